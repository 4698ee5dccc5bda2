//! Programs for other controls, told by their words: once interpreting has failed, what to try, or what is missing; and where nobody has named the
//! dialect, that another one may be meant.

use super::dialect::{Dialect, Note};
use super::error::{Cause, GcodeError};
use std::path::Path;

/// Most lines that are looked at.
const LINES: usize = 20_000;
/// Most words of another control that a message names.
const NAMED: usize = 6;

/// Words of Siemens' SINUMERIK controls, without spaces, in upper case.
const SIEMENS: [&str; 40] = [
    "CYCLE8",
    "CYCLE9",
    "TRAORI",
    "TRAFOOF",
    "MSG(",
    "SUPA",
    "%_N_",
    "MCALL",
    "HOLES1(",
    "POCKET",
    "SLOT1(",
    "WORKPIECE(",
    "GOTOF",
    "GOTOB",
    "ATRANS",
    "AROT",
    "ASCALE",
    "AMIRROR",
    "DEFREAL",
    "DEFINT",
    "DIAMON",
    "DIAMOF",
    "ORIWKS",
    "T=\"",
    "STOPRE",
    "DEFSTRING",
    "DEFBOOL",
    "DEFAXIS",
    "DEFCHAR",
    "SETAL(",
    "SETMS(",
    "SPOS=",
    "$TC_",
    "$P_",
    "$AA_",
    "$AC_",
    "$MC_",
    "$MA_",
    "$A_",
    "EXTERN",
];

/// Words of Okuma's OSP controls; names of variables are Siemens', too.
const OKUMA: [&str; 6] = [".MIN%", ".SSB%", ".SUB%", "CALLO", "NLAP", "VZOF"];

/// Words that begin a line of Heidenhain's conversational language, behind its number.
const HEIDENHAIN: [&str; 14] = [
    "BEGINPGM", "BLKFORM", "TOOLCALL", "TOOLDEF", "CYCLDEF", "CYCLCALL", "CALLLBL", "FN0:", "ENDPGM", "LX+", "LX-",
    "LZ+", "LZ-", "CCX",
];

/// Words of Fanuc's and Haas's controls, and what programs of LinuxCNC's seldom have.
const FANUC: [&str; 14] = [
    "IF[", "GOTO", "WHILE[", "G65", "M98P", "G54.1", "G05.1", "G5.1Q", "G50S", "G28U0", "G28W0", "G71U", "G76P0",
    "#3000",
];

/// Words of Haas's controls alone.
const HAAS: [&str; 5] = ["G187", "G154", "M97", "G234", "HAAS"];

/// The error of a program that is in a dialect which it may not be written in: with a hint, or as that of a language not interpreted.
pub(super) fn recognise(lines: &[String], file: &Path, dialect: Dialect, mut error: GcodeError) -> GcodeError {
    if matches!(error.cause, Cause::Limit { .. } | Cause::Alarm(_) | Cause::Unreadable(_)) {
        return error;
    }
    let lines = bare_lines(lines);
    let siemens = found(&lines, &SIEMENS, |line, word| line.contains(word));
    let heidenhain = found(&lines, &HEIDENHAIN, |line, word| {
        line.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(word)
    });
    let okuma = found(&lines, &OKUMA, |line, word| line.contains(word) && !is_o_word(line));
    let assigns_r = lines.iter().position(|line| assigns_r_parameter(line));
    let assigns_name = lines.iter().position(|line| assigns_named_variable(line));
    let begins = found(&lines, &["PROC", "_"], |line, word| unnumbered(line).starts_with(word));
    let assigned = assigns_r.map(|line| ("R1=", line)).into_iter().chain(assigns_name.map(|line| ("NAME=", line)));
    for (name, words, certain) in [
        ("Heidenhain's conversational language", heidenhain, &["BEGINPGM", "TOOLCALL", "CYCLDEF"][..]),
        ("the language of Okuma's OSP controls", okuma, &[]),
        ("Siemens' SINUMERIK language", siemens.into_iter().chain(begins).chain(assigned).collect(), &[]),
    ] {
        let is_certain = words.len() > 1 || words.iter().any(|(word, _)| certain.is_empty() || certain.contains(word));
        if let Some(first) = words.iter().map(|(_, line)| *line).min().filter(|_| is_certain) {
            let mut names: Vec<&str> = words.iter().map(|(word, _)| *word).take(NAMED).map(spelled).collect();
            names.dedup();
            let message = format!(
                "the program is in {name} ({}), which is not interpreted; post it for LinuxCNC, Fanuc or Haas",
                names.join(", ")
            );
            return GcodeError::new(file.to_owned(), first as u32 + 1, 1, String::new(), Cause::Foreign(message));
        }
    }
    if dialect == Dialect::LinuxCnc
        && let Some(Likely { what, advice, .. }) = Likely::of(&lines)
    {
        error.set_hint(format!("{what}: try {advice}"));
    }
    error
}

/// The note on a program that runs as LinuxCNC's because nobody has named its dialect, and that looks like another control's.
pub(super) fn note(lines: &[String]) -> Option<Note> {
    let Likely { what, advice, first } = Likely::of(&bare_lines(lines))?;
    let text = format!(
        "{what}, and is read as LinuxCNC's, since no dialect is named: {advice} reads it as that control does, and `--dialect linuxcnc` as here without this note (`dialect` in [program] of a scene)"
    );
    Some(Note { line: first as u32 + 1, more: 0, is_unknown: true, text })
}

/// A control that a program may be written for.
struct Likely {
    /// That the program looks like that, with the signs.
    what: String,
    /// How its dialect is named.
    advice: &'static str,
    /// Index of the first line with a sign.
    first: usize,
}

impl Likely {
    /// Fanuc's or Haas's control, where a sign of one stands in the lines.
    fn of(lines: &[String]) -> Option<Self> {
        let haas = found(lines, &HAAS, |line, word| line.contains(word));
        let fanuc = found(lines, &FANUC, is_fanuc);
        let (control, advice) = match haas.is_empty() {
            true => ("Fanuc or Haas", "`--dialect fanuc` or `--dialect haas`"),
            false => ("Haas", "`--dialect haas`"),
        };
        let number = lines.iter().enumerate().find_map(|(index, line)| Some((program_number(line)?, index)));
        let words = haas.into_iter().chain(fanuc).map(|(word, line)| (spelled(word), line));
        let signs: Vec<(&str, usize)> = words.chain(number).collect();
        let first = signs.iter().map(|&(_, line)| line).min()?;
        let names: Vec<&str> = signs.iter().map(|&(name, _)| name).take(NAMED).collect();
        let names = names.join(", ");
        let what = format!("the program looks as if it were written for a {control} control ({names})");
        Some(Self { what, advice, first })
    }
}

fn bare_lines(lines: &[String]) -> Vec<String> {
    lines.iter().take(LINES).map(|line| bare(line)).collect()
}

/// Whether a word of [`FANUC`] is in a line. P of LinuxCNC's `G76` is the pitch, and of Fanuc's six digits.
fn is_fanuc(line: &str, word: &str) -> bool {
    let behind = line.split_once(word).filter(|_| !is_o_word(line)).map(|(_, behind)| behind);
    behind.is_some_and(|behind| word != "G76P0" || behind.bytes().take_while(u8::is_ascii_digit).count() == 5)
}

/// O and digits alone: the number of a program.
fn program_number(line: &str) -> Option<&str> {
    let digits = line.strip_prefix('O')?.trim_start_matches(|c: char| c.is_ascii_digit());
    let (number, rest) = line.split_at(line.len() - digits.len());
    (number.len() > 1 && rest.trim_end_matches("HAAS").chars().all(|c| c == '(')).then_some(number)
}

/// A line in upper case, without spaces, names in `<>`, and what stands in parentheses or behind a semicolon; `HAAS` is looked for everywhere.
fn bare(line: &str) -> String {
    let mut depth = 0_u32;
    let mut text = String::new();
    for character in without_names(line).chars() {
        match character {
            // Siemens' calls and messages have their parenthesis directly behind a word.
            '(' => {
                text.push('(');
                depth += 1;
            }
            ')' => depth = depth.saturating_sub(1),
            ';' if depth == 0 => break,
            _ if depth > 0 || character.is_whitespace() => {}
            _ => text.extend(character.to_uppercase()),
        }
    }
    if line.to_ascii_uppercase().contains("HAAS") {
        text.push_str("HAAS");
    }
    text
}

/// A line without what stands between `<` and `>`.
fn without_names(line: &str) -> String {
    let (mut text, mut rest) = (String::new(), line);
    while let Some((before, from)) = rest.split_once('<')
        && let Some((_, behind)) = from.split_once('>')
    {
        text.push_str(before);
        rest = behind;
    }
    text + rest
}

/// The words that occur, each with the index of its first line.
fn found(lines: &[String], words: &[&'static str], is_in: fn(&str, &str) -> bool) -> Vec<(&'static str, usize)> {
    words.iter().filter_map(|&word| Some((word, lines.iter().position(|line| is_in(line, word))?))).collect()
}

/// Whether the line begins with an O word, as LinuxCNC's control flow does; a `/` and an N number may stand before it.
fn is_o_word(line: &str) -> bool {
    line.trim_start_matches(|c: char| c == '/' || c == 'N' || c.is_ascii_digit()).starts_with('O')
}

/// `R1=...`, Siemens' parameters.
fn assigns_r_parameter(line: &str) -> bool {
    line.match_indices('R').any(|(at, _)| {
        let digits = line[at + 1..].trim_start_matches(|c: char| c.is_ascii_digit());
        digits.len() < line.len() - at - 1 && digits.starts_with('=')
    })
}

/// A line without its number.
fn unnumbered(line: &str) -> &str {
    let rest = line.strip_prefix('N').map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    rest.filter(|rest| rest.len() + 1 < line.len()).unwrap_or(line)
}

/// `NAME=...` and `NAME[...]=...` at the begin of a line, behind its number: a variable of two letters or more, without `#`.
fn assigns_named_variable(line: &str) -> bool {
    let line = unnumbered(line);
    let name_end = line.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(line.len());
    let (name, rest) = line.split_at(name_end);
    let mut letters = name.chars();
    let is_name = letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    let rest = match rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((_, behind)) => behind,
        None => rest,
    };
    is_name && rest.starts_with('=') && !rest.starts_with("==")
}

/// A word as programs spell it.
fn spelled(word: &str) -> &str {
    match word {
        "BEGINPGM" => "BEGIN PGM",
        "BLKFORM" => "BLK FORM",
        "TOOLCALL" => "TOOL CALL",
        "TOOLDEF" => "TOOL DEF",
        "CYCLDEF" => "CYCL DEF",
        "CYCLCALL" => "CYCL CALL",
        "CALLLBL" => "CALL LBL",
        "ENDPGM" => "END PGM",
        "LX+" | "LX-" | "LZ+" | "LZ-" => "L",
        "CCX" => "CC",
        "CYCLE8" | "CYCLE9" => "CYCLE",
        "MSG(" => "MSG",
        "DEFREAL" | "DEFINT" | "DEFSTRING" | "DEFBOOL" | "DEFAXIS" | "DEFCHAR" => "DEF",
        "_" => "_NAME",
        "CALLO" => "CALL O",
        word => word.trim_end_matches(['[', '(']),
    }
}
