//! Engines side by side: from the raw rows to `peers.csv` and `peer-ratios.csv`.
//!
//! The time of a chunk is the median over its rounds, or the sum of the separate times of its poses if that is less. Each pose's time is a
//! median and includes one reading of the clock. If the sum is less, something else interrupted the passes; long passes are interrupted
//! most, which would make slow engines look slower. A mean time is the sum over chunks divided by the number of poses. A ratio is the ratio
//! of mean times on the same chunks. Its interval is that of [`super::totals`], stratum by stratum, because poses of a chunk depend on one
//! another. Chunks that share a line are one cluster. A single cluster has no interval.

use super::grouped;
use super::stats::{Interval, median, quantile};
use super::totals::{Observation, Totals, clusters};
use crate::record::peers::ALL_STRATA;
use crate::record::{
    PeerAnswerRow, PeerBuildRow, PeerRatioRow, PeerRow, PeerTimingRow, RecordError, Stratum, merge_rows, read_rows,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Scene, mode.
pub type Setting = (String, String);

/// Pair, chunk.
type Chunk = (String, u32);

/// Stratum, poses, and the times of all rounds, ns.
type Rounds = (Stratum, u32, Vec<f64>);

/// An engine's chunks: stratum, poses, and median time of a pass, ns.
type Chunks = BTreeMap<Chunk, (Stratum, u32, f64)>;

/// Reads the raw rows of a folder and writes the derived tables beside them; returns what is new in them. The settings that are `due`, or all that have raw
/// rows, are derived anew, and compared with the first of `references` that took part. Rows of other settings stay. Intervals are drawn with `seed`.
///
/// # Errors
/// When a file cannot be read or written.
pub fn summarise(
    folder: &Path,
    references: &[String],
    seed: u64,
    due: Option<BTreeSet<Setting>>,
) -> Result<(Vec<PeerRow>, Vec<PeerRatioRow>), RecordError> {
    let (mut builds, mut timings, mut answers): (Vec<PeerBuildRow>, Vec<PeerTimingRow>, Vec<PeerAnswerRow>) =
        (read_rows(folder)?, read_rows(folder)?, read_rows(folder)?);
    let due = due.unwrap_or_else(|| engines(&timings).into_iter().map(|(setting, _)| setting).collect());
    let is_due = |scene: &str, mode: &str| due.iter().any(|(s, m)| s == scene && m == mode);
    builds.retain(|row| is_due(&row.scene, &row.mode));
    timings.retain(|row| is_due(&row.scene, &row.mode));
    answers.retain(|row| is_due(&row.scene, &row.mode));
    let rows = summary(&builds, &timings, &answers);
    let ratios = ratios(&timings, &answers, &rows, references, seed);
    merge_rows(folder, &rows, |row| !is_due(&row.scene, &row.mode))?;
    merge_rows(folder, &ratios, |row| !is_due(&row.scene, &row.mode))?;
    Ok((rows, ratios))
}

/// The strata that have a row: each stratum, and all together (`None`).
fn strata() -> impl Iterator<Item = Option<Stratum>> {
    std::iter::once(None).chain(Stratum::ALL.map(Some))
}

fn stratum_name(stratum: Option<Stratum>) -> String {
    stratum.map_or(ALL_STRATA, Stratum::id).to_owned()
}

/// Settings and engines, in the order of their first appearance.
fn engines(timings: &[PeerTimingRow]) -> Vec<(Setting, String)> {
    let mut seen = BTreeSet::new();
    let keys = timings.iter().map(|row| ((row.scene.clone(), row.mode.clone()), row.engine.clone()));
    keys.filter(|key| seen.insert(key.clone())).collect()
}

fn chunks_by_engine(timings: &[PeerTimingRow], answers: &[PeerAnswerRow]) -> BTreeMap<(Setting, String), Chunks> {
    let mut pose_by_pose: BTreeMap<_, f64> = BTreeMap::new();
    for row in answers {
        let key = (&row.scene, &row.mode, &row.engine, &row.pair, row.chunk);
        // A time of 0 was never taken.
        *pose_by_pose.entry(key).or_default() += if row.ns > 0 { row.ns as f64 } else { f64::INFINITY };
    }
    let mut times: BTreeMap<_, BTreeMap<Chunk, Rounds>> = BTreeMap::new();
    for row in timings {
        let engine = times.entry(((row.scene.clone(), row.mode.clone()), row.engine.clone())).or_default();
        let chunk = engine.entry((row.pair.clone(), row.chunk));
        chunk.or_insert_with(|| (row.stratum, row.poses, Vec::new())).2.push(row.ns as f64);
    }
    let of_engine = |(engine, chunks): ((Setting, String), BTreeMap<Chunk, Rounds>)| {
        let ((scene, mode), name) = &engine;
        let chunk = |(key, (stratum, poses, ns)): (Chunk, Rounds)| {
            let alone = pose_by_pose.get(&(scene, mode, name, &key.0, key.1)).copied().unwrap_or(f64::INFINITY);
            (key, (stratum, poses, median(ns).min(alone)))
        };
        let chunks: Chunks = chunks.into_iter().map(chunk).collect();
        (engine, chunks)
    };
    times.into_iter().map(of_engine).collect()
}

/// One row per setting, engine and stratum that has poses.
pub fn summary(builds: &[PeerBuildRow], timings: &[PeerTimingRow], answers: &[PeerAnswerRow]) -> Vec<PeerRow> {
    let chunks = chunks_by_engine(timings, answers);
    let mut rows = Vec::new();
    for (setting, engine) in engines(timings) {
        let is_ours = |e: &str, scene: &str, mode: &str| e == engine && scene == setting.0 && mode == setting.1;
        let answers: Vec<&PeerAnswerRow> =
            answers.iter().filter(|row| is_ours(&row.engine, &row.scene, &row.mode)).collect();
        let (build_ns, bytes, triangles) =
            construction(builds.iter().filter(|row| is_ours(&row.engine, &row.scene, &row.mode)));
        let Some(chunks) = chunks.get(&(setting.clone(), engine.clone())) else { continue };
        for stratum in strata() {
            let is_in = |other: Stratum| stratum.is_none_or(|stratum| stratum == other);
            let members = chunks.values().filter(|chunk| is_in(chunk.0));
            let (ns, poses) = members.fold((0.0, 0), |(ns, poses), chunk| (ns + chunk.2, poses + u64::from(chunk.1)));
            if poses == 0 {
                continue;
            }
            let answers: Vec<&&PeerAnswerRow> = answers.iter().filter(|row| is_in(row.stratum)).collect();
            let mut single: Vec<f64> = answers.iter().map(|row| row.ns as f64).collect();
            single.sort_unstable_by(f64::total_cmp);
            let wrong = |exact: u8| {
                let is_wrong = |row: &&&&PeerAnswerRow| row.grazing == 0 && row.exact == exact && row.touching != exact;
                answers.iter().filter(is_wrong).count() as u64
            };
            let errors = answers.iter().filter(|row| row.grazing == 0);
            let errors = errors.filter_map(|row| Some((row.value? - row.true_value?).abs()));
            rows.push(PeerRow {
                engine: engine.clone(),
                scene: setting.0.clone(),
                stratum: stratum_name(stratum),
                poses,
                mean_ns: ns / poses as f64,
                median_ns: quantile(&single, 0.5),
                p99_ns: quantile(&single, 0.99),
                false_negatives: wrong(1),
                false_positives: wrong(0),
                build_ns,
                bytes,
                triangles,
                mode: setting.1.clone(),
                largest_error: errors.reduce(f64::max),
            });
        }
    }
    rows
}

/// Median construction time, memory and number of triangles, each summed over pairs.
fn construction<'a>(builds: impl Iterator<Item = &'a PeerBuildRow>) -> (u64, u64, u64) {
    let mut pairs: BTreeMap<&str, (Vec<f64>, u64, u64)> = BTreeMap::new();
    for row in builds {
        let pair = pairs.entry(&row.pair).or_default();
        pair.0.push(row.ns as f64);
        (pair.1, pair.2) = (row.bytes, row.triangles);
    }
    pairs.into_values().fold((0, 0, 0), |(ns, bytes, triangles), pair| {
        (ns + median(pair.0) as u64, bytes + pair.1, triangles + pair.2)
    })
}

/// The clusters of chunks by scene, mode, and pair.
type Clusters<'a> = BTreeMap<(&'a str, &'a str, &'a str), BTreeMap<u32, u32>>;

fn clusters_by_pair(answers: &[PeerAnswerRow]) -> Clusters<'_> {
    let poses = grouped(answers.iter().map(|row| {
        let pair = (row.scene.as_str(), row.mode.as_str(), row.pair.as_str());
        (pair, (row.chunk, row.line))
    }));
    poses.into_iter().map(|(key, poses)| (key, clusters(poses))).collect()
}

/// Ratios of every engine to the first of `references` that took part, by setting; settings without a reference have none.
pub fn ratios(
    timings: &[PeerTimingRow],
    answers: &[PeerAnswerRow],
    rows: &[PeerRow],
    references: &[String],
    seed: u64,
) -> Vec<PeerRatioRow> {
    let (chunks, clusters) = (chunks_by_engine(timings, answers), clusters_by_pair(answers));
    let p99: BTreeMap<_, f64> =
        rows.iter().map(|row| ((&row.engine, &row.scene, &row.mode, &row.stratum), row.p99_ns)).collect();
    let mut found = Vec::new();
    for (setting, engine) in engines(timings) {
        let of = |engine: &str| chunks.get(&(setting.clone(), engine.to_owned()));
        let held_against = references.iter().find_map(|reference| Some((reference, of(reference)?)));
        let (Some(own), Some((reference, others))) = (of(&engine), held_against) else { continue };
        let cluster = |(pair, chunk): &Chunk| {
            let of_pair = clusters.get(&(setting.0.as_str(), setting.1.as_str(), pair.as_str()));
            of_pair.and_then(|of_pair| of_pair.get(chunk)).copied().unwrap_or(*chunk)
        };
        for stratum in strata() {
            let Some(totals) = Totals::of(paired(own, others, stratum, &cluster)) else { continue };
            let name = stratum_name(stratum);
            let estimate = totals.estimate(seed, &format!("{} {} {name}", setting.0, setting.1));
            let Interval { value, low, high } = match estimate.clusters {
                0 | 1 => Interval { low: f64::NAN, high: f64::NAN, ..estimate.interval },
                _ => estimate.interval,
            };
            let tail = |engine: &String| p99.get(&(engine, &setting.0, &setting.1, &name)).copied().unwrap_or(f64::NAN);
            found.push(PeerRatioRow {
                engine: engine.clone(),
                reference: reference.clone(),
                scene: setting.0.clone(),
                stratum: name.clone(),
                mode: setting.1.clone(),
                ratio: value,
                low,
                high,
                p99_ratio: tail(reference) / tail(&engine),
            });
        }
    }
    found
}

/// The times of the chunks that both engines have, or of those of one stratum: the other engine's over this engine's, ns. `cluster` gives the
/// cluster of a chunk within its pair.
fn paired(
    own: &Chunks,
    others: &Chunks,
    stratum: Option<Stratum>,
    cluster: &dyn Fn(&Chunk) -> u32,
) -> Vec<Observation> {
    let asked = own.iter().filter(|(_, chunk)| stratum.is_none_or(|stratum| stratum == chunk.0));
    let both =
        asked.filter_map(|(key, chunk)| Some(((key.0.as_str(), cluster(key)), chunk.0, others.get(key)?.2, chunk.2)));
    let both: Vec<_> = both.collect();
    let mut strata: BTreeMap<(&str, u32), BTreeSet<Stratum>> = BTreeMap::new();
    for (cluster, stratum, ..) in &both {
        strata.entry(*cluster).or_default().insert(*stratum);
    }
    let observations = both.iter().map(|&(cluster, stratum, numerator, denominator)| Observation {
        // Clusters that span strata are drawn as one.
        stratum: if strata[&cluster].len() > 1 { Stratum::ALL.len() as u32 } else { stratum as u32 },
        cluster: strata.range(..cluster).count() as u32,
        launch: 0,
        numerator,
        denominator,
    });
    observations.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(engine: &str, stratum: Stratum, chunk: u32, round: u32, ns: u64) -> PeerTimingRow {
        PeerTimingRow {
            engine: engine.into(),
            scene: "s".into(),
            pair: "a:b".into(),
            mode: "first".into(),
            stratum,
            chunk,
            poses: 2,
            round,
            ns,
        }
    }

    fn answer(pose: u32, exact: u8, grazing: u8, touching: u8, ns: u64) -> PeerAnswerRow {
        PeerAnswerRow {
            engine: "fast".into(),
            scene: "s".into(),
            pair: "a:b".into(),
            mode: "first".into(),
            pose,
            line: pose,
            chunk: pose / 2,
            stratum: if pose < 2 { Stratum::Colliding } else { Stratum::Far },
            exact,
            grazing,
            touching,
            value: (pose == 0).then_some(3.0),
            true_value: Some(5.0),
            ns,
        }
    }

    fn build(pair: &str, round: u32, ns: u64) -> PeerBuildRow {
        let (engine, scene, mode) = ("fast".into(), "s".into(), "first".into());
        PeerBuildRow { engine, scene, pair: pair.into(), mode, round, ns, bytes: 100, triangles: 7 }
    }

    fn timings() -> Vec<PeerTimingRow> {
        let (hit, far) = (Stratum::Colliding, Stratum::Far);
        vec![
            timing("fast", hit, 0, 0, 10),
            timing("fast", hit, 0, 1, 30),
            timing("fast", hit, 0, 2, 20),
            timing("fast", far, 1, 0, 4),
            timing("slow", hit, 0, 0, 80),
            timing("slow", far, 1, 0, 40),
        ]
    }

    /// Chunk 0: the median of 10, 30, 20 is 20, but its poses alone take 5 + 7 = 12. Chunk 1: 4, and its poses take 3 + 2. The mean is
    /// therefore (12 + 4) / 4 poses = 4 ns. Single poses take 5, 7, 3, 2: the median is 4, and the 99 % quantile at place 2.97 of 2, 3, 5,
    /// 7 is 5 + 0.97 × 2 = 6.94. Pose 1 is missed; pose 3 is wrong, but grazing.
    #[test]
    fn rows_by_hand() {
        let answers = [answer(0, 1, 0, 1, 5), answer(1, 1, 0, 0, 7), answer(2, 0, 0, 0, 3), answer(3, 0, 1, 1, 2)];
        let builds = [build("a:b", 0, 5), build("a:b", 1, 9), build("a:b", 2, 6), build("a:c", 0, 1)];
        let rows = summary(&builds, &timings(), &answers);
        let found: Vec<_> = rows.iter().map(|row| (row.engine.as_str(), row.stratum.as_str(), row.mean_ns)).collect();
        assert_eq!(found[..3], [("fast", "all", 4.0), ("fast", "colliding", 6.0), ("fast", "far", 2.0)]);
        assert_eq!(found[3..], [("slow", "all", 30.0), ("slow", "colliding", 40.0), ("slow", "far", 20.0)]);
        let all = &rows[0];
        assert_eq!((all.poses, all.median_ns), (4, 4.0));
        assert!((all.p99_ns - 6.94).abs() < 1e-12);
        assert_eq!((all.false_negatives, all.false_positives), (1, 0));
        assert_eq!((all.build_ns, all.bytes, all.triangles), (6 + 1, 200, 14));
        assert_eq!((all.largest_error, rows[2].largest_error), (Some(2.0), None)); // |3 - 5|
    }

    /// All strata: (80 + 40) / (20 + 4) = 5; colliding: 80 / 20 = 4; far: 40 / 4 = 10. A stratum of one chunk has no interval. The two strata
    /// together are two chunks of one stratum, which resamples of one of them alone give the ends 4 and 10, widened.
    #[test]
    fn ratios_by_hand() {
        let found = ratios(&timings(), &[], &[], &["nobody".to_owned(), "slow".to_owned()], 1);
        let of = |engine: &str| {
            let rows = found.iter().filter(move |row| row.engine == engine);
            rows.map(|row| (row.stratum.as_str(), row.ratio, row.low, row.high)).collect::<Vec<_>>()
        };
        let values: Vec<_> = of("fast").iter().map(|row| (row.0, row.1)).collect();
        assert_eq!(values, [("all", 5.0), ("colliding", 4.0), ("far", 10.0)]);
        let rows = of("fast");
        assert!(rows[0].2 < 4.0 && rows[0].3 > 10.0, "{rows:?}");
        assert!(rows[1..].iter().all(|row| row.2.is_nan() && row.3.is_nan()), "{rows:?}");
        assert!(of("slow").iter().all(|row| row.1 == 1.0));
        assert!(ratios(&timings(), &[], &[], &["nobody".to_owned()], 1).is_empty());
    }

    /// Chunks 0 and 1 on two lines are two clusters; on one line they are one, which has no interval. A time of 0 was never taken.
    #[test]
    fn chunks_that_share_a_line_are_one_cluster() {
        for (line, has_interval) in [(2, true), (0, false)] {
            let answers = [answer(0, 1, 0, 1, 0), PeerAnswerRow { line, ..answer(2, 0, 0, 0, 0) }];
            let found = ratios(&timings(), &answers, &[], &["slow".to_owned()], 1);
            let all = found.iter().find(|row| row.engine == "fast" && row.stratum == ALL_STRATA).unwrap();
            assert_eq!((all.ratio, all.low.is_finite(), all.high.is_finite()), (5.0, has_interval, has_interval));
        }
    }
}
