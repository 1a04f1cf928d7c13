//! How far a rung's values are from the right ones.

use super::reference::Value;
use super::rungs::RungName;
use super::sampling::Samples;

/// The rounding of `f32`.
const U: f64 = 1.0 / 16_777_216.0;

/// Texels along a side of the texture that errors are told in.
pub(crate) const TEXTURE_SIDE: u32 = 256;

/// Errors at samples: the greatest of all, the others of those drawn evenly. In ulp of `f32` at the
/// right value.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Values compared, and those that the reference left in doubt.
    pub(crate) values: u64,
    pub(crate) doubtful: u64,
    pub(crate) max_ulp: f64,
    pub(crate) p999_ulp: f64,
    pub(crate) mean_ulp: f64,
    /// The greatest error over 2^-24 times the attribute's largest magnitude at the vertices: what
    /// is near 0 weighs no more than the rest.
    pub(crate) max_of_magnitude: f64,
    /// Of attributes 0 and 1 as coordinates of a texture.
    pub(crate) texels: Option<Texels>,
    /// What is promised.
    pub(crate) promise: Option<Kept>,
}

/// Errors in texels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Texels {
    pub(crate) max: f64,
    pub(crate) mean: f64,
    pub(crate) wrong_percent: f64,
}

/// How near the worst value came to a bound.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kept {
    /// Its error over the bound there.
    pub(crate) worst: f64,
    /// The bound there.
    pub(crate) bound_ulp: f64,
}

impl Kept {
    fn take(&mut self, error: f64, bound: f64) {
        if bound > 0.0 && error / bound > self.worst {
            *self = Self { worst: error / bound, bound_ulp: bound };
        }
    }
}

/// The errors of the attributes in `found`, which `rung` made of `samples`.
pub(crate) fn of_attributes(samples: &Samples, found: &[f32], rung: RungName) -> Errors {
    let mut errors = Errors::default();
    let mut promise = Kept::default();
    let mut tally = Tally::default();
    let mut texels = TexelTally::default();
    for (sample, facet) in samples.facets() {
        let all = sample * samples.stride + 1..(sample + 1) * samples.stride;
        let (right, found) = (&samples.right[all.clone()], &found[all]);
        let even = samples.list[sample].even;
        for (k, (right, found)) in right.iter().zip(found).enumerate() {
            let Some(right) = right else {
                errors.doubtful += 1;
                continue;
            };
            let (ulp, distance) = (right.ulp(*found), right.distance(*found));
            tally.take(ulp, even);
            let largest = samples.largest(facet, k);
            if largest > 0.0 {
                errors.max_of_magnitude = errors.max_of_magnitude.max(distance / (U * largest));
            }
            match rung {
                RungName::Exact => promise.take(ulp, 0.5),
                RungName::Fast => {
                    let bound = 4.0 * U * right.high.abs() + 3.0 * U * largest;
                    // In ulp, so that it can be told.
                    promise.take(ulp, bound / right.unit());
                }
                _ => {}
            }
        }
        if let ([Some(u), Some(v), ..], [found_u, found_v, ..]) = (right, found) {
            texels.take([*u, *v], [*found_u, *found_v], even);
        }
    }
    errors.texels = texels.result();
    errors.promise = matches!(rung, RungName::Exact | RungName::Fast).then_some(promise);
    tally.put_into(&mut errors);
    errors
}

/// The errors of depth.
pub(crate) fn of_depth(samples: &Samples, found: &[f32], rung: RungName) -> Errors {
    let mut errors = Errors::default();
    let mut promise = Kept::default();
    let mut tally = Tally::default();
    for (sample, _) in samples.facets() {
        let at = sample * samples.stride;
        let Some(right) = samples.right[at] else {
            errors.doubtful += 1;
            continue;
        };
        let ulp = right.ulp(found[at]);
        tally.take(ulp, samples.list[sample].even);
        errors.max_of_magnitude = errors.max_of_magnitude.max(right.distance(found[at]) / U);
        promise.take(ulp, if rung == RungName::Exact { 0.5 } else { 1.0 });
    }
    errors.promise = matches!(rung, RungName::Exact | RungName::Fast).then_some(promise);
    tally.put_into(&mut errors);
    errors
}

/// Errors in ulp as they come.
#[derive(Default)]
struct Tally {
    max: f64,
    count: u64,
    even: Vec<f64>,
}

impl Tally {
    fn take(&mut self, ulp: f64, even: bool) {
        self.count += 1;
        self.max = if ulp <= self.max { self.max } else { ulp };
        if even {
            self.even.push(ulp);
        }
    }

    fn put_into(mut self, errors: &mut Errors) {
        errors.values = self.count;
        errors.max_ulp = self.max;
        let count = self.even.len();
        if count == 0 {
            return;
        }
        errors.mean_ulp = self.even.iter().sum::<f64>() / count as f64;
        // The least that 99.9 % do not exceed.
        let rank = (count * 999).div_ceil(1000).saturating_sub(1);
        errors.p999_ulp = *self.even.select_nth_unstable_by(rank, f64::total_cmp).1;
    }
}

/// Errors in texels as they come.
#[derive(Default)]
struct TexelTally {
    max: f64,
    sum: f64,
    wrong: u64,
    count: u64,
}

impl TexelTally {
    fn take(&mut self, right: [Value; 2], found: [f32; 2], even: bool) {
        let [u, v] = [0, 1].map(|i: usize| right[i].distance(found[i]) * f64::from(TEXTURE_SIDE));
        let error = u.max(v);
        self.max = self.max.max(error);
        if even {
            self.count += 1;
            self.sum += error;
            let wrong = |i: usize| right_texel(right[i]) != texel(found[i]);
            self.wrong += u64::from(wrong(0) || wrong(1));
        }
    }

    fn result(self) -> Option<Texels> {
        let count = self.count as f64;
        (self.count > 0).then(|| Texels {
            max: self.max,
            mean: self.sum / count,
            wrong_percent: 100.0 * self.wrong as f64 / count,
        })
    }
}

/// The texel's number along an axis, not wrapped.
fn texel(coordinate: f32) -> f64 {
    (f64::from(coordinate) * f64::from(TEXTURE_SIDE)).floor()
}

fn right_texel(coordinate: Value) -> f64 {
    let product = coordinate.high * f64::from(TEXTURE_SIDE);
    let whole = product.floor();
    if whole == product && coordinate.low < 0.0 { whole - 1.0 } else { whole }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Comparisons with NaN are false: it must not pass for the best of all values.
    #[test]
    fn what_is_no_number_keeps_no_bound() {
        let right = Value { high: 0.75, low: 0.0, error: 0.0 };
        let (mut tally, mut promise) = (Tally::default(), Kept::default());
        for found in [f32::NAN, 0.75] {
            tally.take(right.ulp(found), true);
            promise.take(right.ulp(found), 0.5);
        }
        assert_eq!((tally.max, promise.worst), (f64::INFINITY, f64::INFINITY));
    }
}
