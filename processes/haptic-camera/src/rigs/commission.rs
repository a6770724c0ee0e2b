//! `rig commission`: a rig turned for the first time, with so little torque that a wrong sign or scale does no harm.
//!
//! Torques are commanded and no angle is followed, so that nothing can run away. They rise until the knob surely moves; then the
//! angle tells, fitted against the torque that was commanded, what the motor drives, and against the torque that was measured, what
//! lies behind the sensor. Signs and inertia follow.

use std::path::Path;

use identification::{AccelerationUse, Fit, FitOptions, Samples};
use loaded_capture::LoadedCapture;
use rt_loop::request::RunRequest;

use super::torque_run;
use crate::command_line::{RigCommissionOptions, RigOptions};
use crate::load;
use crate::outcome::{Outcome, remark, say};
use crate::rig_run;
use crate::supervision::listen_for_interrupt;

/// First torque, as a share of the most that is tried.
const FIRST_SHARE: f64 = 1.0 / 16.0;
/// Most that is tried, as a share of the motor's limit.
const MOST_SHARE: f64 = 1.0 / 3.0;
/// By how much the torque rises from one try to the next.
const RISE: f64 = 1.5;
/// Length of a try, s.
const TRY_S: f64 = 4.0;
/// Travel from which on the angle tells something, rad: beyond what a knob yields within its stick.
const ENOUGH_RAD: f64 = 0.05;

/// Turns the rig, more with every try, until its inertia is known.
///
/// # Errors
/// Whatever keeps the rig from being turned.
pub fn run(options: &RigCommissionOptions) -> anyhow::Result<Outcome> {
    let interrupted = listen_for_interrupt()?;
    let request = torque_run(&options.file, options.rate_hz, TRY_S)?;
    let file = rt_loop::rigs::file(&request.rig)?;
    let limit_mnm = file.limits.map(|limits| limits.motor_torque_mnm);
    let most_mnm = options.most_torque.or(limit_mnm.map(|limit_mnm| MOST_SHARE * limit_mnm));
    let Some(most_mnm) = most_mnm.filter(|most_mnm| most_mnm.is_finite() && *most_mnm > 0.0) else {
        anyhow::bail!("how much torque may be tried is not known; give --most-torque, or [limits] in the rig file");
    };
    let rig = RigOptions { request: request.rig.clone(), offline: false, captures_in: options.captures_in.clone() };
    let mut amplitude_mnm = FIRST_SHARE * most_mnm;
    loop {
        say(format!("trying   {amplitude_mnm:.3} mNm"));
        let tried = RunRequest { sweep: "multisine".to_owned(), amplitude: Some(amplitude_mnm), ..request.clone() };
        let (archive, _) = rig_run::archive(tried, &rig, "rig-commission", &interrupted)?;
        let loaded = load::load(&archive)?;
        if let Some(outcome) = conclude(&loaded, &options.file) {
            return Ok(outcome);
        }
        anyhow::ensure!(
            amplitude_mnm < most_mnm,
            "the knob does not move at {most_mnm} mNm: check that the amplifier is on and [channels.motor] scale, or try more with \
             --most-torque"
        );
        amplitude_mnm = (RISE * amplitude_mnm).min(most_mnm);
    }
}

/// What a try tells; `None` where the knob hardly moved.
fn conclude(loaded: &LoadedCapture, file: &Path) -> Option<Outcome> {
    let capture = &loaded.capture;
    let (least, most) = capture
        .angle_rad
        .iter()
        .fold((f64::MAX, f64::MIN), |(least, most), angle| (least.min(*angle), most.max(*angle)));
    if most - least < ENOUGH_RAD {
        return None;
    }
    let driven = inertia(loaded, loaded.commanded_torque_mnm()?)?;
    say(format!("moved    {:.3} rad", most - least));
    if driven < 0.0 {
        remark(
            "the motor turns the encoder down where it should turn it up: turn [channels.motor] sign or [channels.angle] sign round, \
             then commission again",
        );
        return Some(Outcome::Failed);
    }
    say(format!("inertia  {driven:.5} mNm·s²/rad are driven by the motor, whatever turns with it"));
    let run = capture.description.as_ref();
    let is_of_motor = run.is_some_and(|run| run.notes.iter().any(|(name, _)| name == "torque"));
    if is_of_motor {
        say(format!(
            "write    motor_inertia = {driven:.5} under [calibration] if nothing was on the gripper, into {}",
            file.display()
        ));
        return Some(Outcome::Done);
    }
    let behind = inertia(loaded, &capture.torque_mnm);
    match behind {
        Some(behind) if behind < 0.0 => {
            remark(
                "the torque sensor counts the wrong way round: turn [channels.torque] sign round, then commission again",
            );
            Some(Outcome::Failed)
        }
        Some(behind) if behind < driven => {
            say(format!("behind   the torque sensor there are {behind:.5} of them"));
            say(format!("write    motor_inertia = {:.5} under [calibration] into {}", driven - behind, file.display()));
            Some(Outcome::Done)
        }
        Some(behind) => {
            remark(format!(
                "behind the torque sensor there seem to be {behind:.5} mNm·s²/rad, more than the motor drives: check the scales of \
                 [channels.torque] and [channels.motor]"
            ));
            Some(Outcome::Failed)
        }
        None => {
            remark("the torque sensor tells no inertia: check [channels.torque] source and scale");
            Some(Outcome::Failed)
        }
    }
}

/// The fit of the capture's angle to a torque.
fn of_torque(loaded: &LoadedCapture, torque_mnm: &[f64]) -> Option<Fit> {
    let samples = Samples { torque_mnm, velocity_rad_s: None, acceleration_rad_s2: None, ..loaded.samples() };
    let options = FitOptions { acceleration: AccelerationUse::Encoder, ..FitOptions::default() };
    identification::fit(&samples, &options).ok()
}

/// The inertia that a torque drives, below zero where it drives the other way; a fit tells none that is below zero.
fn inertia(loaded: &LoadedCapture, torque_mnm: &[f64]) -> Option<f64> {
    let told = |torque_mnm: &[f64]| {
        let value = of_torque(loaded, torque_mnm)?.parameters.get("inertia")?.value?;
        Some(value)
    };
    let turned: Vec<f64> = torque_mnm.iter().map(|torque_mnm| -torque_mnm).collect();
    told(torque_mnm).or_else(|| told(&turned).map(|value| -value))
}
