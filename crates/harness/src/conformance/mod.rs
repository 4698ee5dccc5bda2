//! Checks that every variant must pass. Anyone can run them on a variant of their own: `conformance::check(&Variant::of::<MyVolume>(..))`.
//!
//! Each check is a function of a [`Variant`] and reports the first fault it finds. [`check`] runs the checks that apply to the variant's
//! kind and safety. The tests of this module run all registered variants, and show that shrunken and subtly wrong volumes fail.

#[cfg(test)]
mod tests;

use crate::geometry::{Isometry, Mesh};
use crate::method::brute::AllPairs;
use crate::method::{Kind, Model};
use crate::registry::Variant;
use crate::tree::distance::Proximity;
use crate::tree::validate::TreeFault;
use crate::tree::{Axes, Policy, SplitRule};
use nalgebra::UnitQuaternion;
use obbtree::cases::{Case, Cases, Draw, contacts, meshes};
use std::sync::LazyLock;

/// The meshes and poses of the suite, made once.
static CASES: LazyLock<Cases> = LazyLock::new(Cases::new);

/// The first fault found in a variant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{variant} on {subject}: {what}")]
pub struct Fault {
    /// Id of the variant.
    pub variant: &'static str,
    /// The mesh or pair of meshes.
    pub subject: String,
    /// The kind of fault.
    pub what: Wrong,
}

/// A kind of fault in a variant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Wrong {
    /// The tree is not well formed, or a corner is outside its node's volume.
    #[error("policy {policy}: {fault}")]
    Tree {
        /// How the tree was built.
        policy: Policy,
        /// The fault of the tree.
        fault: TreeFault,
    },
    /// A verdict differs from that of the control.
    #[error("{view}, pose {a_from_b}: says {verdict}, but every pair of triangles tested says {control}")]
    Verdict {
        /// How the pair was presented to the variant.
        view: View,
        /// The pose.
        a_from_b: Isometry,
        /// The variant's verdict.
        verdict: bool,
        /// The control's verdict.
        control: bool,
    },
    /// The list of touching faces differs from that of the control.
    #[error("pose {a_from_b}: lists {listed} pairs of touching faces, the control {control}, not all the same")]
    List {
        /// The pose.
        a_from_b: Isometry,
        /// Number of pairs that the variant lists.
        listed: usize,
        /// Number of pairs that touch.
        control: usize,
    },
    /// A distance differs from that of the control.
    #[error("pose {a_from_b}: says {found} mm apart, but the nearest pair of triangles is {control} mm apart")]
    Distance {
        /// The pose.
        a_from_b: Isometry,
        /// The variant's distance, mm.
        found: f64,
        /// The control's distance, mm.
        control: f64,
    },
    /// A repeated query gave another verdict, or other operation counts.
    #[error("pose {a_from_b}: two runs of the same query differ")]
    NotDeterministic {
        /// The pose.
        a_from_b: Isometry,
    },
}

/// How a pair is presented to a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// As it is.
    Direct,
    /// The meshes exchanged and the pose inverted.
    Exchanged,
    /// Both meshes are moved in their own frames, and the pose is changed accordingly.
    Moved,
    /// As [`View::Moved`], with a quaternion of a length other than 1.
    Stretched,
}

impl std::fmt::Display for View {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Direct => "as it is",
            Self::Exchanged => "meshes exchanged",
            Self::Moved => "meshes moved in their frames",
            Self::Stretched => "meshes moved in their frames, quaternion not of length 1",
        })
    }
}

/// Every split rule with both choices of axes, and leaves of 1, 3 and 8 triangles.
fn policies() -> impl Iterator<Item = Policy> {
    let (least, most) = (*Policy::LEAF_RANGE.start(), *Policy::LEAF_RANGE.end());
    SplitRule::ALL.into_iter().flat_map(move |split| {
        [Axes::Own, Axes::Shared]
            .into_iter()
            .flat_map(move |axes| [least, 3, most].map(move |leaf| Policy { split, axes, leaf }))
    })
}

/// Runs all checks that apply to the variant's kind and safety.
///
/// Trees of volumes: [`structure`], [`consistency`], [`determinism`] and [`no_false_contact`]; safe ones also [`containment`],
/// [`same_as_control`], [`symmetry`], [`rigid_motion`], [`every_policy`] and [`distance`]. The control: all checks but those about trees.
/// Peers: only [`determinism`], because their triangle tests differ. Methods by samples: [`determinism`]; safe ones also [`no_miss`].
///
/// # Errors
/// The first fault found.
pub fn check(variant: &Variant) -> Result<(), Fault> {
    determinism(variant)?;
    match variant.kind {
        Kind::Peer => return Ok(()),
        Kind::Sampling => return if variant.info.safe { no_miss(variant) } else { Ok(()) },
        Kind::Volume | Kind::Engine | Kind::Control => {}
    }
    no_false_contact(variant)?;
    consistency(variant)?;
    if !variant.info.safe {
        return structure(variant);
    }
    // As `structure`, `containment` and `every_policy` do, but each tree is built once.
    let sound = |model: &dyn Model| model.check_structure().and_then(|()| model.check_containment(0.0));
    under_every_policy(variant, sound, true)?;
    same_as_control(variant)?;
    symmetry(variant)?;
    rigid_motion(variant)?;
    distance(variant)
}

/// Checks that the tree divides the triangles of every mesh properly under every policy.
///
/// # Errors
/// The first malformed tree.
pub fn structure(variant: &Variant) -> Result<(), Fault> {
    each_tree(variant, Model::check_structure)
}

/// Checks that each node's volume contains every corner of the node's triangles, without slack, under every policy.
///
/// # Errors
/// The first corner outside its volume.
pub fn containment(variant: &Variant) -> Result<(), Fault> {
    each_tree(variant, |model| model.check_containment(0.0))
}

/// Checks, in a tree with the variant's own policy, that each volume's reported position, size, outline and slack are consistent
/// ([`crate::volume::consistency`]).
///
/// # Errors
/// The first inconsistent volume.
pub fn consistency(variant: &Variant) -> Result<(), Fault> {
    let Some(policy) = variant.policy else { return Ok(()) };
    for (model, subject) in prepared(variant).iter().zip(&CASES.subjects) {
        model.check_consistency().map_err(|fault| Fault {
            variant: variant.info.id,
            subject: subject.name.to_owned(),
            what: Wrong::Tree { policy, fault },
        })?;
    }
    Ok(())
}

fn each_tree(variant: &Variant, check: impl Fn(&dyn Model) -> Result<(), TreeFault>) -> Result<(), Fault> {
    under_every_policy(variant, check, false)
}

/// Builds the tree of every mesh under every policy and checks it. If `asks`, also compares verdicts on an eleventh of the cases with those
/// of the control.
fn under_every_policy(
    variant: &Variant,
    check: impl Fn(&dyn Model) -> Result<(), TreeFault>,
    asks: bool,
) -> Result<(), Fault> {
    /// One case in this many is used: few enough for 30 policies, and coprime to the number of poses of a pair.
    const PART: usize = 11;
    for (number, policy) in policies().enumerate() {
        let models: Vec<_> =
            CASES.subjects.iter().map(|subject| variant.prepare(&subject.mesh, Some(policy))).collect();
        for (model, subject) in models.iter().zip(&CASES.subjects) {
            check(&**model).map_err(|fault| Fault {
                variant: variant.info.id,
                subject: subject.name.to_owned(),
                what: Wrong::Tree { policy, fault },
            })?;
        }
        for case in CASES.cases.iter().skip(number % PART).step_by(PART).filter(|_| asks) {
            let (verdict, _) = models[case.a].first_counted(&*models[case.b], &case.a_from_b);
            let control = !case.contacts.is_empty();
            if verdict != control {
                let what = Wrong::Verdict { view: View::Direct, a_from_b: case.a_from_b, verdict, control };
                return Err(fault(variant, case, what));
            }
        }
    }
    Ok(())
}

/// Each mesh of the suite, prepared under the variant's own policy.
fn prepared(variant: &Variant) -> Vec<Box<dyn Model>> {
    CASES.subjects.iter().map(|subject| variant.prepare(&subject.mesh, None)).collect()
}

fn fault(variant: &Variant, case: &Case, what: Wrong) -> Fault {
    let name = |index: usize| CASES.subjects[index].name;
    Fault { variant: variant.info.id, subject: format!("{} : {}", name(case.a), name(case.b)), what }
}

/// Checks that repeated queries, of models prepared twice, one by one and in a batch, give the same verdicts and the same counts.
///
/// # Errors
/// The first query that differs.
pub fn determinism(variant: &Variant) -> Result<(), Fault> {
    let (models, again) = (prepared(variant), prepared(variant));
    for case in &CASES.cases {
        let pose = &case.a_from_b;
        let once = models[case.a].first_counted(&*models[case.b], pose);
        let twice = again[case.a].first_counted(&*again[case.b], pose);
        let mut batch = Vec::new();
        models[case.a].first(&*models[case.b], &[*pose, *pose], &mut batch);
        if once != twice || batch != [once.0; 2] {
            return Err(fault(variant, case, Wrong::NotDeterministic { a_from_b: *pose }));
        }
    }
    Ok(())
}

/// Checks that the variant never reports a contact when no two triangles touch. This holds for unsafe volumes too, because the leaves
/// decide.
///
/// # Errors
/// The first false contact.
pub fn no_false_contact(variant: &Variant) -> Result<(), Fault> {
    compare(variant, |verdict, control| !verdict || control)
}

/// Checks that the variant agrees with the control at every pose, and lists the same touching faces in mode `all`.
///
/// # Errors
/// The first difference.
pub fn same_as_control(variant: &Variant) -> Result<(), Fault> {
    compare(variant, |verdict, control| verdict == control)?;
    let models = prepared(variant);
    for case in &CASES.cases {
        let (listed, _) = models[case.a].all_counted(&*models[case.b], &case.a_from_b);
        if listed != case.contacts {
            let what = Wrong::List { a_from_b: case.a_from_b, listed: listed.len(), control: case.contacts.len() };
            return Err(fault(variant, case, what));
        }
    }
    Ok(())
}

/// Checks that the variant reports a contact at every pose at which two triangles touch. False contacts are permitted.
///
/// # Errors
/// The first missed contact.
pub fn no_miss(variant: &Variant) -> Result<(), Fault> {
    compare(variant, |verdict, control| verdict || !control)
}

fn compare(variant: &Variant, agree: impl Fn(bool, bool) -> bool) -> Result<(), Fault> {
    let models = prepared(variant);
    for case in &CASES.cases {
        let (verdict, _) = models[case.a].first_counted(&*models[case.b], &case.a_from_b);
        let control = !case.contacts.is_empty();
        if !agree(verdict, control) {
            let what = Wrong::Verdict { view: View::Direct, a_from_b: case.a_from_b, verdict, control };
            return Err(fault(variant, case, what));
        }
    }
    Ok(())
}

/// Checks that the variant, queried for `b` against `a` at the inverse pose, agrees with the control on the same query. (The control is
/// queried again, because now the corners of the other mesh are moved and snapped, which can change the verdict within 1e-8 mm of contact.)
///
/// # Errors
/// The first difference.
pub fn symmetry(variant: &Variant) -> Result<(), Fault> {
    let models = prepared(variant);
    for case in &CASES.cases {
        let b_from_a = case.a_from_b.inverse();
        let (a, b) = CASES.meshes(case);
        let (verdict, _) = models[case.b].first_counted(&*models[case.a], &b_from_a);
        let control = !contacts(&b.triangles(), &a.triangles(), &b_from_a).is_empty();
        if verdict != control {
            let what = Wrong::Verdict { view: View::Exchanged, a_from_b: b_from_a, verdict, control };
            return Err(fault(variant, case, what));
        }
    }
    Ok(())
}

/// Checks that the variant agrees with the control after either mesh is moved in its own frame and the pose is adjusted accordingly. No
/// volume may depend on the position of a part's origin, or on the length of the quaternion, which is 1 ± 1e-7 at two of three poses
/// ([`crate::volume::Shape::pose`]).
///
/// # Errors
/// The first difference.
pub fn rigid_motion(variant: &Variant) -> Result<(), Fault> {
    /// Largest displacement of an origin, mm.
    const SHIFT: f64 = 100.0;
    /// Lengths of quaternions, in turn; coprime to the number of poses of an approach.
    const LENGTHS: [(f64, View); 3] =
        [(1.0, View::Moved), (1.0 + 1e-7, View::Stretched), (1.0 - 1e-7, View::Stretched)];
    let motion = |index: usize| {
        let mut draw = Draw::new(0, &["conformance", "frame", CASES.subjects[index].name], 0);
        // A mesh that fills the range has no room to be moved in.
        let room = CASES.subjects[index].mesh.vertices().iter().all(|v| v.coords.norm() < 3500.0);
        if room { Isometry::from_parts((draw.in_ball() * SHIFT).into(), draw.rotation()) } else { Isometry::identity() }
    };
    let motions: Vec<Isometry> = (0..CASES.subjects.len()).map(motion).collect();
    let moved: Vec<Mesh> = CASES
        .subjects
        .iter()
        .zip(&motions)
        .map(|(subject, motion)| meshes::moved(&subject.mesh, 1.0, motion))
        .collect();
    let models: Vec<_> = moved.iter().map(|mesh| variant.prepare(mesh, None)).collect();
    let triangles: Vec<_> = moved.iter().map(Mesh::triangles).collect();
    for (case, (length, view)) in CASES.cases.iter().zip(LENGTHS.into_iter().cycle()) {
        let pose = motions[case.a] * case.a_from_b * motions[case.b].inverse();
        let quaternion = *pose.rotation.quaternion() * length;
        let pose = Isometry::from_parts(pose.translation, UnitQuaternion::new_unchecked(quaternion));
        let (verdict, _) = models[case.a].first_counted(&*models[case.b], &pose);
        let control = !contacts(&triangles[case.a], &triangles[case.b], &pose).is_empty();
        if verdict != control {
            let what = Wrong::Verdict { view, a_from_b: pose, verdict, control };
            return Err(fault(variant, case, what));
        }
    }
    Ok(())
}

/// Checks that the variant finds the distance that testing every pair of triangles finds, so no lower bound exceeds the true distance. Uses
/// a fifth of the cases.
///
/// # Errors
/// The first difference.
pub fn distance(variant: &Variant) -> Result<(), Fault> {
    /// One case in this many is used; coprime to the number of poses of an approach.
    const PART: usize = 5;
    /// Tolerance, mm. Both sides measure the same triangles, so only the last bits may differ.
    const TOLERANCE_MM: f64 = 1e-9;
    let models = prepared(variant);
    let controls: Vec<AllPairs> = CASES.subjects.iter().map(|subject| AllPairs(subject.mesh.triangles())).collect();
    for case in CASES.cases.iter().step_by(PART) {
        let measure =
            |a: &dyn Model, b: &dyn Model| a.distance_mm(b, &case.a_from_b, f64::INFINITY, &mut Proximity::default());
        let found = measure(&*models[case.a], &*models[case.b]);
        let control = measure(&controls[case.a], &controls[case.b]);
        if (found - control).abs() > TOLERANCE_MM {
            return Err(fault(variant, case, Wrong::Distance { a_from_b: case.a_from_b, found, control }));
        }
    }
    Ok(())
}

/// Checks that the verdicts agree with the control under every policy, on an eleventh of the cases each.
///
/// # Errors
/// The first difference.
pub fn every_policy(variant: &Variant) -> Result<(), Fault> {
    under_every_policy(variant, |_| Ok(()), true)
}
