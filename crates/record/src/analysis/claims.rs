//! The claims file: what the paper says, which cases each claim is about, and the threshold for calling it reproduced. Variants are named
//! in `paper-repro/claims.toml` and nowhere in this code.

use super::ablation::ThesisClaim;
use crate::record::{RecordError, Stratum, read_text};
use serde::Deserialize;
use std::ops::Range;
use std::path::Path;
use thiserror::Error;
use toml::Spanned;

/// Version of the claims file this program reads.
const SCHEMA: u32 = 1;

/// Text of the committed claims on the paper.
pub const DEFAULT_TEXT: &str = include_str!("../../../../paper-repro/claims.toml");

/// Name of the committed claims, in messages and in the folder of a run.
pub const FILE: &str = "claims.toml";

/// Why a claims file cannot be used.
#[derive(Debug, Error)]
pub enum ClaimsError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] RecordError),
    /// The content of the file is wrong.
    #[error("{file}:{line}:{column}: {problem}, at `{text}`")]
    Bad {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
        /// Text of the line, from the error onwards.
        text: String,
    },
}

/// All claims, with the readings that they are judged in and the cases that they are compared with.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimSet {
    schema: Spanned<u32>,
    /// Source of the claims.
    pub source: String,
    /// The cases that every variant is compared with.
    pub comparison: Comparison,
    /// The readings.
    #[serde(default, rename = "reading")]
    pub readings: Vec<Reading>,
    /// The claims, in the order of tables.
    #[serde(default, rename = "claim")]
    pub claims: Vec<Claim>,
    /// The claims of the thesis on tools and octrees; an ablation judges them.
    #[serde(default)]
    pub thesis: Vec<ThesisClaim>,
    /// Text of the claims file.
    #[serde(skip)]
    pub text: String,
}

/// Cases with a special role in comparisons and figures.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Variants that every other variant is compared with; the ranking uses the first.
    pub baselines: Vec<String>,
    /// The scenes that primary rows cover; empty for all scenes.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// The volumes of the paper's first figure, and the volume that it proposes.
    #[serde(default)]
    pub five: Vec<String>,
    /// The boxes that are drawn on the tool.
    #[serde(default)]
    pub drawn: Vec<String>,
}

/// One way to read the paper: the two cases that its words may compare.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// Short name: `R1`.
    pub id: Spanned<String>,
    /// The assumption that the reading makes.
    pub title: String,
    /// The case that the paper proposes or praises.
    pub subject: CaseRef,
    /// The case that it is compared with.
    pub baseline: CaseRef,
}

/// A case by name.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseRef {
    /// Variant id.
    pub variant: String,
    /// `split/axes/leaf`; the variant's default policy when absent.
    #[serde(default)]
    pub policy: Option<String>,
}

/// One sentence of the paper, and the test that judges it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Short name.
    pub id: Spanned<String>,
    /// The sentence, paraphrased.
    pub sentence: String,
    /// Place of the sentence in the paper.
    pub source: String,
    /// Ids of the readings in which the claim is judged.
    #[serde(default)]
    pub readings: Vec<Spanned<String>>,
    /// The reading of the primary row; when absent, all rows of the claim are exploratory.
    pub primary: Option<Spanned<String>>,
    /// The test; absent for a claim that is not judged.
    pub test: Option<Test>,
    /// The reason why the claim is not judged.
    pub not_judged: Option<String>,
}

/// How a claim is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Test {
    /// The quantity that is measured.
    pub kind: TestKind,
    /// For ratios: the claim is supported when the whole interval is below this.
    pub below: Option<f64>,
    /// With `below`: whether the sentence itself says how much, so that a smaller effect refutes it. Without, only a ratio of 1 or more does.
    #[serde(default)]
    pub names_margin: bool,
    /// Replaces `below`: the claim holds when the value, or the whole interval of a ratio, is at most this.
    pub at_most: Option<f64>,
    /// For ratios of queries: the only stratum that the claim covers.
    pub stratum: Option<Stratum>,
    /// For ratios of queries: the workload of the primary row. When absent, times use whole programs and counts use `program`.
    pub workload: Option<String>,
    /// For tightness: the frames in which parts are measured.
    #[serde(default)]
    pub frames: Frames,
    /// For tightness: the only level of the trees that the claim covers; the root has level 0.
    pub level: Option<u32>,
    /// For presence: the effect is present when the value is above this.
    pub above: Option<f64>,
    /// For ratios: whether the subject is claimed to need less or more than the baseline.
    #[serde(default)]
    pub direction: Direction,
    /// For presence and sizes: which of the two cases of the reading is examined.
    pub of: Option<Role>,
    /// For presence: whether the effect is claimed to be present or absent.
    pub expect: Option<Expectation>,
}

/// The quantity that a test measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestKind {
    /// Query time.
    TimeRatio,
    /// Volume overlap tests of a query.
    VolumeTestRatio,
    /// Triangle tests of a query.
    TriangleTestRatio,
    /// Construction time.
    BuildRatio,
    /// Balance of the trees: the smaller child count over the larger.
    Balance,
    /// Volume of the bounding volumes over the volume of the convex hulls.
    Tightness,
    /// Memory of the trees.
    BytesRatio,
    /// Arithmetic operations of a separating-axis test.
    AxisOperations,
    /// Share of the separating-axis tests in which only a cross product of two edges separates the boxes.
    EdgeExits,
    /// Contacts missed by the volume.
    Misses,
    /// Corners of triangles that lie outside their volume.
    Overhang,
    /// Displacement of the root box toward the finely meshed side.
    Drift,
    /// Empty gap opposite the overhang of the root box.
    Gap,
}

impl TestKind {
    /// Whether the test asks whether an effect is present in one case.
    pub const fn is_presence(self) -> bool {
        matches!(self, Self::Misses | Self::Overhang | Self::Drift | Self::Gap)
    }

    /// Whether the test asks how large a quantity of one case is.
    pub const fn is_size(self) -> bool {
        matches!(self, Self::AxisOperations | Self::EdgeExits)
    }

    /// Whether the test is about queries, which have a stratum.
    pub const fn is_about_queries(self) -> bool {
        matches!(self, Self::TimeRatio | Self::VolumeTestRatio | Self::TriangleTestRatio)
    }
}

/// Frames of the parts in which a quantity is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frames {
    /// The frame that the part was drawn in.
    #[default]
    Own,
    /// Frames turned at random, for volumes that depend on the frame.
    Random,
}

/// Which way a ratio is claimed to go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// The subject needs less.
    #[default]
    Less,
    /// The subject needs more.
    Greater,
}

/// One of the two cases of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// The case that is proposed.
    Subject,
    /// The case that it is compared with.
    Baseline,
}

/// Whether a claim expects an effect to be present.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expectation {
    /// The effect is present.
    Present,
    /// The effect is absent.
    Absent,
}

impl ClaimSet {
    /// The committed claims on the paper.
    ///
    /// # Panics
    /// Never in a build whose tests pass: they parse the committed file.
    pub fn standard() -> Self {
        Self::parse(DEFAULT_TEXT, FILE).expect("the committed claims are well formed")
    }

    /// A set without claims, for comparing variants with `baseline`; `source` names what is compared.
    ///
    /// # Panics
    /// Never: the text is generated here and always parses.
    pub fn none(source: &str, baseline: &str) -> Self {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let (source, baseline) = (quoted(source), quoted(baseline));
        let text = format!("schema = {SCHEMA}\nsource = {source}\n\n[comparison]\nbaselines = [{baseline}]\n");
        Self::parse(&text, FILE).expect("the text is that of a claims file")
    }

    /// The claims that the run in `folder` was judged by; the committed ones of a run that was not judged yet.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn of_run(folder: &Path) -> Result<Self, ClaimsError> {
        let judged_by = folder.join(FILE);
        if judged_by.exists() { Self::read(&judged_by) } else { Ok(Self::standard()) }
    }

    /// Whether the set holds no claims.
    pub const fn is_empty(&self) -> bool {
        self.claims.is_empty()
    }

    /// Reads a claims file.
    ///
    /// # Errors
    /// When the file cannot be read, or is not a claims file; the error gives line and column.
    pub fn read(path: &Path) -> Result<Self, ClaimsError> {
        let file = path.display().to_string();
        Self::parse(&read_text(path)?, &file)
    }

    /// Parses the text of a claims file; `file` is its name in messages.
    ///
    /// # Errors
    /// When the text is not a claims file; the error gives line and column.
    pub fn parse(text: &str, file: &str) -> Result<Self, ClaimsError> {
        let bad = |span: Range<usize>, problem: String| bad(text, file, &span, problem);
        let mut set: Self =
            toml::from_str(text).map_err(|error| bad(error.span().unwrap_or(0..0), error.message().to_owned()))?;
        if *set.schema.get_ref() != SCHEMA {
            return Err(bad(set.schema.span(), format!("this program reads schema {SCHEMA}")));
        }
        for (i, reading) in set.readings.iter().enumerate() {
            if set.readings[..i].iter().any(|earlier| earlier.id.get_ref() == reading.id.get_ref()) {
                return Err(bad(reading.id.span(), format!("reading `{}` is there twice", reading.id.get_ref())));
            }
        }
        for (i, claim) in set.claims.iter().enumerate() {
            if set.claims[..i].iter().any(|earlier| earlier.id() == claim.id()) {
                return Err(bad(claim.id.span(), format!("claim `{}` is there twice", claim.id())));
            }
            set.check(claim).map_err(|(span, problem)| bad(span, problem))?;
        }
        if set.comparison.baselines.is_empty() {
            return Err(bad(0..0, "`comparison.baselines` names no variant".to_owned()));
        }
        text.clone_into(&mut set.text);
        Ok(set)
    }

    fn check(&self, claim: &Claim) -> Result<(), (Range<usize>, String)> {
        for reading in &claim.readings {
            if self.reading(reading.get_ref()).is_none() {
                return Err((reading.span(), format!("there is no reading `{}`", reading.get_ref())));
            }
        }
        if let Some(primary) = &claim.primary
            && !claim.readings.iter().any(|reading| reading.get_ref() == primary.get_ref())
        {
            return Err((primary.span(), format!("`{}` is none of the claim's readings", primary.get_ref())));
        }
        let problem = match (&claim.test, &claim.not_judged) {
            (Some(_), Some(_)) => Some("has both a `test` and a reason why it is `not_judged`"),
            (None, None) => Some("has neither a `test` nor a reason why it is `not_judged`"),
            (None, Some(_)) if !claim.readings.is_empty() => Some("has readings but is not judged"),
            (Some(_), None) if claim.readings.is_empty() => Some("has no readings"),
            (Some(test), None) => test.problem(),
            (None, Some(_)) => None,
        };
        problem.map_or(Ok(()), |problem| Err((claim.id.span(), format!("claim `{}` {problem}", claim.id()))))
    }

    /// Finds a reading by its id.
    pub fn reading(&self, id: &str) -> Option<&Reading> {
        self.readings.iter().find(|reading| reading.id.get_ref() == id)
    }

    /// Finds a claim by its id.
    pub fn claim(&self, id: &str) -> Option<&Claim> {
        self.claims.iter().find(|claim| claim.id() == id)
    }
}

impl CaseRef {
    /// A variant under its default policy.
    pub fn default_of(variant: &str) -> Self {
        Self { variant: variant.to_owned(), policy: None }
    }
}

impl Claim {
    /// Short name.
    pub fn id(&self) -> &str {
        self.id.get_ref()
    }
}

impl Test {
    fn problem(&self) -> Option<&'static str> {
        let named = self.of.is_some();
        let asks = self.expect.is_some() || self.above.is_some();
        if self.stratum.is_some() && !self.kind.is_about_queries() {
            return Some("is not about queries: `stratum` has no meaning in it");
        }
        if self.workload.is_some() && !self.kind.is_about_queries() {
            return Some("is not about queries: `workload` has no meaning in it");
        }
        if self.frames != Frames::default() && self.kind != TestKind::Tightness {
            return Some("is not about tightness: `frames` has no meaning in it");
        }
        if self.level.is_some() && self.kind != TestKind::Tightness {
            return Some("is not about the levels of trees: `level` has no meaning in it");
        }
        if self.names_margin && self.below.is_none() {
            return Some("has no `below`: `names_margin` has no meaning in it");
        }
        if self.kind.is_presence() {
            return match (self.below, self.at_most) {
                (None, None) if named && self.expect.is_some() && self.above.is_some() => None,
                (None, None) => Some("needs `of`, `expect` and `above`"),
                _ => Some("asks for a presence: `below` and `at_most` have no meaning in it"),
            };
        }
        if self.kind.is_size() {
            return match (self.below, self.at_most) {
                (None, Some(most)) if most > 0.0 && named && !asks => None,
                _ => Some("is about one case: it needs `of` and a positive `at_most`, and nothing else"),
            };
        }
        match (self.below, self.at_most) {
            (None, None) => Some("needs `below` or `at_most`"),
            (Some(_), Some(_)) => Some("has both `below` and `at_most`"),
            (Some(below), None) if !(below > 0.0 && below <= 1.0) => Some("needs `below` in (0, 1]"),
            (None, Some(most)) if most < 1.0 || most.is_nan() => Some("needs `at_most` of at least 1"),
            _ if named || asks => Some("compares two cases: `of`, `expect` and `above` have no meaning in it"),
            _ => None,
        }
    }
}

fn bad(text: &str, file: &str, span: &Range<usize>, problem: String) -> ClaimsError {
    let start = span.start.min(text.len());
    let before = &text[..start];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    ClaimsError::Bad {
        file: file.to_owned(),
        line: before.matches('\n').count() + 1,
        column: text[line_start..start].chars().count() + 1,
        problem,
        text: text[start..].lines().next().unwrap_or_default().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_claims_parse_and_cover_every_reading() {
        let set = ClaimSet::standard();
        assert!(set.claims.len() >= 15);
        for reading in &set.readings {
            let used = |claim: &Claim| claim.readings.iter().any(|id| id.get_ref() == reading.id.get_ref());
            assert!(set.claims.iter().any(used), "{}", reading.id.get_ref());
        }
    }

    #[test]
    fn mistakes_are_shown_where_they_are() {
        let at = |from: &str, to: &str| {
            assert!(DEFAULT_TEXT.contains(from), "{from}");
            let text = DEFAULT_TEXT.replacen(from, to, 1);
            let line = DEFAULT_TEXT.lines().position(|line| line.contains(from)).unwrap() + 1;
            let message = ClaimsError::to_string(&ClaimSet::parse(&text, "c.toml").unwrap_err());
            assert!(message.starts_with(&format!("c.toml:{line}:")), "{message}");
            message
        };
        assert!(at("schema = 1", "schema = 9").contains("schema 1"));
        assert!(at("readings = [\"R1\",", "readings = [\"R9\",").contains("no reading `R9`"));
        assert!(at("kind = \"time-ratio\"", "kind = \"time-rate\"").contains("time-rate"));
        assert!(at("id = \"R2\"", "id = \"R1\"").contains("twice"));
        assert!(at("below = 0.75, ", "beneath = 0.75, ").contains("beneath"));
        assert!(at("policy = \"area-mean/own/1\" }", "policy = 5 }").contains("5"));
        assert!(ClaimSet::parse("", "c.toml").is_err());
        for (from, to, claim, word) in [
            ("at_most = 200 }", "below = 0.9 }", "few-operations", "at_most"),
            ("kind = \"tightness\", level = 0", "kind = \"balance\", level = 0", "dito-tight", "level"),
            ("at_most = 1.1", "at_most = 0.9", "dito-tight", "at least 1"),
            ("at_most = 1.1", "at_most = 1.1, names_margin = true", "dito-tight", "names_margin"),
            ("kind = \"bytes-ratio\"", "kind = \"bytes-ratio\", stratum = \"far\"", "spatial-storage", "stratum"),
        ] {
            assert!(DEFAULT_TEXT.contains(from), "{from}");
            let message = ClaimSet::parse(&DEFAULT_TEXT.replacen(from, to, 1), "c").unwrap_err().to_string();
            assert!(message.contains(claim) && message.contains(word), "{message}");
        }
        let message = ClaimSet::parse(&DEFAULT_TEXT.replacen("below = 0.95", "above = 0.95", 1), "c").unwrap_err();
        assert!(message.to_string().contains("claim `faster` needs `below`"), "{message}");
    }
}
