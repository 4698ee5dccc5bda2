//! Records what the program was built from, for the manifest: compiler, flags, git revision.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=src");
    println!("cargo:rerun-if-changed=crates");
    println!("cargo:rerun-if-changed=.git/HEAD");
    println!("cargo:rerun-if-changed=.git/logs/HEAD");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    set("BVBENCH_RUSTC", &output(&rustc, &["--version"]).unwrap_or_default());
    set("BVBENCH_TARGET", &std::env::var("TARGET").unwrap_or_default());
    set("BVBENCH_OPT_LEVEL", &std::env::var("OPT_LEVEL").unwrap_or_default());
    let flags = std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default().replace('\u{1f}', " ");
    set("BVBENCH_RUSTFLAGS", &flags);
    // Only a checkout of this very package counts: a crate in a registry folder may lie below somebody else's repository.
    let own_checkout = std::path::Path::new(".git").exists();
    let git = |args: &[&str]| own_checkout.then(|| output("git", args)).flatten();
    set("BVBENCH_GIT_REVISION", &git(&["rev-parse", "HEAD"]).unwrap_or_default());
    // New files count where programs are made of them: a volume that nobody has committed is a local change.
    let tracked = git(&["status", "--porcelain", "--untracked-files=no"]);
    let sources = git(&["status", "--porcelain", "--", "src", "crates", "examples", "benches"]);
    let changes = tracked.zip(sources).map(|(tracked, sources)| tracked + &sources);
    set("BVBENCH_GIT_DIRTY", changes.map_or("unknown", |text| if text.is_empty() { "no" } else { "yes" }));
}

fn set(name: &str, value: &str) {
    println!("cargo:rustc-env={name}={value}");
}

fn output(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program).args(args).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
