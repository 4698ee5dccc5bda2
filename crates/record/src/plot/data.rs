//! The records that figures use. A missing CSV file gives an empty list, and the figure states what is missing.

use super::marks::Look;
use crate::analysis::AnalysisError;
use crate::analysis::claims::ClaimSet;
use crate::analysis::ratios::Cases;
use crate::record::manifest::VariantEntry;
use crate::record::rows::CaseKey;
use crate::record::{
    BuildRow, CONTROL_WORKLOAD, CostChunkRow, Kind, Manifest, NULL_VARIANT, OutlineRow, PeerRatioRow, ProgramTimeRow,
    RatioRow, SummaryRow, TightnessRow, VerificationRow, read_rows_if_there,
};
use std::collections::BTreeSet;
use std::path::Path;

/// A variant in the form that figures need.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Id.
    pub id: String,
    /// Text in legends; it states when the variant is unsafe.
    pub label: String,
    /// Colour and marker.
    pub look: Look,
    /// Whether the variant is safe: it misses no contact by construction.
    pub safe: bool,
    /// Kind of the method, such as volume, engine or peer.
    pub kind: Kind,
}

/// All records of a run that figures use.
#[derive(Debug)]
pub struct Data {
    /// The claims by which the run was judged; they name the cases with a role.
    pub claims: ClaimSet,
    /// Variants in the order of the manifest.
    pub variants: Vec<Entry>,
    /// Scene names in the order of the manifest.
    pub scenes: Vec<String>,
    /// Default policies.
    pub cases: Cases,
    /// `summary.csv`.
    pub summary: Vec<SummaryRow>,
    /// `ratios.csv`.
    pub ratios: Vec<RatioRow>,
    /// `program_times.csv`.
    pub program_times: Vec<ProgramTimeRow>,
    /// `verification.csv`.
    pub verification: Vec<VerificationRow>,
    /// `tightness.csv`.
    pub tightness: Vec<TightnessRow>,
    /// `outlines.csv`.
    pub outlines: Vec<OutlineRow>,
    /// `builds.csv`.
    pub builds: Vec<BuildRow>,
    /// `cost_chunks.csv`.
    pub cost_chunks: Vec<CostChunkRow>,
    /// `peer-ratios.csv`.
    pub peer_ratios: Vec<PeerRatioRow>,
}

impl Data {
    /// Reads a run's folder.
    ///
    /// # Errors
    /// When the manifest is missing or anything is malformed.
    pub fn read(folder: &Path) -> Result<Self, AnalysisError> {
        let manifest = Manifest::read(folder)?;
        Ok(Self {
            variants: entries(&manifest),
            scenes: manifest.scenes.iter().map(|scene| scene.name.clone()).collect(),
            cases: Cases::new(&manifest),
            claims: ClaimSet::of_run(folder)?,
            summary: read_rows_if_there(folder)?,
            ratios: read_rows_if_there(folder)?,
            program_times: read_rows_if_there(folder)?,
            verification: read_rows_if_there(folder)?,
            tightness: read_rows_if_there(folder)?,
            outlines: read_rows_if_there(folder)?,
            builds: read_rows_if_there(folder)?,
            cost_chunks: read_rows_if_there(folder)?,
            peer_ratios: read_rows_if_there(folder)?,
        })
    }

    /// Reason for a missing figure of derived rows: that the analysis has not run; where it has, `lacking`.
    pub fn reason(&self, lacking: &'static str) -> &'static str {
        if self.summary.is_empty() { "summary.csv holds no rows; run the analysis first" } else { lacking }
    }

    /// The variant of that id.
    pub fn variant(&self, id: &str) -> Option<&Entry> {
        self.variants.iter().find(|entry| entry.id == id)
    }

    /// The time of a program of a scene for a variant under its default policy.
    pub fn program_time_of(&self, scene: &str, program: &str, variant: &str) -> Option<&ProgramTimeRow> {
        let mut rows = self.program_times.iter().filter(|row| row.scene == scene && row.program == program);
        rows.find(|row| row.variant == variant && self.is_default(&row.case()))
    }

    /// Each scene with each of its workloads that has a summary, in order; the control's poses are left out.
    pub fn workloads(&self) -> Vec<(String, String)> {
        let of = |scene: &String| {
            let rows = self.summary.iter().filter(|row| row.scene == *scene && row.workload != CONTROL_WORKLOAD);
            rows.map(|row| (scene.clone(), row.workload.clone())).collect::<BTreeSet<_>>()
        };
        self.scenes.iter().flat_map(of).collect()
    }

    /// Whether a row's case is its variant under the default policy.
    pub fn is_default(&self, case: &CaseKey) -> bool {
        self.cases.is_default(&case.variant, &case.policy())
    }

    /// The summary of a variant under its default policy in a workload.
    pub fn summary_of(&self, scene: &str, workload: &str, stratum: &str, variant: &str) -> Option<&SummaryRow> {
        let of_scene = self.summary.iter().filter(|row| row.scene == scene && row.workload == workload);
        let mut rows = of_scene.filter(|row| row.stratum == stratum);
        rows.find(|row| row.variant == variant && self.is_default(&row.case()))
    }
}

/// The variants of a manifest in the form that figures need, in its order.
pub fn entries(manifest: &Manifest) -> Vec<Entry> {
    let variants = manifest.variants.iter().filter(|v| v.id != NULL_VARIANT).enumerate();
    let entry = |(i, v): (usize, &VariantEntry)| {
        let safe = v.safe || !v.kind.is_ours();
        Entry {
            id: v.id.clone(),
            label: if safe { v.label.clone() } else { format!("{} (unsafe)", v.label) },
            look: Look::nth(i).of_promise(safe),
            safe,
            kind: v.kind,
        }
    };
    variants.map(entry).collect()
}
