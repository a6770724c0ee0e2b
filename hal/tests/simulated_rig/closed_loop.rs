//! A position servo drives every knob through the sweeps within the rig's limits.

#[path = "../../examples/follow_sweep/drive.rs"]
mod drive;
#[path = "../../examples/follow_sweep/servo.rs"]
mod servo;

use drive::{Conditions, Following, drive};
use dynamics::{Drive, Excitation, knobs};
use servo::Gains;

fn follow(number: u32, sweep: &str, conditions: &Conditions) -> Following {
    let knob = knobs::paper_knob(number).unwrap();
    let excitation = Excitation::named(sweep, Drive::Position).unwrap();
    let following = drive(&knob, &excitation, Gains::RECOMMENDED, conditions).unwrap();
    println!("knob {number}, {sweep}: {following:?}");
    following
}

#[test]
fn every_knob_follows_every_sweep_within_the_rigs_limits() {
    for number in 1..=5 {
        let conditions = Conditions::default();
        // Where the knob gives way the servo winds up for nothing, and runs on by as much when it catches.
        let lost_rad = knobs::paper_knob(number).unwrap().parameter("backlash_half_gap").unwrap_or(0.0);
        for sweep in ["linear-chirp", "paper", "multisine", "stepped-amplitude"] {
            let following = follow(number, sweep, &conditions);
            assert!(!following.limit_passed, "knob {number}, {sweep}: {following:?}");
            assert!(following.peak_rad < 0.03 + lost_rad, "knob {number}, {sweep}: {following:?}");
            assert!(following.command_change_mnm < 15.0, "knob {number}, {sweep}: the shaft rings, {following:?}");
        }
    }
}

#[test]
fn a_servo_that_is_a_tick_late_still_follows_at_every_rate() {
    for rate_hz in [5_000.0, 10_000.0, 20_000.0] {
        let conditions = Conditions { rate_hz, delay_ticks: 1, duration_s: 7.0, ..Conditions::default() };
        for number in 1..=5 {
            let following = follow(number, "linear-chirp", &conditions);
            assert!(!following.limit_passed, "knob {number} at {rate_hz} Hz: {following:?}");
            assert!(following.command_change_mnm < 15.0, "knob {number} at {rate_hz} Hz: {following:?}");
        }
    }
}
