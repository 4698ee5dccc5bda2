//! What can be wrong with a program, and where.

use std::path::PathBuf;
use thiserror::Error;

/// A program that cannot be interpreted: the first thing wrong with it.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}:{column}: {cause}{quoted}", file = file.display(), quoted = quoted(text))]
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
}

fn quoted(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!(": `{text}`") }
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
    /// A control-flow word of Fanuc's macro language.
    #[error("control flow of Fanuc's macro language is not understood; O-words are, as in `o1 if [#1 EQ 1]`")]
    MacroWord,
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
    #[error("tool is not in the tool table")]
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
