//! The smallest and the largest of some values.

use identification::statistics;

/// The smallest, then the largest.
pub type Extent = [f64; 2];

/// The extent of all values; `None` if there are none. NaN is ignored.
pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Extent> {
    Some(statistics::range(values)).filter(|[low, high]| low <= high)
}
