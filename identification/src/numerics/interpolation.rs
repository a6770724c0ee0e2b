//! Values between samples, from cubic polynomials.

/// The samples from one before a place to two after it, between which its value is interpolated.
pub(crate) const NEIGHBOURS: [f64; 4] = [-1.0, 0.0, 1.0, 2.0];

/// Lagrange's weights: at `at`, the cubic through the values at four `places` is the weighted sum of these values.
pub(crate) fn cubic_weights(places: [f64; 4], at: f64) -> [f64; 4] {
    let others = |one: f64| places.into_iter().filter(move |other| *other != one);
    let product = |from: f64, one: f64| others(one).map(|other| from - other).product::<f64>();
    places.map(|one| product(at, one) / product(one, one))
}

/// The signal `shift` samples later, interpolated by cubic polynomials; the ends are held.
pub(crate) fn advance(signal: &[f64], shift: f64) -> Vec<f64> {
    if shift == 0.0 || signal.is_empty() {
        return signal.to_vec();
    }
    let whole = shift.floor();
    let part = shift - whole;
    let last = signal.len() as isize - 1;
    let at = |index: isize| signal[index.clamp(0, last) as usize];
    let weights = cubic_weights(NEIGHBOURS, part);
    (0..signal.len() as isize)
        .map(|index| {
            let base = index + whole as isize;
            weights.iter().zip(-1..).map(|(weight, offset)| weight * at(base + offset)).sum()
        })
        .collect()
}
