//! The smallest and the largest of some values.

/// The smallest, then the largest.
pub type Extent = (f64, f64);

/// That of no values.
pub const NOTHING: Extent = (f64::INFINITY, f64::NEG_INFINITY);

/// That of one value more; one that is not a number leaves no trace.
pub const fn with((low, high): Extent, value: f64) -> Extent {
    (low.min(value), high.max(value))
}

/// That of all values, if there are any.
pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Extent> {
    let (low, high) = values.into_iter().fold(NOTHING, with);
    (low <= high).then_some((low, high))
}
