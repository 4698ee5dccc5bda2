//! Certificates written by hand, a rule each.

use crate::fixture::{FACES, accepted, checked, corners, cube, faces, refused, written};
use certificate_checker::check;

const PLAIN: &str = "1 0 0 0 0 0 0";

/// Two cubes of 2 mm, `b` 10 mm above `a`, on a slide that goes up to 30 mm and stands there.
fn cubes(rest: &str) -> String {
    let link = "slide s - 1 0 0 0 0 0 0 Z 0 0 1\n";
    let [a, b] = [
        cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0),
        cube(&format!("b s holder - {PLAIN}"), [0.0, 0.0, 10.0], 1.0),
    ];
    written(&format!("{link}{a}{b}point 0 1\nfeed 3 1 Z 20\npoint 4 1\n{rest}"))
}

/// The line of a certificate, from 1, that begins with these words, its last one.
fn last(text: &str, words: &str) -> usize {
    text.lines().count() - text.lines().rev().position(|line| line.starts_with(words)).unwrap()
}

#[track_caller]
fn refused_at(text: &str, words: &str, why: &str) {
    refused(text, last(text, words), why);
}

#[test]
fn one_plane_for_the_whole_path() {
    let report = accepted(&cubes("pair a b examined\nfree 3 10.000001 p 0 0 16777216 16777217"));
    assert_eq!((report.examined, report.intervals, report.blocks.len()), (1, 1, 3));
    assert!(report.blocks.values().all(|verdict| *verdict == "free"));
    assert!(report.notes.iter().all(|note| note.starts_with("by the certificate's word")) && report.notes.len() == 3);
    // What stands goes nowhere.
    accepted(&cubes("pair a b examined\nfree 1 0 p 0 0 16777216 16777217\nopen 3 0"));
    // At the top of `a`, where rounding decides, and through the bottom of `b`.
    for (z, why) in [(16_777_216, "the first part is not behind"), (150_994_944, "does not part the two")] {
        refused_at(&cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 {z}")), "free", why);
    }
    // A plane without a direction has everything on both sides.
    let nothing = cubes("pair a b examined\nfree 3 10.000001 p 0 0 0 0");
    refused_at(&nothing, "free", "the first part is not behind plane 1");
    // All but the margin of 1e-6 mm, which is 17 steps.
    accepted(&cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 {}", 150_994_944 - 18)));
    let near = cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 {}", 150_994_944 - 16));
    refused_at(&near, "free", "does not part the two");
    // The other way round: all of `b` behind, the plane seen from above.
    accepted(&cubes("pair b a examined\nfree 3 10.000001 p 0 0 -16777216 -150994943"));
}

#[test]
fn halves_are_parted_from_left_to_right() {
    let plane = "p 0 0 16777216 16777217";
    let four = format!("a b {plane} {plane} b {plane} {plane}");
    accepted(&cubes(&format!("pair a b examined\nfree 3 10.000001 {four}")));
    let text = |first: &str, second: &str| cubes(&format!("pair a b examined\nfree 3 10.000001 a {first} {second}"));
    accepted(&text(plane, plane));
    refused_at(&text(plane, ""), "free", "a word is missing");
    refused_at(&text(plane, &format!("{plane} {plane}")), "free", "`p` is too much");
    refused_at(&text(plane, "q 0 0 1 1"), "free", "`q` is neither a plane nor a halving");
    let text = |front: &str| cubes(&format!("pair a b examined\nfree 3 10.000001 {front}"));
    let all = leaves(12, &mut std::iter::repeat_n("p 0 0 1 2".to_owned(), 12));
    accepted(&text(&all));
    let (first, rest) = all.split_once('p').unwrap();
    refused_at(&text(&format!("{first}a p{rest}")), "free", "one triangle is not halved");
    // Faces of `b`; the face at +X has vertices at -1 and at 1 in Y and Z, and is not beyond a plane at X2.
    let below = "p 0 0 16777216 16777217".to_owned();
    let mut planes: Vec<String> = vec![below; 12];
    accepted(&text(&leaves(12, &mut planes.clone().into_iter()).replace('a', "b")));
    planes[3] = "p 16777216 0 0 33554432".to_owned();
    refused_at(&text(&leaves(12, &mut planes.into_iter()).replace('a', "b")), "free", "does not part the two");
}

/// Halvings of `a` down to `count` single faces, with a plane for each.
fn leaves(count: usize, planes: &mut impl Iterator<Item = String>) -> String {
    if count == 1 {
        return planes.next().unwrap();
    }
    let first = leaves(count / 2, planes);
    format!("a {first} {}", leaves(count - count / 2, planes))
}

#[test]
fn planes_before_are_taken_up() {
    let rest = |first: &str| cubes(&format!("pair a b examined\n{first}same 2 10.000001\nsame 3 0.000001"));
    accepted(&rest("free 1 0.000001 p 0 0 16777216 16777217\n"));
    refused_at(&rest(""), "same 2", "there is no front before");
    refused_at(&rest("open 1 0\n"), "same 2", "there is no front before");
    refused_at(&rest("same 1 0.000001\n"), "same 1", "there is no front before");
    // They hold over what is not free as well, and for their pair alone.
    let open = "pair a b examined\nfree 1 0.000001 p 0 0 16777216 16777217\nopen 2 5\nsame 3 0.000001\n";
    let found: Vec<_> = accepted(&cubes(open)).blocks.into_iter().collect();
    assert_eq!(found, [(0, "free"), (3, "unresolved"), (4, "free")]);
    let text = cubes("pair a b examined\nfree 3 10.000001 p 0 0 16777216 16777217\npair b a examined");
    refused_at(&text, "pair b a", "the pair was there before");
}

#[test]
fn the_worst_interval_is_the_verdict_of_a_block() {
    // Two steps of line 3, one of line 4.
    let all = |verdicts: [&str; 3]| {
        let steps = ["free 1 0.000001 p 0 0 16777216 16777217", verdicts[0], verdicts[1], verdicts[2]].join("\n");
        let text = cubes(&format!("pair a b examined\n{steps}"));
        let body = text.replace("point 4 1", "point 3 1\npoint 4 1").replace("bvbench-certificate 3\n", "");
        checked(&written(&body)).map(|report| [report.blocks[&3], report.blocks[&4]]).map_err(|refusal| refusal.why)
    };
    let (two, three, four) = ("same 2 10.000001", "same 3 0.000001", "same 4 0.000001");
    assert_eq!(all([two, three, four]), Ok(["free", "free"]));
    assert_eq!(all([two, "open 3 1", four]), Ok(["unresolved", "free"]));
    assert_eq!(all(["open 2 1", three, four]), Ok(["unresolved", "free"]));
    assert_eq!(all(["open 2 1", three, "open 4 1"]), Ok(["unresolved", "unresolved"]));
    // Over whole steps, all of them are open.
    let whole = cubes("pair a b examined\nopen 2 1\nopen 3 1");
    assert_eq!(accepted(&whole).blocks.into_values().collect::<Vec<_>>(), ["unresolved"; 3]);
    assert_eq!(all(["open 4 1", "", ""]), Err("a word is missing".to_owned()), "an empty line");
}

#[test]
fn what_comes_out_of_order_is_refused() {
    let good = cubes("pair a b examined\nfree 3 10.000001 p 0 0 16777216 16777217");
    for (line, why) in [
        ("made late", "`made` does not belong here"),
        ("link t - 1 0 0 0 0 0 0", "`link` does not belong here"),
        ("v 0 0 0", "`v` does not belong here"),
        ("point 5 1", "`point` does not belong here"),
        ("bvbench-certificate 3", "`bvbench-certificate` does not belong here"),
        ("block 3 free", "`block` does not belong here"),
        ("Free 3 0", "`Free` does not belong here"),
        ("same 3 0", "no such interval of the path"),
        ("", "a word is missing"),
    ] {
        let text = good.replace("\nend", &format!("\n{line}\nend"));
        refused(&text, last(&text, "end") - 1, why);
    }
    for first in ["bvbench-certificate 2\n", "bvbench-certificate 3 or so\n", "made up\n", "\n"] {
        refused(&good.replace("bvbench-certificate 3\n", first), 1, "another version of the format");
    }
    refused("", 1, "the certificate ends without `end`");
    refused(&good.replace("point 0", "dot 0"), last(&good, "point 0"), "no such keyword");
    // What a line needs is not there yet.
    refused("bvbench-certificate 3\nv 0 0 0\n", 2, "no part");
    refused("bvbench-certificate 3\nf 0 0 0\n", 2, "no part");
    for line in ["free 3 0 p 0 0 1 1", "same 3 0", "open 3 0", "hit 3 3 0 0 0"] {
        refused(&format!("bvbench-certificate 3\n{line}\n"), 2, "no pair");
    }
    refused_at(&written(""), "end", "there is no path");
    let text = cubes("open 3 0");
    refused_at(&text, "open", "no pair");
    // Without parts nothing can meet.
    let report = accepted(&written("point 0 1\npoint 2 1"));
    assert_eq!((report.examined, report.blocks.into_values().collect::<Vec<_>>()), (0, vec!["free"; 2]));
}

#[test]
fn statements_that_make_no_sense_are_refused() {
    let head = |line: &str| format!("bvbench-certificate 3\nlink a - {PLAIN}\n{line}\n");
    for (line, why) in [
        ("link a - 1 0 0 0 0 0 0", "link `a` was there before"),
        ("link b c 1 0 0 0 0 0 0", "no link `c`"),
        ("link b - 1 0 0 0 0 0", "a word is missing"),
        ("hinge b - 1 0 0 0 0 0 0 A 0 0 1", "no such keyword"),
        ("link b - 1 0 0 0 0 0 0 A 0 0 1", "`A` is too much"),
        ("link - - 1 0 0 0 0 0 0", "link `-` was there before"),
        ("link b b 1 0 0 0 0 0 0", "no link `b`"),
        ("slide b - 1 0 0 0 0 0 0 Q 0 0 1", "`Q` is not an axis"),
        ("slide b - 1 0 0 0 0 0 0 XY 0 0 1", "`XY` is not an axis"),
        ("slide b - 1 0 0 0 0 0 0 A 0 0 1", "A, B and C turn"),
        ("slide b - 1 0 0 0 0 0 0 C 0 0 1", "A, B and C turn"),
        ("turn b - 1 0 0 0 0 0 0 A 0 0 1", "a word is missing"),
        ("link b - 1 0 0 0 0 0 1000000000000.1", "is not a number up to"),
        ("tip a c 0 0 0 0 0 1", "no link `c`"),
        ("part p - fixture none 1 0 0 0 0 0 0", "`none` is not a whole number"),
        ("part p b fixture - 1 0 0 0 0 0 0", "no link `b`"),
    ] {
        refused(&head(line), 3, why);
    }
    for line in [
        "link b - 0.5 0.5 0 0 0 0 0",
        "slide b - 1 0 0 0 0 0 -1e12 W 0 0 0.0011",
        "tip - a 0 0 0 0 0 1",
        "part p - fixture 7 1 0 0 0 0 0 0",
    ] {
        refused(&head(line), 4, "the certificate ends without `end`");
    }
    let part = cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0);
    let begin = |rest: &str| format!("bvbench-certificate 3\nmade up\n{part}{rest}");
    refused(&begin(&part), 24, "part `a` was there before");
    let empty = format!("part b - fixture - {PLAIN}\nv 0 0 0\npoint 0 1\npair a b rigid\n");
    refused(&begin(&empty), 27, "b: a mesh without a face");
    let second = cube(&format!("b - fixture - {PLAIN}"), [9.0; 3], 1.0);
    for (step, why) in [
        ("feed 0 1 arc X Y 0 0", "a word is missing"),
        ("feed 0 1 arc X Y 0 0 1 2 3", "`2` is not an axis"),
        ("feed 0 1 X", "a word is missing"),
        ("feed 0 1 Q 3", "`Q` is not an axis"),
        ("feed 0", "a word is missing"),
        ("feed 0 1 tip", "a word is missing"),
        ("point -1 1", "is not a whole number"),
    ] {
        refused(&begin(&format!("{second}{step}\n")), 45, why);
    }
    refused(&begin(&format!("{second}pair a b rigid\n")), 45, "there is no path");
}

#[test]
fn names_may_have_any_character_but_not_any_length() {
    let [a, b] =
        ["tool%20no%251", "\u{1f980}%2520%A"].map(|name| cube(&format!("{name} - fixture - {PLAIN}"), [0.0; 3], 1.0));
    let text = written(&format!("made\n{a}{b}point 0 1\npair tool%20no%251 \u{1f980}%2520%A ignored"));
    assert_eq!(accepted(&text).notes[0], "not examined: tool no%1:\u{1f980}%20%A, ignored");
    for (length, why) in [(1000, "the certificate ends without"), (1001, "a name of more than 1000 bytes")] {
        let text = format!("bvbench-certificate 3\nlink {} - {PLAIN}\n", "n".repeat(length));
        refused(&text, if length > 1000 { 2 } else { 3 }, why);
    }
}

#[test]
fn parts_of_a_tool_are_there_with_their_tool() {
    let [a, b] =
        [cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0), cube(&format!("b s holder 2 {PLAIN}"), [0.0; 3], 1.0)];
    let text = |intervals: &str| {
        let moves = "feed 1 1 Z 10\npoint 2 2\npoint 3 3\n";
        written(&format!("slide s - {PLAIN} Z 0 0 1\n{a}{b}{moves}pair a b examined\n{intervals}"))
    };
    let front = "p 0 0 16777216 16777217";
    let blocks = |text: &str| accepted(text).blocks.into_values().collect::<Vec<_>>();
    assert_eq!(blocks(&text(&format!("free 2 0.000001 {front}"))), ["free"; 3]);
    assert_eq!(blocks(&text("open 2 0")), ["free", "unresolved", "free"]);
    refused_at(&text(""), "end", "the pair before does not come to the end of the path");
    // Where it is not there nothing is to be stated.
    refused_at(&text("open 1 0"), "open", "no such interval of the path");
    refused_at(&text("hit 1 1 1 0 0"), "hit", "no such interval of the path");
    refused_at(&text("open 2 0\nopen 3 0"), "open 3", "no such interval of the path");
}

/// A triangle below and a needle that goes down through it on a slide, by 10 mm in line 1. Its edge 0, of the corners 0 and 1, points down.
fn needle(hit: &str) -> String {
    let mm = |x: f64| (x * f64::from(1 << 26)) as i64;
    let v = |x: f64, y: f64, z: f64| format!("v {} {} {}\n", mm(x), mm(y), mm(z));
    let a =
        format!("part a - fixture - {PLAIN}\n{}{}{}f 0 1 2\n", v(0.0, 0.0, 0.0), v(30.0, 0.0, 0.0), v(0.0, 30.0, 0.0));
    let b =
        format!("part b s holder - {PLAIN}\n{}{}{}f 0 1 2\n", v(5.0, 5.0, 12.0), v(5.5, 5.0, 4.0), v(6.0, 6.0, 11.0));
    written(&format!("slide s - {PLAIN} Z 0 0 1\n{a}{b}point 0 1\nfeed 1 1 Z -8\nfeed 2 1 Z 0\n{hit}"))
}

#[test]
fn contact_is_an_edge_through_a_triangle() {
    // The point comes to 0 at half the way.
    let begin = "pair a b examined\nfree 1 0.000001 p 0 0 16777216 1\nsame 1.25 1.000001";
    let hit = |hit: &str| needle(&format!("{begin}\nhit {hit}\nopen 3 0"));
    let found: Vec<_> = accepted(&hit("2 1.75 4.000001 0 0")).blocks.into_iter().collect();
    assert_eq!(found, [(0, "free"), (1, "collision"), (2, "unresolved")]);
    accepted(&hit("2 1.501 2.008001 0 0"));
    // Nor is it the first behind what is open on its step.
    let open = needle(&format!("{begin}\nopen 1.3 0\nsame 1.4 0.400001\nhit 2 1.75 2.800001 0 0\nopen 3 0"));
    refused_at(&open, "hit", "no first contact can be there");
    accepted(&needle(&format!("{begin}\nopen 2 0\nhit 3 2 0.000001 0 0")));
    refused_at(&hit("2 1.499 2.008001 0 0"), "hit", "do not pierce each other");
    for wrong in ["1 0", "0 1", "0 18446744073709551615"] {
        refused_at(&hit(&format!("2 1.75 4.000001 {wrong}")), "hit", "no such triangle");
    }
    // The way from the beginning of the interval to the place is 4 mm.
    refused_at(&hit("2 1.75 3.999999 0 0"), "hit", "the way is not within 3.999999 mm");
    // The interval ends with its step, and the place is in it.
    for wrong in ["1.9 1.75", "3 1.75", "2 2.01", "2 1.24"] {
        let text = hit(&format!("{wrong} 9 0 0"));
        assert!(checked(&text).unwrap_err().line == last(&text, "hit"), "{wrong}");
    }
    accepted(&hit("2 2 6.000001 0 0"));
    // The other way round the needle is the first part.
    let text = needle("pair b a examined\nopen 1 0\nhit 2 1.75 6.000001 0 0\nopen 3 0");
    assert_eq!(accepted(&text).blocks[&1], "collision");
    // Contact may be at the very beginning of a step.
    accepted(&needle(&format!("{begin}\nhit 2 2 6.000001 0 0\nhit 3 2 0 0 0")));
}

#[test]
fn an_edge_beside_the_triangle_pierces_nothing() {
    // Beyond each side of the triangle, by the same steps down.
    let hit = needle("pair a b examined\nopen 1 0\nhit 2 1.75 6.000001 0 0\nopen 3 0");
    let body = hit.replace("bvbench-certificate 3\n", "");
    accepted(&written(&body));
    for at in ["-7 0 0", "0 -7 0", "20 20 0"] {
        let moved =
            written(&body.replace(&format!("part b s holder - {PLAIN}"), &format!("part b s holder - 1 0 0 0 {at}")));
        refused_at(&moved, "hit", "do not pierce each other");
    }
    // Turned inside out it pierces as well.
    accepted(&written(&body.replacen("f 0 1 2", "f 0 2 1", 1)));
}

#[test]
fn any_edge_may_be_the_one_that_pierces() {
    // `b` crosses the border of `a`: one edge of `b` goes through `a`, and one of `a` through `b`; each is at any place of its face.
    let hit =
        needle("pair a b examined\nopen 1 0\nhit 2 1.75 6.000001 0 0\nopen 3 0").replace("bvbench-certificate 3\n", "");
    let part = format!("part b s holder - {PLAIN}");
    let [along_x, along_y] =
        ["0 -5.14 0", "-5.5 0 0"].map(|at| hit.replace(&part, &format!("part b s holder - 1 0 0 0 {at}")));
    let faces = ["f 0 1 2", "f 1 2 0", "f 2 0 1"];
    for text in [along_x, along_y] {
        for (first, second) in faces.iter().flat_map(|first| faces.map(|second| (first, second))) {
            let (before, after) = text.split_once("part b").unwrap();
            let text = format!("{}part b{}", before.replace(faces[0], first), after.replace(faces[0], second));
            accepted(&written(&text));
        }
    }
}

/// `b` inside a closed `a`, parted from it by a plane for each face of `a`; the slide goes 4 mm.
fn nested(a: &str, b: &str, front: &str, rest: &str) -> String {
    written(&format!(
        "slide s - {PLAIN} X 1 0 0\npart a - fixture - {PLAIN}\n{a}part b s holder - {PLAIN}\n{b}point 0 1\nfeed 1 1 X 4\npair a b examined\nfree 1 0.000001 {front}\n{rest}"
    ))
}

/// Each face of a cube about a centre from what is inside it.
fn from_inside(centre: [f64; 3], half: f64) -> Vec<String> {
    let side = |face: usize| {
        let (axis, is_high) = (face / 4, face % 4 >= 2);
        let mut normal = [0; 3];
        normal[axis] = if is_high { -1 } else { 1 } << 24;
        let at = if is_high { -(centre[axis] + half) } else { centre[axis] - half };
        let [x, y, z] = normal;
        format!("p {x} {y} {z} {}", (at * 16_777_216.0) as i64 + 1)
    };
    (0..FACES.len()).map(side).collect()
}

#[test]
fn a_part_inside_the_other_is_not_free() {
    let (a, b) = (corners([0.0; 3], 20.0) + &faces(0, false), corners([1.0, 2.0, 3.0], 2.0) + &faces(0, false));
    let front = leaves(12, &mut from_inside([0.0; 3], 20.0).into_iter());
    let inside = "before this line one part may be inside the other";
    let end = "same 2 2.000001";
    refused_at(&nested(&a, &b, &front, end), "end", inside);
    // Far from the origin as well.
    let far = [100.0, -200.0, 300.0];
    let (c, d) = (corners(far, 20.0) + &faces(0, false), corners([101.0, -198.0, 303.0], 2.0) + &faces(0, false));
    refused_at(&nested(&c, &d, &leaves(12, &mut from_inside(far, 20.0).into_iter()), end), "end", inside);
    // Before each line that is no free interval.
    refused_at(&nested(&a, &b, &front, "open 2 0"), "open", inside);
    refused_at(&nested(&a, &b, &front, "pair a b rigid"), "pair a b rigid", inside);
    // The same, with the parts' names swapped.
    let swapped = nested(&b, &a, &front.replace('a', "b"), end);
    assert!(checked(&swapped).is_err());
    // With a face missing, or one turned over, there is no inside, and only what is beyond the box of `a` is known to be outside.
    let without = |face: usize| {
        let [i, j, k] = FACES[face];
        let mut planes = from_inside([0.0; 3], 20.0);
        planes.remove(face);
        (a.replacen(&format!("f {i} {j} {k}\n"), "", 1), leaves(11, &mut planes.into_iter()))
    };
    for (open, front) in (0..FACES.len()).map(without) {
        refused_at(&nested(&open, &b, &front, end), "end", inside);
    }
    let (open, _) = without(0);
    let turned = a.replacen("f 0 1 3\n", "f 1 0 3\n", 1);
    refused_at(&nested(&turned, &b, &front, end), "end", inside);
    // Above it, and below.
    for side in [1, -1] {
        let beyond = corners([1.0, 2.0, 30.0 * f64::from(side)], 2.0) + &faces(0, false);
        for (a, count) in [(&open, 11), (&turned, 12)] {
            let planes = vec![format!("p 0 0 {} 335544321", side << 24); count];
            accepted(&nested(a, &beyond, &leaves(count, &mut planes.into_iter()), end));
        }
    }
    // Whatever has no area hides no inside: a face with a corner twice, or two that are each other's reverse. Vertices in one place are one, so that faces with
    // vertices of their own hide it no better.
    let mut planes = from_inside([0.0; 3], 20.0);
    planes.splice(0..0, [planes[0].clone(), planes[0].clone()]);
    for flat in ["f 0 1 0\nf 0 1 1", "f 0 1 2\nf 2 1 0"] {
        let more = corners([0.0; 3], 20.0) + &format!("{flat}\n{}", faces(0, false));
        refused_at(&nested(&more, &b, &leaves(14, &mut planes.clone().into_iter()), end), "end", inside);
    }
    let corner: Vec<String> = corners([0.0; 3], 20.0).lines().map(|line| line.to_owned() + "\n").collect();
    let apart: String = FACES.iter().flatten().map(|&corner_of_face| corner[corner_of_face].as_str()).collect();
    let own: String =
        (0..FACES.len()).map(|face| format!("f {} {} {}\n", 3 * face, 3 * face + 1, 3 * face + 2)).collect();
    refused_at(&nested(&(apart + &own), &b, &front, end), "end", inside);
    // In a cavity it is not in the solid.
    let hollow = corners([0.0; 3], 30.0) + &corners([0.0; 3], 20.0) + &faces(8, true) + &faces(0, false);
    let planes: Vec<String> = [from_inside([0.0; 3], 20.0), from_inside([0.0; 3], 30.0)].concat();
    accepted(&nested(&hollow, &b, &leaves(24, &mut planes.clone().into_iter()), end));
    // Inside out, it is as hollow.
    let inside_out = corners([0.0; 3], 30.0) + &corners([0.0; 3], 20.0) + &faces(8, false) + &faces(0, true);
    accepted(&nested(&inside_out, &b, &leaves(24, &mut planes.clone().into_iter()), end));
    // A body of the other winding is no cavity, smaller or larger, wherever it is: in both, and in that body alone.
    for ([x, y, z], half) in [([0.0; 3], 15.0), ([0.0; 3], 25.0), (far, 15.0), (far, 25.0)] {
        let (first, second) = ([x, y, z], [x, y + 12.0, z]);
        let mixed = corners(first, 20.0) + &corners(second, half) + &faces(0, false) + &faces(8, true);
        let beyond = vec![format!("p 0 16777216 0 {}", ((y + 20.0) * 16_777_216.0) as i64 + 1); 12];
        for (by, planes) in [(2.0, from_inside(first, 20.0)), (23.5, beyond)] {
            let b = corners([x + 1.0, y + by, z + 3.0], 2.0) + &faces(0, false);
            let planes = [planes, from_inside(second, half)].concat();
            refused_at(&nested(&mixed, &b, &leaves(24, &mut planes.into_iter()), end), "end", inside);
        }
    }
    // With a cavity that is no cavity, it is.
    let solid = corners([0.0; 3], 30.0) + &corners([0.0; 3], 20.0) + &faces(8, false) + &faces(0, false);
    refused_at(&nested(&solid, &b, &leaves(24, &mut planes.into_iter()), end), "end", inside);
}

#[test]
fn a_small_jump_on_a_long_lever_is_refused() {
    // A cube of 0.02 mm that turns about a line 1 km away comes along X to 0.05 mm beside `a`; the arc ends 0.9e-10 rad, or 0.09 mm, beside the next move.
    let a = cube(&format!("a - fixture - {PLAIN}"), [-10.0, 0.0, 0.0], 10.0);
    let b = cube(&format!("b t holder - {PLAIN}"), [0.05, 0.0, 0.0], 0.01);
    let moves = "point 0 1 A -1e-9\nfeed 1 1 A 0.9e-10 B 1e-9 arc A B 0 0 -1.5707963267948966\npoint 2 1\n";
    let text = |arc: &str| {
        let moves = moves.replace("A 0.9e-10", arc);
        let free = "free 1.5 1 p 16777216 0 0 1\nsame 2 1\nsame 3 1";
        written(&format!("turn t - {PLAIN} A 0 0 1 0 -1000000000 0\n{a}{b}{moves}pair a b examined\nopen 1 0\n{free}"))
    };
    accepted(&text("A 0"));
    refused_at(&text("A 0.9e-10"), "pair a b", "the path jumps at move 2, of line 2");
}

/// A holder that comes from above and feeds down between two open cubes, then makes a move more, and one of 1 mm up.
fn between_open_cubes(more: &str, intervals: &str) -> String {
    let slides = format!("slide x - {PLAIN} X 1 0 0\nslide y x {PLAIN} Y 0 1 0\nslide z y {PLAIN} Z 0 0 1\n");
    let open = |first: usize| faces(first, false).split_inclusive('\n').skip(1).collect::<String>();
    let cubes = corners([-20.0, 0.0, 0.0], 9.0) + &corners([20.0, 0.0, 0.0], 9.0) + &open(0) + &open(8);
    let b = cube(&format!("b z holder - {PLAIN}"), [0.0; 3], 2.0);
    written(&format!(
        "{slides}tip z - 0 0 0 0 0 -1\npart a - fixture - {PLAIN}\n{cubes}{b}point 0 1 Z 40\nfeed 1 1 Z 0\n{more}\nfeed 3 1 Z 1\npair a b examined\n{intervals}"
    ))
}

#[test]
fn a_stretch_goes_on_behind_an_arc_and_where_the_tip_begins_to_be_followed() {
    // The holder is above both cubes at first; beside them it is within their box, and a plane parts it from each.
    let above = "free 1 0.000001 p 0 0 16777216 159383552";
    let beside = "free 2 20.000001 a p 16777216 0 0 -167772160 p -16777216 0 0 -167772160";
    let inside = "before this line one part may be inside the other";
    for more in ["feed 2 1", "feed 2 1 arc X Z 1 0 -6.283185307179586", "feed 2 1 tip 0", "feed 2 1 X 1 tip 0"] {
        accepted(&between_open_cubes(more, &format!("{above}\n{beside}\nsame 3 5\nsame 4 5")));
        accepted(&between_open_cubes(more, &format!("{above}\n{beside}\nsame 4 20")));
        // What was above is not known of what follows on an open interval.
        let open = format!("{above}\nopen 2 0\n{}\nsame 4 5", beside.replace("free 2 20.000001", "free 3 5"));
        refused_at(&between_open_cubes(more, &open), "end", inside);
    }
}

#[test]
fn a_plane_that_parts_all_counts_for_what_was_before() {
    // Between the cubes at first, above them in the end.
    let beside = "free 2.25 5.000001 a p 16777216 0 0 -167772160 p -16777216 0 0 -167772160\nsame 3 15.000001";
    let text = |end: &str| between_open_cubes("feed 2 1 Z 40", &format!("open 1 0\nopen 2 0\n{beside}\n{end}open 4 0"));
    accepted(&text("free 3.25 5 p 0 0 16777216 159383552\n"));
    refused_at(&text(""), "open 4", "before this line one part may be inside the other");
}

#[test]
fn what_has_no_volume_may_be_inside_as_well() {
    // Half of `b` are faces in one point within `a`, the rest is a cube beside it.
    let a = corners([0.0; 3], 20.0) + &faces(0, false);
    let text = |x: i64| {
        let points = format!("v {} {} {}\n{}", x << 26, 2 << 26, 3 << 26, "f 8 8 8\n".repeat(12));
        let b = corners([100.0, 0.0, 0.0], 2.0) + &points + &faces(0, false);
        let beyond = "p 16777216 0 0 335544321".to_owned();
        let first = if x < 20 { from_inside([0.0; 3], 20.0) } else { vec![beyond.clone(); 12] };
        let front = format!("b {} {beyond}", leaves(12, &mut first.into_iter()));
        nested(&a, &b, &front, "same 2 2.000001")
    };
    refused_at(&text(1), "end", "before this line one part may be inside the other");
    accepted(&text(40));
}

#[test]
fn slides_in_one_plane_place_no_tip() {
    let cubes =
        [("a -", 0.0), ("b z", 9.0)].map(|(part, at)| cube(&format!("{part} holder - {PLAIN}"), [at; 3], 1.0)).concat();
    for (tilt, why) in [
        (0.005, "the way cannot be bounded"),
        (-0.005, "the way cannot be bounded"),
        (0.02, "do not pierce each other"),
        (-0.02, "do not pierce each other"),
    ] {
        let slides = format!("slide x - {PLAIN} X 1 0 0\nslide y x {PLAIN} Y 0 1 0\nslide z y {PLAIN} Z 1 0 {tilt}\n");
        let moves = "point 0 1 tip 0\nfeed 1 1 Y 1 tip 0\n";
        let hit = "pair a b examined\nopen 1 0\nhit 2 1 0 0 0";
        refused_at(&written(&format!("{slides}tip z - 0 0 0 0 0 -1\n{cubes}{moves}{hit}")), "hit", why);
    }
}

#[test]
fn bodies_that_touch_have_an_inside() {
    // Two cubes with one edge in common, four faces of which pass along it; or with one side, whose faces are there both ways.
    let inside = "before this line one part may be inside the other";
    let b = corners([1.0, 2.0, 3.0], 2.0) + &faces(0, false);
    for centre in [[40.0, 40.0, 0.0], [40.0, 0.0, 0.0]] {
        let a = corners([0.0; 3], 20.0) + &corners(centre, 20.0) + &faces(0, false) + &faces(8, false);
        let mut planes = from_inside([0.0; 3], 20.0);
        planes.extend(vec!["p -16777216 0 0 -335544319".to_owned(); 12]);
        let front = leaves(24, &mut planes.into_iter());
        refused_at(&nested(&a, &b, &front, "same 2 2.000001"), "end", inside);
        let above = corners([1.0, 2.0, 30.0], 2.0) + &faces(0, false);
        let front = leaves(24, &mut vec!["p 0 0 16777216 335544321".to_owned(); 24].into_iter());
        accepted(&nested(&a, &above, &front, "same 2 2.000001"));
    }
}

#[test]
fn neighbours_are_of_the_structure() {
    // The parts of a tool have no bearings, and other tools are not there together.
    let text = |a: &str, b: &str, why: &str| {
        let [a, b] =
            [cube(&format!("a - {a} {PLAIN}"), [0.0; 3], 1.0), cube(&format!("b s {b} {PLAIN}"), [9.0; 3], 1.0)];
        written(&format!("slide s - {PLAIN} Z 0 0 1\n{a}{b}point 0 1\npair a b {why}\n"))
    };
    accepted(&text("machine -", "machine -", "neighbours"));
    for (a, b) in [("machine 1", "machine -"), ("machine -", "machine 1"), ("holder -", "machine -")] {
        refused_at(&text(a, b, "neighbours"), "pair", "the pair is not `neighbours`");
    }
    // One joint is between them: not none, nor two of one chain or of both.
    for (parent, link_a, link_b) in [("s", "-", "-"), ("s", "-", "t"), ("-", "s", "t")] {
        let slides = format!("slide s - {PLAIN} Z 0 0 1\nslide t {parent} {PLAIN} X 1 0 0\n");
        let [a, b] = [("a", link_a, [0.0; 3]), ("b", link_b, [9.0; 3])]
            .map(|(name, link, at)| cube(&format!("{name} {link} machine - {PLAIN}"), at, 1.0));
        let text = written(&format!("{slides}{a}{b}point 0 1\npair a b neighbours\n"));
        refused_at(&text, "pair", "the pair is not `neighbours`");
    }
    accepted(&text("holder 1", "holder 2", "tools"));
    for (a, b) in [("holder 1", "holder -"), ("holder -", "holder 1"), ("holder 1", "holder 1")] {
        refused_at(&text(a, b, "tools"), "pair", "the pair is not `tools`");
    }
}

#[test]
fn every_component_counts() {
    let a = corners([0.0; 3], 20.0) + &faces(0, false);
    // Cubes of `b` inside, or above; a half of `b` each.
    let two = |low: f64, high: f64| {
        let [low, high] = [low, high].map(|z| corners([1.0, 2.0, z], 2.0));
        format!("{low}{high}{}{}", faces(0, false), faces(8, false))
    };
    let above = "p 0 0 16777216 335544321".to_owned();
    let front = leaves(12, &mut from_inside([0.0; 3], 20.0).into_iter());
    let end = "same 2 2.000001";
    let inside = "before this line one part may be inside the other";
    accepted(&nested(&a, &two(30.0, 40.0), &format!("b {above} {above}"), end));
    refused_at(&nested(&a, &two(0.0, 40.0), &format!("b {front} {above}"), end), "end", inside);
    refused_at(&nested(&a, &two(30.0, 0.0), &format!("b {above} {front}"), end), "end", inside);
    // As the first part, the cubes have the other inside one of them.
    let mut planes = from_inside([0.0; 3], 20.0);
    planes.extend(vec!["p 0 0 -16777216 -503316479".to_owned(); 12]);
    let cubes = corners([0.0; 3], 20.0) + &corners([0.0, 0.0, 35.0], 5.0) + &faces(0, false) + &faces(8, false);
    let b = corners([1.0, 2.0, 3.0], 2.0) + &faces(0, false);
    refused_at(&nested(&cubes, &b, &leaves(24, &mut planes.into_iter()), end), "end", inside);
}

#[test]
fn beside_a_concave_part_is_not_inside() {
    // A room of five cubes without a ceiling and a wall: `b` is in its box, and in none of them.
    let walls = [[-20.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, -20.0, 0.0], [0.0, 20.0, 0.0], [0.0, 0.0, -20.0]];
    let vertices: String = walls.iter().map(|&wall| corners(wall, 9.0)).collect();
    let a = vertices + &(0..5).map(|i| faces(8 * i, false)).collect::<String>();
    let sides = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]];
    let planes = sides.iter().flat_map(|side| {
        let [x, y, z] = side.map(|x| x << 24);
        vec![format!("p {x} {y} {z} {}", (-11_i64 << 24) + 1); 12]
    });
    let front = leaves(60, &mut planes.collect::<Vec<_>>().into_iter());
    let end = "same 2 2.000001";
    for centre in [[1.0, 2.0, 3.0], [-6.0, 5.0, 5.0], [2.0, -7.0, -7.0]] {
        let b = corners(centre, 2.0) + &faces(0, false);
        accepted(&nested(&a, &b, &front, end));
        // As the first of the pair as well.
        let text = nested(&a, &b, &front, end);
        assert!(text.contains("pair a b examined"));
    }
}

#[test]
fn a_ray_is_followed_to_where_it_leaves() {
    // A prism whose side at X20 is divided at Y2.5: the ray from the first vertex of `b` at Y2.4 leaves through the upper part.
    let mm = |x: f64| (x * f64::from(1 << 26)) as i64;
    let outline = [[-20.0, -20.0], [20.0, -20.0], [20.0, 2.5], [20.0, 20.0], [-20.0, 20.0]];
    let ring = |z: f64| outline.map(|[x, y]| format!("v {} {} {}\n", mm(x), mm(y), mm(z))).concat();
    let sides =
        (0..5).map(|i| (i, (i + 1) % 5)).map(|(i, j)| format!("f {i} {j} {}\nf {i} {} {}\n", j + 5, j + 5, i + 5));
    let caps = (1..4).map(|i| format!("f 0 {} {i}\nf 5 {} {}\n", i + 1, i + 5, i + 6));
    let a = ring(-20.0) + &ring(20.0) + &sides.collect::<String>() + &caps.collect::<String>();
    let planes = [[0, 1, 0], [-1, 0, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0]].into_iter().flat_map(|side| [side; 2]);
    let planes = planes.chain([[0, 0, 1], [0, 0, -1]].into_iter().cycle().take(6));
    let planes = planes.map(|[x, y, z]| format!("p {} {} {} -335544319", x << 24, y << 24, z << 24));
    let front = leaves(16, &mut planes.collect::<Vec<_>>().into_iter());
    let b = corners([1.0, 4.4, 3.0], 2.0) + &faces(0, false);
    let text = nested(&a, &b, &front, "same 2 2.000001");
    refused_at(&text, "end", "before this line one part may be inside the other");
}

#[test]
fn a_face_behind_the_beginning_of_a_ray_is_not_crossed() {
    // A tetrahedron below X + Y + Z = -20, within 20 mm of the origin along each axis; the ray goes to +X.
    let mm = |x: i64| x << 26;
    let vertex = |[x, y, z]: [i64; 3]| format!("v {} {} {}\n", mm(x), mm(y), mm(z));
    let corners_of = [[-20, -20, -20], [20, -20, -20], [-20, 20, -20], [-20, -20, 20]];
    let a = corners_of.map(vertex).concat() + "f 0 2 1\nf 0 1 3\nf 0 3 2\nf 1 2 3\n";
    let front = leaves(4, &mut vec!["p 16777216 16777216 16777216 -335544319".to_owned(); 4].into_iter());
    let end = "same 2 2.000001";
    for centre in [[0.0, -5.0, -5.0], [5.0, -9.0, -4.0]] {
        accepted(&nested(&a, &(corners(centre, 2.0) + &faces(0, false)), &front, end));
    }
}

#[test]
fn one_plane_at_some_time_shows_that_neither_is_inside() {
    // At first a plane for each face of `a`, then one plane for all of it: the cube is beside it.
    let a = corners([0.0; 3], 20.0) + &faces(0, false);
    let b = corners([30.0, 0.0, 0.0], 2.0) + &faces(0, false);
    let front = leaves(12, &mut vec!["p 16777216 0 0 335544321".to_owned(); 12].into_iter());
    accepted(&nested(&a, &b, &front, "same 2 2.000001"));
    accepted(&nested(&a, &b, &front, "free 2 2.000001 p 16777216 0 0 335544321"));
    accepted(&nested(&a, &b, "p 16777216 0 0 335544321", "same 2 2.000001"));
}

/// The same two as workpiece and cutter: the cutter feeds into the workpiece, stands, and goes back at rapid rate.
fn cutting(moves: &str, intervals: &str) -> String {
    let link = "slide s - 1 0 0 0 0 0 0 Z 0 0 1\n";
    let [a, b] = [
        cube(&format!("a - workpiece - {PLAIN}"), [0.0; 3], 1.0),
        cube(&format!("b s cutter - {PLAIN}"), [0.0, 0.0, 10.0], 1.0),
    ];
    written(&format!("{link}{a}{b}point 0 1\n{moves}pair a b {intervals}"))
}

#[test]
fn a_cutter_may_be_in_the_workpiece_where_it_feeds() {
    let moves = "feed 1 1 Z -10\npoint 2 1\nrapid 3 1 Z 0\n";
    let free = "free 1 0.000001 p 0 0 16777216 16777217";
    let blocks = |text: &str| accepted(text).blocks.into_values().collect::<Vec<_>>();
    let text = cutting(moves, &format!("cutting\n{free}\nopen 4 0"));
    // What is open is neither free nor unresolved.
    assert_eq!(blocks(&text), ["free", "free", "free", "stock"]);
    let report = accepted(&text);
    assert_eq!((report.examined, report.intervals), (1, 1));
    assert_eq!(report.cutting.into_iter().collect::<Vec<_>>(), [1]);
    assert!(report.notes.contains(&"at rapids alone, against the whole workpiece: a:b".to_owned()));
    // In pieces of steps as well, and an arc is a feed.
    accepted(&cutting(moves, &format!("cutting\n{free}\nopen 3.5 0\nopen 4 0")));
    let arc = moves.replace("feed 1 1 Z -10", "feed 1 1 X 2 Z -10 arc X Z 1 -5 3.2");
    let text = cutting(&arc, &format!("cutting\n{free}\nopen 4 0"));
    refused_at(&text, "pair", "the path jumps");
    // Not at a rapid, nor at the start.
    refused_at(&cutting(moves, &format!("cutting\n{free}\n")), "end", "does not come to the end of the path");
    assert_eq!(blocks(&cutting(moves, "cutting\nopen 1 0\nopen 4 0")), ["stock", "free", "free", "stock"]);
    assert_eq!(blocks(&cutting(moves, "cutting\nopen 4 0")), ["stock"; 4]);
    // A change of tools brings a tool to where it was not before.
    let changed = moves.replace("point 2 1", "point 2 2");
    let text = cutting(&changed, &format!("cutting\n{free}\nopen 3 0\nopen 4 0"));
    assert_eq!(blocks(&text), ["free", "free", "stock", "stock"]);
    let kept = changed.replace("rapid 3 1", "rapid 3 2");
    assert_eq!(blocks(&cutting(&kept, &format!("cutting\n{free}\nopen 3 0\nopen 4 0")))[2], "stock");
    // What stands after a rapid, at the start, or behind a point after a change of tools, no feed has brought there.
    let behind = moves.replace("rapid 3 1 Z 0\n", "rapid 3 1 Z 0\npoint 4 1\n");
    let opened = format!("cutting\n{free}\nopen 5 0");
    assert_eq!(blocks(&cutting(&behind, &opened)), ["free", "free", "free", "stock", "stock"]);
    refused_at(&cutting(&behind, &format!("cutting\n{free}\nopen 4 0")), "end", "does not come to the end of the path");
    assert_eq!(blocks(&cutting("point 1 1\n", "cutting\nopen 2 0")), ["stock"; 2]);
    assert!(accepted(&cutting("point 1 1\n", "cutting\nopen 2 0")).cutting.is_empty());
    let twice = changed.replace("rapid 3 1 Z 0\n", "point 3 2\nrapid 4 2 Z 0\n");
    assert_eq!(blocks(&cutting(&twice, &opened)), ["free", "free", "stock", "stock", "stock"]);
    // A tool that is not there does not cut.
    let away = text.replace("b s cutter -", "b s cutter 2").replace("bvbench-certificate 3\n", "");
    let report = accepted(&written(&away.replace(&format!("{free}\nopen 3 0\nopen 4 0\n"), "open 3 0\n")));
    assert!(report.cutting.is_empty(), "{:?}", report.cutting);
    // To touch the whole workpiece is not to touch what is left of it.
    let hit = format!("cutting\n{free}\nhit 4 3.5 10 0 0");
    refused_at(&cutting(moves, &hit), "hit", "what is left of the workpiece");
    // An examined pair has no such contact, and no other two parts are cutter and workpiece.
    let text = cutting(moves, &format!("examined\n{free}\nopen 4 0"));
    assert_eq!(blocks(&text), ["free", "unresolved", "unresolved", "unresolved"]);
    refused_at(&cubes("pair a b cutting\n"), "pair", "the pair is not `cutting`");
}

/// Two flights of `count` triangles along X = Y, 1 mm apart, with a plane for each triangle of the one, which is beside every box but the smallest of the other;
/// and `count` steps on which they stand.
fn flights(count: usize) -> String {
    let mm = |x: f64| (x * f64::from(1 << 26)) as i64;
    let stair = |i: usize, shift: f64| {
        let [x, y] = [i as f64 * 0.5, i as f64 * 0.5 + shift].map(mm);
        let half = mm(0.25);
        format!("v {x} {y} 0\nv {} {y} 0\nv {} {y} {half}\n", x + half, x + half)
    };
    let mesh = |shift: f64| {
        let faces = (0..count).map(|i| format!("f {} {} {}\n", 3 * i, 3 * i + 1, 3 * i + 2));
        (0..count).map(|i| stair(i, shift)).chain(faces).collect::<String>()
    };
    let front = leaves(count, &mut std::iter::repeat_n("p 16777216 -16777216 0 -4194304".to_owned(), count));
    let same: String = (2..count).map(|to| format!("same {to} 0.000001\n")).collect();
    // Open meshes are outside one another where one plane parts them.
    let last = format!("free {count} 0.000001 p 16777216 -16777216 0 -4194304");
    written(&format!(
        "slide s - {PLAIN} X 1 0 0\npart a - fixture - {PLAIN}\n{}part b s holder - {PLAIN}\n{}{}pair a b examined\nfree 1 0.000001 {front}\n{same}{last}",
        mesh(1.0),
        mesh(0.0),
        "point 0 1\n".repeat(count)
    ))
}

#[test]
fn what_takes_too_many_steps_to_check_is_refused() {
    // 66 kB, for which every box of the one is beside every plane in every step.
    let text = flights(256);
    let work = accepted(&text).work;
    assert!(text.len() < 70_000 && work > 256 * 256 * 256, "{work} of {}", text.len());
    let refusal = check(&text, None, None, 1_000_000).unwrap_err();
    let at = last(&text, "same 2 ")..last(&text, "same 20 ");
    assert!(at.contains(&refusal.line), "{refusal:?}");
    assert_eq!(refusal.why, "it takes more than 1000000 steps to check");
    // The last step is one.
    let small = flights(8);
    let work = accepted(&small).work;
    assert!(check(&small, None, None, work + 1).is_ok());
    assert_eq!(check(&small, None, None, work).unwrap_err().line, small.lines().count());
}

#[test]
fn links_and_ways_are_counted() {
    // A hundred links, which each of a hundred steps and each interval that is proved places.
    let links: String = (0..100).map(|i| format!("link l{i} - {PLAIN}\n")).collect();
    let steps = "point 0 1\n".repeat(100);
    let work = accepted(&written(&format!("{links}{steps}"))).work;
    assert!(work > 30 * 100 * 100, "{work}");
    let cubes =
        cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0) + &cube(&format!("b s holder - {PLAIN}"), [9.0; 3], 1.0);
    let parts = format!("{links}slide s - {PLAIN} X 1 0 0\n{cubes}{steps}pair a b examined\n");
    let free = "free 1 0.000001 p 0 0 16777216 33554432\n";
    let same: String = (2..=100).map(|to| format!("same {to} 0.000001\n")).collect();
    let [few, many] =
        ["same 100 0.000001\n", &same].map(|same| accepted(&written(&format!("{parts}{free}{same}"))).work);
    assert!(many > few + 30 * 98 * 100, "{many}, {few}");
    // So do both ends and the middle of a jump; and three times each step and each interval on which the tip is followed.
    let slides = format!(
        "slide x - {PLAIN} X 1 0 0\nslide y x {PLAIN} Y 0 1 0\nslide z y {PLAIN} Z 0 0 1\ntip z - 0 0 0 0 0 -1\n"
    );
    let of = |second: &str, intervals: &str| {
        let moves = format!("point 0 1\npoint 1 1\n{second}\n");
        let parts = format!("{links}{slides}slide s - {PLAIN} X 1 0 0\n{cubes}{moves}pair a b examined\n");
        accepted(&written(&format!("{parts}{intervals}"))).work
    };
    let all_free = format!("{free}same 2 0.000001\nsame 3 0.000001");
    let plain = of("point 2 1", "open 3 0");
    assert!(of("point 2 1 X 1e-9", "open 3 0") > plain + 3 * 30 * 100);
    // Where the tip begins to be followed is a jump as well.
    assert!(of("point 2 1 tip 0", "open 3 0") > plain + (2 + 3 + 2) * 30 * 100);
    assert!(of("point 2 1 tip 0", &all_free) > of("point 2 1", &all_free) + (2 + 2 + 3 + 2) * 30 * 100);
    // So does each pair, from either part up to where the two ways meet: behind two slides, and behind one.
    let chain = format!(
        "{links}slide s - {PLAIN} X 1 0 0\nslide t s {PLAIN} Y 0 1 0\nlink u l99 {PLAIN}\nslide w u {PLAIN} Z 0 0 1\n"
    );
    let parts =
        ["t", "w", "s", "u"].map(|link| cube(&format!("{link} {link} machine - {PLAIN}"), [0.0; 3], 1.0)).concat();
    let pairs = |why: [&str; 6]| {
        let pairs = ["t w", "t s", "t u", "w s", "w u", "s u"];
        let lines: String = pairs.iter().zip(why).map(|(pair, why)| format!("pair {pair} {why}\n")).collect();
        checked(&written(&format!("{chain}{parts}point 0 1\n{lines}"))).map_err(|refusal| refusal.why)
    };
    let why = ["ignored", "neighbours", "ignored", "ignored", "neighbours", "neighbours"];
    let work = pairs(why).unwrap().work;
    assert!((6 * 100..6 * 1000).contains(&work), "{work}");
    for (at, wrong) in
        [(0, "neighbours"), (1, "rigid"), (2, "neighbours"), (3, "neighbours"), (4, "rigid"), (5, "rigid")]
    {
        let mut why = why;
        why[at] = wrong;
        assert_eq!(pairs(why).unwrap_err(), format!("the pair is not `{wrong}`"));
    }
    // A plane is taken up with each way of a motion: over whole steps each axis has one.
    let axes = "rapid 0 1 X 1 Y 1 Z 1 U 1 V 1 W 1\nrapid 0 1 X 0 Y 0 Z 0 U 0 V 0 W 0\n";
    let slides: String = ["- X", "X Y", "Y Z", "Z U", "U V", "V W"]
        .map(|names| names.split_once(' ').unwrap())
        .map(|(parent, axis)| format!("slide {axis} {parent} {PLAIN} {axis} 1 0 0\n"))
        .concat();
    let a = cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0);
    let b = cube(&format!("b W holder - {PLAIN}"), [0.0, 0.0, 9.0], 1.0);
    let front = leaves(12, &mut vec!["p 0 0 16777216 16777217".to_owned(); 12].into_iter());
    let text = |axes: &str| written(&format!("{slides}{a}{b}{axes}pair a b examined\nfree 2 100 {front}\n"));
    let [moving, standing] = [axes, "point 0 1\npoint 0 1\n"].map(|axes| accepted(&text(axes)).work);
    assert_eq!(moving, standing + 12 * 2 * 6);
}

#[test]
fn a_line_takes_as_many_steps_however_many_parts_there_are() {
    // A plate of pins: each line names two of them.
    let text = |count: usize| {
        let pins = (0..count).map(|i| cube(&format!("p{i} - fixture - {PLAIN}"), [4.0 * i as f64, 0.0, 0.0], 1.0));
        let pairs = (0..count).flat_map(|i| (0..i).map(move |j| format!("pair p{i} p{j} rigid\n")));
        written(&format!("{}point 0 1\n{}", pins.collect::<String>(), pairs.collect::<String>()))
    };
    for count in [20, 200] {
        let text = text(count);
        let (work, lines) = (accepted(&text).work, text.lines().count() as u64);
        assert!(lines <= work && work < lines + 100, "{count} pins: {work} steps for {lines} lines");
    }
}

#[test]
fn rays_are_counted() {
    // Cubes beside cubes, each of which has a ray for each stretch; between these the two are open.
    let cubes = |x: f64| {
        let vertices: String = (0..50).map(|i| corners([x, 0.0, 4.0 * f64::from(i)], 1.0)).collect();
        vertices + &(0..50).map(|i| faces(8 * i, false)).collect::<String>()
    };
    let front = format!("a {0} {0}", "p 16777216 0 0 67108864");
    let stretches: String = (1..100).map(|i| format!("free {} 1 {front}\nopen {} 0\n", 2 * i, 2 * i + 1)).collect();
    let text = |stretches: &str, steps: usize| {
        let parts = format!("part a - fixture - {PLAIN}\n{}part b s holder - {PLAIN}\n{}", cubes(0.0), cubes(9.0));
        let moves = "point 0 1\n".repeat(steps);
        written(&format!("slide s - {PLAIN} X 1 0 0\n{parts}{moves}pair a b examined\nopen 1 0\n{stretches}"))
    };
    let work = accepted(&text(&stretches, 199)).work;
    // Without the stretches, which have a hundred rays each.
    let without = accepted(&text("open 199 0", 199)).work;
    assert!(work > without + 99 * 100, "{work}, {without}");
}

#[test]
fn faces_beside_rays_are_counted() {
    // Between two closed cubes, or above them: between them, each stretch has a ray through the four faces across it.
    let a = corners([-20.0, 0.0, 0.0], 9.0) + &corners([20.0, 0.0, 0.0], 9.0) + &faces(0, false) + &faces(8, false);
    let front = "a p 16777216 0 0 -167772160 p -16777216 0 0 -167772160";
    let stretches: String = (1..100).map(|i| format!("free {} 1 {front}\nopen {} 0\n", 2 * i, 2 * i + 1)).collect();
    let work = |z: f64| {
        let b = cube(&format!("b s holder - {PLAIN}"), [0.0, 0.0, z], 2.0);
        let moves = "point 0 1\n".repeat(199);
        let parts = format!("slide s - {PLAIN} X 1 0 0\npart a - fixture - {PLAIN}\n{a}{b}{moves}");
        accepted(&written(&format!("{parts}pair a b examined\nopen 1 0\n{stretches}"))).work
    };
    let [between, above] = [0.0, 40.0].map(work);
    assert!(between > above + 99 * 4 * 10, "{between}, {above}");
}
