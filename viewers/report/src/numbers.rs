//! Numbers as a reader should see them: no more digits than their intervals support.

/// Shown for what is not finite.
const UNKNOWN: &str = "–";
/// Digits after which a number without an uncertainty worth the name is cut.
const MOST_DIGITS: i32 = 9;
/// Magnitudes below this are shown with a power of ten.
const SMALLEST_PLAIN: f64 = 1e-4;

/// How the numbers of one quantity are written, so that value and interval line up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Digits {
    /// Decimals of the mantissa; negative ones round to tens, hundreds, …
    decimals: i32,
    /// Power of ten that is taken out.
    exponent: i32,
}

impl Digits {
    /// Digits down to the first digit of an interval's half width, or to its second digit if the first is a 1.
    pub(crate) fn of_interval(value: f64, half_width: f64) -> Self {
        if !(half_width > 0.0 && half_width.is_finite()) {
            return Self::significant(value, 6);
        }
        let start = order(half_width);
        let leading = half_width / 10_f64.powi(start);
        let place = if leading < 1.95 { start - 1 } else { start };
        Self::to_place(value.abs().max(half_width), place)
    }

    /// A given number of significant digits.
    pub(crate) fn significant(value: f64, digits: i32) -> Self {
        if value == 0.0 {
            return Self { decimals: 0, exponent: 0 };
        }
        Self::to_place(value.abs(), order(value) + 1 - digits)
    }

    fn to_place(magnitude: f64, place: i32) -> Self {
        let place = place.max(order(magnitude) - MOST_DIGITS);
        let exponent = if magnitude > 0.0 && magnitude < SMALLEST_PLAIN { order(magnitude) } else { 0 };
        Self { decimals: exponent - place, exponent }
    }

    /// The number without the power of ten.
    fn mantissa(self, value: f64) -> String {
        if !value.is_finite() {
            return UNKNOWN.to_owned();
        }
        let scaled = value / 10_f64.powi(self.exponent);
        let unit = 10_f64.powi(-self.decimals.min(0));
        let rounded = (scaled / unit).round() * unit;
        let rounded = if self.decimals < 0 { rounded } else { scaled };
        fixed(rounded, self.decimals.max(0).unsigned_abs() as usize)
    }

    fn power(self) -> String {
        if self.exponent == 0 { String::new() } else { format!("\u{a0}×\u{a0}10{}", superscript(self.exponent)) }
    }

    /// The number alone.
    pub(crate) fn show(self, value: f64) -> String {
        if value.is_finite() { format!("{}{}", self.mantissa(value), self.power()) } else { UNKNOWN.to_owned() }
    }

    /// Two ends of an interval.
    pub(crate) fn span(self, [low, high]: [f64; 2]) -> String {
        let (low, high) = (self.mantissa(low), self.mantissa(high));
        if self.exponent == 0 { format!("{low} … {high}") } else { format!("({low} … {high}){}", self.power()) }
    }

    /// A value with the half width of its interval.
    pub(crate) fn plus_minus(self, value: f64, half_width: f64) -> String {
        let (value, half_width) = (self.mantissa(value), self.mantissa(half_width));
        if self.exponent == 0 {
            format!("{value}\u{a0}±\u{a0}{half_width}")
        } else {
            format!("({value}\u{a0}±\u{a0}{half_width}){}", self.power())
        }
    }
}

/// Three significant digits, as for figures without an interval.
pub(crate) fn three(value: f64) -> String {
    Digits::significant(value, 3).show(value)
}

/// Two significant digits.
pub(crate) fn two(value: f64) -> String {
    Digits::significant(value, 2).show(value)
}

/// A number that somebody else printed, with no more digits than it needs.
pub(crate) fn printed(value: f64) -> String {
    if value.is_finite() { value.to_string().replace('-', "−") } else { UNKNOWN.to_owned() }
}

/// A whole number in groups of three.
#[must_use]
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A number with so many decimals and a true minus sign, which zero never has.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.chars().all(|letter| matches!(letter, '-' | '0' | '.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// Position of the first significant digit: 0 for ones, −1 for tenths.
fn order(value: f64) -> i32 {
    if value == 0.0 || !value.is_finite() {
        return 0;
    }
    value.abs().log10().floor() as i32
}

fn superscript(number: i32) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |letter: char| letter.to_digit(10).map_or('⁻', |digit| digits[digit as usize]);
    number.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_ends_where_its_interval_starts() {
        let shown = |value, half| Digits::of_interval(value, half).plus_minus(value, half).replace('\u{a0}', " ");
        assert_eq!(shown(0.035_123, 0.000_21), "0.0351 ± 0.0002");
        assert_eq!(shown(0.035_123, 0.000_14), "0.03512 ± 0.00014");
        assert_eq!(shown(-2.3456, 0.04), "−2.35 ± 0.04");
        assert_eq!(shown(1234.5, 30.0), "1230 ± 30");
        assert_eq!(shown(2.31e-6, 4.2e-8), "(2.31 ± 0.04) × 10⁻⁶");
    }

    #[test]
    fn what_is_not_finite_is_a_dash() {
        assert_eq!(three(f64::NAN), "–");
        assert_eq!(three(f64::INFINITY), "–");
    }

    #[test]
    fn a_rounded_zero_has_no_sign() {
        assert_eq!(Digits::of_interval(1.0, 0.5).show(-0.01), "0.0");
    }

    #[test]
    fn large_counts_are_grouped() {
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(count(999), "999");
    }
}
