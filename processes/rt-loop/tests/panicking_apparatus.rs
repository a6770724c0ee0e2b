//! The amplifier is off once nothing is to be driven: after a run, and after a panic of the driver on the real-time thread.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Parser as _;
use hal::{Apparatus, ApparatusError, Measurement, RigDescription};
use rt_loop::control::{ControlState, Request};
use rt_loop::plan::Plan;
use rt_loop::realtime::{LoopPort, TickLoop};
use rt_loop::request::Options;
use shared_types::LoopState;

/// The simulated rig until it panics, after so many readings.
struct Panicking {
    rig: Box<dyn Apparatus>,
    readings_left: u32,
    is_on: Arc<AtomicBool>,
}

impl Apparatus for Panicking {
    fn description(&self) -> &RigDescription {
        self.rig.description()
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        self.is_on.store(true, Ordering::SeqCst);
        self.rig.enable()
    }

    fn disable(&mut self) {
        self.is_on.store(false, Ordering::SeqCst);
        self.rig.disable();
    }

    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        self.readings_left -= 1;
        assert!(self.is_on.load(Ordering::SeqCst), "it is read only while it is on");
        assert!(self.readings_left > 0, "the driver's panic");
        self.rig.exchange(due_ns, torque_mnm)
    }

    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.rig.write_torque(torque_mnm)
    }
}

/// A loop on that rig, its port, and whether its amplifier is on.
fn looped(readings: u32, duration: &str) -> (TickLoop, LoopPort, Arc<AtomicBool>) {
    let plan = Plan::new(&Options::try_parse_from(["rt-loop", "--knob=3", duration]).unwrap().into()).unwrap();
    let control = ControlState::new(plan.control, &plan.rig.calibration).unwrap();
    let is_on = Arc::new(AtomicBool::new(false));
    let apparatus = Box::new(Panicking { rig: plan.apparatus, readings_left: readings, is_on: Arc::clone(&is_on) });
    let (tick_loop, port) = TickLoop::new(apparatus, control, plan.control.rate_hz);
    (tick_loop, port, is_on)
}

#[test]
fn the_amplifier_is_off_after_a_panic_of_the_real_time_thread() {
    let (mut tick_loop, mut port, is_on) = looped(100, "--duration-s=3");
    let outcome = std::thread::spawn(move || tick_loop.run()).join();
    assert!(outcome.is_err(), "the panic is not swallowed");
    assert!(!is_on.load(Ordering::SeqCst));
    assert!(port.samples.pop().is_err(), "no sample before the run began");
}

#[test]
fn the_amplifier_is_off_after_a_run_though_the_loop_is_not_told_to_end() {
    let (mut tick_loop, mut port, is_on) = looped(u32::MAX, "--duration-s=0.05");
    let shared = Arc::clone(&port.shared);
    let thread = std::thread::spawn(move || tick_loop.run());
    let wait_for = |states: &[LoopState]| {
        while !states.contains(&shared.state()) {
            std::thread::sleep(Duration::from_millis(1));
        }
    };
    // A long stall of the host ends the run in a fault, by the rig's watchdog.
    wait_for(&[LoopState::Armed, LoopState::Fault]);
    assert!(is_on.load(Ordering::SeqCst) || shared.state() == LoopState::Fault);
    port.requests.push(Request::Start).unwrap();
    wait_for(&[LoopState::Idle, LoopState::Fault]);
    let served_ticks = shared.served_ticks();
    while shared.served_ticks() < served_ticks + 10 {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!is_on.load(Ordering::SeqCst));
    shared.quit();
    thread.join().unwrap().unwrap();
}
