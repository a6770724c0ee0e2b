//! What the operator sees while the sweep runs: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use shared_types::{FitUpdate, LoopStatus, Verdict};

use super::loop_link::LoopLink;
use crate::outcome::say;

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(2);
/// Steps of the bar per second of the run.
const STEPS_PER_S: f64 = 20.0;

/// Shows how far the run is and how it goes.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    next_line: Instant,
}

impl Progress {
    pub(crate) fn new(duration_s: f64) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the loop checked the duration")]
        let steps = (duration_s * STEPS_PER_S).ceil() as u64;
        let bar = std::io::stdout().is_terminal().then(|| {
            let bar = ProgressBar::new(steps);
            let style = ProgressStyle::with_template("{bar:24} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
            bar.set_style(style);
            bar
        });
        Self { bar, next_line: Instant::now() + LINE_INTERVAL }
    }

    pub(crate) fn show(&mut self, link: &LoopLink) {
        let line = line(link.status(), link.fit());
        if let Some(bar) = &self.bar {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "time in the run is positive")]
            bar.set_position((elapsed_s(link.status()) * STEPS_PER_S) as u64);
            bar.set_message(line);
        } else if Instant::now() >= self.next_line {
            self.next_line = Instant::now() + LINE_INTERVAL;
            say(line);
        }
    }

    pub(crate) fn close(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[allow(clippy::cast_precision_loss, reason = "ticks stay far below 2^53")]
fn elapsed_s(status: &LoopStatus) -> f64 {
    (status.published_samples + status.missed_ticks) as f64 / status.rate_hz.max(1.0)
}

fn line(status: &LoopStatus, fit: Option<&FitUpdate>) -> String {
    let known = fit.map_or_else(String::new, |fit| {
        let enough = fit.estimates().iter().filter(|(_, e)| e.verdict == Verdict::Enough.code()).count();
        let told = fit.estimates().iter().filter(|(_, e)| e.verdict != Verdict::Absent.code()).count();
        format!(", residual {:.2} mNm, {enough} of {told} known", fit.residual_rms_mnm)
    });
    format!("{:5.1} s, {} missed{known}", elapsed_s(status), status.missed_ticks)
}
