//! Words of a line, and the lines that state the machine, the parts and the path.

use crate::interval::{I, ONE, Pose, V, unit};
use crate::machine::{Joint, Link, Step, Tip};
use crate::mesh::Mesh;
use crate::{Part, Stated};
use std::str::{FromStr, SplitAsciiWhitespace};

/// A, B and C, of the axes X Y Z A B C U V W: radians.
pub const ROTARY: std::ops::Range<usize> = 3..6;
/// π/180 = 0.0174532925199432957..., between two neighbouring numbers.
pub const DEGREE: I = I { lo: 0.017_453_292_519_943_295, hi: 0.017_453_292_519_943_3 };
/// Largest number, mm or radians, and of a plane.
const LARGEST: f64 = 1e12;

pub struct Words<'a>(pub SplitAsciiWhitespace<'a>);

impl<'a> Words<'a> {
    pub fn word(&mut self) -> Result<&'a str, String> {
        self.0.next().ok_or_else(|| "a word is missing".to_owned())
    }

    pub fn whole<T: FromStr>(&mut self) -> Result<T, String> {
        let word = self.word()?;
        word.parse().map_err(|_| format!("`{word}` is not a whole number of its kind"))
    }

    pub fn number(&mut self) -> Result<f64, String> {
        let word = self.word()?;
        let number = word.parse().ok().filter(|x: &f64| x.abs() <= LARGEST);
        number.ok_or_else(|| format!("`{word}` is not a number up to {LARGEST}"))
    }

    pub fn vector(&mut self) -> Result<V, String> {
        Ok([self.number()?, self.number()?, self.number()?].map(I::of))
    }

    /// A name with its spaces. It has a limit because each line compares names.
    pub fn name(&mut self) -> Result<String, String> {
        let name = Some(self.word()?).filter(|name| name.len() <= 1000).ok_or("a name of more than 1000 bytes")?;
        Ok(name.replace("%20", " ").replace("%25", "%"))
    }

    pub fn end(&mut self) -> Result<(), String> {
        self.0.next().map_or(Ok(()), |word| Err(format!("`{word}` is too much")))
    }

    fn pose(&mut self) -> Result<Pose, String> {
        let q = [self.number()?, self.number()?, self.number()?, self.number()?];
        Ok(Pose::of(q, self.vector()?))
    }

    fn direction(&mut self) -> Result<V, String> {
        Ok(unit(&self.vector()?))
    }
}

pub fn axis(letter: &str) -> Result<usize, String> {
    "XYZABCUVW".find(letter).filter(|_| letter.len() == 1).ok_or_else(|| format!("`{letter}` is not an axis"))
}

impl Stated {
    pub(crate) fn link(&self, name: &str) -> Result<usize, String> {
        self.link_numbers.get(name).copied().ok_or_else(|| format!("no link `{name}`"))
    }

    pub(crate) fn part(&self, name: &str) -> Result<usize, String> {
        self.part_numbers.get(name).copied().ok_or_else(|| format!("part `{name}` is missing"))
    }

    pub(crate) fn line(&mut self, keyword: &str, words: &mut Words<'_>) -> Result<(), String> {
        match keyword {
            "made" | "scene" => words.0.by_ref().for_each(drop),
            "input" => self.inputs.push((words.name()?, words.word()?.to_owned())),
            "program" => self.program = (words.name()?, words.word()?.to_owned()),
            // A file beside the program: no path.
            "called" => {
                drop(self.called.insert(words.name()?.replace(['/', '\\', ':'], "%"), words.word()?.to_owned()));
            }
            "link" | "slide" | "turn" => {
                let (name, parent, pose) = (words.name()?, self.link(&words.name()?)?, words.pose()?);
                if self.link_numbers.insert(name.clone(), self.machine.links.len()).is_some() {
                    return Err(format!("link `{name}` was there before"));
                }
                let mut joint = None;
                if keyword != "link" {
                    let (axis, direction) = (axis(words.word()?)?, words.direction()?);
                    let turns = if keyword == "turn" { Some(words.vector()?) } else { None };
                    let is_rotary = ROTARY.contains(&axis);
                    if is_rotary && turns.is_none() {
                        return Err("A, B and C turn".to_owned());
                    }
                    let gain = if is_rotary || turns.is_none() { ONE } else { DEGREE };
                    joint = Some(Joint { axis, turns, direction, gain });
                }
                self.machine.links.push(Link { name, parent, pose, joint });
            }
            "tip" => {
                let (tool, work) = (self.link(&words.name()?)?, self.link(&words.name()?)?);
                self.machine.tip = Some(Tip { tool, work, gauge: words.vector()?, direction: words.direction()? });
            }
            "part" => {
                let (name, link, role) = (words.name()?, self.link(&words.name()?)?, words.name()?);
                if self.part_numbers.insert(name.clone(), self.parts.len()).is_some() {
                    return Err(format!("part `{name}` was there before"));
                }
                let is_of_none = words.0.clone().next() == Some("-");
                let tool = if is_of_none { words.word().map(|_| None)? } else { Some(words.whole()?) };
                self.parts.push(Part { name, link, role, tool, pose: words.pose()?, mesh: Mesh::default() });
            }
            "v" => self.parts.last_mut().ok_or("no part")?.mesh.vertex(words)?,
            "f" => self.parts.last_mut().ok_or("no part")?.mesh.face(words)?,
            "point" | "feed" | "rapid" => self.step(keyword, words)?,
            _ => return Err("no such keyword".to_owned()),
        }
        Ok(())
    }

    fn step(&mut self, course: &str, words: &mut Words<'_>) -> Result<(), String> {
        let (line, tool) = (words.whole()?, words.whole()?);
        let before = self.machine.steps.last();
        let (from, is_point) = (before.map_or([0.0; 9], |step| step.to), course == "point");
        let stays = before.is_some_and(|step| step.cuts && step.tool == tool);
        let cuts = course == "feed" || is_point && stays;
        let mut step = Step { line, tool, is_point, cuts, arc: None, from, to: from, tip: None };
        while let Some(word) = words.0.next() {
            match word {
                "tip" => step.tip = Some(words.number()?),
                "arc" => {
                    let plane = [axis(words.word()?)?, axis(words.word()?)?];
                    step.arc = Some((plane, [words.number()?, words.number()?, words.number()?]));
                }
                letter => step.to[axis(letter)?] = words.number()?,
            }
        }
        if is_point {
            step.from = step.to;
        }
        self.machine.steps.push(step);
        Ok(())
    }
}
