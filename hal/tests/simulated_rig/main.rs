//! The simulated rig against what is known from outside: closed forms, the motor's catalogue,
//! conservation laws and the numbers it was given.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on shall stop")]
#![allow(clippy::print_stdout, reason = "figures that are not asserted are printed")]

mod closed_loop;
mod cogging;
mod motor;
mod repeatability;
mod sensors;
mod shaft;
mod stick;
mod two_bodies;
mod watchdog;
mod waveforms;

use dynamics::{Effect, Model, effects};
use hal::Apparatus;
use hal::simulated_rig::{Readings, RigParameters, SimulatedRig};

/// The default rig without noise, steps, offsets and gravity.
fn ideal_sensors() -> RigParameters {
    RigParameters {
        angle_step_rad: 0.0,
        torque_step_mnm: 0.0,
        torque_zero_mnm: 0.0,
        acceleration_step_rad_s2: 0.0,
        acceleration_zero_rad_s2: 0.0,
        gravity_amplitude_rad_s2: 0.0,
        noise_scale: 0.0,
        ..RigParameters::default()
    }
}

/// The same with a motor that turns without friction.
fn frictionless_motor() -> RigParameters {
    RigParameters { motor_coulomb_mnm: 0.0, motor_viscous: 0.0, ..ideal_sensors() }
}

/// A knob of the given inertia and nothing else.
fn flywheel(inertia: f64) -> Model {
    Model {
        name: "flywheel".to_owned(),
        description: String::new(),
        effects: vec![Effect::new(&effects::inertia::KIND, &[inertia])],
        ..Model::default()
    }
}

/// A knob that nothing on this rig can turn.
fn clamped() -> Model {
    let holds_mnm = 1e6;
    Model { effects: vec![Effect::new(&effects::karnopp_stick::KIND, &[holds_mnm, holds_mnm, 0.01])], ..flywheel(0.0) }
}

/// A rig that is run tick by tick.
struct Run {
    rig: SimulatedRig,
    period_ns: u64,
    tick: u64,
}

impl Run {
    fn new(parameters: RigParameters, knob: Model, rate_hz: u64) -> Self {
        Self::seeded(parameters, knob, rate_hz, 1)
    }

    fn seeded(parameters: RigParameters, knob: Model, rate_hz: u64, seed: u64) -> Self {
        let mut rig = SimulatedRig::new(parameters, knob, seed).unwrap();
        rig.enable().unwrap();
        Self { rig, period_ns: 1_000_000_000 / rate_hz, tick: 0 }
    }

    /// Time of the next reading, s.
    fn time_s(&self) -> f64 {
        (self.tick * self.period_ns) as f64 * 1e-9
    }

    /// Reads and writes once.
    fn tick(&mut self, torque_mnm: f64) -> Readings {
        let measurement = self.rig.read(self.tick * self.period_ns).unwrap();
        self.rig.write_torque(torque_mnm).unwrap();
        self.tick += 1;
        measurement
    }

    /// The same for a while.
    fn ticks(&mut self, count: u64, torque_mnm: f64) {
        for _ in 0..count {
            self.tick(torque_mnm);
        }
    }
}

#[track_caller]
fn assert_close(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((value - expected).abs() <= tolerance, "{what} is {value}, expected {expected} within {tolerance}");
}
