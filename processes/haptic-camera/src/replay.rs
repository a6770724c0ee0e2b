//! `replay`: the rig feels like a model, for as long as the operator wants.

use std::path::Path;

use archive::Overview;
use clap::Args;
use dynamics::Axis;
use rt_loop::request::{HandRequest, LONGEST_DURATION_S, Pace, RenderingRequest, RigRequest, RunRequest};

use crate::command_line::RunOptions;
use crate::command_line::outputs::ResultFiles;
use crate::outcome::{Outcome, say};
use crate::supervision::{Interrupt, RunEnd, Shown, SupervisedRun, claim_archive};
use crate::verify;

/// Length of an offline replay, which nobody can stop by hand, s.
const OFFLINE_S: f64 = 10.0;

#[derive(Clone, Debug, Args)]
#[command(mut_arg("json", |json| json.requires("verify").help("Write the comparison as JSON; `-` for standard output")))]
#[command(mut_arg("report", |report| report.requires("verify").help("Write the comparison as a report page")))]
pub struct ReplayOptions {
    /// The model to feel like: a model file, or 1 to 5 for the paper's knobs
    #[arg(value_name = "1…5|MODEL.toml")]
    pub model: String,
    /// The model's name in the archive [default: that of the model]
    #[arg(long)]
    pub name: Option<String>,
    /// Render the nearest model within the rig's limits instead of refusing one that exceeds them, and list the changes
    #[arg(long)]
    pub nearest: bool,
    #[command(flatten)]
    pub hand: HandRequest,
    /// Amplitude of the hand's sweep, rad or mm [default: that of the sweep]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Length, s [default: until Ctrl-C, a day at most; offline 10]
    #[arg(long, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// Verify the rendering: capture the rendered knob with simulated hands, fit and diagnose it, and compare it with the
    /// model, parameter by parameter
    #[arg(long, conflicts_with_all = ["hand", "hand_torque", "grip", "amplitude", "duration_s"])]
    pub verify: bool,
    #[command(flatten)]
    pub results: ResultFiles,
    #[command(flatten)]
    pub pace: Pace,
    #[command(flatten)]
    pub rig: RigRequest,
    #[command(flatten)]
    pub run: RunOptions,
}

impl ReplayOptions {
    pub fn request(&self) -> RunRequest {
        let Self { model, name, nearest, hand, amplitude, duration_s, pace, rig, run, .. } = self;
        let mut request = RunRequest {
            rendering: Some(RenderingRequest { model: model.clone(), nearest: *nearest, without_remarks: false }),
            name: name.clone(),
            amplitude: *amplitude,
            duration_s: duration_s.unwrap_or(if run.offline { OFFLINE_S } else { LONGEST_DURATION_S }),
            pace: pace.clone(),
            rig: rig.clone(),
            ..RunRequest::default()
        };
        request.rig.simulated.hand = Some(hand.clone());
        request
    }
}

/// Most models that are listed at the end.
const LISTED_MODELS: usize = 12;

pub fn run(options: &ReplayOptions) -> anyhow::Result<Outcome> {
    let interrupt = Interrupt::listen()?;
    if options.verify {
        return verify::run(options, &interrupt);
    }
    let request = options.request();
    let claim = claim_archive(&options.run.out, request.knob_name(), "replay-")?;
    let axis = rt_loop::rigs::file(&request.rig)?.axis;
    let in_words = in_words(options, axis, &request);
    let run = SupervisedRun::new(in_words, request, claim.archive().to_owned(), options.run.offline);
    let run = SupervisedRun { viewer: options.run.viewer(), shown: Shown::Rendering, ..run };
    conclude(&run.archive, &run.take(&interrupt)?)
}

fn in_words(options: &ReplayOptions, axis: Axis, request: &RunRequest) -> String {
    let HandRequest { hand, hand_torque, .. } = &options.hand;
    let model = request.knob_name();
    let model = if model.parse::<u32>().is_ok() { format!("knob {model}") } else { model.to_owned() };
    let hand = match (hand_torque, hand.as_str()) {
        (Some(torque_mnm), _) => axis.words(&format!("a hand that applies {torque_mnm} mNm")).into_owned(),
        (None, "none") => "nobody's hand on it".to_owned(),
        (None, motion) => format!("a hand that follows {motion}"),
    };
    let length = if request.is_open_ended() {
        format!("until Ctrl-C, {} h at most", LONGEST_DURATION_S / 3600.0)
    } else {
        format!("for {} s", request.duration_s)
    };
    format!("rendering {model} with {hand} at {} Hz {length}", request.pace.rate_hz)
}

/// Tells what was rendered, how it went and where the archive lies.
fn conclude(archive: &Path, end: &RunEnd) -> anyhow::Result<Outcome> {
    end.tell();
    end.models.iter().enumerate().take(LISTED_MODELS).for_each(|(index, (tick, name))| {
        let from_s = *tick as f64 / end.status.rate_hz.max(1.0);
        say(format!("{} {name} from {from_s:.2} s on", if index == 0 { "rendered" } else { "        " }));
    });
    if end.models.len() > LISTED_MODELS {
        say(format!("         and {} more models; the archive lists them all", end.models.len() - LISTED_MODELS));
    }
    say(format!("guard    dissipated energy in {} ticks", end.status.guarded_ticks));
    let Some(archive) = end.left_archive(archive) else { return Ok(end.outcome_without_archive()) };
    let archived = Overview::read(&archive)?;
    say(format!("archive  {} ({} samples)", archive.display(), archived.samples));
    Ok(end.settle(&archived))
}
