//! Detents counted and breakaways read off, against the knobs on the simulated rig.

use crate::common::{Capture, RATE_HZ, run};
use dynamics::{Direction, Drive, Model, Motion, knobs};
use identification::checks::{Breakaway, CountError, FreeTravel, breakaways, count_detents, free_travel};

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

fn free_ways(number: u32, amplitude_rad: f64, seed: u64) -> Vec<FreeTravel> {
    let knob = knobs::paper_knob(number).unwrap();
    let creep = run(&knob, "slow-turn", Drive::Position, Some(amplitude_rad), 15.0, seed);
    free_travel(&creep.samples(), Some(creep.rig())).unwrap()
}

#[test]
fn a_creep_shows_the_lost_motion_of_knob_5() {
    let half_gap_rad = knobs::paper_knob(5).unwrap().parameter("backlash_half_gap").unwrap();
    for (amplitude_rad, seed) in [(0.05, 1), (0.1, 2), (0.2, 3), (0.4, 4)] {
        let found = free_ways(5, amplitude_rad, seed);
        let ways: Vec<f64> = found.iter().map(FreeTravel::travel_rad).collect();
        println!("knob 5, ± {amplitude_rad} rad: {ways:.4?} rad, half the gap is {half_gap_rad}");
        assert!(found.len() >= 2, "{found:?}");
        // It starts in the middle of the gap.
        assert!((ways[0] / half_gap_rad - 1.0).abs() < 0.05, "{found:?}");
        assert!(ways.iter().all(|way| *way < 2.2 * half_gap_rad), "{found:?}");
    }
}

#[test]
fn no_lost_motion_is_seen_where_there_is_none() {
    for number in 1..=4 {
        for (amplitude_rad, seed) in [(0.05, 1), (0.1, 2), (0.4, 3), (6.5, 4)] {
            let found = free_ways(number, amplitude_rad, seed);
            assert!(found.is_empty(), "knob {number}, ± {amplitude_rad} rad: {found:?}");
        }
    }
}

#[test]
fn a_capture_of_few_samples_a_second_shows_no_breakaway() {
    for rate_hz in [1.0, 10.0, 40.0, 49.9, 50.1] {
        let t_s: Vec<f64> = (0..2000).map(|row| f64::from(row) / rate_hz).collect();
        let angle_rad: Vec<f64> = (0..2000).map(|row| (f64::from(row) / 50.0).sin()).collect();
        let torque_mnm: Vec<f64> = (0..2000).map(|row| (f64::from(row) / 5.0).sin()).collect();
        let capture = Capture { t_s, angle_rad, torque_mnm, ..Capture::default() };
        let seen = breakaways(&capture.samples(), None).unwrap();
        assert!(seen.iter().all(|breakaway| breakaway.torque_mnm.is_finite()), "{rate_hz} Hz: {seen:?}");
        assert!(rate_hz > 50.0 || seen.is_empty(), "{rate_hz} Hz: {seen:?}");
    }
}
