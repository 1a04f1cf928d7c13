//! Targets: where pixels go. Anything that can store a run of pixels.

use fearless_simd::{Simd as _, dispatch};

use crate::depth::{DepthBounds, TileRows};
use crate::error::Error;
use crate::fetch::fetch;
use crate::shade::BLOCK;
use crate::simd::Simd;

/// Stores pixels. Column 0, row 0 is the upper left one; where it lies in the framebuffer is
/// the tiler's business ([`Tiler::set_origin`](crate::tiler::Tiler::set_origin)).
///
/// Pairs and triples of targets are targets, of pairs and triples of pixels: several are drawn
/// at once. `()` stores nothing and has no bounds: it leaves depth only.
pub trait Target {
    /// What a shader hands over for a pixel.
    type Pixel: Copy + Default + 'static;

    /// Does nothing remain of a pixel once another one is written in its place? Not if they are
    /// added, counted or blended. Where it is so, a draw list need not draw what is hidden in the end.
    const REPLACES: bool = false;

    /// (width, height) in pixels; nothing is written beyond.
    fn size(&self) -> (u32, u32);

    /// Stores `run` at columns `x ..` of row `y`: at least one pixel, 16 at most, all within
    /// `size()`. No other pixel may be touched.
    fn write(&mut self, x: u32, y: u32, run: &[Self::Pixel]);

    /// Stores one pixel, within `size()`.
    #[inline(always)]
    fn write_pixel(&mut self, x: u32, y: u32, pixel: Self::Pixel) {
        self.write(x, y, &[pixel]);
    }

    /// `count` times 16 pixels at columns `x ..` of row `y`, all within `size()`, to be set in
    /// place, some of them to what they were; or nothing, if that is not how they are stored: then
    /// they come by [`write`](Self::write).
    #[inline(always)]
    fn blocks(&mut self, _x: u32, _y: u32, _count: usize) -> &mut [[Self::Pixel; BLOCK]] {
        &mut []
    }

    /// Pixel (x, y), if there is one, will be written soon: who knows where it lies may ask for its memory.
    #[inline(always)]
    fn fetch(&self, _x: u32, _y: u32) {}

    /// What pixels are cleared to that [`clear_later`](Plane::clear_later) has put off; nothing if the target
    /// knows of no such thing.
    fn background(&self) -> Option<Self::Pixel> {
        None
    }

    /// Sets pixels at columns `columns[0] .. columns[1]` of row `y`, all within `size()`.
    fn fill(&mut self, y: u32, [start, end]: [u32; 2], pixel: Self::Pixel) {
        for x in (start..end).step_by(BLOCK) {
            self.write(x, y, &[pixel; BLOCK][..BLOCK.min((end - x) as usize)]);
        }
    }
}

/// Rows of pixels, borrowed from the caller: a picture, depth, ids. Row `r` begins at element
/// `r * stride`.
#[derive(Debug)]
pub struct Plane<'a, P> {
    data: &'a mut [P],
    width: u32,
    height: u32,
    stride: usize,
    /// Of depths that are attached to some.
    bounds: Option<TileRows<'a>>,
    background: Option<P>,
}

impl<P> Default for Plane<'_, P> {
    /// Without a pixel.
    fn default() -> Self {
        Self { data: &mut [], width: 0, height: 0, stride: 0, bounds: None, background: None }
    }
}

/// A plane of depths: see [`DepthTest`](crate::depth::DepthTest).
pub type DepthBuffer<'a> = Plane<'a, f32>;

impl<'a, P: Copy> Plane<'a, P> {
    /// Rows of `width` pixels, one after the other.
    ///
    /// # Errors
    /// [`Error::PlaneTooShort`] if `data` has fewer than `width * height` elements.
    pub fn new(data: &'a mut [P], width: u32, height: u32) -> Result<Self, Error> {
        Self::with_stride(data, width, height, width as usize)
    }

    /// Rows of `width` pixels, `stride` elements from one to the next; what lies between is
    /// never touched.
    ///
    /// # Errors
    /// [`Error::StrideTooSmall`] if `stride < width`, [`Error::PlaneTooShort`] if the last row
    /// reaches beyond `data`.
    pub fn with_stride(
        data: &'a mut [P],
        width: u32,
        height: u32,
        stride: usize,
    ) -> Result<Self, Error> {
        if stride < width as usize {
            return Err(Error::StrideTooSmall { needed: width as usize, given: stride });
        }
        let needed = match height as usize {
            0 => 0,
            h => (h - 1).saturating_mul(stride).saturating_add(width as usize),
        };
        if data.len() < needed {
            return Err(Error::PlaneTooShort { needed, given: data.len() });
        }
        Ok(Self { data, width, height, stride, bounds: None, background: None })
    }

    /// With what is cleared later ([`clear_later`](Plane::clear_later)) cleared to `pixel`.
    #[must_use]
    pub fn with_background(self, pixel: P) -> Self {
        Self { background: Some(pixel), ..self }
    }

    /// (width, height) in pixels.
    pub fn dimensions(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Row `y`, below the height: `width` pixels.
    #[inline(always)]
    pub fn row(&self, y: u32) -> &[P] {
        let start = y as usize * self.stride;
        &self.data[start..start + self.width as usize]
    }

    /// Asks for the memory of pixel (x, y), if there is one.
    #[inline(always)]
    pub(crate) fn fetch_pixel(&self, x: u32, y: u32) {
        fetch(self.data, (y as usize).wrapping_mul(self.stride).wrapping_add(x as usize));
    }

    /// A pixel, for those who keep the bounds true themselves.
    #[inline(always)]
    pub(crate) fn tested_pixel_mut(&mut self, x: u32, y: u32) -> Option<&mut P> {
        self.data.get_mut(y as usize * self.stride + x as usize)
    }

    /// All pixels, and how many it is from one row to the next, for those who keep the bounds true themselves.
    #[inline(always)]
    pub(crate) fn tested_mut(&mut self) -> (&mut [P], usize) {
        (&mut *self.data, self.stride)
    }

    /// Row `y`, below the height: `width` pixels.
    #[inline(always)]
    pub fn row_mut(&mut self, y: u32) -> &mut [P] {
        if let Some(bounds) = &mut self.bounds {
            bounds.forget_row(y);
        }
        self.tested_row_mut(y)
    }

    /// The same, for those who keep the bounds true themselves.
    #[inline(always)]
    pub(crate) fn tested_row_mut(&mut self, y: u32) -> &mut [P] {
        let start = y as usize * self.stride;
        &mut self.data[start..start + self.width as usize]
    }

    /// Sets a pixel, for those who keep the bounds true themselves.
    #[inline(always)]
    pub(crate) fn set_tested(&mut self, x: u32, y: u32, pixel: P) {
        if let Some(to) = self.tested_pixel_mut(x, y) {
            *to = pixel;
        }
    }

    /// The rows above `row`, or all if there are fewer, and the others.
    pub fn split_at_row(self, row: u32) -> (Self, Self) {
        let Self { data, width, height, stride, bounds, background } = self;
        let row = row.min(height);
        let (above, below) = data.split_at_mut((row as usize * stride).min(data.len()));
        let (bounds_above, bounds_below) =
            bounds.and_then(|rows| rows.split_at_row(row, height)).unzip();
        (
            Self { data: above, width, height: row, stride, bounds: bounds_above, background },
            Self {
                data: below,
                width,
                height: height - row,
                stride,
                bounds: bounds_below,
                background,
            },
        )
    }

    /// The same plane, borrowed for a while.
    pub fn reborrow(&mut self) -> Plane<'_, P> {
        let Self { data, width, height, stride, bounds, background } = self;
        let bounds = bounds.as_mut().map(TileRows::reborrow);
        let (width, height, stride, background) = (*width, *height, *stride, *background);
        Plane { data, width, height, stride, bounds, background }
    }

    /// Sets every pixel, and nothing between the rows.
    pub fn clear(&mut self, pixel: P) {
        dispatch!(Simd::auto().0, simd => simd.vectorize(
            #[inline(always)]
            || {
                for y in 0..self.height {
                    self.tested_row_mut(y).fill(pixel);
                }
            }
        ));
        if let Some(bounds) = &mut self.bounds {
            bounds.clear();
        }
    }
}

impl<'a> Plane<'a, f32> {
    /// With bounds of its depths, by which the tiler leaves out what is hidden. They must have
    /// been attached to these same depths before, or to none of this size, else they have to
    /// [`forget`](DepthBounds::forget).
    #[must_use]
    pub fn with_bounds(self, bounds: &'a mut DepthBounds) -> Self {
        Self { bounds: Some(bounds.attach(self.width, self.height)), ..self }
    }

    /// Are any attached?
    #[inline(always)]
    pub(crate) fn has_bounds(&self) -> bool {
        self.bounds.is_some()
    }

    /// Those attached.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> Option<&TileRows<'a>> {
        self.bounds.as_ref()
    }

    /// The bounds attached, and the depths without them.
    pub(crate) fn apart(&mut self) -> (Option<&mut TileRows<'a>>, DepthBuffer<'_>) {
        let Self { data, width, height, stride, bounds, background } = self;
        let (width, height, stride, background) = (*width, *height, *stride, *background);
        (bounds.as_mut(), Plane { data, width, height, stride, bounds: None, background })
    }

    /// The same, to be changed.
    #[inline(always)]
    pub(crate) fn bounds_mut(&mut self) -> Option<&mut TileRows<'a>> {
        self.bounds.as_mut()
    }
}

impl<'a> Plane<'a, [u8; 4]> {
    /// RGBA8 out of bytes: `4 * width * height` of them.
    ///
    /// # Errors
    /// [`Error::PlaneTooShort`] if there are fewer.
    pub fn from_bytes(bytes: &'a mut [u8], width: u32, height: u32) -> Result<Self, Error> {
        Self::new(bytes.as_chunks_mut().0, width, height)
    }
}

#[cfg(feature = "image")]
impl<'a> From<&'a mut image::RgbaImage> for Plane<'a, [u8; 4]> {
    fn from(picture: &'a mut image::RgbaImage) -> Self {
        let (width, height) = picture.dimensions();
        Self {
            data: picture.as_chunks_mut().0,
            width,
            height,
            stride: width as usize,
            ..Self::default()
        }
    }
}

#[cfg(feature = "image")]
impl<'a> From<&'a mut image::ImageBuffer<image::Luma<f32>, alloc::vec::Vec<f32>>>
    for Plane<'a, f32>
{
    fn from(picture: &'a mut image::ImageBuffer<image::Luma<f32>, alloc::vec::Vec<f32>>) -> Self {
        let (width, height) = picture.dimensions();
        Self { data: picture, width, height, stride: width as usize, ..Self::default() }
    }
}

impl<P: Copy + Default + 'static> Target for Plane<'_, P> {
    type Pixel = P;
    const REPLACES: bool = true;

    fn size(&self) -> (u32, u32) {
        self.dimensions()
    }

    #[inline(always)]
    fn write(&mut self, x: u32, y: u32, run: &[P]) {
        let x = x as usize;
        let to = &mut self.row_mut(y)[x..x + run.len()];
        copy_run(run, to);
    }

    #[inline(always)]
    fn write_pixel(&mut self, x: u32, y: u32, pixel: P) {
        if let Some(bounds) = &mut self.bounds {
            bounds.forget_row(y);
        }
        self.set_tested(x, y, pixel);
    }

    #[inline(always)]
    fn blocks(&mut self, x: u32, y: u32, count: usize) -> &mut [[P; BLOCK]] {
        let x = x as usize;
        self.row_mut(y)[x..x + count * BLOCK].as_chunks_mut().0
    }

    #[inline(always)]
    fn fetch(&self, x: u32, y: u32) {
        self.fetch_pixel(x, y);
    }

    fn background(&self) -> Option<P> {
        self.background
    }

    fn fill(&mut self, y: u32, [start, end]: [u32; 2], pixel: P) {
        let to = &mut self.row_mut(y)[start as usize..end as usize];
        dispatch!(Simd::auto().0, simd => simd.vectorize(
            #[inline(always)]
            || to.fill(pixel)
        ));
    }
}

/// Copies 1 to 16 pixels; both slices are as long.
#[inline(always)]
pub(crate) fn copy_run<P: Copy>(from: &[P], to: &mut [P]) {
    // Two copies of a length that is known, overlapping: a call costs more, and so does a branch
    // for each power of two, since nothing predicts a run's length.
    macro_rules! copy {
        ($($length:expr),+) => { $(
            if let (Some(head), Some(tail)) =
                (from.first_chunk::<{ $length }>(), from.last_chunk::<{ $length }>())
            {
                if let Some(to) = to.first_chunk_mut() {
                    *to = *head;
                }
                if let Some(to) = to.last_chunk_mut() {
                    *to = *tail;
                }
                return;
            }
        )+ };
    }
    copy!(8, 4, 2, 1);
}

impl Target for () {
    type Pixel = ();
    const REPLACES: bool = true;

    fn size(&self) -> (u32, u32) {
        (u32::MAX, u32::MAX)
    }

    #[inline(always)]
    fn write(&mut self, _x: u32, _y: u32, _run: &[()]) {}

    #[inline(always)]
    fn blocks(&mut self, _x: u32, _y: u32, count: usize) -> &mut [[(); BLOCK]] {
        // Of no size: nothing is allocated, nor lost.
        alloc::vec![[(); BLOCK]; count].leak()
    }

    fn background(&self) -> Option<()> {
        Some(())
    }

    fn fill(&mut self, _y: u32, _columns: [u32; 2], (): ()) {}
}

impl<T: Target + ?Sized> Target for &mut T {
    type Pixel = T::Pixel;
    const REPLACES: bool = T::REPLACES;

    fn size(&self) -> (u32, u32) {
        (**self).size()
    }

    #[inline(always)]
    fn write(&mut self, x: u32, y: u32, run: &[T::Pixel]) {
        (**self).write(x, y, run);
    }

    #[inline(always)]
    fn write_pixel(&mut self, x: u32, y: u32, pixel: T::Pixel) {
        (**self).write_pixel(x, y, pixel);
    }

    #[inline(always)]
    fn blocks(&mut self, x: u32, y: u32, count: usize) -> &mut [[T::Pixel; BLOCK]] {
        (**self).blocks(x, y, count)
    }

    #[inline(always)]
    fn fetch(&self, x: u32, y: u32) {
        (**self).fetch(x, y);
    }

    fn background(&self) -> Option<T::Pixel> {
        (**self).background()
    }

    fn fill(&mut self, y: u32, columns: [u32; 2], pixel: T::Pixel) {
        (**self).fill(y, columns, pixel);
    }
}

macro_rules! tuple_target {
    ($($name:ident $i:tt),+) => {
        impl<$($name: Target),+> Target for ($($name,)+) {
            type Pixel = ($($name::Pixel,)+);
            const REPLACES: bool = $($name::REPLACES)&&+;

            /// What all of them have.
            fn size(&self) -> (u32, u32) {
                let sizes = [$(self.$i.size()),+];
                sizes.iter().fold((u32::MAX, u32::MAX), |a, b| (a.0.min(b.0), a.1.min(b.1)))
            }

            #[inline(always)]
            fn write(&mut self, x: u32, y: u32, run: &[Self::Pixel]) {
                $(
                    let mut part = [$name::Pixel::default(); BLOCK];
                    for (to, from) in part.iter_mut().zip(run) {
                        *to = from.$i;
                    }
                    self.$i.write(x, y, &part[..run.len()]);
                )+
            }

            #[inline(always)]
            fn write_pixel(&mut self, x: u32, y: u32, pixel: Self::Pixel) {
                $(self.$i.write_pixel(x, y, pixel.$i);)+
            }

            #[inline(always)]
            fn fetch(&self, x: u32, y: u32) {
                $(self.$i.fetch(x, y);)+
            }

            fn background(&self) -> Option<Self::Pixel> {
                Some(($(self.$i.background()?,)+))
            }

            fn fill(&mut self, y: u32, columns: [u32; 2], pixel: Self::Pixel) {
                $(self.$i.fill(y, columns, pixel.$i);)+
            }
        }
    };
}

tuple_target!(A 0, B 1);
tuple_target!(A 0, B 1, C 2);
tuple_target!(A 0, B 1, C 2, D 3);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_check_their_rows_and_leave_gaps_alone() {
        let mut data = [0_u32; 8];
        assert!(Plane::with_stride(&mut data, 3, 3, 4).is_err());
        assert!(Plane::with_stride(&mut data, 3, 1, 2).is_err());
        assert!(Plane::new(&mut data, 0, 0).is_ok());
        Plane::with_stride(&mut data, 3, 2, 4).expect("7 of 8 elements").clear(7);
        assert_eq!(data, [7, 7, 7, 0, 7, 7, 7, 0]);
    }

    #[test]
    fn targets_in_a_tuple_are_written_together() {
        let (mut a, mut b) = ([0_u8; 4], [0_u32; 4]);
        let planes = (Plane::new(&mut a, 4, 1), Plane::new(&mut b, 2, 2));
        let mut both = (planes.0.expect("4 x 1"), planes.1.expect("2 x 2"));
        assert_eq!(both.size(), (2, 1));
        both.write(1, 0, &[(9, 8)]);
        assert_eq!((a, b), ([0, 9, 0, 0], [0, 8, 0, 0]));
    }
}
