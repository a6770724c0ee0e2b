//! Smallest and largest values, and conditions on all values.

use super::LANES;

/// Smallest and largest value; `None` for no values.
pub(crate) fn extent(values: &[f64]) -> Option<(f64, f64)> {
    extent_of(
        values,
        values,
        #[inline(always)]
        |value, _| (value, value),
    )
}

/// Smallest and largest of the values whose weight is above zero; `None` for none.
pub(crate) fn extent_where(values: &[f64], weights: &[f64]) -> Option<(f64, f64)> {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    extent_of(
        values,
        weights,
        #[inline(always)]
        |value, weight| (if weight > 0.0 { value } else { none.0 }, if weight > 0.0 { value } else { none.1 }),
    )
}

/// The smallest difference between neighbours that differ; infinite for none.
pub(crate) fn smallest_step(values: &[f64]) -> f64 {
    let next = values.get(1..).unwrap_or_default();
    let steps = extent_of(
        &values[..next.len()],
        next,
        #[inline(always)]
        |left, right| {
            let step = (right - left).abs();
            (if step > 0.0 { step } else { f64::INFINITY }, step)
        },
    );
    steps.map_or(f64::INFINITY, |(least, _)| least)
}

/// Smallest first and largest second value that `of` gives for the pairs; `None` unless the first is at most the second.
#[inline(always)]
fn extent_of(left: &[f64], right: &[f64], of: impl Fn(f64, f64) -> (f64, f64)) -> Option<(f64, f64)> {
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    widest!({
        let (left, right) = (left.as_chunks::<LANES>(), right.as_chunks::<LANES>());
        for (left, right) in left.0.iter().zip(right.0) {
            for lane in 0..LANES {
                let (lower, upper) = of(left[lane], right[lane]);
                low[lane] = if lower < low[lane] { lower } else { low[lane] };
                high[lane] = if upper > high[lane] { upper } else { high[lane] };
            }
        }
        for (left, right) in left.1.iter().zip(right.1) {
            let (lower, upper) = of(*left, *right);
            (low[0], high[0]) = (low[0].min(lower), high[0].max(upper));
        }
    });
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
    (low <= high).then_some((low, high))
}

/// Whether all values are numbers and none is infinite.
pub(crate) fn all_finite(values: &[f64]) -> bool {
    widest!(values.iter().fold(true, |all, value| all & value.is_finite()))
}

/// Whether every value lies above the one before.
pub(crate) fn rises(values: &[f64]) -> bool {
    widest!(values.iter().zip(values.iter().skip(1)).fold(true, |all, (before, after)| all & (before < after)))
}
