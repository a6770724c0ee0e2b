//! Draws an effect: the numbers that stay, and the limits of the one that is scaled.

use crate::draw::Draw;
use crate::effect::{CATALOGUE, DetentShape, Effect, Kind, OUTSIDE};
use crate::knob::{Knob, Wish};

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
