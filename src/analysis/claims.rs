//! The claims: what was said, which cases it is about, and what it takes to call it reproduced. Data, not code: variants
//! are named in `paper-repro/claims.toml` and nowhere here.

use super::ablation::ThesisClaim;
use crate::record::{RecordError, Stratum, read_text};
use serde::Deserialize;
use std::ops::Range;
use std::path::Path;
use thiserror::Error;
use toml::Spanned;

/// Version of the claims file this program reads.
const SCHEMA: u32 = 1;

/// The claims on the paper, as committed.
pub const DEFAULT_TEXT: &str = include_str!("../../paper-repro/claims.toml");

/// The committed claims' name in messages and in a run's folder.
pub const FILE: &str = "claims.toml";

/// Why a claims file cannot be used.
#[derive(Debug, Error)]
pub enum ClaimsError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] RecordError),
    /// Something in it is wrong.
    #[error("{file}:{line}:{column}: {problem}, at `{text}`")]
    Bad {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
        /// The offending line's text from there on.
        text: String,
    },
}

/// All claims, with the readings and the comparison they are judged in.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimSet {
    schema: Spanned<u32>,
    /// Where the claims come from.
    pub source: String,
    /// What every variant is compared with.
    pub comparison: Comparison,
    /// The readings.
    #[serde(default, rename = "reading")]
    pub readings: Vec<Reading>,
    /// The claims, in the order of tables.
    #[serde(default, rename = "claim")]
    pub claims: Vec<Claim>,
    /// The claims of the thesis on tools and octrees, which an ablation judges.
    #[serde(default)]
    pub thesis: Vec<ThesisClaim>,
    /// The text it was read from.
    #[serde(skip)]
    pub text: String,
}

/// Cases with a role of their own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Variants that every other one is compared with; the ranking uses the first.
    pub baselines: Vec<String>,
    /// The scenes that primary rows are about; empty for all.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// The volumes of the paper's first figure and its proposal.
    #[serde(default)]
    pub five: Vec<String>,
    /// The boxes drawn on the tool.
    #[serde(default)]
    pub drawn: Vec<String>,
}

/// One way to read the paper: which two cases it compares.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// Short name: `R1`.
    pub id: Spanned<String>,
    /// What it assumes.
    pub title: String,
    /// What is proposed or praised.
    pub subject: CaseRef,
    /// What it is held against.
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

/// One sentence, and how it is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Short name.
    pub id: Spanned<String>,
    /// The sentence, paraphrased.
    pub sentence: String,
    /// Where it stands.
    pub source: String,
    /// Ids of the readings it is judged in.
    #[serde(default)]
    pub readings: Vec<Spanned<String>>,
    /// The reading of its primary row; without it all its rows are exploratory.
    pub primary: Option<Spanned<String>>,
    /// How it is judged.
    pub test: Option<Test>,
    /// Why it is not.
    pub not_judged: Option<String>,
}

/// How a claim is judged.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Test {
    /// What is measured.
    pub kind: TestKind,
    /// For ratios: the claimed effect is there when the whole interval is below this.
    pub below: Option<f64>,
    /// Instead of `below`: the claim holds when the value, or the whole interval of a ratio, is not above this.
    pub at_most: Option<f64>,
    /// For ratios of queries: the only stratum that the claim is about.
    pub stratum: Option<Stratum>,
    /// For ratios of queries: the workload of the primary row; without it whole programs for times, and `program` for counts.
    pub workload: Option<String>,
    /// For tightness: the frames of the parts.
    #[serde(default)]
    pub frames: Frames,
    /// For tightness: the only level of the trees that the claim is about; the roots are 0.
    pub level: Option<u32>,
    /// For presence: what is larger than this is there.
    pub above: Option<f64>,
    /// For ratios: whether the subject is claimed to need less or more.
    #[serde(default)]
    pub direction: Direction,
    /// For presence and sizes: which of the reading's two cases is examined.
    pub of: Option<Role>,
    /// For presence: whether the claim says that it is there.
    pub expect: Option<Expectation>,
}

/// What is measured.
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
    /// Smaller over larger child count.
    Balance,
    /// Volume over hull volume.
    Tightness,
    /// Memory of the trees.
    BytesRatio,
    /// Arithmetic operations of a separating-axis test.
    AxisOperations,
    /// Share of the separating-axis tests that only a product of two edges ends.
    EdgeExits,
    /// Contacts missed by the volume.
    Misses,
    /// Corners outside their volume.
    Overhang,
    /// Displacement of the root box toward the dense side.
    Drift,
    /// Empty gap opposite the overhang of the root box.
    Gap,
}

impl TestKind {
    /// Whether the kind compares two cases by a ratio; otherwise it is about one of them.
    #[must_use]
    pub const fn is_ratio(self) -> bool {
        !self.is_presence() && !self.is_size()
    }

    /// Whether the kind asks for the presence of something in one case.
    #[must_use]
    pub const fn is_presence(self) -> bool {
        matches!(self, Self::Misses | Self::Overhang | Self::Drift | Self::Gap)
    }

    /// Whether the kind asks how large something of one case is.
    #[must_use]
    pub const fn is_size(self) -> bool {
        matches!(self, Self::AxisOperations | Self::EdgeExits)
    }

    /// Whether the kind is about queries, which have a stratum.
    #[must_use]
    pub const fn is_about_queries(self) -> bool {
        matches!(self, Self::TimeRatio | Self::VolumeTestRatio | Self::TriangleTestRatio)
    }
}

/// In which frames of the parts something is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frames {
    /// The frame that the part was drawn in.
    #[default]
    Own,
    /// Frames turned at random: for volumes whose size depends on the frame.
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

/// One of a reading's two cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// What is proposed.
    Subject,
    /// What it is held against.
    Baseline,
}

/// What a claim says of a presence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expectation {
    /// It is there.
    Present,
    /// It is not.
    Absent,
}

impl ClaimSet {
    /// The committed claims on the paper.
    ///
    /// # Panics
    /// Never in a build whose tests pass: they parse the committed file.
    #[must_use]
    pub fn standard() -> Self {
        Self::parse(DEFAULT_TEXT, FILE).expect("the committed claims are well formed")
    }

    /// No claims at all: a comparison of variants with `baseline`, on something that `source` names.
    ///
    /// # Panics
    /// Never: the text is made here.
    #[must_use]
    pub fn none(source: &str, baseline: &str) -> Self {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let (source, baseline) = (quoted(source), quoted(baseline));
        let text = format!("schema = {SCHEMA}\nsource = {source}\n\n[comparison]\nbaselines = [{baseline}]\n");
        Self::parse(&text, FILE).expect("the text is that of a claims file")
    }

    /// Whether anything is claimed.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.claims.is_empty()
    }

    /// Reads a claims file.
    ///
    /// # Errors
    /// When it cannot be read, or is not a claims file: with line and column.
    pub fn read(path: &Path) -> Result<Self, ClaimsError> {
        let file = path.display().to_string();
        Self::parse(&read_text(path)?, &file)
    }

    /// Parses the text of a claims file; `file` is its name in messages.
    ///
    /// # Errors
    /// When it is not a claims file: with line and column.
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

    /// The reading of that id.
    #[must_use]
    pub fn reading(&self, id: &str) -> Option<&Reading> {
        self.readings.iter().find(|reading| reading.id.get_ref() == id)
    }

    /// The claim of that id.
    #[must_use]
    pub fn claim(&self, id: &str) -> Option<&Claim> {
        self.claims.iter().find(|claim| claim.id() == id)
    }
}

impl Claim {
    /// Short name.
    #[must_use]
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
        assert!(at("below = 0.75 }", "beneath = 0.75 }").contains("beneath"));
        assert!(at("policy = \"area-mean/own/1\" }", "policy = 5 }").contains("5"));
        assert!(ClaimSet::parse("", "c.toml").is_err());
        for (from, to, claim, word) in [
            ("at_most = 200 }", "below = 0.9 }", "few-operations", "at_most"),
            ("kind = \"tightness\", level = 0", "kind = \"balance\", level = 0", "dito-tight", "level"),
            ("at_most = 1.1", "at_most = 0.9", "dito-tight", "at least 1"),
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
