//! Parameters, intervals and verdicts from the blocks.

use dynamics::{Effect, ParameterKind, Part, effects};
use nalgebra::DMatrix;

use super::growing_blocks::{BlockFit, GrowingBlocks};
use crate::statistics::student_95;

/// Blocks that must scatter before intervals mean anything.
const FEWEST_BLOCKS: usize = 16;
/// A parameter is known when its interval's half width is below this share of its value …
const KNOWN_SHARE: f64 = 0.1;
/// … or worth less than this share of the torque's RMS.
const KNOWN_TORQUE: f64 = 0.02;

/// Whether the data so far can tell a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The sweep has not yet excited the parameter enough.
    NotYet,
    /// Excited enough: value and interval mean what they say.
    Enough,
    /// The model that was fitted does not have this parameter.
    Absent,
}

/// A parameter as fitted so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveParameter {
    /// Standard name.
    pub name: &'static str,
    /// Unit of value and interval.
    pub unit: &'static str,
    /// Value so far; `None` while nothing at all can be said.
    pub value: Option<f64>,
    /// 95 % interval; `None` while nothing can be said of it.
    pub ci95: Option<[f64; 2]>,
    /// Whether the data can tell it.
    pub verdict: Verdict,
}

/// The model as the stream so far tells it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LiveEstimate {
    /// Inertia, friction, detents: always all of them, in the order of equation 1.
    pub parameters: Vec<LiveParameter>,
    /// RMS of the torque that the model leaves, in the band of the fit; `None` before the first row.
    pub residual_rms_mnm: Option<f64>,
    /// RMS of the torque itself in that band.
    pub torque_rms_mnm: Option<f64>,
    /// RMS of the velocity while the knob slid, rad/s; `None` before the first row.
    pub speed_rms_rad_s: Option<f64>,
    /// RMS of the acceleration while the knob slid, rad/s²; `None` before the first row.
    pub acceleration_rms_rad_s2: Option<f64>,
    /// Samples taken in.
    pub samples: u64,
    /// Samples left out because they were not numbers or did not come later than the last.
    pub ignored_samples: u64,
    /// Rows that the fit rests on.
    pub rows: u64,
    /// Time of the newest sample, s; NaN before the first.
    pub newest_s: f64,
    pub(super) wavenumber_correction: f64,
    pub(super) wavenumber_deviation: f64,
}

impl LiveEstimate {
    /// The parameter called `name`.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&LiveParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }
}

/// How much the stream has moved the knob, in samples.
pub(super) struct Excitation {
    /// Sliding samples.
    pub(super) sliding: f64,
    /// Those in the negative direction.
    pub(super) backward: f64,
    /// How many a direction needs.
    pub(super) enough: f64,
}

impl Excitation {
    /// Samples that see a parameter.
    fn of(&self, name: &str) -> f64 {
        if name.ends_with("_negative") {
            self.backward
        } else if name.ends_with("_positive") {
            self.sliding - self.backward
        } else {
            self.sliding
        }
    }
}

/// The joint columns for an assumed period.
pub(super) struct Detent<'a> {
    pub(super) wavenumber: f64,
    pub(super) centre_rad: f64,
    pub(super) blocks: &'a GrowingBlocks,
}

pub(super) fn estimate(
    base_effects: &[Effect],
    base: &GrowingBlocks,
    detent: Option<Detent<'_>>,
    evidence: Option<bool>,
    gripper_inertia: f64,
    excitation: &Excitation,
) -> LiveEstimate {
    let mut estimate = LiveEstimate::default();
    let columns = base.columns();
    let joint = detent
        .filter(|_| evidence == Some(true))
        .and_then(|detent| joint_fit(columns, &detent).map(|joint| (detent, joint)))
        .filter(|(_, joint)| joint.fit.blocks >= FEWEST_BLOCKS);
    let Some(fit) = joint.as_ref().map(|(_, joint)| joint.fit.clone()).or_else(|| base.solve(columns)) else {
        let kinds = base_effects.iter().map(Effect::kind).chain([&effects::detent::KIND]);
        estimate.parameters =
            kinds.flat_map(|kind| kind.parameters).map(|kind| without_value(kind, Verdict::NotYet)).collect();
        return estimate;
    };
    let critical = student_95(fit.degrees_of_freedom());
    let mut start = 0;
    let mut square_speed = 0.0;
    for effect in base_effects {
        for (position, kind) in effect.kind().parameters.iter().enumerate() {
            let column = start + position;
            let subtract = if matches!(effect.kind().part, Part::Inertia(_)) { gripper_inertia } else { 0.0 };
            let half = critical * fit.covariance[(column, column)].max(0.0).sqrt();
            estimate.parameters.push(parameter(kind, column, half, subtract, &fit, excitation));
            match kind.name {
                "inertia" => estimate.acceleration_rms_rad_s2 = Some(fit.column_rms[column]),
                // The column of a direction is the velocity in that direction, and zero in the other.
                "viscous_negative" | "viscous_positive" => square_speed += fit.column_rms[column].powi(2),
                _ => {}
            }
        }
        start += effect.kind().regressors.map_or(0, |regressors| regressors.columns);
    }
    estimate.speed_rms_rad_s = Some(square_speed.sqrt());
    estimate.residual_rms_mnm = Some(fit.residual_rms);
    estimate.torque_rms_mnm = Some(fit.torque_rms);
    estimate.rows = fit.rows;
    match &joint {
        Some((detent, joint)) => {
            estimate.wavenumber_correction = joint.correction;
            estimate.wavenumber_deviation = joint.fit.covariance[(columns + 2, columns + 2)].max(0.0).sqrt();
            estimate.parameters.extend(detent_parameters(columns, detent, joint, critical));
        }
        None => {
            let verdict = if evidence == Some(false) { Verdict::Absent } else { Verdict::NotYet };
            estimate.wavenumber_deviation = f64::INFINITY;
            estimate
                .parameters
                .extend(effects::detent::KIND.parameters.iter().map(|kind| without_value(kind, verdict)));
        }
    }
    estimate
}

fn without_value(kind: &ParameterKind, verdict: Verdict) -> LiveParameter {
    LiveParameter { name: kind.name, unit: kind.unit, value: None, ci95: None, verdict }
}

fn parameter(
    kind: &'static ParameterKind,
    column: usize,
    half: f64,
    subtract: f64,
    fit: &BlockFit,
    excitation: &Excitation,
) -> LiveParameter {
    let ParameterKind { name, unit, .. } = *kind;
    let seen = excitation.of(name);
    if fit.solution.collinear[column] || seen < excitation.enough {
        return without_value(kind, Verdict::NotYet);
    }
    let value = fit.solution.coefficients[column] - subtract;
    // The column counts where it is not zero.
    let column_rms = fit.column_rms[column] * (excitation.sliding / seen).sqrt();
    let small = half <= KNOWN_SHARE * value.abs() || half * column_rms <= KNOWN_TORQUE * fit.torque_rms;
    let enough = fit.blocks >= FEWEST_BLOCKS && small && kind.minimum.permits(value);
    LiveParameter {
        name,
        unit,
        value: Some(value),
        ci95: (fit.blocks >= FEWEST_BLOCKS).then_some([value - half, value + half]),
        verdict: if enough { Verdict::Enough } else { Verdict::NotYet },
    }
}

struct JointFit {
    fit: BlockFit,
    /// Correction of the assumed wavenumber, 1/rad.
    correction: f64,
}

/// Base, sine and cosine, and the wavenumber's tangent θ·(a·cos − b·sin).
fn joint_fit(columns: usize, detent: &Detent<'_>) -> Option<JointFit> {
    let plain = detent.blocks.solve(columns + 2)?.solution.coefficients;
    let (sine, cosine) = (plain[columns], plain[columns + 1]);
    let mut map = DMatrix::identity(columns + 3, columns + 4);
    // Stored after sine and cosine: angle·sine, angle·cosine.
    map[(columns + 2, columns + 2)] = -cosine;
    map[(columns + 2, columns + 3)] = sine;
    let fit = detent.blocks.solve_mapped(&map)?;
    let correction = fit.solution.coefficients[columns + 2];
    Some(JointFit { fit, correction })
}

fn detent_parameters(columns: usize, detent: &Detent<'_>, joint: &JointFit, critical: f64) -> [LiveParameter; 3] {
    let BlockFit { solution, covariance, .. } = &joint.fit;
    let coefficients = &solution.coefficients;
    let (a, b) = (coefficients[columns], coefficients[columns + 1]);
    let wavenumber = detent.wavenumber + joint.correction;
    let period = 1.0 / wavenumber;
    let amplitude = a.hypot(b);
    // The columns' angle counts from the centre: kθ' + s = kθ + (s − k·centre).
    let (_, phase) = effects::detent::canonical(amplitude, b.atan2(a) - wavenumber * detent.centre_rad);
    let part = covariance.view((columns, columns), (3, 3));
    let half = |gradient: [f64; 3]| {
        let mut variance = 0.0;
        for (row, left) in gradient.iter().enumerate() {
            for (column, right) in gradient.iter().enumerate() {
                variance += left * part[(row, column)] * right;
            }
        }
        critical * variance.max(0.0).sqrt()
    };
    let square = amplitude * amplitude;
    let half_amplitude = half([a / amplitude, b / amplitude, 0.0]);
    let known = half_amplitude < KNOWN_SHARE * amplitude;
    let verdict = if known { Verdict::Enough } else { Verdict::NotYet };
    let [amplitude_kind, period_kind, phase_kind] = [0, 1, 2].map(|index| &effects::detent::KIND.parameters[index]);
    let of = |kind: &'static ParameterKind, value: f64, half: f64| LiveParameter {
        name: kind.name,
        unit: kind.unit,
        value: Some(value),
        ci95: Some([value - half, value + half]),
        verdict,
    };
    [
        of(amplitude_kind, amplitude, half_amplitude),
        of(period_kind, period, half([0.0, 0.0, period * period])),
        of(phase_kind, phase, half([-b / square, a / square, -detent.centre_rad])),
    ]
}
