//! A made-up run for the tests of the analysis, the plots and the report: plausible in shape, with effects planted in it.
//! No number here was measured.

use crate::record::manifest::{MachineFacts, Program, Request, SceneEntry, Stage, VariantEntry};
use crate::record::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::BTreeMap;
use std::path::Path;

/// A case with its planted properties.
#[derive(Clone, Copy)]
pub(crate) struct Planted {
    pub id: &'static str,
    pub label: &'static str,
    pub kind: Kind,
    pub safe: bool,
    pub policies: &'static [&'static str],
    /// Time, volume tests and build time relative to the plain box.
    pub time: f64,
    pub build: f64,
    /// Volume over hull volume at the root.
    pub loose: f64,
    /// Share of shallow contacts missed.
    pub missed: f64,
}

const VERTEX: &[&str] = &["vertex-mean/own/1", "median/shared/1"];
const AREA: &[&str] = &["area-mean/own/1", "median/shared/1"];
const ONE: &[&str] = &["vertex-mean/own/1"];

const fn volume(
    id: &'static str,
    label: &'static str,
    policies: &'static [&'static str],
    time: f64,
    build: f64,
    loose: f64,
) -> Planted {
    Planted { id, label, kind: Kind::Volume, safe: true, policies, time, build, loose, missed: 0.0 }
}

/// The variants of the synthetic run; the last volume is one that no file of bvbench names.
pub(crate) const PLANTED: [Planted; 12] = [
    volume("sphere-ritter", "sphere (Ritter)", ONE, 3.0, 0.4, 4.0),
    volume("aabb", "AABB", ONE, 1.6, 0.3, 2.2),
    volume("dop-8", "8-DOP", ONE, 1.9, 0.6, 2.6),
    volume("obb-vertex", "plain OBB", VERTEX, 1.0, 1.0, 1.9),
    volume("obb-area", "area-weighted OBB", AREA, 0.8, 1.1, 1.4),
    Planted {
        safe: false,
        missed: 0.3,
        ..volume("obb-vertex-centroid", "plain OBB, centred on the mean", ONE, 0.7, 1.0, 1.9)
    },
    Planted {
        safe: false,
        missed: 0.1,
        ..volume("obb-area-centroid", "area-weighted OBB, centred on the mean", &["area-mean/own/1"], 0.6, 1.1, 1.4)
    },
    volume("obb-vertex-symmetric", "plain OBB, symmetric", ONE, 1.5, 1.0, 3.1),
    volume("obb-area-symmetric", "area-weighted OBB, symmetric", &["area-mean/own/1"], 1.5, 1.1, 1.8),
    volume("ellipsoid", "a reader's ellipsoid", ONE, 2.4, 0.9, 3.0),
    Planted { kind: Kind::Control, policies: &[], ..volume("brute", "brute force", &[], 40.0, 0.05, 1.0) },
    Planted {
        kind: Kind::Peer,
        safe: false,
        policies: &[],
        ..volume("parry-trimesh", "parry TriMesh (whole system)", &[], 1.2, 0.7, 1.0)
    },
];

/// How large and how noisy the run is.
#[derive(Clone, Copy)]
pub(crate) struct Plan {
    pub seed: u64,
    pub launches: u32,
    /// Binaries that take turns.
    pub binaries: u32,
    pub blocks: u32,
    pub chunks: u32,
    /// Standard deviation of the log of a single timing about.
    pub noise: f64,
}

impl Default for Plan {
    fn default() -> Self {
        Self { seed: 1, launches: 3, binaries: 1, blocks: 4, chunks: 4, noise: 0.005 }
    }
}

/// All records that the measuring side writes.
pub(crate) struct Run {
    pub manifest: Manifest,
    pub cases: Vec<CaseRow>,
    pub poses: Vec<PoseRow>,
    pub answers: Vec<AnswerRow>,
    pub lines: Vec<LineRow>,
    pub misses: Vec<MissRow>,
    pub verification: Vec<VerificationRow>,
    pub trees: Vec<TreeRow>,
    pub tightness: Vec<TightnessRow>,
    pub outlines: Vec<OutlineRow>,
    pub builds: Vec<BuildRow>,
    pub timings: Vec<TimingRow>,
}

pub(crate) const SCENES: [&str; 2] = ["lathe-toolpost", "lathe-tailstock"];
/// Workloads, from the one with the longest to the one with the shortest queries.
pub(crate) const WORKLOADS: [&str; 2] = ["approach", "program"];
/// Programs; the first ends in a collision.
const PROGRAMS: [&str; 2] = ["crash.ngc", "clear.ngc"];
/// Lines of the verification with contacts.
const LINES: u32 = 3000;
const PARTS: [&str; 2] = ["tool", "obstacle"];
const POSES: u32 = 8;

/// What a chunk of the run is.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Sample(&'static str, Stratum),
    Control,
    Program(&'static str),
}

impl Place {
    const fn poses(self) -> u32 {
        match self {
            Self::Sample(..) => POSES,
            Self::Control => 1,
            Self::Program(_) => 5 * POSES,
        }
    }

    const fn workload(self) -> &'static str {
        match self {
            Self::Sample(workload, _) => workload,
            Self::Control => CONTROL_WORKLOAD,
            Self::Program(_) => PROGRAM_TIME,
        }
    }

    /// About the time of a query of the plain box.
    fn base_ns(self) -> f64 {
        match self {
            Self::Sample(workload, stratum) => {
                let slow = if workload == WORKLOADS[0] { 1.0 } else { 0.1 };
                slow * [4000.0, 6000.0, 1500.0, 150.0][stratum as usize]
            }
            Self::Control => 4000.0,
            Self::Program(_) => 200.0,
        }
    }
}

impl Plan {
    /// Chunks of a scene: of each workload and stratum, four of the control, the programs.
    const fn all_chunks(&self) -> u32 {
        self.chunks * 4 * WORKLOADS.len() as u32 + 4 + PROGRAMS.len() as u32
    }

    fn place(&self, chunk: u32) -> Place {
        let sampled = self.chunks * 4 * WORKLOADS.len() as u32;
        match chunk.checked_sub(sampled) {
            None => {
                let workload = WORKLOADS[(chunk / (self.chunks * 4)) as usize];
                Place::Sample(workload, Stratum::ALL[(chunk % (self.chunks * 4) / self.chunks) as usize])
            }
            Some(0..4) => Place::Control,
            Some(place) => Place::Program(PROGRAMS[place as usize - 4]),
        }
    }
}

fn case_name(planted: &Planted, (split, split_axes, leaf): &(String, String, u8)) -> String {
    let (split, split_axes) = (split.clone(), split_axes.clone());
    rows::CaseKey { variant: planted.id.into(), split, split_axes, leaf: *leaf }.name()
}

impl Planted {
    /// Its cases: (split, axes, leaf), the default one first.
    fn cases(&self) -> Vec<(String, String, u8)> {
        if self.policies.is_empty() {
            return vec![("none".into(), "none".into(), 0)];
        }
        let split = |policy: &&str| {
            let parts: Vec<&str> = policy.split('/').collect();
            (parts[0].to_owned(), parts[1].to_owned(), parts[2].parse().unwrap())
        };
        self.policies.iter().map(split).collect()
    }
}

/// The variants with the null duplicate behind them.
fn timed() -> Vec<Planted> {
    let area = PLANTED[4];
    PLANTED.into_iter().chain([Planted { id: NULL_VARIANT, label: "null", policies: &AREA[..1], ..area }]).collect()
}

impl Run {
    pub(crate) fn generate(plan: &Plan) -> Self {
        let mut run = Self {
            manifest: manifest(plan),
            cases: Vec::new(),
            poses: Vec::new(),
            answers: Vec::new(),
            lines: Vec::new(),
            misses: Vec::new(),
            verification: Vec::new(),
            trees: Vec::new(),
            tightness: Vec::new(),
            outlines: Vec::new(),
            builds: Vec::new(),
            timings: Vec::new(),
        };
        let mut rng = Pcg64::seed_from_u64(plan.seed);
        run.cases();
        for scene in SCENES {
            run.poses(plan, scene);
            run.timings(plan, scene, &mut rng);
            run.counts(plan, scene);
            run.trees(scene);
            run.outlines(scene);
        }
        run
    }

    fn cases(&mut self) {
        let null_of = case_name(&PLANTED[4], &PLANTED[4].cases()[0]);
        for planted in timed() {
            for (place, case) in planted.cases().into_iter().enumerate() {
                let (split, split_axes, leaf) = case.clone();
                self.cases.push(CaseRow {
                    case: case_name(&planted, &case),
                    variant: planted.id.into(),
                    label: planted.label.into(),
                    kind: planted.kind,
                    safe: u8::from(planted.safe),
                    split,
                    split_axes,
                    leaf,
                    default: u8::from(place == 0),
                    asked_everywhere: u8::from(!planted.safe),
                    duplicate_of: if planted.id == NULL_VARIANT { null_of.clone() } else { String::new() },
                });
            }
        }
    }

    /// The poses of every chunk, each chunk on a line of its own: workload by workload, stratum by stratum, then the programs.
    fn poses(&mut self, plan: &Plan, scene: &str) {
        for chunk in 0..plan.all_chunks() {
            let place = plan.place(chunk);
            let touches = match place {
                Place::Sample(_, stratum) => stratum == Stratum::Colliding,
                Place::Control | Place::Program(_) => false,
            };
            for step in 0..place.poses() {
                let ends = place == Place::Program(PROGRAMS[0]) && step + 1 == place.poses();
                self.poses.push(PoseRow {
                    scene: scene.into(),
                    pose: self.poses.iter().filter(|row| row.scene == scene).count() as u32,
                    pair: "tool:obstacle".into(),
                    workload: place.workload().into(),
                    program: if let Place::Program(file) = place { file.into() } else { String::new() },
                    line: chunk,
                    step: chunk * POSES + step,
                    chunk,
                    stratum: if let Place::Sample(_, stratum) = place { stratum } else { Stratum::Far },
                    band: if touches || ends { Band::Millimetre } else { Band::Clear },
                    clearance_mm: Some(if touches || ends { 0.0 } else { 5.0 }),
                    exact: u8::from(touches || ends),
                    contained: 0,
                    judged: None,
                });
            }
        }
    }

    fn timings(&mut self, plan: &Plan, scene: &str, rng: &mut Pcg64) {
        for launch in 0..plan.launches {
            for block in 0..plan.blocks {
                for chunk in 0..plan.all_chunks() {
                    let place = plan.place(chunk);
                    let base = place.base_ns() * f64::from(1 + chunk % 3);
                    for planted in timed() {
                        let is_control = planted.kind == Kind::Control;
                        if is_control != (place == Place::Control)
                            && !(place == Place::Control && planted.id == "obb-vertex")
                        {
                            continue;
                        }
                        for case in planted.cases() {
                            let noise: f64 =
                                (0..4).map(|_| rng.random_range(-1.0..1.0)).sum::<f64>() * 0.87 * plan.noise;
                            let ns = base * planted.time * f64::from(place.poses()) * noise.exp();
                            self.timings.push(TimingRow {
                                scene: scene.into(),
                                case: case_name(&planted, &case),
                                binary: launch % plan.binaries,
                                launch,
                                block,
                                chunk,
                                passes: 1,
                                ns: ns as u64,
                            });
                        }
                    }
                }
                for part in PARTS {
                    for planted in timed().into_iter().filter(|p| p.id != NULL_VARIANT) {
                        for (split, split_axes, leaf) in planted.cases() {
                            self.builds.push(BuildRow {
                                scene: scene.into(),
                                part: part.into(),
                                variant: planted.id.into(),
                                split,
                                split_axes,
                                leaf,
                                triangles: 8000,
                                binary: launch % plan.binaries,
                                launch,
                                block,
                                ns: (2e7 * planted.build * (1.0 + plan.noise * rng.random_range(-1.0..1.0))) as u64,
                            });
                        }
                    }
                }
            }
        }
    }

    fn counts(&mut self, plan: &Plan, scene: &str) {
        let poses: Vec<PoseRow> = self.poses.iter().filter(|row| row.scene == scene).cloned().collect();
        for planted in PLANTED {
            for case in planted.cases() {
                for row in &poses {
                    let place = plan.place(row.chunk);
                    let is_control = planted.kind == Kind::Control;
                    let is_volume_there = place == Place::Control && planted.id == "obb-vertex";
                    let counted = matches!(place, Place::Sample(..)) && !is_control;
                    if !(counted || is_volume_there || (is_control && place == Place::Control)) {
                        continue;
                    }
                    let tests = place.base_ns() / 20.0 * planted.time;
                    self.answers.push(AnswerRow {
                        scene: scene.into(),
                        case: case_name(&planted, &case),
                        pose: row.pose,
                        verdict: row.exact,
                        volume_tests: match planted.kind {
                            Kind::Volume => tests as u64 + u64::from(row.pose % 5),
                            _ => 0,
                        },
                        triangle_tests: match planted.kind {
                            Kind::Volume | Kind::Engine | Kind::Sampling => (tests / 8.0) as u64 + 1,
                            Kind::Control => 64_000_000,
                            Kind::Peer => 0,
                        },
                    });
                }
                self.verdicts(scene, &planted, &case);
            }
        }
        // Lines of ten contacts, half of them in the sample: none missed on so many is at most 0.001.
        self.lines.extend((0..LINES).map(|line| LineRow {
            scene: scene.into(),
            workload: "approach".into(),
            pair: "tool:obstacle".into(),
            line,
            contacts: 10,
            sampled: 5,
        }));
    }

    /// What one case misses in each band, and on the first lines.
    fn verdicts(&mut self, scene: &str, planted: &Planted, case: &(String, String, u8)) {
        let (split, split_axes, leaf) = case.clone();
        let mut total = 0;
        for (depth, band) in Band::ALL.into_iter().enumerate() {
            let touching = if band == Band::Clear { 0 } else { 1000 };
            let missed = (planted.missed * 1000.0 / (depth + 1) as f64) as u64 * u64::from(touching > 0);
            total += if band.is_above_grazing() { missed } else { 0 };
            self.verification.push(VerificationRow {
                scene: scene.into(),
                workload: "approach".into(),
                pair: "tool:obstacle".into(),
                variant: planted.id.into(),
                split: split.clone(),
                split_axes: split_axes.clone(),
                leaf,
                safe: u8::from(planted.safe),
                band,
                poses: 1000,
                asked: 1000,
                asked_exact: touching,
                asked_missed: missed,
                exact: touching,
                brute: touching,
                tree: touching - missed,
                missed_by_volume: missed,
                missed_by_leaf: 0,
                missed,
                false_positives: 0,
            });
        }
        let of_line = |line: u64| total.saturating_sub(10 * line).min(10);
        self.misses.extend((0..u64::from(LINES)).filter(|line| of_line(*line) > 0).map(|line| MissRow {
            scene: scene.into(),
            case: case_name(planted, case),
            workload: "approach".into(),
            pair: "tool:obstacle".into(),
            line: line as u32,
            missed: of_line(line),
            missed_asked: of_line(line),
        }));
    }

    fn trees(&mut self, scene: &str) {
        for planted in PLANTED.into_iter().filter(|p| p.kind == Kind::Volume) {
            for ((split, split_axes, leaf), part) in
                planted.cases().into_iter().flat_map(|c| PARTS.map(|p| (c.clone(), p)))
            {
                let centred = planted.id.contains("centroid") || planted.id.contains("symmetric");
                self.trees.push(TreeRow {
                    scene: scene.into(),
                    part: part.into(),
                    variant: planted.id.into(),
                    split: split.clone(),
                    split_axes: split_axes.clone(),
                    leaf,
                    triangles: 8000,
                    nodes: 15_999,
                    leaves: 8000,
                    depth_max: 24,
                    depth_mean: 15.2,
                    child_ratio: if split == "vertex-mean" { 0.6 } else { 0.7 },
                    sah_cost: 30.0 * planted.loose,
                    bytes: 3_000_000,
                    drift_mm: if centred && planted.id.contains("vertex") { 4.5 } else { 0.0 },
                    ..TreeRow::default()
                });
                for level in 0..14_u32 {
                    let (hull, shrink) = (1e6, 0.8_f64.powi(level.cast_signed()));
                    let loose = 1.0 + (planted.loose - 1.0) * shrink + 0.2 * f64::from(level);
                    // Every part in its own frame, and in others in which all is looser.
                    for frame in 0..5 {
                        let loose = loose * (1.0 + 0.1 * f64::from(frame));
                        self.tightness.push(TightnessRow {
                            scene: scene.into(),
                            part: part.into(),
                            variant: planted.id.into(),
                            split: split.clone(),
                            split_axes: split_axes.clone(),
                            leaf,
                            frame,
                            level,
                            nodes: 1 << level,
                            triangles: 8000,
                            volume_mm3: hull * shrink * loose,
                            area_mm2: 6e4 * loose,
                            hull_mm3: hull * shrink,
                            hulled_volume_mm3: hull * shrink * loose,
                            outside_corners_pct: if planted.safe { 0.0 } else { 40.0 * shrink },
                            outside_area_pct: if planted.safe { 0.0 } else { 30.0 * shrink },
                            overhang_mm: if planted.safe { 0.0 } else { 4.5 * shrink },
                            hausdorff_mm: Some(4.0 * loose * shrink),
                            sibling_overlap_mm3: Some(0.1 * hull * shrink),
                        });
                    }
                }
            }
        }
    }

    fn outlines(&mut self, scene: &str) {
        let mut segment = |variant: &str, a: [f64; 3], b: [f64; 3]| {
            self.outlines.push(OutlineRow {
                scene: scene.into(),
                part: PARTS[0].into(),
                variant: variant.into(),
                view: String::new(),
                x1_mm: a[0],
                y1_mm: a[1],
                z1_mm: a[2],
                x2_mm: b[0],
                y2_mm: b[1],
                z2_mm: b[2],
            });
        };
        let ring = |r: f64, z: f64, i: i32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 36.0;
            [r * angle.cos(), r * angle.sin(), z]
        };
        for (r, z) in [(8.0, 0.0), (8.0, 40.0), (25.0, 40.0), (25.0, 100.0)] {
            (0..36).for_each(|i| segment(MESH_OUTLINE, ring(r, z, i), ring(r, z, i + 1)));
        }
        for (r, low, high) in [(8.0, 0.0, 40.0), (25.0, 40.0, 100.0)] {
            (0..12).for_each(|i| segment(MESH_OUTLINE, ring(r, low, 3 * i), ring(r, high, 3 * i)));
        }
        for planted in PLANTED.into_iter().filter(|p| p.kind == Kind::Volume) {
            let shift = if planted.id == "obb-vertex-centroid" { -18.0 } else { 0.0 };
            let corner = |i: usize| {
                let side = |bit: usize, low, high| if i >> bit & 1 == 1 { high } else { low };
                [side(0, -25.0, 25.0), side(1, -25.0, 25.0), side(2, 0.0, 100.0) + shift]
            };
            for i in 0..8 {
                (0..3)
                    .filter(|bit| i >> bit & 1 == 0)
                    .for_each(|bit| segment(planted.id, corner(i), corner(i | 1 << bit)));
            }
        }
    }

    /// Writes everything to a run's folder.
    pub(crate) fn write(&self, folder: &Path) {
        self.manifest.write(folder).unwrap();
        write_rows(folder, &self.cases).unwrap();
        write_rows(folder, &self.poses).unwrap();
        write_rows(folder, &self.answers).unwrap();
        write_rows(folder, &self.lines).unwrap();
        write_rows(folder, &self.misses).unwrap();
        write_rows(folder, &self.verification).unwrap();
        write_rows(folder, &self.trees).unwrap();
        write_rows(folder, &self.tightness).unwrap();
        write_rows(folder, &self.outlines).unwrap();
        write_rows(folder, &self.builds).unwrap();
        write_rows(folder, &self.timings).unwrap();
    }
}

fn manifest(plan: &Plan) -> Manifest {
    let entry = |planted: &Planted| VariantEntry {
        id: planted.id.into(),
        label: planted.label.into(),
        reference: "synthetic".into(),
        safe: planted.safe,
        kind: planted.kind,
        policies: planted.policies.iter().map(|&policy| policy.to_owned()).collect(),
    };
    let scene = |name: &&str| SceneEntry {
        name: (*name).into(),
        title: "made up for the tests".into(),
        triangles: BTreeMap::from([("tool".into(), 8000), ("obstacle".into(), 8000)]),
        pairs: vec!["tool:obstacle".into()],
    };
    Manifest {
        schema: manifest::SCHEMA,
        protocol: manifest::PROTOCOL.into(),
        request: Request {
            profile: "smoke".into(),
            seed: plan.seed,
            scenes: SCENES.map(str::to_owned).to_vec(),
            variants: PLANTED.map(|p| p.id.to_owned()).to_vec(),
            policies: Vec::new(),
            workloads: Vec::new(),
            verify_poses: 8000,
            measure_poses: 2048,
            program_steps: 64,
            blocks: plan.blocks,
            launches: plan.launches,
            binaries: plan.binaries,
            cold_poses: 0,
        },
        inputs: BTreeMap::from([("scenes/made-up/scene.toml".into(), "00".into())]),
        variants: PLANTED.iter().map(entry).collect(),
        scenes: SCENES.iter().map(scene).collect(),
        program: Program {
            version: "0.0.0".into(),
            command: "bvbench repro --profile smoke".into(),
            ..Default::default()
        },
        binaries: Vec::new(),
        clock: None,
        cold: None,
        machine: MachineFacts { cpu: "made-up CPU".into(), cores: 2, os: "none".into(), ..Default::default() },
        null_of: "obb-area".into(),
        cross_check: None,
        finished: vec![Stage::Verify, Stage::Measure],
        noise: Vec::new(),
        rows: BTreeMap::new(),
        shard: None,
    }
}
