//! What was drawn, pixel by pixel; targets with canaries round them.

use hyperspan::shade::Fragment;
use hyperspan::target::Plane;

/// Numbers kept of a pixel: a mark, the depth and five attributes. Neither w nor 1/w, which
/// scale with the polygon.
pub(super) const RECORD: usize = 7;

pub(super) fn record(fragment: &Fragment<'_>) -> [u32; RECORD] {
    let mut out = [1, fragment.depth().to_bits(), 0, 0, 0, 0, 0];
    for k in 0..fragment.attribute_count() {
        out[2 + k] = fragment.attribute(k).to_bits();
    }
    out
}

/// A plane with canaries before it, behind it and between its rows.
pub(super) struct Framed<P> {
    data: Vec<P>,
    pub(super) width: u32,
    height: u32,
    canary: P,
}

/// Elements before the first row and behind each.
pub(super) const FRAME: usize = 3;

impl<P: Copy + PartialEq> Framed<P> {
    pub(super) fn new(width: u32, height: u32, clear: P, canary: P) -> Self {
        let stride = width as usize + FRAME;
        let data = vec![canary; FRAME + height as usize * stride];
        let mut framed = Self { data, width, height, canary };
        framed.plane().clear(clear);
        framed
    }

    pub(super) fn plane(&mut self) -> Plane<'_, P> {
        let stride = self.width as usize + FRAME;
        Plane::with_stride(&mut self.data[FRAME..], self.width, self.height, stride)
            .expect("long enough")
    }

    /// What lies inside, once all canaries are found alive.
    pub(super) fn inside(self) -> Vec<P> {
        let (frame, rows) = self.data.split_at(FRAME);
        let alive = |part: &[P]| part.iter().all(|p| *p == self.canary);
        assert!(alive(frame), "written before the target");
        let mut inside = Vec::new();
        for row in rows.chunks_exact(self.width as usize + FRAME) {
            let (row, gap) = row.split_at(self.width as usize);
            assert!(alive(gap), "written between the rows or behind them");
            inside.extend_from_slice(row);
        }
        inside
    }
}

/// What was drawn, without the frame.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub(super) width: u32,
    pub(super) pixels: Vec<[u32; RECORD]>,
    pub(super) depths: Vec<f32>,
}

impl Picture {
    pub(super) fn crop(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        let index = |i: u32| ((y + i / width) * self.width + x + i % width) as usize;
        let all = || (0..width * height).map(index);
        Self {
            width,
            pixels: all().map(|i| self.pixels[i]).collect(),
            depths: all().map(|i| self.depths[i]).collect(),
        }
    }

    /// Without attribute `k`.
    pub(super) fn without(mut self, k: usize) -> Self {
        for pixel in &mut self.pixels {
            pixel[2 + k] = 0;
        }
        self
    }

    #[track_caller]
    pub(super) fn must_equal(&self, other: &Self, what: &str) {
        let pixels = self.pixels.iter().zip(&other.pixels);
        let depths = self.depths.iter().zip(&other.depths);
        for (i, ((p, q), (d, e))) in (0..).zip(pixels.zip(depths)) {
            let (x, y) = (i % self.width, i / self.width);
            assert_eq!(p, q, "{what}: the pixel at {x}, {y} differs");
            assert_eq!(d.to_bits(), e.to_bits(), "{what}: the depth at {x}, {y} differs");
        }
        assert_eq!(self.pixels.len(), other.pixels.len());
    }
}
