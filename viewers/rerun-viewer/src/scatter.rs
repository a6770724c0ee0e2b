//! Torque over angle and torque over velocity: the newest points, and the model's curves.

use std::collections::VecDeque;

use crate::extent::{self, Extent};
use crate::model_torque::KnobModel;
use crate::plot_axes::{Axis, PlotAxes};
use crate::source::Reading;

/// Points a second: more in 10 s would lie over each other.
const RATE_HZ: f64 = 200.0;
/// Points whose range the axes show: 10 s.
const POINTS: usize = 2_000;
/// Points for the whole of a finished capture.
const WHOLE_POINTS: usize = 8_000;
/// Points of a curve that has no detents to resolve.
const CURVE_POINTS: usize = 121;
/// Points per detent of a curve that has.
const POINTS_PER_DETENT: f64 = 16.0;
/// Most points of a curve.
const MAX_CURVE_POINTS: f64 = 2_000.0;

/// Which quantity the torque is plotted over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Abscissa {
    /// Angle, rad.
    Angle,
    /// Velocity, rad/s.
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

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterPoint {
    /// The abscissa.
    pub x: f64,
    /// Torque, mNm.
    pub torque_mnm: f64,
    /// Whether the knob turned towards positive angle.
    pub turning_positive: bool,
}

/// Points, axes and curves of one plot at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotUpdate {
    /// Which plot.
    pub abscissa: Abscissa,
    /// Points since the last update.
    pub points: Vec<ScatterPoint>,
    /// Axes that hold the newest points.
    pub axes: PlotAxes,
    /// The model, when it is its turn.
    pub model: Option<ModelCurves>,
}

/// The model in a plot: curves as (x, torque).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelCurves {
    /// The model itself.
    pub curves: Vec<Curve>,
    /// Lower and upper ends of its 95 % interval.
    pub borders: Vec<Curve>,
    /// Mean half width of the interval, mNm; `None` where nothing is identified.
    pub half_width_mnm: Option<f64>,
}

/// Points as (x, torque).
pub type Curve = Vec<[f64; 2]>;

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
        Self { plots: both(POINTS), whole_share: None, phase: 0.0 }
    }
}

fn both(capacity: usize) -> [Scatter; 2] {
    [Abscissa::Angle, Abscissa::Velocity].map(|abscissa| Scatter::new(abscissa, capacity))
}

impl Scatters {
    /// Those of a finished capture of so many samples.
    #[allow(clippy::cast_precision_loss, reason = "a share")]
    pub fn of_capture(samples: usize) -> Self {
        let share = (WHOLE_POINTS as f64 / samples.max(1) as f64).min(1.0);
        Self { plots: both(WHOLE_POINTS), whole_share: Some(share), phase: 0.0 }
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

/// Gathers one plot.
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
        self.fresh = if self.fresh >= self.capacity { 1 } else { self.fresh + 1 };
    }

    fn update(&mut self, model: Option<&KnobModel>) -> Option<PlotUpdate> {
        if self.fresh == 0 && model.is_none() {
            return None;
        }
        let (x, y) = (
            extent::of(self.kept.iter().map(|point| point.x))?,
            extent::of(self.kept.iter().map(|point| point.torque_mnm))?,
        );
        let shown = self.axes;
        let axes = PlotAxes {
            x: Axis::following(shown.map(|axes| axes.x), x),
            y: Axis::following(shown.map(|axes| axes.y), y),
        };
        self.axes = Some(axes);
        let model = model.map(|model| {
            let mut drawn = match self.abscissa {
                Abscissa::Angle => torque_over_angle(model, x),
                Abscissa::Velocity => torque_over_velocity(model, x),
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

/// Two curves: the knob turning slowly either way, without inertia.
fn torque_over_angle(model: &KnobModel, (low, high): Extent) -> ModelCurves {
    let points = model.detent_amplitude_and_spacing().map_or(CURVE_POINTS, |[_, spacing]| {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded just here")]
        let resolving = (POINTS_PER_DETENT * (high - low) / spacing).min(MAX_CURVE_POINTS) as usize;
        resolving.max(CURVE_POINTS)
    });
    let mut drawn = ModelCurves::default();
    for slowly in [-f64::MIN_POSITIVE, f64::MIN_POSITIVE] {
        let torque_mnm = |angle: f64| model.torque_mnm(angle, slowly, 0.0);
        drawn.add(curve(low, high, points, torque_mnm), |angle| model.half_width_mnm(angle, slowly));
    }
    drawn
}

/// Friction in either direction, and the least and the largest torque that the angle adds to it.
fn torque_over_velocity(model: &KnobModel, (low, high): Extent) -> ModelCurves {
    let mut drawn = ModelCurves::default();
    for (from, to) in [(low, -f64::MIN_POSITIVE), (f64::MIN_POSITIVE, high)] {
        if from < to {
            let friction =
                |band: f64| curve(from, to, 2, |velocity| model.zero_mnm() + model.friction_mnm(velocity) + band);
            drawn.add(friction(0.0), |velocity| model.friction_half_width_mnm(velocity));
            let range = model.range_over_angle_mnm(if from < 0.0 { from } else { to });
            drawn.curves.extend(range.into_iter().flatten().map(friction));
        }
    }
    drawn
}

impl ModelCurves {
    /// Adds a curve with its interval, if its torque is identified.
    fn add(&mut self, curve: Curve, half_width_mnm: impl Fn(f64) -> f64) {
        if curve.iter().any(|point| !point[1].is_finite()) {
            return;
        }
        let half_widths: Vec<f64> = curve.iter().map(|point| half_width_mnm(point[0])).collect();
        for side in [-1.0, 1.0] {
            let border = curve.iter().zip(&half_widths).map(|([x, torque], half)| [*x, torque + side * half]);
            self.borders.push(border.collect());
        }
        #[allow(clippy::cast_precision_loss, reason = "a few thousand points")]
        let mean = half_widths.iter().sum::<f64>() / half_widths.len() as f64;
        // The wider direction speaks for both.
        self.half_width_mnm = Some(self.half_width_mnm.map_or(mean, |other| other.max(mean)));
        self.curves.push(curve);
    }
}

#[allow(clippy::cast_precision_loss, reason = "a few thousand points")]
fn curve(low: f64, high: f64, points: usize, torque_mnm: impl Fn(f64) -> f64) -> Curve {
    let last = points.max(2) - 1;
    (0..=last)
        .map(|index| index as f64 / last as f64)
        // Both ends come out exactly, however close to zero: friction jumps there.
        .map(|share| low * (1.0 - share) + high * share)
        .map(|x| [x, torque_mnm(x)])
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use super::*;

    const CAPACITY: usize = 4_000;

    fn point(x: f64, torque_mnm: f64) -> ScatterPoint {
        ScatterPoint { x, torque_mnm, turning_positive: true }
    }

    #[test]
    fn the_axes_forget_points_that_are_no_longer_shown() {
        let mut scatter = Scatter::new(Abscissa::Angle, CAPACITY);
        scatter.push(point(0.0, 1e6));
        for index in 0..CAPACITY {
            scatter.push(point(index as f64, (index % 7) as f64));
        }
        assert!(scatter.update(None).unwrap().axes.y.high < 10.0);
    }

    #[test]
    fn a_burst_of_history_stays_bounded() {
        let mut scatter = Scatter::new(Abscissa::Angle, CAPACITY);
        (0..3 * CAPACITY).for_each(|index| scatter.push(point(index as f64, 0.0)));
        assert!(scatter.update(None).unwrap().points.len() <= CAPACITY);
    }

    #[test]
    fn coulomb_friction_is_a_step_over_velocity_and_two_lines_over_angle() {
        let coulomb = |name: &str| name.starts_with("coulomb_").then_some([2.5, 0.0]);
        let model = KnobModel::from_estimates(coulomb).unwrap();
        let over_velocity = torque_over_velocity(&model, (-3.0, 4.0));
        assert_eq!(
            over_velocity.curves,
            [[[-3.0, -2.5], [-f64::MIN_POSITIVE, -2.5]], [[f64::MIN_POSITIVE, 2.5], [4.0, 2.5]]]
        );
        let over_angle = torque_over_angle(&model, (-1.0, 1.0));
        assert!(over_angle.curves[0].iter().all(|point| point[1] == -2.5));
        assert!(over_angle.curves[1].iter().all(|point| point[1] == 2.5));
        assert_eq!(over_angle.half_width_mnm, Some(0.0));
    }
}
