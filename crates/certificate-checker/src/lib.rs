//! Checks a certificate of `bvbench check --certify`: accepts it, or names the first line that it cannot confirm.
//!
//! No code is shared with the program that wrote it. The format and the mathematics stand in `docs/certificate.md`. Reading order: [`interval`], `machine` (links
//! and how far parts move), `mesh` (planes and hulls), `read` (lines), `scene` (the files), this file (the proof, pair by pair).

pub mod interval;
mod machine;
mod mesh;
mod read;
mod scene;

use interval::{I, Pose, V};
use machine::{Machine, Step, Sweep};
use mesh::{Mesh, Token};
use read::Words;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Read};
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
    /// Pairs that are examined.
    pub examined: usize,
    /// Intervals that are proved free.
    pub intervals: usize,
    /// Pairs that are not examined, and statements that nothing was compared with.
    pub notes: Vec<String>,
}

/// A part.
#[derive(Debug)]
pub struct Part {
    name: String,
    link: Option<usize>,
    role: String,
    tool: Option<u32>,
    pose: Pose,
    mesh: Mesh,
}

/// Everything that the certificate states before the proof.
#[derive(Debug, Default)]
pub struct Stated {
    machine: Machine,
    parts: Vec<Part>,
    inputs: Vec<(String, String)>,
    program: (String, String),
    skipped: Vec<[String; 3]>,
}

/// The pair whose lines are read.
struct Current {
    parts: [usize; 2],
    /// Whether it is a cutter and the workpiece: contact is meant while it feeds.
    is_cutting: bool,
    /// The place at which its last interval ended.
    at: f64,
    front: Vec<Token>,
    rooted: bool,
    /// Where a stretch of free intervals begins; whether it is known that neither part is inside the other on it.
    stretch: Option<(Pose, bool)>,
}

/// Clearance that is proved beyond the motion bound, mm. It covers rounding differences between files, certificate and machine.
const MARGIN_MM: f64 = 1e-6;

/// Checks a certificate; against the scene's folder and the program where they are given.
///
/// # Errors
/// The first line that is not confirmed.
pub fn check(text: impl BufRead, scene: Option<&Path>, program: Option<&Path>) -> Result<Report, Refusal> {
    let mut checker = Checker { files: (scene.map(Path::to_owned), program.map(Path::to_owned)), ..Checker::default() };
    let mut text = text;
    let (mut line, mut number) = (Vec::new(), 0);
    loop {
        line.clear();
        number += 1;
        let refuse = |why: String| Refusal { line: number, why };
        // A line of a front of 3 000 planes is some 150 kB.
        let read =
            text.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(|error| refuse(error.to_string()))?;
        if read == 0 {
            return Err(refuse("the certificate ends without `end`".to_owned()));
        }
        let words = std::str::from_utf8(&line).ok().filter(|line| line.ends_with('\n'));
        let words = words.ok_or_else(|| refuse("not a line of text".to_owned()))?;
        if checker.line(number, words).map_err(refuse)? {
            let is_over = text.fill_buf().is_ok_and(<[u8]>::is_empty);
            return if is_over { Ok(checker.report) } else { Err(refuse("something follows".to_owned())) };
        }
        checker.hasher.update(&line);
    }
}

const LONGEST_LINE: u64 = 1 << 22;

/// Verdicts on a block, the worst one last. `stock`: free, but a rapid may bring the cutter into the whole workpiece.
pub const VERDICTS: [&str; 4] = ["free", "stock", "unresolved", "collision"];

#[derive(Default)]
struct Checker {
    files: (Option<std::path::PathBuf>, Option<std::path::PathBuf>),
    stated: Stated,
    hasher: blake3::Hasher,
    current: Option<Current>,
    pairs: BTreeSet<[usize; 2]>,
    /// The worst verdict of each step, by its place in [`VERDICTS`].
    verdicts: Vec<u8>,
    blocks: BTreeMap<u32, u8>,
    phase: usize,
    report: Report,
}

/// Keywords in the order in which their lines come.
const PHASES: [&[&str]; 6] = [
    &["bvbench-certificate"],
    &["made", "scene", "input", "program", "link", "tip"],
    &["part", "v", "f"],
    &["move"],
    &["pair", "free", "hit", "open", "away", "meant"],
    &["block", "end"],
];

type Checked<T = ()> = Result<T, String>;

impl Checker {
    /// Checks one line; true when it is `end`, the last one.
    fn line(&mut self, number: usize, line: &str) -> Checked<bool> {
        let mut words = Words::new(line);
        let keyword = words.word()?;
        let phase = PHASES.iter().position(|words| words.contains(&keyword)).ok_or("no such keyword")?;
        if phase < self.phase || (phase == 0) != (number == 1) || phase > self.phase + 1 {
            return Err(format!("`{keyword}` does not belong here"));
        }
        while self.phase < phase {
            self.phase += 1;
            self.enter()?;
        }
        match keyword {
            "bvbench-certificate" if words.word()? == "2" => {}
            "bvbench-certificate" => return Err("another version of the format".to_owned()),
            "made" | "scene" => words.skip(),
            "v" | "f" => {
                let part = self.stated.parts.last_mut().ok_or("no part")?;
                if keyword == "v" { part.mesh.vertex(&mut words)? } else { part.mesh.face(&mut words)? }
            }
            "input" | "program" | "link" | "tip" | "part" | "move" => self.stated.line(keyword, &mut words)?,
            "pair" => self.pair(&mut words)?,
            "free" | "hit" | "open" | "away" | "meant" => self.interval(keyword, &mut words)?,
            "block" => {
                let (line, verdict) = (words.whole()?, words.word()?);
                let found = self.blocks.remove(&line).map(|worst| VERDICTS[worst as usize]);
                let found = found.filter(|&found| found == verdict);
                self.report.blocks.insert(line, found.ok_or("not what the intervals say")?);
            }
            _ => {
                if !self.blocks.is_empty() {
                    return Err("lines of the program are missing".to_owned());
                }
                if words.word()? != self.hasher.finalize().to_hex().as_str() {
                    return Err("the hash of the lines before is another".to_owned());
                }
            }
        }
        words.end()?;
        Ok(keyword == "end")
    }

    /// Checks what the phase before must have stated, when the next one begins.
    fn enter(&mut self) -> Checked {
        match self.phase {
            3 => self
                .stated
                .parts
                .iter_mut()
                .try_for_each(|part| part.mesh.finish().map_err(|why| format!("{}: {why}", part.name))),
            4 => {
                self.stated.machine.finish()?;
                if self.stated.machine.steps.is_empty() {
                    return Err("there is no path".to_owned());
                }
                self.verdicts = vec![0; self.stated.machine.steps.len()];
                Ok(())
            }
            5 => {
                self.finish_pair()?;
                let count = self.stated.parts.len();
                if self.pairs.len() != count * (count - 1) / 2 {
                    return Err("pairs of parts are missing".to_owned());
                }
                for (Step { line, .. }, &verdict) in self.stated.machine.steps.iter().zip(&self.verdicts) {
                    let worst = self.blocks.entry(*line).or_default();
                    *worst = verdict.max(*worst);
                }
                scene::compare(&self.stated, self.files.0.as_deref(), self.files.1.as_deref(), &mut self.report.notes)
            }
            _ => Ok(()),
        }
    }

    fn pair(&mut self, words: &mut Words<'_>) -> Checked {
        self.finish_pair()?;
        let mut part = || {
            let name = words.name()?;
            self.stated.parts.iter().position(|part| part.name == name).ok_or(format!("no part `{name}`"))
        };
        let parts = [part()?, part()?];
        let mut key = parts;
        key.sort_unstable();
        if key[0] == key[1] || !self.pairs.insert(key) {
            return Err("the pair was there before".to_owned());
        }
        let [a, b] = parts.map(|part| &self.stated.parts[part]);
        let joints = self.stated.machine.between([a.link, b.link]).map(|chain| chain.len()).iter().sum::<usize>();
        let are = |role: &str, other: &str| a.role == role && b.role == other || a.role == other && b.role == role;
        let why = words.word()?;
        let is_cutting = why == "cutting" && are("cutter", "workpiece");
        if is_cutting {
            self.report.notes.push(format!("at rapids alone, against the whole workpiece: {}:{}", a.name, b.name));
        }
        if is_cutting || why == "examined" {
            self.report.examined += 1;
            let (front, stretch) = (Vec::new(), None);
            self.current = Some(Current { parts, is_cutting, at: 0.0, front, rooted: false, stretch });
            return Ok(());
        }
        let holds = match why {
            "rigid" => joints == 0,
            "neighbours" => joints == 1 && are("machine", "machine"),
            "tools" => a.tool.is_some() && b.tool.is_some() && a.tool != b.tool,
            "ignored" | "allowed" => true,
            _ => false,
        };
        if matches!(why, "neighbours" | "ignored" | "allowed") {
            self.stated.skipped.push([a.name.clone(), b.name.clone(), why.to_owned()]);
            self.report.notes.push(format!("not examined: {}:{}, {why}", a.name, b.name));
        }
        if holds { Ok(()) } else { Err(format!("the pair is not `{why}`")) }
    }

    fn finish_pair(&mut self) -> Checked {
        self.finish_stretch()?;
        match self.current.take() {
            Some(current) if current.at != self.stated.machine.steps.len() as f64 => {
                Err("the pair before does not come to the end of the path".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Where surfaces stay apart, one solid may still be inside the other.
    fn finish_stretch(&mut self) -> Checked {
        let Some(current) = &mut self.current else { return Ok(()) };
        let Some((a_from_b, false)) = current.stretch.take() else { return Ok(()) };
        let [a, b] = current.parts.map(|part| &self.stated.parts[part].mesh);
        let is_outside = mesh::is_outside(b, a, &a_from_b) && mesh::is_outside(a, b, &a_from_b.inverse());
        if is_outside { Ok(()) } else { Err("before this line one part may be inside the other".to_owned()) }
    }

    fn interval(&mut self, keyword: &str, words: &mut Words<'_>) -> Checked {
        let to = words.number()?;
        let from = self.current.as_ref().ok_or("no pair")?.at;
        if keyword != "free" {
            self.finish_stretch()?;
        }
        let Some(current) = &mut self.current else { return Ok(()) };
        let Stated { machine, parts, .. } = &self.stated;
        let pair = current.parts.map(|part| &parts[part]);
        let step = from.floor();
        let is_whole = from.fract() == 0.0 && to.fract() == 0.0;
        if !(to > from && to <= machine.steps.len() as f64 && (is_whole || to <= step + 1.0)) {
            return Err("no such interval of the path".to_owned());
        }
        let steps = step as usize..to.ceil() as usize;
        let is_there = |step: &Step| pair.iter().all(|part| part.tool.is_none_or(|tool| tool == step.tool));
        let mut verdict = 0;
        match keyword {
            "away" if machine.steps[steps.clone()].iter().any(is_there) => {
                return Err("both parts are there".to_owned());
            }
            "away" => {}
            "meant" if !(current.is_cutting && steps.clone().all(|step| machine.cuts(step))) => {
                return Err("contact is not meant there".to_owned());
            }
            "meant" => {}
            "open" => {
                words.number()?;
                verdict = if current.is_cutting { 1 } else { 2 };
            }
            "hit" if current.is_cutting => return Err("what is left of the workpiece is not known".to_owned()),
            "hit" => {
                let (place, way) = (words.number()?, words.number()?);
                if !(place >= from && place <= to && to == step + 1.0 && is_there(&machine.steps[steps.start])) {
                    return Err("no contact can be there".to_owned());
                }
                let found = machine.sweep([from, place], pair).ok_or("the way cannot be bounded")?;
                if 2.0 * found.bound().hi > way {
                    return Err(format!("the way is not within {way} mm"));
                }
                let found =
                    machine.sweep_on(steps.start, [place - step; 2], pair).ok_or("the place cannot be found")?;
                mesh::pierces([&pair[0].mesh, &pair[1].mesh], &found.a_from_b, words)?;
                verdict = 3;
            }
            _ => {
                let found = machine.sweep([from, to], pair).ok_or("the way cannot be bounded")?;
                let bound = words.number()?;
                if found.bound().hi > bound {
                    return Err(format!("points may go farther than {bound} mm"));
                }
                Self::free(current, pair, &found, words)?;
                self.report.intervals += 1;
            }
        }
        current.at = to;
        self.verdicts[steps].iter_mut().for_each(|known| *known = verdict.max(*known));
        Ok(())
    }

    /// Checks that each plane keeps its node of `b` on the far side over the whole interval.
    fn free(current: &mut Current, pair: [&Part; 2], sweep: &Sweep, words: &mut Words<'_>) -> Checked {
        let [a, b] = pair.map(|part| &part.mesh);
        if !words.is_next("=") {
            current.front = mesh::front(a, b, words)?;
            current.rooted = current.front.len() == 1;
        }
        if current.front.is_empty() {
            return Err("there is no front before".to_owned());
        }
        for Token { normal, offset, b: node } in &current.front {
            let n: V = normal.map(|x| I::of(f64::from(x)));
            let towards = sweep.towards(&n) + (sweep.radius + I::of(MARGIN_MM)) * interval::norm(&n);
            let least = I::of(*offset as f64) + towards - interval::dot(&n, &sweep.a_from_b.t);
            if !b.is_beyond(*node, &sweep.a_from_b.turn_back(&n), least.hi) {
                return Err(format!("the plane {normal:?} {offset} does not part the two over the interval"));
            }
        }
        let (_, is_outside) = current.stretch.get_or_insert((sweep.a_from_b, false));
        *is_outside |= current.rooted;
        Ok(())
    }
}
