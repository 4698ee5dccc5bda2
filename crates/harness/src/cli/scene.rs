//! `scene`: new scenes from mesh files, what a scene holds, which of its parts can collide, its meshes as files, and where its axes tilt the tool.

mod inverse;
mod new;

use super::options::{ClearanceOptions, make_folder};
use super::subject::{Subject, refuse_output};
use super::{CLEAR, note, picture, say, style, surfaces};
use crate::check;
use crate::geometry::import;
use crate::machine::Joint;
use crate::record::file::write_bytes;
use crate::scene::extents::Extents;
use crate::scene::pairs::{self, Reach};
use crate::scene::{Part, Scene, Turns};
use crate::view::glb;
use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand, ValueEnum};
use comfy_table::{ContentArrangement, Table};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench scene new shop --machine mill --part table.stl:machine:X --part vise.stl:fixture --part head.stl:machine:Z\n  bvbench scene info lathe-toolpost\n  bvbench scene pairs path/to/machine part.ngc --json\n  bvbench scene export lathe-tailstock --out meshes\n  bvbench scene export mill-vise --out mill.glb\n  bvbench scene inverse trunnion-impeller --direction 0.5,0,0.866\n  bvbench scene picture trunnion-impeller --program-line 60 --out impeller.png"
)]
pub struct Options {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Make a scene folder from mesh files: kind of machine, roles, spindle
    New(new::Options),
    /// Links, joints, limits, parts with their extents and surfaces, and program
    Info(SceneOptions),
    /// Which pairs of parts are examined, and why the others are not
    Pairs(PairOptions),
    /// Write every part as binary STL, placed where the machine stands at first; or the machine and its motion as GLB
    Export(ExportOptions),
    /// Where the rotary axes must be for the tool to have a direction: both solutions
    Inverse(inverse::Options),
    /// Draw the machine as it stands at first, or at a line of its program
    Picture(picture::Options),
}

#[derive(Args)]
struct SceneOptions {
    /// Scene by name or by path
    #[arg(value_name = "SCENE")]
    scene: String,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct PairOptions {
    #[command(flatten)]
    subject: Subject,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    clearance: ClearanceOptions,
}

#[derive(Args)]
struct ExportOptions {
    /// Scene by name or by path
    #[arg(value_name = "SCENE")]
    scene: String,
    /// stl: a file per part; glb: one file, with the machine's links as nodes and its program as animation [default: that of the ending .glb, else stl]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// Folder for the files; for GLB, the file or its folder
    #[arg(long, value_name = "DIR|FILE.glb")]
    out: PathBuf,
}

impl ExportOptions {
    /// Whether the output is a GLB file by its ending.
    fn names_glb(&self) -> bool {
        self.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("glb"))
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Stl,
    Glb,
}

pub fn run(options: &Options) -> Result<u8> {
    match &options.what {
        What::New(options) => return new::run(options),
        What::Info(options) => info(&Scene::find(&options.scene)?, options.json)?,
        What::Pairs(options) => show_pairs(options)?,
        What::Inverse(options) => inverse::run(options)?,
        What::Export(options) => match (options.format, options.names_glb()) {
            (Some(Format::Stl), true) => bail!(
                "--out {}: STL is a file for each part; name a folder, or leave --format stl out",
                options.out.display()
            ),
            (Some(Format::Glb), _) | (None, true) => export_glb(options)?,
            (Some(Format::Stl) | None, false) => export_stl(options)?,
        },
        What::Picture(options) => picture::run(&Scene::find(options.scene())?, options)?,
    }
    Ok(CLEAR)
}

pub(super) fn table<S: AsRef<str>>(header: impl IntoIterator<Item = S>) -> Table {
    let mut table = style::plain(header);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    if table.width().is_none() {
        table.set_width(100);
    }
    table
}

/// Writes those files of a scene's folder that it does not have as they are, scene.toml last: it makes the folder a scene.
pub(super) fn write_folder(folder: &Path, mut files: BTreeMap<String, Vec<u8>>) -> Result<()> {
    files.retain(|name, bytes| fs::read(folder.join(name)).ok().as_ref() != Some(&*bytes));
    let (scene, others): (Vec<_>, Vec<_>) = files.iter().partition(|(name, _)| *name == "scene.toml");
    Ok(others.into_iter().chain(scene).try_for_each(|(name, bytes)| write_bytes(&folder.join(name), bytes))?)
}

fn link_name(scene: &Scene, link: Option<usize>) -> &str {
    link.map_or("world", |link| &scene.machine.links()[link].name)
}

/// A limit of a joint in mm or degrees, to the digits a scene file has.
fn limit(joint: &Joint, value: f64) -> f64 {
    ((if joint.turns() { value.to_degrees() } else { value }) * 1e9).round() / 1e9
}

fn info_json(scene: &Scene) -> Value {
    let poses = scene.poses_at_start();
    let links = scene.machine.links().iter().map(|link| {
        let joint = link.joint.as_ref().map(|joint| {
            let kind = if joint.turns() { "rotary" } else { "prismatic" };
            let bound = |value: f64| value.is_finite().then(|| limit(joint, value));
            json!({ "axis": joint.axis.letter().to_string(), "kind": kind, "min": bound(joint.limits.min), "max": bound(joint.limits.max) })
        });
        json!({ "name": link.name, "parent": link.parent, "joint": joint })
    });
    let parts = scene.parts.iter().enumerate().map(|(index, part)| {
        let Extents { low, high } = scene.extents(index, &poses);
        let surface = part.mesh.surface_report();
        json!({
            "name": part.name, "link": link_name(scene, part.link), "role": part.role.name(), "tool": part.tool,
            "turns": part.turns.map(Turns::name), "triangles": part.mesh.faces().len(),
            "vertices": part.mesh.vertices().len(), "watertight": surface.leaking == 0,
            "low_mm": low.coords.as_slice(), "high_mm": high.coords.as_slice(),
            "surface": surfaces::json(scene, &part.name, &surface),
        })
    });
    let program = scene.program.as_ref().map(
        |run| json!({ "file": run.file.to_string_lossy(), "lines": run.program.blocks.len(), "moves": run.program.moves.len() }),
    );
    json!({
        "name": scene.name, "title": scene.title, "links": links.collect::<Vec<_>>(), "parts": parts.collect::<Vec<_>>(),
        "program": program, "inputs": scene.inputs, "warnings": scene.mesh_warnings(),
    })
}

fn info(scene: &Scene, as_json: bool) -> Result<()> {
    if as_json {
        say(serde_json::to_string_pretty(&info_json(scene))?);
        return Ok(());
    }
    say(format!("{}: {}\n", scene.name, scene.title));
    if !scene.machine.links().is_empty() {
        let mut links = table(["LINK", "STANDS ON", "AXIS", "MOVES", "LIMITS"]);
        for link in scene.machine.links() {
            let (axis, moves, range) = link.joint.as_ref().map_or_else(Default::default, |joint| {
                let (moves, unit) = if joint.turns() { ("turns", "degrees") } else { ("slides", "mm") };
                let [min, max] = [joint.limits.min, joint.limits.max].map(|value| limit(joint, value));
                let range = if min.is_finite() || max.is_finite() {
                    format!("{min} to {max} {unit}")
                } else {
                    "none".to_owned()
                };
                (joint.axis.letter().to_string(), moves, range)
            });
            links.add_row([link.name.as_str(), link.parent.as_deref().unwrap_or("world"), &axis, moves, &range]);
        }
        say(format!("{}\n", links.trim_fmt()));
    }
    let mut parts = table(["PART", "ON", "ROLE", "TOOL", ">TRIANGLES"]);
    for part in &scene.parts {
        let (tool, triangles) = (part.tool.map(|tool| tool.to_string()), part.mesh.faces().len().to_string());
        let turns = part.turns.map(|turns| format!(", turns = {}", turns.name())).unwrap_or_default();
        let (link, role) = (link_name(scene, part.link), format!("{}{turns}", part.role.name()));
        parts.add_row([&part.name, link, &role, tool.as_deref().unwrap_or("-"), &triangles]);
    }
    say(format!("{}\n", parts.trim_fmt()));
    say(format!("{}\n", extents_table(scene).trim_fmt()));
    say(surfaces::text(scene));
    for warning in scene.mesh_warnings() {
        note(format!("warning: {warning}"));
    }
    if let Some(run) = &scene.program {
        for told in scene.tool_notes(&run.setup.tools) {
            note(format!("note: {told}"));
        }
        let (lines, moves) = (run.program.blocks.len(), run.program.moves.len());
        say(format!("\nprogram {}: {lines} lines, {moves} moves", run.file.display()));
    }
    Ok(())
}

/// Where the parts are when the machine stands as at first, and all of them together.
fn extents_table(scene: &Scene) -> Table {
    let poses = scene.poses_at_start();
    let mut rows = table(["PART", "SIZE mm", "X", "Y", "Z"]);
    let row = |name: &str, extents: &Extents| {
        let size = extents.size().map(|size| format!("{size:.1}")).join(" x ");
        let range = |axis: usize| format!("{:.1} to {:.1}", extents.low[axis], extents.high[axis]);
        [name.to_owned(), size, range(0), range(1), range(2)]
    };
    let all: Vec<Extents> = (0..scene.parts.len()).map(|part| scene.extents(part, &poses)).collect();
    for (part, extents) in scene.parts.iter().zip(&all) {
        rows.add_row(row(&part.name, extents));
    }
    if let Some(whole) = all.into_iter().reduce(|all, one| all.with(&one)) {
        rows.add_row(row("all together", &whole));
    }
    rows
}

fn show_pairs(options: &PairOptions) -> Result<()> {
    let (scene, run) = options.subject.load()?;
    let scene = &scene;
    let path = run.as_ref().map(|run| check::Path::new(scene, run)).transpose()?;
    let reach = path.map_or_else(|| Reach::of_limits(scene), |path| path.reach());
    let asked = options.clearance.read(scene)?;
    let decisions = pairs::decide(scene, &reach, asked.as_ref().unwrap_or(&scene.clearances));
    if options.json {
        let pair = |decision: &pairs::Decision| {
            let reason = decision.dropped.as_ref().map(ToString::to_string);
            let names = [decision.pair.a, decision.pair.b].map(|part| scene.parts[part].name.clone());
            json!({ "pair": names, "kept": decision.dropped.is_none(), "reason": reason })
        };
        say(serde_json::to_string_pretty(&decisions.iter().map(pair).collect::<Vec<_>>())?);
        return Ok(());
    }
    let mut rows = table(["PAIR", "EXAMINED", "WHY NOT"]);
    let mut sorted: Vec<_> = decisions.iter().collect();
    sorted.sort_by_key(|decision| decision.dropped.is_some());
    for decision in sorted {
        let why = decision.dropped.as_ref().map(ToString::to_string).unwrap_or_default();
        rows.add_row([scene.pair_name(decision.pair), if why.is_empty() { "yes" } else { "no" }.to_owned(), why]);
    }
    say(rows.trim_fmt());
    let kept = decisions.iter().filter(|decision| decision.dropped.is_none()).count();
    say(format!("\n{kept} of {} pairs are examined", decisions.len()));
    Ok(())
}

/// Refuses to write over a file of the scene.
fn refuse_files(options: &ExportOptions, scene: &Scene, files: &[PathBuf]) -> Result<()> {
    let read = || scene.files.iter().map(PathBuf::as_path);
    files.iter().try_for_each(|file| refuse_output("--out", file, &options.scene, read()))
}

fn export_glb(options: &ExportOptions) -> Result<()> {
    let (scene, out) = (&Scene::find(&options.scene)?, &options.out);
    let file = if options.names_glb() { out.to_owned() } else { out.join(format!("{}.glb", scene.name)) };
    refuse_files(options, scene, std::slice::from_ref(&file))?;
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    }
    let content = glb::export(scene, scene.program.as_ref())?;
    fs::write(&file, &content).with_context(|| format!("cannot write {}", file.display()))?;
    say(format!("{} ({:.1} MB)", file.display(), content.len() as f64 * 1e-6));
    Ok(())
}

fn export_stl(options: &ExportOptions) -> Result<()> {
    let (scene, out) = (&Scene::find(&options.scene)?, &options.out);
    let file = |part: &Part| out.join(format!("{}.stl", part.name.replace(['/', '\\'], "-")));
    let files: Vec<PathBuf> = scene.parts.iter().map(file).collect();
    for (index, file) in files.iter().enumerate() {
        if let Some(twin) = files[..index].iter().position(|other| other == file) {
            let [one, other] = [twin, index].map(|part| &scene.parts[part].name);
            bail!("parts `{one}` and `{other}` would both be written to {}; rename one", file.display());
        }
    }
    refuse_files(options, scene, &files)?;
    make_folder("--out", out)?;
    let start = scene.program.as_ref().map(|run| run.start).unwrap_or_default();
    let poses = scene.machine.forward(&start);
    for (index, (part, file)) in scene.parts.iter().zip(&files).enumerate() {
        let world_from_part = scene.world_from_part(index, &poses);
        let triangles =
            part.mesh.triangles().into_iter().map(|triangle| triangle.map(|corner| world_from_part * corner));
        let triangles: Vec<_> = triangles.collect();
        let written =
            File::create(file).and_then(|file| import::write_stl_triangles(&triangles, &mut BufWriter::new(file)));
        written.with_context(|| format!("cannot write {}", file.display()))?;
        say(format!("{} ({} triangles)", file.display(), triangles.len()));
    }
    Ok(())
}
