//! Parameters, intervals and verdicts from the blocks.

use dynamics::{Effect, ParameterKind, Part, effects};
use nalgebra::DMatrix;
use shared_types::{Convergence, Verdict};

use super::WithDetents;
use super::blocks::{Blocks, Solution};
use super::convergence::{Criterion, MotionRms, relative_half_width};
use crate::numerics::statistics::{deviation_of_sum, interval};

/// Fewest blocks whose scatter gives an interval.
const FEWEST_BLOCKS: usize = 16;
/// A parameter counts as estimated when its interval's half width is below this share of its value …
const ESTIMATED_SHARE: f64 = 0.1;
/// … or amounts to less than this share of the torque's RMS.
const ESTIMATED_TORQUE: f64 = 0.02;

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
    /// Whether it can be estimated.
    pub verdict: Verdict,
    /// Whether it is known with the precision asked for.
    pub convergence: Convergence,
}

impl LiveParameter {
    /// Half the width of the 95 % interval; `None` while there is none.
    #[must_use]
    pub fn half_width(&self) -> Option<f64> {
        self.ci95.map(|[low, high]| 0.5 * (high - low))
    }

    /// The half width as a share of the value; of a phase, of one radian. `None` while there is no interval.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        Some(relative_half_width(self.name, self.value?, self.half_width()?)).filter(|share| share.is_finite())
    }

    /// Whether the model that was fitted has this parameter.
    #[must_use]
    pub fn is_in_model(&self) -> bool {
        self.verdict != Verdict::Absent
    }

    /// Whether a capture need not go on for this parameter.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        !self.is_in_model() || self.convergence != Convergence::Open
    }
}

/// The model as the stream so far tells it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LiveEstimate {
    /// Inertia, friction, detents: always all of them, in the order of equation 1.
    pub parameters: Vec<LiveParameter>,
    /// RMS of the torque that the model leaves, in the band of the fit; `None` before the first row.
    pub residual_rms_mnm: Option<f64>,
    /// RMS of the velocity while the knob slid, rad/s; `None` before the first row.
    pub speed_rms_rad_s: Option<f64>,
    /// RMS of the acceleration while the knob slid, rad/s²; `None` before the first row.
    pub acceleration_rms_rad_s2: Option<f64>,
    /// Samples taken in.
    pub samples: u64,
    /// Samples left out because they were not numbers or did not come later than the last.
    pub ignored_samples: u64,
    pub(super) wavenumber_correction: f64,
    pub(super) wavenumber_deviation: f64,
}

impl LiveEstimate {
    /// Holds the parameters' intervals against `criterion`.
    pub(super) fn judge(&mut self, criterion: &Criterion) {
        let motion = self.motion();
        for parameter in &mut self.parameters {
            if let (Some(value), Some(half_width)) = (parameter.value, parameter.half_width()) {
                parameter.convergence = criterion.judge(parameter.name, value, half_width, motion);
            }
        }
    }

    /// RMS of the motion so far; NaN before the first row.
    #[must_use]
    pub fn motion(&self) -> MotionRms {
        MotionRms {
            velocity_rad_s: self.speed_rms_rad_s.unwrap_or(f64::NAN),
            acceleration_rad_s2: self.acceleration_rms_rad_s2.unwrap_or(f64::NAN),
        }
    }

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
    /// Number of samples on which a parameter has an effect.
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

pub(super) fn estimate(
    base_effects: &[Effect],
    base: &Blocks,
    with_detents: Option<&WithDetents>,
    has_detents: Option<bool>,
    gripper_inertia: f64,
    excitation: &Excitation,
) -> LiveEstimate {
    let mut estimate = LiveEstimate::default();
    let columns = base.columns();
    let solved = with_detents
        .filter(|_| has_detents == Some(true))
        .and_then(|with_detents| {
            solution_with_detents(columns, with_detents).map(|solution| (Some(with_detents), solution))
        })
        .filter(|(_, solution)| solution.blocks >= FEWEST_BLOCKS);
    let Some((with_detents, solution)) = solved.or_else(|| base.solve(columns).map(|solution| (None, solution))) else {
        let base = base_effects.iter().flat_map(|effect| effect.kind().parameters);
        let base = base.map(|kind| without_value(kind, Verdict::NotYet));
        estimate.parameters = base.chain(no_detents(has_detents)).collect();
        return estimate;
    };
    let mut start = 0;
    let mut square_speed = 0.0;
    for effect in base_effects {
        for (position, kind) in effect.kind().parameters.iter().enumerate() {
            let column = start + position;
            let subtract = if matches!(effect.kind().part, Part::Inertia(_)) { gripper_inertia } else { 0.0 };
            let half = solution.critical() * solution.covariance[(column, column)].max(0.0).sqrt();
            estimate.parameters.push(parameter(kind, column, half, subtract, &solution, excitation));
            match kind.name {
                "inertia" => estimate.acceleration_rms_rad_s2 = Some(solution.column_rms[column]),
                // The column of a direction is the velocity in that direction, and zero in the other.
                "viscous_negative" | "viscous_positive" => square_speed += solution.column_rms[column].powi(2),
                _ => {}
            }
        }
        start += effect.kind().regressors.map_or(0, |regressors| regressors.columns);
    }
    estimate.speed_rms_rad_s = Some(square_speed.sqrt());
    estimate.residual_rms_mnm = Some(solution.residual_rms);
    match with_detents {
        Some(with_detents) => {
            estimate.wavenumber_correction = solution.coefficients[columns + 2];
            estimate.wavenumber_deviation = solution.covariance[(columns + 2, columns + 2)].max(0.0).sqrt();
            estimate.parameters.extend(detent_parameters(columns, with_detents, &solution));
        }
        None => {
            estimate.wavenumber_deviation = f64::INFINITY;
            estimate.parameters.extend(no_detents(has_detents));
        }
    }
    estimate
}

/// The detents' parameters where none were found.
fn no_detents(has_detents: Option<bool>) -> impl Iterator<Item = LiveParameter> {
    let verdict = if has_detents == Some(false) { Verdict::Absent } else { Verdict::NotYet };
    effects::detent::KIND.parameters.iter().map(move |kind| without_value(kind, verdict))
}

fn without_value(kind: &ParameterKind, verdict: Verdict) -> LiveParameter {
    let ParameterKind { name, unit, .. } = *kind;
    LiveParameter { name, unit, value: None, ci95: None, verdict, convergence: Convergence::Open }
}

fn parameter(
    kind: &'static ParameterKind,
    column: usize,
    half: f64,
    subtract: f64,
    solution: &Solution,
    excitation: &Excitation,
) -> LiveParameter {
    let seen = excitation.of(kind.name);
    if !solution.is_fitted[column] || seen < excitation.enough {
        return without_value(kind, Verdict::NotYet);
    }
    let value = solution.coefficients[column] - subtract;
    // The column counts where it is not zero.
    let column_rms = solution.column_rms[column] * (excitation.sliding / seen).sqrt();
    let small = half <= ESTIMATED_SHARE * value.abs() || half * column_rms <= ESTIMATED_TORQUE * solution.torque_rms;
    let enough = solution.blocks >= FEWEST_BLOCKS && small && kind.minimum.permits(value);
    LiveParameter {
        value: Some(value),
        ci95: (solution.blocks >= FEWEST_BLOCKS).then_some(interval(value, half)),
        ..without_value(kind, if enough { Verdict::Estimated } else { Verdict::NotYet })
    }
}

/// Base, sine and cosine, and the wavenumber's tangent θ·(a·cos − b·sin), whose coefficient corrects the assumed wavenumber.
fn solution_with_detents(columns: usize, with_detents: &WithDetents) -> Option<Solution> {
    let plain = with_detents.rows.blocks.solve(columns + 2)?;
    let (sine, cosine) = (plain.coefficients[columns], plain.coefficients[columns + 1]);
    let mut map = DMatrix::identity(columns + 4, columns + 5);
    // Stored after sine and cosine: angle·sine, angle·cosine.
    map[(columns + 3, columns + 3)] = -cosine;
    map[(columns + 3, columns + 4)] = sine;
    with_detents.rows.blocks.solve_mapped(&map)
}

fn detent_parameters(columns: usize, with_detents: &WithDetents, solution: &Solution) -> [LiveParameter; 3] {
    let Solution { coefficients, covariance, .. } = solution;
    let (a, b) = (coefficients[columns], coefficients[columns + 1]);
    let wavenumber = with_detents.wavenumber + coefficients[columns + 2];
    let period = 1.0 / wavenumber;
    let amplitude = a.hypot(b);
    // The columns' angle counts from the centre: kθ' + s = kθ + (s − k·centre).
    let (_, phase) = effects::detent::canonical(amplitude, b.atan2(a) - wavenumber * with_detents.centre_rad);
    let part = covariance.view((columns, columns), (3, 3)).into_owned();
    let half = |gradient: [f64; 3]| solution.critical() * deviation_of_sum(&part, &gradient);
    let square = amplitude * amplitude;
    let half_amplitude = half([a / amplitude, b / amplitude, 0.0]);
    let estimated = half_amplitude < ESTIMATED_SHARE * amplitude;
    let verdict = if estimated { Verdict::Estimated } else { Verdict::NotYet };
    let half_period = half([0.0, 0.0, period * period]);
    let half_phase = half([-b / square, a / square, -with_detents.centre_rad]);
    let parameters = [(0, amplitude, half_amplitude), (1, period, half_period), (2, phase, half_phase)];
    parameters.map(|(index, value, half)| LiveParameter {
        value: Some(value),
        ci95: Some(interval(value, half)),
        ..without_value(&effects::detent::KIND.parameters[index], verdict)
    })
}
