//! Loads `scene.toml` into a checked [`Scene`].

use super::assembly;
use super::error::{Place, SceneError};
use super::file::{
    ApproachFile, CheckFile, MachineFile, PartFile, ProgramFile, RapidFile, SceneFile, SharedMachineFile, TipFile,
};
use super::folder::Folder;
use super::numbers;
use super::parts::{admit, push_part};
use super::program::{self, Nonsense, ProgramRun, positive};
use super::{
    Approach, Clearance, Clearances, DrawnTool, Expected, MeshFile, Overrides, Pair, Part, Rates, Recording, Role,
    Scene, Turns, recording,
};
use crate::geometry::shapes::Tessellation;
use crate::geometry::{self, Mesh, Point, Vector, import};
use crate::machine::file::{Form, LinkFile};
use crate::machine::tip::TipControl;
use crate::machine::{self, Machine};
use rs274::{Axis, Position, RapidPath, Setup};
use serde::de::DeserializeOwned;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;
use toml::de::DeTable;

/// Message for a tool with a shape in a scene that does not define where the spindle holds tools.
pub(super) const NO_SPINDLE: &str = "it has a shape, and nothing says where the spindle holds tools: give `[program.tool_centre_point]` in scene.toml (`tool_link`, `gauge_mm`), or `--spindle LINK@X,Y,Z`";

/// Name of the file that makes a folder a scene.
pub const SCENE_FILE: &str = "scene.toml";

/// Rapid rates when the scene defines none: those of an ordinary machine tool.
const RAPID_MM_MIN: f64 = 15_000.0;
const RAPID_DEG_MIN: f64 = 7_200.0;

/// A text, and its name in messages.
pub(super) struct Document {
    path: PathBuf,
    pub(super) text: String,
    /// Folder of the file relative to the scene's, `""` or ending in `/`.
    pub(super) base: String,
}

impl Document {
    pub(super) fn read(folder: &mut Folder, relative: &str) -> Result<Self, SceneError> {
        let text = folder.text(relative)?;
        let base = relative.rfind('/').map_or("", |slash| &relative[..=slash]);
        Ok(Self { path: folder.path(relative), text, base: base.to_owned() })
    }

    /// A text that does not belong to a scene.
    pub(super) const fn alone(path: PathBuf, text: String) -> Self {
        Self { path, text, base: String::new() }
    }

    pub(super) fn parse<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        let syntax = |error: toml::de::Error| self.place(&error.span().unwrap_or(0..0)).error(error.message());
        let parsed = toml::from_str(&self.text).map_err(syntax)?;
        match numbers::too_large(DeTable::parse(&self.text).map_err(syntax)?.get_ref()) {
            Some(wrong) => Err(self.meaning(wrong)),
            None => Ok(parsed),
        }
    }

    pub(super) fn place(&self, span: &Range<usize>) -> Place {
        Place::of_byte(self.path.clone(), &self.text, span.start)
    }

    pub(super) fn meaning(&self, (span, message): Nonsense) -> SceneError {
        self.place(&span).error(message)
    }

    /// Adds the place where the document names a file to the error that the file cannot be read.
    pub(super) fn naming(&self, file: &Spanned<String>) -> impl FnOnce(SceneError) -> SceneError {
        |error| if matches!(error, SceneError::Read { .. }) { self.place(&file.span()).error(error) } else { error }
    }

    /// The place of a table's header, for entries without a span of their own.
    fn header(&self, header: &str) -> Place {
        Place::of_byte(self.path.clone(), &self.text, self.text.find(header).unwrap_or(0))
    }
}

/// The scene's own file. One whose name does not end in `.toml` may be a program or a mesh in the place of the scene, which the error says first.
fn read_own(folder: &mut Folder, file: &str) -> Result<(Document, SceneFile), SceneError> {
    let read = Document::read(folder, file).and_then(|document| {
        let scene = document.parse::<SceneFile>()?;
        Ok((document, scene))
    });
    let is_toml = Path::new(file).extension().is_some_and(|kind| kind.eq_ignore_ascii_case("toml"));
    read.map_err(
        |cause| {
            if is_toml { cause } else { SceneError::NoScene { file: folder.path(file), cause: Box::new(cause) } }
        },
    )
}

/// Loads the scene in a folder.
pub fn load(mut folder: Folder, file: &str, overrides: &Overrides) -> Result<Scene, SceneError> {
    let (document, scene) = read_own(&mut folder, file)?;
    let (machine, mut parts) = machine_and_its_parts(&mut folder, &document, &scene.machine, overrides)?;
    add_parts(&mut parts, &mut folder, &document, &scene.parts, &machine, overrides)?;
    if parts.is_empty() {
        return Err(SceneError::NoParts { file: document.path });
    }
    let Programs { first: program, more: more_programs, drawn_tools } =
        read_programs(&mut folder, &document, &scene, &machine, &mut parts, overrides)?;
    let recorded = scene.recorded.as_ref();
    let recording = recorded
        .map(|file| read_recording(&mut folder, &document, &file.file, &machine, &parts, program.as_ref()))
        .transpose()?;
    let meaning = |wrong| document.meaning(wrong);
    let find = |pair: &Spanned<[String; 2]>| find_pair(&document, &parts, pair);
    let find_all = |pairs: &[Spanned<[String; 2]>]| pairs.iter().map(find).collect::<Result<Vec<Pair>, _>>();
    let pairs = match &scene.pairs {
        Some(pairs) => find_all(pairs)?,
        None => movable_pairs(&machine, &parts, recording.is_some()),
    };
    let random = scene.random.as_deref().map_or_else(|| Ok(pairs.clone()), find_all)?;
    let (ignored, allowed) = (find_all(&scene.check.ignore)?, find_all(&scene.check.allow)?);
    let expected = scene.check.expect.iter();
    let expected = expected.map(|file| Ok(Expected { line: file.line, pair: find(&file.pair)? }));
    let expected = expected.collect::<Result<_, SceneError>>()?;
    let rates = read_rates(&scene.check).map_err(meaning)?;
    let gouge_mm = positive("gouge_mm", scene.check.gouge_mm.as_ref()).map_err(meaning)?;
    let clearances = read_clearances(&document, &parts, &scene.check.clearance)?;
    let approaches = read_approaches(&document, &machine, &parts, &scene.approaches)?;
    let name = folder.name().to_owned();
    let (inputs, mut files, mesh_files) = folder.into_records();
    files.extend(program.iter().chain(&more_programs).flat_map(ProgramRun::called_files));
    Ok(Scene {
        name,
        title: scene.title,
        description: scene.description,
        provenance: scene.provenance,
        machine,
        parts,
        pairs,
        names_pairs: scene.pairs.is_some(),
        ignored,
        allowed,
        gouge_mm,
        clearances,
        rates,
        expected,
        program,
        more_programs,
        approaches,
        random,
        recording,
        inputs,
        files,
        drawn_tools,
        lost_tools: false,
        mesh_files,
    })
}

/// The programs of a scene.
#[derive(Default)]
struct Programs {
    first: Option<ProgramRun>,
    more: Vec<ProgramRun>,
    /// Tools of the first that are drawn.
    drawn_tools: Vec<DrawnTool>,
}

/// The scene's program and the further ones; drawn tools are added to the parts.
fn read_programs(
    folder: &mut Folder,
    document: &Document,
    scene: &SceneFile,
    machine: &Machine,
    parts: &mut Vec<Part>,
    overrides: &Overrides,
) -> Result<Programs, SceneError> {
    let Some(file) = &scene.program else { return Ok(Programs::default()) };
    let tip = file.tool_centre_point.as_ref().map(|tip| read_tip(document, machine, tip)).transpose()?;
    let mut setup = read_setup(document, machine, file, tip.as_ref())?;
    let drawn_tools = mount_tools(document, machine, parts, file, tip.as_ref(), &mut setup)?;
    let first = read_program(folder, document, file, &setup, tip, overrides)?;
    let skips_more = overrides.skips_program || overrides.defers_program;
    let more = file.more.iter().filter(|_| !skips_more).map(|path| {
        let source = folder.text(path.get_ref()).map_err(document.naming(path))?;
        let path = path.get_ref();
        program::run(&source, folder.path(path), folder.hash(path), &first.setup, first.tip.clone(), first.sampling)
    });
    let more = more.collect::<Result<Vec<_>, SceneError>>()?;
    Ok(Programs { first: Some(first), more, drawn_tools })
}

/// The machine, from the scene file or from a separate file, and the parts of the separate file.
fn machine_and_its_parts(
    folder: &mut Folder,
    document: &Document,
    file: &MachineFile,
    overrides: &Overrides,
) -> Result<(Machine, Vec<Part>), SceneError> {
    let mut parts = Vec::new();
    let refuse = |message: &str| Err(document.header("[machine]").error(message));
    let of_file = Overrides { density: overrides.density.or(file.density), ..*overrides };
    if let Some(path) = &file.urdf {
        if file.file.is_some() || !file.links.is_empty() {
            return refuse("a machine has a URDF file, a file or links, and only one of them");
        }
        let (machine, mut parts) = read_urdf(folder, document, file, path, &of_file)?;
        add_parts(&mut parts, folder, document, &file.parts, &machine, overrides)?;
        return Ok((machine, parts));
    }
    if !file.axes.is_empty() || file.form != Form::default() {
        return refuse("`axes` and `form` go with `urdf`");
    }
    let Some(path) = &file.file else {
        if file.density.is_some() {
            return refuse("`density` goes with `file` or `urdf`; parts have their own `tessellation`");
        }
        let machine = build_machine(document, &file.links)?;
        add_parts(&mut parts, folder, document, &file.parts, &machine, overrides)?;
        return Ok((machine, parts));
    };
    if !file.links.is_empty() {
        return refuse("a machine has either a file or links");
    }
    let machine_document = Document::read(folder, path.get_ref()).map_err(document.naming(path))?;
    let machine_file: SharedMachineFile = machine_document.parse()?;
    let machine = build_machine(&machine_document, &machine_file.links)?;
    add_parts(&mut parts, folder, &machine_document, &machine_file.parts, &machine, &of_file)?;
    add_parts(&mut parts, folder, document, &file.parts, &machine, overrides)?;
    Ok((machine, parts))
}

#[cfg(feature = "urdf")]
fn read_urdf(
    folder: &mut Folder,
    document: &Document,
    file: &MachineFile,
    path: &Spanned<String>,
    overrides: &Overrides,
) -> Result<(Machine, Vec<Part>), SceneError> {
    super::urdf::read(folder, document, file, path, &overridden(Tessellation::default(), overrides))
}

#[cfg(not(feature = "urdf"))]
fn read_urdf(
    _: &mut Folder,
    document: &Document,
    _: &MachineFile,
    _: &Spanned<String>,
    _: &Overrides,
) -> Result<(Machine, Vec<Part>), SceneError> {
    Err(document.header("[machine]").error("URDF is read only by a build with `--features urdf`"))
}

fn overridden(mut tessellation: Tessellation, overrides: &Overrides) -> Tessellation {
    tessellation.grading = overrides.grading.unwrap_or(tessellation.grading);
    tessellation.density = overrides.density.unwrap_or(tessellation.density);
    tessellation
}

fn build_machine(document: &Document, links: &[LinkFile]) -> Result<Machine, SceneError> {
    machine::file::build(links).map_err(|wrong| document.meaning(wrong))
}

fn add_parts(
    parts: &mut Vec<Part>,
    folder: &mut Folder,
    document: &Document,
    files: &[PartFile],
    machine: &Machine,
    overrides: &Overrides,
) -> Result<(), SceneError> {
    for file in files {
        let name = file.name.get_ref();
        let place = || document.place(&file.name.span());
        admit(parts, name).map_err(|why| why.at(place()))?;
        let link = file.link.as_ref().map(|link| find_link(document, machine, link)).transpose()?;
        let link_from_part = file.at.isometry();
        if !machine::tree::is_usable(&link_from_part) {
            let message = format!("the placement of part `{name}` is not finite, or farther than 1e9 mm");
            return Err(place().error(message));
        }
        if file.tool.is_some() && matches!(file.role, Role::Workpiece | Role::Fixture) {
            let message = format!("part `{name}` belongs to a tool, so it cannot be a {}", file.role.name());
            return Err(place().error(message));
        }
        let groove_mm = file.groove_mm;
        let refused = match file.role {
            _ if !(groove_mm >= 0.0 && groove_mm.is_finite()) => Some("it must be a finite width of at least 0"),
            Role::Cutter => None,
            _ => (groove_mm > 0.0).then_some("only a part with `role = \"cutter\"` has grooves that count"),
        };
        if let Some(why) = refused {
            let message = format!("groove_mm of part `{name}` is {groove_mm}; {why}");
            return Err(place().error(message));
        }
        let refused = match (file.role, file.turns) {
            (Role::Workpiece, Some(_)) => Some("the spindle of a lathe turns every workpiece"),
            (Role::Fixture | Role::Machine, Some(Turns::Own)) => {
                Some("only a cutter, a shank or a holder may say that")
            }
            _ => None,
        };
        if let (Some(why), Some(turns)) = (refused, file.turns) {
            let message = format!("turns of part `{name}` is \"{}\"; {why}", turns.name());
            return Err(place().error(message));
        }
        let mesh = part_mesh(folder, document, file, overrides)?;
        let mesh = Arc::new(mesh);
        let shape = file.shape.clone().map(Arc::new);
        let (name, role, tool, turns) = (name.clone(), file.role, file.tool, file.turns);
        let part = Part { name, mesh, link, link_from_part, shape, role, tool, groove_mm, turns };
        push_part(parts, part).map_err(|why| why.at(place()))?;
    }
    Ok(())
}

/// The mesh of a part, from its shape or its file.
fn part_mesh(
    folder: &mut Folder,
    document: &Document,
    file: &PartFile,
    overrides: &Overrides,
) -> Result<Mesh, SceneError> {
    let place = || document.place(&file.name.span());
    let part = || file.name.get_ref().clone();
    let failed = |cause: Box<dyn Error + Send + Sync>| SceneError::Mesh { place: place(), part: part(), cause };
    let refuse = |message: &str| Err(place().error(format!("part `{}`: {message}", file.name.get_ref())));
    match (&file.shape, &file.mesh) {
        (Some(_), None) if file.unit.is_some() => refuse("a shape is in mm; `unit` goes with `mesh`"),
        (Some(_), None) if file.weld_mm.is_some() => refuse("a shape has no gaps; `weld_mm` goes with `mesh`"),
        (Some(shape), None) => {
            let tessellation = overridden(file.tessellation.unwrap_or_default(), overrides);
            shape.mesh(&tessellation).map_err(|error| failed(error.into()))
        }
        (None, Some(_)) if file.tessellation.is_some() => {
            refuse("a mesh file is triangles already; drop `tessellation`")
        }
        (None, Some(path)) => {
            let path = format!("{}{path}", document.base);
            let options = import::Options { unit: file.unit, weld_mm: file.weld_mm.unwrap_or(0.0) };
            let content = folder.bytes(&path).map_err(|error| failed(error.into()))?;
            let imported = import::parse(&folder.path(&path), &content, options);
            let import::Imported { mesh, report } = imported.map_err(|error| failed(error.into()))?;
            folder.meshes.push(MeshFile { part: file.name.get_ref().clone(), file: path, report });
            Ok(mesh)
        }
        _ => refuse("either `shape` or `mesh` must be given"),
    }
}

fn read_rates(file: &CheckFile) -> Result<Rates, Nonsense> {
    let linear = positive("rapid_mm_min", file.rapid_mm_min.as_ref())?.unwrap_or(RAPID_MM_MIN);
    let rotary = positive("rapid_deg_min", file.rapid_deg_min.as_ref())?.unwrap_or(RAPID_DEG_MIN).to_radians();
    let mut rates = Rates {
        rapid: Axis::ALL.map(|axis| if axis.is_rotary() { rotary } else { linear }),
        feed: [f64::INFINITY; 9],
        rapid_path: RapidPath::Straight,
    };
    for (name, given, rates) in
        [("rapid_rates", &file.rapid_rates, &mut rates.rapid), ("feed_limits", &file.feed_limits, &mut rates.feed)]
    {
        for (letter, value) in given {
            let axis = letter.parse().ok().and_then(Axis::from_letter);
            let axis = axis.ok_or_else(|| {
                (value.span(), format!("{name}: `{letter}` is not an axis; the axes are X Y Z A B C U V W"))
            })?;
            let Some(value) = positive(&format!("{name}.{letter}"), Some(value))? else { continue };
            rates[axis as usize] = if axis.is_rotary() { value.to_radians() } else { value };
        }
    }
    if let RapidFile::DogLeg = file.rapid {
        rates.rapid_path = RapidPath::DogLeg(rates.rapid);
    }
    Ok(rates)
}

/// The controller's initial state.
fn read_setup(
    document: &Document,
    machine: &Machine,
    file: &ProgramFile,
    tip: Option<&TipControl>,
) -> Result<Setup, SceneError> {
    let mut setup = program::setup(file).map_err(|wrong| document.meaning(wrong))?;
    let check = |position: &Position, span: Range<usize>| {
        machine.check_limits(position).map_err(|cause| document.place(&span).error(cause))
    };
    // Where the machine stands without `start`, the program that needs it is to blame; without a home, the block that goes there.
    check(&setup.start, file.start.as_ref().map_or_else(|| file.file.span(), Spanned::span))?;
    for (home, position) in [(&file.home, Some(&setup.home)), (&file.second_home, setup.second_home.as_ref())] {
        if let (Some(home), Some(position)) = (home, position) {
            check(position, home.span())?;
        }
    }
    setup.kinematics = tip.map(|tip| tip.kinematics(machine));
    let unlimited = Some([f64::NEG_INFINITY, f64::INFINITY]);
    setup.endless = Axis::ALL.map(|axis| axis.is_rotary() && machine.axis_limits(axis) == unlimited);
    Ok(setup)
}

/// Adds the parts of the tools that have dimensions, and their lengths to the table.
fn mount_tools(
    document: &Document,
    machine: &Machine,
    parts: &mut Vec<Part>,
    file: &ProgramFile,
    tip: Option<&TipControl>,
    setup: &mut Setup,
) -> Result<Vec<DrawnTool>, SceneError> {
    let meaning = |wrong| document.meaning(wrong);
    let mut drawn = Vec::new();
    for (spanned, entry) in file.tools.iter().zip(program::tools(&file.tools).map_err(meaning)?) {
        let Some(assembly) = &entry.assembly else { continue };
        let wrong = |message| meaning((spanned.span(), format!("tool {}: {message}", entry.number)));
        let tip = tip.ok_or_else(|| wrong(NO_SPINDLE.to_owned()))?;
        let mounted = assembly::mount(&entry, assembly, machine, tip).map_err(wrong)?;
        for part in mounted.parts {
            push_part(parts, part).map_err(|why| why.at(document.place(&spanned.span())))?;
        }
        setup.tools.insert(entry.number, mounted.tool);
        drawn.push(mounted.drawn);
    }
    Ok(drawn)
}

fn read_program(
    folder: &mut Folder,
    document: &Document,
    file: &ProgramFile,
    setup: &Setup,
    tip: Option<TipControl>,
    overrides: &Overrides,
) -> Result<ProgramRun, SceneError> {
    let sampling = program::sampling(file).map_err(|wrong| document.meaning(wrong))?;
    let (path, naming) = (file.file.get_ref(), document.naming(&file.file));
    let source = if overrides.skips_program { String::new() } else { folder.text(path).map_err(naming)? };
    let (path, hash) = (folder.path(path), folder.hash(path));
    if overrides.defers_program {
        return Ok(program::deferred(&source, path, hash, setup, tip, sampling));
    }
    program::run(&source, path, hash, setup, tip, sampling)
}

fn read_tip(document: &Document, machine: &Machine, file: &Spanned<TipFile>) -> Result<TipControl, SceneError> {
    let refuse = |message: &str| Err(document.place(&file.span()).error(message));
    let TipFile { tool_link, gauge_mm, direction, work_link } = file.get_ref();
    // A machine may have a link of that name; else it is what carries everything.
    let is_world = |name: &&Spanned<String>| name.get_ref() == "world" && machine.link("world").is_none();
    let find = |link: &Option<Spanned<String>>| {
        link.as_ref().filter(|name| !is_world(name)).map(|name| find_link(document, machine, name)).transpose()
    };
    let Some(direction) = geometry::direction(Vector::from(*direction)) else {
        return refuse("the direction towards the tip must be finite and not zero");
    };
    if !gauge_mm.iter().all(|x| x.is_finite()) {
        return refuse("gauge_mm is not finite");
    }
    let gauge = Point::from(*gauge_mm);
    let tip = TipControl { tool_link: find(tool_link)?, gauge, direction, work_link: find(work_link)? };
    match tip.check(machine) {
        Ok(()) => Ok(tip),
        Err(why) => refuse(&format!("tool_centre_point: {why}")),
    }
}

fn read_recording(
    folder: &mut Folder,
    document: &Document,
    file: &Spanned<String>,
    machine: &Machine,
    parts: &[Part],
    program: Option<&ProgramRun>,
) -> Result<Recording, SceneError> {
    let start = program.map_or_else(Position::default, |program| program.start);
    let poses = machine.forward(&start);
    let initial: Vec<_> = parts.iter().map(|part| poses.world_from(part.link) * part.link_from_part).collect();
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    let text = folder.text(file.get_ref()).map_err(document.naming(file))?;
    recording::parse(&text, &folder.path(file.get_ref()), &names, &initial)
}

fn read_approaches(
    document: &Document,
    machine: &Machine,
    parts: &[Part],
    files: &[ApproachFile],
) -> Result<Vec<Approach>, SceneError> {
    let mut approaches: Vec<Approach> = Vec::with_capacity(files.len());
    for file in files {
        let name = file.name.get_ref();
        let place = || document.place(&file.name.span());
        if approaches.iter().any(|approach| approach.name == *name) {
            return Err(place().error(format!("there are two approaches named `{name}`")));
        }
        let at = program::finite("`at`", file.at.position()).map_err(|message| place().error(message))?;
        machine.check_limits(&at).map_err(|cause| place().error(cause))?;
        let direction = geometry::direction(Vector::from(file.direction));
        let direction = direction.ok_or_else(|| place().error("the direction is zero or not finite"))?;
        let offsets_mm = file.offsets_mm.clone().unwrap_or_else(|| Approach::OFFSETS_MM.to_vec());
        if offsets_mm.is_empty() || !offsets_mm.iter().all(|offset| offset.is_finite()) {
            return Err(place().error("offsets_mm must be a list of finite numbers, at least one"));
        }
        let pair = find_pair(document, parts, &file.pair)?;
        approaches.push(Approach { name: name.clone(), pair, at, direction, offsets_mm });
    }
    Ok(approaches)
}

fn find_link(document: &Document, machine: &Machine, name: &Spanned<String>) -> Result<usize, SceneError> {
    machine.link(name.get_ref()).ok_or_else(|| {
        let known = machine.links().iter().map(|link| link.name.as_str());
        unknown(document.place(&name.span()), "link", name.get_ref(), known)
    })
}

fn find_pair(document: &Document, parts: &[Part], names: &Spanned<[String; 2]>) -> Result<Pair, SceneError> {
    let place = || document.place(&names.span());
    let find = |name: &String| {
        let known = || parts.iter().map(|part| part.name.as_str());
        known().position(|known| known == name).ok_or_else(|| unknown(place(), "part", name, known()))
    };
    let [a, b] = names.get_ref();
    let pair = Pair { a: find(a)?, b: find(b)? };
    if pair.a == pair.b {
        return Err(place().error(format!("part `{a}` is paired with itself")));
    }
    if let (Some(one), Some(other)) = (parts[pair.a].tool, parts[pair.b].tool)
        && one != other
    {
        let message = format!("`{a}` belongs to tool {one} and `{b}` to tool {other}: they are never there together");
        return Err(place().error(message));
    }
    Ok(pair)
}

/// The clearances of `check`; the standard ones where the scene gives none.
fn read_clearances(document: &Document, parts: &[Part], texts: &[Spanned<String>]) -> Result<Clearances, SceneError> {
    let read = |text: &Spanned<String>| {
        let wrong = |message: String| document.meaning((text.span(), format!("clearance: {message}")));
        let clearance: Clearance = text.get_ref().parse().map_err(wrong)?;
        clearance.check_names(parts).map_err(wrong)?;
        Ok(clearance)
    };
    Ok(Clearances::new(texts.iter().map(read).collect::<Result<_, SceneError>>()?))
}

/// Every two parts that can move relative to each other, by a joint between their links or by recorded poses. Parts of different tools are
/// never mounted together, so they form no pair.
pub(super) fn movable_pairs(machine: &Machine, parts: &[Part], recorded: bool) -> Vec<Pair> {
    let body = |part: usize| machine.rigid_body(parts[part].link);
    (0..parts.len())
        .flat_map(|a| (a + 1..parts.len()).map(move |b| Pair { a, b }))
        .filter(|&Pair { a, b }| recorded || body(a) != body(b))
        .filter(|&Pair { a, b }| parts[a].tool.is_none() || parts[b].tool.is_none() || parts[a].tool == parts[b].tool)
        .collect()
}

/// The error of a name that is not among those that are known.
pub(super) fn unknown<'a>(place: Place, what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> SceneError {
    let known: Vec<&str> = known.collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    place.error(format!("there is no {what} named `{name}`; there are {known}"))
}

#[cfg(test)]
mod tests;
