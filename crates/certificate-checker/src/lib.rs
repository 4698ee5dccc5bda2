//! Checks a certificate of `bvbench check --certify`: accepts it, or names the first line that it cannot confirm.
//!
//! No code is shared with the program that wrote it. The format and the mathematics stand in `docs/certificate.md`. Reading order: [`interval`], `machine` (links
//! and how far parts move), `mesh` (planes and hulls), `read` (lines), `scene` (the files), this file (the proof, pair by pair).

pub mod interval;
mod machine;
mod mesh;
mod read;
mod scene;

use interval::{I, Pose, dot, norm};
use machine::{Link, Machine, Step, Sweep};
use mesh::{Mesh, Plane};
use read::Words;
pub use scene::own_file;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The first line that is not confirmed.
#[derive(Debug)]
pub struct Refusal {
    /// Line of the certificate, from 1.
    pub line: usize,
    /// Why not.
    pub why: String,
}

/// The result of an accepted certificate: what it proves of each block, and what it leaves out.
#[derive(Debug, Default)]
pub struct Report {
    /// Verdict of each line of the program, of [`VERDICTS`].
    pub blocks: BTreeMap<u32, &'static str>,
    /// Lines in which a cutter feeds, where it may be in the workpiece.
    pub cutting: BTreeSet<u32>,
    /// Pairs that are examined.
    pub examined: usize,
    /// Intervals that are proved free.
    pub intervals: usize,
    /// Pairs that are not examined, and statements that nothing was compared with.
    pub notes: Vec<String>,
    /// Elementary steps of [`MOST_WORK`] that it took.
    pub work: u64,
}

/// A part.
struct Part {
    name: String,
    link: usize,
    role: String,
    tool: Option<u32>,
    pose: Pose,
    mesh: Mesh,
}

/// Everything that the certificate states before the proof.
#[derive(Default)]
struct Stated {
    machine: Machine,
    parts: Vec<Part>,
    /// Indices of the links by name.
    link_numbers: BTreeMap<String, usize>,
    /// Indices of the parts by name.
    part_numbers: BTreeMap<String, usize>,
    inputs: Vec<(String, String)>,
    program: (String, String),
    /// Files beside the program's that it calls, with their hashes.
    called: BTreeMap<String, String>,
    skipped: Vec<[String; 3]>,
}

/// The pair whose lines are read.
struct Current {
    parts: [usize; 2],
    /// Whether it is a cutter and the workpiece: contact is meant while it feeds.
    is_cutting: bool,
    /// The place at which its last interval ended.
    at: f64,
    /// The end of its last `open` interval.
    open: f64,
    front: Vec<Plane>,
    /// Where a stretch of free intervals begins; whether it is known that neither part is inside the other on it.
    stretch: Option<(Pose, bool)>,
}

/// Elementary steps that are left: a line; a box or a triangle beside a plane; a box beside a ray; a link or a move that is looked at. To place a link is [`LINK`] of them,
/// a triangle beside a ray ten more, to take up a plane two, and two more for each way of a motion.
#[derive(Default)]
struct Work(Cell<u64>);

impl Work {
    /// Takes some of it; false when no work is left.
    fn take(&self, steps: usize) -> bool {
        self.0.set(self.0.get().saturating_sub(steps as u64));
        self.0.get() > 0
    }
}

/// Clearance that is proved beyond the motion bound, mm. It covers rounding differences between files, certificate and machine.
const MARGIN_MM: f64 = 1e-6;

/// Elementary steps that it takes to place a link.
const LINK: usize = 30;

/// Most elementary steps; a certificate that asks for more is refused.
pub const MOST_WORK: u64 = 2_000_000_000;

/// Verdicts on a block, the worst one last. `stock`: free, but a rapid may bring the cutter into the whole workpiece.
pub const VERDICTS: [&str; 4] = ["free", "stock", "unresolved", "collision"];

type Checked<T = ()> = Result<T, String>;

/// Checks a certificate; against the scene's folder and the program where they are given. `most_work` is [`MOST_WORK`] or less.
///
/// # Errors
/// The first line that is not confirmed.
pub fn check(text: &str, scene: Option<&Path>, program: Option<&Path>, most_work: u64) -> Result<Report, Refusal> {
    let mut checker = Checker { work: Work(Cell::new(most_work)), ..Checker::default() };
    let world = Link { name: "-".to_owned(), parent: 0, pose: Pose::IDENTITY, joint: None };
    checker.stated.link_numbers.insert(world.name.clone(), 0);
    checker.stated.machine.links.push(world);
    let (mut count, mut length) = (0, 0);
    for line in text.split_inclusive('\n') {
        count += 1;
        let is_end = line.starts_with("end ");
        let mut result = match count {
            1 if line == "bvbench-certificate 3\n" => Ok(()),
            1 => Err("not a certificate, or another version of the format".to_owned()),
            _ if is_end => checker.end(text.split_at(length), [scene, program]),
            _ => checker.line(line),
        };
        if !checker.work.take(0) {
            result = Err(format!("it takes more than {most_work} steps to check"));
        }
        result.map_err(|why| Refusal { line: count, why })?;
        if is_end {
            checker.report.work = most_work - checker.work.0.get();
            return Ok(checker.report);
        }
        length += line.len();
    }
    Err(Refusal { line: count + 1, why: "the certificate ends without `end`".to_owned() })
}

#[derive(Default)]
struct Checker {
    work: Work,
    stated: Stated,
    /// Whether the proof has begun: machine, parts and moves are complete.
    is_proof: bool,
    current: Option<Current>,
    pairs: BTreeSet<[usize; 2]>,
    report: Report,
}

impl Checker {
    fn line(&mut self, line: &str) -> Checked {
        let mut words = Words(line.split_ascii_whitespace());
        let keyword = words.word()?;
        self.work.take(1);
        match keyword {
            "pair" => self.pair(&mut words)?,
            "free" | "same" | "hit" | "open" => self.interval(keyword, &mut words)?,
            _ if self.is_proof => return Err(format!("`{keyword}` does not belong here")),
            _ => self.stated.line(keyword, &mut words)?,
        }
        words.end()
    }

    /// Checks the last line; `body` is all before it.
    fn end(&mut self, (body, end): (&str, &str), files: [Option<&Path>; 2]) -> Checked {
        self.finish_pair()?;
        let count = self.stated.parts.len();
        if self.pairs.len() != count * count.saturating_sub(1) / 2 {
            return Err("pairs of parts are missing".to_owned());
        }
        if end != format!("end {}\n", blake3::hash(body.as_bytes()).to_hex()) {
            return Err("the hash of the lines before is another, or something follows".to_owned());
        }
        scene::compare(&self.stated, files, &mut self.report.notes)
    }

    /// Checks what was stated, when the first pair begins.
    fn begin_proof(&mut self) -> Checked {
        let Stated { machine, parts, .. } = &mut self.stated;
        for part in &mut *parts {
            part.mesh.finish(&self.work).map_err(|why| format!("{}: {why}", part.name))?;
        }
        if machine.steps.is_empty() {
            return Err("there is no path".to_owned());
        }
        self.report.blocks = machine.steps.iter().map(|step| (step.line, "free")).collect();
        machine.finish(parts, &self.work)
    }

    fn pair(&mut self, words: &mut Words<'_>) -> Checked {
        self.finish_pair()?;
        let parts = [self.stated.part(&words.name()?)?, self.stated.part(&words.name()?)?];
        if parts[0] == parts[1] || !self.pairs.insert([parts[0].min(parts[1]), parts[0].max(parts[1])]) {
            return Err("the pair was there before".to_owned());
        }
        let [a, b] = parts.map(|part| &self.stated.parts[part]);
        self.work.take(a.link + b.link);
        let joints = [[a, b], [b, a]].map(|[one, other]| self.stated.machine.chain(one.link, other.link).len());
        let are = |role: &str, other: &str| a.role == role && b.role == other || a.role == other && b.role == role;
        let is_structure = |part: &Part| part.role == "machine" && part.tool.is_none();
        let why = words.word()?;
        let holds = match why {
            "examined" | "ignored" | "allowed" => true,
            "cutting" => are("cutter", "workpiece"),
            "rigid" => joints == [0, 0],
            "neighbours" => joints[0] + joints[1] == 1 && is_structure(a) && is_structure(b),
            "tools" => a.tool.is_some() && b.tool.is_some() && a.tool != b.tool,
            _ => false,
        };
        if !holds {
            return Err(format!("the pair is not `{why}`"));
        }
        let (names, is_cutting) = (format!("{}:{}", a.name, b.name), why == "cutting");
        if is_cutting {
            self.report.notes.push(format!("at rapids alone, against the whole workpiece: {names}"));
        }
        if is_cutting || why == "examined" {
            self.report.examined += 1;
            self.current = Some(Current { parts, is_cutting, at: 0.0, open: 0.0, front: Vec::new(), stretch: None });
        } else if !matches!(why, "rigid" | "tools") {
            self.report.notes.push(format!("not examined: {names}, {why}"));
            self.stated.skipped.push([a.name.clone(), b.name.clone(), why.to_owned()]);
        }
        Ok(())
    }

    /// Ends the pair before; the first time, there is none, and the proof begins.
    fn finish_pair(&mut self) -> Checked {
        if !std::mem::replace(&mut self.is_proof, true) {
            self.begin_proof()?;
        }
        self.pass()?;
        let Some(mut current) = self.current.take() else { return Ok(()) };
        current.finish_stretch(&self.stated.parts, &self.work)?;
        let is_whole = current.at == self.stated.machine.steps.len() as f64;
        is_whole.then_some(()).ok_or("the pair before does not come to the end of the path".to_owned())
    }

    /// Passes over the steps that begin here on which not both parts are in the spindle, or the cutter is meant to cut.
    fn pass(&mut self) -> Checked {
        let Self { work, stated: Stated { machine, parts, .. }, current: Some(current), report, .. } = self else {
            return Ok(());
        };
        while current.at.fract() == 0.0 && work.take(1) {
            let Some(step) = machine.steps.get(current.at as usize) else { break };
            let is_there = |part: &usize| parts[*part].tool.is_none_or(|tool| tool == step.tool);
            if current.parts.iter().all(is_there) {
                if !(current.is_cutting && step.cuts) {
                    break;
                }
                report.cutting.extend((!step.is_point).then_some(step.line));
            }
            current.finish_stretch(parts, work)?;
            current.at += 1.0;
        }
        Ok(())
    }

    fn interval(&mut self, keyword: &str, words: &mut Words<'_>) -> Checked {
        self.pass()?;
        let Self { work, stated: Stated { machine, parts, .. }, current: Some(current), report, .. } = self else {
            return Err("no pair".to_owned());
        };
        let (from, to, pair) = (current.at, words.number()?, current.parts.map(|part| &parts[part]));
        let step = from.floor();
        let is_whole = from.fract() == 0.0 && to.fract() == 0.0;
        if !(to > from && to <= machine.steps.len() as f64 && (is_whole || to <= step + 1.0)) {
            return Err("no such interval of the path".to_owned());
        }
        let steps = step as usize..to.ceil() as usize;
        work.take(steps.len());
        let mut verdict = "free";
        match keyword {
            "open" => {
                words.number()?;
                current.open = to;
                verdict = if current.is_cutting { "stock" } else { "unresolved" };
            }
            "hit" => {
                let (place, way) = (words.number()?, words.number()?);
                let is_first = current.open <= step && place >= from && place <= to && to == step + 1.0;
                if current.is_cutting || !is_first {
                    return Err("no first contact can be there, nor with what is left of the workpiece".to_owned());
                }
                let places = [[from - step, place - step], [place - step; 2]];
                let [before, there] = places.map(|places| machine.sweep(steps.start, places, pair, work));
                let (before, there) = before.zip(there).ok_or("the way cannot be bounded")?;
                if 2.0 * before.bound().hi > way {
                    return Err(format!("the way is not within {way} mm"));
                }
                let faces = pair[0].mesh.triangle(words.whole()?).zip(pair[1].mesh.triangle(words.whole()?));
                let (a, b) = faces.ok_or("no such triangle")?;
                if !mesh::touch(&a, &b.map(|p| there.a_from_b.point(&p))) {
                    return Err("the two triangles do not pierce each other".to_owned());
                }
                verdict = "collision";
            }
            _ => {
                let found = machine.sweep(steps.start, [from - step, to - step], pair, work);
                let found = found.ok_or("the way cannot be bounded")?;
                let bound = words.number()?;
                if found.bound().hi > bound {
                    return Err(format!("points may go farther than {bound} mm"));
                }
                if keyword == "free" {
                    current.front = mesh::front(pair.map(|part| &part.mesh), words, work)?;
                }
                current.part(&pair[1].mesh, &found, work)?;
                report.intervals += 1;
            }
        }
        if verdict != "free" {
            current.finish_stretch(parts, work)?;
        }
        current.at = to;
        for Step { line, .. } in &machine.steps[steps] {
            let known = report.blocks.entry(*line).or_insert(verdict);
            *known = VERDICTS.into_iter().rfind(|one| [*known, verdict].contains(one)).unwrap_or(verdict);
        }
        Ok(())
    }
}

impl Current {
    /// Checks that each plane keeps its node of `b` on the far side over the whole interval.
    fn part(&mut self, b: &Mesh, found: &Sweep, work: &Work) -> Checked {
        if self.front.is_empty() {
            return Err("there is no front before".to_owned());
        }
        for (index, Plane { normal, offset, b: node }) in self.front.iter().enumerate() {
            work.take(2 * (1 + found.ways.len() + found.ellipsoid.len()));
            let way = found.towards(normal) + (found.radius + I::of(MARGIN_MM)) * norm(normal);
            let least = *offset + way - dot(normal, &found.a_from_b.t);
            if !b.is_beyond(*node, &found.a_from_b.turn_back(normal), least.hi, work) {
                return Err(format!("plane {} does not part the two over the interval", index + 1));
            }
        }
        let (_, is_outside) = self.stretch.get_or_insert((found.a_from_b, false));
        *is_outside |= self.front.len() == 1;
        Ok(())
    }

    /// Where surfaces stay apart, one solid may still be inside the other.
    fn finish_stretch(&mut self, parts: &[Part], work: &Work) -> Checked {
        let Some((a_from_b, false)) = self.stretch.take() else { return Ok(()) };
        let [a, b] = self.parts.map(|part| &parts[part].mesh);
        let is_outside = mesh::is_outside(b, a, &a_from_b, work) && mesh::is_outside(a, b, &a_from_b.inverse(), work);
        is_outside.then_some(()).ok_or("before this line one part may be inside the other".to_owned())
    }
}
