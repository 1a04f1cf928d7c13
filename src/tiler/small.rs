//! A small triangle in view, from its vertices' places on the grid to its pixels, in one go.

use fearless_simd::Simd as Lanes;

use super::scan::{Counts, Taken, take_in_view};
use super::{Outcome, Precision, Seen, Tiler, positions_of};
use crate::depth::DepthSource;
use crate::gradient::frame::{Anchor, Reach};
use crate::gradient::middle;
use crate::gradient::triple::choose_by_x;
use crate::gradient::view::View;
use crate::paint::small::{CornerValues, Small, paint_small, serves};
use crate::patch::MOST;
use crate::polygon::Polygon;
use crate::shade::Shader;
use crate::space::PixelRect;
use crate::target::{DepthBuffer, Target};
use crate::triangle::{InView, Look, look};

/// What became of a polygon that may be a small triangle.
pub(super) enum Sight {
    /// It has been drawn, or there was nothing to draw.
    Done(Outcome),
    /// It is small, and covers pixels, but has something unusual.
    Pixels,
    /// It is none.
    Elsewhere,
}

impl Tiler {
    /// Draws `polygon` if it is a small triangle in view with nothing unusual about it; else finds
    /// what it covers.
    #[expect(clippy::too_many_arguments, reason = "those of `draw`, and what is found")]
    #[inline(always)]
    pub(super) fn draw_small<L: Lanes, V, S, T>(
        &mut self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        found: &mut InView,
        shader: &mut S,
        target: &mut T,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Sight
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        if polygon.len() != 3 || self.clipper.has_user_planes() {
            return Sight::Elsewhere;
        }
        let placed = self.vertex_places(simd, polygon);
        let (cull, rect) = (self.cull, self.viewport.rect());
        let wants = [cull.keeps(false), cull.keeps(true)];
        match look(simd, placed, [rect.x0, rect.y0], wants, window, found) {
            Look::Elsewhere => return Sight::Elsewhere,
            Look::Degenerate => return Sight::Done(Outcome::Degenerate),
            Look::Away => return Sight::Done(Outcome::Backface),
            Look::Nothing => return Sight::Done(Outcome::Drawn),
            Look::Pixels => {}
        }
        if let Some(buffer) = depth.as_deref_mut()
            && buffer.has_bounds()
            && self.is_hidden_small(polygon, placed, found, window, buffer)
        {
            return Sight::Done(Outcome::Hidden);
        }
        match self.paint_usual(simd, polygon, found, shader, target, depth) {
            Some(()) => Sight::Done(Outcome::Drawn),
            None => Sight::Pixels,
        }
    }

    /// Paints the triangle that was `found`, unless there is something unusual about it.
    #[inline(always)]
    fn paint_usual<L: Lanes, V, S, T>(
        &mut self,
        simd: L,
        polygon: &V,
        found: &InView,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Option<()>
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let source: Option<DepthSource> = depth.is_some().then_some(self.depth_test.source);
        if self.precision != Precision::Fast || !serves::<S>(source) || !self.all_perspective {
            return None;
        }
        let given = positions_of(polygon);
        let (given, exponent) = take_in_view(&given)?;
        if exponent != 0 {
            return None;
        }
        let [a, b, c] = choose_by_x([given[0][0], given[1][0], given[2][0]])?;
        // From where they are: a load of what was just stored in halves waits.
        let corners = [polygon.position(a), polygon.position(b), polygon.position(c)];
        let u = middle([found.bounds.x0, found.bounds.x1 - 1]);
        let v = middle([found.bounds.y0, found.bounds.y1 - 1]);
        let anchor = Anchor::new(self.viewport, [u.0, v.0]);
        let reach = Reach { u: u.1, v: v.1 };
        let w = range([given[0][3], given[1][3], given[2][3]]);
        let view = View::new(&anchor, corners, w, reach, self.viewport)?;
        let range = self.viewport.depth_range();
        let z =
            [range.numerator(corners[0]), range.numerator(corners[1]), range.numerator(corners[2])];
        let small = Small {
            patches: &found.patches,
            view: &view,
            anchor: anchor.pixel,
            z,
            attribute_count: polygon.attribute_count(),
        };
        let values = CornerValues { polygon, corners: [a, b, c] };
        let place = self.placement();
        let lanes = &mut self.scratch.attributes;
        let shaded = if found.patches.count() == 1 {
            paint_small::<1, _, _, _, _>(
                simd, &small, &values, &place, lanes, shader, target, depth,
            )
        } else {
            paint_small::<MOST, _, _, _, _>(
                simd, &small, &values, &place, lanes, shader, target, depth,
            )
        }?;
        self.stats.constant_w.count(view.constant);
        self.count_pixels(found.into(), shaded);
        Some(())
    }

    /// Draws the small triangle that was `found`, whatever is unusual about it.
    pub(super) fn draw_unusual<V, S, T>(
        &mut self,
        polygon: &V,
        found: &InView,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        // They may not be what was placed.
        let Some((given, exponent)) = take_in_view(&positions_of(polygon)) else {
            return Outcome::Refused;
        };
        let w = range([given[0][3], given[1][3], given[2][3]]);
        let taken = Taken { exponent, w, seen: found.bounds, whole: true };
        self.scratch.is_set_up = false;
        self.fill(polygon, Seen::Small(found, &given, taken), found.into(), shader, target, depth)
    }
}

impl From<&InView> for Counts {
    #[inline(always)]
    fn from(found: &InView) -> Self {
        Self { pixels: found.pixels, spans: found.spans }
    }
}

/// Least and greatest of three numbers.
#[inline(always)]
fn range([a, b, c]: [f64; 3]) -> [f64; 2] {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    [if c < low { c } else { low }, if c > high { c } else { high }]
}
