//! Capture after capture, until one name is left for what the knob lacks, or the verdict on it is certain.

use std::path::Path;

use archive::testers::Curve;
use dynamics::{Coordinate, effects};
use identification::diagnosis::Diagnosis;
use loaded_capture::LoadedCapture;
use rt_loop::request::RunRequest;
use sheet::{Sheet, Verdict};

use super::next::next;
use super::{CaptureOptions, finish, supervised};
use crate::command_line::outputs::{ResultFiles, kind, show_on, write};
use crate::outcome::{Outcome, remark, say, show};
use crate::supervision::{Interrupt, LoopSaidWhy, claim_archive};
use crate::{diagnose, judge};

/// The motion that is held out, unless it is the sweep asked for …
const HELD_OUT: &str = "multisine";
/// … and what is then held out.
const HELD_OUT_OF_MULTISINE: &str = "stepped-amplitude";

struct Series<'run> {
    options: &'run CaptureOptions,
    interrupt: &'run Interrupt,
    made: u64,
    worst: Outcome,
}

/// The motion from which static figures are read, and how long it takes there and back, s.
const TURN: (&str, f64) = ("slow-turn", 15.0);

/// Turns the knob until its missing effects have names that nothing rivals, or the budget is spent.
pub(super) fn until_named(options: &CaptureOptions, interrupt: &Interrupt) -> anyhow::Result<Outcome> {
    let held_out = if options.request.sweep == HELD_OUT { HELD_OUT_OF_MULTISINE } else { HELD_OUT };
    let held_out = RunRequest { sweep: held_out.to_owned(), ..options.request.clone() };
    let mut made = vec![options.request.clone(), held_out];
    let mut series = Series { options, interrupt, made: 0, worst: Outcome::Done };
    let mut taken: Vec<LoadedCapture> = Vec::new();
    for experiment in &made {
        match series.add(experiment)? {
            Ok(one) => taken.push(one),
            Err(cut) => return Ok(cut_short(cut, "no diagnosis: it needs two complete captures")),
        }
    }
    let mut before: Option<Diagnosis> = None;
    loop {
        let found = diagnosed(options.reach, &taken, before.as_ref());
        let found = match (found, before.take()) {
            (Ok(found), _) => found,
            (Err(error), Some(before)) => {
                remark(format!("the last capture cannot be diagnosed with the others: {error:#}"));
                conclude(options, &taken[..taken.len() - 1], &before)?;
                return Ok(Outcome::Failed);
            }
            (Err(error), None) => return Err(error),
        };
        let next = if interrupt.is_noted() { None } else { next(&found, &made, options.budget) };
        let Some(experiment) = next else {
            conclude(options, &taken, &found)?;
            return Ok(series.worst);
        };
        // What was found before stands; the cut capture is kept, and is no evidence.
        let cut = match series.add(&experiment) {
            Ok(Ok(one)) => {
                taken.push(one);
                made.push(experiment);
                before = Some(found);
                continue;
            }
            Ok(Err(cut)) => cut,
            Err(error) => {
                if !error.is::<LoopSaidWhy>() {
                    remark(format!("{error:#}"));
                }
                None
            }
        };
        remark("the last experiment did not finish: the diagnosis uses the earlier ones");
        conclude(options, &taken, &found)?;
        return Ok(cut.map_or(Outcome::Failed, |outcome| series.worst.worse(outcome)));
    }
}

/// Diagnoses all captures so far, two at least; `before` is the diagnosis of all but the last.
///
/// The second capture is held out; the first and all later ones are fitted together, so that the experiments which tell rivals
/// apart also determine their parameters, and the sweep the others. An effect of the time since a capture began cannot be fitted
/// across captures: where one is named or tied, the first capture alone is fitted and the last one is held out.
fn diagnosed(reach: Option<f64>, taken: &[LoadedCapture], before: Option<&Diagnosis>) -> anyhow::Result<Diagnosis> {
    let mut fitted: Vec<&LoadedCapture> = taken.iter().collect();
    let held_out = if before.is_some_and(depends_on_time) {
        let last = fitted.split_off(fitted.len() - 1);
        fitted.truncate(1);
        last
    } else {
        vec![fitted.remove(1)]
    };
    let (train, heldout) = (LoadedCapture::joined(&fitted), LoadedCapture::joined(&held_out));
    let found = diagnose::with_progress(|progress| {
        Ok(analysis::diagnose_in_these_roles(reach, &train, &heldout, None, Some(progress))?)
    })?;
    ["", &found.summary].iter().for_each(say);
    Ok(found)
}

/// Whether a name or a rival is an effect of the time since a capture began.
fn depends_on_time(found: &Diagnosis) -> bool {
    let names = found.steps.iter().flat_map(|step| step.ties.iter().chain([&step.effect]));
    names.into_iter().filter_map(|name| effects::by_name(name)).any(|kind| kind.depends_on.contains(&Coordinate::Time))
}

/// Turns or presses the unit until it passes or fails, or the turns are spent.
pub(super) fn until_certain(options: &CaptureOptions, spec: &Path, interrupt: &Interrupt) -> anyhow::Result<Outcome> {
    let specification = analysis::load_specification(spec)?;
    let turn = RunRequest { sweep: TURN.0.to_owned(), duration_s: TURN.1, ..options.request.clone() };
    let mut series = Series { options, interrupt, made: 0, worst: Outcome::Done };
    let mut curves: Vec<Curve> = Vec::new();
    let mut verdict = Verdict::Undecided;
    while verdict == Verdict::Undecided && curves.len() < options.turns as usize {
        match series.add(&turn)? {
            Ok(loaded) => curves.push(loaded.curve()),
            Err(cut) => {
                let outcome = cut_short(cut, "no verdict: it needs a complete slow turn");
                return Ok(if outcome == Outcome::Done { Outcome::Undecided } else { outcome });
            }
        }
        let judgement = specification.judge(&Sheet::of(&Curve::evidence(&curves))?);
        verdict = judgement.verdict;
        let turns = curves.len();
        let after = if turns == 1 { "the first slow turn".to_owned() } else { format!("{turns} slow turns") };
        say([&[format!("{} after {after}", verdict.word())], judgement.reasons.as_slice()].concat().join("; "));
    }
    // A unit out of specification is so whatever else was lost.
    Ok(match judge::outcome(verdict) {
        Outcome::OutOfSpecification => Outcome::OutOfSpecification,
        outcome if series.worst == Outcome::Done => outcome,
        _ => series.worst,
    })
}

impl Series<'_> {
    /// Makes one more capture; if it was cut short, the error is its outcome, `None` where it left no archive.
    fn add(&mut self, experiment: &RunRequest) -> anyhow::Result<Result<LoadedCapture, Option<Outcome>>> {
        let mut request = experiment.clone();
        let rig = &mut request.rig;
        // Another run has other noise.
        if rt_loop::rigs::file(rig).is_ok_and(|file| file.driver == "simulated") {
            rig.simulated.seed = Some(rig.simulated.seed.unwrap_or(1).wrapping_add(self.made));
        }
        let claim = claim_archive(&self.options.run.out, request.knob_name(), "")?;
        let run = supervised(self.options, request, &claim);
        let end = run.take(self.interrupt)?;
        let Some((loaded, outcome)) = finish::read_back(&run.archive, &end)? else { return Ok(Err(None)) };
        if outcome == Outcome::Failed || self.interrupt.is_noted() {
            return Ok(Err(Some(outcome)));
        }
        self.made += 1;
        self.worst = self.worst.worse(outcome);
        Ok(Ok(loaded))
    }
}

/// How a command ends when a capture that it rests on was cut short.
fn cut_short(cut: Option<Outcome>, lacks: &str) -> Outcome {
    cut.inspect(|_| remark(lacks)).unwrap_or(Outcome::Failed)
}

/// Tells the diagnosis and writes it beside the first capture.
fn conclude(options: &CaptureOptions, taken: &[LoadedCapture], found: &Diagnosis) -> anyhow::Result<()> {
    let Some([first, held_out]) = taken.first_chunk() else { return Ok(()) };
    let axis = first.capture.axis;
    show([""]);
    show_on(axis, diagnose::text::lines(found));
    let path = &first.capture.source;
    let beside = |extension: &str| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        path.with_file_name(format!("{stem}-diagnosis.{extension}"))
    };
    let model = analysis::diagnosed_model(found, &taken.iter().collect::<Vec<_>>());
    write(&beside("toml"), kind::DIAGNOSED_MODEL, &model.to_toml())?;
    say(format!("model    {}", beside("toml").display()));
    let report = options.results.report.clone().unwrap_or_else(|| beside("html"));
    let results = ResultFiles { report: Some(report.clone()), ..options.results.clone() };
    diagnose::write_results(&results, &options.recording, found, first, Some(held_out))?;
    say(format!("report   {}", report.display()));
    options.recording.iter().for_each(|path| say(format!("recording  {}", path.display())));
    Ok(())
}
