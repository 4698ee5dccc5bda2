use super::*;
use crate::play::{Plan, Player};
use crate::testing;
use bvbench::registry;
use bvbench::truth::PairOracle;

const CYCLE_S: f64 = 0.004;
const DEADLINE_S: f64 = 0.02;

fn rule(acceleration: f64) -> Rule {
    Rule { dynamics: testing::dynamics(acceleration), deadline_s: DEADLINE_S, near_mm: 2.0 }
}

fn state(x: f64, velocity: f64) -> State {
    let at = |value: f64| {
        let mut position = Position::default();
        position[Axis::X] = value;
        position
    };
    State {
        position: at(x),
        velocity: at(velocity),
        velocity_error: Position::default(),
        interval_s: CYCLE_S,
        spread_s: 0.0,
        tool: 0,
    }
}

fn judge(scene: &Scene) -> Judge<'_> {
    Judge::new(scene, registry::standard().fastest().unwrap(), rule(1000.0)).unwrap()
}

#[test]
fn the_look_ahead_is_the_formula() {
    // s = 100 + 1000 · 0.028 = 128 mm/s, T = 0.128 s, H = 0.02 + 0.064 s; b(H) = 0.001 + 1000 · (H² / 2 + 0.008 H) = 4.201 mm, vH = 8.4 mm.
    let scene = testing::mill();
    assert!((horizon_s(&scene, &rule(1000.0), &state(0.0, 100.0)) - 0.084).abs() < 1e-12);
    let far = 100.0 * 0.084 + 4.201;
    // The holder's right side is 50 mm from the block. What is guaranteed is short of the formula by the motion bound, in which Y and Z have their shares.
    let mut judge = judge(&scene);
    let at = |judge: &mut Judge<'_>, x: f64| judge.judge(&state(x, 100.0));
    assert_eq!(at(&mut judge, 0.0).verdict, Verdict::Clear);
    let answer = at(&mut judge, 50.0 - far + 0.1);
    assert_eq!((answer.verdict, answer.clearance_mm), (Verdict::Collision, 0.0));
    assert_eq!(scene.pair_name(answer.pair.unwrap()), "block:holder");
    let (b_all, near) = (3.0 * 4.201, 2.0);
    let sure = 50.0 - 8.4 - b_all - near - 0.5;
    assert_eq!(at(&mut judge, sure).verdict, Verdict::Clear, "{:?}", at(&mut judge, sure));
    let close = at(&mut judge, sure + 1.5);
    assert!(matches!(close.verdict, Verdict::Near) && close.clearance_mm < 2.0, "{close:?}");
}

#[test]
fn an_old_distance_spares_queries_as_long_as_enough_is_left_of_it() {
    let scene = testing::mill();
    let mut judge = judge(&scene);
    // From 80 mm before the block towards it, 0.4 mm per sample, until it is near.
    let answers: Vec<Answer> = (0..300)
        .map(|i| judge.judge(&state(-30.0 + 0.4 * f64::from(i), 100.0)))
        .take_while(|a| a.verdict == Verdict::Clear)
        .collect();
    let queries: u32 = answers.iter().map(|answer| answer.queries).sum();
    assert!(answers.len() > 100 && (4..30).contains(&queries), "{queries} queries for {} samples", answers.len());
    assert!(answers.iter().all(|answer| answer.clearance_mm == 2.0 && answer.pair.is_none()));
    // Nothing is left of it after a jump.
    assert_eq!(judge.judge(&state(-150.0, 0.0)).verdict, Verdict::Clear);
    assert_eq!(judge.judge(&state(70.0, 0.0)).verdict, Verdict::Collision);
}

#[test]
fn moving_away_is_clear_where_moving_towards_is_not() {
    let scene = testing::mill();
    let mut judge = judge(&scene);
    assert_eq!(judge.judge(&state(35.0, 100.0)).verdict, Verdict::Collision);
    assert_eq!(judge.judge(&state(35.0, -100.0)).verdict, Verdict::Clear);
    assert_eq!(judge.judge(&state(35.0, 0.0)).verdict, Verdict::Clear);
}

#[test]
fn inside_is_a_collision() {
    // A holder that is in the block with all of its surface, as after a reset of the zero point.
    let scene = testing::mill();
    let mut judge = judge(&scene);
    assert_eq!(judge.judge(&state(70.0, 0.0)).verdict, Verdict::Collision);
}

#[test]
fn ignorance_is_never_clear() {
    let scene = testing::mill();
    let mut judge = judge(&scene);
    let beyond = judge.judge(&state(-200.1, 0.0));
    assert_eq!(beyond.verdict, Verdict::Unknown);
    assert_eq!(beyond.cause.unwrap().to_string(), "axis X at -200.1 mm is outside its limits -200 to 200 mm");
    for (x, velocity) in [(f64::NAN, 0.0), (0.0, f64::INFINITY)] {
        let answer = judge.judge(&state(x, velocity));
        assert_eq!((answer.verdict, answer.cause), (Verdict::Unknown, Some(Ignorance::NotFinite('X'))));
    }
    assert!(!Verdict::Unknown.permits() && !Verdict::Collision.permits());
}

#[test]
fn an_axis_may_be_shown_a_few_resolutions_beyond_its_limits() {
    let scene = testing::mill();
    let mut judge = judge(&scene);
    // Resolution 0.001 mm.
    for x in [-200.0, -200.0004, -200.0029, 200.0029] {
        let answer = judge.judge(&state(x, 0.0));
        assert_eq!((answer.verdict, answer.cause), (Verdict::Clear, None), "{x}");
    }
    for x in [-200.0031, 200.0031] {
        assert!(matches!(judge.judge(&state(x, 0.0)).cause, Some(Ignorance::OutOfLimits(_))), "{x}");
    }
}

#[test]
fn parts_that_come_near_just_beyond_the_limits_are_watched() {
    // At the limit of X the balls around block and holder are farther apart by `gap_mm` than is near.
    let scene = |gap_mm: f64| {
        let radius = |part: usize| pairs::ball(&testing::mill().parts[part]).radius;
        let most = 70.0 - radius(0) - radius(1) - 2.0 - gap_mm;
        let text = testing::SCENE.replace("-200, max_mm = 200", "0, max_mm = 0");
        testing::scene(&text.replacen("max_mm = 0", &format!("max_mm = {most}"), 1))
    };
    // Each of three axes may be shown 0.003 mm beyond its limits.
    let judge = |scene: &Scene| Judge::new(scene, registry::standard().fastest().unwrap(), rule(1000.0)).map(drop);
    assert!(judge(&scene(0.008)).is_ok());
    assert!(matches!(judge(&scene(0.010)), Err(JudgeError::NoPairs(_))));
}

#[test]
fn what_cannot_be_calculated_is_never_clear() {
    let scene = testing::mill();
    let mut judge = judge(&scene);
    // The way and its bound are infinite, and what is left between them is not a number.
    for velocity in [1e200, 1e308, f64::MAX] {
        let answer = judge.judge(&state(0.0, velocity));
        assert!(!answer.verdict.permits(), "{velocity}: {answer:?}");
    }
    // A joint without limits may say any number.
    let text = testing::SCENE.replace(", min_mm = -200, max_mm = 200", "");
    let scene = testing::scene(&text);
    let mut judge = self::judge(&scene);
    for x in [1.1e9, -1e200, f64::MAX] {
        let answer = judge.judge(&state(x, 0.0));
        assert_eq!((answer.verdict, answer.cause), (Verdict::Unknown, Some(Ignorance::TooFar('X'))));
    }
    assert_eq!(judge.judge(&state(-1e8, 0.0)).verdict, Verdict::Clear);
}

#[test]
fn an_error_of_the_velocity_widens_the_way() {
    let scene = testing::mill();
    let mut judge = judge(&scene);
    let sure = State { position: state(30.0, 0.0).position, ..state(30.0, 50.0) };
    assert_eq!(judge.judge(&sure).verdict, Verdict::Clear);
    let mut unsure = sure;
    unsure.velocity_error[Axis::X] = 200.0;
    assert_eq!(judge.judge(&unsure).verdict, Verdict::Collision);
}

#[test]
fn variants_that_miss_are_refused() {
    let scene = testing::mill();
    let registry = registry::standard();
    let missing = registry.variants().iter().find(|variant| !variant.info.safe).unwrap();
    assert!(matches!(Judge::new(&scene, missing, rule(1.0)), Err(JudgeError::Unsafe(_))));
}

/// Plays a program with a hold that takes effect a whole deadline after the sample that calls for it, and returns where the machine
/// stands; `None` when it was never held.
fn play(scene: &Scene, program: &str, variant: &Variant) -> Option<Position> {
    let dynamics = testing::dynamics(1000.0);
    let plan = Plan::new(scene, &testing::run(scene, program), &dynamics, CYCLE_S).unwrap();
    let mut player = Player::new(plan, dynamics, CYCLE_S);
    let mut judge = Judge::new(scene, variant, rule(1000.0)).unwrap();
    let (mut last, mut held_since) = (player.place().position, None);
    for cycle in 0.. {
        let position = player.place().position;
        let velocity = Position(std::array::from_fn(|i| (position.0[i] - last.0[i]) / CYCLE_S));
        last = position;
        let state = State { position, velocity, ..state(0.0, 0.0) };
        if held_since.is_none() && !judge.judge(&state).verdict.permits() {
            held_since = Some(cycle);
        }
        let is_held = held_since.is_some_and(|since| f64::from(cycle - since) * CYCLE_S >= DEADLINE_S - 1e-9);
        player.cycle(!is_held);
        if is_held && player.stands() {
            return Some(player.place().position);
        }
        if player.is_over() {
            return None;
        }
    }
    None
}

#[test]
fn every_hold_comes_before_contact_and_a_clear_program_has_none() {
    let scene = testing::mill();
    let registry = registry::standard();
    let pair = scene.pairs.first().copied().unwrap_or(Pair { a: 0, b: 1 });
    let oracle = PairOracle::new(Arc::clone(&scene.parts[pair.a].mesh), Arc::clone(&scene.parts[pair.b].mesh));
    let clearance =
        |at: &Position| oracle.clearance_mm(&scene.a_from_b(pair, &scene.machine.forward(at)), f64::INFINITY);
    for id in ["sphere-ritter", "aabb", "dop-8", "obb-vertex", "obb-area"] {
        let variant = registry.find(id).unwrap();
        for program in [
            "G1 X100 F1800\n",
            "G1 X100 F6000\n",
            "G0 X100\n",
            "G0 Z40\nG0 X70\nG1 Z0 F3000\n",
            "G0 Y40\nG1 X70 F3000\nG1 Y0\n",
            "G1 Y-60 F6000\nG3 X70 Y0 R70\n",
            "G1 X46 F9000\nG1 X46 Y30\nG1 X70 Y10\n",
        ] {
            let stands = play(&scene, program, variant).unwrap_or_else(|| panic!("{id}: {program} was never held"));
            assert!(clearance(&stands) > 0.0, "{id}: {program} touches");
        }
        assert_eq!(play(&scene, "G1 X-40 F6000\nG1 Y70\nG1 X80\nG1 X-40\n", variant), None, "{id}");
    }
}
