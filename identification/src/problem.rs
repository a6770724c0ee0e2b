//! The separable problem: coefficients are linear, the few searched parameters follow by Gauss–Newton.

use dynamics::{Effect, Minimum, Part};

use crate::frame::{self, Frame};
use crate::least_squares::{ColumnNoise, LeastSquares, dot};
use crate::motion::{Band, KnobMotion};
use crate::sensor_noise::SensorNoise;

/// Relative change of a searched parameter for its column by differences.
const DIFFERENCE: f64 = 1e-6;
/// A step that would take off less than this share of the sum of squares is not worth taking.
const SETTLED: f64 = 1e-9;

/// Rows of torque and of every effect's columns.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) motion: &'a KnobMotion,
    pub(crate) target: Vec<f64>,
    pub(crate) effects: Vec<Effect>,
    /// Rows of the linear columns, effect by effect.
    pub(crate) columns: Vec<Vec<f64>>,
    nonnegative: Vec<bool>,
    noise: SensorNoise,
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
        frame: &'a Frame,
        motion: &'a KnobMotion,
        band: &Band,
        torque_mnm: &[f64],
        effects: &[Effect],
    ) -> Self {
        let mut problem = Self {
            frame,
            motion,
            target: frame.rows(torque_mnm),
            effects: Vec::new(),
            columns: Vec::new(),
            nonnegative: Vec::new(),
            noise: SensorNoise::of(frame, motion, band),
            inertial: Vec::new(),
        };
        effects.iter().for_each(|effect| problem.add(*effect));
        problem
    }

    /// Adds an effect's columns.
    pub(crate) fn add(&mut self, effect: Effect) {
        let full = frame::columns(&effect, self.motion);
        let parameters = effect.kind().parameters;
        // Where every coefficient is a parameter, the parameter's bound is the coefficient's.
        let direct = effect.kind().regressors.is_some_and(|r| r.searched.is_empty() && r.columns == parameters.len());
        if matches!(effect.kind().part, Part::Inertia(_)) {
            self.inertial.extend(self.columns.len()..self.columns.len() + full.len());
        }
        for (index, column) in full.iter().enumerate() {
            self.columns.push(self.frame.rows(column));
            self.nonnegative.push(direct && parameters[index].minimum != Minimum::None);
        }
        self.effects.push(effect);
    }

    pub(crate) fn solve(&self) -> LeastSquares {
        LeastSquares::solve_noisy(&self.columns, &self.target, &self.nonnegative, &self.column_noise())
    }

    fn column_noise(&self) -> Vec<ColumnNoise> {
        let SensorNoise { acceleration_squares, acceleration_torque } = self.noise;
        self.inertial
            .iter()
            .map(|column| ColumnNoise { column: *column, square: acceleration_squares, product: acceleration_torque })
            .collect()
    }

    /// Solves with further columns, whose coefficients are free.
    pub(crate) fn solve_with(&self, more: &[Vec<f64>]) -> (Vec<Vec<f64>>, LeastSquares) {
        let columns: Vec<Vec<f64>> = self.columns.iter().chain(more).cloned().collect();
        let mut nonnegative = self.nonnegative.clone();
        nonnegative.resize(columns.len(), false);
        let solution = LeastSquares::solve_noisy(&columns, &self.target, &nonnegative, &self.column_noise());
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

    /// Rows of the model torque's derivative by a searched parameter.
    pub(crate) fn tangent(&self, searched: Searched, coefficients: &[f64]) -> Vec<f64> {
        let coefficients = &coefficients[self.range(searched.effect)];
        let step = self.value(searched).abs().max(f64::MIN_POSITIVE) * DIFFERENCE;
        let torque = |shift: f64| {
            let mut effect = self.effects[searched.effect];
            effect.values_mut()[searched.parameter] += shift;
            frame::torque(&effect, coefficients, self.motion)
        };
        let (above, below) = (torque(step), torque(-step));
        let difference: Vec<f64> = above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        self.frame.rows(&difference)
    }

    pub(crate) fn value(&self, searched: Searched) -> f64 {
        self.effects[searched.effect].values()[searched.parameter]
    }

    fn set(&mut self, searched: Searched, value: f64) {
        self.effects[searched.effect].values_mut()[searched.parameter] = value;
        let range = self.range(searched.effect);
        let full = frame::columns(&self.effects[searched.effect], self.motion);
        for (index, column) in range.zip(&full) {
            self.columns[index] = self.frame.rows(column);
        }
    }

    /// Improves the searched parameters by at most `rounds` Gauss–Newton steps, none of them longer than `limit` of
    /// the parameter; returns the solution there.
    pub(crate) fn refine(&mut self, rounds: usize, limit: impl Fn(Searched, f64) -> f64) -> LeastSquares {
        let mut solution = self.solve();
        let searched = self.searched();
        for _ in 0..rounds {
            let tangents: Vec<Vec<f64>> =
                searched.iter().map(|which| self.tangent(*which, &solution.coefficients)).collect();
            let (_, extended) = self.solve_with(&tangents);
            let start: Vec<f64> = searched.iter().map(|which| self.value(*which)).collect();
            let steps: Vec<f64> = searched
                .iter()
                .zip(&extended.coefficients[self.columns.len()..])
                .zip(&start)
                .map(|((which, step), value)| step.clamp(-limit(*which, *value), limit(*which, *value)))
                .collect();
            let before = dot(&solution.residual, &solution.residual);
            if before - dot(&extended.residual, &extended.residual) <= SETTLED * before {
                break;
            }
            let mut share = 1.0;
            let better = loop {
                for ((which, step), value) in searched.iter().zip(&steps).zip(&start) {
                    self.set(*which, value + share * step);
                }
                let trial = self.solve();
                if dot(&trial.residual, &trial.residual) < before {
                    break Some(trial);
                }
                share *= 0.25;
                if share < 1e-2 {
                    break None;
                }
            };
            let Some(better) = better else {
                searched.iter().zip(&start).for_each(|(which, value)| self.set(*which, *value));
                break;
            };
            solution = better;
        }
        solution
    }

    /// All `columns`, the inertia's from another sensor's acceleration.
    pub(crate) fn instruments(&self, columns: &[Vec<f64>], acceleration_rad_s2: &[f64]) -> Vec<Vec<f64>> {
        let mut instruments = columns.to_vec();
        for column in &self.inertial {
            instruments[*column] = self.frame.rows(acceleration_rad_s2);
        }
        instruments
    }

    /// Rows of minus the model torque's derivative by time: its coefficient is the torque's delay in seconds.
    pub(crate) fn delay_column(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut model = vec![0.0; self.motion.len()];
        for (index, effect) in self.effects.iter().enumerate() {
            let torque = frame::torque(effect, &coefficients[self.range(index)], self.motion);
            model.iter_mut().zip(&torque).for_each(|(sum, value)| *sum += value);
        }
        let mut rate = crate::motion::gradient(&model, -self.frame.rate_hz);
        // Friction jumps where the velocity changes sign; no delay is to be read from that.
        let velocity = &self.motion.velocity_rad_s;
        for index in 1..rate.len().saturating_sub(1) {
            if velocity[index - 1] * velocity[index + 1] <= 0.0 {
                rate[index] = 0.0;
            }
        }
        self.frame.rows(&rate)
    }
}
