//! `gcode`: what a program means.

use super::{CLEAR, note, say};
use anyhow::{Context, Result};
use clap::Args;
use rs274::file::{LARGEST_PROGRAM, text};
use rs274::{
    Axis, CodeName, Dialect, Move, MoveKind, Note, Position, Setup, Tool, Units, canonical, read_parameter_file,
    read_tool_table,
};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// mm per inch.
const INCH_MM: f64 = 25.4;

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench program gcode part.ngc                      a line for each move, mm and degrees\n  bvbench program gcode part.ngc --lathe              the ZX plane to begin with\n  bvbench program gcode part.ngc --tool-table mill.tbl --var mill.var\n  bvbench program gcode O0001.nc --dialect fanuc      macros, subprograms and cycles of a Fanuc control\n  bvbench program gcode part.ngc --ignore M31 --ignore G187\n  bvbench program gcode part.ngc --json | jq '.[] | select(.kind == \"rapid\")'\n\nExit code 2 when the program cannot be interpreted; the message names file, line, column and word."
)]
pub struct Options {
    /// The program (RS274/NGC)
    #[arg(value_name = "PROGRAM")]
    program: PathBuf,
    /// Begin as a lathe does: G18, and with diameters in the dialects fanuc and haas
    #[arg(long)]
    lathe: bool,
    /// Tool table in LinuxCNC's form
    #[arg(long, value_name = "FILE")]
    tool_table: Option<PathBuf>,
    /// The tool table's lengths are inches
    #[arg(long, requires = "tool_table")]
    tool_table_inch: bool,
    /// Parameters in LinuxCNC's form: work offsets, G28, G30, G92 and the program's own; mm and degrees
    #[arg(long, value_name = "FILE")]
    var: Option<PathBuf>,
    /// The lengths among the parameters are inches
    #[arg(long, requires = "var")]
    var_inch: bool,
    #[command(flatten)]
    reading: Reading,
    /// Print the moves as JSON
    #[arg(long)]
    json: bool,
}

/// How a program is read, by whichever verb.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct Reading {
    /// The control that the program is written for: linuxcnc, fanuc, haas or grbl [default: that of the scene, if there is one, else linuxcnc]
    #[arg(long, value_name = "NAME")]
    dialect: Option<Dialect>,
    /// The unit of lengths before any G20 or G21: mm or inch [default: that of the scene, if there is one, else mm with a note]
    #[arg(long, value_name = "UNIT")]
    units: Option<Units>,
    /// Skip a G or M code, with a note; repeatable
    #[arg(long, value_name = "CODE")]
    ignore: Vec<CodeName>,
    /// Skip lines that begin with `/`
    #[arg(long)]
    block_delete: bool,
    /// Set a variable before the program, as in 510=-58.4; repeatable
    #[arg(long, value_name = "NUMBER=VALUE", value_parser = variable)]
    variable: Vec<(u32, f64)>,
}

/// A variable of the program's own and its value.
fn variable(text: &str) -> Result<(u32, f64), String> {
    let wrong = || {
        "it must be like 510=-58.4, with a variable from 31 to 4999 or from 10000 to 10999; `--offset` of `check` sets origins".to_owned()
    };
    let (number, value) = text.split_once('=').ok_or_else(wrong)?;
    let number = number.trim().parse::<u32>().ok().filter(|&number| matches!(number, 31..=4999 | 10_000..=10_999));
    let value = value.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    number.zip(value).ok_or_else(wrong)
}

impl Reading {
    /// Whether it says anything.
    pub(super) fn is_given(&self) -> bool {
        let names_control = self.dialect.is_some() || self.units.is_some();
        names_control || self.block_delete || !(self.ignore.is_empty() && self.variable.is_empty())
    }

    /// Changes what the controller knows.
    pub(super) fn apply(&self, setup: &mut Setup) {
        setup.dialect = self.dialect.unwrap_or(setup.dialect);
        setup.dialect_is_assumed &= self.dialect.is_none();
        setup.units = self.units.or(setup.units);
        setup.block_delete |= self.block_delete;
        setup.ignored.extend(&self.ignore);
        setup.parameters.extend(self.variable.iter().map(|(number, value)| (number.to_string(), *value)));
    }
}

/// Prints what the reader of a program should know.
pub(super) fn print_notes<'a>(notes: impl IntoIterator<Item = &'a Note>) {
    notes.into_iter().for_each(|told| note(format!("note: {told}")));
}

/// A tool table in LinuxCNC's form.
pub(super) fn tool_table(file: &Path, is_inch: bool) -> Result<BTreeMap<u32, Tool>> {
    let text = text(file, LARGEST_PROGRAM).with_context(|| format!("cannot read {}", file.display()))?;
    Ok(read_tool_table(&text, file, if is_inch { INCH_MM } else { 1.0 })?)
}

pub fn run(options: &Options) -> Result<u8> {
    let mut setup = if options.lathe { Setup::lathe() } else { Setup::default() };
    if let Some(file) = &options.tool_table {
        setup.tools = tool_table(file, options.tool_table_inch)?;
    }
    if let Some(file) = &options.var {
        let parameters = text(file, LARGEST_PROGRAM).with_context(|| format!("cannot read {}", file.display()))?;
        let unit_mm = if options.var_inch { INCH_MM } else { 1.0 };
        setup.parameters = read_parameter_file(&parameters, file, unit_mm)?;
    }
    setup.dialect_is_assumed = true;
    options.reading.apply(&mut setup);
    let file = &options.program;
    let program = text(file, LARGEST_PROGRAM).with_context(|| format!("cannot read {}", file.display()))?;
    let program = rs274::interpret(&program, file, &setup)?;
    print_notes(&program.notes);
    if program.moves.is_empty() {
        note(format!("note: {}: the program has no moves", file.display()));
    }
    if options.json {
        // One by one: as values, all moves of a long program would not fit the memory.
        say("[");
        for (step, end) in program.moves.iter().zip((1..program.moves.len()).map(|_| ",").chain([""])) {
            say(format!("  {}{end}", as_json(step)));
        }
        say("]");
    } else {
        say(canonical::render(&program.moves).trim_end());
    }
    Ok(CLEAR)
}

/// The place of an axis as files and people have it: in mm, or degrees of a rotary axis.
pub(super) fn shown(position: &Position, axis: Axis) -> f64 {
    if axis.is_rotary() { position[axis].to_degrees() } else { position[axis] }
}

/// A value of each axis, by its letter.
pub(super) fn by_letter(value: impl Fn(Axis) -> f64) -> Map<String, Value> {
    Axis::ALL.iter().map(|&axis| (axis.letter().to_string(), json!(value(axis)))).collect()
}

/// A move as JSON: mm and degrees.
fn as_json(step: &Move) -> Value {
    let mut value = json!({ "line": step.line, "kind": step.kind.name(), "end": by_letter(|axis| shown(&step.end, axis)), "feed_mm_min": step.feed_mm_min, "spindle_rpm": step.spindle_rpm, "tip_mm": step.tip_mm });
    match step.kind {
        MoveKind::Arc { plane, centre, sweep } => {
            let axes: String = plane.axes()[..2].iter().map(|axis| axis.letter()).collect();
            value["arc"] = json!({ "plane": axes, "centre_mm": centre, "sweep_deg": sweep.to_degrees() });
        }
        MoveKind::Dwell { seconds } => value["seconds"] = json!(seconds),
        MoveKind::ToolChange { tool } => value["tool"] = json!(tool),
        MoveKind::Rapid | MoveKind::Feed => {}
    }
    value
}
