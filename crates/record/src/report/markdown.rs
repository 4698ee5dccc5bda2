//! The report as Markdown, section by section.

use super::Contents;
use super::answer::{answer, is_default, paired_by_default, places, quantity, ratio, undecided_scenes};
use super::programs;
use super::sentences::{Group, blocks, sentences, verdicts_in_words, words};
use super::tables::{Table, bound, interval, number};
use crate::analysis::ALL;
use crate::analysis::claims::{Claim, ClaimSet, DEFAULT_TEXT, Direction, Expectation, TestKind};
use crate::analysis::judge::{SAME, refuted_from};
use crate::analysis::words::listed;
use crate::record::command::{has_option, quoted};
use crate::record::{Kind, Manifest, NULL_VARIANT};
use std::collections::BTreeMap;
use std::path::Path;

/// The whole report. Text from a scene or a claims file is escaped, so it cannot open an HTML element.
pub(super) fn render(contents: &Contents) -> String {
    [
        opening(contents),
        program_time(contents),
        ranking(contents),
        at_a_glance(contents),
        misses(contents),
        what_was_run(contents),
        figures(contents),
        details(contents),
        times(contents),
        super::variance::section(contents),
        super::peers::section(&contents.peers, &contents.peer_ratios),
        provenance(contents),
        limitations(&contents.claims),
    ]
    .concat()
    .replace('<', "&lt;")
}

fn opening(contents: &Contents) -> String {
    let Contents { manifest, claims, noise, .. } = contents;
    let about = if claims.is_empty() { claims.source.clone() } else { format!("the claims of {}", claims.source) };
    let mut text = format!("# Bounding volumes on trial: {about}\n\n## The answer\n\n");
    for statement in answer(contents) {
        text += &format!("**{}** {}\n\n", statement.question, statement.answer);
    }
    text += &format!("## What this is\n\n{}\n\n", super::lead(claims, manifest));
    if let Some(short) = super::noise_in_short(contents) {
        text += &format!("> {short}\n>\n");
        text.extend(noise.iter().map(|note| format!("> - {note}\n")));
        text.push('\n');
    }
    text
}

/// The section on the paper's own quantity: its figure, and below it the paired ratios.
fn program_time(contents: &Contents) -> String {
    let rows = programs::table(contents);
    if rows.is_empty() {
        return String::new();
    }
    let mut text = "## Time of whole programs\n\n".to_owned();
    if let Some(figure) = contents.gallery.figures.iter().find(|figure| figure.name == crate::plot::PAPER_FIGURE) {
        text += &picture(figure);
    }
    let [subject, baseline] = [&rows[0].subject, &rows[0].baseline].map(|id| contents.label(id));
    let mut table = Table::new(&[
        "scene",
        "programs",
        &format!(">{baseline}, ms"),
        &format!(">{subject}, ms"),
        ">paired ratio [95 %]",
        "the first is",
    ]);
    for row in &rows {
        let ms = |ns: Option<[f64; 3]>| ns.map_or_else(|| "-".to_owned(), |[ns, ..]| number(ns / 1e6));
        table.row([
            row.scene.clone(),
            row.programs.clone(),
            ms(row.baseline_ns),
            ms(row.subject_ns),
            interval(Some(row.ratio), Some(row.low), Some(row.high)),
            row.effect.clone(),
        ]);
    }
    text + &table.finish().replace("the first is", &format!("the {subject} is"))
        + "Sum of the query times of each program, from its start to its first collision or to its end. Intervals are over binaries, or over the launches of a single one.\n\n"
}

fn picture(figure: &crate::plot::Figure) -> String {
    let path = |path: &Path| path.display().to_string().replace('\\', "/");
    let (title, svg) = (&figure.title, path(&figure.svg));
    format!("![{title}]({})\n\n{} ([SVG]({svg}))\n\n", path(&figure.png), figure.caption)
}

fn at_a_glance(contents: &Contents) -> String {
    if contents.claims.is_empty() {
        return String::new();
    }
    let mut text = "## The paper, sentence by sentence\n\nThe first verdict answers the sentence; the other columns are the readings that its words \
                    allow, exploratory. *supported*: the whole 95 % interval is where the column `supported` says; *refuted*: it is where the column \
                    `refuted` says, an effect the other way or none; *undecided*: neither, an effect smaller than the margin of 5 % included; \
                    *not-applicable*: nothing was broken that could be repaired.\n\n"
        .to_owned();
    let link = |id: &str, sentence: &str| format!("[{sentence}](#{id})");
    for (readings, of) in blocks(contents, Group::Judged) {
        text.extend(readings.iter().map(|reading| {
            let (name, rest) = words(reading);
            format!("- **{name}**: {rest}.\n")
        }));
        text.push('\n');
        let names = readings.iter().map(|reading| words(reading).0);
        let fixed = ["the paper says", "supported", "refuted", "verdict"].map(str::to_owned);
        let headings: Vec<String> = fixed.into_iter().chain(names).collect();
        let mut table = Table::new(&headings);
        for sentence in of {
            let of_reading =
                |id: &str| sentence.cells.iter().find(|(own, _)| *own == id).map_or(&[][..], |(_, rows)| rows);
            let verdict = sentence.primary.map_or_else(String::new, |row| format!("**{}**", row.verdict));
            let cells = readings.iter().map(|reading| verdicts_in_words(of_reading(reading.id.get_ref())));
            let [supported, refuted] = thresholds(sentence.claim);
            let sentence = link(sentence.claim.id(), &sentence.claim.sentence);
            table.row([sentence, supported, refuted, verdict].into_iter().chain(cells));
        }
        text += &table.finish();
    }
    for (group, heading) in [
        (Group::Literature, "Sentences of other literature"),
        (Group::NotJudged, "Sentences that this run does not judge"),
    ] {
        let mut table = Table::new(&["sentence", "source", "verdict"]);
        let of: Vec<_> = sentences(contents).into_iter().filter(|sentence| sentence.group == group).collect();
        for sentence in &of {
            let rows: Vec<_> = sentence.cells.iter().flat_map(|(_, rows)| rows.iter().copied()).collect();
            let note = rows.iter().find(|row| row.verdict == "not-judged").map(|row| row.note.clone());
            let reason =
                sentence.claim.not_judged.clone().or_else(|| sentence.primary.map(|row| row.note.clone())).or(note);
            let each = sentence.cells.iter().map(|(id, rows)| format!("{id} {}", verdicts_in_words(rows)));
            let verdict = match reason {
                Some(reason) => reason,
                None => each.collect::<Vec<_>>().join("; "),
            };
            table.row([link(sentence.claim.id(), &sentence.claim.sentence), sentence.claim.source.clone(), verdict]);
        }
        if !of.is_empty() {
            text += &format!("### {heading}\n\n{}", table.finish());
        }
    }
    text
}

fn what_was_run(contents: &Contents) -> String {
    let Contents { manifest, .. } = contents;
    let (request, machine) = (&manifest.request, &manifest.machine);
    let (place, judged) = if contents.claims.text == DEFAULT_TEXT {
        ("this folder", "")
    } else {
        ("a folder, and FILE a copy of the `claims.toml` beside this report", " --claims FILE")
    };
    let mut scenes = Table::new(&["scene", "what it shows", "parts (triangles)", "pairs examined"]);
    for scene in &manifest.scenes {
        let parts: Vec<String> = scene.triangles.iter().map(|(part, n)| format!("{part} ({n})")).collect();
        scenes.row([scene.name.clone(), scene.title.clone(), parts.join(", "), scene.pairs.join(", ")]);
    }
    format!(
        "## What was run\n\n{}Per scene some {} posed pairs were verified against exact truth and some {} poses were timed (equal shares of \
         the strata, less where there are not so many), in {} blocks of random order, {} process launch(es) of {} binary(ies), seed {}. Machine: {}, {} logical cores, {}{:.1} GiB, {}{}.\n\n\
         The command was\n\n    {}\n\nand the same steps one by one, where DIR is {place}:\n\n    \
         cargo run --release -- stage verify --profile {p} --seed {s}{chosen} --out DIR\n    \
         cargo run --release -- stage measure --profile {p} --seed {s}{chosen} --out DIR\n    \
         cargo run --release -- stage analyze{judged} --out DIR\n    cargo run --release -- stage plot --out DIR\n    \
         cargo run --release -- stage report --out DIR\n\n",
        scenes.finish(),
        request.verify_poses,
        request.measure_poses,
        request.blocks,
        request.launches,
        request.binaries,
        request.seed,
        machine.cpu,
        machine.cores,
        if machine.simd.is_empty() { String::new() } else { format!("wide trees on {}, ", machine.simd) },
        machine.memory_bytes as f64 / f64::from(1 << 30),
        machine.os,
        machine.load.map_or_else(String::new, |load| format!(", load {load:.2} at the start")),
        manifest.program.command,
        p = request.profile,
        s = request.seed,
        chosen = chosen(manifest),
    )
}

/// The options that selected what was run, if they were not the defaults, and how often it repeated.
fn chosen(manifest: &Manifest) -> String {
    let request = &manifest.request;
    // The request names all variants, whether they were chosen or not.
    let variants = if has_option(&manifest.program.command, "--variant") { &request.variants[..] } else { &[] };
    let options = [
        ("scene", &request.scenes[..]),
        ("variant", variants),
        ("workload", &request.workloads),
        ("policy", &request.policies),
    ];
    let each = options.into_iter().flat_map(|(option, names)| names.iter().map(move |name| (option, name)));
    let names: String = each.map(|(option, name)| format!(" --{option} {}", quoted(name))).collect();
    let binaries = if request.binaries > 1 { " --binary target/binaries" } else { "" };
    format!(
        "{names}{binaries} --launches {} --blocks {} --cold-poses {}",
        request.launches / request.binaries.max(1),
        request.blocks,
        request.cold_poses
    )
}

fn ranking(contents: &Contents) -> String {
    let Some(baseline) = contents.claims.comparison.baselines.first() else { return String::new() };
    let scenes: Vec<&str> = contents.manifest.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let headings: Vec<String> = ["place", "variant", ">time ratio"]
        .map(str::to_owned)
        .into_iter()
        .chain(scenes.iter().map(|scene| format!(">{scene}")))
        .chain([">missed".to_owned()])
        .collect();
    let (mut volumes, mut others) = (Table::new(&headings), Table::new(&headings));
    let mut has_intervals = true;
    for (place, entry) in places(contents).into_iter().zip(&contents.ranking) {
        let is_volume = entry.kind == Kind::Volume;
        let rows = paired_by_default(contents, &entry.variant, baseline);
        has_intervals &= rows.iter().all(|row| row.interval().is_some());
        let per_scene = scenes.iter().map(|scene| {
            let wanted = rows.iter().find(|r| r.scene == *scene);
            wanted.map_or_else(|| "-".to_owned(), |row| ratio(row))
        });
        let tallies = contents.misses.iter().filter(|(_, case, ..)| {
            case.variant == entry.variant && is_default(contents, &case.variant, &case.policy())
        });
        let missed = tallies.map(|(.., tally)| tally.missed_in_all).reduce(|sum, missed| sum + missed);
        let missed = missed.map_or_else(|| "not verified".to_owned(), |missed| missed.to_string());
        let cells = [place, entry.label.clone(), number(entry.ratio)].into_iter().chain(per_scene).chain([missed]);
        if is_volume { volumes.row(cells) } else { others.row(cells) }
    }
    if contents.ranking.is_empty() {
        return format!(
            "## Ranking by speed\n\nNone: this run has no time of another variant relative to {}, by which all are ranked.\n\n",
            contents.label(baseline)
        );
    }
    format!(
        "## Ranking by speed\n\nSafe bounding volumes under their default tree policies, by {} relative to {}: geometric \
         mean over the scenes as a summary, and the ratio in each scene with its 95 % interval{}. The order holds for these \
         scenes, this machine and these trees. Intervals that overlap do not make two volumes equal: the answer above names the \
         volumes that their direct ratio to the fastest one (`ratios.csv`) does not show slower.{} Unsafe volumes are left \
         out whatever their speed, because a method can look fast by missing collisions.\n\n{}\
         Not volumes on the common tree, and so not ranked: our engines, whose trees, vector arithmetic and threads are their own; controls; \
         methods by samples; other libraries' whole systems with trees and triangle tests of their own.\n\n{}",
        quantity(contents, "the time of whole programs"),
        contents.label(baseline),
        if has_intervals { "" } else { ", where it has one: a single launch of programs shows no spread" },
        undecided(contents, baseline),
        volumes.finish(),
        others.finish()
    )
}

/// A sentence on the scenes in which the order of the ranking shows nothing; empty without such.
fn undecided(contents: &Contents, baseline: &str) -> String {
    let scenes = undecided_scenes(contents, baseline);
    if scenes.is_empty() {
        return String::new();
    }
    let marked = if scenes.len() == contents.manifest.scenes.len() { ", so that places are in brackets" } else { "" };
    let each: Vec<String> = scenes.iter().map(|(scene, reason)| format!("{scene} ({reason})")).collect();
    format!(" Speed is undecided on {}: the order shows nothing there{marked}.", listed(&each))
}

fn misses(contents: &Contents) -> String {
    let headings = [
        "scene",
        "variant",
        "policy",
        "promise",
        "workload",
        ">contacts asked",
        ">lines",
        ">missed",
        ">miss rate, 95 %",
        ">with answers by witness",
    ];
    let mut table = Table::new(&headings);
    for (scene, case, workload, tally) in contents.misses.iter() {
        let safe =
            contents.manifest.variants.iter().find(|entry| entry.id == case.variant).is_some_and(|entry| entry.safe);
        let (low, high) = tally.interval();
        let rate = match (tally.missed(), tally.contacts()) {
            (_, 0) => "-".to_owned(),
            (0, _) => format!("at most {}", bound(high)),
            (missed, n) => interval(Some(missed as f64 / n as f64), Some(low), Some(high)),
        };
        table.row([
            scene.to_owned(),
            contents.label(&case.variant).to_owned(),
            case.policy(),
            (if safe { "safe" } else { "none" }).to_owned(),
            workload.to_owned(),
            tally.contacts().to_string(),
            tally.lines.len().to_string(),
            tally.missed().to_string(),
            rate,
            format!("{} of {}", tally.missed_in_all, tally.contacts_in_all),
        ]);
    }
    format!(
        "## Contacts missed\n\nContacts by the exact test, grazing ones apart, at which the variant's own query was asked, and how many of them it \
         missed, by workload: nothing is averaged over workloads. `program` holds the contacts on the scene's own tool paths, `approach` and \
         `random` those of poses made for the test. Rates with 95 % intervals by line (an approach, a ray, a stretch of a path): contacts of one \
         line depend on one another; none missed is written as at most 3/m, where m is the number of lines of equal contacts that say as much \
         ((Σ contacts)² / Σ contacts²). The last column adds verdicts that follow from a contact that the truth names.{}\n\n{}",
        unmissed_in_programs(contents),
        table.finish()
    )
}

/// A sentence when a variant that promises nothing misses contacts, but none on the way of a program.
fn unmissed_in_programs(contents: &Contents) -> String {
    let is_unsafe = |id: &str| contents.manifest.variants.iter().any(|v| v.id == id && !v.safe && v.kind.is_ours());
    let mut sums: BTreeMap<&str, [u64; 3]> = BTreeMap::new();
    for (_, case, workload, tally) in contents.misses.iter() {
        if is_unsafe(&case.variant) && is_default(contents, &case.variant, &case.policy()) {
            let [contacts, missed, elsewhere] = sums.entry(&case.variant).or_default();
            if workload == "program" {
                (*contacts, *missed) = (*contacts + tally.contacts(), *missed + tally.missed());
            } else {
                *elsewhere += tally.missed();
            }
        }
    }
    let spared =
        sums.iter().filter(|(_, [contacts, missed, elsewhere])| *contacts > 0 && *missed == 0 && *elsewhere > 0);
    let each: Vec<String> = spared
        .map(|(id, [contacts, ..])| format!("the {} misses none of the {contacts} contacts", contents.label(id)))
        .collect();
    if each.is_empty() {
        return String::new();
    }
    format!(" On the programs of these scenes {}: its misses are at other poses.", each.join(", and "))
}

fn figures(contents: &Contents) -> String {
    let mut text = "## Figures\n\n".to_owned();
    for figure in contents.gallery.figures.iter().filter(|figure| figure.name != crate::plot::PAPER_FIGURE) {
        text += &format!("### {}\n\n{}", figure.title, picture(figure));
    }
    for skipped in &contents.gallery.skipped {
        text += &format!("Figure `{}` was not drawn: {}.\n\n", skipped.name, skipped.reason);
    }
    if contents.gallery == crate::plot::Gallery::default() {
        text += "None were drawn yet.\n\n";
    }
    text
}

fn details(contents: &Contents) -> String {
    if contents.claims.is_empty() {
        return String::new();
    }
    let mut text = "## The claims one by one\n\nMisses are those of the reading's subject / of its baseline, above \
                    grazing.\n\n"
        .to_owned();
    for claim in &contents.claims.claims {
        text += &format!("### {}\n\n> {} ({})\n\n", claim.id(), claim.sentence, claim.source);
        if let Some(reason) = &claim.not_judged {
            text += &format!("Not judged: {reason}.\n\n");
            continue;
        }
        let [supported, refuted] = thresholds(claim);
        text += &format!("Supported: {supported}. Refuted: {refuted}.\n\n");
        let headings = [
            "role",
            "reading",
            "scene",
            "workload",
            "stratum",
            "verdict",
            "effect",
            "measure",
            ">value [95 %]",
            ">misses",
            "note",
        ];
        let mut table = Table::new(&headings);
        for row in contents.verdicts.iter().filter(|row| row.claim == claim.id()) {
            let count = |missed: Option<u64>| missed.map_or_else(|| "-".to_owned(), |n| n.to_string());
            table.row([
                row.role.clone(),
                row.reading.clone(),
                row.scene.clone(),
                row.workload.clone(),
                row.stratum.clone(),
                row.verdict.clone(),
                row.effect.clone(),
                row.measure.clone(),
                interval(row.value, row.low, row.high),
                format!("{} / {}", count(row.missed), count(row.baseline_missed)),
                row.note.clone(),
            ]);
        }
        text += &table.finish();
    }
    text
}

/// Where a claim is supported and where it is refuted, of the value or of its whole interval; empty for a claim without a test.
fn thresholds(claim: &Claim) -> [String; 2] {
    let Some(test) = &claim.test else { return [String::new(), String::new()] };
    let absent = test.expect == Some(Expectation::Absent);
    let above = test.above.unwrap_or(0.0);
    let presence = |there: String, not_there: String| if absent { [not_there, there] } else { [there, not_there] };
    match test.kind {
        TestKind::Misses => {
            presence("a contact missed".to_owned(), format!("none missed, at most {} %", number(100.0 * above)))
        }
        TestKind::Overhang => presence(format!("> {above} % outside"), format!("≤ {above} % outside")),
        TestKind::Drift => {
            let there = format!("> {above} mm to the dense side");
            if absent {
                [format!("no {there}"), there]
            } else {
                [format!("{there}, none to the other"), "nowhere, or to the other side".to_owned()]
            }
        }
        TestKind::Gap => presence("gap within 10 % of the overhang".to_owned(), "another gap, or none".to_owned()),
        _ => match (test.at_most, test.below) {
            (Some(most), _) => [format!("≤ {most}"), format!("> {most}")],
            (None, below) => {
                let below = below.unwrap_or(SAME.0);
                let refuted = refuted_from(below, test.names_margin);
                if test.direction == Direction::Greater {
                    [format!("> {}", number(1.0 / below)), format!("≤ {}", number(1.0 / refuted))]
                } else {
                    [format!("< {below}"), format!("≥ {refuted}")]
                }
            }
        },
    }
}

fn times(contents: &Contents) -> String {
    let headings = [
        "scene",
        "workload",
        "variant",
        "policy",
        ">mean, µs",
        ">median",
        ">p95",
        ">p99",
        ">max",
        ">volume tests",
        ">triangle tests",
    ];
    let mut table = Table::new(&headings);
    for row in contents.summary.iter().filter(|row| row.stratum == ALL && row.variant != NULL_VARIANT) {
        let us = |ns: Option<f64>| ns.map_or_else(|| "-".to_owned(), |ns| number(ns / 1e3));
        let (low, high) = row.interval().map(|(low, high)| (low / 1e3, high / 1e3)).unzip();
        table.row([
            row.scene.clone(),
            row.workload.clone(),
            contents.label(&row.variant).to_owned(),
            row.case().policy(),
            interval(Some(row.mean_ns / 1e3), low, high),
            us(row.query_p50_ns),
            us(row.query_p95_ns),
            us(row.query_p99_ns),
            us(row.query_max_ns),
            number(row.volume_tests),
            number(row.triangle_tests),
        ]);
    }
    let clock = contents.manifest.clock.map_or_else(String::new, |clock| {
        format!(" Each reading holds the clock's own {} ns (99 % of {}).", clock.empty_ns, clock.empty_p99_ns)
    });
    format!(
        "## Times and counts of a query\n\nArithmetic mean over the poses of each workload with its 95 % interval; median, 95th and 99th \
         percentile and largest of single queries, of each pose the median reading, of cases under their default policies.{clock} By stratum in `summary.csv`. Times of two methods are to be compared by their paired ratios \
         (`ratios.csv`), not by these intervals.\n\n{}",
        table.finish()
    )
}

fn provenance(contents: &Contents) -> String {
    let program = &contents.manifest.program;
    let known = |text: &str| if text.is_empty() { "unknown".to_owned() } else { text.to_owned() };
    let mut inputs = Table::new(&["input", "content hash"]);
    contents.manifest.inputs.iter().for_each(|(name, hash)| inputs.row([name.as_str(), &format!("`{hash}`")]));
    let mut variants = Table::new(&["id", "name", "kind", "promise", "policies, default first", "source"]);
    for entry in &contents.manifest.variants {
        let kind = format!("{:?}", entry.kind).to_lowercase();
        let promise = if entry.safe { "safe" } else { "none" };
        variants.row([&entry.id, &entry.label, kind.as_str(), promise, &entry.policies.join(", "), &entry.reference]);
    }
    format!(
        "## Provenance\n\nbvbench {}, git revision {}{}, {}, flags: {}. Every number above derives from the CSV files in this folder; \
         their columns are described in the data dictionary, `results/README.md` of the project.\n\n{}{}",
        known(&program.version),
        known(&program.git_revision),
        match program.git_dirty {
            Some(true) => " with local changes",
            Some(false) => "",
            None => " (state of the checkout unknown)",
        },
        known(&program.rustc),
        known(&program.flags),
        variants.finish(),
        inputs.finish()
    )
}

/// What the results do not show, and whether that limitation concerns the paper.
const LIMITATIONS: [(bool, &str); 5] = [
    (
        true,
        "This is a conceptual replication. The paper's computer and control, its meshes and its NC programs are not available; the \
     scenes are our own machines built after its description. Its absolute times cannot be compared with any here.",
    ),
    (
        true,
        "The paper leaves open how its plain box is centred and how its trees are split. The readings cover what its text can mean; \
     none of them is certain to be what was programmed.",
    ),
    (
        false,
        "Intervals describe the poses of these scenes and the layouts of the binaries, resampled; those of whole programs the binaries, or the \
     launches of a single one. They say nothing about other machines, tools or meshes.",
    ),
    (
        false,
        "Times belong to one computer, one compiler and one implementation of each method, all by the same authors. Operation counts \
     and misses do not depend on the computer.",
    ),
    (
        true,
        "The sentences are paraphrased from Chinese, and the thresholds for words such as \"considerable\" are ours; both were fixed \
     before the run and stand in claims.toml beside this report.",
    ),
];

/// The [`LIMITATIONS`] that apply to a run with these claims.
pub(super) fn limitations_of(claims: &ClaimSet) -> impl Iterator<Item = &'static str> {
    LIMITATIONS.into_iter().filter(|(about_paper, _)| !(*about_paper && claims.is_empty())).map(|(_, limit)| limit)
}

fn limitations(claims: &ClaimSet) -> String {
    let line = |limit: &str| format!("- {}\n", limit.replace("claims.toml", "`claims.toml`"));
    format!("## Limitations\n\n{}", limitations_of(claims).map(line).collect::<String>())
}
