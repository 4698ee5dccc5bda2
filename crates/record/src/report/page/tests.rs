//! Tests of the page's text. Its look and its reactions to clicks are tested in a browser.

use super::*;
use crate::analysis::analyze;
use crate::analysis::claims::ClaimSet;
use crate::record::synthetic::{PLANTED, Plan, Run, SCENES};
use crate::record::{PROGRAM_TIME, RatioRow, TimingRow, read_rows, write_rows};
use serde_json::Value;
use tempfile::TempDir;

fn page_of(run: &Run, insets: &[Inset]) -> (TempDir, String) {
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    let text = std::fs::read_to_string(write_page(folder.path(), insets).unwrap()).unwrap();
    (folder, text)
}

fn data_of(page: &str) -> Value {
    let data = page.split("id=\"data-of-the-run\" type=\"application/json\">").nth(1).unwrap();
    serde_json::from_str(data.split("</script>").next().unwrap()).unwrap()
}

#[test]
fn the_page_stands_alone_and_no_text_escapes() {
    let mut run = Run::generate(&Plan::default());
    run.manifest.request.profile = "</title> & {{data}}".to_owned();
    run.manifest.scenes[0].title = "</script><b>".to_owned();
    let (_folder, page) = page_of(&run, &[]);
    assert!(page.contains("<title>Bounding volumes on trial: &lt;/title&gt; &amp; {{data}} run</title>"));
    // One end for the data and one for the scripts.
    assert_eq!(page.matches("</script>").count(), 2);
    assert_eq!(data_of(&page)["manifest"]["scenes"][0]["title"], "</script><b>");
    for outside in ["https://", "src=", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    // The one address is the name of a language, which nothing is loaded from.
    assert_eq!(page.matches("http://").count(), page.matches("http://www.w3.org/2000/svg").count());
    assert!(page.len() < 8_000_000, "{}", page.len());
}

/// The line that a mark names holds the row of that mark.
#[test]
fn every_row_names_the_line_it_stands_on() {
    let (folder, page) = page_of(&Run::generate(&Plan::default()), &[]);
    let data = data_of(&page);
    for file in
        ["claims.csv", "ratios.csv", "summary.csv", "tightness.csv", "verification.csv", "trees.csv", "repay.csv"]
    {
        let table = &data["tables"][file];
        let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let rows = table["rows"].as_array().unwrap();
        assert_eq!(rows.len(), lines.len() - 1, "{file}");
        for row in rows {
            let line = lines[row[0].as_u64().unwrap() as usize - 1];
            assert!(line.starts_with(&format!("{},", row[1].as_str().unwrap())), "{file}: {line}");
        }
    }
    // Each sentence names the rows that stand for it: its primary one, and for each reading one per scene.
    let claims = &data["tables"]["claims.csv"];
    let column = |name: &str| claims["columns"].as_array().unwrap().iter().position(|c| c == name).unwrap() + 1;
    let cell = |line: u64, name: &str| claims["rows"][line as usize - 2][column(name)].as_str().unwrap().to_owned();
    let sentences = data["claims"].as_array().unwrap();
    assert_eq!(sentences.len(), ClaimSet::standard().claims.len());
    for sentence in sentences {
        if let Some(line) = sentence["primary"].as_u64() {
            assert_eq!([cell(line, "claim"), cell(line, "role")], [sentence["id"].as_str().unwrap(), "primary"]);
        }
        for reading in sentence["cells"].as_array().unwrap() {
            let lines: Vec<u64> = reading[1].as_array().unwrap().iter().map(|line| line.as_u64().unwrap()).collect();
            let scenes: Vec<String> = lines.iter().map(|line| cell(*line, "scene")).collect();
            assert!(lines.iter().all(|line| cell(*line, "reading") == reading[0].as_str().unwrap()), "{sentence}");
            assert!(scenes.iter().enumerate().all(|(i, scene)| !scenes[..i].contains(scene)), "{sentence}: {scenes:?}");
        }
    }
    let faster = sentences.iter().find(|sentence| sentence["id"] == "faster").unwrap();
    assert_eq!(faster["group"], "judged");
    assert_eq!(faster["cells"][0][1].as_array().unwrap().len(), SCENES.len());
    // A variant looks as in the figures: hollow when it is unsafe.
    for planted in PLANTED.iter().filter(|planted| planted.kind == crate::record::Kind::Volume) {
        assert_eq!(data["looks"][planted.id]["hollow"], !planted.safe, "{}", planted.id);
    }
    assert_eq!(data["manifest"]["variants"].as_array().unwrap().len(), PLANTED.len());
    assert_eq!(data["words"]["bands"].as_array().unwrap().len(), 6);
}

/// The page shows the ratios by which a scene is ranked, also of one without programs beside one with them.
#[test]
fn each_scene_has_the_workload_of_its_ranking() {
    let [a, b] = SCENES;
    let (folder, _) = page_of(&Run::generate(&Plan::default()), &[]);
    let mut ratios: Vec<RatioRow> = read_rows(folder.path()).unwrap();
    ratios.retain(|row| row.scene != b || !row.workload.starts_with(PROGRAM_TIME));
    write_rows(folder.path(), &ratios).unwrap();
    let data = data_of(&std::fs::read_to_string(write_page(folder.path(), &[]).unwrap()).unwrap());
    assert_eq!(data["ranked_by"], serde_json::json!({ a: PROGRAM_TIME, b: "program" }));
    assert_eq!(data["quantity"], format!("program time on {a} and query time in `program` on {b}").as_str());
}

#[test]
fn optional_and_foreign_records_are_shown_and_large_ones_named() {
    let run = Run::generate(&Plan::default());
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    std::fs::write(folder.path().join("ablation.csv"), "what,ns\nlanes,1.5\n").unwrap();
    let header = "engine,scene,stratum,poses,mean_ns,median_ns,p99_ns,false_negatives,false_positives,build_ns,bytes,triangles,mode";
    std::fs::write(folder.path().join("peers.csv"), format!("{header}\nours,s,all,1,2.0,2.0,2.0,0,0,5,0,12,first\n"))
        .unwrap();
    let page = std::fs::read_to_string(write_page(folder.path(), &[]).unwrap()).unwrap();
    let data = data_of(&page);
    assert_eq!(data["tables"]["ablation.csv"]["rows"], serde_json::json!([[2, "lanes", 1.5]]));
    assert_eq!(data["tables"]["peers.csv"]["rows"][0][1], "ours");
    assert!(!read_rows::<TimingRow>(folder.path()).unwrap().is_empty());
    assert!(
        data["tables"]["timings.csv"].is_null() && data["left_out"].as_array().unwrap().contains(&"timings.csv".into())
    );
    std::fs::write(
        folder.path().join("peers.csv"),
        format!("{header}\nours,s,all,many,2.0,2.0,2.0,0,0,5,0,12,first\n"),
    )
    .unwrap();
    assert!(write_page(folder.path(), &[]).unwrap_err().to_string().contains("peers.csv"));
}

#[test]
fn insets_have_a_section_of_their_own() {
    let run = Run::generate(&Plan::default());
    let inset = Inset { title: "a <machine>".into(), html: "<p id=\"mine\">{{data}}</p>".into() };
    let (_folder, page) = page_of(&run, &[inset]);
    assert!(page.contains("<h3>a &lt;machine&gt;</h3>\n<p id=\"mine\">{{data}}</p>"), "an inset is put in as it is");
    assert!(page.contains("href=\"#machines\""));
    assert!(!page_of(&run, &[]).1.contains("id=\"machines\""));
}
