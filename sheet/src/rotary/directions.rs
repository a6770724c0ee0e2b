//! Which way a turned control was going at every row, and how fast.

use archive::testers::Curve;
use identification::statistics::{quantile, range};

use crate::repeats::CurveError;

/// Way back, as a share of the whole travel, from which a control has turned round.
const REVERSAL: f64 = 2e-3;
/// Time over which a speed is estimated, s.
const SPEED_OVER_S: f64 = 0.02;
/// Speed above which inertia is no longer small beside what depends on the angle, rad/s.
const FASTEST_RAD_S: f64 = 2.5;
/// Share of the median speed below and above which a row belongs to a jerk.
const STEADY: [f64; 2] = [0.5, 2.0];
/// Share of the median speed with which a pass begins and ends: before and after that inertia takes torque.
const UP_TO_SPEED: f64 = 0.95;

/// +1 or −1 for the direction in which a row was passed; 0 where the control was turning round, starting or stopping.
///
/// # Errors
/// [`CurveError::TooFast`] for a control that was turned too fast for static figures.
pub(super) fn directions(curve: &Curve) -> Result<Vec<i8>, CurveError> {
    let mut directions = passes(&curve.position);
    let Some(t_s) = &curve.t_s else { return Ok(directions) };
    let speeds = speeds(t_s, &curve.position);
    let mut moving: Vec<f64> =
        speeds.iter().zip(&directions).filter(|(_, direction)| **direction != 0).map(|(speed, _)| *speed).collect();
    let median = quantile(&mut moving, 0.5);
    let fast = quantile(&mut moving, 0.9);
    if fast > FASTEST_RAD_S {
        return Err(CurveError::TooFast { speed_rad_s: fast });
    }
    trim_passes(&mut directions, |row| speeds[row] < UP_TO_SPEED * median);
    for (direction, speed) in directions.iter_mut().zip(speeds) {
        if !(STEADY[0] * median..=STEADY[1] * median).contains(&speed) {
            *direction = 0;
        }
    }
    Ok(directions)
}

/// Takes from both ends of each pass the rows that are `slow`.
fn trim_passes(directions: &mut [i8], slow: impl Fn(usize) -> bool) {
    let mut start = 0;
    for end in 1..=directions.len() {
        if directions.get(end) == Some(&directions[start]) {
            continue;
        }
        let first = (start..end).find(|row| !slow(*row)).unwrap_or(end);
        let last = (first..end).rfind(|row| !slow(*row)).map_or(first, |row| row + 1);
        directions[start..first].fill(0);
        directions[last..end].fill(0);
        start = end;
    }
}

fn passes(angle_rad: &[f64]) -> Vec<i8> {
    let [low, high] = range(angle_rad);
    let reversal = REVERSAL * (high - low);
    let mut directions = vec![0_i8; angle_rad.len()];
    let Some(first) = angle_rad.first() else { return directions };
    let (mut direction, mut furthest, mut since) = (0_i8, *first, 0);
    let mut start = *first;
    for (index, angle) in angle_rad.iter().enumerate() {
        let onwards = f64::from(direction) * (angle - furthest);
        if direction == 0 && (angle - start).abs() > reversal {
            direction = if *angle > start { 1 } else { -1 };
            (furthest, since) = (*angle, index);
        } else if onwards >= 0.0 {
            (furthest, since) = (*angle, index);
        } else if onwards < -reversal {
            // What was passed since the turning point was friction changing over.
            directions[since + 1..index].fill(0);
            direction = -direction;
            start = furthest;
            (furthest, since) = (*angle, index);
        }
        directions[index] = direction;
    }
    directions
}

/// Magnitudes of the speed at each row, rad/s.
fn speeds(t_s: &[f64], angle_rad: &[f64]) -> Vec<f64> {
    let (mut from, mut to) = (0, 0);
    let last = t_s.len() - 1;
    let at = |time: &f64| {
        while from < last && t_s[from + 1] <= time - 0.5 * SPEED_OVER_S {
            from += 1;
        }
        while to < last && t_s[to] < time + 0.5 * SPEED_OVER_S {
            to += 1;
        }
        let span_s = t_s[to] - t_s[from];
        if span_s > 0.0 { ((angle_rad[to] - angle_rad[from]) / span_s).abs() } else { 0.0 }
    };
    t_s.iter().map(at).collect()
}
