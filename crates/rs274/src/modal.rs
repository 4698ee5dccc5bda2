//! The words of one block with their values, sorted into modal groups, and the modes that outlive a block.
//!
//! Groups as in NISTIR 6556, table 4, with LinuxCNC's additions. Two codes of one group in one block are an error.

use super::block::{Block, Word};
use super::canonical::Plane;
use super::dialect::{CodeName, Dialect, Meaning, fanuc_g, fanuc_m, own};
use super::error::{Cause, Fault};
use super::oword::SECOND_ARGUMENTS;
use super::parameters::Parameters;
use super::setup::Setup;
use super::unread::unread_g;
use std::cell::Cell;

/// A value must be this close to a whole number (or a tenth, for G) to be taken as one (LinuxCNC does the same).
const WHOLE_TOLERANCE: f64 = 1e-4;

/// G80, times ten.
pub(super) const CANCEL_CYCLE: i32 = 800;

/// A modal group of G or M codes; the codes are ten times the number, so that 59.3 is 593.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    NonModal,
    Motion,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    CutterCompensation,
    ToolLength,
    Return,
    Coordinates,
    PathControl,
    SpindleMode,
    Diameter,
    /// Turned and tilted coordinates.
    Turn,
    /// Scaled coordinates.
    Scale,
    /// Mirrored coordinates.
    Mirror,
    /// Coordinates by radius and angle.
    Polar,
    Absolute,
    Stop,
    ToolChange,
    Spindle,
    /// Driven tool and sub spindle of Haas's lathes.
    Driven,
    Orient,
    Coolant,
    Override,
    Subprogram,
    State,
    Signal,
    User,
}

const GROUPS: usize = 30;

fn g_group(tenths: i32) -> Option<Group> {
    Some(match tenths {
        40 | 100 | 531 | 280 | 281 | 300 | 301 | 520 | 920..=923 => Group::NonModal,
        530 => Group::Absolute,
        0
        | 10
        | 20
        | 30
        | 50
        | 51
        | 330
        | 331
        | 382..=385
        | 700
        | 710..=712
        | 720..=722
        | 730
        | 740
        | 760
        | 800
        | 810
        | 820
        | 830
        | 840
        | 850
        | 860
        | 870
        | 880
        | 890 => Group::Motion,
        170 | 180 | 190 => Group::Plane,
        900 | 910 => Group::Distance,
        901 | 911 => Group::ArcDistance,
        930 | 940 | 950 => Group::FeedMode,
        200 | 210 => Group::Units,
        400 | 410 | 411 | 420 | 421 => Group::CutterCompensation,
        430 | 431 | 432 | 434 | 435 | 490 => Group::ToolLength,
        980 | 990 => Group::Return,
        540 | 550 | 560 | 570 | 580 | 590..=593 => Group::Coordinates,
        610 | 611 | 640 => Group::PathControl,
        960 | 970 => Group::SpindleMode,
        70 | 80 => Group::Diameter,
        682 | 690 => Group::Turn,
        _ => return None,
    })
}

fn m_group(code: i32) -> Option<Group> {
    Some(match code {
        0 | 1 | 2 | 30 | 60 => Group::Stop,
        6 | 61 => Group::ToolChange,
        3..=5 => Group::Spindle,
        19 => Group::Orient,
        7..=9 => Group::Coolant,
        48..=53 => Group::Override,
        62..=68 => Group::Signal,
        70..=73 => Group::State,
        98 | 99 => Group::Subprogram,
        _ => return None,
    })
}

/// What a G or M code means to this setup.
fn meaning(letter: char, number: f64, setup: &Setup) -> Meaning {
    let common = |group: Option<Group>, number| group.map_or(Meaning::Unknown, |group| Meaning::Code(group, number));
    let like_fanuc = setup.dialect.is_fanuc_like();
    if letter == 'g' {
        let Some(tenths) = whole(number * 10.0) else { return Meaning::Unknown };
        let own = if like_fanuc { fanuc_g(tenths, setup.dialect, setup.is_fanuc_lathe()) } else { Meaning::Common };
        return if own == Meaning::Common { common(g_group(tenths), tenths) } else { own };
    }
    let Some(code) = whole(number) else { return Meaning::Unknown };
    if u32::try_from(code).is_ok_and(|code| setup.user_codes.contains_key(&code)) && m_group(code).is_none() {
        return Meaning::Code(Group::User, code);
    }
    let own = if like_fanuc { fanuc_m(code, setup.dialect, setup.is_fanuc_lathe()) } else { Meaning::Common };
    if own == Meaning::Common { common(m_group(code), code) } else { own }
}

/// A G or M code found in a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Code {
    /// Ten times the number for G, the number for M.
    pub number: i32,
    pub column: u32,
    pub text: String,
}

impl Code {
    pub fn fault(&self, cause: Cause) -> Fault {
        Fault::new(self.column, self.text.clone(), cause)
    }
}

/// A word's value and where it stands.
#[derive(Clone, Debug, PartialEq)]
struct Value {
    number: f64,
    /// Whether it is written in digits without a decimal point, in a dialect where that may mean another length.
    lacks_point: bool,
    column: u32,
    text: String,
}

/// An evaluated block: every word's value, and which words some code has used so far.
#[derive(Clone, Debug)]
pub(super) struct Values {
    letters: [Option<Value>; SLOTS],
    used: Cell<u32>,
    codes: [Option<Code>; GROUPS],
    /// Words taken as lengths, by slot.
    lengths: Cell<u32>,
    /// What the reader should know of the block, and whether the machine may do something else than the moves show.
    notes: Vec<(String, bool)>,
    /// Words that may be left over, by slot: a skipped code's.
    spare: u32,
}

/// The letters, `@`, `^`, `$`, and `,R` and `,C`, whose letters are `R` and `C`.
const SLOTS: usize = 31;

fn slot(letter: char) -> usize {
    match letter {
        '@' => 26,
        '^' => 27,
        '$' => 28,
        'R' => 29,
        'C' => 30,
        _ => letter as usize - 'a' as usize,
    }
}

impl Values {
    /// Evaluates all words; `inches` says whether G20 holds before the block.
    pub fn of(block: &Block, parameters: &Parameters, setup: &Setup, inches: bool) -> Result<Self, Fault> {
        let unit_codes = block.words.iter().filter(|word| word.letter == 'g').filter_map(|word| word.value.literal());
        let inches = unit_codes.fold(inches, |inches, code| code == 20.0 || (inches && code != 21.0));
        let mut values = Self {
            letters: [const { None }; SLOTS],
            used: Cell::new(0),
            lengths: Cell::new(0),
            codes: Default::default(),
            notes: block.notes.iter().map(|&note| (note.to_owned(), false)).collect(),
            spare: 0,
        };
        let mut skips_words = false;
        let mut owner: Option<CodeName> = None;
        let mut rounded = None;
        for word in &block.words {
            let fault = |cause| Fault::new(word.column, word.text.clone(), cause);
            let number = if setup.dialect.is_fanuc_like() && word.value.rounds() {
                rounded = rounded.or(Some(word));
                word.value.evaluate_to(parameters, increments_per_unit(word.letter, inches))?
            } else {
                word.value.evaluate(parameters)?
            };
            if !matches!(word.letter, 'g' | 'm') {
                if number.is_nan() {
                    // A vacant variable: as if the word were not there.
                    continue;
                }
                let entry = &mut values.letters[slot(word.letter)];
                if entry.is_some() {
                    return Err(fault(duplicate(block, word.letter, setup)));
                }
                let lacks_point = setup.dialect.is_fanuc_like() && word.lacks_point && number != 0.0;
                if lacks_point && "xyzabcuvw".contains(word.letter) {
                    values.notes.push((lacks_point_note(word.letter), true));
                }
                *entry = Some(Value { number, lacks_point, column: word.column, text: word.text.clone() });
                continue;
            }
            if let Some(name) = ignored(word.letter, number, setup) {
                values.notes.push((format!("{name} is ignored, as asked"), may_move(word.letter, number, setup)));
                skips_words |= word.letter == 'g';
                values.spare |= !slots(AXES);
                continue;
            }
            let (group, number) = match meaning(word.letter, number, setup) {
                Meaning::Code(group, number) => (group, number),
                Meaning::Nothing => continue,
                Meaning::Noted => {
                    let name = CodeName::new(word.letter, whole(number * 10.0).unwrap_or_default());
                    values.notes.extend(noted(name, setup.dialect).map(|note| (note, false)));
                    values.spare |= slots(words_of_noted(name));
                    if owns_axis_words(name) {
                        owner = Some(name);
                    }
                    continue;
                }
                Meaning::Common | Meaning::Unknown => return Err(fault(unsupported(word.letter, number, setup))),
            };
            let entry = &mut values.codes[group as usize];
            match entry {
                // Where G80 stands beside a motion, the motion wins, as in LinuxCNC: safety lines have `G0 ... G80`.
                Some(_) if group == Group::Motion && number == CANCEL_CYCLE => continue,
                Some(first) if group == Group::Motion && first.number == CANCEL_CYCLE => {}
                Some(first) => return Err(fault(Cause::ModalConflict(first.text.clone()))),
                None => {}
            }
            *entry = Some(Code { number, column: word.column, text: word.text.clone() });
        }
        if skips_words {
            values.drop_ignored_words()?;
        }
        if let Some(owner) = owner.filter(|_| values.has_axis()) {
            values.drop_axis_words(owner)?;
        }
        if let Some(word) = rounded.filter(|_| values.number(Group::Subprogram) == Some(own::MACRO_CALL)) {
            let why = "ROUND in an argument of a macro, whose increment depends on the control";
            return Err(Fault::new(word.column, word.text.clone(), Cause::NotAllowed(why)));
        }
        // G53 is of the group of G4 and G10, but may stand beside a motion, which is not.
        if let (Some(first), Some(second)) = (values.code(Group::NonModal), values.code(Group::Absolute)) {
            let (first, second) = if first.column < second.column { (first, second) } else { (second, first) };
            return Err(second.fault(Cause::ModalConflict(first.text.clone())));
        }
        Ok(values)
    }

    /// Drops the words of an ignored G code, if no other code is there to use them.
    fn drop_ignored_words(&mut self) -> Result<(), Fault> {
        if self.codes().next().is_none() {
            self.letters = [const { None }; SLOTS];
            return Ok(());
        }
        let uses_axes = [Group::Motion, Group::NonModal, Group::Absolute, Group::Turn, Group::Scale, Group::Mirror]
            .into_iter()
            .chain([Group::ToolLength, Group::Subprogram])
            .any(|group| self.code(group).is_some());
        let why = "axis words beside an ignored code and without one that moves axes: nothing tells whose they are";
        match self.first_axis_word() {
            Some(word) if !uses_axes => Err(Fault::new(word.column, word.text.clone(), Cause::NotAllowed(why))),
            _ => Ok(()),
        }
    }

    /// Drops the axis words of a code that moves no axis: no others may want them.
    fn drop_axis_words(&mut self, owner: CodeName) -> Result<(), Fault> {
        if let Some(code) = self.codes().min_by_key(|code| code.column) {
            let why = "another code beside axis words of G5, G5.1 or G22, which move nothing";
            return Err(code.fault(Cause::NotAllowed(why)));
        }
        for letter in AXES.chars().chain("ijk".chars()) {
            self.letters[slot(letter)] = None;
        }
        self.notes.push((format!("axis words beside {owner} are taken to move no axis"), false));
        Ok(())
    }

    fn first_axis_word(&self) -> Option<&Value> {
        AXES.chars().filter_map(|letter| self.letters[slot(letter)].as_ref()).min_by_key(|word| word.column)
    }

    /// The code of a group, if the block has one.
    pub fn code(&self, group: Group) -> Option<&Code> {
        self.codes[group as usize].as_ref()
    }

    /// Every code of the block.
    pub fn codes(&self) -> impl Iterator<Item = &Code> {
        self.codes.iter().flatten()
    }

    /// The number of [`Self::code`].
    pub fn number(&self, group: Group) -> Option<i32> {
        self.code(group).map(|code| code.number)
    }

    /// Whether a word is there.
    pub fn has(&self, letter: char) -> bool {
        self.letters[slot(letter)].is_some()
    }

    /// The column of a word, if it is there.
    pub fn column(&self, letter: char) -> Option<u32> {
        self.letters[slot(letter)].as_ref().map(|value| value.column)
    }

    /// A word's value; from now on the word counts as used.
    pub fn take(&self, letter: char) -> Option<f64> {
        let value = self.letters[slot(letter)].as_ref()?;
        self.used.set(self.used.get() | 1 << slot(letter));
        Some(value.number)
    }

    /// A word's value as a whole number in `range`; `must_be` says what range.
    pub fn take_whole(
        &self,
        letter: char,
        range: std::ops::RangeInclusive<i32>,
        name: &'static str,
        must_be: &'static str,
    ) -> Result<Option<i32>, Fault> {
        let Some(number) = self.take(letter) else { return Ok(None) };
        match whole(number).filter(|number| range.contains(number)) {
            Some(number) => Ok(Some(number)),
            None => Err(self.fault(letter, Cause::Range(name, must_be))),
        }
    }

    /// The code that moves the axes; without one in the block, one at its first word, for messages.
    pub fn motion_code(&self) -> Code {
        self.code(Group::Motion).cloned().unwrap_or_else(|| {
            let Fault { column, text, .. } = self.motion_fault(Cause::Unsupported);
            Code { number: 0, column, text }
        })
    }

    /// A fault at the code that moves the axes, or at the block's first word when the code stands in a block before.
    pub fn motion_fault(&self, cause: Cause) -> Fault {
        self.fault_at(Group::Motion, cause)
    }

    /// A fault at the code of a group, or at the block's first word.
    pub fn fault_at(&self, group: Group, cause: Cause) -> Fault {
        if let Some(code) = self.code(group) {
            return code.fault(cause);
        }
        let words = self.letters.iter().flatten().map(|value| (value.column, &value.text));
        let codes = self.codes.iter().flatten().map(|code| (code.column, &code.text));
        match words.chain(codes).min() {
            Some((column, text)) => Fault::new(column, text.clone(), cause),
            None => Fault::new(1, "", cause),
        }
    }

    /// A fault at a word.
    pub fn fault(&self, letter: char, cause: Cause) -> Fault {
        let value = self.letters[slot(letter)].as_ref();
        match value {
            Some(value) => Fault::new(value.column, value.text.clone(), cause),
            None => Fault::new(1, "", cause),
        }
    }

    /// An error if some word has been used by nothing.
    pub fn check_all_used(&self) -> Result<(), Fault> {
        let needless = self.used.get() | self.spare;
        let unused = self.letters.iter().enumerate().filter(|(at, _)| needless >> at & 1 == 0);
        match unused.filter_map(|(_, value)| value.as_ref()).min_by_key(|value| value.column) {
            None => Ok(()),
            Some(value) => Err(Fault::new(value.column, value.text.clone(), Cause::UnusedWord)),
        }
    }

    /// Whether the word may belong to a code that is skipped in this block.
    pub fn may_be_left(&self, letter: char) -> bool {
        self.spare >> slot(letter) & 1 == 1
    }

    /// Whether the block has any of X, Y, Z, A, B, C, U, V, W, or X and Y as `@` and `^`.
    pub fn has_axis(&self) -> bool {
        AXES.chars().any(|letter| self.has(letter))
    }

    /// What the reader should know of the block.
    pub fn notes(&self) -> impl Iterator<Item = (&str, bool)> {
        self.notes.iter().map(|(text, is_unknown)| (text.as_str(), *is_unknown))
    }

    /// Notes that a word is a length, if it is there and not 0.
    pub fn note_length(&self, letter: char) {
        if self.letters[slot(letter)].as_ref().is_some_and(|value| value.number != 0.0) {
            self.lengths.set(self.lengths.get() | 1 << slot(letter));
        }
    }

    /// Whether the block has a length other than 0. H of lathes is none: it is a step of C, in degrees.
    pub fn has_length(&self) -> bool {
        self.lengths.get() & !slots("h") != 0
    }

    /// Whether this word of the block is a length, and not 0.
    pub fn is_length(&self, letter: char) -> bool {
        self.lengths.get() >> slot(letter) & 1 == 1
    }

    /// What the reader should know of words that have turned out to be lengths.
    pub fn late_notes(&self) -> impl Iterator<Item = String> {
        let is_late = |letter: &char| self.is_length(*letter) && self.lacks_point(*letter);
        "ijrkqhRC".chars().filter(is_late).map(lacks_point_note)
    }

    /// Whether a word is written in digits without a decimal point.
    pub fn lacks_point(&self, letter: char) -> bool {
        self.letters[slot(letter)].as_ref().is_some_and(|value| value.lacks_point)
    }

    /// Whether a word is there and is written with a decimal point.
    pub fn has_point(&self, letter: char) -> bool {
        self.letters[slot(letter)].as_ref().is_some_and(|value| value.text.contains('.'))
    }

    /// All words that are there, by letter.
    pub fn words(&self) -> impl Iterator<Item = (char, f64)> {
        ('a'..='z').filter_map(|letter| self.letters[slot(letter)].as_ref().map(|value| (letter, value.number)))
    }

    /// Counts a word as used, whether it is there or not.
    pub fn drop_word(&self, letter: char) {
        self.used.set(self.used.get() | 1 << slot(letter));
    }
}

/// Letters of words that say where the axes go.
const AXES: &str = "xyzabcuvw@^";

pub(super) fn lacks_point_note(letter: char) -> String {
    format!(
        "{} has no decimal point and is read as if it had one behind its last digit; a control that counts in least increments \
         reads a thousandth or less",
        letter.to_ascii_uppercase()
    )
}

/// How many least increments of Fanuc's and Haas's controls are in a word's unit.
fn increments_per_unit(letter: char, inches: bool) -> f64 {
    match letter {
        'a' | 'b' | 'c' => 1e3,
        'x'..='z' | 'u'..='w' | 'i'..='k' | 'q' | 'r' | 'R' | 'C' | 'e' | 'f' => {
            if inches {
                1e4
            } else {
                1e3
            }
        }
        _ => 1.0,
    }
}

/// The slots of letters, a bit each.
fn slots(letters: &str) -> u32 {
    letters.chars().fold(0, |slots, letter| slots | 1 << slot(letter))
}

/// Whether an ignored code may move axes: any G code but those that are known to move none, and the M codes that are performed.
fn may_move(letter: char, number: f64, setup: &Setup) -> bool {
    match meaning(letter, number, setup) {
        Meaning::Noted | Meaning::Nothing => false,
        Meaning::Code(..) => true,
        Meaning::Common | Meaning::Unknown => letter == 'g',
    }
}

/// The note on a code that moves no axis; none on one of which everybody knows it. M13 and M14 start the spindle on many machines, the others driven tools and sub spindles.
fn noted(name: CodeName, dialect: Dialect) -> Option<String> {
    let name = name.to_string();
    // Look-ahead, smoothing, rigid tapping; on Haas's controls clamps of axes, chips, air and coolant as well.
    let is_known = match dialect {
        Dialect::Haas => {
            matches!(name.as_str(), "G103" | "G187" | "M10" | "M11" | "M31" | "M33" | "M83" | "M84" | "M88" | "M89")
        }
        _ => matches!(name.as_str(), "G5.1" | "G8" | "M29"),
    };
    if is_known {
        return None;
    }
    let more = match name.as_str() {
        "M13" | "M14" | "M133" | "M134" | "M143" | "M144" => {
            format!(
                " and not to start the spindle; `user_codes = {{ {name} = \"spindle-on\" }}` of a scene says that it does"
            )
        }
        _ => String::new(),
    };
    Some(format!("{name} is taken to move no axis{more}"))
}

/// Letters of the words that a code which moves no axis may have, axes apart.
fn words_of_noted(name: CodeName) -> &'static str {
    match name.to_string().as_str() {
        "G5" | "G5.1" => "pqrl",
        "G187" => "pej",
        "G22" => "ijkp",
        _ => "pqe",
    }
}

/// Whether axis words in the block of a code that moves no axis are its own.
fn owns_axis_words(name: CodeName) -> bool {
    matches!(name.to_string().as_str(), "G5" | "G5.1" | "G22")
}

/// The error for a letter that stands twice in a block.
fn duplicate(block: &Block, letter: char, setup: &Setup) -> Cause {
    let is_call = |word: &Word| word.letter == 'g' && word.value.literal() == Some(65.0);
    if setup.dialect.is_fanuc_like() && "ijk".contains(letter) && block.words.iter().any(is_call) {
        return Cause::NotAllowed(SECOND_ARGUMENTS);
    }
    Cause::DuplicateWord
}

fn unsupported(letter: char, number: f64, setup: &Setup) -> Cause {
    let tenths = whole(number * 10.0);
    let unread = tenths.filter(|_| letter == 'g');
    if let Some(what) = unread.and_then(|tenths| unread_g(tenths, setup.dialect, setup.is_fanuc_lathe())) {
        return Cause::Unread(what);
    }
    match tenths {
        Some(tenths) if tenths >= 0 => Cause::UnsupportedCode(CodeName::new(letter, tenths)),
        _ => Cause::Unsupported,
    }
}

/// The code's name, if the setup asks to ignore it.
fn ignored(letter: char, number: f64, setup: &Setup) -> Option<CodeName> {
    if setup.ignored.is_empty() {
        return None;
    }
    let name = CodeName::new(letter, whole(number * 10.0)?);
    setup.ignored.contains(&name).then_some(name)
}

/// The whole number within [`WHOLE_TOLERANCE`], if there is one.
pub(super) fn whole(number: f64) -> Option<i32> {
    let rounded = number.round();
    let near = (number - rounded).abs() <= WHOLE_TOLERANCE && rounded.abs() <= f64::from(i32::MAX);
    near.then_some(rounded as i32)
}

/// What the F word means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum FeedMode {
    /// G93: moves per minute.
    InverseTime,
    /// G94.
    #[default]
    PerMinute,
    /// G95: per spindle revolution.
    PerRevolution,
}

/// What the spindle does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Spindle {
    /// M5.
    #[default]
    Still,
    /// M3.
    Clockwise,
    /// M4.
    Counterclockwise,
}

/// The modes that outlive a block.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    /// The motion code, ten times its number; `None` after G80.
    pub motion: Option<i32>,
    pub plane: Plane,
    pub incremental: bool,
    pub arc_centre_absolute: bool,
    pub feed_mode: FeedMode,
    pub inches: bool,
    /// Index of the work coordinate system: 0 is G54.
    pub system: usize,
    pub diameter: bool,
    /// G99: cycles retract to R.
    pub retract_to_r: bool,
    /// G96: S is a surface speed.
    pub constant_surface_speed: bool,
    /// F as programmed, in mm or degrees per minute or revolution, or 1/min for G93.
    pub feed: f64,
    /// F as programmed: for moves that only turn, degrees per minute whatever the unit of length.
    pub turning_feed: f64,
    /// S as programmed.
    pub speed: f64,
    /// Whether M3 or M4 is in force, and which.
    pub spindle: Spindle,
    /// Revolutions per minute of the driven tool and of the sub spindle; below zero they turn backwards.
    pub driven_rpm: [f64; 2],
    /// The greatest spindle speed under G96, revolutions per minute; `None` for no limit.
    pub greatest_speed: Option<f64>,
    /// The surface speed of G96.
    pub surface_mm_min: f64,
    /// G16: X and Y are radius and angle.
    pub polar: bool,
    /// The last motion that is no cycle: what G80 goes back to on Fanuc's controls.
    pub plain_motion: Option<i32>,
    /// M7 and M8.
    pub mist: bool,
    pub flood: bool,
    /// Whether feed override (M50), speed override (M51), adaptive feed (M52) and feed hold (M53) are allowed. They move
    /// nothing, but programs may ask.
    pub overrides: [bool; 4],
}

impl Modes {
    /// mm per unit of length.
    pub fn unit_mm(&self) -> f64 {
        if self.inches { 25.4 } else { 1.0 }
    }
}
