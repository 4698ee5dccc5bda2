//! The characters of one line: case folded, spaces skipped, columns kept.
//!
//! RS274/NGC (Kramer, Proctor, Messina, NISTIR 6556, section 3.3) ignores case and spaces outside comments.

use super::dialect::Dialect;
use super::error::{Cause, Fault};

/// Longest line accepted, in characters. LinuxCNC stops at 255; generated programs have longer comments.
pub(super) const MAX_LINE_LENGTH: usize = 4096;

/// A place in a line.
#[derive(Clone, Debug)]
pub(super) struct Cursor {
    /// Whose words these are.
    pub dialect: Dialect,
    /// Whether a comment stood inside a comment.
    pub nested_comment: bool,
    characters: Vec<char>,
    at: usize,
}

impl Cursor {
    /// At the first character of a line.
    pub fn new(line: &str, dialect: Dialect) -> Result<Self, Fault> {
        let characters: Vec<char> = line.chars().collect();
        if characters.len() > MAX_LINE_LENGTH {
            let cause = Cause::Limit { limit: MAX_LINE_LENGTH, what: "characters in a line" };
            return Err(Fault::new(MAX_LINE_LENGTH as u32 + 1, "", cause));
        }
        Ok(Self { dialect, nested_comment: false, characters, at: 0 })
    }

    /// The next character that is not a space, in lower case; `None` at the end of the line.
    pub fn peek(&mut self) -> Option<char> {
        while self.characters.get(self.at).is_some_and(|character| character.is_whitespace()) {
            self.at += 1;
        }
        self.characters.get(self.at).map(char::to_ascii_lowercase)
    }

    /// Takes the next character.
    pub fn next(&mut self) -> Option<char> {
        let character = self.peek()?;
        self.at += 1;
        Some(character)
    }

    /// Takes the next character if it is `wanted`.
    pub fn accept(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += usize::from(found);
        found
    }

    /// Takes the next character, which must be `wanted`.
    pub fn expect(&mut self, wanted: char, name: &'static str) -> Result<(), Fault> {
        if self.accept(wanted) { Ok(()) } else { Err(self.fault_here(Cause::Expected(name))) }
    }

    /// Takes `word` (lower case letters) if it comes next; spaces inside it are ignored as everywhere.
    pub fn accept_word(&mut self, word: &str) -> bool {
        let before = self.at;
        for wanted in word.chars() {
            if !self.accept(wanted) {
                self.at = before;
                return false;
            }
        }
        true
    }

    /// Whether `word` comes next.
    pub fn looks_at_word(&mut self, word: &str) -> bool {
        let before = self.at;
        let found = self.accept_word(word);
        self.at = before;
        found
    }

    /// Whether two letters come next: no word of a block begins so.
    pub fn looks_at_keyword(&mut self) -> bool {
        let before = self.at;
        let count = self.letters().len();
        self.at = before;
        count > 1
    }

    /// What is left of the line, as it stands.
    pub fn rest(&mut self) -> String {
        self.peek();
        let rest = self.characters[self.at..].iter().collect::<String>().trim_end().to_owned();
        self.at = self.characters.len();
        rest
    }

    /// Takes a digit if one comes next.
    pub fn accept_digit(&mut self) -> bool {
        let found = self.peek().is_some_and(|character| character.is_ascii_digit());
        self.at += usize::from(found);
        found
    }

    /// Column of the next character, from 1.
    pub fn column(&mut self) -> u32 {
        self.peek();
        self.at as u32 + 1
    }

    /// The text from `column` to here.
    pub fn text_from(&self, column: u32) -> String {
        let start = (column as usize - 1).min(self.at);
        self.characters[start..self.at].iter().collect::<String>().trim_end().to_owned()
    }

    /// A fault at the next character.
    pub fn fault_here(&mut self, cause: Cause) -> Fault {
        let text = self.peek().map(|_| self.characters[self.at].to_string()).unwrap_or_default();
        Fault::new(self.column(), text, cause)
    }

    /// Takes an unsigned decimal number: digits with at most one point. There are no exponents: `E` is a letter.
    pub fn number(&mut self) -> Result<f64, Fault> {
        let column = self.column();
        let mut text = String::new();
        while let Some(character) = self.peek().filter(|&c| c.is_ascii_digit() || c == '.') {
            text.push(character);
            self.at += 1;
        }
        text.parse().map_err(|_| {
            if text.is_empty() {
                self.fault_here(Cause::Expected("number"))
            } else {
                Fault::new(column, text, Cause::Expected("number"))
            }
        })
    }

    /// Takes a name in `<...>`: folded to lower case, spaces removed.
    pub fn name(&mut self) -> Result<String, Fault> {
        let column = self.column();
        self.expect('<', "`<`")?;
        let mut name = String::new();
        loop {
            match self.next() {
                Some('>') if name.is_empty() => {
                    return Err(Fault::new(column, self.text_from(column), Cause::Expected("name")));
                }
                Some('>') => return Ok(name),
                Some(character) => name.push(character),
                None => return Err(Fault::new(column, self.text_from(column), Cause::UnclosedName)),
            }
        }
    }

    /// Takes a run of letters.
    pub fn letters(&mut self) -> String {
        let mut word = String::new();
        while let Some(letter) = self.peek().filter(char::is_ascii_alphabetic) {
            word.push(letter);
            self.at += 1;
        }
        word
    }

    /// Skips comments: `(...)` and everything behind `;`, which on Fanuc's and Haas's controls ends the block (`block`).
    pub fn skip_comments(&mut self) -> Result<(), Fault> {
        loop {
            match self.peek() {
                Some(';') => self.at = self.characters.len(),
                Some('(') => self.skip_parenthesis()?,
                _ => return Ok(()),
            }
        }
    }

    fn skip_parenthesis(&mut self) -> Result<(), Fault> {
        let column = self.column();
        self.at += 1;
        let mut depth = 1_u32;
        while let Some(&character) = self.characters.get(self.at) {
            self.at += 1;
            match character {
                ')' => depth -= 1,
                '(' if self.dialect == Dialect::Grbl => {
                    depth += 1;
                    self.nested_comment = true;
                }
                '(' => return Err(Fault::new(self.at as u32, "(", Cause::NestedComment)),
                _ => {}
            }
            if depth == 0 {
                return Ok(());
            }
        }
        Err(Fault::new(column, self.text_from(column), Cause::UnclosedComment))
    }
}
