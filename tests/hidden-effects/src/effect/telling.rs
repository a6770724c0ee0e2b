//! An effect's parameters as the answers tell them.

use serde_json::{Value, json};

use crate::effect::{DetentShape, Effect, Kind};
use crate::knob::Knob;

impl Effect {
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
}
