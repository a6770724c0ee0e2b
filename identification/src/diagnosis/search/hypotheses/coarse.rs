//! A cheap estimate of how much a further effect would explain.

use dynamics::{Effect, Motion, Part};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::vector::{self, square};
use crate::regression::least_squares::LeastSquares;

/// Estimates how much a further effect would explain, at the rows' middles and without filtering: enough to choose starts.
pub(super) struct Coarse {
    motions: Vec<(Motion, f64)>,
    /// Friction at the rows, for what modulates it, mNm.
    friction: [Vec<f64>; 2],
    /// Orthonormal columns of the present structure.
    basis: Vec<Vec<f64>>,
    residual: Vec<f64>,
}

impl Coarse {
    pub(super) fn of(current: &Separable<'_>) -> Self {
        Self::new(current.capture, &current.structure, &current.columns(), &current.residual)
    }

    /// `columns` are the directions in which the present structure can move.
    pub(super) fn new(capture: &Capture, structure: &Structure, columns: &[&[f64]], residual: &[f64]) -> Self {
        let thin = |coulomb_only| {
            let rows = (0..capture.motion.len()).step_by(capture.row_filter.step);
            rows.map(structure.friction_mnm(&capture.motion, coulomb_only)).collect()
        };
        let basis = vector::orthonormal(columns);
        Self { motions: capture.row_motions(), friction: [thin(false), thin(true)], basis, residual: residual.to_vec() }
    }

    /// By how much the effect's columns would lower the sum of squares, mNm².
    pub(super) fn gain(&self, effect: &Effect) -> f64 {
        // A further line of the law does not occur yet.
        self.gain_into(&mut effect.clone(), effect.kind().columns_of_a_line())
    }

    /// As [`Self::gain`], for the effect's `width` leading columns; writes their coefficients into the effect's values.
    pub(super) fn gain_into(&self, effect: &mut Effect, width: usize) -> f64 {
        let Some(regressors) = effect.kind().regressors else { return 0.0 };
        let factor = match effect.kind().part {
            Part::FrictionFactor(_) => Some(&self.friction[0]),
            Part::CoulombFactor(_) => Some(&self.friction[1]),
            _ => None,
        };
        let mut columns = vec![vec![0.0; self.motions.len()]; width];
        let mut row = [0.0; dynamics::MAX_PARAMETERS];
        for (index, (motion, mask)) in self.motions.iter().enumerate().filter(|(_, (_, mask))| *mask != 0.0) {
            (regressors.fill)(effect, motion, &mut row[..regressors.columns]);
            let weight = mask * factor.map_or(1.0, |friction| friction[index]);
            columns.iter_mut().zip(row).for_each(|(column, value)| column[index] = weight * value);
        }
        let nonnegative: Vec<bool> = (0..columns.len()).map(|column| effect.kind().is_nonnegative(column)).collect();
        let (gain, coefficients) = self.gain_of(columns, &nonnegative);
        let mut all = vec![0.0; regressors.columns];
        all[..coefficients.len()].copy_from_slice(&coefficients);
        (regressors.values)(&all, effect.values_mut());
        gain
    }

    /// By how much columns would lower the sum of squares, mNm², and their coefficients.
    pub(super) fn gain_of(&self, mut columns: Vec<Vec<f64>>, nonnegative: &[bool]) -> (f64, Vec<f64>) {
        columns.iter_mut().for_each(|column| vector::take_out(&self.basis, column));
        let solved = LeastSquares::held(&columns, &self.residual, nonnegative, &[]);
        (square(&self.residual) - solved.squares(), solved.coefficients)
    }
}
