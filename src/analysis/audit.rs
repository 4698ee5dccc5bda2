//! What an audit found: the effect of every level, of every pair of levels, and each term's share of the variance between
//! cells, with bootstrap intervals.
//!
//! The response of a cell is the mean of its logarithms over the chunks of a stratum, then over strata, then over scenes,
//! each weighted equally; so an effect is a factor on the geometric mean. A resample draws chunks within strata, and scenes
//! where there are several (Owen 2007, as in [`super::stats`]); all cells keep the same draw, as they had the same poses.
//! Cells whose boxes leave something out do less work because they miss contacts: the effects are found over the safe
//! cells alone, over all, and over those of each safe centre.

use super::AnalysisError;
use super::factorial::{Decomposition, Design};
use super::stats::{RESAMPLES, below, expansion, generator, quantile};
use super::summary::ALL;
use crate::record::audit::FACTORS;
use crate::record::{
    AuditBuildRow, AuditCellRow, AuditEffectRow, AuditRow, AuditShareRow, AuditTimingRow, AuditTreeRow, Manifest, Row,
    read_rows, write_rows,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The cells whose boxes contain everything.
pub const SAFE: &str = "safe";
/// The share of three and four factors together.
pub const REST: &str = "rest";
/// The responses, in the order of tables and figures.
pub const RESPONSES: [&str; 5] = ["volume-tests", "triangle-tests", "time", "build", "box-area"];

/// What an audit comes to.
#[derive(Clone, Debug, Default)]
pub struct AuditOutcome {
    /// `audit_cells.csv`.
    pub cells: Vec<AuditCellRow>,
    /// `audit_effects.csv`.
    pub effects: Vec<AuditEffectRow>,
    /// `audit_shares.csv`.
    pub shares: Vec<AuditShareRow>,
}

/// The factors' levels as they occur in the records, in order of first appearance.
#[derive(Clone, Debug)]
struct Levels([Vec<String>; 4]);

/// One cluster of one response: a value per cell.
struct Cluster {
    /// What is weighted equally within a scene: the stratum.
    group: String,
    values: Vec<f64>,
}

/// The clusters of one response by scene.
type Observations = BTreeMap<String, Vec<Cluster>>;

/// Analyses the audit in `folder` and writes `audit_cells.csv`, `audit_effects.csv` and `audit_shares.csv`.
///
/// # Errors
/// When a record is missing or malformed, or does not hold every cell.
pub fn analyze_audit(folder: &Path) -> Result<AuditOutcome, AnalysisError> {
    let seed = Manifest::read(folder)?.request.seed;
    let (rows, trees): (Vec<AuditRow>, Vec<AuditTreeRow>) = (read_rows(folder)?, read_rows(folder)?);
    let (timings, builds): (Vec<AuditTimingRow>, Vec<AuditBuildRow>) = (optional(folder)?, optional(folder)?);
    let levels = Levels::of(&rows);
    let leaky: BTreeSet<&str> =
        trees.iter().filter(|tree| tree.outside_nodes > 0).map(|tree| tree.centre.as_str()).collect();
    let observed = observe(&levels, &rows, &trees, &timings, &builds)?;
    let mut outcome =
        AuditOutcome { cells: cell_rows(&levels, &observed, &rows, &trees, &leaky), ..AuditOutcome::default() };
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

fn optional<R: Row>(folder: &Path) -> Result<Vec<R>, AnalysisError> {
    if folder.join(R::FILE).exists() { Ok(read_rows(folder)?) } else { Ok(Vec::new()) }
}

impl Levels {
    fn of(rows: &[AuditRow]) -> Self {
        let mut levels: [Vec<String>; 4] = Default::default();
        for row in rows {
            for (known, level) in levels.iter_mut().zip(row.levels()) {
                if !known.contains(&level) {
                    known.push(level);
                }
            }
        }
        Self(levels)
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

/// All responses' observations, in the order of [`RESPONSES`].
fn observe(
    levels: &Levels,
    rows: &[AuditRow],
    trees: &[AuditTreeRow],
    timings: &[AuditTimingRow],
    builds: &[AuditBuildRow],
) -> Result<[Observations; 5], AnalysisError> {
    let strata: BTreeMap<(&str, u32), &str> =
        rows.iter().map(|row| ((row.scene.as_str(), row.chunk), row.stratum.id())).collect();
    let count = |value: &dyn Fn(&AuditRow) -> f64| {
        let points = rows.iter().map(|r| (&*r.scene, r.stratum.id(), r.chunk.to_string(), r.levels(), value(r)));
        gather(levels, AuditRow::FILE, points.collect())
    };
    let time = |r: &AuditTimingRow| {
        let per_pass = |ns: u64, passes: u32| ns as f64 / f64::from(passes);
        (per_pass(r.ns, r.passes) / per_pass(r.reference_ns, r.reference_passes)).ln()
    };
    let times = timings.iter().map(|r| {
        let stratum = strata.get(&(&*r.scene, r.chunk)).copied().unwrap_or("-");
        (&*r.scene, stratum, r.chunk.to_string(), r.levels(), time(r))
    });
    let build = |r: &AuditBuildRow| (r.ns as f64 / r.reference_ns as f64).ln();
    let build_points = builds.iter().map(|r| (&*r.scene, "-", r.part.clone(), r.levels(), build(r)));
    let area = |t: &AuditTreeRow| (t.boxes_area_mm2 / t.part_area_mm2).ln();
    let areas = trees.iter().map(|t| (&*t.scene, "-", t.part.clone(), t.levels(), area(t)));
    Ok([
        count(&|r| (r.volume_tests as f64 / f64::from(r.poses)).ln())?,
        count(&|r| (r.triangle_tests as f64 / f64::from(r.poses)).ln_1p())?,
        gather(levels, AuditTimingRow::FILE, times.collect())?,
        gather(levels, AuditBuildRow::FILE, build_points.collect())?,
        gather(levels, AuditTreeRow::FILE, areas.collect())?,
    ])
}

/// Sorts points (scene, group, cluster, levels, value) into clusters; of several values of a cell, blocks of a timing, the
/// median counts.
fn gather(
    levels: &Levels,
    file: &'static str,
    points: Vec<(&str, &str, String, [String; 4], f64)>,
) -> Result<Observations, AnalysisError> {
    let size = levels.design().cells();
    let mut clusters: BTreeMap<(String, String, String), Vec<Vec<f64>>> = BTreeMap::new();
    for (scene, group, cluster, point, value) in points {
        let key = (scene.to_owned(), group.to_owned(), cluster);
        let Some(cell) = levels.cell(&point) else {
            return Err(AnalysisError::Cells { file, scene: key.0 });
        };
        clusters.entry(key).or_insert_with(|| vec![Vec::new(); size])[cell].push(value);
    }
    let mut observations = Observations::new();
    for ((scene, group, _), mut values) in clusters {
        if values.iter().any(Vec::is_empty) {
            return Err(AnalysisError::Cells { file, scene });
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_unstable_by(f64::total_cmp);
            quantile(values, 0.5)
        };
        let values = values.iter_mut().map(median).collect();
        observations.entry(scene).or_default().push(Cluster { group, values });
    }
    Ok(observations)
}

/// The same observations of the cells that `kept` has.
fn restrict(observations: &Observations, levels: &Levels, kept: &Levels) -> Observations {
    let cells: Vec<usize> = (0..kept.design().cells()).filter_map(|cell| levels.cell(&kept.of_cell(cell))).collect();
    let cluster = |cluster: &Cluster| Cluster {
        group: cluster.group.clone(),
        values: cells.iter().map(|&cell| cluster.values[cell]).collect(),
    };
    observations.iter().map(|(scene, clusters)| (scene.clone(), clusters.iter().map(cluster).collect())).collect()
}

/// All scenes together, when there are several, and each alone: a name and the clusters of each scene.
fn scene_sets(observations: &Observations) -> Vec<(String, Vec<&[Cluster]>)> {
    let mut sets: Vec<(String, Vec<&[Cluster]>)> = Vec::new();
    if observations.len() > 1 {
        sets.push((ALL.to_owned(), observations.values().map(Vec::as_slice).collect()));
    }
    sets.extend(observations.iter().map(|(scene, clusters)| (scene.clone(), vec![clusters.as_slice()])));
    sets
}

/// The mean response of each cell: over clusters, then groups, then scenes. `draw` says which of so many are taken.
fn mean_response(scenes: &[&[Cluster]], cells: usize, mut draw: impl FnMut(usize) -> Vec<usize>) -> Vec<f64> {
    let mut mean = vec![0.0; cells];
    for scene in draw(scenes.len()).into_iter().map(|scene| scenes[scene]) {
        let groups: BTreeSet<&str> = scene.iter().map(|cluster| cluster.group.as_str()).collect();
        for group in &groups {
            let members: Vec<&Cluster> = scene.iter().filter(|cluster| cluster.group == **group).collect();
            let weight = 1.0 / (scenes.len() * groups.len() * members.len()) as f64;
            for cluster in draw(members.len()).into_iter().map(|member| members[member]) {
                for (sum, value) in mean.iter_mut().zip(&cluster.values) {
                    *sum += weight * value;
                }
            }
        }
    }
    mean
}

/// Degrees of freedom of what is drawn: scenes where there are several, else the chunks of each stratum.
fn freedom(scenes: &[&[Cluster]]) -> f64 {
    if scenes.len() > 1 {
        return scenes.len() as f64 - 1.0;
    }
    let clusters = scenes.iter().map(|scene| scene.len()).sum::<usize>();
    let groups = scenes.iter().flat_map(|scene| scene.iter()).map(|cluster| &cluster.group).collect::<BTreeSet<_>>();
    (clusters - groups.len()) as f64
}

/// Adds the effects and shares of one response over some scenes.
fn tell(
    outcome: &mut AuditOutcome,
    cells: &str,
    response: &str,
    levels: &Levels,
    (name, scenes): &(String, Vec<&[Cluster]>),
    seed: u64,
) {
    let design = levels.design();
    let flat = |d: Decomposition| d.effects.concat().into_iter().chain(d.shares).collect::<Vec<f64>>();
    let found = flat(design.decompose(&mean_response(scenes, design.cells(), |n| (0..n).collect())));
    let mut generator = generator(seed, &format!("audit {cells} {response} {name}"));
    let mut draws = vec![Vec::with_capacity(RESAMPLES); found.len()];
    for _ in 0..RESAMPLES {
        let draw = |n: usize| (0..n).map(|_| below(&mut generator, n)).collect();
        let resample = flat(design.decompose(&mean_response(scenes, design.cells(), draw)));
        for (draws, value) in draws.iter_mut().zip(resample) {
            draws.push(value);
        }
    }
    draws.iter_mut().for_each(|draws| draws.sort_unstable_by(f64::total_cmp));
    let expansion = expansion(freedom(scenes));
    let mut numbers = found.iter().zip(&draws).map(|(&value, draws)| {
        let end = |q: f64| value + (quantile(draws, q) - value) * expansion;
        [value, end(0.025), end(0.975)]
    });
    let terms = design.terms();
    let term_name = |factors: &[usize]| factors.iter().map(|&f| FACTORS[f]).collect::<Vec<_>>().join(":");
    for term in &terms {
        for level in combinations(&design, levels, &term.factors) {
            let Some([effect, low, high]) = numbers.next().map(|numbers| numbers.map(f64::exp)) else { return };
            let (scene, cells, response) = (name.clone(), cells.to_owned(), response.to_owned());
            let term = term_name(&term.factors);
            outcome.effects.push(AuditEffectRow { scene, cells, response, term, level, effect, low, high });
        }
    }
    for term in terms.iter().map(|term| term_name(&term.factors)).chain([REST.to_owned()]) {
        let Some([share, low, high]) = numbers.next().map(|[share, low, high]| [share, low.max(0.0), high.min(1.0)])
        else {
            return;
        };
        let (scene, cells, response) = (name.clone(), cells.to_owned(), response.to_owned());
        outcome.shares.push(AuditShareRow { scene, cells, response, term, share, low, high });
    }
}

/// The names of a term's combinations of levels, the last factor fastest.
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
    rows: &[AuditRow],
    trees: &[AuditTreeRow],
    leaky: &BTreeSet<&str>,
) -> Vec<AuditCellRow> {
    let size = levels.design().cells();
    let mut found = Vec::new();
    for (scene, _) in scene_sets(&observed[0]) {
        let of_scene = |name: &str| scene == ALL || scene == name;
        let means = observed.each_ref().map(|observations| {
            let scenes: Vec<&[Cluster]> =
                observations.iter().filter(|(name, _)| of_scene(name)).map(|(_, c)| c.as_slice()).collect();
            (!scenes.is_empty()).then(|| mean_response(&scenes, size, |n| (0..n).collect()))
        });
        let mut facts = vec![(0, 0, 0.0, 0_u32, 0.0_f64); size];
        for row in rows.iter().filter(|row| of_scene(&row.scene)) {
            let Some(cell) = levels.cell(&row.levels()) else { continue };
            facts[cell].0 += row.touching;
            facts[cell].1 += row.missed;
        }
        for tree in trees.iter().filter(|tree| of_scene(&tree.scene)) {
            let Some(cell) = levels.cell(&tree.levels()) else { continue };
            facts[cell].2 += tree.outside_corners_pct;
            facts[cell].3 += 1;
            facts[cell].4 = facts[cell].4.max(tree.overhang_mm);
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
    found
}

#[cfg(test)]
mod tests;
