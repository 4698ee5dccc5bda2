//! Records what the program was built from, for the manifest: compiler, flags, source, git revision.

#[path = "crates/harness/src/measure/sources.rs"]
mod sources;

use std::path::Path;
use std::process::Command;

fn main() {
    for source in sources::SOURCES {
        println!("cargo:rerun-if-changed={source}");
    }
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    set("RUSTC", &version(&rustc).unwrap_or_default());
    set("TARGET", &std::env::var("TARGET").unwrap_or_default());
    set("OPT_LEVEL", &std::env::var("OPT_LEVEL").unwrap_or_default());
    set("RUSTFLAGS", &std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default().replace('\u{1f}', " "));
    let root = Path::new(".");
    set("FINGERPRINT", &sources::fingerprint(root).map(|number| number.to_string()).unwrap_or_default());
    let (revision, dirty) = sources::checkout(root).unzip();
    set("GIT_REVISION", &revision.unwrap_or_default());
    set("GIT_DIRTY", &dirty.map(|dirty| dirty.to_string()).unwrap_or_default());
}

fn set(name: &str, value: &str) {
    println!("cargo:rustc-env=BVBENCH_{name}={value}");
}

fn version(rustc: &str) -> Option<String> {
    let output = Command::new(rustc).arg("--version").output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
