//! Certificates written by hand, a rule each.

use crate::fixture::{FACES, accepted, assert_refusal, checked, corners, cube, faces, refused, written};

const PLAIN: &str = "1 0 0 0 0 0 0";

/// Two cubes of 2 mm, `b` 10 mm above `a`, on a slide that goes up to 30 mm and stands there.
fn cubes(rest: &str) -> String {
    let link = "link s - 1 0 0 0 0 0 0 slide Z 0 0 1\n";
    let [a, b] = [
        cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0),
        cube(&format!("b s holder - {PLAIN}"), [0.0, 0.0, 10.0], 1.0),
    ];
    written(&format!("{link}{a}{b}move 0 1 point\nmove 3 1 line Z=20\nmove 4 1 point\n{rest}"))
}

const BLOCKS: &str = "block 0 free\nblock 3 free\nblock 4 free";

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
    let report = accepted(&cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 16777216\n{BLOCKS}")));
    assert_eq!((report.examined, report.intervals, report.blocks.len()), (1, 1, 3));
    assert!(report.blocks.values().all(|verdict| *verdict == "free"));
    assert!(report.notes.iter().all(|note| note.starts_with("by the certificate's word")) && report.notes.len() == 3);
    // A step below the top of `a`, and through the bottom of `b`.
    for (z, why) in [(16_777_215, "the first part is not behind"), (150_994_944, "does not part the two")] {
        refused_at(&cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 {z}\n{BLOCKS}")), "free", why);
    }
    // A plane without a direction has everything on both sides.
    let nothing = cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 0 0\n{BLOCKS}"));
    refused_at(&nothing, "free", "the first part is not behind the plane [0, 0, 0] 0");
    // All but the margin of 1e-6 mm, which is 17 steps.
    accepted(&cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 {}\n{BLOCKS}", 150_994_944 - 18)));
    let near = cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 {}\n{BLOCKS}", 150_994_944 - 16));
    refused_at(&near, "free", "does not part the two");
    // The other way round: all of `b` behind, the plane seen from above.
    accepted(&cubes(&format!("pair b a examined\nfree 3 10.000001 p 0 0 -16777216 -150994944\n{BLOCKS}")));
}

#[test]
fn halves_are_parted_from_left_to_right() {
    let plane = "p 0 0 16777216 16777216";
    let four = format!("a b {plane} {plane} b {plane} {plane}");
    accepted(&cubes(&format!("pair a b examined\nfree 3 10.000001 {four}\n{BLOCKS}")));
    let text =
        |first: &str, second: &str| cubes(&format!("pair a b examined\nfree 3 10.000001 a {first} {second}\n{BLOCKS}"));
    accepted(&text(plane, plane));
    refused_at(&text(plane, ""), "free", "a word is missing");
    refused_at(&text(plane, &format!("{plane} {plane}")), "free", "`p` is too much");
    refused_at(&text(plane, "q 0 0 1 1"), "free", "`q` is neither a plane nor a halving");
    let text = |front: &str| cubes(&format!("pair a b examined\nfree 3 10.000001 {front}\n{BLOCKS}"));
    let all = leaves(12, &mut std::iter::repeat_n("p 0 0 1 1".to_owned(), 12));
    accepted(&text(&all));
    let (first, rest) = all.split_once('p').unwrap();
    refused_at(&text(&format!("{first}a p{rest}")), "free", "one triangle is not halved");
    // Faces of `b`; the face at +X has vertices at -1 and at 1 in Y and Z, and is not beyond a plane at X2.
    let below = "p 0 0 16777216 16777216".to_owned();
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
    let rest =
        |first: &str| cubes(&format!("pair a b examined\n{first}free 2 10.000001 =\nfree 3 0.000001 =\n{BLOCKS}"));
    accepted(&rest("free 1 0.000001 p 0 0 16777216 16777216\n"));
    refused_at(&rest(""), "free 2", "there is no front before");
    refused_at(&rest("open 1 0\n"), "free 2", "there is no front before");
    refused_at(&rest("free 1 0.000001 = p 0 0 1 1\n"), "free 1", "there is no front before");
    // They hold over what is not free as well, and for their pair alone.
    let open = cubes(&format!(
        "pair a b examined\nfree 1 0.000001 p 0 0 16777216 16777216\nopen 2 5\nfree 3 0.000001 =\n{}",
        BLOCKS.replace("3 free", "3 unresolved")
    ));
    accepted(&open);
    refused_at(&open.replace("block 3 unresolved", "block 3 free"), "block 3", "not what the intervals say");
    let text = cubes("pair a b examined\nfree 3 10.000001 p 0 0 16777216 16777216\npair b a examined");
    refused_at(&text, "pair b a", "the pair was there before");
}

#[test]
fn the_worst_interval_is_the_verdict_of_a_block() {
    // Two steps of line 3, one of line 4.
    let all = |verdicts: [&str; 3], three: &str, four: &str| {
        let steps = ["free 1 0.000001 p 0 0 16777216 16777216", verdicts[0], verdicts[1], verdicts[2]].join("\n");
        let text = cubes(&format!("pair a b examined\n{steps}\nblock 0 free\nblock 3 {three}\nblock 4 {four}"));
        let body =
            text.replace("move 4 1 point", "move 3 1 point\nmove 4 1 point").replace("bvbench-certificate 2\n", "");
        checked(&written(&body)).map_err(|refusal| refusal.why)
    };
    let (two, three, four) = ("free 2 10.000001 =", "free 3 0.000001 =", "free 4 0.000001 =");
    assert!(all([two, three, four], "free", "free").is_ok());
    assert!(all([two, "open 3 1", four], "unresolved", "free").is_ok());
    assert!(all(["open 2 1", three, four], "unresolved", "free").is_ok());
    assert!(all(["open 2 1", three, "open 4 1"], "unresolved", "unresolved").is_ok());
    assert_eq!(all(["open 2 1", three, four], "unresolved", "unresolved").unwrap_err(), "not what the intervals say");
    assert_eq!(all(["open 2 1", three, four], "collision", "free").unwrap_err(), "not what the intervals say");
    // Over whole steps, all of them are open.
    assert!(all(["open 4 1", "", ""], "unresolved", "unresolved").is_err(), "an empty line");
}

#[test]
fn what_comes_out_of_order_is_refused() {
    let good = cubes(&format!("pair a b examined\nfree 3 10.000001 p 0 0 16777216 16777216\n{BLOCKS}"));
    for (line, why) in [
        ("made late", "`made` does not belong here"),
        ("link t - 1 0 0 0 0 0 0", "`link` does not belong here"),
        ("v 0 0 0", "`v` does not belong here"),
        ("bvbench-certificate 2", "`bvbench-certificate` does not belong here"),
        ("free 3 0 =", "`free` does not belong here"),
        ("Free 3 0 =", "no such keyword"),
        ("", "a word is missing"),
    ] {
        let text = good.replace("block 3", &format!("{line}\nblock 3"));
        refused(&text, last(&text, "block 3") - 1, why);
    }
    refused(&good.replace("certificate 2", "certificate 1"), 1, "another version of the format");
    refused(&good.replace("certificate 2", "certificate 2 or so"), 1, "`or` is too much");
    refused("made up\n", 1, "`made` does not belong here");
    refused("", 1, "the certificate ends without `end`");
    // A phase that is passed over.
    refused("bvbench-certificate 2\nmove 0 1 point\n", 2, "`move` does not belong here");
    refused("bvbench-certificate 2\nmade up\nmove 0 1 point\n", 3, "`move` does not belong here");
    refused("bvbench-certificate 2\nlink a - 1 0 0 0 0 0 0\nv 0 0 0\n", 3, "no part");
    let text = good.replace("move 0", "free 0").replace("move 3", "free 3").replace("move 4", "free 4");
    refused(
        &text,
        text.lines().position(|line| line.starts_with("free 0")).unwrap() + 1,
        "`free` does not belong here",
    );
    let text = cubes("open 3 0");
    refused_at(&text, "open", "no pair");
    // Not UTF-8, and a line that never ends.
    let bytes = [b"bvbench-certificate 2\nmade \xff\n".as_slice(), good.as_bytes()].concat();
    assert_refusal(&certificate_checker::check(&bytes[..], None, None).unwrap_err(), 2, "not a line of text");
    let long = format!("bvbench-certificate 2\nmade {}\n", "x".repeat(1 << 22));
    refused(&long, 2, "not a line of text");
    let long = format!("bvbench-certificate 2\nmade {}\n", "x".repeat((1 << 22) - 6));
    refused(&long, 3, "the certificate ends without `end`");
}

#[test]
fn statements_that_make_no_sense_are_refused() {
    let head = |line: &str| format!("bvbench-certificate 2\nlink a - {PLAIN}\n{line}\n");
    for (line, why) in [
        ("link a - 1 0 0 0 0 0 0", "link `a` was there before"),
        ("link b c 1 0 0 0 0 0 0", "no link `c`"),
        ("link b - 0 0 0 0 0 0 0", "no rotation"),
        ("link b - 0.7 0 0 0 0 0 0", "no rotation"),
        ("link b - 1 0 0 0 0 0", "a word is missing"),
        ("link b - 1 0 0 0 0 0 0 hinge A 0 0 1", "`hinge` is too much"),
        ("link b - 1 0 0 0 0 0 0 slide Q 0 0 1", "`Q` is not an axis"),
        ("link b - 1 0 0 0 0 0 0 slide XY 0 0 1", "`XY` is not an axis"),
        ("link b - 1 0 0 0 0 0 0 slide X 0 0 0.001", "no direction"),
        ("link b - 1 0 0 0 0 0 0 slide A 0 0 1", "A, B and C turn"),
        ("link b - 1 0 0 0 0 0 0 slide C 0 0 1", "A, B and C turn"),
        ("link b - 1 0 0 0 0 0 0 turn A 0 0 1", "a word is missing"),
        ("link b%A; - 1 0 0 0 0 0 0", "an escape of no character"),
        ("link b%1b; - 1 0 0 0 0 0 0", "an escape of no character"),
        ("link b%20 - 1 0 0 0 0 0 0", "an escape without an end"),
        ("link b%d800; - 1 0 0 0 0 0 0", "an escape of no character"),
        ("link b%zz; - 1 0 0 0 0 0 0", "an escape of no character"),
        ("link b - 1 0 0 0 0 0 1000000000.1", "is not a number up to"),
        ("tip a c 0 0 0 0 0 1", "no link `c`"),
        ("part p - fixture none 1 0 0 0 0 0 0", "`none` is not a whole number"),
        ("part p b fixture - 1 0 0 0 0 0 0", "no link `b`"),
    ] {
        refused(&head(line), 3, why);
    }
    for line in [
        "link b - 0.71 0 0 0 0 0 0",
        "link b - 0.5 0.5 0 0 0 0 0",
        "link b - 1 0 0 0 0 0 -1e9 slide W 0 0 0.0011",
        "tip - a 0 0 0 0 0 1",
        "part p - fixture 7 1 0 0 0 0 0 0",
    ] {
        refused(&head(line), 4, "the certificate ends without `end`");
    }
    let part = cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0);
    let begin = |rest: &str| format!("bvbench-certificate 2\nmade up\n{part}{rest}");
    refused(&begin(&part), 24, "part `a` was there before");
    let empty = format!("part b - fixture - {PLAIN}\nv 0 0 0\nmove 0 1 point\n");
    refused(&begin(&empty), 26, "b: a mesh without a face");
    let second = cube(&format!("b - fixture - {PLAIN}"), [9.0; 3], 1.0);
    for (step, why) in [
        ("0 1 jump", "no such course"),
        ("0 1 line arc=X,Y,0,0,1", "no such course"),
        ("0 1 arc X=1", "no such course"),
        ("0 1 arc arc=X,Y,0,0", "not an arc"),
        ("0 1 arc arc=X,Y,0,0,1,2", "not an arc"),
        ("0 1 arc arc=X,X,0,0,1", "a plane of one axis"),
        ("0 1 line X", "a value without a key"),
        ("0 1 line Q=3", "`Q` is not an axis"),
        ("0 1", "a word is missing"),
        ("-1 1 point", "is not a whole number"),
    ] {
        refused(&begin(&format!("{second}move {step}\n")), 45, why);
    }
    refused(&begin(&format!("{second}pair a b rigid\n")), 45, "`pair` does not belong here");
}

#[test]
fn names_may_have_any_character() {
    let [a, b] = ["tool%20;no%25;1", "%1f980;"].map(|name| cube(&format!("{name} - fixture - {PLAIN}"), [0.0; 3], 1.0));
    let text = written(&format!("made\n{a}{b}move 0 1 point\npair tool%20;no%25;1 %1F980; ignored\nblock 0 free"));
    assert_eq!(accepted(&text).notes[0], "not examined: tool no%1:\u{1f980}, ignored");
}

#[test]
fn parts_of_a_tool_are_there_with_their_tool() {
    let [a, b] =
        [cube(&format!("a - fixture - {PLAIN}"), [0.0; 3], 1.0), cube(&format!("b s holder 2 {PLAIN}"), [0.0; 3], 1.0)];
    let text = |first: &str, second: &str, third: &str| {
        written(&format!(
            "link s - {PLAIN} slide Z 0 0 1\n{a}{b}move 1 1 point Z=10\nmove 2 2 point\nmove 3 3 point\npair a b examined\n{first}\n{second}\n{third}\nblock 1 free\nblock 2 free\nblock 3 free"
        ))
    };
    let front = "p 0 0 16777216 16777216";
    let free = format!("free 2 0.000001 {front}");
    accepted(&text("away 1", &free, "away 3"));
    refused_at(&text("away 2", "away 3", ""), "away 2", "both parts are there");
    refused_at(&text("away 1", "away 2", "away 3"), "away 2", "both parts are there");
    refused_at(&text("away 1", "away 3", ""), "away 3", "both parts are there");
    // Where it is not there, planes may be stated all the same.
    accepted(&text(&format!("free 1 0.000001 {front}"), &free, "away 3"));
    // It cannot be in contact while it is not there.
    refused_at(&text("hit 1 1 1 a 0 0 0", &free, "away 3"), "hit", "no contact can be there");
}

/// A triangle below and a needle that goes down through it on a slide, by 10 mm in line 1. Its edge 0, of the corners 0 and 1, points down.
fn needle(hit: &str) -> String {
    let mm = |x: f64| (x * f64::from(1 << 26)) as i64;
    let v = |x: f64, y: f64, z: f64| format!("v {} {} {}\n", mm(x), mm(y), mm(z));
    let a =
        format!("part a - fixture - {PLAIN}\n{}{}{}f 0 1 2\n", v(0.0, 0.0, 0.0), v(30.0, 0.0, 0.0), v(0.0, 30.0, 0.0));
    let b =
        format!("part b s holder - {PLAIN}\n{}{}{}f 0 1 2\n", v(5.0, 5.0, 12.0), v(5.5, 5.0, 4.0), v(6.0, 6.0, 11.0));
    written(&format!(
        "link s - {PLAIN} slide Z 0 0 1\n{a}{b}move 0 1 point\nmove 1 1 line Z=-8\nmove 2 1 line Z=0\n{hit}\nblock 0 free\nblock 1 collision\nblock 2 unresolved"
    ))
}

#[test]
fn contact_is_an_edge_through_a_triangle() {
    // The point comes to 0 at half the way.
    let begin = "pair a b examined\nfree 1 0.000001 p 0 0 16777216 0\nfree 1.25 1.000001 =";
    let hit = |hit: &str| needle(&format!("{begin}\nhit {hit}\nopen 3 0"));
    assert_eq!(accepted(&hit("2 1.75 4.000001 b 0 0 0")).blocks[&1], "collision");
    accepted(&hit("2 1.501 2.008001 b 0 0 0"));
    accepted(&hit("2 1.75 4.000001 b 0 1 0"));
    refused_at(&hit("2 1.499 2.008001 b 0 0 0"), "hit", "the edge does not pierce the triangle");
    for wrong in ["b 0 2 0", "a 0 0 0", "a 0 1 0", "a 0 2 0"] {
        refused_at(&hit(&format!("2 1.75 4.000001 {wrong}")), "hit", "the edge does not pierce the triangle");
    }
    for wrong in ["b 1 0 0", "b 0 0 1", "a 0 0 1", "b 0 3 0", "b 0 4 0", "b 0 18446744073709551615 0"] {
        refused_at(&hit(&format!("2 1.75 4.000001 {wrong}")), "hit", "no such triangle or edge");
    }
    // The way from the beginning of the interval to the place is 4 mm.
    refused_at(&hit("2 1.75 3.999999 b 0 0 0"), "hit", "the way is not within 3.999999 mm");
    // The interval ends with its step, and the place is in it.
    for wrong in ["1.9 1.75", "3 1.75", "2 2.01", "2 1.24"] {
        let text = hit(&format!("{wrong} 9 b 0 0 0"));
        let line = last(&text, "hit");
        assert!(checked(&text).unwrap_err().line == line, "{wrong}");
    }
    accepted(&hit("2 2 6.000001 b 0 0 0"));
    // The other way round the needle's edge is one of the first part.
    let text = needle("pair b a examined\nopen 1 0\nhit 2 1.75 6.000001 a 0 0 0\nopen 3 0")
        .replace("block 0 free", "block 0 unresolved");
    let body = text.replace("bvbench-certificate 2\n", "");
    accepted(&written(&body));
    refused_at(&written(&body.replace("a 0 0 0", "b 0 0 0")), "hit", "the edge does not pierce the triangle");
    // Contact may be at the very beginning of a step.
    accepted(&needle("pair a b examined\nfree 1 0.000001 p 0 0 16777216 0\nfree 1.25 1.000001 =\nhit 2 2 6.000001 b 0 0 0\nhit 3 2 0.000001 b 0 0 0").replace("block 2 unresolved", "block 2 collision").replace("bvbench-certificate 2\n", "").split_once("\nend").map(|(body, _)| written(body)).unwrap());
}

#[test]
fn an_edge_beside_the_triangle_pierces_nothing() {
    // Beyond each side of the triangle, by the same steps down.
    let hit = needle("pair a b examined\nopen 1 0\nhit 2 1.75 6.000001 b 0 0 0\nopen 3 0")
        .replace("block 0 free", "block 0 unresolved");
    let body = hit.replace("bvbench-certificate 2\n", "");
    accepted(&written(&body));
    for at in ["-7 0 0", "0 -7 0", "20 20 0"] {
        let moved =
            written(&body.replace(&format!("part b s holder - {PLAIN}"), &format!("part b s holder - 1 0 0 0 {at}")));
        refused_at(&moved, "hit", "the edge does not pierce the triangle");
    }
    // Turned inside out it pierces as well.
    accepted(&written(&body.replacen("f 0 1 2", "f 0 2 1", 1)));
}

/// `b` inside a closed `a`, parted from it by a plane for each face of `a`; the slide goes 4 mm.
fn nested(a: &str, b: &str, front: &str, rest: &str) -> String {
    written(&format!(
        "link s - {PLAIN} slide X 1 0 0\npart a - fixture - {PLAIN}\n{a}part b s holder - {PLAIN}\n{b}move 0 1 point\nmove 1 1 line X=4\npair a b examined\nfree 1 0.000001 {front}\n{rest}"
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
        format!("p {x} {y} {z} {}", (at * 16_777_216.0) as i64)
    };
    (0..FACES.len()).map(side).collect()
}

#[test]
fn a_part_inside_the_other_is_not_free() {
    let (a, b) = (corners([0.0; 3], 20.0) + &faces(0, false), corners([1.0, 2.0, 3.0], 2.0) + &faces(0, false));
    let front = leaves(12, &mut from_inside([0.0; 3], 20.0).into_iter());
    let inside = "before this line one part may be inside the other";
    let end = "free 2 2.000001 =\nblock 0 free\nblock 1 free";
    refused_at(&nested(&a, &b, &front, end), "block 0", inside);
    // Far from the origin as well.
    let far = [100.0, -200.0, 300.0];
    let (c, d) = (corners(far, 20.0) + &faces(0, false), corners([101.0, -198.0, 303.0], 2.0) + &faces(0, false));
    refused_at(&nested(&c, &d, &leaves(12, &mut from_inside(far, 20.0).into_iter()), end), "block 0", inside);
    // Before each line that is no free interval.
    refused_at(&nested(&a, &b, &front, "open 2 0\nblock 0 free\nblock 1 unresolved"), "open", inside);
    refused_at(&nested(&a, &b, &front, "away 2"), "away", inside);
    refused_at(&nested(&a, &b, &front, "pair a b rigid"), "pair a b rigid", inside);
    // The same, with the parts' names swapped.
    let swapped = nested(&b, &a, &front.replace('a', "b"), end);
    assert!(checked(&swapped).is_err());
    // With a face missing, or one turned over, there is no inside.
    let open = a.replacen("f 0 1 3\n", "", 1);
    let mut planes = from_inside([0.0; 3], 20.0);
    planes.remove(0);
    accepted(&nested(&open, &b, &leaves(11, &mut planes.clone().into_iter()), end));
    accepted(&nested(&a.replacen("f 0 1 3\n", "f 1 0 3\n", 1), &b, &front, end));
    // A face twice is refused, whichever way it winds; it would hide that there is an inside. Vertices in one place are one, so that faces with vertices of
    // their own hide it no better.
    for twice in ["f 0 1 3", "f 3 1 0"] {
        let double = corners([0.0; 3], 20.0) + &format!("{twice}\n{}", faces(0, false));
        refused_at(&nested(&double, &b, &front, end), "move 0", "a: a face is there twice");
    }
    let corner: Vec<String> = corners([0.0; 3], 20.0).lines().map(|line| line.to_owned() + "\n").collect();
    let apart: String = FACES.iter().flatten().map(|&corner_of_face| corner[corner_of_face].as_str()).collect();
    let own: String =
        (0..FACES.len()).map(|face| format!("f {} {} {}\n", 3 * face, 3 * face + 1, 3 * face + 2)).collect();
    refused_at(&nested(&(apart + &own), &b, &front, end), "block 0", inside);
    // In a cavity it is not in the solid.
    let hollow = corners([0.0; 3], 30.0) + &corners([0.0; 3], 20.0) + &faces(8, true) + &faces(0, false);
    let planes: Vec<String> = [from_inside([0.0; 3], 20.0), from_inside([0.0; 3], 30.0)].concat();
    accepted(&nested(&hollow, &b, &leaves(24, &mut planes.clone().into_iter()), end));
    // With a cavity that is no cavity, it is.
    let solid = corners([0.0; 3], 30.0) + &corners([0.0; 3], 20.0) + &faces(8, false) + &faces(0, false);
    refused_at(&nested(&solid, &b, &leaves(24, &mut planes.into_iter()), end), "block 0", inside);
}

#[test]
fn every_component_counts() {
    let a = corners([0.0; 3], 20.0) + &faces(0, false);
    // Cubes of `b` inside, or above; a half of `b` each.
    let two = |low: f64, high: f64| {
        let [low, high] = [low, high].map(|z| corners([1.0, 2.0, z], 2.0));
        format!("{low}{high}{}{}", faces(0, false), faces(8, false))
    };
    let above = "p 0 0 16777216 335544320".to_owned();
    let front = leaves(12, &mut from_inside([0.0; 3], 20.0).into_iter());
    let end = "free 2 2.000001 =\nblock 0 free\nblock 1 free";
    let inside = "before this line one part may be inside the other";
    accepted(&nested(&a, &two(30.0, 40.0), &format!("b {above} {above}"), end));
    refused_at(&nested(&a, &two(0.0, 40.0), &format!("b {front} {above}"), end), "block 0", inside);
    refused_at(&nested(&a, &two(30.0, 0.0), &format!("b {above} {front}"), end), "block 0", inside);
    // As the first part, the cubes have the other inside one of them.
    let mut planes = from_inside([0.0; 3], 20.0);
    planes.extend(vec!["p 0 0 -16777216 -503316480".to_owned(); 12]);
    let cubes = corners([0.0; 3], 20.0) + &corners([0.0, 0.0, 35.0], 5.0) + &faces(0, false) + &faces(8, false);
    let b = corners([1.0, 2.0, 3.0], 2.0) + &faces(0, false);
    refused_at(&nested(&cubes, &b, &leaves(24, &mut planes.into_iter()), end), "block 0", inside);
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
        vec![format!("p {x} {y} {z} {}", -11_i64 << 24); 12]
    });
    let front = leaves(60, &mut planes.collect::<Vec<_>>().into_iter());
    let end = "free 2 2.000001 =\nblock 0 free\nblock 1 free";
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
    let planes = planes.map(|[x, y, z]| format!("p {} {} {} -335544320", x << 24, y << 24, z << 24));
    let front = leaves(16, &mut planes.collect::<Vec<_>>().into_iter());
    let b = corners([1.0, 4.4, 3.0], 2.0) + &faces(0, false);
    let text = nested(&a, &b, &front, "free 2 2.000001 =\nblock 0 free\nblock 1 free");
    refused_at(&text, "block 0", "before this line one part may be inside the other");
}

#[test]
fn a_face_behind_the_beginning_of_a_ray_is_not_crossed() {
    // A tetrahedron below X + Y + Z = -20, within 20 mm of the origin along each axis; the ray goes to +X.
    let mm = |x: i64| x << 26;
    let vertex = |[x, y, z]: [i64; 3]| format!("v {} {} {}\n", mm(x), mm(y), mm(z));
    let corners_of = [[-20, -20, -20], [20, -20, -20], [-20, 20, -20], [-20, -20, 20]];
    let a = corners_of.map(vertex).concat() + "f 0 2 1\nf 0 1 3\nf 0 3 2\nf 1 2 3\n";
    let front = leaves(4, &mut vec!["p 16777216 16777216 16777216 -335544320".to_owned(); 4].into_iter());
    let end = "free 2 2.000001 =\nblock 0 free\nblock 1 free";
    for centre in [[0.0, -5.0, -5.0], [5.0, -9.0, -4.0]] {
        accepted(&nested(&a, &(corners(centre, 2.0) + &faces(0, false)), &front, end));
    }
}

#[test]
fn one_plane_at_some_time_shows_that_neither_is_inside() {
    // At first a plane for each face of `a`, then one plane for all of it: the cube is beside it.
    let a = corners([0.0; 3], 20.0) + &faces(0, false);
    let b = corners([30.0, 0.0, 0.0], 2.0) + &faces(0, false);
    let front = leaves(12, &mut vec!["p 16777216 0 0 335544320".to_owned(); 12].into_iter());
    accepted(&nested(&a, &b, &front, "free 2 2.000001 =\nblock 0 free\nblock 1 free"));
    accepted(&nested(&a, &b, &front, "free 2 2.000001 p 16777216 0 0 335544320\nblock 0 free\nblock 1 free"));
    accepted(&nested(&a, &b, "p 16777216 0 0 335544320", "free 2 2.000001 =\nblock 0 free\nblock 1 free"));
}

/// The same two as workpiece and cutter: the cutter feeds into the workpiece, stands, and goes back at rapid rate.
fn cutting(moves: &str, intervals: &str, verdicts: [&str; 4]) -> String {
    let link = "link s - 1 0 0 0 0 0 0 slide Z 0 0 1\n";
    let [a, b] = [
        cube(&format!("a - workpiece - {PLAIN}"), [0.0; 3], 1.0),
        cube(&format!("b s cutter - {PLAIN}"), [0.0, 0.0, 10.0], 1.0),
    ];
    let blocks = verdicts.iter().enumerate().map(|(line, verdict)| format!("\nblock {line} {verdict}"));
    let blocks: String = blocks.collect();
    written(&format!("{link}{a}{b}move 0 1 point\n{moves}pair a b {intervals}{blocks}"))
}

#[test]
fn a_cutter_may_be_in_the_workpiece_where_it_feeds() {
    let moves = "move 1 1 line Z=-10\nmove 2 1 point\nmove 3 1 rapid Z=0\n";
    let free = "free 1 0.000001 p 0 0 16777216 16777216";
    let left = ["free", "free", "free", "stock"];
    let report = accepted(&cutting(moves, &format!("cutting\n{free}\nmeant 3\nopen 4 0"), left));
    assert_eq!((report.examined, report.intervals, report.blocks[&3]), (1, 1, "stock"));
    assert!(report.notes.contains(&"at rapids alone, against the whole workpiece: a:b".to_owned()));
    // In pieces of steps as well, and an arc is a feed.
    accepted(&cutting(moves, &format!("cutting\n{free}\nmeant 1.5\nmeant 2\nmeant 3\nopen 3.5 0\nopen 4 0"), left));
    let arc = moves.replace("line Z=-10", "arc X=2 Z=-10 arc=X,Z,1,-5,3.2");
    let text = cutting(&arc, &format!("cutting\n{free}\nmeant 3\nopen 4 0"), left);
    assert!(!matches!(checked(&text), Err(refusal) if refusal.why.contains("meant")));
    // Not at a rapid, nor at the start.
    let all = ["free"; 4];
    refused_at(&cutting(moves, &format!("cutting\n{free}\nmeant 4"), all), "meant", "contact is not meant there");
    refused_at(
        &cutting(moves, &format!("cutting\n{free}\nmeant 3\nmeant 3.5\nopen 4 0"), left),
        "meant 3.5",
        "not meant",
    );
    refused_at(&cutting(moves, "cutting\nmeant 3\nopen 4 0", left), "meant", "contact is not meant there");
    // A change of tools brings a tool to where it was not before.
    let changed = moves.replace("move 2 1", "move 2 2");
    refused_at(&cutting(&changed, &format!("cutting\n{free}\nmeant 3\nopen 4 0"), left), "meant", "not meant");
    let kept = changed.replace("move 3 1", "move 3 2");
    refused_at(&cutting(&kept, &format!("cutting\n{free}\nmeant 3\nopen 4 0"), left), "meant", "not meant");
    let change = ["free", "free", "stock", "stock"];
    accepted(&cutting(&changed, &format!("cutting\n{free}\nmeant 2\nopen 3 0\nopen 4 0"), change));
    // What is open is neither free nor unresolved.
    for verdict in ["free", "unresolved", "collision"] {
        let text = cutting(moves, &format!("cutting\n{free}\nmeant 3\nopen 4 0"), ["free", "free", "free", verdict]);
        refused_at(&text, "block 3", "not what the intervals say");
    }
    // To touch the whole workpiece is not to touch what is left of it.
    let hit = format!("cutting\n{free}\nmeant 3\nhit 4 3.5 10 b 0 0 0");
    refused_at(&cutting(moves, &hit, left), "hit", "what is left of the workpiece is not known");
    // An examined pair has no such contact, and no other two parts are cutter and workpiece.
    refused_at(&cutting(moves, &format!("examined\n{free}\nmeant 3\nopen 4 0"), left), "meant", "not meant");
    refused_at(
        &cubes("pair a b cutting\nfree 3 10.000001 p 0 0 16777216 16777216\n"),
        "pair",
        "the pair is not `cutting`",
    );
}
