//! The options of `export`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `export`.
#[derive(Debug, Args)]
pub struct ExportOptions {
    /// What to export: a capture, or a model as file or as 1 to 5 for the paper's knobs
    #[arg(value_name = "CAPTURE|MODEL.toml|1…5")]
    pub source: String,
    /// The file to write; its extension selects the format: a capture as .csv or .parquet, a model's torque over the angle
    /// as .csv or .h, a model for simulators as .xml (MuJoCo), .urdf (and a file for Isaac Lab) or .fmu (FMI 3.0),
    /// a model for SmartKnob's firmware as .json
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Number of points in a model's table
    #[arg(long, default_value_t = 256, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=65_536))]
    pub points: u32,
    /// Angle that a model's table covers [default: one period of the detents, a turn without detents]
    #[arg(long, value_enum, value_name = "SPAN")]
    pub over: Option<TableSpan>,
    /// Torque per volt of SmartKnob's motor, mNm/V
    #[arg(long, value_name = "MNM_PER_V", value_parser = positive)]
    pub motor_mnm_per_v: Option<f64>,
    /// Compute the torque that a simulator's format leaves out along this capture's motion [default: the sweep linear-chirp]
    #[arg(long, value_name = "CAPTURE")]
    pub along: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    if number.is_finite() && number > 0.0 { Ok(number) } else { Err("it must be greater than zero".to_owned()) }
}

/// The angle that a table covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TableSpan {
    /// From one detent to the next.
    Period,
    /// Once around, with springs and end stops.
    Turn,
}
