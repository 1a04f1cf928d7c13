//! The chart: run time across, greatest error up, both logarithmic; a panel for each w ratio.
//!
//! Colours are mid-tones on nothing, and change where the reader prefers a dark page.

use std::fmt::Write;

use super::measure::Variant;
use super::report::{Case, Report, Summary, power};

/// A panel's sides, and the space for its numbers and its title.
const PANEL: [f64; 2] = [430.0, 330.0];
const MARGIN: [f64; 2] = [62.0, 54.0];
const COLUMNS: usize = 2;
/// Of a label's letters: width, and height of a line.
const LETTER: [f64; 2] = [6.7, 13.0];

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
    let [width, height] = [cell[0] * columns as f64, cell[1] * rows as f64 + 62.0];
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
        "<text x=\"{x}\" y=\"{first}\">Dots: the greatest error in any scene; a line goes down to \
         the mean error. Dashed: the Pareto front. Blue: hyperspan.</text>\n\
         <text x=\"{x}\" y=\"{second}\">Time: geometric mean of {scenes}, two attributes, {pixels} \
         pixels wide, one thread, {simd}; set-up and spans included.</text>\n</svg>",
        x = MARGIN[0],
        first = height - 36.0,
        second = height - 16.0,
        scenes = scenes(report),
        pixels = report.width,
        simd = report.simd,
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
            // Labels stand to the right of their dots.
            most: [axes.most[0] + 0.12, axes.most[1].ceil().max(axes.least[1].floor() + 1.0)],
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
    let places: Vec<[f64; 2]> =
        lines.iter().map(|line| axes.place(line.ns, line.max_ulp)).collect();
    let names: Vec<&str> = lines.iter().map(|line| line.rung.name()).collect();
    for (line, [x, y]) in lines.iter().zip(&places) {
        let [_, mean] = axes.place(line.ns, line.mean_ulp);
        let _ = writeln!(out, "<path class=\"mean\" d=\"M{x:.1} {y:.1}V{mean:.1}m-3 0h6\"/>");
    }
    for ((line, [x, y]), label) in lines.iter().zip(&places).zip(labels(&places, &names)) {
        let ours = matches!(line.rung.name(), "fast" | "exact");
        let class = if ours { "product" } else { "dot" };
        let _ = writeln!(out, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>");
        if let Some([end_x, end_y]) = label.lead([*x, *y]) {
            let _ =
                writeln!(out, "<path class=\"lead\" d=\"M{x:.1} {y:.1}L{end_x:.1} {end_y:.1}\"/>");
        }
        let weight = if ours { " class=\"ours\"" } else { "" };
        let _ = writeln!(
            out,
            "<text{weight} x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            label.low[0],
            label.high[1] - 3.0,
            line.rung.name()
        );
    }
}

/// Lines at powers of ten of the error, and at 1, 2, 5 and so on of the time.
fn grid(out: &mut String, axes: &Axes) {
    let [width, height] = PANEL;
    let _ = writeln!(out, "<path class=\"grid\" d=\"M0 0V{height}H{width}\"/>");
    for exponent in axes.least[1] as i32..=axes.most[1] as i32 {
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

/// The rectangle that a label takes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Label {
    low: [f64; 2],
    high: [f64; 2],
}

impl Label {
    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }

    /// Where a line from `dot` ends, if the label is too far from it to do without.
    fn lead(&self, dot: [f64; 2]) -> Option<[f64; 2]> {
        const NEAR: f64 = 14.0;
        let end = [0, 1].map(|i: usize| dot[i].clamp(self.low[i], self.high[i]));
        let distance = (end[0] - dot[0]).abs().max((end[1] - dot[1]).abs());
        (distance > NEAR).then_some(end)
    }
}

/// Places for the names of dots: near them, on no other label and on no dot.
fn labels(dots: &[[f64; 2]], names: &[&str]) -> Vec<Label> {
    const DOT: f64 = 6.0;
    let around = |[x, y]: [f64; 2]| Label { low: [x - DOT, y - DOT], high: [x + DOT, y + DOT] };
    let mut taken: Vec<Label> = dots.iter().map(|dot| around(*dot)).collect();
    let mut labels = Vec::new();
    for (dot, name) in dots.iter().zip(names) {
        let size = [LETTER[0] * name.len() as f64, LETTER[1]];
        let free = candidates(*dot, size)
            .find(|label| {
                let inside = (0..2).all(|i| label.low[i] >= 2.0 && label.high[i] <= PANEL[i]);
                inside && !taken.iter().any(|other| label.overlaps(other))
            })
            .unwrap_or_else(|| around(*dot));
        taken.push(free);
        labels.push(free);
    }
    labels
}

/// Rectangles of `size` around `dot`, the nearest first: to the right, to the left, below, above,
/// and between.
fn candidates(dot: [f64; 2], size: [f64; 2]) -> impl Iterator<Item = Label> {
    const DIRECTIONS: [[f64; 2]; 8] = [
        [1.0, 0.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [0.0, -1.0],
        [1.0, 1.0],
        [-1.0, 1.0],
        [1.0, -1.0],
        [-1.0, -1.0],
    ];
    (0..40).flat_map(move |ring| {
        let distance = 9.0 + 7.0 * f64::from(ring);
        DIRECTIONS.into_iter().map(move |direction| {
            let centre = [0, 1].map(|i: usize| dot[i] + direction[i] * (distance + size[i] / 2.0));
            let low = [0, 1].map(|i: usize| centre[i] - size[i] / 2.0);
            Label { low, high: [low[0] + size[0], low[1] + size[1]] }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_collide_with_nothing() {
        // All dots in two heaps.
        let dots: Vec<[f64; 2]> =
            (0..11).map(|i| [f64::from(i % 2) * 300.0 + f64::from(i), 40.0]).collect();
        let names = ["affine-polygon"; 11];
        let labels = labels(&dots, &names);
        for (i, label) in labels.iter().enumerate() {
            assert!(labels[..i].iter().all(|other| !label.overlaps(other)), "{i}: {label:?}");
            let on = |[x, y]: &[f64; 2]| {
                (label.low[0]..label.high[0]).contains(x)
                    && (label.low[1]..label.high[1]).contains(y)
            };
            assert!(!dots.iter().any(on), "{i}: {label:?}");
            assert!(label.low[0] >= 0.0 && label.high[0] <= PANEL[0]);
        }
    }

    #[test]
    fn superscripts() {
        assert_eq!(with_superscript("10^4"), "10\u{2074}");
        assert_eq!(with_superscript("100"), "100");
    }
}
