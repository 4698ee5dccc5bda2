//! Control flow: O-words and M98, M99. Labels are matched once before the program runs; then each word is a jump.
//!
//! Meaning as LinuxCNC documents it ("O Codes"): `sub`, `endsub`, `return`, `call`; `if`, `elseif`, `else`, `endif`;
//! `while`, `endwhile`; `do`, `while`; `repeat`, `endrepeat`; `break`, `continue`. `O100` alone starts a subroutine that
//! ends at M99. Subroutines of other files are found by `source`.
//!
//! Loops that are left from inside run on as in LinuxCNC 2.9 (`interp_o_word.cc`). The count of a `repeat` stays until it has run out, though `return`,
//! or `break` or `continue` of a loop around it, has left the loop: the next time it counts on. A `continue` is remembered until the end of a `while`
//! or `repeat` loop is next skipped to, which then begins again; a `break`, until the `while` of a `do` loop is next reached, which then ends. A `break`
//! that is only skipped over, on the way to the end of its loop, is remembered as well.

use super::block::{Block, Flow, Keyword, Label};
use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::interpret::{Interpreter, Next};
use super::macro_flow::Jumps;
use super::modal::{Group, Modes, Values, whole};
use super::offsets::from_canonical;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hasher};

/// At most so many times M99 is compared with the time before: that reads all variables.
const MOST_COMPARED: u32 = 1000;

/// A program that goes round by M99 without P, and is not the same each time, is left once it has more moves.
const MOST_MOVES_OF_ROUNDS: usize = 10_000;

/// Deepest nesting of subroutine calls.
pub const MAX_CALL_DEPTH: usize = 64;

/// A program's lines after parsing; a line that is wrong is an error only when it is executed.
pub(super) type Lines = [Result<Block, Fault>];

/// Partners of a control-flow line, as indices of lines.
#[derive(Clone, Copy, Debug, Default)]
struct Links {
    /// The line that opens the construct.
    open: usize,
    /// The next branch of an `if`.
    next: usize,
    /// The line that closes the construct.
    end: usize,
    /// The last `break` of a loop.
    last_break: Option<usize>,
}

/// Where control goes from each line.
#[derive(Debug)]
pub(super) struct FlowTable {
    links: Vec<Links>,
    /// How many lines are the program's own.
    pub own: usize,
    subroutines: BTreeMap<String, usize>,
    /// Labels with words, assignments or jumps beside them.
    starts_with_words: BTreeSet<usize>,
    /// Of Fanuc's macro language.
    pub jumps: Jumps,
}

/// A construct that is still open while labels are matched.
struct Open<'a> {
    label: &'a str,
    keyword: Keyword,
    line: usize,
    branches: Vec<usize>,
    last_break: Option<usize>,
}

fn flow_fault(flow: &Flow, cause: Cause) -> Fault {
    Fault::new(flow.column, flow.text.clone(), cause)
}

impl FlowTable {
    /// Matches the labels of lines, the first `own` of which are the program's; an error names its line's index.
    pub fn of(lines: &Lines, own: usize) -> Result<Self, (usize, Fault)> {
        let jumps = Jumps::of(lines, own)?;
        let mut table = Self {
            links: vec![Links::default(); lines.len()],
            own,
            subroutines: BTreeMap::new(),
            starts_with_words: BTreeSet::new(),
            jumps,
        };
        let mut open: Vec<Open> = Vec::new();
        for (line, block) in lines.iter().enumerate() {
            if let Ok(Block { flow: Some(flow), .. }) = block
                && let Label::Fixed(label) = &flow.label
            {
                table.link(&mut open, line, label, flow.keyword).map_err(|cause| (line, flow_fault(flow, cause)))?;
                if block.as_ref().is_ok_and(Block::has_more) {
                    table.starts_with_words.insert(line);
                }
            }
        }
        match open.last() {
            None => Ok(table),
            Some(Open { line, .. }) => {
                let flow = lines[*line].as_ref().ok().and_then(|block| block.flow.as_ref());
                let cause = Cause::Flow("is never closed");
                Err((*line, flow.map_or_else(|| Fault::new(1, "", cause.clone()), |f| flow_fault(f, cause.clone()))))
            }
        }
    }

    fn link<'a>(
        &mut self,
        open: &mut Vec<Open<'a>>,
        line: usize,
        label: &'a str,
        keyword: Keyword,
    ) -> Result<(), Cause> {
        let innermost = open.last().filter(|entry| entry.label == label).map(|entry| entry.keyword);
        match keyword {
            Keyword::While if innermost == Some(Keyword::Do) => self.close(open, line),
            Keyword::Sub | Keyword::If | Keyword::While | Keyword::Do | Keyword::Repeat => {
                if keyword == Keyword::Sub {
                    self.define(label, line)?;
                }
                open.push(Open { label, keyword, line, branches: vec![line], last_break: None });
            }
            Keyword::ElseIf | Keyword::Else => match open.last_mut() {
                Some(entry) if innermost == Some(Keyword::If) => entry.branches.push(line),
                _ => return Err(Cause::Flow("has no `if` with this label")),
            },
            Keyword::EndIf if innermost == Some(Keyword::If) => self.close(open, line),
            Keyword::EndSub if innermost == Some(Keyword::Sub) => self.close(open, line),
            Keyword::EndWhile if innermost == Some(Keyword::While) => self.close(open, line),
            Keyword::EndRepeat if innermost == Some(Keyword::Repeat) => self.close(open, line),
            Keyword::EndIf | Keyword::EndSub | Keyword::EndWhile | Keyword::EndRepeat => {
                return Err(Cause::Flow("closes nothing that is open"));
            }
            Keyword::Break | Keyword::Continue => {
                // Of a `repeat` they are errors on LinuxCNC.
                let is_loop = |k| matches!(k, Keyword::While | Keyword::Do);
                let enclosing = open.iter_mut().rev().find(|entry| entry.label == label && is_loop(entry.keyword));
                let entry = enclosing.ok_or(Cause::Flow("is in no `while` or `do` loop with this label"))?;
                self.links[line].open = entry.line;
                if keyword == Keyword::Break {
                    entry.last_break = Some(line);
                }
            }
            // Of two programs of one number the first is found, as on LinuxCNC, which reads a file from its start.
            Keyword::Label => {
                self.subroutines.entry(label.to_owned()).or_insert(line);
            }
            Keyword::Return | Keyword::Call => {}
        }
        Ok(())
    }

    /// Where a subroutine begins: on Fanuc's controls words may stand beside the program's number.
    fn start_of(&self, label: &str) -> Result<usize, Cause> {
        let &line = self.subroutines.get(label).ok_or(Cause::UnknownSubroutine)?;
        Ok(if self.starts_with_words.contains(&line) { line } else { line + 1 })
    }

    /// The lines between `sub` and `endsub` of a label.
    pub fn body(&self, label: &str) -> Option<std::ops::Range<usize>> {
        let &line = self.subroutines.get(label)?;
        let end = self.links[line].end;
        (end > line).then(|| line + 1..end)
    }

    fn define(&mut self, label: &str, line: usize) -> Result<(), Cause> {
        match self.subroutines.insert(label.to_owned(), line) {
            None => Ok(()),
            Some(_) => Err(Cause::Flow("subroutine is defined twice")),
        }
    }

    fn close(&mut self, open: &mut Vec<Open>, line: usize) {
        let Some(entry) = open.pop() else { return };
        for (i, &branch) in entry.branches.iter().enumerate() {
            let next = entry.branches.get(i + 1).copied().unwrap_or(line);
            self.links[branch] = Links { open: entry.line, next, end: line, last_break: entry.last_break };
        }
        self.links[line] = Links { open: entry.line, next: line, end: line, last_break: None };
    }
}

/// A call that has not returned.
#[derive(Debug)]
struct Call {
    /// Index of the line to go on with.
    back: usize,
    /// First line of the body, and how often it still runs: M98 with L.
    start: usize,
    again: i32,
    /// What M73 has asked to be restored.
    restore: Option<Kept>,
}

/// What M70 and M73 keep.
#[derive(Clone, Debug)]
struct Kept {
    modes: Modes,
    /// Whether a tool offset was in force (G43), and G92.
    has_tool_offset: bool,
    is_shifted: bool,
    /// Under tool-centre-point control, the tool's length, mm.
    tip_mm: Option<f64>,
    /// Cutter compensation's code.
    compensation: Option<i32>,
}

/// Where control is.
#[derive(Debug, Default)]
pub(super) struct Control {
    calls: Vec<Call>,
    /// How often the body of a `repeat` still runs, by its line.
    repeats: BTreeMap<usize, f64>,
    /// Whether the next loops still see an earlier `break`, as on LinuxCNC.
    breaks: bool,
    /// The same of a `continue`.
    continues: bool,
    /// The modes that M70 kept, for each level of calls that has kept some.
    kept: BTreeMap<usize, Kept>,
    /// How often M99 without P was reached in the main program.
    rounds: u32,
    /// How often M99 or M99 P was reached there.
    jumps: u32,
    /// A hash of all variables and the axis positions when M99 of each line was last reached.
    at_jumps: BTreeMap<usize, u64>,
}

impl Control {
    /// How many subroutines are running.
    pub fn depth(&self) -> usize {
        self.calls.len()
    }

    /// Whether the subroutine that runs began at a line, which may be its label with words beside it.
    pub fn began_at(&self, at: usize) -> bool {
        self.calls.last().is_some_and(|call| call.start == at)
    }
}

impl Interpreter<'_> {
    /// Obeys a control-flow line at index `at`: the index of the line to go on with.
    pub(super) fn obey_flow(
        &mut self,
        table: &FlowTable,
        lines: &Lines,
        flow: &Flow,
        at: usize,
    ) -> Result<usize, Fault> {
        let links = table.links[at];
        Ok(match flow.keyword {
            Keyword::Sub => links.end + 1,
            Keyword::Label | Keyword::EndIf | Keyword::Do => at + 1,
            Keyword::Call => return self.call(table, flow, at),
            Keyword::Return | Keyword::EndSub => {
                if self.control.calls.is_empty() {
                    return Err(flow_fault(flow, Cause::Flow("is not in a subroutine that was called")));
                }
                if let Some(value) = flow.arguments.first() {
                    let value = value.evaluate(&self.parameters)?;
                    self.parameters.set_returned(Some(value));
                } else {
                    self.parameters.set_returned(None);
                }
                self.leave_subroutine().map_err(|cause| flow_fault(flow, cause))?.unwrap_or(at + 1)
            }
            Keyword::If => return self.choose_branch(table, lines, at),
            // Reached from above: the branch before has run.
            Keyword::ElseIf | Keyword::Else => links.end + 1,
            Keyword::While if links.end == at => {
                let holds = self.condition(flow)?;
                let breaks = std::mem::take(&mut self.control.breaks);
                if holds && !breaks { links.open + 1 } else { at + 1 }
            }
            Keyword::While if self.condition(flow)? => at + 1,
            Keyword::While => self.skip_loop(table, lines, at, at),
            Keyword::EndWhile | Keyword::EndRepeat => links.open,
            Keyword::Repeat => {
                let times = flow.arguments[0].number(&self.parameters)?.round();
                let left = self.control.repeats.entry(at).or_insert(times);
                *left -= 1.0;
                if *left >= 0.0 {
                    return Ok(at + 1);
                }
                self.control.repeats.remove(&at);
                self.skip_loop(table, lines, at, at)
            }
            Keyword::Break => self.skip_loop(table, lines, at, links.open),
            Keyword::Continue => {
                self.control.continues = true;
                self.skip_loop(table, lines, at, links.open)
            }
        })
    }

    /// The line to go on with when control skips from the line `from` to the end of the loop that begins at line `open`: of a `do` loop its `while`; else
    /// the line behind, or the loop's begin where a `continue` is remembered. A `break` of the loop on the way, or at `from`, is remembered.
    fn skip_loop(&mut self, table: &FlowTable, lines: &Lines, from: usize, open: usize) -> usize {
        let Links { end, last_break, .. } = table.links[open];
        self.control.breaks |= last_break >= Some(from);
        let is_do = matches!(&lines[open], Ok(Block { flow: Some(Flow { keyword: Keyword::Do, .. }), .. }));
        if is_do {
            end
        } else if std::mem::take(&mut self.control.continues) {
            open
        } else {
            end + 1
        }
    }

    fn condition(&self, flow: &Flow) -> Result<bool, Fault> {
        Ok(flow.arguments[0].number(&self.parameters)? != 0.0)
    }

    fn choose_branch(&mut self, table: &FlowTable, lines: &Lines, start: usize) -> Result<usize, Fault> {
        let mut at = start;
        loop {
            let Ok(Block { flow: Some(flow), .. }) = &lines[at] else { return Ok(at + 1) };
            self.at = at;
            let taken = match flow.keyword {
                Keyword::If | Keyword::ElseIf => self.condition(flow)?,
                _ => true,
            };
            if taken {
                return Ok(at + 1);
            }
            at = table.links[at].next;
        }
    }

    fn call(&mut self, table: &FlowTable, flow: &Flow, at: usize) -> Result<usize, Fault> {
        let label = match &flow.label {
            Label::Fixed(label) => label.clone(),
            Label::Computed(number) => format!("{}", number.evaluate(&self.parameters)?.round()),
        };
        let arguments: Result<Vec<f64>, Fault> =
            flow.arguments.iter().map(|argument| argument.evaluate(&self.parameters)).collect();
        let arguments = arguments?;
        let start = table.start_of(&label).map_err(|cause| flow_fault(flow, cause))?;
        self.enter_lines(start, at, 1, Some(&arguments)).map_err(|cause| flow_fault(flow, cause))
    }

    /// Calls the lines from `start` on, from the line `at`, with arguments or with the caller's parameters.
    fn enter_lines(&mut self, start: usize, at: usize, times: i32, arguments: Option<&[f64]>) -> Result<usize, Cause> {
        if self.control.calls.len() >= MAX_CALL_DEPTH {
            return Err(Cause::Limit { limit: MAX_CALL_DEPTH, what: "subroutine calls inside one another" });
        }
        match arguments {
            Some(arguments) => self.parameters.enter(arguments),
            None => self.parameters.enter_plain(),
        }
        self.control.calls.push(Call { back: at + 1, start, again: times - 1, restore: None });
        Ok(start)
    }

    /// Where to go on behind the present subroutine; `None` in the main program.
    fn leave_subroutine(&mut self) -> Result<Option<usize>, Cause> {
        let Some(call) = self.control.calls.last_mut() else { return Ok(None) };
        if call.again > 0 {
            call.again -= 1;
            return Ok(Some(call.start));
        }
        let back = call.back;
        let kept = self.control.calls.pop().and_then(|call| call.restore);
        self.parameters.leave();
        if let Some(kept) = kept {
            self.restore(&kept)?;
        }
        Ok(Some(back))
    }

    /// M70 keeps the modes, M71 forgets them, M72 restores them; M73 restores them when the subroutine returns.
    pub(super) fn keep_or_restore_modes(&mut self, values: &Values) -> Result<(), Fault> {
        let level = self.control.depth();
        let Some(code) = values.code(Group::State) else { return Ok(()) };
        match code.number {
            70 => {
                let kept = self.kept();
                self.control.kept.insert(level, kept);
            }
            71 => {
                self.control.kept.remove(&level);
            }
            72 => {
                if let Some(kept) = self.control.kept.get(&level).cloned() {
                    self.restore(&kept).map_err(|cause| code.fault(cause))?;
                }
            }
            _ => {
                let kept = self.kept();
                if let Some(call) = self.control.calls.last_mut() {
                    call.restore = Some(kept);
                }
            }
        }
        Ok(())
    }

    fn kept(&self) -> Kept {
        Kept {
            modes: self.modes.clone(),
            has_tool_offset: self.offsets.tool != [0.0; 9],
            is_shifted: self.offsets.shift != [0.0; 9],
            tip_mm: self.tip_mm,
            compensation: self.compensation.on().map(|offset| offset.code),
        }
    }

    /// Restores what was kept; the motion code is not a part of it (LinuxCNC, "M70"). A tool offset that was cancelled since becomes that of
    /// the tool in the spindle: LinuxCNC executes `G43` (`interp_convert.cc`, `gen_settings`).
    fn restore(&mut self, kept: &Kept) -> Result<(), Cause> {
        let now = self.kept();
        for (differs, why) in [
            (now.compensation != kept.compensation, "kept modes come back where cutter compensation is another"),
            (now.is_shifted != kept.is_shifted, "kept modes come back where G92 is another"),
            (now.tip_mm != kept.tip_mm, "kept modes come back where tool-centre-point control is another"),
        ] {
            if differs {
                return Err(Cause::NotAllowed(why));
            }
        }
        if now.has_tool_offset != kept.has_tool_offset {
            if now.compensation.is_some() {
                return Err(Cause::NotAllowed("another tool offset while cutter compensation is on"));
            }
            self.offsets.tool = match self.tools.get(&self.tool) {
                Some(tool) if kept.has_tool_offset => from_canonical(&tool.offset),
                None if kept.has_tool_offset && self.tool != 0 => return Err(Cause::UnknownTool),
                _ => [0.0; 9],
            };
        }
        let mut modes = kept.modes.clone();
        if modes.feed != 0.0 {
            // LinuxCNC executes F in the kept unit, in which F of a block with G20 or G21 was not meant.
            modes.feed = modes.turning_feed * modes.unit_mm();
        }
        if now.compensation.is_some() {
            (modes.plane, modes.system) = (self.modes.plane, self.modes.system);
        }
        self.change_system(modes.system);
        self.modes = Modes { motion: self.modes.motion, spindle: self.modes.spindle, ..modes };
        self.note_units();
        Ok(())
    }

    /// M97, M98 and M99 at the end of a block at index `at`.
    pub(super) fn obey_subprogram(&mut self, table: &FlowTable, values: &Values, at: usize) -> Result<Next, Fault> {
        let Some(code) = values.code(Group::Subprogram) else { return Ok(Next::Line(at + 1)) };
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        if code.number == 99 {
            let to = if like_fanuc { values.take('p') } else { None };
            let depth = self.control.depth();
            let back = self.leave_subroutine().map_err(|cause| code.fault(cause))?;
            let Some(back) = back else { return self.end_main(table, to, values, at) };
            // A body that runs again does not go elsewhere; from the caller's line P is looked for.
            let again = self.control.depth() == depth;
            return Ok(Next::Line(match to {
                Some(number) if !again => {
                    self.line_of(table, number, back - 1).map_err(|cause| values.fault('p', cause))?
                }
                _ => back,
            }));
        }
        let number = values.take('p').ok_or_else(|| code.fault(Cause::Missing("P, the subroutine's number,")))?;
        let Some(label) = whole(number).filter(|&number| number >= 0) else {
            return Err(values.fault('p', Cause::Range("P", "a subroutine's number")));
        };
        let given = values.take_whole('l', 0..=1_000_000, "L", "a whole number from 0 to 1000000")?;
        // Without L, Fanuc's P has the repeats before the last four digits: P31000 runs O1000 three times. Haas's is O31000.
        let (label, times) = match given {
            None if self.setup.dialect == Dialect::Fanuc
                && code.number == 98
                && label > 9999
                && !table.subroutines.contains_key(&label.to_string()) =>
            {
                (label % 10_000, label / 10_000)
            }
            given => (label, given.unwrap_or(1)),
        };
        if times == 0 {
            return Ok(Next::Line(at + 1));
        }
        let fault = |cause| values.fault('p', cause);
        let line = if code.number == own::LOCAL_CALL {
            // The line of the number itself is executed.
            self.line_of(table, f64::from(label), at)
        } else {
            table.start_of(&label.to_string())
        };
        let start = line.map_err(fault)?;
        self.enter_lines(start, at, times, None).map(Next::Line).map_err(fault)
    }

    /// Whether the M99 of line `at` was reached before in the same state: then it goes round for ever.
    fn goes_round(&mut self, at: usize) -> bool {
        self.control.jumps += 1;
        if self.control.jumps > MOST_COMPARED {
            return false;
        }
        let mut state = DefaultHasher::new();
        self.parameters.bits().chain(self.position.map(f64::to_bits)).for_each(|bits| state.write_u64(bits));
        let state = state.finish();
        self.control.at_jumps.insert(at, state) == Some(state)
    }

    /// M99 in the main program: on with line N`to`, else with the first line. It goes round for ever if nothing has changed since it was last reached; the
    /// last round is from where the one before ends. Without P most programs go round until somebody stops them, so that what changes is followed only so far.
    fn end_main(&mut self, table: &FlowTable, to: Option<f64>, values: &Values, at: usize) -> Result<Next, Fault> {
        let code = if to.is_some() { "M99 P" } else { "M99" };
        if self.goes_round(at) {
            self.note(format!("{code} goes round for ever; it is followed until a round changes nothing"));
            return Ok(Next::End);
        }
        if let Some(number) = to {
            return self.line_of(table, number, at).map(Next::Line).map_err(|cause| values.fault('p', cause));
        }
        self.control.rounds += 1;
        let rounds = self.control.rounds;
        if rounds > 1 && (rounds > MOST_COMPARED || self.moves.len() > MOST_MOVES_OF_ROUNDS) {
            self.note_unknown(format!("M99 starts the program again, and variables or axes change from round to round; behind {rounds} rounds it is not followed"));
            return Ok(Next::End);
        }
        Ok(Next::Line(0))
    }

    /// G65: a subprogram with the block's words as its arguments.
    pub(super) fn call_macro(&mut self, table: &FlowTable, values: &Values, at: usize) -> Result<Next, Fault> {
        let Some(code) = values.code(Group::Subprogram) else { return Ok(Next::Line(at + 1)) };
        if let Some(other) = values.codes().find(|other| other.column != code.column) {
            return Err(other.fault(Cause::NotAllowed("another code beside G65")));
        }
        let number = values.take('p').ok_or_else(|| code.fault(Cause::Missing("P, the macro's number,")))?;
        let label = whole(number).filter(|&number| number >= 0);
        let label = label.ok_or_else(|| values.fault('p', Cause::Range("P", "a macro's number")))?;
        let times = values.take_whole('l', 1..=1_000_000, "L", "a whole number from 1 to 1000000")?.unwrap_or(1);
        let columns = ['i', 'j', 'k'].map(|letter| values.column(letter)).into_iter().flatten();
        if !columns.is_sorted() {
            return Err(code.fault(Cause::NotAllowed(SECOND_ARGUMENTS)));
        }
        self.note_missing_points(values, "ijkqr");
        let mut arguments = [f64::NAN; 26];
        for (letter, value) in values.words() {
            if let Some(variable) = ARGUMENTS.iter().find(|entry| entry.0 == letter) {
                arguments[variable.1 - 1] = value;
            }
        }
        let line =
            table.start_of(&label.to_string()).and_then(|start| self.enter_lines(start, at, times, Some(&arguments)));
        line.map(Next::Line).map_err(|cause| values.fault('p', cause))
    }
}

/// Why I, J and K of G65 must stand in their order, and once.
pub(super) const SECOND_ARGUMENTS: &str = "I, J and K of G65 out of their order, or twice: the control takes argument specification II, in which they are other variables";

/// The local variable that each word of G65 sets.
const ARGUMENTS: [(char, usize); 20] = [
    ('a', 1),
    ('b', 2),
    ('c', 3),
    ('i', 4),
    ('j', 5),
    ('k', 6),
    ('d', 7),
    ('e', 8),
    ('f', 9),
    ('h', 11),
    ('q', 17),
    ('r', 18),
    ('s', 19),
    ('t', 20),
    ('u', 21),
    ('v', 22),
    ('w', 23),
    ('x', 24),
    ('y', 25),
    ('z', 26),
];
