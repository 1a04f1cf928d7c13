//! What a frame is drawn into: the picture, the depth buffer, and a plane for each kind of data
//! that was asked for; and the shaders that fill them.
//!
//! A picture alone goes through [`Picture`], straight into rows of RGBA8. As soon as data is
//! asked for, [`Data`] writes every plane itself, from one pass; [`Coverage`] does where depth
//! is all that is wanted. Where colours come from is the caller's [`Colour`].

use hyperspan::shade::{BLOCK, Block, Inputs, Shader, unorm8};
use hyperspan::target::Target;
use hyperspan::varying::CANONICAL_NAN;

use crate::aov::Aov;
use crate::failure::Failure;
use crate::flags::Crop;
use crate::memory;

/// The colour of a pixel, out of its attributes. Covered pixels are opaque.
pub(crate) trait Colour {
    /// How many attributes it reads: the first ones.
    const ATTRIBUTES: usize;

    /// Red, green and blue of `lane`.
    fn rgb(&self, attributes: &[[f32; BLOCK]], lane: usize) -> [f32; 3];

    /// RGBA8 of the lanes in `mask`, the others are anything: `rgb` rounded.
    #[inline]
    fn rgba8(&self, attributes: &[[f32; BLOCK]], _mask: u16, out: &mut [[u8; 4]; BLOCK]) {
        // All lanes: vectors are faster than branches.
        for (lane, pixel) in out.iter_mut().enumerate() {
            let [r, g, b] = self.rgb(attributes, lane).map(unorm8);
            *pixel = [r, g, b, 255];
        }
    }
}

/// Colours into a target of RGBA8.
#[derive(Debug)]
pub(crate) struct Picture<'a, C>(pub(crate) &'a C);

impl<C: Colour> Shader for Picture<'_, C> {
    type Pixel = [u8; 4];
    const INPUTS: Inputs = Inputs::attributes(C::ATTRIBUTES);

    #[inline]
    fn shade(&mut self, block: &Block<'_>, out: &mut [[u8; 4]; BLOCK]) -> u16 {
        self.0.rgba8(block.attributes, block.mask, out);
        block.mask
    }
}

/// Nothing but the depth test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coverage;

impl Shader for Coverage {
    type Pixel = ();
    const INPUTS: Inputs = Inputs::COVERAGE;

    #[inline]
    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        block.mask
    }
}

/// A target that stores nothing, but has a size: for shaders that store by themselves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// In pixels.
    pub(crate) width: u32,
    /// In pixels.
    pub(crate) height: u32,
}

impl Target for Extent {
    type Pixel = ();

    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    #[inline]
    fn write(&mut self, _x: u32, _y: u32, _run: &[()]) {}
}

/// The values of a plane, pixel after pixel.
#[derive(Debug)]
pub(crate) enum Values {
    /// Measures.
    Floats(Vec<f32>),
    /// Numbers and counts.
    Integers(Vec<u32>),
}

/// One kind of data, for all pixels of the crop.
#[derive(Debug)]
pub(crate) struct DataPlane {
    /// What it holds.
    pub(crate) aov: Aov,
    /// Values for each pixel.
    channels: usize,
    /// `channels` of them for each pixel, row 0 on top.
    pub(crate) values: Values,
}

impl DataPlane {
    fn new(aov: Aov, pixels: usize, attributes: usize) -> Result<Self, Failure> {
        let channels = aov.channels(attributes).unwrap_or(1);
        let count = pixels.saturating_mul(channels);
        let values = match aov {
            Aov::Id | Aov::Overdraw => Values::Integers(memory::filled(count, 0)?),
            _ => Values::Floats(memory::filled(count, 0.0)?),
        };
        Ok(Self { aov, channels, values })
    }

    fn clear(&mut self, depth: f32) {
        match (&mut self.values, self.aov) {
            (Values::Floats(values), Aov::Depth) => values.fill(depth),
            (Values::Floats(values), _) => values.fill(0.0),
            (Values::Integers(values), Aov::Id) => values.fill(u32::MAX),
            (Values::Integers(values), _) => values.fill(0),
        }
    }
}

/// What is to be drawn.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    /// The rectangle of the framebuffer.
    pub(crate) crop: Crop,
    /// Is a picture wanted, and on which background?
    pub(crate) picture: Option<[u8; 4]>,
    /// Is there a depth buffer?
    pub(crate) depth_buffer: bool,
    /// What depth is where nothing is drawn.
    pub(crate) clear_depth: f32,
    /// The data wanted; the same one twice is drawn once.
    pub(crate) aovs: &'a [Aov],
    /// Attributes of a polygon, for [`Aov::Attr`].
    pub(crate) attributes: usize,
}

/// All that a frame is drawn into: of the size of the crop, which begins at its first pixel.
#[derive(Debug)]
pub(crate) struct Canvas {
    /// Which part of the framebuffer this is.
    pub(crate) crop: Crop,
    background: [u8; 4],
    clear_depth: f32,
    /// RGBA8, or nothing if no picture is wanted.
    pub(crate) picture: Option<Vec<[u8; 4]>>,
    /// The depth buffer, or nothing if there is no test. It is the depth that is written to
    /// files too.
    pub(crate) depth: Option<Vec<f32>>,
    /// What [`Data`] fills.
    planes: Vec<DataPlane>,
    /// What the pass without depth test fills.
    overdraw: Option<DataPlane>,
}

impl Canvas {
    /// Memory for all of `plan`.
    pub(crate) fn new(plan: &Plan<'_>) -> Result<Self, Failure> {
        let crop = plan.crop;
        let pixels = crop.width as usize * crop.height as usize;
        let mut aovs = Vec::new();
        for aov in plan.aovs {
            if !aovs.contains(aov) {
                aovs.push(*aov);
            }
        }
        let values: usize =
            aovs.iter().map(|aov| aov.channels(plan.attributes).unwrap_or(1)).sum::<usize>()
                + usize::from(plan.picture.is_some())
                + usize::from(plan.depth_buffer);
        memory::check((pixels as u64).saturating_mul(values as u64).saturating_mul(4))?;

        // The depth buffer doubles as the data.
        aovs.retain(|aov| !(*aov == Aov::Depth && plan.depth_buffer));
        let (overdraw, shaded): (Vec<_>, Vec<_>) =
            aovs.into_iter().partition(|aov| *aov == Aov::Overdraw);
        let plane = |aov| DataPlane::new(aov, pixels, plan.attributes);
        Ok(Self {
            crop,
            background: plan.picture.unwrap_or_default(),
            clear_depth: plan.clear_depth,
            picture: plan.picture.map(|color| memory::filled(pixels, color)).transpose()?,
            depth: plan
                .depth_buffer
                .then(|| memory::filled(pixels, plan.clear_depth))
                .transpose()?,
            planes: shaded.into_iter().map(plane).collect::<Result<_, _>>()?,
            overdraw: overdraw.into_iter().map(plane).next().transpose()?,
        })
    }

    /// Makes it what it is before a frame.
    pub(crate) fn clear(&mut self) {
        if let Some(picture) = &mut self.picture {
            picture.fill(self.background);
        }
        if let Some(depth) = &mut self.depth {
            depth.fill(self.clear_depth);
        }
        for plane in self.planes.iter_mut().chain(&mut self.overdraw) {
            plane.clear(self.clear_depth);
        }
    }

    /// Must pixels go through [`Data`]?
    pub(crate) fn has_data(&self) -> bool {
        !self.planes.is_empty()
    }

    /// Does a pixel's colour matter?
    pub(crate) fn has_color(&self) -> bool {
        self.picture.is_some() || self.wants(Aov::Color)
    }

    /// Is `aov` among what [`Data`] fills?
    pub(crate) fn wants(&self, aov: Aov) -> bool {
        self.planes.iter().any(|plane| plane.aov == aov)
    }

    /// A target of the crop's size that stores nothing.
    pub(crate) fn extent(&self) -> Extent {
        Extent { width: self.crop.width, height: self.crop.height }
    }

    /// The depth buffer, and apart from it what the shader [`Data`] writes.
    pub(crate) fn split(&mut self) -> (Option<&mut Vec<f32>>, Planes<'_>) {
        let planes = Planes {
            crop: self.crop,
            picture: self.picture.as_deref_mut(),
            planes: &mut self.planes,
        };
        (self.depth.as_mut(), planes)
    }

    /// What counts how often each pixel is covered, if that is wanted. It goes with a pass
    /// without depth test.
    pub(crate) fn overdraw(&mut self) -> Option<Overdraw<'_>> {
        match &mut self.overdraw.as_mut()?.values {
            Values::Integers(counts) => Some(Overdraw { crop: self.crop, counts }),
            Values::Floats(_) => None,
        }
    }

    /// What was drawn of `aov`: values, and how many there are for each pixel. The depth
    /// buffer is asked too.
    pub(crate) fn data(&self, aov: Aov) -> Option<Drawn<'_>> {
        if let (Aov::Depth, Some(depth)) = (aov, &self.depth) {
            return Some(Drawn::Floats { values: depth, channels: 1 });
        }
        let plane = self.planes.iter().chain(&self.overdraw).find(|plane| plane.aov == aov)?;
        Some(match &plane.values {
            Values::Floats(values) => Drawn::Floats { values, channels: plane.channels },
            Values::Integers(values) => Drawn::Integers { values },
        })
    }
}

/// The values of one kind of data.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Drawn<'a> {
    /// `channels` for each pixel.
    Floats {
        /// Pixel after pixel.
        values: &'a [f32],
        /// Values for each pixel.
        channels: usize,
    },
    /// One for each pixel.
    Integers {
        /// Pixel after pixel.
        values: &'a [u32],
    },
}

/// What [`Data`] writes to.
#[derive(Debug)]
pub(crate) struct Planes<'a> {
    crop: Crop,
    /// RGBA8, if a picture is wanted.
    pub(crate) picture: Option<&'a mut [[u8; 4]]>,
    planes: &'a mut [DataPlane],
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

/// Writes all planes of data, and the picture if there is one.
#[derive(Debug)]
pub(crate) struct Data<'a, C> {
    /// Where colours come from.
    pub(crate) colour: &'a C,
    /// Where the other attributes are.
    pub(crate) layout: Layout,
    /// The polygon's number.
    pub(crate) id: u32,
    /// Where it all goes.
    pub(crate) planes: Planes<'a>,
}

impl<C: Colour> Shader for Data<'_, C> {
    type Pixel = ();

    #[inline]
    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        let crop = self.planes.crop;
        let Some(start) = crop.block_start(block) else { return 0 };
        if let Some(picture) = &mut self.planes.picture {
            let mut rgba = [[0; 4]; BLOCK];
            self.colour.rgba8(block.attributes, block.mask, &mut rgba);
            for lane in lanes(block.mask) {
                picture[start.index(lane)] = rgba[lane];
            }
        }
        for plane in self.planes.planes.iter_mut() {
            match &mut plane.values {
                Values::Integers(values) => {
                    for lane in lanes(block.mask) {
                        values[start.index(lane)] = self.id;
                    }
                }
                Values::Floats(values) => {
                    let n = plane.channels;
                    for lane in lanes(block.mask) {
                        let i = start.index(lane) * n;
                        let pixel = &mut values[i..i + n];
                        match plane.aov {
                            Aov::Depth => pixel[0] = block.depth[lane],
                            Aov::W => pixel[0] = block.w[lane],
                            Aov::Color => {
                                let [r, g, b] = self.colour.rgb(block.attributes, lane);
                                pixel.copy_from_slice(&[r, g, b, 1.0].map(canonical));
                            }
                            Aov::Uv => gather(pixel, self.layout.uv, block, lane),
                            Aov::Normal => gather(pixel, self.layout.normal, block, lane),
                            Aov::Position => gather(pixel, self.layout.position, block, lane),
                            Aov::Attr => gather(pixel, Some(0), block, lane),
                            Aov::Id | Aov::Overdraw => {}
                        }
                    }
                }
            }
        }
        block.mask
    }
}

/// Counts how often each pixel is covered.
#[derive(Debug)]
pub(crate) struct Overdraw<'a> {
    crop: Crop,
    counts: &'a mut [u32],
}

impl Shader for Overdraw<'_> {
    type Pixel = ();
    const INPUTS: Inputs = Inputs::COVERAGE;

    #[inline]
    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        let Some(start) = self.crop.block_start(block) else { return 0 };
        for lane in lanes(block.mask) {
            let count = &mut self.counts[start.index(lane)];
            *count = count.saturating_add(1);
        }
        block.mask
    }
}

/// Where a block's pixels are in a plane of the crop's size. Lane 0 may lie left of it.
#[derive(Clone, Copy, Debug)]
struct BlockStart {
    row: usize,
    column: isize,
}

impl BlockStart {
    /// The place of `lane`, which lies in the crop.
    #[inline]
    fn index(self, lane: usize) -> usize {
        self.row + self.column.saturating_add_unsigned(lane).unsigned_abs()
    }
}

impl Crop {
    /// Where `block` begins; nothing for a row that is not in the crop.
    #[inline]
    fn block_start(self, block: &Block<'_>) -> Option<BlockStart> {
        let row = u32::try_from(block.y).ok()?.checked_sub(self.y)?;
        let column = isize::try_from(i64::from(block.x) - i64::from(self.x)).ok()?;
        Some(BlockStart { row: row as usize * self.width as usize, column })
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

/// The attributes from `first` on of one pixel; 0 for what the polygon has not.
#[inline]
fn gather(pixel: &mut [f32], first: Option<usize>, block: &Block<'_>, lane: usize) {
    match first.and_then(|first| block.attributes.get(first..first + pixel.len())) {
        Some(attributes) => {
            for (to, from) in pixel.iter_mut().zip(attributes) {
                *to = from[lane];
            }
        }
        None => pixel.fill(0.0),
    }
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
