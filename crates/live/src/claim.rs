//! Does the paper's claim of real time hold here? Long runs decide.
//!
//! A run supports the claim when at most [`LATE`] of its verdicts came after the deadline, and refutes it otherwise. The share has no interval: samples of
//! one run depend on one another. The answer is about this computer and a simulated control, not about the paper's.

use crate::soak::SoakRow;
use bvbench::analysis::judge::Verdict;
use bvbench::record::ClaimRow;

/// Id of the claim in `paper-repro/claims.toml`.
pub const CLAIM: &str = "real-time-on-controller";
/// Largest share of late verdicts: 99.9 % are in time.
pub const LATE: f64 = 0.001;
/// With fewer verdicts a run decides nothing: by the rule of three, 0 late of 3000 bound the share by [`LATE`].
const FEWEST: u64 = 3000;

/// A row for every run over a network that neither delays nor loses.
pub fn judge(rows: &[SoakRow]) -> Vec<ClaimRow> {
    rows.iter().filter(|row| row.delay_ns == 0 && row.loss == 0.0).map(of_run).collect()
}

fn of_run(row: &SoakRow) -> ClaimRow {
    let verdicts = row.samples - row.missed.min(row.samples);
    let share = (verdicts > 0).then(|| row.late as f64 / verdicts as f64);
    let verdict = match share {
        Some(share) if verdicts >= FEWEST && share <= LATE => Verdict::Supported,
        Some(_) if verdicts >= FEWEST => Verdict::Refuted,
        _ => Verdict::Undecided,
    };
    let ms = |ns: u64| ns as f64 / 1e6;
    ClaimRow {
        scene: row.scene.clone(),
        workload: "live".to_owned(),
        measure: format!(
            "share of verdicts by {} later than {} ms, cycle {} ms",
            row.variant,
            ms(row.deadline_ns),
            ms(row.cycle_ns)
        ),
        value: share,
        note: format!(
            "{verdicts} verdicts about {} samples in {:.1} min, {} late, 99.9 % within {:.1} ms; a simulated control on the computer of the run",
            row.samples,
            row.run_ns as f64 / 60e9,
            row.late,
            ms(row.p999_ns)
        ),
        ..ClaimRow::blank(CLAIM, verdict.id())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousandth_of_the_verdicts_may_be_late() {
        let run = |samples: u64, missed: u64, late: u64, delay_ns: u64| SoakRow {
            scene: "mill-vise".to_owned(),
            variant: "aabb".to_owned(),
            cycle_ns: 4_000_000,
            delay_ns,
            loss: 0.0,
            run_ns: 60_000_000_000,
            samples,
            missed,
            p50_ns: 1,
            p99_ns: 2,
            p999_ns: 3,
            max_ns: 4,
            deadline_ns: 20_000_000,
            late,
            contact_holds: 0,
            fault_holds: 0,
            stops: 0,
            moving: 1.0,
        };
        let told = |row| judge(&[row]).pop().map(|row| (row.verdict, row.value));
        assert_eq!(told(run(5000, 1000, 4, 0)), Some(("supported".to_owned(), Some(0.001))));
        assert_eq!(told(run(5000, 1000, 5, 0)), Some(("refuted".to_owned(), Some(0.00125))));
        assert_eq!(told(run(3999, 1000, 0, 0)), Some(("undecided".to_owned(), Some(0.0))));
        assert_eq!(told(run(1000, 1000, 0, 0)), Some(("undecided".to_owned(), None)));
        assert_eq!(told(run(5000, 0, 0, 1_000_000)), None);
        let set = bvbench::analysis::claims::ClaimSet::standard();
        assert!(set.claims.iter().any(|claim| claim.id() == CLAIM));
    }
}
