//! The rungs: complete ways of interpolating along spans, from the crudest to the most exact.
//!
//! All draw the same polygons with the same shaders into the same targets. `fast` and `exact` are
//! the product's, called as a user calls it. The others take their spans from the library's
//! public stages ([`prepare`]), find their functions in plain `f64`, and share one loop ([`walk`]);
//! they are vectorised as the product is, and are no part of it.

mod affine;
mod inverse;
mod knots;
mod lanes;
mod prepare;
mod product;
mod quadratic;
mod reciprocal;
mod walk;

use clap::ValueEnum;
use fearless_simd::Level;
use hyperspan::shade::Shader;
use hyperspan::target::{DepthBuffer, Target};
use hyperspan::tiler::Precision;

use super::machine::Machine;
use super::scenes::{Facet, Picture};
use affine::{AffineEvery, AffinePolygon, AffineSpan};
use inverse::Inverse;
pub(crate) use lanes::COUNT_F32;
use lanes::LaneArrays;
pub(crate) use prepare::Prepared;
use product::Product;
use quadratic::Quadratic;
use reciprocal::Estimate;
use walk::{Rung, paint};

/// A way of interpolating.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RungName {
    /// Affine along edges and spans.
    AffinePolygon,
    /// Affine between the exact ends of each span.
    AffineSpan,
    /// Exact at every 32 pixels, affine between.
    #[value(name = "affine-32")]
    Affine32,
    /// Exact at every 16 pixels, affine between.
    #[value(name = "affine-16")]
    Affine16,
    /// Exact at every 8 pixels, affine between.
    #[value(name = "affine-8")]
    Affine8,
    /// A parabola through three exact points of every 16 pixels.
    #[value(name = "quadratic-16")]
    Quadratic16,
    /// The machine's estimate of a reciprocal.
    Estimate,
    /// The estimate and a step of Newton's.
    Newton,
    /// The product's `Fast`.
    Fast,
    /// The product's `Exact`.
    Exact,
    /// The inverse of the transform and a division at each pixel.
    Inverse,
}

impl RungName {
    /// As the command line has it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::AffinePolygon => "affine-polygon",
            Self::AffineSpan => "affine-span",
            Self::Affine32 => "affine-32",
            Self::Affine16 => "affine-16",
            Self::Affine8 => "affine-8",
            Self::Quadratic16 => "quadratic-16",
            Self::Estimate => "estimate",
            Self::Newton => "newton",
            Self::Fast => "fast",
            Self::Exact => "exact",
            Self::Inverse => "inverse",
        }
    }

    /// Does it find depth in a way of its own? What the other rungs do is affine, which depth is.
    pub(crate) fn has_own_depth(self) -> bool {
        matches!(self, Self::AffineSpan | Self::Fast | Self::Exact | Self::Inverse)
    }
}

/// All rungs, for pictures of one size.
#[derive(Debug)]
pub(crate) struct Rungs {
    level: Level,
    prepared: Prepared,
    lanes: LaneArrays,
    product: Product,
    affine_polygon: AffinePolygon,
    affine_span: AffineSpan,
    affine_32: AffineEvery<32>,
    affine_16: AffineEvery<16>,
    affine_8: AffineEvery<8>,
    quadratic: Quadratic,
    estimate: Estimate<false>,
    newton: Estimate<true>,
    inverse: Inverse,
}

impl Rungs {
    /// For pictures like `picture`, on `machine`.
    pub(crate) fn new(picture: &Picture, machine: Machine) -> Self {
        Self {
            level: machine.level,
            prepared: Prepared::new(picture.viewport),
            lanes: LaneArrays::default(),
            product: Product::new(picture.viewport, machine.simd),
            affine_polygon: AffinePolygon::default(),
            affine_span: AffineSpan::default(),
            affine_32: AffineEvery::default(),
            affine_16: AffineEvery::default(),
            affine_8: AffineEvery::default(),
            quadratic: Quadratic::default(),
            estimate: Estimate::default(),
            newton: Estimate::default(),
            inverse: Inverse::default(),
        }
    }

    /// Draws `facet`, with the `stride` attributes that its vertices have.
    pub(crate) fn draw<S: Shader, T: Target<Pixel = S::Pixel>>(
        &mut self,
        rung: RungName,
        facet: &Facet,
        stride: usize,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) {
        let Self { level, prepared, lanes, .. } = self;
        let shared = Loop { level: *level, prepared, lanes, facet, stride };
        match rung {
            RungName::Fast => {
                self.product.draw(Precision::Fast, facet, stride, shader, target, depth);
            }
            RungName::Exact => {
                self.product.draw(Precision::Exact, facet, stride, shader, target, depth);
            }
            RungName::AffinePolygon => shared.run(&mut self.affine_polygon, shader, target, depth),
            RungName::AffineSpan => shared.run(&mut self.affine_span, shader, target, depth),
            RungName::Affine32 => shared.run(&mut self.affine_32, shader, target, depth),
            RungName::Affine16 => shared.run(&mut self.affine_16, shader, target, depth),
            RungName::Affine8 => shared.run(&mut self.affine_8, shader, target, depth),
            RungName::Quadratic16 => shared.run(&mut self.quadratic, shader, target, depth),
            RungName::Estimate => shared.run(&mut self.estimate, shader, target, depth),
            RungName::Newton => shared.run(&mut self.newton, shader, target, depth),
            RungName::Inverse => shared.run(&mut self.inverse, shader, target, depth),
        }
    }
}

/// A polygon on its way through the loop that rungs share.
struct Loop<'a> {
    level: Level,
    prepared: &'a mut Prepared,
    lanes: &'a mut LaneArrays,
    facet: &'a Facet,
    stride: usize,
}

impl Loop<'_> {
    fn run<R: Rung, S: Shader, T: Target<Pixel = S::Pixel>>(
        self,
        rung: &mut R,
        shader: &mut S,
        target: &mut T,
        depth: Option<&mut DepthBuffer<'_>>,
    ) {
        let Self { level, prepared, lanes, facet, stride } = self;
        let wanted = S::INPUTS.attributes.min(stride);
        prepared.set(facet, wanted, if R::GOES_ALONG_EDGES { wanted } else { 0 });
        if prepared.spans.is_empty() {
            return;
        }
        rung.begin_polygon(prepared, facet);
        let lanes = &mut lanes.0[..wanted];
        paint(level, rung, prepared, lanes, shader, target, depth);
    }
}
