//! Single readings of a sensor that stand out from their neighbours, as a garbled frame or a disturbed line leaves them.

use std::borrow::Cow;

use crate::numerics::statistics::{FOURTH_DIFFERENCE_DEVIATION, fourth_difference, noise_deviation};
use crate::numerics::vector::smallest_step;
use crate::samples::Samples;

/// An outlier deviates from the cubic through its neighbours by more than this many standard deviations of the readings around it …
const STANDS_OUT: f64 = 12.0;
/// … and once it is replaced, the readings around it deviate by no more than this many.
const ORDINARY: f64 = 5.0;
/// … and both neighbours by more than this share of its deviation.
const BEYOND: f64 = 0.5;
/// Readings on either side from which that deviation is estimated, since fast motion makes it larger.
const AROUND: usize = 34;
/// Largest share of the readings that may be outliers: more are no accident.
const MOST: f64 = 0.01;
/// Share of its fourth difference by which a reading differs from the cubic through its neighbours.
const OF_FOURTH_DIFFERENCE: f64 = 1.0 / 6.0;

/// Angle and torque without such readings, and a note on each that had some.
pub(crate) fn cleaned<'a>(samples: &Samples<'a>) -> ([Cow<'a, [f64]>; 2], Vec<String>) {
    let mut notes = Vec::new();
    let columns = [(samples.angle_rad, "angle"), (samples.torque_mnm, "torque")].map(|(readings, name)| {
        let (cleaned, note) = without_outliers(readings, name).unzip();
        notes.extend(note);
        cleaned.map_or(Cow::Borrowed(readings), Cow::Owned)
    });
    (columns, notes)
}

/// A column with such readings replaced by the cubics through their neighbours, and a note that says so of the sensor called `name`; `None` where
/// there are none.
fn without_outliers(readings: &[f64], name: &str) -> Option<(Vec<f64>, String)> {
    let deviations: Vec<f64> = (0..readings.len()).map(|at| deviation(readings, at)).collect();
    let coarse = smallest_step(readings);
    // An outlier leaves readings more than two away undisturbed. Taking the median around every reading would be slow.
    let may_stand_out = |at: &usize| {
        let here = deviations[*at].abs();
        let is_quiet = |near: usize| deviations.get(near).is_none_or(|near| 2.0 * near.abs() < here);
        here > STANDS_OUT * coarse && (3..=6).all(|apart| is_quiet(at + apart) && is_quiet(at.wrapping_sub(apart)))
    };
    let candidates: Vec<usize> = (2..readings.len().saturating_sub(2)).filter(may_stand_out).collect();
    if candidates.is_empty() {
        return None;
    }
    let mut cleaned = readings.to_vec();
    let mut outliers = 0;
    for at in candidates {
        let around = at.saturating_sub(AROUND)..(at + AROUND + 1).min(readings.len());
        let typical =
            (OF_FOURTH_DIFFERENCE * FOURTH_DIFFERENCE_DEVIATION * noise_deviation(&readings[around])).max(coarse);
        // An outlier just before this reading may have been replaced by now.
        let (reading, deviates) = (cleaned[at], deviation(&cleaned, at));
        // At a step, the readings before and after it deviate from the cubic, but differ from one neighbour only.
        let is_beyond = |neighbour: f64| (reading - neighbour) / deviates > BEYOND;
        let is_beyond_both = is_beyond(cleaned[at - 1]) && is_beyond(cleaned[at + 1]);
        if deviates.abs() <= STANDS_OUT * typical || !is_beyond_both {
            continue;
        }
        cleaned[at] -= deviates;
        if (at - 2..=at + 2).all(|near| deviation(&cleaned, near).abs() <= ORDINARY * typical) {
            outliers += 1;
        } else {
            cleaned[at] = reading;
        }
    }
    let is_seldom = f64::from(outliers) <= MOST * readings.len() as f64;
    (outliers > 0 && is_seldom).then(|| {
        let note = format!(
            "single readings of the {name} that stand out from all around them: {outliers}; they were replaced by what lies between their \
             neighbours: look for a loose contact or a disturbed line"
        );
        (cleaned, note)
    })
}

/// By how much a reading differs from the cubic through the two before and the two after it; 0 next to an end.
fn deviation(readings: &[f64], at: usize) -> f64 {
    let around = at.checked_sub(2).and_then(|from| readings.get(from..)?.first_chunk());
    around.map_or(0.0, |around| OF_FOURTH_DIFFERENCE * fourth_difference(around))
}

#[cfg(test)]
mod tests {
    use super::without_outliers;

    /// A torque that reverses like Coulomb friction, with a little noise by formula.
    fn torque_mnm() -> Vec<f64> {
        let noise = |at: f64| 0.05 * ((at * 12.9898).sin() * 43_758.545).fract();
        (0..2000u32).map(f64::from).map(|at| 3.0 * (0.01 * at).sin().signum() + (0.03 * at).sin() + noise(at)).collect()
    }

    #[test]
    fn a_reading_that_stands_out_alone_is_replaced_and_nothing_else() {
        let clean = torque_mnm();
        assert!(without_outliers(&clean, "torque").is_none(), "reversals are no outliers");
        let mut disturbed = clean.clone();
        disturbed[700] += 15.0;
        disturbed[1201] -= 4.0;
        let (cleaned, note) = without_outliers(&disturbed, "torque").expect("two readings stand out");
        assert!(note.contains(": 2;"), "{note}");
        let farthest = cleaned.iter().zip(&clean).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(farthest < 0.2, "{farthest}");
    }

    #[test]
    fn steps_of_any_size_stay() {
        for percent in 1..400 {
            let mut torque = torque_mnm();
            torque[1000..].iter_mut().for_each(|torque| *torque += 0.01 * f64::from(percent));
            assert!(without_outliers(&torque, "torque").is_none(), "{percent} %");
        }
    }

    #[test]
    fn impacts_that_ring_and_peaks_that_recur_stay() {
        let mut torque = torque_mnm();
        torque[500..504].copy_from_slice(&[8.0, -6.0, 4.0, -2.0]);
        assert!(without_outliers(&torque, "torque").is_none());
        let mut torque = torque_mnm();
        torque.iter_mut().step_by(40).for_each(|torque| *torque += 5.0);
        assert!(without_outliers(&torque, "torque").is_none());
    }
}
