//! The options of `calibrate`.

use std::path::PathBuf;

use clap::Args;
use rt_loop::request::Pace;

use crate::command_line::RigOptions;

/// Options of `calibrate`.
#[derive(Debug, Args)]
#[command(mut_arg("calibration", |calibration| calibration
    .help("The previous calibration, instead of the captures' own")
    .value_name("PREVIOUS.toml")))]
pub struct CalibrateOptions {
    /// What to calibrate
    #[arg(value_enum, value_name = "WHAT")]
    pub what: CalibrationKind,
    /// Captures to calibrate from; without any the rig is turned, with nothing on the gripper
    #[arg(value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// Write the calibration here; may be the file given as --calibration
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub out: PathBuf,
    /// Rate and core, if no capture is given
    #[command(flatten)]
    pub pace: Pace,
    /// The rig, if no capture is given
    #[command(flatten)]
    pub rig: RigOptions,
}

/// What `calibrate` can determine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum CalibrationKind {
    /// Gravity in the acceleration signal, from a slow turn of more than 360°.
    Gravity,
    /// The readings of torque sensor and accelerometer at rest, with nothing on the gripper.
    Zero,
    /// The gripper's inertia, from a sweep of the gripper alone.
    Gripper,
    /// Delays of torque and acceleration, from fast sines of the gripper alone.
    Latency,
    /// The motor's cogging, from slow turns of the gripper alone in both directions.
    Cogging,
    /// The motor's own inertia and friction, from a sweep of the gripper alone.
    Friction,
}
