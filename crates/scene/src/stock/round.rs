//! A turning part as pieces: the body of revolution around its mesh, and by how much the mesh may fall short of it.
//!
//! A spindle turns the mesh. What it sweeps at a height is a disc where the mesh holds the axis, and a ring around a bore ([`super::bore`]) where it does not.
//! Where circles wholly outside the mesh separate parts of it, as between a hole saw and its pilot drill, it is a disc and rings, or several rings; whether they
//! do is asked at five heights between two neighbouring ones at which vertices lie. Between these two, the distance from the axis is a convex function along each
//! edge: chords bound the radius from outside, tangents from inside. The slack of a piece is the greatest difference of these bounds: a point nearer to the axis
//! than the outline by more than that is in the swept body. Shells of a mesh that overlap, such as inserts in their holder, are bodies of their own. Of an open
//! mesh the outer body is a cylinder, and nothing is swept for sure.

use super::bore::{Bore, BoreSlab, upper_envelope};
use super::convex::{Convex, Cube, HalfPlane, Least, Lowest, rho};
use crate::geometry::{Isometry, Mesh, Point, Vector};
use crate::interference::revolved::{frustum_mm3, nearest_to_axis};
use crate::interference::{ROUND, Revolved};
use crate::truth::Solid;
use std::sync::Arc;

/// Heights nearer than this are one, mm.
pub(super) const SAME_HEIGHT_MM: f64 = 1e-7;
/// Part of the greatest coordinate by which files may round the coordinates of vertices: seven digits, turned and added up.
const ROUNDED: f64 = 1e-6;
/// Heights at which the profile may have a corner, where a mesh has more: as many where most vertices are, and up to twice as many beside what is free of vertices.
const MOST_HEIGHTS: usize = 1000;
/// Slopes that differ by less than this are one; over 100 mm that is 1e-7 mm.
const STRAIGHT: f64 = 1e-9;
/// Part of the largest radius that a hollow of the profile is filled up to, where so much of it is not known either: between irregular vertices the profile of
/// a convex body has such.
const FILLED: f64 = 0.01;

/// A body of revolution about z.
#[derive(Clone, Debug)]
pub(super) struct Round {
    /// Their union holds the body.
    pub pieces: Vec<Piece>,
    /// The greatest slack of its pieces, mm, where that is known.
    pub slack_mm: f64,
    /// Takes the mesh's frame to the body's.
    pub body_from_part: Isometry,
    /// Fraction of the body that the mesh fills, 0 to 1. Bores count as part of the body, except those of a workpiece that turns.
    pub filled: f64,
    /// Largest radius, and lowest and highest z, mm.
    pub radius_mm: f64,
    pub span_mm: [f64; 2],
}

/// A piece of a body of revolution.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub convex: Convex,
    /// What is hollow of it.
    pub bore: Option<Bore>,
    /// Uncertainty of the radius, mm: a point nearer to the axis than the outline by more than this is in the body for sure. Infinite if no point is. The ends are exact.
    pub slack_mm: f64,
    /// Largest radius, and lowest and highest z, mm.
    radius: f64,
    span: [f64; 2],
}

/// Role of a mesh in the simulation of cutting.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// A part that turns.
    Turning,
    /// A part that does not turn.
    Standing,
    /// A workpiece that turns.
    Stock,
}

/// A disc or a ring of the profile between two heights: radii at both from outside and from inside, mm.
#[derive(Clone, Copy, Debug)]
struct Slab {
    z: [f64; 2],
    outer: [f64; 2],
    inner: [f64; 2],
    /// Where the axis is not in the mesh.
    bore: Option<BoreSlab>,
    /// Rings around it between the same heights.
    rank: usize,
}

impl Round {
    /// The body around a mesh that turns about its own axis. Grooves of the outline that are at most `groove_mm` wide, along the axis, are filled.
    pub fn new(mesh: &Arc<Mesh>, groove_mm: f64) -> Self {
        Self::of(mesh, Revolved::around(mesh), groove_mm, Purpose::Turning)
    }

    /// The body around a mesh that turns about z of the frame to which `body_from_part` leads.
    pub fn about(mesh: &Arc<Mesh>, body_from_part: Isometry, groove_mm: f64) -> Self {
        Self::of(mesh, Revolved::about(mesh, body_from_part), groove_mm, Purpose::Turning)
    }

    /// The body around a mesh that does not turn; `None` where the mesh is not round.
    pub fn standing(mesh: &Arc<Mesh>) -> Option<Self> {
        let revolved = Revolved::around(mesh);
        (revolved.filled >= ROUND).then(|| Self::of(mesh, revolved, 0.0, Purpose::Standing))
    }

    /// The body around a workpiece that turns about its own axis. Its bore is known with all steps.
    pub fn stock(mesh: &Arc<Mesh>) -> Self {
        Self::of(mesh, Revolved::around(mesh), 0.0, Purpose::Stock)
    }

    fn of(mesh: &Arc<Mesh>, revolved: Revolved, groove_mm: f64, purpose: Purpose) -> Self {
        let Revolved { tool_from_mesh, filled, profile, volume_mm3 } = revolved;
        let places: Vec<Point> = mesh.vertices().iter().map(|vertex| tool_from_mesh * vertex).collect();
        if !mesh.edge_report().is_watertight() {
            return Self::around_open(&places, tool_from_mesh);
        }
        let shells =
            shells(mesh).into_iter().map(|shell| Shell::new(&shell, &tool_from_mesh, groove_mm, purpose)).collect();
        let shells = uncovered(shells);
        let swept_mm3: f64 = shells.iter().map(|shell| shell.swept_mm3).sum();
        let pieces: Vec<Piece> = shells.into_iter().flat_map(|shell| shell.pieces).collect();
        let known = pieces.iter().map(|piece| piece.slack_mm).filter(|slack| slack.is_finite());
        Self {
            slack_mm: known.fold(0.0, f64::max),
            pieces,
            body_from_part: tool_from_mesh,
            // A workpiece is as round with a bore as without.
            filled: match purpose {
                Purpose::Stock => (filled * volume_mm3 / swept_mm3).max(filled).min(1.0),
                Purpose::Turning | Purpose::Standing => filled,
            },
            radius_mm: profile.radius_mm(),
            span_mm: profile.span_mm(),
        }
    }

    /// The cylinder around a mesh that encloses nothing: what is in it for sure, nobody knows.
    fn around_open(places: &[Point], body_from_part: Isometry) -> Self {
        let radius = places.iter().map(|place| place.x.hypot(place.y)).fold(0.0, f64::max);
        let (low, high) = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
        let plane = |a: f64, b: f64, c: f64| HalfPlane { a, b, c };
        let planes = vec![plane(0.0, -1.0, -low), plane(0.0, 1.0, high), plane(1.0, 0.0, radius)];
        let span = [low, high];
        let piece = Piece { convex: Convex { planes }, bore: None, slack_mm: f64::INFINITY, radius, span };
        Self { pieces: vec![piece], slack_mm: 0.0, body_from_part, filled: 0.0, radius_mm: radius, span_mm: span }
    }

    /// The same of which no point is in the part for sure.
    pub fn vague(&self) -> Self {
        let vague = |piece: &Piece| Piece { slack_mm: f64::INFINITY, ..piece.clone() };
        Self { pieces: self.pieces.iter().map(vague).collect(), ..self.clone() }
    }

    /// Whether all of it is known to within a length.
    pub fn is_known(&self) -> bool {
        self.pieces.iter().all(|piece| piece.slack_mm.is_finite())
    }

    /// Whether it is solid, and known to be.
    pub fn is_solid(&self) -> bool {
        self.pieces.iter().all(|piece| piece.bore.is_none() && piece.slack_mm.is_finite())
    }

    /// Whether no point is in the part for sure.
    pub fn is_vague(&self) -> bool {
        self.pieces.iter().all(|piece| piece.slack_mm == f64::INFINITY)
    }

    /// How deep a point can be at most, mm: in all of it, and in what is thin of it and stands out of the rest by more than `out_mm`.
    pub fn deepest_mm(&self, out_mm: f64) -> f64 {
        let [low, high] = self.span_mm;
        let whole = self.radius_mm.min(0.5 * (high - low));
        let is_covered = |thin: &Piece| {
            let covers = |other: &Piece| {
                other.wall_mm() > out_mm
                    && other.span[0] - out_mm <= thin.span[0]
                    && thin.span[1] <= other.span[1] + out_mm
            };
            self.pieces.iter().any(covers)
        };
        let of_piece = |piece: &Piece| {
            let wall = if is_covered(piece) { f64::INFINITY } else { piece.wall_mm() };
            wall.min(0.5 * self.length_mm(piece, piece.radius - out_mm))
        };
        self.pieces.iter().map(of_piece).fold(whole, f64::min)
    }

    /// The length along the axis of what is connected to a piece and reaches to a radius, mm.
    fn length_mm(&self, piece: &Piece, radius: f64) -> f64 {
        let [mut low, mut high] = piece.span;
        loop {
            let is_met = |other: &&Piece| {
                let [from, to] = other.span;
                other.radius >= radius && from <= high + SAME_HEIGHT_MM && to >= low - SAME_HEIGHT_MM
            };
            let met = self.pieces.iter().filter(is_met);
            let all = met.fold([low, high], |[l, h], other| [l.min(other.span[0]), h.max(other.span[1])]);
            if all == [low, high] {
                return high - low;
            }
            [low, high] = all;
        }
    }

    /// As [`Convex::lowest`], over all pieces; `high` is that of the part.
    pub fn least(&self, q: &Vector, travel: &Vector, cube: &Cube) -> Least {
        let mut found = Least { low: f64::INFINITY, high: f64::INFINITY, deep: f64::INFINITY };
        for of_piece in self.lowest(q, travel, cube) {
            let Least { low, high, deep } = of_piece.1.least;
            found = Least { low: found.low.min(low), high: found.high.min(high), deep: found.deep.min(deep) };
            if found.high <= cube.inside {
                break;
            }
        }
        found
    }

    /// As [`Convex::lowest`], of each piece; `high` is that of the part. Of those whose cylinders are too far away nothing more is asked.
    pub fn lowest<'a>(
        &'a self,
        q: &'a Vector,
        travel: &'a Vector,
        cube: &'a Cube,
    ) -> impl Iterator<Item = (&'a Piece, Lowest)> {
        let end = q - travel;
        let (lowest, highest) = (q.z.min(end.z), q.z.max(end.z));
        let across = travel.x * travel.x + travel.y * travel.y;
        let part = if across > 0.0 { ((q.x * travel.x + q.y * travel.y) / across).clamp(0.0, 1.0) } else { 0.0 };
        let (x, y) = (q.x - part * travel.x, q.y - part * travel.y);
        let nearest = (x * x + y * y).sqrt();
        self.pieces.iter().map(move |piece| {
            let [low, high] = piece.span;
            let apart = (nearest - piece.radius).max(lowest - high).max(low - highest);
            if apart - cube.radius < cube.outside {
                return (piece, piece.lowest(q, travel, cube));
            }
            let least = Least { low: apart, high: f64::INFINITY, deep: apart - cube.radius };
            (piece, Lowest { least, at: 0.0, value: least.deep, normal: Vector::zeros() })
        })
    }
}

impl Piece {
    /// How deep a point can be below its outer surface, mm: to the axis, or to the middle of its ring.
    fn wall_mm(&self) -> f64 {
        self.radius - self.bore.as_ref().map_or(0.0, |bore| bore.middle_mm)
    }

    fn lowest(&self, q: &Vector, travel: &Vector, cube: &Cube) -> Lowest {
        let Some(bore) = &self.bore else {
            let cube = Cube { inside: cube.inside - self.slack_mm, ..*cube };
            let mut found = self.convex.lowest(q, travel, &cube);
            if self.slack_mm > 0.0 {
                let p = q - travel * found.at;
                found.least.high = self.short_of(rho(&p), p.z);
            }
            return found;
        };
        // Where the convex piece is deepest the bore may be.
        let mut found = self.convex.lowest(q, travel, &Cube { inside: f64::NEG_INFINITY, ..*cube });
        if found.least.deep >= cube.outside {
            found.least.high = f64::INFINITY;
            return found;
        }
        let hollow = bore.hollow(q, &(q - travel));
        found.least.low = found.least.low.max(hollow);
        found.least.deep = found.least.deep.max(hollow - cube.radius);
        let middle = [bore.middle_mm, f64::midpoint(self.span[0], self.span[1])];
        let highs = places(q, travel, found.at, middle).map(|at| {
            let p = q - travel * at;
            self.short_of(rho(&p), p.z).max(bore.short_of(&p))
        });
        found.least.high = highs.fold(f64::INFINITY, f64::min);
        found
    }

    /// How far (ρ, z) is from what is in the body for sure if it has no bore, mm; negative inside.
    pub fn short_of(&self, rho: f64, z: f64) -> f64 {
        let nowhere = if self.slack_mm.is_finite() { f64::NEG_INFINITY } else { f64::INFINITY };
        let of = |plane: &HalfPlane| {
            let slack = if plane.a > 0.0 { self.slack_mm } else { 0.0 };
            plane.a * rho + plane.b * z - plane.c + slack
        };
        self.convex.planes.iter().map(of).fold(nowhere, f64::max)
    }

    /// What is in the body for sure, as a piece.
    fn for_sure(mut self) -> Self {
        for plane in self.convex.planes.iter_mut().filter(|plane| plane.a > 0.0) {
            plane.c -= self.slack_mm;
        }
        self.slack_mm = 0.0;
        self
    }
}

/// Parts of a way at which a point may be deepest in a ring around the axis: the ends, where it is at the ring's radius or height, and `at`.
fn places(q: &Vector, travel: &Vector, at: f64, [radius, z]: [f64; 2]) -> impl Iterator<Item = f64> {
    let (a, b) = (travel.xy().norm_squared(), q.xy().dot(&travel.xy()));
    let root = (b * b - a * (q.xy().norm_squared() - radius * radius)).max(0.0).sqrt();
    let all = [0.0, 1.0, at, (b - root) / a, (b + root) / a, (q.z - z) / travel.z];
    all.into_iter().filter(|at| (0.0..=1.0).contains(at))
}

/// Most shells of a mesh that are taken one by one.
const MOST_SHELLS: usize = 64;

/// The closed surfaces of a watertight mesh that do not share vertices; the mesh itself where one of them is the wall of a hollow.
fn shells(mesh: &Arc<Mesh>) -> Vec<Arc<Mesh>> {
    let whole = || vec![Arc::clone(mesh)];
    let (numbers, count) = mesh.components();
    if !(2..=MOST_SHELLS).contains(&count) {
        return whole();
    }
    let mut faces = vec![Vec::new(); count];
    for (face, number) in mesh.faces().iter().zip(numbers) {
        faces[number as usize].push(*face);
    }
    let shell = |faces| Mesh::new(mesh.vertices().to_vec(), faces).ok().map(Mesh::without_unused_vertices);
    let shells: Option<Vec<Mesh>> = faces.into_iter().map(shell).collect();
    match shells {
        Some(shells) if shells.iter().all(|shell| shell.signed_volume() > 0.0) => {
            shells.into_iter().map(Arc::new).collect()
        }
        _ => whole(),
    }
}

/// A closed surface that turns.
struct Shell {
    /// The outermost disc or ring at each height.
    slabs: Vec<Slab>,
    pieces: Vec<Piece>,
    /// Volume of what it sweeps, mm³.
    swept_mm3: f64,
}

impl Shell {
    fn new(mesh: &Arc<Mesh>, body_from_part: &Isometry, groove_mm: f64, purpose: Purpose) -> Self {
        let mut places: Vec<Point> = mesh.vertices().iter().map(|vertex| body_from_part * vertex).collect();
        let greatest = mesh.vertices().iter().map(|vertex| vertex.coords.amax()).fold(0.0, f64::max);
        let same_mm = SAME_HEIGHT_MM.max(ROUNDED * greatest);
        level(&mut places, same_mm);
        let solid = Solid::new(Arc::clone(mesh));
        let part_from_body = body_from_part.inverse();
        let holds = |p: &Point| solid.holds(&(part_from_body * p));
        let stands = purpose == Purpose::Standing;
        let upright = Upright { places: &places, faces: mesh.faces(), holds: &holds, stands };
        let rings: Vec<Vec<Slab>> = slabs(&places, mesh.faces()).iter().map(|slab| upright.rings(slab)).collect();
        let stack = |rank: usize| -> Vec<Slab> { rings.iter().map(|all| all[rank.min(all.len() - 1)]).collect() };
        let mut slabs = stack(0);
        fill_grooves(&mut slabs, groove_mm);
        let most = rings.iter().map(Vec::len).max().unwrap_or(0);
        let is_stock = purpose == Purpose::Stock;
        let within = (1..most).flat_map(|rank| pieces(&stack(rank), rank, is_stock, same_mm));
        let pieces = pieces(&slabs, 0, is_stock, same_mm).into_iter().chain(within).collect();
        Self { pieces, slabs, swept_mm3: rings.iter().flatten().map(Slab::swept_mm3).sum() }
    }

    /// Whether all that it sweeps is in what `other` sweeps for sure.
    fn is_within(&self, other: &Self) -> bool {
        let solid = || other.pieces.iter().filter(|piece| piece.bore.is_none());
        self.slabs.iter().all(|Slab { z, outer, .. }| {
            let holds = |piece: &Piece, rho: f64, z: f64| piece.short_of(rho, z) <= 0.0;
            solid().any(|piece| (0..2).all(|k| holds(piece, outer[k], z[k]) && holds(piece, 0.0, z[k])))
        })
    }
}

/// Without those that are within another.
fn uncovered(mut shells: Vec<Shell>) -> Vec<Shell> {
    let mut at = 0;
    while at < shells.len() {
        let is_within = (0..shells.len()).any(|other| other != at && shells[at].is_within(&shells[other]));
        if is_within {
            shells.remove(at);
        } else {
            at += 1;
        }
    }
    shells
}

/// Heights between two neighbouring ones at which the mesh is looked at, as parts of the way: near both ends, and between.
const LOOKED_AT: [f64; 5] = [0.01, 0.25, 0.5, 0.75, 0.99];

/// A mesh in the frame of its axis.
struct Upright<'a> {
    places: &'a [Point],
    faces: &'a [[u32; 3]],
    holds: &'a dyn Fn(&Point) -> bool,
    stands: bool,
}

impl Upright<'_> {
    /// Splits a slab into its discs and rings, outermost first. If they differ between its heights, gives one slab of which nothing is known.
    fn rings(&self, slab: &Slab) -> Vec<Slab> {
        let [low, high] = slab.z;
        let meets = |face: &&[u32; 3]| {
            let heights = face.map(|corner| self.places[corner as usize].z);
            heights.iter().any(|&z| z < high) && heights.iter().any(|&z| z > low)
        };
        let faces: Vec<[u32; 3]> = self.faces.iter().filter(meets).copied().collect();
        let sections = LOOKED_AT.map(|part| self.section(&faces, low + part * (high - low)));
        if sections.iter().all(|rings| rings.len() <= 1) {
            return vec![self.bored(*slab, &faces, true)];
        }
        let is_between = |p: &Point| p.z > low + SAME_HEIGHT_MM && p.z < high - SAME_HEIGHT_MM;
        let is_same = sections.iter().all(|rings| *rings == sections[0]);
        if !is_same || self.places.iter().any(is_between) {
            return vec![Slab { bore: Some(BoreSlab::unknown(slab.z)), ..*slab }];
        }
        let innermost = sections[0].len() - 1;
        let ring = |(rank, faces): (usize, &Vec<[u32; 3]>)| {
            let mut ring = Slab { rank, ..Slab::between(low, high) };
            for (p, q) in faces.iter().flat_map(|face| edges(face, self.places)) {
                ring.add(&p, &q, &mut [0.0; PARTS]);
            }
            self.bored(ring, faces, rank == innermost)
        };
        sections[0].iter().enumerate().map(ring).collect()
    }

    /// The faces that meet a height, in groups from the outermost inwards: the circles between two groups are outside the mesh.
    fn section(&self, faces: &[[u32; 3]], z: f64) -> Vec<Vec<[u32; 3]>> {
        let met = |face: &[u32; 3]| Some((radii_at(face.map(|corner| self.places[corner as usize]), z)?, *face));
        let mut met: Vec<([f64; 2], [u32; 3])> = faces.iter().filter_map(met).collect();
        met.sort_by(|([_, one], _), ([_, other], _)| other.total_cmp(one));
        let (mut groups, mut nearest): (Vec<Vec<[u32; 3]>>, f64) = (Vec::new(), f64::INFINITY);
        for ([near, far], face) in met {
            // No surface is between the two: circles there are wholly inside or outside.
            let is_gap = far < nearest - SAME_HEIGHT_MM;
            match groups.last_mut() {
                Some(group) if !is_gap || (self.holds)(&Point::new(f64::midpoint(far, nearest), 0.0, z)) => {
                    group.push(face);
                }
                _ => groups.push(vec![face]),
            }
            nearest = nearest.min(near);
        }
        groups.iter_mut().for_each(|group| group.sort_unstable());
        groups
    }

    /// A slab of these faces, with its bore; the innermost has none where it holds the axis.
    fn bored(&self, slab: Slab, faces: &[[u32; 3]], is_innermost: bool) -> Slab {
        let bore = || BoreSlab::new(slab.z, self.places, faces);
        if !is_innermost || !slab.holds_axis(self.holds) {
            Slab { bore: Some(bore()), ..slab }
        } else if self.stands {
            // What stands is only there up to its nearest face, not up to its farthest edge.
            Slab { inner: bore().empty, ..slab }
        } else {
            slab
        }
    }
}

/// The least and the greatest distance from the axis of a triangle where it meets a height, mm.
fn radii_at(corners: [Point; 3], z: f64) -> Option<[f64; 2]> {
    let crossing = |k: usize| {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        ((p.z < z) != (q.z < z)).then(|| p + (q - p) * ((z - p.z) / (q.z - p.z)))
    };
    let ends: Vec<Point> = (0..3).filter_map(crossing).collect();
    let nearest = nearest_to_axis(&ends)?;
    let far = ends.iter().map(|end| end.x.hypot(end.y)).fold(0.0, f64::max);
    Some([nearest.x.hypot(nearest.y), far])
}

/// The edges of a face, none of them downwards.
fn edges(face: &[u32; 3], places: &[Point]) -> [(Point, Point); 3] {
    [0, 1, 2].map(|side| {
        let [p, q] = [face[side], face[(side + 1) % 3]].map(|corner| places[corner as usize]);
        // Each edge of a closed mesh runs once up and once down.
        if p.z <= q.z { (p, q) } else { (q, p) }
    })
}

/// Parts of a slab for which edges that end in it are taken one by one.
const PARTS: usize = 16;

fn slabs(places: &[Point], faces: &[[u32; 3]]) -> Vec<Slab> {
    let heights = heights(places);
    let mut slabs: Vec<Slab> = heights.windows(2).map(|ends| Slab::between(ends[0], ends[1])).collect();
    let mut least = vec![[0.0; PARTS]; slabs.len()];
    for (p, q) in faces.iter().flat_map(|face| edges(face, places)) {
        let first = heights.partition_point(|&z| z < p.z - SAME_HEIGHT_MM).saturating_sub(1);
        let met = slabs[first..].iter_mut().zip(&mut least[first..]);
        for (slab, least) in met.take_while(|(slab, _)| slab.z[0] < q.z + SAME_HEIGHT_MM) {
            slab.add(&p, &q, least);
        }
    }
    slabs.iter_mut().zip(&least).for_each(|(slab, least)| slab.raise(least));
    slabs
}

/// Gives vertices one height that lie at one up to rounding: the lowest of theirs, at the top the highest of all.
fn level(places: &mut [Point], same_mm: f64) {
    let mut upwards: Vec<&mut Point> = places.iter_mut().collect();
    upwards.sort_by(|a, b| a.z.total_cmp(&b.z));
    let top = upwards.last().map_or(0.0, |place| place.z);
    let mut level = f64::NEG_INFINITY;
    for place in upwards {
        if place.z - level > same_mm {
            level = place.z;
        }
        place.z = if top - level <= same_mm { top } else { level };
    }
}

fn heights(places: &[Point]) -> Vec<f64> {
    let mut all: Vec<f64> = places.iter().map(|place| place.z).collect();
    all.sort_by(f64::total_cmp);
    let (low, high) = (all[0], all[all.len() - 1]);
    all.dedup_by(|next, kept| *next - *kept <= SAME_HEIGHT_MM);
    if all.len() > MOST_HEIGHTS {
        // Every so manyth, and both ends of what is free of vertices.
        let (stride, wide) = (all.len().div_ceil(MOST_HEIGHTS), (high - low) / MOST_HEIGHTS as f64);
        let is_wide = |from: usize| all.get(from + 1).is_none_or(|next| next - all[from] > wide);
        let is_kept = |&k: &usize| k % stride == 0 || is_wide(k) || is_wide(k - 1);
        all = (0..all.len()).filter(is_kept).map(|k| all[k]).collect();
    }
    // The ends may have been given up for a neighbour that is one with them.
    if let [first, .., last] = &mut all[..] {
        (*first, *last) = (low, high);
    }
    all
}

impl Slab {
    const fn between(low: f64, high: f64) -> Self {
        Self { z: [low, high], outer: [0.0; 2], inner: [0.0; 2], bore: None, rank: 0 }
    }

    /// Whether the mesh holds the axis near both ends and between.
    fn holds_axis(&self, holds: &dyn Fn(&Point) -> bool) -> bool {
        let [low, high] = self.z;
        LOOKED_AT.iter().all(|part| {
            // The axis of a tool in its own frame runs through vertices; a ray beside it does not begin on a triangle.
            let beside = 1e-4 * (self.outer[0] + part * (self.outer[1] - self.outer[0]));
            holds(&Point::new(0.7 * beside, 0.3 * beside, low + part * (high - low)))
        })
    }

    /// Volume of what it sweeps, mm³.
    fn swept_mm3(&self) -> f64 {
        let height = self.z[1] - self.z[0];
        let hollow = self.bore.and_then(|bore| bore.filled).map_or(0.0, |radii| frustum_mm3(radii, height));
        frustum_mm3(self.outer, height) - hollow
    }

    /// How much the mesh may fall short of radii that are linear in it, mm; infinite where nothing is known.
    fn missing(&self, radius: &dyn Fn(f64) -> f64) -> f64 {
        if self.bore.is_some_and(|bore| bore.is_vague()) {
            return f64::INFINITY;
        }
        (radius(self.z[0]) - self.inner[0]).max(radius(self.z[1]) - self.inner[1])
    }

    /// Widens the radii by an edge, `p` not above `q`. One that ends in the slab goes into the `least` radius of each part that it spans.
    fn add(&mut self, p: &Point, q: &Point, least: &mut [f64; PARTS]) {
        let [low, high] = self.z;
        if q.z < low - SAME_HEIGHT_MM || p.z > high + SAME_HEIGHT_MM || q.z - p.z <= SAME_HEIGHT_MM {
            return;
        }
        let radius = |z: f64| {
            let at = p + (q - p) * ((z - p.z) / (q.z - p.z)).clamp(0.0, 1.0);
            at.x.hypot(at.y)
        };
        let spans = p.z <= low + SAME_HEIGHT_MM && q.z >= high - SAME_HEIGHT_MM;
        if !spans {
            // Touching a border from the other side is not running through.
            if q.z <= low + SAME_HEIGHT_MM || p.z >= high - SAME_HEIGHT_MM {
                return;
            }
            let most = radius(low.max(p.z)).max(radius(high.min(q.z)));
            self.outer = self.outer.map(|r| r.max(most));
            for (k, least) in least.iter_mut().enumerate() {
                let ends = [self.border(k), self.border(k + 1)];
                if p.z <= ends[0] && q.z >= ends[1] {
                    let [below, above] = tangent(p, q, ends);
                    *least = least.max(below.min(above));
                }
            }
            return;
        }
        self.outer = [self.outer[0].max(radius(low)), self.outer[1].max(radius(high))];
        let tangent = tangent(p, q, self.z);
        // Of two edges that one counts which is farther out in the middle: a mixture would not be below the radius.
        if tangent[0] + tangent[1] > self.inner[0] + self.inner[1] {
            self.inner = tangent;
        }
    }

    /// Height at which part `k` of [`PARTS`] begins.
    fn border(&self, k: usize) -> f64 {
        let [low, high] = self.z;
        if k == PARTS { high } else { low + (high - low) * (k as f64 / PARTS as f64) }
    }

    /// Raises the inner radius to one value, the least over all parts, if that is above the present radius halfway up. Each part counts with its outermost edge.
    fn raise(&mut self, least: &[f64; PARTS]) {
        let [below, above] = self.inner;
        let of_one = |k: usize| below + (above - below) * (k as f64 / PARTS as f64);
        let parts = least.iter().enumerate().map(|(k, least)| least.max(of_one(k).min(of_one(k + 1))));
        let level = parts.fold(f64::INFINITY, f64::min);
        if 2.0 * level > below + above {
            self.inner = [level; 2];
        }
    }

    /// Whether it is solid, its outline reaches a radius, and up to that radius less a slack it is filled for sure.
    fn reaches(&self, radius: f64, slack_mm: f64) -> bool {
        let fills = |[inner, outer]: [f64; 2]| outer >= radius && inner >= radius - slack_mm;
        self.bore.is_none() && (0..2).all(|k| fills([self.inner[k], self.outer[k]]))
    }
}

/// The distance from the axis of the tangent in the middle of a part of an edge, at both ends of the part, mm; the edge is nowhere nearer to the axis. `p` is below `q`.
fn tangent(p: &Point, q: &Point, [low, high]: [f64; 2]) -> [f64; 2] {
    let along = (q - p) / (q.z - p.z);
    let at = p + along * (f64::midpoint(low, high) - p.z);
    let rho = at.x.hypot(at.y);
    let slope = if rho > 0.0 { (at.x * along.x + at.y * along.y) / rho } else { 0.0 };
    let rise = 0.5 * slope * (high - low);
    [rho - rise, rho + rise]
}

/// Fills what is between two heights with less radius than at both, as far as they are at most `width_mm` apart.
fn fill_grooves(slabs: &mut [Slab], width_mm: f64) {
    let radii = |slabs: &[Slab], of: fn(&Slab) -> [f64; 2], at: usize| {
        let below = at.checked_sub(1).map_or(0.0, |below| of(&slabs[below])[1]);
        below.max(slabs.get(at).map_or(0.0, |above| of(above)[0]))
    };
    let before = slabs.to_vec();
    for first in 1..before.len() {
        let within = |last: &usize| before[last - 1].z[1] - before[first].z[0] <= width_mm;
        for last in (first + 1..before.len()).take_while(within) {
            let level = |of| radii(&before, of, first).min(radii(&before, of, last));
            let (outer, inner) = (level(|slab| slab.outer), level(|slab| slab.inner));
            for slab in &mut slabs[first..last] {
                slab.outer = slab.outer.map(|radius| radius.max(outer));
                // A line above a radius that is at the level on one side only would be above it in the middle.
                if slab.inner.iter().all(|&radius| radius <= inner) {
                    slab.inner = [inner; 2];
                }
            }
        }
    }
}

/// Slabs that are convex together, each run as one piece. Where a piece meets a wider one it reaches into it, so that no gap of rounding is between them. Runs without a slab of
/// this rank are left out. Rings of the stock end where their bore has a step; in those of a cutter that would leave a film between the two.
fn pieces(slabs: &[Slab], rank: usize, is_stock: bool, same_mm: f64) -> Vec<Piece> {
    let most_mm = FILLED * slabs.iter().flat_map(|slab| slab.outer).fold(0.0, f64::max);
    let is_convex = |first: usize, last: usize| is_convex(&slabs[first..=last], [same_mm, most_mm]);
    let kind = |k: usize| slabs[k].bore.map(|bore| bore.is_vague());
    let is_ring = |k: usize| kind(k) == Some(false);
    let bores = |[first, last]: [usize; 2]| -> Vec<BoreSlab> {
        slabs[first..=last].iter().filter_map(|slab| slab.bore).collect()
    };
    let is_of_rank = |[first, last]: [usize; 2]| slabs[first..=last].iter().any(|slab| slab.rank == rank);
    let (mut pieces, mut solid) = (Vec::new(), Vec::new());
    let mut first = 0;
    while first < slabs.len() {
        let mut last = first;
        let goes_on = |next: usize| {
            kind(next) == kind(first) && (!is_stock || !is_ring(first) || Bore::is_known(&bores([first, next])))
        };
        while last + 1 < slabs.len() && goes_on(last + 1) && is_convex(first, last + 1) {
            last += 1;
        }
        let (mut from, mut to) = (first, last);
        if is_ring(first) {
            // A ring goes on in what is solid above and below it.
            while to + 1 < slabs.len() && kind(to + 1).is_none() && is_convex(from, to + 1) {
                to += 1;
            }
            while from > 0 && kind(from - 1).is_none() && is_convex(from - 1, to) {
                from -= 1;
            }
        }
        if kind(first).is_none() {
            solid.push([first, last]);
        }
        if is_of_rank([first, last]) {
            let mut piece = piece(slabs, from, to);
            let outer: Vec<[f64; 2]> = slabs[first..=last].iter().map(|slab| slab.outer).collect();
            piece.bore = Bore::of(&bores([first, last]), &outer);
            pieces.push(piece);
        }
        first = last + 1;
    }
    let joined = joined(slabs, &solid).into_iter().filter(|&run| is_of_rank(run));
    // What decides for the most cells comes first.
    joined.map(|[first, last]| piece(slabs, first, last).for_sure()).chain(pieces).collect()
}

/// Whether the convex hull of a run of slabs is hardly farther out than they are: by what rounding does, or by what is not known of them, up to a most, mm.
fn is_convex(run: &[Slab], [same_mm, most_mm]: [f64; 2]) -> bool {
    let hull = outline(run);
    let mut at = 0;
    let ends = || run.iter().flat_map(|slab| [0, 1].map(|k| (slab.z[k], slab.outer[k], slab.inner[k])));
    let unknown_mm = ends().map(|(_, outer, inner)| outer - inner).fold(0.0, f64::max);
    let spare_mm = unknown_mm.min(most_mm).max(same_mm);
    ends().all(|(z, outer, _)| {
        while at + 2 < hull.len() && hull[at + 1][1] < z {
            at += 1;
        }
        let [below, above] = [hull[at], hull[(at + 1).min(hull.len() - 1)]];
        let slope = (above[0] - below[0]) / (above[1] - below[1]).max(SAME_HEIGHT_MM);
        let out_mm = (below[0] + slope * (z - below[1]) - outer) / slope.hypot(1.0);
        out_mm <= spare_mm
    })
}

/// The convex hull of a run of slabs: radii and heights, upwards.
fn outline(run: &[Slab]) -> Vec<[f64; 2]> {
    let corners: Vec<[f64; 2]> = run.iter().flat_map(|slab| [0, 1].map(|k| [slab.outer[k], slab.z[k]])).collect();
    upper_envelope(&corners)
}

/// By how much a mesh may fall short of the outline of runs that are joined, mm: a fifth of the standard resolution where that is enough.
const JOINED_MM: [f64; 3] = [0.02, 0.1, 0.5];

/// Runs that are one convex outline to within such a length, joined. Between irregular heights pieces are thinner than a cell of the stock: none holds one.
fn joined(slabs: &[Slab], runs: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let mut all: Vec<[usize; 2]> = Vec::new();
    for limit_mm in JOINED_MM {
        let mut runs = runs.iter().copied().peekable();
        while let Some([first, end]) = runs.next() {
            let mut last = end;
            let is_next = |[next, end]: &[usize; 2], last: usize| {
                *next == last + 1 && piece(slabs, first, *end).slack_mm <= limit_mm
            };
            while let Some([_, end]) = runs.next_if(|run| is_next(run, last)) {
                last = end;
            }
            if last > end && !all.contains(&[first, last]) {
                all.push([first, last]);
            }
        }
    }
    all
}

/// The slabs from one to another as one convex piece.
fn piece(slabs: &[Slab], first: usize, last: usize) -> Piece {
    let run = &slabs[first..=last];
    let hull = outline(run);
    let [bottom, top] = [hull[0][0], hull[hull.len() - 1][0]];
    let lines: Vec<HalfPlane> = hull.windows(2).filter_map(|pair| HalfPlane::below_line(pair[0], pair[1])).collect();
    let radius_at = |z: f64| lines.iter().map(|line| (line.c - line.b * z) / line.a).fold(f64::INFINITY, f64::min);
    let slack_mm = run.iter().map(|slab| slab.missing(&radius_at)).fold(0.0, f64::max);
    // Outwards the radius goes on as it does, but never grows.
    let below = slabs[..first].iter().rev().take_while(|slab| slab.reaches(bottom, slack_mm)).last();
    let above = slabs[last + 1..].iter().take_while(|slab| slab.reaches(top, slack_mm)).last();
    let low = below.map_or(run[0].z[0], |slab| slab.z[0]);
    let high = above.map_or(run[run.len() - 1].z[1], |slab| slab.z[1]);
    let mut planes = vec![HalfPlane { a: 0.0, b: -1.0, c: -low }, HalfPlane { a: 0.0, b: 1.0, c: high }];
    let upright = |r: f64| HalfPlane { a: 1.0, b: 0.0, c: r };
    if below.is_some() && lines.first().is_some_and(|line| line.b > 0.0) {
        planes.push(upright(bottom));
    }
    if above.is_some() && lines.last().is_some_and(|line| line.b < 0.0) {
        planes.push(upright(top));
    }
    for line in lines {
        let is_new = planes.last().is_none_or(|last| (last.a - line.a).abs() + (last.b - line.b).abs() > STRAIGHT);
        if is_new {
            planes.push(line);
        }
    }
    let radius = run.iter().flat_map(|slab| slab.outer).fold(0.0, f64::max);
    Piece { convex: Convex { planes }, bore: None, slack_mm, radius, span: [low, high] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Triangle;
    use crate::geometry::shapes::outline::OutlinePoint;
    use crate::geometry::shapes::{Revolve, Shape, Tessellation};
    use obbtree::cases::meshes;
    use proptest::prelude::*;

    fn revolve(profile_mm: &[[f64; 2]]) -> Arc<Mesh> {
        let shape =
            Shape::Revolve(Revolve { profile_mm: profile_mm.iter().copied().map(OutlinePoint::Sharp).collect() });
        Arc::new(shape.mesh(&Tessellation { density: 2.0, grading: 1.0 }).unwrap())
    }

    /// How far a point is from all that may be in the body, mm.
    fn excess(round: &Round, rho: f64, z: f64) -> f64 {
        let p = Vector::new(rho, 0.0, z);
        let of = |piece: &Piece| {
            piece.convex.excess(rho, z).max(piece.bore.as_ref().map_or(f64::NEG_INFINITY, |bore| bore.hollow(&p, &p)))
        };
        round.pieces.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// How far a point is from what is in the body for sure, mm.
    fn short_of(round: &Round, rho: f64, z: f64) -> f64 {
        let p = Vector::new(rho, 0.0, z);
        let of = |piece: &Piece| {
            let bore = piece.bore.as_ref().map_or(f64::NEG_INFINITY, |bore| bore.short_of(&p));
            piece.short_of(rho, z).max(bore)
        };
        round.pieces.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// The least and greatest distances from the axis of the triangles that cross a height.
    fn sections(round: &Round, mesh: &Mesh, z: f64) -> Vec<[f64; 2]> {
        let of = |triangle: &Triangle| {
            let corners = triangle.corners.map(|corner| round.body_from_part * corner);
            let crossing = |k: usize| {
                let (q, r) = (corners[k], corners[(k + 1) % 3]);
                ((q.z - z) * (r.z - z) < 0.0).then(|| q + (r - q) * ((z - q.z) / (r.z - q.z)))
            };
            let ends: Vec<Point> = (0..3).filter_map(crossing).collect();
            let [q, r] = ends[..] else { return None };
            let along = r - q;
            let at = (-q.coords.dot(&along) + z * along.z) / along.norm_squared().max(1e-300);
            let nearest = q + along * at.clamp(0.0, 1.0);
            Some([nearest.x.hypot(nearest.y), q.x.hypot(q.y).max(r.x.hypot(r.y))])
        };
        mesh.triangles().iter().filter_map(of).collect()
    }

    #[test]
    fn a_drill_is_one_piece_and_a_slot_cutter_two_that_overlap() {
        let drill = Round::new(&revolve(&[[0.0, -2.0], [5.0, 0.0], [5.0, 30.0], [0.0, 30.0]]), 0.0);
        assert_eq!(drill.pieces.len(), 1);
        assert!(drill.slack_mm < 1e-6, "{}", drill.slack_mm);
        let slot =
            Round::new(&revolve(&[[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [4.0, 6.0], [4.0, 40.0], [0.0, 40.0]]), 0.0);
        assert_eq!(slot.pieces.len(), 2);
        assert!(slot.slack_mm < 1e-6);
        // No border within the solid where the two meet.
        assert!(excess(&slot, 1.0, 6.0) <= -2.9, "{}", excess(&slot, 1.0, 6.0));
        assert!((excess(&slot, 6.0, 7.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_body_is_as_thin_as_what_stands_out_of_it() {
        let fillet = [[0.0, 0.0], [8.0, 0.0], [8.0, 3.0], [7.0, 3.1], [6.4, 3.3], [6.0, 4.0], [6.0, 40.0], [0.0, 40.0]];
        for (profile, deepest) in [
            (&[[0.0, 0.0], [9.0, 0.0], [9.0, 0.8], [0.0, 0.8]][..], 0.4),
            // A blade on an arbor, a thin drill in a chuck, and a tube of 0.6 mm under a plate.
            (&[[0.0, 0.0], [9.0, 0.0], [9.0, 0.8], [5.0, 0.8], [5.0, 40.0], [0.0, 40.0]][..], 0.4),
            (&[[0.0, 0.0], [0.3, 0.0], [0.3, 9.0], [5.0, 9.0], [5.0, 40.0], [0.0, 40.0]][..], 0.3),
            (&[[8.4, 0.0], [9.0, 0.0], [9.0, 20.0], [0.0, 20.0], [0.0, 14.0], [8.4, 14.0]][..], 0.3),
            // A rim and a tip that stand out by less than half a millimetre, and the slices of a fillet.
            (&[[0.0, 0.0], [5.4, 0.0], [5.4, 0.8], [5.0, 0.8], [5.0, 40.0], [0.0, 40.0]][..], 5.4),
            (&[[0.0, 0.0], [0.3, 0.4], [5.0, 0.4], [5.0, 40.0], [0.0, 40.0]][..], 5.0),
            (&fillet[..], 8.0),
        ] {
            let found = Round::new(&revolve(profile), 0.0).deepest_mm(0.5);
            let is_near = if deepest < 1.0 { (found - deepest).abs() < 0.05 } else { found > 0.5 };
            assert!(is_near, "{profile:?}: {found}");
        }
    }

    /// A ball of 3 mm on a shank, of so many rings; each vertex between the first and the last is moved along the ball by a part of their distance.
    fn ball(rings: u32, moved: f64) -> Arc<Mesh> {
        let right = std::f64::consts::FRAC_PI_2;
        let arc = (0..=rings).map(|k| (right * f64::from(k) / f64::from(rings)).sin_cos());
        let arc: Vec<[f64; 2]> = arc.map(|(sin, cos)| [3.0 * sin, 3.0 - 3.0 * cos]).collect();
        let regular = revolve(&[&arc[..], &[[3.0, 60.0], [0.0, 60.0]]].concat());
        let along = |(k, p): (usize, &Point)| {
            let angle = (1.0 - p.z / 3.0).acos() + moved * right / f64::from(rings) * (7.3 * k as f64).sin();
            let scale = 3.0 * angle.sin() / p.x.hypot(p.y);
            let is_moved = p.z > 1e-9 && p.z < 2.9;
            if is_moved { Point::new(p.x * scale, p.y * scale, 3.0 - 3.0 * angle.cos()) } else { *p }
        };
        let vertices = regular.vertices().iter().enumerate().map(along).collect();
        Arc::new(Mesh::new(vertices, regular.faces().to_vec()).unwrap())
    }

    #[test]
    fn a_point_is_as_deep_as_it_is_whatever_heights_the_vertices_lie_at() {
        // Written in single precision in a frame that leans, staggered, and so finely that only some heights are taken.
        let lean = Isometry::new(Vector::new(120.0, -40.0, 80.0), Vector::new(0.3, 0.5, 0.1));
        let regular = ball(16, 0.0);
        let written = regular.vertices().iter().map(|p| (lean * p).map(|x| f64::from(x as f32))).collect();
        let leaning = Arc::new(Mesh::new(written, regular.faces().to_vec()).unwrap());
        for (name, mesh, frame) in [
            ("regular", regular, Isometry::identity()),
            ("leaning", leaning, lean.inverse()),
            ("staggered", ball(16, 0.4), Isometry::identity()),
            ("fine", ball(60, 0.4), Isometry::identity()),
        ] {
            let round = Round::about(&mesh, frame, 0.0);
            for (depth, angle) in (0..20).map(|k| (0.2 + 0.1 * f64::from(k), 0.4 * f64::from(k % 4))) {
                let (rho, z) = ((3.0 - depth) * angle.sin(), 3.0 - (3.0 - depth) * angle.cos());
                let found = -excess(&round, rho, z);
                assert!((found - depth).abs() < 0.04, "{name}: {found}, not {depth}, {angle}");
            }
        }
    }

    #[test]
    fn pieces_of_a_hollow_outline_reach_into_one_another_whatever_heights_the_vertices_lie_at() {
        // A rod of 3 mm with a fillet of 3 mm to a head of 6 mm.
        let fillet = (0..=12).map(|k| (f64::from(k) / 24.0 * std::f64::consts::PI).sin_cos());
        let fillet: Vec<[f64; 2]> = fillet.map(|(sin, cos)| [6.0 - 3.0 * cos, 10.0 + 3.0 * sin]).collect();
        let regular = revolve(&[&[[0.0, 0.0], [3.0, 0.0]][..], &fillet, &[[6.0, 30.0], [0.0, 30.0]]].concat());
        let moved = |(k, p): (usize, &Point)| {
            let angle = (p.z - 10.0) / 3.0;
            let is_moved = angle > 0.01 && angle < 0.99;
            let (sin, cos) = (angle.asin() + 0.03 * (7.0 * k as f64).sin()).sin_cos();
            let scale = (6.0 - 3.0 * cos) / p.x.hypot(p.y);
            if is_moved { Point::new(p.x * scale, p.y * scale, 10.0 + 3.0 * sin) } else { *p }
        };
        let vertices = regular.vertices().iter().enumerate().map(moved).collect();
        let staggered = Arc::new(Mesh::new(vertices, regular.faces().to_vec()).unwrap());
        let round = Round::about(&staggered, Isometry::identity(), 0.0);
        for (rho, z, depth) in [(0.0, 11.5, 3.18), (2.0, 11.0, 1.12), (3.0, 12.0, 0.6), (0.0, 2.0, 2.0)] {
            let found = -excess(&round, rho, z);
            assert!(found > 0.8 * depth && found < depth + 0.05, "{found}, not {depth}, at {rho} {z}");
        }
    }

    #[test]
    fn an_annular_cutter_is_a_ring() {
        let saw = Round::new(&revolve(&[[8.0, 0.0], [10.0, 0.0], [10.0, 30.0], [8.0, 30.0]]), 0.0);
        assert!(excess(&saw, 5.0, 15.0) > 2.9 && excess(&saw, 9.0, 15.0) < -0.9 && short_of(&saw, 5.0, 15.0) > 2.9);
        assert!(short_of(&saw, 9.0, 15.0) < -0.9, "{}", short_of(&saw, 9.0, 15.0));
    }

    #[test]
    fn a_workpiece_is_round_whatever_its_bore_and_known_up_to_the_walls() {
        // A tube, a blind hole that a drill has left, a counterbore, and a groove within.
        for (profile, out, within) in [
            (&[[15.0, 0.0], [30.0, 0.0], [30.0, 80.0], [15.0, 80.0]][..], vec![[14.2, 1.0]], vec![[15.8, 40.0]]),
            (
                &[[0.0, 0.0], [30.0, 0.0], [30.0, 80.0], [15.0, 80.0], [15.0, 40.0], [0.0, 31.0]][..],
                vec![[14.2, 41.0], [0.0, 32.0], [7.0, 36.0]],
                vec![[15.8, 41.0], [0.0, 30.0], [7.0, 34.0]],
            ),
            (
                &[[15.0, 0.0], [30.0, 0.0], [30.0, 80.0], [20.0, 80.0], [20.0, 50.0], [15.0, 50.0]][..],
                vec![[19.2, 51.0], [14.2, 49.0]],
                vec![[20.8, 51.0], [15.8, 49.0]],
            ),
            (
                &[
                    [15.0, 0.0],
                    [30.0, 0.0],
                    [30.0, 80.0],
                    [15.0, 80.0],
                    [15.0, 50.0],
                    [20.0, 50.0],
                    [20.0, 30.0],
                    [15.0, 30.0],
                ][..],
                vec![[19.2, 49.0], [19.2, 31.0], [14.2, 10.0]],
                vec![[15.8, 51.0], [15.8, 29.0], [20.8, 40.0]],
            ),
        ] {
            let round = Round::stock(&revolve(profile));
            assert!(round.filled >= ROUND && round.is_known(), "{profile:?}: {}", round.filled);
            for [rho, z] in out {
                let least = short_of(&round, rho, z).min(excess(&round, rho, z));
                assert!(least > 0.3, "{profile:?} {rho} {z}: {least}");
            }
            for [rho, z] in within {
                let most = short_of(&round, rho, z).max(excess(&round, rho, z));
                assert!(most < -0.3, "{profile:?} {rho} {z}: {most}");
            }
        }
    }

    /// A hole saw with a pilot drill.
    const PILOTED: [[f64; 2]; 8] =
        [[0.0, -8.0], [3.0, -6.0], [3.0, 30.0], [16.0, 30.0], [16.0, 0.0], [18.0, 0.0], [18.0, 34.0], [0.0, 34.0]];

    #[test]
    fn between_a_core_and_its_rings_nothing_is_cut() {
        let brad =
            [[0.0, -4.0], [2.0, -1.0], [2.0, 0.0], [11.0, 0.0], [11.0, -2.0], [12.0, -2.0], [12.0, 34.0], [0.0, 34.0]];
        let slanted = [
            [0.0, 0.0],
            [40.0, 0.0],
            [40.0, 30.0],
            [35.0, 30.0],
            [25.0, 20.0],
            [20.0, 20.0],
            [30.0, 30.0],
            [0.0, 30.0],
        ];
        let two_walls = [
            [0.0, 20.0],
            [4.0, 20.0],
            [4.0, 0.0],
            [6.0, 0.0],
            [6.0, 20.0],
            [16.0, 20.0],
            [16.0, 0.0],
            [18.0, 0.0],
            [18.0, 24.0],
            [0.0, 24.0],
        ];
        for (profile, out, within) in [
            (&PILOTED[..], [10.0, 15.0], vec![[2.0, 15.0], [17.0, 15.0], [1.0, 0.0], [1.0, 30.0], [10.0, 32.0]]),
            (&brad[..], [7.0, -1.5], vec![[0.5, -1.5], [11.5, -1.0], [7.0, 1.0]]),
            (&slanted[..], [27.5, 25.0], vec![[24.0, 27.0], [37.0, 25.0], [25.0, 10.0]]),
            (&two_walls[..], [10.0, 10.0], vec![[5.0, 10.0], [17.0, 10.0], [10.0, 22.0]]),
        ] {
            let round = Round::new(&revolve(profile), 0.0);
            let [rho, z] = out;
            assert!(short_of(&round, rho, z) > 1.0 && excess(&round, rho, z) > 1.0, "{profile:?}");
            for [rho, z] in within {
                assert!(short_of(&round, rho, z) < -0.3, "{profile:?} {rho} {z}: {}", short_of(&round, rho, z));
                assert!(excess(&round, rho, z) < -0.3, "{profile:?} {rho} {z}");
            }
        }
    }

    /// A prism that turns once about itself over 40 mm; its corners are 5 mm from the axis, and each is moved along it.
    fn helix(steps: u32, sides: u32, moved_mm: f64) -> Arc<Mesh> {
        let corner = |step: u32, side: u32| {
            let moved =
                if (1..steps).contains(&step) { (7.0 * f64::from(side) + 0.9 * f64::from(step)).sin() } else { 0.0 };
            let z = 40.0 * f64::from(step) / f64::from(steps) + moved_mm * moved;
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(side) / f64::from(sides) + z / 40.0)).sin_cos();
            Point::new(5.0 * cos, 5.0 * sin, z)
        };
        let all = (0..=steps).flat_map(|step| (0..sides).map(move |side| corner(step, side)));
        let vertices: Vec<Point> = all.chain([Point::origin(), Point::new(0.0, 0.0, 40.0)]).collect();
        let (bottom, top) = ((steps + 1) * sides, (steps + 1) * sides + 1);
        let around = |side: u32| {
            let next = (side + 1) % sides;
            let walls = (0..steps).flat_map(move |step| {
                let [a, b] = [side, next].map(|side| step * sides + side);
                [[a, b, b + sides], [a, b + sides, a + sides]]
            });
            walls.chain([[bottom, next, side], [top, steps * sides + side, steps * sides + next]])
        };
        Arc::new(Mesh::new(vertices, (0..sides).flat_map(around).collect()).unwrap())
    }

    #[test]
    fn a_helix_with_irregular_heights_is_known_all_along() {
        // Up to 1 000 heights, and more: then some slabs hold whole rows of corners.
        for (steps, sides, moved_mm) in [(30, 12, 0.1), (40, 24, 0.1), (80, 36, 0.1), (160, 36, 0.03)] {
            let mesh = helix(steps, sides, moved_mm);
            assert!(mesh.edge_report().is_watertight() && mesh.signed_volume() > 0.0);
            let round = Round::new(&mesh, 0.0);
            for z in (4..156).map(|k| 0.25 * f64::from(k) + 0.01) {
                let short = short_of(&round, 4.9, z);
                assert!(short < 0.0, "{steps} {sides}: {short} at {z}");
                let radius = sections(&round, &mesh, z).into_iter().fold(0.0, |most: f64, [_, far]| most.max(far));
                assert!(short_of(&round, radius + 1e-9, z) >= 0.0, "{steps} {sides}: at {z}");
            }
        }
    }

    #[test]
    fn inserts_in_the_end_of_a_cutter_hide_nothing_of_it() {
        let cutter = revolve(&[[0.0, 1.0], [3.0, 1.0], [3.5, 0.0], [6.0, 0.0], [6.0, 30.0], [0.0, 30.0]]);
        let ball = revolve(&[[0.0, -0.9], [0.9, 0.0], [0.0, 0.9]]);
        let with_balls_at = |x: f64, z: f64| {
            let (mut vertices, mut faces) = (cutter.vertices().to_vec(), cutter.faces().to_vec());
            for x in [x, -x] {
                let first = vertices.len() as u32;
                vertices.extend(ball.vertices().iter().map(|v| v + Vector::new(x, 0.0, z)));
                faces.extend(ball.faces().iter().map(|face| face.map(|corner| corner + first)));
            }
            Round::new(&Arc::new(Mesh::new(vertices, faces).unwrap()), 0.0)
        };
        let (alone, within) = (Round::new(&cutter, 0.0), with_balls_at(2.0, 8.0));
        assert_eq!(within.pieces.len(), alone.pieces.len());
        assert!((short_of(&within, 5.0, 0.5) - short_of(&alone, 5.0, 0.5)).abs() < 1e-9);
        // In the ring around the dish, and reaching out of it: both bodies are there.
        let seated = with_balls_at(5.5, 2.0);
        assert!(short_of(&seated, 5.0, 0.5) <= short_of(&alone, 5.0, 0.5) + 1e-9, "{}", short_of(&seated, 5.0, 0.5));
        assert!(excess(&seated, 6.3, 2.0) < 0.0 && short_of(&seated, 6.3, 2.0) < 0.0);
        assert!(excess(&seated, 6.3, 3.5) > 0.2 && excess(&seated, 1.0, 0.2) > 0.2);
    }

    #[test]
    fn under_the_dish_of_an_end_mill_nothing_is_cut() {
        let mill = Round::new(
            &revolve(&[[0.0, 0.7], [2.0, 0.4], [4.0, 0.0], [5.2, 0.0], [6.0, 0.8], [6.0, 30.0], [0.0, 30.0]]),
            0.0,
        );
        assert!(excess(&mill, 0.1, 0.05) > 0.1 && short_of(&mill, 0.1, 0.05) > 0.1);
        assert!(short_of(&mill, 4.6, 0.3) < -0.1 && short_of(&mill, 0.1, 0.9) < -0.1);
        // Beside a dish with a rounded edge and a rounded floor the ring is known to be full.
        let rounded = [
            [0.0, 3.0],
            [1.0, 3.0],
            [1.4, 2.8],
            [1.6, 2.4],
            [2.4, 0.6],
            [2.6, 0.2],
            [3.0, 0.0],
            [6.0, 0.0],
            [6.0, 30.0],
            [0.0, 30.0],
        ];
        let rounded = Round::new(&revolve(&rounded), 0.0);
        assert!(short_of(&rounded, 4.5, 1.2) < -1.0, "{}", short_of(&rounded, 4.5, 1.2));
        assert!(excess(&rounded, 0.1, 1.2) > 1.0 && short_of(&rounded, 1.5, 2.0) > 0.1);
        // No film where the ring meets the solid part.
        assert!(short_of(&mill, 5.0, 0.7) < -0.3, "{}", short_of(&mill, 5.0, 0.7));
    }

    #[test]
    fn grooves_are_filled_up_to_a_width() {
        let profile = [
            [0.0, 0.0],
            [6.0, 0.0],
            [6.0, 5.0],
            [5.0, 5.5],
            [6.0, 6.0],
            [6.0, 10.0],
            [5.0, 10.0],
            [5.0, 15.0],
            [6.0, 15.0],
            [6.0, 20.0],
            [0.0, 20.0],
        ];
        let mill = Round::new(&revolve(&profile), 1.5);
        assert!(short_of(&mill, 5.8, 5.5) < -0.1, "{}", short_of(&mill, 5.8, 5.5));
        assert!(excess(&mill, 5.8, 12.0) > 0.7, "the neck is no groove");
        assert!(short_of(&Round::new(&revolve(&profile), 0.0), 5.8, 5.5) > 0.1);
    }

    #[test]
    fn an_open_mesh_is_within_a_cylinder_and_cuts_nothing_for_sure() {
        // A lid of 9 mm, joined to nothing, over a tube of 5 mm without ends: no edge between two heights bounds the lid.
        let tube = revolve(&[[0.0, 0.0], [5.0, 0.0], [5.0, 30.0], [0.0, 30.0]]);
        let mut vertices = tube.vertices().to_vec();
        let mut faces = tube.faces().to_vec();
        faces.retain(|face| face.iter().any(|&k| vertices[k as usize].z > 1.0));
        let first = vertices.len() as u32;
        vertices.extend([[9.0, 0.0, 30.0], [-9.0, 0.0, 30.0], [0.0, 9.0, 30.0]].map(Point::from));
        faces.push([first, first + 1, first + 2]);
        let open = Arc::new(Mesh::new(vertices, faces).unwrap());
        let round = Round::new(&open, 0.0);
        for place in open.vertices().iter().map(|vertex| round.body_from_part * vertex) {
            assert!(excess(&round, place.x.hypot(place.y), place.z) <= 1e-9, "{place}");
        }
        assert!(round.is_vague());
    }

    proptest! {
        /// Of any solid: its points are in the pieces, and what is deep enough in them is swept by its turning.
        #[test]
        fn the_mesh_is_within_and_depth_is_swept(which in 0..64usize, face in 0..10_000usize, u in 0.0..1.0f64, v in 0.0..1.0f64) {
            let solids = meshes::subjects().into_iter().map(|subject| Arc::new(subject.mesh));
            let solids: Vec<Arc<Mesh>> = solids.chain([revolve(&PILOTED), helix(20, 8, 0.5)]).collect();
            let mesh = &solids[which % solids.len()];
            prop_assume!(mesh.edge_report().is_watertight() && mesh.signed_volume() > 0.0);
            let round = Round::new(mesh, 0.0);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = mesh.triangles()[face % mesh.faces().len()].corners;
            let p = round.body_from_part * (a + (b - a) * u + (c - a) * v);
            prop_assert!(excess(&round, p.x.hypot(p.y), p.z) <= 1e-6);
            // A height through the mesh: its largest radius there, found by cutting every triangle.
            let sections = sections(&round, mesh, p.z);
            let radius = sections.iter().fold(0.0, |most: f64, [_, far]| most.max(*far));
            for part in 0..20 {
                let rho = radius * (1.0 + f64::from(part) / 10.0);
                if rho > radius + 1e-6 {
                    prop_assert!(short_of(&round, rho, p.z) >= -1e-6, "{rho} > {radius} at {}", p.z);
                }
            }
            // Between what crosses the height, and within all of it, a circle is inside or outside.
            let (solid, part_from_body) = (Solid::new(Arc::clone(mesh)), round.body_from_part.inverse());
            for part in 0..40 {
                let rho = radius * (f64::from(part) + 1e-3) / 40.0;
                let is_met = sections.iter().any(|[near, far]| (near - 1e-6..=far + 1e-6).contains(&rho));
                if !is_met && !solid.holds(&(part_from_body * Point::new(0.8 * rho, 0.6 * rho, p.z))) {
                    prop_assert!(short_of(&round, rho, p.z) >= -1e-6, "{rho} at {}", p.z);
                }
            }
        }
    }
}
