//! Words that figures and reports share: lists of names, and the quantity by which scenes are ranked.

use super::ranked_by;
use crate::record::{PROGRAM_TIME, RatioRow};

/// Joins names as `a`, `a and b`, or `a, b and c`.
pub fn listed<S: AsRef<str>>(names: &[S]) -> String {
    match names {
        [] => String::new(),
        [only] => only.as_ref().to_owned(),
        [first @ .., last] => {
            format!("{} and {}", first.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "), last.as_ref())
        }
    }
}

/// The text with a capital first letter.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

/// The quantity by which scenes are ranked: `programs` for the time of programs, or the query time in a workload, with the scenes where
/// these differ.
pub fn quantity<'a>(ratios: &'a [RatioRow], scenes: impl Iterator<Item = &'a str>, programs: &str) -> String {
    let timed: Vec<(&str, &str)> = scenes.filter_map(|scene| Some((scene, ranked_by(ratios, scene)?))).collect();
    quantity_of(&timed, programs)
}

/// The quantity in scenes, each with its workload.
pub fn quantity_of(timed: &[(&str, &str)], programs: &str) -> String {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for &(scene, workload) in timed {
        match groups.iter_mut().find(|(known, _)| *known == workload) {
            Some((_, scenes)) => scenes.push(scene),
            None => groups.push((workload, vec![scene])),
        }
    }
    let named = |workload: &str| match workload {
        PROGRAM_TIME => programs.to_owned(),
        _ => format!("query time in `{workload}`"),
    };
    match &groups[..] {
        [(workload, _)] => named(workload),
        groups => {
            let each = groups.iter().map(|(workload, scenes)| format!("{} on {}", named(workload), listed(scenes)));
            listed(&each.collect::<Vec<_>>())
        }
    }
}
