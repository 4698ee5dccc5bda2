//! The watch: an OPC UA client that judges every sample of a control and writes the verdict back.
//!
//! One verdict is on its way at a time, so that no older one overtakes a newer one; samples that come meanwhile are judged by the newest of
//! them. After a lost connection everything is made anew: node ids, subscription, velocities.

use crate::config::{Config, Hold, Mode, Node};
use crate::judge::Verdict;
use crate::log::{Log, Row};
use crate::monitor::{Fault, Monitor, Outcome, Reading, Slot};
use crate::opc;
use bvbench::scene::Scene;
use opcua::client::{Client, ClientBuilder, MonitoredItemMap, OnSubscriptionNotificationCore, Session};
use opcua::types::{
    AttributeId, BrowsePath, DataChangeFilter, DataChangeNotification, DataChangeTrigger, DataValue, ExtensionObject,
    MonitoredItemCreateRequest, MonitoringMode, MonitoringParameters, NodeId, NotificationMessage, NumericRange,
    ObjectId, QualifiedName, ReadValueId, ReferenceTypeId, RelativePath, RelativePathElement, StatusChangeNotification,
    StatusCode, TimestampsToReturn, Variant, WriteValue,
};
use rs274::Axis;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;

/// Application URI of the watch.
const APPLICATION: &str = "urn:bvbench:watch";
/// Batches of values that wait for the judge before new ones are dropped.
const BATCHES: usize = 256;
/// Values of a node that the server keeps between two publications.
const QUEUE: u32 = 64;
/// Time between attempts to connect.
const RETRY: Duration = Duration::from_millis(500);
/// Time that a connection may take.
const CONNECT: Duration = Duration::from_secs(10);

/// What a watch has seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Samples that were judged.
    pub judged: u64,
    /// Samples that came with newer ones and were not judged.
    pub superseded: u64,
    /// Verdicts that the control had confirmed later than the deadline after they were received.
    pub late: u64,
    /// Times that a machine that was free was held.
    pub holds: u64,
    /// Times that a connection was made.
    pub connections: u64,
    /// The last outcome.
    pub last: Option<Outcome>,
}

/// What a watch reports as it goes.
#[derive(Clone, Debug)]
pub struct Report {
    /// The row of the log.
    pub row: Row,
    /// The outcome.
    pub outcome: Outcome,
}

/// Settings of a watch that are not about the machine.
pub struct Settings {
    /// The log; `None` for none.
    pub log: Option<PathBuf>,
    /// Folder of certificates, instead of that of the configuration.
    pub pki: Option<PathBuf>,
    /// Takes the newest report.
    pub reports: watch::Sender<Option<Report>>,
    /// Ends the watch.
    pub stop: CancellationToken,
}

/// Watches until it is stopped.
///
/// # Errors
/// When the log cannot be created, or the client cannot be set up.
pub async fn run(scene: &Scene, monitor: Monitor<'_>, config: &Config, settings: Settings) -> Result<Summary, String> {
    let log = Log::create(settings.log.as_deref())
        .map_err(|error| format!("cannot create {}: {error}", settings.log.clone().unwrap_or_default().display()))?;
    let mut client = client(config, &settings)?;
    let mut watch = Watch { scene, config, monitor, log, summary: Summary::default(), settings, held: None };
    let stop = watch.settings.stop.clone();
    while !stop.is_cancelled() {
        let connected = tokio::select! {
            () = stop.cancelled() => break,
            connected = tokio::time::timeout(CONNECT, Link::open(&mut client, config)) => connected,
        };
        let fault = match connected.unwrap_or_else(|_| Err(Fault::Lost("it took too long to connect".into()))) {
            Ok(mut link) => {
                watch.summary.connections += 1;
                let fault = watch.serve(&mut link, &stop).await;
                link.close().await;
                fault
            }
            Err(fault) => Some(fault),
        };
        let Some(fault) = fault else { break };
        watch.monitor.restart();
        let outcome = watch.monitor.without_sample(fault);
        watch.held = None;
        watch.note(Row { received_ns: now_ns(), ..Row::new(scene, &outcome) }, outcome);
        tokio::select! {
            () = stop.cancelled() => {}
            () = tokio::time::sleep(RETRY) => {}
        }
    }
    Ok(watch.summary)
}

fn client(config: &Config, settings: &Settings) -> Result<Client, String> {
    let security = &config.security;
    let pki = settings.pki.clone().unwrap_or_else(|| security.pki.clone());
    let secure = security.mode != Mode::None;
    ClientBuilder::new()
        .application_name("bvbench watch")
        .application_uri(APPLICATION)
        .product_uri(APPLICATION)
        .pki_dir(pki)
        .create_sample_keypair(security.creates_certificate)
        .trust_server_certs(!secure)
        .verify_server_certs(secure)
        .session_retry_limit(0)
        .min_publish_interval(Duration::from_millis(1))
        .request_timeout(Duration::from_secs_f64(config.stale_s.max(1.0)))
        .client()
        .map_err(|errors| format!("the client cannot be set up: {}", errors.join("; ")))
}

/// Values that came together, or the end of a subscription.
enum Batch {
    Values { readings: Vec<Reading>, published_ns: i64, received: Instant, received_ns: i64 },
    Closed(StatusCode),
}

/// Takes notifications from the client's own task.
struct Feed {
    /// What each monitored item is of, and the factor to mm or radians, by client handle less one.
    slots: Vec<(Slot, f64)>,
    batches: mpsc::Sender<Batch>,
}

impl OnSubscriptionNotificationCore for Feed {
    fn on_subscription_notification(&mut self, notification: NotificationMessage, _items: MonitoredItemMap<'_>) {
        let (received, received_ns) = (Instant::now(), now_ns());
        let (mut readings, mut published) = (Vec::new(), 0);
        for data in notification.notification_data.unwrap_or_default() {
            if let Some(changes) = data.inner_as::<DataChangeNotification>() {
                for item in changes.monitored_items.iter().flatten() {
                    let Some(&(slot, factor)) =
                        (item.client_handle as usize).checked_sub(1).and_then(|i| self.slots.get(i))
                    else {
                        continue;
                    };
                    let ticks = item.value.source_timestamp.as_ref().map_or(0, opcua::types::DateTime::ticks);
                    published = item.value.server_timestamp.as_ref().map_or(published, opcua::types::DateTime::ticks);
                    readings.push(Reading { slot, value: value(&item.value, factor), source_ticks: ticks });
                }
            } else if let Some(change) = data.inner_as::<StatusChangeNotification>() {
                self.batches.try_send(Batch::Closed(change.status)).ok();
            }
        }
        if !readings.is_empty() {
            // A watch that is behind by so many batches is late anyway, and holds for that.
            let published_ns = opc::unix_ns(published);
            self.batches.try_send(Batch::Values { readings, published_ns, received, received_ns }).ok();
        }
    }
}

fn value(value: &DataValue, factor: f64) -> Result<f64, String> {
    let status = value.status();
    if !status.is_good() {
        return Err(status.to_string());
    }
    if value.source_timestamp.is_none() {
        return Err("no source time".into());
    }
    let number = value.value.as_ref().and_then(opc::number);
    number.map(|number| number * factor).ok_or_else(|| "not a number".into())
}

/// A connection to a control.
struct Link {
    session: Arc<Session>,
    task: tokio::task::JoinHandle<StatusCode>,
    batches: mpsc::Receiver<Batch>,
    verdict: (NodeId, Variant),
    heartbeat: Option<(NodeId, Variant)>,
    hold: Way,
}

/// How a hold is given.
enum Way {
    Node(NodeId, Variant),
    Method(NodeId, NodeId),
}

impl Link {
    async fn open(client: &mut Client, config: &Config) -> Result<Self, Fault> {
        let lost = |error: String| Fault::Lost(error);
        let security = &config.security;
        let endpoint = (config.endpoint.as_str(), opc::policy(security).to_str(), opc::mode(security));
        let identity = opc::identity(security).map_err(lost)?;
        let (session, events) = client
            .connect_to_matching_endpoint(endpoint, identity)
            .await
            .map_err(|error| lost(format!("{}: {error}", config.endpoint)))?;
        let task = events.spawn();
        let opened = Self::subscribe(session.clone(), config, task).await;
        if opened.is_err() {
            // A session that the control refused has nobody to take leave of.
            tokio::time::timeout(Duration::from_millis(200), session.disconnect()).await.ok();
        }
        opened
    }

    async fn subscribe(
        session: Arc<Session>,
        config: &Config,
        mut task: tokio::task::JoinHandle<StatusCode>,
    ) -> Result<Self, Fault> {
        tokio::select! {
            ended = &mut task => {
                let status = ended.unwrap_or(StatusCode::BadUnexpectedError);
                return Err(Fault::Lost(format!("{} refused the session: {status}", config.endpoint)));
            }
            _ = session.wait_for_connection() => {}
        }
        let (sender, batches) = mpsc::channel(BATCHES);
        let (items, slots) = items(&session, config).await?;
        let nodes = &config.nodes;
        let verdict = writable(&session, config, &nodes.verdict).await?;
        let heartbeat = match &nodes.heartbeat {
            Some(node) => Some(writable(&session, config, node).await?),
            None => None,
        };
        let hold = match &nodes.hold {
            Hold::Node(node) => {
                let (id, template) = writable(&session, config, node).await?;
                Way::Node(id, template)
            }
            Hold::Method { object, method } => {
                Way::Method(resolve(&session, config, object).await?, resolve(&session, config, method).await?)
            }
        };
        let lost = |error: opcua::types::Error| Fault::Lost(error.to_string());
        let feed = Feed { slots, batches: sender };
        // More often than the control moves, a server that is slow to publish falls behind.
        let cycle = Duration::from_secs_f64(config.cycle_s);
        let id = session.create_subscription(cycle, 30_000, 10_000, 0, 0, true, feed).await.map_err(lost)?;
        let created = session.create_monitored_items(id, TimestampsToReturn::Both, items).await.map_err(lost)?;
        if let Some(refused) = created.iter().find(|item| !item.result.status_code.is_good()) {
            let (node, status) = (&refused.item_to_monitor.node_id, refused.result.status_code);
            return Err(Fault::Node(format!("node {node} cannot be subscribed to: {status}")));
        }
        Ok(Self { session, task, batches, verdict, heartbeat, hold })
    }

    async fn close(self) {
        tokio::time::timeout(Duration::from_secs(1), self.session.disconnect()).await.ok();
        self.task.abort();
    }

    /// Writes a verdict, and a hold where it is to change.
    async fn write(&self, verdict: Verdict, count: u32, source_ticks: i64, hold: Option<bool>) -> Result<(), Fault> {
        // A hold is given before a verdict that says why, and released after one that permits.
        let mut writes = Vec::new();
        let stamp = (source_ticks != 0).then(|| opc::date(source_ticks));
        let typed = |(id, template): &(NodeId, Variant), number: u32| {
            let value = opc::like(template, number);
            let value = DataValue { value, source_timestamp: stamp, ..DataValue::null() };
            write_value(id.clone(), value)
        };
        if let (Way::Node(id, template), Some(hold)) = (&self.hold, hold) {
            let value = DataValue { value: opc::like(template, hold.into()), ..DataValue::null() };
            writes.push(write_value(id.clone(), value));
        }
        writes.push(typed(&self.verdict, verdict as u32));
        writes.extend(self.heartbeat.as_ref().map(|heartbeat| typed(heartbeat, count & 0x7f)));
        let results = self.session.write(&writes).await.map_err(|error| Fault::Lost(error.to_string()))?;
        if let Some((write, status)) = writes.iter().zip(&results).find(|(_, status)| !status.is_good()) {
            return Err(Fault::Node(format!("node {} cannot be written: {status}", write.node_id)));
        }
        if let (Way::Method(object, method), Some(hold)) = (&self.hold, hold) {
            let call = (object.clone(), method.clone(), Some(vec![Variant::Boolean(hold)]));
            let result = self.session.call_one(call).await.map_err(|error| Fault::Lost(error.to_string()))?;
            if !result.status_code.is_good() {
                return Err(Fault::Node(format!("method {method} cannot be called: {}", result.status_code)));
            }
        }
        Ok(())
    }
}

fn write_value(node_id: NodeId, value: DataValue) -> WriteValue {
    WriteValue { node_id, attribute_id: AttributeId::Value as u32, index_range: NumericRange::None, value }
}

/// What is subscribed to.
async fn items(
    session: &Session,
    config: &Config,
) -> Result<(Vec<MonitoredItemCreateRequest>, Vec<(Slot, f64)>), Fault> {
    let axis = |(letter, axis): (&char, &crate::config::AxisConfig)| {
        Some((axis.node.clone(), Slot::Axis(Axis::from_letter(*letter)?), axis.factor))
    };
    let mut wanted: Vec<(Node, Slot, f64)> = config.axes.iter().filter_map(axis).collect();
    wanted.extend(config.nodes.line.clone().map(|node| (node, Slot::Line, 1.0)));
    wanted.extend(config.nodes.tool.clone().map(|node| (node, Slot::Tool, 1.0)));
    let (mut items, mut slots) = (Vec::new(), Vec::new());
    for (node, slot, factor) in wanted {
        let node_id = resolve(session, config, &node).await?;
        slots.push((slot, factor));
        let filter = DataChangeFilter {
            trigger: DataChangeTrigger::StatusValueTimestamp,
            deadband_type: 0,
            deadband_value: 0.0,
        };
        items.push(MonitoredItemCreateRequest {
            item_to_monitor: ReadValueId { node_id, attribute_id: AttributeId::Value as u32, ..Default::default() },
            monitoring_mode: MonitoringMode::Reporting,
            requested_parameters: MonitoringParameters {
                client_handle: u32::try_from(slots.len()).unwrap_or(u32::MAX),
                sampling_interval: 0.0,
                filter: ExtensionObject::from_message(filter),
                queue_size: QUEUE,
                discard_oldest: true,
            },
        });
    }
    Ok((items, slots))
}

/// The id of a node, which a server need not have.
async fn resolve(session: &Session, config: &Config, node: &Node) -> Result<NodeId, Fault> {
    let steps = match node {
        Node::Id(text) => {
            return NodeId::from_str(text).map_err(|_| Fault::Node(format!("`{text}` is not a node id")));
        }
        Node::Path(steps) => steps,
    };
    let mut elements = Vec::new();
    for (alias, name) in steps {
        let uri = config.namespaces.get(alias);
        let uri = uri.ok_or_else(|| Fault::Node(format!("node {node}: `{alias}` is not in [namespaces]")))?;
        let index = session.get_namespace_index(uri).await;
        let index = index.map_err(|_| Fault::Node(format!("node {node}: the control has no namespace {uri}")))?;
        elements.push(RelativePathElement {
            reference_type_id: ReferenceTypeId::HierarchicalReferences.into(),
            is_inverse: false,
            include_subtypes: true,
            target_name: QualifiedName::new(index, name.clone()),
        });
    }
    let path = BrowsePath {
        starting_node: ObjectId::ObjectsFolder.into(),
        relative_path: RelativePath { elements: Some(elements) },
    };
    let found = session.translate_browse_paths_to_node_ids(&[path]).await;
    let found = found.map_err(|error| Fault::Lost(error.to_string()))?;
    let target = found.into_iter().next().and_then(|result| result.targets?.into_iter().next());
    target.map(|target| target.target_id.node_id).ok_or_else(|| Fault::Node(format!("the control has no node {node}")))
}

/// A node that takes numbers, and a value of its type.
async fn writable(session: &Session, config: &Config, node: &Node) -> Result<(NodeId, Variant), Fault> {
    let node_id = resolve(session, config, node).await?;
    let read = ReadValueId { node_id: node_id.clone(), attribute_id: AttributeId::Value as u32, ..Default::default() };
    let values = session.read(&[read], TimestampsToReturn::Neither, 0.0).await;
    let value = values.map_err(|error| Fault::Lost(error.to_string()))?.into_iter().next().unwrap_or_default();
    let status = value.status();
    match value.value.filter(|value| status.is_good() && opc::like(value, 0).is_some()) {
        Some(template) => Ok((node_id, template)),
        None => Err(Fault::Node(format!("node {node} cannot be read as a number: {status}"))),
    }
}

/// A watch with all that it keeps from one connection to the next.
struct Watch<'a> {
    scene: &'a Scene,
    config: &'a Config,
    monitor: Monitor<'a>,
    log: Log,
    summary: Summary,
    settings: Settings,
    /// What the hold was last set to; `None` when nobody knows.
    held: Option<bool>,
}

impl Watch<'_> {
    /// Judges samples until the connection is lost, or the watch is stopped (`None`).
    async fn serve(&mut self, link: &mut Link, stop: &CancellationToken) -> Option<Fault> {
        let stale = Duration::from_secs_f64(self.config.stale_s);
        let begin = Instant::now();
        let mut last = begin;
        loop {
            let batch = tokio::select! {
                () = stop.cancelled() => return None,
                batch = link.batches.recv() => batch,
                ended = &mut link.task => {
                    let status = ended.unwrap_or(StatusCode::BadUnexpectedError);
                    return Some(Fault::Lost(format!("the connection was closed: {status}")));
                }
                () = tokio::time::sleep_until((last + stale).into()) => {
                    let outcome = self.monitor.silence(last.elapsed().as_secs_f64());
                    last = Instant::now();
                    let times = (0, now_ns());
                    if let Err(fault) = self.answer(link, outcome, times, Instant::now()).await { return Some(fault); }
                    continue;
                }
            };
            let Some(batch) = batch else { return Some(Fault::Lost("the connection was closed".into())) };
            let mut batches = vec![batch];
            batches.extend(std::iter::from_fn(|| link.batches.try_recv().ok()));
            let (mut readings, mut times, mut received) = (Vec::new(), (0, 0), Instant::now());
            for batch in batches {
                match batch {
                    Batch::Closed(status) => return Some(Fault::Lost(format!("the subscription ended: {status}"))),
                    Batch::Values { readings: more, published_ns, received: at, received_ns } => {
                        readings.extend(more);
                        (times, received) = ((published_ns, received_ns), at);
                    }
                }
            }
            let Some(outcome) = self.monitor.take(&readings, (received - begin).as_secs_f64()) else { continue };
            last = received;
            if let Err(fault) = self.answer(link, outcome, times, received).await {
                return Some(fault);
            }
        }
    }

    /// Writes what follows from a sample, and notes it.
    async fn answer(
        &mut self,
        link: &Link,
        outcome: Outcome,
        (published_ns, received_ns): (i64, i64),
        received: Instant,
    ) -> Result<(), Fault> {
        let judged_ns = now_ns();
        let hold = (self.held != Some(outcome.holds)).then_some(outcome.holds);
        let verdict = match outcome.verdict {
            verdict if outcome.holds && verdict.permits() => Verdict::Unknown,
            verdict => verdict,
        };
        self.summary.judged += 1;
        self.summary.superseded += u64::from(outcome.superseded);
        let count = self.summary.judged as u32;
        let written = link.write(verdict, count, outcome.source_ticks, hold).await;
        self.summary.holds += u64::from(self.held == Some(false) && outcome.holds);
        self.held = written.is_ok().then_some(outcome.holds);
        self.summary.late += u64::from(received.elapsed().as_secs_f64() > self.config.deadline_s);
        let written_ns = if written.is_ok() { now_ns() } else { 0 };
        let row = Row { published_ns, received_ns, judged_ns, written_ns, ..Row::new(self.scene, &outcome) };
        self.note(row, outcome);
        written
    }

    fn note(&mut self, row: Row, outcome: Outcome) {
        match self.log.write(&row) {
            Ok(()) => self.monitor.recover(),
            Err(error) => self.monitor.fail(Fault::Log(error.to_string())),
        }
        self.summary.last = Some(outcome.clone());
        self.settings.reports.send_replace(Some(Report { row, outcome }));
    }
}

fn now_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}
