use super::super::pairs::{Dropped, Reach, decide};
use super::super::{Clearances, Pair, Role, Scene, SceneError, Turns};
use crate::geometry::Point;
use rs274::{Axis, Position};
use std::path::Path;
use tempfile::TempDir;

/// A tetrahedron with legs of 1 mm.
const TETRAHEDRON: &str = "solid t
facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet
facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet
facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet
facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet
endsolid t
";

/// A slide along X that carries `tool`, with `block` fixed to the world 10 mm farther along X.
const SLIDE: &str = r#"title = "A slide"
pairs = [["block", "tool"]]
[[machine.links]]
name = "slide"
joint = { axis = "X", direction = [1, 0, 0], min_mm = -100, max_mm = 50 }
[[parts]]
name = "tool"
link = "slide"
mesh = "t.stl"
[[parts]]
name = "block"
at = { xyz_mm = [10, 0, 0] }
mesh = "t.stl"
"#;

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.stl"), TETRAHEDRON).unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

fn load(files: &[(&str, &str)]) -> Result<Scene, SceneError> {
    Scene::load(folder(files).path())
}

/// The error of a scene file, with the folder's name removed.
fn error_of(files: &[(&str, &str)]) -> (SceneError, String) {
    let folder = folder(files);
    let error = Scene::load(folder.path()).unwrap_err();
    let text = error.to_string().replace(&format!("{}/", folder.path().display()), "");
    (error, text)
}

#[test]
fn a_scene_knows_its_machine_parts_pairs_and_inputs() {
    let scene = load(&[("scene.toml", SLIDE)]).unwrap();
    assert_eq!(scene.pairs, [Pair { a: 1, b: 0 }]);
    assert_eq!(scene.random, scene.pairs);
    assert_eq!(scene.pair_name(scene.pairs[0]), "block:tool");
    assert_eq!(scene.parts[0].mesh.faces().len(), 4);
    let mut position = Position::default();
    position[Axis::X] = 4.0;
    let tool_in_block = scene.a_from_b(scene.pairs[0], &scene.machine.forward(&position)) * Point::origin();
    assert!((tool_in_block - Point::new(-6.0, 0.0, 0.0)).norm() < 1e-12); // 4 - 10
    let inputs: Vec<&str> = scene.inputs.keys().map(|key| key.split_once('/').unwrap().1).collect();
    assert_eq!(inputs, ["scene.toml", "t.stl"]);
    assert_eq!(scene.inputs.values().nth(1).unwrap(), blake3::hash(TETRAHEDRON.as_bytes()).to_hex().as_str());
}

#[test]
fn a_machine_may_have_its_own_file_that_brings_parts() {
    let machine = "[[links]]\nname = \"slide\"\njoint = { axis = \"X\", direction = [1, 0, 0] }\n\
                   [[parts]]\nname = \"bed\"\nmesh = \"t.stl\"\n";
    let scene = "title = \"\"\n[machine]\nfile = \"machine.toml\"\n\
                 [[parts]]\nname = \"arm\"\nlink = \"slide\"\nmesh = \"t.stl\"\n[[parts]]\nname = \"leg\"\nmesh = \"t.stl\"\n";
    let loaded = load(&[("scene.toml", scene), ("machine.toml", machine)]).unwrap();
    assert_eq!(loaded.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["bed", "arm", "leg"]);
    // Bed and leg stand still, so only the arm can run into them.
    assert_eq!(loaded.pairs, [Pair { a: 0, b: 1 }, Pair { a: 1, b: 2 }]);
    let (_, text) = error_of(&[("scene.toml", scene), ("machine.toml", "[[links]]\nname = 3\n")]);
    assert!(text.starts_with("machine.toml:2:8: "), "{text}");
    for key in
        ["form = \"visual\"", "axes = { slide = \"Y\" }", "density = 2", "file = \"other.toml\"", "urdf = \"r.urdf\""]
    {
        let machine = format!("# of a mill\n{key}\n{machine}");
        let (_, text) = error_of(&[("scene.toml", scene), ("machine.toml", &machine)]);
        assert!(text.starts_with("machine.toml:2:1: ") && text.contains("`links` or `parts`"), "{text}");
    }
}

#[test]
fn a_density_for_the_machines_file_is_for_its_parts_alone() {
    let shape = "shape = { kind = \"sphere\", radius_mm = 20 }\n";
    let machine = format!(
        "[[links]]\nname = \"slide\"\njoint = {{ axis = \"X\", direction = [1, 0, 0] }}\n[[parts]]\nname = \"a\"\n{shape}"
    );
    let scene = |density: &str| {
        format!(
            "title = \"\"\n[machine]\nfile = \"machine.toml\"\n{density}[[parts]]\nname = \"b\"\nlink = \"slide\"\n{shape}"
        )
    };
    let faces = |density: &str| {
        let loaded = load(&[("scene.toml", &scene(density)), ("machine.toml", &machine)]).unwrap();
        [0, 1].map(|part| loaded.parts[part].mesh.faces().len())
    };
    let [a, b] = faces("density = 0.5\n");
    assert_eq!(faces(""), [b, b]);
    // Half as dense: about a quarter of the triangles.
    assert!(3 * a < b && b < 5 * a, "{a} {b}");
    let (_, text) = error_of(&[("scene.toml", "title = \"\"\n[machine]\ndensity = 2\n")]);
    assert!(text.contains("`density` goes with `file`"), "{text}");
}

#[test]
fn parts_and_recorded_poses_make_a_scene() {
    let scene = "title = \"\"\n[[parts]]\nname = \"a\"\nmesh = \"t.stl\"\n[[parts]]\nname = \"b\"\nmesh = \"t.stl\"\n\
                 [recorded]\nfile = \"poses.csv\"\n";
    let poses = "part,qw,qx,qy,qz,tx,ty,tz\nb,1,0,0,0,5,0,0\nb,1,0,0,0,6,0,0\n";
    let loaded = load(&[("scene.toml", scene), ("poses.csv", poses)]).unwrap();
    assert_eq!(loaded.pairs, [Pair { a: 0, b: 1 }]);
    assert_eq!(loaded.recording.unwrap().pose(1, 1).translation.x, 6.0);
    let (_, text) = error_of(&[("scene.toml", scene), ("poses.csv", "part,qw,qx,qy,qz,tx,ty,tz\nc,1,0,0,0,5,0,0\n")]);
    assert_eq!(text, "poses.csv:2:1: there is no part named `c`; there are a, b");
    let (_, text) = error_of(&[("scene.toml", scene)]);
    assert!(text.starts_with("scene.toml:9:8: poses.csv: "), "{text}");
}

#[test]
fn programs_and_approaches_are_read_and_checked() {
    let scene = format!(
        "{SLIDE}[program]\nfile = \"p.ngc\"\nstep_mm = 0.5\nstart = {{ x_mm = -20 }}\n\
         [[approaches]]\nname = \"head-on\"\npair = [\"block\", \"tool\"]\nat = {{ x_mm = -20 }}\ndirection = [2, 0, 0]\n"
    );
    let loaded = load(&[("scene.toml", &scene), ("p.ngc", "G0 X5\nM2\n")]).unwrap();
    let run = loaded.program.unwrap();
    assert_eq!((run.start[Axis::X], run.sampling.step_mm, run.program.moves.len()), (-20.0, 0.5, 1));
    assert_eq!(loaded.approaches[0].direction.x, 1.0);
    assert_eq!(loaded.approaches[0].offsets_mm.len(), 15);

    let (error, text) = error_of(&[("scene.toml", &scene), ("p.ngc", "G0 X5\nG0 X[\nM2\n")]);
    assert!(matches!(error, SceneError::Program(_)) && text.starts_with("p.ngc:2:"), "{text}");
    for (from, to, message) in [
        ("step_mm = 0.5", "step_mm = 0", "step_mm is 0; it must be a finite number above 0"),
        ("start = { x_mm = -20 }", "start = { x_mm = nan }", "start is not finite"),
        ("start = { x_mm = -20 }", "start = { x_mm = -101 }", "axis X at -101 mm is outside its limits -100 to 50 mm"),
        ("at = { x_mm = -20 }", "at = { x_mm = 51 }", "axis X at 51 mm is outside its limits -100 to 50 mm"),
        ("direction = [2, 0, 0]", "direction = [0, 0, 0]", "the direction is zero or not finite"),
        ("direction = [2, 0, 0]", "direction = [1, 0, 0]\noffsets_mm = []", "offsets_mm must be a list"),
    ] {
        let text = error_of(&[("scene.toml", &scene.replace(from, to)), ("p.ngc", "M2\n")]).1;
        assert!(text.starts_with("scene.toml:") && text.contains(message), "{text}");
    }
}

#[test]
fn wrong_values_are_told_at_their_own_place() {
    let scene = |more: &str| format!("{SLIDE}{more}");
    let program = "[program]\nfile = \"p.ngc\"\n";
    for (table, line, message) in [
        (program, "step_deg = -1", "12: step_deg is -1; it must be"),
        (program, "start = { x_mm = nan }", "9: start is not finite"),
        (program, "start = { x_mm = 51 }", "9: axis X at 51 mm is outside its limits"),
        (program, "home = { z_mm = inf }", "8: home is not finite"),
        (program, "second_home = { z_mm = inf }", "15: second_home is not finite"),
        (program, "units = \"cm\"", "9: there are no units `cm`; there are mm, inch"),
        (program, "home = { x_mm = 51 }", "8: axis X at 51 mm is outside its limits"),
        (program, "second_home = { x_mm = -101 }", "15: axis X at -101 mm is outside its limits"),
        (program, "work_offsets = { G60 = { z_mm = 1 } }", "24: work_offsets: `G60` is not one of G54,"),
        (program, "work_offsets = { G54 = { z_mm = nan } }", "24: work_offsets.G54 is not finite"),
        (program, "tools = [{ number = 3, diameter_mm = -1 }]", "10: tool 3: diameter_mm must be"),
        (program, "tools = [{ number = 3 }, { number = 3 }]", "26: there are two tools with number 3"),
        (program, "user_codes = { X428 = \"ignore\" }", "23: `X428` is not an M code"),
        ("[check]\n\n", "rapid_mm_min = 0", "16: rapid_mm_min is 0; it must be"),
        ("[check]\n\n", "gouge_mm = -1", "12: gouge_mm is -1; it must be"),
        ("[check]\n\n", "rapid_rates = { Q = 3 }", "21: rapid_rates: `Q` is not an axis"),
        ("[check]\n\n", "feed_limits = { X = 5, A = nan }", "28: feed_limits.A is NaN; it must be"),
    ] {
        let text = error_of(&[("scene.toml", &scene(&format!("{table}{line}\n"))), ("p.ngc", "M2\n")]).1;
        assert!(text.starts_with(&format!("scene.toml:16:{message}")), "{line}: {text}");
    }
}

#[test]
fn a_machines_own_codes_turn_the_spindle() {
    let codes = "[program]\nfile = \"p.ngc\"\nuser_codes = { M113 = \"spindle-on\", M115 = \"spindle-off\" }\n";
    let scene = format!("{SLIDE}{codes}");
    let loaded = load(&[("scene.toml", &scene), ("p.ngc", "S500 M113\nG0 X1\nM115\nX2\nM2\n")]).unwrap();
    let moves = loaded.program.unwrap().program.moves;
    assert_eq!(moves.iter().map(|step| step.spindle_rpm).collect::<Vec<_>>(), [500.0, 0.0]);
}

#[test]
fn rotary_axes_without_limits_are_endless() {
    let turn = |axis, limits| {
        format!(
            "[[machine.links]]\nname = \"{axis}\"\njoint = {{ axis = \"{axis}\", direction = [0, 0, 1]{limits} }}\n"
        )
    };
    let turns = [turn("A", ", min_deg = -720, max_deg = 720"), turn("C", ""), turn("Z", "")].concat();
    let scene = format!("{SLIDE}{turns}[program]\nfile = \"p.ngc\"\n");
    let setup = load(&[("scene.toml", &scene), ("p.ngc", "M2\n")]).unwrap().program.unwrap().setup;
    let endless: Vec<_> = Axis::ALL.into_iter().filter(|&axis| setup.endless[axis as usize]).collect();
    assert_eq!(endless, [Axis::C]);
}

#[test]
fn both_homes_are_where_the_scene_says() {
    let homes = "[program]\nfile = \"p.ngc\"\nhome = { x_mm = 40 }\nsecond_home = { x_mm = -30, z_mm = 5 }\n";
    let scene = format!("{SLIDE}{homes}");
    let loaded = load(&[("scene.toml", &scene), ("p.ngc", "G28\nG91 G30 X0\nM2\n")]).unwrap();
    let moves = loaded.program.unwrap().program.moves;
    assert_eq!(moves.iter().map(|step| step.end[Axis::X]).collect::<Vec<_>>(), [40.0, 40.0, -30.0]);
    for (home, is_told) in [("", true), ("second_home = {}\n", false)] {
        let scene = format!("{SLIDE}[program]\nfile = \"p.ngc\"\n{home}");
        let loaded = load(&[("scene.toml", &scene), ("p.ngc", "G91 G30 X0\nM2\n")]).unwrap();
        let notes = loaded.program.unwrap().program.notes;
        let told = notes.iter().any(|note| note.is_unknown && note.text.contains("`second_home`"));
        assert_eq!(told, is_told, "{home}: {notes:?}");
    }
}

#[test]
fn the_worked_example_of_the_documentation_is_a_program_table() {
    let text = include_str!("../../../../../docs/format.md");
    let example = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let slides = "[[machine.links]]\nname = \"z\"\njoint = { axis = \"Z\", direction = [0, 0, 1] }\n";
    let scene = format!("{SLIDE}{slides}{example}");
    let setup = load(&[("scene.toml", &scene), ("part.ngc", "M2\n")]).unwrap().program.unwrap().setup;
    assert_eq!((setup.tools[&2].offset[Axis::Z], setup.tools[&2].diameter_mm), (95.5, 10.0));
    assert_eq!(setup.work_offsets[0].origin[Axis::Z], 120.0);
    assert_eq!([setup.start, setup.home, setup.second_home.unwrap()].map(|p| p[Axis::Z]), [400.0, 400.0, 350.0]);
    assert_eq!(setup.tool, 1);
}

#[test]
fn whatever_is_wrong_with_a_scene_file_is_said_with_its_place() {
    for (from, to, message) in [
        ("title = \"A slide\"", "title = ", "scene.toml:1:9: "),
        ("title = \"A slide\"", "colour = 3", "scene.toml:1:1: unknown field `colour`"),
        ("link = \"slide\"", "link = \"sledge\"", "scene.toml:8:8: there is no link named `sledge`; there are slide"),
        (
            "[\"block\", \"tool\"]",
            "[\"block\", \"fool\"]",
            "scene.toml:2:10: there is no part named `fool`; there are tool, block",
        ),
        ("[\"block\", \"tool\"]", "[\"tool\", \"tool\"]", "scene.toml:2:10: part `tool` is paired with itself"),
        ("name = \"block\"", "name = \"tool\"", "scene.toml:11:8: there are two parts named `tool`"),
        (
            "at = { xyz_mm = [10, 0, 0] }",
            "at = { xyz_mm = [inf, 0, 0] }",
            "scene.toml:11:8: the placement of part `block` is not finite",
        ),
        (
            "direction = [1, 0, 0]",
            "direction = [0, 0, 0]",
            "scene.toml:5:35: link `slide`: the direction of axis X is zero",
        ),
        (
            "name = \"slide\"",
            "name = \"slide\"\nparent = \"slide\"",
            "scene.toml:4:8: links stand on one another in a circle: slide -> slide",
        ),
        (
            "link = \"slide\"\nmesh = \"t.stl\"",
            "link = \"slide\"",
            "scene.toml:7:8: part `tool`: either `shape` or `mesh` must be given",
        ),
        (
            "link = \"slide\"\nmesh = \"t.stl\"",
            "mesh = \"none.stl\"",
            "scene.toml:7:8: part `tool`: none.stl: No such file",
        ),
    ] {
        assert!(SLIDE.contains(from), "{from}");
        let text = error_of(&[("scene.toml", &SLIDE.replacen(from, to, 1))]).1;
        assert!(text.starts_with(message), "{text}\nis not\n{message}");
    }
}

#[test]
fn files_that_cannot_be_read_are_told_where_the_scene_names_them() {
    let axes = "[[machine.links]]\nname = \"slide\"\njoint = { axis = \"X\", direction = [1, 0, 0], min_mm = -100, max_mm = 50 }";
    for (from, to, message) in [
        (axes, "machine = { file = \"none.toml\" }", "scene.toml:3:20: none.toml: "),
        (SLIDE, &format!("{SLIDE}[program]\nfile = \"none.ngc\"\n"), "scene.toml:15:8: none.ngc: "),
        (SLIDE, &format!("{SLIDE}[program]\nfile = \"p.ngc\"\nmore = [\"none.ngc\"]\n"), "scene.toml:16:9: none.ngc: "),
    ] {
        assert!(SLIDE.contains(from), "{from}");
        let text = error_of(&[("scene.toml", &SLIDE.replacen(from, to, 1)), ("p.ngc", "M2\n")]).1;
        assert!(text.starts_with(message), "{text}\nis not\n{message}");
    }
}

#[test]
fn parts_of_a_tool_are_told_from_parts_of_others() {
    let scene = SLIDE.replacen("link = \"slide\"", "link = \"slide\"\nrole = \"holder\"\ntool = 7", 1);
    let other = format!("{scene}[[parts]]\nname = \"other\"\ntool = 8\nmesh = \"t.stl\"\n");
    let loaded = load(&[("scene.toml", &other.replace("pairs = [[\"block\", \"tool\"]]", ""))]).unwrap();
    assert_eq!((loaded.parts[0].role, loaded.parts[0].tool), (Role::Holder, Some(7)));
    // The block stands in the world, and so does `other`; `tool` and `other` are of different tools.
    assert_eq!(loaded.pairs, [Pair { a: 0, b: 1 }]);
    assert!(loaded.is_mounted(loaded.pairs[0], 7) && !loaded.is_mounted(loaded.pairs[0], 8));
    let text = error_of(&[("scene.toml", &other.replace("[\"block\", \"tool\"]", "[\"other\", \"tool\"]"))]).1;
    assert_eq!(text, "scene.toml:2:10: `other` belongs to tool 8 and `tool` to tool 7: they are never there together");
    let text = error_of(&[("scene.toml", &scene.replacen("holder", "fixture", 1))]).1;
    assert_eq!(text, "scene.toml:7:8: part `tool` belongs to a tool, so it cannot be a fixture");
}

#[test]
fn grooves_are_those_of_cutters_and_have_a_width() {
    let with = |role: &str, groove: &str| {
        let keys = format!("link = \"slide\"\nrole = \"{role}\"\ngroove_mm = {groove}");
        SLIDE.replacen("link = \"slide\"", &keys, 1)
    };
    let loaded = load(&[("scene.toml", &with("cutter", "1.5"))]).unwrap();
    assert_eq!(loaded.parts.iter().map(|part| part.groove_mm).fold(0.0, f64::max), 1.5);
    for groove in ["-1", "nan", "inf"] {
        let text = error_of(&[("scene.toml", &with("cutter", groove))]).1;
        assert!(text.starts_with("scene.toml:7:8: groove_mm of part `tool` is "), "{text}");
        assert!(text.ends_with("must be a finite width of at least 0"), "{text}");
    }
    let text = error_of(&[("scene.toml", &with("holder", "1"))]).1;
    assert!(text.contains("only a part with `role = \"cutter\"`"), "{text}");
}

#[test]
fn what_turns_a_part_is_a_key_of_what_may_turn() {
    let with = |role: &str, turns: &str| {
        let keys = format!("link = \"slide\"\nrole = \"{role}\"\n{turns}");
        SLIDE.replacen("link = \"slide\"", &keys, 1)
    };
    for (role, turns, expected) in [
        ("cutter", "turns = \"own\"", Turns::Own),
        ("holder", "turns = \"spindle\"", Turns::Spindle),
        ("fixture", "turns = \"none\"", Turns::Nothing),
    ] {
        let loaded = load(&[("scene.toml", &with(role, turns))]).unwrap();
        assert!(loaded.parts.iter().any(|part| part.turns == Some(expected)), "{turns}");
        assert!(turns.contains(expected.name()));
    }
    for (role, turns, why) in [
        ("workpiece", "turns = \"none\"", "the spindle of a lathe turns every workpiece"),
        ("fixture", "turns = \"own\"", "only a cutter, a shank or a holder may say that"),
        ("cutter", "turns = \"itself\"", "unknown variant `itself`"),
        ("cutter", "turn = \"own\"", "unknown field `turn`"),
    ] {
        let text = error_of(&[("scene.toml", &with(role, turns))]).1;
        assert!(text.starts_with("scene.toml:") && text.contains(why), "{text}");
    }
}

#[test]
fn bad_meshes_are_refused_with_their_part() {
    let scene = SLIDE.replacen("t.stl", "bad.stl", 1);
    for bad in ["solid t\nendsolid t\n", &TETRAHEDRON.replacen("vertex 1 0 0", "vertex nan 0 0", 1), "no mesh at all"] {
        let (error, text) = error_of(&[("scene.toml", &scene), ("bad.stl", bad)]);
        assert!(matches!(error, SceneError::Mesh { .. }), "{text}");
        assert!(text.starts_with("scene.toml:7:8: part `tool`: "), "{text}");
    }
}

#[test]
fn scenes_without_parts_or_of_another_encoding_are_refused() {
    assert!(matches!(error_of(&[("scene.toml", "title = \"\"\n")]).0, SceneError::NoParts { .. }));
    let folder = folder(&[]);
    std::fs::write(folder.path().join("scene.toml"), b"title = \"\xff\"").unwrap();
    assert!(matches!(Scene::load(folder.path()).unwrap_err(), SceneError::Read { .. }));
}

#[test]
fn a_scene_that_is_nowhere_is_answered_with_those_that_are_somewhere() {
    for error in [Scene::find("lathe-toolpots"), Scene::load(Path::new("no/such/folder"))].map(Result::unwrap_err) {
        assert!(matches!(error, SceneError::Missing { .. }));
        assert!(error.to_string().contains("lathe-toolpost, lathe-tailstock"), "{error}");
    }
}

#[test]
fn a_folder_without_a_scene_file_is_told_from_one_that_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    for error in [Scene::find(path), Scene::load(folder.path())].map(Result::unwrap_err) {
        assert_eq!(error.to_string(), format!("{path}: the folder has no scene.toml, so it is not a scene"));
    }
}

#[test]
fn a_scene_has_a_limited_number_of_parts() {
    let part =
        |i: usize| format!("[[parts]]\nname = \"p{i}\"\nshape = {{ kind = \"rounded-box\", size_mm = [1, 1, 1] }}\n");
    let parts: String = (2..4097).map(part).collect();
    let text = error_of(&[("scene.toml", &format!("{SLIDE}{parts}"))]).1;
    assert!(text.contains("with part `p4096` the scene has more than 4096 parts"), "{text}");
}

#[test]
fn a_part_of_a_tool_is_no_neighbour_of_the_structure() {
    let free = SLIDE.replacen("pairs = [[\"block\", \"tool\"]]\n", "", 1);
    for (keys, dropped) in [("", Some(Dropped::Neighbours { axis: 'X' })), ("tool = 7\n", None)] {
        let scene = load(&[("scene.toml", &free.replacen("link =", &format!("{keys}link ="), 1))]).unwrap();
        let decisions = decide(&scene, &Reach::of_limits(&scene), &Clearances::everywhere(&[]));
        assert_eq!((decisions.len(), &decisions[0].dropped), (1, &dropped), "{keys}");
    }
}

/// A machine of three slides with a block in the world, whose spindle holds tool 1.
fn holding(axes: [(char, [f64; 3]); 3], direction: [f64; 3], tool: &str) -> Result<Scene, SceneError> {
    let mut text = "title = \"\"\n".to_owned();
    let mut parent = String::new();
    for (letter, along) in axes.iter().filter(|(_, along)| *along != [0.0; 3]) {
        text += &format!(
            "[[machine.links]]\nname = \"{letter}\"\n{parent}joint = {{ axis = \"{letter}\", direction = {along:?} }}\n"
        );
        parent = format!("parent = \"{letter}\"\n");
    }
    let last = parent.trim_start_matches("parent = ").trim_end();
    text += &format!(
        "[[parts]]\nname = \"block\"\nat = {{ xyz_mm = [500, 500, 500] }}\nmesh = \"t.stl\"\n\
         [program]\nfile = \"p.ngc\"\ntool_centre_point = {{ tool_link = {last}, direction = {direction:?} }}\n\
         tools = [{{ number = 1, diameter_mm = 10, flute_mm = 20, holder = [{{ diameter_mm = 30, length_mm = 60 }}], {tool} }}]\n"
    );
    load(&[("scene.toml", &text), ("p.ngc", "M2\n")])
}

#[test]
fn the_length_of_a_tool_goes_to_the_axes_that_lie_along_it() {
    let offsets = |axes, direction, tool: &str| {
        let offset = holding(axes, direction, tool).unwrap().program.unwrap().setup.tools[&1].offset;
        [Axis::X, Axis::Y, Axis::Z].map(|axis| (offset[axis] * 1e6).round() / 1e6)
    };
    let upright = [('X', [1.0, 0.0, 0.0]), ('Y', [0.0, 1.0, 0.0]), ('Z', [0.0, 0.0, 1.0])];
    assert_eq!(offsets(upright, [0.0, 0.0, -1.0], "stickout_mm = 40"), [0.0, 0.0, 100.0]);
    // A lathe without Y, drawn with +X towards -x: the tool points along +x.
    let lathe = [('X', [-1.0, 0.0, 0.0]), ('Y', [0.0; 3]), ('Z', [0.0, 0.0, 1.0])];
    assert_eq!(offsets(lathe, [1.0, 0.0, 0.0], "stickout_mm = 40"), [100.0, 0.0, 0.0]);
    // A horizontal spindle along y, which the machine calls Z.
    let horizontal = [('X', [-1.0, 0.0, 0.0]), ('Y', [0.0, 0.0, 1.0]), ('Z', [0.0, 1.0, 0.0])];
    assert_eq!(offsets(horizontal, [0.0, -1.0, 0.0], "stickout_mm = 40"), [0.0, 0.0, 100.0]);
    // A given offset is read as that length: 110 less the holder's 60.
    let scene = holding(horizontal, [0.0, -1.0, 0.0], "offset = { z_mm = 110 }").unwrap();
    assert_eq!(scene.drawn_tools[0].length_mm, 110.0);
    let cutter = scene.part("tool-1-cutter").unwrap();
    assert_eq!(scene.parts[cutter].link_from_part.translation.y, -110.0);
    // Where the axes are askew, a length is no offset.
    let askew = [('X', [1.0, 0.0, 0.0]), ('Y', [0.6, 0.8, 0.0]), ('Z', [0.0, 0.0, 1.0])];
    let error = holding(askew, [0.0, 0.0, -1.0], "stickout_mm = 40").unwrap_err().to_string();
    assert!(error.contains("scene.toml:") && error.contains("give both `offset` and `stickout_mm`"), "{error}");
    assert_eq!(offsets(askew, [0.0, 0.0, -1.0], "stickout_mm = 40, offset = { z_mm = 99 }"), [0.0, 0.0, 99.0]);
}

#[test]
fn what_there_is_to_tell_of_a_tool_is_told_by_the_table_in_force() {
    let upright = [('X', [1.0, 0.0, 0.0]), ('Y', [0.0, 1.0, 0.0]), ('Z', [0.0, 0.0, 1.0])];
    let scene = holding(upright, [0.0, 0.0, -1.0], "stickout_mm = 40, offset = { z_mm = 95 }").unwrap();
    let mut table = scene.program.as_ref().unwrap().setup.tools.clone();
    let differs = "tool 1 is 100.000 mm long from the gauge line to its tip, and its offset says 95.000 mm";
    assert_eq!(scene.tool_notes(&table), [differs]);
    table.get_mut(&1).unwrap().offset[Axis::Z] = 100.25;
    assert!(scene.tool_notes(&table).is_empty());
    table.get_mut(&1).unwrap().diameter_mm = 9.5;
    assert!(scene.tool_notes(&table).is_empty());
    table.get_mut(&1).unwrap().diameter_mm = 0.25;
    let differs = "tool 1 is drawn 10.000 mm wide, and the tool table says 0.250 mm, which G41 and G42 go by";
    assert_eq!(scene.tool_notes(&table), [differs]);
    assert!(scene.tool_notes(&std::collections::BTreeMap::new()).is_empty());
}

#[test]
fn tool_centre_point_refuses_linear_letters_that_turn() {
    let scene = "title = \"\"\n[[machine.links]]\nname = \"tilt\"\njoint = { axis = \"U\", turns = true, direction = [1, 0, 0] }\n\
                 [[parts]]\nname = \"a\"\nlink = \"tilt\"\nmesh = \"t.stl\"\n[[parts]]\nname = \"b\"\nmesh = \"t.stl\"\n\
                 [program]\nfile = \"p.ngc\"\ntool_centre_point = { tool_link = \"tilt\" }\n";
    let text = error_of(&[("scene.toml", scene), ("p.ngc", "M2\n")]).1;
    assert!(text.starts_with("scene.toml:14:21: tool_centre_point: axis U turns link `tilt`"), "{text}");
    let named = scene.replacen("\"U\", turns = true", "\"A\"", 1);
    assert!(load(&[("scene.toml", &named), ("p.ngc", "M2\n")]).is_ok());
}

const WITH_URDF: &str = "title = \"\"\n[machine]\nurdf = \"r.urdf\"\naxes = { slide = \"Z\" }\n\
                         [[parts]]\nname = \"tip\"\nlink = \"carriage\"\nmesh = \"t.stl\"\n";

#[cfg(not(feature = "urdf"))]
#[test]
fn urdf_needs_its_feature() {
    let text = error_of(&[("scene.toml", WITH_URDF)]).1;
    assert_eq!(text, "scene.toml:2:1: URDF is read only by a build with `--features urdf`");
}

#[test]
fn keys_of_urdf_want_urdf() {
    let text =
        error_of(&[("scene.toml", &SLIDE.replacen("[[machine", "[machine]\naxes = { a = \"X\" }\n[[machine", 1))]).1;
    assert_eq!(text, "scene.toml:3:1: `axes` and `form` go with `urdf`");
}

#[cfg(feature = "urdf")]
mod urdf {
    use super::*;

    const ROBOT: &str = r#"<robot name="robot">
  <link name="bed"><visual><geometry><box size="1 0.5 0.1"/></geometry></visual></link>
  <link name="carriage">
    <visual><geometry><mesh filename="t.stl" scale="0.002 0.002 0.002"/></geometry></visual>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="bed"/><child link="carriage"/><axis xyz="0 0 1"/><limit lower="0.1" upper="0.2" effort="0" velocity="1"/>
  </joint>
</robot>
"#;

    #[test]
    fn a_urdf_file_is_a_machine_with_parts() {
        let loaded = load(&[("scene.toml", WITH_URDF), ("r.urdf", ROBOT)]).unwrap();
        let names: Vec<&str> = loaded.parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["bed", "carriage", "tip"]);
        assert_eq!(loaded.machine.axis_limits(Axis::Z), Some([100.0, 200.0]));
        assert_eq!(loaded.pairs, [Pair { a: 0, b: 1 }, Pair { a: 0, b: 2 }]);
        // The tetrahedron's legs are 1 unit, and a unit is 0.002 m.
        let reach = |part: usize| loaded.parts[part].mesh.vertices().iter().map(|v| v.x).fold(0.0, f64::max);
        assert_eq!((reach(0), reach(1), reach(2)), (500.0, 2.0, 1.0));
        let inputs: Vec<&str> = loaded.inputs.keys().map(|key| key.split_once('/').unwrap().1).collect();
        assert_eq!(inputs, ["r.urdf", "scene.toml", "t.stl"]);
    }

    #[test]
    fn a_density_is_for_the_shapes_of_a_urdf_file_alone() {
        let scene = |density: &str| {
            let scene = WITH_URDF.replacen("axes", &format!("{density}axes"), 1);
            scene.replacen("mesh = \"t.stl\"", "shape = { kind = \"sphere\", radius_mm = 20 }", 1)
        };
        let faces = |density: &str| {
            let loaded = load(&[("scene.toml", &scene(density)), ("r.urdf", ROBOT)]).unwrap();
            ["bed", "tip"].map(|part| loaded.parts[loaded.part(part).unwrap()].mesh.faces().len())
        };
        let ([bed, tip], [coarse, same]) = (faces(""), faces("density = 0.5\n"));
        assert!(2 * coarse < bed && same == tip, "{coarse} {bed}, {same} {tip}");
        let (_, text) = error_of(&[("scene.toml", &scene("density = -1\n")), ("r.urdf", ROBOT)]);
        assert!(text.starts_with("r.urdf:2:15: part `bed`: ") && text.contains("density"), "{text}");
    }

    #[test]
    fn parts_of_a_urdf_file_are_checked_and_reported_like_others() {
        let loaded = load(&[("scene.toml", WITH_URDF), ("r.urdf", ROBOT)]).unwrap();
        let reports: Vec<(&str, &str)> =
            loaded.mesh_files.iter().map(|mesh| (mesh.part.as_str(), mesh.file.as_str())).collect();
        assert_eq!(reports, [("carriage", "t.stl"), ("tip", "t.stl")]);
        assert!(loaded.parts[0].shape.is_some() && loaded.parts[1].shape.is_none());
        let robot = ROBOT.replace("\"bed\"", "\"=bed\"");
        let text = error_of(&[("scene.toml", WITH_URDF), ("r.urdf", &robot)]).1;
        assert_eq!(text, "r.urdf:2:15: the name `=bed` begins like a spreadsheet's formula");
    }

    #[test]
    fn a_mesh_of_a_package_is_in_that_package() {
        let scene = WITH_URDF.replacen("r.urdf", "src/arm/urdf/r.urdf", 1);
        let robot = ROBOT.replacen("t.stl", "package://grip/meshes/t.stl", 1);
        let wide = TETRAHEDRON.replace("vertex 1 0 0", "vertex 3 0 0");
        // A unit is 2 mm: the mesh of the arm reaches to 2 mm along X, and that of the gripper to 6.
        let mesh = |more: &[(&str, &str)]| -> Result<f64, String> {
            let own =
                [("scene.toml", &*scene), ("src/arm/urdf/r.urdf", &*robot), ("src/arm/meshes/t.stl", TETRAHEDRON)];
            let carriage = load(&[&own[..], more].concat()).map_err(|error| error.to_string())?.parts.swap_remove(1);
            Ok(carriage.mesh.vertices().iter().map(|v| v.x).fold(0.0, f64::max))
        };
        let manifest = |name: &str| format!("<package format=\"3\">\n  <name>{name}</name>\n</package>\n");
        assert_eq!(mesh(&[("src/grip/meshes/t.stl", &wide)]), Ok(6.0));
        assert_eq!(mesh(&[("src/arm/package.xml", &manifest("grip"))]), Ok(2.0));
        let other = manifest("arm");
        for more in [&[][..], &[("src/arm/package.xml", &*other)]] {
            let missing = mesh(more).unwrap_err();
            assert!(missing.contains("there is no mesh `package://grip/meshes/t.stl`; tried "), "{missing}");
            assert!(missing.contains("/src/arm/urdf/../../grip/meshes/t.stl, "), "{missing}");
            assert!(missing.ends_with("needs a `package.xml` that names the package"), "{missing}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_urdf_file_is_said_with_its_place() {
        let text = |robot: &str| error_of(&[("scene.toml", WITH_URDF), ("r.urdf", robot)]).1;
        let missing = text(&ROBOT.replacen("t.stl", "u.stl", 1));
        assert_eq!(missing, "r.urdf:3:15: part `carriage`: there is no mesh `u.stl`; tried u.stl");
        let cycle = text(&ROBOT.replacen("parent link=\"bed\"", "parent link=\"carriage\"", 1));
        assert_eq!(cycle, "r.urdf:3:15: links stand on one another in a circle: carriage -> carriage");
        let mimic = text(&ROBOT.replacen("<limit", "<mimic joint=\"other\"/><limit", 1));
        assert!(mimic.starts_with("r.urdf:6:16: joint `slide` mimics `other`"), "{mimic}");
        let planar = text(&ROBOT.replacen("prismatic", "planar", 1));
        assert!(planar.starts_with("r.urdf:6:16: joint `slide` is planar"), "{planar}");
        let flat = text(&ROBOT.replacen("0.1\"/></geometry>", "0\"/></geometry>", 1));
        assert!(flat.starts_with("r.urdf:2:15: part `bed`: "), "{flat}");
        assert!(text("<robot").starts_with("r.urdf:1:1: "));
        let both = WITH_URDF.replacen("axes", "file = \"m.toml\"\naxes", 1);
        let text = error_of(&[("scene.toml", &both), ("r.urdf", ROBOT)]).1;
        assert_eq!(text, "scene.toml:2:1: a machine has a URDF file, a file or links, and only one of them");
    }
}
