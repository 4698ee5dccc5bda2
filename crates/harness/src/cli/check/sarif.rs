//! Findings as SARIF 2.1.0 (OASIS 2020): what code hosts and editors show at the line of the program.

use super::findings::{Finding, RULES, findings};
use super::{Checked, not_examined_of_scene};
use crate::scene::Scene;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Component, Path};

const SCHEMA: &str = "https://json.schemastore.org/sarif-2.1.0.json";

/// A log of one run.
pub fn report(checked: &Checked<'_>) -> Value {
    let Checked { scene, run, outcome, .. } = checked;
    let uri = uri(&run.file);
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let results: Vec<Value> = findings(checked).iter().map(|finding| result(scene, &uri, finding, &mut seen)).collect();
    let of_program = run.program.notes.iter().map(|note| {
        let level = if note.is_unknown { "warning" } else { "note" };
        let mut notice = notice(level, &note.to_string());
        notice["locations"] = json!([location(&uri, &json!({ "startLine": note.line.max(1) }))]);
        notice
    });
    let of_scene = not_examined_of_scene(scene, outcome);
    let notices: Vec<Value> = of_scene.iter().map(|text| notice("warning", text)).chain(of_program).collect();
    let program = run.file.file_name().unwrap_or(OsStr::new("")).to_string_lossy();
    let dialect = run.setup.dialect.name();
    let mut run = log(&results, &json!({ "executionSuccessful": true, "toolExecutionNotifications": notices }));
    // Two programs of one pipeline are two analyses, of which none replaces the other.
    run["automationDetails"] = json!({ "id": format!("bvbench/{}/{program}/", scene.name) });
    run["properties"] = json!({ "dialect": dialect });
    run["artifacts"] = json!([{ "location": { "uri": uri } }]);
    whole(&run)
}

/// A log of a run that came to no answer.
pub fn failure(error: &str) -> Value {
    let invocation = json!({ "executionSuccessful": false, "toolExecutionNotifications": [notice("error", error)] });
    whole(&log(&[], &invocation))
}

fn whole(run: &Value) -> Value {
    json!({ "$schema": SCHEMA, "version": "2.1.0", "runs": [run] })
}

fn log(results: &[Value], invocation: &Value) -> Value {
    let rules = RULES.iter().map(|rule| {
        json!({
            "id": rule.id, "name": rule.name, "shortDescription": { "text": rule.what }, "fullDescription": { "text": rule.what },
            "help": { "text": rule.help }, "defaultConfiguration": { "level": if rule.is_note { "note" } else { "error" } },
        })
    });
    let driver = json!({
        "name": "bvbench", "version": env!("CARGO_PKG_VERSION"), "semanticVersion": env!("CARGO_PKG_VERSION"),
        "rules": rules.collect::<Vec<_>>(),
    });
    json!({ "tool": { "driver": driver }, "invocations": [invocation], "results": results })
}

fn location(uri: &str, region: &Value) -> Value {
    json!({ "physicalLocation": { "artifactLocation": { "uri": uri, "index": 0 }, "region": region } })
}

fn notice(level: &str, text: &str) -> Value {
    json!({ "level": level, "message": { "text": text } })
}

fn result(scene: &Scene, uri: &str, finding: &Finding<'_>, seen: &mut BTreeMap<String, usize>) -> Value {
    let Finding { rule, line, block, message, pair, time_s, at, .. } = finding;
    let parts: Vec<&str> =
        pair.iter().flat_map(|pair| [pair.a, pair.b]).map(|part| scene.parts[part].name.as_str()).collect();
    let mut region = json!({ "startLine": line });
    if !block.is_empty() {
        region["snippet"] = json!({ "text": block });
    }
    // The same finding where lines were put in before it.
    let same = format!("{} {} {block}", rule.id, parts.join(":"));
    let times = seen.entry(same.clone()).or_insert(0);
    *times += 1;
    let fingerprint = blake3::hash(format!("{same} {times}").as_bytes()).to_hex().to_string();
    json!({
        "ruleId": rule.id, "ruleIndex": RULES.iter().position(|known| known.id == rule.id),
        "level": if rule.is_note { "note" } else { "error" },
        "message": { "text": message },
        "locations": [location(uri, &region)],
        "partialFingerprints": { "kindPartsBlock/v1": fingerprint },
        "properties": {
            "parts": parts, "time_s": time_s, "least_mm": at.map(|(least_mm, _)| least_mm),
            "position": at.map(|(_, extent)| super::extent_json(extent)["position"].take()),
        },
    })
}

/// The file as a URI: relative to the current folder where it is in it, as code hosts want it, else absolute.
fn uri(file: &Path) -> String {
    let full = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let here = std::env::current_dir().and_then(|here| here.canonicalize()).unwrap_or_default();
    let path = full.strip_prefix(&here).unwrap_or(&full);
    let mut uri = String::new();
    for component in path.components() {
        match component {
            // A verbatim prefix (`\\?\C:`) without what makes it verbatim.
            Component::Prefix(prefix) => {
                let drive = prefix.as_os_str().to_string_lossy();
                uri = format!("file:///{}", drive.trim_start_matches(r"\\?\"));
            }
            Component::RootDir if uri.is_empty() => "file://".clone_into(&mut uri),
            Component::RootDir | Component::CurDir => {}
            Component::ParentDir => add(&mut uri, OsStr::new("..")),
            Component::Normal(name) => add(&mut uri, name),
        }
    }
    uri
}

/// Adds a part of a path, percent-encoded.
fn add(uri: &mut String, name: &OsStr) {
    if !uri.is_empty() {
        uri.push('/');
    }
    for &byte in name.as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            *uri += &format!("%{byte:02X}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::uri;
    use std::path::Path;

    #[test]
    fn files_of_the_current_folder_are_relative_and_characters_are_encoded() {
        assert_eq!(uri(Path::new("Cargo.toml")), "Cargo.toml");
        assert_eq!(uri(&Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/check.md")), "docs/check.md");
        assert_eq!(uri(Path::new("no such/50%:ü.ngc")), "no%20such/50%25%3A%C3%BC.ngc");
        let elsewhere = tempfile::tempdir().unwrap();
        std::fs::write(elsewhere.path().join("a b.ngc"), "").unwrap();
        let found = uri(&elsewhere.path().join("a b.ngc"));
        assert!(found.starts_with("file:///") && found.ends_with("/a%20b.ngc"), "{found}");
    }
}
