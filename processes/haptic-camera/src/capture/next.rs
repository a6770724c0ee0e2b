//! What to do after a diagnosis: another experiment, or nothing.

use std::str::FromStr;

use identification::diagnosis::Diagnosis;
use rt_loop::request::RunRequest;

use crate::outcome::{remark, say};

/// How much the knob may be turned: most captures, or most seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    Captures(usize),
    Seconds(f64),
}

impl FromStr for Budget {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_time = |seconds: &f64| seconds.is_finite() && *seconds > 0.0;
        let budget = match text.strip_suffix('s') {
            Some(seconds) => seconds.trim().parse().ok().filter(is_time).map(Self::Seconds),
            None => text.parse().ok().map(Self::Captures),
        };
        budget.ok_or("give a number of captures, as 5, or seconds of turning, as 60s")
    }
}

/// Relative difference of amplitudes below which two experiments are the same.
const SAME_AMPLITUDE: f64 = 0.01;

fn are_alike(one: &RunRequest, other: &RunRequest) -> bool {
    let close = |(one, other): (f64, f64)| (one / other - 1.0).abs() < SAME_AMPLITUDE;
    one.sweep == other.sweep && one.amplitude.zip(other.amplitude).map_or(one.amplitude == other.amplitude, close)
}

/// The experiment that comes after `found`, which rests on the experiments `made`; says what it is for, or why there is none.
pub(super) fn next(found: &Diagnosis, made: &[RunRequest], budget: Budget) -> Option<RunRequest> {
    let undecidable = "no experiment within reach discriminates between the remaining rivals; if the knob may be turned \
                       further, give --reach";
    let captures = made.len();
    let Some(proposed) = &found.next_experiment else {
        if found.steps.iter().any(|step| !step.ties.is_empty()) {
            remark(undecidable);
        } else if found.is_floor_doubtful() {
            remark(format!(
                "no rivals are left after {captures} captures, but the noise floor, and so the verdict, is doubtful"
            ));
        } else {
            say(format!("settled after {captures} captures"));
        }
        return None;
    };
    let (sweep, amplitude) = (proposed.excitation.clone(), Some(proposed.amplitude_rad));
    let experiment = RunRequest { sweep, amplitude, ..made.first()?.clone() };
    if made.iter().any(|done| are_alike(done, &experiment)) {
        // The best experiment did not distinguish them.
        remark(undecidable);
        return None;
    }
    let turned_s = (captures + 1) as f64 * experiment.duration_s;
    let is_spent = match budget {
        Budget::Captures(most) => captures >= most,
        Budget::Seconds(most_s) => turned_s > most_s * (1.0 + 1e-9),
    };
    if is_spent {
        remark(format!("rivals are left and the budget is spent after {captures} captures"));
        return None;
    }
    let [one, other] = &proposed.tells_apart;
    say("");
    say(format!("capture {}: to discriminate between {one} and {other}", captures + 1));
    Some(experiment)
}
