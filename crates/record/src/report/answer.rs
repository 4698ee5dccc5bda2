//! The answer of a run in a few sentences: whether the proposal saves time, what the boxes as printed miss, and which volume is fastest on
//! which scene.
//!
//! README, terminal, `report.md` and the page all show these sentences. They are derived from the records alone, for any run: of one scene,
//! of a user's scenes, with noisy timings, and without some of the variants.

use super::Contents;
use super::tables::{bound, interval, number};
use crate::analysis::claims::{CaseRef, Claim, ClaimSet, Reading, Role, TestKind};
use crate::analysis::judge::CLUSTERS_MIN;
use crate::analysis::misses::Tally;
use crate::analysis::ratios::Cases;
use crate::analysis::words::{self, capital, listed, quantity_of};
use crate::analysis::{
    ALL, Ranked, counted, distinct, grouped, is_noisy, is_query_time, ranked_by, ranked_in, ranking_ratio,
};
use crate::record::rows::CaseKey;
use crate::record::{Kind, NULL_VARIANT, PROGRAM_TIME, RECORDED, RatioRow, SummaryRow};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A question and its answer, as plain text of a few short sentences.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Statement {
    /// The question, with its question mark.
    pub question: String,
    /// The answer.
    pub answer: String,
}

/// The statements of a run, the most important one first.
pub fn answer(contents: &Contents) -> Vec<Statement> {
    let mut fastest = fastest(contents);
    fastest.answer += &untimed(contents);
    [proposal(contents), Some(misses(contents)), Some(fastest)].into_iter().flatten().collect()
}

/// The reading of the first claim about speed: the proposed case, and the case with which it is compared.
pub fn proposed(claims: &ClaimSet) -> Option<&Reading> {
    primary_of(claims, TestKind::TimeRatio).next().map(|(_, reading)| reading)
}

/// The workload that the first claim about speed names.
fn proposed_workload(claims: &ClaimSet) -> Option<&str> {
    primary_of(claims, TestKind::TimeRatio).next()?.0.test.as_ref()?.workload.as_deref()
}

/// The claims of a kind that have a primary reading, each with that reading.
fn primary_of(claims: &ClaimSet, kind: TestKind) -> impl Iterator<Item = (&Claim, &Reading)> {
    let wanted = claims.claims.iter().filter(move |claim| claim.test.as_ref().is_some_and(|test| test.kind == kind));
    wanted.filter_map(|claim| Some((claim, claims.reading(claim.primary.as_ref()?.get_ref())?)))
}

/// The result of a comparison in one scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Speed {
    Faster,
    Slower,
    Same,
    Undecided,
}

impl Speed {
    const ALL: [Self; 4] = [Self::Faster, Self::Slower, Self::Same, Self::Undecided];

    fn of(row: &RatioRow) -> Self {
        match row.effect.as_str() {
            _ if row.noisy == 1 => Self::Undecided,
            "less" => Self::Faster,
            "more" => Self::Slower,
            "same" => Self::Same,
            _ => Self::Undecided,
        }
    }

    const fn word(self) -> &'static str {
        match self {
            Self::Faster => "faster",
            Self::Slower => "slower",
            Self::Same => "the same within 5 %",
            Self::Undecided => "undecided",
        }
    }
}

/// The effect of a ratio of times in words.
pub(super) fn effect_in_words(row: &RatioRow) -> String {
    let word = Speed::of(row).word();
    if row.noisy == 1 { format!("{word} (noisy)") } else { word.to_owned() }
}

/// Whether the proposal takes less time; `None` for a run that judges no claim about speed.
fn proposal(contents: &Contents) -> Option<Statement> {
    let reading = proposed(&contents.claims)?;
    let [subject, baseline] = [&reading.subject, &reading.baseline].map(|case| contents.label(&case.variant));
    let workload = proposed_workload(&contents.claims);
    let rows = paired_in(contents, &reading.subject, &reading.baseline, workload);
    let question = format!("Is the {subject} faster than the {baseline}?");
    if rows.is_empty() {
        let answer = "This run cannot say: it did not time both of them on the same poses.".to_owned();
        return Some(Statement { question, answer });
    }
    let scenes = |outcome: Speed| -> Vec<&str> {
        rows.iter().filter(|row| Speed::of(row) == outcome).map(|row| row.scene.as_str()).collect()
    };
    let groups = Speed::ALL.map(|outcome| (outcome, scenes(outcome))).into_iter().filter(|(_, of)| !of.is_empty());
    let groups: Vec<(Speed, Vec<&str>)> = groups.collect();
    let list = |groups: &[(Speed, Vec<&str>)]| {
        let each = groups.iter().map(|(outcome, scenes)| format!("{} on {}", outcome.word(), listed(scenes)));
        each.collect::<Vec<_>>().join("; ")
    };
    let verdict = match (&groups[..], scenes(Speed::Faster).len(), rows.len()) {
        ([(Speed::Faster, _)], _, 1) => format!("Yes, on {}.", rows[0].scene),
        ([(Speed::Faster, _)], _, n) => format!("Yes, in all {n} scenes."),
        ([(Speed::Undecided, _)], _, 1) => format!("Undecided on {}.", rows[0].scene),
        ([(Speed::Undecided, _)], _, n) => format!("Undecided in all {n} scenes."),
        ([(outcome, _)], _, 1) => format!("No: {} on {}.", outcome.word(), rows[0].scene),
        ([(outcome, _)], _, n) => format!("No: {} in all {n} scenes.", outcome.word()),
        (groups, 0, n) if scenes(Speed::Undecided).is_empty() => {
            format!("No, in none of {n} scenes: {}.", list(groups))
        }
        (groups, 0, n) => format!("Not shown in any of {n} scenes: {}.", list(groups)),
        (groups, k, n) => format!("In {k} of {n} scenes: {}.", list(groups)),
    };
    let values = rows.iter().map(|row| format!("{} on {}", ratio(row), row.scene)).collect::<Vec<_>>();
    let what = if rows.iter().any(|row| row.interval().is_some()) { " (95 % intervals)" } else { "" };
    let timed: Vec<(&str, &str)> = rows.iter().map(|row| (row.scene.as_str(), row.workload.as_str())).collect();
    let quantity = capital(&quantity_of(&timed, "program time"));
    let mut answer = format!("{verdict} {quantity} relative to the {baseline}: {}{what}.", values.join(", "));
    let noisy: Vec<&str> = rows.iter().filter(|row| row.noisy == 1).map(|row| row.scene.as_str()).collect();
    if !noisy.is_empty() {
        answer += &format!(" The timings of {} were too noisy to decide on speed.", listed(&noisy));
    }
    Some(Statement { question, answer })
}

/// The quantity by which the run's scenes are ranked: `programs` for the time of programs, or the query time in a workload, with the scenes
/// where these differ.
pub fn quantity(contents: &Contents, programs: &str) -> String {
    words::quantity(&contents.ratios, contents.manifest.scenes.iter().map(|scene| scene.name.as_str()), programs)
}

/// The ratio of two cases in each scene, by the workload of the ranking.
pub(super) fn paired<'a>(contents: &'a Contents, subject: &CaseRef, baseline: &CaseRef) -> Vec<&'a RatioRow> {
    paired_in(contents, subject, baseline, None)
}

/// The ratio of two cases in each scene, in a given workload or in that of the ranking.
fn paired_in<'a>(
    contents: &'a Contents,
    subject: &CaseRef,
    baseline: &CaseRef,
    workload: Option<&str>,
) -> Vec<&'a RatioRow> {
    let wanted = |row: &&RatioRow| {
        row.stratum == ALL
            && is_query_time(row)
            && is_case(contents, subject, &row.variant, &row.policy)
            && is_case(contents, baseline, &row.baseline, &row.baseline_policy)
    };
    let of = |scene: &str| {
        let workload = workload.or_else(|| ranked_by(&contents.ratios, scene))?;
        contents.ratios.iter().filter(wanted).find(|row| row.scene == scene && row.workload == workload)
    };
    contents.manifest.scenes.iter().filter_map(|scene| of(&scene.name)).collect()
}

/// The ratios of a variant to a baseline, both under their default policies.
pub(super) fn paired_by_default<'a>(contents: &'a Contents, variant: &str, baseline: &str) -> Vec<&'a RatioRow> {
    paired(contents, &CaseRef::default_of(variant), &CaseRef::default_of(baseline))
}

/// Whether `case` names this variant and policy; without a policy it names the default one.
pub(super) fn is_case(contents: &Contents, case: &CaseRef, variant: &str, policy: &str) -> bool {
    case.variant == variant
        && case.policy.as_deref().map_or_else(|| is_default(contents, variant, policy), |wanted| wanted == policy)
}

/// Whether a policy is the default policy of its variant.
pub(super) fn is_default(contents: &Contents, variant: &str, policy: &str) -> bool {
    let entry = contents.manifest.variants.iter().find(|entry| entry.id == variant);
    entry.is_some_and(|entry| entry.policies.first().is_none_or(|default| default == policy))
}

/// A ratio with its interval, if it has one.
pub(super) fn ratio(row: &RatioRow) -> String {
    let (low, high) = row.interval().unzip();
    interval(Some(row.ratio), low, high)
}

/// The contacts that are missed: by the boxes that the claims call printed (otherwise by all unsafe volumes), and by the safe volumes.
fn misses(contents: &Contents) -> Statement {
    let printed = printed(&contents.claims);
    let question = if printed.is_empty() {
        "Which contacts are missed?".to_owned()
    } else {
        "What do the boxes as printed miss?".to_owned()
    };
    let default = |variant: &str| tallies(contents, &CaseRef::default_of(variant));
    let entries = || contents.manifest.variants.iter().filter(|v| v.id != NULL_VARIANT && v.kind.is_ours());
    let mut unsafe_cases = printed;
    if unsafe_cases.is_empty() {
        unsafe_cases = entries().filter(|v| !v.safe).map(|v| CaseRef::default_of(&v.id)).collect();
    }
    let found: Vec<Tallies<'_>> = unsafe_cases.iter().map(|case| tallies(contents, case)).collect();
    let rates = unsafe_cases
        .iter()
        .zip(&found)
        .filter_map(|(case, found)| Some(format!("the {} {}", contents.label(&case.variant), rates(found)?)));
    let rates: Vec<String> = rates.collect();
    let mut sentences = Vec::new();
    if !rates.is_empty() {
        sentences.push(format!("Of the contacts of each workload, {}{}.", rates.join("; "), ranges(&found)));
    } else if unsafe_cases.iter().any(|case| contents.manifest.variants.iter().any(|v| v.id == case.variant)) {
        sentences.push("They were asked about no contact in this run.".to_owned());
    } else if !unsafe_cases.is_empty() {
        sentences.push("This run does not have them.".to_owned());
    }
    sentences.push(safe_ones(contents, &entries().filter(|v| v.safe).map(|v| default(&v.id)).collect::<Vec<_>>()));
    Statement { question, answer: sentences.join(" ") }
}

/// The contacts that the safe variants missed, of which there must be none.
fn safe_ones(contents: &Contents, safe: &[Tallies<'_>]) -> String {
    let broken: Vec<String> = contents
        .manifest
        .variants
        .iter()
        .filter(|v| v.safe && v.kind.is_ours() && contents.misses.any_of(&v.id))
        .map(|v| format!("the {}", v.label))
        .collect();
    if !broken.is_empty() {
        let verb = if broken.len() == 1 { "is" } else { "are" };
        return capital(&format!("{} {verb} called safe and missed a contact.", listed(&broken)));
    }
    let asked = |of: &Tallies<'_>| of.values().flatten().map(|(_, tally)| tally.contacts()).sum::<u64>();
    let fewest = match safe.iter().map(asked).min() {
        None => return "The run has no safe variant.".to_owned(),
        Some(0) => return "The safe variants were asked about no contact.".to_owned(),
        Some(fewest) => fewest,
    };
    // None missed on m equal lines is at most 3/m: the largest of any variant in any scene.
    let mut bounds: BTreeMap<&str, f64> = BTreeMap::new();
    let mut unshown: BTreeSet<(&str, &str)> = BTreeSet::new();
    for (&workload, of) in safe.iter().flatten() {
        for &(scene, tally) in of {
            if tally.contacts() == 0 {
                unshown.insert((workload, scene));
            } else {
                let most = bounds.entry(workload).or_default();
                *most = most.max((300.0 / tally.equal_lines()).min(100.0));
            }
        }
    }
    let bounds: Vec<String> =
        bounds.iter().map(|(workload, percent)| format!("{} % in `{workload}`", bound(*percent))).collect();
    let unshown: Vec<String> =
        unshown.into_iter().map(|(workload, scene)| format!("in `{workload}` of {scene}")).collect();
    let unshown = if unshown.is_empty() {
        String::new()
    } else {
        format!(" Nothing is shown where there was no contact to ask about: {}.", listed(&unshown))
    };
    format!(
        "The safe variants miss none of at least {fewest} contacts each: a rate of at most {} (95 %).{unshown}",
        listed(&bounds)
    )
}

/// The cases whose misses the primary rows examine, each once.
fn printed(claims: &ClaimSet) -> Vec<CaseRef> {
    let of_claim = |(claim, reading): (&Claim, &Reading)| match claim.test.as_ref().and_then(|test| test.of) {
        Some(Role::Baseline) => reading.baseline.clone(),
        _ => reading.subject.clone(),
    };
    distinct(primary_of(claims, TestKind::Misses).map(of_claim))
}

/// Tallies by workload, one for each scene, with the scene.
type Tallies<'a> = BTreeMap<&'a str, Vec<(&'a str, &'a Tally)>>;

/// The tallies of a case by workload, one for each scene in which it was verified.
fn tallies<'a>(contents: &'a Contents, case: &CaseRef) -> Tallies<'a> {
    let is_it = |key: &CaseKey| is_case(contents, case, &key.variant, &key.policy());
    let verified = contents.misses.verified().filter(|(_, key, ..)| is_it(key));
    grouped(verified.map(|(scene, _, workload, tally)| (workload, (scene, tally))))
}

/// The miss rates in words, such as ``misses 10 to 29 % in `approach` and none of 412 in `program` ``; `None` when no query was at a contact.
fn rates(of: &Tallies<'_>) -> Option<String> {
    let each: Vec<String> = of.iter().filter_map(|(workload, of)| range(workload, of)).collect();
    (!each.is_empty()).then(|| format!("misses {}", listed(&each)))
}

/// Over how many scenes with contacts the rates range, by workload where that differs; empty where it is one.
fn ranges(of: &[Tallies<'_>]) -> String {
    let mut scenes: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (&workload, of_scenes) in of.iter().flatten() {
        for &(scene, _) in of_scenes.iter().filter(|(_, tally)| tally.contacts() > 0) {
            scenes.entry(workload).or_default().insert(scene);
        }
    }
    let counts: BTreeSet<usize> = scenes.values().map(BTreeSet::len).collect();
    match (counts.first(), counts.len()) {
        (None | Some(1), 0 | 1) => String::new(),
        (Some(same), 1) => format!(" (ranges over {same} scenes)"),
        _ => {
            let each =
                scenes.iter().map(|(workload, of)| format!("{} in `{workload}`", counted(of.len() as u64, "scenes")));
            format!(" (ranges over {})", listed(&each.collect::<Vec<_>>()))
        }
    }
}

/// The miss rates of one workload over scenes: ``10 to 29 % in `random` ``, ``none of 412 in `program` ``, or
/// ``25 % in `program` (none of 4 on housing)``; `None` without a contact.
fn range(workload: &str, of_scenes: &[(&str, &Tally)]) -> Option<String> {
    let asked = of_scenes.iter().filter(|(_, tally)| tally.contacts() > 0);
    let (unmissed, missed): (Vec<_>, Vec<_>) = asked.partition(|(_, tally)| tally.missed() == 0);
    let contacts = unmissed.iter().map(|(_, tally)| tally.contacts()).sum::<u64>();
    if missed.is_empty() {
        return (contacts > 0).then(|| format!("none of {contacts} in `{workload}`"));
    }
    let shares = missed.iter().map(|(_, tally)| 100.0 * tally.missed() as f64 / tally.contacts() as f64);
    let (low, high) = shares.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), share| (l.min(share), h.max(share)));
    let short = |share: f64| match share {
        _ if share >= 9.5 => format!("{share:.0}"),
        _ if share >= 0.1 => format!("{share:.1}"),
        _ => number(share),
    };
    let (low, high) = (short(low), short(high));
    let rate = if low == high { low } else { format!("{low} to {high}") };
    let aside = match &unmissed[..] {
        [] => String::new(),
        [(scene, _)] => format!(" (none of {contacts} on {scene})"),
        several => format!(" (none of {contacts} in {} scenes)", several.len()),
    };
    Some(format!("{rate} % in `{workload}`{aside}"))
}

/// A volume's ratio to the baseline in one scene.
struct Timed<'a> {
    label: &'a str,
    ratio: f64,
    /// Whether its ratio to the fastest volume does not show it slower: the interval holds 1, or there is none.
    is_tied: bool,
    /// Why its time decides nothing: a single launch of programs, or too few clusters of poses.
    undecided: Option<&'static str>,
}

/// Scenes with the same fastest volumes.
struct Group<'a> {
    /// The fastest volume, and those that are not told apart from it, or why nothing is decided.
    leaders: Result<Vec<&'a str>, &'static str>,
    /// The workload by which the scenes are ranked.
    workload: &'a str,
    scenes: Vec<&'a str>,
}

/// The fastest safe volume in each scene, and how much longer the fastest volumes of other scenes take there.
fn fastest(contents: &Contents) -> Statement {
    let question = "Which safe volume is fastest?".to_owned();
    let Some(baseline) = contents.claims.comparison.baselines.first() else {
        return Statement { question, answer: "The claims name nothing to compare with.".to_owned() };
    };
    let scenes: Vec<&str> = contents.manifest.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let timed: Vec<(&str, Vec<Timed>)> = scenes
        .iter()
        .map(|scene| (*scene, timed_on(contents, baseline, scene)))
        .filter(|(_, of)| of.len() > 1)
        .collect();
    if timed.is_empty() {
        let answer = "This run cannot say: it did not time two safe volumes on the same poses.".to_owned();
        return Statement { question, answer };
    }
    let mut groups: Vec<Group<'_>> = Vec::new();
    for (scene, volumes) in &timed {
        let leaders = match undecided_on(contents, scene, volumes) {
            Some(reason) => Err(reason),
            None => Ok(volumes.iter().filter(|volume| volume.is_tied).map(|volume| volume.label).collect()),
        };
        let workload = ranked_by(&contents.ratios, scene).unwrap_or_default();
        match groups.iter_mut().find(|known| known.leaders == leaders && known.workload == workload) {
            Some(known) => known.scenes.push(scene),
            None => groups.push(Group { leaders, workload, scenes: vec![scene] }),
        }
    }
    let each = groups.iter().map(|Group { leaders, workload, scenes }| {
        let the = |labels: &Vec<&str>| labels.iter().map(|label| format!("the {label}")).collect::<Vec<_>>();
        let names = match leaders.as_ref().map(the).as_deref() {
            Err(reason) => format!("undecided ({reason})"),
            Ok([only]) => only.clone(),
            Ok(several) => format!("{}, not told apart,", listed(several)),
        };
        let by = if *workload == PROGRAM_TIME { String::new() } else { format!(", by query time in `{workload}`") };
        format!("{names} on {}{by}", listed(scenes))
    });
    let mut answer = capital(&format!("{}.", each.collect::<Vec<_>>().join("; ")));
    answer += &contrast(&timed, &groups);
    Statement { question, answer }
}

/// How many poses were timed of workloads that were not timed, and of recordings that were in part; empty without such.
fn untimed(contents: &Contents) -> String {
    let timed = |scene: &str, workload: &str| {
        let of_workload = |row: &&SummaryRow| row.scene == scene && row.workload == workload && row.stratum == ALL;
        contents.summary.iter().filter(of_workload).map(|row| row.poses).max().unwrap_or_default()
    };
    let mut is_sampled = false;
    let each = contents.misses.poses().into_iter().filter_map(|((scene, workload), poses)| {
        let count = match timed(scene, workload) {
            0 => "none".to_owned(),
            timed if workload == RECORDED && timed < poses => {
                is_sampled = true;
                timed.to_string()
            }
            _ => return None,
        };
        Some(format!("{count} of the {poses} poses in `{workload}` of {scene}"))
    });
    let each: Vec<String> = each.collect();
    if each.is_empty() {
        return String::new();
    }
    let how =
        if is_sampled { ", those of a recording chosen by stratum and weighted by each stratum's share" } else { "" };
    format!(" {} were timed{how}.", capital(&listed(&each)))
}

/// The safe volumes with a time in a scene, under their default policies, fastest first.
fn timed_on<'a>(contents: &'a Contents, baseline: &str, scene: &str) -> Vec<Timed<'a>> {
    let Contents { ranking, ratios, manifest, .. } = contents;
    let cases = Cases::new(manifest);
    let volumes = ranked_in(scene, ranking, ratios, &cases, baseline);
    let Some(fastest) = volumes.first().map(|(entry, _)| &entry.variant) else { return Vec::new() };
    let timed = volumes.iter().map(|(entry, row)| {
        let direct = ranking_ratio(ratios, &cases, scene, &entry.variant, fastest).and_then(RatioRow::interval);
        Timed {
            label: &entry.label,
            ratio: row.map_or(1.0, |row| row.ratio),
            is_tied: entry.variant == *fastest || direct.is_none_or(|(low, _)| low <= 1.0),
            undecided: row.and_then(undecided),
        }
    });
    timed.collect()
}

/// Why a ratio decides nothing, however clear it looks.
fn undecided(row: &RatioRow) -> Option<&'static str> {
    let is_program = row.metric == PROGRAM_TIME;
    let (fewest, reason) = if is_program { (2, "one launch") } else { (CLUSTERS_MIN as u64, "too few poses") };
    (row.clusters < fewest).then_some(reason)
}

/// Why nothing is decided about speed in a scene.
fn undecided_on(contents: &Contents, scene: &str, volumes: &[Timed<'_>]) -> Option<&'static str> {
    let reason = volumes.iter().find_map(|volume| volume.undecided);
    reason.or_else(|| is_noisy(&contents.ratios, scene).then_some("noisy"))
}

/// The scenes of the ranking in which nothing is decided about speed, each with the reason.
pub(super) fn undecided_scenes<'a>(contents: &'a Contents, baseline: &str) -> Vec<(&'a str, &'static str)> {
    let scenes = contents.manifest.scenes.iter().map(|scene| scene.name.as_str());
    let each = scenes.filter_map(|scene| {
        let volumes = timed_on(contents, baseline, scene);
        Some((scene, undecided_on(contents, scene, &volumes)?))
    });
    each.collect()
}

/// The places of the ranking: `1`, or `(1)` when speed is decided in no scene; `-` for a method that is not a volume on the common tree.
pub fn places(contents: &Contents) -> Vec<String> {
    let baseline = contents.claims.comparison.baselines.first().map_or("", String::as_str);
    let is_decided = undecided_scenes(contents, baseline).len() < contents.manifest.scenes.len();
    let place = |(place, entry): (usize, &Ranked)| match entry.kind {
        Kind::Volume if is_decided => place.to_string(),
        Kind::Volume => format!("({place})"),
        _ => "-".to_owned(),
    };
    (1..).zip(&contents.ranking).map(place).collect()
}

/// How much longer a volume that is fastest in one scene takes in another, as the largest such factor. Empty when one volume leads
/// everywhere. Scenes without a leader count for nothing.
fn contrast(timed: &[(&str, Vec<Timed>)], groups: &[Group<'_>]) -> String {
    let led: Vec<&Group<'_>> = groups.iter().filter(|group| group.leaders.is_ok()).collect();
    let is_leader = |label: &str| led.iter().filter_map(|group| group.leaders.as_ref().ok()).any(|of| of[0] == label);
    let worst = timed
        .iter()
        .filter(|(scene, _)| led.iter().any(|group| group.scenes.contains(scene)))
        .flat_map(|(scene, volumes)| {
            let best = volumes[0].ratio;
            volumes.iter().filter(|v| is_leader(v.label)).map(move |v| (v.ratio / best, v.label, *scene))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((factor, label, scene)) if led.len() > 1 && factor >= 1.5 => {
            format!(
                " None is fastest everywhere: on {scene} the {label} takes {} times the time of the fastest.",
                number(factor)
            )
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests;
