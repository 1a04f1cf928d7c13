//! What a soak came to, as tables for reading and as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::soak::check::Tally;
use super::soak::values::QUANTITIES;
use super::soak::{Options, Soaked};

const PRECISIONS: [&str; 2] = ["fast", "exact"];

/// Counts by kind of scene, the worst values, and disagreements with a reproduction.
pub(crate) fn markdown(soaked: &Soaked, options: Options) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{:.0} seconds, seed {}, scenes from {} on: {} disagreements.\n",
        soaked.seconds, options.seed, options.first, soaked.disagreements
    );
    out.push_str(
        "| scenes | drawn | polygons | cut by planes | pixels compared | covered, of each polygon | \
         too near to a cut | values | doubtful | without reference |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    let total = ("all", soaked.total());
    for (kind, tally) in soaked.tallies.iter().chain([&total]) {
        let Tally { scenes, polygons, cut, pixels, covered, undecided, compared } = tally;
        let values: u64 = compared.values.iter().sum();
        let (doubtful, left_out) = (compared.doubtful, compared.left_out);
        let _ = writeln!(
            out,
            "| {kind} | {scenes} | {polygons} | {cut} | {pixels} | {covered} | {undecided} | \
             {values} | {doubtful} | {left_out} |"
        );
    }
    let _ = writeln!(out, "\nThe largest error over its bound; none may be above 1.\n");
    let _ = writeln!(out, "| precision | values | {} |", QUANTITIES.join(" | "));
    out.push_str("|---|---|---|---|---|---|\n");
    let compared = total.1.compared;
    for (p, precision) in PRECISIONS.iter().enumerate() {
        let worst = compared.worst[p].map(|part| format!("{part:.4}")).join(" | ");
        let _ = writeln!(out, "| `{precision}` | {} | {worst} |", compared.values[p]);
    }
    for shown in &soaked.shown {
        let _ = writeln!(
            out,
            "\nDisagreement: --soak 0 --seed {} --from {} ({}): {}\n\n{}",
            options.seed, shown.scene, shown.kind, shown.what, shown.text
        );
    }
    out
}

/// An object with the same.
pub(crate) fn json(soaked: &Soaked, options: Options) -> Value {
    let tally = |tally: &Tally| {
        json!({
            "scenes": tally.scenes,
            "polygons": tally.polygons,
            "cut": tally.cut,
            "pixels": tally.pixels,
            "covered": tally.covered,
            "undecided": tally.undecided,
            "values": tally.compared.values.iter().sum::<u64>(),
            "doubtful": tally.compared.doubtful,
            "left_out": tally.compared.left_out,
        })
    };
    let total = soaked.total();
    let mut object = tally(&total);
    for (p, precision) in PRECISIONS.iter().enumerate() {
        let mut worst = json!({ "values": total.compared.values[p] });
        for (name, part) in QUANTITIES.iter().zip(total.compared.worst[p]) {
            worst[*name] = json!(part);
        }
        object[*precision] = worst;
    }
    let kinds = soaked.tallies.iter().map(|(kind, of_kind)| {
        let mut object = tally(of_kind);
        object["kind"] = json!(kind);
        object
    });
    object["kinds"] = kinds.collect();
    object["seconds"] = json!(soaked.seconds);
    object["seed"] = json!(options.seed);
    object["from"] = json!(options.first);
    object["disagreements"] = json!(soaked.disagreements);
    let shown = soaked.shown.iter().map(|shown| {
        json!({ "scene": shown.scene, "kind": shown.kind, "what": shown.what, "polygon": shown.text })
    });
    object["shown"] = shown.collect();
    object
}
