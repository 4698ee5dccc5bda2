//! Sets a scene up for a job without editing its file: the links of spindle and table, tools in the spindle, and stock on the table.

use super::assembly::{self, ToolEntry};
use super::error::SceneError;
use super::file::LibraryFile;
use super::load::{Document, NO_SPINDLE, movable_pairs};
use super::parts::push_part;
use super::stock_spec::StockSpec;
pub use super::stock_spec::numbers;
use super::{Pair, Part, ProgramRun, Role, Scene};
use crate::geometry::{Isometry, Point, Vector};
use crate::machine::tip::TipControl;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use rs274::file::LARGEST_PROGRAM;
use rs274::{Position, Tool};
use std::collections::BTreeMap;
use std::path::Path;

/// Permitted deviation of the axes' directions from a right-handed frame.
pub(super) const SKEW: f64 = 1e-6;

/// Additions that a job makes to a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetUp {
    /// The link that carries tools, and the tip of a tool of length zero in its frame: `LINK@X,Y,Z`, or `LINK` where the scene says it.
    pub spindle: Option<String>,
    /// The link that carries the workpiece.
    pub table: Option<String>,
    /// The control's tool table; its lines take precedence over those of tools, and its offsets over drawn lengths.
    pub measured: BTreeMap<u32, Tool>,
    /// Tools; they replace the scene's tools of the same number.
    pub tools: Vec<ToolEntry>,
    /// The workpiece before the first cut; it replaces that of the scene.
    pub stock: Option<StockSpec>,
}

impl SetUp {
    /// Whether the job adds nothing.
    pub fn is_empty(&self) -> bool {
        self == &Self::default()
    }
}

impl ToolEntry {
    /// Reads a tool library: a TOML file with `[[tools]]`, each as in a scene's `[program]`.
    ///
    /// # Errors
    /// When the file cannot be read, or with file, line and column of the first error in it.
    pub fn library(path: &Path) -> Result<Vec<Self>, SceneError> {
        let text = rs274::file::text(path, LARGEST_PROGRAM);
        let text = text.map_err(|cause| SceneError::Read { file: path.to_owned(), cause })?;
        let document = Document::alone(path.to_owned(), text);
        let file: LibraryFile = document.parse()?;
        let tools = super::program::tools(&file.tools).map_err(|wrong| document.meaning(wrong))?;
        for (i, entry) in tools.iter().enumerate() {
            if tools[..i].iter().any(|earlier| earlier.number == entry.number) {
                let message = format!("there are two tools with number {}", entry.number);
                return Err(document.meaning((file.tools[i].span(), message)));
            }
        }
        Ok(tools)
    }
}

impl Scene {
    /// Adds the job to the scene and to the controller's state; the program must be interpreted again afterwards. Returns warnings for the
    /// reader; those about the tools themselves are [`Scene::tool_notes`].
    ///
    /// # Errors
    /// A message that names the option or the tool.
    pub fn set_up(&mut self, run: &mut ProgramRun, job: &SetUp) -> Result<Vec<String>, String> {
        let mut notes = Vec::new();
        let before = run.tip.clone();
        self.place_spindle(run, job)?;
        for (&number, &tool) in &job.measured {
            run.setup.tools.insert(number, tool);
        }
        for entry in &job.tools {
            let wrong = |message: String| format!("tool {}: {message}", entry.number);
            notes.extend(self.mount(run, entry, &job.measured).map_err(wrong)?);
        }
        notes.extend(self.left_behind(before.as_ref(), run.tip.as_ref()));
        if let ([only], 0) = (&job.tools[..], run.setup.tool) {
            run.setup.tool = only.number;
            notes.push(format!("tool {} is in the spindle at first", only.number));
        }
        if let Some(stock) = &job.stock {
            notes.extend(self.place_stock(run, stock).map_err(|message| format!("--stock: {message}"))?);
        }
        if !self.names_pairs {
            self.pairs = movable_pairs(&self.machine, &self.parts, self.recording.is_some());
        }
        Ok(notes)
    }

    /// Applies `--spindle` and `--table`, and moves the drawn tools that the job does not replace.
    fn place_spindle(&mut self, run: &mut ProgramRun, job: &SetUp) -> Result<(), String> {
        if job.spindle.is_none() && job.table.is_none() {
            return Ok(());
        }
        let work_link = self.link_of(Role::Workpiece).or_else(|| self.link_of(Role::Fixture));
        let mut tip = run.tip.clone().unwrap_or_else(|| TipControl {
            tool_link: None,
            gauge: Point::origin(),
            direction: -Vector::z_axis(),
            work_link: work_link.unwrap_or_default(),
        });
        if let Some(spindle) = &job.spindle {
            self.hold_tools(&mut tip, spindle, run.tip.is_some())?;
        } else if run.tip.is_none() {
            return Err("--table needs --spindle LINK@X,Y,Z, as the scene does not say where tools are held".to_owned());
        }
        if let Some(table) = &job.table {
            tip.work_link = self.named_link("--table", table)?;
        } else if run.tip.is_none() && work_link.is_none() {
            let why = "--spindle needs --table LINK, as the scene has no workpiece or fixture that says what carries the work; `--table world` where it stands still";
            return Err(why.to_owned());
        }
        tip.check(&self.machine).map_err(|why| format!("--spindle and --table: {why}"))?;
        let replaced = |number: u32| job.tools.iter().any(|entry| entry.number == number);
        for drawn in self.drawn_tools.iter_mut().filter(|drawn| !replaced(drawn.number)) {
            let number = drawn.number;
            let tool = run.setup.tools.get_mut(&number).filter(|_| !job.measured.contains_key(&number));
            let moved = drawn.mount_again(&self.machine, &tip, &mut self.parts, tool);
            moved.map_err(|why| format!("--spindle and --table: tool {number} of the scene: {why}"))?;
        }
        run.setup.kinematics = Some(tip.kinematics(&self.machine));
        run.tip = Some(tip);
        Ok(())
    }

    /// Applies `--spindle` to the place that holds tools. With `is_known`, the scene says where that is: its gauge holds for its link, and its
    /// direction towards the tip, at zero, for all links.
    fn hold_tools(&self, tip: &mut TipControl, spindle: &str, is_known: bool) -> Result<(), String> {
        let (name, gauge) = spindle.split_once('@').map_or((spindle, None), |(name, gauge)| (name, Some(gauge)));
        let link = self.named_link("--spindle", name)?;
        let is_same = is_known && link == tip.tool_link;
        if let Some(gauge) = gauge {
            tip.gauge = Point::from(numbers::<3>(gauge).map_err(|why| format!("--spindle: {why}, as in head@0,0,0"))?);
        } else if !is_same {
            let why = "the scene does not say where the tip of a tool of no length is in this link";
            return Err(format!("--spindle {name}: {why}; give it as in {name}@0,0,0"));
        }
        if is_known && !is_same {
            let at_zero = self.machine.forward(&Position::default());
            let turn = at_zero.world_from(link).rotation.inverse() * at_zero.world_from(tip.tool_link).rotation;
            tip.direction = turn * tip.direction;
        }
        tip.tool_link = link;
        Ok(())
    }

    /// A note on the tools that stay on the link from which `--spindle` moves those drawn by their measures.
    fn left_behind(&self, before: Option<&TipControl>, now: Option<&TipControl>) -> Option<String> {
        let (before, now) = before.zip(now)?;
        let place = |tip: &TipControl| (tip.tool_link, tip.gauge, tip.direction);
        if place(before) == place(now) {
            return None;
        }
        let is_left = |part: &&Part| {
            let is_of_tool = part.tool.is_some() || part.role.is_of_tool();
            is_of_tool && part.link == before.tool_link && !self.drawn_tools.iter().any(|drawn| drawn.has(part))
        };
        let left: Vec<&str> = self.parts.iter().filter(is_left).map(|part| part.name.as_str()).collect();
        let why = "stay where they are drawn: `--spindle` moves only tools by their measures";
        (!left.is_empty()).then(|| format!("`{}` {why}", left.join("`, `")))
    }

    /// The link that an option names; `None` is the world.
    fn named_link(&self, option: &str, name: &str) -> Result<Option<usize>, String> {
        let known = || self.machine.links().iter().map(|link| link.name.as_str()).collect::<Vec<_>>().join(", ");
        match self.machine.link(name) {
            None if name == "world" => Ok(None),
            None => Err(format!("{option}: there is no link named `{name}`; there are {}, and world", known())),
            link => Ok(link),
        }
    }

    /// The link of the first part with the role.
    fn link_of(&self, role: Role) -> Option<Option<usize>> {
        self.parts.iter().find(|part| part.role == role).map(|part| part.link)
    }

    /// Adds a tool to the table and, if it has a shape, to the scene, in place of what the scene has of its number.
    fn mount(
        &mut self,
        run: &mut ProgramRun,
        entry: &ToolEntry,
        measured: &BTreeMap<u32, Tool>,
    ) -> Result<Option<String>, String> {
        let mut entry = entry.clone();
        if let Some(tool) = measured.get(&entry.number) {
            entry.tool = *tool;
            entry.has_offset = true;
        }
        let mounted = match &entry.assembly {
            Some(assembly) => {
                let tip = run.tip.as_ref().ok_or(NO_SPINDLE)?;
                Some(assembly::mount(&entry, assembly, &self.machine, tip)?)
            }
            None => None,
        };
        let is_drawn = mounted.is_some();
        let gone = self.retain_parts(|part| match part.tool {
            Some(number) => number != entry.number,
            None => !(is_drawn && part.role.is_of_tool()),
        });
        self.drawn_tools.retain(|drawn| drawn.number != entry.number);
        let mut tool = entry.tool;
        if let Some(mounted) = mounted {
            for part in mounted.parts {
                push_part(&mut self.parts, part).map_err(|why| why.to_string())?;
            }
            tool = mounted.tool;
            self.drawn_tools.push(mounted.drawn);
        }
        run.setup.tools.insert(entry.number, tool);
        if gone.is_empty() {
            return Ok(None);
        }
        self.lost_tools |= !is_drawn;
        let shape = if is_drawn { "" } else { ", and has no shape: it is not examined" };
        Ok(Some(format!("tool {} replaces `{}` of the scene{shape}", entry.number, gone.join("`, `"))))
    }

    /// Replaces the workpiece by stock.
    fn place_stock(&mut self, run: &ProgramRun, stock: &StockSpec) -> Result<Vec<String>, String> {
        let (link, link_from_work) = self.work_frame(run)?;
        let (part, place) = stock.part(link, &link_from_work)?;
        let gone = self.retain_parts(|part| part.role != Role::Workpiece);
        push_part(&mut self.parts, part).map_err(|why| why.to_string())?;
        let mut notes = vec![format!("the stock is at {place}, on {}", assembly::link_name(&self.machine, link))];
        if !gone.is_empty() {
            notes.push(format!("the stock replaces `{}` of the scene", gone.join("`, `")));
        }
        if self.gouge_mm.take().is_some() {
            notes.push("`gouge_mm` of the scene is about the finished part, and does not hold for stock".to_owned());
        }
        Ok(notes)
    }

    /// The link that carries the workpiece, and the frame of G54 on that link. The origin is the tip of a tool of length zero at the origin
    /// of G54. The axes are the directions in which X, Y and Z move that tip over the workpiece.
    fn work_frame(&self, run: &ProgramRun) -> Result<(Option<usize>, Isometry), String> {
        let tip = run.tip.as_ref().ok_or(
            "nothing says where tool and workpiece are: give `[program.tool_centre_point]` in scene.toml, or `--spindle LINK@X,Y,Z --table LINK`",
        )?;
        let origin = run.setup.work_offsets[0].origin;
        let at = tip.tip(&self.machine, &origin, 0.0);
        assembly::check_axes(&self.machine, tip, &origin)?;
        // A lathe has no Y; the other two say where it would go.
        let matrix = Matrix3::from_columns(&tip.directions(&self.machine, &origin));
        if (matrix.transpose() * matrix - Matrix3::identity()).amax() > SKEW || matrix.determinant() < 0.0 {
            let why = "X, Y and Z do not move the tool over the workpiece along three directions of a right-handed frame; make the stock a part of scene.toml";
            return Err(why.to_owned());
        }
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
        Ok((tip.work_link, Isometry::from_parts(Translation3::from(at.coords), turn)))
    }

    /// Keeps the parts for which `is_kept` holds, and the pairs between them. Returns the names of the removed parts.
    fn retain_parts(&mut self, is_kept: impl Fn(&Part) -> bool) -> Vec<String> {
        let mut gone = Vec::new();
        let mut kept = Vec::with_capacity(self.parts.len());
        let mut place: Vec<Option<usize>> = Vec::with_capacity(self.parts.len());
        for part in std::mem::take(&mut self.parts) {
            if is_kept(&part) {
                place.push(Some(kept.len()));
                kept.push(part);
            } else {
                place.push(None);
                gone.push(part.name);
            }
        }
        self.parts = kept;
        if gone.is_empty() {
            return gone;
        }
        let moved = |pair: &Pair| Some(Pair { a: place[pair.a]?, b: place[pair.b]? });
        for pairs in [&mut self.pairs, &mut self.ignored, &mut self.allowed, &mut self.random] {
            *pairs = pairs.iter().filter_map(moved).collect();
        }
        self.expected.retain_mut(|expected| {
            moved(&expected.pair).is_some_and(|pair| {
                expected.pair = pair;
                true
            })
        });
        self.approaches.retain_mut(|approach| {
            moved(&approach.pair).is_some_and(|pair| {
                approach.pair = pair;
                true
            })
        });
        self.mesh_files.retain(|file| !gone.contains(&file.part));
        gone
    }
}
