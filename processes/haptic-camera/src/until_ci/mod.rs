//! How well a capture must know a knob before it may end: `capture --until-ci`.
//!
//! Whether a parameter is known well enough is the live fit's word ([`identification::live::Criterion`]). One that the data
//! cannot tell yet is waited for, since a later part of the sweep may excite it. One that the model does not have, detents on
//! a knob without them, is not.

mod knowledge;
mod rule;

use std::fmt;
use std::str::FromStr;

pub use knowledge::{Knowledge, Known};
pub use rule::StopRule;

/// The share of a parameter's value that half its interval may be wide: more than zero and less than one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share(f64);

/// A text that is no share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give half the width of the 95 % interval as a share of the value, between 0% and 100%, as in 1% or 0.5%")]
pub struct ShareError;

impl Share {
    /// The share as a number below one.
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl FromStr for Share {
    type Err = ShareError;

    /// The sign is asked for, since a bare 1 could mean all of the value.
    fn from_str(text: &str) -> Result<Self, ShareError> {
        let percent: f64 = text.trim().strip_suffix('%').ok_or(ShareError)?.trim().parse().map_err(|_| ShareError)?;
        if percent > 0.0 && percent < 100.0 { Ok(Self(percent / 100.0)) } else { Err(ShareError) }
    }
}

impl fmt::Display for Share {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} %", self.0 * 100.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Share, ShareError};

    #[test]
    fn a_share_is_a_percentage_between_nothing_and_all() {
        assert_eq!("1%".parse(), Ok(Share(0.01)));
        assert_eq!("2.5 %".parse(), Ok(Share(0.025)));
        for none in ["0", "0%", "abc", "200%", "100%", "-1%", "1", "NaN%", "inf%", "%", ""] {
            assert_eq!(none.parse::<Share>(), Err(ShareError), "{none}");
        }
    }
}
