//! Motion under a given torque and torque along a given motion, against closed solutions and a knob simulated by other
//! means.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use dynamics::{Effect, Model, effects};

mod bodies;
mod plant;
mod readings;
mod stick_slip;
mod windows;

/// A model of effects given by name and values.
fn model(effects: &[(&str, &[f64])]) -> Model {
    Model {
        name: "test".to_owned(),
        description: String::new(),
        effects: effects.iter().map(|(name, values)| Effect::new(effects::by_name(name).unwrap(), values)).collect(),
        ..Model::default()
    }
}
