//! What the operator sees while a run goes on: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use shared_types::{FitUpdate, LoopStatus, Sample, Verdict};

use super::loop_link::LoopLink;
use crate::outcome::say;

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(2);
/// Steps of the bar per second of the run.
const STEPS_PER_S: f64 = 20.0;

/// What is shown of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    /// The model as it is fitted.
    Fit,
    /// What a hand does to a rendered model, and what it feels.
    Rendering,
}

/// Shows how far the run is and how it goes.
pub(crate) struct Progress {
    shown: Shown,
    bar: Option<ProgressBar>,
    next_line: Instant,
}

impl Progress {
    /// For a run of so many seconds, or one that the operator ends.
    pub(crate) fn new(shown: Shown, duration_s: Option<f64>) -> Self {
        let bar = std::io::stdout().is_terminal().then(|| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the loop checked the duration")]
            let (bar, template) = match duration_s {
                Some(duration_s) => (ProgressBar::new((duration_s * STEPS_PER_S).ceil() as u64), "{bar:24} {msg}"),
                None => (ProgressBar::no_length(), "{msg}"),
            };
            bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self { shown, bar, next_line: Instant::now() + LINE_INTERVAL }
    }

    pub(crate) fn show(&mut self, link: &LoopLink) {
        let line = match self.shown {
            Shown::Fit => fit_line(link.status(), link.fit()),
            Shown::Rendering => rendering_line(link),
        };
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

fn fit_line(status: &LoopStatus, fit: Option<&FitUpdate>) -> String {
    let known = fit.map_or_else(String::new, |fit| {
        let enough = fit.estimates().iter().filter(|(_, e)| e.verdict == Verdict::Enough.code()).count();
        let told = fit.estimates().iter().filter(|(_, e)| e.verdict != Verdict::Absent.code()).count();
        format!(", residual {:.2} mNm, {enough} of {told} known", fit.residual_rms_mnm)
    });
    format!("{:5.1} s, {} missed{known}", elapsed_s(status), status.missed_ticks)
}

#[allow(clippy::cast_precision_loss, reason = "for display")]
fn rendering_line(link: &LoopLink) -> String {
    let status = link.status();
    let contact = if status.flags & Sample::STUCK == 0 { "sliding" } else { "stuck" };
    let model = link.models().last().map_or("", |model| model.name.as_str());
    format!(
        "{:5.1} s, {:+.3} rad, {contact}, hand {:+.1} mNm, late by {:.3} ms at most, {} missed, {model}",
        elapsed_s(status),
        status.angle_rad,
        link.hand_torque_mnm(),
        status.max_lateness_ns as f64 / 1e6,
        status.missed_ticks
    )
}
