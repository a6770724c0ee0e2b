//! Faults put into a running capture on purpose: which process, which fault, when, and what came of it.
//!
//! A [`Trial`] is drawn from a seed, so that each can be repeated alone. Its [`Outcome`] names every promise that was
//! broken; what a trial measured besides, the table of many trials needs (see `scripts/study-faults`).

mod draw;
mod early;
mod evidence;
mod outcome;
mod restarts;
mod table;
mod watched;

pub use draw::{Fault, Trial, Victim};
pub use early::EarlyKills;
pub use evidence::Evidence;
pub use outcome::Outcome;
pub use restarts::{Restarts, capture_with_restarts};
pub use table::markdown;
