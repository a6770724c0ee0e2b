//! `capture`: a knob turned through a sweep, recorded and fitted.

mod finish;
mod next;
mod series;

use std::path::PathBuf;

use archive::Claim;
use clap::Args;
use rt_loop::request::RunRequest;

use crate::command_line::RunOptions;
use crate::command_line::outputs::ResultFiles;
use crate::export::positive;
use crate::outcome::Outcome;
use crate::supervision::{Interrupt, Shown, SupervisedRun, claim_archive};
use crate::until_ci::Share;
pub(crate) use next::Budget;

#[derive(Clone, Debug, Args)]
#[command(mut_arg("json", |json| json.requires("diagnose").help("Write the diagnosis as JSON; `-` for standard output")))]
#[command(mut_arg("report", |report| report.requires("diagnose")
    .help("Write the report page of the diagnosis here, instead of next to the first capture")))]
pub struct CaptureOptions {
    #[command(flatten)]
    pub request: RunRequest,
    /// End the sweep once every parameter is known within this share of its value, as 1%; --duration-s is then the longest.
    ///
    /// The criterion is half the width of the 95 % interval of the live fit, and must hold while the data grow by a tenth. For a
    /// phase it is the share of one radian; a parameter whose interval amounts to less torque than one step of the torque
    /// sensor meets it.
    #[arg(long, value_name = "SHARE%", conflicts_with = "diagnose", allow_hyphen_values = true)]
    pub until_ci: Option<Share>,
    /// Judge the unit by a specification, with repeated slow turns until the verdict is certain; exit status as for `judge`. Every
    /// turn is a separate capture
    #[arg(
        long,
        value_name = "SPEC.toml",
        conflicts_with_all = ["diagnose", "until_ci", "torque", "sweep", "duration_s"]
    )]
    pub spec: Option<PathBuf>,
    /// Largest number of slow turns for a verdict
    #[arg(long, requires = "spec", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub turns: u32,
    #[command(flatten)]
    pub run: RunOptions,
    /// Diagnose the captures, and run experiments that discriminate between rival effects until one is left.
    ///
    /// The first capture is the requested sweep, the second another motion that is held out. While effects are tied,
    /// the experiment on which they differ most is run and added to the evidence. Every capture is a separate file;
    /// model and report page of the diagnosis go next to the first.
    #[arg(long, conflicts_with = "torque")]
    pub diagnose: bool,
    /// Budget of a diagnosis: captures, as in 5, or seconds of turning, as in 60s. It includes the first two captures,
    /// which are always made
    #[arg(long, requires = "diagnose", default_value = "5", value_name = "CAPTURES|SECONDSs")]
    pub budget: Budget,
    /// Largest distance from the start to move the control in experiments, rad or mm [default: that of the first two captures]
    #[arg(long, requires = "diagnose", value_name = "RAD", value_parser = positive, allow_negative_numbers = true)]
    pub reach: Option<f64>,
    #[command(flatten)]
    pub results: ResultFiles,
    /// Write the diagnosis as a rerun file
    #[arg(long, requires = "diagnose", value_name = "FILE.rrd")]
    pub recording: Option<PathBuf>,
}

pub fn run(options: &CaptureOptions) -> anyhow::Result<Outcome> {
    let interrupt = Interrupt::listen()?;
    if options.diagnose {
        return series::until_named(options, &interrupt);
    }
    if let Some(spec) = &options.spec {
        return series::until_certain(options, spec, &interrupt);
    }
    let claim = claim_archive(&options.run.out, options.request.knob_name(), "")?;
    let run = supervised(options, options.request.clone(), &claim);
    finish::conclude(&run.archive, &run.take(&interrupt)?, options.request.duration_s)
}

fn supervised(options: &CaptureOptions, request: RunRequest, claim: &Claim) -> SupervisedRun {
    let CaptureOptions { run, until_ci: until, .. } = options;
    let in_words = in_words(&request, *until);
    let plain = SupervisedRun::new(in_words, request, claim.archive().to_owned(), run.offline);
    SupervisedRun { viewer: run.viewer(), until: *until, shown: Shown::Fit, ..plain }
}

fn in_words(request: &RunRequest, until: Option<Share>) -> String {
    let RunRequest { sweep, torque, amplitude, duration_s, pace, rig, .. } = request;
    let amplitude = amplitude
        .map_or_else(String::new, |amplitude| format!(" of {amplitude:.3} {}", if *torque { "mNm" } else { "rad" }));
    let axis = rt_loop::rigs::file(rig).map(|file| file.axis).unwrap_or_default();
    let amplitude = axis.words(&amplitude);
    let until = until.map_or_else(|| "for ".to_owned(), |share| format!("until ± {share}, at most "));
    let knob = request.knob_name();
    format!("capturing knob {knob} with {sweep}{amplitude} at {} Hz {until}{duration_s} s", pace.rate_hz)
}
