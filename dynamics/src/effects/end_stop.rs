//! A stiff contact beyond an angle.

use std::ops::Range;

use crate::{
    Coordinate, Effect, EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, Regressors, Role, Scene, Search,
};

/// `end-stop`: beyond either end τ = K·depth + D·θ̇, the contact pushing back only.
pub static KIND: EffectKind = EffectKind {
    name: "end-stop",
    description: "stiff contact beyond an angle, on one side or both",
    source: "penalty contact of Kelvin and Voigt",
    role: Role::Other,
    depends_on: &[Coordinate::Angle, Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "stop_lower",
            unit: "rad",
            symbol: "θ₁",
            description: "angle at which the lower stop begins",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "stop_upper",
            unit: "rad",
            symbol: "θ₂",
            description: "angle at which the upper stop begins",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "stop_lower_stiffness",
            unit: "mNm/rad",
            symbol: "K₁",
            description: "stiffness of the lower stop, zero where there is none",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "stop_upper_stiffness",
            unit: "mNm/rad",
            symbol: "K₂",
            description: "stiffness of the upper stop, zero where there is none",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "stop_damping",
            unit: "mNm s/rad",
            symbol: "D",
            description: "damping in contact",
            minimum: Minimum::Zero,
        },
    ],
    part: Part::Torque(|values, motion| torque_mnm(&columns_at(values, motion), values)),
    steepest_mnm_rad: Some(|effect| effect.values()[2].max(effect.values()[3])),
    regressors: Some(Regressors {
        columns: 3,
        searched: &[0, 1],
        fill: |effect, motion, row| row.copy_from_slice(&columns_at(effect.values(), motion)[..row.len()]),
        values: |coefficients, values| values[2..5].copy_from_slice(&coefficients[..3]),
        nonnegative: &[0, 1, 2],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[
            Search {
                parameter: 0,
                // The angle of a stop that does not exist lies out of the motion's reach.
                range: |scene| Some(around(scene.lowest_rad, -BEYOND, WITHIN, scene)),
                starts: |_| 9,
                ..Search::PLAIN
            },
            Search {
                parameter: 1,
                range: |scene| Some(around(scene.highest_rad, -WITHIN, BEYOND, scene)),
                starts: |_| 9,
                ..Search::PLAIN
            },
        ],
        // A contact of a few milliseconds does not tell its damping.
        nested: &[2, 3],
        ..Hypothesis::PLAIN
    }),
};

/// The stop on either side alone, the other one out of the motion's reach.
#[must_use]
pub fn one_sided(stops: &Effect, scene: &Scene) -> [Effect; 2] {
    let lower_rad = around(scene.lowest_rad, -BEYOND, WITHIN, scene).0;
    let upper_rad = around(scene.highest_rad, -WITHIN, BEYOND, scene).1;
    [(0, lower_rad), (1, upper_rad)].map(|(side, out_of_reach_rad)| {
        let mut other = *stops;
        other.values_mut()[side] = out_of_reach_rad;
        other.values_mut()[2 + side] = 0.0;
        other
    })
}

/// The angles between the stops, rad; empty of another effect.
#[must_use]
pub fn free_rad(effect: &Effect) -> Range<f64> {
    if std::ptr::eq(effect.kind(), &KIND) { effect.values()[0]..effect.values()[1] } else { 0.0..0.0 }
}

/// Number of sides without a stop, that is, with a stiffness of zero; 0 for an effect of another kind.
#[must_use]
pub fn absent_sides(effect: &Effect) -> usize {
    let is_stop = std::ptr::eq(effect.kind(), &KIND);
    effect.values().iter().skip(2).take(2).filter(|stiffness| is_stop && **stiffness == 0.0).count()
}

/// How far beyond the motion a stop may be sought, as a share of the travel.
const BEYOND: f64 = 0.05;

/// How far within the motion, likewise: a spring from further in is no stop.
const WITHIN: f64 = 0.36;

fn around(end_rad: f64, from: f64, to: f64, scene: &Scene) -> (f64, f64) {
    (end_rad + from * scene.travel_rad(), end_rad + to * scene.travel_rad())
}

fn columns_at(values: &[f64], motion: &Motion) -> [f64; 3] {
    let lower_rad = (motion.angle_rad - values[0]).min(0.0);
    let upper_rad = (motion.angle_rad - values[1]).max(0.0);
    // Where there is a stop on the other side only, there is no damper on this one.
    let [lower_mnm_rad, upper_mnm_rad] = [values[2], values[3]];
    let is_at_lower = lower_rad < 0.0 && (lower_mnm_rad > 0.0 || upper_mnm_rad <= 0.0);
    let is_at_upper = upper_rad > 0.0 && (upper_mnm_rad > 0.0 || lower_mnm_rad <= 0.0);
    let columns = [lower_rad, upper_rad, if is_at_lower || is_at_upper { motion.velocity_rad_s } else { 0.0 }];
    // Where the damper would pull, the contact lets go.
    let torque_mnm = torque_mnm(&columns, values);
    if lower_rad < 0.0 && torque_mnm > 0.0 || upper_rad > 0.0 && torque_mnm < 0.0 { [0.0; 3] } else { columns }
}

fn torque_mnm(columns: &[f64], values: &[f64]) -> f64 {
    columns.iter().zip(&values[2..]).map(|(column, value)| column * value).sum()
}
