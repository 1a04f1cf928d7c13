//! `hyperspan bench`: what it promises of the rungs, and the files that it writes. Times are not
//! judged.

use crate::harness::Folder;
use serde_json::Value;

/// The rows of a quick run with these flags.
fn rows(folder: &Folder, flags: &str) -> Vec<Value> {
    folder.good(&format!("bench --quick --width 256 --json rows.json {flags}"));
    let rows = folder.json("rows.json")["rows"].as_array().expect("an array").clone();
    assert!(!rows.is_empty());
    rows
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {row}"))
}

#[test]
fn bench_rows_have_all_keys_and_no_rung_is_missing() {
    let folder = Folder::new();
    let rows = rows(&folder, "--scene walls --w-ratio 100");
    let rungs: Vec<&str> = rows.iter().filter_map(|row| row["rung"].as_str()).collect();
    #[rustfmt::skip]
    assert_eq!(rungs, [
        "affine-polygon", "affine-span", "affine-32", "affine-16", "affine-8", "quadratic-16",
        "estimate", "newton", "fast", "exact", "inverse",
    ]);
    for row in &rows {
        assert_eq!((row["scene"].as_str(), row["w_ratio"].as_f64()), (Some("walls"), Some(100.0)));
        assert!(row["pareto"].is_boolean());
        for key in ["ns_per_pixel", "yardstick_ns", "fill_ns", "p999_ulp", "mean_ulp", "max_ulp"] {
            assert!(number(row, key) > 0.0, "{key}: {row}");
        }
        for key in ["max_texels", "mean_texels", "wrong_texels_percent"] {
            assert!(number(row, key) >= 0.0);
        }
        assert!(number(row, "mean_ulp") <= number(row, "max_ulp"));
        assert!(number(row, "values") > 1000.0 && number(row, "doubtful_values") == 0.0);
        let promised = matches!(row["rung"].as_str(), Some("fast" | "exact"));
        assert_eq!(row["worst_over_bound"].is_number(), promised, "{row}");
    }
    assert!(rows.iter().any(|row| row["pareto"] == true));
}

#[test]
fn bench_finds_the_product_within_its_bounds() {
    let folder = Folder::new();
    let rows = rows(&folder, "--rung fast --rung exact");
    assert_eq!(rows.len(), 2 * 4 * 7, "both rungs, four w ratios, seven scenes");
    for row in rows {
        let worst = number(&row, "worst_over_bound");
        assert!(worst > 0.0 && worst <= 1.0, "{row}");
        if row["rung"] == "exact" {
            assert!(number(&row, "max_ulp") <= 0.5, "{row}");
        }
    }
}

/// Half of a wall: u is affine in w, and 1/w is affine in the picture. The chord of 1/q over q in
/// a..b is at most (1/sqrt(a) - 1/sqrt(b))^2 off.
#[test]
fn bench_finds_affine_rungs_as_far_off_as_theory_says() {
    let folder = Folder::new();
    let flags =
        "--scene walls --rung affine-span --rung affine-32 --rung affine-16 --rung affine-8";
    let flags = format!("{flags} --rung quadratic-16 --rung affine-polygon --rung fast");
    let rows = rows(&folder, &format!("{flags} --w-ratio 1 --w-ratio 100"));
    let ratio: f64 = 100.0;
    // Columns over which w goes from the least to the greatest, and texels that u does meanwhile.
    let (columns, texels) = (0.95 * 256.0 / 2.0, 256.0 * 3.6875);
    for (rung, pixels) in
        [("affine-8", 8.0), ("affine-16", 16.0), ("affine-32", 32.0), ("affine-span", columns)]
    {
        let last = 1.0 / ratio;
        let first = last + (1.0 - last) * pixels / columns;
        let root = 1.0 / last.sqrt() - 1.0 / f64::sqrt(first);
        let most = texels / (ratio - 1.0) * root * root;
        let row = rows.iter().find(|row| row["rung"] == rung && row["w_ratio"] == 100.0);
        let found = number(row.expect("a row"), "max_texels");
        // The last pixels' centres lie before the end, and the last piece is no whole one.
        assert!(found <= most && found > 0.3 * most, "{rung}: {found} of {most} texels");
    }
    let ulp = |rung: &str, w_ratio: f64| {
        let row = rows.iter().find(|row| row["rung"] == rung && row["w_ratio"] == w_ratio);
        number(row.expect("a row"), "max_ulp")
    };
    for rung in
        ["affine-polygon", "affine-span", "affine-32", "affine-16", "affine-8", "quadratic-16"]
    {
        assert!(ulp(rung, 1.0) < 6.0, "{rung} where w is constant: {}", ulp(rung, 1.0));
        assert!(ulp(rung, 100.0) > 1e4 * ulp("fast", 100.0), "{rung}: {}", ulp(rung, 100.0));
    }
}

/// w is constant along the rows of a floor: affine along a span is right there, and only there.
#[test]
fn bench_finds_floors_affine_along_spans() {
    let folder = Folder::new();
    let rows = rows(
        &folder,
        "--scene floor --scene rolled-floor --w-ratio 100 --rung affine-span --rung affine-polygon",
    );
    let ulp = |scene: &str, rung: &str| {
        let row = rows.iter().find(|row| row["scene"] == scene && row["rung"] == rung);
        number(row.expect("a row"), "max_ulp")
    };
    assert!(ulp("floor", "affine-span") < 6.0);
    assert!(ulp("rolled-floor", "affine-span") > 1e4);
    assert!(ulp("floor", "affine-polygon") > 1e4, "not down the polygon");
}

#[test]
fn bench_finds_the_estimate_worse_than_a_step_of_newtons() {
    let folder = Folder::new();
    let flags = "--scene rolled-floor --w-ratio 100 --rung estimate --rung newton --rung inverse";
    let rows = rows(&folder, flags);
    let [estimate, newton, inverse] = [0, 1, 2].map(|i| number(&rows[i], "max_ulp"));
    // The step doubles the estimate's bits: 11 and more on x86, 8 on Arm. Without an instruction
    // for it the estimate is a division.
    let most = if cfg!(target_arch = "aarch64") { 256.0 } else { 6.0 };
    assert!(newton < most && inverse < 0.6, "{newton} {inverse}");
    let estimates = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));
    assert!(estimate > 10.0 * newton.max(1.0) || !estimates, "{estimate} {newton}");
}

#[test]
fn bench_writes_what_is_asked_for() {
    let folder = Folder::new();
    let few =
        "bench --quick --width 256 --scene triangles --w-ratio 100 --rung fast --rung affine-8";
    let tables = String::from_utf8(folder.good(few)).expect("UTF-8");
    assert!(tables.contains("\n## triangles, w ratio 100, 2 attributes, 256 pixels wide\n"));
    assert!(tables.contains("\n| affine-8 | ") && tables.contains("\n| fast | "));
    assert!(folder.list().is_empty(), "nothing but tables on standard output");

    folder.write("heat/kept", b"");
    let out = folder.good(&format!("{few} --md tables.md --svg - --heat heat"));
    let svg = String::from_utf8(out).expect("UTF-8");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{svg}");
    for wanted in ["w ratio 100<", ">fast<", ">affine-8<", "prefers-color-scheme"] {
        assert!(svg.contains(wanted), "no {wanted} in {svg}");
    }
    assert_eq!(folder.list(), ["heat", "tables.md"]);

    let [fast, affine] = ["fast", "affine-8"].map(|rung| {
        let picture = folder.png(&format!("heat/triangles-w100-{rung}.png"));
        assert_eq!(picture.dimensions(), (256, 256));
        let sum = |pixel: &image::Rgba<u8>| pixel.0[..3].iter().map(|c| u32::from(*c)).sum::<u32>();
        picture.pixels().map(sum).max()
    });
    assert!(affine > fast.map(|sum| 2 * sum), "{affine:?} {fast:?}: the brighter the worse");
}

#[test]
fn bench_refuses_what_it_cannot_do() {
    let folder = Folder::new();
    folder.bad("bench --scene nowhere", "rolled-floor");
    folder.bad("bench --rung slow", "quadratic-16");
    folder.bad("bench --w-ratio 0.5", "from 1 to 1000000");
    folder.bad("bench --w-ratio NaN", "from 1 to 1000000");
    folder.bad("bench --width 100", "256..=8192");
    folder.bad("bench --simd mmx", "this machine has auto");
    folder.bad("bench --json - --md -", "only one of");
    folder.bad("bench --svg missing/chart.svg", "missing");
    folder.bad("bench --heat missing", "make it first");
}

/// Two seconds of the soak; tests/promises/soak.rs has each kind of scene, and shows that it would notice.
#[test]
fn bench_soaks_without_a_disagreement() {
    let folder = Folder::new();
    folder.good("bench --soak 2 --threads 2 --json soak.json --md soak.md");
    let soak = folder.json("soak.json");
    assert_eq!((soak["disagreements"].as_u64(), soak["seed"].as_u64()), (Some(0), Some(1)));
    assert_eq!(soak["kinds"].as_array().map(Vec::len), Some(13));
    assert!(number(&soak, "scenes") > 1.0 && number(&soak, "covered") > 1e5, "{soak}");
    for precision in ["fast", "exact"] {
        for quantity in ["depth", "w", "1/w", "attribute"] {
            assert!(number(&soak[precision], quantity) <= 1.0, "{soak}");
        }
    }
    let tables = String::from_utf8(folder.read("soak.md")).expect("UTF-8");
    assert!(tables.contains(" 0 disagreements.") && tables.contains("| clipped net | "));
    // One scene, by its number.
    let out = folder.good("bench --soak 0 --seed 7 --from 5");
    assert!(String::from_utf8(out).expect("UTF-8").contains("\n| all | 1 | "));
    folder.bad("bench --soak never", "give seconds");
    folder.bad("bench --from 5", "--soak");
    folder.bad("bench --soak 1 --stress", "cannot be used with");
}
