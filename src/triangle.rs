//! Triangles within the view volume: from positions to covered pixels in one go.
//!
//! Most polygons are small triangles that nothing clips. For them this does what clip, divide,
//! edges and spans do for any polygon, and to the same bits: a vertex is a vector, and so is
//! [`Patches`]' part of the framebuffer. What is not such a triangle is left to those stages.

use fearless_simd::{Level, Simd, SimdBase, SimdMask, dispatch, f64x4};

use crate::fixed::{Subpixel, power_of_two};
use crate::patch::Patches;
use crate::space::{DepthRange, PixelRect, Viewport};

/// What is the same for all triangles of a viewport: x, y, and two lanes that are not used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// Times w: the least x, y, z that are within the volume; and w times 0.
    lowest: [f64; 4],
    half: [f64; 4],
    centre: [f64; 4],
    /// Steps of the grid in a pixel; what each is in 16 fraction bits.
    steps: f64,
    step: f64,
    /// The viewport's corner, with 16 fraction bits, and in pixels.
    corner: [f64; 4],
    corner_pixel: [i32; 2],
}

/// A triangle within the view volume that covers some pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct InView {
    pub(crate) patches: Patches,
    /// Pixels of the framebuffer that it may cover.
    pub(crate) bounds: PixelRect,
    /// Least and greatest w.
    pub(crate) w: [f64; 2],
    pub(crate) pixels: u64,
    pub(crate) spans: u64,
}

/// What became of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// It is not small, or not within the view volume.
    Elsewhere,
    /// No area, once snapped.
    Degenerate,
    /// It faces away.
    Away,
    /// No pixel's centre is covered, or none in the window.
    Nothing,
    /// [`InView`] tells.
    Pixels,
}

/// The sum with it has no room for a fraction, and its low bits are the nearest whole number.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// The exponents of w between which no product of a few numbers leaves the range of `f64`.
const MODERATE: i32 = 60;

impl View {
    pub(crate) fn new(viewport: Viewport) -> Self {
        let ([half_w, half_h], [centre_x, centre_y]) = (viewport.half_size(), viewport.centre());
        let near = match viewport.depth_range() {
            DepthRange::ZeroToOne => 0.0,
            DepthRange::MinusOneToOne => -1.0,
        };
        let rect = viewport.rect();
        let steps = f64::from(viewport.grid().steps_per_pixel());
        let fixed = |pixel: i32| f64::from(pixel) * PIXEL;
        Self {
            lowest: [-1.0, -1.0, near, 0.0],
            // Turned round: y points down.
            half: [half_w, -half_h, 0.0, 0.0],
            centre: [centre_x, centre_y, 0.0, 0.0],
            steps,
            step: PIXEL / steps,
            corner: [fixed(rect.x0), fixed(rect.y0), 0.0, 0.0],
            corner_pixel: [rect.x0, rect.y0],
        }
    }

    /// Looks at the triangle of `positions`, and fills `found` in if it covers any pixel of
    /// `window`. It faces away unless `wants` says otherwise of its side, the front or not.
    #[inline(always)]
    pub(crate) fn look(
        &self,
        level: Level,
        positions: &[[f64; 4]; 3],
        wants: impl Fn(bool) -> bool,
        window: PixelRect,
        found: &mut InView,
    ) -> Sight {
        dispatch!(level, simd => self.look_on(simd, positions, &wants, window, found))
    }

    #[inline(always)]
    fn look_on<S: Simd>(
        &self,
        simd: S,
        positions: &[[f64; 4]; 3],
        wants: &impl Fn(bool) -> bool,
        window: PixelRect,
        found: &mut InView,
    ) -> Sight {
        let load = |lanes: &[f64; 4]| f64x4::load_array_ref(simd, lanes);
        let splat = |value: f64| f64x4::splat(simd, value);
        let [a, b, c] = positions;
        let (wa, wb, wc) = (splat(a[3]), splat(b[3]), splat(c[3]));
        let (pa, pb, pc) = (load(a), load(b), load(c));
        let lowest = load(&self.lowest);
        // No number fails.
        let a_in = pa.simd_ge(lowest * wa) & pa.simd_le(wa);
        let b_in = pb.simd_ge(lowest * wb) & pb.simd_le(wb);
        let c_in = pc.simd_ge(lowest * wc) & pc.simd_le(wc);
        let [w_low, w_high] = ends([a[3], b[3], c[3]]);
        let moderate = w_low >= power_of_two(-MODERATE) && w_high <= power_of_two(MODERATE);
        if (a_in & b_in & c_in).to_bitmask() != 0b1111 || !moderate {
            return Sight::Elsewhere;
        }

        // Divide, viewport, snap: as `divide` does, but that nothing can be out of reach.
        let (half, centre, corner) = (load(&self.half), load(&self.centre), load(&self.corner));
        let (steps, step, whole) = (splat(self.steps), splat(self.step), splat(WHOLE));
        let snap = |framebuffer: f64x4<S>| (framebuffer * steps + whole - whole) * step - corner;
        let (sa, sb, sc) = (
            snap(pa / wa * half + centre),
            snap(pb / wb * half + centre),
            snap(pc / wc * half + centre),
        );

        // The bounding box, and which way it faces.
        let (low, high) = (lesser(lesser(sa, sb), sc), greater(greater(sa, sb), sc));
        let first = |end: f64x4<S>| {
            let bits: [f64; 4] = (end + whole).into();
            [first_centre(bits[0]), first_centre(bits[1])]
        };
        let ([x0, y0], [x1, y1]) = (first(low), first(high));
        let size: [f64; 4] = (high - low).into();
        if size[0].max(size[1]) > LARGEST {
            return Sight::Elsewhere;
        }
        let (ab, ac): ([f64; 4], [f64; 4]) = ((sb - sa).into(), (sc - sa).into());
        // Whole numbers below 2^53: exact.
        let area = ab[1] * ac[0] - ab[0] * ac[1];
        if area == 0.0 {
            return Sight::Degenerate;
        }
        let front = area > 0.0;
        if !wants(front) {
            return Sight::Away;
        }
        if x0 >= x1 || y0 >= y1 {
            return Sight::Nothing;
        }
        let [corner_x, corner_y] = self.corner_pixel;
        let bounds = PixelRect {
            x0: x0.wrapping_add(corner_x),
            y0: y0.wrapping_add(corner_y),
            x1: x1.wrapping_add(corner_x),
            y1: y1.wrapping_add(corner_y),
        };
        let Some(mut patches) = Patches::of(bounds) else { return Sight::Elsewhere };
        let centre = [x0, y0].map(|c| f64::from(c) * PIXEL + PIXEL / 2.0);
        let centre = load(&[centre[0], centre[1], 0.0, 0.0]);
        let from_centre = |s: f64x4<S>| {
            let [x, y, ..]: [f64; 4] = (s - centre).into();
            [x, y]
        };
        let vertices = [from_centre(sa), from_centre(sb), from_centre(sc)];
        let (pixels, spans) = patches.cover(simd, vertices, front, window);
        if pixels == 0 {
            return Sight::Nothing;
        }
        *found = InView { patches, bounds, w: [w_low, w_high], pixels, spans };
        Sight::Pixels
    }
}

/// A pixel's side, with 16 fraction bits.
const PIXEL: f64 = (1 << Subpixel::FRACTION_BITS) as f64;

/// The longest side of a bounding box for which products of two sides are exact, and to spare.
const LARGEST: f64 = 1024.0 * PIXEL;

/// [`Subpixel::first_centre`] of the whole number that `sum` is with [`WHOLE`].
#[expect(clippy::cast_possible_truncation, reason = "the low half")]
#[inline(always)]
fn first_centre(sum: f64) -> i32 {
    let whole = (sum.to_bits() as u32).cast_signed();
    Subpixel::first_centre_of(whole)
}

#[inline(always)]
fn ends([a, b, c]: [f64; 3]) -> [f64; 2] {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    [if c < low { c } else { low }, if c > high { c } else { high }]
}

/// Of numbers that are no NaN; of zeros, either.
#[inline(always)]
fn lesser<S: Simd>(a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
    a.min(b)
}

/// Of numbers that are no NaN; of zeros, either.
#[inline(always)]
fn greater<S: Simd>(a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
    a.max(b)
}
