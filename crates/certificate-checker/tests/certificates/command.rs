//! The command: what it prints and how it ends.

use crate::fixture::{cube, folder, lines, signed, with_word, written};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Output, error output and exit code.
fn run(arguments: &[&str], input: &str) -> (String, String, i32) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_certificate-checker"));
    let command = command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // A command that does not read its input has closed it.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    let output = child.wait_with_output().unwrap();
    let [out, error] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (out, error, output.status.code().unwrap())
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn an_accepted_certificate_is_told_with_what_it_leaves_out() {
    let mill = folder("mill");
    let (cert, program) = (mill.join("mill.cert"), mill.join("program.ngc"));
    let (out, error, code) = run(&[path(&cert), "--scene", path(&mill), "--program", path(&program)], "");
    assert_eq!((code, &*error), (0, ""));
    assert!(out.starts_with("not examined: base:saddle, neighbours\n"), "{out}");
    assert!(out.contains("\ncollision: 1 blocks, lines 12\nunresolved: 1 blocks, lines 13\n"), "{out}");
    assert!(out.ends_with("\naccepted: 11 of 13 blocks are free, by 80 intervals of 21 pairs; in 5 blocks a cutter feeds, where it may be in the workpiece\n"), "{out}");
    assert!(!out.contains("its program is"), "{out}");
    // From standard input, without files, and with nothing that collides.
    let (out, _, code) = run(&["-"], &signed(&lines("five-axis")));
    assert_eq!(code, 0);
    assert!(out.ends_with("\naccepted: 8 of 8 blocks are free, by 30 intervals of 3 pairs\n"), "{out}");
    assert!(!out.contains("collision") && out.contains("its program is `program.ngc`"), "{out}");
}

#[test]
fn the_first_40_lines_are_named() {
    let cubes = cube("a - fixture - 1 0 0 0 0 0 0", [0.0; 3], 1.0) + &cube("b s holder - 1 0 0 0 0 0 0", [9.0; 3], 1.0);
    let told = |count: usize| {
        let steps: String = (1..=count).map(|line| format!("point {line} 1\n")).collect();
        let text = format!("slide s - 1 0 0 0 0 0 0 X 1 0 0\n{cubes}{steps}pair a b examined\nopen {count} 0\n");
        run(&["-"], &written(&text)).0
    };
    let named = (1..=40).map(|line| line.to_string()).collect::<Vec<_>>().join(" ");
    assert!(told(40).contains(&format!("\nunresolved: 40 blocks, lines {named}\n")), "{}", told(40));
    assert!(told(41).contains(&format!("\nunresolved: 41 blocks, lines {named} ...\n")), "{}", told(41));
}

#[test]
fn a_refused_certificate_is_told_by_its_line() {
    let mut lines = lines("five-axis");
    lines[1] = with_word(&lines[1], 0, "mode");
    let (out, _, code) = run(&["-"], &signed(&lines));
    assert_eq!((code, &*out), (1, "-:2: refused: no such keyword\n"));
    let mill = folder("mill");
    let cert = folder("five-axis").join("five-axis.cert");
    let (out, _, code) = run(&[path(&cert), "--scene", path(&mill)], "");
    assert!(code == 1 && out.contains("five-axis.cert:") && out.contains(": refused: "), "{out}");
    let (out, _, code) = run(&[path(&cert), "--program", path(&mill.join("program.ngc"))], "");
    assert!(code == 1 && out.contains("is not the program of the certificate"), "{out}");
}

#[test]
fn bad_usage_ends_with_two() {
    let (out, _, code) = run(&["--help"], "");
    assert!(code == 0 && out.contains("Usage: certificate-checker CERTIFICATE"), "{out}");
    assert!(out.contains("0 accepted, also where blocks are `collision`"), "{out}");
    assert_eq!(run(&["-h"], "").0, out);
    let (_, error, code) = run(&[], "");
    assert!(code == 2 && error.contains("Usage"), "{error}");
    let (_, error, code) = run(&["-", "--scene"], "");
    assert!(code == 2 && error.starts_with("--scene needs a value"), "{error}");
    // A mistyped option is no certificate, and there is but one.
    for more in [["--scne", "folder"], ["one.cert", "two.cert"]] {
        let (_, error, code) = run(&[more[0], more[1], "-"], "");
        assert!(code == 2 && error.contains("is not understood"), "{error}");
    }
    let (_, error, code) = run(&["no-such-file.cert"], "");
    assert!(code == 2 && error.starts_with("no-such-file.cert: "), "{error}");
    // A mistyped path is no refusal of the certificate, and the system says what is wrong with it.
    let cert = signed(&lines("five-axis"));
    for (option, file) in [("--scene", "no-such"), ("--program", "no-such.ngc"), ("--program", ".")] {
        let (out, error, code) = run(&["-", option, file], &cert);
        let why = if file == "." { "no regular file" } else { "(os error" };
        assert!(code == 2 && out.is_empty() && error.starts_with(option) && error.contains(why), "{out}{error}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn what_cannot_be_written_or_decoded_is_no_panic() {
    use std::os::unix::ffi::OsStrExt;
    let run = |arguments: &[&std::ffi::OsStr], out: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_certificate-checker"));
        command.args(arguments).stdout(out).stderr(Stdio::null()).status().unwrap().code()
    };
    let closed = || {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        Stdio::from(writer)
    };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let named = folder.join(std::ffi::OsStr::from_bytes(b"fr\xe4se.cert"));
    std::fs::write(&named, signed(&lines("five-axis"))).unwrap();
    let refused = folder.join("refused.cert");
    std::fs::write(&refused, "none").unwrap();
    let missing = folder.join("missing.cert");
    let scene = folder.join(std::ffi::OsStr::from_bytes(b"\xe4"));
    for (file, code) in [(&named, 0), (&refused, 1), (&missing, 2)] {
        // A reader that has gone away has read what it asked for.
        assert_eq!(run(&[file.as_os_str()], closed()), Some(code), "{}", file.display());
    }
    assert_eq!(run(&[named.as_os_str(), "--scene".as_ref(), scene.as_os_str()], Stdio::null()), Some(2));
    assert_eq!(run(&[std::ffi::OsStr::from_bytes(b"--\xe4")], closed()), Some(2));
    if let Ok(full) = std::fs::File::create("/dev/full") {
        assert_eq!(run(&[named.as_os_str()], full.into()), Some(2));
    }
}
