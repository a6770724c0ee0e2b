//! Model files: what is read is written and read again as the same.
#![no_main]

use dynamics::{Model, Motion};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| fuzz::bounded(text.len(), || {
    let Ok(model) = Model::from_toml(text, "the model") else { return };
    let again = Model::from_toml(&model.to_toml(), "the model written again").expect("what was written is read");
    assert_eq!(model, again);
    let motion = Motion { angle_rad: 0.3, velocity_rad_s: -2.0, acceleration_rad_s2: 5.0, ..Motion::default() };
    let _ = model.torque_mnm(&motion);
}));
