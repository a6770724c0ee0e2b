//! Where the knob rests, as the encoder shows it.

use std::ops::Range;

/// Standard deviations of the angle's noise that a resting angle may span: a rest on the edge between two steps of the
/// encoder spans one step, which is 3.5 of them.
const SPAN: f64 = 6.0;
/// What rounding does to an angle without noise, rad.
const ROUNDING_RAD: f64 = 1e-9;

/// Stretches of at least `shortest` samples in which every window of that length spans no more than noise does.
pub(super) fn rests(angle_rad: &[f64], noise_rad: f64, measured: &[bool], shortest: usize) -> Vec<Range<usize>> {
    let tolerance_rad = SPAN * noise_rad + ROUNDING_RAD;
    let mut rests: Vec<Range<usize>> = Vec::new();
    let mut open = false;
    for (first, window) in angle_rad.windows(shortest.max(1)).enumerate() {
        let end = first + window.len();
        let still = spans_at_most(window, tolerance_rad) && measured[first..end].iter().all(|measured| *measured);
        match rests.last_mut() {
            Some(rest) if still && open => rest.end = end,
            _ if still => rests.push(first..end),
            _ => {}
        }
        open = still;
    }
    rests
}

/// Gives up at the first sample that is too far away: a moving knob costs little.
fn spans_at_most(window: &[f64], tolerance_rad: f64) -> bool {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    window.iter().all(|angle| {
        low = low.min(*angle);
        high = high.max(*angle);
        high - low <= tolerance_rad
    })
}

#[cfg(test)]
mod tests {
    use super::rests;

    #[test]
    fn a_rest_between_two_motions_is_found_and_a_reversal_is_not_one() {
        // 100 samples of motion, 60 at rest, on again, then a parabola that only reverses.
        let moving = |n: usize| 1e-3 * f64::from(u32::try_from(n).unwrap_or(0));
        let angle: Vec<f64> = (0..400)
            .map(|n| match n {
                0..100 => moving(n),
                100..160 => moving(100),
                160..300 => moving(n - 60),
                _ => moving(240) - 1e-4 * (moving(n) * 1e3 - 350.0).powi(2),
            })
            .collect();
        let found = rests(&angle, 1e-5, &vec![true; angle.len()], 20);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].start.abs_diff(100) <= 1 && found[0].end.abs_diff(160) <= 1, "{found:?}");
    }
}
