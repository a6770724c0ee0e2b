//! How much the knob may be turned for a diagnosis.

use std::str::FromStr;

/// Most captures, or most seconds of turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    Captures(usize),
    /// So long, s.
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
