//! What was measured, as rows, and what the rows of all scenes have in common.

use super::errors::Errors;
use super::measure::{Times, Variant};
use super::rungs::RungName;
use super::scenes::SceneName;

/// What is measured together: all rungs on the same polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Case {
    pub(crate) scene: SceneName,
    pub(crate) w_ratio: f64,
    /// Of each vertex.
    pub(crate) attributes: usize,
    /// Of the picture, in pixels.
    pub(crate) width: u32,
    pub(crate) variant: Variant,
}

impl Case {
    /// Do they differ in the scene alone, if at all?
    fn is_like(&self, other: &Self) -> bool {
        *self == Self { scene: self.scene, ..*other }
    }
}

/// One rung in one case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) case: Case,
    pub(crate) rung: RungName,
    /// Covered, by all polygons.
    pub(crate) pixels: u64,
    pub(crate) polygons: usize,
    /// ns for each covered pixel.
    pub(crate) times: Times,
    /// ns per pixel of the yardstick loop and of filling memory, in the same run.
    pub(crate) yardstick: f64,
    pub(crate) fill: f64,
    pub(crate) errors: Errors,
    /// Is no other rung of the case at least as fast and as accurate?
    pub(crate) pareto: bool,
}

/// All rows, and how they were measured.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) rows: Vec<Row>,
    /// The instruction set's name.
    pub(crate) simd: &'static str,
    /// Times are medians of so many.
    pub(crate) runs: usize,
    /// The width of the pictures that charts show.
    pub(crate) width: u32,
}

impl Report {
    /// Adds the rows of one case, and finds out which of them are on the Pareto front.
    pub(crate) fn add(&mut self, mut rows: Vec<Row>) {
        let places: Vec<[f64; 2]> =
            rows.iter().map(|row| [row.times.median, row.errors.max_ulp]).collect();
        for (row, pareto) in rows.iter_mut().zip(front(&places)) {
            row.pareto = pareto;
        }
        self.rows.append(&mut rows);
    }

    /// The cases, each once for all scenes, in the order of the rows.
    pub(crate) fn kinds(&self) -> Vec<Case> {
        let mut kinds: Vec<Case> = Vec::new();
        for row in &self.rows {
            if !kinds.iter().any(|kind| kind.is_like(&row.case)) {
                kinds.push(row.case);
            }
        }
        kinds
    }

    /// What all scenes of a kind have in common: one line for each rung.
    pub(crate) fn summary(&self, kind: &Case) -> Vec<Summary> {
        let rows = || self.rows.iter().filter(|row| row.case.is_like(kind));
        let mut rungs: Vec<RungName> = Vec::new();
        for row in rows() {
            if !rungs.contains(&row.rung) {
                rungs.push(row.rung);
            }
        }
        let line = |rung: &RungName| {
            let of_rung = rows().filter(|row| row.rung == *rung).map(Summary::of);
            Summary::of_all(&of_rung.collect::<Vec<_>>())
        };
        let mut lines: Vec<Summary> = rungs.iter().filter_map(line).collect();
        let places: Vec<[f64; 2]> = lines.iter().map(|line| [line.ns, line.max_ulp]).collect();
        for (line, pareto) in lines.iter_mut().zip(front(&places)) {
            line.pareto = pareto;
        }
        lines
    }
}

/// One rung, in one case or over all scenes of a kind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Summary {
    pub(crate) rung: RungName,
    /// Geometric means: ns per pixel, and over the yardstick.
    pub(crate) ns: f64,
    pub(crate) yardsticks: f64,
    /// The greatest of all scenes.
    pub(crate) max_ulp: f64,
    pub(crate) p999_ulp: f64,
    pub(crate) max_of_magnitude: f64,
    /// Means of the scenes.
    pub(crate) mean_ulp: f64,
    /// The greatest, the mean, and the mean percentage of wrong ones.
    pub(crate) texels: Option<[f64; 3]>,
    /// The greatest error over a bound that is promised.
    pub(crate) worst_over_bound: Option<f64>,
    pub(crate) pareto: bool,
}

impl Summary {
    /// One row, as it is.
    pub(crate) fn of(row: &Row) -> Self {
        let errors = &row.errors;
        Self {
            rung: row.rung,
            ns: row.times.median,
            yardsticks: row.times.median / row.yardstick,
            max_ulp: errors.max_ulp,
            p999_ulp: errors.p999_ulp,
            max_of_magnitude: errors.max_of_magnitude,
            mean_ulp: errors.mean_ulp,
            texels: errors.texels.map(|texels| [texels.max, texels.mean, texels.wrong_percent]),
            worst_over_bound: errors.promise.map(|kept| kept.worst),
            pareto: row.pareto,
        }
    }

    /// Of the lines of one rung, at least one.
    fn of_all(lines: &[Self]) -> Option<Self> {
        let count = lines.len() as f64;
        let mean = |of: fn(&Self) -> f64| lines.iter().map(of).sum::<f64>() / count;
        let geometric = |of: fn(&Self) -> f64| {
            libm::exp(lines.iter().map(|line| libm::log(of(line))).sum::<f64>() / count)
        };
        let greatest = |of: fn(&Self) -> f64| lines.iter().map(of).fold(0.0, f64::max);
        let first = lines.first()?;
        let texel = |i: usize| lines.iter().filter_map(move |line| Some(line.texels?[i]));
        Some(Self {
            rung: first.rung,
            ns: geometric(|line| line.ns),
            yardsticks: geometric(|line| line.yardsticks),
            max_ulp: greatest(|line| line.max_ulp),
            p999_ulp: greatest(|line| line.p999_ulp),
            max_of_magnitude: greatest(|line| line.max_of_magnitude),
            mean_ulp: mean(|line| line.mean_ulp),
            texels: first.texels.map(|_| {
                let mean = |i| texel(i).sum::<f64>() / count;
                [texel(0).fold(0.0, f64::max), mean(1), mean(2)]
            }),
            worst_over_bound: first
                .worst_over_bound
                .map(|_| lines.iter().filter_map(|line| line.worst_over_bound).fold(0.0, f64::max)),
            pareto: false,
        })
    }
}

/// For each place (time, error): is there no other that is as good in both, and better in one?
fn front(places: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: &[f64; 2], b: &[f64; 2]| a != b && a[0] <= b[0] && a[1] <= b[1];
    places.iter().map(|place| !places.iter().any(|other| beats(other, place))).collect()
}

/// A ratio or a large number as people write it: 1, 100, 10^4.
pub(crate) fn power(number: f64) -> String {
    let exponent = libm::log10(number).round();
    if exponent >= 3.0 && libm::pow(10.0, exponent) == number {
        format!("10^{exponent}")
    } else {
        format!("{number}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn front_has_what_nothing_beats() {
        let places = [[1.0, 9.0], [2.0, 4.0], [2.0, 5.0], [3.0, 4.0], [4.0, 0.5], [4.0, 0.5]];
        assert_eq!(front(&places), [true, true, false, false, true, true]);
    }

    #[test]
    fn powers_are_written_short() {
        assert_eq!([1.0, 100.0, 1e4, 1e6, 2e4].map(power), ["1", "100", "10^4", "10^6", "20000"]);
    }
}
