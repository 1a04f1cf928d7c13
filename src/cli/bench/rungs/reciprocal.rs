//! The division replaced by the machine's estimate of a reciprocal, and by one Newton step more.
//!
//! Numerators and denominators are the product's: `f64`, rounded once. How good the estimate is
//! differs between machines; without an instruction for it, it is a division.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x16};
use hyperspan::edge::Span;
use hyperspan::shade::BLOCK;

use super::lanes::{COUNT, Wide, clamp};
use super::prepare::Prepared;
use super::walk::Rung;
use crate::bench::scenes::Facet;

/// The estimate, after a step of Newton's if `NEWTON`.
#[derive(Debug, Default)]
pub(crate) struct Estimate<const NEWTON: bool> {
    /// Where the span begins, from the anchor.
    offset: [f64; 2],
}

impl<const NEWTON: bool> Rung for Estimate<NEWTON> {
    fn begin_polygon(&mut self, _prepared: &Prepared, _facet: &Facet) {}

    #[inline(always)]
    fn begin_span<S: Simd>(&mut self, _simd: S, prepared: &Prepared, span: &Span) {
        self.offset = prepared.offset(span.start, span.row);
    }

    #[inline(always)]
    fn values<S: Simd>(
        &mut self,
        simd: S,
        prepared: &Prepared,
        first: i32,
        out: &mut [[f32; BLOCK]],
    ) {
        let [u, v] = self.offset;
        let us = Wide::load(simd, &COUNT) + Wide::splat(simd, u + f64::from(first));
        let q = &prepared.inv_w;
        let q = (Wide::splat(simd, q.row(v)) + Wide::splat(simd, q.x) * us).narrow();
        let mut w = q.approximate_recip();
        if NEWTON {
            w = w * (f32x16::splat(simd, 2.0) - q * w);
        }
        for ((n, range), out) in prepared.over_w.iter().zip(&prepared.ranges).zip(out) {
            let n = Wide::splat(simd, n.row(v)) + Wide::splat(simd, n.x) * us;
            clamp(simd, n.narrow() * w, *range).store_slice(out);
        }
    }
}
