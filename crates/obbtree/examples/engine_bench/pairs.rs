//! Pairs of meshes: read from folders of arrays, or made.

use crate::Pair;
use obbtree::cases::meshes::{moved, revolve, stepped_tool, torus};
use obbtree::engine::geometry::{GridMesh, Isometry, Point, Triangle, Vector};
use obbtree::nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use std::error::Error;
use std::path::Path;

/// Poses that came with a pair, and how far apart the meshes are there; 0 colliding, 1 near, 2 medium, 3 far.
#[derive(Default)]
pub struct Recorded {
    /// Mesh `b` in the frame of `a`.
    pub poses: Vec<Isometry>,
    /// One for each pose.
    pub strata: Vec<u8>,
    /// First pose of each run of poses along a program.
    pub starts: Vec<usize>,
    /// Whether poses are fine steps along a program.
    pub is_path: bool,
}

/// The numbers of an NPY file (version 1.0, little endian, C order), by their width in bytes.
fn array<const N: usize, T>(path: &Path, number: impl Fn([u8; N]) -> T) -> Result<Vec<T>, Box<dyn Error>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let length = bytes.get(8..10).ok_or_else(|| format!("{}: not an NPY file", path.display()))?;
    let start = 10 + usize::from(u16::from_le_bytes([length[0], length[1]]));
    Ok(bytes[start..].as_chunks().0.iter().map(|bytes| number(*bytes)).collect())
}

fn mesh(folder: &Path, name: &str) -> Result<GridMesh, Box<dyn Error>> {
    let vertices = array(&folder.join(format!("{name}_vertices.npy")), f64::from_le_bytes)?;
    let faces = array(&folder.join(format!("{name}_faces.npy")), u32::from_le_bytes)?;
    let points = vertices.as_chunks::<3>().0.iter().map(|&p| Point::from(p)).collect();
    Ok(GridMesh::new(points, faces.as_chunks::<3>().0.to_vec())?)
}

/// The pair of a folder, with its poses.
pub fn read(folder: &Path) -> Result<(Pair, Recorded), Box<dyn Error>> {
    let numbers = array(&folder.join("poses.npy"), f64::from_le_bytes)?;
    let poses = numbers.as_chunks::<12>().0.iter().map(|m| {
        let rotation = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Isometry::from_parts(Translation3::new(m[3], m[7], m[11]), turn)
    });
    let chunks = array(&folder.join("chunks.npy"), u32::from_le_bytes)?;
    let recorded = Recorded {
        poses: poses.collect(),
        strata: array(&folder.join("stratum.npy"), |[x]: [u8; 1]| x)?,
        starts: chunks.iter().step_by(2).map(|&first| first as usize).collect(),
        is_path: folder.components().any(|part| part.as_os_str() == "path"),
    };
    let names: Vec<_> = folder.iter().rev().take(2).map(|part| part.to_string_lossy()).collect();
    let kind = if recorded.is_path { ".path" } else { "" };
    let name = format!("{}:{}{kind}", names.get(1).map_or("", |name| name), names[0]);
    Ok((Pair { name, a: mesh(folder, "a")?, b: mesh(folder, "b")? }, recorded))
}

/// A flat sheet about the origin of `n` by `n` squares with edges of `square` mm, its middle square left out if it `has_hole` of so many squares.
fn sheet(n: u32, square: f64, hole: u32) -> GridMesh {
    let half = 0.5 * f64::from(n) * square;
    let corner = |i: u32, j: u32| Point::new(f64::from(i) * square - half, f64::from(j) * square - half, 0.0);
    let inside = |i: u32| (n - hole) / 2 <= i && i < (n + hole) / 2;
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in (0..n).filter(|&j| !(inside(i) && inside(j))) {
            triangles.push(Triangle::new(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)));
            triangles.push(Triangle::new(corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)));
        }
    }
    GridMesh::from_triangles(&triangles).expect("a sheet is in range")
}

/// A closed ring about z from radius `inner` to `outer`, mm, from 0 to `height`.
fn ring(inner: f64, outer: f64, height: f64, bands: u32, steps: u32) -> GridMesh {
    let at = |i: u32| height * f64::from(i) / f64::from(bands);
    let mut profile: Vec<[f64; 2]> = (0..=bands).map(|i| [outer, at(i)]).collect();
    profile.extend((0..=bands).rev().map(|i| [inner, at(i)]));
    revolve(&profile, true, steps)
}

/// A closed cylinder about z, its ends fans of needles.
fn cylinder(radius: f64, height: f64, bands: u32, steps: u32) -> GridMesh {
    let mut profile = vec![[0.0, 0.0]];
    profile.extend((0..=bands).map(|i| [radius, height * f64::from(i) / f64::from(bands)]));
    profile.push([0.0, height]);
    revolve(&profile, false, steps)
}

/// Pairs that are hard in one way each.
pub fn made() -> Vec<(Pair, Recorded)> {
    let pair = |name: &str, a, b| (Pair { name: name.into(), a, b }, Recorded::default());
    let down = |mesh: &GridMesh, z: f64| moved(mesh, 1.0, &Isometry::translation(0.0, 0.0, z));
    let turned = Isometry::rotation(Vector::new(0.3, -1.1, 0.7));
    vec![
        pair("torus:tool", torus(60.0, 20.0, 120, 60), stepped_tool(64, 60)),
        pair("torus-turned:torus", moved(&torus(60.0, 20.0, 120, 60), 1.0, &turned), torus(40.0, 9.0, 90, 40)),
        pair("needles:needles", cylinder(30.0, 120.0, 1, 720), cylinder(12.0, 150.0, 1, 360)),
        pair("bore:shaft", ring(20.0, 40.0, 60.0, 30, 180), down(&cylinder(19.5, 100.0, 50, 180), -20.0)),
        pair("bore-needles:shaft-needles", ring(20.0, 40.0, 60.0, 1, 360), down(&cylinder(19.5, 100.0, 1, 360), -20.0)),
        pair("flat-sheet:sheet", sheet(60, 1.0, 0), sheet(40, 0.7, 0)),
        pair("flat-hole:sheet", sheet(60, 1.0, 20), sheet(20, 0.6, 0)),
        pair("flat-ring:cylinder", ring(20.0, 40.0, 30.0, 1, 360), cylinder(19.0, 30.0, 1, 360)),
        pair("flat-tool:sheet", stepped_tool(96, 24), sheet(80, 1.0, 0)),
    ]
}
