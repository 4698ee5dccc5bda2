//! The verdicts. Each claim is judged for each of its readings in each scene and, where it is about queries, each stratum,
//! by the thresholds that stand in the claims file.

use super::AnalysisError;
use super::claims::{CaseRef, Claim, ClaimSet, Direction, Expectation, Reading, Role, Test, TestKind};
use super::misses::Misses;
use super::ratios::{Cases, Metric, compare};
use super::stats::{self, Interval};
use super::summary::ALL;
use super::table::Scene;
use crate::record::rows::CaseKey;
use crate::record::{ClaimRow, ExitRow, Manifest, OutlineRow, Stratum, TightnessRow, TreeRow};
use std::collections::{BTreeMap, BTreeSet};

mod presence;
mod sizes;

/// Ratios within this are called equal.
pub const EQUIVALENT: (f64, f64) = (0.95, 1.05);

/// Fewer resampled clusters than this say nothing about the spread.
pub const CLUSTERS_MIN: usize = 4;

/// What the verdicts rest on.
#[derive(Debug)]
pub struct Evidence<'a> {
    /// Timings, queries and builds by scene.
    pub scenes: &'a BTreeMap<String, Scene>,
    /// Misses.
    pub misses: &'a Misses,
    /// Trees.
    pub trees: Vec<TreeRow>,
    /// Levels of trees.
    pub tightness: Vec<TightnessRow>,
    /// Ends of separating-axis tests.
    pub exits: Vec<ExitRow>,
    /// Drawings.
    pub outlines: Vec<OutlineRow>,
    /// The run.
    pub manifest: &'a Manifest,
    /// Default policies.
    pub cases: &'a Cases,
    /// Whether anything disturbed the timings.
    pub noisy: bool,
}

/// The verdict on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// As claimed.
    Reproduces,
    /// No difference.
    Equivalent,
    /// The opposite.
    Reversed,
    /// The evidence does not decide.
    Inconclusive,
    /// Nothing was measured that could decide.
    NotJudged,
}

impl Verdict {
    /// The name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Reproduces => "reproduces",
            Self::Equivalent => "equivalent",
            Self::Reversed => "reversed",
            Self::Inconclusive => "inconclusive",
            Self::NotJudged => "not-judged",
        }
    }
}

/// What was found, before it becomes a row.
#[derive(Clone, Debug)]
struct Finding {
    stratum: &'static str,
    verdict: Verdict,
    value: Option<f64>,
    interval: Option<(f64, f64)>,
    note: Vec<String>,
}

impl Finding {
    fn not_measured(stratum: &'static str, what: &str) -> Self {
        Self { stratum, verdict: Verdict::NotJudged, value: None, interval: None, note: vec![what.to_owned()] }
    }
}

/// The two cases of a reading in one scene.
struct Judged<'a> {
    evidence: &'a Evidence<'a>,
    scene_name: &'a str,
    scene: &'a Scene,
    subject: CaseKey,
    baseline: CaseKey,
}

/// All verdicts, in the order of the claims.
///
/// # Errors
/// When a policy of the manifest or the claims is malformed.
pub fn judge(evidence: &Evidence, set: &ClaimSet) -> Result<Vec<ClaimRow>, AnalysisError> {
    let mut rows = Vec::new();
    for claim in &set.claims {
        let Some(test) = &claim.test else {
            rows.push(not_judged(claim));
            continue;
        };
        for reading in claim.readings.iter().filter_map(|id| set.reading(id.get_ref())) {
            if evidence.cases.find(&reading.subject)?.is_none() || evidence.cases.find(&reading.baseline)?.is_none() {
                rows.push(not_measured(claim, test, reading));
                continue;
            }
            for (scene_name, scene) in evidence.scenes {
                judge_reading(evidence, claim, test, reading, (scene_name, scene), &mut rows)?;
            }
        }
    }
    Ok(rows)
}

fn not_judged(claim: &Claim) -> ClaimRow {
    ClaimRow {
        claim: claim.id().to_owned(),
        reading: "-".to_owned(),
        scene: "-".to_owned(),
        stratum: "-".to_owned(),
        verdict: Verdict::NotJudged.id().to_owned(),
        measure: "-".to_owned(),
        value: None,
        low: None,
        high: None,
        missed: None,
        baseline_missed: None,
        note: claim.not_judged.clone().unwrap_or_default(),
    }
}

fn not_measured(claim: &Claim, test: &Test, reading: &Reading) -> ClaimRow {
    let CaseRef { variant: subject, .. } = &reading.subject;
    let CaseRef { variant: baseline, .. } = &reading.baseline;
    ClaimRow {
        reading: reading.id.get_ref().clone(),
        measure: measure(test, reading),
        note: format!("this run does not have both {subject} and {baseline}; name them with --variant"),
        ..not_judged(claim)
    }
}

fn judge_reading(
    evidence: &Evidence,
    claim: &Claim,
    test: &Test,
    reading: &Reading,
    (scene_name, scene): (&str, &Scene),
    rows: &mut Vec<ClaimRow>,
) -> Result<(), AnalysisError> {
    let found = (evidence.cases.find(&reading.subject)?, evidence.cases.find(&reading.baseline)?);
    let (Some(subject), Some(baseline)) = found else { return Ok(()) };
    let judged = Judged { evidence, scene_name, scene, subject, baseline };
    let (findings, misses) =
        (judged.findings(test), [&judged.subject, &judged.baseline].map(|case| judged.missed(case)));
    for mut finding in findings {
        if evidence.noisy && matches!(test.kind, TestKind::TimeRatio | TestKind::BuildRatio) {
            finding.note.push("noisy run".to_owned());
        }
        rows.push(ClaimRow {
            claim: claim.id().to_owned(),
            reading: reading.id.get_ref().clone(),
            scene: scene_name.to_owned(),
            stratum: finding.stratum.to_owned(),
            verdict: finding.verdict.id().to_owned(),
            measure: measure(test, reading),
            value: finding.value,
            low: finding.interval.map(|i| i.0),
            high: finding.interval.map(|i| i.1),
            missed: misses[0],
            baseline_missed: misses[1],
            note: finding.note.join("; "),
        });
    }
    Ok(())
}

/// What is measured, in words.
fn measure(test: &Test, reading: &Reading) -> String {
    let (subject, baseline) = (&reading.subject.variant, &reading.baseline.variant);
    let of = if test.of == Some(Role::Subject) { subject } else { baseline };
    match test.kind {
        TestKind::TimeRatio => format!("time {subject} / {baseline}"),
        TestKind::VolumeTestRatio => format!("volume tests {subject} / {baseline}"),
        TestKind::TriangleTestRatio => format!("triangle tests {subject} / {baseline}"),
        TestKind::BuildRatio => format!("build time {subject} / {baseline}"),
        TestKind::Balance => format!("child-count ratio {baseline} / {subject}"),
        TestKind::Tightness => format!("volume over hull volume {subject} / {baseline}"),
        TestKind::BytesRatio => format!("memory {subject} / {baseline}"),
        TestKind::AxisOperations => format!("operations of an overlap test of {of}"),
        TestKind::EdgeExits => format!("share of overlap tests of {of} that edges end"),
        TestKind::Misses => format!("miss rate of {of}"),
        TestKind::Overhang => format!("% corners outside {of}"),
        TestKind::Drift => format!("drift of {of}, mm"),
        TestKind::Gap => format!("gap / overhang of {of}"),
    }
}

/// The verdict on a ratio that is claimed to lie below `below`, and what to add to it.
#[must_use]
pub fn ratio_verdict(ratio: Interval, below: f64) -> (Verdict, Option<&'static str>) {
    if ratio.high < below {
        (Verdict::Reproduces, None)
    } else if ratio.low > EQUIVALENT.1 {
        (Verdict::Reversed, None)
    } else if ratio.is_within(EQUIVALENT.0, EQUIVALENT.1) {
        (Verdict::Equivalent, None)
    } else if ratio.high < EQUIVALENT.0 {
        (Verdict::Inconclusive, Some("the effect is there, but not shown to be as large as claimed"))
    } else {
        (Verdict::Inconclusive, None)
    }
}

/// The verdict on a ratio by the claim's own bound, and what to add to it.
fn decide(test: &Test, ratio: Interval) -> (Verdict, Option<&'static str>) {
    let oriented = if test.direction == Direction::Greater { ratio.reciprocal() } else { ratio };
    match test.at_most {
        Some(most) if oriented.high <= most => (Verdict::Reproduces, None),
        Some(most) if oriented.low > most => (Verdict::Reversed, None),
        Some(_) => (Verdict::Inconclusive, None),
        None => ratio_verdict(oriented, test.below.unwrap_or(EQUIVALENT.0)),
    }
}

impl Judged<'_> {
    fn findings(&self, test: &Test) -> Vec<Finding> {
        let examined = if test.of == Some(Role::Subject) { &self.subject } else { &self.baseline };
        let above = test.above.unwrap_or(0.0);
        let expected = test.expect.unwrap_or(Expectation::Present);
        match test.kind {
            TestKind::TimeRatio => self.ratios(test, Metric::Time),
            TestKind::VolumeTestRatio => self.ratios(test, Metric::VolumeTests),
            TestKind::TriangleTestRatio => self.ratios(test, Metric::TriangleTests),
            TestKind::BuildRatio => self.ratios(test, Metric::Build),
            TestKind::Balance => vec![self.balance(test)],
            TestKind::Tightness => vec![self.tightness(test)],
            TestKind::BytesRatio => vec![self.bytes(test)],
            TestKind::AxisOperations => vec![self.axis_operations(examined, test)],
            TestKind::EdgeExits => vec![self.edge_exits(examined, test)],
            TestKind::Misses => vec![self.misses(examined, above, expected)],
            TestKind::Overhang => vec![self.overhang(examined, above, expected)],
            TestKind::Drift => vec![self.drift(examined, above, expected)],
            TestKind::Gap => vec![self.gap(examined, above, expected)],
        }
    }

    fn missed(&self, case: &CaseKey) -> Option<u64> {
        self.evidence.misses.of(self.scene_name, case).map(|tally| tally.missed)
    }

    /// What to say beside a speed: which of the two cases is unsafe or was not verified.
    fn caution(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for case in [&self.subject, &self.baseline] {
            let entry = self.evidence.manifest.variants.iter().find(|entry| entry.id == case.variant);
            if entry.is_some_and(|entry| !entry.safe) {
                notes.push(format!("{} is unsafe: its speed is not that of a working method", case.variant));
            }
            if self.missed(case).is_none() {
                notes.push(format!("{} {} was not verified", case.variant, case.policy()));
            }
        }
        notes
    }

    fn ratios(&self, test: &Test, metric: Metric) -> Vec<Finding> {
        let seed = self.evidence.manifest.request.seed;
        let ratios = compare(self.scene_name, self.scene, metric, &self.subject, &self.baseline, seed);
        let together = if metric == Metric::Build { "-" } else { ALL };
        if ratios.is_empty() {
            return vec![Finding::not_measured(
                together,
                "the two cases were not measured on the same items in this run",
            )];
        }
        let asked = ratios.into_iter().filter(|ratio| test.stratum.is_none() || ratio.stratum == test.stratum);
        let findings = asked.map(|ratio| {
            let (mut verdict, remark) = decide(test, ratio.interval);
            let mut note: Vec<String> = remark.map(str::to_owned).into_iter().collect();
            if ratio.clusters < CLUSTERS_MIN {
                verdict = Verdict::Inconclusive;
                note.push(format!("only {} clusters: too few for an interval", ratio.clusters));
            }
            note.extend(self.caution());
            Finding {
                stratum: ratio.stratum.map_or(together, Stratum::id),
                verdict,
                value: Some(ratio.interval.value),
                interval: Some((ratio.interval.low, ratio.interval.high)),
                note,
            }
        });
        findings.collect()
    }

    /// The rows of one case in this scene.
    fn trees<'b>(&'b self, case: &'b CaseKey) -> impl Iterator<Item = &'b TreeRow> {
        self.evidence.trees.iter().filter(move |row| row.scene == self.scene_name && row.case() == *case)
    }

    fn levels<'b>(&'b self, case: &'b CaseKey) -> impl Iterator<Item = &'b TightnessRow> {
        let own_frame = self.evidence.tightness.iter().filter(|row| row.frame == 0);
        own_frame.filter(move |row| row.scene == self.scene_name && row.case() == *case)
    }

    /// The verdict on the geometric mean of counted ratios.
    fn mean_ratio(logs: &[f64], test: &Test, what: &str) -> Finding {
        if logs.is_empty() {
            return Finding::not_measured("-", "no trees of both cases in this run");
        }
        let ratio = Interval::exact((logs.iter().sum::<f64>() / logs.len() as f64).exp());
        let (verdict, remark) = decide(test, ratio);
        let (low, high) = logs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let range = format!("{} {what}, from {:.3} to {:.3}", logs.len(), low.exp(), high.exp());
        let note = remark.map(str::to_owned).into_iter().chain([range]).collect();
        Finding { stratum: "-", verdict, value: Some(ratio.value), interval: None, note }
    }

    fn balance(&self, test: &Test) -> Finding {
        let subject: BTreeMap<&str, f64> =
            self.trees(&self.subject).map(|row| (row.part.as_str(), row.child_ratio)).collect();
        let logs = self.trees(&self.baseline).filter_map(|row| {
            let log = (row.child_ratio / subject.get(row.part.as_str())?).ln();
            log.is_finite().then_some(log)
        });
        Self::mean_ratio(&logs.collect::<Vec<_>>(), test, "parts")
    }

    fn tightness(&self, test: &Test) -> Finding {
        let looseness = |row: &TightnessRow| row.hulled_volume_mm3 / row.hull_mm3;
        let asked = |row: &&TightnessRow| test.level.is_none_or(|level| row.level == level);
        let subject: BTreeMap<(&str, u32), f64> = self
            .levels(&self.subject)
            .filter(asked)
            .map(|row| ((row.part.as_str(), row.level), looseness(row)))
            .collect();
        let logs = self.levels(&self.baseline).filter_map(|row| {
            let log = (subject.get(&(row.part.as_str(), row.level))? / looseness(row)).ln();
            log.is_finite().then_some(log)
        });
        let mut finding = Self::mean_ratio(&logs.collect::<Vec<_>>(), test, "levels of trees");
        if !self.caution().iter().all(|note| !note.contains("unsafe")) {
            finding.note.push("an unsafe box has the volume of the tight one without holding its contents".to_owned());
        }
        finding
    }

    fn misses(&self, case: &CaseKey, above: f64, expected: Expectation) -> Finding {
        let Some(tally) = self.evidence.misses.of(self.scene_name, case) else {
            return Finding::not_measured(Stratum::Colliding.id(), "not verified in this run");
        };
        let (low, high) = stats::miss_rate(tally.missed_by_volume, tally.brute);
        let verdict = match expected {
            _ if tally.brute == 0 => Verdict::Inconclusive,
            Expectation::Present if tally.missed_by_volume > 0 => Verdict::Reproduces,
            Expectation::Absent if tally.missed_by_volume > 0 => Verdict::Reversed,
            _ if high > above => Verdict::Inconclusive,
            Expectation::Present => Verdict::Reversed,
            Expectation::Absent => Verdict::Reproduces,
        };
        let mut note =
            vec![format!("{} of {} colliding poses hidden by the volume", tally.missed_by_volume, tally.brute)];
        if tally.missed_by_leaf > 0 {
            note.push(format!("{} more missed by the triangle test itself", tally.missed_by_leaf));
        }
        Finding {
            stratum: Stratum::Colliding.id(),
            verdict,
            value: (tally.brute > 0).then(|| tally.missed_by_volume as f64 / tally.brute as f64),
            interval: Some((low, high)),
            note,
        }
    }
}

/// The names of the parts among some rows, each once.
fn names<'a>(parts: impl Iterator<Item = &'a str>) -> String {
    parts.collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(", ")
}
