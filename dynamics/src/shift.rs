//! A sampled signal at other times.

/// `values`, sampled at the rising times `time_s`, taken `ahead_s` after each of them.
///
/// A cubic through the four nearest samples; before the first and after the last sample their values are kept.
/// `values` should be as long as `time_s`; surplus elements of either are ignored.
#[must_use]
pub fn shifted(time_s: &[f64], values: &[f64], ahead_s: f64) -> Vec<f64> {
    let count = time_s.len().min(values.len());
    let (time_s, values) = (&time_s[..count], &values[..count]);
    if ahead_s == 0.0 {
        return values.to_vec();
    }
    let mut next = 0;
    let at = |time: &f64| {
        let at_s = time + ahead_s;
        while next < count && time_s[next] <= at_s {
            next += 1;
        }
        match next {
            0 => values[0],
            next if next == count => values[count - 1],
            next => {
                let first = next.saturating_sub(2);
                let last = (next + 2).min(count);
                lagrange(&time_s[first..last], &values[first..last], at_s)
            }
        }
    };
    time_s.iter().map(at).collect()
}

/// The polynomial through all points, at `at_s`.
fn lagrange(time_s: &[f64], values: &[f64], at_s: f64) -> f64 {
    let weight = |index: usize| -> f64 {
        let others = time_s.iter().enumerate().filter(|(other, _)| *other != index);
        others.map(|(_, time)| (at_s - time) / (time_s[index] - time)).product()
    };
    values.iter().enumerate().map(|(index, value)| value * weight(index)).sum()
}
