//! Why a run cannot be done as asked.

use std::path::PathBuf;

use dynamics::excitation::ExcitationError;
use dynamics::{Axis, CalibrationError, ModelError};
use hal::RigFileError;
use hal::plugin::PluginRigError;
use shared_types::MODEL_MAX_BYTES;

use crate::control::rendering::Unrenderable;
use crate::request::LONGEST_DURATION_S;
use crate::stability::BoundExceeded;

/// A run that cannot be done as asked.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A rig that is not there.
    #[error("there is no shipped rig '{asked}'; --apparatus takes {known}, and --rig a file")]
    UnknownRig {
        /// The name asked for.
        asked: String,
        /// Those that ship.
        known: String,
    },
    /// A driver that is not there.
    #[error("the rig '{rig}' has an unknown driver '{asked}'; known are {known}")]
    UnknownDriver {
        /// The rig's name.
        rig: String,
        /// The driver asked for.
        asked: String,
        /// Those that there are, each with what it is.
        known: String,
    },
    /// A rig file that cannot be used.
    #[error(transparent)]
    RigFile(#[from] RigFileError),
    /// A library that cannot be used.
    #[error(transparent)]
    Plugin(#[from] PluginRigError),
    /// Something that only the simulated rig has.
    #[error("{what} only applies to the simulated rig, and not to '{rig}'; omit it")]
    NotSimulated {
        /// The rig's name.
        rig: String,
        /// The option.
        what: String,
    },
    /// A system call that the loop cannot look for.
    #[error("the rig '{rig}' declares an unknown system call '{call}'; known are {known}")]
    UnknownCall {
        /// The rig's name.
        rig: String,
        /// The call.
        call: String,
        /// Those that are.
        known: String,
    },
    /// A rig that cannot feel a hand.
    #[error("the rig '{0}' has no torque sensor, which a replay needs to measure the hand; it can only capture")]
    NoTorqueSensor(String),
    /// A rate at which nothing can be rendered.
    #[error("at {asked} Hz the rig '{rig}' cannot render a knob stably in a hand: {remedy}")]
    TooSlow {
        /// The rate asked for, Hz.
        asked: f64,
        /// The rig's name.
        rig: String,
        /// What to do instead.
        remedy: String,
    },
    /// A knob that cannot be had.
    #[error(transparent)]
    Knob(#[from] ModelError),
    /// A model of what moves along the other axis.
    #[error(
        "the model '{model}' is of a control with a {is} axis, and the rig '{rig}' has a {has} one; choose another of either"
    )]
    OtherAxis {
        /// The model's name.
        model: String,
        /// Its axis.
        is: Axis,
        /// The rig's name.
        rig: String,
        /// The rig's axis.
        has: Axis,
    },
    /// A knob that the simulated rig cannot turn.
    #[error("the knob cannot be put on the simulated rig: {0}")]
    Unmountable(String),
    /// A calibration that cannot be used.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A calibration of a rig that moves along the other axis.
    #[error(
        "{} is the calibration of a rig with a {is} axis, and the rig '{rig}' has a {has} one; calibrate this rig",
        path.display()
    )]
    CalibrationOfOtherAxis {
        /// The file.
        path: PathBuf,
        /// Its axis.
        is: Axis,
        /// The rig's name.
        rig: String,
        /// The rig's axis.
        has: Axis,
    },
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
    /// A rate at which the servo makes the shaft swing.
    #[error("at {asked} Hz the servo would be unstable with this knob: {remedy}")]
    Unstable {
        /// The rate asked for, Hz.
        asked: f64,
        /// What to do instead.
        remedy: String,
    },
    /// A hand that cannot be had.
    #[error("the hand is invalid: {0}")]
    Hand(String),
    /// A model that cannot be rendered.
    #[error(transparent)]
    Unrenderable(#[from] Unrenderable),
    /// A model that this rig cannot render.
    #[error(transparent)]
    Unsafe(#[from] BoundExceeded),
    /// A model that does not fit what is sent to the loop and published.
    #[error(
        "the model takes {bytes} bytes as TOML, but at most {MODEL_MAX_BYTES} can be rendered; shorten its description"
    )]
    TooLong {
        /// Its length, bytes of TOML.
        bytes: usize,
    },
    /// A rig whose own friction is not known.
    #[error(
        "the calibration has no motor_coulomb_mnm, so that the rig's own friction would add to the model's; run \
         `haptic-camera calibrate friction` first"
    )]
    Uncalibrated,
    /// What cannot be done on a rig that presses or slides, in the terms of such a rig.
    #[error("{0}")]
    OnLinearAxis(String),
    /// A duration that is no length of a run.
    #[error("a run cannot last {0} s; give a duration above 0 and up to a day ({LONGEST_DURATION_S} s)")]
    Duration(f64),
    /// A core that the process may not use.
    #[error("core {asked} is not available; this process may run on cores up to {last}")]
    Core {
        /// The core asked for.
        asked: usize,
        /// The last one permitted.
        last: usize,
    },
}
