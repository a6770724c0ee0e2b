//! The commands under `rig`, and their options.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// What can be done about rigs.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Bring a rig up without torque: what its channels read, their noise, the rate it holds, its watchdog
    Check(RigCheckOptions),
    /// Write a commented rig file to begin with, and the header for a library of your own beside it
    New(RigNewOptions),
    /// List the drivers that a rig file may name
    List,
    /// Look for devices on a network interface or a tty, and write a rig file for what is there
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
    /// How long to look at it, s
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Write what was found as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of `rig new`.
#[derive(Debug, Args)]
pub struct RigNewOptions {
    /// The driver, as `rig list` has it
    #[arg(long, default_value = "plugin")]
    pub driver: String,
    /// Where to write the rig file
    #[arg(long, value_name = "FILE.toml")]
    pub out: PathBuf,
}

/// Options of `rig scan`.
#[derive(Debug, Args)]
pub struct RigScanOptions {
    /// Where to look: a network interface or a tty
    #[arg(value_name = "TARGET")]
    pub target: String,
    /// Where to write a rig file for what was found
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
    /// Where to write the rig file with what was found [default: FILE.toml itself]
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
    /// Folder for the captures made on the way
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}
