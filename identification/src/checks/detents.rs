//! Detents counted in the torque over the angle.

use std::f64::consts::TAU;

use super::profile::{BINS_PER_TURN, Profile};
use crate::samples::{FitError, Samples, span};
use crate::uncertainty::statistics::student_95;

/// Agreement of the two directions' torques over angle from which they show detents, as a correlation.
const REPEATS: f64 = 0.5;
/// Scatter of the detents' distances, relative to their mean, beyond which they are no detents.
const UNEVEN: f64 = 0.3;
/// Most turns over which detents are counted; each takes memory, and ten would do.
const MOST_TURNS: f64 = 1000.0;
/// Fewest bins that both directions must have passed.
const FEWEST_BINS: usize = 100;

/// Detents counted over the angle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct DetentCount {
    /// Angle over which they were counted, from the first detent to the last, rad.
    pub turned_rad: f64,
    /// Detents in it.
    pub detents: u32,
    /// Detents in a full turn, as the spacing of the counted ones makes it.
    pub per_turn: f64,
    /// Detent period P = spacing/2π, rad.
    pub period_rad: f64,
    /// 95 % interval of the period from the scatter of the spacings, rad.
    pub period_ci95_rad: [f64; 2],
}

/// Why no detents could be counted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CountError {
    /// Not a capture.
    #[error(transparent)]
    Samples(#[from] FitError),
    /// Too little of the travel was passed both ways.
    #[error(
        "only {:.0}° were passed in both directions, too little to count detents; capture with `--sweep slow-turn`",
        passed_rad.to_degrees()
    )]
    TooLittleTravel {
        /// Angle passed both ways, rad.
        passed_rad: f64,
    },
    /// More turns than detents are counted over.
    #[error("the knob turned {turns:.0} times, too far to count detents; capture with `--sweep slow-turn`")]
    TooManyTurns {
        /// Turns from the smallest angle to the largest.
        turns: f64,
    },
    /// The torque over the angle does not repeat.
    #[error(
        "no detents to count: the torque over the angle is not the same on the way there and back (correlation \
         {correlation:.2}); if the knob has detents, turn it more slowly, with `--sweep slow-turn`"
    )]
    NoneSeen {
        /// Correlation of the two directions' torques over angle.
        correlation: f64,
    },
    /// The torque repeats, but at uneven distances.
    #[error(
        "no detents to count: the torque over the angle rises at uneven distances (they scatter by {scatter_percent:.0} %); \
         turn the knob more slowly, or diagnose the capture, which tells several periods apart"
    )]
    Uneven {
        /// Standard deviation of the distances over their mean, %.
        scatter_percent: f64,
    },
}

/// Counts detents in the torque over the angle of a turn there and back.
///
/// The mean of both directions' torque has no friction in it that is the same at every angle. Its rising
/// zero crossings are the detents.
///
/// # Errors
/// [`CountError`] for a capture that does not turn both ways, or a knob without detents.
pub fn count_detents(samples: &Samples<'_>) -> Result<DetentCount, CountError> {
    samples.check()?;
    let turns = span(samples.angle_rad) / TAU;
    if turns > MOST_TURNS {
        return Err(CountError::TooManyTurns { turns });
    }
    let profile = Profile::of(samples);
    if profile.mean_mnm.len() < FEWEST_BINS {
        return Err(CountError::TooLittleTravel { passed_rad: profile.mean_mnm.len() as f64 * TAU / BINS_PER_TURN });
    }
    if profile.correlation < REPEATS {
        return Err(CountError::NoneSeen { correlation: profile.correlation });
    }
    let crossings = profile.rising_crossings();
    if crossings.len() < 2 {
        return Err(CountError::NoneSeen { correlation: profile.correlation });
    }
    let intervals = crossings.len() - 1;
    let turned_rad = crossings[intervals] - crossings[0];
    let spacing_rad = turned_rad / intervals as f64;
    let distances: f64 =
        crossings.windows(2).map(|pair| (pair[1] - pair[0] - spacing_rad).powi(2)).sum::<f64>() / intervals as f64;
    let uneven = distances.sqrt() / spacing_rad;
    if uneven > UNEVEN {
        return Err(CountError::Uneven { scatter_percent: 100.0 * uneven });
    }
    let freedom = (intervals - 1).max(1) as f64;
    // The ends of a mean spacing are two crossings, each as uncertain as their scatter about the even spacing.
    let scatter = crossings
        .iter()
        .enumerate()
        .map(|(index, angle)| (angle - crossings[0] - index as f64 * spacing_rad).powi(2))
        .sum::<f64>()
        / freedom;
    let half = student_95(freedom) * (2.0 * scatter).sqrt() / intervals as f64 + TAU / BINS_PER_TURN / intervals as f64;
    Ok(DetentCount {
        turned_rad,
        detents: u32::try_from(intervals).unwrap_or(u32::MAX),
        per_turn: TAU / spacing_rad,
        period_rad: spacing_rad / TAU,
        period_ci95_rad: [(spacing_rad - half) / TAU, (spacing_rad + half) / TAU],
    })
}
