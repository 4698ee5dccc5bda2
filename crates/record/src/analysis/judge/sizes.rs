//! Claims about the arithmetic of the separating-axis test. It is counted without sampling, so there is no interval.

use super::{ALL, CaseKey, ExitRow, Finding, Judged, Stratum, Test, Verdict};

/// The first axis, in the numbering of the records, that is a cross product of two edges.
const FIRST_EDGE_AXIS: u8 = 7;

impl Judged<'_> {
    /// Mean arithmetic operations of a test.
    pub(super) fn axis_operations(&self, case: &CaseKey, test: &Test) -> Finding {
        let most = self.exits(case).filter(|row| row.tests > 0).map(|row| row.operations).max();
        let mut finding = self.mean_of_exits(case, test, |row| row.operations as f64);
        finding.note.extend(most.map(|most| format!("no test takes more than {most}")));
        finding
    }

    /// Share of the tests in which only a cross product of edges separates the boxes. A test of the six face normals alone reports overlap
    /// in these.
    pub(super) fn edge_exits(&self, case: &CaseKey, test: &Test) -> Finding {
        let is_edge = |row: &ExitRow| f64::from(u8::from(row.axis >= FIRST_EDGE_AXIS));
        let mut finding = self.mean_of_exits(case, test, is_edge);
        let (edge, ended) = self
            .exits(case)
            .filter(|row| row.axis > 0)
            .fold((0.0, 0.0), |(edge, ended), row| (edge + is_edge(row) * row.tests as f64, ended + row.tests as f64));
        if ended > 0.0 {
            finding.note.push(format!("{:.1} % of the tests that some axis ends", 100.0 * edge / ended));
        }
        finding
    }

    fn exits<'b>(&'b self, case: &'b CaseKey) -> impl Iterator<Item = &'b ExitRow> {
        self.evidence.exits.iter().filter(move |row| row.scene == self.scene_name && row.case() == *case)
    }

    /// The mean of `value` over all tests, compared with the claim's threshold, with its range over the strata.
    fn mean_of_exits(&self, case: &CaseKey, test: &Test, value: impl Fn(&ExitRow) -> f64) -> Finding {
        let mean = |wanted: Option<Stratum>| {
            let rows = self.exits(case).filter(|row| wanted.is_none_or(|stratum| row.stratum == stratum));
            let (sum, tests) =
                rows.fold((0.0, 0.0), |(s, n), row| (s + value(row) * row.tests as f64, n + row.tests as f64));
            (tests > 0.0).then_some(sum / tests)
        };
        let Some(all) = mean(None) else {
            return Finding::not_measured("no ends of separating-axis tests of this case in this run");
        };
        let by_stratum = Stratum::ALL.into_iter().filter_map(|stratum| Some((stratum, mean(Some(stratum))?)));
        let by_stratum: Vec<String> = by_stratum.map(|(stratum, mean)| format!("{} {mean:.3}", stratum.id())).collect();
        let holds = test.at_most.is_some_and(|most| all <= most);
        let verdict = if holds { Verdict::Supported } else { Verdict::Refuted };
        Finding { stratum: ALL.to_owned(), ..Finding::of_trees(verdict, Some(all), vec![by_stratum.join(", ")]) }
    }
}
