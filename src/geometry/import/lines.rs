//! A reader that counts lines while a parser of another crate reads them.

use std::cell::Cell;
use std::io::{BufRead, Error, ErrorKind, Read, Result, Seek, SeekFrom};

/// A reader that returns one line per call, so that its caller cannot read ahead of the current line.
pub(super) struct Lines<'a> {
    lines: Vec<String>,
    /// Bytes of the current line that have been returned.
    used: usize,
    /// Number of the current line, counted from 1; 0 before the first.
    number: &'a Cell<usize>,
}

impl<'a> Lines<'a> {
    /// Reads `lines`, adding a line feed to each; `number` holds the number of the line that was returned last.
    pub fn new(mut lines: Vec<String>, number: &'a Cell<usize>) -> Self {
        lines.iter_mut().for_each(|line| line.push('\n'));
        number.set(0);
        Self { lines, used: 0, number }
    }

    fn current(&self) -> &[u8] {
        self.number.get().checked_sub(1).map_or(&[], |i| self.lines[i].as_bytes())
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        if self.used == self.current().len() && self.number.get() < self.lines.len() {
            self.number.set(self.number.get() + 1);
            self.used = 0;
        }
        Ok(&self.current()[self.used..])
    }

    fn consume(&mut self, amount: usize) {
        self.used += amount;
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let available = self.fill_buf()?;
        let amount = available.len().min(buffer.len());
        buffer[..amount].copy_from_slice(&available[..amount]);
        self.consume(amount);
        Ok(amount)
    }
}

impl Seek for Lines<'_> {
    /// Seeks to the beginning, which is the only seek of a parser that inspects the content before reading it.
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        if to != SeekFrom::Start(0) {
            return Err(Error::new(ErrorKind::Unsupported, "lines can only be read again from the beginning"));
        }
        self.number.set(0);
        self.used = 0;
        Ok(0)
    }
}
