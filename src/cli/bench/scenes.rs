//! What is drawn: polygons whose greatest w is a given multiple of the least.
//!
//! With more than three vertices, positions and attributes are sums of numbers of few bits, so that
//! the polygon is exactly flat and every attribute exactly affine over it: whichever three vertices
//! a rung takes, the right values are the same. Triangles have positions of any bits.

use clap::ValueEnum;
use hyperspan::space::Viewport;

use super::stress::random::Random;
use crate::failure::Failure;

/// A scene; its w ratio, number of attributes and size are parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SceneName {
    /// A quad towards the horizon: w is constant along rows.
    Floor,
    /// The same, rolled.
    RolledFloor,
    /// One to the left, one to the right: w is constant along columns.
    Walls,
    /// Floor, ceiling, two walls and the one at the end.
    Room,
    /// Triangles anywhere, the ratio in each.
    Triangles,
    /// Convex polygons of 4 to 8 vertices anywhere, the ratio in each.
    Ngons,
    /// Triangles a hundredth of a pixel to three pixels thick.
    Slivers,
}

impl SceneName {
    /// As the command line has it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Floor => "floor",
            Self::RolledFloor => "rolled-floor",
            Self::Walls => "walls",
            Self::Room => "room",
            Self::Triangles => "triangles",
            Self::Ngons => "ngons",
            Self::Slivers => "slivers",
        }
    }
}

/// Positions in clip space, and `attributes / positions` attributes for each.
#[derive(Clone, Debug)]
pub(crate) struct Facet {
    pub(crate) positions: Vec<[f64; 4]>,
    pub(crate) attributes: Vec<f32>,
}

/// A scene, ready to be drawn.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) facets: Vec<Facet>,
    pub(crate) viewport: Viewport,
    /// Of each vertex.
    pub(crate) attributes: usize,
}

/// Pixels of a picture, about: wider ones are less high, so that each takes as long.
const AREA: u32 = 1 << 18;

/// Width and height of the picture that is `width` pixels wide.
pub(crate) fn size(width: u32) -> [u32; 2] {
    [width, (AREA / width).clamp(64, width)]
}

impl Picture {
    /// `scene` with a ratio of `w_ratio` between the greatest w and the least.
    pub(crate) fn new(
        scene: SceneName,
        w_ratio: f64,
        attributes: usize,
        width: u32,
    ) -> Result<Self, Failure> {
        let [width, height] = size(width);
        let mut maker = Maker {
            facets: Vec::new(),
            attributes,
            far: w_ratio,
            random: Random::new(0x5EED + u64::from(width)),
        };
        match scene {
            SceneName::Floor => maker.floor([1.0, 0.0]),
            SceneName::RolledFloor => maker.floor([0.8, 0.6]),
            SceneName::Walls => [-1.0, 1.0].into_iter().for_each(|side| maker.wall(side, 4.0)),
            SceneName::Room => maker.room(),
            SceneName::Triangles => (0..150).for_each(|_| maker.triangle()),
            SceneName::Ngons => (0..60).for_each(|_| maker.ngon()),
            SceneName::Slivers => (0..800).for_each(|_| maker.sliver(height)),
        }
        let viewport = Viewport::new(0, 0, width, height)?;
        Ok(Self { facets: maker.facets, viewport, attributes })
    }
}

/// Attribute k is c + a s + b t over a polygon: (c, a, b). The first two are texture coordinates.
/// The first four keep away from 0; of the others some change sign, as normals do.
const ATTRIBUTES: [[f64; 3]; 8] = [
    [1.0, 3.6875, 0.0],
    [1.0, 0.0, 3.8125],
    [1.0, 1.5, 2.0],
    [5.0, -2.0, -1.5],
    [-1.0, 2.0, 0.5],
    [0.0, 1.0, 0.0],
    [1.0, -1.0, 0.25],
    [-0.5, 0.5, 1.0],
];

/// The most attributes that a vertex can have.
pub(crate) const MOST_ATTRIBUTES: usize = ATTRIBUTES.len();

/// Points in convex position, in 1/256: the first and the seventh are the ends in s.
const ROUND: [[f64; 2]; 12] = [
    [1.0, 128.0],
    [18.0, 64.0],
    [64.0, 18.0],
    [128.0, 1.0],
    [192.0, 18.0],
    [238.0, 64.0],
    [255.0, 128.0],
    [238.0, 192.0],
    [192.0, 238.0],
    [128.0, 255.0],
    [64.0, 238.0],
    [18.0, 192.0],
];

/// The corners of a parallelogram in (s, t).
const PARALLELOGRAM: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// The least w. No power of two: with these, some roundings would cost nothing.
const NEAREST: f64 = 1.3;

struct Maker {
    facets: Vec<Facet>,
    attributes: usize,
    /// The greatest w, where the least is 1.
    far: f64,
    random: Random,
}

impl Maker {
    /// The polygon of `points` in (s, t) on the plane a + s (b - a) + t (c - a); positions are
    /// (x, y, w), and `NEAREST` times that in clip space.
    fn add(&mut self, frame: [[f64; 3]; 3], points: &[[f64; 2]]) {
        // With s and t in 1/256 no sum needs more than 53 bits.
        const STEPS: f64 = 1_048_576.0;
        let round = |n: f64| (n * NEAREST * STEPS).round() / STEPS;
        let [a, b, c] = frame.map(|p| p.map(round));
        let at = |[s, t]: [f64; 2]| {
            [0, 1, 2].map(|i: usize| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]))
        };
        self.push(points.iter().map(|point| (at(*point), *point)));
    }

    /// The triangle with these corners.
    fn add_triangle(&mut self, corners: [[f64; 3]; 3]) {
        let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        self.push(corners.map(|p| p.map(|n| n * NEAREST)).into_iter().zip(places));
    }

    /// The polygon of vertices with these (x, y, w) and (s, t).
    fn push(&mut self, vertices: impl Iterator<Item = ([f64; 3], [f64; 2])>) {
        let mut facet = Facet { positions: Vec::new(), attributes: Vec::new() };
        for ([x, y, w], [s, t]) in vertices {
            // The near plane at 1/2, the far one at infinity.
            facet.positions.push([x, y, w - 0.5, w]);
            let values = ATTRIBUTES.iter().take(self.attributes);
            facet.attributes.extend(values.map(|[c, a, b]| (c + a * s + b * t) as f32));
        }
        self.facets.push(facet);
    }

    /// From the lower edge of the picture to a horizon near the upper one; `turn` is cosine and
    /// sine of the roll.
    fn floor(&mut self, turn: [f64; 2]) {
        let [cos, sin] = turn;
        let at = |x: f64, y: f64, w: f64| [x * cos - y * sin, x * sin + y * cos, w];
        let far = self.far;
        let frame = [at(-4.0, -1.0, 1.0), at(4.0, -1.0, 1.0), at(-4.0, 0.75 * far, far)];
        self.add(frame, &PARALLELOGRAM);
    }

    /// From one `side` (-1 or 1) of the picture towards its middle.
    fn wall(&mut self, side: f64, half_height: f64) {
        let far = self.far;
        let frame = [
            [side, -half_height, 1.0],
            [0.05 * side * far, -half_height, far],
            [side, half_height, 1.0],
        ];
        self.add(frame, &PARALLELOGRAM);
    }

    fn room(&mut self) {
        let far = self.far;
        for side in [-1.0, 1.0] {
            let frame = [[-1.0, side, 1.0], [1.0, side, 1.0], [-1.0, 0.05 * side * far, far]];
            self.add(frame, &PARALLELOGRAM);
            self.wall(side, 1.0);
        }
        let end = 0.05 * far;
        self.add([[-end, -end, far], [end, -end, far], [-end, end, far]], &PARALLELOGRAM);
    }

    /// A place in a box of the picture whose sides are `size` of the picture's.
    fn near(&mut self, centre: [f64; 2], size: f64) -> [f64; 2] {
        centre.map(|c| c + self.random.within(-size, size))
    }

    fn anywhere(&mut self) -> [f64; 2] {
        [self.random.within(-0.9, 0.9), self.random.within(-0.9, 0.9)]
    }

    /// A w between the ends, its logarithm evenly spread.
    fn any_w(&mut self) -> f64 {
        libm::pow(self.far, self.random.within(0.0, 1.0))
    }

    fn triangle(&mut self) {
        let centre = self.anywhere();
        let ws = [1.0, self.far, self.any_w()];
        let corners = ws.map(|w| {
            let [x, y] = self.near(centre, 0.35);
            [x * w, y * w, w]
        });
        self.add_triangle(corners);
    }

    fn ngon(&mut self) {
        let centre = self.anywhere();
        let (near, end) = (self.near(centre, 0.35), self.near(centre, 0.35));
        let far = self.far;
        // Along s w goes from 1 at the first point to the ratio at the seventh.
        let slope = (far - 1.0) * 256.0 / 254.0;
        let along = [0, 1].map(|i: usize| (end[i] * far - near[i]) * 256.0 / 254.0);
        // Wide enough to be seen from where w is a tenth of the greatest on.
        let width = 1.0 + 0.07 * (far - 1.0);
        let across = self.near([0.0, 0.0], 0.5).map(|c| c * width);
        let first = [near[0], near[1], 1.0];
        let a = [0, 1, 2].map(|i: usize| {
            let (along, across) = if i < 2 { (along[i], across[i]) } else { (slope, 0.0) };
            first[i] - along / 256.0 - across / 2.0
        });
        let b = [a[0] + along[0], a[1] + along[1], a[2] + slope];
        let c = [a[0] + across[0], a[1] + across[1], a[2]];
        let sides = 4 + self.random.bits() % 5;
        let mut points = Vec::new();
        for (i, point) in ROUND.iter().enumerate() {
            let kept = i % 6 == 0 || self.random.unit() < (sides - 2) as f64 / 10.0;
            if kept || points.len() + (ROUND.len() - i) <= 4 {
                points.push(point.map(|c| c / 256.0));
            }
        }
        self.add([a, b, c], &points);
    }

    /// `height` of the picture in pixels.
    fn sliver(&mut self, height: u32) {
        let from = self.anywhere();
        let to = self.near(from, 0.8);
        // A hundredth of a pixel to three, in the units of a picture that is 2 high.
        let pixels = libm::pow(300.0, self.random.within(0.0, 1.0)) / 100.0;
        let thickness = pixels * 2.0 / f64::from(height);
        let third = [from[0], from[1] + thickness];
        let ws = [1.0, self.far, self.any_w()];
        let corners = [0, 1, 2].map(|i: usize| {
            let [x, y] = [from, to, third][i];
            [x * ws[i], y * ws[i], ws[i]]
        });
        self.add_triangle(corners);
    }
}
