//! Right answers before any timing: every pose is asked about once, and the answer compared with exact truth.

use super::{Mode, drive::Comparison};
use crate::record::PeerAnswerRow;

/// How far off a time of first contact may be, as a part of the motion.
const MOST_TIME_OFF: f64 = 1e-3;

/// How right an engine is on the poses of a scene. Grazing poses, where either answer is right, do not count.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// The engine.
    pub engine: String,
    /// Poses that count.
    pub poses: usize,
    /// Poses whose surfaces touch, of which the engine says they do not.
    pub missed: usize,
    /// Poses whose surfaces do not touch, of which the engine says they do.
    pub invented: usize,
    /// Poses with a right verdict and a wrong value: another number of touching pairs, a distance farther off than the tolerance.
    pub wrong_values: usize,
    /// Largest difference of a value from the true one, mm or pairs; `None` in modes that have no values.
    pub largest_error: Option<f64>,
    /// The first pose that is answered wrongly.
    pub first_wrong: Option<Wrong>,
}

/// A wrong answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    /// The pair of parts.
    pub pair: String,
    /// Number of the pose in `poses.npy` of the pair's folder.
    pub pose: u32,
    /// What the engine says: a verdict, 0 or 1, or a value.
    pub said: f64,
    /// What is true.
    pub truth: f64,
}

impl Verdict {
    /// Whether no answer is wrong, and there is one.
    pub const fn is_right(&self) -> bool {
        self.poses > 0 && self.missed == 0 && self.invented == 0 && self.wrong_values == 0
    }
}

/// A verdict on each engine that answered, in the order of `engines`. A distance may be off by `tolerance_mm`.
pub fn verdicts(engines: &[&str], found: &Comparison, mode: Mode, tolerance_mm: f64) -> Vec<Verdict> {
    let of = |engine: &&str| {
        let mut answers = found.answers.iter().filter(|row| row.engine == *engine).peekable();
        answers.peek()?;
        Some(verdict(engine, answers.filter(|row| row.grazing == 0), mode, tolerance_mm))
    };
    engines.iter().filter_map(of).collect()
}

fn verdict<'a>(
    engine: &str,
    answers: impl Iterator<Item = &'a PeerAnswerRow>,
    mode: Mode,
    tolerance_mm: f64,
) -> Verdict {
    let tolerance = match mode {
        Mode::Distance => tolerance_mm,
        Mode::Motion => MOST_TIME_OFF,
        _ => 0.0,
    };
    let mut verdict = Verdict { engine: engine.to_owned(), ..Verdict::default() };
    for row in answers {
        verdict.poses += 1;
        let values = row.value.zip(row.true_value);
        let error = values.map(|(said, truth)| (said - truth).abs());
        // What is not a number is as wrong as can be.
        let error = error.map(|error| if error.is_nan() { f64::INFINITY } else { error });
        verdict.largest_error = verdict.largest_error.into_iter().chain(error).reduce(f64::max);
        let (is_missed, is_invented) = (row.exact > row.touching, row.touching > row.exact);
        let is_off = !is_missed && !is_invented && error.is_some_and(|error| error > tolerance);
        verdict.missed += usize::from(is_missed);
        verdict.invented += usize::from(is_invented);
        verdict.wrong_values += usize::from(is_off);
        if (is_missed || is_invented || is_off) && verdict.first_wrong.is_none() {
            let (said, truth) = values.unwrap_or((f64::from(row.touching), f64::from(row.exact)));
            verdict.first_wrong = Some(Wrong { pair: row.pair.clone(), pose: row.pose, said, truth });
        }
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Stratum;

    fn row(pose: u32, exact: u8, touching: u8, values: Option<(f64, f64)>) -> PeerAnswerRow {
        PeerAnswerRow {
            engine: "one".into(),
            scene: "scene".into(),
            pair: "a:b".into(),
            mode: "distance".into(),
            pose,
            line: 0,
            chunk: 0,
            stratum: Stratum::Far,
            exact,
            grazing: 0,
            touching,
            value: values.map(|v| v.0),
            true_value: values.map(|v| v.1),
            ns: 1,
        }
    }

    fn judged(rows: Vec<PeerAnswerRow>, mode: Mode) -> Verdict {
        let found = Comparison { answers: rows, ..Comparison::default() };
        verdicts(&["none", "one"], &found, mode, 1e-6).remove(0)
    }

    #[test]
    fn a_right_engine_is_right_and_each_kind_of_wrong_answer_is_counted() {
        let right = judged(vec![row(0, 1, 1, None), row(1, 0, 0, None)], Mode::First);
        assert!(right.is_right() && right.poses == 2 && right.largest_error.is_none(), "{right:?}");

        let wrong = judged(vec![row(0, 0, 0, None), row(1, 1, 0, None), row(2, 0, 1, None)], Mode::First);
        assert_eq!((wrong.missed, wrong.invented, wrong.is_right()), (1, 1, false));
        assert_eq!(wrong.first_wrong, Some(Wrong { pair: "a:b".into(), pose: 1, said: 0.0, truth: 1.0 }));

        let near = judged(vec![row(0, 0, 0, Some((5.0 + 1e-9, 5.0)))], Mode::Distance);
        assert!(near.is_right() && near.largest_error.is_some_and(|mm| mm < 1e-8), "{near:?}");
        for said in [5.1, f64::NAN, f64::INFINITY] {
            let off = judged(vec![row(0, 0, 0, Some((said, 5.0)))], Mode::Distance);
            assert_eq!((off.wrong_values, off.is_right()), (1, false), "{said}");
        }
        // A number of pairs is right or wrong.
        assert_eq!(judged(vec![row(0, 1, 1, Some((4.0, 5.0)))], Mode::All).wrong_values, 1);
    }

    #[test]
    fn grazing_poses_do_not_count_and_no_poses_are_not_right() {
        let mut grazing = row(0, 1, 0, None);
        grazing.grazing = 1;
        let verdict = judged(vec![grazing], Mode::First);
        assert_eq!((verdict.poses, verdict.missed, verdict.is_right()), (0, 0, false));
    }
}
