//! The certificate against the scene's files: each of them is read, and each statement compared.

use crate::fixture::{NAMES, assert_refusal, corners, cube, faces, find, folder, lines, signed, with_word, written};
use certificate_checker::{MOST_WORK, Refusal, Report, check};
use std::path::{Path, PathBuf};

/// A copy of a scene, with a certificate that has the hashes of its files as they are now.
struct Copy {
    folder: PathBuf,
    lines: Vec<String>,
}

impl Copy {
    fn of(name: &str, test: &str) -> Self {
        let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test).join(name);
        std::fs::create_dir_all(&copy).unwrap();
        for entry in std::fs::read_dir(folder(name)).unwrap() {
            let file = entry.unwrap().path();
            std::fs::copy(&file, copy.join(file.file_name().unwrap())).unwrap();
        }
        Self { folder: copy, lines: lines(name) }
    }

    fn write(&self, file: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.folder.join(file), content).unwrap();
    }

    fn read(&self, file: &str) -> Vec<u8> {
        std::fs::read(self.folder.join(file)).unwrap()
    }

    /// Checks against the folder; the hashes of its files in the certificate are right.
    fn check(&self) -> Result<Report, Refusal> {
        let mut lines = self.lines.clone();
        for line in lines.iter_mut().filter(|line| line.starts_with("input ")) {
            let file = line.split(' ').nth(1).unwrap().split_once('/').unwrap().1.to_owned();
            *line = with_word(line, 2, &blake3::hash(&self.read(&file)).to_hex());
        }
        check(&signed(&lines), Some(&self.folder), None, MOST_WORK)
    }

    /// The answer with one thing changed in a file of text.
    #[track_caller]
    fn with(&self, file: &str, from: &str, to: &str) -> Result<Report, Refusal> {
        let own = String::from_utf8(self.read(file)).unwrap();
        assert_eq!(own.matches(from).count(), 1, "{from}");
        self.write(file, own.replace(from, to));
        let answer = self.check();
        self.write(file, own);
        answer
    }

    /// Fails unless such a change is refused for this reason, where the blocks begin.
    #[track_caller]
    fn refuses(&self, file: &str, from: &str, to: &str, why: &str) {
        let refusal = self.with(file, from, to).map(|_| ()).unwrap_err();
        assert_refusal(&refusal, find(&self.lines, "end") + 1, why);
    }

    /// Fails unless such a change is accepted; the notes.
    #[track_caller]
    fn accepts(&self, file: &str, from: &str, to: &str) -> Vec<String> {
        self.with(file, from, to).unwrap_or_else(|refusal| panic!("{}", refusal.why)).notes
    }
}

#[test]
fn every_file_is_compared_by_its_hash() {
    for name in NAMES {
        let copy = Copy::of(name, "hashes");
        let text = signed(&copy.lines);
        let block = find(&copy.lines, "end") + 1;
        // The program is compared where it is given.
        let is_read = |line: &&String| line.starts_with("input ") && !line.contains("program.ngc");
        for line in copy.lines.iter().filter(is_read) {
            let file = line.split(' ').nth(1).unwrap().split_once('/').unwrap().1;
            let own = copy.read(file);
            copy.write(file, [&own[..], b"\n"].concat());
            let refusal = check(&text, Some(&copy.folder), None, MOST_WORK).unwrap_err();
            assert_refusal(&refusal, block, &format!("{file} is not among the files of the certificate"));
            copy.write(file, own);
        }
        copy.check().unwrap();
        let refusal = check(&text, Some(&copy.folder.join("none")), None, MOST_WORK).unwrap_err();
        assert_eq!(refusal.line, block);
    }
}

#[test]
fn files_that_the_certificate_does_not_name_are_not_read() {
    let copy = Copy::of("mill", "unnamed");
    let without = |file: &str| {
        let mut copy = Copy { folder: copy.folder.clone(), lines: copy.lines.clone() };
        copy.lines.retain(|line| !line.starts_with(&format!("input mill/{file} ")));
        copy.check().map(|_| ()).map_err(|refusal| refusal.why)
    };
    for file in ["scene.toml", "base.stl"] {
        assert_eq!(without(file), Err(format!("{file} is not among the files of the certificate")));
    }
    // What the certificate names besides is not opened, wherever it is.
    let named = ["/dev/zero", "/proc/kmsg", "../unnamed", "mill/none.stl"].map(|file| format!("input {file} 0"));
    let mut more = Copy { folder: copy.folder.clone(), lines: copy.lines.clone() };
    let input = find(&more.lines, "input");
    more.lines.splice(input..input, named);
    assert!(check(&signed(&more.lines), Some(&copy.folder), None, MOST_WORK).is_ok());
    // Of what the scene names, devices, folders and what is too large are not read.
    std::fs::File::create(copy.folder.join("large.stl")).unwrap().set_len((1 << 30) + 1).unwrap();
    for file in ["/dev/zero", ".", "large.stl"] {
        let why = copy.with("scene.toml", "\"base.stl\"", &format!("\"{file}\"")).map(|_| ()).unwrap_err().why;
        assert!(why.ends_with(&format!("{file}: no file of up to 1073741824 bytes can be read there")), "{why}");
    }
    std::fs::remove_file(copy.folder.join("large.stl")).unwrap();
    // Meshes of a machine's own file are in its folder.
    let copy = Copy::of("five-axis", "own");
    let folder = copy.folder.join("lathe");
    std::fs::create_dir_all(&folder).unwrap();
    for file in ["machine.toml", "cradle.stl"] {
        copy.write(&format!("lathe/{file}"), copy.read(file));
    }
    std::fs::remove_file(copy.folder.join("cradle.stl")).unwrap();
    let mut moved = Copy { folder: copy.folder.clone(), lines: copy.lines.clone() };
    moved.lines.iter_mut().for_each(|line| {
        *line = line
            .replace("five-axis/machine.toml", "five-axis/lathe/machine.toml")
            .replace("five-axis/cradle.stl", "five-axis/lathe/cradle.stl");
    });
    let scene = "file = \"lathe/machine.toml\"";
    moved.accepts("scene.toml", "file = \"machine.toml\"", scene);
    // Beside a file the scene may have parts of the machine of its own.
    let more = format!("{scene}\nparts = [{{ name = \"door\", mesh = \"door.stl\" }}]");
    moved.refuses("scene.toml", "file = \"machine.toml\"", &more, "part `door` is missing");
}

#[test]
fn a_scene_may_be_named_by_its_file() {
    let copy = Copy::of("mill", "named");
    let check = |text: &str, scene: &str| {
        let scene = copy.folder.join(scene);
        check(text, Some(&scene), None, MOST_WORK).map(|_| ()).map_err(|refusal| refusal.why)
    };
    let text = signed(&copy.lines);
    assert_eq!([check(&text, ""), check(&text, "scene.toml")], [Ok(()), Ok(())]);
    // It has any name; what is beside it is no scene then.
    copy.write("other.toml", copy.read("scene.toml"));
    let lines: Vec<String> =
        copy.lines.iter().map(|line| line.replace("input mill/scene.toml", "input mill/other.toml")).collect();
    assert_eq!(check(&signed(&lines), "other.toml"), Ok(()));
    for (text, scene, other) in [(&text, "other.toml", "other.toml"), (&signed(&lines), "", "scene.toml")] {
        assert_eq!(check(text, scene), Err(format!("{other} is not among the files of the certificate")));
    }
    // The folder has any name as well, and a file may be a link to another one that the certificate names.
    let other = Copy { folder: copy.folder.with_file_name("other"), lines: copy.lines.clone() };
    std::fs::create_dir_all(&other.folder).unwrap();
    for file in ["scene.toml", "base.stl", "saddle.stl", "program.ngc"] {
        other.write(file, copy.read(file));
    }
    assert!(certificate_checker::check(&text, Some(&other.folder), None, MOST_WORK).is_ok());
    #[cfg(unix)]
    {
        let _ = std::fs::remove_file(other.folder.join("link.stl"));
        std::os::unix::fs::symlink("base.stl", other.folder.join("link.stl")).unwrap();
        let mut linked = Copy { folder: other.folder.clone(), lines: copy.lines };
        let input = find(&linked.lines, "input mill/base.stl");
        linked.lines.insert(input + 1, linked.lines[input].replace("base.stl", "link.stl"));
        linked.accepts("scene.toml", "\"base.stl\"", "\"link.stl\"");
    }
}

#[test]
fn tools_with_measures_have_parts() {
    let copy = Copy::of("five-axis", "tools");
    let own = "tools = [{ number = 1, offset = { z_mm = 70 } }]";
    let tool = |more: &str| format!("tools = [{{ number = 1, offset = {{ z_mm = 70 }}{more} }}]");
    copy.accepts("scene.toml", own, &tool(", diameter_mm = 6"));
    copy.refuses("scene.toml", own, &tool(", diameter_mm = 6, flute_mm = 20"), "part `tool-1-cutter` is missing");
    let cutter = cube("tool-1-cutter head cutter 1 1 0 0 0 0 0 0", [0.0; 3], 1.0);
    let with = |parts: &[String], tool: &str| {
        let mut copy = Copy { folder: copy.folder.clone(), lines: copy.lines.clone() };
        let at = find(&copy.lines, "point");
        copy.lines.splice(at..at, parts.iter().flat_map(|part| part.lines().map(str::to_owned)).collect::<Vec<_>>());
        let at = find(&copy.lines, "end");
        let names = ["blank", "holder", "cradle"];
        copy.lines.splice(
            at..at,
            (0..parts.len()).flat_map(|_| names.map(|name| format!("pair tool-1-cutter {name} ignored"))),
        );
        copy.with("scene.toml", own, tool).map(|report| report.notes).map_err(|refusal| refusal.why)
    };
    // It is there as a part; then it is the pairs that the scene does not leave out.
    let why = with(std::slice::from_ref(&cutter), &tool(", diameter_mm = 6, flute_mm = 20")).unwrap_err();
    assert!(why.starts_with("by the scene, tool-1-cutter:"), "{why}");
    let holder = ", diameter_mm = 6, flute_mm = 20, holder = [{ diameter_mm = 30, length_mm = 50 }]";
    assert_eq!(with(std::slice::from_ref(&cutter), &tool(holder)).unwrap_err(), "part `tool-1-holder` is missing");
    // The gauge point is at Z5 of the head: the tip is there or below, by what the scene says of the length, and the axis points up.
    let bare = ", diameter_mm = 6, flute_mm = 20";
    let at = |place: &str| cutter.replace("head cutter 1 1 0 0 0 0 0 0", place);
    let below = "head cutter 1 0.9 0 0 0.4 0 0 -65";
    let not_there = "part `tool-1-cutter` is not where the tool is";
    for (place, more, is_there) in [
        (below, "", true),
        (below, ", length_mm = 70", true),
        (below, ", stickout_mm = 70", true),
        (below, ", length_mm = 70.00001", false),
        (below, ", stickout_mm = 60", false),
        ("- cutter 1 1 0 0 0 0 0 -65", "", false),
        ("slide cutter 1 1 0 0 0 0 0 -65", "", false),
        ("head cutter 1 1 0 0 0 0 0.00001 -65", "", false),
        ("head cutter 1 1 0 0 0 0 0 995", ", length_mm = 70", false),
        ("head cutter 1 0 1 0 0 0 0 -65", "", false),
        ("head cutter 1 1 0.00001 0 0 0 0 -65", "", false),
    ] {
        let why = with(&[at(place)], &tool(&format!("{bare}{more}"))).unwrap_err();
        assert_eq!(why != not_there, is_there, "{place}{more}: {why}");
    }
    let long = tool(&format!("{holder}, stickout_mm = 20"));
    assert_eq!(with(&[at(below)], &long).unwrap_err(), "part `tool-1-holder` is missing");
    assert_eq!(with(&[at(below)], &long.replace("= 20", "= 30")).unwrap_err(), not_there);
    let other = cutter.replace("head cutter 1", "head shank 1");
    assert_eq!(
        with(&[other], &tool(", diameter_mm = 6, flute_mm = 20")).unwrap_err(),
        "part `tool-1-cutter` is missing"
    );
}

#[test]
fn every_key_of_a_link_counts() {
    let copy = Copy::of("mill", "links");
    let other = |name: &str, what: &str| format!("link `{name}`: the file has another {what}");
    let place = other("stop arm", "parent or place");
    let joint = other("stop arm", "joint");
    let file = "scene.toml";
    copy.refuses(file, r#""stop arm", parent = "table""#, r#""stop arm", parent = "saddle""#, &place);
    copy.refuses(file, r#""table", parent = "saddle","#, r#""table","#, &other("table", "parent or place"));
    copy.refuses(file, "[0, 45, 0]", "[0, 45, 0.000001]", &place);
    copy.refuses(file, "rpy_deg = [0, 0, 30]", "rpy_deg = [0, 0, 30.0000001]", &place);
    copy.refuses(file, "rpy_deg = [0, 0, 30]", "rpy_deg = [0, 30, 0]", &place);
    copy.accepts(file, "rpy_deg = [0, 0, 30]", "rpy_deg = [0, 0, 30.000000000001]");
    copy.accepts(file, "[0, 45, 0]", "[0.0, 45.0000000001, 0]");
    copy.refuses(file, r#"axis = "U""#, r#"axis = "V""#, &joint);
    copy.refuses(file, r#"axis = "U""#, r#"axis = "up""#, "`UP` is not an axis");
    copy.accepts(file, r#"axis = "U""#, r#"axis = "u""#);
    copy.refuses(file, "turns = true, ", "", &joint);
    copy.refuses(file, "direction = [0, 0, 2]", "direction = [0, 0.000001, 2]", &joint);
    copy.accepts(file, "direction = [0, 0, 2]", "direction = [0, 0, 0.3]");
    copy.refuses(file, "point_mm = [0, 5, 0]", "point_mm = [0.0001, 5, 0]", &joint);
    copy.refuses(
        file,
        r#""head", joint = { axis = "Z", direction = [0, 0, 1] }"#,
        r#""head""#,
        &other("head", "joint"),
    );
    copy.refuses(file, r#"name = "head""#, r#"name = "neck""#, "no link `neck`");
    copy.refuses(file, "links = [\n", "links = [\n{ name = \"more\" },\n", "the machine has another number of links");
    let mut copy = copy;
    let head = find(&copy.lines, "slide head");
    copy.lines[head] = with_word(&copy.lines[head], 1, "neck");
    copy.lines.iter_mut().for_each(|line| *line = line.replace(" head ", " neck "));
    assert!(copy.check().unwrap_err().why.contains("no link `head`"));
}

#[test]
fn every_key_of_a_part_counts() {
    let copy = Copy::of("mill", "parts");
    let file = "scene.toml";
    let other = |name: &str| format!("part `{name}`: the file has another link, role, tool or place");
    copy.refuses(file, "name = \"stop\"\nrole = \"fixture\"", "name = \"stop\"\nrole = \"holder\"", &other("stop"));
    copy.refuses(file, "name = \"stop\"\nrole = \"fixture\"", "name = \"stop\"", &other("stop"));
    copy.accepts(file, "name = \"base\"", "name = \"base\"\nrole = \"machine\"");
    copy.refuses(file, "link = \"stop arm\"", "link = \"table\"", &other("stop"));
    copy.refuses(file, "link = \"stop arm\"\n", "", &other("stop"));
    copy.refuses(file, "tool = 2", "tool = 1", &other("probe"));
    copy.refuses(file, "tool = 2\n", "", &other("probe"));
    copy.refuses(file, "xyz_mm = [0, 5, 15]", "xyz_mm = [0, 5, 15.00000001]", &other("stop"));
    copy.accepts(file, "xyz_mm = [0, 5, 15]", "xyz_mm = [0, 5, 15.0000000001]");
    copy.refuses(file, "name = \"stop\"", "name = \"halt\"", "part `halt` is missing");
    // What the scene does not describe may be a tool by its measures: told, not compared.
    let whole = std::fs::read_to_string(copy.folder.join(file)).unwrap();
    let probe = &whole[whole.find("[[parts]]\nname = \"probe\"").unwrap()..whole.find("[program]").unwrap()];
    let notes = copy.accepts(file, probe, "");
    assert!(
        notes.contains(&"by the certificate's word: part `probe`, which no [[parts]] describes".to_owned()),
        "{notes:?}"
    );
    let usual = copy.check().unwrap().notes;
    assert!(usual.iter().all(|note| !note.contains("which no [[parts]]")), "{usual:?}");
    // Triangles of what is no STL file, or is welded, are told; those of STL files are not.
    let told = |notes: &[String], name: &str| {
        notes.iter().any(|note| *note == format!("by the certificate's word: the triangles of `{name}`"))
    };
    assert!(told(&usual, "vise") && !told(&usual, "base") && !told(&usual, "saddle"), "{usual:?}");
    let notes = copy.accepts(file, "mesh = \"base.stl\"", "mesh = \"base.stl\"\nweld_mm = 0.001");
    assert!(told(&notes, "base"), "{notes:?}");
    copy.refuses(file, "mesh = \"base.stl\"", "mesh = \"none.STL\"", "none.STL");
    let mut copy = copy;
    let input = find(&copy.lines, "input mill/base.stl");
    for (other, content) in [("base.obj", Vec::new()), ("BASE.STL", copy.read("base.stl"))] {
        copy.write(other, content);
        copy.lines.insert(input + 1, copy.lines[input].replace("base.stl", other));
    }
    assert!(told(&copy.accepts(file, "mesh = \"base.stl\"", "mesh = \"base.obj\""), "base"));
    assert!(!told(&copy.accepts(file, "mesh = \"base.stl\"", "mesh = \"BASE.STL\""), "base"));
    for unit in ["\"mm\"", "\"m\"", "\"inch\""] {
        copy.refuses(file, "unit = \"cm\"", &format!("unit = {unit}"), "saddle.stl has other triangles");
    }
    // Parts of the machine's own file are parts as well.
    let copy = Copy::of("five-axis", "parts");
    copy.refuses("machine.toml", "link = \"cradle\"", "link = \"plate\"", &other("cradle"));
    copy.refuses(file, "file = \"machine.toml\"", "file = \"none.toml\"", "none.toml");
    copy.refuses(file, "file = \"machine.toml\"", "urdf = \"machine.urdf\"", "a machine in URDF is not compared");
    copy.refuses("machine.toml", "links = [", "links = ", "machine.toml: ");
    copy.write("machine.toml", b"\xff");
    assert!(copy.check().unwrap_err().why.contains("machine.toml is not text"));
}

#[test]
fn every_triangle_of_a_file_counts() {
    let copy = Copy::of("mill", "triangles");
    let file = "base.stl";
    let other = "base.stl has other triangles";
    let own = String::from_utf8(copy.read(file)).unwrap();
    copy.refuses(
        file,
        "vertex 0 0 -30\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 0 90 0\nvertex 80 -80 0",
        "vertex 0 0 -30.00001\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 0 90 0\nvertex 80 -80 0",
        other,
    );
    let facets: Vec<&str> = own
        .split("facet normal 0 0 0\n")
        .filter(|text| text.contains("vertex"))
        .map(|text| text.split("end").next().unwrap())
        .collect();
    assert_eq!(facets.len(), 4);
    let file_of = |facets: &[&str]| -> Vec<u8> {
        facets
            .iter()
            .map(|facet| format!("  facet normal 0 0 0\n  {facet}  endloop\nendfacet\n"))
            .collect::<String>()
            .into_bytes()
    };
    let with = |facets: &[&str]| {
        copy.write(file, file_of(facets));
        copy.check().map(|_| ()).map_err(|refusal| refusal.why)
    };
    assert_eq!(with(&facets), Ok(()));
    assert_eq!(with(&[facets[2], facets[0], facets[3], facets[1]]), Ok(()));
    assert!(with(&facets[1..]).unwrap_err().contains(other));
    // A triangle twice is there once, whichever way it winds; one without an area is dropped, whichever corners fall together.
    let turned = |facet: &str| {
        let mut lines: Vec<&str> = facet.lines().collect();
        lines.swap(1, 2);
        lines.join("\n") + "\n"
    };
    let double = turned(facets[1]);
    assert_eq!(with(&[facets[0], facets[1], facets[2], facets[3], &double]), Ok(()));
    assert!(with(&[facets[0], &double, facets[2], facets[3]]).unwrap_err().contains(other), "turned over");
    let [a, b] = ["vertex 1 2 3\n", "vertex 4 5 6\n"];
    for flat in [[a, a, b], [a, b, a], [b, a, a], [a, a, a]] {
        assert_eq!(
            with(&[facets[0], facets[1], facets[2], facets[3], &format!("outer loop\n{}", flat.concat())]),
            Ok(())
        );
    }
    let more = format!("outer loop\n{a}{b}vertex 9 9 8\n");
    assert!(with(&[facets[0], facets[1], facets[2], facets[3], &more]).unwrap_err().contains(other));
    for wrong in [
        "solid\nendsolid\n".to_owned(),
        own.replace("vertex 0 0 -30", "vertex 0 0"),
        own.replace("-30", "nan"),
        own.replace("-30", "-x"),
    ] {
        copy.write(file, wrong);
        assert!(copy.check().unwrap_err().why.contains("base.stl is not an STL file"));
    }
    copy.write(file, b"\xff\xfe");
    assert!(copy.check().unwrap_err().why.contains("base.stl is not an STL file"));
    // Letters, ends of lines and the characters of a name as others write them.
    let named = [&b"solid Geh\xe4use"[..], &own.as_bytes()[own.find('\n').unwrap()..]].concat();
    for same in [own.to_uppercase().into_bytes(), own.replace('\n', "\r").into_bytes(), named] {
        copy.write(file, same);
        copy.check().unwrap();
    }
    copy.write(file, own);
    // The binary one: its corners, and its length by its count.
    let own = copy.read("saddle.stl");
    for (at, is_read) in [
        (0, false),
        (79, false),
        (84, false),
        (95, false),
        (96, true),
        (131, true),
        (132, false),
        (133, false),
        (146, true),
    ] {
        let mut bytes = own.clone();
        bytes[at] ^= 1;
        copy.write("saddle.stl", bytes);
        assert_eq!(copy.check().is_err(), is_read, "byte {at}");
    }
    copy.write("saddle.stl", &own[..own.len() - 1]);
    assert!(copy.check().unwrap_err().why.contains("saddle.stl is not an STL file"));
    copy.write("saddle.stl", &own[..83]);
    assert!(copy.check().unwrap_err().why.contains("saddle.stl is not an STL file"));
}

#[test]
fn text_may_be_utf16_with_a_byte_order_mark() {
    let copy = Copy::of("mill", "encodings");
    for file in ["scene.toml", "base.stl"] {
        let own = String::from_utf8(copy.read(file)).unwrap();
        let units = |text: &str| std::iter::once(0xfeff).chain(text.encode_utf16()).collect::<Vec<u16>>();
        let little = |text: &str| units(text).into_iter().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        let big: Vec<u8> = units(&own).into_iter().flat_map(u16::to_be_bytes).collect();
        let marked = [&b"\xef\xbb\xbf"[..], own.as_bytes()].concat();
        for same in [little(&own), big, marked, own.replace('\n', "\r").into_bytes()] {
            copy.write(file, same);
            copy.check().unwrap_or_else(|refusal| panic!("{file}: {}", refusal.why));
        }
        // What it says is compared as ever.
        copy.write(
            file,
            little(&own.replacen("-30", "-31", 1).replacen("rpy_deg = [0, 0, 30]", "rpy_deg = [0, 0, 31]", 1)),
        );
        assert!(copy.check().is_err(), "{file}");
        copy.write(file, own);
    }
}

#[test]
fn pairs_that_are_left_out_are_the_scenes_own() {
    let copy = Copy::of("mill", "pairs");
    let file = "scene.toml";
    let (ignored, allowed) = ("by the scene, base:stop is not ignored", "by the scene, vise:stop is not allowed");
    let [ignore, allow] = ["ignore = [[\"base\", \"stop\"]]", "allow = [[\"stop\", \"vise\"]]"];
    copy.refuses(file, ignore, "", ignored);
    copy.refuses(file, allow, "", allowed);
    copy.refuses(file, ignore, "ignore = [[\"base\", \"vise\"]]", ignored);
    copy.refuses(file, ignore, "ignore = [[\"saddle\", \"stop\"]]", ignored);
    copy.refuses(file, ignore, "ignore = [[\"base\", \"stop\", \"vise\"]]", ignored);
    copy.refuses(
        file,
        &format!("{ignore}\n{allow}"),
        "ignore = [[\"vise\", \"stop\"]]\nallow = [[\"base\", \"stop\"]]",
        ignored,
    );
    copy.accepts(file, ignore, "ignore = [[\"mill\", \"part\"], [\"stop\", \"base\"]]");
    copy.accepts(file, allow, "allow = [[\"vise\", \"stop\"]]");
    copy.refuses(file, "[check]", "[checks]", ignored);
    // Neighbours that the scene names are examined.
    let title = "[machine]";
    copy.accepts(file, title, "pairs = [[\"base\", \"vise\"]]\n[machine]");
    for pair in ["\"base\", \"saddle\"", "\"saddle\", \"base\""] {
        let named = format!("pairs = [[\"vise\", \"mill\"], [{pair}]]\n{title}");
        copy.refuses(file, title, &named, "by the scene, base:saddle is not neighbours");
    }
}

#[test]
fn the_control_of_the_tip_is_compared() {
    let copy = Copy::of("five-axis", "tip");
    let other = "another tool_centre_point";
    let own = r#"tool_link = "head", work_link = "plate", gauge_mm = [0, 0, 5]"#;
    for wrong in [
        r#"tool_link = "slide", work_link = "plate", gauge_mm = [0, 0, 5]"#,
        r#"tool_link = "head", work_link = "cradle", gauge_mm = [0, 0, 5]"#,
        r#"tool_link = "head", gauge_mm = [0, 0, 5]"#,
        r#"work_link = "plate", gauge_mm = [0, 0, 5]"#,
        r#"tool_link = "head", work_link = "plate", gauge_mm = [0, 0, 5.00000001]"#,
        r#"tool_link = "head", work_link = "plate""#,
        r#"tool_link = "head", work_link = "plate", gauge_mm = [0, 0, 5], direction = [0, 0, 1]"#,
        r#"tool_link = "head", work_link = "plate", gauge_mm = [0, 0, 5], direction = [0, 0.0001, -1]"#,
    ] {
        copy.refuses("scene.toml", own, wrong, other);
    }
    copy.accepts(
        "scene.toml",
        own,
        r#"tool_link = "head", work_link = "plate", gauge_mm = [0, 0, 5], direction = [0, 0, -7.5]"#,
    );
    copy.refuses("scene.toml", &format!("tool_centre_point = {{ {own} }}"), "", other);
    let mill = Copy::of("mill", "tip");
    mill.refuses("scene.toml", "tool = 1\n\n", "tool = 1\ntool_centre_point = { tool_link = \"head\" }\n\n", other);
}

/// A certificate of two cubes at rest, against a scene.
fn at_rest(test: &str, stated: &str, scene: &str, files: &[(&str, Vec<u8>)]) -> Result<Report, Refusal> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    std::fs::create_dir_all(&folder).unwrap();
    let mut inputs = String::new();
    for (name, content) in
        files.iter().map(|(name, content)| (*name, content.as_slice())).chain([("scene.toml", scene.as_bytes())])
    {
        std::fs::write(folder.join(name), content).unwrap();
        inputs += &format!("input {test}/{name} {}\n", blake3::hash(content).to_hex());
    }
    let text = written(&format!("made by hand\n{inputs}{stated}point 0 1\npair a b rigid"));
    check(&text, Some(&folder), None, MOST_WORK)
}

#[test]
fn turns_of_a_placement_are_about_x_then_y_then_z() {
    // By 90 degrees each: Z Y X of these is the rotation by 90 degrees about Y.
    let part = |turn: &str| {
        cube(&format!("a - fixture - {turn} 1 2 3"), [0.0; 3], 1.0)
            + &cube("b - fixture - 1 0 0 0 0 0 0", [9.0; 3], 1.0)
    };
    let scene = |rpy: &str| {
        format!(
            "[[parts]]\nname = \"a\"\nrole = \"fixture\"\nat = {{ xyz_mm = [1, 2, 3], rpy_deg = {rpy} }}\n[[parts]]\nname = \"b\"\nrole = \"fixture\""
        )
    };
    let half = 0.5_f64.sqrt();
    let is_same = |turn: &str, rpy: &str| at_rest("placement", &part(turn), &scene(rpy), &[]).is_ok();
    let quarter = |i: usize| [1, 2, 3].map(|k| if k == i { half } else { 0.0 }).map(|x| x.to_string()).join(" ");
    for (i, rpy) in [(1, "[90, 0, 0]"), (2, "[0, 90, 0]"), (3, "[0, 0, 90.0]"), (2, "[90, 90, 90]")] {
        let turn = format!("{half} {}", quarter(i));
        assert!(is_same(&turn, rpy), "{rpy}");
        assert!(!is_same(&turn, "[90, 90, 0]") && !is_same("1 0 0 0", rpy), "{rpy}");
    }
    // X then Y: (1 + j)(1 + i) = 1 + i + j - k. X then Z: 1 + i + j + k.
    assert!(is_same("1 1 1 -1", "[90, 90, 0]") && !is_same("1 1 1 1", "[90, 90, 0]"));
    assert!(is_same("1 1 1 1", "[90, 0, 90]"));
}

#[test]
fn units_of_a_file_are_those_of_the_scene() {
    // A tetrahedron in binary: one unit along X, two along Y, three along Z.
    let corners = [[0.0_f32; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mut bytes = [vec![b' '; 80], 4_u32.to_le_bytes().to_vec()].concat();
    for face in faces {
        bytes.extend([0; 12]);
        face.iter().flat_map(|&corner: &usize| corners[corner]).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    let stated = |unit: f64| {
        let on_grid = |x: f32| (f64::from(x) * unit * f64::from(1 << 26)).round_ties_even() as i64;
        let vertex =
            |corner: [f32; 3]| format!("v {} {} {}\n", on_grid(corner[0]), on_grid(corner[1]), on_grid(corner[2]));
        let face = |[i, j, k]: [usize; 3]| format!("f {i} {j} {k}\n");
        let mesh: String = corners.into_iter().map(vertex).chain(faces.into_iter().map(face)).collect();
        format!("part a - fixture - 1 0 0 0 0 0 0\n{mesh}") + &cube("b - fixture - 1 0 0 0 0 0 0", [9.0; 3], 1.0)
    };
    let scene = |unit: &str| {
        format!(
            "[[parts]]\nname = \"a\"\nrole = \"fixture\"\nmesh = \"a.stl\"\n{unit}\n[[parts]]\nname = \"b\"\nrole = \"fixture\""
        )
    };
    let units = [
        ("", 1.0),
        ("unit = \"mm\"", 1.0),
        ("unit = \"cm\"", 10.0),
        ("unit = \"m\"", 1000.0),
        ("unit = \"inch\"", 25.4),
    ];
    for (told, _) in units {
        for (_, mm) in units {
            let is_same = at_rest("units", &stated(mm), &scene(told), &[("a.stl", bytes.clone())]).is_ok();
            assert_eq!(is_same, units.contains(&(told, mm)), "{told}, {mm}");
        }
    }
    // A triangle that is stated twice, or turned over beside itself, could hide that there is an inside.
    for more in ["f 0 2 1", "f 1 2 0"] {
        let twice = stated(1.0).replacen("f 0 2 1\n", &format!("f 0 2 1\n{more}\n"), 1);
        let refusal = at_rest("units", &twice, &scene(""), &[("a.stl", bytes.clone())]).unwrap_err();
        assert!(refusal.why.contains("a.stl has other triangles"), "{}", refusal.why);
    }
}

#[test]
fn faces_wound_against_each_other_count_where_the_mesh_is_closed_only_with_them() {
    // Two cubes with a side in common, and one that is there both ways round.
    for (x, is_turned, is_same) in [(2.0, false, true), (0.0, true, false)] {
        let mesh = corners([0.0; 3], 1.0) + &corners([x, 0.0, 0.0], 1.0) + &faces(0, false) + &faces(8, is_turned);
        let numbers = |word: &str| -> Vec<[i64; 3]> {
            let lines = mesh.lines().filter_map(|line| line.strip_prefix(word));
            lines.map(|line| [0, 1, 2].map(|i| line.split(' ').nth(i).unwrap().parse().unwrap())).collect()
        };
        let vertices = numbers("v ");
        let vertex = |corner: i64| {
            let [x, y, z] = vertices[corner as usize].map(|x| x >> 26);
            format!("vertex {x} {y} {z}\n")
        };
        let stl = numbers("f ").into_iter().map(|face| face.map(vertex).concat()).collect::<String>().into_bytes();
        let stated = format!("part a - fixture - 1 0 0 0 0 0 0\n{mesh}");
        let stated = stated + &cube("b - fixture - 1 0 0 0 0 0 0", [9.0; 3], 1.0);
        let scene = "[[parts]]\nname = \"a\"\nrole = \"fixture\"\nmesh = \"a.stl\"\n[[parts]]\nname = \"b\"\nrole = \"fixture\"";
        let found = at_rest("both", &stated, scene, &[("a.stl", stl)]).map(|_| ()).map_err(|refusal| refusal.why);
        assert_eq!(found.is_ok(), is_same, "{found:?}");
        assert!(
            found.is_ok() || found.as_ref().is_err_and(|why| why.contains("a.stl has other triangles")),
            "{found:?}"
        );
    }
}

#[test]
fn world_is_a_link_of_that_name_or_none() {
    let cubes =
        cube("a - fixture - 1 0 0 0 0 0 0", [0.0; 3], 1.0) + &cube("b - fixture - 1 0 0 0 0 0 0", [9.0; 3], 1.0);
    let check = |link: &str, work: &str| {
        let stated = format!("slide {link} - 1 0 0 0 0 0 0 Z 0 0 1\ntip {link} {work} 0 0 0 0 0 -1\n{cubes}");
        let joint = "joint = { axis = \"Z\", direction = [0, 0, 1] }";
        let tip = format!("tool_centre_point = {{ tool_link = \"{link}\", work_link = \"world\" }}");
        let parts = ["a", "b"].map(|name| format!("[[parts]]\nname = \"{name}\"\nrole = \"fixture\"\n")).concat();
        let scene = format!("[machine]\nlinks = [{{ name = \"{link}\", {joint} }}]\n[program]\n{tip}\n{parts}");
        at_rest("world", &stated, &scene, &[]).map(|_| ()).map_err(|refusal| refusal.why)
    };
    assert_eq!(check("head", "-"), Ok(()));
    assert_eq!(check("world", "world"), Ok(()));
    for (link, work) in [("head", "head"), ("world", "-")] {
        assert_eq!(check(link, work), Err("another tool_centre_point".to_owned()));
    }
}

#[test]
fn the_program_is_compared_by_its_bytes() {
    let copy = Copy::of("mill", "program");
    let program = copy.folder.join("program.ngc");
    let own = String::from_utf8(copy.read("program.ngc")).unwrap();
    let text = signed(&copy.lines);
    let is_same = |content: &[u8]| {
        copy.write("program.ngc", content);
        check(&text, None, Some(&program), MOST_WORK).is_ok()
    };
    assert!(is_same(own.as_bytes()));
    for other in [own.replace("X20", "X21"), own.replace('\n', "\r\n"), own.trim_end().to_owned(), String::new()] {
        assert!(!is_same(other.as_bytes()), "{other}");
    }
    // In any encoding.
    let utf16: Vec<u8> = std::iter::once(0xfeff).chain(own.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for bytes in [utf16, own.replace('\n', "\r").into_bytes(), [&b"\xef\xbb\xbf(\xe4)"[..], own.as_bytes()].concat()] {
        copy.write("program.ngc", &bytes);
        let mut lines = copy.lines.clone();
        let line = find(&lines, "program");
        lines[line] = with_word(&lines[line], 2, &blake3::hash(&bytes).to_hex());
        check(&signed(&lines), None, Some(&program), MOST_WORK).unwrap();
    }
    // Each file that it calls is beside it: what is elsewhere is not opened.
    copy.write("program.ngc", &own);
    copy.write("go there.ngc", "G0 X1");
    let mut lines = copy.lines.clone();
    let called = format!("called go%20there.ngc {}", blake3::hash(b"G0 X1").to_hex());
    lines.insert(find(&lines, "program") + 1, called);
    let compared = |program| check(&signed(&lines), None, program, MOST_WORK).map(|_| ());
    compared(Some(&program)).unwrap();
    for path in ["../program/mill/", "./", "/dev/"] {
        let moved = signed(&lines).replace("called ", &format!("called {path}"));
        let lines: Vec<String> = moved.lines().map(str::to_owned).collect();
        let why = check(&signed(&lines), None, Some(&program), MOST_WORK).unwrap_err().why;
        assert!(why.contains("%go there.ngc: no file"), "{why}");
    }
    copy.write("go there.ngc", "G0 X2");
    assert!(compared(None).is_ok());
    let why = compared(Some(&program)).unwrap_err().why;
    assert!(why.ends_with("go there.ngc is not the program of the certificate, or what it calls"), "{why}");
    std::fs::remove_file(copy.folder.join("go there.ngc")).unwrap();
    let why = compared(Some(&program)).unwrap_err().why;
    assert!(why.contains("go there.ngc: no file"), "{why}");
    let notes = |program| check(&text, None, program, MOST_WORK).unwrap().notes;
    let told = |notes: &[String]| {
        notes.iter().any(|note| note == "by the certificate's word: that its program is `program.ngc`")
    };
    assert!(told(&notes(None)) && !told(&notes(Some(&program))));
    assert!(
        notes(None).iter().any(|note| note.ends_with("(no --scene)"))
            && !copy.check().unwrap().notes.iter().any(|note| note.ends_with("(no --scene)"))
    );
}
