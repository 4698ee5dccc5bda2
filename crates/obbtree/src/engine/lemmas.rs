//! Lemmas A, B and C of `docs/proofs.md`, which Gappa cannot hold: each looked at where its error is largest, found by climbing from many places.
//!
//! What the lanes compute in `f32` is held against the same in `f64`, whose own rounding is 2⁻²⁹ of the errors here.

use super::boxes::{along, backwards};
use super::lanes::{FOUR, Lanes, Machine, Row, Simd, WIDTH, Work};
use super::pose::Motion;
use super::volume::U;
use crate::engine::geometry::Vector;
use nalgebra::{Quaternion, UnitQuaternion, Vector4};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The longest vector part of a stored rotation (`super::turn`): the sine of 31.4°.
const LONGEST: f64 = 0.521;

/// A rotation as it is stored, the pose's (or the box's), and a way.
#[derive(Clone, Copy)]
struct At {
    stored: [f32; 3],
    pose: UnitQuaternion<f64>,
    way: [f32; 3],
}

/// What the lanes make of a place: the box's quaternion after the pose, that of a child seen from it, and the way along its axes.
#[derive(Clone, Copy, Debug)]
struct Found {
    turned: [f32; FOUR],
    seen: [f32; FOUR],
    along: [f32; 3],
}

struct Finding<'a>(&'a At);

impl Work for Finding<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<M: Machine>(self) -> Found {
        fn first<L: Lanes>(x: L) -> f32 {
            let mut to = [[0.0; WIDTH]; 2];
            x.store(0, &mut to);
            to[0][0]
        }
        let At { stored: [x, y, z], pose, way } = *self.0;
        let motion = Motion::of(pose);
        let turn = M::Single::spread(Motion::turned(&|_| &motion, <M::Single as Lanes>::Row::of(|_| [x, y, z, 0.0])));
        let all = |v: [f32; 3]| v.map(M::Single::all);
        let pose = pose.coords.map(|x| x as f32);
        let pose = [pose.x, pose.y, pose.z, pose.w].map(M::Single::all);
        Found {
            turned: turn.map(first),
            seen: backwards(&pose, &all([x, y, z])).map(first),
            along: along(&pose, &all(way)).map(first),
        }
    }
}

fn whole([x, y, z]: [f32; 3]) -> Quaternion<f64> {
    let v = Vector::from([x, y, z].map(f64::from));
    Quaternion::from_parts((1.0 - v.norm_squared()).sqrt(), v)
}

fn wide(q: [f32; FOUR]) -> Vector4<f64> {
    Vector4::from(q.map(f64::from))
}

/// The errors that the three lemmas are about, in units of `U`.
fn errors(at: &At, simd: Simd) -> [f64; 3] {
    let found = simd.run(Finding(at));
    let rounded = Quaternion::from(at.pose.coords.map(|x| f64::from(x as f32)));
    let (stored, way) = (whole(at.stored), Vector::from(at.way.map(f64::from)));
    // A box's quaternion after the pose; a child's, seen from a box with the quaternion as it is.
    let turned = (at.pose.into_inner() * stored).coords;
    let seen = (rounded.conjugate() * stored).coords;
    let (v, w) = (rounded.imag(), rounded.w);
    let cross = v.cross(&way);
    let along = way - cross * (2.0 * w) + v.cross(&cross) * 2.0;
    [
        (wide(found.turned) - turned).norm(),
        (wide(found.seen) - seen).norm() / rounded.norm(),
        (Vector::from(found.along.map(f64::from)) - along).norm() / way.norm(),
    ]
    .map(|error| error / f64::from(U))
}

fn draw(random: &mut Pcg64) -> At {
    let mut number = || 2.0 * random.random::<f64>() - 1.0;
    let mut vector = || Vector::from([(); 3].map(|()| number()));
    let (stored, length, pose, way) = (vector(), vector().x.abs().sqrt(), [vector(), vector()], vector());
    let pose = Quaternion::new(pose[0].x, pose[0].y, pose[0].z, pose[1].x);
    At {
        stored: (stored.normalize() * LONGEST * length).map(|x| x as f32).into(),
        pose: UnitQuaternion::new_normalize(pose),
        way: way.map(|x| x as f32).into(),
    }
}

/// A place near another one.
fn near(at: &At, random: &mut Pcg64) -> At {
    let size = 10f64.powf(-7.0 * random.random::<f64>());
    let mut shift = |x: f64| x + size * (2.0 * random.random::<f64>() - 1.0);
    let stored = Vector::from(at.stored.map(|x| shift(f64::from(x))));
    let stored = stored * (LONGEST / stored.norm()).min(1.0);
    At {
        stored: stored.map(|x| x as f32).into(),
        pose: UnitQuaternion::new_normalize(Quaternion::from(at.pose.coords.map(&mut shift))),
        way: at.way.map(|x| shift(f64::from(x)) as f32),
    }
}

/// No place that is climbed to has an error above the lemma's; and the worst is a seventh of it at least, without which the climb would tell nothing.
#[test]
fn the_lemmas_hold_where_their_errors_are_largest() {
    let bounds = [6.5, 5.5, 18.2];
    let mut random = Pcg64::seed_from_u64(29);
    for simd in Simd::available() {
        for (lemma, bound) in bounds.into_iter().enumerate() {
            let mut worst = 0.0_f64;
            for _ in 0..12 {
                let mut at = draw(&mut random);
                let mut error = errors(&at, simd)[lemma];
                for _ in 0..1500 {
                    let other = near(&at, &mut random);
                    let there = errors(&other, simd)[lemma];
                    if there > error {
                        (at, error) = (other, there);
                    }
                }
                worst = worst.max(error);
            }
            let name = ["A", "B", "C"][lemma];
            assert!(worst <= bound, "lemma {name}, {}: {worst}u of {bound}u", simd.name());
            assert!(worst > 0.15 * bound, "lemma {name}, {}: {worst}u of {bound}u", simd.name());
        }
    }
}
