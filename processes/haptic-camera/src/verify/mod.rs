//! The proof of a rendering: the rendered knob captured like any other, fitted, diagnosed and compared with its model.

mod compare;
mod table;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use archive::claim;
use dynamics::excitation::PRESSED_MM;
use dynamics::{Axis, Model, Motion};
use identification::{Fit, FitOptions};
use loaded_capture::LoadedCapture;
use report::{HeldStill, Rendering, RenderingLimits, RenderingPage};
use rt_loop::plan::Plan;
use rt_loop::request::HandRequest;
use rt_loop::stability::driving_speed_rad_s;

use self::compare::{further_effects, one_body, two_bodies};
use crate::load;
use crate::outcome::{Outcome, show};
use crate::replay::ReplayOptions;
use crate::rigs::span;
use crate::supervision::{Shown, SupervisedRun, archive_stem};

const LIMITS: RenderingLimits =
    RenderingLimits { difference_percent: 2.0, static_difference_percent: 5.0, torque_error_percent: 5.0 };

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

/// Verifies a rendering and tells the result; failed if the rendered knob is not the model's.
pub fn run(options: &ReplayOptions, interrupted: &AtomicBool) -> anyhow::Result<Outcome> {
    let mut asked = options.request();
    // The model that is to be felt: the one asked for, or the nearest to it that the rig renders.
    let model = Plan::new(&asked)?.rendering.context("no model is rendered")?.model;
    let out = &options.run.out;
    let folder = claim::folder(out, &archive_stem(asked.knob_name(), "verify-"))
        .with_context(|| format!("cannot create a folder in {}; choose another with --out", out.display()))?;
    let mut whole = Outcome::Done;
    let make =
        |name: &str, hand: HandRequest, amplitude_rad: Option<f64>, duration_s: f64| -> anyhow::Result<PathBuf> {
            asked.duration_s = duration_s;
            (asked.rig.simulated.hand, asked.amplitude) = (Some(hand), amplitude_rad);
            let in_words = format!("rendering {} for the {name}, {duration_s} s", model.name);
            let archive = folder.join(format!("{name}.mcap"));
            let run = SupervisedRun::new(in_words, asked.clone(), archive, options.run.offline);
            let (archive, outcome) = SupervisedRun { shown: Shown::Rendering, ..run }.complete(interrupted)?;
            whole = whole.worse(outcome);
            // Once is enough.
            asked.rendering.iter_mut().for_each(|rendering| rendering.without_remarks = true);
            Ok(archive)
        };
    let (rendering, fit) = verify(&model, options.pace.rate_hz, make)?;
    let results = &options.results;
    results.tell(model.axis, table::lines(&rendering), &rendering, || page(&model, &fit, &rendering))?;
    if let Some(path) = &results.report {
        show([format!("report   {}", path.display())]);
    }
    Ok(if rendering.passed { whole } else { Outcome::Failed })
}

/// The report page, which tells of a gap among its notes.
fn page(model: &Model, fit: &Fit, rendering: &Rendering) -> String {
    let gap = rendering.lost_motion.iter().flat_map(table::lost_motion_in_words);
    let notes = gap.chain(rendering.notes.iter().cloned()).collect();
    report::rendering_page(&RenderingPage { intended: model, fit, rendering: Rendering { notes, ..rendering.clone() } })
}

/// Captures the rendered knob and compares it with its model; gives also its fit as a knob of one body.
///
/// `make` makes a capture: its name, the hand, the largest angle of the hand's sweep in rad, its length in s; it gives the archive.
fn verify(
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

    let hold =
        |torque_mnm| capture("hold", holding(torque_mnm), None, HOLD_S).map(|hold| held_still(torque_mnm, &hold));
    let held_still = holding_torque_mnm(model).map(hold).transpose()?;
    let fit = fit(&train, model)?;
    let compared = [&train, &heldout, &creep];
    let rendering =
        if model.coupling().is_some() { two_bodies(model, compared)? } else { one_body(model, &fit, compared)? };
    let mut rendering = Rendering {
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

fn fit(train: &LoadedCapture, model: &Model) -> anyhow::Result<Fit> {
    // The model says what the torque over the angle is: nothing is left to be measured.
    let options =
        FitOptions { further_effects: further_effects(model), characteristic: false, ..analysis::fit_options(train) };
    identification::fit(&train.samples(), &options).context("the rendered knob cannot be fitted")
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
