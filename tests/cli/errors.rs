//! Bad usage and bad input: exit code 2, one message that names the file and the line, and no
//! file that was not there before.

use crate::harness::Folder;

const TRIANGLE: &str = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";
const POLY: &str = "-1 -1 .5 1\n3 -1 .5 1\n-1 3 .5 1\n";

fn small() -> Folder {
    Folder::with(&[("m.obj", TRIANGLE), ("t.poly", POLY)])
}

#[test]
fn bad_models_are_named_with_their_line() {
    let folder = small();
    for (bytes, wanted) in [
        (&b""[..], "bad.obj: the file is empty"),
        (b"\n  \n", "bad.obj: the file is empty"),
        (b"# only a comment\n", "bad.obj: the model has no face"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2\n", "bad.obj: the model has no face"),
        (b"v 0 0 0\nv 1 0 0\nf 1 2 3\n", "bad.obj:3: position index 3 is out of range"),
        (b"v 0 0 0\nv 1 0 0\nf 1 2 -3\n", "bad.obj:3: position index -3 is out of range"),
        (b"v 0 0 0\nv 1 0\n", "bad.obj:2: a vertex of 2 numbers"),
        (b"v 0 0 zero\n", "bad.obj:1: `zero` is no number"),
        (b"v 0 0 0\r\nvt a\r\n", "bad.obj:2: `a` is no number"),
        (b"v 0 0 0 \\\n0\nf 1/x 1 1\n", "bad.obj:3: `1/x` is no corner"),
        (b"f 1 1 9223372036854775808\n", "bad.obj:1: `9223372036854775808` is no corner"),
        (b"f 1 1 4294967296\n", "bad.obj:1: position index 4294967296 is out of range"),
        (b"f 1 1 0\n", "bad.obj:1: position index 0 is out of range"),
        (b"\x7FELF\x02\x01\x01\0\0\0", "bad.obj:1: "),
        (b"\xFF\xD8\xFF\xE0 jpeg", "bad.obj:1: "),
        (b"<html>\n", "bad.obj:1: `<html>` begins no OBJ statement"),
        (b"ply\nformat ascii 1.0\nend_header\n0 0 0\n", "bad.obj:4: `0` begins no OBJ statement"),
    ] {
        folder.write("bad.obj", bytes);
        folder.bad("render bad.obj -o out.png --aov id=id.npy --stats s.json", wanted);
        folder.bad("info bad.obj", wanted);
    }
    for (name, wanted) in [
        ("gone.obj", "gone.obj: cannot read it: "),
        (".", ".: this is a folder"),
        ("t.poly", "t.poly: models of this kind cannot be read"),
        ("no/such/folder/m.obj", "cannot read it"),
    ] {
        folder.bad(&format!("render {name} -o out.png"), wanted);
        folder.bad(&format!("info {name}"), wanted);
    }
    folder.write("bad.obj", TRIANGLE.as_bytes());
    for end in 0..TRIANGLE.len() - 2 {
        folder.write("cut.obj", &TRIANGLE.as_bytes()[..end]);
        folder.bad("render cut.obj -o out.png", "cut.obj");
    }
}

#[test]
fn bad_materials_and_textures_are_named_with_their_line() {
    let model =
        format!("mtllib m.mtl\nusemtl a\nvt 0 0\n{}", TRIANGLE.replace("1 2 3", "1/1 2/1 3/1"));
    let folder = Folder::with(&[("m.obj", &model), ("text.png", "hello")]);
    for (text, wanted) in [
        ("newmtl a\nKd red green blue\n", "m.mtl:2: `red` is no number"),
        ("newmtl a\nKd 1 1\n", "m.mtl:2: Kd with 2 numbers"),
        ("newmtl a\n\nmap_Kd\n", "m.mtl:3: map_Kd names no file"),
        ("newmtl a\nmap_Kd text.png\n", "text.png: cannot use this picture"),
        ("newmtl a\nmap_Kd .\n", "cannot use this picture as a texture: it is no regular file"),
        ("newmtl a\nmap_Kd cut.png\n", "cut.png: cannot use this picture"),
        ("newmtl a\nmap_Kd lie.png\n", "lie.png: cannot use this picture"),
        ("newmtl a\nmap_Kd head.jpg\n", "head.jpg: cannot use this picture"),
        ("newmtl a\nmap_Kd cut.jpg\n", "cut.jpg: cannot use this picture"),
        ("newmtl a\nmap_Kd lie.jpg\n", "it says that it has 32000 x 32000 pixels, and cannot"),
        ("newmtl \0\n", "m.mtl:1: there is a zero byte"),
    ] {
        folder.write_png("whole.png", 64, &[[1, 2, 3, 4]; 64 * 64]);
        let whole = folder.read("whole.png");
        folder.write("cut.png", &whole[..whole.len() - 20]);
        // Its header says 2^31 - 1 pixels a side, and the checksum agrees.
        let mut lie = whole[..33].to_vec();
        lie[16..24].copy_from_slice(&[0x7F, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF]);
        let checksum = crc32(&lie[12..29]).to_be_bytes();
        lie[29..33].copy_from_slice(&checksum);
        lie.extend_from_slice(&whole[33..]);
        folder.write("lie.png", &lie);
        folder.write("head.jpg", b"\xFF\xD8\xFF\xE0\0\x10JFIF\0\x01");
        let picture = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * y) as u8; 3]));
        picture.save(folder.path("whole.jpg")).expect("room for a small file");
        let whole = folder.read("whole.jpg");
        folder.write("cut.jpg", &whole[..whole.len() / 2]);
        // A fuzzer's: the decoder makes up what is missing, and that was 4 GB of a small file.
        let mut lie = whole.clone();
        let frame = lie.windows(2).position(|pair| pair == [0xFF, 0xC0]).expect("a frame");
        lie[frame + 5..frame + 9].copy_from_slice(&[0x7D, 0, 0x7D, 0]);
        folder.write("lie.jpg", &lie);
        folder.write("m.mtl", text.as_bytes());
        folder.bad("render m.obj -o out.png", wanted);
    }
}

#[test]
fn bad_textures_are_those_beyond_the_limit() {
    let model =
        format!("mtllib m.mtl\nusemtl a\nvt 0 0\n{}", TRIANGLE.replace("1 2 3", "1/1 2/1 3/1"));
    let folder = Folder::with(&[("m.obj", &model)]);
    folder.write_png("large.png", 1024, &vec![[1, 2, 3, 4]; 1024 * 1024]);
    folder.write("m.mtl", b"newmtl a\nmap_Kd large.png\n");
    let wanted = "large.png: cannot use this picture as a texture: it takes 4 MiB; --texture-limit";
    folder.bad("render m.obj -o out.png --texture-limit 3", wanted);
    assert_eq!(folder.run("render m.obj -o out.png --texture-limit 4").code, Some(0));
}

/// PNG's checksum, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 }
        })
    })
}

#[test]
fn bad_cameras_are_named() {
    let folder = small();
    for (text, wanted) in [
        ("", "bad.json:1: this is no JSON"),
        ("{\n\"eye\": [0, 0,\n", "bad.json:"),
        ("[1]", "bad.json: a camera is a JSON object"),
        (r#"{"eye": [1, 2]}"#, "bad.json: `eye` must be three numbers"),
        (r#"{"eye": "here"}"#, "bad.json: `eye` must be three numbers"),
        (r#"{"fov_y_degrees": "wide"}"#, "bad.json: `fov_y_degrees` must be a number"),
        (r#"{"fov_y_degrees": 180}"#, "between 0 and 180 degrees"),
        (r#"{"far": "far"}"#, "bad.json: `far` must be a number or \"inf\""),
        (r#"{"width": 10}"#, "bad.json: give both `width` and `height`"),
        (r#"{"width": 0, "height": 10}"#, "bad.json: 0 x 10 pixels cannot be drawn"),
        (r#"{"width": 10.5, "height": 10}"#, "bad.json: `width` must be a whole number"),
        (r#"{"width": 99999, "height": 10}"#, "bad.json: 99999 x 10 pixels cannot be drawn"),
        (r#"{"eye": [0, 0, 0], "target": [0, 0, 0]}"#, "eye and target must be different"),
        (r#"{"eye": [0, 5, 0], "target": [0, 0, 0]}"#, "up must not point along the view"),
        (r#"{"near": 5, "far": 2}"#, "0 < near < far"),
        (r#"{"near": 0}"#, "0 < near < far"),
        (r#"{"eye": [0, 0, 1e999]}"#, "bad.json:1: this is no JSON"),
    ] {
        folder.write("bad.json", text.as_bytes());
        folder.bad("render m.obj --camera bad.json -o out.png", wanted);
    }
    folder.bad("render m.obj --camera gone.json -o out.png", "gone.json: cannot read it");
    folder.write("odd.json", br#"{"fov": 40}"#);
    let run = folder.run("render m.obj --camera odd.json --size 8x8 -o out.png");
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.starts_with("warning: odd.json: `fov` is not known"), "{}", run.stderr);
}

#[test]
fn bad_polygons_are_named_with_their_line() {
    let folder = small();
    for (text, wanted) in [
        ("", "bad.poly: there is no polygon"),
        ("# nothing\n", "bad.poly: there is no polygon"),
        ("0 0 0\n", "bad.poly:1: a vertex of 3 numbers"),
        (
            "0 0 0 1\n\n0 0 0 1 2\n",
            "bad.poly:3: this vertex has 1 attributes, but the first one has 0",
        ),
        (
            "attrs flat flat\n0 0 0 1 2\n",
            "bad.poly:2: this vertex has 1 attributes, but `attrs` (line 1)",
        ),
        ("attrs linear\n", "bad.poly:1: `linear` is no way"),
        ("zrange 1 0\n", "bad.poly:1: zrange must be"),
        ("0 0 0 1\nattrs\n", "bad.poly:2: `attrs` must stand before"),
        ("0 0 one 1\n", "bad.poly:1: `one` is no number"),
        ("\u{1}\0", "bad.poly:1: there is a zero byte"),
    ] {
        folder.write("bad.poly", text.as_bytes());
        folder.bad("tile bad.poly --size 8x8 -o out.png --aov attr=a.npy", wanted);
    }
    folder.bad("tile gone.poly -o out.png", "gone.poly: cannot open it");
    folder.bad("tile . -o out.png", ".: this is a folder");
}

#[test]
fn bad_usage_says_what_to_do() {
    let folder = small();
    for (flags, wanted) in [
        ("", "nothing is asked for: add -o OUT.png"),
        ("-o out.jpg", "ends in .png"),
        ("-o out.png --size 0x0", "0 x 0 pixels cannot be drawn"),
        ("-o out.png --size 16385x1", "each side must be 1 to 16384"),
        ("-o out.png --size 12", "WIDTHxHEIGHT"),
        ("-o out.png --size -1x5", "--size"),
        ("-o out.png --size 8x8 --crop 1,1,8,1", "the crop 1,1,8,1 sticks out"),
        ("-o out.png --size 8x8 --crop 4294967295,0,1,1", "sticks out"),
        ("-o out.png --size 8x8 --crop 0,0,0,1", "at least one pixel"),
        ("-o out.png --background 1,2", "R,G,B"),
        ("-o out.png --background 1,2,256", "0 to 255"),
        ("-o out.png --threads 9999", "whole number"),
        ("-o out.png --threads many", "whole number"),
        ("-o out.png --repeat 0", "--repeat"),
        ("-o out.png --precision double", "--precision"),
        ("-o out.png --simd mmx", "choose one of auto, scalar, sse2"),
        ("-o out.png --no-such-flag", "--no-such-flag"),
        ("-o - --stats -", "cannot both go to standard output"),
        ("--aov id", "NAME=FILE"),
        ("--aov color=a.exr", ".npy (exact values) or .png"),
        ("--aov beauty=a.npy", "there is no `beauty` here; choose one of depth, w, id, overdraw"),
        ("-o a.png --aov id=a.png", "a.png: two results go there"),
        ("--aov id=./a.npy --aov w=dir.png/../a.npy", "a.npy: two results go there"),
        ("-o no/such/out.png", "no/such: cannot write into it"),
        ("--aov id=m.obj/a.npy", "m.obj: cannot write into it: it is no folder"),
        ("-o dir.png", "dir.png: cannot write it: it is a folder"),
    ] {
        std::fs::create_dir_all(folder.path("dir.png")).expect("a folder");
        folder.bad(&format!("render m.obj {flags}"), wanted);
        folder.bad(&format!("tile t.poly {flags}"), wanted);
    }
    for (arguments, wanted) in [
        ("render m.obj --aov attr=a.npy", "choose one of depth, w, id, overdraw, uv"),
        ("tile t.poly --aov uv=a.npy", "choose one of depth, w, id, overdraw, color, attr"),
        ("tile t.poly --cull back -o out.png", "--cull"),
        ("render m.obj --depth none -o out.png", "--depth"),
        ("render m.obj --shade phong -o out.png", "--shade"),
        ("render m.obj --filter bilinear -o out.png", "--filter"),
        ("render m.obj --ssaa 2 -o out.png", "--ssaa"),
        ("render m.obj --eye 1,2 -o out.png", "three finite numbers"),
        ("render m.obj --eye nan,0,0 -o out.png", "three finite numbers"),
        ("render m.obj --fov-y 0 -o out.png", "between 0 and 180"),
        ("render m.obj --fov-y nan -o out.png", "between 0 and 180"),
        ("render m.obj --near 0 -o out.png", "0 < near < far"),
        ("render m.obj --near -1 -o out.png", "0 < near < far"),
        ("render m.obj --ortho 0 -o out.png", "--ortho"),
        ("render m.obj --ortho inf -o out.png", "--ortho"),
        ("render m.obj --ortho 2 --far inf -o out.png", "both finite"),
        ("render m.obj --ortho 2 --fov-y 40 -o out.png", "cannot be used with"),
        ("render m.obj --intrinsics 0,1,2,3 -o out.png", "FX,FY,CX,CY"),
        ("render -o out.png", "required"),
        ("draw", "draw"),
        ("bench --search 3", "--stress"),
        ("bench --stress --search -1", "seconds"),
        ("bench --stress --svg chart.svg", "cannot be used with"),
        ("bench --json - --md -", "standard output"),
    ] {
        folder.bad(arguments, wanted);
    }
    // Without any argument there is help, which is no success.
    assert_eq!(folder.run("").code, Some(2));
    for arguments in ["--help", "render --help", "tile --help", "info --help", "--version"] {
        assert!(!folder.good(arguments).is_empty());
    }
}

#[test]
fn targets_too_large_for_memory_are_refused() {
    let folder = small();
    let values = " 1".repeat(10_000);
    folder.write("wide.poly", format!("0 0 0 1{values}\n").as_bytes());
    folder.bad(
        "tile wide.poly --size 16384x16384 --aov attr=a.npy",
        "more than this machine has free: choose a smaller --size",
    );
}

#[test]
fn results_are_written_all_or_none() {
    let folder = small();
    // The second of two results cannot be written: the first one is not left behind, and what
    // was there before still is.
    folder.write("out.png", b"old");
    folder.bad("render m.obj --size 8x8 -o out.png --aov id=no/such.npy", "cannot write into it");
    assert_eq!(folder.read("out.png"), b"old");
    folder.good("render m.obj --size 8x8 -o out.png");
    assert_ne!(folder.read("out.png"), b"old");
}

#[cfg(unix)]
#[test]
fn results_reach_devices_and_links() {
    use std::os::unix::fs::symlink;

    let folder = small();
    if std::path::Path::new("/dev/full").exists() {
        folder.bad(
            "render m.obj --size 8x8 --aov id=id.npy --stats /dev/full",
            "/dev/full: cannot write",
        );
        symlink("/dev/full", folder.path("full.png")).expect("a link");
        folder.bad("render m.obj --size 8x8 --aov id=id.npy -o full.png", "full.png: cannot write");
    }
    if std::path::Path::new("/proc/self").exists() {
        folder.bad("render m.obj --size 8x8 -o /proc/out.png", "cannot write");
    }
    folder.write("real/out.png", b"old");
    symlink("real/out.png", folder.path("link.png")).expect("a link");
    folder.good("render m.obj --size 8x8 -o link.png");
    assert!(folder.path("link.png").is_symlink());
    assert_eq!(folder.png("real/out.png").dimensions(), (8, 8));
}

#[test]
fn a_closed_pipe_is_an_error() {
    let folder = small();
    for arguments in ["render m.obj --size 900x900 --background 1,2,3 -o -", "info m.obj"] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = folder.command(arguments).stdout(writer).output().expect("the program starts");
        let message = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.starts_with("error: cannot write to standard output"), "{message}");
    }
}

/// Numbers that look random and are the same every time (Steele and others, SplitMix64).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// `text` with some of its bytes, or some of its words, replaced.
fn spoil(text: &[u8], state: &mut u64) -> Vec<u8> {
    const WORDS: [&str; 12] =
        ["-1", "0", "1e39", "NaN", "-inf", "/", "99999999999", "f", "v", "\\\n", "1e-320", "#"];
    let mut bytes = text.to_vec();
    for _ in 0..1 + random(state) % 4 {
        let at = (random(state) % (bytes.len() as u64 + 1)) as usize;
        let word = WORDS[(random(state) % 12) as usize].as_bytes();
        let end = bytes.len();
        match random(state) % 4 {
            0 => bytes.truncate(at),
            1 => bytes.splice(at..(at + 1).min(end), [random(state) as u8]).for_each(drop),
            2 => bytes.splice(at..(at + 2).min(end), word.iter().copied()).for_each(drop),
            _ => bytes.splice(at..at, [b" ", word, b" "].concat()).for_each(drop),
        }
    }
    bytes
}

#[test]
fn spoilt_files_never_break_the_program() {
    let model = "mtllib m.mtl\nusemtl a\nv -1 -1 0 1 0 0\nv 1 -1 0 0 1 0\nv 1 1 .5 0 0 1\nv -1 1 0 1 1 1\n\
        v 0 0 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf 1 2 3 4 5\nf 1/1 2/2 3/3\n";
    let material = "newmtl a\nKd 1 .5 0\nmap_Kd t.png\n";
    let camera = r#"{"eye": [0, 1, 5], "target": [0, 0, 0], "near": 0.1, "far": "inf", "width": 9, "height": 7}"#;
    let polygons = "attrs perspective noperspective\nzrange 0 1\n-1 -1 .5 1 0 1\n1 -1 .5 1 1 2\n0 1 .5 2 2 3\n\n0 0 0 1 1 1\n";
    let folder = Folder::new();
    folder.write_png("t.png", 2, &[[9; 4]; 4]);
    let picture = folder.read("t.png");
    let sources: [(&str, &[u8]); 5] = [
        ("m.obj", model.as_bytes()),
        ("m.mtl", material.as_bytes()),
        ("c.json", camera.as_bytes()),
        ("t.png", &picture),
        ("t.poly", polygons.as_bytes()),
    ];
    let mut state = 1;
    for round in 0..200 {
        for (name, bytes) in sources {
            folder.write(name, bytes);
        }
        let (name, bytes) = sources[round % sources.len()];
        let spoilt = spoil(bytes, &mut state);
        folder.write(name, &spoilt);
        let arguments = if name == "t.poly" {
            "tile t.poly --size 9x7 -o out.png --aov attr=a.npy"
        } else {
            "render m.obj --camera c.json --size 9x7 -o out.png --aov normal=a.npy"
        };
        let run = folder.run(arguments);
        let wrote =
            ["out.png", "a.npy"].map(|name| std::fs::remove_file(folder.path(name)).is_ok());
        let fine = match run.code {
            Some(0) => wrote == [true; 2],
            Some(2) => wrote == [false; 2] && run.stderr.contains("error: "),
            _ => false,
        };
        assert!(fine, "round {round}, {name}: {run:?}\n{}", String::from_utf8_lossy(&spoilt));
    }
}
