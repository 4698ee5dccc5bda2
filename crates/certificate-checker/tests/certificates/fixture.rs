//! Certificates to read and to change.

use certificate_checker::{MOST_WORK, Refusal, Report, check};
use std::path::{Path, PathBuf};

/// The scenes with their certificates.
pub const NAMES: [&str; 2] = ["mill", "five-axis"];

/// The folder of a scene.
pub fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

/// The lines of a scene's certificate.
pub fn lines(name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder(name).join(format!("{name}.cert"))).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// The lines as a file, with the hash that its content has now.
pub fn signed(lines: &[String]) -> String {
    let body: String =
        lines.iter().filter(|line| !line.starts_with("end ")).map(|line| line.to_owned() + "\n").collect();
    format!("{body}end {}\n", blake3::hash(body.as_bytes()).to_hex())
}

/// Checks a text without any files.
pub fn checked(text: &str) -> Result<Report, Refusal> {
    check(text, None, None, MOST_WORK)
}

/// Fails unless the text is accepted.
#[track_caller]
pub fn accepted(text: &str) -> Report {
    checked(text).unwrap_or_else(|Refusal { line, why }| panic!("line {line}: {why}: {:?}", text.lines().nth(line - 1)))
}

/// Fails unless the text is refused at this line, from 1, for this reason.
#[track_caller]
pub fn refused(text: &str, line: usize, why: &str) {
    match checked(text) {
        Ok(_) => panic!("accepted, not refused at {:?}", text.lines().nth(line - 1)),
        Err(refusal) => assert_refusal(&refusal, line, why),
    }
}

/// Fails unless the refusal names this line and this reason.
#[track_caller]
pub fn assert_refusal(refusal: &Refusal, line: usize, why: &str) {
    assert!(refusal.line == line && refusal.why.contains(why), "line {line}, {why}: {refusal:?}");
}

/// The index of the first line that begins with some words.
#[track_caller]
pub fn find(lines: &[String], words: &str) -> usize {
    lines.iter().position(|line| line.starts_with(words)).unwrap()
}

/// The line with one of its words, from 0, changed.
pub fn with_word(line: &str, at: usize, word: &str) -> String {
    let mut words: Vec<&str> = line.split(' ').collect();
    words[at] = word;
    words.join(" ")
}

/// A file of these lines behind the first, with its hash.
pub fn written(body: &str) -> String {
    signed(&format!("bvbench-certificate 3\n{body}").lines().map(str::to_owned).collect::<Vec<_>>())
}

/// Faces of a box; its vertex `i` is high in X, Y and Z where the bits 4, 2 and 1 of `i` are set. Two faces each at -X, +X, -Y, +Y, -Z, +Z.
pub const FACES: [[usize; 3]; 12] = [
    [0, 1, 3],
    [0, 3, 2],
    [4, 6, 7],
    [4, 7, 5],
    [0, 4, 5],
    [0, 5, 1],
    [2, 3, 7],
    [2, 7, 6],
    [0, 2, 6],
    [0, 6, 4],
    [1, 5, 7],
    [1, 7, 3],
];

/// The vertices of a cube about a centre, mm, as lines.
pub fn corners(centre: [f64; 3], half: f64) -> String {
    let side =
        |i: usize, bit: usize, x: f64| ((if i & bit == 0 { x - half } else { x + half }) * f64::from(1 << 26)) as i64;
    let [x, y, z] = centre;
    (0..8).map(|i| format!("v {} {} {}\n", side(i, 4, x), side(i, 2, y), side(i, 1, z))).collect()
}

/// Faces of a box as lines, its vertices counted from `first`; turned inside out where it is a cavity.
pub fn faces(first: usize, is_cavity: bool) -> String {
    let face = |[i, j, k]: [usize; 3]| {
        let [i, j, k] = if is_cavity { [k, j, i] } else { [i, j, k] };
        format!("f {} {} {}\n", first + i, first + j, first + k)
    };
    FACES.into_iter().map(face).collect()
}

/// A cube as a part: `head` is what its line says.
pub fn cube(head: &str, centre: [f64; 3], half: f64) -> String {
    format!("part {head}\n{}{}", corners(centre, half), faces(0, false))
}
