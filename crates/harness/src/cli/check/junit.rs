//! Findings as JUnit XML: what test pages of continuous integration show. A test case for each examined pair, and one each for the limits of the
//! axes, the tools, the wanted part, the proof and how the program is read; attributes are those that all readers of the format allow.

use super::findings::{Finding, findings};
use super::{Checked, not_examined, tool_without_part};
use anyhow::Result;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event as Xml};
use std::ffi::OsStr;

/// A test case.
struct Case {
    name: String,
    /// Element, kind, message, and what stands in it, where it did not pass.
    failed: Option<(&'static str, String, String, String)>,
    /// What else there is to say.
    output: String,
}

/// A report of one suite.
///
/// # Errors
/// When it cannot be written as XML.
pub fn report(checked: &Checked<'_>) -> Result<String> {
    let Checked { scene, run, outcome, variant, times, left, certificate } = checked;
    let found = findings(checked);
    let file = run.file.to_string_lossy();
    let program = run.file.file_name().unwrap_or(OsStr::new("")).to_string_lossy();
    let at_line = |finding: &Finding<'_>| format!("{file}:{}: {}", finding.line, finding.message);
    let case = |name: &str, of_case: &[&Finding<'_>]| {
        let (faults, notes): (Vec<&Finding<'_>>, Vec<&Finding<'_>>) =
            of_case.iter().partition(|finding| !finding.rule.is_note);
        let told = |findings: &[&Finding<'_>]| {
            let line = |finding: &&Finding<'_>| match finding.block {
                "" => at_line(finding),
                block => format!("{}\n    {block}", at_line(finding)),
            };
            findings.iter().map(line).collect::<Vec<_>>().join("\n")
        };
        let failed = faults.first().map(|first| {
            let more = if faults.len() > 1 { format!(" (and {} more)", faults.len() - 1) } else { String::new() };
            let message = format!("line {}: {}{more}", first.line, first.message);
            ("failure", first.rule.id.to_owned(), message, told(&faults))
        });
        Case { name: format!("{program}: {name}"), failed, output: told(&notes) }
    };
    let examined = outcome.decisions.iter().filter(|decision| decision.dropped.is_none());
    let mut cases: Vec<Case> = examined
        .map(|decision| {
            let of_pair: Vec<_> = found.iter().filter(|finding| finding.pair == Some(decision.pair)).collect();
            case(&scene.pair_name(decision.pair), &of_pair)
        })
        .collect();
    let is_compared = left.iter().any(|left| left.comparison.is_some());
    for (name, id, is_asked) in [
        ("limits of the axes", "over-travel", true),
        ("tools in use", "tool-without-part", true),
        ("the wanted part", "target-gouge", is_compared),
        ("proof of each block", "not-proved", certificate.is_some()),
    ] {
        let of_rule: Vec<&Finding<'_>> = found.iter().filter(|finding| finding.rule.id == id).collect();
        cases.extend(is_asked.then(|| case(name, &of_rule)));
    }
    let notes: Vec<String> = run.program.notes.iter().map(ToString::to_string).collect();
    let name = format!("{program}: how the program is read");
    cases.push(Case { name, failed: None, output: notes.join("\n") });
    let tools: Vec<String> = outcome.tools_without_parts.iter().map(tool_without_part).collect();
    for text in not_examined(scene, run, outcome).into_iter().filter(|text| !tools.contains(text)) {
        let what = text.strip_prefix("not examined: ").unwrap_or(&text);
        let failed = Some(("skipped", String::new(), "not examined".to_owned(), String::new()));
        cases.push(Case { name: format!("{program}: {what}"), failed, output: String::new() });
    }
    let properties = [
        ("program", file.to_string()),
        ("dialect", run.setup.dialect.to_string()),
        ("method", variant.info.id.to_owned()),
        ("program_time_s", format!("{:.3}", outcome.duration_s)),
    ];
    write(&scene.name, &cases, &properties, times.load_s + times.check_s)
}

/// A report of a check that came to no answer.
///
/// # Errors
/// When it cannot be written as XML.
pub fn failure(scene: &str, program: &str, error: &str) -> Result<String> {
    let failed = Some(("error", "no-answer".to_owned(), error.to_owned(), error.to_owned()));
    let case = Case { name: format!("{program}: no answer"), failed, output: String::new() };
    write(scene, &[case], &[], 0.0)
}

fn write(suite: &str, cases: &[Case], properties: &[(&str, String)], seconds: f64) -> Result<String> {
    let count =
        |element: &str| cases.iter().filter(|case| case.failed.as_ref().is_some_and(|f| f.0 == element)).count();
    let [failures, errors, skipped] = ["failure", "error", "skipped"].map(|element| count(element).to_string());
    let (tests, time) = (cases.len().to_string(), format!("{seconds:.3}"));
    let of_all = [("tests", &tests), ("failures", &failures), ("errors", &errors), ("time", &time)];
    let of_all = of_all.map(|(name, value)| (name, value.as_str()));
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    writer.write_event(Xml::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let suites = BytesStart::new("testsuites").with_attributes([("name", "bvbench check")]);
    writer.write_event(Xml::Start(suites.with_attributes(of_all)))?;
    let (suite, skipped) = (legal(suite), ("skipped", skipped.as_str()));
    let start = BytesStart::new("testsuite").with_attributes([("name", suite.as_str()), skipped]);
    writer.write_event(Xml::Start(start.with_attributes(of_all)))?;
    if !properties.is_empty() {
        writer.write_event(Xml::Start(BytesStart::new("properties")))?;
        for (name, value) in properties {
            let property = BytesStart::new("property").with_attributes([("name", *name), ("value", &*legal(value))]);
            writer.write_event(Xml::Empty(property))?;
        }
        writer.write_event(Xml::End(BytesEnd::new("properties")))?;
    }
    for case in cases {
        write_case(&mut writer, &suite, case)?;
    }
    writer.write_event(Xml::End(BytesEnd::new("testsuite")))?;
    writer.write_event(Xml::End(BytesEnd::new("testsuites")))?;
    let mut text = String::from_utf8(writer.into_inner())?;
    text.push('\n');
    Ok(text)
}

fn write_case(writer: &mut Writer<Vec<u8>>, suite: &str, case: &Case) -> Result<()> {
    let start = BytesStart::new("testcase").with_attributes([("classname", suite), ("name", &*legal(&case.name))]);
    if case.failed.is_none() && case.output.is_empty() {
        return Ok(writer.write_event(Xml::Empty(start))?);
    }
    writer.write_event(Xml::Start(start))?;
    if let Some((element, kind, message, text)) = &case.failed {
        let mut start = BytesStart::new(*element).with_attributes([("message", &*legal(message))]);
        if !kind.is_empty() {
            start.push_attribute(("type", kind.as_str()));
        }
        write_text(writer, start, text)?;
    }
    if !case.output.is_empty() {
        write_text(writer, BytesStart::new("system-out"), &case.output)?;
    }
    Ok(writer.write_event(Xml::End(BytesEnd::new("testcase")))?)
}

fn write_text(writer: &mut Writer<Vec<u8>>, start: BytesStart<'_>, text: &str) -> Result<()> {
    if text.is_empty() {
        return Ok(writer.write_event(Xml::Empty(start))?);
    }
    let end = start.to_end().into_owned();
    writer.write_event(Xml::Start(start))?;
    writer.write_event(Xml::Text(BytesText::new(&legal(text))))?;
    Ok(writer.write_event(Xml::End(end))?)
}

/// The text without characters that XML cannot hold in any form.
fn legal(text: &str) -> String {
    let is_legal = |c: char| matches!(c, '\t' | '\n' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..);
    text.chars().map(|c| if is_legal(c) { c } else { '\u{fffd}' }).collect()
}

#[cfg(test)]
mod tests {
    use super::legal;

    #[test]
    fn control_characters_are_replaced() {
        assert_eq!(legal("a\tb\nc\u{1b}[1m\0\u{ffff}é"), "a\tb\nc\u{fffd}[1m\u{fffd}\u{fffd}é");
    }
}
