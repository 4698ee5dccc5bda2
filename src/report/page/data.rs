//! What the page's scripts get, as JSON.

use crate::analysis::claims::{CaseRef, Claim};
use crate::analysis::{ALL, Ranked};
use crate::record::file::located;
use crate::record::{
    AuditCellRow, AuditEffectRow, AuditShareRow, Band, ClaimRow, CostChunkRow, CostRow, DeadlineRow, Manifest,
    NULL_VARIANT, PeerRatioRow, PeerRow, RatioRow, RecordError, RepayRow, Row, Stratum, SummaryRow, SweepSummaryRow,
    Table, TightnessRow, TreeRow, VerificationRow,
};
use crate::report::terminal::stands_for_claim;
use crate::report::{Contents, ReportError};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Bytes of records that a page may hold, as CSV; as JSON they take about as much again. Raw records of the largest runs stay
/// beside the page, which then stays below 8 MB.
const MOST_BYTES: u64 = 3_000_000;

/// A record of no type known here, such as another tool's summary, is shown when it is no larger than this, bytes.
const MOST_FOREIGN_BYTES: u64 = 200_000;

/// Everything.
#[derive(Debug, Serialize)]
pub(super) struct PageData<'a> {
    manifest: &'a Manifest,
    words: Words,
    source: &'a str,
    baselines: &'a [String],
    claims: Vec<ClaimEntry<'a>>,
    readings: Vec<ReadingEntry<'a>>,
    ranking: &'a [Ranked],
    noise: &'a [String],
    /// Lines of `claims.csv` that stand for a claim as a whole.
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

#[derive(Debug, Serialize)]
struct ClaimEntry<'a> {
    id: &'a str,
    sentence: &'a str,
    source: &'a str,
    readings: Vec<&'a str>,
    not_judged: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct ReadingEntry<'a> {
    id: &'a str,
    title: &'a str,
    subject: String,
    baseline: String,
}

#[derive(Debug, Serialize)]
struct FigureEntry<'a> {
    title: &'a str,
    svg: String,
}

impl<'a> PageData<'a> {
    /// Gathers it from the run's folder.
    ///
    /// # Errors
    /// When a record is malformed.
    pub fn read(folder: &Path, contents: &'a Contents) -> Result<Self, ReportError> {
        let mut shelf = Shelf { folder, tables: BTreeMap::new(), left_out: Vec::new(), room: MOST_BYTES };
        shelf.fill()?;
        let standing = shelf.tables.get(ClaimRow::FILE).map_or_else(Vec::new, |table| {
            let rows = table.rows.iter().zip(&contents.verdicts);
            let standing = rows.filter(|(_, verdict)| stands_for_claim(verdict, &contents.verdicts));
            standing.filter_map(|(row, _)| row[0].as_u64()).collect()
        });
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
            claims: contents.claims.claims.iter().map(claim).collect(),
            readings: contents.claims.readings.iter().map(reading).collect(),
            ranking: &contents.ranking,
            noise: &contents.noise,
            standing,
            figures: contents.gallery.figures.iter().map(figure).collect(),
            tables: shelf.tables,
            left_out: shelf.left_out,
        })
    }
}

fn claim(claim: &Claim) -> ClaimEntry<'_> {
    ClaimEntry {
        id: claim.id(),
        sentence: &claim.sentence,
        source: &claim.source,
        readings: claim.readings.iter().map(|id| id.get_ref().as_str()).collect(),
        not_judged: claim.not_judged.as_deref(),
    }
}

fn reading(reading: &crate::analysis::claims::Reading) -> ReadingEntry<'_> {
    let name = |case: &CaseRef| {
        case.policy.as_ref().map_or_else(|| case.variant.clone(), |policy| format!("{} ({policy})", case.variant))
    };
    ReadingEntry {
        id: reading.id.get_ref(),
        title: &reading.title,
        subject: name(&reading.subject),
        baseline: name(&reading.baseline),
    }
}

/// A compressed table is about so many times as long when it is read.
const TIMES_COMPRESSED: u64 = 12;

/// The records that the page holds, as long as there is room.
struct Shelf<'a> {
    folder: &'a Path,
    tables: BTreeMap<String, Table>,
    left_out: Vec<String>,
    room: u64,
}

impl Shelf<'_> {
    /// What the charts need first, then what some runs have beside it, then any other small record.
    fn fill(&mut self) -> Result<(), RecordError> {
        self.add::<ClaimRow>()?;
        self.add::<SummaryRow>()?;
        self.add::<VerificationRow>()?;
        self.add::<RatioRow>()?;
        self.add::<TightnessRow>()?;
        self.add::<TreeRow>()?;
        self.add::<RepayRow>()?;
        self.add::<CostRow>()?;
        self.add::<DeadlineRow>()?;
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
                self.put(&name, MOST_FOREIGN_BYTES, |folder| Table::of_file(folder, &name))?;
            }
        }
        Ok(())
    }

    fn add<R: Row>(&mut self) -> Result<(), RecordError> {
        if located(self.folder, R::FILE).exists() { self.put(R::FILE, self.room, Table::of::<R>) } else { Ok(()) }
    }

    fn put(
        &mut self,
        file: &str,
        most: u64,
        read: impl FnOnce(&Path) -> Result<Table, RecordError>,
    ) -> Result<(), RecordError> {
        let path = located(self.folder, file);
        let mut bytes = std::fs::metadata(&path).map_err(RecordError::io("read", &path))?.len();
        if path != self.folder.join(file) {
            bytes *= TIMES_COMPRESSED;
        }
        if bytes > most.min(self.room) {
            self.left_out.push(file.to_owned());
        } else {
            self.room -= bytes;
            self.tables.insert(file.to_owned(), read(self.folder)?);
        }
        Ok(())
    }
}
