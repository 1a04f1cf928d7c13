//! Polygons of any bytes: vertices on pixel centres, on planes and behind the eye, copies,
//! collinear and nearly collinear ones; and convex ones on a plane with affine attributes.

use hyperspan::space::Viewport;
use hyperspan::varying::Interpolation;

use super::bytes::Bytes;

/// A polygon is brought to the size of its largest number: numbers smaller by more than this
/// are lost.
pub(super) const RATIO: f64 = 1e280;

/// Vertices and their attributes, `count` for each.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) positions: Vec<[f64; 4]>,
    pub(super) attributes: Vec<f32>,
    pub(super) count: usize,
    /// Was it made convex, on a plane?
    pub(super) flat: bool,
}

impl Shape {
    pub(super) fn new(
        bytes: &mut Bytes<'_>,
        count: usize,
        viewport: Viewport,
        origin: (i32, i32),
    ) -> Self {
        let n = usize::from(bytes.below(9));
        let mut shape = if bytes.below(3) == 0 {
            Self::flat(bytes, n, count, viewport, origin)
        } else {
            Self::loose(bytes, n, count, viewport, origin)
        };
        for _ in 0..bytes.below(4) {
            shape.nudge(bytes, viewport);
        }
        shape
    }

    /// Vertices one by one.
    fn loose(
        bytes: &mut Bytes<'_>,
        n: usize,
        count: usize,
        viewport: Viewport,
        origin: (i32, i32),
    ) -> Self {
        let mut shape = Self { positions: Vec::new(), attributes: Vec::new(), count, flat: false };
        for _ in 0..n {
            let position = shape.vertex(bytes, viewport, origin);
            shape.positions.push(position);
        }
        let values = n * count;
        let copies = bytes.below(4) == 0;
        for i in 0..values {
            let value = match shape.attributes.get(i.wrapping_sub(count)) {
                Some(value) if copies => *value,
                _ => bytes.number_f32(),
            };
            shape.attributes.push(value);
        }
        shape
    }

    /// Puts a vertex onto a plane: a side of the view or of the guard band, or w = 0.
    fn nudge(&mut self, bytes: &mut Bytes<'_>, viewport: Viewport) {
        let which = usize::from(bytes.byte());
        let sides = [viewport.width(), viewport.height()];
        let Some(i) = which.checked_rem(self.positions.len()) else { return };
        let p = &mut self.positions[i];
        let (axis, w) = (usize::from(bytes.below(2)), p[3]);
        let half = f64::from(sides[axis]) / 2.0;
        match bytes.below(8) {
            0 => p[axis] = w,
            1 => p[axis] = -w,
            // x/w W/2 + W/2 is a corner of the guard band; y points up.
            2 => p[axis] = (32767.0 - half) / half * w,
            3 => p[axis] = -(32767.0 + half) / half * w,
            4 => p[2] = bytes.pick(&[0.0, -0.0, w, -w]),
            5 => p[3] = bytes.pick(&[0.0, -0.0, 1e-300, -1e-300, 1e-9, -1e-9]),
            6 => p[3] = -w,
            _ => p[axis] = p[1 - axis],
        }
        self.flat = false;
    }

    /// A plane for the user to clip by: any, one of the others or nearly, through a vertex, or
    /// parallel to a side of the view.
    pub(super) fn plane(&self, bytes: &mut Bytes<'_>, others: &[[f64; 4]]) -> [f64; 4] {
        let mut plane = match (bytes.below(4), others.last()) {
            (0, Some(last)) => last.map(|c| -c),
            (1, Some(last)) => {
                let mut plane = *last;
                plane[usize::from(bytes.below(4))] *= 1.0 + f64::EPSILON;
                plane
            }
            (2, _) => {
                let mut plane = [0.0; 4];
                plane[usize::from(bytes.below(3))] = bytes.pick(&[1.0, -1.0]);
                plane[3] = bytes.pick(&[0.0, 1.0, 0.5, -0.5]);
                plane
            }
            _ => [(); 4].map(|()| bytes.number()),
        };
        let which = usize::from(bytes.byte());
        if let (Some(i), 1) = (which.checked_rem(self.positions.len()), bytes.below(2)) {
            let [x, y, z, w] = self.positions[i];
            plane[3] = -(plane[0] * x + plane[1] * y + plane[2] * z) / w;
        }
        plane
    }

    fn vertex(&self, bytes: &mut Bytes<'_>, viewport: Viewport, origin: (i32, i32)) -> [f64; 4] {
        let earlier = |bytes: &mut Bytes<'_>| match self.positions.len() {
            0 => [0.25, 0.5, 0.5, 1.0],
            n => self.positions[usize::from(bytes.byte()) % n],
        };
        match bytes.below(8) {
            0 => [(); 4].map(|()| bytes.number()),
            1 | 2 => {
                // Eighths of a pixel round the target: pixel centres and corners are common.
                let at = [(); 2].map(|()| f64::from(bytes.small()) / 8.0 + 12.0);
                on_screen(bytes, viewport, origin, at)
            }
            3 => {
                // Within a few steps of the subpixel grid of a pixel's centre.
                let at = [(); 2].map(|()| {
                    f64::from(bytes.small() / 4) + 0.5 + f64::from(bytes.small()) / 524_288.0
                });
                on_screen(bytes, viewport, origin, at)
            }
            4 => {
                let mut p = earlier(bytes);
                p[usize::from(bytes.below(4))] = bytes.number();
                p
            }
            5 => earlier(bytes),
            6 => {
                let factor = bytes.number();
                earlier(bytes).map(|c| c * factor)
            }
            _ => {
                // Collinear with two others.
                let (p, q) = (earlier(bytes), earlier(bytes));
                let t = f64::from(bytes.small()) / 64.0;
                [0, 1, 2, 3].map(|k| p[k] + (q[k] - p[k]) * t)
            }
        }
    }

    /// A convex polygon on a plane, with attributes that are affine over it.
    fn flat(
        bytes: &mut Bytes<'_>,
        n: usize,
        count: usize,
        viewport: Viewport,
        origin: (i32, i32),
    ) -> Self {
        let [middle, radius] =
            [(); 2].map(|()| [f64::from(bytes.byte()) / 8.0, f64::from(bytes.byte()) / 8.0]);
        let tilt = [(); 2].map(|()| f64::from(bytes.small()) / 128.0);
        let distance = f64::from(bytes.byte()) / 64.0;
        let scale = 2.0_f64.powi(bytes.small() / 2);
        let mut shape = Self { positions: Vec::new(), attributes: Vec::new(), count, flat: true };
        let weights: Vec<[f32; 3]> =
            (0..count).map(|_| [(); 3].map(|()| bytes.small() as f32)).collect();
        for i in 0..n {
            // Once round the circle, by rational numbers.
            let t = (2 * i + 1) as f64 / n as f64 - 1.0;
            let t = t / (1.0 - t * t + 1e-3);
            let [c, s] = [(1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t)];
            let w = distance + tilt[0] * c + tilt[1] * s;
            let at = [middle[0] + radius[0] * c, middle[1] + radius[1] * s];
            let ndc = to_ndc(viewport, origin, at);
            // Affine in c and s, so that all lies on one plane.
            shape.positions.push([ndc[0], ndc[1], 0.5 * w, w].map(|v| v * scale));
            let affine = weights.iter().map(|k| k[0] + k[1] * c as f32 + k[2] * s as f32);
            shape.attributes.extend(affine);
        }
        shape
    }

    /// Gives all vertices the first one's values of flat attributes.
    pub(super) fn even_out(&mut self, interpolation: &[Interpolation]) {
        for (k, how) in interpolation.iter().enumerate().take(self.count) {
            if let (Interpolation::Flat, Some(value)) = (how, self.attributes.get(k).copied()) {
                self.attributes.iter_mut().skip(k).step_by(self.count).for_each(|a| *a = value);
            }
        }
    }

    /// Vertex `first` first.
    pub(super) fn rotated(&self, first: usize) -> Self {
        let mut shape = self.clone();
        if !self.positions.is_empty() {
            let first = first % self.positions.len();
            shape.positions.rotate_left(first);
            shape.attributes.rotate_left(first * self.count);
        }
        shape
    }

    /// All four coordinates of all vertices times `factor`, if nothing is lost by that.
    pub(super) fn scaled(&self, factor: f64) -> Option<Self> {
        let mut shape = self.clone();
        for value in shape.positions.iter_mut().flatten() {
            let scaled = *value * factor;
            let exact = scaled / factor == *value && scaled.is_finite();
            if value.is_finite() && !exact {
                return None;
            }
            *value = scaled;
        }
        Some(shape)
    }

    /// Is attribute `k` finite at all vertices?
    pub(super) fn is_finite(&self, k: usize) -> bool {
        self.column(k).all(f32::is_finite)
    }

    /// Are two vertices at the same place?
    pub(super) fn has_copies(&self) -> bool {
        let others = |i: usize| &self.positions[..i];
        self.positions.iter().enumerate().any(|(i, p)| others(i).contains(p))
    }

    pub(super) fn column(&self, k: usize) -> impl Iterator<Item = f32> {
        self.attributes.iter().skip(k).step_by(self.count.max(1)).copied()
    }
}

pub(super) fn to_ndc(viewport: Viewport, origin: (i32, i32), at: [f64; 2]) -> [f64; 2] {
    let rect = viewport.rect();
    let half = [f64::from(viewport.width()) / 2.0, f64::from(viewport.height()) / 2.0];
    let x = (f64::from(origin.0) + at[0] - f64::from(rect.x0) - half[0]) / half[0];
    let y = (f64::from(rect.y0) + half[1] - f64::from(origin.1) - at[1]) / half[1];
    [x, y]
}

/// A vertex at `at`, in pixels from the target's corner, at some distance.
pub(super) fn on_screen(
    bytes: &mut Bytes<'_>,
    viewport: Viewport,
    origin: (i32, i32),
    at: [f64; 2],
) -> [f64; 4] {
    let w = bytes.pick(&[1.0, 1.0, 1.0, 2.0, 0.5, 3.0, 1e-6, 1e6, 0.1, -1.0, 1e-300, 1e30]);
    let z = bytes.pick(&[0.5, 0.5, 0.0, 1.0, 0.25, -0.5, 1.5, 1e-3]);
    let [x, y] = to_ndc(viewport, origin, at);
    [x * w, y * w, z * w, w]
}
