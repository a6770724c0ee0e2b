//! The body that has what the model has.

use dynamics::{Direction, Motion};

use super::rendered_model::Forces;

/// What the body's friction does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Contact {
    /// At rest, exactly.
    Stuck,
    /// Broken away, but not yet faster than the stick velocity; until then it cannot stick again.
    BreakingAway(Direction),
    /// Sliding.
    Sliding(Direction),
}

/// What acts on a body over a tick, its friction apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    /// Inertia of the body, mNm·s²/rad.
    pub(super) inertia: f64,
    /// Torque on it if it is at rest at the end of the tick, mNm.
    pub(super) torque_mnm: f64,
    /// Decrease of that torque for each rad/s of the body's velocity at the end of the tick, mNm·s/rad.
    pub(super) yielding: f64,
}

/// Least speed over which the slope of friction is taken, rad/s.
const SLOW_RAD_S: f64 = 1e-3;

/// Inertia under the model's torques, with Karnopp's friction: a speed below the stick velocity ends at rest, and rest
/// ends only when the load passes the stick limits (D. Karnopp, *Computer simulation of stick-slip friction in mechanical
/// dynamic systems*, J. Dyn. Sys. Meas. Control 107, 1985).
#[derive(Clone, Copy, Debug)]
pub(super) struct VirtualBody {
    /// Angle, rad.
    pub(super) angle_rad: f64,
    /// Velocity, rad/s; exactly zero at rest.
    pub(super) velocity_rad_s: f64,
    contact: Contact,
}

impl VirtualBody {
    /// A body at rest.
    pub(super) fn at_rest(angle_rad: f64) -> Self {
        Self { angle_rad, velocity_rad_s: 0.0, contact: Contact::Stuck }
    }

    /// Whether friction holds it.
    pub(super) fn is_stuck(&self) -> bool {
        self.contact == Contact::Stuck
    }

    /// Where torques of the angle are taken over a tick that begins at `time_s`: half way along the path at the present velocity,
    /// so that stiff detents gain no energy from the step.
    pub(super) fn middle(&self, time_s: f64, step_s: f64) -> Motion {
        Motion {
            time_s: time_s + 0.5 * step_s,
            angle_rad: self.angle_rad + 0.5 * step_s * self.velocity_rad_s,
            velocity_rad_s: self.velocity_rad_s,
            acceleration_rad_s2: 0.0,
        }
    }

    /// Advances one tick from `time_s` on under the external torque `drive_mnm`, with torques of the angle taken `given_way_rad`
    /// further; gives its work against detents and springs, mNm·rad.
    pub(super) fn advance(
        &mut self,
        forces: &Forces<'_>,
        drive_mnm: f64,
        given_way_rad: f64,
        time_s: f64,
        step_s: f64,
    ) -> f64 {
        let middle = self.middle(time_s, step_s);
        let middle = Motion { angle_rad: middle.angle_rad + given_way_rad, ..middle };
        let free_mnm = forces.free_mnm(&middle);
        let load = Load { inertia: forces.inertia(), torque_mnm: drive_mnm - free_mnm, yielding: 0.0 };
        let before_rad_s = self.velocity_rad_s;
        *self = self.turned(forces, &middle, &load, step_s);
        let way_rad = 0.5 * step_s * (before_rad_s + self.velocity_rad_s);
        free_mnm * way_rad
    }

    /// The body after a tick under a load.
    ///
    /// Friction is taken at the end of the tick by its slope, so that strong damping gains no energy from the step.
    pub(super) fn turned(&self, forces: &Forces<'_>, middle: &Motion, load: &Load, step_s: f64) -> Self {
        let mut body = *self;
        let limits = forces.stick_limits(&Motion { velocity_rad_s: 0.0, ..*middle });
        let held = (-limits.negative_mnm..=limits.positive_mnm).contains(&load.torque_mnm);
        let mobility = step_s / load.inertia;
        if body.contact == Contact::Stuck {
            if held {
                return body;
            }
            body.contact = Contact::BreakingAway(Direction::of(load.torque_mnm));
        }
        let (Contact::BreakingAway(direction) | Contact::Sliding(direction)) = body.contact else { return body };
        let start_rad_s = body.velocity_rad_s;
        let coming_to_rest =
            matches!(body.contact, Contact::Sliding(_)) && held && start_rad_s.abs() < limits.velocity_rad_s;
        let end_rad_s = if coming_to_rest {
            let braking_mnm = match direction {
                Direction::Negative => -limits.negative_mnm,
                Direction::Positive => limits.positive_mnm,
            };
            (start_rad_s + mobility * (load.torque_mnm - braking_mnm)) / (1.0 + mobility * load.yielding)
        } else {
            let at = |velocity_rad_s: f64| forces.friction_mnm(&Motion { velocity_rad_s, ..*middle }, direction);
            let speed_rad_s = direction.sign() * start_rad_s.abs().max(SLOW_RAD_S);
            let slope = ((at(speed_rad_s) - at(0.0)) / speed_rad_s).max(0.0);
            let friction_mnm = at(start_rad_s);
            (start_rad_s + mobility * (load.torque_mnm - friction_mnm + slope * start_rad_s))
                / (1.0 + mobility * (slope + load.yielding))
        };
        if end_rad_s * direction.sign() <= 0.0 {
            body.contact = Contact::Stuck;
            body.velocity_rad_s = 0.0;
        } else {
            if end_rad_s.abs() >= limits.velocity_rad_s {
                body.contact = Contact::Sliding(direction);
            }
            body.velocity_rad_s = end_rad_s;
        }
        body.angle_rad += 0.5 * step_s * (start_rad_s + body.velocity_rad_s);
        body
    }
}
