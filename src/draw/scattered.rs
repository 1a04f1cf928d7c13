//! Do the polygons of a batch that follow one another lie far apart?
//!
//! One thread draws a list as it comes, which costs least where what comes next lies near. If it does not, and the
//! target is larger than a core's caches, every polygon waits for memory: then the list is sorted into bands of
//! rows first, as it is for several threads. docs/benchmarks.md, "Bands on one thread", has what it saves where.

use fearless_simd::dispatch;

use crate::batch::Batch;
use crate::space::PixelRect;
use crate::tiler::Tiler;
use crate::tiler::bunch::FAR;

/// Below so many pixels, 8 MiB of colours and depths, caches hold enough of them.
const LEAST_PIXELS: u64 = 1 << 20;

/// Fewer polygons are drawn before anything is won.
const LEAST_POLYGONS: usize = 1024;

/// So many places of the list are looked at, and no more once that many polygons are found in view.
const PLACES: u32 = 256;
const SAMPLES: u64 = 32;

/// It takes so many to tell.
const LEAST_SAMPLES: u64 = 3;

/// From one place to the next, as a part of the list with 32 fraction bits: the golden ratio, which comes everywhere,
/// and is in step with nothing that repeats.
const STRIDE: u32 = 0x9E37_79B9;

/// Polygons that follow one another are often of one thing: so many later there is another.
const LATER: usize = 8;

/// A polygon's pixels, times those of the target, from which on sorting wins: 200 of 1920 x 1080.
const WORTH: u64 = 400_000_000;

/// Is `batch` worth being sorted, to be drawn in `window` by one thread?
///
/// Compiled for each type of batch, and out of line.
#[inline(never)]
pub(super) fn is_scattered<B: Batch + ?Sized>(batch: &B, tiler: &Tiler, window: PixelRect) -> bool {
    let pixels = window.area();
    let n = batch.len();
    if pixels < LEAST_PIXELS || n < LEAST_POLYGONS {
        return false;
    }
    let (mut seen, mut far, mut covered) = (0, 0, 0);
    dispatch!(tiler.simd().0, simd => {
        for k in 0..PLACES {
            let part = u128::from(k.wrapping_mul(STRIDE)) * (n - LATER) as u128;
            let i = (part >> 32) as usize;
            let [this, later] = [i, i + LATER].map(|i| {
                let bounds = tiler.bounds_in_view(simd, &batch.polygon(i))?.intersect(window);
                (!bounds.is_empty()).then_some(bounds)
            });
            let (Some(this), Some(later)) = (this, later) else { continue };
            far += u64::from(this.y0.abs_diff(later.y0) > FAR);
            covered += this.area();
            seen += 1;
            if seen == SAMPLES {
                break;
            }
        }
    });
    seen >= LEAST_SAMPLES && 2 * far >= seen && covered.saturating_mul(pixels) >= seen * WORTH
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::polygon::Vertex;
    use crate::space::Viewport;

    const SIDES: [u32; 2] = [1920, 1080];

    /// `count` right triangles with legs of `side` pixels, polygon `i` at `place(i)` of the target's sides.
    fn triangles(
        count: u32,
        side: f64,
        place: impl Fn(f64) -> [f64; 2],
    ) -> Vec<[Vertex<0, [f64; 4]>; 3]> {
        let triangle = |i: u32| {
            let [x, y] = place(f64::from(i));
            [[0.0, 0.0], [side, 0.0], [0.0, side]].map(|[dx, dy]| {
                let [x, y] = [x + dx / f64::from(SIDES[0]), y + dy / f64::from(SIDES[1])];
                Vertex::new([2.0 * x - 1.0, 2.0 * y - 1.0, 0.5, 1.0], [])
            })
        };
        (0..count).map(triangle).collect()
    }

    /// All over the target, by the golden ratio.
    fn anywhere(i: f64) -> [f64; 2] {
        [i * 0.754_877_666 % 0.95, i * 0.569_840_291 % 0.95]
    }

    #[test]
    fn lists_are_scattered_that_are_worth_sorting() {
        let [width, height] = SIDES;
        let tiler = Tiler::new(Viewport::new(0, 0, width, height).expect("small"));
        let whole = PixelRect::new(0, 0, width, height);
        let is = |batch: &Vec<_>, window| is_scattered(batch, &tiler, window);
        let large = triangles(3000, 20.0, anywhere);
        assert!(is(&large, whole));
        // As rows of a picture come, or columns: near each other.
        let in_rows = |i: f64| [i * 0.02 % 0.95, (i * 0.02 / 0.95).floor() * 0.015 % 0.95];
        assert!(!is(&triangles(3000, 20.0, in_rows), whole));
        // Too small, too few, too small a target, or none of them in it.
        assert!(!is(&triangles(3000, 10.0, anywhere), whole));
        assert!(!is(&triangles(1000, 20.0, anywhere), whole));
        assert!(!is(&large, PixelRect::new(0, 0, 960, 1080)));
        assert!(!is(&large, PixelRect::default()));
        assert!(!is(&triangles(3000, 20.0, |_| [2.0, 2.0]), whole));
        // Most are out of view, and those that are not are scattered.
        let few = |i: f64| if i % 4.0 < 3.0 { [2.0, 2.0] } else { anywhere(i / 4.0) };
        assert!(is(&triangles(12_000, 20.0, few), whole));
    }
}
