//! The chart: run time across, greatest error up, both logarithmic; a panel for each w ratio.
//!
//! Colours are mid-tones on nothing, and change where the reader prefers a dark page.

use std::fmt::Write;

use super::labels::{Area, along, labels};
use super::measure::Variant;
use super::report::{Case, Report, Summary, power};

/// A panel's sides, and the space for its numbers and its title.
const PANEL: [f64; 2] = [450.0, 390.0];
const MARGIN: [f64; 2] = [62.0, 54.0];
const COLUMNS: usize = 2;
/// Powers of ten above the greatest error that are left to labels.
const HEADROOM: f64 = 2.0;

const STYLE: &str = "\
text{font:12px ui-sans-serif,system-ui,sans-serif;fill:#57606a}\
.title{font-size:14px;font-weight:600}\
.ours{font-weight:700}\
.grid{stroke:#8c959f;stroke-opacity:.3;stroke-width:1;fill:none}\
.front{stroke:#2f81f7;stroke-width:1.5;stroke-dasharray:5 4;fill:none}\
.mean{stroke:#8c959f;stroke-opacity:.75;stroke-width:1.2}\
.lead{stroke:#8c959f;stroke-opacity:.8;stroke-width:.8}\
.dot{fill:#8c6d1f}.product{fill:#2f81f7}\
@media(prefers-color-scheme:dark){text{fill:#b1bac4}.dot{fill:#d4a72c}}";

/// One picture: all scenes of the first kind that attributes were measured for.
pub(crate) fn svg(report: &Report) -> String {
    let kinds = report.kinds();
    let is_charted = |kind: &&Case| {
        kind.width == report.width && kind.attributes == 2 && kind.variant == Variant::Attributes
    };
    let panels: Vec<(f64, Vec<Summary>)> =
        kinds.iter().filter(is_charted).map(|kind| (kind.w_ratio, report.summary(kind))).collect();
    let columns = COLUMNS.min(panels.len().max(1));
    let rows = panels.len().div_ceil(COLUMNS).max(1);
    let cell = [PANEL[0] + MARGIN[0] + 24.0, PANEL[1] + MARGIN[1] + 44.0];
    let [width, height] = [cell[0] * columns as f64, cell[1] * rows as f64 + 70.0];
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\" role=\"img\">\n\
         <title>Run time against error</title>\n<style>{STYLE}</style>"
    );
    let lines: Vec<&Summary> = panels.iter().flat_map(|(_, lines)| lines).collect();
    let axes = Axes::around(&lines);
    for (i, (w_ratio, lines)) in panels.iter().enumerate() {
        let corner = [
            cell[0] * (i % COLUMNS) as f64 + MARGIN[0],
            cell[1] * (i / COLUMNS) as f64 + MARGIN[1],
        ];
        let _ = writeln!(out, "<g transform=\"translate({:.0} {:.0})\">", corner[0], corner[1]);
        panel(&mut out, &axes, *w_ratio, lines);
        out.push_str("</g>\n");
    }
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{}\">Dots: the greatest error in any scene; lines go down to the mean. \
         Dashed: the Pareto front. Blue: hyperspan.</text>\n\
         <text x=\"{x}\" y=\"{}\">Time: one thread, {}, two attributes, {} pixels wide; set-up and \
         spans included. Geometric mean of the scenes</text>\n\
         <text x=\"{x}\" y=\"{}\">{}.</text>\n</svg>",
        height - 48.0,
        height - 30.0,
        report.simd,
        report.width,
        height - 12.0,
        scenes(report),
        x = MARGIN[0],
    );
    out
}

/// Which scenes the chart is of.
fn scenes(report: &Report) -> String {
    let mut names: Vec<&str> = report.rows.iter().map(|row| row.case.scene.name()).collect();
    names.dedup();
    names.sort_unstable();
    names.dedup();
    names.join(", ")
}

/// What is shown, as logarithms to base 10: time across, error up.
struct Axes {
    least: [f64; 2],
    most: [f64; 2],
}

impl Axes {
    /// All of `lines`, with some space.
    fn around(lines: &[&Summary]) -> Self {
        let mut axes = Self { least: [f64::INFINITY; 2], most: [f64::NEG_INFINITY; 2] };
        for line in lines {
            for (time, error) in [(line.ns, line.max_ulp), (line.ns, line.mean_ulp)] {
                for (i, log) in [libm::log10(time), error_log(error)].into_iter().enumerate() {
                    axes.least[i] = axes.least[i].min(log);
                    axes.most[i] = axes.most[i].max(log);
                }
            }
        }
        if lines.is_empty() {
            return Self { least: [0.0; 2], most: [1.0; 2] };
        }
        Self {
            least: [axes.least[0] - 0.08, axes.least[1].floor()],
            // Labels stand to the right of their dots, or above them.
            most: [axes.most[0] + 0.15, axes.most[1].ceil() + HEADROOM],
        }
    }

    /// Where a time and an error are in the panel, in pixels.
    fn place(&self, time: f64, error: f64) -> [f64; 2] {
        let part = |i: usize, log: f64| (log - self.least[i]) / (self.most[i] - self.least[i]);
        [PANEL[0] * part(0, libm::log10(time)), PANEL[1] * (1.0 - part(1, error_log(error)))]
    }
}

/// Errors below a hundredth of an ulp are drawn there.
fn error_log(error: f64) -> f64 {
    libm::log10(error.clamp(0.01, 1e12))
}

fn panel(out: &mut String, axes: &Axes, w_ratio: f64, lines: &[Summary]) {
    grid(out, axes);
    let _ = writeln!(
        out,
        "<text class=\"title\" x=\"0\" y=\"-14\">w ratio {}</text>",
        with_superscript(&power(w_ratio))
    );
    let mut front: Vec<[f64; 2]> = lines
        .iter()
        .filter(|line| line.pareto)
        .map(|line| axes.place(line.ns, line.max_ulp))
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let points: Vec<String> = front.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(out, "<polyline class=\"front\" points=\"{}\"/>", points.join(" "));
    let mut taken: Vec<Area> = front.windows(2).flat_map(|ends| along(ends[0], ends[1])).collect();
    let mut dots = Vec::new();
    for line in lines {
        let [x, y] = axes.place(line.ns, line.max_ulp);
        let [_, mean] = axes.place(line.ns, line.mean_ulp);
        let _ = writeln!(out, "<path class=\"mean\" d=\"M{x:.1} {y:.1}V{mean:.1}m-3 0h6\"/>");
        taken.push(Area { low: [x - 4.0, y], high: [x + 4.0, mean] });
        dots.push(([x, y], line.rung.name()));
    }
    let labels = labels(&dots, taken, PANEL);
    for (([x, y], name), label) in dots.iter().zip(labels) {
        let ours = matches!(*name, "fast" | "exact");
        let (dot, text) = if ours { ("product", " class=\"ours\"") } else { ("dot", "") };
        if let Some([pole_x, pole_y]) = label.pole {
            let _ = writeln!(
                out,
                "<path class=\"lead\" d=\"M{x:.1} {y:.1}L{pole_x:.1} {pole_y:.1}\"/>"
            );
        }
        let [text_x, text_y] = [label.area.low[0], label.area.high[1] - 3.0];
        let _ = writeln!(
            out,
            "<circle class=\"{dot}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>\
             <text{text} x=\"{text_x:.1}\" y=\"{text_y:.1}\">{name}</text>"
        );
    }
}

/// Lines at powers of ten of the error, and at 1, 2, 5 and so on of the time.
fn grid(out: &mut String, axes: &Axes) {
    let [width, height] = PANEL;
    let _ = writeln!(out, "<path class=\"grid\" d=\"M0 0V{height}H{width}\"/>");
    for exponent in axes.least[1] as i32..=(axes.most[1] - HEADROOM) as i32 {
        let error = libm::pow(10.0, f64::from(exponent));
        let [_, y] = axes.place(1.0, error);
        let _ = writeln!(
            out,
            "<path class=\"grid\" d=\"M0 {y:.1}H{width}\"/>\
             <text x=\"-8\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            y + 4.0,
            match exponent {
                -2 => "0.01".to_owned(),
                -1 => "0.1".to_owned(),
                0 => "1".to_owned(),
                1 => "10".to_owned(),
                _ => with_superscript(&format!("10^{exponent}")),
            }
        );
    }
    for exponent in -3..4 {
        for digit in [1.0, 2.0, 5.0] {
            let time = digit * libm::pow(10.0, f64::from(exponent));
            let [x, _] = axes.place(time, 1.0);
            if (0.0..=width).contains(&x) {
                let _ = writeln!(
                    out,
                    "<path class=\"grid\" d=\"M{x:.1} 0V{height}\"/>\
                     <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{time}</text>",
                    height + 16.0
                );
            }
        }
    }
    let _ = writeln!(
        out,
        "<text x=\"{width}\" y=\"{:.1}\" text-anchor=\"end\">ns per pixel</text>\
         <text x=\"{width}\" y=\"-14\" text-anchor=\"end\">error in ulp</text>",
        height + 32.0
    );
}

/// 10^4 with a raised 4.
fn with_superscript(number: &str) -> String {
    let digit = |c: char| match c {
        '-' => '\u{207B}',
        '1' => '\u{B9}',
        '2' => '\u{B2}',
        '3' => '\u{B3}',
        digit => {
            let value = digit.to_digit(10).unwrap_or(0);
            char::from_u32(0x2070 + value).unwrap_or(digit)
        }
    };
    match number.split_once('^') {
        Some((base, exponent)) => base.chars().chain(exponent.chars().map(digit)).collect(),
        None => number.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn superscripts() {
        assert_eq!(with_superscript("10^4"), "10\u{2074}");
        assert_eq!(with_superscript("100"), "100");
    }
}
