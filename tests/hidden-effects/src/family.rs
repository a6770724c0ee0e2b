//! Families of captures: the standard rig, and rigs unlike the one that a method may have been written for.

use std::f64::consts::TAU;

use crate::draw::Draw;

/// A kind of rig or knob that captures come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// White torque noise, a quick servo, 5 kHz, 6 s and 4 s, knobs within Table 5.
    Standard,
    /// Torque noise that is pink or remembers its past.
    ColouredNoise,
    /// A torque sensor that rings at 600 to 1500 Hz.
    ResonantSensor,
    /// A torque sensor that clips the highest peaks: a few samples in a thousand.
    ClippingSensor,
    /// Samples taken 0.1 to 2 % of a tick too early or late.
    TimeJitter,
    /// A servo of 5 to 12 Hz, which the knob's torque drags about.
    SoftServo,
    /// Knobs at the extremes of Table 5.
    ExtremeKnob,
    /// 2 or 10 kHz.
    OtherRate,
    /// 3 or 12 s to train on.
    OtherLength,
    /// An axis as its drive logs it: moves from point to point at 1 kHz, an encoder of 16 to 18 bits in a turn, and no other column but
    /// the torque.
    DriveLog,
}

impl Family {
    /// All of them, the standard one first.
    pub const ALL: [Self; 10] = [
        Self::Standard,
        Self::ColouredNoise,
        Self::ResonantSensor,
        Self::ClippingSensor,
        Self::TimeJitter,
        Self::SoftServo,
        Self::ExtremeKnob,
        Self::OtherRate,
        Self::OtherLength,
        Self::DriveLog,
    ];

    /// The name that selects it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::ColouredNoise => "coloured-noise",
            Self::ResonantSensor => "resonant-sensor",
            Self::ClippingSensor => "clipping-sensor",
            Self::TimeJitter => "time-jitter",
            Self::SoftServo => "soft-servo",
            Self::ExtremeKnob => "extreme-knob",
            Self::OtherRate => "other-rate",
            Self::OtherLength => "other-length",
            Self::DriveLog => "drive-log",
        }
    }

    /// The family of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.name() == name)
    }

    /// Draws the family's sensors and times.
    pub fn conditions(self, draw: &mut Draw) -> Conditions {
        let mut conditions = Conditions::default();
        match self {
            Self::Standard | Self::SoftServo | Self::ExtremeKnob => {}
            Self::ColouredNoise if draw.chance(0.5) => conditions.noise = Noise::Pink,
            Self::ColouredNoise => conditions.noise = Noise::Remembering(draw.uniform(0.6, 0.97)),
            Self::ResonantSensor => {
                conditions.ring =
                    Some(Ring { frequency_hz: draw.uniform(600.0, 1500.0), damping: draw.log_uniform(0.02, 0.1) });
            }
            Self::ClippingSensor => conditions.clipped_share = Some(draw.log_uniform(5e-4, 5e-3)),
            Self::TimeJitter => {
                conditions.jitter = draw.log_uniform(1e-3, 2e-2);
                conditions.jitter_is_recorded = draw.chance(0.5);
            }
            Self::OtherRate => conditions.rate_hz = if draw.chance(0.5) { 2000.0 } else { 10_000.0 },
            Self::OtherLength => conditions.durations_s = if draw.chance(0.5) { [3.0, 3.0] } else { [12.0, 6.0] },
            Self::DriveLog => {
                conditions.rate_hz = 1000.0;
                conditions.durations_s = [12.0, 6.0];
                conditions.encoder_step_rad = TAU / f64::from(1 << (16 + draw.below(3)));
                conditions.logs_angle_alone = true;
            }
        }
        conditions
    }
}

/// Sensors and times of a capture, beyond what each has.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Samples per second.
    pub rate_hz: f64,
    /// Lengths of the training and the held-out capture, s.
    pub durations_s: [f64; 2],
    /// The colour of the torque noise.
    pub noise: Noise,
    /// The torque sensor's own resonance.
    pub ring: Option<Ring>,
    /// Share of the samples whose torque is beyond the sensor's range.
    pub clipped_share: Option<f64>,
    /// Standard deviation of a sample's time, over a tick.
    pub jitter: f64,
    /// Whether the time column tells when the sample was truly taken, or the tick it was meant for.
    pub jitter_is_recorded: bool,
    /// Step of the encoder, rad.
    pub encoder_step_rad: f64,
    /// Whether the motion is logged as the encoder's angle alone, without velocity and acceleration.
    pub logs_angle_alone: bool,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            rate_hz: 5000.0,
            durations_s: [6.0, 4.0],
            noise: Noise::White,
            ring: None,
            clipped_share: None,
            jitter: 0.0,
            jitter_is_recorded: false,
            encoder_step_rad: 9.8e-6,
            logs_angle_alone: false,
        }
    }
}

/// The colour of noise; its RMS is given apart.
#[derive(Clone, Copy, Debug)]
pub enum Noise {
    /// Each sample on its own.
    White,
    /// Half the power white, half first-order autoregressive with this coefficient.
    Remembering(f64),
    /// Half the power white, half falling as 1/f from 1 Hz or so up.
    Pink,
}

/// A sensor that rings.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Its resonance, Hz.
    pub frequency_hz: f64,
    /// Its damping ratio.
    pub damping: f64,
}
