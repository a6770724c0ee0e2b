//! The options of `simulate`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateOptions {
    /// The model
    #[arg(value_name = "MODEL.toml")]
    pub model: PathBuf,
    /// The capture that gives the motion or torque
    #[arg(long, value_name = "CAPTURE")]
    pub like: PathBuf,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Where to write the simulated capture: an archive, or CSV if the name ends in .csv
    #[arg(long, value_name = "CAPTURE")]
    pub out: Option<PathBuf>,
    /// The input from the capture: its motion, to simulate the torque, or its torque, to simulate the motion
    #[arg(long, value_enum, default_value = "motion")]
    pub drive: SimulationDrive,
}

/// What a simulation takes from a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SimulationDrive {
    /// The motion: the model's torque is simulated.
    Motion,
    /// The torque: the model's motion is simulated forward.
    Torque,
}
