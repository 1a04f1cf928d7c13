//! Memory that is asked for before it is needed.

/// Asks for the memory of element `i`, if there is one; does nothing where there is no way to.
#[inline(always)]
pub(crate) fn fetch<T>(data: &[T], i: usize) {
    #[cfg(feature = "std")]
    prefetch_index::prefetch_index(data, i);
    #[cfg(not(feature = "std"))]
    let _ = (data, i);
}
