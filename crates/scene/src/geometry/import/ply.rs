//! PLY, text and binary of either byte order, through the `ply-rs-bw` crate (Turk, The PLY Polygon File Format, 1994).
//!
//! The elements `vertex` (scalars `x`, `y`, `z`) and `face` (list `vertex_indices` or `vertex_index`) form the mesh; other elements and
//! properties are skipped. Polygons are divided into triangles ([`super::polygon`]). Deviations: an element whose announced count cannot fit
//! into the rest of the file, or is beyond the limit of a mesh, is refused before it is read, because the crate would allocate or loop for
//! that count. Triangle strips, and anything but white space after the last element, are refused.

use super::super::Point;
use super::error::{ImportError, Place, quote};
use super::{MOST, Raw};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult};
use ply_rs_bw::ply::{PropertyType, ScalarType};
use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;

/// Whether the content begins as a PLY file does.
pub(super) fn is_ply(content: &[u8]) -> bool {
    content.starts_with(b"ply\n") || content.starts_with(b"ply\r")
}

/// Longest header looked for, bytes.
const LONGEST_HEADER: usize = 1 << 16;

/// The header of a binary file, with the end of its last line: CR, LF or CR LF, as the first line ends.
pub(super) fn binary_header(content: &[u8]) -> Option<&[u8]> {
    let end: &[u8] = match content {
        [b'p', b'l', b'y', b'\n', ..] => b"\n",
        [b'p', b'l', b'y', b'\r', b'\n', ..] => b"\r\n",
        [b'p', b'l', b'y', b'\r', ..] => b"\r",
        _ => return None,
    };
    let last = [b"end_header", end].concat();
    let searched = &content[..content.len().min(LONGEST_HEADER)];
    let length = searched.windows(last.len()).position(|window| window == last)? + last.len();
    let header = &content[..length];
    header.windows(13).any(|window| window == b"format binary").then_some(header)
}

/// The position of a vertex.
#[derive(Debug)]
struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f64::NAN; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[axis] = match property {
            Property::Char(x) => x.into(),
            Property::UChar(x) => x.into(),
            Property::Short(x) => x.into(),
            Property::UShort(x) => x.into(),
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            Property::Float(x) => x.into(),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// The corners of a face as the file has them; a list of bytes may be long, and is not made eight times as long.
#[derive(Debug)]
struct Face(Option<Property>);

impl Face {
    /// Corners that are vertices.
    fn corners(&self, vertices: usize) -> Result<Vec<u32>, String> {
        let known = |vertex: i64| {
            let vertex_number = u32::try_from(vertex).ok().filter(|&number| (number as usize) < vertices);
            vertex_number.ok_or_else(|| format!("there is no vertex {vertex}, only {vertices}"))
        };
        match &self.0 {
            Some(Property::ListChar(list)) => list.iter().map(|&x| known(x.into())).collect(),
            Some(Property::ListUChar(list)) => list.iter().map(|&x| known(x.into())).collect(),
            Some(Property::ListShort(list)) => list.iter().map(|&x| known(x.into())).collect(),
            Some(Property::ListUShort(list)) => list.iter().map(|&x| known(x.into())).collect(),
            Some(Property::ListInt(list)) => list.iter().map(|&x| known(x.into())).collect(),
            Some(Property::ListUInt(list)) => list.iter().map(|&x| known(x.into())).collect(),
            _ => Ok(Vec::new()),
        }
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(None)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corner_list(name) {
            return PropertyAccessResult::Ignored;
        }
        match property {
            Property::ListChar(_)
            | Property::ListUChar(_)
            | Property::ListShort(_)
            | Property::ListUShort(_)
            | Property::ListInt(_)
            | Property::ListUInt(_) => self.0 = Some(property),
            _ => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

fn is_corner_list(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

/// An element that is skipped.
#[derive(Debug)]
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// The file, and the current position of the reader.
struct File<'a> {
    path: &'a Path,
    content: &'a [u8],
    reader: Reader<Cursor<&'a [u8]>>,
}

impl File<'_> {
    /// The place of an error: a line in text, a byte in binary data.
    fn place(&self, text: bool, line: Option<usize>) -> Place {
        let byte = self.reader.get_ref().position() as usize;
        if text { Place::Line(line.unwrap_or_else(|| self.reader.line())) } else { Place::Byte(byte) }
    }

    fn wrong(&self, place: &Place, message: impl Display) -> ImportError {
        ImportError::at(self.path, place, message)
    }

    /// Converts an error of the crate. The first line of its message is kept, with the line of the file if the file is text.
    fn failed(&self, text: bool, error: &ParseError) -> ImportError {
        let place = self.place(text, error.line());
        let message = error.to_string();
        let message = message.lines().next().unwrap_or_default();
        let message = message.split_once(": ").filter(|(start, _)| start.starts_with("Line ")).map_or(message, |m| m.1);
        let message = message.trim_end_matches('.');
        let line = match place {
            Place::Line(line) => self.content.split(|b| *b == b'\n').nth(line.saturating_sub(1)),
            _ => None,
        };
        match line {
            Some(line) => self.wrong(&place, format!("{message}: {}", quote(&String::from_utf8_lossy(line)))),
            None => self.wrong(&place, message),
        }
    }

    /// What has not been read.
    fn rest(&self) -> &[u8] {
        self.content.get(self.reader.get_ref().position() as usize..).unwrap_or_default()
    }

    /// All items of an element.
    fn items<E: PropertyAccess>(&mut self, element: &ElementDef, header: &Header) -> Result<Vec<E>, ImportError> {
        let text = header.encoding == Encoding::Ascii;
        // A line has at least its end; binary items have their scalars and the lengths of their lists.
        let least = if text { 1 } else { element.properties.values().map(|p| least_bytes(&p.data_type)).sum() };
        let rest = self.rest().len();
        if element.count.checked_mul(least).is_none_or(|bytes| bytes > rest) || (least == 0 && element.count > 0) {
            let message = format!(
                "the header announces {} of `{}`, at least {least} bytes each, but {rest} bytes are left",
                element.count, element.name
            );
            return Err(self.wrong(&self.place(text, None), message));
        }
        if size_of::<E>() > 0 && element.count > MOST {
            let message =
                format!("the header announces {} of `{}`; at most {MOST} are read", element.count, element.name);
            return Err(self.wrong(&self.place(text, None), message));
        }
        let items = Parser::<E>::new().read_payload_for_element(&mut self.reader, element, header);
        items.map_err(|error| self.failed(text, &error))
    }
}

/// The smallest number of bytes that a property takes in a binary file.
const fn least_bytes(property: &PropertyType) -> usize {
    match property {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => match scalar {
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        },
    }
}

pub(super) fn read(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    let mut file = File { path, content, reader: Reader::new(Cursor::new(content)) };
    let header = Parser::<Skipped>::new().read_header(&mut file.reader).map_err(|error| file.failed(true, &error))?;
    check_header(&file, &header)?;
    let mut raw = Raw::default();
    let mut faces = Vec::new();
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                let vertices: Vec<Vertex> = file.items(element, &header)?;
                raw.vertices = vertices.into_iter().map(|v| Point::from(v.0)).collect();
            }
            "face" => faces = file.items::<Face>(element, &header)?,
            _ => drop(file.items::<Skipped>(element, &header)?),
        }
    }
    if !file.rest().trim_ascii().is_empty() {
        let place = file.place(header.encoding == Encoding::Ascii, None);
        return Err(file.wrong(&place, "the file goes on after what its header announces"));
    }
    let count = raw.vertices.len();
    for (index, face) in faces.into_iter().enumerate() {
        let added = face.corners(count).and_then(|corners| raw.add_polygon(&corners));
        added.map_err(|why| file.wrong(&Place::Object(format!("face {index}")), why))?;
    }
    Ok(raw)
}

/// Refuses a header without the elements and properties of a mesh.
fn check_header(file: &File, header: &Header) -> Result<(), ImportError> {
    let has = |element: &str, fits: &dyn Fn(&str, &PropertyType) -> bool| {
        let properties = header.elements.get(element).map(|element| &element.properties);
        properties.is_some_and(|properties| properties.iter().any(|(name, p)| fits(name, &p.data_type)))
    };
    let refuse = |message: &str| Err(file.wrong(&Place::Line(file.reader.line()), message));
    for axis in ["x", "y", "z"] {
        if !has("vertex", &|name, kind| name == axis && matches!(kind, PropertyType::Scalar(_))) {
            return refuse(&format!("the header has no element `vertex` with a scalar `{axis}`"));
        }
    }
    if !has("face", &|name, kind| is_corner_list(name) && matches!(kind, PropertyType::List(..))) {
        let strips = header.elements.contains_key("tristrips");
        let hint = if strips { "; triangle strips are not read" } else { "" };
        return refuse(&format!("the header has no element `face` with a list `vertex_indices`{hint}"));
    }
    Ok(())
}
