//! Torque over angle and torque over velocity: the newest points, and the model's curves.

use std::collections::VecDeque;

use crate::extent;
use crate::model_curves::{self, ModelCurves};
use crate::model_torque::KnobModel;
use crate::plot_axes::{Axis, PlotAxes};
use crate::source::Reading;

/// Points a second: more in 10 s would lie over each other.
const RATE_HZ: f64 = 200.0;
/// Points whose range the axes show: 10 s.
const POINTS: usize = 2_000;
/// Points for the whole of a finished capture.
const WHOLE_POINTS: usize = 8_000;

/// Which quantity the torque is plotted over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Abscissa {
    Angle,
    Velocity,
}

impl Abscissa {
    /// Title of the horizontal axis: the sample's field.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Angle => "angle_rad",
            Self::Velocity => "velocity_rad_s",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterPoint {
    pub x: f64,
    pub torque_mnm: f64,
    /// Whether the knob turned towards positive angle.
    pub turning_positive: bool,
}

/// Points, axes and curves of one plot at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotUpdate {
    pub abscissa: Abscissa,
    /// Points since the last update.
    pub points: Vec<ScatterPoint>,
    /// Axes that hold the newest points.
    pub axes: PlotAxes,
    /// The model, when it is its turn.
    pub model: Option<ModelCurves>,
}

/// Gathers both plots.
#[derive(Debug)]
pub struct Scatters {
    plots: [Scatter; 2],
    /// Share of a finished capture's samples that is shown.
    whole_share: Option<f64>,
    phase: f64,
}

/// Those of a run.
impl Default for Scatters {
    fn default() -> Self {
        Self::new(POINTS, None)
    }
}

impl Scatters {
    /// Those of a finished capture of so many samples.
    pub fn of_capture(samples: usize) -> Self {
        Self::new(WHOLE_POINTS, Some((WHOLE_POINTS as f64 / samples.max(1) as f64).min(1.0)))
    }

    fn new(capacity: usize, whole_share: Option<f64>) -> Self {
        let plots = [Abscissa::Angle, Abscissa::Velocity].map(|abscissa| Scatter::new(abscissa, capacity));
        Self { plots, whole_share, phase: 0.0 }
    }

    /// Takes in what was measured, at that rate in a run.
    pub fn push(&mut self, reading: &Reading, rate_hz: Option<f64>) {
        let of_run = rate_hz.map_or(1.0, |rate_hz| RATE_HZ / rate_hz);
        self.phase += self.whole_share.unwrap_or(of_run);
        if self.phase >= 1.0 {
            self.phase = self.phase.fract();
            let Reading { angle_rad, velocity_rad_s, torque_mnm, turning_positive, .. } = *reading;
            for (plot, x) in self.plots.iter_mut().zip([angle_rad, velocity_rad_s]) {
                plot.push(ScatterPoint { x, torque_mnm, turning_positive });
            }
        }
    }

    /// What is new in the plots: points, and the curves of a new `model`.
    pub fn update(&mut self, model: Option<&KnobModel>) -> Vec<PlotUpdate> {
        self.plots.iter_mut().filter_map(|plot| plot.update(model)).collect()
    }
}

#[derive(Debug)]
struct Scatter {
    abscissa: Abscissa,
    /// The newest points, at most so many.
    kept: VecDeque<ScatterPoint>,
    capacity: usize,
    /// How many of them are new.
    fresh: usize,
    axes: Option<PlotAxes>,
}

impl Scatter {
    fn new(abscissa: Abscissa, capacity: usize) -> Self {
        Self { abscissa, kept: VecDeque::with_capacity(capacity), capacity, fresh: 0, axes: None }
    }

    /// Takes in a point; one that is not a number leaves no trace.
    fn push(&mut self, point: ScatterPoint) {
        if !(point.x.is_finite() && point.torque_mnm.is_finite()) {
            return;
        }
        if self.kept.len() >= self.capacity {
            self.kept.pop_front();
        }
        self.kept.push_back(point);
        // A burst, as after a restart, shows its newest points only.
        self.fresh = (self.fresh + 1).min(self.capacity);
    }

    fn update(&mut self, model: Option<&KnobModel>) -> Option<PlotUpdate> {
        if self.fresh == 0 && model.is_none() {
            return None;
        }
        let extent = |of: fn(&ScatterPoint) -> f64| extent::of(self.kept.iter().map(of));
        let (x, y) = (extent(|point| point.x)?, extent(|point| point.torque_mnm)?);
        let [shown_x, shown_y] = [self.axes.map(|axes| axes.x), self.axes.map(|axes| axes.y)];
        let axes = PlotAxes { x: Axis::following(shown_x, x), y: Axis::following(shown_y, y) };
        self.axes = Some(axes);
        let model = model.map(|model| {
            let mut drawn = match self.abscissa {
                Abscissa::Angle => model_curves::torque_over_angle(model, x),
                Abscissa::Velocity => model_curves::torque_over_velocity(model, x),
            };
            for curves in [&mut drawn.curves, &mut drawn.borders] {
                // A direction whose friction is not identified has no curve.
                curves.retain(|curve| curve.iter().all(|point| point[1].is_finite()));
                // A model that is far off runs along the frame, not across the neighbouring views.
                curves.iter_mut().flatten().for_each(|point| point[1] = point[1].clamp(axes.y.low, axes.y.high));
            }
            drawn
        });
        let fresh = std::mem::take(&mut self.fresh);
        let points = self.kept.range(self.kept.len() - fresh..).copied().collect();
        Some(PlotUpdate { abscissa: self.abscissa, points, axes, model })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_of_history_stays_bounded_and_the_axes_forget_points_that_are_no_longer_shown() {
        let mut scatter = Scatter::new(Abscissa::Angle, POINTS);
        for index in 0..3 * POINTS {
            let torque_mnm = if index < POINTS { 1e6 } else { (index % 7) as f64 };
            scatter.push(ScatterPoint { x: index as f64, torque_mnm, turning_positive: true });
        }
        let update = scatter.update(None).unwrap();
        assert_eq!(update.points.len(), POINTS);
        assert!(update.axes.y.high < 10.0);
    }
}
