//! Detents that are no sine.

use std::f64::consts::{PI, TAU};

use crate::{
    Coordinate, Effect, EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, Regressors, Role, Search,
};

/// Highest harmonic: a sawtooth needs about as many before what is left hides in a sensor's noise.
const HIGHEST: usize = 12;
const COLUMNS: usize = 2 * (HIGHEST - 1);

macro_rules! harmonics {
    ($(($sine:literal, $cosine:literal, $order:literal)),*) => {
        [
            ParameterKind {
                name: "harmonic_period",
                unit: "rad",
                symbol: "P",
                description: "period of the detents that these are harmonics of",
                minimum: Minimum::AboveZero,
            },
            $(ParameterKind {
                name: $sine,
                unit: "mNm",
                symbol: concat!("a", $order),
                description: concat!("sine of ", $order, "θ/P"),
                minimum: Minimum::None,
            },
            ParameterKind {
                name: $cosine,
                unit: "mNm",
                symbol: concat!("b", $order),
                description: concat!("cosine of ", $order, "θ/P"),
                minimum: Minimum::None,
            }),*
        ]
    };
}

static PARAMETERS: [ParameterKind; COLUMNS + 1] = harmonics![
    ("harmonic_2_sine", "harmonic_2_cosine", "2"),
    ("harmonic_3_sine", "harmonic_3_cosine", "3"),
    ("harmonic_4_sine", "harmonic_4_cosine", "4"),
    ("harmonic_5_sine", "harmonic_5_cosine", "5"),
    ("harmonic_6_sine", "harmonic_6_cosine", "6"),
    ("harmonic_7_sine", "harmonic_7_cosine", "7"),
    ("harmonic_8_sine", "harmonic_8_cosine", "8"),
    ("harmonic_9_sine", "harmonic_9_cosine", "9"),
    ("harmonic_10_sine", "harmonic_10_cosine", "10"),
    ("harmonic_11_sine", "harmonic_11_cosine", "11"),
    ("harmonic_12_sine", "harmonic_12_cosine", "12")
];

/// `detent-harmonics`: τ = Σ aₖ·sin(kθ/P) + bₖ·cos(kθ/P), k from 2 to 12, P the detents' own period.
pub static KIND: EffectKind = EffectKind {
    name: "detent-harmonics",
    description: "detents of the same period whose torque is no sine",
    source: "Fourier series of a periodic torque",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &PARAMETERS,
    part: Part::Torque(|values, motion| {
        let mut columns = [0.0; COLUMNS];
        columns_at(values, motion, &mut columns);
        columns.iter().zip(&values[1..]).map(|(column, value)| column * value).sum()
    }),
    steepest_mnm_rad: Some(|effect| steepest_mnm_rad(effect, [0.0; 2])),
    regressors: Some(Regressors {
        columns: COLUMNS,
        searched: &[0],
        fill: |effect, motion, row| columns_at(effect.values(), motion, row),
        values: |coefficients, values| values[1..=COLUMNS].copy_from_slice(&coefficients[..COLUMNS]),
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 0,
            range: |scene| scene.detent_period_rad.map(|period| (0.99 * period, 1.01 * period)),
            starts: |_| 1,
            same_as: Some("detent_period"),
            ..Search::PLAIN
        }],
        nested: &[2, 4, 6, 10, 14, COLUMNS],
        ..Hypothesis::PLAIN
    }),
};

/// Sines and cosines of the multiples, each from the one before by the angle-sum formulas.
fn columns_at(values: &[f64], motion: &Motion, row: &mut [f64]) {
    let (sine, cosine) = (motion.angle_rad / values[0]).sin_cos();
    let (mut s, mut c) = (sine, cosine);
    for pair in row.chunks_exact_mut(2) {
        (s, c) = (s * cosine + c * sine, c * cosine - s * sine);
        (pair[0], pair[1]) = (s, c);
    }
}

/// Angles over one period at which the slope of a sum of harmonics is looked at.
const SCANNED: usize = 4096;

/// Steepest slope of the harmonics together with a first harmonic of the same period, mNm/rad; `first_mnm` holds that
/// one's sine and cosine.
///
/// No less than the true value and at most 0.005 % more: a trigonometric polynomial of degree n is nowhere larger than
/// the largest of its values at N even angles over cos(πn/N). Source: H. Ehlich and K. Zeller, *Schwankung von
/// Polynomen zwischen Gitterpunkten*, Math. Zeitschrift 86 (1964) 41–44.
pub(crate) fn steepest_mnm_rad(effect: &Effect, first_mnm: [f64; 2]) -> f64 {
    let (period_rad, harmonics_mnm) = (effect.values()[0], &effect.values()[1..]);
    let slope = |index: usize| {
        let (sine, cosine) = (TAU * index as f64 / SCANNED as f64).sin_cos();
        let (mut s, mut c) = (sine, cosine);
        let mut sum = first_mnm[0] * c - first_mnm[1] * s;
        for (order, pair) in (2..=HIGHEST).zip(harmonics_mnm.chunks_exact(2)) {
            (s, c) = (s * cosine + c * sine, c * cosine - s * sine);
            sum += order as f64 * (pair[0] * c - pair[1] * s);
        }
        sum.abs()
    };
    let largest = (0..SCANNED).map(slope).fold(0.0, f64::max);
    largest / (PI * HIGHEST as f64 / SCANNED as f64).cos() / period_rad
}
