//! `tile`: polygons in clip space, with and without depth.

use crate::harness::Folder;

const COVER: &str = "-1 -1 .5 1\n3 -1 .5 1\n-1 3 .5 1\n";
const ALL: &str = "--aov depth=depth.npy --aov w=w.npy --aov id=id.npy --aov overdraw=overdraw.npy \
    --aov color=color.npy --aov attr=attr.npy";

#[test]
fn tile_draws_every_pixel_of_a_cover_once() {
    let folder = Folder::with(&[("t.poly", COVER)]);
    folder.good(&format!("tile t.poly --size 17x5 {ALL} -o out.png"));
    assert!(folder.npy("overdraw.npy").integers().iter().all(|count| *count == 1));
    assert!(folder.npy("id.npy").integers().iter().all(|id| *id == 0));
    assert!(folder.npy("depth.npy").floats().iter().all(|depth| *depth == 0.5));
    assert_eq!(folder.npy("attr.npy").shape, [5, 17, 0]);
    assert!(folder.png("out.png").pixels().all(|pixel| pixel.0 == [255; 4]));
}

#[test]
fn tile_shows_the_first_three_attributes() {
    for (attributes, wanted) in [
        ("", [255, 255, 255, 255]),
        ("0", [0, 255, 255, 255]),
        (".2 NaN", [51, 0, 255, 255]),
        ("-7 .5 1e30 .3", [0, 128, 255, 255]),
    ] {
        let text = COVER.replace(".5 1\n", &format!(".5 1 {attributes}\n"));
        let folder = Folder::with(&[("t.poly", &text)]);
        folder.good(&format!("tile t.poly --size 4x4 {ALL} -o out.png"));
        assert_eq!(folder.png("out.png").get_pixel(2, 1).0, wanted);
        let n = attributes.split_whitespace().count();
        let attr = folder.npy("attr.npy");
        assert_eq!(attr.shape, [4, 4, n]);
        for (value, word) in attr.at(2, 1).iter().zip(attributes.split_whitespace()) {
            let exact: f32 = word.parse().expect("a number");
            assert_eq!(*value, if exact.is_nan() { 0x7FC0_0000 } else { exact.to_bits() });
        }
        let color = folder.npy("color.npy").floats_at(2, 1);
        assert_eq!(color[3], 1.0);
    }
}

#[test]
fn tile_interpolates_as_the_header_says() {
    // Along x, from w = 1 on the left to w = 3 on the right.
    let vertices = "-1 -1 0 1 0 0 7\n3 -3 0 3 1 1 8\n3 3 0 3 1 1 9\n-1 1 0 1 0 0 9\n";
    let text = format!("attrs perspective noperspective flat\nzrange -1 1\n\n{vertices}");
    let folder = Folder::with(&[("t.poly", &text)]);
    folder.good(&format!("tile t.poly --size 2x2 {ALL}"));
    for (column, t) in [(0, 0.25_f32), (1, 0.75)] {
        let attr = folder.npy("attr.npy").floats_at(0, column);
        // r/w and 1/w are linear.
        let perspective = (t / 3.0) / ((1.0 - t) + t / 3.0);
        assert!((attr[0] - perspective).abs() < 1e-7, "{attr:?}");
        assert_eq!(attr[1..], [t, 7.0]);
        assert_eq!(folder.npy("depth.npy").floats_at(0, column), [0.5], "(z/w + 1) / 2");
        let w = folder.npy("w.npy").floats_at(0, column)[0];
        assert!((w - 1.0 / ((1.0 - t) + t / 3.0)).abs() < 1e-6, "{w}");
    }
}

#[test]
fn tile_depth_decides_who_is_seen() {
    let far = COVER.replace(".5 1", ".75 1");
    let text = format!("{COVER}\n\n{far}\n# the third is as near as the first\n\n{COVER}");
    let folder = Folder::with(&[("t.poly", &text)]);
    for (flags, id, depth, shaded) in [
        ("", 2, 0.5, 48),
        ("--depth none", 2, 0.5, 48),
        ("--depth standard", 0, 0.5, 16),
        ("--depth reversed", 1, 0.75, 32),
    ] {
        folder.good(&format!("tile t.poly --size 4x4 {flags} {ALL} --stats stats.json"));
        assert!(folder.npy("id.npy").integers().iter().all(|found| *found == id), "{flags}");
        assert!(folder.npy("depth.npy").floats().iter().all(|found| *found == depth), "{flags}");
        assert!(folder.npy("overdraw.npy").integers().iter().all(|count| *count == 3));
        let stats = folder.json("stats.json");
        assert_eq!(stats["pixels_covered"], 48);
        assert_eq!(stats["pixels_shaded"], shaded);
        assert_eq!(stats["pixels_hidden"], 48 - shaded);
    }
    // Where nothing is drawn.
    folder.write("t.poly", b"0 0 0 1\n");
    for (flags, clear) in [("none", 0.0), ("standard", 1.0), ("reversed", 0.0)] {
        folder.good(&format!("tile t.poly --size 4x4 --depth {flags} {ALL}"));
        assert!(folder.npy("depth.npy").floats().iter().all(|depth| *depth == clear));
        assert!(folder.npy("id.npy").integers().iter().all(|id| *id == u32::MAX));
    }
}

#[test]
fn tile_counts_what_it_does_not_draw() {
    let text = "0 0 0 1\n\n0 0 0 1\n1 0 0 1\n\nNaN 0 0 1\n1 0 0 1\n0 1 0 1\n\n\
                9 0 0 1\n9 1 0 1\n8 0 0 1\n\n0 0 0 1\n.5 0 0 1\n0 .5 0 1\n\n0 0 0 1\n0 .5 0 1\n.5 0 0 1\n";
    let folder = Folder::with(&[("t.poly", text)]);
    let run = folder.run("tile t.poly --size 16x16 --stats - --aov id=id.npy");
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.starts_with("warning: t.poly: NaN"), "{}", run.stderr);
    let stats: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(stats["polygons"], 6);
    assert_eq!(stats["culled"]["degenerate"], 2);
    assert_eq!(stats["culled"]["refused"], 1);
    assert_eq!(stats["culled"]["outside"], 1);
    assert_eq!(stats["culled"]["backface"], 0, "tile never culls");
    // Later polygons overwrite, and all are counted in the numbers.
    assert!(folder.npy("id.npy").integers().iter().all(|id| *id == 5 || *id == u32::MAX));
}

#[test]
fn tile_crops_are_parts_of_the_whole() {
    let text = "-.9 -.7 .2 1 0 1\n1.4 -.5 .8 2 1 0\n.3 .9 .1 .7 .5 .5\n";
    let folder = Folder::with(&[("t.poly", text)]);
    let names = ["depth", "w", "id", "overdraw", "color", "attr"];
    let arrays = || names.map(|name| folder.npy(&format!("{name}.npy")));
    folder.good(&format!("tile t.poly --size 70x60 {ALL}"));
    let whole = arrays();
    folder.good(&format!("tile t.poly --size 70x60 {ALL} --crop 13,21,33,7"));
    for (part, whole) in arrays().iter().zip(&whole) {
        for row in 0..7 {
            for column in 0..33 {
                assert_eq!(part.at(row, column), whole.at(21 + row, 13 + column));
            }
        }
    }
}

#[test]
fn tile_takes_ten_thousand_attributes() {
    let values: String = (0..10_000).map(|k| format!(" {k}")).collect();
    let text = COVER.replace(".5 1\n", &format!(".5 1{values}\n"));
    let folder = Folder::with(&[("t.poly", &text)]);
    folder.good("tile t.poly --size 2x1 --aov attr=attr.npy");
    let attr = folder.npy("attr.npy");
    assert_eq!(attr.shape, [1, 2, 10_000]);
    assert_eq!(attr.floats_at(0, 1)[9_999], 9_999.0);
}
