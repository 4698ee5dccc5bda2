//! Meshes and colliders as serde has them: vertices and faces. What is read is checked, and the tree of a collider built again.

use crate::collider::Collider;
use crate::mesh::Mesh;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

#[derive(Serialize, Deserialize)]
#[serde(rename = "Mesh")]
struct Parts<'a> {
    vertices: Vec<[f64; 3]>,
    faces: Cow<'a, [[u32; 3]]>,
}

impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let vertices = self.vertices().iter().map(|&p| p.into()).collect();
        Parts { vertices, faces: self.faces().into() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Mesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Parts { vertices, faces } = Parts::deserialize(deserializer)?;
        Self::new(vertices, faces.iter().copied()).map_err(D::Error::custom)
    }
}

impl Serialize for Collider {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.mesh().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Collider {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Mesh::deserialize(deserializer).map(Self::new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;

    #[test]
    fn what_is_written_is_read_again_and_checked() {
        let mesh = Mesh::new([[0.25, 0.5, 3.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1e9]], [[0, 1, 2]]).unwrap();
        let text = serde_json::to_string(&mesh).unwrap();
        assert_eq!(serde_json::from_str::<Mesh>(&text).unwrap(), mesh);
        let collider: Collider = serde_json::from_str(&text).unwrap();
        assert_eq!(serde_json::to_string(&collider).unwrap(), text);
        let nearest = collider.distance(&collider, &Isometry3::translation(0.0, 5.0, 1e10)).unwrap();
        let again = serde_json::from_str(&serde_json::to_string(&nearest).unwrap()).unwrap();
        assert_eq!(nearest, again);
        let error = serde_json::from_str::<Mesh>(r#"{"vertices": [[0, 0, 0]], "faces": [[0, 0, 1]]}"#).unwrap_err();
        assert!(error.to_string().contains("face 0 names vertex 1"), "{error}");
    }
}
