//! The effects that the instrument knows: one file each, and the list of them.

pub mod angle_characteristic;
pub mod angle_dependent_inertia;
pub mod backlash;
pub mod bottom_out;
pub mod cogging;
pub mod detent;
pub mod detent_harmonics;
pub mod detent_sawtooth;
pub mod detent_triangle;
pub mod eddy_current_damping;
pub mod end_stop;
pub mod friction;
pub mod friction_characteristic;
pub mod friction_drift;
pub mod friction_eccentricity;
pub mod inertia;
pub mod karnopp_stick;
pub mod load_dependent_friction;
pub mod mains_hum;
pub mod mass_imbalance;
pub mod presliding_hysteresis;
pub mod quadratic_drag;
pub mod return_spring;
pub mod scratch;
pub mod sensor_delay;
pub mod shaft_compliance;
pub mod snap_through;
pub mod speed_characteristic;
pub mod stribeck;
pub mod torque_offset;
pub mod torque_ramp;
pub mod torque_table;
pub mod unequal_detents;
pub mod velocity_strengthening;

use crate::EffectKind;

/// Every effect, in the order in which a model lists them: first those that every fit looks for.
pub static ALL: [&EffectKind; 34] = [
    &inertia::KIND,
    &angle_dependent_inertia::KIND,
    &friction::KIND,
    &karnopp_stick::KIND,
    &detent::KIND,
    &detent_harmonics::KIND,
    &detent_triangle::KIND,
    &detent_sawtooth::KIND,
    &torque_table::KIND,
    &unequal_detents::KIND,
    &cogging::KIND,
    &mass_imbalance::KIND,
    &return_spring::KIND,
    &end_stop::KIND,
    &snap_through::KIND,
    &bottom_out::KIND,
    &torque_ramp::KIND,
    &quadratic_drag::KIND,
    &eddy_current_damping::KIND,
    &stribeck::KIND,
    &velocity_strengthening::KIND,
    &friction_eccentricity::KIND,
    &scratch::KIND,
    &load_dependent_friction::KIND,
    &friction_drift::KIND,
    &presliding_hysteresis::KIND,
    &shaft_compliance::KIND,
    &backlash::KIND,
    &torque_offset::KIND,
    &mains_hum::KIND,
    &sensor_delay::KIND,
    &angle_characteristic::KIND,
    &friction_characteristic::KIND,
    &speed_characteristic::KIND,
];

/// The effect with the standard name `name`.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static EffectKind> {
    ALL.iter().copied().find(|kind| kind.name == name)
}
