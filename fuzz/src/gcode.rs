//! A program, interpreted on a small machine and sampled along its path.

use rs274::path::count;
use rs274::{Dialect, Limits, Position, RapidPath, Sampling, Setup, Tool, UserCode, WorkOffset, interpret, sample};
use std::path::Path;

/// The coarsest way to walk a path that still passes through every kind of move.
const SAMPLING: Sampling = Sampling { step_mm: 1e5, step_deg: 1e4, chord_mm: 10.0 };

pub fn run(bytes: &[u8], dialect: Dialect) {
    let text = String::from_utf8_lossy(bytes);
    // The first bit of the program chooses the machine, so that both are reached.
    let is_lathe = bytes.first().is_some_and(|byte| byte & 1 == 1);
    let setup = if is_lathe { Setup::lathe() } else { Setup::default() };
    let turned = WorkOffset { origin: Position([10.0, -20.0, 5.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0]), rotation: 0.5 };
    let mut work_offsets = setup.work_offsets;
    work_offsets[1] = turned;
    let setup = Setup {
        work_offsets,
        tools: [(1, Tool::with_length(50.0, 6.0)), (2, Tool { orientation: 3, ..Tool::with_length(80.0, 2.0) })].into(),
        user_codes: [(428, UserCode::TipOn), (429, UserCode::TipOff), (100, UserCode::Ignore)].into(),
        // Small, or the search spends its time in loops.
        limits: Limits { moves: 20_000, blocks: 20_000 },
        dialect,
        ignored: ["M31".parse(), "G187".parse()].into_iter().flatten().collect(),
        ..setup
    };
    // No folder of that name: a subroutine of another file is never found.
    let Ok(program) = interpret(&text, Path::new("no such folder/program.ngc"), &setup) else { return };
    for rapids in [RapidPath::Straight, RapidPath::DogLeg([1000.0; 9])] {
        // Tens of megabytes at most, or the search spends its time in memory.
        if !count(&program, &setup.start, &SAMPLING, &rapids).is_ok_and(|count| count < 100_000) {
            continue;
        }
        let Ok(samples) = sample(&program, &setup.start, &SAMPLING, &rapids) else { continue };
        let finite = samples.iter().all(|sample| sample.position.0.iter().all(|x| x.is_finite()));
        assert!(finite, "a position is not finite");
    }
}
