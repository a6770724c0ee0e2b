//! A driver that panics on the real-time thread: the amplifier must be off all the same.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser as _;
use hal::{Apparatus, ApparatusError, Measurement, RigDescription};
use rt_loop::control::ControlState;
use rt_loop::plan::Plan;
use rt_loop::realtime::TickLoop;
use rt_loop::request::Options;

/// The simulated rig until it panics at its hundredth reading.
struct Panicking {
    rig: Box<dyn Apparatus>,
    readings: u32,
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
        self.readings += 1;
        assert!(self.is_on.load(Ordering::SeqCst), "it is read only while it is on");
        assert!(self.readings < 100, "the driver's panic");
        self.rig.exchange(due_ns, torque_mnm)
    }

    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.rig.write_torque(torque_mnm)
    }
}

#[test]
fn the_amplifier_is_off_after_a_panic_of_the_real_time_thread() {
    let plan = Plan::new(&Options::try_parse_from(["rt-loop", "--knob=3", "--duration-s=3"]).unwrap().into()).unwrap();
    let control = ControlState::new(plan.control, &plan.rig.calibration).unwrap();
    let is_on = Arc::new(AtomicBool::new(false));
    let apparatus = Box::new(Panicking { rig: plan.apparatus, readings: 0, is_on: Arc::clone(&is_on) });
    let (mut tick_loop, mut port) = TickLoop::new(apparatus, control, plan.control.rate_hz);
    let outcome = std::thread::spawn(move || tick_loop.run()).join();
    assert!(outcome.is_err(), "the panic is not swallowed");
    assert!(!is_on.load(Ordering::SeqCst));
    assert!(port.samples.pop().is_err(), "no sample before the run began");
}
