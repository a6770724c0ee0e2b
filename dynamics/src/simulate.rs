//! Forward simulation: the motion of a knob under a given torque, with true stick and slip.
//!
//! Between events the equation of motion M·θ̈ = τ − free(θ, θ̇, t) − friction(θ, θ̇, direction) is
//! smooth and integrated by the classical fourth-order Runge–Kutta method. Events are located to
//! rounding: the velocity falling through Karnopp's Δv or through zero, and the load on a resting
//! knob passing D₋ or D₊. The result therefore does not depend on the step size, and a knob at
//! rest does not creep.

use crate::{Direction, Model, Motion, StickLimits};

/// Longest Runge–Kutta step, s: a fraction of the shortest time constant of any knob (0.4 ms, B/M of knob 5).
const LONGEST_STEP_S: f64 = 50e-6;
/// Bisections of a step to locate an event: 2⁻⁴⁰ of it.
const BISECTIONS: u32 = 40;
/// Events in one Runge–Kutta step beyond which the knob is taken to be at rest.
const MOST_EVENTS: u32 = 16;

/// Why a model cannot be simulated forward.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// Without inertia a torque has no definite motion.
    #[error("forward simulation needs an inertia above zero, and the model with its gripper has {inertia} mNm s²/rad")]
    NoInertia {
        /// Inertia of model and gripper, mNm·s²/rad.
        inertia: f64,
    },
    /// The motion grew beyond all numbers.
    #[error("the simulated motion is not finite after {time_s} s; the model is unstable under this torque")]
    NotFinite {
        /// Time at which it was found, s.
        time_s: f64,
    },
}

/// A knob in motion.
#[derive(Clone, Debug)]
pub struct ForwardSimulation<'model> {
    model: &'model Model,
    inertia: f64,
    time_s: f64,
    angle_rad: f64,
    velocity_rad_s: f64,
    /// `None` while the knob is stuck.
    sliding: Option<Direction>,
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
    /// [`SimulationError::NoInertia`] when nothing has inertia.
    pub fn at_rest(model: &'model Model, added_inertia: f64, angle_rad: f64) -> Result<Self, SimulationError> {
        let inertia = model.inertia() + added_inertia;
        if inertia > 0.0 && inertia.is_finite() {
            Ok(Self { model, inertia, time_s: 0.0, angle_rad, velocity_rad_s: 0.0, sliding: None })
        } else {
            Err(SimulationError::NoInertia { inertia })
        }
    }

    /// Whether the knob is stuck.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.sliding.is_none()
    }

    /// Time, angle, velocity and, under `torque_mnm`, acceleration.
    #[must_use]
    pub fn motion(&self, torque_mnm: f64) -> Motion {
        Motion {
            time_s: self.time_s,
            angle_rad: self.angle_rad,
            velocity_rad_s: self.velocity_rad_s,
            acceleration_rad_s2: self.sliding.map_or(0.0, |direction| {
                self.acceleration(self.angle_rad, self.velocity_rad_s, self.time_s, torque_mnm, direction)
            }),
        }
    }

    /// Moves on by `step_s`, the torque going in a straight line from its value now to its value then, mNm.
    ///
    /// # Errors
    /// [`SimulationError::NotFinite`] when the motion grows beyond all numbers.
    pub fn advance(&mut self, step_s: f64, torque_now_mnm: f64, torque_then_mnm: f64) -> Result<(), SimulationError> {
        let torque = TorqueLine {
            start_s: self.time_s,
            start_mnm: torque_now_mnm,
            slope_mnm_s: (torque_then_mnm - torque_now_mnm) / step_s,
        };
        let end_s = self.time_s + step_s;
        while end_s - self.time_s > 1e-12 * step_s {
            let next_s = (self.time_s + LONGEST_STEP_S).min(end_s);
            self.advance_between_events(next_s, &torque);
        }
        self.time_s = end_s;
        if self.angle_rad.is_finite() && self.velocity_rad_s.is_finite() {
            Ok(())
        } else {
            Err(SimulationError::NotFinite { time_s: self.time_s })
        }
    }

    /// Moves on to `end_s`, at most one Runge–Kutta step away, through however many events lie between.
    fn advance_between_events(&mut self, end_s: f64, torque: &TorqueLine) {
        for _ in 0..MOST_EVENTS {
            if self.time_s >= end_s {
                return;
            }
            match self.sliding {
                None => self.wait_for_breakaway(end_s, torque),
                Some(direction) => self.slide(end_s, torque, direction),
            }
        }
        // Chattering between slip and stick within one short step: it rests until the step's end.
        self.come_to_rest();
        self.time_s = end_s;
    }

    /// Stays at rest until the load passes a threshold or `end_s` comes.
    fn wait_for_breakaway(&mut self, end_s: f64, torque: &TorqueLine) {
        let limits = self.limits();
        if self.breakaway(self.time_s, torque, &limits).is_some() {
            self.sliding = self.breakaway(self.time_s, torque, &limits);
        } else if self.breakaway(end_s, torque, &limits).is_some() {
            self.time_s = bisect(self.time_s, end_s, |time| self.breakaway(time, torque, &limits).is_some());
            self.sliding = self.breakaway(self.time_s, torque, &limits);
        } else {
            self.time_s = end_s;
        }
    }

    /// Slides until the knob sticks, turns round, or `end_s` comes.
    fn slide(&mut self, end_s: f64, torque: &TorqueLine, direction: Direction) {
        let limits = self.limits();
        let threshold = limits.velocity_rad_s;
        let speed = direction.sign() * self.velocity_rad_s;
        let reached = |time: f64| self.runge_kutta(time, torque, direction);
        let speed_at = |time: f64| direction.sign() * reached(time).1;
        let end_speed = speed_at(end_s);

        if speed > threshold && end_speed <= threshold && threshold > 0.0 {
            let time = bisect(self.time_s, end_s, |time| speed_at(time) <= threshold);
            (self.angle_rad, self.velocity_rad_s) = reached(time);
            self.time_s = time;
            if self.breakaway(time, torque, &self.limits()).is_none() {
                self.come_to_rest();
            } else {
                // The load is too large to stick: it goes on through, from just below the threshold.
                self.velocity_rad_s = direction.sign() * threshold * (1.0 - 1e-9);
            }
        } else if end_speed < 0.0 {
            let time = bisect(self.time_s, end_s, |time| speed_at(time) < 0.0);
            (self.angle_rad, _) = reached(time);
            self.time_s = time;
            self.come_to_rest();
        } else {
            (self.angle_rad, self.velocity_rad_s) = reached(end_s);
            self.time_s = end_s;
        }
    }

    fn come_to_rest(&mut self) {
        self.velocity_rad_s = 0.0;
        self.sliding = None;
    }

    fn limits(&self) -> StickLimits {
        self.model.stick_limits(&Motion { time_s: self.time_s, angle_rad: self.angle_rad, ..Motion::default() })
    }

    /// The direction in which a knob at rest breaks away at `time_s`, if it does.
    fn breakaway(&self, time_s: f64, torque: &TorqueLine, limits: &StickLimits) -> Option<Direction> {
        let still = Motion { time_s, angle_rad: self.angle_rad, ..Motion::default() };
        let load = torque.at(time_s) - self.model.free_torque_mnm(&still);
        if load > limits.positive_mnm {
            Some(Direction::Positive)
        } else if load < -limits.negative_mnm {
            Some(Direction::Negative)
        } else {
            None
        }
    }

    fn acceleration(&self, angle: f64, velocity: f64, time_s: f64, torque_mnm: f64, direction: Direction) -> f64 {
        let motion = Motion { time_s, angle_rad: angle, velocity_rad_s: velocity, acceleration_rad_s2: 0.0 };
        let resisting = self.model.free_torque_mnm(&motion) + self.model.friction_mnm(&motion, direction);
        (torque_mnm - resisting) / self.inertia
    }

    /// Angle and velocity at `end_s` by one Runge–Kutta step, friction keeping its direction.
    fn runge_kutta(&self, end_s: f64, torque: &TorqueLine, direction: Direction) -> (f64, f64) {
        let step = end_s - self.time_s;
        let slope = |fraction: f64, angle: f64, velocity: f64| {
            let time = self.time_s + fraction * step;
            (velocity, self.acceleration(angle, velocity, time, torque.at(time), direction))
        };
        let (angle, velocity) = (self.angle_rad, self.velocity_rad_s);
        let k1 = slope(0.0, angle, velocity);
        let k2 = slope(0.5, angle + 0.5 * step * k1.0, velocity + 0.5 * step * k1.1);
        let k3 = slope(0.5, angle + 0.5 * step * k2.0, velocity + 0.5 * step * k2.1);
        let k4 = slope(1.0, angle + step * k3.0, velocity + step * k3.1);
        (
            angle + step / 6.0 * (k1.0 + 2.0 * (k2.0 + k3.0) + k4.0),
            velocity + step / 6.0 * (k1.1 + 2.0 * (k2.1 + k3.1) + k4.1),
        )
    }
}

/// The latest time found at which `passed` holds while it did not before, between a start where it
/// does not hold and an end where it does.
fn bisect(start: f64, end: f64, passed: impl Fn(f64) -> bool) -> f64 {
    let (mut before, mut after) = (start, end);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + after);
        if passed(middle) {
            after = middle;
        } else {
            before = middle;
        }
    }
    after
}
