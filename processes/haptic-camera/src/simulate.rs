//! `simulate`: a model along a capture's motion or torque.

use std::path::PathBuf;

use analysis::{Drive, Simulation};
use archive::whole_file;
use clap::Args;

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::kind;
use crate::load;
use crate::outcome::say;

#[derive(Debug, Args)]
pub struct SimulateOptions {
    /// The model
    #[arg(value_name = "MODEL.toml")]
    pub model: PathBuf,
    /// The capture that gives the motion or torque
    #[arg(long, value_name = "CAPTURE")]
    pub like: PathBuf,
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Where to write the simulated capture: an archive, or CSV if the name ends in .csv
    #[arg(long, value_name = "CAPTURE")]
    pub out: Option<PathBuf>,
    /// The input from the capture: its motion, to simulate the torque, or its torque, to simulate the motion
    #[arg(long, value_enum, default_value = "motion")]
    pub drive: Drive,
}

/// Simulates the model, says how far it is from the capture, and writes one of the same length and rate if asked to.
pub fn run(options: &SimulateOptions) -> anyhow::Result<()> {
    let model = load::model(&options.model)?;
    let like = load::load_chosen(&options.like, &options.columns)?;
    let Simulation { capture, rms_difference, captured_rms } = analysis::simulate(&model, &like, options.drive)?;
    let differs = match options.drive {
        Drive::Motion => format!(
            "the model's torque differs from the capture's by {rms_difference:.3} of {captured_rms:.3} mNm RMS: \
             relative error {:.2} %",
            100.0 * rms_difference / captured_rms
        ),
        Drive::Torque => {
            format!("the model's angle differs by {rms_difference:.4} rad RMS from the capture's")
        }
    };
    say(model.axis.words(&differs));
    if let Some(out) = &options.out {
        if options.writes_table() {
            // The columns alone: a table does not tell the gripper's inertia, which counts as the knob's.
            capture.capture.write_csv(out)?;
        } else {
            whole_file::write_whole(out, kind::SIMULATION, |place| capture.write_mcap_to(place))?;
        }
        say(format!("{}: {} samples", out.display(), capture.capture.len()));
    }
    Ok(())
}
