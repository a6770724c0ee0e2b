//! Sums over blocks of rows that grow in length, not in number: all that least squares and its intervals need, in bounded memory.

use nalgebra::DMatrix;

use crate::regression::{Blocks, Gram, Solution};

/// Most columns of a row, torque included.
pub(super) const MOST_COLUMNS: usize = 16;
/// Most blocks; when they are full, neighbours merge.
const MOST_BLOCKS: usize = 128;
/// Rows of the first blocks.
const FIRST_LENGTH: u64 = 16;

/// Sums over consecutive blocks of rows.
#[derive(Clone, Debug)]
pub(super) struct GrowingBlocks {
    columns: usize,
    blocks: Blocks,
    length: u64,
    in_last: u64,
    rows: u64,
}

/// Coefficients from the blocks.
#[derive(Clone, Debug)]
pub(super) struct BlockFit {
    pub(super) solution: Solution,
    /// Covariance of the coefficients from the scatter of the blocks.
    pub(super) covariance: DMatrix<f64>,
    /// RMS of each column over the rows.
    pub(super) column_rms: Vec<f64>,
    pub(super) torque_rms: f64,
    pub(super) residual_rms: f64,
    pub(super) rows: u64,
    pub(super) blocks: usize,
}

impl GrowingBlocks {
    pub(super) fn new(columns: usize) -> Self {
        Self { columns, blocks: Blocks(vec![Gram::empty(columns)]), length: FIRST_LENGTH, in_last: 0, rows: 0 }
    }

    /// Columns without the torque.
    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// Adds a row: the torque, then the columns.
    pub(super) fn add(&mut self, row: &[f64]) {
        let Blocks(blocks) = &mut self.blocks;
        if self.in_last == self.length {
            if blocks.len() == MOST_BLOCKS {
                *blocks = blocks
                    .chunks(2)
                    .map(|pair| {
                        pair.iter().skip(1).fold(pair[0].clone(), |mut sum, block| {
                            sum += block;
                            sum
                        })
                    })
                    .collect();
                self.length *= 2;
            }
            blocks.push(Gram::empty(self.columns));
            self.in_last = 0;
        }
        if let Some(last) = blocks.last_mut() {
            last.add_row(row);
        }
        self.in_last += 1;
        self.rows += 1;
    }

    /// Solves with the first `columns` columns.
    pub(super) fn solve(&self, columns: usize) -> Option<BlockFit> {
        self.solve_mapped(&DMatrix::identity(columns, self.columns))
    }

    /// Solves with columns that are sums of the stored ones, a row of `map` for each; `None` without torque.
    pub(super) fn solve_mapped(&self, map: &DMatrix<f64>) -> Option<BlockFit> {
        let blocks = Blocks(self.blocks.0.iter().map(|block| block.mapped(map)).collect());
        let total = blocks.total();
        if self.rows == 0 || total.total() <= 0.0 {
            return None;
        }
        let solution = total.solve();
        let mean_root = |square: f64| (square / self.rows as f64).sqrt();
        Some(BlockFit {
            covariance: blocks.covariance(&solution, solution.fitted().len()),
            column_rms: (0..map.nrows()).map(|column| mean_root(total.square(column))).collect(),
            torque_rms: mean_root(total.total()),
            residual_rms: mean_root(total.left(&solution.coefficients)),
            rows: self.rows,
            blocks: blocks.0.len(),
            solution,
        })
    }
}

impl BlockFit {
    /// Degrees of freedom with which the covariance is known.
    pub(super) fn degrees_of_freedom(&self) -> f64 {
        self.blocks.saturating_sub(self.solution.fitted().len()) as f64
    }
}
