//! Modes and the motion codes G0, G1, G2, G3, G38.2 to G38.5, G53.

use super::arc::{CENTRE_TOLERANCE_INCH, CENTRE_TOLERANCE_MM, Circle, from_centre, from_radius};
use super::canonical::{Axis, MoveKind, Plane};
use super::compensation::Compensation;
use super::cycle::{Sticky, is_cycle};
use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::feed::{NO_TRAVEL_MM, Travel, travel};
use super::interpret::Interpreter;
use super::modal::{CANCEL_CYCLE, Group, Values};
use super::offsets::{Similar, Values9};
use super::spline::SPLINE_CHORD_MM;

/// Note on the first place behind a turn.
const ONE_AXIS_BEHIND_TURN: &str = "the first place behind G68 or G69 names one axis of the plane: the other is taken to stay where it is; a control may keep its number instead, which is another place in the turned coordinates (Fanuc's parameter 11600#5, AX1, at 0)";

/// Note on a rotary axis while Haas's G51 is on.
const SCALED_ROTARY: &str = "A, B and C are taken as written while G51 is on; Haas's controls scale them, too";

/// Note on a step behind T of a lathe.
const STEP_BEHIND_T: &str = "a step (U, W) behind a T with another offset is taken to be as long as written, as the offset shifts the coordinates; where the control moves by the offset instead (wear, or Fanuc's parameter 5002#4, LGT, at 1), it goes further by the change";

impl Interpreter<'_> {
    /// G20 and G21.
    pub(super) fn set_units(&mut self, values: &Values) {
        if let Some(units) = values.number(Group::Units) {
            self.modes.inches = units == 200;
            self.knows_units = true;
        }
    }

    pub(super) fn set_modes(&mut self, values: &Values) -> Result<(), Fault> {
        if let Some(plane) = values.number(Group::Plane) {
            let plane = match plane {
                170 => Plane::Xy,
                180 => Plane::Zx,
                _ => Plane::Yz,
            };
            if plane != self.modes.plane {
                self.refuse_compensated(values, Group::Plane, "another plane while cutter compensation is on")?;
            }
            self.modes.plane = plane;
        }
        self.set_units(values);
        if let Some(diameter) = values.number(Group::Diameter) {
            self.modes.diameter = diameter == 70;
            self.knows_diameter = true;
        }
        self.note_units();
        self.keep_offset_numbers(values)?;
        self.set_compensation(values)?;
        self.refuse_compensated(values, Group::ToolLength, "another tool offset while cutter compensation is on")?;
        self.set_tool_offset(values)?;
        let why = "another coordinate system while cutter compensation is on";
        self.refuse_compensated(values, Group::Coordinates, why)?;
        if let Some(system) = values.number(Group::Coordinates) {
            let system = self.system_of(values, system)?;
            self.change_system(system);
        }
        if values.number(Group::PathControl) == Some(640) {
            values.take('p');
            values.take('q');
        }
        if let Some(distance) = values.number(Group::Distance) {
            self.modes.incremental = distance == 910;
        }
        if let Some(distance) = values.number(Group::ArcDistance) {
            self.modes.arc_centre_absolute = distance == 901;
        }
        if let Some(level) = values.number(Group::Return) {
            self.modes.retract_to_r = level == 990;
        }
        Ok(())
    }

    /// The value of an axis word in mm or degrees, if the block has one: inches converted, diameters halved.
    pub(super) fn take_axis(&self, values: &Values, axis: Axis) -> Option<f64> {
        if self.is_step_axis(axis) {
            return None;
        }
        let letter = axis.letter().to_ascii_lowercase();
        let value = values.take(letter)?;
        if !axis.is_rotary() {
            values.note_length(letter);
        }
        Some(match axis {
            Axis::A | Axis::B | Axis::C => value,
            Axis::X if self.modes.diameter => value * self.modes.unit_mm() / 2.0,
            _ => value * self.modes.unit_mm(),
        })
    }

    /// Whether the axis's letter means steps of another axis: U, V and W on Fanuc's and Haas's lathes.
    pub(super) fn is_step_axis(&self, axis: Axis) -> bool {
        matches!(axis, Axis::U | Axis::V | Axis::W) && self.setup.is_fanuc_lathe()
    }

    /// The letter of the word that moves an axis by a step, on Fanuc's and Haas's lathes.
    pub(super) fn step_letter(&self, axis: Axis) -> Option<char> {
        let letter = match axis {
            Axis::X => 'u',
            Axis::Y => 'v',
            Axis::Z => 'w',
            Axis::C => 'h',
            _ => return None,
        };
        self.setup.is_fanuc_lathe().then_some(letter)
    }

    /// The step of an axis in mm or degrees, if the block has one.
    fn take_step(&self, values: &Values, axis: Axis) -> Option<f64> {
        let letter = self.step_letter(axis)?;
        values.note_length(letter);
        let value = values.take(letter)?;
        Some(match axis {
            Axis::C => value,
            Axis::X if self.modes.diameter => value * self.modes.unit_mm() / 2.0,
            _ => value * self.modes.unit_mm(),
        })
    }

    /// The value of an axis's word, and whether it is a step: in G91, or U, V, W or H of lathes. Of two words for an axis the later counts.
    pub(super) fn take_axis_or_step(&self, values: &Values, axis: Axis) -> Option<(f64, bool)> {
        let word = self.take_axis(values, axis).map(|value| (value, self.modes.incremental));
        let step = self.take_step(values, axis).map(|value| (value, true));
        let column = |letter: Option<char>| letter.and_then(|letter| values.column(letter));
        let is_step_later = column(self.step_letter(axis)) > column(Some(axis.letter().to_ascii_lowercase()));
        if is_step_later { step } else { word }
    }

    /// A length word in mm.
    pub(super) fn take_length(&self, values: &Values, letter: char) -> Option<f64> {
        values.note_length(letter);
        values.take(letter).map(|value| value * self.modes.unit_mm())
    }

    /// Where the axis words lead, as axis positions. Axes without a word stay exactly where they are.
    pub(super) fn target(&mut self, values: &Values) -> Values9 {
        let mut program = self.offsets.to_program(&self.position);
        let (mut named, mut names_place) = ([false; 9], false);
        // What a step adds beside itself.
        let mut change = [0.0; 9];
        for axis in Axis::ALL {
            if let Some((value, is_step)) = self.take_axis_or_step(values, axis) {
                let i = axis as usize;
                if !is_step {
                    self.note_roll_over(i, program[i], value);
                }
                program[i] = if is_step { program[i] + value } else { value };
                change[i] = if is_step { self.change_for_step(i) } else { 0.0 };
                named[i] = true;
                names_place |= !is_step;
                if axis.is_rotary() && self.setup.dialect == Dialect::Haas && self.transforms.factor(0) != 1.0 {
                    self.note_unknown(SCALED_ROTARY.to_owned());
                }
                self.note_step_behind_turn(i, is_step.then_some(value));
                if axis == Axis::Z && !is_step {
                    self.note_lapsed_length();
                }
            }
        }
        if names_place {
            self.note_unset_origin();
            self.note_turned_place(&named);
        }
        let from = self.offsets.to_program(&self.position);
        if let Some([x, y]) = self.take_polar(values, &from) {
            (program[0], program[1]) = (x, y);
            (named[0], named[1]) = (true, true);
        }
        let machine = self.offsets.to_machine(&program);
        let mixed = self.offsets.mixed_axes();
        let turned = named[..mixed].contains(&true);
        for (change, _) in self.offset_change.iter_mut().zip(named).filter(|(_, named)| *named) {
            *change = 0.0;
        }
        let position = self.position;
        std::array::from_fn(|i| if named[i] || (turned && i < mixed) { machine[i] + change[i] } else { position[i] })
    }

    /// X and Y of `@radius ^angle` about the program's origin; a word that is missing, or in G91 is added to, is what the point
    /// `from` has.
    pub(super) fn take_polar(&self, values: &Values, from: &Values9) -> Option<[f64; 2]> {
        let (radius, angle) = if self.modes.polar {
            (self.take_length(values, 'x'), values.take('y'))
        } else {
            (self.take_length(values, '@'), values.take('^'))
        };
        if radius.is_none() && angle.is_none() {
            return None;
        }
        let (old_radius, old_angle) = (from[0].hypot(from[1]), from[1].atan2(from[0]).to_degrees());
        let of = |word: Option<f64>, old: f64| match word {
            Some(value) if self.modes.incremental => old + value,
            Some(value) => value,
            None => old,
        };
        let (sin, cos) = of(angle, old_angle).to_radians().sin_cos();
        let radius = of(radius, old_radius);
        Some([radius * cos, radius * sin])
    }

    /// Where axis words in machine coordinates lead: G53.
    fn absolute_target(&mut self, values: &Values) -> Values9 {
        let words = Axis::ALL.map(|axis| self.take_axis(values, axis));
        for (i, word) in words.into_iter().enumerate().filter_map(|(i, word)| Some((i, word?))) {
            self.note_roll_over(i, self.position[i], word);
            (self.offset_change[i], self.turned_back[i]) = (0.0, false);
        }
        if words[Axis::Z as usize].is_some() {
            self.lapse_length();
        }
        std::array::from_fn(|i| words[i].unwrap_or(self.position[i]))
    }

    /// Notes the first place behind G68 or G69 where it is of one axis of the plane, and the number of the other has changed by the turn.
    pub(super) fn note_turned_place(&mut self, named: &[bool; 9]) {
        let [first, second, _] = self.modes.plane.axes().map(|axis| axis as usize);
        if !named[first] && !named[second] {
            return;
        }
        let Some(before) = self.before_turn.take() else { return };
        let now = self.offsets.to_program(&self.position);
        let other = if named[first] { second } else { first };
        if !named[other] && (before[other] - now[other]).abs() > NO_TRAVEL_MM {
            self.note_unknown(ONE_AXIS_BEHIND_TURN.to_owned());
        }
    }

    /// What a step adds to itself: on mills what the tool length has changed. T of lathes shifts the coordinates.
    fn change_for_step(&mut self, axis: usize) -> f64 {
        let change = self.offset_change[axis];
        if change != 0.0 && self.setup.is_fanuc_lathe() {
            self.note_unknown(STEP_BEHIND_T.to_owned());
            return 0.0;
        }
        change
    }

    /// Notes a step of an axis that G69 has turned back, where Fanuc's manuals want a place first; without a step the axis goes to a place.
    pub(super) fn note_step_behind_turn(&mut self, axis: usize, step: Option<f64>) {
        self.turned_back[axis] &= step.is_some();
        if self.turned_back[axis] && step != Some(0.0) {
            let note = "the first move of an axis behind G69 is a step (G91), where Fanuc's controls need a place (G90): from where the step counts is not known";
            self.note_unknown(note.to_owned());
        }
    }

    /// Notes a way from one place to another that Fanuc's controls may take otherwise where the axis rolls over: not the nearer way, or to a place below 0,
    /// where the sign may be the way.
    pub(super) fn note_roll_over(&mut self, axis: usize, from: f64, to: f64) {
        let may_roll = self.setup.endless[axis] && self.setup.dialect == Dialect::Fanuc && from != to;
        if may_roll && (to < 0.0 || (to - from).abs() >= HALF_TURN_DEG) {
            let axis = Axis::ALL[axis].letter();
            self.note_unknown(format!("{axis} is sent to a place by half a turn or more, or to one below 0: where it rolls over (Fanuc's parameter 1008#0) it goes the nearer way, or as the sign says (1008#1); here it turns to the number, as with `min_deg` and `max_deg` at its joint"));
        }
    }

    pub(super) fn obey_motion(&mut self, values: &Values) -> Result<(), Fault> {
        let axes_taken = self.uses_axis_words(values);
        self.forget_held_cut(values);
        if let Some(code) = values.code(Group::Motion) {
            // On Fanuc's controls G28 and G30 go their way, and G0 to G3 beside them set the mode for what follows.
            let only_sets_mode = self.setup.dialect.is_fanuc_like()
                && matches!(code.number, 0..=30)
                && matches!(values.number(Group::NonModal), Some(280 | 300));
            if axes_taken && values.has_axis() && code.number != CANCEL_CYCLE && !only_sets_mode {
                return Err(code.fault(Cause::NotAllowed("another code of this block uses the axis words")));
            }
            if code.number == CANCEL_CYCLE {
                // On Fanuc's controls cycles are a group of their own, beside G0 to G3.
                self.modes.motion = if self.setup.dialect.is_fanuc_like() { self.modes.plain_motion } else { None };
            } else {
                self.modes.motion = Some(code.number);
            }
            if matches!(code.number, 0..=30) {
                self.modes.plain_motion = Some(code.number);
            }
            if !is_cycle(code.number) {
                self.sticky = Sticky::default();
            }
        }
        if !matches!(self.modes.motion, Some(50)) {
            self.spline_leaves = None;
        }
        let absolute = values.number(Group::Absolute).is_some();
        self.refuse_compensated(values, Group::Absolute, "G53 while cutter compensation is on")?;
        // Fanuc's G53 goes at rapid rate whatever the mode, and does not count under G91.
        let is_rapid_always = self.setup.dialect == Dialect::Fanuc;
        if absolute && is_rapid_always && self.modes.incremental {
            return Err(self.fault_at(values, Group::Absolute, Cause::NotAllowed("G53 under G91, which ignores it,")));
        }
        if absolute && !is_rapid_always && !matches!(self.modes.motion, Some(0 | 10)) {
            return Err(self.fault_at(values, Group::Absolute, Cause::NotAllowed("G53 needs G0 or G1")));
        }
        // A full circle in an arc's mode needs no more than its centre.
        let has_vector = "ijk".chars().any(|letter| values.has(letter));
        let is_circle = matches!(self.modes.motion, Some(20 | 30)) && has_vector;
        let turns = self.has_tool_vectors && has_vector;
        let starts = values.number(Group::Motion).is_some_and(|code| code != CANCEL_CYCLE);
        // H of lathes moves C by a step.
        let has_axis = values.has_axis() || self.step_letter(Axis::C).is_some_and(|letter| values.has(letter));
        let moves = has_axis || starts || is_circle || turns;
        if axes_taken || !moves {
            return Ok(());
        }
        if self.modes.polar
            && self.modes.incremental
            && self.setup.dialect.is_fanuc_like()
            && values.has('x')
            && !absolute
        {
            let why = "a polar radius in G91, whose pole is where the tool is";
            return Err(values.fault('x', Cause::NotAllowed(why)));
        }
        match self.modes.motion.map(|code| if absolute && is_rapid_always { 0 } else { code }) {
            Some(code @ (0 | 10)) => {
                if !has_axis && !turns {
                    return Ok(());
                }
                if absolute {
                    return self.in_machine_coordinates(values, Group::Absolute, |interpreter| {
                        let target = interpreter.absolute_target(values);
                        if code == 0 { interpreter.rapid_to(target) } else { interpreter.feed_to(target, values) }
                    });
                }
                let mut target = self.target(values);
                self.point_tool(values, &mut target)?;
                if code == 0 {
                    self.straight_to(target, MoveKind::Rapid, None, values)
                } else {
                    self.feed_with_corners(target, values)
                }
            }
            Some(code @ (20 | 30)) => self.arc(values, code == 20),
            Some(code @ (50 | 51)) => self.spline(values, code),
            Some(_) if self.compensation.on().is_some() => {
                let why = "another motion than G0 to G3 while cutter compensation is on";
                Err(values.motion_fault(Cause::NotAllowed(why)))
            }
            Some(code @ (330 | 331)) => self.thread_move(values, code == 331),
            // A probe that nothing stops: the whole move.
            Some(382..=385) if values.has_axis() => self.probe(values),
            Some(760) => self.thread_cycle(values),
            Some(code @ (own::TURN_CUT | own::THREAD_CUT | own::FACE_CUT)) => self.lathe_cycle(values, code),
            Some(code @ (own::PECK_FACE | own::PECK_GROOVE | own::THREAD)) => {
                // These hold for their own block alone.
                self.modes.motion = self.modes.plain_motion;
                self.lathe_cycle(values, code)
            }
            Some(code) if is_cycle(code) => self.cycle(values, code),
            Some(_) => Err(self.fault_at(values, Group::Motion, Cause::Unsupported)),
            // Axis words without a motion mode stay unused, which is reported as such.
            None => Ok(()),
        }
    }

    /// G31 and G38.2 to G38.5: as when the probe meets nothing; parameters 5061 to 5070 say so.
    pub(super) fn probe(&mut self, values: &Values) -> Result<(), Fault> {
        let target = self.target(values);
        let start = self.position;
        let back = match travel(&start, &target) {
            Travel::Along(length) => self.setup.probe_stops_short_mm / length,
            Travel::Turning(_) => 0.0,
        };
        let known = self.moves.len();
        self.feed_to(std::array::from_fn(|i| target[i] + back * (start[i] - target[i])), values)?;
        self.moves[known..].iter_mut().for_each(|step| step.is_probe = true);
        self.note_probe();
        let ends = match self.modes.motion {
            Some(382 | 384) => "; at G38.2 and G38.4 that meet nothing the control stops",
            _ => "",
        };
        self.note_unknown(format!("nothing stops a probe here: it goes to the end of its move. Contact of the tool's tip with the workpiece on that way, and straight back on it, is not told, and what the program makes of #5061 to #5069 is not what the machine measures{ends}"));
        Ok(())
    }

    /// A rapid move; cutter compensation is off.
    pub(super) fn rapid_to(&mut self, target: Values9) -> Result<(), Fault> {
        self.compensation = Compensation::Off;
        self.position = target;
        self.emit(MoveKind::Rapid, None)
    }

    /// A straight move at a feed rate; cutter compensation is off.
    pub(super) fn feed_at(&mut self, target: Values9, feed: Option<f64>) -> Result<(), Fault> {
        self.compensation = Compensation::Off;
        self.position = target;
        self.emit(MoveKind::Feed, feed)
    }

    /// A straight feed move.
    pub(super) fn feed_to(&mut self, target: Values9, values: &Values) -> Result<(), Fault> {
        let feed = self.straight_feed(&target, values)?;
        self.straight_to(target, MoveKind::Feed, feed, values)
    }

    /// G2 and G3.
    fn arc(&mut self, values: &Values, clockwise: bool) -> Result<(), Fault> {
        let plane = self.modes.plane;
        let target = self.target(values);
        // Fanuc's and Haas's arcs have no P.
        let turns = if self.setup.dialect.is_fanuc_like() {
            None
        } else {
            values.take_whole('p', 1..=MAX_TURNS, "P", "a whole number of turns from 1 to 100000")?
        };
        let turns = turns.unwrap_or(1);
        let Some(similar) = self.offsets.similar(plane) else {
            if self.transforms.is_uneven() {
                let why = "an arc in a plane of axes that G51 scales differently: Fanuc's controls trace no ellipse";
                return Err(values.motion_fault(Cause::NotAllowed(why)));
            }
            return self.bent_arc(values, &target, clockwise, turns);
        };
        let circle = self.circle(values, &self.position, &target, clockwise, turns, Some(similar))?;
        let feed = self.arc_feed(&circle, &target, values)?;
        if self.compensation.on().is_some() {
            return self.compensated_arc(target, &circle, turns, feed, values);
        }
        self.round_to(target, &circle, feed, values)
    }

    /// An arc of one turn at most under cutter compensation.
    pub(super) fn round_to(
        &mut self,
        target: Values9,
        circle: &Circle,
        feed: Option<f64>,
        values: &Values,
    ) -> Result<(), Fault> {
        if self.compensation.on().is_some() {
            return self.compensated_arc(target, circle, 1, feed, values);
        }
        self.refuse_leading_out_by_an_arc(values)?;
        self.position = target;
        self.emit(MoveKind::Arc { plane: self.modes.plane, centre: circle.centre, sweep: circle.sweep }, feed)
    }

    fn refuse_leading_out_by_an_arc(&self, values: &Values) -> Result<(), Fault> {
        if self.compensation.is_leaving() {
            let why = "an arc right behind G40: the move that leads out must be straight";
            return Err(values.motion_fault(Cause::NotAllowed(why)));
        }
        Ok(())
    }

    /// The feed rate of an arc in axis positions.
    pub(super) fn arc_feed(&self, circle: &Circle, target: &Values9, values: &Values) -> Result<Option<f64>, Fault> {
        let [first, second, normal] = self.modes.plane.axes().map(|axis| axis as usize);
        let radius = (self.position[first] - circle.centre[0]).hypot(self.position[second] - circle.centre[1]);
        let along = target[normal] - self.position[normal];
        self.feed_for(Travel::Along((radius * circle.sweep).hypot(along)), target, values)
    }

    /// An arc whose plane is none of the machine's, or that is no circle there: straight feeds that leave it by no more than
    /// [`SPLINE_CHORD_MM`].
    fn bent_arc(&mut self, values: &Values, target: &Values9, clockwise: bool, turns: i32) -> Result<(), Fault> {
        if self.compensation.on().is_some() {
            let why = "an arc in a plane that is turned, scaled or tilted out of the machine's while cutter compensation is on";
            return Err(values.motion_fault(Cause::NotAllowed(why)));
        }
        self.refuse_leading_out_by_an_arc(values)?;
        let (start, end) = (self.offsets.to_program(&self.position), self.offsets.to_program(target));
        let circle = self.circle(values, &start, &end, clockwise, turns, None)?;
        self.bend_to(target, &circle, values)
    }

    /// An arc in program coordinates by straight feeds.
    pub(super) fn bend_to(&mut self, target: &Values9, circle: &Circle, values: &Values) -> Result<(), Fault> {
        let (start, end) = (self.offsets.to_program(&self.position), self.offsets.to_program(target));
        let [first, second, _] = self.modes.plane.axes().map(|axis| axis as usize);
        let radius = |at: &Values9| (at[first] - circle.centre[0]).hypot(at[second] - circle.centre[1]);
        let radii = [radius(&start), radius(&end)];
        let larger = radii[0].max(radii[1]);
        let feed = self.feed_for(Travel::Along(larger * circle.sweep.abs()), target, values)?;
        // As a function of the fraction, the curve's second derivative is at most this; see `path`.
        let bend = (2.0 * (radii[1] - radii[0]) * circle.sweep).hypot(larger * circle.sweep * circle.sweep);
        let chords = (self.offsets.largest_scale() * bend / (8.0 * SPLINE_CHORD_MM)).sqrt().ceil().max(4.0);
        if chords > MAX_CHORDS {
            let cause = Cause::Limit { limit: MAX_CHORDS as usize, what: "straight pieces of one arc" };
            return Err(values.motion_fault(cause));
        }
        let from = (start[second] - circle.centre[1]).atan2(start[first] - circle.centre[0]);
        for chord in 1..chords as u32 {
            let part = f64::from(chord) / chords;
            let mut point: Values9 = std::array::from_fn(|i| start[i] + part * (end[i] - start[i]));
            let radius = radii[0] + part * (radii[1] - radii[0]);
            let (sin, cos) = (from + part * circle.sweep).sin_cos();
            (point[first], point[second]) = (circle.centre[0] + radius * cos, circle.centre[1] + radius * sin);
            let machine = self.offsets.to_machine(&point);
            self.feed_at(machine, feed)?;
        }
        self.feed_at(*target, feed)
    }

    /// Centre and sweep of the block's arc from `start` to `target`: axis positions, where circles of the program are `similar` circles,
    /// or program coordinates.
    pub(super) fn circle(
        &self,
        values: &Values,
        start: &Values9,
        target: &Values9,
        clockwise: bool,
        turns: i32,
        similar: Option<Similar>,
    ) -> Result<Circle, Fault> {
        let plane = self.modes.plane;
        let [first, second, _] = plane.axes().map(|axis| axis as usize);
        let letters = match plane {
            Plane::Xy => ['i', 'j'],
            Plane::Zx => ['k', 'i'],
            Plane::Yz => ['j', 'k'],
        };
        let start = [start[first], start[second]];
        let end = [target[first], target[second]];
        let fault = |cause| self.fault_at(values, Group::Motion, cause);
        let in_machine = similar.is_some();
        let Similar { scale, mirrors } = similar.unwrap_or(Similar { scale: 1.0, mirrors: false });
        let clockwise = clockwise != mirrors;
        if let Some(radius) = self.take_length(values, 'r') {
            if self.setup.dialect == Dialect::Fanuc {
                // R takes precedence.
                ['i', 'j', 'k'].into_iter().for_each(|letter| values.drop_word(letter));
            }
            return from_radius(start, end, radius * scale, clockwise, turns).map_err(fault);
        }
        let given = letters.map(|letter| self.take_length(values, letter));
        if self.setup.dialect == Dialect::Grbl {
            // It takes a word of the third axis and does nothing with it.
            ['i', 'j', 'k'].into_iter().for_each(|letter| values.drop_word(letter));
        }
        let mut centre = [0.0; 9];
        (centre[first], centre[second]) = (given[0].unwrap_or(0.0), given[1].unwrap_or(0.0));
        if self.modes.arc_centre_absolute {
            if given.contains(&None) {
                return Err(fault(Cause::Missing("a centre word (G90.1 needs both of the plane)")));
            }
            if in_machine {
                centre = self.offsets.to_machine(&centre);
            }
        } else {
            if given == [None, None] {
                return Err(fault(Cause::Missing("the radius R or a centre word of the plane")));
            }
            if in_machine {
                self.offsets.to_machine_vector(&mut centre);
            }
            (centre[first], centre[second]) = (centre[first] + start[0], centre[second] + start[1]);
        }
        let tolerance = if self.modes.inches { CENTRE_TOLERANCE_INCH * 25.4 } else { CENTRE_TOLERANCE_MM };
        from_centre(start, end, [centre[first], centre[second]], clockwise, turns, tolerance * scale).map_err(fault)
    }
}

/// Half a turn, less what rounding may add to one, degrees.
const HALF_TURN_DEG: f64 = 180.0 - 1e-9;

/// Most straight pieces of one arc.
const MAX_CHORDS: f64 = 1_000_000.0;

/// Most turns of one arc.
const MAX_TURNS: i32 = 100_000;
