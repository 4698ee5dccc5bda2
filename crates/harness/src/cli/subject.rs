//! A scene, the program that runs on it, and what the command line adds to both: shared by `check`, `view` and `scene`.

use super::gcode::{Reading, print_notes, tool_table};
use super::note;
use crate::machine::tip::TipControl;
use crate::scene::set_up::SetUp;
use crate::scene::{Overrides, ProgramRun, Scene, SceneError, StockSpec, ToolEntry};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use rs274::{Axis, Note};
use std::path::{Path, PathBuf};

/// Examples for the help of every verb that takes a [`Subject`].
pub const SET_UP_EXAMPLES: &str = "\
Set up a job without editing the scene:
  --offset G54=100,-50,30                where the work's zero is, machine coordinates
  --tool 3=diameter:10,flute:22,stickout:40,holder:32x20/50x40
                                         an end mill; its holder's steps from the tool's side up
  --tool 5=diameter:8,point:118,flute:60,stickout:80
                                         a drill; corner:1 rounds a corner, corner:4 makes a ball
  --tools shop.toml                      a library: [[tools]] with number, diameter_mm, ...
  --stock box:100,60,30                  a block, the middle of its top at zero of G54
  --stock cylinder:50,120@0,0,-120       round stock, the middle of its lower end there
  --stock blank.stl                      a mesh in coordinates of G54
  --spindle head@0,0,-20 --table table   where the scene does not say what holds tool and work
  --ignore M31 --ignore G187             codes that are skipped";

/// A scene and the program that runs on it.
#[derive(Args)]
pub struct Subject {
    /// Scene by name or by path
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// The program (RS274/NGC) [default: the scene's own]
    #[arg(value_name = "PROGRAM")]
    pub program: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Put the origin of a work offset elsewhere, machine coordinates, mm and degrees: G54=X,Y,Z[,A,B,C[,U,V,W]]; axes that are not given keep the scene's
    /// origin; in the dialects fanuc and haas G54.1P12, too, and in haas G154P12; X is a diameter on Fanuc's and Haas's lathes, as on their offset page; repeatable
    #[arg(long = "offset", value_name = "NAME=X,Y,Z")]
    offsets: Vec<String>,
    /// Take tools from a LinuxCNC tool table in place of the scene's; its offsets and diameters go before those of --tool and --tools
    #[arg(long, value_name = "FILE")]
    tool_table: Option<PathBuf>,
    /// The tool table's lengths are inches
    #[arg(long, requires = "tool_table")]
    tool_table_inch: bool,
    #[command(flatten)]
    job: Job,
}

/// Tools and stock.
#[derive(Args)]
struct Job {
    /// Put a tool into the spindle by its measures, mm and degrees: diameter, corner, point, flute, shank, stickout or length, holder, offset; repeatable
    #[arg(long = "tool", value_name = "N=KEY:VALUE,...")]
    tools: Vec<String>,
    /// Take tools with their shapes from a TOML file with [[tools]], as in [program] of a scene
    #[arg(long = "tools", value_name = "FILE")]
    library: Option<PathBuf>,
    /// Put stock in place of the workpiece, in coordinates of G54: box:X,Y,Z, cylinder:DIAMETER,LENGTH or a mesh FILE[:UNIT]; @X,Y,Z behind it
    /// says where the box's corner of least X, Y and Z is, the middle of the cylinder's lower end, or the file's origin
    #[arg(long, value_name = "STOCK")]
    stock: Option<String>,
    /// The link that holds tools, and the tip of a tool of no length in it; @X,Y,Z may be left out for the link of the scene's
    /// tool_centre_point [default: the scene's tool_centre_point]
    #[arg(long, value_name = "LINK[@X,Y,Z]")]
    spindle: Option<String>,
    /// The link that carries the workpiece [default: the scene's tool_centre_point]
    #[arg(long, value_name = "LINK")]
    table: Option<String>,
}

impl Job {
    fn set_up(&self) -> Result<SetUp> {
        let mut tools = self.library.as_deref().map(ToolEntry::library).transpose()?.unwrap_or_default();
        for text in &self.tools {
            let tool = ToolEntry::parse(text).map_err(|why| anyhow!("--tool {text}: {why}"))?;
            tools.retain(|known| known.number != tool.number);
            tools.push(tool);
        }
        let stock = self.stock.as_deref().map(StockSpec::parse).transpose();
        Ok(SetUp {
            spindle: self.spindle.clone(),
            table: self.table.clone(),
            tools,
            stock: stock.map_err(|why| anyhow!("--stock: {why}"))?,
            ..SetUp::default()
        })
    }
}

impl Subject {
    /// Refuses a file that is no place for what an option writes ([`refuse_output`]); `read` are the scene's files, where it is loaded.
    ///
    /// # Errors
    /// When it is such a file.
    pub fn refuse_output(&self, option: &str, file: &Path, read: &[PathBuf]) -> Result<()> {
        let stock = self.job.stock.as_deref().and_then(|text| StockSpec::parse(text).ok());
        let stock = stock.as_ref().and_then(StockSpec::file);
        let inputs = [self.program.as_deref(), self.tool_table.as_deref(), self.job.library.as_deref(), stock];
        let inputs = inputs.into_iter().flatten().chain(read.iter().map(PathBuf::as_path));
        refuse_output(option, file, &self.scene, inputs)
    }

    /// The scene, and the program asked for; else the scene's own, if it has one. Prints the notes on it.
    pub fn load(&self) -> Result<(Scene, Option<ProgramRun>)> {
        self.load_and_note(|_| true)
    }

    /// The same; of the notes on the program it prints those that `counts` wants.
    pub fn load_and_note(&self, counts: fn(&Note) -> bool) -> Result<(Scene, Option<ProgramRun>)> {
        let mut job = self.job.set_up()?;
        let is_changed =
            self.reading.is_given() || !self.offsets.is_empty() || self.tool_table.is_some() || !job.is_empty();
        let overrides =
            Overrides { skips_program: self.program.is_some(), defers_program: is_changed, ..Overrides::default() };
        let mut scene = Scene::find_with(&self.scene, &overrides)?;
        let mut setup = scene.program.clone().unwrap_or_else(ProgramRun::of_mill);
        self.reading.apply(&mut setup.setup);
        for offset in &self.offsets {
            let wrong = |message: String| anyhow!("--offset {offset}: {message}");
            let (name, origin) =
                offset.split_once('=').ok_or_else(|| wrong("it must be like G54=100,-50,30".to_owned()))?;
            setup.set_work_offset(name, place(origin).map_err(wrong)?).map_err(wrong)?;
        }
        if let Some(path) = &self.tool_table {
            setup.setup.tools = tool_table(path, self.tool_table_inch)?;
            job.measured = setup.setup.tools.clone();
        }
        if !job.is_empty() {
            for told in scene.set_up(&mut setup, &job).map_err(|why| anyhow!(why))? {
                note(format!("note: {told}"));
            }
        }
        let of_tools = scene.tool_notes(&setup.setup.tools);
        of_tools.iter().for_each(|told| note(format!("note: {told}")));
        if let Some(program) = self.program.as_deref().filter(|file| file.extension().is_some_and(|end| end == "toml"))
        {
            bail!(
                "{}: this is a file of settings, not a program; a command names first the scene, then the program",
                program.display()
            );
        }
        let mut run = match &self.program {
            Some(program) => Some(setup.with_program(program).map_err(with_hint)?),
            None if is_changed && scene.program.is_some() => Some(setup.again().map_err(with_hint)?),
            None => scene.program.clone(),
        };
        if let Some(run) = &mut run {
            if job.stock.is_some() {
                run.note_moved_zero();
            }
            scene.files.extend(run.called_files());
            print_notes(run.program.notes.iter().filter(|note| counts(note)));
            for told in scene.tool_notes(&run.program.tools).iter().filter(|told| !of_tools.contains(told)) {
                note(format!("note: {told} (the program sets it)"));
            }
            // A library holds more than one program uses.
            let asked = job.tools.iter().filter(|_| self.job.library.is_none());
            asked.filter_map(|tool| unused(tool, run)).for_each(note);
        }
        scene.mesh_warnings().iter().for_each(|warning| note(format!("warning: {warning}")));
        Ok((scene, run))
    }
}

/// Kinds of files that a command may replace in a scene's folder: what it writes, and nobody draws or programs.
const WRITTEN: [&str; 6] = ["sarif", "json", "xml", "cert", "html", "png"];

/// Whether there is no such file, or it is of a kind that is [`WRITTEN`].
pub fn is_new_or_written(file: &Path) -> bool {
    let Ok(place) = file.canonicalize() else { return true };
    let kind = place.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    WRITTEN.contains(&&*kind)
}

/// Refuses a file that is no place for what an option writes: devices and folders, `inputs`, and files in the folder of `scene` that are drawn or
/// programmed.
///
/// # Errors
/// When it is such a file.
pub fn refuse_output<'a>(
    option: &str,
    file: &Path,
    scene: &str,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    let Ok(place) = file.canonicalize() else { return Ok(()) };
    let name = file.display();
    if !place.is_file() {
        let found = if place.is_dir() { "a folder" } else { "no ordinary file" };
        bail!("{option} {name}: this is {found}; name a file");
    }
    let is_it = |input: &Path| input.canonicalize().is_ok_and(|input| input == place);
    let is_of_scene = || Path::new(scene).canonicalize().is_ok_and(|folder| place.starts_with(folder));
    if inputs.into_iter().any(is_it) || !is_new_or_written(&place) && is_of_scene() {
        bail!("{option} {name}: this would replace what is read; name another file");
    }
    Ok(())
}

/// Refuses a file whose name does not end as what an option writes, `kind`.
///
/// # Errors
/// When it is such a file.
pub fn refuse_ending(option: &str, file: &Path, kind: &str) -> Result<()> {
    if file.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case(kind)) {
        let (name, what) = (file.display(), kind.to_uppercase());
        bail!("{option} {name}: it writes {what}; name a file that ends with .{kind}");
    }
    Ok(())
}

/// A tool that was asked for and never is in the spindle.
fn unused(tool: &ToolEntry, run: &ProgramRun) -> Option<String> {
    let number = tool.number;
    let is_used = run.setup.tool == number || run.tools().contains(&number);
    (!is_used && tool.assembly.is_some())
        .then(|| format!("note: tool {number} is never in the spindle of this program"))
}

/// What carries tool and workpiece of a scene's program.
pub fn tip_control(scene: &Scene) -> Result<&TipControl> {
    scene.program.as_ref().and_then(|run| run.tip.as_ref()).with_context(|| {
        format!(
            "scene `{}` has no `[program.tool_centre_point]`, which says what carries tool and workpiece",
            scene.name
        )
    })
}

/// X,Y,Z, then A,B,C, then U,V,W, mm and degrees; `None` for the axes that are not given.
fn place(text: &str) -> std::result::Result<[Option<f64>; 9], String> {
    let numbers: std::result::Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let numbers = numbers.map_err(|error| error.to_string())?;
    if ![3, 6, 9].contains(&numbers.len()) {
        return Err(format!(
            "{} numbers; it must have 3 (X,Y,Z), 6 (X,Y,Z,A,B,C) or 9 (X,Y,Z,A,B,C,U,V,W)",
            numbers.len()
        ));
    }
    let mut origin = [None; 9];
    for (axis, number) in Axis::ALL.into_iter().zip(numbers) {
        origin[axis as usize] = Some(if axis.is_rotary() { number.to_radians() } else { number });
    }
    Ok(origin)
}

/// What to do about a tool that nobody knows.
fn with_hint(error: SceneError) -> anyhow::Error {
    let error = anyhow::Error::from(error);
    if format!("{error:#}").contains("tool table") {
        error.context(
            "a tool is unknown: give --tool N=diameter:D,flute:F,stickout:S, --tools LIBRARY or --tool-table FILE, or name it in `tools` of [program] in scene.toml",
        )
    } else {
        error
    }
}
