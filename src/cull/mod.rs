//! Bounding volumes against the view volume: what a whole mesh, or a part of it, is to a picture,
//! before any of its polygons is looked at.
//!
//! All in `f64` and rounded outward: what is `Outside` draws no pixel, and nothing clips what is
//! `Inside`. That holds for positions that are taken to clip space by
//! [`transform`](crate::camera::transform), or as exactly. docs/precision.md, "Bounding volumes",
//! derives the bounds.

mod hierarchy;

use glam::{DMat4, DVec3, DVec4};

use crate::depth::DepthSource;
use crate::space::{DepthRange, PixelRect, Viewport};

pub use hierarchy::{Clusters, Hierarchy, Walk};

/// What a volume is to the view volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Inclusion {
    /// Nothing of it can be seen.
    Outside,
    /// Some of it may be, and some not.
    Crossing,
    /// All of it lies within.
    Inside,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    low: DVec3,
    high: DVec3,
}

impl BoundingBox {
    /// Nothing; it is outside of every view.
    pub const EMPTY: Self =
        Self { low: DVec3::splat(f64::INFINITY), high: DVec3::splat(f64::NEG_INFINITY) };

    /// Everything.
    const ALL: Self =
        Self { low: DVec3::splat(f64::NEG_INFINITY), high: DVec3::splat(f64::INFINITY) };

    /// Grows until it holds `point`; one that is not finite makes it hold everything.
    #[inline]
    pub fn add(&mut self, point: [f64; 3]) {
        let point = DVec3::from_array(point);
        if point.is_finite() {
            *self = Self { low: self.low.min(point), high: self.high.max(point) };
        } else {
            *self = Self::ALL;
        }
    }

    /// Grows until it holds `other`.
    #[inline]
    fn join(&mut self, other: &Self) {
        *self = Self { low: self.low.min(other.low), high: self.high.max(other.high) };
    }

    /// Does it hold nothing?
    pub fn is_empty(&self) -> bool {
        self.low.cmpgt(self.high).any()
    }

    /// The corners.
    fn corners(&self) -> [DVec3; 8] {
        let pick = |i: usize, bit: usize, low: f64, high: f64| {
            if i >> bit & 1 == 0 { low } else { high }
        };
        core::array::from_fn(|i| {
            DVec3::new(
                pick(i, 0, self.low.x, self.high.x),
                pick(i, 1, self.low.y, self.high.y),
                pick(i, 2, self.low.z, self.high.z),
            )
        })
    }
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Its centre.
    pub centre: [f64; 3],
    /// Not negative.
    pub radius: f64,
}

/// Times the sum of the magnitudes that a clip distance is made of: its error, the caller's
/// transform included. 16 roundings.
const ERROR: f64 = 16.0 * f64::EPSILON;

/// A plane in object space, with its inside where a x + b y + c z + d is not negative, and the
/// magnitudes that its coefficients were made of.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    normal: DVec3,
    offset: f64,
    sizes: DVec3,
    offset_size: f64,
}

impl Plane {
    /// Where `row` + `by` `w_row` is not negative.
    fn new(row: DVec4, by: f64, w_row: DVec4) -> Self {
        let sum = row + w_row * by;
        let size = row.abs() + (w_row * by).abs();
        Self { normal: sum.truncate(), offset: sum.w, sizes: size.truncate(), offset_size: size.w }
    }

    /// Of points `reach` round `centre`, along each axis, whose distances differ by `radius` at
    /// most.
    #[inline]
    fn include(&self, centre: DVec3, reach: DVec3, radius: f64) -> Inclusion {
        let distance = dot(self.normal, centre) + self.offset;
        let error = ERROR * (dot(self.sizes, centre.abs() + reach) + self.offset_size);
        // What is no number is neither.
        if distance + radius < -error {
            Inclusion::Outside
        } else if distance - radius > error {
            Inclusion::Inside
        } else {
            Inclusion::Crossing
        }
    }
}

/// What a camera sees through a rectangle of pixels, in the space that its matrix takes positions
/// from.
#[derive(Clone, Copy, Debug)]
pub struct ViewVolume {
    matrix: DMat4,
    viewport: Viewport,
    pixels: PixelRect,
    planes: [Plane; 6],
}

impl ViewVolume {
    /// Of all pixels of `viewport`; `matrix` takes positions to its clip space.
    pub fn new(matrix: DMat4, viewport: Viewport) -> Self {
        Self::of_crop(matrix, viewport, viewport.rect())
    }

    /// Of those of `pixels`, in the framebuffer: so that a crop costs its share.
    pub fn of_crop(matrix: DMat4, viewport: Viewport, pixels: PixelRect) -> Self {
        let pixels = viewport.rect().intersect(pixels);
        let [x, y, z, w] = [matrix.row(0), matrix.row(1), matrix.row(2), matrix.row(3)];
        let [half_w, half_h] = viewport.half_size();
        let [centre_x, centre_y] = viewport.centre();
        // Centres are half a pixel within: further than the grid can move anything.
        let column = |c: i32| (f64::from(c) - centre_x) / half_w;
        let row = |r: i32| (centre_y - f64::from(r)) / half_h;
        let near = match viewport.depth_range() {
            DepthRange::ZeroToOne => 0.0,
            DepthRange::MinusOneToOne => 1.0,
        };
        let planes = [
            Plane::new(x, -column(pixels.x0), w),
            Plane::new(-x, column(pixels.x1), w),
            Plane::new(y, -row(pixels.y1), w),
            Plane::new(-y, row(pixels.y0), w),
            Plane::new(z, near, w),
            Plane::new(-z, 1.0, w),
        ];
        Self { matrix, viewport, pixels, planes }
    }

    /// What `bounds` is to it.
    #[inline]
    pub fn include(&self, bounds: &BoundingBox) -> Inclusion {
        if bounds.is_empty() || self.pixels.is_empty() {
            return Inclusion::Outside;
        }
        let (centre, reach) = ((bounds.low + bounds.high) * 0.5, (bounds.high - bounds.low) * 0.5);
        self.of_all(|plane| plane.include(centre, reach, dot(plane.normal.abs(), reach)))
    }

    /// What `sphere` is to it.
    #[inline]
    pub fn include_sphere(&self, sphere: &BoundingSphere) -> Inclusion {
        if self.pixels.is_empty() {
            return Inclusion::Outside;
        }
        let (centre, radius) = (DVec3::from_array(sphere.centre), sphere.radius);
        self.of_all(|plane| {
            let square = dot(plane.normal, plane.normal);
            // Below, numbers may have vanished.
            let tiny = square < 1e-280;
            let length =
                if tiny { dot(plane.normal.abs(), DVec3::ONE) } else { libm::sqrt(square) };
            plane.include(centre, DVec3::splat(radius), length * radius)
        })
    }

    #[inline]
    fn of_all(&self, include: impl Fn(&Plane) -> Inclusion) -> Inclusion {
        let mut all = Inclusion::Inside;
        for plane in &self.planes {
            match include(plane) {
                Inclusion::Outside => return Inclusion::Outside,
                Inclusion::Crossing => all = Inclusion::Crossing,
                Inclusion::Inside => {}
            }
        }
        all
    }

    /// The pixels that points of `bounds` may lie in, of those that are seen, and what their
    /// depths lie between; nothing if some of it may be before the near plane.
    pub(crate) fn project(
        &self,
        bounds: &BoundingBox,
        source: DepthSource,
    ) -> Option<(PixelRect, [f64; 2])> {
        let Self { matrix, viewport, pixels, .. } = self;
        let rows = [matrix.row(0), matrix.row(1), matrix.row(2), matrix.row(3)];
        let [half_w, half_h] = viewport.half_size();
        let [centre_x, centre_y] = viewport.centre();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut depths = [f64::INFINITY, f64::NEG_INFINITY];
        for corner in bounds.corners() {
            let corner = corner.extend(1.0);
            let [x, y, z, w] = rows.map(|row| dot4(row, corner));
            let [x_size, y_size, z_size, w_size] = rows.map(|row| dot4(row.abs(), corner.abs()));
            let (z, z_size) = match viewport.depth_range() {
                DepthRange::ZeroToOne => (z, z_size),
                DepthRange::MinusOneToOne => ((z + w) / 2.0, z_size + w_size),
            };
            // Also where it is no number. The bounds below are of first order.
            let certain = ERROR * (x_size + y_size + w_size) < w * SMALL && z >= ERROR * z_size;
            if !certain {
                return None;
            }
            let (n, n_size) = match source {
                DepthSource::Z => (z, z_size),
                DepthSource::InvW => (1.0, 0.0),
            };
            let depth = n / w;
            let error = 2.0 * ERROR * (n_size + depth * w_size) / w;
            depths = [lesser(depths[0], depth - error), greater(depths[1], depth + error)];
            let at = [x / w * half_w + centre_x, centre_y - y / w * half_h];
            for k in 0..2 {
                (low[k], high[k]) = (lesser(low[k], at[k]), greater(high[k], at[k]));
            }
        }
        // A pixel more on each side than the errors and the grid can move anything.
        let column = |c: f64, by: f64| whole(c + by);
        let around = PixelRect {
            x0: column(low[0], -1.0),
            y0: column(low[1], -1.0),
            x1: column(high[0], 2.0),
            y1: column(high[1], 2.0),
        };
        Some((pixels.intersect(around), depths))
    }
}

/// How far a place may be off, in parts of w: a hundredth of a pixel of the widest viewport.
const SMALL: f64 = 1.0 / 1_048_576.0;

/// The whole number at or below, of any within the reach of `i32`.
#[expect(clippy::cast_possible_truncation, reason = "it saturates")]
fn whole(value: f64) -> i32 {
    libm::floor(value) as i32
}

#[inline]
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

#[inline]
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[inline]
fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

#[inline]
fn dot4(a: DVec4, b: DVec4) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w
}
