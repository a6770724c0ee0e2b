//! The proof of a rendered knob with lost motion or a shaft: no linear fit tells its parameters.

use dynamics::{Effect, Model, ParameterKind, Part};
use identification::checks::{FreeTravel, free_travel};
use identification::diagnosis::Diagnosis;
use loaded_capture::LoadedCapture;
use report::{LostMotion, RenderedParameter, Rendering};

use super::added;
use super::captures::diagnosed;
use super::compare::{along_motion_mnm, verified};

/// Compares the captures of a sweep, another motion and a creep with a model of two bodies.
///
/// The model is refined on the sweep, its inner body simulated behind the measured motion of the cap: that tells the
/// parameters with their intervals. The torque error is the intended model's, not refined, along the measured motion.
pub(super) fn compared(model: &Model, [train, heldout, creep]: [&LoadedCapture; 3]) -> anyhow::Result<Rendering> {
    let whole = diagnosed(model, train, heldout)?;
    let gap = model.coupling().filter(|coupling| coupling.half_gap_rad > 0.0);
    let lost_motion = match gap {
        Some(coupling) => {
            let mut stiff = model.clone();
            stiff.effects.retain(|effect| !matches!(effect.kind().part, Part::Coupling(_)));
            let without = diagnosed(&stiff, train, heldout)?;
            let ways = free_travel(&creep.samples(), creep.calibration.as_ref())?;
            Some(LostMotion {
                intended_rad: 2.0 * coupling.half_gap_rad,
                free_ways_rad: ways.iter().map(FreeTravel::travel_rad).collect(),
                named: added(&without),
                partly: without.partial.iter().map(|one| (one.effect.to_owned(), one.explains_percent)).collect(),
            })
        }
        None => None,
    };
    let [torque_error_rms_mnm, torque_rms_mnm] = along_motion_mnm(model, train)?;
    Ok(Rendering {
        parameters: parameters(model, &whole),
        torque_error_rms_mnm,
        torque_rms_mnm,
        lost_motion,
        added: Some(added(&whole)),
        notes: whole.notes,
        ..Rendering::default()
    })
}

/// Every parameter of the model beside its value refined on the sweep.
fn parameters(model: &Model, found: &Diagnosis) -> Vec<RenderedParameter> {
    let compared = |effect: &Effect, kind: &ParameterKind, intended: f64| {
        let rendered = match effect.kind().part {
            // The speed at which a knob comes to rest shows in no torque.
            Part::Stick(_) if kind.unit != "mNm" => return None,
            Part::Stick(_) => Err("the encoder does not measure the inner body's breakaway"),
            _ => found.refined.get(kind.name).ok_or("a refinement does not estimate this effect"),
        };
        let rendered = rendered.map(|value| (value.value, value.ci95)).map_err(str::to_owned);
        Some(verified(kind, intended, rendered))
    };
    let all = model.effects.iter().flat_map(|effect| effect.parameters().map(move |parameter| (effect, parameter)));
    let told = all.filter(|(_, (_, intended))| *intended != 0.0);
    told.filter_map(|(effect, (kind, intended))| compared(effect, kind, intended)).collect()
}
