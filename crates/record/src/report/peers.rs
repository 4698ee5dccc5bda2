//! The report's section on whole engines, if the run's folder has such a comparison.

use super::tables::{Table, interval, number};
use crate::record::peers::ALL_STRATA;
use crate::record::{PeerRatioRow, PeerRow};
use std::collections::BTreeSet;

/// One table per scene and mode, fastest engine first; empty without rows.
pub(super) fn section(rows: &[PeerRow], ratios: &[PeerRatioRow]) -> String {
    let settings: BTreeSet<(&str, &str)> = rows.iter().map(|row| (row.scene.as_str(), row.mode.as_str())).collect();
    if settings.is_empty() {
        return String::new();
    }
    let mut text = "## Whole engines\n\nOther libraries' engines and our variants on the same poses, each in a process of its own, \
                    in turn within every round, on one thread. Times faster compare mean times and have 95 % intervals; missed and \
                    false contacts are against exact truth, grazing poses left out. A name with `refit` marks an engine that \
                    fits its tree again at each query. See `docs/adding-a-peer.md`.\n\n"
        .to_owned();
    for (scene, mode) in settings {
        let ratio_of = |engine: &str| {
            let is_wanted = |row: &&PeerRatioRow| {
                (row.scene.as_str(), row.mode.as_str(), row.engine.as_str()) == (scene, mode, engine)
                    && row.stratum == ALL_STRATA
            };
            ratios.iter().find(is_wanted)
        };
        let mut here: Vec<&PeerRow> =
            rows.iter().filter(|row| row.scene == scene && row.mode == mode && row.stratum == ALL_STRATA).collect();
        here.sort_by(|x, y| x.mean_ns.total_cmp(&y.mean_ns));
        let reference = here.iter().find_map(|row| ratio_of(&row.engine)).map_or("-", |ratio| &ratio.reference);
        let faster = format!(">times faster than {reference}");
        let mut table = Table::new(&[
            "engine",
            ">mean us",
            &faster,
            ">p99 us",
            ">missed",
            ">false",
            ">build ms",
            ">bytes/triangle",
        ]);
        for row in here {
            let ratio = ratio_of(&row.engine);
            table.row([
                format!("`{}`", row.engine),
                number(row.mean_ns / 1e3),
                interval(ratio.map(|r| r.ratio), ratio.map(|r| r.low), ratio.map(|r| r.high)),
                number(row.p99_ns / 1e3),
                row.false_negatives.to_string(),
                row.false_positives.to_string(),
                number(row.build_ns as f64 / 1e6),
                if row.bytes == 0 { "-".to_owned() } else { format!("{:.0}", row.bytes as f64 / row.triangles as f64) },
            ]);
        }
        text += &format!("### {scene}, mode `{mode}`\n\n{}", table.finish());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_engine_stands_first() {
        let row = |engine: &str, mean_ns: f64, stratum: &str| PeerRow {
            engine: engine.into(),
            scene: "s".into(),
            stratum: stratum.into(),
            poses: 8,
            mean_ns,
            median_ns: 1.0,
            p99_ns: 2.0 * mean_ns,
            false_negatives: 3,
            false_positives: 0,
            build_ns: 1_500_000,
            bytes: 0,
            triangles: 10,
            mode: "first".into(),
            largest_error: None,
        };
        let ratio = PeerRatioRow {
            engine: "fast".into(),
            reference: "slow".into(),
            scene: "s".into(),
            stratum: "all".into(),
            mode: "first".into(),
            ratio: 20.0,
            low: 18.0,
            high: 22.0,
            p99_ratio: 20.0,
        };
        let text = section(&[row("slow", 4e4, "all"), row("fast", 2e3, "all"), row("fast", 1e3, "far")], &[ratio]);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with('|')).collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines[0].contains("times faster than slow"));
        assert_eq!(lines[2], "| `fast` | 2.000 | 20.0 [18.0, 22.0] | 4.000 | 3 | 0 | 1.500 | - |");
        assert_eq!(lines[3], "| `slow` | 40.0 |  | 80.0 | 3 | 0 | 1.500 | - |");
        assert_eq!(section(&[], &[]), "");
    }
}
