//! Detents whose torque rises slowly and falls fast, or the other way round.

use std::f64::consts::TAU;

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `detent-sawtooth`: τ = A·saw(θ/P + S). The wave rises from −1 to 1 over the share r of a period, through zero at
/// phase zero, and falls over the rest. Both flanks are finite: a jump could not be rendered.
pub static KIND: EffectKind = EffectKind {
    name: "detent-sawtooth",
    description: "detents whose torque rises and falls in straight lines of different lengths",
    source: "sawtooth wave with a finite flank; amplitude, period and phase as in equation 1 of Swindells and MacLean 2007",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "sawtooth_amplitude",
            unit: "mNm",
            symbol: "A",
            description: "largest torque",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "sawtooth_period",
            unit: "rad",
            symbol: "P",
            description: "angle per radian of the wave; detents are 2πP apart",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "sawtooth_phase",
            unit: "rad",
            symbol: "S",
            description: "phase of the wave at angle zero, counted from the middle of its rise",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "sawtooth_rising_share",
            unit: "1",
            symbol: "r",
            description: "share of a period over which the torque rises; 0.5 makes a triangle",
            minimum: Minimum::ShareOfOne,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * wave(motion.angle_rad / values[1] + values[2], values[3])),
    steepest_mnm_rad: Some(|effect| {
        let [amplitude, period, _, share] = *effect.values() else { return 0.0 };
        2.0 * (amplitude / (TAU * period)).abs() / share.min(1.0 - share)
    }),
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1, 2, 3],
        fill: |effect, motion, row| {
            row[0] = wave(motion.angle_rad / effect.values()[1] + effect.values()[2], effect.values()[3]);
        },
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: None,
};

/// From −1 to 1 in a straight line around phase zero, over the share of a period, and back over the rest.
fn wave(phase_rad: f64, rising_share: f64) -> f64 {
    // In periods, from the middle of the rise, within half a period of it.
    let turns = phase_rad / TAU;
    let from_rise = turns - turns.round();
    if from_rise.abs() <= 0.5 * rising_share {
        return 2.0 * from_rise / rising_share;
    }
    from_rise.signum() * (1.0 - 2.0 * from_rise.abs()) / (1.0 - rising_share)
}
