//! Detents counted and breakaways read off, against the knobs on the simulated rig.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "figures that are not asserted are printed")]

mod common;

use common::{Capture, RATE_HZ, run};
use dynamics::{Direction, Drive, Model, Motion, knobs};
use identification::checks::{Breakaway, CountError, breakaways, count_detents};

#[test]
fn detents_counted_over_a_slow_turn_give_the_knobs_period() {
    // The paper's own counts agreed within 4.8, 1.6 and 9.9 %.
    for (number, turned) in [(3, 1.0), (4, 1.0), (5, 0.8)] {
        let knob = knobs::paper_knob(number).unwrap();
        let turn = run(&knob, "slow-turn", Drive::Position, None, 15.0, 1);
        let count = count_detents(&turn.samples()).unwrap();
        let truth = knob.parameter("detent_period").unwrap();
        println!("knob {number}: {count:?}, in truth {truth}");
        assert!(count.turned_rad > turned * std::f64::consts::TAU, "{count:?}");
        assert!((count.period_rad / truth - 1.0).abs() < 0.02, "knob {number}: {count:?}");
        assert_eq!(count.detents, (count.turned_rad / (std::f64::consts::TAU * truth)).round() as u32);
    }
}

#[test]
fn a_knob_without_detents_shows_none_to_count() {
    for number in [1, 2] {
        let turn = run(&knobs::paper_knob(number).unwrap(), "slow-turn", Drive::Position, None, 15.0, 1);
        let refused = count_detents(&turn.samples()).unwrap_err();
        assert!(matches!(refused, CountError::NoneSeen { .. }), "knob {number}: {refused}");
    }
}

#[test]
fn a_sweep_that_does_not_turn_far_is_refused() {
    let hold = run(&knobs::paper_knob(4).unwrap(), "tone", Drive::Position, None, 1.0, 1);
    let refused = count_detents(&hold.samples()).unwrap_err().to_string();
    assert!(refused.contains("slow-turn"), "{refused}");
}

/// Breakaways of a knob in one direction, detents taken out, as magnitudes in rising order, mNm.
fn thresholds(knob: &Model, seen: &[Breakaway], direction: Direction) -> Vec<f64> {
    let mut torques: Vec<f64> = seen
        .iter()
        .filter(|one| one.direction == direction)
        .map(|one| {
            let rest = Motion { angle_rad: one.angle_rad, ..Motion::default() };
            direction.sign() * (one.torque_mnm - knob.free_torque_mnm(&rest))
        })
        .collect();
    torques.sort_by(f64::total_cmp);
    torques
}

#[track_caller]
fn assert_thresholds(number: u32, capture: &Capture, fewest: usize) {
    let knob = knobs::paper_knob(number).unwrap();
    let steps = capture.angle_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let fastest_rad_s = steps.fold(0.0, f64::max) * RATE_HZ;
    assert!(fastest_rad_s < 60.0, "knob {number} runs away at {fastest_rad_s} rad/s");
    let seen = breakaways(&capture.samples(), Some(capture.rig())).unwrap();
    for direction in [Direction::Negative, Direction::Positive] {
        let torques = thresholds(&knob, &seen, direction);
        let limits = knob.stick_limits(&Motion::default());
        let truth = if direction == Direction::Negative { limits.negative_mnm } else { limits.positive_mnm };
        println!("knob {number} {direction:?}, up to {fastest_rad_s:.0} rad/s: {torques:.1?}, in truth {truth}");
        assert!(torques.len() >= fewest, "knob {number} broke away {} times", torques.len());
        let median = torques[torques.len() / 2];
        assert!((median / truth - 1.0).abs() < 0.05, "knob {number}: {median} mNm, in truth {truth}");
    }
}

#[test]
fn a_torque_ramp_shows_the_torque_at_which_the_knob_breaks_away() {
    for (number, amplitude_mnm) in [(2, 24.0), (3, 16.0), (4, 38.0)] {
        let knob = knobs::paper_knob(number).unwrap();
        let ramp = run(&knob, "torque-ramp", Drive::Torque, Some(amplitude_mnm), 9.6, 1);
        assert_thresholds(number, &ramp, 1);
    }
}

#[test]
fn a_creep_under_the_servo_shows_it_too_even_of_a_knob_that_would_run_away() {
    for number in 1..=4 {
        let knob = knobs::paper_knob(number).unwrap();
        let creep = run(&knob, "slow-turn", Drive::Position, Some(0.1), 15.0, 1);
        assert_thresholds(number, &creep, 1);
    }
}
