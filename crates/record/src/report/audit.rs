//! The report of an audit, `audit.md`: which factor matters, which cells are best, and what the boxes leave out.

use crate::analysis::audit::{RESPONSES, SAFE};
use crate::analysis::{ALL, AnalysisError, distinct};
use crate::plot::read_gallery;
use crate::record::{AuditCellRow, AuditShareRow, Manifest, read_rows, write_text};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The report's file in an audit's folder.
pub const AUDIT_FILE: &str = "audit.md";

/// Number of cells in the table of the best.
const BEST: usize = 12;

/// Writes `audit.md` of the audit in `folder` and returns its path.
///
/// # Errors
/// When the audit has not been analysed, a record is malformed, or the file cannot be written.
pub fn write_audit(folder: &Path) -> Result<PathBuf, AnalysisError> {
    let manifest = Manifest::read(folder)?;
    let (cells, shares): (Vec<AuditCellRow>, Vec<AuditShareRow>) = (read_rows(folder)?, read_rows(folder)?);
    let mut text = heading(&manifest, &cells);
    for figure in &read_gallery(folder)?.figures {
        let _ = write!(text, "![{}]({})\n\n{}\n\n", figure.title, figure.svg.display(), figure.caption);
    }
    text += &share_table(&shares);
    text += &best_cells(&cells);
    text += &containment(&cells);
    let path = folder.join(AUDIT_FILE);
    write_text(&path, &text)?;
    Ok(path)
}

/// The scene whose rows are reported: all scenes together, or the only scene.
fn whole(scenes: impl Iterator<Item = String>) -> String {
    let scenes: Vec<String> = scenes.collect();
    if scenes.iter().any(|scene| scene == ALL) { ALL.to_owned() } else { scenes.into_iter().next().unwrap_or_default() }
}

fn heading(manifest: &Manifest, cells: &[AuditCellRow]) -> String {
    let scenes: Vec<&str> = manifest.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let count = manifest.request.policies.len();
    let timed = cells.iter().any(|cell| cell.time_ratio.is_some());
    let times = if timed {
        format!(
            "Times were taken on {} ({}). Every ratio of times is against one reference cell, measured in the same minute.",
            manifest.machine.cpu, manifest.machine.os
        )
    } else {
        "Nothing was timed.".to_owned()
    };
    format!(
        "# Audit: what makes a box good\n\n{count} cells (orientation × centre × split × leaf) on {}, profile `{}`, seed {}. Counts are \
         the same on every machine. {times}\n\n",
        scenes.join(", "),
        manifest.request.profile,
        manifest.request.seed
    )
}

fn share_table(shares: &[AuditShareRow]) -> String {
    let mut text = "## Shares of the variance between cells\n\nPercent of the sum of squares of the log response over the cells whose boxes \
                    contain everything, with 95 % intervals.\n\n"
        .to_owned();
    let scene = whole(shares.iter().map(|row| row.scene.clone()));
    let rows: Vec<&AuditShareRow> = shares.iter().filter(|row| row.cells == SAFE && row.scene == scene).collect();
    let responses: Vec<&str> = RESPONSES.into_iter().filter(|r| rows.iter().any(|row| row.response == *r)).collect();
    let _ = writeln!(text, "| term | {} |\n|---|{}", responses.join(" | "), "---:|".repeat(responses.len()));
    let terms: Vec<&str> =
        rows.iter().filter(|row| Some(&row.response.as_str()) == responses.first()).map(|row| &*row.term).collect();
    for term in terms {
        let _ = write!(text, "| {} |", term.replace(':', " × "));
        for response in &responses {
            let cell = rows.iter().find(|row| row.term == term && row.response == *response);
            let words = cell.map_or_else(String::new, |row| {
                let [share, low, high] = [row.share, row.low, row.high].map(|share| 100.0 * share);
                if low.is_finite() { format!("{share:.1} [{low:.1}, {high:.1}]") } else { format!("{share:.1}") }
            });
            let _ = write!(text, " {words} |");
        }
        text.push('\n');
    }
    text + "\n"
}

fn best_cells(cells: &[AuditCellRow]) -> String {
    let scene = whole(cells.iter().map(|row| row.scene.clone()));
    let mut rows: Vec<&AuditCellRow> = cells.iter().filter(|row| row.scene == scene && row.safe == 1).collect();
    let timed = rows.iter().all(|row| row.time_ratio.is_some());
    let key = |row: &AuditCellRow| if timed { row.time_ratio.unwrap_or(f64::INFINITY) } else { row.volume_tests };
    rows.sort_by(|a, b| key(a).total_cmp(&key(b)));
    let by = if timed { "query time" } else { "volume tests" };
    let mut text = format!(
        "## The {BEST} best safe cells by {by}, and the worst\n\n| orientation | centre | split | leaf | volume tests | triangle tests | \
         time | build | box area |\n|---|---|---|---:|---:|---:|---:|---:|---:|\n"
    );
    let ratio = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
    for row in rows.iter().take(BEST).chain(rows.iter().skip(BEST).next_back()) {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.1} | {:.2} | {} | {} | {:.2} |",
            row.orientation,
            row.centre,
            row.split,
            row.leaf,
            row.volume_tests,
            row.triangle_tests,
            ratio(row.time_ratio),
            ratio(row.build_ratio),
            row.box_area_ratio
        );
    }
    text + "\nTests are geometric means of a query, time and build are ratios to the reference cell, box area is that of all boxes over that \
            of the part.\n\n"
}

fn containment(cells: &[AuditCellRow]) -> String {
    let scene = whole(cells.iter().map(|row| row.scene.clone()));
    let mut text = "## What the centre leaves out\n\n| orientation | centre | corners outside, % | farthest, mm | contacts missed |\n\
                    |---|---|---:|---:|---:|\n"
        .to_owned();
    let of_scene = || cells.iter().filter(|row| row.scene == scene);
    fn key(row: &AuditCellRow) -> (&str, &str) {
        (&row.orientation, &row.centre)
    }
    for (orientation, centre) in distinct(of_scene().map(key)) {
        let members: Vec<&AuditCellRow> = of_scene().filter(|row| key(row) == (orientation, centre)).collect();
        let outside = members.iter().map(|m| m.outside_corners_pct).sum::<f64>() / members.len() as f64;
        let farthest = members.iter().map(|m| m.overhang_mm).fold(0.0, f64::max);
        let (missed, touching) =
            members.iter().fold((0, 0), |(missed, touching), m| (missed + m.missed, touching + m.touching));
        let _ = writeln!(text, "| {orientation} | {centre} | {outside:.2} | {farthest:.2} | {missed} of {touching} |");
    }
    text + "\nCorners count once for each node that holds them; contacts count once for each split rule and leaf size.\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_audit_by_counts_alone_speaks_of_no_ratio_of_times() {
        let text = heading(&Manifest::default(), &[]);
        assert!(text.ends_with("the same on every machine. Nothing was timed.\n\n"), "{text}");
    }

    #[test]
    fn a_share_without_interval_stands_alone() {
        let row = |term: &str, low: f64, high: f64| {
            let (scene, cells, response) = ("mill".to_owned(), SAFE.to_owned(), RESPONSES[0].to_owned());
            AuditShareRow { scene, cells, response, term: term.to_owned(), share: 0.125, low, high }
        };
        let text = share_table(&[row("split", 0.1, 0.2), row("leaf", f64::NAN, f64::NAN)]);
        assert!(text.contains("| split | 12.5 [10.0, 20.0] |\n| leaf | 12.5 |\n"), "{text}");
    }
}
