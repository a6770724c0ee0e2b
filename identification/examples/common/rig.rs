//! Captures from the simulated rig, driven by the instrument's own servo, without a clock.

use dynamics::effects::detent;
use dynamics::{Calibration, Excitation, Model};
use hal::Apparatus;
use hal::simulated::{RigParameters, SimulatedRig, Truth};
use identification::Samples;
use rt_loop::control::{ControlPlan, ControlState, Reading, Request, ServoGains};

/// Sample rate of the studies, Hz.
pub const RATE_HZ: f64 = 10_000.0;
/// Ticks during which the servo holds the knob before the sweep.
const ARMED_TICKS: u64 = 2_000;

/// A capture's columns, with what no sensor shows.
pub struct RigCapture {
    /// Time since the start of the sweep, s.
    pub t_s: Vec<f64>,
    /// Encoder, rad.
    pub angle_rad: Vec<f64>,
    /// Accelerometer, rad/s².
    pub acceleration_rad_s2: Vec<f64>,
    /// Torque sensor, mNm.
    pub torque_mnm: Vec<f64>,
    /// What the servo was told, rad.
    pub commanded_angle_rad: Vec<f64>,
    /// The plant's state.
    pub truth: Vec<Truth>,
    /// What the rig says of itself.
    pub calibration: Calibration,
}

impl RigCapture {
    /// The columns as a fit takes them.
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: None,
            acceleration_rad_s2: Some(&self.acceleration_rad_s2),
            torque_mnm: &self.torque_mnm,
        }
    }
}

/// Captures `knob` for `duration_s`.
///
/// # Errors
/// What rig or loop say.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss, reason = "ticks")]
pub fn capture(
    knob: &Model,
    excitation: Excitation,
    parameters: RigParameters,
    duration_s: f64,
    seed: u64,
) -> Result<RigCapture, Box<dyn std::error::Error + Send + Sync>> {
    let mut rig = SimulatedRig::new(parameters, knob.clone(), seed)?;
    let calibration = rig.description().calibration.clone();
    let planned_ticks = (duration_s * RATE_HZ) as u64;
    let limits = rig.description().limits;
    let plan = ControlPlan { excitation, gains: ServoGains::default(), limits, rate_hz: RATE_HZ, planned_ticks };
    let mut control = ControlState::new(plan, &calibration).ok_or("the rate is too low for the loop's filters")?;
    rig.enable()?;
    control.arm();
    let mut capture = RigCapture {
        t_s: Vec::new(),
        angle_rad: Vec::new(),
        acceleration_rad_s2: Vec::new(),
        torque_mnm: Vec::new(),
        commanded_angle_rad: Vec::new(),
        truth: Vec::new(),
        calibration,
    };
    for tick in 0..ARMED_TICKS + planned_ticks {
        if tick == ARMED_TICKS {
            control.request(Request::Start);
        }
        let measurement = rig.read((tick as f64 / RATE_HZ * 1e9).round() as u64)?;
        let output = control.step(&Reading { elapsed_ticks: 1, measurement: Ok(measurement) });
        rig.write_torque(output.torque_mnm)?;
        if let Some(fault) = control.fault() {
            return Err(format!("the loop stopped at tick {tick}: {fault:?}").into());
        }
        if let Some(sample) = output.sample {
            capture.t_s.push(sample.tick as f64 / RATE_HZ);
            capture.angle_rad.push(measurement.angle_rad);
            capture.acceleration_rad_s2.push(measurement.acceleration_rad_s2);
            capture.torque_mnm.push(measurement.torque_mnm);
            capture.commanded_angle_rad.push(sample.commanded_angle_rad);
            capture.truth.push(rig.truth());
        }
    }
    Ok(capture)
}

/// A knob's parameter as a fit would write it: detents with a positive amplitude.
pub fn true_value(knob: &Model, name: &str) -> Option<f64> {
    let canonical = || knob.effect("detent").map(|e| detent::canonical(e.values()[0], e.values()[2]));
    match name {
        "detent_amplitude" => canonical().map(|(amplitude, _)| amplitude),
        "detent_phase" => canonical().map(|(_, phase)| phase),
        _ => knob.parameter(name),
    }
}
