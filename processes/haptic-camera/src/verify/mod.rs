//! The proof of a rendering: the rendered knob captured like any other, fitted, diagnosed and compared with its model.

mod table;

use analysis::{RenderedCaptures, holding_torque_mnm};
use anyhow::Context as _;
use archive::claim;
use dynamics::excitation::PRESSED_MM;
use dynamics::{Axis, Model};
use identification::Fit;
use loaded_capture::LoadedCapture;
use report::{Rendering, RenderingPage};
use rt_loop::plan::Plan;
use rt_loop::request::HandRequest;
use rt_loop::stability::driving_speed_rad_s;

use crate::load;
use crate::outcome::{Outcome, show};
use crate::replay::ReplayOptions;
use crate::supervision::{Interrupt, Shown, SupervisedRun, archive_stem};

/// Grip of the hand that turns the knob, relative to a usual grip: it holds the knob firmly.
const GRIP: f64 = 6.0;
/// Largest amplitude of the sweeps, rad: the paper's.
const AMPLITUDE_RAD: f64 = 1.0;
/// Highest frequency of the sweep, Hz, so that amplitude and speed go together.
const SWEEP_HZ: f64 = 3.0;
/// Largest speed of the sweep, as a share of the speed above which rendered friction differs from the model's.
const SPEED_SHARE: f64 = 0.9;
/// Length of a sweep, s.
const SWEEP_S: f64 = 10.0;
/// Amplitude of the creep, rad, and its length, s; what is pressed creeps to its bottom.
const CREEP: (f64, f64) = (0.1, 15.0);
/// How long the knob is held, s.
const HOLD_S: f64 = 10.0;

/// Verifies a rendering and tells the result; failed if the rendered knob is not the model's.
pub fn run(options: &ReplayOptions, interrupt: &Interrupt) -> anyhow::Result<Outcome> {
    let mut asked = options.request();
    // The model that is to be felt: the one asked for, or the nearest to it that the rig renders.
    let model = Plan::new(&asked)?.rendering.context("no model is rendered")?.model;
    let out = &options.run.out;
    let folder = claim::folder(out, &archive_stem(asked.knob_name(), "verify-"))
        .with_context(|| format!("cannot create a folder in {}; choose another with --out", out.display()))?;
    let mut whole = Outcome::Done;
    let mut capture = |name: &str, hand: HandRequest, amplitude, duration_s| -> anyhow::Result<LoadedCapture> {
        asked.duration_s = duration_s;
        (asked.rig.simulated.hand, asked.amplitude) = (Some(hand), amplitude);
        let in_words = format!("rendering {} for the {name}, {duration_s} s", model.name);
        let archive = folder.join(format!("{name}.mcap"));
        let run = SupervisedRun::new(in_words, asked.clone(), archive, options.run.offline);
        let (archive, outcome) = SupervisedRun { shown: Shown::Rendering, ..run }.complete(interrupt)?;
        whole = whole.worse(outcome);
        // Once is enough.
        asked.rendering.iter_mut().for_each(|rendering| rendering.without_remarks = true);
        load::load(&archive)
    };
    let (widest, creep_to) = match model.axis {
        Axis::Rotary => (AMPLITUDE_RAD, CREEP.0),
        Axis::Linear => (PRESSED_MM, PRESSED_MM),
    };
    let amplitude_rad = driving_speed_rad_s(&model)
        .map_or(widest, |speed_rad_s| (SPEED_SHARE * speed_rad_s / (std::f64::consts::TAU * SWEEP_HZ)).min(widest));
    let firm = |sweep: &str| HandRequest { hand: sweep.to_owned(), hand_torque: None, grip: GRIP };
    let holding = |torque_mnm| HandRequest { hand_torque: Some(torque_mnm), grip: 1.0, ..firm("none") };
    let captures = RenderedCaptures {
        train: capture("sweep", firm("linear-chirp"), Some(amplitude_rad), SWEEP_S)?,
        heldout: capture("heldout", firm("stepped-amplitude"), Some(amplitude_rad), SWEEP_S)?,
        creep: capture("creep", firm("slow-turn"), Some(creep_to), CREEP.1)?,
        hold: holding_torque_mnm(&model)
            .map(|torque_mnm| capture("hold", holding(torque_mnm), None, HOLD_S))
            .transpose()?,
    };
    let (mut rendering, fit) = analysis::rendering(&model, &captures)?;
    rendering.rate_hz = options.pace.rate_hz;
    let results = &options.results;
    results.tell(model.axis, table::lines(&rendering), &rendering, || page(&model, &fit, &rendering))?;
    if let Some(path) = &results.report {
        show([format!("report   {}", path.display())]);
    }
    Ok(if rendering.passed { whole } else { Outcome::Failed })
}

/// The report page, with what is known of a gap among its notes.
fn page(model: &Model, fit: &Fit, rendering: &Rendering) -> String {
    let gap = rendering.lost_motion.iter().flat_map(table::lost_motion_in_words);
    let notes = gap.chain(rendering.notes.iter().cloned()).collect();
    report::rendering_page(&RenderingPage { intended: model, fit, rendering: Rendering { notes, ..rendering.clone() } })
}
