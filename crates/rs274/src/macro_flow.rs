//! Control flow of Fanuc's macro language: IF, GOTO, WHILE, DO and END. Every jump is a step of the program, so that the limit of steps holds.
//!
//! GOTO goes to the next line with the number behind it, else to the first from the start of its program: from one O to the next.

use super::block::{Block, Jump, Keyword};
use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::whole;
use super::oword::{FlowTable, Lines};
use std::collections::BTreeMap;

/// Where the macro language's jumps lead, by indices of lines.
#[derive(Debug, Default)]
pub(super) struct Jumps {
    /// Between DO and END, both ways.
    partners: BTreeMap<usize, usize>,
    /// Lines with a number, in their order.
    numbered: BTreeMap<u32, Vec<usize>>,
    /// Where programs begin, in their order.
    programs: Vec<usize>,
}

impl Jumps {
    /// Matches DO and END. An error names its line's index.
    pub fn of(lines: &Lines, own: usize) -> Result<Self, (usize, Fault)> {
        let mut jumps = Self { programs: vec![0, own], ..Self::default() };
        let mut open: Vec<(u32, usize)> = Vec::new();
        for (at, block) in lines.iter().enumerate() {
            let Ok(block) = block else { continue };
            if block.flow.as_ref().is_some_and(|flow| flow.keyword == Keyword::Label) {
                jumps.programs.push(at);
            }
            if let Some(number) = block.sequence {
                jumps.numbered.entry(number).or_default().push(at);
            }
            match block.jump {
                Some(Jump::Do(number)) => open.push((number, at)),
                Some(Jump::End(number)) => match open.pop() {
                    Some((opened, start)) if opened == number => {
                        jumps.partners.insert(start, at);
                        jumps.partners.insert(at, start);
                    }
                    _ => return Err((at, fault(format!("END{number}"), "has no DO with this number before it"))),
                },
                _ => {}
            }
        }
        jumps.programs.sort_unstable();
        match open.pop() {
            Some((number, at)) => Err((at, fault(format!("DO{number}"), "is never ended by END with this number"))),
            None => Ok(jumps),
        }
    }

    /// The line with a number, seen from the line `at`.
    pub fn line(&self, number: u32, at: usize) -> Option<usize> {
        let lines = self.lines(number, at);
        lines.iter().copied().find(|&line| line > at).or_else(|| lines.first().copied())
    }

    /// The lines with a number in the program of the line `at`, in their order.
    fn lines(&self, number: u32, at: usize) -> &[usize] {
        let after = self.programs.partition_point(|&start| start <= at);
        let (start, end) = (self.programs[after - 1], self.programs.get(after).copied().unwrap_or(usize::MAX));
        let lines = self.numbered.get(&number).map_or(&[][..], Vec::as_slice);
        let before = |border: usize| lines.partition_point(|&line| line < border);
        &lines[before(start)..before(end)]
    }
}

/// The error for an N that no line has.
const NO_LINE: Cause = Cause::Flow("there is no line with this number N");

fn sequence(number: f64) -> Option<u32> {
    whole(number).and_then(|number| u32::try_from(number).ok())
}

fn fault(text: String, why: &'static str) -> Fault {
    Fault::new(1, text, Cause::Flow(why))
}

impl Interpreter<'_> {
    /// Obeys the macro language's words of the line `at`: where to go on, or `None` to execute the rest of the line.
    pub(super) fn obey_macro_word(
        &mut self,
        block: &Block,
        table: &FlowTable,
        at: usize,
    ) -> Result<Option<usize>, Fault> {
        let holds = match &block.condition {
            Some(condition) if self.setup.dialect == Dialect::Fanuc && !condition.compares() => {
                let why = "a condition that compares nothing, which Fanuc's controls refuse";
                return Err(Fault::new(1, "", Cause::NotAllowed(why)));
            }
            Some(condition) => condition.number(&self.parameters)? != 0.0,
            None => true,
        };
        let partner = || table.jumps.partners.get(&at).copied().unwrap_or(at);
        Ok(match &block.jump {
            Some(Jump::Do(_)) if !holds => Some(partner() + 1),
            Some(Jump::End(_)) => Some(partner()),
            _ if !holds => Some(at + 1),
            Some(Jump::Do(_)) => Some(at + 1),
            Some(Jump::Goto(target)) => {
                let number = target.evaluate(&self.parameters)?;
                Some(self.line_of(table, number, at).map_err(|cause| Fault::new(1, format!("GOTO {number}"), cause))?)
            }
            None => None,
        })
    }

    /// The index of the line N`number`, seen from the line `at`.
    pub(super) fn line_of(&self, table: &FlowTable, number: f64, at: usize) -> Result<usize, Cause> {
        sequence(number).and_then(|number| table.jumps.line(number, at)).ok_or(NO_LINE)
    }

    /// The index of the only line N`number` in the program of the line `at`.
    pub(super) fn only_line_of(&self, table: &FlowTable, number: f64, at: usize) -> Result<usize, Cause> {
        match sequence(number).map_or(&[][..], |number| table.jumps.lines(number, at)) {
            [] => Err(NO_LINE),
            [line] => Ok(*line),
            _ => Err(Cause::Flow(
                "more than one line of this program has this number N: give each contour numbers of its own",
            )),
        }
    }
}
