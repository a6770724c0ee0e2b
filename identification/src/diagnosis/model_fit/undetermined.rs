//! Combinations of a base model's coefficients that the training capture leaves open and that would look like a gap in the other.
//!
//! A capture at constant speed tells next to nothing of the inertia. On another motion the base model is then wrong by more than noise, though
//! nothing is missing, and whatever effect moves the prediction seems to explain it. With training columns X and held-out columns Y, a
//! combination v of coefficients that is known to σ²·(XᵀX)⁻¹ adds σ²·vᵀYᵀYv / vᵀXᵀXv to the held-out sum of squares: the generalised
//! eigenvectors tell which combinations add more than a share of the noise. The held-out capture is compared without them.

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::vector;
use crate::regression::least_squares::residual;

/// Share of the noise's mean square that the uncertainty of one combination may add to the held-out residual's mean square.
const OPEN: f64 = 0.1;
/// Share of each column's square that is added to it, so that collinear ones can be told apart.
const RIDGE: f64 = 1e-9;
/// Part of a combination from which a coefficient belongs to it.
const BELONGS: f64 = 0.3;

/// Combinations of a structure's coefficients that a training capture leaves open.
pub(crate) struct Undetermined {
    structure: Structure,
    /// The coefficients of each combination.
    combinations: Vec<Vec<f64>>,
    /// The coefficients that belong to them, by the names of parameters or effects.
    names: Vec<&'static str>,
}

impl Undetermined {
    /// The open combinations of a structure; `None` if it is coupled, or determined well enough for the held-out capture.
    pub(crate) fn of(structure: &Structure, train: &Capture, heldout: &Capture) -> Option<Self> {
        if structure.is_coupled() {
            return None;
        }
        let (known, other) = (columns(structure, train), columns(structure, heldout));
        let (known, products_there) = (vector::gram(&known), vector::gram(&other));
        let scale = |column: usize| products_there[(column, column)].sqrt();
        let shown: Vec<usize> = (0..other.len()).filter(|column| scale(*column) > 0.0).collect();
        let scaled = |products: &DMatrix<f64>| {
            DMatrix::from_fn(shown.len(), shown.len(), |row, column| {
                let product = products[(shown[row], shown[column])] / (scale(shown[row]) * scale(shown[column]));
                if row == column { product * (1.0 + RIDGE) } else { product }
            })
        };
        let lower = Cholesky::new(scaled(&products_there))?.l();
        let half = lower.solve_lower_triangular(&scaled(&known))?;
        let determined = SymmetricEigen::new(lower.solve_lower_triangular(&half.transpose())?);
        let is_open = |place: &usize| determined.eigenvalues[*place] * OPEN * heldout.weight < 1.0;
        let open: Vec<usize> = (0..shown.len()).filter(is_open).collect();
        let combinations = lower.transpose().solve_upper_triangular(&determined.eigenvectors)?;
        let coefficients = |place: &usize| {
            let mut coefficients = vec![0.0; other.len()];
            let parts = combinations.column(*place);
            parts.iter().zip(&shown).for_each(|(part, column)| coefficients[*column] = part / scale(*column));
            coefficients
        };
        let belongs = |row: &usize| {
            open.iter().any(|place| {
                let combination = combinations.column(*place);
                combination[*row].abs() > BELONGS * combination.amax()
            })
        };
        let names = (0..shown.len()).filter(belongs).map(|row| name(structure, shown[row]));
        let combinations = open.iter().map(coefficients).collect();
        let undetermined = Self { structure: structure.clone(), combinations, names: names.collect() };
        (!open.is_empty()).then_some(undetermined)
    }

    /// The torques of the combinations in a capture, as orthonormal rows.
    pub(crate) fn rows(&self, capture: &Capture) -> Vec<Vec<f64>> {
        let columns = columns(&self.structure, capture);
        let nothing = vec![0.0; capture.row_count()];
        // This is minus the torque; the sign of a row does not matter.
        let torque = |coefficients: &Vec<f64>| residual(&columns, &nothing, coefficients);
        vector::orthonormal(&self.combinations.iter().map(torque).collect::<Vec<_>>())
    }

    /// A note on the open combinations for the reader.
    pub(crate) fn note(&self) -> String {
        let mut names = self.names.clone();
        names.dedup();
        format!(
            "the training capture does not determine {} well enough to predict the held-out one: what they do there counts neither for nor \
             against an effect; train on a capture with more speeds and accelerations",
            names.join(", ")
        )
    }
}

/// Rows of a structure's columns in a capture.
fn columns(structure: &Structure, capture: &Capture) -> Vec<Vec<f64>> {
    (0..structure.effects.len()).flat_map(|index| capture.rows_of(structure, index)).collect()
}

/// Name of the parameter that is a column's coefficient, or else of the column's effect.
fn name(structure: &Structure, column: usize) -> &'static str {
    let ranges = structure.ranges();
    let index = ranges.iter().position(|range| range.contains(&column)).unwrap_or(0);
    structure.effects[index].kind().column_name(column - ranges[index].start)
}
