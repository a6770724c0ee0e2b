//! Dry friction: what holds a body at rest and what brakes it while it slides.

use dynamics::{Direction, Model, Motion, StickLimits};

/// State of a dry contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Contact {
    /// At rest, exactly.
    Stuck,
    /// Torn loose, not yet faster than the stick velocity: it cannot stick again before it was.
    BreakingAway(Direction),
    /// Sliding.
    Sliding(Direction),
}

impl Contact {
    pub(super) fn direction(self) -> Option<Direction> {
        match self {
            Self::Stuck => None,
            Self::BreakingAway(direction) | Self::Sliding(direction) => Some(direction),
        }
    }

    /// The state at the end of a substep that ends with `velocity_rad_s`.
    pub(super) fn settled(self, velocity_rad_s: f64, stick_velocity_rad_s: f64) -> Self {
        match self {
            Self::BreakingAway(direction) if velocity_rad_s.abs() >= stick_velocity_rad_s => Self::Sliding(direction),
            other => other,
        }
    }
}

/// One side's dry contact during a substep.
pub(super) struct Braked<F> {
    pub(super) contact: Contact,
    pub(super) friction: F,
    /// Torque of friction while the contact slides, zero while it is stuck: then it is a constraint, mNm.
    pub(super) braking_mnm: f64,
}

impl<F: Friction> Braked<F> {
    pub(super) fn new(contact: Contact, friction: F) -> Self {
        let braking_mnm = contact.direction().map_or(0.0, |direction| friction.sliding_mnm(direction));
        Self { contact, friction, braking_mnm }
    }

    pub(super) fn at_rest(&self) -> bool {
        self.contact == Contact::Stuck
    }

    /// Corrects the state if a substep in it ends with a velocity against its direction, or if at
    /// rest the contact would have to hold more than it can; says whether it did.
    pub(super) fn correct(&mut self, velocity_rad_s: f64, holding_mnm: f64) -> bool {
        let corrected = match self.contact.direction() {
            Some(direction) => (velocity_rad_s * direction.sign() <= 0.0).then_some(Contact::Stuck),
            None => {
                let limits = self.friction.limits();
                if holding_mnm > limits.positive_mnm {
                    Some(Contact::BreakingAway(Direction::Positive))
                } else if holding_mnm < -limits.negative_mnm {
                    Some(Contact::BreakingAway(Direction::Negative))
                } else {
                    None
                }
            }
        };
        let Some(contact) = corrected else { return false };
        self.contact = contact;
        self.braking_mnm = contact.direction().map_or(0.0, |direction| self.friction.sliding_mnm(direction));
        true
    }
}

/// The torques of a dry contact over one substep.
pub(super) trait Friction {
    /// Torque while sliding in `direction`, with its sign, mNm.
    fn sliding_mnm(&self, direction: Direction) -> f64;
    /// What the contact bears at rest: never less than it takes to keep it sliding slowly.
    fn limits(&self) -> StickLimits;
}

/// The knob's friction at one moment.
pub(super) struct KnobFriction<'a> {
    pub(super) knob: &'a Model,
    pub(super) motion: Motion,
    /// Speed beyond which friction does not drive.
    pub(super) coast_speed_rad_s: f64,
}

impl Friction for KnobFriction<'_> {
    /// The model's friction as it is, also where a negative viscous coefficient makes it drive.
    ///
    /// A fitted law says nothing about speeds that the rig must not reach: from there on it is
    /// kept from driving, so that a loose knob coasts and does not run away.
    fn sliding_mnm(&self, direction: Direction) -> f64 {
        let Self { knob, motion, coast_speed_rad_s } = self;
        let speed_rad_s = motion.velocity_rad_s.abs();
        if speed_rad_s <= *coast_speed_rad_s {
            return knob.friction_mnm(motion, direction);
        }
        let slower = Motion { velocity_rad_s: coast_speed_rad_s * direction.sign(), ..*motion };
        direction.sign() * (direction.sign() * knob.friction_mnm(&slower, direction)).max(0.0)
    }

    fn limits(&self) -> StickLimits {
        let still = Motion { velocity_rad_s: 0.0, acceleration_rad_s2: 0.0, ..self.motion };
        let limits = self.knob.stick_limits(&still);
        StickLimits {
            negative_mnm: limits.negative_mnm.max(-self.knob.friction_mnm(&still, Direction::Negative)).max(0.0),
            positive_mnm: limits.positive_mnm.max(self.knob.friction_mnm(&still, Direction::Positive)).max(0.0),
            ..limits
        }
    }
}

/// The motor's friction at one moment.
pub(super) struct MotorFriction {
    pub(super) coulomb_mnm: f64,
    pub(super) viscous_mnm: f64,
}

impl Friction for MotorFriction {
    fn sliding_mnm(&self, direction: Direction) -> f64 {
        direction.sign() * self.coulomb_mnm + self.viscous_mnm
    }

    fn limits(&self) -> StickLimits {
        StickLimits { negative_mnm: self.coulomb_mnm, positive_mnm: self.coulomb_mnm, velocity_rad_s: 0.0 }
    }
}
