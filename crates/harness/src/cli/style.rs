//! Tables and colours of the terminal. Colours only where a person looks: not into files and pipes, and not when `NO_COLOR` is
//! set; `CLICOLOR_FORCE` asks for them all the same.

use anstream::{AutoStream, ColorChoice};
use anstyle::{AnsiColor, Style};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// Columns that tables fit when nobody knows how wide the terminal is, and that they do not exceed on a wider one.
const WIDTH: u16 = 100;

/// How a word is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// As one wants it.
    Good,
    /// Not as one wants it.
    Bad,
    /// To be looked at.
    Doubtful,
    /// Of no weight.
    Dim,
}

impl Tone {
    const fn style(self) -> Style {
        match self {
            Self::Good => AnsiColor::Green.on_default(),
            Self::Bad => AnsiColor::Red.on_default().bold(),
            Self::Doubtful => AnsiColor::Yellow.on_default(),
            Self::Dim => Style::new().dimmed(),
        }
    }
}

/// Whether standard output shows colours.
pub fn is_coloured() -> bool {
    AutoStream::choice(&std::io::stdout()) != ColorChoice::Never
}

/// The text with the words in their tones, where `coloured`. Words are coloured in finished text, so that they do not count
/// as wider than they look; a word that is part of another one is left alone.
pub fn painted(text: &str, tones: &[(&str, Tone)], coloured: bool) -> String {
    if !coloured {
        return text.to_owned();
    }
    tones.iter().fold(text.to_owned(), |text, (word, tone)| paint_word(&text, word, tone.style()))
}

fn paint_word(text: &str, word: &str, style: Style) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '-';
    let mut painted = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(place) = rest.find(word) {
        let (before, after) = (&rest[..place], &rest[place + word.len()..]);
        painted += before;
        if painted.ends_with(is_part) || after.starts_with(is_part) {
            painted += word;
        } else {
            painted += &format!("{style}{word}{style:#}");
        }
        rest = after;
    }
    painted + rest
}

/// An empty table with these headings, as wide as its cells; headings that begin with `>` are of columns aligned right.
pub fn plain<S: AsRef<str>>(headings: impl IntoIterator<Item = S>) -> Table {
    let headings: Vec<S> = headings.into_iter().collect();
    let mut table = Table::new();
    table
        .load_style(presets::NOTHING)
        .set_header(headings.iter().map(|heading| heading.as_ref().trim_start_matches('>')));
    for (column, _) in table.column_iter_mut().zip(&headings).filter(|(_, heading)| heading.as_ref().starts_with('>')) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// An empty table with these headings, as of [`plain`], that fits the terminal and [`WIDTH`] columns.
pub fn table(headings: &[&str]) -> Table {
    table_within(headings, usize::from(WIDTH))
}

/// As [`table`], no wider than `columns`.
pub fn table_within(headings: &[&str], columns: usize) -> Table {
    let most = u16::try_from(columns).unwrap_or(WIDTH);
    let mut table = plain(headings);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(table.width().map_or(most, |width| width.min(most)));
    // A space between columns, so that rows of long values still fit.
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 1));
    });
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_words_are_painted_and_only_in_colour() {
        let tones = [("reversed", Tone::Bad), ("noise", Tone::Dim)];
        let text = "reversed reversed-twice irreversed reversed, noise";
        assert_eq!(painted(text, &tones, false), text);
        let (bad, dim) = (Tone::Bad.style(), Tone::Dim.style());
        let expected =
            format!("{bad}reversed{bad:#} reversed-twice irreversed {bad}reversed{bad:#}, {dim}noise{dim:#}");
        assert_eq!(painted(text, &tones, true), expected);
    }

    #[test]
    fn a_table_of_long_words_fits_its_columns() {
        let mut table = table(&["NAME", ">VALUE", "NOTE"]);
        let name = "a-name-that-nobody-would-give-".repeat(3);
        table.add_row([&*name, "123456.789", &"words and more words ".repeat(20)]);
        assert!(table.trim_fmt().lines().all(|line| line.chars().count() <= usize::from(WIDTH)), "{table}");
    }
}
