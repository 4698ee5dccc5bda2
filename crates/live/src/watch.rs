//! The watch: an OPC UA client that judges every sample of a control and writes the verdict back.
//!
//! One verdict is on its way at a time, so that no older one overtakes a newer one; samples that come meanwhile are judged by the newest of
//! them. After a lost connection everything is made anew: node ids, subscription, velocities. However a connection ends, the last thing that is
//! written is a hold.

use crate::config::{Config, Hold, Mode, Node};
use crate::judge::Verdict;
use crate::log::{Log, Row};
use crate::monitor::{Fault, Monitor, Outcome, Reading, Slot};
use crate::opc::{self, now_ns};
use crate::outputs::{MOST_BEAT, MOST_HOLD, MOST_VERDICT, Output, Outputs, Target, Way};
use bvbench::scene::Scene;
use opcua::client::{Client, ClientBuilder, MonitoredItemMap, OnSubscriptionNotificationCore, Session};
use opcua::types::{
    AttributeId, BrowsePath, BrowsePathResult, DataChangeFilter, DataChangeNotification, DataChangeTrigger, DataValue,
    ExtensionObject, MonitoredItemCreateRequest, MonitoringMode, MonitoringParameters, NodeId, NotificationMessage,
    ObjectId, QualifiedName, ReadValueId, ReferenceTypeId, RelativePath, RelativePathElement, StatusChangeNotification,
    StatusCode, TimestampsToReturn,
};
use rs274::Axis;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;

/// Application URI of the watch.
const APPLICATION: &str = "urn:bvbench:watch";
/// Batches of values that may wait for the judge. With more the connection is given up.
const BATCHES: usize = 256;
/// Values of a node that the server keeps between two publications.
const QUEUE: u32 = 64;
/// Time between attempts to connect.
const RETRY: Duration = Duration::from_millis(500);
/// Time that a connection may take.
const CONNECT: Duration = Duration::from_secs(10);
/// Time that the last hold may take before a connection is closed.
const FAREWELL: Duration = Duration::from_millis(200);

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
/// When the log cannot be opened, or the client cannot be set up.
pub async fn run(scene: &Scene, monitor: Monitor<'_>, config: &Config, settings: Settings) -> Result<Summary, String> {
    let log = Log::open(settings.log.as_deref())
        .map_err(|error| format!("cannot open {}: {error}", settings.log.clone().unwrap_or_default().display()))?;
    let mut client = client(config, &settings)?;
    let mut watch = Watch { scene, config, monitor, log, summary: Summary::default(), settings, held: None, beat: 0 };
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
                link.close(&watch.monitor).await;
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
    opc::keep_private(security, &pki)?;
    let client = ClientBuilder::new()
        .application_name("bvbench watch")
        .application_uri(APPLICATION)
        .product_uri(APPLICATION)
        .pki_dir(pki.clone())
        .create_sample_keypair(security.creates_certificate)
        .trust_server_certs(!secure)
        .verify_server_certs(secure)
        .session_retry_limit(0)
        .recreate_subscriptions(false)
        .min_publish_interval(Duration::from_millis(1))
        .request_timeout(Duration::from_secs_f64(config.stale_s.max(1.0)))
        .client()
        .map_err(|errors| format!("the client cannot be set up: {}", errors.join("; ")))?;
    opc::keep_private(security, &pki)?;
    Ok(client)
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
    /// Set when a batch found no room.
    overflowed: Arc<AtomicBool>,
}

impl Feed {
    /// Hands a batch over. If there is no room it is lost, with what it said of the tool or an axis.
    fn send(&self, batch: Batch) {
        if matches!(self.batches.try_send(batch), Err(mpsc::error::TrySendError::Full(_))) {
            self.overflowed.store(true, Ordering::SeqCst);
        }
    }
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
                self.send(Batch::Closed(change.status));
            }
        }
        if !readings.is_empty() {
            let published_ns = opc::unix_ns(published);
            self.send(Batch::Values { readings, published_ns, received, received_ns });
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

/// The task that drives a session. It ends with its owner: left alone it would keep the session open.
struct Driver(tokio::task::JoinHandle<StatusCode>);

impl Driver {
    /// Waits for the end of the session, and tells how it ended.
    async fn ended(&mut self) -> StatusCode {
        (&mut self.0).await.unwrap_or(StatusCode::BadUnexpectedError)
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// A connection to a control.
struct Link {
    session: Arc<Session>,
    driver: Driver,
    batches: mpsc::Receiver<Batch>,
    overflowed: Arc<AtomicBool>,
    outputs: Outputs,
}

/// What a watch waits for.
enum Event {
    /// The watch is stopped.
    Stop,
    /// The session ended.
    Ended(StatusCode),
    /// Values came, or the end of the subscription; `None` when no more can come.
    Batch(Option<Batch>),
    /// Nothing came in time.
    Silence,
}

/// The next event. Of several at the same time the first in this order: what has come is judged before silence is told.
async fn next_event(
    stop: &CancellationToken,
    driver: &mut Driver,
    batches: &mut mpsc::Receiver<Batch>,
    silent_at: Instant,
) -> Event {
    tokio::select! {
        biased;
        () = stop.cancelled() => Event::Stop,
        status = driver.ended() => Event::Ended(status),
        batch = batches.recv() => Event::Batch(batch),
        () = tokio::time::sleep_until(silent_at.into()) => Event::Silence,
    }
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
        // The library would connect again by itself, and send values to a watch that does not know that some are missing.
        session.disable_reconnects();
        let mut driver = Driver(events.spawn());
        let subscribed = subscribe(&session, config, &mut driver).await;
        if subscribed.is_err() {
            // A session that the control refused has nobody to take leave of.
            tokio::time::timeout(FAREWELL, session.disconnect()).await.ok();
        }
        let (batches, overflowed, outputs) = subscribed?;
        Ok(Self { session, driver, batches, overflowed, outputs })
    }

    /// Holds the machine and takes leave.
    async fn close(self, monitor: &Monitor<'_>) {
        // Without a heartbeat: nothing vouches for what comes after.
        let hold = Output {
            hold: true,
            hold_changes: true,
            verdict: Verdict::Unknown,
            source_ticks: monitor.source_ticks(),
            beat: None,
        };
        tokio::time::timeout(FAREWELL, self.outputs.write(&self.session, &hold)).await.ok();
        tokio::time::timeout(Duration::from_secs(1), self.session.disconnect()).await.ok();
    }
}

/// Finds the nodes of a configuration and subscribes to those that are read.
async fn subscribe(
    session: &Session,
    config: &Config,
    driver: &mut Driver,
) -> Result<(mpsc::Receiver<Batch>, Arc<AtomicBool>, Outputs), Fault> {
    tokio::select! {
        status = driver.ended() => {
            return Err(Fault::Lost(format!("{} refused the session: {status}", config.endpoint)));
        }
        _ = session.wait_for_connection() => {}
    }
    let (sender, batches) = mpsc::channel(BATCHES);
    let (items, slots) = items(session, config).await?;
    let nodes = &config.nodes;
    let verdict = writable(session, config, &nodes.verdict, MOST_VERDICT).await?;
    let heartbeat = match &nodes.heartbeat {
        Some(node) => Some(writable(session, config, node, MOST_BEAT).await?),
        None => None,
    };
    let hold = match &nodes.hold {
        Hold::Node(node) => Way::Node(writable(session, config, node, MOST_HOLD).await?),
        Hold::Method { object, method } => {
            Way::Method(resolve(session, config, object).await?, resolve(session, config, method).await?)
        }
    };
    let lost = |error: opcua::types::Error| Fault::Lost(error.to_string());
    let overflowed = Arc::new(AtomicBool::new(false));
    let feed = Feed { slots, batches: sender, overflowed: Arc::clone(&overflowed) };
    // More often than the control moves, a server that is slow to publish falls behind.
    let cycle = Duration::from_secs_f64(config.cycle_s);
    let id = session.create_subscription(cycle, 30_000, 10_000, 0, 0, true, feed).await.map_err(lost)?;
    let created = session.create_monitored_items(id, TimestampsToReturn::Both, items).await.map_err(lost)?;
    if let Some(refused) = created.iter().find(|item| !item.result.status_code.is_good()) {
        let (node, status) = (&refused.item_to_monitor.node_id, refused.result.status_code);
        return Err(Fault::Node(format!("node {node} cannot be subscribed to: {status}")));
    }
    Ok((batches, overflowed, Outputs::new(verdict, heartbeat, hold)))
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
    target(node, found.into_iter().next().unwrap_or_default())
}

/// The one node that a path leads to. A target with a rest of the path left lies on another server.
fn target(node: &Node, found: BrowsePathResult) -> Result<NodeId, Fault> {
    let mut targets = found.targets.unwrap_or_default();
    targets.retain(|target| target.remaining_path_index == u32::MAX);
    match &targets[..] {
        [target] => Ok(target.target_id.node_id.clone()),
        [] => Err(Fault::Node(format!("the control has no node {node}"))),
        several => Err(Fault::Node(format!("node {node} names {} nodes of the control", several.len()))),
    }
}

/// A node, and a value of its type, which must hold the numbers 0 to `most`.
async fn writable(session: &Session, config: &Config, node: &Node, most: u32) -> Result<Target, Fault> {
    let node_id = resolve(session, config, node).await?;
    let read = ReadValueId { node_id: node_id.clone(), attribute_id: AttributeId::Value as u32, ..Default::default() };
    let values = session.read(&[read], TimestampsToReturn::Neither, 0.0).await;
    let value = values.map_err(|error| Fault::Lost(error.to_string()))?.into_iter().next().unwrap_or_default();
    let status = value.status();
    match value.value.filter(|_| status.is_good()) {
        Some(template) if opc::like(&template, most).is_some() => Ok((node_id, template)),
        Some(other) => {
            let cause = format!("node {node} holds {other:?}: give it a type of numbers from 0 to {most}");
            Err(Fault::Node(cause))
        }
        None => Err(Fault::Node(format!("node {node} cannot be read: {status}"))),
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
    /// The heartbeat.
    beat: u32,
}

impl Watch<'_> {
    /// Judges samples until the connection is lost, or the watch is stopped (`None`).
    async fn serve(&mut self, link: &mut Link, stop: &CancellationToken) -> Option<Fault> {
        let stale = Duration::from_secs_f64(self.config.stale_s);
        let begin = Instant::now();
        let mut last = begin;
        loop {
            let batch = match next_event(stop, &mut link.driver, &mut link.batches, last + stale).await {
                Event::Stop => return None,
                Event::Ended(status) => return Some(Fault::Lost(format!("the connection was closed: {status}"))),
                Event::Batch(Some(batch)) => batch,
                Event::Batch(None) => return Some(Fault::Lost("the connection was closed".into())),
                Event::Silence => {
                    let outcome = self.monitor.without_sample(Fault::Stale(last.elapsed().as_secs_f64()));
                    last = Instant::now();
                    let times = (0, now_ns());
                    if let Err(fault) = self.answer(link, outcome, times, Instant::now()).await {
                        return Some(fault);
                    }
                    continue;
                }
            };
            let mut batches = vec![batch];
            batches.extend(std::iter::from_fn(|| link.batches.try_recv().ok()));
            if link.overflowed.load(Ordering::SeqCst) {
                return Some(Fault::Lost(format!("more than {BATCHES} notifications waited for the judge")));
            }
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
        let verdict = match outcome.verdict {
            verdict if outcome.holds && verdict.permits() => Verdict::Unknown,
            verdict => verdict,
        };
        self.summary.judged += 1;
        self.summary.superseded += u64::from(outcome.superseded);
        // A heartbeat that does not change lets the control's timer run out: it vouches for no sample that is older than the deadline.
        let age_s = outcome.delay_s + received.elapsed().as_secs_f64();
        self.beat = self.beat.wrapping_add(u32::from(age_s <= self.config.deadline_s));
        let output = Output {
            hold: outcome.holds,
            hold_changes: self.held != Some(outcome.holds),
            verdict,
            source_ticks: outcome.source_ticks,
            beat: Some(self.beat),
        };
        let written = link.outputs.write(&link.session, &output).await;
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
        self.settings.reports.send_replace(Some(Report { row, outcome }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use opcua::types::BrowsePathTarget;

    fn values() -> Batch {
        Batch::Values { readings: Vec::new(), published_ns: 0, received: Instant::now(), received_ns: 0 }
    }

    #[test]
    fn a_batch_that_finds_no_room_is_told() {
        let (batches, _receiver) = mpsc::channel(1);
        let feed = Feed { slots: Vec::new(), batches, overflowed: Arc::default() };
        feed.send(values());
        assert!(!feed.overflowed.load(Ordering::SeqCst));
        feed.send(values());
        assert!(feed.overflowed.load(Ordering::SeqCst));
    }

    #[tokio::test]
    async fn what_has_come_is_judged_before_silence_is_told() {
        let (sender, mut batches) = mpsc::channel(BATCHES);
        let (stop, mut driver) = (CancellationToken::new(), Driver(tokio::spawn(std::future::pending())));
        // The judge was at work for longer than silence may last.
        let past = Instant::now();
        for _ in 0..BATCHES {
            sender.try_send(values()).ok().unwrap();
        }
        for _ in 0..BATCHES {
            assert!(matches!(next_event(&stop, &mut driver, &mut batches, past).await, Event::Batch(Some(_))));
        }
        assert!(matches!(next_event(&stop, &mut driver, &mut batches, past).await, Event::Silence));
    }

    #[tokio::test]
    async fn a_session_ends_with_its_owner() {
        let (alive, ended) = tokio::sync::oneshot::channel::<()>();
        let driver = Driver(tokio::spawn(async move {
            let _alive = alive;
            std::future::pending().await
        }));
        // As when the time to connect is over.
        drop(driver);
        let ended = tokio::time::timeout(Duration::from_secs(60), ended).await;
        assert!(ended.is_ok_and(|ended| ended.is_err()), "the task goes on");
    }

    #[test]
    #[cfg(unix)]
    fn nobody_else_reads_a_private_key_that_is_made() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let axes = "axes.X.acceleration = 1\n[security]\ncreate_certificate = true\n";
        let nodes = "preset = \"sinumerik\"\nnodes.heartbeat = \"ns=2;s=beat\"\n";
        let text = format!("scene = \"x\"\nendpoint = \"opc.tcp://127.0.0.1/\"\n{nodes}{axes}");
        let config = Config::parse(&folder.path().join("live.toml"), &text).unwrap();
        let settings =
            Settings { log: None, pki: None, reports: watch::channel(None).0, stop: CancellationToken::new() };
        client(&config, &settings).unwrap();
        let mode = |name: &str| std::fs::metadata(config.security.pki.join(name)).unwrap().permissions().mode() & 0o777;
        assert_eq!([mode("private"), mode("private/private.pem")], [0o700, 0o600]);
    }

    #[test]
    fn a_path_leads_to_one_node_of_this_server() {
        let node = Node::parse("/cnc:X").unwrap();
        let at = |id: u32, remaining_path_index| BrowsePathTarget {
            target_id: NodeId::new(2, id).into(),
            remaining_path_index,
        };
        let found = |targets: Vec<BrowsePathTarget>| {
            target(&node, BrowsePathResult { targets: Some(targets), ..BrowsePathResult::default() })
        };
        assert_eq!(found(vec![at(1, 0), at(2, u32::MAX)]).unwrap(), NodeId::new(2, 2));
        for (targets, expected) in [
            (vec![], "the control has no node /cnc:X"),
            (vec![at(1, 0)], "the control has no node /cnc:X"),
            (vec![at(1, u32::MAX), at(2, u32::MAX)], "node /cnc:X names 2 nodes of the control"),
        ] {
            assert_eq!(found(targets).unwrap_err().to_string(), expected);
        }
    }
}
