//! The axis of a forest plot: linear, or logarithmic where values lie powers of ten apart.

use identification::statistics::range;

use crate::numbers::printed;
use crate::plot::Axis;

/// Largest over smallest value from which on a linear axis would crowd the small ones.
const FAR_APART: f64 = 20.0;
/// Round values along a linear axis.
const TICKS: usize = 5;
/// Decades up to which 2 and 5 have ticks too.
const FEW_DECADES: f64 = 2.6;

/// Where values lie along the axis.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    /// The axis of the values, or of their common logarithms.
    axis: Axis,
    /// The ends in powers of ten; `None` on a linear axis.
    decades: Option<[f64; 2]>,
    /// Whether zero lies among the values.
    spans_zero: bool,
}

impl Scale {
    /// The scale that suits all finite `values`.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let [low, high] = range(&values);
        let spans_zero = low < 0.0 && high > 0.0;
        if low > 0.0 && high > FAR_APART * low {
            let decades = [low.log10(), high.log10()];
            return Self { axis: Axis::around("", decades), decades: Some(decades), spans_zero };
        }
        Self { axis: Axis::around("", values), decades: None, spans_zero }
    }

    /// Place of a value along the axis, from 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        self.axis.share(if self.decades.is_some() { value.log10() } else { value })
    }

    /// Whether the axis is logarithmic.
    pub(super) fn is_logarithmic(&self) -> bool {
        self.decades.is_some()
    }

    /// Zero, where values of both signs lie about it.
    pub(super) fn zero(&self) -> Option<f64> {
        self.spans_zero.then_some(0.0)
    }

    /// Round values on the axis with what to write at them.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let Some([low, high]) = self.decades else { return self.axis.ticks(TICKS) };
        let steps: &[f64] = if high - low < FEW_DECADES { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let powers = low.floor() as i32..=high.ceil() as i32;
        powers
            .flat_map(|power| steps.iter().map(move |step| rounded(*step, power)))
            .filter(|tick| (0.0..=1.0).contains(&self.share(*tick)))
            .map(|tick| (tick, printed(tick)))
            .collect()
    }
}

/// A power of ten times a digit as its shortest decimal number.
fn rounded(digit: f64, power: i32) -> f64 {
    format!("{digit}e{power}").parse().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_powers_of_ten_apart_lie_on_a_logarithmic_axis() {
        let scale = Scale::around([0.0019, 0.035, 0.28].into_iter());
        assert!(scale.is_logarithmic());
        let labels: Vec<String> = scale.ticks().into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["0.002", "0.005", "0.01", "0.02", "0.05", "0.1", "0.2"]);
        assert!((scale.share((0.0019_f64 * 0.28).sqrt()) - 0.5).abs() < 1e-9);
    }

    #[test]
    fn values_of_both_signs_lie_on_a_linear_axis() {
        let scale = Scale::around([-4.5, 0.01, 4.7].into_iter());
        assert!(!scale.is_logarithmic());
        assert_eq!(scale.zero(), Some(0.0));
    }
}
