//! The same case through `hyperspan tile`: its data are those of the library.

use crate::case::{Case, Drawn};
use crate::harness::Folder;
use crate::oracle::Poly;

/// As `.poly` text; numbers are those of `f32`.
pub(crate) fn text(polygons: &[Poly], gl: bool) -> String {
    let line = |poly: &Poly, i: usize| {
        let position = poly.positions[i].iter().map(|c| format!("{:e} ", *c as f32));
        let values = poly.attributes[i].iter().map(|value| format!(" {value:e}"));
        position.chain(values).collect::<String>() + "\n"
    };
    let polygon =
        |poly: &Poly| (0..poly.positions.len()).map(|i| line(poly, i)).collect::<String>() + "\n";
    let range = if gl { "zrange -1 1\n" } else { "" };
    range.to_owned() + &polygons.iter().map(polygon).collect::<String>()
}

/// Draws `case` and compares with what the library drew.
pub(crate) fn check(case: &Case, right: &Drawn) {
    let Case { name, size: [width, height], crop, polygons, .. } = case;
    let folder = Folder::with(&[("case.poly", &text(polygons, case.gl))]);
    let crop = format!("{},{},{},{}", crop.x0, crop.y0, crop.x1 - crop.x0, crop.y1 - crop.y0);
    let run = folder.run(&format!(
        "tile case.poly --size {width}x{height} --crop {crop} --precision exact --threads 2 \
         --aov overdraw=overdraw.npy --aov id=id.npy --aov depth=depth.npy --aov w=w.npy \
         --aov attr=attr.npy"
    ));
    if polygons.is_empty() {
        assert_eq!(run.code, Some(2), "{name}: a file without a polygon is an error");
        return;
    }
    assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
    let words = |file: &str| folder.npy(file).words;
    assert_eq!(words("overdraw.npy"), right.overdraw, "{name}");
    assert_eq!(words("id.npy"), right.ids, "{name}");
    assert_eq!(words("depth.npy"), right.depth, "{name}");
    assert_eq!(words("w.npy"), right.w, "{name}");
    assert_eq!(words("attr.npy"), right.attributes.concat(), "{name}");
}
