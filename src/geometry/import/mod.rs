//! SHIM
use crate::geometry::{Mesh, Point};
/// shim
#[derive(Debug, Clone, Copy, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// shim
    #[default]
    Mm,
    /// shim
    M,
}
/// shim
pub fn load(path: &std::path::Path, _: Unit) -> Result<Mesh, Box<dyn std::error::Error + Send + Sync>> {
    let m = stl_io::read_stl(&mut std::fs::File::open(path)?)?;
    let v = m.vertices.iter().map(|v| Point::new(v[0] as f64, v[1] as f64, v[2] as f64)).collect();
    Ok(Mesh::new(v, m.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect())?)
}
