//! The rows as JSON, for other programs. No key is ever missing; what there is not is null.

use serde_json::{Value, json};

use super::report::{Report, Row};

/// One object.
pub(crate) fn json(report: &Report) -> String {
    let rows: Vec<Value> = report.rows.iter().map(|row| row_json(report, row)).collect();
    let object = json!({
        "simd": report.simd,
        "runs": report.runs,
        "rows": rows,
    });
    format!("{object:#}\n")
}

/// A number that is none becomes null.
fn row_json(report: &Report, row: &Row) -> Value {
    let (case, errors) = (&row.case, &row.errors);
    json!({
        "scene": case.scene.name(),
        "w_ratio": case.w_ratio,
        "attributes": case.attributes,
        "width": case.width,
        "variant": case.variant.name(),
        "rung": row.rung.name(),
        "simd": report.simd,
        "polygons": row.polygons,
        "pixels": row.pixels,
        "ns_per_pixel": row.times.median,
        "least_ns_per_pixel": row.times.least,
        "yardstick_ns": row.yardstick,
        "fill_ns": row.fill,
        "yardsticks": row.times.median / row.yardstick,
        "values": errors.values,
        "doubtful_values": errors.doubtful,
        "max_ulp": errors.max_ulp,
        "p999_ulp": errors.p999_ulp,
        "mean_ulp": errors.mean_ulp,
        "max_of_magnitude": errors.max_of_magnitude,
        "max_texels": errors.texels.map(|texels| texels.max),
        "mean_texels": errors.texels.map(|texels| texels.mean),
        "wrong_texels_percent": errors.texels.map(|texels| texels.wrong_percent),
        "bound_ulp": errors.promise.map(|kept| kept.bound_ulp),
        "worst_over_bound": errors.promise.map(|kept| kept.worst),
        "pareto": row.pareto,
    })
}
