//! Agreement: exact engines asked about posed pairs by the million, and their answers compared.
//!
//! A contact that an engine reports rests on two triangles that touch by the exact test, so it is a proof for all engines: one that does not report
//! it has missed it. That nothing touches is as sure as the engines are independent of one another; at a share of the poses the exact truth, which
//! no engine helps to find, says so, too.
//!
//! The posed pairs come in rounds, one for each seed. A round is a unit: it is kept when it is whole, so that a run can be interrupted, and that the
//! `units` of several machines can be put into one folder. Poses along programs and recordings do not depend on the seed; they are asked in the first
//! round only.

use super::Progress;
use super::accuracy::is_asked;
use super::folder::write_unit;
use super::plan::{Case, Plan};
use super::run::MeasureError;
use super::shard::Shard;
use super::timer::Stopwatch;
use crate::geometry::Isometry;
use crate::method::Model;
use crate::record::{
    AgreementRow, Band, DisagreementRow, FolderLock, RecordError, RoundRow, read_json, read_rows, write_json,
    write_rows,
};
use crate::scene::{Pair, Scene};
use crate::truth::PairOracle;
use crate::workload::{self, PairPoses, PosedPair};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Poses that a thread takes at a time.
const BATCH: usize = 1024;
/// Most disagreements that a round keeps of a pair; all are counted.
const MOST_KEPT: usize = 1000;
/// File that says what a folder's rounds were asked for.
const REQUEST_FILE: &str = "request.json";

/// What is asked.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// Posed pairs of each scene in a round, about.
    pub poses: usize,
    /// How many of them the exact truth is asked about, spread evenly over the poses of each pair.
    pub exhaustive: usize,
    /// Seed of the first round; the others count up.
    pub first_seed: u64,
}

/// What the rounds of a folder have in common.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Request {
    program: String,
    /// BLAKE3 hash of its executable; empty when unknown, and in older folders.
    #[serde(default)]
    hash: String,
    /// Content hashes of everything the scenes were made from.
    inputs: BTreeMap<String, String>,
    cases: Vec<String>,
    asked: Asked,
}

impl Request {
    /// What differs from another request first.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let differences = [
            (self.program != other.program || self.hash != other.hash, "the program"),
            (self.inputs != other.inputs, "the scenes"),
            (self.cases != other.cases, "the variants"),
            (self.asked != other.asked, "the amount or the first seed"),
        ];
        differences.into_iter().find_map(|(differs, what)| differs.then_some(what))
    }
}

/// All that the rounds in a folder found.
#[derive(Clone, Debug, Default)]
pub struct Agreement {
    /// `agreement.csv`.
    pub rows: Vec<AgreementRow>,
    /// `disagreements.csv`.
    pub disagreements: Vec<DisagreementRow>,
    /// `rounds.csv`.
    pub rounds: Vec<RoundRow>,
}

/// A run of rounds in its folder.
pub struct AgreementRun {
    scenes: Vec<Scene>,
    cases: Vec<Case>,
    asked: Asked,
    folder: PathBuf,
    _lock: FolderLock,
}

/// One scene with the trees of its parts, by case and part.
struct Prepared<'a> {
    scene: &'a Scene,
    models: Vec<BTreeMap<usize, Box<dyn Model>>>,
}

impl AgreementRun {
    /// Opens a folder for rounds of the plan's scenes and of its variants, each with its own policy.
    ///
    /// # Errors
    /// When the folder holds rounds of another request, is in use, or cannot be written.
    pub fn open(plan: Plan, asked: Asked, folder: &Path) -> Result<Self, MeasureError> {
        let lock = FolderLock::take(folder)?;
        let cases: Vec<Case> = plan.variants.iter().map(Case::of).collect();
        let program = super::environment::program();
        let request = Request {
            program: program.version,
            hash: program.hash,
            inputs: plan.inputs(),
            cases: cases.iter().map(Case::name).collect(),
            asked: asked.clone(),
        };
        let path = folder.join(REQUEST_FILE);
        if path.exists() {
            let before: Request = read_json(&path)?;
            if let Some(difference) = before.difference(&request) {
                return Err(MeasureError::AnotherRun { folder: folder.to_owned(), difference });
            }
        } else {
            write_json(&path, &request)?;
        }
        Ok(Self { scenes: plan.scenes, cases, asked, folder: folder.to_owned(), _lock: lock })
    }

    /// Carries out the rounds of a shard, or all, but those that the folder has, and sums all that it has.
    ///
    /// # Errors
    /// When poses cannot be made, or a file cannot be read or written.
    pub fn run(&self, rounds: usize, shard: Option<Shard>, progress: &dyn Progress) -> Result<Agreement, MeasureError> {
        let missing: Vec<u64> = (0..rounds)
            .filter(|&round| shard.is_none_or(|shard| shard.has(round, rounds)))
            .map(|round| self.asked.first_seed + round as u64)
            .filter(|&seed| !self.unit(seed).exists())
            .collect();
        if !missing.is_empty() {
            progress.begin("trees", self.scenes.len() as u64);
            let scenes: Vec<Prepared> = self.scenes.iter().map(|scene| self.prepare(scene, progress)).collect();
            for seed in missing {
                self.round(seed, &scenes, progress)?;
            }
        }
        let all = self.sum()?;
        write_rows(&self.folder, &all.rows)?;
        write_rows(&self.folder, &all.disagreements)?;
        write_rows(&self.folder, &all.rounds)?;
        Ok(all)
    }

    fn units(&self) -> PathBuf {
        self.folder.join("units")
    }

    fn unit(&self, seed: u64) -> PathBuf {
        self.units().join(format!("seed-{seed:06}"))
    }

    fn prepare<'a>(&self, scene: &'a Scene, progress: &dyn Progress) -> Prepared<'a> {
        let parts: BTreeSet<usize> = scene.pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect();
        let prepared = |case: &Case, part: usize| case.variant.prepare(&scene.parts[part].mesh, case.policy);
        let of_case = |case: &Case| parts.iter().map(|&part| (part, prepared(case, part))).collect();
        let models = self.cases.iter().map(of_case).collect();
        progress.advance(1);
        Prepared { scene, models }
    }

    fn round(&self, seed: u64, scenes: &[Prepared], progress: &dyn Progress) -> Result<(), MeasureError> {
        let begun = Stopwatch::start();
        progress.begin(&format!("seed {seed}"), (scenes.len() * self.asked.poses) as u64);
        let mut found = Agreement::default();
        for prepared in scenes {
            let generate = if seed == self.asked.first_seed { workload::generate } else { workload::generate_drawn };
            let workloads = generate(prepared.scene, self.asked.poses, seed)?;
            let pairs: usize = workloads.iter().map(|workload| workload.pairs.len()).sum();
            for workload in &workloads {
                for posed in &workload.pairs {
                    let exhaustive = self.asked.exhaustive / pairs.max(1);
                    self.ask((seed, &workload.name), prepared, posed, exhaustive, &mut found);
                    progress.advance(posed.poses.len() as u64);
                }
            }
        }
        found.rounds = vec![round_row(seed, &found.rows, begun.seconds())];
        Ok(write_unit(&self.unit(seed), |folder| {
            write_rows(folder, &found.rows)?;
            write_rows(folder, &found.disagreements)?;
            write_rows(folder, &found.rounds)
        })?)
    }

    /// Asks all cases about the poses of a pair.
    fn ask(
        &self,
        (seed, workload): (u64, &str),
        prepared: &Prepared,
        posed: &PairPoses,
        exhaustive: usize,
        found: &mut Agreement,
    ) {
        let Pair { a, b } = posed.pair;
        let parts = &prepared.scene.parts;
        let oracle = PairOracle::new(Arc::clone(&parts[a].mesh), Arc::clone(&parts[b].mesh));
        let batches: Vec<Vec<Answered>> = posed
            .poses
            .par_chunks(BATCH)
            .enumerate()
            .map(|(batch, poses)| {
                let is_judged = |index: usize| is_asked(batch * BATCH + index, posed.poses.len(), exhaustive);
                answered(&prepared.models, posed.pair, poses, &oracle, &is_judged)
            })
            .collect();
        let scene = prepared.scene;
        let pair = scene.pair_name(posed.pair);
        let answers: Vec<&Answered> = batches.iter().flatten().collect();
        for (number, case) in self.cases.iter().enumerate() {
            let row = |band| AgreementRow {
                scene: scene.name.clone(),
                workload: workload.to_owned(),
                pair: pair.clone(),
                case: case.name(),
                band,
                ..counted(&answers, number, band)
            };
            found.rows.extend(Band::ALL.into_iter().map(row).filter(|row| row.poses > 0));
            let wrong = answers.iter().zip(&posed.poses).filter(|(answer, _)| answer.is_wrong(number));
            found.disagreements.extend(wrong.take(MOST_KEPT).map(|(answer, pose)| DisagreementRow {
                seed,
                scene: scene.name.clone(),
                workload: workload.to_owned(),
                pair: pair.clone(),
                line: answer.line,
                band: answer.band,
                case: case.name(),
                verdict: u8::from(answer.verdicts >> number & 1 == 1),
                against: if answer.truth.is_some() { "exact" } else { "engines" }.to_owned(),
                pose: bits(&pose.a_from_b),
            }));
        }
    }

    /// The sums of the rounds that the folder has, in the order of their seeds.
    fn sum(&self) -> Result<Agreement, MeasureError> {
        let units = self.units();
        let entries = std::fs::read_dir(&units).map_err(RecordError::io("read", &units))?;
        let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
        names.retain(|name| !name.to_string_lossy().ends_with(".partial"));
        names.sort_unstable();
        let (mut all, mut sums) = (Agreement::default(), BTreeMap::new());
        for name in names {
            let unit = units.join(name);
            for row in read_rows::<AgreementRow>(&unit)? {
                let (scene, workload, pair, case, band) = row.key();
                let key = (scene.to_owned(), workload.to_owned(), pair.to_owned(), case.to_owned(), band);
                sums.entry(key).and_modify(|sum: &mut AgreementRow| sum.add(&row)).or_insert(row);
            }
            all.disagreements.extend(read_rows::<DisagreementRow>(&unit)?);
            all.rounds.extend(read_rows::<RoundRow>(&unit)?);
        }
        all.rows = sums.into_values().collect();
        Ok(all)
    }
}

/// What the engines and, where it was asked, the exact truth say of a pose.
struct Answered {
    line: u32,
    band: Band,
    /// A bit for each case.
    verdicts: u64,
    /// The exact truth, where it was asked.
    truth: Option<bool>,
}

impl Answered {
    const fn touches(&self) -> bool {
        match self.truth {
            Some(touches) => touches,
            None => self.verdicts != 0,
        }
    }

    const fn is_wrong(&self, case: usize) -> bool {
        (self.verdicts >> case & 1 == 1) != self.touches()
    }
}

/// Most cases: each has a bit of its own in the answers.
pub const MOST_CASES: usize = 64;

fn answered(
    models: &[BTreeMap<usize, Box<dyn Model>>],
    pair: Pair,
    posed: &[PosedPair],
    oracle: &PairOracle,
    is_judged: &dyn Fn(usize) -> bool,
) -> Vec<Answered> {
    let poses: Vec<Isometry> = posed.iter().map(|pose| pose.a_from_b).collect();
    let mut bits = vec![0; poses.len()];
    let mut verdicts = Vec::with_capacity(poses.len());
    for (case, models) in models.iter().enumerate() {
        verdicts.clear();
        models[&pair.a].first(models[&pair.b].as_ref(), &poses, &mut verdicts);
        for (bits, &verdict) in bits.iter_mut().zip(&verdicts) {
            *bits |= u64::from(verdict) << case;
        }
    }
    let one = |(index, (pose, verdicts)): (usize, (&PosedPair, u64))| {
        let truth = is_judged(index).then(|| oracle.judge(&pose.a_from_b).witness.is_some());
        let mut answer = Answered { line: pose.cluster, band: Band::Clear, verdicts, truth };
        if answer.touches() {
            answer.band = pose.depth_mm.map_or(Band::Deep, Band::of_depth);
        }
        answer
    };
    posed.iter().zip(bits).enumerate().map(one).collect()
}

/// The counts of a case in a band; who and where is left empty.
fn counted(answers: &[&Answered], case: usize, band: Band) -> AgreementRow {
    let members: Vec<&&Answered> = answers.iter().filter(|answer| answer.band == band).collect();
    let count =
        |condition: &dyn Fn(&Answered) -> bool| members.iter().filter(|answer| condition(answer)).count() as u64;
    let mut lines: Vec<u32> = members.iter().map(|answer| answer.line).collect();
    lines.dedup();
    lines.sort_unstable();
    lines.dedup();
    AgreementRow {
        scene: String::new(),
        workload: String::new(),
        pair: String::new(),
        case: String::new(),
        band,
        lines: lines.len() as u64,
        poses: members.len() as u64,
        contacts: count(&|answer| answer.touches()),
        missed: count(&|answer| answer.touches() && answer.is_wrong(case)),
        exhaustive: count(&|answer| answer.truth.is_some()),
        false_positives: count(&|answer| !answer.touches() && answer.is_wrong(case)),
    }
}

fn round_row(seed: u64, rows: &[AgreementRow], seconds: f64) -> RoundRow {
    let first = rows.first().map_or("", |row| &row.case);
    let once = |count: fn(&AgreementRow) -> u64| rows.iter().filter(|row| row.case == first).map(count).sum();
    let all = |count: fn(&AgreementRow) -> u64| rows.iter().map(count).sum();
    RoundRow {
        seed,
        poses: once(|row| row.poses),
        verdicts: all(|row| row.poses),
        contacts: once(|row| row.contacts),
        exhaustive: once(|row| row.exhaustive),
        disagreements: all(|row| row.missed + row.false_positives),
        seconds,
    }
}

/// A pose bit by bit, as [`DisagreementRow::pose`] has it.
fn bits(pose: &Isometry) -> String {
    let numbers = pose.rotation.coords.iter().chain(pose.translation.vector.iter());
    numbers.map(|number| format!("{:016x}", number.to_bits())).collect::<Vec<_>>().join(" ")
}

/// The pose that [`bits`] wrote.
fn from_bits(text: &str) -> Option<Isometry> {
    let numbers = text.split(' ').map(|word| u64::from_str_radix(word, 16).ok().map(f64::from_bits));
    let [i, j, k, w, x, y, z] = numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()?;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
    Some(Isometry::from_parts(Translation3::new(x, y, z), rotation))
}

/// The verdicts of all variants of a plan, and the exact truth, at the pose of a disagreement.
///
/// # Errors
/// Why the row cannot be asked again: scene, pair or pose are not what they were.
pub fn replay(plan: &Plan, row: &DisagreementRow) -> Result<(Vec<(String, bool)>, bool), String> {
    let scene = plan.scenes.iter().find(|scene| scene.name == row.scene);
    let scene = scene.ok_or_else(|| format!("there is no scene `{}`", row.scene))?;
    let mut pairs = scene.pairs.iter().chain(&scene.random);
    let pair = pairs.find(|pair| scene.pair_name(**pair) == row.pair);
    let pair = pair.ok_or_else(|| format!("scene `{}` has no pair `{}`", row.scene, row.pair))?;
    let pose = from_bits(&row.pose).ok_or_else(|| format!("`{}` is no pose of seven numbers", row.pose))?;
    let meshes = [pair.a, pair.b].map(|part| &scene.parts[part].mesh);
    let verdict = |case: &Case| {
        let [a, b] = meshes.map(|mesh| case.variant.prepare(mesh, case.policy));
        let mut verdicts = Vec::new();
        a.first(b.as_ref(), &[pose], &mut verdicts);
        (case.name(), verdicts == [true])
    };
    let verdicts = plan.variants.iter().map(|variant| verdict(&Case::of(variant))).collect();
    let [a, b] = meshes.map(Arc::clone);
    Ok((verdicts, PairOracle::new(a, b).judge(&pose).witness.is_some()))
}

#[cfg(test)]
mod tests {
    use super::super::{Profile, Selection, Silent};
    use super::*;
    use crate::registry::{self, Registry};
    use crate::volume::Info;

    fn plan(registry: &Registry, variants: &[&str]) -> Plan {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let selection = Selection {
            profile: Profile::Smoke,
            scenes: names(&["lathe-toolpost"]),
            variants: names(variants),
            workloads: Vec::new(),
            policies: Vec::new(),
            seed: 1,
        };
        Plan::new(selection, registry).unwrap()
    }

    fn asked(exhaustive: usize) -> Asked {
        Asked { poses: 2000, exhaustive, first_seed: 5 }
    }

    #[test]
    fn exact_engines_agree_and_rounds_add_up_in_any_order() {
        let registry = registry::standard();
        let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let open = |folder: &Path| AgreementRun::open(plan(&registry, &["obb-wide", "aabb-wide"]), asked(100), folder);
        let all = open(whole.path()).unwrap().run(3, None, &Silent).unwrap();
        assert!(all.rows.iter().all(|row| row.missed == 0 && row.false_positives == 0));
        assert!(all.rows.iter().map(|row| row.contacts).sum::<u64>() > 1000);
        assert!(all.rounds.iter().all(|round| round.exhaustive > 50 && round.verdicts == 2 * round.poses));
        // A program's poses are the same with every seed.
        assert!(all.rounds[0].poses > all.rounds[1].poses);
        for number in [2, 1] {
            open(parts.path()).unwrap().run(3, Some(Shard { number, of: 2 }), &Silent).unwrap();
        }
        for file in ["agreement.csv", "disagreements.csv"] {
            let [one, other] = [&whole, &parts].map(|folder| std::fs::read(folder.path().join(file)).unwrap());
            assert!(one == other, "{file}");
        }
        // A folder has rounds of one request and of one program.
        let another = AgreementRun::open(plan(&registry, &["obb-wide"]), asked(100), whole.path());
        assert!(matches!(another, Err(MeasureError::AnotherRun { difference: "the variants", .. })));
        let path = whole.path().join(REQUEST_FILE);
        let request: Request = read_json(&path).unwrap();
        write_json(&path, &Request { hash: "another".to_owned(), ..request }).unwrap();
        assert!(matches!(open(whole.path()), Err(MeasureError::AnotherRun { difference: "the program", .. })));
    }

    /// 2400 random poses in rounds of twelve depths, of which the exact truth is asked about 200: a stride of twelve would meet one band alone.
    #[test]
    fn the_exact_truth_is_asked_in_every_band() {
        let registry = registry::standard();
        let folder = tempfile::tempdir().unwrap();
        let asked = Asked { poses: 4800, exhaustive: 600, first_seed: 5 };
        let run = AgreementRun::open(plan(&registry, &["obb-wide", "aabb-wide"]), asked, folder.path()).unwrap();
        let all = run.run(1, None, &Silent).unwrap();
        let random: Vec<&AgreementRow> = all.rows.iter().filter(|row| row.workload == "random").collect();
        assert!(random.len() >= 2 * 7); // two engines, in six bands of contacts and apart
        for row in random.iter().filter(|row| row.poses >= 100) {
            let (even, of) = (row.poses as f64 / 12.0, row.exhaustive as f64);
            assert!((of - even).abs() < even / 3.0, "{:?}: {of} of {}", row.band, row.poses);
        }
    }

    #[test]
    fn an_engine_that_misses_is_found_and_its_poses_can_be_asked_again() {
        // A volume that does not contain its triangles, and says that it is safe.
        let standard = registry::standard();
        let mut broken = *standard.variants().iter().find(|variant| variant.info.id == "obb-area-centroid").unwrap();
        broken.info = Info { id: "broken", safe: true, ..broken.info };
        let registry = standard.with(broken);
        for exhaustive in [0, 6000] {
            let folder = tempfile::tempdir().unwrap();
            let plan = plan(&registry, &["obb-wide", "broken"]);
            let all = AgreementRun::open(plan.clone(), asked(exhaustive), folder.path())
                .unwrap()
                .run(1, None, &Silent)
                .unwrap();
            let missed: u64 = all.rows.iter().map(|row| row.missed).sum();
            assert!(missed > 0 && all.rounds[0].disagreements == missed);
            assert!(all.rows.iter().all(|row| row.missed == 0 || row.case.starts_with("broken")));
            let row = &all.disagreements[0];
            assert_eq!((row.verdict, row.against.as_str()), (0, if exhaustive == 0 { "engines" } else { "exact" }));
            let (verdicts, touches) = replay(&plan, row).unwrap();
            assert_eq!(verdicts.iter().map(|(_, touching)| *touching).collect::<Vec<_>>(), [true, false]);
            assert!(touches);
            assert!(replay(&plan, &DisagreementRow { pose: "0 1".into(), ..row.clone() }).is_err());
        }
    }
}
