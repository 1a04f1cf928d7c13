//! Vertices on the subpixel grid, worked out before any polygon: clip, divide and snap at once,
//! for those within the view volume.
//!
//! Vertices that many polygons share are divided once, and not for each polygon ([`Placed`]); and
//! a small triangle needs no more of them than this to know which pixels it covers. The bits are
//! those of [`clip`](crate::clip) and [`divide`](mod@crate::divide).

use alloc::vec::Vec;

use fearless_simd::{Simd as Level, SimdBase, SimdMask, dispatch, f64x4};

use crate::fixed::Subpixel;
use crate::simd::Simd;
use crate::space::{DepthRange, Viewport};

/// A vertex's place on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PlacedVertex {
    /// From the viewport's corner, with 16 fraction bits; anything if it is not within.
    pub(crate) bits: [i32; 2],
    /// Is it within the view volume?
    pub(crate) within: bool,
}

/// The vertices of a list of positions on the grid of a viewport, for polygons that share them:
/// see [`Polygon::placed`](crate::polygon::Polygon::placed). About 3 ns and 12 bytes a vertex.
#[derive(Clone, Debug)]
pub struct Placed {
    viewport: Viewport,
    constants: Constants,
    vertices: Vec<PlacedVertex>,
}

impl Placed {
    /// No vertices yet, for `viewport`.
    pub fn new(viewport: Viewport) -> Self {
        Self { viewport, constants: Constants::new(viewport), vertices: Vec::new() }
    }

    /// Places all of `positions`; vertex `i` is that of `positions[i]`.
    pub fn set(&mut self, positions: &[[f64; 4]], simd: Simd) {
        self.vertices.clear();
        self.vertices.reserve(positions.len());
        dispatch!(simd.0, simd => {
            for position in positions {
                self.vertices.push(self.constants.place(simd, position));
            }
        });
    }

    /// For which viewport.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Vertex `i`; one that is not within the view for a number that there is not.
    #[inline(always)]
    pub(crate) fn vertex(&self, i: usize) -> PlacedVertex {
        self.vertices.get(i).copied().unwrap_or_default()
    }
}

/// What is the same for all vertices of a viewport: for x, y, and two lanes that are not used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Times w: the least x, y, z that are within the volume; and w times 0.
    lowest: [f64; 4],
    half: [f64; 4],
    centre: [f64; 4],
    /// Steps of the grid in a pixel; what each is in 16 fraction bits.
    steps: f64,
    step: f64,
    /// The viewport's corner, with 16 fraction bits.
    corner: [f64; 4],
}

/// The sum with it has no room for a fraction, and its low bits are the nearest whole number.
const WHOLE: f64 = 6_755_399_441_055_744.0;

impl Constants {
    pub(crate) fn new(viewport: Viewport) -> Self {
        let ([half_w, half_h], [centre_x, centre_y]) = (viewport.half_size(), viewport.centre());
        let near = match viewport.depth_range() {
            DepthRange::ZeroToOne => 0.0,
            DepthRange::MinusOneToOne => -1.0,
        };
        let rect = viewport.rect();
        let steps = f64::from(viewport.grid().steps_per_pixel());
        let pixel = f64::from(1_u32 << Subpixel::FRACTION_BITS);
        Self {
            lowest: [-1.0, -1.0, near, 0.0],
            // Turned round: y points down.
            half: [half_w, -half_h, 0.0, 0.0],
            centre: [centre_x, centre_y, 0.0, 0.0],
            steps,
            step: pixel / steps,
            corner: [f64::from(rect.x0) * pixel, f64::from(rect.y0) * pixel, 0.0, 0.0],
        }
    }

    /// Where `position` lies.
    #[inline(always)]
    pub(crate) fn place<S: Level>(&self, simd: S, position: &[f64; 4]) -> PlacedVertex {
        let w = position[3];
        let (p, ws) = (f64x4::load_array_ref(simd, position), f64x4::splat(simd, w));
        // What is no number is not within.
        let inside = p.simd_ge(f64x4::load_array_ref(simd, &self.lowest) * ws) & p.simd_le(ws);
        let within = inside.to_bitmask() == 0b1111 && w > 0.0;
        let framebuffer = p / ws * f64x4::load_array_ref(simd, &self.half)
            + f64x4::load_array_ref(simd, &self.centre);
        // Within the view volume nothing is beyond the grid's reach.
        let whole = f64x4::splat(simd, WHOLE);
        let snapped = (framebuffer * f64x4::splat(simd, self.steps) + whole - whole)
            * f64x4::splat(simd, self.step);
        let sums: [f64; 4] = (snapped - f64x4::load_array_ref(simd, &self.corner) + whole).into();
        PlacedVertex { bits: [low_half(sums[0]), low_half(sums[1])], within }
    }
}

/// The whole number that `sum` is with [`WHOLE`].
#[expect(clippy::cast_possible_truncation, reason = "the low half")]
#[inline(always)]
fn low_half(sum: f64) -> i32 {
    (sum.to_bits() as u32).cast_signed()
}
