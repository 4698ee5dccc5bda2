//! The certificate as text, as `docs/certificate.md` describes it.

use super::hull::{Token, Tree};
use super::motion::{Course, Step};
use super::search::{Entry, Finding};
use crate::geometry::grid::STEP_MM;
use crate::geometry::{Isometry, Vector};
use crate::machine::Motion;
use crate::scene::{Pair, ProgramRun, Scene};
use rs274::Axis;
use rs274::file::LARGEST_PROGRAM;
use std::fmt::Write;
use std::sync::Arc;

/// What a certificate says.
pub(super) struct Proof<'a> {
    pub scene: &'a Scene,
    pub run: &'a ProgramRun,
    pub steps: &'a [Step],
    pub trees: &'a [Tree],
    pub skipped: &'a [(Pair, &'static str)],
    pub found: &'a [(Pair, Vec<Entry>)],
}

/// The whole file.
pub(super) fn write(proof: &Proof<'_>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = proof.head(&mut text).and_then(|()| proof.parts(&mut text)).and_then(|()| proof.moves(&mut text));
    let _ = proof.pairs(&mut text).and_then(|()| end(&mut text));
    text
}

impl Proof<'_> {
    fn head(&self, text: &mut String) -> std::fmt::Result {
        let Self { scene, run, .. } = self;
        writeln!(text, "bvbench-certificate 3")?;
        writeln!(text, "made bvbench {} interpreter rs274 {}", env!("CARGO_PKG_VERSION"), rs274::VERSION)?;
        writeln!(text, "scene {}", name(&scene.name))?;
        for (file, hash) in &scene.inputs {
            writeln!(text, "input {} {hash}", name(file))?;
        }
        let file = run.file.file_name().unwrap_or_default().to_string_lossy();
        writeln!(text, "program {} {}", name(&file), run.hash)?;
        for file in &run.program.called_files {
            let (own, content) = (file.file_name().unwrap_or_default(), rs274::file::bytes(file, LARGEST_PROGRAM));
            let hash = content.map_or_else(|_| "-".to_owned(), |content| blake3::hash(&content).to_hex().to_string());
            writeln!(text, "called {} {hash}", name(&own.to_string_lossy()))?;
        }
        // Parents first.
        let depth = |&link: &usize| scene.machine.chain(Some(link)).count();
        let mut order: Vec<usize> = (0..scene.machine.links().len()).collect();
        order.sort_by_key(depth);
        for link in order.into_iter().map(|link| &scene.machine.links()[link]) {
            let parent = link.parent.as_deref().map_or_else(|| "-".to_owned(), name);
            let own = format!("{} {parent} {}", name(&link.name), placed(&link.parent_from_link));
            let joint = link.joint.as_ref().map(|joint| (joint.axis.letter(), &joint.motion));
            match joint {
                None => writeln!(text, "link {own}")?,
                Some((letter, Motion::Prismatic { direction })) => {
                    writeln!(text, "slide {own} {letter} {}", three(direction))?;
                }
                Some((letter, Motion::Rotary { direction, point })) => {
                    writeln!(text, "turn {own} {letter} {} {}", three(direction), three(&point.coords))?;
                }
            }
        }
        if let Some(tip) = &run.tip {
            let [tool, work] = [tip.tool_link, tip.work_link].map(|link| self.link(link));
            writeln!(text, "tip {tool} {work} {} {}", three(&tip.gauge.coords), three(&tip.direction))?;
        }
        Ok(())
    }

    fn link(&self, link: Option<usize>) -> String {
        link.map_or_else(|| "-".to_owned(), |link| name(&self.scene.machine.links()[link].name))
    }

    fn parts(&self, text: &mut String) -> std::fmt::Result {
        for (part, tree) in self.scene.parts.iter().zip(self.trees) {
            let tool = part.tool.map_or_else(|| "-".to_owned(), |tool| tool.to_string());
            let (link, role) = (self.link(part.link), part.role.name());
            writeln!(text, "part {} {link} {role} {tool} {}", name(&part.name), placed(&part.link_from_part))?;
            for p in part.mesh.vertices() {
                let [x, y, z] = [p.x, p.y, p.z].map(|x| (x / STEP_MM) as i64);
                writeln!(text, "v {x} {y} {z}")?;
            }
            for [i, j, k] in &tree.faces {
                writeln!(text, "f {i} {j} {k}")?;
            }
        }
        Ok(())
    }

    fn moves(&self, text: &mut String) -> std::fmt::Result {
        let mut last = [0.0; 9];
        for step in self.steps {
            let course = match step.course {
                Course::Point => "point",
                Course::Line | Course::Arc { .. } => "feed",
                Course::Rapid => "rapid",
            };
            write!(text, "{course} {} {}", step.line, step.tool)?;
            for axis in Axis::ALL.into_iter().filter(|&axis| step.to[axis] != last[axis as usize]) {
                write!(text, " {} {}", axis.letter(), step.to[axis])?;
            }
            if let Course::Arc { plane, centre, sweep } = step.course {
                let [first, second] = plane.map(Axis::letter);
                write!(text, " arc {first} {second} {} {} {sweep}", centre[0], centre[1])?;
            }
            if let Some(length) = step.tip_mm {
                write!(text, " tip {length}")?;
            }
            writeln!(text)?;
            last = step.to.0;
        }
        Ok(())
    }

    fn pairs(&self, text: &mut String) -> std::fmt::Result {
        let pair_names = |pair: &Pair| [pair.a, pair.b].map(|part| name(&self.scene.parts[part].name)).join(" ");
        for (pair, why) in self.skipped {
            writeln!(text, "pair {} {why}", pair_names(pair))?;
        }
        for (pair, entries) in self.found {
            let how = if self.scene.is_cutting(*pair) { "cutting" } else { "examined" };
            writeln!(text, "pair {} {how}", pair_names(pair))?;
            let mut planes: Option<&Arc<[Token]>> = None;
            for Entry { to, finding, .. } in entries {
                match finding {
                    // The checker sees itself on which steps nothing is to be proved.
                    Finding::Away | Finding::Meant => {}
                    Finding::Open { apart_mm } => writeln!(text, "open {to} {}", apart_mm.unwrap_or(0.0))?,
                    Finding::Hit { place, way_mm, faces: [i, j] } => {
                        writeln!(text, "hit {to} {place} {way_mm} {i} {j}")?;
                    }
                    Finding::Free { bound_mm, front } if planes.is_some_and(|before| Arc::ptr_eq(before, front)) => {
                        writeln!(text, "same {to} {bound_mm}")?;
                    }
                    Finding::Free { bound_mm, front } => {
                        planes = Some(front);
                        write!(text, "free {to} {bound_mm}")?;
                        for token in front.iter() {
                            match token {
                                Token::HalveA => write!(text, " a")?,
                                Token::HalveB => write!(text, " b")?,
                                Token::Plane { normal: [x, y, z], offset } => write!(text, " p {x} {y} {z} {offset}")?,
                            }
                        }
                        writeln!(text)?;
                    }
                }
            }
        }
        Ok(())
    }
}

fn end(text: &mut String) -> std::fmt::Result {
    let hash = blake3::hash(text.as_bytes()).to_hex();
    writeln!(text, "end {hash}")
}

/// A name as one word. The checker reads spaces and `%`; a link's name with a control character, or of the world, is of no link to it.
fn name(name: &str) -> String {
    let mut word = String::new();
    for c in name.chars() {
        if c == '%' || c == ' ' || c.is_control() {
            let _ = write!(word, "%{:02X}", u32::from(c));
        } else {
            word.push(c);
        }
    }
    word
}

fn three(vector: &Vector) -> String {
    format!("{} {} {}", vector.x, vector.y, vector.z)
}

/// Quaternion (w, x, y, z) and translation.
fn placed(motion: &Isometry) -> String {
    let q = motion.rotation.quaternion();
    format!("{} {} {} {} {}", q.w, q.i, q.j, q.k, three(&motion.translation.vector))
}
