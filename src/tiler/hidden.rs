//! Whole polygons that bounds of the stored depths, or what others of a list hide, show to be hidden, as
//! far as their corners tell: before any set-up.

use fearless_simd::Simd;

use super::{Cull, Scratch, Tiler};
use crate::depth::{DepthSource, DepthTest, Occluders};
use crate::fixed::{Subpixel, power_of_two};
use crate::gradient::enclosure::{outward, widened, within};
use crate::gradient::frame::Plane;
use crate::gradient::nearest_f32;
use crate::gradient::small::{SmallCorners, SmallSetups};
use crate::hidden::Area;
use crate::in_view::{BEYOND, THICK};
use crate::number::{EIGHT, Lanes, Number, range_of};
use crate::polygon::Polygon;
use crate::space::{PixelRect, Viewport};
use crate::target::DepthBuffer;

/// Bounds that any depth keeps.
const ANY_DEPTH: [f32; 2] = [0.0, f32::INFINITY];

/// Corners of a polygon with all w > 0 that nothing clips: positions, times 2^-`exponent`, and
/// places on the grid.
struct Corners<'a, const N: usize> {
    positions: &'a [[f64; 4]; N],
    bits: [[i32; 2]; N],
    exponent: i32,
}

impl<const N: usize> Corners<'_, N> {
    /// What the depths of the pixels lie between: of a triangle or a quadrilateral. docs/precision.md,
    /// "What is hidden", has the proof.
    #[inline(always)]
    fn depths(&self, source: DepthSource, viewport: Viewport) -> [f32; 2] {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut depths = [0.0; N];
        for (depth, position) in depths.iter_mut().zip(self.positions) {
            *depth = right_depth(*position, source, viewport);
            low = if *depth < low { *depth } else { low };
            high = if *depth > high { *depth } else { high };
        }
        let beyond = match source {
            DepthSource::Z => self.beyond(&depths, high - low, viewport.grid().snap_reach()),
            // It is clamped to the range of the vertices.
            DepthSource::InvW => {
                let scale = power_of_two(-self.exponent);
                (low, high) = (low * scale, high * scale);
                0.0
            }
        };
        within(outward([low - beyond, high + beyond]), ANY_DEPTH)
    }

    /// How far a pixel's depth may lie beyond those of the corners, which differ by `difference`;
    /// infinite where that is not known.
    #[inline(always)]
    fn beyond(&self, depths: &[f64; N], difference: f64, reach: f64) -> f64 {
        let pixels = |bits: i32| f64::from(bits) / f64::from(1 << Subpixel::FRACTION_BITS);
        let place = |i: usize| self.bits[i].map(pixels);
        let [x, y] = place(0);
        let from_first = |i: usize| {
            let [px, py] = place(i);
            [px - x, py - y]
        };
        let (mut low, mut high) = ([0.0; 2], [0.0; 2]);
        for i in 1..N {
            let p = from_first(i);
            for k in 0..2 {
                low[k] = if p[k] < low[k] { p[k] } else { low[k] };
                high[k] = if p[k] > high[k] { p[k] } else { high[k] };
            }
        }
        let size = high[0] - low[0] + high[1] - low[1] + 2.0 * reach;
        let cross = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| ax * by - ay * bx;
        // Twice the areas of the triangles without one corner.
        let (least_area, defect) = match N {
            3 => (cross(from_first(1), from_first(2)).abs(), 0.0),
            4 => {
                let [p, q, r] = [from_first(1), from_first(2), from_first(3)];
                let [a, b, c] = [cross(q, r), cross(p, r), cross(p, q)];
                let first = a - b + c;
                let defect = b * (depths[2] - depths[0])
                    - a * (depths[1] - depths[0])
                    - c * (depths[3] - depths[0]);
                let mut least = first.abs();
                for area in [a, b, c] {
                    least = if area.abs() < least { area.abs() } else { least };
                }
                (least, defect.abs())
            }
            _ => return f64::INFINITY,
        };
        if least_area >= THICK * reach * size {
            defect / least_area * (1.0 + BEYOND) + difference * BEYOND
        } else {
            f64::INFINITY
        }
    }
}

/// The depth at a corner.
#[inline(always)]
pub(super) fn right_depth<F: Number>(
    position: [F; 4],
    source: DepthSource,
    viewport: Viewport,
) -> F {
    match source {
        DepthSource::InvW => position[3].reciprocal(),
        DepthSource::Z => viewport.depth_range().numerator(position) / position[3],
    }
}

/// What the depths of small polygons lie between, as far as their corners tell: [`widened`].
#[derive(Debug, Default)]
pub(super) struct SmallDepths([Lanes; 2]);

impl SmallDepths {
    #[inline(always)]
    pub(super) fn set<F: Number>(
        &mut self,
        level: F::Level,
        corners: &SmallCorners,
        source: DepthSource,
        viewport: Viewport,
    ) {
        let [a, b, c] = corners.load::<F>(level);
        let a = right_depth(a, source, viewport);
        let (b, c) = (right_depth(b, source, viewport), right_depth(c, source, viewport));
        let (low, high) = (a.lesser(b).lesser(c), a.greater(b).greater(c));
        let beyond = match source {
            DepthSource::Z => (high - low) * F::load(level, &corners.beyond),
            // It is clamped to the range of the vertices.
            DepthSource::InvW => low.like(0.0),
        };
        self.store([low - beyond, high + beyond]);
    }

    /// The same of small quadrilaterals that are set up, all of whose depths are z/w. What is not usual among
    /// them has anything.
    #[inline(always)]
    pub(super) fn set_quads<F: Number>(
        &mut self,
        level: F::Level,
        corners: &SmallCorners,
        setups: &SmallSetups,
        viewport: Viewport,
    ) {
        let [a, b, c] = corners.load::<F>(level);
        let projection = corners.projection::<F>(level, viewport);
        let [x, y, w] = projection.project(corners.load_fourth::<F>(level));
        let (z, fourth) = (DepthSource::Z, setups.depth_at(level, [x / w, y / w]));
        let [low, high] = range_of(&[
            right_depth(a, z, viewport),
            right_depth(b, z, viewport),
            right_depth(c, z, viewport),
            fourth,
        ]);
        // The triple's triangle: its area, and no less than the sum of its box's sides.
        let det = Plane::new(&projection, [a, b, c]).det;
        let size = (F::load(level, &corners.reach) + 2.0) * 4.0;
        let least = size * (THICK * viewport.grid().snap_reach()) * (a[3] * b[3] * c[3]);
        let beyond = F::select(least.le(det.abs()), (high - low) * BEYOND, low.like(f64::INFINITY));
        self.store([low - beyond, high + beyond]);
    }

    #[inline(always)]
    fn store<F: Number>(&mut self, bounds: [F; 2]) {
        let [low, high] = widened(bounds);
        low.store(&mut self.0[0]);
        high.store(&mut self.0[1]);
    }

    /// Those of `lane`.
    #[inline(always)]
    pub(super) fn of(&self, lane: usize) -> [f32; 2] {
        let ([low, high], lane) = (&self.0, lane % EIGHT);
        within([nearest_f32(low[lane]), nearest_f32(high[lane])], ANY_DEPTH)
    }
}

impl Tiler {
    /// Is all that was taken surely hidden, as far as its corners tell?
    pub(super) fn is_hidden(
        &self,
        window: PixelRect,
        buffer: Option<&mut DepthBuffer<'_>>,
    ) -> bool {
        let Scratch { taken, given, screen, .. } = &self.scratch;
        let Some(buffer) = buffer.filter(|buffer| buffer.has_bounds()) else { return false };
        let Some(area) = Area::new(taken.seen.intersect(window), self.origin) else { return false };
        // Those that the division left out named no place.
        if !taken.whole || screen.len() != given.len() {
            return false;
        }
        let bits = |i: usize| screen[i].snapped.map(Subpixel::bits);
        let (source, viewport, exponent) = (self.depth_test.source, self.viewport, taken.exponent);
        let depths = match *given.as_slice() {
            [a, b, c] => {
                let bits = [bits(0), bits(1), bits(2)];
                Corners { positions: &[a, b, c], bits, exponent }.depths(source, viewport)
            }
            [a, b, c, d] => {
                let bits = [bits(0), bits(1), bits(2), bits(3)];
                Corners { positions: &[a, b, c, d], bits, exponent }.depths(source, viewport)
            }
            _ => return false,
        };
        buffer.hides(area, depths, self.depth_test.compare)
    }

    /// Is `polygon` a quadrilateral within the view that `buffer` surely hides? Then it need not even be
    /// divided.
    #[inline(always)]
    pub(super) fn is_hidden_in_view<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        buffer: Option<&mut DepthBuffer<'_>>,
    ) -> bool {
        let DepthTest { compare, source, .. } = self.depth_test;
        // Faces that are left out for the way they face count as that, hidden or not.
        let looks = self.hides && self.cull == Cull::None;
        let Some(buffer) = buffer.filter(|buffer| looks && buffer.has_bounds()) else {
            return false;
        };
        let Some((bits, bounds)) = self.quad_in_view(simd, polygon) else { return false };
        let Some(area) = Area::new(bounds.intersect(window), self.origin) else { return false };
        let first = right_depth(polygon.position(0), source, self.viewport);
        buffer.may_hide(area, [nearest_f32(first); 2], compare)
            && buffer.hides(area, self.quad_depths(polygon, bits), compare)
    }

    /// The same, by what others of the list hide.
    #[inline(always)]
    pub(super) fn is_occluded<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        occluders: &Occluders,
    ) -> bool {
        let Some((bits, bounds)) = self.quad_in_view(simd, polygon) else { return false };
        let Some(area) = Area::new(bounds.intersect(window), self.origin) else { return false };
        let first = right_depth(polygon.position(0), self.depth_test.source, self.viewport);
        let nearer = usize::from(self.depth_test.compare.raises());
        area.is_first_behind(occluders, nearest_f32(first))
            && area.is_behind(occluders, self.quad_depths(polygon, bits)[nearer])
    }

    /// The corners of a quadrilateral within the view, and the pixels that it may cover.
    #[inline(always)]
    fn quad_in_view<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
    ) -> Option<([[i32; 2]; 4], PixelRect)> {
        if polygon.len() != 4 {
            return None;
        }
        let [a, b, c, d] = self.vertex_places(simd, polygon);
        if !(a.within & b.within & c.within & d.within) {
            return None;
        }
        let (mut low, mut high) = (a.bits, a.bits);
        for corner in [b, c, d] {
            let [x, y] = corner.bits;
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        Some(([a.bits, b.bits, c.bits, d.bits], self.bounds_between(low, high)))
    }

    /// What the depths of a quadrilateral within the view lie between.
    #[inline(always)]
    fn quad_depths<V: Polygon + ?Sized>(&self, polygon: &V, bits: [[i32; 2]; 4]) -> [f32; 2] {
        let positions =
            &[polygon.position(0), polygon.position(1), polygon.position(2), polygon.position(3)];
        let corners = Corners { positions, bits, exponent: 0 };
        corners.depths(self.depth_test.source, self.viewport)
    }
}
