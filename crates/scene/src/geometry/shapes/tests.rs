//! Properties of every shape: soundness over random parameters, volumes of closed form, and the effect of grading.

use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

fn parse(text: &str) -> Shape {
    toml::from_str(text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn at(density: f64, grading: f64) -> Tessellation {
    Tessellation { grading, density }
}

/// One shape of each kind, with its volume, mm³, if that has a closed form.
fn gallery() -> Vec<(&'static str, Shape, Option<f64>)> {
    let rounded_box = {
        let ([a, b, c], r) = ([30.0, 24.0, 18.0], 4.0);
        let [p, q, s] = [a - 2.0 * r, b - 2.0 * r, c - 2.0 * r];
        // Core, six slabs, twelve quarter cylinders, eight eighths of a ball (Steiner).
        p * q * s + 2.0 * r * (p * q + q * s + s * p) + PI * r * r * (p + q + s) + 4.0 / 3.0 * PI * r.powi(3)
    };
    [
        ("cylinder", "kind = 'cylinder'\nradius_mm = 25\nheight_mm = 90", Some(PI * 625.0 * 90.0)),
        ("tube", "kind = 'cylinder'\nradius_mm = 25\nbore_mm = 15\nheight_mm = 90", Some(PI * 400.0 * 90.0)),
        (
            "cone",
            "kind = 'cone'\nbottom_radius_mm = 12\ntop_radius_mm = 0\nheight_mm = 20",
            Some(PI * 144.0 * 20.0 / 3.0),
        ),
        (
            "frustum",
            "kind = 'cone'\nbottom_radius_mm = 2\ntop_radius_mm = 40\nheight_mm = 20",
            Some(PI * 20.0 / 3.0 * (4.0 + 80.0 + 1600.0)),
        ),
        ("sphere", "kind = 'sphere'\nradius_mm = 14", Some(4.0 / 3.0 * PI * 14.0_f64.powi(3))),
        ("capsule", "kind = 'capsule'\nradius_mm = 9\nlength_mm = 30", Some(4.0 / 3.0 * PI * 729.0 + PI * 81.0 * 30.0)),
        ("torus", "kind = 'torus'\nring_radius_mm = 60\ntube_radius_mm = 8", Some(2.0 * PI * PI * 60.0 * 64.0)),
        ("box", "kind = 'rounded-box'\nsize_mm = [30, 24, 18]", Some(30.0 * 24.0 * 18.0)),
        ("rounded-box", "kind = 'rounded-box'\nsize_mm = [30, 24, 18]\nfillet_mm = 4", Some(rounded_box)),
        (
            "drilled-box",
            "kind = 'rounded-box'
             size_mm = [100, 80, 60]
             fillet_mm = 3
             holes = [
                 { face = '+z', at_mm = [30, 20], radius_mm = 5, depth_mm = 20, point_deg = 118 },
                 { face = '+z', at_mm = [-30, 20], radius_mm = 5, counterbore = { radius_mm = 9, depth_mm = 6 } },
                 { face = '-z', at_mm = [30, -20], radius_mm = 5, depth_mm = 12 },
                 { face = '+x', at_mm = [10, 0], radius_mm = 6, depth_mm = 10 },
                 { face = '-y', at_mm = [0, 5], radius_mm = 6, depth_mm = 10 },
             ]",
            None,
        ),
        (
            "pattern",
            "kind = 'extrude'
             outline_mm = [[0, 0, 4], [80, 0, 4], [80, 40, 4], [0, 40, 4]]
             holes = [
                 { at_mm = [20, 20], radius_mm = 5 }, { at_mm = [40, 20], radius_mm = 5 },
                 { outline_mm = [[54, 14], [66, 14], [66, 26], [54, 26]] },
             ]
             height_mm = 12",
            Some(12.0 * (3200.0 - (4.0 - PI) * 16.0 - 2.0 * PI * 25.0 - 144.0)),
        ),
        (
            "rimmed",
            "kind = 'extrude'
             outline_mm = [[0, 0, 6], [80, 0, 6], [80, 40, 6], [50, 40], [50, 25, 3], [30, 25, 3], [30, 40], [0, 40, 6]]
             holes = [{ at_mm = [15, 15], radius_mm = 5 }]
             height_mm = 20
             top = { fillet_mm = 2 }
             bottom = { chamfer_mm = 1 }",
            None,
        ),
        (
            "centre",
            "kind = 'revolve'
             profile_mm = [[0, 0], [15, 0, 1], [15, 40, 2], [8, 40, 2], [8, 50], [0, 64]]",
            None,
        ),
        ("screw", "kind = 'thread'\nradius_mm = 6\npitch_mm = 1.75\nlength_mm = 20", None),
        ("lead screw", "kind = 'thread'\nradius_mm = 12\npitch_mm = 5\nlength_mm = 60\nform = 'trapezoidal'", None),
        (
            "bolt circle",
            "kind = 'compound'
             [[parts]]
             shape = { kind = 'cylinder', radius_mm = 40, height_mm = 10, chamfer_mm = 1 }
             [[parts]]
             shape = { kind = 'sphere', radius_mm = 3 }
             at = { xyz_mm = [30, 0, 12], rpy_deg = [0, 90, 0] }
             repeat = { kind = 'around', count = 6 }",
            None,
        ),
    ]
    .into_iter()
    .map(|(name, text, volume)| (name, parse(text), volume))
    .collect()
}

/// Largest over smallest triangle area.
fn area_ratio(mesh: &Mesh) -> f64 {
    let areas = mesh.triangles().iter().map(super::super::Triangle::area).collect::<Vec<_>>();
    areas.iter().fold(0.0_f64, |a, &b| a.max(b)) / areas.iter().fold(f64::INFINITY, |a, &b| a.min(b))
}

fn assert_sound(name: &str, mesh: &Mesh) {
    assert!(mesh.edge_report().is_watertight(), "{name}: {:?}", mesh.edge_report());
    assert!(mesh.signed_volume() > 0.0, "{name}");
    assert!(mesh.triangles().iter().all(|t| t.area() > 0.0), "{name}");
}

#[test]
fn every_kind_is_sound_at_every_density_and_grading() {
    for (name, shape, _) in gallery() {
        for density in [0.25, 1.0, 2.0] {
            for grading in [0.25, 1.0, 4.0] {
                let tessellation = at(density, grading);
                let mesh =
                    shape.mesh(&tessellation).unwrap_or_else(|error| panic!("{name} at {tessellation:?}: {error}"));
                assert_sound(name, &mesh);
                assert_eq!(shape.triangle_count(&tessellation), Ok(mesh.faces().len()), "{name}");
            }
        }
    }
}

#[test]
fn volumes_approach_their_closed_forms() {
    for (name, shape, volume) in gallery() {
        let Some(volume) = volume else { continue };
        let error_at = |density| {
            let tessellated = shape.mesh(&at(density, 1.0)).unwrap().signed_volume();
            (tessellated - volume).abs() / volume
        };
        let (coarse, fine) = (error_at(1.0), error_at(4.0));
        assert!(coarse < 0.02, "{name}: {coarse}");
        // A chord's error falls with the square of the number of segments: 16 times; whole segments cost some of it.
        assert!(fine < coarse / 8.0 || fine < 1e-9, "{name}: {coarse} to {fine}");
    }
}

#[test]
fn grading_keeps_shape_and_number_and_changes_the_spread() {
    let block = gallery().into_iter().find(|(name, ..)| *name == "drilled-box").unwrap().1;
    let mesh = |grading| block.mesh(&at(1.5, grading)).unwrap();
    let even = mesh(1.0);
    for grading in [0.125, 0.5, 2.0, 8.0] {
        let graded = mesh(grading);
        let number = graded.faces().len() as f64 / even.faces().len() as f64;
        assert!((0.9..1.1).contains(&number), "grading {grading}: {number} times the triangles");
        let volume = graded.signed_volume() / even.signed_volume();
        assert!((0.998..1.002).contains(&volume), "grading {grading}: {volume} times the volume");
    }
    let [coarser, finer] = [area_ratio(&mesh(0.125)), area_ratio(&mesh(8.0))];
    assert!(coarser < area_ratio(&even) && area_ratio(&even) < finer, "{coarser} {} {finer}", area_ratio(&even));
}

#[test]
fn members_of_a_compound_stay_apart() {
    let two = parse(
        "kind = 'compound'
         [[parts]]
         shape = { kind = 'rounded-box', size_mm = [10, 10, 10] }
         repeat = { kind = 'along', count = 2, step_mm = [10, 10, 0] }",
    );
    let mesh = two.mesh(&Tessellation::default()).unwrap();
    assert_eq!(mesh.components().1, 2);
    assert_sound("two boxes edge to edge", &mesh);
    assert!((mesh.signed_volume() - 2000.0).abs() < 1e-6);
}

#[test]
fn roll_pitch_yaw_turn_about_fixed_axes() {
    let placement = Placement { xyz_mm: [1.0, 2.0, 3.0], rpy_deg: [90.0, 0.0, 90.0] };
    // Roll takes z to -y, yaw takes -y to x.
    let moved = placement.isometry().unwrap() * super::super::Point::new(0.0, 0.0, 5.0);
    assert!((moved - super::super::Point::new(6.0, 2.0, 3.0)).norm() < 1e-12);
}

#[test]
fn the_same_description_gives_the_same_mesh() {
    for (name, shape, _) in gallery() {
        let hash = || crate::geometry::content_hash(&shape.mesh(&at(1.0, 2.0)).unwrap());
        assert_eq!(hash(), hash(), "{name}");
    }
}

#[test]
fn faults_name_their_field() {
    for (text, field) in [
        ("kind = 'cylinder'\nradius_mm = -1\nheight_mm = 2", "radius_mm"),
        ("kind = 'cylinder'\nradius_mm = nan\nheight_mm = 2", "radius_mm"),
        ("kind = 'cylinder'\nradius_mm = 4\nbore_mm = 5\nheight_mm = 2", "bore_mm"),
        ("kind = 'torus'\nring_radius_mm = 4\ntube_radius_mm = 5", "tube_radius_mm"),
        ("kind = 'rounded-box'\nsize_mm = [10, 10, 4]\nfillet_mm = 2", "fillet_mm"),
        (
            "kind = 'rounded-box'\nsize_mm = [9, 9, 9]\nholes = [{ face = '+z', at_mm = [4, 0], radius_mm = 1 }]",
            "holes[0]",
        ),
        (
            "kind = 'rounded-box'\nsize_mm = [9, 9, 9]
             holes = [{ face = '+z', at_mm = [0, 0], radius_mm = 1 }, { face = '+x', at_mm = [0, 0], radius_mm = 1 }]",
            "holes[1]",
        ),
        ("kind = 'revolve'\nprofile_mm = [[-1, 0], [4, 0], [4, 4]]", "profile_mm"),
        ("kind = 'revolve'\nprofile_mm = [[0, 0], [0, 4], [4, 4]]", "profile_mm"),
        ("kind = 'extrude'\noutline_mm = [[0, 0], [9, 0], [9, 9]]\nheight_mm = 0", "height_mm"),
        (
            "kind = 'extrude'\noutline_mm = [[0, 0], [9, 0], [9, 9], [0, 9]]\nheight_mm = 20\ntop = { fillet_mm = 5 }",
            "rim",
        ),
        (
            "kind = 'extrude'\noutline_mm = [[0, 0], [9, 0], [9, 9]]\nheight_mm = 1\nholes = [{ at_mm = [20, 0], radius_mm = 1 }]",
            "holes[0]",
        ),
        ("kind = 'thread'\nradius_mm = 1\npitch_mm = 5\nlength_mm = 20", "pitch_mm"),
        ("kind = 'thread'\nradius_mm = 100\npitch_mm = 0.002\nlength_mm = 8000", "pitch_mm"),
        (
            "kind = 'compound'\nparts = [{ shape = { kind = 'compound', parts = [{ shape = { kind = 'sphere', radius_mm = 0 } }] } }]",
            "parts[0].shape.parts[0].shape.radius_mm",
        ),
        ("kind = 'compound'\nparts = []", "parts"),
    ] {
        let error = parse(text).mesh(&Tessellation::default()).expect_err(text);
        assert_eq!(error.field, field, "{text}: {error}");
    }
    assert!(toml::from_str::<Shape>("kind = 'sphere'\nradius_mm = 1\ncolour = 'red'").is_err());
}

/// A length that may fit, or may be an arbitrary number.
fn any_length() -> impl Strategy<Value = f64> {
    prop_oneof![8 => 0.5..60.0, 1 => -5.0..5.0, 1 => proptest::num::f64::ANY]
}

fn any_point() -> impl Strategy<Value = outline::OutlinePoint> {
    let corner = ((any_length(), any_length()), prop_oneof![4 => Just(0.0), 1 => any_length()], 0..4_usize);
    corner.prop_map(|((x, y), size, which)| {
        let mut corner = outline::OutlineCorner { at_mm: [x, y], ..Default::default() };
        match which {
            1 => corner.fillet_mm = size,
            2 => corner.chamfer_mm = size,
            3 => corner.arc_mm = size,
            _ => {}
        }
        outline::OutlinePoint::Detailed(corner)
    })
}

fn any_box() -> impl Strategy<Value = Shape> {
    let side = prop::sample::select(vec!["-x", "+x", "-y", "+y", "-z", "+z"]);
    let hole =
        (side, any_length(), any_length(), any_length(), prop::option::of(any_length()), prop::option::of(90.0..150.0));
    let holes = prop::collection::vec(hole, 0..4);
    ([any_length(), any_length(), any_length()], prop_oneof![Just(0.0), any_length()], holes).prop_map(
        |(size_mm, fillet_mm, holes)| {
            let holes = holes.into_iter().map(|(face, u, v, radius, depth_mm, point_deg)| {
                let face = Shape::side(face);
                box_holes::BoxHole {
                    face,
                    at_mm: [u - 20.0, v - 20.0],
                    radius_mm: radius / 8.0,
                    depth_mm,
                    point_deg,
                    counterbore: None,
                }
            });
            Shape::RoundedBox(RoundedBox { size_mm, fillet_mm, holes: holes.collect() })
        },
    )
}

impl Shape {
    fn side(name: &str) -> box_holes::Side {
        serde_json::from_value(name.into()).expect("a side's name")
    }
}

fn any_shape() -> impl Strategy<Value = Shape> {
    let points = || prop::collection::vec(any_point(), 0..7);
    prop_oneof![
        points().prop_map(|profile_mm| Shape::Revolve(Revolve { profile_mm })),
        (points(), any_length(), any_length()).prop_map(|(outline_mm, height_mm, rim)| {
            let rim = extrude::Rim { fillet_mm: rim / 20.0, chamfer_mm: 0.0 };
            Shape::Extrude(Extrude { outline_mm, holes: vec![], height_mm, bottom: rim, top: extrude::Rim::default() })
        }),
        any_box(),
        (any_length(), any_length(), any_length()).prop_map(|(radius_mm, pitch, length_mm)| {
            Shape::Thread(Thread { radius_mm, pitch_mm: pitch / 10.0, length_mm, form: thread::ThreadForm::Metric })
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 64 } else { 512 }))]

    /// Arbitrary numbers give either a fault or a sound mesh, never a panic.
    #[test]
    fn any_description_is_a_sound_solid_or_a_fault(
        shape in any_shape(), density in 0.3..1.5_f64, grading in 0.25..4.0_f64,
    ) {
        if let Ok(mesh) = shape.mesh(&at(density, grading)) {
            assert_sound("random", &mesh);
        }
    }

    /// Stars with rounded corners, a hole in the middle, and fillets or chamfers at both ends.
    #[test]
    fn prisms_that_fit_are_sound(
        radii in prop::collection::vec(40.0..60.0_f64, 5..12), fillet in 1.0..2.5_f64, rim in 0.05..0.9_f64,
        bore in 1.0..25.0_f64, height in 5.0..200.0_f64, grading in 0.1..10.0_f64, density in 0.25..2.0_f64,
    ) {
        let corner = |(i, radius): (usize, &f64)| {
            let (sin, cos) = (2.0 * PI * i as f64 / radii.len() as f64).sin_cos();
            outline::OutlinePoint::Rounded([radius * cos, radius * sin, fillet])
        };
        let hole = extrude::RoundHole { at_mm: [0.0, 0.0], radius_mm: bore };
        let shape = Shape::Extrude(Extrude {
            outline_mm: radii.iter().enumerate().map(corner).collect(),
            holes: vec![extrude::ExtrudeHole::Round(hole)],
            height_mm: height,
            bottom: extrude::Rim { fillet_mm: rim, chamfer_mm: 0.0 },
            top: extrude::Rim { fillet_mm: 0.0, chamfer_mm: rim },
        });
        let mesh = shape.mesh(&at(density, grading));
        prop_assert!(mesh.is_ok(), "{:?}", mesh);
    }

    /// Parameters that fit must give solids.
    #[test]
    fn boxes_that_fit_are_sound(
        size in prop::array::uniform3(20.0..200.0_f64), fillet in 0.0..0.45_f64, hole in 0.1..0.9_f64, deep in 0.1..0.8_f64,
        density in 0.25..2.0_f64, grading in 0.1..10.0_f64,
    ) {
        let fillet_mm = if fillet < 0.05 { 0.0 } else { fillet * 18.0 };
        let flat = size.map(|s| s / 2.0 - fillet_mm - 0.01);
        let drill = |face: &str, u: usize, v: usize, axis: usize| box_holes::BoxHole {
            face: Shape::side(face),
            at_mm: [0.0, 0.0],
            radius_mm: hole * flat[u].min(flat[v]),
            depth_mm: Some(deep * size[axis] * 0.45),
            point_deg: None,
            counterbore: None,
        };
        let holes = vec![drill("+z", 0, 1, 2), drill("-z", 0, 1, 2)];
        let shape = Shape::RoundedBox(RoundedBox { size_mm: size, fillet_mm, holes });
        let mesh = shape.mesh(&at(density, grading));
        prop_assert!(mesh.is_ok(), "{:?}", mesh);
    }

    /// Screws that fit are solids between their core and their crests.
    #[test]
    fn screws_that_fit_are_sound(radius in 1.0..40.0_f64, pitch in 0.05..1.2_f64, turns in 2.0..20.0_f64, density in 0.25..2.0_f64) {
        let shape = Shape::Thread(Thread {
            radius_mm: radius, pitch_mm: pitch * radius, length_mm: turns * pitch * radius, form: thread::ThreadForm::Metric,
        });
        let mesh = shape.mesh(&at(density, 1.0)).unwrap();
        prop_assert!(mesh.signed_volume() < PI * radius.powi(2) * turns * pitch * radius);
    }

    /// Stepped shafts with rounded shoulders.
    #[test]
    fn shafts_that_fit_are_sound(steps in prop::collection::vec((4.0..60.0_f64, 5.0..80.0_f64), 1..6), bore in 0.0..3.0_f64, grading in 0.1..10.0_f64) {
        let bore = if bore < 1.0 { 0.0 } else { bore };
        let mut profile_mm = vec![outline::OutlinePoint::Sharp([bore, 0.0])];
        let mut z = 0.0;
        for (radius, height) in steps {
            profile_mm.push(outline::OutlinePoint::Sharp([radius, z]));
            z += height;
            profile_mm.push(outline::OutlinePoint::Sharp([radius, z]));
        }
        profile_mm.push(outline::OutlinePoint::Sharp([bore, z]));
        let mesh = Shape::Revolve(Revolve { profile_mm }).mesh(&at(1.0, grading));
        prop_assert!(mesh.is_ok(), "{:?}", mesh);
    }
}
