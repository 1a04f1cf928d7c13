//! The soak: random scenes, drawn in all ways that there are, every pixel against a coverage oracle
//! and every value against the reference, for as long as one likes.
//!
//! - `scene`   polygons, and how they are drawn
//! - `shapes`  what scenes are made of
//! - `kinds`   random scenes
//! - `outline` the coverage oracle: exact crossings, a row at a time
//! - `cut`     the same for polygons that planes cut, with a tolerance at their sides
//! - `values`  compares values with P2
//! - `marks`   draws a polygon alone and compares which pixels it covers
//! - `check`   draws a scene and compares

pub(crate) mod check;
pub(crate) mod cut;
mod kinds;
mod marks;
pub(crate) mod outline;
pub(crate) mod scene;
mod shapes;
pub(crate) mod values;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::ThreadPool;

use check::{Desk, Tally};
pub(crate) use kinds::{names, scene};

/// Threads of scenes that are drawn on several.
pub(crate) const POOL: usize = 3;

/// What to run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    pub(crate) seconds: f64,
    /// Another one gives other scenes.
    pub(crate) seed: u64,
    /// The number of the first scene.
    pub(crate) first: u64,
    /// So many scenes at a time.
    pub(crate) threads: usize,
}

/// A scene that is not as it must be.
#[derive(Clone, Debug)]
pub(crate) struct Disagreement {
    pub(crate) scene: u64,
    pub(crate) kind: &'static str,
    pub(crate) what: String,
    /// The polygon, as `hyperspan tile` reads it.
    pub(crate) text: String,
}

/// What came of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Soaked {
    /// For each kind of scenes.
    pub(crate) tallies: Vec<(&'static str, Tally)>,
    pub(crate) seconds: f64,
    /// How many there were, and the first of them.
    pub(crate) disagreements: u64,
    pub(crate) shown: Vec<Disagreement>,
}

impl Soaked {
    /// Of all kinds.
    pub(crate) fn total(&self) -> Tally {
        let mut total = Tally::default();
        self.tallies.iter().for_each(|(_, tally)| total.add(tally));
        total
    }

    fn add(&mut self, kind: &'static str, tally: &Tally) {
        let of_kind = self.tallies.iter_mut().find(|(name, _)| *name == kind);
        if let Some((_, sum)) = of_kind {
            sum.add(tally);
        }
    }
}

/// Draws scenes until the time is over, one at least. `pool` has the threads of the scenes that
/// are drawn on several; `tell` hears which part of the time is over.
pub(crate) fn run(
    options: Options,
    pool: &ThreadPool,
    tell: &mut (dyn FnMut(f64) + Send),
) -> Soaked {
    const MOST_SHOWN: usize = 10;
    let begun = Instant::now();
    let next = AtomicU64::new(options.first);
    let soaked = Soaked {
        tallies: names().map(|name| (name, Tally::default())).collect(),
        ..Soaked::default()
    };
    let shared = Mutex::new((soaked, tell));
    let work = || {
        let mut desk = Desk::default();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let of_time = begun.elapsed().as_secs_f64() / options.seconds;
            if number > options.first && of_time.is_nan() | (of_time >= 1.0) {
                return;
            }
            let result = scene(options.seed, number).map(|scene| {
                let result = desk.check(&scene, pool, &|_| ());
                (scene, result)
            });
            // A thread that panicked has been told of already.
            let Ok(mut shared) = shared.lock() else { return };
            let (soaked, tell) = &mut *shared;
            tell(of_time.min(1.0));
            match result {
                Ok((scene, Ok(tally))) => soaked.add(scene.kind, &tally),
                Ok((scene, Err(wrong))) => {
                    soaked.disagreements += 1;
                    if soaked.shown.len() < MOST_SHOWN {
                        let text = scene.text(wrong.piece);
                        let what = format!("polygon {}: {}", wrong.piece, wrong.what);
                        let kind = scene.kind;
                        soaked.shown.push(Disagreement { scene: number, kind, what, text });
                    }
                }
                // Viewports are small enough.
                Err(_) => soaked.disagreements += 1,
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..options.threads {
            scope.spawn(work);
        }
        work();
    });
    let mut soaked = shared.into_inner().map_or_else(|poisoned| poisoned.into_inner().0, |s| s.0);
    soaked.seconds = begun.elapsed().as_secs_f64();
    soaked
}
