//! Two bodies in one knob: a cap that the sensor turns and an inner body that friction and detents act on.

use crate::{Direction, Model, Motion};

/// Substeps per sample, at least.
const SUBSTEPS: f64 = 2.0;
/// Largest phase that the coupling's resonance may turn in one substep, rad.
const PHASE: f64 = 0.25;

/// What joins the cap to the inner body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Half of the angle in which the bodies do not touch, rad; zero for a shaft that merely twists.
    pub half_gap_rad: f64,
    /// Share of the knob's inertia that is inside.
    pub inner_share: f64,
    /// Stiffness of shaft or contact, mNm/rad.
    pub stiffness_mnm_rad: f64,
    /// Damping of shaft or contact, mNm·s/rad.
    pub damping: f64,
}

impl Coupling {
    /// Torque that the cap passes on to the inner body, `ahead_rad` in front of it and faster by `faster_rad_s`.
    #[must_use]
    pub fn torque_mnm(&self, ahead_rad: f64, faster_rad_s: f64) -> f64 {
        let beyond_rad = ahead_rad - ahead_rad.clamp(-self.half_gap_rad, self.half_gap_rad);
        if beyond_rad == 0.0 && self.half_gap_rad > 0.0 {
            return 0.0;
        }
        let torque_mnm = self.stiffness_mnm_rad * beyond_rad + self.damping * faster_rad_s;
        // A contact pushes and does not pull.
        if self.half_gap_rad > 0.0 && torque_mnm * beyond_rad < 0.0 { 0.0 } else { torque_mnm }
    }
}

/// The inner body of a knob whose cap moves as it was measured.
///
/// Implicit midpoint rule for coupling and inertia, dry friction as a constraint on the velocity at the end of a substep
/// (J. J. Moreau, *Unilateral contact and dry friction in finite freedom dynamics*, CISM 302, 1988): the body comes
/// to rest exactly and stays there.
#[derive(Debug)]
pub struct InnerBody<'model> {
    knob: &'model Model,
    coupling: Coupling,
    inertia: f64,
    angle_rad: f64,
    velocity_rad_s: f64,
}

impl<'model> InnerBody<'model> {
    /// An inner body at rest in the middle of its gap under a cap at `angle_rad`.
    ///
    /// `knob` gives inertia, friction and detents; its own coupling is not looked at.
    #[must_use]
    pub fn at_rest(knob: &'model Model, coupling: Coupling, angle_rad: f64) -> Self {
        let inertia = (knob.inertia() * coupling.inner_share).max(f64::MIN_POSITIVE);
        Self { knob, coupling, inertia, angle_rad, velocity_rad_s: 0.0 }
    }

    /// Torque on the cap now, mNm.
    #[must_use]
    pub fn torque_mnm(&self, cap: &Motion) -> f64 {
        self.coupling.torque_mnm(cap.angle_rad - self.angle_rad, cap.velocity_rad_s - self.velocity_rad_s)
    }

    /// Angle of the inner body, rad.
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Velocity of the inner body, rad/s.
    #[must_use]
    pub fn velocity_rad_s(&self) -> f64 {
        self.velocity_rad_s
    }

    /// Number of substeps that a sample takes.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number; `as` saturates")]
    fn substeps(&self, sample_s: f64) -> u32 {
        let turns = (self.coupling.stiffness_mnm_rad / self.inertia).sqrt() * sample_s;
        (turns / PHASE).ceil().clamp(SUBSTEPS, 16.0) as u32
    }

    /// Moves on to the next sample, the cap going there evenly accelerated.
    pub fn advance(&mut self, from: &Motion, to: &Motion) {
        let sample_s = to.time_s - from.time_s;
        let substeps = self.substeps(sample_s);
        let step_s = sample_s / f64::from(substeps);
        let between = |share: f64| Motion {
            time_s: from.time_s + share * sample_s,
            angle_rad: from.angle_rad + share * (to.angle_rad - from.angle_rad),
            velocity_rad_s: from.velocity_rad_s + share * (to.velocity_rad_s - from.velocity_rad_s),
            acceleration_rad_s2: 0.0,
        };
        for index in 0..substeps {
            let cap = between(f64::from(index) / f64::from(substeps));
            let middle = between((f64::from(index) + 0.5) / f64::from(substeps));
            self.substep(step_s, cap.angle_rad, &middle);
        }
    }

    fn substep(&mut self, step_s: f64, cap_rad: f64, middle: &Motion) {
        let Coupling { half_gap_rad, stiffness_mnm_rad, damping, .. } = self.coupling;
        let velocity = self.velocity_rad_s;
        let ahead_rad = cap_rad - self.angle_rad;
        let beyond_rad = ahead_rad - ahead_rad.clamp(-half_gap_rad, half_gap_rad);
        let touching = half_gap_rad == 0.0 || beyond_rad != 0.0;
        let pulls = half_gap_rad > 0.0
            && (stiffness_mnm_rad * beyond_rad + damping * (middle.velocity_rad_s - velocity)) * beyond_rad < 0.0;
        let implicit = if touching && !pulls { stiffness_mnm_rad * step_s / 2.0 + damping } else { 0.0 };
        let spring_mnm = if implicit > 0.0 { stiffness_mnm_rad * beyond_rad } else { 0.0 };
        let inner = Motion {
            time_s: middle.time_s,
            angle_rad: self.angle_rad + 0.5 * step_s * velocity,
            velocity_rad_s: velocity,
            acceleration_rad_s2: 0.0,
        };
        let driving_mnm =
            spring_mnm + implicit * (middle.velocity_rad_s - 0.5 * velocity) - self.knob.free_torque_mnm(&inner);
        let mass = self.inertia + 0.5 * step_s * implicit;
        let frictionless = (self.inertia * velocity + step_s * driving_mnm) / mass;
        let direction = Direction::of(frictionless);
        // The velocity at which friction acts must have the direction that it opposes.
        let sliding = Motion { velocity_rad_s: if velocity * frictionless > 0.0 { velocity } else { 0.0 }, ..inner };
        let braked = frictionless - step_s * self.knob.friction_mnm(&sliding, direction) / mass;
        let end = if braked * frictionless > 0.0 { braked } else { 0.0 };
        self.angle_rad += 0.5 * step_s * (velocity + end);
        self.velocity_rad_s = end;
    }
}
