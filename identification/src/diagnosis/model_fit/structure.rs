//! A model as a hypothesis about a capture: its effects with their values, and which of these are free.

use std::ops::Range;

use dynamics::effects::{self, end_stop};
use dynamics::{Bristles, Effect, Model, Part, Scene};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::lobes::Lobes;
use crate::diagnosis::model_fit::twist;

/// Share by which the searched values of the base effects may move.
const NEAR: f64 = 0.03;

/// A model while it is looked for.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub(crate) effects: Vec<Effect>,
    /// Leading columns of each effect that take part.
    pub(crate) columns: Vec<usize>,
    /// Time by which the torque channel is late besides what a delay effect says, s: at most a fraction of a sample.
    pub(crate) skew_s: f64,
    /// Whether such a time may be there.
    pub(crate) may_be_skewed: bool,
    /// Whether the body behind a shaft that twists is simulated: there it may stick while the cap moves.
    pub(crate) shaft_is_simulated: bool,
}

/// A parameter that columns depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Searched {
    /// Parameter of an effect, by their indices.
    Parameter {
        effect: usize,
        parameter: usize,
        /// Least and largest value; a step never leaves this range.
        range: (f64, f64),
    },
    /// The skew.
    Skew,
}

impl Searched {
    pub(crate) fn is(self, of: usize, which: usize) -> bool {
        matches!(self, Self::Parameter { effect, parameter, .. } if effect == of && parameter == which)
    }

    pub(crate) fn is_of(self, of: usize) -> bool {
        matches!(self, Self::Parameter { effect, .. } if effect == of)
    }
}

impl Structure {
    pub(crate) fn new(effects: &[Effect]) -> Self {
        let columns = effects.iter().map(Effect::columns).collect();
        Self { effects: effects.to_vec(), columns, skew_s: 0.0, may_be_skewed: true, shaft_is_simulated: false }
    }

    /// The structure with one effect more, of which the first `columns` take part; a delay takes the place of the skew.
    pub(crate) fn with(&self, effect: Effect, columns: usize) -> Self {
        let more = self.with_at(self.effects.len(), effect, columns);
        if matches!(effect.kind().part, Part::ReadingDelay(_)) { Self { skew_s: 0.0, ..more } } else { more }
    }

    /// The structure with one effect more at an index.
    pub(crate) fn with_at(&self, index: usize, effect: Effect, columns: usize) -> Self {
        let mut more = self.clone();
        more.effects.insert(index, effect);
        more.columns.insert(index, columns);
        more
    }

    pub(crate) fn without(&self, index: usize) -> Self {
        let mut less = self.clone();
        less.effects.remove(index);
        less.columns.remove(index);
        less
    }

    pub(crate) fn position(&self, name: &str) -> Option<usize> {
        self.effects.iter().position(|effect| effect.kind().name == name)
    }

    pub(crate) fn has_detents(&self) -> bool {
        [&effects::detent::KIND, &effects::unequal_detents::KIND].iter().any(|kind| self.position(kind.name).is_some())
    }

    /// The structure without the effects at these indices.
    pub(crate) fn without_all(&self, indices: &[usize]) -> Self {
        indices.iter().rev().fold(self.clone(), |less, index| less.without(*index))
    }

    /// Puts other detents in the place of the equal ones that there are.
    pub(crate) fn put_detent(&mut self, detent: Effect) {
        let places = self.effects.iter_mut().filter(|effect| std::ptr::eq(effect.kind(), detent.kind()));
        places.for_each(|place| *place = detent);
    }

    /// Value of a parameter, by its name.
    pub(crate) fn parameter(&self, name: &str) -> Option<f64> {
        self.effects.iter().flat_map(Effect::parameters).find(|(kind, _)| kind.name == name).map(|(_, value)| value)
    }

    pub(crate) fn inertia(&self) -> f64 {
        self.model().inertia()
    }

    pub(crate) fn delay_s(&self) -> f64 {
        self.skew_s + self.model().reading_delay_s()
    }

    /// Whether a skew is fitted: not where a delay is an effect of its own.
    pub(crate) fn has_free_skew(&self, capture: &Capture) -> bool {
        let delayed = self.effects.iter().any(|effect| matches!(effect.kind().part, Part::ReadingDelay(_)));
        self.may_be_skewed && !delayed && !capture.motion.exact
    }

    pub(crate) fn without_skew(&self) -> Self {
        Self { skew_s: 0.0, may_be_skewed: false, ..self.clone() }
    }

    pub(crate) fn bristles(&self) -> Option<Bristles> {
        self.model().bristles()
    }

    pub(crate) fn model(&self) -> Model {
        Model { effects: self.effects.clone(), ..Model::default() }
    }

    /// Whether an inner body is simulated.
    pub(crate) fn is_simulated(&self) -> bool {
        self.is_coupled() && twist::of(self).is_none()
    }

    pub(crate) fn is_coupled(&self) -> bool {
        self.effects.iter().any(|effect| matches!(effect.kind().part, Part::Coupling(_)))
    }

    /// Range of each effect's columns among all.
    pub(crate) fn ranges(&self) -> Vec<Range<usize>> {
        let mut start = 0;
        let range = |width: usize| {
            start += width;
            start - width..start
        };
        self.widths().into_iter().map(range).collect()
    }

    pub(crate) fn widths(&self) -> Vec<usize> {
        let width = |(effect, columns): (&Effect, &usize)| match effect.kind().part {
            Part::Bristles(_) | Part::LoadFriction(_) => 1,
            _ => *columns,
        };
        self.effects.iter().zip(&self.columns).map(width).collect()
    }

    /// Which coefficients cannot be negative.
    pub(crate) fn nonnegative(&self) -> Vec<bool> {
        let mut signs = Vec::new();
        for (effect, width) in self.effects.iter().zip(self.widths()) {
            let kind = effect.kind();
            let is_load = matches!(kind.part, Part::LoadFriction(_));
            signs.extend((0..width).map(|column| is_load || kind.is_nonnegative(column)));
        }
        signs
    }

    /// Number of values fitted to the data, not counting the skew.
    pub(crate) fn freedom(&self) -> usize {
        let searched = |(effect, columns): (&Effect, &usize)| match effect.kind().hypothesis {
            Some(_) => effect.free_searches(*columns).count() - end_stop::absent_sides(effect),
            None => effect.kind().regressors.map_or(0, |r| r.searched.len()),
        };
        // One limit for both directions is tried.
        let limits = usize::from(self.is_coupled() && self.sticks());
        // A measured table has its points' torques and no scale of its own.
        let of_table = |effect: &Effect| match (Lobes::of(effect), effect.table()) {
            (Some(lobes), _) => 2 * lobes.units() - 1,
            (None, table) => table.map_or(0, |table| table.points().len() - 1),
        };
        // A stop that is not there has neither a place nor a stiffness.
        let stiffnesses = |effect: &Effect, width: usize| width - end_stop::absent_sides(effect).min(width);
        let each = |(of, width): ((&Effect, &usize), usize)| stiffnesses(of.0, width) + searched(of) + of_table(of.0);
        limits + self.effects.iter().zip(&self.columns).zip(self.widths()).map(each).sum::<usize>()
    }

    /// Writes fitted coefficients into the effects' values.
    pub(crate) fn take(&mut self, coefficients: &[f64]) {
        for (index, range) in self.ranges().into_iter().enumerate() {
            let effect = &mut self.effects[index];
            if let Some(regressors) = effect.kind().regressors {
                let mut all = vec![0.0; regressors.columns];
                all[..range.len()].copy_from_slice(&coefficients[range]);
                (regressors.values)(&all, effect.values_mut());
            } else if let Some(coefficient) = coefficients.get(range.start) {
                match effect.kind().part {
                    Part::Bristles(_) => effect.values_mut()[1] = *coefficient,
                    Part::LoadFriction(_) => effect.values_mut()[0] = *coefficient,
                    _ => {}
                }
            }
        }
    }

    /// The nonlinear parameters of the columns, with the ranges in which a capture's scene lets them be searched.
    pub(crate) fn searched(&self, scene: &Scene) -> Vec<Searched> {
        let mut all = Vec::new();
        for (index, effect) in self.effects.iter().enumerate() {
            if effect.kind().hypothesis.is_none() {
                // The base model's parameters are searched near their values.
                for parameter in effect.kind().regressors.map_or(&[][..], |r| r.searched) {
                    let value = effect.values()[*parameter];
                    let reach = NEAR * value.abs();
                    let range = (value - reach, value + reach);
                    all.push(Searched::Parameter { effect: index, parameter: *parameter, range });
                }
                continue;
            }
            for search in effect.free_searches(self.columns[index]) {
                if let Some(range) = search.range_in(scene) {
                    all.push(Searched::Parameter { effect: index, parameter: search.parameter, range });
                }
            }
        }
        all
    }

    /// Sets a searched parameter, and all that are always equal to it.
    pub(crate) fn set(&mut self, searched: Searched, value: f64) {
        let Searched::Parameter { effect, parameter, .. } = searched else {
            self.skew_s = value;
            return;
        };
        self.effects[effect].values_mut()[parameter] = value;
        let name = self.effects[effect].kind().parameters[parameter].name;
        for other in &mut self.effects {
            for search in other.kind().searches() {
                if search.same_as == Some(name) {
                    other.values_mut()[search.parameter] = value;
                }
            }
        }
    }

    pub(crate) fn get(&self, searched: Searched) -> f64 {
        match searched {
            Searched::Parameter { effect, parameter, .. } => self.effects[effect].values()[parameter],
            Searched::Skew => self.skew_s,
        }
    }

    pub(crate) fn frictions(&self) -> Vec<usize> {
        self.indices(|part| matches!(part, Part::Friction(_) | Part::FrictionTable(_)))
    }

    pub(crate) fn factors(&self) -> Vec<usize> {
        self.indices(Part::changes_friction)
    }

    /// Indices of the effects that are friction in proportion to the load.
    pub(crate) fn load_frictions(&self) -> Vec<usize> {
        self.indices(|part| matches!(part, Part::LoadFriction(_)))
    }

    fn indices(&self, is: impl Fn(Part) -> bool) -> Vec<usize> {
        (0..self.effects.len()).filter(|index| is(self.effects[*index].kind().part)).collect()
    }
}
