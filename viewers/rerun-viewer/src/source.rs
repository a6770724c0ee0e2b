//! Where samples, fits and health come from.

use shared_types::{FitUpdate, LoopStatus, ProcessHealth, RunDescription, Sample};

/// Something that a source has to tell.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// What the run is.
    Description(&'a RunDescription),
    /// Consecutive samples of a run.
    Samples {
        /// Identity of the run.
        run_id: u64,
        /// In the order of their ticks.
        samples: &'a [Sample],
    },
    /// The control loop's word about itself.
    Status(&'a LoopStatus),
    /// The model fitted so far.
    Fit(&'a FitUpdate),
    /// A consumer's word about itself.
    Health(&'a ProcessHealth),
}

/// Gives events as they come, from a running rig or from what one left behind.
pub trait Source {
    /// Hands over everything that has come since the last call; does not wait.
    ///
    /// `samples_wanted` is false while the rate is unknown: samples without a time cannot be
    /// drawn and wait in the source.
    ///
    /// # Errors
    /// When the source has failed for good.
    fn poll(&mut self, samples_wanted: bool, take_in: &mut dyn FnMut(Event<'_>)) -> anyhow::Result<()>;
}
