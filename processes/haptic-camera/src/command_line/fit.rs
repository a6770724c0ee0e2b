//! The options of `fit`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `fit`.
#[derive(Debug, Args)]
pub struct FitOptions {
    /// The capture: an archive, a CSV or an MDF file; several of the same knob give one model
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the fitted model
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the fitted parameters into a joint of this MuJoCo model, changing the file: armature, damping, frictionloss, detents
    #[arg(long, value_name = "MUJOCO.xml")]
    pub into: Option<PathBuf>,
    /// The joint's name [default: the only one]
    #[arg(long, requires = "into", value_name = "NAME")]
    pub joint: Option<String>,
    /// Measure the torque over the angle point by point instead of fitting detents; linear controls are always fitted this way
    #[arg(long)]
    pub characteristic: bool,
    /// How the capture is filtered before the fit
    #[arg(long, value_enum, default_value = "automatic")]
    pub preparation: Preparation,
}

/// How a capture is filtered before a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preparation {
    /// Every cut-off frequency from the signals' own spectra.
    Automatic,
    /// As Swindells and MacLean 2007 did.
    Paper,
    /// Angle through a 100 Hz Butterworth low-pass, differenced twice, decimated to 100 Hz: common for robots.
    CentralDifferences,
}

impl From<Preparation> for identification::PreparationMethod {
    fn from(preparation: Preparation) -> Self {
        match preparation {
            Preparation::Automatic => Self::Automatic,
            Preparation::Paper => Self::Paper,
            Preparation::CentralDifferences => Self::CentralDifferences,
        }
    }
}
