//! The lines of a program and of the subroutine files it calls.
//!
//! A subroutine that the program does not define is looked for beside it, as `NAME.ngc` for `O<NAME> call` (LinuxCNC, "Calling
//! Files"), and as `O1000.nc`, `1000.nc` and the like for Fanuc's `M98 P1000` and `G65 P1000`. Files are found before the program runs, so a
//! label that is computed finds none.

use super::block::{Block, Keyword, Label};
use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::file::{self, LARGEST_PROGRAM};
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Most lines of a program with its subroutine files: some 2 GB of memory.
const MAX_LINES: usize = 2_000_000;

const TOO_MANY_LINES: Cause = Cause::Limit { limit: MAX_LINES, what: "lines of the program and its subroutine files" };

/// Parses a line; the interpreter decides what block delete leaves of it.
pub(super) type Parse<'a> = &'a dyn Fn(&str) -> Result<Block, Fault>;

/// The lines of a file's text, without the byte-order mark that editors on Windows put before it. A carriage return alone ends a line, too.
pub(super) fn every_line(text: &str) -> impl Iterator<Item = &str> {
    text.strip_prefix('\u{feff}').unwrap_or(text).lines().flat_map(|line| line.split('\r'))
}

/// A line without the spaces and control characters around it: tapes and serial links put NUL, DC1 to DC4 and Ctrl-Z beside the `%` signs.
pub(super) fn bare(line: &str) -> &str {
    line.trim_matches(|c: char| c.is_whitespace() || c.is_control())
}

/// The lines of [`every_line`], copied.
///
/// # Errors
/// When there are more than `MAX_LINES`, with the number of the first that is too many.
pub(super) fn lines(text: &str) -> Result<Vec<String>, (u32, Cause)> {
    match every_line(text).nth(MAX_LINES) {
        Some(_) => Err((MAX_LINES as u32 + 1, TOO_MANY_LINES)),
        None => Ok(every_line(text).map(str::to_owned).collect()),
    }
}

/// All lines, parsed; a line that is wrong is an error only when it is executed.
pub(super) struct Source {
    pub blocks: Vec<Result<Block, Fault>>,
    /// Where each file's lines begin, the program's own first.
    files: Vec<(PathBuf, usize)>,
    /// How many lines are the program's own.
    own: usize,
    /// In Fanuc's and Haas's, M98 and G65 call files.
    dialect: Dialect,
    /// Whether a line that cannot be read may have an O-word, DO or END, which another line then lacks.
    pub hides_flow: bool,
}

/// How files of Fanuc's programs end.
const EXTENSIONS: [&str; 8] = [".nc", ".NC", ".ngc", ".cnc", ".CNC", ".tap", ".txt", ""];

impl Source {
    /// # Errors
    /// The file to blame and its line, when a subroutine's file cannot be read or makes too many lines.
    pub fn of(text: &[String], file: &Path, parse: Parse, dialect: Dialect) -> Result<Self, (PathBuf, u32, Cause)> {
        let range = program_lines(text, parse, dialect).map_err(|(line, cause)| (file.to_owned(), line, cause))?;
        let files = vec![(file.to_owned(), 0)];
        let mut source = Self { blocks: Vec::new(), files, own: range.end, dialect, hides_flow: false };
        source.add(text, range, parse);
        // The program ends here, whatever stands behind.
        source.blocks.push(parse("M2"));
        source.add_called_files(file.parent().unwrap_or(Path::new("")), parse)?;
        Ok(source)
    }

    /// Adds the lines up to the range's end; those before it are empty.
    fn add(&mut self, lines: &[String], range: Range<usize>, parse: Parse) {
        self.blocks.extend((0..range.start).map(|_| Ok(Block::default())));
        for line in &lines[range] {
            let block = parse(line);
            self.hides_flow |=
                block.is_err() && (line.contains(['o', 'O']) || line.to_ascii_lowercase().contains("en"));
            self.blocks.push(block);
        }
    }

    fn add_called_files(&mut self, folder: &Path, parse: Parse) -> Result<(), (PathBuf, u32, Cause)> {
        let mut asked = BTreeSet::new();
        loop {
            let missing: Vec<String> = self.missing().into_iter().filter(|name| asked.insert(name.clone())).collect();
            if missing.is_empty() {
                return Ok(());
            }
            for name in missing {
                let Some((path, text)) = self.file_of(folder, &name)? else { continue };
                let lines = match lines(&text) {
                    Ok(lines) if self.blocks.len() + lines.len() <= MAX_LINES => lines,
                    Ok(_) => return Err((path, 1, TOO_MANY_LINES)),
                    Err((line, cause)) => return Err((path, line, cause)),
                };
                let range = match program_lines(&lines, parse, self.dialect) {
                    Ok(range) => range,
                    Err((line, cause)) => return Err((path, line, cause)),
                };
                self.files.push((path, self.blocks.len()));
                self.add(&lines, range, parse);
                // A file ends where it ends, not in the next.
                self.blocks.push(parse("M2"));
            }
        }
    }

    /// The file of a subroutine, if there is one.
    fn file_of(&self, folder: &Path, name: &str) -> Result<Option<(PathBuf, String)>, (PathBuf, u32, Cause)> {
        let number: Option<u32> = if self.dialect.is_fanuc_like() { name.parse().ok() } else { None };
        let names: Vec<String> = match number {
            None => vec![format!("{name}.ngc")],
            Some(number) => {
                [format!("O{number:04}"), format!("o{number:04}"), format!("{number:04}"), format!("{number}")]
                    .into_iter()
                    .flat_map(|stem| EXTENSIONS.map(|extension| format!("{stem}{extension}")))
                    .collect()
            }
        };
        for path in names.into_iter().map(|name| folder.join(name)) {
            match file::text(&path, LARGEST_PROGRAM) {
                Ok(text) => return Ok(Some((path, text))),
                Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {}
                Err(error) => return Err((path, 1, Cause::Unreadable(error.to_string()))),
            }
        }
        Ok(None)
    }

    /// Numbers of the programs that the macro language calls.
    fn called_numbers(&self) -> impl Iterator<Item = String> {
        let blocks = self.blocks.iter().filter_map(|block| block.as_ref().ok());
        let blocks = blocks.filter(|_| self.dialect.is_fanuc_like());
        blocks.flat_map(|block| {
            let literals = |letter: char| {
                block.words.iter().filter(move |word| word.letter == letter).filter_map(|word| word.value.literal())
            };
            let calls = literals('m').any(|code| code == 98.0) || literals('g').any(|code| code == 65.0);
            let number = literals('p').next().filter(|_| calls);
            // Both meanings of Fanuc's P31000.
            let program = number.filter(|_| self.dialect == Dialect::Fanuc).map(|number| number % 10_000.0);
            number.into_iter().chain(program).map(|number| format!("{number}"))
        })
    }

    /// Names of subroutines that are called and not defined, and that can be a file's name.
    fn missing(&self) -> BTreeSet<String> {
        let labels = |wanted: fn(Keyword) -> bool| -> BTreeSet<String> {
            let flows = self.blocks.iter().filter_map(|block| block.as_ref().ok()?.flow.as_ref());
            let fixed = flows.filter(|flow| wanted(flow.keyword)).filter_map(|flow| match &flow.label {
                Label::Fixed(label) => Some(label.trim_matches(['<', '>']).to_owned()),
                Label::Computed(_) => None,
            });
            fixed.collect()
        };
        let defined = labels(|keyword| matches!(keyword, Keyword::Sub | Keyword::Label));
        let called: BTreeSet<String> =
            labels(|keyword| keyword == Keyword::Call).into_iter().chain(self.called_numbers()).collect();
        let is_name = |name: &String| name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' '));
        called.difference(&defined).filter(|name| is_name(name)).cloned().collect()
    }

    /// The lines that cannot be read.
    pub fn unread_lines(&self) -> impl Iterator<Item = (usize, Fault)> {
        self.blocks.iter().enumerate().filter_map(|(at, block)| Some((at, block.as_ref().err()?.clone())))
    }

    /// The file of a line's index, and its number in it from 1.
    pub fn place(&self, at: usize) -> (&Path, u32) {
        let after = self.files.partition_point(|(_, first)| *first <= at);
        let (file, first) = &self.files[after - 1];
        (file, (at - first) as u32 + 1)
    }

    /// The files of subroutines that were read.
    pub fn called_files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().skip(1).map(|(file, _)| file.as_path())
    }

    /// How many lines are the program's own.
    pub fn own_lines(&self) -> usize {
        self.own
    }

    /// Whether a file ends at this index, behind its last line.
    pub fn is_end(&self, at: usize) -> bool {
        at + 1 == self.blocks.len() || self.files.iter().any(|(_, first)| *first == at + 1)
    }

    /// Whether a line before this index is not empty.
    pub fn says_something_before(&self, at: usize) -> bool {
        self.blocks[..at].iter().any(|block| block.as_ref().map_or(true, |block| !block.is_empty()))
    }

    /// Whether a line is the program's own.
    pub fn is_own(&self, at: usize) -> bool {
        at < self.own
    }
}

/// The lines of the program, from 0, as its `%` signs mark them: up to the second when the text starts with one, else up to the first. In a text of
/// Fanuc's that starts with other lines, as a tape does, the program stands behind the first when something stands there.
///
/// # Errors
/// When words stand on both sides of a `%` and nothing tells which the control reads.
fn program_lines(lines: &[String], parse: Parse, dialect: Dialect) -> Result<Range<usize>, (u32, Cause)> {
    let sign_from = |from: usize| lines.iter().skip(from).position(|line| bare(line) == "%").map(|i| from + i);
    let first_line = lines.iter().position(|line| !bare(line).is_empty()).unwrap_or(0);
    let Some(first) = sign_from(0) else { return Ok(0..lines.len()) };
    let second = sign_from(first + 1).unwrap_or(lines.len());
    if first == first_line {
        return Ok(0..second);
    }
    let says_something = |line: &String| parse(line).map_or(true, |block| !block.is_empty());
    if !lines[first + 1..second].iter().any(says_something) {
        return Ok(0..first);
    }
    let has_code =
        |line: &String| parse(line).is_ok_and(|block| block.words.iter().any(|word| matches!(word.letter, 'g' | 'm')));
    let why = if !dialect.is_fanuc_like() {
        "words stand behind this `%`, which ends the program"
    } else if lines[..first].iter().any(has_code) {
        "codes stand on both sides of this `%`: the control may read either"
    } else {
        return Ok(first + 1..second);
    };
    Err((first as u32 + 1, Cause::Flow(why)))
}
