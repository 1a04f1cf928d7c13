//! Pictures of the error: how far each pixel is from the right value, in colours.

use super::reference::Value;
use super::sampling::Samples;

/// The logarithm (to base 10) of an error in ulp, and its colour: half an ulp is all but black.
const COLOURS: [(f64, [f64; 3]); 6] = [
    (-0.3, [8.0, 8.0, 24.0]),
    (1.0, [40.0, 60.0, 150.0]),
    (2.5, [150.0, 40.0, 140.0]),
    (4.0, [230.0, 80.0, 50.0]),
    (5.5, [250.0, 190.0, 40.0]),
    (7.0, [255.0, 255.0, 220.0]),
];

/// RGBA, rows from the top: the greatest error of a pixel's attributes, of the polygon that was
/// drawn last. Nothing where there is no polygon.
pub(crate) fn picture(samples: &Samples, found: &[f32], [width, height]: [u32; 2]) -> Vec<[u8; 4]> {
    let mut pixels = vec![[0; 4]; width as usize * height as usize];
    for (i, sample) in samples.list.iter().enumerate() {
        let all = i * samples.stride + 1..(i + 1) * samples.stride;
        let errors = samples.right[all.clone()].iter().zip(&found[all]);
        let ulp = |(right, found): (&Option<Value>, &f32)| right.map_or(0.0, |r| r.ulp(*found));
        let error = errors.map(ulp).fold(0.0, f64::max);
        let [x, y] = [sample.x, sample.y].map(|c| c.cast_unsigned() as usize);
        pixels[y * width as usize + x] = colour(error);
    }
    pixels
}

/// The colour of an error in ulp.
fn colour(ulp: f64) -> [u8; 4] {
    let [first, .., last] = COLOURS;
    let level = libm::log10(ulp).clamp(first.0, last.0);
    let mut colour = last.1;
    for pair in COLOURS.windows(2) {
        let [(from, a), (to, b)] = [pair[0], pair[1]];
        if level < to {
            let part = (level - from) / (to - from);
            colour = [0, 1, 2].map(|i: usize| a[i] + (b[i] - a[i]) * part);
            break;
        }
    }
    let [r, g, b] = colour.map(|c| c.round() as u8);
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_grow_with_the_error() {
        let sum = |ulp: f64| colour(ulp).iter().map(|c| u32::from(*c)).sum::<u32>();
        let errors = [0.0, 0.5, 2.0, 10.0, 1e3, 1e5, 1e6, 1e7];
        let sums = errors.map(sum);
        assert_eq!(sums[0], sums[1]);
        assert!(sums[1..].is_sorted_by(|a, b| a < b), "{sums:?}");
        assert_eq!(colour(f64::INFINITY), [255, 255, 220, 255]);
    }
}
