//! What `--aov` writes: shapes, types and values; and that a crop is a part of the whole.

use crate::harness::Folder;

/// A square of side 1 about the origin, coloured from left to right, and one behind it that is
/// twice as large, without attributes.
const SQUARES: &str = "v -.5 -.5 0 0 1 1\nv .5 -.5 0 1 1 1\nv .5 .5 0 1 1 1\nv -.5 .5 0 0 1 1\n\
    vt 2 -1\nvt 3 -1\nvt 3 0\nvt 2 0\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/1 4/4/1\n\
    v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nf 5 6 7 8\n";

/// 8 x 8 pixels, 4 to a unit; depths 1 to 9.
const ORTHO: &str =
    "--ortho 2 --eye 0,0,5 --target 0,0,0 --near 1 --far 9 --size 8x8 --shade unlit";

const ALL: &str = "--aov depth=depth.npy --aov w=w.npy --aov id=id.npy --aov overdraw=overdraw.npy \
    --aov uv=uv.npy --aov normal=normal.npy --aov position=position.npy --aov color=color.npy";

const NAMES: [&str; 8] = ["depth", "w", "id", "overdraw", "uv", "normal", "position", "color"];

#[test]
fn data_has_the_values_that_geometry_says() {
    let folder = Folder::with(&[("model.obj", SQUARES)]);
    folder.good(&format!("render model.obj {ORTHO} {ALL}"));
    let shapes: Vec<Vec<usize>> =
        NAMES.iter().map(|name| folder.npy(&format!("{name}.npy")).shape).collect();
    let (one, two, three, four) = (vec![8, 8], vec![8, 8, 2], vec![8, 8, 3], vec![8, 8, 4]);
    assert_eq!(shapes, [&one, &one, &one, &one, &two, &three, &three, &four].map(Clone::clone));
    let [depth, w, uv, normal, position, color] =
        ["depth", "w", "uv", "normal", "position", "color"]
            .map(|n| folder.npy(&format!("{n}.npy")));
    let (id, overdraw) = (folder.npy("id.npy"), folder.npy("overdraw.npy"));
    for row in 0..8 {
        for column in 0..8 {
            let inner = (2..6).contains(&row) && (2..6).contains(&column);
            let x = (column as f32 - 3.5) / 4.0;
            let y = (3.5 - row as f32) / 4.0;
            let at = |npy: &crate::harness::Npy| npy.floats_at(row, column);
            // Reversed: (far - d) / (far - near).
            assert_eq!(at(&depth), [if inner { 0.5 } else { 0.375 }]);
            assert_eq!(at(&w), [1.0]);
            assert_eq!(id.at(row, column), [u32::from(!inner)]);
            assert_eq!(overdraw.at(row, column), [1 + u32::from(inner)]);
            assert_eq!(at(&position), [x, y, if inner { 0.0 } else { -1.0 }]);
            if inner {
                assert_eq!(at(&uv), [x + 2.5, y - 0.5], "as in the file, not wrapped");
                assert_eq!(at(&normal), [0.0, 0.0, 2.0], "not normalised");
                assert_eq!(at(&color), [x + 0.5, 1.0, 1.0, 1.0]);
            } else {
                assert_eq!(at(&uv), [0.0, 0.0]);
                assert_eq!(at(&normal), [0.0, 0.0, 1.0]);
                assert_eq!(at(&color), [1.0; 4]);
            }
        }
    }
}

#[test]
fn data_is_clear_where_nothing_is_drawn() {
    let folder = Folder::with(&[("model.obj", SQUARES)]);
    // The large square ends at pixels 2 and 6.
    for (flags, clear) in [("", 0.0), ("--depth standard", 1.0)] {
        folder.good(
            &format!("render model.obj {ORTHO} {ALL} {flags} --ortho 4 -o out.png").replacen(
                "--ortho 2 ",
                "",
                1,
            ),
        );
        for name in NAMES {
            let npy = folder.npy(&format!("{name}.npy"));
            let wanted = match name {
                "depth" => f32::to_bits(clear),
                "id" => u32::MAX,
                _ => 0,
            };
            assert!(npy.at(1, 1).iter().all(|word| *word == wanted), "{name}");
            assert!(npy.at(2, 2).iter().any(|word| *word != wanted) || name == "uv", "{name}");
        }
        assert_eq!(folder.png("out.png").get_pixel(1, 1).0, [0; 4]);
        assert_eq!(folder.png("out.png").get_pixel(2, 2).0, [255; 4]);
    }
}

#[test]
fn data_of_a_perspective_camera() {
    let folder = Folder::with(&[
        ("model.obj", SQUARES),
        (
            "camera.json",
            r#"{"eye": [0, 0, 2], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_degrees": 90,
                "near": 0.5, "far": "inf", "width": 8, "height": 8}"#,
        ),
    ]);
    folder.good(&format!("render model.obj --camera camera.json {ALL}"));
    // At distance 2 a pixel is 1/2 wide: the front square covers 2 x 2, the one behind, at
    // distance 3, does not reach the next centres.
    let id = folder.npy("id.npy");
    assert_eq!(id.integers().iter().filter(|id| **id == 0).count(), 4);
    assert_eq!(folder.npy("w.npy").floats_at(3, 3), [2.0]);
    assert_eq!(folder.npy("depth.npy").floats_at(3, 3), [0.25], "near / distance");
    assert_eq!(folder.npy("position.npy").floats_at(3, 3), [-0.25, 0.25, 0.0]);
    // A flag overrides the file: the eye farther away.
    folder.good(&format!("render model.obj --camera camera.json --eye 0,0,4 --size 16x16 {ALL}"));
    assert_eq!(folder.npy("w.npy").shape, [16, 16]);
    assert_eq!(folder.npy("w.npy").floats_at(7, 7), [4.0]);
}

#[test]
fn intrinsics_put_points_where_opencv_does() {
    // In front of an eye at the origin that looks down -z: OpenCV's (X, Y, Z) is (x, -y, -z).
    // fx X / Z + cx = 80 * 1/4 + 10.5 = 30.5, 80 * 2/4 + 10.5 = 50.5: the square covers the
    // pixels whose centres, at whole numbers, lie between: 31 to 50.
    let text = "v 1 -1 -4\nv 2 -1 -4\nv 2 -2 -4\nv 1 -2 -4\nf 1 2 3 4\n";
    let folder = Folder::with(&[("model.obj", text)]);
    folder.good(
        "render model.obj --eye 0,0,0 --target 0,0,-1 --intrinsics 80,40,10.5,5.5 --size 64x32 \
         --near .1 --aov id=id.npy",
    );
    let id = folder.npy("id.npy");
    for row in 0..32 {
        for column in 0..64 {
            // fy Y / Z + cy = 40 * 1/4 + 5.5 = 15.5, 40 * 2/4 + 5.5 = 25.5
            let inside = (31..=50).contains(&column) && (16..=25).contains(&row);
            assert_eq!(id.at(row, column), [if inside { 0 } else { u32::MAX }], "{row} {column}");
        }
    }
}

/// Draws `view`, and `crops` of it (x, y, width, height): all that they share has the same bytes.
fn crops_are_parts_of(folder: &Folder, view: &str, names: &[&str], crops: &[[usize; 4]]) {
    let planes: String = names.iter().map(|name| format!(" --aov {name}={name}.npy")).collect();
    folder.good(&format!("render {view} {planes} -o out.png"));
    let whole: Vec<_> = names.iter().map(|name| folder.npy(&format!("{name}.npy"))).collect();
    let picture = folder.png("out.png");
    for [x, y, w, h] in crops.iter().copied() {
        folder.good(&format!("render {view} {planes} -o out.png --crop {x},{y},{w},{h}"));
        for (name, whole) in names.iter().zip(&whole) {
            let part = folder.npy(&format!("{name}.npy"));
            assert_eq!(part.shape[..2], [h, w]);
            for row in 0..h {
                for column in 0..w {
                    let place = (y + row, x + column);
                    assert_eq!(
                        part.at(row, column),
                        whole.at(place.0, place.1),
                        "{name} {place:?}"
                    );
                }
            }
        }
        let [x, y, w, h] = [x, y, w, h].map(|side| u32::try_from(side).expect("small"));
        let part = image::imageops::crop_imm(&picture, x, y, w, h).to_image();
        assert!(folder.png("out.png") == part, "{view} {x} {y}");
    }
}

#[test]
fn crops_are_parts_of_the_whole() {
    let folder = Folder::with(&[("model.obj", SQUARES)]);
    let crops = [[0, 0, 50, 40], [17, 11, 16, 13], [49, 39, 1, 1], [3, 0, 1, 40]];
    let view = "model.obj --size 50x40 --background 9,8,7";
    crops_are_parts_of(&folder, view, &NAMES, &crops);
    folder.good(&format!("render {view} -o out.png"));
    assert_eq!(folder.png("out.png").get_pixel(0, 0).0, [9, 8, 7, 255]);
}

/// Rows so long that four whole blocks are shaded at once, and crops in which no four lie side by side: of what
/// needs neither depth nor w.
#[test]
fn crops_of_long_rows_are_parts_of_the_whole() {
    let folder = Folder::with(&[]);
    for name in ["room.obj", "room.mtl", "room_crate.png", "room_tiles.png", "room.json"] {
        folder.write(name, &std::fs::read(format!("tests/data/{name}")).expect("it is there"));
    }
    let crops: Vec<_> = (0..1280).step_by(320).map(|x| [x + 7, 400, 40, 320]).collect();
    for shade in ["unlit", "gouraud"] {
        let view = format!("room.obj --camera room.json --shade {shade}");
        let names = ["id", "uv", "normal", "position", "color"];
        crops_are_parts_of(&folder, &view, &names, &crops);
        folder.good(&format!("render {view} -o one.png"));
        folder.good(&format!("render {view} --aov id=id.npy -o out.png"));
        assert!(folder.png("one.png") == folder.png("out.png"), "{shade}");
    }
}

/// Whole blocks of rows, parts of them and small triangles; with textures, with light, and with neither.
#[test]
fn data_does_not_depend_on_what_else_is_asked_for() {
    let folder = Folder::with(&[("model.obj", SQUARES)]);
    for name in ["room.obj", "room.mtl", "room_crate.png", "room_tiles.png", "teapot.obj"] {
        folder.write(name, &std::fs::read(format!("tests/data/{name}")).expect("it is there"));
    }
    let views = ["model.obj", "room.obj", "teapot.obj", "room.obj --shade unlit --precision exact"]
        .map(|view| format!("{view} --size 150x90"));
    for view in views {
        folder.good(&format!("render {view} {ALL} -o all.png"));
        folder.good(&format!("render {view} -o one.png"));
        assert_eq!(folder.read("one.png"), folder.read("all.png"), "{view}");
        for name in NAMES {
            folder.good(&format!("render {view} --aov {name}=one.npy"));
            assert_eq!(
                folder.read("one.npy"),
                folder.read(&format!("{name}.npy")),
                "{view} {name}"
            );
        }
    }
    folder.good("render model.obj --size 50x40 --aov id=a.npy --aov id=b.npy --aov id=c.png");
    assert_eq!(folder.read("a.npy"), folder.read("b.npy"));
}

#[test]
fn data_does_not_depend_on_instructions() {
    let folder = Folder::with(&[("model.obj", SQUARES)]);
    let levels = ["scalar", "sse2", "sse4.2", "avx2", "avx512", "neon", "wasm"];
    folder.good(&format!("render model.obj --size 50x40 {ALL} --stats stats.json"));
    let whole = NAMES.map(|name| folder.read(&format!("{name}.npy")));
    let widest = folder.json("stats.json")["simd"].clone();
    let mut drawn = Vec::new();
    for level in levels {
        let arguments = format!("render model.obj --size 50x40 {ALL} --simd {level}");
        if folder.run(&arguments).code == Some(0) {
            assert_eq!(NAMES.map(|name| folder.read(&format!("{name}.npy"))), whole, "{level}");
            drawn.push(level);
        } else {
            folder.bad(&arguments, "this machine does not have it; it has scalar");
        }
    }
    assert_eq!(drawn.first(), Some(&"scalar"));
    assert_eq!(drawn.last().copied(), widest.as_str());
}

#[test]
fn data_as_pictures_can_be_looked_at() {
    let folder = Folder::with(&[("model.obj", SQUARES), ("t.poly", "0 0 0 1\n")]);
    for name in NAMES {
        folder.good(&format!("render model.obj {ORTHO} --aov {name}=out.PNG"));
        let picture = folder.png("out.PNG");
        assert_eq!(picture.dimensions(), (8, 8));
        // w is 1 all over, and white is as far as normals go.
        let shows = picture.get_pixel(0, 0) != picture.get_pixel(3, 3);
        assert_eq!(shows, name != "w" && name != "normal", "{name}");
    }
    folder.good("tile t.poly --size 8x8 --aov attr=out.png");
    assert_eq!(folder.png("out.png").dimensions(), (8, 8));
}

#[test]
fn results_go_to_standard_output_if_asked() {
    let folder = Folder::with(&[("model.obj", SQUARES)]);
    folder.good("render model.obj --size 9x7 -o out.png");
    assert_eq!(folder.good("render model.obj --size 9x7 -o -"), folder.read("out.png"));
    let stats = folder.good("render model.obj --size 9x7 --stats - -o again.png");
    let stats: serde_json::Value = serde_json::from_slice(&stats).expect("JSON");
    assert_eq!(stats["polygons"], 2);
    assert_eq!(folder.good("render model.obj --size 9x7 -o last.png").len(), 0);
    assert_eq!(folder.list(), ["again.png", "last.png", "model.obj", "out.png"]);
}
