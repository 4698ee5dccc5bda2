//! The data of the page's scripts, as JSON.

use crate::analysis::claims::CaseRef;
use crate::analysis::{ALL, AnalysisError, Ranked, ranked_by};
use crate::plot::data::entries;
use crate::record::file::table_bytes;
use crate::record::manifest::SceneEntry;
use crate::record::{
    AuditCellRow, AuditEffectRow, AuditShareRow, Band, CASE_COSTS, ClaimRow, CostChunkRow, DEADLINES, Head, Manifest,
    NULL_VARIANT, PeerRatioRow, PeerRow, REPAY, RatioRow, RecordError, Row, Stratum, SummaryRow, SweepSummaryRow,
    Table, TightnessRow, TreeRow, VerificationRow, has_rows,
};
use crate::report::answer::places;
use crate::report::programs::{self, ProgramTotals};
use crate::report::sentences::{Group, blocks, sentences, words};
use crate::report::{Contents, Statement, answer, quantity};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Largest total size of the records in a page, bytes of CSV; as JSON they take about as much again, so the page stays below 8 MB. Larger
/// raw records stay beside the page.
const MOST_BYTES: u64 = 3_000_000;

/// Largest size, bytes, at which a record of an unknown type, such as another tool's summary, is shown.
const MOST_FOREIGN_BYTES: u64 = 200_000;

/// The data of the page.
#[derive(Debug, Serialize)]
pub(super) struct PageData<'a> {
    manifest: &'a Manifest,
    words: Words,
    source: &'a str,
    baselines: &'a [String],
    answer: Vec<Statement>,
    programs: Vec<ProgramTotals>,
    claims: Vec<ClaimEntry<'a>>,
    readings: Vec<ReadingEntry<'a>>,
    /// Groups of sentences of the paper with the same readings: the readings, and the ids of the sentences.
    blocks: Vec<(Vec<&'a str>, Vec<&'a str>)>,
    looks: BTreeMap<String, LookEntry>,
    ranking: &'a [Ranked],
    /// The places of the ranking as text.
    places: Vec<String>,
    /// The workload by which each scene is ranked.
    ranked_by: BTreeMap<&'a str, &'a str>,
    /// The quantity of the ranking, in words.
    quantity: String,
    noise: &'a [String],
    /// The notes in a sentence or two.
    noise_in_short: Option<String>,
    /// Lines of `claims.csv` that represent a claim as a whole.
    standing: Vec<u64>,
    figures: Vec<FigureEntry<'a>>,
    tables: BTreeMap<String, Table>,
    left_out: Vec<String>,
}

/// Names that the records use.
#[derive(Debug, Serialize)]
struct Words {
    all: &'static str,
    null: &'static str,
    strata: [&'static str; 4],
    /// Bands above grazing.
    bands: Vec<&'static str>,
}

/// Colour and marker of a variant, as in the figures.
#[derive(Debug, Serialize)]
struct LookEntry {
    light: String,
    dark: String,
    /// The marker as an SVG path about the origin.
    path: String,
    hollow: bool,
}

#[derive(Debug, Serialize)]
struct ClaimEntry<'a> {
    id: &'a str,
    sentence: &'a str,
    source: &'a str,
    /// `judged`, `literature`, `not-judged`.
    group: &'static str,
    /// Line in `claims.csv` of the row that answers the sentence.
    primary: Option<u64>,
    /// The readings, each with the lines of `claims.csv` that represent the sentence, one for each scene.
    cells: Vec<(&'a str, Vec<u64>)>,
    /// Why the sentence is not judged.
    reason: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct ReadingEntry<'a> {
    id: &'a str,
    name: String,
    words: &'a str,
    subject: String,
    baseline: String,
}

#[derive(Debug, Serialize)]
struct FigureEntry<'a> {
    title: &'a str,
    svg: String,
}

impl<'a> PageData<'a> {
    /// Gathers the data from the run's folder.
    ///
    /// # Errors
    /// When a record is malformed.
    pub fn read(folder: &Path, contents: &'a Contents) -> Result<Self, AnalysisError> {
        let mut shelf = Shelf { folder, tables: BTreeMap::new(), left_out: Vec::new(), room: MOST_BYTES };
        shelf.fill()?;
        let claims = claims(contents);
        let lines =
            |claim: &ClaimEntry<'_>| claim.cells.iter().flat_map(|(_, lines)| lines.clone()).collect::<Vec<_>>();
        let standing = claims.iter().flat_map(|claim| claim.primary.into_iter().chain(lines(claim))).collect();
        let looks = entries(&contents.manifest).into_iter().map(|entry| {
            let [light, dark] = entry.look.css();
            (entry.id, LookEntry { light, dark, path: entry.look.path(), hollow: entry.look.is_hollow() })
        });
        let ids = |(readings, of): (
            Vec<&'a crate::analysis::claims::Reading>,
            Vec<crate::report::sentences::Sentence<'a>>,
        )| {
            let readings = readings.into_iter().map(|reading| reading.id.get_ref().as_str()).collect();
            (readings, of.into_iter().map(|sentence| sentence.claim.id()).collect())
        };
        let workload = |scene: &'a SceneEntry| {
            let name = scene.name.as_str();
            Some((name, ranked_by(&contents.ratios, name)?))
        };
        let figure = |figure: &'a crate::plot::Figure| FigureEntry {
            title: &figure.title,
            svg: figure.svg.display().to_string().replace('\\', "/"),
        };
        Ok(Self {
            manifest: &contents.manifest,
            words: Words {
                all: ALL,
                null: NULL_VARIANT,
                strata: Stratum::ALL.map(Stratum::id),
                bands: Band::ALL.into_iter().filter(|band| band.is_above_grazing()).map(Band::id).collect(),
            },
            source: &contents.claims.source,
            baselines: &contents.claims.comparison.baselines,
            answer: answer(contents),
            programs: programs::table(contents),
            claims,
            blocks: blocks(contents, Group::Judged).into_iter().map(ids).collect(),
            looks: looks.collect(),
            readings: contents.claims.readings.iter().map(reading).collect(),
            ranking: &contents.ranking,
            places: places(contents),
            ranked_by: contents.manifest.scenes.iter().filter_map(workload).collect(),
            quantity: quantity(contents, "program time"),
            noise: &contents.noise,
            noise_in_short: crate::report::noise_in_short(contents),
            standing,
            figures: contents.gallery.figures.iter().map(figure).collect(),
            tables: shelf.tables,
            left_out: shelf.left_out,
        })
    }
}

/// Line of the first row in a CSV file, below the header.
const FIRST_LINE: u64 = 2;

fn claims(contents: &Contents) -> Vec<ClaimEntry<'_>> {
    let line = |row: &ClaimRow| {
        let place = contents.verdicts.iter().position(|other| std::ptr::eq(other, row));
        place.map(|place| place as u64 + FIRST_LINE)
    };
    sentences(contents)
        .into_iter()
        .map(|sentence| {
            let rows = sentence.cells.iter().flat_map(|(_, rows)| rows.iter().copied()).chain(sentence.primary);
            let mut notes = rows.filter(|row| row.verdict == "not-judged").map(|row| row.note.as_str());
            let note = notes.next();
            ClaimEntry {
                id: sentence.claim.id(),
                sentence: &sentence.claim.sentence,
                source: &sentence.claim.source,
                group: match sentence.group {
                    Group::Judged => "judged",
                    Group::Literature => "literature",
                    Group::NotJudged => "not-judged",
                },
                primary: sentence.primary.and_then(line),
                cells: sentence
                    .cells
                    .iter()
                    .map(|(reading, rows)| (*reading, rows.iter().filter_map(|row| line(row)).collect()))
                    .collect(),
                reason: sentence.claim.not_judged.as_deref().or(note),
            }
        })
        .collect()
}

fn reading(reading: &crate::analysis::claims::Reading) -> ReadingEntry<'_> {
    let name = |case: &CaseRef| {
        case.policy.as_ref().map_or_else(|| case.variant.clone(), |policy| format!("{} ({policy})", case.variant))
    };
    let (short, words) = words(reading);
    ReadingEntry {
        id: reading.id.get_ref(),
        name: short,
        words,
        subject: name(&reading.subject),
        baseline: name(&reading.baseline),
    }
}

/// The records in the page, within the size limit.
struct Shelf<'a> {
    folder: &'a Path,
    tables: BTreeMap<String, Table>,
    left_out: Vec<String>,
    room: u64,
}

impl Shelf<'_> {
    /// Adds records: first those that the charts need, then those of supplements, then other small records.
    fn fill(&mut self) -> Result<(), RecordError> {
        self.add::<ClaimRow>()?;
        self.add::<SummaryRow>()?;
        self.add::<VerificationRow>()?;
        self.add::<RatioRow>()?;
        self.add::<TightnessRow>()?;
        self.add::<TreeRow>()?;
        for Head { file, .. } in [REPAY, CASE_COSTS, DEADLINES] {
            if self.folder.join(file).exists() {
                self.put_file(file, self.room)?;
            }
        }
        self.add::<PeerRatioRow>()?;
        self.add::<PeerRow>()?;
        self.add::<SweepSummaryRow>()?;
        self.add::<AuditCellRow>()?;
        self.add::<AuditShareRow>()?;
        self.add::<AuditEffectRow>()?;
        self.add::<CostChunkRow>()?;
        let files = std::fs::read_dir(self.folder).map_err(RecordError::io("read", self.folder))?;
        let names = files.filter_map(|file| file.ok()?.file_name().into_string().ok());
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".csv")).collect();
        names.sort_unstable();
        for name in names {
            if !self.tables.contains_key(&name) && !self.left_out.contains(&name) {
                self.put_file(&name, MOST_FOREIGN_BYTES)?;
            }
        }
        Ok(())
    }

    fn add<R: Row>(&mut self) -> Result<(), RecordError> {
        if has_rows::<R>(self.folder) { self.put(R::FILE, self.room, Table::of::<R>) } else { Ok(()) }
    }

    fn put_file(&mut self, file: &str, most: u64) -> Result<(), RecordError> {
        self.put(file, most, |folder| Table::of_file(folder, file))
    }

    fn put(
        &mut self,
        file: &str,
        most: u64,
        read: impl FnOnce(&Path) -> Result<Table, RecordError>,
    ) -> Result<(), RecordError> {
        match table_bytes(self.folder, file, most.min(self.room))? {
            Some(bytes) => {
                self.room -= bytes;
                self.tables.insert(file.to_owned(), read(self.folder)?);
            }
            None => self.left_out.push(file.to_owned()),
        }
        Ok(())
    }
}
