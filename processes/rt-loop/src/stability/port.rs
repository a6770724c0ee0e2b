//! What a hand feels of the loop, frequency by frequency.

use biquad::Coefficients;
use dynamics::{Axis, Calibration};
use num_complex::Complex64;

use crate::control::notch;
use crate::control::rendering::{RenderGains, slow_part, taken_in};

/// What the virtual body is, as far as small motions go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinearModel {
    /// It slides: inertia of the model with rotor and gripper, mNm·s²/rad, damping, mNm·s/rad, and stiffness, mNm/rad.
    Sliding {
        /// Inertia, mNm·s²/rad.
        inertia: f64,
        /// Damping, mNm·s/rad.
        damping: f64,
        /// Stiffness, mNm/rad.
        stiffness_mnm_rad: f64,
    },
    /// It sticks.
    Stuck,
    /// A cap behind which an inner body turns, or sticks, on a contact or a shaft.
    TwoBodies {
        /// Inertia of the cap with rotor and gripper, mNm·s²/rad.
        cap_inertia: f64,
        /// Stiffness of the contact, mNm/rad.
        stiffness_mnm_rad: f64,
        /// Damping of the contact, mNm·s/rad.
        damping: f64,
        /// The inner body; `None` where it sticks.
        inner: Option<InnerPart>,
    },
}

/// What turns behind a contact or a shaft, as far as small motions go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnerPart {
    /// Inertia, mNm·s²/rad.
    pub inertia: f64,
    /// Damping, mNm·s/rad.
    pub damping: f64,
    /// Stiffness, mNm/rad.
    pub stiffness_mnm_rad: f64,
}

/// The rig with its loop, seen from the gripper.
///
/// The loop is linear and sampled. A hand moves slowly compared with the sample rate, so what is aliased from beyond half the
/// rate is neglected, as by J. E. Colgate and G. G. Schenkel in their comparison with the continuous system (*Passivity of a
/// class of sampled-data systems*, J. Robotic Systems 14, 1997).
#[derive(Clone, Copy, Debug)]
pub struct Port {
    gains: RenderGains,
    motor_inertia: f64,
    gripper_inertia: f64,
    viscous: f64,
    stiffness_mnm_rad: f64,
    torque_delay_s: f64,
    resonance_hz: f64,
    rate_hz: f64,
    actuator_delay_s: f64,
}

/// Time that the current takes after a command where the calibration does not know, s: an amplifier of 3 kHz.
pub(crate) const ACTUATOR_DELAY_S: f64 = 53e-6;
/// Damping of the torque sensor, as a share of the critical: a metal spring hardly damps.
pub(crate) const SENSOR_DAMPING_RATIO: f64 = 0.01;

impl Port {
    /// The rig with this calibration under these gains.
    #[must_use]
    pub fn new(gains: RenderGains, calibration: &Calibration, rate_hz: f64) -> Self {
        Self {
            gains,
            motor_inertia: calibration.motor_inertia,
            gripper_inertia: calibration.gripper_inertia,
            viscous: calibration.motor_viscous.unwrap_or(0.0),
            stiffness_mnm_rad: calibration.torque_sensor_stiffness_mnm_rad,
            torque_delay_s: calibration.torque_delay_s.max(0.0),
            resonance_hz: gains.notch_hz,
            rate_hz,
            actuator_delay_s: calibration.command_delay_s.unwrap_or(ACTUATOR_DELAY_S),
        }
    }

    /// The same with an amplifier that is so much later, s.
    #[must_use]
    pub fn delayed(self, by_s: f64) -> Self {
        Self { actuator_delay_s: self.actuator_delay_s + by_s, ..self }
    }

    /// Torque of a hand over the velocity of the gripper at the angular frequency `omega`, mNm·s/rad.
    #[must_use]
    pub fn impedance(&self, omega: f64, model: &LinearModel) -> Complex64 {
        let step_s = self.rate_hz.recip();
        let s = Complex64::new(0.0, omega);
        let z = (s * step_s).exp();
        let hold = (1.0 - z.inv()) / (s * step_s) * (-s * self.actuator_delay_s).exp();
        let of_z = |c: Option<Coefficients<f64>>| {
            c.map_or(Complex64::ONE, |c| (c.b0 + c.b1 / z + c.b2 / (z * z)) / (1.0 + c.a1 / z + c.a2 / (z * z)))
        };
        let slow = of_z(slow_part(self.gains.slow_edge_hz, self.gains.slow_damping, self.rate_hz))
            * (-s * self.torque_delay_s).exp();
        let notch = of_z(notch(self.resonance_hz, self.gains.notch_depth, self.gains.notch_width, self.rate_hz));
        let RenderGains { stiffness_mnm_rad, damping, lead_s, place_edge_hz, .. } = self.gains;
        // Torque of the coupling per angle of the rotor and per velocity of the body.
        let of_rotor = notch * (stiffness_mnm_rad + (damping + stiffness_mnm_rad * lead_s) * (1.0 - z.inv()) / step_s);
        // Angle of the body per its velocity: the trapezium that the body is integrated with.
        let angle_per_velocity = 0.5 * step_s * (z + 1.0) / (z - 1.0);
        let of_body = notch * (stiffness_mnm_rad * angle_per_velocity + damping);
        // Share of the angle from body to rotor by which torques of the angle are taken further on; the resulting torque per rotor angle.
        let taken_in = taken_in(place_edge_hz, step_s);
        let further = taken_in / (1.0 - (1.0 - taken_in) / z);
        let of_place = match *model {
            LinearModel::Sliding { stiffness_mnm_rad, .. } => {
                stiffness_mnm_rad * further * (1.0 + lead_s * (1.0 - z.inv()) / step_s)
            }
            LinearModel::Stuck | LinearModel::TwoBodies { .. } => Complex64::ZERO,
        };
        // The motor's own friction is felt anyway, and is not rendered once more.
        let rendered = |damping: f64| (damping - self.viscous).max(0.0);
        // The body: inertia·(z − 1)/T·ω = drive − torques of the model.
        let body = match *model {
            LinearModel::Stuck => None,
            LinearModel::Sliding { inertia, damping, stiffness_mnm_rad } => Some(
                (inertia - self.gripper_inertia) * (z - 1.0) / step_s
                    + rendered(damping) * z
                    + stiffness_mnm_rad * (angle_per_velocity * (1.0 - further) + 0.5 * step_s),
            ),
            LinearModel::TwoBodies { cap_inertia, stiffness_mnm_rad, damping, inner } => {
                // Spring at the middle of a tick, damper at its end.
                let contact = stiffness_mnm_rad * (angle_per_velocity + 0.25 * step_s * (z + 1.0)) + damping * z;
                let behind = inner.map_or(contact, |inner| {
                    let inner = inner.inertia * (z - 1.0) / step_s
                        + rendered(inner.damping) * z
                        + inner.stiffness_mnm_rad * (angle_per_velocity + 0.5 * step_s);
                    contact * inner / (contact + inner)
                });
                Some((cap_inertia - self.gripper_inertia) * (z - 1.0) / step_s + behind)
            }
        };
        // drive = −slow·Ts + of_rotor·θ − of_body·ω_body; the command is J·(z − 1)/T·ω_body − drive.
        let (drive_of_sensor, drive_of_rotor, body_of_sensor, body_of_rotor) = match body {
            None => (-slow, of_rotor, Complex64::ZERO, Complex64::ZERO),
            Some(body) => {
                let total = body + of_body;
                let (by_sensor, by_rotor) = (-slow / total, (of_rotor - of_place) / total);
                (-slow - of_body * by_sensor, of_rotor - of_body * by_rotor, by_sensor, by_rotor)
            }
        };
        let forward = self.motor_inertia * (z - 1.0) / step_s;
        let command_of_sensor = hold * (forward * body_of_sensor - drive_of_sensor);
        let command_of_rotor = hold * (forward * body_of_rotor - drive_of_rotor);
        // Rotor: (J·s² + b·s)·θ = command − Ts, so that Ts = rotor·θ.
        let rotor = (command_of_rotor - self.motor_inertia * s * s - self.viscous * s) / (1.0 - command_of_sensor);
        let inertia =
            self.motor_inertia * self.gripper_inertia / (self.motor_inertia + self.gripper_inertia).max(1e-12);
        let sensor = self.stiffness_mnm_rad
            + s * 2.0 * SENSOR_DAMPING_RATIO * (self.stiffness_mnm_rad * inertia.max(1e-6)).sqrt();
        // Ts = sensor·(θ − θg) = rotor·θ.
        let sensor_of_gripper = rotor * sensor / (sensor - rotor);
        (self.gripper_inertia * s * s - sensor_of_gripper) / s
    }

    /// Whether no hand of the class can make it swing: zero exclusion over its impedances.
    ///
    /// A swing that neither grows nor dies needs a hand with impedance + loop = 0. Where the loop's real part is not
    /// negative no passive hand has that; where it is, the loop's imaginary part must lie beyond what spring and inertia
    /// of such a hand can cancel.
    #[must_use]
    pub fn is_safe(&self, model: &LinearModel, hands: &Hands) -> bool {
        self.first_unsafe_hz(model, hands).is_none()
    }

    /// The lowest frequency at which one of these hands could make the rendered knob oscillate, Hz.
    #[must_use]
    pub fn first_unsafe_hz(&self, model: &LinearModel, hands: &Hands) -> Option<f64> {
        self.frequencies_hz().find(|frequency_hz| {
            let omega = std::f64::consts::TAU * frequency_hz;
            let impedance = self.impedance(omega, model);
            // Stiffness of the softest grip that cancels the loop's mass-like part, and the dampings that such a grip may have.
            let stiffness_mnm_rad = (omega * impedance.im).max(0.0);
            let damping = stiffness_mnm_rad / hands.relaxation_per_s..=hands.damping;
            damping.contains(&-impedance.re)
                && stiffness_mnm_rad <= hands.stiffness_mnm_rad
                && -impedance.im <= hands.inertia * omega
        })
    }

    /// The frequencies to check, Hz: in steps of 3 % up to half the rate, and of 0.5 % around the resonance of rotor and gripper,
    /// beyond half the rate too.
    ///
    /// A resonance beyond half the rate is sampled and fed back like one below it: the loop's filters are periodic in frequency, and
    /// the hold lets a share through. Beside that resonance the other frequencies with the same alias are negligible.
    fn frequencies_hz(&self) -> impl Iterator<Item = f64> {
        let resonance_hz = |inverse_inertia: f64| {
            let hz = (self.stiffness_mnm_rad * inverse_inertia).sqrt() / std::f64::consts::TAU;
            hz.min(RIGID_HZ)
        };
        let loaded_hz = RESONANCE_MARGIN.recip() * resonance_hz(self.motor_inertia.recip());
        let free_hz = RESONANCE_MARGIN * resonance_hz(self.motor_inertia.recip() + self.gripper_inertia.recip());
        ladder(0.1, 0.5 * self.rate_hz, 1.03).chain(ladder(loaded_hz, free_hz, 1.005))
    }
}

/// Resonance from which on a torque sensor counts as rigid, Hz; a calibration that knows no stiffness has one far beyond.
const RIGID_HZ: f64 = 20_000.0;
/// Factor by which a resonance may differ from what the calibration gives.
const RESONANCE_MARGIN: f64 = 1.1;

/// From `first` to `last`, each so many times the one before.
fn ladder(first: f64, last: f64, times: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(first), move |value| Some(value * times)).take_while(move |value| *value < last)
}

/// A class of hands: every passive second-order grip within these limits, and no hand at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hands {
    /// Stiffest grip, mNm/rad.
    pub stiffness_mnm_rad: f64,
    /// Heaviest, mNm·s²/rad.
    pub inertia: f64,
    /// Most stiffness per damping, 1/s: a stiff grip is a firm one, and damps in proportion.
    pub relaxation_per_s: f64,
    /// Largest damping, mNm·s/rad.
    pub damping: f64,
}

impl Hands {
    /// The class of those that hold what has that axis.
    #[must_use]
    pub fn on(axis: Axis) -> Self {
        let hands = Self::default();
        let square = axis.fingertip_travel().powi(2);
        Self {
            stiffness_mnm_rad: hands.stiffness_mnm_rad / square,
            inertia: hands.inertia / square,
            damping: hands.damping / square,
            ..hands
        }
    }
}

impl Default for Hands {
    /// Ten times as stiff as a usual pinch grip with at least a fifth of the damping that goes with it, thirty times as damped and four times as heavy: a knob cap may be on the gripper.
    fn default() -> Self {
        Self { stiffness_mnm_rad: 6_400.0, inertia: 0.02, relaxation_per_s: 1_000.0, damping: 100.0 }
    }
}
