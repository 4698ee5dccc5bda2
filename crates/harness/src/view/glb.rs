//! A scene as GLB (Khronos Group, glTF 2.0 Specification, 2021; sections in parentheses), for every other viewer.
//!
//! The nodes are the machine's: a root that turns z-up millimetres into y-up metres (3.4), below it each link at its place
//! on its parent, its joint, and its parts. The program is one animation of the joints (3.11): straight between keys, as `check`
//! takes it; turns are divided so that none between two keys is above [`MOST_TURN`], which spherical interpolation then follows
//! exactly. A tool that is not in the spindle is shrunk to nothing.
//!
//! Deviations: no normals (3.7.2.1 then asks for flat shading); times of keys that are equal are moved apart by what
//! single precision can tell, because they must increase (3.11). Written with our own few fields: what is needed
//! of `gltf-json` is smaller than the crate.

use super::motion::Motion;
use crate::check::Path;
use crate::geometry::{Isometry, Mesh, Point};
use crate::machine::Joint;
use crate::machine::joint::Motion as JointMotion;
use crate::scene::{Part, ProgramRun, Role, Scene, TipFault};
use nalgebra::UnitQuaternion;
use rs274::{Axis, Position};
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};
use thiserror::Error;

/// Greatest turn between two keys, radians. Spherical interpolation takes the shorter way, so it must be below a half turn.
pub const MOST_TURN: f64 = FRAC_PI_3;
/// Longest file: its header counts bytes with 32 bits (4.4.2).
const LONGEST: usize = u32::MAX as usize;

/// Component types and targets (3.6.2.2, 5.11.5).
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Why there is no file.
#[derive(Debug, Error)]
pub enum GlbError {
    /// The program cannot be followed.
    #[error(transparent)]
    Tip(#[from] TipFault),
    /// More than a file can hold.
    #[error("scene `{0}` takes more than the 4 GiB that a GLB file can hold")]
    TooLarge(String),
}

/// The bytes of a GLB file: the scene as it stands at first and, with a program, its motion.
///
/// # Errors
/// When the program cannot be followed, or the scene is too large.
pub fn export(scene: &Scene, run: Option<&ProgramRun>) -> Result<Vec<u8>, GlbError> {
    let mut file = Writer::default();
    let start = run.map(|run| run.start).unwrap_or_default();
    let tool = run.map_or(0, |run| run.setup.tool);
    let nodes = file.add_scene(scene, &start, tool);
    if let Some(run) = run {
        let path = Path::new(scene, run)?;
        file.animate(scene, &path, &Motion::new(&path, run, &[]), &nodes);
    }
    file.finish(scene)
}

#[derive(Clone, Debug, Default, Serialize)]
struct Node {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    translation: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotation: Option<[f64; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<usize>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    children: Vec<usize>,
}

impl Node {
    fn at(name: String, place: &Isometry) -> Self {
        let q = place.rotation.coords;
        Self {
            name,
            translation: Some(place.translation.vector.into()),
            rotation: Some([q.x, q.y, q.z, q.w]),
            ..Self::default()
        }
    }
}

/// Which nodes move.
struct Nodes {
    /// Per link, the node of its joint.
    joints: Vec<Option<usize>>,
    /// Per part, its node.
    parts: Vec<usize>,
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    nodes: Vec<Node>,
    meshes: Vec<Value>,
    animations: Vec<Value>,
}

impl Writer {
    /// Bytes that an accessor reads; their number.
    fn view(&mut self, content: impl IntoIterator<Item = u8>, target: Option<u32>) -> usize {
        let from = self.bytes.len();
        self.bytes.extend(content);
        let mut view = json!({ "buffer": 0, "byteOffset": from, "byteLength": self.bytes.len() - from });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        // Every accessor must begin at a multiple of its component's size (3.6.2.4).
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Numbers in single precision, `width` to an element, with their bounds where they must be told; the accessor's number.
    fn floats<const WIDTH: usize>(&mut self, elements: &[[f32; WIDTH]], bounded: bool, target: Option<u32>) -> usize {
        let view = self.view(elements.as_flattened().iter().flat_map(|value| value.to_le_bytes()), target);
        let shape = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][WIDTH];
        let mut accessor = json!({ "bufferView": view, "componentType": F32, "count": elements.len(), "type": shape });
        if bounded {
            let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
                (0..WIDTH).filter_map(|k| elements.iter().map(|element| element[k]).reduce(pick)).collect()
            };
            accessor["min"] = json!(bound(f32::min));
            accessor["max"] = json!(bound(f32::max));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn node(&mut self, node: Node, parent: Option<usize>) -> usize {
        self.nodes.push(node);
        let number = self.nodes.len() - 1;
        if let Some(parent) = parent {
            self.nodes[parent].children.push(number);
        }
        number
    }

    /// Nodes and meshes of links and parts, as they stand at `start`.
    fn add_scene(&mut self, scene: &Scene, start: &Position, tool: u32) -> Nodes {
        // Up along z becomes up along y; millimetres become metres.
        let upright = UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), -FRAC_PI_2);
        let root = Node { scale: Some([1e-3; 3]), ..Node::at(scene.name.clone(), &upright_place(upright)) };
        let root = self.node(root, None);
        let machine = &scene.machine;
        // Parents first, whatever the order of the file.
        let mut holders: Vec<Option<usize>> = vec![None; machine.links().len()];
        let mut joints = vec![None; machine.links().len()];
        while let Some(link) = (0..holders.len()).find(|&link| {
            holders[link].is_none() && machine.parent(link).is_none_or(|parent| holders[parent].is_some())
        }) {
            let above = machine.parent(link).and_then(|parent| holders[parent]).unwrap_or(root);
            let it = &machine.links()[link];
            holders[link] = Some(match &it.joint {
                None => self.node(Node::at(it.name.clone(), &it.parent_from_link), Some(above)),
                Some(joint) => {
                    // The joint turns about its own node's origin, so that is where the node must be.
                    let shift = Isometry::from_parts(pivot(joint).coords.into(), UnitQuaternion::identity());
                    let base = Node::at(format!("{} base", it.name), &(it.parent_from_link * shift));
                    let base = self.node(base, Some(above));
                    let moved = self.node(Node::at(format!("{} joint", it.name), &moved(joint, start)), Some(base));
                    joints[link] = Some(moved);
                    self.node(Node::at(it.name.clone(), &shift.inverse()), Some(moved))
                }
            });
        }
        let parts = scene.parts.iter().map(|part| {
            let holder = part.link.and_then(|link| holders[link]).unwrap_or(root);
            let mesh = self.mesh(part);
            let is_there = part.tool.is_none_or(|own| own == tool);
            let place = Node::at(part.name.clone(), &part.link_from_part);
            let node = Node { mesh: Some(mesh), scale: Some([if is_there { 1.0 } else { 0.0 }; 3]), ..place };
            self.node(node, Some(holder))
        });
        Nodes { parts: parts.collect(), joints }
    }

    fn mesh(&mut self, part: &Part) -> usize {
        let mesh: &Mesh = &part.mesh;
        let corners: Vec<[f32; 3]> = mesh.vertices().iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect();
        let position = self.floats(&corners, true, Some(VERTICES));
        let indices = mesh.faces().as_flattened();
        // The greatest number of 16 bits means something else (3.7.2.1).
        let wide = corners.len() > usize::from(u16::MAX);
        let view = if wide {
            self.view(indices.iter().flat_map(|corner| corner.to_le_bytes()), Some(INDICES))
        } else {
            self.view(indices.iter().flat_map(|&corner| (corner as u16).to_le_bytes()), Some(INDICES))
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": if wide { U32 } else { U16 }, "count": indices.len(), "type": "SCALAR",
        }));
        self.meshes.push(json!({
            "name": part.name,
            "primitives": [{
                "attributes": { "POSITION": position }, "indices": self.accessors.len() - 1, "material": part.role as usize,
            }],
        }));
        self.meshes.len() - 1
    }

    /// One animation: a channel for every joint that moves, and one for every part of a tool that comes or goes.
    fn animate(&mut self, scene: &Scene, path: &Path, motion: &Motion, nodes: &Nodes) {
        let keys = Keys::of(motion);
        if keys.times.len() < 2 {
            return;
        }
        let times: Vec<[f32; 1]> = keys.times.iter().map(|&time| [time]).collect();
        let input = self.floats(&times, true, None);
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        let mut add = |node: usize, what: &str, output: usize, interpolation: &str| {
            samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
            channels.push(json!({ "sampler": samplers.len() - 1, "target": { "node": node, "path": what } }));
        };
        for (link, node) in scene.machine.links().iter().zip(&nodes.joints) {
            let (Some(joint), Some(node)) = (&link.joint, *node) else { continue };
            let first = joint.value(&keys.positions[0]);
            if keys.positions.iter().all(|position| joint.value(position) == first) {
                continue;
            }
            let places = keys.positions.iter().map(|position| moved(joint, position));
            if joint.turns() {
                let output: Vec<[f32; 4]> = places.map(|at| at.rotation.coords.map(|x| x as f32).into()).collect();
                add(node, "rotation", self.floats(&signed_alike(output), false, None), "LINEAR");
            } else {
                let output: Vec<[f32; 3]> = places.map(|at| at.translation.vector.map(|x| x as f32).into()).collect();
                add(node, "translation", self.floats(&output, false, None), "LINEAR");
            }
        }
        for (part, &node) in scene.parts.iter().zip(&nodes.parts) {
            let Some(own) = part.tool else { continue };
            let size = |&place: &f64| [if path.tool(place.ceil() as usize) == own { 1.0 } else { 0.0 }; 3];
            let output: Vec<[f32; 3]> = keys.places.iter().map(size).collect();
            if output.iter().any(|size| *size != output[0]) {
                add(node, "scale", self.floats(&output, false, None), "STEP");
            }
        }
        if !channels.is_empty() {
            self.animations.push(json!({ "name": "program", "samplers": samplers, "channels": channels }));
        }
    }

    fn finish(self, scene: &Scene) -> Result<Vec<u8>, GlbError> {
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("bvbench ", env!("CARGO_PKG_VERSION")), "extras": { "provenance": scene.provenance } },
            "scene": 0,
            "scenes": [{ "name": scene.title, "nodes": [0] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": Role::ALL.map(material),
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes.len() }],
        });
        if !self.animations.is_empty() {
            document["animations"] = json!(self.animations);
        }
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        if length > LONGEST {
            return Err(GlbError::TooLarge(scene.name.clone()));
        }
        let mut file = Vec::with_capacity(length);
        file.extend(b"glTF");
        for number in [2, length as u32, text.len() as u32] {
            file.extend(number.to_le_bytes());
        }
        file.extend(b"JSON");
        file.extend(text);
        file.extend((self.bytes.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(self.bytes);
        Ok(file)
    }
}

fn upright_place(rotation: UnitQuaternion<f64>) -> Isometry {
    Isometry::from_parts(nalgebra::Translation3::identity(), rotation)
}

/// The point that a joint leaves where it is, link frame, mm.
fn pivot(joint: &Joint) -> Point {
    match joint.motion {
        JointMotion::Prismatic { .. } => Point::origin(),
        JointMotion::Rotary { point, .. } => point,
    }
}

/// Where a joint takes its node, seen from its pivot.
fn moved(joint: &Joint, position: &Position) -> Isometry {
    let displacement = joint.displacement(position);
    if joint.turns() { upright_place(displacement.rotation) } else { displacement }
}

/// Quaternions each with the sign that is nearer to the one before.
fn signed_alike(mut quaternions: Vec<[f32; 4]>) -> Vec<[f32; 4]> {
    for at in 1..quaternions.len() {
        let before = quaternions[at - 1];
        let quaternion = &mut quaternions[at];
        if before.iter().zip(&*quaternion).map(|(p, q)| p * q).sum::<f32>() < 0.0 {
            *quaternion = quaternion.map(|x| -x);
        }
    }
    quaternions
}

/// A role's paint; linear, as the format wants it (3.9.2).
fn material(role: Role) -> Value {
    let srgb: [f64; 3] = match role {
        Role::Machine => [0.74, 0.77, 0.80],
        Role::Workpiece => [0.27, 0.53, 0.78],
        Role::Cutter => [0.90, 0.33, 0.16],
        Role::Shank => [0.90, 0.45, 0.28],
        Role::Holder => [0.62, 0.42, 0.66],
        Role::Fixture => [0.42, 0.64, 0.42],
    };
    let [r, g, b] = srgb.map(|x| x.powf(2.2));
    json!({
        "name": role.name(), "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.3, "roughnessFactor": 0.55 },
    })
}

/// The keys of a path, times strictly increasing, turns divided.
struct Keys {
    times: Vec<f32>,
    places: Vec<f64>,
    positions: Vec<Position>,
}

impl Keys {
    fn of(motion: &Motion) -> Self {
        let mut keys = Self { times: Vec::new(), places: Vec::new(), positions: Vec::new() };
        let mut before: Option<(f64, f64, Position)> = None;
        for ((&place, &time), &position) in motion.places.iter().zip(&motion.times_s).zip(&motion.positions) {
            if let Some((from_place, from_time, from)) = before {
                let turn = Axis::ALL.map(|axis| turned(axis, &from, &position)).into_iter().fold(0.0, f64::max);
                let pieces = (turn / MOST_TURN).ceil().max(1.0) as u32;
                for piece in 1..pieces {
                    let part = f64::from(piece) / f64::from(pieces);
                    let mix = |a: f64, b: f64| a + part * (b - a);
                    let between = Position(std::array::from_fn(|i| mix(from.0[i], position.0[i])));
                    keys.push(mix(from_place, place), mix(from_time, time), between);
                }
            }
            keys.push(place, time, position);
            before = Some((place, time, position));
        }
        keys
    }

    fn push(&mut self, place: f64, time: f64, position: Position) {
        let time = time as f32;
        self.times.push(self.times.last().map_or(time, |last| time.max(last.next_up())));
        self.places.push(place);
        self.positions.push(position);
    }
}

/// How far any joint of an axis turns at most, radians: by the angle, or by a degree per mm.
fn turned(axis: Axis, from: &Position, to: &Position) -> f64 {
    let change = (to[axis] - from[axis]).abs();
    if axis.is_rotary() { change } else { change.to_radians() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_increase_in_time_and_turn_by_a_sixth_at_most() {
        let mut turned = Position::default();
        turned[Axis::C] = 2.0 * FRAC_PI_2;
        let positions = vec![Position::default(), turned, turned];
        let motion =
            Motion { places: vec![0.0, 1.0, 2.0], times_s: vec![0.0, 3.0, 3.0], positions, last_keys: vec![1, 2] };
        let keys = Keys::of(&motion);
        // Half a turn is three sixths: keys at 0, 1, 2 and 3 s, and one that takes no time.
        assert_eq!(keys.times, [0.0, 1.0, 2.0, 3.0, 3.0_f32.next_up()]);
        assert!((keys.positions[1][Axis::C] - FRAC_PI_3).abs() < 1e-15);
        assert_eq!(keys.places[3..], [1.0, 2.0]);
    }

    #[test]
    fn quaternions_keep_to_one_side() {
        let turned = signed_alike(vec![[0.0, 0.0, 0.1, 0.99], [0.0, 0.0, -0.2, -0.98], [0.0, 0.0, 0.3, 0.95]]);
        assert!(turned.iter().all(|q| q[3] > 0.0));
    }
}
