//! What the search wrote is accepted; whatever is changed in it is refused, with the line.

use crate::fixture::{NAMES, accepted, checked, find, folder, lines, refused, signed, with_word};
use certificate_checker::{MOST_WORK, check};
use std::collections::BTreeSet;

#[test]
fn certificates_of_the_search_are_accepted() {
    for (name, free, of, pairs) in [("mill", 11, 13, 21), ("five-axis", 8, 8, 3)] {
        let (lines, folder) = (lines(name), folder(name));
        let text = lines.join("\n") + "\n";
        assert_eq!(text, signed(&lines));
        let report = check(&text, Some(&folder), Some(&folder.join("program.ngc")), MOST_WORK).unwrap();
        assert_eq!(report.blocks.values().filter(|verdict| **verdict == "free").count(), free);
        assert_eq!((report.blocks.len(), report.examined), (of, pairs));
        assert_eq!(
            report.intervals,
            lines.iter().filter(|line| line.starts_with("free ") || line.starts_with("same ")).count()
        );
        accepted(&text);
    }
    let report = accepted(&signed(&lines("mill")));
    assert_eq!((report.blocks[&12], report.blocks[&13]), ("collision", "unresolved"));
    let named: Vec<&str> =
        report.notes.iter().filter(|note| note.starts_with("not examined")).map(String::as_str).collect();
    let wanted = ["base:saddle, neighbours", "base:stop, ignored", "vise:stop, allowed"];
    assert_eq!(named, wanted.map(|pair| format!("not examined: {pair}")));
}

#[test]
fn a_shifted_plane_is_refused() {
    for name in NAMES {
        let mut lines = lines(name);
        for i in 0..lines.len() {
            if lines[i].starts_with("free") && lines[i].split(' ').nth(3) == Some("p") {
                let own = lines[i].clone();
                let offset: i64 = own.split(' ').nth(7).unwrap().parse().unwrap();
                for (by, why) in [(80 << 24, "does not part the two"), (-(80 << 24), "is not behind plane 1")] {
                    lines[i] = with_word(&own, 7, &(offset + by).to_string());
                    refused(&signed(&lines), i + 1, why);
                }
                lines[i] = with_word(&own, 7, &(1_i64 << 53).to_string());
                refused(&signed(&lines), i + 1, "is not a number up to");
                lines[i] = own;
            }
        }
    }
}

#[test]
fn a_cut_interval_is_refused() {
    // Without its first interval the next one has no planes, or goes too far.
    let mut mill = lines("mill");
    let i = find(&mill, "pair base mill") + 1;
    mill.remove(i);
    refused(&signed(&mill), i + 1, "points may go farther than 18.000002 mm");
    let mut mill = lines("mill");
    let i = find(&mill, "pair vise stop") + 1;
    let i = i + mill[i..].iter().position(|line| line.starts_with("same")).unwrap() - 1;
    mill.remove(i);
    refused(&signed(&mill), i + 1, "points may go farther");
}

#[test]
fn a_gap_is_refused() {
    for name in NAMES {
        let own = lines(name);
        let ends: Vec<usize> = (1..own.len())
            .filter(|&i| {
                own[i].starts_with("pair ") && ["free ", "same "].iter().any(|word| own[i - 1].starts_with(word))
            })
            .collect();
        assert!(ends.len() > 1);
        // The last interval of a pair is missing, or ends too early.
        for i in ends {
            let mut lines = own.clone();
            let last = lines.remove(i - 1);
            refused(&signed(&lines), i, "the pair before does not come to the end of the path");
            let early = last.split(' ').nth(1).unwrap().parse::<f64>().unwrap() - 0.5;
            lines.insert(i - 1, with_word(&last, 1, &early.to_string()));
            // Half a step is an interval, one and a half are none.
            let refusal = checked(&signed(&lines)).unwrap_err();
            let is_short = refusal.line == i + 1 && refusal.why.starts_with("the pair before");
            assert!(is_short || refusal.line == i && refusal.why.starts_with("no such interval"), "{refusal:?}");
        }
    }
    // An interval that ends before it begins, at no number of the path, or behind its end.
    let mut mill = lines("mill");
    let i = find(&mill, "pair base mill") + 2;
    for to in ["8", "7", "12.5", "20"] {
        mill[i] = with_word(&mill[i], 1, to);
        refused(&signed(&mill), i + 1, "no such interval of the path");
    }
}

#[test]
fn another_mesh_is_refused() {
    for name in NAMES {
        let mut lines = lines(name);
        let last = find(&lines, "point") - 1;
        let v = (0..last).rev().find(|&i| lines[i].starts_with("v ")).unwrap();
        lines[v] = with_word(&lines[v], 3, &(-1000_i64 << 26).to_string());
        let line = checked(&signed(&lines)).unwrap_err().line;
        assert!(["free ", "same "].iter().any(|word| lines[line - 1].starts_with(word)), "{}", lines[line - 1]);
        // One step of the grid beyond the largest coordinate.
        lines[v] = with_word(&lines[v], 3, &((4096_i64 << 26) + 1).to_string());
        refused(&signed(&lines), v + 1, "a vertex out of range");
        let f = (0..last).rev().find(|&i| lines[i].starts_with("f ")).unwrap();
        let count = (0..last)
            .rev()
            .take_while(|&i| !lines[i].starts_with("part"))
            .filter(|&i| lines[i].starts_with("v "))
            .count();
        lines[v] = "v 0 0 0".to_owned();
        lines[f] = with_word(&lines[f], 1, &count.to_string());
        refused(&signed(&lines), f + 1, "no such vertex");
    }
}

#[test]
fn swapped_lines_are_refused() {
    let own = lines("mill");
    let swapped = |first: &str| {
        let mut lines = own.clone();
        let i = find(&lines, first);
        lines.swap(i, i + 1);
        (signed(&lines), i + 1)
    };
    let (text, line) = swapped("bvbench-certificate");
    refused(&text, line, "another version of the format");
    let (text, line) = swapped("part saddle");
    let needs_four = |line: &str| line.starts_with("f ") && line.contains('3');
    let needs_four = text.lines().skip(line).position(needs_four).unwrap() + line + 1;
    refused(&text, needs_four, "no such vertex");
    // An arc does not end where it would from another place; the path is complete when the first pair begins.
    let pair = find(&own, "pair") + 1;
    refused(&swapped("feed 3").0, pair, "the path jumps at move 5, of line 3");
    refused(&swapped("feed 5").0, pair, "the path jumps at move 7, of line 5");
    let (text, line) = swapped("pair chuck probe");
    refused(&text, line + 1, "the pair before does not come to the end");
    let mut lines = own.clone();
    let i = find(&lines, "pair base mill") + 1;
    lines.swap(i, i + 1);
    refused(&signed(&lines), i + 1, "points may go farther");
    let mut lines = own;
    let i = find(&lines, "turn stop");
    lines.swap(i - 1, i);
    refused(&signed(&lines), i, "no link `table`");
}

#[test]
fn a_changed_hash_is_refused() {
    for name in NAMES {
        let mut lines = lines(name);
        let (end, input) = (lines.len() - 1, find(&lines, "input"));
        let other = blake3::hash(b"another").to_hex();
        lines[end] = format!("end {other}");
        refused(&(lines.join("\n") + "\n"), end + 1, "the hash of the lines before is another");
        // The content is changed, and the hash is the old one.
        let mut lines = self::lines(name);
        lines[1] = "made by hand".to_owned();
        refused(&(lines.join("\n") + "\n"), end + 1, "the hash of the lines before is another");
        let mut lines = self::lines(name);
        lines[input] = with_word(&lines[input], 2, &other);
        let refusal = check(&signed(&lines), Some(&folder(name)), None, MOST_WORK).unwrap_err();
        crate::fixture::assert_refusal(&refusal, find(&lines, "end") + 1, "is not among the files");
    }
}

#[test]
fn a_truncated_file_is_refused() {
    for name in NAMES {
        let lines = lines(name);
        for count in 0..lines.len() {
            let text: String = lines[..count].iter().map(|line| line.to_owned() + "\n").collect();
            let refusal = checked(&text).unwrap_err();
            assert_eq!((refusal.line, &*refusal.why), (count + 1, "the certificate ends without `end`"));
            let cut = text + &lines[count][..lines[count].len() / 2];
            assert!(checked(&cut).unwrap_err().line > count);
        }
        // The last line without its end, and more behind it.
        refused(&lines.join("\n"), lines.len(), "something follows");
        refused(&(lines.join("\n") + "\n\n"), lines.len(), "something follows");
    }
}

/// The places of numbers in a line.
fn numbers(line: &str) -> Vec<(usize, usize)> {
    let bounds = line.char_indices().filter(|(_, c)| *c == ' ').map(|(i, _)| i).chain([line.len()]);
    let mut begin = 0;
    let mut found = Vec::new();
    for end in bounds {
        if line[begin..end].parse::<f64>().is_ok() {
            found.push((begin, end));
        }
        begin = end + 1;
    }
    found
}

#[test]
fn numbers_that_are_none_or_too_large_are_refused() {
    for name in NAMES {
        let mut lines = lines(name);
        // A line of each kind: its words without the digits.
        let mut kinds = BTreeSet::new();
        let count = lines.len();
        for i in 0..count - 1 {
            let kind: String =
                lines[i].chars().filter(|c| !c.is_ascii_digit() && !"-.".contains(*c)).take(40).collect();
            let is_told = lines[i].starts_with("made") || lines[i].starts_with("scene");
            if is_told || !kinds.insert(kind) {
                continue;
            }
            let own = lines[i].clone();
            for (begin, end) in numbers(&own) {
                for number in [
                    "NaN",
                    "inf",
                    "-inf",
                    "-infinity",
                    "1e300",
                    "1e999",
                    "-99999999999999999999999999",
                    "",
                    "0x10",
                    "one",
                ] {
                    lines[i] = format!("{}{number}{}", &own[..begin], &own[end..]);
                    let refusal = checked(&signed(&lines)).unwrap_err();
                    assert_eq!(refusal.line, i + 1, "{}: {}", lines[i], refusal.why);
                }
            }
            lines[i] = own;
        }
        assert!(kinds.len() > 25, "{kinds:?}");
    }
}

#[test]
fn a_wrong_pair_is_refused() {
    let own = lines("mill");
    let with = |line: usize, text: &str| {
        let mut lines = own.clone();
        lines[line] = text.to_owned();
        signed(&lines)
    };
    let rigid = find(&own, "pair vise part");
    refused(&with(rigid, "pair vise vise rigid"), rigid + 1, "the pair was there before");
    refused(&with(rigid, "pair saddle base rigid"), rigid + 1, "the pair was there before");
    refused(&with(rigid, "pair vise door rigid"), rigid + 1, "part `door` is missing");
    refused(&with(rigid, "pair vise part soft"), rigid + 1, "the pair is not `soft`");
    refused(&with(rigid, "pair vise part rigid indeed"), rigid + 1, "`indeed` is too much");
    refused(&with(rigid, "pair vise part"), rigid + 1, "a word is missing");
    refused(&with(rigid, "pair vise"), rigid + 1, "a word is missing");
    // Reasons that do not hold.
    for why in ["neighbours", "tools", "cutting"] {
        refused(&with(rigid, &format!("pair vise part {why}")), rigid + 1, &format!("the pair is not `{why}`"));
    }
    let neighbours = find(&own, "pair base saddle");
    for why in ["rigid", "tools", "cutting"] {
        refused(&with(neighbours, &format!("pair base saddle {why}")), neighbours + 1, "the pair is not");
    }
    let cutting = find(&own, "pair part mill");
    for why in ["rigid", "tools", "neighbours"] {
        refused(&with(cutting, &format!("pair part mill {why}")), cutting + 1, "the pair is not");
    }
    // A holder is not meant to cut, one joint between a part of the machine and a fixture makes no neighbours.
    for pair in ["part chuck", "chuck part", "mill chuck", "chuck mill", "chuck probe"] {
        refused(&with(rigid, &format!("pair {pair} cutting")), rigid + 1, "the pair is not");
    }
    for pair in ["saddle vise", "vise saddle"] {
        refused(&with(rigid, &format!("pair {pair} neighbours")), rigid + 1, "the pair is not");
    }
    let tools = find(&own, "pair mill probe");
    accepted(&with(tools, "pair mill probe tools"));
    let one = find(&own, "pair mill chuck");
    refused(&with(one, "pair mill chuck tools"), one + 1, "the pair is not");
    for pair in ["chuck base", "base chuck"] {
        refused(&with(one, &format!("pair {pair} tools")), one + 1, "the pair is not");
    }
    // A cutter and the workpiece, with the intervals of a cutter and the vise.
    let examined = find(&own, "pair vise mill");
    refused(&with(examined, "pair base stop examined"), examined + 1, "the pair was there before");
}

#[test]
fn missing_pairs_are_refused() {
    for name in NAMES {
        let own = lines(name);
        let end = own.len() - 1;
        // Without a pair and its intervals.
        let pairs: Vec<usize> = (0..end).filter(|&i| own[i].starts_with("pair ")).chain([end]).collect();
        for pair in pairs.windows(2) {
            let mut lines = own.clone();
            lines.drain(pair[0]..pair[1]);
            refused(&signed(&lines), lines.len(), "pairs of parts are missing");
        }
    }
}

#[test]
fn a_wrong_program_is_refused() {
    for name in NAMES {
        let lines = lines(name);
        let other = NAMES.iter().find(|other| **other != name).unwrap();
        let program = folder(other).join("program.ngc");
        let refusal = check(&signed(&lines), None, Some(&program), MOST_WORK).unwrap_err();
        crate::fixture::assert_refusal(&refusal, find(&lines, "end") + 1, "is not the program of the certificate");
        let refusal = check(&signed(&lines), None, Some(&folder(name).join("none.ngc")), MOST_WORK).unwrap_err();
        crate::fixture::assert_refusal(&refusal, find(&lines, "end") + 1, "none.ngc");
    }
}

#[test]
fn every_line_counts() {
    for name in NAMES {
        let own = lines(name);
        for i in 0..own.len() - 1 {
            let keyword = own[i].split(' ').next().unwrap();
            // Told for readers, compared with files only, or a mesh that is only smaller.
            let is_needed = !["made", "scene", "input", "program", "f", "open"].contains(&keyword);
            let is_needed = is_needed && !["point", "feed", "rapid"].contains(&keyword);
            let mut lines = own.clone();
            lines.remove(i);
            // Of intervals, a plane may hold until the next one's end.
            let is_longer = ["free", "same"].contains(&keyword);
            assert!(!is_needed || is_longer || checked(&signed(&lines)).is_err(), "without {}", own[i]);
            let mut lines = own.clone();
            lines.insert(i, own[i].clone());
            let is_told = ["made", "scene", "input", "program", "tip", "v", "f"].contains(&keyword);
            let is_told = is_told || ["point", "feed", "rapid"].contains(&keyword);
            assert!(is_told || checked(&signed(&lines)).is_err(), "twice {}", own[i]);
            // A word too much is never passed over.
            let mut lines = own.clone();
            lines[i] += " zero";
            assert!(
                ["made", "scene"].contains(&keyword) || checked(&signed(&lines)).unwrap_err().line == i + 1,
                "{}",
                lines[i]
            );
        }
    }
}
