//! The command: reads a certificate and says whether it is accepted.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command prints")]

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::ExitCode;

const HELP: &str = "Checks a certificate of `bvbench check --certify`.

Usage: certificate-checker CERTIFICATE [--scene FOLDER] [--program FILE]

  CERTIFICATE       the file; - reads standard input
  --scene FOLDER    compare machine, parts and meshes with the scene's own files
  --program FILE    compare the hash of the program

Exit codes: 0 accepted, 1 refused, 2 bad usage.";

fn main() -> ExitCode {
    let (mut certificate, mut scene, mut program) = (None, None, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let slot = match argument.as_str() {
            "--scene" => &mut scene,
            "--program" => &mut program,
            "--help" | "-h" => {
                println!("{HELP}");
                return ExitCode::SUCCESS;
            }
            name if name.starts_with('-') && name != "-" || certificate.is_some() => {
                eprintln!("`{argument}` is not understood\n\n{HELP}");
                return ExitCode::from(2);
            }
            _ => {
                certificate = Some(argument);
                continue;
            }
        };
        *slot = arguments.next().map(PathBuf::from);
        if slot.is_none() {
            eprintln!("{argument} needs a value\n\n{HELP}");
            return ExitCode::from(2);
        }
    }
    let Some(certificate) = certificate else {
        eprintln!("{HELP}");
        return ExitCode::from(2);
    };
    let text: Box<dyn BufRead> = if certificate == "-" {
        Box::new(std::io::stdin().lock())
    } else {
        match File::open(&certificate) {
            Ok(file) => Box::new(BufReader::new(file)),
            Err(error) => {
                eprintln!("{certificate}: {error}");
                return ExitCode::from(2);
            }
        }
    };
    match certificate_checker::check(text, scene.as_deref(), program.as_deref()) {
        Ok(report) => {
            report.notes.iter().for_each(|note| println!("{note}"));
            for verdict in certificate_checker::VERDICTS.into_iter().skip(1).rev() {
                let lines = report.blocks.iter().filter(|(_, found)| **found == verdict);
                let lines: Vec<String> = lines.map(|(line, _)| line.to_string()).collect();
                if !lines.is_empty() {
                    println!("{verdict}: {} blocks, lines {}", lines.len(), lines.join(" "));
                }
            }
            let free = report.blocks.values().filter(|found| **found == "free").count();
            let (all, pairs, intervals) = (report.blocks.len(), report.examined, report.intervals);
            println!("accepted: {free} of {all} blocks are free, by {intervals} intervals of {pairs} pairs");
            ExitCode::SUCCESS
        }
        Err(refusal) => {
            println!("{certificate}:{}: refused: {}", refusal.line, refusal.why);
            ExitCode::from(1)
        }
    }
}
