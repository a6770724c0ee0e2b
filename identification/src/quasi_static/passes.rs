//! Which way a slowly turned knob was going at every sample.

use crate::preparation::motion::scatter;
use crate::samples::span;

/// A reversal counts once the knob has come back by this many times what the encoder resolves.
const REVERSAL: f64 = 10.0;
/// Travel in units of a counted reversal from which it is a motion and no noise.
const LEAST_TRAVEL: f64 = 20.0;
/// Mean speed of the passes above which inertia and viscous friction of a knob are no longer small beside the rest, rad/s.
const FASTEST_RAD_S: f64 = 0.5;
/// The travel is divided into this many places …
const PLACES: usize = 50;
/// … of which this share must have been visited: a jump from one place to another is no map.
const VISITED: f64 = 0.8;

/// +1 or −1 for the direction of the pass that a sample belongs to; 0 where that is not known: before the first pass,
/// and between a turning point and where the knob has surely turned, while friction changes over.
///
/// `None` if the knob did not wander slowly through its travel.
pub(super) fn directions(angle_rad: &[f64], duration_s: f64, resolution_rad: f64) -> Option<Vec<i8>> {
    let travel = span(angle_rad);
    let reversal = REVERSAL * resolution_rad.max(scatter(angle_rad));
    if !reversal.is_finite() || travel < LEAST_TRAVEL * reversal {
        return None;
    }
    let lowest = angle_rad.iter().copied().fold(f64::INFINITY, f64::min);
    let mut visited = [false; PLACES];
    for angle in angle_rad {
        visited[(((angle - lowest) / travel * PLACES as f64) as usize).min(PLACES - 1)] = true;
    }
    if (visited.iter().filter(|place| **place).count() as f64) < VISITED * PLACES as f64 {
        return None;
    }
    let mut directions = vec![0_i8; angle_rad.len()];
    let mut direction = 0_i8;
    let mut path = 0.0;
    // The furthest points of the pass, and where they were.
    let (mut low, mut high) = ((angle_rad[0], 0), (angle_rad[0], 0));
    for (index, angle) in angle_rad.iter().enumerate() {
        if *angle < low.0 {
            low = (*angle, index);
        }
        if *angle > high.0 {
            high = (*angle, index);
        }
        if direction >= 0 && *angle < high.0 - reversal {
            directions[high.1 + 1..index].fill(0);
            path += high.0 - low.0;
            (direction, low) = (-1, (*angle, index));
        } else if direction <= 0 && *angle > low.0 + reversal {
            directions[low.1 + 1..index].fill(0);
            path += high.0 - low.0;
            (direction, high) = (1, (*angle, index));
        }
        directions[index] = direction;
    }
    path += high.0 - low.0;
    (path < FASTEST_RAD_S * duration_s).then_some(directions)
}
