//! The fit of a structure whose torque is linear in none of its values, such as one with a coupling, whose inner body
//! is simulated under the measured motion of the cap.
//!
//! Every value is searched, by Levenberg and Marquardt, first on slow motion and then on wider bands: on the whole band
//! at once the search stops in the first of many valleys.

use dynamics::Resolution;
use rayon::prelude::*;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::free_values::{FreeValue, free_values};
use crate::diagnosis::model_fit::residuals::{TOGETHER, residual, residuals};
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::vector::{self, square};
use crate::preparation::clock::whole;
use crate::preparation::row_filter::{row_low_pass, row_step};
use crate::regression::refiner::{self, Ended};

/// Edges of the bands of slow motion that are fitted one after the other, as shares of the comparison's, and steps in
/// each.
const SLOW_BANDS: [(f64, usize); 2] = [(0.075, 6), (0.25, 8)];
/// Fewest rows for each value in a band of slow motion that is simulated coarsely.
const ROWS_PER_VALUE: usize = 10;
/// Samples per period of the whole band's edge in which slow motion is simulated …
const SLOW_SAMPLES: f64 = 5.0;
/// … and most samples that are passed at once.
const LARGEST_STEP: usize = 4;
/// RMS of a fit's residual, in floors, above which a coarse simulation of slow motion may lead the fit into its valley. The error of the coarse
/// simulation is as large as the effect of a fainter contact.
const COARSE: f64 = 6.0;
/// Steps in the whole band.
const ROUNDS: usize = 14;
/// Steps in the whole band after which it shows whether a start leads anywhere: one set of derivatives.
const FIRST_ROUNDS: usize = UPDATES + 1;
/// Relative change of a value for its derivative.
const DIFFERENCE: f64 = 1e-4;
/// The same for an interval, where a body is simulated.
const SECANT: f64 = 1e-2;
/// An improvement of the sum of squares below this share ends the whole band, …
const SETTLED: f64 = 1e-4;
/// … and one below this share a band of slow motion, which only has to lead into the right valley.
const SLOW_SETTLED: f64 = 3e-3;
/// Steps for which derivatives are updated before they are taken anew.
const UPDATES: usize = 2;
/// Dampings that are tried in a step.
const TRIALS: usize = 6;
/// First damping, as a share of the diagonal.
const DAMPING: f64 = 1e-3;

/// Rows of the residual's derivatives with the sign turned, one per value.
#[derive(Default)]
struct Tangents {
    rows: Vec<Vec<f64>>,
    /// Steps since they were taken.
    updates: usize,
}

impl Tangents {
    /// Updates the derivatives from the residuals before and after a step (C. G. Broyden, *A class of methods for solving nonlinear simultaneous
    /// equations*, Math. Comp. 19 (1965) 577–593): a step costs one simulation, new derivatives cost one for each value.
    fn update(&mut self, step: &[f64], before: &[f64], after: &[f64]) {
        let length = square(step);
        if length > 0.0 {
            let mut missed: Vec<f64> = before.iter().zip(after).map(|(before, after)| before - after).collect();
            for (tangent, step) in self.rows.iter().zip(step) {
                missed.iter_mut().zip(tangent).for_each(|(slot, value)| *slot -= step * value);
            }
            for (tangent, step) in self.rows.iter_mut().zip(step) {
                tangent.iter_mut().zip(&missed).for_each(|(slot, value)| *slot += step / length * value);
            }
        }
        self.updates += 1;
    }
}

/// A structure in one capture, all of its values free.
#[derive(Clone)]
pub(crate) struct Nonlinear<'a> {
    capture: &'a Capture,
    pub(crate) structure: Structure,
    values: Vec<FreeValue>,
    pub(crate) residual: Vec<f64>,
    /// Whether bodies are simulated coarsely in slow motion.
    is_coarse: bool,
}

impl<'a> Nonlinear<'a> {
    pub(crate) fn new(structure: Structure, capture: &'a Capture) -> Self {
        let residual = residual(&structure, capture);
        Self::with_residual(structure, residual, capture)
    }

    /// As [`new`](Self::new), for several structures.
    pub(crate) fn all(structures: &[Structure], capture: &'a Capture) -> Vec<Self> {
        let fits = structures.par_chunks(TOGETHER).flat_map_iter(|group| {
            let residuals = residuals(&group.iter().collect::<Vec<_>>(), capture, Resolution::Full);
            let fits = group.iter().zip(residuals);
            fits.map(|(structure, residual)| Self::with_residual(structure.clone(), residual, capture))
        });
        fits.collect()
    }

    fn with_residual(structure: Structure, residual: Vec<f64>, capture: &'a Capture) -> Self {
        Self { capture, values: free_values(&structure, capture), structure, residual, is_coarse: false }
    }

    pub(crate) fn squares(&self) -> f64 {
        square(&self.residual)
    }

    /// Sum of squares of the residual below a share of the band's edge.
    pub(crate) fn slow_squares(&self, share: f64) -> f64 {
        square(&narrowed(&self.residual, share, self.capture))
    }

    /// Whether so much is left that slow motion may be simulated coarsely to find what is missing.
    pub(crate) fn leaves_much(&self) -> bool {
        let floor_mnm = self.capture.floor_of_mnm(&self.structure);
        self.squares() > (COARSE * floor_mnm).powi(2) * self.capture.weight
    }

    /// Fits all values on slow motion only, band by band.
    pub(crate) fn refine_slow(&mut self, is_coarse: bool) {
        self.is_coarse = is_coarse;
        for (share, rounds) in SLOW_BANDS {
            self.refine_in(share, rounds);
        }
        self.residual = residual(&self.structure, self.capture);
    }

    /// The fit with all values fitted in the whole band.
    pub(crate) fn refined(mut self) -> Self {
        self.refine_in(1.0, ROUNDS);
        self
    }

    /// The same by a few steps only.
    pub(crate) fn refined_shortly(mut self) -> Self {
        self.refine_in(1.0, FIRST_ROUNDS);
        self
    }

    /// Whether the last effect's values agree with those of another fit of the same structure.
    pub(crate) fn is_like(&self, other: &Self, share: f64) -> bool {
        let last = |fit: &Self| fit.structure.effects.last().map(|effect| effect.values().to_vec());
        let alike = |(a, b): (&f64, &f64)| (a - b).abs() <= share * a.abs().max(b.abs());
        last(self).zip(last(other)).is_some_and(|(own, others)| own.iter().zip(&others).all(alike))
    }

    /// Resolution of the simulation for a share of the band: full if few rows determine all values, since a small error would change the values.
    fn resolution(&self, share: f64) -> Resolution {
        let capture = self.capture;
        let rows = self.residual.len() / narrowing(share, capture);
        if !self.is_coarse || share == 1.0 || rows < ROWS_PER_VALUE * self.values.len() {
            return Resolution::Full;
        }
        Resolution::Slow(whole(capture.rate_hz / (SLOW_SAMPLES * capture.band.edge_hz)).min(LARGEST_STEP))
    }

    fn refine_in(&mut self, share: f64, rounds: usize) {
        // A band of slow motion has to lead into the right valley: a step repeated with new derivatives does not count there.
        let (settled, attempts) = if share < 1.0 { (SLOW_SETTLED, usize::MAX) } else { (SETTLED, rounds) };
        let mut damping = DAMPING;
        let resolution = self.resolution(share);
        if resolution != Resolution::Full {
            self.residual = residuals(&[&self.structure], self.capture, resolution).remove(0);
        }
        let mut left = narrowed(&self.residual, share, self.capture);
        let mut tangents = Tangents::default();
        let mut attempts = 0..attempts;
        refiner::refine(rounds, settled, square(&left), |mut before| {
            loop {
                attempts.next().ok_or(Ended::OutOfSteps)?;
                if tangents.rows.is_empty() || tangents.updates > UPDATES {
                    tangents = Tangents { rows: self.tangents(share), updates: 0 };
                }
                let are_fresh = tangents.updates == 0;
                let after = self.step(share, before, &mut left, &mut tangents, &mut damping);
                match after {
                    Ok(after) if !are_fresh && before - after < settled * before => before = after,
                    Err(_) if !are_fresh => {}
                    after => return after,
                }
                // The updated derivatives may be what is wrong.
                tangents = Tangents::default();
            }
        });
    }

    /// One step of Levenberg and Marquardt in a band, whose residual is given, damped until it improves.
    fn step(
        &mut self,
        share: f64,
        before: f64,
        left: &mut Vec<f64>,
        tangents: &mut Tangents,
        damping: &mut f64,
    ) -> Result<f64, Ended> {
        let (gram, right) = (vector::gram(&tangents.rows), vector::products_with(&tangents.rows, left));
        let trials = if tangents.updates > 0 { 1 } else { TRIALS };
        // The added `least` keeps a value without effect in this capture from moving.
        let least = f64::EPSILON * gram.diagonal().max();
        for _ in 0..trials {
            let mut damped = gram.clone();
            for index in 0..gram.nrows() {
                damped[(index, index)] += *damping * gram[(index, index)] + least;
            }
            let step = damped.cholesky().ok_or(Ended::NoStepImproves)?.solve(&right);
            let structure = self.moved(step.as_slice());
            let residual = residuals(&[&structure], self.capture, self.resolution(share)).remove(0);
            let trial = narrowed(&residual, share, self.capture);
            let after = square(&trial);
            if after < before {
                tangents.update(step.as_slice(), left, &trial);
                (self.structure, self.residual, *left) = (structure, residual, trial);
                *damping = (0.2 * *damping).max(1e-7);
                return Ok(after);
            }
            if tangents.updates == 0 {
                *damping *= 6.0;
            }
        }
        Err(Ended::NoStepImproves)
    }

    /// The same values, in the same units, in another capture.
    pub(crate) fn in_capture<'b>(&self, capture: &'b Capture) -> Nonlinear<'b> {
        Nonlinear { values: self.values.clone(), ..Nonlinear::new(self.structure.clone(), capture) }
    }

    /// The step that takes each value to its lower bound; infinite where it has none.
    pub(crate) fn lowest_steps(&self) -> Vec<f64> {
        self.values.iter().map(|value| value.lowest_step(self.structure.get(value.searched))).collect()
    }

    /// The structure with every value moved by a step in units of its scale.
    pub(crate) fn moved(&self, step: &[f64]) -> Structure {
        let mut moved = self.structure.clone();
        for (value, step) in self.values.iter().zip(step) {
            moved.set(value.searched, value.moved(moved.get(value.searched), *step));
        }
        moved
    }

    /// Which value a parameter is, if it is free.
    pub(crate) fn column_of(&self, effect: usize, parameter: usize) -> Option<usize> {
        self.values.iter().position(|value| value.searched.is(effect, parameter))
    }

    /// The values that may stand at the end of their range where their effect is a straight line.
    pub(crate) fn with_straight_end(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.values.len()).filter(|index| self.values[*index].has_straight_end(&self.structure))
    }

    /// A value's interval from the half width of its step's.
    pub(crate) fn interval(&self, column: usize, half: f64) -> Option<[f64; 2]> {
        let value = self.values[column];
        value.interval(self.structure.get(value.searched), half)
    }

    /// Rows of the derivatives by one effect's values.
    pub(crate) fn tangents_of(&self, effect: usize) -> Vec<Vec<f64>> {
        let values: Vec<usize> =
            (0..self.values.len()).filter(|index| self.values[*index].searched.is_of(effect)).collect();
        self.tangents_by(&values, DIFFERENCE, 1.0)
    }

    /// Rows of the residual's derivatives with the sign turned, one per value.
    pub(crate) fn tangents(&self, share: f64) -> Vec<Vec<f64>> {
        self.tangents_over(DIFFERENCE, share)
    }

    /// As [`tangents`](Self::tangents) in the whole band, but over larger steps if a body is simulated. At any moment the body
    /// touches or sticks or does not, so its torque jumps as the values change: over small steps one jump would dominate.
    pub(crate) fn secants(&self) -> Vec<Vec<f64>> {
        self.tangents_over(if self.structure.is_simulated() { SECANT } else { DIFFERENCE }, 1.0)
    }

    fn tangents_over(&self, difference: f64, share: f64) -> Vec<Vec<f64>> {
        let all: Vec<usize> = (0..self.values.len()).collect();
        let (left, right) = all.split_at(all.len() / 2);
        let by = |values: &[usize]| self.tangents_by(values, difference, share);
        let (mut all, rest) = rayon::join(|| by(left), || by(right));
        all.extend(rest);
        all
    }

    /// Rows of the derivatives by some of the values.
    fn tangents_by(&self, values: &[usize], difference: f64, share: f64) -> Vec<Vec<f64>> {
        let moved: Vec<(f64, Structure)> = values.iter().map(|index| self.moved_alone(*index, difference)).collect();
        let structures: Vec<&Structure> = moved.iter().map(|(_, structure)| structure).collect();
        let there = residuals(&structures, self.capture, self.resolution(share));
        let tangent = |(there, (step, _)): (&Vec<f64>, &(f64, Structure))| {
            let rows: Vec<f64> = self.residual.iter().zip(there).map(|(here, there)| (here - there) / step).collect();
            narrowed(&rows, share, self.capture)
        };
        there.iter().zip(&moved).map(tangent).collect()
    }

    /// The structure with one value moved for its derivative, and the step.
    fn moved_alone(&self, index: usize, difference: f64) -> (f64, Structure) {
        let mut step = vec![0.0; self.values.len()];
        step[index] = difference;
        let mut moved = self.moved(&step);
        if moved.effects == self.structure.effects && moved.skew_s == self.structure.skew_s {
            // It stands at its upper bound.
            step[index] = -difference;
            moved = self.moved(&step);
        }
        (step[index], moved)
    }
}

/// Rows below a share of the comparison's band.
fn narrowed(rows: &[f64], share: f64, capture: &Capture) -> Vec<f64> {
    if share >= 1.0 {
        return rows.to_vec();
    }
    row_low_pass(share * capture.band.edge_hz, capture.row_rate_hz()).decimate(rows, narrowing(share, capture))
}

/// Number of rows of the whole band for each row of a share of it.
fn narrowing(share: f64, capture: &Capture) -> usize {
    row_step(share * capture.band.edge_hz, capture.row_rate_hz())
}
