//! What is set of a tiler, and what it has counted.

use super::Tiler;
use crate::clip::ClipPlane;
use crate::depth::DepthTest;
use crate::simd::Simd;
use crate::space::Viewport;
use crate::stats::Stats;
use crate::varying::Interpolation;

/// Which polygons are left out for the way they face. Front faces are counter-clockwise with
/// y up; a snapped area of 0 faces back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cull {
    /// All are drawn.
    #[default]
    None,
    /// Back faces are left out.
    Back,
    /// Front faces are left out.
    Front,
}

impl Cull {
    /// Is a polygon drawn that faces the front, or not?
    #[inline(always)]
    pub(super) fn keeps(self, front: bool) -> bool {
        match self {
            Self::None => true,
            Self::Back => front,
            Self::Front => !front,
        }
    }
}

/// How good attributes are; see docs/precision.md.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// Within 4u |value| + 3u M of the right value, where u is 2^-24 and M the attribute's largest
    /// magnitude at the vertices; depth within an ulp.
    #[default]
    Fast,
    /// Correctly rounded: at most half an ulp off.
    Exact,
}

impl Tiler {
    /// The framebuffer position of the target's first pixel: (0, 0) unless set. A target that
    /// is a crop of the picture has the bytes of that part of the whole.
    pub fn set_origin(&mut self, x: i32, y: i32) -> &mut Self {
        self.origin = [x, y];
        self
    }

    /// The depth test of the calls of [`draw`](Self::draw) that have a depth buffer.
    pub fn set_depth_test(&mut self, test: DepthTest) -> &mut Self {
        self.depth_test = test;
        self
    }

    /// Which faces are left out.
    pub fn set_cull(&mut self, cull: Cull) -> &mut Self {
        self.cull = cull;
        self
    }

    /// How good attributes are.
    pub fn set_precision(&mut self, precision: Precision) -> &mut Self {
        self.precision = precision;
        self
    }

    /// How attribute 0, 1, ... is interpolated; those beyond the list have perspective.
    pub fn set_interpolation(&mut self, interpolation: &[Interpolation]) -> &mut Self {
        self.interpolation.clear();
        self.interpolation.extend_from_slice(interpolation);
        self.all_perspective = interpolation.iter().all(|i| *i == Interpolation::Perspective);
        self
    }

    /// Planes to clip against beside the view volume's: any number. With planes +d and -d the
    /// two parts of a polygon cover each of its pixels exactly once.
    pub fn set_clip_planes(&mut self, planes: &[ClipPlane]) -> &mut Self {
        self.clipper.set_user_planes(planes);
        self
    }

    /// Which of the machine's instruction sets to use; the widest unless set. No bit depends on
    /// it.
    pub fn set_simd(&mut self, simd: Simd) -> &mut Self {
        self.simd = simd;
        self
    }

    /// Is what is surely hidden left out before it is set up, where the depth buffer has bounds
    /// ([`DepthBuffer::with_bounds`](crate::target::Plane::with_bounds)), and what a draw list covers not even
    /// cleared ([`Canvas::clear_later`](crate::draw::Canvas::clear_later))? It is unless set; no byte depends on
    /// it.
    pub fn set_hidden_skips(&mut self, skip: bool) -> &mut Self {
        self.hides = skip;
        self
    }

    /// Is what is hidden left out?
    pub(crate) fn skips_hidden(&self) -> bool {
        self.hides
    }

    /// Counts since the tiler was made or since [`reset_stats`](Self::reset_stats).
    pub fn stats(&self) -> Stats {
        // Buffers never shrink: what they hold now is the most they held.
        Stats { peak_bytes: self.bytes() as u64, ..self.stats }
    }

    /// The depth test of what has a depth buffer.
    pub(crate) fn depth_test(&self) -> DepthTest {
        self.depth_test
    }

    /// The counts, to be changed.
    #[inline(always)]
    pub(crate) fn stats_mut(&mut self) -> &mut Stats {
        &mut self.stats
    }

    /// Which instruction set is used.
    #[inline(always)]
    pub(crate) fn simd(&self) -> Simd {
        self.simd
    }

    /// What the framebuffer is drawn from.
    pub(crate) fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// The framebuffer position of the target's first pixel.
    pub(crate) fn origin(&self) -> [i32; 2] {
        self.origin
    }

    /// Sets the counts to 0.
    pub fn reset_stats(&mut self) {
        self.stats = Stats::default();
    }

    /// Takes over all that is set of `other`.
    pub(crate) fn set_as(&mut self, other: &Self) {
        self.viewport = other.viewport;
        self.depth_test = other.depth_test;
        self.cull = other.cull;
        self.precision = other.precision;
        self.set_interpolation(&other.interpolation);
        self.clipper.set_as(&other.clipper);
        self.place_constants = other.place_constants;
        self.simd = other.simd;
        self.hides = other.hides;
    }
}
