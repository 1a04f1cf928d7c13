//! Run time: interleaved runs, so that what disturbs one rung disturbs all.

use std::hint::black_box;
use std::time::Instant;

use hyperspan::Aligned;
use hyperspan::target::Plane;
use hyperspan::texture::Texture;

use super::errors::TEXTURE_SIDE;
use super::machine::Machine;
use super::rungs::{RungName, Rungs};
use super::scenes::{MOST_ATTRIBUTES, Picture, size};
use super::shaders::{Bits, Textured};
use super::stress::random::Random;
use super::yardstick::Yardstick;
use crate::failure::Failure;

/// What is made of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variant {
    /// The bits of all attributes, together, into a plane.
    Attributes,
    /// Depth test and write, and nothing else.
    Depth,
    /// Depth test and write, and the nearest texel.
    Texture,
}

impl Variant {
    /// As tables have it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Attributes => "attributes",
            Self::Depth => "depth",
            Self::Texture => "texture",
        }
    }
}

/// Times of one rung in ns: whole frames with set-up and spans, without clearing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times {
    pub(crate) median: f64,
    pub(crate) least: f64,
}

impl Times {
    /// For each of `pixels`.
    pub(crate) fn per(self, pixels: u64) -> Self {
        let pixels = pixels.max(1) as f64;
        Self { median: self.median / pixels, least: self.least / pixels }
    }
}

/// Times of some rungs, and of what they are compared with.
#[derive(Debug)]
pub(crate) struct Measured {
    /// In the order of the rungs.
    pub(crate) rungs: Vec<Times>,
    /// Medians, per pixel.
    pub(crate) yardstick: f64,
    pub(crate) fill: f64,
}

/// What is drawn on.
pub(crate) struct Easel {
    size: [u32; 2],
    bits: Aligned<u32>,
    colours: Aligned<[u8; 4]>,
    depths: Aligned<f32>,
    texture: Texture,
    yardstick: Yardstick,
}

impl Easel {
    /// For pictures of `width` pixels a row.
    pub(crate) fn new(width: u32, machine: Machine) -> Result<Self, Failure> {
        let size = size(width);
        let area = size[0] as usize * size[1] as usize;
        let mut random = Random::new(0x7E7);
        let texels = TEXTURE_SIDE as usize * TEXTURE_SIDE as usize;
        let texels: Vec<[u8; 4]> =
            (0..texels).map(|_| (random.bits() as u32).to_le_bytes()).collect();
        Ok(Self {
            size,
            bits: Aligned::filled(0, area)?,
            colours: Aligned::filled([0; 4], area)?,
            depths: Aligned::filled(1.0, area)?,
            texture: Texture::new(TEXTURE_SIDE, TEXTURE_SIDE, &texels)?,
            yardstick: Yardstick::new(machine.level, size)?,
        })
    }

    /// Draws `picture` `runs` times with each of `names`, in turn, and once before that.
    pub(crate) fn measure(
        &mut self,
        rungs: &mut Rungs,
        names: &[RungName],
        picture: &Picture,
        variant: Variant,
        runs: usize,
    ) -> Result<Measured, Failure> {
        let mut times = vec![Vec::with_capacity(runs); names.len()];
        let (mut yardsticks, mut fills) = (Vec::new(), Vec::new());
        for run in 0..=runs {
            for i in 0..names.len() {
                // Each run begins with another one.
                let i = (i + run) % names.len();
                let time = self.frame(rungs, names[i], picture, variant)?;
                if run > 0 {
                    times[i].push(time);
                }
            }
            let area = self.yardstick.area() as f64;
            yardsticks.push(time_of(|| self.yardstick.draw()) / area);
            fills.push(time_of(|| self.yardstick.fill()) / area);
        }
        let of = |times: &mut Vec<f64>| Times {
            median: median(times),
            least: times.iter().copied().fold(f64::INFINITY, f64::min),
        };
        Ok(Measured {
            rungs: times.iter_mut().map(of).collect(),
            yardstick: median(&mut yardsticks),
            fill: median(&mut fills),
        })
    }

    /// Clears, then draws: the time of that in ns.
    fn frame(
        &mut self,
        rungs: &mut Rungs,
        name: RungName,
        picture: &Picture,
        variant: Variant,
    ) -> Result<f64, Failure> {
        let [width, height] = self.size;
        let stride = picture.attributes;
        if variant != Variant::Attributes {
            self.depths.fill(1.0);
        }
        let time = match variant {
            Variant::Attributes => {
                let mut target = Plane::new(&mut self.bits, width, height)?;
                time_of(|| {
                    for facet in &picture.facets {
                        // A number that is known, as a user's shader has it.
                        if stride == MOST_ATTRIBUTES {
                            let shader = &mut Bits::<MOST_ATTRIBUTES>;
                            rungs.draw(name, facet, stride, shader, &mut target, None);
                        } else {
                            rungs.draw(name, facet, stride, &mut Bits::<2>, &mut target, None);
                        }
                    }
                })
            }
            Variant::Depth => {
                let mut depth = Plane::new(&mut self.depths, width, height)?;
                time_of(|| {
                    for facet in &picture.facets {
                        let shader = &mut hyperspan::shade::Solid(());
                        rungs.draw(name, facet, stride, shader, &mut (), Some(&mut depth));
                    }
                })
            }
            Variant::Texture => {
                let mut depth = Plane::new(&mut self.depths, width, height)?;
                let mut target = Plane::new(&mut self.colours, width, height)?;
                let mut shader = Textured(&self.texture);
                time_of(|| {
                    for facet in &picture.facets {
                        rungs.draw(name, facet, stride, &mut shader, &mut target, Some(&mut depth));
                    }
                })
            }
        };
        black_box((&self.bits, &self.colours, &self.depths));
        Ok(time)
    }
}

/// In ns.
fn time_of(task: impl FnOnce()) -> f64 {
    let start = Instant::now();
    task();
    start.elapsed().as_nanos() as f64
}

/// The one in the middle, or the mean of the two.
fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    let middle = times.len() / 2;
    match times.len() {
        0 => 0.0,
        n if n % 2 == 1 => times[middle],
        _ => f64::midpoint(times[middle - 1], times[middle]),
    }
}
