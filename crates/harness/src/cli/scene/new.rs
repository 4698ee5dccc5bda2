//! `scene new`: a scene folder from mesh files.

use super::super::{CLEAR, note, say};
use super::{extents_table, write_folder};
use crate::geometry::import::{ImportError, Unit};
use crate::record::command::quoted;
use crate::scene::template::{BASE, Chain, NewPart, NewScene, TEMPLATES};
use crate::scene::{LARGEST_FILE, Overrides, Role, Scene, SceneError, set_up};
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use rs274::Plane;
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// The folder of the mesh files in a new scene.
const MESHES: &str = "meshes";

#[derive(Args)]
#[command(
    after_help = "Examples:\n  bvbench scene new shop --machine mill --part base.stl:machine:base --part saddle.stl:machine:Y --part table.stl:machine:X \\\n                         --part vise.stl:fixture --part head.stl:machine:Z --gauge 0,0,500\n  bvbench scene new shop --machine trunnion --part cradle.stl:machine:A --part rotary.stl:machine:C --pivot A=0,0,150 --limits A=-110,30 ...\n  bvbench scene new shop --machine \"w B X b Z Y t\" --part ...      axes from the work over the base b to the tool\n  bvbench scene new shop --machine \"lathe: w C b Z X Y t\" --part ...   the same of a lathe\n  bvbench scene new shop --machine lathe --part chuck.stl:fixture --part turret.stl:machine:X --unit inch\n  bvbench scene new shop --machine mill --part *.stl --ask          asks for the role and the link of each part\n\nAll files share one frame: the drawing of the machine with every axis at zero. On a terminal roles that are not given are asked for.\nNext: `bvbench view shop --open` moves each axis, `bvbench check shop part.ngc --tool ... --stock ...` checks a program."
)]
pub struct Options {
    /// The new folder
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// A mesh file (STL, OBJ, OFF, PLY, GLB, 3MF), its role, and the axis that carries it: a letter, or base; repeatable
    #[arg(long = "part", value_name = "FILE[:ROLE[:LINK]]", required = true, num_args = 1..)]
    parts: Vec<String>,
    /// Kind of machine: mill, router, horizontal, rotary, trunnion, head-table, fork, lathe, or its axes as in "w X Y b Z t", those of a lathe
    /// as in "lathe: w C b Z X Y t"
    #[arg(long, value_name = "KIND")]
    machine: Option<String>,
    /// Where a tool of no length has its tip (the spindle's nose) in the drawing, mm
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true)]
    gauge: String,
    /// A point on the line of a rotary axis in the drawing, mm; repeatable [default: 0,0,0]
    #[arg(long = "pivot", value_name = "AXIS=X,Y,Z")]
    pivots: Vec<String>,
    /// Limits of an axis, mm or degrees of its own way, so that X of a lathe is a radius; repeatable [default: none]
    #[arg(long = "limits", value_name = "AXIS=MIN,MAX")]
    limits: Vec<String>,
    /// Unit of the mesh files: mm, cm, m or inch [default: the format's: metres in GLB, its own in 3MF, else mm]
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    /// The program to begin with, which is copied [default: one that moves each axis a little]
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// One line on what the scene shows [default: the folder's name]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Ask for what is not given, also where standard input is no terminal
    #[arg(long)]
    ask: bool,
    /// Replace the scene.toml that is in the folder
    #[arg(long)]
    fresh: bool,
}

pub fn run(options: &Options) -> Result<u8> {
    let file = options.folder.join("scene.toml");
    if file.exists() && !options.fresh {
        bail!("{}: there is a scene already; name another folder, or replace it with --fresh", file.display());
    }
    let asks = options.ask || io::stdin().is_terminal();
    let mut questions = Questions { from: io::stdin().lock(), asks };
    let unit = options.unit.as_deref().map(unit).transpose()?;
    let chain = questions.machine(options.machine.as_deref())?;
    let mut parts: Vec<(PathBuf, NewPart)> = Vec::new();
    for text in &options.parts {
        let part = questions.part(text, &chain)?;
        if let Some((twin, _)) = parts.iter().find(|(_, other)| other.name == part.1.name) {
            bail!("--part {text}: `{}` would be named `{}`, too; rename one", twin.display(), part.1.name);
        }
        parts.push(part);
    }
    let program = match &options.program {
        Some(path) => path.file_name().ok_or_else(|| anyhow!("--program {}: no file", path.display()))?,
        None => "jog.ngc".as_ref(),
    };
    if program == "scene.toml" || program == MESHES {
        bail!("--program: the new folder needs the name `{}` itself; rename the program", program.to_string_lossy());
    }
    let scene = NewScene {
        title: options.title.clone().unwrap_or_else(|| name_of(&options.folder)),
        gauge_mm: numbers("--gauge", &options.gauge)?,
        pivots_mm: by_axis("--pivot", &options.pivots, &chain, true)?,
        limits: limits(&options.limits, &chain)?,
        parts: parts.iter().map(|(_, part)| part.clone()).collect(),
        chain,
        unit,
        program: program.to_string_lossy().into_owned(),
    };
    show(&options.folder, &write(options, &scene, &parts)?);
    Ok(CLEAR)
}

/// Writes the folder, and gives the scene that it holds. Nothing is written where no scene comes of it, or a file of other content would be lost.
fn write(options: &Options, scene: &NewScene, parts: &[(PathBuf, NewPart)]) -> Result<Scene> {
    let folder = &options.folder;
    let read =
        |from: &Path| rs274::file::bytes(from, LARGEST_FILE).with_context(|| format!("cannot read {}", from.display()));
    let program = options.program.as_deref().map_or_else(|| Ok(scene.jog().into_bytes()), read)?;
    let mut files = BTreeMap::from([(scene.program.clone(), program)]);
    for (from, part) in parts {
        files.insert(part.file.clone(), read(from)?);
    }
    for (name, bytes) in &files {
        let file = folder.join(name);
        if file.exists() && fs::read(&file).ok().as_ref() != Some(bytes) {
            bail!(
                "{}: the file is there already, with other content; move it away, or name another folder",
                file.display()
            );
        }
    }
    files.insert("scene.toml".to_owned(), scene.toml().into_bytes());
    let made = Scene::from_memory(&folder.to_string_lossy(), files.clone(), &Overrides::default());
    let made = made.map_err(|error| {
        if let Some(unread) = unread(&error, parts) {
            return unread;
        }
        let next = match &error {
            SceneError::Mesh { .. } => UNIT_HINT,
            SceneError::Program(_) => {
                "; leave --program out, and check the program where it is: `bvbench check FOLDER PROGRAM --dialect NAME`"
            }
            _ => "",
        };
        anyhow::Error::from(error)
            .context(format!("no scene can be made of these files, and nothing is written{next}"))
    })?;
    write_folder(folder, files)?;
    Ok(made)
}

/// Advice for a mesh that is too large or too small.
const UNIT_HINT: &str = "; --unit says what they are in";

/// The error about a file of the user that cannot be read as a mesh: it names that file, not the copy that was to be made.
fn unread(error: &SceneError, parts: &[(PathBuf, NewPart)]) -> Option<anyhow::Error> {
    let SceneError::Mesh { cause, .. } = error else { return None };
    let ImportError { path, message } = cause.downcast_ref()?;
    let (from, _) = parts.iter().find(|(_, part)| path.ends_with(&part.file))?;
    let next = if message.contains("is the unit right?") { UNIT_HINT } else { "" };
    Some(anyhow!("cannot read {}: {message}; nothing is written{next}", from.display()))
}

/// Says what a new scene holds.
fn show(folder: &Path, scene: &Scene) {
    say(extents_table(scene).trim_fmt());
    for warning in scene.mesh_warnings() {
        note(format!("warning: {warning}"));
    }
    if scene.pairs.is_empty() {
        note(
            "note: no two parts move against each other yet: add --tool or --stock to a check, or parts to scene.toml",
        );
    }
    let (folder, shown) = (folder.display(), quoted(&folder.to_string_lossy()));
    let is_lathe = scene.program.as_ref().is_some_and(|run| run.setup.plane == Plane::Zx);
    let job = match is_lathe {
        true => {
            "--stock cylinder:50,120\nTurning tools are parts with `tool = N`; `tools = [{ number = N }]` of [program] in scene.toml names them."
        }
        false => "--tool 1=diameter:10,flute:22,stickout:40,holder:32x60 --stock box:100,60,30",
    };
    say(format!(
        "\n{folder}/scene.toml is written. If the sizes are wrong, give the command again with --unit and --fresh. Next:\n  bvbench view {shown} --open        does each axis go the right way?\n  bvbench check {shown}              does anything touch that should not?\n  bvbench check {shown} part.ngc --offset G54=X,Y,Z {job}"
    ));
}

/// What is given, else asked for.
struct Questions<R> {
    from: R,
    asks: bool,
}

impl<R: BufRead> Questions<R> {
    fn machine(&mut self, given: Option<&str>) -> Result<Chain> {
        if let Some(kind) = given {
            return Chain::find(kind).map_err(|why| anyhow!("--machine: {why}"));
        }
        let kinds: Vec<String> =
            TEMPLATES.iter().map(|kind| format!("  {:<11}{} ({})", kind.name, kind.about, kind.chain)).collect();
        if !self.asks {
            bail!("give --machine KIND, one of\n{}", kinds.join("\n"));
        }
        note(kinds.join("\n"));
        loop {
            match Chain::find(&self.answer("Which kind of machine?", "mill")?) {
                Ok(chain) => return Ok(chain),
                Err(why) => note(why),
            }
        }
    }

    /// A part, and where its file is now.
    fn part(&mut self, text: &str, chain: &Chain) -> Result<(PathBuf, NewPart)> {
        let (path, role, link) = split(text);
        let wrong = |why: String| anyhow!("--part {text}: {why}");
        if !path.is_file() {
            let roles = Role::ALL.map(Role::name).join(", ");
            return Err(wrong(format!("there is no file {}; roles are {roles}", path.display())));
        }
        let role = match role {
            Some(role) => role,
            None if self.asks => self.role(&path)?,
            None => {
                let roles = Role::ALL.map(Role::name).join(", ");
                return Err(wrong(format!(
                    "which role? Write {}:ROLE[:LINK], ROLE one of {roles}; or give --ask",
                    path.display()
                )));
            }
        };
        let link = match link.or_else(|| chain.link_of(role)) {
            Some(link) => known(&link, chain)
                .ok_or_else(|| wrong(format!("there is no link `{link}`; there are {}", chain.links().join(", "))))?,
            None if self.asks => self.link(&path, chain)?,
            None => {
                return Err(wrong(format!(
                    "what carries it? Write {}:{}:LINK, LINK one of {}",
                    path.display(),
                    role.name(),
                    chain.links().join(", ")
                )));
            }
        };
        let extension =
            path.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
        let name = name_of(&path.with_extension(""));
        let file = format!("{MESHES}/{name}{extension}");
        Ok((path, NewPart { name, file, role, link }))
    }

    fn role(&mut self, path: &Path) -> Result<Role> {
        let roles = Role::ALL.map(Role::name).join(", ");
        loop {
            let answer = self.answer(&format!("{}: which role ({roles})?", path.display()), Role::Machine.name())?;
            match role_named(&answer) {
                Some(role) => return Ok(role),
                None => note(format!("`{answer}` is none of {roles}")),
            }
        }
    }

    fn link(&mut self, path: &Path, chain: &Chain) -> Result<String> {
        let links = chain.links().join(", ");
        loop {
            let answer = self.answer(&format!("{}: what carries it ({links})?", path.display()), BASE)?;
            match known(&answer, chain) {
                Some(link) => return Ok(link),
                None => note(format!("`{answer}` is none of {links}")),
            }
        }
    }

    /// A line from standard input; an empty one is the usual answer.
    fn answer(&mut self, question: &str, usual: &str) -> Result<String> {
        let _ = write!(io::stderr(), "{question} [{usual}] ");
        let mut line = String::new();
        if self.from.read_line(&mut line).context("cannot read the answer")? == 0 {
            bail!("standard input ended before the question: {question}");
        }
        let answer = line.trim();
        Ok(if answer.is_empty() { usual } else { answer }.to_owned())
    }
}

/// The file, and role and link where they are behind it: FILE:ROLE:LINK.
fn split(text: &str) -> (PathBuf, Option<Role>, Option<String>) {
    let pieces: Vec<&str> = text.split(':').collect();
    // From behind: a drive's letter has a colon, too.
    match (1..pieces.len()).rev().find_map(|i| Some((i, role_named(pieces[i])?))) {
        Some((i, role)) if i + 2 >= pieces.len() => {
            (pieces[..i].join(":").into(), Some(role), pieces.get(i + 1).map(|&link| link.to_owned()))
        }
        _ => (text.into(), None, None),
    }
}

fn role_named(name: &str) -> Option<Role> {
    Role::ALL.into_iter().find(|role| role.name() == name)
}

/// A link of the machine, whatever case it is written in.
fn known(link: &str, chain: &Chain) -> Option<String> {
    chain.links().into_iter().find(|known| known.eq_ignore_ascii_case(link))
}

/// The last part of a path.
fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| "machine".to_owned(), |name| name.to_string_lossy().into_owned())
}

fn unit(name: &str) -> Result<Unit> {
    Unit::named(name).ok_or_else(|| anyhow!("--unit {name}: it must be mm, cm, m or inch"))
}

fn numbers<const N: usize>(option: &str, text: &str) -> Result<[f64; N]> {
    set_up::numbers(text).map_err(|why| anyhow!("{option}: {why}"))
}

/// `A=...` for axes of the machine, each once.
fn by_axis<const N: usize>(
    option: &str,
    texts: &[String],
    chain: &Chain,
    rotary: bool,
) -> Result<BTreeMap<char, [f64; N]>> {
    let mut read = BTreeMap::new();
    for text in texts {
        let (axis, values) = text.split_once('=').ok_or_else(|| anyhow!("{option} {text}: it must be like A=..."))?;
        let axis = chain.axes().into_iter().find(|known| axis.trim().eq_ignore_ascii_case(&known.letter().to_string()));
        let axis = axis.filter(|axis| !rotary || axis.is_rotary());
        let axis = axis.ok_or_else(|| {
            let what = if rotary { "rotary axis" } else { "axis" };
            anyhow!("{option} {text}: the machine has no such {what}; its links are {}", chain.links().join(", "))
        })?;
        if read.insert(axis.letter(), numbers(option, values)?).is_some() {
            bail!("{option} {text}: axis {} is given twice", axis.letter());
        }
    }
    Ok(read)
}

fn limits(texts: &[String], chain: &Chain) -> Result<BTreeMap<char, [f64; 2]>> {
    let limits = by_axis("--limits", texts, chain, false)?;
    match limits.iter().find(|(_, [min, max])| min >= max) {
        Some((axis, [min, max])) => bail!("--limits {axis}={min},{max}: the lower limit comes first, and is lower"),
        None => Ok(limits),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_stand_behind_files_and_links_behind_roles() {
        let split = |text| {
            let (path, role, link) = split(text);
            (path.to_string_lossy().into_owned(), role.map(Role::name), link)
        };
        let link = |name: &str| Some(name.to_owned());
        assert_eq!(split("a.stl"), ("a.stl".to_owned(), None, None));
        assert_eq!(split("a.stl:fixture"), ("a.stl".to_owned(), Some("fixture"), None));
        assert_eq!(split("C:\\a.stl:machine:X"), ("C:\\a.stl".to_owned(), Some("machine"), link("X")));
        assert_eq!(split("a.stl:vise:X").1, None, "no role of that name");
    }

    #[test]
    fn what_is_not_given_is_asked_for_until_it_makes_sense() {
        let file = tempfile::NamedTempFile::with_suffix(".stl").unwrap();
        let text = file.path().to_string_lossy().into_owned();
        let mut questions = Questions { from: io::Cursor::new("mills\nmill\n\nnowhere\nz\n"), asks: true };
        let chain = questions.machine(None).unwrap();
        let (_, part) = questions.part(&text, &chain).unwrap();
        assert_eq!((part.role, part.link.as_str()), (Role::Machine, "Z"));
        assert!(questions.part(&text, &chain).unwrap_err().to_string().contains("standard input ended"));
        let mut silent = Questions { from: io::empty(), asks: false };
        assert!(silent.machine(None).unwrap_err().to_string().contains("trunnion"));
        assert!(silent.part(&text, &chain).unwrap_err().to_string().contains("which role?"));
    }
}
