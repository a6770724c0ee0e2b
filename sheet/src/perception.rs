//! Would a hand feel it? Differences as numbers of thresholds, by a model of people.
//!
//! A threshold is a fraction of what the whole control takes, not of the part that differs: friction hides behind strong detents. The
//! Delft group found this for a linear control's frequency response: the least difference that people notice in its real or imaginary
//! part is the same fraction of the magnitude |H(jω)| of the whole (W. Fu, M. M. van Paassen, M. Mulder, *Human threshold model for
//! perceiving changes in system dynamics*, IEEE Trans. Human-Machine Syst. 50, 2020, 444–453). For a nonlinear control, the RMS of its
//! torque along a usual motion stands for |H|; for a linear control the two are equivalent. The fractions were measured with fingers;
//! each comes with its source. People differ, and so does their attention.

use std::f64::consts::TAU;

use dynamics::excitation::{POSITION_AMPLITUDE_RAD, PRESSED_MM};
use dynamics::{Axis, Effect, Model, Motion, Part, Role};
use identification::statistics::rms;
use serde::Serialize;

/// The least difference that people notice, as a fraction of the whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Threshold {
    /// The fraction.
    pub fraction: f64,
    /// Who measured it, and on what.
    pub source: &'static str,
}

/// Of a torque between thumb and index finger.
static TORQUE: Threshold = Threshold {
    fraction: 0.127,
    source: "torque of 60 mNm, pinch grip (L. Jandura, M. A. Srinivasan, ASME DSC 55-1, 1994)",
};
/// Of a force between thumb and index finger.
static FORCE: Threshold = Threshold {
    fraction: 0.07,
    source: "force of 2.5 to 10 N between thumb and finger (X. D. Pang, H. Z. Tan, N. I. Durlach, Percept. Psychophys. 49, 1991)",
};
/// Of friction and of inertia: the middle of what was found.
static FRICTION_AND_INERTIA: Threshold = Threshold {
    fraction: 0.15,
    source: "friction and inertia of rotary controls, 10 to 20 % (W. B. Knowles, T. B. Sheridan, Human Factors 8, 1966)",
};

/// Frequency of the usual motion, Hz.
const USUAL_HZ: f64 = 1.0;
/// Moments of one period that are looked at.
const MOMENTS: u32 = 2000;

/// A difference in thresholds of perception.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PerceivedDifference {
    /// How many thresholds it is; from one on a hand would feel it.
    pub thresholds: f64,
    /// The threshold.
    #[serde(flatten)]
    pub threshold: Threshold,
}

impl PerceivedDifference {
    fn of(difference: f64, whole: f64, threshold: Threshold) -> Self {
        Self { thresholds: difference.abs() / (threshold.fraction * whole.max(f64::MIN_POSITIVE)), threshold }
    }
}

/// How differently two controls feel, parameter by parameter: what each alone changes in the torque of the reference along a usual
/// motion, ±1 rad once a second, or a press and return in that time. Parameters that are no torque, those of a period or a phase,
/// and those that only one of them has, are left out.
#[must_use]
pub fn perceived_differences(reference: &Model, other: &Model) -> Vec<(&'static str, PerceivedDifference)> {
    let motion = usual_motion(reference.axis);
    let torque = |model: &Model| motion.iter().map(|motion| model.torque_mnm(motion)).collect::<Vec<f64>>();
    let before = torque(reference);
    let whole = rms(&before);
    let mut felt = Vec::new();
    for (place, effect) in reference.effects.iter().enumerate() {
        for (index, (parameter, value)) in effect.parameters().enumerate() {
            let Some(theirs) = other.parameter(parameter.name).filter(|_| parameter.unit.starts_with("mNm")) else {
                continue;
            };
            let threshold = threshold_of(effect, reference.axis);
            let value = if matches!(effect.kind().part, Part::Stick(_)) {
                // What holds a control shows in no torque while it moves.
                PerceivedDifference::of(theirs - value, whole.max(value), threshold)
            } else {
                let mut changed = reference.clone();
                changed.effects[place].values_mut()[index] = theirs;
                let difference: Vec<f64> =
                    torque(&changed).iter().zip(&before).map(|(after, before)| after - before).collect();
                PerceivedDifference::of(rms(&difference), whole, threshold)
            };
            felt.push((parameter.name, value));
        }
    }
    felt
}

/// A difference between a figure of a sheet and its limit, beside the largest load of the same control; `None` for a figure that is
/// no load.
#[must_use]
pub(crate) fn perceived_figure(
    name: &str,
    axis: Axis,
    difference: f64,
    largest_load: f64,
) -> Option<PerceivedDifference> {
    let threshold = match axis {
        _ if name == "running_friction" => FRICTION_AND_INERTIA,
        Axis::Rotary if name.ends_with("_torque") => TORQUE,
        Axis::Linear if name.ends_with("_force") || name == "force_drop" => FORCE,
        _ => return None,
    };
    Some(PerceivedDifference::of(difference, largest_load, threshold))
}

fn threshold_of(effect: &Effect, axis: Axis) -> Threshold {
    match (effect.kind().role, axis) {
        (Role::Inertia | Role::Friction, _) => FRICTION_AND_INERTIA,
        (_, Axis::Rotary) => TORQUE,
        (_, Axis::Linear) => FORCE,
    }
}

fn usual_motion(axis: Axis) -> Vec<Motion> {
    let omega = TAU * USUAL_HZ;
    let at = |moment: u32| {
        let time_s = f64::from(moment) / (USUAL_HZ * f64::from(MOMENTS));
        let (sine, cosine) = (omega * time_s).sin_cos();
        // What is pressed goes one way: its motion is raised.
        let (amplitude, raised) = match axis {
            Axis::Rotary => (POSITION_AMPLITUDE_RAD, 0.0),
            Axis::Linear => (0.5 * PRESSED_MM, 1.0),
        };
        Motion {
            time_s,
            angle_rad: amplitude * (raised - cosine),
            velocity_rad_s: amplitude * omega * sine,
            acceleration_rad_s2: amplitude * omega * omega * cosine,
        }
    };
    (0..MOMENTS).map(at).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use dynamics::{Effect, Model, effects, knobs};

    use super::perceived_differences;

    fn of<'a>(felt: &'a [(&'static str, super::PerceivedDifference)], name: &str) -> &'a super::PerceivedDifference {
        &felt.iter().find(|(known, _)| *known == name).unwrap().1
    }

    #[test]
    fn what_differs_by_its_fraction_alone_is_at_the_threshold() {
        let friction = |coulomb: f64| Model {
            effects: vec![Effect::new(&effects::friction::KIND, &[coulomb, coulomb, 0.0, 0.0])],
            ..Model::default()
        };
        let felt = perceived_differences(&friction(10.0), &friction(11.5));
        // Each direction has half of the motion.
        assert!((of(&felt, "coulomb_positive").thresholds - 0.5_f64.sqrt()).abs() < 0.01, "{felt:?}");
    }

    #[test]
    fn strong_detents_mask_friction() {
        let knob = knobs::paper_knob(3).unwrap();
        let mut more = knob.clone();
        let friction = more.effects.iter_mut().find(|effect| effect.kind().name == "friction").unwrap();
        friction.values_mut()[1] *= 1.5;
        let open = of(&perceived_differences(&knob, &more), "coulomb_positive").thresholds;
        let mut masked = knob;
        let detent = masked.effects.iter_mut().find(|effect| effect.kind().name == "detent").unwrap();
        detent.values_mut()[0] *= 20.0;
        assert!(of(&perceived_differences(&masked, &more), "coulomb_positive").thresholds < 0.5 * open);
    }
}
