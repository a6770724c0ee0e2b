//! Motion predicted from the torque commanded from the rig's motor, without the torque sensor's readings.

use dynamics::simulate::{RigMotor, forward_windows_from_command};
use dynamics::{Calibration, Model};

use crate::calibration::acting_mnm;
use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::ForwardFromCommand;
use crate::diagnosis::search::forward::FORWARD_WINDOW_S;
use crate::numerics::statistics::rms;
use crate::regression::least_squares::LeastSquares;

/// Speed below which the motor's friction is not read off, as a share of the RMS speed.
const SLOW: f64 = 0.1;
/// A command stands for a sample at most this many periods later; then samples were lost.
const STALE: f64 = 1.5;

/// The commands to the rig's motor during a capture.
#[derive(Clone, Copy, Debug)]
pub struct CommandedTorque<'a> {
    /// A command for each sample, mNm; NaN where it is unknown.
    pub torque_mnm: &'a [f64],
    /// Time of the samples, s.
    pub t_s: &'a [f64],
}

/// Errors of the held-out motion predicted from the command with each model of `chain`; the error says why there are none.
pub(crate) fn forward(
    chain: &[Model],
    [train, heldout]: [&Capture; 2],
    commanded: Option<[CommandedTorque<'_>; 2]>,
    known: Option<&Calibration>,
) -> Result<ForwardFromCommand, &'static str> {
    let [of_train, of_heldout] =
        commanded.ok_or("a capture has no column of commanded torque; captures of a rig have one")?;
    let known = known.ok_or("nothing is known of the rig's motor without a calibration; lay one beside the capture")?;
    // The torque that the motor's known cogging takes is subtracted from the command.
    let on_grid = |commanded: CommandedTorque<'_>, capture: &Capture| -> Vec<f64> {
        let commands_mnm = on_grid(commanded, capture).into_iter().zip(&capture.motions);
        commands_mnm.map(|(command_mnm, motion)| command_mnm - known.motor_cogging_mnm(motion.angle_rad)).collect()
    };
    let motor = motor(known.motor_inertia, train, &on_grid(of_train, train))
        .ok_or("the training capture does not tell the motor's friction; turn the knob faster, both ways")?;
    let commands = on_grid(of_heldout, heldout);
    let mut angle_rms_rad = Vec::new();
    for model in chain {
        let errors = forward_windows_from_command(model, &motor, &heldout.motions, &commands, FORWARD_WINDOW_S);
        match errors {
            Ok(errors) if errors.angle_rms_rad.is_finite() && !errors.windows.is_empty() => {
                angle_rms_rad.push(errors.angle_rms_rad);
            }
            _ => return Err("a model cannot be simulated forward"),
        }
    }
    Ok(ForwardFromCommand { angle_rms_rad, window_s: FORWARD_WINDOW_S, motor })
}

/// The command that holds at each motion, mNm.
fn on_grid(CommandedTorque { torque_mnm, t_s }: CommandedTorque<'_>, capture: &Capture) -> Vec<f64> {
    let rate_hz = capture.rate_hz;
    let mut index = 0;
    let each = capture.motions.iter().map(|motion| {
        let now_s = capture.start_s + motion.time_s;
        // A grid point may lie a rounding before its sample.
        while t_s.get(index + 1).is_some_and(|next_s| next_s - now_s < 0.25 / rate_hz) {
            index += 1;
        }
        let is_stale = t_s.get(index).is_none_or(|time_s| (now_s - time_s).abs() > STALE / rate_hz);
        if is_stale { f64::NAN } else { torque_mnm.get(index).copied().unwrap_or(f64::NAN) }
    });
    each.collect()
}

/// The motor's friction, fitted by least squares to the part of the command that neither accelerates the motor nor reaches the
/// torque sensor.
fn motor(inertia: f64, capture: &Capture, commands_mnm: &[f64]) -> Option<RigMotor> {
    let torque_mnm = capture.torque_mnm(0.0);
    let (motions, velocity) = (&capture.motions, &capture.motion.velocity_rad_s);
    let slow_rad_s = SLOW * rms(velocity);
    let lost_mnm =
        |at: usize| acting_mnm(commands_mnm, at) - torque_mnm[at] - inertia * motions[at].acceleration_rad_s2;
    let is_known = |at: &usize| velocity[*at].abs() > slow_rad_s && lost_mnm(*at).is_finite();
    let rows: Vec<usize> = (0..motions.len()).filter(is_known).collect();
    let column = |of: &dyn Fn(usize) -> f64| rows.iter().map(|at| of(*at)).collect::<Vec<f64>>();
    let columns = [column(&|at| velocity[at].signum()), column(&|at| velocity[at])];
    let fitted = LeastSquares::solve(&columns, &column(&lost_mnm));
    // A negative estimate means that the friction is small and lost in the noise.
    let [coulomb_mnm, viscous] = [0, 1].map(|at| fitted.coefficients[at].max(0.0));
    (!fitted.collinear.contains(&true)).then_some(RigMotor { inertia, coulomb_mnm, viscous })
}
