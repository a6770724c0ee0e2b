//! Gram matrices of blocks of rows: all that least squares and its intervals need, in bounded memory.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::uncertainty::statistics::student_95;

/// Most columns of a row, torque included.
pub(super) const MOST_COLUMNS: usize = 16;
/// Most blocks; when they are full, neighbours merge.
const MOST_BLOCKS: usize = 128;
/// Rows of the first blocks.
const FIRST_LENGTH: u64 = 16;
/// A column of which less than this share remains beside the others cannot be told.
const COLLINEAR: f64 = 1e-7;

/// The Gram matrices of consecutive blocks of rows; the last column of a row is the torque.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    width: usize,
    /// Packed lower triangles.
    blocks: Vec<Vec<f64>>,
    length: u64,
    in_last: u64,
    rows: u64,
}

/// Coefficients from the blocks.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    /// One per column; zero where it could not be told.
    pub(super) coefficients: Vec<f64>,
    /// Covariance of the coefficients from the scatter of the blocks.
    pub(super) covariance: DMatrix<f64>,
    /// Whether each column could be told.
    pub(super) told: Vec<bool>,
    /// RMS of each column over the rows.
    pub(super) column_rms: Vec<f64>,
    pub(super) torque_rms: f64,
    pub(super) residual_rms: f64,
    pub(super) rows: u64,
    pub(super) blocks: usize,
}

impl Solution {
    /// Half width of a 95 % interval over the standard deviation, which the scatter of the blocks gives.
    #[allow(clippy::cast_precision_loss, reason = "a number of blocks")]
    pub(super) fn critical(&self) -> f64 {
        student_95(self.blocks as f64 - 1.0)
    }
}

impl Blocks {
    pub(super) fn new(width: usize) -> Self {
        Self { width, blocks: vec![vec![0.0; packed(width)]], length: FIRST_LENGTH, in_last: 0, rows: 0 }
    }

    /// Columns without the torque.
    pub(super) fn columns(&self) -> usize {
        self.width - 1
    }

    /// Adds a row.
    pub(super) fn add(&mut self, row: &[f64]) {
        if self.in_last == self.length {
            if self.blocks.len() == MOST_BLOCKS {
                self.merge();
            } else {
                self.blocks.push(vec![0.0; packed(self.width)]);
                self.in_last = 0;
            }
        }
        if let Some(last) = self.blocks.last_mut() {
            let mut slot = last.iter_mut();
            for (index, left) in row.iter().enumerate() {
                for (right, sum) in row[..=index].iter().zip(&mut slot) {
                    *sum += left * right;
                }
            }
        }
        self.in_last += 1;
        self.rows += 1;
    }

    fn merge(&mut self) {
        for index in 0..MOST_BLOCKS / 2 {
            let second = std::mem::take(&mut self.blocks[2 * index + 1]);
            let mut first = std::mem::take(&mut self.blocks[2 * index]);
            first.iter_mut().zip(&second).for_each(|(sum, value)| *sum += value);
            self.blocks[index] = first;
        }
        self.blocks.truncate(MOST_BLOCKS / 2);
        self.blocks.push(vec![0.0; packed(self.width)]);
        self.length *= 2;
        self.in_last = 0;
    }

    /// Solves with the first `columns` columns.
    pub(super) fn solve(&self, columns: usize) -> Option<Solution> {
        let mut map = DMatrix::zeros(columns + 1, self.width);
        (0..columns).for_each(|index| map[(index, index)] = 1.0);
        map[(columns, self.width - 1)] = 1.0;
        self.solve_mapped(&map)
    }

    /// Solves with columns that are sums of the stored ones: `map` has a row for each, and a last one for the torque.
    #[allow(clippy::cast_precision_loss, reason = "a number of rows")]
    pub(super) fn solve_mapped(&self, map: &DMatrix<f64>) -> Option<Solution> {
        let columns = map.nrows() - 1;
        let grams: Vec<DMatrix<f64>> =
            self.blocks.iter().map(|block| map * self.unpacked(block) * map.transpose()).collect();
        let total = grams.iter().fold(DMatrix::zeros(columns + 1, columns + 1), |sum, gram| sum + gram);
        if self.rows == 0 || total[(columns, columns)] <= 0.0 {
            return None;
        }
        let scales: Vec<f64> = (0..columns).map(|index| total[(index, index)].sqrt()).collect();
        let told = told(&total, &scales);
        let active: Vec<usize> = (0..columns).filter(|index| told[*index]).collect();
        let part = DMatrix::from_fn(active.len(), active.len(), |row, column| {
            total[(active[row], active[column])] / (scales[active[row]] * scales[active[column]])
        });
        let factor = Cholesky::new(part)?;
        let right = DVector::from_iterator(active.len(), active.iter().map(|i| total[(*i, columns)] / scales[*i]));
        let solved = factor.solve(&right);
        let mut coefficients = vec![0.0; columns];
        active.iter().zip(solved.iter()).for_each(|(index, value)| coefficients[*index] = value / scales[*index]);
        let inverse = factor.inverse();
        let mut full = DMatrix::zeros(columns, columns);
        for (row, at) in active.iter().enumerate() {
            for (column, other) in active.iter().enumerate() {
                full[(*at, *other)] = inverse[(row, column)] / (scales[*at] * scales[*other]);
            }
        }
        let beta = DVector::from_column_slice(&coefficients);
        let mut scatter = DMatrix::zeros(columns, columns);
        for gram in &grams {
            let score =
                gram.view((0, columns), (columns, 1)).into_owned() - gram.view((0, 0), (columns, columns)) * &beta;
            scatter += &score * score.transpose();
        }
        let freedom = grams.len() as f64 / grams.len().saturating_sub(active.len()).max(1) as f64;
        let explained: f64 = (0..columns).map(|index| coefficients[index] * total[(index, columns)]).sum();
        let rows = self.rows as f64;
        Some(Solution {
            covariance: &full * scatter * &full * freedom,
            told,
            column_rms: scales.iter().map(|scale| scale / rows.sqrt()).collect(),
            torque_rms: (total[(columns, columns)] / rows).sqrt(),
            residual_rms: ((total[(columns, columns)] - explained).max(0.0) / rows).sqrt(),
            rows: self.rows,
            blocks: grams.len(),
            coefficients,
        })
    }

    fn unpacked(&self, block: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(self.width, self.width, |row, column| {
            let (high, low) = if row >= column { (row, column) } else { (column, row) };
            block[packed(high) + low]
        })
    }
}

fn packed(width: usize) -> usize {
    width * (width + 1) / 2
}

/// Which columns are more than sums of earlier ones.
fn told(gram: &DMatrix<f64>, scales: &[f64]) -> Vec<bool> {
    let count = scales.len();
    let mut told = vec![false; count];
    let mut factor = DMatrix::<f64>::zeros(count, count);
    for row in 0..count {
        if scales[row] <= 0.0 {
            continue;
        }
        for column in 0..row {
            if told[column] {
                let sum: f64 = (0..column).map(|k| factor[(row, k)] * factor[(column, k)]).sum();
                let product = gram[(row, column)] / (scales[row] * scales[column]);
                factor[(row, column)] = (product - sum) / factor[(column, column)];
            }
        }
        let left = 1.0 - (0..row).map(|k| factor[(row, k)].powi(2)).sum::<f64>();
        told[row] = left > COLLINEAR;
        if told[row] {
            factor[(row, row)] = left.sqrt();
        } else {
            (0..row).for_each(|k| factor[(row, k)] = 0.0);
        }
    }
    told
}
