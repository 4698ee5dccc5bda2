//! Turned (G68), scaled (G51), mirrored (G51.1, Haas's G101) and polar (G16) coordinates of Fanuc's and Haas's controls.
//!
//! A program's point is mirrored first, then scaled, then turned, as Fanuc's manuals have it.

use super::affine::Affine;
use super::canonical::{Axis, Plane};
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Code, Group, Values};

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// What is in force of them, in program coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Transforms {
    /// Where the mirror of each axis stands.
    mirrors: [Option<f64>; 3],
    scale: Option<Affine>,
    /// The factors of `scale`, sizes alone.
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
        self.factors.is_some_and(|[x, y, z]| x != y || y != z)
    }

    /// By how much lengths along X, Y or Z grow.
    pub fn factor(&self, axis: usize) -> f64 {
        self.factors.and_then(|factors| factors.get(axis).copied()).unwrap_or(1.0)
    }

    /// All of them in one.
    fn affine(&self) -> Option<Affine> {
        let parts = [self.mirror(), self.scale.clone(), self.turn.clone()];
        parts.into_iter().flatten().reduce(|first, then| then.after(&first))
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
            match code.number {
                680 => self.turn_coordinates(values, code)?,
                682 => self.tilt(values, code)?,
                _ => {
                    self.untransform(code)?;
                    self.transforms.turn = None;
                    self.transform(code)?;
                }
            }
        }
        if let Some(code) = values.code(Group::Mirror) {
            self.mirror(values, code)?;
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
        self.offsets.local = self.transforms.affine();
        Ok(())
    }

    /// G68: by R degrees about the point of the plane's two axis words, which G51 scales, or about where the tool is.
    fn turn_coordinates(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if ['i', 'j', 'k'].iter().any(|&letter| values.has(letter)) {
            return Err(code.fault(Cause::NotAllowed("a turn in space; G68.2 tilts a plane")));
        }
        let degrees = values.take('r').ok_or_else(|| code.fault(Cause::Missing("R, the angle,")))?;
        let [first, second, normal] = self.modes.plane.axes();
        let mut here = self.offsets.to_program(&self.position);
        let mut named = here;
        let words = [first, second].map(|axis| (axis as usize, self.take_axis(values, axis)));
        for (axis, word) in words {
            named[axis] = word.unwrap_or(named[axis]);
        }
        // A turn is about a point of the scaled coordinates. Those of the tool are mirrored, too.
        let Transforms { scale, .. } = &self.transforms;
        for part in [self.transforms.mirror().as_ref(), scale.as_ref()].into_iter().flatten() {
            part.apply(&mut here);
        }
        if let Some(scale) = scale {
            scale.apply(&mut named);
        }
        let mut centre = [0.0; 3];
        for (axis, word) in words {
            centre[axis] = if word.is_some() { named[axis] } else { here[axis] };
        }
        self.transforms.turn = Some(Affine::rotation(normal as usize, degrees, centre));
        self.transform(code)
    }

    /// G51: by P, or by I, J and K along X, Y and Z, about the point of the axis words; G50 ends it.
    fn scale(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if code.number == 500 {
            (self.transforms.scale, self.transforms.factors) = (None, None);
            return self.transform(code);
        }
        let here = self.offsets.to_program(&self.position);
        let about = LINEAR.map(|axis| self.take_axis(values, axis).unwrap_or(here[axis as usize]));
        // Without a decimal point Fanuc's factors count thousandths.
        let factor = |letter: char| {
            let counts = self.setup.dialect == super::dialect::Dialect::Fanuc && !values.has_point(letter);
            values.take(letter).map(|value| if counts { value / 1000.0 } else { value })
        };
        let whole = factor('p');
        // Haas's scale has one factor.
        let has_three = self.setup.dialect == super::dialect::Dialect::Fanuc;
        let factors = match (whole, if has_three { ['i', 'j', 'k'].map(factor) } else { [None; 3] }) {
            (Some(whole), [None, None, None]) => [whole; 3],
            (None, [None, None, None]) => return Err(code.fault(Cause::Missing("P, or I, J and K, the scale,"))),
            (_, factors) => factors.map(|factor| factor.unwrap_or(1.0)),
        };
        let scale = Affine::scale(factors, about).ok_or_else(|| code.fault(Cause::Range("a scale", "other than 0")))?;
        (self.transforms.scale, self.transforms.factors) = (Some(scale), Some(factors.map(f64::abs)));
        self.transform(code)
    }

    /// G51.1: the named axes are mirrored where their words say; G50.1 ends that for the named axes, or all.
    fn mirror(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
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
