//! The smallest and the largest of some values.

/// The smallest, then the largest.
pub type Extent = (f64, f64);

/// The extent of no values.
pub const NOTHING: Extent = (f64::INFINITY, f64::NEG_INFINITY);

/// The extent with one more value; NaN is ignored.
pub const fn with((low, high): Extent, value: f64) -> Extent {
    (low.min(value), high.max(value))
}

/// The extent of all values; `None` if there are none.
pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Extent> {
    let (low, high) = values.into_iter().fold(NOTHING, with);
    (low <= high).then_some((low, high))
}
