//! Forward simulation: the motion of a knob under a given torque, with true stick and slip.
//!
//! Between events the equations of motion
//!
//! ```text
//! J·ω̇ = T − free(θ, ω, t) − friction(θ, ω, direction)       what friction and detents act on
//! Jc·ω̇c = τ − T,  T = coupling(θc − θ, ωc − ω)               a cap before it, where the knob has two bodies
//! ```
//!
//! (T = τ in a knob of one body) are integrated with steps that keep to a tolerance, so that contacts, shafts and
//! bristles may be as stiff as they like. Events are located to rounding: the velocity falling through Karnopp's Δv or
//! through zero, and the load on a resting body passing D₋ or D₊. The result therefore does not depend on how the time
//! is divided, and a knob at rest does not creep.
//!
//! Bristles do not stick: between two reversals their deflection is a function of the angle alone
//! ([`crate::Bristles::bent`]), so only reversals are events. What a torque sensor reads besides the torque takes no
//! part in the motion; [`crate::Model::knob_torque_mnm`] takes it off.
//!
//! Where the motion of the cap is given, `inner_body` follows it in fixed substeps.
//!
//! [`forward_windows`] compares a model's motion with a measured one, window by window, and
//! [`forward_windows_from_command`] does so from the command to the rig's motor.

mod driving;
mod equation;
mod error;
mod events;
pub(crate) mod inner_body;
mod observer;
mod runge_kutta;
mod state;
mod twist;
mod windows;

use self::equation::Equation;
use self::runge_kutta::Place;
use self::twist::Twist;
use crate::{Coupling, Direction, Model, Motion};

pub use self::driving::RigMotor;
pub use self::error::SimulationError;
pub use self::state::State;
pub use self::windows::{ForwardErrors, WindowErrors, forward_windows, forward_windows_from_command};

/// Longest step, s; also the time in which the number of events and of steps is bounded.
const LONGEST_STEP_S: f64 = 100e-6;

/// A knob in motion.
#[derive(Clone, Debug)]
pub struct ForwardSimulation<'model> {
    equation: Equation<'model>,
    time_s: f64,
    place: Place,
    /// Deflection of the bristles, if friction has any.
    deflection: f64,
    /// `None` while what friction acts on is at rest.
    sliding: Option<Direction>,
    /// Twist of a shaft whose cap has no inertia.
    twist: Option<Twist>,
    /// Length of the step to try next, s.
    step_s: f64,
}

/// Torque over one step: a straight line from its start to its end.
#[derive(Clone, Copy, Debug)]
struct TorqueLine {
    start_s: f64,
    start_mnm: f64,
    slope_mnm_s: f64,
}

impl TorqueLine {
    fn at(&self, time_s: f64) -> f64 {
        self.start_mnm + self.slope_mnm_s * (time_s - self.start_s)
    }
}

impl<'model> ForwardSimulation<'model> {
    /// A knob at rest at `angle_rad`, with `added_inertia` (a gripper's, mNm·s²/rad) turning with it.
    ///
    /// # Errors
    /// [`SimulationError::NoInertia`] and [`SimulationError::WeightlessCap`].
    pub fn at_rest(model: &'model Model, added_inertia: f64, angle_rad: f64) -> Result<Self, SimulationError> {
        Self::from_state(model, added_inertia, &State::at_rest(angle_rad), 0.0)
    }

    /// A knob in a given state, under `torque_mnm`.
    ///
    /// It is at rest if it is slower than Karnopp's Δv and bears its load.
    ///
    /// # Errors
    /// [`SimulationError::NoInertia`] and [`SimulationError::WeightlessCap`].
    pub fn from_state(
        model: &'model Model,
        added_inertia: f64,
        state: &State,
        torque_mnm: f64,
    ) -> Result<Self, SimulationError> {
        let (equation, twist) = Equation::of(model, added_inertia)?;
        Ok(Self::started(equation, twist, state, torque_mnm))
    }

    fn started(equation: Equation<'model>, twist: Option<Twist>, state: &State, torque_mnm: f64) -> Self {
        let velocity_rad_s = state.inner_velocity_rad_s;
        let mut simulation = Self {
            equation,
            time_s: state.time_s,
            place: [state.inner_angle_rad, velocity_rad_s, state.angle_rad, state.velocity_rad_s],
            deflection: state.deflection,
            sliding: (velocity_rad_s != 0.0).then(|| Direction::of(velocity_rad_s)),
            twist: twist.map(|twist| twist.wound(state)),
            step_s: LONGEST_STEP_S,
        };
        let torque = TorqueLine { start_s: state.time_s, start_mnm: torque_mnm, slope_mnm_s: 0.0 };
        if velocity_rad_s.abs() < simulation.stick_velocity_rad_s() && simulation.breakaway(&torque).is_none() {
            simulation.come_to_rest();
        }
        simulation
    }

    /// The inner body of a knob of two bodies, from a state on; the cap's motion is given.
    fn led(model: &'model Model, coupling: Coupling, state: &State) -> Result<Self, SimulationError> {
        Ok(Self::started(Equation::led(model, coupling)?, None, state, 0.0))
    }

    /// Moves on, the cap going from one motion to the other along the cubic that has their angles and velocities.
    fn lead(&mut self, from: &Motion, to: &Motion) -> Result<(), SimulationError> {
        let step_s = to.time_s - from.time_s;
        let mean_rad_s = (to.angle_rad - from.angle_rad) / step_s;
        let now = (6.0 * mean_rad_s - 4.0 * from.velocity_rad_s - 2.0 * to.velocity_rad_s) / step_s;
        let then = (2.0 * from.velocity_rad_s + 4.0 * to.velocity_rad_s - 6.0 * mean_rad_s) / step_s;
        [self.place[2], self.place[3]] = [from.angle_rad, from.velocity_rad_s];
        self.advance(step_s, now, then)?;
        [self.place[2], self.place[3]] = [to.angle_rad, to.velocity_rad_s];
        Ok(())
    }

    /// Whether what friction acts on is at rest.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.sliding.is_none()
    }

    /// Time, angle, velocity and, under `torque_mnm`, acceleration of what the torque acts on: the cap of a knob with
    /// two bodies.
    #[must_use]
    pub fn motion(&self, torque_mnm: f64) -> Motion {
        let [angle_rad, velocity_rad_s, cap_rad, cap_rad_s] = self.place;
        let [_, acceleration_rad_s2, _, cap_rad_s2] =
            self.equation.rates(self.time_s, &self.place, torque_mnm, self.sliding_from_here().as_ref());
        let time_s = self.time_s;
        if self.equation.has_cap() {
            return Motion { time_s, angle_rad: cap_rad, velocity_rad_s: cap_rad_s, acceleration_rad_s2: cap_rad_s2 };
        }
        let inner = Motion { time_s, angle_rad, velocity_rad_s, acceleration_rad_s2 };
        self.twist.as_ref().map_or(inner, |twist| twist.ahead_of(&inner))
    }

    /// The state, from which another simulation can go on.
    #[must_use]
    pub fn state(&self) -> State {
        let outer = self.motion(0.0);
        State {
            time_s: self.time_s,
            angle_rad: outer.angle_rad,
            velocity_rad_s: outer.velocity_rad_s,
            deflection: self.deflection,
            inner_angle_rad: self.place[0],
            inner_velocity_rad_s: self.place[1],
        }
    }

    /// Moves on by `step_s`, the torque going in a straight line from its value now to its value then, mNm.
    ///
    /// # Errors
    /// [`SimulationError::NotFinite`] when the motion grows beyond all numbers, [`SimulationError::TooStiff`] when it
    /// changes too fast to be followed.
    pub fn advance(&mut self, step_s: f64, torque_now_mnm: f64, torque_then_mnm: f64) -> Result<(), SimulationError> {
        let torque = TorqueLine {
            start_s: self.time_s,
            start_mnm: torque_now_mnm,
            slope_mnm_s: (torque_then_mnm - torque_now_mnm) / step_s,
        };
        let end_s = self.time_s + step_s;
        while end_s - self.time_s > 1e-12 * step_s {
            let next_s = (self.time_s + LONGEST_STEP_S).min(end_s);
            self.advance_through_events(next_s, &torque)?;
        }
        self.time_s = end_s;
        if let Some(twist) = &mut self.twist {
            twist.advance(step_s, torque_now_mnm, torque_then_mnm);
        }
        Ok(())
    }
}
