//! The fit of a structure without coupling: coefficients are linear, the few searched parameters follow by Gauss–Newton.

use std::sync::Arc;

use dynamics::Part;
use nalgebra::{DMatrix, DVector};

use super::capture::Capture;
use super::structure::{Searched, Structure};
use crate::regression::{Damping, LeastSquares, Refined, projected, refine};

/// Relative change of a searched parameter for its column by differences.
const DIFFERENCE: f64 = 1e-5;
/// A step that would take off less than this share of the sum of squares is not worth taking.
const SETTLED: f64 = 1e-6;
/// Rounds in which friction and what modulates it are fitted in turn.
const FACTOR_ROUNDS: usize = 2;

/// A structure in one capture: its rows, made anew only where a value changed.
#[derive(Clone)]
pub(crate) struct Separable<'a> {
    pub(crate) capture: &'a Capture,
    pub(crate) structure: Structure,
    /// Rows of each effect's columns.
    rows: Vec<Arc<[Vec<f64>]>>,
    target: Vec<f64>,
    pub(crate) solution: LeastSquares,
    searched: Vec<Searched>,
}

impl<'a> Separable<'a> {
    /// The structure with its linear coefficients fitted to the capture.
    pub(crate) fn new(structure: Structure, capture: &'a Capture) -> Self {
        let rows = (0..structure.effects.len()).map(|index| structure.rows(index, capture).into()).collect();
        let target = capture.target(structure.delay_s());
        let solution = LeastSquares::solve::<&[f64]>(&[], &target);
        let mut fit = Self { capture, structure, rows, target, solution, searched: Vec::new() };
        fit.solve();
        fit
    }

    /// Sum of squares if the torque channel were late by so much, s.
    pub(crate) fn squares_if_late(&self, delay_s: f64) -> f64 {
        let target = self.capture.target(delay_s);
        LeastSquares::solve_held(&self.columns(), &target, &self.structure.nonnegative()).squares()
    }

    /// All columns' rows.
    pub(crate) fn columns(&self) -> Vec<&[f64]> {
        self.rows.iter().flat_map(|rows| rows.iter().map(Vec::as_slice)).collect()
    }

    fn solve(&mut self) {
        let factors: Vec<usize> = (0..self.structure.effects.len())
            .filter(|index| {
                let part = self.structure.effects[*index].kind().part;
                matches!(part, Part::CoulombFactor(_) | Part::FrictionFactor(_))
            })
            .collect();
        for round in 0..if factors.is_empty() { 1 } else { FACTOR_ROUNDS + 1 } {
            if round > 0 {
                factors.iter().for_each(|index| self.rows[*index] = self.structure.rows(*index, self.capture).into());
            }
            self.solution = LeastSquares::solve_held(&self.columns(), &self.target, &self.structure.nonnegative());
            self.structure.take(&self.solution.coefficients);
        }
    }

    /// Sets searched parameters and solves again.
    fn set(&mut self, values: &[f64]) {
        let before = self.structure.clone();
        for (which, value) in self.searched.iter().zip(values) {
            self.structure.set(*which, *value);
        }
        if self.structure.delay_s() != before.delay_s() {
            self.target = self.capture.target(self.structure.delay_s());
        }
        for index in changed(&before, &self.structure) {
            self.rows[index] = self.structure.rows(index, self.capture).into();
        }
        self.solve();
    }

    /// Rows of the prediction's derivative by a searched parameter, the target's counted with the other sign.
    fn tangent(&self, searched: Searched) -> Vec<f64> {
        let value = self.structure.get(searched);
        let delays = matches!(searched, Searched::Skew)
            || matches!(searched, Searched::Parameter { effect, .. }
                if matches!(self.structure.effects[effect].kind().part, Part::ReadingDelay(_)));
        if delays {
            let step = 0.02 / self.capture.rate_hz;
            let delay_s = self.structure.delay_s();
            let (later, sooner) = (self.capture.target(delay_s + step), self.capture.target(delay_s - step));
            return later.iter().zip(&sooner).map(|(later, sooner)| (sooner - later) / (2.0 * step)).collect();
        }
        let step = DIFFERENCE * value.abs().max(f64::MIN_POSITIVE);
        let ranges = self.structure.ranges();
        let predicted = |value: f64| {
            let mut moved = self.structure.clone();
            moved.set(searched, value);
            let mut sum = vec![0.0; self.target.len()];
            for index in changed(&self.structure, &moved) {
                let coefficients = &self.solution.coefficients[ranges[index].clone()];
                for (rows, coefficient) in moved.rows(index, self.capture).iter().zip(coefficients) {
                    sum.iter_mut().zip(rows).for_each(|(slot, value)| *slot += coefficient * value);
                }
            }
            sum
        };
        let (above, below) = (predicted(value + step), predicted(value - step));
        above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step)).collect()
    }

    /// Improves the searched parameters and the skew by at most `rounds` Gauss–Newton steps.
    pub(crate) fn refine(&mut self, rounds: usize) {
        self.searched = self.all_searched();
        refine(self, rounds, SETTLED, Damping::NONE);
    }

    /// Goes along a step if that leaves less.
    fn try_step(&mut self, step: &[f64]) -> bool {
        let mut moved = self.clone();
        let values = self.searched.iter().zip(step).map(|(which, step)| {
            let (least, largest) = self.range(*which);
            (self.structure.get(*which) + step).clamp(least, largest)
        });
        moved.set(&values.collect::<Vec<f64>>());
        let better = moved.squares() < self.squares();
        if better {
            *self = moved;
        }
        better
    }

    /// What a parameter may be.
    fn range(&self, searched: Searched) -> (f64, f64) {
        match searched {
            Searched::Skew => (-self.capture.largest_skew_s(), self.capture.largest_skew_s()),
            Searched::Parameter { range, .. } => range,
        }
    }

    /// The structure's searched parameters; the skew too unless a delay is an effect of its own.
    fn all_searched(&self) -> Vec<Searched> {
        let mut searched = self.structure.searched(&self.capture.scene_of(&self.structure));
        if self.structure.may_be_skewed(self.capture) {
            searched.push(Searched::Skew);
        }
        searched
    }
}

impl Refined for Separable<'_> {
    fn squares(&self) -> f64 {
        self.solution.squares()
    }

    fn normal_equations(&mut self) -> (DMatrix<f64>, DVector<f64>) {
        let tangents: Vec<Vec<f64>> = self.searched.iter().map(|which| self.tangent(*which)).collect();
        projected(&self.solution, &self.columns(), &tangents)
    }

    fn limit(&self, step: &mut DVector<f64>) {
        for (step, which) in step.iter_mut().zip(&self.searched) {
            let (least, largest) = self.range(*which);
            let width = largest - least;
            // What may have either sign has no scale of its own: near zero a share of it would be no step at all.
            let own = self.structure.get(*which).abs().max(1e-3 * width);
            let most = if least < 0.0 && largest > 0.0 { 0.25 * width } else { (0.25 * width).min(0.7 * own) };
            *step = step.clamp(-most, most);
        }
    }

    fn go(&mut self, step: &DVector<f64>) -> bool {
        // Where one parameter hardly matters its step is wild: then one at a time.
        self.try_step(step.as_slice())
            || step.len() > 1
                && (0..step.len()).fold(false, |helped, index| {
                    let mut alone = vec![0.0; step.len()];
                    alone[index] = step[index];
                    self.try_step(&alone) || helped
                })
    }
}

/// Effects whose columns differ between two structures of the same effects.
fn changed(before: &Structure, after: &Structure) -> Vec<usize> {
    let bristles = before.bristles() != after.bristles();
    (0..after.effects.len())
        .filter(|index| {
            let (old, new) = (&before.effects[*index], &after.effects[*index]);
            let of_friction = matches!(
                new.kind().part,
                Part::Friction(_) | Part::CoulombFactor(_) | Part::FrictionFactor(_) | Part::Bristles(_)
            );
            old != new || bristles && of_friction
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use dynamics::{Effect, effects};

    use super::super::capture::Stretches;
    use super::*;
    use crate::Samples;

    #[test]
    fn a_delay_is_found_from_a_start_without_any() {
        const DELAY_S: f64 = -0.008;
        const INERTIA: f64 = 2.0;
        let tones = [(1.1, 0.7), (2.3, 0.2), (3.7, 0.08)].map(|(hz, size)| (std::f64::consts::TAU * hz, size));
        let sum = |term: &dyn Fn(f64, f64) -> f64| tones.iter().map(|(omega, size)| term(*omega, *size)).sum::<f64>();
        let t_s: Vec<f64> = (0..4000).map(|index| f64::from(index) / 1000.0).collect();
        let each = |of: &dyn Fn(f64) -> f64| t_s.iter().map(|t| of(*t)).collect::<Vec<f64>>();
        let acceleration = |t: f64| sum(&|omega, size| -size * omega * omega * (omega * t).sin());
        let angle_rad = each(&|t| sum(&|omega, size| size * (omega * t).sin()));
        let velocity_rad_s = each(&|t| sum(&|omega, size| size * omega * (omega * t).cos()));
        let acceleration_rad_s2 = each(&acceleration);
        let torque_mnm = each(&|t| INERTIA * acceleration(t - DELAY_S));
        let samples = Samples {
            t_s: &t_s,
            angle_rad: &angle_rad,
            velocity_rad_s: Some(&velocity_rad_s),
            acceleration_rad_s2: Some(&acceleration_rad_s2),
            torque_mnm: &torque_mnm,
        };
        let Ok(capture) = Capture::of(&samples, None, 12.5, Stretches::All) else {
            panic!("the capture can be prepared")
        };
        let none = [Effect::new(&effects::inertia::KIND, &[1.0]), Effect::new(&effects::sensor_delay::KIND, &[0.0])];
        let mut fit = Separable::new(Structure::new(&none), &capture);
        fit.refine(6);
        let found_s = fit.structure.delay_s();
        assert!((found_s - DELAY_S).abs() < 1e-4, "found {found_s} s for {DELAY_S} s");
        assert!((fit.structure.inertia() - INERTIA).abs() < 1e-2);
    }
}
