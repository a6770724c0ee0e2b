//! Further sinusoids of the angle, such as a motor's poles make.

use std::f64::consts::{PI, TAU};

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role, Scene, Search};

/// Lines that an effect may have: a motor's poles, its slots, and a multiple of either.
const LINES: usize = 3;
/// Parameters of a line.
const EACH: usize = 3;

macro_rules! lines {
    ($(($torque:literal, $per_turn:literal, $phase:literal, $least:ident)),*) => {
        [
            $(ParameterKind {
                name: $torque,
                unit: "mNm",
                symbol: "H",
                description: "largest torque",
                minimum: Minimum::None,
            },
            ParameterKind {
                name: $per_turn,
                unit: "1",
                symbol: "n",
                description: "periods per turn",
                minimum: Minimum::$least,
            },
            ParameterKind {
                name: $phase,
                unit: "rad",
                symbol: "η",
                description: "phase at angle zero",
                minimum: Minimum::None,
            }),*
        ]
    };
}

static PARAMETERS: [ParameterKind; LINES * EACH] = lines![
    ("cogging_torque", "cogging_per_turn", "cogging_phase", AboveZero),
    ("cogging_2_torque", "cogging_2_per_turn", "cogging_2_phase", Zero),
    ("cogging_3_torque", "cogging_3_per_turn", "cogging_3_phase", Zero)
];

/// `cogging`: τ = Σ H·sin(n·θ + η) over at most three lines, their periods unrelated to the detents'.
pub static KIND: EffectKind = EffectKind {
    name: "cogging",
    description: "sinusoids of the angle whose periods have nothing to do with the detents",
    source: "poles and slots of a motor, or a second wheel",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &PARAMETERS,
    part: Part::Torque(|values, motion| {
        lines(values).map(|[torque, per_turn, phase]| torque * (per_turn * motion.angle_rad + phase).sin()).sum()
    }),
    steepest_mnm_rad: Some(|effect| {
        lines(effect.values()).map(|[torque, per_turn, _]| (torque * per_turn).abs()).sum()
    }),
    regressors: Some(Regressors {
        columns: 2 * LINES,
        searched: &[1, 1 + EACH, 1 + 2 * EACH],
        fill: |effect, motion, row| {
            for (line, columns) in effect.values().chunks_exact(EACH).zip(row.chunks_exact_mut(2)) {
                // A line without a period does not occur.
                (columns[0], columns[1]) =
                    if line[1] == 0.0 { (0.0, 0.0) } else { (line[1] * motion.angle_rad).sin_cos() };
            }
        },
        values: |coefficients, values| {
            for (pair, line) in coefficients.chunks_exact(2).zip(values.chunks_exact_mut(EACH)) {
                (line[0], line[2]) = (pair[0].hypot(pair[1]), pair[1].atan2(pair[0]));
            }
        },
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[per_turn(1), per_turn(1 + EACH), per_turn(1 + 2 * EACH)],
        lines: LINES,
        least_turn_rad: Some(0.0),
        ..Hypothesis::PLAIN
    }),
};

/// Torque, periods per turn and phase of each line that occurs.
pub fn lines(values: &[f64]) -> impl Iterator<Item = [f64; EACH]> + '_ {
    let lines = values.chunks_exact(EACH).map(|line| [line[0], line[1], line[2]]);
    lines.filter(|[torque, ..]| *torque != 0.0)
}

/// Whether a sinusoid of so many periods per turn is a multiple of the detents', as far as the travel can tell: then it is
/// the detents' own shape, and no cogging.
#[must_use]
pub fn is_of_the_detents(per_turn: f64, scene: &Scene) -> bool {
    scene.detent_period_rad.is_some_and(|period_rad| {
        let order = per_turn * period_rad;
        order > 1.5 && !are_resolved(per_turn, order.round() / period_rad, scene)
    })
}

/// Whether a sinusoid of so many periods per turn differs from the detents themselves, as far as the travel can resolve.
#[must_use]
pub fn is_apart_from_the_detents(per_turn: f64, scene: &Scene) -> bool {
    scene.detent_period_rad.is_none_or(|period_rad| are_resolved(per_turn, 1.0 / period_rad, scene))
}

/// Whether every line of an effect's values differs from all lines before it, as far as the travel can resolve.
#[must_use]
pub fn lines_are_resolved(values: &[f64], scene: &Scene) -> bool {
    let per_turn: Vec<f64> = lines(values).map(|[_, per_turn, _]| per_turn).collect();
    let is_new = |(index, one): (usize, &f64)| per_turn[..index].iter().all(|other| are_resolved(*one, *other, scene));
    per_turn.iter().enumerate().all(is_new)
}

/// Whether two numbers of periods per turn differ by half a period over the travel.
fn are_resolved(one_per_turn: f64, other_per_turn: f64, scene: &Scene) -> bool {
    (one_per_turn - other_per_turn).abs() >= PI / scene.travel_rad()
}

/// The search for a line's periods per turn.
const fn per_turn(parameter: usize) -> Search {
    Search {
        parameter,
        range: |scene| {
            // Fewer than two periods over the travel are a bend.
            let fewest = (2.0 * TAU / scene.travel_rad()).max(1.5);
            let most = finest_per_turn(scene);
            (most > fewest).then_some((fewest, most))
        },
        starts: |scene| Search::starts_over(finest_per_turn(scene) * scene.travel_rad() / TAU),
        ..Search::PLAIN
    }
}

/// Most periods per turn that pass slowly enough for the band.
fn finest_per_turn(scene: &Scene) -> f64 {
    TAU * scene.band_hz / (0.5 * scene.median_speed_rad_s).max(f64::MIN_POSITIVE)
}
