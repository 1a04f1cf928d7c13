//! Clip space, the framebuffer, and the viewport between them.
//!
//! ```text
//! clip space (x, y, z, w)            framebuffer (pixels)
//!   -w <= x, y <= w     --viewport->   +--------> x      pixel (c, r) has its
//!    0 <= z <= w, 0 < w                |                 centre at (c + 1/2, r + 1/2)
//!    y up                              v y
//! ```

use core::ops::{Add, Mul};

use crate::error::Error;

/// A position in clip space as an array (x, y, z, w): anything that can be widened to `f64`
/// without loss.
///
/// Hand on `f64` where you have it: a clip position rounded to `f32` is worth less than the
/// subpixel grid.
pub trait ClipPosition: Copy {
    /// (x, y, z, w).
    fn to_clip(self) -> [f64; 4];
}

impl ClipPosition for [f64; 4] {
    #[inline]
    fn to_clip(self) -> [f64; 4] {
        self
    }
}

impl ClipPosition for [f32; 4] {
    #[inline]
    fn to_clip(self) -> [f64; 4] {
        self.map(f64::from)
    }
}

impl ClipPosition for glam::DVec4 {
    #[inline]
    fn to_clip(self) -> [f64; 4] {
        self.to_array()
    }
}

impl ClipPosition for glam::Vec4 {
    #[inline]
    fn to_clip(self) -> [f64; 4] {
        self.to_array().map(f64::from)
    }
}

/// The range of z in the view volume, before division, and so what depth is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthRange {
    /// 0 <= z <= w (Direct3D, Vulkan, Metal, WebGPU): depth is z/w.
    #[default]
    ZeroToOne,
    /// -w <= z <= w (OpenGL): depth is (z/w + 1)/2.
    MinusOneToOne,
}

impl DepthRange {
    /// What over w is depth.
    #[inline(always)]
    pub(crate) fn numerator<F>(self, [_, _, z, w]: [F; 4]) -> F
    where
        F: Add<Output = F> + Mul<f64, Output = F>,
    {
        match self {
            Self::ZeroToOne => z,
            Self::MinusOneToOne => (z + w) * 0.5,
        }
    }
}

/// The subpixel grid that vertices are snapped to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Grid {
    /// 16 fraction bits: 1/65536 of a pixel.
    #[default]
    Sixteen,
    /// 8 fraction bits, as Direct3D 11 asks for: 1/256 of a pixel.
    Eight,
}

impl Grid {
    /// How many positions of the grid lie within a pixel's side.
    pub(crate) const fn steps_per_pixel(self) -> u32 {
        match self {
            Self::Sixteen => 1 << 16,
            Self::Eight => 1 << 8,
        }
    }

    /// How far a covered centre can lie outside of the unsnapped polygon, in pixels along
    /// either axis: twice what rounding to the grid moves a vertex, and room.
    pub(crate) fn snap_reach(self) -> f64 {
        2.0 / f64::from(self.steps_per_pixel())
    }
}

/// A rectangle of pixels in the framebuffer: columns `x0..x1`, rows `y0..y1`, half-open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PixelRect {
    /// First column.
    pub x0: i32,
    /// First row.
    pub y0: i32,
    /// Column after the last.
    pub x1: i32,
    /// Row after the last.
    pub y1: i32,
}

impl PixelRect {
    /// How many pixels there are.
    pub fn area(self) -> u64 {
        if self.is_empty() {
            return 0;
        }
        u64::from(self.x0.abs_diff(self.x1)) * u64::from(self.y0.abs_diff(self.y1))
    }

    /// The rectangle of `width` x `height` pixels whose first pixel is (`x`, `y`); sides that
    /// would leave the range of `i32` end there.
    #[inline(always)]
    pub fn new(x: i32, y: i32, width: u32, height: u32) -> Self {
        Self {
            x0: x,
            y0: y,
            x1: x.saturating_add_unsigned(width),
            y1: y.saturating_add_unsigned(height),
        }
    }

    /// What both have in common; empty if nothing.
    #[inline(always)]
    pub fn intersect(self, other: Self) -> Self {
        let (x0, y0) = (self.x0.max(other.x0), self.y0.max(other.y0));
        Self { x0, y0, x1: self.x1.min(other.x1).max(x0), y1: self.y1.min(other.y1).max(y0) }
    }

    /// Has it all that `other` has?
    #[inline(always)]
    pub fn contains(self, other: Self) -> bool {
        self.x0 <= other.x0 && other.x1 <= self.x1 && self.y0 <= other.y0 && other.y1 <= self.y1
    }

    /// Has it no pixel?
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }
}

/// The map from clip space to the framebuffer: a rectangle of pixels, which may be larger than
/// the target or lie beyond it (Blinn's off-screen viewport). Nothing is drawn outside it.
///
/// A clip position goes to x/w (W/2) + (x + W/2), (y + H/2) - y/w (H/2), in `f64`, in this
/// order, and is then snapped to the [`Grid`], round to nearest even.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Viewport {
    rect: PixelRect,
    width: u32,
    height: u32,
    grid: Grid,
    depth_range: DepthRange,
}

impl Viewport {
    /// The longest side, in pixels.
    pub const MAX_SIDE: u32 = 16384;

    /// The viewport of `width` x `height` pixels whose upper left corner is at framebuffer
    /// (`x`, `y`); the n.16 grid and 0 <= z <= w. A side of 0 is allowed and shows nothing.
    ///
    /// # Errors
    /// [`Error::ViewportTooLarge`] for a side above [`Self::MAX_SIDE`].
    pub fn new(x: i32, y: i32, width: u32, height: u32) -> Result<Self, Error> {
        if width > Self::MAX_SIDE || height > Self::MAX_SIDE {
            return Err(Error::ViewportTooLarge { width, height });
        }
        let rect = PixelRect::new(x, y, width, height);
        Ok(Self { rect, width, height, grid: Grid::Sixteen, depth_range: DepthRange::ZeroToOne })
    }

    /// The same rectangle with another subpixel grid.
    #[must_use]
    pub fn with_grid(self, grid: Grid) -> Self {
        Self { grid, ..self }
    }

    /// The same rectangle with another range of z.
    #[must_use]
    pub fn with_depth_range(self, depth_range: DepthRange) -> Self {
        Self { depth_range, ..self }
    }

    /// The pixels it shows, cut at the range of `i32`.
    pub fn rect(self) -> PixelRect {
        self.rect
    }

    /// Width W in pixels.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Height H in pixels.
    pub fn height(self) -> u32 {
        self.height
    }

    /// The subpixel grid.
    pub fn grid(self) -> Grid {
        self.grid
    }

    /// The range of z.
    pub fn depth_range(self) -> DepthRange {
        self.depth_range
    }

    /// (W/2, H/2) in pixels: exact.
    pub(crate) fn half_size(self) -> [f64; 2] {
        [f64::from(self.width) / 2.0, f64::from(self.height) / 2.0]
    }

    /// The centre (x + W/2, y + H/2) in framebuffer pixels: exact.
    pub(crate) fn centre(self) -> [f64; 2] {
        let half = self.half_size();
        [f64::from(self.rect.x0) + half[0], f64::from(self.rect.y0) + half[1]]
    }
}
