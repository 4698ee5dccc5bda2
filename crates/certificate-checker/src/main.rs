//! The command: reads a certificate and says whether it is accepted.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command prints")]

use certificate_checker::{MOST_WORK, VERDICTS, check};
use std::path::Path;
use std::process::ExitCode;

/// Most lines of a program that are named.
const MOST_NAMED: usize = 40;

const HELP: &str = "Checks a certificate of `bvbench check --certify`.

Usage: certificate-checker CERTIFICATE [--scene SCENE] [--program FILE]

  CERTIFICATE       the file; - reads standard input
  --scene SCENE     compare machine, parts and meshes with the scene's own files; its folder, or its .toml file
  --program FILE    compare the hash of the program

Exit codes: 0 accepted, 1 refused, 2 bad usage.";

fn bad_usage(what: &str) -> ExitCode {
    eprintln!("{what}\n\n{HELP}");
    ExitCode::from(2)
}

fn main() -> ExitCode {
    let [mut certificate, mut scene, mut program] = [None, None, None];
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--help" | "-h" => {
                println!("{HELP}");
                return ExitCode::SUCCESS;
            }
            "--scene" | "--program" => {
                let Some(value) = arguments.next() else { return bad_usage(&format!("{argument} needs a value")) };
                *(if argument == "--scene" { &mut scene } else { &mut program }) = Some(value);
            }
            name if name.starts_with('-') && name != "-" || certificate.is_some() => {
                return bad_usage(&format!("`{argument}` is not understood"));
            }
            _ => certificate = Some(argument),
        }
    }
    let Some(certificate) = certificate else { return bad_usage("no certificate is named") };
    let is_input = certificate == "-";
    let text = if is_input { std::io::read_to_string(std::io::stdin()) } else { std::fs::read_to_string(&certificate) };
    let text = match text {
        Ok(text) => text,
        Err(error) => return bad_usage(&format!("{certificate}: {error}")),
    };
    let report = match check(&text, scene.as_deref().map(Path::new), program.as_deref().map(Path::new), MOST_WORK) {
        Ok(report) => report,
        Err(refusal) => {
            println!("{certificate}:{}: refused: {}", refusal.line, refusal.why);
            return ExitCode::from(1);
        }
    };
    report.notes.iter().for_each(|note| println!("{note}"));
    let lines = |verdict: &str| -> Vec<String> {
        report.blocks.iter().filter(|block| *block.1 == verdict).map(|block| block.0.to_string()).collect()
    };
    for verdict in VERDICTS.into_iter().skip(1).rev().filter(|verdict| !lines(verdict).is_empty()) {
        let lines = lines(verdict);
        let more = if lines.len() > MOST_NAMED { " ..." } else { "" };
        println!("{verdict}: {} blocks, lines {}{more}", lines.len(), lines[..lines.len().min(MOST_NAMED)].join(" "));
    }
    let (free, all, pairs, intervals) = (lines("free").len(), report.blocks.len(), report.examined, report.intervals);
    println!("accepted: {free} of {all} blocks are free, by {intervals} intervals of {pairs} pairs");
    ExitCode::SUCCESS
}
