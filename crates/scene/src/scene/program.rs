//! The program of a scene, from the file to canonical moves.

use super::assembly::ToolEntry;
use super::error::SceneError;
use super::file::{ControllerFile, PositionFile, ProgramFile, ToolFile, UserCodeFile};
use crate::machine::Machine;
use crate::machine::tip::{TipControl, TipError};
use rs274::file::LARGEST_PROGRAM;
use rs274::setup::MORE_OFFSETS;
use rs274::{
    Axis, Dialect, MAX_SAMPLES, Move, MoveKind, Position, RapidPath, Sample, Sampling, Setup, TooManySamples, UserCode,
};
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// An interpreted program, and the settings under which it runs.
#[derive(Clone, Debug)]
pub struct ProgramRun {
    /// Path of the file, for messages.
    pub file: PathBuf,
    /// BLAKE3 of the file's bytes, as hexadecimal text.
    pub hash: String,
    /// Its moves.
    pub program: rs274::Program,
    /// The controller's initial state, including the machine's position.
    pub setup: Setup,
    /// The links that carry tool and workpiece, if the scene defines them.
    pub tip: Option<TipControl>,
    /// Initial position of the machine, mm and radians.
    pub start: Position,
    /// Sampling that the scene asks for.
    pub sampling: Sampling,
}

/// Names of the work offsets, in the order of [`Setup::work_offsets`].
const WORK_OFFSETS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// Difference below which two places of zero are the same, mm and radians.
const SAME_ZERO: f64 = 1e-6;

/// An invalid value: its byte range in the file, and a message.
pub(super) type Nonsense = (Range<usize>, String);

/// The controller's initial state from the scene file.
pub(super) fn setup(file: &ProgramFile) -> Result<Setup, Nonsense> {
    let mut setup = match file.controller {
        ControllerFile::Mill => Setup::default(),
        ControllerFile::Lathe => Setup::lathe(),
    };
    let position = |what: &str, file: &Option<Spanned<PositionFile>>| match file {
        Some(file) => finite(what, file.get_ref().position()).map_err(|message| (file.span(), message)),
        None => Ok(Position::default()),
    };
    setup.start = position("start", &file.start)?;
    setup.home = position("home", &file.home)?;
    if file.second_home.is_some() {
        setup.second_home = Some(position("second_home", &file.second_home)?);
    }
    for (letter, value) in &file.tool_change {
        let wrong = |message| (value.span(), format!("tool_change: {message}"));
        let axis = letter.parse().ok().and_then(Axis::from_letter);
        let axis = axis.ok_or_else(|| wrong(format!("`{letter}` is not an axis; the axes are X Y Z A B C U V W")))?;
        let value = Some(*value.get_ref()).filter(|value| value.is_finite());
        let value = value.ok_or_else(|| wrong(format!("{letter} is not finite")))?;
        setup.tool_change[axis as usize] = Some(if axis.is_rotary() { value.to_radians() } else { value });
    }
    setup.tool = file.tool;
    setup.dialect_is_assumed = file.dialect.is_none();
    if let Some(dialect) = &file.dialect {
        setup.dialect = dialect.get_ref().parse().map_err(|message| (dialect.span(), message))?;
    }
    if let Some(units) = &file.units {
        setup.units = Some(units.get_ref().parse().map_err(|message| (units.span(), message))?);
    }
    for code in &file.ignored_codes {
        setup.ignored.insert(code.get_ref().parse().map_err(|message| (code.span(), message))?);
    }
    for (name, origin) in &file.work_offsets {
        let wrong = |message| (origin.span(), message);
        let place = work_offset(&mut setup, name).map_err(|message| wrong(format!("work_offsets: {message}")))?;
        *place = finite(&format!("work_offsets.{name}"), origin.get_ref().position()).map_err(wrong)?;
    }
    for (name, code) in &file.user_codes {
        let number = name.strip_prefix(['M', 'm']).and_then(|digits| digits.parse().ok());
        let number = number.ok_or_else(|| (code.span(), format!("`{name}` is not an M code, as in M428")))?;
        setup.user_codes.insert(
            number,
            match code.get_ref() {
                UserCodeFile::ToolCentrePointOn => UserCode::TipOn,
                UserCodeFile::ToolCentrePointOff => UserCode::TipOff,
                UserCodeFile::SpindleOn => UserCode::SpindleOn,
                UserCodeFile::SpindleOff => UserCode::SpindleOff,
                UserCodeFile::Ignore => UserCode::Ignore,
            },
        );
    }
    for (spanned, entry) in file.tools.iter().zip(tools(&file.tools)?) {
        if setup.tools.insert(entry.number, entry.tool).is_some() {
            return Err((spanned.span(), format!("there are two tools with number {}", entry.number)));
        }
    }
    Ok(setup)
}

/// The origin of a work offset, which is known from then on, by its name: `G54` to `G59.3`, in Fanuc's and Haas's dialects `G54.1P1` and on, too, and in Haas's `G154P1`.
fn work_offset<'a>(setup: &'a mut Setup, name: &str) -> Result<&'a mut Position, String> {
    let name = name.to_ascii_uppercase().replace(' ', "");
    if let Some(index) = WORK_OFFSETS.iter().position(|known| *known == name) {
        setup.known_offsets[index] = true;
        return Ok(&mut setup.work_offsets[index].origin);
    }
    let families = [("G54.1P", MORE_OFFSETS), ("G154P", 99)];
    let count = match setup.dialect {
        Dialect::LinuxCnc | Dialect::Grbl => 0,
        Dialect::Fanuc => 1,
        Dialect::Haas => 2,
    };
    let families = &families[..count];
    let number = families.iter().find_map(|&(family, most)| {
        let number = name.strip_prefix(family)?.parse::<u32>().ok()?;
        (1..=most).contains(&number).then_some(number)
    });
    let more = || families.iter().map(|(family, most)| format!(", {family}1 to {family}{most}")).collect::<String>();
    let number = number.ok_or_else(|| format!("`{name}` is not one of {}{}", WORK_OFFSETS.join(", "), more()))?;
    Ok(setup.more_work_offsets.entry(number).or_default())
}

/// The tools of a table or a library.
pub(super) fn tools(files: &[Spanned<ToolFile>]) -> Result<Vec<ToolEntry>, Nonsense> {
    let read = |file: &Spanned<ToolFile>| {
        let wrong = |message| (file.span(), format!("tool {}: {message}", file.get_ref().number));
        ToolEntry::new(file.get_ref()).map_err(wrong)
    };
    files.iter().map(read).collect()
}

/// The sampling from the scene file.
pub(super) fn sampling(file: &ProgramFile) -> Result<Sampling, Nonsense> {
    let default = Sampling::default();
    Ok(Sampling {
        step_mm: positive("step_mm", file.step_mm.as_ref())?.unwrap_or(default.step_mm),
        step_deg: positive("step_deg", file.step_deg.as_ref())?.unwrap_or(default.step_deg),
        chord_mm: positive("chord_mm", file.chord_mm.as_ref())?.unwrap_or(default.chord_mm),
    })
}

/// The number, if one is given; it must be finite and above 0.
pub(super) fn positive(name: &str, value: Option<&Spanned<f64>>) -> Result<Option<f64>, Nonsense> {
    let Some(spanned) = value else { return Ok(None) };
    match *spanned.get_ref() {
        value if value > 0.0 && value.is_finite() => Ok(Some(value)),
        value => Err((spanned.span(), format!("{name} is {value}; it must be a finite number above 0"))),
    }
}

/// The machine cannot follow the path of the tool's tip.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}: {cause}", file = file.display())]
pub struct TipFault {
    /// The program.
    pub file: PathBuf,
    /// Line.
    pub line: u32,
    /// Why.
    pub cause: TipCause,
}

/// Why the machine cannot follow the path.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TipCause {
    /// The scene does not define which links carry tool and workpiece.
    #[error("tool-centre-point control needs `[program.tool_centre_point]` in the scene")]
    NoLinks,
    /// The path is too long.
    #[error(transparent)]
    TooManySamples(#[from] TooManySamples),
    /// The axes cannot reach the position.
    #[error(transparent)]
    Machine(#[from] TipError),
}

/// A place on the way of a tool's tip.
#[derive(Clone, Copy)]
struct Followed {
    /// As the program says it.
    programmed: Position,
    /// Where the axes are then.
    axes: Position,
    /// How much of the move is done.
    fraction: f64,
}

/// Most halvings of the way between two samples of a tip's path: of a turn of ten million degrees each is 0.6 degrees long.
const HALVINGS: u32 = 24;

/// Widest turn over which the way is asked at its quarters, radians: at those of whole turns the tip's lead is nowhere to be seen.
const WIDEST_ASKED: f64 = std::f64::consts::FRAC_PI_6;

/// Gives the places between two at which the way has to be divided, so that the axes stay within `chord_mm` of the straight way from one to
/// the next: asked at its quarters.
fn bend(
    [from, to]: [&Followed; 2],
    axes: &impl Fn(&Position) -> Result<Position, TipFault>,
    chord_mm: f64,
    halvings: u32,
    give: &mut impl FnMut(Followed) -> Result<(), TipFault>,
) -> Result<(), TipFault> {
    let rotary = Axis::ALL.into_iter().filter(|axis| axis.is_rotary());
    let turn = rotary.map(|axis| (to.programmed[axis] - from.programmed[axis]).abs()).fold(0.0, f64::max);
    if turn == 0.0 || halvings == 0 {
        return Ok(());
    }
    let between = |from: &Position, to: &Position, part: f64| {
        Position(std::array::from_fn(|i| from.0[i] + part * (to.0[i] - from.0[i])))
    };
    let mut is_straight = turn <= WIDEST_ASKED;
    for part in [0.25, 0.5, 0.75] {
        let (found, chord) =
            (axes(&between(&from.programmed, &to.programmed, part))?, between(&from.axes, &to.axes, part));
        let off = [Axis::X, Axis::Y, Axis::Z].map(|axis| (found[axis] - chord[axis]).powi(2));
        is_straight &= off.iter().sum::<f64>().sqrt() <= chord_mm;
    }
    if is_straight {
        return Ok(());
    }
    let programmed = between(&from.programmed, &to.programmed, 0.5);
    let middle = Followed { axes: axes(&programmed)?, programmed, fraction: 0.5 * (from.fraction + to.fraction) };
    bend([from, &middle], axes, chord_mm, halvings - 1, give)?;
    give(middle)?;
    bend([&middle, to], axes, chord_mm, halvings - 1, give)
}

impl ProgramRun {
    /// Another program under the same controller, machine position and sampling.
    ///
    /// # Errors
    /// When the program cannot be read or interpreted.
    pub fn with_program(&self, path: &Path) -> Result<Self, SceneError> {
        let missing = |cause| SceneError::Read { file: path.to_owned(), cause };
        let bytes = rs274::file::bytes(path, LARGEST_PROGRAM).map_err(missing)?;
        let hash = blake3::hash(&bytes).to_hex().to_string();
        run(&rs274::file::decode(bytes), path.to_owned(), hash, &self.setup, self.tip.clone(), self.sampling)
    }

    /// The program's path in axis positions.
    ///
    /// # Errors
    /// The line on which the path has too many samples, or the first line on which the axes cannot follow the tool's tip.
    pub fn samples(&self, machine: &Machine, sampling: &Sampling, rapids: &RapidPath) -> Result<Vec<Sample>, TipFault> {
        // Where the tip goes along an arc, the arc takes one half of the tolerance and the axes that follow the other.
        let is_bent = |step: &Move| step.tip_mm.is_some() && matches!(step.kind, MoveKind::Arc { .. });
        let halves = if self.program.moves.iter().any(is_bent) { 0.5 } else { 1.0 };
        let sampling = Sampling { chord_mm: halves * sampling.chord_mm, ..*sampling };
        let samples = rs274::sample(&self.program, &self.start, &sampling, rapids);
        let samples = samples.map_err(|cause| self.tip_fault(cause.line, cause.into()))?;
        self.follow_tip(machine, samples, sampling.chord_mm)
    }

    fn tip_fault(&self, line: u32, cause: TipCause) -> TipFault {
        TipFault { file: self.file.clone(), line, cause }
    }

    /// Converts samples of the tip's path to axis positions, by moving the linear axes, with more samples where these would leave the way
    /// between two by more than `chord_mm`. Other samples are unchanged.
    fn follow_tip(&self, machine: &Machine, samples: Vec<Sample>, chord_mm: f64) -> Result<Vec<Sample>, TipFault> {
        let mut followed: Vec<Sample> = Vec::with_capacity(samples.len());
        let mut before: Option<Sample> = None;
        for sample in samples {
            let Some(length) = self.program.moves[sample.move_index].tip_mm else {
                followed.push(sample);
                before = None;
                continue;
            };
            let last = followed.last().map(|last| last.position);
            let control = self.tip.as_ref().ok_or_else(|| self.tip_fault(sample.line, TipCause::NoLinks))?;
            let axes = |programmed: &Position| {
                let found = control.axes(machine, programmed, length);
                found.map_err(|error| self.tip_fault(sample.line, TipCause::Machine(error)))
            };
            let mut follow = |next: Sample| {
                followed.push(next);
                let is_too_many = || self.tip_fault(sample.line, TooManySamples { line: sample.line }.into());
                if followed.len() > MAX_SAMPLES { Err(is_too_many()) } else { Ok(()) }
            };
            let to = Followed { programmed: sample.position, axes: axes(&sample.position)?, fraction: sample.fraction };
            if let (Some(before), Some(last)) = (before, last) {
                let fraction = if before.move_index == sample.move_index { before.fraction } else { 0.0 };
                let from = Followed { programmed: before.position, axes: last, fraction };
                bend([&from, &to], &axes, chord_mm, HALVINGS, &mut |between| {
                    follow(Sample { position: between.axes, fraction: between.fraction, ..sample })
                })?;
            }
            follow(Sample { position: to.axes, ..sample })?;
            before = Some(sample);
        }
        Ok(followed)
    }

    /// Text of a line of the program.
    pub fn block(&self, line: u32) -> &str {
        let index = (line as usize).checked_sub(1);
        index.and_then(|index| self.program.blocks.get(index)).map_or("", |block| block.trim())
    }

    /// The tool in the spindle during each move, 0 for none; the move of a tool change has the new tool.
    pub fn tools(&self) -> Vec<u32> {
        let mut tool = self.setup.tool;
        let during = |step: &Move| {
            if let MoveKind::ToolChange { tool: new } = step.kind {
                tool = new;
            }
            tool
        };
        self.program.moves.iter().map(during).collect()
    }

    /// Real paths of the files of subroutines that were read.
    pub fn called_files(&self) -> impl Iterator<Item = PathBuf> {
        self.program.called_files.iter().filter_map(|file| file.canonicalize().ok())
    }

    /// Sets the origin of a work offset (`G54` to `G59.3`; `G54.1P1` and on, and Haas's `G154P1` and on), machine coordinates, mm and radians, in the axes
    /// that `axes` gives, in the order of [`Axis::ALL`]; the others keep theirs. As on the control's offset page, and in G10 L2, X of Fanuc's and Haas's
    /// lathes is a diameter.
    ///
    /// # Errors
    /// A message when there is no offset of that name, or the origin is not finite.
    pub fn set_work_offset(&mut self, name: &str, mut axes: [Option<f64>; 9]) -> Result<(), String> {
        if self.setup.is_fanuc_lathe() {
            axes[Axis::X as usize] = axes[Axis::X as usize].map(|diameter| diameter / 2.0);
        }
        let origin = work_offset(&mut self.setup, name)?;
        let moved = std::array::from_fn(|index| axes[index].unwrap_or(origin.0[index]));
        *origin = finite(name, Position(moved))?;
        Ok(())
    }

    /// Adds a note where the first feed in G54 is from another zero than the origin of G54 before the program, at which stock was put.
    pub fn note_moved_zero(&mut self) {
        let Some((line, zero)) = self.program.first_zero else { return };
        let before = self.setup.work_offsets[0];
        let moved = zero.origin.0.iter().zip(before.origin.0).any(|(now, before)| (now - before).abs() > SAME_ZERO);
        let turned = (zero.rotation - before.rotation).abs() > SAME_ZERO;
        if !moved && !turned {
            return;
        }
        let doubled = self.setup.is_fanuc_lathe();
        let place = Axis::ALL.map(|axis| match zero.origin[axis] {
            value if axis.is_rotary() => value.to_degrees(),
            value if axis == Axis::X && doubled => 2.0 * value,
            value => value,
        });
        let count = if zero.origin.0[3..] == before.origin.0[3..] { 3 } else { 9 };
        // Adding zero takes the sign from it.
        let place = place[..count].iter().map(|value| ((value * 1e6).round() / 1e6 + 0.0).to_string());
        let place = place.collect::<Vec<_>>().join(",");
        let turn = if turned { ", but does not turn it as G54 is turned" } else { "" };
        let text = format!(
            "the first feed in G54 is from another zero (G10, G52, G92 or a parameter) than before the program, where the stock stays: `--offset G54={place}` puts it there{turn}; where G52 or G92 shifts G54, move the stock by its @X,Y,Z instead"
        );
        self.program.notes.push(rs274::Note { line, more: 0, is_unknown: true, text });
    }

    /// Interprets the same program again, after a change of [`ProgramRun::setup`].
    ///
    /// # Errors
    /// When the program cannot be interpreted.
    pub fn again(&self) -> Result<Self, SceneError> {
        let source = self.program.blocks.join("\n");
        run(&source, self.file.clone(), self.hash.clone(), &self.setup, self.tip.clone(), self.sampling)
    }

    /// A run without moves, with the controller of a mill that starts at zero, for a scene without a program.
    pub fn of_mill() -> Self {
        let setup = Setup { dialect_is_assumed: true, ..Setup::default() };
        deferred("", PathBuf::new(), String::new(), &setup, None, Sampling::default())
    }
}

/// A program that has not been run: it has no moves until [`ProgramRun::again`].
pub(super) fn deferred(
    source: &str,
    path: PathBuf,
    hash: String,
    setup: &Setup,
    tip: Option<TipControl>,
    sampling: Sampling,
) -> ProgramRun {
    let blocks = source.lines().map(str::to_owned).collect();
    let program = rs274::Program {
        moves: Vec::new(),
        blocks,
        notes: Vec::new(),
        called_files: Vec::new(),
        tools: setup.tools.clone(),
        turns_spindle: false,
        first_zero: None,
        kinematics: setup.kinematics.clone(),
    };
    ProgramRun { file: path, hash, program, setup: setup.clone(), tip, start: setup.start, sampling }
}

/// Interprets the program of a file whose bytes have this hash.
pub(super) fn run(
    source: &str,
    path: PathBuf,
    hash: String,
    setup: &Setup,
    tip: Option<TipControl>,
    sampling: Sampling,
) -> Result<ProgramRun, SceneError> {
    let program = rs274::interpret(source, &path, setup)?;
    Ok(ProgramRun { program, ..deferred("", path, hash, setup, tip, sampling) })
}

/// Returns the position if all of it is finite, and otherwise a message.
pub(super) fn finite(what: &str, position: Position) -> Result<Position, String> {
    if position.0.iter().all(|x| x.is_finite()) { Ok(position) } else { Err(format!("{what} is not finite")) }
}
