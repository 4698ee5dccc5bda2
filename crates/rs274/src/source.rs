//! The lines of a program and of the subroutine files it calls.
//!
//! A subroutine that the program does not define is looked for beside it, as `NAME.ngc` for `O<NAME> call` (LinuxCNC, "Calling
//! Files"). Files are found before the program runs, so a label that is computed finds none.

use super::block::{Block, Keyword, Label};
use super::error::Fault;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Most lines of a program with its subroutine files.
const MAX_LINES: usize = 4_000_000;

/// Parses a line; the interpreter decides what block delete leaves of it.
pub(super) type Parse<'a> = &'a dyn Fn(&str) -> Result<Block, Fault>;

/// The lines of a file's text, without the byte-order mark that editors on Windows put before it.
pub(super) fn lines(text: &str) -> std::str::Lines<'_> {
    text.strip_prefix('\u{feff}').unwrap_or(text).lines()
}

/// All lines, parsed; a line that is wrong is an error only when it is executed.
pub(super) struct Source {
    pub blocks: Vec<Result<Block, Fault>>,
    /// Where each file's lines begin, the program's own first.
    files: Vec<(PathBuf, usize)>,
    /// How many lines are the program's own.
    own: usize,
}

impl Source {
    pub fn of(text: &[String], file: &Path, parse: Parse) -> Self {
        let lines = program_text(text);
        let mut source = Self { blocks: Vec::new(), files: vec![(file.to_owned(), 0)], own: lines.len() };
        source.add(lines, parse);
        // The program ends here, whatever stands behind.
        source.blocks.push(parse("M2"));
        source.add_called_files(file.parent().unwrap_or(Path::new("")), parse);
        source
    }

    fn add<L: AsRef<str>>(&mut self, lines: &[L], parse: Parse) {
        self.blocks.extend(lines.iter().map(|line| parse(line.as_ref())));
    }

    fn add_called_files(&mut self, folder: &Path, parse: Parse) {
        let mut asked = BTreeSet::new();
        loop {
            let missing: Vec<String> = self.missing().into_iter().filter(|name| asked.insert(name.clone())).collect();
            if missing.is_empty() || self.blocks.len() > MAX_LINES {
                return;
            }
            for name in missing {
                let path = folder.join(format!("{name}.ngc"));
                let Ok(bytes) = std::fs::read(&path) else { continue };
                self.files.push((path, self.blocks.len()));
                let text = String::from_utf8_lossy(&bytes);
                self.add(&lines(&text).collect::<Vec<_>>(), parse);
            }
        }
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
        let called = labels(|keyword| keyword == Keyword::Call);
        let is_name = |name: &String| name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' '));
        called.difference(&defined).filter(|name| is_name(name)).cloned().collect()
    }

    /// The file of a line's index, and its number in it from 1.
    pub fn place(&self, at: usize) -> (&Path, u32) {
        let after = self.files.partition_point(|(_, first)| *first <= at);
        let (file, first) = &self.files[after - 1];
        (file, (at - first) as u32 + 1)
    }

    /// Whether a line is the program's own.
    pub fn is_own(&self, at: usize) -> bool {
        at < self.own
    }
}

/// The lines up to the program's end as its `%` signs mark it: the second one when the text starts with one, else the
/// first.
fn program_text(lines: &[String]) -> &[String] {
    let first = lines.iter().position(|line| !line.trim().is_empty()).unwrap_or(0);
    let end = lines.iter().skip(first + 1).position(|line| line.trim() == "%").map(|i| first + 1 + i);
    &lines[..end.unwrap_or(lines.len())]
}
