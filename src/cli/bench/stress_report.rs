//! What the stress came to, as tables for reading and as JSON.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::stress::judge::{Judged, PRECISIONS, Quantity};
use super::stress::{Case, Row};

/// Two tables: the worst of each sweep, and all steps.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let mut sweeps: Vec<Row> = Vec::new();
    for row in rows {
        match sweeps.last_mut().filter(|last| last.sweep == row.sweep) {
            Some(last) => {
                last.judged = last.judged.and(row.judged);
                last.polygons += row.polygons;
            }
            None => sweeps.push(row.clone()),
        }
    }
    let mut out =
        String::from("The largest error over the promised bound; none may be above 1.\n\n");
    table(&mut out, "sweep", &sweeps, |row| row.sweep.to_owned());
    out.push_str("\nStep by step.\n\n");
    table(&mut out, "sweep, step", rows, |row| format!("{}, {}", row.sweep, step(row.step)));
    out
}

fn table(out: &mut String, first: &str, rows: &[Row], label: impl Fn(&Row) -> String) {
    let columns: Vec<String> = PRECISIONS
        .iter()
        .flat_map(|p| Quantity::ALL.map(|quantity| format!("`{p:?}` {}", quantity.name())))
        .collect();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "| {first} | polygons | pixels | {} |", columns.join(" | "));
    let _ = writeln!(out, "|---|---|---|{}", "---|".repeat(columns.len()));
    for row in rows {
        let Judged { pixels, worst, .. } = row.judged;
        let parts: Vec<String> = worst.iter().flatten().map(|part| number(*part)).collect();
        let (label, polygons) = (label(row), row.polygons);
        let _ = writeln!(out, "| {label} | {polygons} | {pixels} | {} |", parts.join(" | "));
    }
}

/// A part of a bound: what is beyond catches the eye, however little it is.
fn number(part: f64) -> String {
    if part > 1.0 { format!("**{part}**") } else { format!("{part:.4}") }
}

fn step(step: f64) -> String {
    let plain = step == 0.0 || (1e-3..1e5).contains(&step);
    if plain { format!("{step}") } else { format!("{step:e}") }
}

/// An object whose `rows` have what the tables have, and the worst polygon of each row.
pub(crate) fn json(rows: &[Row]) -> Value {
    json!({ "rows": rows.iter().map(row).collect::<Vec<_>>() })
}

fn row(row: &Row) -> Value {
    let judged = row.judged;
    let parts = |p: usize| -> Map<String, Value> {
        let parts = Quantity::ALL.iter().zip(judged.worst[p]);
        parts.map(|(quantity, part)| (quantity.name().to_owned(), json!(part))).collect()
    };
    let mut object = json!({
        "sweep": row.sweep,
        "parameter": row.parameter,
        "step": row.step,
        "polygons": row.polygons,
        "clipped": judged.clipped,
        "pixels": judged.pixels,
        "values": judged.values,
        "left_out": judged.left_out,
        "mean_fast_attribute": judged.mean_of_fast(),
        "worst": row.worst.as_ref().map(case),
    });
    for (p, precision) in PRECISIONS.iter().enumerate() {
        object[format!("{precision:?}").to_lowercase()] = Value::Object(parts(p));
    }
    object
}

fn case(case: &Case) -> Value {
    let rect = case.viewport.rect();
    let windows: Vec<_> = case.windows.iter().map(|w| [w.x0, w.y0, w.x1, w.y1]).collect();
    json!({
        "viewport": [rect.x0, rect.y0, rect.x1, rect.y1],
        "positions": case.positions,
        "attributes": case.attributes,
        "windows": windows,
    })
}
