//! What the operator sees while a run goes on: a panel on a terminal, plain lines elsewhere.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use dynamics::Axis;
use dynamics::effects::{detent, friction, inertia};
use identification::live::{Convergence, LiveParameter, USUAL_SHARE};
use indicatif::ProgressBar;
use shared_types::{FitUpdate, LoopStatus, ProcessKind, Sample};

use super::SupervisedRun;
use super::loop_link::LoopLink;
use crate::outcome::{hold_panel, say};
use crate::terminal::{self, WIDTH, digits};
use crate::until_ci::{Share, estimate_of, open, share_words};

/// Time between two plain lines, at least …
const LINE_INTERVAL: Duration = Duration::from_secs(2);
/// … and as a share of a run of known length, so that an hour does not fill a log.
const LINES_PER_RUN: f64 = 60.0;
/// Steps of the bar per second of the run.
const STEPS_PER_S: f64 = 20.0;
/// Time between two pictures of the panel: numbers that change faster cannot be read.
const PANEL_INTERVAL: Duration = Duration::from_millis(200);
/// Lines of the panel: the bar, the table's head, eight parameters, and what follows.
const FIT_LINES: u16 = 14;

/// Silence of the recorder, which reports twice a second, after which lost samples can no longer be ruled out.
const RECORDER_AWAY: Duration = Duration::from_millis(1_500);
/// How long the stream keeps what a recorder missed.
const STREAM_HISTORY: Duration = Duration::from_secs(8);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    /// The model as it is fitted.
    Fit,
    /// What a hand does to a rendered model, and what it feels.
    Rendering,
    /// How far the run is, and what was lost.
    Time,
}

pub(crate) struct Progress<'run> {
    run: &'run SupervisedRun,
    bar: Option<ProgressBar>,
    whole_panel: bool,
    next: Instant,
    interval: Duration,
}

impl<'run> Progress<'run> {
    pub(crate) fn new(run: &'run SupervisedRun) -> Self {
        let duration_s = (!run.request.is_open_ended()).then_some(run.request.duration_s);
        let size = terminal::size();
        // A panel that does not fit would scroll instead of staying where it is.
        let whole_panel =
            run.shown == Shown::Fit && size.is_some_and(|(rows, columns)| rows > FIT_LINES && columns >= WIDTH);
        let bar = size.map(|_| {
            let template = match (duration_s, whole_panel) {
                (Some(_), true) => "{bar:38}  {prefix}\n{msg}",
                (Some(_), false) => "{bar:16} {msg}",
                (None, _) => "{msg}",
            };
            let bar = terminal::bar(duration_s.map(steps), template);
            hold_panel(&bar);
            bar
        });
        let lines = duration_s.and_then(|duration_s| Duration::try_from_secs_f64(duration_s / LINES_PER_RUN).ok());
        let line_interval = lines.map_or(LINE_INTERVAL, |interval| interval.max(LINE_INTERVAL));
        let (first, interval) =
            if bar.is_some() { (Duration::ZERO, PANEL_INTERVAL) } else { (line_interval, line_interval) };
        Self { run, bar, whole_panel, next: Instant::now() + first, interval }
    }

    pub(crate) fn show(&mut self, link: &LoopLink) {
        if Instant::now() < self.next {
            return;
        }
        self.next = Instant::now() + self.interval;
        let line = || match self.run.shown {
            Shown::Fit => fit_line(link, self.run.until),
            Shown::Rendering => rendering_line(link),
            Shown::Time => time_line(link),
        };
        match &self.bar {
            None => say(line()),
            Some(bar) => {
                if self.whole_panel {
                    bar.set_prefix(panel_time(link, bar.length()));
                    bar.set_message(below_bar(link, self.run.until));
                } else {
                    bar.set_message(operator::visible(&line()).into_owned());
                }
                bar.set_position(steps(link.elapsed_s()));
            }
        }
    }
}

fn steps(time_s: f64) -> u64 {
    (time_s * STEPS_PER_S).ceil() as u64
}

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

fn time_line(link: &LoopLink) -> String {
    format!("{:5.1} s, {}", link.elapsed_s(), losses(link))
}

/// How many parameters are known well enough; with `until`, the one that is known least.
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

/// Number of digits that a load in N takes beyond those of one in mNm.
fn finer(axis: Axis) -> usize {
    if axis.is_rotary() { 0 } else { 2 }
}

fn rendering_line(link: &LoopLink) -> String {
    let status = &link.status;
    let contact = if status.flags & Sample::STUCK == 0 { "sliding" } else { "stuck" };
    let model = link.models.last().map_or("", |(_, name)| name.as_str());
    let axis = link.run.axis;
    let calibration = link.run.calibration().ok().flatten();
    // On a rig that renders, the sensor reads the opposite of what the hand does.
    let hand_mnm = calibration.map_or(0.0, |known| known.torque_zero_mnm) - status.torque_mnm;
    let felt = format!("{:+.3} rad, {contact}, hand {hand_mnm:+.*} mNm", status.angle_rad, 1 + finer(axis));
    format!(
        "{:5.1} s, {}, late by {:.3} ms at most, {} missed, {model}",
        link.elapsed_s(),
        axis.words(&felt),
        status.max_lateness_ns as f64 / 1e6,
        status.missed_ticks
    )
}

fn panel_time(link: &LoopLink, planned_steps: Option<u64>) -> String {
    let planned_s = planned_steps.map(|_| link.status.planned_ticks as f64 / link.status.rate_hz.max(1.0));
    let planned = planned_s.filter(|planned_s| *planned_s > 0.0);
    format!("{:.1}{} s", link.elapsed_s(), planned.map_or_else(String::new, |planned_s| format!(" of {planned_s:.1}")))
}

/// All below the bar, at most 80 columns wide: what is known of the knob, how late the loop was, what was lost.
fn below_bar(link: &LoopLink, until: Option<Share>) -> String {
    let mut text = table(link.fit(), until);
    let residual = link.fit().map(|fit| fit.residual_rms_mnm).filter(|residual| residual.is_finite());
    let residual = residual.map_or_else(|| "-".to_owned(), |residual| format!("{residual:.3} mNm RMS"));
    let _ = write!(text, "residual  {residual}\nlateness  {}\nlosses    {}", lateness(&link.status), losses(link));
    link.run.axis.words(&text).into_owned()
}

fn table(fit: Option<&FitUpdate>, until: Option<Share>) -> String {
    let asked = until.unwrap_or(Share(USUAL_SHARE));
    let mut text =
        format!("{:<18}{:>12}{:>13}{:>9}  {:<12}needs ± {asked}\n", "parameter", "so far", "95 %", "share", "unit");
    let estimate = fit.map(estimate_of);
    // The parameters of equation 1 in its order.
    let effects = [&inertia::KIND, &friction::KIND, &detent::KIND];
    for kind in effects.into_iter().flat_map(|kind| kind.parameters) {
        let known = estimate.as_ref().and_then(|estimate| estimate.parameter(kind.name));
        let [value, half_width, share] = cells(known);
        let word = known.map_or("", word);
        let line = format!("{:<18}{value:>12}{half_width:>13}{share:>9}  {:<12}{word}", kind.name, kind.unit);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// Value, half width and its share of the value.
fn cells(known: Option<&LiveParameter>) -> [String; 3] {
    let nothing = |word: &str| [word.to_owned(), String::new(), String::new()];
    let Some(known) = known else { return nothing("-") };
    match known.value.zip(known.half_width()) {
        _ if !known.is_in_model() => nothing("none"),
        Some((value, half_width)) => {
            let digits = digits(half_width);
            let share = known.share().map(|share| 100.0 * share).filter(|share| *share < 1000.0);
            let share = share.map_or_else(|| "-".to_owned(), |share| format!("{share:.2} %"));
            [format!("{value:.digits$}"), format!("± {half_width:.digits$}"), share]
        }
        None => nothing("-"),
    }
}

fn word(known: &LiveParameter) -> &'static str {
    match known.convergence {
        _ if !known.is_in_model() => "",
        Convergence::Converged => "known",
        Convergence::Negligible => "negligible",
        Convergence::Open => "not yet",
    }
}

/// Median, 99th percentile and maximum, the first two as upper edges of their bins.
fn lateness(status: &LoopStatus) -> String {
    if status.lateness_counts.iter().sum::<u64>() == 0 {
        return "-".to_owned();
    }
    let below = |share: f64| {
        let edge_ns = status.lateness_below_ns(share);
        edge_ns.map_or_else(|| "over 10 ms".to_owned(), |edge_ns| format!("up to {}", time_in_words(edge_ns)))
    };
    format!("half {}, 99 % {}, at most {}", below(0.5), below(0.99), time_in_words(status.max_lateness_ns))
}

fn time_in_words(ns: u64) -> String {
    match ns {
        0..1_000 => format!("{ns} ns"),
        1_000..1_000_000 => format!("{:.0} µs", ns as f64 / 1e3),
        _ => format!("{:.1} ms", ns as f64 / 1e6),
    }
}

/// Ticks missed and samples lost, by whom.
fn losses(link: &LoopLink) -> String {
    let status = &link.status;
    let lost_by = |kind: ProcessKind| (kind.name(), link.health_of(kind).map_or(0, |health| health.lost_samples));
    let consumers = [ProcessKind::Recorder, ProcessKind::LiveFitter, ProcessKind::Viewer].map(lost_by);
    let mut lost = [consumers.as_slice(), &[("control loop", status.dropped_samples)]].concat();
    lost.retain(|(_, samples)| *samples > 0);
    let restarts: u32 = link.health.iter().map(|health| health.restarts).sum();
    let mut words = format!("{} ticks missed", status.missed_ticks);
    let absence = link.absence_of_recorder();
    let longest = link.longest_absence.max(absence);
    if longest > STREAM_HISTORY {
        let _ = write!(words, ", samples lost while there was no recorder for {:.1} s", longest.as_secs_f64());
    } else if absence > RECORDER_AWAY {
        let _ = write!(words, ", no recorder for {:.1} s", absence.as_secs_f64());
    } else if lost.is_empty() {
        words += ", no sample lost";
    }
    for (who, samples) in lost {
        let _ = write!(words, ", {samples} samples lost by {who}");
    }
    if restarts > 0 {
        let _ = write!(words, ", {restarts} restarts");
    }
    words
}

#[cfg(test)]
mod tests {
    use super::{FIT_LINES, lateness, table};
    use shared_types::{Estimate, FitUpdate, LoopStatus, Verdict};

    #[test]
    fn the_table_fits_a_terminal_of_80_columns_by_24_lines_whatever_is_known() {
        let wide = Estimate {
            value: -12_345.678,
            ci95_low: -12_345.679,
            ci95_high: -12_345.677,
            verdict: Verdict::Estimated.code(),
            convergence: 0,
        };
        let absurd = Estimate { value: 1e-9, ci95_low: -1e6, ci95_high: 1e6, ..wide };
        for one in [Estimate::default(), wide, absurd, Estimate { value: f64::NAN, ..wide }] {
            let update = FitUpdate { inertia: one, coulomb_negative: one, detent_phase: one, ..FitUpdate::default() };
            let text = table(Some(&update), None);
            assert!(text.lines().all(|line| line.chars().count() <= 79), "{text}");
            // The bar above; residual, lateness and losses below.
            assert_eq!(text.lines().count() + 4, usize::from(FIT_LINES) - 1);
        }
    }

    #[test]
    fn lateness_is_reported_as_the_bins_that_hold_half_and_nearly_all_ticks() {
        let mut status = LoopStatus { max_lateness_ns: 250_000, ..LoopStatus::default() };
        assert_eq!(lateness(&status), "-");
        status.lateness_counts[1] = 90;
        status.lateness_counts[4] = 9;
        status.lateness_counts[8] = 1;
        assert_eq!(lateness(&status), "half up to 100 ns, 99 % up to 3 µs, at most 250 µs");
    }
}
