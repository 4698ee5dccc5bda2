//! Writes a commented scene file for a new machine, given which axes carry the workpiece and which carry the tool.
//!
//! A machine is a chain from the workpiece `w` over the base `b` to the tool `t`, in the notation of machine builders. In `w X Y b Z t`,
//! the table moves along X on a saddle that moves along Y, and the head moves along Z. Axes between workpiece and base move in the opposite
//! direction, so that a positive move takes the tool to larger coordinates on the workpiece (ISO 841).

use super::Role;
use crate::geometry::import::Unit;
use rs274::Axis;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Name of the lathe's template; with a colon, the prefix that marks a written chain as a lathe's.
const LATHE: &str = "lathe";

/// Distance by which the first program moves each axis, mm and degrees.
const JOG: f64 = 10.0;
/// Feed rate of the first program, mm/min and degrees/min.
const JOG_FEED: f64 = 1000.0;

/// A kind of machine by name.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    /// Name of the template on the command line.
    pub name: &'static str,
    /// One line on the kind of machine.
    pub about: &'static str,
    /// The axes, from the workpiece to the tool.
    pub chain: &'static str,
}

/// The kinds of machines that have names.
pub const TEMPLATES: [Template; 8] = [
    Template { name: "mill", about: "3-axis mill: table in X and Y, head in Z", chain: "w X Y b Z t" },
    Template { name: "router", about: "gantry router: the work stands still", chain: "w b Y X Z t" },
    Template { name: "horizontal", about: "horizontal mill with a rotary table B", chain: "w B X b Y Z t" },
    Template { name: "rotary", about: "4-axis mill: rotary axis A on the table", chain: "w A X Y b Z t" },
    Template { name: "trunnion", about: "5-axis mill: table turns about C on a trunnion A", chain: "w C A Y b X Z t" },
    Template {
        name: "head-table",
        about: "5-axis mill: head tilts about B, table turns about C",
        chain: "w C X b Y Z B t",
    },
    Template {
        name: "fork",
        about: "5-axis gantry: fork head turns about C and tilts about A",
        chain: "w b X Y Z C A t",
    },
    Template { name: LATHE, about: "lathe: spindle C, turret in Z and X", chain: "w C b Z X t" },
];

/// The axes that carry the workpiece and those that carry the tool, each listed from the base outwards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    work: Vec<Axis>,
    tool: Vec<Axis>,
    /// Whether the machine is a lathe: its programs begin in G18.
    is_lathe: bool,
}

impl Chain {
    /// Finds a template's chain by its name, or parses a written chain. A written chain is a lathe's if `lathe:` stands before it, or if it
    /// equals the chain of the lathe's template.
    ///
    /// # Errors
    /// A message that lists the templates.
    pub fn find(text: &str) -> Result<Self, String> {
        let lathe = text.strip_prefix(LATHE).and_then(|rest| rest.trim_start().strip_prefix(':'));
        let named = TEMPLATES.iter().find(|template| template.name == text);
        let chain = Self::parse(named.map_or(lathe.unwrap_or(text), |template| template.chain));
        let chain = chain.map_err(|why| {
            let names: Vec<&str> = TEMPLATES.iter().map(|template| template.name).collect();
            format!(
                "`{text}` is neither one of {} nor a chain such as \"w X Y b Z t\" or \"lathe: w C b Z X Y t\": {why}",
                names.join(", ")
            )
        })?;
        let is_template =
            || TEMPLATES.iter().any(|of| of.name == LATHE && Self::parse(of.chain).as_ref() == Ok(&chain));
        let is_lathe = lathe.is_some() || is_template();
        Ok(Self { is_lathe, ..chain })
    }

    fn parse(text: &str) -> Result<Self, String> {
        let letters: Vec<char> = text.chars().filter(|c| !c.is_whitespace() && *c != '-').collect();
        let ['w', inner @ .., 't'] = letters.as_slice() else {
            return Err("it must begin with w (work) and end with t (tool)".to_owned());
        };
        let base = inner.iter().position(|&c| c == 'b').ok_or("it has no b (base)")?;
        let axes = |letters: &[char]| -> Result<Vec<Axis>, String> {
            let axis = |&c: &char| Axis::from_letter(c).filter(|_| c.is_ascii_uppercase());
            letters.iter().map(|c| axis(c).ok_or_else(|| format!("`{c}` is not an axis (X Y Z A B C U V W)"))).collect()
        };
        let (mut work, tool) = (axes(&inner[..base])?, axes(&inner[base + 1..])?);
        work.reverse();
        let chain = Self { work, tool, is_lathe: false };
        let all = chain.axes();
        if let Some(twice) = all.iter().enumerate().find_map(|(i, axis)| all[..i].contains(axis).then_some(axis)) {
            return Err(format!("{} occurs twice", twice.letter()));
        }
        if all.is_empty() {
            return Err("it has no axis".to_owned());
        }
        Ok(chain)
    }

    /// All axes, those of the workpiece first.
    pub fn axes(&self) -> Vec<Axis> {
        self.work.iter().chain(&self.tool).copied().collect()
    }

    /// The default link for a part of a role: an axis letter, or `base`. `None` for machine parts.
    pub fn link_of(&self, role: Role) -> Option<String> {
        let last = |axes: &[Axis]| axes.last().map_or_else(|| BASE.to_owned(), |axis| axis.letter().to_string());
        match role {
            Role::Machine => None,
            Role::Workpiece | Role::Fixture => Some(last(&self.work)),
            Role::Cutter | Role::Shank | Role::Holder => Some(last(&self.tool)),
        }
    }

    /// The names of all links, `base` first.
    pub fn links(&self) -> Vec<String> {
        let letters = self.axes().into_iter().map(|axis| axis.letter().to_string());
        std::iter::once(BASE.to_owned()).chain(letters).collect()
    }
}

/// Name of the link that does not move.
pub const BASE: &str = "base";

/// A part of a new scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewPart {
    /// Name.
    pub name: String,
    /// Mesh file, relative to the scene's folder.
    pub file: String,
    /// Role of the part.
    pub role: Role,
    /// The link it is fixed to: the letter of an axis, or [`BASE`].
    pub link: String,
}

/// A new scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NewScene {
    /// One line on what the scene shows.
    pub title: String,
    /// The machine's axes.
    pub chain: Chain,
    /// Position of the tip of a tool of length zero, in the drawing with all axes at zero, mm.
    pub gauge_mm: [f64; 3],
    /// A point on the line of each rotary axis, in the same drawing, mm.
    pub pivots_mm: BTreeMap<char, [f64; 3]>,
    /// Limits, mm and degrees.
    pub limits: BTreeMap<char, [f64; 2]>,
    /// The parts.
    pub parts: Vec<NewPart>,
    /// The unit of all mesh files; `None` for that of their formats.
    pub unit: Option<Unit>,
    /// The program's file, relative to the scene's folder.
    pub program: String,
}

impl NewScene {
    /// The scene file.
    pub fn toml(&self) -> String {
        let mut text = format!(
            "# A machine for `bvbench check` and `bvbench view`; docs/format.md of bvbench describes every key. Lengths are mm, angles degrees.\n\
             # All mesh files share one frame: the drawing of the machine with every axis at zero.\n\
             title = {}\n\n\
             # The axes. A direction says where the link goes when its axis goes up: table axes go the other way, so that the tool moves over the\n\
             # work in the positive direction. `bvbench view FOLDER` plays a program that moves each axis; turn a direction round where one goes wrong.\n",
            quoted(&self.title)
        );
        for (carried, axes) in [("work", &self.chain.work), ("tool", &self.chain.tool)] {
            let mut parent = None;
            for &axis in axes {
                self.link(&mut text, axis, parent, carried);
                parent = Some(axis);
            }
        }
        text += "\n# The parts. Roles: machine (the default), workpiece, fixture, cutter, shank, holder. Only a cutter may touch the workpiece, in a feed move.\n\
                 # A part of tool 3 alone has `tool = 3`. `at = { xyz_mm = [0, 0, 0], rpy_deg = [0, 0, 0] }` moves a part that was drawn elsewhere.\n";
        for part in &self.parts {
            self.part(&mut text, part);
        }
        self.program(&mut text);
        text += "\n[check]\n\
                 # ignore = [[\"hose\", \"column\"]]      # pairs that are never examined\n\
                 # allow = [[\"vise\", \"table\"]]        # pairs that touch because they are built so\n\
                 # clearance = [\"5\", \"holder:fixture=10\"] # told when pairs come nearer, mm: all, and by part or role\n\
                 # rapid_mm_min = 15000                 # rapid rates; rapid_rates = { Z = 10000 } for single axes\n\
                 # rapid = \"dog-leg\"                    # every axis at its own rate, not along a straight line\n";
        text
    }

    fn link(&self, text: &mut String, axis: Axis, parent: Option<Axis>, carried: &str) {
        let letter = axis.letter();
        let sign = if carried == "work" { -1 } else { 1 };
        let mut direction = [0; 3];
        direction[axis as usize % 3] = sign;
        let mut joint = format!("axis = \"{letter}\", direction = {direction:?}");
        if axis.is_rotary() {
            let _ = write!(joint, ", point_mm = {:?}", self.pivots_mm.get(&letter).unwrap_or(&[0.0; 3]));
        }
        let unit = if axis.is_rotary() { "deg" } else { "mm" };
        let limits = match self.limits.get(&letter) {
            Some([min, max]) => {
                let _ = write!(joint, ", min_{unit} = {min:?}, max_{unit} = {max:?}");
                String::new()
            }
            None => format!(" # without limits; min_{unit} and max_{unit} set them"),
        };
        let _ = writeln!(text, "\n[[machine.links]]\nname = \"{letter}\" # carries the {carried}");
        if let Some(parent) = parent {
            let _ = writeln!(text, "parent = \"{}\"", parent.letter());
        }
        let _ = writeln!(text, "joint = {{ {joint} }}{limits}");
    }

    fn part(&self, text: &mut String, part: &NewPart) {
        let _ = writeln!(text, "\n[[parts]]\nname = {}\nmesh = {}", quoted(&part.name), quoted(&part.file));
        if part.role != Role::Machine {
            let _ = writeln!(text, "role = \"{}\"", part.role.name());
        }
        if part.link != BASE {
            let _ = writeln!(text, "link = {}", quoted(&part.link));
        }
        let unit = match self.unit {
            None => return,
            Some(Unit::Mm) => "mm",
            Some(Unit::Cm) => "cm",
            Some(Unit::M) => "m",
            Some(Unit::Inch) => "inch",
        };
        let _ = writeln!(text, "unit = \"{unit}\"");
    }

    fn program(&self, text: &mut String) {
        let link = |role| self.chain.link_of(role).filter(|link| link != BASE).unwrap_or_else(|| "world".to_owned());
        let _ = write!(
            text,
            "\n[program]\nfile = {} # `bvbench check FOLDER other.ngc` runs another one\n",
            quoted(&self.program)
        );
        *text += if self.chain.is_lathe {
            "controller = \"lathe\" # G18; X words are diameters of Fanuc's and Haas's controls, of LinuxCNC's under G7\n"
        } else {
            "# controller = \"lathe\" # for a lathe: programs begin in G18, and the workpiece turns\n"
        };
        *text += "# dialect = \"fanuc\" # or \"haas\", \"grbl\"; without it, LinuxCNC's\n\
                  # units = \"inch\" # of programs before any G20 or G21; without it, mm with a note\n";
        let start: Vec<String> = self.starts().into_iter().map(|(key, value)| format!("{key} = {value:?}")).collect();
        let (off, at) = if start.is_empty() { ("# ", "z_mm = 300".to_owned()) } else { ("", start.join(", ")) };
        for (key, why) in [("start", "where the axes stand at first"), ("home", "where G28 goes")] {
            let _ = writeln!(text, "{off}{key} = {{ {at} }} # {why}, machine coordinates");
        }
        *text += "# work_offsets = { G54 = { x_mm = 0, y_mm = 0, z_mm = 0 } } # machine coordinates; `--offset G54=X,Y,Z` for a single run\n\
                  # tool_change = { Z = 0 } # where M6 changes tools; without it, where the machine stands\n";
        *text += if self.chain.is_lathe {
            "# tools = [{ number = 1 }] # turning tools, which are drawn as parts with `tool = 1`\n"
        } else {
            "# tools = [{ number = 1, diameter_mm = 10, flute_mm = 22, stickout_mm = 40, holder = [{ diameter_mm = 32, length_mm = 60 }] }]\n"
        };
        let _ = writeln!(
            text,
            "\n# Where the spindle holds tools and what carries the work: for `--tool`, `--stock` and five axes.\n[program.tool_centre_point]\n\
             tool_link = \"{}\"\ngauge_mm = {:?} # the tip of a tool of no length\ndirection = [0, 0, -1] # towards the tip\nwork_link = \"{}\"",
            link(Role::Cutter),
            self.gauge_mm,
            link(Role::Workpiece),
        );
    }

    /// Axes that cannot be at zero, by their keys in files, each with its initial position.
    fn starts(&self) -> Vec<(String, f64)> {
        let standing = self.chain.axes().into_iter().map(|axis| (axis, self.start(axis)));
        let key = |axis: Axis| {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            format!("{}_{unit}", axis.letter().to_ascii_lowercase())
        };
        standing.filter(|(_, at)| *at != 0.0).map(|(axis, at)| (key(axis), at)).collect()
    }

    /// Initial position of an axis: zero, or as near to it as the limits permit.
    fn start(&self, axis: Axis) -> f64 {
        self.limits.get(&axis.letter()).map_or(0.0, |[min, max]| 0.0_f64.clamp(*min, *max))
    }

    /// A program that moves each axis a little and back, to check the direction of each.
    pub fn jog(&self) -> String {
        // Programs of lathes give diameters.
        let diameters = if self.chain.is_lathe { " G7" } else { "" };
        let mut text =
            format!("(moves each axis up and back: does it go the right way?)\nG21{diameters} G90 G94 G53 G0");
        let factor = |axis: Axis| if self.chain.is_lathe && axis == Axis::X { 2.0 } else { 1.0 };
        let word = |axis: Axis, at: f64| format!(" {}{}", axis.letter(), at * factor(axis));
        for axis in self.chain.axes() {
            text += &word(axis, self.start(axis));
        }
        let _ = write!(text, "\nF{JOG_FEED}\n");
        for axis in self.chain.axes() {
            let from = self.start(axis);
            let [min, max] = self.limits.get(&axis.letter()).copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let to = if max - from >= JOG.min(from - min) { (from + JOG).min(max) } else { (from - JOG).max(min) };
            let _ = writeln!(text, "G1{}\nG1{}", word(axis, to), word(axis, from));
        }
        text + "M2\n"
    }
}

/// A TOML string.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_are_read_from_the_work_to_the_tool() {
        let chain = Chain::find("trunnion").unwrap();
        assert_eq!((&chain.work[..], &chain.tool[..]), (&[Axis::Y, Axis::A, Axis::C][..], &[Axis::X, Axis::Z][..]));
        assert_eq!(Chain::find("wCAYbXZt").unwrap(), chain);
        let links = [Role::Workpiece, Role::Holder, Role::Machine].map(|role| chain.link_of(role));
        assert_eq!(links, [Some("C".to_owned()), Some("Z".to_owned()), None]);
        for (wrong, why) in [
            ("mil", "neither one of mill"),
            ("w X b Q t", "`Q` is not an axis"),
            ("w X Z t", "no b"),
            ("w X b X t", "X occurs twice"),
            ("w b t", "no axis"),
            ("lathe:", "it must begin with w"),
            ("lathes: w C b Z X t", "neither one of mill"),
        ] {
            let error = Chain::find(wrong).unwrap_err();
            assert!(error.contains(why), "{error}");
        }
        assert!(TEMPLATES.iter().all(|template| Chain::find(template.name).is_ok()));
        for (text, is_lathe) in [
            ("lathe", true),
            ("w C b Z X t", true),
            ("lathe: w C b Z X Y t", true),
            ("lathe:wCbZXYt", true),
            ("w C b Z X Y t", false),
            ("rotary", false),
        ] {
            assert_eq!(Chain::find(text).unwrap().is_lathe, is_lathe, "{text}");
        }
    }

    #[test]
    fn the_first_program_stays_within_limits() {
        let limits = BTreeMap::from([('X', [-5.0, 4.0]), ('Z', [20.0, 300.0])]);
        let scene = NewScene {
            title: "a \"machine\"".to_owned(),
            chain: Chain::find("mill").unwrap(),
            gauge_mm: [0.0; 3],
            pivots_mm: BTreeMap::new(),
            limits,
            parts: Vec::new(),
            unit: None,
            program: "jog.ngc".to_owned(),
        };
        let jog = scene.jog();
        assert!(
            jog.contains("G53 G0 Y0 X0 Z20\n") && jog.contains("G1 X-5\nG1 X0\n") && jog.contains("G1 Z30\n"),
            "{jog}"
        );
        assert!(scene.toml().contains("\n# tools = [{ number = 1, diameter_mm"));
        let lathe = NewScene { chain: Chain::find("lathe").unwrap(), limits: BTreeMap::new(), ..scene.clone() };
        assert!(lathe.toml().contains("\n# tools = [{ number = 1 }]"));
        for key in ["start", "home"] {
            assert!(scene.toml().contains(&format!("\n{key} = {{ z_mm = 20.0 }}")), "{key}");
        }
    }

    #[test]
    fn a_unit_is_written_where_it_is_given() {
        let part =
            NewPart { name: "a".to_owned(), file: "a.glb".to_owned(), role: Role::Fixture, link: "X".to_owned() };
        let scene = |unit| NewScene {
            title: String::new(),
            chain: Chain::find("mill").unwrap(),
            gauge_mm: [0.0; 3],
            pivots_mm: BTreeMap::new(),
            limits: BTreeMap::new(),
            parts: vec![part.clone()],
            unit,
            program: "jog.ngc".to_owned(),
        };
        // A GLB file is in metres unless the scene says otherwise.
        assert!(scene(Some(Unit::Mm)).toml().contains("unit = \"mm\""));
        assert!(!scene(None).toml().contains("unit ="));
    }
}
