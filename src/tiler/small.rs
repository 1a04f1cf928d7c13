//! Small triangles and quadrilaterals in view, from their vertices' places on the grid to their pixels: some
//! are looked at and set up together, and then drawn one after the other, in order.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over arrays are unrolled, iterators are not"
)]

use core::ops::Range;

use fearless_simd::{Level, Simd, dispatch, f64x8};

use super::hidden::SmallDepths;
use super::scan::{Counts, Taken, take_in_view};
use super::sort::{placed_for, vertex_place};
use super::{Outcome, Precision, Seen, Tiler, positions_of};
use crate::depth::{DepthSource, DepthTest};
use crate::gradient::AttributesOf;
use crate::gradient::small::{SmallCorners, SmallSetups};
use crate::gradient::triple::choose;
use crate::hidden::Area;
use crate::number::{EIGHT, Number};
use crate::paint::small::{Small, paint, serves};
use crate::placed::Constants;
use crate::polygon::Polygon;
use crate::shade::Shader;
use crate::space::{PixelRect, Viewport};
use crate::target::{DepthBuffer, Target};
use crate::triangle::{InView, Looks, Places, Scope, Sight};

/// Polygons that are looked at together, at most: so many that those among them that cover pixels fill
/// lanes.
pub(crate) const BUNCH: usize = 32;

/// Some polygons, by number from 0 on.
pub(crate) trait Several {
    type Polygon<'a>: Polygon
    where
        Self: 'a;

    fn polygon(&self, k: usize) -> Self::Polygon<'_>;
}

/// One polygon.
pub(super) struct One<'a, V: ?Sized>(pub(super) &'a V);

impl<V: Polygon + ?Sized> Several for One<'_, V> {
    type Polygon<'a>
        = &'a V
    where
        Self: 'a;

    #[inline(always)]
    fn polygon(&self, _k: usize) -> &V {
        self.0
    }
}

/// Polygons that are looked at together, and what was found.
#[derive(Debug, Default)]
pub(super) struct Bunch {
    count: usize,
    sights: [Sight; BUNCH],
    found: [InView; BUNCH],
    places: Places<3>,
    pub(super) looks: Looks<3>,
    quad_places: Places<4>,
    pub(super) quad_looks: Looks<4>,
    triangles_ready: Ready,
    quads_ready: Ready,
}

/// Those of one kind that cover pixels are set up some at a time.
#[derive(Debug, Default)]
struct Ready {
    /// So many lanes are, and so many of these have been drawn.
    filled: usize,
    lane: usize,
    corners: SmallCorners,
    depths: SmallDepths,
    setups: SmallSetups,
}

/// What small polygons are set up for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// To compare their depths with bounds.
    depths: bool,
    /// To be painted, where nothing about them is unusual: with so many attributes at most.
    setups: bool,
    most: usize,
    /// Is each value to be rounded right?
    strict: bool,
}

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

impl Bunch {
    /// Bytes held elsewhere.
    pub(super) fn bytes(&self) -> usize {
        self.triangles_ready.setups.bytes() + self.quads_ready.setups.bytes()
    }

    /// Those that are ready, with `N` corners.
    #[inline(always)]
    fn ready<const N: usize>(&self) -> &Ready {
        if N == 3 { &self.triangles_ready } else { &self.quads_ready }
    }

    /// Looks at what was placed.
    #[inline(always)]
    fn look<const LANES: usize>(&mut self, level: Level, scope: &Scope) {
        let Self { looks, places, quad_looks, quad_places, .. } = self;
        if looks.start(places) {
            match LANES {
                1 => looks.look::<f64>((), places, scope),
                _ => look_at_eight(level, looks, places, scope),
            }
        }
        if quad_looks.start(quad_places) {
            match LANES {
                1 => quad_looks.look::<f64>((), quad_places, scope),
                _ => look_at_eight(level, quad_looks, quad_places, scope),
            }
        }
    }

    /// Finds what the small quadrilaterals among `polygons` cover: out of line, as all that is for these alone,
    /// so that it does not stand in the way of triangles.
    #[inline(never)]
    fn look_closely_at_quads<L: Simd>(&mut self, simd: L, polygons: Range<usize>, scope: &Scope) {
        let Self { sights, found, quad_looks, .. } = self;
        simd.vectorize(
            #[inline(always)]
            || {
                for (lane, k) in polygons.enumerate() {
                    if !quad_looks.is_small(lane) {
                        continue;
                    }
                    let found = &mut found[k % BUNCH];
                    let mut sight = quad_looks.sight(lane, scope, found);
                    if sight == Sight::Pixels {
                        sight = quad_looks.cover(simd, lane, scope, found);
                    }
                    sights[k % BUNCH] =
                        if sight == Sight::Pixels { Sight::PixelsOfQuad } else { sight };
                }
            },
        );
    }
}

/// [`Looks::look`], compiled for the instruction set, and once.
#[inline(never)]
fn look_at_eight<const N: usize>(
    level: Level,
    looks: &mut Looks<N>,
    places: &Places<N>,
    scope: &Scope,
) {
    dispatch!(level, simd => looks.look::<f64x8<_>>(simd, places, scope));
}

impl Ready {
    /// Have all that were set up been drawn?
    #[inline(always)]
    fn are_drawn(&self) -> bool {
        self.lane == self.filled
    }

    /// The lane of the next one.
    #[inline(always)]
    fn next_lane(&mut self) -> usize {
        self.lane += 1;
        (self.lane - 1) % EIGHT
    }

    /// Sets up what is `asked`, of polygons with `N` corners.
    #[inline(always)]
    fn set<F: Number, const N: usize>(
        &mut self,
        level: F::Level,
        asked: Asked,
        source: DepthSource,
        viewport: Viewport,
    ) {
        let Self { filled, corners, depths, setups, .. } = self;
        if asked.depths && N == 3 {
            depths.set::<F>(level, corners, source, viewport);
        }
        if asked.setups {
            let lanes = u8::MAX >> (EIGHT - (*filled).clamp(1, EIGHT));
            match (asked.strict, N) {
                (true, _) => setups.set_strict::<F, N>(level, corners, lanes, viewport),
                (false, 3) => setups.set::<F>(level, corners, lanes, viewport),
                (false, _) => setups.set_quads::<F>(level, corners, lanes, viewport),
            }
        }
        if asked.depths && N > 3 {
            depths.set_quads::<F>(level, corners, setups, viewport);
        }
    }

    /// The same, compiled for the instruction set, and once.
    #[inline(never)]
    fn set_eight<const N: usize>(
        &mut self,
        level: Level,
        asked: Asked,
        source: DepthSource,
        viewport: Viewport,
    ) {
        dispatch!(level, simd => self.set::<f64x8<_>, N>(simd, asked, source, viewport));
    }
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
        self.bunch.count = count.min(BUNCH);
        for ready in [&mut self.bunch.triangles_ready, &mut self.bunch.quads_ready] {
            (ready.filled, ready.lane) = (0, 0);
        }
        let mut first = 0;
        while first < self.bunch.count {
            let end = self.bunch.count.min(first + LANES);
            self.look_from_outside::<LANES, _, _>(simd, several, first..end, window);
            let Bunch { sights, found, looks, .. } = &mut self.bunch;
            for k in first..end {
                let found = &mut found[k % BUNCH];
                sights[k % BUNCH] = match looks.sight(k - first, &scope, found) {
                    Sight::Pixels => looks.cover(simd, k - first, &scope, found),
                    sight => sight,
                };
            }
            if self.bunch.quad_looks.any() {
                self.bunch.look_closely_at_quads(simd, first..end, &scope);
            }
            first = end;
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

    /// Where small triangles are to be drawn.
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
        if asked.setups {
            if self.bunch.quads_ready.are_drawn() {
                self.leave_out_hidden::<LANES, _, _>(
                    simd,
                    several,
                    k,
                    window,
                    depth.as_deref_mut(),
                );
                if self.bunch.sights[k % BUNCH] == Sight::Hidden {
                    return Next::Done(Outcome::Hidden);
                }
                self.set_up::<LANES, 4, _>(several, k, asked);
            }
            let ready = &mut self.bunch.quads_ready;
            let lane = ready.next_lane();
            if ready.setups.is_usual(lane) {
                if asked.depths && self.hides_or_takes::<4>(k, lane, window, depth) {
                    return Next::Done(Outcome::Hidden);
                }
                return Next::Quad(lane);
            }
        }
        self.next_spans(simd, &several.polygon(k), window, depth)
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
            self.set_up::<LANES, 3, _>(several, k, asked);
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

    /// Sets up what is `asked` of those with `N` corners from polygon `first` on that cover pixels, as many
    /// as there are lanes.
    #[inline(always)]
    fn set_up<const LANES: usize, const N: usize, P: Several>(
        &mut self,
        several: &P,
        first: usize,
        asked: Asked,
    ) {
        let Bunch { count, sights, found, triangles_ready, quads_ready, .. } = &mut self.bunch;
        let ready = if N == 3 { triangles_ready } else { quads_ready };
        let Ready { corners, setups, .. } = ready;
        let most = if asked.setups { asked.most } else { 0 };
        let n = several.polygon(first).attribute_count().min(most);
        let attributes = setups.attributes_mut(n);
        let wanted = if N == 3 { Sight::Pixels } else { Sight::PixelsOfQuad };
        let (mut lanes, mut odd) = (0, 0);
        for k in first..*count {
            if lanes == LANES {
                break;
            }
            if sights[k % BUNCH] != wanted {
                continue;
            }
            let (polygon, found, at) = (several.polygon(k), &found[k % BUNCH], lanes % EIGHT);
            lanes += 1;
            let [(column, u), (row, v)] = found.middle();
            (corners.anchor[0][at], corners.anchor[1][at]) = (column.into(), row.into());
            corners.reach[at] = u.greater(v);
            corners.beyond[at] = found.beyond;
            if polygon.attribute_count().min(most) != n {
                odd |= 1 << at;
            }
            let order = if N == 3 {
                [0, 1, 2, 2]
            } else if let Some(order) = triple_and_fourth(&polygon) {
                order
            } else {
                odd |= 1 << at;
                [0, 1, 2, 3]
            };
            for i in 0..N {
                let [x, y, z, w] = polygon.position(order[i]);
                let corner = &mut corners.positions[i];
                (corner[0][at], corner[1][at], corner[2][at], corner[3][at]) = (x, y, z, w);
            }
            if odd >> at == 0 {
                for (k, attribute) in attributes.iter_mut().enumerate() {
                    for i in 0..N {
                        attribute.values[i][at] = polygon.attribute(order[i], k).into();
                    }
                }
            }
        }
        (ready.filled, ready.lane) = (lanes, 0);
        let (source, viewport) = (self.depth_test.source, self.viewport);
        match LANES {
            1 => ready.set::<f64, N>((), asked, source, viewport),
            _ => ready.set_eight::<N>(self.simd.0, asked, source, viewport),
        }
        ready.setups.give_up(odd);
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
        let taken = Taken { exponent, w, seen: found.bounds, whole: true, short: true };
        self.scratch.is_set_up = false;
        self.fill(polygon, Seen::Small(found, &given, taken), found.into(), shader, target, depth)
    }
}

/// Puts the vertices of the quadrilaterals among `polygons` into lanes of `places`; out of line.
#[inline(never)]
fn place_quads<L: Simd, P: Several>(
    simd: L,
    constants: &Constants,
    viewport: Viewport,
    several: &P,
    polygons: Range<usize>,
    places: &mut Places<4>,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (lane, k) in polygons.enumerate() {
                let (lane, polygon) = (lane % EIGHT, several.polygon(k));
                if polygon.len() == 4 {
                    place_in_lane(simd, constants, viewport, &polygon, lane, places);
                }
            }
        },
    );
}

/// Puts the vertices of `polygon`, of which there are `N`, into `lane` of `places`.
#[inline(always)]
fn place_in_lane<L: Simd, V: Polygon + ?Sized, const N: usize>(
    simd: L,
    constants: &Constants,
    viewport: Viewport,
    polygon: &V,
    lane: usize,
    places: &mut Places<N>,
) {
    let placed = placed_for(viewport, polygon);
    let mut within = true;
    for i in 0..N {
        let place = vertex_place(simd, constants, polygon, placed, i);
        let [x, y] = place.bits;
        (places.x[i][lane], places.y[i][lane]) = (x.into(), y.into());
        within &= place.within;
    }
    places.within |= u8::from(within) << lane;
}

/// The vertices of a quadrilateral's triple, and the fourth; nothing if it is none that could have been
/// placed within the view, at a size where nothing overflows.
#[inline(always)]
fn triple_and_fourth<V: Polygon + ?Sized>(quad: &V) -> Option<[usize; 4]> {
    let positions = [quad.position(0), quad.position(1), quad.position(2), quad.position(3)];
    let (mut largest, mut sum) = (0.0_f64, 0.0);
    for component in positions.as_flattened() {
        (largest, sum) = (largest.greater(component.abs()), sum + component);
    }
    // What is no number makes no number of this.
    if !(SMALLEST..LARGEST).contains(&largest) || sum * 0.0 != 0.0 {
        return None;
    }
    let [a, b, c] = choose(&positions, &AttributesOf(quad));
    // Of all four the sum is 6.
    Some([a, b, c, 6_usize.wrapping_sub(a + b + c) % 4])
}

/// Between these polygons are taken in as they are.
const SMALLEST: f64 = 1.0 / LARGEST;
const LARGEST: f64 = 18_446_744_073_709_551_616.0;

impl From<&InView> for Counts {
    #[inline(always)]
    fn from(found: &InView) -> Self {
        Self { pixels: found.pixels, spans: found.spans, within: found.bounds }
    }
}

/// Least and greatest of three numbers.
#[inline(always)]
fn range([a, b, c]: [f64; 3]) -> [f64; 2] {
    [a.lesser(b).lesser(c), a.greater(b).greater(c)]
}
