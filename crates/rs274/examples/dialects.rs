//! Which share of the programs of a folder is understood: `cargo run --release --package rs274 --example dialects FOLDER`.
//!
//! A subfolder is a row: name it after what it holds. Each file is interpreted in every dialect, with a mill's and a lathe's defaults and a thin tool of
//! every number; it counts as understood when one of these accepts all of it. Below the table stand the first errors of the others, by how many
//! files they stop. `scripts/dialects` runs this.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example prints")]

use rs274::file::{LARGEST_PROGRAM, text};
use rs274::{Cause, Dialect, GcodeError, Setup, Tool, interpret};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Endings of files that are programs.
const ENDINGS: [&str; 15] =
    ["ngc", "nc", "gcode", "tap", "cnc", "mpf", "spf", "h", "eia", "iso", "ncc", "ncd", "prg", "txt", "min"];
/// Tools that exist.
const TOOLS: u32 = 9999;
/// Blockers shown per row.
const SHOWN: usize = 8;

/// A row: how many files, how many are understood in each dialect and in any, how many are named as another language's, and what stops the
/// others.
#[derive(Default)]
struct Row {
    files: usize,
    by_dialect: [usize; Dialect::ALL.len()],
    any: usize,
    named: usize,
    blockers: BTreeMap<String, usize>,
}

fn main() -> ExitCode {
    let Some(folder) = std::env::args().nth(1).map(PathBuf::from).filter(|folder| folder.is_dir()) else {
        eprintln!("usage: dialects FOLDER (with a subfolder for each kind of program)");
        return ExitCode::from(2);
    };
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    for file in programs(&folder) {
        let below = file.strip_prefix(&folder).unwrap_or(&file);
        let first = below.components().next().filter(|_| below.components().count() > 1);
        let name = first.map_or_else(|| ".".to_owned(), |part| part.as_os_str().to_string_lossy().into_owned());
        rows.entry(name).or_default().add(&file);
    }
    if rows.is_empty() {
        eprintln!("{}: no programs ({})", folder.display(), ENDINGS.join(", "));
        return ExitCode::from(2);
    }
    println!(
        "| programs | files | {} | understood | named |",
        Dialect::ALL.map(|dialect| dialect.to_string()).join(" | ")
    );
    println!("|---|---|{}---|---|", "---|".repeat(Dialect::ALL.len()));
    for (name, row) in &rows {
        let counts = row.by_dialect.map(|count| count.to_string()).join(" | ");
        let share = 100.0 * row.any as f64 / row.files as f64;
        println!("| {name} | {} | {counts} | {} ({share:.0} %) | {} |", row.files, row.any, row.named);
    }
    for (name, row) in rows.iter().filter(|(_, row)| !row.blockers.is_empty()) {
        println!("\n{name}, first errors by files:");
        let mut blockers: Vec<_> = row.blockers.iter().collect();
        blockers.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        for (blocker, count) in blockers.into_iter().take(SHOWN) {
            println!("  {count:4}  {blocker}");
        }
    }
    ExitCode::SUCCESS
}

/// All programs below a folder, in order.
fn programs(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for entry in entries.flatten() {
            let path = entry.path();
            // A link may lead in a circle.
            let Ok(kind) = entry.file_type() else { continue };
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
            if kind.is_dir() {
                folders.push(path);
            } else if kind.is_file() && ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

impl Row {
    fn add(&mut self, file: &Path) {
        self.files += 1;
        let source = match text(file, LARGEST_PROGRAM) {
            Ok(source) => source,
            Err(error) => return self.stop(&format!("cannot be read: {}", error.kind())),
        };
        let mut errors = Vec::new();
        let mut is_understood = false;
        for (dialect, count) in Dialect::ALL.into_iter().zip(&mut self.by_dialect) {
            match accepted(&source, file, dialect) {
                Ok(()) => {
                    *count += 1;
                    is_understood = true;
                }
                Err(error) => errors.push(error),
            }
        }
        if is_understood {
            self.any += 1;
        } else if errors.iter().any(|error| matches!(error.cause, Cause::Foreign(_))) {
            self.named += 1;
        } else if let Some(farthest) = errors.iter().max_by_key(|error| error.line) {
            self.stop(&blocker(farthest));
        }
    }

    fn stop(&mut self, blocker: &str) {
        *self.blockers.entry(blocker.to_owned()).or_default() += 1;
    }
}

/// Whether a mill or a lathe accepts the program; else the error that comes later.
fn accepted(source: &str, file: &Path, dialect: Dialect) -> Result<(), GcodeError> {
    let tools: BTreeMap<u32, Tool> = (1..=TOOLS).map(|number| (number, Tool::with_length(100.0, 0.1))).collect();
    let run = |setup: Setup| interpret(source, file, &Setup { tools: tools.clone(), dialect, ..setup }).map(drop);
    run(Setup::default())
        .or_else(|mill| run(Setup::lathe()).map_err(|lathe| if lathe.line > mill.line { lathe } else { mill }))
}

/// An error without its place: the word and the cause.
fn blocker(error: &GcodeError) -> String {
    let word = error.text.trim();
    let cause = error.cause.to_string();
    if word.is_empty() { cause } else { format!("`{word}`: {cause}") }
}
