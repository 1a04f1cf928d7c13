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
