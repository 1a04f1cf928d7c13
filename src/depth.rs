//! The depth test: what a pixel's depth is compared with, and how.

mod bounds;
mod occluders;
mod unclear;

pub use bounds::DepthBounds;
pub(crate) use bounds::{SIDE, TileRows};
pub(crate) use occluders::Occluders;
pub(crate) use unclear::Unclear;

/// How a pixel's depth is compared with the stored one; it passes if `new (op) stored` holds.
/// A NaN in the buffer passes only [`NotEqual`](Self::NotEqual) and [`Always`](Self::Always).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Compare {
    /// Nothing passes.
    Never,
    /// new < stored. With depth cleared to 1: the usual test of "standard" depth.
    Less,
    /// new == stored.
    Equal,
    /// new <= stored.
    LessEqual,
    /// new > stored. With depth cleared to 0: the usual test of reversed depth.
    Greater,
    /// new != stored.
    NotEqual,
    /// new >= stored.
    GreaterEqual,
    /// Everything passes.
    Always,
}

impl Compare {
    /// Does `new` pass against `stored`?
    #[inline]
    pub fn passes(self, new: f32, stored: f32) -> bool {
        match self {
            Self::Never => false,
            Self::Less => new < stored,
            Self::Equal => new == stored,
            Self::LessEqual => new <= stored,
            Self::Greater => new > stored,
            Self::NotEqual => new != stored,
            Self::GreaterEqual => new >= stored,
            Self::Always => true,
        }
    }

    /// Do all depths within `new` fail against all within `stored`, and against NaN? Both are a
    /// least and a greatest.
    #[inline(always)]
    pub(crate) fn fails_all(self, new: [f32; 2], stored: [f32; 2]) -> bool {
        match self {
            Self::Never => true,
            Self::Less => new[0] >= stored[1],
            Self::LessEqual => new[0] > stored[1],
            Self::Greater => new[1] <= stored[0],
            Self::GreaterEqual => new[1] < stored[0],
            Self::Equal => new[0] > stored[1] || new[1] < stored[0],
            Self::NotEqual | Self::Always => false,
        }
    }

    /// Do all depths within `new` pass against `stored`?
    pub(crate) fn passes_all(self, new: [f32; 2], stored: f32) -> bool {
        match self {
            Self::Always => true,
            Self::NotEqual => new[1] < stored || new[0] > stored,
            // What passes at both ends passes between them.
            _ => new.iter().all(|new| self.passes(*new, stored)),
        }
    }

    /// Might they, if `stored` could be narrower than it is?
    #[inline(always)]
    pub(crate) fn may_fail_all(self, new: [f32; 2], stored: [f32; 2]) -> bool {
        match self {
            Self::Less | Self::LessEqual => new[0] >= stored[0],
            Self::Greater | Self::GreaterEqual => new[1] <= stored[1],
            Self::Never | Self::Equal => true,
            Self::NotEqual | Self::Always => false,
        }
    }

    /// May what passes be below the stored depth that it replaces?
    #[inline(always)]
    pub(crate) fn lowers(self) -> bool {
        matches!(self, Self::Less | Self::LessEqual | Self::NotEqual | Self::Always)
    }

    /// And above?
    #[inline(always)]
    pub(crate) fn raises(self) -> bool {
        matches!(self, Self::Greater | Self::GreaterEqual | Self::NotEqual | Self::Always)
    }
}

/// What is stored and compared as depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthSource {
    /// z/w (or (z/w + 1)/2, see [`DepthRange`](crate::space::DepthRange)), in 0..=1.
    #[default]
    Z,
    /// 1/w: larger is nearer. It is interpolated anyway, so no z is set up at all.
    InvW,
}

/// The depth test of a draw call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DepthTest {
    /// What passes.
    pub compare: Compare,
    /// Is the depth of a pixel that passes (and that the shader keeps) stored?
    pub write: bool,
    /// What depth is.
    pub source: DepthSource,
}

impl DepthTest {
    /// Near is 0, clear to 1, nearer wins, equal keeps the first.
    pub const STANDARD: Self = Self { compare: Compare::Less, write: true, source: DepthSource::Z };
    /// Near is 1, clear to 0, nearer wins, equal keeps the first.
    pub const REVERSED: Self =
        Self { compare: Compare::Greater, write: true, source: DepthSource::Z };
    /// Depth is 1/w, clear to 0, nearer wins, equal keeps the first.
    pub const INV_W: Self =
        Self { compare: Compare::Greater, write: true, source: DepthSource::InvW };
}
