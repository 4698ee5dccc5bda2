//! Hostile inputs, hundreds of them, given to the program itself: it must end within seconds and 4 GB, with exit code 0, 1 or 2, and say which file
//! is wrong. Never a panic, an abort or a hang.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const SEED: u64 = 2011;
/// Longest that a run may take; without optimisation the limits of a program are met later.
const LONGEST: Duration = Duration::from_secs(if cfg!(debug_assertions) { 120 } else { 20 });
/// Address space of a run, in units of 1024 bytes: 4 GB.
const MEMORY_KIB: u32 = 4 << 20;

/// A run of the program.
struct Attack {
    name: String,
    arguments: Vec<String>,
    /// What the message must name when the run fails.
    names: String,
    /// Exit codes that are right.
    codes: &'static [i32],
}

/// How a run ended.
fn run(attack: &Attack) -> Result<(), String> {
    let limited = format!("ulimit -v {MEMORY_KIB}; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_bvbench")])
        .args(&attack.arguments)
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    let mut errors = child.stderr.take().unwrap();
    let reader = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = errors.by_ref().take(1 << 20).read_to_end(&mut text);
        let _ = std::io::copy(&mut errors, &mut std::io::sink());
        String::from_utf8_lossy(&text).into_owned()
    });
    let begin = Instant::now();
    let status = loop {
        match child.try_wait().map_err(|error| error.to_string())? {
            Some(status) => break status,
            None if begin.elapsed() > LONGEST => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("still running after {LONGEST:?}"));
            }
            None => std::thread::sleep(Duration::from_millis(3)),
        }
    };
    let text = reader.join().unwrap();
    let code = status.code().ok_or_else(|| format!("killed: {status}, {text}"))?;
    if text.contains("panicked") {
        return Err(format!("panic: {text}"));
    }
    if !attack.codes.contains(&code) {
        return Err(format!("exit code {code}, not one of {:?}: {text}", attack.codes));
    }
    if code == 2 && !text.contains(&attack.names) {
        return Err(format!("the message does not name {}: {text}", attack.names));
    }
    Ok(())
}

/// What is made of a good file, by number.
fn spoiled(good: &[u8], kind: usize, random: &mut Pcg64) -> Vec<u8> {
    let mut bytes = good.to_vec();
    let at = |random: &mut Pcg64, length: usize| (random.next_u64() % length.max(1) as u64) as usize;
    match kind {
        // Cut short.
        0..=2 => bytes.truncate(at(random, good.len())),
        // Bytes of chance.
        3..=5 => {
            for _ in 0..1 + at(random, 8) {
                let place = at(random, good.len());
                if let Some(byte) = bytes.get_mut(place) {
                    *byte = random.next_u64() as u8;
                }
            }
        }
        // Carriage returns alone.
        6 => bytes = String::from_utf8_lossy(good).replace("\r\n", "\n").replace('\n', "\r").into_bytes(),
        // UTF-16, either order.
        7 | 8 => {
            let order = if kind == 7 { u16::to_le_bytes } else { u16::to_be_bytes };
            let mark = '\u{feff}';
            let text = format!("{mark}{}", String::from_utf8_lossy(good));
            bytes = text.encode_utf16().flat_map(order).collect();
        }
        // Numbers that are none, too large, too small; each digit run of chance replaced.
        9..=13 => {
            let number = ["nan", "inf", "1e308", "-1e-320", "99999999999999999999"][kind - 9];
            let text = String::from_utf8_lossy(good).into_owned();
            let digits: Vec<(usize, &str)> = text.match_indices(|c: char| c.is_ascii_digit()).collect();
            if !digits.is_empty() {
                let (place, _) = digits[at(random, digits.len())];
                bytes = format!("{}{number}{}", &text[..place], &text[place + 1..]).into_bytes();
            }
        }
        // Nothing, zeros, all of it many times.
        14 => bytes.clear(),
        15 => bytes = vec![0; 10_000],
        16 => bytes = good.repeat(50),
        // A piece moved to another place.
        _ => {
            let (from, to) = (at(random, good.len()), at(random, good.len()));
            let piece = bytes.split_off(from.min(bytes.len()));
            let to = to.min(bytes.len());
            bytes.splice(to..to, piece);
        }
    }
    bytes
}
const SPOILED: usize = 22;

/// The seeds of the fuzz targets for a kind of file.
fn seeds(kind: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(kind);
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|file| fs::read(file).unwrap()).collect()
}

const MESH_SCENE: &str = r#"
title = "a mesh against a cube"
[[machine.links]]
name = "slide"
joint = { axis = "X", direction = [1, 0, 0] }
[[parts]]
name = "mesh"
mesh = "MESH"
[[parts]]
name = "cube"
link = "slide"
shape = { kind = "sphere", radius_mm = 20 }
tessellation = { density = 0.3 }
"#;

const PROGRAM_SCENE: &str = r#"
title = "two cubes"
[[machine.links]]
name = "slide"
joint = { axis = "X", direction = [1, 0, 0] }
[[parts]]
name = "one"
shape = { kind = "sphere", radius_mm = 20 }
tessellation = { density = 0.3 }
[[parts]]
name = "other"
link = "slide"
shape = { kind = "sphere", radius_mm = 20 }
tessellation = { density = 0.3 }
[program]
file = "PROGRAM"
"#;

#[cfg(feature = "urdf")]
const URDF: &str = r#"<?xml version="1.0"?>
<robot name="small">
  <link name="bed"><visual><geometry><box size="1 0.2 0.1"/></geometry></visual></link>
  <link name="arm"><collision><origin xyz="0.1 0 0" rpy="0 0 1.5"/><geometry><cylinder radius="0.03" length="0.2"/></geometry></collision></link>
  <link name="hand"><visual><geometry><sphere radius="0.04"/></geometry></visual></link>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0.1 0.2" rpy="0 0 0.5"/><parent link="bed"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="-0.25" upper="0.25" effort="1" velocity="1"/>
  </joint>
  <joint name="swing" type="revolute">
    <parent link="arm"/><child link="hand"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>
"#;

struct Attacks {
    folder: PathBuf,
    random: Pcg64,
    all: Vec<Attack>,
}

impl Attacks {
    fn write(&self, name: &str, bytes: &[u8]) -> String {
        let path = self.folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path.to_string_lossy().into_owned()
    }

    fn add(&mut self, name: String, arguments: &[&str], names: &str, codes: &'static [i32]) {
        let arguments = arguments.iter().map(|&argument| argument.to_owned()).collect();
        self.all.push(Attack { name, arguments, names: names.to_owned(), codes });
    }

    fn scene_of(&mut self, name: &str, text: &str, names: &str, codes: &'static [i32]) {
        self.write(&format!("{name}/scene.toml"), text.as_bytes());
        let folder = self.folder.join(name).to_string_lossy().into_owned();
        self.add(name.to_owned(), &["scene", "info", &folder], names, codes);
    }

    fn meshes(&mut self) {
        for (kind, extension) in
            [("stl", "stl"), ("obj", "obj"), ("off", "off"), ("ply", "ply"), ("glb", "glb"), ("three_mf", "3mf")]
        {
            for (number, good) in seeds(kind).iter().enumerate() {
                for spoil in 0..SPOILED {
                    let file = format!("mesh.{extension}");
                    let name = format!("mesh-{kind}-{number}-{spoil}");
                    let bytes = spoiled(good, spoil, &mut self.random);
                    self.write(&format!("{name}/{file}"), &bytes);
                    self.scene_of(&name, &MESH_SCENE.replace("MESH", &file), &file, &[0, 2]);
                }
            }
        }
    }

    fn programs(&mut self) {
        for (number, good) in seeds("gcode").iter().enumerate() {
            for spoil in 0..SPOILED {
                let name = format!("program-{number}-{spoil}.ngc");
                let bytes = spoiled(good, spoil, &mut self.random);
                let path = self.write(&name, &bytes);
                self.add(name.clone(), &["program", "gcode", &path], &name, &[0, 2]);
            }
        }
        let endless = [
            ("o1 while [1 EQ 1]\n#1=1\no1 endwhile\nM2", "loop"),
            ("o1 while [1 EQ 1]\nG0 X1\nG0 X2\no1 endwhile\nM2", "moves"),
            ("o1 sub\no1 call\no1 endsub\no1 call\nM2", "recursion"),
            ("o1 repeat [1e15]\nG91 G1 X1 F100\no1 endrepeat\nM2", "repeat"),
            ("G81 X1 Y1 Z-1 R1 L1000000000 F100\nM2", "cycle"),
            ("G18 M3 S100 G33 Z-10 K0\nM2", "pitch"),
            ("G18 M3 S100 G33 Z-10 K0.0000000001\nM2", "small-pitch"),
        ];
        for (text, what) in endless {
            let name = format!("endless-{what}.ngc");
            let path = self.write(&name, text.as_bytes());
            self.add(name.clone(), &["program", "gcode", &path], &name, &[2]);
        }
        for depth in [100, 10_000, 1_000_000] {
            let name = format!("deep-{depth}.ngc");
            let text = format!("G0 X{}1{}\nM2", "[".repeat(depth), "]".repeat(depth));
            let path = self.write(&name, text.as_bytes());
            self.add(name.clone(), &["program", "gcode", &path], &name, &[0, 2]);
        }
        let many = self.write("lines.ngc", "G0 X1\n".repeat(2_100_000).as_bytes());
        self.add("lines.ngc".to_owned(), &["program", "gcode", &many], "more than 2000000 lines", &[2]);
        let calls = self.write("calls/calls.ngc", b"o<long> call\nM2");
        self.write("calls/long.ngc", "G0 X1\n".repeat(2_100_000).as_bytes());
        self.add("called lines".to_owned(), &["program", "gcode", &calls], "long.ngc", &[2]);
        let calls = self.write("odd/odd.ngc", b"o<folder> call\nM2");
        fs::create_dir_all(self.folder.join("odd/folder.ngc")).unwrap();
        self.add("called folder".to_owned(), &["program", "gcode", &calls], "it is a folder, not a regular file", &[2]);
    }

    fn scenes(&mut self) {
        for (number, good) in seeds("scene").iter().enumerate() {
            for spoil in 0..SPOILED {
                let bytes = spoiled(good, spoil, &mut self.random);
                let name = format!("scene-{number}-{spoil}");
                self.write(&format!("{name}/scene.toml"), &bytes);
                let folder = self.folder.join(&name).to_string_lossy().into_owned();
                self.add(name.clone(), &["scene", "info", &folder], &name, &[0, 2]);
            }
        }
        // Every number of a scene, in turn, is one that cannot be meant.
        let scene = PROGRAM_SCENE.replace("PROGRAM", "a.ngc");
        for (place, _) in scene.match_indices(|c: char| c.is_ascii_digit()) {
            for number in ["1e300", "-1e300", "nan", "1e-320", "9223372036854775807", "1e12", "-0.5"] {
                let name = format!("number-{place}-{number}");
                self.write(&format!("{name}/a.ngc"), b"G0 X1\nM2");
                let text = format!("{}{number}{}", &scene[..place], &scene[place + 1..]);
                self.scene_of(&name, &text, "scene.toml:", &[0, 2]);
            }
        }
        self.scene_of(
            "beyond",
            &scene.replace("name = \"other\"", "name = \"other\"\nat = { xyz_mm = [1e200, 0, 0] }"),
            "scene.toml:12:18: xyz_mm: 1e200 is beyond 1e9",
            &[2],
        );
        let cycle =
            "[[machine.links]]\nname = \"a\"\nparent = \"b\"\n[[machine.links]]\nname = \"b\"\nparent = \"a\"\n";
        self.scene_of("cycle", &format!("title = \"t\"\n{cycle}"), "scene.toml:", &[2]);
        // 1 000 parts in 100 000 frames, each of which moves one.
        let parts: String = (0..1000).map(|i| format!("[[parts]]\nname = \"p{i}\"\nmesh = \"part.obj\"\n")).collect();
        let poses = format!("part,qw,qx,qy,qz,tx,ty,tz\n{}", "p1,1,0,0,0,0,0,0\n".repeat(100_000));
        self.write("many-poses/part.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        self.write("many-poses/poses.csv", poses.as_bytes());
        let pairs = "pairs = [[\"p0\", \"p1\"]]\n";
        self.scene_of(
            "many-poses",
            &format!("title = \"t\"\n{pairs}{parts}[recorded]\nfile = \"poses.csv\"\n"),
            "",
            &[0],
        );
        let deep = format!("title = {}1{}", "[".repeat(100_000), "]".repeat(100_000));
        self.scene_of("deep", &deep, "scene.toml", &[2]);
    }

    /// Things that are no files, in the place of each kind of file.
    fn devices(&mut self) {
        let pipe = self.folder.join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let pipe = pipe.to_string_lossy().into_owned();
        let missing = self.folder.join("missing").to_string_lossy().into_owned();
        let mesh = self.write("try.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let poses = self.write("try.csv", b"part,qw,qx,qy,qz,tx,ty,tz\ntry,1,0,0,0,0,0,0\n");
        let out = self.folder.join("try-run").to_string_lossy().into_owned();
        for (what, path) in
            [("zero", "/dev/zero"), ("pipe", &pipe), ("folder", "/"), ("missing", &missing), ("null", "/dev/null")]
        {
            self.scene_of(&format!("mesh-is-{what}"), &MESH_SCENE.replace("MESH", path), path, &[2]);
            self.scene_of(&format!("program-is-{what}"), &PROGRAM_SCENE.replace("PROGRAM", path), path, &[2]);
            let machine = format!("title = \"t\"\n[machine]\nfile = \"{path}\"\n");
            self.scene_of(&format!("machine-is-{what}"), &machine, path, &[2]);
            let recorded = MESH_SCENE.replace("mesh = \"MESH\"", "shape = { kind = \"sphere\", radius_mm = 20 }");
            self.scene_of(
                &format!("recording-is-{what}"),
                &format!("{recorded}[recorded]\nfile = \"{path}\"\n"),
                path,
                &[2],
            );
            self.add(format!("gcode-is-{what}"), &["program", "gcode", path], path, &[2]);
            self.add(format!("tools-are-{what}"), &["program", "gcode", path, "--tool-table", path], path, &[2]);
            self.add(format!("check-{what}"), &["check", "mill-vise", path], path, &[2]);
            self.add(format!("try-{what}"), &["try", &mesh, path, &poses, "--out", &out], path, &[2]);
            self.add(
                format!("claims-are-{what}"),
                &["stage", "analyze", "--claims", path, "--out", "none"],
                path,
                &[2],
            );
            let run = self.folder.join(format!("run-{what}"));
            fs::create_dir_all(&run).unwrap();
            std::os::unix::fs::symlink(path, run.join("manifest.json")).unwrap();
            let run = run.to_string_lossy().into_owned();
            for verb in ["analyze", "plot", "report"] {
                self.add(format!("{verb}-of-{what}"), &["stage", verb, "--out", &run], "manifest.json", &[2]);
            }
        }
    }

    /// Spoiled recordings, tool tables, parameter files and manifests.
    fn tables(&mut self) {
        let recording = b"part,qw,qx,qy,qz,tx,ty,tz\ncube,1,0,0,0,10,0,0\ncube,1,0,0,0,20,0,0\n";
        let tools = b"T1 P1 D6.0 Z50.0 ; mill\nT2 P2 D10.5 Z80.25\n";
        let parameters = b"5221 10.5\n5222 -20\n5223 0\n";
        let scene = MESH_SCENE.replace("mesh = \"MESH\"", "shape = { kind = \"sphere\", radius_mm = 20 }");
        let scene = format!("{scene}[recorded]\nfile = \"poses.csv\"\n");
        let program = self.write("tables.ngc", b"G0 X1\nM2");
        for spoil in 0..SPOILED {
            let name = format!("recording-{spoil}");
            let bytes = spoiled(recording, spoil, &mut self.random);
            self.write(&format!("{name}/poses.csv"), &bytes);
            self.scene_of(&name, &scene, "poses.csv", &[0, 2]);
            for (option, good) in [("--tool-table", &tools[..]), ("--var", parameters)] {
                let name = format!("table{option}-{spoil}");
                let bytes = spoiled(good, spoil, &mut self.random);
                let path = self.write(&name, &bytes);
                self.add(name.clone(), &["program", "gcode", &program, option, &path], &name, &[0, 2]);
            }
            for (number, good) in seeds("manifest").iter().enumerate() {
                let name = format!("manifest-{number}-{spoil}");
                let bytes = spoiled(good, spoil, &mut self.random);
                self.write(&format!("{name}/manifest.json"), &bytes);
                let run = self.folder.join(&name).to_string_lossy().into_owned();
                self.add(name.clone(), &["stage", "analyze", "--out", &run], &name, &[2]);
            }
        }
        // A run with a timing of a launch that it has not.
        let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/reference");
        for launch in ["4294967295", "1000000"] {
            let name = format!("launch-{launch}");
            for file in ["manifest.json", "cases.csv", "poses.csv.gz"] {
                self.write(&format!("{name}/{file}"), &fs::read(reference.join(file)).unwrap());
            }
            let row = format!("lathe-toolpost,aabb@vertex-mean/own/1,0,{launch},0,0,1,205475\n");
            let timings = format!("scene,case,binary,launch,block,chunk,passes,ns\n{row}");
            self.write(&format!("{name}/timings.csv"), timings.as_bytes());
            let run = self.folder.join(&name).to_string_lossy().into_owned();
            let analyze = ["stage", "analyze", "--accept-changed-rows", "--out", &run];
            self.add(name, &analyze, "timings.csv:2: the run has fewer launches", &[2]);
        }
        let far = "part,qw,qx,qy,qz,tx,ty,tz\ncube,1,0,0,0,1e12,0,0\n";
        self.write("recording-far/poses.csv", far.as_bytes());
        self.scene_of("recording-far", &scene, "poses.csv:2:2: 1000000000000 is beyond 1e9 mm", &[2]);
    }

    /// Spoiled robots, robots with numbers that cannot be meant, and robots that never end.
    #[cfg(feature = "urdf")]
    fn robots(&mut self) {
        let scene = "title = \"a robot\"\n[machine]\nurdf = \"robot.urdf\"\n";
        let mut robots: Vec<Vec<u8>> =
            (0..4 * SPOILED).map(|spoil| spoiled(URDF.as_bytes(), spoil % SPOILED, &mut self.random)).collect();
        for (place, _) in URDF.match_indices(|c: char| c.is_ascii_digit()) {
            for number in ["1e300", "nan", "-1e-320"] {
                robots.push(format!("{}{number}{}", &URDF[..place], &URDF[place + 1..]).into_bytes());
            }
        }
        robots.push(URDF.replace("<parent link=\"bed\"/>", "<parent link=\"hand\"/>").into_bytes());
        robots.push(format!("{}{}", "<a>".repeat(200_000), URDF).into_bytes());
        let entities: String = (1..30).map(|i| format!("<!ENTITY e{i} \"&e{};&e{};\">", i - 1, i - 1)).collect();
        robots.push(
            format!("<!DOCTYPE robot [<!ENTITY e0 \"laugh\">{entities}]>{}", URDF.replace("small", "&e29;"))
                .into_bytes(),
        );
        for (number, robot) in robots.iter().enumerate() {
            let name = format!("robot-{number}");
            self.write(&format!("{name}/robot.urdf"), robot);
            self.scene_of(&name, scene, &name, &[0, 2]);
        }
    }

    fn steps(&mut self) {
        for step in ["1e-300", "1e-9", "0", "-1", "nan", "inf"] {
            let option = format!("--step={step}");
            self.add(format!("path-{step}"), &["program", "path", "freeform-5axis", &option], "", &[0, 2]);
        }
    }
}

#[test]
fn hostile_inputs_end_in_a_message() {
    let folder = tempfile::tempdir().unwrap();
    let mut attacks = Attacks { folder: folder.path().to_owned(), random: Pcg64::seed_from_u64(SEED), all: Vec::new() };
    attacks.meshes();
    attacks.programs();
    attacks.scenes();
    attacks.devices();
    attacks.tables();
    #[cfg(feature = "urdf")]
    attacks.robots();
    attacks.steps();
    let all = attacks.all;
    assert!(all.len() >= 600, "{}", all.len());
    let failures: Vec<String> = all
        .par_iter()
        .filter_map(|attack| run(attack).err().map(|error| format!("{}: {error}", attack.name)))
        .collect();
    let shown = failures.iter().take(30).cloned().collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} of {} inputs:\n{shown}", failures.len(), all.len());
}
