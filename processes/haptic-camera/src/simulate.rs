//! `simulate`: a model along a capture's motion or torque.

use analysis::{Drive, Simulation};
use archive::whole_file;
use dynamics::Model;

use crate::command_line::{SimulateOptions, SimulationDrive};
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::Kind;

/// Simulates the model and writes a capture of the same length and rate.
///
/// # Errors
/// One sentence on what is wrong with the model, the capture or the output.
pub fn run(options: &SimulateOptions) -> anyhow::Result<Outcome> {
    let model = Model::load(&options.model)?;
    let like = load::load(&options.like)?;
    let Simulation { capture, rms_difference } = analysis::simulate(&model, &like, options.drive.into())?;
    if options.writes_table() {
        capture.write_csv(&options.out)?;
    } else {
        whole_file::write_whole(&options.out, Kind::Simulation.replaces(), |place| capture.write_mcap_to(place))?;
    }
    let difference = match options.drive {
        SimulationDrive::Motion => format!("torque differs by {rms_difference:.3} mNm RMS"),
        SimulationDrive::Torque => format!("angle differs by {rms_difference:.4} rad RMS"),
    };
    say(format!("{}: {} samples; {difference} from the capture", options.out.display(), capture.len()));
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
