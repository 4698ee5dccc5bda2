//! Rotating tools by their dimensions: cutter, shank and holder as solids of revolution, and the text that describes them on a command
//! line.
//!
//! A tool stands on its tip at z = 0, with its axis along z. The cutter extends to the end of its flutes, the shank to the start of the
//! holder, and the holder, step by step, to the spindle's gauge line.

use super::file::{HolderStepFile, PositionFile, ToolFile};
use super::set_up::SKEW;
use super::{Part, Role};
use crate::geometry::shapes::outline::{OutlineCorner, OutlinePoint};
use crate::geometry::shapes::{Revolve, Shape, Tessellation};
use crate::geometry::{Isometry, Vector, turn_between};
use crate::machine::Machine;
use crate::machine::tip::TipControl;
use nalgebra::{Matrix3, Translation3};
use rs274::{Axis, Position, Tool};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Tessellation of tools: the chords of their circles deviate by at most 0.0027 mm.
const TESSELLATION: Tessellation = Tessellation { grading: 1.0, density: 3.0 };
/// Lengths that differ by less than this count as equal, mm.
const SAME_MM: f64 = 1e-6;
/// Smallest difference of length or diameter between the table and the drawn tool that is reported, mm.
const TOLD_MM: f64 = 0.5;

/// A checked entry of a tool table, a library or a command line.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolEntry {
    /// Its number.
    pub number: u32,
    /// The entry in the tool table; the offset is zero when none was given.
    pub tool: Tool,
    /// Whether the offset was given.
    pub has_offset: bool,
    /// The dimensions of the tool; `None` when none were given.
    pub assembly: Option<Assembly>,
}

/// The dimensions of a rotating tool, mm and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Cutting diameter.
    diameter_mm: f64,
    /// Radius between end and side; half the diameter for a ball end.
    corner_mm: f64,
    /// Full angle of a drill's point, radians.
    point: Option<f64>,
    /// Length from the tip to the end of the cutting part.
    flute_mm: f64,
    /// Diameter above the flutes.
    shank_mm: f64,
    /// Length from the tip to the holder; when `None`, it follows from the tool's length in the table.
    stickout_mm: Option<f64>,
    /// The steps of the holder, from the tool's side upwards.
    holder: Vec<HolderStepFile>,
}

impl ToolEntry {
    /// Makes the entry from a file or a command line.
    ///
    /// # Errors
    /// A message that does not name the tool.
    pub(super) fn new(file: &ToolFile) -> Result<Self, String> {
        let offset = file.offset.unwrap_or_default().position();
        let offset = super::program::finite("offset", offset)?;
        if !(file.diameter_mm >= 0.0 && file.diameter_mm.is_finite()) {
            return Err("diameter_mm must be a finite number, at least 0".to_owned());
        }
        if file.orientation > 9 {
            return Err("orientation must be from 0 to 9".to_owned());
        }
        let tool = Tool { offset, diameter_mm: file.diameter_mm, orientation: file.orientation };
        let assembly = Assembly::new(file)?;
        Ok(Self { number: file.number, tool, has_offset: file.offset.is_some(), assembly })
    }

    /// Parses the text of a command line, such as `3=diameter:10,flute:22,stickout:40,holder:32x20/50x40`, mm and degrees.
    ///
    /// # Errors
    /// A message that states the expected form.
    pub fn parse(text: &str) -> Result<Self, String> {
        let like = "it must be like 3=diameter:10,flute:22,stickout:40,holder:32x20/50x40";
        let (number, measures) = text.split_once('=').ok_or(like)?;
        let number = number.trim().parse().map_err(|_| format!("`{number}` is not a tool's number; {like}"))?;
        let mut file = ToolFile { number, ..ToolFile::default() };
        for measure in measures.split(',') {
            let (key, value) = measure.split_once(':').ok_or_else(|| format!("`{measure}` has no value; {like}"))?;
            let number = || value.trim().parse::<f64>().map_err(|_| format!("{key}: `{value}` is not a number"));
            match key.trim() {
                "diameter" => file.diameter_mm = number()?,
                "corner" => file.corner_mm = Some(number()?),
                "point" => file.point_deg = Some(number()?),
                "flute" => file.flute_mm = Some(number()?),
                "shank" => file.shank_mm = Some(number()?),
                "stickout" => file.stickout_mm = Some(number()?),
                "length" => file.length_mm = Some(number()?),
                "offset" => file.offset = Some(PositionFile { z_mm: number()?, ..PositionFile::default() }),
                "holder" => file.holder = Some(holder(value)?),
                _ => {
                    return Err(format!(
                        "`{key}` is none of diameter, corner, point, flute, shank, stickout, length, holder, offset"
                    ));
                }
            }
        }
        let entry = Self::new(&file)?;
        if entry.assembly.is_none() {
            return Err(format!("flute and stickout are missing; {like}"));
        }
        Ok(entry)
    }
}

/// Parses `32x20/50x40`: steps of diameter and length, from the tool's side upwards; `27-40x35` widens from 27 to 40.
fn holder(text: &str) -> Result<Vec<HolderStepFile>, String> {
    let step = |step: &str| {
        let wrong = || format!("holder: `{step}` must be diameter x length, as in 32x20, or 27-40x35 for a cone");
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
        let (diameter, length_mm) = step.split_once('x').ok_or_else(wrong)?;
        let (diameter_mm, top_mm) = match diameter.split_once('-') {
            Some((bottom, top)) => (number(bottom)?, Some(number(top)?)),
            None => (number(diameter)?, None),
        };
        Ok(HolderStepFile { diameter_mm, top_mm, length_mm: number(length_mm)? })
    };
    text.split('/').map(step).collect()
}

impl Assembly {
    /// The dimensions of a tool; `None` when the file gives none.
    fn new(file: &ToolFile) -> Result<Option<Self>, String> {
        let ToolFile { corner_mm, point_deg, flute_mm, shank_mm, stickout_mm, length_mm, holder, .. } = file;
        let numbers = [
            ("corner_mm", corner_mm),
            ("point_deg", point_deg),
            ("flute_mm", flute_mm),
            ("shank_mm", shank_mm),
            ("stickout_mm", stickout_mm),
            ("length_mm", length_mm),
        ];
        if holder.is_none() && numbers.iter().all(|(_, number)| number.is_none()) {
            return Ok(None);
        }
        let holder = holder.clone().unwrap_or_default();
        let holder_numbers = holder.iter().enumerate().flat_map(|(i, step)| {
            let HolderStepFile { diameter_mm, top_mm, length_mm } = *step;
            [("diameter_mm", Some(diameter_mm)), ("top_mm", top_mm), ("length_mm", Some(length_mm))]
                .map(|(name, number)| (format!("holder[{i}].{name}"), number))
        });
        let all = numbers.iter().map(|(name, number)| ((*name).to_owned(), **number)).chain(holder_numbers);
        let given = all.filter_map(|(name, number)| Some((name, number?)));
        for (name, number) in given.chain([("diameter_mm".to_owned(), file.diameter_mm)]) {
            let may_be_zero = name == "corner_mm";
            if !(number > 0.0 || may_be_zero && number == 0.0) || !number.is_finite() {
                return Err(format!("{name} is {number}; a tool with a shape needs a finite number above 0"));
            }
        }
        let flute_mm = flute_mm.ok_or("flute_mm is missing: how much of the tool cuts")?;
        let corner_mm = corner_mm.unwrap_or(0.0);
        let radius = 0.5 * file.diameter_mm;
        if corner_mm > radius + SAME_MM {
            return Err(format!("corner_mm is {corner_mm}, more than half the diameter of {}", file.diameter_mm));
        }
        let point = point_deg.map(f64::to_radians);
        if point.is_some_and(|point| point >= PI) || point.is_some() && corner_mm > 0.0 {
            return Err("point_deg must be below 180, and a tool with a point has no corner_mm".to_owned());
        }
        let end = point.map_or(corner_mm, |point| radius / (0.5 * point).tan());
        if end >= flute_mm {
            return Err(format!("flute_mm is {flute_mm}, and the tool's end alone takes {end:.3}"));
        }
        let holder_mm: f64 = holder.iter().map(|step| step.length_mm).sum();
        let from_length = length_mm.map(|length| length - holder_mm);
        if let (Some(one), Some(other)) = (*stickout_mm, from_length)
            && (one - other).abs() > SAME_MM
        {
            return Err(format!(
                "stickout_mm is {one}, and length_mm less the holder's {holder_mm} is {other}; one of the two is enough"
            ));
        }
        let assembly = Self {
            diameter_mm: file.diameter_mm,
            corner_mm,
            point,
            flute_mm,
            shank_mm: shank_mm.unwrap_or(file.diameter_mm),
            stickout_mm: stickout_mm.or(from_length),
            holder,
        };
        assembly.stickout_mm.map_or(Ok(()), |stickout| assembly.holds(stickout))?;
        Ok(Some(assembly))
    }

    /// Checks that the flutes end before the holder begins.
    fn holds(&self, stickout_mm: f64) -> Result<(), String> {
        if stickout_mm + SAME_MM < self.flute_mm {
            let flute = self.flute_mm;
            return Err(format!("the tool sticks out by {stickout_mm} mm, less than its flute_mm of {flute}"));
        }
        Ok(())
    }

    /// Length of the holder, mm.
    fn holder_mm(&self) -> f64 {
        self.holder.iter().map(|step| step.length_mm).sum()
    }

    /// Length from the tip to the holder: the given one, or otherwise the tool's length in the table minus the holder.
    fn stickout_mm(&self, tabled_mm: Option<f64>) -> Result<f64, String> {
        let stickout = self.stickout_mm.or_else(|| tabled_mm.map(|length| length - self.holder_mm()));
        let stickout = stickout.ok_or("stickout_mm or length_mm is missing: how far the tool sticks out")?;
        self.holds(stickout)?;
        Ok(stickout)
    }

    /// The outline of the cutting part, with its tip at the origin.
    fn cutter(&self) -> Vec<OutlinePoint> {
        let (radius, corner, top) = (0.5 * self.diameter_mm, self.corner_mm, self.flute_mm);
        let sharp = |r: f64, z: f64| OutlinePoint::Sharp([r, z]);
        let end = if let Some(point) = self.point {
            vec![sharp(0.0, 0.0), sharp(radius, radius / (0.5 * point).tan())]
        } else if corner > radius - SAME_MM {
            let pole = OutlineCorner { at_mm: [0.0, 0.0], arc_mm: radius, ..OutlineCorner::default() };
            vec![OutlinePoint::Detailed(pole), sharp(radius, radius)]
        } else {
            vec![sharp(0.0, 0.0), OutlinePoint::Rounded([radius, 0.0, corner])]
        };
        end.into_iter().chain([sharp(radius, top), sharp(0.0, top)]).collect()
    }

    /// The outline of the holder above `bottom`.
    fn holder_outline(&self, bottom: f64) -> Vec<OutlinePoint> {
        let mut outline: Vec<[f64; 2]> = vec![[0.0, bottom]];
        let mut z = bottom;
        for step in &self.holder {
            let top = step.top_mm.unwrap_or(step.diameter_mm);
            for point in [[0.5 * step.diameter_mm, z], [0.5 * top, z + step.length_mm]] {
                if outline.last() != Some(&point) {
                    outline.push(point);
                }
            }
            z += step.length_mm;
        }
        outline.push([0.0, z]);
        outline.into_iter().map(OutlinePoint::Sharp).collect()
    }

    /// The solids of the tool by role, from the tip upwards.
    fn solids(&self, stickout: f64) -> Vec<(Role, Shape)> {
        let revolved = |profile_mm| Shape::Revolve(Revolve { profile_mm });
        let mut solids = vec![(Role::Cutter, revolved(self.cutter()))];
        if stickout > self.flute_mm + SAME_MM {
            let radius = 0.5 * self.shank_mm;
            let shank = [[0.0, self.flute_mm], [radius, self.flute_mm], [radius, stickout], [0.0, stickout]];
            solids.push((Role::Shank, revolved(shank.map(OutlinePoint::Sharp).to_vec())));
        }
        if !self.holder.is_empty() {
            solids.push((Role::Holder, revolved(self.holder_outline(stickout))));
        }
        solids
    }
}

/// A tool mounted in the spindle of a machine: its parts, its entry in the table, and what is to be told of it.
pub(super) struct Mounted {
    pub parts: Vec<Part>,
    pub tool: Tool,
    pub drawn: DrawnTool,
}

/// The lengths and the diameter of a tool that was drawn by its dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnTool {
    /// Its number.
    pub number: u32,
    /// Length from the gauge line to the tip, mm.
    pub length_mm: f64,
    /// Cutting diameter, mm.
    diameter_mm: f64,
    /// Offsets of X, Y and Z for a length of 1 mm; `None` when these axes are not at right angles.
    up: Option<Vector>,
    /// Stick-out of a tool without a holder, mm.
    bare_mm: Option<f64>,
    /// Whether its offset was given; otherwise it follows from the length.
    has_offset: bool,
    /// Names of its parts.
    parts: Vec<String>,
}

impl DrawnTool {
    /// Whether the part is one of the tool's, by its name.
    pub(super) fn has(&self, part: &Part) -> bool {
        self.parts.contains(&part.name)
    }

    /// Moves the tool into the spindle of `tip`: its parts among `parts` and, where its offset follows from its length, `tool`, its entry in
    /// the table. Its length stays.
    ///
    /// # Errors
    /// When an axis does not move the tool there, or its length gives no offset.
    pub(super) fn mount_again(
        &mut self,
        machine: &Machine,
        tip: &TipControl,
        parts: &mut [Part],
        tool: Option<&mut Tool>,
    ) -> Result<(), String> {
        check_axes(machine, tip, &Position::default())?;
        let up = up_by_axes(machine, tip);
        self.up = if self.has_offset { up.ok() } else { Some(up?) };
        if let (false, Some(up), Some(tool)) = (self.has_offset, self.up, tool) {
            set_length(tool, &up, self.length_mm);
        }
        for part in parts.iter_mut().filter(|part| self.has(part)) {
            part.link = tip.tool_link;
            part.link_from_part = link_from_tool(tip, self.length_mm);
        }
        Ok(())
    }

    /// Warnings for the reader: an offset or a diameter in the table that differs from the drawn tool, and a missing holder.
    pub fn notes(&self, table: &BTreeMap<u32, Tool>) -> Vec<String> {
        let Self { number, length_mm, diameter_mm, up, bare_mm, .. } = self;
        let tool = table.get(number);
        let tabled = up.zip(tool).map(|(up, tool)| along(&up, tool));
        let differs = tabled.filter(|tabled| (tabled - length_mm).abs() > TOLD_MM).map(|tabled| {
            format!("tool {number} is {length_mm:.3} mm long from the gauge line to its tip, and its offset says {tabled:.3} mm")
        });
        // 0 is a table without diameters, or one of what is left to compensate.
        let tabled = tool.map(|tool| tool.diameter_mm).filter(|&tabled| tabled != 0.0);
        let is_other = tabled.filter(|tabled| (tabled - diameter_mm).abs() > TOLD_MM).map(|tabled| {
            format!("tool {number} is drawn {diameter_mm:.3} mm wide, and the tool table says {tabled:.3} mm, which G41 and G42 go by")
        });
        let bare = bare_mm.map(|stickout| {
            format!("tool {number} has no holder: nothing is known of what is above its {stickout} mm")
        });
        differs.into_iter().chain(is_other).chain(bare).collect()
    }
}

/// Length of a tool by its offsets of X, Y and Z, mm.
fn along(up: &Vector, tool: &Tool) -> f64 {
    up.dot(&Vector::new(tool.offset[Axis::X], tool.offset[Axis::Y], tool.offset[Axis::Z]))
}

/// Sets the offsets of X, Y and Z of a tool from its length; `up` is their value for 1 mm.
fn set_length(tool: &mut Tool, up: &Vector, length_mm: f64) {
    for (axis, part) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(up.iter()) {
        let value = part * length_mm;
        tool.offset[axis] = if value.abs() < SAME_MM { 0.0 } else { value };
    }
}

/// Pose of a tool of `length_mm`, which stands on its tip, in the frame of the link that holds it.
fn link_from_tool(tip: &TipControl, length_mm: f64) -> Isometry {
    let turn = turn_between(&Vector::z(), &-tip.direction.into_inner());
    let point = tip.gauge + tip.direction.into_inner() * length_mm;
    Isometry::from_parts(Translation3::from(point.coords), turn)
}

/// Offsets of X, Y and Z, as G43 adds them, for a tool of 1 mm: the direction up the tool by the directions in which the axes move the tip
/// over the workpiece.
///
/// # Errors
/// When these directions are not at right angles.
fn up_by_axes(machine: &Machine, tip: &TipControl) -> Result<Vector, String> {
    let axes = tip.axes_at_zero(machine);
    if (axes.transpose() * axes - Matrix3::identity()).amax() > SKEW {
        let why = "X, Y and Z do not move the tool over the workpiece at right angles, so its length gives no offset: give both `offset` and `stickout_mm`";
        return Err(why.to_owned());
    }
    let up = tip.tool_vector(machine, &Position::default());
    Ok(axes.transpose() * up.into_inner())
}

/// Checks that those of X, Y and Z that the machine has move the tool over the workpiece.
///
/// # Errors
/// A message that names the first that does not, and the two links, one of which is then another.
pub(super) fn check_axes(machine: &Machine, tip: &TipControl, position: &Position) -> Result<(), String> {
    let Some(axis) = tip.idle_axis(machine, position) else { return Ok(()) };
    let [tool, work] = [tip.tool_link, tip.work_link].map(|link| link_name(machine, link));
    Err(format!(
        "axis {} does not move the tool over the workpiece: {tool} is said to carry the tool, and {work} the workpiece; name the links that do: `tool_link` and `work_link` of `[program.tool_centre_point]`, or, for tools that the scene does not have, --spindle LINK@X,Y,Z and --table LINK",
        axis.letter()
    ))
}

/// A link in messages; `None` is the world.
pub(super) fn link_name(machine: &Machine, link: Option<usize>) -> String {
    link.map_or_else(|| "the world".to_owned(), |link| format!("link `{}`", machine.links()[link].name))
}

/// Mounts a tool in the spindle. A tool without a given offset gets its length along its axis as the offset.
///
/// # Errors
/// A message when an axis does not move the tool over the workpiece, or a dimension is missing or makes no solid.
pub(super) fn mount(
    entry: &ToolEntry,
    assembly: &Assembly,
    machine: &Machine,
    tip: &TipControl,
) -> Result<Mounted, String> {
    let number = entry.number;
    check_axes(machine, tip, &Position::default())?;
    let up = up_by_axes(machine, tip);
    let needs_up = !entry.has_offset || assembly.stickout_mm.is_none();
    let up = if needs_up { Some(up?) } else { up.ok() };
    let tabled = up.filter(|_| entry.has_offset).map(|up| along(&up, &entry.tool));
    let stickout = assembly.stickout_mm(tabled)?;
    let length_mm = stickout + assembly.holder_mm();
    let mut tool = entry.tool;
    if let (false, Some(up)) = (entry.has_offset, up) {
        set_length(&mut tool, &up, length_mm);
    }
    let parts = assembly.solids(stickout).into_iter().map(|(role, shape)| {
        let mesh = shape.mesh(&TESSELLATION).map_err(|error| format!("the {}: {error}", role.name()))?;
        Ok(Part {
            name: format!("tool-{number}-{}", role.name()),
            mesh: Arc::new(mesh),
            link: tip.tool_link,
            link_from_part: link_from_tool(tip, length_mm),
            shape: Some(Arc::new(shape)),
            role,
            tool: Some(number),
            groove_mm: 0.0,
            turns: None,
        })
    });
    let parts = parts.collect::<Result<Vec<_>, String>>()?;
    let bare_mm = assembly.holder.is_empty().then_some(stickout);
    let names = parts.iter().map(|part| part.name.clone()).collect();
    let (diameter_mm, has_offset) = (assembly.diameter_mm, entry.has_offset);
    let drawn = DrawnTool { number, length_mm, diameter_mm, up, bare_mm, has_offset, parts: names };
    Ok(Mounted { parts, tool, drawn })
}
