//! An angle that counts within one turn only.

use std::f64::consts::TAU;

use dynamics::Axis;

use crate::samples::span;

/// Share of a turn that no knob turns from one sample to the next.
const WRAPS: f64 = 0.75;
/// Share of a turn by which noise may make the range of a wrapped angle exceed one turn.
const MARGIN: f64 = 1e-3;

/// The angle without its jumps by a turn, and how many there were, in a sentence; `None` where there are none, and of a travel.
pub(crate) fn unwrapped(angle_rad: &[f64], axis: Axis) -> Option<(Vec<f64>, String)> {
    if !axis.is_rotary() {
        return None;
    }
    let turns_of =
        |pair: &[f64]| if (pair[1] - pair[0]).abs() > WRAPS * TAU { (pair[1] - pair[0]).signum() } else { 0.0 };
    let jumps = angle_rad.windows(2).filter(|pair| turns_of(pair) != 0.0).count();
    if jumps == 0 || span(angle_rad) > (1.0 + MARGIN) * TAU {
        return None;
    }
    let mut turns = 0.0;
    let mut unwrapped = vec![angle_rad[0]];
    for pair in angle_rad.windows(2) {
        turns -= turns_of(pair);
        unwrapped.push(pair[1] + turns * TAU);
    }
    let times = if jumps == 1 { "once".to_owned() } else { format!("{jumps} times") };
    Some((unwrapped, format!("the angle begins anew after a turn, {times}: whole turns were added to it")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_that_begins_anew_after_a_turn_goes_on() {
        let angle: Vec<f64> = (0..500).map(|index| 6.0 * (0.02 * f64::from(index)).sin()).collect();
        assert!(unwrapped(&angle, Axis::Rotary).is_none());
        let wrapped: Vec<f64> = angle.iter().map(|angle| angle.rem_euclid(TAU)).collect();
        assert!(unwrapped(&wrapped, Axis::Linear).is_none());
        let Some((found, _)) = unwrapped(&wrapped, Axis::Rotary) else { panic!("no jumps were found") };
        let shift = found[0] - angle[0];
        assert!(found.iter().zip(&angle).all(|(found, angle)| (found - angle - shift).abs() < 1e-9));
    }
}
