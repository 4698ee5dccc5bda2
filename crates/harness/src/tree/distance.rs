//! The distance between two meshes, by branch and bound over pairs of nodes with a lower bound of their distance.
//!
//! E. Larsen, S. Gottschalk, M. C. Lin, D. Manocha, "Fast Proximity Queries with Swept Sphere Volumes", TR99-018, 1999, section 4, with the
//! bound of each volume ([`Shape::gap_mm`]) in place of that of the swept sphere. Of all waiting pairs, the pair with the smallest bound is
//! opened first (G. R. Hjaltason, H. Samet, "Distance Browsing in Spatial Databases", ACM TODS 24(2), 1999). No pair with a bound above the
//! distance is then opened.

use super::Tree;
use super::traverse::open;
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, Triangle, certified, triangle_distance};
use crate::volume::Shape;
pub use obbtree::engine::proximity::Proximity;

/// The largest `f32` that is not above `x`.
fn rounded_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The distance between the meshes, mm, if it is below `below_mm`; otherwise infinity. 0 when triangles touch. With [`Proximity::keeping`], a
/// lower bound of it. For volumes that are not safe, the answer may be too large.
pub fn distance_mm<S: Shape>(
    a: &Tree<S>,
    b: &Tree<S>,
    a_from_b: &Isometry,
    below_mm: f64,
    proximity: &mut Proximity,
) -> f64 {
    let pose = S::pose(a_from_b);
    let placement = Placement::new(a_from_b);
    let kept = proximity.kept();
    let Proximity { queue, nearest, .. } = proximity;
    // What is told of it; infinite where it is for sure not below what is known.
    let between = |i: usize, moved: &Triangle, least: f64| {
        let still = &a.triangles[i];
        if triangle_distance::exceeds(still, moved, least * least) {
            f64::INFINITY
        } else if certified::touch(still, moved) {
            0.0
        } else {
            kept * triangle_distance::squared(still, moved).sqrt()
        }
    };
    let gap = |(i, j): (u32, u32)| a.nodes[i as usize].volume.gap_mm(&b.nodes[j as usize].volume, &pose);
    let mut least = below_mm;
    if let Some((i, j)) = *nearest {
        least = least.min(between(i as usize, &placement.triangle(&b.triangles[j as usize]), least));
    }
    queue.clear();
    queue.push(rounded_down(gap((0, 0))), (0, 0));
    while let Some(at) = queue.pop_below(least) {
        let (node_a, node_b) = (&a.nodes[at.0 as usize], &b.nodes[at.1 as usize]);
        let Some(next) = open(node_a, node_b, at) else {
            for j in node_b.range() {
                let moved = placement.triangle(&b.triangles[j]);
                for i in node_a.range() {
                    let distance = between(i, &moved, least);
                    if distance < least {
                        (least, *nearest) = (distance, Some((i as u32, j as u32)));
                    }
                }
            }
            continue;
        };
        for pair in next {
            let bound = gap(pair);
            if bound < least {
                queue.push(rounded_down(bound), pair);
            }
        }
    }
    if least < below_mm { least } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::obb_area::ObbArea;
    use crate::volume::sphere_ritter::SphereRitter;
    use obbtree::cases::meshes;
    use parry3d_f64::math::Pose;
    use parry3d_f64::query;
    use parry3d_f64::shape::TriMesh;

    fn along_a_path<V: BoundingVolume>(leaf: u8) {
        let (torus, tool) = (meshes::torus(12.0, 4.0, 14, 7), meshes::stepped_tool(8, 4));
        let build = |mesh: &crate::geometry::Mesh| {
            Tree::build(&V::fit, &mesh.triangles(), Policy { leaf, ..Policy::own(SplitRule::AreaMean) })
        };
        let parry = |mesh: &crate::geometry::Mesh| {
            TriMesh::new(mesh.vertices().iter().map(|p| p.coords.into()).collect(), mesh.faces().to_vec()).unwrap()
        };
        let (a, b, parry_a, parry_b) = (build(&torus), build(&tool), parry(&torus), parry(&tool));
        let mut proximity = Proximity::default();
        let mut touching = 0;
        for step in 0..60 {
            let t = f64::from(step);
            let shift = nalgebra::Vector3::new(60.0 - 1.5 * t, 3.0, 0.2 * t - 5.0);
            let pose = Isometry::new(shift, nalgebra::Vector3::new(0.02 * t, 0.3, 0.1));
            let found = distance_mm(&a, &b, &pose, f64::INFINITY, &mut proximity);
            let fresh = distance_mm(&a, &b, &pose, f64::INFINITY, &mut Proximity::default());
            let expected = query::distance(&Pose::IDENTITY, &parry_a, &pose.into(), &parry_b).unwrap().distance;
            assert!((found - expected).abs() < 1e-6, "step {step}: {found}, parry {expected}");
            assert_eq!(found, fresh, "step {step}");
            let bound = distance_mm(&a, &b, &pose, f64::INFINITY, &mut Proximity::keeping(0.75));
            assert!((0.75 * found..=found).contains(&bound), "step {step}: {bound} of {found}");
            let cut_off = distance_mm(&a, &b, &pose, 5.0, &mut proximity);
            assert_eq!(cut_off, if found < 5.0 { found } else { f64::INFINITY }, "step {step}");
            touching += u32::from(found == 0.0);
        }
        assert!((5..55).contains(&touching), "{touching}");
    }

    #[test]
    fn bounds_are_rounded_down() {
        for x in [0.0, 0.1, 0.3, 1.0, 1e-300, 123.456] {
            let down = rounded_down(x);
            assert!(down >= 0.0 && f64::from(down) <= x && f64::from(down.next_up()) > x, "{x}");
        }
    }

    #[test]
    fn distances_are_parrys_fresh_or_warm() {
        along_a_path::<ObbArea>(1);
        along_a_path::<ObbArea>(4);
        along_a_path::<SphereRitter>(1);
    }
}
