//! `simulate`: a model along a capture's motion or torque.

use analysis::{Drive, Simulation};
use archive::whole_file;

use crate::command_line::{SimulateOptions, SimulationDrive};
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::Kind;

/// Simulates the model, says how far it is from the capture, and writes one of the same length and rate if asked to.
///
/// # Errors
/// One sentence on what is wrong with the model, the capture or the output.
pub fn run(options: &SimulateOptions) -> anyhow::Result<Outcome> {
    let model = load::model(&options.model)?;
    let like = load::load_chosen(&options.like, &options.columns)?;
    let Simulation { capture, rms_difference, captured_rms } = analysis::simulate(&model, &like, options.drive.into())?;
    let differs = match options.drive {
        SimulationDrive::Motion => format!(
            "the model's torque differs from the capture's by {rms_difference:.3} of {captured_rms:.3} mNm RMS: \
             relative error {:.2} %",
            100.0 * rms_difference / captured_rms
        ),
        SimulationDrive::Torque => {
            format!("the model's angle differs by {rms_difference:.4} rad RMS from the capture's")
        }
    };
    say(model.axis.words(&differs));
    if let Some(out) = &options.out {
        if options.writes_table() {
            capture.write_csv(out)?;
        } else {
            whole_file::write_whole(out, Kind::Simulation.replaces(), |place| capture.write_mcap_to(place))?;
        }
        say(format!("{}: {} samples", out.display(), capture.len()));
    }
    Ok(Outcome::Done)
}

impl From<SimulationDrive> for Drive {
    fn from(drive: SimulationDrive) -> Self {
        match drive {
            SimulationDrive::Motion => Self::Motion,
            SimulationDrive::Torque => Self::Torque,
        }
    }
}
