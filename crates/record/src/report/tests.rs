//! Tests of a report from made-up records, in the form that a reader sees.

use super::*;
use crate::analysis::analyze;
use crate::plot::draw_all;
use crate::record::synthetic::{PLANTED, Plan, Run, SCENES};
use tempfile::TempDir;

fn report_of(run: &Run) -> (TempDir, String) {
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    draw_all(folder.path()).unwrap();
    let text = std::fs::read_to_string(write(folder.path()).unwrap()).unwrap();
    (folder, text)
}

#[test]
fn the_report_holds_every_claim_variant_and_figure() {
    let (folder, text) = report_of(&Run::generate(&Plan::default()));
    for claim in &ClaimSet::standard().claims {
        assert!(text.contains(&format!("### {}\n", claim.id())) && text.contains(&claim.sentence), "{}", claim.id());
    }
    assert!(PLANTED.iter().all(|planted| text.contains(planted.label)));
    assert!(SCENES.iter().all(|scene| text.contains(scene)));
    let images = text.lines().filter_map(|line| line.strip_prefix("![")?.split_once("](")?.1.strip_suffix(')'));
    let images: Vec<&str> = images.collect();
    assert_eq!(images.len(), 10);
    assert!(images.iter().all(|image| folder.path().join(image).exists()), "{images:?}");
    assert!(!text.contains("NaN") && !text.contains("Something else used"));
    // All rows of a table have as many cells as its head.
    let mut columns = 0;
    for line in text.lines() {
        let cells = line.replace("\\|", "").matches('|').count();
        if line.starts_with('|') && columns > 0 {
            assert_eq!(cells, columns, "{line}");
        }
        columns = if line.starts_with('|') { cells } else { 0 };
    }
}

#[test]
fn unsafe_volumes_are_not_in_the_ranking_and_noise_is_on_top() {
    let mut run = Run::generate(&Plan::default());
    run.manifest.noise.push("a busy neighbour".to_owned());
    let (_folder, text) = report_of(&run);
    let ranking = text.split("## Ranking by speed").nth(1).unwrap().split("\n## ").next().unwrap();
    assert!(ranking.contains("| 1 | area-weighted OBB |") && !ranking.contains("centred on the mean"), "{ranking}");
    let noisy = text.find("Something else used the machine").unwrap();
    assert!(noisy < text.find("## The paper, sentence by sentence").unwrap() && text.contains("a busy neighbour"));
}

#[test]
fn the_terminal_has_one_line_per_sentence() {
    let (folder, _) = report_of(&Run::generate(&Plan::default()));
    let contents = Contents::read(folder.path()).unwrap();
    let (rows, others) = sentence_rows(&contents);
    // A line for each sentence that was judged, over both scenes where it is about both.
    assert!(rows.iter().filter(|row| row.claim == "faster").count() == 1 && rows.len() >= 13, "{}", rows.len());
    assert_eq!(rows.len() + others, contents.claims.claims.len());
    // The others have a row each in the report, with the reason.
    let absent = contents.verdicts.iter().filter(|row| row.reading != "-" && row.scene == "-");
    assert!(absent.clone().count() > 0 && absent.clone().all(|row| row.note.contains("--variant")));
    let faster = rows.iter().find(|row| row.claim == "faster").unwrap();
    // Planted: 0.8 with an error of half a hundredth.
    let ratio: f64 = faster.value.split_once(' ').unwrap().0.parse().unwrap();
    assert!((ratio - 0.8).abs() < 0.01 && faster.misses == "0 / 0" && faster.scene.contains('+'), "{faster:?}");
}

#[test]
fn a_run_of_one_launch_speaks_of_no_intervals() {
    let answer = |launches: u32| {
        let (_folder, text) = report_of(&Run::generate(&Plan { launches, ..Plan::default() }));
        text.lines().find(|line| line.contains("relative to the plain OBB")).unwrap().to_owned()
    };
    assert!(!answer(1).contains("interval"), "{}", answer(1));
    assert!(answer(3).ends_with("(95 % intervals)."), "{}", answer(3));
    let (_folder, text) = report_of(&Run::generate(&Plan { launches: 1, ..Plan::default() }));
    assert!(text.contains("95 % interval, where it has one: a single launch of programs shows no spread. The order"));
    let [a, b] = SCENES;
    assert!(text.contains(&format!(
        " Speed is undecided on {a} (one launch) and {b} (one launch): the order shows nothing there, so that places are in brackets."
    )));
    assert!(text.contains("\n| (1) | area-weighted OBB |") && !text.contains("\n| 1 |"), "{text}");
}

/// The spread of a single cluster is unknown, here of control poses on one line.
#[test]
fn a_mean_over_one_cluster_has_no_interval() {
    let mut run = Run::generate(&Plan::default());
    run.poses.iter_mut().filter(|row| row.workload == "control").for_each(|row| row.line = 0);
    let (_folder, text) = report_of(&run);
    let times = text.split("## Times and counts of a query").nth(1).unwrap().split("\n## ").next().unwrap();
    for (workload, has_interval) in [("control", false), ("approach", true)] {
        let start = format!("| {} | {workload} |", SCENES[0]);
        let lines: Vec<&str> = times.lines().filter(|line| line.starts_with(&start)).collect();
        assert!(!lines.is_empty() && lines.iter().any(|line| line.contains(" [")) == has_interval, "{lines:?}");
    }
}

/// The report begins with the answer, the figure with its ratios, and the ranking.
#[test]
fn the_report_opens_with_the_answer() {
    let (folder, text) = report_of(&Run::generate(&Plan::default()));
    let headings: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    let first =
        ["The answer", "What this is", "Time of whole programs", "Ranking by speed", "The paper, sentence by sentence"];
    assert_eq!(headings[..first.len()], first);
    assert!(text.contains("**Is the area-weighted OBB faster than the plain OBB?** Yes, in all 2 scenes."), "{text}");
    let programs = text.split("## Time of whole programs").nth(1).unwrap().split("\n## ").next().unwrap();
    assert_eq!(programs.matches("| faster |").count(), SCENES.len(), "{programs}");
    assert!(programs.contains("paper-figure-6.png") && programs.contains("2, 1 of them to a collision"), "{programs}");
    // Readings are columns, spelled out above their table.
    assert!(text.contains(
        "| the paper says | supported | refuted | verdict | R1, conservative | R2, literal | R3, symmetric | control |"
    ));
    assert!(text.contains("- **R2, literal**: the box is centred on the mean"));
    // Every claim says where it is supported and where it is refuted; a named margin refutes by a smaller effect.
    assert!(
        text.contains("Supported: &lt; 0.95. Refuted: ≥ 1.\n")
            && text.contains("Supported: &lt; 0.75. Refuted: ≥ 0.75.\n")
    );
    assert!(text.contains("Supported: a contact missed. Refuted: none missed, at most 0.100 %."));
    let request = Manifest::read(folder.path()).unwrap().request;
    let (launches, blocks, cold) = (request.launches / request.binaries, request.blocks, request.cold_poses);
    assert!(text.contains(&format!(" --launches {launches} --blocks {blocks} --cold-poses {cold} --out DIR")));
}

#[test]
fn old_records_are_analysed_again_to_the_same_bytes() {
    let (folder, text) = report_of(&Run::generate(&Plan::default()));
    let read = |file: &str| std::fs::read(folder.path().join(file)).unwrap();
    let files = ["claims.csv", "ratios.csv", "summary.csv", "plots/time-ratios.svg", "plots/time-ratios.png"];
    let before = files.map(read);
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    draw_all(folder.path()).unwrap();
    assert!(before == files.map(read));
    assert_eq!(text, std::fs::read_to_string(write(folder.path()).unwrap()).unwrap());
}

#[test]
fn a_run_that_was_not_analysed_is_an_error() {
    let folder = TempDir::new().unwrap();
    Run::generate(&Plan::default()).write(folder.path());
    assert!(write(folder.path()).unwrap_err().to_string().contains("claims.toml"));
}
