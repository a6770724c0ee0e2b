//! A rendered knob, captured like any other, beside its model, as `replay --verify --json` writes it.

use std::f64::consts::TAU;
use std::path::PathBuf;

use dynamics::{Effect, Model, Motion, ParameterKind, Part, effects};
use identification::checks::{FreeTravel, free_travel};
use identification::diagnosis::Diagnosis;
use identification::statistics::nearest_turn;
use identification::{Fit, FitOptions};
use loaded_capture::LoadedCapture;
use report::{AddedByRendering, HeldStill, LostMotion, RenderedParameter, Rendering, RenderingLimits, true_value};

use crate::check::Threshold;
use crate::{AnalysisError, along_motion, diagnose_in_these_roles, facts, fit_options, torque_at_knob};

const LIMITS: RenderingLimits =
    RenderingLimits { difference_percent: 2.0, static_difference_percent: 5.0, torque_error_percent: 5.0 };

/// Time after which a hold is looked at, s: the hand's torque has risen.
const SETTLED_S: f64 = 0.5;

/// The captures of a rendered knob.
#[derive(Debug)]
pub struct RenderedCaptures {
    /// A sweep.
    pub train: LoadedCapture,
    /// Another motion.
    pub heldout: LoadedCapture,
    /// A creep through a breakaway.
    pub creep: LoadedCapture,
    /// The knob held by [`holding_torque_mnm`], if there is one.
    pub hold: Option<LoadedCapture>,
}

/// Compares the captures with the model that was rendered; also gives the fit of the rendered knob as a knob of one body.
///
/// # Errors
/// [`AnalysisError`] for a sweep that cannot be fitted or, of a model of two bodies, diagnosed.
pub fn rendering(model: &Model, captures: &RenderedCaptures) -> Result<(Rendering, Fit), AnalysisError> {
    let held = holding_torque_mnm(model).zip(captures.hold.as_ref());
    let held_still = held.map(|(torque_mnm, hold)| held_still(torque_mnm, hold));
    let train = &captures.train;
    // The model says what the torque over the angle is: nothing is left to be measured.
    let options = FitOptions { further_effects: further_effects(model), characteristic: false, ..fit_options(train) };
    let fit = identification::fit(&train.samples(), &options).map_err(AnalysisError::Rendered)?;
    let rendering =
        if model.coupling().is_some() { two_bodies(model, captures)? } else { one_body(model, &fit, captures)? };
    let files = [train, &captures.heldout, &captures.creep].into_iter().chain(&captures.hold);
    let files: Vec<PathBuf> = files.map(|one| one.capture.source.clone()).collect();
    let mut rendering = Rendering {
        model: model.name.clone(),
        captures: files,
        torque_error_percent: 100.0 * rendering.torque_error_rms_mnm / rendering.torque_rms_mnm,
        held_still,
        limits: LIMITS,
        capture: facts(train),
        ..rendering
    };
    rendering.passed = rendering.parameters.iter().all(|parameter| parameter.passed != Some(false))
        && rendering.torque_passes()
        && rendering.is_held_still();
    Ok((rendering, fit))
}

/// A torque in the middle of what the knob bears at the angle at which it starts; `None` where it bears none.
#[must_use]
pub fn holding_torque_mnm(model: &Model) -> Option<f64> {
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
    let ends = settled.fold((f64::MAX, f64::MIN), |(least, most), (_, rad)| (least.min(*rad), most.max(*rad)));
    let step_rad = hold.calibration.as_ref().map_or(0.0, |known| known.angle_step_rad);
    HeldStill {
        torque_mnm,
        duration_s: capture.t_s.last().map_or(0.0, |last| last - SETTLED_S),
        encoder_steps: (ends.1 - ends.0) / step_rad,
    }
}

/// The effects of a model that a fit takes beside inertia, friction and detents. What changes the friction is no torque of its own: it is found by
/// the diagnosis.
fn further_effects(model: &Model) -> Vec<Effect> {
    let base = [effects::inertia::KIND.name, effects::friction::KIND.name, effects::detent::KIND.name];
    let fits = |effect: &&Effect| {
        let kind = effect.kind();
        kind.regressors.is_some() && !kind.part.changes_friction() && !base.contains(&kind.name)
    };
    model.effects.iter().filter(fits).copied().collect()
}

/// Compares the captures with a model of one body.
fn one_body(model: &Model, fit: &Fit, captures: &RenderedCaptures) -> Result<Rendering, AnalysisError> {
    let thresholds = Threshold::of(&captures.creep, Some(model))?;
    let mut notes = fit.notes.clone();
    let is_drawn = model.effects.iter().any(|effect| effect.table().is_some());
    let found = if is_drawn {
        Err("a diagnosis cannot start from a model with a drawn table".to_owned())
    } else {
        diagnosed(model, captures).map_err(|error| error.to_string())
    };
    let unknown = |reason| notes.push(format!("what the rendering adds cannot be determined: {reason}"));
    let added = found.map_err(unknown).ok().map(|found| added(&found));
    let [torque_error_rms_mnm, torque_rms_mnm] = torque_error_mnm(model, fit);
    let parameters = parameters(model, fit, &thresholds);
    Ok(Rendering { parameters, torque_error_rms_mnm, torque_rms_mnm, added, notes, ..Rendering::default() })
}

/// Compares the captures with a model of two bodies.
///
/// The model is refined on the sweep, its inner body simulated behind the measured motion of the cap: that tells the
/// parameters with their intervals. The torque error is the intended model's, not refined, along the measured motion.
fn two_bodies(model: &Model, captures: &RenderedCaptures) -> Result<Rendering, AnalysisError> {
    let whole = diagnosed(model, captures)?;
    let gap = model.coupling().filter(|coupling| coupling.half_gap_rad > 0.0);
    let lost_motion = gap.map(|coupling| -> Result<LostMotion, AnalysisError> {
        let mut stiff = model.clone();
        stiff.effects.retain(|effect| !matches!(effect.kind().part, Part::Coupling(_)));
        let without = diagnosed(&stiff, captures)?;
        let ways = free_travel(&captures.creep.samples(), captures.creep.calibration.as_ref())?;
        Ok(LostMotion {
            intended_rad: 2.0 * coupling.half_gap_rad,
            free_ways_rad: ways.iter().map(FreeTravel::travel_rad).collect(),
            named: added(&without),
            partly: without.partial.iter().map(|one| (one.effect.to_owned(), one.explains_percent)).collect(),
        })
    });
    let [torque_error_rms_mnm, torque_rms_mnm] = along_motion_mnm(model, &captures.train)?;
    Ok(Rendering {
        parameters: refined_parameters(model, &whole),
        torque_error_rms_mnm,
        torque_rms_mnm,
        lost_motion: lost_motion.transpose()?,
        added: Some(added(&whole)),
        notes: whole.notes,
        ..Rendering::default()
    })
}

/// A diagnosis of the rendered knob that starts from a model.
fn diagnosed(model: &Model, captures: &RenderedCaptures) -> Result<Diagnosis, AnalysisError> {
    diagnose_in_these_roles(None, &captures.train, &captures.heldout, Some(model.clone()), None)
}

/// What a diagnosis that starts from the intended model found.
fn added(found: &Diagnosis) -> AddedByRendering {
    AddedByRendering {
        verdict: found.verdict,
        effects: found.effects.iter().map(ToString::to_string).collect(),
        heldout_rms_before: found.heldout_rms_before,
        heldout_rms_after: found.heldout_rms_after,
        noise_floor_rms: found.noise_floor_rms,
    }
}

/// A parameter with its value in the rendered knob and the interval of that, or why there is none.
fn verified(
    kind: &ParameterKind,
    intended: f64,
    rendered: Result<(f64, Option<[f64; 2]>), String>,
) -> RenderedParameter {
    let ParameterKind { name, unit, .. } = *kind;
    let (value, ci95, reason) = match rendered {
        Ok((value, ci95)) => (Some(value), ci95, None),
        Err(reason) => (None, None, Some(reason)),
    };
    let difference_percent = value.map(|value| {
        if unit == "rad" && name.ends_with("phase") {
            100.0 * nearest_turn(value - intended, 0.0) / TAU
        } else {
            100.0 * (value / intended - 1.0)
        }
    });
    let is_static = name.starts_with("static_");
    let limit = if is_static { LIMITS.static_difference_percent } else { LIMITS.difference_percent };
    let held = ci95.is_some_and(|[low, high]| (low..=high).contains(&intended));
    let passed = difference_percent.map(|percent| held || percent.abs() <= limit);
    RenderedParameter { name, unit, intended, rendered: value, ci95, difference_percent, passed, reason }
}

/// Every parameter of every effect of a model, with its value.
fn every(model: &Model) -> impl Iterator<Item = (&Effect, &'static ParameterKind, f64)> {
    model.effects.iter().flat_map(|effect| effect.parameters().map(move |(kind, value)| (effect, kind, value)))
}

/// Every parameter of the model beside what the fit of the rendered knob and its breakaways tell.
fn parameters(model: &Model, fit: &Fit, thresholds: &[Option<Threshold>; 2]) -> Vec<RenderedParameter> {
    // A knob bears at rest at least the friction with which it slides off.
    let borne = model.stick_limits(&Motion::default());
    let stick = |kind: &ParameterKind, borne_mnm, threshold: &Option<Threshold>| {
        let seen = threshold.as_ref().map(|seen| (seen.torque_mnm, seen.ci95_mnm));
        verified(kind, borne_mnm, seen.ok_or_else(|| "the knob did not break away in the creep".to_owned()))
    };
    let compared = |effect: &Effect, kind: &ParameterKind, value: f64| match (effect.kind().part, kind.name) {
        (Part::Stick(_), "static_negative") => Some(stick(kind, borne.negative_mnm, &thresholds[0])),
        (Part::Stick(_), "static_positive") => Some(stick(kind, borne.positive_mnm, &thresholds[1])),
        // The speed at which a knob comes to rest shows in no torque.
        (Part::Stick(_), _) => None,
        _ => {
            let found = fit.parameters.get(kind.name).ok_or_else(|| "a fit does not estimate this effect".to_owned());
            let rendered = found.and_then(|found| {
                Ok((found.value.ok_or_else(|| found.reason.clone().unwrap_or_default())?, found.ci95))
            });
            Some(verified(kind, true_value(Some(model), kind.name, None).unwrap_or(value), rendered))
        }
    };
    every(model).filter_map(|(effect, kind, value)| compared(effect, kind, value)).collect()
}

/// Every parameter of the model beside its value refined on the sweep.
fn refined_parameters(model: &Model, found: &Diagnosis) -> Vec<RenderedParameter> {
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
    let told = every(model).filter(|(.., intended)| *intended != 0.0);
    told.filter_map(|(effect, kind, intended)| compared(effect, kind, intended)).collect()
}

/// RMS of rendered minus intended torque over the fit's rows, and of the intended torque, mNm.
///
/// A row is a mean over samples, without those where the knob may stick. Its error is the fit's residual (rendered minus fitted torque)
/// plus fitted minus intended torque for the row's motion.
fn torque_error_mnm(model: &Model, fit: &Fit) -> [f64; 2] {
    let mut fitted = fit.model(&model.name);
    // Parameters that are not separately identifiable make up the torque together: their fitted values are used as they are.
    for effect in fitted.effects.iter_mut().filter(|effect| !matches!(effect.kind().part, Part::Inertia(_))) {
        let left = fit.effects().iter().find(|left| left.kind().name == effect.kind().name);
        *effect = left.copied().unwrap_or(*effect);
    }
    let mut sums = [0.0; 2];
    for point in &fit.points {
        let motion = point.motion();
        let intended_mnm = model.torque_mnm(&motion);
        sums[0] += (point.residual_mnm + fitted.torque_mnm(&motion) - intended_mnm).powi(2);
        sums[1] += intended_mnm * intended_mnm;
    }
    sums.map(|sum| (sum / fit.points.len().max(1) as f64).sqrt())
}

/// Length of the means in which torques of a knob of two bodies are compared, s: the band of a diagnosis, 200 Hz.
const MEAN_S: f64 = 0.0025;

/// RMS of captured minus simulated torque, and RMS of captured torque, both of means over [`MEAN_S`], mNm. The model is not refined;
/// its inner body is simulated behind the measured motion of the cap.
fn along_motion_mnm(model: &Model, capture: &LoadedCapture) -> Result<[f64; 2], AnalysisError> {
    let gripper_inertia = capture.calibration.as_ref().map_or(0.0, |known| known.gripper_inertia);
    let motions = identification::knob_motion(&capture.samples(), capture.capture.axis, capture.calibration.as_ref())?;
    let simulated_mnm = along_motion(model, gripper_inertia, &motions).torque_mnm;
    let captured_mnm = torque_at_knob(capture);
    let length = ((MEAN_S * capture.capture.rate_hz) as usize).max(1);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let mut sums = [0.0; 2];
    for (captured, simulated) in captured_mnm.chunks_exact(length).zip(simulated_mnm.chunks_exact(length)) {
        sums[0] += (mean(captured) - mean(simulated)).powi(2);
        sums[1] += mean(captured).powi(2);
    }
    let count = (captured_mnm.len() / length).max(1) as f64;
    Ok(sums.map(|sum| (sum / count).sqrt()))
}
