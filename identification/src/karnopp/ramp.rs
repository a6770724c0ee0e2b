//! The torque at an instant, from the ramp before it.

use crate::regression::least_squares::LeastSquares;

use super::slide::to_f64;

/// Reads `received_mnm`, which comes `delay` samples late, at `instant` (in samples) off a parabola through the last
/// `length` samples received up to then: none of them has seen anything that happened after.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index within the capture")]
pub(super) fn ramp_end(received_mnm: &[f64], delay: f64, instant: f64, length: usize) -> Option<f64> {
    let last = instant.floor().max(0.0) as usize;
    let first = (last + 1).checked_sub(length)?;
    let torque = received_mnm.get(first..=last)?;
    let before: Vec<f64> = (first..=last).map(|index| (to_f64(index) - delay - instant) / to_f64(length)).collect();
    let columns = [vec![1.0; length], before.clone(), before.iter().map(|time| time * time).collect()];
    let parabola = LeastSquares::solve(&columns, torque, &[false; 3]);
    Some(parabola.coefficients[0])
}

#[cfg(test)]
mod tests {
    use super::ramp_end;

    #[test]
    fn a_bent_ramp_that_arrives_late_is_read_at_the_instant() {
        let torque = |time: f64| 3.0 + 0.2 * time - 0.001 * time * time;
        let received: Vec<f64> = (0..100).map(|n| torque(f64::from(n) - 1.7)).collect();
        let read = ramp_end(&received, 1.7, 60.4, 20).expect("the ramp lies within the samples");
        assert!((read - torque(60.4)).abs() < 1e-9, "{read}");
    }
}
