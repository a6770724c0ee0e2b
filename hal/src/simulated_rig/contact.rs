//! Dry friction: what holds a body at rest and what brakes it while it slides.

use dynamics::{Direction, Model, Motion, StickLimits};

/// State of a dry contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Contact {
    /// At rest, exactly.
    Stuck,
    /// Broken away, but not yet faster than the stick velocity; until then it cannot stick again.
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
    /// Friction that is taken at the mean velocity over the substep, mNm·s/rad.
    pub(super) drag: f64,
}

impl<F: Friction> Braked<F> {
    pub(super) fn new(contact: Contact, friction: F) -> Self {
        let mut braked = Self { contact, friction, braking_mnm: 0.0, drag: 0.0 };
        braked.enter(contact);
        braked
    }

    fn enter(&mut self, contact: Contact) {
        self.contact = contact;
        let sliding = contact.direction().map(|direction| self.friction.sliding(direction));
        Sliding { braking_mnm: self.braking_mnm, drag: self.drag } = sliding.unwrap_or_default();
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
        self.enter(contact);
        true
    }
}

/// Friction over a substep: a part known beforehand, and a damper on the mean velocity over it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sliding {
    /// Torque, with its sign, mNm.
    pub(super) braking_mnm: f64,
    /// Damper, mNm·s/rad.
    pub(super) drag: f64,
}

/// The torques of a dry contact over one substep.
pub(super) trait Friction {
    /// Friction while sliding in `direction`.
    fn sliding(&self, direction: Direction) -> Sliding;
    /// What the contact bears at rest: never less than it takes to keep it sliding slowly.
    fn limits(&self) -> StickLimits;
}

/// Least speed over which the slope of friction is taken, rad/s.
const SLOW_RAD_S: f64 = 1e-3;

/// The knob's friction at one moment.
pub(super) struct KnobFriction<'a> {
    pub(super) knob: &'a Model,
    pub(super) motion: Motion,
    /// Speed beyond which friction does not drive.
    pub(super) coast_speed_rad_s: f64,
    /// Whether friction that grows with speed is taken at the mean velocity over the substep: a light body needs it.
    pub(super) light: bool,
}

impl Friction for KnobFriction<'_> {
    fn sliding(&self, direction: Direction) -> Sliding {
        let sliding_mnm = self.sliding_mnm(direction);
        if !self.light {
            return Sliding { braking_mnm: sliding_mnm, drag: 0.0 };
        }
        let speed_rad_s = self.motion.velocity_rad_s.abs().clamp(SLOW_RAD_S, self.coast_speed_rad_s.max(SLOW_RAD_S));
        let at = |velocity_rad_s: f64| {
            self.knob.friction_mnm(&Motion { velocity_rad_s, ..self.motion }, direction) * direction.sign()
        };
        let drag = ((at(direction.sign() * speed_rad_s) - at(0.0)) / speed_rad_s).max(0.0);
        Sliding { braking_mnm: sliding_mnm - drag * self.motion.velocity_rad_s, drag }
    }

    fn limits(&self) -> StickLimits {
        let limits = self.knob.stick_limits(&self.still());
        let (negative_mnm, positive_mnm) = self.at_rest_mnm();
        StickLimits {
            negative_mnm: limits.negative_mnm.max(-negative_mnm).max(0.0),
            positive_mnm: limits.positive_mnm.max(positive_mnm).max(0.0),
            ..limits
        }
    }
}

impl KnobFriction<'_> {
    /// The model's friction as it is, also where a negative viscous coefficient makes it drive.
    ///
    /// A fitted law says nothing about speeds that the rig must not reach: from there on it is
    /// kept from driving, so that a loose knob coasts and does not run away.
    pub(super) fn sliding_mnm(&self, direction: Direction) -> f64 {
        let Self { knob, motion, coast_speed_rad_s, light: _ } = self;
        let speed_rad_s = motion.velocity_rad_s.abs();
        if speed_rad_s <= *coast_speed_rad_s {
            return knob.friction_mnm(motion, direction);
        }
        let slower = Motion { velocity_rad_s: coast_speed_rad_s * direction.sign(), ..*motion };
        direction.sign() * (direction.sign() * knob.friction_mnm(&slower, direction)).max(0.0)
    }

    fn still(&self) -> Motion {
        Motion { velocity_rad_s: 0.0, acceleration_rad_s2: 0.0, ..self.motion }
    }

    /// Torques that keep the knob sliding ever so slowly, negatively and positively, with their signs, mNm.
    pub(super) fn at_rest_mnm(&self) -> (f64, f64) {
        let still = self.still();
        (self.knob.friction_mnm(&still, Direction::Negative), self.knob.friction_mnm(&still, Direction::Positive))
    }
}

/// The motor's friction at one moment.
pub(super) struct MotorFriction {
    pub(super) coulomb_mnm: f64,
    pub(super) viscous_mnm: f64,
}

impl Friction for MotorFriction {
    fn sliding(&self, direction: Direction) -> Sliding {
        Sliding { braking_mnm: direction.sign() * self.coulomb_mnm + self.viscous_mnm, drag: 0.0 }
    }

    fn limits(&self) -> StickLimits {
        StickLimits { negative_mnm: self.coulomb_mnm, positive_mnm: self.coulomb_mnm, velocity_rad_s: 0.0 }
    }
}
