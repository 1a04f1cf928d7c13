//! Small polygons in view, in `Exact`: from their set-up to depths and attributes, each shown to be rounded
//! right. It depends on neither shader nor target, and is compiled once.

use fearless_simd::{Level, Simd, SimdBase, dispatch};

use super::small::{Small, test_pixels};
use crate::aligned::LaneMemory;
use crate::gradient::small::SmallField;
use crate::gradient::small_strict::ErrorBound;
use crate::lanes::{Narrow, Wide};
use crate::patch::MOST;
use crate::shade::BLOCK;
use crate::span::InPatch;
use crate::target::DepthBuffer;

/// Finds what is asked of `small`, as `paint` lays it out: for each patch its depths, lanes that are not
/// used here, and its attributes. Returns the pixels that pass; nothing, with nothing done, if any of their
/// values is in doubt. Depths are not stored.
#[inline(never)]
pub(super) fn find_strict(
    level: Level,
    small: &Small<'_>,
    lanes: &mut LaneMemory,
    needs_depth: bool,
    depth: Option<&mut DepthBuffer<'_>>,
) -> Option<[u16; MOST]> {
    dispatch!(level, simd => match small.found.patches.lanes() {
        ..=8 => find_lanes::<8, _>(simd, small, lanes, needs_depth, depth),
        9..=BLOCK => find_lanes::<BLOCK, _>(simd, small, lanes, needs_depth, depth),
        _ => find_lanes::<{ MOST * BLOCK }, _>(simd, small, lanes, needs_depth, depth),
    })
}

/// [`find_strict`] where patches have `LANES` at most.
#[inline(always)]
fn find_lanes<const LANES: usize, L: Simd>(
    simd: L,
    small: &Small<'_>,
    lanes: &mut LaneMemory,
    needs_depth: bool,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> Option<[u16; MOST]> {
    let Small { found, setups, lane: triangle, place, .. } = small;
    let (patches, triangle) = (&found.patches, *triangle);
    let anchor = small.anchor();
    let n = setups.count();
    let (lanes, stride) = small.make_room(lanes);
    let mut masks = [0; MOST];

    // 1. Depth.
    for (i, mask) in masks.iter_mut().enumerate().take(patches.count()) {
        let patch = patches.patch(i);
        *mask = patch.mask;
        if *mask == 0 || !(needs_depth || depth.is_some()) {
            continue;
        }
        let out = lanes.get_mut(i * stride)?;
        if let Some((function, _)) = setups.depth(triangle) {
            let value = InPatch::of::<LANES>(simd, patch, anchor).at(simd, function);
            let error = setups.depth_error(triangle);
            let (rounded, certain) = round(simd, value, error, [0.0, 1.0]);
            if patch.mask & !certain != 0 {
                return None;
            }
            rounded.store_array(out);
        } else {
            *out = [0.0; BLOCK];
        }
        if let Some(buffer) = depth.as_deref_mut() {
            *mask = test_pixels(buffer, patch, place, out, false);
        }
    }

    // 2. Attributes, where a pixel passed.
    for (i, mask) in masks.iter().enumerate().take(patches.count()) {
        if *mask == 0 || n == 0 {
            continue;
        }
        let at = InPatch::of::<LANES>(simd, patches.patch(i), anchor);
        let q = at.at(simd, setups.unit_q(triangle));
        let r = q.quick_reciprocal(simd);
        let mut doubtful = q.below(Wide::splat(simd, setups.least_q(triangle)));
        let attributes = lanes.get_mut(i * stride + 2..(i + 1) * stride)?;
        for (k, out) in attributes.iter_mut().enumerate() {
            match setups.attribute(k, triangle)? {
                SmallField::Linear(numerator, range) => {
                    let (base, error) = setups.base(k, triangle)?;
                    let value = at.at(simd, numerator) * r + Wide::splat(simd, base);
                    let (rounded, certain) = round(simd, value, error, range);
                    doubtful |= !certain;
                    rounded.store_array(out);
                }
                SmallField::Constant(value) => *out = [value; BLOCK],
            }
        }
        if mask & doubtful != 0 {
            return None;
        }
    }
    Some(masks)
}

/// `value`, which is off by `error` at most, rounded to `f32` within the range; and the lanes at which that
/// is surely right.
#[inline(always)]
fn round<L: Simd>(simd: L, value: Wide<L>, error: ErrorBound, range: [f32; 2]) -> (Narrow<L>, u16) {
    let ErrorBound { always, by_value } = error;
    let error = value.abs() * Wide::splat(simd, by_value) + Wide::splat(simd, always);
    value.round_within(error, range)
}
