//! Rotor and knob as numbers, which several rigs of the tests turn, and whether a fit has found them.

use serde_json::Value;

/// Inertia of the rotor, mNm·s²/rad.
pub const ROTOR_INERTIA: f64 = 0.02;
/// Inertia of the knob, mNm·s²/rad.
pub const KNOB_INERTIA: f64 = 0.06;
/// Coulomb friction, mNm.
pub const COULOMB_MNM: f64 = 3.0;
/// Viscous friction, mNm·s/rad.
pub const VISCOUS: f64 = 0.25;
/// Amplitude of the detents, mNm.
pub const DETENT_MNM: f64 = 4.0;
/// Detents in a turn.
pub const DETENTS_PER_TURN: f64 = 24.0;

/// What a fit is to find.
const TRUTH: [(&str, f64); 7] = [
    ("inertia", KNOB_INERTIA),
    ("coulomb_negative", COULOMB_MNM),
    ("coulomb_positive", COULOMB_MNM),
    ("viscous_negative", VISCOUS),
    ("viscous_positive", VISCOUS),
    ("detent_amplitude", DETENT_MNM),
    ("detent_period", 1.0 / DETENTS_PER_TURN),
];
/// All inertia that the motor drives: a share of it is what the motor's torque is not known by in inertia.
const DRIVEN_INERTIA: f64 = ROTOR_INERTIA + KNOB_INERTIA;
/// Most that half an interval may be of its value: a wide one would hold anything.
const WIDEST_SHARE: f64 = 0.1;
/// Half widths of the 95 % interval within which the truth must lie: of the dozens of intervals here one in twenty misses it by
/// right, and one in fifteen thousand by twice as much.
const HALF_WIDTHS: f64 = 2.0;

/// Asserts that every parameter is the plant's, but for a share by which the torque is not known.
///
/// # Panics
/// Where one is not, or is missing.
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
pub fn is_the_plants(parameters: &Value, of_torque: f64, what: &str) {
    for (name, truth) in TRUTH {
        let parameter = &parameters[name];
        let [value, low, high] =
            [&parameter["value"], &parameter["ci95"][0], &parameter["ci95"][1]].map(|number| number.as_f64().unwrap());
        let half_width = (high - low) / 2.0;
        assert!(half_width < WIDEST_SHARE * truth, "{what}: {name} {value} ± {half_width}");
        let permitted = HALF_WIDTHS * half_width + of_torque * if name == "inertia" { DRIVEN_INERTIA } else { truth };
        assert!(
            (value - truth).abs() <= permitted,
            "{what}: {name} is {value} ± {half_width}, but the plant has {truth}"
        );
    }
}
