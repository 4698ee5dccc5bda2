//! GLB, the binary form of glTF (Khronos Group, glTF 2.0 Specification, 2021; sections in parentheses).
//!
//! The meshes of the default scene are read, placed by their nodes in the rest pose. Points and lines are ignored.
//! Coordinates are metres unless the caller says otherwise (3.4), and stay in the file's axes: in glTF y points up, not z.
//!
//! `serde_json` reads the JSON into the few fields that positions need. The `gltf` crate is not used: its arithmetic on the lengths, counts
//! and strides of a file is unchecked, and it is larger than these fields. Deviations: buffers outside the file, sparse accessors, skins,
//! morph targets of nonzero weight, and extensions that may place or change geometry are refused by name.

use super::super::{Point, Vector};
use super::error::{ImportError, Place};
use super::placement::{self, Placement};
use super::{METRE, Raw};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use std::path::Path;

const MAGIC: &[u8] = b"glTF";
/// Bytes of the file header (4.4.2); below, of a chunk header (4.4.3).
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
/// Component types (3.6.2.2).
const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// Whether the content begins as a GLB file does.
pub(super) fn is_glb(content: &[u8]) -> bool {
    content.starts_with(MAGIC)
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Document {
    scene: Option<usize>,
    scenes: Vec<SceneObject>,
    nodes: Vec<Node>,
    meshes: Vec<MeshObject>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<BufferView>,
    buffers: Vec<Buffer>,
    extensions_required: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct SceneObject {
    nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Node {
    mesh: Option<usize>,
    children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
    skin: Option<IgnoredAny>,
    /// Weights of the mesh's morph targets; they replace those of the mesh (3.5.4).
    weights: Option<Vec<f64>>,
    extensions: BTreeMap<String, IgnoredAny>,
}

#[derive(Debug, Deserialize)]
struct MeshObject {
    primitives: Vec<Primitive>,
    #[serde(default)]
    weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    #[serde(default = "triangles")]
    mode: u32,
    /// Morph targets.
    #[serde(default)]
    targets: Vec<IgnoredAny>,
}

const fn triangles() -> u32 {
    4
}

#[derive(Debug, Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    shape: String,
    sparse: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Debug, Deserialize)]
struct Buffer {
    uri: Option<IgnoredAny>,
}

/// Whether an extension leaves all positions as they are.
fn is_harmless(extension: &str) -> bool {
    ["KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_"].iter().any(|prefix| extension.starts_with(prefix))
}

/// The place of an error, and its description.
type Fault = (Place, String);

fn fault<T>(object: impl Into<String>, message: impl Into<String>) -> Result<T, Fault> {
    Err((Place::Object(object.into()), message.into()))
}

pub(super) fn read(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    read_document(content).map_err(|(place, message)| ImportError::at(path, &place, message))
}

fn read_document(content: &[u8]) -> Result<Raw, Fault> {
    let (json, binary) = chunks(content)?;
    let start = HEADER + CHUNK_HEADER;
    let document: Document = serde_json::from_slice(json).map_err(|error| {
        let line = json.split_inclusive(|b| *b == b'\n').take(error.line().saturating_sub(1)).map(<[u8]>::len);
        (Place::Byte(start + line.sum::<usize>() + error.column().saturating_sub(1)), error.to_string())
    })?;
    if let Some(extension) = document.extensions_required.iter().find(|extension| !is_harmless(extension)) {
        return fault("extensionsRequired", format!("the extension {extension} is not read"));
    }
    let file = File { document: &document, binary };
    let mut raw = Raw { unit_mm: Some(METRE), ..Raw::default() };
    let mut visited = vec![false; document.nodes.len()];
    let mut waiting: Vec<(usize, Placement)> =
        file.roots()?.into_iter().rev().map(|node| (node, Placement::identity())).collect();
    while let Some((index, holder)) = waiting.pop() {
        let name = format!("nodes[{index}]");
        let Some(node) = document.nodes.get(index) else {
            return fault(name, format!("there is no such node, only {}", document.nodes.len()));
        };
        if std::mem::replace(&mut visited[index], true) {
            return fault(name, "the node is in the scene twice; nodes must form trees");
        }
        if let Some(extension) = node.extensions.keys().find(|extension| !is_harmless(extension)) {
            return fault(name, format!("the extension {extension} is not read"));
        }
        let placement = holder.of(&node.placement());
        if let Some(mesh) = node.mesh {
            if node.skin.is_some() {
                return fault(name, "skins are not read; export the mesh in the pose that it shall have");
            }
            file.add_mesh(&mut raw, mesh, node.weights.as_deref(), &placement)?;
        }
        waiting.extend(node.children.iter().rev().map(|&child| (child, placement)));
    }
    Ok(raw)
}

/// The JSON chunk and the binary chunk; the latter is empty if the file has none.
fn chunks(content: &[u8]) -> Result<(&[u8], &[u8]), Fault> {
    let word = |at: usize| {
        let bytes = content.get(at..at + 4).and_then(|bytes| bytes.try_into().ok());
        bytes.map(u32::from_le_bytes).ok_or_else(|| (Place::Byte(content.len()), "the file ends too early".to_owned()))
    };
    if !is_glb(content) {
        return Err((Place::Byte(0), "expected `glTF`".to_owned()));
    }
    let (version, length) = (word(4)?, word(8)?);
    if version != 2 {
        return Err((Place::Byte(4), format!("version {version} of glTF is not read, only 2")));
    }
    if length as usize != content.len() {
        let message = format!("the header announces {length} bytes, but the file has {}", content.len());
        return Err((Place::Byte(8), message));
    }
    let (mut json, mut binary) = (None, &[][..]);
    let mut at = HEADER;
    while at < content.len() {
        let (length, kind) = (word(at)? as usize, word(at + 4)?.to_le_bytes());
        let start = at + CHUNK_HEADER;
        let Some(chunk) = content.get(start..start + length) else {
            let message = format!("the chunk announces {length} bytes, but {} are left", content.len() - start);
            return Err((Place::Byte(at), message));
        };
        match (&kind, json) {
            (b"JSON", None) => json = Some(chunk),
            (_, None) => break,
            (b"BIN\0", Some(_)) if binary.is_empty() => binary = chunk,
            // Chunks of other kinds are to be ignored (4.4.3).
            _ => {}
        }
        at = start + length;
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err((Place::Byte(HEADER), "the first chunk is not JSON".to_owned())),
    }
}

impl Node {
    /// The placement of a node: its matrix, column by column, or otherwise its scale, rotation and translation in this order (3.5.3).
    fn placement(&self) -> Placement {
        if let Some(m) = self.matrix {
            let linear = Matrix3::new(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]);
            return Placement { linear, offset: Vector::new(m[12], m[13], m[14]) };
        }
        let [x, y, z, w] = self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        let scale = Matrix3::from_diagonal(&self.scale.unwrap_or([1.0; 3]).into());
        Placement { linear: rotation.matrix() * scale, offset: self.translation.unwrap_or_default().into() }
    }
}

struct File<'a> {
    document: &'a Document,
    binary: &'a [u8],
}

impl<'a> File<'a> {
    /// The root nodes of the default scene, or of the first scene. Without scenes, all nodes that are no other node's child.
    fn roots(&self) -> Result<Vec<usize>, Fault> {
        let document = self.document;
        if let Some(scene) = document.scenes.get(document.scene.unwrap_or(0)) {
            return Ok(scene.nodes.clone());
        }
        if let Some(scene) = document.scene {
            return fault("scene", format!("there is no scene {scene}, only {}", document.scenes.len()));
        }
        let mut held = vec![false; document.nodes.len()];
        for &child in document.nodes.iter().flat_map(|node| &node.children) {
            if let Some(held) = held.get_mut(child) {
                *held = true;
            }
        }
        Ok((0..held.len()).filter(|&node| !held[node]).collect())
    }

    /// Adds a mesh; `weights` are those of its node.
    fn add_mesh(&self, raw: &mut Raw, index: usize, weights: Option<&[f64]>, at: &Placement) -> Result<(), Fault> {
        let name = format!("meshes[{index}]");
        let Some(mesh) = self.document.meshes.get(index) else {
            return fault(name, format!("there is no such mesh, only {}", self.document.meshes.len()));
        };
        let is_morphed = weights.unwrap_or(&mesh.weights).iter().any(|weight| *weight != 0.0);
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let name = format!("{name}.primitives[{number}]");
            match primitive.mode {
                0..=3 => continue,
                4..=6 => {}
                mode => return fault(name, format!("there is no mode {mode}")),
            }
            if is_morphed && !primitive.targets.is_empty() {
                return fault(name, "morph targets are not read; export the mesh in the shape that it shall have");
            }
            let Some(position) = primitive.attributes.position else { continue };
            let vertices = self.positions(position)?;
            let indices = match primitive.indices {
                Some(indices) => self.indices(indices)?,
                None => (0..vertices.len() as u32).collect(),
            };
            if let Some(vertex) = indices.iter().find(|&&v| v as usize >= vertices.len()) {
                return fault(name, format!("there is no vertex {vertex}, only {}", vertices.len()));
            }
            if primitive.mode == triangles() && indices.len() % 3 != 0 {
                return fault(name, format!("{} corners do not make triangles", indices.len()));
            }
            let faces = faces(&indices, primitive.mode);
            placement::add(raw, &vertices, &faces, at).or_else(|message| fault(name, message))?;
        }
        Ok(())
    }

    fn positions(&self, index: usize) -> Result<Vec<Point>, Fault> {
        let accessor = self.accessor(index)?;
        if accessor.component_type != F32 || accessor.shape != "VEC3" {
            return fault(format!("accessors[{index}]"), "positions must be three single-precision numbers");
        }
        let number = |bytes: &[u8], i: usize| {
            f64::from(f32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]))
        };
        let point = |bytes: &[u8]| Point::new(number(bytes, 0), number(bytes, 1), number(bytes, 2));
        let points: Vec<Point> = self.elements(index, 12)?.map(point).collect();
        match points.iter().position(|p| !p.coords.iter().all(|x| x.is_finite())) {
            Some(vertex) => fault(format!("accessors[{index}]"), format!("position {vertex} is not finite")),
            None => Ok(points),
        }
    }

    fn indices(&self, index: usize) -> Result<Vec<u32>, Fault> {
        let accessor = self.accessor(index)?;
        let size = match (accessor.component_type, accessor.shape.as_str()) {
            (U8, "SCALAR") => 1,
            (U16, "SCALAR") => 2,
            (U32, "SCALAR") => 4,
            _ => return fault(format!("accessors[{index}]"), "indices must be unsigned whole numbers"),
        };
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte));
        Ok(self.elements(index, size)?.map(number).collect())
    }

    fn accessor(&self, index: usize) -> Result<&'a Accessor, Fault> {
        let missing = || format!("there is no such accessor, only {}", self.document.accessors.len());
        self.document.accessors.get(index).map_or_else(|| fault(format!("accessors[{index}]"), missing()), Ok)
    }

    /// The bytes of an accessor's elements, `size` each.
    fn elements(&self, index: usize, size: usize) -> Result<impl Iterator<Item = &'a [u8]>, Fault> {
        let (accessor, name) = (self.accessor(index)?, format!("accessors[{index}]"));
        if accessor.sparse.is_some() {
            return fault(name, "sparse accessors are not read");
        }
        let Some(view_index) = accessor.buffer_view else {
            return fault(name, "the accessor has no buffer view");
        };
        let view_name = format!("bufferViews[{view_index}]");
        let Some(view) = self.document.buffer_views.get(view_index) else {
            return fault(view_name, format!("there is no such view, only {}", self.document.buffer_views.len()));
        };
        let outside = self.document.buffers.get(view.buffer).is_none_or(|buffer| buffer.uri.is_some());
        if view.buffer != 0 || outside {
            return fault(view_name, format!("buffer {} is not in the file", view.buffer));
        }
        let end = view.byte_offset.checked_add(view.byte_length);
        let Some(bytes) = end.and_then(|end| self.binary.get(view.byte_offset..end)) else {
            let message = format!(
                "{} bytes from byte {} of the binary chunk, which has {}",
                view.byte_length,
                view.byte_offset,
                self.binary.len()
            );
            return fault(view_name, message);
        };
        let stride = view.byte_stride.unwrap_or(size);
        let needed = match accessor.count {
            0 => Some(accessor.byte_offset),
            count => stride.checked_mul(count - 1).and_then(|n| n.checked_add(size)?.checked_add(accessor.byte_offset)),
        };
        if stride < size || needed.is_none_or(|needed| needed > bytes.len()) {
            let message = format!(
                "{} elements of {size} bytes every {stride} from byte {} of a view of {} bytes",
                accessor.count,
                accessor.byte_offset,
                bytes.len()
            );
            return fault(name, message);
        }
        let start = accessor.byte_offset;
        Ok((0..accessor.count).map(move |i| &bytes[start + i * stride..start + i * stride + size]))
    }
}

/// The triangles of a list (mode 4), a strip (5) or a fan (6) (3.7.2.1).
fn faces(indices: &[u32], mode: u32) -> Vec<[u32; 3]> {
    let windows = indices.windows(3).enumerate();
    match mode {
        5 => windows.map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] }).collect(),
        6 => (2..indices.len()).map(|i| [indices[i - 1], indices[i], indices[0]]).collect(),
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}
