//! `scene picture`: a scene drawn as PNG.

use super::say;
use super::subject::{refuse_ending, refuse_output};
use crate::check;
use crate::picture::{self, Up, View};
use crate::plot::canvas;
use crate::scene::Scene;
use anyhow::{Context, Result, anyhow};
use clap::{Args, ValueEnum};
use rs274::Position;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench scene picture mill-vise\n  bvbench scene picture mill-vise --program-line 93 --focus vise --focus holder --out crash.png\n  bvbench scene picture lathe-tailstock --up y --azimuth -30\n\nCutters are red, holders purple, workpieces blue, fixtures green, other parts of examined pairs yellow, and everything else grey."
)]
pub struct Options {
    /// Scene by name or by path
    #[arg(value_name = "SCENE")]
    scene: String,
    /// Show the machine at the end of its first way through this line of its program
    #[arg(long, value_name = "N")]
    program_line: Option<u32>,
    /// Part that shall fill the picture; repeatable [default: all]
    #[arg(long, value_name = "PART")]
    focus: Vec<String>,
    /// The axis that is up
    #[arg(long, value_name = "AXIS", default_value = "z")]
    up: UpAxis,
    /// Degrees that the eye is turned about it, counter-clockwise seen from above; at 0 it looks along +y, or -z where y is up
    #[arg(long, value_name = "DEG", default_value_t = 35.0, allow_negative_numbers = true)]
    azimuth: f64,
    /// Degrees that the eye is above the horizon
    #[arg(long, value_name = "DEG", default_value_t = 28.0, allow_negative_numbers = true)]
    elevation: f64,
    /// Width, pixels
    #[arg(long, value_name = "PX", default_value_t = 900)]
    width: usize,
    /// The file [default: SCENE.png]
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
}

/// The axis that is up.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum UpAxis {
    Y,
    Z,
}

impl From<UpAxis> for Up {
    fn from(axis: UpAxis) -> Self {
        match axis {
            UpAxis::Y => Self::Y,
            UpAxis::Z => Self::Z,
        }
    }
}

impl Options {
    pub fn scene(&self) -> &str {
        &self.scene
    }
}

pub fn run(scene: &Scene, options: &Options) -> Result<()> {
    let out = options.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.png", scene.name)));
    refuse_output("--out", &out, &options.scene, scene.files.iter().map(PathBuf::as_path))?;
    refuse_ending("--out", &out, "png")?;
    let part = |name: &String| {
        scene.part(name).ok_or_else(|| {
            let known: Vec<_> = scene.parts.iter().map(|part| part.name.as_str()).collect();
            anyhow!("there is no part `{name}`; there are {}", known.join(", "))
        })
    };
    let (position, tool) = position(scene, options.program_line)?;
    let view = View {
        tool,
        up: options.up.into(),
        azimuth: options.azimuth.to_radians(),
        elevation: options.elevation.to_radians(),
        focus: options.focus.iter().map(part).collect::<Result<_>>()?,
        width: options.width,
    };
    let image = picture::take(scene, &scene.machine.forward(&position), &view)?;
    canvas::write_pixels(&image.rgb, (image.width, image.height), &out)
        .map_err(|problem| anyhow!("cannot write {problem}"))?;
    say(format!("{} ({} x {} pixels)", out.display(), image.width, image.height));
    Ok(())
}

/// Where the machine stands at first, or at the end of its first way through a line, and the tool in its spindle.
fn position(scene: &Scene, line: Option<u32>) -> Result<(Position, u32)> {
    let Some(line) = line else {
        return Ok(scene.program.as_ref().map_or_else(Default::default, |run| (run.start, run.setup.tool)));
    };
    let run = scene.program.as_ref().with_context(|| format!("scene `{}` has no program of its own", scene.name))?;
    let path = check::Path::new(scene, run)?;
    let is_of_line = |at: &usize| path.samples()[at - 1].line == line;
    let first = (1..=path.samples().len()).find(is_of_line);
    let first = first.with_context(|| format!("nothing moves on line {line} of {}", run.file.display()))?;
    let last = (first..=path.samples().len()).take_while(is_of_line).last().unwrap_or(first);
    Ok((path.position(last), path.tool(last)))
}
