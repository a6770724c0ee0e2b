//! What an effect does to the body that slides.

use std::f64::consts::TAU;

use crate::effect::{DetentShape, Effect, Kind, State};

impl Effect {
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
