//! What the certificate states, compared with the files of the scene, read anew.

use crate::interval::{I, Pose, V, ZERO, norm};
use crate::mesh::{canonical, on_grid};
use crate::read::{DEGREE, axis};
use crate::{Part, Stated};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use toml::{Table, Value};

/// Rounding differences that are allowed in an entry of a rotation, and in a length, mm.
const TURNED: f64 = 1e-12;
const MOVED_MM: f64 = 1e-9;

type Checked<T = ()> = Result<T, String>;

/// Compares the certificate with the files, and notes what no file was compared with.
pub fn compare(stated: &Stated, scene: Option<&Path>, program: Option<&Path>, notes: &mut Vec<String>) -> Checked {
    notes.push(
        "by the certificate's word: the moves of each line, which are what its interpreter made of the program"
            .to_owned(),
    );
    match program {
        Some(file) => {
            let bytes = bytes(file)?;
            let text = String::from_utf8_lossy(&bytes);
            let lines = text.lines().collect::<Vec<_>>().join("\n");
            if blake3::hash(lines.as_bytes()).to_hex().as_str() != stated.program.1 {
                return Err(format!("{} is not the program of the certificate", file.display()));
            }
        }
        None => notes.push(format!("by the certificate's word: that its program is `{}`", stated.program.0)),
    }
    match scene {
        Some(folder) => Files::read(stated, folder)?.compare(notes),
        None => {
            notes.push("by the certificate's word: links, joints, parts and meshes (no --scene)".to_owned());
            Ok(())
        }
    }
}

fn canonical_path(file: &Path) -> Checked<PathBuf> {
    file.canonicalize().map_err(|error| format!("{}: {error}", file.display()))
}

fn bytes(file: &Path) -> Checked<Vec<u8>> {
    std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))
}

/// A scene's files, as they were read to compare their hashes, and the statements of the certificate.
struct Files<'a> {
    stated: &'a Stated,
    folder: PathBuf,
    contents: BTreeMap<PathBuf, Vec<u8>>,
}

impl<'a> Files<'a> {
    fn read(stated: &'a Stated, folder: &Path) -> Checked<Self> {
        let folder = canonical_path(folder)?;
        let mut contents = BTreeMap::new();
        for (file, hash) in &stated.inputs {
            if !Path::new(file).components().all(|part| matches!(part, Component::Normal(_))) {
                return Err(format!("`{file}` leads out of the scenes' folder"));
            }
            let path = canonical_path(&folder.parent().unwrap_or(&folder).join(file))?;
            let bytes = bytes(&path)?;
            if blake3::hash(&bytes).to_hex().as_str() != hash {
                return Err(format!("{} is not the file of the certificate", path.display()));
            }
            contents.insert(path, bytes);
        }
        Ok(Self { stated, folder, contents })
    }

    fn bytes(&self, file: &str) -> Checked<&[u8]> {
        let content = self.contents.get(&canonical_path(&self.folder.join(file))?);
        content.map(Vec::as_slice).ok_or_else(|| format!("{file} is not among the files of the certificate"))
    }

    fn table(&self, file: &str) -> Checked<Table> {
        let text = std::str::from_utf8(self.bytes(file)?).map_err(|_| format!("{file} is not text"))?;
        text.parse().map_err(|error| format!("{file}: {error}"))
    }

    fn compare(&self, notes: &mut Vec<String>) -> Checked {
        let scene = self.table("scene.toml")?;
        let mut machine = scene.get("machine").and_then(Value::as_table).cloned().unwrap_or_default();
        if machine.contains_key("urdf") {
            return Err("a machine in URDF is not compared; leave --scene out".to_owned());
        }
        // Meshes of a machine's own file are found from its folder.
        let (own, mut base) = (machine.clone(), PathBuf::new());
        if let Some(file) = machine.get("file").and_then(Value::as_str) {
            base = Path::new(file).parent().map_or(base, Path::to_owned);
            machine = self.table(file)?;
        }
        let links = array(&machine, "links");
        if links.len() != self.stated.machine.links.len() {
            return Err("the machine has another number of links".to_owned());
        }
        links.iter().try_for_each(|link| self.link(link))?;
        let mut parts: Vec<(&Value, &Path)> =
            parts_of(&machine, &base).chain(parts_of(&scene, Path::new(""))).collect();
        if own != machine {
            parts.extend(parts_of(&own, Path::new("")));
        }
        let named: BTreeSet<&str> = parts.iter().map(|(part, _)| text(part, "name")).collect();
        parts.iter().try_for_each(|(part, base)| self.part(part, base, notes))?;
        let program = scene.get("program").and_then(Value::as_table).cloned().unwrap_or_default();
        array(&program, "tools").iter().try_for_each(|tool| self.tool(tool, notes))?;
        let made = self.stated.parts.iter().filter(|part| !named.contains(part.name.as_str()));
        notes.extend(
            made.map(|part| format!("by the certificate's word: part `{}`, which no [[parts]] describes", part.name)),
        );
        let check = scene.get("check").and_then(Value::as_table).cloned().unwrap_or_default();
        for [a, b, why] in &self.stated.skipped {
            let key = match why.as_str() {
                "ignored" => "ignore",
                "allowed" => "allow",
                _ => continue,
            };
            let is_pair = |pair: &Value| {
                let names: Vec<&str> = pair.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
                names == [a, b] || names == [b, a]
            };
            if !array(&check, key).iter().any(is_pair) {
                return Err(format!("the scene does not say that {a}:{b} is {why}"));
            }
        }
        self.tip(program.get("tool_centre_point"))
    }

    fn link(&self, file: &Value) -> Checked {
        let name = text(file, "name");
        let link = &self.stated.machine.links[self.stated.link(name)?];
        let parent = link.parent.map_or("", |parent| &self.stated.machine.links[parent].name);
        let differs = |what: &str| Err(format!("link `{name}`: the file has another {what}"));
        if parent != text(file, "parent") || !is_near(&link.pose, &placement(file)) {
            return differs("parent or place");
        }
        let (joint, found) = (file.get("joint"), &link.joint);
        let (Some(joint), Some(found)) = (joint, found) else {
            return if joint.is_none() && found.is_none() { Ok(()) } else { differs("joint") };
        };
        let axis = axis(&text(joint, "axis").to_uppercase())?;
        let turns = (3..6).contains(&axis) || joint.get("turns").and_then(Value::as_bool).unwrap_or(false);
        let direction = vector(joint, "direction");
        let length = norm(&direction);
        let direction = direction.map(|x| x.over(length));
        let is_same = axis == found.axis
            && turns == found.turns.is_some()
            && near(&direction, &found.direction, TURNED)
            && found.turns.is_none_or(|point| near(&vector(joint, "point_mm"), &point, MOVED_MM));
        if is_same { Ok(()) } else { differs("joint") }
    }

    /// A tool with measures has parts.
    fn tool(&self, file: &Value, notes: &mut Vec<String>) -> Checked {
        let number = file.get("number").and_then(Value::as_integer);
        let has_holder = file.get("holder").and_then(Value::as_array).is_some_and(|steps| !steps.is_empty());
        for role in ["cutter", "shank", "holder"].into_iter().filter(|_| file.get("flute_mm").is_some()) {
            let name = format!("tool-{}-{role}", number.unwrap_or_default());
            let is_it = |part: &Part| part.name == name && part.role == role && part.tool.map(i64::from) == number;
            match self.stated.parts.iter().any(is_it) {
                false if role == "cutter" || role == "holder" && has_holder => {
                    return Err(format!("part `{name}` is missing"));
                }
                false if role == "shank" => notes.push(format!("by the certificate's word: that there is no `{name}`")),
                _ => {}
            }
        }
        Ok(())
    }

    fn part(&self, file: &Value, base: &Path, notes: &mut Vec<String>) -> Checked {
        let name = text(file, "name");
        let part =
            self.stated.parts.iter().find(|part| part.name == name).ok_or(format!("part `{name}` is missing"))?;
        let link = part.link.map_or("", |link| &self.stated.machine.links[link].name);
        let role = Some(text(file, "role")).filter(|role| !role.is_empty()).unwrap_or("machine");
        let tool = file.get("tool").and_then(Value::as_integer);
        let is_same = link == text(file, "link") && role == part.role && tool == part.tool.map(i64::from);
        if !is_same || !is_near(&part.pose, &placement(file)) {
            return Err(format!("part `{name}`: the file has another link, role, tool or place"));
        }
        let mesh = text(file, "mesh");
        let path = base.join(mesh).to_string_lossy().into_owned();
        let content = if mesh.is_empty() { &[] } else { self.bytes(&path)? };
        if !mesh.to_lowercase().ends_with(".stl") || file.get("weld_mm").is_some() {
            notes.push(format!("by the certificate's word: the triangles of `{name}`"));
            return Ok(());
        }
        let unit = match text(file, "unit") {
            "cm" => 10.0,
            "m" => 1000.0,
            "inch" => 25.4,
            _ => 1.0,
        };
        let read = stl(content, unit).ok_or(format!("{mesh} is not an STL file"))?;
        let is_area = |[a, b, c]: &[[i64; 3]; 3]| a != b && b != c && c != a;
        let sorted = |triangle: &[[i64; 3]; 3]| {
            let mut all = *triangle;
            all.sort_unstable();
            all
        };
        // Doubled triangles are dropped, whichever way they wind.
        let found: BTreeSet<_> = read.iter().filter(|t| is_area(t)).map(sorted).collect();
        let own = part.mesh.triangles();
        let wound: BTreeSet<_> = read.into_iter().map(canonical).collect();
        let is_same = own.iter().map(sorted).collect::<BTreeSet<_>>() == found && own.iter().all(|t| wound.contains(t));
        if is_same { Ok(()) } else { Err(format!("part `{name}`: {mesh} has other triangles")) }
    }

    fn tip(&self, file: Option<&Value>) -> Checked {
        let (Some(file), Some(tip)) = (file, &self.stated.machine.tip) else {
            let is_same = file.is_none() && self.stated.machine.tip.is_none();
            return if is_same { Ok(()) } else { Err("another tool_centre_point".to_owned()) };
        };
        let name = |link: Option<usize>| link.map_or("world", |link| self.stated.machine.links[link].name.as_str());
        let named = |key: &str| Some(text(file, key)).filter(|name| !name.is_empty()).unwrap_or("world");
        let given = if file.get("direction").is_some() { vector(file, "direction") } else { [ZERO, ZERO, I::of(-1.0)] };
        let length = norm(&given);
        let is_same = name(tip.tool) == named("tool_link")
            && name(tip.work) == named("work_link")
            && near(&vector(file, "gauge_mm"), &tip.gauge, MOVED_MM)
            && near(&given.map(|x| x.over(length)), &tip.direction, TURNED);
        if is_same { Ok(()) } else { Err("another tool_centre_point".to_owned()) }
    }
}

fn array<'a>(table: &'a Table, key: &str) -> &'a [Value] {
    table.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn parts_of<'a>(table: &'a Table, base: &'a Path) -> impl Iterator<Item = (&'a Value, &'a Path)> {
    array(table, "parts").iter().map(move |part| (part, base))
}

fn text<'a>(file: &'a Value, key: &str) -> &'a str {
    file.get(key).and_then(Value::as_str).unwrap_or_default()
}

fn vector(file: &Value, key: &str) -> V {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|x| x as f64));
    let numbers: Vec<f64> = file.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(number).collect();
    [0, 1, 2].map(|i| I::of(numbers.get(i).copied().unwrap_or(0.0)))
}

/// `at`: turned about X, then Y, then Z, then moved.
fn placement(file: &Value) -> Pose {
    let Some(at) = file.get("at") else { return Pose::IDENTITY };
    let [roll, pitch, yaw] = vector(at, "rpy_deg").map(|x| x * DEGREE);
    let about = |i: usize, angle: I| Pose::about(&[0, 1, 2].map(|k| I::of(f64::from(u8::from(k == i)))), angle);
    Pose { t: vector(at, "xyz_mm"), ..about(2, yaw).after(&about(1, pitch)).after(&about(0, roll)) }
}

fn near(a: &V, b: &V, by: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (*a - *b).most() <= by)
}

fn is_near(a: &Pose, b: &Pose) -> bool {
    near(&a.t, &b.t, MOVED_MM) && a.r.iter().zip(&b.r).all(|(a, b)| near(a, b, TURNED))
}

/// Triangles of an STL file, binary or text, on the grid.
fn stl(bytes: &[u8], unit_mm: f64) -> Option<Vec<[[i64; 3]; 3]>> {
    let count = bytes.get(80..84).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize);
    let numbers: Vec<f64> = if count.is_some_and(|count| bytes.len() == 84 + 50 * count) {
        let float = |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        bytes[84..].chunks_exact(50).flat_map(|triangle| triangle[12..48].chunks_exact(4).map(float)).collect()
    } else {
        let text = std::str::from_utf8(bytes).ok()?;
        let corners = text.lines().filter_map(|line| line.trim_start().strip_prefix("vertex"));
        // As the format has it, numbers of 32 bits.
        corners
            .flat_map(|line| line.split_whitespace().map(|word| word.parse::<f32>().map_or(f64::NAN, f64::from)))
            .collect()
    };
    if numbers.is_empty() || !numbers.len().is_multiple_of(9) || !numbers.iter().all(|x| x.is_finite()) {
        return None;
    }
    let corner = |p: &[f64]| on_grid([p[0] * unit_mm, p[1] * unit_mm, p[2] * unit_mm]);
    Some(numbers.chunks_exact(9).map(|t| [corner(&t[..3]), corner(&t[3..6]), corner(&t[6..])]).collect())
}
