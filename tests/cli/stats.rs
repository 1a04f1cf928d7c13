//! `--stats`: the keys that other programs read, and what they count.

use crate::harness::Folder;

const TRIANGLES: &str = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n";

#[test]
fn stats_have_all_keys() {
    let folder = Folder::with(&[("model.obj", TRIANGLES), ("t.poly", "0 0 0 1\n")]);
    for arguments in ["render model.obj", "tile t.poly"] {
        folder.good(&format!("{arguments} --size 64x64 --stats stats.json --repeat 3 --threads 3"));
        let stats = folder.json("stats.json");
        let keys: Vec<&String> = stats.as_object().expect("an object").keys().collect();
        #[rustfmt::skip]
        assert_eq!(keys, [
            "clipped", "constant_w", "culled", "frames", "median_ms", "min_ms", "peak_bytes",
            "pixels_covered", "pixels_hidden", "pixels_shaded", "polygons", "precision", "simd",
            "spans", "threads",
        ]);
        let keys = |key: &str| -> Vec<String> {
            stats[key].as_object().expect("an object").keys().cloned().collect()
        };
        assert_eq!(keys("culled"), ["backface", "degenerate", "hidden", "outside", "refused"]);
        assert_eq!(keys("constant_w"), ["column", "polygon", "row"]);
        assert_eq!(stats["frames"], 3);
        assert_eq!(stats["threads"], 3);
        assert_eq!(stats["precision"], "fast");
        let (least, median) = (stats["min_ms"].as_f64(), stats["median_ms"].as_f64());
        assert!(least > Some(0.0) && median >= least);
    }
}

#[test]
fn stats_are_of_one_frame_and_do_not_change_with_repeats() {
    let folder = Folder::with(&[("model.obj", TRIANGLES)]);
    let counts = |repeat: u32| {
        folder.good(&format!(
            "render model.obj --size 64x64 --threads 1 --stats s.json --repeat {repeat}"
        ));
        let mut stats = folder.json("s.json");
        let object = stats.as_object_mut().expect("an object");
        for key in ["frames", "min_ms", "median_ms"] {
            object.remove(key);
        }
        stats
    };
    assert_eq!(counts(1), counts(7));
    assert!(counts(1)["pixels_covered"].as_u64() > Some(200));
}

#[test]
fn stats_count_faces_and_not_pieces() {
    // A plus sign, not convex, half of it behind the eye; one wholly behind; one seen from
    // its back.
    let plus = "f -12 -11 -10 -9 -8 -7 -6 -5 -4 -3 -2 -1\n";
    let corners = [
        (1, 3),
        (-1, 3),
        (-1, 1),
        (-3, 1),
        (-3, -1),
        (-1, -1),
        (-1, -3),
        (1, -3),
        (1, -1),
        (3, -1),
        (3, 1),
        (1, 1),
    ];
    let at = |z: fn(i32) -> i32| -> String {
        corners.iter().map(|(x, y)| format!("v {x} {y} {}\n", z(*y))).collect()
    };
    let mirrored: String = corners.iter().map(|(x, y)| format!("v {} {y} -9\n", -x)).collect();
    let text = format!("{}{plus}{}{plus}{mirrored}{plus}", at(|y| 3 * y - 1), at(|_| 9));
    let folder = Folder::with(&[("model.obj", &text)]);
    folder.good(
        "render model.obj --eye 0,0,0 --target 0,0,-1 --near .1 --size 64x64 --cull back \
         --stats s.json",
    );
    let stats = folder.json("s.json");
    assert_eq!(stats["polygons"], 3);
    assert_eq!(stats["clipped"], 1);
    assert_eq!(stats["culled"]["outside"], 1);
    assert_eq!(stats["culled"]["backface"], 1);
    assert_eq!(stats["culled"]["degenerate"], 0);
}

#[test]
fn stats_count_the_faces_that_are_culled() {
    let folder = Folder::with(&[("model.obj", TRIANGLES)]);
    for (flags, backface) in [("--cull none", 0), ("--cull back", 1)] {
        folder.good(&format!(
            "render model.obj --ortho 2 --eye 0,0,5 --target 0,0,0 --size 8x8 {flags} --stats s.json"
        ));
        let stats = folder.json("s.json");
        assert_eq!(stats["culled"]["backface"], backface);
        assert_eq!(stats["constant_w"]["polygon"], 2 - backface);
    }
}
