//! Polygons and everything that is set for them, of any bytes; and what can be checked on one
//! picture of them.

use std::cell::Cell;

use hyperspan::clip::ClipPlane;
use hyperspan::depth::{Compare, DepthSource, DepthTest};
use hyperspan::polygon::Strided;
use hyperspan::shade::Fragment;
use hyperspan::simd::Simd;
use hyperspan::space::{DepthRange, Grid, Viewport};
use hyperspan::tiler::{Cull, Outcome, Precision, Tiler};
use hyperspan::varying::{CANONICAL_NAN, Interpolation};

use super::bytes::Bytes;
use super::picture::{Framed, Picture, RECORD, record};
use super::shape::Shape;

/// Polygons and everything that is set for them.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) viewport: Viewport,
    pub(super) origin: (i32, i32),
    pub(super) size: (u32, u32),
    pub(super) interpolation: Vec<Interpolation>,
    pub(super) depth: Option<DepthTest>,
    pub(super) clear: f32,
    pub(super) cull: Cull,
    pub(super) precision: Precision,
    pub(super) planes: Vec<ClipPlane>,
    pub(super) simd: Simd,
    pub(super) shapes: Vec<Shape>,
}

impl Case {
    pub(super) fn new(bytes: &mut Bytes<'_>) -> Self {
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
        for _ in 0..1 + bytes.below(3) {
            case.shapes.push(Shape::new(bytes, count, viewport, origin));
        }
        for _ in 0..bytes.below(9).saturating_sub(5) {
            let plane = case.shapes[0].plane(bytes, &case.planes);
            case.planes.push(plane);
        }
        case
    }

    pub(super) fn interpolation(&self, k: usize) -> Interpolation {
        self.interpolation.get(k).copied().unwrap_or_default()
    }

    pub(super) fn set_up(&self, tiler: &mut Tiler) {
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
    pub(super) fn draw(&self, tiler: &mut Tiler) -> Picture {
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
