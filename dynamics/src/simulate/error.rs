//! Why a simulation ends early.

/// Why a model cannot be simulated forward.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// Without inertia a torque has no definite motion.
    #[error("forward simulation needs an inertia above zero, and the model with its gripper has {inertia} mNm s²/rad")]
    NoInertia {
        /// Inertia of model and gripper, mNm·s²/rad.
        inertia: f64,
    },
    /// Between the flanks of a gap a cap without inertia has no definite motion.
    #[error(
        "forward simulation of backlash needs a cap with inertia, and it has {inertia} mNm s²/rad; \
         choose a backlash_inner_share below 1"
    )]
    WeightlessCap {
        /// Inertia of cap and gripper, mNm·s²/rad.
        inertia: f64,
    },
    /// The motion grew beyond all numbers.
    #[error("the simulated motion is not finite after {time_s} s; the model is unstable under this torque")]
    NotFinite {
        /// Time at which it was found, s.
        time_s: f64,
    },
    /// Something in the model changes too fast to be followed.
    #[error(
        "the simulated motion changes too fast to be followed at {time_s} s; \
         some stiffness or damping of the model is too large for the inertia that it acts on"
    )]
    TooStiff {
        /// Time at which it was given up, s.
        time_s: f64,
    },
}
