use super::*;
use rs274::Position;

/// A slide of 0.5 m along y carries an arm that rotates about z, and the arm carries a spindle that rotates without limits.
const ROBOT: &str = r#"<?xml version="1.0"?>
<robot name="small">
  <!-- <a><b><c> <xacro:include filename="common.xacro"/> -->
  <link name="bed"><visual><geometry><box size="1 0.2 0.1"/></geometry></visual></link>
  <link name="carriage">
    <visual><origin xyz="0 0 0.05" rpy="0 0 0"/><geometry><mesh filename="package://small/carriage.stl" scale="0.001 0.001 0.001"/></geometry></visual>
    <collision><geometry><cylinder radius="0.03" length="0.2"/></geometry></collision>
    <collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.04"/></geometry></collision>
  </link>
  <link name="arm"><visual><geometry><mesh filename="arm.obj"/></geometry></visual></link>
  <link name="spindle"/>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0.1 0.2" rpy="0 0 1.5707963267948966"/>
    <parent link="bed"/><child link="carriage"/><axis xyz="0 1 0"/><limit lower="-0.25" upper="0.25" effort="1" velocity="1"/>
  </joint>
  <joint name="swing" type="revolute">
    <origin xyz="0.1 0 0"/>
    <parent link="carriage"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="spin" type="continuous"><parent link="arm"/><child link="spindle"/><axis xyz="1 0 0"/></joint>
</robot>
"#;

fn letters(of: &[(&str, char)]) -> BTreeMap<String, char> {
    of.iter().map(|&(name, letter)| (name.to_owned(), letter)).collect()
}

#[test]
fn metres_become_mm_and_joints_get_letters() {
    let (machine, bodies) = read(ROBOT, &BTreeMap::new(), Form::Collision).unwrap();
    assert_eq!(machine.axis_limits(Axis::X), Some([-250.0, 250.0]));
    assert_eq!(machine.axis_limits(Axis::A), Some([-1.0, 1.0]));
    assert_eq!(machine.axis_limits(Axis::B), Some([f64::NEG_INFINITY, f64::INFINITY]));
    let mut position = Position::default();
    position[Axis::X] = 30.0;
    // The slide's frame is turned by 90°: its y is the world's -x. From (0, 100, 200) by 30 to (-30, 100, 200).
    let poses = machine.forward(&position);
    let carriage = poses.world_from(machine.link("carriage")) * Point::origin();
    assert!((carriage - Point::new(-30.0, 100.0, 200.0)).norm() < 1e-9, "{carriage}");
    // The arm is 100 along the carriage's x, which is the world's y.
    let arm = poses.world_from(machine.link("arm")) * Point::origin();
    assert!((arm - Point::new(-30.0, 200.0, 200.0)).norm() < 1e-9, "{arm}");
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["bed", "carriage-1", "carriage-2", "arm"]);
    // A cylinder about the origin, 200 long: ours begins 100 below.
    assert_eq!(bodies[1].link_from_body.translation.z, -100.0);
    assert_eq!(bodies[2].link_from_body.translation.x, 100.0);
    assert_eq!(bodies[3].solid, Solid::Mesh { file: "arm.obj".to_owned(), unit_mm: 1000.0 });
}

#[test]
fn what_is_seen_may_be_taken_instead() {
    let (_, bodies) = read(ROBOT, &BTreeMap::new(), Form::Visual).unwrap();
    assert_eq!(bodies.len(), 3);
    assert_eq!(bodies[1].solid, Solid::Mesh { file: "package://small/carriage.stl".to_owned(), unit_mm: 1.0 });
    assert_eq!(bodies[1].link_from_body.translation.z, 50.0);
}

#[test]
fn a_link_that_has_only_what_collides_is_there_in_both_forms() {
    let visual = "<visual><geometry><mesh filename=\"arm.obj\"/></geometry></visual>";
    assert!(ROBOT.contains(visual));
    let (_, seen) = read(ROBOT, &BTreeMap::new(), Form::Visual).unwrap();
    let robot = ROBOT.replacen(visual, &visual.replace("visual", "collision"), 1);
    assert_eq!(read(&robot, &BTreeMap::new(), Form::Visual).unwrap().1, seen);
}

#[test]
fn letters_may_be_chosen_and_linear_ones_turn() {
    let (machine, _) = read(ROBOT, &letters(&[("swing", 'x'), ("spin", 'C')]), Form::Collision).unwrap();
    // A radian of a joint that turns a degree per mm.
    assert!((machine.axis_limits(Axis::X).unwrap()[1] - 1f64.to_degrees()).abs() < 1e-12);
    assert_eq!(machine.axis_limits(Axis::Y), Some([-250.0, 250.0])); // the next free one for the slide
    assert!(machine.axis_limits(Axis::C).is_some());
}

#[test]
fn what_cannot_be_taken_is_told() {
    let none = BTreeMap::new();
    let error = |from: &str, to: &str| {
        assert!(ROBOT.contains(from), "{from}");
        let error = read(&ROBOT.replacen(from, to, 1), &none, Form::Collision).unwrap_err();
        (error.to_string(), error.name)
    };
    for (from, to, message, name) in [
        ("type=\"continuous\"", "type=\"floating\"", "joint `spin` is floating;", Some("spin")),
        ("type=\"continuous\"", "type=\"planar\"", "joint `spin` is planar;", Some("spin")),
        (
            "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
            "",
            "joint `swing` has no range:",
            Some("swing"),
        ),
        ("lower=\"-1\"", "lower=\"2\"", "joint `swing`: the limits of axis A are the wrong way round", Some("swing")),
        (
            "<axis xyz=\"0 0 1\"/>",
            "<axis xyz=\"0 0 0\"/>",
            "joint `swing`: the direction of axis A is zero",
            Some("swing"),
        ),
        (
            "<axis xyz=\"0 0 1\"/>",
            "<axis xyz=\"0 0 1\"/><mimic joint=\"slide\"/>",
            "joint `swing` mimics `slide`",
            Some("swing"),
        ),
        ("<child link=\"arm\"/>", "<child link=\"leg\"/>", "joint `swing` names the link `leg`", Some("swing")),
        (
            "<child link=\"spindle\"/>",
            "<child link=\"arm\"/>",
            "link `arm` is the child of two joints, `swing` and `spin`",
            Some("arm"),
        ),
        (
            "<parent link=\"bed\"/>",
            "<parent link=\"arm\"/>",
            "links stand on one another in a circle: ",
            Some("carriage"),
        ),
        ("<link name=\"spindle\"/>", "<link name=\"arm\"/>", "joint `spin` names the link `spindle`", Some("spin")),
        ("rpy=\"0 0 1.5707963267948966\"", "rpy=\"0 0 inf\"", "a placement at `slide` is not finite", Some("slide")),
        ("<robot name=\"small\">", "<robot name=\"small\"><xacro:include/>", "this is xacro;", None),
        ("</robot>", "<xacro:if value=\"1\"></xacro:if></robot>", "this is xacro;", None),
        ("</robot>", "", "", None),
    ] {
        let (text, found) = error(from, to);
        assert!(text.starts_with(message), "{text}\nis not\n{message}");
        assert_eq!(found.as_deref(), name, "{text}");
    }
    let scale = "0.001 0.001 0.001";
    assert!(ROBOT.contains(scale));
    for bad in ["0.001 0.001 -0.001", "-1 -1 -1", "0 0 0", "1 2 1", "1 1 2", "inf inf inf"] {
        let error = read(&ROBOT.replacen(scale, bad, 1), &none, Form::Visual).unwrap_err().to_string();
        assert!(error.starts_with("a mesh of link `carriage` is scaled by ["), "{error}");
    }
    let bad = |of: &[(&str, char)]| read(ROBOT, &letters(of), Form::Collision).unwrap_err().to_string();
    assert_eq!(bad(&[("slid", 'X')]), "there is no joint `slid` to give axis X to; there are slide, swing, spin");
    assert_eq!(bad(&[("slide", 'A')]), "joint `slide` cannot be axis `A`: it slides, and A, B and C turn");
    assert_eq!(bad(&[("slide", 'q')]), "joint `slide` cannot be axis `q`: the axes are X Y Z A B C U V W");
}

#[test]
fn bottomless_files_end_in_an_error() {
    let deep = format!("<robot name=\"a\">{}", "<link>".repeat(100_000));
    let nested = UrdfError::of_file("elements are nested deeper than 64");
    assert_eq!(read(&deep, &BTreeMap::new(), Form::Visual).unwrap_err(), nested);
    // Neither character data nor a quoted value closes an element.
    for once in ["<a><![CDATA[></a>]]>", "<a b=\"/>\">", "<a b='</a>'>", "<a><!-- > </a> -->"] {
        let deep = format!("<robot name=\"a\">{}", once.repeat(100_000));
        assert_eq!(read(&deep, &BTreeMap::new(), Form::Visual).unwrap_err(), nested, "{once}");
    }
    let elements = |depth: usize| check_elements(&format!("{}{}", "<a>".repeat(depth), "</a>".repeat(depth)));
    assert!(elements(64).is_ok() && elements(65) == Err(nested));
    assert!(check_elements(&"<a></a>".repeat(100)).is_ok());
    for text in ["", "<", "<robot", "<robot/>", "\u{0}", "<robot name='a'><link/></robot>"] {
        // An empty robot is a machine without links; whatever else is here is not.
        assert!(text == "<robot/>" || read(text, &BTreeMap::new(), Form::Visual).is_err(), "{text}");
    }
}
