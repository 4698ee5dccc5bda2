//! What `check` found, as a list that reports for other programs are made of: each finding with its rule and its line.

use super::stock::{Left, lacks};
use super::{Checked, axes, clock, near_pairs, tool_without_part};
use crate::check::{Event, Extent, Kind, OverTravel};
use crate::scene::{Pair, ProgramRun, Scene};
use rs274::Move;

/// A kind of finding.
pub struct Rule {
    /// Its name in every output of `check`.
    pub id: &'static str,
    /// The same as one word.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub what: &'static str,
    /// What it means and what to do about it.
    pub help: &'static str,
    /// Whether it is nearness and no fault.
    pub is_note: bool,
}

/// Every rule; [`rule`] finds an event's.
pub const RULES: [Rule; 11] = [
    Rule {
        id: "collision",
        name: "Collision",
        what: "Two parts touch, or one is inside the other.",
        help: "Everything that touches collides, but for the cutter that feeds into the workpiece. Contact before the first move has no line of \
            its own and is shown at line 1: parts that are built so belong into `allow` of `[check]` in scene.toml.",
        is_note: false,
    },
    Rule {
        id: "rapid-into-workpiece",
        name: "RapidIntoWorkpiece",
        what: "The cutter comes into the workpiece at rapid rate.",
        help: "Stop the rapid above the workpiece and feed in, or retract before the move. A wrong work offset or tool length shows like this too.",
        is_note: false,
    },
    Rule {
        id: "tool-change-into-workpiece",
        name: "ToolChangeIntoWorkpiece",
        what: "A tool is in the workpiece when it is put into the spindle.",
        help: "Retract before M6, or give the machine's change position as `tool_change` of `[program]` in scene.toml.",
        is_note: false,
    },
    Rule {
        id: "stopped-spindle-into-workpiece",
        name: "StoppedSpindleIntoWorkpiece",
        what: "The cutter feeds into the workpiece while the spindle stands still.",
        help: "Start the spindle (M3 or M4 with S) before the feed move.",
        is_note: false,
    },
    Rule {
        id: "gouge",
        name: "Gouge",
        what: "The cutter goes deeper into the finished workpiece than it may.",
        help: "`gouge_mm` of `[check]` in scene.toml says how deep it may go; the depth is in the message.",
        is_note: false,
    },
    Rule {
        id: "unresolved",
        name: "UnresolvedContact",
        what: "A part may come into what is left of the workpiece, deeper than the resolution of the stock, or may touch another as its spindle turns it.",
        help: "Whether it does is not known: the message says how deep at most. `--stock-resolution` with a smaller length may decide it; open meshes of \
            workpiece or cutter have to be closed; else look at the move. What a spindle turns is taken for rings around its axis.",
        is_note: false,
    },
    Rule {
        id: "over-travel",
        name: "OverTravel",
        what: "An axis leaves its limits.",
        help: "Limits are those of the joints in scene.toml. Look at the work offset first: it moves the whole program.",
        is_note: false,
    },
    Rule {
        id: "tool-without-part",
        name: "ToolWithoutPart",
        what: "A tool in use has no part in the scene, so nobody knows what it meets.",
        help: "Draw the tool (`tool = N` of a part), or give its measures with `--tool`. Where the program feeds with none, `tool` of `[program]` says which is there at \
            first.",
        is_note: false,
    },
    Rule {
        id: "target-gouge",
        name: "TargetGouge",
        what: "What is left of the workpiece lacks, or may lack, some of the wanted part of `--target`.",
        help: "The message says how deep and how much, and whether it is cut away or was never in the workpiece. What is not decided, another `--stock-resolution` may decide. Which \
            line cuts it is not known, so it is shown at line 1.",
        is_note: false,
    },
    Rule {
        id: "not-proved",
        name: "NotProved",
        what: "A block is not proved free of contact by `--certify`.",
        help: "The block is proved to be in contact, or the search found no proof: the message says which, and of which parts.",
        is_note: false,
    },
    Rule {
        id: "near",
        name: "NearMiss",
        what: "Two parts come nearer than a clearance without touching.",
        help: "One note for each pair, at the line where it is nearest. `--clearance` sets the distances; 0 asks for none.",
        is_note: true,
    },
];

fn rule(id: &str) -> &'static Rule {
    // Every kind has its rule: a test asks for them all.
    RULES.iter().find(|rule| rule.id == id).unwrap_or(&RULES[0])
}

/// Something found at a line of the program.
pub struct Finding<'a> {
    /// What kind it is of.
    pub rule: &'static Rule,
    /// The line, from 1; 1 for what is there before the first move, and for what has no line.
    pub line: u32,
    /// Text of the line.
    pub block: &'a str,
    /// What happens, where and when, in a sentence.
    pub message: String,
    /// The parts, where it is of two.
    pub pair: Option<Pair>,
    /// The axis, tool or workpiece, where it is of one.
    pub subject: String,
    /// When, s from the program's start.
    pub time_s: Option<f64>,
    /// The least distance, mm, and where it happens, where it is of two parts.
    pub at: Option<(f64, &'a Extent)>,
}

/// Whatever makes a check fail: collisions and over-travel by time, tools without parts, what the wanted part lacks or may lack, blocks without a proof. Then a near miss for each
/// pair.
pub fn findings<'a>(checked: &'a Checked<'_>) -> Vec<Finding<'a>> {
    let Checked { scene, run, outcome, left, certificate, .. } = checked;
    let (collisions, near): (Vec<&Event>, Vec<&Event>) =
        outcome.events.iter().partition(|event| event.kind.is_collision());
    let mut found: Vec<Finding<'_>> = collisions.iter().map(|event| of_collision(scene, event)).collect();
    found.extend(outcome.over_travel.iter().map(of_over_travel));
    found.sort_by(|a, b| a.time_s.unwrap_or_default().total_cmp(&b.time_s.unwrap_or_default()));
    found.extend(outcome.tools_without_parts.iter().map(|&tool| of_tool(run, tool)));
    found.extend(left.iter().filter_map(|left| of_target(scene, left)));
    let cut: Vec<usize> = outcome.remaining.iter().map(|remaining| remaining.part).collect();
    let unproved = certificate.iter().flat_map(|written| written.unproved(scene, &cut));
    found.extend(unproved.map(|(line, message)| of_line("not-proved", run, line, message)));
    found.extend(near_pairs(&near, &collisions).into_iter().filter_map(|(events, _)| of_near_miss(scene, &events)));
    found
}

fn of_collision<'a>(scene: &Scene, event: &'a Event) -> Finding<'a> {
    let rule = rule(event.kind.name());
    let what = match &event.kind {
        Kind::Gouge => format!("gouge {:.3} mm deep", -event.least_mm),
        kind if event.depth_mm.is_some() => {
            format!("{}, {}", kind.name().replace('-', " "), super::stock::depth(event).unwrap_or_default())
        }
        kind => kind.name().replace('-', " "),
    };
    let inside = if event.inside { ", one inside the other" } else { "" };
    let ends = match (event.to_the_end, event.last.line) {
        (true, _) => "contact never ends".to_owned(),
        (false, line) => format!("contact ends on line {line}"),
    };
    let begin = if event.first.line == 0 { "before the first move" } else { "into the program" };
    let when = if event.first.line == 0 { String::new() } else { format!("{} ", clock(event.first.time_s)) };
    let message =
        format!("{}: {what}{inside}, {when}{begin}, at {}; {ends}", scene.pair_name(event.pair), axes(&event.first));
    let (line, block) = (event.first.line.max(1), event.block.as_str());
    Finding {
        rule,
        line,
        block,
        message,
        pair: Some(event.pair),
        subject: String::new(),
        time_s: Some(event.first.time_s),
        at: Some((event.least_mm, &event.first)),
    }
}

fn of_over_travel(over: &OverTravel) -> Finding<'_> {
    let message = format!("{}, {} into the program", over.cause, clock(over.time_s));
    let (rule, subject, time_s) = (rule("over-travel"), over.cause.axis.to_string(), Some(over.time_s));
    Finding { rule, line: over.line, block: &over.block, message, pair: None, subject, time_s, at: None }
}

/// A finding of a line as a whole.
fn of_line<'a>(id: &str, run: &'a ProgramRun, line: u32, message: String) -> Finding<'a> {
    let (rule, block, line, subject) = (rule(id), run.block(line), line.max(1), String::new());
    Finding { rule, line, block, message, pair: None, subject, time_s: None, at: None }
}

/// At the first feed with the tool, else at its first move.
fn of_tool(run: &ProgramRun, tool: u32) -> Finding<'_> {
    let feeds = |step: &&Move| step.kind.is_feed();
    let with_it: Vec<&Move> =
        run.program.moves.iter().zip(run.tools()).filter(|&(_, other)| other == tool).map(|(step, _)| step).collect();
    let first = with_it.iter().copied().find(feeds).or_else(|| with_it.first().copied());
    let finding = of_line("tool-without-part", run, first.map_or(1, |step| step.line), tool_without_part(&tool));
    Finding { subject: format!("tool {tool}"), ..finding }
}

fn of_target(scene: &Scene, left: &Left) -> Option<Finding<'static>> {
    let subject = scene.parts[left.part].name.clone();
    let message = format!("{subject}: {}", lacks(left.comparison.as_ref()?)?);
    let rule = rule("target-gouge");
    Some(Finding { rule, line: 1, block: "", message, pair: None, subject, time_s: None, at: None })
}

fn of_near_miss<'a>(scene: &Scene, events: &[&'a Event]) -> Option<Finding<'a>> {
    let event = *events.iter().min_by(|a, b| a.least_mm.total_cmp(&b.least_mm))?;
    let times = if events.len() == 1 { "once".to_owned() } else { format!("{} times", events.len()) };
    let Kind::Near { zone_mm } = event.kind else { return None };
    let message = format!(
        "{}: nearer than {zone_mm} mm {times}, nearest {:.3} mm, {} into the program, at {}",
        scene.pair_name(event.pair),
        event.least_mm,
        clock(event.nearest.time_s),
        axes(&event.nearest),
    );
    // The block of an event is the one where it begins.
    let block = if event.first.line == event.nearest.line { event.block.as_str() } else { "" };
    Some(Finding {
        rule: rule(event.kind.name()),
        line: event.nearest.line.max(1),
        block,
        message,
        pair: Some(event.pair),
        subject: String::new(),
        time_s: Some(event.nearest.time_s),
        at: Some((event.least_mm, &event.nearest)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_rule_of_its_name() {
        let kinds = [
            Kind::Collision,
            Kind::RapidIntoWorkpiece,
            Kind::ToolChangeIntoWorkpiece,
            Kind::StoppedSpindleIntoWorkpiece,
            Kind::Gouge,
            Kind::Unresolved,
            Kind::Near { zone_mm: 2.0 },
        ];
        for kind in kinds {
            let rule = rule(kind.name());
            assert_eq!((rule.id, rule.is_note), (kind.name(), !kind.is_collision()));
        }
        for id in ["over-travel", "tool-without-part", "target-gouge", "not-proved"] {
            assert_eq!(rule(id).id, id);
        }
        let mut ids: Vec<_> = RULES.iter().map(|rule| rule.id).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), RULES.len());
    }
}
