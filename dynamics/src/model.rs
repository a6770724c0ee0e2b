//! A model: a named list of effects.

use crate::effects::{backlash, shaft_compliance};
use crate::{Axis, Coordinate, Direction, Effect, Motion, ParameterKind, Part, StickLimits};

/// A knob as numbers: the list of its effects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// What the knob is called.
    pub name: String,
    /// What it is like, or where the numbers come from; may be empty.
    pub description: String,
    /// Whether it is turned; a model of what is pressed or slid has mm where names say rad, and N where they say mNm.
    pub axis: Axis,
    /// The effects that act together.
    pub effects: Vec<Effect>,
}

impl Model {
    /// The effect called `name`, if the model has it.
    #[must_use]
    pub fn effect(&self, name: &str) -> Option<&Effect> {
        self.effects.iter().find(|effect| effect.kind().name == name)
    }

    /// The value of the parameter called `name`, if the model has it.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters().find(|(parameter, _)| parameter.name == name).map(|(_, value)| value)
    }

    /// Every parameter with its value, effect by effect.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static ParameterKind, f64)> + '_ {
        self.effects.iter().flat_map(Effect::parameters)
    }

    /// Torque that the knob takes while it moves as given, mNm.
    ///
    /// At zero velocity friction is left out: there it is whatever holds the knob, up to [`Model::stick_limits`].
    /// Effects with a memory (an inner body, bristles) are taken as if they had none; [`Model::readings_mnm`] includes
    /// the memory.
    #[must_use]
    pub fn torque_mnm(&self, motion: &Motion) -> f64 {
        let friction = if motion.velocity_rad_s == 0.0 {
            0.0
        } else {
            self.friction_mnm(motion, Direction::of(motion.velocity_rad_s))
        };
        self.inertia_at(motion.angle_rad) * motion.acceleration_rad_s2 + self.free_torque_mnm(motion) + friction
    }

    /// Moment of inertia at an angle, mNm·s²/rad: the mean one and what varies.
    #[must_use]
    pub fn inertia_at(&self, angle_rad: f64) -> f64 {
        let varying = self.effects.iter().map(|effect| match effect.kind().part {
            Part::VaryingInertia(inertia) => inertia(effect.values(), angle_rad)[0],
            _ => 0.0,
        });
        self.inertia() + varying.sum::<f64>()
    }

    /// Torque that inertia, detents and springs take: the load on the friction, mNm.
    #[must_use]
    pub fn load_mnm(&self, motion: &Motion) -> f64 {
        self.inertia_at(motion.angle_rad) * motion.acceleration_rad_s2 + self.place_torque_mnm(motion)
    }

    /// Friction over the load.
    #[must_use]
    pub fn load_friction(&self) -> f64 {
        let each = self.effects.iter().map(|effect| match effect.kind().part {
            Part::LoadFriction(coefficient) => coefficient(effect.values()),
            _ => 0.0,
        });
        each.sum()
    }

    /// Moment of inertia, mNm·s²/rad.
    #[must_use]
    pub fn inertia(&self) -> f64 {
        self.effects
            .iter()
            .map(|effect| if let Part::Inertia(inertia) = effect.kind().part { inertia(effect.values()) } else { 0.0 })
            .sum()
    }

    /// This model with `inertia`, mNm·s²/rad, taken off its cap: the knob alone, if this is the model of a knob with its gripper.
    ///
    /// The inner body of a coupling stays the same, so that its share of the remaining inertia is larger.
    #[must_use]
    pub fn without_cap_inertia(&self, inertia: f64) -> Self {
        let left = (self.inertia() - inertia).max(0.0);
        let mut without = self.clone();
        for effect in &mut without.effects {
            if let Part::Inertia(_) = effect.kind().part {
                effect.values_mut()[0] = left;
            }
            if let Part::Coupling(coupling) = effect.kind().part
                && left > 0.0
                && inertia != 0.0
            {
                let inner_share = (coupling(effect.values()).inner_share * self.inertia() / left).min(1.0);
                match std::ptr::eq(effect.kind(), &backlash::KIND) {
                    true => effect.values_mut()[backlash::INNER_SHARE] = inner_share,
                    false => effect.values_mut()[shaft_compliance::OUTER_SHARE] = 1.0 - inner_share,
                }
            }
        }
        without
    }

    /// Torque that depends on neither acceleration nor the direction of sliding (detents, drag), mNm.
    #[must_use]
    pub fn free_torque_mnm(&self, motion: &Motion) -> f64 {
        self.effects.iter().map(|effect| effect.free_torque_mnm(motion)).sum()
    }

    /// The part of [`Model::free_torque_mnm`] that depends on velocity alone: drag, mNm.
    #[must_use]
    pub fn drag_mnm(&self, motion: &Motion) -> f64 {
        let drags = self.effects.iter().filter(|effect| effect.kind().depends_only_on(Coordinate::Velocity));
        drags.map(|effect| effect.free_torque_mnm(motion)).sum()
    }

    /// The rest of [`Model::free_torque_mnm`]: detents, springs, stops, mNm.
    #[must_use]
    pub fn place_torque_mnm(&self, motion: &Motion) -> f64 {
        let others = self.effects.iter().filter(|effect| !effect.kind().depends_only_on(Coordinate::Velocity));
        others.map(|effect| effect.free_torque_mnm(motion)).sum()
    }

    /// Torque of friction while sliding in `direction`, mNm.
    #[must_use]
    pub fn friction_mnm(&self, motion: &Motion, direction: Direction) -> f64 {
        let sum_mnm = |motion: &Motion| {
            let each = self.effects.iter().map(|effect| effect.friction_mnm(motion, direction));
            each.fold(0.0, |sum, friction_mnm| sum + friction_mnm)
        };
        let coulomb_mnm = || sum_mnm(&Motion { velocity_rad_s: 0.0, ..*motion });
        FrictionChange::of(&self.effects, self, motion).applied_mnm(sum_mnm(motion), coulomb_mnm, direction)
    }

    /// What a knob at rest bears: Karnopp's limits, but at least the friction with which it begins to slide.
    ///
    /// If it bore less, the friction of sliding would stop it as soon as it broke away.
    #[must_use]
    pub fn stick_limits(&self, motion: &Motion) -> StickLimits {
        let still = Motion { velocity_rad_s: 0.0, ..*motion };
        let levels_mnm = [Direction::Negative, Direction::Positive].map(|to| self.friction_mnm(&still, to));
        self.karnopp_limits().at_least(levels_mnm)
    }

    /// Karnopp's limits alone; zero without them.
    pub(crate) fn karnopp_limits(&self) -> StickLimits {
        let limits = self.effects.iter().find_map(|effect| match effect.kind().part {
            Part::Stick(limits) => Some(limits(effect.values())),
            _ => None,
        });
        limits.unwrap_or_default()
    }
}

impl StickLimits {
    /// The same, but at least the friction with which the knob begins to slide negatively and positively, mNm.
    pub(crate) fn at_least(self, sliding_mnm: [f64; 2]) -> Self {
        Self {
            negative_mnm: self.negative_mnm.max(-sliding_mnm[0]),
            positive_mnm: self.positive_mnm.max(sliding_mnm[1]),
            ..self
        }
    }
}

/// Solves load + μ·|load| = `both_mnm` for the load of a sliding body, mNm. μ, `signed_load_friction`, is friction over the load with the
/// sign of the direction.
pub(crate) fn balanced_load_mnm(both_mnm: f64, signed_load_friction: f64) -> f64 {
    both_mnm / (1.0 + signed_load_friction * both_mnm.signum())
}

/// Change that some effects make to the friction of others at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrictionChange {
    /// Relative change of all friction.
    of_all: f64,
    /// Relative change of the Coulomb friction.
    of_coulomb: f64,
    /// Friction of the load, a magnitude, mNm.
    of_load_mnm: f64,
}

impl FrictionChange {
    /// By these effects of a model.
    pub(crate) fn of<'a>(effects: impl IntoIterator<Item = &'a Effect>, model: &Model, motion: &Motion) -> Self {
        let (mut of_all, mut of_coulomb, mut load_friction) = (0.0, 0.0, 0.0);
        for effect in effects {
            match effect.kind().part {
                Part::FrictionFactor(change) => of_all += change(effect.values(), motion),
                Part::CoulombFactor(change) => of_coulomb += change(effect.values(), motion),
                Part::LoadFriction(coefficient) => load_friction += coefficient(effect.values()),
                _ => {}
            }
        }
        let of_load_mnm = if load_friction == 0.0 { 0.0 } else { load_friction * model.load_mnm(motion).abs() };
        Self { of_all, of_coulomb, of_load_mnm }
    }

    /// The changed friction while sliding in `direction`, mNm, from the unchanged friction and its Coulomb part.
    pub(crate) fn applied_mnm(self, sliding_mnm: f64, coulomb_mnm: impl FnOnce() -> f64, direction: Direction) -> f64 {
        let friction_mnm = (1.0 + self.of_all) * sliding_mnm + direction.sign() * self.of_load_mnm;
        if self.of_coulomb == 0.0 { friction_mnm } else { friction_mnm + self.of_coulomb * coulomb_mnm() }
    }
}
