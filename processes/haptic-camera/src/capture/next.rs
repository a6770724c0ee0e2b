//! What to do after a diagnosis: another experiment, or nothing.

use std::str::FromStr;

use identification::diagnosis::Diagnosis;

use crate::outcome::{remark, say};

/// How much the knob may be turned: most captures, or most seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    Captures(usize),
    /// Seconds of turning.
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

impl Budget {
    /// Whether the budget permits one more capture of `duration_s` after `captures` captures that took `turned_s` in all.
    pub fn permits(self, captures: usize, turned_s: f64, duration_s: f64) -> bool {
        match self {
            Self::Captures(most) => captures < most,
            Self::Seconds(most_s) => turned_s + duration_s <= most_s * (1.0 + 1e-9),
        }
    }
}

/// Relative difference of amplitudes below which two experiments are the same.
const SAME_AMPLITUDE: f64 = 0.01;

/// A motion that the knob is turned through.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Experiment {
    pub(super) sweep: String,
    /// Its amplitude, rad; `None` for the sweep's own.
    pub(super) amplitude_rad: Option<f64>,
}

impl Experiment {
    fn is_like(&self, other: &Self) -> bool {
        let close = |(one, other): (f64, f64)| (one / other - 1.0).abs() < SAME_AMPLITUDE;
        let amplitudes = self.amplitude_rad.zip(other.amplitude_rad);
        self.sweep == other.sweep && amplitudes.map_or(self.amplitude_rad == other.amplitude_rad, close)
    }
}

/// The experiment that comes after `found`, which rests on the experiments `made`; says what it is for, or why there is none.
pub(super) fn next(found: &Diagnosis, made: &[Experiment], duration_s: f64, budget: Budget) -> Option<Experiment> {
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
    let experiment = Experiment { sweep: proposed.excitation.clone(), amplitude_rad: Some(proposed.amplitude_rad) };
    if made.iter().any(|done| done.is_like(&experiment)) {
        // The best experiment did not distinguish them.
        remark(undecidable);
        return None;
    }
    if !budget.permits(captures, captures as f64 * duration_s, duration_s) {
        remark(format!("rivals are left and the budget is spent after {captures} captures"));
        return None;
    }
    let [one, other] = &proposed.tells_apart;
    say("");
    say(format!("capture {}: to discriminate between {one} and {other}", captures + 1));
    Some(experiment)
}

#[cfg(test)]
mod tests {
    use super::Budget;

    #[test]
    fn a_budget_is_captures_or_seconds_of_turning() {
        assert_eq!("5".parse(), Ok(Budget::Captures(5)));
        assert_eq!("60s".parse(), Ok(Budget::Seconds(60.0)));
        for nothing in ["", "s", "-3", "-3s", "5m", "NaNs", "1.5"] {
            assert!(nothing.parse::<Budget>().is_err(), "{nothing}");
        }
    }

    #[test]
    fn the_last_capture_may_use_the_budget_up() {
        assert!(Budget::Captures(3).permits(2, 20.0, 10.0));
        assert!(!Budget::Captures(3).permits(3, 30.0, 10.0));
        assert!(Budget::Seconds(30.0).permits(2, 20.0, 10.0));
        assert!(!Budget::Seconds(29.0).permits(2, 20.0, 10.0));
    }
}
