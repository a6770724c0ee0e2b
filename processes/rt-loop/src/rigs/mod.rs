//! The drivers that the control loop has: one file each, and the list of them.
//!
//! To add one, implement [`Apparatus`] in a folder under `hal/`, write a file beside `plugin.rs` that makes it of a rig file, and
//! add its [`RigKind`] to [`ALL`]; or leave this as it is, and hand a list of your own to [`run`](crate::run).

mod ethercat;
mod hand;
mod moteus;
mod plugin;
mod scan;
mod simulated;

use dynamics::Model;
use hal::{Apparatus, RigFile};
pub use scan::{DriverError, Scan, ScanError, scan};

use crate::plan::PlanError;
use crate::request::{RigRequest, RunRequest};

/// A driver.
pub struct RigKind {
    /// Its name, as a rig file's `driver` has it.
    pub name: &'static str,
    /// What it drives, in a few words.
    pub description: &'static str,
    /// A commented rig file to begin with.
    pub template: &'static str,
    /// Makes the rig ready for a run, its amplifier off.
    ///
    /// # Errors
    /// [`PlanError`], for a request that the driver cannot meet.
    pub make: fn(&RigFile, &RunRequest) -> Result<Rig, PlanError>,
    /// How it looks for its devices; `None` for a driver that cannot.
    pub scan: Option<Scan>,
}

/// A rig ready for a run.
pub struct Rig {
    /// What the control loop drives.
    pub apparatus: Box<dyn Apparatus>,
    /// The model that a simulated rig turns; `None` on real hardware.
    pub simulated_knob: Option<Model>,
}

/// The drivers to choose from.
pub type Registry<'a> = &'a [&'static RigKind];

/// Every driver of ours.
pub static ALL: [&RigKind; 4] = [&simulated::KIND, &plugin::KIND, &ethercat::KIND, &moteus::KIND];

/// The simulated rigs' files, by the names that `--apparatus` has for them.
const SHIPPED: [(&str, &str); 2] =
    [("sim", hal::simulated_rig::RIG_FILE), ("sim-linear", hal::simulated_rig::LINEAR_RIG_FILE)];

/// The file of the rig that is asked for: one that is given, or one that ships.
///
/// # Errors
/// [`PlanError::RigFile`], and [`PlanError::UnknownRig`] with those that ship.
pub fn file(asked: &RigRequest) -> Result<RigFile, PlanError> {
    let shipped = SHIPPED.iter().find(|(name, _)| asked.apparatus == *name);
    match (&asked.rig, shipped) {
        (Some(path), _) => Ok(RigFile::load(path)?),
        (None, Some((_, text))) => Ok(RigFile::parse(text, std::path::Path::new(""))?),
        (None, None) => Err(PlanError::UnknownRig {
            asked: asked.apparatus.clone(),
            known: SHIPPED.map(|(name, _)| format!("'{name}'")).join(" and "),
        }),
    }
}

/// The driver of a rig file.
///
/// # Errors
/// [`PlanError::UnknownDriver`] with those that there are.
pub fn driver(registry: Registry<'_>, file: &RigFile) -> Result<&'static RigKind, PlanError> {
    registry.iter().copied().find(|kind| kind.name == file.driver).ok_or_else(|| PlanError::UnknownDriver {
        rig: file.name.clone(),
        asked: file.driver.clone(),
        known: registry
            .iter()
            .map(|kind| format!("'{}' ({})", kind.name, kind.description))
            .collect::<Vec<_>>()
            .join(", "),
    })
}

/// Refuses what only the simulated rig can be asked.
///
/// # Errors
/// [`PlanError::NotSimulated`].
pub fn refuse_simulated(file: &RigFile, request: &RunRequest) -> Result<(), PlanError> {
    let refused = |what: &str| Err(PlanError::NotSimulated { rig: file.name.clone(), what: what.to_owned() });
    let simulated = &request.rig.simulated;
    if simulated.seed.is_some() {
        return refused("--seed");
    }
    if !simulated.motor_cogging.is_empty() {
        return refused("--motor-cogging");
    }
    match &simulated.hand {
        Some(hand) if hand.hand != "none" || hand.hand_torque.is_some() => {
            refused("a hand (--hand, --hand-torque, --verify)")
        }
        _ => Ok(()),
    }
}
