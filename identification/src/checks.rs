//! What a capture tells without a fit: detents counted, breakaways read off.
//!
//! Nothing here shares a step with [`fit`](crate::fit()) but the samples themselves, so that agreement
//! means something. The paper does the same by hand: its periods agreed with detents counted over 360°
//! within 4.8, 1.6 and 9.9 % for knobs 3, 4 and 5 (section 4.3).

use std::f64::consts::TAU;

use dynamics::{Calibration, Direction};

use crate::samples::{FitError, Samples, span};
use crate::spectrum::median;

/// Bins of angle in one turn: a detent needs some ten of them.
const BINS_PER_TURN: f64 = 1440.0;
/// Bins over which the torque's median is taken, so that single shocks do not count.
const MEDIAN_OF: usize = 5;
/// Bins over which the torque is averaged before it is counted.
const SMOOTHED: usize = 3;
/// Time after missed ticks in which the torque is the servo's, catching up, and not the knob's, s.
const CATCHING_UP_S: f64 = 0.02;
/// Agreement of the two directions' torques over angle from which they show detents, as a correlation.
const REPEATS: f64 = 0.5;
/// A crossing counts once the torque has passed this share of the detents' amplitude on both sides.
const HYSTERESIS: f64 = 0.4;
/// Longest hole in the passed angles that is bridged, bins: 2°.
const LONGEST_BRIDGE: usize = 8;
/// Scatter of the detents' distances, relative to their mean, beyond which they are no detents.
const UNEVEN: f64 = 0.3;
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
    /// The torque over the angle does not repeat.
    #[error(
        "no detents to count: the torque over the angle is not the same on the way there and back (correlation {correlation:.2})"
    )]
    NoneSeen {
        /// Correlation of the two directions' torques over angle.
        correlation: f64,
    },
    /// The torque repeats, but at uneven distances.
    #[error(
        "no detents to count: the torque over the angle rises at uneven distances (they scatter by {scatter_percent:.0} %)"
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
    // The ends of a mean spacing are two crossings, each as uncertain as their scatter about the even spacing.
    let scatter = crossings
        .iter()
        .enumerate()
        .map(|(index, angle)| (angle - crossings[0] - index as f64 * spacing_rad).powi(2))
        .sum::<f64>()
        / intervals as f64;
    let half = 1.96 * (2.0 * scatter).sqrt() / intervals as f64 + TAU / BINS_PER_TURN / intervals as f64;
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
    mean_mnm: Vec<f64>,
    correlation: f64,
}

impl Profile {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "bins of some turns"
    )]
    fn of(samples: &Samples<'_>) -> Self {
        let lowest = samples.angle_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let width = TAU / BINS_PER_TURN;
        let bin = |angle: f64| ((angle - lowest) / width) as usize;
        let bins = (span(samples.angle_rad) / width) as usize + 1;
        let (mut sums, mut counts) = ([vec![0.0; bins], vec![0.0; bins]], [vec![0.0; bins], vec![0.0; bins]]);
        // The direction of a sample is that in which the knob leaves its bin's neighbourhood, not that of encoder steps.
        let mut turning_point = samples.angle_rad[0];
        let mut direction = None;
        let mut steps: Vec<f64> = samples.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step_s = median(&mut steps);
        let (mut previous_s, mut caught_up_s) = (samples.t_s[0], samples.t_s[0]);
        for ((time_s, angle), torque) in samples.t_s.iter().zip(samples.angle_rad).zip(samples.torque_mnm) {
            if time_s - previous_s > 1.5 * step_s {
                caught_up_s = time_s + CATCHING_UP_S;
            }
            previous_s = *time_s;
            let away = angle - turning_point;
            let onwards = match direction {
                Some(Direction::Positive) => away > 0.0,
                Some(Direction::Negative) => away < 0.0,
                None => false,
            };
            if onwards {
                turning_point = *angle;
            } else if away.abs() > 2.0 * width {
                direction = Some(Direction::of(away));
                turning_point = *angle;
            }
            let side = match direction {
                Some(Direction::Negative) => 0,
                Some(Direction::Positive) => 1,
                None => continue,
            };
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
        let (first, length) = longest_run(&both);
        let side = |side: usize| {
            let torque: Vec<f64> = sides[side][first..first + length].iter().copied().flatten().collect();
            centred(&smoothed(&without_shocks(&torque)))
        };
        let (back, there) = (side(0), side(1));
        let product = |left: &[f64], right: &[f64]| left.iter().zip(right).map(|(a, b)| a * b).sum::<f64>();
        let scale = (product(&back, &back) * product(&there, &there)).sqrt();
        let mean: Vec<f64> = back.iter().zip(&there).map(|(a, b)| 0.5 * (a + b)).collect();
        Self {
            first_rad: lowest + (first as f64 + 0.5) * width,
            mean_mnm: mean,
            correlation: if scale > 0.0 { product(&back, &there) / scale } else { 0.0 },
        }
    }

    /// Angles at which the torque rises through its mean, rad.
    #[allow(clippy::cast_precision_loss, reason = "bins of some turns")]
    fn rising_crossings(&self) -> Vec<f64> {
        let mean_mnm = &self.mean_mnm;
        // Half of a sine's values lie below its amplitude over √2, shocks or not.
        let mut sizes: Vec<f64> = mean_mnm.iter().map(|torque| torque.abs()).collect();
        let threshold = HYSTERESIS * std::f64::consts::SQRT_2 * median(&mut sizes);
        let mut crossings = Vec::new();
        let mut low = false;
        let mut candidate = None;
        for (index, pair) in mean_mnm.windows(2).enumerate() {
            if pair[0] < -threshold {
                (low, candidate) = (true, None);
            }
            if low && pair[0] < 0.0 && pair[1] >= 0.0 {
                let share = pair[0] / (pair[0] - pair[1]);
                candidate = Some(self.first_rad + (index as f64 + share) * TAU / BINS_PER_TURN);
            }
            if pair[1] > threshold
                && let Some(angle) = candidate.take()
            {
                crossings.push(angle);
                low = false;
            }
        }
        crossings
    }
}

/// The values with short holes bridged by straight lines: missed ticks and slips leave such.
#[allow(clippy::cast_precision_loss, reason = "a few bins")]
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

/// Start and length of the longest run of `true`.
fn longest_run(values: &[bool]) -> (usize, usize) {
    let (mut best, mut start) = ((0, 0), 0);
    for index in 0..=values.len() {
        if values.get(index) != Some(&true) {
            if index - start > best.1 {
                best = (start, index - start);
            }
            start = index + 1;
        }
    }
    best
}

fn without_shocks(signal: &[f64]) -> Vec<f64> {
    let last = signal.len().saturating_sub(1);
    (0..signal.len())
        .map(|index| {
            median(&mut signal[index.saturating_sub(MEDIAN_OF / 2)..=(index + MEDIAN_OF / 2).min(last)].to_vec())
        })
        .collect()
}

fn smoothed(signal: &[f64]) -> Vec<f64> {
    let last = signal.len().saturating_sub(1);
    (0..signal.len())
        .map(|index| {
            let part = &signal[index.saturating_sub(SMOOTHED / 2)..=(index + SMOOTHED / 2).min(last)];
            part.iter().sum::<f64>() / part.iter().map(|_| 1.0).sum::<f64>()
        })
        .collect()
}

/// The signal without its straight line.
#[allow(clippy::cast_precision_loss, reason = "bins of some turns")]
fn centred(signal: &[f64]) -> Vec<f64> {
    let count = signal.len().max(1) as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = signal.iter().sum::<f64>() / count;
    let moment: f64 = signal.iter().enumerate().map(|(at, value)| (at as f64 - middle) * (value - mean)).sum();
    let spread: f64 = (0..signal.len()).map(|at| (at as f64 - middle).powi(2)).sum();
    let slope = moment / spread.max(f64::MIN_POSITIVE);
    signal.iter().enumerate().map(|(at, value)| value - mean - slope * (at as f64 - middle)).collect()
}

/// Shortest rest before a breakaway, s.
const REST_S: f64 = 0.020;
/// A knob that has left its rest by this much has broken away, in encoder steps …
const AWAY_STEPS: f64 = 6.0;
/// … or rad, where the encoder's step is not known.
const AWAY_RAD: f64 = 1e-4;
/// How soon after leaving its rest it must be ten times as far, s: a breakaway, not a creep.
const SOON_S: f64 = 0.030;
/// Time before the knob is seen to move from which the torque at breakaway is read, s.
const READ_S: f64 = 0.004;
/// Time over which the torque is averaged before its peak is taken, s.
const AVERAGE_S: f64 = 0.001;

/// One breakaway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Time, s.
    pub t_s: f64,
    /// Angle at which the knob rested, rad.
    pub angle_rad: f64,
    /// Whither it broke away.
    pub direction: Direction,
    /// Torque on it as it broke away, sensor's zero taken out, mNm; detents included.
    pub torque_mnm: f64,
}

/// Reads off the torques at which a resting knob breaks away.
///
/// A capture of slow ramps shows them best (`--torque --sweep torque-ramp`); any in which the knob rests
/// and slips will do. Takes zero, stiffness and encoder step from `known`.
///
/// # Errors
/// [`FitError`] for samples that are no capture of a motion.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "lengths of a few samples"
)]
pub fn breakaways(samples: &Samples<'_>, known: Option<&Calibration>) -> Result<Vec<Breakaway>, FitError> {
    samples.check()?;
    let mut steps: Vec<f64> = samples.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rate_hz = 1.0 / median(&mut steps);
    let zero_mnm = known.map_or(0.0, |known| known.torque_zero_mnm);
    let stiffness = known.map_or(f64::INFINITY, |known| known.torque_sensor_stiffness_mnm_rad);
    let twist = |torque: f64| if stiffness > 0.0 { torque / stiffness } else { 0.0 };
    // The knob itself rests while the sensor twists under the rising torque.
    let knob_rad: Vec<f64> =
        samples.angle_rad.iter().zip(samples.torque_mnm).map(|(angle, torque)| angle - twist(*torque)).collect();
    let away_rad = known.map(|known| AWAY_STEPS * known.angle_step_rad).filter(|away| *away > 0.0).unwrap_or(AWAY_RAD);
    let (rest, soon) = ((REST_S * rate_hz) as usize, (SOON_S * rate_hz) as usize);
    let read = ((READ_S * rate_hz) as usize).max(3).min(rest);
    let average = ((AVERAGE_S * rate_hz) as usize).max(3).min(read);

    let mut found = Vec::new();
    let mut start = 0;
    for index in 1..knob_rad.len() {
        if (knob_rad[index] - knob_rad[start]).abs() <= away_rad {
            continue;
        }
        let rested = index - start;
        let later = (index + soon).min(knob_rad.len() - 1);
        let moved = knob_rad[later] - knob_rad[start];
        if rested >= rest && moved.abs() > 10.0 * away_rad {
            let direction = Direction::of(moved);
            let sign = direction.sign();
            // The torque falls once the knob slides: its peak is the breakaway, a short mean keeps noise out of it.
            let peak = samples.torque_mnm[index - read..=index]
                .windows(average)
                .map(|part| sign * part.iter().sum::<f64>() / average as f64)
                .fold(f64::NEG_INFINITY, f64::max);
            found.push(Breakaway {
                t_s: samples.t_s[index],
                angle_rad: knob_rad[start],
                direction,
                torque_mnm: sign * peak - zero_mnm,
            });
        }
        start = index;
    }
    Ok(found)
}
