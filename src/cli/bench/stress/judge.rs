//! Draws a polygon in both precisions and says how much of the promised bounds its errors take.

use hyperspan::polygon::Strided;
use hyperspan::shade::Fragment;
use hyperspan::space::PixelRect;
use hyperspan::target::Plane;
use hyperspan::tiler::{Precision, Tiler};

use super::super::reference::{Reference, Value};
use super::Case;

/// What has a bound of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Attribute,
    Depth,
    W,
    InvW,
}

impl Quantity {
    pub(crate) const ALL: [Self; 4] = [Self::Attribute, Self::Depth, Self::W, Self::InvW];

    /// As tables call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Attribute => "attribute",
            Self::Depth => "depth",
            Self::W => "w",
            Self::InvW => "1/w",
        }
    }

    /// By how much a value may be off. `most` is the greatest magnitude of the attribute at the
    /// vertices.
    fn bound(self, precision: Precision, right: Value, most: f64) -> f64 {
        const U: f64 = 1.0 / (1_u64 << 24) as f64;
        let size = right.high.abs();
        match (precision, self) {
            (Precision::Fast, Self::Attribute) => 4.0 * U * size + 3.0 * U * most,
            (Precision::Fast, Self::InvW) => 7.0 * U * size,
            (Precision::Fast, Self::Depth) => right.unit(),
            // w is as good as in `Exact`.
            (Precision::Fast, Self::W) | (Precision::Exact, _) => right.unit() / 2.0,
        }
    }
}

/// The precisions, in the order of [`Judged::worst`].
pub(crate) const PRECISIONS: [Precision; 2] = [Precision::Fast, Precision::Exact];

/// What became of some polygons.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Judged {
    pub(crate) pixels: u64,
    /// Compared, in both precisions together.
    pub(crate) values: u64,
    /// Polygons that crossed a plane.
    pub(crate) clipped: u64,
    /// Without a reference: beyond the plane's horizon, or 1/w at the rim of a clipped polygon.
    pub(crate) left_out: u64,
    /// The largest error over its bound, for each precision and quantity.
    pub(crate) worst: [[f64; 4]; 2],
    /// Errors of attributes in `Fast` over their bounds, and how many there are.
    pub(crate) sum: f64,
    pub(crate) attributes: u64,
}

impl Judged {
    /// Both together.
    pub(crate) fn and(self, other: Self) -> Self {
        let greater = |p: usize, q: usize| self.worst[p][q].max(other.worst[p][q]);
        Self {
            pixels: self.pixels + other.pixels,
            values: self.values + other.values,
            clipped: self.clipped + other.clipped,
            left_out: self.left_out + other.left_out,
            worst: [0, 1].map(|p| [0, 1, 2, 3].map(|q| greater(p, q))),
            sum: self.sum + other.sum,
            attributes: self.attributes + other.attributes,
        }
    }

    /// The largest error over its bound, of all.
    pub(crate) fn worst_of_all(&self) -> f64 {
        self.worst.iter().flatten().copied().fold(0.0, f64::max)
    }

    /// That of attributes in `Fast`.
    pub(crate) fn worst_of_fast(&self) -> f64 {
        self.worst[0][0]
    }

    /// How bad it is: whatever breaks its bound is worse than all that does not.
    pub(crate) fn badness(&self) -> f64 {
        let most = self.worst_of_all();
        if most > 1.0 { most } else { self.worst_of_fast() }
    }

    /// The mean error of attributes in `Fast` over its bound.
    pub(crate) fn mean_of_fast(&self) -> f64 {
        if self.attributes == 0 { 0.0 } else { self.sum / self.attributes as f64 }
    }
}

/// What a shader saw: places, and for each depth, w, 1/w and the attributes.
#[derive(Debug, Default)]
struct Seen {
    places: Vec<[i32; 2]>,
    numbers: Vec<f32>,
    clipped: u64,
}

/// Draws `case` and compares. A polygon that the reference does not know (edge-on) counts nothing.
pub(crate) fn judge(case: &Case) -> Judged {
    let mut judged = Judged::default();
    let Some(reference) = Reference::new(&case.positions, &case.attributes, &case.viewport) else {
        return judged;
    };
    let count = case.attributes[0].len();
    let most: Vec<f64> = (0..count)
        .map(|k| case.attributes.iter().map(|list| f64::from(list[k].abs())).fold(0.0, f64::max))
        .collect();
    let mut seen = [Seen::default(), Seen::default()];
    for window in case.windows.iter().filter(|window| !window.is_empty()) {
        for (seen, precision) in seen.iter_mut().zip(PRECISIONS) {
            draw(case, *window, precision, seen);
        }
        let [fast, exact] = &seen;
        if fast.places != exact.places {
            // Coverage does not depend on precision.
            judged.worst[0][0] = f64::INFINITY;
            return judged;
        }
        judged.pixels += fast.places.len() as u64;
        judged.clipped = judged.clipped.max(fast.clipped);
        for (i, &[x, y]) in fast.places.iter().enumerate() {
            let mut compare =
                |quantity: Quantity, right: Option<Value>, which: usize, most: f64| {
                    let Some(right) = right else {
                        judged.left_out += 2;
                        return;
                    };
                    judged.values += 2;
                    for (p, precision) in PRECISIONS.into_iter().enumerate() {
                        let computed = seen[p].numbers[i * (3 + count) + which];
                        let part = part(computed, right, quantity.bound(precision, right, most));
                        let worst = &mut judged.worst[p][quantity as usize];
                        *worst = worst.max(part);
                        if quantity == Quantity::Attribute && precision == Precision::Fast {
                            judged.sum += part;
                            judged.attributes += 1;
                        }
                    }
                };
            compare(Quantity::Depth, reference.depth(x, y), 0, 0.0);
            compare(Quantity::W, reference.w(x, y), 1, 0.0);
            compare(Quantity::InvW, reference.inv_w(x, y), 2, 0.0);
            for (k, most) in most.iter().enumerate() {
                compare(Quantity::Attribute, reference.attribute(k, x, y), 3 + k, *most);
            }
        }
    }
    judged
}

/// The error over its bound; what the reference itself may be off by speaks for the library.
fn part(computed: f32, right: Value, bound: f64) -> f64 {
    let off = right.distance(computed) - right.error;
    if off <= 0.0 { 0.0 } else { off / bound }
}

/// Draws one window of `case` into `seen`.
fn draw(case: &Case, window: PixelRect, precision: Precision, seen: &mut Seen) {
    seen.places.clear();
    seen.numbers.clear();
    let count = case.attributes[0].len();
    let flat = case.attributes.concat();
    let [width, height] = [window.x1.abs_diff(window.x0), window.y1.abs_diff(window.y0)];
    let mut nothing = vec![(); width as usize * height as usize];
    // Both have the sizes that they say.
    let Ok(polygon) = Strided::new(&case.positions, &flat, count, count) else { return };
    let Ok(mut target) = Plane::new(&mut nothing, width, height) else { return };
    let mut tiler = Tiler::new(case.viewport);
    tiler.set_origin(window.x0, window.y0).set_precision(precision);
    // Not a type of its own, for which drawing would be compiled once more.
    let mut record: &mut dyn FnMut(&Fragment<'_>) = &mut |pixel| {
        seen.places.push([pixel.x(), pixel.y()]);
        seen.numbers.extend([pixel.depth(), pixel.w(), pixel.inv_w()]);
        seen.numbers.extend((0..count).map(|k| pixel.attribute(k)));
    };
    tiler.draw(&polygon, &mut record, &mut target, None);
    seen.clipped = tiler.stats().clipped;
}
