//! `try`: a scene or meshes of one's own through every stage, on a page about them and not about the paper.

use super::options::{Extent, OutputOptions, open_run};
use super::progress::Bar;
use super::{CLEAR, FAILED, analyze, conclusion, launch, say, scene, style, verify};
use crate::analysis::claims::ClaimSet;
use crate::measure::Plan;
use crate::record::manifest::Stage;
use crate::registry::Registry;
use crate::scene::{LARGEST_FILE, Overrides, Scene};
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench try my-machine                       a folder with a scene.toml (docs/format.md), or the name of a shipped scene\n  bvbench try fixture.stl arm.ply poses.csv    meshes, and the poses at which they are compared\n  bvbench try my-machine --profile smoke --variant ID --variant ID\n\nThe first row of the pose file names its columns: part,qw,qx,qy,qz,tx,ty,tz. Each row behind it is a pose (mm), and part is a mesh's file name\nwithout its ending; a mesh that is not named stays where its file has it.\n\nAn interrupted run goes on where it stopped when the same command is given again; a finished one is shown as it is, or made again where another program made it.\n\nExit code 1 when a safe variant misses a contact."
)]
pub struct Options {
    /// A scene, by name or folder; or two or more mesh files and a pose file (CSV)
    #[arg(value_name = "PATH", required = true, num_args = 1..)]
    paths: Vec<String>,
    #[command(flatten)]
    extent: Extent,
    #[command(flatten)]
    output: OutputOptions,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    let names: Vec<String> = options.paths.iter().map(|path| file_stem(path)).collect();
    let folder = options.extent.folder(&format!("try-{}", names.join("-")));
    let (extent, mut made) = (&options.extent, None);
    let plan = match options.paths.as_slice() {
        [scene] if !is_mesh(scene) => extent.plan_of(scene, || Ok(Scene::find(scene)?), registry)?,
        files => {
            let scene = made.insert(MadeScene::of(files, &folder)?);
            extent.plan_of(&scene.folder.to_string_lossy(), || scene.load(), registry)?
        }
    };
    let title = plan.scenes.first().map_or_else(String::new, |scene| scene.title.clone());
    let claims = ClaimSet::none(&title, baseline(&plan)?);
    let mut run = open_run(plan, &folder, &extent.cache_folder(&folder), extent.fresh)?;
    // The run's folder is locked, and its run is this one: nothing is refused any more.
    if let Some(MadeScene { folder, files, .. }) = made {
        scene::write_folder(&folder, files)?;
    }
    let bar = Bar::new(options.output.quiet);
    // A finished run of another program says nothing of this one, so it is made again.
    let is_anothers = run.has_finished(Stage::Measure) && !run.is_own();
    let is_verified = run.has_finished(Stage::Verify) && !is_anothers;
    let verification = if is_verified { run.verification()? } else { run.verify(&bar)? };
    if !run.has_finished(Stage::Measure) {
        launch::measure(&mut run, &extent.cache_folder(&folder), &bar)?;
    }
    run.manifest().check_rows(&folder)?;
    let (outcome, gallery, report, page) = analyze::finish(&mut run, &claims, registry, &bar)?;
    if options.output.json {
        let result = json!({
            "out": folder.to_string_lossy(), "report": report.to_string_lossy(), "page": page.to_string_lossy(),
            "answer": crate::report::answer(&crate::report::Contents::read(&folder)?),
            "verification": verify::as_json(&verification), "ranking": outcome.ranking, "analysis": analyze::as_json(&outcome),
        });
        say(serde_json::to_string_pretty(&result)?);
    } else {
        say(verify::verdict(&verification));
        say(format!("\n{title}\n"));
        say(conclusion::text(&crate::report::Contents::read(&folder)?, style::is_coloured()));
        say(format!("\nLook next at\n  {}   the page: charts, with the CSV row behind every mark", page.display()));
        say(format!("  {}     the same to read, with {} figures", report.display(), gallery.figures.len()));
    }
    Ok(if verification.holds() { CLEAR } else { FAILED })
}

/// The variant that the others are compared with: the reference where the run has it.
fn baseline(plan: &Plan) -> Result<&str> {
    let first = || plan.variants.iter().find(|variant| variant.info.safe).map(|variant| variant.info.id);
    let null_of = plan.null_reference().map(|case| case.id.as_str());
    null_of.or_else(first).context("none of the variants is safe, so there is none to compare the others with")
}

/// A file's or folder's name without its ending; that of the folder meant where the path ends in `.` or `..`.
fn stem(path: &str) -> String {
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let real = || stem(&fs::canonicalize(path).ok()?);
    stem(Path::new(path)).or_else(real).unwrap_or_else(|| "scene".to_owned())
}

/// The same in letters that any file system takes.
fn file_stem(path: &str) -> String {
    stem(path).chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}

/// Whether a file's name is that of a mesh or of poses, and not of a scene.
fn is_mesh(path: &str) -> bool {
    let ending = Path::new(path).extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    ending.is_some_and(|ending| ["stl", "obj", "off", "ply", "glb", "3mf", "csv"].contains(&ending.as_str()))
}

/// First line of a scene that was made here, which may be made again.
const MADE: &str = "# Made by `bvbench try` from the files beside it.\n";

/// Whether a folder is free for the files of a scene: one that is not there, one that was made here, or what a killed run has begun with these files.
fn is_ours(folder: &Path, files: &BTreeMap<String, Vec<u8>>) -> bool {
    if let Ok(text) = fs::read_to_string(folder.join("scene.toml")) {
        return text.starts_with(MADE);
    }
    let Ok(entries) = fs::read_dir(folder) else { return !folder.exists() };
    let is_begun = |name: &str| files.contains_key(name.strip_suffix(".partial").unwrap_or(name));
    entries.flatten().all(|entry| entry.file_name().to_str().is_some_and(is_begun))
}

/// A scene of meshes and poses, to be written beside the folder of a run.
struct MadeScene {
    folder: PathBuf,
    /// The pose file as it was named.
    poses: String,
    /// The files of the folder, by name.
    files: BTreeMap<String, Vec<u8>>,
}

impl MadeScene {
    /// Reads the files, and writes none.
    fn of(files: &[String], run: &Path) -> Result<Self> {
        let (poses, meshes): (Vec<&String>, Vec<&String>) =
            files.iter().partition(|file| Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")));
        let [poses] = poses.as_slice() else {
            bail!(
                "meshes need one pose file (.csv), and {} of the paths are; one scene is tried at a time, `bvbench repro --scene A --scene B` runs several",
                poses.len()
            );
        };
        ensure!(meshes.len() >= 2, "two meshes at least are needed, and {} of the paths are", meshes.len());
        let folder = PathBuf::from(format!("{}-scene", run.display()));
        let bytes = |file: &str| rs274::file::bytes(Path::new(file), LARGEST_FILE);
        let read = |file: &str| bytes(file).with_context(|| format!("cannot read {file}"));
        let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::from([("poses.csv".to_owned(), read(poses)?)]);
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let names = meshes.iter().map(|mesh| stem(mesh)).collect::<Vec<_>>();
        let title = format!("{} at the poses of {}", names.join(" against "), stem(poses));
        let mut text = format!("{MADE}title = {}\n", quoted(&title));
        for (mesh, name) in meshes.iter().zip(&names) {
            let ending = Path::new(mesh).extension().map_or_else(String::new, |e| format!(".{}", e.to_string_lossy()));
            let file = format!("{}{ending}", file_stem(mesh));
            ensure!(!files.contains_key(&file), "{mesh}: another of the files would be named {file}, too; rename one");
            files.insert(file.clone(), read(mesh)?);
            text += &format!("\n[[parts]]\nname = {}\nmesh = {}\n", quoted(name), quoted(&file));
        }
        text += "\n[recorded]\nfile = \"poses.csv\"\n";
        files.insert("scene.toml".to_owned(), text.into_bytes());
        ensure!(
            is_ours(&folder, &files),
            "{} exists and was not made by `bvbench try`; name another folder with --out",
            folder.display()
        );
        Ok(Self { folder, poses: (*poses).clone(), files })
    }

    /// Loads it from memory, by the name that it has in its folder.
    fn load(&self) -> Result<Scene> {
        let real = self.folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
        let name = real.file_name().unwrap_or_default().to_string_lossy();
        let scene = Scene::from_memory(&name, self.files.clone(), &Overrides::default());
        scene.with_context(|| format!("no scene can be made of {} and the meshes (named as their copies)", self.poses))
    }
}
