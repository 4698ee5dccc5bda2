//! Tests that planted costs are recovered.

use super::*;
use crate::analysis::table;
use crate::record::PROGRAM_TIME;
use crate::record::synthetic::{Plan, Run, SCENES};
use tempfile::TempDir;

fn observed(chunk: u32, volume_tests: f64, triangle_tests: f64, ns: f64) -> Observed {
    Observed { chunk, stratum: Stratum::Far, volume_tests, triangle_tests, ns }
}

#[test]
fn planted_costs_are_found() {
    // 50 + 20 Nv + 300 Np, without noise.
    let chunks: Vec<Observed> = [(1.0, 0.0), (100.0, 3.0), (400.0, 50.0), (20.0, 9.0)]
        .iter()
        .zip(0..)
        .map(|(&(v, t), chunk)| observed(chunk, v, t, 50.0 + 20.0 * v + 300.0 * t))
        .collect();
    let costs = fit(&chunks).unwrap();
    for (found, planted) in costs.iter().zip([50.0, 20.0, 300.0]) {
        assert!((found / planted - 1.0).abs() < 1e-6, "{costs:?}");
    }
}

#[test]
fn no_cost_is_below_zero() {
    // More triangle tests and less time: the free fit would give a triangle test a negative cost.
    let chunks = [observed(0, 10.0, 0.0, 1000.0), observed(1, 10.0, 5.0, 900.0), observed(2, 20.0, 1.0, 2000.0)];
    let costs = fit(&chunks).unwrap();
    assert_eq!(costs[2], 0.0);
    assert!(costs.iter().all(|cost| *cost >= 0.0) && costs[1] > 50.0, "{costs:?}");
}

#[test]
fn what_never_occurs_costs_nothing_and_nothing_has_no_costs() {
    let chunks = [observed(0, 1.0, 0.0, 30.0), observed(1, 3.0, 0.0, 70.0)];
    let costs = fit(&chunks).unwrap();
    assert!((costs[0] - 10.0).abs() < 1e-6 && (costs[1] - 20.0).abs() < 1e-6 && costs[2] == 0.0, "{costs:?}");
    assert_eq!(fit(&[]), None);
}

#[test]
fn deadlines_weigh_strata_equally() {
    let case = CaseKey { variant: "ball".into(), split: "median".into(), split_axes: "own".into(), leaf: 1 };
    let query = |stratum: Stratum, volume_tests: u64| Query {
        line: 0,
        touches: false,
        pose: 0,
        chunk: 0,
        stratum,
        volume_tests,
        triangle_tests: 0,
    };
    // One colliding query of 3 ms, and three far ones of 1 microsecond, at 1000 ns a test.
    let queries =
        [query(Stratum::Colliding, 3000), query(Stratum::Far, 1), query(Stratum::Far, 1), query(Stratum::Far, 1)];
    let (.., p999_ns, over) = deadline("mill", &case, &queries, [0.0, 1000.0, 0.0], 1.0).unwrap();
    assert!((over[0] - 0.5).abs() < 1e-12 && (over[1] - 0.5).abs() < 1e-12);
    assert_eq!((over[2], over[3], p999_ns), (0.0, 0.0, 3e6));
    let (.., slower) = deadline("mill", &case, &queries, [0.0, 1000.0, 0.0], 4.0).unwrap();
    assert!((slower[3] - 0.5).abs() < 1e-12);
    assert_eq!(deadline("mill", &case, &[], [1.0; 3], 1.0), None);
}

/// In a scene without programs recorded poses come before generated ones, as in the ranking. In the order of names, `random` would come first.
#[test]
fn a_scene_without_programs_repays_by_the_workload_that_ranks_it() {
    let mut run = Run::generate(&Plan::default());
    run.poses.retain(|row| row.workload != PROGRAM_TIME);
    let chunks: BTreeSet<(String, u32)> = run.poses.iter().map(|row| (row.scene.clone(), row.chunk)).collect();
    run.timings.retain(|row| chunks.contains(&(row.scene.clone(), row.chunk)));
    for row in &mut run.poses {
        let renamed = match row.workload.as_str() {
            "approach" => "random",
            "program" => "recorded",
            other => other,
        };
        row.workload = renamed.to_owned();
    }
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    let scene = &table::read(folder.path()).unwrap()[SCENES[0]];
    let case = CaseKey { variant: "aabb".into(), split: "vertex-mean".into(), split_axes: "own".into(), leaf: 1 };
    let mean = |workload| scene.mean_time(&case, Cell { workload, stratum: None }, 0).unwrap().interval.value;
    assert!(mean("recorded") < 0.2 * mean("random"));
    assert_eq!(mean_query(scene, &case), Some(mean("recorded")));
}
