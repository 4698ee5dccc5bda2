//! The command: reads a certificate and says whether it is accepted.

use certificate_checker::{MOST_WORK, Report, VERDICTS, check, own_file};
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Most lines of a program that are named.
const MOST_NAMED: usize = 40;

const HELP: &str = "Checks a certificate of `bvbench check --certify`.

Usage: certificate-checker CERTIFICATE [--scene SCENE] [--program FILE]

  CERTIFICATE       the file; - reads standard input
  --scene SCENE     compare machine, parts and meshes with the scene's own files; its folder, or its .toml file (those that
                    bvbench knows by name are in its folder bench-scenes)
  --program FILE    compare the hashes of the program and of the files beside it that it calls

Exit codes: 0 accepted, also where blocks are `collision`, `unresolved` or `stock`: the answer names them; 1 refused, 2 bad usage, a file that is named
cannot be read, or the answer could not be written.
";

fn main() -> ExitCode {
    let (text, code) = match answer(std::env::args_os().skip(1)) {
        Ok(answer) => answer,
        Err(why) => {
            // Where nothing can be written, the exit code says it.
            let _ = write!(std::io::stderr(), "{why}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let _ = writeln!(std::io::stderr(), "cannot write to standard output: {error}");
            ExitCode::from(2)
        }
        _ => ExitCode::from(code),
    }
}

/// The answer, and how the command ends; an error is one of usage.
fn answer(mut arguments: impl Iterator<Item = OsString>) -> Result<(String, u8), String> {
    let [mut certificate, mut scene, mut program] = [None, None, None];
    while let Some(argument) = arguments.next() {
        let name = argument.to_string_lossy();
        match &*name {
            "--help" | "-h" => return Ok((HELP.to_owned(), 0)),
            "--scene" | "--program" => {
                let value = arguments.next().ok_or_else(|| format!("{name} needs a value"))?;
                *(if name == "--scene" { &mut scene } else { &mut program }) = Some(PathBuf::from(value));
            }
            _ if name.starts_with('-') && name != "-" || certificate.is_some() => {
                return Err(format!("`{name}` is not understood"));
            }
            _ => certificate = Some(PathBuf::from(argument)),
        }
    }
    let certificate = certificate.ok_or("no certificate is named")?;
    readable("--scene", scene.as_deref().map(own_file).as_deref())?;
    readable("--program", program.as_deref())?;
    let is_input = certificate == Path::new("-");
    let text = if is_input { std::io::read_to_string(std::io::stdin()) } else { std::fs::read_to_string(&certificate) };
    let text = text.map_err(|error| format!("{}: {error}", certificate.display()))?;
    Ok(match check(&text, scene.as_deref(), program.as_deref(), MOST_WORK) {
        Ok(report) => (told(&report), 0),
        Err(refusal) => (format!("{}:{}: refused: {}\n", certificate.display(), refusal.line, refusal.why), 1),
    })
}

/// Whether the file that an option names can be read, where there is one: a mistyped path says nothing of the certificate.
fn readable(option: &str, file: Option<&Path>) -> Result<(), String> {
    let Some(file) = file else { return Ok(()) };
    let is_file = |found: Metadata| if found.is_file() { Ok(()) } else { Err(Error::other("this is no regular file")) };
    let opened = file.metadata().and_then(is_file).and_then(|()| File::open(file));
    opened.map(drop).map_err(|error| format!("{option} {}: {error}", file.display()))
}

/// The answer for an accepted certificate: the verdicts, and what was not examined.
fn told(report: &Report) -> String {
    let mut text: String = report.notes.iter().map(|note| format!("{note}\n")).collect();
    let lines = |verdict: &str| -> Vec<String> {
        report.blocks.iter().filter(|block| *block.1 == verdict).map(|block| block.0.to_string()).collect()
    };
    for verdict in VERDICTS.into_iter().skip(1).rev() {
        let lines = lines(verdict);
        let more = if lines.len() > MOST_NAMED { " ..." } else { "" };
        let named = lines[..lines.len().min(MOST_NAMED)].join(" ");
        if !lines.is_empty() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{verdict}: {} blocks, lines {named}{more}", lines.len());
        }
    }
    let (free, all, pairs, intervals) = (lines("free").len(), report.blocks.len(), report.examined, report.intervals);
    let cutting = match report.cutting.len() {
        0 => String::new(),
        count => format!("; in {count} blocks a cutter feeds, where it may be in the workpiece"),
    };
    text + &format!("accepted: {free} of {all} blocks are free, by {intervals} intervals of {pairs} pairs{cutting}\n")
}
