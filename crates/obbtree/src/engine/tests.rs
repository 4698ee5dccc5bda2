//! The wide tree against the exact truth, on every instruction set this machine has.

use super::aligned::Aligned;
use super::ball::Ball;
use super::lanes::{DOUBLES, DoubleLanes, Lanes, Machine, Simd, WIDTH, Work};
use super::node::Node;
use super::oriented::Oriented;
use super::traverse::{Scratch, all, first};
use super::*;
use crate::cases::{Cases, Draw, meshes};
use crate::engine::geometry::grid::{Placement, STEP_MM};
use crate::engine::geometry::{GridMesh, Isometry, Point, Triangle, Vector, exact};
use proptest::prelude::*;

/// Around a cube from 10 to 12 along each axis: √3 mm and 10⁻¹² of that and of the farthest corner's 12√3 mm, which are 10⁻¹² more as well.
#[test]
fn the_ball_and_the_reach_of_a_mesh_are_widened_by_their_rounding() {
    let cube = meshes::cuboid(2.0, 2.0, 2.0);
    let vertices = cube.vertices().iter().map(|vertex| vertex + Vector::repeat(11.0)).collect();
    let tree = WideTree::<Oriented>::build(&GridMesh::new(vertices, cube.faces().to_vec()).unwrap());
    let (root, (centre, radius)) = (3.0_f64.sqrt(), tree.ball);
    assert_eq!(centre, Point::new(11.0, 11.0, 11.0));
    assert!((radius - root - 13.0 * root * 1e-12).abs() < 1e-15, "{radius}");
    assert!((tree.reach - 12.0 * root - 12.0 * root * 1e-12).abs() < 1e-14, "{}", tree.reach);
    let other = WideTree::<Oriented>::build(&cube);
    assert!((other.reach_with(&tree) - 13.0 * root).abs() < 1e-9);
}

#[test]
fn an_instruction_set_is_found_by_its_name() {
    for simd in Simd::available() {
        assert_eq!(Simd::named(simd.name()), Some(simd));
    }
    assert_eq!((Simd::named("portable").map(Simd::name), Simd::named("")), (Some("portable"), None));
}

/// For `f32` and `f64` in which lanes 0, 1, 2 and so on exceed 2, and the lesser and the greater of both. Of numbers that go up and such that go down the lesser
/// ones, and the least of some of them.
struct Compared;

impl Work for Compared {
    type Output = (u32, [[f32; WIDTH]; 2], u8, [[f64; DOUBLES]; 2], [f32; WIDTH], [f32; 3]);

    #[inline(always)]
    fn run<M: Machine>(self) -> Self::Output {
        let numbers: [f32; WIDTH] = std::array::from_fn(|lane| if lane == 5 { f32::NAN } else { lane as f32 });
        let two = M::Single::all(2.0);
        let (mut bits, mut less, mut more) = (0, [[0.0; WIDTH]; 2], [[0.0; WIDTH]; 2]);
        for part in 0..M::Single::PARTS {
            let x = M::Single::load(part, |_| &numbers);
            bits |= x.exceeds(two) << (part * WIDTH / M::Single::PARTS);
            x.min(two).store(part, &mut less);
            x.max(two).store(part, &mut more);
        }
        let (x, two) = (M::Double::load(&[1.0, 2.0, 3.0, f64::NAN]), M::Double::load(&[2.0; DOUBLES]));
        let mut joined: [f32; WIDTH] = std::array::from_fn(|lane| lane as f32);
        let down = std::array::from_fn(|lane| 7.0 - lane as f32);
        M::join(&mut joined, &down);
        let least = [0b1111_1111, 0b0001_1000, 0].map(|places| M::least_of(&down, places));
        let wide = [x.min(two).stored(), x.max(two).stored()];
        (bits & 0xff, [less[0], more[0]], x.exceeds(two), wide, joined, least)
    }
}

#[test]
fn only_what_is_larger_exceeds_and_what_is_no_number_does_not() {
    for simd in Simd::available() {
        let (bits, [less, more], wide_bits, wide, joined, least) = simd.run(Compared);
        assert_eq!(joined, [0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.0], "{}", simd.name());
        assert_eq!(least, [0.0, 3.0, f32::INFINITY], "{}", simd.name());
        assert_eq!((bits, wide_bits), (0b1101_1000, 0b100), "{}", simd.name());
        assert_eq!((&less[..5], &more[..5]), (&[0.0, 1.0, 2.0, 2.0, 2.0][..], &[2.0, 2.0, 2.0, 3.0, 4.0][..]));
        assert_eq!(wide, [[1.0, 2.0, 2.0, 2.0], [2.0, 2.0, 3.0, 2.0]], "{}", simd.name());
    }
}

/// Every pair of faces that touch exactly, sorted.
fn truth(a: &GridMesh, b: &GridMesh, a_from_b: &Isometry) -> Vec<(u32, u32)> {
    let placement = Placement::new(a_from_b);
    let moved: Vec<Triangle> = b.triangles().iter().map(|t| placement.triangle(t)).collect();
    let mut contacts = Vec::new();
    for (still, face_a) in a.triangles().iter().zip(0..) {
        contacts.extend(moved.iter().zip(0..).filter(|(t, _)| exact::touch(still, t)).map(|(_, f)| (face_a, f)));
    }
    contacts
}

/// On every instruction set the verdict and the list are the truth's. Where products are fused, all counts are equal; elsewhere the volume tests
/// are within a hundredth in total.
fn are_exact<V: WideVolume>() {
    let cases = Cases::new();
    let trees: Vec<WideTree<V>> = cases.subjects.iter().map(|subject| WideTree::build(&subject.mesh)).collect();
    let mut scratch = Scratch::default();
    let (mut touching, mut fused, mut plain) = (0, 0, 0);
    for case in &cases.cases {
        let (a, b, pose) = (&trees[case.a], &trees[case.b], &case.a_from_b);
        let (mesh_a, mesh_b) = cases.meshes(case);
        let expected = truth(mesh_a, mesh_b, pose);
        touching += usize::from(!expected.is_empty());
        let mut counts = Vec::new();
        for simd in Simd::available() {
            assert_eq!(first(a, b, pose, simd, &mut scratch), !expected.is_empty(), "{}", simd.name());
            let of_first = scratch.counts();
            assert_eq!(all(a, b, pose, simd, &mut scratch), expected, "{}", simd.name());
            let of_all = scratch.counts();
            if simd.fuses() {
                counts.push((of_first, of_all));
            } else {
                plain += of_first.volume_tests + of_all.volume_tests;
            }
        }
        assert!(counts.iter().all(|c| *c == counts[0]), "{counts:?}");
        fused += counts.first().map_or(0, |(of_first, of_all)| of_first.volume_tests + of_all.volume_tests);
    }
    assert!(plain > 0 && (fused == 0 || plain.abs_diff(fused) <= plain / 100), "{plain} {fused}");
    assert!(touching > cases.cases.len() / 3 && touching < 2 * cases.cases.len() / 3);
}

#[test]
fn the_instruction_set_in_use_stays_the_one_in_use() {
    let used = Simd::in_use();
    for simd in Simd::available() {
        assert_eq!(simd.choose(), simd == used);
        assert_eq!(Simd::in_use(), used);
    }
}

#[test]
fn verdicts_and_lists_are_the_exact_truth_on_every_instruction_set_and_counts_agree() {
    are_exact::<Oriented>();
    are_exact::<Aligned>();
    are_exact::<Ball>();
}

/// Triangles are never opened, however large they are beside the other mesh.
#[test]
fn a_triangle_is_larger_than_all_of_the_other_mesh() {
    let torus = meshes::torus(2.0, 0.5, 12, 8);
    let corner = |x: f64, y: f64| Point::new(x, y, 0.0);
    let wall = GridMesh::from_triangles(&[Triangle::new(corner(-90.0, -90.0), corner(90.0, -90.0), corner(0.0, 90.0))])
        .unwrap();
    let (torus, wall) = (WideTree::<Oriented>::build(&torus), WideTree::build(&wall));
    for simd in Simd::available() {
        for (height, touches) in [(0.4, true), (0.6, false)] {
            let pose = Isometry::translation(0.0, 0.0, height);
            for (a, b, pose) in [(&torus, &wall, pose.inverse()), (&wall, &torus, pose)] {
                assert_eq!(first(a, b, &pose, simd, &mut Scratch::default()), touches, "{}", simd.name());
                assert_eq!(all(a, b, &pose, simd, &mut Scratch::default()).is_empty(), !touches);
                let mut proximity = proximity::Proximity::default();
                let distance = distance::distance_mm(a, b, &pose, simd, f64::INFINITY, &mut proximity);
                assert!((distance - if touches { 0.0 } else { 0.1 }).abs() < 1e-6, "{distance}");
            }
        }
    }
}

/// A mesh of triangles that are points, mm.
fn points(points: &[[f64; 3]]) -> GridMesh {
    let triangles: Vec<Triangle> = points.iter().map(|&p| Triangle { corners: [Point::from(p); 3] }).collect();
    GridMesh::from_triangles(&triangles).unwrap()
}

/// The wide trees of all volumes say on every instruction set that these meshes touch.
fn touch(a: &GridMesh, b: &GridMesh, pose: &Isometry) {
    fn says<V: WideVolume>(a: &GridMesh, b: &GridMesh, pose: &Isometry) {
        let (a, b) = (WideTree::<V>::build(a), WideTree::build(b));
        for simd in Simd::available() {
            assert!(
                first(&a, &b, pose, simd, &mut Scratch::default()),
                "{}, {}",
                std::any::type_name::<V>(),
                simd.name()
            );
        }
    }
    assert!(!truth(a, b, pose).is_empty());
    says::<Oriented>(a, b, pose);
    says::<Aligned>(a, b, pose);
    says::<Ball>(a, b, pose);
}

/// A corner 0.499 steps off along each axis is snapped onto the other: 0.499 · √3 · 2⁻²⁶ = 1.29e-8 mm, and volumes of no extent around either.
#[test]
fn points_touch_that_meet_by_snapping_alone() {
    let off = Vector::repeat(0.499 * STEP_MM);
    for at in [[0.0; 3], [1.0, 2.0, 3.0], [-1e-7, 0.0, 1e-6]] {
        let a = points(&[at]);
        let pose = Isometry::from_parts((a.vertices()[0].coords + off).into(), nalgebra::UnitQuaternion::identity());
        touch(&a, &points(&[[0.0; 3]]), &pose);
        // With a node: one more point a step farther.
        touch(&a, &points(&[[0.0; 3], [STEP_MM, 0.0, 0.0]]), &pose);
    }
}

/// A quarter turn about z by a quaternion 1 + 1e-7 long. The leaves make it rigid and put (1000, 0, 0) at (0, 1000, 0) mm; the engine takes it as it
/// is, by the matrix to (0, 1000.0002, 0), by the quaternion likewise 2.8e-4 mm off: the slack of `f32` at this size is 3e-6 mm at most.
#[test]
fn meshes_far_from_their_origins_touch_at_a_pose_that_stretches() {
    let turn = nalgebra::Quaternion::new(0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt());
    let rotation = nalgebra::UnitQuaternion::new_unchecked(turn * (1.0 + 1e-7));
    let pose = Isometry::from_parts(nalgebra::Translation3::identity(), rotation);
    let moved = Placement::new(&pose).point(&Point::new(1000.0, 0.0, 0.0));
    assert!((rotation.to_rotation_matrix() * Vector::new(1000.0, 0.0, 0.0) - moved.coords).norm() > 1.9e-4);
    assert!((rotation * Vector::new(1000.0, 0.0, 0.0) - moved.coords).norm() > 1.9e-4);
    let a = points(&[moved.into()]);
    touch(&a, &points(&[[1000.0, 0.0, 0.0]]), &pose);
    touch(&a, &points(&[[1000.0, 0.0, 0.0], [1001.0, 0.0, 0.0]]), &pose);
}

/// A mesh of the same shape in another unit, as near as the grid allows.
fn scaled(mesh: &GridMesh, factor: f64) -> GridMesh {
    GridMesh::new(mesh.vertices().iter().map(|p| p * factor).collect(), mesh.faces().to_vec()).unwrap()
}

#[test]
fn the_verdict_does_not_depend_on_the_unit() {
    // Some mm, written in metres and in micrometres: in relation to the part the grid's step differs by a factor of a million.
    let (torus, tool) = (scaled(&meshes::torus(12.0, 4.0, 40, 20), 0.05), scaled(&meshes::stepped_tool(16, 8), 0.05));
    let (a, b) = (WideTree::<Oriented>::build(&torus), WideTree::build(&tool));
    let units = [1e-3, 1.0, 1e3].map(|factor| {
        let (a, b) = (scaled(&torus, factor), scaled(&tool, factor));
        (factor, WideTree::<Oriented>::build(&a), WideTree::build(&b))
    });
    let (mut touching, mut compared) = (0, 0);
    for step in 0..200 {
        let mut draw = Draw::new(5, &["units"], step);
        let pose = Isometry::from_parts((draw.in_ball() * 2.5).into(), draw.rotation());
        // Poses that a micrometre either way would change depend on how the grid cuts off, not on the engine.
        let near = [-1e-3, 1e-3].map(|shift| {
            let moved = Isometry::translation(shift, shift, shift) * pose;
            first(&a, &b, &moved, Simd::in_use(), &mut Scratch::default())
        });
        if near[0] != near[1] {
            continue;
        }
        for (factor, a, b) in &units {
            let mut pose = pose;
            pose.translation.vector *= *factor;
            let verdict = first(a, b, &pose, Simd::in_use(), &mut Scratch::default());
            assert_eq!(verdict, near[0], "pose {step}, factor {factor}");
        }
        compared += 1;
        touching += usize::from(near[0]);
    }
    assert!(compared > 150 && touching > 20 && touching < 130, "{touching} of {compared}");
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let mesh = meshes::torus(60.0, 20.0, 120, 60); // 14 400 triangles: some ranges are built apart
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", WideTree::<Oriented>::build(&mesh)))
    };
    assert!(build(1) == build(3));
}

#[test]
fn a_built_tree_is_well_formed_and_its_boxes_hold_their_contents() {
    for mesh in [meshes::torus(60.0, 20.0, 120, 60), meshes::cuboid(1.0, 2.0, 3.0), meshes::stepped_tool(24, 12)] {
        fn is_sound<V: WideVolume>(mesh: &GridMesh) {
            let tree = WideTree::<V>::build(mesh);
            assert_eq!(
                (tree.check_structure(), tree.check_containment(0.0)),
                (Ok(()), Ok(())),
                "{}",
                std::any::type_name::<V>()
            );
        }
        is_sound::<Oriented>(&mesh);
        is_sound::<Aligned>(&mesh);
        is_sound::<Ball>(&mesh);
    }
}

#[test]
fn a_tree_takes_what_its_nodes_triangles_vertices_and_faces_take() {
    let tree = WideTree::<Oriented>::build(&meshes::stepped_tool(24, 12));
    assert!(!tree.is_empty());
    assert_eq!(tree.bytes(), 320 * tree.nodes.len() + 24 * tree.vertices.len() + (12 + 4) * tree.len());
}

#[test]
fn a_broken_tree_is_found() {
    use crate::engine::validate::TreeFault;
    let tree = WideTree::<Oriented>::build(&meshes::stepped_tool(24, 12));
    let mut broken = tree.clone();
    broken.nodes[1].volumes[6][0] *= 0.99;
    assert!(matches!(broken.check_containment(0.0), Err(TreeFault::Outside { node: 1, .. })));
    let mut broken = tree.clone();
    broken.nodes[1].first_node += 1;
    assert!(matches!(broken.check_structure(), Err(TreeFault::Division { .. })));
    // Each number of a node that others contradict is found at that node.
    let inner = tree.nodes[1].inner;
    assert!(inner >= 2 && tree.nodes[1].count == 8, "{inner}");
    let corrupt: [fn(&mut Node<Oriented>); 4] = [
        |node| (node.inner, node.count) = (node.inner, node.inner - 1),
        |node| node.paired = node.count - node.inner + 1,
        |node| node.count = 9,
        |node| (node.inner, node.count, node.paired) = (1, 1, 0),
    ];
    for corrupt in corrupt {
        let mut broken = tree.clone();
        corrupt(&mut broken.nodes[1]);
        assert_eq!(broken.check_structure(), Err(TreeFault::Division { node: 1 }));
    }
    assert_eq!(TreeFault::Division { node: 1 }.to_string(), "node 1: its children do not divide its triangles");
    // Two leaves with the same triangles leave others out.
    let mut broken = tree.clone();
    let leaves: Vec<usize> = (1..tree.nodes.len()).filter(|&at| tree.nodes[at].inner == 0).collect();
    broken.nodes[leaves[0]].first_triangle += 1;
    assert_eq!(broken.check_structure(), Err(TreeFault::Faces));
    let mut broken = tree;
    broken.faces[3] = broken.faces[4];
    assert_eq!(broken.check_structure(), Err(TreeFault::Faces));
}

fn corner() -> impl Strategy<Value = [f64; 3]> {
    prop_oneof![prop::array::uniform3(-1.0..1.0_f64), prop::array::uniform3((-2..=2_i32).prop_map(f64::from))]
}

fn mesh(triangles: usize) -> impl Strategy<Value = GridMesh> {
    prop::collection::vec(prop::array::uniform3(corner()), 1..triangles).prop_map(|triangles| {
        let triangles: Vec<Triangle> =
            triangles.into_iter().map(|corners| Triangle { corners: corners.map(Point::from) }).collect();
        GridMesh::from_triangles(&triangles).unwrap()
    })
}

fn is_the_list<V: WideVolume>(
    a: &GridMesh,
    b: &GridMesh,
    pose: &Isometry,
    list: &Vec<(u32, u32)>,
) -> Result<(), TestCaseError> {
    let (a, b) = (WideTree::<V>::build(a), WideTree::build(b));
    for simd in Simd::available() {
        prop_assert_eq!(&all(&a, &b, pose, simd, &mut Scratch::default()), list);
        prop_assert_eq!(first(&a, &b, pose, simd, &mut Scratch::default()), !list.is_empty());
    }
    Ok(())
}

proptest! {
    /// Random and lattice triangles, with and without area, turned or not: the exact list on every instruction set.
    #[test]
    fn lists_are_exact_on_random_and_grid_triangles(
        a in mesh(40),
        b in mesh(40),
        shift in corner(),
        turn in prop_oneof![Just([0.0; 3]), prop::array::uniform3(-3.0..3.0_f64)],
    ) {
        let pose = Isometry::new(Vector::from(shift), Vector::from(turn));
        let expected = truth(&a, &b, &pose);
        is_the_list::<Oriented>(&a, &b, &pose, &expected)?;
        is_the_list::<Aligned>(&a, &b, &pose, &expected)?;
        is_the_list::<Ball>(&a, &b, &pose, &expected)?;
    }
}
