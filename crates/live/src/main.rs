//! The command line of the watch, the simulated control and the measurement of their latency.

use anyhow::{Context as _, Result, anyhow, bail};
use bvbench::cli::refuse_output;
use bvbench::record::file::write_bytes;
use bvbench::registry::{self, Registry, Variant};
use bvbench::scene::{Overrides, ProgramRun, Scene};
use bvbench_live::config::{Config, Mode};
use bvbench_live::figure::Figure;
use bvbench_live::judge::Judge;
use bvbench_live::latency::{self, Budget, LatencyRow};
use bvbench_live::monitor::Monitor;
use bvbench_live::numbers::{YEAR_S, between, share};
use bvbench_live::planted::Exact;
use bvbench_live::relay::Network;
use bvbench_live::soak::{self, Soak};
use bvbench_live::{control, panel, watch};
use clap::{Args, Parser, Subcommand};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

/// Exit code for bad usage, bad input, and output that cannot be written.
const BAD_INPUT: u8 = 2;

/// Watches a machine tool over OPC UA and holds it before it collides.
#[derive(Parser)]
#[command(name = "bvbench-live", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

const EXAMPLES: &str = "\
Examples:
  bvbench-live control live.toml part.ngc          play a program on a simulated control
  bvbench-live watch live.toml --panel 8080        watch it, with a panel in the browser
  bvbench-live latency live.toml part.ngc --out D  how long from a sample to its verdict

docs/live.md describes the configuration, the rules and the security.
Exit codes: 0 all is well; 2 bad usage or input, or output that cannot be written.";

#[derive(Subcommand)]
enum Verb {
    /// Watch a control: judge every sample, write the verdict, give the hold
    Watch(WatchOptions),
    /// Simulate a control that plays a program and obeys the hold
    Control(ControlOptions),
    /// Measure how long from a sample to its verdict
    Latency(LatencyOptions),
    /// Draw the figure of a latency.csv again, without measuring
    Redraw(RedrawOptions),
    /// Run control and watch for long, plant collisions, kill either side, delay and lose
    Soak(SoakOptions),
}

const WATCH_EXAMPLES: &str = "\
Examples:
  bvbench-live watch live.toml                     until Ctrl-C or SIGTERM, which hold the machine
  bvbench-live watch live.toml --log watch.csv     a row per sample
  bvbench-live watch live.toml --panel 8080        panel at http://127.0.0.1:8080/";

#[derive(Args)]
#[command(after_help = WATCH_EXAMPLES)]
struct WatchOptions {
    /// Configuration, TOML
    config: PathBuf,
    /// Log, CSV: a row per sample and per fault, behind those of earlier runs; a log that cannot be written holds the machine
    #[arg(long)]
    log: Option<PathBuf>,
    /// Port of the panel on the loopback address
    #[arg(long)]
    panel: Option<u16>,
    /// Folder of certificates, instead of that of the configuration
    #[arg(long)]
    pki: Option<PathBuf>,
    /// Seconds after which the watch ends; without it, at Ctrl-C
    #[arg(long = "for", value_parser = between(YEAR_S, "s"))]
    seconds: Option<f64>,
}

const CONTROL_EXAMPLES: &str = "\
Examples:
  bvbench-live control live.toml part.ngc          play once
  bvbench-live control live.toml part.ngc --repeat --drop 0.01 --late 0.01
  bvbench-live control live.toml part.ngc --restart-every 10
  bvbench-live control live.toml                   the program of the scene";

#[derive(Args)]
#[command(after_help = CONTROL_EXAMPLES)]
struct ControlOptions {
    /// Configuration, TOML
    config: PathBuf,
    /// Program, G-code; without it, that of the scene
    program: Option<PathBuf>,
    #[command(flatten)]
    disturbances: control::Options,
}

const LATENCY_EXAMPLES: &str = "\
Examples:
  bvbench-live latency live.toml part.ngc --out results/live
  bvbench-live latency live.toml --out D --variants obb-area,aabb --network-s 0";

#[derive(Args)]
#[command(after_help = LATENCY_EXAMPLES)]
struct LatencyOptions {
    /// Configuration, TOML
    config: PathBuf,
    /// Program, G-code; without it, that of the scene
    program: Option<PathBuf>,
    /// Folder for latency.csv and latency.svg
    #[arg(long)]
    out: PathBuf,
    /// Variants, by id; without it, the paper's five and the fastest
    #[arg(long, value_delimiter = ',')]
    variants: Vec<String>,
    #[command(flatten)]
    budget: Budget,
}

#[derive(Args)]
struct RedrawOptions {
    /// Folder of latency.csv, for latency.svg
    #[arg(long)]
    out: PathBuf,
}

const SOAK_EXAMPLES: &str = "\
Examples:
  bvbench-live soak live.toml part.ngc --out D --minutes 30 --planted 20
  bvbench-live soak live.toml part.ngc --out D --kills 20
  bvbench-live soak live.toml part.ngc --out D --minutes 0.5 --delay-ms 2 --loss 0.01";

#[derive(Args)]
#[command(after_help = SOAK_EXAMPLES)]
struct SoakOptions {
    /// Configuration, TOML, without security
    config: PathBuf,
    /// Program, G-code; without it, that of the scene
    program: Option<PathBuf>,
    /// Folder for soak.csv and planted.csv, where rows about the same are replaced, and claims.csv
    #[arg(long)]
    out: PathBuf,
    /// Variant, by id; without it, the fastest
    #[arg(long)]
    variant: Option<String>,
    /// Minutes that the program is played, to and fro
    #[arg(long, default_value_t = 0.0, value_parser = between(24.0 * 60.0, "minutes"))]
    minutes: f64,
    /// Collisions to plant
    #[arg(long, default_value_t = 0)]
    planted: u32,
    /// Kills of the watch, and as many of the control, each before a planted collision
    #[arg(long, default_value_t = 0)]
    kills: u32,
    /// Delay of the network each way, ms
    #[arg(long, default_value_t = 0.0, value_parser = between(10_000.0, "ms"))]
    delay_ms: f64,
    /// Share of what is sent that is lost and sent again after 0.2 s, 0 to 1
    #[arg(long, default_value_t = 0.0, value_parser = share)]
    loss: f64,
    /// Seed of collisions, kills and losses
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The five volumes of the paper.
const PAPER: [&str; 5] = ["sphere-ritter", "aabb", "dop-8", "obb-vertex", "obb-area"];

fn main() -> ExitCode {
    let done = match Arguments::parse().verb {
        Verb::Watch(options) => watch_verb(options),
        Verb::Control(options) => control_verb(&options),
        Verb::Latency(options) => latency_verb(&options),
        Verb::Redraw(options) => redraw_verb(&options),
        Verb::Soak(options) => soak_verb(options),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("error: {error:#}"));
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// A line to people, who are on the other stream than data.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").ok();
}

fn load(path: &Path) -> Result<(Config, Arc<Scene>)> {
    let config = Config::read(path)?;
    let scene = Scene::find_with(&config.scene, &Overrides::default())?;
    Ok((config, Arc::new(scene)))
}

fn program(scene: &Scene, path: Option<&Path>) -> Result<ProgramRun> {
    let own = scene.program.as_ref();
    match (path, own) {
        (Some(path), Some(own)) => Ok(own.with_program(path)?),
        (Some(path), None) => Ok(ProgramRun::of_mill().with_program(path)?),
        (None, Some(own)) => Ok(own.clone()),
        (None, None) => bail!("scene `{}` has no program: name one", scene.name),
    }
}

fn variant<'a>(registry: &'a Registry, id: Option<&str>) -> Result<&'a Variant> {
    match id {
        Some(id) => registry.find(id).with_context(|| format!("there is no variant `{id}`; `bvbench list` names them")),
        None => registry.fastest().context("the registry is empty"),
    }
}

/// Waits until somebody wants the process to end: Ctrl-C, or SIGTERM, with which services are ended.
async fn asked_to_end() -> std::io::Result<()> {
    #[cfg(unix)]
    {
        let mut terminate = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
        tokio::select! {
            done = tokio::signal::ctrl_c() => done,
            _ = terminate.recv() => Ok(()),
        }
    }
    #[cfg(not(unix))]
    tokio::signal::ctrl_c().await
}

/// Cancels when asked to end, or after some seconds.
fn end(stop: CancellationToken, seconds: Option<f64>) {
    tokio::spawn(async move {
        let wait = async {
            match seconds {
                Some(seconds) => tokio::time::sleep(Duration::from_secs_f64(seconds)).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = asked_to_end() => {}
            () = wait => {}
        }
        stop.cancel();
    });
}

fn watch_verb(options: WatchOptions) -> Result<()> {
    let (config, scene) = load(&options.config)?;
    let registry = registry::standard();
    let chosen = variant(&registry, config.variant.as_deref())?;
    let judge = Judge::new(&scene, chosen, config.rule(&scene)?)?;
    say(&format!("scene {}, variant {}: {} pairs watched", scene.name, chosen.info.id, judge.pairs().count()));
    for part in judge.open_parts() {
        say(&format!(
            "warning: part {} is not watertight; what lies wholly inside it is not seen",
            scene.parts[part].name
        ));
    }
    if scene.parts.iter().any(|part| part.role.is_of_tool()) {
        say("note: what a spindle turns is judged as drawn, and not at every angle");
    }
    let monitor = Monitor::new(&scene, judge, &config);
    let runtime = tokio::runtime::Runtime::new()?;
    let summary = runtime.block_on(async {
        let (reports, newest) = tokio::sync::watch::channel(None);
        let stop = CancellationToken::new();
        end(stop.clone(), options.seconds);
        tokio::spawn(tell(newest.clone()));
        if let Some(port) = options.panel {
            let listener = TcpListener::bind(("127.0.0.1", port)).await.context("the panel's port")?;
            say(&format!("panel at http://{}/", listener.local_addr()?));
            tokio::spawn(panel::serve(listener, Arc::clone(&scene), config.near_mm, newest));
        }
        let settings = watch::Settings { log: options.log, pki: options.pki, reports, stop };
        watch::run(&scene, monitor, &config, settings).await.map_err(|error| anyhow!(error))
    })?;
    let watch::Summary { judged, superseded, late, holds, connections } = summary;
    say(&format!(
        "{judged} samples judged, {superseded} superseded, {late} late; {holds} holds, {connections} connections"
    ));
    Ok(())
}

/// Tells each change of the hold.
async fn tell(mut reports: tokio::sync::watch::Receiver<Option<watch::Report>>) {
    let mut last = None;
    while reports.changed().await.is_ok() {
        let Some((holds, fault, message, line)) = reports
            .borrow_and_update()
            .as_ref()
            .map(|report| (report.row.holds, report.row.fault, report.row.message.clone(), report.row.line))
        else {
            continue;
        };
        if last != Some((holds, fault)) {
            let what = if holds { format!("hold: {message}") } else { "free".to_owned() };
            say(&if line > 0 { format!("line {line}: {what}") } else { what });
            last = Some((holds, fault));
        }
    }
}

fn control_verb(options: &ControlOptions) -> Result<()> {
    let (config, scene) = load(&options.config)?;
    let run = program(&scene, options.program.as_deref())?;
    if let Some(trace) = &options.disturbances.trace {
        let files = [options.config.clone(), run.file.clone()].into_iter().chain(scene.files.clone());
        let read: Vec<PathBuf> = files.chain(run.called_files()).collect();
        // A trace may lie in the folder of the scene, where that of an earlier run is replaced.
        refuse_output("--trace", trace, "", read.iter().map(PathBuf::as_path))?;
    }
    let address = config.endpoint.trim_start_matches("opc.tcp://").split('/').next().unwrap_or_default().to_owned();
    tokio::runtime::Runtime::new()?.block_on(async {
        let found = tokio::net::lookup_host(&address).await.ok().and_then(|mut found| found.next());
        let found = found.with_context(|| format!("{address} is no address of this computer"))?;
        let listener = control::listen(found).with_context(|| format!("cannot listen on {address}"))?;
        say(&format!("{} plays {} at {}", scene.name, run.file.display(), config.endpoint));
        let (status, newest) = tokio::sync::watch::channel(None);
        let stop = CancellationToken::new();
        end(stop.clone(), None);
        control::control(&scene, &run, &config, &options.disturbances, listener, status, stop).await?;
        if let Some(status) = newest.borrow().as_ref() {
            let control::Status { holds, is_over, place, .. } = status;
            let end = if *is_over { "the program is over" } else { "stopped" };
            say(&format!("{end} at line {}; held {holds} times", place.line));
        }
        Ok(())
    })
}

fn latency_verb(options: &LatencyOptions) -> Result<()> {
    let (config, scene) = load(&options.config)?;
    let run = program(&scene, options.program.as_deref())?;
    let registry = registry::standard();
    let fastest = variant(&registry, None)?;
    let variants = if options.variants.is_empty() {
        let paper: Result<Vec<&Variant>> = PAPER.iter().map(|id| variant(&registry, Some(id))).collect();
        let mut all = paper?;
        all.push(fastest);
        all
    } else {
        options.variants.iter().map(|id| variant(&registry, Some(id))).collect::<Result<_>>()?
    };
    let mut told = |row: &LatencyRow| {
        let ms = |ns: u64| ns as f64 / 1e6;
        say(&format!(
            "{:<8} {:<14} {} ms {} {}: {} samples, p50 {:.3} ms, p99 {:.3} ms, p99.9 {:.3} ms, max {:.3} ms, late {}",
            row.way,
            row.variant,
            row.cycle_ns / 1_000_000,
            row.load,
            row.cache,
            row.samples,
            ms(row.p50_ns),
            ms(row.p99_ns),
            ms(row.p999_ns),
            ms(row.max_ns),
            row.late
        ));
    };
    let rows = latency::measure(&scene, &run, &config, &variants, &options.budget, &mut told)?;
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    write_bytes(&options.out.join("latency.csv"), &writer.into_inner().map_err(|error| anyhow!("{error}"))?)?;
    draw(&options.out, &rows)
}

fn redraw_verb(options: &RedrawOptions) -> Result<()> {
    let path = options.out.join("latency.csv");
    let read = || csv::Reader::from_path(&path)?.deserialize().collect::<Result<Vec<LatencyRow>, csv::Error>>();
    let rows = read().with_context(|| format!("cannot read {}: `bvbench-live latency` measures it", path.display()))?;
    draw(&options.out, &rows)
}

fn draw(out: &Path, rows: &[LatencyRow]) -> Result<()> {
    let figure = bvbench::plot::canvas::svg(&Figure(rows)).map_err(|error| anyhow!(error))?;
    write_bytes(&out.join("latency.svg"), figure.as_bytes())?;
    Ok(())
}

fn soak_verb(options: SoakOptions) -> Result<()> {
    let (config, scene) = load(&options.config)?;
    if config.security.mode != Mode::None {
        bail!("{}: a soak has no certificates: leave [security] out", options.config.display());
    }
    let run = program(&scene, options.program.as_deref())?;
    let registry = registry::standard();
    let chosen = variant(&registry, options.variant.as_deref())?;
    let judge = Judge::new(&scene, chosen, config.rule(&scene)?)?;
    let exact = Exact::new(&scene, judge.pairs());
    let delay = Duration::from_secs_f64(options.delay_ms / 1e3);
    let settings = soak::Settings {
        out: options.out,
        variant: chosen.info.id.to_owned(),
        program_s: options.minutes * 60.0,
        planted: options.planted,
        kills: options.kills,
        network: Network { delay, loss: options.loss, seed: options.seed },
        seed: options.seed,
    };
    let program = options.program.as_deref();
    Soak { scene: &scene, config: &config, run: &run, program, settings: &settings }.run(&exact, &mut |line| say(line))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_are_finite_and_not_negative() {
        for [verb, option] in [
            ["watch", "--for"],
            ["control", "--jitter"],
            ["control", "--restart-every"],
            ["control", "--down"],
            ["control", "--patience"],
            ["latency", "--network-s"],
            ["latency", "--judge-s"],
        ] {
            let parse = |value: &str| {
                let value = format!("{option}={value}");
                let more: &[&str] = if verb == "latency" { &["--out", "D"] } else { &[] };
                let words = [&["bvbench-live", verb, "live.toml", value.as_str()], more].concat();
                Arguments::try_parse_from(words).map(drop)
            };
            assert!(parse("2").is_ok(), "{option}");
            for value in ["nan", "inf", "1e300", "-1"] {
                let refused = parse(value).unwrap_err().to_string();
                assert!(refused.contains("are not between 0 and"), "{option} {value}: {refused}");
            }
        }
    }
}
