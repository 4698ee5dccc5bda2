//! What `check` writes for other programs: SARIF by the rules of its specification (OASIS 2.1.0), JUnit XML read back.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

#[path = "support/mill.rs"]
mod mill;
mod support;

use mill::{MILL, folder_of};
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::Event;
use quick_xml::{Reader, XmlVersion};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use support::Folder;

/// The mill, whose clamp has a name to be escaped, with a finger that may be touched.
fn mill() -> String {
    let finger = r#"  { name = "finger", link = "table", at = { xyz_mm = [-70, 0, 0] }, shape = { kind = "rounded-box", size_mm = [4, 4, 4], fillet_mm = 1 } },"#;
    let cutter = "  { name = \"cutter\"";
    let text = MILL.replacen("\"clamp\"", "\"clamp <A & B>\"", 1).replacen(cutter, &format!("{finger}\n{cutter}"), 1);
    text + "allow = [[\"cutter\", \"finger\"]]\n"
}

/// A rapid into the block, a feed into the clamp, a near miss above the clamp, and a Z beyond its limit.
const CRASHES: &str = "(<crash> & \x1b[31mcontrol\x1b[0m)\nG0 Z5\nG0 Z-2\nG0 Z50\nG1 X70 Z10 F1000 (\x07bell)\nG0 Z21\nG0 X0\nG0 Z260\nM2\n";

fn scene(program: &str) -> Folder {
    folder_of(&mill(), program)
}

/// Runs `check` in the scene's folder, where both reports go; the exit code.
fn check(folder: &Folder, arguments: &[&str]) -> i32 {
    folder.run(&[&["check", "--quiet", "."], arguments].concat()).status.code().unwrap()
}

/// The log of a check, which obeys the rules.
fn read_sarif(folder: &Folder, name: &str) -> Value {
    let log = serde_json::from_slice(&fs::read(folder.path(name)).unwrap()).unwrap();
    obeys_the_rules(&log);
    log
}

fn sarif_of(program: &str, code: i32, arguments: &[&str]) -> Value {
    let folder = scene(program);
    assert_eq!(check(&folder, &[arguments, &["--sarif", "out.sarif"]].concat()), code);
    read_sarif(&folder, "out.sarif")
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is no string"))
}

/// The rules for a place of the program.
fn lies_in_an_artifact(run: &Value, location: &Value) {
    let place = &location["physicalLocation"]; // 3.28.3
    let uri = text(&place["artifactLocation"]["uri"]); // 3.4.3: RFC 3986
    assert!(uri.chars().all(|c| c.is_ascii_alphanumeric() || "-._~/%:".contains(c)), "{uri}");
    let artifact = usize::try_from(place["artifactLocation"]["index"].as_u64().unwrap()).unwrap();
    assert_eq!(text(&run["artifacts"][artifact]["location"]["uri"]), uri); // 3.4.5
    assert!(place["region"]["startLine"].as_u64().unwrap() >= 1); // 3.30.5
}

/// The rules of the specification that apply to these logs, by section.
fn obeys_the_rules(log: &Value) {
    assert_eq!(text(&log["version"]), "2.1.0"); // 3.13.2
    assert!(text(&log["$schema"]).ends_with("sarif-2.1.0.json")); // 3.13.3
    let runs = log["runs"].as_array().unwrap(); // 3.13.4
    assert_eq!(runs.len(), 1);
    let run = &runs[0];
    let driver = &run["tool"]["driver"]; // 3.14.6, 3.18.2
    assert_eq!(text(&driver["name"]), "bvbench"); // 3.19.8
    assert_eq!(text(&driver["semanticVersion"]), env!("CARGO_PKG_VERSION")); // 3.19.12
    let rules = driver["rules"].as_array().unwrap(); // 3.19.23
    let mut ids: Vec<&str> = rules.iter().map(|rule| text(&rule["id"])).collect(); // 3.49.3
    for rule in rules {
        let name = text(&rule["name"]); // 3.49.7: an identifier
        assert!(name.starts_with(char::is_uppercase) && name.chars().all(char::is_alphanumeric), "{name}");
        for key in ["shortDescription", "fullDescription", "help"] {
            assert!(text(&rule[key]["text"]).ends_with(['.', ';']), "{rule}"); // 3.49.9 to 3.49.13
        }
        assert!(["note", "error"].contains(&text(&rule["defaultConfiguration"]["level"]))); // 3.50.3
    }
    for invocation in run["invocations"].as_array().unwrap() {
        assert!(invocation["executionSuccessful"].is_boolean()); // 3.20.14
        for notice in invocation["toolExecutionNotifications"].as_array().unwrap() {
            assert!(!text(&notice["message"]["text"]).is_empty()); // 3.58.5
            assert!(["note", "warning", "error"].contains(&text(&notice["level"]))); // 3.58.6
            for location in notice["locations"].as_array().into_iter().flatten() {
                lies_in_an_artifact(run, location); // 3.58.4
            }
        }
    }
    let mut prints = Vec::new();
    for result in run["results"].as_array().unwrap() {
        let index = usize::try_from(result["ruleIndex"].as_u64().unwrap()).unwrap();
        assert_eq!(ids[index], text(&result["ruleId"])); // 3.27.5, 3.27.6
        assert_eq!(result["level"], rules[index]["defaultConfiguration"]["level"]); // 3.27.10
        assert!(!text(&result["message"]["text"]).is_empty()); // 3.27.11
        lies_in_an_artifact(run, &result["locations"][0]); // 3.27.12
        prints.push(text(&result["partialFingerprints"]["kindPartsBlock/v1"]).to_owned()); // 3.27.17
    }
    ids.sort_unstable();
    ids.dedup();
    prints.sort_unstable();
    prints.dedup();
    assert_eq!((ids.len(), prints.len()), (rules.len(), run["results"].as_array().unwrap().len()));
}

#[test]
fn sarif_has_a_result_at_the_line_of_each_finding() {
    let log = sarif_of(CRASHES, 1, &[]);
    let run = &log["runs"][0];
    let found: Vec<(&str, &str, u64)> = run["results"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| {
            let region = &r["locations"][0]["physicalLocation"]["region"];
            (text(&r["ruleId"]), text(&r["level"]), region["startLine"].as_u64().unwrap())
        })
        .collect();
    let wanted = [("rapid-into-workpiece", "error", 3), ("collision", "error", 5), ("over-travel", "error", 8)];
    assert_eq!(found, wanted);
    let collision = &run["results"][1];
    let message = text(&collision["message"]["text"]);
    for part in ["clamp <A & B>:cutter", "collision", "0:", "X5", "Z"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert_eq!(collision["properties"]["parts"], serde_json::json!(["clamp <A & B>", "cutter"]));
    assert!(collision["properties"]["position"]["X"].as_f64().unwrap() > 50.0);
    let place = &collision["locations"][0]["physicalLocation"];
    assert_eq!(text(&place["artifactLocation"]["uri"]), "own.ngc");
    assert!(text(&place["region"]["snippet"]["text"]).starts_with("G1 X70"));
    assert!(text(&run["results"][2]["message"]["text"]).contains("axis Z at 260 mm"));
    assert_eq!(run["invocations"][0]["executionSuccessful"], true);
    let notices = run["invocations"][0]["toolExecutionNotifications"].as_array().unwrap();
    assert!(notices.iter().any(|notice| text(&notice["message"]["text"]).contains("finger:cutter")), "{notices:?}");
}

#[test]
fn near_misses_are_notes_and_what_is_there_at_first_is_at_line_1() {
    let near = sarif_of("G0 Z21\nG0 X70\nG0 X0\nM2", 0, &[]);
    let results = near["runs"][0]["results"].as_array().unwrap();
    assert_eq!(results.len(), 1, "{results:?}");
    let line = &results[0]["locations"][0]["physicalLocation"]["region"]["startLine"];
    assert_eq!((text(&results[0]["level"]), line.as_u64()), ("note", Some(2)));
    assert!(text(&results[0]["message"]["text"]).contains("nearest 1.000 mm"), "{}", results[0]);
    assert!(
        sarif_of("G0 Z21\nG0 X70\nG0 X0\nM2", 0, &["--clearance", "0"])["runs"][0]["results"] == serde_json::json!([])
    );
    let lowered = ["--offset", "G54=0,0,0"];
    let folder = scene("G0 Z60\nM2");
    folder.write("scene.toml", &mill().replace("z_mm = 50", "z_mm = -5"));
    assert_eq!(check(&folder, &[&lowered[..], &["--sarif", "out.sarif"]].concat()), 1);
    let log = read_sarif(&folder, "out.sarif");
    let result = &log["runs"][0]["results"][0];
    assert_eq!(result["locations"][0]["physicalLocation"]["region"]["startLine"], 1);
    assert!(text(&result["message"]["text"]).contains("before the first move"), "{result}");
}

#[test]
fn a_check_without_an_answer_replaces_the_reports_of_an_earlier_one() {
    let folder = scene("G0 Z21\nM2");
    let reports = ["--sarif", "out.sarif", "--junit", "out.xml"];
    assert_eq!(check(&folder, &reports), 0);
    folder.write("own.ngc", "G0 Z21\nG77\nM2");
    assert_eq!(check(&folder, &reports), 2);
    let log = read_sarif(&folder, "out.sarif");
    let invocation = &log["runs"][0]["invocations"][0];
    assert_eq!(invocation["executionSuccessful"], false);
    assert!(text(&invocation["toolExecutionNotifications"][0]["message"]["text"]).contains("own.ngc:2:1"));
    let suite = read_junit(&folder.path("out.xml"));
    assert_eq!((&*suite.counts["tests"], &*suite.counts["errors"]), ("1", "1"));
    assert!(suite.cases[0].texts["error"].contains("own.ngc:2:1"), "{:?}", suite.cases[0]);
}

#[test]
fn reports_replace_neither_the_program_nor_the_scene() {
    let folder = scene("G0 Z21\nM2");
    for bad in ["own.ngc", "scene.toml", "."] {
        assert_eq!(check(&folder, &["own.ngc", "--sarif", bad]), 2, "{bad}");
        assert_eq!(check(&folder, &["own.ngc", "--junit", bad]), 2, "{bad}");
    }
    assert_eq!(check(&folder, &["own.ngc", "--sarif", "x", "--junit", "x"]), 2);
    assert_eq!(fs::read_to_string(folder.path("own.ngc")).unwrap(), "G0 Z21\nM2");
}

#[derive(Debug, Default)]
struct Case {
    name: String,
    class: String,
    /// Text and message of each element of the case.
    texts: BTreeMap<String, String>,
    /// Types of failures.
    kinds: Vec<String>,
}

#[derive(Debug, Default)]
struct Suite {
    counts: BTreeMap<String, String>,
    cases: Vec<Case>,
}

/// Adds to the text of the element that is open, where a case has it.
fn add(suite: &mut Suite, open: &[String], content: &str) {
    let case = suite.cases.last_mut().filter(|_| open.iter().any(|name| name == "testcase"));
    if let Some(text) = case.and_then(|case| case.texts.get_mut(open.last().unwrap())) {
        *text += content;
    }
}

/// Reads a report with an XML parser, and holds the counts of suite and suites against the cases.
fn read_junit(file: &Path) -> Suite {
    let text = fs::read_to_string(file).unwrap();
    let mut reader = Reader::from_str(&text);
    let (mut suite, mut open): (Suite, Vec<String>) = Default::default();
    loop {
        let event = reader.read_event().unwrap();
        let empty = matches!(event, Event::Empty(_));
        match event {
            Event::Start(start) | Event::Empty(start) => {
                let name = String::from_utf8(start.name().as_ref().as_bytes().to_vec()).unwrap();
                let attributes: BTreeMap<String, String> = start
                    .attributes()
                    .map(|attribute| attribute.unwrap())
                    .map(|a| {
                        (
                            String::from_utf8(a.key.as_ref().as_bytes().to_vec()).unwrap(),
                            a.normalized_value(XmlVersion::Implicit1_0).unwrap().into_owned(),
                        )
                    })
                    .collect();
                let parent = open.last().map(String::as_str);
                match (parent, name.as_str()) {
                    (None, "testsuites") => suite.counts = attributes,
                    (Some("testsuites"), "testsuite") => {
                        for (key, value) in &suite.counts {
                            assert!(key == "name" || attributes[key] == *value, "{key}");
                        }
                        suite.counts.insert("skipped".to_owned(), attributes["skipped"].clone());
                    }
                    (Some("testsuite"), "properties") | (Some("properties"), "property") => {}
                    (Some("testsuite"), "testcase") => suite.cases.push(Case {
                        name: attributes["name"].clone(),
                        class: attributes["classname"].clone(),
                        ..Case::default()
                    }),
                    (Some("testcase"), "failure" | "error" | "skipped" | "system-out") => {
                        let case = suite.cases.last_mut().unwrap();
                        case.kinds.extend(attributes.get("type").cloned());
                        case.texts.insert(name.clone(), attributes.get("message").cloned().unwrap_or_default());
                    }
                    other => panic!("{other:?}"),
                }
                if !empty {
                    open.push(name);
                }
            }
            Event::Text(content) => add(&mut suite, &open, &content.xml_content(XmlVersion::Implicit1_0)),
            Event::GeneralRef(name) => {
                let name = name.into_inner();
                add(&mut suite, &open, resolve_predefined_entity(&name).unwrap());
            }
            Event::End(_) => drop(open.pop()),
            Event::Eof => break,
            _ => {}
        }
    }
    assert!(open.is_empty());
    let with = |element: &str| suite.cases.iter().filter(|case| case.texts.contains_key(element)).count().to_string();
    assert_eq!(suite.counts["tests"], suite.cases.len().to_string());
    for (count, element) in [("failures", "failure"), ("errors", "error"), ("skipped", "skipped")] {
        assert_eq!(suite.counts[count], with(element), "{count}");
    }
    suite
}

#[test]
fn junit_has_a_case_for_each_pair_and_one_for_the_limits() {
    let folder = scene(CRASHES);
    assert_eq!(check(&folder, &["--junit", "reports/out.xml"]), 1);
    let suite = read_junit(&folder.path("reports/out.xml"));
    let failed: Vec<(&str, &str)> = suite
        .cases
        .iter()
        .filter(|case| case.texts.contains_key("failure"))
        .map(|case| (case.name.as_str(), case.kinds[0].as_str()))
        .collect();
    let wanted = [
        ("own.ngc: block:cutter", "rapid-into-workpiece"),
        ("own.ngc: clamp <A & B>:cutter", "collision"),
        ("own.ngc: limits of the axes", "over-travel"),
    ];
    assert_eq!(failed, wanted);
    let clamp = &suite.cases.iter().find(|case| case.name.contains("clamp")).unwrap().texts["failure"];
    assert!(clamp.starts_with("line 5: ") && clamp.contains("own.ngc:5: "), "{clamp}");
    assert!(suite.cases.iter().any(|case| case.texts.contains_key("skipped") && case.name.contains("finger:cutter")));
    let class = &suite.cases[0].class;
    assert!(!class.is_empty() && suite.cases.iter().all(|case| case.class == *class));
    // A clear program fails no case, and tells what came near.
    folder.write("own.ngc", "G0 Z21\nG0 X70\nG0 X0\nM2");
    assert_eq!(check(&folder, &["--junit", "reports/out.xml"]), 0);
    let clear = read_junit(&folder.path("reports/out.xml"));
    assert_eq!(clear.counts["failures"], "0");
    let near = clear.cases.iter().find(|case| case.name.contains("clamp")).unwrap();
    assert!(near.texts["system-out"].contains("own.ngc:2: "), "{near:?}");
    let names = |suite: &Suite| suite.cases.iter().map(|case| case.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&suite), names(&clear), "a pipeline compares cases by name");
}

/// A box between two corners, mm, as text STL.
fn box_stl(low: [f64; 3], high: [f64; 3]) -> String {
    let corner = |k: usize| [0, 1, 2].map(|i| if (k >> i) & 1 == 1 { high[i] } else { low[i] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facet = |corners: [usize; 3]| {
        let vertices = corners.map(corner).map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    let facets: String = sides.iter().map(|&[a, b, c, d]| facet([a, b, c]) + &facet([a, c, d])).collect();
    format!("solid box\n{facets}endsolid box\n")
}

#[test]
fn whatever_fails_a_check_is_in_every_report() {
    let cut = "M3 S1000 G0 Z5\nG1 Z-3 F500\nG0 Z5\nM2";
    for ([from, to], program, arguments, rule, line, case) in [
        ([""; 2], cut, &["--target", "box.stl", "--stock-resolution", "1"][..], "target-gouge", 1, "the wanted part"),
        // Under the cut, and 10 mm beyond the block at two sides.
        ([""; 2], cut, &["--target", "wide.stl", "--stock-resolution", "1"], "target-gouge", 1, "the wanted part"),
        // 1.1 mm under the cut: perhaps deeper than the resolution.
        ([""; 2], cut, &["--target", "inner.stl", "--stock-resolution", "1"], "target-gouge", 1, "the wanted part"),
        // A thin wall across the cut.
        ([""; 2], cut, &["--target", "wall.stl", "--stock-resolution", "1"], "target-gouge", 1, "the wanted part"),
        // A retreat out of the whole workpiece is not proved.
        (
            [""; 2],
            cut,
            &["--stock-resolution", "none", "--certify", "part.cert"],
            "not-proved",
            3,
            "proof of each block",
        ),
        // What is finished is not cut, so that nothing decides on a rapid within the tolerance of it.
        (
            ["[check]\n", "[check]\ngouge_mm = 0.05\n"],
            "M3 S1000 G0 Z5\nG0 Z-0.005\nM2",
            &["--certify", "part.cert"],
            "not-proved",
            2,
            "proof of each block",
        ),
        (
            ["role = \"cutter\"", "role = \"cutter\", tool = 1"],
            "G0 Z40\nT8 M6\nG0 Z30\nG1 X5 F500\nM2",
            &[],
            "tool-without-part",
            4,
            "tools in use",
        ),
    ] {
        let changed = mill().replacen(from, to, 1).replacen("[program]\n", "[program]\ntool = 1\n", 1);
        let folder = folder_of(&changed, program);
        for (name, low, high) in [
            ("box.stl", [-50.0, -50.0, -10.0], [50.0, 50.0, 10.0]),
            ("wide.stl", [-60.0, -50.0, -10.0], [60.0, 50.0, 6.0]),
            ("inner.stl", [-40.0, -40.0, -9.0], [40.0, 40.0, 8.1]),
            ("wall.stl", [-40.0, -0.5, -9.0], [40.0, 0.5, 9.9]),
        ] {
            folder.write(name, &box_stl(low, high));
        }
        let reports = ["check", "--quiet", ".", "--clearance", "0", "--csv", "--sarif", "a.sarif", "--junit", "b.xml"];
        let (code, csv, told) = folder.told(&[&reports[..], arguments].concat());
        assert_eq!(code, Some(1), "{rule}: {told}");
        let log = read_sarif(&folder, "a.sarif");
        let [result] = &log["runs"][0]["results"].as_array().unwrap()[..] else { panic!("{rule}: {log}") };
        let region = &result["locations"][0]["physicalLocation"]["region"];
        let found = (text(&result["ruleId"]), text(&result["level"]), region["startLine"].as_u64());
        assert_eq!(found, (rule, "error", Some(line)), "{result}");
        let suite = read_junit(&folder.path("b.xml"));
        let failed: Vec<_> = suite.cases.iter().filter(|case| case.texts.contains_key("failure")).collect();
        let [only] = &failed[..] else { panic!("{rule}: {suite:?}") };
        assert_eq!((only.name.as_str(), only.kinds[0].as_str()), (&*format!("own.ngc: {case}"), rule));
        assert!(csv.lines().count() == 2 && csv.lines().nth(1).unwrap().starts_with(&format!("{rule},")), "{csv}");
    }
}

#[test]
fn how_a_program_is_read_is_in_every_report() {
    // X 5 without a decimal point twice, a zero that nothing has set, a probe, and a code of the machine's builder.
    let folder = scene("G21 G0 Z40.\nG0 X5\nG154 P12 X0.\nG31 X1. F100.\nX5\nM27\nM30");
    let reports = ["check", "--quiet", ".", "--dialect", "haas", "--json", "--sarif", "a.sarif", "--junit", "b.xml"];
    let (code, shown, told) = folder.told(&reports);
    assert_eq!(code, Some(0), "{shown}{told}");
    let wanted = [
        (2, 1, true, "X has no decimal point"),
        (3, 2, true, "the origin of G154P12 is taken to be zero"),
        (4, 0, true, "nothing stops a probe here"),
        (6, 0, false, "M27 is taken to move no axis"),
    ];
    let json: Value = serde_json::from_str(&shown).unwrap();
    let log = read_sarif(&folder, "a.sarif");
    assert_eq!((text(&json["dialect"]), text(&log["runs"][0]["properties"]["dialect"])), ("haas", "haas"));
    let junit = fs::read_to_string(folder.path("b.xml")).unwrap();
    assert!(junit.contains("<property name=\"dialect\" value=\"haas\"/>"), "{junit}");
    let notices = log["runs"][0]["invocations"][0]["toolExecutionNotifications"].as_array().unwrap();
    let located: Vec<&Value> = notices.iter().filter(|notice| notice["locations"].is_array()).collect();
    let suite = read_junit(&folder.path("b.xml"));
    let case = suite.cases.iter().find(|case| case.name == "own.ngc: how the program is read").unwrap();
    let (notes, lines) = (json["notes"].as_array().unwrap(), case.texts["system-out"].lines().collect::<Vec<_>>());
    assert_eq!((notes.len(), located.len(), lines.len()), (4, 4, 4), "{json} {log} {case:?}");
    for (i, (line, more, is_unknown, told)) in wanted.into_iter().enumerate() {
        let note = &notes[i];
        let found = (note["line"].as_u64(), note["more"].as_u64(), note["not_examined"].as_bool());
        assert_eq!(found, (Some(line), Some(more), Some(is_unknown)), "{note}");
        assert!(text(&note["text"]).starts_with(told), "{note}");
        let (level, region) =
            (text(&located[i]["level"]), &located[i]["locations"][0]["physicalLocation"]["region"]["startLine"]);
        let wanted_level = if is_unknown { "warning" } else { "note" };
        assert_eq!((level, region.as_u64()), (wanted_level, Some(line)), "{}", located[i]);
        assert!(text(&located[i]["message"]["text"]).contains(told), "{}", located[i]);
        assert!(lines[i].starts_with(&format!("line {line}: {told}")), "{lines:?}");
    }
}

#[test]
fn reports_come_beside_what_is_printed() {
    let folder = scene(CRASHES);
    let (code, shown, _) = folder.told(&["check", "--quiet", ".", "--json", "--sarif", "a.sarif", "--junit", "b.xml"]);
    let json: Value = serde_json::from_str(&shown).unwrap();
    assert_eq!((code, &json["collides"]), (Some(1), &Value::Bool(true)));
    assert!(folder.path("a.sarif").is_file() && folder.path("b.xml").is_file());
    let (_, help, _) = folder.told(&["check", "--help"]);
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("part.ngc --sarif part.sarif --junit part.xml"));
    assert!(words.contains("or with --certify a block is not proved, 2 bad usage"), "{words}");
}
