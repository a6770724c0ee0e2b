//! The model's torque, averaged over narrow ranges of a quantity.

use identification::Point;
use identification::statistics::range;

use super::real;

/// Fewest rows in a bin that is shown.
const FEWEST_ROWS: usize = 2;

/// Mean of the rows in a range.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bin {
    /// Mean of the quantity.
    pub(super) at: f64,
    /// Mean torque of the model, mNm.
    pub(super) model_mnm: f64,
    /// Mean half width of the model's 95 % interval, mNm.
    pub(super) half_width_mnm: f64,
    rows: usize,
}

/// A moving average over bins that lie within `width` of each other, as one run.
pub(super) fn smoothed(runs: &[Vec<Bin>], width: f64) -> Vec<Bin> {
    let bins: Vec<Bin> = runs.iter().flatten().copied().collect();
    let average = |centre: &Bin| {
        let weight = |bin: &Bin| real(bin.rows) * (1.0 - (bin.at - centre.at).abs() / width).max(0.0);
        let total: f64 = bins.iter().map(weight).sum();
        let mean = |of: fn(&Bin) -> f64| bins.iter().map(|bin| weight(bin) * of(bin)).sum::<f64>() / total;
        Bin { model_mnm: mean(|bin| bin.model_mnm), half_width_mnm: mean(|bin| bin.half_width_mnm), ..*centre }
    };
    bins.iter().map(average).filter(|bin| bin.model_mnm.is_finite()).collect()
}

impl Bin {
    fn mean(self) -> Self {
        let rows = real(self.rows);
        Self {
            at: self.at / rows,
            model_mnm: self.model_mnm / rows,
            half_width_mnm: self.half_width_mnm / rows,
            rows: self.rows,
        }
    }
}

/// Bins of equal width over `of`, at most `most` and of `rows_each` on average; runs end where a bin has too few rows.
pub(super) fn runs<'a>(
    points: impl Iterator<Item = &'a Point> + Clone,
    of: fn(&Point) -> f64,
    most: usize,
    rows_each: usize,
) -> Vec<Vec<Bin>> {
    let values = points.clone().map(of);
    let [low, high] = range(values.clone());
    let count = (values.count() / rows_each).clamp(1, most);
    let mut bins = vec![Bin::default(); count];
    for point in points {
        let share = if high > low { (of(point) - low) / (high - low) } else { 0.0 };
        let bin = &mut bins[((share * real(count)) as usize).min(count - 1)];
        bin.at += of(point);
        bin.model_mnm += point.torque_model_mnm;
        bin.half_width_mnm += point.torque_model_ci95_mnm;
        bin.rows += 1;
    }
    bins.split(|bin| bin.rows < FEWEST_ROWS)
        .filter(|run| !run.is_empty())
        .map(|run| run.iter().map(|bin| bin.mean()).collect())
        .collect()
}
