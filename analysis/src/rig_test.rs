//! What a rig measures beside what it was commanded to do, channel by channel, as in the paper's Table 3.

use std::f64::consts::TAU;

use dynamics::{Axis, Excitation};
use identification::filter::chebyshev2_low_pass;
use identification::statistics::{mean, nearest_turn, standard_deviation};
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, ChannelDifference, ChannelLag, ChannelTrace, RigTest};

/// Frequency at which the lag is taken, Hz.
const LAG_HZ: f64 = 30.0;
/// Lag there below which the paper's rig stays, rad.
const PAPER_LAG_RAD: f64 = 0.5;
/// Nm in a mNm, the unit of a capture.
const NM_PER_MNM: f64 = 1e-3;
/// Time for which a tone is faded in and the rig settles, s.
const SETTLED_S: f64 = 1.0;

/// A capture of the rig, and what it was commanded to do.
pub type Commanded = (LoadedCapture, Excitation);

/// Compares the gripper alone and the locked gripper, each under the sweep and at one frequency, with their commands.
#[must_use]
pub fn rig_test(sweep: &str, rate_hz: f64, free: &[Commanded; 2], locked: &[Commanded; 2]) -> RigTest {
    let titles = [
        "free gripper, sweep",
        "free gripper, one frequency",
        "locked gripper, sweep",
        "locked gripper, one frequency",
    ];
    let facts =
        |((loaded, _), title): (&Commanded, &str)| CaptureFacts { title: title.to_owned(), ..crate::facts(loaded) };
    let axis = free[0].0.capture.axis;
    let mut test = RigTest {
        axis,
        sweep: sweep.to_owned(),
        rate_hz,
        differences: Vec::new(),
        lag_at_30_hz: Vec::new(),
        lag_hz: LAG_HZ,
        filter_edges_hz: Channel::ALL.map(Channel::filter_edge_hz).to_vec(),
        captures: free.iter().chain(locked).zip(titles).map(facts).collect(),
        traces: Vec::new(),
    };
    for channel in Channel::ALL {
        let [sweep, tone] = if channel == Channel::Torque { locked } else { free };
        let trace = ChannelTrace {
            channel: channel.name(axis),
            unit: channel.paper(axis).0,
            sweep: channel.signals(sweep),
            tone: channel.signals(tone),
        };
        test.differences.push(channel.difference(axis, &trace.sweep, sweep.0.capture.rate_hz));
        test.lag_at_30_hz.push(lag(trace.channel, &trace.tone));
        test.traces.push(trace);
    }
    test
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Position,
    Velocity,
    Acceleration,
    Torque,
}

impl Channel {
    const ALL: [Self; 4] = [Self::Position, Self::Velocity, Self::Acceleration, Self::Torque];

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
    fn signals(self, (loaded, excitation): &Commanded) -> Vec<[f64; 3]> {
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
    fn filter_edge_hz(self) -> f64 {
        match self {
            Self::Position | Self::Velocity => 1000.0,
            Self::Acceleration | Self::Torque => 500.0,
        }
    }

    /// Mean and standard deviation of original minus measured.
    fn difference(self, axis: Axis, signals: &[[f64; 3]], rate_hz: f64) -> ChannelDifference {
        let differences: Vec<f64> = signals.iter().map(|[_, original, measured]| original - measured).collect();
        // Third-order Chebyshev II, 20 dB, forwards and backwards (section 4.2).
        let filtered = chebyshev2_low_pass(3, 20.0, self.filter_edge_hz(), rate_hz)
            .map_or_else(|| differences.clone(), |filter| filter.filter_zero_phase(&differences));
        let (unit, paper_mean, paper_sd) = self.paper(axis);
        ChannelDifference {
            channel: self.name(axis),
            unit,
            mean: mean(&differences),
            sd: standard_deviation(&differences),
            sd_filtered: standard_deviation(&filtered),
            paper_mean,
            paper_sd,
        }
    }
}

/// Phase and gain at 30 Hz, over a whole number of periods.
fn lag(channel: &'static str, signals: &[[f64; 3]]) -> ChannelLag {
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
    let phase_rad = nearest_turn(difference, 0.0);
    ChannelLag {
        channel,
        phase_rad,
        delay_ms: 1e3 * phase_rad / (TAU * LAG_HZ),
        gain: measured[0].hypot(measured[1]) / original[0].hypot(original[1]),
        paper_phase_rad_below: PAPER_LAG_RAD,
    }
}
