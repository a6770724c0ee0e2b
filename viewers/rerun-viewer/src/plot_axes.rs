//! Axes of an x-y plot: round ranges, ticks, and the way from quantities to the drawing.
//!
//! rerun has no x-y plot. One is drawn in a plane instead: the plot's box is [`BOX_WIDTH`] by
//! [`BOX_HEIGHT`] with y downwards, whatever the quantities' units, so that it fills its view.

use report::numbers::fixed;

use crate::extent::Extent;

pub const BOX_WIDTH: f64 = 150.0;
pub const BOX_HEIGHT: f64 = 100.0;
/// Ticks that an axis has about.
const TARGET_TICKS: f64 = 6.0;

/// One axis: a range that ends on ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    pub low: f64,
    /// Above the lower end.
    pub high: f64,
    /// From tick to tick.
    pub step: f64,
}

impl Axis {
    /// The axis with round ends that shows `low..=high`.
    pub fn around(low: f64, high: f64) -> Self {
        let middle = f64::midpoint(low, high);
        // A range of nothing still needs a width, in proportion to the value it shows.
        let least = if high > low { (middle.abs() * 1e-6).max(1e-9) } else { (middle.abs() * 0.1).max(0.01) };
        let span = (high - low).max(least);
        let step = round_step(span / TARGET_TICKS);
        let low = ((middle - span / 2.0) / step).floor() * step;
        let high = ((middle + span / 2.0) / step).ceil() * step;
        Self { low, high, step }
    }

    /// The axis that is shown while it fits the range, else a new one: an axis that jumped about could not be read.
    pub fn following(shown: Option<Self>, [low, high]: Extent) -> Self {
        let fits = |axis: &Self| axis.low <= low && high <= axis.high && high - low > axis.span() / 2.0;
        shown.filter(fits).unwrap_or_else(|| Self::around(low, high))
    }

    /// The ticks with their labels, from low to high.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let decimals = (-self.step.log10().floor()).clamp(0.0, 9.0) as usize;
        let [first, last] = [self.low, self.high].map(|end| (end / self.step).round() as i64);
        (first..=last).map(|index| index as f64 * self.step).map(|value| (value, fixed(value, decimals))).collect()
    }

    pub fn span(&self) -> f64 {
        self.high - self.low
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotAxes {
    pub x: Axis,
    /// Vertical, upwards.
    pub y: Axis,
}

impl PlotAxes {
    /// Factors for (x, y) from quantities to the drawing.
    pub fn scale(&self) -> [f64; 2] {
        [BOX_WIDTH / self.x.span(), -BOX_HEIGHT / self.y.span()]
    }

    /// Where a pair of quantities lies in the drawing.
    pub fn place(&self, x: f64, y: f64) -> [f64; 2] {
        let [scale_x, scale_y] = self.scale();
        [(x - self.x.low) * scale_x, (y - self.y.high) * scale_y]
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`.
pub fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    // The tolerance keeps 0.2 a step for a span of exactly 1.2.
    let enough = |step: &f64| *step >= least * (1.0 - 1e-9);
    [1.0, 2.0, 5.0].map(|factor| factor * power).into_iter().find(enough).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ends_and_ticks_are_round_numbers_with_the_digits_they_need() {
        let axis = Axis::around(-4.3, 3.9);
        assert_eq!(labels(&axis), ["\u{2212}6", "\u{2212}4", "\u{2212}2", "0", "2", "4"]);
        assert_eq!(labels(&Axis::around(0.0, 0.12)).last().map(String::as_str), Some("0.12"));
    }

    #[test]
    fn an_axis_stays_while_the_data_fits() {
        let axis = Axis::around(-4.0, 4.0);
        assert_eq!(Axis::following(Some(axis), [-3.0, 3.9]), axis);
        assert!(Axis::following(Some(axis), [-3.0, 4.5]).high > axis.high);
        assert!(Axis::following(Some(axis), [-0.5, 0.5]).high < axis.high);
    }

    #[test]
    fn a_constant_still_has_an_axis() {
        let axis = Axis::around(5.0, 5.0);
        assert!(axis.low <= 5.0 && axis.high >= 5.0 && axis.high > axis.low);
        assert!(labels(&Axis::around(0.0, 0.0)).iter().all(|label| label.chars().count() <= 6));
    }

    #[test]
    fn the_corners_of_the_ranges_are_the_corners_of_the_box() {
        let axes = PlotAxes { x: Axis::around(-1.0, 1.0), y: Axis::around(-30.0, 60.0) };
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9;
        assert!(near(axes.place(axes.x.low, axes.y.high), [0.0, 0.0]));
        assert!(near(axes.place(axes.x.high, axes.y.low), [BOX_WIDTH, BOX_HEIGHT]));
    }
}
