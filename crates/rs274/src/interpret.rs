//! From text to canonical moves: executes a program block by block.
//!
//! Order of execution inside a block as LinuxCNC documents it (G-code overview, "Order of Execution"). Cited facts:
//! Kramer, Proctor, Messina: The NIST RS274/NGC Interpreter, NISTIR 6556; LinuxCNC's G-code reference.

use super::block::{Block, Keyword, Target, Word};
use super::canonical::{Axis, Move, MoveKind, Plane};
use super::compensation::Compensation;
use super::contour::follows_contour;
use super::corner::{Corner, OPEN_CORNER};
use super::cycle::Sticky;
use super::dialect::{Dialect, Note, own};
use super::error::{Cause, Fault, GcodeError, MOST_ERRORS};
use super::fanuc::{OffsetNumbers, origin_of};
use super::foreign;
use super::kinematics::Kinematics;
use super::lathe::LatheMemory;
use super::modal::{FeedMode, Group, Modes, Spindle, Values, lacks_point_note};
use super::offsets::{Offsets, Values9, from_canonical, to_canonical};
use super::oword::{Control, FlowTable, Lines};
use super::parameters::{INPUT, Parameters, UNKNOWN};
use super::profile_cycle::is_profile_cycle;
use super::setup::{Setup, Tool, Units, WorkOffset};
use super::source::{self, Source};
use super::transform::Transforms;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Farthest an axis may be from zero, mm or degrees; farther out a number has no tenths of micrometres left.
pub const FARTHEST: f64 = 1e9;

/// `#<_vmajor>` and `#<_vminor>`: of the LinuxCNC whose meanings are followed.
const LANGUAGE_VERSION: [f64; 2] = [2.9, 0.0];

/// Numbers that T, and Q of M61, take; for messages.
const TOOL_NUMBERS: &str = "a whole number from 0 to 99999";

/// Most lines that are found wrong before a program is given up: many of them may be one error, or one line of a loop.
const MOST_FAULTS: usize = 1000;

/// Most different notes on one program. Notes on what the machine may do otherwise are given beyond that number, too.
const MOST_NOTES: usize = 100;

/// Note on the first length of a program that has not said its unit.
const NO_UNITS_CODE: &str = "no G20 or G21 comes before this length, which is read as mm; where the control begins in inches, set `units` to `inch`";

/// Note on the first X of a lathe of LinuxCNC's whose program has not said what it is.
const NO_DIAMETER_CODE: &str =
    "no G7 or G8 comes before this X, which is read as a radius, as LinuxCNC begins; G7 makes X words diameters";

/// What a program comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Its moves.
    pub moves: Vec<Move>,
    /// Whether a spindle turns at some time: during a move, between two moves, or when M19 orients it.
    pub turns_spindle: bool,
    /// Its lines; line `n` of a move is `blocks[n - 1]`.
    pub blocks: Vec<String>,
    /// What its reader should know: codes that were skipped, numbers whose meaning is a guess.
    pub notes: Vec<Note>,
    /// The files of subroutines that were read beside it.
    pub called_files: Vec<PathBuf>,
    /// The tool table at its end, with the offsets that G43.1 and G43.2 have given the tool in the spindle.
    pub tools: BTreeMap<u32, Tool>,
    /// The line of the first feed in G54, and where G54 and G92 have zero there.
    pub first_zero: Option<(u32, WorkOffset)>,
    /// The machine that it was interpreted for, if that is known. It gives the axis positions for a place of the tip.
    pub kinematics: Option<Kinematics>,
}

/// Executes a program.
///
/// `file` is named in errors, and subroutine files are looked for beside it. Text behind a second `%` is not read, nor behind M2 or M30, after which
/// only Grbl runs on.
///
/// # Errors
/// What is wrong, with file, line, column and text: the first thing, and what else is wrong whatever the first has done, [`MOST_ERRORS`] in
/// all. Bad input never panics and never runs for ever.
pub fn interpret(source: &str, file: &Path, setup: &Setup) -> Result<Program, GcodeError> {
    let fault = |(file, line, cause)| GcodeError::new(file, line, 1, String::new(), cause);
    let lines = source::lines(source).map_err(|(line, cause)| fault((file.to_owned(), line, cause)))?;
    let parse = |line: &str| parse(line, setup);
    let text = Source::of(&lines, file, &parse, setup.dialect).map_err(fault)?;
    let mut interpreter = Interpreter::new(setup);
    let errors = interpreter.run(&text);
    if errors.is_empty() {
        let called_files = text.called_files().map(Path::to_owned).collect();
        let tools = interpreter.last_tools();
        let Interpreter { moves, turns_spindle, mut notes, first_zero, .. } = interpreter;
        if setup.dialect_is_assumed {
            notes.splice(..0, foreign::note(&lines));
        }
        let kinematics = setup.kinematics.clone();
        return Ok(Program { moves, turns_spindle, blocks: lines, notes, called_files, tools, first_zero, kinematics });
    }
    let error = all_in_one(errors, &text);
    Err(foreign::recognise(&lines, file, setup.dialect, error))
}

/// The first error with the others in it.
fn all_in_one(errors: Vec<(usize, Fault)>, text: &Source) -> GcodeError {
    let mut told: Vec<GcodeError> = Vec::new();
    for (at, fault) in errors {
        if let Some(error) = told.iter_mut().find(|error| error.cause == fault.cause && error.text == fault.text) {
            error.more += 1;
        } else if told.len() < MOST_ERRORS {
            let (file, line) = text.place(at);
            told.push(GcodeError::of(file, line, fault));
        }
    }
    let mut first = told.remove(0);
    first.set_others(told);
    first
}

fn parse(line: &str, setup: &Setup) -> Result<Block, Fault> {
    if matches!(source::bare(line), "" | "%") || (setup.block_delete && line.trim_start().starts_with('/')) {
        return Ok(Block::default());
    }
    let block = Block::parse(line, setup.dialect)?;
    Ok(if setup.block_delete && block.deletable { Block::default() } else { block })
}

/// Whether the program goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// With the line of this index.
    Line(usize),
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
    pub tools: BTreeMap<u32, Tool>,
    /// The offset of each tool that G43.1 or G43.2 has set, by its number.
    pub spindle_offsets: BTreeMap<u32, Values9>,
    /// Whether a spindle has turned so far.
    pub turns_spindle: bool,
    pub first_zero: Option<(u32, WorkOffset)>,
    pub tool: u32,
    pub selected_tool: u32,
    /// Numbers of offsets that hold on Fanuc's controls.
    pub numbers: OffsetNumbers,
    /// By how much tool offsets have changed since each axis was last sent somewhere, on Fanuc's controls.
    pub offset_change: Values9,
    /// Axes that G69 has turned back on Fanuc's controls and that nothing has sent to a place since.
    pub turned_back: [bool; 9],
    /// Where the tool was in the program's coordinates when G68 or G69 turned them on Fanuc's controls, until an axis of the plane is sent to a place.
    pub before_turn: Option<Values9>,
    /// A tool that T has selected and no M6 has changed to.
    pub waiting_tool: Option<u32>,
    /// Whether the unit of lengths is known: from G20 or G21, the setup, or a note that was given.
    pub knows_units: bool,
    /// Whether it is known if X words are diameters: from G7 or G8, the control, or a note that was given.
    pub knows_diameter: bool,
    pub control: Control,
    pub compensation: Compensation,
    /// From the end of a G5 to the control point of the next that continues it.
    pub spline_leaves: Option<[f64; 2]>,
    /// What a canned cycle keeps for its next block.
    pub sticky: Sticky,
    /// Under tool-centre-point control, the tool's length, mm; X, Y, Z of the position are then the tip's.
    pub tip_mm: Option<f64>,
    /// Whether LinuxCNC's kinematics lead the tip, by an M code of the machine's own: machine coordinates are then world coordinates, and G49 does
    /// not end the control.
    pub is_switched: bool,
    /// Whether M67 or M68 has set an output (LinuxCNC); outputs may switch the kinematics.
    pub has_set_output: bool,
    /// Turned, scaled and mirrored coordinates.
    pub transforms: Transforms,
    /// What lathe cycles keep.
    pub lathe: LatheMemory,
    /// Whether the lines of a cycle's contour are being executed, and whether cutter compensation and T do not count there.
    pub in_contour: bool,
    pub ignores_compensation: bool,
    /// Lines executed so far.
    pub steps: usize,
    /// Blocks executed so far, but for those of the macro language and calls.
    pub nc_blocks: usize,
    /// A straight move whose end is rounded or chamfered once the next is known.
    pub corner: Option<Corner>,
    /// Whether that is so because of a tilted plane (G68.2).
    pub is_tilted: bool,
    /// Whether I, J and K say which way the tool points (G43.5).
    pub has_tool_vectors: bool,
    pub moves: Vec<Move>,
    pub notes: Vec<Note>,
    /// Index of the line being executed.
    pub at: usize,
    /// The program's own line that is being executed, from 1: the call's while a subroutine of another file runs.
    pub line: u32,
}

impl<'a> Interpreter<'a> {
    fn new(setup: &'a Setup) -> Self {
        let mut interpreter = Self {
            setup,
            modes: Modes {
                motion: (setup.dialect != Dialect::LinuxCnc).then_some(0),
                plane: setup.plane,
                incremental: false,
                arc_centre_absolute: false,
                feed_mode: if setup.is_fanuc_lathe() { FeedMode::PerRevolution } else { FeedMode::PerMinute },
                inches: setup.units == Some(Units::Inch),
                system: 0,
                diameter: setup.is_fanuc_lathe(),
                retract_to_r: !setup.dialect.is_fanuc_like(),
                constant_surface_speed: false,
                feed: 0.0,
                turning_feed: 0.0,
                speed: 0.0,
                spindle: Spindle::Still,
                driven_rpm: [0.0; 2],
                greatest_speed: None,
                surface_mm_min: 0.0,
                polar: false,
                plain_motion: setup.dialect.is_fanuc_like().then_some(0),
                mist: false,
                flood: false,
                overrides: [true, true, false, true],
            },
            compensation: Compensation::Off,
            spline_leaves: None,
            sticky: Sticky::default(),
            tip_mm: None,
            is_switched: false,
            has_set_output: false,
            is_tilted: false,
            transforms: Transforms::default(),
            corner: None,
            lathe: LatheMemory::default(),
            in_contour: false,
            ignores_compensation: false,
            steps: 0,
            nc_blocks: 0,
            has_tool_vectors: false,
            parameters: Parameters::new(&setup.parameters, setup.dialect),
            offsets: Offsets::default(),
            position: from_canonical(&setup.start),
            tools: setup.tools.clone(),
            spindle_offsets: BTreeMap::new(),
            turns_spindle: false,
            first_zero: None,
            tool: setup.tool,
            selected_tool: setup.tool,
            numbers: OffsetNumbers::default(),
            offset_change: [0.0; 9],
            turned_back: [false; 9],
            before_turn: None,
            waiting_tool: None,
            knows_units: setup.units.is_some(),
            knows_diameter: setup.plane != Plane::Zx || setup.dialect != Dialect::LinuxCnc,
            control: Control::default(),
            moves: Vec::new(),
            notes: Vec::new(),
            at: 0,
            line: 0,
        };
        interpreter.load_datums();
        interpreter.note_units();
        interpreter
    }

    /// Runs the program: what is wrong with it, by the index of the line. Behind the first error it goes on to find what else is wrong
    /// that does not hang on what went wrong before.
    fn run(&mut self, source: &Source) -> Vec<(usize, Fault)> {
        let blocks = &source.blocks;
        let table = match FlowTable::of(blocks, source.own_lines()) {
            Ok(table) => table,
            Err(error) => {
                // Its cause may be a line that cannot be read.
                let error = Some(error).filter(|_| !source.hides_flow);
                return error.into_iter().chain(source.unread_lines()).collect();
            }
        };
        let mut errors: Vec<(usize, Fault)> = Vec::new();
        let mut wrong = BTreeSet::new();
        let mut faults = 0;
        let mut at = 0;
        while self.steps < self.setup.limits.blocks {
            self.steps += 1;
            let next = self.step(source, &table, at);
            if self.parameters.has_full_turn.take() {
                self.note_unknown("ATAN of two arguments is taken to be from 0 to 360 degrees, and ASIN from 270 to 90; with Fanuc's parameter 6004#0 (NAT) at 1 this angle is 360 less".to_owned());
            }
            if let Some(index) = self.parameters.unknown.take() {
                let on_machine = match index {
                    INPUT => "what M66 has read: the input's state, or -1 where it has waited too long",
                    _ => "a clock or a timer",
                };
                self.note_unknown(format!("#{index} is read as 0 here; on the machine it is {on_machine}"));
            }
            match next {
                Ok(Next::Line(next)) => at = next,
                Ok(Next::End) => return errors,
                Err(fault) => {
                    faults += 1;
                    self.in_contour = false;
                    // Where the shifted path has come to is no longer known.
                    self.compensation = Compensation::Off;
                    let gives_up = matches!(fault.cause, Cause::Limit { .. } | Cause::Alarm(_));
                    if errors.is_empty() || (fault.cause.stands_alone() && wrong.insert(self.at)) {
                        wrong.insert(self.at);
                        errors.push((self.at, fault));
                    }
                    if gives_up || faults > MOST_FAULTS {
                        return errors;
                    }
                    at += 1;
                }
            }
        }
        if errors.is_empty() {
            let cause = Cause::Limit { limit: self.setup.limits.blocks, what: "blocks executed" };
            errors.push((self.at, Fault::new(1, "", cause)));
        }
        errors
    }

    /// Executes the line of an index.
    fn step(&mut self, source: &Source, table: &FlowTable, at: usize) -> Result<Next, Fault> {
        let blocks = &source.blocks;
        let Some(block) = blocks.get(at) else { return Ok(Next::End) };
        self.at = at;
        if source.is_own(at) {
            self.line = at as u32 + 1;
        }
        let block = block.as_ref().map_err(Clone::clone)?;
        self.refuse_open_program(source, block, at)?;
        if block.reads_parameters {
            self.refresh_parameters();
        }
        match &block.flow {
            Some(flow) if !block.has_more() => return self.obey_flow(table, blocks, flow, at).map(Next::Line),
            _ => {}
        }
        match self.obey_macro_word(block, table, at)? {
            Some(next) => Ok(Next::Line(next)),
            None => self.execute(block, blocks, table, at),
        }
    }

    /// A fault where a subprogram ends without M99: at its file's end, and in Fanuc's programs at the next O. There the main program must have ended, too.
    fn refuse_open_program(&self, source: &Source, block: &Block, at: usize) -> Result<(), Fault> {
        let next = block.flow.as_ref().filter(|flow| flow.keyword == Keyword::Label && !self.control.began_at(at));
        let next = next.filter(|_| self.setup.dialect.is_fanuc_like());
        let (is_open, why) = if self.control.depth() > 0 {
            (next.is_some() || source.is_end(at), "the subprogram before it is not ended by M99")
        } else {
            let is_open = next.is_some() && source.says_something_before(at);
            (is_open, "the program before it is not ended by M30, M2 or M99")
        };
        if !is_open {
            return Ok(());
        }
        let (column, text) = next.map_or((1, ""), |flow| (flow.column, flow.text.as_str()));
        Err(Fault::new(column, text, Cause::Flow(why)))
    }

    /// Notes what the reader should know, once, with how often it is so.
    pub fn note(&mut self, text: String) {
        self.add_note(text, false);
    }

    /// Notes that the machine may do something else here than the moves show. [`MOST_NOTES`] does not hold back such notes.
    pub fn note_unknown(&mut self, text: String) {
        self.add_note(text, true);
    }

    fn add_note(&mut self, text: String, is_unknown: bool) {
        if let Some(note) = self.notes.iter_mut().find(|note| note.text == text) {
            note.more = note.more.saturating_add(1);
        } else if is_unknown || self.notes.len() < MOST_NOTES {
            self.notes.push(Note { line: self.line, more: 0, is_unknown, text });
        }
    }

    /// Notes which of these words lack a decimal point. Words of lengths are noted without being asked for.
    pub(super) fn note_missing_points(&mut self, values: &Values, letters: &str) {
        for letter in letters.chars().filter(|&letter| values.lacks_point(letter)) {
            self.note_unknown(lacks_point_note(letter));
        }
    }

    /// Notes what the reader should know of words that have turned out to be lengths.
    fn note_lengths(&mut self, values: &Values) {
        values.late_notes().for_each(|note| self.note_unknown(note));
        if !self.knows_units && values.has_length() {
            self.knows_units = true;
            self.note(NO_UNITS_CODE.to_owned());
        }
        if !self.knows_diameter && values.is_length('x') {
            self.knows_diameter = true;
            self.note(NO_DIAMETER_CODE.to_owned());
        }
    }

    /// Executes a block at index `at`: evaluates everything, then assigns, then obeys.
    pub(super) fn execute(
        &mut self,
        block: &Block,
        lines: &Lines,
        table: &FlowTable,
        at: usize,
    ) -> Result<Next, Fault> {
        let values = Values::of(block, &self.parameters, self.setup, self.modes.inches)?;
        values.notes().for_each(|(note, is_unknown)| self.add_note(note.to_owned(), is_unknown));
        self.assign(block)?;
        let says_something = !block.words.is_empty() || (block.sequence.is_some() && block.assignments.is_empty());
        self.nc_blocks += usize::from(says_something && values.code(Group::Subprogram).is_none());
        if values.number(Group::Subprogram) == Some(own::MACRO_CALL) {
            return self.call_macro(table, &values, at);
        }
        self.keep_or_restore_modes(&values)?;
        self.set_feed_and_speed(&values)?;
        self.select_tool(&values)?;
        self.obey_machine_codes(&values, false)?;
        self.obey_coolant_and_overrides(&values)?;
        self.dwell(&values)?;
        self.set_modes(&values)?;
        self.obey_user_code(&values)?;
        self.obey_datum_codes(&values)?;
        let behind_cycle = match values.code(Group::Motion) {
            Some(code) if follows_contour(code.number) => Some(self.contour_cycle(lines, table, &values, code, at)?),
            Some(code) if is_profile_cycle(code.number) => {
                self.profile_cycle(lines, table, &values, code)?;
                Some(at + 1)
            }
            _ => {
                let (first_move, start) = (self.moves.len(), self.position);
                self.obey_motion(&values)?;
                self.note_start_of_spindle(&values, first_move);
                self.note_turned_table(&values, &start);
                None
            }
        };
        self.obey_machine_codes(&values, true)?;
        self.turns_spindle |= self.spindle_rpm() != 0.0;
        self.note_lengths(&values);
        if let Some(next) = behind_cycle {
            values.check_all_used()?;
            return Ok(Next::Line(next));
        }
        if values.number(Group::Stop) == Some(0) && self.setup.dialect.is_fanuc_like() {
            self.stop_spindle();
        }
        let next = match values.number(Group::Stop) {
            Some(2 | 30) => {
                self.refuse_open_corner(&values)?;
                self.note_unchanged_tool();
                self.end_program(table, at)
            }
            _ => self.obey_subprogram(table, &values, at)?,
        };
        values.check_all_used()?;
        if next == Next::End && at < table.own {
            if block.deletable {
                self.note_optional_end(&lines[at + 1..table.own]);
            }
            self.note_more_programs(&lines[at + 1..table.own]);
        }
        Ok(next)
    }

    /// Notes programs of their own behind the end of this one: those that end with M2 or M30.
    fn note_more_programs(&mut self, behind: &Lines) {
        let mut own = None;
        for block in behind.iter().flatten() {
            if let Some(flow) = block.flow.as_ref().filter(|flow| flow.keyword == Keyword::Label) {
                own = Some(flow.text.as_str());
            }
            let ends = |word: &Word| word.letter == 'm' && matches!(word.value.literal(), Some(2.0 | 30.0));
            if let Some(name) = own.take_if(|_| block.words.iter().any(ends)) {
                self.note(format!(
                    "the file has another program, {name}, behind the end of this one: it is not examined"
                ));
            }
        }
    }

    /// Notes the end of the program at a line with `/` where the lines behind it, up to the next program, do more than end it.
    fn note_optional_end(&mut self, behind: &Lines) {
        let begins = |block: &Block| block.flow.as_ref().is_some_and(|flow| flow.keyword == Keyword::Label);
        let ends = |word: &Word| {
            word.letter == 'm'
                && word.value.literal().is_some_and(|code| [0.0, 1.0, 2.0, 5.0, 9.0, 30.0, 99.0].contains(&code))
        };
        let does_more = |block: &Block| block.flow.is_some() || block.jump.is_some() || !block.words.iter().all(ends);
        let mut behind = behind.iter().take_while(|line| !line.as_ref().is_ok_and(begins));
        if behind.any(|line| line.as_ref().map_or(true, does_more)) {
            self.note_unknown("this line with `/` ends the program, so the lines behind it are not examined; `--block-delete` skips it as the switch of the control does".to_owned());
        }
    }

    /// M2 and M30. Grbl goes back to G1, G17, G54, G90, G94, M5 and M9 and runs on (its `gcode.c`, step 21).
    fn end_program(&mut self, table: &FlowTable, at: usize) -> Next {
        if self.setup.dialect != Dialect::Grbl || at >= table.own {
            return Next::End;
        }
        self.select_system(0);
        let modes = &mut self.modes;
        (modes.motion, modes.plane, modes.incremental) = (Some(10), Plane::Xy, false);
        (modes.feed_mode, modes.spindle, modes.driven_rpm) = (FeedMode::PerMinute, Spindle::Still, [0.0; 2]);
        (modes.mist, modes.flood) = (false, false);
        Next::Line(at + 1)
    }

    /// Brings the parameters that mirror the controller's state up to date. On LinuxCNC G40 puts the programmed place back at once.
    pub(super) fn refresh_parameters(&mut self) {
        let mut position = self.position;
        if self.setup.dialect.is_fanuc_like() || !self.compensation.is_leaving() {
            self.compensation.place(&mut position);
        }
        let program = self.offsets.to_program(&position);
        let in_units = |i: usize, value: f64, halved: bool| match Axis::ALL[i] {
            axis if axis.is_rotary() => value,
            Axis::X if halved && self.modes.diameter => 2.0 * value / self.modes.unit_mm(),
            _ => value / self.modes.unit_mm(),
        };
        // LinuxCNC's places are radii under G7, too.
        let halved = self.setup.dialect.is_fanuc_like();
        let relative: Values9 = std::array::from_fn(|i| in_units(i, program[i], halved));
        let unknown = |i: usize| if Axis::ALL[i].is_rotary() { position[i] } else { UNKNOWN };
        let axes = self.machine_coordinates(&position).unwrap_or_else(|_| std::array::from_fn(unknown));
        let absolute: Values9 = std::array::from_fn(|i| in_units(i, axes[i], false));
        let modes = &self.modes;
        let plane = match modes.plane {
            Plane::Xy => 170.0,
            Plane::Zx => 180.0,
            Plane::Yz => 190.0,
        };
        let system = if modes.system < 6 { 540 + 10 * modes.system } else { 585 + modes.system };
        let yes = |condition: bool| f64::from(condition);
        let state = [
            modes.motion.map_or(800.0, f64::from),
            plane,
            system as f64,
            yes(!modes.inches),
            yes(modes.inches),
            yes(!modes.incremental),
            yes(modes.incremental),
            yes(modes.feed_mode == FeedMode::InverseTime),
            yes(modes.feed_mode == FeedMode::PerMinute),
            yes(modes.feed_mode == FeedMode::PerRevolution),
            modes.feed / if modes.feed_mode == FeedMode::InverseTime { 1.0 } else { modes.unit_mm() },
            modes.speed,
            f64::from(self.tool),
            f64::from(self.selected_tool),
            yes(modes.diameter),
            yes(!modes.diameter),
            self.control.depth() as f64,
            f64::from(self.line),
            0.0, // _task: nobody's machine is waiting
            0.0,
            self.compensation.on().map_or(400.0, |offset| f64::from(offset.code)),
            yes(self.offsets.tool != [0.0; 9]),
            yes(modes.retract_to_r),
            yes(!modes.retract_to_r),
            yes(!modes.constant_surface_speed),
            yes(modes.constant_surface_speed),
            yes(modes.arc_centre_absolute),
            yes(modes.spindle != Spindle::Still),
            yes(modes.spindle == Spindle::Clockwise),
            yes(modes.mist),
            yes(modes.flood),
            yes(modes.overrides[1]),
            yes(modes.overrides[0]),
            yes(modes.overrides[2]),
            yes(modes.overrides[3]),
            1.0, // _metric_machine
            LANGUAGE_VERSION[0],
            LANGUAGE_VERSION[1],
        ];
        let parameters = &mut self.parameters;
        parameters.system[..9].copy_from_slice(&relative);
        parameters.system[9..18].copy_from_slice(&absolute);
        parameters.system[18..18 + state.len()].copy_from_slice(&state);
        if self.setup.dialect.is_fanuc_like() {
            let (end, now) = if self.setup.dialect == Dialect::Fanuc {
                let of = |place: Values9| -> Values9 { std::array::from_fn(|i| in_units(i, place[i], true)) };
                // Fanuc's end of a block has no compensation in it.
                (of(self.offsets.to_program(&self.position)), of(self.reading(&position)))
            } else {
                (relative, relative)
            };
            self.refresh_variables(&axes, &end, &now);
            return;
        }
        let tool = self.tools.get(&self.tool).copied().unwrap_or_default();
        let offset = from_canonical(&tool.offset);
        parameters.put(5400, f64::from(self.tool));
        parameters.put(5410, tool.diameter_mm);
        parameters.put(5413, f64::from(tool.orientation));
        for i in 0..9 {
            parameters.put(5401 + i, offset[i]);
            parameters.put(5420 + i, relative[i]);
        }
    }

    /// Assigns parameters: all right-hand sides are evaluated first (NISTIR 6556, section 3.3.2.1).
    pub(super) fn assign(&mut self, block: &Block) -> Result<(), Fault> {
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
                (Target::Numbered(_), index) => self.assign_numbered(index.unwrap_or_default(), value),
            };
            outcome.map_err(|cause| Fault::new(assignment.column, assignment.text.clone(), cause))?;
        }
        Ok(())
    }

    /// `#number = value`. On Fanuc's controls the origin in force takes effect at once.
    fn assign_numbered(&mut self, number: f64, value: f64) -> Result<(), Cause> {
        let from = origin_of(self.modes.system);
        let is_in_force = self.parameters.index(number).is_some_and(|index| (from..from + 9).contains(&index));
        let moves_zero = self.setup.dialect.is_fanuc_like() && is_in_force;
        if moves_zero && self.compensation.on().is_some() {
            return Err(Cause::NotAllowed("another origin of the system in force while cutter compensation is on"));
        }
        self.parameters.assign_numbered(number, value)?;
        if moves_zero {
            self.select_system(self.modes.system);
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
        if self.setup.dialect.is_fanuc_like() {
            // On LinuxCNC F is read in the unit before.
            self.set_units(values);
        }
        if let Some(feed) = values.take('f') {
            if feed < 0.0 {
                return Err(values.fault('f', Cause::Range("F", "at least 0")));
            }
            let scale = if self.modes.feed_mode == FeedMode::InverseTime { 1.0 } else { self.modes.unit_mm() };
            self.modes.feed = feed * scale;
            self.modes.turning_feed = feed;
        }
        if self.limit_speed(values) {
            return Ok(());
        }
        if let Some(speed) = values.take('s') {
            if speed < 0.0 {
                return Err(values.fault('s', Cause::Range("S", "at least 0")));
            }
            self.modes.speed = speed;
        }
        match values.number(Group::SpindleMode) {
            Some(960) => {
                if !values.has('s') {
                    return Err(self.fault_at(values, Group::SpindleMode, Cause::Missing("S, the surface speed,")));
                }
                // Fanuc's limit is that of G50 S, and stays.
                if !self.setup.dialect.is_fanuc_like() {
                    self.modes.greatest_speed = values.take('d').filter(|&limit| limit != 0.0).map(f64::abs);
                }
                self.modes.constant_surface_speed = true;
            }
            Some(_) => self.modes.constant_surface_speed = false,
            None => {}
        }
        if values.has('s') && self.modes.constant_surface_speed {
            // S is feet a minute in G20, metres a minute in G21.
            self.modes.surface_mm_min = self.modes.speed * if self.modes.inches { 304.8 } else { 1000.0 };
        }
        Ok(())
    }

    /// T: the next tool, on Fanuc's and Haas's lathes the tool and its offset.
    fn select_tool(&mut self, values: &Values) -> Result<(), Fault> {
        if self.setup.is_fanuc_lathe() {
            return self.call_lathe_tool(values);
        }
        if let Some(tool) = values.take_whole('t', 0..=99_999, "T", TOOL_NUMBERS)? {
            self.selected_tool = tool.unsigned_abs();
            self.waiting_tool = Some(self.selected_tool);
        }
        Ok(())
    }

    /// M3, M4, M5, M6, M19 and M61, of which some act behind the block's move: on Fanuc's and Haas's controls a change of tools and what stops the
    /// spindle, on Haas's and beside a change of tools what starts it, too.
    fn obey_machine_codes(&mut self, values: &Values, is_behind: bool) -> Result<(), Fault> {
        let changes_tools = values.code(Group::ToolChange).is_some();
        let stops_behind = self.setup.dialect.is_fanuc_like();
        let starts_behind = self.setup.dialect == Dialect::Haas || (stops_behind && changes_tools);
        if stops_behind == is_behind && !self.setup.is_fanuc_lathe() {
            self.change_tool(values)?;
        }
        match values.number(Group::Spindle) {
            Some(3) if starts_behind == is_behind => self.modes.spindle = Spindle::Clockwise,
            Some(4) if starts_behind == is_behind => self.modes.spindle = Spindle::Counterclockwise,
            Some(5) if stops_behind == is_behind => self.stop_spindle(),
            _ => {}
        }
        if is_behind {
            self.drive(values)?;
        }
        if stops_behind == is_behind { self.orient_spindle(values) } else { Ok(()) }
    }

    /// Stops the spindle. Driven tools and sub spindles of Fanuc's and Haas's lathes turn on: they have codes of their own.
    fn stop_spindle(&mut self) {
        self.modes.spindle = Spindle::Still;
        if !self.setup.is_fanuc_lathe() {
            self.modes.driven_rpm = [0.0; 2];
        }
    }

    /// Haas's M133, M134, M135 (the driven tool forward, backward, off), and M143, M144, M145 (the sub spindle): P is the speed.
    fn drive(&mut self, values: &Values) -> Result<(), Fault> {
        let Some(code) = values.code(Group::Driven) else { return Ok(()) };
        let speed = values.take('p').filter(|speed| *speed >= 0.0);
        let missing = || code.fault(Cause::Missing("P, the speed, at least 0,"));
        if matches!(code.number, 143 | 144) {
            let told = "which of main and sub spindle holds the workpiece that is cut is not known: either counts as turning it";
            self.note_unknown(told.to_owned());
        }
        self.modes.driven_rpm[usize::from(code.number > 140)] = match code.number % 10 {
            3 => speed.ok_or_else(missing)?,
            4 => -speed.ok_or_else(missing)?,
            _ => 0.0,
        };
        Ok(())
    }

    /// Notes that M3 or M4 of Fanuc's controls stands beside a feed move; the block's moves begin at the index `first_move`.
    fn note_start_of_spindle(&mut self, values: &Values, first_move: usize) {
        let starts = matches!(values.number(Group::Spindle), Some(3 | 4)) && values.code(Group::ToolChange).is_none();
        let feeds = |step: &Move| step.kind.is_feed();
        if starts && self.setup.dialect == Dialect::Fanuc && self.moves.iter().skip(first_move).any(feeds) {
            self.note_unknown("M3 or M4 beside a feed move is taken to start the spindle before the move; on some machines it acts behind it".to_owned());
        }
    }

    fn change_tool(&mut self, values: &Values) -> Result<(), Fault> {
        if values.code(Group::ToolChange).is_some() {
            self.waiting_tool = None;
        }
        match values.number(Group::ToolChange) {
            Some(6) => {
                let why = "another tool while cutter compensation is on";
                self.refuse_compensated(values, Group::ToolChange, why)?;
                self.stop_spindle();
                self.go_to_tool_change(values)?;
                self.tool = self.selected_tool;
                self.emit(MoveKind::ToolChange { tool: self.tool }, None)?;
            }
            Some(_) => {
                let tool = values.take_whole('q', 0..=99_999, "Q", TOOL_NUMBERS)?;
                let Some(tool) = tool else {
                    return Err(self.fault_at(values, Group::ToolChange, Cause::Missing("Q, the tool's number,")));
                };
                if tool.unsigned_abs() != self.tool {
                    self.tool = tool.unsigned_abs();
                    self.emit(MoveKind::ToolChange { tool: self.tool }, None)?;
                }
            }
            None => {}
        }
        Ok(())
    }

    /// M19: the spindle stands where R says.
    fn orient_spindle(&mut self, values: &Values) -> Result<(), Fault> {
        if values.code(Group::Orient).is_none() {
            return Ok(());
        }
        self.stop_spindle();
        self.turns_spindle = true;
        values.take('r');
        if self.setup.dialect.is_fanuc_like() {
            // An angle.
            values.take('p');
        } else {
            values.take_whole('p', 0..=2, "P", "0, 1 or 2")?;
        }
        values.take('q');
        Ok(())
    }

    /// Coolant and overrides move nothing; their words are checked all the same.
    fn obey_coolant_and_overrides(&mut self, values: &Values) -> Result<(), Fault> {
        let may_be_all =
            values.has('s') || [Group::Spindle, Group::SpindleMode].iter().any(|&g| values.code(g).is_some());
        let least = -i32::from(may_be_all);
        values.take_whole('$', least..=0, "$", "0, or with S, M3, M4 and M5 -1 for all: there is one spindle")?;
        match values.number(Group::Coolant) {
            Some(7) => self.modes.mist = true,
            Some(8) => self.modes.flood = true,
            Some(_) => (self.modes.mist, self.modes.flood) = (false, false),
            None => {}
        }
        if values.number(Group::Signal) == Some(own::ASK_OPERATOR) {
            self.ask_operator(values)?;
        }
        if values.number(Group::Signal) == Some(66) {
            self.parameters.read_input();
        }
        // Inputs and outputs of a controller that is not there.
        if let Some(code) = values.number(Group::Signal) {
            self.has_set_output |= matches!(code, 67 | 68) && self.setup.dialect == Dialect::LinuxCnc;
            for letter in ['p', 'e', 'l', 'q'] {
                values.take(letter);
            }
        }
        if let Some(code) = values.number(Group::Override) {
            let overrides = &mut self.modes.overrides;
            if code < 50 {
                (overrides[0], overrides[1]) = (code == 48, code == 48);
            } else {
                let on = values.take_whole('p', 0..=1, "P", "0 or 1")?.unwrap_or(1);
                overrides[(code - 50).unsigned_abs() as usize] = on == 1;
            }
        }
        Ok(())
    }

    fn dwell(&mut self, values: &Values) -> Result<(), Fault> {
        if values.number(Group::NonModal) != Some(40) {
            return Ok(());
        }
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        let letter = ['p', 'x', 'u']
            .into_iter()
            .find(|&letter| values.has(letter) && (letter == 'p' || like_fanuc))
            .unwrap_or('p');
        match self.take_dwell(values, letter) {
            Some(seconds) if seconds >= 0.0 => self.emit(MoveKind::Dwell { seconds }, None),
            Some(_) => Err(values.fault(letter, Cause::Range("a dwell", "at least 0"))),
            None if like_fanuc => Ok(()),
            None => {
                let missing = "P, the time in seconds (X, U, or P in milliseconds in the dialects fanuc and haas),";
                Err(self.fault_at(values, Group::NonModal, Cause::Missing(missing)))
            }
        }
    }

    /// Notes that a tool was selected and none is ever put into the spindle. Behind a change it is one that is got ready.
    fn note_unchanged_tool(&mut self) {
        let changes = self.moves.iter().any(|step| matches!(step.kind, MoveKind::ToolChange { .. }));
        if let Some(tool) = self.waiting_tool.take().filter(|&tool| tool != self.tool && !changes) {
            self.note(format!(
                "T{tool} selects a tool that no M6 changes to; on Fanuc's and Haas's lathes T0101 does both (dialect `fanuc`)"
            ));
        }
    }

    /// A fault at a block's code.
    pub fn fault_at(&self, values: &Values, group: Group, cause: Cause) -> Fault {
        values.fault_at(group, cause)
    }

    /// Records a move that ends where the machine is.
    pub fn emit(&mut self, kind: MoveKind, feed_mm_min: Option<f64>) -> Result<(), Fault> {
        if let Some(corner) = &self.corner {
            return Err(Fault::new(1, corner.text.clone(), OPEN_CORNER));
        }
        let limit = self.setup.limits.moves;
        if self.moves.len() >= limit {
            return Err(Fault::new(1, "", Cause::Limit { limit, what: "moves" }));
        }
        let mut position = self.position;
        self.compensation.place(&mut position);
        if let Some((axis, _)) = Axis::ALL.into_iter().zip(position).find(|(_, x)| x.is_nan() || x.abs() > FARTHEST) {
            return Err(Fault::new(1, axis.letter(), Cause::Domain("an axis farther than 1e9 from zero")));
        }
        let end = to_canonical(&position);
        if matches!(kind, MoveKind::Rapid | MoveKind::Feed | MoveKind::Arc { .. }) {
            self.note_waiting_length();
            self.note_unknown_kinematics(&position);
        }
        if kind.is_feed() && self.modes.system == 0 && self.first_zero.is_none() {
            self.first_zero = Some((self.line, self.offsets.zero()));
        }
        let [turns_workpiece, turns_tool] = self.turning();
        self.moves.push(Move {
            line: self.line,
            kind,
            end,
            tip_mm: self.tip_mm,
            is_tilted: self.is_tilted && self.tip_mm.is_some(),
            is_probe: false,
            feed_mm_min,
            spindle_rpm: self.spindle_rpm(),
            turns_workpiece,
            turns_tool,
        });
        Ok(())
    }
}
