//! What a checked constructor refuses, and what to do about it.

use core::fmt;

/// Why a constructor refused its arguments. The text says what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// A viewport side is longer than [`Viewport::MAX_SIDE`](crate::space::Viewport::MAX_SIDE).
    ViewportTooLarge {
        /// The width asked for, in pixels.
        width: u32,
        /// The height asked for, in pixels.
        height: u32,
    },
    /// A plane's rows do not fit into the slice that was lent to it.
    PlaneTooShort {
        /// Elements that the rows need.
        needed: usize,
        /// Elements of the slice.
        given: usize,
    },
    /// A stride is smaller than the row it steps over.
    StrideTooSmall {
        /// The least stride that would do, in elements.
        needed: usize,
        /// The stride given, in elements.
        given: usize,
    },
    /// There are fewer attributes than the vertices need.
    AttributesTooShort {
        /// Values that the vertices need.
        needed: usize,
        /// Values of the slice.
        given: usize,
    },
    /// An index names a vertex that is not there.
    IndexOutOfRange {
        /// Where in the list of indices.
        at: usize,
        /// The index.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A texture has no texels, or not as many as its sides say.
    TextureSize {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
        /// Texels given.
        given: usize,
    },
    /// There is no memory for what was asked for.
    OutOfMemory {
        /// Bytes that it needs.
        bytes: usize,
    },
    /// A camera's parameters span no view volume (equal sides, a field of view that is not
    /// between 0 and 180 degrees, a near plane behind the eye, a direction of length 0).
    Camera(&'static str),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ViewportTooLarge { width, height } => write!(
                f,
                "a viewport of {width} x {height} pixels is too large: \
                 its sides may be 16384 at most; draw the picture in parts"
            ),
            Self::PlaneTooShort { needed, given } => write!(
                f,
                "the rows need {needed} elements, but the slice has {given}: lend a longer slice"
            ),
            Self::StrideTooSmall { needed, given } => write!(
                f,
                "a stride of {given} elements is smaller than a row of {needed}: rows would overlap"
            ),
            Self::AttributesTooShort { needed, given } => {
                write!(f, "the vertices need {needed} attribute values, but the slice has {given}")
            }
            Self::IndexOutOfRange { at, index, vertices } => {
                write!(
                    f,
                    "index {index} (number {at} of the list) is beyond the {vertices} vertices"
                )
            }
            Self::TextureSize { width, height, given } => write!(
                f,
                "a texture of {width} x {height} needs as many texels, at least one, \
                 and fewer than 2^31; {given} were given"
            ),
            Self::OutOfMemory { bytes } => {
                write!(f, "there is no memory for {bytes} bytes: draw the picture in parts")
            }
            Self::Camera(why) => write!(f, "this camera sees nothing: {why}"),
        }
    }
}

impl core::error::Error for Error {}
