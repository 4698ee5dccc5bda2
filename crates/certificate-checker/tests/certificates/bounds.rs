//! How far parts go over an interval, against formulas worked out by hand: motion bounds that are just enough, and planes that just hold.

use crate::fixture::{cube, written};
use certificate_checker::{MOST_WORK, check};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2};

/// Half the side of the cube that moves, and the radius of the ball around it, mm.
const HALF: f64 = 2.0;
const RADIUS: f64 = HALF * 1.732_050_807_568_877_2;
/// Clearance that a written plane has beyond the motion bound, mm.
const MARGIN: f64 = 1e-6;
/// How near to its formula each bound is tested, mm.
const NEAR: f64 = 1e-8;

/// Links and moves, and where the two cubes `a` and `b` are: link, quaternion and place, and the centre of the cube.
struct Case<'a> {
    links: &'a str,
    a: [&'a str; 2],
    b: [&'a str; 2],
    centre: [f64; 3],
    moves: &'a str,
}

const PLAIN: &str = "1 0 0 0 0 0 0";

impl Case<'_> {
    /// Why the interval is refused; nothing where it is not.
    fn why(&self, from: f64, to: f64, free: &str) -> Option<String> {
        let Self { links, a, b, centre, moves } = self;
        let parts = [
            cube(&format!("a {} fixture - {}", a[0], a[1]), [0.0; 3], HALF),
            cube(&format!("b {} holder - {}", b[0], b[1]), *centre, HALF),
        ];
        let before = [from.floor(), from].map(|place| format!("open {place} 0\n"));
        let open = match (from.floor() > 0.0, from.fract() > 0.0) {
            (true, true) => before.concat(),
            (false, false) => String::new(),
            _ => before[1].clone(),
        };
        let text =
            written(&format!("{links}\n{}{}{moves}\npair a b examined\n{open}free {to} {free}\n", parts[0], parts[1]));
        let line = text.lines().count() - 1;
        let refusal = check(&text, None, None, MOST_WORK).err()?;
        assert!(refusal.line >= line, "line {}: {}", refusal.line, refusal.why);
        (refusal.line == line).then_some(refusal.why)
    }

    /// The least motion bound that is accepted between two places is `wanted`.
    #[track_caller]
    fn goes(&self, from: f64, to: f64, wanted: f64) {
        for (by, is_refused) in [(NEAR, false), (-NEAR, true)] {
            let why = self.why(from, to, &format!("{} p 0 0 16777216 0", wanted + by));
            let found = why.as_ref().is_some_and(|why| why.starts_with("points may go farther"));
            assert_eq!(found, is_refused, "{from} to {to}: {wanted} and {by}: {why:?}");
        }
    }

    /// Nothing bounds the motion.
    #[track_caller]
    fn goes_anywhere(&self, from: f64, to: f64) {
        let why = self.why(from, to, "1e9 p 0 0 16777216 0");
        assert_eq!(why.as_deref(), Some("the way cannot be bounded"), "{from} to {to}");
    }

    /// The last plane with this normal that parts the two is `wanted` mm from the origin of `a`.
    #[track_caller]
    fn stays_beyond(&self, from: f64, to: f64, normal: [f64; 3], wanted: f64) {
        // Fifths are whole numbers.
        let normal = normal.map(|x| (x * f64::from(5 << 26)).round());
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (by, is_refused) in [(-4.0 * NEAR, false), (4.0 * NEAR, true)] {
            let [x, y, z] = normal.map(|x| x as i64);
            let offset = ((wanted - MARGIN + by) * length).round() as i64;
            let why = self.why(from, to, &format!("1e9 p {x} {y} {z} {offset}"));
            let found = why.as_ref().is_some_and(|why| why.contains("does not part"));
            assert!(why.is_none() || found, "{why:?}");
            assert_eq!(found, is_refused, "{from} to {to}: {wanted} and {by}");
        }
    }
}

#[test]
fn a_slide_goes_half_its_way_to_either_side() {
    let case = Case {
        links: "slide s - 1 0 0 0 0 0 0 X 3 0 4",
        a: ["-", PLAIN],
        b: ["s", PLAIN],
        centre: [10.0, 20.0, 30.0],
        moves: "point 0 1 X 4\nfeed 7 1 X 44\npoint 8 1 X 44",
    };
    case.goes(1.0, 2.0, 20.0);
    case.goes(1.25, 1.5, 5.0);
    case.goes(0.0, 1.0, 0.0);
    case.goes(2.0, 3.0, 0.0);
    // Along the slide, across it, and at an angle.
    case.stays_beyond(0.0, 1.0, [0.6, 0.0, 0.8], 6.0 + 24.0 - 1.4 * HALF + 4.0);
    case.stays_beyond(1.0, 2.0, [0.6, 0.0, 0.8], 6.0 + 24.0 - 1.4 * HALF + 4.0);
    case.stays_beyond(1.25, 1.5, [0.6, 0.0, 0.8], 6.0 + 24.0 - 1.4 * HALF + 14.0);
    case.stays_beyond(1.0, 2.0, [-0.8, 0.0, 0.6], -8.0 + 18.0 - 1.4 * HALF);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 30.0 + 0.8 * 4.0 - HALF);
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 20.0 - HALF);
}

#[test]
fn a_turn_goes_its_angle_times_the_farthest_point() {
    let turn = |links, moves| Case { links, a: ["-", PLAIN], b: ["t", PLAIN], centre: [10.0, 25.0, 0.0], moves };
    // The axis is at Y5: the centre is 20 mm from it.
    let case = turn("turn t - 1 0 0 0 0 0 0 A 2 0 0 0 5 0", "point 0 1\nfeed 1 1 A 0.6");
    case.goes(1.0, 2.0, 0.3 * (20.0 + RADIUS));
    case.goes(1.5, 1.75, 0.075 * (20.0 + RADIUS));
    // At the middle it stands at 0.3; its corner is 18 or 22 mm from the axis in its own Y, 2 in Z.
    let (sin, cos) = 0.3_f64.sin_cos();
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 5.0 + 18.0 * cos - 2.0 * sin - 0.3 * (20.0 + RADIUS));
    case.stays_beyond(1.5, 1.5 + 1e-9, [0.0, 1.0, 0.0], 5.0 + 18.0 * cos - 2.0 * sin);
    case.stays_beyond(1.5, 1.75, [1.0, 0.0, 0.0], 8.0 - 0.075 * (20.0 + RADIUS));
    case.stays_beyond(1.5, 1.5 + 1e-9, [0.0, 0.0, 1.0], 18.0 * sin - 2.0 * cos);
    // An axis of mm turns by a degree per mm.
    let case = turn("turn t - 1 0 0 0 0 0 0 U 1 0 0 0 5 0", "point 0 1\nfeed 1 1 U 60");
    case.goes(1.0, 2.0, PI / 6.0 * (20.0 + RADIUS));
    case.stays_beyond(1.5, 1.5 + 1e-9, [0.0, 0.0, 1.0], 18.0 * 0.5 - 2.0 * 0.75_f64.sqrt());
}

#[test]
fn joints_of_a_chain_add_up() {
    let (sin, cos) = 0.2_f64.sin_cos();
    let along = (4.0 * cos).hypot(4.0 * sin + 3.0);
    let arm = 14.0_f64.hypot(20.0);
    // Slide on a turn on a slide: the turn moves what the slide has moved.
    let links =
        "slide y - 1 0 0 0 0 0 0 Y 0 1 0\nturn c y 1 0 0 0 0 0 0 C 0 0 1 0 0 0\nslide x c 1 0 0 0 0 0 0 X 1 0 0";
    let moves = "point 0 1\nfeed 1 1 X 8 Y 6 C 0.4";
    let case = Case { links, a: ["-", PLAIN], b: ["x", PLAIN], centre: [10.0, 20.0, 0.0], moves };
    let turned = 0.2 * (arm + RADIUS + 4.0);
    case.goes(1.0, 2.0, along + turned);
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 3.0 + 12.0 * sin + 18.0 * cos - (4.0 * sin + 3.0) - turned);
    // A turn on a turn: the outer one moves what the inner one has moved. Both about the same line, which `b` is 14 and 20 mm beside.
    let links = "turn a - 1 0 0 0 0 0 0 A 0 0 1 0 0 0\nturn c a 1 0 0 0 0 0 0 C 0 0 1 0 0 0";
    let moves = "point 0 1\nfeed 1 1 A 0.2 C 0.4";
    let case = Case { links, a: ["-", PLAIN], b: ["c", PLAIN], centre: [14.0, 20.0, 0.0], moves };
    let inner = 0.2 * (arm + RADIUS);
    case.goes(1.0, 2.0, inner + 0.1 * (arm + RADIUS + inner));
    // The same chain carries `a`, whose centre is on the line; `b` stands.
    let case = Case { links, a: ["c", PLAIN], b: ["-", PLAIN], centre: [14.0, 20.0, 0.0], moves };
    let inner = 0.2 * RADIUS;
    case.goes(1.0, 2.0, inner + 0.1 * (RADIUS + inner));
    // Seen from `a`, turned by 0.3, the stretch to `b` has turned back.
    let (sin, cos) = 0.3_f64.sin_cos();
    let wanted = 14.0 * cos + 20.0 * sin - HALF * (cos + sin);
    case.stays_beyond(1.5, 1.5 + 1e-9, [1.0, 0.0, 0.0], wanted);
    // `a` turns with one link, `b` with another.
    let links = "turn a - 1 0 0 0 0 0 0 A 0 0 1 0 0 0\nturn c - 1 0 0 0 0 0 0 C 0 0 1 0 0 0";
    let case = Case { links, a: ["a", PLAIN], b: ["c", PLAIN], centre: [14.0, 20.0, 0.0], moves };
    case.goes(1.0, 2.0, 0.1 * RADIUS + 0.2 * (arm + RADIUS));
}

#[test]
fn what_carries_both_does_not_count() {
    let moves = "point 0 1\nfeed 1 1 X 8 C 1";
    // Both turn; `b` slides.
    let links = "turn c - 1 0 0 0 0 0 0 C 0 0 1 5 6 7\nslide x c 1 0 0 0 0 0 0 X 0 0 1";
    let case = Case { links, a: ["c", PLAIN], b: ["x", PLAIN], centre: [0.0, 0.0, 30.0], moves };
    case.goes(1.0, 2.0, 4.0);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 28.0);
    // Both slide alike, on slides of their own: nothing moves.
    let links = "slide one - 1 0 0 0 0 0 0 X 0 0 1\nslide two - 1 0 0 0 0 0 0 X 0 0 1";
    let case = Case { links, a: ["one", PLAIN], b: ["two", PLAIN], centre: [0.0, 0.0, 30.0], moves };
    case.goes(1.0, 2.0, 0.0);
    // Against one another: twice as far.
    let links = "slide one - 1 0 0 0 0 0 0 X 0 0 -1\nslide two - 1 0 0 0 0 0 0 X 0 0 1";
    let case = Case { links, a: ["one", PLAIN], b: ["two", PLAIN], centre: [0.0, 0.0, 30.0], moves };
    case.goes(1.0, 2.0, 8.0);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 28.0);
    // A link without a joint carries the one, and the other stands beside it.
    let links = "link base - 1 0 0 0 0 0 9\nslide x base 1 0 0 0 0 0 0 X 0 0 1";
    let case = Case { links, a: ["base", PLAIN], b: ["x", PLAIN], centre: [0.0, 0.0, 30.0], moves };
    case.goes(1.0, 2.0, 4.0);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 28.0);
}

#[test]
fn places_of_links_and_parts() {
    // 1 + 2i + 3j + 4k: 1/30 of these rows.
    let rows = [[-20.0, 4.0, 22.0], [20.0, -10.0, 20.0], [10.0, 28.0, 4.0]].map(|row| row.map(|x: f64| x / 30.0));
    let moves = "point 0 1 X 3";
    let links = "link base - 1 2 3 4 5 6 7\nslide x base 1 0 0 0 0 0 20 X 0 1 0";
    let least =
        |row: [f64; 3], at: [f64; 3], t: f64| (0..3).map(|i| row[i] * at[i] - HALF * row[i].abs()).sum::<f64>() + t;
    let case = Case { links, a: ["-", PLAIN], b: ["x", "1 0 0 0 1 1 0"], centre: [10.0, 20.0, 30.0], moves };
    for (i, normal) in [(1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])] {
        case.stays_beyond(0.0, 1.0, normal, least(rows[i], [11.0, 24.0, 50.0], [5.0, 6.0, 7.0][i]));
    }
    // Part `b` turned in its link, then moved.
    let case = Case {
        links: "slide x - 1 0 0 0 0 0 20 X 0 1 0",
        a: ["-", PLAIN],
        b: ["x", "1 2 3 4 5 6 7"],
        centre: [10.0, 20.0, 30.0],
        moves,
    };
    case.stays_beyond(0.0, 1.0, [0.0, 1.0, 0.0], least(rows[1], [10.0, 20.0, 30.0], 9.0));
    case.stays_beyond(0.0, 1.0, [0.0, 0.0, 1.0], least(rows[2], [10.0, 20.0, 30.0], 27.0));
    // Part `a` turned: the way of `b` is seen in its frame, by the columns.
    let links = "slide x - 1 0 0 0 0 0 0 X 0 0 1";
    let moves = "point 0 1\nfeed 1 1 X 10";
    let case = Case { links, a: ["-", "1 2 3 4 5 6 7"], b: ["x", PLAIN], centre: [15.0, 26.0, 37.0], moves };
    let column = [rows[0][1], rows[1][1], rows[2][1]];
    case.stays_beyond(0.0, 1.0, [0.0, 1.0, 0.0], least(column, [10.0, 20.0, 30.0], 0.0));
    case.stays_beyond(
        1.0,
        2.0,
        [0.0, 1.0, 0.0],
        least(column, [10.0, 20.0, 30.0], 0.0) + 5.0 * column[2] - 5.0 * column[2].abs(),
    );
    case.goes(1.0, 2.0, 5.0);
}

/// X, Y and Z in a row.
const SLIDES: &str =
    "slide x - 1 0 0 0 0 0 0 X 1 0 0\nslide y x 1 0 0 0 0 0 0 Y 0 1 0\nslide z y 1 0 0 0 0 0 0 Z 0 0 1";

#[test]
fn an_arc_stays_in_a_ball_about_its_middle() {
    // From radius 10 to 12 through a quarter, about (1, 2), rising.
    let moves = format!("point 0 1 X 11 Y 2\nfeed 1 1 X 1 Y 14 Z 6 arc X Y 1 2 {FRAC_PI_2}");
    let case = Case { links: SLIDES, a: ["-", PLAIN], b: ["z", PLAIN], centre: [40.0, 40.0, 40.0], moves: &moves };
    let ball = |half: f64| half * (12.0 * FRAC_PI_2 + 2.0);
    case.goes(1.0, 2.0, ball(0.5) * SQRT_2 + 3.0);
    case.goes(1.25, 1.5, ball(0.125) * SQRT_2 + 0.75);
    case.stays_beyond(1.0, 2.0, [1.0, 0.0, 0.0], 38.0 + 1.0 + 11.0 * FRAC_PI_4.cos() - ball(0.5));
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 38.0 + 2.0 + 11.0 * FRAC_PI_4.sin() - ball(0.5));
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 38.0);
    case.stays_beyond(1.0, 2.0, [0.6, 0.8, 0.0], 1.4 * 38.0 + 0.6 + 1.6 + 1.4 * 11.0 * FRAC_PI_4.cos() - ball(0.5));
    // The other way round, in the plane of Z and X.
    let moves = format!("point 0 1 Z 10\nfeed 1 1 X -10 Z 0 arc Z X 0 0 {}", -FRAC_PI_2);
    let case = Case { moves: &moves, ..case };
    case.goes(1.0, 2.0, 0.25 * PI * 10.0 * SQRT_2);
    case.stays_beyond(1.0, 2.0, [1.0, 0.0, 0.0], 38.0 - 10.0 * FRAC_PI_4.sin() - 2.5 * PI);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 38.0 + 10.0 * FRAC_PI_4.cos() - 2.5 * PI);
}

#[test]
fn a_turn_moves_what_an_arc_has_moved() {
    let links =
        "turn c - 1 0 0 0 0 0 0 C 0 0 1 0 0 0\nslide x c 1 0 0 0 0 0 0 X 1 0 0\nslide y x 1 0 0 0 0 0 0 Y 0 1 0";
    let moves = format!("point 0 1 X 10\nfeed 1 1 X 0 Y 10 C 0.4 arc X Y 0 0 {FRAC_PI_2}");
    let case = Case { links, a: ["-", PLAIN], b: ["y", PLAIN], centre: [20.0, 30.0, 0.0], moves: &moves };
    // Both slides are within the ball.
    let (ball, arm) = (2.5 * PI, (20.0 + 10.0 * FRAC_PI_4.cos()).hypot(30.0 + 10.0 * FRAC_PI_4.sin()));
    case.goes(1.0, 2.0, ball * SQRT_2 + 0.2 * (arm + RADIUS + 2.0 * ball));
}

#[test]
fn whole_steps_stay_in_a_box() {
    let moves = "point 0 1 X 1\nfeed 1 1 X 10\nfeed 2 1 Y 6\nfeed 3 1 X -2 Z 3\npoint 4 1";
    let case = Case { links: SLIDES, a: ["-", PLAIN], b: ["z", PLAIN], centre: [40.0, 40.0, 40.0], moves };
    case.goes(1.0, 4.0, 6.0 + 3.0 + 1.5);
    case.goes(0.0, 3.0, 4.5 + 3.0);
    case.goes(1.0, 3.0, 4.5 + 3.0);
    case.stays_beyond(1.0, 4.0, [0.6, 0.8, 0.0], 1.4 * 38.0 - 2.0 * 0.6);
    case.stays_beyond(1.0, 3.0, [0.6, 0.8, 0.0], 1.4 * 38.0 + 0.6);
    case.stays_beyond(1.0, 4.0, [0.6, 0.0, 0.8], 1.4 * 38.0 - 2.0 * 0.6);
    // A ball's box is about its middle; a turn counts its range.
    let moves = format!("point 0 1 X 10\nfeed 1 1 X -10 arc X Y 0 0 {PI}\nfeed 2 1 C 0.5");
    let links = format!("{SLIDES}\nturn c z 1 0 0 0 0 0 0 C 0 0 1 0 0 0");
    let case = Case { links: &links, b: ["c", PLAIN], moves: &moves, ..case };
    // Middle (0, 10), ball of 5 pi: X within 5 pi, Y within 10 ± 5 pi. With the end of the first step.
    let arm = 40.0 * SQRT_2;
    case.goes(1.0, 3.0, 10.0 * PI + 0.25 * (arm + RADIUS));
}

#[test]
fn what_has_no_rotation_or_direction_is_anywhere() {
    let (moves, x) = ("point 0 1\nfeed 1 1 X 0.5", "slide x - 1 0 0 0 0 0 0 X 1 0 0");
    let case = Case { links: x, a: ["-", PLAIN], b: ["x", PLAIN], centre: [0.0, 0.0, 9.0], moves };
    let free = "1e9 p 0 0 16777216 50000000";
    let are_refused = |case: &Case<'_>| [0.0, 1.0].map(|from| case.why(from, from + 1.0, free).is_some());
    // Of any length but zero.
    for links in [x, "slide x - 1e-9 0 0 0 0 0 0 X 1 0 0", "slide x - 1 0 0 0 0 0 0 X 1e-9 0 0"] {
        assert_eq!(are_refused(&Case { links, ..case }), [false; 2], "{links}");
    }
    for links in [
        "slide x - 0 0 0 0 0 0 0 X 1 0 0",
        "slide x - 1e-200 0 0 0 0 0 0 X 1 0 0",
        "slide x - 1 0 0 0 0 0 0 X 0 0 0",
        "slide x - 1 0 0 0 0 0 0 X 1e-200 0 0",
        "turn x - 1 0 0 0 0 0 0 A 0 0 0 0 0 0",
        "turn x - 1 0 0 0 0 0 0 U 1e-200 0 0 0 0 0",
    ] {
        assert_eq!(are_refused(&Case { links, ..case }), [true; 2], "{links}");
    }
    assert_eq!(are_refused(&Case { a: ["-", "0 0 0 0 0 0 0"], ..case }), [true; 2]);
    assert_eq!(are_refused(&Case { b: ["x", "0 0 0 0 0 0 0"], ..case }), [true; 2]);
    // Neither does the tip follow what has none.
    let moves = "point 0 1 X 14 tip 70\nfeed 1 1 X 6 tip 70";
    for links in [table(SLIDES), table(&SLIDES.replace("Z 0 0 1", "Z 0 0 0")), table(SLIDES).replace("0 0 -2", "0 0 0")]
    {
        let case = Case { links: &links, a: ["c", PLAIN], b: ["z", PLAIN], centre: [3.0, 0.0, 90.0], moves };
        let is_plain = links == table(SLIDES);
        assert_eq!(are_refused(&case), [!is_plain; 2], "{links}");
    }
}

#[test]
fn a_jump_is_refused() {
    // At the end of an arc a part is midway `by` mm, or radians, from where the arc and the next move have it. `b` is on its last link, 100 mm from the origin.
    let jump = |links: &str, first: &str, by: f64| {
        let moves = format!(
            "point 0 1 {first} 10\nfeed 1 1 {first} {} B 10 Y 10 arc {first} {} 0 0 {FRAC_PI_2}",
            2.0 * by,
            if first == "A" { "B" } else { "Y" }
        );
        let text = written(&format!(
            "{links}\n{}{}{moves}\nfeed 2 1 X 3\npair a b rigid\n",
            cube("a - fixture - 1 0 0 0 0 0 0", [0.0; 3], HALF),
            cube("b last fixture - 1 0 0 0 0 0 0", [0.0, 100.0, 0.0], HALF)
        ));
        let answer = check(&text, None, None, MOST_WORK);
        answer.is_err_and(|refusal| refusal.why.contains("the path jumps at move 2, of line 2"))
    };
    let (slide, turn) = (SLIDES.replace("slide z", "slide last"), "turn last - 1 0 0 0 0 0 0");
    let twice = slide.replace("Z 0 0 1", "X 0 0 1");
    let [turned, of_mm] = ["A 0 0 1 0 0 0", "X 0 0 1 0 0 0"].map(|joint| format!("{turn} {joint}"));
    let carried = format!("{}\nslide last t 1 0 0 0 0 0 0 Z 0 0 1", turned.replace("last", "t"));
    // As far as the farthest point goes. Where all joints of an axis stand still, it may jump.
    let arm = 100.0 + RADIUS;
    for (links, axis, most) in [
        (&slide, "X", 1e-7),
        (&twice, "X", 0.5e-7),
        (&slide, "A", f64::INFINITY),
        (&turned, "A", 1e-7 / arm),
        (&carried, "A", 1e-7 / arm),
        (&of_mm, "X", 1e-7 / arm.to_radians()),
    ] {
        for sign in [1.0, -1.0] {
            assert!(!jump(links, axis, 0.95 * sign * most.min(1.0)), "{links}, {axis}");
            assert_eq!(jump(links, axis, 1.05 * sign * most.min(1.0)), most.is_finite(), "{links}, {axis}");
        }
    }
    // A point elsewhere, and a tip that is followed from a move on while the table is turned.
    let tip = table(SLIDES);
    for (links, move_1) in [(SLIDES, "point 1 1 X 11"), (&tip, "feed 1 1 X 11 tip 2")] {
        let a = cube("a z fixture - 1 0 0 0 0 0 0", [0.0; 3], 1.0);
        let turned = if links == SLIDES { "" } else { " C 0.5" };
        let text = format!("{links}\n{a}point 0 1 X 10{turned}\n{move_1}\npair a b rigid\n");
        let refusal = check(&written(&text), None, None, MOST_WORK).unwrap_err();
        assert!(refusal.why.contains("the path jumps at move 1, of line 1"), "{}", refusal.why);
    }
    // A tilt before the quill, from 37.7 degrees to where the interval is bounded and its end alone would not be; then the tip is followed no more.
    let quill = "slide x - 1 0 0 0 0 0 0 X 1 0 0\nslide y x 1 0 0 0 0 0 0 Y 0 1 0\nturn b y 1 0 0 0 0 0 0 B 0 1 0 0 0 0\nslide q b 1 0 0 0 0 0 0 Z 0 0 1\ntip q - 0 0 0 0 0 -1";
    for (end, is_bounded) in [(42.0_f64, true), (43.3, true), (44.0, false), (60.0, false)] {
        let moves = format!("point 0 1 B 0.658 tip 100\nfeed 1 1 B {} tip 100\nfeed 2 1 X 1", end.to_radians());
        let a = cube("a q fixture - 1 0 0 0 0 0 0", [0.0; 3], 1.0);
        let refusal =
            check(&written(&format!("{quill}\n{a}{moves}\npair a b rigid\n")), None, None, MOST_WORK).unwrap_err();
        assert!(refusal.why.contains("the path jumps at move 2, of line 2"), "{end}: {}", refusal.why);
        let still = moves.replace("\nfeed 2 1 X 1", "");
        let case = Case { links: quill, a: ["-", PLAIN], b: ["q", PLAIN], centre: [0.0; 3], moves: &still };
        let why = case.why(1.0, 2.0, "1e9 p 0 0 16777216 0");
        assert_eq!(why.as_deref() != Some("the way cannot be bounded"), is_bounded, "{end}: {why:?}");
    }
    // An arc of no radius has no place.
    let moves = "point 0 1\nfeed 1 1 X 5 arc X Y 0 0 1";
    Case { links: SLIDES, a: ["-", PLAIN], b: ["z", PLAIN], centre: [40.0; 3], moves }.goes_anywhere(1.0, 2.0);
}

/// Slides for the tool in `slides`, a table that turns about Z, and control of the tip.
fn table(slides: &str) -> String {
    format!("{slides}\nturn c - 1 0 0 0 0 0 0 C 0 0 1 0 0 0\ntip z c 0 0 5 0 0 -2")
}

#[test]
fn the_tip_goes_straight_over_the_table() {
    // From (14, 16, 10) to (6, 20, 14): the middle is (10, 18, 12), half the way (-4, 2, 2). The table turns by 0.1 to either side of 0.3.
    let moves = "point 0 1 X 14 Y 16 Z 10 C 0.2 tip 70\nfeed 1 1 X 6 Y 20 Z 14 C 0.4 tip 70";
    // The tip is at (0, 0, 5 - 70); the cube's centre (3, 0, 4) from it.
    let links = table(SLIDES);
    let case = Case { links: &links, a: ["c", PLAIN], b: ["z", PLAIN], centre: [3.0, 0.0, -61.0], moves };
    let (way, turned) = (24.0_f64.sqrt(), 0.1 * (5.0 + RADIUS));
    case.goes(1.0, 2.0, way + turned);
    case.goes(1.5, 1.75, 0.25 * (way + turned));
    case.stays_beyond(0.0, 1.0, [0.0, 0.0, 1.0], 10.0 + 5.0 + 4.0 - HALF);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 12.0 + 5.0 + 4.0 - HALF - 2.0 - turned);
    let (sin, cos) = 0.3_f64.sin_cos();
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 18.0 - 3.0 * sin - HALF * (cos + sin) - 2.0 - turned);
    // Against what stands, the slides follow: a ball over three axes.
    let ball = (way + 0.1 * 10.0_f64.hypot(18.0)) / (1.0 - 3.0_f64.sqrt() * 0.1);
    let case = Case { a: ["-", PLAIN], ..case };
    case.goes(1.0, 2.0, ball * 3.0_f64.sqrt());
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 12.0 + 5.0 + 4.0 - HALF - ball);
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 10.0 * sin + 18.0 * cos - HALF - ball);
    // An arc of the tip: a ball in its plane about the middle, for which the third axis counts as well.
    let moves = format!("point 0 1 X 10 Z 10 tip 70\nfeed 1 1 X 0 Y 10 Z 12 arc X Y 0 0 {FRAC_PI_2} tip 70");
    let case = Case { a: ["c", PLAIN], moves: &moves, ..case };
    case.goes(1.0, 2.0, 1.0 + 2.5 * PI);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 11.0 + 5.0 + 4.0 - HALF - 1.0 - 2.5 * PI);
    let case = Case { a: ["-", PLAIN], ..case };
    case.goes(1.0, 2.0, (1.0 + 2.5 * PI) * 3.0_f64.sqrt());
}

#[test]
fn slides_at_other_angles_follow_the_tip_less_well() {
    // X and Y at the angle whose cosine is `by`.
    let slides = |by: f64| table(&SLIDES.replace("Y 0 1 0", &format!("Y {by} {} 0", (1.0 - by * by).sqrt())));
    let moves = "point 0 1 X 14 Y 16 Z 10 tip 70\nfeed 1 1 X 6 Y 20 Z 14 tip 70";
    let links = slides(0.28);
    let case = Case { links: &links, a: ["c", PLAIN], b: ["z", PLAIN], centre: [3.0, 0.0, -61.0], moves };
    let way = [-4.0 + 2.0 * 0.28, 2.0 * 0.96, 2.0_f64];
    case.goes(1.0, 2.0, way.iter().map(|x| x * x).sum::<f64>().sqrt());
    case.stays_beyond(1.0, 2.0, [0.0, 1.0, 0.0], 18.0 * 0.96 - HALF - way[1]);
    case.stays_beyond(1.0, 2.0, [0.0, 0.0, 1.0], 12.0 + 5.0 + 4.0 - HALF - 2.0);
    let defect = SQRT_2 * 0.28;
    // The middle of an arc's way is as far off as the slides are from square.
    let arc = format!("point 0 1 X 10 Z 10 tip 70\nfeed 1 1 X 0 Y 10 Z 12 arc X Y 0 0 {FRAC_PI_2} tip 70");
    Case { moves: &arc, ..case }.goes(1.0, 2.0, 1.0 + (1.0 + defect).sqrt() * 2.5 * PI);
    let ball = |way: [f64; 3], defect: f64| way.iter().map(|x| x * x).sum::<f64>().sqrt() / (1.0 - defect).sqrt();
    let case = Case { a: ["-", PLAIN], ..case };
    case.goes(1.0, 2.0, ball(way, defect) * 3.0_f64.sqrt());
    // The least singular value must be above 0.2: 1 - defect above 0.04.
    for (by, is_bounded) in [(0.678, true), (0.6795, false), (0.75, false)] {
        let links = slides(by);
        let case = Case { links: &links, ..case };
        if is_bounded {
            let way = [-4.0 + 2.0 * by, 2.0 * (1.0 - by * by).sqrt(), 2.0_f64];
            case.goes(1.0, 2.0, ball(way, SQRT_2 * by) * 3.0_f64.sqrt());
        } else {
            case.goes_anywhere(1.0, 2.0);
        }
    }
}

#[test]
fn what_the_slides_cannot_follow_has_no_bound() {
    let links = table(SLIDES);
    let moves = "point 0 1 X 14 tip 70\nfeed 1 1 X 6 C 0.92 tip 70\nfeed 2 1 C 1.9 tip 70";
    let case = Case { links: &links, a: ["c", PLAIN], b: ["z", PLAIN], centre: [3.0, 0.0, -61.0], moves };
    // 1 - sqrt(3) 0.46 is above 0.2, with 0.49 it is not.
    case.goes(1.0, 2.0, 4.0 + 0.46 * (5.0 + RADIUS));
    case.goes_anywhere(2.0, 3.0);
    case.goes_anywhere(1.0, 3.0);
    case.goes(2.0, 2.5, 0.245 * (5.0 + RADIUS));
    // U moves with the tip, or stands.
    let u = "point 0 1 U 1 tip 70\nfeed 1 1 X 6 tip 70\nfeed 2 1 U 2 tip 70";
    let case = Case { moves: u, ..case };
    case.goes(1.0, 2.0, 3.0);
    case.goes_anywhere(2.0, 3.0);
    // X or U turns something; or there is no such control, or no third slide.
    let turned = format!("{links}\nturn d - 1 0 0 0 0 0 0 X 0 0 1 0 0 0");
    let turned_by_u = turned.replace("X 0 0 1 0 0 0", "U 0 0 1 0 0 0");
    let untold = links.replace("\ntip z c 0 0 5 0 0 -2", "");
    let flat = links.replace("Z 0 0 1", "X 0 0 1");
    // Two slides in one direction are longer together than one.
    let double = links.replace("slide z y", "slide w y 1 0 0 0 0 0 0 Y 0 1 0\nslide z w");
    // So are two at 60 degrees to it, which are as long together.
    let sides = [1.0, -1.0].map(|side| format!("Y {} 0.5 0", side * 0.75_f64.sqrt()));
    let across = double.replacen("Y 0 1 0", &sides[0], 1).replacen("Y 0 1 0", &sides[1], 1);
    for links in [&turned, &turned_by_u, &untold, &flat, &double, &across] {
        Case { links, ..case }.goes_anywhere(1.0, 2.0);
    }
    // An arc that turns the table.
    let arc = |axes: &str| format!("point 0 1 A 0.5 tip 70\nfeed 1 1 arc {axes} 0 0 {} tip 70", 2.0 * PI);
    for (axes, is_bounded) in [("A C", false), ("Z A", false), ("X Y", true)] {
        let moves = arc(axes).replace("A 0.5", if is_bounded { "X 0.5" } else { "A 0.5" });
        let case = Case { moves: &moves, ..case };
        if is_bounded { case.goes(1.0, 2.0, PI * 0.5) } else { case.goes_anywhere(1.0, 2.0) }
    }
}
