//! A knob that was turned too slowly for its speed to be estimated: torque against angle and direction alone.
//!
//! Stepped or creeping captures map the torque over the angle. Inertia and viscous friction have no part in them; Coulomb
//! friction shows as the distance between passes in the two directions, and detents as sinusoids of the angle,
//! counted per turn where a whole turn was covered.

mod characteristic;
mod map;

use std::f64::consts::TAU;

use dynamics::{Effect, ParameterKind, effects};

use crate::estimate::{Fit, Harmonic, Parameter, Parameters, Point, Preparation};
use crate::fit::report::{one_sided_friction_of, prediction_sd};
use crate::numerics::statistics::{NORMAL_95, interval, mean, noise_deviation, range};
use crate::options::FitOptions;
use crate::preparation::clock::typical_step;
use crate::regression::block_sums::{BlockSums, Estimate, critical};
use crate::regression::characteristic::Spline;
use crate::samples::Samples;
use crate::sinusoids::matching_pursuit::{self, Grid};
use map::Friction;
pub(crate) use map::Map;

/// Fits friction and the sinusoids of the angle to checked samples; `None` if the knob did not pass slowly through its travel.
pub(crate) fn fit(samples: &Samples<'_>, options: &FitOptions) -> Option<Fit> {
    let map = Map::of(samples, options.axis, options.calibration.as_ref(), options.is_quasi_static)?;
    if options.characteristic {
        return characteristic::fit(samples, &map);
    }
    let look_for_detents = !options.without_detents;
    let mut sums = BlockSums::new(map.torque_mnm.clone());
    let frictions = map.frictions();
    for friction in &frictions {
        sums.push(map.friction_column(*friction));
    }
    let angle_rad = &map.motion.angle_rad;
    let grid = Grid::of(angle_rad);
    let wavenumbers =
        if look_for_detents { matching_pursuit::sinusoids(&mut sums, angle_rad, &grid) } else { Vec::new() };
    let fitted = Fitted::of(sums, &map, frictions.len(), &wavenumbers, grid.whole_turn)?;

    let none = if look_for_detents { fitted.no_detents(&grid) } else { "detents were not asked for".to_owned() };
    let mut notes = map.notes();
    if !wavenumbers.is_empty() && !grid.whole_turn {
        notes.push("less than a whole turn was covered: counts per turn are not whole numbers by rule".to_owned());
    }
    Some(fitted.fit(samples, &map, &frictions, &none, notes))
}

/// A map that was fitted: friction columns first, then sine and cosine of each sinusoid.
struct Fitted {
    sums: BlockSums,
    estimate: Estimate,
    /// Strongest first.
    harmonics: Vec<Harmonic>,
    /// Half width of the 95 % interval of the strongest one's period, rad.
    period_half_width_rad: f64,
    /// Whether they repeat after a turn.
    whole_turn: bool,
}

/// Points of a table in a period of the finest sinusoid in it: between them it keeps to the sinusoid within 0.1 % of its amplitude.
const POINTS_A_PERIOD: f64 = 24.0;
/// Most points of the table.
const MOST_POINTS: f64 = 9_999.0;

impl Fitted {
    fn of(mut sums: BlockSums, map: &Map, frictions: usize, wavenumbers: &[f64], whole_turn: bool) -> Option<Self> {
        let estimate = sums.estimate()?;
        let harmonics = matching_pursuit::ranked(&sums, &estimate, frictions, wavenumbers)?;
        let mut period_half_width_rad = 0.0;
        if let Some(Harmonic { per_turn, amplitude_mnm, phase_rad, .. }) = harmonics.first() {
            let base = sums.width();
            let pair = [amplitude_mnm * phase_rad.cos(), amplitude_mnm * phase_rad.sin()];
            sums.push(matching_pursuit::tangent(&map.motion.angle_rad, *per_turn, pair));
            if let Some(wider) = sums.estimate() {
                let deviation = wider.covariance[(base, base)].max(0.0).sqrt();
                period_half_width_rad = critical() * deviation / per_turn.powi(2);
            }
            sums.truncate(base);
        }
        Some(Self { sums, estimate, harmonics, period_half_width_rad, whole_turn })
    }

    /// The fit with these notes; `no_detents` says why it has no detents, if it has none.
    fn fit(
        &self,
        samples: &Samples<'_>,
        map: &Map,
        frictions: &[Friction],
        no_detents: &str,
        mut notes: Vec<String>,
    ) -> Fit {
        let parameters = self.parameters(map, frictions, no_detents);
        notes.extend(one_sided_friction_of(&parameters));
        Fit {
            parameters,
            mean_ci95_textbook_mnm: NORMAL_95 * mean(prediction_sd(&self.sums.columns, &self.estimate.textbook)),
            samples: samples.t_s.len(),
            detent_harmonics: self.harmonics.clone(),
            preparation: preparation(samples, map.torque_mnm.len()),
            notes,
            effects: self.effects(frictions, map),
            ..Fit::default()
        }
        .compared(self.points(map))
    }

    fn no_detents(&self, grid: &Grid) -> String {
        format!(
            "no torque that repeats with the angle stands out and predicts stretches that it was not fitted to{}",
            if grid.whole_turn { "" } else { "; turn the knob further" }
        )
    }

    fn parameters(&self, map: &Map, frictions: &[Friction], no_detents: &str) -> Parameters {
        let without_speed = map.without_speed().to_owned();
        let Estimate { coefficients, covariance, textbook } = &self.estimate;
        let mut parameters = Vec::new();
        for kind in effects::inertia::KIND.parameters.iter().chain(effects::friction::KIND.parameters) {
            let direction = if kind.name.ends_with("_negative") { "negative" } else { "positive" };
            parameters.push(match frictions.iter().position(|(name, _)| *name == kind.name) {
                Some(at) if coefficients[at] >= 0.0 => {
                    let around = |half: f64| Some(interval(coefficients[at], half));
                    let ci95 = around(critical() * covariance[(at, at)].max(0.0).sqrt());
                    let ci95_textbook = around(NORMAL_95 * textbook[(at, at)].max(0.0).sqrt());
                    Parameter { ci95_textbook, ..Parameter::estimated(kind, coefficients[at], ci95) }
                }
                Some(at) => Parameter::not_identifiable(
                    kind,
                    format!(
                        "the mean torque in the {direction} direction is {:.3} mNm against friction: the torque channel has \
                         an offset; calibrate its zero",
                        coefficients[at].abs()
                    ),
                ),
                None if kind.name.starts_with("coulomb") => Parameter::not_identifiable(
                    kind,
                    format!("the knob never turned in the {direction} direction for long enough; sweep both ways"),
                ),
                None => Parameter::not_identifiable(kind, without_speed.clone()),
            });
        }
        let detent = [0, 1, 2].map(|index| &effects::detent::KIND.parameters[index]);
        if let Some(strongest) = self.harmonics.first() {
            let [amplitude, period, phase] = detent;
            let period_rad = 1.0 / strongest.per_turn;
            let period_ci95_rad = Some(interval(period_rad, self.period_half_width_rad));
            parameters.push(Parameter::estimated(amplitude, strongest.amplitude_mnm, strongest.amplitude_ci95_mnm));
            parameters.push(Parameter::estimated(period, period_rad, period_ci95_rad));
            parameters.push(Parameter::estimated(phase, strongest.phase_rad, strongest.phase_ci95_rad));
        } else {
            parameters.extend(detent.map(|kind| Parameter::not_identifiable(kind, no_detents.to_owned())));
        }
        let unknown = |kind: &ParameterKind| Parameter::not_identifiable(kind, without_speed.clone());
        parameters.extend(effects::karnopp_stick::KIND.parameters.iter().map(unknown));
        Parameters(parameters)
    }

    /// Inertia (not estimated), friction, the strongest sinusoid as the detent, and the others as one torque over the angle.
    fn effects(&self, frictions: &[Friction], map: &Map) -> Vec<Effect> {
        let coulomb = |name: &str| {
            let column = frictions.iter().position(|(known, _)| *known == name);
            column.map_or(0.0, |column| self.estimate.coefficients[column].max(0.0))
        };
        let friction = [coulomb("coulomb_negative"), coulomb("coulomb_positive"), 0.0, 0.0];
        let mut effects =
            vec![Effect::new(&effects::inertia::KIND, &[0.0]), Effect::new(&effects::friction::KIND, &friction)];
        if let Some((strongest, others)) = self.harmonics.split_first() {
            let values = [strongest.amplitude_mnm, 1.0 / strongest.per_turn, strongest.phase_rad];
            effects.push(Effect::new(&effects::detent::KIND, &values));
            effects.extend(self.as_table(others, map));
        }
        effects
    }

    /// Sinusoids as a torque over the angle, which repeats after a turn if one was covered; `None` for none.
    fn as_table(&self, sinusoids: &[Harmonic], map: &Map) -> Option<Effect> {
        let finest = sinusoids.iter().map(|one| one.per_turn).reduce(f64::max)?;
        let [lowest_rad, highest_rad] = if self.whole_turn { [0.0, TAU] } else { range(&map.motion.angle_rad) };
        let travel_rad = highest_rad - lowest_rad;
        let count = (POINTS_A_PERIOD * finest * travel_rad / TAU).clamp(POINTS_A_PERIOD, MOST_POINTS).ceil() as u16;
        let period_rad = self.whole_turn.then_some(TAU);
        let spline = Spline::new(&effects::angle_characteristic::KIND, [lowest_rad, highest_rad], count, period_rad)?;
        let sum_mnm = |angle_rad: &f64| {
            sinusoids.iter().map(|one| one.amplitude_mnm * (one.per_turn * angle_rad + one.phase_rad).sin()).sum()
        };
        spline.effect(&spline.points.iter().map(sum_mnm).collect::<Vec<f64>>())
    }

    fn points(&self, map: &Map) -> Vec<Point> {
        let residual = self.sums.residual(&self.estimate.coefficients);
        let deviation_mnm = prediction_sd(&self.sums.columns, &self.estimate.covariance);
        let critical = critical();
        let point =
            |at: usize| Point::of(map.motion.at(at), map.torque_mnm[at], residual[at], critical * deviation_mnm[at]);
        (0..residual.len()).map(point).collect()
    }
}

fn preparation(samples: &Samples<'_>, rows: usize) -> Preparation {
    let rate_hz = 1.0 / typical_step(samples.t_s).0;
    let used = rows as f64 / samples.t_s.len() as f64;
    Preparation {
        method: "quasi-static",
        rate_hz,
        angle_cutoff_hz: 0.5 * rate_hz,
        band_hz: 0.5 * rate_hz,
        sliding_percent: 100.0 * used,
        angle_noise_rad: noise_deviation(samples.angle_rad),
        torque_noise_mnm: noise_deviation(samples.torque_mnm),
        ..Preparation::default()
    }
}
