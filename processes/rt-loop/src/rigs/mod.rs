//! The rigs that the control loop can drive: one file each, and the list of them.
//!
//! To add a rig, implement [`Apparatus`] for it, write a file beside `sim.rs` that makes it from a request, and add its
//! [`RigKind`] to [`ALL`].

mod hand;
mod sim;

use dynamics::Model;
use hal::Apparatus;

use crate::plan::PlanError;
use crate::request::RunRequest;

/// A kind of rig.
pub struct RigKind {
    /// Its name, as `--apparatus` takes it.
    pub name: &'static str,
    /// What it is, in a few words.
    pub description: &'static str,
    /// Makes it ready for a run, its amplifier off.
    ///
    /// # Errors
    /// [`PlanError`], for what it cannot be asked.
    pub make: fn(&RunRequest) -> Result<Rig, PlanError>,
}

/// A rig ready for a run.
pub struct Rig {
    /// What the control loop drives.
    pub apparatus: Box<dyn Apparatus>,
    /// The model that a simulated rig turns; `None` on real hardware.
    pub simulated_knob: Option<Model>,
}

/// Every rig.
pub static ALL: [&RigKind; 1] = [&sim::KIND];

/// The rig called `name`.
///
/// # Errors
/// [`PlanError::UnknownRig`] with those that there are.
pub fn by_name(name: &str) -> Result<&'static RigKind, PlanError> {
    ALL.into_iter().find(|kind| kind.name == name).ok_or_else(|| PlanError::UnknownRig {
        asked: name.to_owned(),
        known: ALL.map(|kind| format!("'{}' ({})", kind.name, kind.description)).join(", "),
    })
}
