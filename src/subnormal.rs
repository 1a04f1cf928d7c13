//! Arithmetic that takes the smallest numbers for 0.
//!
//! A thread can be set so (FTZ and DAZ; programs built with `-ffast-math` do it to all threads of a
//! process): then some bits would differ, and nothing is drawn instead.

/// Does this thread's arithmetic keep subnormal numbers? A sum takes no longer for them, as a product
/// does on some machines.
#[inline(always)]
pub(crate) fn are_kept() -> bool {
    let least = core::hint::black_box(f32::from_bits(1));
    (least + least).to_bits() == 2
}

#[cfg(test)]
mod tests {
    #[test]
    fn arithmetic_keeps_subnormal_numbers() {
        assert!(super::are_kept());
    }
}
