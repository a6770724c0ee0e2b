//! The part to which an effect belongs when a knob is composed of parts of others.

use std::fmt;

/// The part of a composed knob that an effect comes with; every effect's file says which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// What resists acceleration: inertia.
    Inertia,
    /// What resists turning: friction, its stick, what modulates it, bristles, drag.
    Friction,
    /// Torques that repeat along the angle: detents of every waveform, cogging.
    Detents,
    /// All else: springs, stops, an imbalance, lost motion, a soft shaft, what a sensor misreads. Taken one by one.
    Other,
}

impl fmt::Display for Role {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Inertia => "inertia",
            Self::Friction => "friction",
            Self::Detents => "detents",
            Self::Other => "other effects",
        })
    }
}
