//! The product's own code, as a user calls it.

use hyperspan::depth::DepthTest;
use hyperspan::polygon::Strided;
use hyperspan::shade::Shader;
use hyperspan::simd::Simd;
use hyperspan::space::Viewport;
use hyperspan::target::{DepthBuffer, Target};
use hyperspan::tiler::{Precision, Tiler};

use crate::bench::scenes::Facet;

/// A tiler.
#[derive(Debug)]
pub(crate) struct Product {
    tiler: Tiler,
}

impl Product {
    /// For pictures of `viewport`.
    pub(crate) fn new(viewport: Viewport, simd: Simd) -> Self {
        let mut tiler = Tiler::new(viewport);
        tiler.set_simd(simd).set_depth_test(DepthTest::STANDARD);
        Self { tiler }
    }

    /// Draws `facet`, whose vertices have `stride` attributes.
    pub(crate) fn draw<S: Shader, T: Target<Pixel = S::Pixel>>(
        &mut self,
        precision: Precision,
        facet: &Facet,
        stride: usize,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) {
        let polygon = Strided::new(&facet.positions, &facet.attributes, stride, stride);
        if let Ok(polygon) = polygon {
            self.tiler.set_precision(precision).draw(&polygon, shader, target, depth);
        }
    }
}
