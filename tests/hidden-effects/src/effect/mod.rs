//! The effects that a capture may hide: those with a name in the catalogue, and real ones without.
//!
//! Each says what it does to the body that slides, to the link between cap and inner body, or to the sensors;
//! and which of its numbers is scaled to reach a strength.

mod acting;
mod drawing;
mod telling;

pub use drawing::wish;

/// Names of the effects that the catalogue knows.
pub const CATALOGUE: [&str; 15] = [
    "stribeck",
    "backlash",
    "detent-harmonics",
    "mass-imbalance",
    "friction-eccentricity",
    "presliding-hysteresis",
    "return-spring",
    "end-stop",
    "quadratic-drag",
    "shaft-compliance",
    "friction-drift",
    "cogging",
    "torque-offset",
    "sensor-delay",
    "mains-hum",
];

/// Names of real effects that the catalogue does not know.
pub const OUTSIDE: [&str; 13] = [
    "sensor-saturation",
    "varying-inertia",
    "cubic-spring",
    "friction-step",
    "torque-drift",
    "strange-hum",
    "encoder-eccentricity",
    "load-friction",
    "grip-slips",
    "friction-dropouts",
    "rate-limited-sensor",
    "directional-detents",
    "sensor-hysteresis",
];

/// Pairs that a capture cannot tell from one another or from one of them alone.
const LOOK_ALIKES: [(&str, &str); 9] = [
    ("torque-offset", "return-spring"),
    ("return-spring", "mass-imbalance"),
    ("shaft-compliance", "presliding-hysteresis"),
    ("shaft-compliance", "backlash"),
    ("shaft-compliance", "sensor-delay"),
    ("quadratic-drag", "stribeck"),
    ("presliding-hysteresis", "backlash"),
    ("backlash", "sensor-delay"),
    ("presliding-hysteresis", "stribeck"),
];

/// Whether two effects of the catalogue can be told apart when both are there.
pub fn distinguishable(first: &str, second: &str) -> bool {
    first != second && !LOOK_ALIKES.iter().any(|pair| *pair == (first, second) || *pair == (second, first))
}

/// The shape of one detent period: which, and its numbers.
#[derive(Clone, Copy, Debug)]
pub enum DetentShape {
    /// A sine mixed with a triangle by the effect's share.
    Triangle,
    /// A sine mixed with a sawtooth that rises over this fraction of the period.
    Sawtooth(f64),
    /// Second and third harmonic: their phases, and the third's part of the second's size.
    Harmonics(f64, f64, f64),
}

/// What an effect is, with the numbers that stay as drawn.
#[derive(Clone, Debug)]
#[allow(missing_docs, reason = "the variants are the catalogue's and OUTSIDE's names; fields carry their units")]
pub enum Kind {
    Stribeck { speed_rad_s: f64, exponent: f64 },
    Backlash { inner_share: f64, stiffness_mnm_rad: f64, damping_mnm_s_rad: f64 },
    DetentHarmonics(DetentShape),
    MassImbalance { phase_rad: f64 },
    FrictionEccentricity { phase_rad: f64 },
    PreslidingHysteresis { damping_ratio: f64 },
    ReturnSpring { centre_rad: f64 },
    EndStop { stiffness_mnm_rad: f64, damping_mnm_s_rad: f64, upper: bool, lower: bool, travel_rad: [f64; 2] },
    QuadraticDrag,
    ShaftCompliance { damping_ratio: f64, inertia: f64 },
    FrictionDrift { time_constant_s: f64 },
    Cogging { periods_per_turn: f64, phase_rad: f64 },
    TorqueOffset { sign: f64 },
    SensorDelay,
    MainsHum { frequency_hz: f64, phase_rad: f64 },
    SensorSaturation,
    VaryingInertia { phase_rad: f64 },
    CubicSpring { centre_rad: f64 },
    FrictionStep { angle_rad: f64 },
    TorqueDrift { sign: f64 },
    StrangeHum { frequency_hz: f64, phase_rad: f64 },
    EncoderEccentricity { phase_rad: f64 },
    LoadFriction,
    GripSlips { times_s: [Vec<f64>; 2], signs: Vec<f64> },
    FrictionDropouts { times_s: [Vec<f64>; 2], length_s: f64 },
    RateLimitedSensor,
    DirectionalDetents,
    SensorHysteresis { width_mnm: f64 },
}

/// One effect of a certain size.
#[derive(Clone, Debug)]
pub struct Effect {
    /// Its name, from [`CATALOGUE`] or [`OUTSIDE`].
    pub name: &'static str,
    /// What it is.
    pub kind: Kind,
    /// The number that is scaled to reach a strength; its meaning belongs to the kind.
    pub size: f64,
}

/// The place in phase space that friction and position torques depend on.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Angle of the sliding body, rad.
    pub angle_rad: f64,
    /// Its velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Time since the start of the capture, s.
    pub time_s: f64,
    /// Torque that the body's inertia and detents carried lately, mNm.
    pub load_mnm: f64,
    /// 0 in the training capture, 1 in the held-out one.
    pub capture: usize,
}
