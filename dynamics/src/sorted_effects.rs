//! A model's effects sorted by what they do, for a simulation that asks them at every sample.

use crate::model::FrictionChange;
use crate::{Coordinate, Direction, Effect, Model, Motion, Part};

/// The effects of a model that act on its inner body, grouped by what they do.
#[derive(Debug)]
pub(crate) struct SortedEffects<'model> {
    model: &'model Model,
    /// Torques that depend on neither acceleration nor the direction of sliding.
    free: Vec<&'model Effect>,
    /// Whether the inertia depends on the angle.
    varies: bool,
    /// Friction over the load.
    pub(crate) load_friction: f64,
    /// Friction effects, each with its friction at the lowest speed in either direction if that depends on neither place nor time.
    rubbing: Vec<(&'model Effect, Option<[f64; 2]>)>,
    /// Effects that change the friction of others.
    changing: Vec<&'model Effect>,
    /// Whether that change depends on the velocity.
    changes_with_velocity: bool,
}

/// Friction on a body, mNm.
pub(crate) struct Friction {
    /// At the lowest speed in the negative and the positive direction.
    pub(crate) level_mnm: [f64; 2],
    /// While it turns as given.
    pub(crate) sliding_mnm: f64,
}

impl<'model> SortedEffects<'model> {
    pub(crate) fn of(model: &'model Model) -> Self {
        let is_free = |part| matches!(part, Part::Torque(_) | Part::TorqueTable(_) | Part::VaryingInertia(_));
        let rubs = |part| matches!(part, Part::Friction(_) | Part::FrictionTable(_));
        let changes = |part| matches!(part, Part::FrictionFactor(_) | Part::CoulombFactor(_) | Part::LoadFriction(_));
        let with = |is: &dyn Fn(Part) -> bool| -> Vec<&'model Effect> {
            model.effects.iter().filter(|effect| is(effect.kind().part)).collect()
        };
        let level = |effect: &Effect| {
            effect.kind().depends_only_on(Coordinate::Velocity).then(|| levels_mnm(effect, &Motion::default()))
        };
        let of_velocity = |effect: &&Effect| {
            effect.kind().depends_on.iter().any(|of| matches!(of, Coordinate::Velocity | Coordinate::Load))
        };
        let changing = with(&changes);
        Self {
            model,
            varies: !with(&|part| matches!(part, Part::VaryingInertia(_))).is_empty(),
            load_friction: model.load_friction(),
            free: with(&is_free),
            rubbing: with(&rubs).into_iter().map(|effect| (effect, level(effect))).collect(),
            changes_with_velocity: changing.iter().any(of_velocity),
            changing,
        }
    }

    /// As [`Model::free_torque_mnm`].
    #[inline]
    pub(crate) fn free_torque_mnm(&self, motion: &Motion) -> f64 {
        self.free.iter().map(|effect| effect.free_torque_mnm(motion)).sum()
    }

    /// By how much the inertia at an angle differs from the mean one, mNm·s²/rad.
    #[inline]
    pub(crate) fn further_inertia(&self, angle_rad: f64) -> f64 {
        if self.varies { self.model.inertia_at(angle_rad) - self.model.inertia() } else { 0.0 }
    }

    /// As [`Model::place_torque_mnm`] if friction depends on the load, else zero.
    #[inline]
    pub(crate) fn rubbing_place_torque_mnm(&self, motion: &Motion) -> f64 {
        if self.load_friction == 0.0 { 0.0 } else { self.model.place_torque_mnm(motion) }
    }

    /// [`Model::friction_mnm`] at the place and time of `turning`: at the lowest speed in both directions, and while turning in `direction`.
    #[inline]
    pub(crate) fn friction(&self, turning: &Motion, direction: Direction) -> Friction {
        let still = Motion { velocity_rad_s: 0.0, ..*turning };
        let mut level_mnm = [0.0; 2];
        let mut sliding_mnm = 0.0;
        for (effect, levels) in &self.rubbing {
            let [negative_mnm, positive_mnm] = levels.unwrap_or_else(|| levels_mnm(effect, &still));
            level_mnm[0] += negative_mnm;
            level_mnm[1] += positive_mnm;
            sliding_mnm += effect.friction_mnm(turning, direction);
        }
        if self.changing.is_empty() {
            return Friction { level_mnm, sliding_mnm };
        }
        let change = |motion| FrictionChange::of(self.changing.iter().copied(), self.model, motion);
        let while_still = change(&still);
        let while_turning = if self.changes_with_velocity { change(turning) } else { while_still };
        let [negative_mnm, positive_mnm] = level_mnm;
        let sliding_mnm = while_turning.applied_mnm(sliding_mnm, || level_mnm[direction as usize], direction);
        let level_mnm = [
            while_still.applied_mnm(negative_mnm, || negative_mnm, Direction::Negative),
            while_still.applied_mnm(positive_mnm, || positive_mnm, Direction::Positive),
        ];
        Friction { level_mnm, sliding_mnm }
    }
}

/// Friction in either direction, mNm.
fn levels_mnm(effect: &Effect, still: &Motion) -> [f64; 2] {
    [effect.friction_mnm(still, Direction::Negative), effect.friction_mnm(still, Direction::Positive)]
}
