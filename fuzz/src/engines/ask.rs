//! The questions, and what is a wrong answer.

use super::{Case, Mismatch, Posed};
use bvbench::geometry::{Isometry, Mesh};
use bvbench::method::Kind;
use bvbench::registry::Variant;
use bvbench::tree::distance::Proximity;
use obbtree::engine::aligned::Aligned;
use obbtree::engine::ball::Ball;
use obbtree::engine::oriented::Oriented;
use obbtree::engine::traverse::{self, Scratch};
use obbtree::engine::{Coherence, Memory, Simd, WideTree, WideVolume, distance};
use std::fmt::Debug;

/// How much a measured distance may be off, relative to the size of everything: 2⁻²², what the engine allows for. Two edges that are nearly parallel
/// are measured at a place that rounding chooses.
const MEASURED: f64 = 1.0 / 4_194_304.0;

/// Asks the wide trees of all three volumes: of every pose on every instruction set, and of a path on one for each coherence, another for every
/// `turn`.
pub fn wide_trees(case: &Case, turn: usize) -> Result<u64, Mismatch> {
    Ok(wide::<Oriented>(case, turn)? + wide::<Aligned>(case, turn)? + wide::<Ball>(case, turn)?)
}

fn wide<V: WideVolume>(case: &Case, turn: usize) -> Result<u64, Mismatch> {
    let (a, b) = (WideTree::<V>::build(&case.a), WideTree::<V>::build(&case.b));
    let mut questions = 0;
    for simd in Simd::available() {
        let who = || format!("{} on {}", std::any::type_name::<V>(), simd.name());
        let (mut scratch, mut warm) = (Scratch::default(), Proximity::default());
        for pose in &case.poses {
            let at = &pose.a_from_b;
            equal(
                case,
                at,
                || format!("{}: first", who()),
                &traverse::first(&a, &b, at, simd, &mut scratch),
                &!pose.contacts.is_empty(),
            )?;
            equal(
                case,
                at,
                || format!("{}: all", who()),
                &traverse::all(&a, &b, at, simd, &mut scratch),
                &pose.contacts,
            )?;
            for proximity in [&mut Proximity::default(), &mut warm] {
                let found = distance::distance_mm(&a, &b, at, simd, f64::INFINITY, proximity);
                near(case, pose, || format!("{}: distance", who()), found)?;
            }
            questions += 4;
        }
    }
    for (k, coherence) in Coherence::ALL.into_iter().enumerate() {
        let simds = Simd::available();
        let simd = simds[(turn % simds.len() + k) % simds.len()];
        let mut memory = Memory::default();
        for (at, touching) in &case.path {
            let found = memory.first(&a, &b, at, simd, coherence);
            let who = || format!("{} on {}: first, coherence {coherence}", std::any::type_name::<V>(), simd.name());
            equal(case, at, who, &found, touching)?;
            questions += 1;
        }
    }
    Ok(questions)
}

/// Whether [`variant`] asks it: it promises to miss nothing, is ours, and is not a wide tree, which has been asked.
pub fn is_asked(variant: &Variant) -> bool {
    variant.info.safe && !matches!(variant.kind, Kind::Peer | Kind::Engine)
}

/// Asks one variant of the registry. What samples a mesh may say of meshes apart that they touch, and has no list and no distance.
pub fn variant(case: &Case, variant: &Variant) -> Result<u64, Mismatch> {
    let prepare = |mesh: &Mesh| variant.prepare(mesh, None);
    let (a, b) = (prepare(&case.a), prepare(&case.b));
    let id = variant.info.id;
    for pose in &case.poses {
        let (at, touching) = (&pose.a_from_b, !pose.contacts.is_empty());
        let (verdict, _) = a.first_counted(&*b, at);
        if variant.kind == Kind::Sampling {
            equal(case, at, || format!("{id}: no miss"), &(verdict || !touching), &true)?;
            continue;
        }
        equal(case, at, || format!("{id}: first"), &verdict, &touching)?;
        equal(case, at, || format!("{id}: all"), &a.all_counted(&*b, at).0, &pose.contacts)?;
        let found = a.distance_mm(&*b, at, f64::INFINITY, &mut Proximity::default());
        near(case, pose, || format!("{id}: distance"), found)?;
    }
    let poses: Vec<Isometry> = case.path.iter().map(|(pose, _)| *pose).collect();
    let mut verdicts = Vec::with_capacity(poses.len());
    a.first(&*b, &poses, &mut verdicts);
    for ((at, touching), verdict) in case.path.iter().zip(verdicts) {
        let right = verdict == *touching || (verdict && variant.kind == Kind::Sampling);
        equal(case, at, || format!("{id}: first, on a path"), &right, &true)?;
    }
    Ok((3 * case.poses.len() + case.path.len()) as u64)
}

fn equal<T: PartialEq + Debug>(
    case: &Case,
    at: &Isometry,
    question: impl Fn() -> String,
    found: &T,
    expected: &T,
) -> Result<(), Mismatch> {
    if found == expected {
        Ok(())
    } else {
        Err(mismatch(case, at, &question(), &format!("{found:?}, not {expected:?}")))
    }
}

/// A distance: 0 where the meshes touch, and that of all pairs where they do not.
fn near(case: &Case, pose: &Posed, question: impl Fn() -> String, found: f64) -> Result<(), Mismatch> {
    let at = &pose.a_from_b;
    if !pose.contacts.is_empty() {
        return equal(case, at, question, &found, &0.0);
    }
    let (distance, size) = pose.distance_and_size_mm;
    if (found - distance).abs() <= MEASURED * size {
        return Ok(());
    }
    Err(mismatch(case, at, &question(), &format!("{found:e}, not {distance:e}, where everything is {size:e} mm large")))
}

fn mismatch(case: &Case, at: &Isometry, question: &str, answer: &str) -> Mismatch {
    let (t, q) = (at.translation.vector, at.rotation.coords);
    let (faces_a, faces_b) = (case.a.faces().len(), case.b.faces().len());
    Mismatch(format!(
        "{question}: {answer}\n  {faces_a} and {faces_b} triangles, translation ({:e}, {:e}, {:e}) mm, quaternion (x, y, z, w) = \
         ({:e}, {:e}, {:e}, {:e})",
        t.x, t.y, t.z, q.x, q.y, q.z, q.w
    ))
}
