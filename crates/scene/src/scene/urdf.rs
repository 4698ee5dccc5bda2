//! Machines of scenes from URDF files: finds the file's meshes, and makes parts of its bodies.

use super::error::{Place, SceneError};
use super::file::MachineFile;
use super::folder::Folder;
use super::load::Document;
use super::parts::{admit, push_part};
use super::{MeshFile, Part, Role};
use crate::geometry::shapes::Tessellation;
use crate::geometry::{Mesh, import};
use crate::machine::Machine;
use crate::machine::urdf::{self, Solid};
use std::error::Error;
use std::sync::Arc;
use toml::Spanned;

/// Number of levels above the URDF file's folder at which a package is searched.
const LEVELS_UP: usize = 5;

/// The machine of a URDF file and a part for each of its bodies.
pub fn read(
    folder: &mut Folder,
    document: &Document,
    file: &MachineFile,
    path: &Spanned<String>,
    tessellation: &Tessellation,
) -> Result<(Machine, Vec<Part>), SceneError> {
    let robot = Document::read(folder, &format!("{}{}", document.base, path.get_ref()));
    let robot = robot.map_err(document.naming(path))?;
    let (machine, bodies) = urdf::read(&robot.text, &file.axes, file.form)
        .map_err(|cause| place_of(&robot, cause.name.as_deref()).error(cause.message))?;
    let mut parts: Vec<Part> = Vec::with_capacity(bodies.len());
    for body in bodies {
        let place = || place_of(&robot, machine.links().get(body.link).map(|link| link.name.as_str()));
        let failed = |cause| SceneError::Mesh { place: place(), part: body.name.clone(), cause };
        admit(&parts, &body.name).map_err(|why| why.at(place()))?;
        let shape = if let Solid::Shape(shape) = &body.solid { Some(Arc::new(shape.clone())) } else { None };
        let mesh = match &body.solid {
            Solid::Shape(shape) => shape.mesh(tessellation).map_err(|error| failed(error.into()))?,
            Solid::Mesh { file, unit_mm } => {
                read_mesh(folder, &robot.base, &body.name, file, *unit_mm).map_err(failed)?
            }
        };
        let part = Part {
            name: body.name.clone(),
            mesh: Arc::new(mesh),
            link: Some(body.link),
            link_from_part: body.link_from_body,
            shape,
            role: Role::Machine,
            tool: None,
            groove_mm: 0.0,
            turns: None,
        };
        push_part(&mut parts, part).map_err(|why| why.at(place()))?;
    }
    Ok((machine, parts))
}

/// The place at which a name occurs in the file as a value, or the beginning of the file.
fn place_of(robot: &Document, name: Option<&str>) -> Place {
    let at =
        name.and_then(|name| robot.text.find(&format!("\"{name}\"")).or_else(|| robot.text.find(&format!("'{name}'"))));
    // After the quotation mark.
    let byte = at.map_or(0, |at| at + 1);
    robot.place(&(byte..byte))
}

/// The mesh of a part; its import report goes to the folder's records.
fn read_mesh(
    folder: &mut Folder,
    base: &str,
    part: &str,
    file: &str,
    unit_mm: f64,
) -> Result<Mesh, Box<dyn Error + Send + Sync>> {
    let path = find_mesh(folder, base, file)?;
    let bytes = folder.bytes(&path)?;
    let import::Imported { mesh, report } = import::parse_scaled(&folder.path(&path), &bytes, unit_mm)?;
    folder.meshes.push(MeshFile { part: part.to_owned(), file: path, report });
    Ok(mesh)
}

/// The path of a mesh. `package://name/rest` is in a folder `name` beside or above the file, or in a folder around the file whose `package.xml`
/// names the package. `file://` is used as it is, and any other path is relative to the file.
fn find_mesh(folder: &mut Folder, base: &str, file: &str) -> Result<String, String> {
    let in_package = file.strip_prefix("package://").or_else(|| file.strip_prefix("model://"));
    let ups = || (0..=LEVELS_UP).map(|levels| format!("{base}{}", "../".repeat(levels)));
    let mut tried = match (file.strip_prefix("file://"), in_package) {
        (Some(path), _) => vec![path.to_owned()],
        (None, Some(path)) => ups().map(|up| format!("{up}{path}")).collect(),
        (None, None) => vec![format!("{base}{file}")],
    };
    if let Some(path) = tried.iter().find(|path| folder.has(path)) {
        return Ok(path.clone());
    }
    let mut hint = "";
    if let Some((name, rest)) = in_package.and_then(|path| path.split_once('/')) {
        hint = "; a folder of another name needs a `package.xml` that names the package";
        for up in ups() {
            let path = format!("{up}{rest}");
            if is_package(folder, &up, name) {
                if folder.has(&path) {
                    return Ok(path);
                }
                tried.push(path);
            }
        }
    }
    let tried: Vec<String> = tried.iter().map(|path| folder.path(path).display().to_string()).collect();
    Err(format!("there is no mesh `{file}`; tried {}{hint}", tried.join(", ")))
}

/// Whether a folder has a `package.xml` with this package's name.
fn is_package(folder: &mut Folder, up: &str, name: &str) -> bool {
    let manifest = format!("{up}package.xml");
    let text = if folder.has(&manifest) { folder.text(&manifest).unwrap_or_default() } else { String::new() };
    let named = text.split_once("<name>").and_then(|(_, text)| text.split_once("</name>"));
    named.is_some_and(|(named, _)| named.trim() == name)
}
