//! The effects that a capture may hide: those with a name in the catalogue, and real ones without.
//!
//! Each says what it does to the body that slides, to the link between cap and inner body, or to the sensors;
//! and which of its numbers is scaled to reach a strength.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use crate::draw::Draw;
use crate::knob::{Knob, Wish};

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

/// What the effect called `name` asks of a knob, at a strength times the torque noise of `size_mnm`.
pub fn wish(name: &str, size_mnm: f64) -> Wish {
    let mut wish = Wish::default();
    match name {
        // A sine or a slow line would be taken for detents by a base model whose detents are free.
        "mass-imbalance" | "cogging" | "return-spring" | "cubic-spring" => wish.detents = Some(true),
        "torque-offset" => {
            // An offset below the Coulomb friction is only an asymmetry of friction.
            wish.detents = Some(true);
            wish.most_coulomb_mnm = (2.0 * size_mnm).clamp(0.7, 3.0);
        }
        "detent-harmonics" | "directional-detents" => {
            wish.detents = Some(true);
            wish.least_detent_mnm = 6.0 * size_mnm;
        }
        "encoder-eccentricity" | "grip-slips" => {
            wish.detents = Some(true);
            wish.least_detent_mnm = 4.0 * size_mnm;
        }
        "stribeck" => wish.least_coulomb_mnm = size_mnm,
        "backlash" => {
            wish.least_coulomb_mnm = 3.0 * size_mnm;
        }
        "friction-eccentricity"
        | "friction-drift"
        | "friction-step"
        | "presliding-hysteresis"
        | "friction-dropouts" => {
            wish.least_coulomb_mnm = 5.0 * size_mnm;
        }
        _ => {}
    }
    wish
}

impl Effect {
    /// Draws the effect of that name for a knob whose training and held-out motion span `travel_rad` (both of
    /// `[lowest, highest]`); `None` if no effect has the name.
    pub fn draw(name: &str, knob: &Knob, travel_rad: [f64; 2], durations_s: [f64; 2], draw: &mut Draw) -> Option<Self> {
        let name = CATALOGUE.iter().chain(&OUTSIDE).copied().find(|known| *known == name)?;
        let middle = 0.5 * (travel_rad[0] + travel_rad[1]);
        let centre_rad = middle + draw.uniform(-0.4, 0.4);
        let sign = if draw.chance(0.5) { 1.0 } else { -1.0 };
        let kind = match name {
            "stribeck" => Kind::Stribeck {
                speed_rad_s: draw.log_uniform(0.4, 2.5),
                exponent: if draw.chance(0.5) { 1.0 } else { 2.0 },
            },
            "backlash" => {
                let inner_share = draw.uniform(0.1, 0.7);
                let stiffness = draw.log_uniform(4e3, 2e4);
                let critical = 2.0 * (stiffness * inner_share * knob.inertia).sqrt();
                Kind::Backlash {
                    inner_share,
                    stiffness_mnm_rad: stiffness,
                    damping_mnm_s_rad: draw.uniform(0.2, 0.5) * critical,
                }
            }
            "detent-harmonics" => Kind::DetentHarmonics(match draw.below(3) {
                0 => DetentShape::Triangle,
                1 => DetentShape::Sawtooth(draw.uniform(0.1, 0.3)),
                _ => DetentShape::Harmonics(draw.phase(), draw.phase(), draw.uniform(0.2, 0.8)),
            }),
            "mass-imbalance" => Kind::MassImbalance { phase_rad: draw.phase() },
            "friction-eccentricity" => Kind::FrictionEccentricity { phase_rad: draw.phase() },
            "presliding-hysteresis" => Kind::PreslidingHysteresis { damping_ratio: draw.uniform(0.02, 0.1) },
            "return-spring" => Kind::ReturnSpring { centre_rad },
            "end-stop" => {
                let which = draw.below(3);
                let stiffness = draw.log_uniform(120.0, 1200.0);
                Kind::EndStop {
                    stiffness_mnm_rad: stiffness,
                    damping_mnm_s_rad: stiffness * draw.log_uniform(1e-3, 8e-3),
                    upper: which != 1,
                    lower: which != 0,
                    travel_rad,
                }
            }
            "quadratic-drag" => Kind::QuadraticDrag,
            "shaft-compliance" => {
                Kind::ShaftCompliance { damping_ratio: draw.uniform(0.03, 0.12), inertia: knob.inertia }
            }
            "friction-drift" => Kind::FrictionDrift { time_constant_s: draw.uniform(0.8, 3.0) },
            "cogging" => Kind::Cogging { periods_per_turn: unrelated_periods(knob, draw), phase_rad: draw.phase() },
            "torque-offset" => Kind::TorqueOffset { sign },
            "sensor-delay" => Kind::SensorDelay,
            "mains-hum" => {
                Kind::MainsHum { frequency_hz: if draw.chance(0.5) { 50.0 } else { 60.0 }, phase_rad: draw.phase() }
            }
            "sensor-saturation" => Kind::SensorSaturation,
            "varying-inertia" => Kind::VaryingInertia { phase_rad: draw.phase() },
            "cubic-spring" => Kind::CubicSpring { centre_rad: middle },
            "friction-step" => {
                Kind::FrictionStep { angle_rad: middle + draw.uniform(-0.25, 0.25) * (travel_rad[1] - travel_rad[0]) }
            }
            "torque-drift" => Kind::TorqueDrift { sign },
            "strange-hum" => Kind::StrangeHum {
                frequency_hz: if draw.chance(0.5) { draw.uniform(20.0, 44.0) } else { draw.uniform(66.0, 140.0) },
                phase_rad: draw.phase(),
            },
            "encoder-eccentricity" => Kind::EncoderEccentricity { phase_rad: draw.phase() },
            "load-friction" => Kind::LoadFriction,
            "grip-slips" => {
                let count = 2 + draw.below(2);
                let times_s = [0, 1].map(|capture| times(count, durations_s[capture], draw));
                Kind::GripSlips { times_s, signs: vec![sign; count] }
            }
            "friction-dropouts" => {
                let times_s = [0, 1].map(|capture| times(6 + draw.below(5), durations_s[capture], draw));
                Kind::FrictionDropouts { times_s, length_s: draw.uniform(0.03, 0.12) }
            }
            "rate-limited-sensor" => Kind::RateLimitedSensor,
            "directional-detents" => Kind::DirectionalDetents,
            _ => Kind::SensorHysteresis { width_mnm: draw.uniform(5.0, 40.0) },
        };
        Some(Self { name, kind, size: 0.0 })
    }

    /// The sizes between which the strength is sought: where the effect is weakest and where it is strongest.
    pub fn size_limits(&self) -> [f64; 2] {
        match &self.kind {
            Kind::Stribeck { .. } => [1e-2, 150.0],
            Kind::Backlash { .. } => [3e-5, 0.03],
            Kind::DetentHarmonics(DetentShape::Harmonics(..)) => [1e-4, 0.9],
            Kind::DetentHarmonics(_) | Kind::FrictionEccentricity { .. } | Kind::FrictionDropouts { .. } => [1e-4, 0.9],
            Kind::MassImbalance { .. } | Kind::Cogging { .. } | Kind::TorqueOffset { .. } => [1e-2, 40.0],
            Kind::PreslidingHysteresis { .. } => [3e-4, 0.12],
            Kind::ReturnSpring { .. } | Kind::CubicSpring { .. } => [1e-3, 40.0],
            Kind::EndStop { travel_rad, .. } => [1e-3, 0.35 * (travel_rad[1] - travel_rad[0])],
            Kind::QuadraticDrag => [1e-4, 1.0],
            Kind::ShaftCompliance { .. } => [500.0, 15.0],
            Kind::FrictionDrift { .. } | Kind::FrictionStep { .. } => [1e-3, 2.0],
            Kind::SensorDelay => [5e-5, 3e-3],
            Kind::MainsHum { .. } | Kind::StrangeHum { .. } => [1e-2, 40.0],
            Kind::SensorSaturation => [400.0, 3.0],
            Kind::VaryingInertia { .. } => [1e-3, 0.7],
            Kind::TorqueDrift { .. } => [1e-3, 20.0],
            Kind::EncoderEccentricity { .. } => [1e-5, 0.15],
            Kind::LoadFriction => [1e-3, 0.6],
            Kind::GripSlips { .. } => [1e-4, 0.15],
            Kind::RateLimitedSensor => [2e6, 300.0],
            Kind::DirectionalDetents => [1e-3, 0.9],
            Kind::SensorHysteresis { .. } => [1e-2, 60.0],
        }
    }

    /// Multiplies the Coulomb friction, and the viscous one where `viscous`.
    pub fn friction_factor(&self, state: &State, viscous: bool) -> f64 {
        match &self.kind {
            Kind::FrictionDrift { time_constant_s } => 1.0 + self.size * (-state.time_s / time_constant_s).exp(),
            Kind::FrictionEccentricity { phase_rad } if !viscous => {
                1.0 + self.size * (state.angle_rad + phase_rad).cos()
            }
            Kind::FrictionStep { angle_rad } if !viscous => 1.0 + self.size * f64::from(state.angle_rad > *angle_rad),
            Kind::FrictionDropouts { times_s, length_s } => {
                let out = times_s[state.capture].iter().any(|start| (*start..start + length_s).contains(&state.time_s));
                1.0 - self.size * f64::from(out)
            }
            _ => 1.0,
        }
    }

    /// Adds to the Coulomb friction, mNm.
    pub fn friction_extra(&self, state: &State) -> f64 {
        match &self.kind {
            Kind::Stribeck { speed_rad_s, exponent } => {
                self.size * (-(state.velocity_rad_s.abs() / speed_rad_s).powf(*exponent)).exp()
            }
            Kind::LoadFriction => self.size * state.load_mnm.abs(),
            _ => 0.0,
        }
    }

    /// Torque in mNm that the sliding body takes for its place and speed.
    pub fn body_torque(&self, state: &State) -> f64 {
        let State { angle_rad: angle, velocity_rad_s: velocity, .. } = *state;
        match &self.kind {
            Kind::MassImbalance { phase_rad } => self.size * (angle + phase_rad).sin(),
            Kind::ReturnSpring { centre_rad } => self.size * (angle - centre_rad),
            Kind::CubicSpring { centre_rad } => self.size * (angle - centre_rad).powi(3),
            Kind::QuadraticDrag => self.size * velocity * velocity.abs(),
            Kind::Cogging { periods_per_turn, phase_rad } => self.size * (periods_per_turn * angle + phase_rad).sin(),
            Kind::EndStop { stiffness_mnm_rad, damping_mnm_s_rad, .. } => {
                let [lower, upper] = self.stops();
                let contact = |depth: f64, speed: f64| {
                    if depth > 0.0 { (stiffness_mnm_rad * depth + damping_mnm_s_rad * speed).max(0.0) } else { 0.0 }
                };
                upper.map_or(0.0, |stop| contact(angle - stop, velocity))
                    - lower.map_or(0.0, |stop| contact(stop - angle, -velocity))
            }
            _ => 0.0,
        }
    }

    /// The end stops' angles, `[lower, upper]`.
    pub fn stops(&self) -> [Option<f64>; 2] {
        match &self.kind {
            Kind::EndStop { upper, lower, travel_rad, .. } => {
                [lower.then_some(travel_rad[0] + self.size), upper.then_some(travel_rad[1] - self.size)]
            }
            _ => [None, None],
        }
    }

    /// How far the body has slipped in its grip, rad.
    pub fn slipped_rad(&self, state: &State) -> f64 {
        match &self.kind {
            Kind::GripSlips { times_s, signs } => {
                let slips = times_s[state.capture].iter().zip(signs).filter(|(time, _)| **time < state.time_s);
                self.size * slips.map(|(_, sign)| sign).sum::<f64>()
            }
            _ => 0.0,
        }
    }

    /// The detents' wave at phase `x`, in the place of a sine, if the effect shapes it.
    pub fn detent_wave(&self, x: f64, velocity_rad_s: f64) -> Option<f64> {
        let size = self.size;
        match &self.kind {
            Kind::DetentHarmonics(DetentShape::Harmonics(second, third, ratio)) => {
                Some(x.sin() + size * ((2.0 * x + second).sin() + ratio * (3.0 * x + third).sin()))
            }
            Kind::DetentHarmonics(DetentShape::Triangle) => Some((1.0 - size) * x.sin() + size * tooth(x, 0.5)),
            Kind::DetentHarmonics(DetentShape::Sawtooth(rising)) => {
                Some((1.0 - size) * x.sin() + size * tooth(x, *rising))
            }
            Kind::DirectionalDetents => Some((1.0 + size * (velocity_rad_s / 0.2).tanh()) * x.sin()),
            _ => None,
        }
    }

    /// The parameters as the answers tell them.
    pub fn parameters(&self, knob: &Knob) -> Value {
        let size = self.size;
        match &self.kind {
            Kind::Stribeck { speed_rad_s, exponent } => {
                json!({"extra_mnm": size, "speed_rad_s": speed_rad_s, "exponent": exponent})
            }
            Kind::Backlash { inner_share, stiffness_mnm_rad, damping_mnm_s_rad } => json!({
                "half_gap_rad": size, "inner_share_of_inertia": inner_share,
                "contact_stiffness_mnm_rad": stiffness_mnm_rad, "contact_damping_mnm_s_rad": damping_mnm_s_rad}),
            Kind::DetentHarmonics(shape) => match shape {
                DetentShape::Triangle => json!({"shape": "triangle", "share": size}),
                DetentShape::Sawtooth(rising) => json!({"shape": "sawtooth", "share": size, "rising_fraction": rising}),
                DetentShape::Harmonics(second, third, ratio) => json!({"shape": "harmonics", "second": size,
                    "second_phase_rad": second, "third": size * ratio, "third_phase_rad": third}),
            },
            Kind::MassImbalance { phase_rad } => json!({"amplitude_mnm": size, "phase_rad": phase_rad}),
            Kind::FrictionEccentricity { phase_rad } => json!({"depth": size, "phase_rad": phase_rad}),
            Kind::PreslidingHysteresis { .. } => json!({"bristle_rad": size}),
            Kind::ReturnSpring { centre_rad } => json!({"stiffness_mnm_rad": size, "centre_rad": centre_rad}),
            Kind::EndStop { stiffness_mnm_rad, damping_mnm_s_rad, .. } => {
                let [lower, upper] = self.stops();
                json!({"upper_rad": upper, "lower_rad": lower,
                    "stiffness_mnm_rad": stiffness_mnm_rad, "damping_mnm_s_rad": damping_mnm_s_rad})
            }
            Kind::QuadraticDrag => json!({"coefficient_mnm_s2_rad2": size}),
            Kind::ShaftCompliance { .. } => {
                let (stiffness, damping) = self.shaft().unwrap_or_default();
                json!({"resonance_hz": size, "stiffness_mnm_rad": stiffness, "damping_mnm_s_rad": damping})
            }
            Kind::FrictionDrift { time_constant_s } => {
                json!({"start_excess": size, "time_constant_s": time_constant_s})
            }
            Kind::Cogging { periods_per_turn, phase_rad } => {
                json!({"amplitude_mnm": size, "periods_per_turn": periods_per_turn, "phase_rad": phase_rad})
            }
            Kind::TorqueOffset { sign } => json!({"offset_mnm": sign * size}),
            Kind::SensorDelay => json!({"delay_s": size}),
            Kind::MainsHum { frequency_hz, phase_rad } | Kind::StrangeHum { frequency_hz, phase_rad } => {
                json!({"amplitude_mnm": size, "frequency_hz": frequency_hz, "phase_rad": phase_rad})
            }
            Kind::SensorSaturation => json!({"clip_mnm": size}),
            Kind::VaryingInertia { phase_rad } => json!({"depth": size, "phase_rad": phase_rad}),
            Kind::CubicSpring { centre_rad } => json!({"stiffness_mnm_rad3": size, "centre_rad": centre_rad}),
            Kind::FrictionStep { angle_rad } => json!({"excess": size, "angle_rad": angle_rad}),
            Kind::TorqueDrift { sign } => json!({"rate_mnm_s": sign * size}),
            Kind::EncoderEccentricity { phase_rad } => json!({"amplitude_rad": size, "phase_rad": phase_rad}),
            Kind::LoadFriction => json!({"coefficient": size}),
            Kind::GripSlips { times_s, signs } => json!({"slip_rad": size, "times_s": times_s, "signs": signs}),
            Kind::FrictionDropouts { times_s, length_s } => {
                json!({"depth": size, "times_s": times_s, "length_s": length_s})
            }
            Kind::RateLimitedSensor => json!({"limit_mnm_s": size}),
            Kind::DirectionalDetents => json!({"depth": size, "amplitude_mnm": knob.detent_amplitude}),
            Kind::SensorHysteresis { width_mnm } => json!({"height_mnm": size, "width_mnm": width_mnm}),
        }
    }

    /// Stiffness and damping of a compliant shaft, mNm/rad and mNm s/rad.
    pub fn shaft(&self) -> Option<(f64, f64)> {
        match &self.kind {
            Kind::ShaftCompliance { damping_ratio, inertia } => {
                let speed = TAU * self.size;
                Some((inertia * speed * speed, 2.0 * damping_ratio * inertia * speed))
            }
            _ => None,
        }
    }
}

/// A wave from −1 up to 1 and back, its zero at 0 on the rise, that rises over a fraction of its period.
fn tooth(x: f64, rising: f64) -> f64 {
    let turn = (x / TAU + 0.5 * rising).rem_euclid(1.0);
    if turn < rising { 2.0 * turn / rising - 1.0 } else { 1.0 - 2.0 * (turn - rising) / (1.0 - rising) }
}

/// Whole periods per turn that are no multiple of the detents', nor near one.
fn unrelated_periods(knob: &Knob, draw: &mut Draw) -> f64 {
    loop {
        let periods = (5 + draw.below(56)) as f64;
        let ratio = knob.detent_period.map_or(0.5, |period| periods * period);
        let nearest = ratio.round().max(1.0);
        if (ratio - nearest).abs() > 0.12 * nearest.min(2.0) {
            return periods;
        }
    }
}

/// Moments of a capture, apart from the rest at its start, in order.
fn times(count: usize, duration_s: f64, draw: &mut Draw) -> Vec<f64> {
    let mut times: Vec<f64> = (0..count).map(|_| draw.uniform(0.6, duration_s - 0.2)).collect();
    times.sort_by(f64::total_cmp);
    times
}
