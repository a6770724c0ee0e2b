//! The signals of a run, reduced to what a screen can show, and their extremes.

use crate::decimation::{Decimator, Keep};
use crate::entities::{self, MODEL_TORQUE, SIGNALS};
use crate::extremes::Extremes;
use crate::frame::SeriesRows;
use crate::source::Reading;

/// Width of a pixel of a plot that shows 10 s in 1000 pixels; a bin keeps two points.
const BIN_NS: i64 = 10_000_000;
/// The model's torque is drawn as dots, which stay apart at four pixels. Without a graphics card each dot takes as long to
/// draw as a whole line of them.
const MODEL_BIN_NS: i64 = 40_000_000;

/// One decimator and one window of extremes for each of [`SIGNALS`].
#[derive(Debug)]
pub struct Signals {
    decimators: [Decimator; SIGNALS.len()],
    extremes: [Extremes; SIGNALS.len()],
}

impl Signals {
    /// No signals yet; the extremes look back `steps_kept` steps.
    pub fn new(steps_kept: usize) -> Self {
        let decimator = |field| Decimator::new(Keep::MinMax, if field == MODEL_TORQUE { MODEL_BIN_NS } else { BIN_NS });
        Self { decimators: SIGNALS.map(decimator), extremes: std::array::from_fn(|_| Extremes::new(steps_kept)) }
    }

    /// Takes in what was measured; a quantity that is not a number leaves no trace.
    pub fn push(&mut self, reading: &Reading) {
        let Reading { time_ns, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm, contact, .. } = *reading;
        for (index, value) in
            [angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm, contact].into_iter().enumerate()
        {
            self.push_at(index, time_ns, value);
        }
    }

    /// Takes in what the model gives, mNm.
    pub fn push_model_torque(&mut self, time_ns: i64, torque_mnm: f64) {
        self.push_at(SIGNALS.len() - 1, time_ns, torque_mnm);
    }

    fn push_at(&mut self, index: usize, time_ns: i64, value: f64) {
        self.decimators[index].push(time_ns, value);
        self.extremes[index].push(value);
    }

    /// The points that are complete, each handed out once.
    pub fn take_rows(&mut self) -> Vec<SeriesRows> {
        let rows = |(field, decimator): (&str, &mut Decimator)| {
            SeriesRows::of_points(entities::signal(field), decimator.take())
        };
        SIGNALS.into_iter().zip(&mut self.decimators).filter_map(rows).collect()
    }

    /// Completes the open bins, for a run that has ended.
    pub fn close_bins(&mut self) {
        self.decimators.iter_mut().for_each(Decimator::close_bin);
    }

    /// Moves the extremes' window on by one step.
    pub fn step_extremes(&mut self) {
        self.extremes.iter_mut().for_each(Extremes::step);
    }

    /// Smallest and largest value of each signal in the window.
    pub fn ranges(&self) -> [(&'static str, Option<(f64, f64)>); SIGNALS.len()] {
        std::array::from_fn(|index| (SIGNALS[index], self.extremes[index].range()))
    }
}
