//! A random search that climbs towards the worst case: small changes to a polygon, those kept that
//! make the error of an attribute in `Fast` a larger part of its bound; in every fourth climb that of
//! depth. What `Exact` gives has nowhere to climb to, but is judged all the same.

use std::time::Instant;

use hyperspan::error::Error;
use hyperspan::space::Viewport;

use super::Until;
use super::judge::{Judged, Quantity, judge};
use super::random::Random;
use super::shape::{Case, Shape, window};

/// What a search came to.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// Of all polygons that were tried.
    pub(crate) judged: Judged,
    pub(crate) tried: u64,
    /// How often the climb began anew.
    pub(crate) starts: u64,
    /// The worst of them.
    pub(crate) worst: Case,
}

/// A polygon and where it is looked at.
#[derive(Clone, Debug)]
struct Candidate {
    shape: Shape,
    /// The middle of the window, as weights of the corners.
    look: [f64; 3],
}

impl Candidate {
    fn any(random: &mut Random) -> Result<Self, Error> {
        const SIDES: [u32; 5] = [16, 64, 512, 4096, 16384];
        let mut side = || SIDES[random.below(SIDES.len())];
        let (width, height) = (side(), side());
        let viewport = Viewport::new(0, 0, width, height)?;
        let ratio = random.up_to(1e9);
        let shape = Shape::triangle(viewport, ratio, random);
        Ok(Self { shape, look: weights(random) })
    }

    fn case(&self) -> Case {
        let at = self.shape.at(self.look);
        self.shape.case(vec![window(self.shape.viewport, at)])
    }

    /// One to three changes, from large to the least.
    fn changed(&self, random: &mut Random) -> Self {
        let mut next = self.clone();
        for _ in 0..=random.below(3) {
            // 1 down to 2^-30.
            let amount = 1.0 / random.up_to(1_073_741_824.0);
            let amount = random.signed(amount);
            let shape = &mut next.shape;
            let corner = random.below(3);
            match random.below(9) {
                0 | 1 => {
                    let side = f64::from(shape.viewport.width().max(shape.viewport.height()));
                    shape.corners[corner].at[random.below(2)] += amount * side;
                }
                2 => {
                    let at = &mut shape.corners[corner].at[random.below(2)];
                    *at = at.floor() + 0.5;
                }
                3 => {
                    let w = &mut shape.corners[corner].w;
                    *w = (*w * (1.0 + amount)).clamp(1e-9, 1e9);
                }
                4 => shape.corners[corner].w = random.up_to(1e9),
                5 => shape.corners[corner].depth = random.unit(),
                6 => {
                    let list = &mut shape.attributes[random.below(2)];
                    list[corner] += amount * list[random.below(3)].abs().max(1e-6);
                }
                7 => {
                    let list = &mut shape.attributes[random.below(2)];
                    let other = list[random.below(3)];
                    list[corner] = random.signed(other);
                }
                _ => next.look = weights(random),
            }
        }
        next
    }
}

fn weights(random: &mut Random) -> [f64; 3] {
    let part = [0, 1, 2].map(|_| 1.0 / random.up_to(1e3));
    let sum = part[0] + part[1] + part[2];
    part.map(|p| p / sum)
}

/// Climbs until `until`, and again from elsewhere whenever it has come to rest. `tell` hears which
/// part of the way is done.
pub(crate) fn search(until: Until, seed: u64, tell: &mut dyn FnMut(f64)) -> Result<Found, Error> {
    // So many changes in a row that make nothing worse end a climb.
    const PATIENCE: u32 = 2000;
    let begun = Instant::now();
    let mut random = Random::new(seed);
    let mut here = Candidate::any(&mut random)?;
    let mut found = Found { judged: Judged::default(), tried: 0, starts: 1, worst: here.case() };
    let (mut height, mut worst, mut idle) = (-1.0, -1.0, 0);
    loop {
        let of_time = begun.elapsed().as_secs_f64() / until.seconds;
        let done = of_time.max(found.tried as f64 / until.tried as f64);
        tell(done.min(1.0));
        if done >= 1.0 {
            return Ok(found);
        }
        let next = if height < 0.0 { here.clone() } else { here.changed(&mut random) };
        let case = next.case();
        let judged = judge(&case);
        found.tried += 1;
        found.judged = found.judged.and(judged);
        let how_bad = judged.badness();
        if how_bad > worst {
            worst = how_bad;
            found.worst = case;
        }
        let goal =
            if found.starts.is_multiple_of(4) { Quantity::Depth } else { Quantity::Attribute };
        let part = judged.worst[0][goal as usize];
        // As bad is good enough: it wanders along.
        idle = if part > height { 0 } else { idle + 1 };
        if part >= height {
            height = part;
            here = next;
        }
        if idle > PATIENCE {
            here = Candidate::any(&mut random)?;
            (height, idle) = (-1.0, 0);
            found.starts += 1;
        }
    }
}
