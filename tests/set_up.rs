//! Setting up a job from outside: `scene new` from mesh files, tools and stock from the command line, extents and warnings.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use serde_json::Value;
use support::{Folder, words};

/// A mill whose table moves in X and Y and whose head moves in Z; the spindle's nose is 200 mm above the table's top at zero.
const MILL: &str = r#"
title = "a mill"

machine.links = [
  { name = "saddle", joint = { axis = "Y", direction = [0, -1, 0], min_mm = -300, max_mm = 300 } },
  { name = "table", parent = "saddle", joint = { axis = "X", direction = [-1, 0, 0], min_mm = -300, max_mm = 300 } },
  { name = "head", joint = { axis = "Z", direction = [0, 0, 1], min_mm = -200, max_mm = 0 } },
]
parts = [
  { name = "table", link = "table", shape = { kind = "rounded-box", size_mm = [400, 300, 40] }, at = { xyz_mm = [0, 0, -20] } },
  { name = "block", role = "workpiece", link = "table", shape = { kind = "rounded-box", size_mm = [100, 60, 30] }, at = { xyz_mm = [0, 0, 15] } },
  { name = "jaw", role = "fixture", link = "table", shape = { kind = "rounded-box", size_mm = [140, 20, 50] }, at = { xyz_mm = [0, 45, 25] } },
  { name = "spindle", link = "head", shape = { kind = "cylinder", radius_mm = 40, height_mm = 100 }, at = { xyz_mm = [0, 0, 200] } },
]
"#;

const HELD: &str =
    "\n[program.tool_centre_point]\ntool_link = \"head\"\ngauge_mm = [0, 0, 200]\nwork_link = \"table\"\n";

/// Zero is the middle of the block's top, 30 mm above the table: 170 mm below the nose at Z0. Along the jaw at Y26.
const PROGRAM: &str =
    "G21 G90 G94 G54\nT1 M6\nS3000 M3\nG43 H1\nG0 X-70 Y26\nG0 Z5\nG1 Z-10 F300\nG1 X70\nG0 Z20\nM2\n";
const OFFSET: [&str; 2] = ["--offset", "G54=0,0,-170"];

fn folder() -> Folder {
    let with_spindle = format!("{MILL}\n[program]\nfile = \"part.ngc\"{HELD}");
    Folder::with(&[
        ("mill/scene.toml", with_spindle.as_str()),
        ("mill/part.ngc", "M2\n"),
        ("bare/scene.toml", MILL),
        ("part.ngc", PROGRAM),
    ])
}

/// What `check --json` says, and what it tells on standard error.
fn check(folder: &Folder, arguments: &[&str]) -> (Value, String, Option<i32>) {
    let all: Vec<&str> = ["check"]
        .iter()
        .chain(arguments)
        .chain(&OFFSET)
        .chain(&["--json", "--quiet", "--clearance", "0"])
        .copied()
        .collect();
    let output = folder.run(&all);
    let told = String::from_utf8(output.stderr).unwrap();
    let found = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{all:?}: {told}"));
    (found, told, output.status.code())
}

/// Kind, line and pair of each event.
fn events(found: &Value) -> Vec<(String, u64, String)> {
    let event = |event: &Value| {
        let pair = [&event["pair"][0], &event["pair"][1]].map(|part| part.as_str().unwrap()).join(":");
        (event["kind"].as_str().unwrap().to_owned(), event["line"].as_u64().unwrap(), pair)
    };
    found["events"].as_array().unwrap().iter().map(event).collect()
}

#[test]
fn a_tool_by_its_measures_cuts_and_its_holder_collides() {
    let folder = folder();
    // The holder's lower end, 32 mm wide, is 20 mm above the tip: at Z-10 it is at Z10, below the jaw's top at Z20, and reaches from Y26 to Y42.
    let short = "1=diameter:10,flute:15,stickout:20,holder:32x60";
    let (found, told, code) = check(&folder, &["mill", "part.ngc", "--tool", short]);
    assert_eq!(code, Some(1), "{told}");
    assert_eq!(events(&found)[0], ("collision".to_owned(), 7, "jaw:tool-1-holder".to_owned()), "{found}");
    // The same 20 mm farther out passes over the jaw: its holder is at Z30.
    let long = "1=diameter:10,flute:15,stickout:40,holder:32x60";
    let (found, told, code) = check(&folder, &["mill", "part.ngc", "--tool", long]);
    assert_eq!((code, events(&found).len()), (Some(0), 0), "{found} {told}");
    assert!(told.contains("tool 1 is in the spindle at first"), "{told}");
}

#[test]
fn origins_of_g54_1_and_g154_are_given_from_outside() {
    let folder = folder();
    let tool = ["mill", "part.ngc", "--tool", "1=diameter:10,flute:15,stickout:40,holder:32x60"];
    let checked = |system: &str, options: &[&str]| {
        folder.write("part.ngc", &PROGRAM.replacen("G54", system, 1));
        let (found, told, code) = check(&folder, &[&tool[..], options].concat());
        (code, events(&found).len(), told)
    };
    for (dialect, system, name) in
        [("haas", "G154 P12", "G154P12"), ("haas", "G154 P12", "g54.1 p12"), ("fanuc", "G54.1 P298", "G54.1P298")]
    {
        let offset = format!("{name}=0,0,-170");
        let (code, events, told) = checked(system, &["--dialect", dialect, "--offset", &offset]);
        assert_eq!((code, events, told.contains("nothing has set it")), (Some(0), 0, false), "{system}: {told}");
    }
    for (dialect, is_given) in [("linuxcnc", true), ("haas", true), ("fanuc", false)] {
        let offset = if is_given { &["--offset", "G55=0,0,0"][..] } else { &[] };
        let (_, _, told) = checked("G55", &[&["--dialect", dialect], offset].concat());
        assert_eq!(told.contains("nothing has set it (`--offset G55=X,Y,Z`)"), !is_given, "{dialect}: {told}");
    }
    // At zero the block is above the machine's limit.
    let (code, _, told) = checked("G154 P12", &["--dialect", "haas"]);
    assert!(code == Some(1) && told.contains("`--offset G154P12=X,Y,Z`"), "{told}");
    let program =
        "[program]\nfile = \"part.ngc\"\ndialect = \"haas\"\nwork_offsets = { \"G154P12\" = { z_mm = -170 } }";
    folder.write("mill/scene.toml", &format!("{MILL}\n{program}{HELD}"));
    let (code, events, told) = checked("G154 P12", &[]);
    assert_eq!((code, events), (Some(0), 0), "{told}");
    for (dialect, name, message) in [
        ("linuxcnc", "G54.1P1", "`G54.1P1` is not one of G54"),
        ("fanuc", "G154P1", "G59.3, G54.1P1 to G54.1P298"),
        ("haas", "G54.1P299", "G54.1P298, G154P1 to G154P99"),
        ("haas", "G154P100", "`G154P100` is not one of G54"),
        ("haas", "G54.1P0", "`G54.1P0` is not one of G54"),
    ] {
        let offset = format!("{name}=0,0,0");
        let told = folder.refused(&["check", "mill", "part.ngc", "--dialect", dialect, "--offset", &offset]);
        assert!(told.contains(message), "{dialect} {name}: {told}");
    }
}

/// A tool on a quill (W) over a plate that B turns away.
const QUILL: &str = r#"
title = "a quill and a plate"
machine.links = [
  { name = "head", joint = { axis = "Z", direction = [0, 0, 1] } },
  { name = "quill", parent = "head", joint = { axis = "W", direction = [0, 0, 1] } },
  { name = "table", joint = { axis = "B", direction = [0, 1, 0] } },
]
parts = [
  { name = "tool", link = "quill", shape = { kind = "rounded-box", size_mm = [10, 10, 40] }, at = { xyz_mm = [0, 0, 20] } },
  { name = "plate", link = "table", shape = { kind = "rounded-box", size_mm = [20, 20, 10] }, at = { xyz_mm = [0, 0, -50] } },
]
[program]
file = "own.ngc"
start = { z_mm = 100 }
"#;

#[test]
fn axes_that_an_offset_leaves_out_keep_the_origin_of_the_scene() {
    let folder = Folder::with(&[]);
    // The plate's top is at -45. At W-100 the tool comes through it, unless B turns the plate away.
    for (origin, offset, program, code) in [
        ("w_mm = -100", None, "G0 Z0 W0", 1),
        ("w_mm = -100", Some("0,0,0"), "G0 Z0 W0", 1),
        ("w_mm = -100", Some("0,0,0,0,0,0"), "G0 Z0 W0", 1),
        ("w_mm = -100", Some("0,0,0,0,0,0,0,0,0"), "G0 Z0 W0", 0),
        ("z_mm = 0", Some("0,0,0,0,0,0,0,0,-100"), "G0 Z0 W0", 1),
        ("b_deg = 90", None, "G0 B0\nG0 Z-60", 0),
        ("b_deg = 90", Some("0,0,0"), "G0 B0\nG0 Z-60", 0),
        ("b_deg = 90", Some("0,0,0,0,0,0"), "G0 B0\nG0 Z-60", 1),
        ("z_mm = 0", Some("0,0,0,0,90,0"), "G0 B0\nG0 Z-60", 0),
    ] {
        folder.write("quill/scene.toml", &format!("{QUILL}work_offsets = {{ G54 = {{ {origin} }} }}\n"));
        folder.write("job.ngc", &format!("G21 G90 G54\n{program}\nM2\n"));
        let offset: Vec<String> = offset.iter().map(|numbers| format!("--offset=G54={numbers}")).collect();
        let offset: Vec<&str> = offset.iter().map(String::as_str).collect();
        let check = ["check", "quill", "job.ngc", "--quiet", "--clearance", "0"];
        let output = folder.run(&[&check[..], &offset[..]].concat());
        assert_eq!(output.status.code(), Some(code), "{origin} {offset:?} {program}: {output:?}");
    }
}

#[test]
fn a_tool_that_is_not_there_is_named_with_what_to_do() {
    let folder = folder();
    let message = folder.refused(&["check", "mill", "part.ngc"]);
    assert!(
        message.contains("part.ngc:4:5") && message.contains("--tool N=") && message.contains("--tools"),
        "{message}"
    );
}

#[test]
fn the_length_of_a_tool_is_its_offset_and_a_measured_table_goes_before_it() {
    let folder = folder();
    folder.write("tool.tbl", "T1 P1 Z+95.0 D+10.0\n");
    let tool = "1=diameter:10,flute:15,stickout:40,holder:32x60";
    let (_, told, _) = check(&folder, &["mill", "part.ngc", "--tool", tool, "--tool-table", "tool.tbl"]);
    assert!(told.contains("tool 1 is 100.000 mm long") && told.contains("its offset says 95.000 mm"), "{told}");
    // Without a stick-out the table decides it: 95 less the holder's 60.
    let (found, told, code) = check(
        &folder,
        &["mill", "part.ngc", "--tool", "1=diameter:10,flute:15,holder:32x60", "--tool-table", "tool.tbl"],
    );
    assert_eq!((code, events(&found).len()), (Some(0), 0), "{told}");
    assert!(!told.contains("mm long"), "{told}");
    // The table goes before what a library says, and tools of the scene are told of by the table, too.
    let tool = "diameter_mm = 10, flute_mm = 15, stickout_mm = 40, offset = { z_mm = 80 }";
    folder.write("shop.toml", &format!("tools = [{{ number = 1, {tool} }}]\n"));
    let (_, told, _) = check(&folder, &["mill", "part.ngc", "--tools", "shop.toml", "--tool-table", "tool.tbl"]);
    assert!(told.contains("its offset says 95.000 mm") && told.contains("tool 1 has no holder"), "{told}");
    let (_, told, _) = check(&folder, &["mill", "part.ngc", "--tools", "shop.toml"]);
    assert!(told.contains("its offset says 80.000 mm"), "{told}");
    let scene = format!("{MILL}\n[program]\nfile = \"part.ngc\"\ntools = [{{ number = 1, {tool} }}]\n{HELD}");
    folder.write("mill/scene.toml", &scene);
    let (_, told, _) = check(&folder, &["mill", "part.ngc"]);
    assert!(told.contains("its offset says 80.000 mm") && told.contains("tool 1 has no holder"), "{told}");
    let (_, told, _) = check(&folder, &["mill", "part.ngc", "--tool-table", "tool.tbl"]);
    assert!(told.contains("tool 1 is 40.000 mm long") && told.contains("its offset says 95.000 mm"), "{told}");
    let (_, _, told) = folder.told(&["scene", "info", "mill"]);
    assert!(told.contains("tool 1 has no holder"), "{told}");
}

#[test]
fn a_length_that_the_program_sets_is_compared_with_the_drawn_tool() {
    let folder = folder();
    let tool = ["mill", "part.ngc", "--tool", "1=diameter:10,flute:15,stickout:40,holder:32x60", "--dialect"];
    for (dialect, program, is_told) in [
        ("fanuc", format!("G10L10P1R95.\n{PROGRAM}"), true),
        ("fanuc", format!("G10L10P1R100.\n{PROGRAM}"), false),
        ("linuxcnc", format!("G10 L1 P1 Z95\n{PROGRAM}"), true),
        ("linuxcnc", PROGRAM.replace("G43 H1", "G43.1 Z95"), true),
    ] {
        folder.write("part.ngc", &program);
        let (_, told, _) = check(&folder, &[&tool[..], &[dialect]].concat());
        assert_eq!(told.contains("its offset says 95.000 mm (the program sets it)"), is_told, "{program}: {told}");
    }
}

#[test]
fn stock_that_a_program_with_another_zero_leaves_behind_is_told() {
    let folder = folder();
    let tool = ["mill", "part.ngc", "--tool", "1=diameter:10,flute:15,stickout:40,holder:32x60", "--dialect"];
    // G54 is at Z-170, so that G92 Z160 at Z0 puts zero at Z-160.
    for (dialect, line, is_told) in [
        ("linuxcnc", "G10 L2 P1 Z-160", true),
        ("linuxcnc", "G10 L2 P1 Z-170", false),
        ("fanuc", "G92Z160.", true),
        ("haas", "#5223=-160.", true),
        ("haas", "G52Z10.", false),
    ] {
        folder.write("part.ngc", &format!("{line}\n{PROGRAM}"));
        for stock in [&[][..], &["--stock", "box:100,60,30"]] {
            let (_, told, _) = check(&folder, &[&tool[..], &[dialect], stock].concat());
            let has_note = told.contains("where the stock stays: `--offset G54=0,0,-160` puts it there");
            assert_eq!(has_note, is_told && !stock.is_empty(), "{line}: {told}");
        }
    }
    // Who follows the advice is not told again: 0.1234 inches are 3.13436 mm.
    folder.write("part.ngc", &format!("G20\nG10 L2 P1 X0.1234 Z-6.3\n{PROGRAM}"));
    let job = [&tool[..], &["linuxcnc", "--stock", "box:100,60,30"]].concat();
    let (_, told, _) = check(&folder, &job);
    let advice = told.split("`--offset ").nth(1).unwrap().split('`').next().unwrap();
    assert_eq!(advice, "G54=3.13436,0,-160.02");
    let again = [&["check"][..], &job, &["--offset", advice, "--json", "--quiet", "--clearance", "0"]].concat();
    let (_, _, told) = folder.told(&again);
    assert!(!told.contains("where the stock stays"), "{told}");
}

#[test]
fn compensation_goes_by_the_diameter_of_a_measured_table() {
    let folder = folder();
    // The side of the jaw is at Y35. The cutter covers Y21 to Y31 where it is compensated by 5 mm, to the right, and Y25.9 to Y35.9 where it is by 0.1 mm.
    let program = "G21 G90 G94 G54\nT1 M6\nS3000 M3\nG43 H1\nG0 X-90 Y31\nG0 Z-10\nG42 D1 G1 X-75 F300\nG1 X75\nG0 Z30\nG40\nM2\n";
    folder.write("wall.ngc", program);
    folder.write("drawn.tbl", "T1 P1 Z+100.0 D+10.0\n");
    folder.write("wear.tbl", "T1 P1 Z+100.0 D0.2\n");
    let holder = "holder = [{ diameter_mm = 32, length_mm = 60 }]";
    let tool = format!("number = 1, diameter_mm = 10, flute_mm = 15, stickout_mm = 40, {holder}");
    folder.write("shop.toml", &format!("tools = [{{ {tool} }}]\n"));
    for given in [["--tool", "1=diameter:10,flute:15,stickout:40,holder:32x60"], ["--tools", "shop.toml"]] {
        let told_of = "tool 1 is drawn 10.000 mm wide, and the tool table says 0.200 mm";
        for table in [&[][..], &["--tool-table", "drawn.tbl"]] {
            let (found, told, code) = check(&folder, &[&["mill", "wall.ngc"][..], &given, table].concat());
            assert_eq!((code, events(&found).len(), told.contains("wide")), (Some(0), 0, false), "{found} {told}");
        }
        let wear = ["--tool-table", "wear.tbl"];
        let (found, told, code) = check(&folder, &[&["mill", "wall.ngc"][..], &given, &wear].concat());
        assert!(code == Some(1) && told.contains(told_of), "{told}");
        assert!(events(&found).contains(&("collision".to_owned(), 8, "jaw:tool-1-cutter".to_owned())), "{found}");
    }
}

#[test]
fn a_library_replaces_tools_and_names_the_line_of_what_is_wrong() {
    let folder = folder();
    folder.write(
        "shop.toml",
        "[[tools]]\nnumber = 1\nname = \"end mill\"\ndiameter_mm = 10\nflute_mm = 15\nstickout_mm = 20\nholder = [{ diameter_mm = 32, length_mm = 60 }]\n",
    );
    let (found, _, code) = check(&folder, &["mill", "part.ngc", "--tools", "shop.toml"]);
    assert_eq!((code, events(&found)[0].1), (Some(1), 7));
    // A tool without a shape replaces the scene's drawn tool, too, though the scene has no other.
    let drawn = "tools = [{ number = 1, diameter_mm = 10, flute_mm = 15, stickout_mm = 100 }]";
    folder.write("mill/scene.toml", &format!("{MILL}\n[program]\nfile = \"part.ngc\"\n{drawn}\n{HELD}"));
    assert_eq!(check(&folder, &["mill", "part.ngc"]).2, Some(0));
    folder.write("bare.toml", "[[tools]]\nnumber = 1\ndiameter_mm = 300\noffset = { z_mm = 100 }\n");
    let (found, told, code) = check(&folder, &["mill", "part.ngc", "--tools", "bare.toml"]);
    assert_eq!((code, &found["tools_without_parts"]), (Some(1), &serde_json::json!([1])), "{told}");
    assert!(told.contains("tool 1 replaces `tool-1-cutter`, `tool-1-shank` of the scene, and has no shape"), "{told}");
    for (text, place, why) in [
        (
            "[[tools]]\nnumber = 1\ndiameter_mm = 10\nflute_mm = 15\nstickout_mm = 12\n",
            "bad.toml:1",
            "less than its flute_mm",
        ),
        ("[[tools]]\nnumber = 1\n[[tools]]\nnumber = 1\n", "bad.toml:3", "two tools with number 1"),
        ("[[tools]]\nnumber = 1\nflutes = 3\n", "bad.toml:3", "flutes"),
    ] {
        folder.write("bad.toml", text);
        let message = folder.refused(&["check", "mill", "part.ngc", "--tools", "bad.toml"]);
        assert!(message.contains(place) && message.contains(why), "{message}");
    }
}

#[test]
fn tools_that_make_no_sense_are_refused() {
    let folder = folder();
    for (tool, why) in [
        ("1", "it must be like"),
        ("one=diameter:10", "`one` is not a tool's number"),
        ("1=diameter:10", "flute and stickout are missing"),
        ("1=diameter:10,flute:20", "stickout_mm or length_mm is missing"),
        ("1=diameter:10,flute:20,stickout:15", "less than its flute_mm"),
        ("1=diameter:10,flute:20,stickout:30,corner:6", "more than half the diameter"),
        ("1=diameter:10,flute:20,stickout:30,length:70,holder:32x60", "one of the two is enough"),
        ("1=diameter:0,flute:20,stickout:30", "diameter_mm is 0"),
        ("1=diameter:nan,flute:20,stickout:30", "diameter_mm must be a finite number"),
        ("1=diameter:10,flute:20,stickout:30,holder:32", "must be diameter x length"),
        ("1=diameter:10,flute:20,stickout:30,hold:32x1", "`hold` is none of"),
        ("1=diameter:10,flute:2,stickout:30,point:90", "the tool's end alone takes 5.000"),
        ("1=diameter:10,flute:20,stickout:30,point:190", "below 180"),
        ("1=diameter:9e9,flute:20,stickout:30", ""),
    ] {
        let message = folder.refused(&["check", "mill", "part.ngc", "--tool", tool]);
        assert!(message.contains(why), "{tool}: {message}");
    }
    // Where the scene does not say where tools are held, the option does.
    let tool = "1=diameter:10,flute:15,stickout:20,holder:32x60";
    let message = folder.refused(&["check", "bare", "part.ngc", "--tool", tool]);
    assert!(message.contains("--spindle LINK@X,Y,Z"), "{message}");
    let message = folder.refused(&["check", "bare", "part.ngc", "--tool", tool, "--spindle", "heat@0,0,200"]);
    assert!(message.contains("no link named `heat`"), "{message}");
    let (found, _, code) = check(&folder, &["bare", "part.ngc", "--tool", tool, "--spindle", "head@0,0,200"]);
    assert_eq!((code, events(&found)[0].1), (Some(1), 7));
}

#[test]
fn a_spindle_keeps_what_the_scene_says_of_it() {
    let folder = folder();
    // A link of the head that is drawn upside down.
    let turned = "  { name = \"nose\", parent = \"head\", at = { rpy_deg = [180, 0, 0] } },\n]\nparts";
    let turned = format!("{}\n[program]\nfile = \"part.ngc\"{HELD}", MILL.replacen("]\nparts", turned, 1));
    folder.write("mill/scene.toml", &turned);
    let job = ["mill", "part.ngc", "--tool", "1=diameter:10,flute:15,stickout:20,holder:32x60"];
    let own = events(&check(&folder, &job).0);
    assert!(!own.is_empty());
    for spindle in ["head", "head@0,0,200", "nose@0,0,-200"] {
        let (found, told, _) = check(&folder, &[&job[..], &["--spindle", spindle][..]].concat());
        assert_eq!(events(&found), own, "{spindle}: {told}");
    }
    for (scene, spindle) in [("mill", "saddle"), ("bare", "head")] {
        let message =
            folder.refused(&["check", scene, "part.ngc", job[2], job[3], "--spindle", spindle, "--table", "table"]);
        assert!(message.contains(&format!("give it as in {spindle}@0,0,0")), "{message}");
    }
}

#[test]
fn a_spindle_takes_the_tools_of_the_scene_along() {
    let folder = folder();
    // Tool 2 has no measures, so nobody can say where it goes.
    let drill = "{ name = \"drill\", role = \"cutter\", link = \"head\", tool = 2, shape = { kind = \"sphere\", radius_mm = 2 }, at = { xyz_mm = [0, 0, 150] } }";
    let drawn = format!("{}  {drill},\n]\n", MILL.strip_suffix("]\n").unwrap());
    let program = "[program]\nfile = \"part.ngc\"\n";
    let tool = "{ number = 1, diameter_mm = 10, flute_mm = 15, stickout_mm = 20, holder = [{ diameter_mm = 32, length_mm = 60 }] }";
    let ignored = "[check]\nignore = [[\"spindle\", \"tool-1-holder\"]]\n";
    folder.write("mill/scene.toml", &format!("{drawn}{program}{HELD}"));
    folder.write("own/scene.toml", &format!("{drawn}{program}tools = [{tool}]\n{HELD}{ignored}"));
    folder.write("own/part.ngc", "M2\n");
    let given = ["mill", "part.ngc", "--tool", "1=diameter:10,flute:15,stickout:20,holder:32x60"];
    let mut lines = Vec::new();
    for (spindle, is_moved) in [("head@0,0,200", false), ("head@0,0,180", true), ("head@0,30,200", true)] {
        let found = events(&check(&folder, &[&given[..], &["--spindle", spindle][..]].concat()).0);
        let (own, told, _) = check(&folder, &["own", "part.ngc", "--spindle", spindle]);
        assert_eq!(events(&own), found, "{spindle}: {told}");
        assert_eq!(told.contains("`drill` stay where they are drawn"), is_moved, "{spindle}: {told}");
        lines.push(found.first().map(|event| event.1));
    }
    assert!(lines[0] == Some(7) && lines[1] == Some(6), "{lines:?}");
}

#[test]
fn stock_lies_in_the_coordinates_of_the_program() {
    let folder = folder();
    let tool = ["--tool", "1=diameter:10,flute:15,stickout:40,holder:32x60"];
    // A block that is 5 mm higher than the scene's is met by the rapid to Z5 beside it, at Y26 with a radius of 5: its side is at Y30.
    let at = |stock: &str| check(&folder, &["mill", "part.ngc", tool[0], tool[1], "--stock", stock]);
    let (_, told, code) = at("box:100,60,30");
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("X -50.000 to 50.000, Y -30.000 to 30.000, Z -30.000 to 0.000 in G54"), "{told}");
    assert!(told.contains("the stock replaces `block`"), "{told}");
    let (found, told, code) = at("box:200,60,40@-100,-30,-30");
    assert_eq!(code, Some(1), "{told}");
    assert_eq!(events(&found)[0], ("rapid-into-workpiece".to_owned(), 6, "tool-1-cutter:stock".to_owned()), "{found}");
    // The same as a mesh file in inches, and as a cylinder that is that wide at Y26.
    let output = folder.run(&["scene", "export", "mill", "--out", "parts"]);
    assert!(output.status.success());
    let (_, told, code) = at("parts/block.stl@0,0,-30");
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("Z -30.000 to 0.000 in G54"), "{told}");
    let (found, _, code) = at("cylinder:190,40@0,0,-30");
    assert_eq!((code, events(&found)[0].1), (Some(1), 6), "{found}");
    for (stock, why) in [
        ("box:1,2", "3 finite numbers"),
        ("box:1,2,0", "must be above 0"),
        ("cylinder:1,nan", "2 finite numbers"),
        ("nowhere.stl", "nowhere.stl"),
        ("box:1,2,3@4,5", "3 finite numbers"),
    ] {
        let message = folder.refused(&["check", "mill", "part.ngc", tool[0], tool[1], "--stock", stock]);
        assert!(message.contains(why), "{stock}: {message}");
    }
}

#[test]
fn stock_is_not_put_where_an_axis_does_not_move_the_tool_over_it() {
    // Table and spindle alone: no part says what carries the work.
    let [block, spindle] = ["block", "spindle"].map(|name| MILL.find(&format!("  {{ name = \"{name}\"")).unwrap());
    let bare = [&MILL[..block], &MILL[spindle..]].concat();
    let lacks = HELD.replace("work_link = \"table\"\n", "");
    let program = "G21 G90 G94 G54\nT1 M6\nG43 H1\nG0 Z5\nG0 X80\nG0 Z-10\nG0 X-80\nM2\n";
    let folder = Folder::with(&[
        ("bare/scene.toml", bare.as_str()),
        ("lacks/scene.toml", &format!("{bare}\n[program]\nfile = \"p.ngc\"{lacks}")),
        ("lacks/p.ngc", "M2\n"),
        ("part.ngc", program),
    ]);
    let job = ["--tool", "1=diameter:10,flute:15,stickout:20,holder:40x30", "--stock", "box:60,60,30"];
    let spindle = ["--spindle", "head@0,0,200"];
    let all = |scene: &'static str, more: &[&'static str]| [&[scene, "part.ngc"][..], &job[..], more].concat();
    let refused =
        |scene, more: &[&'static str]| folder.refused(&[&["check"][..], &all(scene, more)[..], &OFFSET].concat());
    let message = refused("bare", &spindle);
    assert!(message.contains("--spindle needs --table LINK"), "{message}");
    for (scene, more) in
        [("bare", &[spindle[0], spindle[1], "--table", "world"][..]), ("lacks", &[]), ("lacks", &["--table", "saddle"])]
    {
        let message = refused(scene, more);
        assert!(message.contains("axis X does not move the tool over") && message.contains("--table"), "{message}");
    }
    for (scene, more) in [("bare", &[spindle[0], spindle[1], "--table", "table"][..]), ("lacks", &["--table", "table"])]
    {
        let (found, told, code) = check(&folder, &all(scene, more));
        assert_eq!((code, events(&found)[0].1), (Some(1), 7), "{found}");
        assert!(told.contains("in G54, on link `table`"), "{told}");
    }
}

#[test]
fn a_tool_is_not_put_where_an_axis_does_not_move_it() {
    let folder = folder();
    let tool = ["--tool", "1=diameter:10,flute:15,stickout:20,holder:32x60"];
    let why = "does not move the tool over the workpiece";
    // Z moves neither the world nor the saddle.
    for held in [HELD.replace("tool_link = \"head\"\n", ""), HELD.replace("\"head\"", "\"saddle\"")] {
        let scene = |tools: &str| format!("{MILL}\n[program]\nfile = \"part.ngc\"\n{tools}{held}");
        folder.write("mill/scene.toml", &scene(""));
        let message = folder.refused(&["check", "mill", "part.ngc", tool[0], tool[1]]);
        assert!(message.contains("tool 1: axis ") && message.contains(why), "{message}");
        let job = ["mill", "part.ngc", tool[0], tool[1], "--spindle", "head@0,0,200"];
        let (found, told, code) = check(&folder, &job);
        assert_eq!((code, events(&found)[0].1), (Some(1), 7), "{told}");
        folder.write(
            "mill/scene.toml",
            &scene("tools = [{ number = 1, diameter_mm = 10, flute_mm = 15, stickout_mm = 20 }]\n"),
        );
        let message = folder.refused(&["check", "mill"]);
        assert!(
            message.contains("scene.toml:") && message.contains("tool 1: axis ") && message.contains(why),
            "{message}"
        );
    }
}

#[test]
fn stock_turns_with_the_table_and_lies_along_a_lathes_spindle() {
    // A table turned by 90 degrees about C when G54 has C90: the stock's X is the machine's X all the same.
    let folder = Folder::with(&[
        (
            "turned/scene.toml",
            "title = \"t\"\n[[machine.links]]\nname = \"c\"\njoint = { axis = \"C\", direction = [0, 0, -1], point_mm = [10, 0, 0] }\n[[machine.links]]\nname = \"x\"\njoint = { axis = \"X\", direction = [1, 0, 0] }\n[[machine.links]]\nname = \"y\"\nparent = \"x\"\njoint = { axis = \"Y\", direction = [0, 1, 0] }\n[[machine.links]]\nname = \"z\"\nparent = \"y\"\njoint = { axis = \"Z\", direction = [0, 0, 1] }\n[[parts]]\nname = \"quill\"\nlink = \"z\"\nshape = { kind = \"sphere\", radius_mm = 5 }\nat = { xyz_mm = [0, 0, 200] }\n[[parts]]\nname = \"faceplate\"\nlink = \"c\"\nshape = { kind = \"cylinder\", radius_mm = 50, height_mm = 10 }\nat = { xyz_mm = [10, 0, -60] }\n[program]\nfile = \"p.ngc\"\nstart = { z_mm = 100 }\nwork_offsets = { G54 = { x_mm = 10, c_deg = 90 } }\ntool_centre_point = { tool_link = \"z\", work_link = \"c\" }\n",
        ),
        ("turned/p.ngc", "G21 G90 G54\nG0 Z100\nC0\nG0 X50 Y0\nG0 Z3\nM2\n"),
    ]);
    // In G54 the block reaches 100 mm along X and 10 along Y. After C0 in G54 (machine C90) the tool comes down at X50 Y0 of G54: into the block along X, and beside the one along Y.
    let tool = "1=diameter:2,flute:5,stickout:20";
    let run = |stock: &str| {
        let output =
            folder.run(&["check", "turned", "--tool", tool, "--stock", stock, "--json", "--quiet", "--clearance", "0"]);
        let found: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
        events(&found).into_iter().map(|event| event.1).collect::<Vec<_>>()
    };
    // G43 is not in force, so the tip is 20 mm below: Z100 has it at 80, Z3 at -17.
    assert_eq!(run("box:100,10,10@-2,-5,0").first(), Some(&5));
    assert_eq!(run("box:10,200,10@-5,-100,0"), [0_u64; 0], "Y of G54 is not X of G54");
}

#[test]
fn a_new_scene_loads_shows_its_extents_and_checks() {
    let folder = folder();
    folder.done(&["scene", "export", "mill", "--out", "parts"]);
    let new = words(
        "scene new shop --machine mill --gauge 0,0,200 --limits Z=-200,0 --part parts/table.stl:machine:X \
         parts/block.stl:workpiece parts/jaw.stl:fixture parts/spindle.stl:machine:z",
    );
    let said = folder.done(&new);
    assert!(said.contains("400.0 x 300.0 x 40.0") && said.contains("all together"), "{said}");
    assert_eq!(folder.run(&["check", "shop", "--quiet"]).status.code(), Some(0), "the first program touches nothing");
    // It behaves like the scene that its parts came from.
    let tool = ["--tool", "1=diameter:10,flute:15,stickout:20,holder:32x60"];
    let [old, new_] = ["mill", "shop"].map(|scene| events(&check(&folder, &[scene, "part.ngc", tool[0], tool[1]]).0));
    assert_eq!(old, new_);
    // A scene is not written over.
    let message = folder.refused(&new);
    assert!(message.contains("there is a scene already"), "{message}");
}

#[test]
fn what_is_no_mesh_no_program_or_no_file_is_named_as_the_user_named_it() {
    let folder = folder();
    folder.write("bad.stl", "solid cut off\nfacet normal 0 0 1\n");
    folder.write("empty.ngc", "");
    for (command, expected) in [
        ("scene new shop --machine mill --part bad.stl:machine:X", "cannot read bad.stl: line "),
        ("check mill mill/scene.toml", "mill/scene.toml: this is a file of settings, not a program"),
        ("check mill part.ngc --sarif mill", "--sarif mill: this is a folder; name a file"),
        ("scene export mill --out part.ngc", "--out part.ngc: this is a file; name a folder"),
        ("repro --scene mill --profile smoke --out part.ngc", "--out part.ngc: this is a file; name a folder"),
        ("check mill part.ngc --clearance -3", "-3"),
        (
            "check mill part.ngc --tool 1=diameter:10,flute:15,stickout:20 --step -1",
            "--step is -1; it must be a finite number above 0",
        ),
        ("check mill part.ngc --step abc", "`abc` is not a number"),
    ] {
        let message = folder.refused(&words(command));
        assert!(message.contains(expected) && !message.contains("unexpected argument"), "{command}: {message}");
    }
    let empty = folder.run(&words("program gcode empty.ngc"));
    let told = String::from_utf8_lossy(&empty.stderr);
    assert!(empty.status.success() && told.contains("empty.ngc: the program has no moves"), "{told}");
}

#[test]
fn a_new_scene_is_made_again_with_another_unit() {
    let folder = folder();
    folder.done(&["scene", "export", "mill", "--out", "parts"]);
    let parts = ["--part", "parts/table.stl:machine:X", "parts/spindle.stl:machine:Z"];
    let new = |unit: &[&'static str]| [&["scene", "new", "shop", "--machine", "mill"][..], &parts, unit].concat();
    // 400 m are no table: nothing is left of it.
    let message = folder.refused(&new(&["--unit", "m"]));
    assert!(message.contains("nothing is written; --unit says"), "{message}");
    // The subprogram is not there, and the program is Fanuc's: no unit of the meshes helps.
    folder.write("own.nc", "O1000\nG21 G90\nM98 P2000\nM30\n");
    let message = folder.refused(&new(&["--program", "own.nc"]));
    assert!(message.contains("nothing is written; leave --program out") && !message.contains("--unit"), "{message}");
    assert!(!folder.path("shop").exists());
    let spaced = folder.run(&[&["scene", "new", "my shop", "--machine", "mill"][..], &parts].concat());
    let said = String::from_utf8_lossy(&spaced.stdout);
    assert!(
        said.contains("\nmy shop/scene.toml is written") && said.contains("bvbench view 'my shop' --open"),
        "{said}"
    );
    for (unit, size) in [(&[][..], "400.0 x 300.0 x 40.0"), (&["--unit", "cm", "--fresh"], "4000.0 x 3000.0 x 400.0")] {
        let output = folder.run(&new(unit));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains(size), "{unit:?}: {said} {output:?}");
    }
    let message = folder.refused(&new(&["--unit", "cm"]));
    assert!(message.contains("there is a scene already") && message.contains("--fresh"), "{message}");
    // What cannot be loaded replaces nothing.
    let before = std::fs::read(folder.path("shop/scene.toml")).unwrap();
    folder.refused(&new(&["--unit", "m", "--fresh"]));
    assert_eq!(std::fs::read(folder.path("shop/scene.toml")).unwrap(), before);
}

#[test]
fn a_new_scene_in_a_folder_with_its_sources_keeps_them() {
    let folder = folder();
    folder.done(&["scene", "export", "mill", "--out", "parts"]);
    let table = std::fs::read(folder.path("parts/table.stl")).unwrap();
    let program = "G0 X1\nM2\n";
    folder.write("shop/own.ngc", program);
    std::fs::create_dir_all(folder.path("shop/meshes")).unwrap();
    std::fs::write(folder.path("shop/meshes/table.stl"), &table).unwrap();
    let new = |folder: &Folder, part: &str, program: &[&str]| {
        let new = ["scene", "new", "shop", "--machine", "mill", "--part", part, "parts/spindle.stl:machine:Z"];
        let all = [&new[..], program].concat();
        let output = folder.run(&all);
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    // Other content under a name that the scene needs: nothing is written.
    folder.write("shop/jog.ngc", "G0 Y1\nM2\n");
    let (code, told) = new(&folder, "shop/meshes/table.stl:machine:base", &[]);
    assert!(code == Some(2) && told.contains("jog.ngc: the file is there already"), "{told}");
    folder.write("job.ngc", program);
    let (code, told) = new(&folder, "parts/table.stl:machine:base", &["--program", "job.ngc"]);
    assert_eq!(code, Some(0), "the same content is no loss: {told}");
    std::fs::remove_file(folder.path("shop/scene.toml")).unwrap();
    std::fs::copy(folder.path("parts/jaw.stl"), folder.path("table.stl")).unwrap();
    let (code, told) = new(&folder, "table.stl:machine:base", &["--program", "shop/own.ngc"]);
    assert!(code == Some(2) && told.contains("table.stl: the file is there already"), "{told}");
    assert!(!folder.path("shop/scene.toml").exists());
    // The sources themselves are in the folder: they stay as they are.
    let (code, told) = new(&folder, "shop/meshes/table.stl:machine:base", &["--program", "shop/own.ngc"]);
    assert_eq!(code, Some(0), "{told}");
    assert_eq!(std::fs::read_to_string(folder.path("shop/own.ngc")).unwrap(), program);
    assert_eq!(std::fs::read(folder.path("shop/meshes/table.stl")).unwrap(), table);
    assert_eq!(std::fs::read_to_string(folder.path("shop/jog.ngc")).unwrap(), "G0 Y1\nM2\n");
}

/// A lathe whose tool post meets a guard where X is at 80 mm, a radius, and not where it is at 50 mm.
const LATHE: &str = r#"
title = "a lathe"
machine.links = [
  { name = "carriage", joint = { axis = "Z", direction = [0, 0, 1] } },
  { name = "slide", parent = "carriage", joint = { axis = "X", direction = [1, 0, 0] } },
]
parts = [
  { name = "guard", at = { xyz_mm = [105, 0, 100] }, shape = { kind = "rounded-box", size_mm = [10, 100, 400] } },
  { name = "post", role = "holder", link = "slide", at = { xyz_mm = [20, 0, 50] }, shape = { kind = "rounded-box", size_mm = [20, 20, 20] } },
]
[program]
file = "part.nc"
controller = "lathe"
"#;

#[test]
fn an_offset_of_a_lathe_is_what_g10_sets() {
    let folder = Folder::with(&[("lathe/scene.toml", LATHE), ("lathe/part.nc", "M30\n")]);
    // The origin is 30 mm from zero where it is a diameter, and 60 mm where it is a radius.
    for (dialect, x, code) in [("fanuc", 220, 1), ("haas", 220, 1), ("linuxcnc", 110, 0), ("grbl", 110, 0)] {
        for (sets, options) in [("G10 L2 P1 X-60.", &[][..]), ("", &["--offset", "G54=-60,0,0"])] {
            folder.write("own.nc", &format!("G21\n{sets}\nG54\nG0 X{x}.\nM30\n"));
            let check = ["check", "lathe", "own.nc", "--quiet", "--clearance", "0", "--dialect", dialect];
            let output = folder.run(&[&check[..], options].concat());
            assert_eq!(output.status.code(), Some(code), "{dialect} {options:?}: {output:?}");
        }
    }
}

#[test]
fn every_template_makes_a_scene_that_loads() {
    let folder = folder();
    folder.done(&["scene", "export", "mill", "--out", "parts"]);
    let named = ["mill", "router", "horizontal", "rotary", "trunnion", "head-table", "fork", "lathe"];
    for kind in named.into_iter().chain(["w A b X Z t", "lathe: w C b Z X Y t"]) {
        let name = format!("new-{}", kind.replace([' ', ':'], ""));
        let new = ["scene", "new", &name, "--machine", kind, "--part", "parts/spindle.stl:holder"];
        let said = folder.done(&[&new[..], &["parts/table.stl:fixture"]].concat());
        assert_eq!(said.contains("--stock cylinder:"), kind.starts_with("lathe"), "{kind}: {said}");
        assert_eq!(folder.run(&["check", &name, "--quiet"]).status.code(), Some(0), "{kind}");
        let text = std::fs::read_to_string(folder.path(&format!("{name}/scene.toml"))).unwrap();
        assert_eq!(text.contains("\ncontroller = \"lathe\""), kind.starts_with("lathe"), "{kind}: {text}");
    }
}

#[test]
fn a_new_scene_goes_home_within_its_limits() {
    let folder = folder();
    folder.done(&["scene", "export", "mill", "--out", "parts"]);
    let parts = ["--part", "parts/spindle.stl:holder", "parts/jaw.stl:fixture"];
    let new = [&["scene", "new", "shop", "--machine", "mill", "--limits", "Z=20,300"][..], &parts].concat();
    folder.done(&new);
    folder.write("home.ngc", "G21 G90\nG28\nM2\n");
    let output = folder.run(&["check", "shop", "home.ngc", "--quiet", "--clearance", "0"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_new_scene_of_a_vise_alone_takes_tool_and_stock() {
    let folder = folder();
    folder.done(&["scene", "export", "mill", "--out", "parts"]);
    let new = ["scene", "new", "shop", "--machine", "mill", "--gauge", "0,0,200", "--part", "parts/jaw.stl:fixture"];
    let output = folder.run(&new);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && told.contains("no two parts move against each other yet"), "{told}");
    let job = ["--tool", "1=diameter:10,flute:15,stickout:20,holder:32x60", "--stock", "box:100,60,30"];
    let (found, told, code) = check(&folder, &[&["shop", "part.ngc"][..], &job[..]].concat());
    assert_eq!(code, Some(1), "{told}");
    assert_eq!(events(&found)[0], ("collision".to_owned(), 7, "jaw:tool-1-holder".to_owned()), "{found}");
    // By itself there is nothing to examine, and nothing to measure.
    assert!(folder.refused(&["check", "shop", "--quiet"]).contains("no two parts that could collide"));
    let message = folder.refused(&["stage", "verify", "--scene", "shop", "--out", "run"]);
    assert!(message.contains("no pair of parts to measure"), "{message}");
}

#[test]
fn new_scenes_refuse_what_makes_no_sense() {
    let folder = folder();
    folder.write("a.stl", "solid a\nendsolid a\n");
    for (arguments, why) in [
        (&["--machine", "mil", "--part", "a.stl:fixture"][..], "neither one of mill, router"),
        (&["--machine", "mill", "--part", "b.stl:fixture"], "there is no file b.stl"),
        (&["--machine", "mill", "--part", "a.stl"], "which role?"),
        (&["--machine", "mill", "--part", "a.stl:machine"], "what carries it?"),
        (&["--machine", "mill", "--part", "a.stl:machine:C"], "there are base, Y, X, Z"),
        (&["--machine", "mill", "--part", "a.stl:fixture", "--unit", "yard"], "mm, cm, m or inch"),
        (&["--machine", "mill", "--part", "a.stl:fixture", "--pivot", "X=0,0,0"], "no such rotary axis"),
        (&["--machine", "mill", "--part", "a.stl:fixture", "--limits", "X=5,4"], "the lower limit comes first"),
        (
            &["--machine", "mill", "--part", "a.stl:fixture", "--limits", "X=0,5", "--limits", "x=1,2"],
            "axis X is given twice",
        ),
        (
            &["--machine", "trunnion", "--part", "a.stl:fixture", "--pivot", "A=0,0,1", "--pivot", "A=0,0,1"],
            "axis A is given twice",
        ),
        (&["--machine", "mill", "--part", "a.stl:fixture", "--gauge", "0,0"], "3 finite numbers"),
        (&["--part", "a.stl:fixture"], "give --machine KIND"),
    ] {
        let all: Vec<&str> = ["scene", "new", "shop"].iter().chain(arguments).copied().collect();
        let message = folder.refused(&all);
        assert!(message.contains(why), "{arguments:?}: {message}");
        assert!(!folder.path("shop/scene.toml").exists());
    }
}

#[test]
fn what_is_wrong_with_meshes_is_told() {
    let cube = |size: f64| {
        let corner = |n: usize| [0, 1, 2].map(|axis| if n >> axis & 1 == 1 { size } else { 0.0 });
        let faces = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        let vertices: String = (0..8).map(corner).map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        (vertices, faces)
    };
    let off = |size: f64, turned: bool, faces: usize| {
        let (vertices, all) = cube(size);
        let lines: String = all[..faces]
            .iter()
            .map(|[a, b, c]| if turned { format!("3 {a} {c} {b}\n") } else { format!("3 {a} {b} {c}\n") })
            .collect();
        format!("OFF\n8 {faces} 0\n{vertices}{lines}")
    };
    let scene = "title = \"t\"\n[[machine.links]]\nname = \"x\"\njoint = { axis = \"X\", direction = [1, 0, 0] }\n[[parts]]\nname = \"a\"\nmesh = \"a.off\"\n[[parts]]\nname = \"b\"\nrole = \"holder\"\nmesh = \"b.off\"\nlink = \"x\"\nat = { xyz_mm = [50, 0, 0] }\n[program]\nfile = \"p.ngc\"\n";
    let folder = Folder::with(&[("s/scene.toml", scene), ("s/p.ngc", "G0 X1\nM2\n")]);
    for (a, b, why) in [
        (
            off(0.4, false, 12),
            off(20.0, false, 12),
            "`a` is 0.693 mm across: if its file is in metres (693 mm) or inches",
        ),
        (off(10.0, false, 12), off(20.0, false, 12), "together are 75.5 mm across"),
        (off(90.0, true, 12), off(20.0, false, 12), "`a` is inside out"),
        (off(90.0, false, 11), off(20.0, false, 12), "`a` is not watertight: 3 edges on one triangle"),
    ] {
        folder.write("s/a.off", &a);
        folder.write("s/b.off", &b);
        for verb in [&["check", "s", "--quiet"][..], &["scene", "info", "s"]] {
            let (_, _, told) = folder.told(verb);
            assert!(told.contains(why), "{verb:?}: {told}");
        }
        let json: Value = serde_json::from_slice(&folder.run(&["check", "s", "--quiet", "--json"]).stdout).unwrap();
        assert!(json["mesh_warnings"][0].as_str().unwrap().contains(why), "{json}");
    }
}

#[test]
fn pairs_are_those_of_a_program_and_of_tools_from_the_command_line() {
    let folder = folder();
    let tool = "1=diameter:10,flute:15,stickout:20,holder:32x60";
    let output = folder.run(&["scene", "pairs", "mill", "part.ngc", "--tool", tool, OFFSET[0], OFFSET[1], "--json"]);
    let pairs: Value = serde_json::from_slice(&output.stdout).unwrap();
    let kept = |a: &str, b: &str| {
        pairs.as_array().unwrap().iter().any(|pair| pair["kept"] == true && pair["pair"] == serde_json::json!([a, b]))
    };
    assert!(kept("jaw", "tool-1-holder") && kept("block", "tool-1-cutter"), "{pairs}");
}
