//! What was too noisy to judge, in a sentence or two for terminal, `report.md` and page; each of them names the cells elsewhere.

use super::Contents;
use crate::analysis::ratios::NoisyCells;
use crate::analysis::words::listed;
use crate::analysis::{ALL, counted};
use crate::record::{PROGRAM_TIME, PROGRAM_TIME_COLD};
use std::collections::BTreeMap;

/// Nothing where all is quiet. Workloads as a whole are named; cells of a stratum or a single program are counted.
pub fn in_short(contents: &Contents) -> Option<String> {
    let cells = NoisyCells::of(&contents.ratios);
    let mut scenes_of: BTreeMap<&str, usize> = BTreeMap::new();
    let mut parts = 0;
    for (workload, stratum) in cells.names() {
        if stratum == ALL {
            *scenes_of.entry(workload).or_default() += 1;
        } else {
            parts += 1;
        }
    }
    let mut noisy: Vec<String> = scenes_of
        .iter()
        .map(|(workload, scenes)| format!("{} in {}", spoken(workload), counted(*scenes as u64, "scenes")))
        .collect();
    if parts > 0 {
        noisy.push(format!("{} of a stratum or a single program", counted(parts as u64, "cells")));
    }
    let mut sentences = Vec::new();
    if !noisy.is_empty() {
        sentences.push(format!("Noisy: {}. Speed is undecided there.", listed(&noisy)));
        if !scenes_of.contains_key(PROGRAM_TIME) && !contents.program_times.is_empty() {
            sentences.push("The times of whole programs are quiet.".to_owned());
        }
    }
    let disturbed = contents.manifest.noise.len();
    if disturbed > 0 {
        sentences.push(format!("Something else used the machine during {}.", counted(disturbed as u64, "timings")));
    }
    (!sentences.is_empty()).then(|| format!("{} Counts and misses are not affected.", sentences.join(" ")))
}

fn spoken(workload: &str) -> &str {
    match workload {
        PROGRAM_TIME => "whole programs",
        PROGRAM_TIME_COLD => "programs with cold caches",
        sampled => sampled,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::analyze;
    use crate::analysis::claims::ClaimSet;
    use crate::record::NULL_VARIANT;
    use crate::record::synthetic::{Plan, Run};

    fn short_of(change: impl FnOnce(&mut Contents)) -> Option<String> {
        let folder = tempfile::TempDir::new().unwrap();
        Run::generate(&Plan::default()).write(folder.path());
        analyze(folder.path(), &ClaimSet::standard()).unwrap();
        let mut contents = Contents::read(folder.path()).unwrap();
        change(&mut contents);
        in_short(&contents)
    }

    fn disturb(contents: &mut Contents, workload: &str) {
        let of_null = |row: &&mut crate::record::RatioRow| row.variant == NULL_VARIANT && row.workload == workload;
        contents.ratios.iter_mut().filter(of_null).for_each(|row| row.ratio = 1.5);
    }

    #[test]
    fn a_quiet_run_says_nothing() {
        assert_eq!(short_of(|_| ()), None);
    }

    #[test]
    fn noisy_samples_do_not_make_whole_programs_noisy() {
        let text = short_of(|contents| disturb(contents, "approach")).unwrap();
        assert!(
            text.starts_with("Noisy: approach in 2 scenes and ") && text.contains("whole programs are quiet"),
            "{text}"
        );
        let text = short_of(|contents| disturb(contents, PROGRAM_TIME)).unwrap();
        assert!(text.starts_with("Noisy: whole programs in 2 scenes") && !text.contains("are quiet"), "{text}");
    }

    #[test]
    fn a_busy_neighbour_is_told_too() {
        let text = short_of(|contents| contents.manifest.noise.push("a busy neighbour".to_owned())).unwrap();
        assert!(text.starts_with("Something else used the machine during 1 timing. Counts"), "{text}");
    }
}
