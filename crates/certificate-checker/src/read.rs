//! Words of a line, and the lines that state the machine, the parts and the path.

use crate::interval::{I, ONE, Pose, V, norm};
use crate::machine::{Joint, Link, Step, Tip};
use crate::mesh::Mesh;
use crate::{Part, Stated};
use std::iter::Peekable;
use std::str::{FromStr, SplitAsciiWhitespace};

/// The letters of the axes.
pub const AXES: &str = "XYZABCUVW";
/// A, B and C: radians.
pub const ROTARY: std::ops::Range<usize> = 3..6;
/// π/180 = 0.0174532925199432957..., between two neighbouring numbers.
pub const DEGREE: I = I { lo: 0.017_453_292_519_943_295, hi: 0.017_453_292_519_943_3 };
/// Largest number, mm or radians.
const LARGEST: f64 = 1e9;

pub struct Words<'a>(Peekable<SplitAsciiWhitespace<'a>>);

impl<'a> Words<'a> {
    pub fn new(line: &'a str) -> Self {
        Self(line.split_ascii_whitespace().peekable())
    }

    pub fn word(&mut self) -> Result<&'a str, String> {
        self.0.next().ok_or_else(|| "a word is missing".to_owned())
    }

    pub fn whole<T: FromStr>(&mut self) -> Result<T, String> {
        let word = self.word()?;
        word.parse().map_err(|_| format!("`{word}` is not a whole number of its kind"))
    }

    pub fn number(&mut self) -> Result<f64, String> {
        number(self.word()?)
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut found = [0.0; N];
        found.iter_mut().try_for_each(|x| self.number().map(|number| *x = number))?;
        Ok(found)
    }

    /// A name with its escapes undone.
    pub fn name(&mut self) -> Result<String, String> {
        let word = self.word()?;
        let mut parts = word.split('%');
        let mut name = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (code, rest) = part.split_once(';').ok_or("an escape without an end")?;
            let c = u32::from_str_radix(code, 16).ok().and_then(char::from_u32).filter(|c| !c.is_control());
            name.push(c.ok_or("an escape of no character")?);
            name.push_str(rest);
        }
        Ok(name)
    }

    fn optional_name(&mut self) -> Result<Option<String>, String> {
        if self.is_next("-") { Ok(None) } else { self.name().map(Some) }
    }

    /// Takes the next word if it is this one.
    pub fn is_next(&mut self, word: &str) -> bool {
        self.0.next_if_eq(&word).is_some()
    }

    pub fn skip(&mut self) {
        while self.0.next().is_some() {}
    }

    pub fn end(&mut self) -> Result<(), String> {
        self.0.next().map_or(Ok(()), |word| Err(format!("`{word}` is too much")))
    }

    fn pose(&mut self) -> Result<Pose, String> {
        let (q, t) = (self.numbers::<4>()?, self.numbers()?);
        if q.iter().map(|x| x * x).sum::<f64>() < 0.5 {
            return Err("no rotation".to_owned());
        }
        Ok(Pose::of(q, t.map(I::of)))
    }

    fn direction(&mut self) -> Result<V, String> {
        let d = self.numbers::<3>()?.map(I::of);
        let length = norm(&d);
        if length.lo > 1e-3 { Ok(d.map(|x| x.over(length))) } else { Err("no direction".to_owned()) }
    }
}

fn number(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|x: &f64| x.abs() <= LARGEST);
    number.ok_or_else(|| format!("`{word}` is not a number up to {LARGEST}"))
}

pub fn axis(letter: &str) -> Result<usize, String> {
    AXES.find(letter).filter(|_| letter.len() == 1).ok_or_else(|| format!("`{letter}` is not an axis"))
}

impl Stated {
    pub(crate) fn link(&self, name: &str) -> Result<usize, String> {
        self.machine.links.iter().position(|link| link.name == name).ok_or_else(|| format!("no link `{name}`"))
    }

    fn link_or_world(&self, words: &mut Words<'_>) -> Result<Option<usize>, String> {
        words.optional_name()?.map(|name| self.link(&name)).transpose()
    }

    pub(crate) fn line(&mut self, keyword: &str, words: &mut Words<'_>) -> Result<(), String> {
        match keyword {
            "input" => self.inputs.push((words.name()?, words.word()?.to_owned())),
            "program" => self.program = (words.name()?, words.word()?.to_owned()),
            "link" => {
                let name = words.name()?;
                if self.link(&name).is_ok() {
                    return Err(format!("link `{name}` was there before"));
                }
                let (parent, pose) = (self.link_or_world(words)?, words.pose()?);
                let joint = if words.is_next("slide") {
                    let axis = axis(words.word()?)?;
                    if ROTARY.contains(&axis) {
                        return Err("A, B and C turn".to_owned());
                    }
                    Some(Joint { axis, direction: words.direction()?, turns: None, gain: ONE })
                } else if words.is_next("turn") {
                    let axis = axis(words.word()?)?;
                    let gain = if ROTARY.contains(&axis) { ONE } else { DEGREE };
                    let (direction, point) = (words.direction()?, words.numbers::<3>()?.map(I::of));
                    Some(Joint { axis, turns: Some(point), direction, gain })
                } else {
                    None
                };
                self.machine.links.push(Link { name, parent, pose, joint });
            }
            "tip" => {
                let (tool, work) = (self.link_or_world(words)?, self.link_or_world(words)?);
                let (gauge, direction) = (words.numbers::<3>()?.map(I::of), words.direction()?);
                self.machine.tip = Some(Tip { tool, work, gauge, direction });
            }
            "part" => {
                let (name, link) = (words.name()?, self.link_or_world(words)?);
                let role = words.word()?.to_owned();
                let tool = if words.is_next("-") { None } else { Some(words.whole()?) };
                if self.parts.iter().any(|part| part.name == name) {
                    return Err(format!("part `{name}` was there before"));
                }
                self.parts.push(Part { name, link, role, tool, pose: words.pose()?, mesh: Mesh::default() });
            }
            _ => self.step(words)?,
        }
        Ok(())
    }

    fn step(&mut self, words: &mut Words<'_>) -> Result<(), String> {
        let (line, tool, course) = (words.whole()?, words.whole()?, words.word()?);
        let from = self.machine.steps.last().map_or([0.0; 9], |step| step.to);
        let (mut to, mut arc, mut tip) = (from, None, None);
        while let Ok(word) = words.word() {
            let (key, value) = word.split_once('=').ok_or("a value without a key")?;
            match key {
                "tip" => tip = Some(number(value)?),
                "arc" => {
                    let parts: Vec<&str> = value.split(',').collect();
                    let [first, second, x, y, sweep] = parts[..] else { return Err("not an arc".to_owned()) };
                    let plane = [axis(first)?, axis(second)?];
                    if plane[0] == plane[1] {
                        return Err("a plane of one axis".to_owned());
                    }
                    arc = Some((plane, [number(x)?, number(y)?], number(sweep)?));
                }
                _ => to[axis(key)?] = number(value)?,
            }
        }
        if !matches!((course, arc), ("point" | "line" | "rapid", None) | ("arc", Some(_))) {
            return Err("no such course".to_owned());
        }
        let (is_point, is_rapid) = (course == "point", course == "rapid");
        self.machine.steps.push(Step { line, tool, is_point, is_rapid, arc, from, to, tip });
        Ok(())
    }
}
