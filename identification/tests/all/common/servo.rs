//! Captures from the simulated rig, driven by the instrument's own servo, without a clock.

use dynamics::{Drive, Excitation, Model};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};
use rt_loop::control::{ControlPlan, ControlState, Reading, Request, ServoGains};

use super::{Capture, Failure, RATE_HZ};

/// Ticks during which the servo holds the knob before the sweep.
const ARMED_TICKS: u64 = 2_000;

/// Captures `knob` for `duration_s` with a position sweep of that name and amplitude.
///
/// # Errors
/// What rig or loop say.
pub fn captured_at(
    knob: &Model,
    sweep: &str,
    amplitude_rad: f64,
    parameters: RigParameters,
    duration_s: f64,
    seed: u64,
) -> Result<Capture, Failure> {
    let excitation = Excitation::named(sweep, Drive::Position)?.with_amplitude(amplitude_rad)?;
    captured(knob, excitation, parameters, duration_s, seed)
}

/// Captures `knob` for `duration_s`.
///
/// # Errors
/// What rig or loop say.
pub fn captured(
    knob: &Model,
    excitation: Excitation,
    parameters: RigParameters,
    duration_s: f64,
    seed: u64,
) -> Result<Capture, Failure> {
    commanded(knob, excitation, parameters, duration_s, seed).map(|run| run.capture)
}

/// A capture with what was commanded.
pub struct Commanded {
    /// The capture.
    pub capture: Capture,
    /// Torque commanded at each sample, mNm.
    pub commanded_mnm: Vec<f64>,
}

/// The same with what was commanded.
///
/// # Errors
/// What rig or loop say.
pub fn commanded(
    knob: &Model,
    excitation: Excitation,
    parameters: RigParameters,
    duration_s: f64,
    seed: u64,
) -> Result<Commanded, Failure> {
    let mut rig = SimulatedRig::new(parameters, knob.clone(), seed)?;
    let calibration = rig.description().calibration.clone();
    let planned_ticks = (duration_s * RATE_HZ) as u64;
    let limits = rig.description().limits;
    let plan = ControlPlan {
        excitation,
        gains: ServoGains::default(),
        limits,
        rate_hz: RATE_HZ,
        planned_ticks,
        stale_limit: 0,
        torque_late_ticks: 0.0,
    };
    let mut control = ControlState::new(plan, &calibration).ok_or("the rate is too low for the loop's filters")?;
    rig.enable()?;
    control.arm();
    let mut capture = Capture { calibration: Some(calibration), ..Capture::default() };
    let (mut acceleration_rad_s2, mut commanded_mnm) = (Vec::new(), Vec::new());
    for tick in 0..ARMED_TICKS + planned_ticks {
        if tick == ARMED_TICKS {
            control.request(Request::Start);
        }
        let measurement = rig.read((tick as f64 / RATE_HZ * 1e9).round() as u64)?;
        let output = control.step(&Reading { elapsed_ticks: 1, measurement: Ok(measurement.into()) });
        rig.write_torque(output.torque_mnm)?;
        if let Some(fault) = control.fault() {
            return Err(format!("the loop stopped at tick {tick}: {fault:?}").into());
        }
        if let Some(sample) = output.sample {
            capture.t_s.push(sample.tick as f64 / RATE_HZ);
            capture.angle_rad.push(measurement.angle_rad);
            acceleration_rad_s2.push(measurement.acceleration_rad_s2);
            capture.torque_mnm.push(measurement.torque_mnm);
            commanded_mnm.push(sample.commanded_torque_mnm);
        }
    }
    Ok(Commanded { capture: Capture { acceleration_rad_s2: Some(acceleration_rad_s2), ..capture }, commanded_mnm })
}
