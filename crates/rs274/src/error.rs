//! What can be wrong with a program, and where.

use super::dialect::CodeName;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A program that cannot be interpreted: the first thing wrong with it, and what else can be told without it.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", told(self))]
pub struct GcodeError {
    /// The program.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// The offending text, empty at the end of a line.
    pub text: String,
    /// What is wrong with it.
    pub cause: Cause,
    /// On how many further lines the same is wrong with the same text.
    pub more: u32,
    /// Apart, so that the error stays small.
    further: Option<Box<Further>>,
}

/// What there is to tell beside the first error.
#[derive(Clone, Debug, Default, PartialEq)]
struct Further {
    others: Vec<GcodeError>,
    hint: Option<String>,
}

/// Most errors that are told of one program.
pub const MOST_ERRORS: usize = 20;

impl GcodeError {
    /// An error at a place of a file.
    #[must_use]
    pub fn new(file: PathBuf, line: u32, column: u32, text: String, cause: Cause) -> Self {
        Self { file, line, column, text, cause, more: 0, further: None }
    }

    /// What else is wrong, fewer than [`MOST_ERRORS`], each without others of its own: only what does not hang on the errors before.
    #[must_use]
    pub fn others(&self) -> &[Self] {
        self.further.as_ref().map_or(&[], |further| &further.others)
    }

    /// What to try, when the program seems to be written for another control.
    #[must_use]
    pub fn hint(&self) -> Option<&str> {
        self.further.as_ref()?.hint.as_deref()
    }

    pub(super) fn set_others(&mut self, others: Vec<Self>) {
        self.further.get_or_insert_default().others = others;
    }

    pub(super) fn set_hint(&mut self, hint: String) {
        self.further.get_or_insert_default().hint = Some(hint);
    }

    /// An error inside a line of a file.
    pub(super) fn of(file: &Path, line: u32, fault: Fault) -> Self {
        Self::new(file.to_owned(), line, fault.column, fault.text, fault.cause)
    }
}

/// All errors, a line each, and the hint.
fn told(error: &GcodeError) -> String {
    let mut text = one(error);
    for other in error.others() {
        text.push('\n');
        text.push_str(&one(other));
    }
    if let Some(hint) = error.hint() {
        text.push('\n');
        text.push_str(hint);
    }
    text
}

fn one(error: &GcodeError) -> String {
    let GcodeError { file, line, column, text, cause, more, .. } = error;
    let quoted = if text.is_empty() { String::new() } else { format!(": `{text}`") };
    let again = match more {
        0 => String::new(),
        1 => " (and on another line)".to_owned(),
        more => format!(" (and on {more} more lines)"),
    };
    format!("{}:{line}:{column}: {cause}{quoted}{again}", file.display())
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Cause {
    /// A character that starts nothing.
    #[error("unexpected character")]
    UnexpectedCharacter,
    /// `(` without `)`.
    #[error("comment is not closed")]
    UnclosedComment,
    /// `(` inside a comment.
    #[error("comment inside a comment")]
    NestedComment,
    /// `<` without `>`.
    #[error("name is not closed by `>`")]
    UnclosedName,
    /// Something must follow here.
    #[error("{0} expected")]
    Expected(&'static str),
    /// A control-flow word of Fanuc's macro language in another dialect.
    #[error(
        "control flow of Fanuc's macro language is understood in the dialects fanuc and haas; here O-words are, as in `o1 if [#1 EQ 1]`"
    )]
    MacroWord,
    /// Words behind `;` on a control that ends the block there.
    #[error(
        "these words stand behind `;`, where the control ends the block: give them a line of their own, or write a comment in ( )"
    )]
    SecondBlock,
    /// A program in a language that is not interpreted.
    #[error("{0}")]
    Foreign(String),
    /// A macro's own alarm: `#3000 = 1 (MESSAGE)`.
    #[error("the program raises alarm {0}")]
    Alarm(String),
    /// What the machine cannot do; the message says why.
    #[error("{0}")]
    Machine(String),
    /// A function that RS274/NGC does not have.
    #[error("unknown function")]
    UnknownFunction,
    /// A function or operator outside its domain; the message says which.
    #[error("{0}")]
    Domain(&'static str),
    /// A number that must be whole and in a range.
    #[error("{0} must be {1}")]
    Range(&'static str, &'static str),
    /// A parameter that does not exist.
    #[error("parameter does not exist")]
    UnknownParameter,
    /// A variable that the control keeps from one program to the next or that M109 asks the operator for, and that nothing has set.
    #[error(
        "nothing has set this variable, which the control keeps from one program to the next or M109 asks the operator for: set it in the program, or give its value (`--variable NUMBER=VALUE`)"
    )]
    UnsetVariable,
    /// A parameter that programs may not set.
    #[error("parameter is read-only")]
    ReadOnlyParameter,
    /// A letter that means nothing.
    #[error("letter without meaning")]
    UnknownLetter,
    /// Two words with one letter.
    #[error("word given twice in one block")]
    DuplicateWord,
    /// A word that no code of its block uses.
    #[error("no code of this block uses this word")]
    UnusedWord,
    /// A code of RS274/NGC that this interpreter does not perform, or one that nobody knows.
    #[error("code is not supported")]
    Unsupported,
    /// The same, of a code that programs may be asked to skip.
    #[error("code is not supported; if it moves nothing, ignore it (`--ignore {0}`)")]
    UnsupportedCode(CodeName),
    /// A code of the control that this interpreter does not read; the message says what it does.
    #[error("{0} is not read")]
    Unread(&'static str),
    /// Two codes that exclude each other.
    #[error("excludes {0} in the same block: same modal group")]
    ModalConflict(String),
    /// A code that needs a word which is not there; the message names it.
    #[error("{0} is missing")]
    Missing(&'static str),
    /// A code that is not allowed in the present state; the message says why.
    #[error("not allowed: {0}")]
    NotAllowed(&'static str),
    /// An arc whose start and end are not equally far from its centre.
    #[error("arc radius is {start_mm} mm at its start and {end_mm} mm at its end")]
    RadiusMismatch {
        /// Radius at the start, mm.
        start_mm: f64,
        /// Radius at the end, mm.
        end_mm: f64,
    },
    /// A path that the compensated tool cannot follow; the message says why.
    #[error("cutter compensation: {0}")]
    Compensation(&'static str),
    /// An arc that cannot be drawn; the message says why.
    #[error("impossible arc: {0}")]
    Arc(&'static str),
    /// A tool that the table lacks.
    #[error("tool is not in the tool table (`--tool-table`, or `[[program.tools]]` of a scene)")]
    UnknownTool,
    /// A control-flow word without its partner.
    #[error("{0}")]
    Flow(&'static str),
    /// A subroutine that the program does not define.
    #[error("subroutine is not defined in this program")]
    UnknownSubroutine,
    /// A subroutine's file that is there and cannot be read.
    #[error("the file cannot be read: {0}")]
    Unreadable(String),
    /// A limit of this interpreter, so that no program runs for ever.
    #[error("more than {limit} {what}")]
    Limit {
        /// The limit.
        limit: usize,
        /// Of what.
        what: &'static str,
    },
}

impl Cause {
    /// Whether it is wrong whatever the lines before have done.
    pub(super) const fn stands_alone(&self) -> bool {
        matches!(
            self,
            Self::UnexpectedCharacter
                | Self::UnclosedComment
                | Self::NestedComment
                | Self::UnclosedName
                | Self::Expected(_)
                | Self::MacroWord
                | Self::SecondBlock
                | Self::UnknownFunction
                | Self::UnknownLetter
                | Self::DuplicateWord
                | Self::Unsupported
                | Self::UnsupportedCode(_)
                | Self::Unread(_)
                | Self::ModalConflict(_)
                | Self::UnknownTool
                | Self::UnknownSubroutine
        )
    }
}

/// An error inside one line: the interpreter adds file and line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    /// Column, from 1.
    pub column: u32,
    /// The offending text.
    pub text: String,
    /// The cause.
    pub cause: Cause,
}

impl Fault {
    pub fn new(column: u32, text: impl Into<String>, cause: Cause) -> Self {
        Self { column, text: text.into(), cause }
    }
}
