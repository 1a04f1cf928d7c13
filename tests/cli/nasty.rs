//! Inputs that break rasterizers, through `tile` as anyone can try them.

use crate::harness::{Folder, Npy};

/// x, y, z, w, then attributes.
type Vertex = Vec<f32>;

/// The triangle that the others are made of, with an attribute.
fn triangle() -> [Vertex; 3] {
    [
        vec![-0.5, -0.5, 0.5, 1.0, 0.25],
        vec![0.5, -0.5, 0.5, 1.0, 0.5],
        vec![0.0, 0.6, 0.5, 1.0, 1.0],
    ]
}

/// The triangle with another third vertex.
fn with_apex(apex: [f32; 4]) -> [Vertex; 3] {
    let mut all = triangle();
    all[2][..4].copy_from_slice(&apex);
    all
}

fn scaled(polygon: &[Vertex], factor: f32) -> Vec<Vertex> {
    let scale = |i: usize, x: f32| if i < 4 { x * factor } else { x };
    let vertex = |v: &Vertex| v.iter().enumerate().map(|(i, x)| scale(i, *x)).collect();
    polygon.iter().map(vertex).collect()
}

/// What is drawn of polygons on 64 x 64 pixels.
struct Drawn {
    overdraw: Npy,
    depth: Npy,
    attr: Npy,
    stats: serde_json::Value,
}

impl Drawn {
    fn of(polygons: &[&[Vertex]]) -> Self {
        let number = |x: &f32| format!("{x:e} ");
        let line = |vertex: &Vertex| vertex.iter().map(number).collect::<String>() + "\n";
        let text: Vec<String> =
            polygons.iter().map(|polygon| polygon.iter().map(line).collect()).collect();
        let folder = Folder::with(&[("t.poly", &text.join("\n"))]);
        let run = folder.run(
            "tile t.poly --size 64x64 --precision exact --aov overdraw=o.npy --aov depth=d.npy \
             --aov attr=a.npy --stats s.json",
        );
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        Self {
            overdraw: folder.npy("o.npy"),
            depth: folder.npy("d.npy"),
            attr: folder.npy("a.npy"),
            stats: folder.json("s.json"),
        }
    }

    /// Pixels that are covered at all.
    fn covered(&self) -> usize {
        self.overdraw.integers().iter().filter(|count| **count > 0).count()
    }

    fn is_once_at_most(&self) -> bool {
        self.overdraw.integers().iter().all(|count| *count <= 1)
    }
}

#[test]
fn nasty_scales_change_no_bit() {
    let plain = Drawn::of(&[&triangle()]);
    assert_eq!(plain.covered(), 560, "half of 32 x 35.2 pixels, nearly");
    for exponent in [-120, -60, 60, 126] {
        let drawn = Drawn::of(&[&scaled(&triangle(), 2.0_f32.powi(exponent))]);
        assert_eq!(drawn.overdraw, plain.overdraw, "{exponent}");
        assert_eq!((drawn.depth, drawn.attr), (plain.depth.clone(), plain.attr.clone()));
    }
    // Subnormal, with so few bits that none is lost.
    let (half_way, short) = (2.0_f32.powi(-65), with_apex([0.0, 0.625, 0.5, 1.0]));
    let subnormal = Drawn::of(&[&scaled(&scaled(&short, half_way), half_way)]);
    let plain = Drawn::of(&[&short]);
    assert!(plain.covered() > 500);
    assert_eq!(subnormal.overdraw, plain.overdraw);
    assert_eq!((subnormal.depth, subnormal.attr), (plain.depth, plain.attr));
}

#[test]
fn nasty_polygons_that_show_nothing() {
    let [a, b, c] = triangle();
    let d = vec![0.0, -0.5, 0.5, 1.0, 0.0];
    for polygon in [
        scaled(&triangle(), -1.0),
        with_apex([0.0; 4]).to_vec(),
        vec![a.clone(), d.clone(), b.clone()],
        vec![a.clone(), a.clone(), b.clone(), b.clone()],
        vec![a.clone(); 3],
        vec![a.clone(), b.clone()],
        vec![c.clone()],
        with_apex([f32::NAN, 0.0, 0.5, 1.0]).to_vec(),
        with_apex([0.0, f32::INFINITY, 0.5, 1.0]).to_vec(),
        with_apex([0.0, 0.6, f32::NEG_INFINITY, 1.0]).to_vec(),
        with_apex([0.0, 0.6, 0.5, f32::NAN]).to_vec(),
    ] {
        let drawn = Drawn::of(&[&polygon]);
        assert_eq!(drawn.covered(), 0, "{polygon:?}");
        let culled = drawn.stats["culled"].as_object().expect("counts");
        let sum: u64 = culled.values().filter_map(serde_json::Value::as_u64).sum();
        assert_eq!(sum, 1, "{polygon:?}: {culled:?}");
    }
    // Rows, columns and duplicates within a good polygon do no harm.
    let plain = Drawn::of(&[&triangle()]);
    let drawn = Drawn::of(&[&[a.clone(), a, d, b.clone(), b, c]]);
    assert_eq!(drawn.overdraw, plain.overdraw);
}

#[test]
fn nasty_vertices_at_and_beyond_infinity() {
    let at_infinity = Drawn::of(&[&with_apex([0.0, 1.0, 0.0, 0.0])]);
    let top = at_infinity.overdraw.integers()[..64].iter().filter(|count| **count == 1).count();
    assert_eq!(top, 32, "the sides are parallel up to the edge of the target");
    let column: Vec<f32> = (0..48).map(|row| at_infinity.attr.floats_at(row, 32)[0]).collect();
    assert!(column.windows(2).all(|pair| pair[0] > pair[1]), "{column:?}");
    let minus_zero = Drawn::of(&[&with_apex([0.0, 1.0, 0.0, -0.0])]);
    assert_eq!(minus_zero.overdraw, at_infinity.overdraw);
    assert_eq!(minus_zero.attr, at_infinity.attr);
    // Behind the eye: the sides diverge, and the near plane cuts.
    let behind = Drawn::of(&[&with_apex([0.0, 0.6, -0.5, -1.0])]);
    assert!(behind.covered() > 0 && behind.is_once_at_most());
    assert_eq!(behind.stats["clipped"], 1);

    for size in [1e20_f32, 3e38] {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let cover = square.map(|[x, y]| vec![x * size, y * size, 0.5, 1.0, 0.5]);
        let drawn = Drawn::of(&[&cover]);
        assert!(drawn.overdraw.integers().iter().all(|count| *count == 1), "{size:e}");
        assert!(drawn.attr.floats().iter().all(|u| *u == 0.5));
    }
}

#[test]
fn nasty_depths() {
    let plain = Drawn::of(&[&triangle()]);
    for z in [0.0, 1.0] {
        let flat = triangle().map(|mut vertex| {
            vertex[2] = z;
            vertex
        });
        assert_eq!(Drawn::of(&[&flat]).overdraw, plain.overdraw, "z = {z}");
    }
    let cut = Drawn::of(&[&with_apex([0.0, 0.6, -0.5, 1.0])]);
    assert!(cut.covered() < plain.covered() && cut.covered() > plain.covered() / 2);
}

#[test]
fn nasty_attributes_spoil_only_themselves() {
    let pair = |u: [f32; 3]| {
        let mut all = triangle().to_vec();
        for (vertex, u) in all.iter_mut().zip(u) {
            vertex.insert(4, u);
        }
        all
    };
    let plain = Drawn::of(&[&pair([0.0, 1.0, 2.0])]);
    let spoilt = Drawn::of(&[&pair([0.0, f32::NAN, 2.0])]);
    assert_eq!((&spoilt.overdraw, &spoilt.depth), (&plain.overdraw, &plain.depth));
    let second = |drawn: &Drawn| -> Vec<u32> {
        drawn.attr.words.iter().skip(1).step_by(2).copied().collect()
    };
    assert_eq!(second(&spoilt), second(&plain));
    for value in [3e38, 1e-40, -0.1] {
        for w in [0.5, 1.0, 3.0] {
            let mut all = scaled(&pair([value; 3]), 0.5);
            all[1] = scaled(&all[1..2], w).remove(0);
            let drawn = Drawn::of(&[&all]);
            let first = drawn.attr.words.iter().step_by(2);
            let covered = first.zip(drawn.overdraw.integers()).filter(|(_, count)| **count == 1);
            assert!(covered.clone().count() > 500);
            assert!(covered.clone().all(|(word, _)| *word == value.to_bits()), "{value:e}, {w}");
        }
    }
}

#[test]
fn nasty_neighbours_leave_no_crack() {
    // A fan about a pixel's centre, in both orders, with edges through centres in 8 octants.
    let rim = |k: i32| {
        let (x, y) = [(8, 0), (8, 8), (0, 8), (-8, 8), (-8, 0), (-8, -8), (0, -8), (8, -8)]
            [k.rem_euclid(8) as usize];
        vec![(x as f32 + 0.5) / 32.0, (y as f32 + 0.5) / 32.0, 0.5, 1.0, 0.0]
    };
    let centre = vec![0.5 / 32.0, 0.5 / 32.0, 0.5, 1.0, 0.0];
    let fan: Vec<[Vertex; 3]> = (0..8)
        .map(|k| {
            let (a, b) = (rim(k), rim(k + 1));
            if k % 2 == 0 { [centre.clone(), a, b] } else { [b, a, centre.clone()] }
        })
        .collect();
    let fan: Vec<&[Vertex]> = fan.iter().map(<[Vertex; 3]>::as_slice).collect();
    let drawn = Drawn::of(&fan);
    assert_eq!(drawn.covered(), 16 * 16);
    assert!(drawn.is_once_at_most());

    // Two that share an edge: the second one reaches behind the eye and must be clipped.
    let [a, b, c] = triangle();
    let behind = vec![3.0, 2.0, -0.5, -1.0, 0.0];
    let whole = Drawn::of(&[&[a.clone(), b.clone(), c.clone()]]);
    let beside = [c.clone(), b.clone(), behind];
    let both = Drawn::of(&[&triangle(), &beside]);
    assert!(both.is_once_at_most() && both.covered() > whole.covered());
    for row in 0..64 {
        let counts: Vec<u32> = (0..64).map(|column| both.overdraw.at(row, column)[0]).collect();
        let runs = counts.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(runs <= 2, "row {row} has a gap: {counts:?}");
    }

    // The same list from another vertex on: the same bits.
    let whole_bits = Drawn::of(&[&[b, c, a]]);
    assert_eq!((whole_bits.attr, whole_bits.depth), (whole.attr, whole.depth));
}

#[test]
fn nasty_numbers_of_vertices() {
    const N: u32 = 100_000;
    let vertex = |i: u32| {
        let angle = f64::from(i) / f64::from(N) * std::f64::consts::TAU;
        vec![angle.cos() as f32 * 0.9, angle.sin() as f32 * 0.9, 0.5, 1.0, 0.5]
    };
    let drawn = Drawn::of(&[&(0..N).map(vertex).collect::<Vec<_>>()]);
    let area = std::f64::consts::PI * 28.8 * 28.8;
    assert!((drawn.covered() as f64 - area).abs() < 20.0, "{} of {area}", drawn.covered());
    assert!(drawn.is_once_at_most());
}
