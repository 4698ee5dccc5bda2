//! The program of a scene: from the file to canonical moves.

use super::error::SceneError;
use super::file::{ControllerFile, ProgramFile, UserCodeFile};
use crate::gcode::{self, Position, RapidPath, Sample, Sampling, Setup, TooManySamples, Tool, UserCode, WorkOffset};
use crate::machine::Machine;
use crate::machine::tip::{TipControl, TipError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A program, interpreted, and how to run it.
#[derive(Clone, Debug)]
pub struct ProgramRun {
    /// Its file, for messages.
    pub file: PathBuf,
    /// Its moves.
    pub program: gcode::Program,
    /// What the controller knows at first, the machine's position among it.
    pub setup: Setup,
    /// Which links carry tool and workpiece, where the scene says so.
    pub tip: Option<TipControl>,
    /// Where the machine stands at first, mm and radians.
    pub start: Position,
    /// How finely the scene wants it sampled.
    pub sampling: Sampling,
}

/// Names of the work offsets, in the order of [`Setup::work_offsets`].
const WORK_OFFSETS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// What the controller knows, as the scene file says it. `Err` is a message.
pub(super) fn setup(file: &ProgramFile) -> Result<Setup, String> {
    let mut setup = match file.controller {
        ControllerFile::Mill => Setup::default(),
        ControllerFile::Lathe => Setup::lathe(),
    };
    setup.start = finite("start", file.start.position())?;
    setup.home = finite("home", file.home.position())?;
    setup.tool = file.tool;
    for (name, origin) in &file.work_offsets {
        let index = WORK_OFFSETS.iter().position(|known| known == name);
        let index = index.ok_or_else(|| format!("`{name}` is not one of {}", WORK_OFFSETS.join(", ")))?;
        setup.work_offsets[index] = WorkOffset { origin: finite(name, origin.position())?, rotation: 0.0 };
    }
    for (name, &code) in &file.user_codes {
        let number = name.strip_prefix(['M', 'm']).and_then(|digits| digits.parse().ok());
        let number = number.ok_or_else(|| format!("`{name}` is not an M code, as in M428"))?;
        setup.user_codes.insert(
            number,
            match code {
                UserCodeFile::ToolCentrePointOn => UserCode::TipOn,
                UserCodeFile::ToolCentrePointOff => UserCode::TipOff,
                UserCodeFile::Ignore => UserCode::Ignore,
            },
        );
    }
    for tool in &file.tools {
        let offset = finite("a tool's offset", tool.offset.position())?;
        if !(tool.diameter_mm >= 0.0 && tool.diameter_mm.is_finite()) {
            return Err(format!("tool {}: diameter_mm must be a finite number, at least 0", tool.number));
        }
        if tool.orientation > 9 {
            return Err(format!("tool {}: orientation must be from 0 to 9", tool.number));
        }
        if setup
            .tools
            .insert(tool.number, Tool { offset, diameter_mm: tool.diameter_mm, orientation: tool.orientation })
            .is_some()
        {
            return Err(format!("there are two tools with number {}", tool.number));
        }
    }
    Ok(setup)
}

/// How finely to sample, as the scene file says it. `Err` is a message.
pub(super) fn sampling(file: &ProgramFile) -> Result<Sampling, String> {
    let default = Sampling::default();
    let positive = |name: &str, value: Option<f64>, default: f64| match value.unwrap_or(default) {
        value if value > 0.0 && value.is_finite() => Ok(value),
        value => Err(format!("{name} is {value}; it must be a finite number above 0")),
    };
    Ok(Sampling {
        step_mm: positive("step_mm", file.step_mm, default.step_mm)?,
        step_deg: positive("step_deg", file.step_deg, default.step_deg)?,
        chord_mm: positive("chord_mm", file.chord_mm, default.chord_mm)?,
    })
}

/// A path that the machine cannot follow.
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

/// Why the machine cannot follow.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TipCause {
    /// Nobody says which links carry tool and workpiece.
    #[error("tool-centre-point control needs `[program.tool_centre_point]` in the scene")]
    NoLinks,
    /// The path is too long.
    #[error(transparent)]
    TooManySamples(#[from] TooManySamples),
    /// The axes cannot.
    #[error(transparent)]
    Machine(#[from] TipError),
}

impl ProgramRun {
    /// Another program under the same controller, machine position and sampling.
    ///
    /// # Errors
    /// When the program cannot be read or interpreted.
    pub fn with_program(&self, path: &Path) -> Result<Self, SceneError> {
        let missing = |cause| SceneError::Read { file: path.to_owned(), cause };
        let source = std::fs::read(path).map_err(missing)?;
        run(&String::from_utf8_lossy(&source), path.to_owned(), &self.setup, self.tip.clone(), self.sampling)
    }

    /// The program's path in axis positions.
    ///
    /// # Errors
    /// The line on which it has too many samples, or the first on which the axes cannot follow the tool's tip.
    pub fn samples(&self, machine: &Machine, sampling: &Sampling, rapids: &RapidPath) -> Result<Vec<Sample>, TipFault> {
        let mut samples = gcode::sample(&self.program, &self.start, sampling, rapids).map_err(|cause| TipFault {
            file: self.file.clone(),
            line: cause.line,
            cause: cause.into(),
        })?;
        self.follow_tip(machine, &mut samples)?;
        Ok(samples)
    }

    /// Turns samples of the tip's way into axis positions: the linear axes follow. Other samples stay as they are.
    fn follow_tip(&self, machine: &Machine, samples: &mut [Sample]) -> Result<(), TipFault> {
        for sample in samples {
            let Some(length) = self.program.moves[sample.move_index].tip_mm else { continue };
            let fault = |cause| TipFault { file: self.file.clone(), line: sample.line, cause };
            let tip = self.tip.as_ref().ok_or_else(|| fault(TipCause::NoLinks))?;
            sample.position =
                tip.axes(machine, &sample.position, length).map_err(|error| fault(TipCause::Machine(error)))?;
        }
        Ok(())
    }

    /// The tool in the spindle during each move, 0 for none; a tool change has the new one.
    #[must_use]
    pub fn tools(&self) -> Vec<u32> {
        let mut tool = self.setup.tool;
        let during = |step: &gcode::Move| {
            if let gcode::MoveKind::ToolChange { tool: new } = step.kind {
                tool = new;
            }
            tool
        };
        self.program.moves.iter().map(during).collect()
    }

    /// The same program, interpreted again: after a change of [`ProgramRun::setup`].
    ///
    /// # Errors
    /// When the program cannot be interpreted.
    pub fn again(&self) -> Result<Self, SceneError> {
        let source = self.program.blocks.join("\n");
        run(&source, self.file.clone(), &self.setup, self.tip.clone(), self.sampling)
    }

    /// For a scene without a program: no moves, and a mill's controller that starts at zero.
    #[must_use]
    pub fn of_mill() -> Self {
        let program = gcode::Program { moves: Vec::new(), blocks: Vec::new() };
        let setup = Setup::default();
        let start = setup.start;
        Self { file: PathBuf::new(), program, setup, tip: None, start, sampling: Sampling::default() }
    }
}

/// Interprets the program.
pub(super) fn run(
    source: &str,
    path: PathBuf,
    setup: &Setup,
    tip: Option<TipControl>,
    sampling: Sampling,
) -> Result<ProgramRun, SceneError> {
    let program = gcode::interpret(source, &path, setup)?;
    Ok(ProgramRun { file: path, program, setup: setup.clone(), tip, start: setup.start, sampling })
}

/// The position, when all of it is finite. `Err` is a message.
pub(super) fn finite(what: &str, position: Position) -> Result<Position, String> {
    if position.0.iter().all(|x| x.is_finite()) { Ok(position) } else { Err(format!("{what} is not finite")) }
}
