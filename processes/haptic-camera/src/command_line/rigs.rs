//! The commands under `rig`, and their options.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// The commands about rigs.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Start a rig without torque: readings and noise of its channels, rate, watchdog
    Check(RigCheckOptions),
    /// Write a commented rig file, and the header for your own library
    New(RigNewOptions),
    /// List the drivers that a rig file may name
    List,
    /// Search a network interface or a tty for devices, and write a rig file for them
    Scan(RigScanOptions),
    /// Turn a rig for the first time, with little torque: signs, scales, inertia
    Commission(RigCommissionOptions),
}

/// Options of `rig check`.
#[derive(Debug, Args)]
pub struct RigCheckOptions {
    /// The rig's file
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Samples per second [default: the fastest that the file permits]
    #[arg(long, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
    /// Duration, s
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of `rig new`.
#[derive(Debug, Args)]
pub struct RigNewOptions {
    /// The driver, as listed by `rig list`
    #[arg(long, default_value = "plugin")]
    pub driver: String,
    /// Where to write the rig file
    #[arg(long, value_name = "FILE.toml")]
    pub out: PathBuf,
}

/// Options of `rig scan`.
#[derive(Debug, Args)]
pub struct RigScanOptions {
    /// A network interface or a tty
    #[arg(value_name = "TARGET")]
    pub target: String,
    /// Write a rig file for the devices here
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
}

/// Options of `rig commission`.
#[derive(Debug, Args)]
pub struct RigCommissionOptions {
    /// The rig's file
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Samples per second [default: the fastest that the file permits]
    #[arg(long, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
    /// Largest torque to try, mNm, or force, N [default: a third of the limit]
    #[arg(long, value_name = "MNM", allow_negative_numbers = true)]
    pub most_torque: Option<f64>,
    /// Write the rig file with the results here [default: FILE.toml itself]
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
    /// Folder for the captures
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}
