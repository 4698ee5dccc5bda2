//! `check`: what collides when a program runs on a machine.
//!
//! Reading order: this file (options, the run, and what a terminal shows), `findings` (the list that other programs get), `sarif`, `junit`, `stock`, `certify`.

mod certify;
mod findings;
mod junit;
mod sarif;
mod stock;

use super::gcode::{by_letter, shown};
use super::options::{ClearanceOptions, number};
use super::progress::Bar;
use super::style::{self, Tone};
use super::subject::{SET_UP_EXAMPLES, Subject, is_new_or_written, refuse_ending};
use super::{CLEAR, FAILED, note, say};
use crate::check::{self, Cutting, Event, Extent, Kind, Outcome, OverTravel, Settings};
use crate::geometry::Mesh;
use crate::geometry::import::FileInUnit;
use crate::machine::OutOfLimits;
use crate::measure::{Progress, timer};
use crate::record::file::write_text;
use crate::registry::{Registry, Variant};
use crate::scene::pairs::{Decision, Dropped};
use crate::scene::{Part, ProgramRun, Role, Scene};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use comfy_table::Table;
use rs274::{Axis, Note};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stock::Left;

#[derive(Args)]
#[command(
    after_help = format!("Examples:\n  bvbench check lathe-toolpost                     a shipped scene with its own program\n  bvbench check path/to/machine part.ngc           your machine, your program\n  bvbench check path/to/machine part.ngc --first   stop at the first collision\n  bvbench check path/to/machine part.ngc --clearance 5 --clearance holder:fixture=10 --json\n  bvbench check lathe-tailstock --method ID --csv > events.csv\n  bvbench check path/to/machine part.ngc --sarif part.sarif --junit part.xml\n  bvbench check path/to/machine part.ngc --stock-resolution 0.05 --stock-out left.stl\n  bvbench check path/to/machine part.ngc --target finished.stl   gouges and rests against the wanted part\n  bvbench check path/to/machine part.ngc --certify part.cert\n\nA cutter that feeds into the workpiece takes material away. A cutter at rapid rate or with a standing spindle, a shank, a holder and all else collide with what is left; whatever else touches collides. With --certify a block is clear only if it is proved free; a rapid of the cutter over the workpiece, if it is free of what is left of it.\nExit codes: 0 clear, 1 something collides, may collide (unresolved), gouges the target or lacks stock for it, or may, an axis leaves its limits, a tool in use has no part, or with --certify a block is not proved, 2 bad usage or input.\n\n{SET_UP_EXAMPLES}")
)]
pub struct Options {
    #[command(flatten)]
    subject: Subject,
    /// Variant whose trees are used (see `list`) [default: the fastest safe one; with --certify the search's own]
    #[arg(long, value_name = "ID")]
    method: Option<String>,
    #[command(flatten)]
    clearance: ClearanceOptions,
    /// Greatest travel between samples of the path, mm [default: the scene's]
    #[arg(long, value_name = "MM", value_parser = number, allow_negative_numbers = true)]
    step: Option<f64>,
    /// Travel to which beginnings and ends of contact are found, mm
    #[arg(long, value_name = "MM", default_value_t = 0.01, value_parser = number, allow_negative_numbers = true)]
    tolerance: f64,
    /// Stop at the first collision; where it ends is then not looked for
    #[arg(long)]
    first: bool,
    #[command(flatten)]
    stock: StockOptions,
    /// Print the result as JSON
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print the findings as CSV
    #[arg(long)]
    csv: bool,
    #[command(flatten)]
    reports: Reports,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print no progress
    #[arg(long, short)]
    quiet: bool,
}

/// The workpiece while it is cut.
#[derive(Args)]
struct StockOptions {
    /// Depth to which contact with what is left of the workpiece is not told from touching, mm; `none` keeps the workpiece whole, and may miss a rapid through
    /// it [default: 0.1, or a ten-thousandth of its longest side where that is more; five times that on lathes with driven tools; down to a quarter of it for
    /// thin cutters that feed]
    #[arg(long, value_name = "MM", value_parser = cutting)]
    stock_resolution: Option<Cutting>,
    /// Write what may be left of the workpiece at the end (outer bound) as STL, in the frame of the workpiece's mesh: that of its file, or G54 for a box or
    /// cylinder of --stock
    #[arg(long, value_name = "FILE.stl")]
    stock_out: Option<PathBuf>,
    /// Compare what is left with the wanted part, a mesh file in the same frame as --stock-out: gouges and rests. UNIT is mm, cm, m or inch [default: the
    /// format's: metres in GLB, its own in 3MF, else mm]
    #[arg(long, value_name = "FILE[:UNIT]")]
    target: Option<FileInUnit>,
}

/// A resolution, or `none`.
fn cutting(text: &str) -> Result<Cutting, String> {
    match text {
        "none" => Ok(Cutting::Never),
        number => number.parse().map(Cutting::At).map_err(|_| "must be a length in mm, or `none`".to_owned()),
    }
}

/// Reports for other programs, beside what is printed.
#[derive(Args)]
struct Reports {
    /// Also write the findings as SARIF 2.1.0, which code hosts and editors show at their lines
    #[arg(long, value_name = "FILE")]
    sarif: Option<PathBuf>,
    /// Also write the findings as JUnit XML, a test case for each pair, which build servers show
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Also prove each block free of contact, in contact, or unresolved, and write the proof, which `certificate-checker` checks
    #[arg(long, value_name = "FILE")]
    certify: Option<PathBuf>,
}

impl Reports {
    /// Refuses files that are no place for what is written: what is read, devices, folders. `read` are the scene's files, where it is loaded.
    fn refuse_bad_files(&self, subject: &Subject, stock: &StockOptions, read: &[PathBuf]) -> Result<()> {
        let target = stock.target.as_ref().map(|target| target.path.clone());
        let files = [
            ("--sarif", &self.sarif),
            ("--junit", &self.junit),
            ("--certify", &self.certify),
            ("--stock-out", &stock.stock_out),
            ("--target", &target),
        ];
        let read = [read, target.as_slice()].concat();
        for (option, file) in &files[..4] {
            file.as_deref().map(|file| subject.refuse_output(option, file, &read)).transpose()?;
        }
        if let Some(file) = &stock.stock_out {
            refuse_ending("--stock-out", file, "stl")?;
        }
        for (i, (option, file)) in files.iter().enumerate() {
            let same = files[..i].iter().find(|(_, other)| file.is_some() && other == file);
            if let Some((other, _)) = same {
                bail!("{other} and {option} name the same file");
            }
        }
        Ok(())
    }

    fn write(&self, checked: &Checked<'_>) -> Result<()> {
        if let Some(file) = &self.sarif {
            write_text(file, &pretty(&sarif::report(checked))?)?;
        }
        if let Some(file) = &self.junit {
            write_text(file, &junit::report(checked)?)?;
        }
        Ok(())
    }

    /// Reports that there is no answer, so that those of an earlier run are not taken for one. Files of other kinds than reports stay: what
    /// was read before the error is not known.
    fn write_failure(&self, subject: &Subject, error: &anyhow::Error) -> Result<()> {
        let error = super::error_text(error);
        let ours = |file: &&PathBuf| is_new_or_written(file);
        if let Some(file) = self.sarif.as_ref().filter(ours) {
            write_text(file, &pretty(&sarif::failure(&error))?)?;
        }
        if let Some(file) = self.junit.as_ref().filter(ours) {
            let program = subject.program.as_deref().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
            write_text(file, &junit::failure(&subject.scene, &program, &error)?)?;
        }
        if let Some(file) = self.certify.as_ref().filter(ours) {
            write_text(file, &format!("no certificate: {}\n", error.replace('\n', " ")))?;
        }
        Ok(())
    }
}

fn pretty(value: &Value) -> Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// A program that was checked, and what was found.
struct Checked<'a> {
    scene: Scene,
    run: ProgramRun,
    variant: &'a Variant,
    outcome: Outcome,
    left: Vec<Left>,
    certificate: Option<certify::Written>,
    times: Times,
}

impl Checked<'_> {
    /// Whether the program may run.
    fn is_clear(&self) -> bool {
        let is_clear = findings::findings(self).iter().all(|finding| finding.rule.is_note);
        assert!(self.outcome.is_clear() || !is_clear, "whatever fails a check is a finding of every report");
        is_clear
    }
}

/// How long the stages took, s.
struct Times {
    /// Reading the scene and making its meshes.
    load_s: f64,
    /// Building trees, which is a part of checking.
    trees_s: f64,
    /// Checking the program.
    check_s: f64,
}

impl Times {
    fn poses_per_s(&self, outcome: &Outcome) -> f64 {
        outcome.samples as f64 / self.check_s
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    options.reports.refuse_bad_files(&options.subject, &options.stock, &[])?;
    let failed = |error: anyhow::Error| options.reports.write_failure(&options.subject, &error).err().unwrap_or(error);
    let prepared = Prepared::new(options, registry).map_err(failed)?;
    options.reports.refuse_bad_files(&options.subject, &options.stock, &prepared.scene.files)?;
    let checked = prepared.check(options, registry).map_err(failed)?;
    options.reports.write(&checked)?;
    let Checked { scene, run, variant, outcome, times, left, certificate } = &checked;
    if options.json {
        let mut json = as_json(scene, run, variant, outcome, times);
        json["clear"] = json!(checked.is_clear());
        json["certificate"] = json!(certificate.as_ref().map(|written| written.as_json(scene)));
        json["stock"] = stock::as_json(scene, outcome, left);
        say(serde_json::to_string_pretty(&json)?);
    } else if options.csv {
        say(as_csv(&checked)?.trim_end());
        not_examined(scene, run, outcome).iter().for_each(note);
    } else {
        print(scene, run, outcome, variant, times);
        left.iter().flat_map(|left| left.lines(scene)).for_each(say);
        if let (Some(certificate), Some(file)) = (certificate, &options.reports.certify) {
            certificate.print(scene, file);
        }
    }
    Ok(if checked.is_clear() { CLEAR } else { FAILED })
}

/// A program that can be checked.
struct Prepared<'a> {
    scene: Scene,
    run: ProgramRun,
    variant: &'a Variant,
    settings: Settings,
    target: Option<Arc<Mesh>>,
    load_ns: u64,
}

impl<'a> Prepared<'a> {
    fn new(options: &Options, registry: &'a Registry) -> Result<Self> {
        super::options::use_threads(options.threads)?;
        let variant = method(options.method.as_deref(), registry)?;
        let mut settings = settings(options)?;
        let target = options.stock.target()?;
        // What is not examined is part of an answer in words, and of what stands beside a table.
        let counts: fn(&Note) -> bool = if options.json { |_| true } else { |note| !note.is_unknown };
        let (load_ns, loaded) = timer::time(|| options.subject.load_and_note(counts));
        let (scene, run) = loaded?;
        settings.clearances = options.clearance.read(&scene)?;
        let mut run = run.with_context(|| format!("scene `{}` has no program of its own; name one", scene.name))?;
        if let Some(step) = options.step {
            if !(step > 0.0 && step.is_finite()) {
                bail!("--step is {step}; it must be a finite number above 0");
            }
            run.sampling.step_mm = step;
        }
        if !variant.info.safe {
            note(format!("warning: `{}` does not promise to find every contact", variant.info.id));
        }
        Ok(Self { scene, run, variant, settings, target, load_ns })
    }

    fn check(self, options: &Options, registry: &Registry) -> Result<Checked<'a>> {
        let Self { scene, run, variant, settings, target, load_ns } = self;
        let bar = Bar::new(options.quiet);
        let (ns, outcome) = timer::time(|| check::check(&scene, &run, variant, registry, &settings, &bar));
        let mut outcome = outcome?;
        // Only a variant that is asked for: without one the search halves meshes in its own way.
        let searched_by = options.method.as_ref().map(|_| variant);
        let certify = |file: &PathBuf| certify::Written::new(file, &scene, &run, searched_by, &bar);
        let certificate = options.reports.certify.as_ref().map(certify).transpose()?;
        if settings.is_solid {
            bar.begin("measuring what is left", 1);
        }
        let left = options.stock.left(&scene, &mut outcome, target.as_ref());
        bar.finish();
        let left = left?;
        let times = Times { load_s: seconds(load_ns), trees_s: seconds(outcome.trees_ns), check_s: seconds(ns) };
        Ok(Checked { scene, run, variant, outcome, left, certificate, times })
    }
}

/// The variant asked for; else the fastest of the safe ones.
pub(super) fn method<'a>(asked: Option<&str>, registry: &'a Registry) -> Result<&'a Variant> {
    match asked {
        Some(id) => {
            let known = || registry.variants().iter().map(|variant| variant.info.id).collect::<Vec<_>>().join(", ");
            registry.find(id).ok_or_else(|| anyhow!("there is no variant `{id}`; there are {}", known()))
        }
        None => registry.fastest().context("no safe variant is registered"),
    }
}

fn settings(options: &Options) -> Result<Settings> {
    let settings = Settings {
        stop_at_first: options.first,
        tolerance_mm: options.tolerance,
        cutting: options.stock.stock_resolution.unwrap_or_default(),
        is_solid: options.stock.stock_out.is_some() || options.stock.target.is_some(),
        ..Settings::standard()
    };
    if !(options.tolerance > 0.0 && options.tolerance.is_finite()) {
        bail!("--tolerance is {}; it must be a finite number above 0", options.tolerance);
    }
    Ok(settings)
}

fn print(scene: &Scene, run: &ProgramRun, outcome: &Outcome, variant: &Variant, times: &Times) {
    let (collisions, near): (Vec<&Event>, Vec<&Event>) =
        outcome.events.iter().partition(|event| event.kind.is_collision());
    if !(collisions.is_empty() && outcome.over_travel.is_empty()) {
        say(painted(&table(scene, &collisions, &outcome.over_travel).trim_fmt()));
        for event in &collisions {
            say(format!(
                "\nline {}: {}\n  {} {}",
                event.first.line,
                if event.first.line == 0 { "(before the first move)" } else { &event.block },
                scene.pair_name(event.pair),
                // The depth is that of the whole way.
                match stock::depth(event) {
                    Some(depth) => format!("from {} on, {depth}", axes(&event.first)),
                    None => format!("at {}", axes(&event.first)),
                },
            ));
        }
        for over in &outcome.over_travel {
            say(format!("\nline {}: {}\n  {}", over.line, over.block, over.cause));
        }
        say("");
    }
    let near = near_pairs(&near, &collisions);
    if !near.is_empty() {
        say(painted(&near_misses(scene, &near).trim_fmt()));
        say("");
    }
    say(format!(
        "{}, read as {}: {} in {} of program time",
        run.file.display(),
        run.setup.dialect,
        found(&collisions, outcome),
        clock(outcome.duration_s),
    ));
    let kept = outcome.decisions.iter().filter(|decision| decision.dropped.is_none()).count();
    say(format!(
        "{} of {} pairs examined (`bvbench scene pairs` says why), {} poses of the path, {} distance queries",
        kept,
        outcome.decisions.len(),
        outcome.samples,
        outcome.queries,
    ));
    let (id, rate) = (variant.info.id, times.poses_per_s(outcome));
    say(format!(
        "{:.2} s to load the scene; {:.2} s with {id}, {:.2} s of it to build trees: {rate:.0} poses per second",
        times.load_s, times.check_s, times.trees_s
    ));
    not_examined(scene, run, outcome).iter().for_each(say);
    if collisions.iter().any(|event| event.first.line == 0) {
        say(
            "parts that touch before the first move, because they are built so, belong into `allow` of `[check]` in scene.toml",
        );
    }
}

/// The answer in a few words.
fn found(collisions: &[&Event], outcome: &Outcome) -> String {
    let unresolved = collisions.iter().filter(|event| event.kind == Kind::Unresolved).count();
    let counted = [
        (collisions.len() - unresolved, "collision", "collisions"),
        (unresolved, "contact that is not excluded", "contacts that are not excluded"),
        (outcome.over_travel.len(), "axis beyond its limits", "times an axis beyond its limits"),
    ];
    let counted = counted.into_iter().filter(|(count, ..)| *count > 0);
    let counted: Vec<String> =
        counted.map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many })).collect();
    let deepest = outcome.touches.iter().map(|touch| touch.at_most_mm).fold(0.0, f64::max);
    if !counted.is_empty() {
        counted.join(", ")
    } else if !outcome.tools_without_parts.is_empty() {
        "nothing collides that has a part, and a tool has none (see below)".to_owned()
    } else if deepest > 0.0 {
        format!("nothing collides, but for what may touch the stock by at most {deepest:.3} mm (see below)")
    } else if outcome.stays_whole {
        "nothing collides, but rapids through the workpiece are not examined (see below)".to_owned()
    } else {
        "nothing collides".to_owned()
    }
}

/// Says of a tool in use that it has no part.
fn tool_without_part(tool: &u32) -> String {
    match tool {
        0 => "not examined: the tool with which the program feeds, for none is in the spindle; `tool` in [program] of scene.toml says which is there at first".to_owned(),
        tool => format!("not examined: tool {tool}, which has no part in the scene, or only a holder"),
    }
}

/// What the answer says nothing about, a line each.
pub(super) fn not_examined(scene: &Scene, run: &ProgramRun, outcome: &Outcome) -> Vec<String> {
    let unknown = run.program.notes.iter().filter(|note| note.is_unknown).map(|note| format!("not examined: {note}"));
    unknown.chain(not_examined_of_scene(scene, outcome)).collect()
}

/// The lines of [`not_examined`] that follow from the scene, without those from the notes on the program.
fn not_examined_of_scene(scene: &Scene, outcome: &Outcome) -> Vec<String> {
    let touches = outcome.touches.iter().map(|touch| stock::touch(scene, touch));
    let tools = outcome.tools_without_parts.iter().map(tool_without_part);
    let others = stock::not_examined(scene, outcome).into_iter().chain(not_examined_of_parts(scene, outcome));
    let dropped = outcome.decisions.iter().filter_map(|decision| match &decision.dropped {
        Some(why @ (Dropped::Ignored | Dropped::Allowed)) => Some(format!("{}, {why}", scene.pair_name(decision.pair))),
        _ => None,
    });
    let is_neighbours = |decision: &&Decision| matches!(decision.dropped, Some(Dropped::Neighbours { .. }));
    let neighbours = outcome.decisions.iter().filter(is_neighbours).count();
    let neighbours = (neighbours > 0).then(|| {
        format!("{neighbours} pairs of the machine's structure with one joint between them (`bvbench scene pairs`)")
    });
    let others = others.chain(dropped).chain(neighbours).map(|what| format!("not examined: {what}"));
    touches.chain(tools).chain(others).collect()
}

/// What is said of a part, by its name.
type Tell = fn(&str, &Part) -> String;

/// What is not known of parts that are open, thin or turn.
fn not_examined_of_parts(scene: &Scene, outcome: &Outcome) -> Vec<String> {
    let of_parts: [(&[usize], Tell); 6] = [
        (&outcome.open_cutters, |name, _| {
            format!(
                "what `{name}` cuts, whose mesh is not watertight; nothing is taken away for sure, and rapids where it has cut are unresolved"
            )
        }),
        (&outcome.thin_cutters, |name, _| {
            format!(
                "gouges by `{name}`, which is so thin that no depth in it is 0.05 mm above `gouge_mm`; between samples they may be missed, except where its middle is inside"
            )
        }),
        (&outcome.as_drawn, |name, part| {
            let why = match part.turns {
                None if part.role == Role::Workpiece => {
                    "a link that the spindle turns, with axis C, says about which axis it does"
                }
                None => "`turns` of the part says what turns it",
                Some(_) => "about which axis it turns is not known",
            };
            format!(
                "what `{name}` passes as it turns; it is not round, and stands as drawn; {why} (docs/check.md, What turns)"
            )
        }),
        (&outcome.unsure, |name, _| {
            format!(
                "which axis `{name}` turns about, its own or the spindle's; what only one of them would cut or meet is unresolved (`turns` of the part says which)"
            )
        }),
        (&outcome.driven, |name, _| {
            format!(
                "what `{name}` cuts if it stands while the workpiece turns; it is taken as driven (`turns = \"none\"` of the part says that it stands, `\"own\"` that it is driven)"
            )
        }),
        (&outcome.open_parts, |name, _| {
            format!("what lies wholly inside `{name}`, whose mesh is not watertight (`bvbench scene info` says where)")
        }),
    ];
    let told = |part: usize, tell: Tell| tell(&scene.parts[part].name, &scene.parts[part]);
    of_parts.iter().flat_map(|(parts, tell)| parts.iter().map(move |&part| told(part, *tell))).collect()
}

/// What happens at a line, in its tone.
fn painted(text: &str) -> String {
    let tones = [
        ("COLLISION", Tone::Bad),
        ("RAPID INTO WORKPIECE", Tone::Bad),
        ("TOOL CHANGE INTO WORKPIECE", Tone::Bad),
        ("STOPPED SPINDLE INTO WORKPIECE", Tone::Bad),
        ("GOUGE", Tone::Bad),
        ("UNRESOLVED", Tone::Bad),
        ("OVER-TRAVEL", Tone::Bad),
        ("NEAR MISSES", Tone::Doubtful),
    ];
    style::painted(text, &tones, style::is_coloured())
}

/// Collisions and over-travel, by time.
fn table(scene: &Scene, events: &[&Event], over_travel: &[OverTravel]) -> Table {
    let mut rows: Vec<(f64, [String; 7])> = Vec::new();
    for event in events {
        let inside = if event.inside { ", inside" } else { "" };
        let what = event.kind.name().replace('-', " ").to_uppercase() + inside;
        let last = if event.to_the_end { "never".to_owned() } else { format!("line {}", event.last.line) };
        let row = [
            event.first.line.to_string(),
            what,
            scene.pair_name(event.pair),
            clock(event.first.time_s),
            last,
            format!("{:.3}", event.least_mm),
            event.nearest.line.to_string(),
        ];
        rows.push((event.first.time_s, row));
    }
    for over in over_travel {
        let (line, axis) = (over.line.to_string(), format!("axis {}", over.cause.axis));
        let what = "OVER-TRAVEL".to_owned();
        rows.push((over.time_s, [line.clone(), what, axis, clock(over.time_s), String::new(), String::new(), line]));
    }
    rows.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut table = style::table(&[">LINE", "WHAT", "PARTS", "TIME", "CONTACT ENDS", ">LEAST mm", ">AT LINE"]);
    for (_, row) in rows {
        table.add_row(row);
    }
    table
}

/// The events of each pair that comes near, in the widest zone that it enters, and that zone, mm. What leads to a collision is told there.
fn near_pairs<'a>(near: &[&'a Event], collisions: &[&Event]) -> Vec<(Vec<&'a Event>, f64)> {
    let leads_to_collision = |event: &Event| {
        let is_in = |hit: &&Event| {
            hit.pair == event.pair && event.first.place <= hit.first.place && hit.first.place <= event.last.place
        };
        collisions.iter().any(is_in)
    };
    // Widest zone first: its events are the episodes, and the least of an episode is theirs.
    let mut pairs: Vec<(Vec<&Event>, f64)> = Vec::new();
    for &event in near.iter().filter(|event| !leads_to_collision(event)) {
        let Kind::Near { zone_mm } = event.kind else { continue };
        match pairs.iter_mut().find(|(events, _)| events[0].pair == event.pair) {
            Some((events, zone)) if *zone == zone_mm => events.push(event),
            Some((events, zone)) if *zone < zone_mm => (*events, *zone) = (vec![event], zone_mm),
            Some(_) => {}
            None => pairs.push((vec![event], zone_mm)),
        }
    }
    pairs
}

/// Pairs that come near, a line each.
fn near_misses(scene: &Scene, pairs: &[(Vec<&Event>, f64)]) -> Table {
    let mut table = style::table(&["NEAR MISSES", ">TIMES", ">WITHIN mm", ">LEAST mm", ">AT LINE", "AT TIME"]);
    for (events, zone_mm) in pairs {
        let Some(least) = events.iter().min_by(|a, b| a.least_mm.total_cmp(&b.least_mm)) else { continue };
        table.add_row([
            scene.pair_name(least.pair),
            events.len().to_string(),
            zone_mm.to_string(),
            format!("{:.3}", least.least_mm),
            least.nearest.line.to_string(),
            clock(least.nearest.time_s),
        ]);
    }
    table
}

/// Minutes and seconds.
fn clock(seconds: f64) -> String {
    // Rounded before it is split: 59.996 s is a minute.
    let hundredths = (seconds * 100.0).round();
    format!("{}:{:05.2}", (hundredths / 6000.0).floor(), hundredths % 6000.0 / 100.0)
}

/// Axes that the position has moved, mm and degrees.
fn axes(extent: &Extent) -> String {
    let told = Axis::ALL.into_iter().filter(|&axis| extent.position[axis] != 0.0 || axis as usize <= Axis::Z as usize);
    told.map(|axis| format!("{}{:.3}", axis.letter(), shown(&extent.position, axis))).collect::<Vec<_>>().join(" ")
}

fn extent_json(extent: &Extent) -> Value {
    json!({ "line": extent.line, "fraction": extent.fraction, "time_s": extent.time_s, "rapid": extent.rapid, "position": by_letter(|axis| shown(&extent.position, axis)) })
}

fn over_travel_json(over: &OverTravel) -> Value {
    let OutOfLimits { axis, value, min, max, unit } = &over.cause;
    let finite = |limit: &f64| limit.is_finite().then_some(*limit);
    json!({
        "line": over.line, "block": over.block, "time_s": over.time_s, "axis": axis, "value": value,
        "min": finite(min), "max": finite(max), "unit": unit,
    })
}

fn as_json(scene: &Scene, run: &ProgramRun, variant: &Variant, outcome: &Outcome, times: &Times) -> Value {
    let name = |part: usize| scene.parts[part].name.clone();
    let names = |parts: &[usize]| parts.iter().map(|&part| name(part)).collect::<Vec<_>>();
    let events = outcome.events.iter().map(|event| {
        let zone = if let Kind::Near { zone_mm } = event.kind { Some(zone_mm) } else { None };
        json!({
            "kind": event.kind.name(), "zone_mm": zone, "line": event.first.line, "block": event.block,
            "pair": [name(event.pair.a), name(event.pair.b)], "least_mm": event.least_mm, "depth_mm": event.depth_mm, "inside": event.inside, "to_the_end": event.to_the_end,
            "first": extent_json(&event.first), "last": extent_json(&event.last), "nearest": extent_json(&event.nearest),
        })
    });
    let notes = run.program.notes.iter().map(
        |note| json!({ "line": note.line, "more": note.more, "not_examined": note.is_unknown, "text": note.text }),
    );
    json!({
        "scene": scene.name, "program": run.file.to_string_lossy(), "dialect": run.setup.dialect.name(), "method": variant.info.id, "clear": outcome.is_clear(), "collides": outcome.collides(),
        "events": events.collect::<Vec<_>>(), "notes": notes.collect::<Vec<_>>(), "duration_s": outcome.duration_s, "samples": outcome.samples,
        "queries": outcome.queries, "load_s": times.load_s, "trees_s": times.trees_s, "elapsed_s": times.check_s,
        "poses_per_s": times.poses_per_s(outcome),
        "over_travel": outcome.over_travel.iter().map(over_travel_json).collect::<Vec<_>>(),
        "tools_without_parts": outcome.tools_without_parts, "mesh_warnings": scene.mesh_warnings(),
        "open_parts": names(&outcome.open_parts),
        "thin_cutters": names(&outcome.thin_cutters),
        "parts_unsure": names(&outcome.unsure), "cutters_taken_as_driven": names(&outcome.driven),
        "parted_workpieces": outcome.remaining.iter().filter(|remaining| remaining.is_parted).map(|remaining| name(remaining.part)).collect::<Vec<_>>(),
        "parts_as_drawn": names(&outcome.as_drawn),
        "pairs_not_examined": outcome.decisions.iter().filter_map(|decision| {
            let why = decision.dropped.as_ref()?.to_string();
            Some(json!({ "pair": [name(decision.pair.a), name(decision.pair.b)], "why": why }))
        }).collect::<Vec<_>>(),
    })
}

/// The columns of `--csv` before those of the axes and the block.
const CSV_COLUMNS: &str = "kind,zone_mm,a,b,first_line,first_time_s,last_line,last_time_s,least_mm,least_line,inside,to_the_end,depth_least_mm,depth_most_mm";

fn as_csv(checked: &Checked<'_>) -> Result<String> {
    let Checked { scene, outcome, .. } = checked;
    let mut writer = csv::Writer::from_writer(Vec::new());
    let axes = Axis::ALL
        .map(|axis| format!("{}_{}", axis.letter().to_ascii_lowercase(), if axis.is_rotary() { "deg" } else { "mm" }));
    let columns = CSV_COLUMNS.split(',').map(str::to_owned);
    let header: Vec<String> = columns.chain(axes).chain(["block".to_owned()]).collect();
    writer.write_record(&header)?;
    for event in &outcome.events {
        let zone = if let Kind::Near { zone_mm } = event.kind { zone_mm.to_string() } else { String::new() };
        let mut row = vec![
            event.kind.name().to_owned(),
            zone,
            scene.parts[event.pair.a].name.clone(),
            scene.parts[event.pair.b].name.clone(),
            event.first.line.to_string(),
            event.first.time_s.to_string(),
            event.last.line.to_string(),
            event.last.time_s.to_string(),
            event.least_mm.to_string(),
            event.nearest.line.to_string(),
            event.inside.to_string(),
            event.to_the_end.to_string(),
        ];
        row.extend([0, 1].map(|end| event.depth_mm.map_or(String::new(), |depth| depth[end].to_string())));
        row.extend(Axis::ALL.map(|axis| shown(&event.first.position, axis).to_string()));
        row.push(event.block.clone());
        writer.write_record(&row)?;
    }
    for finding in findings::findings(checked).iter().filter(|finding| finding.pair.is_none()) {
        let (line, time) = (finding.line.to_string(), finding.time_s.map(|time_s| time_s.to_string()));
        let mut row = vec![String::new(); header.len()];
        for (column, value) in [
            ("kind", finding.rule.id),
            ("a", &finding.subject),
            ("first_line", &line),
            ("first_time_s", time.as_deref().unwrap_or_default()),
            ("block", finding.block),
        ] {
            if let Some(at) = header.iter().position(|name| name == column) {
                row[at] = value.to_owned();
            }
        }
        writer.write_record(&row)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

#[cfg(test)]
mod tests {
    use super::clock;

    #[test]
    fn the_clock_has_no_sixtieth_second() {
        let shown = [0.0, 59.994, 59.996, 60.0, 3599.999, 61.5].map(clock);
        assert_eq!(shown, ["0:00.00", "0:59.99", "1:00.00", "1:00.00", "60:00.00", "1:01.50"]);
    }
}
