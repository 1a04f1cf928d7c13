//! Flat polygons with affine attributes, and where to look at them.

use hyperspan::space::{PixelRect, Viewport};

use super::random::Random;

/// A polygon in clip space, and the windows that are drawn of it.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) viewport: Viewport,
    /// (x, y, z, w) of each vertex.
    pub(crate) positions: Vec<[f64; 4]>,
    /// One list for each vertex.
    pub(crate) attributes: Vec<Vec<f32>>,
    pub(crate) windows: Vec<PixelRect>,
}

/// The clip position with the given depth (z/w) and w that lands on `at`, in pixels from the
/// viewport's corner.
pub(crate) fn unproject(viewport: Viewport, at: [f64; 2], depth: f64, w: f64) -> [f64; 4] {
    let half = [viewport.width(), viewport.height()].map(|side| f64::from(side) / 2.0);
    let [x, y] = [(at[0] - half[0]) / half[0] * w, (half[1] - at[1]) / half[1] * w];
    [x, y, (depth * w).clamp(0.0, w), w]
}

/// A window round `at`, in pixels from the viewport's corner; all of a small viewport.
pub(crate) fn window(viewport: Viewport, at: [f64; 2]) -> PixelRect {
    const SIZE: [i32; 2] = [24, 10];
    const SMALL: u32 = 1024;
    let rect = viewport.rect();
    if viewport.width() * viewport.height() <= SMALL {
        return rect;
    }
    let [x, y] = [0, 1].map(|i| at[i] as i32 - SIZE[i] / 2);
    let [x, y] = [rect.x0.saturating_add(x), rect.y0.saturating_add(y)];
    PixelRect::new(x, y, SIZE[0].unsigned_abs(), SIZE[1].unsigned_abs()).intersect(rect)
}

/// One of the three corners that carry a shape's plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// Pixels from the viewport's corner.
    pub(crate) at: [f64; 2],
    /// z/w, 0 to 1.
    pub(crate) depth: f64,
    pub(crate) w: f64,
}

/// A polygon on the plane of three corners, all of them in front of the eye.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub(crate) viewport: Viewport,
    pub(crate) corners: [Corner; 3],
    /// The values at the corners.
    pub(crate) attributes: Vec<[f64; 3]>,
    /// Its vertices, as weights of the corners in the framebuffer; none stands for the corners.
    pub(crate) outline: Vec<[f64; 3]>,
}

impl Shape {
    /// A triangle anywhere, most of it in the viewport. Of its three w, the greatest is `ratio`
    /// times the least.
    pub(crate) fn triangle(viewport: Viewport, ratio: f64, random: &mut Random) -> Self {
        const BEYOND: f64 = 0.1;
        let side = [viewport.width(), viewport.height()].map(f64::from);
        let mut corner = |w: f64| Corner {
            at: side.map(|side| random.within(-BEYOND, 1.0 + BEYOND) * side),
            depth: random.unit(),
            w,
        };
        let mut corners = [corner(1.0), corner(1.0), corner(ratio)];
        corners[1].w = random.up_to(ratio);
        corners.rotate_left(random.below(3));
        let attributes =
            vec![[0, 1, 2].map(|_| random.within(-1.0, 1.0)), [0, 1, 2].map(|_| random.unit())];
        Self { viewport, corners, attributes, outline: Vec::new() }
    }

    /// What lies at the mean of the corners with `weights`, in pixels from the viewport's corner.
    pub(crate) fn at(&self, weights: [f64; 3]) -> [f64; 2] {
        [0, 1].map(|i| mean(weights, self.corners.map(|corner| corner.at[i])))
    }

    /// The polygon, to be looked at in `windows`.
    pub(crate) fn case(&self, windows: Vec<PixelRect>) -> Case {
        let viewport = self.viewport;
        if self.outline.is_empty() {
            let place = |corner: &Corner| unproject(viewport, corner.at, corner.depth, corner.w);
            let positions = self.corners.iter().map(place).collect();
            let values = |k: usize| self.attributes.iter().map(|list| list[k] as f32).collect();
            return Case { viewport, positions, attributes: (0..3).map(values).collect(), windows };
        }
        let (mut positions, mut attributes) = (Vec::new(), Vec::new());
        for weights in &self.outline {
            // 1/w and depth are linear in the framebuffer.
            let shares = [0, 1, 2].map(|k| weights[k] / self.corners[k].w);
            let inv_w = shares[0] + shares[1] + shares[2];
            let depth = mean(*weights, self.corners.map(|corner| corner.depth));
            positions.push(unproject(viewport, self.at(*weights), depth, 1.0 / inv_w));
            let value = |list: &[f64; 3]| (mean(shares, *list) / inv_w) as f32;
            attributes.push(self.attributes.iter().map(value).collect());
        }
        Case { viewport, positions, attributes, windows }
    }

    /// The polygon, to be looked at where errors are largest: at its corners, which are the ends
    /// of spans and the extremes of w, and somewhere inside.
    pub(crate) fn case_at_extremes(&self, random: &mut Random) -> Case {
        // Of a corner's surroundings most lies outside; some pixels inwards there is more.
        const PIXELS: f64 = 6.0;
        let reach = |i: usize| {
            let of_axis = || self.corners.iter().map(|corner| corner.at[i]);
            of_axis().fold(f64::NEG_INFINITY, f64::max) - of_axis().fold(f64::INFINITY, f64::min)
        };
        let inwards = (PIXELS / reach(0).max(reach(1)).max(1.0)).min(0.1);
        let mut places = [0, 1, 2].map(|k| {
            let mut weights = [inwards; 3];
            weights[k] = 1.0 - 2.0 * inwards;
            weights
        });
        let part = [0, 1, 2].map(|_| random.within(0.01, 1.0));
        let sum = part[0] + part[1] + part[2];
        let inside = part.map(|p| p / sum);
        places.rotate_left(random.below(3));
        let places = [places[0], places[1], inside];
        self.case(places.map(|weights| window(self.viewport, self.at(weights))).to_vec())
    }
}

fn mean(weights: [f64; 3], values: [f64; 3]) -> f64 {
    weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]
}
