//! What `repro`, `try` and `analyze` end with: the answer, a ranking and the verdicts, in 80 columns.

use super::style::{self, Tone};
use crate::plot::marks::wrap;
use crate::report::{
    Contents, PREVIEW, RankedRow, answer, capital, is_preview, noise_in_short, quantity, ranked_rows, sentence_rows,
};

/// Columns that everything here fits.
const COLUMNS: usize = 80;

/// Scenes that have a column of their own in the ranking; of more only the range is shown.
const SCENES: usize = 3;

/// Characters of a variant's or a scene's name.
const NAME: usize = 28;

/// The words of verdicts.
const TONES: [(&str, Tone); 4] =
    [("supported", Tone::Good), ("refuted", Tone::Bad), ("undecided", Tone::Doubtful), ("not-applicable", Tone::Dim)];

/// The conclusion of an analysed run.
pub fn text(contents: &Contents, coloured: bool) -> String {
    let sections = [answers(contents), ranking(contents), verdicts(contents), noise(contents), preview(contents)];
    let text = sections.into_iter().filter(|section| !section.is_empty()).collect::<Vec<_>>().join("\n\n");
    style::painted(&text, &TONES, coloured)
}

fn answers(contents: &Contents) -> String {
    let each = answer(contents).into_iter().map(|statement| {
        let lines = wrap(&statement.answer, COLUMNS - 2).into_iter().map(|line| format!("  {line}"));
        [statement.question].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
    });
    each.collect::<Vec<_>>().join("\n")
}

fn ranking(contents: &Contents) -> String {
    let rows = ranked_rows(contents);
    if rows.is_empty() {
        return String::new();
    }
    let baseline = contents.claims.comparison.baselines.first().map_or("", |id| contents.label(id));
    let what = capital(&quantity(contents, "time of whole programs"));
    let scenes: Vec<&str> = contents.manifest.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let few = scenes.len() <= SCENES && scenes.iter().map(|scene| scene.len() + 1).sum::<usize>() + NAME + 3 <= COLUMNS;
    let mut headings = vec![">", "SAFE VARIANT"];
    let right: Vec<String> = scenes.iter().map(|scene| format!(">{scene}")).collect();
    if few {
        headings.extend(right.iter().map(String::as_str));
    } else {
        headings.extend([">MEAN", ">LEAST", ">MOST"]);
    }
    let mut table = style::table_within(&headings, COLUMNS);
    let is_decided = !rows.iter().any(|row| row.place.starts_with('('));
    for row in rows {
        let numbers = if few { row.scenes.clone() } else { spread(&row) };
        let cells = [row.place, shortened(&row.label)].into_iter().chain(numbers);
        table.add_row(cells);
    }
    let undecided = if is_decided { "" } else { " Places are in brackets where speed is undecided in every scene." };
    let note =
        format!("Places are by the geometric mean over the scenes; - is no volume on the common tree.{undecided}");
    let [what, note] =
        [&format!("{what} relative to the {baseline}:"), &note].map(|text| wrap(text, COLUMNS).join("\n"));
    format!("{what}\n{}\n{note}", table.trim_fmt())
}

/// Mean, least and most of a row's ratios.
fn spread(row: &RankedRow) -> Vec<String> {
    let mut values: Vec<(f64, &String)> =
        row.scenes.iter().filter_map(|text| Some((text.parse().ok()?, text))).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let end = |value: Option<&(f64, &String)>| value.map_or_else(|| "-".to_owned(), |(_, text)| (*text).clone());
    vec![row.mean.clone(), end(values.first()), end(values.last())]
}

fn shortened(label: &str) -> String {
    if label.chars().count() <= NAME { label.to_owned() } else { label.chars().take(NAME - 1).chain(['…']).collect() }
}

fn verdicts(contents: &Contents) -> String {
    let (rows, others) = sentence_rows(contents);
    if rows.is_empty() {
        return String::new();
    }
    let mut table = style::table_within(&["SENTENCE", "VERDICT", "VALUE [95 %]", ">MISSED"], COLUMNS);
    let mut scenes: Vec<String> = Vec::new();
    for row in rows {
        if !scenes.contains(&row.scene) {
            scenes.push(row.scene);
        }
        table.add_row([row.claim, row.verdict, row.value, row.misses]);
    }
    let about = wrap(&format!("The paper's sentences, on {}:", scenes.join(", ").replace('+', " and ")), COLUMNS);
    let rest = if others > 0 {
        let rest = format!("The report names {others} more sentences: of other literature, or not judged and why.");
        format!("\n{}", wrap(&rest, COLUMNS).join("\n"))
    } else {
        String::new()
    };
    let missed = "MISSED: contacts missed by what is proposed / by what it is compared with.";
    format!("{}\n{}\n{missed}{rest}", about.join("\n"), table.trim_fmt())
}

fn noise(contents: &Contents) -> String {
    noise_in_short(contents)
        .map(|text| wrap(&format!("{text} report.md has the cells."), COLUMNS).join("\n"))
        .unwrap_or_default()
}

fn preview(contents: &Contents) -> String {
    if is_preview(&contents.manifest) { wrap(&PREVIEW.replace('`', ""), COLUMNS).join("\n") } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::analyze;
    use crate::analysis::claims::ClaimSet;
    use crate::record::NULL_VARIANT;
    use crate::synthetic::{Plan, Run};

    /// The text of a made-up run after a change of its contents.
    fn conclusion(change: impl FnOnce(&mut Contents)) -> String {
        let folder = tempfile::TempDir::new().unwrap();
        Run::generate(&Plan::default()).write(folder.path());
        analyze(folder.path(), &ClaimSet::standard()).unwrap();
        let mut contents = Contents::read(folder.path()).unwrap();
        change(&mut contents);
        text(&contents, false)
    }

    fn widest(text: &str) -> usize {
        text.lines().map(|line| line.chars().count()).max().unwrap_or(0)
    }

    #[test]
    fn the_conclusion_has_answer_ranking_and_verdicts_in_eighty_columns() {
        let text = conclusion(|_| ());
        assert!(
            text.starts_with("Is the area-weighted OBB faster than the plain OBB?\n  Yes, in all 2 scenes."),
            "{text}"
        );
        let ranking = text.find("SAFE VARIANT").unwrap();
        let verdicts = text.find("SENTENCE").unwrap();
        assert!(ranking < verdicts && text[ranking..verdicts].contains("lathe-toolpost"), "{text}");
        assert!(text[verdicts..].contains("faster"), "{text}");
        assert!(widest(&text) <= COLUMNS, "{text}");
    }

    #[test]
    fn a_run_of_one_binary_is_called_a_preview() {
        assert!(conclusion(|_| ()).contains("This run is a preview"));
        assert!(!conclusion(|contents| contents.manifest.request.binaries = 5).contains("preview"));
    }

    #[test]
    fn long_names_and_noise_fit_too() {
        let text = conclusion(|contents| {
            let long = "a-scene-with-a-name-that-nobody-would-give-it";
            contents
                .ratios
                .iter_mut()
                .filter(|row| row.scene == "lathe-toolpost")
                .for_each(|row| long.clone_into(&mut row.scene));
            long.clone_into(&mut contents.manifest.scenes[0].name);
            let nulls = contents.ratios.iter_mut().filter(|row| row.variant == NULL_VARIANT);
            nulls.for_each(|row| row.ratio = 1.5);
        });
        assert!(text.contains("MEAN") && text.contains("Noisy: "), "{text}");
        assert!(widest(&text) <= COLUMNS, "{} columns:\n{text}", widest(&text));
    }
}
