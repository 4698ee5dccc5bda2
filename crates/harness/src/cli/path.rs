//! `path`: a tool path over the free-form part of a scene, as a program.

use super::subject::{refuse_output, tip_control};
use super::{note, say};
use crate::geometry::shapes::{Freeform, Shape};
use crate::interference::path::{Corner, Flaw, PathPlan, Pattern, stops};
use crate::interference::program::Writer;
use crate::record::write_text;
use crate::scene::{Part, Role, Scene};
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use rs274::Axis;
use std::path::PathBuf;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench program path freeform-5axis --rows 8 --out clean.ngc\n  bvbench program path freeform-5axis --pattern spiral --rows 6 --lead 8 --tilt 4\n  bvbench program path freeform-5axis --gouge 0.05@0.4 --lean 25@0.8 --out gouging.ngc\n\nThe scene must have a part with `shape = { kind = \"freeform\" }` on the link that carries the workpiece, a tool table, and\n`[program.tool_centre_point]`. The program is in G54 under tool-centre-point control (G43.4). Flaws are put at a part of the path, 0 its first\ncontact point and 1 its last; on which lines they are is told on standard error."
)]
pub struct Options {
    /// Scene by name or by path
    #[arg(value_name = "SCENE")]
    scene: String,
    /// The free-form part [default: the first]
    #[arg(long, value_name = "PART")]
    part: Option<String>,
    /// Number of the tool [default: the lowest of the tool table]
    #[arg(long, value_name = "N")]
    tool: Option<u32>,
    /// Radius of the cutter's corner, mm [default: half its diameter, a ball]
    #[arg(long, value_name = "MM")]
    corner: Option<f64>,
    /// How the contact points run
    #[arg(long, value_enum, default_value_t = PatternName::ZigZag)]
    pattern: PatternName,
    /// Rows, or turns of the spiral
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    rows: u32,
    /// Most way along the surface from one contact point to the next, mm
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    step: f64,
    /// Part of the surface's size kept away from its edges
    #[arg(long, value_name = "PART", default_value_t = 0.08)]
    margin: f64,
    /// Angle of the tool from the normal in the direction of feed, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    lead: f64,
    /// Angle of the tool from the normal to the left of the feed, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
    tilt: f64,
    /// Feed rate of the tip, mm/min
    #[arg(long, value_name = "RATE", default_value_t = 1500.0)]
    feed: f64,
    /// Sink the tool at a part of the path: mm@PART; repeatable
    #[arg(long = "gouge", value_name = "MM@PART", value_parser = placed)]
    gouges: Vec<(f64, f64)>,
    /// Lean the tool to the left of the feed at a part of the path: degrees@PART; repeatable
    #[arg(long = "lean", value_name = "DEG@PART", value_parser = placed, allow_hyphen_values = true)]
    leans: Vec<(f64, f64)>,
    /// Write to a file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// How the contact points run.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum PatternName {
    /// To and fro along x
    ZigZag,
    /// A rectangle that shrinks to the middle
    Spiral,
}

/// `value@part`, part from 0 to 1.
fn placed(text: &str) -> Result<(f64, f64), String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let (value, part) = text.split_once('@').ok_or("it must look like 0.05@0.4")?;
    let value = number(value).ok_or_else(|| format!("`{value}` is not a finite number"))?;
    let part = number(part).filter(|part| (0.0..=1.0).contains(part));
    Ok((part.ok_or("what follows the @ must be from 0 to 1")?, value))
}

impl Options {
    fn plan(&self) -> PathPlan {
        PathPlan {
            pattern: match self.pattern {
                PatternName::ZigZag => Pattern::ZigZag,
                PatternName::Spiral => Pattern::Spiral,
            },
            rows: self.rows,
            step_mm: self.step,
            margin: self.margin,
            lead: self.lead.to_radians(),
            tilt: self.tilt.to_radians(),
        }
    }
}

/// Says on which lines of the program a flaw is.
fn tell(flaw: Flaw, lines: &[u32]) {
    let (first, last) = (lines.first().copied().unwrap_or(0), lines.last().copied().unwrap_or(0));
    match flaw {
        Flaw::Gouge { depth_mm } => note(format!("gouge of {depth_mm} mm on line {first}")),
        Flaw::Lean { angle } => {
            note(format!("lean by {:.1} degrees on lines {first} to {last}", angle.to_degrees()));
        }
    }
}

/// Distance from the surface at which the way in begins, mm.
const RETRACT_MM: f64 = 10.0;

pub fn run(options: &Options) -> Result<()> {
    let scene = Scene::find(&options.scene)?;
    if let Some(out) = &options.out {
        refuse_output("--out", out, &options.scene, scene.files.iter().map(PathBuf::as_path))?;
    }
    let (part, surface) = free_form(&scene, options.part.as_deref())?;
    let run = scene.program.as_ref().with_context(|| format!("scene `{}` has no [program]", scene.name))?;
    let tip = tip_control(&scene)?;
    if part.link != tip.work_link {
        bail!("part `{}` is not on the link that carries the workpiece", part.name);
    }
    let tool = options.tool.or_else(|| run.setup.tools.keys().min().copied()).context("the tool table is empty")?;
    let entry = run.setup.tools.get(&tool).with_context(|| format!("tool {tool} is not in the tool table"))?;
    let radius_mm = 0.5 * entry.diameter_mm;
    let corner_mm = options.corner.unwrap_or(radius_mm);
    if !(radius_mm > 0.0 && (0.0..=radius_mm).contains(&corner_mm)) {
        bail!("the cutter of tool {tool} has a radius of {radius_mm} mm and a corner of {corner_mm} mm");
    }
    check_numbers(options)?;
    let plan = options.plan();
    let gouges = options.gouges.iter().map(|&(part, depth_mm)| (part, Flaw::Gouge { depth_mm }));
    let leans = options.leans.iter().map(|&(part, degrees)| (part, Flaw::Lean { angle: degrees.to_radians() }));
    let flaws: Vec<(f64, Flaw)> = gouges.chain(leans).collect();
    let contacts = plan.contacts(surface)?;
    let planned = stops(&contacts, &flaws);
    let title = format!(
        "{} over {} of {}, length of tool {tool} {} mm",
        plan.pattern,
        part.name,
        scene.name,
        entry.offset[Axis::Z]
    );
    let writer = Writer {
        machine: &scene.machine,
        tip,
        setup: &run.setup,
        tool,
        work_from_surface: part.link_from_part,
        corner: Corner { radius_mm, corner_mm },
        feed_mm_min: options.feed,
        retract_mm: RETRACT_MM,
        title: &title,
    };
    let written = writer.write(&planned)?;
    for &(part, flaw) in &flaws {
        let at = contacts[(part * (contacts.len() - 1) as f64).round() as usize].point;
        let lines = planned.iter().zip(&written.lines).filter(|(stop, _)| stop.contact.point == at);
        tell(flaw, &lines.map(|(_, line)| *line).collect::<Vec<u32>>());
    }
    match &options.out {
        Some(path) => write_text(path, &written.text)?,
        None => say(written.text.trim_end()),
    }
    Ok(())
}

/// The free-form part of that name, or the first.
fn free_form<'a>(scene: &'a Scene, name: Option<&str>) -> Result<(&'a Part, &'a Freeform)> {
    let shape = |part: &'a Part| match part.shape.as_deref() {
        Some(Shape::Freeform(surface)) => Some((part, surface)),
        _ => None,
    };
    match name {
        Some(name) => {
            let part = scene.part(name).with_context(|| format!("scene `{}` has no part `{name}`", scene.name))?;
            shape(&scene.parts[part]).with_context(|| format!("part `{name}` is not a free-form shape"))
        }
        None => {
            let parts = || scene.parts.iter().filter_map(shape);
            let workpiece = parts().find(|(part, _)| part.role == Role::Workpiece);
            workpiece
                .or_else(|| parts().next())
                .with_context(|| format!("scene `{}` has no free-form part", scene.name))
        }
    }
}

fn check_numbers(options: &Options) -> Result<()> {
    for (name, value) in [("--step", options.step), ("--feed", options.feed)] {
        if !(value > 0.0 && value.is_finite()) {
            bail!("{name} is {value}; it must be a finite number above 0");
        }
    }
    if !(0.0..0.5).contains(&options.margin) {
        bail!("--margin is {}; it must be from 0 to below 0.5", options.margin);
    }
    if !(options.lead.abs() < 90.0 && options.tilt.abs() < 90.0) {
        bail!("--lead and --tilt must be between -90 and 90");
    }
    Ok(())
}
