//! The fit of a structure without coupling: coefficients are linear, the few searched parameters follow by Gauss–Newton.

use std::borrow::Cow;

use dynamics::effects::end_stop;
use dynamics::{Effect, Part};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::kept::{Kept, Product, changed};
use crate::diagnosis::model_fit::structure::{Searched, Structure};
use crate::numerics::vector::{square, subtract};
use crate::regression::gram::Correction;
use crate::regression::least_squares::{LeastSquares, residual};
use crate::regression::refiner::{self, Ended, longest_improving};

/// Relative change of a searched parameter for its column by differences.
const DIFFERENCE: f64 = 1e-5;
/// A step that would take off less than this share of the sum of squares is not worth taking.
const SETTLED: f64 = 1e-6;
/// Powers of the angle that make a slow bend.
pub(crate) const BEND: usize = 5;
/// Most steps in which coefficients and the factors on them are fitted together …
const FACTOR_STEPS: usize = 6;
/// … and the relative gain that ends them.
const FACTORS_SETTLED: f64 = 1e-4;

/// A structure in one capture.
pub(crate) struct Separable<'a> {
    pub(crate) capture: &'a Capture,
    pub(crate) structure: Structure,
    kept: Kept,
    target: Vec<f64>,
    pub(crate) coefficients: Vec<f64>,
    pub(crate) residual: Vec<f64>,
}

impl<'a> Separable<'a> {
    /// The structure with its linear coefficients fitted to the capture.
    pub(crate) fn new(structure: Structure, capture: &'a Capture) -> Self {
        let nothing = vec![0.0; structure.nonnegative().len()];
        let kept = Kept::default().updated(&Structure::new(&[]), &structure, capture);
        Self::solved(capture, structure, kept, nothing)
    }

    /// The fit with one effect more, of which the first `columns` take part.
    pub(crate) fn with(&self, effect: Effect, columns: usize) -> Self {
        let structure = self.structure.with(effect, columns);
        let mut coefficients = self.coefficients.clone();
        coefficients.resize(structure.nonnegative().len(), 0.0);
        let kept = self.kept.clone().updated(&self.structure, &structure, self.capture);
        Self::solved(self.capture, structure, kept, coefficients)
    }

    fn solved(capture: &'a Capture, structure: Structure, kept: Kept, coefficients: Vec<f64>) -> Self {
        let target = capture.target(structure.delay_s());
        let mut fit = Self { capture, structure, kept, target, coefficients, residual: Vec::new() };
        fit.solve();
        fit
    }

    pub(crate) fn squares(&self) -> f64 {
        square(&self.residual)
    }

    /// The sum of squares less what the sensors' noise alone leaves.
    pub(crate) fn squares_above_floor(&self) -> f64 {
        let floor_mnm = self.capture.floor_of_mnm(&self.structure);
        self.squares() - self.capture.weight * floor_mnm * floor_mnm
    }

    /// Sum of squares if the torque channel were late by so much, s.
    pub(crate) fn squares_if_late(&self, delay_s: f64) -> f64 {
        let (columns, target) = (self.columns(), self.capture.target(delay_s));
        LeastSquares::held(&columns, &target, &self.structure.nonnegative(), &[]).squares()
    }

    /// A polynomial of the angle, fitted beside all columns, for a torque that bends slowly along the angle: returns its torque at an angle, mNm.
    pub(crate) fn bend(&self) -> impl Fn(f64) -> f64 + use<> {
        let scene = &self.capture.scene;
        let middle_rad = 0.5 * (scene.lowest_rad + scene.highest_rad);
        let half_rad = 0.5 * scene.travel_rad().max(f64::MIN_POSITIVE);
        let share = move |angle_rad: f64| (angle_rad - middle_rad) / half_rad;
        let bend = self.capture.row_filter.rows_by_sample(BEND, |at, powers| {
            let share = share(self.capture.motion.angle_rad[at]);
            powers.iter_mut().fold(share, |power, slot| {
                *slot = power;
                power * share
            });
        });
        let powers = self.coefficients_beside(&bend, &self.target, &[]);
        move |angle_rad| powers.iter().rev().fold(0.0, |sum, power_mnm| (sum + power_mnm) * share(angle_rad))
    }

    /// Coefficients of further columns, corrected by `holds` and fitted to a target beside the fit's own columns.
    pub(crate) fn coefficients_beside(&self, more: &[Vec<f64>], target: &[f64], holds: &[Correction]) -> Vec<f64> {
        let own = self.columns();
        let columns: Vec<&[f64]> = own.iter().copied().chain(more.iter().map(Vec::as_slice)).collect();
        let mut nonnegative = self.structure.nonnegative();
        nonnegative.resize(columns.len(), false);
        LeastSquares::held(&columns, target, &nonnegative, holds).coefficients.split_off(own.len())
    }

    pub(crate) fn columns(&self) -> Vec<&[f64]> {
        self.kept.rows.iter().flatten().map(Vec::as_slice).collect()
    }

    /// Solves for the coefficients.
    ///
    /// The problem is nonlinear if a factor multiplies friction or load, whose coefficients are fitted too, or if there is a stop, which lets go
    /// where its damper would pull. Then it takes Gauss–Newton steps from the present coefficients. If levels and factor were fitted in turn,
    /// the levels would be fitted without the factor's effect on them, and would end elsewhere if an offset can replace them.
    fn solve(&mut self) {
        let nonnegative = self.structure.nonnegative();
        let is_linear = self.kept.products.is_empty()
            && self.structure.load_frictions().is_empty()
            && self.structure.position(end_stop::KIND.name).is_none();
        if is_linear {
            let solved = LeastSquares::held(&self.columns(), &self.target, &nonnegative, &[]);
            self.structure.take(&solved.coefficients);
            (self.coefficients, self.residual) = (solved.coefficients, solved.residual);
            return;
        }
        self.take(self.coefficients.clone());
        refiner::refine(FACTOR_STEPS, FACTORS_SETTLED, self.squares(), |before| {
            let start = self.coefficients.clone();
            let (columns, target) = self.linearised(None);
            let end = LeastSquares::held(&columns, &target, &nonnegative, &[]).coefficients;
            let improved = longest_improving(0.25, |share| {
                self.take(start.iter().zip(&end).map(|(start, end)| start + share * (end - start)).collect());
                Some(self.squares()).filter(|after| *after < before)
            });
            if improved.is_err() {
                self.take(start);
            }
            improved
        });
    }

    /// Sets the coefficients, and recomputes the rows and the residual that depend on them.
    fn take(&mut self, coefficients: Vec<f64>) {
        self.structure.take(&coefficients);
        if let Some(stop) = self.structure.position(end_stop::KIND.name) {
            self.kept.rows[stop] = self.capture.rows_of(&self.structure, stop);
        }
        for factor in self.structure.factors() {
            self.kept.rows[factor] = self.factor_rows(factor, &coefficients);
        }
        for index in self.structure.load_frictions() {
            self.kept.rows[index] = self.load_rows(&coefficients);
        }
        self.residual = residual(&self.columns(), &self.target, &coefficients);
        self.coefficients = coefficients;
    }

    /// Rows of the load's magnitude with the sign of the velocity: the column of friction that grows with the load.
    fn load_rows(&self, coefficients: &[f64]) -> Vec<Vec<f64>> {
        let (capture, ranges) = (self.capture, self.structure.ranges());
        let mut load_mnm = vec![0.0; capture.motion.len()];
        for (index, columns) in &self.kept.loads {
            for (coefficient, column) in coefficients[ranges[*index].clone()].iter().zip(columns.iter()) {
                subtract(&mut load_mnm, -coefficient, column);
            }
        }
        let against = load_mnm.iter().zip(&capture.motions).map(|(load, motion)| motion.velocity_sign() * load.abs());
        vec![capture.row_filter.rows(&against.collect::<Vec<_>>())]
    }

    /// Rows of a factor's columns, each multiplied by the sum of the friction torques.
    fn factor_rows(&self, factor: usize, coefficients: &[f64]) -> Vec<Vec<f64>> {
        let ranges = self.structure.ranges();
        let mut sums = vec![vec![0.0; self.target.len()]; ranges[factor].len()];
        for product in self.kept.products.iter().filter(|product| product.factor == factor) {
            for (level, rows) in coefficients[ranges[product.friction].clone()].iter().zip(&*product.rows) {
                sums.iter_mut().zip(rows).for_each(|(sum, row)| subtract(sum, -level, row));
            }
        }
        sums
    }

    /// The torque's derivatives by the coefficients, and the target of a linear fit of them. Without the factor by which friction multiplies
    /// the load at every sample, the derivatives leave out the change of that friction with the load's own coefficients, which is small and
    /// costly.
    pub(crate) fn linearised(&self, load_factor: Option<&[f64]>) -> (Vec<Cow<'_, [f64]>>, Cow<'_, [f64]>) {
        let mut columns: Vec<Cow<'_, [f64]>> = self.columns().into_iter().map(Cow::Borrowed).collect();
        let mut target = Cow::Borrowed(self.target.as_slice());
        let ranges = self.structure.ranges();
        // Linearised, the product of level and factor is in both their columns, once too often: the target gets it once more too.
        let mut multiply = |column: usize, by: f64, row: &[f64]| {
            subtract(columns[column].to_mut(), -by, row);
            subtract(target.to_mut(), -by * self.coefficients[column], row);
        };
        for Product { friction, factor, rows } in &self.kept.products {
            let depths = &self.coefficients[ranges[*factor].clone()];
            for (level, rows) in ranges[*friction].clone().zip(&**rows) {
                rows.iter().zip(depths).for_each(|(row, depth)| multiply(level, *depth, row));
            }
        }
        if let Some(factor) = load_factor {
            for (index, loads) in &self.kept.loads {
                for (column, load) in ranges[*index].clone().zip(&**loads) {
                    let rubbing: Vec<f64> = load.iter().zip(factor).map(|(load, factor)| load * factor).collect();
                    multiply(column, 1.0, &self.capture.row_filter.rows(&rubbing));
                }
            }
        }
        (columns, target)
    }

    /// Sets searched parameters and solves again.
    fn set(&mut self, searched: &[Searched], values: &[f64]) {
        let before = self.structure.clone();
        for (which, value) in searched.iter().zip(values) {
            self.structure.set(*which, *value);
        }
        if self.structure.delay_s() != before.delay_s() {
            self.target = self.capture.target(self.structure.delay_s());
        }
        self.kept = std::mem::take(&mut self.kept).updated(&before, &self.structure, self.capture);
        self.solve();
    }

    /// Rows of the derivative of prediction minus target by a searched parameter.
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
                let coefficients = &self.coefficients[ranges[index].clone()];
                for (rows, coefficient) in self.capture.rows_of(&moved, index).iter().zip(coefficients) {
                    sum.iter_mut().zip(rows).for_each(|(slot, value)| *slot += coefficient * value);
                }
            }
            sum
        };
        let (above, below) = (predicted(value + step), predicted(value - step));
        above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step)).collect()
    }

    /// The fit with searched parameters and skew improved by at most `rounds` Gauss–Newton steps.
    pub(crate) fn refined(mut self, rounds: usize) -> Self {
        self.refine_by(&self.searched(), rounds);
        self
    }

    /// The same by the last effect's parameters and the skew alone.
    pub(crate) fn newest_refined(mut self, rounds: usize) -> Self {
        let newest = self.structure.effects.len().saturating_sub(1);
        let mut searched = self.searched();
        searched.retain(|which| *which == Searched::Skew || which.is_of(newest));
        self.refine_by(&searched, rounds);
        self
    }

    /// Takes Gauss–Newton steps of some searched parameters; the coefficients are solved for anew in each.
    fn refine_by(&mut self, searched: &[Searched], rounds: usize) {
        refiner::refine(rounds, 0.0, self.squares(), |before| {
            let tangents: Vec<Vec<f64>> = searched.iter().map(|which| self.tangent(*which)).collect();
            let (columns, target) = self.linearised(None);
            let columns: Vec<&[f64]> =
                columns.iter().map(AsRef::as_ref).chain(tangents.iter().map(Vec::as_slice)).collect();
            let mut nonnegative = self.structure.nonnegative();
            let linear = nonnegative.len();
            nonnegative.resize(columns.len(), false);
            let mut extended = LeastSquares::held(&columns, &target, &nonnegative, &[]);
            if before - extended.squares() <= SETTLED * before {
                return Err(Ended::Settled);
            }
            let step = extended.coefficients.split_off(linear);
            let mut improved = self.try_step(searched, &step);
            if improved.is_err() {
                // A parameter with little effect takes a wild step that spoils the joint one, so each parameter moves alone.
                for index in 0..searched.len() {
                    let mut alone = vec![0.0; step.len()];
                    alone[index] = step[index];
                    improved = self.try_step(searched, &alone).or(improved);
                }
            }
            improved
        });
    }

    /// Goes along a step as far as the sum of squares falls, and returns it.
    fn try_step(&mut self, searched: &[Searched], step: &[f64]) -> Result<f64, Ended> {
        let before = self.squares();
        let start: Vec<f64> = searched.iter().map(|which| self.structure.get(*which)).collect();
        let improved = longest_improving(0.25, |share| {
            let moved = searched.iter().zip(&start).zip(step);
            let values: Vec<f64> =
                moved.map(|((which, value), step)| self.limited(*which, *value, share * step)).collect();
            self.set(searched, &values);
            Some(self.squares()).filter(|after| *after < before)
        });
        if improved.is_err() {
            self.set(searched, &start);
        }
        improved
    }

    /// A value moved by a step, no further than is sensible in one go and within its range.
    fn limited(&self, searched: Searched, value: f64, step: f64) -> f64 {
        match searched {
            Searched::Skew => {
                let most = self.capture.largest_skew_s();
                (value + step).clamp(-most, most)
            }
            Searched::Parameter { range: (least, largest), .. } => {
                let width = largest - least;
                // A value of either sign has no scale of its own: near zero, a share of it would be no step at all.
                let signed = least < 0.0 && largest > 0.0;
                let most = if signed { 0.25 * width } else { (0.25 * width).min(0.7 * value.abs().max(1e-3 * width)) };
                (value + step.clamp(-most, most)).clamp(least, largest)
            }
        }
    }

    /// The structure's searched parameters; the skew too unless a delay is an effect of its own.
    fn searched(&self) -> Vec<Searched> {
        let mut searched = self.structure.searched(&self.capture.scene_of(&self.structure));
        if self.structure.has_free_skew(self.capture) {
            searched.push(Searched::Skew);
        }
        searched
    }
}

#[cfg(test)]
mod tests {
    use dynamics::{Axis, effects};

    use super::*;
    use crate::Samples;
    use crate::diagnosis::capture::Stretches;

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
        let Ok(capture) = Capture::of(&samples, Axis::Rotary, None, 12.5, Stretches::All) else {
            panic!("the capture can be prepared")
        };
        let none = [Effect::new(&effects::inertia::KIND, &[1.0]), Effect::new(&effects::sensor_delay::KIND, &[0.0])];
        let fit = Separable::new(Structure::new(&none), &capture).refined(6);
        let found_s = fit.structure.delay_s();
        assert!((found_s - DELAY_S).abs() < 1e-4, "found {found_s} s for {DELAY_S} s");
        assert!((fit.structure.inertia() - INERTIA).abs() < 1e-2);
    }
}
