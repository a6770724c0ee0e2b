//! How firmly the virtual body is held to the rotor.

use dynamics::Axis;
use serde::{Deserialize, Serialize};

/// What holds the virtual body to the rotor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderGains {
    /// Stiffness of the coupling, mNm/rad.
    pub stiffness_mnm_rad: f64,
    /// Damping of the coupling, mNm·s/rad.
    pub damping: f64,
    /// Time by which the body is ahead of the rotor, s: the torque that it feels reaches the shaft as much later.
    ///
    /// Without it a spring would be felt after its angle, and give out energy at every swing: the condition b > K·T/2 of
    /// Colgate and Schenkel.
    pub lead_s: f64,
    /// Edge below which the hand's torque is taken from the torque sensor, Hz.
    pub slow_edge_hz: f64,
    /// Damping ratio of that filter.
    pub slow_damping: f64,
    /// Edge frequency below which torques of the angle are taken at the rotor's angle instead of the body's, Hz; zero takes them at the
    /// body's angle alone, as in recordings without this value.
    #[serde(default)]
    pub place_edge_hz: f64,
    /// Frequency of the notch, Hz.
    pub notch_hz: f64,
    /// Damping ratio of the notch's zeros, at the resonance of rotor and gripper: its depth.
    pub notch_depth: f64,
    /// Damping ratio of the notch's poles: its width.
    pub notch_width: f64,
    /// Energy that the coupling may give out before the guard takes it back, mNm·rad.
    pub slack: f64,
}

/// Rate from which on the softer of the drawn gains are safe, Hz: the slower of the rates of Swindells and MacLean.
const MEDIUM_RATE_HZ: f64 = 5_000.0;
/// Rate from which on the stiffer gains are safe, Hz.
const FAST_RATE_HZ: f64 = 10_000.0;

impl RenderGains {
    /// The gains at a sample rate.
    ///
    /// Chosen among gains drawn at random (example `choose_gains`) under which no hand of the class can make a knob swing, at
    /// rest or with any inertia from that of rotor and gripper alone to 0.6 mNm·s²/rad (zero exclusion,
    /// [`Port`](crate::stability::Port)). Other gains carry up to 1.8 times as much of a slow load; these are rounded, and gains
    /// beside them were found safe too. The lead is a compromise between the delay that it leaves to a spring and the lead that
    /// is too much for an inertia.
    ///
    /// Below the slower of the two rates all frequencies come down with it. Whether that is enough on a rig is for
    /// [`gains_for`](crate::stability::gains_for) to say.
    #[must_use]
    pub fn at_rate(rate_hz: f64) -> Self {
        let lead_s = 0.4 / rate_hz;
        if rate_hz >= FAST_RATE_HZ {
            Self {
                stiffness_mnm_rad: 7_000.0,
                damping: 68.0,
                lead_s,
                slow_edge_hz: 50.0,
                slow_damping: 4.0,
                place_edge_hz: 100.0,
                notch_hz: 1_100.0,
                notch_depth: 0.1,
                notch_width: 0.8,
                slack: SLACK,
            }
        } else {
            let medium = Self {
                stiffness_mnm_rad: 3_000.0,
                damping: 50.0,
                lead_s,
                slow_edge_hz: 30.0,
                slow_damping: 3.0,
                place_edge_hz: 100.0,
                notch_hz: 1_050.0,
                notch_depth: 0.07,
                notch_width: 2.9,
                slack: SLACK,
            };
            medium.slower((rate_hz / MEDIUM_RATE_HZ).min(1.0))
        }
    }

    /// These gains with all frequencies of the coupling multiplied by `times`.
    #[must_use]
    pub fn slower(self, times: f64) -> Self {
        Self {
            stiffness_mnm_rad: times * times * self.stiffness_mnm_rad,
            damping: times * self.damping,
            slow_edge_hz: times * self.slow_edge_hz,
            place_edge_hz: times * self.place_edge_hz,
            ..self
        }
    }
}

impl RenderGains {
    /// The same for a rig of that axis: hands and rigs that press are like those that turn, at the fingertips.
    #[must_use]
    pub fn on(self, axis: Axis) -> Self {
        let square = axis.fingertip_travel().powi(2);
        Self { stiffness_mnm_rad: self.stiffness_mnm_rad / square, damping: self.damping / square, ..self }
    }
}

/// Energy that the guard lets out, mNm·rad: as much as the coupling's spring stores at 120 mNm, and more than noise and steps of
/// the sensors add to the energy balance.
const SLACK: f64 = 1.0;
