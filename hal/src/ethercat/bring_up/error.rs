//! Why a bus does not come up.

use std::io;

use ethercrab::error::Error;

/// Why a bus does not come up.
#[derive(Debug, thiserror::Error)]
pub enum BringUpError {
    /// The interface cannot be used.
    #[error("the network interface {interface} cannot be used ({reason}); {remedy}")]
    Interface {
        /// The interface.
        interface: String,
        /// The system's word for it.
        reason: io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// There was a bus in this process before.
    #[error("one process drives one EtherCAT bus, once")]
    Again,
    /// Nothing answers.
    #[error("nothing answers on {0}; check the cable and the devices' supply")]
    Silent(String),
    /// The interface is down.
    #[error("{0} takes no frames; bring it up (`ip link set {0} up`) and check its cable")]
    Down(String),
    /// The caller asked to stop.
    #[error("stopped")]
    Stopped,
    /// A device sent a message of its own in place of an answer.
    #[error(
        "a device sent an emergency message while it was set up; clear its fault, or switch it off and on, and try again"
    )]
    Interrupted,
    /// A device that is not there.
    #[error("no device is {asked}, which [settings] has for '{name}'; there are {there}")]
    Missing {
        /// The file's name for it.
        name: String,
        /// What was asked for.
        asked: String,
        /// What there is.
        there: String,
    },
    /// Several devices match the one that was asked for.
    #[error("{count} devices are {asked}, which [settings] has for '{name}'; add `position`; there are {there}")]
    Ambiguous {
        /// The file's name for it.
        name: String,
        /// How many.
        count: usize,
        /// What was asked for.
        asked: String,
        /// What there is.
        there: String,
    },
    /// A device that does not do what it must.
    #[error("the device '{device}' {what}")]
    Unsuitable {
        /// The device.
        device: String,
        /// What it does not do.
        what: String,
    },
    /// A device that does not reach a state.
    #[error("the device '{device}' does not go to {state}: {reason}")]
    State {
        /// The device.
        device: String,
        /// The state.
        state: &'static str,
        /// Its reason.
        reason: String,
    },
    /// Something failed on the bus.
    #[error("the bus failed while {doing} ({reason}); check the cable and the devices' supply")]
    Bus {
        /// What was done.
        doing: String,
        /// ethercrab's word for it.
        reason: Error,
    },
    /// A source that the process data do not have.
    #[error("the source '{source_name}' is not among the inputs of '{device}': {there}; add it to its `inputs`")]
    NoInput {
        /// The source.
        source_name: String,
        /// The device.
        device: String,
        /// What it gives.
        there: String,
    },
}

pub(super) fn failed(doing: impl Into<String>) -> impl FnOnce(Error) -> BringUpError {
    let doing = doing.into();
    move |reason| BringUpError::Bus { doing, reason }
}

pub(super) fn unsuitable(device: &str, what: impl Into<String>) -> BringUpError {
    BringUpError::Unsuitable { device: device.to_owned(), what: what.into() }
}
