//! The report as one page that opens from disk without a network: `page.html` with its style, its scripts and the run's tables. The page
//! computes nothing that the analysis could have computed, and every mark names the CSV row behind it.
//!
//! The scripts are plain scripts in one scope, in the order in which they must be loaded: the data, elements and numbers, scales, looks,
//! the details behind a mark, the two kinds of charts, filters, tables, then one file per part of the page.

mod data;

use super::Contents;
use crate::analysis::AnalysisError;
use crate::record::write_text;
use data::PageData;
use std::path::{Path, PathBuf};

/// The page's file in a run's folder.
pub const PAGE_FILE: &str = "report.html";

const PAGE: &str = include_str!("page.html");
/// The section on the claims.
const VERDICTS: &str = include_str!("verdicts.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 16] = [
    include_str!("data.js"),
    include_str!("dom.js"),
    include_str!("scale.js"),
    include_str!("looks.js"),
    include_str!("behind.js"),
    include_str!("dots.js"),
    include_str!("curves.js"),
    include_str!("filters.js"),
    include_str!("table.js"),
    include_str!("verdicts.js"),
    include_str!("sentences.js"),
    include_str!("programs.js"),
    include_str!("charts.js"),
    include_str!("misses.js"),
    include_str!("more.js"),
    include_str!("start.js"),
];

/// A part of the page from another module: HTML with everything it needs, such as a view of a scene's machine.
#[derive(Clone, Debug)]
pub struct Inset {
    /// Its heading, text.
    pub title: String,
    /// The part, HTML.
    pub html: String,
}

/// Writes `report.html` of the run in `folder`, with `insets` in a section about the machines, and returns its path.
///
/// # Errors
/// When the run has not been analysed, a record is malformed, or the file cannot be written.
pub fn write_page(folder: &Path, insets: &[Inset]) -> Result<PathBuf, AnalysisError> {
    let path = folder.join(PAGE_FILE);
    let contents = Contents::read(folder)?;
    let data = PageData::read(folder, &contents)?;
    let json = serde_json::to_string(&data)
        .map_err(|source| crate::record::RecordError::Json { path: path.clone(), source })?;
    write_text(&path, &render(&contents, &json, insets))?;
    Ok(path)
}

fn render(contents: &Contents, json: &str, insets: &[Inset]) -> String {
    let profile = &contents.manifest.request.profile;
    let has_claims = !contents.claims.is_empty();
    let scripts = SCRIPTS.map(|script| script.replacen("// @ts-check\n", "", 1)).concat();
    // In a script element only `<` can end or confuse the data.
    let json = json.replace('<', "\\u003c");
    let limits = super::markdown::limitations_of(&contents.claims);
    let limits: String = limits.map(|limit| format!("<li>{}</li>\n", escaped(limit))).collect();
    let (link, machines) = if insets.is_empty() {
        (String::new(), String::new())
    } else {
        let inset =
            |inset: &Inset| format!("<div class=\"card\"><h3>{}</h3>\n{}</div>\n", escaped(&inset.title), inset.html);
        let insets: String = insets.iter().map(inset).collect();
        (
            "<a href=\"#machines\">Machines</a>".to_owned(),
            format!("<section id=\"machines\"><h2>The machines</h2>\n{insets}</section>\n"),
        )
    };
    filled(PAGE, |name| match name {
        "title" if has_claims => escaped(&format!("Bounding volumes on trial: {profile} run")),
        "title" => escaped(&format!("Bounding volumes on trial: {}", contents.claims.source)),
        "heading" if has_claims => "Bounding volumes on trial".to_owned(),
        "heading" => escaped(&contents.claims.source),
        "lead" => escaped(&super::lead(&contents.claims, &contents.manifest).replace('`', "")),
        "verdicts-link" if has_claims => "<a href=\"#verdicts\">Sentences</a>".to_owned(),
        "verdicts" if has_claims => VERDICTS.to_owned(),
        "profile" => escaped(profile),
        "style" => STYLE.to_owned(),
        "limits" => format!("<ul>\n{limits}</ul>"),
        "machines-link" => link.clone(),
        "machines" => machines.clone(),
        "data" => json.clone(),
        "scripts" => scripts.clone(),
        _ => String::new(),
    })
}

/// The template with every `{{name}}` replaced; inserted text is not expanded again.
fn filled(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut pieces = template.split("{{");
    let first = pieces.next().unwrap_or_default().to_owned();
    pieces.fold(first, |text, piece| match piece.split_once("}}") {
        Some((name, rest)) => text + &value(name) + rest,
        None => text + "{{" + piece,
    })
}

/// Text for HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests;
