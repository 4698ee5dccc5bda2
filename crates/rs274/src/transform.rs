//! Turned (G68), scaled (G51), mirrored (G51.1, Haas's G101) and polar (G16) coordinates of Fanuc's and Haas's controls.
//!
//! A program's point is mirrored first, then scaled, then turned, as Fanuc's manuals have it. In a plane that G51.1 mirrors along one axis G68 turns the
//! other way. Of the turn where G51 mirrors, and of Haas's mirrors beside a turn, the manuals say nothing.

use super::affine::Affine;
use super::canonical::{Axis, Plane};
use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Code, Group, Values};
use super::offsets::{Offsets, Values9};

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Note on a turn in mirrored coordinates that manuals leave open.
const MIRRORED_TURN: &str = "G68 turns mirrored coordinates: which way the control turns them, and about which point, is not known here; one way is followed";

/// Note on Haas's mirrors about a zero that is shifted.
const SHIFTED_MIRROR: &str = "G101 mirrors about the work zero; whether that is the zero which G52 or G92 has shifted is not known, and it is taken to be";

/// Note on the angle of a turn in G91, which a setting of the control may make a step.
const STEP_OF_TURN: &str = "R of G68 in G91 is taken for the whole angle; with Fanuc's parameter 5400#0 (RIN) at 1, and Haas's Setting 73 ON, it adds to the angle before";

/// What is in force of them, in program coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Transforms {
    /// Where the mirror of each axis stands.
    mirrors: [Option<f64>; 3],
    scale: Option<Affine>,
    /// The factors of `scale`.
    factors: Option<[f64; 3]>,
    turn: Option<Affine>,
}

impl Transforms {
    /// Whether any mirror, scale or turn is in force.
    pub fn are_on(&self) -> bool {
        *self != Self::default()
    }

    /// Whether X, Y and Z are scaled differently.
    pub fn is_uneven(&self) -> bool {
        self.factors.is_some_and(|factors| factors.iter().any(|factor| factor.abs() != factors[0].abs()))
    }

    /// By how much lengths along X, Y or Z grow.
    pub fn factor(&self, axis: usize) -> f64 {
        self.factors.and_then(|factors| factors.get(axis).copied()).map_or(1.0, f64::abs)
    }

    /// All of them in one.
    fn affine(&self) -> Option<Affine> {
        let parts = [self.mirror(), self.scale.clone(), self.turn.clone()];
        parts.into_iter().flatten().reduce(|first, then| then.after(&first))
    }

    /// Mirrors and scales a point.
    fn apply_unturned(&self, point: &mut Values9) {
        for part in [self.mirror(), self.scale.clone()].into_iter().flatten() {
            part.apply(point);
        }
    }

    fn mirror(&self) -> Option<Affine> {
        let about = self.mirrors.map(|mirror| mirror.unwrap_or(0.0));
        let flips = self.mirrors.map(|mirror| if mirror.is_some() { -1.0 } else { 1.0 });
        self.mirrors.iter().any(Option::is_some).then(|| Affine::scale(flips, about)).flatten()
    }
}

impl Interpreter<'_> {
    /// The block's codes of this file.
    pub(super) fn obey_transforms(&mut self, values: &Values) -> Result<(), Fault> {
        if let Some(code) = values.code(Group::Turn) {
            if code.number == 680 || self.transforms.turn.is_some() {
                self.before_turn = Some(self.offsets.to_program(&self.position));
            }
            match code.number {
                680 => self.turn_coordinates(values, code)?,
                682 => self.tilt(values, code)?,
                _ => {
                    self.untransform(code)?;
                    if self.transforms.turn.take().is_some() && self.setup.dialect == Dialect::Fanuc {
                        let [first, second, _] = self.modes.plane.axes().map(|axis| axis as usize);
                        (self.turned_back[first], self.turned_back[second]) = (true, true);
                    }
                    self.transform(code)?;
                }
            }
        }
        if let Some(code) = values.code(Group::Mirror) {
            match code.number {
                own::MIRROR_OFF | own::MIRROR_ON => self.mirror_at_zero(values, code)?,
                _ => self.mirror(values, code)?,
            }
        }
        if let Some(code) = values.code(Group::Scale) {
            self.scale(values, code)?;
        }
        if let Some(code) = values.code(Group::Polar) {
            if code.number == 160 && self.modes.plane != Plane::Xy {
                return Err(code.fault(Cause::NotAllowed("polar coordinates outside the XY plane (G17)")));
            }
            self.modes.polar = code.number == 160;
        }
        Ok(())
    }

    /// Puts what is in force before all other offsets.
    fn transform(&mut self, code: &Code) -> Result<(), Fault> {
        if self.compensation.on().is_some() {
            return Err(code.fault(Cause::NotAllowed("other coordinates while cutter compensation is on")));
        }
        if self.is_tilted {
            return Err(
                code.fault(Cause::NotAllowed("turned, scaled or mirrored coordinates in a tilted plane (G68.2)"))
            );
        }
        let Transforms { mirrors, factors, turn, .. } = &self.transforms;
        let is_haas = self.setup.dialect == Dialect::Haas;
        let is_open = |axis: &Axis| {
            let axis = *axis as usize;
            (is_haas && mirrors[axis].is_some()) || factors.is_some_and(|factors| factors[axis] < 0.0)
        };
        if turn.is_some() && self.modes.plane.axes()[..2].iter().any(is_open) {
            self.note_unknown(MIRRORED_TURN.to_owned());
        }
        self.offsets.local = self.transforms.affine();
        Ok(())
    }

    /// G68: by R degrees about the point of the plane's two axis words, which G51.1 mirrors and G51 scales, or about where the tool is. Where G51.1
    /// mirrors one axis of the plane, the turn goes the other way.
    fn turn_coordinates(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if ['i', 'j', 'k'].iter().any(|&letter| values.has(letter)) {
            return Err(code.fault(Cause::NotAllowed("a turn in space; G68.2 tilts a plane")));
        }
        self.note_missing_points(values, "r");
        let degrees = values.take('r').ok_or_else(|| code.fault(Cause::Missing("R, the angle,")))?;
        // While no turn is in force, a step is the whole angle. Haas's manuals do not say that G69 forgets the angle.
        if self.modes.incremental && (self.transforms.turn.is_some() || self.setup.dialect == Dialect::Haas) {
            self.note_unknown(STEP_OF_TURN.to_owned());
        }
        let [first, second, normal] = self.modes.plane.axes();
        let mut centre = self.offsets.to_program(&self.position);
        // Where the tool is, behind all that is in force.
        let mut here = centre;
        if let Some(local) = &self.offsets.local {
            local.apply(&mut here);
        }
        let (mut reverses, mut is_beside) = (false, false);
        for axis in [first, second] {
            let (at, word) = (axis as usize, self.take_axis(values, axis));
            let mirror = self.transforms.mirrors[at];
            reverses ^= mirror.is_some();
            is_beside |= word.is_some() && mirror.is_some() && word != mirror;
            centre[at] = word.unwrap_or(centre[at]);
        }
        if is_beside && self.setup.dialect == Dialect::Fanuc {
            self.note_unknown(MIRRORED_TURN.to_owned());
        }
        self.transforms.apply_unturned(&mut centre);
        for axis in [first, second].into_iter().filter(|axis| !values.has(axis.letter().to_ascii_lowercase())) {
            centre[axis as usize] = here[axis as usize];
        }
        let degrees = if reverses { -degrees } else { degrees };
        let [x, y, z, ..] = centre;
        self.transforms.turn = Some(Affine::rotation(normal as usize, degrees, [x, y, z]));
        self.transform(code)
    }

    /// G51: by P, or by I, J and K along X, Y and Z, about the point of the axis words; G50 ends it.
    fn scale(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if code.number == 500 {
            (self.transforms.scale, self.transforms.factors) = (None, None);
            return self.transform(code);
        }
        let mut here = self.offsets.to_program(&self.position);
        self.transforms.apply_unturned(&mut here);
        let about = LINEAR.map(|axis| self.take_axis(values, axis).unwrap_or(here[axis as usize]));
        // Without a decimal point Fanuc's factors count thousandths.
        let factor = |letter: char| {
            let counts = self.setup.dialect == Dialect::Fanuc && !values.has_point(letter);
            values.take(letter).map(|value| if counts { value / 1000.0 } else { value })
        };
        let whole = factor('p');
        // Haas's scale has one factor.
        let has_three = self.setup.dialect == Dialect::Fanuc;
        let factors = match (whole, if has_three { ['i', 'j', 'k'].map(factor) } else { [None; 3] }) {
            (Some(whole), [None, None, None]) => [whole; 3],
            (None, [None, None, None]) => return Err(code.fault(Cause::Missing("P, or I, J and K, the scale,"))),
            (_, factors) => factors.map(|factor| factor.unwrap_or(1.0)),
        };
        let scale = Affine::scale(factors, about).ok_or_else(|| code.fault(Cause::Range("a scale", "other than 0")))?;
        (self.transforms.scale, self.transforms.factors) = (Some(scale), Some(factors));
        self.transform(code)
    }

    /// Haas's G101: the named axes are mirrored about zero, whatever their words say; G100 ends that for them.
    fn mirror_at_zero(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        let starts = code.number == own::MIRROR_ON;
        let is_named = |axis: Axis| self.take_axis(values, axis).is_some();
        let named = Axis::ALL.map(is_named);
        if !named.contains(&true) {
            return Err(code.fault(Cause::Missing("an axis word, which names the axis to mirror,")));
        }
        let other = Axis::ALL.into_iter().find(|axis| named[*axis as usize] && !LINEAR.contains(axis));
        if let Some(axis) = other.filter(|_| starts) {
            let letter = axis.letter().to_ascii_lowercase();
            return Err(values.fault(letter, Cause::NotAllowed("a mirror of another axis than X, Y and Z")));
        }
        let changes =
            LINEAR.iter().any(|&axis| named[axis as usize] && self.transforms.mirrors[axis as usize].is_some());
        if !starts && !changes {
            return Ok(());
        }
        for (mirror, _) in self.transforms.mirrors.iter_mut().zip(named).filter(|(_, named)| *named) {
            *mirror = starts.then_some(0.0);
        }
        self.note_shifted_mirror();
        self.transform(code)
    }

    /// Notes a mirror of Haas's that stands at a zero which G52 or G92 has shifted.
    pub(super) fn note_shifted_mirror(&mut self) {
        let Offsets { shift, local_zero, .. } = &self.offsets;
        let is_shifted = |axis: usize| shift[axis] != 0.0 || local_zero[axis] != 0.0;
        let stands_there = |axis: usize| self.transforms.mirrors[axis] == Some(0.0) && is_shifted(axis);
        if self.setup.dialect == Dialect::Haas && (0..3).any(stands_there) {
            self.note_unknown(SHIFTED_MIRROR.to_owned());
        }
    }

    /// G51.1: the named axes are mirrored where their words say; G50.1 ends that for the named axes, or all.
    fn mirror(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        let is_scaled = self.transforms.scale.is_some() && values.number(Group::Scale) != Some(500);
        if self.setup.dialect == Dialect::Fanuc && (is_scaled || self.transforms.turn.is_some()) {
            let why = "a mirror set or ended while coordinates are scaled or turned, on Fanuc's controls; cancel that first (G69, G50)";
            return Err(code.fault(Cause::NotAllowed(why)));
        }
        let words = LINEAR.map(|axis| self.take_axis(values, axis));
        let any = words.iter().any(Option::is_some);
        if code.number == 511 && !any {
            return Err(code.fault(Cause::Missing("an axis word, where the mirror stands,")));
        }
        for (mirror, word) in self.transforms.mirrors.iter_mut().zip(words) {
            match word {
                Some(at) if code.number == 511 => *mirror = Some(at),
                None if any || code.number == 511 => {}
                _ => *mirror = None,
            }
        }
        self.transform(code)
    }
}
