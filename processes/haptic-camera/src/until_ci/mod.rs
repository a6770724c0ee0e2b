//! How well a capture must know a knob before it may end: `capture --until-ci`.
//!
//! Whether a parameter is known well enough is the live fit's word ([`identification::live::Criterion`]). One that the data
//! cannot tell yet is waited for, since a later part of the sweep may excite it. One that the model does not have, detents on
//! a knob without them, is not.

mod knowledge;
mod rule;

use std::fmt;
use std::str::FromStr;

pub use knowledge::{estimate_of, open, share_words};
pub use rule::StopRule;

/// The share of a parameter's value that half its interval may be wide: more than zero and less than one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share(f64);

impl Share {
    /// The share as a number below one.
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl FromStr for Share {
    type Err = &'static str;

    /// The sign is asked for, since a bare 1 could mean all of the value.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let percent = text.trim().strip_suffix('%').and_then(|number| number.trim().parse().ok());
        let share = percent.filter(|percent| (0.0..100.0).contains(percent) && *percent > 0.0);
        share.map(|percent: f64| Self(percent / 100.0)).ok_or(
            "give half the width of the 95 % interval as a share of the value, between 0% and 100%, as in 1% or 0.5%",
        )
    }
}

impl fmt::Display for Share {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} %", self.0 * 100.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Share;

    #[test]
    fn a_share_is_a_percentage_between_nothing_and_all() {
        assert_eq!("1%".parse(), Ok(Share(0.01)));
        assert_eq!("2.5 %".parse(), Ok(Share(0.025)));
        for none in ["0", "0%", "abc", "200%", "100%", "-1%", "1", "NaN%", "inf%", "%", ""] {
            assert!(none.parse::<Share>().is_err(), "{none}");
        }
    }
}
