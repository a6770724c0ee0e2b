//! Looking for devices: the driver that knows a target is asked what is there.

use hal::Scanned;

use super::Registry;
use crate::rig_lock::{DeviceLock, RigLockError};

/// How a driver looks for its devices.
pub struct Scan {
    /// What it looks at, for people: "an Ethernet interface".
    pub target: &'static str,
    /// Whether it knows this target.
    pub knows: fn(&str) -> bool,
    /// Looks at a target that it knows, until it is stopped; nothing moves.
    ///
    /// # Errors
    /// The driver's own, in a sentence.
    pub look: fn(&str, &dyn Fn() -> bool) -> Result<Scanned, DriverError>,
}

/// The error of a driver that cannot look.
pub type DriverError = Box<dyn std::error::Error + Send + Sync>;

/// Why nothing was found out about a target.
#[derive(Debug, thiserror::Error)]
pub enum ScanError {
    /// A target that no driver knows.
    #[error("no driver knows '{target}'; give {known} that this machine has")]
    UnknownTarget {
        /// The target.
        target: String,
        /// What drivers look at.
        known: String,
    },
    /// A run has it.
    #[error(transparent)]
    InUse(#[from] RigLockError),
    /// The driver's word for it.
    #[error(transparent)]
    Driver(DriverError),
}

/// Looks at a target with the driver that knows it, while no run holds it.
///
/// # Errors
/// [`ScanError`].
pub fn scan(registry: Registry<'_>, target: &str, stop: &dyn Fn() -> bool) -> Result<Scanned, ScanError> {
    let mut scans = registry.iter().filter_map(|kind| kind.scan.as_ref());
    let Some(found) = scans.clone().find(|scan| (scan.knows)(target)) else {
        let known: Vec<&str> = scans.by_ref().map(|scan| scan.target).collect();
        return Err(ScanError::UnknownTarget { target: target.to_owned(), known: known.join(" or ") });
    };
    let _device = DeviceLock::take(target, target)?;
    (found.look)(target, stop).map_err(ScanError::Driver)
}
