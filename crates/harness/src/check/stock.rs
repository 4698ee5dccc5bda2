//! The workpiece as the program leaves it: what cuts takes material away, and whatever else comes into what is left is told.
//!
//! Each move is one step of a stock ([`crate::stock`]) or several. What has not touched the uncut workpiece has not touched
//! what is left of it: only where the scan of the trees found contact are shank, holder and the rest held against the stock. A cutter always is.

use super::event::{Kind, runs};
use super::motion::Path;
use super::scan::Stretch;
use super::spun::Spun;
use super::turning::{Needs, Turning, WorkAxis, feeds_of};
use super::{CheckError, Cutting, Settings};
use crate::geometry::{Mesh, Point};
use crate::scene::{Pair, Part, Role, Scene, Turns};
use crate::stock::motion::{Chain, Mount, Piece};
use crate::stock::{Body, Contact, Depth, Step, Stock, StockError, Sweep, standard_resolution_mm};
use rs274::{MoveKind, Plane, Position};
use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Steps that are gathered before the stock takes them.
const BATCH: usize = 1024;
/// Cells that are held against what moves before a program is given up, by default.
pub const MOST_QUESTIONS: u64 = 2_000_000_000;
/// How many times as coarse the standard resolution is on a lathe where a half section is not enough: ten times as fast, which makes seconds of minutes.
const COARSER_ON_LATHES: f64 = 5.0;
/// Fraction of the greatest depth that the stock can have in a thin part. Deeper contact is told although it is within the resolution. For thin cutters the resolution is
/// this fraction of that depth.
const THIN_PART: f64 = 0.5;
/// Greatest factor by which a thin cutter makes the resolution finer; a cutter that needs more leaves it as it is.
const MOST_FINER: f64 = 4.0;
/// Part of the resolution by which a part that turns may be elsewhere than its straight piece says, mm.
const PAD: f64 = 0.05;

/// Contact with the stock over a part of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StockContact {
    pub pair: Pair,
    /// Whether the part, or the workpiece, is taken as what the spindle turns it through.
    pub is_turned: bool,
    /// What it is, if it is certain.
    pub kind: Kind,
    /// Places on the path.
    pub from: f64,
    pub to: f64,
    pub depth: Depth,
    /// Where the part of it begins in which that depth is found.
    pub deepest_at: f64,
}

/// A part that stays within the resolution of what is left: whether it touches is not known.
#[derive(Clone, Debug, PartialEq)]
pub struct Touch {
    /// The part and the workpiece.
    pub pair: Pair,
    /// Moves in which it does.
    pub moves: usize,
    /// Line of the first of them.
    pub line: u32,
    /// How deep it may be at most, mm.
    pub at_most_mm: f64,
}

/// A workpiece after the program.
#[derive(Clone, Debug)]
pub struct Remaining {
    /// The part.
    pub part: usize,
    /// What is left of it, in the frame of its mesh.
    pub stock: Stock,
    /// Line from which on nothing was cut or examined any more, the budget being spent.
    pub given_up: Option<u32>,
    /// Whether it is in pieces, and something that moves against the workpiece may carry one: all are taken to stay where the workpiece is.
    pub is_parted: bool,
}

/// A workpiece and everything that may come into it.
pub(super) struct Workpiece<'a> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    pub part: usize,
    /// Cutters that are taken as driven on a lathe; nothing in the scene says so.
    pub driven: Vec<usize>,
    stock: Stock,
    others: Vec<Other>,
    given_up: Option<u32>,
}

/// A part that may come into the workpiece.
struct Other {
    pair: Pair,
    body: Body,
    /// Of a cutter that the spindle or a drive of its own may turn: what both sweep for sure; `body` is then what the spindle may sweep. Where nothing is swept for
    /// sure, what the drive may.
    own: Option<Body>,
    /// The mesh of a cutter that is not round. It is examined while the cutter's spindle stands.
    drawn: Option<Body>,
    chain: Chain,
    role: Role,
    /// Whether the part, or the workpiece, is taken as what the spindle turns it through.
    is_turned: bool,
    /// Of what stands while the workpiece turns.
    turning: Option<Turning>,
    /// The spindle that it needs to cut.
    needs: Needs,
    /// Whether it is a cutter that nothing turns, nor a workpiece: it takes nothing away.
    stands: bool,
    /// Whether it is asked only while the workpiece turns, and after a driven cutter has cut it: a round workpiece is at every angle as drawn.
    once_unround: bool,
}

/// What a step was: where on the path, and what contact in it is.
struct Told {
    from: f64,
    to: f64,
    /// For each body that the step examines.
    examined: Vec<(usize, Kind)>,
}

/// All that a workpiece met.
#[derive(Default)]
pub(super) struct Met {
    pub contacts: Vec<StockContact>,
    pub touches: Vec<Touch>,
    /// Place from which on the workpiece may have been cut.
    cut_from: Option<f64>,
    /// Where other workpieces, as drawn and uncut, are not free of what is left of this one.
    near: Vec<(Pair, [f64; 2])>,
    /// Place from which on nothing was examined, the budget being spent.
    given_up: Option<f64>,
    /// The last place to which the program was run.
    pub last: usize,
}

impl Met {
    /// Merges the contacts that the stocks of two workpieces found with each other. Each stock takes the other workpiece as uncut, so the stock that is cut first
    /// decides. Once the other one is cut too, contact is not certain, and there is none where the other stock is free of the first workpiece as drawn.
    fn join(&mut self, second: &mut Self, pair: Pair) {
        let is_self = self.uncut_to() <= second.uncut_to();
        let (deciding, other) = if is_self { (self, second) } else { (second, self) };
        let of_pair = |contact: &StockContact| contact.pair == pair && !contact.is_turned;
        // Where the deciding stock was given up, the other one alone was examined, against a workpiece that may have been cut.
        let given_up = deciding.given_up.unwrap_or(f64::INFINITY);
        other.contacts.retain_mut(|contact| {
            if !of_pair(contact) {
                return true;
            }
            contact.from = contact.from.max(given_up.next_up());
            contact.depth.low = 0.0;
            contact.from <= contact.to
        });
        other.touches.retain(|touch| touch.pair != pair);
        let is_free = !other.near.iter().any(|(near, _)| *near == pair);
        deciding.touches.retain(|touch| touch.pair != pair || !is_free);
        let joined = |contact: &StockContact| match of_pair(contact) && contact.to > other.uncut_to() {
            true => other.confirmed(contact),
            false => vec![*contact],
        };
        deciding.contacts = deciding.contacts.iter().flat_map(joined).collect();
    }

    /// Another workpiece is not free of this one on a part of the path.
    fn not_free(&mut self, pair: Pair, [from, to]: [f64; 2]) {
        match self.near.last_mut() {
            Some((last, [_, end])) if *last == pair && *end >= from => *end = f64::max(*end, to),
            _ => self.near.push((pair, [from, to])),
        }
    }

    fn uncut_to(&self) -> f64 {
        self.cut_from.unwrap_or(f64::INFINITY)
    }

    /// The parts of a contact with this workpiece, uncut, where its stock is not free of it either. They are not certain.
    fn confirmed(&self, contact: &StockContact) -> Vec<StockContact> {
        let near = self.near.iter().filter(|(pair, _)| *pair == contact.pair);
        let part = |&(_, [from, to]): &(Pair, [f64; 2])| StockContact {
            // A whole place belongs to the move that leads to it.
            from: if from > contact.from { from.next_up() } else { contact.from },
            to: to.min(contact.to),
            depth: Depth { low: 0.0, ..contact.depth },
            ..*contact
        };
        near.map(part).filter(|part| part.from <= part.to).collect()
    }
}

impl<'a> Workpiece<'a> {
    /// The workpieces of a scene that are cut, and those that cannot be: their meshes are open, or nobody knows about which axis they turn. None where the
    /// workpiece is the finished part. `turned` are the pairs that are examined at every angle of the spindle.
    pub fn all(
        scene: &'a Scene,
        path: &'a Path<'a>,
        all: &[Pair],
        (spun, turned): (&Spun, &[Pair]),
        Settings { cutting, is_solid, .. }: &Settings,
    ) -> Result<(Vec<Self>, Vec<usize>), CheckError> {
        let (cutting, is_solid) = (*cutting, *is_solid);
        let cuts = |pairs: &[Pair]| pairs.iter().any(|&pair| scene.is_cutting(pair));
        let (mut workpieces, mut uncut) = (Vec::new(), Vec::new());
        if scene.gouge_mm.is_some() || cutting == Cutting::Never {
            return Ok((workpieces, uncut));
        }
        for part in (0..scene.parts.len()).filter(|&part| scene.parts[part].role == Role::Workpiece) {
            // What lies in an open mesh nobody knows: contact of such a part is that with the uncut workpiece, which holds all that is left.
            let is_known = |pair: Pair| {
                let other = pair.other(part);
                scene.parts[other].role == Role::Cutter || scene.parts[other].mesh.edge_report().is_watertight()
            };
            let of_workpiece = |pair: &Pair| [pair.a, pair.b].contains(&part) && is_known(*pair);
            let [pairs, turned] =
                [all, turned].map(|pairs| pairs.iter().copied().filter(of_workpiece).collect::<Vec<_>>());
            // What is left is wanted even where no cutter comes near.
            if !cuts(&pairs) && (!is_solid || cuts(all)) {
                continue;
            }
            let resolution_mm = match cutting {
                Cutting::At(mm) => mm,
                _ => standard_resolution_mm(&scene.parts[part].mesh),
            };
            let axis = WorkAxis::of(scene, path, part);
            if axis.is_none() && path.first_plane() == Plane::Zx {
                uncut.push(part);
                continue;
            }
            let examined =
                Examined { scene, path, axis: axis.as_ref(), spun, workpiece: part, pairs: &pairs, turned: &turned };
            let workpiece = match cutting {
                Cutting::Standard => examined.cut(resolution_mm, is_solid, COARSER_ON_LATHES).and_then(|workpiece| {
                    let finer_mm = workpiece.finer_mm();
                    finer_mm.map_or(Ok(workpiece), |finer_mm| examined.cut(finer_mm, is_solid, 1.0))
                }),
                _ => examined.cut(resolution_mm, is_solid, 1.0),
            };
            match workpiece {
                Ok(workpiece) => workpieces.push(workpiece),
                Err(why @ StockError::Resolution(_)) => return Err(CheckError::Resolution(why)),
                Err(_) => uncut.push(part),
            }
        }
        Ok((workpieces, uncut))
    }

    /// The resolution at which a rapid back out of what a thin cutter has cut is clear, mm, where that is finer.
    fn finer_mm(&self) -> Option<f64> {
        let standard_mm = self.stock.resolution_mm();
        let feeds = |other: &&Other| {
            let part = other.pair.other(self.part);
            other.role == Role::Cutter && feeds_of(self.scene, self.path, part).next().is_some()
        };
        let thin = self.others.iter().filter(feeds).filter_map(|other| other.thin_mm(standard_mm));
        let wanted = thin.map(|deepest| THIN_PART * deepest).filter(|finer_mm| MOST_FINER * finer_mm >= standard_mm);
        wanted.reduce(f64::min)
    }

    /// Cutters whose meshes are open.
    pub fn open_cutters(&self) -> impl Iterator<Item = usize> {
        let part = |other: &Other| other.pair.other(self.part);
        let cutters = self.others.iter().filter(|other| other.role == Role::Cutter).map(part);
        cutters.filter(|&cutter| !self.scene.parts[cutter].mesh.edge_report().is_watertight())
    }

    /// Whether a pair is this workpiece and something else.
    pub fn has(&self, pair: Pair) -> bool {
        [pair.a, pair.b].contains(&self.part) && self.others.iter().any(|other| other.pair == pair)
    }

    /// Merges the contacts of each pair of workpieces.
    pub fn join(workpieces: &[Self], met: &mut [Met]) {
        for (index, second) in workpieces.iter().enumerate() {
            let (before, rest) = met.split_at_mut(index);
            for (first, met) in workpieces.iter().zip(before) {
                let is_second = |other: &&Other| !other.is_turned && other.pair.other(first.part) == second.part;
                if let Some(other) = first.others.iter().find(is_second) {
                    met.join(&mut rest[0], other.pair);
                }
            }
        }
    }

    /// Runs the program up to place `end`, with `stops` no farther than its first contact needs, or until the budget is spent; `stretches` says where each pair
    /// that was scanned touches the uncut workpiece, as drawn or as what a spindle turns.
    pub fn run(
        &mut self,
        end: usize,
        stops: bool,
        &Settings { tolerance_mm, stock_budget: budget, .. }: &Settings,
        stretches: &dyn Fn(Pair, bool) -> Vec<Stretch>,
    ) -> Met {
        let touching = |other: &Other| runs(&stretches(other.pair, other.is_turned), 0);
        let touching: Vec<Vec<Stretch>> = self.others.iter().map(touching).collect();
        let Self { scene, path, stock, others, given_up, .. } = self;
        let pad_mm = PAD * stock.resolution_mm();
        let mut route = Route { scene, path, others, touching: &touching, pad_mm, unround_from: usize::MAX };
        route.unround_from = (1..=end).find(|&at| route.cuts_unround(at)).unwrap_or(usize::MAX);
        let mut ledger = Ledger::new(path, others, &touching, stock.resolution_mm());
        let mut batch = Batch::default();
        let mut at = 0;
        while at <= end {
            let known = batch.steps.len();
            let last = route.add(at, end, &mut batch);
            let cuts = |step: &Step| step.cutting.iter().any(|sweep| stock.is_near(sweep));
            if ledger.met.cut_from.is_none() && batch.steps[known..].iter().any(cuts) {
                ledger.met.cut_from = Some(at as f64 - 1.0);
            }
            let may_meet = |step: &Step| step.examined.iter().any(|sweep| stock.is_near(sweep));
            if batch.steps.len() >= BATCH || stops && batch.steps[known..].iter().any(may_meet) {
                ledger.take(&batch, &stock.run(&batch.steps, tolerance_mm));
                batch = Batch::default();
            }
            if stops && ledger.knows_first(scene, last) {
                return Met { last, ..ledger.met };
            }
            at = last + 1;
            if at <= end && stock.questions() >= budget {
                *given_up = Some(path.line_at(at as f64));
                ledger.take(&batch, &stock.run(&batch.steps, tolerance_mm));
                ledger.give_up(scene, at as f64 - 1.0, end as f64);
                return Met { last: end, ..ledger.met };
            }
        }
        ledger.take(&batch, &stock.run(&batch.steps, tolerance_mm));
        Met { last: end, ..ledger.met }
    }

    /// What is left.
    pub fn remaining(mut self) -> Remaining {
        let scene = self.scene;
        let body = |part: &Part| scene.machine.rigid_body(part.link);
        let own = body(&scene.parts[self.part]);
        let may_carry = |part: &Part| {
            let holds = part.role == Role::Fixture || part.turns == Some(Turns::Spindle) && part.role == Role::Machine;
            holds && body(part) != own
        };
        let is_parted = scene.parts.iter().any(may_carry) && self.stock.pieces() > 1;
        Remaining { part: self.part, stock: self.stock, given_up: self.given_up, is_parted }
    }
}

/// A workpiece, and the pairs in which something may come into it.
struct Examined<'a, 'b> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    axis: Option<&'b WorkAxis>,
    spun: &'b Spun,
    workpiece: usize,
    /// As drawn.
    pairs: &'b [Pair],
    /// At every angle of the spindle.
    turned: &'b [Pair],
}

impl<'a> Examined<'a, '_> {
    /// The workpiece as a half section where that is enough and no solid is wanted, else as an octree; on a lathe `coarser` times as coarse.
    fn cut(&self, resolution_mm: f64, is_solid: bool, coarser: f64) -> Result<Workpiece<'a>, StockError> {
        match self.axis.map(|axis| self.flat(axis, resolution_mm)) {
            Some(Ok(Some(workpiece))) if !is_solid => Ok(workpiece),
            // A half section is not enough: a cutter turns as well, or the workpiece is not round.
            Some(_) if !is_solid => self.solid(coarser * resolution_mm),
            _ => self.solid(resolution_mm),
        }
    }

    /// The workpiece as an octree.
    fn solid(&self, resolution_mm: f64) -> Result<Workpiece<'a>, StockError> {
        let stock = Stock::new(&self.mesh(), resolution_mm)?;
        let others = self.pairs.iter().map(|&pair| self.as_drawn(pair));
        let turned = self.turned.iter().map(|&pair| self.as_turned(pair));
        let beside = self.pairs.iter().filter(|&&pair| self.stands_beside(pair));
        let beside = beside.map(|&pair| Other { once_unround: true, ..self.as_turned(pair) });
        Ok(self.with(stock, others.chain(turned).chain(beside).collect()))
    }

    /// Whether a part that does not cut stands beside the workpiece, which turns and is round before it is cut.
    fn stands_beside(&self, pair: Pair) -> bool {
        let part = pair.other(self.workpiece);
        let is_cutter = self.scene.parts[part].role == Role::Cutter;
        self.axis.is_some()
            && !is_cutter
            && !self.turned.contains(&pair)
            && self.spun.turns_beside(self.workpiece, part)
    }

    /// The workpiece as a half section; `None` where a cutter turns.
    fn flat(&self, axis: &WorkAxis, resolution_mm: f64) -> Result<Option<Workpiece<'a>>, StockError> {
        let stock = Stock::turned(&self.mesh(), axis.axis_from_stock, resolution_mm)?;
        let others = self.pairs.iter().map(|&pair| self.beside(axis, pair, false));
        let turned = self.turned.iter().map(|&pair| self.beside(axis, pair, true));
        Ok(others.chain(turned).collect::<Option<_>>().map(|others| self.with(stock, others)))
    }

    fn mesh(&self) -> Arc<Mesh> {
        Arc::clone(&self.scene.parts[self.workpiece].mesh)
    }

    fn with(&self, stock: Stock, others: Vec<Other>) -> Workpiece<'a> {
        let Self { scene, path, workpiece: part, .. } = *self;
        let driven = |other: &Other| {
            let (number, is_standing) = (other.pair.other(part), other.turning.is_some());
            let is_guess = self.axis.is_some() && other.role == Role::Cutter && scene.parts[number].turns.is_none();
            (is_guess && !is_standing).then_some(number)
        };
        let driven = others.iter().filter_map(driven).collect();
        Workpiece { scene, path, part, driven, stock, others, given_up: None }
    }

    /// A part against the workpiece as it is.
    fn as_drawn(&self, pair: Pair) -> Other {
        let part = pair.other(self.workpiece);
        let Part { ref mesh, role, groove_mm, turns, .. } = self.scene.parts[part];
        let stands = role == Role::Cutter && turns == Some(Turns::Nothing) && self.axis.is_none();
        // A drive turns it about an axis that is not known.
        let is_said = turns == Some(Turns::Own) || (self.axis.is_some() && turns == Some(Turns::Spindle));
        let is_vague = is_said && self.spun.as_drawn.contains(&part);
        let body = match (role, self.spun.axis_of(part)) {
            (Role::Cutter, _) if stands => Body::standing(mesh),
            (Role::Cutter, None) if is_vague => Body::turning(mesh, groove_mm).vague(),
            (Role::Cutter, Some(axis_from_part)) => Body::turning_about(mesh, axis_from_part, groove_mm),
            (Role::Cutter, None) => Body::turning(mesh, groove_mm),
            _ => Body::standing(mesh),
        };
        if role == Role::Cutter && self.spun.is_unsure(part) {
            // Whichever of the two turns it, it is where it is drawn.
            let own = Body::round_as_drawn(mesh).unwrap_or_else(|| Body::turning(mesh, groove_mm).vague());
            return self.standing(pair, body.vague(), Some(own));
        }
        let axis = self.axis.filter(|_| role == Role::Cutter);
        let turning = axis.and_then(|axis| {
            let turning = Turning::new(self.scene, self.path, axis, false, part, &body);
            (!turning.is_driven(self.scene, self.path, axis, part, &body)).then_some(turning)
        });
        // One that is not round is only taken as driven because the program turns the workpiece between its feeds: it may as well stand.
        let may_stand = axis.is_some() && turning.is_none() && turns.is_none() && body.axis().is_none();
        let body = if may_stand { body.vague() } else { body };
        let other = Other { turning, stands, ..self.standing(pair, body, None) };
        let is_unround = mesh.edge_report().is_watertight() && other.body.axis().is_none();
        let drawn = (other.spins() && is_unround).then(|| Body::standing(mesh));
        Other { drawn, ..other }
    }

    /// A part that the spindle turns, or any part beside a workpiece that it turns, at every angle.
    fn as_turned(&self, pair: Pair) -> Other {
        let part = pair.other(self.workpiece);
        // Beside a workpiece that turns about another axis, the rings replace the part.
        let scene = &self.spun.scene;
        let axis_from_part = self.spun.axis_of(part);
        // A round workpiece stands while a driven tool turns beside it.
        let axis = self.axis.filter(|_| axis_from_part.is_none() || self.spun.is_turned(self.workpiece));
        let body = match axis_from_part.filter(|_| axis.is_none()) {
            Some(axis_from_part) => Body::turning_about(&self.scene.parts[part].mesh, axis_from_part, 0.0),
            None => Body::standing(&scene.parts[part].mesh),
        };
        let turning = axis.map(|axis| Turning::new(scene, self.path, axis, false, part, &body));
        Other { turning, is_turned: true, ..self.standing(pair, body, None) }
    }

    fn standing(&self, pair: Pair, body: Body, own: Option<Body>) -> Other {
        let part = pair.other(self.workpiece);
        let mut of_part = mount(self.scene, part, &body);
        if let Some(own) = &own {
            let Mount { centre, radius_mm, .. } = mount(self.scene, part, own);
            of_part.radius_mm = of_part.radius_mm.max((centre - of_part.centre).norm() + radius_mm);
        }
        let chain = chain(self.scene, of_part, self.workpiece);
        let role = self.scene.parts[part].role;
        let (is_turned, stands, once_unround) = (false, false, false);
        let (drawn, turning, needs) = (None, None, self.needs(part));
        Other { pair, body, own, drawn, chain, role, is_turned, turning, needs, stands, once_unround }
    }

    fn needs(&self, part: usize) -> Needs {
        let is_cutter = self.scene.parts[part].role == Role::Cutter;
        if is_cutter { Needs::of(self.scene, self.path, self.workpiece, part) } else { Needs::Any }
    }

    /// A part beside the workpiece, which turns; `None` where it is the cutter that turns.
    fn beside(&self, axis: &WorkAxis, pair: Pair, is_turned: bool) -> Option<Other> {
        let scene = if is_turned { &self.spun.scene } else { self.scene };
        let (path, part) = (self.path, pair.other(self.workpiece));
        let Part { ref mesh, role, .. } = scene.parts[part];
        let body = Body::turning(mesh, 0.0);
        let turning = Turning::new(scene, path, axis, true, part, &body);
        let is_driven = role == Role::Cutter && turning.is_driven(scene, path, axis, part, &body);
        let chain = turning.to_base.clone();
        let turning = Some(turning);
        let (stands, once_unround) = (false, false);
        let (own, drawn, needs) = (None, None, self.needs(part));
        let other = Other { pair, body, own, drawn, chain, role, is_turned, turning, needs, stands, once_unround };
        (!is_driven).then_some(other)
    }
}

impl Other {
    /// The joints that move it against the stock, or against the workpiece's axis.
    fn way(&self) -> &Chain {
        self.turning.as_ref().map_or(&self.chain, |turning| &turning.to_base)
    }

    /// Whether it is a cutter that a spindle or a drive turns.
    fn spins(&self) -> bool {
        self.role == Role::Cutter && self.turning.is_none() && !self.stands
    }

    fn bodies(&self) -> impl Iterator<Item = &Body> {
        std::iter::once(&self.body).chain(&self.own)
    }

    /// How deep the stock can be in it, mm, where that is no more than the resolution: all contact would be told as a touch.
    fn thin_mm(&self, resolution_mm: f64) -> Option<f64> {
        let of_body = || self.body.deepest_mm(resolution_mm);
        let deepest = self.turning.as_ref().map_or_else(of_body, |turning| turning.deepest_mm(resolution_mm));
        Some(deepest).filter(|deepest| *deepest <= resolution_mm)
    }
}

/// A part's frame on its link, with a ball around it.
pub(super) fn mount(scene: &Scene, part: usize, body: &Body) -> Mount {
    let (centre, radius_mm) = body.ball();
    let Part { link, link_from_part, .. } = scene.parts[part];
    Mount { link, link_from_mesh: link_from_part, centre, radius_mm }
}

/// The joints between a part and a workpiece.
pub(super) fn chain(scene: &Scene, part: Mount, workpiece: usize) -> Chain {
    let Part { link, link_from_part, .. } = scene.parts[workpiece];
    let workpiece = Mount { link, link_from_mesh: link_from_part, centre: Point::origin(), radius_mm: 0.0 };
    Chain::new(&scene.machine, part, workpiece)
}

#[derive(Default)]
struct Batch {
    steps: Vec<Step>,
    told: Vec<Told>,
    /// Places at which the machine waits: what is in contact stays so.
    waits: Vec<(usize, f64)>,
}

/// The path as steps.
struct Route<'a> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    others: &'a [Other],
    /// Where each other part touches the uncut workpiece; of cutters nothing is said.
    touching: &'a [Vec<Stretch>],
    pad_mm: f64,
    /// The first place to which a driven cutter feeds.
    unround_from: usize,
}

impl<'a> Route<'a> {
    /// Adds the way to place `at`, and as far beyond as one straight step goes; at place 0 what is there at first. Returns the last place.
    fn add(&self, at: usize, end: usize, batch: &mut Batch) -> usize {
        if at == 0 {
            let position = self.path.position(0);
            let examined = self.present(0).filter(|&other| self.may_touch(other, 0.0, 0.0));
            let examined: Vec<_> = examined.map(|other| (other, Kind::Collision)).collect();
            self.add_step([0.0, 0.0], [position, position], 0.0, &examined, &[], batch);
            return 0;
        }
        let step = self.path.step(at as f64);
        let cutter = match step.kind {
            MoveKind::Dwell { .. } => {
                batch.waits.push((batch.steps.len(), at as f64));
                return at;
            }
            MoveKind::Rapid => Some(Kind::RapidIntoWorkpiece),
            MoveKind::ToolChange { .. } => Some(Kind::ToolChangeIntoWorkpiece),
            MoveKind::Feed | MoveKind::Arc { .. } => None,
        };
        let last = self.straight_to(at, end);
        let (from, to) = (at as f64 - 1.0, last as f64);
        let (mut examined, mut cutting) = (Vec::new(), Vec::new());
        let is_probing = self.path.is_probing(at as f64);
        for other in self.present(at) {
            let Other { role, stands, needs, .. } = self.others[other];
            match (role == Role::Cutter, cutter) {
                (true, _) if is_probing => {}
                (true, Some(kind)) => examined.push((other, kind)),
                (true, None) if stands || needs.stands(step) => {
                    examined.push((other, Kind::StoppedSpindleIntoWorkpiece));
                }
                (true, None) => cutting.push(other),
                (false, _) if self.may_touch(other, from, to) => examined.push((other, Kind::Collision)),
                _ => {}
            }
        }
        // An arc is its chords only up to this, and so is the way of a tool's tip.
        let is_bent = matches!(step.kind, MoveKind::Arc { .. }) || step.tip_mm.is_some();
        let chord_mm = if is_bent { self.path.chord_mm() } else { 0.0 };
        let positions = [self.path.position(at - 1), self.path.position(last)];
        self.add_step([from, to], positions, chord_mm, &examined, &cutting, batch);
        last
    }

    /// Parts that are there on the way to a place, and asked.
    fn present(&self, at: usize) -> impl Iterator<Item = usize> {
        let is_unround = at >= self.unround_from && !self.works_driven(at);
        self.mounted(at).filter(move |&other| is_unround || !self.others[other].once_unround)
    }

    fn mounted(&self, at: usize) -> impl Iterator<Item = usize> {
        let tool = self.path.tool(at);
        (0..self.others.len()).filter(move |&other| self.scene.is_mounted(self.others[other].pair, tool))
    }

    /// For each cutter in use whether it is driven, on a lathe.
    fn driven(&self, at: usize) -> impl Iterator<Item = bool> {
        let others = self.mounted(at).map(|other| &self.others[other]);
        others.filter(|other| other.role == Role::Cutter).map(|other| other.turning.is_none())
    }

    /// Whether all cutters in use are driven. The workpiece then stands.
    fn works_driven(&self, at: usize) -> bool {
        self.driven(at).next().is_some() && self.driven(at).all(|is_driven| is_driven)
    }

    /// Whether a driven cutter feeds to a place. False where no part has to know.
    fn cuts_unround(&self, at: usize) -> bool {
        let asks = self.others.iter().any(|other| other.once_unround);
        asks && self.path.step(at as f64).kind.is_feed() && self.driven(at).any(|is_driven| is_driven)
    }

    fn may_touch(&self, other: usize, from: f64, to: f64) -> bool {
        let stretches = &self.touching[other];
        // Stretches are in the order of the path.
        let next = stretches.partition_point(|stretch| stretch.to < from);
        self.others[other].role == Role::Cutter || stretches.get(next).is_some_and(|stretch| stretch.from <= to)
    }

    /// The last place to which the machine goes straight on from the way to `at` within one move, as long as the same parts may touch.
    fn straight_to(&self, at: usize, end: usize) -> usize {
        let samples = self.path.samples();
        let touching = |at: usize| -> Vec<usize> {
            let others = 0..self.others.len();
            others.filter(|&other| self.may_touch(other, at as f64 - 1.0, at as f64)).collect()
        };
        let way = |at: usize| {
            let (from, to) = (self.path.position(at - 1), self.path.position(at));
            Position(std::array::from_fn(|i| to.0[i] - from.0[i]))
        };
        let (first, parts, is_probing) = (way(at), touching(at), self.path.is_probing(at as f64));
        let stands = parts.iter().any(|&other| !self.others[other].body.is_round());
        let mut last = at;
        while last < end
            && !stands
            && samples[last].move_index == samples[at - 1].move_index
            && self.path.is_probing(last as f64 + 1.0) == is_probing
            && is_parallel(&first, &way(last + 1))
            && touching(last + 1) == parts
        {
            last += 1;
        }
        last
    }

    fn add_step(
        &self,
        [from, to]: [f64; 2],
        [first, last]: [Position; 2],
        chord_mm: f64,
        examined: &[(usize, Kind)],
        cutting: &[usize],
        batch: &mut Batch,
    ) {
        if examined.is_empty() && cutting.is_empty() {
            return;
        }
        let machine = &self.scene.machine;
        let all = examined.iter().map(|&(other, _)| other).chain(cutting.iter().copied());
        let pieces = |other: usize| {
            let (other, way) = (&self.others[other], self.others[other].way());
            let off = |piece: &Piece| if other.turning.is_some() { way.unturned(piece).1 } else { piece.sag_mm };
            way.pieces(machine, &first, &last, self.pad_mm, off)
        };
        let count = all.map(pieces).max().unwrap_or(1);
        let is_stopped = |needs: Needs| to == 0.0 || needs.stands(self.path.step(to));
        for index in 0..count {
            let sweeps = |other: usize, of_turning: fn(&Turning, &Piece, f64) -> Sweep| {
                let Other { turning, drawn, needs, .. } = &self.others[other];
                let piece = self.others[other].way().piece(machine, &first, &last, index, count);
                let straight = |body: &Body| body.sweep([&piece.first, &piece.last], piece.sag_mm + chord_mm);
                let of_body = |body: &Body| match (turning, drawn) {
                    (Some(turning), _) => of_turning(turning, &piece, chord_mm),
                    (None, Some(drawn)) if is_stopped(*needs) => straight(body).standing(straight(drawn)),
                    _ => straight(body),
                };
                self.others[other].bodies().map(of_body).collect::<Vec<_>>()
            };
            let step = Step {
                examined: examined.iter().flat_map(|&(other, _)| sweeps(other, Turning::sweep)).collect(),
                cutting: cutting.iter().flat_map(|&other| sweeps(other, Turning::cut)).collect(),
            };
            let of_bodies = |&(other, kind): &(usize, Kind)| self.others[other].bodies().map(move |_| (other, kind));
            let examined = examined.iter().flat_map(of_bodies).collect();
            let place = |index: usize| from + (to - from) * (index as f64 / count as f64);
            batch.steps.push(step);
            batch.told.push(Told { from: place(index), to: place(index + 1), examined });
        }
    }
}

/// Whether two steps of the axes go the same way, up to rounding.
fn is_parallel(a: &Position, b: &Position) -> bool {
    let length = |way: &Position| way.0.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (one, other) = (length(a), length(b));
    // Over a metre the two part by a nanometre. Beside a step of no length this is no number.
    let apart = (0..9).map(|i| (a.0[i] / one - b.0[i] / other).powi(2)).sum::<f64>();
    apart.sqrt() <= 1e-9
}

/// What was found, by part, in the order of the path.
struct Ledger<'a> {
    path: &'a Path<'a>,
    others: &'a [Other],
    /// Where each other part touches the uncut workpiece; of cutters nothing is said.
    touching: &'a [Vec<Stretch>],
    met: Met,
    resolution_mm: f64,
    /// Per part: how deep the stock can be in what is thin of it, mm. Found when it may touch for the first time.
    thin: Vec<OnceCell<Option<f64>>>,
    /// Per part: index of its last contact.
    last: Vec<Option<usize>>,
    /// Index of the touches of each pair, and the move of the last.
    touch: BTreeMap<Pair, (usize, usize)>,
}

impl<'a> Ledger<'a> {
    fn new(path: &'a Path<'a>, others: &'a [Other], touching: &'a [Vec<Stretch>], resolution_mm: f64) -> Self {
        let (last, touch, thin) = (vec![None; others.len()], BTreeMap::new(), vec![OnceCell::new(); others.len()]);
        Self { path, others, touching, met: Met::default(), resolution_mm, thin, last, touch }
    }

    /// Whether what is found on the way to place `at` says which contact is the first. Contact that is not certain may become so further on its line; that of two
    /// workpieces may be none ([`Met::join`]), and that of what a spindle turns is not told on lines on which the parts as drawn collide meanwhile ([`super::event::EventWriter::add_turned`]).
    fn knows_first(&self, scene: &Scene, at: usize) -> bool {
        let is_of_two = |pair: Pair| [pair.a, pair.b].iter().all(|&part| scene.parts[part].role == Role::Workpiece);
        let contacts = self.met.contacts.iter().filter(|contact| !contact.is_turned && !is_of_two(contact.pair));
        let first = contacts.min_by(|a, b| a.from.total_cmp(&b.from));
        let is_over = |place: f64| self.path.line_at(place) != self.path.line_at(at as f64);
        first.is_some_and(|first| first.depth.low > 0.0 || is_over(first.to))
    }

    fn take(&mut self, batch: &Batch, found: &[Contact]) {
        let mut waits = batch.waits.iter().peekable();
        for contact in found {
            while let Some((_, place)) = waits.next_if(|(step, _)| *step <= contact.step) {
                self.wait(*place);
            }
            let told = &batch.told[contact.step];
            let (other, kind) = told.examined[contact.part];
            self.meet(other, [told.from, told.to]);
            // Within the resolution: the contact has no ends, and no depth that is certain.
            let is_touch = contact.to <= 0.0;
            let thin = || *self.thin[other].get_or_init(|| self.others[other].thin_mm(self.resolution_mm));
            if is_touch && thin().is_some_and(|deepest| contact.depth.high > THIN_PART * deepest) {
                self.contact(other, Kind::Unresolved, told, &Contact { to: 1.0, ..*contact });
            } else if is_touch {
                self.touch(other, told, contact.depth.high);
            } else {
                self.contact(other, kind, told, contact);
            }
        }
        waits.for_each(|(_, place)| self.wait(*place));
    }

    /// What is in contact where the machine waits stays so.
    fn wait(&mut self, place: f64) {
        for index in self.last.iter().flatten() {
            let contact = &mut self.met.contacts[*index];
            if contact.to >= place - 1.0 {
                contact.to = place;
            }
        }
    }

    /// Another workpiece is not free of the stock on a part of the path.
    fn meet(&mut self, other: usize, [from, to]: [f64; 2]) {
        let Other { pair, role, is_turned, .. } = self.others[other];
        if role != Role::Workpiece || is_turned {
            return;
        }
        self.met.not_free(pair, [from, to]);
    }

    /// Every cutter may be in the stock from a place on: nobody has looked.
    fn give_up(&mut self, scene: &Scene, from: f64, to: f64) {
        self.met.cut_from = self.met.cut_from.or(Some(from));
        self.met.given_up = Some(from);
        (0..self.others.len()).for_each(|other| self.meet(other, [from, to]));
        let depth = Depth { low: 0.0, high: f64::INFINITY };
        let cutters = self.others.iter().map(|other| other.pair).filter(|&pair| scene.is_cutting(pair));
        let contact = |pair| {
            let (kind, from) = (Kind::Unresolved, from.next_up());
            StockContact { pair, is_turned: false, kind, from, to, depth, deepest_at: from }
        };
        self.met.contacts.extend(cutters.map(contact));
    }

    fn contact(&mut self, other: usize, kind: Kind, told: &Told, contact: &Contact) {
        let place = |part: f64| told.from + part * (told.to - told.from);
        let (mut from, to) = (place(contact.from), place(contact.to));
        // A whole place belongs to the move that leads to it.
        if from.fract() == 0.0 && from < to {
            from = from.next_up();
        }
        // Nothing touches what is left before it touches the uncut workpiece.
        let touching: &[Stretch] = &self.touching[other];
        let begin = |from: f64, to: f64| {
            let next = touching.partition_point(|stretch| stretch.to < from);
            touching.get(next).map_or(from, |stretch| from.max(stretch.from.min(to)))
        };
        let before = self.last[other].map(|index| &mut self.met.contacts[index]);
        if let Some(before) = before {
            let goes_on = before.to >= from - JOINED * (told.to - told.from).max(1.0);
            let same_line = || self.path.line_at(before.to) == self.path.line_at(to);
            // A retreat at rapid rate from a contact belongs to it.
            let same = match kind {
                Kind::StoppedSpindleIntoWorkpiece => before.kind == kind && same_line(),
                Kind::RapidIntoWorkpiece => true,
                kind => before.kind == kind,
            };
            // What may be contact makes no certain contact of a later line begin on its own line.
            let is_as_sure = before.depth.low > 0.0 || contact.depth.low <= 0.0 || before.kind == kind && same_line();
            if goes_on && same && is_as_sure {
                // Two bodies of one part may be in contact at once.
                let to = before.to.max(to);
                let is_deeper = (contact.depth.low, contact.depth.high) > (before.depth.low, before.depth.high);
                before.deepest_at = if is_deeper { from } else { before.deepest_at };
                (before.from, before.to) = (begin(before.from.min(from), to), to);
                before.depth = before.depth.max(contact.depth);
                return;
            }
        }
        let from = begin(from, to);
        self.last[other] = Some(self.met.contacts.len());
        let Other { pair, is_turned, .. } = self.others[other];
        let (depth, deepest_at) = (contact.depth, from);
        self.met.contacts.push(StockContact { pair, is_turned, kind, from, to, depth, deepest_at });
    }

    fn touch(&mut self, other: usize, told: &Told, at_most_mm: f64) {
        let sample = self.path.sample_at(told.to);
        let (line, step) = (if told.to <= 0.0 { 0 } else { sample.line }, sample.move_index);
        let pair = self.others[other].pair;
        let Some((index, last)) = self.touch.get_mut(&pair) else {
            self.touch.insert(pair, (self.met.touches.len(), step));
            self.met.touches.push(Touch { pair, moves: 1, line, at_most_mm });
            return;
        };
        let touch = &mut self.met.touches[*index];
        touch.moves += usize::from(*last != step);
        touch.at_most_mm = touch.at_most_mm.max(at_most_mm);
        *last = step;
    }
}

/// Part of a step that may be between two contacts that are one.
const JOINED: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::super::tests;
    use super::*;

    #[test]
    fn ways_that_join_are_one_where_a_workpiece_is_not_free() {
        let (pair, other) = (Pair { a: 0, b: 1 }, Pair { a: 1, b: 2 });
        let mut met = Met::default();
        for (pair, way) in
            [(pair, [1.0, 2.0]), (pair, [2.0, 5.0]), (pair, [3.0, 4.0]), (pair, [6.0, 7.0]), (other, [7.0, 8.0])]
        {
            met.not_free(pair, way);
        }
        assert_eq!(met.near, [(pair, [1.0, 5.0]), (pair, [6.0, 7.0]), (other, [7.0, 8.0])]);
    }

    #[test]
    fn steps_of_the_axes_go_the_same_way_whatever_their_lengths() {
        let way = |x: f64, y: f64| {
            let mut way = Position::default();
            (way[rs274::Axis::X], way[rs274::Axis::Y]) = (x, y);
            way
        };
        assert!(is_parallel(&way(1.0, 2.0), &way(0.1, 0.2)) && is_parallel(&way(0.0, 3.0), &way(0.0, 5.0)));
        for other in [way(-1.0, -2.0), way(1.0, 2.1), way(1.0, 0.0), way(0.0, 0.0)] {
            assert!(!is_parallel(&way(1.0, 2.0), &other) && !is_parallel(&other, &way(1.0, 2.0)), "{other:?}");
        }
        assert!(!is_parallel(&way(0.0, 0.0), &way(0.0, 0.0)));
    }

    #[test]
    fn two_workpieces_touch_where_neither_stock_is_free() {
        let (pair, other) = (Pair { a: 0, b: 1 }, Pair { a: 1, b: 2 });
        let depth = Depth { low: 1.0, high: 2.0 };
        let (is_turned, kind, from, to, deepest_at) = (false, Kind::Collision, 2.0, 9.0, 2.0);
        let contact = StockContact { pair, is_turned, kind, from, to, depth, deepest_at };
        let mut first = Met { contacts: vec![contact], cut_from: Some(0.0), ..Met::default() };
        let near = vec![(pair, [1.0, 4.0]), (other, [4.0, 5.0]), (pair, [6.0, 7.0]), (pair, [20.0, 21.0])];
        let touch = Touch { pair, moves: 1, line: 3, at_most_mm: 0.1 };
        first.touches = vec![touch.clone(), Touch { pair: other, ..touch }];
        let mut second = Met { near, cut_from: Some(5.0), ..Met::default() };
        // The stock that is cut first decides; what the other one found of the two does not count.
        let of_other = StockContact { pair: other, ..contact };
        second.contacts = vec![contact, of_other];
        first.join(&mut second, pair);
        assert_eq!(second.contacts, [of_other]);
        assert_eq!(first.touches.len(), 2);
        let found: Vec<_> = first.contacts.iter().map(|part| (part.from, part.to, part.depth)).collect();
        let uncertain = Depth { low: 0.0, ..depth };
        assert_eq!(found, [(2.0, 4.0, uncertain), (6.0_f64.next_up(), 7.0, uncertain)]);
        // What begins with the contact begins where that does.
        second.near[0].1[0] = 2.0;
        first.contacts = vec![contact];
        first.join(&mut second, pair);
        assert_eq!(first.contacts[0].from, 2.0);
        // Where the other stock is free of it, nothing touches once that is cut.
        second.near.retain(|(near, _)| *near == other);
        first.join(&mut second, pair);
        assert_eq!((first.contacts.len(), first.touches.iter().map(|touch| touch.pair).collect()), (1, vec![other]));
        // What ends where the other stock is cut first is certain.
        first.contacts = vec![StockContact { to: 5.0, ..contact }];
        second.touches = vec![touch.clone(), Touch { pair: other, ..touch }];
        first.join(&mut second, pair);
        assert_eq!(first.contacts, [StockContact { to: 5.0, ..contact }]);
        assert_eq!(second.touches.iter().map(|touch| touch.pair).collect::<Vec<_>>(), [other]);
    }

    fn path_of(scene: &Scene) -> Path<'_> {
        Path::new(scene, scene.program.as_ref().unwrap()).unwrap()
    }

    /// The first workpiece, uncut, and all that may come into it as drawn.
    fn workpiece_of<'a>(scene: &'a Scene, path: &'a Path<'a>) -> Workpiece<'a> {
        let spun = Spun::of(scene, scene.program.as_ref().unwrap(), path);
        let count = scene.parts.len();
        let pairs: Vec<Pair> = (0..count).flat_map(|a| (a + 1..count).map(move |b| Pair { a, b })).collect();
        let settings = Settings { is_solid: true, ..Settings::standard() };
        Workpiece::all(scene, path, &pairs, (&spun, &[]), &settings).unwrap().0.remove(0)
    }

    fn stretch([from, to]: [f64; 2]) -> Stretch {
        Stretch { nearness: 0, from, to, least_mm: 0.0, least_at: from, inside: false, goes_on: false }
    }

    /// [`tests::CUBES`] as a workpiece and a holder that is not round.
    fn with_holder(program: &str) -> Scene {
        tests::scene(&tests::with_cutter().replace("\"cutter\"", "\"holder\""), program)
    }

    fn route_of<'a>(workpiece: &'a Workpiece<'a>, touching: &'a [Vec<Stretch>]) -> Route<'a> {
        let Workpiece { scene, path, ref others, .. } = *workpiece;
        Route { scene, path, others, touching, pad_mm: 0.005, unround_from: usize::MAX }
    }

    #[test]
    fn a_part_may_touch_where_the_scan_says_so_ends_included() {
        let scene = with_holder("G0 Z80\nM2");
        let path = path_of(&scene);
        let workpiece = workpiece_of(&scene, &path);
        let touching = [vec![stretch([2.0, 4.0]), stretch([6.0, 7.0])]];
        let route = route_of(&workpiece, &touching);
        for (from, to, expected) in [
            (0.0, 1.9, false),
            (0.0, 2.0, true),
            (3.0, 3.5, true),
            (4.0, 5.0, true),
            (4.5, 5.0, false),
            (4.5, 6.0, true),
            (0.0, 9.0, true),
            (7.5, 9.0, false),
        ] {
            assert_eq!(route.may_touch(0, from, to), expected, "{from} {to}");
        }
    }

    #[test]
    fn a_step_ends_where_the_way_bends_or_the_move_the_probe_or_contact_changes() {
        let last = |program: &str, touching: [f64; 2], ats: &[usize]| {
            let scene = with_holder(program);
            let path = path_of(&scene);
            let workpiece = workpiece_of(&scene, &path);
            let touching = [vec![stretch(touching)]];
            let route = route_of(&workpiece, &touching);
            ats.iter().map(|&at| route.straight_to(at, path.samples().len())).collect::<Vec<_>>()
        };
        let never = [1e9, 1e9];
        // Two moves of ten samples on one straight way.
        assert_eq!(last("G0 Z90\nG0 Z80\nM2", never, &[1, 10, 11]), [10, 10, 20]);
        // Contact on the way to place 5.
        assert_eq!(last("G0 Z90\nG0 Z80\nM2", [4.2, 4.8], &[1, 5, 6]), [4, 5, 10]);
        // A probe goes ten places, and is back after as many of twenty.
        assert_eq!(last("G38.2 Z90 F500\nG0 Z110\nM2", never, &[1, 11, 21]), [10, 20, 30]);
        assert_eq!(last("G18\nG2 X10 Z90 R10 F500\nM2", never, &[1, 2]), [1, 2]);
    }

    #[test]
    fn a_workpiece_may_be_cut_from_the_beginning_of_the_first_way_near_it() {
        // One way each to places 1 and 11; from there into the workpiece, and into it once more.
        let scene = tests::scene(&tests::with_cutter(), "M3 S1000\nG1 X1 F6000\nG1 Z90\nG1 Z15\nG0 Z60\nG1 Z10\nM2");
        let path = path_of(&scene);
        let mut workpiece = workpiece_of(&scene, &path);
        let end = path.samples().len();
        let met = workpiece.run(end, false, &Settings::standard(), &|_, _| Vec::new());
        assert_eq!((met.cut_from, met.last), (Some(11.0), end));
    }

    #[test]
    fn a_round_workpiece_is_round_until_a_driven_cutter_feeds() {
        let at = tests::LATHE.find("[program]").unwrap();
        let insert = format!("{}tool = 1\n", &tests::LATHE[..at]);
        let drill = "[[parts]]\nname = \"drill\"\nlink = \"cross\"\nrole = \"cutter\"\ntool = 2\nturns = \"own\"\nshape = { kind = \"cylinder\", radius_mm = 3, height_mm = 10 }\n";
        let text = format!("{insert}{drill}{}step_mm = 1000\n", &tests::LATHE[at..]);
        // Each move is one place: the insert feeds to place 2, the drill to place 5.
        let program = "T1 M6\nG1 X50 F100\nT2 M6\nG0 X60\nG1 X70\nG0 X80\nM2";
        let scene = tests::scene(&text, program);
        let path = path_of(&scene);
        let mut workpiece = workpiece_of(&scene, &path);
        for asks in [true, false] {
            workpiece.others[0].once_unround = asks;
            let touching = vec![Vec::new(); workpiece.others.len()];
            let route = route_of(&workpiece, &touching);
            let found: Vec<usize> = (1..=6).filter(|&at| route.cuts_unround(at)).collect();
            assert_eq!(found, if asks { vec![5] } else { vec![] });
        }
    }

    #[test]
    fn a_cutter_that_either_of_two_may_turn_is_in_one_ball() {
        let text = tests::with_tip();
        let (at, to) = (text.rfind("name = \"moved\"").unwrap(), text.find("[program]").unwrap());
        // 40 mm beside the spindle's axis, 40 mm long: up to 20.1 mm from its middle.
        let drill = "name = \"drill\"\nlink = \"head\"\nrole = \"cutter\"\nat = { xyz_mm = [40, 0, 0] }\nshape = { kind = \"cylinder\", radius_mm = 2, height_mm = 40 }\n";
        let text = [&text[..at], drill, &text[to..]].concat();
        let text = text.replacen("name = \"fixed\"\n", "name = \"fixed\"\nrole = \"workpiece\"\n", 1);
        let scene = tests::scene(&text, "M3 S1000\nG1 Z90 F500\nM2");
        let path = path_of(&scene);
        let workpiece = workpiece_of(&scene, &path);
        let Other { own, chain, .. } = &workpiece.others[0];
        let still = crate::geometry::Isometry::identity();
        // One radian turns what is farthest from the middle by as much as it is far.
        let piece = Piece { from: 0.0, to: 1.0, first: still, last: still, turn: 1.0, way_mm: 0.0, sag_mm: 0.0 };
        let (_, radius_mm) = chain.unturned(&piece);
        assert!(own.is_some() && (radius_mm - 60.1).abs() < 0.2, "{radius_mm}");
    }

    /// A ledger of two cubes on the way of [`tests::CUBES`]: 85 places down and 85 up.
    fn with_ledger(touching: Vec<Stretch>, test: impl FnOnce(&mut Ledger<'_>, &Scene)) {
        let scene = tests::scene(&tests::with_cutter(), "G0 Z15\nG0 Z100\nM2");
        let path = path_of(&scene);
        let workpiece = workpiece_of(&scene, &path);
        test(&mut Ledger::new(&path, &workpiece.others, &[touching], 0.1), &scene);
    }

    #[test]
    fn the_first_contact_is_known_when_it_is_certain_or_its_line_is_over() {
        let (certain, uncertain) = (Depth { low: 1.0, high: 2.0 }, Depth { low: 0.0, high: 2.0 });
        let (pair, kind) = (Pair { a: 0, b: 1 }, Kind::RapidIntoWorkpiece);
        let contact = |depth: Depth, is_turned: bool| StockContact {
            pair,
            is_turned,
            kind,
            from: 80.0,
            to: 82.0,
            depth,
            deepest_at: 80.0,
        };
        // Places up to 85 are of the line of the contact.
        for (contacts, at, expected) in [
            (vec![], 90, false),
            (vec![contact(certain, false)], 83, true),
            (vec![contact(uncertain, false)], 83, false),
            (vec![contact(uncertain, false)], 90, true),
            (vec![contact(certain, true)], 90, false),
            (vec![contact(certain, true), contact(uncertain, false)], 83, false),
        ] {
            with_ledger(Vec::new(), |ledger, scene| {
                ledger.met.contacts = contacts;
                assert_eq!(ledger.knows_first(scene, at), expected, "{at} {:?}", ledger.met.contacts);
                // That of two workpieces may be none.
                let mut of_two = scene.clone();
                of_two.parts[1].role = Role::Workpiece;
                assert!(!ledger.knows_first(&of_two, at));
            });
        }
    }

    /// What a ledger tells of contacts on steps from and to places, between parts of the steps, and of a depth that is certain: from, to and depth.
    fn told(touching: Vec<Stretch>, contacts: &[(Kind, [f64; 2], [f64; 2], f64)]) -> Vec<(f64, f64, f64)> {
        let mut found = Vec::new();
        with_ledger(touching, |ledger, _| {
            for &(kind, [from, to], part, low) in contacts {
                let contact = Contact { step: 0, part: 0, from: part[0], to: part[1], depth: Depth { low, high: 2.0 } };
                ledger.contact(0, kind, &Told { from, to, examined: Vec::new() }, &contact);
            }
            found = ledger.met.contacts.iter().map(|contact| (contact.from, contact.to, contact.depth.low)).collect();
        });
        found
    }

    #[test]
    fn contacts_that_part_by_a_thousandth_of_a_step_are_one() {
        let kind = Kind::RapidIntoWorkpiece;
        let before = (kind, [20.0, 30.0], [0.25, 1.0], 1.0);
        // A step of 50 places, of which a thousandth is 0.05.
        assert_eq!(told(Vec::new(), &[before, (kind, [30.0, 80.0], [0.0008, 1.0], 1.0)]), [(22.5, 80.0, 1.0)]);
        assert_eq!(told(Vec::new(), &[before, (kind, [30.0, 80.0], [0.0012, 1.0], 1.0)]).len(), 2);
    }

    #[test]
    fn what_may_be_contact_does_not_begin_a_certain_one_of_a_later_line_or_another_kind() {
        let (rapid, whole) = (Kind::RapidIntoWorkpiece, [0.0, 1.0]);
        let (before, here, later) = ([80.5, 81.5], [81.5, 82.5], [85.0, 86.0]);
        let at_once = [(rapid, before, whole, 0.0), (rapid, here, whole, 1.0)];
        assert_eq!(told(Vec::new(), &at_once), [(80.5, 82.5, 1.0)]);
        let on_next_line = [(rapid, [84.5, 85.0], whole, 0.0), (rapid, later, whole, 1.0)];
        assert_eq!(told(Vec::new(), &on_next_line), [(84.5, 85.0, 0.0), (85.0_f64.next_up(), 86.0, 1.0)]);
        let other_kind = [(Kind::Unresolved, before, whole, 0.0), (rapid, here, whole, 1.0)];
        assert_eq!(told(Vec::new(), &other_kind), [(80.5, 81.5, 0.0), (81.5, 82.5, 1.0)]);
    }

    #[test]
    fn contact_begins_where_the_uncut_workpiece_is_touched() {
        let touching = vec![stretch([1.0, 2.0]), stretch([4.25, 4.5]), stretch([4.7, 4.8])];
        let begin = |from: f64| told(touching.clone(), &[(Kind::Collision, [4.0, 5.0], [from, 1.0], 1.0)])[0].0;
        // Where it is touched already, or for the last time, contact begins at once.
        assert_eq!([0.0, 0.375, 0.5, 0.625].map(begin), [4.25, 4.375, 4.5, 4.7]);
    }

    #[test]
    fn only_another_workpiece_as_drawn_is_near() {
        let scene = tests::scene(&tests::with_cutter(), "G0 Z80\nM2");
        let path = path_of(&scene);
        let mut workpiece = workpiece_of(&scene, &path);
        for (role, is_turned, count) in
            [(Role::Workpiece, false, 1), (Role::Workpiece, true, 0), (Role::Cutter, false, 0), (Role::Cutter, true, 0)]
        {
            (workpiece.others[0].role, workpiece.others[0].is_turned) = (role, is_turned);
            let mut ledger = Ledger::new(&path, &workpiece.others, &[], 0.1);
            ledger.meet(0, [1.0, 2.0]);
            assert_eq!(ledger.met.near.len(), count, "{role:?} {is_turned}");
        }
    }
}
