//! A model as a hypothesis about a capture: its effects with their values, and the columns that these make.

use std::ops::Range;

use dynamics::effects::{self, end_stop};
use dynamics::{Bristles, Direction, Effect, Model, Motion, Part, Regressors, Scene};

use super::capture::Capture;
use super::lobes::Lobes;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;

/// A model while it is looked for.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub(crate) effects: Vec<Effect>,
    /// Leading columns of each effect that take part.
    pub(crate) columns: Vec<usize>,
    /// Time by which the torque channel is late besides what a delay effect says, s: at most a fraction of a sample.
    pub(crate) skew_s: f64,
}

/// A parameter that columns depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Searched {
    /// Parameter of an effect, by their indices.
    Parameter {
        effect: usize,
        parameter: usize,
        /// What it may be; a step never leaves this range.
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
        Self { effects: effects.to_vec(), columns, skew_s: 0.0 }
    }

    /// The structure with one effect more, of which the first `columns` take part; a delay takes the place of the skew.
    pub(crate) fn with(&self, effect: Effect, columns: usize) -> Self {
        let mut more = self.clone();
        if matches!(effect.kind().part, Part::ReadingDelay(_)) {
            more.skew_s = 0.0;
        }
        more.effects.push(effect);
        more.columns.push(columns);
        more
    }

    /// The structure without the effect at an index.
    pub(crate) fn without(&self, index: usize) -> Self {
        let mut less = self.clone();
        less.effects.remove(index);
        less.columns.remove(index);
        less
    }

    pub(crate) fn position(&self, name: &str) -> Option<usize> {
        self.effects.iter().position(|effect| effect.kind().name == name)
    }

    /// Whether there are detents, equal or not.
    pub(crate) fn has_detents(&self) -> bool {
        [&effects::detent::KIND, &effects::unequal_detents::KIND].iter().any(|kind| self.position(kind.name).is_some())
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

    /// Whether torque and motion may be skewed: not where a delay is an effect of its own.
    pub(crate) fn may_be_skewed(&self, capture: &Capture) -> bool {
        let delayed = self.effects.iter().any(|effect| matches!(effect.kind().part, Part::ReadingDelay(_)));
        !delayed && !capture.motion.exact
    }

    pub(crate) fn bristles(&self) -> Option<Bristles> {
        self.model().bristles()
    }

    pub(crate) fn model(&self) -> Model {
        Model { effects: self.effects.clone(), ..Model::default() }
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

    fn widths(&self) -> Vec<usize> {
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
            let parameters = effect.kind().parameters;
            for column in 0..width {
                let is_load = matches!(effect.kind().part, Part::LoadFriction(_));
                signs.push(
                    is_load
                        || regressors(effect).is_some_and(|r| {
                            let direct = r.searched.is_empty() && r.columns == parameters.len();
                            r.nonnegative.contains(&column)
                                || direct && parameters[column].minimum != dynamics::Minimum::None
                        }),
                );
            }
        }
        signs
    }

    /// Number of values that the data had to settle, the skew apart.
    pub(crate) fn freedom(&self) -> usize {
        let searched = |(effect, columns): (&Effect, &usize)| match effect.kind().hypothesis {
            Some(_) => effect.kind().free_searches(*columns).count() - end_stop::absent_sides(effect),
            None => regressors(effect).map_or(0, |r| r.searched.len()),
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

    /// The parameters on which columns depend, with the ranges that a scene leaves them.
    pub(crate) fn searched(&self, scene: &Scene) -> Vec<Searched> {
        let mut all = Vec::new();
        for (index, effect) in self.effects.iter().enumerate() {
            if effect.kind().hypothesis.is_none() {
                // What every fit has is searched near its value.
                for parameter in regressors(effect).map_or(&[][..], |r| r.searched) {
                    let value = effect.values()[*parameter];
                    all.push(Searched::Parameter {
                        effect: index,
                        parameter: *parameter,
                        range: (0.97 * value, 1.03 * value),
                    });
                }
                continue;
            }
            for search in effect.kind().free_searches(self.columns[index]) {
                if let Some(range) = (search.range)(scene) {
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
            for search in other.kind().hypothesis.iter().flat_map(|hypothesis| hypothesis.searched) {
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

    /// Whether the columns of the effect at an index depend on other effects, or on what was before.
    pub(crate) fn depends_on_others(&self, index: usize) -> bool {
        match self.effects[index].kind().part {
            Part::Friction(_) | Part::FrictionTable(_) => self.bristles().is_some(),
            Part::CoulombFactor(_) | Part::FrictionFactor(_) | Part::Bristles(_) | Part::LoadFriction(_) => true,
            _ => false,
        }
    }

    /// Rows of the columns of the effect at an index, in a row filter of a motion.
    pub(crate) fn rows(&self, index: usize, motion: &KnobMotion, row_filter: &RowFilter) -> Vec<Vec<f64>> {
        if self.depends_on_others(index) {
            return self.dependent_rows(index, motion, row_filter);
        }
        row_filter.leading_effect_rows(&self.effects[index], self.columns[index], motion)
    }

    /// The same of an effect that depends on others, or on what was before.
    fn dependent_rows(&self, index: usize, motion: &KnobMotion, row_filter: &RowFilter) -> Vec<Vec<f64>> {
        let effect = &self.effects[index];
        let mut values = vec![0.0; self.widths()[index]];
        let mut each = |row: &dyn Fn(usize, &mut [f64])| {
            row_filter.rows_of(values.len(), |range, columns| {
                for (place, at) in range.enumerate() {
                    if row_filter.mask[at] == 0.0 {
                        values.fill(0.0);
                    } else {
                        row(at, &mut values);
                    }
                    columns.iter_mut().zip(&values).for_each(|(column, value)| column[place] = *value);
                }
            })
        };
        let Some(regressors) = effect.kind().regressors else {
            if let Part::Bristles(bristles) = effect.kind().part {
                let deflections = deflections(bristles(effect.values()), motion);
                return each(&|at, row| row[0] = Bristles::bending_rad_s(deflections[at], motion.velocity_rad_s[at]));
            }
            if let Part::LoadFriction(_) = effect.kind().part {
                let model = self.model();
                return each(&|at, row| {
                    let now = motion.at(at);
                    row[0] = now.velocity_sign() * model.load_mnm(&now).abs();
                });
            }
            return Vec::new();
        };
        let all = |motion: &Motion| filled(effect, regressors, motion);
        match effect.kind().part {
            Part::Friction(_) | Part::FrictionTable(_) => {
                let columns = self.friction_columns(effect, regressors, motion, false);
                each(&columns)
            }
            Part::CoulombFactor(_) | Part::FrictionFactor(_) => {
                let coulomb_only = matches!(effect.kind().part, Part::CoulombFactor(_));
                let friction_mnm = self.friction_mnm(motion, coulomb_only);
                each(&|at, row| {
                    let (friction_mnm, factors) = (friction_mnm(at), all(&motion.at(at)));
                    row.iter_mut().zip(factors).for_each(|(slot, factor)| *slot = friction_mnm * factor);
                })
            }
            _ => Vec::new(),
        }
    }

    /// Rows of the products of a friction's columns with those of a factor on it: for each column of the friction one for each of the
    /// factor.
    pub(crate) fn product_rows(&self, friction: usize, factor: usize, capture: &Capture) -> Vec<Vec<Vec<f64>>> {
        let [effect, by] = [friction, factor].map(|index| &self.effects[index]);
        let (Some(own), Some(others)) = (regressors(effect), regressors(by)) else { return Vec::new() };
        let of_coulomb = matches!(by.kind().part, Part::CoulombFactor(_));
        let columns_at = self.friction_columns(effect, own, &capture.motion, of_coulomb);
        let (width, depth) = (self.columns[friction], self.columns[factor]);
        let mut frictions = vec![0.0; width];
        let rows = capture.row_filter.rows_of(width * depth, |range, columns| {
            for (place, at) in range.enumerate() {
                if capture.row_filter.mask[at] == 0.0 {
                    columns.iter_mut().for_each(|column| column[place] = 0.0);
                    continue;
                }
                columns_at(at, &mut frictions);
                let factors = filled(by, others, &capture.motion.at(at));
                for (columns, friction) in columns.chunks_mut(depth).zip(&frictions) {
                    columns.iter_mut().zip(factors).for_each(|(column, factor)| column[place] = friction * factor);
                }
            }
        });
        rows.chunks(depth).map(<[_]>::to_vec).collect()
    }

    /// Indices of the effects that rub.
    pub(crate) fn frictions(&self) -> Vec<usize> {
        self.indices(|part| matches!(part, Part::Friction(_) | Part::FrictionTable(_)))
    }

    /// Indices of the factors on friction.
    pub(crate) fn factors(&self) -> Vec<usize> {
        self.indices(|part| matches!(part, Part::CoulombFactor(_) | Part::FrictionFactor(_)))
    }

    /// Indices of the effects whose friction is over the load.
    pub(crate) fn load_frictions(&self) -> Vec<usize> {
        self.indices(|part| matches!(part, Part::LoadFriction(_)))
    }

    fn indices(&self, is: impl Fn(Part) -> bool) -> Vec<usize> {
        (0..self.effects.len()).filter(|index| is(self.effects[*index].kind().part)).collect()
    }

    /// Rows of what friction on the load adds to the columns of the effect at an index, a load, by a factor at every sample.
    pub(crate) fn rubbing_rows(&self, index: usize, capture: &Capture, load_factor: &[f64]) -> Vec<Vec<f64>> {
        let effect = &self.effects[index];
        let Some(regressors) = regressors(effect).filter(|_| effect.kind().is_of_the_load()) else {
            return Vec::new();
        };
        capture.row_filter.rows_of(self.columns[index], |range, columns| {
            for (place, at) in range.enumerate() {
                let row = filled(effect, regressors, &capture.motion.at(at));
                columns.iter_mut().zip(row).for_each(|(column, value)| column[place] = load_factor[at] * value);
            }
        })
    }

    /// By how much friction that grows with the load adds to the torques of the load, as a share of them, at every sample; `None` without such
    /// friction.
    pub(crate) fn load_factor(&self, motion: &KnobMotion) -> Option<Vec<f64>> {
        let model = self.model();
        let coefficient = model.load_friction();
        let at = |index: usize| {
            let now = motion.at(index);
            coefficient * now.velocity_sign() * model.load_mnm(&now).signum()
        };
        (coefficient != 0.0).then(|| (0..motion.angle_rad.len()).map(at).collect())
    }

    /// Writes a friction's leading columns at a sample, of all that it makes or of its Coulomb part; with bristles the latter as these bend.
    fn friction_columns<'a>(
        &self,
        effect: &'a Effect,
        regressors: Regressors,
        motion: &'a KnobMotion,
        coulomb_only: bool,
    ) -> impl Fn(usize, &mut [f64]) + use<'a> {
        let deflections = self.bristles().map(|bristles| deflections(bristles, motion));
        move |at: usize, row: &mut [f64]| {
            let now = motion.at(at);
            let mut columns = [0.0; dynamics::MAX_PARAMETERS];
            row.fill(0.0);
            let mut add = |motion: &Motion, by: f64| {
                (regressors.fill)(effect, motion, &mut columns[..regressors.columns]);
                row.iter_mut().zip(&columns).for_each(|(row, column)| *row += by * column);
            };
            let still = slowest(now.velocity_rad_s, &now);
            match deflections.as_ref().map(|deflections| deflections[at]) {
                None => add(if coulomb_only { &still } else { &now }, 1.0),
                Some(bent) => {
                    add(&slowest(bent, &now), bent.abs());
                    if !coulomb_only {
                        add(&now, 1.0);
                        add(&still, -1.0);
                    }
                }
            }
        }
    }

    /// Torque of friction as it is without factors at every sample, mNm.
    pub(crate) fn friction_mnm(&self, motion: &KnobMotion, coulomb_only: bool) -> impl Fn(usize) -> f64 {
        let deflections = self.bristles().map(|bristles| deflections(bristles, motion));
        let is_friction = |effect: &&Effect| matches!(effect.kind().part, Part::Friction(_) | Part::FrictionTable(_));
        let frictions: Vec<&Effect> = self.effects.iter().filter(is_friction).collect();
        let sum = move |motion: &Motion, direction| -> f64 {
            frictions.iter().map(|effect| effect.friction_mnm(motion, direction)).sum()
        };
        move |index: usize| {
            let now = motion.at(index);
            let still = Motion { velocity_rad_s: 0.0, ..now };
            let direction = Direction::of(now.velocity_rad_s);
            match &deflections {
                Some(bent) => {
                    let coulomb = bent[index].abs() * sum(&still, Direction::of(bent[index]));
                    if coulomb_only { coulomb } else { coulomb + sum(&now, direction) - sum(&still, direction) }
                }
                None if now.velocity_rad_s == 0.0 => 0.0,
                None if coulomb_only => sum(&still, direction),
                None => sum(&now, direction),
            }
        }
    }
}

fn regressors(effect: &Effect) -> Option<Regressors> {
    effect.kind().regressors
}

/// An effect's columns at a motion.
fn filled(effect: &Effect, regressors: Regressors, motion: &Motion) -> [f64; dynamics::MAX_PARAMETERS] {
    let mut row = [0.0; dynamics::MAX_PARAMETERS];
    (regressors.fill)(effect, motion, &mut row[..regressors.columns]);
    row
}

/// The motion at the lowest speed with the sign of `sign`.
fn slowest(sign: f64, motion: &Motion) -> Motion {
    Motion { velocity_rad_s: if sign == 0.0 { 0.0 } else { sign.signum() * f64::MIN_POSITIVE }, ..*motion }
}

/// Deflection z of the bristles at every sample; unbent at the start.
fn deflections(bristles: Bristles, motion: &KnobMotion) -> Vec<f64> {
    let angle = &motion.angle_rad;
    let mut deflection = 0.0;
    let mut all = Vec::with_capacity(angle.len());
    all.push(deflection);
    for pair in angle.windows(2) {
        deflection = bristles.bent(deflection, pair[1] - pair[0]);
        all.push(deflection);
    }
    all
}
