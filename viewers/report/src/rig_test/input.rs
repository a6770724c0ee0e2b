//! What the page of a rig test is made of; it serialises to what `rig-test --json` gives.

use dynamics::Axis;
use serde::Serialize;

use crate::CaptureFacts;

/// How far a rig's measurement is from its command, compared with the paper's rig.
#[derive(Clone, Debug, Serialize)]
pub struct RigTest {
    /// Whether the rig turns.
    pub axis: Axis,
    /// Name of the sweep.
    pub sweep: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Original minus measured, channel by channel.
    pub differences: Vec<ChannelDifference>,
    /// How late each channel shows a sine of [`RigTest::lag_hz`].
    pub lag_at_30_hz: Vec<ChannelLag>,
    /// Frequency at which the lag is taken, Hz.
    pub lag_hz: f64,
    /// Low-pass edges behind which the filtered standard deviations are taken, channel by channel, Hz.
    pub filter_edges_hz: Vec<f64>,
    /// The captures: free and locked gripper under the sweep, then both at one frequency.
    pub captures: Vec<CaptureFacts>,
    /// The signals that the figures show; of no other use.
    #[serde(skip)]
    pub traces: Vec<ChannelTrace>,
}

/// Original minus measured, in the units of the paper's Table 3, or in mm and N.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelDifference {
    /// `position`, `velocity`, `acceleration`, and `torque` or `force`.
    pub channel: &'static str,
    /// Unit of all that follows.
    pub unit: &'static str,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Standard deviation behind the paper's filters for a fit, which take out what no fit sees.
    pub sd_filtered: f64,
    /// Mean in Table 3; on a linear axis at a fingertip's 20 mm from the paper's.
    pub paper_mean: f64,
    /// Standard deviation in Table 3, likewise.
    pub paper_sd: f64,
}

/// How late a channel shows a sine.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelLag {
    /// The channel, as in [`ChannelDifference`].
    pub channel: &'static str,
    /// Phase lag, rad; negative if the channel is ahead.
    pub phase_rad: f64,
    /// The same as a time, ms.
    pub delay_ms: f64,
    /// Measured amplitude over the original one.
    pub gain: f64,
    /// The phase lag that the paper's rig stays below, rad.
    pub paper_phase_rad_below: f64,
}

/// A channel sample by sample: time in s, original and measured value in the channel's unit.
#[derive(Clone, Debug, Default)]
pub struct ChannelTrace {
    /// The channel, as in [`ChannelDifference`].
    pub channel: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Under the sweep.
    pub sweep: Vec<[f64; 3]>,
    /// At one frequency.
    pub tone: Vec<[f64; 3]>,
}
