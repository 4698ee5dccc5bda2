//! The safe variants by speed, as a person reads them.

use super::style;
use crate::analysis::Outcome;
use comfy_table::Table;

/// A line for each: its query time as a multiple of the first baseline's.
pub fn table(outcome: &Outcome) -> Table {
    let mut table = style::table(&["VARIANT", "NAME", "KIND", "TIME RATIO"]);
    for entry in &outcome.ranking {
        let kind = format!("{:?}", entry.kind).to_lowercase();
        table.add_row([entry.variant.clone(), entry.label.clone(), kind, format!("{:.2}", entry.ratio)]);
    }
    table
}
