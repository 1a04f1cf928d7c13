//! Numbers of attributes that are known at run time: 0 to 300 of them, some the same as others, in
//! strides with gaps. Nothing panics, and:
//!
//! - a stride that is too small, or a slice that is too short, is refused, and nothing else is;
//! - what stands in the gaps changes nothing;
//! - attributes with the same values at the vertices have the same bits at every pixel, however
//!   many others there are; and so has each of them alone;
//! - a shader that asks for fewer gets the same bits of those;
//! - the clipper leaves the same vertices whatever the number of attributes, and of each of them
//!   what it leaves of that one alone.

use hyperspan::clip::{Clipped, Clipper, VertexArrays};
use hyperspan::polygon::Strided;
use hyperspan::shade::{BLOCK, Block, Inputs, Shader};
use hyperspan::space::Viewport;
use hyperspan::target::Plane;
use hyperspan::tiler::{Precision, Tiler};
use hyperspan::varying::Interpolation;

use super::bytes::Bytes;
use super::shape::Shape;

/// Pixels of the target.
const SIDES: (u32, u32) = (9, 7);

/// Attributes, by columns.
struct Case {
    tiler: Tiler,
    origin: [i32; 2],
    shape: Shape,
    /// Values at all vertices.
    columns: Vec<Vec<f32>>,
    /// Which column each attribute is.
    names: Vec<usize>,
    interpolation: Vec<Interpolation>,
}

pub(crate) fn counts(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let viewport = Viewport::new(0, 0, 24, 24).expect("small");
    let origin = [(); 2].map(|()| i32::from(bytes.below(18)));
    let count = match bytes.below(4) {
        0 => usize::from(bytes.below(9)),
        1 => usize::from(bytes.below(40)),
        2 => bytes.pick(&[7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65]),
        _ => usize::from(u16::from_le_bytes(bytes.array())) % 301,
    };
    let gap = usize::from(bytes.below(4));
    let precision = bytes.pick(&[Precision::Exact, Precision::Fast]);
    let interpolation: Vec<Interpolation> = (0..bytes.below(5))
        .map(|_| {
            bytes.pick(&[
                Interpolation::Perspective,
                Interpolation::NoPerspective,
                Interpolation::Flat,
            ])
        })
        .collect();
    let seed = usize::from(bytes.byte());
    let lengths = [(); 3].map(|()| usize::from(bytes.below(40)));
    let picked = [(); 2].map(|()| usize::from(bytes.byte()));
    let mut shape = Shape::new(bytes, 3, viewport, (0, 0));
    // Of vertices at one place all attributes say which one counts.
    if shape.has_copies() {
        shape.positions.clear();
    }
    check_lengths(&shape, lengths);

    let mut columns: Vec<Vec<f32>> = (0..3).map(|k| shape.column(k).collect()).collect();
    columns.push(vec![0.5; shape.positions.len()]);
    let names: Vec<usize> =
        (0..count).map(|k| (k * (1 + seed % 5) + k / 7 + seed / 5) % 4).collect();
    let mut tiler = Tiler::new(viewport);
    tiler.set_origin(origin[0], origin[1]).set_precision(precision);
    let mut case = Case { tiler, origin, shape, columns, names, interpolation };
    let all = case.draw::<{ usize::MAX }>(&case.names.clone(), gap, f32::NAN);
    assert_eq!(case.draw::<{ usize::MAX }>(&case.names.clone(), 0, 0.0), all, "without the gaps");

    for pixel in all.iter().flatten() {
        assert_eq!(pixel.len(), count);
        for k in 0..count {
            let same = |j: &usize| case.names[*j] == case.names[k] && case.mode(*j) == case.mode(k);
            let first = (0..k).find(same).unwrap_or(k);
            assert_eq!(pixel[k], pixel[first], "attributes {first} and {k} of {count}");
        }
    }
    check_fewer::<1>(&mut case, &all);
    check_fewer::<5>(&mut case, &all);
    for k in picked.into_iter().filter(|k| *k < count) {
        let mode = case.mode(k);
        let listed = std::mem::replace(&mut case.interpolation, vec![mode]);
        let alone = case.draw::<{ usize::MAX }>(&[case.names[k]], 0, 0.0);
        case.interpolation = listed;
        let right = all.iter().map(|pixel| pixel.as_ref().map(|all| vec![all[k]]));
        assert!(right.eq(alone), "attribute {k} of {count} alone");
    }
    check_clipped(&case, viewport, &picked);
}

/// `Strided` takes what fits.
fn check_lengths(shape: &Shape, [stride, count, length]: [usize; 3]) {
    let n = shape.positions.len();
    let needed = if n == 0 { 0 } else { (n - 1) * stride + count };
    let fits = stride >= count && length >= needed;
    let made = Strided::new(&shape.positions, &vec![0.0; length], stride, count).is_ok();
    assert_eq!(made, fits, "{n} vertices, {count} of {stride} out of {length}");
}

/// The bits of the first `N` attributes.
struct First<const N: usize> {
    found: Vec<Option<Vec<u32>>>,
    origin: [i32; 2],
}

impl<const N: usize> Shader for First<N> {
    type Pixel = ();
    const INPUTS: Inputs = Inputs::attributes(N);

    fn shade(&mut self, block: &Block<'_>, _out: &mut [(); BLOCK]) -> u16 {
        for lane in (0..BLOCK as u16).filter(|lane| block.mask >> lane & 1 != 0) {
            let [x, y] = [block.x(lane) - self.origin[0], block.y(lane) - self.origin[1]];
            let values = block.attributes.iter().map(|lanes| lanes[usize::from(lane)].to_bits());
            let place = &mut self.found[(y * SIDES.0 as i32 + x) as usize];
            assert!(place.replace(values.collect()).is_none(), "{x}, {y} twice");
        }
        block.mask
    }
}

impl Case {
    fn mode(&self, k: usize) -> Interpolation {
        self.interpolation.get(k).copied().unwrap_or_default()
    }

    /// Each pixel's first `N` attributes, drawn with those of `names`, and `gap` numbers between.
    fn draw<const N: usize>(
        &mut self,
        names: &[usize],
        gap: usize,
        filler: f32,
    ) -> Vec<Option<Vec<u32>>> {
        let n = self.shape.positions.len();
        let mut attributes = Vec::new();
        for i in 0..n {
            attributes.extend(names.iter().map(|name| self.columns[*name][i]));
            attributes.extend(std::iter::repeat_n(filler, gap));
        }
        let stride = names.len() + gap;
        let polygon = Strided::new(&self.shape.positions, &attributes, stride, names.len())
            .expect("as many as needed");
        let found = vec![None; (SIDES.0 * SIDES.1) as usize];
        self.tiler.set_interpolation(&self.interpolation);
        let mut shader = First::<N> { found, origin: self.origin };
        let mut pixels = [(); (SIDES.0 * SIDES.1) as usize];
        let mut target = Plane::new(&mut pixels, SIDES.0, SIDES.1).expect("its size");
        self.tiler.draw(&polygon, &mut shader, &mut target, None);
        shader.found
    }
}

fn check_fewer<const N: usize>(case: &mut Case, all: &[Option<Vec<u32>>]) {
    let names = case.names.clone();
    let first = case.draw::<N>(&names, 0, 0.0);
    let n = N.min(names.len());
    let right = all.iter().map(|pixel| pixel.as_ref().map(|all| all[..n].to_vec()));
    assert!(right.eq(first), "the first {N} of {}", names.len());
}

fn check_clipped(case: &Case, viewport: Viewport, picked: &[usize]) {
    let finite = case.shape.positions.iter().flatten().all(|c| c.is_finite() && c.abs() < 1e100);
    if !finite {
        return;
    }
    let clip = |names: &[usize], modes: &[Interpolation]| {
        let mut arrays = VertexArrays::new(names.len());
        for (k, mode) in modes.iter().enumerate() {
            if *mode == Interpolation::NoPerspective {
                arrays.set_noperspective(k);
            }
        }
        for (i, position) in case.shape.positions.iter().enumerate() {
            arrays.push(*position, names.iter().map(|name| f64::from(case.columns[*name][i])));
        }
        let found = Clipper::new(viewport).clip(&mut arrays);
        (found, arrays)
    };
    let modes: Vec<Interpolation> = (0..case.names.len()).map(|k| case.mode(k)).collect();
    let (found, all) = clip(&case.names, &modes);
    for k in picked.iter().copied().filter(|k| *k < case.names.len()) {
        let (found_alone, alone) = clip(&[case.names[k]], &[modes[k]]);
        assert_eq!(found, found_alone);
        assert_eq!(all.len(), alone.len());
        if found == Clipped::Outside {
            continue;
        }
        for i in 0..all.len() {
            let bits = |p: [f64; 4]| p.map(f64::to_bits);
            assert_eq!(bits(all.position(i)), bits(alone.position(i)), "vertex {i}");
            let [a, b] = [all.attributes(i)[k], alone.attributes(i)[0]];
            assert!(
                a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
                "attribute {k}: {a}, {b}"
            );
        }
    }
}
