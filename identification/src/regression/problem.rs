//! The separable problem: coefficients are linear, the few searched parameters follow by Gauss–Newton.

use std::sync::Arc;

use dynamics::{Effect, Part, effects};
use nalgebra::{DMatrix, DVector};

use super::gram::{COLLINEAR, Correction};
use super::least_squares::LeastSquares;
use super::refiner::{self, Ended, longest_improving};
use crate::numerics::derivative::{GRADIENT_REACH, gradient};
use crate::numerics::vector::{self, dot};
use crate::preparation::band::Band;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::{self, RowFilter};
use crate::preparation::sensor_noise::SensorNoise;

/// Relative change of a searched parameter for its column by differences.
const DIFFERENCE: f64 = 1e-6;
/// A step is not taken if it would lower the sum of squares by no more than this multiple of the residual's mean square: it is then
/// shorter than a hundredth of the parameter's standard deviation.
const SETTLED: f64 = 1e-4;

/// One column of rows, shared by all that look at it.
pub(crate) type Column = Arc<[f64]>;

/// Rows of torque and of every effect's columns.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    pub(crate) row_filter: &'a RowFilter,
    pub(crate) motion: &'a KnobMotion,
    pub(crate) target: Column,
    pub(crate) effects: Vec<Effect>,
    /// Rows of the linear columns, effect by effect.
    pub(crate) columns: Vec<Column>,
    /// Inner products of the columns.
    products: DMatrix<f64>,
    /// Rows of θ·sin(θ/P) and θ·cos(θ/P) for the detents at the index given, from which the derivative by P follows.
    detent_slopes: Option<(usize, [Column; 2])>,
    /// Which coefficients stay at or above zero.
    pub(crate) nonnegative: Vec<bool>,
    pub(crate) noise: SensorNoise,
    /// Columns whose coefficient is an inertia.
    inertial: Vec<usize>,
}

/// A searched parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Searched {
    pub(crate) effect: usize,
    pub(crate) parameter: usize,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        row_filter: &'a RowFilter,
        motion: &'a KnobMotion,
        band: &Band,
        torque_mnm: &[f64],
        effects: &[Effect],
    ) -> Self {
        let mut problem = Self {
            row_filter,
            motion,
            target: row_filter.rows(torque_mnm).into(),
            effects: Vec::new(),
            columns: Vec::new(),
            products: DMatrix::zeros(0, 0),
            detent_slopes: None,
            nonnegative: Vec::new(),
            noise: SensorNoise::of(row_filter, motion, band),
            inertial: Vec::new(),
        };
        effects.iter().for_each(|effect| problem.add(*effect));
        problem
    }

    /// Adds an effect's columns.
    pub(crate) fn add(&mut self, effect: Effect) {
        let first = self.columns.len();
        let rows = self.effect_rows(self.effects.len(), &effect);
        if matches!(effect.kind().part, Part::Inertia(_)) {
            self.inertial.extend(first..first + rows.len());
        }
        for (index, column) in rows.into_iter().enumerate() {
            self.columns.push(column);
            self.nonnegative.push(effect.kind().is_nonnegative(index));
        }
        self.effects.push(effect);
        self.update_products(first);
    }

    /// Rows of the columns of the effect that is, or will be, at `index`.
    fn effect_rows(&mut self, index: usize, effect: &Effect) -> Vec<Column> {
        if effect.kind().name != effects::detent::KIND.name {
            return self.row_filter.effect_rows(effect, self.motion).into_iter().map(Column::from).collect();
        }
        let rows = self.row_filter.rows_of(4, |range, columns| {
            let (sines, slopes) = columns.split_at_mut(2);
            row_filter::fill(effect, self.motion, |_| true, range.clone(), sines);
            for (slope, sine) in slopes.iter_mut().zip(sines) {
                let angles = &self.motion.angle_rad[range.clone()];
                slope.iter_mut().zip(sine).zip(angles).for_each(|((slope, sine), angle)| *slope = *sine * angle);
            }
        });
        let mut rows: Vec<Column> = rows.into_iter().map(Column::from).collect();
        let slopes = [rows.remove(2), rows.remove(2)];
        self.detent_slopes = Some((index, slopes));
        rows
    }

    /// Computes the inner products of the columns from `first` on again.
    fn update_products(&mut self, first: usize) {
        let count = self.columns.len();
        self.products.resize_mut(count, count, 0.0);
        vector::products(&self.columns, first, &mut self.products);
    }

    pub(crate) fn solve(&self) -> LeastSquares {
        let Self { columns, products, target, nonnegative, .. } = self;
        LeastSquares::of_products(columns, products, target, nonnegative, &self.column_noise(), COLLINEAR)
    }

    /// Corrections that subtract the columns' noise from their products.
    pub(crate) fn column_noise(&self) -> Vec<Correction> {
        let SensorNoise { acceleration_squares, acceleration_torque, .. } = self.noise;
        self.inertial
            .iter()
            .map(|column| Correction { column: *column, square: -acceleration_squares, product: -acceleration_torque })
            .collect()
    }

    /// Solves with further columns, whose coefficients are free.
    pub(crate) fn solve_with(&self, more: &[Column]) -> (Vec<Column>, LeastSquares) {
        let columns: Vec<Column> = self.columns.iter().chain(more).cloned().collect();
        let mut nonnegative = self.nonnegative.clone();
        nonnegative.resize(columns.len(), false);
        let mut products = self.products.clone().resize(columns.len(), columns.len(), 0.0);
        vector::products(&columns, self.columns.len(), &mut products);
        let noise = self.column_noise();
        let solution = LeastSquares::of_products(&columns, &products, &self.target, &nonnegative, &noise, COLLINEAR);
        (columns, solution)
    }

    /// The searched parameters of all effects.
    pub(crate) fn searched(&self) -> Vec<Searched> {
        let of = |effect: usize| {
            let regressors = self.effects[effect].kind().regressors;
            regressors
                .map_or(&[][..], |r| r.searched)
                .iter()
                .map(move |parameter| Searched { effect, parameter: *parameter })
        };
        (0..self.effects.len()).flat_map(of).collect()
    }

    /// Range of an effect's coefficients among all.
    pub(crate) fn range(&self, effect: usize) -> std::ops::Range<usize> {
        let width = |effect: &Effect| effect.kind().regressors.map_or(0, |r| r.columns);
        let start = self.effects[..effect].iter().map(width).sum();
        start..start + width(&self.effects[effect])
    }

    /// The derivatives of the model's torque by the searched parameters, in rows.
    pub(crate) fn tangents(&self, coefficients: &[f64]) -> Vec<Column> {
        self.searched().iter().map(|which| self.tangent(*which, coefficients)).collect()
    }

    fn tangent(&self, searched: Searched, coefficients: &[f64]) -> Column {
        let coefficients = &coefficients[self.range(searched.effect)];
        if let (Some((effect, [sine, cosine])), [of_sine, of_cosine]) = (&self.detent_slopes, coefficients)
            && *effect == searched.effect
        {
            // d/dP of a·sin(θ/P) + b·cos(θ/P) is −θ/P²·(a·cos(θ/P) − b·sin(θ/P)).
            let scale = -self.value(searched).powi(-2);
            return sine.iter().zip(&**cosine).map(|(s, c)| scale * (of_sine * c - of_cosine * s)).collect();
        }
        let step = self.value(searched).abs().max(f64::MIN_POSITIVE) * DIFFERENCE;
        let moved = |shift: f64| {
            let mut effect = self.effects[searched.effect];
            effect.values_mut()[searched.parameter] += shift;
            self.row_filter.effect_rows(&effect, self.motion)
        };
        let mut tangent = vec![0.0; self.target.len()];
        for ((above, below), coefficient) in moved(step).iter().zip(&moved(-step)).zip(coefficients) {
            for ((slot, above), below) in tangent.iter_mut().zip(above).zip(below) {
                *slot += coefficient * (above - below) / (2.0 * step);
            }
        }
        tangent.into()
    }

    pub(crate) fn value(&self, searched: Searched) -> f64 {
        self.effects[searched.effect].values()[searched.parameter]
    }

    fn set(&mut self, searched: Searched, value: f64) {
        self.effects[searched.effect].values_mut()[searched.parameter] = value;
        let range = self.range(searched.effect);
        let effect = self.effects[searched.effect];
        let rows = self.effect_rows(searched.effect, &effect);
        self.columns.splice(range.clone(), rows);
        self.update_products(range.start);
    }

    /// Improves the searched parameters by at most `rounds` Gauss–Newton steps, none of them longer than `limit` of
    /// the parameter; returns the solution there.
    pub(crate) fn refine(&mut self, rounds: usize, limit: impl Fn(Searched, f64) -> f64) -> LeastSquares {
        let solution = self.solve();
        self.refine_from(solution, rounds, limit).0
    }

    /// [`Problem::refine`] from the solution that [`Problem::solve`] gives where the searched parameters are; returns why it ended too.
    pub(crate) fn refine_from(
        &mut self,
        mut solution: LeastSquares,
        rounds: usize,
        limit: impl Fn(Searched, f64) -> f64,
    ) -> (LeastSquares, Ended) {
        let searched = self.searched();
        if searched.is_empty() {
            return (solution, Ended::Settled);
        }
        let rows = self.target.len() as f64;
        let ended = refiner::refine(rounds, 0.0, solution.squares(), |before| {
            let (full, gain) = self.gauss_newton(&solution).ok_or(Ended::NoStepImproves)?;
            let start: Vec<f64> = searched.iter().map(|which| self.value(*which)).collect();
            let steps: Vec<f64> = searched
                .iter()
                .zip(full.iter())
                .zip(&start)
                .map(|((which, step), value)| step.clamp(-limit(*which, *value), limit(*which, *value)))
                .collect();
            if gain * rows <= SETTLED * before {
                return Err(Ended::Settled);
            }
            let better = longest_improving(0.25, |share| {
                for ((which, step), value) in searched.iter().zip(&steps).zip(&start) {
                    self.set(*which, value + share * step);
                }
                let trial = self.solve();
                let after = trial.squares();
                (after < before).then_some((trial, after))
            });
            if better.is_err() {
                searched.iter().zip(&start).for_each(|(which, value)| self.set(*which, *value));
            }
            let (trial, after) = better?;
            solution = trial;
            Ok(after)
        });
        (solution, ended)
    }

    /// The Gauss–Newton step of the searched parameters, all coefficients moving along, and what it would take off the
    /// sum of squares.
    fn gauss_newton(&self, solution: &LeastSquares) -> Option<(DVector<f64>, f64)> {
        let tangents = self.tangents(&solution.coefficients);
        let slope = vector::products_with(&tangents, &solution.residual);
        let cross = DMatrix::from_fn(self.columns.len(), tangents.len(), |row, column| {
            dot(&self.columns[row], &tangents[column])
        });
        let mut curvature = vector::gram(&tangents);
        // The part of the tangents that the columns explain is taken off.
        curvature -= cross.transpose() * &solution.inverse * &cross;
        let step = curvature.cholesky()?.solve(&slope);
        let gain = step.dot(&slope);
        Some((step, gain))
    }

    /// Range of the friction's coefficients among all: Coulomb friction, then viscous, of the negative direction first.
    pub(crate) fn friction(&self) -> Option<std::ops::Range<usize>> {
        let friction = self.effects.iter().position(|effect| effect.kind().name == effects::friction::KIND.name)?;
        Some(self.range(friction))
    }

    /// Where the columns of the Coulomb friction are, of the negative direction first, and their sum: that of a friction alike in both.
    pub(crate) fn both_ways(&self) -> Option<([usize; 2], Column)> {
        let friction = self.friction()?;
        let places = [0, 1].map(|place| friction.start + place);
        let [negative, positive] = places.map(|place| &self.columns[place]);
        Some((places, negative.iter().zip(&**positive).map(|(one, other)| one + other).collect()))
    }

    /// Rows of minus the model torque's derivative by time: its coefficient is the torque's delay in seconds.
    pub(crate) fn delay_column(&self, coefficients: &[f64]) -> Column {
        let velocity = &self.motion.velocity_rad_s;
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut rows = self.row_filter.rows_of(1, |range, rates| {
            let around = range.start.saturating_sub(GRADIENT_REACH)..(range.end + GRADIENT_REACH).min(velocity.len());
            let mut model = vec![0.0; around.len()];
            for (index, effect) in self.effects.iter().enumerate() {
                let coefficients = &coefficients[self.range(index)];
                columns.resize_with(coefficients.len(), Vec::new);
                columns.iter_mut().for_each(|column| column.resize(around.len(), 0.0));
                row_filter::fill(effect, self.motion, |_| true, around.clone(), &mut columns);
                for (column, coefficient) in columns.iter().zip(coefficients) {
                    model.iter_mut().zip(column).for_each(|(sum, value)| *sum += coefficient * value);
                }
            }
            let rate = gradient(&model, -self.row_filter.rate_hz);
            rates[0].copy_from_slice(&rate[range.start - around.start..][..range.len()]);
            // Friction jumps where the velocity changes sign; no delay is to be read from that.
            for (slot, index) in rates[0].iter_mut().zip(range) {
                let jumps = index > 0 && index + 1 < velocity.len() && velocity[index - 1] * velocity[index + 1] <= 0.0;
                *slot = if jumps { 0.0 } else { *slot };
            }
        });
        rows.remove(0).into()
    }
}
