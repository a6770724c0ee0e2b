//! A torque reading that is late.

use crate::{EffectKind, Hypothesis, Minimum, ParameterKind, Part, Search};

/// `sensor-delay`: what the sensor reads is the torque of a fixed time ago.
pub static KIND: EffectKind = EffectKind {
    name: "sensor-delay",
    description: "the torque reading lags the motion by a fixed time",
    source: "filters and conversion of a sensor channel",
    parameters: &[ParameterKind {
        name: "sensor_delay",
        unit: "s",
        symbol: "d",
        description: "lag of the torque reading behind the motion",
        minimum: Minimum::None,
    }],
    part: Part::ReadingDelay(|values| values[0]),
    regressors: None,
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 0,
            range: |scene| Some((0.5 * scene.sample_s, 0.02_f64.max(20.0 * scene.sample_s))),
            starts: |_| 12,
            logarithmic: true,
            same_as: None,
        }],
        nested: &[],
        per_capture: false,
    }),
};
