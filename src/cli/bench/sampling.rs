//! Pixels at which the error is measured, with their right values, and what a rung makes of them.
//!
//! Whole pictures would take too long: pixels are drawn evenly from a seed, and
//! of some spans, drawn likewise, both ends besides, where errors are largest.

use std::ops::Range;

use super::reference::{Reference, Value};
use super::rungs::{Prepared, RungName, Rungs};
use super::scenes::Picture;
use super::shaders::Capture;
use super::stress::random::Random;
use crate::failure::Failure;

/// Pixels of a span's end that are taken.
const END: i32 = 16;

/// How many pixels to take, about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Amount {
    /// Of all pixels, evenly.
    pub(crate) even: f64,
    /// At the ends of spans.
    pub(crate) at_ends: f64,
}

impl Amount {
    /// Every pixel.
    pub(crate) const ALL: Self = Self { even: f64::INFINITY, at_ends: 0.0 };
}

/// A pixel of one of the polygons.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) x: i32,
    pub(crate) y: i32,
    /// Was it drawn evenly from all pixels?
    pub(crate) even: bool,
}

/// Samples of all polygons of a picture.
#[derive(Debug)]
pub(crate) struct Samples {
    pub(crate) list: Vec<Sample>,
    /// Those of each polygon.
    of_facets: Vec<Range<usize>>,
    /// The right values of each sample: depth, then the attributes; none where the reference is in
    /// doubt.
    pub(crate) right: Vec<Option<Value>>,
    /// The largest magnitude of each attribute over the sample's polygon: for each attribute of
    /// each polygon.
    largest: Vec<f64>,
    /// Values of a sample.
    pub(crate) stride: usize,
    /// Covered pixels: of all polygons, one by one.
    pub(crate) pixels: u64,
}

impl Samples {
    /// Takes about as many pixels of `picture` as `amount` says.
    pub(crate) fn new(picture: &Picture, amount: Amount) -> Self {
        let mut prepared = Prepared::new(picture.viewport);
        let (mut pixels, mut spans) = (0_u64, 0_u64);
        for facet in &picture.facets {
            prepared.set(facet, 0, 0);
            spans += prepared.spans.len() as u64;
            let length = |span: &hyperspan::edge::Span| u64::from(span.end.abs_diff(span.start));
            pixels += prepared.spans.iter().map(length).sum::<u64>();
        }
        let even = amount.even / pixels as f64;
        let at_ends = amount.at_ends / (spans * 2 * u64::from(END.unsigned_abs())) as f64;

        let stride = 1 + picture.attributes;
        let mut samples = Self {
            list: Vec::new(),
            of_facets: Vec::new(),
            right: Vec::new(),
            largest: Vec::new(),
            stride,
            pixels,
        };
        let mut random = Random::new(0xE22);
        for facet in &picture.facets {
            prepared.set(facet, 0, 0);
            let first = samples.list.len();
            for span in &prepared.spans {
                let ends = random.unit() < at_ends;
                for x in span.start..span.end {
                    let even = random.unit() < even;
                    let at_end = x < span.start + END || x >= span.end - END;
                    if even || (ends && at_end) {
                        samples.list.push(Sample { x, y: span.row, even });
                    }
                }
            }
            samples.of_facets.push(first..samples.list.len());
            let attributes: Vec<Vec<f32>> =
                facet.attributes.chunks(picture.attributes).map(<[f32]>::to_vec).collect();
            let reference = Reference::new(&facet.positions, &attributes, &picture.viewport);
            for Sample { x, y, .. } in &samples.list[first..] {
                samples.right.push(reference.as_ref().and_then(|r| r.depth(*x, *y)));
                for k in 0..picture.attributes {
                    let right = reference.as_ref().and_then(|r| r.attribute(k, *x, *y));
                    samples.right.push(right);
                }
            }
            for k in 0..picture.attributes {
                let all = attributes.iter().map(|values| f64::from(values[k].abs()));
                samples.largest.push(all.fold(0.0, f64::max));
            }
        }
        samples
    }

    /// Each sample with its polygon.
    pub(crate) fn facets(&self) -> impl Iterator<Item = (usize, usize)> {
        self.of_facets
            .iter()
            .enumerate()
            .flat_map(|(facet, samples)| samples.clone().map(move |sample| (sample, facet)))
    }

    /// The largest magnitude of attribute `k` at the vertices of polygon `facet`.
    pub(crate) fn largest(&self, facet: usize, k: usize) -> f64 {
        self.largest[facet * (self.stride - 1) + k]
    }

    /// What `rung` finds at the samples, as `right` has it.
    pub(crate) fn capture(
        &self,
        rungs: &mut Rungs,
        rung: RungName,
        picture: &Picture,
    ) -> Result<Vec<f32>, Failure> {
        let (width, height) =
            (picture.viewport.width() as usize, picture.viewport.height() as usize);
        let mut wanted = vec![0; width * height];
        let mut values = vec![f32::NAN; self.right.len()];
        let at = |sample: &Sample| {
            sample.y.cast_unsigned() as usize * width + sample.x.cast_unsigned() as usize
        };
        let mut pixels = 0;
        for (facet, samples) in picture.facets.iter().zip(&self.of_facets) {
            for (sample, number) in self.list[samples.clone()].iter().zip(samples.start + 1..) {
                wanted[at(sample)] = u32::try_from(number).unwrap_or(u32::MAX);
            }
            let (stride, values) = (self.stride, &mut values);
            let mut shader = Capture { wanted: &wanted, width, stride, values, pixels };
            rungs.draw(rung, facet, picture.attributes, &mut shader, &mut (), None);
            pixels = shader.pixels;
            for sample in &self.list[samples.clone()] {
                wanted[at(sample)] = 0;
            }
        }
        if pixels != self.pixels {
            return Err(Failure::new(format!(
                "{} drew {pixels} pixels, not the {} that are covered: this is a defect, please \
                 report it",
                rung.name(),
                self.pixels
            )));
        }
        Ok(values)
    }
}
