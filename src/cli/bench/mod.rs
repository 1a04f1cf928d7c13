//! `hyperspan bench`: run time against error, of the product and of what could be done instead.

mod errors;
mod heat;
mod json;
mod labels;
mod machine;
mod markdown;
mod measure;
mod reference;
mod report;
mod rungs;
mod sampling;
mod scenes;
mod shaders;
mod soak;
mod soak_report;
mod stress;
mod stress_report;
mod svg;
mod yardstick;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::failure::{Failure, Place};
use crate::flags::{Sink, pool, thread_count, threads};
use crate::output::{Staged, check_place, print, write_rgba_png};
use crate::progress::Progress;
use machine::{Machine, machine};
use measure::{Easel, Variant};
use report::{Case, Report, Row, power};
use rungs::{RungName, Rungs};
use sampling::{Amount, Samples};
use scenes::{MOST_ATTRIBUTES, Picture, SceneName};
use stress::{Options, Until};

/// Measures run time against error: each way of interpolating along a span, on the same polygons.
///
/// Times are ns for each covered pixel. Errors are against exact values, in ulp of f32 and in texels
/// of a 256 x 256 texture. Without --json, --md or --svg the tables go to standard output.
#[derive(Clone, Debug, Args)]
pub(crate) struct BenchArgs {
    /// Writes all rows as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE", value_parser = sink)]
    json: Option<Sink>,

    /// Writes tables; `-` is standard output.
    #[arg(long, value_name = "FILE", value_parser = sink)]
    md: Option<Sink>,

    /// Writes charts: time across, error up; `-` is standard output.
    #[arg(long, value_name = "FILE", value_parser = sink)]
    svg: Option<Sink>,

    /// Writes the error of each pixel as pictures into a folder, which must be there: one for each
    /// scene, w ratio and rung. From dark to bright: 0.5, 10, 300, 10^4, 3 10^5, 10^7 ulp.
    #[arg(long, value_name = "DIR")]
    heat: Option<PathBuf>,

    /// Only this scene; can be given several times.
    #[arg(long, value_name = "NAME", value_enum)]
    scene: Vec<SceneName>,

    /// Only this rung; can be given several times.
    #[arg(long, value_name = "NAME", value_enum)]
    rung: Vec<RungName>,

    /// Only this ratio between the greatest w of a polygon and the least, 1 to 10^6; can be given
    /// several times. Else 1, 10^2, 10^4 and 10^6.
    #[arg(long, value_name = "R", value_parser = w_ratio, allow_hyphen_values = true)]
    w_ratio: Vec<f64>,

    /// Pictures of this width only, 256 to 8192 pixels. Else 1024, and some of 256 and 8192.
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(256..=8192), allow_hyphen_values = true)]
    width: Option<u32>,

    /// In half a minute: fewer runs and samples, and two attributes only.
    #[arg(long)]
    quick: bool,

    /// Instead: polygons that go step by step to an extreme, and how near their errors come to what
    /// is promised. Fails if one is beyond.
    #[arg(long, conflicts_with_all = ["svg", "heat", "scene", "rung", "w_ratio", "width", "simd"])]
    stress: bool,

    /// Instead: random scenes for so long, each pixel against a coverage oracle and each value
    /// against the reference; one scene at least. Exit code 1 if there is a disagreement.
    #[arg(long, value_name = "SECONDS", conflicts_with_all = ["svg", "heat", "scene", "rung", "w_ratio", "width", "simd", "quick", "stress"], value_parser = seconds, allow_hyphen_values = true)]
    soak: Option<f64>,

    /// With --soak: the number of the first scene.
    #[arg(long, value_name = "SCENE", requires = "soak", default_value = "0")]
    from: u64,

    /// With --soak: so many scenes at a time; 0 is one for each core.
    #[arg(long, value_name = "N", requires = "soak", default_value = "1", value_parser = thread_count, allow_hyphen_values = true)]
    threads: u32,

    /// With --stress: a search that climbs towards the worst polygon, for so long.
    #[arg(long, value_name = "SECONDS", requires = "stress", value_parser = seconds, allow_hyphen_values = true)]
    search: Option<f64>,

    /// With --stress and --soak: another number gives other polygons.
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,

    /// Instructions to draw with: auto (the widest), or scalar, sse2, sse4.2, avx2, avx512, neon or
    /// wasm, if the machine has them.
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = machine)]
    simd: Machine,
}

fn sink(text: &str) -> Result<Sink, String> {
    match text {
        "" => Err("give a file name, or -".to_owned()),
        "-" => Ok(Sink::Stdout),
        _ => Ok(Sink::File(PathBuf::from(text))),
    }
}

fn w_ratio(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (1.0..=1e6).contains(number));
    number.ok_or_else(|| "give a number from 1 to 1000000".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (0.0..=1e6).contains(number));
    number.ok_or_else(|| "give seconds, from 0 to 1000000".to_owned())
}

/// Measures what `args` asks for, and writes it. Is all as it must be?
pub(crate) fn run(args: &BenchArgs) -> Result<bool, Failure> {
    args.check()?;
    if let Some(seconds) = args.soak {
        return run_soak(args, seconds);
    }
    if args.stress {
        return run_stress(args).map(|()| true);
    }
    let plan = Plan::new(args);
    let cases = plan.cases();
    let mut progress = Progress::new("measuring");
    let mut report =
        Report { rows: Vec::new(), simd: args.simd.name, runs: plan.runs, width: plan.width };
    let mut staged = Staged::default();
    for (i, case) in cases.iter().enumerate() {
        progress.set(i as u64, cases.len() as u64);
        measure_case(&plan, case, &mut report)?;
        let draws_heat = case.width == plan.width && case.attributes == 2;
        if let Some(folder) = args.heat.as_ref().filter(|_| draws_heat) {
            draw_heat(&plan, case, folder, &mut staged)?;
        }
    }
    drop(progress);
    write(args, &report, staged)?;
    Ok(true)
}

impl BenchArgs {
    /// Can what is asked for be written?
    fn check(&self) -> Result<(), Failure> {
        let sinks = || [&self.json, &self.md, &self.svg].into_iter().flatten();
        if sinks().filter(|sink| **sink == Sink::Stdout).count() > 1 {
            return Err(Failure::new(
                "only one of --json, --md and --svg can go to standard output: name files for the \
                 others",
            ));
        }
        for sink in sinks() {
            if let Sink::File(path) = sink {
                check_place(path)?;
            }
        }
        match &self.heat {
            Some(folder) if !folder.is_dir() => Err(Failure::at(
                Place::file(folder),
                "--heat writes into a folder, and there is none of that name: make it first",
            )),
            _ => Ok(()),
        }
    }
}

/// What is measured, and how thoroughly.
struct Plan {
    machine: Machine,
    scenes: Vec<SceneName>,
    rungs: Vec<RungName>,
    w_ratios: Vec<f64>,
    /// Of most pictures.
    width: u32,
    other_widths: Vec<u32>,
    /// Each number of attributes, and what is made of them.
    kinds: Vec<(usize, Vec<Variant>)>,
    runs: usize,
    samples: Amount,
}

impl Plan {
    fn new(args: &BenchArgs) -> Self {
        const ALL: [Variant; 3] = [Variant::Attributes, Variant::Depth, Variant::Texture];
        let all_or = |chosen: &[f64], all: &[f64]| {
            if chosen.is_empty() { all.to_vec() } else { chosen.to_vec() }
        };
        let mut kinds = vec![(2, if args.quick { vec![ALL[0]] } else { ALL.to_vec() })];
        if !args.quick {
            kinds.push((MOST_ATTRIBUTES, vec![Variant::Attributes]));
        }
        let fixed = args.quick || args.width.is_some();
        let samples = if args.quick {
            Amount { even: 4e3, at_ends: 4e3 }
        } else {
            Amount { even: 2e4, at_ends: 2e4 }
        };
        Self {
            machine: args.simd,
            scenes: chosen(&args.scene),
            rungs: chosen(&args.rung),
            w_ratios: all_or(&args.w_ratio, &[1.0, 1e2, 1e4, 1e6]),
            width: args.width.unwrap_or(1024),
            other_widths: if fixed { Vec::new() } else { vec![256, 8192] },
            kinds,
            runs: if args.quick { 7 } else { 25 },
            samples,
        }
    }

    /// What is drawn: in the order of the tables.
    fn cases(&self) -> Vec<Drawn> {
        let mut cases = Vec::new();
        let widths = [self.width].into_iter().chain(self.other_widths.iter().copied());
        for (i, width) in widths.enumerate() {
            for (attributes, variants) in &self.kinds {
                // Other widths: two attributes, and no more made of them.
                if i > 0 && *attributes != 2 {
                    continue;
                }
                let variants = if i > 0 { &variants[..1] } else { variants };
                for w_ratio in &self.w_ratios {
                    for scene in &self.scenes {
                        let (scene, w_ratio, attributes) = (*scene, *w_ratio, *attributes);
                        let variants = variants.to_vec();
                        cases.push(Drawn { scene, w_ratio, attributes, width, variants });
                    }
                }
            }
        }
        cases
    }
}

/// Those that are chosen, each once and in their own order; all if none is.
fn chosen<T: ValueEnum + Copy + PartialEq>(chosen: &[T]) -> Vec<T> {
    let all = T::value_variants().iter().copied();
    all.filter(|name| chosen.is_empty() || chosen.contains(name)).collect()
}

/// A picture, and what is made of it.
struct Drawn {
    scene: SceneName,
    w_ratio: f64,
    attributes: usize,
    width: u32,
    variants: Vec<Variant>,
}

/// Draws one picture in all ways, and adds their rows.
fn measure_case(plan: &Plan, drawn: &Drawn, report: &mut Report) -> Result<(), Failure> {
    let Drawn { scene, w_ratio, attributes, width, ref variants } = *drawn;
    let picture = Picture::new(scene, w_ratio, attributes, width)?;
    let samples = Samples::new(&picture, plan.samples);
    let mut rungs = Rungs::new(&picture, plan.machine);
    let mut easel = Easel::new(width, plan.machine)?;
    let mut found = Vec::new();
    for rung in &plan.rungs {
        found.push(samples.capture(&mut rungs, *rung, &picture)?);
    }
    for variant in variants {
        let is_measured = |rung: &RungName| *variant != Variant::Depth || rung.has_own_depth();
        let names: Vec<RungName> = plan.rungs.iter().copied().filter(is_measured).collect();
        let measured = easel.measure(&mut rungs, &names, &picture, *variant, plan.runs)?;
        let mut rows = Vec::new();
        for (rung, times) in names.iter().zip(&measured.rungs) {
            let at = plan.rungs.iter().position(|name| name == rung).unwrap_or(0);
            let errors = match variant {
                Variant::Depth => errors::of_depth(&samples, &found[at], *rung),
                _ => errors::of_attributes(&samples, &found[at], *rung),
            };
            let variant = *variant;
            rows.push(Row {
                case: Case { scene, w_ratio, attributes, width, variant },
                rung: *rung,
                pixels: samples.pixels,
                polygons: picture.facets.len(),
                times: times.per(samples.pixels),
                yardstick: measured.yardstick,
                fill: measured.fill,
                errors,
                pareto: false,
            });
        }
        report.add(rows);
    }
    Ok(())
}

/// Pictures of the error at each pixel.
fn draw_heat(
    plan: &Plan,
    drawn: &Drawn,
    folder: &std::path::Path,
    staged: &mut Staged,
) -> Result<(), Failure> {
    let picture = Picture::new(drawn.scene, drawn.w_ratio, drawn.attributes, drawn.width)?;
    let samples = Samples::new(&picture, Amount::ALL);
    let mut rungs = Rungs::new(&picture, plan.machine);
    let [width, height] = scenes::size(drawn.width);
    for rung in &plan.rungs {
        let found = samples.capture(&mut rungs, *rung, &picture)?;
        let pixels = heat::picture(&samples, &found, [width, height]);
        let ratio = power(drawn.w_ratio).replace('^', "");
        let name = format!("{}-w{ratio}-{}.png", drawn.scene.name(), rung.name());
        let sink = Sink::File(folder.join(name));
        staged.add(&sink, |out| write_rgba_png(out, &pixels, width, height))?;
    }
    Ok(())
}

/// Stresses the bounds.
fn run_stress(args: &BenchArgs) -> Result<(), Failure> {
    let polygons = if args.quick { 100 } else { 1000 };
    let search = args.search.map(|seconds| Until { tried: u64::MAX, seconds });
    let mut progress = Progress::new("stressing");
    let options = Options { polygons, search, seed: args.seed };
    let rows = stress::run(options, &mut |done, all| progress.set(done, all))?;
    drop(progress);
    let markdown = || stress_report::markdown(&rows);
    let json = || stress_report::json(&rows).to_string();
    write_texts(&[(&args.json, &json), (&args.md, &markdown)], &markdown, Staged::default())?;
    if rows.iter().any(|row| row.judged.worst.iter().flatten().any(|part| *part > 1.0)) {
        return Err(Failure::new("an error is beyond its bound: see the entries above 1"));
    }
    Ok(())
}

/// Draws random scenes. Are they all as they must be?
fn run_soak(args: &BenchArgs, seconds: f64) -> Result<bool, Failure> {
    let (seed, first) = (args.seed, args.from);
    let options = soak::Options { seconds, seed, first, threads: threads(args.threads) };
    let mut progress = Progress::new("soaking");
    const PARTS: u64 = 1000;
    let mut tell = |part: f64| progress.set((part * PARTS as f64) as u64, PARTS);
    let soaked = soak::run(options, &pool(soak::POOL)?, &mut tell);
    drop(progress);
    let markdown = || soak_report::markdown(&soaked, options);
    let json = || soak_report::json(&soaked, options).to_string();
    write_texts(&[(&args.json, &json), (&args.md, &markdown)], &markdown, Staged::default())?;
    Ok(soaked.disagreements == 0)
}

/// Writes what is asked for: all of it, or nothing.
fn write(args: &BenchArgs, report: &Report, staged: Staged) -> Result<(), Failure> {
    let (json, svg) = (|| json::json(report), || svg::svg(report));
    let markdown = || markdown::markdown(report);
    let texts: [Text<'_>; 3] = [(&args.json, &json), (&args.md, &markdown), (&args.svg, &svg)];
    // Pictures are something, too.
    let nothing = || String::new();
    let or_else: &dyn Fn() -> String = if args.heat.is_some() { &nothing } else { &markdown };
    write_texts(&texts, or_else, staged)
}

/// Where a text goes, if it is asked for, and how it is made.
type Text<'a> = (&'a Option<Sink>, &'a dyn Fn() -> String);

/// Writes the texts that are asked for, and if none is, prints `or_else`.
fn write_texts(
    texts: &[Text<'_>],
    or_else: &dyn Fn() -> String,
    mut staged: Staged,
) -> Result<(), Failure> {
    let mut asked = false;
    for (sink, text) in texts {
        if let Some(sink) = sink {
            asked = true;
            let text = text();
            staged.add(sink, |out| {
                out.write_all(text.as_bytes())
                    .map_err(|e| Failure::new(format!("cannot write the results: {e}")))
            })?;
        }
    }
    staged.commit()?;
    if asked { Ok(()) } else { print(or_else().as_bytes()) }
}
