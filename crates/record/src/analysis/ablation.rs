//! Judges the claims of the thesis by an ablation of its method: by counts, which are the same on every machine, and by time.

use super::claims::ClaimSet;
use super::judge::{CLUSTERS_MIN, Effect, Verdict, ratio_verdict};
use super::stats::{Interval, clustered_rate, equal_lines, mean};
use super::summary::ALL;
use super::totals::over_launches;
use super::{AnalysisError, counted, distinct};
use crate::record::vocabulary::named;
use crate::record::{
    BuildRow, ClaimRow, CountRow, FactorRow, Row, TimingRow, TreeRow, read_rows, read_rows_if_there, write_rows,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// The sweep that the claims compare: it varies the search, the second level, safety and coherence.
pub const PARTS: &str = "parts";

/// One form of the method: the level of each factor, and the size of the surface it ran on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Form {
    /// The sweep that the form belongs to: `parts`, `cap`, `depth`, `spacing`, `step` or `size`.
    pub sweep: String,
    /// How leaves are found: `points`, `leaves` or `octree`. For a tree over both meshes, the id of its variant.
    pub search: String,
    /// `none`, `profile4`, `axial4` or `quad4`.
    pub second_level: String,
    /// Whether the tool is widened by the covering radius, 0 or 1.
    pub safe: u8,
    /// Whether the leaf that collided at the last pose is tested first, 0 or 1.
    pub coherence: u8,
    /// Largest number of points in a leaf.
    pub cap: u32,
    /// Greatest depth of the octree.
    pub depth: u8,
    /// Spacing of the samples, mm.
    pub spacing_mm: f64,
    /// Mean distance of the tool's tip between successive poses, mm.
    pub step_mm: f64,
    /// Number of samples; for a variant, the number of triangles of the surface.
    pub points: u64,
}

/// Counts of a form on one surface, over the poses that the form calls interfering or over all other poses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Counted {
    /// The form.
    pub form: Form,
    /// The counts on that surface.
    #[serde(flatten)]
    pub counts: CountRow,
}

/// Time of a form over all poses of a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timed {
    /// The surface.
    pub surface: String,
    /// The form.
    pub form: Form,
    /// Number of the timing round.
    pub round: u32,
    /// Poses.
    pub poses: u64,
    /// Time over all poses, ns.
    pub ns: u64,
    /// Time to sample the surface and build the octree, ns.
    pub build_ns: u64,
}

/// The raw records of an ablation, joined.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Ablation {
    /// Counts of the forms.
    pub rows: Vec<Counted>,
    /// Counts of local and global interference.
    pub kinds: Vec<CountRow>,
    /// Times.
    pub times: Vec<Timed>,
}

impl Counted {
    /// The surface.
    pub fn surface(&self) -> &str {
        &self.counts.scene
    }

    /// 1 when the form calls these poses interfering, otherwise 0.
    pub fn hit(&self) -> u8 {
        self.counts.verdict.unwrap_or(0)
    }

    /// Separating-axis tests of both levels; for a variant, its volume tests.
    pub fn box_tests(&self) -> u64 {
        self.counts.volume_tests + self.counts.second_level_tests
    }
}

impl Form {
    /// Sets a factor to a level; `false` when the factor or the level is unknown.
    fn set(&mut self, factor: &str, level: &str) -> bool {
        fn put<T: std::str::FromStr>(place: &mut T, level: &str) -> bool {
            level.parse().map(|level| *place = level).is_ok()
        }
        match factor {
            "sweep" => put(&mut self.sweep, level),
            "search" => put(&mut self.search, level),
            "second_level" => put(&mut self.second_level, level),
            "safe" => put(&mut self.safe, level),
            "coherence" => put(&mut self.coherence, level),
            "cap" => put(&mut self.cap, level),
            "depth" => put(&mut self.depth, level),
            "spacing_mm" => put(&mut self.spacing_mm, level),
            "step_mm" => put(&mut self.step_mm, level),
            "covering_mm" | "kind" => true,
            _ => false,
        }
    }
}

impl Ablation {
    /// Reads the ablation in `folder`.
    ///
    /// # Errors
    /// When a record is missing or malformed, or a row names a case or scene that no other record defines.
    pub fn read(folder: &Path) -> Result<Self, AnalysisError> {
        let factors: Vec<FactorRow> = read_rows(folder)?;
        let trees: Vec<TreeRow> = read_rows(folder)?;
        let points: BTreeMap<(&str, &str), u64> =
            trees.iter().map(|tree| ((&*tree.scene, &*tree.variant), tree.triangles)).collect();
        let form = |scene: &str, case: &str| -> Result<Form, AnalysisError> {
            let mut form = Form { points: points.get(&(scene, case)).copied().unwrap_or(0), ..Form::default() };
            for row in factors.iter().filter(|row| row.case == case && ["", scene].contains(&row.scene.as_str())) {
                if !form.set(&row.factor, &row.level) {
                    let what = format!("level `{}` of factor `{}`", row.level, row.factor);
                    return Err(AnalysisError::Unknown { file: FactorRow::FILE, scene: scene.to_owned(), what });
                }
            }
            Ok(form)
        };
        let mut found = Self::default();
        let mut poses: BTreeMap<(String, String), (u64, Form)> = BTreeMap::new();
        for counts in read_rows::<CountRow>(folder)? {
            let form = form(&counts.scene, &counts.case)?;
            if form.sweep.is_empty() {
                found.kinds.push(counts);
                continue;
            }
            let key = (counts.scene.clone(), counts.case.clone());
            poses.entry(key).or_insert_with(|| (0, form.clone())).0 += counts.poses;
            found.rows.push(Counted { form, counts });
        }
        let builds: Vec<BuildRow> = read_rows_if_there(folder)?;
        for row in read_rows_if_there::<TimingRow>(folder)? {
            let (poses, form) = poses.get(&(row.scene.clone(), row.case.clone())).cloned().ok_or_else(|| {
                let what = format!("case `{}`", row.case);
                AnalysisError::Unknown { file: TimingRow::FILE, scene: row.scene.clone(), what }
            })?;
            let build = builds.iter().find(|build| build.scene == row.scene && build.variant == row.case);
            found.times.push(Timed {
                surface: row.scene,
                form,
                round: row.block,
                poses,
                ns: row.ns,
                build_ns: build.map_or(0, |build| build.ns),
            });
        }
        Ok(found)
    }
}

/// One sentence of the thesis, and the test that judges it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThesisClaim {
    /// Short name.
    pub id: Spanned<String>,
    /// The sentence, paraphrased.
    pub sentence: String,
    /// Place of the sentence in the thesis.
    pub source: String,
    /// The test that judges the sentence.
    pub test: ThesisTest,
}

/// How a sentence of the thesis is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, tag = "kind", rename_all = "kebab-case")]
pub enum ThesisTest {
    /// Two forms of the method compared.
    Ratio {
        /// The form that the thesis proposes.
        subject: FormRef,
        /// The form that it is compared with.
        baseline: FormRef,
        /// The poses over which counts are added up.
        #[serde(default)]
        poses: Poses,
        /// Quantities to compare; each gets a verdict of its own.
        measures: Vec<Measure>,
        /// The claim is supported when the whole interval is below this ratio.
        below: f64,
    },
    /// Local and global interference are both found wherever the meshes touch.
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
    /// Whether the leaf that collided at the last pose is tested first.
    #[serde(default)]
    pub coherence: bool,
    /// Whether the tool is widened by the covering radius.
    #[serde(default)]
    pub safe: bool,
}

fn none() -> String {
    "none".to_owned()
}

named! {
    /// Poses over which counts are added up.
    #[derive(Default)]
    pub enum Poses {
        /// All.
        #[default]
        All = "all",
        /// The poses that the method calls interfering.
        Hit = "hit",
        /// The poses that the method calls free.
        Free = "free",
    }
}

impl Poses {
    const fn holds(self, hit: u8) -> bool {
        match self {
            Self::All => true,
            Self::Hit => hit == 1,
            Self::Free => hit == 0,
        }
    }
}

/// The quantity that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Tests of octants against boxes, both levels.
    BoxTests,
    /// Points compared with tool profiles.
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
    fn is(&self, form: &Form) -> bool {
        (&form.search, &form.second_level) == (&self.search, &self.second_level)
            && (form.coherence, form.safe) == (u8::from(self.coherence), u8::from(self.safe))
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
pub fn analyze_ablation(folder: &Path, set: &ClaimSet) -> Result<Vec<ClaimRow>, AnalysisError> {
    let ablation = Ablation::read(folder)?;
    let rows: Vec<ClaimRow> = set.thesis.iter().flat_map(|claim| ablation.judge(claim)).collect();
    write_rows(folder, &rows)?;
    Ok(rows)
}

/// Largest rate that counts as none missed, as in the paper's claims about misses.
const RATE_MOST: f64 = 0.001;

/// A ratio of two forms.
struct Ratio {
    /// A surface, or `all`.
    surface: String,
    /// Its value and interval; without one when too little was repeated.
    interval: Interval,
    /// What was repeated, when it is too little to decide.
    few: Option<String>,
}

impl Ratio {
    /// The mean of logarithms of ratios, with Student's interval over them.
    fn of(surface: &str, logs: &[f64], what: &str) -> Self {
        let repeats: Vec<(f64, f64)> = logs.iter().map(|log| (log.exp(), 1.0)).collect();
        let interval = over_launches(&repeats).map_or(Interval::exact(f64::NAN), |estimate| estimate.interval);
        // Of ratios the geometric mean, not that of totals.
        let shift = mean(logs).exp() / interval.value;
        let few = (logs.len() < CLUSTERS_MIN)
            .then(|| format!("only {}: too few for an interval", counted(logs.len() as u64, what)));
        Self { surface: surface.to_owned(), interval: interval.map(|end| end * shift), few }
    }

    /// A ratio of counts on one surface, which no repetition changes.
    fn counted(surface: &str, value: f64) -> Self {
        Self { surface: surface.to_owned(), interval: Interval::exact(value), few: None }
    }
}

impl Ablation {
    fn judge(&self, claim: &ThesisClaim) -> Vec<ClaimRow> {
        match &claim.test {
            ThesisTest::Found => self.found(claim),
            ThesisTest::Ratio { subject, baseline, poses, measures, below } => measures
                .iter()
                .flat_map(|&measure| {
                    // Times are of all poses together.
                    let poses = if measure == Measure::Time { Poses::All } else { *poses };
                    let text = format!("{} {} / {}", measure.name(), subject.describe(), baseline.describe());
                    let ratios = self.ratios([subject, baseline], measure, poses);
                    ratios.into_iter().map(move |Ratio { surface, interval, few }| {
                        let (verdict, effect) = match few {
                            Some(_) => (Verdict::Undecided, Effect::Unclear),
                            None => (ratio_verdict(interval, *below, false), Effect::of(interval)),
                        };
                        let end = |end: f64| end.is_finite().then_some(end);
                        ClaimRow {
                            stratum: poses.id().to_owned(),
                            verdict: verdict.id().to_owned(),
                            effect: effect.id().to_owned(),
                            measure: text.clone(),
                            value: Some(interval.value),
                            low: end(interval.low),
                            high: end(interval.high),
                            note: few.unwrap_or_default(),
                            ..empty(claim, &surface)
                        }
                    })
                })
                .collect(),
        }
    }

    fn surfaces(&self) -> Vec<&str> {
        distinct(self.rows.iter().filter(|row| row.form.sweep == PARTS).map(Counted::surface))
    }

    /// The ratio of two forms on each surface, for times with its interval over rounds, and their geometric mean over surfaces with its
    /// interval. Counts of one surface have no interval. Surfaces on which either form has a count of zero are left out.
    fn ratios(&self, forms: [&FormRef; 2], measure: Measure, poses: Poses) -> Vec<Ratio> {
        let logs_of = |surface: &str| -> Vec<f64> {
            let ratios: Vec<f64> = if measure == Measure::Time {
                let rounds = |form: &FormRef| {
                    let of_form = self.times.iter().filter(|row| {
                        (row.form.sweep.as_str(), row.surface.as_str()) == (PARTS, surface) && form.is(&row.form)
                    });
                    of_form.map(|row| row.ns as f64).collect::<Vec<_>>()
                };
                rounds(forms[0]).iter().zip(rounds(forms[1])).map(|(subject, baseline)| subject / baseline).collect()
            } else {
                let total = |form: &FormRef| {
                    let of_form = self.rows.iter().filter(|row| {
                        (row.form.sweep.as_str(), row.surface()) == (PARTS, surface)
                            && poses.holds(row.hit())
                            && form.is(&row.form)
                    });
                    let count = |row: &Counted| match measure {
                        Measure::BoxTests => row.box_tests(),
                        Measure::PointTests | Measure::Time => row.counts.triangle_tests,
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
        let of_surface = |(surface, logs): &(&str, Vec<f64>)| match measure {
            Measure::Time => Ratio::of(surface, logs, "rounds"),
            Measure::BoxTests | Measure::PointTests => Ratio::counted(surface, logs[0].exp()),
        };
        let mut found: Vec<Ratio> = observed.iter().map(of_surface).collect();
        if observed.len() > 1 {
            let means: Vec<f64> =
                observed.iter().map(|(_, logs)| logs.iter().sum::<f64>() / logs.len() as f64).collect();
            let few = found.iter().find_map(|ratio| ratio.few.clone());
            let all = Ratio::of(ALL, &means, "surfaces");
            found.push(Ratio { few: all.few.clone().or(few), ..all });
        }
        found
    }

    fn found(&self, claim: &ThesisClaim) -> Vec<ClaimRow> {
        let mut rows = Vec::new();
        for kind in ["local", "global"] {
            let of_kind = || self.kinds.iter().filter(|row| row.case == kind);
            let sum = |part: fn(&CountRow) -> u64| of_kind().map(part).sum::<u64>();
            let (touching, missed) = (sum(|row| row.touching), sum(|row| row.missed));
            let found: u64 = of_kind().filter(|row| row.verdict == Some(1)).map(|row| row.poses).sum();
            let mut lines: BTreeMap<(&str, u32), (u64, u64)> = BTreeMap::new();
            for row in of_kind() {
                let line = lines.entry((&row.scene, row.chunk)).or_default();
                *line = (line.0 + row.missed, line.1 + row.touching);
            }
            let lines: Vec<(u64, u64)> = lines.into_values().collect();
            let (low, high) = clustered_rate(&lines);
            let verdict = match (touching, missed) {
                (0, _) => Verdict::NotJudged,
                (_, 1..) => Verdict::Refuted,
                _ if high > RATE_MOST => Verdict::Undecided,
                _ => Verdict::Supported,
            };
            rows.push(ClaimRow {
                stratum: kind.to_owned(),
                verdict: verdict.id().to_owned(),
                measure: "share of contacts of the meshes that is missed".to_owned(),
                value: (touching > 0).then(|| missed as f64 / touching as f64),
                low: Some(low),
                high: Some(high),
                missed: Some(missed),
                note: format!(
                    "{missed} of {touching} poses with {kind} contact missed, which are worth {:.1} lines; said of {found}",
                    equal_lines(&lines)
                ),
                ..empty(claim, ALL)
            });
        }
        rows
    }
}

fn empty(claim: &ThesisClaim, surface: &str) -> ClaimRow {
    ClaimRow {
        scene: surface.to_owned(),
        measure: String::new(),
        ..ClaimRow::blank(claim.id.get_ref(), Verdict::NotJudged.id())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(surface: &str, search: &str, hit: u8, boxes: u64) -> Counted {
        let (sweep, second_level) = (PARTS.to_owned(), "none".to_owned());
        let form = Form { sweep, search: search.to_owned(), second_level, ..Form::default() };
        let counts = CountRow::new(surface, search, 0, None);
        Counted { form, counts: CountRow { verdict: Some(hit), poses: 10, volume_tests: boxes, ..counts } }
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
        let evidence = Ablation { rows: rows.collect(), kinds: Vec::new(), times: Vec::new() };
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
        let free = evidence.ratios([&forms[0], &forms[1]], Measure::BoxTests, Poses::Free);
        assert!((free[0].interval.value - 0.1).abs() < 1e-12 && (free[1].interval.value - 0.2).abs() < 1e-12);
    }

    /// A tenth of the time in each of four rounds is supported; in one round, or in three, nothing is.
    #[test]
    fn few_rounds_decide_nothing() {
        let claim = ClaimSet::standard()
            .thesis
            .into_iter()
            .find(|claim| claim.id.get_ref() == "octree-reduces-checks")
            .unwrap();
        let verdicts = |rounds: u32| {
            let time = |search: &str, round: u32, ns: u64| {
                let form = row("a", search, 0, 1).form;
                Timed { surface: "a".to_owned(), form, round, poses: 1, ns, build_ns: 0 }
            };
            let times = (0..rounds).flat_map(|round| [time("octree", round, 100), time("leaves", round, 1000)]);
            let rows = vec![row("a", "octree", 0, 1), row("a", "leaves", 0, 2)];
            let evidence = Ablation { rows, kinds: Vec::new(), times: times.collect() };
            let judged = evidence.judge(&claim);
            let time = judged.into_iter().find(|row| row.measure.starts_with("time")).unwrap();
            assert!(rounds > 1 || time.note.contains("only 1 round: too few"), "{}", time.note);
            (time.verdict, time.effect, time.low.is_some())
        };
        let undecided = |has_interval| ("undecided".to_owned(), "unclear".to_owned(), has_interval);
        assert_eq!(verdicts(1), undecided(false));
        assert_eq!(verdicts(3), undecided(true));
        assert_eq!(verdicts(4), ("supported".to_owned(), "less".to_owned(), true));
    }

    /// None missed on 5 lines is at most 60 %, and on 3000 at most 0.1 %, however many contacts a line has. 3000 contacts of one line show nothing.
    #[test]
    fn few_lines_show_no_absence() {
        let claim =
            ClaimSet::standard().thesis.into_iter().find(|claim| claim.id.get_ref() == "local-and-global").unwrap();
        let verdict = |lines: u32, touching: u64, missed: u64| {
            let line = |chunk| CountRow {
                touching,
                missed: if chunk == 0 { missed } else { 0 },
                ..CountRow::new("a", "local", chunk, None)
            };
            let evidence = Ablation { rows: Vec::new(), kinds: (0..lines).map(line).collect(), times: Vec::new() };
            let row = evidence.judge(&claim).remove(0);
            (row.verdict, row.high)
        };
        assert_eq!(verdict(5, 1, 0), ("undecided".to_owned(), Some(0.6)));
        assert_eq!(verdict(1, 3000, 0), ("undecided".to_owned(), Some(1.0)));
        assert_eq!(verdict(3000, 1, 0), ("supported".to_owned(), Some(0.001)));
        assert_eq!(verdict(3000, 2, 0), ("supported".to_owned(), Some(0.001)));
        assert_eq!(verdict(3000, 2, 1).0, "refuted");
        assert_eq!(verdict(0, 0, 0).0, "not-judged");
    }
}
