//! Canonical moves: what a program means once every mode, offset, unit and expression is resolved.

use std::fmt::Write;

/// The nine axes of ISO 841 as RS274/NGC uses them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum Axis {
    X,
    Y,
    Z,
    A,
    B,
    C,
    U,
    V,
    W,
}

impl Axis {
    /// All axes in the order of [`Position`].
    pub const ALL: [Self; 9] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C, Self::U, Self::V, Self::W];

    /// Whether the axis turns (A, B, C).
    #[must_use]
    pub const fn is_rotary(self) -> bool {
        matches!(self, Self::A | Self::B | Self::C)
    }

    /// Its letter.
    #[must_use]
    pub const fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'][self as usize]
    }

    /// The axis of an upper- or lower-case letter.
    #[must_use]
    pub fn from_letter(letter: char) -> Option<Self> {
        Self::ALL.into_iter().find(|axis| axis.letter() == letter.to_ascii_uppercase())
    }
}

/// A value per axis: mm for linear axes, radians for rotary ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position(pub [f64; 9]);

impl std::ops::Index<Axis> for Position {
    type Output = f64;
    fn index(&self, axis: Axis) -> &f64 {
        &self.0[axis as usize]
    }
}

impl std::ops::IndexMut<Axis> for Position {
    fn index_mut(&mut self, axis: Axis) -> &mut f64 {
        &mut self.0[axis as usize]
    }
}

/// The plane of an arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Plane {
    /// G17.
    #[default]
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// Its first and second axis and its normal, a right-handed triple.
    #[must_use]
    pub const fn axes(self) -> [Axis; 3] {
        match self {
            Self::Xy => [Axis::X, Axis::Y, Axis::Z],
            Self::Zx => [Axis::Z, Axis::X, Axis::Y],
            Self::Yz => [Axis::Y, Axis::Z, Axis::X],
        }
    }
}

/// How the tool gets to [`Move::end`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveKind {
    /// G0: at rapid rate, cutting nothing.
    Rapid,
    /// G1 and everything that feeds in a straight line.
    Feed,
    /// G2, G3.
    Arc {
        /// The plane.
        plane: Plane,
        /// Centre in the plane's first and second axis (X, Y for G17; Z, X for G18; Y, Z for G19), mm, same frame as `end`.
        centre: [f64; 2],
        /// Angle turned, radians: positive is counter-clockwise seen from the plane's positive normal.
        sweep: f64,
    },
    /// G4 and other pauses, s; `end` is where the machine already is.
    Dwell {
        /// Duration, s.
        seconds: f64,
    },
    /// M6.
    ToolChange {
        /// The tool's number.
        tool: u32,
    },
}

impl MoveKind {
    /// Whether it is a feed: a straight line or an arc.
    #[must_use]
    pub const fn is_feed(&self) -> bool {
        matches!(self, Self::Feed | Self::Arc { .. })
    }

    /// Its name in listings.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Rapid => "rapid",
            Self::Feed => "feed",
            Self::Arc { .. } => "arc",
            Self::Dwell { .. } => "dwell",
            Self::ToolChange { .. } => "tool",
        }
    }
}

/// One canonical move. The start is the previous move's end.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Line of the program, from 1.
    pub line: u32,
    /// How.
    pub kind: MoveKind,
    /// Where to, as axis positions (work, G92 and tool offsets resolved): mm and radians.
    pub end: Position,
    /// Under tool-centre-point control, the tool's length, mm: X, Y, Z of [`Move::end`] are then the place of the tool's tip, in
    /// machine coordinates with all rotary axes at zero, and whoever moves the machine finds the linear axes
    /// (`bvbench::machine::tip`). `None` otherwise.
    pub tip_mm: Option<f64>,
    /// Whether the tip moves in a tilted plane (G68.2). A rapid there may be a dog-leg of the axes ([`RapidPath`](crate::RapidPath)).
    pub is_tilted: bool,
    /// Whether a probe ends it where it meets something (G31, G38.2 to G38.5). Here it goes on to its end.
    pub is_probe: bool,
    /// Feed rate, mm/min, degrees/min for a move that only turns; where it changes along the move, the one that takes as
    /// long. `None` for rapids, and where the rate hangs on a spindle speed that is not known.
    pub feed_mm_min: Option<f64>,
    /// Revolutions per minute of the spindle at the end: above zero for M3, below for M4. Infinite on the axis of turning at a
    /// constant surface speed without limit. Of several spindles the main one, or while that stands the driven tool, or else the sub spindle.
    pub spindle_rpm: f64,
    /// Whether a spindle turns that may hold the workpiece: on Haas's lathes the main or the sub spindle, elsewhere any.
    pub turns_workpiece: bool,
    /// Whether a spindle turns that may drive the tool: on Haas's lathes that of driven tools, elsewhere any.
    pub turns_tool: bool,
}

/// Moves as text, one a line: source line, kind, the end's X, Y, Z and every axis that is ever not zero,
/// mm and degrees with four decimals; an arc adds plane, centre and sweep, a move of the tip the tool's length, a feed move its rate.
#[must_use]
pub fn render(moves: &[Move]) -> String {
    let shown =
        Axis::ALL.map(|axis| moves.iter().any(|step| step.end[axis] != 0.0) || axis as usize <= Axis::Z as usize);
    let mut text = String::new();
    for step in moves {
        // Writing to a string cannot fail.
        let _ = render_move(&mut text, step, &shown);
    }
    text
}

fn render_move(text: &mut String, step: &Move, shown: &[bool; 9]) -> std::fmt::Result {
    write!(text, "{:>4} {}", step.line, step.kind.name())?;
    match step.kind {
        MoveKind::Dwell { seconds } => return writeln!(text, " {}", fixed(seconds)),
        MoveKind::ToolChange { tool } => return writeln!(text, " {tool}"),
        _ => {}
    }
    for axis in Axis::ALL.into_iter().filter(|&axis| shown[axis as usize]) {
        let value = if axis.is_rotary() { step.end[axis].to_degrees() } else { step.end[axis] };
        write!(text, " {}{}", axis.letter(), fixed(value))?;
    }
    if let MoveKind::Arc { plane, centre, sweep } = step.kind {
        let name = plane.axes().map(Axis::letter);
        let [u, v] = centre.map(fixed);
        write!(text, " {}{} centre {u} {v} sweep {}", name[0], name[1], fixed(sweep.to_degrees()))?;
    }
    if let Some(length) = step.tip_mm {
        write!(text, " tip {}", fixed(length))?;
    }
    match step.feed_mm_min {
        Some(feed) => writeln!(text, " F{}", fixed(feed)),
        None => writeln!(text),
    }
}

/// Four decimals, and no minus before a zero.
fn fixed(value: f64) -> String {
    let text = format!("{value:.4}");
    if text == "-0.0000" { "0.0000".to_owned() } else { text }
}
