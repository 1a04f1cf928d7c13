//! The rows as tables: first what all scenes have in common, then each scene.

use std::fmt::Write;

use super::report::{Case, Report, Row, Summary, power};

/// All tables.
pub(crate) fn markdown(report: &Report) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "# Run time against error\n");
    let _ = writeln!(
        out,
        "ns for each covered pixel: medians of {} interleaved runs on {}; set-up and spans included, \
         clearing not. Errors in ulp of f32 at the right value, and in texels of a 256 x 256 texture; \
         M is the largest magnitude of an attribute at a polygon's vertices, u is 2^-24. Front: no \
         other rung is as fast and has as small a greatest error.\n",
        report.runs, report.simd
    );
    let _ = writeln!(
        out,
        "All scenes: geometric means of times, the greatest of the greatest errors and of the \
         99.9th percentiles, means of the means.\n"
    );
    let kinds = report.kinds();
    for kind in &kinds {
        let _ = writeln!(out, "## All scenes, {}\n", title(kind));
        out.push_str(HEADER);
        for summary in report.summary(kind) {
            out.push_str(&line(&summary));
        }
        out.push('\n');
    }
    let mut last = None;
    for row in &report.rows {
        if last != Some(row.case) {
            last = Some(row.case);
            let Row { case, polygons, pixels, yardstick, fill, .. } = row;
            let _ = writeln!(out, "\n## {}, {}\n", case.scene.name(), title(case));
            let _ = writeln!(
                out,
                "{polygons} polygons, {pixels} pixels; yardstick {yardstick:.3} ns, filling memory \
                 {fill:.3} ns a pixel.\n"
            );
            out.push_str(HEADER);
        }
        out.push_str(&line(&Summary::of(row)));
    }
    out
}

const HEADER: &str = "\
| rung | ns | x yardstick | max ulp | 99.9 % | mean ulp | max / uM | max texels | mean texels | wrong texels % | of the bound | front |
|---|---|---|---|---|---|---|---|---|---|---|---|
";

fn title(case: &Case) -> String {
    let Case { w_ratio, attributes, width, variant, .. } = case;
    let what = match variant.name() {
        "attributes" => format!("{attributes} attributes"),
        other => other.to_owned(),
    };
    format!("w ratio {}, {what}, {width} pixels wide", power(*w_ratio))
}

fn line(summary: &Summary) -> String {
    let [max_texels, mean_texels, wrong] = match summary.texels {
        Some(texels) => texels.map(short),
        None => [const { String::new() }; 3],
    };
    format!(
        "| {} | {:.3} | {:.2} | {} | {} | {} | {} | {max_texels} | {mean_texels} | {wrong} | {} | {} |\n",
        summary.rung.name(),
        summary.ns,
        summary.yardsticks,
        short(summary.max_ulp),
        short(summary.p999_ulp),
        short(summary.mean_ulp),
        short(summary.max_of_magnitude),
        summary.worst_over_bound.map(short).unwrap_or_default(),
        if summary.pareto { "yes" } else { "" },
    )
}

/// Three digits, or a power of ten.
fn short(number: f64) -> String {
    match number {
        0.0 => "0".to_owned(),
        n if !(1e-3..1e5).contains(&n) => format!("{n:.1e}"),
        n if n >= 100.0 => format!("{n:.0}"),
        n if n >= 10.0 => format!("{n:.1}"),
        n if n >= 0.1 => format!("{n:.2}"),
        n => format!("{n:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, 0.5, 0.0312, 4.25, 37.44, 512.6, 4.5e6, 1e-9];
        let wanted = ["0", "0.50", "0.0312", "4.25", "37.4", "513", "4.5e6", "1.0e-9"];
        assert_eq!(numbers.map(short), wanted);
    }
}
