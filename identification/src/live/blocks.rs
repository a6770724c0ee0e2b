//! Rows of a stream, and Gram matrices of blocks of them: all that least squares and its intervals need, in bounded memory.

use nalgebra::{DMatrix, DVectorView};

use crate::detents::angle_bins::MOST_COLUMNS;
use crate::numerics::statistics::student_95;
use crate::preparation::filter::Fir;
use crate::regression::gram;

/// Most blocks; when they are full, neighbours merge.
const MOST_BLOCKS: usize = 128;
/// Rows of the first blocks.
const FIRST_LENGTH: u64 = 16;
/// A column of which less than this share remains beside the others cannot be estimated.
const COLLINEAR: f64 = 1e-7;

/// The Gram matrices of consecutive blocks of rows; the first column of a row is the torque.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    blocks: Vec<DMatrix<f64>>,
    length: u64,
    in_last: u64,
    rows: u64,
}

/// Coefficients from the blocks.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    /// One per column; zero where it could not be estimated.
    pub(super) coefficients: Vec<f64>,
    /// Covariance of the coefficients from the scatter of the blocks.
    pub(super) covariance: DMatrix<f64>,
    /// Whether each column could be estimated from the others.
    pub(super) is_fitted: Vec<bool>,
    /// RMS of each column over the rows.
    pub(super) column_rms: Vec<f64>,
    pub(super) torque_rms: f64,
    pub(super) residual_rms: f64,
    pub(super) blocks: usize,
}

impl Solution {
    /// Ratio of the half width of a 95 % interval to the standard deviation from the blocks' scatter.
    pub(super) fn critical(&self) -> f64 {
        student_95(self.blocks as f64 - 1.0)
    }
}

impl Blocks {
    pub(super) fn new(width: usize) -> Self {
        Self { blocks: vec![DMatrix::zeros(width, width)], length: FIRST_LENGTH, in_last: 0, rows: 0 }
    }

    fn width(&self) -> usize {
        self.blocks[0].nrows()
    }

    /// Columns without the torque.
    pub(super) fn columns(&self) -> usize {
        self.width() - 1
    }

    pub(super) fn add(&mut self, row: &[f64]) {
        if self.in_last == self.length {
            if self.blocks.len() == MOST_BLOCKS {
                self.blocks = self.blocks.chunks_exact(2).map(|pair| &pair[0] + &pair[1]).collect();
                self.length *= 2;
            }
            self.blocks.push(DMatrix::zeros(self.width(), self.width()));
            self.in_last = 0;
        }
        if let Some(last) = self.blocks.last_mut() {
            let row = DVectorView::from_slice(row, row.len());
            last.ger(1.0, &row, &row, 1.0);
        }
        self.in_last += 1;
        self.rows += 1;
    }

    /// Solves with the first `columns` columns.
    pub(super) fn solve(&self, columns: usize) -> Option<Solution> {
        self.solve_mapped(&DMatrix::identity(columns + 1, self.width()))
    }

    /// Solves with columns that are sums of the stored ones: `map` has a first row for the torque, and one for each.
    pub(super) fn solve_mapped(&self, map: &DMatrix<f64>) -> Option<Solution> {
        let columns = map.nrows() - 1;
        let blocks: Vec<DMatrix<f64>> = self.blocks.iter().map(|block| map * block * map.transpose()).collect();
        let total = gram::sum(blocks.iter(), columns + 1);
        if self.rows == 0 || total[(0, 0)] <= 0.0 {
            return None;
        }
        let all: Vec<usize> = (0..columns).collect();
        let solved = gram::solve(&total, &all, COLLINEAR)?;
        let rows = self.rows as f64;
        let rms = |squares: f64| (squares.max(0.0) / rows).sqrt();
        Some(Solution {
            covariance: solved.covariance_over(&blocks),
            is_fitted: (0..columns).map(|column| solved.fitted.contains(&column)).collect(),
            column_rms: (1..=columns).map(|index| rms(total[(index, index)])).collect(),
            torque_rms: rms(total[(0, 0)]),
            residual_rms: rms(solved.squares(&total)),
            blocks: blocks.len(),
            coefficients: solved.coefficients,
        })
    }
}

/// A low-pass with decimation, over several columns at once, sample by sample.
#[derive(Clone, Debug)]
pub(super) struct RowFilter {
    fir: Fir,
    step: usize,
    pub(super) width: usize,
    /// Ring of the last samples, each with its columns side by side; stored twice, so that the samples always form one slice.
    history: Vec<f64>,
    next: usize,
    since_row: usize,
    /// Number of unmasked samples in the history.
    unmasked: usize,
    mask: Vec<bool>,
    row: [f64; MOST_COLUMNS],
}

impl RowFilter {
    /// A low-pass that keeps every `step`-th sample.
    pub(super) fn new(fir: Fir, step: usize, width: usize) -> Self {
        let length = fir.taps().len();
        Self {
            fir,
            step,
            width,
            history: vec![0.0; 2 * length * width],
            next: 0,
            since_row: 0,
            unmasked: 0,
            mask: vec![false; length],
            row: [0.0; MOST_COLUMNS],
        }
    }

    /// Forgets the history: what follows does not continue it.
    pub(super) fn restart(&mut self) {
        self.history.fill(0.0);
        self.mask.fill(false);
        self.unmasked = 0;
        self.since_row = 0;
    }

    /// Takes one sample (zeros if masked). Returns a row every `step` samples, unless the whole history is masked; else `None`.
    pub(super) fn push(&mut self, sample: &[f64], unmasked: bool) -> Option<&[f64]> {
        let length = self.mask.len();
        for copy in [self.next, self.next + length] {
            self.history[copy * self.width..(copy + 1) * self.width].copy_from_slice(&sample[..self.width]);
        }
        self.unmasked = self.unmasked + usize::from(unmasked) - usize::from(self.mask[self.next]);
        self.mask[self.next] = unmasked;
        self.next = (self.next + 1) % length;
        self.since_row += 1;
        if self.since_row < self.step {
            return None;
        }
        self.since_row = 0;
        if self.unmasked == 0 {
            return None;
        }
        let row = &mut self.row[..self.width];
        row.fill(0.0);
        let oldest = &self.history[self.next * self.width..(self.next + length) * self.width];
        for (sample, tap) in oldest.chunks_exact(self.width).zip(self.fir.taps()) {
            row.iter_mut().zip(sample).for_each(|(sum, value)| *sum += tap * value);
        }
        Some(&self.row[..self.width])
    }
}
