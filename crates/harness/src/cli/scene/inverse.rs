//! `scene inverse`: where the axes must be for the tool to have a direction.

use super::super::gcode;
use super::super::subject::tip_control;
use super::{say, table};
use crate::geometry::{self, Vector};
use crate::machine::Joint;
use crate::machine::orientation::Solution;
use crate::machine::tip::TipControl;
use crate::scene::Scene;
use anyhow::{Context, Result, bail};
use clap::Args;
use rs274::{Axis, Position};
use serde_json::{Value, json};

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench scene inverse trunnion-impeller --direction 0.5,0,0.866\n  bvbench scene inverse trunnion-impeller --direction 0.5,0,0.866 --from A-20,C90 --tip 10,0,60 --json\n\nThe direction is the one from the tool's tip up the tool, on the workpiece, in the axes that X, Y and Z have while all axes are at zero. Of\nthe two solutions within the limits that is chosen which Fanuc's controls take for G53.1: the least travel of the axis nearer to the base\n(of the table's, where the other is the head's), then of the other, then the first nearest to a whole turn, then the other."
)]
pub struct Options {
    /// Scene by name or by path; it must say which links carry tool and workpiece
    #[arg(value_name = "SCENE")]
    scene: String,
    /// From the tip up the tool, any length but zero
    #[arg(long, value_name = "I,J,K", value_parser = triple, allow_hyphen_values = true)]
    direction: [f64; 3],
    /// Where the tip shall be, mm, as a program says it under tool-centre-point control; adds the linear axes
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    tip: Option<[f64; 3]>,
    /// Length of the tool, mm [default: that of the tool in the spindle at first]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    length: Option<f64>,
    /// Where the axes come from, as in A-20,C90 [default: where the scene's program starts]
    #[arg(long, value_name = "AXES", value_delimiter = ',', value_parser = word)]
    from: Vec<(Axis, f64)>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

fn number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    number.ok_or_else(|| format!("`{text}` is not a finite number"))
}

fn triple(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    numbers.try_into().map_err(|_| "there must be three numbers, as in 0.5,0,1".to_owned())
}

/// An axis with its position in mm or radians, from mm or degrees.
fn word(text: &str) -> Result<(Axis, f64), String> {
    let text = text.trim();
    let letter = text.chars().next().and_then(Axis::from_letter);
    let axis = letter.ok_or_else(|| format!("`{text}` does not begin with one of X Y Z A B C U V W"))?;
    let value = number(&text[1..])?;
    Ok((axis, if axis.is_rotary() { value.to_radians() } else { value }))
}

pub fn run(options: &Options) -> Result<()> {
    let scene = Scene::find(&options.scene)?;
    let program = scene.program.as_ref();
    let tip = tip_control(&scene)?;
    let direction = geometry::direction(Vector::from(options.direction)).context("the direction has no length")?;
    let mut from = program.map(|run| run.start).unwrap_or_default();
    options.from.iter().for_each(|&(axis, value)| from[axis] = value);
    let found = tip.orient(&scene.machine, &tip.world_direction(&scene.machine, &direction)?, &from)?;
    let solutions: Vec<Solution> = [Some(found.chosen), found.other].into_iter().flatten().collect();
    let length = options.length.unwrap_or_else(|| {
        let setup = program.map(|run| &run.setup);
        setup.and_then(|setup| setup.tools.get(&setup.tool)).map_or(0.0, |tool| tool.offset[Axis::Z])
    });
    let placed: Vec<Placed> =
        solutions.iter().map(|solution| place(&scene, tip, solution, options.tip, length)).collect::<Result<_>>()?;
    if options.json {
        let names = ["chosen", "other"];
        let values: serde_json::Map<String, Value> =
            names.iter().zip(&placed).map(|(name, placed)| ((*name).to_owned(), as_json(placed))).collect();
        say(serde_json::to_string_pretty(&values)?);
    } else {
        print(&scene, &placed, options.tip.is_some());
    }
    Ok(())
}

/// A solution with its linear axes.
struct Placed<'a> {
    solution: &'a Solution,
    position: Position,
    /// What forbids it.
    forbidden: Option<String>,
}

fn place<'a>(
    scene: &Scene,
    tip: &TipControl,
    solution: &'a Solution,
    at: Option<[f64; 3]>,
    length_mm: f64,
) -> Result<Placed<'a>> {
    if !length_mm.is_finite() {
        bail!("--length is {length_mm}; it must be a finite number");
    }
    let mut position = solution.position;
    if let Some(at) = at {
        position.0[..3].copy_from_slice(&at);
        position = tip.axes(&scene.machine, &position, length_mm)?;
    }
    let checked = if at.is_some() { scene.machine.check_limits(&position) } else { solution.limits };
    Ok(Placed { solution, position, forbidden: checked.err().map(|cause| cause.to_string()) })
}

/// The axes that the machine has, without the linear ones when nothing was asked of them.
fn shown(scene: &Scene, linear: bool) -> Vec<Axis> {
    let drives = |axis: &Axis| scene.machine.joints_of(*axis).next().is_some();
    let turns = |axis: &Axis| scene.machine.joints_of(*axis).any(Joint::turns);
    Axis::ALL.into_iter().filter(|axis| drives(axis) && (linear || turns(axis))).collect()
}

/// Mm or degrees, to a nanometre's worth of digits.
fn value(position: &Position, axis: Axis) -> f64 {
    // Adding zero turns -0 into 0.
    (gcode::shown(position, axis) * 1e6).round() / 1e6 + 0.0
}

fn print(scene: &Scene, placed: &[Placed], linear: bool) {
    let axes = shown(scene, linear);
    let header = [String::new()].into_iter().chain(axes.iter().map(|axis| axis.letter().to_string()));
    let mut rows = table(header.chain(["TRAVEL", "NOTE"].map(str::to_owned)));
    for (name, Placed { solution, position, forbidden }) in ["chosen", "other"].iter().zip(placed) {
        let mut row = vec![(*name).to_owned()];
        row.extend(axes.iter().map(|&axis| value(position, axis).to_string()));
        let [first, second] = solution.travel.map(|travel| format!("{:.3}", travel.to_degrees().abs()));
        row.push(format!("{first} and {second} degrees"));
        let free = solution.free.map(|axis| format!("{} does not matter", axis.letter()));
        row.push([free, forbidden.clone()].into_iter().flatten().collect::<Vec<_>>().join("; "));
        rows.add_row(row);
    }
    say(rows.trim_fmt());
}

fn as_json(placed: &Placed) -> Value {
    let Placed { solution, position, forbidden } = placed;
    json!({
        "position": gcode::by_letter(|axis| value(position, axis)), "travel_deg": solution.travel.map(f64::to_degrees),
        "free": solution.free.map(|axis| axis.letter().to_string()), "forbidden": forbidden,
    })
}
