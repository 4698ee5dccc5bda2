//! Progress on a terminal: a bar with the time left. Elsewhere one line per stretch of work, with the seconds since
//! the start. Nothing when quiet.

use super::note;
use crate::measure::Progress;
use crate::measure::timer::Stopwatch;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// A progress bar on standard error.
pub struct Bar {
    bar: ProgressBar,
    /// Since when, where lines are written.
    lines_since: Option<Stopwatch>,
}

impl Bar {
    /// A bar on a terminal; lines where standard error is none; neither when `quiet`.
    pub fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = ProgressBar::new(0);
        bar.set_draw_target(if quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        });
        let style = ProgressStyle::with_template("{msg:42} [{bar:30}] {percent:>3} %  {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        Self { bar, lines_since: (!quiet && !terminal).then(Stopwatch::start) }
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn begin(&self, what: &str, total: u64) {
        if let Some(start) = self.lines_since {
            note(format!("[{:4.0} s] {what} ...", start.seconds()));
        }
        self.bar.reset();
        self.bar.set_length(total);
        self.bar.set_message(what.to_owned());
    }

    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }
}
