//! Draws all figures from a made-up run and checks the files.

use super::*;
use crate::analysis::{analyze, claims::ClaimSet};
use crate::record::synthetic::{PLANTED, Plan, Planted, Run, SCENES};
use crate::record::{
    BuildRow, Kind, OutlineRow, PROGRAM_TIME, PeerRatioRow, Row, TightnessRow, VerificationRow, read_rows, write_rows,
    write_rows_compressed,
};
use std::collections::BTreeSet;
use std::fs;
use tempfile::TempDir;

/// Width and height in a PNG's header.
fn png_size(bytes: &[u8]) -> (u32, u32) {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

/// Every opened element is closed, in order.
fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (tag, _text) = tag.split_once('>').expect("a tag ends");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            open.push(tag.split_whitespace().next().unwrap());
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

/// The text of an SVG, without line breaks and escapes.
fn words(svg: &str) -> String {
    let text: Vec<&str> = svg.split('<').filter_map(|tag| tag.split_once('>')).map(|(_, text)| text.trim()).collect();
    text.join(" ").replace("&apos;", "'").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_figure_is_drawn_with_every_variant() {
    let folder = TempDir::new().unwrap();
    // Set BVBENCH_KEEP_PLOTS to a folder to look at the figures of this made-up run.
    let path = std::env::var_os("BVBENCH_KEEP_PLOTS").map_or_else(|| folder.path().to_owned(), PathBuf::from);
    Run::generate(&Plan::default()).write(&path);
    analyze(&path, &ClaimSet::standard()).unwrap();
    let gallery = draw_all(&path).unwrap();
    assert_eq!(gallery.skipped, []);
    assert_eq!(gallery.figures.len(), 10);
    assert_eq!(read_gallery(&path).unwrap(), gallery);
    for figure in &gallery.figures {
        let svg = fs::read_to_string(path.join(&figure.svg)).unwrap();
        assert_well_formed(&svg);
        let png = fs::read(path.join(&figure.png)).unwrap();
        let (width, height) = png_size(&png);
        assert!(width >= 1200 && height >= 400 && png.len() > 20_000, "{}: {width}x{height}", figure.name);
        let words = words(&svg);
        assert!(words.contains(&figure.title), "{}: {words}", figure.name);
        if ["query-time-by-stratum", "time-ratios", "misses-by-depth", "build-time"].contains(&figure.name.as_str()) {
            // Nothing has a ratio to itself, and the control runs neither the workloads' poses nor programs.
            let is_drawn = |p: &&Planted| match figure.name.as_str() {
                "time-ratios" => p.id != "obb-vertex" && p.kind != Kind::Control,
                "query-time-by-stratum" => p.kind != Kind::Control,
                _ => true,
            };
            for planted in PLANTED.iter().filter(is_drawn) {
                assert!(words.contains(planted.label), "{} lacks {}", figure.name, planted.label);
            }
        }
    }
}

#[test]
fn drawing_is_deterministic_and_not_blank() {
    let folder = TempDir::new().unwrap();
    Run::generate(&Plan::default()).write(folder.path());
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    let data = Data::read(folder.path()).unwrap();
    let drawing = paper_figure::sketch(&data).drawing.unwrap();
    let (once, again) = (canvas::pixels(&drawing).unwrap(), canvas::pixels(&drawing).unwrap());
    assert!(once == again);
    let coloured = once.chunks_exact(3).filter(|p| p.iter().max() != p.iter().min()).count();
    assert!(coloured > 5000, "{coloured} coloured pixels");
    assert_eq!(canvas::svg(&drawing).unwrap(), canvas::svg(&drawing).unwrap());
}

#[test]
fn compressed_rows_make_the_same_figures() {
    fn pack<R: Row>(folder: &Path) {
        let rows: Vec<R> = read_rows(folder).unwrap();
        write_rows_compressed(folder, &rows).unwrap();
        assert!(!folder.join(R::FILE).exists());
    }
    let folder = TempDir::new().unwrap();
    Run::generate(&Plan::default()).write(folder.path());
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    let plain = draw_all(folder.path()).unwrap();
    pack::<BuildRow>(folder.path());
    pack::<OutlineRow>(folder.path());
    pack::<TightnessRow>(folder.path());
    pack::<VerificationRow>(folder.path());
    assert_eq!(draw_all(folder.path()).unwrap(), plain);
}

#[test]
fn missing_records_skip_figures_and_say_why() {
    let folder = TempDir::new().unwrap();
    Run::generate(&Plan::default()).manifest.write(folder.path()).unwrap();
    let gallery = draw_all(folder.path()).unwrap();
    assert_eq!((gallery.figures.len(), gallery.skipped.len()), (0, 10));
    assert!(gallery.skipped.iter().all(|skipped| skipped.reason.contains(".csv")));
    fs::write(folder.path().join("ratios.csv"), "scene\n1\n").unwrap();
    assert!(draw_all(folder.path()).unwrap_err().to_string().contains("ratios.csv"));
}

/// A run of flat parts, of which some scenes have no programs: what is skipped says so, and the ratios name the quantity of each scene.
#[test]
fn reasons_and_titles_follow_the_data() {
    let [a, b] = SCENES;
    let mixed = format!("Query time in `program` on {a} and time of the programs on {b}");
    let cases: [(&[&str], &str, bool); 3] =
        [(&[], "Time of the programs", false), (&[a], &mixed, false), (&[a, b], "Query time in `program`", true)];
    for (without, quantity, has_no_programs) in cases {
        let mut run = Run::generate(&Plan::default());
        run.poses.retain(|row| row.workload != PROGRAM_TIME || !without.contains(&row.scene.as_str()));
        let chunks: BTreeSet<(&str, u32)> = run.poses.iter().map(|row| (row.scene.as_str(), row.chunk)).collect();
        run.timings.retain(|row| chunks.contains(&(row.scene.as_str(), row.chunk)));
        for row in &mut run.tightness {
            (row.hull_mm3, row.hulled_volume_mm3) = (0.0, 0.0);
            (row.hausdorff_mm, row.sibling_overlap_mm3) = (None, None);
        }
        let folder = TempDir::new().unwrap();
        run.write(folder.path());
        analyze(folder.path(), &ClaimSet::standard()).unwrap();
        let gallery = draw_all(folder.path()).unwrap();
        let skipped: Vec<(&str, &str)> =
            gallery.skipped.iter().map(|skipped| (skipped.name.as_str(), skipped.reason.as_str())).collect();
        let flat = "tightness.csv holds no contents with a convex hull: the parts are flat";
        let programs = (PAPER_FIGURE, "program_times.csv holds no rows: the run timed no whole programs");
        let expected = [programs, ("tightness-by-level", flat), ("tightness-by-frame", flat)];
        assert_eq!(skipped, expected[usize::from(!has_no_programs)..]);
        let figure = gallery.figures.iter().find(|figure| figure.name == "time-ratios").unwrap();
        assert_eq!(figure.title, format!("{quantity} against plain OBB"));
        assert!(figure.caption.starts_with(&format!("{quantity}, over that of plain OBB")), "{}", figure.caption);
    }
}

#[test]
fn engines_are_drawn_where_a_run_has_them() {
    let folder = TempDir::new().unwrap();
    Run::generate(&Plan::default()).manifest.write(folder.path()).unwrap();
    let row = |engine: &str, scene: &str, stratum: &str, ratio: f64| PeerRatioRow {
        engine: engine.into(),
        reference: "steady".into(),
        scene: scene.into(),
        stratum: stratum.into(),
        mode: "first".into(),
        ratio,
        low: 0.9 * ratio,
        high: 1.1 * ratio,
        p99_ratio: ratio,
    };
    let rows = [
        row("steady", "mill", "all", 1.0),
        row("swift", "mill", "all", 20.0),
        row("only-far", "mill", "far", 3.0),
        row("steady", "lathe", "all", 1.0),
        row("late", "lathe", "all", 0.01),
    ];
    write_rows(folder.path(), &rows).unwrap();
    let gallery = draw_all(folder.path()).unwrap();
    let [figure] = gallery.figures.as_slice() else { panic!("{gallery:?}") };
    assert!(figure.caption.contains("steady"));
    let words = words(&fs::read_to_string(folder.path().join(&figure.svg)).unwrap());
    for drawn in ["swift", "late", "mill, first", "lathe, first"] {
        assert!(words.contains(drawn), "{drawn}: {words}");
    }
    assert!(!words.contains("only-far") && !words.contains("off scale"), "{words}");
}
