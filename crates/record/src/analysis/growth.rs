//! How costs grow with the size of the meshes: the exponent of a power law over the sweep of mesh size.
//!
//! Every group of lines gives one slope in each stratum, by least squares over the logarithms; for builds, every block gives one. The slopes of
//! a group depend on one another, so that a group counts with their mean. The exponent is the mean over groups, with a bootstrap interval over
//! them; a single group has none. The exponent of each stratum is told beside it.

use super::stats::{bootstrap_mean, mean};
use super::summary::ALL;
use super::sweep::Swept;
use super::{AnalysisError, distinct, grouped};
use crate::record::rows::CaseKey;
use crate::record::{BuildRow, CountRow, Row, Stratum, SweepGrowthRow, TimingRow, read_rows_if_there, write_rows};
use std::collections::BTreeMap;
use std::path::Path;

/// The costs whose growth is analysed, as records name them.
pub const COSTS: [&str; 4] = ["build", "time", "volume-tests", "triangle-tests"];
/// Fewest sizes from which a slope is computed.
const FEWEST_SIZES: usize = 3;

/// Identifies one slope: a group of lines and a stratum, or a block of builds.
type Unit = (u32, Option<Stratum>);
/// Observed costs by case, cost and unit, then by number of triangles (as bits).
type Costs = BTreeMap<(CaseKey, usize), BTreeMap<Unit, BTreeMap<u64, Vec<f64>>>>;

/// Fits the growth of every case over the mesh sizes in `folder` and writes `sweep_growth.csv`.
///
/// # Errors
/// When a record is missing or malformed.
pub(super) fn analyze_growth(folder: &Path, swept: &Swept, seed: u64) -> Result<Vec<SweepGrowthRow>, AnalysisError> {
    let mut costs = Costs::new();
    let mut order: Vec<CaseKey> = Vec::new();
    // A chunk of the same number is the same group and stratum at every size.
    let unit = |row: &CountRow| (row.chunk / Stratum::ALL.len() as u32, row.stratum);
    let mut add = |case: CaseKey, cost: usize, unit: Unit, triangles: f64, value: f64| {
        if value > 0.0 {
            let units = costs.entry((case, cost)).or_default();
            units.entry(unit).or_default().entry(triangles.to_bits()).or_default().push(value);
        }
    };
    for row in &swept.counts {
        let (x, case) = swept.place(CountRow::FILE, &row.scene, &row.case)?;
        if !order.contains(&case) {
            order.push(case.clone());
        }
        add(case.clone(), 2, unit(row), x, row.volume_tests as f64 / row.queries as f64);
        add(case, 3, unit(row), x, row.triangle_tests as f64 / row.queries as f64);
    }
    for (counted, timing, ns) in swept.samples()? {
        let (x, case) = swept.place(TimingRow::FILE, &timing.scene, &timing.case)?;
        add(case, 1, unit(counted), x, ns);
    }
    for row in read_rows_if_there::<BuildRow>(folder)? {
        let (x, case) = swept.place(BuildRow::FILE, &row.scene, &row.case().name())?;
        add(case, 0, (row.block, None), x, row.ns as f64);
    }
    let mut found = Vec::new();
    for case in order {
        for (cost, metric) in COSTS.into_iter().enumerate() {
            let Some(units) = costs.get(&(case.clone(), cost)) else { continue };
            let slopes: BTreeMap<Unit, f64> =
                units.iter().filter_map(|(unit, costs)| Some((*unit, slope(costs)?))).collect();
            let sizes = || units.values().flat_map(BTreeMap::keys).map(|&bits| f64::from_bits(bits) as u64);
            for (stratum, slopes) in by_stratum(&slopes) {
                let exponent = bootstrap_mean(&slopes, seed, &format!("growth {metric}"));
                found.push(SweepGrowthRow {
                    sweep: swept.sweep.clone(),
                    variant: case.variant.clone(),
                    split: case.split.clone(),
                    split_axes: case.split_axes.clone(),
                    leaf: case.leaf,
                    stratum: stratum.map_or(ALL, Stratum::id).to_owned(),
                    metric: metric.to_owned(),
                    from_triangles: sizes().min().unwrap_or(0),
                    to_triangles: sizes().max().unwrap_or(0),
                    exponent: exponent.value,
                    low: exponent.low,
                    high: exponent.high,
                });
            }
        }
    }
    write_rows(folder, &found)?;
    Ok(found)
}

/// The slopes of all strata together, then those of each stratum if there are several. All strata together have one slope for each group: its mean over the
/// strata, if it has a slope in every one. Sets without a slope are left out.
fn by_stratum(slopes: &BTreeMap<Unit, f64>) -> Vec<(Option<Stratum>, Vec<f64>)> {
    let strata = distinct(slopes.keys().map(|(_, stratum)| *stratum));
    let groups = grouped(slopes.iter().map(|((group, _), slope)| (*group, *slope)));
    let whole = groups.into_values().filter(|of_group| of_group.len() == strata.len());
    let mut found = vec![(None, whole.map(|of_group| mean(&of_group)).collect::<Vec<f64>>())];
    if strata.len() > 1 {
        let of = |stratum: Option<Stratum>| {
            let of_it = slopes.iter().filter(|(unit, _)| unit.1 == stratum);
            of_it.map(|(_, slope)| *slope).collect::<Vec<f64>>()
        };
        found.extend(strata.into_iter().map(|stratum| (stratum, of(stratum))));
    }
    found.retain(|(_, slopes)| !slopes.is_empty());
    found
}

/// The slope of a straight line through the logarithms of the costs over the logarithms of the sizes. Several costs at one size count by
/// their geometric mean. `None` when there are too few sizes.
fn slope(costs: &BTreeMap<u64, Vec<f64>>) -> Option<f64> {
    let mean_log = |values: &Vec<f64>| values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64;
    let points: Vec<(f64, f64)> = costs.iter().map(|(&bits, of)| (f64::from_bits(bits).ln(), mean_log(of))).collect();
    if points.len() < FEWEST_SIZES {
        return None;
    }
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let (along, square) = points
        .iter()
        .fold((0.0, 0.0), |(along, square), p| (along + (p.0 - x) * (p.1 - y), square + (p.0 - x) * (p.0 - x)));
    Some(along / square)
}

#[cfg(test)]
mod tests {
    use super::super::sweep::analyze_sweep;
    use super::*;
    use crate::record::synthetic::{Plan, Run};
    use crate::record::{CaseRow, FactorRow, Stratum, read_rows};

    #[test]
    fn a_power_law_gives_its_exponent() {
        let of = |exponent: f64, sizes: &[f64]| {
            let cost = |x: &f64| (x.to_bits(), vec![2.0 * 3.0 * x.powf(exponent), 1.5 * x.powf(exponent)]);
            slope(&sizes.iter().map(cost).collect())
        };
        for exponent in [-0.5, 0.0, 0.4, 1.1] {
            let found = of(exponent, &[1e3, 2e4, 7e5, 1e6]).unwrap();
            assert!((found - exponent).abs() < 1e-12, "{found}");
        }
        assert_eq!(of(1.0, &[1e3, 1e6]), None);
    }

    /// Two groups whose slopes go together: 0.1 and 0.3 in contact, 0.2 and 0.4 near it. A group counts once, with its mean; a third group without
    /// a slope near contact counts there alone where it has one.
    #[test]
    fn a_group_of_lines_counts_once() {
        let (hit, near) = (Some(Stratum::Colliding), Some(Stratum::NearMiss));
        let slopes = [(0, hit, 0.1), (0, near, 0.2), (1, hit, 0.3), (1, near, 0.4), (2, hit, 0.8)];
        let slopes = slopes.map(|(group, stratum, slope)| ((group, stratum), slope)).into_iter().collect();
        let found = by_stratum(&slopes);
        let strata: Vec<_> = found.iter().map(|(stratum, slopes)| (*stratum, slopes.len())).collect();
        assert_eq!(strata, [(None, 2), (hit, 3), (near, 2)]);
        assert!((found[0].1[0] - 0.15).abs() < 1e-12 && (found[0].1[1] - 0.35).abs() < 1e-12, "{found:?}");
        assert_eq!(by_stratum(&BTreeMap::from([((0, None), 1.0), ((1, None), 1.1)])), [(None, vec![1.0, 1.1])]);
        assert!(by_stratum(&BTreeMap::new()).is_empty());
    }

    #[test]
    fn growth_is_told_of_builds_and_queries() {
        let folder = tempfile::tempdir().unwrap();
        let (mut counted, mut timed, mut built) = (Vec::new(), Vec::new(), Vec::new());
        let case = CaseRow { case: "ball@median/own/1".into(), ..Run::generate(&Plan::default()).cases[0].clone() };
        let case =
            CaseRow { variant: "ball".into(), split: "median".into(), split_axes: "own".into(), leaf: 1, ..case };
        let mut factors = Vec::new();
        for (triangles, block) in [1000.0, 10_000.0, 100_000.0].into_iter().flat_map(|x: f64| [(x, 0), (x, 1)]) {
            let scene = format!("size={triangles}");
            factors.push(FactorRow::of_scene(&scene, "size", triangles.to_string()));
            built.push(BuildRow {
                scene: scene.clone(),
                part: "both".into(),
                variant: case.variant.clone(),
                split: case.split.clone(),
                split_axes: case.split_axes.clone(),
                leaf: case.leaf,
                triangles: triangles as u64,
                binary: 0,
                launch: 0,
                block,
                ns: (triangles * 100.0) as u64,
            });
            timed.push(TimingRow {
                scene: scene.clone(),
                case: case.case.clone(),
                binary: 0,
                launch: 0,
                block: 0,
                chunk: 4 * block,
                passes: 2,
                ns: (triangles.sqrt() * 1e6) as u64,
            });
            let counts = CountRow::new(&scene, &case.case, 4 * block, Some(Stratum::Colliding));
            counted.push(CountRow { poses: 4, queries: 4, volume_tests: 40, ..counts });
        }
        Run::generate(&Plan::default()).manifest.write(folder.path()).unwrap();
        write_rows(folder.path(), &[case]).unwrap();
        write_rows(folder.path(), &factors).unwrap();
        write_rows(folder.path(), &counted).unwrap();
        write_rows(folder.path(), &timed).unwrap();
        write_rows(folder.path(), &built).unwrap();
        analyze_sweep(folder.path()).unwrap();
        let found: Vec<SweepGrowthRow> = read_rows(folder.path()).unwrap();
        let told: Vec<_> = found.iter().map(|row| (&*row.metric, (row.exponent * 1e6).round() / 1e6)).collect();
        // No triangle was ever tested: nothing to say of that.
        assert_eq!(told, [("build", 1.0), ("time", 0.5), ("volume-tests", 0.0)]);
        assert!(found.iter().all(|row| (row.from_triangles, row.to_triangles) == (1000, 100_000)));
        assert!(found.iter().all(|row| row.low <= row.exponent + 1e-9 && row.exponent <= row.high + 1e-9));
    }
}
