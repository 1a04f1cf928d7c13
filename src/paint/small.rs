//! Small triangles in view, from their set-up to the target: what is usual goes straight through,
//! without a field for each quantity. The bits are those of [`Walker`](crate::span::Walker).

use alloc::vec::Vec;

use fearless_simd::{Simd, SimdBase, SimdMask};

use super::patches::stored_depths;
use super::{Placement, passing_lanes};
use crate::depth::DepthSource;
use crate::gradient::view::{View, usual_range};
use crate::gradient::{ConstantAlong, nearest_f32};
use crate::lanes::{Narrow, clamp_numbers, low_bits};
use crate::patch::{MOST, Patches};
use crate::polygon::Polygon;
use crate::shade::{BLOCK, Block, Shader};
use crate::span::InPatch;
use crate::target::{DepthBuffer, Target};

/// A small triangle whose plane is set up.
pub(crate) struct Small<'a> {
    pub(crate) patches: &'a Patches,
    pub(crate) view: &'a View,
    /// The pixel that offsets count from.
    pub(crate) anchor: [i32; 2],
    /// What becomes depth, at the corners, before the division.
    pub(crate) z: [f64; 3],
    pub(crate) attribute_count: usize,
}

/// The attributes of a triangle's corners.
pub(crate) struct CornerValues<'a, V: ?Sized> {
    pub(crate) polygon: &'a V,
    /// The numbers of its vertices.
    pub(crate) corners: [usize; 3],
}

impl<V: Polygon + ?Sized> CornerValues<'_, V> {
    /// Attribute `k`.
    #[inline(always)]
    fn of(&self, k: usize) -> [f32; 3] {
        let Self { polygon, corners: [a, b, c] } = *self;
        [polygon.attribute(a, k), polygon.attribute(b, k), polygon.attribute(c, k)]
    }
}

/// No shader that reads 1/w or w comes here.
static UNREAD: [f32; BLOCK] = [0.0; BLOCK];

/// Paints `small`, which has `MANY` patches at most and whose corners have `values`: one, as most
/// have, is compiled by itself, without loops. Returns how many pixels were shaded, or nothing, with
/// nothing done, if the triangle is not usual: an attribute is no number, not of a size that fits, or
/// a depth too near to 0.
#[expect(clippy::too_many_arguments, reason = "a room's door: what comes in, and where to")]
#[inline(always)]
pub(crate) fn paint_small<const MANY: usize, L: Simd, V, S, T>(
    simd: L,
    small: &Small<'_>,
    values: &CornerValues<'_, V>,
    place: &Placement,
    lanes: &mut Vec<[f32; BLOCK]>,
    shader: &mut S,
    target: &mut T,
    mut depth: Option<&mut DepthBuffer<'_>>,
) -> Option<u64>
where
    V: Polygon + ?Sized,
    S: Shader,
    T: Target<Pixel = S::Pixel>,
{
    let Small { patches, view, anchor, z, .. } = *small;
    let n = small.attribute_count.min(S::INPUTS.attributes);
    // For each patch its depths, 1/Q, and its attributes.
    let stride = n + 2;
    if lanes.len() < MOST * stride {
        lanes.resize(MOST * stride, [0.0; BLOCK]);
    }
    let count = if MANY == 1 { 1 } else { patches.count() };
    let first = InPatch::new(simd, patches.patch(0), anchor);
    let mut masks = [0; MANY];
    let mut passed = 0;

    // 1. Depth.
    let zero = z[0].abs() + z[1].abs() + z[2].abs() == 0.0;
    for (i, mask) in masks.iter_mut().enumerate().take(count) {
        let patch = patches.patch(i);
        if patch.mask == 0 {
            continue;
        }
        *mask = patch.mask;
        let out = lanes.get_mut(i * stride)?;
        if depth.is_some() || S::INPUTS.depth {
            if zero {
                *out = [0.0; BLOCK];
            } else {
                let (function, doubtful_below) = view.depth(z);
                let at = if MANY == 1 { first } else { InPatch::new(simd, patch, anchor) };
                let found = at.at(simd, function).narrow();
                // A hair above it, so that what rounds to a `f32` below is among them.
                let limit = Narrow::splat(simd, nearest_f32(doubtful_below * 1.001));
                if patch.mask & low_bits(found.abs().simd_lt(limit).to_bitmask()) != 0 {
                    return None;
                }
                let (low, high) = (Narrow::splat(simd, 0.0), Narrow::splat(simd, 1.0));
                clamp_numbers(found, low, high).store_array(out);
            }
        }
        if let Some(buffer) = depth.as_deref() {
            let stored = stored_depths(buffer, patch, place.origin);
            *mask &= passing_lanes(simd, place.test.compare, out, &stored);
        }
        passed |= *mask;
    }
    if passed == 0 {
        return Some(0);
    }

    // 2. Attributes, where a pixel passed.
    let divided = view.constant == ConstantAlong::Polygon;
    if n > 0 && !divided {
        for (i, mask) in masks.iter().enumerate().take(count) {
            if *mask == 0 {
                continue;
            }
            let at = if MANY == 1 { first } else { InPatch::new(simd, patches.patch(i), anchor) };
            let q = at.at(simd, view.unit_q).narrow();
            (Narrow::splat(simd, 1.0) / q).store_array(lanes.get_mut(i * stride + 1)?);
        }
    }
    for k in 0..n {
        let [a, b, c] = values.of(k);
        let (numerator, range) = match usual_range([a, b, c]) {
            Some(range) => {
                let numerator = view.numerator([f64::from(a), f64::from(b), f64::from(c)]);
                // As for any polygon: one rounding is left where w is the same all over.
                let numerator =
                    if divided { numerator.scaled(1.0 / view.unit_q.c) } else { numerator };
                (Some(numerator), range)
            }
            None if a.to_bits() == b.to_bits() && a.to_bits() == c.to_bits() && a.is_finite() => {
                (None, [a; 2])
            }
            None => return None,
        };
        let (low, high) = (Narrow::splat(simd, range[0]), Narrow::splat(simd, range[1]));
        for (i, mask) in masks.iter().enumerate().take(count) {
            if *mask == 0 {
                continue;
            }
            let [_, r, attributes @ ..] = lanes.get_mut(i * stride..(i + 1) * stride)? else {
                return None;
            };
            let Some(numerator) = numerator else {
                low.store_array(&mut attributes[k]);
                continue;
            };
            let at = if MANY == 1 { first } else { InPatch::new(simd, patches.patch(i), anchor) };
            let n = at.at(simd, numerator).narrow();
            let value = if divided { n } else { n * Narrow::load_array_ref(simd, r) };
            clamp_numbers(value, low, high).store_array(&mut attributes[k]);
        }
    }

    // 3. Shader and target.
    let mut shaded = 0;
    for (i, mask) in masks.into_iter().enumerate().take(count) {
        let patch = patches.patch(i);
        if mask == 0 {
            continue;
        }
        let lanes = lanes.get(i * stride..(i + 1) * stride)?;
        let block = Block {
            first: patch.first,
            columns: patch.columns,
            mask,
            depth: &lanes[0],
            inv_w: &UNREAD,
            w: &UNREAD,
            attributes: &lanes[2..],
        };
        let mut pixels = [S::Pixel::default(); BLOCK];
        let kept = shader.shade(&block, &mut pixels);
        let mut left = if S::KEEPS_ALL { mask } else { kept & mask };
        shaded += u64::from(mask.count_ones());
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let [x, y] = patch.place(lane, place.origin);
            // A pixel at a time: nothing predicts how long a run is.
            target.write_pixel(x, y, pixels[lane]);
            if let Some(buffer) = depth.as_deref_mut()
                && place.test.write
            {
                buffer.set_tested(x, y, block.depth[lane]);
            }
        }
    }
    Some(shaded)
}

/// Can a shader, or a depth test of `source`, have all that it reads?
#[inline(always)]
pub(crate) fn serves<S: Shader>(source: Option<DepthSource>) -> bool {
    !S::INPUTS.inv_w && !S::INPUTS.w && source != Some(DepthSource::InvW)
}
