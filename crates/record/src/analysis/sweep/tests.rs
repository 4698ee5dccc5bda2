//! Tests on made-up sweeps with known means.

use super::*;
use crate::record::synthetic::{Plan, Run};
use tempfile::TempDir;

fn row(x: f64, group: u32, volume_tests: u64, missed: u64) -> CountRow {
    CountRow {
        poses: 10,
        queries: 40,
        volume_tests,
        triangle_tests: 80,
        touching: 10,
        missed,
        delay_mm: 5.0 * (10 - missed) as f64,
        ..CountRow::new(&format!("weight={x}"), "ball@median/own/1", 4 * group, Some(Stratum::Colliding))
    }
}

#[test]
fn metrics_are_means_over_groups() {
    let folder = TempDir::new().unwrap();
    let run = Run::generate(&Plan::default());
    run.manifest.write(folder.path()).unwrap();
    let case = CaseRow { case: "ball@median/own/1".into(), variant: "ball".into(), ..run.cases[0].clone() };
    write_rows(folder.path(), &[case]).unwrap();
    write_rows(
        folder.path(),
        &[0.5, 2.0, 4.0].map(|x| FactorRow::of_scene(&format!("weight={x}"), "weight", x.to_string())),
    )
    .unwrap();
    let mut rows = vec![row(0.5, 0, 400, 0), row(0.5, 1, 1200, 5), row(2.0, 0, 4000, 10)];
    rows.extend((0..6).map(|group| row(4.0, group, 400, 0)));
    write_rows(folder.path(), &rows).unwrap();
    let timing = |block: u32, ns: u64| TimingRow {
        scene: "weight=0.5".into(),
        case: "ball@median/own/1".into(),
        binary: 0,
        launch: 0,
        block,
        chunk: 0,
        passes: 2,
        ns,
    };
    write_rows(folder.path(), &[timing(0, 2000), timing(1, 2400), timing(2, 90_000)]).unwrap();
    let found = analyze_sweep(folder.path()).unwrap();
    let value = |x: f64, metric: &str| {
        let row = found.iter().find(|row| row.x == x && row.metric == metric);
        row.map(|row| (row.value, row.low, row.high))
    };
    // 400 / 40 and 1200 / 40.
    let (mean, low, high) = value(0.5, "volume-tests").unwrap();
    // Two groups: 20 ± 10·√2 · t / 1.96 with t = 12.706 at one degree of freedom, and not below all that was seen.
    assert_eq!((mean, low), (20.0, 10.0));
    assert!((high - 111.68).abs() < 0.01, "{high}");
    // Of one group the spread is not known.
    let (mean, low, high) = value(2.0, "volume-tests").unwrap();
    assert!(mean == 100.0 && low.is_nan() && high.is_nan(), "{low} {high}");
    assert_eq!(value(0.5, "triangle-tests").unwrap().0, 2.0);
    let (rate, low, high) = value(0.5, "miss-rate").unwrap();
    assert!(rate == 0.25 && low < 0.1 && high > 0.5, "{low} {high}"); // none and half
    assert_eq!(value(4.0, "miss-rate"), Some((0.0, 0.0, 0.5))); // none in six groups: at most 3/6
    assert_eq!(value(0.5, "delay").unwrap().0, 5.0); // over the contacts that were reported
    assert_eq!(value(2.0, "delay"), None); // none was
    assert_eq!(value(0.5, "time").unwrap().0, 120.0); // the median block: 2400 / 2 / 10
    assert_eq!(value(2.0, "time"), None);
}
