//! Inertia that varies with the angle, as behind a universal joint, a crank or a bent linkage.

use std::f64::consts::{PI, TAU};

use crate::{
    Coordinate, EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, RangeEnd, Regressors, Role, Search,
};

/// `angle-dependent-inertia`: the inertia is larger by D·cos(n·θ + δ), and the torque by its slope times θ̇²/2 besides.
pub static KIND: EffectKind = EffectKind {
    name: "angle-dependent-inertia",
    description: "moment of inertia that varies with the angle",
    source: "Lagrange's equation for a kinetic energy J(θ)·θ̇²/2: τ = J·θ̈ + J′·θ̇²/2",
    role: Role::Inertia,
    depends_on: &[Coordinate::Acceleration, Coordinate::Angle, Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "inertia_variation",
            unit: "mNm s²/rad",
            symbol: "D",
            description: "largest deviation from the mean inertia",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "inertia_per_turn",
            unit: "1",
            symbol: "n",
            description: "periods per turn",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "inertia_phase",
            unit: "rad",
            symbol: "δ",
            description: "phase at angle zero",
            minimum: Minimum::None,
        },
    ],
    part: Part::VaryingInertia(|values, angle_rad| {
        let (sine, cosine) = (values[1] * angle_rad + values[2]).sin_cos();
        [values[0] * cosine, -values[0] * values[1] * sine]
    }),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 2,
        searched: &[1],
        // D·cos(n·θ + δ) = D·cos δ·cos(n·θ) − D·sin δ·sin(n·θ), and as much of the derivatives.
        fill: |effect, motion, row| {
            let per_turn = effect.values()[1];
            let Motion { angle_rad, velocity_rad_s, acceleration_rad_s2, .. } = *motion;
            let (sine, cosine) = (per_turn * angle_rad).sin_cos();
            let half_square = 0.5 * per_turn * velocity_rad_s * velocity_rad_s;
            row[0] = cosine * acceleration_rad_s2 - sine * half_square;
            row[1] = sine * acceleration_rad_s2 + cosine * half_square;
        },
        values: |coefficients, values| {
            values[0] = coefficients[0].hypot(coefficients[1]);
            values[2] = (-coefficients[1]).atan2(coefficients[0]);
        },
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 1,
            // Less than half a period over the travel is hardly a change; more than six a turn is no linkage.
            range: |scene| {
                let fewest = (PI / scene.travel_rad()).max(0.8);
                (fewest < MOST_PER_TURN).then_some((fewest, MOST_PER_TURN))
            },
            starts: |scene| Search::starts_over(MOST_PER_TURN * scene.travel_rad() / TAU),
            straight_end: Some(RangeEnd::Least),
            ..Search::PLAIN
        }],
        least_turn_rad: Some(0.0),
        ..Hypothesis::PLAIN
    }),
};

const MOST_PER_TURN: f64 = 6.5;
