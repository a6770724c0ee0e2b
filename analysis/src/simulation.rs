//! A model along a capture's motion or torque.

use dynamics::simulate::ForwardSimulation;
use dynamics::{Calibration, Model, Motion, shifted};
use identification::statistics::rms;
use loaded_capture::LoadedCapture;

use crate::AnalysisError;
use crate::error::same_axis;

/// What a simulation takes from a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Drive {
    /// The motion: the model's torque is simulated.
    Motion,
    /// The torque: the model's motion is simulated forward.
    Torque,
}

/// A simulated capture beside the one that it follows.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The simulated capture, of the same length and rate.
    pub capture: LoadedCapture,
    /// RMS of simulated minus captured torque along the motion, mNm, or of simulated minus captured angle under the torque, rad.
    pub rms_difference: f64,
    /// RMS of what was captured, likewise.
    pub captured_rms: f64,
}

/// Simulates the model along the motion or under the torque of a capture.
///
/// # Errors
/// [`AnalysisError`] for samples that are not a capture of a motion, and for a model that cannot be moved by the torque.
pub fn simulate(model: &Model, like: &LoadedCapture, drive: Drive) -> Result<Simulation, AnalysisError> {
    same_axis(model, like)?;
    let gripper_inertia = like.calibration.as_ref().map_or(0.0, |known| known.gripper_inertia);
    let motions = identification::knob_motion(&like.samples(), like.capture.axis, like.calibration.as_ref())?;
    let captured_mnm = torque_at_knob(like);
    let (simulated, rms_difference, captured_rms) = match drive {
        Drive::Motion => {
            let simulated = along_motion(model, gripper_inertia, &motions);
            let difference = rms_difference(&simulated.torque_mnm, &captured_mnm);
            (simulated, difference, rms(&captured_mnm))
        }
        Drive::Torque => {
            let simulated = along_torque(model, gripper_inertia, &motions, &captured_mnm)?;
            let captured: Vec<f64> = motions.iter().map(|motion| motion.angle_rad).collect();
            let difference = rms_difference(&simulated.angle_rad, &captured);
            (simulated, difference, rms(&captured))
        }
    };
    Ok(Simulation { capture: described(simulated, like, model), rms_difference, captured_rms })
}

/// Columns of a simulated capture.
pub(crate) struct Simulated {
    angle_rad: Vec<f64>,
    velocity_rad_s: Vec<f64>,
    acceleration_rad_s2: Vec<f64>,
    /// Torque that the sensor reads, mNm.
    pub(crate) torque_mnm: Vec<f64>,
}

/// What the sensor reads of the model along a given motion, what turns with the knob included.
pub(crate) fn along_motion(model: &Model, gripper_inertia: f64, motions: &[Motion]) -> Simulated {
    let mut torque_mnm = model.readings_mnm(motions);
    for (torque_mnm, motion) in torque_mnm.iter_mut().zip(motions) {
        *torque_mnm += gripper_inertia * motion.acceleration_rad_s2 - model.unsettled_friction_mnm(motion);
    }
    let time_s: Vec<f64> = motions.iter().map(|motion| motion.time_s).collect();
    Simulated {
        angle_rad: motions.iter().map(|motion| motion.angle_rad).collect(),
        velocity_rad_s: motions.iter().map(|motion| motion.velocity_rad_s).collect(),
        acceleration_rad_s2: motions.iter().map(|motion| motion.acceleration_rad_s2).collect(),
        torque_mnm: shifted(&time_s, &torque_mnm, -model.reading_delay_s()),
    }
}

/// The model's motion under a torque read as given, from rest at the capture's first angle.
fn along_torque(
    model: &Model,
    gripper_inertia: f64,
    motions: &[Motion],
    torque_mnm: &[f64],
) -> Result<Simulated, AnalysisError> {
    let start_rad = motions.first().map_or(0.0, |motion| motion.angle_rad);
    let mut simulation = ForwardSimulation::at_rest(model, gripper_inertia, start_rad)?;
    let knob_torque_mnm = model.knob_torque_mnm(motions, torque_mnm);
    let mut simulated = Simulated {
        angle_rad: Vec::with_capacity(motions.len()),
        velocity_rad_s: Vec::with_capacity(motions.len()),
        acceleration_rad_s2: Vec::with_capacity(motions.len()),
        torque_mnm: torque_mnm.to_vec(),
    };
    for (index, motion) in motions.iter().enumerate() {
        if index > 0 {
            let step_s = motion.time_s - motions[index - 1].time_s;
            simulation.advance(step_s, knob_torque_mnm[index - 1], knob_torque_mnm[index])?;
        }
        let now = simulation.motion(knob_torque_mnm[index]);
        simulated.angle_rad.push(now.angle_rad);
        simulated.velocity_rad_s.push(now.velocity_rad_s);
        simulated.acceleration_rad_s2.push(now.acceleration_rad_s2);
    }
    Ok(simulated)
}

/// The captured torque without the sensor's zero.
pub(crate) fn torque_at_knob(like: &LoadedCapture) -> Vec<f64> {
    let zero = like.calibration.as_ref().map_or(0.0, |known| known.torque_zero_mnm);
    like.capture.torque_mnm.iter().map(|torque| torque - zero).collect()
}

/// A capture of the simulated columns that says what it is: of a knob, or of a rendering if it follows one.
fn described(simulated: Simulated, like: &LoadedCapture, model: &Model) -> LoadedCapture {
    let Simulated { angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm } = simulated;
    let mut capture = like.capture.clone();
    capture.angle_rad = angle_rad;
    capture.velocity_rad_s = Some(velocity_rad_s);
    capture.acceleration_rad_s2 = Some(acceleration_rad_s2);
    capture.torque_mnm = torque_mnm;
    capture.commanded_torque_mnm = None;
    (capture.fault, capture.device_code) = (None, None);
    capture.unmeasured.clear();
    // Simulated columns have nothing to be corrected but the gripper that turns with the knob.
    let calibration = like.calibration.as_ref().map(|known| Calibration {
        torque_zero_mnm: 0.0,
        torque_delay_s: 0.0,
        acceleration_zero_rad_s2: 0.0,
        acceleration_delay_s: 0.0,
        gravity_amplitude_rad_s2: 0.0,
        torque_sensor_stiffness_mnm_rad: f64::MAX.copysign(known.torque_sensor_stiffness_mnm_rad),
        ..known.clone()
    });
    let is_of_hand = calibration.as_ref().is_some_and(Calibration::is_seen_from_the_hand);
    let mut description = capture.description_or_default();
    description.apparatus = "simulation".to_owned();
    description.knob = model.name.clone();
    let is_rendered = is_of_hand || description.is_rendered();
    let simulated =
        if is_rendered { &mut description.rendered_model_toml } else { &mut description.simulated_knob_toml };
    *simulated = Some(model.to_toml());
    // An archive holds a calibration as the rig has it.
    let of_rig = |known: &Calibration| if is_of_hand { known.seen_from_the_hand() } else { known.clone() };
    description.calibration_toml = calibration.as_ref().map_or_else(String::new, |known| of_rig(known).to_toml());
    capture.models = description.first_model().into_iter().collect();
    capture.description = Some(description);
    LoadedCapture { capture, calibration, truth: Some(model.clone()), ..LoadedCapture::default() }
}

fn rms_difference(left: &[f64], right: &[f64]) -> f64 {
    let sum: f64 = left.iter().zip(right).map(|(left, right)| (left - right).powi(2)).sum();
    (sum / left.len().max(1) as f64).sqrt()
}
