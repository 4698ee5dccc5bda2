//! 3MF, through the `zip` and `quick-xml` crates (3MF Consortium, 3MF Core Specification 1.3; sections in parentheses).
//!
//! The meshes that the build of the root model part places are read, with components of the production extension in other parts. The file
//! names its unit (3.4). Materials are skipped, and so is what a file does not require: slices, beam lattices and the rest.
//!
//! The `threemf` crate is not used: it unpacks as much as the archive holds, keeps data that a mesh does not need, and its errors have no
//! place in the file. Here the unpacked size and the number of placements are bounded.

use super::super::{Point, Vector};
use super::Raw;
use super::error::{ImportError, Place, quote};
use super::placement::{self, Placement};
use nalgebra::Matrix3;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;
use std::io::{Cursor, Read};
use std::path::Path;
use std::str::FromStr;
use zip::ZipArchive;

/// Most bytes to which all model parts together may unpack: 1 GiB, about ten million triangles.
const MOST_UNPACKED: u64 = 1 << 30;
/// Most components that may be placed. Components may contain components, so a few lines can ask for any number.
const MOST_PLACED: usize = 1 << 16;
/// Namespaces of extensions that a file may require: paths of components, which are read, and colours, which move nothing.
const KNOWN_EXTENSIONS: [&str; 2] = [
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
];
/// The usual name of the root model part, in lower case; names in the archive are compared without regard to case.
const ROOT: &str = "3d/3dmodel.model";

/// An object in the archive: the part, by its name in lower case, and the object's number in that part.
type Key = (String, u32);

/// A mesh, placed objects, or both.
#[derive(Debug, Default)]
struct Object {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
    components: Vec<(Key, Placement)>,
}

/// The content of one model part.
#[derive(Debug, Default)]
struct Model {
    unit_mm: f64,
    objects: HashMap<u32, Object>,
    items: Vec<(Key, Placement)>,
}

pub(super) fn read(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    read_archive(content).map_err(|(place, message)| ImportError::at(path, &place, message))
}

/// The place of an error, and its description.
type Fault = (Place, String);

fn in_archive(name: &str, message: &(impl ToString + ?Sized)) -> Fault {
    (Place::Object(format!("archive, {name}")), message.to_string())
}

fn read_archive(content: &[u8]) -> Result<Raw, Fault> {
    let mut archive = ZipArchive::new(Cursor::new(content)).map_err(|error| in_archive("directory", &error))?;
    let mut models: Vec<(String, Model)> = Vec::new();
    let mut left = MOST_UNPACKED;
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(|error| in_archive(&format!("entry {index}"), &error))?;
        let name = entry.name().map_err(|error| in_archive(&format!("entry {index}"), &error))?.into_owned();
        if !name.to_ascii_lowercase().ends_with(".model") {
            continue;
        }
        let mut text = Vec::new();
        entry.take(left + 1).read_to_end(&mut text).map_err(|error| in_archive(&name, &error))?;
        left = left
            .checked_sub(text.len() as u64)
            .ok_or_else(|| in_archive(&name, &format!("the model unpacks to more than {MOST_UNPACKED} bytes")))?;
        let text = String::from_utf8(text).map_err(|error| in_archive(&name, &error))?;
        models.push((part_key(&name), Part::new(&name, &text).read()?));
    }
    let root = models.iter().find(|(name, _)| name == ROOT);
    let Some((_, root)) = root.or_else(|| models.iter().find(|(_, model)| !model.items.is_empty())) else {
        return Err(in_archive("directory", "there is no model that builds anything"));
    };
    build(root, &models)
}

/// The name by which a part is found.
fn part_key(name: &str) -> String {
    name.trim_start_matches('/').to_ascii_lowercase()
}

/// Places the objects that the build of the root part names.
fn build(root: &Model, models: &[(String, Model)]) -> Result<Raw, Fault> {
    let mut raw = Raw { unit_mm: Some(root.unit_mm), ..Raw::default() };
    let mut waiting: Vec<(&Key, Placement)> = root.items.iter().rev().map(|(key, at)| (key, *at)).collect();
    let mut placed = waiting.len();
    while let Some((key, at)) = waiting.pop() {
        let name = format!("object {} of {}", key.1, key.0);
        let model = models.iter().find(|(part, _)| *part == key.0);
        let Some(object) = model.and_then(|(_, model)| model.objects.get(&key.1)) else {
            return Err((Place::Object(name), "there is no such object".to_owned()));
        };
        placement::add(&mut raw, &object.vertices, &object.faces, &at)
            .map_err(|message| (Place::Object(name.clone()), message))?;
        placed += object.components.len();
        if placed > MOST_PLACED {
            let message = format!("more than {MOST_PLACED} objects are placed; does one hold itself?");
            return Err((Place::Object(name), message));
        }
        waiting.extend(object.components.iter().rev().map(|(key, inner)| (key, at.of(inner))));
    }
    Ok(raw)
}

/// A reader of one model part.
struct Part<'a> {
    name: &'a str,
    text: &'a str,
    xml: Reader<&'a [u8]>,
    /// The byte at which the current element begins.
    begin: usize,
}

impl<'a> Part<'a> {
    fn new(name: &'a str, text: &'a str) -> Self {
        Self { name, text, xml: Reader::from_str(text), begin: 0 }
    }

    fn wrong(&self, message: &(impl ToString + ?Sized)) -> Fault {
        let before = &self.text.as_bytes()[..self.begin.min(self.text.len())];
        let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let place = Place::Part { part: self.name.to_owned(), line, column: before.len() - line_start + 1 };
        (place, message.to_string())
    }

    fn read(mut self) -> Result<Model, Fault> {
        let mut model = Model { unit_mm: 1.0, ..Model::default() };
        let mut object: Option<(u32, Object)> = None;
        // The prefix of the core namespace: whatever the root element has. Other prefixes are extensions.
        let mut prefix: Option<String> = None;
        loop {
            self.begin = self.xml.buffer_position() as usize;
            let event = self.xml.read_event().map_err(|error| self.wrong(&error))?;
            let (Event::Start(tag) | Event::Empty(tag)) = &event else {
                match event {
                    Event::Eof => break,
                    Event::End(tag) if tag.local_name().as_ref() == "object" => {
                        self.finish(&mut model, object.take())?;
                    }
                    _ => {}
                }
                continue;
            };
            let full = tag.name();
            let (before, name) = full.as_ref().rsplit_once(':').unwrap_or(("", full.as_ref()));
            match &prefix {
                None if name != "model" => return Err(self.wrong(&format!("expected `model`, found {}", quote(name)))),
                None => prefix = Some(before.to_owned()),
                Some(core) if core != before => continue,
                Some(_) => {}
            }
            match (name, &mut object) {
                ("model", _) => {
                    self.refuse_unknown_extensions(tag)?;
                    model.unit_mm = self.unit(tag)?;
                }
                ("object", _) => object = Some((self.number(tag, "id")?, Object::default())),
                ("vertex", Some((_, object))) => {
                    let [x, y, z] = self.numbers(tag, ["x", "y", "z"])?;
                    object.vertices.push(Point::new(x, y, z));
                }
                ("triangle", Some((_, object))) => object.faces.push(self.numbers(tag, ["v1", "v2", "v3"])?),
                ("component", Some((_, object))) => object.components.push(self.placed(tag)?),
                ("item", None) => model.items.push(self.placed(tag)?),
                _ => {}
            }
            if name == "object" && matches!(event, Event::Empty(_)) {
                self.finish(&mut model, object.take())?;
            }
        }
        match (prefix, object) {
            (None, _) => Err(self.wrong("there is no `model`")),
            (_, Some((id, _))) => Err(self.wrong(&format!("the part ends within object {id}"))),
            _ => Ok(model),
        }
    }

    /// Stores an object that has been read completely.
    fn finish(&self, model: &mut Model, object: Option<(u32, Object)>) -> Result<(), Fault> {
        let Some((id, object)) = object else { return Ok(()) };
        let count = object.vertices.len();
        if let Some(vertex) = object.faces.iter().flatten().find(|&&v| v as usize >= count) {
            return Err(self.wrong(&format!("object {id} has no vertex {vertex}, only {count}")));
        }
        match model.objects.insert(id, object) {
            Some(_) => Err(self.wrong(&format!("there is an object {id} already"))),
            None => Ok(()),
        }
    }

    fn attribute<'t>(&self, tag: &'t BytesStart, name: &str) -> Result<Option<std::borrow::Cow<'t, str>>, Fault> {
        let attribute = tag.try_get_attribute(name).map_err(|error| self.wrong(&error))?;
        Ok(attribute.map(|attribute| attribute.value))
    }

    fn number<T: FromStr>(&self, tag: &BytesStart, name: &str) -> Result<T, Fault> {
        let Some(text) = self.attribute(tag, name)? else {
            return Err(self.wrong(&format!("`{name}` is missing: {}", quote(tag))));
        };
        text.trim().parse().map_err(|_| self.wrong(&format!("`{name}` is not a number of its kind: {}", quote(&text))))
    }

    fn numbers<T: FromStr>(&self, tag: &BytesStart, [a, b, c]: [&str; 3]) -> Result<[T; 3], Fault> {
        Ok([self.number(tag, a)?, self.number(tag, b)?, self.number(tag, c)?])
    }

    /// Refuses a `model` element that requires an extension of an unknown namespace. It lists their prefixes, which it also defines.
    fn refuse_unknown_extensions(&self, tag: &BytesStart) -> Result<(), Fault> {
        let required = self.attribute(tag, "requiredextensions")?.unwrap_or_default();
        for prefix in required.split_ascii_whitespace() {
            let namespace = self.attribute(tag, &format!("xmlns:{prefix}"))?.unwrap_or_default();
            if !KNOWN_EXTENSIONS.contains(&&*namespace) {
                let (prefix, namespace) = (quote(prefix), quote(&namespace));
                return Err(
                    self.wrong(&format!("the file requires the extension {prefix}, {namespace}; it is not read"))
                );
            }
        }
        Ok(())
    }

    /// The unit of a `model` element, mm.
    fn unit(&self, tag: &BytesStart) -> Result<f64, Fault> {
        match self.attribute(tag, "unit")?.as_deref() {
            None | Some("millimeter") => Ok(1.0),
            Some("micron") => Ok(1e-3),
            Some("centimeter") => Ok(10.0),
            Some("inch") => Ok(25.4),
            Some("foot") => Ok(304.8),
            Some("meter") => Ok(1000.0),
            Some(other) => Err(self.wrong(&format!("there is no unit {}", quote(other)))),
        }
    }

    /// The object that an `item` or a `component` names, and its placement. A transform is a matrix of four rows and three columns that
    /// multiplies a point as a row vector (3.3).
    fn placed(&self, tag: &BytesStart) -> Result<(Key, Placement), Fault> {
        let mut part = part_key(self.name);
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|error| self.wrong(&error))?;
            if attribute.key.local_name().as_ref() == "path" {
                part = part_key(&attribute.value);
            }
        }
        let mut at = Placement::identity();
        if let Some(text) = self.attribute(tag, "transform")? {
            let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
            let Some(numbers) = numbers.filter(|n| n.len() == 12 && n.iter().all(|x| x.is_finite())) else {
                return Err(self.wrong(&format!("a transform is twelve numbers: {}", quote(&text))));
            };
            at.linear = Matrix3::from_column_slice(&numbers[..9]);
            at.offset = Vector::from_column_slice(&numbers[9..]);
        }
        Ok(((part, self.number(tag, "objectid")?), at))
    }
}
