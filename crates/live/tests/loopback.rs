//! The watch and the simulated control on the loopback address, in one process.
//!
//! Nothing here depends on how quick the computer is: the control's clock counts its own cycles and waits for the watch.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::registry;
use bvbench::scene::{Overrides, ProgramRun, Scene};
use bvbench_live::config::Config;
use bvbench_live::control::{self, Options, Status};
use bvbench_live::judge::Judge;
use bvbench_live::monitor::Monitor;
use bvbench_live::planted::Exact;
use bvbench_live::watch::{self, Report, Settings, Summary};
use opcua::client::{ClientBuilder, IdentityToken};
use opcua::crypto::{CertificateStore, SecurityPolicy};
use opcua::types::{
    AttributeId, DataValue, MessageSecurityMode, NodeId, NumericRange, StatusCode, Variant, WriteValue,
};
use rs274::{Axis, Position};
use std::fs;
use std::io::Write as _;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::sync::watch as latest;
use tokio_util::sync::CancellationToken;

/// Long enough for any machine; only a test that fails waits for it.
const PATIENCE: Duration = Duration::from_secs(60);

const AXES: &str = "
[axes]
X = { acceleration = 1000 }
Y = { acceleration = 1000 }
Z = { acceleration = 1000 }
";

/// A folder with a configuration for a scene and a port.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn config(&self, address: SocketAddr, first: &str, more: &str) -> Config {
        Config::parse(&self.path("live.toml"), &Self::text(address, first, more)).unwrap()
    }

    fn text(address: SocketAddr, first: &str, more: &str) -> String {
        let beat =
            if more.contains("heartbeat") { "" } else { "heartbeat = \"ns=2;s=/Channel/Parameter/R[u1,902]\"\n" };
        format!(
            "{first}\nscene = \"mill-vise\"\nendpoint = \"opc.tcp://{address}/\"\npreset = \"sinumerik\"\ndeadline_ms = 40\nstale_ms = 60000\ntool = 1\n{AXES}\n[nodes]\nline = \"ns=2;s=/Channel/ProgramInfo/actLineNumber\"\n{beat}{more}"
        )
    }

    fn program(&self, scene: &Scene, text: &str) -> ProgramRun {
        let path = self.path("program.ngc");
        fs::write(&path, text).unwrap();
        scene.program.as_ref().unwrap().with_program(&path).unwrap()
    }
}

/// A control in a thread of its own.
struct Control {
    address: SocketAddr,
    status: latest::Receiver<Option<Status>>,
    stop: CancellationToken,
    thread: Option<JoinHandle<()>>,
}

fn listen() -> (std::net::TcpListener, SocketAddr) {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let address = listener.local_addr().unwrap();
    (listener, address)
}

impl Control {
    fn start(
        scene: &Arc<Scene>,
        run: ProgramRun,
        config: Config,
        options: Options,
        (listener, address): (std::net::TcpListener, SocketAddr),
    ) -> Self {
        let (sender, status) = latest::channel(None);
        let stop = CancellationToken::new();
        let (scene, token) = (Arc::clone(scene), stop.clone());
        let thread = thread::spawn(move || {
            Runtime::new().unwrap().block_on(async {
                let listener = TcpListener::from_std(listener).unwrap();
                control::control(&scene, &run, &config, &options, listener, sender, token).await.unwrap();
            });
        });
        Self { address, status, stop, thread: Some(thread) }
    }

    /// Waits until the machine is as wanted.
    #[track_caller]
    fn wait(&mut self, is_wanted: impl Fn(&Status) -> bool) -> Status {
        let found = Runtime::new().unwrap().block_on(async {
            let wanted = self.status.wait_for(|status| status.as_ref().is_some_and(&is_wanted));
            tokio::time::timeout(PATIENCE, wanted).await.map(|status| status.unwrap().unwrap())
        });
        found.unwrap_or_else(|_| panic!("the machine never got there: {:?}", self.status.borrow()))
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        self.stop.cancel();
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// A watch in a thread of its own.
struct Watch {
    reports: latest::Receiver<Option<Report>>,
    stop: CancellationToken,
    thread: Option<JoinHandle<Summary>>,
}

impl Watch {
    fn start(scene: &Arc<Scene>, config: Config, log: Option<PathBuf>, pki: Option<PathBuf>) -> Self {
        let (sender, reports) = latest::channel(None);
        let stop = CancellationToken::new();
        let (scene, token) = (Arc::clone(scene), stop.clone());
        let thread = thread::spawn(move || {
            let registry = registry::standard();
            let rule = config.rule(&scene).unwrap();
            let judge = Judge::new(&scene, registry.fastest().unwrap(), rule).unwrap();
            let monitor = Monitor::new(&scene, judge, &config);
            let settings = Settings { log, pki, reports: sender, stop: token };
            Runtime::new().unwrap().block_on(watch::run(&scene, monitor, &config, settings)).unwrap()
        });
        Self { reports, stop, thread: Some(thread) }
    }

    #[track_caller]
    fn wait(&mut self, is_wanted: impl Fn(&Report) -> bool) -> Report {
        let found = Runtime::new().unwrap().block_on(async {
            let wanted = self.reports.wait_for(|report| report.as_ref().is_some_and(&is_wanted));
            tokio::time::timeout(PATIENCE, wanted).await.map(|report| report.unwrap().clone().unwrap())
        });
        found.unwrap_or_else(|_| panic!("the watch never got there: {:?}", self.reports.borrow()))
    }

    fn end(mut self) -> Summary {
        self.stop.cancel();
        self.thread.take().unwrap().join().unwrap()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.stop.cancel();
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// A control whose clock waits for the watch.
fn patient() -> Options {
    Options { patience_s: 2.0, ..Options::default() }
}

fn scene() -> Arc<Scene> {
    Arc::new(Scene::find_with("mill-vise", &Overrides::default()).unwrap())
}

/// The least distance of all pairs that are watched, by the exact oracle, mm.
fn clearance_mm(scene: &Scene, at: &Position) -> f64 {
    let pairs = scene.pairs.iter().copied().filter(|&pair| !scene.is_cutting(pair));
    Exact::new(scene, pairs).clearance_mm(at, 1, 1000.0)
}

/// The tool above the vice goes down beside the workpiece until its nut would run into the jaw.
const COLLIDES: &str = "G21 G90 G94\nT1 M6\nG0 X80 Y28\nG0 G53 Z330\nG1 G53 Z200 F3000\nM2\n";
/// High above everything.
const CLEAR: &str = "G21 G90 G94\nT1 M6\nG0 G53 Z500\nG0 G53 X20 Y10\nG1 G53 X40 F6000\nG1 G53 Y-20\nM2\n";

#[test]
fn a_hold_comes_before_contact() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, COLLIDES);
    let end = run.program.moves.last().unwrap().end;
    assert_eq!(clearance_mm(&scene, &end), 0.0, "the program ends in a collision");
    let mut control = Control::start(&scene, run, config.clone(), patient(), socket);
    let mut watch = Watch::start(&scene, config, Some(place.path("log.csv")), None);
    let report = watch.wait(|report| report.row.fault == "contact");
    assert!(report.row.pair.contains("holder"), "{:?}", report.row);
    let stands = control.wait(|status| status.stands && status.time_s > 0.0 && !status.permitted);
    assert!(!stands.is_over);
    let left = clearance_mm(&scene, &stands.place.position);
    assert!(left > 0.0, "the machine touches where it stands");
    // It was not held at the start of its way, but near the end of it.
    let way = stands.place.position[Axis::Z];
    assert!(left < 40.0, "held {left} mm before contact, at Z {way}");
    assert!(stands.place.line >= 4);
    let summary = watch.end();
    assert_eq!(summary.connections, 1);
    let log = fs::read_to_string(place.path("log.csv")).unwrap();
    assert!(log.lines().any(|line| line.contains(",true,contact,")), "{log}");
}

#[test]
fn a_clear_program_gets_no_hold_and_a_restart_of_the_control_one() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "release_after_s = 0.1", "");
    let run = place.program(&scene, CLEAR);
    let options = Options { repeat: true, restart_every_s: 1.0, down_s: 0.3, drop: 0.02, late: 0.02, ..patient() };
    let mut control = Control::start(&scene, run, config.clone(), options, socket);
    let mut watch = Watch::start(&scene, config, None, None);
    // Goes on, is lost, stands, is found again, goes on.
    watch.wait(|report| !report.row.holds);
    let before = control.wait(|status| status.permitted && !status.stands);
    watch.wait(|report| report.row.fault == "lost");
    let standing = control.wait(|status| status.stands && !status.permitted);
    assert!(standing.holds >= 1 && standing.time_s >= before.time_s);
    watch.wait(|report| !report.row.holds);
    control.wait(|status| status.permitted && !status.stands);
    let summary = watch.end();
    assert!(summary.connections >= 2, "{summary:?}");
    // Nobody answers any more: the machine stands.
    control.wait(|status| status.stands && !status.permitted);
}

#[test]
fn no_contact_is_seen_where_there_is_none() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, CLEAR);
    let mut control = Control::start(&scene, run, config.clone(), patient(), socket);
    let log = place.path("log.csv");
    let watch = Watch::start(&scene, config, Some(log.clone()), None);
    control.wait(|status| status.is_over);
    drop(watch);
    let log = fs::read_to_string(log).unwrap();
    assert!(!log.contains("contact") && !log.contains("latched"), "{log}");
    assert!(log.lines().filter(|line| line.contains(",clear,")).count() > 10, "{log}");
}

/// Certificates of a client or server, whose trust list gets those of the other.
fn pki(place: &Place, name: &str, trusts: &[&Path]) -> PathBuf {
    let folder = place.path(name);
    for own in ["own", "private", "trusted", "rejected"] {
        fs::create_dir_all(folder.join(own)).unwrap();
    }
    for certificate in trusts {
        let file = certificate.join("own/cert.der");
        let name = CertificateStore::cert_file_name(&CertificateStore::read_cert(&file).unwrap());
        fs::copy(file, folder.join("trusted").join(name)).unwrap();
    }
    folder
}

fn certificate(folder: &Path, application: &str) {
    ClientBuilder::new()
        .application_name(application)
        .application_uri(application)
        .pki_dir(folder)
        .create_sample_keypair(true)
        .client()
        .unwrap();
}

#[test]
fn who_is_not_trusted_is_refused_and_only_verdict_and_hold_are_written() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let (known, unknown, server) = (pki(&place, "known", &[]), pki(&place, "unknown", &[]), pki(&place, "server", &[]));
    certificate(&known, "urn:bvbench:watch");
    certificate(&unknown, "urn:bvbench:watch");
    certificate(&server, "urn:bvbench:control");
    pki(&place, "known", &[&server]);
    pki(&place, "unknown", &[&server]);
    pki(&place, "server", &[&known]);
    fs::write(place.path("password"), "sesame\n").unwrap();
    let security = "[security]\npolicy = \"Basic256Sha256\"\nmode = \"SignAndEncrypt\"\nuser = \"watch\"\npassword_file = \"password\"\n";
    let config = place.config(socket.1, "", security);
    let run = place.program(&scene, CLEAR);
    let options = Options { pki: Some(server.clone()), repeat: true, ..patient() };
    let mut control = Control::start(&scene, run, config.clone(), options, socket);

    let mut stranger = Watch::start(&scene, config.clone(), None, Some(unknown));
    let refused = stranger.wait(|report| report.row.fault == "lost");
    assert!(
        refused.row.message.contains("BadCertificateUntrusted") || refused.row.message.contains("BadSecurity"),
        "{}",
        refused.row.message
    );
    assert_eq!(stranger.end().connections, 0);
    assert_eq!(fs::read_dir(server.join("rejected")).unwrap().count(), 1, "for the administrator to look at");

    fs::write(place.path("password"), "guess\n").unwrap();
    let guess = place.config(control.address, "", security);
    let mut guesser = Watch::start(&scene, guess, None, Some(known.clone()));
    let refused = guesser.wait(|report| report.row.fault == "lost");
    assert!(
        refused.row.message.contains("Identity") || refused.row.message.contains("refused"),
        "{}",
        refused.row.message
    );
    assert_eq!(guesser.end().connections, 0);

    let mut watch = Watch::start(&scene, config, None, Some(known.clone()));
    watch.wait(|report| !report.row.holds);
    control.wait(|status| status.permitted);

    let statuses = write_everywhere(control.address, &known);
    assert_eq!(
        statuses,
        [StatusCode::BadUserAccessDenied, StatusCode::BadUserAccessDenied, StatusCode::Good],
        "{statuses:?}"
    );
}

/// Writes an axis, the line and the hold as the trusted client.
fn write_everywhere(address: SocketAddr, pki: &Path) -> Vec<StatusCode> {
    let mut client = ClientBuilder::new()
        .application_name("urn:bvbench:watch")
        .application_uri("urn:bvbench:watch")
        .pki_dir(pki)
        .verify_server_certs(true)
        .session_retry_limit(0)
        .client()
        .unwrap();
    Runtime::new().unwrap().block_on(async {
        let url = format!("opc.tcp://{address}/");
        let endpoint = (url.as_str(), SecurityPolicy::Basic256Sha256.to_str(), MessageSecurityMode::SignAndEncrypt);
        let user = IdentityToken::new_user_name("watch", "sesame");
        let (session, events) = client.connect_to_matching_endpoint(endpoint, user).await.unwrap();
        events.spawn();
        tokio::time::timeout(PATIENCE, session.wait_for_connection()).await.unwrap();
        let write = |(node, value): (&str, Variant)| WriteValue {
            node_id: NodeId::from_str(node).unwrap(),
            attribute_id: AttributeId::Value as u32,
            index_range: NumericRange::None,
            value: DataValue::value_only(value),
        };
        let writes = [
            ("ns=2;s=/Channel/MachineAxis/actToolBasePos[u1,1]", Variant::Double(1.0)),
            ("ns=2;s=/Channel/ProgramInfo/actLineNumber", Variant::UInt32(1)),
            ("ns=2;s=/Channel/Parameter/R[u1,901]", Variant::Boolean(true)),
        ];
        let statuses = session.write(&writes.map(write)).await.unwrap();
        session.disconnect().await.ok();
        statuses
    })
}

/// The log is on a small disk: when it is full the machine is held, and with room again it goes on.
#[test]
#[ignore = "needs a small disk at BVBENCH_SMALL_DISK; `scripts/live test` mounts one"]
fn a_full_disk_holds_and_room_releases() {
    let disk = PathBuf::from(std::env::var_os("BVBENCH_SMALL_DISK").unwrap());
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, CLEAR);
    let log = disk.join("log.csv");
    let mut control = Control::start(&scene, run, config.clone(), Options { repeat: true, ..patient() }, socket);
    let mut watch = Watch::start(&scene, config, Some(log.clone()), None);
    control.wait(|status| status.permitted && !status.stands);
    let ballast = disk.join("ballast");
    fill(&ballast);
    let held = watch.wait(|report| report.row.fault == "log");
    assert!(held.row.holds && held.row.message.contains("No space left"), "{:?}", held.row);
    control.wait(|status| !status.permitted && status.stands);
    fs::remove_file(&ballast).unwrap();
    watch.wait(|report| !report.row.holds);
    control.wait(|status| status.permitted && !status.stands);
    watch.end();
    // The row that the full disk cut short is a line of its own, and those behind it are whole.
    let log = fs::read_to_string(log).unwrap();
    let fields = log.lines().next().unwrap().split(',').count();
    assert!(log.lines().last().unwrap().split(',').count() >= fields, "{log}");
}

/// Writes until the disk is full.
fn fill(ballast: &Path) {
    let mut file = fs::File::create(ballast).unwrap();
    for block in [4096, 512, 1] {
        while file.write_all(&vec![1; block]).is_ok() {}
    }
}

#[test]
fn a_user_logs_in_by_certificate_and_messages_are_signed_alone() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let (client, server) = (pki(&place, "client", &[]), pki(&place, "server", &[]));
    let (user, stranger) = (pki(&place, "user", &[]), pki(&place, "stranger", &[]));
    certificate(&client, "urn:bvbench:watch");
    certificate(&server, "urn:bvbench:control");
    certificate(&user, "urn:bvbench:user");
    certificate(&stranger, "urn:bvbench:stranger");
    pki(&place, "client", &[&server]);
    pki(&place, "server", &[&client]);
    let signed = |user: &str| {
        let user = format!("user_certificate = \"{user}/own/cert.der\"\nuser_key = \"{user}/private/private.pem\"\n");
        format!("[security]\npolicy = \"Basic256Sha256\"\nmode = \"Sign\"\n{user}")
    };
    let config = place.config(socket.1, "", &signed("user"));
    let run = place.program(&scene, CLEAR);
    let options = Options { pki: Some(server), repeat: true, ..patient() };
    let mut control = Control::start(&scene, run, config.clone(), options, socket);

    let other = place.config(control.address, "", &signed("stranger"));
    let mut refused = Watch::start(&scene, other, None, Some(client.clone()));
    refused.wait(|report| report.row.fault == "lost");
    assert_eq!(refused.end().connections, 0);

    let mut watch = Watch::start(&scene, config, None, Some(client));
    watch.wait(|report| !report.row.holds);
    control.wait(|status| status.permitted && !status.stands);
}

#[test]
fn nodes_are_found_by_path_and_a_hold_is_given_by_method() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let text = Place::text(socket.1, "", "").replace("preset = \"sinumerik\"\n", "preset = \"cnc\"\n");
    let nodes = "[nodes]\nverdict = \"/own:Watch/own:Verdict\"\nheartbeat = \"/own:Watch/own:Heartbeat\"\nhold_object = \"/own:Watch\"\nhold_method = \"/own:Watch/own:Hold\"\nline = \"/own:Program/own:Line\"\n[namespaces]\nown = \"urn:test:own\"\n";
    let (text, _) = text.split_once("[nodes]").unwrap();
    let config = Config::parse(&place.path("live.toml"), &format!("{text}{nodes}")).unwrap();
    let run = place.program(&scene, COLLIDES);
    let mut control = Control::start(&scene, run, config.clone(), patient(), socket);
    let mut watch = Watch::start(&scene, config, None, None);
    control.wait(|status| status.permitted && !status.stands);
    // The contact lasts for a moment, which a busy computer may miss; the latch stays.
    let report = watch.wait(|report| matches!(report.row.fault, "contact" | "latched"));
    assert!(report.row.line > 0, "the line comes by its path: {:?}", report.row);
    let stands = control.wait(|status| status.stands && !status.permitted && status.held);
    assert!(clearance_mm(&scene, &stands.place.position) > 0.0);
}

#[test]
fn a_node_that_the_control_lacks_or_that_cannot_tell_verdicts_apart_holds_and_is_named() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, CLEAR);
    let control = Control::start(&scene, run, config.clone(), Options { repeat: true, ..patient() }, socket);
    // The hold is a Boolean.
    let hold = "ns=2;s=/Channel/Parameter/R[u1,901]";
    for (node, id, expected) in [
        ("heartbeat", "ns=2;s=nobody", "ns=2;s=nobody"),
        ("heartbeat", hold, "R[u1,901] holds Boolean(true): give it a type of numbers from 0 to 127"),
        ("verdict", hold, "R[u1,901] holds Boolean(true): give it a type of numbers from 0 to 3"),
    ] {
        let wrong = place.config(control.address, "", &format!("{node} = \"{id}\"\n"));
        let mut watch = Watch::start(&scene, wrong, None, None);
        let report = watch.wait(|report| report.row.fault == "node");
        assert!(report.row.holds && report.row.message.contains(expected), "{:?}", report.row);
    }
}

/// A way to a control that can be cut.
struct Cable {
    address: SocketAddr,
    runtime: Runtime,
    cut: tokio::sync::watch::Sender<()>,
}

impl Cable {
    fn new(control: SocketAddr) -> Self {
        let runtime = Runtime::new().unwrap();
        // The same port on another address of the computer: a client keeps the port that the server names.
        let near = SocketAddr::from(([127, 0, 0, 2], control.port()));
        let listener = runtime.block_on(TcpListener::bind(near)).unwrap();
        let (cut, is_cut) = tokio::sync::watch::channel(());
        runtime.spawn(async move {
            while let Ok((mut client, _)) = listener.accept().await {
                let mut is_cut = is_cut.clone();
                is_cut.mark_unchanged();
                tokio::spawn(async move {
                    let mut server = tokio::net::TcpStream::connect(control).await.unwrap();
                    tokio::select! {
                        _ = tokio::io::copy_bidirectional(&mut client, &mut server) => {}
                        _ = is_cut.changed() => {}
                    }
                });
            }
        });
        Self { address: near, runtime, cut }
    }
}

/// The next connection is there at once. A library that takes it by itself goes on with values from before and behind a gap.
#[test]
#[cfg(target_os = "linux")]
fn a_connection_that_is_cut_is_told_even_when_there_is_another_at_once() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, CLEAR);
    let control = Control::start(&scene, run, config, Options { repeat: true, ..patient() }, socket);
    let cable = Cable::new(control.address);
    let log = place.path("log.csv");
    let mut watch = Watch::start(&scene, place.config(cable.address, "", ""), Some(log.clone()), None);
    watch.wait(|report| !report.row.holds);
    cable.cut.send_replace(());
    watch.wait(|report| report.row.fault == "lost");
    watch.wait(|report| !report.row.holds);
    assert!(watch.end().connections >= 2);
    cable.runtime.shutdown_background();
}

#[test]
fn a_watch_that_is_stopped_holds() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, CLEAR);
    // A deadline that never comes: the hold alone stops the machine.
    let patient_config = Config { deadline_s: 1e6, ..config.clone() };
    let mut control =
        Control::start(&scene, run, patient_config, Options { repeat: true, ..Options::default() }, socket);
    let mut watch = Watch::start(&scene, config, None, None);
    watch.wait(|report| !report.row.holds);
    control.wait(|status| status.permitted && !status.held);
    watch.end();
    control.wait(|status| status.held && status.stands);
}

#[test]
#[cfg(unix)]
fn a_watch_that_is_terminated_holds_and_ends_well() {
    let (scene, place, socket) = (scene(), Place::new(), listen());
    let config = place.config(socket.1, "", "");
    let run = place.program(&scene, CLEAR);
    let slow = Config { deadline_s: 1e6, ..config };
    let file = place.path("watch.toml");
    fs::write(&file, Place::text(socket.1, "", "")).unwrap();
    let mut control = Control::start(&scene, run, slow, Options { repeat: true, ..Options::default() }, socket);
    let mut watch = std::process::Command::new(env!("CARGO_BIN_EXE_bvbench-live"))
        .args(["watch".as_ref(), file.as_os_str()])
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    control.wait(|status| status.permitted && !status.held);
    let sent = std::process::Command::new("kill").args(["-TERM", &watch.id().to_string()]).status().unwrap();
    assert!(sent.success() && watch.wait().unwrap().success());
    control.wait(|status| status.held && status.stands);
}

#[test]
fn a_trace_never_replaces_what_is_read() {
    let place = Place::new();
    let file = place.path("live.toml");
    fs::write(&file, Place::text(listen().1, "", "")).unwrap();
    let before = fs::read(&file).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_bvbench-live"))
        .args(["control".as_ref(), file.as_os_str(), "--trace".as_ref(), file.as_os_str()])
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && told.contains("would replace what is read"), "{told}");
    assert_eq!(fs::read(&file).unwrap(), before);
}
