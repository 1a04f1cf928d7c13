//! The stress that the bounds of docs/precision.md must survive: polygons that go step by step to
//! an extreme, and a search that climbs towards the worst. What comes out is a row for each step:
//! the largest error over the promised bound, which must not be above 1.
//!
//! - `random`  numbers
//! - `shape`   polygons and where to look at them
//! - `sweeps`  the kinds of polygons and their steps
//! - `ties`    values almost halfway between two `f32`
//! - `judge`   draws a polygon and compares
//! - `search`  the climb

pub(crate) mod judge;
pub(crate) mod random;
mod search;
mod shape;
mod sweeps;
mod ties;

use hyperspan::error::Error;
use judge::Judged;
use random::Random;
pub(crate) use shape::Case;
use sweeps::SWEEPS;

/// When a search ends: at whichever comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Until {
    /// After so many polygons.
    pub(crate) tried: u64,
    pub(crate) seconds: f64,
}

/// What to run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Polygons in each step of a sweep.
    pub(crate) polygons: usize,
    /// A search beside the sweeps.
    pub(crate) search: Option<Until>,
    /// Another one gives other polygons.
    pub(crate) seed: u64,
}

/// The worst of some polygons.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) sweep: &'static str,
    /// What a step of the sweep is.
    pub(crate) parameter: &'static str,
    pub(crate) step: f64,
    pub(crate) polygons: u64,
    pub(crate) judged: Judged,
    /// The polygon with the greatest error of all, over its bound, if that is above 1, or else
    /// the one with the greatest of attributes in `Fast`.
    pub(crate) worst: Option<Case>,
}

/// The rows of all sweeps, and of the search if there is one. `tell` hears how many parts of how
/// many are done.
pub(crate) fn run(options: Options, tell: &mut dyn FnMut(u64, u64)) -> Result<Vec<Row>, Error> {
    const SEARCH_PARTS: u64 = 100;
    let steps: u64 = SWEEPS.iter().map(|sweep| sweep.steps.len() as u64).sum();
    let all = steps + options.search.map_or(0, |_| SEARCH_PARTS);
    let mut rows = Vec::new();
    for (number, sweep) in SWEEPS.iter().enumerate() {
        for step in sweep.steps {
            tell(rows.len() as u64, all);
            rows.push(row(options, number, *step)?);
        }
    }
    if let Some(until) = options.search {
        let mut tell = |part: f64| tell(steps + (part * SEARCH_PARTS as f64) as u64, all);
        let found = search::search(until, options.seed, &mut tell)?;
        rows.push(Row {
            sweep: "search",
            parameter: "climbs",
            step: found.starts as f64,
            polygons: found.tried,
            judged: found.judged,
            worst: Some(found.worst),
        });
    }
    Ok(rows)
}

fn row(options: Options, number: usize, step: f64) -> Result<Row, Error> {
    let sweep = &SWEEPS[number];
    let mut judged = Judged::default();
    let (mut worst, mut how_bad) = (None, -1.0);
    for index in 0..options.polygons {
        // A panned polygon is the same one in a hundred frames.
        let polygon = if sweep.name == "pan" { index / sweeps::FRAMES } else { index };
        let mut random =
            Random::new((options.seed << 40) ^ ((number as u64) << 32) ^ polygon as u64);
        let case = (sweep.make)(step, index, &mut random)?;
        let of_case = judge::judge(&case);
        judged = judged.and(of_case);
        if of_case.badness() > how_bad {
            (worst, how_bad) = (Some(case), of_case.badness());
        }
    }
    Ok(Row {
        sweep: sweep.name,
        parameter: sweep.parameter,
        step,
        polygons: options.polygons as u64,
        judged,
        worst,
    })
}
