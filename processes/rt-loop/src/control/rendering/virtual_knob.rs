//! The virtual knob: one body, or a cap that the hand turns and an inner body behind lost motion or a shaft.

use super::joint::Joint;
use super::rendered_model::Forces;
use super::virtual_body::{Load, VirtualBody};

/// Most times that a tick is done again because the bodies met or parted in it.
const CORRECTIONS: u32 = 3;
/// Speed from which a cap has all of the motor's friction taken off, rad/s.
const MOVING_RAD_S: f64 = 0.01;

/// The moving bodies of a model: inner body and cap, which are one in a knob of one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct VirtualKnob {
    /// What friction, stick and detents act on.
    inner: VirtualBody,
    /// What the rotor is held to: angle, rad, and velocity, rad/s.
    cap_rad: f64,
    cap_rad_s: f64,
    /// What joins them; `None` while they are one.
    joint: Option<Joint>,
}

impl VirtualKnob {
    /// A knob at rest, the inner body in the middle of its gap.
    pub(super) fn at_rest(angle_rad: f64) -> Self {
        Self { inner: VirtualBody::at_rest(angle_rad), cap_rad: angle_rad, cap_rad_s: 0.0, joint: None }
    }

    /// Angle of what the hand turns, rad.
    pub(super) fn angle_rad(&self) -> f64 {
        self.cap_rad
    }

    /// Angle of what friction and detents act on, rad.
    pub(super) fn inner_angle_rad(&self) -> f64 {
        self.inner.angle_rad
    }

    /// Velocity of what the hand turns, rad/s.
    pub(super) fn velocity_rad_s(&self) -> f64 {
        self.cap_rad_s
    }

    /// Whether friction holds what it acts on.
    pub(super) fn is_stuck(&self) -> bool {
        self.inner.is_stuck()
    }

    /// Share of the motor's own friction that is taken off, with the sign of the motion: none while the knob is held.
    ///
    /// A cap never comes to rest exactly: below [`MOVING_RAD_S`] its share is proportional to its speed.
    pub(super) fn sliding(&self) -> f64 {
        let Some(joint) = &self.joint else { return direction(self.cap_rad_s) };
        let touching = (self.cap_rad - self.inner.angle_rad).abs() >= joint.half_gap_rad;
        if touching && self.is_stuck() { 0.0 } else { (self.cap_rad_s / MOVING_RAD_S).clamp(-1.0, 1.0) }
    }

    /// Moves on by the way that the rotor went unheld: a sticking body stays where it is, and a cap moves as far as its gap permits.
    pub(super) fn carry_on(&mut self, way_rad: f64) {
        let before_rad = self.cap_rad - self.inner.angle_rad;
        let half_gap_rad = self.joint.map_or(0.0, |joint| joint.half_gap_rad);
        let [least_rad, most_rad] = [before_rad.min(-half_gap_rad), before_rad.max(half_gap_rad)];
        let ahead_rad = (before_rad + way_rad).clamp(least_rad, most_rad);
        if self.is_stuck() {
            self.cap_rad = self.inner.angle_rad + ahead_rad;
        } else {
            self.cap_rad += way_rad;
            self.inner.angle_rad = self.cap_rad - ahead_rad;
        }
    }

    /// One tick from `time_s` on under `drive_mnm` on the cap; gives the work against detents and springs, mNm·rad.
    ///
    /// In a knob of one body detents and springs act `given_way_rad` further on, where the rotor is; behind a joint they do not.
    pub(super) fn advance(
        &mut self,
        forces: &Forces<'_>,
        drive_mnm: f64,
        given_way_rad: f64,
        time_s: f64,
        step_s: f64,
    ) -> f64 {
        self.joint = forces.joint();
        let Some(joint) = self.joint else {
            // The deflection that remains of a joint that became rigid is below the encoder's resolution.
            self.inner.angle_rad = self.cap_rad;
            let work = self.inner.advance(forces, drive_mnm, given_way_rad, time_s, step_s);
            (self.cap_rad, self.cap_rad_s) = (self.inner.angle_rad, self.inner.velocity_rad_s);
            return work;
        };
        let middle = self.inner.middle(time_s, step_s);
        let free_mnm = forces.free_mnm(&middle);
        let ahead_rad = self.cap_rad - self.inner.angle_rad;
        let faster_rad_s = self.cap_rad_s - self.inner.velocity_rad_s;
        let mut touch = joint.touch(ahead_rad, step_s);
        let mut corrections = 0;
        let (inner, cap_rad, cap_rad_s) = loop {
            let passed = joint.passed(touch, ahead_rad, faster_rad_s, step_s);
            // Solving the cap's equation for its end velocity leaves an equation in the inner body's velocity alone.
            let mass = joint.cap_inertia + step_s * passed.firmness;
            let momentum = joint.cap_inertia * self.cap_rad_s + step_s * (drive_mnm - passed.torque_mnm);
            let load = Load {
                inertia: joint.inner_inertia,
                torque_mnm: passed.torque_mnm + passed.firmness * momentum / mass - free_mnm,
                yielding: passed.firmness * joint.cap_inertia / mass,
            };
            let inner = self.inner.turned(forces, &middle, &load, step_s);
            let cap_rad_s = (momentum + step_s * passed.firmness * inner.velocity_rad_s) / mass;
            let cap_rad = self.cap_rad + 0.5 * step_s * (self.cap_rad_s + cap_rad_s);
            let torque_mnm = passed.torque_mnm + passed.firmness * (cap_rad_s - inner.velocity_rad_s);
            match joint.otherwise(touch, torque_mnm, [ahead_rad, cap_rad - inner.angle_rad]) {
                Some(other) if corrections < CORRECTIONS => touch = other,
                _ => break (inner, cap_rad, cap_rad_s),
            }
            corrections += 1;
        };
        let way_rad = inner.angle_rad - self.inner.angle_rad;
        (self.inner, self.cap_rad, self.cap_rad_s) = (inner, cap_rad, cap_rad_s);
        free_mnm * way_rad
    }

    /// Energy that it keeps beyond the rotor's kinetic one, mNm·rad.
    pub(super) fn kept(&self, forces: &Forces<'_>, motor_inertia: f64) -> f64 {
        let Some(joint) = &self.joint else {
            return 0.5 * (forces.inertia() - motor_inertia) * self.cap_rad_s.powi(2);
        };
        0.5 * (joint.cap_inertia - motor_inertia) * self.cap_rad_s.powi(2)
            + 0.5 * joint.inner_inertia * self.inner.velocity_rad_s.powi(2)
            + joint.held(self.cap_rad - self.inner.angle_rad)
    }
}

/// −1, 0 or +1.
fn direction(velocity_rad_s: f64) -> f64 {
    if velocity_rad_s == 0.0 { 0.0 } else { velocity_rad_s.signum() }
}
