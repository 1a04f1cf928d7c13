//! The shaders that fill a canvas.
//!
//! [`Picture`] writes a picture and nothing else, straight into rows of RGBA8: the fast way.
//! [`Data`] writes every plane itself, the picture too, from one pass; [`Coverage`] does where
//! no plane needs values. Where colours come from is the caller's [`Colour`]. For each there is
//! what opens it for a band of rows.
//!
//! Each pair of a polygon's type and a shader is a loop of its own, times the instruction sets.
//! So only what is drawn most has a [`Picture`] of its own, and all else is [`Data`].

use hyperspan::draw::Paint;
use hyperspan::shade::{BLOCK, Block, Inputs, ROW, Shader, unorm8};
use hyperspan::target::{DepthBuffer, Plane};
use hyperspan::varying::CANONICAL_NAN;

use crate::aov::Aov;
use crate::canvas::{Band, Counts, PlaneRows, RowValues};
use crate::flags::Crop;

/// The colour of a pixel, out of its attributes. Covered pixels are opaque.
pub(crate) trait Colour: Sync {
    /// Red, green and blue of `lane`.
    fn rgb(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [f32; 3];

    /// Red, green and blue of the lanes in `mask`, the others are anything: `rgb`.
    fn rgb_lanes(&self, attributes: &[[f32; BLOCK]], _mask: u16, out: &mut [[f32; BLOCK]; 3]) {
        let [r, g, b] = out;
        for (lane, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
            [*r, *g, *b] = self.rgb(attributes, lane);
        }
    }

    /// RGBA8 of the lanes in `mask`, the others are anything: `rgb` rounded.
    #[inline(always)]
    fn rgba8(&self, attributes: &[[f32; BLOCK]], _mask: u16, out: &mut [[u8; 4]; BLOCK]) {
        // All lanes: vectors are faster than branches.
        for (lane, pixel) in out.iter_mut().enumerate() {
            let [r, g, b] = self.rgb(attributes, lane);
            *pixel = [unorm8(r), unorm8(g), unorm8(b), 255];
        }
    }

    /// The same of all lanes of some blocks.
    #[inline(always)]
    fn rgba8_row(&self, blocks: &[Block<'_>; ROW], out: &mut [[[u8; 4]; BLOCK]; ROW]) {
        for (block, out) in blocks.iter().zip(out) {
            self.rgba8(block.attributes, block.mask, out);
        }
    }
}

/// What a loop is compiled for.
pub(crate) trait Reads {
    /// How many attributes a colour is made of: the first ones.
    const ATTRIBUTES: usize;
}

/// Colours into a target of RGBA8.
#[derive(Debug)]
pub(crate) struct Picture<'a, C>(pub(crate) &'a C);

impl<C: Colour + Reads> Shader for Picture<'_, C> {
    type Pixel = [u8; 4];
    const INPUTS: Inputs = Inputs::attributes(C::ATTRIBUTES);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [[u8; 4]; BLOCK]) -> u16 {
        self.0.rgba8(block.attributes, block.mask, out);
        block.mask
    }

    #[inline(always)]
    fn shade_row(&mut self, blocks: &[Block<'_>; ROW], out: &mut [[[u8; 4]; BLOCK]; ROW]) {
        self.0.rgba8_row(blocks, out);
    }
}

/// Which of a polygon's attributes are what; nothing for what it has not.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layout {
    /// Of (u, v).
    pub(crate) uv: Option<usize>,
    /// Of the normal.
    pub(crate) normal: Option<usize>,
    /// Of the world position.
    pub(crate) position: Option<usize>,
}

/// Draws a picture and nothing else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PaintPicture<'a, C>(pub(crate) &'a C);

impl<'a, 'b, C: Colour + Reads> Paint<Band<'b>> for PaintPicture<'a, C> {
    const REPLACES: bool = true;
    const CLEARS: bool = true;

    type Shader<'c>
        = Picture<'c, C>
    where
        Self: 'c,
        Band<'b>: 'c;
    type Target<'c>
        = Plane<'c, [u8; 4]>
    where
        Self: 'c,
        Band<'b>: 'c;

    fn open<'c>(
        &'c self,
        band: &'c mut Band<'b>,
    ) -> (Picture<'c, C>, Plane<'c, [u8; 4]>, Option<DepthBuffer<'c>>) {
        let picture = band.picture.as_deref_mut().unwrap_or_default();
        let depth = band.depth.as_mut().map(DepthBuffer::reborrow);
        (Picture(self.0), plane(picture, band.crop).with_background(band.background), depth)
    }
}

/// The pixels of a crop; none where there are too few.
pub(crate) fn plane<P: Copy>(pixels: &mut [P], crop: Crop) -> Plane<'_, P> {
    let size = if pixels.len() < crop.width as usize * crop.height as usize {
        (0, 0)
    } else {
        (crop.width, crop.height)
    };
    Plane::new(pixels, size.0, size.1).unwrap_or_else(|_| Plane::default())
}

/// A target that stores nothing, but has a crop's size: for shaders that store by themselves.
fn extent<'a>(crop: Crop) -> Plane<'a, ()> {
    // Of no size: nothing is allocated, nor lost.
    plane(vec![(); crop.width as usize * crop.height as usize].leak(), crop)
}

/// Draws all planes of data, and the picture if there is one. Depth and w are found only if `ALL` is:
/// no other plane needs them, and small triangles know no w.
pub(crate) struct PaintData<'a, const ALL: bool> {
    /// Where colours come from.
    pub(crate) colour: &'a dyn Colour,
    /// Where the other attributes are.
    pub(crate) layout: Layout,
    /// The number of polygon `i` of the batch.
    pub(crate) id: &'a (dyn Fn(usize) -> u32 + Sync),
}

impl<'a, 'b, const ALL: bool> Paint<Band<'b>> for PaintData<'a, ALL> {
    const REPLACES: bool = true;

    type Shader<'c>
        = Data<'c, 'b, ALL>
    where
        Self: 'c,
        Band<'b>: 'c;
    type Target<'c>
        = Plane<'c, ()>
    where
        Self: 'c,
        Band<'b>: 'c;

    fn open<'c>(
        &'c self,
        band: &'c mut Band<'b>,
    ) -> (Data<'c, 'b, ALL>, Plane<'c, ()>, Option<DepthBuffer<'c>>) {
        let crop = band.crop;
        let depth = band.depth.as_mut().map(DepthBuffer::reborrow);
        let data = Data {
            paint: self,
            id: 0,
            crop,
            picture: band.picture.as_deref_mut(),
            planes: &mut band.planes,
        };
        (data, extent(crop), depth)
    }
}

/// Draws depth, and nothing else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PaintDepth;

impl<'b> Paint<Band<'b>> for PaintDepth {
    const REPLACES: bool = true;
    const CLEARS: bool = true;

    type Shader<'c>
        = Coverage<'c>
    where
        Band<'b>: 'c;
    type Target<'c>
        = Plane<'c, ()>
    where
        Band<'b>: 'c;

    fn open<'c>(
        &'c self,
        band: &'c mut Band<'b>,
    ) -> (Coverage<'c>, Plane<'c, ()>, Option<DepthBuffer<'c>>) {
        let depth = band.depth.as_mut().map(DepthBuffer::reborrow);
        (Coverage::default(), extent(band.crop), depth)
    }
}

/// Counts how often pixels are covered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PaintCounts;

impl<'b> Paint<Counts<'b>> for PaintCounts {
    type Shader<'c>
        = Coverage<'c>
    where
        Counts<'b>: 'c;
    type Target<'c>
        = Plane<'c, ()>
    where
        Counts<'b>: 'c;

    fn open<'c>(
        &'c self,
        band: &'c mut Counts<'b>,
    ) -> (Coverage<'c>, Plane<'c, ()>, Option<DepthBuffer<'c>>) {
        let counts = Some((band.crop, &mut *band.counts));
        (Coverage { counts }, extent(band.crop), None)
    }
}

/// Writes all planes of data, and the picture if there is one.
pub(crate) struct Data<'c, 'b, const ALL: bool> {
    paint: &'c PaintData<'c, ALL>,
    /// The polygon's number.
    id: u32,
    crop: Crop,
    picture: Option<&'c mut [[u8; 4]]>,
    planes: &'c mut [PlaneRows<'b>],
}

impl<const ALL: bool> Shader for Data<'_, '_, ALL> {
    type Pixel = ();
    const INPUTS: Inputs = Inputs { depth: ALL, inv_w: false, w: ALL, attributes: usize::MAX };
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn start(&mut self, i: usize) {
        self.id = (self.paint.id)(i);
    }

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        let places = self.crop.places(block);
        if let Some(picture) = &mut self.picture {
            let mut rgba = [[0; 4]; BLOCK];
            self.paint.colour.rgba8(block.attributes, block.mask, &mut rgba);
            places.put(block.mask, &rgba, picture);
        }
        self.put_data(block, &places);
        block.mask
    }

    #[inline(always)]
    fn shade_row(&mut self, blocks: &[Block<'_>; ROW], _out: &mut [[(); BLOCK]; ROW]) {
        let start = self.crop.place(&blocks[0], 0);
        if let Some(picture) = &mut self.picture {
            let pixels = picture[start..].as_chunks_mut().0;
            if let Some(pixels) = pixels.first_chunk_mut() {
                self.paint.colour.rgba8_row(blocks, pixels);
            }
        }
        for (block, start) in blocks.iter().zip((start..).step_by(BLOCK)) {
            self.put_data(block, &Places::Row(start));
        }
    }
}

impl<const ALL: bool> Data<'_, '_, ALL> {
    /// Stores what data there is of `block`.
    #[inline(always)]
    fn put_data(&mut self, block: &Block<'_>, places: &Places) {
        let PaintData { colour, layout, .. } = *self.paint;
        for plane in self.planes.iter_mut() {
            match &mut plane.values {
                RowValues::Integers(values) => places.put(block.mask, &[self.id; BLOCK], values),
                RowValues::Floats(values) => {
                    let attributes = |first: Option<usize>| {
                        let end = first.map(|first| first + plane.channels);
                        first.zip(end).and_then(|(first, end)| block.attributes.get(first..end))
                    };
                    let channels = match plane.aov {
                        Aov::Depth => Some(std::slice::from_ref(block.depth)),
                        Aov::W => Some(std::slice::from_ref(block.w)),
                        Aov::Color => {
                            let mut rgb = [[1.0; BLOCK]; 4];
                            if let Some(rgb) = rgb.first_chunk_mut() {
                                colour.rgb_lanes(block.attributes, block.mask, rgb);
                            }
                            rgb.as_flattened_mut().iter_mut().for_each(|c| *c = canonical(*c));
                            places.put_channels(block.mask, 4, Some(&rgb), values);
                            continue;
                        }
                        Aov::Uv => attributes(layout.uv),
                        Aov::Normal => attributes(layout.normal),
                        Aov::Position => attributes(layout.position),
                        Aov::Attr => attributes(Some(0)),
                        Aov::Id | Aov::Overdraw => continue,
                    };
                    places.put_channels(block.mask, plane.channels, channels, values);
                }
            }
        }
    }
}

/// Where the pixels of a block are in a plane of the crop's size.
enum Places {
    /// All 16 are covered, one after the other from here on.
    Row(usize),
    /// Of each covered lane.
    Each([usize; BLOCK]),
}

impl Places {
    /// Stores the lanes of `mask`.
    #[inline(always)]
    fn put<P: Copy>(&self, mask: u16, from: &[P; BLOCK], to: &mut [P]) {
        match self {
            Self::Row(start) => to[*start..*start + BLOCK].copy_from_slice(from),
            Self::Each(places) => {
                for lane in lanes(mask) {
                    to[places[lane]] = from[lane];
                }
            }
        }
    }

    /// The same of pixels of `n` values, which are those of `channels`; 0 without them.
    #[inline(always)]
    fn put_channels(&self, mask: u16, n: usize, channels: Option<&[[f32; BLOCK]]>, to: &mut [f32]) {
        let Some(channels) = channels else {
            for lane in lanes(mask) {
                let start = self.of(lane) * n;
                to[start..start + n].fill(0.0);
            }
            return;
        };
        if let Self::Row(start) = self {
            let to = &mut to[start * n..(start + BLOCK) * n];
            // Where the compiler knows how many there are, they become vectors.
            if let Ok([a]) = <&[_; 1]>::try_from(channels) {
                to.copy_from_slice(a);
                return;
            } else if let Ok(channels) = channels.try_into() {
                return interleave::<2>(channels, to);
            } else if let Ok(channels) = channels.try_into() {
                return interleave::<3>(channels, to);
            } else if let Ok(channels) = channels.try_into() {
                return interleave::<4>(channels, to);
            }
        }
        for lane in lanes(mask) {
            let start = self.of(lane) * n;
            for (to, from) in to[start..start + n].iter_mut().zip(channels) {
                *to = from[lane];
            }
        }
    }

    /// Of one lane.
    #[inline(always)]
    fn of(&self, lane: usize) -> usize {
        match self {
            Self::Row(start) => start + lane,
            Self::Each(places) => places[lane],
        }
    }
}

/// 16 pixels of `N` values.
#[inline(always)]
fn interleave<const N: usize>(channels: &[[f32; BLOCK]; N], to: &mut [f32]) {
    for (lane, pixel) in to.as_chunks_mut::<N>().0.iter_mut().enumerate().take(BLOCK) {
        for (to, from) in pixel.iter_mut().zip(channels) {
            *to = from[lane];
        }
    }
}

/// Nothing but the depth test; or, without one, how often each pixel is covered.
#[derive(Debug, Default)]
pub(crate) struct Coverage<'a> {
    /// Counts for the pixels of a rectangle, row after row.
    pub(crate) counts: Option<(Crop, &'a mut [u32])>,
}

impl Shader for Coverage<'_> {
    type Pixel = ();
    const INPUTS: Inputs = Inputs::COVERAGE;
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        if let Some((crop, counts)) = &mut self.counts {
            let places = crop.places(block);
            for lane in lanes(block.mask) {
                let count = &mut counts[places.of(lane)];
                *count = count.saturating_add(1);
            }
        }
        block.mask
    }
}

impl Crop {
    /// Where lane `lane` of `block` is in a plane of the crop's size.
    #[inline(always)]
    fn place(self, block: &Block<'_>, lane: u16) -> usize {
        let (x, y) = self.origin();
        let (column, row) = (block.x(lane).abs_diff(x), block.y(lane).abs_diff(y));
        (row as usize).wrapping_mul(self.width as usize) + column as usize
    }

    /// Where the covered pixels of `block` are in a plane of the crop's size.
    #[inline(always)]
    fn places(self, block: &Block<'_>) -> Places {
        if block.mask == u16::MAX && block.columns == 16 {
            return Places::Row(self.place(block, 0));
        }
        let mut places = [0; BLOCK];
        for lane in lanes(block.mask) {
            places[lane] = self.place(block, lane as u16);
        }
        Places::Each(places)
    }
}

/// The lanes whose bits are set in `mask`, from the left.
#[inline]
pub(crate) fn lanes(mask: u16) -> impl Iterator<Item = usize> {
    let mut left = mask;
    std::iter::from_fn(move || {
        let lane = left.trailing_zeros() as usize;
        left &= left.wrapping_sub(1);
        (lane < BLOCK).then_some(lane)
    })
}

/// `value`, any NaN as the one that is written.
fn canonical(value: f32) -> f32 {
    if value.is_nan() { CANONICAL_NAN } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_the_set_bits() {
        assert_eq!(lanes(0b1000_0000_0010_0001).collect::<Vec<_>>(), [0, 5, 15]);
        assert_eq!(lanes(0).count(), 0);
        assert_eq!(lanes(u16::MAX).count(), BLOCK);
    }
}
