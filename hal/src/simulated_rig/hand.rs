//! A hand that holds the gripper: what turns a rendered knob.

use dynamics::{Axis, Excitation};

use super::ParameterError;

/// A pinch grip as a second-order impedance about an intended motion.
///
/// The form is that of C. J. Hasser and M. R. Cutkosky, *System identification of the human hand grasping a haptic
/// knob*, Haptic Symposium 2002: inertia, damping and stiffness are lumped, and what the person wants is the angle at
/// which the spring is slack. The hand's inertia turns with the gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Moment of inertia of the fingers, mNm·s²/rad.
    pub inertia: f64,
    /// Damping between fingers and intended motion, mNm·s/rad.
    pub damping: f64,
    /// Stiffness between fingers and intended motion, mNm/rad.
    pub stiffness_mnm_rad: f64,
}

impl Default for Grip {
    /// Two fingertips at 20 mm from the axis.
    ///
    /// For a fingertip in its own direction of motion, A. Z. Hajian and R. D. Howe, *Identification of the mechanical impedance
    /// at the human finger tip*, J. Biomech. Eng. 119 (1997), report some grams, some N·s/m and several hundred N/m, growing with
    /// the force of the grip. Taken here: 6 g, 4 N·s/m and 800 N/m.
    fn default() -> Self {
        Self::of_fingertips(2.0, 0.02, 0.006, 4.0, 800.0)
    }
}

impl Grip {
    /// The grip of `number` fingertips at `radius_m` from the axis, each with mass in kg, damping in N·s/m and
    /// stiffness in N/m.
    #[must_use]
    pub fn of_fingertips(number: f64, radius_m: f64, mass_kg: f64, damping_n_s_m: f64, stiffness_n_m: f64) -> Self {
        let about_the_axis = 1e3 * number * radius_m * radius_m;
        Self {
            inertia: about_the_axis * mass_kg,
            damping: about_the_axis * damping_n_s_m,
            stiffness_mnm_rad: about_the_axis * stiffness_n_m,
        }
    }
}

impl Grip {
    /// The usual grip of what has that axis.
    #[must_use]
    pub fn on(axis: Axis) -> Self {
        let Self { inertia, damping, stiffness_mnm_rad } = Self::default();
        let square = axis.fingertip_travel().powi(2);
        Self { inertia: inertia / square, damping: damping / square, stiffness_mnm_rad: stiffness_mnm_rad / square }
    }

    /// The inertia of a grip that can be, mNm·s²/rad.
    pub(super) fn validated(&self) -> Result<f64, ParameterError> {
        let fields = [
            ("grip's inertia", self.inertia),
            ("grip's damping", self.damping),
            ("grip's stiffness", self.stiffness_mnm_rad),
        ];
        match fields.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            Some((parameter, value)) => {
                Err(ParameterError { parameter, value, requirement: "zero or more, and finite" })
            }
            None => Ok(self.inertia),
        }
    }
}

/// What the person wants the knob to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Intention {
    /// A motion as a sweep has it, in rad.
    Motion(Excitation),
    /// A motion that was recorded: angles in rad, evenly spaced, the first one at time zero; held at the end.
    Recorded {
        /// Angles, rad.
        angle_rad: Vec<f64>,
        /// Samples per second.
        rate_hz: f64,
    },
    /// A torque that is applied whatever the knob does, mNm, rising over the first tenth of a second; inertia and
    /// damping of the fingers remain.
    Torque(f64),
}

/// A hand with what it wants. It knows the angle of the gripper that it holds and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand {
    /// How it holds the gripper.
    pub grip: Grip,
    /// What it wants.
    pub intention: Intention,
    /// Time at which it begins, after the first reading, s.
    pub begins_s: f64,
}

/// Time over which an applied torque rises, s.
const TORQUE_RISE_S: f64 = 0.1;

impl Hand {
    /// Torque on the gripper, mNm, its own inertia apart, for a gripper at this angle with this velocity.
    pub(super) fn torque_mnm(&self, time_s: f64, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        let since_s = (time_s - self.begins_s).max(0.0);
        let Grip { damping, stiffness_mnm_rad, .. } = self.grip;
        let (intended_rad, intended_rad_s) = match &self.intention {
            Intention::Torque(torque_mnm) => {
                return torque_mnm * (since_s / TORQUE_RISE_S).min(1.0) - damping * velocity_rad_s;
            }
            Intention::Motion(excitation) => {
                let setpoint = excitation.at(since_s);
                if since_s > 0.0 { (setpoint.value, setpoint.rate) } else { (0.0, 0.0) }
            }
            Intention::Recorded { angle_rad, rate_hz } => between(angle_rad, *rate_hz, since_s),
        };
        stiffness_mnm_rad * (intended_rad - angle_rad) + damping * (intended_rad_s - velocity_rad_s)
    }
}

/// Angle and velocity between two samples, from the first sample's angle on.
fn between(angle_rad: &[f64], rate_hz: f64, time_s: f64) -> (f64, f64) {
    let (Some(first), Some(last)) = (angle_rad.first(), angle_rad.last()) else { return (0.0, 0.0) };
    let position = time_s * rate_hz;
    let index = position as usize;
    match (angle_rad.get(index), angle_rad.get(index + 1)) {
        (Some(here), Some(next)) => (here + position.fract() * (next - here) - first, (next - here) * rate_hz),
        _ => (last - first, 0.0),
    }
}
