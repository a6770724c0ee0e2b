//! Rings: the last few values of a stream, and the filter that turns masked samples into rows.

use super::blocks::MOST_COLUMNS;
use crate::preparation::filter::Fir;
use crate::preparation::motion::ROWS_PER_EDGE;
use crate::preparation::uniform::whole;

/// The last values of a stream, addressed by their count since the start.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    values: Vec<f64>,
}

impl Ring {
    /// Room for at least `length` values.
    pub(super) fn new(length: usize) -> Self {
        Self { values: vec![0.0; length.next_power_of_two()] }
    }

    pub(super) fn set(&mut self, index: usize, value: f64) {
        let place = index & (self.values.len() - 1);
        self.values[place] = value;
    }

    pub(super) fn get(&self, index: usize) -> f64 {
        self.values[index & (self.values.len() - 1)]
    }
}

/// The common low-pass and decimation, over several columns at once.
#[derive(Clone, Debug)]
pub(super) struct RowFilter {
    fir: Fir,
    step: usize,
    width: usize,
    /// The last samples, column by column after each other in a row, twice over so that they lie in one piece.
    history: Vec<f64>,
    next: usize,
    since_row: usize,
    /// Whether any unmasked sample is in the history.
    unmasked: usize,
    mask: Vec<bool>,
    row: [f64; MOST_COLUMNS],
}

impl RowFilter {
    pub(super) fn new(rate_hz: f64, band_hz: f64, width: usize) -> Self {
        let half_length = (1.65 * rate_hz / band_hz).round() as usize;
        let length = 2 * half_length + 1;
        Self {
            fir: Fir::low_pass(half_length, band_hz, rate_hz),
            step: whole(rate_hz / (ROWS_PER_EDGE * band_hz)).max(1),
            width,
            history: vec![0.0; 2 * length * width],
            next: 0,
            since_row: 0,
            unmasked: 0,
            mask: vec![false; length],
            row: [0.0; MOST_COLUMNS],
        }
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// Forgets the history: what follows does not continue it.
    pub(super) fn restart(&mut self) {
        self.history.fill(0.0);
        self.mask.fill(false);
        self.unmasked = 0;
        self.since_row = 0;
    }

    /// Takes one sample (zeros if masked) and gives a row every `step` samples unless all it sees is masked.
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
