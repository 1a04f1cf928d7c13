//! `compare`: 0 the same, 1 different, 2 not to be compared.

use crate::harness::Folder;

/// A `.npy` file of `<f4`, or of whatever `kind` says.
fn npy(kind: &str, shape: &str, bytes: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).expect("short").to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), bytes].concat()
}

fn floats(values: &[f32]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    npy("<f4", &format!("({}, 2)", values.len() / 2), &bytes)
}

#[test]
fn compare_pictures() {
    let folder = Folder::new();
    folder.write_png("a.png", 2, &[[1, 2, 3, 4], [5, 6, 7, 8], [9; 4], [0; 4]]);
    folder.write_png("b.png", 2, &[[1, 2, 3, 4], [5, 6, 10, 8], [9; 4], [1, 0, 0, 0]]);
    folder.write_png("c.png", 1, &[[1, 2, 3, 4], [5, 6, 7, 8]]);
    folder.good("compare a.png a.png");
    folder.good("compare a.png b.png --tolerance 3");
    let run = folder.run("compare a.png b.png --tolerance 1 --diff diff.png");
    assert_eq!(run.code, Some(1));
    assert_eq!(
        run.stderr,
        "a.png and b.png differ at 1 of 4 pixels, first at row 0, column 1, most by 3\n"
    );
    let diff = folder.png("diff.png");
    assert_eq!(diff.get_pixel(1, 0).0, [255; 4]);
    assert_eq!(diff.get_pixel(1, 1).0, [0, 0, 0, 255], "within the tolerance");
    let run = folder.run("compare a.png c.png --diff no.png");
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("differ in shape: [2, 2, 4] and [2, 1, 4]"), "{}", run.stderr);
    assert!(!folder.path("no.png").exists());
}

#[test]
fn compare_arrays() {
    let folder = Folder::new();
    let nan = f32::NAN;
    folder.write("a.npy", &floats(&[1.0, nan, f32::INFINITY, 0.0]));
    folder.write("b.npy", &floats(&[1.25, nan, f32::INFINITY, 0.0]));
    folder.write("c.npy", &floats(&[1.0, nan, nan, 0.0]));
    folder.write("d.npy", &floats(&[1.0, nan]));
    folder.write("e.npy", &npy("<f8", "(1, 2)", &[0; 16]));
    folder.write("f.npy", &npy("|u1", "(1,2)", &[0; 2]));
    folder.write("g.npy", &npy("<u4", "(3,)", &[0; 12]));
    folder.good("compare a.npy a.npy");
    folder.good("compare a.npy b.npy --tolerance .25");
    folder.good("compare e.npy f.npy");
    folder.good("compare g.npy g.npy --diff diff.png");
    for (pair, code) in [("a b", 1), ("a c", 1), ("a d", 1), ("a g", 1)] {
        let (a, b) = pair.split_once(' ').expect("two");
        let run = folder.run(&format!("compare {a}.npy {b}.npy"));
        assert_eq!(run.code, Some(code), "{pair}: {}", run.stderr);
        assert!(!run.stderr.is_empty());
    }
    assert_eq!(folder.run("compare a.npy c.npy --tolerance 1e30").code, Some(1));
}

#[test]
fn compare_what_the_program_wrote() {
    let folder = Folder::with(&[("t.poly", "-1 -1 .5 1 0\n3 -1 .5 1 1\n-1 3 .5 1 1\n")]);
    folder.good("tile t.poly --size 9x9 -o a.png --aov attr=a.npy --aov id=id.npy");
    folder.good("tile t.poly --size 9x9 -o b.png --aov attr=b.npy --simd scalar --threads 1");
    folder.good("compare a.png b.png");
    folder.good("compare a.npy b.npy");
    folder.good("compare id.npy id.npy --diff same.png");
}

#[test]
fn compare_refuses_what_it_cannot_read() {
    let folder = Folder::with(&[("text.png", "hello"), ("cut.npy", "\u{FFFD}NUM")]);
    folder.write_png("a.png", 1, &[[0; 4]]);
    folder.write("a.npy", &floats(&[0.0; 4]));
    let whole = folder.read("a.png");
    folder.write("cut.png", &whole[..whole.len() / 2]);
    let whole = folder.read("a.npy");
    folder.write("short.npy", &whole[..whole.len() - 1]);
    folder.write("long.npy", &[whole, vec![0]].concat());
    folder.write("text.npy", &npy("<U5", "(1, 1)", &[0; 20]));
    folder.write("huge.npy", &npy("<f4", "(4294967296, 4294967296, 2)", &[]));
    for (pair, wanted) in [
        ("a.png a.npy", "a.png is a picture, but a.npy is an array"),
        ("a.png gone.png", "gone.png: cannot read it"),
        ("a.png text.png", "text.png: this is neither PNG nor .npy"),
        ("a.png cut.png", "cut.png: cannot read this PNG"),
        ("a.npy cut.npy", "cut.npy: this is neither"),
        ("a.npy short.npy", "short.npy: cannot read this .npy"),
        ("a.npy long.npy", "long.npy: cannot read this .npy"),
        ("a.npy text.npy", "text.npy: cannot read this .npy"),
        ("a.npy huge.npy", "huge.npy: cannot read this .npy"),
        ("a.npy a.npy --tolerance -1", "--tolerance"),
        ("a.npy a.npy --tolerance nan", "--tolerance"),
        ("a.npy a.npy --diff out.jpg", "--diff"),
        ("a.npy a.npy --diff no/such/out.png", "no/such: cannot write into it"),
        ("a.npy", "required"),
    ] {
        folder.bad(&format!("compare {pair}"), wanted);
    }
}
