//! What the operator sees while a run goes on: a panel on a terminal, plain lines elsewhere.

use std::time::{Duration, Instant};

use dynamics::Axis;
use identification::live::LiveParameter;
use indicatif::ProgressBar;
use shared_types::Sample;

use super::SupervisedRun;
use super::loop_link::LoopLink;
use super::panel::{self, FIT_LINES, losses};
use crate::outcome::{hold_panel, say};
use crate::terminal::{self, WIDTH};
use crate::until_ci::{Share, estimate_of, open, share_words};

/// Time between two plain lines, at least …
const LINE_INTERVAL: Duration = Duration::from_secs(2);
/// … and as a share of a run of known length, so that an hour does not fill a log.
const LINES_PER_RUN: f64 = 60.0;
/// Steps of the bar per second of the run.
const STEPS_PER_S: f64 = 20.0;
/// Time between two pictures of the panel: numbers that change faster cannot be read.
const PANEL_INTERVAL: Duration = Duration::from_millis(200);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    /// The model as it is fitted.
    Fit,
    /// What a hand does to a rendered model, and what it feels.
    Rendering,
    /// How far the run is, and what was lost.
    Time,
}

/// Shows how far the run is and how it goes.
pub(crate) struct Progress {
    shown: Shown,
    until: Option<Share>,
    bar: Option<ProgressBar>,
    whole_panel: bool,
    next: Instant,
    interval: Duration,
}

impl Progress {
    /// For a run that has just begun.
    pub(crate) fn new(run: &SupervisedRun) -> Self {
        let shown = run.shown;
        let duration_s = (!run.request.is_open_ended()).then_some(run.request.duration_s);
        let size = terminal::size();
        // A panel that does not fit would scroll instead of staying where it is.
        let whole_panel =
            shown == Shown::Fit && size.is_some_and(|(rows, columns)| rows > FIT_LINES && columns >= WIDTH);
        let bar = size.map(|_| {
            let template = match (duration_s, whole_panel) {
                (Some(_), true) => "{bar:38}  {prefix}\n{msg}",
                (Some(_), false) => "{bar:16} {msg}",
                (None, _) => "{msg}",
            };
            let bar = terminal::bar(duration_s.map(steps), template);
            hold_panel(Some(bar.clone()));
            bar
        });
        let lines = duration_s.and_then(|duration_s| Duration::try_from_secs_f64(duration_s / LINES_PER_RUN).ok());
        let line_interval = lines.map_or(LINE_INTERVAL, |interval| interval.max(LINE_INTERVAL));
        let (first, interval) =
            if bar.is_some() { (Duration::ZERO, PANEL_INTERVAL) } else { (line_interval, line_interval) };
        Self { shown, until: run.until, bar, whole_panel, next: Instant::now() + first, interval }
    }

    pub(crate) fn show(&mut self, link: &LoopLink) {
        if Instant::now() < self.next {
            return;
        }
        self.next = Instant::now() + self.interval;
        let line = || match self.shown {
            Shown::Fit => fit_line(link, self.until),
            Shown::Rendering => rendering_line(link),
            Shown::Time => time_line(link),
        };
        match &self.bar {
            None => say(line()),
            Some(bar) => {
                if self.whole_panel {
                    bar.set_prefix(panel::time(link, bar.length()));
                    bar.set_message(panel::below(link, self.until));
                } else {
                    bar.set_message(operator::visible(&line()).into_owned());
                }
                bar.set_position(steps(link.elapsed_s()));
            }
        }
    }
}

/// However the run ends, the terminal is left as it was.
impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            hold_panel(None);
            bar.finish_and_clear();
        }
    }
}

fn steps(time_s: f64) -> u64 {
    (time_s * STEPS_PER_S).ceil() as u64
}

/// How far run and fit are, how late the loop was and what was lost.
fn fit_line(link: &LoopLink, until: Option<Share>) -> String {
    let axis = link.run.axis;
    let known = link.fit().map_or_else(String::new, |fit| {
        let residual = if fit.residual_rms_mnm.is_finite() {
            axis.words(&format!(", residual {:.*} mNm", 2 + finer(axis), fit.residual_rms_mnm)).into_owned()
        } else {
            String::new()
        };
        format!("{residual}, {}", known_words(&estimate_of(fit).parameters, until))
    });
    format!("{}{known}", time_line(link))
}

/// How far the run is, how late the loop was and what was lost.
fn time_line(link: &LoopLink) -> String {
    format!("{:5.1} s, {}", link.elapsed_s(), losses(link))
}

/// How many parameters are known well enough, or the one that an end of the sweep waits for most.
fn known_words(parameters: &[LiveParameter], until: Option<Share>) -> String {
    match (until, open(parameters).first()) {
        (Some(share), None) => format!("all within {share}"),
        (Some(_), Some(least_known)) => share_words(least_known),
        (None, _) => {
            let in_model = parameters.iter().filter(|known| known.is_in_model());
            format!("{} of {} known", in_model.clone().filter(|known| known.is_settled()).count(), in_model.count())
        }
    }
}

/// Digits that a load in N takes more than one in mNm.
fn finer(axis: Axis) -> usize {
    if axis.is_rotary() { 0 } else { 2 }
}

/// What a hand does to a rendered model, and what it feels.
fn rendering_line(link: &LoopLink) -> String {
    let status = &link.status;
    let contact = if status.flags & Sample::STUCK == 0 { "sliding" } else { "stuck" };
    let model = link.models.last().map_or("", |model| model.name.as_str());
    let axis = link.run.axis;
    let felt =
        format!("{:+.3} rad, {contact}, hand {:+.*} mNm", status.angle_rad, 1 + finer(axis), link.hand_torque_mnm());
    format!(
        "{:5.1} s, {}, late by {:.3} ms at most, {} missed, {model}",
        link.elapsed_s(),
        axis.words(&felt),
        status.max_lateness_ns as f64 / 1e6,
        status.missed_ticks
    )
}
