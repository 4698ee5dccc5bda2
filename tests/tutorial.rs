//! The tutorial, word for word: files are written, commands are run, and what it says they print is printed.
//!
//! Fenced blocks of `docs/tutorial-machine.md`: `sh` holds commands, `text` lines that the last command prints (each a part of one of its lines, in
//! order; `exit code N` for codes but 0), and any other language with a file's name behind it a file.

mod support;

use std::path::Path;
use support::Folder;

/// A fenced block: language, what stands behind it, the text, and the line where it begins.
struct Block {
    language: String,
    name: String,
    text: String,
    line: usize,
}

fn blocks(document: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = document.lines().enumerate();
    while let Some((line, text)) = lines.next() {
        let Some(info) = text.strip_prefix("```") else { continue };
        let (language, name) = info.split_once(' ').unwrap_or((info, ""));
        let inner: Vec<&str> =
            lines.by_ref().map(|(_, text)| text).take_while(|text| !text.starts_with("```")).collect();
        let text = inner.join("\n") + "\n";
        blocks.push(Block { language: language.to_owned(), name: name.trim().to_owned(), text, line: line + 1 });
    }
    blocks
}

/// Commands of a block, lines that end in `\` joined with the next.
fn commands(text: &str) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    let lines = joined.lines().map(|line| line.split(" #").next().unwrap_or_default().trim().to_owned());
    lines.filter(|line| !line.is_empty()).collect()
}

#[test]
fn every_command_of_the_tutorial_does_what_it_says() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tutorial-machine.md");
    let folder = Folder::with(&[]);
    let mut last: Option<(String, i32, String)> = None;
    let (mut ran, mut compared) = (0, 0);
    for block in blocks(&std::fs::read_to_string(file).unwrap()) {
        let Block { language, name, text, line } = block;
        match language.as_str() {
            "sh" => {
                for command in commands(&text) {
                    accepted(last.take());
                    let mut words = command.split_whitespace();
                    assert_eq!(words.next(), Some("bvbench"), "line {line}: {command}");
                    let words: Vec<&str> = words.collect();
                    let output = folder.run(&words);
                    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
                    last = Some((command.clone(), output.status.code().unwrap(), said.into_owned()));
                    ran += 1;
                }
            }
            "text" => {
                let (command, code, said) = last.take().expect("a command before what it prints");
                let mut expected = 0;
                for wanted in text.lines() {
                    if let Some(wanted) = wanted.strip_prefix("exit code ") {
                        expected = wanted.parse().unwrap();
                    } else {
                        assert!(said.contains(wanted), "line {line}: `{wanted}` is not printed by {command}:\n{said}");
                        compared += 1;
                    }
                }
                assert_eq!(code, expected, "line {line}: {command}\n{said}");
            }
            // What is no command of ours: other programs, which a test cannot ask for.
            "console" => {}
            _ => {
                folder.write(&name, &text);
            }
        }
    }
    accepted(last);
    assert!(ran >= 6 && compared >= 8, "{ran} commands, {compared} lines");
}

/// A command without a block of what it prints ends with 0.
fn accepted(last: Option<(String, i32, String)>) {
    if let Some((command, code, said)) = last {
        assert_eq!(code, 0, "{command}\n{said}");
    }
}
