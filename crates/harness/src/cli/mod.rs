//! The command line: one file per verb. The only module that prints.
//!
//! [`main_with`] gives any registry the whole of it, so that a volume from another crate is listed, verified, measured,
//! plotted and reported like the ones that are shipped.

mod ablation;
mod agree;
mod analyze;
mod audit;
mod check;
mod compare;
mod conclusion;
mod gcode;
mod identity;
mod launch;
mod list;
mod machines;
mod measure;
mod merge;
mod options;
mod path;
mod peers;
mod picture;
mod plot;
mod progress;
mod repetitions;
mod report;
mod repro;
mod scene;
mod shell;
mod style;
mod subject;
mod supplements;
mod surfaces;
mod sweep;
mod trial;
mod verify;
mod view;

pub use subject::refuse_output;

use crate::measure::environment::{self, Build};
use crate::registry::Registry;
use anyhow::{Result, anyhow};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::io;
use std::process::ExitCode;
use std::sync::OnceLock;

/// Exit code when all is well.
const CLEAR: u8 = 0;
/// Exit code when what a verb looks for was found: a safe variant missed a contact, a program collides.
const FAILED: u8 = 1;
/// Exit code for bad usage, bad input, and output that cannot be written.
const BAD_INPUT: u8 = 2;

/// Bounding volumes on trial: compares bounding-volume methods for machine-tool collision detection against exact truth.
#[derive(Parser)]
#[command(name = "bvbench", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

const EXAMPLES: &str = "\
Examples:
  bvbench repro                          reproduce the paper, in five minutes
  bvbench repro --profile smoke          the same in two minutes, to see that it works
  bvbench try my-scene                   which volume suits a machine of your own
  bvbench check SCENE part.ngc           what collides on this machine, at which line
  bvbench view SCENE part.ngc --open     the machine in motion, in the browser
  bvbench scene pairs SCENE              which parts can collide at all, and why the others cannot
  bvbench program gcode part.ngc         what a program means, move by move
  bvbench study audit --profile smoke    which property of a box matters
  bvbench stage compare RUN_A RUN_B      what changed between two runs, beyond noise

Every verb has --help with examples. `bvbench completions SHELL` prints shell completions,
`bvbench man` writes manual pages.

Exit codes: 0 all is well; 1 a safe variant missed a contact, a later run fails a gate of
`stage compare`, or a program collides; 2 bad usage or input, or output that cannot be written.";

#[derive(Subcommand)]
enum Verb {
    /// Reproduce the paper: verify, measure, analyse, plot and report
    Repro(repro::Options),
    /// Compare the volumes on a scene or meshes of your own
    Try(trial::Options),
    /// List the variants: id, label, safety, default tree, source
    List(list::Options),
    /// Check a program on a machine: what collides, at which line
    Check(check::Options),
    /// Write a page that shows the machine in motion
    View(view::Options),
    /// Show a scene: what it holds, which parts can collide
    Scene(scene::Options),
    /// Show what a G-code program means, or write one over a surface
    #[command(subcommand)]
    Program(Program),
    /// Run one experiment: audit (boxes), sweep (one quantity), ablation (the octree method), agree (exact engines)
    #[command(subcommand)]
    Study(Study),
    /// Run one stage: verify, measure, analyze, plot, report; compare two runs, or merge shards
    #[command(subcommand)]
    Stage(Stage),
    /// Compare whole engines, ours and others, on the same poses
    Peers(peers::Options),
    /// Print completions for a shell
    #[command(hide = true)]
    Completions(shell::CompletionOptions),
    /// Write manual pages
    #[command(hide = true)]
    Man(shell::ManOptions),
    /// Print what this binary was built from (asked by runs over several binaries)
    #[command(hide = true)]
    Identity,
    /// Carry out one timing launch of a run in this process (called by `measure`)
    #[command(hide = true)]
    Launch(launch::Options),
}

#[derive(Subcommand)]
enum Program {
    /// Print the canonical moves of a program
    Gcode(gcode::Options),
    /// Write a tool path over a free-form part as a program
    Path(path::Options),
}

#[derive(Subcommand)]
enum Study {
    /// Cross orientation, centre, split and leaf size of boxes: which of them matters?
    Audit(audit::Options),
    /// Vary one quantity and keep everything else: tessellation, size, distance, frame, shape, path step
    Sweep(sweep::Options),
    /// Switch parts of the octree method off: what each saves, what sampling misses
    Ablation(ablation::Options),
    /// Ask exact engines about posed pairs by the million: do they agree?
    Agree(agree::Options),
}

#[derive(Subcommand)]
enum Stage {
    /// Compare every variant's verdicts with the exact truth
    Verify(verify::Options),
    /// Count operations, describe trees, and time queries and construction
    Measure(measure::Options),
    /// Turn a run's raw records into summary, ratios and verdicts on the claims
    Analyze(analyze::Options),
    /// Draw a run's figures, SVG and PNG
    Plot(plot::Options),
    /// Write a run's report
    Report(report::Options),
    /// Compare two runs: what changed beyond noise
    Compare(compare::Options),
    /// Merge the shards of a run or a study
    Merge(merge::Options),
}

/// The verbs that `--help` shows, by what they are for.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Start here", &["repro", "try", "list"]),
    ("Your machine", &["check", "view", "scene", "program"]),
    ("Studies", &["study"]),
    ("Stages of a run", &["stage"]),
    ("Other engines", &["peers"]),
];

/// Verbs that once stood alone, and the verb they belong to now.
const MOVED: [(&str, &[&str]); 3] = [
    ("program", &["gcode", "path"]),
    ("study", &["audit", "sweep", "ablation"]),
    ("stage", &["verify", "measure", "analyze", "plot", "report", "compare"]),
];

/// The command line with its verbs in groups.
fn command() -> clap::Command {
    let command = Arguments::command();
    let mut verbs = String::new();
    for (group, names) in GROUPS {
        verbs += &format!("{group}:\n");
        for name in names {
            let about = command.find_subcommand(name).and_then(clap::Command::get_about).cloned().unwrap_or_default();
            verbs += &format!("  {name:<9}{about}\n");
        }
        verbs.push('\n');
    }
    command.help_template(format!(
        "{{about}}\n\n{{usage-heading}} {{usage}}\n\n{verbs}Options:\n{{options}}{{after-help}}"
    ))
}

/// The words of the command line, an old spelling of a verb replaced by the new one, which it names.
fn words() -> Vec<OsString> {
    let mut words: Vec<OsString> = std::env::args_os().collect();
    let verb = words.get(1).and_then(|word| word.to_str()).unwrap_or_default().to_owned();
    if let Some((owner, _)) = MOVED.iter().find(|(_, verbs)| verbs.contains(&verb.as_str())) {
        note(format!("`bvbench {verb}` is now `bvbench {owner} {verb}`"));
        words.insert(1, owner.into());
    }
    words
}

/// Runs the command line of this process over the variants of `registry`, for a program that was built from `build`.
#[expect(clippy::needless_pass_by_value, reason = "a `main` builds the registry and is done with it")]
pub fn main_with(registry: Registry, build: Build) -> ExitCode {
    environment::tell(build);
    let parsed = command().try_get_matches_from(words()).and_then(|found| Arguments::from_arg_matches(&found));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version come as errors too, but are none; clap prints them to the right stream.
            let printed = error.print();
            if error.use_stderr() {
                return ExitCode::from(BAD_INPUT);
            }
            remember(printed);
            return exit_code(said_all().map(|()| CLEAR));
        }
    };
    exit_code(run(arguments.verb, &registry).and_then(|code| said_all().map(|()| code)))
}

fn exit_code(outcome: Result<u8>) -> ExitCode {
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            say_error(&error);
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn run(verb: Verb, registry: &Registry) -> Result<u8> {
    match verb {
        Verb::Repro(options) => repro::run(&options, registry),
        Verb::Try(options) => trial::run(&options, registry),
        Verb::List(options) => list::run(&options, registry),
        Verb::Check(options) => check::run(&options, registry),
        Verb::View(options) => view::run(&options, registry),
        Verb::Scene(options) => scene::run(&options),
        Verb::Program(Program::Gcode(options)) => gcode::run(&options),
        Verb::Program(Program::Path(options)) => path::run(&options).map(|()| CLEAR),
        Verb::Study(Study::Audit(options)) => audit::run(&options, registry),
        Verb::Study(Study::Sweep(options)) => sweep::run(&options, registry),
        Verb::Study(Study::Ablation(options)) => ablation::run(&options, registry),
        Verb::Study(Study::Agree(options)) => agree::run(&options, registry),
        Verb::Stage(Stage::Verify(options)) => verify::run(&options, registry),
        Verb::Stage(Stage::Measure(options)) => measure::run(&options, registry),
        Verb::Stage(Stage::Analyze(options)) => analyze::run(&options),
        Verb::Stage(Stage::Plot(options)) => plot::run(&options),
        Verb::Stage(Stage::Report(options)) => report::run(&options, registry),
        Verb::Stage(Stage::Compare(options)) => compare::run(&options),
        Verb::Stage(Stage::Merge(options)) => merge::run(&options, registry),
        Verb::Peers(options) => peers::run(&options, registry),
        Verb::Completions(options) => shell::completions(&options),
        Verb::Man(options) => shell::man(&options),
        Verb::Identity => identity::run(),
        Verb::Launch(options) => launch::run(&options, registry),
    }
}

/// The first error of writing to standard output, kept until the verb is done: what it measured is in its files by then.
static UNSAID: OnceLock<io::Error> = OnceLock::new();

/// Prints a line to standard output; [`said_all`] tells whether it arrived.
fn say(text: impl std::fmt::Display) {
    use std::io::Write;
    remember(writeln!(io::stdout(), "{}", printable(&text.to_string())));
}

/// Text that cannot steer a terminal: control characters are shown escaped, but for line ends, tabs and colours (`ESC [ digits m`).
fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for (place, c) in text.char_indices() {
        let is_colour = || {
            let code = text[place + 1..].strip_prefix('[');
            code.is_some_and(|code| code.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').starts_with('m'))
        };
        if c.is_control() && !matches!(c, '\n' | '\t') && !(c == '\x1b' && is_colour()) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Keeps an error of standard output. A reader that has gone away (`bvbench list | head -1`) is none.
fn remember(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        // Only the first counts.
        let _ = UNSAID.set(error);
    }
}

/// Whether standard output has all that was said, the buffer's rest among it.
fn said_all() -> Result<()> {
    use std::io::Write;
    remember(io::stdout().flush());
    match UNSAID.get() {
        None => Ok(()),
        Some(error) => Err(anyhow!("cannot write to standard output: {error}")),
    }
}

/// Prints a line about how things go to standard error, where it does not mix with results.
fn note(text: impl std::fmt::Display) {
    use std::io::Write;
    let _ = writeln!(io::stderr(), "{}", printable(&text.to_string()));
}

/// An error and its causes; a cause that the error already tells is not told twice.
fn error_text(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Prints an error and its causes.
fn say_error(error: &anyhow::Error) {
    note(format!("error: {}", error_text(error)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_shows_every_verb_in_one_group_and_ten_at_most() {
        let command = command();
        let visible = command.get_subcommands().filter(|verb| !verb.is_hide_set()).map(clap::Command::get_name);
        let mut visible: Vec<&str> = visible.collect();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, verbs)| verbs.iter().copied()).collect();
        visible.sort_unstable();
        grouped.sort_unstable();
        assert_eq!(visible, grouped);
        assert!(grouped.len() <= 10);
        command.clone().debug_assert();
    }

    #[test]
    fn verbs_have_moved_to_where_the_old_spelling_says() {
        let command = command();
        for (owner, verbs) in MOVED {
            let owner = command.find_subcommand(owner).unwrap();
            assert!(verbs.iter().all(|verb| owner.find_subcommand(verb).is_some()));
            assert!(verbs.iter().all(|verb| command.find_subcommand(verb).is_none()));
        }
    }

    /// The commands of a line: their words as a POSIX shell splits them. What follows two spaces is a remark.
    fn commands(line: &str) -> Vec<Vec<String>> {
        let line = line.split("  ").next().unwrap_or_default();
        let (mut commands, mut quote) = (vec![vec![String::new()]], None);
        for c in line.chars() {
            let words = commands.last_mut().unwrap();
            match (quote, c) {
                (Some(mark), _) if mark == c => quote = None,
                (None, '\'' | '"') => quote = Some(c),
                (None, '|' | '&' | '>') => commands.push(vec![String::new()]),
                (None, ' ') => words.push(String::new()),
                _ => words.last_mut().unwrap().push(c),
            }
        }
        commands.iter_mut().for_each(|words| words.retain(|word| !word.is_empty()));
        commands
    }

    /// The lines of the help of a command and of those below it, continued ones joined.
    fn help_lines(command: &clap::Command, lines: &mut Vec<String>) {
        let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let joined = text.split("\\\n").map(str::trim_start).collect::<String>();
        lines.extend(joined.lines().map(|line| line.trim().to_owned()));
        command.get_subcommands().for_each(|verb| help_lines(verb, lines));
    }

    #[test]
    fn every_command_that_a_help_text_shows_is_understood() {
        let mut lines = Vec::new();
        help_lines(&command(), &mut lines);
        let all = lines.iter().flat_map(|line| commands(line));
        let mut shown: Vec<_> = all.filter(|words| words.first().is_some_and(|word| word == "bvbench")).collect();
        assert!(shown.len() >= 100, "{}", shown.len());
        for words in &mut shown {
            // More options like the last one; behind an option its value.
            if let [.., before, last] = &words[..]
                && last == "..."
                && !before.starts_with('-')
            {
                words.pop();
            }
            let parsed = command().try_get_matches_from(&*words);
            assert!(parsed.is_ok(), "{}: {}", words.join(" "), parsed.unwrap_err());
        }
    }
}
