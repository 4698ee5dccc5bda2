//! Analyses an audit: the effect of every level and of every pair of levels, and the share of each term in the variance between cells, with
//! bootstrap intervals.
//!
//! The response of a cell is the mean of its logarithms over the chunks of a stratum, then over strata, then over scenes, each weighted
//! equally. An effect is therefore a factor on the geometric mean. A resample draws clusters within strata, and scenes when there are several.
//! A cluster is chunks that share lines, with all its chunks. Where a cluster spans strata, or a stratum with a single one shows no spread, the
//! strata of the scene are merged; a single cluster has no interval. Deviations are lengthened for few clusters by the variances of their own strata. All cells share one draw, because all cells were measured at the same poses. Cells with unsafe boxes do less work because they
//! miss contacts. Effects are therefore computed three ways: over the safe cells alone, over all cells, and over the cells of each safe centre
//! rule.

use super::factorial::{Decomposition, Design};
use super::stats::{RESAMPLES, below, expansion, generator, median, over_strata, quantile, student_95};
use super::summary::ALL;
use super::totals::clusters;
use super::{AnalysisError, distinct, grouped};
use crate::record::audit::FACTORS;
use crate::record::{
    AuditCellRow, AuditEffectRow, AuditShareRow, BuildRow, CountRow, FactorRow, Manifest, NULL_VARIANT, PoseRow, Row,
    Stratum, TimingRow, TreeRow, read_rows, read_rows_if_there, write_rows,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Name of the set of cells whose boxes contain all of their contents.
pub const SAFE: &str = "safe";
/// Name of the term that holds all interactions of three and four factors.
pub const REST: &str = "rest";
/// The responses, in the order of tables and figures.
pub const RESPONSES: [&str; 5] = ["volume-tests", "triangle-tests", "time", "build", "box-area"];

/// The rows that the analysis of an audit writes.
#[derive(Clone, Debug, Default)]
pub struct AuditOutcome {
    /// Rows of `audit_cells.csv`.
    pub cells: Vec<AuditCellRow>,
    /// Rows of `audit_effects.csv`.
    pub effects: Vec<AuditEffectRow>,
    /// Rows of `audit_shares.csv`.
    pub shares: Vec<AuditShareRow>,
}

/// The raw records of an audit, and the factor levels of every case.
struct Raw {
    levels: BTreeMap<String, [String; 4]>,
    units: Units,
    counts: Vec<CountRow>,
    trees: Vec<TreeRow>,
    timings: Vec<TimingRow>,
    builds: Vec<BuildRow>,
}

/// The clusters of chunks, by scene and chunk.
type Units = BTreeMap<(String, String), String>;

/// One value of a response: scene, group, chunk or part, levels of the cell, value.
type Point<'a> = (&'a str, &'a str, String, &'a [String; 4], f64);

/// The factors' levels as they occur in the records, in order of first appearance.
#[derive(Clone, Debug)]
struct Levels([Vec<String>; 4]);

/// The value of every cell in one chunk, or of one part, of one response.
struct Observed {
    /// The stratum; all groups of a scene have equal weight.
    group: String,
    /// The cluster, which is drawn as one.
    unit: String,
    values: Vec<f64>,
}

/// The values of one response, by scene.
type Observations = BTreeMap<String, Vec<Observed>>;

/// Analyses the audit in `folder` and writes `audit_cells.csv`, `audit_effects.csv` and `audit_shares.csv`.
///
/// # Errors
/// When a record is missing or malformed, or does not hold every cell.
pub fn analyze_audit(folder: &Path) -> Result<AuditOutcome, AnalysisError> {
    let seed = Manifest::read(folder)?.request.seed;
    let factors: Vec<FactorRow> = read_rows(folder)?;
    let levels = Levels::of(&factors);
    let raw = Raw::read(folder, &factors)?;
    let mut leaky: BTreeSet<&str> = BTreeSet::new();
    for tree in raw.trees.iter().filter(|tree| tree.outside_nodes != Some(0)) {
        leaky.insert(&raw.of_cell(TreeRow::FILE, &tree.scene, &tree.case().name())?[1]);
    }
    let observed = raw.observe(&levels)?;
    let mut outcome = AuditOutcome { cells: cell_rows(&levels, &observed, &raw, &leaky)?, ..AuditOutcome::default() };
    let safe = levels.with_centres(|centre| !leaky.contains(centre));
    let each = safe.0[1].iter().map(|safe| (safe.as_str(), levels.with_centres(|centre| centre == safe)));
    for (cells, kept) in [(SAFE, safe.clone()), (ALL, levels.clone())].into_iter().chain(each) {
        if kept.0[1].is_empty() {
            continue;
        }
        for (response, observations) in RESPONSES.iter().zip(&observed) {
            let chosen = restrict(observations, &levels, &kept);
            for scenes in scene_sets(&chosen) {
                tell(&mut outcome, cells, response, &kept, &scenes, seed);
            }
        }
    }
    write_rows(folder, &outcome.cells)?;
    write_rows(folder, &outcome.effects)?;
    write_rows(folder, &outcome.shares)?;
    Ok(outcome)
}

impl Levels {
    fn of(factors: &[FactorRow]) -> Self {
        let of_factor =
            |name: &&str| distinct(factors.iter().filter(|row| row.factor == *name).map(|row| row.level.clone()));
        Self(FACTORS.each_ref().map(of_factor))
    }

    fn with_centres(&self, wanted: impl Fn(&str) -> bool) -> Self {
        let mut kept = self.clone();
        kept.0[1].retain(|centre| wanted(centre));
        kept
    }

    fn design(&self) -> Design {
        Design::new(self.0.iter().map(Vec::len).collect())
    }

    /// The number of the cell with these levels, if all of them are known.
    fn cell(&self, levels: &[String; 4]) -> Option<usize> {
        let places: Option<Vec<usize>> =
            self.0.iter().zip(levels).map(|(known, level)| known.iter().position(|l| l == level)).collect();
        places.map(|places| self.design().cell(&places))
    }

    /// The levels of a cell.
    fn of_cell(&self, cell: usize) -> [String; 4] {
        let design = self.design();
        std::array::from_fn(|factor| self.0[factor][design.level(cell, factor)].clone())
    }
}

impl Raw {
    fn read(folder: &Path, factors: &[FactorRow]) -> Result<Self, AnalysisError> {
        let mut levels: BTreeMap<String, [String; 4]> = BTreeMap::new();
        for row in factors {
            if let Some(place) = FACTORS.iter().position(|factor| *factor == row.factor) {
                levels.entry(row.case.clone()).or_default()[place].clone_from(&row.level);
            }
        }
        let poses = read_rows::<PoseRow>(folder)?.into_iter();
        let poses = grouped(poses.map(|row| (row.scene, (row.chunk, (row.workload, row.pair, row.line)))));
        let of_scene = |(scene, poses): (String, Vec<_>)| {
            let unit = move |(chunk, unit): (u32, u32)| ((scene.clone(), chunk.to_string()), unit.to_string());
            clusters(poses).into_iter().map(unit)
        };
        Ok(Self {
            levels,
            units: poses.into_iter().flat_map(of_scene).collect(),
            counts: read_rows(folder)?,
            trees: read_rows(folder)?,
            timings: read_rows_if_there(folder)?,
            builds: read_rows_if_there(folder)?,
        })
    }

    /// The factor levels of the case that a row of `file` names.
    fn of_cell(&self, file: &'static str, scene: &str, case: &str) -> Result<&[String; 4], AnalysisError> {
        self.levels.get(case).ok_or_else(|| AnalysisError::Unknown {
            file,
            scene: scene.to_owned(),
            what: format!("case `{case}`"),
        })
    }

    /// The observations of every response, in the order of [`RESPONSES`].
    fn observe(&self, levels: &Levels) -> Result<[Observations; 5], AnalysisError> {
        let count = |value: &dyn Fn(&CountRow) -> f64| {
            let point = |r| {
                let CountRow { scene, case, chunk, stratum, .. }: &CountRow = r;
                let stratum = stratum.map_or("-", Stratum::id);
                Ok((scene.as_str(), stratum, chunk.to_string(), self.of_cell(CountRow::FILE, scene, case)?, value(r)))
            };
            let points = self.counts.iter().map(point).collect::<Result<_, AnalysisError>>()?;
            gather(levels, CountRow::FILE, points, &self.units)
        };
        let area = |t| {
            let tree: &TreeRow = t;
            let cell = self.of_cell(TreeRow::FILE, &tree.scene, &tree.case().name())?;
            let ratio = tree.volumes_area_mm2.zip(tree.part_area_mm2).map_or(f64::NAN, |(boxes, part)| boxes / part);
            Ok((tree.scene.as_str(), "-", tree.part.clone(), cell, ratio.ln()))
        };
        let areas = self.trees.iter().map(area).collect::<Result<_, AnalysisError>>()?;
        Ok([
            count(&|r| (r.volume_tests as f64 / r.poses as f64).ln())?,
            count(&|r| (r.triangle_tests as f64 / r.poses as f64).ln_1p())?,
            gather(levels, TimingRow::FILE, self.times()?, &self.units)?,
            gather(levels, BuildRow::FILE, self.build_times()?, &Units::new())?,
            gather(levels, TreeRow::FILE, areas, &Units::new())?,
        ])
    }

    /// Times of passes, divided by the time of the second copy of the reference cell in the same launch, block and chunk.
    fn times(&self) -> Result<Vec<Point<'_>>, AnalysisError> {
        let strata: BTreeMap<(&str, u32), &str> = self
            .counts
            .iter()
            .map(|row| ((row.scene.as_str(), row.chunk), row.stratum.map_or("-", Stratum::id)))
            .collect();
        let key = |r: &TimingRow| (r.scene.clone(), r.launch, r.block, r.chunk);
        let per_pass = |r: &TimingRow| r.ns as f64 / f64::from(r.passes);
        let of_reference: BTreeMap<_, f64> = self
            .timings
            .iter()
            .filter(|row| row.variant() == NULL_VARIANT)
            .map(|row| (key(row), per_pass(row)))
            .collect();
        let point = |r| {
            let row: &TimingRow = r;
            let stratum = strata.get(&(row.scene.as_str(), row.chunk)).copied().unwrap_or("-");
            let reference = of_reference.get(&key(row)).copied().unwrap_or(f64::NAN);
            let cell = self.of_cell(TimingRow::FILE, &row.scene, &row.case)?;
            Ok((row.scene.as_str(), stratum, row.chunk.to_string(), cell, (per_pass(row) / reference).ln()))
        };
        self.timings.iter().filter(|row| row.variant() != NULL_VARIANT).map(point).collect()
    }

    /// Construction times, divided by the construction time of the second copy of the reference cell in the same launch.
    fn build_times(&self) -> Result<Vec<Point<'_>>, AnalysisError> {
        let key = |r: &BuildRow| (r.scene.clone(), r.launch, r.block, r.part.clone());
        let of_reference: BTreeMap<_, f64> =
            self.builds.iter().filter(|row| row.variant == NULL_VARIANT).map(|row| (key(row), row.ns as f64)).collect();
        let point = |r| {
            let row: &BuildRow = r;
            let reference = of_reference.get(&key(row)).copied().unwrap_or(f64::NAN);
            let cell = self.of_cell(BuildRow::FILE, &row.scene, &row.case().name())?;
            Ok((row.scene.as_str(), "-", row.part.clone(), cell, (row.ns as f64 / reference).ln()))
        };
        self.builds.iter().filter(|row| row.variant != NULL_VARIANT).map(point).collect()
    }
}

/// Sorts points by chunk, or part. A cell with several values there, one for each block of timing, gets their median. What `units` does not
/// name is a cluster of its own.
fn gather(
    levels: &Levels,
    file: &'static str,
    points: Vec<Point<'_>>,
    units: &Units,
) -> Result<Observations, AnalysisError> {
    let size = levels.design().cells();
    let mut items: BTreeMap<(String, String, String), Vec<Vec<f64>>> = BTreeMap::new();
    for (scene, group, item, point, value) in points {
        let key = (scene.to_owned(), group.to_owned(), item);
        let Some(cell) = levels.cell(point) else {
            return Err(AnalysisError::Cells { file, scene: key.0 });
        };
        items.entry(key).or_insert_with(|| vec![Vec::new(); size])[cell].push(value);
    }
    let mut observations = Observations::new();
    for ((scene, group, item), values) in items {
        if values.iter().any(Vec::is_empty) {
            return Err(AnalysisError::Cells { file, scene });
        }
        let values = values.into_iter().map(median).collect();
        let item = (scene, item);
        let unit = units.get(&item).unwrap_or(&item.1).clone();
        observations.entry(item.0).or_default().push(Observed { group, unit, values });
    }
    Ok(observations)
}

/// The observations of the cells in `kept` alone.
fn restrict(observations: &Observations, levels: &Levels, kept: &Levels) -> Observations {
    let cells: Vec<usize> = (0..kept.design().cells()).filter_map(|cell| levels.cell(&kept.of_cell(cell))).collect();
    let of_cells = |item: &Observed| Observed {
        group: item.group.clone(),
        unit: item.unit.clone(),
        values: cells.iter().map(|&cell| item.values[cell]).collect(),
    };
    observations.iter().map(|(scene, items)| (scene.clone(), items.iter().map(of_cells).collect())).collect()
}

/// The sets of scenes to analyse: all together, when there are several, and each alone. Returns a name and what was observed in each scene.
fn scene_sets(observations: &Observations) -> Vec<(String, Vec<&[Observed]>)> {
    let mut sets: Vec<(String, Vec<&[Observed]>)> = Vec::new();
    if observations.len() > 1 {
        sets.push((ALL.to_owned(), observations.values().map(Vec::as_slice).collect()));
    }
    sets.extend(observations.iter().map(|(scene, items)| (scene.clone(), vec![items.as_slice()])));
    sets
}

/// What is drawn as one: what was observed in it, each with its weight in the mean response.
type Cluster<'a> = Vec<(f64, &'a Observed)>;

/// The clusters of a scene by stratum.
type Strata<'a> = Vec<Vec<Cluster<'a>>>;

/// The strata of each scene. Scenes weigh the same, and so do the groups of a scene and what was observed in a group. If a group has a single
/// cluster, or a cluster spans groups, all groups of the scene are one stratum.
fn strata<'a>(scenes: &[&'a [Observed]]) -> Vec<Strata<'a>> {
    let of_scene = |scene: &&'a [Observed]| {
        let items: &'a [Observed] = scene;
        let mut groups: BTreeMap<&str, BTreeMap<&str, Cluster<'a>>> = BTreeMap::new();
        for item in items {
            groups.entry(&item.group).or_default().entry(&item.unit).or_default().push((0.0, item));
        }
        let count = scenes.len() * groups.len();
        for group in groups.values_mut() {
            let weight = 1.0 / (count * group.values().map(Vec::len).sum::<usize>()) as f64;
            group.values_mut().flatten().for_each(|item| item.0 = weight);
        }
        let is_single = groups.values().any(|clusters| clusters.len() < 2);
        let units: BTreeSet<&str> = items.iter().map(|item| item.unit.as_str()).collect();
        if is_single || units.len() < groups.values().map(BTreeMap::len).sum() {
            let mut merged: BTreeMap<&str, Cluster<'a>> = BTreeMap::new();
            for (unit, cluster) in groups.into_values().flatten() {
                merged.entry(unit).or_default().extend(cluster);
            }
            vec![merged.into_values().collect()]
        } else {
            groups.into_values().map(|clusters| clusters.into_values().collect()).collect()
        }
    };
    scenes.iter().map(of_scene).collect()
}

/// The mean response of each cell: over chunks or parts, then groups, then scenes. `draw` selects the clusters and scenes of a resample; its
/// argument is the number of them.
fn mean_response(scenes: &[Strata<'_>], cells: usize, mut draw: impl FnMut(usize) -> Vec<usize>) -> Vec<f64> {
    let weight = |cluster: &Cluster<'_>| cluster.iter().map(|(weight, _)| weight).sum::<f64>();
    let mut mean = vec![0.0; cells];
    for scene in draw(scenes.len()) {
        for stratum in &scenes[scene] {
            let drawn: Vec<&Cluster<'_>> = draw(stratum.len()).into_iter().map(|place| &stratum[place]).collect();
            // The clusters of merged groups weigh differently.
            let of_drawn: f64 = drawn.iter().map(|cluster| weight(cluster)).sum();
            let scale = stratum.iter().map(weight).sum::<f64>() / of_drawn;
            for (weight, item) in drawn.into_iter().flatten() {
                for (sum, value) in mean.iter_mut().zip(&item.values) {
                    *sum += weight * scale * value;
                }
            }
        }
    }
    mean
}

/// The numbers that follow from a mean response, for a choice of the items of a resample.
type Statistic<'a> = dyn Fn(&mut dyn FnMut(usize) -> Vec<usize>) -> Vec<f64> + 'a;

/// Factors on the deviations of resamples that correct for few items, one for each number of the statistic. Of several scenes their number
/// counts. Of one scene, each number has the variances of its strata (by the jackknife, which leaves out one cluster at a time), and the
/// degrees of freedom that [`over_strata`] combines from them.
fn expansions(scenes: &[Strata<'_>], numbers: usize, statistic: &Statistic<'_>) -> Vec<f64> {
    let [strata] = scenes else { return vec![expansion(scenes.len() as f64 - 1.0); numbers] };
    let mut variances = vec![Vec::new(); numbers];
    for (place, stratum) in strata.iter().enumerate().filter(|(_, stratum)| stratum.len() > 1) {
        let without = |left_out: usize| {
            let mut draws = 0;
            // The scene is drawn first, then its strata.
            statistic(&mut |items| {
                draws += 1;
                (0..items).filter(|&item| draws != place + 2 || item != left_out).collect()
            })
        };
        let found: Vec<Vec<f64>> = (0..stratum.len()).map(without).collect();
        let count = stratum.len() as f64;
        for (number, variances) in variances.iter_mut().enumerate() {
            let middle = found.iter().map(|values| values[number]).sum::<f64>() / count;
            let squares = found.iter().map(|values| (values[number] - middle).powi(2)).sum::<f64>();
            variances.push((squares * (count - 1.0) / count, count));
        }
    }
    let freedom = strata.iter().map(|clusters| clusters.len() as f64 - 1.0).sum::<f64>();
    let factor = |variances: Vec<(f64, f64)>| match over_strata(variances.into_iter()) {
        Some((freedom, lengthening, _)) => lengthening * student_95(freedom) / student_95(f64::INFINITY),
        None => expansion(freedom),
    };
    variances.into_iter().map(factor).collect()
}

/// Adds the effects and shares of one response over some scenes.
fn tell(
    outcome: &mut AuditOutcome,
    cells: &str,
    response: &str,
    levels: &Levels,
    (name, scenes): &(String, Vec<&[Observed]>),
    seed: u64,
) {
    let (design, scenes) = (levels.design(), strata(scenes));
    let flat = |d: Decomposition| d.effects.concat().into_iter().chain(d.shares).collect::<Vec<f64>>();
    let statistic = |draw: &mut dyn FnMut(usize) -> Vec<usize>| {
        flat(design.decompose(&mean_response(&scenes, design.cells(), draw)))
    };
    let found = statistic(&mut |n| (0..n).collect());
    let mut generator = generator(seed, &format!("audit {cells} {response} {name}"));
    let mut draws = vec![Vec::with_capacity(RESAMPLES); found.len()];
    for _ in 0..RESAMPLES {
        let resample = statistic(&mut |n| (0..n).map(|_| below(&mut generator, n)).collect());
        for (draws, value) in draws.iter_mut().zip(resample) {
            draws.push(value);
        }
    }
    draws.iter_mut().for_each(|draws| draws.sort_unstable_by(f64::total_cmp));
    let expansions = expansions(&scenes, found.len(), &statistic);
    let mut numbers = found.iter().zip(&draws).zip(expansions).map(|((&value, draws), expansion)| {
        let end = |q: f64| value + (quantile(draws, q) - value) * expansion;
        [value, end(0.025), end(0.975)]
    });
    let terms = design.terms();
    let term_name = |factors: &[usize]| factors.iter().map(|&f| FACTORS[f]).collect::<Vec<_>>().join(":");
    for term in &terms {
        for level in combinations(&design, levels, term) {
            let Some([effect, low, high]) = numbers.next().map(|numbers| numbers.map(f64::exp)) else { return };
            let (scene, cells, response) = (name.clone(), cells.to_owned(), response.to_owned());
            let term = term_name(term);
            outcome.effects.push(AuditEffectRow { scene, cells, response, term, level, effect, low, high });
        }
    }
    for term in terms.iter().map(|term| term_name(term)).chain([REST.to_owned()]) {
        let Some([share, low, high]) =
            numbers.next().map(|[share, low, high]| [share, low.clamp(0.0, 1.0), high.clamp(0.0, 1.0)])
        else {
            return;
        };
        let (scene, cells, response) = (name.clone(), cells.to_owned(), response.to_owned());
        outcome.shares.push(AuditShareRow { scene, cells, response, term, share, low, high });
    }
}

/// The names of all combinations of levels of a term; the last factor varies fastest.
fn combinations(design: &Design, levels: &Levels, factors: &[usize]) -> Vec<String> {
    factors.iter().fold(vec![String::new()], |names, &factor| {
        let with = |name: &String, level: usize| {
            let level = &levels.0[factor][level];
            if name.is_empty() { level.clone() } else { format!("{name}:{level}") }
        };
        names.iter().flat_map(|name| (0..design.levels(factor)).map(|l| with(name, l)).collect::<Vec<_>>()).collect()
    })
}

/// A row per cell and scene, and over all scenes.
fn cell_rows(
    levels: &Levels,
    observed: &[Observations; 5],
    raw: &Raw,
    leaky: &BTreeSet<&str>,
) -> Result<Vec<AuditCellRow>, AnalysisError> {
    let size = levels.design().cells();
    let mut found = Vec::new();
    for (scene, _) in scene_sets(&observed[0]) {
        let of_scene = |name: &str| scene == ALL || scene == name;
        let means = observed.each_ref().map(|observations| {
            let scenes: Vec<&[Observed]> =
                observations.iter().filter(|(name, _)| of_scene(name)).map(|(_, c)| c.as_slice()).collect();
            (!scenes.is_empty()).then(|| mean_response(&strata(&scenes), size, |n| (0..n).collect()))
        });
        let mut facts = vec![(0, 0, 0.0, 0_u32, 0.0_f64); size];
        for row in raw.counts.iter().filter(|row| of_scene(&row.scene)) {
            let Some(cell) = levels.cell(raw.of_cell(CountRow::FILE, &row.scene, &row.case)?) else { continue };
            facts[cell].0 += row.touching;
            facts[cell].1 += row.missed;
        }
        for tree in raw.trees.iter().filter(|tree| of_scene(&tree.scene)) {
            let case = tree.case().name();
            let Some(cell) = levels.cell(raw.of_cell(TreeRow::FILE, &tree.scene, &case)?) else { continue };
            facts[cell].2 += tree.outside_corners_pct.unwrap_or(f64::NAN);
            facts[cell].3 += 1;
            facts[cell].4 = facts[cell].4.max(tree.overhang_mm.unwrap_or(0.0));
        }
        for (cell, &(touching, missed, outside, parts, overhang_mm)) in facts.iter().enumerate() {
            let [orientation, centre, split, leaf] = levels.of_cell(cell);
            let [volume, triangle, time, build, area] =
                means.each_ref().map(|mean| mean.as_ref().map(|mean| mean[cell]));
            found.push(AuditCellRow {
                scene: scene.clone(),
                safe: u8::from(!leaky.contains(centre.as_str())),
                orientation,
                centre,
                split,
                leaf: leaf.parse().unwrap_or(0),
                volume_tests: volume.map_or(f64::NAN, f64::exp),
                triangle_tests: triangle.map_or(f64::NAN, f64::exp_m1),
                time_ratio: time.map(f64::exp),
                build_ratio: build.map(f64::exp),
                box_area_ratio: area.map_or(f64::NAN, f64::exp),
                touching,
                missed,
                outside_corners_pct: outside / f64::from(parts),
                overhang_mm,
            });
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
