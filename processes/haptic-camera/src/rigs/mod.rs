//! `rig`: a rig of one's own, from an empty file to its first turn.

mod check;
mod commission;

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::atomic::Ordering;

use anyhow::Context as _;
use clap::{Args, Subcommand};
use rt_loop::request::{Pace, RigRequest, RunRequest};

use self::check::RigCheckOptions;
use self::commission::RigCommissionOptions;
use crate::command_line::outputs::{kind, write};
use crate::outcome::{Outcome, say};
use crate::rig_run;
use crate::supervision::{Interrupt, program};

#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Start a rig without torque: readings and noise of its channels, rate, watchdog
    Check(RigCheckOptions),
    /// Write a commented rig file, and the header for your own library
    New {
        /// The driver, as listed by `rig list`
        #[arg(long, default_value = "plugin")]
        driver: String,
        /// Where to write the rig file
        #[arg(long, value_name = "FILE.toml")]
        out: PathBuf,
    },
    /// List the drivers that a rig file may name
    List,
    /// Search a network interface or a tty for devices, and write a rig file for them
    Scan {
        /// A network interface or a tty
        #[arg(value_name = "TARGET")]
        target: String,
        /// Write a rig file for the devices here
        #[arg(long, value_name = "FILE.toml")]
        out: Option<PathBuf>,
    },
    /// Turn a rig for the first time, with little torque: signs, scales, inertia
    Commission(RigCommissionOptions),
}

#[derive(Debug, Args)]
pub struct RigFileOptions {
    /// The rig's file
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Samples per second [default: the fastest that the file permits]
    #[arg(long, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
}

/// Sample rate of a rig whose file names none, Hz.
const USUAL_RATE_HZ: f64 = 10_000.0;

pub fn run(command: &RigCommand) -> anyhow::Result<Outcome> {
    match command {
        RigCommand::Check(options) => check::run(options),
        RigCommand::New { driver, out } => new(driver, out),
        RigCommand::List => list(),
        RigCommand::Scan { target, out } => scan(target, out.as_deref()),
        RigCommand::Commission(options) => commission::run(options),
    }
}

fn new(driver: &str, out: &Path) -> anyhow::Result<Outcome> {
    let kind = rt_loop::rigs::ALL.into_iter().find(|kind| kind.name == driver);
    let names = || rt_loop::rigs::ALL.map(|kind| kind.name).join(", ");
    let kind = kind.with_context(|| format!("there is no driver '{driver}'; known are {}", names()))?;
    write(out, kind::DATA, kind.template)?;
    say(format!("rig file {}", out.display()));
    if kind.name == "plugin" {
        let header = out.with_file_name("haptic_rig.h");
        if !header.exists() {
            write(&header, kind::DATA, hal::plugin::HEADER)?;
            say(format!("header   {}", header.display()));
        }
    }
    Ok(Outcome::Done)
}

fn list() -> anyhow::Result<Outcome> {
    let listed = program("rt-loop")?.arg("--drivers").stderr(Stdio::inherit()).output()?;
    anyhow::ensure!(listed.status.success(), "the control loop does not list its drivers; build the whole workspace");
    String::from_utf8_lossy(&listed.stdout).lines().for_each(|line| say(line.replace('\t', "  ")));
    Ok(Outcome::Done)
}

fn scan(target: &str, out: Option<&Path>) -> anyhow::Result<Outcome> {
    let interrupt = Interrupt::listen()?;
    let found = interrupt.noted_during(|noted| {
        let stop = || noted.load(Ordering::Relaxed);
        rt_loop::rigs::scan(&rt_loop::rigs::ALL, target, &stop)
    })?;
    found.lines.iter().for_each(say);
    if let Some(out) = out {
        let none = || format!("{target} has no device for a rig; no rig file is written");
        write(out, kind::DATA, found.rig_file.as_ref().with_context(none)?)?;
        say(format!("rig file {}", out.display()));
    }
    Ok(Outcome::Done)
}

impl RigFileOptions {
    /// A run that commands torques on the rig: zero, unless the caller sets others.
    pub fn torque_request(&self, duration_s: f64) -> anyhow::Result<RunRequest> {
        let rig = RigRequest { rig: Some(self.file.clone()), ..RunRequest::default().rig };
        let file = rt_loop::rigs::file(&rig)?;
        let fastest_hz = [file.rates.map(|rates| rates.fastest_hz), file.limits.map(|limits| limits.rate_hz)];
        let fastest_hz = fastest_hz.into_iter().flatten().reduce(f64::min);
        let rate_hz = self.rate_hz.or(fastest_hz).unwrap_or(USUAL_RATE_HZ);
        let request = rig_run::request("none", "hold", duration_s, Pace { rate_hz, core: None }, rig);
        Ok(RunRequest { torque: true, ..request })
    }
}
