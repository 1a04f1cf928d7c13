//! Blocks of which only some pixels are drawn.

use core::any::Any;

use fearless_simd::{Bytes as _, Select as _, Simd, SimdBase, f32x16, u8x64, u32x16};

use crate::lanes::lanes_of;
use crate::shade::BLOCK;

/// Stores the lanes of `mask`; the others stay what they are.
///
/// Pixels of 4 bytes, which nearly all are, take a handful of instructions, and where the
/// instruction set has masked stores nothing is read.
#[inline(always)]
pub(super) fn store_lanes<L: Simd, P: Copy + 'static>(
    simd: L,
    mask: u16,
    new: &[P; BLOCK],
    pixels: &mut [P; BLOCK],
) {
    let lanes = lanes_of(simd, mask);
    // Which of these it is, is known when this is compiled.
    let (new, to): (&dyn Any, &mut dyn Any) = (new, pixels);
    if let (Some(new), Some(to)) = (new.downcast_ref::<[[u8; 4]; BLOCK]>(), to.downcast_mut()) {
        let to: &mut [[u8; 4]; BLOCK] = to;
        let (new, to) = (new.as_flattened(), to.as_flattened_mut());
        let new: u32x16<L> = u8x64::from_slice(simd, new).bitcast();
        let old: u32x16<L> = u8x64::from_slice(simd, to).bitcast();
        let both: u8x64<L> = lanes.select(new, old).bitcast();
        both.store_slice(to);
    } else if let (Some(new), Some(to)) = (new.downcast_ref::<[u32; BLOCK]>(), to.downcast_mut()) {
        let to: &mut [u32; BLOCK] = to;
        let old = u32x16::load_array_ref(simd, to);
        lanes.select(u32x16::load_array_ref(simd, new), old).store_array(to);
    } else if let (Some(new), Some(to)) = (new.downcast_ref::<[f32; BLOCK]>(), to.downcast_mut()) {
        let to: &mut [f32; BLOCK] = to;
        let old = f32x16::load_array_ref(simd, to);
        lanes.select(f32x16::load_array_ref(simd, new), old).store_array(to);
    } else if let (Some(new), Some(to)) = (new.downcast_ref::<[P; BLOCK]>(), to.downcast_mut()) {
        let to: &mut [P; BLOCK] = to;
        for (lane, (to, from)) in to.iter_mut().zip(new).enumerate() {
            if mask >> lane & 1 != 0 {
                *to = *from;
            }
        }
    }
}
