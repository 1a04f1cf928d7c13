//! `hyperspan info`: what is in a model, without drawing it.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Map, Value, json};

use crate::failure::Failure;
use crate::model::{Material, Model, Needs};
use crate::output::print;

/// Says what is in a model: polygons, bounds, materials, textures, memory.
#[derive(Clone, Debug, Args)]
pub(crate) struct InfoArgs {
    /// A Wavefront OBJ file.
    model: PathBuf,

    /// As one JSON object.
    #[arg(long)]
    json: bool,
}

/// Prints what `args` asks for.
pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let model = Model::read(&args.model, Needs::default())?;
    let text = if args.json { json(args, &model) } else { text(args, &model) };
    print(text.as_bytes())
}

/// The materials that the file names, without the one that is drawn where it names none.
fn materials(model: &Model) -> &[Material] {
    model.materials.get(1..).unwrap_or_default()
}

fn json(args: &InfoArgs, model: &Model) -> String {
    let census = &model.census;
    let by_vertices: Map<String, Value> =
        census.by_vertices.iter().map(|(n, faces)| (n.to_string(), json!(faces))).collect();
    let texture_name = |i: usize| model.textures[i].path.display().to_string();
    let materials: Vec<Value> = materials(model)
        .iter()
        .map(|material| {
            json!({
                "name": material.name,
                "diffuse": material.diffuse,
                "texture": material.texture.map(texture_name),
            })
        })
        .collect();
    let textures: Vec<Value> = (0..model.textures.len())
        .map(|i| {
            let (width, height) = model.textures[i].texture.size();
            json!({ "file": texture_name(i), "width": width, "height": height })
        })
        .collect();
    let object = json!({
        "file": args.model.display().to_string(),
        "polygons": census.faces(),
        "polygons_by_vertices": by_vertices,
        "not_convex": census.not_convex,
        "not_flat": census.not_flat,
        "not_affine": census.not_affine,
        "degenerate": census.degenerate,
        "not_finite": census.not_finite,
        "pieces": model.pieces.len(),
        "vertices": model.positions.len(),
        "vertex_colors": !model.colors.is_empty(),
        "texture_coordinates": model.uvs.len(),
        "normals": model.normals.len(),
        "bounds": model.bounds().map(|[least, greatest]| json!({ "min": least, "max": greatest })),
        "materials": materials,
        "textures": textures,
        "memory_bytes": model.bytes(),
    });
    format!("{object:#}\n")
}

fn text(args: &InfoArgs, model: &Model) -> String {
    let census = &model.census;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let mut line = |label: &str, value: String| {
        let _ = writeln!(out, "{label:<22}{value}");
    };
    line("file", args.model.display().to_string());
    line("polygons", census.faces().to_string());
    for (n, faces) in &census.by_vertices {
        line(&format!("  of {n} vertices"), faces.to_string());
    }
    for (label, count) in [
        ("  not convex", census.not_convex),
        ("  not flat", census.not_flat),
        ("  not affine", census.not_affine),
        ("  degenerate", census.degenerate),
        ("  NaN or infinite", census.not_finite),
    ] {
        line(label, count.to_string());
    }
    line("drawn as", format!("{} convex pieces", model.pieces.len()));
    line("vertices", model.positions.len().to_string());
    line("  with colours", if model.colors.is_empty() { "no" } else { "yes" }.to_owned());
    line("texture coordinates", model.uvs.len().to_string());
    line("normals", model.normals.len().to_string());
    match model.bounds() {
        Some([[x0, y0, z0], [x1, y1, z1]]) => {
            line("bounds", format!("x {x0} .. {x1}, y {y0} .. {y1}, z {z0} .. {z1}"));
        }
        None => line("bounds", "none: no vertex is finite".to_owned()),
    }
    line("materials", materials(model).len().to_string());
    for Material { name, diffuse: [r, g, b], texture } in materials(model) {
        let file = texture.map(|i| format!(", {}", model.textures[i].path.display()));
        line("", format!("{name}: Kd {r} {g} {b}{}", file.unwrap_or_default()));
    }
    line("textures", model.textures.len().to_string());
    for file in &model.textures {
        let (width, height) = file.texture.size();
        line("", format!("{}: {width} x {height}", file.path.display()));
    }
    line("memory", format!("{:.1} MiB", mebibytes(model.bytes())));
    out
}

#[expect(clippy::cast_precision_loss, reason = "for reading")]
fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
