//! Numbers as they are written in texts.

use identification::statistics::digits;
pub use report::numbers::count as grouped;
use report::numbers::fixed;
use shared_types::Estimate;

use crate::extent::Extent;
use crate::model_torque::finite_value;

/// `2.301 ± 0.012`, with as many digits as the interval deserves; a dash until it is identified.
pub fn value_and_interval(estimate: &Estimate) -> String {
    let value = finite_value(estimate);
    value.map_or_else(|| "\u{2013}".to_owned(), |value| with_half_width(value, estimate.half_width()))
}

/// Power of ten below which a number is written with it.
const SMALL_POWER: i32 = -3;

/// `2.301 ± 0.012`, with two digits of the half width; `(3.99 ± 0.03)e−6` of what is small.
pub fn with_half_width(value: f64, half_width: f64) -> String {
    let power = value.abs().max(half_width).log10().floor() as i32;
    if (-30..SMALL_POWER).contains(&power) {
        let scale = 10_f64.powi(power);
        return format!("({})e\u{2212}{}", with_half_width(value / scale, half_width / scale), -power);
    }
    if !half_width.is_finite() || half_width <= 0.0 {
        return fixed(value, 4);
    }
    format!("{} ± {}", fixed(value, digits(half_width)), fixed(half_width, digits(half_width)))
}

/// A number with about three digits that count.
pub fn three_digits(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 3.0) as usize;
    fixed(value, decimals)
}

/// A parameter with three digits that count; `3.99e−6` of what is small.
pub fn three_figures(value: f64) -> String {
    let power = value.abs().log10().floor() as i32;
    match power {
        -30..SMALL_POWER => format!("{}e\u{2212}{}", three_figures(value / 10_f64.powi(power)), -power),
        SMALL_POWER..0 => fixed(value, (2 - power).unsigned_abs() as usize),
        _ => three_digits(value),
    }
}

/// A count that should be zero.
pub fn alarmed(count: u64) -> String {
    if count == 0 { "0".to_owned() } else { format!("**{}**", grouped(count)) }
}

/// The smallest and the largest value of each signal as a table in Markdown; nothing where there is no value.
pub fn ranges(of: &str, ranges: impl IntoIterator<Item = (&'static str, Option<Extent>)>) -> String {
    let row = |(signal, range): (&str, Option<Extent>)| {
        let [low, high] = range?.map(three_digits);
        Some(format!("| {signal} | {low} | {high} |\n"))
    };
    let rows: String = ranges.into_iter().filter_map(row).collect();
    if rows.is_empty() { rows } else { format!("| {of} | from | to |\n|---|---:|---:|\n{rows}\n") }
}

#[cfg(test)]
mod tests {
    use shared_types::Convergence;

    use super::*;
    use crate::model_torque::tests::estimated;

    #[test]
    fn a_value_has_two_digits_of_its_interval_and_a_small_one_its_power_of_ten() {
        let enough = |value, half_width| estimated(value, half_width, Convergence::Converged);
        assert_eq!(value_and_interval(&enough(2.301_234, 0.012_4)), "2.301 ± 0.012");
        assert_eq!(value_and_interval(&enough(-0.035, 0.000_21)), "\u{2212}0.03500 ± 0.00021");
        for not_identified in [Estimate { value: 5.0, ..Estimate::default() }, enough(f64::NAN, 1.0)] {
            assert_eq!(value_and_interval(&not_identified), "\u{2013}");
        }
        assert_eq!(with_half_width(3.986e-6, 3e-8), "(3.986 \u{b1} 0.030)e\u{2212}6");
    }

    #[test]
    fn a_range_has_three_digits() {
        assert_eq!(three_digits(-1e-5), "0.000");
        assert_eq!([0.299_9, -3.456, 98.76, 12_345.6].map(three_digits), ["0.300", "\u{2212}3.46", "98.8", "12346"]);
    }

    #[test]
    fn a_parameter_has_three_figures() {
        let written = [0.0, 0.0019, -0.07, 3.986e-6, 12.34].map(three_figures);
        assert_eq!(written, ["0.000", "0.00190", "\u{2212}0.0700", "3.99e\u{2212}6", "12.3"]);
    }
}
