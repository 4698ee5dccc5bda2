//! Figures from records, one file per figure, each as SVG and PNG by the same drawing code.
//!
//! Every variant that has data in the records is drawn, whatever its name. Colours and markers follow the order of the manifest, so a
//! variant looks the same in all figures.

pub mod ablation;
pub mod audit;
pub mod audit_axes;
pub mod audit_containment;
mod backend;
pub mod boxes;
pub mod build_time;
pub mod canvas;
pub mod cost_model;
pub mod data;
pub mod forest;
pub mod grouped;
pub mod marks;
pub mod misses;
pub mod operations;
pub mod paper_figure;
pub mod query_time;
pub mod sweep;
pub mod ticks;
pub mod tightness;

pub use ablation::draw_ablation;
pub use audit::draw_audit;
pub use sweep::draw_sweep;

use crate::analysis::AnalysisError;
use crate::record::{read_json, write_json, write_text};
use data::Data;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The folder of the figures within a run's folder.
pub const FOLDER: &str = "plots";

/// Folders of supplements within the folder of a run: an audit, an ablation and sweeps.
pub const SUPPLEMENTS: [&str; 4] = ["audit", "ablation", "sweep-rotation", "sweep-grading"];

/// Name of the figure of the time of whole programs.
pub const PAPER_FIGURE: &str = "paper-figure-6";

/// The list of figures in [`FOLDER`].
const INDEX: &str = "figures.json";

/// A figure on disk.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figure {
    /// Short name: the files' stem.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// How to read it.
    pub caption: String,
    /// The SVG file, relative to the run's folder.
    pub svg: PathBuf,
    /// The PNG file, relative to the run's folder.
    pub png: PathBuf,
}

impl Figure {
    /// The figure of a folder within the run's folder, with its paths relative to the run's folder.
    fn within(self, folder: &str) -> Self {
        let [svg, png] = [self.svg, self.png].map(|file| Path::new(folder).join(file));
        Self { name: format!("{folder}-{}", self.name), svg, png, ..self }
    }
}

/// A figure that was not drawn because data are missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// Short name.
    pub name: String,
    /// What was missing.
    pub reason: String,
}

/// All figures of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Gallery {
    /// The figures that were drawn.
    pub figures: Vec<Figure>,
    /// The figures that could not be drawn.
    pub skipped: Vec<Skipped>,
}

/// A figure before it is drawn.
#[derive(Debug)]
pub struct Sketch<D> {
    /// Short name.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// How to read it.
    pub caption: String,
    /// The drawing, or the reason for its absence.
    pub drawing: Result<D, &'static str>,
}

/// Draws every figure for which the run in `folder` has records, into `plots/`, and lists them in `plots/figures.json`.
///
/// # Errors
/// When a record is malformed, the manifest is missing, or a figure cannot be written. A missing CSV file only skips figures.
pub fn draw_all(folder: &Path) -> Result<Gallery, AnalysisError> {
    let data = Data::read(folder)?;
    let mut gallery = Gallery::default();
    add(folder, &mut gallery, paper_figure::sketch(&data))?;
    add(folder, &mut gallery, query_time::sketch(&data))?;
    add(folder, &mut gallery, forest::sketch(&data))?;
    add(folder, &mut gallery, misses::sketch(&data))?;
    add(folder, &mut gallery, boxes::sketch(&data))?;
    add(folder, &mut gallery, tightness::sketch(&data))?;
    add(folder, &mut gallery, tightness::frames(&data))?;
    add(folder, &mut gallery, operations::sketch(&data))?;
    add(folder, &mut gallery, build_time::sketch(&data))?;
    add(folder, &mut gallery, cost_model::sketch(&data))?;
    if let Some(engines) = forest::engines(&data) {
        add(folder, &mut gallery, engines)?;
    }
    for aside in SUPPLEMENTS {
        gallery
            .figures
            .extend(read_gallery(&folder.join(aside))?.figures.into_iter().map(|figure| figure.within(aside)));
    }
    write_index(&folder.join(FOLDER), &gallery)?;
    Ok(gallery)
}

/// Writes the list of figures in `folder`, which [`read_gallery`] reads.
fn write_index(folder: &Path, gallery: &Gallery) -> Result<(), AnalysisError> {
    Ok(write_json(&folder.join(INDEX), gallery)?)
}

/// The figures that an earlier [`draw_all`] made; empty when it never ran.
///
/// # Errors
/// When the list is malformed.
pub fn read_gallery(folder: &Path) -> Result<Gallery, AnalysisError> {
    let path = folder.join(FOLDER).join(INDEX);
    if !path.exists() {
        return Ok(Gallery::default());
    }
    Ok(read_json(&path)?)
}

fn add<D: canvas::Drawing>(folder: &Path, gallery: &mut Gallery, sketch: Sketch<D>) -> Result<(), AnalysisError> {
    let name = sketch.name.to_owned();
    match sketch.drawing {
        Err(reason) => gallery.skipped.push(Skipped { name, reason: reason.to_owned() }),
        Ok(drawing) => {
            let stem = Path::new(FOLDER).join(&name);
            let (svg, png) = (stem.with_extension("svg"), stem.with_extension("png"));
            let problem = |problem| AnalysisError::Draw { figure: name.clone(), problem };
            let titled = canvas::Titled { title: &sketch.title, drawing: &drawing };
            write_text(&folder.join(&svg), &canvas::svg(&titled).map_err(problem)?)?;
            canvas::write_png(&titled, &folder.join(&png)).map_err(problem)?;
            gallery.figures.push(Figure { name, title: sketch.title, caption: sketch.caption, svg, png });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
