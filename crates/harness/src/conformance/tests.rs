//! All registered variants pass, and deliberately wrong ones fail.

use super::*;
use crate::geometry::separating_axes::{separated, widened_abs};
use crate::geometry::{Point, Triangle, Vector};
use crate::registry;
use crate::volume::fit;
use crate::volume::fit::centre::{CentreRule, MidExtent};
use crate::volume::fit::frame::AreaCovariance;
use crate::volume::obb_area::ObbArea;
use crate::volume::obb_area_centroid::ObbAreaCentroid;
use crate::volume::obb_vertex_centroid::ObbVertexCentroid;
use crate::volume::shape::obb::Obb;
use crate::volume::{BoundingVolume, Info, Segment, Shape, Solid};
use nalgebra::{Matrix3, Unit};
use rayon::prelude::*;

const fn info(id: &'static str) -> Info {
    Info { id, label: id, reference: "made wrong on purpose", safe: true }
}

#[test]
fn every_registered_variant_conforms() {
    let faults: Vec<Fault> =
        registry::standard().variants().par_iter().filter_map(|variant| check(variant).err()).collect();
    assert!(faults.is_empty(), "{}", faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("\n"));
}

#[test]
fn the_literal_boxes_leave_corners_outside_and_miss_contacts() {
    let literal =
        [Variant::of::<ObbVertexCentroid>(SplitRule::VertexMean), Variant::of::<ObbAreaCentroid>(SplitRule::AreaMean)];
    for variant in literal {
        assert!(matches!(
            containment(&variant),
            Err(Fault { what: Wrong::Tree { fault: TreeFault::Outside { .. }, .. }, .. })
        ));
        assert!(matches!(
            same_as_control(&variant),
            Err(Fault { what: Wrong::Verdict { verdict: false, control: true, .. }, .. })
        ));
    }
}

#[test]
fn samples_alone_miss_contacts() {
    let sampled = *registry::standard().variants().iter().find(|v| v.kind == Kind::Sampling && !v.info.safe).unwrap();
    assert!(matches!(no_miss(&sampled), Err(Fault { what: Wrong::Verdict { verdict: false, control: true, .. }, .. })));
}

#[test]
fn the_peer_agrees_away_from_contact() {
    let parry = *registry::standard().variants().iter().find(|v| v.kind == Kind::Peer).unwrap();
    let models = prepared(&parry);
    let clear = CASES
        .cases
        .iter()
        .filter(|case| CASES.subjects[case.a].name == "torus" && CASES.subjects[case.b].name == "torus");
    let mut disagreements = 0;
    let mut asked = 0;
    for case in clear {
        asked += 1;
        let (verdict, _) = models[case.a].first_counted(&*models[case.b], &case.a_from_b);
        disagreements += usize::from(verdict == case.contacts.is_empty());
    }
    // Of seven offsets three lie within 1e-6 of the pair's size of contact, where its tolerance may decide otherwise.
    assert!(asked >= 42 && disagreements * 7 <= asked * 3, "{disagreements} of {asked}");
}

/// Tight half-lengths, two percent too short.
#[derive(Clone, Copy, Debug)]
struct TwoPercentShort;

impl CentreRule for TwoPercentShort {
    fn centre_and_half(low: &Vector, high: &Vector) -> (Vector, Vector) {
        let (centre, half) = MidExtent::centre_and_half(low, high);
        (centre, half * 0.98)
    }
}

#[derive(Clone, Debug)]
struct Shrunken;

impl BoundingVolume for Shrunken {
    const INFO: Info = info("shrunken");
    type Shape = Obb;

    fn fit(triangles: &[Triangle]) -> Obb {
        fit::oriented::<AreaCovariance, TwoPercentShort>(triangles)
    }
}

#[test]
fn a_shrunken_box_fails_in_every_way() {
    let shrunken = Variant::of::<Shrunken>(SplitRule::AreaMean);
    assert!(matches!(check(&shrunken), Err(Fault { what: Wrong::Tree { fault: TreeFault::Outside { .. }, .. }, .. })));
    for miss in [same_as_control(&shrunken), symmetry(&shrunken), rigid_motion(&shrunken), every_policy(&shrunken)] {
        assert!(
            matches!(miss, Err(Fault { what: Wrong::Verdict { verdict: false, control: true, .. }, .. })),
            "{miss:?}"
        );
    }
    assert_eq!(structure(&shrunken), Ok(()));
    assert_eq!(no_false_contact(&shrunken), Ok(()));
}

/// The fault in the overlap test of a [`Faulty`] box; the fit of the box is correct.
trait Flaw: Clone + std::fmt::Debug + Send + Sync + 'static {
    const INFO: Info;
    fn overlaps(t: &Vector, r: &Matrix3<f64>, a: &Vector, b: &Vector) -> bool;
}

/// Does not widen |R|, so rounding decides between nearly parallel edges.
#[derive(Clone, Debug)]
struct WithoutEpsilon;

impl Flaw for WithoutEpsilon {
    const INFO: Info = info("without-epsilon");
    fn overlaps(t: &Vector, r: &Matrix3<f64>, a: &Vector, b: &Vector) -> bool {
        !separated(t, r, &r.abs(), a, b)
    }
}

/// Omits the absolute value of one entry of R.
#[derive(Clone, Debug)]
struct WrongSign;

impl Flaw for WrongSign {
    const INFO: Info = info("wrong-sign");
    fn overlaps(t: &Vector, r: &Matrix3<f64>, a: &Vector, b: &Vector) -> bool {
        let mut q = widened_abs(r);
        q[(1, 2)] = r[(1, 2)];
        !separated(t, r, &q, a, b)
    }
}

/// Uses the inverse of the rotation.
#[derive(Clone, Debug)]
struct Transposed;

impl Flaw for Transposed {
    const INFO: Info = info("transposed");
    fn overlaps(t: &Vector, r: &Matrix3<f64>, a: &Vector, b: &Vector) -> bool {
        let r = r.transpose();
        !separated(t, &r, &widened_abs(&r), a, b)
    }
}

#[derive(Clone, Debug)]
struct Faulty<F> {
    axes: Matrix3<f64>,
    centre: Point,
    half: Vector,
    sound: Obb,
    flaw: std::marker::PhantomData<F>,
}

impl<F: Flaw> BoundingVolume for Faulty<F> {
    const INFO: Info = F::INFO;

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        let sound = ObbArea::fit(triangles);
        // The edges of the outline that run along axis 0, 1 and 2 are four in a row each.
        let edges = sound.outline();
        let along = [0, 4, 8].map(|edge| edges[edge][1] - edges[edge][0]);
        let half = Vector::from(along.map(|edge| 0.5 * edge.norm()));
        let axes = Matrix3::from_columns(&along.map(|edge| edge.normalize()));
        Self { axes, centre: sound.centre(), half, sound, flaw: std::marker::PhantomData }
    }
}

impl<F: Flaw> Shape for Faulty<F> {
    type Pose = Isometry;

    fn pose(a_from_b: &Isometry) -> Isometry {
        *a_from_b
    }

    fn overlaps(&self, other: &Self, pose: &Isometry) -> bool {
        let t = self.axes.tr_mul(&(pose * other.centre - self.centre));
        let r = self.axes.tr_mul(&(pose.rotation.to_rotation_matrix() * other.axes));
        F::overlaps(&t, &r, &self.half, &other.half)
    }

    fn gap_mm(&self, other: &Self, pose: &Isometry) -> f64 {
        self.sound.gap_mm(&other.sound, &Obb::pose(pose))
    }

    fn size(&self) -> f64 {
        self.sound.size()
    }

    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        self.sound.split_axes(triangles)
    }
}

impl<F: Flaw> Solid for Faulty<F> {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        self.sound.contains(point, slack_mm)
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn volume(&self) -> f64 {
        self.sound.volume()
    }

    fn surface_area(&self) -> f64 {
        self.sound.surface_area()
    }

    fn outline(&self) -> Vec<Segment> {
        self.sound.outline()
    }
}

#[test]
fn wrong_overlap_tests_fail() {
    let faulty = [
        Variant::of::<Faulty<WithoutEpsilon>>(SplitRule::AreaMean),
        Variant::of::<Faulty<WrongSign>>(SplitRule::AreaMean),
        Variant::of::<Faulty<Transposed>>(SplitRule::AreaMean),
    ];
    for variant in faulty {
        assert_eq!(containment(&variant), Ok(()), "the fit is right");
        let found = check(&variant);
        assert!(
            matches!(found, Err(Fault { what: Wrong::Verdict { verdict: false, control: true, .. }, .. })),
            "{} {found:?}",
            variant.info.id
        );
    }
}

/// A correct box that reports one figure of itself wrongly; `LIE` selects the figure.
#[derive(Clone, Debug)]
struct Lying<const LIE: usize>(Obb);

/// The check that must catch each fault, in the order of the faults.
const LIES: [&str; 10] = [
    "split_axes: the axes are not square",
    "centre: it lies outside",
    "outline: it leaves the volume",
    "outline: it ends within the volume",
    "not all are positive",
    "surface_area: it is too little",
    "surface_area: it is more",
    "volume: it is not that of the points",
    "contains: a point nearer than the slack is left out",
    "contains: a point farther than the slack is let in",
];

impl<const LIE: usize> Lying<LIE> {
    /// The factor of this fault; 1 when another fault is selected.
    fn factor(of: [(usize, f64); 2]) -> f64 {
        of.into_iter().find(|(lie, _)| *lie == LIE).map_or(1.0, |(_, factor)| factor)
    }
}

impl<const LIE: usize> BoundingVolume for Lying<LIE> {
    const INFO: Info = info("lying");

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        Self(ObbArea::fit(triangles))
    }
}

impl<const LIE: usize> Shape for Lying<LIE> {
    type Pose = <Obb as Shape>::Pose;

    fn pose(a_from_b: &Isometry) -> Self::Pose {
        Obb::pose(a_from_b)
    }

    fn overlaps(&self, other: &Self, pose: &Self::Pose) -> bool {
        self.0.overlaps(&other.0, pose)
    }

    /// The last fault shows only between two volumes: disjoint volumes are a millimetre nearer than the reported gap.
    fn gap_mm(&self, other: &Self, pose: &Self::Pose) -> f64 {
        let gap_mm = self.0.gap_mm(&other.0, pose);
        if LIE == LIES.len() && gap_mm > 0.0 { gap_mm + 1.0 } else { gap_mm }
    }

    fn size(&self) -> f64 {
        if LIE == 4 { -1.0 } else { self.0.size() }
    }

    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        let [x, y, z] = self.0.split_axes(triangles);
        if LIE == 0 { [x, x, z] } else { [x, y, z] }
    }
}

impl<const LIE: usize> Solid for Lying<LIE> {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        self.0.contains(point, slack_mm * Self::factor([(8, 0.9), (9, 10.0)]))
    }

    fn centre(&self) -> Point {
        let out = self.0.outline()[0][0] - self.0.centre();
        self.0.centre() + if LIE == 1 { out * 2.0 + Vector::x() } else { Vector::zeros() }
    }

    fn volume(&self) -> f64 {
        self.0.volume() * if LIE == 7 { 0.9 } else { 1.0 }
    }

    fn surface_area(&self) -> f64 {
        self.0.surface_area() * Self::factor([(5, 0.1), (6, 1.1)])
    }

    fn outline(&self) -> Vec<Segment> {
        let longer = Self::factor([(2, 1.1), (3, 0.9)]);
        let centre = self.0.centre();
        self.0.outline().into_iter().map(|edge| edge.map(|end| centre + (end - centre) * longer)).collect()
    }
}

fn lying<const LIE: usize>() -> Variant {
    Variant::of::<Lying<LIE>>(SplitRule::AreaMean)
}

#[test]
fn what_a_volume_says_of_itself_must_be_so() {
    let liars = [
        lying::<0>(),
        lying::<1>(),
        lying::<2>(),
        lying::<3>(),
        lying::<4>(),
        lying::<5>(),
        lying::<6>(),
        lying::<7>(),
        lying::<8>(),
        lying::<9>(),
    ];
    for (liar, lie) in liars.iter().zip(LIES) {
        let found = check(liar).expect_err(lie).to_string();
        assert!(found.contains(lie), "{found}, where `{lie}` is wrong");
    }
}

#[test]
fn a_gap_that_is_too_wide_fails() {
    let liar = lying::<{ LIES.len() }>();
    assert_eq!(consistency(&liar), Ok(()), "of itself it says what is so");
    let found = check(&liar);
    assert!(matches!(found, Err(Fault { what: Wrong::Distance { .. }, .. })), "{found:?}");
}

/// Answers no at every second pose, which [`determinism`] must detect.
#[derive(Clone, Debug)]
struct Moody(Obb);

static MOOD: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);

impl BoundingVolume for Moody {
    const INFO: Info = info("moody");

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        Self(Shrunken::fit(triangles))
    }
}

impl Shape for Moody {
    type Pose = (<Obb as Shape>::Pose, bool);

    fn pose(a_from_b: &Isometry) -> Self::Pose {
        let mood = MOOD.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        (Obb::pose(a_from_b), mood.is_multiple_of(2))
    }

    fn overlaps(&self, other: &Self, (pose, mood): &Self::Pose) -> bool {
        *mood && self.0.overlaps(&other.0, pose)
    }

    fn gap_mm(&self, other: &Self, (pose, _): &Self::Pose) -> f64 {
        self.0.gap_mm(&other.0, pose)
    }

    fn size(&self) -> f64 {
        self.0.size()
    }

    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        self.0.split_axes(triangles)
    }
}

impl Solid for Moody {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        self.0.contains(point, slack_mm)
    }

    fn centre(&self) -> Point {
        self.0.centre()
    }

    fn volume(&self) -> f64 {
        self.0.volume()
    }

    fn surface_area(&self) -> f64 {
        self.0.surface_area()
    }

    fn outline(&self) -> Vec<Segment> {
        self.0.outline()
    }
}

#[test]
fn a_moody_volume_is_not_deterministic() {
    let found = determinism(&Variant::of::<Moody>(SplitRule::Median));
    assert!(matches!(found, Err(Fault { what: Wrong::NotDeterministic { .. }, .. })), "{found:?}");
}
