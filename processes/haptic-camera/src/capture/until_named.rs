//! Capture after capture until one name is left: the rig runs the experiments that a diagnosis asks for.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use dynamics::Model;
use identification::diagnosis::Diagnosis;
use loaded_capture::LoadedCapture;
use report::DiagnosisPage;
use rt_loop::request::RunRequest;

use super::CaptureOptions;
use super::evidence::diagnosed;
use super::next::{Experiment, Next, next};
use super::{finish, supervised};
use crate::diagnose;
use crate::diagnosis_text;
use crate::outcome::{Outcome, remark, say, show};
use crate::outputs::{ResultFiles, kind, show_on, write};
use crate::recording;
use crate::supervision::{claim_archive, ending_signals};

/// The motion that is held out, unless it is the sweep asked for …
const HELD_OUT: &str = "multisine";
/// … and what is then held out.
const HELD_OUT_OF_MULTISINE: &str = "stepped-amplitude";

/// Exit status of a diagnosis that was stopped: failed.
const STOPPED: i32 = 1;

/// A finished capture and the motion that it was made with.
pub(super) struct Taken {
    experiment: Experiment,
    pub(super) loaded: LoadedCapture,
    path: PathBuf,
}

/// Turns the knob until its missing effects have names that nothing rivals, or the budget is spent.
///
/// # Errors
/// Whatever keeps a run from being made, and why there can be no meaningful diagnosis, in one sentence.
pub(super) fn run(options: &CaptureOptions, interrupted: &AtomicBool) -> anyhow::Result<Outcome> {
    if let Some(reach) = options.reach {
        anyhow::ensure!(reach.is_finite() && reach > 0.0, "--reach is {reach} rad, but it must be greater than zero");
    }
    // While the rig rests and a diagnosis is under way there is nothing to end in order.
    let at_rest = Arc::new(AtomicBool::new(false));
    for signal in ending_signals() {
        signal_hook::flag::register_conditional_shutdown(signal, STOPPED, Arc::clone(&at_rest))?;
    }
    let held_out = if options.request.sweep == HELD_OUT { HELD_OUT_OF_MULTISINE } else { HELD_OUT };
    let first = [options.request.sweep.as_str(), held_out]
        .map(|sweep| Experiment { sweep: sweep.to_owned(), amplitude_rad: options.request.amplitude });
    let mut taken: Vec<Taken> = Vec::new();
    let mut worst = Outcome::Done;
    for experiment in first {
        let Some((one, outcome)) = one_more(options, experiment, taken.len(), interrupted)? else {
            return Ok(Outcome::Failed);
        };
        taken.push(one);
        if outcome == Outcome::Failed || interrupted.load(Ordering::Acquire) {
            remark("no diagnosis: it needs two complete captures");
            return Ok(outcome);
        }
        worst = worst.worse(outcome);
    }
    let mut before: Option<Diagnosis> = None;
    loop {
        at_rest.store(true, Ordering::Release);
        let found = diagnosed(options, taken.iter().map(|one| &one.loaded).collect(), before.as_ref());
        at_rest.store(false, Ordering::Release);
        let found = match (found, before.take()) {
            (Ok(found), _) => found,
            (Err(error), Some(before)) => {
                remark(format!("the last capture cannot be diagnosed with the others: {error:#}"));
                conclude(options, &taken[..taken.len() - 1], &before)?;
                return Ok(Outcome::Failed);
            }
            (Err(error), None) => return Err(error),
        };
        let made: Vec<Experiment> = taken.iter().map(|one| one.experiment.clone()).collect();
        let next = match next(&found, &made, options.request.duration_s, options.budget) {
            _ if interrupted.load(Ordering::Acquire) => None,
            Next::Experiment(experiment, [one, other]) => {
                say(format!("\ncapture {}: to discriminate between {one} and {other}", taken.len() + 1));
                Some(experiment)
            }
            end => {
                tell_end(&end, &taken, diagnosis_text::is_floor_doubtful(&found));
                None
            }
        };
        let Some(experiment) = next else {
            conclude(options, &taken, &found)?;
            return Ok(worst);
        };
        let more = one_more(options, experiment, taken.len(), interrupted)?;
        match more {
            Some((one, outcome)) if outcome != Outcome::Failed && !interrupted.load(Ordering::Acquire) => {
                taken.push(one);
                before = Some(found);
                worst = worst.worse(outcome);
            }
            // What was found before stands; the cut capture is kept, and is no evidence.
            cut => {
                remark("the last experiment did not finish: the diagnosis uses the earlier ones");
                conclude(options, &taken, &found)?;
                return Ok(cut.map_or(Outcome::Failed, |(_, outcome)| worst.worse(outcome)));
            }
        }
    }
}

/// Makes one capture more; `None` when there is no archive.
pub(super) fn one_more(
    options: &CaptureOptions,
    experiment: Experiment,
    index: usize,
    interrupted: &AtomicBool,
) -> anyhow::Result<Option<(Taken, Outcome)>> {
    let mut options = options.clone();
    let RunRequest { sweep, amplitude, rig, .. } = &mut options.request;
    (*sweep, *amplitude) = (experiment.sweep.clone(), experiment.amplitude_rad);
    // Another run has other noise.
    if rt_loop::rigs::file(rig).is_ok_and(|file| file.driver == "simulated") {
        rig.simulated.seed = Some(rig.simulated.seed.unwrap_or(1).wrapping_add(index as u64));
    }
    let claim = claim_archive(&options.run.out, options.request.knob_name(), "")?;
    let run = supervised(&options, &claim);
    let Some(end) = run.take(interrupted)? else { return Ok(None) };
    let read = finish::read_back(&run.archive, &end)?;
    Ok(read.map(|(loaded, outcome)| (Taken { experiment, path: loaded.capture.source.clone(), loaded }, outcome)))
}

fn tell_end(end: &Next, taken: &[Taken], floor_is_doubtful: bool) {
    let captures = taken.len();
    match end {
        Next::Settled if floor_is_doubtful => remark(format!(
            "no rivals are left after {captures} captures, but the noise floor, and so the verdict, is doubtful"
        )),
        Next::Settled => say(format!("settled after {captures} captures")),
        Next::BudgetSpent => remark(format!("rivals are left and the budget is spent after {captures} captures")),
        Next::Undecidable => remark(
            "no experiment within reach discriminates between the remaining rivals; if the knob may be turned \
             further, give --reach",
        ),
        Next::Experiment(..) => {}
    }
}

/// Tells the diagnosis and writes it beside the first capture.
fn conclude(options: &CaptureOptions, taken: &[Taken], found: &Diagnosis) -> anyhow::Result<()> {
    let Some([first, held_out]) = taken.first_chunk() else { return Ok(()) };
    let axis = first.loaded.capture.axis;
    show([""]);
    show_on(axis, diagnosis_text::lines(found));
    let beside = |extension: &str| {
        let stem = first.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        first.path.with_file_name(format!("{stem}-diagnosis.{extension}"))
    };
    let files: Vec<String> = taken.iter().map(|one| one.path.display().to_string()).collect();
    let model = Model {
        name: analysis::title(&first.loaded),
        description: format!("diagnosed from {}: {}", files.join(", "), axis.words(&found.summary)),
        effects: found.model.effects.clone(),
        axis,
    };
    write(&beside("toml"), kind::DIAGNOSED_MODEL, &model.to_toml())?;
    say(format!("model    {}", beside("toml").display()));
    let page = DiagnosisPage {
        found,
        train: analysis::facts(&first.loaded),
        heldout: Some(analysis::facts(&held_out.loaded)),
    };
    let report = options.results.report.clone().unwrap_or_else(|| beside("html"));
    let results = ResultFiles { report: Some(report.clone()), ..options.results.clone() };
    diagnose::write_results(&results, axis, &page)?;
    say(format!("report   {}", report.display()));
    if let Some(path) = &options.recording {
        recording::write(path, found, &analysis::title(&first.loaded), Some(&analysis::title(&held_out.loaded)))?;
        say(format!("recording  {}", path.display()));
    }
    Ok(())
}
