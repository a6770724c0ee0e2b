//! Coulomb and viscous friction, each direction of turning with its own.

use crate::{Coordinate, Direction, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `friction`: τ = −C₋ + B₋·θ̇ when turning negatively, C₊ + B₊·θ̇ when turning positively.
///
/// Coulomb levels are magnitudes. Viscous coefficients keep the sign of the fit: a negative one
/// says that friction falls with speed over the range that was captured.
pub static KIND: EffectKind = EffectKind {
    name: "friction",
    description: "a constant torque against the motion and one in proportion to speed, for each direction",
    source: "Swindells and MacLean 2007, equation 1, middle row",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "coulomb_negative",
            unit: "mNm",
            symbol: "C₋",
            description: "Coulomb friction when turning negatively, a magnitude",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "coulomb_positive",
            unit: "mNm",
            symbol: "C₊",
            description: "Coulomb friction when turning positively",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "viscous_negative",
            unit: "mNm s/rad",
            symbol: "B₋",
            description: "viscous friction when turning negatively",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "viscous_positive",
            unit: "mNm s/rad",
            symbol: "B₊",
            description: "viscous friction when turning positively",
            minimum: Minimum::None,
        },
    ],
    part: Part::Friction(|values, motion, direction| match direction {
        Direction::Negative => -values[0] + values[2] * motion.velocity_rad_s,
        Direction::Positive => values[1] + values[3] * motion.velocity_rad_s,
    }),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 4,
        searched: &[],
        fill: |_, motion, row| {
            let velocity = motion.velocity_rad_s;
            let (negative, positive) = (f64::from(velocity < 0.0), f64::from(velocity > 0.0));
            row[0] = -negative;
            row[1] = positive;
            row[2] = negative * velocity;
            row[3] = positive * velocity;
        },
        values: |coefficients, values| values[..4].copy_from_slice(&coefficients[..4]),
        nonnegative: &[],
    }),
    hypothesis: None,
};
