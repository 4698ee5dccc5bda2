//! Progress on a terminal: a bar with the time left. Elsewhere one line per stretch of work, with the seconds since
//! the start. Nothing when quiet.

use super::note;
use crate::measure::Progress;
use crate::measure::timer::Stopwatch;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt;
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
        let target = if quiet || !terminal { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self { lines_since: (!quiet && !terminal).then(Stopwatch::start), ..Self::on(target) }
    }

    /// A bar of the width of `target`, on which a long description is cut; nothing is drawn before the first stretch of work.
    fn on(target: ProgressDrawTarget) -> Self {
        let bar = ProgressBar::with_draw_target(None, target);
        let style = ProgressStyle::with_template("{wide_msg} [{bar:20}] {percent:>3} %{left}");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.with_key("left", time_left).progress_chars("=> "));
        Self { bar, lines_since: None }
    }

    /// Removes the bar from the terminal.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// The time left, once a step is done from which it can be estimated.
fn time_left(state: &ProgressState, text: &mut dyn fmt::Write) {
    if state.pos() > 0 {
        // A bar without its time left is still one.
        let _ = write!(text, "  {:#} left", HumanDuration(state.eta()));
    }
}

impl Progress for Bar {
    fn begin(&self, what: &str, total: u64) {
        if let Some(start) = self.lines_since {
            note(format!("[{:4.0} s] {what} ...", start.seconds()));
        }
        // Message and position are set without drawing, so that no frame has those of two stretches.
        let bar = self.bar.clone().with_message(what.to_owned()).with_position(0);
        bar.set_length(total);
        bar.reset();
    }

    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::TermLike;
    use std::io;
    use std::sync::{Arc, Mutex};

    /// A terminal that keeps what is written to it.
    #[derive(Clone, Debug)]
    struct Terminal {
        columns: u16,
        written: Arc<Mutex<Vec<String>>>,
    }

    impl Terminal {
        /// The frames drawn since the last time.
        fn frames(&self) -> Vec<String> {
            let written = std::mem::take(&mut *self.written.lock().unwrap());
            written.into_iter().filter(|text| text.contains('%')).collect()
        }
    }

    impl TermLike for Terminal {
        fn width(&self) -> u16 {
            self.columns
        }

        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(text)
        }

        fn write_str(&self, text: &str) -> io::Result<()> {
            self.written.lock().unwrap().push(text.to_owned());
            Ok(())
        }

        fn clear_line(&self) -> io::Result<()> {
            Ok(())
        }

        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn frames_fit_the_terminal_and_each_stretch_begins_at_nothing() {
        for columns in [60, 80] {
            let terminal = Terminal { columns, written: Arc::default() };
            let bar = Bar::on(ProgressDrawTarget::term_like(Box::new(terminal.clone())));
            for what in ["checking", "lathe-toolpost: exact truth along bench-scenes/lathe-toolpost/program.ngc"] {
                assert_eq!(terminal.frames(), [""; 0]);
                bar.begin(what, 4);
                let begun = terminal.frames();
                assert!(!begun.is_empty());
                for frame in &begun {
                    assert!(frame.starts_with(&what[..8]) && frame.trim_end().ends_with("]   0 %"), "{begun:?}");
                }
                bar.advance(2);
                bar.bar.tick();
                let half = terminal.frames();
                let last = half.last().unwrap();
                assert!(last.contains("]  50 %  ") && last.contains(" left"), "{half:?}");
                for frame in begun.iter().chain(&half) {
                    assert!(frame.chars().count() <= usize::from(columns), "{columns}: {frame}");
                }
            }
        }
    }
}
