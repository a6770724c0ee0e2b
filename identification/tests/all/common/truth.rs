//! True values as a fit would write them.

use dynamics::Model;
use dynamics::effects::detent;

/// Parameters of a sliding knob of equation 1.
pub const SLIDING: [&str; 8] = [
    "inertia",
    "coulomb_negative",
    "coulomb_positive",
    "viscous_negative",
    "viscous_positive",
    "detent_amplitude",
    "detent_period",
    "detent_phase",
];

/// M, C₋, C₊, B₋, B₊, A, P, S of the paper's Table 2.
pub const TABLE_2: [f64; 8] = [0.4, 1.5, 2.0, 1.0, 1.5, 1.0, 0.2, 0.9];

/// A knob's parameter as a fit would write it: detents with a positive amplitude.
pub fn true_value(knob: &Model, name: &str) -> Option<f64> {
    let canonical = || knob.effect("detent").map(|e| detent::canonical(e.values()[0], e.values()[2]));
    match name {
        "detent_amplitude" => canonical().map(|(amplitude, _)| amplitude),
        "detent_phase" => canonical().map(|(_, phase)| phase),
        _ => knob.parameter(name),
    }
}
