//! What the fuzz targets check, on inputs made of any bytes.
//!
//! Called by fuzz_targets/*.rs and by tests/corpus.rs, which replays fuzz/corpus with plain
//! `cargo test`. Cases are built by hand from the bytes, with a bias to what breaks
//! rasterizers: w near 0 and below, signed zeros, subnormals, giants, NaN, vertices on planes
//! and on pixel centres, copies, collinear and nearly collinear points.

use std::cell::Cell;

use hyperspan::clip::{ClipPlane, Clipped, Clipper, VertexArrays};
use hyperspan::depth::{Compare, DepthSource, DepthTest};
use hyperspan::polygon::Strided;
use hyperspan::shade::{Fragment, Solid};
use hyperspan::simd::Simd;
use hyperspan::space::{DepthRange, Grid, Viewport};
use hyperspan::target::Plane;
use hyperspan::tiler::{Cull, Outcome, Precision, Tiler};
use hyperspan::varying::{CANONICAL_NAN, Interpolation};

/// Reads choices off the input; zeros once it is used up.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut out = [0; N];
        let n = N.min(self.0.len());
        out[..n].copy_from_slice(&self.0[..n]);
        self.0 = &self.0[n..];
        out
    }

    fn byte(&mut self) -> u8 {
        self.array::<1>()[0]
    }

    fn below(&mut self, n: u8) -> u8 {
        self.byte() % n
    }

    fn small(&mut self) -> i32 {
        i32::from(self.byte().cast_signed())
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[usize::from(self.byte()) % from.len()]
    }

    /// Any number, often an awkward one.
    fn number(&mut self) -> f64 {
        match self.below(8) {
            0 => f64::from(f32::from_bits(u32::from_le_bytes(self.array()))),
            1 => f64::from_bits(u64::from_le_bytes(self.array())),
            2 | 3 => self.pick(&AWKWARD),
            4 => f64::from(self.small()) / 16.0,
            5 => f64::from(i16::from_le_bytes(self.array())) / 4096.0,
            6 => f64::from(self.small()) * 2.0_f64.powi(self.small()),
            _ => 1.0 + f64::from(self.small()) * f64::from(f32::EPSILON),
        }
    }

    fn number_f32(&mut self) -> f32 {
        self.number() as f32
    }
}

const AWKWARD: [f64; 32] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    3.0,
    1e-3,
    -1e-3,
    1e-9,
    1e9,
    1e20,
    -1e20,
    3e38,
    -3e38,
    1e-40,                  // a subnormal f32
    -1e-40,                 //
    1.401298464324817e-45,  // the least f32
    1.1754943508222875e-38, // the least normal f32
    5e-324,                 // the least f64
    2.2250738585072014e-308,
    1e-300,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    8.673617379884035e-19, // 2^-60
    1.152921504606847e18,  // 2^60
];

/// Vertices and their attributes, `count` for each.
#[derive(Clone, Debug)]
struct Shape {
    positions: Vec<[f64; 4]>,
    attributes: Vec<f32>,
    count: usize,
}

impl Shape {
    fn new(bytes: &mut Bytes<'_>, count: usize, viewport: Viewport, origin: (i32, i32)) -> Self {
        let n = usize::from(bytes.below(9));
        if bytes.below(3) == 0 {
            return Self::flat(bytes, n, count, viewport, origin);
        }
        let mut shape = Self { positions: Vec::new(), attributes: Vec::new(), count };
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
        let mut shape = Self { positions: Vec::new(), attributes: Vec::new(), count };
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
    fn even_out(&mut self, interpolation: &[Interpolation]) {
        for (k, how) in interpolation.iter().enumerate().take(self.count) {
            if let (Interpolation::Flat, Some(value)) = (how, self.attributes.get(k).copied()) {
                self.attributes.iter_mut().skip(k).step_by(self.count).for_each(|a| *a = value);
            }
        }
    }

    /// Vertex `first` first.
    fn rotated(&self, first: usize) -> Self {
        let mut shape = self.clone();
        if !self.positions.is_empty() {
            let first = first % self.positions.len();
            shape.positions.rotate_left(first);
            shape.attributes.rotate_left(first * self.count);
        }
        shape
    }

    /// All four coordinates of all vertices times `factor`, if nothing is lost by that.
    fn scaled(&self, factor: f64) -> Option<Self> {
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
    fn is_finite(&self, k: usize) -> bool {
        self.column(k).all(f32::is_finite)
    }

    /// Are two vertices at the same place?
    fn has_copies(&self) -> bool {
        let others = |i: usize| &self.positions[..i];
        self.positions.iter().enumerate().any(|(i, p)| others(i).contains(p))
    }

    fn column(&self, k: usize) -> impl Iterator<Item = f32> {
        self.attributes.iter().skip(k).step_by(self.count.max(1)).copied()
    }
}

fn to_ndc(viewport: Viewport, origin: (i32, i32), at: [f64; 2]) -> [f64; 2] {
    let rect = viewport.rect();
    let half = [f64::from(viewport.width()) / 2.0, f64::from(viewport.height()) / 2.0];
    let x = (f64::from(origin.0) + at[0] - f64::from(rect.x0) - half[0]) / half[0];
    let y = (f64::from(rect.y0) + half[1] - f64::from(origin.1) - at[1]) / half[1];
    [x, y]
}

/// A vertex at `at`, in pixels from the target's corner, at some distance.
fn on_screen(
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

/// Polygons and everything that is set for them.
#[derive(Clone, Debug)]
struct Case {
    viewport: Viewport,
    origin: (i32, i32),
    size: (u32, u32),
    interpolation: Vec<Interpolation>,
    depth: Option<DepthTest>,
    clear: f32,
    cull: Cull,
    precision: Precision,
    planes: Vec<ClipPlane>,
    simd: Simd,
    shapes: Vec<Shape>,
}

impl Case {
    fn new(bytes: &mut Bytes<'_>) -> Self {
        let size = (1 + u32::from(bytes.below(40)), 1 + u32::from(bytes.below(20)));
        let origin = match bytes.below(3) {
            0 => (bytes.small(), bytes.small()),
            _ => (0, 0),
        };
        let (width, height) = size;
        let viewport = match bytes.below(6) {
            0 => {
                let corner = [(); 2].map(|()| bytes.small() / 4);
                let sides = [(); 2].map(|()| u32::from(bytes.byte()));
                Viewport::new(origin.0 + corner[0], origin.1 + corner[1], sides[0], sides[1])
            }
            1 => Viewport::new(origin.0 - 8000, origin.1 - 16300, 16384, 16384),
            _ => Viewport::new(origin.0, origin.1, width, height),
        }
        .expect("sides of 16384 at most")
        .with_grid(bytes.pick(&[Grid::Sixteen, Grid::Sixteen, Grid::Eight]))
        .with_depth_range(bytes.pick(&[DepthRange::ZeroToOne, DepthRange::MinusOneToOne]));
        let compare = bytes.pick(&[
            Compare::Less,
            Compare::Greater,
            Compare::LessEqual,
            Compare::GreaterEqual,
            Compare::Equal,
            Compare::NotEqual,
            Compare::Always,
            Compare::Never,
        ]);
        let source = bytes.pick(&[DepthSource::Z, DepthSource::Z, DepthSource::InvW]);
        let test = DepthTest { compare, write: bytes.below(4) != 0, source };
        let depth = (bytes.below(3) != 0).then_some(test);
        let count = usize::from(bytes.below(6));
        let interpolation = (0..bytes.below(7))
            .map(|_| {
                bytes.pick(&[
                    Interpolation::Perspective,
                    Interpolation::Perspective,
                    Interpolation::NoPerspective,
                    Interpolation::Flat,
                ])
            })
            .collect();
        let mut case = Self {
            viewport,
            origin,
            size,
            interpolation,
            depth,
            clear: bytes.pick(&[1.0, 0.0, 0.5, f32::NAN]),
            cull: bytes.pick(&[Cull::None, Cull::None, Cull::Back, Cull::Front]),
            precision: bytes.pick(&[Precision::Exact, Precision::Fast]),
            planes: Vec::new(),
            simd: Simd::auto(),
            shapes: Vec::new(),
        };
        for _ in 0..bytes.below(8).saturating_sub(5) {
            case.planes.push([(); 4].map(|()| bytes.number()));
        }
        for _ in 0..1 + bytes.below(3) {
            case.shapes.push(Shape::new(bytes, count, viewport, origin));
        }
        case
    }

    fn interpolation(&self, k: usize) -> Interpolation {
        self.interpolation.get(k).copied().unwrap_or_default()
    }

    fn set_up(&self, tiler: &mut Tiler) {
        tiler
            .set_origin(self.origin.0, self.origin.1)
            .set_cull(self.cull)
            .set_precision(self.precision)
            .set_interpolation(&self.interpolation)
            .set_clip_planes(&self.planes)
            .set_simd(self.simd)
            .reset_stats();
        if let Some(test) = self.depth {
            tiler.set_depth_test(test);
        }
    }

    /// Draws all with `tiler` (which may have drawn before), and checks on the way what can be
    /// checked on one picture.
    fn draw(&self, tiler: &mut Tiler) -> Picture {
        self.set_up(tiler);
        let (width, height) = self.size;
        let mut pixels = Framed::new(width, height, [0; RECORD], [0xDEAD_BEEF; RECORD]);
        let mut depths = Framed::new(width, height, self.clear, -7.0);
        let mut outcomes = [0_u64; 6];
        let calls = Cell::new(0_u64);
        for shape in &self.shapes {
            let polygon =
                Strided::new(&shape.positions, &shape.attributes, shape.count, shape.count)
                    .expect("as many as needed");
            let before = calls.get();
            let mut shader = |fragment: &Fragment<'_>| {
                calls.set(calls.get() + 1);
                self.check_fragment(shape, fragment);
                record(fragment)
            };
            let outcome = {
                let mut target = pixels.plane();
                let mut depth = depths.plane();
                let depth = self.depth.map(|_| &mut depth);
                tiler.draw(&polygon, &mut shader, &mut target, depth)
            };
            if outcome != Outcome::Drawn {
                assert_eq!(calls.get(), before, "{outcome:?}, and yet something was drawn");
            }
            outcomes[outcome as usize] += 1;
        }
        let stats = tiler.stats();
        let culled = stats.culled;
        assert_eq!(stats.polygons, self.shapes.len() as u64);
        assert_eq!(outcomes[Outcome::Outside as usize], culled.outside);
        assert_eq!(outcomes[Outcome::Backface as usize], culled.backface);
        assert_eq!(outcomes[Outcome::Degenerate as usize], culled.degenerate);
        assert_eq!(outcomes[Outcome::Refused as usize], culled.refused);
        assert_eq!(stats.pixels_covered, stats.pixels_shaded + stats.pixels_hidden);
        assert_eq!(stats.pixels_shaded, calls.get());
        assert!(self.depth.is_some() || stats.pixels_hidden == 0);
        Picture { width, pixels: pixels.inside(), depths: depths.inside() }
    }

    fn check_fragment(&self, shape: &Shape, fragment: &Fragment<'_>) {
        let (x, y) = (fragment.x(), fragment.y());
        let rect = self.viewport.rect();
        assert!((rect.x0..rect.x1).contains(&x) && (rect.y0..rect.y1).contains(&y));
        let depth = fragment.depth();
        assert!((0.0..=1.0).contains(&depth), "depth {depth} at {x}, {y}");
        assert!(fragment.inv_w() >= 0.0 && fragment.w() >= 0.0, "1/w at {x}, {y}");
        assert_eq!(fragment.attribute_count(), shape.count);
        for k in 0..shape.count {
            let value = fragment.attribute(k);
            if self.interpolation(k) == Interpolation::Flat {
                let first = canonical(shape.attributes[k]);
                assert_eq!(value.to_bits(), first.to_bits(), "flat attribute {k} at {x}, {y}");
            } else if shape.is_finite(k) {
                let least = shape.column(k).fold(f32::INFINITY, f32::min);
                let most = shape.column(k).fold(f32::NEG_INFINITY, f32::max);
                assert!(
                    (least..=most).contains(&value),
                    "attribute {k} at {x}, {y}: {value:e} is not in {least:e}..={most:e}"
                );
            } else if value.is_nan() {
                assert_eq!(value.to_bits(), CANONICAL_NAN.to_bits());
            }
        }
    }
}

fn canonical(value: f32) -> f32 {
    if value.is_nan() { CANONICAL_NAN } else { value }
}

/// Numbers kept of a pixel: a mark, the depth and five attributes. Neither w nor 1/w, which
/// scale with the polygon.
const RECORD: usize = 7;

fn record(fragment: &Fragment<'_>) -> [u32; RECORD] {
    let mut out = [1, fragment.depth().to_bits(), 0, 0, 0, 0, 0];
    for k in 0..fragment.attribute_count() {
        out[2 + k] = fragment.attribute(k).to_bits();
    }
    out
}

/// A plane with canaries before it, behind it and between its rows.
struct Framed<P> {
    data: Vec<P>,
    width: u32,
    height: u32,
    canary: P,
}

/// Elements before the first row and behind each.
const FRAME: usize = 3;

impl<P: Copy + PartialEq> Framed<P> {
    fn new(width: u32, height: u32, clear: P, canary: P) -> Self {
        let stride = width as usize + FRAME;
        let data = vec![canary; FRAME + height as usize * stride];
        let mut framed = Self { data, width, height, canary };
        framed.plane().clear(clear);
        framed
    }

    fn plane(&mut self) -> Plane<'_, P> {
        let stride = self.width as usize + FRAME;
        Plane::with_stride(&mut self.data[FRAME..], self.width, self.height, stride)
            .expect("long enough")
    }

    /// What lies inside, once all canaries are found alive.
    fn inside(self) -> Vec<P> {
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
struct Picture {
    width: u32,
    pixels: Vec<[u32; RECORD]>,
    depths: Vec<f32>,
}

impl Picture {
    fn crop(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        let index = |i: u32| ((y + i / width) * self.width + x + i % width) as usize;
        let all = || (0..width * height).map(index);
        Self {
            width,
            pixels: all().map(|i| self.pixels[i]).collect(),
            depths: all().map(|i| self.depths[i]).collect(),
        }
    }

    /// Without attribute `k`.
    fn without(mut self, k: usize) -> Self {
        for pixel in &mut self.pixels {
            pixel[2 + k] = 0;
        }
        self
    }

    #[track_caller]
    fn must_equal(&self, other: &Self, what: &str) {
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

/// The whole tiler, on one to three polygons of up to eight vertices with up to five
/// attributes. Nothing panics, and:
///
/// - nothing is written outside the target, nothing drawn outside the viewport;
/// - each polygon is counted once, each pixel as shaded or hidden;
/// - depth lies in 0..=1, finite attributes in their range over the vertices, flat ones are
///   the first vertex's, a NaN is the canonical one;
/// - a rotated vertex list, all coordinates times a power of two, a crop, and another
///   instruction set give the same bits, and so does a tiler that has drawn other things before;
/// - an attribute that is not finite changes nothing else (but where vertices at one place have
///   several values); nor does leaving them all out;
/// - `Fast` is within its bound of `Exact`;
/// - a polygon that no plane cuts covers the pixels that P1 says, in exact integers.
pub(crate) fn tiler(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let case = Case::new(bytes);
    let mut tiler = Tiler::new(case.viewport);
    let picture = case.draw(&mut tiler);

    // What is flat follows the first vertex: there, let all vertices have its values.
    let mut evened = case.clone();
    for shape in &mut evened.shapes {
        shape.even_out(&case.interpolation);
    }
    let first = 1 + usize::from(bytes.below(7));
    let mut rotated = evened.clone();
    for shape in &mut rotated.shapes {
        *shape = shape.rotated(first);
    }
    let evened = evened.draw(&mut tiler);
    evened.must_equal(&rotated.draw(&mut tiler), "another first vertex");

    let factor = 2.0_f64.powi(bytes.pick(&[-120, -60, -30, -3, -1, 1, 2, 40, 60, 120]));
    let scaled: Option<Vec<Shape>> = case.shapes.iter().map(|s| s.scaled(factor)).collect();
    let by_inv_w = case.depth.is_some_and(|test| test.source == DepthSource::InvW);
    if let (Some(shapes), false) = (scaled, by_inv_w) {
        let scaled = Case { shapes, ..case.clone() };
        picture.must_equal(&scaled.draw(&mut tiler), "times a power of two");
    }

    let levels: Vec<Simd> = Simd::all().map(|(_, simd)| simd).collect();
    let other = Case { simd: bytes.pick(&levels), ..case.clone() };
    picture.must_equal(&other.draw(&mut tiler), "another instruction set");

    let (width, height) = case.size;
    let [x, y] = [width, height].map(|side| u32::from(bytes.byte()) % side);
    let size = [width - x, height - y].map(|side| 1 + u32::from(bytes.byte()) % side);
    let origin = (case.origin.0 + x as i32, case.origin.1 + y as i32);
    let crop = Case { origin, size: (size[0], size[1]), ..case.clone() };
    picture.crop(x, y, size[0], size[1]).must_equal(&crop.draw(&mut tiler), "a crop");

    // Of vertices at one place with several values, all attributes say which one counts.
    let ambiguous = case.shapes.iter().any(Shape::has_copies);
    for k in 0..case.shapes[0].count {
        if !ambiguous && !case.shapes.iter().all(|shape| shape.is_finite(k)) {
            let mut healed = case.clone();
            for shape in &mut healed.shapes {
                let column = shape.attributes.iter_mut().skip(k).step_by(shape.count);
                column.for_each(|a| *a = 0.5);
            }
            let healed = healed.draw(&mut tiler).without(k);
            picture.clone().without(k).must_equal(&healed, "a spoilt attribute");
        }
    }

    let alone = Case { depth: None, ..case.clone() };
    let exact = Case { precision: Precision::Exact, ..alone.clone() }.draw(&mut tiler);
    let fast = Case { precision: Precision::Fast, ..alone }.draw(&mut tiler);
    check_bound(&case, &exact, &fast);

    let mut bare = case.clone();
    for shape in &mut bare.shapes {
        (shape.attributes, shape.count) = (Vec::new(), 0);
    }
    let count = case.shapes[0].count;
    let expected = (0..count).fold(picture, Picture::without);
    expected.must_equal(&bare.draw(&mut tiler), "without attributes");

    for shape in &bare.shapes {
        check_coverage(&bare, shape, &mut tiler);
    }
}

/// `fast` is within its bound of `exact`.
fn check_bound(case: &Case, exact: &Picture, fast: &Picture) {
    const U: f64 = 1.0 / 16_777_216.0;
    for (p, q) in exact.pixels.iter().zip(&fast.pixels) {
        assert_eq!(p[0], q[0], "coverage depends on the precision");
        assert!(p[1].abs_diff(q[1]) <= 1, "depth is off by more than an ulp");
        for k in 0..case.shapes[0].count {
            // Any of the polygons may have drawn the pixel.
            let columns = case.shapes.iter().flat_map(|shape| shape.column(k));
            let largest = columns.map(|a| f64::from(a).abs()).fold(0.0, f64::max);
            let [a, b] = [p, q].map(|pixel| f64::from(f32::from_bits(pixel[2 + k])));
            // The exact value is known to half an ulp.
            let ulp = 2.0 * U * a.abs().max(f64::from(f32::MIN_POSITIVE));
            let allowed = 4.0 * U * a.abs() + 3.0 * U * largest + ulp;
            let near = a == b || (a - b).abs() <= allowed;
            let spoilt = !case.shapes.iter().all(|shape| shape.is_finite(k));
            assert!(near || spoilt, "attribute {k}: {b:e} is too far from {a:e}");
        }
    }
}

/// A polygon is brought to the size of its largest number: numbers smaller by more than this
/// are lost.
const RATIO: f64 = 1e280;

/// Coverage of one polygon against P1, if it is not clipped.
fn check_coverage(case: &Case, shape: &Shape, tiler: &mut Tiler) {
    case.set_up(tiler);
    tiler.set_cull(Cull::None);
    let (width, height) = case.size;
    let mut data = vec![0_u8; (width * height) as usize];
    let mut target = Plane::new(&mut data, width, height).expect("long enough");
    let polygon = Strided::new(&shape.positions, &[], 0, 0).expect("no attributes");
    let outcome = tiler.draw(&polygon, &mut Solid(1), &mut target, None);
    let numbers = || shape.positions.iter().flatten().map(|c| c.abs()).filter(|c| *c > 0.0);
    let least = numbers().fold(f64::INFINITY, f64::min);
    let lost = numbers().any(|c| c / RATIO > least);
    if outcome != Outcome::Drawn || tiler.stats().clipped > 0 || lost {
        return;
    }
    let snapped = snapped(case.viewport, &shape.positions);
    let rect = case.viewport.rect();
    for (i, got) in (0..).zip(data) {
        let (x, y) = (case.origin.0 + i % width as i32, case.origin.1 + i / width as i32);
        let shown = (rect.x0..rect.x1).contains(&x) && (rect.y0..rect.y1).contains(&y);
        let expected = shown && winding(&snapped, x, y) != 0;
        assert_eq!(got != 0, expected, "coverage of {x}, {y} by {:?}", shape.positions);
    }
}

/// Framebuffer positions in 1/65536 of a pixel.
fn snapped(viewport: Viewport, positions: &[[f64; 4]]) -> Vec<[i64; 2]> {
    let rect = viewport.rect();
    let half = [f64::from(viewport.width()) / 2.0, f64::from(viewport.height()) / 2.0];
    let centre = [f64::from(rect.x0) + half[0], f64::from(rect.y0) + half[1]];
    let step = match viewport.grid() {
        Grid::Sixteen => 65536.0,
        Grid::Eight => 256.0,
    };
    let snap = |v: f64| (v * step).round_ties_even() as i64 * (65536.0 / step) as i64;
    let named = positions.iter().filter(|p| p[3] > 0.0);
    named
        .map(|[x, y, _, w]| [snap(x / w * half[0] + centre[0]), snap(centre[1] - y / w * half[1])])
        .collect()
}

/// How often the polygon goes round the centre of a pixel; left and top edges belong to it.
fn winding(polygon: &[[i64; 2]], x: i32, y: i32) -> i32 {
    let [x, y] = [x, y].map(|c| i64::from(c) * 65536 + 32768);
    let mut winding = 0;
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (upper, lower, sign) = if a[1] < b[1] { (*a, b, 1) } else { (b, *a, -1) };
        if upper[1] <= y && y < lower[1] {
            let [dx, dy] = [0, 1].map(|k| i128::from(lower[k] - upper[k]));
            // Is the edge to the left of the centre, or on it?
            let left = dx * i128::from(y - upper[1]) <= dy * i128::from(x - upper[0]);
            winding += if left { sign } else { 0 };
        }
    }
    winding
}

/// The clipper alone, on a polygon of up to eight vertices and up to eight user planes, all
/// finite. Nothing panics, and where no number is beyond 1e100:
///
/// - what is found `Inside` is untouched;
/// - a triangle leaves at most 3 + planes vertices, and any polygon at most twice as many for
///   each plane;
/// - no vertex that is inside every plane is lost;
/// - every vertex that is left is inside every plane but for rounding, and its numbers lie in
///   their range over the vertices as given, but for rounding;
/// - the reversed list leaves the same vertices, bit for bit, and so does a rotated one;
/// - a plane and its complement cut the same new vertices out of the polygon, bit for bit.
pub(crate) fn clip(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let range = bytes.pick(&[DepthRange::ZeroToOne, DepthRange::MinusOneToOne]);
    let sides = bytes.pick(&[(64, 64), (1, 1), (16384, 16384), (7, 16384), (0, 0)]);
    let viewport = Viewport::new(bytes.small(), bytes.small(), sides.0, sides.1)
        .expect("sides of 16384 at most")
        .with_depth_range(range);
    let tame = bytes.below(4) != 0;
    let mut planes: Vec<ClipPlane> = Vec::new();
    for _ in 0..bytes.below(9) {
        let plane = match (bytes.below(4), planes.last()) {
            (0, Some(last)) => last.map(|c| -c),
            _ => [(); 4].map(|()| bytes.number()),
        };
        planes.push(plane);
    }
    let mut shape = Shape::new(bytes, 1, viewport, (0, 0));
    let limit = if tame { 1e100 } else { f64::MAX };
    let numbers = shape.positions.iter_mut().chain(&mut planes).flatten();
    for number in numbers {
        // The clipper is promised finite numbers.
        if number.is_nan() || number.abs() > limit {
            *number = 0.75;
        }
    }
    for value in &mut shape.attributes {
        if !value.is_finite() {
            *value = 0.25;
        }
    }

    let mut clipper = Clipper::new(viewport);
    clipper.set_user_planes(&planes);
    let n = shape.positions.len();
    let (found, cut) = run(&mut clipper, &shape);
    if !tame {
        // Products overflow: no panic is all that is asked for.
        return;
    }
    if found == Clipped::Inside {
        assert_eq!(sorted(&cut), sorted(&arrays(&shape)));
    }

    let mut reversed = shape.clone();
    reversed.positions.reverse();
    reversed.attributes.reverse();
    for other in [reversed, shape.rotated(1 + usize::from(bytes.below(7)))] {
        let (found_other, cut_other) = run(&mut clipper, &other);
        assert_eq!(found, found_other);
        assert_eq!(sorted(&cut), sorted(&cut_other), "another order of the vertices");
    }

    if found == Clipped::Crossed {
        let count = clipper.plane_count();
        if n == 3 && planes.is_empty() {
            assert!(cut.len() <= n + count, "{} vertices left", cut.len());
        }
        assert!(cut.len() <= n << count, "{} vertices left", cut.len());
        check_cut(viewport, &planes, &shape, &cut);
    }

    // Both halves have the same new vertices, if nothing else cuts them.
    if let Some(plane) = planes.first() {
        let mut alone = Clipper::new(viewport);
        if run(&mut alone, &shape).0 == Clipped::Inside {
            let given = sorted(&arrays(&shape));
            let new = |plane: ClipPlane| -> Vec<Vec<u64>> {
                let mut clipper = Clipper::new(viewport);
                clipper.set_user_planes(&[plane]);
                let (found, cut) = run(&mut clipper, &shape);
                let mut new = sorted(&cut);
                new.retain(|v| found == Clipped::Crossed && !given.contains(v));
                new
            };
            let (inner, outer) = (new(*plane), new(plane.map(|c| -c)));
            if !inner.is_empty() && !outer.is_empty() {
                assert_eq!(inner, outer, "a plane and its complement");
            }
        }
    }
}

fn arrays(shape: &Shape) -> VertexArrays {
    let mut arrays = VertexArrays::new(1);
    for (position, attribute) in shape.positions.iter().zip(&shape.attributes) {
        arrays.push(*position, [f64::from(*attribute)]);
    }
    arrays
}

fn run(clipper: &mut Clipper, shape: &Shape) -> (Clipped, VertexArrays) {
    let mut arrays = arrays(shape);
    let found = clipper.clip(&mut arrays);
    (found, arrays)
}

fn vertex(arrays: &VertexArrays, i: usize) -> Vec<f64> {
    [&arrays.position(i), arrays.attributes(i)].concat()
}

/// The numbers of all vertices; the sign of a zero is of no account.
fn bits(arrays: &VertexArrays) -> Vec<Vec<u64>> {
    let bits = |i| vertex(arrays, i).into_iter().map(|v| (v + 0.0).to_bits()).collect();
    (0..arrays.len()).map(bits).collect()
}

fn sorted(arrays: &VertexArrays) -> Vec<Vec<u64>> {
    let mut all = bits(arrays);
    all.sort_unstable();
    all
}

/// What rounding may do, relative to the largest number involved.
const ROUNDING: f64 = 1e-13;

/// Products of two numbers above it do not underflow, divided by a plane's largest either.
const UNDERFLOW: f64 = 1e-100;

fn check_cut(viewport: Viewport, planes: &[ClipPlane], shape: &Shape, cut: &VertexArrays) {
    let near = match viewport.depth_range() {
        DepthRange::ZeroToOne => [0.0, 0.0, 1.0, 0.0],
        DepthRange::MinusOneToOne => [0.0, 0.0, 1.0, 1.0],
    };
    let far = [0.0, 0.0, -1.0, 1.0];
    let terms = |plane: &ClipPlane, p: [f64; 4]| [0, 1, 2, 3].map(|k| plane[k] * p[k]);
    for plane in planes.iter().chain(&[near, far]) {
        let largest = shape.positions.iter().flat_map(|p| terms(plane, *p));
        let allowed = ROUNDING * largest.map(f64::abs).fold(UNDERFLOW, f64::max);
        for i in 0..cut.len() {
            let distance: f64 = terms(plane, cut.position(i)).iter().sum();
            assert!(distance >= -allowed, "vertex {i} is {distance:e} from {plane:?}");
        }
    }
    let given = arrays(shape);
    let left = sorted(cut);
    for (i, vertex) in bits(&given).into_iter().enumerate() {
        let p = given.position(i);
        let visible = p[0].abs() <= p[3] && p[1].abs() <= p[3];
        let inside = planes.iter().chain(&[near, far]).all(|plane| {
            let [x, y, z, w] = terms(plane, p);
            (x + y) + (z + w) >= 0.0
        });
        // Where products underflow, a distance may round to either side.
        let small = |numbers: &[f64]| numbers.iter().any(|c| *c != 0.0 && c.abs() < UNDERFLOW);
        let unsure = small(&p) || planes.iter().any(|plane| small(plane));
        assert!(unsure || !(visible && inside) || left.contains(&vertex), "vertex {i} is lost");
    }
    for k in 0..5 {
        let column = || (0..given.len()).map(|i| vertex(&given, i)[k]);
        let least = column().fold(f64::INFINITY, f64::min);
        let most = column().fold(f64::NEG_INFINITY, f64::max);
        let mut slack = ROUNDING * least.abs().max(most.abs());
        if let Some(side) = [viewport.width(), viewport.height()].get(k) {
            // On the guard band x and y are some reach times w, and as good as w.
            let reach = 32767.0 / (f64::from(*side) / 2.0) + 1.0;
            let w = shape.positions.iter().map(|p| p[3].abs()).fold(0.0, f64::max);
            slack += ROUNDING * w * if reach.is_finite() { reach } else { 0.0 };
        }
        for i in 0..cut.len() {
            let value = vertex(cut, i)[k];
            let inside = least - slack <= value && value <= most + slack;
            assert!(inside, "number {k} of vertex {i}: {value:e} not in {least:e}..={most:e}");
        }
    }
}
