//! P3: one hash for each scene and precision, whatever instruction set, profile, machine or crop.
//!
//! The hashes stand below: a machine, or a profile, that draws other bits fails. tests/neon.sh
//! runs this file on 64-bit Arm.

#[expect(dead_code, reason = "the benches use the rest")]
mod scenes;

use hyperspan::shade::Fragment;
use hyperspan::simd::Simd;
use hyperspan::target::Plane;
use hyperspan::tiler::Precision;
use scenes::draw::{Placed, Stage};
use scenes::{Look, Scene};

/// Of the pictures: small, and no multiple of a block.
const SIZE: (u32, u32) = (323, 181);

/// Where the picture is cut in four: not at a block's end.
const CUT: (u32, u32) = (133, 77);

/// Scene, `Fast`, `Exact`.
const HASHES: &[(&str, u64, u64)] = &[
    ("floor", 0x07c9797c00a1af02, 0xaa4f4d5c3912c1aa),
    ("floor_roll", 0x700c114a0784fe18, 0x58289df799c9441b),
    ("room", 0xfa01a7af7e9af525, 0x28a137ada98c10dc),
    ("walls", 0xdb0e80d85cf24f52, 0x582245ad72edf75a),
    ("mesh", 0xefad46ea76cebf11, 0xc7b0cbafa355907f),
    ("mesh_full", 0x34fb57b6bb3e16cb, 0x76af051ce28f05f8),
    ("soup", 0x3e67f76491c76430, 0x9bdf2e005c430bd9),
    ("layers_ftb", 0xb63ae7b8707a048d, 0xb280a09ce11362f5),
    ("layers_btf", 0xa94c7d17078a402f, 0x92c5e9cb0cf4d9cf),
    ("ngons", 0x8cf6272ca3494ed1, 0xebbcedd7c0bb5023),
    ("clip", 0x1840da2dd0a40f1b, 0xb1316d1beb78e075),
    ("hairs", 0x99ca5627a945485e, 0x54fd7c84987228a6),
    ("boxes", 0xba7b8490739351f6, 0x572229f4ba2425a5),
    ("board", 0x6c863734eaff9e00, 0xf18c838ef7cd9972),
];

/// FNV-1a.
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }

    /// Colours are rounded to 8 bits, and hide what is below: so the numbers they are made of
    /// count too.
    fn of(stage: &Stage<'_>, values: &[[f32; 4]]) -> u64 {
        let mut hash = Self::new();
        hash.add(stage.colour.as_flattened());
        stage.depth.iter().for_each(|depth| hash.add(&depth.to_bits().to_le_bytes()));
        values.as_flattened().iter().for_each(|v| hash.add(&v.to_bits().to_le_bytes()));
        hash.0
    }
}

/// What a closure sees of a pixel: 1/w and the attributes, of the last face that covers it.
fn draw_values(stage: &mut Stage<'_>, values: &mut [[f32; 4]], at: [u32; 2], size: [u32; 2]) {
    let Stage { scene, tiler, clip, .. } = stage;
    let stride = scene.size.0 as usize;
    let first = at[1] as usize * stride + at[0] as usize;
    let mut target = Plane::with_stride(&mut values[first..], size[0], size[1], stride)
        .expect("a part of the picture");
    tiler.set_origin(at[0].cast_signed(), at[1].cast_signed());
    for face in &scene.faces {
        match face.look {
            Look::Coloured => {
                let mut shader = |pixel: &Fragment<'_>| {
                    let [r, g, b] = [0, 1, 2].map(|k| pixel.attribute(k));
                    [pixel.inv_w(), r, g, b]
                };
                let face = Placed::<3>::new(scene, clip, *face);
                tiler.draw(&face, &mut shader, &mut target, None);
            }
            Look::Textured(_) => {
                let mut shader = |pixel: &Fragment<'_>| {
                    [pixel.inv_w(), pixel.attribute(0), pixel.attribute(1), pixel.w()]
                };
                let face = Placed::<2>::new(scene, clip, *face);
                tiler.draw(&face, &mut shader, &mut target, None);
            }
        }
    }
}

/// The hash of the whole picture, and that of the same drawn in four parts.
fn hashes(scene: &Scene, precision: Precision, simd: Simd) -> [u64; 2] {
    let (width, height) = scene.size;
    let whole = [([0, 0], [width, height])];
    let quarters = [
        ([0, 0], [CUT.0, CUT.1]),
        ([CUT.0, 0], [width - CUT.0, CUT.1]),
        ([0, CUT.1], [CUT.0, height - CUT.1]),
        ([CUT.0, CUT.1], [width - CUT.0, height - CUT.1]),
    ];
    [&whole[..], &quarters[..]].map(|parts| {
        let mut stage = Stage::new(scene, precision, simd);
        let mut values = vec![[0.0; 4]; stage.depth.len()];
        stage.clear();
        stage.transform();
        for (at, size) in parts {
            stage.draw_part(*at, *size);
            draw_values(&mut stage, &mut values, *at, *size);
        }
        Hash::of(&stage, &values)
    })
}

/// Draws everything in every way, and gives the table as it came out, and what is wrong with it.
pub fn table() -> (String, Vec<String>) {
    let (mut table, mut wrong) = (String::new(), Vec::new());
    for scene in scenes::all(SIZE) {
        let found = [Precision::Fast, Precision::Exact].map(|precision| {
            let [first, _] = hashes(&scene, precision, Simd::scalar());
            for (level, simd) in Simd::all() {
                let [whole, parts] = hashes(&scene, precision, simd);
                for (what, hash) in [("whole", whole), ("in parts", parts)] {
                    if hash != first {
                        wrong.push(format!("{} {precision:?} {level} {what}", scene.name));
                    }
                }
            }
            first
        });
        if !HASHES.contains(&(scene.name, found[0], found[1])) {
            wrong.push(format!("{}: not the hashes of the table", scene.name));
        }
        let [fast, exact] = found;
        table += &format!("    (\"{}\", {fast:#018x}, {exact:#018x}),\n", scene.name);
    }
    (table, wrong)
}

#[test]
fn same_hash_everywhere() {
    let (table, wrong) = table();
    assert!(
        wrong.is_empty() && HASHES.len() == table.lines().count(),
        "{wrong:#?}\nIf bits were meant to change, this is the new table:\n{table}"
    );
}
