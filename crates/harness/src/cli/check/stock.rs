//! What `check` tells of the workpiece: depths, touches, what is left, and how that compares with the wanted part.

use super::super::note;
use super::StockOptions;
use crate::check::{Event, Outcome, Touch};
use crate::geometry::Mesh;
use crate::geometry::import::{self, FileInUnit};
use crate::scene::{Part, Scene};
use crate::stock::export::Volume;
use crate::stock::target::{Comparison, Deviation};
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

/// What is left of a workpiece.
pub struct Left {
    pub part: usize,
    /// Depth to which contact is not told from touching, mm.
    resolution_mm: f64,
    /// Measured only where the stock is divided anyway: its cells along cuts wait for questions.
    volume: Option<Volume>,
    /// Bytes of its cells.
    bytes: usize,
    /// Cells that were held against what moves.
    questions: u64,
    /// Line from which on nothing was cut any more.
    given_up: Option<u32>,
    pub comparison: Option<Comparison>,
    /// The file it was written to, and the side of the mesh's cubes, mm.
    written: Option<(String, f64)>,
}

/// How deep an event is, in words; `None` where the stock has no part in it.
pub fn depth(event: &Event) -> Option<String> {
    let [low, high] = event.depth_mm?;
    Some(match low {
        _ if high == f64::INFINITY => "not examined: the work that a stock may take is spent".to_owned(),
        low if low > 0.0 => format!("{low:.2} to {high:.2} mm deep in the stock"),
        _ => format!("not excluded: up to {high:.2} mm deep in the stock"),
    })
}

/// What may touch the stock, in a line.
pub fn touch(scene: &Scene, touch: &Touch) -> String {
    let moves = if touch.moves == 1 { "1 move".to_owned() } else { format!("{} moves", touch.moves) };
    format!(
        "not decided: whether {} touch in {moves}, first on line {}: by at most {:.3} mm, within the stock's resolution",
        scene.pair_name(touch.pair),
        touch.line,
        touch.at_most_mm
    )
}

/// What is not known of the workpieces.
pub fn not_examined(scene: &Scene, outcome: &Outcome) -> Vec<String> {
    let name = |part: usize| &scene.parts[part].name;
    let uncut = outcome.uncut.iter().map(|&part| {
        let why = why_uncut(&scene.parts[part]);
        format!("what is cut away from `{}`, since {why}; what comes after the first cut is unresolved", name(part))
    });
    let whole = outcome.stays_whole.then(|| {
        "what is cut away (`--stock-resolution none`); a rapid that begins inside the workpiece is taken for a retreat"
            .to_owned()
    });
    let given_up = outcome.remaining.iter().filter_map(|remaining| {
        let (name, line) = (name(remaining.part), remaining.given_up?);
        Some(format!("contact with `{name}` from line {line} on: cutting it takes too much work; a coarser `--stock-resolution` takes less"))
    });
    let parted = outcome.remaining.iter().filter(|remaining| remaining.is_parted).map(|remaining| {
        let name = name(remaining.part);
        format!("where the pieces go into which the program parts `{name}`; all are taken to stay where they are cut")
    });
    uncut.chain(whole).chain(given_up).chain(parted).collect()
}

impl StockOptions {
    /// Reads the wanted part.
    pub fn target(&self) -> Result<Option<Arc<Mesh>>> {
        let Some(FileInUnit { path, unit }) = &self.target else { return Ok(None) };
        let imported = import::load(path, *unit).with_context(|| format!("--target {}", path.display()))?;
        Ok(Some(Arc::new(imported.mesh)))
    }

    /// Measures, compares and writes what is left.
    pub fn left(&self, scene: &Scene, outcome: &mut Outcome, target: Option<&Arc<Mesh>>) -> Result<Vec<Left>> {
        let wants_one = self.stock_out.is_some() || target.is_some();
        if wants_one && outcome.remaining.len() != 1 {
            let count = outcome.remaining.len();
            bail!(
                "--stock-out and --target need exactly one workpiece that is cut, and this check has {count}: a part with \
                `role = \"workpiece\"`, a watertight mesh, a cutter, and no `gouge_mm`"
            );
        }
        let mut all = Vec::new();
        for remaining in &mut outcome.remaining {
            if let Some(line) = remaining.given_up.filter(|_| wants_one) {
                bail!(
                    "--stock-out and --target: the stock was given up at line {line}; a coarser --stock-resolution takes less work"
                );
            }
            let stock = &mut remaining.stock;
            let comparison = target.map(|target| stock.compare(target)).transpose().context("--target")?;
            let written = self.stock_out.as_deref().map(|file| {
                let hull = stock.hull();
                match &hull.mesh {
                    Some(mesh) => write_stl(file, mesh)?,
                    None => {
                        note(format!("nothing is left of `{}`: no mesh is written", scene.parts[remaining.part].name));
                    }
                }
                anyhow::Ok((file.display().to_string(), hull.cube_mm))
            });
            let volume = wants_one.then(|| stock.volume());
            let (bytes, questions) = (stock.bytes(), stock.questions());
            let (resolution_mm, written, given_up) = (stock.resolution_mm(), written.transpose()?, remaining.given_up);
            let part = remaining.part;
            all.push(Left { part, resolution_mm, volume, bytes, questions, given_up, comparison, written });
        }
        Ok(all)
    }
}

impl Left {
    /// What is left, a line each.
    pub fn lines(&self, scene: &Scene) -> Vec<String> {
        let name = &scene.parts[self.part].name;
        let mut lines = vec![format!("`{name}` is cut: contact is told from a depth of {} mm on", self.resolution_mm)];
        lines.extend(self.volume.map(|Volume { low, high }| format!("left of `{name}`: {low:.0} to {high:.0} mm³")));
        lines.extend(self.comparison.iter().flat_map(|comparison| self.compared(comparison)));
        if let Some((file, cube_mm)) = &self.written {
            lines.push(format!("{file}: all that may be left of `{name}`, in cubes of {cube_mm:.3} mm"));
        }
        lines
    }

    /// Gouges, rests and what is missing, a line each.
    fn compared(&self, comparison: &Comparison) -> Vec<String> {
        let Comparison { gouge, rest, missing, surface } = comparison;
        let of = |what: &str, name: &str, Deviation { greatest_mm, at_most_mm, volume_mm3 }: &Deviation| {
            if *greatest_mm > 0.0 {
                format!("{what}: {greatest_mm:.3} mm deep, at least {volume_mm3:.1} mm³")
            } else if *at_most_mm > 0.0 {
                format!("{name}: not decided: up to {at_most_mm:.3} mm; another `--stock-resolution` may decide it")
            } else {
                format!("{name}: none deeper than {} mm", self.resolution_mm)
            }
        };
        let what = if missing.greatest_mm > 0.0 { "MISSING or GOUGE" } else { "GOUGE" };
        let lost = is_lost(comparison).then(|| format!("{what}, {}", lost(surface)));
        // A surface that lacks its material for sure is told by that.
        let of_surface_mm = if surface.greatest_mm > 0.0 { 0.0 } else { surface.at_most_mm };
        let may = Deviation { at_most_mm: gouge.at_most_mm.max(of_surface_mm), ..*gouge };
        let cut = (lost.is_none() || may.at_most_mm > 0.0).then(|| of("GOUGE, the wanted part is cut", "gouge", &may));
        let rest = of("rest, stock beyond the wanted part", "rest", rest);
        let what = "MISSING, the wanted part is larger than the uncut workpiece";
        let missing = (missing.at_most_mm > 0.0).then(|| of(what, "missing", missing));
        cut.into_iter().chain(lost).chain([rest]).chain(missing).collect()
    }
}

/// Whether the part's surface is farther from what may be left than gouges and missing material are deep: a wall or a boss is gone, or never was in the workpiece.
fn is_lost(Comparison { gouge, missing, surface, .. }: &Comparison) -> bool {
    surface.greatest_mm > gouge.greatest_mm.max(missing.greatest_mm)
}

fn lost(surface: &Deviation) -> String {
    format!("the wanted part's surface is {:.3} mm from all that may be left", surface.greatest_mm)
}

/// What the wanted part lacks or, where nothing is certain, may lack; `None` where it lacks nothing.
pub fn lacks(comparison: &Comparison) -> Option<String> {
    let Comparison { gouge, missing, surface, .. } = comparison;
    let certain = [("is cut", gouge), ("is larger than the uncut workpiece,", missing)];
    let certain = certain.iter().filter(|(_, lack)| lack.greatest_mm > 0.0).map(|(what, lack)| {
        format!("the wanted part {what} {:.3} mm deep, at least {:.1} mm³", lack.greatest_mm, lack.volume_mm3)
    });
    let told: Vec<String> = certain.chain(is_lost(comparison).then(|| lost(surface))).collect();
    let at_most_mm = gouge.at_most_mm.max(missing.at_most_mm).max(surface.at_most_mm);
    let may = || format!("not decided: whether the wanted part is cut or lacks stock, up to {at_most_mm:.3} mm deep");
    match told.is_empty() {
        true => (at_most_mm > 0.0).then(may),
        false => Some(told.join("; ")),
    }
}

/// Why nothing is taken away from a workpiece.
pub fn why_uncut(part: &Part) -> &'static str {
    if part.mesh.edge_report().is_watertight() {
        "nobody knows about which axis it turns"
    } else {
        "its mesh is not watertight (`bvbench scene info` says where)"
    }
}

/// The stock as data.
pub fn as_json(scene: &Scene, outcome: &Outcome, left: &[Left]) -> Value {
    let name = |part: usize| &scene.parts[part].name;
    let touches = outcome.touches.iter().map(|touch| {
        json!({
            "pair": [name(touch.pair.a), name(touch.pair.b)], "moves": touch.moves, "line": touch.line, "at_most_mm": touch.at_most_mm,
        })
    });
    let deviation = |of: &Deviation| json!({ "greatest_mm": of.greatest_mm, "at_most_mm": of.at_most_mm, "volume_mm3": of.volume_mm3 });
    let workpieces = left.iter().map(|left| {
        let comparison = left.comparison.as_ref().map(|comparison| {
            json!({
                "gouge": deviation(&comparison.gouge), "rest": deviation(&comparison.rest), "missing": deviation(&comparison.missing), "surface": deviation(&comparison.surface),
            })
        });
        json!({
            "part": name(left.part), "resolution_mm": left.resolution_mm, "left_mm3": left.volume.map(|volume| [volume.low, volume.high]), "bytes": left.bytes, "questions": left.questions, "given_up_at_line": left.given_up, "target": comparison,
            "file": left.written.as_ref().map(|(file, _)| file), "cube_mm": left.written.as_ref().map(|(_, cube)| cube),
        })
    });
    json!({
        "stays_whole": outcome.stays_whole, "open_cutters": outcome.open_cutters.iter().map(|&part| name(part)).collect::<Vec<_>>(), "touches": touches.collect::<Vec<_>>(), "workpieces": workpieces.collect::<Vec<_>>(),
        "uncut": outcome.uncut.iter().map(|&part| json!({ "part": name(part), "why": why_uncut(&scene.parts[part]) })).collect::<Vec<_>>(),
    })
}

fn write_stl(file: &Path, mesh: &Mesh) -> Result<()> {
    let written = File::create(file).and_then(|file| import::write_stl(mesh, &mut BufWriter::new(file)));
    written.with_context(|| format!("cannot write {}", file.display()))
}
