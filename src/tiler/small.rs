//! Small triangles and quadrilaterals in view, from their vertices' places on the grid to their pixels: some
//! are looked at and set up together, and then drawn one after the other, in order.

use core::ops::Range;

use fearless_simd::Simd;

use super::bunch::{Asked, BUNCH, Bunch, Several, count_far, place_in_lane, place_quads};
use super::scan::{Counts, Taken, take_in_view};
use super::{Outcome, Precision, Seen, Tiler, positions_of};
use crate::depth::DepthTest;
use crate::hidden::Area;
use crate::in_view::{InView, Scope, Sight};
use crate::number::{EIGHT, range_of};
use crate::paint::small::{Small, paint, serves};
use crate::polygon::Polygon;
use crate::shade::Shader;
use crate::space::PixelRect;
use crate::target::{DepthBuffer, Target};

/// What is to be done with a polygon that was looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Next {
    /// Nothing more.
    Done(Outcome),
    /// It is to be drawn by its spans.
    Spans,
    /// It is a small triangle: to be painted, if it was set up in this lane and is usual.
    Small(Option<usize>),
    /// It is a small quadrilateral, which was set up in this lane.
    Quad(usize),
}

impl Tiler {
    /// Looks at the first `count` polygons of `several`, at most [`BUNCH`], so that they can be drawn.
    #[inline(always)]
    pub(crate) fn look_at<const LANES: usize, L: Simd, P: Several>(
        &mut self,
        simd: L,
        several: &P,
        count: usize,
        window: PixelRect,
    ) {
        let scope = self.scope(window);
        self.bunch.start(count);
        let mut first = 0;
        while first < self.bunch.count {
            let end = self.bunch.count.min(first + LANES);
            self.look_from_outside::<LANES, _, _>(simd, several, first..end, window);
            let Bunch { sights, found, looks, far, last_small_row, .. } = &mut self.bunch;
            for k in first..end {
                let found = &mut found[k % BUNCH];
                sights[k % BUNCH] = match looks.sight(k - first, &scope, found) {
                    Sight::Pixels => {
                        *far += count_far(last_small_row, found.bounds.y0);
                        looks.cover(simd, k - first, &scope, found)
                    }
                    sight => sight,
                };
            }
            if self.bunch.quad_looks.any() {
                self.bunch.look_closely_at_quads(simd, first..end, &scope);
            }
            first = end;
        }
    }

    /// Clears what has not been cleared in the rows of the small polygons that have been looked at.
    #[inline(always)]
    pub(crate) fn clear_under_small<T: Target>(
        &self,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) {
        if let Some(buffer) = depth.filter(|buffer| buffer.may_be_unclear([0, u32::MAX - 1])) {
            let Bunch { sights, found, count, .. } = &self.bunch;
            let place = self.placement();
            for (sight, found) in sights.iter().zip(found).take(*count) {
                let rows = place.rows(found.bounds);
                let is_small = matches!(sight, Sight::Pixels | Sight::PixelsOfQuad);
                if is_small && buffer.may_be_unclear(rows) {
                    buffer.clear_rows(target, rows);
                }
            }
        }
    }

    /// Looks at as many polygons as there are lanes, but not at their pixels.
    #[inline(always)]
    pub(crate) fn look_from_outside<const LANES: usize, L: Simd, P: Several>(
        &mut self,
        simd: L,
        several: &P,
        polygons: Range<usize>,
        window: PixelRect,
    ) {
        let (scope, viewport) = (&self.scope(window), self.viewport);
        let has_planes = self.clipper.has_user_planes();
        let Self { bunch: Bunch { places, quad_places, .. }, place_constants, .. } = self;
        (places.within, quad_places.within) = (0, 0);
        let mut others = false;
        for (lane, k) in polygons.clone().enumerate() {
            let (lane, polygon) = (lane % EIGHT, several.polygon(k));
            if polygon.len() != 3 || has_planes {
                others = true;
                continue;
            }
            place_in_lane(simd, place_constants, viewport, &polygon, lane, places);
        }
        if others && !has_planes {
            place_quads(simd, place_constants, viewport, several, polygons, quad_places);
        }
        self.bunch.look::<LANES>(self.simd.0, scope);
    }

    /// Where small polygons are to be drawn.
    #[inline(always)]
    pub(super) fn scope(&self, window: PixelRect) -> Scope {
        let (rect, cull) = (self.viewport.rect(), self.cull);
        Scope {
            corner: [rect.x0, rect.y0],
            window,
            wants: [cull.keeps(false), cull.keeps(true)],
            snap_reach: self.viewport.grid().snap_reach(),
        }
    }

    /// What shaders of the type `S` ask for, with a depth test or without.
    #[inline(always)]
    pub(crate) fn asked<S: Shader>(&self, depth: Option<&DepthBuffer<'_>>) -> Asked {
        let source = depth.is_some().then_some(self.depth_test.source);
        Asked {
            depths: depth.is_some_and(DepthBuffer::has_bounds),
            setups: self.all_perspective && serves::<S>(source),
            most: S::INPUTS.attributes,
            strict: self.precision == Precision::Exact,
        }
    }

    /// What is next for polygon `k` of `several`, all of which have been looked at; those before it have
    /// been drawn.
    #[inline(always)]
    pub(crate) fn next<const LANES: usize, L: Simd, P: Several>(
        &mut self,
        simd: L,
        several: &P,
        k: usize,
        window: PixelRect,
        asked: Asked,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Next {
        match self.bunch.sights[k % BUNCH] {
            Sight::Degenerate => Next::Done(Outcome::Degenerate),
            Sight::Away => Next::Done(Outcome::Backface),
            Sight::Nothing => Next::Done(Outcome::Drawn),
            Sight::Hidden => Next::Done(Outcome::Hidden),
            Sight::Elsewhere => self.next_spans(simd, &several.polygon(k), window, depth),
            Sight::PixelsOfQuad => {
                self.next_quad::<LANES, _, _>(simd, several, k, window, asked, depth)
            }
            Sight::Pixels => self.next_small::<LANES, _>(several, k, window, asked, depth),
        }
    }

    /// The same of a polygon that is drawn by its spans, unless it is hidden.
    #[inline(always)]
    fn next_spans<L: Simd, V: Polygon + ?Sized>(
        &self,
        simd: L,
        polygon: &V,
        window: PixelRect,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Next {
        if self.is_hidden_in_view(simd, polygon, window, depth) {
            Next::Done(Outcome::Hidden)
        } else {
            Next::Spans
        }
    }

    /// The same of a small quadrilateral that covers pixels; out of line.
    #[inline(never)]
    fn next_quad<const LANES: usize, L: Simd, P: Several>(
        &mut self,
        simd: L,
        several: &P,
        k: usize,
        window: PixelRect,
        asked: Asked,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Next {
        simd.vectorize(
            #[inline(always)]
            || {
                if !asked.setups {
                    return self.next_spans(simd, &several.polygon(k), window, depth);
                }
                if self.bunch.quads_ready.are_drawn() {
                    let bounds = depth.as_deref_mut();
                    self.leave_out_hidden::<LANES, _, _>(simd, several, k, window, bounds);
                    if self.bunch.sights[k % BUNCH] == Sight::Hidden {
                        return Next::Done(Outcome::Hidden);
                    }
                    let made_of = (self.depth_test.source, self.viewport);
                    self.bunch.set_up::<LANES, 4, _>(self.simd.0, several, k, asked, made_of);
                }
                let ready = &mut self.bunch.quads_ready;
                let lane = ready.next_lane();
                if !ready.setups.is_usual(lane) {
                    return Next::Spans;
                }
                if asked.depths && self.hides_or_takes::<4>(k, lane, window, depth) {
                    return Next::Done(Outcome::Hidden);
                }
                Next::Quad(lane)
            },
        )
    }

    /// Finds the next quadrilaterals from `first` on that are not hidden, as many as there are lanes: of those
    /// that are nothing need be set up.
    #[inline(always)]
    fn leave_out_hidden<const LANES: usize, L: Simd, P: Several>(
        &mut self,
        simd: L,
        several: &P,
        first: usize,
        window: PixelRect,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) {
        let mut left = LANES;
        for k in first..self.bunch.count {
            if left == 0 {
                break;
            }
            if self.bunch.sights[k % BUNCH] != Sight::PixelsOfQuad {
                continue;
            }
            let depth = depth.as_deref_mut();
            if self.is_hidden_in_view(simd, &several.polygon(k), window, depth) {
                self.bunch.sights[k % BUNCH] = Sight::Hidden;
            } else {
                left -= 1;
            }
        }
    }

    /// Do bounds of the stored depths hide polygon `k`, which was set up in `lane`? Else they take it in.
    #[inline(always)]
    fn hides_or_takes<const N: usize>(
        &self,
        k: usize,
        lane: usize,
        window: PixelRect,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> bool {
        let DepthTest { compare, write, .. } = self.depth_test;
        let found = &self.bunch.found[k % BUNCH];
        let (Some(buffer), Some(area)) =
            (depth, Area::new(found.bounds.intersect(window), self.origin))
        else {
            return false;
        };
        let (hides, count) = (self.hides, write.then_some(found.pixels));
        let depths = self.bunch.ready::<N>().depths.of(lane);
        buffer.hides_or_takes(area, depths, compare, hides, count)
    }

    /// The same of a small triangle that covers pixels.
    #[inline(always)]
    fn next_small<const LANES: usize, P: Several>(
        &mut self,
        several: &P,
        k: usize,
        window: PixelRect,
        asked: Asked,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Next {
        if !(asked.depths || asked.setups) {
            return Next::Small(None);
        }
        if self.bunch.triangles_ready.are_drawn() {
            let made_of = (self.depth_test.source, self.viewport);
            self.bunch.set_up::<LANES, 3, _>(self.simd.0, several, k, asked, made_of);
        }
        let ready = &mut self.bunch.triangles_ready;
        let lane = ready.next_lane();
        let usual = asked.setups && ready.setups.is_usual(lane);
        if asked.depths && self.hides_or_takes::<3>(k, lane, window, depth) {
            return Next::Done(Outcome::Hidden);
        }
        Next::Small(usual.then_some(lane))
    }

    /// Does what is `next` for polygon `k` of `several`, all of which have been looked at.
    #[expect(clippy::too_many_arguments, reason = "those of `draw`, and which")]
    #[inline(always)]
    pub(crate) fn follow<L: Simd, P, S, T>(
        &mut self,
        simd: L,
        next: Next,
        several: &P,
        k: usize,
        window: PixelRect,
        shader: &mut S,
        target: &mut T,
        mut depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        P: Several,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let Bunch { found, triangles_ready, quads_ready, .. } = &self.bunch;
        let (lane, setups) = match next {
            Next::Done(outcome) => return outcome,
            Next::Spans => {
                return self.draw_any(&several.polygon(k), window, shader, target, depth);
            }
            Next::Small(lane) => (lane, &triangles_ready.setups),
            Next::Quad(lane) => (Some(lane), &quads_ready.setups),
        };
        let (place, found) = (self.placement(), &found[k % BUNCH]);
        if let Some(lane) = lane {
            let strict = self.precision == Precision::Exact;
            let small = Small { found, setups, lane, place, strict };
            let lanes = &mut self.scratch.attributes;
            let shaded = paint(simd, small, lanes, shader, target, depth.as_deref_mut());
            if let Some(shaded) = shaded {
                self.stats.constant_w.count(setups.constant(lane));
                let counts = found.into();
                self.count_pixels(counts, shaded);
                return Outcome::Drawn;
            }
        }
        if matches!(next, Next::Quad(_)) {
            return self.draw_any(&several.polygon(k), window, shader, target, depth);
        }
        let found = *found;
        self.draw_unusual(&several.polygon(k), &found, shader, target, depth)
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
        let w = range_of(&[given[0][3], given[1][3], given[2][3]]);
        let taken = Taken { exponent, w, seen: found.bounds, whole: true, short: true };
        self.fill(polygon, Seen::Small(found, &given, taken), found.into(), shader, target, depth)
    }
}

impl From<&InView> for Counts {
    #[inline(always)]
    fn from(found: &InView) -> Self {
        Self { pixels: found.pixels, spans: found.spans, within: found.bounds }
    }
}
