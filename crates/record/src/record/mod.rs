//! What a run leaves behind: one row type per CSV, the manifest, and atomic writing. The only thing that the analysis, the
//! plots and the report know.
//!
//! Tidy: one row per observation, units in column names, times as integer nanoseconds. Derived values are never stored
//! beside what they derive from.

pub mod agreement;
pub mod audit;
pub mod command;
pub mod cost;
pub mod file;
pub mod lock;
pub mod manifest;
pub mod peers;
pub mod repeats;
pub mod rows;
pub mod study;
pub mod sweep;
pub mod table;
pub mod vocabulary;

#[cfg(test)]
pub(crate) mod synthetic;

pub use agreement::{AgreementRow, DisagreementRow, RoundRow};
pub use audit::{AuditCellRow, AuditEffectRow, AuditShareRow};
pub use cost::{CASE_COSTS, CostChunkRow, DEADLINES, REPAY};
pub use file::{
    Head, RecordError, for_each_row, has_rows, merge_rows, read_json, read_rows, read_rows_if_there, read_text,
    write_bytes, write_json, write_lines, write_rows, write_rows_compressed, write_text,
};
pub use lock::FolderLock;
pub use manifest::Manifest;
pub use peers::{PeerAnswerRow, PeerBuildRow, PeerRatioRow, PeerRow, PeerTimingRow};
pub use repeats::{Cache, SingleRow, VarianceRow};
pub use rows::{
    AnswerRow, BuildRow, CaseRow, ClaimRow, ExitRow, LineRow, MissRow, OutlineRow, PoseRow, ProgramTimeRow, RatioRow,
    Row, SummaryRow, TightnessRow, TimingRow, TreeRow, VerificationRow,
};
pub use study::{CountRow, FactorRow};
pub use sweep::{SweepGrowthRow, SweepSummaryRow};
pub use table::Table;
pub use vocabulary::{
    ALL_VARIANTS, Band, CONTROL_WORKLOAD, Kind, MESH_OUTLINE, NULL_VARIANT, PROGRAM_TIME, PROGRAM_TIME_COLD, RECORDED,
    Stratum,
};
