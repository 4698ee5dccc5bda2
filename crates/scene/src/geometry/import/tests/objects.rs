//! Tests of the formats that have objects, headers and units: PLY, GLB, 3MF.

use super::*;

pub(super) const PLY: &str = "ply
format ascii 1.0
comment a tetrahedron
element material 1
property uchar red
element vertex 4
property float x
property double y
property short z
property uchar red
element face 4
property list uchar int vertex_indices
element edge 0
property int vertex1
end_header
255
0 -0.0 0 1
6 0 0 2
0 1.0e-0 0 3
0 0 1 4
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
";

/// The same tetrahedron in binary: positions in double precision, corners in 16 bits.
pub(in super::super) fn binary_ply(little: bool) -> Vec<u8> {
    let order = if little { "little" } else { "big" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
         element face 4\nproperty list uchar ushort vertex_index\nproperty uchar red\nend_header\n"
    )
    .into_bytes();
    for x in [0_f64, 0.0, 0.0, 6.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] {
        bytes.extend(if little { x.to_le_bytes() } else { x.to_be_bytes() });
    }
    for face in FACES {
        bytes.push(3);
        face.iter().for_each(|v| bytes.extend(if little { v.to_le_bytes() } else { v.to_be_bytes() }));
        bytes.push(255);
    }
    bytes
}

const FACES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// A tetrahedron of 0.006, 0.001 and 0.001 m. Its node mirrors it, scales it by 2.5 and moves it: (x, y, z) to (-2.5 x + 1, 2.5 y, 2.5 z).
/// The parent node turns it by a quarter turn about z: (x, y) to (-y, x).
pub(in super::super) const GLB: &str = r#"{"asset": {"version": "2.0"},
"scene": 0, "scenes": [{"nodes": [1]}],
"nodes": [{"mesh": 0, "matrix": [-2.5,0,0,0, 0,2.5,0,0, 0,0,2.5,0, 1,0,0,1]},
 {"children": [0], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 77}, "indices": 1},
 {"attributes": {"POSITION": 0}, "mode": 1}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
 {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 64, "byteStride": 16}, {"buffer": 0, "byteOffset": 64, "byteLength": 24}],
"buffers": [{"byteLength": 88}], "extensionsRequired": ["KHR_materials_unlit"]}"#;

/// A GLB file with this JSON and a binary chunk of four vertices, 16 bytes each, and twelve 16-bit indices.
pub(in super::super) fn glb(json: &str) -> Vec<u8> {
    let mut binary = Vec::new();
    for [x, y, z] in [[0_f32, 0.0, 0.0], [0.006, 0.0, 0.0], [0.0, 0.001, 0.0], [0.0, 0.0, 0.001]] {
        [x, y, z, 9.0].iter().for_each(|x| binary.extend(x.to_le_bytes()));
    }
    FACES.iter().flatten().for_each(|v| binary.extend(v.to_le_bytes()));
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((length as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", &binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// The tetrahedron in centimetres: 0.6, 0.1 and 0.1. The build places, mirrored and moved, an object that contains it.
pub(in super::super) const MODEL: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="centimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:b="urn:of-others">
 <metadata name="Title">a &amp; b</metadata>
 <resources>
  <object id="1" type="model"><mesh><vertices>
   <vertex x="0" y="0" z="0"/><vertex x="0.6" y="0" z="0"/><vertex x="0" y="1e-1" z="0"/><vertex x="0" y="0" z=".1"></vertex>
  </vertices><triangles>
   <triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/>
  </triangles><b:triangle v1="99"/></mesh></object>
  <object id="2"><components><component objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>
  <object id="3"/>
 </resources>
 <build><item objectid="2" transform="0 1 0 -1 0 0 0 0 1 1 0 0"/></build>
</model>
"#;

#[cfg(feature = "3mf")]
fn archive(parts: &[(&str, &str)]) -> Vec<u8> {
    use std::io::{Cursor, Write};
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        let options = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
        writer.start_file(*name, options).unwrap();
        writer.write_all(text.as_bytes()).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// A 3MF file with this model. Without the feature, only the first bytes of one, because nothing else is read then.
pub(in super::super) fn three_mf(model: &str) -> Vec<u8> {
    #[cfg(feature = "3mf")]
    return archive(&[("[Content_Types].xml", "<Types/>"), ("3D/3dmodel.model", model)]);
    #[cfg(not(feature = "3mf"))]
    [ZIP, model.as_bytes()].concat()
}

/// The corners of a mesh's bounding box, mm.
fn extent(mesh: &Mesh) -> [[f64; 3]; 2] {
    let by = |pick: fn(f64, f64) -> f64| {
        let points = mesh.vertices().iter().map(|p| p.coords);
        points.reduce(|a, b| a.zip_map(&b, pick)).unwrap().into()
    };
    [by(f64::min), by(f64::max)]
}

fn assert_near(found: [[f64; 3]; 2], expected: [[f64; 3]; 2]) {
    let near = found.iter().flatten().zip(expected.iter().flatten()).all(|(a, b): (&f64, &f64)| (a - b).abs() < 1e-5);
    assert!(near, "{found:?} and not {expected:?}");
}

#[test]
fn glb_nodes_place_turn_and_mirror_and_stay_outward() {
    for name in ["a.glb", "glb"] {
        let Imported { mesh, report } = read(name, &glb(GLB)).unwrap();
        assert_eq!((report.format, report.unit_mm, report.triangles_read), (Format::Glb, 1000.0, 4));
        let surface = mesh.surface_report();
        assert!(surface.leaking == 0 && !surface.is_inside_out(), "{surface}");
        // 6 · 1 · 1 / 6 mm³, stretched by 2.5 three ways.
        assert!((mesh.signed_volume() - 15.625).abs() < 1e-3, "{}", mesh.signed_volume());
        // The mirror takes x = 0 .. 6 mm to 1000 - 2.5 · 6 = 985 .. 1000 mm and y to 0 .. 2.5; the turn makes them y and -x.
        assert_near(extent(&mesh), [[-2.5, 985.0, 0.0], [0.0, 1000.0, 2.5]]);
    }
    let inches = parse(Path::new("a.glb"), &glb(GLB), Some(Unit::Inch)).unwrap();
    assert!((inches.mesh.signed_volume() / 15.625 - 0.0254_f64.powi(3)).abs() < 1e-6);
}

#[test]
fn glb_strips_fans_and_loose_corners_wind_alike() {
    // Without indices, four vertices: a strip of 0 1 2 and 2 1 3, a fan of 1 2 0 and 2 3 0.
    let strip = GLB.replacen(r#", "indices": 1"#, r#", "mode": 5"#, 1);
    let mesh = read("a.glb", &glb(&strip)).unwrap().mesh;
    let edges = mesh.edge_report();
    assert_eq!((mesh.faces().len(), edges.open, edges.flipped), (2, 4, 0));
    let fan = GLB.replacen(r#", "indices": 1"#, r#", "mode": 6"#, 1);
    let mesh = read("a.glb", &glb(&fan)).unwrap().mesh;
    let edges = mesh.edge_report();
    assert_eq!((mesh.faces().len(), edges.open, edges.flipped), (2, 4, 0));
    let loose = GLB.replacen(r#", "indices": 1"#, "", 1);
    let error = message("a.glb", &glb(&loose));
    assert_eq!(error, "a.glb: meshes[0].primitives[0]: 4 corners do not make triangles");
}

#[test]
fn glb_errors_name_the_byte_or_the_object() {
    let file = glb(GLB);
    let spoilt = |from: &str, to: &str| {
        assert!(GLB.contains(from), "{from}");
        message("a.glb", &glb(&GLB.replacen(from, to, 1)))
    };
    assert!(message("a.glb", &file[..100]).starts_with("a.glb: byte 8: the header announces"));
    let mut chunk = file.clone();
    chunk[12..16].fill(0xff);
    assert!(message("a.glb", &chunk).starts_with("a.glb: byte 12: the chunk announces 4294967295 bytes"));
    assert!(message("a.glb", b"glTF\x01\0\0\0\x0c\0\0\0").starts_with("a.glb: byte 4: version 1"));
    assert!(message("a.glb", b"glTF\x02\0\0\0\x0c\0\0\0").contains("the first chunk is not JSON"));
    // The first line has 31 bytes and a line feed, and the seventh character of the second is wrong.
    assert!(GLB.starts_with(r#"{"asset": {"version": "2.0"},"#));
    assert!(spoilt("\"scene\": 0", "\"scene\" 0").starts_with("a.glb: byte 58: expected `:`"));
    assert!(
        spoilt("\"count\": 4", "\"count\": 4000000000000").starts_with("a.glb: accessors[0]: 4000000000000 elements")
    );
    assert!(spoilt("\"count\": 4", "\"count\": 18446744073709551615").starts_with("a.glb: accessors[0]: "));
    assert!(
        spoilt("\"byteOffset\": 64", "\"byteOffset\": 18446744073709551615").starts_with("a.glb: bufferViews[1]: ")
    );
    assert!(spoilt("\"byteStride\": 16", "\"byteStride\": 0").starts_with("a.glb: accessors[0]: "));
    assert!(spoilt("\"POSITION\": 0", "\"POSITION\": 1").starts_with("a.glb: accessors[1]: positions must be"));
    assert!(spoilt("\"indices\": 1", "\"indices\": 8").starts_with("a.glb: accessors[8]: there is no such accessor"));
    assert!(
        spoilt("\"children\": [0]", "\"children\": [1]").starts_with("a.glb: nodes[1]: the node is in the scene twice")
    );
    assert!(spoilt("\"children\": [0]", "\"children\": [2]").starts_with("a.glb: nodes[2]: there is no such node"));
    assert!(spoilt("\"mesh\": 0", "\"mesh\": 5").starts_with("a.glb: meshes[5]: "));
    assert!(spoilt("\"scene\": 0", "\"scene\": 5").starts_with("a.glb: scene: there is no scene 5"));
    assert!(spoilt("{\"byteLength\": 88}", "{\"uri\": \"a.bin\"}").contains("buffer 0 is not in the file"));
    // What a node places otherwise than by its matrix; without `extensionsRequired`, too.
    let instances =
        spoilt("\"mesh\": 0", "\"mesh\": 0, \"extensions\": {\"EXT_mesh_gpu_instancing\": {\"attributes\": {}}}");
    assert_eq!(instances, "a.glb: nodes[0]: the extension EXT_mesh_gpu_instancing is not read");
    assert!(spoilt("\"mesh\": 0", "\"mesh\": 0, \"skin\": 0").starts_with("a.glb: nodes[0]: skins are not read"));
    let morphed = |of_node: &str, of_mesh: &str| {
        let json = GLB.replacen("\"mesh\": 0", &format!("\"mesh\": 0{of_node}"), 1);
        let json = json.replacen("\"meshes\": [{", &format!("\"meshes\": [{{{of_mesh}"), 1);
        read("a.glb", &glb(&json.replacen("\"indices\": 1", "\"indices\": 1, \"targets\": [{\"POSITION\": 0}]", 1)))
    };
    for (of_node, of_mesh, is_read) in [
        ("", "", true),
        ("", "\"weights\": [0], ", true),
        (", \"weights\": [0]", "\"weights\": [1], ", true),
        (", \"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}", "", true),
        ("", "\"weights\": [0, 1], ", false),
        (", \"weights\": [0.5]", "", false),
    ] {
        match morphed(of_node, of_mesh) {
            Ok(_) => assert!(is_read, "{of_node} {of_mesh}"),
            Err(error) => {
                let expected = "a.glb: meshes[0].primitives[0]: morph targets are not read";
                assert!(!is_read && error.to_string().starts_with(expected), "{of_node} {of_mesh}: {error}");
            }
        }
    }
    let draco = spoilt("KHR_materials_unlit", "KHR_draco_mesh_compression");
    assert_eq!(draco, "a.glb: extensionsRequired: the extension KHR_draco_mesh_compression is not read");
    let start = file.len() - 24 - 64;
    let mut nan = file.clone();
    nan[start + 16..start + 20].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(message("a.glb", &nan), "a.glb: accessors[0]: position 1 is not finite");
    let mut index = file.clone();
    index[start + 64] = 4;
    assert_eq!(message("a.glb", &index), "a.glb: meshes[0].primitives[0]: there is no vertex 4, only 4");
}

#[test]
fn ply_errors_name_the_line_or_the_byte() {
    let spoilt = |from: &str, to: &str| {
        assert!(PLY.contains(from), "{from}");
        message("a.ply", PLY.replacen(from, to, 1).as_bytes())
    };
    assert!(
        spoilt("element vertex 4", "element vertex 4000000000")
            .starts_with("a.ply: line 17: the header announces 4000000000")
    );
    assert!(spoilt("6 0 0 2", "6 zero 0 2").starts_with("a.ply: line 18: "), "{}", spoilt("6 0 0 2", "6 zero 0 2"));
    assert!(spoilt("6 0 0 2", "6 zero 0 2").ends_with("`6 zero 0 2`"));
    assert_eq!(spoilt("6 0 0 2", "inf 0 0 2"), "a.ply: line 18: Couldn't read element line: `inf 0 0 2`");
    assert_eq!(spoilt("3 1 2 3", "3 1 2 4"), "a.ply: face 3: there is no vertex 4, only 4");
    assert_eq!(spoilt("3 1 2 3", "3 1 2 -1"), "a.ply: face 3: there is no vertex -1, only 4");
    assert!(spoilt("3 1 2 3", "4 1 2 3").starts_with("a.ply: line 24: "));
    assert!(spoilt("3 1 2 3\n", "").starts_with("a.ply: line 24: "), "{}", spoilt("3 1 2 3\n", ""));
    assert!(spoilt("property double y", "property double yy").contains("no element `vertex` with a scalar `y`"));
    assert!(spoilt("element face 4", "element tristrips 4").contains("triangle strips are not read"));
    assert!(spoilt("property uchar red", "property colour red").starts_with("a.ply: line 5: "));
    assert!(message("a.ply", b"ply\nformat ascii 1.0\n").starts_with("a.ply: line 3: "));

    let binary = binary_ply(true);
    let body = binary.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let cut = message("a.ply", &binary[..binary.len() - 1]);
    assert!(cut.starts_with(&format!("a.ply: byte {}: ", binary.len() - 1)), "{cut}");
    let mut long = binary.clone();
    long[body + 96] = 255;
    let mut nan = binary.clone();
    nan[body + 24..body + 32].copy_from_slice(&f64::NAN.to_le_bytes());
    assert_eq!(message("a.ply", &nan), "a.ply: vertex 1 has a coordinate that is not finite: (NaN, 0, 0)");
    assert!(message("a.ply", &long).starts_with("a.ply: byte "));
    let text = String::from_utf8_lossy(&binary[..body]).into_owned();
    let lie =
        |from: &str, to: &str| message("a.ply", &[text.replacen(from, to, 1).as_bytes(), &binary[body..]].concat());
    assert!(
        lie("element face 4", "element face 400000000")
            .contains("announces 400000000 of `face`, at least 2 bytes each")
    );
    let nothing = lie("element face 4", "element nothing 99999999999\nelement face 4");
    assert!(nothing.contains("announces 99999999999 of `nothing`, at least 0 bytes each"), "{nothing}");
}

#[test]
fn a_report_says_in_a_line_what_was_found() {
    let report = |name, content: &str| {
        let Imported { mesh, report } = read(name, content.as_bytes()).unwrap();
        format!("{report}; {}", mesh.surface_report())
    };
    assert_eq!(report("a.ply", PLY), "PLY in units of 1 mm, 4 triangles; watertight");
    assert_eq!(report("a.stl", STL), "text STL in units of 1 mm, 4 triangles, 8 vertices welded; watertight");
    let open = PLY.replace("3 1 2 3", "3 0 1 2");
    assert_eq!(
        report("a.ply", &open),
        "PLY in units of 1 mm, 4 triangles, 1 duplicate triangles dropped; not watertight: 3 edges on one triangle"
    );
}

#[cfg(not(feature = "3mf"))]
#[test]
fn without_the_feature_a_3mf_file_says_how_to_read_it() {
    for name in ["a.3mf", "archive"] {
        let error = message(name, &three_mf(MODEL));
        assert!(error.ends_with("3MF is read by a build with `--features 3mf`; this one was built without"), "{error}");
    }
}

#[cfg(feature = "3mf")]
#[test]
fn three_mf_items_place_components_in_the_files_unit() {
    let elsewhere = MODEL.replace(r#"<item objectid="2""#, r#"<item b:path="/3D/other.model" objectid="2""#);
    for (name, content) in [
        ("a.3mf", three_mf(MODEL)),
        ("archive", three_mf(MODEL)),
        (
            "prefixed.3mf",
            three_mf(
                &MODEL
                    .replace("</", "</c:")
                    .replace('<', "<c:")
                    .replace("<c:/c:", "</c:")
                    .replace("<c:?", "<?")
                    .replace("<c:b:", "<b:"),
            ),
        ),
        ("split.3mf", archive(&[("3D/other.model", MODEL), ("3D/3dmodel.model", &elsewhere)])),
    ] {
        let Imported { mesh, report } = read(name, &content).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((report.format, report.unit_mm, report.triangles_read), (Format::ThreeMf, 10.0, 4), "{name}");
        let surface = mesh.surface_report();
        assert!(surface.leaking == 0 && !surface.is_inside_out(), "{name}: {surface}");
        assert!((mesh.signed_volume() - 1.0).abs() < 1e-6, "{name}"); // 6 · 1 · 1 / 6 mm³
        // Mirrored, x is -6 .. 0 mm; then (x, y) goes to (-y + 10 mm, x).
        assert_near(extent(&mesh), [[9.0, -6.0, 0.0], [10.0, 0.0, 1.0]]);
    }
    let millimetres = parse(Path::new("a.3mf"), &three_mf(MODEL), Some(Unit::Mm)).unwrap().mesh;
    assert!((millimetres.signed_volume() - 1e-3).abs() < 1e-8);
}

#[cfg(feature = "3mf")]
#[test]
fn three_mf_errors_name_part_line_and_column() {
    let spoilt = |from: &str, to: &str| {
        assert!(MODEL.contains(from), "{from}");
        message("a.3mf", &three_mf(&MODEL.replacen(from, to, 1)))
    };
    let vertex = spoilt("<vertex x=\"0.6\"", "<vertex x=\"six\"");
    assert_eq!(vertex, "a.3mf: 3D/3dmodel.model: line 6, column 31: `x` is not a number of its kind: `six`");
    assert!(spoilt("v2=\"2\"", "v4=\"2\"").contains("line 8, column 4: `v2` is missing"));
    assert!(spoilt("v2=\"2\"", "v2=\"-2\"").contains("line 8, column 4: `v2` is not a number of its kind"));
    assert!(spoilt("v2=\"2\"", "v2=\"4\"").contains("object 1 has no vertex 4, only 4"));
    assert!(spoilt("x=\"0.6\"", "x=\"inf\"").contains("not finite"));
    assert!(spoilt("centimeter", "furlong").contains("line 2, column 1: there is no unit `furlong`"));
    assert!(spoilt("-1 0 0 0 1", "-1 0 0 0").contains("line 10, column 30: a transform is twelve numbers"));
    assert!(
        spoilt("component objectid=\"1\"", "component objectid=\"7\"")
            .contains("object 7 of 3d/3dmodel.model: there is no such object")
    );
    assert!(spoilt("component objectid=\"1\"", "component objectid=\"2\"").contains("does one hold itself?"));
    assert!(spoilt("object id=\"2\"", "object id=\"1\"").contains("there is an object 1 already"));
    let requires = spoilt("<model ", "<model requiredextensions=\"b\" ");
    assert!(
        requires.ends_with("line 2, column 1: the file requires the extension `b`, `urn:of-others`; it is not read")
    );
    for known in ["production/2015/06", "material/2015/02"] {
        let model = MODEL.replace("urn:of-others", &format!("http://schemas.microsoft.com/3dmanufacturing/{known}"));
        let model = model.replacen("<model ", "<model requiredextensions=\" b \" ", 1);
        assert!(read("a.3mf", &three_mf(&model)).is_ok(), "{known}");
    }
    assert!(spoilt("<model", "<mesh").contains("line 2, column 1: expected `model`, found `mesh`"));
    assert!(spoilt("</triangles>", "</mesh>").contains("3D/3dmodel.model: line 9, column 3: "));
    assert!(message("a.3mf", &three_mf(&MODEL[..400])).contains("3D/3dmodel.model: line "));
    assert!(message("a.3mf", b"PK\x03\x04").starts_with("a.3mf: archive, directory: "));
    assert!(message("a.3mf", &archive(&[("readme", "")])).contains("there is no model that builds anything"));
    let file = three_mf(MODEL);
    assert!(message("a.3mf", &file[..file.len() - 9]).starts_with("a.3mf: archive, "));
}

/// Sixteen objects, each placing the previous one sixteen times: 16^16 placements in two kilobytes.
#[cfg(feature = "3mf")]
#[test]
fn three_mf_objects_that_multiply_are_refused() {
    let object = |id: usize| {
        let component = format!("<component objectid=\"{}\"/>", id - 1);
        format!("<object id=\"{id}\"><components>{}</components></object>", component.repeat(16))
    };
    let objects: String = (4..20).map(object).collect();
    let model = MODEL
        .replace("</resources>", &format!("{objects}</resources>"))
        .replace("item objectid=\"2\"", "item objectid=\"19\"");
    assert!(message("a.3mf", &three_mf(&model)).contains("more than 65536 objects are placed"));
}
