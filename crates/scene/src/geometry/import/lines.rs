//! A reader that makes and counts lines one by one, while a parser of another crate reads them.

use std::cell::Cell;
use std::io::{BufRead, Error, ErrorKind, Read, Result, Seek, SeekFrom};

/// A reader that returns one line per call, so that its caller cannot read ahead of the current line. Only the current line is in memory.
pub(super) struct Lines<'a, F> {
    text: &'a str,
    rest: std::str::Lines<'a>,
    /// What the parser gets in place of a line, by its number from 1 and its text.
    change: F,
    /// A line after the last of the text.
    last: Option<&'static str>,
    is_past_last: bool,
    current: String,
    /// Bytes of the current line that have been returned.
    used: usize,
    /// Number of the current line, counted from 1; 0 before the first.
    number: &'a Cell<usize>,
}

impl<'a, F: Fn(usize, &str) -> String> Lines<'a, F> {
    /// Reads the lines of `text` as `change` gives them, each with a line feed, then `last`; `number` holds the number of the line that was
    /// returned last.
    pub fn new(text: &'a str, change: F, last: Option<&'static str>, number: &'a Cell<usize>) -> Self {
        number.set(0);
        Self { text, rest: text.lines(), change, last, is_past_last: false, current: String::new(), used: 0, number }
    }

    /// Goes to the next line; stays at the last.
    fn advance(&mut self) {
        let number = self.number.get() + 1;
        let line = match self.rest.next() {
            Some(line) => (self.change)(number, line),
            None => match self.last {
                Some(last) if !self.is_past_last => {
                    self.is_past_last = true;
                    last.to_owned()
                }
                _ => return,
            },
        };
        self.current = line + "\n";
        self.number.set(number);
        self.used = 0;
    }
}

impl<F: Fn(usize, &str) -> String> BufRead for Lines<'_, F> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        if self.used == self.current.len() {
            self.advance();
        }
        Ok(&self.current.as_bytes()[self.used..])
    }

    fn consume(&mut self, amount: usize) {
        self.used += amount;
    }
}

impl<F: Fn(usize, &str) -> String> Read for Lines<'_, F> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let available = self.fill_buf()?;
        let amount = available.len().min(buffer.len());
        buffer[..amount].copy_from_slice(&available[..amount]);
        self.consume(amount);
        Ok(amount)
    }
}

impl<F: Fn(usize, &str) -> String> Seek for Lines<'_, F> {
    /// Seeks to the beginning, which is the only seek of a parser that inspects the content before reading it.
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        if to != SeekFrom::Start(0) {
            return Err(Error::new(ErrorKind::Unsupported, "lines can only be read again from the beginning"));
        }
        self.rest = self.text.lines();
        self.is_past_last = false;
        self.number.set(0);
        self.current.clear();
        self.used = 0;
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_made_one_by_one_and_again_from_the_beginning() {
        let (number, made) = (Cell::new(0), Cell::new(0));
        let change = |number: usize, line: &str| {
            made.set(made.get() + 1);
            format!("{number} {line}")
        };
        let text = "a\n\nb";
        let mut lines = Lines::new(text, change, Some("end"), &number);
        let mut line = String::new();
        lines.read_line(&mut line).unwrap();
        assert_eq!((line.as_str(), made.get(), number.get()), ("1 a\n", 1, 1));
        for _ in 0..2 {
            lines.seek(SeekFrom::Start(0)).unwrap();
            let mut all = String::new();
            lines.read_to_string(&mut all).unwrap();
            assert_eq!((all.as_str(), number.get()), ("1 a\n2 \n3 b\nend\n", 4));
        }
        assert!(lines.seek(SeekFrom::End(0)).is_err());
    }
}
