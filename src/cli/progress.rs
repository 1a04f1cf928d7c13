//! A progress bar on a terminal for whatever takes longer than a second; nothing in a pipe.

use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// One task's progress. Cheap to ask, quiet for the first second.
#[derive(Debug)]
pub(crate) struct Progress {
    label: &'static str,
    /// Nothing if standard error is no terminal.
    started: Option<Instant>,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// A task called `label` begins.
    pub(crate) fn new(label: &'static str) -> Self {
        Self { label, started: stderr().is_terminal().then(Instant::now), bar: None }
    }

    /// A task that shows nothing.
    pub(crate) fn silent() -> Self {
        Self { label: "", started: None, bar: None }
    }

    /// `done` of `all` is done.
    pub(crate) fn set(&mut self, done: u64, all: u64) {
        const PATIENCE: Duration = Duration::from_secs(1);
        let Some(started) = self.started else { return };
        if self.bar.is_none() && started.elapsed() > PATIENCE {
            let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {percent:>3} %") {
                bar.set_style(style);
            }
            bar.set_prefix(self.label);
            self.bar = Some(bar);
        }
        if let Some(bar) = &self.bar {
            bar.set_length(all);
            bar.set_position(done);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
