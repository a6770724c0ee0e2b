//! The proof of a rendered knob with lost motion or a shaft: no linear fit tells its parameters.

use std::path::PathBuf;

use dynamics::{Model, Part};
use identification::checks::{FreeTravel, free_travel};
use identification::diagnosis::{DiagnoseOptions, Diagnosis, diagnose};
use loaded_capture::LoadedCapture;

use super::compare::{Verified, along_motion_mnm};
use super::{Added, HeldStill, Limits, LostMotion, Verification, passes};

/// Compares the captures of a sweep, another motion and a creep with a model of two bodies.
///
/// The model is refined on the sweep, its inner body simulated behind the measured motion of the cap: that tells the
/// parameters with their intervals. The torque error is the intended model's, not refined, along the measured motion.
///
/// # Errors
/// When a capture cannot be prepared or diagnosed.
pub(super) fn verification(
    model: &Model,
    rate_hz: f64,
    captures: Vec<PathBuf>,
    [train, heldout, creep]: [&LoadedCapture; 3],
    held_still: Option<HeldStill>,
) -> anyhow::Result<Verification> {
    let from = |model: &Model| -> anyhow::Result<Diagnosis> {
        let options = DiagnoseOptions {
            calibration: train.calibration.clone(),
            axis: train.capture.axis,
            model: Some(model.clone()),
            ..DiagnoseOptions::default()
        };
        Ok(diagnose(&train.samples(), Some(&heldout.samples()), &options)?)
    };
    let whole = from(model)?;
    let parameters = parameters(model, &whole);
    let [torque_error_rms_mnm, torque_rms_mnm] = along_motion_mnm(model, train)?;
    let torque_error_percent = 100.0 * torque_error_rms_mnm / torque_rms_mnm;
    let passed = passes(&parameters, torque_error_percent, held_still.as_ref());
    let gap = model.coupling().filter(|coupling| coupling.half_gap_rad > 0.0);
    let lost_motion = match gap {
        Some(coupling) => {
            let mut stiff = model.clone();
            stiff.effects.retain(|effect| !matches!(effect.kind().part, Part::Coupling(_)));
            let without = from(&stiff)?;
            let ways = free_travel(&creep.samples(), creep.calibration.as_ref())?;
            Some(LostMotion {
                intended_rad: 2.0 * coupling.half_gap_rad,
                free_ways_rad: ways.iter().map(FreeTravel::travel_rad).collect(),
                named: Added::of(&without),
                partly: without.partial.iter().map(|one| (one.effect.to_owned(), one.explains_percent)).collect(),
            })
        }
        None => None,
    };
    Ok(Verification {
        model: model.name.clone(),
        rate_hz,
        captures,
        parameters,
        torque_error_rms_mnm,
        torque_rms_mnm,
        torque_error_percent,
        lost_motion,
        held_still,
        added: Some(Added::of(&whole)),
        limits: Limits::default(),
        notes: whole.notes,
        passed,
    })
}

/// Every parameter of the model beside its value refined on the sweep.
fn parameters(model: &Model, found: &Diagnosis) -> Vec<Verified> {
    let mut verified = Vec::new();
    for effect in &model.effects {
        for (parameter, intended) in effect.parameters().filter(|(_, intended)| *intended != 0.0) {
            let (name, unit) = (parameter.name, parameter.unit);
            if let Part::Stick(_) = effect.kind().part {
                // The speed at which a knob comes to rest shows in no torque.
                if unit == "mNm" {
                    let reason = "the encoder does not measure the inner body's breakaway".to_owned();
                    verified.push(Verified::not_identifiable(name, unit, intended, reason));
                }
                continue;
            }
            verified.push(match found.refined.get(name) {
                Some(value) => Verified::new(name, unit, intended, value.value, value.ci95),
                None => Verified::not_identifiable(
                    name,
                    unit,
                    intended,
                    "a refinement does not estimate this effect".to_owned(),
                ),
            });
        }
    }
    verified
}
