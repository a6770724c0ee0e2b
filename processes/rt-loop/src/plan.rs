//! What the process was asked to do, checked against the rig.

use std::path::PathBuf;

use clap::Parser;
use dynamics::excitation::ExcitationError;
use dynamics::{Drive, Excitation, Model, ModelError, knobs};
use hal::simulated::{RigParameters, SimulatedRig};
use hal::{Apparatus, RigDescription};

use crate::control::{ControlPlan, ServoGains};

/// Slowest rate at which the servo's velocity filter still does its work, Hz.
const SLOWEST_RATE_HZ: f64 = 2_000.0;
/// Longest run, s: a day.
const LONGEST_DURATION_S: f64 = 86_400.0;

/// Turns the knob under real-time control and publishes what it measures.
#[derive(Debug, Clone, Parser)]
#[command(name = "rt-loop", version, about)]
pub struct Options {
    /// The rig: `sim` is the simulated one.
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// The knob on the simulated rig: 1 to 5 for the paper's, or a model file.
    #[arg(long, default_value = "3")]
    pub knob: String,
    /// The excitation: paper, linear-chirp, multisine, stepped-amplitude or hold.
    #[arg(long, default_value = "linear-chirp")]
    pub sweep: String,
    /// Command a torque instead of an angle.
    #[arg(long)]
    pub torque: bool,
    /// Largest commanded angle in rad, or torque in mNm [default: 1 rad, 20 mNm].
    #[arg(long)]
    pub amplitude: Option<f64>,
    /// Samples per second.
    #[arg(long, default_value_t = 10_000.0)]
    pub rate_hz: f64,
    /// Length of the run, s.
    #[arg(long, default_value_t = 10.0)]
    pub duration_s: f64,
    /// Seed of the simulated rig's noise.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Core for the real-time thread [default: the last one].
    #[arg(long)]
    pub core: Option<usize>,
}

/// A run that cannot be done as asked.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A rig that is not there.
    #[error("there is no apparatus '{0}'; this program drives 'sim', the simulated rig")]
    UnknownApparatus(String),
    /// A knob that cannot be had.
    #[error(transparent)]
    Knob(#[from] ModelError),
    /// A knob that the simulated rig cannot turn.
    #[error("the knob cannot be put on the simulated rig: {0}")]
    Unmountable(String),
    /// An excitation that cannot be had.
    #[error(transparent)]
    Excitation(#[from] ExcitationError),
    /// A rate outside what rig and servo hold.
    #[error("a rate of {asked} Hz cannot be held: the rig '{rig}' takes {slowest} to {fastest} Hz")]
    Rate {
        /// The rate asked for, Hz.
        asked: f64,
        /// The rig's name.
        rig: String,
        /// Slowest rate, Hz.
        slowest: f64,
        /// Fastest rate, Hz.
        fastest: f64,
    },
    /// A duration that is no length of a run.
    #[error("a run of {0} s cannot be done; give a duration above 0 and up to a day (86400 s)")]
    Duration(f64),
    /// A core that the process may not use.
    #[error("core {asked} is not to be had; this process may run on cores up to {last}")]
    Core {
        /// The core asked for.
        asked: usize,
        /// The last one permitted.
        last: usize,
    },
}

/// A run ready to be done.
pub struct Plan {
    /// The rig with the knob on it.
    pub apparatus: Box<dyn Apparatus>,
    /// What the rig says of itself.
    pub rig: RigDescription,
    /// The run itself.
    pub control: ControlPlan,
    /// The knob as the operator named it.
    pub knob: String,
    /// The model that the simulated rig turns.
    pub simulated_knob: Model,
    /// Core for the real-time thread.
    pub core: usize,
}

impl Plan {
    /// Checks the options against the rig.
    ///
    /// # Errors
    /// [`PlanError`], for whatever cannot be done as asked.
    pub fn new(options: &Options) -> Result<Self, PlanError> {
        if options.apparatus != "sim" {
            return Err(PlanError::UnknownApparatus(options.apparatus.clone()));
        }
        if !(options.duration_s > 0.0 && options.duration_s <= LONGEST_DURATION_S) {
            return Err(PlanError::Duration(options.duration_s));
        }
        let last = crate::realtime::last_core();
        let core = options.core.unwrap_or(last);
        if core > last {
            return Err(PlanError::Core { asked: core, last });
        }
        let drive = if options.torque { Drive::Torque } else { Drive::Position };
        let mut excitation = Excitation::named(&options.sweep, drive)?;
        if let Some(amplitude) = options.amplitude {
            excitation = excitation.with_amplitude(amplitude)?;
        }
        let knob = mounted_knob(&options.knob)?;
        let apparatus = SimulatedRig::new(RigParameters::default(), knob.clone(), options.seed)
            .map_err(|error| PlanError::Unmountable(error.to_string()))?;
        let rig = apparatus.description().clone();
        if !(options.rate_hz >= SLOWEST_RATE_HZ && options.rate_hz <= rig.limits.rate_hz) {
            return Err(PlanError::Rate {
                asked: options.rate_hz,
                rig: rig.name,
                slowest: SLOWEST_RATE_HZ,
                fastest: rig.limits.rate_hz,
            });
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to lie within a day")]
        let planned_ticks = ((options.rate_hz * options.duration_s).round() as u64).max(1);
        let control = ControlPlan {
            excitation,
            gains: ServoGains::default(),
            limits: rig.limits,
            rate_hz: options.rate_hz,
            planned_ticks,
        };
        Ok(Self {
            apparatus: Box::new(apparatus),
            rig,
            control,
            knob: options.knob.clone(),
            simulated_knob: knob,
            core,
        })
    }
}

fn mounted_knob(name: &str) -> Result<Model, ModelError> {
    match name.parse::<u32>() {
        Ok(number) => knobs::paper_knob(number),
        Err(_) => Model::load(&PathBuf::from(name)),
    }
}
