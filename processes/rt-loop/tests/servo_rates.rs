//! At which rates the servo holds which knob: what the plan says, against the simulated rig.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use clap::Parser as _;
use rt_loop::control::{ControlState, Reading, Request};
use rt_loop::plan::{Plan, PlanError};
use rt_loop::request::Options;
use shared_types::Fault;

const RATES_HZ: [f64; 6] = [2_000.0, 2_300.0, 2_600.0, 3_300.0, 5_000.0, 20_000.0];

fn plan(knob: &str, rate_hz: f64, further: &[&str]) -> Result<Plan, PlanError> {
    let arguments = ["rt-loop".to_owned(), format!("--knob={knob}"), format!("--rate-hz={rate_hz}")];
    let arguments = arguments.into_iter().chain(further.iter().map(|&argument| argument.to_owned()));
    Plan::new(&Options::try_parse_from(arguments).unwrap().into())
}

/// Makes a run without a clock; the fault that ended it.
fn fault(plan: Plan) -> Option<Fault> {
    let Plan { mut apparatus, rig, control, .. } = plan;
    let mut state = ControlState::new(control, &rig.calibration).unwrap();
    apparatus.enable().unwrap();
    state.arm();
    for tick in 0..control.planned_ticks {
        if tick == 1_000 {
            assert!(state.request(Request::Start));
        }
        let measurement = apparatus.read((tick as f64 * 1e9 / control.rate_hz).round() as u64);
        let output = state.step(&Reading { elapsed_ticks: 1, measurement });
        let _ = apparatus.write_torque(output.torque_mnm);
    }
    state.fault()
}

#[test]
fn no_rate_that_is_accepted_makes_the_servo_shake_one_of_the_papers_knobs() {
    for knob in ["1", "2", "3", "4", "5"] {
        for rate_hz in RATES_HZ {
            if let Ok(plan) = plan(knob, rate_hz, &["--duration-s=3"]) {
                assert_eq!(fault(plan), None, "knob {knob} at {rate_hz} Hz");
            }
        }
        for rate_hz in [5_000.0, 10_000.0, 20_000.0] {
            assert!(plan(knob, rate_hz, &[]).is_ok(), "knob {knob} at {rate_hz} Hz");
        }
    }
}

#[test]
fn a_rate_at_which_the_servo_would_shake_the_knob_is_refused_and_the_slowest_that_holds_it_is_named() {
    for knob in ["1", "2", "4"] {
        let Err(error @ PlanError::Unstable { .. }) = plan(knob, 2_000.0, &[]) else { panic!("knob {knob}") };
        let told = error.to_string();
        let slowest_hz: f64 = told.split_whitespace().filter_map(|word| word.parse().ok()).next_back().unwrap();
        assert!(plan(knob, slowest_hz, &[]).is_ok(), "{told}");
        assert!(plan(knob, slowest_hz - 100.0, &[]).is_err(), "{told}");
    }
}

#[test]
fn a_run_that_commands_a_torque_has_no_servo_to_shake_it() {
    assert!(plan("1", 2_000.0, &["--torque"]).is_ok());
}
