//! Samples that are no readings of their own: a sensor's value held, or interpolated linearly to the next.
//!
//! A logger that is faster than its sensor repeats each reading, and a file that was interpolated to a higher rate has
//! straight lines between readings. Both look like a signal of far less noise and far more bandwidth than the sensor has: the
//! jumps from reading to reading fill the spectrum up to half the logger's rate. Only the readings are kept.

use crate::numerics::statistics::quantile;
use crate::numerics::vector;
use crate::samples::{PickedSamples, Samples};

/// Fewest readings that show a rate of their own.
const FEWEST_READINGS: usize = 50;
/// A value is held, or a line straight, up to this share of the channel's typical change: what decimals in a file leave.
const ROUNDING: f64 = 1e-4;
/// Least mean distance of readings, in samples: below, hardly any sample lies between two of them.
const LEAST_DISTANCE: f64 = 1.8;
/// Share of the readings' distances that must be the same but for one sample.
const REGULAR: f64 = 0.9;
/// Steps of an encoder by which its readings must differ at the median to be told from a slow knob's single steps.
const FEWEST_STEPS: f64 = 3.0;

/// How a channel goes from one reading to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Between {
    /// It keeps the value.
    Held,
    /// It follows a straight line.
    Interpolated,
}

/// The samples that are readings, and how they were recognised, in a sentence; `None` if every sample is a reading.
pub(crate) fn own_readings(samples: &Samples<'_>) -> Option<(PickedSamples, String)> {
    let angle = readings(samples.angle_rad, vector::smallest_step(samples.angle_rad));
    let torque = readings(samples.torque_mnm, 0.0);
    // The channel with fewer readings: at the times of its readings the other one is known too.
    let (channel, (between, indices)) = [("angle", angle), ("torque", torque)]
        .into_iter()
        .filter_map(|(channel, found)| found.map(|found| (channel, found)))
        .min_by_key(|(_, (_, indices))| indices.len())?;
    let word = match between {
        Between::Held => "repeats each reading",
        Between::Interpolated => "is a straight line from reading to reading",
    };
    let distance = samples.t_s.len() as f64 / indices.len() as f64;
    let note = format!(
        "the {channel} channel {word}, over {distance:.1} samples each: only the {} readings were used",
        indices.len()
    );
    Some((PickedSamples::of(samples, &indices), note))
}

/// The indices of a channel's readings, if they lie regularly apart; `step` is the sensor's, 0 if it has none.
fn readings(signal: &[f64], step: f64) -> Option<(Between, Vec<usize>)> {
    let changes: Vec<f64> = signal.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let bends: Vec<f64> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // A held value changes on arriving at the reading; a line bends at it.
    let held = regular_nonzero(&changes).filter(|indices| {
        let mut sizes: Vec<f64> = indices.iter().map(|index| changes[*index].abs()).collect();
        quantile(&mut sizes, 0.5) >= FEWEST_STEPS * step
    });
    let interpolated = || regular_nonzero(&bends).map(|indices| (Between::Interpolated, indices));
    let (between, indices) = held.map(|indices| (Between::Held, indices)).or_else(interpolated)?;
    Some((between, indices.into_iter().map(|index| index + 1).collect()))
}

/// The indices of the differences that are more than rounding, if those lie regularly apart.
fn regular_nonzero(differences: &[f64]) -> Option<Vec<usize>> {
    let mut sizes: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
    let too_many = |count: usize| (differences.len() as f64) < LEAST_DISTANCE * count as f64;
    // Most channels change at every sample, which the largest difference shows faster than a quantile.
    let (_, largest) = vector::extent(&sizes)?;
    if too_many(sizes.iter().filter(|size| **size > ROUNDING * largest).count()) {
        return None;
    }
    let rounding = ROUNDING * quantile(&mut sizes, 0.99);
    let indices: Vec<usize> = (0..differences.len()).filter(|index| differences[*index].abs() > rounding).collect();
    if indices.len() < FEWEST_READINGS || too_many(indices.len()) {
        return None;
    }
    let distances: Vec<usize> = indices.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let typical = *distances.clone().select_nth_unstable(distances.len() / 2).1;
    let share = |is_regular: &dyn Fn(usize) -> bool| {
        distances.iter().filter(|distance| is_regular(**distance)).count() as f64 / distances.len() as f64
    };
    // A rate that is no multiple of the sensor's gives distances of two lengths; a reading that equals the last, or lies on
    // the line through it, leaves a distance of several.
    let is_regular = share(&|distance| distance.abs_diff(typical) <= 1) >= REGULAR
        || share(&|distance| distance.is_multiple_of(typical)) >= REGULAR;
    let readings = indices.iter().zip(distances.iter().chain([&1])).flat_map(|(index, distance)| {
        let count = if distance.is_multiple_of(typical) { distance / typical } else { 1 };
        (0..count).map(move |reading| index + reading * typical)
    });
    (is_regular && typical >= 2).then(|| readings.collect())
}

#[cfg(test)]
mod tests {
    use super::{Between, readings};

    /// A motion of two tones at so many samples a second.
    fn motion(samples: usize, rate_hz: f64) -> Vec<f64> {
        let at = |index: usize| index as f64 / rate_hz;
        (0..samples).map(|index| (5.0 * at(index)).sin() + 0.2 * (17.0 * at(index)).cos()).collect()
    }

    #[test]
    fn held_and_interpolated_readings_are_found_where_they_are() {
        let sensor = motion(500, 1000.0);
        let held: Vec<f64> = (0..4990).map(|sample| sensor[sample / 10]).collect();
        let (between, places) = readings(&held, 0.0).unwrap_or((Between::Interpolated, Vec::new()));
        assert_eq!(between, Between::Held);
        assert!(places.len() >= 490 && places.iter().all(|place| place % 10 == 0), "{places:?}");

        let line = |sample: usize| {
            let part = [0.0, 0.25, 0.5, 0.75][sample % 4];
            sensor[sample / 4] + part * (sensor[sample / 4 + 1] - sensor[sample / 4])
        };
        let interpolated: Vec<f64> = (0..1990).map(line).collect();
        let (between, places) = readings(&interpolated, 0.0).unwrap_or((Between::Held, Vec::new()));
        assert_eq!(between, Between::Interpolated);
        assert!(places.len() >= 480 && places.iter().all(|place| place % 4 == 0), "{places:?}");
    }

    #[test]
    fn a_sensors_own_samples_and_the_steps_of_a_coarse_encoder_are_all_readings() {
        let sensor = motion(5000, 1000.0);
        assert!(readings(&sensor, 0.0).is_none());
        let step = 0.01;
        let coarse: Vec<f64> = sensor.iter().map(|angle| (angle / step).round() * step).collect();
        assert!(readings(&coarse, step).is_none());
        // At one speed a coarse encoder's steps lie regularly apart, one step each.
        let ramp: Vec<f64> = (0..5000).map(|index| f64::from(index / 5) * step).collect();
        assert!(readings(&ramp, step).is_none_or(|(between, _)| between == Between::Interpolated));
    }
}
