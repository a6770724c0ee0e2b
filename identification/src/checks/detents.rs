//! Detents counted in the torque over the angle.

use std::f64::consts::{SQRT_2, TAU};

use dynamics::Direction;

use crate::numerics::statistics::{mean, median, running, runs, student_95, without_line};
use crate::preparation::clock::typical_step;
use crate::samples::{FitError, Samples, span};

/// Correlation of the two directions' torques over angle from which they show detents.
const REPEATS: f64 = 0.5;
/// Scatter of the detents' distances, relative to their mean, beyond which they are no detents.
const UNEVEN: f64 = 0.3;
/// Most turns over which detents are counted: each takes memory.
const MOST_TURNS: f64 = 1000.0;
/// Fewest bins that both directions must have passed.
const FEWEST_BINS: usize = 100;
/// Bins of angle in one turn: a detent needs some ten of them.
const BINS_PER_TURN: f64 = 1440.0;
/// Time after missed ticks in which the torque is the servo's, catching up, and not the knob's, s.
const CATCHING_UP_S: f64 = 0.02;
/// A crossing counts once the torque has passed this share of the detents' amplitude on both sides.
const HYSTERESIS: f64 = 0.4;
/// Bins on either side over which the torque's median is taken, so that single shocks do not count, …
const MEDIAN_REACH: usize = 2;
/// … and over which it is then averaged before it is counted.
const MEAN_REACH: usize = 1;
/// Longest run of bins without samples that is bridged: 2°.
const LONGEST_BRIDGE: usize = 8;

/// Detents counted over the angle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct DetentCount {
    /// Angle over which they were counted, from the first detent to the last, rad.
    pub turned_rad: f64,
    /// Detents in it.
    pub detents: u32,
    /// Detents in a full turn, from the mean spacing of those counted.
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
/// Friction that is the same at every angle cancels in the mean of both directions' torques. The rising
/// zero crossings of this mean are the detents.
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
    let passed_rad = profile.mean_mnm.len() as f64 * TAU / BINS_PER_TURN;
    if profile.mean_mnm.len() < FEWEST_BINS {
        return Err(CountError::TooLittleTravel { passed_rad });
    }
    let crossings = profile.rising_crossings();
    if profile.correlation < REPEATS || crossings.len() < 2 {
        return Err(CountError::NoneSeen { correlation: profile.correlation });
    }
    // One spacing shows no scatter.
    if crossings.len() < 3 {
        return Err(CountError::TooLittleTravel { passed_rad });
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
    let freedom = (intervals - 1) as f64;
    // The mean spacing depends on the first and last crossing; each has the scatter of the crossings about even spacing.
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

/// Torque over angle where the knob passed both ways.
struct Profile {
    first_rad: f64,
    /// Mean of both directions' torques, bin by bin, without its straight line, mNm.
    mean_mnm: Vec<f64>,
    /// Correlation of the two directions' torques over angle.
    correlation: f64,
}

impl Profile {
    fn of(samples: &Samples<'_>) -> Self {
        let lowest = samples.angle_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let width = TAU / BINS_PER_TURN;
        let bin = |angle: f64| ((angle - lowest) / width) as usize;
        let bins = (span(samples.angle_rad) / width) as usize + 1;
        let (mut sums, mut counts) = ([vec![0.0; bins], vec![0.0; bins]], [vec![0.0; bins], vec![0.0; bins]]);
        // The direction changes once the knob has come back by two bins: noise of the encoder does not change it.
        let mut turning_point = samples.angle_rad[0];
        let mut direction: Option<Direction> = None;
        let (step_s, _) = typical_step(samples.t_s);
        let (mut previous_s, mut caught_up_s) = (samples.t_s[0], samples.t_s[0]);
        for ((time_s, angle), torque) in samples.t_s.iter().zip(samples.angle_rad).zip(samples.torque_mnm) {
            if time_s - previous_s > 1.5 * step_s {
                caught_up_s = time_s + CATCHING_UP_S;
            }
            previous_s = *time_s;
            let away = angle - turning_point;
            let turned = Some(Direction::of(away));
            if turned == direction || away.abs() > 2.0 * width {
                (direction, turning_point) = (turned, *angle);
            }
            let Some(towards) = direction else { continue };
            let side = usize::from(towards == Direction::Positive);
            if *time_s >= caught_up_s {
                sums[side][bin(*angle)] += torque;
                counts[side][bin(*angle)] += 1.0;
            }
        }
        let sides = [0, 1].map(|side| {
            let passed = sums[side].iter().zip(&counts[side]);
            bridged(&passed.map(|(sum, count)| (*count > 0.0).then(|| sum / count)).collect::<Vec<_>>())
        });
        let both: Vec<bool> = (0..bins).map(|at| sides[0][at].is_some() && sides[1][at].is_some()).collect();
        let passed = runs(&both, |one, other| one == other).filter(|run| both[run.start]);
        let run = passed.reduce(|longest, run| if run.len() > longest.len() { run } else { longest }).unwrap_or(0..0);
        let side = |side: usize| {
            let torque: Vec<f64> = sides[side][run.clone()].iter().copied().flatten().collect();
            let without_shocks = running(&torque, MEDIAN_REACH, |near| median(&mut near.to_vec()));
            let smooth = running(&without_shocks, MEAN_REACH, |near| mean(near));
            let places: Vec<f64> = (0..smooth.len()).map(|at| at as f64).collect();
            without_line(&smooth, &places).collect::<Vec<f64>>()
        };
        let (back, there) = (side(0), side(1));
        let product = |left: &[f64], right: &[f64]| left.iter().zip(right).map(|(a, b)| a * b).sum::<f64>();
        let scale = (product(&back, &back) * product(&there, &there)).sqrt();
        let mean: Vec<f64> = back.iter().zip(&there).map(|(a, b)| 0.5 * (a + b)).collect();
        Self {
            first_rad: lowest + (run.start as f64 + 0.5) * width,
            mean_mnm: mean,
            correlation: if scale > 0.0 { product(&back, &there) / scale } else { 0.0 },
        }
    }

    /// Angles at which the torque rises through its mean, rad.
    fn rising_crossings(&self) -> Vec<f64> {
        let mean_mnm = &self.mean_mnm;
        // Half of a sine's values lie below its amplitude over √2, shocks or not.
        let mut sizes: Vec<f64> = mean_mnm.iter().map(|torque| torque.abs()).collect();
        let threshold = HYSTERESIS * SQRT_2 * median(&mut sizes);
        let places = rising_crossings(mean_mnm, threshold).into_iter();
        places.map(|place| self.first_rad + place * TAU / BINS_PER_TURN).collect()
    }
}

/// Positions, in samples from the first value, at which values rise through zero from below −`threshold` to above `threshold`, so
/// that noise about zero is no crossing.
#[must_use]
pub fn rising_crossings(values: &[f64], threshold: f64) -> Vec<f64> {
    let mut crossings = Vec::new();
    let (mut low, mut candidate) = (false, None);
    for (index, pair) in values.windows(2).enumerate() {
        if pair[0] < -threshold {
            (low, candidate) = (true, None);
        }
        if low && pair[0] < 0.0 && pair[1] >= 0.0 {
            candidate = Some(index as f64 + pair[0] / (pair[0] - pair[1]));
        }
        if pair[1] > threshold
            && let Some(place) = candidate.take()
        {
            crossings.push(place);
            low = false;
        }
    }
    crossings
}

/// The values with short gaps, such as missed ticks and slips leave, bridged by straight lines.
fn bridged(values: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut bridged = values.to_vec();
    let mut before: Option<(usize, f64)> = None;
    for (index, value) in values.iter().enumerate() {
        let Some(value) = *value else { continue };
        if let Some((from, start)) = before
            && index - from <= LONGEST_BRIDGE
        {
            let slope = (value - start) / (index - from) as f64;
            (from + 1..index).for_each(|at| bridged[at] = Some(start + slope * (at - from) as f64));
        }
        before = Some((index, value));
    }
    bridged
}
