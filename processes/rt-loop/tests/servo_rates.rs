//! At which rates the servo holds which knob: what the plan says, against the simulated rig.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
#![allow(clippy::print_stdout, reason = "figures that are not asserted are printed")]

use clap::Parser as _;
use rt_loop::control::{ControlState, Reading, Request};
use rt_loop::plan::{Plan, PlanError};
use rt_loop::request::Options;
use shared_types::Fault;

const RATES_HZ: [f64; 7] = [500.0, 700.0, 1_000.0, 2_000.0, 3_300.0, 5_000.0, 20_000.0];

/// Rate from which on each of them is accepted, Hz.
const ACCEPTED_HZ: f64 = 5_000.0;
/// Rate from which on the servo also follows each that is accepted, Hz.
const FAST_HZ: f64 = 2_000.0;

fn plan(knob: &str, rate_hz: f64, further: &[&str]) -> Result<Plan, PlanError> {
    let arguments = ["rt-loop".to_owned(), format!("--knob={knob}"), format!("--rate-hz={rate_hz}")];
    let arguments = arguments.into_iter().chain(further.iter().map(|&argument| argument.to_owned()));
    Plan::new(&Options::try_parse_from(arguments).unwrap().into())
}

/// Makes a run without a clock, of which the host serves every tick whose number `served_every` divides; the fault that ended it.
fn fault(plan: Plan, served_every: u64) -> Option<Fault> {
    let Plan { mut apparatus, rig, control, .. } = plan;
    let mut state = ControlState::new(control, &rig.calibration).unwrap();
    apparatus.enable().unwrap();
    state.arm();
    for tick in (0..control.planned_ticks).step_by(served_every as usize) {
        if tick / served_every == 1_000 {
            assert!(state.request(Request::Start));
        }
        let measurement = apparatus.exchange((tick as f64 * 1e9 / control.rate_hz).round() as u64, 0.0);
        let output = state.step(&Reading { elapsed_ticks: served_every, measurement });
        let _ = apparatus.write_torque(output.torque_mnm);
    }
    state.fault()
}

#[test]
fn no_rate_that_is_accepted_makes_the_servo_shake_one_of_the_papers_knobs() {
    for knob in ["1", "2", "3", "4", "5"] {
        for rate_hz in RATES_HZ {
            let Ok(plan) = plan(knob, rate_hz, &["--duration-s=3"]) else {
                assert!(rate_hz < ACCEPTED_HZ, "knob {knob} at {rate_hz} Hz");
                println!("knob {knob} at {rate_hz} Hz: refused");
                continue;
            };
            let fault = fault(plan, 1);
            println!("knob {knob} at {rate_hz} Hz: {fault:?}");
            // A slow servo is soft: it may fall behind a knob that takes much torque, but it does not shake it.
            let lags = rate_hz < FAST_HZ && fault == Some(Fault::FollowingError);
            assert!(fault.is_none() || lags, "knob {knob} at {rate_hz} Hz: {fault:?}");
        }
    }
}

#[test]
fn a_host_that_misses_most_ticks_does_not_make_the_servo_shake_the_knob() {
    for (rate_hz, most) in [(5_000.0, 8), (10_000.0, 8), (20_000.0, 6)] {
        for served_every in 2..=most {
            let fault = fault(plan("3", rate_hz, &["--duration-s=6"]).unwrap(), served_every);
            assert_eq!(fault, None, "every {served_every} at {rate_hz} Hz");
        }
    }
}

#[test]
fn a_rig_whose_servo_would_shake_the_knob_is_refused_whatever_the_rate() {
    let folder = tempfile::tempdir().unwrap();
    let mut known = plan("3", 10_000.0, &[]).unwrap().rig.calibration;
    // So soft a sensor that rotor and knob swing against each other far below the notch of any rotor.
    known.torque_sensor_stiffness_mnm_rad = 200.0;
    let path = folder.path().join("soft.toml");
    std::fs::write(&path, known.to_toml()).unwrap();
    let calibration = format!("--calibration={}", path.display());
    for rate_hz in RATES_HZ {
        let Err(error @ PlanError::Unstable { .. }) = plan("3", rate_hz, &[&calibration]) else {
            panic!("{rate_hz} Hz")
        };
        assert!(error.to_string().contains("servo would be unstable"), "{error}");
    }
}

#[test]
fn a_run_that_commands_a_torque_has_no_servo_to_shake_it() {
    assert!(plan("1", 2_000.0, &["--torque"]).is_ok());
}
