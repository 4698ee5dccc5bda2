//! From text to canonical moves: executes a program block by block.
//!
//! Order of execution inside a block as LinuxCNC documents it (G-code overview, "Order of Execution"). Cited facts:
//! Kramer, Proctor, Messina: The NIST RS274/NGC Interpreter, NISTIR 6556; LinuxCNC's G-code reference.

use super::block::{Block, Target};
use super::canonical::{Move, MoveKind};
use super::error::{Cause, Fault, GcodeError};
use super::modal::{FeedMode, Group, Modes, Values};
use super::offsets::{Offsets, Values9, from_canonical, to_canonical};
use super::parameters::Parameters;
use super::setup::Setup;
use std::path::Path;

/// Most moves a program may produce.
pub const MAX_MOVES: usize = 10_000_000;

/// Most blocks a program may execute: ends loops that never end.
pub const MAX_EXECUTED_BLOCKS: usize = 20_000_000;

/// What a program comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Its moves.
    pub moves: Vec<Move>,
    /// Its lines; line `n` of a move is `blocks[n - 1]`.
    pub blocks: Vec<String>,
}

/// Executes a program.
///
/// `file` is only named in errors. Text behind M2, M30 or a second `%` is not read.
///
/// # Errors
/// The first thing wrong, with file, line, column and text. Bad input never panics and never runs for ever.
pub fn interpret(source: &str, file: &Path, setup: &Setup) -> Result<Program, GcodeError> {
    let blocks: Vec<String> = source.lines().map(str::to_owned).collect();
    let mut interpreter = Interpreter::new(setup);
    match interpreter.run(&blocks) {
        Ok(()) => Ok(Program { moves: interpreter.moves, blocks }),
        Err(Fault { column, text, cause }) => {
            Err(GcodeError { file: file.to_owned(), line: interpreter.line, column, text, cause })
        }
    }
}

/// Whether the program goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    Continue,
    End,
}

/// The controller.
pub(super) struct Interpreter<'a> {
    pub setup: &'a Setup,
    pub modes: Modes,
    pub parameters: Parameters,
    pub offsets: Offsets,
    /// Axis positions, mm and degrees.
    pub position: Values9,
    pub tools: std::collections::BTreeMap<u32, super::setup::Tool>,
    pub tool: u32,
    pub selected_tool: u32,
    pub moves: Vec<Move>,
    /// The line being executed, from 1.
    pub line: u32,
}

impl<'a> Interpreter<'a> {
    fn new(setup: &'a Setup) -> Self {
        let mut interpreter = Self {
            setup,
            modes: Modes {
                motion: None,
                plane: setup.plane,
                incremental: false,
                arc_centre_absolute: false,
                feed_mode: FeedMode::PerMinute,
                inches: setup.inches,
                system: 0,
                diameter: setup.diameter,
                retract_to_r: false,
                constant_surface_speed: false,
                feed: 0.0,
                speed: 0.0,
            },
            parameters: Parameters::new(&setup.parameters),
            offsets: Offsets::default(),
            position: from_canonical(&setup.start),
            tools: setup.tools.clone(),
            tool: setup.tool,
            selected_tool: setup.tool,
            moves: Vec::new(),
            line: 0,
        };
        interpreter.load_datums();
        interpreter
    }

    fn run(&mut self, lines: &[String]) -> Result<(), Fault> {
        let delimited = lines.iter().find(|line| !line.trim().is_empty()).is_some_and(|line| line.trim() == "%");
        let mut percent_signs = 0;
        for (index, line) in lines.iter().enumerate() {
            self.line = index as u32 + 1;
            if line.trim() == "%" {
                percent_signs += 1;
                if !delimited || percent_signs == 2 {
                    return Ok(());
                }
                continue;
            }
            let block = Block::parse(line)?;
            if block.deletable && self.setup.block_delete {
                continue;
            }
            if let Some(flow) = &block.flow {
                return Err(Fault::new(flow.column, flow.text.clone(), Cause::Unsupported));
            }
            if self.execute(&block)? == Next::End {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Executes a block: evaluates everything, then assigns, then obeys.
    fn execute(&mut self, block: &Block) -> Result<Next, Fault> {
        let values = Values::of(block, &self.parameters)?;
        self.assign(block)?;
        self.set_feed_and_speed(&values)?;
        self.change_tool(&values)?;
        self.obey_spindle_and_coolant(&values)?;
        self.dwell(&values)?;
        self.set_modes(&values)?;
        self.obey_datum_codes(&values)?;
        self.obey_motion(&values)?;
        let next = match values.number(Group::Stop) {
            Some(2 | 30) => Next::End,
            _ => Next::Continue,
        };
        values.check_all_used()?;
        Ok(next)
    }

    /// Assigns parameters: all right-hand sides are evaluated first (NISTIR 6556, section 3.3.2.1).
    fn assign(&mut self, block: &Block) -> Result<(), Fault> {
        let mut found = Vec::with_capacity(block.assignments.len());
        for assignment in &block.assignments {
            let target = match &assignment.target {
                Target::Numbered(index) => Some(index.evaluate(&self.parameters)?),
                Target::Named(_) => None,
            };
            found.push((assignment, target, assignment.value.evaluate(&self.parameters)?));
        }
        for (assignment, index, value) in found {
            let outcome = match (&assignment.target, index) {
                (Target::Named(name), _) => self.parameters.assign_named(name, value),
                (Target::Numbered(_), index) => self.parameters.assign_numbered(index.unwrap_or_default(), value),
            };
            outcome.map_err(|cause| Fault::new(assignment.column, assignment.text.clone(), cause))?;
        }
        Ok(())
    }

    fn set_feed_and_speed(&mut self, values: &Values) -> Result<(), Fault> {
        if let Some(mode) = values.number(Group::FeedMode) {
            let mode = match mode {
                930 => FeedMode::InverseTime,
                940 => FeedMode::PerMinute,
                _ => FeedMode::PerRevolution,
            };
            if mode != self.modes.feed_mode {
                self.modes.feed = 0.0;
            }
            self.modes.feed_mode = mode;
        }
        if self.modes.feed_mode == FeedMode::InverseTime {
            // In G93 an F belongs to its block alone.
            self.modes.feed = 0.0;
        }
        if let Some(feed) = values.take('f') {
            if feed < 0.0 {
                return Err(values.fault('f', Cause::Range("F", "at least 0")));
            }
            let scale = if self.modes.feed_mode == FeedMode::InverseTime { 1.0 } else { self.modes.unit_mm() };
            self.modes.feed = feed * scale;
        }
        if let Some(speed) = values.take('s') {
            if speed < 0.0 {
                return Err(values.fault('s', Cause::Range("S", "at least 0")));
            }
            self.modes.speed = speed;
        }
        match values.number(Group::SpindleMode) {
            Some(960) => {
                // D is the greatest spindle speed.
                values.take('d');
                self.modes.constant_surface_speed = true;
            }
            Some(_) => self.modes.constant_surface_speed = false,
            None => {}
        }
        Ok(())
    }

    fn change_tool(&mut self, values: &Values) -> Result<(), Fault> {
        const RANGE: &str = "a whole number from 0 to 99999";
        if let Some(tool) = values.take_whole('t', 0..=99_999, "T", RANGE)? {
            self.selected_tool = tool.unsigned_abs();
        }
        match values.number(Group::ToolChange) {
            Some(6) => {
                self.tool = self.selected_tool;
                self.emit(MoveKind::ToolChange { tool: self.tool }, None)?;
            }
            Some(_) => {
                let tool = values.take_whole('q', 0..=99_999, "Q", RANGE)?;
                let Some(tool) = tool else {
                    return Err(self.fault_at(values, Group::ToolChange, Cause::Missing("Q, the tool's number,")));
                };
                self.tool = tool.unsigned_abs();
            }
            None => {}
        }
        Ok(())
    }

    /// Spindle, coolant and overrides move nothing; their words are checked all the same.
    fn obey_spindle_and_coolant(&mut self, values: &Values) -> Result<(), Fault> {
        if matches!(values.number(Group::Override), Some(50..=53)) {
            values.take_whole('p', 0..=1, "P", "0 or 1")?;
        }
        Ok(())
    }

    fn dwell(&mut self, values: &Values) -> Result<(), Fault> {
        if values.number(Group::NonModal) != Some(40) {
            return Ok(());
        }
        match values.take('p') {
            Some(seconds) if seconds >= 0.0 => self.emit(MoveKind::Dwell { seconds }, None),
            Some(_) => Err(values.fault('p', Cause::Range("P", "at least 0"))),
            None => Err(self.fault_at(values, Group::NonModal, Cause::Missing("P, the time in seconds,"))),
        }
    }

    /// A fault at a block's code.
    pub fn fault_at(&self, values: &Values, group: Group, cause: Cause) -> Fault {
        match values.code(group) {
            Some(code) => code.fault(cause),
            None => Fault::new(1, "", cause),
        }
    }

    /// Records a move that ends where the machine is.
    pub fn emit(&mut self, kind: MoveKind, feed_mm_min: Option<f64>) -> Result<(), Fault> {
        if self.moves.len() >= MAX_MOVES {
            return Err(Fault::new(1, "", Cause::Limit { limit: MAX_MOVES, what: "moves" }));
        }
        self.moves.push(Move { line: self.line, kind, end: to_canonical(&self.position), feed_mm_min });
        Ok(())
    }
}
