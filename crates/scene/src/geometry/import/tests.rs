//! A tetrahedron in every format, and ways to damage each.

mod objects;

use super::*;
use proptest::prelude::*;

const OBJ: &str = "# a tetrahedron
mtllib nothing.mtl
o part
v 0 0 0
v 6 0 0
v 0 1 0 0.5 0.5 0.5
v 0 0 1
vt 0.5 0.5
s off
f 1/1 3/1 2/99999999999999999999
f 1 2 4 # the front
f -4//-1 -1 -2
fo 2 3 4
l 1 2
";
const OFF: &str = "OFF # header
4 4 6

0 0 0
6 0 0
0 1 0
0 0 1 # a comment
3 0 2 1
3 0 1 3 255 0 0
3 0 3 2
3 1 2 3
";
const STL: &str = "solid a
facet normal nan nan nan
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 6 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 6 0 0
vertex 0 0 1
endloop
endfacet
endsolid a
solid b
facet normal -1 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 1 6 6
outer loop
vertex 6 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid b
";

fn binary_stl() -> Vec<u8> {
    let mesh = read("a.off", OFF.as_bytes()).unwrap().mesh;
    let mut bytes = Vec::new();
    write_stl(&mesh, &mut bytes).unwrap();
    bytes
}

fn read(name: &str, content: &[u8]) -> Result<Imported, ImportError> {
    parse(Path::new(name), content, None)
}

fn message(name: &str, content: &[u8]) -> String {
    read(name, content).expect_err(name).to_string()
}

#[test]
fn every_format_gives_the_same_closed_tetrahedron() {
    let binary = binary_stl();
    let mut solid = binary.clone();
    solid[..6].copy_from_slice(b"solid ");
    let mut spaced = binary.clone();
    spaced[..8].copy_from_slice(b" \nsolid ");
    for (name, content, format) in [
        ("a.obj", OBJ.as_bytes(), Format::Obj),
        ("a.off", OFF.as_bytes(), Format::Off),
        ("a.stl", STL.as_bytes(), Format::TextStl),
        ("a.STL", &binary, Format::BinaryStl),
        ("named solid.stl", &solid, Format::BinaryStl),
        ("named solid behind spaces.stl", &spaced, Format::BinaryStl),
        ("obj", OBJ.as_bytes(), Format::Obj),
        ("off", OFF.as_bytes(), Format::Off),
        ("text", STL.as_bytes(), Format::TextStl),
        ("binary", &binary, Format::BinaryStl),
        ("a.ply", objects::PLY.as_bytes(), Format::Ply),
        ("ply", objects::PLY.as_bytes(), Format::Ply),
        ("little.ply", &objects::binary_ply(true), Format::Ply),
        ("big", &objects::binary_ply(false), Format::Ply),
    ] {
        let Imported { mesh, report } = read(name, content).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(report.format, format, "{name}");
        assert_eq!((report.triangles_read, mesh.faces().len(), mesh.vertices().len()), (4, 4, 4), "{name}");
        let surface = mesh.surface_report();
        assert!(surface.leaking == 0 && !surface.is_inside_out(), "{name}: {surface:?}");
        assert!((mesh.signed_volume() - 1.0).abs() < 1e-6, "{name}"); // 6 · 1 · 1 / 6
        let welded = if matches!(format, Format::BinaryStl | Format::TextStl) { 12 - 4 } else { 0 };
        assert_eq!(report.welded_vertices, welded, "{name}");
    }
}

#[test]
fn every_line_end_and_encoding_of_text_gives_the_same_tetrahedron() {
    let mixed = |text: &str| text.replacen('\n', "\r\n", 1).replacen("\nv", "\rv", 1);
    let texts = [("a.obj", OBJ), ("a.off", OFF), ("a.stl", STL), ("a.ply", objects::PLY)];
    let of = |text: &str| {
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        [
            text.replace('\n', "\r").into_bytes(),
            text.replace('\n', "\r\n").into_bytes(),
            mixed(text).into_bytes(),
            little,
            big,
        ]
    };
    let mut files: Vec<_> = texts.iter().flat_map(|&(name, text)| of(text).map(|content| (name, content))).collect();
    for little in [true, false] {
        let binary = objects::binary_ply(little);
        let header = binary.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
        let returns: Vec<u8> = binary[..header].iter().map(|&byte| if byte == b'\n' { b'\r' } else { byte }).collect();
        files.push(("a.ply", [&returns, &binary[header..]].concat()));
    }
    for (index, (name, content)) in files.iter().enumerate() {
        let imported = read(name, content).unwrap_or_else(|error| panic!("{index} {error}"));
        assert_eq!((imported.mesh.faces().len(), imported.mesh.vertices().len()), (4, 4), "{index} {name}");
    }
}

#[test]
fn text_in_upper_case_or_behind_a_byte_order_mark_is_read() {
    let marked = |text: &str| format!("\u{feff}{text}");
    for (name, content) in [
        ("a.stl", STL.to_uppercase()),
        ("upper", STL.to_uppercase()),
        ("a.stl", marked(STL)),
        ("a.obj", marked(&OBJ[OBJ.find("v 0").unwrap()..])),
        ("off", marked(OFF)),
        ("a.ply", marked(objects::PLY)),
    ] {
        let imported = read(name, content.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((imported.mesh.faces().len(), imported.mesh.vertices().len()), (4, 4), "{name}");
    }
    assert!(message("a.stl", STL.to_uppercase().replacen("6 0 0", "6 O 0", 1).as_bytes()).contains("a.stl: line 6"));
    // Binary files whose headers begin in these ways stay binary.
    let mut binary = binary_stl();
    binary[..3].copy_from_slice(b"\xef\xbb\xbf");
    assert_eq!(read("a.stl", &binary).unwrap().report.format, Format::BinaryStl);
    binary[..10].copy_from_slice(b"SolidWorks");
    binary.push(0);
    assert!(message("a.stl", &binary).contains("the header announces 4 triangles"));
}

#[test]
fn units_scale_to_mm() {
    for (unit, scale) in [(Unit::Mm, 1.0_f64), (Unit::Cm, 10.0), (Unit::Inch, 25.4), (Unit::M, 1000.0)] {
        let mesh = parse(Path::new("a.off"), OFF.replace('6', "4").as_bytes(), Some(unit)).unwrap().mesh;
        assert!((mesh.signed_volume() / scale.powi(3) - 4.0 / 6.0).abs() < 1e-5, "{unit:?}");
    }
    let far = parse(Path::new("a.off"), OFF.as_bytes(), Some(Unit::M)).expect_err("6 m are beyond the grid");
    assert!(far.to_string().contains("is the unit right?"), "{far}");
}

#[test]
fn duplicates_and_collapsed_triangles_go_and_needles_stay() {
    let off =
        "OFF\n5 6 0\n0 0 0\n1 0 0\n2 0 0\n0 1 0\n0 0 1e-10\n3 0 1 3\n3 3 0 1\n3 1 0 3\n3 0 4 1\n3 0 1 2\n4 0 2 3 0\n";
    let Imported { mesh, report } = read("a.off", off.as_bytes()).unwrap();
    // The polygon of four corners is two triangles, one of which collapses.
    assert_eq!(
        (report.triangles_read, report.duplicate, report.collapsed, mesh.surface_report().degenerate),
        (7, 2, 2, 1)
    );
    assert_eq!(report.welded_vertices, 1);
}

/// The sides of a box; bits 0 to 2 of a corner's number say whether it is at the upper end of x, y and z.
const BOX: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

#[test]
fn triangles_wound_against_each_other_stay_only_where_they_close_bodies_with_a_side_in_common() {
    // Corners of boxes of 1 mm on one another, four at each height; the box of a level, and the same inside out.
    let read = |boxes: &[(usize, bool)], weld_mm: f64| {
        let mut off = format!("OFF\n20 {} 0\n", 6 * boxes.len());
        for i in 0..20 {
            off += &format!("{} {} {}\n", i & 1, i >> 1 & 1, [0.0, 1.0, 2.0, 2.01, 3.01][i >> 2]);
        }
        for (level, is_turned) in boxes {
            for mut face in BOX {
                if *is_turned {
                    face[1..].reverse();
                }
                off += &format!("4 {}\n", face.map(|corner| (corner + 4 * level).to_string()).join(" "));
            }
        }
        parse(Path::new("a.off"), off.as_bytes(), Options { unit: None, weld_mm }).unwrap()
    };
    for (what, boxes, weld_mm, duplicate, volume_mm3) in [
        ("stacked", &[(0, false), (1, false)][..], 0.0, 0, Some(2.0)),
        ("stacked by welding", &[(1, false), (3, false)][..], 0.02, 0, Some(2.01)),
        ("stacked, and one twice", &[(0, false), (1, false), (1, false)][..], 0.0, 12, Some(2.0)),
        ("double-sided", &[(0, false), (0, true)][..], 0.0, 12, Some(1.0)),
        ("two double-sided, stacked", &[(0, false), (0, true), (1, false), (1, true)][..], 0.0, 26, None),
        ("stacked, and a double-sided one apart", &[(0, false), (1, false), (3, false), (3, true)][..], 0.0, 14, None),
    ] {
        let Imported { mesh, report } = read(boxes, weld_mm);
        let surface = mesh.surface_report();
        assert_eq!((report.duplicate, surface.edges.is_watertight()), (duplicate, volume_mm3.is_some()), "{what}");
        assert!(volume_mm3.is_none_or(|volume| (surface.volume_mm3 - volume).abs() < 1e-6), "{what}: {surface:?}");
    }
}

#[test]
fn what_fills_a_cavity_is_solid_whichever_of_the_two_comes_first() {
    // A box of 27 mm³, and one of 1 mm³ from both sides, in it or beside it.
    let (block, cavity, plug) = ((0, false), (8, true), (8, false));
    for (at, bodies) in [
        (0.0, [block, cavity, plug]),
        (0.0, [block, plug, cavity]),
        (0.0, [cavity, plug, block]),
        (5.0, [block, cavity, plug]),
    ] {
        let mut off = "OFF\n16 18 0\n".to_owned();
        for ends in [[-1.0, 2.0], [at, at + 1.0]] {
            for corner in 0..8_usize {
                off += &format!("{} {} {}\n", ends[corner & 1], ends[corner >> 1 & 1], ends[corner >> 2]);
            }
        }
        for (first, is_turned) in bodies {
            for mut face in BOX {
                if is_turned {
                    face[1..].reverse();
                }
                off += &format!("4 {}\n", face.map(|corner| (corner + first).to_string()).join(" "));
            }
        }
        let Imported { mesh, report } = read("a.off", off.as_bytes()).unwrap();
        let surface = mesh.surface_report();
        assert_eq!((report.duplicate, surface.components, surface.leaking, surface.inward), (12, 2, 0, 0), "{surface}");
        assert!((surface.volume_mm3 - 28.0).abs() < 1e-6, "{at} {bodies:?}: {surface:?}");
    }
}

/// Vertices and polygons in the three formats that have polygons.
fn polygons(vertices: &[[f64; 3]], faces: &[&[usize]]) -> [(&'static str, String); 3] {
    let lines = |lead: &str| -> String { vertices.iter().map(|[x, y, z]| format!("{lead}{x} {y} {z}\n")).collect() };
    let list = |face: &[usize], from: usize| face.iter().map(|v| format!(" {}", v + from)).collect::<String>();
    let counted: String = faces.iter().map(|face| format!("{}{}\n", face.len(), list(face, 0))).collect();
    let numbered: String = faces.iter().map(|face| format!("f{}\n", list(face, 1))).collect();
    let (count, all) = (vertices.len(), faces.len());
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty double x\nproperty double y\nproperty double z\nelement face {all}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    [
        ("a.obj", format!("{}{numbered}", lines("v "))),
        ("a.off", format!("OFF\n{count} {all} 0\n{}{counted}", lines(""))),
        ("a.ply", format!("{header}{}{counted}", lines(""))),
    ]
}

#[test]
fn concave_polygons_are_covered_once_and_crossed_ones_refused() {
    // A bar of 1 mm whose section is an L of 5 mm² with a girth of 12 mm, from the end of one leg on.
    let outline = [[3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0], [0.0, 0.0], [3.0, 0.0]];
    let vertices: Vec<[f64; 3]> = [0.0, 1.0].iter().flat_map(|&z| outline.map(|[x, y]| [x, y, z])).collect();
    let sides: Vec<[usize; 4]> = (0..6).map(|i| [i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i]).collect();
    let mut faces: Vec<&[usize]> = sides.iter().map(|side| &side[..]).collect();
    let ends = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]];
    faces.extend(ends.iter().map(|end| &end[..]));
    for (name, text) in polygons(&vertices, &faces) {
        let Imported { mesh, report } = read(name, text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        let surface = mesh.surface_report();
        assert!(surface.edges.is_watertight() && report.triangles_read == 20, "{name}: {surface:?}");
        assert!(
            (surface.volume_mm3 - 5.0).abs() < 1e-6 && (surface.area_mm2 - 22.0).abs() < 1e-6,
            "{name}: {surface:?}"
        );
    }
    let crossed = [[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let places = ["a.obj: line 6: ", "a.off: line 8: ", "a.ply: face 1: "];
    for ((name, text), place) in polygons(&crossed, &[&[0, 2, 1], &[0, 1, 2, 3]]).into_iter().zip(places) {
        let error = message(name, text.as_bytes());
        assert!(error.starts_with(&format!("{place}the sides of this polygon of 4 corners cross")), "{error}");
    }
}

#[test]
fn what_the_header_does_not_announce_is_refused() {
    let error = message("a.off", format!("{OFF}# more\n\n3 0 1 2\n").as_bytes());
    assert_eq!(
        error,
        "a.off: line 14: the header announces 4 vertices and 4 faces, and the file goes on with `3 0 1 2`"
    );
    let text = format!("{}\n\n3 0 1 2\n", objects::PLY.trim_end());
    assert!(message("a.ply", text.as_bytes()).contains("goes on after what its header announces"));
    for little in [true, false] {
        let binary = objects::binary_ply(little);
        assert!(read("a.ply", &[&binary[..], b"\n"].concat()).is_ok(), "white space");
        let error = message("a.ply", &[&binary[..], &[3]].concat());
        assert!(error.contains(&format!("byte {}: the file goes on", binary.len())), "{error}");
    }
}

#[test]
fn more_than_a_mesh_may_hold_is_refused_before_it_is_read() {
    // Empty lists of corners, one byte each.
    let mut file = b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 16777217\nproperty list uchar int vertex_indices\nend_header\n".to_vec();
    file.resize(file.len() + MOST + 1, 0);
    let error = message("a.ply", &file);
    assert!(error.contains("the header announces 16777217 of `face`; at most 16777216 are read"), "{error}");
}

#[test]
fn an_inside_out_mesh_is_reported() {
    let turned = OFF.replace("3 0 2 1", "3 0 1 2").replace("3 0 1 3", "3 0 3 1").replace("3 0 3 2", "3 0 2 3");
    let surface = read("a.off", turned.replace("3 1 2 3", "3 1 3 2").as_bytes()).unwrap().mesh.surface_report();
    assert!(surface.edges.is_watertight() && surface.is_inside_out());
}

#[test]
fn vertices_within_the_tolerance_become_the_first_of_them() {
    // The tetrahedron's last face stands 0.01 mm off in x, with vertices of its own.
    let apart = OFF.replace("4 4 6", "7 4 6").replace("0 0 1 # a comment\n", "0 0 1\n6.01 0 0\n0.01 1 0\n0.01 0 1\n");
    let apart = apart.replace("3 1 2 3", "3 4 5 6");
    let read = |weld_mm| parse(Path::new("a.off"), apart.as_bytes(), Options { unit: None, weld_mm });
    for (weld_mm, welded, open) in [(0.0, 0, 6), (0.005, 0, 6), (0.02, 3, 0)] {
        let Imported { mesh, report } = read(weld_mm).unwrap();
        assert_eq!(
            (report.welded_vertices, mesh.edge_report().open, mesh.vertices().len()),
            (welded, open, 7 - welded)
        );
    }
    assert_eq!(read(0.02).unwrap().mesh, parse(Path::new("a.off"), OFF.as_bytes(), None).unwrap().mesh);
    // (0, 1, 0) and (0, 0, 1) are 1 mm from the origin and go to it; the last triangle's corners are farther, and alone remain.
    let Imported { mesh, report } = read(1.0).unwrap();
    assert_eq!((report.collapsed, mesh.faces().len()), (3, 1));
    for weld_mm in [-1.0, 1e-7, 2.0, f64::NAN, f64::INFINITY] {
        assert!(read(weld_mm).unwrap_err().message.starts_with("vertices cannot be welded within "), "{weld_mm}");
    }
}

#[test]
fn errors_say_file_place_and_cause() {
    let binary = binary_stl();
    let error = message("cut.stl", &binary[..150]);
    assert_eq!(error, "cut.stl: the header announces 4 triangles, 284 bytes, but the file has 150 bytes");
    let mut huge = binary.clone();
    huge[80..84].fill(0xff);
    assert!(message("huge.stl", &huge).contains("4294967295 triangles"));
    let mut bad = binary.clone();
    bad[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(message("nan.stl", &bad).starts_with("nan.stl: triangle 1 at byte 134: "));
    assert!(
        message("a.stl", STL.replace("0 0 1\nvertex 0 1 0\nendloop", "0 x 1\nvertex 0 1 0\nendloop").as_bytes())
            .starts_with("a.stl: line 21: ")
    );
    assert!(message("cut.stl", &STL.as_bytes()[..STL.len() * 2 / 3]).starts_with("cut.stl: line "));
    assert!(message("a.obj", OBJ.replace("fo 2 3 4", "fo 2 3 9").as_bytes()).starts_with("a.obj: line 13: "));
    assert!(message("a.obj", OBJ.replace("f -4//", "f -5//").as_bytes()).starts_with("a.obj: line 12: "));
    for line in ["surf 0 1 0 1 1 2 3 4", "F 1 2 4", "call other.obj", "1 2 3"] {
        let error = message("a.obj", OBJ.replace("l 1 2", line).as_bytes());
        assert_eq!(error, format!("a.obj: line 14: this statement is not read, and may be a surface: `{line}`"));
    }
    for line in ["vp 0 1", "mg 1 0.1", "usemap none", "bevel on", "curv 0 1 1 2 3", "#f 1 2 4"] {
        assert!(read("a.obj", OBJ.replace("l 1 2", line).as_bytes()).is_ok(), "{line}");
    }
    assert!(
        message("a.obj", OBJ.replace("v 6 0 0", "v 6 zero 0").as_bytes())
            .contains("line 5: position parse error: `v 6 zero 0`")
    );
    assert!(message("a.off", OFF.replace("3 1 2 3", "3 1 2 9").as_bytes()).contains("line 11: there is no vertex 9"));
    assert!(message("a.off", OFF.replace("6 0 0", "6 nan 0").as_bytes()).contains("line 5: "));
    assert!(
        message("a.off", b"OFF\n4000000000 4000000000 0\n0 0 0\n")
            .contains("the file ends before vertex 1 of 4000000000")
    );
    assert!(message("a.off", b"OFF BINARY\n").contains("binary OFF"));
    assert!(message("a.obj", b"").contains("no triangle"));
    assert!(message("a.stl", b"").contains("0 bytes"));
    assert!(message("a.step", b"ISO-10303-21;").contains("not an STL, OBJ, OFF, PLY, GLB or 3MF file; STEP"));
    for (name, content, tool) in [
        ("a", &b"ISO-10303-21;"[..], "gmsh"),
        ("a.IGS", b"", "gmsh"),
        ("a.dae", b"x", "assimp"),
        ("a.xml", b"<COLLADA>", "assimp"),
    ] {
        assert!(message(name, content).contains(&format!("become STL by `{tool} ")), "{name}");
    }
    assert!(message("a.txt", b"x").ends_with("3MF file"));
    let missing = load(Path::new("no such folder/a.stl"), None).expect_err("there is no such file");
    assert!(missing.to_string().starts_with("no such folder/a.stl: "));
}

#[test]
fn a_file_on_disk_comes_back_as_it_was_written() {
    let path = tempfile::tempdir().unwrap();
    let path = path.path().join("part.stl");
    std::fs::write(&path, binary_stl()).unwrap();
    assert!(load(&path, None).unwrap().mesh.edge_report().is_watertight());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// However a file is damaged, the result is a mesh or an error.
    #[test]
    fn no_spoilt_file_panics(
        which in 0..9_usize, cut in 0.0..1.2_f64, flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        copied in any::<prop::sample::Index>(), unit in prop::sample::select(vec![Unit::Mm, Unit::M, Unit::Inch]),
        weld_mm in prop::sample::select(vec![0.0, 1e-6, 0.5]),
    ) {
        let (name, mut content) = match which {
            0 => ("a.obj", OBJ.as_bytes().to_vec()),
            1 => ("a.off", OFF.as_bytes().to_vec()),
            2 => ("a.stl", STL.as_bytes().to_vec()),
            3 => ("a.ply", objects::PLY.as_bytes().to_vec()),
            4 => ("a.ply", objects::binary_ply(true)),
            5 => ("a.ply", objects::binary_ply(false)),
            6 => ("a.glb", objects::glb(objects::GLB)),
            7 => ("a.3mf", objects::three_mf(objects::MODEL)),
            _ => ("a.stl", binary_stl()),
        };
        // A piece of the file once more, in the middle of it, and digits where none were.
        let (from, at) = (copied.index(content.len()), flips.len() * 7 % content.len());
        if flips.len() > 3 {
            let piece = content[from..content.len().min(from + 9)].to_vec();
            content.splice(at..at, piece);
        }
        for (index, byte) in &flips {
            let i = index.index(content.len());
            content[i] = if byte % 2 == 0 { *byte } else { b"0123456789.-e/ \n"[usize::from(*byte) / 2 % 16] };
        }
        content.truncate((content.len() as f64 * cut) as usize);
        for name in [name, "unknown"] {
            if let Ok(imported) = parse(Path::new(name), &content, Options { unit: Some(unit), weld_mm }) {
                prop_assert!(!imported.mesh.faces().is_empty());
            }
        }
    }
}
