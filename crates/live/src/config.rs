//! The TOML that says how to reach a control, what its axes promise, and what to do with the verdict.
//!
//! Reading order: [`Config`] (what is read), [`Node`] (how a node is named), the presets, `File` (the TOML form), the errors.

use crate::judge::{Dynamics, Rule, is_driven};
use bvbench::machine::Machine;
use bvbench::scene::Scene;
use rs274::Axis;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// Largest configuration that is read, bytes.
const LARGEST: u64 = 1 << 20;

/// A configuration, checked as far as it can be without its scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The file it came from.
    pub file: PathBuf,
    /// Name or path of the scene.
    pub scene: String,
    /// Id of the variant; `None` is the fastest.
    pub variant: Option<String>,
    /// Endpoint of the control, `opc.tcp://host:port/path`.
    pub endpoint: String,
    /// Cycle of the control, s.
    pub cycle_s: f64,
    /// Time from the source time of a sample within which a hold takes effect, s.
    pub deadline_s: f64,
    /// Age beyond which the last sample is stale, s.
    pub stale_s: f64,
    /// Largest error of a source time, s.
    pub source_jitter_s: f64,
    /// Guaranteed clearance below which the verdict is near, mm.
    pub near_mm: f64,
    /// The axes, by letter.
    pub axes: BTreeMap<char, AxisConfig>,
    /// The other nodes.
    pub nodes: Nodes,
    /// When a hold that contact called for is released.
    pub release: Release,
    /// Tool in the spindle when no node says it; `None` when the file does not say it either.
    pub tool: Option<u32>,
    /// How the connection is secured.
    pub security: Security,
    /// Namespaces by the alias that paths use.
    pub namespaces: BTreeMap<String, String>,
}

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisConfig {
    /// Where its position is read.
    pub node: Node,
    /// Factor from the value of the node to mm or radians.
    pub factor: f64,
    /// Largest acceleration, mm/s² or radians/s².
    pub acceleration: f64,
    /// Deceleration of a hold, mm/s² or radians/s².
    pub deceleration: f64,
    /// Resolution of the position, mm or radians.
    pub resolution: f64,
    line: usize,
}

/// Nodes besides the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// Takes the number of the verdict, with the source time of the sample it is about.
    pub verdict: Node,
    /// Takes true for a hold.
    pub hold: Hold,
    /// Takes a number that grows with every verdict, for controls that cannot see times.
    pub heartbeat: Option<Node>,
    /// Line of the program.
    pub line: Option<Node>,
    /// Tool in the spindle.
    pub tool: Option<Node>,
}

/// How a hold is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Hold {
    /// By writing true to a node, and false to release it.
    Node(Node),
    /// By calling a method of an object with true or false.
    Method {
        /// The object.
        object: Node,
        /// The method.
        method: Node,
    },
}

/// When a hold that contact called for is released. Holds for any other cause are released as soon as the cause is gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Release {
    /// Not before the watch is started again.
    Latched,
    /// When the look-ahead has been clear for this long, s.
    After(f64),
}

/// How the connection is secured.
#[derive(Clone, Debug, PartialEq)]
pub struct Security {
    /// Policy, as `Basic256Sha256`; `None` for none.
    pub policy: String,
    /// Mode: `None`, `Sign` or `SignAndEncrypt`.
    pub mode: Mode,
    /// Who asks.
    pub user: User,
    /// Folder with `own/cert.der`, `private/private.pem`, `trusted/` (the trust list) and `rejected/`.
    pub pki: PathBuf,
    /// Makes a certificate for this side when the folder has none.
    pub creates_certificate: bool,
}

/// Mode of a secure channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Mode {
    /// Neither signed nor encrypted.
    #[default]
    None,
    /// Signed.
    Sign,
    /// Signed and encrypted.
    SignAndEncrypt,
}

/// Who asks.
#[derive(Clone, PartialEq)]
pub enum User {
    /// Nobody in particular.
    Anonymous,
    /// A name with a password.
    Name {
        /// The name.
        name: String,
        /// The password.
        password: String,
    },
    /// Whoever holds a certificate.
    Certificate {
        /// The certificate, DER.
        certificate: PathBuf,
        /// Its private key, PEM.
        key: PathBuf,
    },
}

impl std::fmt::Debug for User {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Anonymous => write!(f, "anonymous"),
            Self::Name { name, .. } => write!(f, "user {name}"),
            Self::Certificate { certificate, .. } => write!(f, "holder of {}", certificate.display()),
        }
    }
}

/// How a node is named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Node {
    /// By its id, as `ns=2;s=/Channel/MachineAxis/actToolBasePos[u1,1]`.
    Id(String),
    /// By browse names from the Objects folder, each with the alias of its namespace: `/cnc:CncInterface/cnc:CncAxisList`.
    Path(Vec<(String, String)>),
}

impl Node {
    /// Reads either form.
    ///
    /// # Errors
    /// A message when the text is neither a node id nor a path.
    pub fn parse(text: &str) -> Result<Self, String> {
        let Some(path) = text.strip_prefix('/') else {
            let is_id = text.starts_with("ns=") || ["i=", "s=", "g=", "b="].iter().any(|kind| text.starts_with(kind));
            let advice = "is neither a node id (`ns=2;s=name`) nor a path (`/alias:Name/alias:Name`)";
            return if is_id { Ok(Self::Id(text.to_owned())) } else { Err(format!("`{text}` {advice}")) };
        };
        let step = |step: &str| {
            let (alias, name) = step.split_once(':')?;
            (!alias.is_empty() && !name.is_empty()).then(|| (alias.to_owned(), name.to_owned()))
        };
        let steps = path.split('/').map(|text| step(text).ok_or(text));
        steps
            .collect::<Result<_, _>>()
            .map(Self::Path)
            .map_err(|step| format!("`{step}` is not alias:Name in `{text}`"))
    }
}

impl std::fmt::Display for Node {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Id(id) => write!(f, "{id}"),
            Self::Path(steps) => steps.iter().try_for_each(|(alias, name)| write!(f, "/{alias}:{name}")),
        }
    }
}

/// Default nodes of a kind of control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// SINUMERIK Operate's OPC UA server: machine axes of channel 1, numbered from 1 in the order X Y Z A B C U V W of those that the file
    /// has; verdict and hold in R parameters 900 and 901, which a synchronous action or the PLC watches. These see no source times, so
    /// `nodes.heartbeat` must be given. Siemens, "SINUMERIK Integrate Access MyMachine /OPC UA, Configuration Manual", 12/2017, section 5.3.
    Sinumerik,
    /// A server of OPC 40502 (CNC Systems 1.0): `CncAxisList/<axis>/PosDirect/ActPos`, sections 6.1, 6.2 and 6.8. The specification has
    /// no node to write: verdict and hold must be named.
    Cnc,
}

impl Preset {
    fn axis(self, letter: char, number: usize) -> Node {
        match self {
            Self::Sinumerik => Node::Id(format!("ns=2;s=/Channel/MachineAxis/actToolBasePos[u1,{number}]")),
            Self::Cnc => {
                let steps = ["CncInterface", "CncAxisList", &letter.to_string(), "PosDirect", "ActPos"];
                Node::Path(steps.map(|name| ("cnc".to_owned(), name.to_owned())).into())
            }
        }
    }

    fn verdict(self) -> Option<Node> {
        (self == Self::Sinumerik).then(|| Node::Id("ns=2;s=/Channel/Parameter/R[u1,900]".to_owned()))
    }

    fn hold(self) -> Option<Node> {
        (self == Self::Sinumerik).then(|| Node::Id("ns=2;s=/Channel/Parameter/R[u1,901]".to_owned()))
    }
}

/// Namespace of OPC 40502.
const CNC_NAMESPACE: &str = "http://opcfoundation.org/UA/CNC";

impl Config {
    /// Reads a configuration.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line and cause.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let wrong = |cause: String| ConfigError { file: path.to_owned(), line: 0, cause };
        let size = fs::metadata(path).map_err(|error| wrong(error.to_string()))?.len();
        if size > LARGEST {
            return Err(wrong(format!("{size} bytes are more than a configuration has")));
        }
        let text = fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
        Self::parse(path, &text)
    }

    /// Reads a configuration from text; `path` is for messages and relative paths.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let line = |at: usize| text.bytes().take(at).filter(|&byte| byte == b'\n').count() + 1;
        let wrong = |at: usize, cause: String| ConfigError { file: path.to_owned(), line: line(at), cause };
        let file: File = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            wrong(at, error.message().to_owned())
        })?;
        Reader { path, line: &line }.config(file).map_err(|(at, cause)| wrong(at, cause))
    }

    /// The acceleration, deceleration and resolution of each joint of a machine.
    ///
    /// # Errors
    /// When the machine has an axis that the configuration lacks, or the other way round.
    pub fn dynamics(&self, machine: &Machine) -> Result<Dynamics, ConfigError> {
        let wrong = |line: usize, cause: String| ConfigError { file: self.file.clone(), line, cause };
        let mut dynamics = Dynamics { acceleration: [0.0; 9], deceleration: [f64::INFINITY; 9], resolution: [0.0; 9] };
        for axis in Axis::ALL {
            let (i, letter) = (axis as usize, axis.letter());
            match (self.axes.get(&letter), is_driven(machine, axis)) {
                (Some(own), true) => {
                    dynamics.acceleration[i] = own.acceleration;
                    dynamics.deceleration[i] = own.deceleration;
                    dynamics.resolution[i] = own.resolution;
                }
                (None, true) => {
                    let cause =
                        format!("the machine of scene `{}` has axis {letter}: add `[axes.{letter}]`", self.scene);
                    return Err(wrong(0, cause));
                }
                (Some(own), false) => {
                    return Err(wrong(own.line, format!("no joint of scene `{}` has axis {letter}", self.scene)));
                }
                (None, false) => {}
            }
        }
        Ok(dynamics)
    }

    /// The rule by which the machine of a scene is judged.
    ///
    /// # Errors
    /// As [`Config::dynamics`], and when nothing says which of the scene's tools is in the spindle.
    pub fn rule(&self, scene: &Scene) -> Result<Rule, ConfigError> {
        if scene.changes_tools() && self.tool.is_none() && self.nodes.tool.is_none() {
            let cause = format!(
                "scene `{}` has parts of tools, and nothing says which tool is in the spindle: give `nodes.tool` or `tool`",
                self.scene
            );
            return Err(ConfigError { file: self.file.clone(), line: 0, cause });
        }
        let dynamics = self.dynamics(&scene.machine)?;
        // The deadline counts from a source time, and the sample may be older than that.
        Ok(Rule { dynamics, deadline_s: self.deadline_s + self.source_jitter_s, near_mm: self.near_mm })
    }
}

/// A fault of a configuration.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{file}:{line}: {cause}", file = .file.display())]
pub struct ConfigError {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1; 0 for the file as a whole.
    pub line: usize,
    /// The cause.
    pub cause: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    scene: String,
    variant: Option<String>,
    endpoint: Spanned<String>,
    preset: Option<Preset>,
    cycle_ms: Option<Spanned<f64>>,
    deadline_ms: Option<Spanned<f64>>,
    stale_ms: Option<Spanned<f64>>,
    source_jitter_ms: Option<Spanned<f64>>,
    near_mm: Option<Spanned<f64>>,
    axes: BTreeMap<String, Spanned<AxisFile>>,
    #[serde(default)]
    nodes: NodesFile,
    release_after_s: Option<Spanned<f64>>,
    tool: Option<u32>,
    security: Option<Spanned<SecurityFile>>,
    #[serde(default)]
    namespaces: BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisFile {
    node: Option<Spanned<String>>,
    number: Option<usize>,
    unit: Option<Spanned<String>>,
    acceleration: Spanned<f64>,
    deceleration: Option<Spanned<f64>>,
    resolution: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct NodesFile {
    verdict: Option<Spanned<String>>,
    hold: Option<Spanned<String>>,
    hold_object: Option<Spanned<String>>,
    hold_method: Option<Spanned<String>>,
    heartbeat: Option<Spanned<String>>,
    line: Option<Spanned<String>>,
    tool: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SecurityFile {
    policy: Option<String>,
    #[serde(default)]
    mode: Mode,
    user: Option<String>,
    password_file: Option<PathBuf>,
    user_certificate: Option<PathBuf>,
    user_key: Option<PathBuf>,
    pki: Option<PathBuf>,
    #[serde(default)]
    create_certificate: bool,
    #[serde(default)]
    insecure: bool,
}

/// Range of times, ms: a tenth of a millisecond to an hour.
const TIMES_MS: [f64; 2] = [0.1, 3.6e6];
/// Range of lengths, angles and accelerations, in their own units.
const SIZES: [f64; 2] = [1e-9, 1e9];

/// Policies of async-opcua that are not broken.
const POLICIES: [&str; 4] = ["None", "Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"];

/// A byte of the text, and what is wrong there.
type Fault = (usize, String);

/// Turns the TOML form into a configuration.
struct Reader<'a> {
    path: &'a Path,
    line: &'a dyn Fn(usize) -> usize,
}

impl Reader<'_> {
    fn config(&self, file: File) -> Result<Config, Fault> {
        if !file.endpoint.get_ref().starts_with("opc.tcp://") {
            let cause = format!("`{}` is no endpoint; write opc.tcp://host:port/", file.endpoint.get_ref());
            return Err((file.endpoint.span().start, cause));
        }
        let seconds = |value: &Option<Spanned<f64>>, name: &str, default: f64| {
            Ok::<_, Fault>(within(value.as_ref(), name, TIMES_MS)?.unwrap_or(default) / 1e3)
        };
        let cycle_s = seconds(&file.cycle_ms, "cycle_ms", 4.0)?;
        let deadline_s = seconds(&file.deadline_ms, "deadline_ms", 20.0)?;
        if deadline_s < cycle_s {
            let at = file.deadline_ms.as_ref().or(file.cycle_ms.as_ref()).map_or(0, |value| value.span().start);
            let cause =
                format!("deadline_ms is {}, which is shorter than a cycle of {} ms", deadline_s * 1e3, cycle_s * 1e3);
            return Err((at, cause));
        }
        // Half a cycle at most: between two samples some time has passed for certain.
        let most = 0.49e3 * cycle_s;
        let source_jitter_s =
            within(file.source_jitter_ms.as_ref(), "source_jitter_ms", [0.0, most])?.unwrap_or(0.0) / 1e3;
        self.check_security(&file)?;
        let mut namespaces = file.namespaces;
        namespaces.entry("cnc".into()).or_insert_with(|| CNC_NAMESPACE.into());
        Ok(Config {
            file: self.path.to_owned(),
            scene: self.scene(file.scene),
            variant: file.variant,
            endpoint: file.endpoint.into_inner(),
            cycle_s,
            deadline_s,
            stale_s: seconds(&file.stale_ms, "stale_ms", 200.0)?,
            source_jitter_s,
            near_mm: positive(file.near_mm.as_ref(), "near_mm")?.unwrap_or(2.0),
            axes: self.axes(&file.axes, file.preset)?,
            nodes: nodes(&file.nodes, file.preset)?,
            release: positive(file.release_after_s.as_ref(), "release_after_s")?
                .map_or(Release::Latched, Release::After),
            tool: file.tool,
            security: self.security(file.security)?,
            namespaces,
        })
    }

    /// Refuses what anybody on the network could read or forge, unless the file says that it may be so.
    fn check_security(&self, file: &File) -> Result<(), Fault> {
        let security = file.security.as_ref().map(Spanned::get_ref);
        let is_open = security.is_none_or(|security| security.mode == Mode::None);
        if is_open && !security.is_some_and(|security| security.insecure) && !is_loopback(file.endpoint.get_ref()) {
            let cause = format!(
                "`{}` is another computer, and without `[security]` anybody between can forge positions and verdicts: give policy and \
                 mode, or `insecure = true` where the network is trusted",
                file.endpoint.get_ref()
            );
            return Err((file.endpoint.span().start, cause));
        }
        Ok(())
    }

    /// A scene's path is relative to the file; a name that is no path there stays a name.
    fn scene(&self, scene: String) -> String {
        let beside = self.beside(Path::new(&scene));
        if beside.exists() { beside.display().to_string() } else { scene }
    }

    fn beside(&self, path: &Path) -> PathBuf {
        self.path.parent().map_or_else(|| path.to_owned(), |folder| folder.join(path))
    }

    fn axes(
        &self,
        files: &BTreeMap<String, Spanned<AxisFile>>,
        preset: Option<Preset>,
    ) -> Result<BTreeMap<char, AxisConfig>, Fault> {
        let letter = |name: &str| name.parse::<char>().ok().and_then(Axis::from_letter);
        let mut axes: Vec<(Axis, &Spanned<AxisFile>)> = Vec::new();
        for (name, file) in files {
            let axis = letter(name).ok_or_else(|| {
                (file.span().start, format!("`{name}` is not an axis; the axes are X Y Z A B C U V W"))
            })?;
            axes.push((axis, file));
        }
        axes.sort_by_key(|(axis, _)| *axis as usize);
        let read = |(index, &(axis, file)): (usize, &(Axis, &Spanned<AxisFile>))| {
            Ok((axis.letter(), self.axis(axis, index + 1, file, preset)?))
        };
        axes.iter().enumerate().map(read).collect()
    }

    fn axis(
        &self,
        axis: Axis,
        number: usize,
        spanned: &Spanned<AxisFile>,
        preset: Option<Preset>,
    ) -> Result<AxisConfig, Fault> {
        let (file, letter) = (spanned.get_ref(), axis.letter());
        let default = preset.map(|preset| preset.axis(letter, file.number.unwrap_or(number)));
        let missing = || (spanned.span().start, format!("axis {letter}: without a preset it needs a `node`"));
        let node = node(file.node.as_ref())?.or(default).ok_or_else(missing)?;
        let unit = file.unit.as_ref().map_or(if axis.is_rotary() { "deg" } else { "mm" }, |unit| unit.get_ref());
        let at = file.unit.as_ref().map_or(0, |unit| unit.span().start);
        let factor = factor(unit, axis).ok_or_else(|| {
            let units = if axis.is_rotary() { "deg, rad" } else { "mm, um, m, inch" };
            (at, format!("axis {letter}: `{unit}` is not one of {units}"))
        })?;
        let scale = if axis.is_rotary() { 1f64.to_radians() } else { 1.0 };
        let required = |value: &Spanned<f64>, name| Ok(positive(Some(value), name)?.unwrap_or_default() * scale);
        let acceleration = required(&file.acceleration, "acceleration")?;
        let deceleration = positive(file.deceleration.as_ref(), "deceleration")?.map(|value| value * scale);
        let resolution = positive(file.resolution.as_ref(), "resolution")?.unwrap_or(0.001) * scale;
        let line = (self.line)(spanned.span().start);
        let deceleration = deceleration.unwrap_or(acceleration);
        Ok(AxisConfig { node, factor, acceleration, deceleration, resolution, line })
    }

    fn security(&self, file: Option<Spanned<SecurityFile>>) -> Result<Security, Fault> {
        let Some(spanned) = file else {
            let pki = self.beside(Path::new("pki"));
            let (policy, mode, user) = ("None".to_owned(), Mode::None, User::Anonymous);
            return Ok(Security { policy, mode, user, pki, creates_certificate: false });
        };
        let at = spanned.span().start;
        let wrong = |cause: String| (at, format!("security: {cause}"));
        let file = spanned.into_inner();
        let policy = file.policy.unwrap_or_else(|| "None".to_owned());
        if !POLICIES.contains(&policy.as_str()) {
            return Err(wrong(format!("policy `{policy}` is not one of {}", POLICIES.join(", "))));
        }
        if (policy == "None") != (file.mode == Mode::None) {
            return Err(wrong("policy and mode are both None, or neither is".to_owned()));
        }
        if file.mode == Mode::None && file.password_file.is_some() {
            return Err(wrong("a password needs a mode other than None: it would be sent as it is".to_owned()));
        }
        let user = match (file.user, file.password_file, file.user_certificate, file.user_key) {
            (None, None, None, None) => User::Anonymous,
            (Some(name), Some(secret), None, None) => {
                let secret = self.beside(&secret);
                let text = fs::read_to_string(&secret)
                    .map_err(|error| wrong(format!("cannot read {}: {error}", secret.display())))?;
                User::Name { name, password: text.trim_end_matches(['\n', '\r']).to_owned() }
            }
            (None, None, Some(certificate), Some(key)) => {
                User::Certificate { certificate: self.beside(&certificate), key: self.beside(&key) }
            }
            _ => {
                let advice = "give user with password_file, or user_certificate with user_key, or none of them";
                return Err(wrong(advice.to_owned()));
            }
        };
        let pki = self.beside(file.pki.as_deref().unwrap_or(Path::new("pki")));
        Ok(Security { policy, mode: file.mode, user, pki, creates_certificate: file.create_certificate })
    }
}

/// Whether an endpoint's name says that it is on this computer. No name is looked up.
fn is_loopback(endpoint: &str) -> bool {
    let rest = endpoint.trim_start_matches("opc.tcp://");
    let authority = rest.split('/').next().unwrap_or_default();
    let host = match authority.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => authority.split(':').next().unwrap_or_default(),
    };
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

/// A number above 0 with which one can calculate.
fn positive(value: Option<&Spanned<f64>>, name: &str) -> Result<Option<f64>, Fault> {
    within(value, name, SIZES)
}

fn within(value: Option<&Spanned<f64>>, name: &str, [least, most]: [f64; 2]) -> Result<Option<f64>, Fault> {
    let Some(spanned) = value else { return Ok(None) };
    match *spanned.get_ref() {
        value if (least..=most).contains(&value) => Ok(Some(value)),
        value => Err((spanned.span().start, format!("{name} is {value}; it must be between {least} and {most}"))),
    }
}

fn factor(unit: &str, axis: Axis) -> Option<f64> {
    Some(match (unit, axis.is_rotary()) {
        ("mm", false) | ("rad", true) => 1.0,
        ("um", false) => 1e-3,
        ("m", false) => 1e3,
        ("inch", false) => 25.4,
        ("deg", true) => 1f64.to_radians(),
        _ => return None,
    })
}

fn node(text: Option<&Spanned<String>>) -> Result<Option<Node>, Fault> {
    text.map(|text| Node::parse(text.get_ref()).map_err(|cause| (text.span().start, cause))).transpose()
}

fn nodes(file: &NodesFile, preset: Option<Preset>) -> Result<Nodes, Fault> {
    let missing = |name: &str| (0, format!("`nodes.{name}` is missing: without it no hold can be given"));
    let verdict = node(file.verdict.as_ref())?.or_else(|| preset?.verdict()).ok_or_else(|| missing("verdict"))?;
    let method = (node(file.hold_object.as_ref())?, node(file.hold_method.as_ref())?);
    let hold = match (node(file.hold.as_ref())?, method) {
        (Some(node), (None, None)) => Hold::Node(node),
        (None, (Some(object), Some(method))) => Hold::Method { object, method },
        (None, (None, None)) => Hold::Node(preset.and_then(Preset::hold).ok_or_else(|| missing("hold"))?),
        _ => return Err((0, "give `nodes.hold`, or `nodes.hold_object` with `nodes.hold_method`".to_owned())),
    };
    let [heartbeat, line, tool] = [&file.heartbeat, &file.line, &file.tool].map(|text| node(text.as_ref()));
    let heartbeat = heartbeat?;
    if preset == Some(Preset::Sinumerik) && heartbeat.is_none() {
        let cause = "`nodes.heartbeat` is missing: an R parameter has no source time, so that without a heartbeat and a timer that \
                     watches it nothing stops the machine when no verdict comes";
        return Err((0, cause.to_owned()));
    }
    Ok(Nodes { verdict, hold, heartbeat, line: line?, tool: tool? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    const TEXT: &str = r#"
scene = "mill-vise"
endpoint = "opc.tcp://127.0.0.1:4840/"
preset = "sinumerik"
nodes.heartbeat = "ns=2;s=beat"
[axes]
Z = { acceleration = 2000, deceleration = 1500 }
X = { acceleration = 2000, unit = "inch" }
C = { acceleration = 90, node = "ns=3;s=c" }
"#;

    fn parse(text: &str) -> Result<Config, ConfigError> {
        Config::parse(Path::new("live.toml"), text)
    }

    #[test]
    fn axes_get_the_numbers_of_the_preset_in_their_order() {
        let config = parse(TEXT).unwrap();
        let id = |letter| config.axes[&letter].node.to_string();
        assert_eq!(id('X'), "ns=2;s=/Channel/MachineAxis/actToolBasePos[u1,1]");
        assert_eq!(id('Z'), "ns=2;s=/Channel/MachineAxis/actToolBasePos[u1,2]");
        assert_eq!(id('C'), "ns=3;s=c");
        assert_eq!((config.axes[&'X'].factor, config.axes[&'X'].deceleration), (25.4, 2000.0));
        assert_eq!(config.axes[&'Z'].deceleration, 1500.0);
        assert!((config.axes[&'C'].acceleration - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(config.release, Release::Latched);
        let unwatched = parse(&TEXT.replace("nodes.heartbeat", "nodes.line")).unwrap_err();
        assert!(unwatched.cause.contains("`nodes.heartbeat` is missing"), "{unwatched}");
        let cnc = parse(&TEXT.replace("sinumerik", "cnc")).unwrap_err();
        assert!(cnc.cause.contains("nodes.verdict"), "{cnc}");
    }

    #[test]
    fn faults_name_file_line_and_cause() {
        for (from, to, expected) in [
            ("opc.tcp:", "http:", "live.toml:3: `http://127.0.0.1:4840/` is no endpoint; write opc.tcp://host:port/"),
            (
                "acceleration = 90",
                "acceleration = -1",
                "live.toml:9: acceleration is -1; it must be between 0.000000001 and 1000000000",
            ),
            ("unit = \"inch\"", "unit = \"deg\"", "live.toml:8: axis X: `deg` is not one of mm, um, m, inch"),
            (
                "ns=3;s=c",
                "c",
                "live.toml:9: `c` is neither a node id (`ns=2;s=name`) nor a path (`/alias:Name/alias:Name`)",
            ),
            ("preset = \"sinumerik\"", "tool = 1", "live.toml:8: axis X: without a preset it needs a `node`"),
            ("C = ", "Q = ", "live.toml:9: `Q` is not an axis; the axes are X Y Z A B C U V W"),
            (
                "preset =",
                "deadline_ms = 1\npreset =",
                "live.toml:4: deadline_ms is 1, which is shorter than a cycle of 4 ms",
            ),
            (
                "preset =",
                "cycle_ms = 50\npreset =",
                "live.toml:4: deadline_ms is 20, which is shorter than a cycle of 50 ms",
            ),
            (
                "preset =",
                "stale_ms = 1e25\npreset =",
                "live.toml:4: stale_ms is 10000000000000000000000000; it must be between 0.1 and 3600000",
            ),
            (
                "preset =",
                "cycle_ms = 1e-7\npreset =",
                "live.toml:4: cycle_ms is 0.0000001; it must be between 0.1 and 3600000",
            ),
            (
                "preset =",
                "source_jitter_ms = 2\npreset =",
                "live.toml:4: source_jitter_ms is 2; it must be between 0 and 1.96",
            ),
        ] {
            assert_eq!(parse(&TEXT.replace(from, to)).unwrap_err().to_string(), expected);
        }
        let unknown = parse(&format!("speed = 1\n{TEXT}")).unwrap_err();
        assert_eq!(unknown.line, 1, "{unknown}");
    }

    #[test]
    fn a_scene_with_parts_of_tools_needs_a_tool() {
        let axis = |letter| format!("{letter} = {{ acceleration = 2000 }}\n");
        let head = TEXT.split("[axes]").next().unwrap();
        let text = |tool: &str| format!("{tool}{head}[axes]\n{}{}{}", axis('X'), axis('Y'), axis('Z'));
        let rule = |tool: &str, scene: &Scene| parse(&text(tool)).unwrap().rule(scene);
        let refused = rule("", &testing::tools()).unwrap_err();
        assert!(refused.cause.contains("give `nodes.tool` or `tool`"), "{refused}");
        assert!(rule("tool = 0\n", &testing::tools()).is_ok() && rule("", &testing::mill()).is_ok());
        assert!(rule("nodes.tool = \"ns=2;s=tool\"\n", &testing::tools()).is_ok());
    }

    #[test]
    fn security_is_whole_or_absent() {
        for (table, expected) in [
            ("policy = \"Basic128Rsa15\"", "policy `Basic128Rsa15` is not one of"),
            ("mode = \"Sign\"", "policy and mode are both None, or neither is"),
            ("policy = \"Basic256Sha256\"\nmode = \"Sign\"\nuser = \"a\"", "give user with password_file"),
            ("user = \"a\"\npassword_file = \"b\"", "a password needs a mode other than None"),
        ] {
            let error = parse(&format!("{TEXT}\n[security]\n{table}\n")).unwrap_err();
            assert!(error.cause.contains(expected), "{error}");
        }
    }

    #[test]
    fn another_computer_needs_security_or_a_word_that_it_does_not() {
        let at = |host: &str, security: &str| parse(&format!("{}\n{security}", TEXT.replace("127.0.0.1", host)));
        for host in ["localhost", "127.0.0.2", "[::1]"] {
            assert!(at(host, "").is_ok(), "{host}");
        }
        for host in ["10.0.0.5", "0.0.0.0", "mill", "localhost.example.org", "[fe80::1]"] {
            let refused = at(host, "").unwrap_err();
            assert!(refused.line == 3 && refused.cause.contains("is another computer"), "{refused}");
            assert!(at(host, "[security]\n").is_err(), "{host}");
            assert!(at(host, "[security]\ninsecure = true\n").is_ok(), "{host}");
            assert!(at(host, "[security]\npolicy = \"Basic256Sha256\"\nmode = \"Sign\"\n").is_ok(), "{host}");
        }
    }

    #[test]
    fn paths_have_an_alias_in_every_step() {
        let node = Node::parse("/cnc:CncInterface/cnc:X").unwrap();
        assert_eq!(node.to_string(), "/cnc:CncInterface/cnc:X");
        assert!(Node::parse("/cnc:CncInterface/X").is_err());
    }
}
