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
        if let Some(Comparison { gouge, rest, missing }) = &self.comparison {
            let told = |what: &str, Deviation { greatest_mm, volume_mm3 }: &Deviation| {
                format!("{what}: {greatest_mm:.3} mm deep, at least {volume_mm3:.1} mm³")
            };
            let none = |what: &str| format!("{what}: none deeper than {} mm", self.resolution_mm);
            let of = |what: &str, name: &str, found: &Deviation| match found.volume_mm3 > 0.0 || found.greatest_mm > 0.0
            {
                true => told(what, found),
                false => none(name),
            };
            lines.push(of("GOUGE, the wanted part is cut", "gouge", gouge));
            lines.push(of("rest, stock beyond the wanted part", "rest", rest));
            if missing.volume_mm3 > 0.0 {
                lines.push(told("MISSING, the wanted part is larger than the uncut workpiece", missing));
            }
        }
        if let Some((file, cube_mm)) = &self.written {
            lines.push(format!("{file}: all that may be left of `{name}`, in cubes of {cube_mm:.3} mm"));
        }
        lines
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
    let deviation = |of: &Deviation| json!({ "greatest_mm": of.greatest_mm, "volume_mm3": of.volume_mm3 });
    let workpieces = left.iter().map(|left| {
        let comparison = left.comparison.as_ref().map(|comparison| {
            json!({
                "gouge": deviation(&comparison.gouge), "rest": deviation(&comparison.rest), "missing": deviation(&comparison.missing),
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
