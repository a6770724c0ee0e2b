//! The panel of a capture under way: what is known of the knob, how late the loop was, what was lost. 80 columns by 16 lines.

use std::fmt::Write as _;
use std::time::Duration;

use dynamics::effects::{detent, friction, inertia};
use identification::live::{Convergence, LiveParameter, USUAL_SHARE};
use shared_types::{FitUpdate, LATENESS_BIN_EDGES_NS, LoopStatus, ProcessKind};

use super::loop_link::LoopLink;
use crate::terminal::digits;
use crate::until_ci::{Share, estimate_of};

/// Lines of the panel: the bar, the table's head, eight parameters, and what follows.
pub(super) const FIT_LINES: u16 = 14;

/// Silence of the recorder, which reports twice a second, after which it cannot be said that nothing is lost.
const RECORDER_AWAY: Duration = Duration::from_millis(1_500);
/// How long the stream keeps what a recorder missed.
const STREAM_HISTORY: Duration = Duration::from_secs(8);

/// Time in the run, beside the bar.
pub(super) fn time(link: &LoopLink, planned_steps: Option<u64>) -> String {
    let planned_s = planned_steps.map(|_| link.status.planned_ticks as f64 / link.status.rate_hz.max(1.0));
    let planned = planned_s.filter(|planned_s| *planned_s > 0.0);
    format!("{:.1}{} s", link.elapsed_s(), planned.map_or_else(String::new, |planned_s| format!(" of {planned_s:.1}")))
}

/// All below the bar.
pub(super) fn below(link: &LoopLink, until: Option<Share>) -> String {
    let mut text = table(link.fit(), until);
    let residual = link.fit().map(|fit| fit.residual_rms_mnm).filter(|residual| residual.is_finite());
    let residual = residual.map_or_else(|| "-".to_owned(), |residual| format!("{residual:.3} mNm RMS"));
    let _ = write!(text, "residual  {residual}\nlateness  {}\nlosses    {}", lateness(&link.status), losses(link));
    link.run.axis.words(&text).into_owned()
}

fn table(fit: Option<&FitUpdate>, until: Option<Share>) -> String {
    let asked = 100.0 * until.map_or(USUAL_SHARE, |share| share.0);
    let mut text =
        format!("{:<18}{:>12}{:>13}{:>9}  {:<12}needs ± {asked} %\n", "parameter", "so far", "95 %", "share", "unit");
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
    let ticks: u64 = status.lateness_counts.iter().sum();
    let below = |share: f64| {
        let wanted = (share * ticks as f64).ceil() as u64;
        let mut counted = 0;
        let bin = status.lateness_counts.iter().position(|count| {
            counted += count;
            counted >= wanted
        });
        let edge_ns = bin.and_then(|bin| LATENESS_BIN_EDGES_NS.get(bin)).copied();
        edge_ns.map_or_else(|| "over 10 ms".to_owned(), |edge_ns| format!("up to {}", time_in_words(edge_ns)))
    };
    if ticks == 0 {
        return "-".to_owned();
    }
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
pub(super) fn losses(link: &LoopLink) -> String {
    let status = &link.status;
    let lost_by = |kind: ProcessKind| (kind.name(), link.health_of(kind).map_or(0, |health| health.lost_samples));
    let consumers = [ProcessKind::Recorder, ProcessKind::LiveFitter, ProcessKind::Viewer].map(lost_by);
    let mut lost = [consumers.as_slice(), &[("control loop", status.dropped_samples)]].concat();
    lost.retain(|(_, samples)| *samples > 0);
    let restarts: u32 = link.health.iter().map(|health| health.restarts).sum();
    let mut words = format!("{} ticks missed", status.missed_ticks);
    let (absence, longest) = (link.absence_of_recorder(), link.longest_absence_of_recorder());
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
