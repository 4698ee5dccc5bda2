//! Verdicts on the claims. Each claim is judged for each of its readings, in each scene and, if it is about queries, in each workload, by
//! the thresholds of the claims file. One primary row, which the file declares, answers the sentence as a whole; see `primary`.

use super::claims::{CaseRef, Claim, ClaimSet, Direction, Expectation, Frames, Reading, Role, Test, TestKind};
use super::misses::{Misses, Tally};
use super::ratios::{Cases, Metric, NoisyCells, Ratio, compare};
use super::stats::{Interval, mean};
use super::summary::ALL;
use super::table::Scene;
use super::totals::{Estimate, over_launches};
use super::{AnalysisError, counted, grouped};
use crate::record::rows::CaseKey;
use crate::record::vocabulary::named;
use crate::record::{ClaimRow, ExitRow, Manifest, OutlineRow, PROGRAM_TIME, Stratum, TightnessRow, TreeRow};
use std::collections::{BTreeMap, BTreeSet};

mod presence;
mod primary;
mod sizes;

/// Ratios within this interval are called the same.
pub const SAME: (f64, f64) = (0.95, 1.05);

/// Fewest resampled clusters from which a spread is estimated.
pub const CLUSTERS_MIN: usize = 4;

/// The records that the verdicts are derived from.
#[derive(Debug)]
pub struct Evidence<'a> {
    /// Poses, timings, answers and builds by scene.
    pub scenes: &'a BTreeMap<String, Scene>,
    /// Misses.
    pub misses: &'a Misses,
    /// Trees.
    pub trees: Vec<TreeRow>,
    /// Levels of trees.
    pub tightness: Vec<TightnessRow>,
    /// Where separating-axis tests end.
    pub exits: Vec<ExitRow>,
    /// Drawings.
    pub outlines: Vec<OutlineRow>,
    /// The run.
    pub manifest: &'a Manifest,
    /// Default policies.
    pub cases: &'a Cases,
    /// Cells in which the null duplicate is noisy.
    pub noisy: NoisyCells,
}

named! {
    /// The verdict on a claim.
    pub enum Verdict {
        /// The whole interval is beyond the claim's threshold.
        Supported = "supported",
        /// The whole interval is at or beyond 1 on the other side, or on the other side of a margin that the sentence names.
        Refuted = "refuted",
        /// The evidence does not decide.
        Undecided = "undecided",
        /// The baseline has no defect that the subject could repair.
        NotApplicable = "not-applicable",
        /// No measurement can decide the claim.
        NotJudged = "not-judged",
    }
}

named! {
    /// The direction of a ratio, independent of any claim.
    pub enum Effect {
        /// The whole interval is below 1, and part of it is below 0.95.
        Less = "less",
        /// The whole interval is within 5 % of 1.
        Same = "same",
        /// The whole interval is above 1, and part of it is above 1.05.
        More = "more",
        /// The interval is in none of these places.
        Unclear = "unclear",
    }
}

impl Effect {
    /// The effect that an interval shows.
    pub fn of(interval: Interval) -> Self {
        match () {
            () if interval.is_within(SAME.0, SAME.1) => Self::Same,
            () if interval.high < 1.0 => Self::Less,
            () if interval.low > 1.0 => Self::More,
            () => Self::Unclear,
        }
    }
}

/// The result of one test, before it becomes a row.
#[derive(Clone, Debug)]
struct Finding {
    workload: String,
    stratum: String,
    verdict: Verdict,
    effect: Option<Effect>,
    value: Option<f64>,
    interval: Option<(f64, f64)>,
    /// For ratios that were sampled: the probability of the data if the true ratio were at the threshold.
    p: Option<f64>,
    note: Vec<String>,
}

impl Finding {
    /// A finding about the trees or drawings of a scene, without an interval.
    fn of_trees(verdict: Verdict, value: Option<f64>, note: Vec<String>) -> Self {
        let (workload, stratum) = ("-".to_owned(), "-".to_owned());
        Self { workload, stratum, verdict, effect: None, value, interval: None, p: None, note }
    }

    fn not_measured(what: &str) -> Self {
        Self::of_trees(Verdict::NotJudged, None, vec![what.to_owned()])
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

/// A row, with the values that decide the primary row.
#[derive(Clone, Debug)]
struct Candidate {
    row: ClaimRow,
    verdict: Verdict,
    p: Option<f64>,
}

/// All verdicts, in the order of the claims; the primary row of each claim comes first.
///
/// # Errors
/// When a policy of the manifest or the claims is malformed.
pub fn judge(evidence: &Evidence, set: &ClaimSet) -> Result<Vec<ClaimRow>, AnalysisError> {
    let mut judged: Vec<(Option<primary::Primary>, Vec<ClaimRow>)> = Vec::new();
    // A run that has none of the scenes is about its own.
    let named = &set.comparison.scenes;
    let scenes = if named.iter().any(|name| evidence.scenes.contains_key(name)) { &named[..] } else { &[] };
    for claim in &set.claims {
        let Some(test) = &claim.test else {
            judged.push((None, vec![ClaimRow { role: primary::PRIMARY.to_owned(), ..not_judged(claim) }]));
            continue;
        };
        let mut candidates = Vec::new();
        for reading in claim.readings.iter().filter_map(|id| set.reading(id.get_ref())) {
            if evidence.cases.find(&reading.subject)?.is_none() || evidence.cases.find(&reading.baseline)?.is_none() {
                let row = not_measured(claim, test, reading);
                candidates.push(Candidate { row, verdict: Verdict::NotJudged, p: None });
                continue;
            }
            for (scene_name, scene) in evidence.scenes {
                judge_reading(evidence, claim, test, reading, (scene_name, scene), &mut candidates)?;
            }
        }
        let primary = claim
            .primary
            .as_ref()
            .map(|reading| primary::Primary::of(claim, test, reading.get_ref(), scenes, &candidates));
        judged.push((primary, candidates.into_iter().map(|candidate| candidate.row).collect()));
    }
    primary::correct(judged.iter_mut().filter_map(|(primary, _)| primary.as_mut()));
    let rows =
        judged.into_iter().flat_map(|(primary, rows)| primary.map(|primary| primary.row).into_iter().chain(rows));
    Ok(rows.collect())
}

fn not_judged(claim: &Claim) -> ClaimRow {
    ClaimRow {
        note: claim.not_judged.clone().unwrap_or_default(),
        ..ClaimRow::blank(claim.id(), Verdict::NotJudged.id())
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
    candidates: &mut Vec<Candidate>,
) -> Result<(), AnalysisError> {
    let found = (evidence.cases.find(&reading.subject)?, evidence.cases.find(&reading.baseline)?);
    let (Some(subject), Some(baseline)) = found else { return Ok(()) };
    let judged = Judged { evidence, scene_name, scene, subject, baseline };
    let (findings, misses) =
        (judged.findings(test), [&judged.subject, &judged.baseline].map(|case| judged.missed(case)));
    for finding in findings {
        let row = ClaimRow {
            reading: reading.id.get_ref().clone(),
            scene: scene_name.to_owned(),
            workload: finding.workload,
            stratum: finding.stratum,
            verdict: finding.verdict.id().to_owned(),
            effect: finding.effect.map_or("-", Effect::id).to_owned(),
            measure: measure(test, reading),
            value: finding.value,
            low: finding.interval.map(|i| i.0),
            high: finding.interval.map(|i| i.1),
            missed: misses[0],
            baseline_missed: misses[1],
            note: finding.note.join("; "),
            ..not_judged(claim)
        };
        candidates.push(Candidate { row, verdict: finding.verdict, p: finding.p });
    }
    Ok(())
}

/// The measured quantity in words.
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

/// The verdict on a ratio that is claimed to lie below `below`. A sentence that names a margin is refuted by a smaller effect; one that says
/// only `less` is refuted by a ratio of 1 or more.
pub fn ratio_verdict(ratio: Interval, below: f64, names_margin: bool) -> Verdict {
    if ratio.high < below {
        Verdict::Supported
    } else if ratio.low >= refuted_from(below, names_margin) {
        Verdict::Refuted
    } else {
        Verdict::Undecided
    }
}

/// The ratio from which on a claim of a ratio below `below` is refuted.
pub const fn refuted_from(below: f64, names_margin: bool) -> f64 {
    if names_margin { below } else { 1.0 }
}

/// The threshold of the test. It applies to the ratio after [`oriented`].
fn threshold(test: &Test) -> f64 {
    test.at_most.or(test.below).unwrap_or(SAME.0)
}

/// The ratio in the direction of the claim: inverted when the subject is claimed to need more.
fn oriented(test: &Test, estimate: Estimate) -> Estimate {
    if test.direction == Direction::Greater { estimate.reciprocal() } else { estimate }
}

/// The verdict on a ratio by the thresholds of the claim.
fn decide(test: &Test, estimate: Estimate) -> Verdict {
    let ratio = oriented(test, estimate).interval;
    match test.at_most {
        Some(most) if ratio.high <= most => Verdict::Supported,
        Some(most) if ratio.low > most => Verdict::Refuted,
        Some(_) => Verdict::Undecided,
        None => ratio_verdict(ratio, threshold(test), test.names_margin),
    }
}

/// Probability of the data if the true ratio were at the bound that the verdict is about: the one that refutes, for a refutation.
fn p_value(test: &Test, estimate: Estimate, verdict: Verdict) -> f64 {
    let bound = match verdict {
        Verdict::Refuted if test.at_most.is_none() => refuted_from(threshold(test), test.names_margin),
        _ => threshold(test),
    };
    oriented(test, estimate).p_value(bound)
}

impl Judged<'_> {
    fn findings(&self, test: &Test) -> Vec<Finding> {
        let Self { subject, baseline, .. } = self;
        let examined = if test.of == Some(Role::Subject) { subject } else { baseline };
        let above = test.above.unwrap_or(0.0);
        let expected = test.expect.unwrap_or(Expectation::Present);
        match test.kind {
            TestKind::TimeRatio => self.ratios(test, &[Metric::ProgramTime, Metric::Time]),
            TestKind::VolumeTestRatio => self.ratios(test, &[Metric::VolumeTests]),
            TestKind::TriangleTestRatio => self.ratios(test, &[Metric::TriangleTests]),
            TestKind::BuildRatio => self.ratios(test, &[Metric::Build]),
            TestKind::Balance => vec![self.over_parts(test, [baseline, subject], |row| row.child_ratio)],
            TestKind::Tightness => vec![self.tightness(test)],
            TestKind::BytesRatio => vec![self.over_parts(test, [subject, baseline], |row| row.bytes as f64)],
            TestKind::AxisOperations => vec![self.axis_operations(examined, test)],
            TestKind::EdgeExits => vec![self.edge_exits(examined, test)],
            TestKind::Misses => self.misses_by_workload(test, examined, above, expected),
            TestKind::Overhang | TestKind::Drift | TestKind::Gap => {
                vec![self.presence(test, examined, above, expected)]
            }
        }
    }

    fn presence(&self, test: &Test, case: &CaseKey, above: f64, expected: Expectation) -> Finding {
        let found = |case: &CaseKey, expected| match test.kind {
            TestKind::Overhang => self.overhang(case, above, expected),
            TestKind::Drift => self.drift(case, above, expected),
            _ => self.gap(case, above, expected),
        };
        let mut finding = found(case, expected);
        if repairs(test, expected) && finding.verdict != Verdict::NotJudged {
            let is_there = match test.kind {
                TestKind::Drift => self.drifts_to_the_dense_side(&self.baseline, above),
                _ => found(&self.baseline, Expectation::Present).verdict != Verdict::Refuted,
            };
            if !is_there {
                self.has_nothing_to_repair(&mut finding);
            }
        }
        finding
    }

    /// Turns a finding about a repair into one about nothing that could be repaired.
    fn has_nothing_to_repair(&self, finding: &mut Finding) {
        finding.verdict = Verdict::NotApplicable;
        finding.note.insert(0, format!("{} has no such fault here", self.baseline.variant));
    }

    fn missed(&self, case: &CaseKey) -> Option<u64> {
        self.evidence.misses.missed(self.scene_name, case)
    }

    /// Notes to show beside a time: which of the two cases is unsafe or was not verified.
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

    fn ratios(&self, test: &Test, metrics: &[Metric]) -> Vec<Finding> {
        let seed = self.evidence.manifest.request.seed;
        let all = metrics.iter().flat_map(|&metric| {
            let ratios = compare(self.scene, metric, &self.subject, &self.baseline, seed);
            ratios.into_iter().map(move |ratio| (metric, ratio))
        });
        let asked = |ratio: &Ratio| match test.stratum {
            None => ratio.is_whole(),
            Some(stratum) => ratio.stratum == stratum.id(),
        };
        let findings: Vec<Finding> =
            all.filter(|(_, ratio)| asked(ratio)).map(|(metric, ratio)| self.ratio(test, metric, &ratio)).collect();
        if findings.is_empty() {
            return vec![Finding::not_measured("the two cases were not measured on the same items in this run")];
        }
        findings
    }

    fn ratio(&self, test: &Test, metric: Metric, ratio: &Ratio) -> Finding {
        let interval = ratio.estimate.interval;
        let (mut verdict, mut effect) = (decide(test, ratio.estimate), Effect::of(interval));
        let mut p = Some(p_value(test, ratio.estimate, verdict));
        let mut note = Vec::new();
        let mut doubt = |why: String| {
            (verdict, p) = (Verdict::Undecided, Some(1.0));
            note.push(why);
        };
        if ratio.has_few_clusters() {
            effect = Effect::Unclear;
            let unit = if metric == Metric::ProgramTime { "launches" } else { "clusters" };
            doubt(format!("only {}: too few for an interval", counted(ratio.estimate.clusters, unit)));
        }
        if matches!(metric, Metric::ProgramTime | Metric::Time)
            && let Some(null) = self.evidence.noisy.get(self.scene_name, &ratio.workload, &ratio.stratum)
        {
            effect = Effect::Unclear;
            doubt(format!("noisy: the null duplicate takes {null}"));
        }
        if !self.evidence.manifest.noise.is_empty() && metric != Metric::VolumeTests && metric != Metric::TriangleTests
        {
            note.push("other processes were at work during the run".to_owned());
        }
        note.extend(self.caution());
        Finding {
            workload: ratio.workload.clone(),
            stratum: ratio.stratum.clone(),
            verdict,
            effect: Some(effect),
            value: Some(interval.value),
            interval: (ratio.estimate.clusters != 1).then_some((interval.low, interval.high)),
            p,
            note,
        }
    }

    /// The rows of one case's trees in this scene.
    fn trees<'b>(&'b self, case: &'b CaseKey) -> impl Iterator<Item = &'b TreeRow> {
        self.evidence.trees.iter().filter(move |row| row.scene == self.scene_name && row.case() == *case)
    }

    fn levels<'b>(&'b self, case: &'b CaseKey) -> impl Iterator<Item = &'b TightnessRow> {
        self.levels_in(case, Frames::Own)
    }

    fn levels_in<'b>(&'b self, case: &'b CaseKey, frames: Frames) -> impl Iterator<Item = &'b TightnessRow> {
        let in_frame = self.evidence.tightness.iter().filter(move |row| (row.frame == 0) == (frames == Frames::Own));
        in_frame.filter(move |row| row.scene == self.scene_name && row.case() == *case)
    }

    /// The verdict on the geometric mean of counted ratios.
    fn mean_ratio(logs: &[f64], test: &Test, what: &str) -> Finding {
        if logs.is_empty() {
            return Finding::not_measured("no trees of both cases in this run");
        }
        let ratio = Estimate::exact(mean(logs).exp());
        let (low, high) = logs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let range = format!("{} {what}, from {:.3} to {:.3}", logs.len(), low.exp(), high.exp());
        let effect = Some(Effect::of(ratio.interval));
        Finding { effect, ..Finding::of_trees(decide(test, ratio), Some(ratio.interval.value), vec![range]) }
    }

    /// The ratio of a property of the trees of two cases, over the parts.
    fn over_parts(&self, test: &Test, [above, below]: [&CaseKey; 2], property: fn(&TreeRow) -> f64) -> Finding {
        let below: BTreeMap<&str, f64> = self.trees(below).map(|row| (row.part.as_str(), property(row))).collect();
        let logs = self.trees(above).filter_map(|row| {
            let log = (property(row) / below.get(row.part.as_str())?).ln();
            log.is_finite().then_some(log)
        });
        Self::mean_ratio(&logs.collect::<Vec<_>>(), test, "parts")
    }

    fn tightness(&self, test: &Test) -> Finding {
        let looseness = |row: &TightnessRow| row.hulled_volume_mm3 / row.hull_mm3;
        let asked = |row: &&TightnessRow| test.level.is_none_or(|level| row.level == level);
        let key = |row: &TightnessRow| (row.frame, row.part.clone(), row.level);
        let subject: BTreeMap<_, f64> =
            self.levels_in(&self.subject, test.frames).filter(asked).map(|row| (key(row), looseness(row))).collect();
        let frames = grouped(self.levels_in(&self.baseline, test.frames).filter_map(|row| {
            let log = (subject.get(&key(row))? / looseness(row)).ln();
            log.is_finite().then_some((row.frame, log))
        }));
        let mut finding = match test.frames {
            Frames::Own => {
                Self::mean_ratio(&frames.into_values().flatten().collect::<Vec<_>>(), test, "levels of trees")
            }
            Frames::Random => Self::over_frames(&frames, test),
        };
        if !self.caution().iter().all(|note| !note.contains("unsafe")) {
            finding.note.push("an unsafe box has the volume of the tight one without holding its contents".to_owned());
        }
        finding
    }

    /// The verdict on the geometric mean over parts and levels, measured in frames drawn at random.
    fn over_frames(frames: &BTreeMap<u32, Vec<f64>>, test: &Test) -> Finding {
        let ratios: Vec<f64> = frames.values().map(|logs| mean(logs).exp()).collect();
        let logs = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
        let Some(mut estimate) = over_launches(&ratios.iter().map(|ratio| (*ratio, 1.0)).collect::<Vec<_>>()) else {
            return Finding::not_measured("no trees of both cases over turned parts in this run");
        };
        // Of ratios the geometric mean, not that of totals.
        let shift = logs.exp() / estimate.interval.value;
        estimate.interval = estimate.interval.map(|x| x * shift);
        let mut note = vec![format!("{} random frames", ratios.len())];
        let mut verdict = decide(test, estimate);
        let mut p = p_value(test, estimate, verdict);
        if ratios.len() < CLUSTERS_MIN {
            (verdict, p) = (Verdict::Undecided, 1.0);
            note.push("too few for an interval".to_owned());
        }
        Finding {
            effect: Some(Effect::of(estimate.interval)),
            interval: Some((estimate.interval.low, estimate.interval.high)),
            p: Some(p),
            ..Finding::of_trees(verdict, Some(estimate.interval.value), note)
        }
    }

    /// One finding for each workload: its lines hold other numbers of contacts than those of the others.
    fn misses_by_workload(&self, test: &Test, case: &CaseKey, above: f64, expected: Expectation) -> Vec<Finding> {
        let Some(workloads) = self.evidence.misses.of(self.scene_name, case) else {
            return vec![Finding::not_measured("not verified in this run")];
        };
        let each = workloads.iter().map(|(workload, tally)| {
            let mut finding = Self::misses(workload, tally, above, expected);
            let fault = self.evidence.misses.in_workload(self.scene_name, &self.baseline, workload);
            if repairs(test, expected) && fault.missed() == 0 {
                self.has_nothing_to_repair(&mut finding);
            }
            finding
        });
        each.collect()
    }

    fn misses(workload: &str, tally: &Tally, above: f64, expected: Expectation) -> Finding {
        let (contacts, missed) = (tally.contacts(), tally.missed());
        let (low, high) = tally.interval();
        let verdict = match expected {
            _ if contacts == 0 => Verdict::Undecided,
            Expectation::Present if missed > 0 => Verdict::Supported,
            Expectation::Absent if missed > 0 => Verdict::Refuted,
            _ if high > above => Verdict::Undecided,
            Expectation::Present => Verdict::Refuted,
            Expectation::Absent => Verdict::Supported,
        };
        let note = vec![
            format!("{missed} of {contacts} contacts asked directly, on {} lines", tally.lines.len()),
            format!("{} of {} with the answers by witness", tally.missed_in_all, tally.contacts_in_all),
        ];
        let value = (contacts > 0).then(|| missed as f64 / contacts as f64);
        Finding {
            stratum: Stratum::Colliding.id().to_owned(),
            workload: workload.to_owned(),
            interval: Some((low, high)),
            ..Finding::of_trees(verdict, value, note)
        }
    }
}

/// Whether the claim says that the subject repairs a fault of the baseline: the fault has to be there before it can be mended.
fn repairs(test: &Test, expected: Expectation) -> bool {
    expected == Expectation::Absent && test.of == Some(Role::Subject)
}

/// Joins the names of the given parts, each name once.
fn names<'a>(parts: impl Iterator<Item = &'a str>) -> String {
    parts.collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(", ")
}
