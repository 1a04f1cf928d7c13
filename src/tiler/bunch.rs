//! Small polygons that are looked at together, and set up some at a time: a lane for each.
#![expect(
    clippy::needless_range_loop,
    reason = "loops over arrays are unrolled, iterators are not"
)]

use core::ops::Range;

use fearless_simd::{Level, Simd, dispatch, f64x8};

use super::hidden::SmallDepths;
use super::scan::take_in_view;
use super::sort::{placed_for, vertex_place};
use crate::depth::DepthSource;
use crate::gradient::AttributesOf;
use crate::gradient::small::{SmallCorners, SmallSetups};
use crate::gradient::triple::choose;
use crate::in_view::{InView, Looks, Places, Scope, Sight};
use crate::number::{EIGHT, Number};
use crate::placed::Constants;
use crate::polygon::Polygon;
use crate::space::Viewport;

/// So many rows from one polygon to the next are too many for a cache to hold what lies between.
pub(crate) const FAR: u32 = 64;

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
    pub(super) count: usize,
    pub(super) sights: [Sight; BUNCH],
    pub(super) found: [InView; BUNCH],
    pub(super) places: Places<3>,
    pub(super) looks: Looks<3>,
    pub(super) quad_places: Places<4>,
    pub(super) quad_looks: Looks<4>,
    pub(super) triangles_ready: Ready,
    pub(super) quads_ready: Ready,
    /// So many small ones lie far from the one before.
    pub(super) far: usize,
    /// The first row of the last small one, and of the last of the others.
    pub(super) last_small_row: i32,
    pub(super) last_row: i32,
    /// So many of the others may yet lie near those before them until fewer are looked at.
    pub(super) patience: usize,
}

/// Those of one kind that cover pixels are set up some at a time.
#[derive(Debug, Default)]
pub(super) struct Ready {
    /// So many lanes are, and so many of these have been drawn.
    filled: usize,
    lane: usize,
    corners: SmallCorners,
    pub(super) depths: SmallDepths,
    pub(super) setups: SmallSetups,
}

/// What small polygons are set up for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// To compare their depths with bounds.
    pub(super) depths: bool,
    /// To be painted, where nothing about them is unusual: with so many attributes at most.
    pub(super) setups: bool,
    pub(super) most: usize,
    /// Is each value to be rounded right?
    pub(super) strict: bool,
}

impl Bunch {
    /// Bytes held elsewhere.
    pub(super) fn bytes(&self) -> usize {
        self.triangles_ready.setups.bytes() + self.quads_ready.setups.bytes()
    }

    /// Those that are ready, with `N` corners.
    #[inline(always)]
    pub(super) fn ready<const N: usize>(&self) -> &Ready {
        if N == 3 { &self.triangles_ready } else { &self.quads_ready }
    }

    /// Begins with `count` polygons.
    #[inline(always)]
    pub(super) fn start(&mut self, count: usize) {
        (self.count, self.far) = (count.min(BUNCH), 0);
        for ready in [&mut self.triangles_ready, &mut self.quads_ready] {
            (ready.filled, ready.lane) = (0, 0);
        }
    }

    /// Looks at what was placed.
    #[inline(always)]
    pub(super) fn look<const LANES: usize>(&mut self, level: Level, scope: &Scope) {
        let Self { looks, places, quad_looks, quad_places, .. } = self;
        if looks.start(places) {
            match LANES {
                1 => looks.look::<f64>((), places, scope),
                _ => look_at_eight_triangles(level, looks, places, scope),
            }
        }
        if quad_looks.start(quad_places) {
            match LANES {
                1 => quad_looks.look::<f64>((), quad_places, scope),
                _ => look_at_eight_quads(level, quad_looks, quad_places, scope),
            }
        }
    }

    /// Finds what the small quadrilaterals among `polygons` cover: out of line, as all that is for these alone,
    /// so that it does not stand in the way of triangles.
    #[inline(never)]
    pub(super) fn look_closely_at_quads<L: Simd>(
        &mut self,
        simd: L,
        polygons: Range<usize>,
        scope: &Scope,
    ) {
        let Self { sights, found, quad_looks, far, last_small_row, .. } = self;
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
                        *far += count_far(last_small_row, found.bounds.y0);
                    }
                    sights[k % BUNCH] =
                        if sight == Sight::Pixels { Sight::PixelsOfQuad } else { sight };
                }
            },
        );
    }

    /// Sets up what is `asked` of those with `N` corners from polygon `first` on that cover pixels, as many
    /// as there are lanes.
    #[inline(always)]
    pub(super) fn set_up<const LANES: usize, const N: usize, P: Several>(
        &mut self,
        level: Level,
        several: &P,
        first: usize,
        asked: Asked,
        (source, viewport): (DepthSource, Viewport),
    ) {
        let Self { count, sights, found, triangles_ready, quads_ready, .. } = self;
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
        match LANES {
            1 => ready.set::<f64, N>((), asked, source, viewport),
            _ if N == 3 => ready.set_eight_triangles(level, asked, source, viewport),
            _ => ready.set_eight_quads(level, asked, source, viewport),
        }
        ready.setups.give_up(odd);
    }
}

/// 1 if `row` is far from the one before it.
#[inline(always)]
pub(super) fn count_far(last: &mut i32, row: i32) -> usize {
    let is_far = row.abs_diff(*last) > FAR;
    *last = row;
    is_far.into()
}

/// [`Looks::look`], compiled for the instruction set, and once: what is generic is compiled again in every crate
/// that draws.
#[inline(never)]
fn look_at_eight_triangles(level: Level, looks: &mut Looks<3>, places: &Places<3>, scope: &Scope) {
    dispatch!(level, simd => looks.look::<f64x8<_>>(simd, places, scope));
}

/// The same.
#[inline(never)]
fn look_at_eight_quads(level: Level, looks: &mut Looks<4>, places: &Places<4>, scope: &Scope) {
    dispatch!(level, simd => looks.look::<f64x8<_>>(simd, places, scope));
}

impl Ready {
    /// Have all that were set up been drawn?
    #[inline(always)]
    pub(super) fn are_drawn(&self) -> bool {
        self.lane == self.filled
    }

    /// The lane of the next one.
    #[inline(always)]
    pub(super) fn next_lane(&mut self) -> usize {
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
    fn set_eight_triangles(
        &mut self,
        level: Level,
        asked: Asked,
        source: DepthSource,
        viewport: Viewport,
    ) {
        dispatch!(level, simd => self.set::<f64x8<_>, 3>(simd, asked, source, viewport));
    }

    /// The same.
    #[inline(never)]
    fn set_eight_quads(
        &mut self,
        level: Level,
        asked: Asked,
        source: DepthSource,
        viewport: Viewport,
    ) {
        dispatch!(level, simd => self.set::<f64x8<_>, 4>(simd, asked, source, viewport));
    }
}

/// Puts the vertices of the quadrilaterals among `polygons` into lanes of `places`; out of line.
#[inline(never)]
pub(super) fn place_quads<L: Simd, P: Several>(
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
pub(super) fn place_in_lane<L: Simd, V: Polygon + ?Sized, const N: usize>(
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
/// placed within the view.
#[inline(always)]
fn triple_and_fourth<V: Polygon + ?Sized>(quad: &V) -> Option<[usize; 4]> {
    let positions = [quad.position(0), quad.position(1), quad.position(2), quad.position(3)];
    let (positions, _) = take_in_view(&positions)?;
    let [a, b, c] = choose(&positions, &AttributesOf(quad));
    // Of all four the sum is 6.
    Some([a, b, c, 6_usize.wrapping_sub(a + b + c) % 4])
}
