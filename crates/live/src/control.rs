//! A simulated control: an OPC UA server that plays a program, shows its axes, and obeys the verdict and the hold.
//!
//! The control's clock counts its own cycles, as an interpolator does. The machine
//! moves only while the newest verdict permits it, is about a sample not older than the deadline, and the hold node is false. Whoever stops to answer
//! therefore stops the machine. Of all nodes, only verdict, hold and heartbeat can be written.

use crate::config::{Config, Hold, Mode, Node, User};
use crate::judge::Verdict;
use crate::monitor::TICKS_PER_S;
use crate::numbers::{YEAR_S, between, share};
use crate::opc;
use crate::play::{Place, Plan, Player};
use crate::trace::{Cycle, Trace};
use anyhow::{Context as _, Result, anyhow};
use bvbench::scene::{ProgramRun, Scene};
use clap::Args;
use opcua::nodes::{MethodBuilder, ObjectBuilder, VariableBuilder};
use opcua::server::address_space::AddressSpace;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::{SimpleNodeManager, simple_node_manager};
use opcua::server::{ANONYMOUS_USER_TOKEN_ID, ServerBuilder, ServerHandle, ServerUserToken};
use opcua::types::{
    AttributeId, DataEncoding, DataTypeId, DataValue, DateTime, NodeId, NumericRange, ObjectId, QualifiedName,
    StatusCode, TimestampsToReturn, Variant,
};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use rs274::Axis;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

/// Namespace of the nodes of a simulated control.
const NAMESPACE: &str = "urn:bvbench:control:nodes";
/// Application URI of a simulated control.
const APPLICATION: &str = "urn:bvbench:control";

/// Disturbances that a simulated control adds to the program it plays.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Options {
    /// Share of samples that are never shown, 0 to 1
    #[arg(long, default_value_t = 0.0, value_parser = share)]
    pub drop: f64,
    /// Share of samples that are shown late, 0 to 1
    #[arg(long, default_value_t = 0.0, value_parser = share)]
    pub late: f64,
    /// How late, cycles
    #[arg(long, default_value_t = 5)]
    pub late_cycles: u32,
    /// Largest error of a position that is shown, in the unit of its node
    #[arg(long, default_value_t = 0.0, value_parser = between(1e6, "units of the node"))]
    pub jitter: f64,
    /// Seed of what is dropped, late and wrong
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Seconds of motion after which the server goes down and comes back; 0 for never
    #[arg(long = "restart-every", value_name = "RESTART_EVERY", default_value_t = 0.0, value_parser = between(YEAR_S, "s"))]
    pub restart_every_s: f64,
    /// Seconds that it stays down
    #[arg(long = "down", value_name = "DOWN", default_value_t = 0.5, value_parser = between(YEAR_S, "s"))]
    pub down_s: f64,
    /// Go back the way it came when the program is over, and forth again, until Ctrl-C
    #[arg(long)]
    pub repeat: bool,
    /// Seconds that the control's clock waits for a verdict that is nearly too old, for slow computers
    #[arg(long = "patience", value_name = "PATIENCE", default_value_t = 0.0, value_parser = between(3600.0, "s"))]
    pub patience_s: f64,
    /// Folder of certificates, instead of that of the configuration
    #[arg(long)]
    pub pki: Option<PathBuf>,
    /// Trace, CSV: a row per cycle
    #[arg(long)]
    pub trace: Option<PathBuf>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            drop: 0.0,
            late: 0.0,
            late_cycles: 5,
            jitter: 0.0,
            seed: 1,
            restart_every_s: 0.0,
            down_s: 0.5,
            repeat: false,
            patience_s: 0.0,
            pki: None,
            trace: None,
        }
    }
}

/// State of the simulated machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Place in the program.
    pub place: Place,
    /// Whether no axis moves.
    pub stands: bool,
    /// Whether the program is over.
    pub is_over: bool,
    /// Whether it may move.
    pub permitted: bool,
    /// Whether the hold is set.
    pub held: bool,
    /// Times that a machine that moved was held.
    pub holds: u32,
    /// The program's own clock, s.
    pub time_s: f64,
}

/// Ids of the nodes.
struct Nodes {
    axes: Vec<(Axis, f64, NodeId)>,
    verdict: NodeId,
    hold: HoldNode,
    line: Option<NodeId>,
    tool: Option<NodeId>,
}

/// Where the hold stands.
enum HoldNode {
    /// In a node that is written.
    Node(NodeId),
    /// In what the method was last called with.
    Method(Arc<AtomicBool>),
}

/// A running server.
struct Server {
    handle: ServerHandle,
    manager: Arc<SimpleNodeManager>,
    nodes: Nodes,
    task: tokio::task::JoinHandle<Result<(), String>>,
}

/// Listens on an address. Connections send small messages at once: with Nagle's algorithm a sample waits for the answer to the one before.
///
/// # Errors
/// When the address is in use, or not of this computer.
pub fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    socket.set_reuseaddr(true)?;
    socket.set_nodelay(true)?;
    socket.bind(address)?;
    socket.listen(64)
}

/// Plays a program of a scene until it is over, or `stop` is cancelled, on a server that listens on `listener`.
///
/// # Errors
/// When the program cannot be sampled, or the server cannot start.
pub async fn control(
    scene: &Scene,
    run: &ProgramRun,
    config: &Config,
    options: &Options,
    listener: TcpListener,
    status: watch::Sender<Option<Status>>,
    stop: CancellationToken,
) -> Result<()> {
    let dynamics = config.dynamics(&scene.machine)?;
    let plan = Plan::new(scene, run, &dynamics, config.cycle_s)?;
    let mut machine = Machine::new(Player::new(plan, dynamics, config.cycle_s), config, options.clone());
    let create = |path: &PathBuf| Trace::create(path).with_context(|| format!("cannot create {}", path.display()));
    machine.trace = options.trace.as_ref().map(create).transpose()?;
    let address = listener.local_addr()?;
    let mut listener = Some(listener);
    loop {
        let socket = match listener.take() {
            Some(listener) => listener,
            None => listen(address)?,
        };
        let server = Server::start(config, options, socket, address)?;
        let is_done = machine.serve(&server, &status, &stop).await?;
        server.stop().await;
        if is_done {
            return Ok(());
        }
        machine.alone(&status, &stop).await?;
    }
}

/// The machine behind the server.
struct Machine {
    player: Player,
    options: Options,
    random: Pcg64Mcg,
    cycle_s: f64,
    deadline_s: f64,
    /// The control's clock, ticks.
    ticks: i64,
    /// Samples that are not shown yet, with the cycles that they wait.
    waiting: VecDeque<(u32, i64, Place)>,
    /// Source time of the newest verdict, ticks, and the verdict.
    verdict: (i64, f64),
    /// Whether the patience for a newer verdict is used up.
    impatient: bool,
    moved: bool,
    held: bool,
    holds: u32,
    trace: Option<Trace>,
}

impl Machine {
    fn new(player: Player, config: &Config, options: Options) -> Self {
        Self {
            player,
            random: Pcg64Mcg::seed_from_u64(options.seed),
            options,
            cycle_s: config.cycle_s,
            deadline_s: config.deadline_s,
            ticks: DateTime::now().ticks(),
            waiting: VecDeque::new(),
            verdict: (0, 0.0),
            impatient: false,
            moved: false,
            held: true,
            holds: 0,
            trace: None,
        }
    }

    /// Plays with a server until the program is over or the machine is stopped (true), or the server is to go down (false).
    async fn serve(
        &mut self,
        server: &Server,
        status: &watch::Sender<Option<Status>>,
        stop: &CancellationToken,
    ) -> Result<bool> {
        let mut tick = self.tick();
        let mut moved_s = 0.0;
        loop {
            tokio::select! {
                () = stop.cancelled() => return Ok(true),
                _ = tick.tick() => {}
            }
            let mut permitted = self.permitted(server);
            let patience = Instant::now() + Duration::from_secs_f64(self.options.patience_s);
            while self.waits() && Instant::now() < patience && !stop.is_cancelled() {
                tokio::time::sleep(Duration::from_millis(1)).await;
                permitted = self.permitted(server);
            }
            self.impatient = self.waits();
            self.cycle(permitted, status)?;
            self.show(server)?;
            if self.player.is_over() {
                if !self.options.repeat {
                    return Ok(true);
                }
                self.player.turn();
            }
            moved_s += if permitted { self.cycle_s } else { 0.0 };
            if self.options.restart_every_s > 0.0 && moved_s >= self.options.restart_every_s {
                return Ok(false);
            }
        }
    }

    /// Runs while the server is down, by the last permission it received.
    async fn alone(&mut self, status: &watch::Sender<Option<Status>>, stop: &CancellationToken) -> Result<()> {
        let mut tick = self.tick();
        let mut left_s = self.options.down_s;
        while left_s > 0.0 && !stop.is_cancelled() {
            tick.tick().await;
            let permitted = self.may_move();
            self.cycle(permitted, status)?;
            left_s -= self.cycle_s;
        }
        Ok(())
    }

    fn tick(&self) -> tokio::time::Interval {
        let mut tick = tokio::time::interval(Duration::from_secs_f64(self.cycle_s));
        // A clock that keeps time makes up for what it missed; one that waits does not.
        tick.set_missed_tick_behavior(if self.options.patience_s > 0.0 {
            tokio::time::MissedTickBehavior::Delay
        } else {
            tokio::time::MissedTickBehavior::Burst
        });
        tick
    }

    fn cycle(&mut self, permitted: bool, status: &watch::Sender<Option<Status>>) -> Result<()> {
        self.ticks += (self.cycle_s * TICKS_PER_S).round() as i64;
        self.player.cycle(permitted);
        self.holds += u32::from(self.moved && !permitted);
        self.moved = permitted;
        let (place, stands, is_over) = (self.player.place(), self.player.stands(), self.player.is_over());
        let (held, holds, time_s) = (self.held, self.holds, self.player.time_s());
        status.send_replace(Some(Status { place, stands, is_over, permitted, held, holds, time_s }));
        let Some(trace) = &mut self.trace else { return Ok(()) };
        let [source_ns, verdict_ns] = [self.ticks, self.verdict.0].map(opc::unix_ns);
        let cycle = Cycle { source_ns, verdict_ns, permitted, time_s, reach_s: self.player.reach_s(self.deadline_s) };
        trace.write(&cycle).context("the trace cannot be written")
    }

    /// Whether the machine may move in the next cycle. Verdicts about older samples than the newest are ignored.
    fn permitted(&mut self, server: &Server) -> bool {
        self.held = server.is_held();
        if let Some((value, ticks)) = server.read(&server.nodes.verdict)
            && ticks > self.verdict.0
        {
            self.verdict = (ticks, opc::number(&value).unwrap_or_default());
            self.impatient = false;
        }
        self.may_move()
    }

    /// Whether the last permission it received lets the machine move.
    fn may_move(&self) -> bool {
        !self.held && self.is_fresh()
    }

    /// Whether the newest verdict would be too old after three more cycles, and patience is left.
    fn waits(&self) -> bool {
        let age_s = (self.ticks - self.verdict.0) as f64 / TICKS_PER_S + 3.0 * self.cycle_s;
        self.options.patience_s > 0.0 && !self.impatient && self.verdict.0 > 0 && age_s > self.deadline_s
    }

    /// Whether the newest verdict permits motion until the end of the next cycle.
    fn is_fresh(&self) -> bool {
        let permits = [Verdict::Clear, Verdict::Near].iter().any(|&verdict| self.verdict.1 == f64::from(verdict as u8));
        let age_s = (self.ticks - self.verdict.0) as f64 / TICKS_PER_S + self.cycle_s;
        permits && age_s <= self.deadline_s
    }

    /// Shows the newest sample, or an older one that was late, or none.
    fn show(&mut self, server: &Server) -> Result<()> {
        if self.random.random::<f64>() >= self.options.drop {
            let is_late = self.random.random::<f64>() < self.options.late;
            self.waiting.push_back((
                if is_late { self.options.late_cycles } else { 0 },
                self.ticks,
                self.player.place(),
            ));
        }
        // Samples do not overtake one another.
        while let Some((0, ticks, place)) = self.waiting.front().copied() {
            self.waiting.pop_front();
            let jitter = self.options.jitter;
            let error = if jitter > 0.0 { self.random.random_range(-jitter..=jitter) } else { 0.0 };
            server.show(ticks, &place, error)?;
        }
        if let Some((left, ..)) = self.waiting.front_mut() {
            *left -= 1;
        }
        Ok(())
    }
}

impl Server {
    fn start(config: &Config, options: &Options, listener: TcpListener, address: SocketAddr) -> Result<Self> {
        let manager_of = |uri: &str, name: &str| {
            simple_node_manager(NamespaceMetadata { namespace_uri: uri.to_owned(), ..Default::default() }, name)
        };
        let mut builder = builder(config, options, address)?.with_node_manager(manager_of(NAMESPACE, "control"));
        // A server shows the namespaces of its managers alone: one without nodes for each that browse names are in.
        for uri in config.namespaces.values().filter(|uri| *uri != NAMESPACE) {
            builder = builder.with_node_manager(manager_of(uri, "names"));
        }
        let pki = options.pki.as_ref().unwrap_or(&config.security.pki);
        let keep_private = || opc::keep_private(&config.security, pki).map_err(anyhow::Error::msg);
        keep_private()?;
        let (server, handle) = builder.build().map_err(|error| anyhow!("the server cannot start: {error}"))?;
        keep_private()?;
        let manager = handle.node_managers().get_of_type::<SimpleNodeManager>().context("no node manager")?;
        let nodes = add_nodes(config, &handle, &manager)?;
        let task = tokio::spawn(server.run_with(listener));
        Ok(Self { handle, manager, nodes, task })
    }

    async fn stop(self) {
        self.handle.cancel();
        if tokio::time::timeout(Duration::from_secs(2), self.task).await.is_err() {
            // Its connections end with the runtime.
        }
    }

    fn is_held(&self) -> bool {
        match &self.nodes.hold {
            HoldNode::Node(id) => self.read(id).and_then(|(value, _)| opc::number(&value)) != Some(0.0),
            HoldNode::Method(held) => held.load(Ordering::SeqCst),
        }
    }

    /// Value and source time of a node, ticks.
    fn read(&self, id: &NodeId) -> Option<(Variant, i64)> {
        let space = self.manager.address_space().read();
        let value = space.find(id)?.as_node().get_attribute(
            TimestampsToReturn::Source,
            AttributeId::Value,
            &NumericRange::None,
            &DataEncoding::Binary,
        )?;
        let ticks = value.source_timestamp.as_ref().map_or(0, DateTime::ticks);
        Some((value.value?, ticks))
    }

    fn show(&self, ticks: i64, place: &Place, error: f64) -> Result<()> {
        let (source, now) = (opc::date(ticks), DateTime::now());
        let value = |value: Variant| DataValue {
            value: Some(value),
            status: Some(StatusCode::Good),
            source_timestamp: Some(source),
            server_timestamp: Some(now),
            ..DataValue::null()
        };
        let axes = self
            .nodes
            .axes
            .iter()
            .map(|(axis, factor, id)| (id, None, value(Variant::Double(place.position[*axis] / factor + error))));
        let line = self.nodes.line.iter().map(|id| (id, None, value(Variant::UInt32(place.line))));
        let tool = self.nodes.tool.iter().map(|id| (id, None, value(Variant::UInt32(place.tool))));
        self.manager
            .set_values(self.handle.subscriptions(), axes.chain(line).chain(tool))
            .map_err(|status| anyhow!("cannot set an axis node: {status}"))
    }
}

/// A server with one endpoint of the configuration's policy and mode.
fn builder(config: &Config, options: &Options, address: SocketAddr) -> Result<ServerBuilder> {
    let security = &config.security;
    let pki = options.pki.clone().unwrap_or_else(|| security.pki.clone());
    let (token, user) = match &security.user {
        User::Anonymous => (None, ANONYMOUS_USER_TOKEN_ID),
        User::Name { name, password } => (Some(ServerUserToken::user_pass(name.clone(), password.clone())), "operator"),
        User::Certificate { certificate, .. } => {
            let mut token = ServerUserToken::x509("operator", certificate);
            token.read_thumbprint();
            (Some(token), "operator")
        }
    };
    let users = [user];
    let mut builder = ServerBuilder::new()
        .application_name("bvbench simulated control")
        .application_uri(APPLICATION)
        .product_uri(APPLICATION)
        .host(address.ip().to_string())
        .port(address.port())
        .pki_dir(pki)
        .create_sample_keypair(security.creates_certificate)
        .trust_client_certs(security.mode == Mode::None)
        .discovery_urls(vec![format!("opc.tcp://{address}/")])
        .subscription_poll_interval_ms(1)
        .add_endpoint("control", ("/", opc::policy(security), opc::mode(security), users.as_slice()));
    if let Some(token) = token {
        builder = builder.add_user_token(user, token);
    }
    let limits = &mut builder.limits_mut().subscriptions;
    limits.min_publishing_interval_ms = 1.0;
    limits.min_sampling_interval_ms = 0.0;
    Ok(builder)
}

fn add_nodes(config: &Config, handle: &ServerHandle, manager: &SimpleNodeManager) -> Result<Nodes> {
    let index = *manager.namespaces().keys().next().context("the server has no namespace")?;
    let mut adder = Adder { config, handle, manager, index, count: 0 };
    let mut axes = Vec::new();
    for (letter, axis) in &config.axes {
        let id = adder.add(&axis.node, Variant::Double(0.0), DataTypeId::Double, false)?;
        axes.push((Axis::from_letter(*letter).context("an axis of the configuration")?, axis.factor, id));
    }
    let nodes = &config.nodes;
    let verdict = adder.add(&nodes.verdict, Variant::Int32(0), DataTypeId::Int32, true)?;
    let hold = match &nodes.hold {
        Hold::Node(hold) => HoldNode::Node(adder.add(hold, Variant::Boolean(true), DataTypeId::Boolean, true)?),
        Hold::Method { object, method } => HoldNode::Method(adder.add_method(object, method)?),
    };
    if let Some(heartbeat) = &nodes.heartbeat {
        adder.add(heartbeat, Variant::UInt32(0), DataTypeId::UInt32, true)?;
    }
    let mut number = |node: &Option<Node>| {
        node.as_ref().map(|node| adder.add(node, Variant::UInt32(0), DataTypeId::UInt32, false)).transpose()
    };
    let (line, tool) = (number(&nodes.line)?, number(&nodes.tool)?);
    Ok(Nodes { axes, verdict, hold, line, tool })
}

/// Adds variables to the address space of a server.
struct Adder<'a> {
    config: &'a Config,
    handle: &'a ServerHandle,
    manager: &'a SimpleNodeManager,
    /// Namespace of the nodes.
    index: u16,
    /// Nodes that were named by a path, and numbered.
    count: u32,
}

impl Adder<'_> {
    /// Id, folder and browse name of a node that is to be added.
    fn place(&mut self, node: &Node) -> Result<(NodeId, NodeId, QualifiedName)> {
        let objects: NodeId = ObjectId::ObjectsFolder.into();
        match node {
            Node::Id(text) => {
                let id = NodeId::from_str(text).map_err(|_| anyhow!("`{text}` is not a node id"))?;
                if id.namespace != self.index {
                    let index = self.index;
                    return Err(anyhow!("node `{text}`: the nodes of a simulated control are in ns={index}"));
                }
                Ok((id, objects, QualifiedName::new(self.index, text.clone())))
            }
            Node::Path(steps) => {
                let (last, folders) = steps.split_last().context("an empty path")?;
                let parent = folders.iter().try_fold(objects, |parent, step| self.folder(&parent, step))?;
                self.count += 1;
                let name = QualifiedName::new(self.namespace(&last.0)?, last.1.clone());
                Ok((NodeId::new(self.index, self.count), parent, name))
            }
        }
    }

    /// Adds a method that takes the hold as its argument.
    fn add_method(&mut self, object: &Node, method: &Node) -> Result<Arc<AtomicBool>> {
        let objects: NodeId = ObjectId::ObjectsFolder.into();
        let object = match object {
            Node::Path(steps) => steps.iter().try_fold(objects, |parent, step| self.folder(&parent, step))?,
            Node::Id(_) => {
                let (id, parent, name) = self.place(object)?;
                let display = name.name.to_string();
                let builder = ObjectBuilder::new(&id, name, display).organized_by(parent);
                builder.insert(&mut *self.manager.address_space().write());
                id
            }
        };
        let (id, _, name) = self.place(method)?;
        let display = name.name.to_string();
        self.count += 1;
        let (mut space, arguments) = (self.manager.address_space().write(), NodeId::new(self.index, self.count));
        let builder = MethodBuilder::new(&id, name, display)
            .executable(true)
            .user_executable(true)
            .component_of(object)
            .input_args(&mut *space, &arguments, &[("Hold", DataTypeId::Boolean).into()]);
        if !builder.insert(&mut *space) {
            return Err(anyhow!("node {method} is there twice"));
        }
        drop(space);
        let held = Arc::new(AtomicBool::new(true));
        let own = Arc::clone(&held);
        self.manager.inner().add_method_callback(id, move |arguments| match arguments {
            [Variant::Boolean(hold)] => {
                own.store(*hold, Ordering::SeqCst);
                Ok(Vec::new())
            }
            _ => Err(StatusCode::BadInvalidArgument),
        });
        Ok(held)
    }

    fn add(&mut self, node: &Node, value: Variant, kind: DataTypeId, writable: bool) -> Result<NodeId> {
        let (id, parent, name) = self.place(node)?;
        let display = name.name.to_string();
        let builder = VariableBuilder::new(&id, name, display).data_type(kind).value(value).organized_by(parent);
        let builder = if writable { builder.writable() } else { builder };
        if !builder.insert(&mut *self.manager.address_space().write()) {
            return Err(anyhow!("node {node} is there twice"));
        }
        Ok(id)
    }

    /// The folder of a name below another, which is added if it is missing.
    fn folder(&self, parent: &NodeId, (alias, name): &(String, String)) -> Result<NodeId> {
        let id = NodeId::new(self.index, format!("{parent}/{alias}:{name}"));
        let namespace = self.namespace(alias)?;
        let mut space = self.manager.address_space().write();
        if AddressSpace::find(&space, &id).is_none() {
            let name = QualifiedName::new(namespace, name.clone());
            let display = name.name.to_string();
            ObjectBuilder::new(&id, name, display).organized_by(parent.clone()).insert(&mut *space);
        }
        Ok(id)
    }

    fn namespace(&self, alias: &str) -> Result<u16> {
        let uri = self.config.namespaces.get(alias);
        let uri = uri.with_context(|| format!("`{alias}` is not in [namespaces]"))?;
        Ok(self.handle.type_tree().write().namespaces_mut().add_namespace(uri))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::path::Path;

    #[tokio::test]
    async fn a_hold_holds_while_the_server_is_down() {
        let scene = testing::mill();
        let text = "scene = \"x\"\nendpoint = \"opc.tcp://127.0.0.1/\"\npreset = \"sinumerik\"\nnodes.heartbeat = \"ns=2;s=beat\"\naxes.X.acceleration = 1000\naxes.Y.acceleration = 1000\naxes.Z.acceleration = 1000\n";
        let config = Config::parse(Path::new("live.toml"), text).unwrap();
        let dynamics = config.dynamics(&scene.machine).unwrap();
        let plan = Plan::new(&scene, &testing::run(&scene, "G1 X40 F6000\n"), &dynamics, config.cycle_s).unwrap();
        for (held, moves) in [(false, true), (true, false)] {
            let player = Player::new(plan.clone(), dynamics, config.cycle_s);
            let mut machine = Machine::new(player, &config, Options { down_s: 0.02, ..Options::default() });
            // The newest verdict permits motion for some more cycles.
            (machine.held, machine.verdict) = (held, (machine.ticks, f64::from(Verdict::Clear as u8)));
            machine.alone(&watch::channel(None).0, &CancellationToken::new()).await.unwrap();
            assert_eq!(machine.player.time_s() > 0.0, moves, "held: {held}");
        }
    }
}
