//! From a straight piece of the path in axis space to ways of parts through the stock, on which every point of the stock goes straight as the part sees it.
//!
//! Slides alone do that. Where a joint between part and stock turns, the piece is divided until chords are near enough. The distance is bounded: with Ω the sum of
//! the turns in a piece and S the way of a point, its acceleration is at most 2 Ω S, and it is within Ω S / 4 of its chord. S is at most that of the part's centre
//! and Ω times the distance from it. Only points that the part can meet matter: they are as near to its centre as its ball and their own way allow.

use crate::geometry::{Isometry, Point, Vector};
use crate::machine::Machine;
use rs274::Position;

/// Something fixed to a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// The link; `None` is the world.
    pub link: Option<usize>,
    /// The frame of the mesh in the link's, mm.
    pub link_from_mesh: Isometry,
    /// Centre of a ball around it, in the frame of its mesh, mm.
    pub centre: Point,
    /// Radius of the ball, mm.
    pub radius_mm: f64,
}

/// A part of an axis move, and the frames of a part in the stock's at its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Parts of the axis move, 0 to 1.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// The part's frame in the stock's at first, mm.
    pub first: Isometry,
    /// And at last.
    pub last: Isometry,
    /// Sum of the turns, radians.
    pub turn: f64,
    /// Longest way of the part's centre, mm.
    pub way_mm: f64,
    /// How far from its chord, in the part's frame, a point of the stock may be that the part meets, mm.
    pub sag_mm: f64,
}

/// The joints between two mounts.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    links: Vec<usize>,
    part: Mount,
    stock: Mount,
}

/// Most pieces of an axis move.
const MOST_PIECES: usize = 4096;
/// Greatest sum of turns in a piece, radians: the way's bound below holds for much less than a radian.
const MOST_TURN: f64 = 0.1;

impl Chain {
    /// The joints between a part and a stock.
    pub fn new(machine: &Machine, part: Mount, stock: Mount) -> Self {
        let links = machine.up_to_shared(part.link, stock.link).chain(machine.up_to_shared(stock.link, part.link));
        let links = links.filter(|&link| machine.links()[link].joint.is_some()).collect();
        Self { links, part, stock }
    }

    /// Sum of the turns while axes change by `change`, radians.
    fn turn(&self, machine: &Machine, change: &Position) -> f64 {
        let joints = self.links.iter().filter_map(|&link| machine.links()[link].joint.as_ref());
        joints.filter(|joint| joint.turns()).map(|joint| joint.value(change).abs()).sum()
    }

    /// Into how many pieces a move must be cut for what `off` says of each to be at most `pad_mm`; as few as that takes, or the most there may be.
    pub fn pieces(
        &self,
        machine: &Machine,
        from: &Position,
        to: &Position,
        pad_mm: f64,
        off: impl Fn(&Piece) -> f64,
    ) -> usize {
        let turn = self.turn(machine, &change(from, to));
        if turn == 0.0 {
            return 1;
        }
        let mut pieces = (turn / MOST_TURN).ceil() as usize;
        while pieces < MOST_PIECES {
            let pads = (0..pieces).map(|piece| off(&self.piece(machine, from, to, piece, pieces)));
            let worst = pads.fold(0.0, f64::max);
            if worst <= pad_mm {
                return pieces;
            }
            // What a piece is off falls at least as its length does, the sag as its square.
            let wanted = (pieces as f64 * (worst / pad_mm).sqrt().clamp(1.05, 8.0)).ceil() as usize;
            pieces = wanted.clamp(pieces + 1, MOST_PIECES);
        }
        MOST_PIECES
    }

    /// Piece `index` of `count`.
    pub fn piece(&self, machine: &Machine, from: &Position, to: &Position, index: usize, count: usize) -> Piece {
        let part_of = |k: f64| k / count as f64;
        let (begin, end) = (part_of(index as f64), part_of(index as f64 + 1.0));
        let at = |part: f64| Position(std::array::from_fn(|i| from.0[i] + part * (to.0[i] - from.0[i])));
        let (first, last) = (at(begin), at(end));
        let step = change(&first, &last);
        let turn = self.turn(machine, &step);
        let (start, finish) = (self.stock_from_part(machine, &first), self.stock_from_part(machine, &last));
        // Levers grow by the way itself. A piece that turns by half a radian or more has no bound.
        let is_bounded = turn < 0.5;
        let way_mm = if is_bounded { self.way(machine, &first, &step) / (1.0 - turn) } else { f64::INFINITY };
        // A point that meets the part at some time is in its ball then, and else nearer than its own way and sag more.
        let grown = 1.0 + 0.25 * turn;
        let near = (self.part.radius_mm + grown * way_mm) / (1.0 - turn * grown);
        let sag_mm = if is_bounded { 0.25 * turn * (way_mm + turn * near) } else { f64::INFINITY };
        Piece { from: begin, to: end, first: start, last: finish, turn, way_mm, sag_mm }
    }

    /// A piece as a way without turning, in the orientation at first: its travel in the stock's frame, and how far any point of the part may be from where that
    /// says, mm.
    pub fn unturned(&self, piece: &Piece) -> (Vector, f64) {
        let travel = piece.last * self.part.centre - piece.first * self.part.centre;
        (travel, piece.turn * self.part.radius_mm + 0.25 * piece.turn * piece.way_mm)
    }

    /// The part's frame in the stock's at a position.
    pub fn stock_from_part(&self, machine: &Machine, position: &Position) -> Isometry {
        let poses = machine.forward(position);
        let world_from = |mount: &Mount| poses.world_from(mount.link) * mount.link_from_mesh;
        world_from(&self.stock).inv_mul(&world_from(&self.part))
    }

    /// Way of the part's centre as far as joints turn about axes as distant from it as they are at `position`, mm.
    fn way(&self, machine: &Machine, position: &Position, change: &Position) -> f64 {
        let poses = machine.forward(position);
        let centre = poses.world_from(self.part.link) * self.part.link_from_mesh * self.part.centre;
        let levers = self.links.iter().filter_map(|&link| machine.lever(link, &poses, &centre, change));
        levers.map(|(step, distance)| distance.map_or(step, |distance| step * distance)).sum()
    }
}

fn change(from: &Position, to: &Position) -> Position {
    Position(std::array::from_fn(|i| to.0[i] - from.0[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Joint, Limits, Link};
    use proptest::prelude::*;
    use rs274::Axis;

    /// X carries B carries the part; the stock turns about C on a slide Y.
    fn machine() -> Machine {
        let link = |name: &str, parent: Option<&str>, at: [f64; 3], joint| Link {
            name: name.into(),
            parent: parent.map(Into::into),
            parent_from_link: Isometry::translation(at[0], at[1], at[2]),
            joint: Some(joint),
        };
        let slide = |axis, direction| Joint::prismatic(axis, direction, Limits::NONE).unwrap();
        let turn = |axis, direction| Joint::rotary(axis, direction, Point::new(1.0, 2.0, 3.0), Limits::NONE).unwrap();
        Machine::new(vec![
            link("x", None, [0.0; 3], slide(Axis::X, Vector::x())),
            link("b", Some("x"), [10.0, 0.0, 80.0], turn(Axis::B, Vector::y())),
            link("y", None, [0.0; 3], slide(Axis::Y, Vector::y())),
            link("c", Some("y"), [0.0, 20.0, 5.0], turn(Axis::C, Vector::z())),
        ])
        .unwrap()
    }

    #[test]
    fn a_piece_that_turns_too_far_has_no_bound() {
        let machine = machine();
        let mount = |link: &str| Mount {
            link: machine.link(link),
            link_from_mesh: Isometry::identity(),
            centre: Point::origin(),
            radius_mm: 1.0,
        };
        let chain = Chain::new(&machine, mount("b"), mount("c"));
        let sag_mm = |turn: f64| {
            let mut to = Position::default();
            to[Axis::C] = turn;
            chain.piece(&machine, &Position::default(), &to, 0, 1).sag_mm
        };
        assert!(sag_mm(0.49).is_finite() && sag_mm(0.5).is_infinite() && sag_mm(3.0).is_infinite());
    }

    proptest! {
        #[test]
        fn no_point_is_farther_from_its_chord_than_the_sag(
            start in prop::array::uniform4(-1.0..1.0f64),
            step in prop::array::uniform4(-1.0..1.0f64),
            offset in prop::array::uniform3(-1.0..1.0f64),
            at in 0.0..1.0f64,
            met in 0.0..1.0f64,
        ) {
            let machine = machine();
            let mount = |link: &str, radius_mm| Mount {
                link: machine.link(link), link_from_mesh: Isometry::translation(3.0, -2.0, 1.0), centre: Point::new(0.0, 5.0, -30.0), radius_mm,
            };
            let chain = Chain::new(&machine, mount("b", 3f64.sqrt()), mount("c", 1.0));
            let position = |scale: f64, values: [f64; 4]| {
                let mut position = Position::default();
                for (axis, (value, long)) in [Axis::X, Axis::B, Axis::Y, Axis::C].into_iter().zip(values.into_iter().zip([50.0, 1.0, 50.0, 1.0])) {
                    position[axis] = start[0] * 0.0 + scale * value * long;
                }
                position
            };
            let from = position(1.0, start);
            let by = position(0.3, step);
            let to = Position(std::array::from_fn(|i| from.0[i] + by.0[i]));
            let count = chain.pieces(&machine, &from, &to, 0.05, |piece| piece.sag_mm);
            let point = Point::new(0.0, 5.0, -30.0) + Vector::from(offset);
            for index in 0..count {
                let piece = chain.piece(&machine, &from, &to, index, count);
                prop_assert!(piece.sag_mm <= 0.05);
                let pose = |at: f64| {
                    let part = piece.from + at * (piece.to - piece.from);
                    chain.stock_from_part(&machine, &Position(std::array::from_fn(|i| from.0[i] + part * by.0[i])))
                };
                // What the part's point meets at some time.
                let in_stock = pose(met) * point;
                let (one, other) = (piece.first.inverse() * in_stock, piece.last.inverse() * in_stock);
                let off = (one + (other - one) * at - pose(at).inverse() * in_stock).norm();
                prop_assert!(off <= piece.sag_mm + 1e-9, "{off} > {}", piece.sag_mm);
                let (travel, pad) = chain.unturned(&piece);
                let off = (piece.first * point + travel * at - pose(at) * point).norm();
                prop_assert!(off <= pad + 1e-9, "{off} > {pad}");
            }
        }
    }
}
