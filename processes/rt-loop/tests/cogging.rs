//! The motor's cogging, taken out while a model is rendered and while a sweep is followed.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
#![allow(clippy::print_stdout, reason = "figures for who asks for them")]

mod common;

use clap::Parser as _;
use common::Bench;
use dynamics::{Calibration, CoggingHarmonic};
use rt_loop::control::{CoggingCompensation, ControlState, Reading, Request};
use rt_loop::plan::Plan;
use rt_loop::request::Options;
use shared_types::LoopState;

const COGGING: &str = "--motor-cogging=48:1.5:0.4";
/// A hand that turns up to 3 Hz: 19 rad/s at the end, where the teeth pass at 144 Hz.
const HAND: [&str; 4] = ["--hand=linear-chirp", "--grip=6", "--amplitude=1", "--duration-s=6"];

fn calibrated(known: &mut Calibration) {
    known.motor_cogging = Some(vec![CoggingHarmonic { per_turn: 48, torque_mnm: 1.5, phase_rad: 0.4 }]);
}

/// Speed from which on the teeth pass so fast that a delay shows, rad/s.
const FAST_RAD_S: f64 = 10.0;
/// Time by which the model with which the bench begins has given way, ticks.
const SETTLED: usize = 10_000;

/// Encoder, rad, and torque sensor, mNm, while a knob that never sticks is turned.
fn felt(further: &[&str], knowing: impl Fn(&mut Calibration)) -> Vec<[f64; 2]> {
    let mut bench = Bench::on_rig(&[&HAND, further].concat(), knowing);
    let sliding = bench.sliding(0.05, 1.0, 0.0);
    bench.control.take_model(sliding).unwrap();
    bench.start();
    let mut readings = Vec::new();
    while bench.control.state() == LoopState::Running {
        let measurement = bench.read(1);
        let output = bench.step(1, measurement);
        bench.write(&output);
        readings.push([measurement.angle_rad, measurement.torque_mnm]);
    }
    readings
}

/// Amplitude at 48 periods a turn of the torque difference between two runs while they turn fast, mNm: the larger of both directions.
fn teeth_mnm(one: &[[f64; 2]], other: &[[f64; 2]]) -> f64 {
    let left = |sign: f64| {
        let mut sums = [0.0; 3];
        for row in SETTLED..one.len().min(other.len()) - 10 {
            let velocity_rad_s = (one[row + 10][0] - one[row - 10][0]) * 500.0;
            if sign * velocity_rad_s > FAST_RAD_S {
                let (sine, cosine) = (48.0 * one[row][0]).sin_cos();
                let difference_mnm = one[row][1] - other[row][1];
                for (sum, part) in sums.iter_mut().zip([1.0, sine * difference_mnm, cosine * difference_mnm]) {
                    *sum += part;
                }
            }
        }
        assert!(sums[0] > 5_000.0, "{} rows turn fast", sums[0]);
        2.0 * sums[1].hypot(sums[2]) / sums[0]
    };
    left(1.0).max(left(-1.0))
}

#[test]
fn what_the_hand_feels_of_cogging_is_gone_at_speed_too_where_its_delay_is_known() {
    let without_teeth = felt(&[], |_| ());
    let left_mnm = |knowing: &dyn Fn(&mut Calibration)| teeth_mnm(&felt(&[COGGING], knowing), &without_teeth);
    let uncompensated_mnm = left_mnm(&|_| ());
    let compensated_mnm = left_mnm(&calibrated);
    let late_mnm = left_mnm(&|known| {
        calibrated(known);
        known.command_delay_s = None;
    });
    println!(
        "felt of 1.5 mNm above {FAST_RAD_S} rad/s: {uncompensated_mnm:.4} mNm uncompensated, {compensated_mnm:.4} compensated, \
         {late_mnm:.4} where the amplifier's delay is not known"
    );
    assert!(uncompensated_mnm > 0.7);
    assert!(compensated_mnm < 0.02 * uncompensated_mnm, "{compensated_mnm} of {uncompensated_mnm} mNm");
    assert!(late_mnm > 2.0 * compensated_mnm, "{late_mnm} mNm, {compensated_mnm} mNm");
}

/// RMS of the distance from the commanded angle while the gripper alone is turned, rad.
fn behind_rad(arguments: &[&str], knowing: impl Fn(&mut Calibration)) -> f64 {
    let arguments = [&["rt-loop", "--knob=none", "--sweep=slow-turn", "--duration-s=3"], arguments].concat();
    let mut plan = Plan::new(&Options::try_parse_from(arguments).unwrap().into()).unwrap();
    knowing(&mut plan.rig.calibration);
    let mut control = ControlState::new(plan.control, &plan.rig.calibration).unwrap();
    plan.apparatus.enable().unwrap();
    control.arm();
    let (mut squares, mut count) = (0.0, 0.0);
    for tick in 0_u32.. {
        if tick == 1_000 {
            assert!(control.request(Request::Start));
        }
        let measurement = plan.apparatus.exchange(u64::from(tick) * 100_000, 0.0);
        let output = control.step(&Reading { elapsed_ticks: 1, measurement });
        plan.apparatus.write_torque(output.torque_mnm).unwrap();
        if let Some(sample) = output.sample.filter(|sample| sample.tick > 5_000) {
            squares += (sample.angle_rad - sample.commanded_angle_rad).powi(2);
            count += 1.0;
        }
        if tick > 1_000 && control.state() == LoopState::Idle {
            break;
        }
    }
    f64::sqrt(squares / count)
}

#[test]
fn a_servo_follows_a_motor_that_cogs_as_closely_as_one_that_does_not() {
    let smooth_rad = behind_rad(&[], |_| ());
    let [without_rad, with_rad] = [behind_rad(&[COGGING], |_| ()), behind_rad(&[COGGING], calibrated)];
    println!("behind by {smooth_rad:.2e} rad RMS without teeth, {without_rad:.2e} with, {with_rad:.2e} compensated");
    assert!(without_rad > 2.0 * smooth_rad, "{without_rad} rad, {smooth_rad} rad");
    assert!(with_rad < 1.1 * smooth_rad, "{with_rad} rad, {smooth_rad} rad");
}

#[test]
fn a_calibration_with_more_harmonics_than_a_tick_has_time_for_is_refused() {
    let folder = std::env::temp_dir().join(format!("haptic-camera-cogging-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut known = Plan::new(&Options::try_parse_from(["rt-loop"]).unwrap().into()).unwrap().rig.calibration;
    let planned = |known: &Calibration| {
        let path = folder.join("rig.toml");
        std::fs::write(&path, known.to_toml()).unwrap();
        let arguments = ["rt-loop".to_owned(), format!("--calibration={}", path.display())];
        Plan::new(&Options::try_parse_from(arguments).unwrap().into()).map(|_| ()).map_err(|error| error.to_string())
    };
    let harmonic = CoggingHarmonic { per_turn: 1, torque_mnm: 0.1, phase_rad: 0.0 };
    known.motor_cogging = Some(vec![harmonic; 64]);
    assert_eq!(planned(&known), Ok(()));
    known.motor_cogging = Some(vec![harmonic; 65]);
    assert!(planned(&known).unwrap_err().contains("harmonics of motor_cogging"));
    known.motor_cogging = Some(vec![CoggingHarmonic { torque_mnm: f64::NAN, ..harmonic }]);
    assert!(planned(&known).unwrap_err().contains("motor_cogging"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_torque_that_waits_for_a_tick_is_that_of_the_angle_at_which_it_acts() {
    let mut known = Plan::new(&Options::try_parse_from(["rt-loop"]).unwrap().into()).unwrap().rig.calibration;
    calibrated(&mut known);
    known.command_delay_s = Some(5e-5);
    let tooth = known.motor_cogging.as_ref().unwrap()[0];
    for (late_ticks, lead_s) in [(0.0, 0.55e-3), (1.0, 1.55e-3), (2.0, 2.55e-3)] {
        let torque_mnm = CoggingCompensation::new(&known, 1_000.0, late_ticks).torque_mnm(0.7, 12.0);
        assert!((torque_mnm - tooth.at_mnm(0.7 + 12.0 * lead_s)).abs() < 1e-9, "{late_ticks} ticks: {torque_mnm} mNm");
    }
}
