//! The thesis's claims, judged by an ablation: by counts, which do not depend on the machine, and by time.

use super::AnalysisError;
use super::claims::ClaimSet;
use super::judge::{Effect, Verdict, ratio_verdict};
use super::stats::{Interval, bootstrap_mean, miss_rate};
use super::summary::ALL;
use crate::record::{AblationKindRow, AblationRow, AblationTimeRow, ClaimRow, read_rows, write_rows};
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

/// The sweep whose forms the claims compare.
pub const PARTS: &str = "parts";

/// One sentence of the thesis, and how it is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThesisClaim {
    /// Short name.
    pub id: Spanned<String>,
    /// The sentence, paraphrased.
    pub sentence: String,
    /// Where it stands.
    pub source: String,
    /// How it is judged.
    pub test: ThesisTest,
}

/// How a sentence of the thesis is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, tag = "kind", rename_all = "kebab-case")]
pub enum ThesisTest {
    /// Two forms of the method compared.
    Ratio {
        /// What is proposed.
        subject: FormRef,
        /// What it is held against.
        baseline: FormRef,
        /// The poses over which counts are added up.
        #[serde(default)]
        poses: Poses,
        /// What is compared, one verdict each.
        measures: Vec<Measure>,
        /// The claimed effect is there when the whole interval is below this.
        below: f64,
    },
    /// Both kinds of interference are found wherever the meshes touch.
    Found,
}

/// A form of the method by name.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FormRef {
    /// `points`, `leaves` or `octree`.
    pub search: String,
    /// `none`, `profile4`, `axial4` or `quad4`.
    #[serde(default = "none")]
    pub second_level: String,
    /// Whether the last colliding leaf is asked first.
    #[serde(default)]
    pub coherence: bool,
    /// Whether the tool is widened by the covering radius.
    #[serde(default)]
    pub safe: bool,
}

fn none() -> String {
    "none".to_owned()
}

/// Poses over which counts are added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Poses {
    /// All.
    #[default]
    All,
    /// Those that the method calls interfering.
    Hit,
    /// The others.
    Free,
}

impl Poses {
    const fn name(self) -> &'static str {
        match self {
            Self::All => ALL,
            Self::Hit => "hit",
            Self::Free => "free",
        }
    }

    const fn holds(self, hit: u8) -> bool {
        match self {
            Self::All => true,
            Self::Hit => hit == 1,
            Self::Free => hit == 0,
        }
    }
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Tests of octants against boxes, both levels.
    BoxTests,
    /// Points held against profiles.
    PointTests,
    /// Time over all poses.
    Time,
}

impl Measure {
    const fn name(self) -> &'static str {
        match self {
            Self::BoxTests => "box tests",
            Self::PointTests => "point tests",
            Self::Time => "time",
        }
    }
}

impl FormRef {
    fn is(&self, search: &str, second_level: &str, coherence: u8, safe: u8) -> bool {
        (search, second_level) == (&self.search, &self.second_level)
            && (coherence, safe) == (u8::from(self.coherence), u8::from(self.safe))
    }

    fn describe(&self) -> String {
        let level = if self.second_level == "none" { String::new() } else { format!(" + {}", self.second_level) };
        format!("{}{level}{}", self.search, if self.coherence { " + coherence" } else { "" })
    }
}

/// Judges the ablation in `folder` and writes `claims.csv` there.
///
/// # Errors
/// When a record is missing or malformed, or cannot be written.
pub fn analyze_ablation(folder: &Path, set: &ClaimSet, seed: u64) -> Result<Vec<ClaimRow>, AnalysisError> {
    let evidence = Evidence { rows: read_rows(folder)?, kinds: read_rows(folder)?, times: read_rows(folder)?, seed };
    let rows: Vec<ClaimRow> = set.thesis.iter().flat_map(|claim| evidence.judge(claim)).collect();
    write_rows(folder, &rows)?;
    Ok(rows)
}

struct Evidence {
    rows: Vec<AblationRow>,
    kinds: Vec<AblationKindRow>,
    times: Vec<AblationTimeRow>,
    seed: u64,
}

impl Evidence {
    fn judge(&self, claim: &ThesisClaim) -> Vec<ClaimRow> {
        match &claim.test {
            ThesisTest::Found => self.found(claim),
            ThesisTest::Ratio { subject, baseline, poses, measures, below } => measures
                .iter()
                .flat_map(|&measure| {
                    // Times are of all poses together.
                    let poses = if measure == Measure::Time { Poses::All } else { *poses };
                    let text = format!("{} {} / {}", measure.name(), subject.describe(), baseline.describe());
                    let ratios = self.ratios([subject, baseline], measure, poses, claim.id.get_ref());
                    ratios.into_iter().map(move |(surface, ratio)| ClaimRow {
                        stratum: poses.name().to_owned(),
                        verdict: ratio_verdict(ratio, *below).id().to_owned(),
                        effect: Effect::of(ratio).id().to_owned(),
                        measure: text.clone(),
                        value: Some(ratio.value),
                        low: Some(ratio.low),
                        high: Some(ratio.high),
                        ..empty(claim, &surface)
                    })
                })
                .collect(),
        }
    }

    fn surfaces(&self) -> Vec<&str> {
        let mut surfaces: Vec<&str> = Vec::new();
        for row in self.rows.iter().filter(|row| row.sweep == PARTS) {
            if !surfaces.contains(&row.surface.as_str()) {
                surfaces.push(&row.surface);
            }
        }
        surfaces
    }

    /// The ratio of two forms on each surface, and their geometric mean with an interval over surfaces (and rounds, of times). Counts of one
    /// surface have no interval. Surfaces on which the baseline needs nothing, or the subject, say nothing.
    fn ratios(&self, forms: [&FormRef; 2], measure: Measure, poses: Poses, purpose: &str) -> Vec<(String, Interval)> {
        let logs_of = |surface: &str| -> Vec<f64> {
            let ratios: Vec<f64> = if measure == Measure::Time {
                let rounds = |form: &FormRef| {
                    let of_form = self.times.iter().filter(|row| {
                        (row.sweep.as_str(), row.surface.as_str()) == (PARTS, surface)
                            && form.is(&row.search, &row.second_level, row.coherence, row.safe)
                    });
                    of_form.map(|row| row.ns as f64).collect::<Vec<_>>()
                };
                rounds(forms[0]).iter().zip(rounds(forms[1])).map(|(subject, baseline)| subject / baseline).collect()
            } else {
                let total = |form: &FormRef| {
                    let of_form = self.rows.iter().filter(|row| {
                        (row.sweep.as_str(), row.surface.as_str()) == (PARTS, surface)
                            && poses.holds(row.hit)
                            && form.is(&row.search, &row.second_level, row.coherence, row.safe)
                    });
                    let count = |row: &AblationRow| match measure {
                        Measure::BoxTests => row.first_level + row.second_level_tests,
                        Measure::PointTests | Measure::Time => row.point_tests,
                    };
                    of_form.map(count).sum::<u64>() as f64
                };
                vec![total(forms[0]) / total(forms[1])]
            };
            ratios.into_iter().map(f64::ln).filter(|log| log.is_finite()).collect()
        };
        let surfaces = self.surfaces();
        let observed: Vec<(&str, Vec<f64>)> = surfaces.into_iter().map(|surface| (surface, logs_of(surface))).collect();
        let observed: Vec<_> = observed.into_iter().filter(|(_, logs)| !logs.is_empty()).collect();
        let mean = |values: &[f64], purpose: &str| bootstrap_mean(values, self.seed, purpose).map(f64::exp);
        let mut found: Vec<(String, Interval)> =
            observed.iter().map(|(surface, logs)| ((*surface).to_owned(), mean(logs, purpose))).collect();
        if observed.len() > 1 {
            let means: Vec<f64> =
                observed.iter().map(|(_, logs)| logs.iter().sum::<f64>() / logs.len() as f64).collect();
            found.push((ALL.to_owned(), mean(&means, purpose)));
        }
        found
    }

    fn found(&self, claim: &ThesisClaim) -> Vec<ClaimRow> {
        let mut rows = Vec::new();
        for kind in ["local", "global"] {
            let sum = |part: fn(&AblationKindRow) -> u64| {
                self.kinds.iter().filter(|row| row.kind == kind && row.safe == 1).map(part).sum::<u64>()
            };
            let (touching, missed, found) = (sum(|row| row.touching), sum(|row| row.missed), sum(|row| row.found));
            let (low, high) = miss_rate(missed, touching);
            let verdict = match (touching, missed) {
                (0, _) => Verdict::NotJudged,
                (_, 0) => Verdict::Supported,
                _ => Verdict::Refuted,
            };
            rows.push(ClaimRow {
                stratum: kind.to_owned(),
                verdict: verdict.id().to_owned(),
                measure: "share of contacts of the meshes that is missed".to_owned(),
                value: (touching > 0).then(|| missed as f64 / touching as f64),
                low: Some(low),
                high: Some(high),
                missed: Some(missed),
                note: format!("{missed} of {touching} poses with {kind} contact missed; said of {found}"),
                ..empty(claim, ALL)
            });
        }
        rows
    }
}

fn empty(claim: &ThesisClaim, surface: &str) -> ClaimRow {
    ClaimRow {
        claim: claim.id.get_ref().clone(),
        role: "exploratory".to_owned(),
        reading: "-".to_owned(),
        scene: surface.to_owned(),
        workload: "-".to_owned(),
        stratum: "-".to_owned(),
        verdict: Verdict::NotJudged.id().to_owned(),
        effect: "-".to_owned(),
        p_holm: None,
        measure: String::new(),
        value: None,
        low: None,
        high: None,
        missed: None,
        baseline_missed: None,
        note: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(surface: &str, search: &str, hit: u8, boxes: u64) -> AblationRow {
        AblationRow {
            sweep: PARTS.to_owned(),
            surface: surface.to_owned(),
            spacing_mm: 0.5,
            covering_mm: 0.25,
            points: 1000,
            cap: 16,
            depth: 12,
            octants: 10,
            bytes: 10,
            search: search.to_owned(),
            second_level: "none".to_owned(),
            safe: 0,
            coherence: 0,
            step_mm: 1.0,
            hit,
            poses: 10,
            first_level: boxes,
            second_level_tests: 0,
            point_tests: 0,
            recalled: 0,
            touching: 0,
            missed: 0,
        }
    }

    #[test]
    fn forms_are_compared_by_their_totals() {
        // On a and c: (30 + 10) / (100 + 100) = 0.2; on b and d: 40 / 100; free poses alone: 0.1 and 0.2.
        let surfaces = [("a", 100), ("b", 50), ("c", 100), ("d", 50)];
        let rows = surfaces.map(|(surface, baseline)| (surface, 30, 10, baseline, baseline));
        let rows = rows.into_iter().flat_map(|(surface, h, f, bh, bf)| {
            [
                row(surface, "octree", 1, h),
                row(surface, "octree", 0, f),
                row(surface, "leaves", 1, bh),
                row(surface, "leaves", 0, bf),
            ]
        });
        let evidence = Evidence { rows: rows.collect(), kinds: Vec::new(), times: Vec::new(), seed: 1 };
        let claim = ClaimSet::standard()
            .thesis
            .into_iter()
            .find(|claim| claim.id.get_ref() == "octree-reduces-checks")
            .unwrap();
        let judged: Vec<_> =
            evidence.judge(&claim).into_iter().filter(|row| row.measure.starts_with("box tests")).collect();
        let values: Vec<f64> = judged.iter().map(|row| row.value.unwrap()).collect();
        assert!((values[0] - 0.2).abs() < 1e-12 && (values[1] - 0.4).abs() < 1e-12);
        assert!((values[4] - 0.08f64.sqrt()).abs() < 1e-12 && judged[4].scene == ALL);
        assert!(judged.iter().all(|row| row.verdict == "supported"
            && row.effect == "less"
            && row.measure == "box tests octree / leaves"));
        let forms = ["octree", "leaves"].map(|search| FormRef {
            search: search.to_owned(),
            second_level: none(),
            coherence: false,
            safe: false,
        });
        let free = evidence.ratios([&forms[0], &forms[1]], Measure::BoxTests, Poses::Free, "test");
        assert!((free[0].1.value - 0.1).abs() < 1e-12 && (free[1].1.value - 0.2).abs() < 1e-12);
    }
}
