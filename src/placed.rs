//! Vertices on the subpixel grid, worked out before any polygon: clip, divide and snap at once,
//! for those within the view volume.
//!
//! Vertices that many polygons share are divided once, and not for each polygon ([`Placed`]); and
//! a small triangle needs no more of them than this to know which pixels it covers. The bits are
//! those of [`clip`](crate::clip) and [`divide`](mod@crate::divide).

use alloc::vec::Vec;
use core::ops::Range;

use fearless_simd::{Simd as Level, SimdBase, SimdMask, dispatch, f64x4};
use glam::DMat4;

use crate::fetch::fetch;
use crate::fixed::{Subpixel, WHOLE, whole_of};
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

    /// Transforms `points` by `matrix` into `clip`, and places them: vertex `i` is that of
    /// `points[i]`. The clip positions are those of [`transform`](crate::camera::transform). With
    /// `parallel` (and the feature of that name) all threads of the current pool of `rayon` do it.
    pub fn transform(
        &mut self,
        matrix: DMat4,
        points: &[[f64; 3]],
        clip: &mut Vec<[f64; 4]>,
        simd: Simd,
        parallel: bool,
    ) {
        let all = core::iter::once(0..points.len());
        self.transform_some(matrix, points, all, clip, simd, parallel);
    }

    /// The same of the points in `ranges`, each of which lies within the list (else it is left out);
    /// the others are where they were last, or at no place.
    pub fn transform_some(
        &mut self,
        matrix: DMat4,
        points: &[[f64; 3]],
        ranges: impl IntoIterator<Item = Range<usize>>,
        clip: &mut Vec<[f64; 4]>,
        simd: Simd,
        parallel: bool,
    ) {
        clip.resize(points.len(), [0.0; 4]);
        self.vertices.resize(points.len(), PlacedVertex::default());
        let columns = matrix.to_cols_array_2d();
        for range in ranges {
            if let (Some(points), Some(clip), Some(vertices)) = (
                points.get(range.clone()),
                clip.get_mut(range.clone()),
                self.vertices.get_mut(range),
            ) {
                self.constants.transform(&columns, points, clip, vertices, simd, parallel);
            }
        }
    }

    /// For which viewport.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Asks for the memory of vertex `i`, if there is one.
    #[inline(always)]
    pub(crate) fn fetch(&self, i: usize) {
        fetch(&self.vertices, i);
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

/// So many vertices are worth a thread.
#[cfg(feature = "parallel")]
const MOST_AT_ONCE: usize = 1 << 13;

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

    /// See [`Placed::transform`]; all lists are as long.
    fn transform(
        &self,
        columns: &[[f64; 4]; 4],
        points: &[[f64; 3]],
        clip: &mut [[f64; 4]],
        vertices: &mut [PlacedVertex],
        simd: Simd,
        parallel: bool,
    ) {
        #[cfg(feature = "parallel")]
        if parallel && points.len() > MOST_AT_ONCE {
            let half = points.len() / 2;
            let (points, other_points) = points.split_at(half);
            let (clip, other_clip) = clip.split_at_mut(half);
            let (vertices, other_vertices) = vertices.split_at_mut(half);
            rayon::join(
                || self.transform(columns, points, clip, vertices, simd, true),
                || self.transform(columns, other_points, other_clip, other_vertices, simd, true),
            );
            return;
        }
        let _ = parallel;
        let [x_axis, y_axis, z_axis, origin] = columns;
        dispatch!(simd.0, simd => {
            let x_axis = f64x4::load_array_ref(simd, x_axis);
            let y_axis = f64x4::load_array_ref(simd, y_axis);
            let z_axis = f64x4::load_array_ref(simd, z_axis);
            let origin = f64x4::load_array_ref(simd, origin);
            for ((point, clip), vertex) in points.iter().zip(clip).zip(vertices) {
                let [x, y, z] = point;
                let position = x_axis * f64x4::splat(simd, *x)
                    + y_axis * f64x4::splat(simd, *y)
                    + z_axis * f64x4::splat(simd, *z)
                    + origin;
                position.store_array(clip);
                *vertex = self.place(simd, clip);
            }
        });
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
        PlacedVertex { bits: [whole_of(sums[0]), whole_of(sums[1])], within }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::camera::transform;

    #[test]
    fn placed_positions_are_those_of_the_camera() {
        let numbers: [f64; 16] = core::array::from_fn(|i| libm::sin(i as f64 * 1.7) * 3.0 + 0.1);
        let matrix = DMat4::from_cols_array(&numbers);
        let point = |i: usize| [0, 1, 2].map(|k| libm::cos((3 * i + k) as f64));
        let points: Vec<[f64; 3]> = (0..20_000).map(point).collect();
        let viewport = Viewport::new(0, 0, 640, 480).expect("small");
        let expected: Vec<_> =
            points.iter().map(|p| transform(matrix, DVec3::from_array(*p))).collect();
        let mut one_by_one = Placed::new(viewport);
        one_by_one.set(&expected, Simd::scalar());
        assert!(one_by_one.vertices.iter().any(|vertex| vertex.within));
        for (_, simd) in Simd::all() {
            for parallel in [false, true] {
                let (mut placed, mut clip) = (Placed::new(viewport), Vec::new());
                placed.transform(matrix, &points, &mut clip, simd, parallel);
                assert_eq!(clip, expected);
                assert_eq!(placed.vertices, one_by_one.vertices);
                // Of some, the others stay.
                clip.fill([7.0; 4]);
                let ranges = [3..9, 9..9, 10..19_990, 19_995..30_000];
                placed.transform_some(matrix, &points, ranges, &mut clip, simd, parallel);
                for (i, (clip, expected)) in clip.iter().zip(&expected).enumerate() {
                    let is_in = (3..19_990).contains(&i) && i != 9;
                    assert_eq!(*clip, if is_in { *expected } else { [7.0; 4] });
                }
                assert_eq!(placed.vertices, one_by_one.vertices);
            }
        }
    }
}
