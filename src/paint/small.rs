//! Small polygons in view, from their set-up to the target: what is usual goes straight through,
//! without a field for each quantity. The bits are those of [`Walker`](crate::span::Walker).

use fearless_simd::{Simd, SimdBase, SimdMask};

use super::Placement;
use super::small_strict::find_strict;
use crate::aligned::LaneMemory;
use crate::depth::{Compare, DepthSource, DepthTest};
use crate::gradient::frame::Linear;
use crate::gradient::nearest_f32;
use crate::gradient::small::{SmallField, SmallSetups};
use crate::in_view::InView;
use crate::lanes::{Narrow, clamp_numbers, low_bits};
use crate::patch::{MOST, Patch};
use crate::shade::{BLOCK, Block, Shader};
use crate::span::InPatch;
use crate::target::{DepthBuffer, Target};

/// A small polygon that is set up.
pub(crate) struct Small<'a> {
    pub(crate) found: &'a InView,
    pub(crate) setups: &'a SmallSetups,
    /// Which of them is its own.
    pub(crate) lane: usize,
    pub(crate) place: Placement,
    /// Is it set up for `Exact`?
    pub(crate) strict: bool,
}

impl Small<'_> {
    /// The pixel that offsets count from.
    #[inline(always)]
    pub(super) fn anchor(&self) -> [i32; 2] {
        let [(column, _), (row, _)] = self.found.middle();
        [column, row]
    }

    /// For each patch its depths, 1/Q, and its attributes; from one to the next it is so many `lanes`.
    #[inline(always)]
    pub(super) fn stride(&self) -> usize {
        self.setups.count() + 2
    }

    /// Room for those of all patches, and the stride.
    #[inline(always)]
    pub(super) fn make_room<'a>(
        &self,
        lanes: &'a mut LaneMemory,
    ) -> (&'a mut [[f32; BLOCK]], usize) {
        let stride = self.stride();
        (lanes.make_room(MOST * stride), stride)
    }
}

/// No shader that reads 1/w or w comes here.
static UNREAD: [f32; BLOCK] = [0.0; BLOCK];

/// Paints `small`. Returns how many pixels were shaded, or nothing, with nothing done, if a depth is too
/// near to 0, or, for `Exact`, any value in doubt.
///
/// It is a function of its own for each shader and target, and not for each type of polygon, too.
#[inline(always)]
pub(crate) fn paint<L: Simd, S: Shader, T: Target<Pixel = S::Pixel>>(
    simd: L,
    small: Small<'_>,
    lanes: &mut LaneMemory,
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> Option<u64> {
    simd.vectorize(
        #[inline(always)]
        move || match small.found.patches.lanes() {
            _ if small.strict => {
                let needs_depth = S::INPUTS.depth;
                let masks =
                    find_strict(simd.level(), &small, lanes, needs_depth, depth.as_deref_mut())?;
                let masks = &masks[..small.found.patches.count()];
                Some(shade_patches(&small, masks, lanes, shader, target, depth, false))
            }
            1 => paint_pixel(&small, lanes, shader, target, depth),
            2..=8 => paint_patch::<8, _, _, _>(simd, &small, lanes, shader, target, depth),
            9..=BLOCK => paint_patch::<BLOCK, _, _, _>(simd, &small, lanes, shader, target, depth),
            _ => paint_several(simd, &small, lanes, shader, target, depth),
        },
    )
}

/// [`paint`] of one patch with `LANES` at most, as most have: straight through, and of a half with half of
/// the lanes.
#[inline(always)]
fn paint_patch<const LANES: usize, L: Simd, S, T>(
    simd: L,
    small: &Small<'_>,
    lanes: &mut LaneMemory,
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> Option<u64>
where
    S: Shader,
    T: Target<Pixel = S::Pixel>,
{
    let Small { found, setups, lane: triangle, place, .. } = small;
    let (patch, triangle) = (found.patches.patch(0), *triangle);
    let at = InPatch::of::<LANES>(simd, patch, small.anchor());
    let n = setups.count();
    let [depths, attributes @ ..] = lanes.make_room(n + 1) else { return None };
    if depth.is_some() || S::INPUTS.depth {
        find_depths(simd, small, at, patch.mask, depths)?;
    }
    // Nothing is in doubt: from here on pixels may be stored.
    let mask = match depth.as_deref_mut() {
        Some(buffer) => test_pixels(buffer, patch, place, depths, S::KEEPS_ALL),
        None => patch.mask,
    };
    if mask == 0 {
        return Some(0);
    }
    let attributes = attributes.get_mut(..n)?;
    if n > 0 {
        let r = find_reciprocals(simd, at, setups.divisor(triangle));
        for (k, out) in attributes.iter_mut().enumerate() {
            find_attribute(simd, at, setups.attribute(k, triangle)?, r, out);
        }
    }
    let stored = S::KEEPS_ALL;
    let values = (&*depths, &*attributes);
    Some(shade_patch(small, patch, mask, values, shader, target, depth, stored))
}

/// The same of several patches.
#[inline(always)]
fn paint_several<L: Simd, S, T>(
    simd: L,
    small: &Small<'_>,
    lanes: &mut LaneMemory,
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> Option<u64>
where
    S: Shader,
    T: Target<Pixel = S::Pixel>,
{
    let Small { found, setups, lane: triangle, place, .. } = small;
    let (patches, triangle) = (&found.patches, *triangle);
    let (anchor, n, count) = (small.anchor(), setups.count(), patches.count());
    let (lanes, stride) = small.make_room(lanes);
    let mut masks = [0; MOST];
    let mut passed = 0;

    // 1. Depth.
    for (i, mask) in masks.iter_mut().enumerate().take(count) {
        let patch = patches.patch(i);
        *mask = patch.mask;
        if *mask != 0 && (depth.is_some() || S::INPUTS.depth) {
            let at = InPatch::new(simd, patch, anchor);
            find_depths(simd, small, at, *mask, lanes.get_mut(i * stride)?)?;
        }
    }
    // Nothing is in doubt: from here on pixels may be stored.
    for (i, mask) in masks.iter_mut().enumerate().take(count) {
        if let Some(buffer) = depth.as_deref_mut() {
            let depths = lanes.get(i * stride)?;
            *mask = test_pixels(buffer, patches.patch(i), place, depths, S::KEEPS_ALL);
        }
        passed |= *mask;
    }
    if passed == 0 {
        return Some(0);
    }

    // 2. Attributes, where a pixel passed.
    if n > 0 {
        let divisor = setups.divisor(triangle);
        for (i, mask) in masks.iter().enumerate().take(count) {
            if *mask == 0 {
                continue;
            }
            let at = InPatch::new(simd, patches.patch(i), anchor);
            let r = find_reciprocals(simd, at, divisor);
            r.store_array(lanes.get_mut(i * stride + 1)?);
        }
    }
    for k in 0..n {
        let field = setups.attribute(k, triangle)?;
        for (i, mask) in masks.iter().enumerate().take(count) {
            if *mask == 0 {
                continue;
            }
            let [_, r, attributes @ ..] = lanes.get_mut(i * stride..(i + 1) * stride)? else {
                return None;
            };
            let at = InPatch::new(simd, patches.patch(i), anchor);
            find_attribute(simd, at, field, Narrow::load_array_ref(simd, r), &mut attributes[k]);
        }
    }
    Some(shade_patches(small, &masks[..count], lanes, shader, target, depth, S::KEEPS_ALL))
}

/// Depths at the lanes of a patch; nothing if one of those that are covered is too near to 0.
#[inline(always)]
fn find_depths<L: Simd>(
    simd: L,
    small: &Small<'_>,
    at: InPatch<L>,
    covered: u16,
    out: &mut [f32; BLOCK],
) -> Option<()> {
    let Some((function, doubtful_below)) = small.setups.depth(small.lane) else {
        *out = [0.0; BLOCK];
        return Some(());
    };
    let found = at.at(simd, function).narrow();
    let limit = Narrow::splat(simd, doubtful_below);
    if covered & low_bits(found.abs().simd_lt(limit).to_bitmask()) != 0 {
        return None;
    }
    let (low, high) = (Narrow::splat(simd, 0.0), Narrow::splat(simd, 1.0));
    clamp_numbers(found, low, high).store_array(out);
    Some(())
}

/// 1/Q there, or 1 if nothing is left to be divided by it.
#[inline(always)]
fn find_reciprocals<L: Simd>(simd: L, at: InPatch<L>, divisor: Option<Linear>) -> Narrow<L> {
    let one = Narrow::splat(simd, 1.0);
    match divisor {
        Some(q) => one / at.at(simd, q).narrow(),
        None => one,
    }
}

/// An attribute there, where that is `r`.
#[inline(always)]
fn find_attribute<L: Simd>(
    simd: L,
    at: InPatch<L>,
    field: SmallField,
    r: Narrow<L>,
    out: &mut [f32; BLOCK],
) {
    match field {
        SmallField::Linear(numerator, [low, high]) => {
            let value = at.at(simd, numerator).narrow() * r;
            let (low, high) = (Narrow::splat(simd, low), Narrow::splat(simd, high));
            clamp_numbers(value, low, high).store_array(out);
        }
        SmallField::Constant(value) => *out = [value; BLOCK],
    }
}

/// Shades what has been found of `small`, at the lanes of `masks`, one for each patch. `stored`: have its
/// depths been?
#[inline(always)]
fn shade_patches<S: Shader, T: Target<Pixel = S::Pixel>>(
    small: &Small<'_>,
    masks: &[u16],
    lanes: &[[f32; BLOCK]],
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
    stored: bool,
) -> u64 {
    let stride = small.stride();
    let mut shaded = 0;
    for (i, mask) in masks.iter().copied().enumerate() {
        let Some([depths, _, attributes @ ..]) = lanes.get(i * stride..(i + 1) * stride) else {
            break;
        };
        if mask != 0 {
            let (patch, values) = (small.found.patches.patch(i), (depths, attributes));
            let depth = depth.as_deref_mut();
            shaded += shade_patch(small, patch, mask, values, shader, target, depth, stored);
        }
    }
    shaded
}

/// The same of one patch, at the lanes of `mask`, where depths and attributes are so much.
#[expect(clippy::too_many_arguments, reason = "what is shaded, with what, and where to")]
#[inline(always)]
fn shade_patch<S: Shader, T: Target<Pixel = S::Pixel>>(
    small: &Small<'_>,
    patch: Patch,
    mask: u16,
    (depths, attributes): (&[f32; BLOCK], &[[f32; BLOCK]]),
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
    stored: bool,
) -> u64 {
    let place = small.place;
    let block = Block {
        first: patch.first,
        columns: patch.columns,
        mask,
        depth: depths,
        inv_w: &UNREAD,
        w: &UNREAD,
        attributes,
    };
    let mut pixels = [S::Pixel::default(); BLOCK];
    let kept = shader.shade(&block, &mut pixels);
    let mut left = if S::KEEPS_ALL { mask } else { kept & mask };
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let [x, y] = patch.place(lane, place.origin);
        // A pixel at a time: nothing predicts how long a run is.
        target.write_pixel(x, y, pixels[lane]);
        if !stored
            && let Some(buffer) = depth.as_deref_mut()
            && place.test.write
        {
            buffer.set_tested(x, y, depths[lane]);
        }
    }
    mask.count_ones().into()
}

/// The pixels of `patch` that pass, tested one after the other; their depths are stored if what passes is
/// kept.
#[inline(always)]
pub(super) fn test_pixels(
    buffer: &mut DepthBuffer<'_>,
    patch: Patch,
    place: &Placement,
    depths: &[f32; BLOCK],
    keeps_all: bool,
) -> u16 {
    let DepthTest { compare, write, .. } = place.test;
    let (origin, store) = (place.origin, keeps_all && write);
    // The most usual ones stand in line, and ask nothing for each pixel: the compiler knows `keeps_all`.
    match compare {
        Compare::Less if store == keeps_all => {
            test_each(buffer, patch, origin, depths, keeps_all, |new, old| new < old)
        }
        Compare::Greater if store == keeps_all => {
            test_each(buffer, patch, origin, depths, keeps_all, |new, old| new > old)
        }
        _ => test_otherwise(buffer, patch, place, depths, store),
    }
}

/// The same for what is less usual. To `store` is to store what passes.
#[inline(never)]
fn test_otherwise(
    buffer: &mut DepthBuffer<'_>,
    patch: Patch,
    place: &Placement,
    depths: &[f32; BLOCK],
    store: bool,
) -> u16 {
    let (compare, origin) = (place.test.compare, place.origin);
    match compare {
        Compare::LessEqual => {
            test_each(buffer, patch, origin, depths, store, |new, old| new <= old)
        }
        Compare::GreaterEqual => {
            test_each(buffer, patch, origin, depths, store, |new, old| new >= old)
        }
        other => test_each(buffer, patch, origin, depths, store, |new, old| other.passes(new, old)),
    }
}

/// [`test_pixels`] by `passes`. To `store` is to store what passes.
#[inline(always)]
fn test_each(
    buffer: &mut DepthBuffer<'_>,
    patch: Patch,
    origin: [i32; 2],
    depths: &[f32; BLOCK],
    store: bool,
    passes: impl Fn(f32, f32) -> bool,
) -> u16 {
    let (stored, stride) = buffer.tested_mut();
    let (first, offsets) = (patch.first_in(origin, stride), patch.offsets());
    let (mut left, mut passed) = (patch.mask, 0);
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        let [column, row] = offsets[lane % BLOCK].map(usize::from);
        // Of a single row the stride may be anything.
        let place = first.wrapping_add(row.wrapping_mul(stride)).wrapping_add(column);
        let Some(stored) = stored.get_mut(place) else { continue };
        let passes = passes(depths[lane], *stored);
        passed |= u16::from(passes) << lane;
        if store {
            // Stored in any case: nothing predicts which pass.
            *stored = if passes { depths[lane] } else { *stored };
        }
    }
    passed
}

/// [`paint_patch`] of a triangle whose bounding box has one pixel, which is covered: offsets count from there, so
/// that nothing changes from pixel to pixel.
#[inline(always)]
fn paint_pixel<S, T>(
    small: &Small<'_>,
    lanes: &mut LaneMemory,
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> Option<u64>
where
    S: Shader,
    T: Target<Pixel = S::Pixel>,
{
    let Small { found, setups, lane: triangle, place, .. } = small;
    let triangle = *triangle;
    let n = setups.count();
    let [depths, attributes @ ..] = lanes.make_room(n + 1) else { return None };
    let patch = found.patches.patch(0);
    let [x, y] = patch.place(0, place.origin);
    if depth.is_some() || S::INPUTS.depth {
        depths[0] = match setups.depth(triangle) {
            Some((function, doubtful_below)) => {
                let found = nearest_f32(function.c);
                if found.abs() < doubtful_below {
                    return None;
                }
                clamp_number(found, [0.0, 1.0])
            }
            None => 0.0,
        };
    }
    if let Some(buffer) = depth.as_deref_mut()
        && !place.test.compare.passes(depths[0], *buffer.tested_pixel_mut(x, y)?)
    {
        return Some(0);
    }
    let r = 1.0 / nearest_f32(setups.unit_q(triangle).c);
    let r = if setups.is_divided(triangle) { 1.0 } else { r };
    for (k, lanes) in attributes.iter_mut().enumerate().take(n) {
        lanes[0] = match setups.attribute(k, triangle)? {
            SmallField::Linear(numerator, range) => {
                clamp_number(nearest_f32(numerator.c) * r, range)
            }
            SmallField::Constant(value) => value,
        };
    }
    let block = Block {
        first: patch.first,
        columns: patch.columns,
        mask: 1,
        depth: depths,
        inv_w: &UNREAD,
        w: &UNREAD,
        attributes: attributes.get(..n)?,
    };
    let mut pixels = [S::Pixel::default(); BLOCK];
    let kept = shader.shade(&block, &mut pixels);
    if S::KEEPS_ALL || kept & 1 != 0 {
        target.write_pixel(x, y, pixels[0]);
        if let Some(buffer) = depth
            && place.test.write
        {
            buffer.set_tested(x, y, block.depth[0]);
        }
    }
    Some(1)
}

/// See [`clamp_numbers`].
#[inline(always)]
fn clamp_number(value: f32, [low, high]: [f32; 2]) -> f32 {
    let value = if value > low { value } else { low };
    (if value < high { value } else { high }) + 0.0
}

/// Can a shader, or a depth test of `source`, have all that it reads?
#[inline(always)]
pub(crate) fn serves<S: Shader>(source: Option<DepthSource>) -> bool {
    !S::INPUTS.inv_w && !S::INPUTS.w && source != Some(DepthSource::InvW)
}
