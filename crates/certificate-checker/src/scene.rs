//! What the certificate states, compared with the files of the scene, read anew.

use crate::interval::{I, Pose, V, ZERO, dot, minus, times, unit};
use crate::machine::Link;
use crate::mesh::{is_closed, on_grid};
use crate::read::{DEGREE, ROTARY, axis};
use crate::{Checked, Part, Stated};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::ops::Neg;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The value of a missing key.
static NOTHING: Value = Value::Boolean(false);

/// Rounding differences that are allowed in an entry of a rotation, and in a length, mm.
const TURNED: f64 = 1e-12;
const MOVED_MM: f64 = 1e-9;

/// Largest file of a scene, bytes.
const LARGEST_FILE: u64 = 1 << 30;

/// Compares the certificate with the files, and notes what no file was compared with.
pub fn compare(stated: &Stated, [scene, program]: [Option<&Path>; 2], notes: &mut Vec<String>) -> Checked {
    let mut trust = |what: &str| notes.push(format!("by the certificate's word: {what}"));
    trust("the moves of each line, which are what its interpreter made of the program");
    if let Some(own) = program {
        let called = stated.called.iter().map(|(name, hash)| (own.with_file_name(name), hash));
        for (file, hash) in called.chain([(own.to_owned(), &stated.program.1)]) {
            if blake3::hash(&bytes(&file)?).to_hex().as_str() != hash {
                return Err(format!("{} is not the program of the certificate, or what it calls", file.display()));
            }
        }
    } else {
        trust(&format!("that its program is `{}`", stated.program.0));
    }
    let Some(scene) = scene else {
        trust("links, joints, parts and meshes (no --scene)");
        return Ok(());
    };
    let own = own_file(scene);
    let folder = own.parent().unwrap_or(&own);
    Files { stated, folder }.compare(&own, &mut trust)
}

/// The own file of a scene, which is named by its folder or by that file.
pub fn own_file(scene: &Path) -> PathBuf {
    let named = Path::new(".").join(scene);
    if named.is_file() { named } else { named.join("scene.toml") }
}

/// A file's content. What the system says of its length need not be so.
fn bytes(file: &Path) -> Checked<Vec<u8>> {
    let is_plain = file.metadata().is_ok_and(|found| found.is_file() && found.len() <= LARGEST_FILE);
    let mut content = Vec::new();
    let read = |file: File| file.take(LARGEST_FILE + 1).read_to_end(&mut content);
    let is_read = is_plain && File::open(file).and_then(read).is_ok_and(|length| length as u64 <= LARGEST_FILE);
    is_read
        .then_some(content)
        .ok_or_else(|| format!("{}: no file of up to {LARGEST_FILE} bytes can be read there", file.display()))
}

/// A file of text in UTF-8, whatever its byte-order mark says.
fn in_utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)),
    };
    let wide = bytes[2..].as_chunks::<2>().0.iter().map(|pair| unit(*pair));
    Cow::Owned(String::from_utf16_lossy(&wide.collect::<Vec<_>>()).into_bytes())
}

/// The folder of a scene, and the statements of the certificate.
struct Files<'a> {
    stated: &'a Stated,
    folder: &'a Path,
}

impl Files<'_> {
    /// The content of a file that the scene names: that of a file of the certificate, by its last name and its hash.
    fn bytes(&self, file: &Path) -> Checked<Vec<u8>> {
        let content = bytes(&self.folder.join(file))?;
        let hash = blake3::hash(&content).to_hex();
        let is_it = |input: &(String, String)| Path::new(&input.0).file_name() == file.file_name() && *input.1 == *hash;
        let is_there = self.stated.inputs.iter().any(is_it);
        is_there
            .then_some(content)
            .ok_or_else(|| format!("{} is not among the files of the certificate", file.display()))
    }

    fn table(&self, file: &Path) -> Checked<Value> {
        let (name, bytes) = (file.display(), self.bytes(file)?);
        let bytes = in_utf8(&bytes);
        let text = std::str::from_utf8(&bytes).map_err(|_| format!("{name} is not text"))?;
        // A lone CR ends a line as well.
        text.replace('\r', "\n").parse::<Table>().map(Value::Table).map_err(|error| format!("{name}: {error}"))
    }

    fn compare(&self, file: &Path, trust: &mut impl FnMut(&str)) -> Checked {
        let scene = self.table(Path::new(file.file_name().unwrap_or_default()))?;
        let [own, program, check] = ["machine", "program", "check"].map(|key| value(&scene, key));
        if own.get("urdf").is_some() {
            return Err("a machine in URDF is not compared; leave --scene out".to_owned());
        }
        // Meshes of a machine's own file are found from its folder.
        let file = Path::new(text(own, "file"));
        let (machine, base) = match file.parent() {
            Some(base) => (self.table(file)?, base),
            None => (NOTHING.clone(), file),
        };
        let links = array(if file.parent().is_none() { own } else { &machine }, "links");
        if links.len() + 1 != self.stated.machine.links.len() {
            return Err("the machine has another number of links".to_owned());
        }
        links.iter().try_for_each(|link| self.link(link))?;
        let mut others: BTreeSet<&str> = self.stated.parts.iter().map(|part| part.name.as_str()).collect();
        for (file, base) in [(&scene, Path::new("")), (own, Path::new("")), (&machine, base)] {
            for part in array(file, "parts") {
                self.part(part, base, trust)?;
                others.remove(text(part, "name"));
            }
        }
        others.iter().for_each(|name| trust(&format!("part `{name}`, which no [[parts]] describes")));
        array(program, "tools").iter().try_for_each(|tool| self.tool(tool, trust))?;
        for [a, b, why] in &self.stated.skipped {
            let is_pair = |pair: &Value| {
                let names: Vec<_> = pair.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
                names == [a, b] || names == [b, a]
            };
            let (file, key) = match why.as_str() {
                "ignored" => (check, "ignore"),
                "allowed" => (check, "allow"),
                _ => (&scene, "pairs"),
            };
            // The scene names what it leaves out; neighbours that it names are examined.
            if array(file, key).iter().any(is_pair) == (why == "neighbours") {
                return Err(format!("by the scene, {a}:{b} is not {why}"));
            }
        }
        self.tip(program.get("tool_centre_point"))
    }

    /// The link that a key names; without it, the world, and by `world` where no link has that name.
    fn named(&self, file: &Value, key: &str) -> Checked<usize> {
        let is_world = |name: &str| name.is_empty() || name == "world" && self.stated.link(name).is_err();
        self.stated.link(Some(text(file, key)).filter(|name| !is_world(name)).unwrap_or("-"))
    }

    fn link(&self, file: &Value) -> Checked {
        let Link { name, parent, pose, joint } = &self.stated.machine.links[self.stated.link(text(file, "name"))?];
        if *parent != self.named(file, "parent")? || !is_near(pose, &placement(file)) {
            return Err(format!("link `{name}`: the file has another parent or place"));
        }
        let is_same = match (file.get("joint"), joint) {
            (Some(file), Some(joint)) => {
                let axis = axis(&text(file, "axis").to_uppercase())?;
                let turns = ROTARY.contains(&axis) || file.get("turns").and_then(Value::as_bool).unwrap_or(false);
                [axis, usize::from(turns)] == [joint.axis, usize::from(joint.turns.is_some())]
                    && near(&unit(&vector(file, "direction")), &joint.direction, TURNED)
                    && joint.turns.is_none_or(|point| near(&vector(file, "point_mm"), &point, MOVED_MM))
            }
            (file, joint) => file.is_none() && joint.is_none(),
        };
        is_same.then_some(()).ok_or(format!("link `{name}`: the file has another joint"))
    }

    /// A tool with measures has parts, whose axis goes through the gauge point and the tip, and which begin at the tip.
    fn tool(&self, file: &Value, trust: &mut impl FnMut(&str)) -> Checked {
        if file.get("flute_mm").is_none() {
            return Ok(());
        }
        let id = file.get("number").and_then(Value::as_integer).unwrap_or_default();
        let tip = self.stated.machine.tip.as_ref().ok_or("a tool with measures without a tool_centre_point")?;
        let holder = array(file, "holder");
        let holder_mm: f64 = holder.iter().filter_map(|step| number(value(step, "length_mm"))).sum();
        let [length, stickout] = ["length_mm", "stickout_mm"].map(|key| number(value(file, key)));
        let mut length = length.or(stickout.map(|stickout| stickout + holder_mm)).map(I::of);
        for role in ["cutter", "shank", "holder"] {
            let name = format!("tool-{id}-{role}");
            let is_it = |part: &&Part| part.name == name && part.role == role && part.tool.map(i64::from) == Some(id);
            let Some(Part { link, pose, .. }) = self.stated.parts.iter().find(is_it) else {
                match role {
                    "shank" => trust(&format!("that there is no `{name}`")),
                    "holder" if holder.is_empty() => {}
                    _ => return Err(format!("part `{name}` is missing")),
                }
                continue;
            };
            let way = minus(&pose.t, &tip.gauge);
            let length = length.get_or_insert_with(|| {
                trust(&format!("the length of tool {id}"));
                dot(&way, &tip.direction)
            });
            let is_there = *link == tip.tool && near(&way, &times(&tip.direction, *length), MOVED_MM);
            if !is_there || !near(&pose.r[2], &tip.direction.map(Neg::neg), TURNED) {
                return Err(format!("part `{name}` is not where the tool is"));
            }
        }
        Ok(())
    }

    fn part(&self, file: &Value, base: &Path, trust: &mut impl FnMut(&str)) -> Checked {
        let Part { name, link, role, tool, pose, mesh } = &self.stated.parts[self.stated.part(text(file, "name"))?];
        let own_role = Some(text(file, "role")).filter(|role| !role.is_empty()).unwrap_or("machine");
        let own_tool = file.get("tool").and_then(Value::as_integer);
        let is_same = *link == self.named(file, "link")? && role == own_role && tool.map(i64::from) == own_tool;
        if !is_same || !is_near(pose, &placement(file)) {
            return Err(format!("part `{name}`: the file has another link, role, tool or place"));
        }
        let path = text(file, "mesh");
        let content = if path.is_empty() { Vec::new() } else { self.bytes(&base.join(path))? };
        if !path.to_lowercase().ends_with(".stl") || file.get("weld_mm").is_some() {
            trust(&format!("the triangles of `{name}`"));
            return Ok(());
        }
        let units = [("cm", 10.0), ("m", 1000.0), ("inch", 25.4)];
        let unit = units.into_iter().find(|unit| unit.0 == text(file, "unit")).map_or(1.0, |unit| unit.1);
        // Triangles without an area are dropped, and doubled ones behind the first. Those that wind against it may stay where the mesh is not closed without them.
        let least = |[a, b, c]: [[i64; 3]; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or_default();
        let (mut first, mut both) = (BTreeMap::new(), BTreeSet::new());
        for face in stl(&content, unit).ok_or(format!("{path} is not an STL file"))? {
            let corners = BTreeSet::from(face);
            if corners.len() == 3 {
                first.entry(corners).or_insert(least(face));
                both.insert(least(face));
            }
        }
        let mut own: Vec<_> = mesh.faces.iter().map(|&face| least(face)).collect();
        let mut once: Vec<_> = first.into_values().collect();
        own.sort_unstable();
        once.sort_unstable();
        let is_same = own == once || own.iter().eq(&both) && !is_closed(&once);
        is_same.then_some(()).ok_or(format!("part `{name}`: {path} has other triangles"))
    }

    fn tip(&self, file: Option<&Value>) -> Checked {
        let is_same = match (file, &self.stated.machine.tip) {
            (Some(file), Some(tip)) => {
                let down = [ZERO, ZERO, I::of(-1.0)];
                let given = if file.get("direction").is_some() { unit(&vector(file, "direction")) } else { down };
                [self.named(file, "tool_link")?, self.named(file, "work_link")?] == [tip.tool, tip.work]
                    && near(&vector(file, "gauge_mm"), &tip.gauge, MOVED_MM)
                    && near(&given, &tip.direction, TURNED)
            }
            (file, tip) => file.is_none() && tip.is_none(),
        };
        is_same.then_some(()).ok_or("another tool_centre_point".to_owned())
    }
}

fn value<'a>(file: &'a Value, key: &str) -> &'a Value {
    file.get(key).unwrap_or(&NOTHING)
}

fn array<'a>(file: &'a Value, key: &str) -> &'a [Value] {
    value(file, key).as_array().map_or(&[], Vec::as_slice)
}

fn text<'a>(file: &'a Value, key: &str) -> &'a str {
    value(file, key).as_str().unwrap_or_default()
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|x| x as f64))
}

fn vector(file: &Value, key: &str) -> V {
    [0, 1, 2].map(|i| array(file, key).get(i).and_then(number).map_or(ZERO, I::of))
}

/// `at`: turned about X, then Y, then Z, then moved.
fn placement(file: &Value) -> Pose {
    let at = value(file, "at");
    let [roll, pitch, yaw] = vector(at, "rpy_deg").map(|x| x * DEGREE);
    let [x, y, z] = Pose::IDENTITY.r;
    let turned = Pose::about(&z, yaw).after(&Pose::about(&y, pitch)).after(&Pose::about(&x, roll));
    Pose { t: vector(at, "xyz_mm"), ..turned }
}

fn near(a: &V, b: &V, by: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (*a - *b).most() <= by)
}

fn is_near(a: &Pose, b: &Pose) -> bool {
    near(&a.t, &b.t, MOVED_MM) && a.r.iter().zip(&b.r).all(|(a, b)| near(a, b, TURNED))
}

/// Triangles of an STL file, binary or text, on the grid.
fn stl(bytes: &[u8], unit_mm: f64) -> Option<Vec<[[i64; 3]; 3]>> {
    let count = bytes.get(80..).and_then(<[u8]>::first_chunk).map(|count| u32::from_le_bytes(*count) as usize);
    // In text as well, numbers of 32 bits.
    let numbers: Vec<f32> = if count.is_some_and(|count| bytes.len() == 84 + 50 * count) {
        let float = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes);
        bytes[84..].as_chunks::<50>().0.iter().flat_map(|face| face[12..48].as_chunks().0).map(float).collect()
    } else {
        let text = String::from_utf8_lossy(&in_utf8(bytes)).to_ascii_lowercase();
        let corners = text.split(['\n', '\r']).filter_map(|line| line.trim_start().strip_prefix("vertex"));
        corners.flat_map(|line| line.split_whitespace().map(|word| word.parse().unwrap_or(f32::NAN))).collect()
    };
    let is_whole = !numbers.is_empty() && numbers.len().is_multiple_of(9) && numbers.iter().all(|x| x.is_finite());
    let corner = |p: &[f32; 3]| on_grid(p.map(|x| f64::from(x) * unit_mm));
    let corners: Vec<_> = numbers.as_chunks().0.iter().map(corner).collect();
    is_whole.then(|| corners.as_chunks().0.to_vec())
}
