//! OBJ files as they are found in the wild: all of these draw the same.

use crate::harness::Folder;

/// A square of two materials' worth of colours, as plainly as it can be written.
const PLAIN: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                     vn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";

const VIEW: &str = "--ortho 4 --eye 0,0,5 --target 0,0,0 --size 24x16 --shade unlit";

/// Ids, texture coordinates and normals of all pixels of `model.obj`.
fn drawn(folder: &Folder) -> [Vec<u8>; 3] {
    folder.good(&format!(
        "render model.obj {VIEW} --aov id=id.npy --aov uv=uv.npy --aov normal=normal.npy"
    ));
    ["id.npy", "uv.npy", "normal.npy"].map(|name| folder.read(name))
}

#[test]
fn obj_quirks_change_nothing() {
    let plain = drawn(&Folder::with(&[("model.obj", PLAIN)]));
    let with = |from: &str, to: &str| {
        assert!(PLAIN.contains(from));
        PLAIN.replace(from, to).into_bytes()
    };
    let variants: Vec<(&str, Vec<u8>)> = vec![
        ("CRLF", with("\n", "\r\n")),
        ("tabs", with(" ", " \t ")),
        ("a byte order mark", [b"\xEF\xBB\xBF", PLAIN.as_bytes()].concat()),
        ("Latin-1 in a comment", [b"# Gr\xFC\xDFe \\\n", PLAIN.as_bytes(), b"# \xE9"].concat()),
        ("comments behind", with("\n", " # 1 2 3\n")),
        ("continued lines", with("2/2/1 3/3/1", "2/2/1 \\\r\n  3/3/1")),
        ("negative indices", with("1/1/1 2/2/1 3/3/1 4/4/1", "-4/-4/-1 -3/-3/1 3/3/1 -1/-1/-1")),
        ("a weight", with("v 1 1 0", "v 1 1 0 1")),
        ("a colour on one vertex", with("v 1 1 0", "v 1 1 0 1 1 1")),
        ("a third texture coordinate", with("vt 1 1", "vt 1 1 0")),
        ("no second texture coordinate", with("vt 1 0", "vt 1")),
        ("exponents and signs", with("v 1 1 0", "v +1e0 0.1E1 -0")),
        ("lines and points", with("f ", "l 1 2 3\np 1\nl 1/1 2/2\nf 1 2\nf ")),
        ("groups", with("f ", "o a b\ng c d\ns off\ns 1\nmg 1 2\nf ")),
        ("the face first", {
            let (vertices, face) = PLAIN.split_at(PLAIN.find("f 1").expect("a face"));
            format!("{face}{vertices}").into_bytes()
        }),
        ("no newline at the end", PLAIN.trim_end().as_bytes().to_vec()),
        ("an unused vertex far away", with("vn ", "v 9e9 9e9 9e9\nvn ")),
    ];
    for (what, bytes) in variants {
        let folder = Folder::new();
        folder.write("model.obj", &bytes);
        assert!(drawn(&folder) == plain, "{what}");
    }
}

#[test]
fn obj_corners_without_attributes_mix_with_others() {
    // The second face has no texture coordinates, the third no normals.
    let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nvt .5 .5\nvn 0 1 0\n\
                f 1/1/1 2/1/1 5/1/1\nf 2//1 3//1 5//1\nf 3/1 4/1 5/1\nf 4 1/1 5\n";
    let folder = Folder::with(&[("model.obj", text)]);
    drawn(&folder);
    let (id, uv, normal) = (folder.npy("id.npy"), folder.npy("uv.npy"), folder.npy("normal.npy"));
    // Pixels below, right of, above and left of the middle.
    for (face, (row, column)) in [(10, 12), (7, 14), (5, 11), (7, 9)].into_iter().enumerate() {
        assert_eq!(id.at(row, column), [u32::try_from(face).expect("0 to 3")]);
        let has_uv = face == 0 || face == 2;
        let wanted = if has_uv { [0.5, 0.5] } else { [0.0, 0.0] };
        assert_eq!(uv.floats_at(row, column), wanted, "face {face}");
        let n = normal.floats_at(row, column);
        if face < 2 {
            assert_eq!(n, [0.0, 1.0, 0.0]);
        } else {
            // Its own: unit length, and towards the viewer.
            assert!((n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-6 && n[2] > 0.0);
        }
    }
}

#[test]
fn textures_and_colours_are_found() {
    let model = "mtllib no such.mtl\nmtllib my materials.mtl other.mtl\n\
        v -1 -1 0 1 .5 0\nv 1 -1 0 1 .5 0\nv 1 1 0 1 .5 0\nv -1 1 0 1 .5 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        usemtl Material #1\nf 1/1 2/2 3/3 4/4\n";
    let draw = |material: &str, face: &str| {
        let model = model.replace("Material #1", material).replace("f 1/1 2/2 3/3 4/4", face);
        let folder = Folder::with(&[
            ("model.obj", &model),
            (
                "my materials.mtl",
                "newmtl Material #1\nKd .5 .5 .5\nmap_Kd -s 1 1 1 pic tures/a b.png\n",
            ),
            ("other.mtl", "newmtl bare\nKd .5 1 1\nnewmtl missing\nmap_Kd gone.png\n"),
        ]);
        folder.write("pic tures/.keep", b"");
        let (red, green, blue, white) =
            ([255, 0, 0, 255], [0, 255, 0, 0], [0, 0, 255, 255], [255; 4]);
        folder.write_png("pic tures/a b.png", 2, &[red, green, blue, white]);
        let run = folder.run(&format!("render model.obj {VIEW} -o out.png --aov color=color.npy"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let picture = folder.png("out.png");
        let colors = folder.npy("color.npy");
        let quarters = [(5, 10), (5, 13), (10, 10), (10, 13)].map(|(row, column)| {
            let pixel = picture.get_pixel(column, row).0;
            let rounded = colors.floats_at(row as usize, column as usize);
            let rounded: Vec<u8> =
                rounded.iter().map(|c| (c * 255.0).round_ties_even() as u8).collect();
            assert_eq!(pixel, *rounded);
            pixel
        });
        (quarters, run.stderr)
    };
    let whole = "f 1/1 2/2 3/3 4/4";
    // The texel as it is, opaque; v = 0 is the bottom row.
    let (quarters, messages) = draw("Material #1", whole);
    assert_eq!(quarters, [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]]);
    assert!(messages.contains("warning: model.obj:1: there is no no such.mtl"), "{messages}");
    assert!(messages.contains("warning: my materials.mtl:3: -s of map_Kd"), "{messages}");
    // Vertex colours times Kd.
    let (quarters, messages) = draw("bare", whole);
    assert_eq!(quarters, [[128, 128, 0, 255]; 4]);
    assert!(!messages.contains("bare"), "{messages}");
    // Without coordinates there is no texel.
    assert_eq!(draw("Material #1", "f 1 2 3 4").0, [[128, 64, 0, 255]; 4]);
    // What is missing is warned about, and drawn without.
    let (quarters, messages) = draw("missing", whole);
    assert_eq!(quarters, [[255, 128, 0, 255]; 4]);
    assert!(messages.contains("warning: other.mtl:4: there is no gone.png"), "{messages}");
    let (quarters, messages) = draw("unknown", whole);
    assert_eq!(quarters, [[255, 128, 0, 255]; 4]);
    assert!(
        messages.contains("warning: model.obj:11: there is no material `unknown`"),
        "{messages}"
    );
}

#[test]
fn faces_of_every_kind_are_filled_and_keep_their_number() {
    // An L, a bent square, a square with twisted texture coordinates, a plain triangle.
    let text = "v -2 -2 0\nv 0 -2 0\nv 0 -1 0\nv -1 -1 0\nv -1 0 0\nv -2 0 0\nf 1 2 3 4 5 6\n\
                v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nf -4 -3 -2 -1\n\
                v 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 5 5\nvt 0 1\n\
                f -4/1 -3/2 -2/3 -1/4\nv -2 1 0\nv -1 1 0\nv -2 2 0\nf -3 -2 -1\n";
    let folder = Folder::with(&[("model.obj", text)]);
    folder.good(
        "render model.obj --ortho 4 --eye 0,0,5 --target 0,0,0 --size 8x8 --cull back \
         --aov id=id.npy --aov overdraw=overdraw.npy --stats stats.json",
    );
    let none = u32::MAX;
    #[rustfmt::skip]
    assert_eq!(folder.npy("id.npy").integers(), [
        none, none, none, none, none, none, none, none,
        3,    none, none, none, none, none, none, none,
        none, none, none, none, 1,    1,    2,    2,
        none, none, none, none, 1,    1,    2,    2,
        0,    0,    none, none, none, none, none, none,
        0,    0,    none, none, none, none, none, none,
        0,    0,    0,    0,    none, none, none, none,
        0,    0,    0,    0,    none, none, none, none,
    ]);
    assert!(folder.npy("overdraw.npy").integers().iter().all(|count| *count <= 1));
    assert_eq!(folder.json("stats.json")["polygons"], 4);

    let info: serde_json::Value =
        serde_json::from_slice(&folder.good("info model.obj --json")).expect("JSON");
    assert_eq!(info["polygons"], 4);
    assert_eq!(info["polygons_by_vertices"], serde_json::json!({"3": 1, "4": 2, "6": 1}));
    assert_eq!(
        [&info["not_convex"], &info["not_flat"], &info["not_affine"], &info["degenerate"]],
        [1, 1, 1, 0]
    );
    assert_eq!(
        info["bounds"],
        serde_json::json!({"min": [-2.0, -2.0, 0.0], "max": [2.0, 2.0, 1.0]})
    );
    let text = String::from_utf8(folder.good("info model.obj")).expect("UTF-8");
    assert!(text.contains("not convex          1\n"), "{text}");
}

#[test]
fn vertices_that_are_no_points_are_refused_and_the_rest_is_drawn() {
    let text =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv NaN 1 0\nv -1 inf 0\nf 1 2 3\nf 1 3 4\nf 1 3 5\nf 1 1 1\n";
    let folder = Folder::with(&[("model.obj", text)]);
    let run = folder.run("render model.obj --size 32x32 --aov id=id.npy --stats stats.json");
    assert_eq!(run.code, Some(0));
    assert!(
        run.stderr.starts_with("warning: model.obj: NaN or infinite positions: 2"),
        "{}",
        run.stderr
    );
    assert!(folder.npy("id.npy").integers().contains(&0), "the model is framed all the same");
    let stats = folder.json("stats.json");
    assert_eq!((&stats["polygons"], &stats["culled"]["refused"]), (&4.into(), &2.into()));
    assert_eq!(stats["culled"]["degenerate"], 1);
}

#[test]
fn models_are_framed_whatever_their_size_and_place() {
    for (scale, shift) in [(1.0, 0.0), (1e-12, 0.0), (1e12, 0.0), (1.0, 1e6), (0.0, 3.0)] {
        let corner = |bits: u32| {
            let side = |bit: u32| f64::from(bits >> bit & 1) * scale + shift;
            format!("v {:e} {:e} {:e}\n", side(0), side(1), 3.0 * side(2))
        };
        let vertices: String = (0..8).map(corner).collect();
        let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        let folder = Folder::with(&[("model.obj", &format!("{vertices}{faces}"))]);
        for lens in ["", "--fov-y 100", "--size 50x200", "--intrinsics 90,90,50,50"] {
            folder.good(
                &format!("render model.obj --size 100x100 {lens} --aov id=id.npy")
                    .replace("--size 100x100 --size", "--size"),
            );
            let ids = folder.npy("id.npy");
            let (rows, columns) = (ids.shape[0], ids.shape[1]);
            let covered = |row: usize, column: usize| ids.at(row, column) != [u32::MAX];
            let border = (0..rows)
                .flat_map(|row| (0..columns).map(move |column| (row, column)))
                .filter(|(r, c)| *r == 0 || *c == 0 || r + 1 == rows || c + 1 == columns);
            assert!(border.clone().all(|(r, c)| !covered(r, c)), "{scale} {shift} {lens}");
            let area = (0..rows * columns).filter(|i| covered(i / columns, i % columns)).count();
            assert!(scale == 0.0 || area * 12 > rows * columns, "{scale} {shift} {lens}: {area}");
        }
    }
}

#[test]
fn light_falls_on_bare_models_only_unless_asked() {
    // A roof: the left slope is turned to the light.
    let text = "v -1 0 0\nv 0 0 1\nv 0 1 1\nv -1 1 0\nv 1 0 0\nv 1 1 0\nf 1 2 3 4\nf 2 5 6 3\n";
    let folder = Folder::with(&[("model.obj", text)]);
    let gray = |flags: &str, row: u32, column: u32| {
        folder.good(&format!(
            "render model.obj --ortho 2 --eye 0,.5,5 --target 0,.5,0 --size 16x16 {flags} -o out.png"
        ));
        let [r, g, b, a] = folder.png("out.png").get_pixel(column, row).0;
        assert!(r == g && g == b && a == 255);
        r
    };
    let (left, right) = (gray("", 8, 5), gray("", 8, 11));
    assert!(255 > left && left > right && right > 40, "{left} {right}");
    assert_eq!(gray("--shade gouraud", 8, 5), left);
    assert_eq!(gray("--shade unlit", 8, 5), 255);
    let colored = text.replace("v 0 0 1\n", "v 0 0 1 1 1 1\n");
    folder.write("model.obj", colored.as_bytes());
    assert_eq!(gray("", 8, 5), 255);
    assert_eq!(gray("--shade gouraud", 8, 5), left);
}
