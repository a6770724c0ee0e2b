//! The position servo: PID with a notch at the shaft's resonance, and the load's torque fed forward.
//!
//! Measured on the simulated rig with the paper's knobs, 10 s of `linear-chirp` at 10 kHz, one tick
//! of delay: plain PD with these gains or higher rings at the resonance of rotor and gripper over the
//! torque sensor (about 1 kHz) until the sensor's limit ends the run; the notch takes that away. The
//! knob's torque is unknown but measured, so most of it is fed forward, which halves the following
//! error with knobs that stick.
//!
//! A bare gripper is another matter: with so little behind the torque sensor the resonance is twice as high, out of
//! the notch, and the encoder's steps, differentiated, keep it ringing. There the load is known beforehand, and notch
//! and damping follow from it: [`ServoGains::for_free_gripper`].

use biquad::{Biquad as _, Coefficients, DirectForm2Transposed};
use dynamics::{Calibration, Setpoint};
use hal::{Measurement, TorqueSource};
use serde::{Deserialize, Serialize};

use super::lowpass::ButterworthLowPass;
use crate::stability::ACTUATOR_DELAY_S;

/// Gains of the position servo.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoGains {
    /// Torque per error of the angle, mNm/rad.
    pub proportional_mnm_rad: f64,
    /// Torque per error of the speed, mNm·s/rad.
    pub derivative_mnm_s_rad: f64,
    /// Torque per error of the angle and second, mNm/(rad·s).
    pub integral_mnm_rad_s: f64,
    /// Most torque that the integral may hold, mNm.
    pub integral_limit_mnm: f64,
    /// Share of the measured load torque that is fed forward.
    pub load_share: f64,
    /// Edge of the load torque's low-pass, Hz.
    pub load_edge_hz: f64,
    /// Damping ratio of the notch's zeros: its depth.
    pub notch_depth: f64,
    /// Damping ratio of the notch's poles: its width.
    pub notch_width: f64,
    /// Whether nothing is on the gripper, so that the resonance is known.
    pub free_gripper: bool,
    /// Time constant of the low-pass on the error of the speed, s; zero for none.
    #[serde(default)]
    pub speed_lag_s: f64,
}

/// Damping ratio at which a rig without a knob follows.
const FREE_DAMPING_RATIO: f64 = 0.85;
/// Width of its notch: poles at a sixth of the resonance and at six times it, so that it is a low-pass for all between.
const FREE_NOTCH_WIDTH: f64 = 3.0;

impl Default for ServoGains {
    /// Gains that hold each of the paper's knobs, and up to 2 mNm·s²/rad, at 5 to 20 kHz with a tick of delay.
    fn default() -> Self {
        Self {
            proportional_mnm_rad: 4_000.0,
            derivative_mnm_s_rad: 30.0,
            integral_mnm_rad_s: 40_000.0,
            integral_limit_mnm: 200.0,
            load_share: 0.6,
            load_edge_hz: 90.0,
            notch_depth: 0.1,
            notch_width: 1.0,
            free_gripper: false,
            speed_lag_s: 0.0,
        }
    }
}

/// Most acceleration that the damping makes of one step of the encoder, rad/s²: what the default gains make of the simulated rig's
/// at 20 kHz.
const LARGEST_STEP_RAD_S2: f64 = 300.0;
/// Inertia of the rig that the default gains were measured on, mNm·s²/rad: rotor, coupling and gripper.
const REFERENCE_INERTIA: f64 = 0.0199;
/// Most that the phase may fall behind at the frequency where the loop's gain passes one, rad: what the default gains have at
/// 5 kHz, where they hold each of the paper's knobs.
const LARGEST_PHASE_LAG: f64 = 0.7;
/// Mean delay of a torque in addition to the known delays of the rig, in ticks: half a tick of holding, half a tick of
/// differentiating the angle, and half a tick of computing.
const LATE_TICKS: f64 = 1.5;

/// Most ticks in a row through which a filter runs: by then it has settled at any rate, and a tick's work stays short.
const MOST_FILTERED_TICKS: u64 = 128;

impl ServoGains {
    /// Gains for a rig at a rate: as stiff as its inertia and its delay permit.
    ///
    /// With a damping D and an inertia J the loop's gain passes one at the angular frequency D/J, where the phase lag is D/J times
    /// the delay. So gains are proportional to the inertia; where the delay is longer than they bear, all frequencies come down by
    /// one factor: the stiffness by its square, the integral gain by its cube.
    #[must_use]
    pub fn for_rig(calibration: &Calibration, torque: TorqueSource, rate_hz: f64, torque_delay_ticks: f64) -> Self {
        let gains = Self::default();
        let heavier = (calibration.motor_inertia + calibration.gripper_inertia) / REFERENCE_INERTIA;
        let delay_s =
            (LATE_TICKS + torque_delay_ticks) / rate_hz + calibration.command_delay_s.unwrap_or(ACTUATOR_DELAY_S);
        let crossover_rad_s = gains.derivative_mnm_s_rad / REFERENCE_INERTIA;
        let speed_lag_s = speed_lag_s(calibration.angle_step_rad, crossover_rad_s, delay_s, rate_hz);
        let slower = slower(crossover_rad_s, delay_s + speed_lag_s);
        Self {
            integral_limit_mnm: gains.integral_limit_mnm / calibration.axis.fingertip_travel(),
            proportional_mnm_rad: heavier * slower * slower * gains.proportional_mnm_rad,
            derivative_mnm_s_rad: heavier * slower * gains.derivative_mnm_s_rad,
            integral_mnm_rad_s: heavier * slower.powi(3) * gains.integral_mnm_rad_s,
            load_edge_hz: slower * gains.load_edge_hz,
            // The motor's own torque, fed forward as a load, would sustain itself.
            load_share: if torque == TorqueSource::Motor { 0.0 } else { gains.load_share },
            speed_lag_s,
            ..gains
        }
    }

    /// By how much the torque jumps at a step of the encoder, mNm.
    #[must_use]
    pub fn jump_mnm(&self, angle_step_rad: f64, rate_hz: f64) -> f64 {
        let over_s = self.speed_lag_s.max(rate_hz.recip());
        angle_step_rad * (self.derivative_mnm_s_rad / over_s + self.proportional_mnm_rad)
    }

    /// Gains for a rig with nothing on its gripper.
    ///
    /// The spring of the proportional gain and the rig's own inertia form an oscillator. It gets no more damping than it needs,
    /// since differentiated encoder steps shake gripper and rotor. No load torque is fed forward, since there is no load.
    #[must_use]
    pub fn for_free_gripper(self, calibration: &Calibration) -> Self {
        let gains = self;
        let inertia = calibration.motor_inertia + calibration.gripper_inertia;
        let damping_mnm_s_rad = 2.0 * FREE_DAMPING_RATIO * (gains.proportional_mnm_rad * inertia).sqrt();
        Self {
            derivative_mnm_s_rad: damping_mnm_s_rad.min(gains.derivative_mnm_s_rad),
            load_share: 0.0,
            notch_width: FREE_NOTCH_WIDTH,
            free_gripper: true,
            ..gains
        }
    }
}

/// Factor by which all frequencies of the default gains come down where the torque is late by `delay_s`.
fn slower(crossover_rad_s: f64, delay_s: f64) -> f64 {
    (LARGEST_PHASE_LAG / (crossover_rad_s * delay_s)).min(1.0)
}

/// Time constant of the low-pass on the speed that keeps a step of the encoder from shaking the rig; zero where none is needed.
///
/// A step s in a tick is a speed of s·rate for that tick; behind a low-pass of time constant τ it is s/τ at most. With the
/// crossover ω, which comes down as τ grows, it accelerates the rig by ω·s/τ. That acceleration falls with τ; bisection finds the
/// least τ that is enough.
fn speed_lag_s(angle_step_rad: f64, crossover_rad_s: f64, delay_s: f64, rate_hz: f64) -> f64 {
    let makes_rad_s2 = |lag_s: f64| {
        slower(crossover_rad_s, delay_s + lag_s) * crossover_rad_s * angle_step_rad / lag_s.max(rate_hz.recip())
    };
    if makes_rad_s2(0.0) <= LARGEST_STEP_RAD_S2 {
        return 0.0;
    }
    let (mut too_short_s, mut enough_s) = (rate_hz.recip(), LONGEST_SPEED_LAG_S);
    for _ in 0..40 {
        let middle_s = 0.5 * (too_short_s + enough_s);
        match makes_rad_s2(middle_s) <= LARGEST_STEP_RAD_S2 {
            true => enough_s = middle_s,
            false => too_short_s = middle_s,
        }
    }
    enough_s
}

/// Longest time constant of that low-pass, s. An encoder too coarse for it makes the torque shake, which is reported.
const LONGEST_SPEED_LAG_S: f64 = 5e-3;

/// Frequency of the notch, Hz.
///
/// With any knob the shaft resonates at or above √(k/J), J being the inertia on the motor's side: there the notch is. Without a knob
/// it is where rotor and gripper swing against each other, unless the rate is too low for that frequency.
fn notch_hz(calibration: &Calibration, free_gripper: bool, rate_hz: f64) -> f64 {
    let of = |inverse_inertia: f64| {
        (calibration.torque_sensor_stiffness_mnm_rad * inverse_inertia).sqrt() / std::f64::consts::TAU
    };
    let loaded_hz = of(calibration.motor_inertia.recip());
    let free_hz = of(calibration.motor_inertia.recip() + calibration.gripper_inertia.recip());
    if free_gripper && free_hz < 0.45 * rate_hz { free_hz } else { loaded_hz }
}

/// The servo with its state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Servo {
    gains: ServoGains,
    rig_inertia: f64,
    gripper_inertia: f64,
    torque_zero_mnm: f64,
    /// `None` where the resonance is beyond what the rate can hold: then the gains are too low to reach it.
    notch: Option<DirectForm2Transposed<f64>>,
    load: ButterworthLowPass<1>,
    integral_mnm: f64,
    /// Error of the speed behind a low-pass of first order.
    lagged_speed_error_rad_s: f64,
    /// What the filters were given last.
    feedback_mnm: f64,
    load_mnm: f64,
    tick_s: f64,
}

impl Servo {
    /// A servo at rest; `None` when the rate is too low for its filters.
    pub(super) fn new(gains: ServoGains, calibration: &Calibration, rate_hz: f64) -> Option<Self> {
        let resonance_hz = notch_hz(calibration, gains.free_gripper, rate_hz);
        Some(Self {
            gains,
            rig_inertia: calibration.motor_inertia + calibration.gripper_inertia,
            gripper_inertia: calibration.gripper_inertia,
            torque_zero_mnm: calibration.torque_zero_mnm,
            notch: notch(resonance_hz, gains.notch_depth, gains.notch_width, rate_hz).map(DirectForm2Transposed::new),
            load: ButterworthLowPass::new(gains.load_edge_hz, rate_hz)?,
            integral_mnm: 0.0,
            lagged_speed_error_rad_s: 0.0,
            feedback_mnm: 0.0,
            load_mnm: 0.0,
            tick_s: rate_hz.recip(),
        })
    }

    /// Torque that follows `setpoint`, mNm, so many ticks after the last one.
    pub(super) fn torque_mnm(
        &mut self,
        setpoint: &Setpoint,
        measurement: &Measurement,
        velocity_rad_s: f64,
        elapsed_ticks: u64,
    ) -> f64 {
        let step_s = elapsed_ticks as f64 * self.tick_s;
        let angle_error_rad = setpoint.value - measurement.angle_rad;
        let limit_mnm = self.gains.integral_limit_mnm;
        self.integral_mnm =
            (self.integral_mnm + self.gains.integral_mnm_rad_s * angle_error_rad * step_s).clamp(-limit_mnm, limit_mnm);
        let feedback_mnm = self.gains.proportional_mnm_rad * angle_error_rad
            + self.damping_mnm(setpoint.rate - velocity_rad_s, step_s)
            + self.integral_mnm;
        let load_mnm = measurement.torque_mnm - self.torque_zero_mnm - self.gripper_inertia * setpoint.acceleration;
        let filtered_mnm = self.notched_mnm(feedback_mnm, elapsed_ticks);
        let carried_mnm = across_ticks(elapsed_ticks, self.load_mnm, load_mnm, |input| self.load.run(input));
        self.load_mnm = load_mnm;
        self.rig_inertia * setpoint.acceleration + filtered_mnm + self.gains.load_share * carried_mnm
    }

    /// Torque that brakes wherever the knob is, mNm, so many ticks after the last one.
    pub(super) fn braking_mnm(&mut self, velocity_rad_s: f64, elapsed_ticks: u64) -> f64 {
        let damping_mnm = self.damping_mnm(-velocity_rad_s, elapsed_ticks as f64 * self.tick_s);
        self.notched_mnm(damping_mnm, elapsed_ticks)
    }

    fn damping_mnm(&mut self, speed_error_rad_s: f64, step_s: f64) -> f64 {
        let lag_s = self.gains.speed_lag_s;
        self.lagged_speed_error_rad_s = match lag_s > 0.0 {
            true => {
                self.lagged_speed_error_rad_s
                    - (speed_error_rad_s - self.lagged_speed_error_rad_s) * (-step_s / lag_s).exp_m1()
            }
            false => speed_error_rad_s,
        };
        self.gains.derivative_mnm_s_rad * self.lagged_speed_error_rad_s
    }

    fn notched_mnm(&mut self, feedback_mnm: f64, elapsed_ticks: u64) -> f64 {
        let before_mnm = std::mem::replace(&mut self.feedback_mnm, feedback_mnm);
        self.notch.as_mut().map_or(feedback_mnm, |notch| {
            across_ticks(elapsed_ticks, before_mnm, feedback_mnm, |input| notch.run(input))
        })
    }
}

/// Runs a filter once for each elapsed tick, on inputs interpolated linearly between the last one and the new one; gives its output.
///
/// If a filter ran only in the ticks that are served, its frequencies would fall with their rate and the resonance would ring: where
/// a host missed every other tick at 5 kHz, the simulated rig with knob 3 reached the sensor's limit within 20 ms. Run for each
/// tick, the servo bears seven of eight ticks missed at 5 and 10 kHz, and five of six at 20 kHz.
pub(super) fn across_ticks(elapsed_ticks: u64, from: f64, to: f64, mut run: impl FnMut(f64) -> f64) -> f64 {
    let ticks = elapsed_ticks.min(MOST_FILTERED_TICKS);
    for tick in 1..ticks {
        run(from + (to - from) * tick as f64 / ticks as f64);
    }
    run(to)
}

/// A notch (s² + 2·depth·ω·s + ω²)/(s² + 2·width·ω·s + ω²) by the bilinear transform, its frequency kept.
///
/// `None` when the frequency is not below half the rate: then there is nothing to keep out.
pub(crate) fn notch(frequency_hz: f64, depth: f64, width: f64, rate_hz: f64) -> Option<Coefficients<f64>> {
    if !(frequency_hz > 0.0 && frequency_hz < 0.5 * rate_hz) {
        return None;
    }
    let k = (std::f64::consts::PI * frequency_hz / rate_hz).tan();
    let polynomial =
        |damping: f64| [1.0 + 2.0 * damping * k + k * k, 2.0 * (k * k - 1.0), 1.0 - 2.0 * damping * k + k * k];
    let (zeros, poles) = (polynomial(depth), polynomial(width));
    Some(Coefficients {
        b0: zeros[0] / poles[0],
        b1: zeros[1] / poles[0],
        b2: zeros[2] / poles[0],
        a1: poles[1] / poles[0],
        a2: poles[2] / poles[0],
    })
}

#[cfg(test)]
mod tests {
    use super::{ServoGains, notch_hz};
    use dynamics::Calibration;
    use hal::TorqueSource;

    /// Rotor and gripper of 1 and 3 mNm·s²/rad on a spring of 3·(2π·100 Hz)²/4 mNm/rad: 100 Hz against each other.
    fn calibration() -> Calibration {
        Calibration {
            axis: dynamics::Axis::Rotary,
            motor_inertia: 1.0,
            gripper_inertia: 3.0,
            torque_sensor_stiffness_mnm_rad: 0.75 * (std::f64::consts::TAU * 100.0).powi(2),
            torque_zero_mnm: 0.0,
            torque_delay_s: 0.0,
            acceleration_zero_rad_s2: 0.0,
            acceleration_delay_s: 0.0,
            gravity_amplitude_rad_s2: 0.0,
            gravity_phase_rad: 0.0,
            angle_step_rad: 0.0,
            torque_step_mnm: 0.0,
            acceleration_step_rad_s2: 0.0,
            motor_coulomb_mnm: None,
            motor_viscous: None,
            command_delay_s: None,
            motor_cogging: None,
        }
    }

    #[test]
    fn without_a_knob_the_notch_lies_where_rotor_and_gripper_swing_against_each_other() {
        assert!((notch_hz(&calibration(), true, 5_000.0) - 100.0).abs() < 1e-9);
        assert!((notch_hz(&calibration(), false, 5_000.0) - 100.0 * 0.75_f64.sqrt()).abs() < 1e-9);
        assert!((notch_hz(&calibration(), true, 200.0) - 100.0 * 0.75_f64.sqrt()).abs() < 1e-9, "too slow a rate");
    }

    #[test]
    fn a_coarse_encoder_makes_the_servo_slower_and_not_louder() {
        let rig = |counts: f64| Calibration {
            motor_inertia: 0.02,
            gripper_inertia: 0.0,
            angle_step_rad: std::f64::consts::TAU / counts,
            ..calibration()
        };
        let gains = |counts: f64| ServoGains::for_rig(&rig(counts), TorqueSource::Sensor, 5_000.0, 1.0);
        assert_eq!(gains(640_000.0).speed_lag_s, 0.0);
        let (fine, coarse) = (gains(640_000.0), gains(4_000.0));
        assert!(coarse.derivative_mnm_s_rad < fine.derivative_mnm_s_rad && coarse.speed_lag_s > 1e-3, "{coarse:?}");
        let step_rad = std::f64::consts::TAU / 4_000.0;
        let (before_mnm, after_mnm) = (fine.jump_mnm(step_rad, 5_000.0), coarse.jump_mnm(step_rad, 5_000.0));
        assert!(before_mnm > 50.0 && after_mnm < 7.0, "{before_mnm} and {after_mnm} mNm");
    }

    #[test]
    fn a_free_gripper_is_never_damped_more_than_a_knob() {
        let heavy = ServoGains::default().for_free_gripper(&calibration());
        assert!(heavy.derivative_mnm_s_rad <= ServoGains::default().derivative_mnm_s_rad);
        let light = ServoGains::default().for_free_gripper(&Calibration {
            motor_inertia: 0.016,
            gripper_inertia: 0.004,
            ..calibration()
        });
        assert!((light.derivative_mnm_s_rad - 1.7 * 80.0_f64.sqrt()).abs() < 1e-9);
    }
}
