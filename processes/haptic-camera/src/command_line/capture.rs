//! The options of `capture`.

use std::path::PathBuf;

use clap::Args;
use rt_loop::request::RunRequest;

use crate::capture::Budget;
use crate::command_line::RunOptions;
use crate::until_ci::Share;

/// Options of `capture`.
#[derive(Clone, Debug, Args)]
pub struct CaptureOptions {
    /// Rig, knob, motion and rate
    #[command(flatten)]
    pub request: RunRequest,
    /// End the sweep once every parameter is known within this share of its value, as 1%; --duration-s is then the longest.
    ///
    /// What counts is half the width of the 95 % interval, as fitted live. It must hold while the data grow by a tenth. A phase
    /// is judged by the share of one radian; a parameter whose whole interval makes less torque than one step of the torque
    /// sensor is settled.
    #[arg(long, value_name = "SHARE%", conflicts_with = "diagnose", allow_hyphen_values = true)]
    pub until_ci: Option<Share>,
    /// Judge the unit by a specification, slow turn after slow turn, and stop as soon as the verdict is certain; exit status as of
    /// `judge`. Every turn is a separate capture
    #[arg(long, value_name = "SPEC.toml", conflicts_with_all = ["diagnose", "until_ci", "torque"])]
    pub spec: Option<PathBuf>,
    /// Largest number of slow turns for a verdict
    #[arg(long, requires = "spec", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub turns: u32,
    /// Archive and view
    #[command(flatten)]
    pub run: RunOptions,
    /// Diagnose what is captured, and run the experiments that tell rivals apart until one name is left.
    ///
    /// The first capture is the sweep asked for, the second another motion that is held out. While effects are tied,
    /// the experiment on which they differ most is run and joins the evidence. Every capture is kept as a file of
    /// its own; model and report page of the diagnosis lie beside the first.
    #[arg(long, conflicts_with = "torque")]
    pub diagnose: bool,
    /// How much the knob may be turned for a diagnosis: captures, as in 5, or seconds of turning, as in 60s. The first two
    /// captures count, and are always made
    #[arg(long, requires = "diagnose", default_value = "5", value_name = "CAPTURES|SECONDSs")]
    pub budget: Budget,
    /// How far from its start the knob may be moved to tell rivals apart, rad or mm [default: as far as the first two captures]
    #[arg(long, requires = "diagnose", value_name = "RAD", allow_negative_numbers = true)]
    pub reach: Option<f64>,
    /// Write the diagnosis as JSON; `-` for standard output
    #[arg(long, requires = "diagnose", value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page of the diagnosis here, instead of beside the first capture
    #[arg(long, requires = "diagnose", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the diagnosis as a rerun file
    #[arg(long, requires = "diagnose", value_name = "FILE.rrd")]
    pub recording: Option<PathBuf>,
}
