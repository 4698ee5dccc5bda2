//! The walls between the rooms, read off the source: which module may name which, who may print, who may read a clock.
//!
//! Comments and string literals do not count; nor do modules that only tests see (`#[cfg(test)] mod tests { .. }` at the end of a
//! file, and the files of `#[cfg(test)] mod name;`), which may use whatever they like. A variant's id is looked for in
//! string literals, and there too tests may name the variants they are about.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::registry;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One source file without comments, literals and tests.
struct Source {
    path: PathBuf,
    /// The top-level module it belongs to: `tree` for `src/tree/build.rs`, `record` for `crates/record/src/record/rows.rs`.
    module: String,
    code: String,
    literals: Vec<String>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The sources of the harness, its crates in the order in which they know one another.
fn roots() -> [PathBuf; 4] {
    ["../crates/record/src", "../crates/scene/src", "../crates/harness/src", ""].map(|folder| root().join(folder))
}

fn sources() -> Vec<Source> {
    let mut files = Vec::new();
    roots().iter().for_each(|root| collect(root, &mut files));
    files.sort();
    let texts: Vec<(PathBuf, String)> =
        files.into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect();
    let test_modules: Vec<PathBuf> = texts.iter().flat_map(|(path, text)| test_modules(path, text)).collect();
    let is_test =
        |path: &Path| test_modules.iter().any(|module| path.starts_with(module) || path == module.with_extension("rs"));
    texts
        .into_iter()
        .filter(|(path, _)| !is_test(path))
        .map(|(path, text)| {
            let (code, literals) = strip(text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default());
            let below = roots().iter().find_map(|root| path.strip_prefix(root).ok().map(Path::to_owned)).unwrap();
            let first = below.iter().next().unwrap().to_str().unwrap();
            let module = first.trim_end_matches(".rs").to_owned();
            Source { path, module, code, literals }
        })
        .collect()
}

/// The modules, as paths without extension, that a file declares for tests only: `#[cfg(test)] mod synthetic;`.
fn test_modules(path: &Path, text: &str) -> Vec<PathBuf> {
    let stem = path.file_stem().unwrap();
    let folder =
        if stem == "mod" || stem == "lib" { path.parent().unwrap().to_owned() } else { path.with_extension("") };
    text.split("#[cfg(test)]\n")
        .skip(1)
        .filter_map(|after| {
            let line = after.lines().next()?.trim_start_matches("pub(crate) ").trim_start_matches("pub ");
            Some(folder.join(line.strip_prefix("mod ")?.strip_suffix(';')?))
        })
        .collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The code without comments, with every string literal emptied; and the literals.
fn strip(text: &str) -> (String, Vec<String>) {
    let (mut code, mut literals) = (String::new(), Vec::new());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        if rest.starts_with("//") {
            rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
        } else if let Some(raw) = rest.strip_prefix("r#\"") {
            let end = raw.find("\"#").unwrap_or(raw.len());
            literals.push(raw[..end].to_owned());
            code.push_str("\"\"");
            rest = raw.get(end + 2..).unwrap_or_default();
        } else if let Some(string) = rest.strip_prefix('"') {
            let mut end = 0;
            let bytes = string.as_bytes();
            while end < bytes.len() && bytes[end] != b'"' {
                end += if bytes[end] == b'\\' { 2 } else { 1 };
            }
            literals.push(string.get(..end).unwrap_or(string).to_owned());
            code.push_str("\"\"");
            rest = string.get(end + 1..).unwrap_or_default();
        } else if rest.starts_with("'\"'") {
            code.push_str("' '");
            rest = &rest[3..];
        } else if rest.starts_with("'\\\"'") {
            code.push_str("' '");
            rest = &rest[4..];
        } else {
            code.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    (code, literals)
}

/// The modules of the harness, in reading order.
fn rooms() -> Vec<String> {
    let of = |root: &PathBuf| {
        let (code, _) = strip(&fs::read_to_string(root.join("lib.rs")).unwrap());
        let names = code
            .lines()
            .filter_map(|line| line.strip_prefix("pub mod "))
            .map(|name| name.trim_end_matches(';').to_owned());
        names.collect::<Vec<_>>()
    };
    roots().iter().flat_map(of).collect()
}

/// The top-level modules that a file names with a path from the crate's root, in `use` lines and elsewhere; `use crate::{a, b}`
/// counts for each.
fn imports(code: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (position, _) in code.match_indices("crate::") {
        let after = &code[position + "crate::".len()..];
        match after.strip_prefix('{') {
            Some(group) => {
                let mut depth = 0;
                let mut item = String::new();
                for c in group.chars() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => found.push(word(std::mem::take(&mut item).trim())),
                        _ if depth == 0 => item.push(c),
                        _ => {}
                    }
                }
                found.push(word(item.trim()));
            }
            None => found.push(word(after)),
        }
    }
    found.retain(|name| !name.is_empty());
    found
}

/// Every (file, module named) that breaks a rule, one per line.
fn offences(allowed: impl Fn(&Source, &str) -> bool) -> String {
    let mut lines = Vec::new();
    for source in sources() {
        for import in imports(&source.code) {
            if !allowed(&source, &import) {
                lines.push(format!("{} names crate::{import}", source.path.display()));
            }
        }
    }
    lines.join("\n")
}

/// Every file outside `exempt` whose code has one of the words.
fn files_with(words: &[&str], exempt: &[&str]) -> String {
    let has = |source: &Source| words.iter().find(|word| source.code.contains(**word)).copied();
    sources()
        .iter()
        .filter(|source| !exempt.contains(&source.module.as_str()))
        .filter_map(|source| has(source).map(|word| format!("{} has {word}", source.path.display())))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn the_reader_sees_what_the_compiler_sees() {
    let text = "use crate::a::{b, c}; // use crate::x;\nlet s = \"crate::y \\\" \"; use crate::{d::e, f, g::{h, i}};\n'\"'; \"z\"";
    let (code, literals) = strip(text);
    assert_eq!(imports(&code), ["a", "d", "f", "g"]);
    assert_eq!(literals, ["crate::y \\\" ", "z"]);
    let declared =
        test_modules(Path::new("src/a/mod.rs"), "mod b;\n#[cfg(test)]\npub(crate) mod c;\n#[cfg(test)]\nmod tests {");
    assert_eq!(declared, [Path::new("src/a/c")]);
    let (rooms, sources) = (rooms(), sources());
    assert!(rooms.len() > 10 && sources.len() > 50, "{} rooms, {} sources", rooms.len(), sources.len());
    for room in rooms {
        assert!(sources.iter().any(|source| source.module == room), "{room} has no source");
    }
    assert!(sources.iter().any(|source| imports(&source.code).contains(&"geometry".to_owned())));
}

#[test]
fn imports_point_up_the_list_of_modules() {
    let rooms = rooms();
    let place = |name: &str| rooms.iter().position(|room| room == name);
    let found = offences(|source, import| match (place(&source.module), place(import)) {
        (Some(here), Some(there)) => there <= here,
        // `lib.rs`, `main.rs` and names that are not modules, such as macros.
        _ => true,
    });
    assert!(found.is_empty(), "imports that point down:\n{found}");
}

/// The records are the ground floor: nothing of the project is below them, and the analysis needs nothing else.
#[test]
fn records_know_nothing_of_the_project_and_the_analysis_knows_records_alone() {
    assert_eq!(rooms()[..2], ["record", "analysis"]);
    let found = offences(|source, import| match source.module.as_str() {
        "record" => import == "record",
        "analysis" => ["record", "analysis"].contains(&import),
        _ => true,
    });
    assert!(found.is_empty(), "{found}");
}

/// Whoever needs the variants is given them, so that those of another crate count everywhere.
#[test]
fn only_the_entry_makes_the_standard_registry() {
    let found = files_with(&["registry::standard()"], &["main"]);
    assert!(found.is_empty(), "{found}");
}

#[test]
fn what_is_made_of_records_knows_nothing_else() {
    let found = offences(|source, import| {
        !["analysis", "plot", "report"].contains(&source.module.as_str())
            || ["record", "analysis", "plot", "report"].contains(&import)
    });
    assert!(found.is_empty(), "these must know only `record`:\n{found}");
}

#[test]
fn volumes_and_trees_know_only_geometry() {
    let found = offences(|source, import| {
        !["volume", "tree"].contains(&source.module.as_str()) || ["geometry", "volume", "tree"].contains(&import)
    });
    assert!(found.is_empty(), "no scenes, clocks or CSV here:\n{found}");
}

/// The packages in a section of a crate's manifest.
fn dependencies(manifest: &str) -> Vec<String> {
    let section = manifest.split("[dependencies]").nth(1).unwrap_or_default().split("\n[").next().unwrap_or_default();
    let name = |line: &str| line.split(['.', '=', ' ']).next().unwrap_or_default().to_owned();
    section.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')).map(name).collect()
}

#[test]
fn the_engine_depends_on_arithmetic_alone() {
    let manifest = fs::read_to_string(root().join("../crates/obbtree/Cargo.toml")).unwrap();
    let known = ["foldhash", "nalgebra", "rayon", "robust"];
    let on_demand = ["blake3", "rand", "rand_pcg", "serde"];
    let found = dependencies(&manifest);
    assert!(known.iter().all(|name| found.iter().any(|found| found == name)), "{found:?}");
    assert!(found.iter().all(|name| known.contains(&&**name) || on_demand.contains(&&**name)), "{found:?}");
    for name in on_demand {
        let line = manifest.lines().find(|line| line.starts_with(&format!("{name} = "))).unwrap();
        assert!(line.contains("optional = true"), "{name} is not optional");
    }
}

/// All crates that a package of the workspace brings, itself among them.
fn crates_of(package: &str) -> BTreeSet<String> {
    let arguments = "tree --locked --offline --edges normal,build --prefix none --format {p} --package".split(' ');
    let output = Command::new(env!("CARGO")).args(arguments).arg(package).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().filter_map(|line| Some(line.split(' ').next()?.to_owned())).collect()
}

/// Whoever depends on the engine gets few crates, and none for serialisation, plots or a command line.
#[test]
fn the_engine_brings_few_crates() {
    let crates = crates_of("obbtree");
    assert!(crates.contains("obbtree") && crates.contains("nalgebra") && crates.len() <= 25, "{crates:?}");
    for name in ["clap", "plotters", "serde", "serde_core", "parry3d-f64"] {
        assert!(!crates.contains(name), "{name} comes with the engine");
    }
}

/// Packages that the checker of certificates may depend on: a hash and a reader of TOML.
const OF_THE_CHECKER: [&str; 2] = ["blake3", "toml"];
/// Equal lines in a row, of those with a word in them, from which on code counts as shared.
const SHARED: usize = 3;

/// What is shared is not checked: a fault of the search would be one of the checker too.
#[test]
fn the_checker_depends_on_nothing_that_it_checks() {
    let manifest = fs::read_to_string(root().join("../crates/certificate-checker/Cargo.toml")).unwrap();
    assert_eq!(dependencies(&manifest), OF_THE_CHECKER);
    assert_eq!(manifest.matches("dependencies]").count(), 1, "one section");
    let crates = crates_of("certificate-checker");
    assert!(OF_THE_CHECKER.iter().all(|name| crates.contains(*name)), "{crates:?}");
    for name in ["bvbench", "obbtree", "rs274", "nalgebra", "parry3d-f64", "robust"] {
        assert!(!crates.contains(name), "{name} comes with the checker");
    }
    let manifest = fs::read_to_string(root().join("../Cargo.toml")).unwrap();
    assert!(!dependencies(&manifest).contains(&"certificate-checker".to_owned()), "only tests know the checker");
}

/// Lines of code with a word in them, without comments.
fn lines_of_code(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
    code.filter(|line| line.contains(char::is_alphanumeric)).map(str::to_owned).collect()
}

#[test]
fn the_checker_shares_no_code_with_what_it_checks() {
    let checker = root().join("../crates/certificate-checker/src");
    let (mut own, mut others) = (Vec::new(), Vec::new());
    collect(&checker, &mut own);
    for folder in
        ["../crates/obbtree/src", "../crates/rs274/src"].map(|folder| root().join(folder)).iter().chain(&roots())
    {
        collect(folder, &mut others);
    }
    assert!(own.len() > 5 && others.len() > 200, "{} and {} files", own.len(), others.len());
    for path in &own {
        assert!(!path.symlink_metadata().unwrap().is_symlink(), "{}", path.display());
        let text = fs::read_to_string(path).unwrap();
        assert!(!["include!", "include_str!", "#[path"].iter().any(|word| text.contains(word)), "{}", path.display());
    }
    let code = |files: &[PathBuf]| files.iter().map(|path| lines_of_code(path)).collect::<Vec<_>>();
    let (own, others) = (code(&own), code(&others));
    let known: BTreeSet<&[String]> = own.iter().flat_map(|lines| lines.windows(SHARED)).collect();
    let shared: Vec<_> =
        others.iter().flat_map(|lines| lines.windows(SHARED)).filter(|lines| known.contains(lines)).collect();
    assert!(shared.is_empty(), "{shared:?}");
}

#[test]
fn the_workspace_needs_no_python() {
    let lock = fs::read_to_string(root().join("../Cargo.lock")).unwrap();
    assert!(lock.contains("name = \"obbtree\"") && !lock.contains("pyo3"), "crates/obbtree-py is in the workspace");
}

#[test]
fn the_interpreter_depends_on_nothing_of_the_project() {
    let manifest = fs::read_to_string(root().join("../crates/rs274/Cargo.toml")).unwrap();
    assert_eq!(dependencies(&manifest), ["thiserror"]);
}

#[test]
fn only_the_measurement_reads_a_clock() {
    let found = files_with(&["Instant", "SystemTime", "std::time::{"], &["measure"]);
    assert!(found.is_empty(), "{found}");
}

#[test]
fn only_the_command_line_prints() {
    let found = files_with(
        &["println!", "print!(", "eprintln!", "eprint!(", "dbg!(", "stdout()", "stderr()"],
        &["cli", "main"],
    );
    assert!(found.is_empty(), "{found}");
}

#[test]
fn all_randomness_is_seeded() {
    let found = files_with(&["thread_rng", "rand::rng(", "from_os_rng", "from_entropy", "SysRng", "RandomState"], &[]);
    assert!(found.is_empty(), "{found}");
}

#[test]
fn a_variants_id_stands_only_in_its_own_file() {
    let sources = sources();
    let is_part = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    for variant in registry::standard().variants() {
        let id = variant.info.id;
        let files: Vec<_> = sources
            .iter()
            .filter(|source| {
                source.literals.iter().any(|literal| literal.split(|c| !is_part(c)).any(|word| word == id))
            })
            .map(|source| source.path.display().to_string())
            .collect();
        assert_eq!(files.len(), 1, "`{id}` stands in {files:?}");
    }
}
