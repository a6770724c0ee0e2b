//! A control loop with a rig of one's own: build it under the name `rt-loop` beside `haptic-camera`, and the rig file's
//! `driver = "pendulum"` finds it.
//!
//! `cargo run --release -p rt-loop --example own_rig -- --drivers`

use hal::{Apparatus, ApparatusError, DeclaredCalls, Measurement, RigDescription, RigFile, TorqueSource};
use rt_loop::plan::PlanError;
use rt_loop::request::RunRequest;
use rt_loop::rigs::{self, Rig, RigKind};

static PENDULUM: RigKind = RigKind {
    name: "pendulum",
    description: "a pendulum on a motor, as an example",
    template: "name = \"my pendulum\"\ndriver = \"pendulum\"\n",
    make,
    scan: None,
};

fn make(file: &RigFile, request: &RunRequest) -> Result<Rig, PlanError> {
    rigs::refuse_simulated(file, request)?;
    let calibration =
        file.calibration()?.ok_or_else(|| file.error("a pendulum needs [calibration] with motor_inertia"))?;
    let limits = file.limits.ok_or_else(|| file.error("a pendulum needs [limits]"))?;
    let description = RigDescription {
        name: file.name.clone(),
        limits,
        slowest_rate_hz: 500.0,
        calibration,
        torque: TorqueSource::Motor,
        has_contact: false,
        torque_late_ticks: 1.0,
        angle_delay_s: 0.0,
        stale_limit: 0,
        watchdog_s: None,
        device: None,
        calls: DeclaredCalls::default(),
        codes: Vec::new(),
        notes: Vec::new(),
    };
    Ok(Rig {
        apparatus: Box::new(Pendulum { description, angle_rad: 0.0, speed_rad_s: 0.0, at_ns: None }),
        simulated_knob: None,
    })
}

struct Pendulum {
    description: RigDescription,
    angle_rad: f64,
    speed_rad_s: f64,
    at_ns: Option<u64>,
}

impl Apparatus for Pendulum {
    fn description(&self) -> &RigDescription {
        &self.description
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        Ok(())
    }

    fn disable(&mut self) {}

    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        let step_s = (due_ns - self.at_ns.replace(due_ns).unwrap_or(due_ns)) as f64 * 1e-9;
        let inertia = self.description.calibration.motor_inertia;
        let falling_mnm = 5.0 * self.angle_rad.sin() + 0.1 * self.speed_rad_s;
        self.speed_rad_s += step_s * (torque_mnm - falling_mnm) / inertia;
        self.angle_rad += step_s * self.speed_rad_s;
        Ok(Measurement { angle_rad: self.angle_rad, torque_mnm, ..Measurement::default() })
    }
}

fn main() -> std::process::ExitCode {
    rt_loop::program(&[&PENDULUM])
}
