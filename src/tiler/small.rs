//! Small triangles in view, from their vertices' places on the grid to their pixels: some are looked at
//! and set up together, and then drawn one after the other, in order.

use core::ops::Range;

use fearless_simd::{Level, Simd, dispatch, f64x8};

use super::hidden::SmallDepths;
use super::scan::{Counts, Taken, take_in_view};
use super::sort::{placed_for, vertex_place};
use super::{Outcome, Precision, Seen, Tiler, positions_of};
use crate::depth::{DepthSource, DepthTest};
use crate::gradient::small::{SmallCorners, SmallSetups};
use crate::hidden::Area;
use crate::number::{EIGHT, Number};
use crate::paint::small::{Small, paint, serves};
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
    places: Places,
    pub(super) looks: Looks,
    /// Those of them that cover pixels are set up some at a time: so many lanes are, and so many of
    /// these have been drawn.
    filled: usize,
    lane: usize,
    corners: SmallCorners,
    depths: SmallDepths,
    setups: SmallSetups,
}

/// What small triangles are set up for.
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
}

impl Bunch {
    /// Bytes held elsewhere.
    pub(super) fn bytes(&self) -> usize {
        self.setups.bytes()
    }

    /// [`Looks::look`], compiled for the instruction set, and once.
    #[inline(never)]
    fn look_at_eight(&mut self, level: Level, scope: &Scope) {
        let Self { looks, places, .. } = self;
        dispatch!(level, simd => looks.look::<f64x8<_>>(simd, places, scope));
    }

    /// Sets up what is `asked`.
    #[inline(always)]
    fn set<F: Number>(
        &mut self,
        level: F::Level,
        asked: Asked,
        source: DepthSource,
        viewport: Viewport,
    ) {
        let Self { filled, corners, depths, setups, .. } = self;
        if asked.depths {
            depths.set::<F>(level, corners, source, viewport);
        }
        if asked.setups {
            let lanes = u8::MAX >> (EIGHT - (*filled).clamp(1, EIGHT));
            if asked.strict {
                setups.set_strict::<F>(level, corners, lanes, viewport);
            } else {
                setups.set::<F>(level, corners, lanes, viewport);
            }
        }
    }

    /// The same, compiled for the instruction set, and once.
    #[inline(never)]
    fn set_eight(&mut self, level: Level, asked: Asked, source: DepthSource, viewport: Viewport) {
        dispatch!(level, simd => self.set::<f64x8<_>>(simd, asked, source, viewport));
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
        (self.bunch.filled, self.bunch.lane) = (0, 0);
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
        let scope = &self.scope(window);
        let Self { bunch: Bunch { places, looks, .. }, place_constants, viewport, .. } = self;
        places.within = 0;
        let has_planes = self.clipper.has_user_planes();
        for (lane, k) in polygons.enumerate() {
            let (lane, polygon) = (lane % EIGHT, several.polygon(k));
            if polygon.len() != 3 || has_planes {
                continue;
            }
            let placed = placed_for(*viewport, &polygon);
            let mut within = true;
            for i in 0..3 {
                let place = vertex_place(simd, place_constants, &polygon, placed, i);
                let [x, y] = place.bits;
                (places.x[i][lane], places.y[i][lane]) = (x.into(), y.into());
                within &= place.within;
            }
            places.within |= u8::from(within) << lane;
        }
        match LANES {
            _ if !looks.start(places) => {}
            1 => looks.look::<f64>((), places, scope),
            _ => self.bunch.look_at_eight(self.simd.0, scope),
        }
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
            Sight::Elsewhere => {
                if self.is_hidden_in_view(simd, &several.polygon(k), window, depth) {
                    Next::Done(Outcome::Hidden)
                } else {
                    Next::Spans
                }
            }
            Sight::Pixels => self.next_small::<LANES, _>(several, k, window, asked, depth),
        }
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
        if self.bunch.lane == self.bunch.filled {
            self.set_up::<LANES, _>(several, k, asked);
        }
        let lane = self.bunch.lane % EIGHT;
        self.bunch.lane += 1;
        let DepthTest { compare, write, .. } = self.depth_test;
        let Bunch { found, depths, setups, .. } = &mut self.bunch;
        let found = &found[k % BUNCH];
        if asked.depths
            && let Some(buffer) = depth
            && let Some(area) = Area::new(found.bounds.intersect(window), self.origin)
        {
            let (hides, count) = (self.hides, write.then_some(found.pixels));
            if buffer.hides_or_takes(area, depths.of(lane), compare, hides, count) {
                return Next::Done(Outcome::Hidden);
            }
        }
        Next::Small((asked.setups && setups.is_usual(lane)).then_some(lane))
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
        let lane = match next {
            Next::Done(outcome) => return outcome,
            Next::Spans => {
                return self.draw_any(&several.polygon(k), window, shader, target, depth);
            }
            Next::Small(lane) => lane,
        };
        let place = self.placement();
        let Bunch { found, setups, .. } = &self.bunch;
        let found = &found[k % BUNCH];
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
        let found = *found;
        self.draw_unusual(&several.polygon(k), &found, shader, target, depth)
    }

    /// Sets up what is `asked` of those from polygon `first` on that cover pixels, as many as there are
    /// lanes.
    #[inline(always)]
    fn set_up<const LANES: usize, P: Several>(&mut self, several: &P, first: usize, asked: Asked) {
        let Bunch { count, sights, found, corners, setups, .. } = &mut self.bunch;
        let most = if asked.setups { asked.most } else { 0 };
        let n = several.polygon(first).attribute_count().min(most);
        let attributes = setups.attributes_mut(n);
        let (mut lanes, mut odd) = (0, 0);
        for k in first..*count {
            if lanes == LANES {
                break;
            }
            if sights[k % BUNCH] != Sight::Pixels {
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
            for (i, corner) in corners.positions.iter_mut().enumerate() {
                let [x, y, z, w] = polygon.position(i);
                (corner[0][at], corner[1][at], corner[2][at], corner[3][at]) = (x, y, z, w);
                if odd >> at == 0 {
                    for (k, attribute) in attributes.iter_mut().enumerate() {
                        attribute.values[i][at] = polygon.attribute(i, k).into();
                    }
                }
            }
        }
        (self.bunch.filled, self.bunch.lane) = (lanes, 0);
        let (source, viewport) = (self.depth_test.source, self.viewport);
        match LANES {
            1 => self.bunch.set::<f64>((), asked, source, viewport),
            _ => self.bunch.set_eight(self.simd.0, asked, source, viewport),
        }
        self.bunch.setups.give_up(odd);
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
