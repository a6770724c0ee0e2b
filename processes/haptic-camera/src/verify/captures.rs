//! The captures of a rendered knob, and what they tell.

use std::path::PathBuf;

use anyhow::{Context as _, anyhow};
use dynamics::excitation::PRESSED_MM;
use dynamics::{Axis, Model, Motion};
use identification::checks::breakaways;
use identification::diagnosis::Diagnosis;
use identification::{Fit, FitOptions};
use loaded_capture::LoadedCapture;
use report::{HeldStill, Rendering};
use rt_loop::request::HandRequest;
use rt_loop::stability::driving_speed_rad_s;

use super::compare::{further_effects, parameters, torque_error_mnm};
use super::two_bodies;
use super::{LIMITS, added};
use crate::check::Threshold;
use crate::load;
use crate::rigs::span;

/// Grip of the hand that turns the knob, in usual ones: one that holds a knob firmly.
const GRIP: f64 = 6.0;
/// Largest amplitude of the sweeps, rad: the paper's.
const AMPLITUDE_RAD: f64 = 1.0;
/// Highest frequency of the sweep, Hz, so that amplitude and speed go together.
const SWEEP_HZ: f64 = 3.0;
/// Share of the speed beyond which friction is no longer what the model says that the sweep reaches.
const SPEED_SHARE: f64 = 0.9;
/// Length of a sweep, s.
const SWEEP_S: f64 = 10.0;
/// Amplitude of the creep, rad, and its length, s; what is pressed creeps to its bottom.
const CREEP: (f64, f64) = (0.1, 15.0);
/// How long the knob is held, s.
const HOLD_S: f64 = 10.0;
/// Time after which a hold is looked at, s: the hand's torque has risen.
const SETTLED_S: f64 = 0.5;

/// Captures the rendered knob and compares it with its model; gives also its fit as a knob of one body.
///
/// `make` makes a capture: its name, the hand, the largest angle of the hand's sweep in rad, its length in s; it gives the archive.
pub fn verify(
    model: &Model,
    rate_hz: f64,
    mut make: impl FnMut(&str, HandRequest, Option<f64>, f64) -> anyhow::Result<PathBuf>,
) -> anyhow::Result<(Rendering, Fit)> {
    let mut captures = Vec::new();
    let mut capture = |name: &str, hand, amplitude_rad, duration_s| -> anyhow::Result<LoadedCapture> {
        let path = make(name, hand, amplitude_rad, duration_s)?;
        captures.push(path.clone());
        load::load(&path)
    };
    let (widest, creep_to) = match model.axis {
        Axis::Rotary => (AMPLITUDE_RAD, CREEP.0),
        Axis::Linear => (PRESSED_MM, PRESSED_MM),
    };
    let amplitude_rad = driving_speed_rad_s(model)
        .map_or(widest, |speed_rad_s| (SPEED_SHARE * speed_rad_s / (std::f64::consts::TAU * SWEEP_HZ)).min(widest));
    let firm = |sweep: &str| HandRequest { hand: sweep.to_owned(), hand_torque: None, grip: GRIP };
    let holding = |torque_mnm| HandRequest { hand_torque: Some(torque_mnm), grip: 1.0, ..firm("none") };
    let train = capture("sweep", firm("linear-chirp"), Some(amplitude_rad), SWEEP_S)?;
    let heldout = capture("heldout", firm("stepped-amplitude"), Some(amplitude_rad), SWEEP_S)?;
    let creep = capture("creep", firm("slow-turn"), Some(creep_to), CREEP.1)?;

    let held_still = match holding_torque_mnm(model) {
        Some(torque_mnm) => Some(held_still(torque_mnm, &capture("hold", holding(torque_mnm), None, HOLD_S)?)),
        None => None,
    };
    let fit = fit(&train, model)?;
    let mut rendering = if model.coupling().is_some() {
        two_bodies::compared(model, [&train, &heldout, &creep])?
    } else {
        one_body(model, &fit, [&train, &heldout, &creep])?
    };
    rendering = Rendering {
        model: model.name.clone(),
        rate_hz,
        captures,
        torque_error_percent: 100.0 * rendering.torque_error_rms_mnm / rendering.torque_rms_mnm,
        held_still,
        limits: LIMITS,
        capture: analysis::facts(&train),
        ..rendering
    };
    rendering.passed = rendering.parameters.iter().all(|parameter| parameter.passed != Some(false))
        && rendering.torque_error_percent <= LIMITS.torque_error_percent
        && held_still.is_none_or(|held| held.encoder_steps < 1.0);
    Ok((rendering, fit))
}

/// Compares the captures of a sweep, another motion and a creep with a model of one body.
fn one_body(model: &Model, fit: &Fit, [train, heldout, creep]: [&LoadedCapture; 3]) -> anyhow::Result<Rendering> {
    let thresholds = Threshold::of(&breakaways(&creep.samples(), creep.calibration.as_ref())?, Some(model));
    let mut notes = fit.notes.clone();
    let is_drawn = model.effects.iter().any(|effect| effect.table().is_some());
    let found = if is_drawn {
        Err(anyhow!("a diagnosis cannot start from a model with a drawn table"))
    } else {
        diagnosed(model, train, heldout)
    };
    let added = match found {
        Ok(found) => Some(added(&found)),
        Err(error) => {
            notes.push(format!("what the rendering adds cannot be determined: {error:#}"));
            None
        }
    };
    let [torque_error_rms_mnm, torque_rms_mnm] = torque_error_mnm(model, fit);
    let parameters = parameters(model, fit, &thresholds);
    Ok(Rendering { parameters, torque_error_rms_mnm, torque_rms_mnm, added, notes, ..Rendering::default() })
}

fn fit(train: &LoadedCapture, model: &Model) -> anyhow::Result<Fit> {
    // The model says what the torque over the angle is: nothing is left to be measured.
    let options =
        FitOptions { further_effects: further_effects(model), characteristic: false, ..analysis::fit_options(train) };
    identification::fit(&train.samples(), &options).context("the rendered knob cannot be fitted")
}

/// A diagnosis of the rendered knob that starts from a model.
pub(super) fn diagnosed(model: &Model, train: &LoadedCapture, heldout: &LoadedCapture) -> anyhow::Result<Diagnosis> {
    Ok(analysis::diagnose(train, Some(heldout), Some(model.clone()), None)?)
}

/// A torque in the middle of what the knob bears at the angle at which it starts; `None` where it bears none.
fn holding_torque_mnm(model: &Model) -> Option<f64> {
    let start = Motion::default();
    let limits = model.stick_limits(&start);
    let free_mnm = model.free_torque_mnm(&start);
    let (least_mnm, most_mnm) = (free_mnm - limits.negative_mnm, free_mnm + limits.positive_mnm);
    // It must begin at rest without a hand, and bear more than noise.
    (least_mnm < 0.0 && most_mnm > 0.0).then_some(0.5 * most_mnm)
}

fn held_still(torque_mnm: f64, hold: &LoadedCapture) -> HeldStill {
    let capture = &hold.capture;
    let settled = capture.t_s.iter().zip(&capture.angle_rad).filter(|(t_s, _)| **t_s >= SETTLED_S);
    let moved_rad = span(settled.map(|(_, angle_rad)| *angle_rad));
    let step_rad = hold.calibration.as_ref().map_or(0.0, |known| known.angle_step_rad);
    HeldStill {
        torque_mnm,
        duration_s: capture.t_s.last().map_or(0.0, |last| last - SETTLED_S),
        encoder_steps: moved_rad / step_rad,
    }
}
