//! A torque reading that is late.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Role, Scene, Search};

/// `sensor-delay`: the sensor reads the torque of a fixed time ago; if the angle is the late one, the time is
/// negative.
pub static KIND: EffectKind = EffectKind {
    name: "sensor-delay",
    description: "the torque reading lags the motion by a fixed time",
    source: "filters and conversion of a sensor channel",
    role: Role::Other,
    depends_on: &[Coordinate::Load],
    parameters: &[ParameterKind {
        name: "sensor_delay",
        unit: "s",
        symbol: "d",
        description: "lag of the torque reading behind the motion",
        minimum: Minimum::None,
    }],
    part: Part::ReadingDelay(|values| values[0]),
    steepest_mnm_rad: None,
    regressors: None,
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 0,
            // Either channel may be the late one.
            range: |scene| Some((-longest_s(scene), longest_s(scene))),
            // Three to a period of what is fastest.
            starts: |scene| Search::starts_over(2.0 * longest_s(scene) * scene.band_hz),
            ..Search::PLAIN
        }],
        ..Hypothesis::PLAIN
    }),
};

/// Longest delay that is looked for, s.
fn longest_s(scene: &Scene) -> f64 {
    0.02_f64.max(20.0 * scene.sample_s)
}
