//! A model's effects sorted by what they do, for a simulation that asks them at every sample.

use crate::model::FrictionChange;
use crate::{Coordinate, Direction, Effect, Model, Motion, Part};

/// A model's effects, those apart that act on its inner body.
#[derive(Debug)]
pub(crate) struct SortedEffects<'model> {
    model: &'model Model,
    /// Torques that depend on neither acceleration nor the direction of sliding.
    free: Vec<&'model Effect>,
    /// Effects that rub, with what they do at the lowest speed where that is the same everywhere.
    rubbing: Vec<(&'model Effect, Option<[f64; 2]>)>,
    /// Whether any effect changes what others rub.
    friction_changes: bool,
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
            let levels =
                [Direction::Negative, Direction::Positive].map(|to| effect.friction_mnm(&Motion::default(), to));
            effect.kind().depends_only_on(Coordinate::Velocity).then_some(levels)
        };
        let of_velocity = |effect: &&Effect| {
            effect.kind().depends_on.iter().any(|of| matches!(of, Coordinate::Velocity | Coordinate::Load))
        };
        let changing = with(&changes);
        Self {
            model,
            free: with(&is_free),
            rubbing: with(&rubs).into_iter().map(|effect| (effect, level(effect))).collect(),
            friction_changes: !changing.is_empty(),
            changes_with_velocity: changing.iter().any(of_velocity),
        }
    }

    /// As [`Model::free_torque_mnm`].
    #[inline]
    pub(crate) fn free_torque_mnm(&self, motion: &Motion) -> f64 {
        self.free.iter().map(|effect| effect.free_torque_mnm(motion)).sum()
    }

    /// As [`Model::friction_mnm`]: at a place and time at rest in both directions, and turning as given in `direction`.
    #[inline]
    pub(crate) fn friction(&self, turning: &Motion, direction: Direction) -> Friction {
        let still = Motion { velocity_rad_s: 0.0, ..*turning };
        let mut level_mnm = [0.0; 2];
        let mut sliding_mnm = 0.0;
        for (effect, levels) in &self.rubbing {
            let levels = levels.unwrap_or_else(|| {
                [Direction::Negative, Direction::Positive].map(|to| effect.friction_mnm(&still, to))
            });
            level_mnm[0] += levels[0];
            level_mnm[1] += levels[1];
            sliding_mnm += effect.friction_mnm(turning, direction);
        }
        if !self.friction_changes {
            return Friction { level_mnm, sliding_mnm };
        }
        let change = FrictionChange::of(self.model, &still);
        let while_turning = if self.changes_with_velocity { FrictionChange::of(self.model, turning) } else { change };
        Friction {
            level_mnm: [Direction::Negative, Direction::Positive].map(|to| {
                let level_mnm = level_mnm[to as usize];
                change.applied_mnm(level_mnm, || level_mnm, to)
            }),
            sliding_mnm: while_turning.applied_mnm(sliding_mnm, || level_mnm[direction as usize], direction),
        }
    }
}
