//! One channel of the rig: the original signal, the measured one, and what lies between them.

use std::f64::consts::TAU;

use dynamics::{Axis, Excitation};
use identification::filter::chebyshev2_low_pass;
use loaded_capture::LoadedCapture;
use report::{ChannelDifference, ChannelLag, ChannelTrace};

/// Frequency at which the lag is taken, Hz.
pub const LAG_HZ: f64 = 30.0;
/// Lag there below which the paper's rig stays, rad.
const PAPER_LAG_RAD: f64 = 0.5;
/// Nm in a mNm, the unit of a capture.
const NM_PER_MNM: f64 = 1e-3;
/// Time for which a tone is faded in and the rig settles, s.
const SETTLED_S: f64 = 1.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    Position,
    Velocity,
    Acceleration,
    Torque,
}

impl Channel {
    pub const ALL: [Self; 4] = [Self::Position, Self::Velocity, Self::Acceleration, Self::Torque];

    fn name(self, axis: Axis) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Torque => axis.load().name(),
        }
    }

    /// Unit, mean and standard deviation of Table 3; on a linear axis those of the paper's rig at a fingertip's distance from its
    /// axis.
    fn paper(self, axis: Axis) -> (&'static str, f64, f64) {
        let (rotary, linear, mean, sd) = match self {
            Self::Position => ("rad", "mm", 0.0012, 0.0032),
            Self::Velocity => ("rad/s", "mm/s", 0.0016, 0.0244),
            Self::Acceleration => ("rad/s²", "mm/s²", 0.664, 0.4148),
            Self::Torque => ("Nm", "N", 0.0010, 0.0018),
        };
        let travel = axis.fingertip_travel();
        match (axis, self) {
            (Axis::Rotary, _) => (rotary, mean, sd),
            (Axis::Linear, Self::Torque) => (linear, mean / (NM_PER_MNM * travel), sd / (NM_PER_MNM * travel)),
            (Axis::Linear, _) => (linear, mean * travel, sd * travel),
        }
    }

    /// Time, original and measured signal, sample by sample, in Table 3's units, or mm and N.
    fn signals(self, loaded: &LoadedCapture, excitation: &Excitation) -> Vec<[f64; 3]> {
        let capture = &loaded.capture;
        let known = loaded.calibration.as_ref();
        let load = if capture.axis.is_rotary() { NM_PER_MNM } else { 1.0 };
        let start_rad = capture.commanded_angle_rad.as_ref().map_or(0.0, |commanded| {
            commanded.first().map_or(0.0, |first| first - excitation.at(capture.t_s[0]).value)
        });
        let column = |column: &Option<Vec<f64>>, row: usize| column.as_ref().map_or(f64::NAN, |column| column[row]);
        let of_row = |row: usize| {
            let time_s = capture.t_s[row];
            let set = excitation.at(time_s);
            let (original, measured) = match self {
                Self::Position => (start_rad + set.value, capture.angle_rad[row]),
                Self::Velocity => (set.rate, column(&capture.velocity_rad_s, row)),
                Self::Acceleration => {
                    let seen = column(&capture.acceleration_rad_s2, row);
                    let still = known.map_or(0.0, |known| {
                        known.acceleration_zero_rad_s2 + known.gravity_rad_s2(capture.angle_rad[row])
                    });
                    (set.acceleration, seen - still)
                }
                Self::Torque => {
                    let zero_mnm = known.map_or(0.0, |known| known.torque_zero_mnm);
                    (load * set.value, load * (capture.torque_mnm[row] - zero_mnm))
                }
            };
            [time_s, original, measured]
        };
        (0..capture.len()).map(of_row).collect()
    }

    /// Edge of the low-pass through which the paper takes the channel before a fit, Hz.
    pub fn filter_edge_hz(self) -> f64 {
        match self {
            Self::Position | Self::Velocity => 1000.0,
            Self::Acceleration | Self::Torque => 500.0,
        }
    }

    /// Original and measured signal under the sweep and at one frequency, for the figures of a page.
    pub fn trace(self, sweep: (&LoadedCapture, &Excitation), tone: (&LoadedCapture, &Excitation)) -> ChannelTrace {
        let axis = sweep.0.capture.axis;
        ChannelTrace {
            channel: self.name(axis),
            unit: self.paper(axis).0,
            sweep: self.signals(sweep.0, sweep.1),
            tone: self.signals(tone.0, tone.1),
        }
    }

    /// Mean and standard deviation of original minus measured.
    pub fn compare(self, loaded: &LoadedCapture, excitation: &Excitation) -> ChannelDifference {
        let differences: Vec<f64> =
            self.signals(loaded, excitation).iter().map(|[_, original, measured]| original - measured).collect();
        // Third-order Chebyshev II, 20 dB, forwards and backwards (section 4.2).
        let filtered = chebyshev2_low_pass(3, 20.0, self.filter_edge_hz(), loaded.capture.rate_hz)
            .map_or_else(|| differences.clone(), |filter| filter.filter_zero_phase(&differences));
        let axis = loaded.capture.axis;
        let channel = self.name(axis);
        let (unit, paper_mean, paper_sd) = self.paper(axis);
        let ((mean, sd), (_, sd_filtered)) = (mean_and_sd(&differences), mean_and_sd(&filtered));
        ChannelDifference { channel, unit, mean, sd, sd_filtered, paper_mean, paper_sd }
    }

    /// Phase and gain at 30 Hz, over a whole number of periods.
    pub fn lag(self, loaded: &LoadedCapture, excitation: &Excitation) -> ChannelLag {
        let signals = self.signals(loaded, excitation);
        let end_s = signals.last().map_or(0.0, |[time_s, ..]| *time_s);
        let until_s = SETTLED_S + ((end_s - SETTLED_S) * LAG_HZ).floor() / LAG_HZ;
        let (mut original, mut measured) = ([0.0; 2], [0.0; 2]);
        for [time_s, commanded, seen] in signals.iter().filter(|[time_s, ..]| (SETTLED_S..until_s).contains(time_s)) {
            let (sine, cosine) = (TAU * LAG_HZ * time_s).sin_cos();
            for (sum, value) in [(&mut original, commanded), (&mut measured, seen)] {
                sum[0] += value * cosine;
                sum[1] += value * sine;
            }
        }
        // For cos(ωt − φ) the sums are in the ratio cos φ to sin φ.
        let difference = measured[1].atan2(measured[0]) - original[1].atan2(original[0]);
        let phase_rad = difference - TAU * (difference / TAU).round();
        ChannelLag {
            channel: self.name(loaded.capture.axis),
            phase_rad,
            delay_ms: 1e3 * phase_rad / (TAU * LAG_HZ),
            gain: measured[0].hypot(measured[1]) / original[0].hypot(original[1]),
            paper_phase_rad_below: PAPER_LAG_RAD,
        }
    }
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, variance.sqrt())
}
