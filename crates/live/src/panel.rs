//! The operator's panel: a page on the loopback address, fed by server-sent events.
//!
//! It answers two paths: `/` (the page, with the boxes of the parts in it) and `/events` (the newest report, at most twenty a second). Requests for another
//! host than the loopback address are refused, so that no page from elsewhere can read it.

use crate::judge::is_driven;
use crate::watch::Report;
use bvbench::scene::{Role, Scene};
use serde_json::json;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

const PAGE: &str = include_str!("panel.html");
/// Longest request that is read, bytes.
const LONGEST: usize = 8192;
/// Time between two events.
const PACE: Duration = Duration::from_millis(50);
/// Browsers that are served at the same time.
const BROWSERS: usize = 16;

/// Serves the panel until the reports end.
pub async fn serve(listener: TcpListener, scene: Arc<Scene>, near_mm: f64, reports: watch::Receiver<Option<Report>>) {
    let page = Arc::new(PAGE.replace("\"SCENE\"", &shown(&scene, near_mm).replace("</", "<\\/")));
    let places = Arc::new(tokio::sync::Semaphore::new(BROWSERS));
    while let Ok((stream, _)) = listener.accept().await {
        let Ok(place) = Arc::clone(&places).try_acquire_owned() else { continue };
        let (page, scene, reports) = (Arc::clone(&page), Arc::clone(&scene), reports.clone());
        tokio::spawn(async move {
            // A browser that goes away ends its own task alone.
            answer(stream, &page, &scene, reports).await.ok();
            drop(place);
        });
    }
}

async fn answer(
    mut stream: TcpStream,
    page: &str,
    scene: &Scene,
    reports: watch::Receiver<Option<Report>>,
) -> std::io::Result<()> {
    let request = tokio::time::timeout(Duration::from_secs(5), head(&mut stream)).await??;
    let mut lines = request.lines();
    let path = lines.next().and_then(|line| line.strip_prefix("GET ")).and_then(|rest| rest.split(' ').next());
    let host =
        lines.find_map(|line| line.to_ascii_lowercase().strip_prefix("host:").map(|host| host.trim().to_owned()));
    let is_local = host.is_some_and(|host| ["127.0.0.1", "localhost"].contains(&host.split(':').next().unwrap_or("")));
    match path {
        _ if !is_local => respond(&mut stream, "403 Forbidden", "text/plain", "for the loopback address alone\n").await,
        Some("/") => respond(&mut stream, "200 OK", "text/html; charset=utf-8", page).await,
        Some("/events") => events(&mut stream, scene, reports).await,
        _ => respond(&mut stream, "404 Not Found", "text/plain", "not here\n").await,
    }
}

async fn head(stream: &mut TcpStream) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    let mut buffer = [0; 1024];
    while !bytes.windows(4).any(|end| end == b"\r\n\r\n") {
        let read = stream.read(&mut buffer).await?;
        if read == 0 || bytes.len() + read > LONGEST {
            return Err(std::io::ErrorKind::InvalidData.into());
        }
        bytes.extend_from_slice(&buffer[..read]);
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

async fn respond(stream: &mut TcpStream, status: &str, kind: &str, body: &str) -> std::io::Result<()> {
    let length = body.len();
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\nX-Content-Type-Options: nosniff\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).await?;
    stream.write_all(body.as_bytes()).await?;
    stream.shutdown().await
}

async fn events(
    stream: &mut TcpStream,
    scene: &Scene,
    mut reports: watch::Receiver<Option<Report>>,
) -> std::io::Result<()> {
    let head =
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n";
    stream.write_all(head.as_bytes()).await?;
    loop {
        let event = reports.borrow_and_update().as_ref().map(|report| event(scene, report));
        if let Some(event) = event {
            stream.write_all(format!("data: {event}\n\n").as_bytes()).await?;
        }
        tokio::time::sleep(PACE).await;
        if reports.changed().await.is_err() {
            return Ok(());
        }
    }
}

/// A report as JSON, with the pose of every part as the twelve numbers of a matrix, by rows.
fn event(scene: &Scene, report: &Report) -> String {
    let poses = scene.machine.forward(&report.outcome.position);
    let matrix = |part: usize| {
        let pose = scene.world_from_part(part, &poses).to_homogeneous();
        (0..3).flat_map(|row| (0..4).map(move |column| (row, column))).map(|at| pose[at]).collect::<Vec<f64>>()
    };
    let axes = rs274::Axis::ALL.into_iter().filter(|&axis| is_driven(&scene.machine, axis));
    let axes: Vec<_> = axes
        .map(|axis| {
            let value = report.outcome.position[axis];
            let (value, unit) = if axis.is_rotary() { (value.to_degrees(), "°") } else { (value, "mm") };
            json!({ "axis": axis.letter().to_string(), "value": value, "unit": unit })
        })
        .collect();
    json!({
        "row": report.row,
        "axes": axes,
        "poses": (0..scene.parts.len()).map(matrix).collect::<Vec<_>>(),
    })
    .to_string()
}

/// The parts as their boxes, and the clearance of a full bar, JSON.
fn shown(scene: &Scene, near_mm: f64) -> String {
    let part = |part: &bvbench::scene::Part| {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for vertex in part.mesh.vertices() {
            for i in 0..3 {
                (low[i], high[i]) = (low[i].min(vertex[i]), high[i].max(vertex[i]));
            }
        }
        json!({ "name": part.name, "low": low, "high": high, "tool": part.role.is_of_tool(), "work": part.role == Role::Workpiece })
    };
    json!({ "name": scene.name, "near_mm": near_mm, "parts": scene.parts.iter().map(part).collect::<Vec<_>>() })
        .to_string()
}
