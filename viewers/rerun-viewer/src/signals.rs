//! The streams of a run, reduced to what a screen can show, and the extremes of the last seconds.

use crate::decimation::{Decimator, Keep};
use crate::entities::{self, MODEL_TORQUE, SIGNALS};
use crate::extent::{self, Extent};
use crate::frame::Series;
use crate::source::Reading;

/// Width of a pixel of a plot that shows 10 s in 1000 pixels; a bin keeps two points.
const BIN_NS: i64 = 10_000_000;
/// The model's torque is drawn as dots, which stay apart at four pixels. Without a graphics card each dot takes as long to
/// draw as a whole line of them.
const MODEL_BIN_NS: i64 = 40_000_000;
/// Bin of the lateness, of which only the largest stays.
const LATENESS_BIN_NS: i64 = 20_000_000;
/// Steps that the extremes look back: at one in 2.5 s the 10 s that the plots show.
const STEPS_KEPT: usize = 4;

/// All of [`SIGNALS`], and the lateness.
#[derive(Debug)]
pub struct Signals {
    signals: [Signal; SIGNALS.len()],
    /// Log10 of the ticks' lateness in ns.
    pub lateness: Decimator,
}

#[derive(Debug)]
struct Signal {
    decimator: Decimator,
    /// Of each step, the present one first.
    extents: [Option<Extent>; STEPS_KEPT],
}

impl Default for Signals {
    fn default() -> Self {
        let signals = SIGNALS.map(|field| Signal {
            decimator: Decimator::new(Keep::MinMax, if field == MODEL_TORQUE { MODEL_BIN_NS } else { BIN_NS }),
            extents: [None; STEPS_KEPT],
        });
        Self { signals, lateness: Decimator::new(Keep::Max, LATENESS_BIN_NS) }
    }
}

impl Signals {
    /// Takes in what was measured; a quantity that is not a number leaves no trace.
    pub fn push(&mut self, reading: &Reading) {
        let Reading { time_ns, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm, contact, .. } = *reading;
        let measured = [angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm, contact];
        self.signals.iter_mut().zip(measured).for_each(|(signal, value)| signal.push(time_ns, value));
    }

    pub fn push_model_torque(&mut self, time_ns: i64, torque_mnm: f64) {
        self.signals[SIGNALS.len() - 1].push(time_ns, torque_mnm);
    }

    /// The points of the signals that are complete, each handed out once.
    pub fn take(&mut self) -> Series {
        let points = |(field, signal): (&str, &mut Signal)| (entities::signal(field), signal.decimator.take());
        let all = SIGNALS.into_iter().zip(&mut self.signals).map(points);
        all.filter(|(_, points)| !points.times_ns.is_empty()).collect()
    }

    /// Completes the open bins, for a run that has ended.
    pub fn close_bins(&mut self) {
        self.signals.iter_mut().for_each(|signal| signal.decimator.close_bin());
        self.lateness.close_bin();
    }

    /// Forgets the extremes of the oldest step and begins another one.
    pub fn step_extremes(&mut self) {
        for Signal { extents, .. } in &mut self.signals {
            extents.rotate_right(1);
            extents[0] = None;
        }
    }

    /// Smallest and largest value of each signal over the last steps.
    pub fn ranges(&self) -> impl Iterator<Item = (&'static str, Option<Extent>)> {
        let joined = |signal: &Signal| extent::of(signal.extents.into_iter().flatten().flatten());
        SIGNALS.into_iter().zip(self.signals.iter().map(joined))
    }
}

impl Signal {
    fn push(&mut self, time_ns: i64, value: f64) {
        self.decimator.push(time_ns, value);
        if value.is_finite() {
            self.extents[0] = extent::of(self.extents[0].into_iter().flatten().chain([value]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extreme_is_forgotten_once_the_window_has_passed_it() {
        let mut signals = Signals::default();
        let range = |signals: &Signals| signals.ranges().last().and_then(|(_, range)| range);
        assert_eq!(range(&signals), None);
        for (time_ns, value) in [50.0, -1.0, f64::NAN, 2.0].into_iter().enumerate() {
            signals.push_model_torque(time_ns as i64, value);
            assert_eq!(range(&signals).map(|[_, high]| high), Some(50.0));
            signals.step_extremes();
        }
        assert_eq!(range(&signals), Some([-1.0, 2.0]));
    }
}
