//! Shaders: what turns a pixel's interpolated values into what is stored.
//!
//! A closure over a [`Fragment`] is a shader; who wants speed implements [`Shader`] on a type of
//! his own and gets [`Block`]s of 16 pixels, as structure of arrays. Both are compiled into the
//! loop: there is no call per pixel.

/// Pixels in a block.
pub const BLOCK: usize = 16;

/// Blocks that are shaded together where all of their lanes are drawn.
pub const ROW: usize = 4;

/// Which of a block's values a shader reads; what it does not read is not computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inputs {
    /// [`Block::depth`].
    pub depth: bool,
    /// [`Block::inv_w`].
    pub inv_w: bool,
    /// [`Block::w`].
    pub w: bool,
    /// The first so many attributes.
    pub attributes: usize,
}

impl Inputs {
    /// Everything.
    pub const ALL: Self = Self { depth: true, inv_w: true, w: true, attributes: usize::MAX };
    /// Nothing but which pixels are covered.
    pub const COVERAGE: Self = Self { depth: false, inv_w: false, w: false, attributes: 0 };
    /// The first `n` attributes.
    pub const fn attributes(n: usize) -> Self {
        Self { attributes: n, ..Self::COVERAGE }
    }
}

/// 16 pixels: of one row, or whole rows of a small rectangle, one after the other. Lanes whose bit is not set in `mask` hold unspecified finite or
/// non-finite numbers; so does what [`Shader::INPUTS`] does not ask for.
#[derive(Debug)]
pub struct Block<'a> {
    /// Framebuffer column and row of lane 0.
    pub first: [i32; 2],
    /// Lane `i` is `i % columns` columns to the right of lane 0 and `i / columns` rows below it:
    /// 1 to 16.
    pub columns: u16,
    /// Bit `i`: lane `i` is covered and passed the depth test.
    pub mask: u16,
    /// z/w in 0..=1; see [`DepthRange`](crate::space::DepthRange).
    pub depth: &'a [f32; BLOCK],
    /// 1/w.
    pub inv_w: &'a [f32; BLOCK],
    /// w: with a perspective camera the distance along the view axis.
    pub w: &'a [f32; BLOCK],
    /// The attributes, one array of 16 lanes for each.
    pub attributes: &'a [[f32; BLOCK]],
}

impl Block<'_> {
    /// Framebuffer column of lane `lane`.
    #[inline]
    pub fn x(&self, lane: u16) -> i32 {
        self.first[0].wrapping_add(i32::from(lane % self.columns))
    }

    /// Framebuffer row of lane `lane`.
    #[inline]
    pub fn y(&self, lane: u16) -> i32 {
        self.first[1].wrapping_add(i32::from(lane / self.columns))
    }
}

/// One pixel, as a closure sees it.
#[derive(Clone, Copy, Debug)]
pub struct Fragment<'a> {
    block: &'a Block<'a>,
    lane: u16,
}

impl Fragment<'_> {
    /// Framebuffer column.
    #[inline]
    pub fn x(&self) -> i32 {
        self.block.x(self.lane)
    }

    /// Framebuffer row.
    #[inline]
    pub fn y(&self) -> i32 {
        self.block.y(self.lane)
    }

    /// z/w in 0..=1; see [`DepthRange`](crate::space::DepthRange).
    #[inline]
    pub fn depth(&self) -> f32 {
        self.block.depth[usize::from(self.lane)]
    }

    /// 1/w.
    #[inline]
    pub fn inv_w(&self) -> f32 {
        self.block.inv_w[usize::from(self.lane)]
    }

    /// w: with a perspective camera the distance along the view axis.
    #[inline]
    pub fn w(&self) -> f32 {
        self.block.w[usize::from(self.lane)]
    }

    /// Attribute `k`; NaN for one that the polygon does not have.
    #[inline]
    pub fn attribute(&self, k: usize) -> f32 {
        let lanes = self.block.attributes.get(k);
        lanes.map_or(crate::varying::CANONICAL_NAN, |lanes| lanes[usize::from(self.lane)])
    }

    /// The number of attributes.
    #[inline]
    pub fn attribute_count(&self) -> usize {
        self.block.attributes.len()
    }
}

/// Turns blocks of 16 pixels into what a target stores.
pub trait Shader {
    /// What it makes of a pixel; see [`Target::Pixel`](crate::target::Target::Pixel).
    type Pixel: Copy + Default + 'static;

    /// What it reads.
    const INPUTS: Inputs = Inputs::ALL;

    /// Does it set every lane that is set in `block.mask`, and never discard one? Then what
    /// [`shade`](Self::shade) returns is not looked at, and whole blocks are shaded straight into
    /// the target's rows.
    const KEEPS_ALL: bool = false;

    /// Polygon `_i` of a [`Batch`](crate::batch::Batch) comes next: for shaders that differ from
    /// polygon to polygon, as by an id. Bands are drawn one by one, so that a polygon may come
    /// several times.
    #[inline(always)]
    fn start(&mut self, _i: usize) {}

    /// Shades the lanes that are set in `block.mask` into `out`, which holds any pixels before, and
    /// returns the mask of those to keep: a lane that is left out is discarded, with its depth.
    /// Bits beyond `block.mask` are ignored. Say `#[inline(always)]`: then it is compiled for the instruction set that
    /// the tiler runs on.
    fn shade(&mut self, block: &Block<'_>, out: &mut [Self::Pixel; BLOCK]) -> u16;

    /// Shades all lanes of `blocks`, which lie side by side in a row: the same pixels that
    /// [`shade`](Self::shade) makes of one after the other. It is asked for if
    /// [`KEEPS_ALL`](Self::KEEPS_ALL), and worth writing where something can be done once for all of them.
    #[inline(always)]
    fn shade_row(&mut self, blocks: &[Block<'_>; ROW], out: &mut [[Self::Pixel; BLOCK]; ROW]) {
        for (block, out) in blocks.iter().zip(out) {
            self.shade(block, out);
        }
    }
}

/// A closure that is called for each pixel that passes. Everything that a [`Fragment`] has is found
/// for it; see [`Attributes`] for less.
impl<P: Copy + Default + 'static, F: FnMut(&Fragment<'_>) -> P> Shader for F {
    type Pixel = P;
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [P; BLOCK]) -> u16 {
        each_lane(self, block, out)
    }
}

/// A closure that reads where a pixel is and its first `N` attributes, and nothing else: depth, w and
/// 1/w, which are unspecified, are not found for it, nor further attributes, which are NaN.
///
/// ```
/// use hyperspan::shade::{Attributes, unorm8};
///
/// let grey = Attributes::<1, _>(|pixel: &hyperspan::Fragment<'_>| unorm8(pixel.attribute(0)));
/// # fn is_shader(_: impl hyperspan::Shader<Pixel = u8>) {}
/// # is_shader(grey);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Attributes<const N: usize, F>(pub F);

impl<const N: usize, P, F> Shader for Attributes<N, F>
where
    P: Copy + Default + 'static,
    F: FnMut(&Fragment<'_>) -> P,
{
    type Pixel = P;
    const INPUTS: Inputs = Inputs::attributes(N);
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [P; BLOCK]) -> u16 {
        each_lane(&mut self.0, block, out)
    }
}

/// Calls `closure` for the lanes of `block` that are set.
#[inline(always)]
fn each_lane<P>(
    closure: &mut impl FnMut(&Fragment<'_>) -> P,
    block: &Block<'_>,
    out: &mut [P; BLOCK],
) -> u16 {
    if block.mask == u16::MAX {
        // Without a look at the mask, lanes may become vectors.
        for (lane, out) in (0..).zip(out) {
            *out = closure(&Fragment { block, lane });
        }
        return block.mask;
    }
    let mut left = block.mask;
    while left != 0 {
        let lane = left.trailing_zeros() as u16;
        left &= left - 1;
        out[usize::from(lane)] = closure(&Fragment { block, lane });
    }
    block.mask
}

/// The same pixel all over: a colour, or an id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Solid<P>(pub P);

impl<P: Copy + Default + 'static> Shader for Solid<P> {
    type Pixel = P;
    const INPUTS: Inputs = Inputs::COVERAGE;
    const KEEPS_ALL: bool = true;

    #[inline(always)]
    fn shade(&mut self, block: &Block<'_>, out: &mut [P; BLOCK]) -> u16 {
        out.fill(self.0);
        block.mask
    }
}

/// 255 `value`, clamped to 0..=255, rounded half to even; NaN is 0.
#[inline(always)]
pub fn unorm8(value: f32) -> u8 {
    // Not `clamp`: a NaN must become 0. The sum rounds to a whole number, half to even.
    const WHOLE: f32 = 8_388_608.0;
    let scaled = 255.0 * value;
    let scaled = if scaled > 0.0 { scaled } else { 0.0 };
    let scaled = if scaled < 255.0 { scaled } else { 255.0 };
    // Its low bits are that number.
    #[expect(clippy::cast_possible_truncation, reason = "0..=255")]
    let whole = (scaled + WHOLE).to_bits() as u8;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_round_half_to_even() {
        assert_eq!(
            [f32::NAN, -1.0, -0.0, 0.0, 1.0, 2.0, f32::INFINITY].map(unorm8),
            [0, 0, 0, 0, 255, 255, 255]
        );
        assert_eq!(
            [0.5 / 255.0, 1.5 / 255.0, 2.5 / 255.0].map(|c: f32| (255.0 * c, unorm8(c)).1),
            [0, 2, 2]
        );
        for byte in 0..=255_u8 {
            assert_eq!(unorm8(f32::from(byte) / 255.0), byte);
        }
    }
}
