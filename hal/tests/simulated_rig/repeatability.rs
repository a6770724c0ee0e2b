//! The same run twice, and the same run at other rates.

use dynamics::knobs;
use hal::simulated_rig::{Readings, RigParameters};

use super::Run;

fn bits(measurement: &Readings) -> [u64; 3] {
    [measurement.angle_rad, measurement.acceleration_rad_s2, measurement.torque_mnm].map(f64::to_bits)
}

fn record(seed: u64) -> (Vec<[u64; 3]>, hal::simulated_rig::Truth) {
    let mut run = Run::seeded(RigParameters::default(), knobs::paper_knob(4).unwrap(), 10_000, seed);
    let readings = (0..5000).map(|tick| bits(&run.tick(80.0 * (f64::from(tick) * 2e-3).sin()))).collect();
    (readings, run.rig.truth())
}

#[test]
fn a_seed_fixes_a_run_bit_for_bit_and_another_seed_changes_only_the_noise() {
    let (first, first_truth) = record(3);
    let (again, again_truth) = record(3);
    let (other, other_truth) = record(4);
    assert_eq!(first, again);
    assert_ne!(first, other);
    assert_eq!(first_truth, again_truth);
    assert_eq!(first_truth, other_truth);
}

#[test]
fn the_plant_does_not_care_how_often_it_is_read() {
    for number in 1..=5 {
        let knob = || knobs::paper_knob(number).unwrap();
        let command_mnm = |step: u64| 300.0 * (0.003 * step as f64).sin();
        let mut slow = Run::new(RigParameters::default(), knob(), 5_000);
        let mut fast = Run::new(RigParameters::default(), knob(), 20_000);
        for step in 0..5_000 {
            slow.tick(command_mnm(step));
            fast.tick(command_mnm(step));
            assert_eq!(slow.rig.truth(), fast.rig.truth(), "knob {number} at step {step}");
            fast.ticks(3, command_mnm(step));
        }
    }
}

#[test]
fn a_smooth_command_gives_the_same_motion_at_5_and_at_20_khz() {
    let at_end = |rate_hz: u64| {
        let mut run = Run::new(RigParameters::default(), knobs::paper_knob(2).unwrap(), rate_hz);
        let mut largest_rad = 0.0_f64;
        while run.time_s() < 2.0 {
            // The middle of the tick that the command is held for.
            let time_s = run.time_s() + 0.5 * run.period_ns as f64 * 1e-9;
            run.tick(150.0 * (8.0 * time_s).sin());
            largest_rad = largest_rad.max(run.rig.truth().knob_angle_rad);
        }
        largest_rad
    };
    let (slow_rad, fast_rad) = (at_end(5_000), at_end(20_000));
    println!("largest angle {slow_rad:.6} rad at 5 kHz, {fast_rad:.6} rad at 20 kHz");
    assert!((slow_rad / fast_rad - 1.0).abs() < 1e-3);
}

#[test]
fn halving_the_substep_hardly_changes_the_motion() {
    for number in 1..=5 {
        let angle_rad = |substep_ns: u64| {
            let parameters = RigParameters { substep_ns, ..RigParameters::default() };
            let mut run = Run::new(parameters, knobs::paper_knob(number).unwrap(), 10_000);
            for step in 0..3_000 {
                run.tick(320.0 * (0.002 * f64::from(step)).sin());
            }
            run.rig.truth().knob_angle_rad
        };
        let (coarse_rad, fine_rad) = (angle_rad(10_000), angle_rad(5_000));
        println!("knob {number}: {coarse_rad:.6} rad with 10 µs, {fine_rad:.6} rad with 5 µs");
        assert!((coarse_rad - fine_rad).abs() < 2e-3 * fine_rad.abs().max(1.0));
    }
}
