//! `simulate`: a model along a capture's motion or torque.

use anyhow::Context as _;
use archive::{Capture, whole_file};
use dynamics::simulate::ForwardSimulation;
use dynamics::{Calibration, Direction, Model, Motion, shifted};
use identification::statistics::rms;
use loaded_capture::LoadedCapture;

use crate::command_line::{SimulateOptions, SimulationDrive};
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::Kind;

/// Speed below which a model without stick of its own counts as resting, rad/s.
const RESTING_RAD_S: f64 = 0.02;

/// Simulates the model, says how far it is from the capture, and writes one of the same length and rate if asked to.
///
/// # Errors
/// One sentence on what is wrong with the model, the capture or the output.
pub fn run(options: &SimulateOptions) -> anyhow::Result<Outcome> {
    let model = Model::load(&options.model)?;
    let like = load::load(&options.like)?;
    let gripper_inertia = like.calibration.as_ref().map_or(0.0, |known| known.gripper_inertia);
    let motions = identification::knob_motion(&like.samples(), like.calibration.as_ref())?;
    let simulated = match options.drive {
        SimulationDrive::Motion => along_motion(&model, gripper_inertia, &motions),
        SimulationDrive::Torque => along_torque(&model, gripper_inertia, &motions, &torque_at_knob(&like))?,
    };
    let captured: Vec<f64> = match options.drive {
        SimulationDrive::Motion => torque_at_knob(&like),
        SimulationDrive::Torque => motions.iter().map(|motion| motion.angle_rad).collect(),
    };
    say(match options.drive {
        SimulationDrive::Motion => {
            let [left, all] = [rms_difference(&captured, &simulated.torque_mnm), rms(&captured)];
            format!(
                "the model's torque differs by {left:.3} of {all:.3} mNm RMS from the capture's: relative error {:.2} %",
                100.0 * left / all
            )
        }
        SimulationDrive::Torque => {
            let left = rms_difference(&captured, &simulated.angle_rad);
            format!("the model's angle differs by {left:.4} rad RMS from the capture's")
        }
    });
    if let Some(out) = &options.out {
        let capture = described(simulated, &like, &model);
        if options.writes_table() {
            capture.write_csv(out)?;
        } else {
            whole_file::write_whole(out, Kind::Simulation.replaces(), |place| capture.write_mcap_to(place))?;
        }
        say(format!("{}: {} samples", out.display(), capture.len()));
    }
    Ok(Outcome::Done)
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
    let slips_at_once = model.coupling().is_none() && model.bristles().is_none();
    for (torque_mnm, motion) in torque_mnm.iter_mut().zip(motions) {
        *torque_mnm += gripper_inertia * motion.acceleration_rad_s2;
        if slips_at_once && motion.velocity_rad_s != 0.0 {
            *torque_mnm -= unsettled_friction_mnm(model, motion);
        }
    }
    let time_s: Vec<f64> = motions.iter().map(|motion| motion.time_s).collect();
    Simulated {
        angle_rad: motions.iter().map(|motion| motion.angle_rad).collect(),
        velocity_rad_s: motions.iter().map(|motion| motion.velocity_rad_s).collect(),
        acceleration_rad_s2: motions.iter().map(|motion| motion.acceleration_rad_s2).collect(),
        torque_mnm: shifted(&time_s, &torque_mnm, -model.reading_delay_s()),
    }
}

/// The part of sliding friction that is left out close to rest, mNm.
///
/// At rest friction is whatever holds the knob and no function of its motion; a straight line across the band keeps
/// encoder noise there from throwing it from one side to the other.
fn unsettled_friction_mnm(model: &Model, motion: &Motion) -> f64 {
    let band = model.stick_limits(motion).velocity_rad_s.max(RESTING_RAD_S);
    let share = (motion.velocity_rad_s.abs() / band).min(1.0);
    (1.0 - share) * model.friction_mnm(motion, Direction::of(motion.velocity_rad_s))
}

/// The model's motion under a torque read as given, from rest at the capture's first angle.
fn along_torque(
    model: &Model,
    gripper_inertia: f64,
    motions: &[Motion],
    torque_mnm: &[f64],
) -> anyhow::Result<Simulated> {
    let first = motions.first().context("the capture is empty")?;
    let mut simulation = ForwardSimulation::at_rest(model, gripper_inertia, first.angle_rad)?;
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

/// A capture of the simulated columns that says what it is.
fn described(simulated: Simulated, like: &LoadedCapture, model: &Model) -> Capture {
    let Simulated { angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm } = simulated;
    let mut capture = like.capture.clone();
    // A capture of a rendering is kept as its sensor reads, and its calibration as the rig has it.
    let rendered = capture.is_rendered();
    capture.angle_rad = angle_rad;
    capture.velocity_rad_s = Some(velocity_rad_s);
    capture.acceleration_rad_s2 = Some(acceleration_rad_s2);
    capture.torque_mnm = torque_mnm;
    capture.commanded_torque_mnm = None;
    if let Some(description) = &mut capture.description {
        description.apparatus = "simulation".to_owned();
        description.knob = model.name.clone();
        description.simulated_knob_toml = Some(model.to_toml());
        // Simulated columns have nothing to be corrected but the gripper that turns with the knob.
        description.calibration_toml = like.calibration.as_ref().map_or_else(String::new, |known| {
            Calibration {
                torque_zero_mnm: 0.0,
                torque_delay_s: 0.0,
                acceleration_zero_rad_s2: 0.0,
                acceleration_delay_s: 0.0,
                gravity_amplitude_rad_s2: 0.0,
                torque_sensor_stiffness_mnm_rad: f64::MAX,
                ..if rendered { known.seen_from_the_hand() } else { known.clone() }
            }
            .to_toml()
        });
    }
    capture.of_knob()
}

fn rms_difference(left: &[f64], right: &[f64]) -> f64 {
    rms(&left.iter().zip(right).map(|(left, right)| left - right).collect::<Vec<_>>())
}
