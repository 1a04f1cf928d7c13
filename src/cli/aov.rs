//! The data that can be asked for beside the picture ("arbitrary output variables"): their
//! names, and what `--aov NAME=FILE` means. How they are filled is in `canvas.rs`.

use std::path::PathBuf;

/// A kind of data, one value or several for each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Aov {
    /// Framebuffer depth.
    Depth,
    /// Clip-space w: the distance along the view axis.
    W,
    /// Number of the polygon, in file order.
    Id,
    /// How often the pixel was covered, hidden or not.
    Overdraw,
    /// Texture coordinates as in the file.
    Uv,
    /// The normal, interpolated and not normalised.
    Normal,
    /// World position.
    Position,
    /// Colour before it is rounded to 8 bits.
    Color,
    /// All attributes of a `.poly` file.
    Attr,
}

impl Aov {
    /// What `render` can give.
    pub(crate) const RENDER: [Self; 8] = [
        Self::Depth,
        Self::W,
        Self::Id,
        Self::Overdraw,
        Self::Uv,
        Self::Normal,
        Self::Position,
        Self::Color,
    ];
    /// What `tile` can give.
    pub(crate) const TILE: [Self; 6] =
        [Self::Depth, Self::W, Self::Id, Self::Overdraw, Self::Color, Self::Attr];

    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::W => "w",
            Self::Id => "id",
            Self::Overdraw => "overdraw",
            Self::Uv => "uv",
            Self::Normal => "normal",
            Self::Position => "position",
            Self::Color => "color",
            Self::Attr => "attr",
        }
    }

    /// Values for each pixel, if it has an axis of its own in the file; `attributes` is how
    /// many the polygons have.
    pub(crate) fn channels(self, attributes: usize) -> Option<usize> {
        match self {
            Self::Depth | Self::W | Self::Id | Self::Overdraw => None,
            Self::Uv => Some(2),
            Self::Normal | Self::Position => Some(3),
            Self::Color => Some(4),
            Self::Attr => Some(attributes),
        }
    }
}

/// How a file of data is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Exact values.
    Npy,
    /// For looking at.
    Png,
}

/// One `--aov`.
#[derive(Clone, Debug)]
pub(crate) struct Request {
    /// What.
    pub(crate) aov: Aov,
    /// Into which file.
    pub(crate) path: PathBuf,
    /// In which format.
    pub(crate) format: Format,
}

/// Reads `NAME=FILE`, where NAME is one of `render`'s.
pub(crate) fn render_request(text: &str) -> Result<Request, String> {
    request(text, &Aov::RENDER)
}

/// Reads `NAME=FILE`, where NAME is one of `tile`'s.
pub(crate) fn tile_request(text: &str) -> Result<Request, String> {
    request(text, &Aov::TILE)
}

fn request(text: &str, allowed: &[Aov]) -> Result<Request, String> {
    let names = || allowed.iter().map(|aov| aov.name()).collect::<Vec<_>>().join(", ");
    let Some((name, file)) = text.split_once('=') else {
        return Err(format!("give NAME=FILE, NAME one of {}", names()));
    };
    let Some(&aov) = allowed.iter().find(|aov| aov.name() == name) else {
        return Err(format!("there is no `{name}` here; choose one of {}", names()));
    };
    let path = PathBuf::from(file);
    let is = |wanted| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(wanted));
    let format = if is("npy") {
        Format::Npy
    } else if is("png") {
        Format::Png
    } else {
        return Err("FILE must end in .npy (exact values) or .png (for looking at)".to_owned());
    };
    Ok(Request { aov, path, format })
}
