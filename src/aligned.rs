//! Memory that begins where a line of the cache does.
//!
//! A vector of 64 bytes that lies in two lines takes two accesses: where lanes and rows of pixels
//! begin decides how long a frame takes (docs/benchmarks.md has how much). An allocator promises 16.

use alloc::vec::Vec;
use core::ops::{Deref, DerefMut};

use crate::error::Error;
use crate::shade::BLOCK;

/// Bytes of a line of the cache, and of 16 pixels or depths.
const LINE: usize = 64;

/// Elements that begin on 64 bytes, if their size allows for it: a picture or depths to draw on.
///
/// Any slice can be drawn on, with the same bits. Rows of a multiple of 16 pixels in one of these
/// are drawn with the fewest accesses to memory.
///
/// ```
/// use hyperspan::{Aligned, Plane};
///
/// let mut picture = Aligned::filled([0_u8; 4], 640 * 480)?;
/// assert_eq!(picture.as_ptr() as usize % 64, 0);
/// let mut plane = Plane::new(&mut picture, 640, 480)?;
/// plane.row_mut(2)[1] = [255; 4];
/// assert_eq!(picture[2 * 640 + 1], [255; 4]);
/// # Ok::<(), hyperspan::Error>(())
/// ```
#[derive(Debug)]
pub struct Aligned<P> {
    memory: Vec<P>,
    start: usize,
    count: usize,
}

impl<P> Default for Aligned<P> {
    /// None.
    fn default() -> Self {
        Self { memory: Vec::new(), start: 0, count: 0 }
    }
}

impl<P: Copy> Aligned<P> {
    /// `count` elements, all `value`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if there is not enough.
    pub fn filled(value: P, count: usize) -> Result<Self, Error> {
        // No size needs more elements than this to come to the beginning of a line.
        let all = count.saturating_add(LINE);
        let mut memory = Vec::new();
        let bytes = all.saturating_mul(size_of::<P>());
        memory.try_reserve_exact(all).map_err(|_| Error::OutOfMemory { bytes })?;
        memory.resize(all, value);
        Ok(Self::within(memory, count))
    }

    /// `count` elements of `memory`, which has [`LINE`] more.
    fn within(memory: Vec<P>, count: usize) -> Self {
        let start = memory.as_ptr().align_offset(LINE);
        // Some sizes cannot come there, and need not.
        Self { memory, start: if start < LINE { start } else { 0 }, count }
    }
}

impl<P> Deref for Aligned<P> {
    type Target = [P];

    #[inline(always)]
    fn deref(&self) -> &[P] {
        &self.memory[self.start..self.start + self.count]
    }
}

impl<P> DerefMut for Aligned<P> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [P] {
        &mut self.memory[self.start..self.start + self.count]
    }
}

/// Values of 16 pixels each, for as many quantities as a polygon has.
#[derive(Debug, Default)]
pub(crate) struct LaneMemory(Aligned<f32>);

impl LaneMemory {
    /// Room for `count` quantities or more; those that were here stay.
    #[inline(always)]
    pub(crate) fn make_room(&mut self, count: usize) -> &mut [[f32; BLOCK]] {
        if self.0.count < count * BLOCK {
            self.grow(count);
        }
        self
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, count: usize) {
        let count = count * BLOCK;
        let mut more = Aligned::within(alloc::vec![0.0; count + LINE], count);
        more[..self.0.count].copy_from_slice(&self.0);
        self.0 = more;
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.0.memory.capacity() * size_of::<f32>()
    }
}

impl Deref for LaneMemory {
    type Target = [[f32; BLOCK]];

    #[inline(always)]
    fn deref(&self) -> &[[f32; BLOCK]] {
        self.0.as_chunks().0
    }
}

impl DerefMut for LaneMemory {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [[f32; BLOCK]] {
        self.0.as_chunks_mut().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begins_on_a_line<P: Copy + PartialEq + core::fmt::Debug>(value: P) -> bool {
        let all = Aligned::filled(value, 5).expect("little");
        assert_eq!(*all, [value; 5]);
        (all.as_ptr() as usize).is_multiple_of(LINE)
    }

    #[test]
    fn memory_begins_on_a_line_if_its_elements_can() {
        assert!(begins_on_a_line(7_u8));
        assert!(begins_on_a_line([1_u8, 2, 3]));
        assert!(begins_on_a_line(1.5_f32));
        assert!(begins_on_a_line([1.5_f64; 3]));
        // These need not, and are there.
        begins_on_a_line([1_u8; LINE]);
        begins_on_a_line(());
        assert!(Aligned::<u32>::default().is_empty());
    }

    #[test]
    fn more_memory_than_there_is_is_an_error() {
        for count in [usize::MAX / 8, usize::MAX] {
            let refused = Aligned::filled(0_u64, count).map(|_| ());
            assert!(matches!(refused, Err(Error::OutOfMemory { .. })), "{count}");
        }
    }

    #[test]
    fn lanes_stay_when_there_is_room_for_more() {
        let mut lanes = LaneMemory::default();
        lanes.make_room(2)[1] = [3.0; BLOCK];
        lanes.make_room(100)[99] = [4.0; BLOCK];
        assert_eq!((lanes[1], lanes[99]), ([3.0; BLOCK], [4.0; BLOCK]));
        assert_eq!((lanes.make_room(1).len(), lanes.bytes()), (100, 4 * (100 * BLOCK + LINE)));
        assert!((lanes.as_ptr() as usize).is_multiple_of(LINE));
    }
}
