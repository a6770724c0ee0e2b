//! Detents that are no sine.

use crate::{EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, Regressors, Search};

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
    parameters: &PARAMETERS,
    part: Part::Torque(|values, motion| {
        let mut columns = [0.0; COLUMNS];
        columns_at(values, motion, &mut columns);
        columns.iter().zip(&values[1..]).map(|(column, value)| column * value).sum()
    }),
    regressors: Some(Regressors {
        columns: COLUMNS,
        searched: &[0],
        fill: columns_at,
        values: |coefficients, values| values[1..=COLUMNS].copy_from_slice(&coefficients[..COLUMNS]),
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 0,
            range: |scene| scene.detent_period_rad.map(|period| (0.99 * period, 1.01 * period)),
            starts: |_| 1,
            logarithmic: false,
            same_as: Some("detent_period"),
        }],
        nested: &[2, 4, 6, 10, 14, COLUMNS],
        per_capture: false,
    }),
};

/// Sines and cosines of the multiples by turning the first harmonic on by its own angle.
fn columns_at(values: &[f64], motion: &Motion, row: &mut [f64]) {
    let (sine, cosine) = (motion.angle_rad / values[0]).sin_cos();
    let (mut s, mut c) = (sine, cosine);
    for pair in row.chunks_exact_mut(2) {
        (s, c) = (s * cosine + c * sine, c * cosine - s * sine);
        (pair[0], pair[1]) = (s, c);
    }
}
