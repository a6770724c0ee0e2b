//! How much the knob may be turned for a diagnosis.

use std::str::FromStr;

/// Most captures, or most seconds of turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// So many captures.
    Captures(usize),
    /// So long, s.
    Seconds(f64),
}

/// A budget that is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give a number of captures, as 5, or seconds of turning, as 60s")]
pub struct BudgetError;

impl FromStr for Budget {
    type Err = BudgetError;

    fn from_str(text: &str) -> Result<Self, BudgetError> {
        match text.strip_suffix('s') {
            Some(seconds) => match seconds.trim().parse() {
                Ok(seconds) if f64::is_finite(seconds) && seconds > 0.0 => Ok(Self::Seconds(seconds)),
                _ => Err(BudgetError),
            },
            None => text.parse().map(Self::Captures).map_err(|_| BudgetError),
        }
    }
}

impl Budget {
    /// Whether one more capture of `duration_s` is within it after `captures` that took `turned_s` in all.
    pub fn permits(self, captures: usize, turned_s: f64, duration_s: f64) -> bool {
        match self {
            Self::Captures(most) => captures < most,
            Self::Seconds(most_s) => turned_s + duration_s <= most_s * (1.0 + 1e-9),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Budget, BudgetError};

    #[test]
    fn a_budget_is_captures_or_seconds_of_turning() {
        assert_eq!("5".parse(), Ok(Budget::Captures(5)));
        assert_eq!("60s".parse(), Ok(Budget::Seconds(60.0)));
        for nothing in ["", "s", "-3", "-3s", "5m", "NaNs", "1.5"] {
            assert_eq!(nothing.parse::<Budget>(), Err(BudgetError), "{nothing}");
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
