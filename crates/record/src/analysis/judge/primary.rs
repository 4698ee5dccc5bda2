//! The primary row of a claim: one answer to one sentence, over all scenes that the claim covers.
//!
//! The claim is supported when it is supported in each scene (an intersection-union test: the largest p counts; Berger 1982, Technometrics
//! 24). It is refuted when it is refuted in one scene (the smallest p times the number of scenes). All primary rows that rest on samples
//! are corrected together (Holm 1979, Scandinavian Journal of Statistics 6). A scene without a verdict has p = 1, so that it leaves the claim
//! undecided unless another scene refutes it.

use super::{ALL, Candidate, Claim, ClaimRow, Expectation, PROGRAM_TIME, Test, TestKind, Verdict, not_judged};

/// Role of the row that answers a sentence; all others are `exploratory`.
pub const PRIMARY: &str = "primary";
/// A primary row with a larger p, after the correction, is undecided.
const LEVEL: f64 = 0.05;

/// A primary row before and after the correction.
pub(super) struct Primary {
    pub(super) row: ClaimRow,
    p: Option<f64>,
}

impl Primary {
    /// Makes the primary row from the rows of the claim's scenes: those of `scenes`, or all when it is empty.
    pub(super) fn of(claim: &Claim, test: &Test, reading: &str, scenes: &[String], candidates: &[Candidate]) -> Self {
        let (workload, stratum) = place(test);
        let is_asked = |row: &ClaimRow| {
            row.reading == reading
                && (scenes.is_empty() || scenes.contains(&row.scene))
                && workload.is_none_or(|workload| row.workload == workload)
                && stratum.is_none_or(|stratum| row.stratum == stratum)
        };
        let rows: Vec<&Candidate> =
            candidates.iter().filter(|c| is_asked(&c.row) && c.verdict != Verdict::NotJudged).collect();
        let of_workloads = test.kind == TestKind::Misses;
        let judged = if of_workloads { by_scene(&rows, test.expect) } else { rows.clone() };
        let Some(deciding) = deciding(&judged) else {
            let missing = candidates.iter().find(|c| c.row.reading == reading && c.verdict == Verdict::NotJudged);
            let note = missing.map_or_else(
                || format!("this run has none of its scenes with {}", workload.unwrap_or("what is asked")),
                |missing| missing.row.note.clone(),
            );
            let row = ClaimRow { role: PRIMARY.into(), reading: reading.into(), note, ..not_judged(claim) };
            return Self { row, p: None };
        };
        let found: Vec<&str> = judged.iter().map(|c| c.row.scene.as_str()).collect();
        let lacking: Vec<&str> = scenes.iter().map(String::as_str).filter(|scene| !found.contains(scene)).collect();
        let (verdict, p) = match together(&judged) {
            Verdict::Refuted => (Verdict::Refuted, deciding.p.map(|p| (p * judged.len() as f64).min(1.0))),
            verdict if lacking.is_empty() => (verdict, deciding.p.map(|p| p.min(1.0))),
            _ => (Verdict::Undecided, deciding.p.map(|_| 1.0)),
        };
        let row = ClaimRow {
            role: PRIMARY.to_owned(),
            scene: found.join("+"),
            verdict: verdict.id().to_owned(),
            note: note(&rows, deciding, &lacking, of_workloads),
            ..deciding.row.clone()
        };
        Self { row, p }
    }
}

/// The scenes that have no verdict, the verdict of each row, and the note of the deciding one.
fn note(rows: &[&Candidate], deciding: &Candidate, lacking: &[&str], of_workloads: bool) -> String {
    let place =
        |row: &ClaimRow| if of_workloads { format!("{} {}", row.scene, row.workload) } else { row.scene.clone() };
    let mut notes = Vec::new();
    if !lacking.is_empty() {
        notes.push(format!("this run has no verdict on {}", lacking.join(" and ")));
    }
    if rows.len() + lacking.len() > 1 {
        let each = rows.iter().map(|c| match c.row.value {
            Some(value) => format!("{} {} ({value:.3})", place(&c.row), c.verdict.id()),
            None => format!("{} {}", place(&c.row), c.verdict.id()),
        });
        notes.push(each.collect::<Vec<_>>().join(", "));
        notes.push(format!("numbers of {}", place(&deciding.row)));
    }
    notes.push(deciding.row.note.clone());
    notes.retain(|note| !note.is_empty());
    notes.join("; ")
}

/// Workload and stratum of a claim's primary row; `None` for a quantity that has none.
fn place(test: &Test) -> (Option<&str>, Option<&str>) {
    if !test.kind.is_about_queries() {
        return (None, None);
    }
    let stratum = test.stratum.map_or(ALL, crate::record::Stratum::id);
    let usual = match test.kind {
        TestKind::TimeRatio if test.stratum.is_none() => PROGRAM_TIME,
        _ => "program",
    };
    (Some(test.workload.as_deref().unwrap_or(usual)), Some(stratum))
}

/// For each scene, the workload that decides about misses. Misses are present in a scene when they are present in one workload, and absent
/// when they are absent in each. Of equal verdicts, the one with the largest rate; of equal rates, the first.
fn by_scene<'a>(rows: &[&'a Candidate], expected: Option<Expectation>) -> Vec<&'a Candidate> {
    use Verdict::{NotApplicable, NotJudged, Refuted, Supported, Undecided};
    let order = match expected {
        Some(Expectation::Absent) => [Refuted, Undecided, Supported, NotApplicable, NotJudged],
        _ => [Supported, Undecided, Refuted, NotApplicable, NotJudged],
    };
    let place = |c: &Candidate| order.iter().position(|verdict| *verdict == c.verdict);
    let rate = |c: &Candidate| c.row.value.unwrap_or(0.0);
    let mut deciding: Vec<&Candidate> = Vec::new();
    for &row in rows {
        match deciding.iter_mut().find(|other| other.row.scene == row.row.scene) {
            None => deciding.push(row),
            Some(other) => {
                if (place(row), -rate(row)) < (place(other), -rate(other)) {
                    *other = row;
                }
            }
        }
    }
    deciding
}

/// The verdict over several scenes.
fn together(judged: &[&Candidate]) -> Verdict {
    let all = |verdict: Verdict| judged.iter().all(|c| c.verdict == verdict);
    let applicable = || judged.iter().filter(|c| c.verdict != Verdict::NotApplicable);
    match () {
        () if all(Verdict::NotApplicable) => Verdict::NotApplicable,
        () if applicable().all(|c| c.verdict == Verdict::Supported) => Verdict::Supported,
        () if judged.iter().any(|c| c.verdict == Verdict::Refuted) => Verdict::Refuted,
        () => Verdict::Undecided,
    }
}

/// The scene that decides: the strongest refutation, otherwise the weakest support.
fn deciding<'a>(judged: &[&'a Candidate]) -> Option<&'a Candidate> {
    let p = |c: &Candidate| c.p.unwrap_or(0.0);
    let refuted = judged.iter().filter(|c| c.verdict == Verdict::Refuted).min_by(|a, b| p(a).total_cmp(&p(b)));
    let applicable = judged.iter().filter(|c| c.verdict != Verdict::NotApplicable);
    refuted.or_else(|| applicable.max_by(|a, b| p(a).total_cmp(&p(b)))).or_else(|| judged.first()).copied()
}

/// Holm's correction over the primary rows that rest on samples.
pub(super) fn correct<'a>(primaries: impl Iterator<Item = &'a mut Primary>) {
    let mut family: Vec<(f64, &mut Primary)> = primaries.filter_map(|row| Some((row.p?, row))).collect();
    family.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = family.len();
    let mut adjusted: f64 = 0.0;
    for (place, (p, primary)) in family.into_iter().enumerate() {
        adjusted = adjusted.max(((count - place) as f64 * p).min(1.0));
        primary.row.p_holm = Some(adjusted);
        let decided = [Verdict::Supported, Verdict::Refuted].map(Verdict::id).contains(&primary.row.verdict.as_str());
        if decided && adjusted > LEVEL {
            let before = std::mem::replace(&mut primary.row.verdict, Verdict::Undecided.id().to_owned());
            primary.row.note = format!("{before} before Holm's correction; {}", primary.row.note);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::claims::ClaimSet;

    fn primary(verdict: Verdict, p: f64) -> Primary {
        let claim = &ClaimSet::standard().claims[0];
        let row = ClaimRow { verdict: verdict.id().to_owned(), ..not_judged(claim) };
        Primary { row, p: Some(p) }
    }

    /// For 0.01, 0.02, 0.03: 3 × 0.01 = 0.03 passes, 2 × 0.02 = 0.04 passes, and 0.03 is raised to 0.04 and passes. For 0.02 and 0.03
    /// alone: 2 × 0.03 fails, and then 0.03 raised to it fails.
    #[test]
    fn holm_by_hand() {
        let mut rows = [0.03, 0.01, 0.02].map(|p| primary(Verdict::Supported, p));
        correct(rows.iter_mut());
        assert_eq!(rows.each_ref().map(|row| row.row.p_holm.unwrap()), [0.04, 0.03, 0.04]);
        assert!(rows.iter().all(|row| row.row.verdict == "supported"));
        let mut rows = [0.03, 0.04].map(|p| primary(Verdict::Refuted, p));
        correct(rows.iter_mut());
        assert!(rows.iter().all(|row| row.row.verdict == "undecided" && row.row.note.contains("refuted before Holm")));
    }

    /// A miss in one workload is a miss; that none is missed has to be shown in every workload.
    #[test]
    fn misses_are_present_in_one_workload_and_absent_in_all() {
        let candidate = |scene: &str, workload: &str, verdict: Verdict, value| {
            let (scene, workload) = (scene.to_owned(), workload.to_owned());
            let row = ClaimRow { scene, workload, value: Some(value), ..primary(verdict, 0.0).row };
            Candidate { row, verdict, p: None }
        };
        let names = |rows: &[Candidate], expected| {
            let of = by_scene(&rows.iter().collect::<Vec<_>>(), Some(expected));
            of.iter().map(|c| (c.row.workload.clone(), c.verdict)).collect::<Vec<_>>()
        };
        let there = [
            candidate("a", "approach", Verdict::Supported, 0.1),
            candidate("a", "program", Verdict::Undecided, 0.0),
            candidate("a", "random", Verdict::Supported, 0.3),
            candidate("b", "program", Verdict::Undecided, 0.0),
        ];
        let expected = [("random".to_owned(), Verdict::Supported), ("program".to_owned(), Verdict::Undecided)];
        assert_eq!(names(&there, Expectation::Present), expected);
        let absent = [
            candidate("a", "approach", Verdict::Supported, 0.0),
            candidate("a", "program", Verdict::Undecided, 0.0),
            candidate("b", "approach", Verdict::Refuted, 0.2),
            candidate("b", "program", Verdict::NotApplicable, 0.0),
        ];
        let expected = [("program".to_owned(), Verdict::Undecided), ("approach".to_owned(), Verdict::Refuted)];
        assert_eq!(names(&absent, Expectation::Absent), expected);
    }

    #[test]
    fn a_sentence_about_two_scenes_must_hold_in_both() {
        let candidate = |verdict: Verdict, p| Candidate { row: primary(verdict, p).row, verdict, p: Some(p) };
        let (yes, no, open) = (
            candidate(Verdict::Supported, 0.01),
            candidate(Verdict::Refuted, 0.001),
            candidate(Verdict::Undecided, 0.4),
        );
        let idle = candidate(Verdict::NotApplicable, 0.0);
        assert_eq!(together(&[&yes, &yes]), Verdict::Supported);
        assert_eq!(together(&[&yes, &no]), Verdict::Refuted);
        assert_eq!(together(&[&yes, &open]), Verdict::Undecided);
        assert_eq!(together(&[&idle, &yes]), Verdict::Supported);
        assert_eq!(together(&[&idle, &idle]), Verdict::NotApplicable);
        assert_eq!(deciding(&[&yes, &open]).unwrap().p, Some(0.4));
        assert_eq!(deciding(&[&yes, &no]).unwrap().p, Some(0.001));
    }

    #[test]
    fn one_scene_of_two_refutes_a_sentence_but_does_not_support_it() {
        use Verdict::{NotApplicable, NotJudged, Refuted, Supported, Undecided};
        let set = ClaimSet::standard();
        let (claim, both) = (&set.claims[0], ["a", "b"].map(str::to_owned));
        let test = claim.test.as_ref().unwrap();
        let candidate = |&(scene, verdict, p): &(&str, Verdict, f64)| {
            let (workload, stratum) = (PROGRAM_TIME.to_owned(), ALL.to_owned());
            let row =
                ClaimRow { reading: "R1".into(), scene: scene.into(), workload, stratum, ..primary(verdict, p).row };
            Candidate { row, verdict, p: Some(p) }
        };
        type Rows = [(&'static str, Verdict, f64)];
        let cases: [(&[String], &Rows, Verdict, f64); 7] = [
            (&both, &[("a", Supported, 0.01), ("b", Supported, 0.02)], Supported, 0.02),
            (&both, &[("a", Supported, 0.01)], Undecided, 1.0),
            (&both, &[("a", Supported, 0.01), ("b", NotJudged, 0.0)], Undecided, 1.0),
            (&both, &[("b", NotApplicable, 0.0)], Undecided, 1.0),
            (&both, &[("a", Undecided, 0.3), ("other", Supported, 0.01)], Undecided, 1.0),
            (&both, &[("a", Refuted, 0.01)], Refuted, 0.01),
            (&[], &[("a", Supported, 0.01)], Supported, 0.01),
        ];
        for (scenes, rows, verdict, p) in cases {
            let candidates: Vec<Candidate> = rows.iter().map(candidate).collect();
            let found = Primary::of(claim, test, "R1", scenes, &candidates);
            assert_eq!((found.row.verdict.as_str(), found.p), (verdict.id(), Some(p)), "{scenes:?} {rows:?}");
            assert!(
                verdict != Undecided || found.row.note.contains("this run has no verdict on"),
                "{}",
                found.row.note
            );
        }
    }
}
