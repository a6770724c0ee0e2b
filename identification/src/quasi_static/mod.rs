//! A knob that was turned too slowly for its speed to be estimated: torque against angle and direction alone.
//!
//! Stepped or creeping captures map the torque along the angle. Inertia and viscous friction have no part in them; Coulomb
//! friction shows as the distance between passes in the two directions, and detents as sinusoids of the angle,
//! counted per turn where a whole turn was covered.

mod characteristic;

use dynamics::{Effect, ParameterKind, effects};

use crate::estimate::{Fit, Harmonic, Parameter, Parameters, Point, Preparation};
use crate::fit::report::prediction_sd;
use crate::numerics::vector::{extent, smallest_step};
use crate::options::FitOptions;
use crate::preparation::motion::KnobMotion;
use crate::preparation::saturation::Saturation;
use crate::preparation::uniform::typical_step;
use crate::regression::block_sums::{BlockSums, Estimate, critical};
use crate::samples::{FEWEST_SAMPLES, Samples};
use crate::sinusoids::matching_pursuit::{self, Grid};
use crate::uncertainty::statistics::{NORMAL_95, interval, mean, noise_deviation};

/// Fewest rows of a direction from which its friction is told.
const FEWEST_ROWS: usize = FEWEST_SAMPLES / 4;
/// A reversal counts once the knob has come back by this many times what the encoder resolves.
const REVERSAL: f64 = 10.0;
/// Travel in units of a counted reversal from which it is a motion and no noise.
const LEAST_TRAVEL: f64 = 20.0;
/// Mean speed of the passes above which inertia and viscous friction of a knob are no longer small beside the rest, rad/s.
const FASTEST_RAD_S: f64 = 0.5;
/// The travel is divided into this many places …
const PLACES: usize = 50;
/// … of which this share must have been visited: a jump from one place to another is no map.
const VISITED: f64 = 0.8;

/// The rows of a map, as a motion: of the speed only its direction and its mean can be estimated, of the acceleration nothing.
pub(crate) struct Map {
    pub(crate) motion: KnobMotion,
    pub(crate) torque_mnm: Vec<f64>,
    directions: Vec<i8>,
    saturation: Saturation,
}

/// Fits friction and the sinusoids of the angle to checked samples; `None` if the knob did not wander slowly through its travel.
pub(crate) fn fit(samples: &Samples<'_>, options: &FitOptions) -> Option<Fit> {
    let map = Map::of(samples, options.is_quasi_static)?;
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
    let fitted = Fitted::of(sums, &map, frictions.len(), &wavenumbers)?;

    let none = if look_for_detents { fitted.no_detents(&grid) } else { "detents were not asked for".to_owned() };
    let mut notes = map.notes();
    if !wavenumbers.is_empty() && !grid.whole_turn {
        notes.push("less than a whole turn was covered: counts per turn are not whole numbers by rule".to_owned());
    }
    Some(fitted.fit(samples, &map, &frictions, &none, notes))
}

impl Map {
    /// The map of checked samples; `None` if the knob did not wander slowly through its travel. A curve has no duration, so that it is never
    /// too fast.
    pub(crate) fn of(samples: &Samples<'_>, is_curve: bool) -> Option<Self> {
        let saturation = Saturation::of(samples.torque_mnm);
        let step = smallest_step(samples.angle_rad);
        let duration_s = if is_curve { f64::INFINITY } else { samples.t_s.last()? - samples.t_s.first()? };
        let directions = directions(samples.angle_rad, duration_s, step)?;
        let index: Vec<usize> =
            (0..directions.len()).filter(|at| directions[*at] != 0 && !saturation.contains(*at)).collect();
        if index.len() < FEWEST_SAMPLES {
            return None;
        }
        let taken = |column: &[f64]| -> Vec<f64> { index.iter().map(|at| column[*at]).collect() };
        let (time_s, angle_rad) = (taken(samples.t_s), taken(samples.angle_rad));
        let directions: Vec<i8> = index.iter().map(|at| directions[*at]).collect();
        let speed_rad_s = mean_speed_rad_s(&time_s, &angle_rad, &directions);
        let velocity_rad_s = directions.iter().map(|direction| f64::from(*direction) * speed_rad_s).collect();
        let rate_hz = (index.len() - 1) as f64 / (time_s[index.len() - 1] - time_s[0]);
        let columns = [time_s, angle_rad, velocity_rad_s, vec![0.0; index.len()]];
        let motion = KnobMotion::as_given(columns, 0.5 * rate_hz);
        Some(Self { motion, torque_mnm: taken(samples.torque_mnm), directions, saturation })
    }

    /// The frictions of the directions that have rows enough.
    fn frictions(&self) -> Vec<(&'static str, i8)> {
        [("coulomb_negative", -1), ("coulomb_positive", 1)]
            .into_iter()
            .filter(|(_, direction)| self.directions.iter().filter(|d| **d == *direction).count() >= FEWEST_ROWS)
            .collect()
    }

    fn friction_column(&self, (_, direction): (&'static str, i8)) -> Vec<f64> {
        self.directions.iter().map(|d| if *d == direction { f64::from(*d) } else { 0.0 }).collect()
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!(
            "the knob turned too slowly for its speed to be measured: torque against angle and direction was fitted, from {} passes",
            self.directions.chunk_by(|one, other| one == other).count()
        )];
        notes.extend(self.saturation.note("torque", "mNm"));
        notes
    }
}

/// The settled map: friction columns first, then sine and cosine of each sinusoid.
struct Fitted {
    sums: BlockSums,
    estimate: Estimate,
    /// Strongest first.
    harmonics: Vec<Harmonic>,
    /// Half width of the strongest one's period, phase-independent, rad.
    period_half_width_rad: f64,
}

impl Fitted {
    fn of(mut sums: BlockSums, map: &Map, frictions: usize, wavenumbers: &[f64]) -> Option<Self> {
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
        Some(Self { sums, estimate, harmonics, period_half_width_rad })
    }

    /// The fit as it is told.
    fn fit(
        &self,
        samples: &Samples<'_>,
        map: &Map,
        frictions: &[(&'static str, i8)],
        no_detents: &str,
        notes: Vec<String>,
    ) -> Fit {
        Fit {
            parameters: self.parameters(frictions, no_detents),
            mean_ci95_textbook_mnm: NORMAL_95 * mean(prediction_sd(&self.sums.columns, &self.estimate.textbook)),
            samples: samples.t_s.len(),
            detent_harmonics: self.harmonics.clone(),
            preparation: preparation(samples, map.torque_mnm.len()),
            notes,
            effects: self.effects(frictions),
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

    fn parameters(&self, frictions: &[(&'static str, i8)], no_detents: &str) -> Parameters {
        let slow = "the knob turned too slowly: its speed and acceleration do not stand out of the sensors' noise; \
                    sweep faster"
            .to_owned();
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
                None => Parameter::not_identifiable(kind, slow.clone()),
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
        let unknown = |kind: &ParameterKind| Parameter::not_identifiable(kind, slow.clone());
        parameters.extend(effects::karnopp_stick::KIND.parameters.iter().map(unknown));
        Parameters(parameters)
    }

    /// Inertia (not estimated), friction and one detent for each sinusoid.
    fn effects(&self, frictions: &[(&'static str, i8)]) -> Vec<Effect> {
        let coulomb = |name: &str| {
            let place = frictions.iter().position(|(known, _)| *known == name);
            place.map_or(0.0, |at| self.estimate.coefficients[at].max(0.0))
        };
        let friction = [coulomb("coulomb_negative"), coulomb("coulomb_positive"), 0.0, 0.0];
        let mut effects =
            vec![Effect::new(&effects::inertia::KIND, &[0.0]), Effect::new(&effects::friction::KIND, &friction)];
        effects.extend(self.harmonics.iter().map(|harmonic| {
            let values = [harmonic.amplitude_mnm, 1.0 / harmonic.per_turn, harmonic.phase_rad];
            Effect::new(&effects::detent::KIND, &values)
        }));
        effects
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

/// Way over time of all neighbouring rows of one pass, rad/s.
fn mean_speed_rad_s(time_s: &[f64], angle_rad: &[f64], directions: &[i8]) -> f64 {
    let (mut way_rad, mut duration_s) = (0.0, 0.0);
    for at in (1..time_s.len()).filter(|at| directions[at - 1] == directions[*at]) {
        way_rad += f64::from(directions[at]) * (angle_rad[at] - angle_rad[at - 1]);
        duration_s += time_s[at] - time_s[at - 1];
    }
    if duration_s > 0.0 { way_rad / duration_s } else { 0.0 }
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

/// +1 or −1 for the direction of the pass that a sample belongs to; 0 where that is not known: before the first pass,
/// and between a turning point and where the knob has surely turned, while friction changes over.
///
/// `None` if the knob did not wander slowly through its travel.
fn directions(angle_rad: &[f64], duration_s: f64, resolution_rad: f64) -> Option<Vec<i8>> {
    let (lowest, highest) = extent(angle_rad)?;
    let travel = highest - lowest;
    let reversal = REVERSAL * resolution_rad.max(noise_deviation(angle_rad));
    if !reversal.is_finite() || travel < LEAST_TRAVEL * reversal {
        return None;
    }
    let mut visited = [false; PLACES];
    for angle in angle_rad {
        visited[(((angle - lowest) / travel * PLACES as f64) as usize).min(PLACES - 1)] = true;
    }
    if (visited.iter().filter(|place| **place).count() as f64) < VISITED * PLACES as f64 {
        return None;
    }
    let mut directions = vec![0_i8; angle_rad.len()];
    let mut direction = 0_i8;
    let mut path = 0.0;
    // The furthest points of the pass, and where they were.
    let (mut low, mut high) = ((angle_rad[0], 0), (angle_rad[0], 0));
    for (index, angle) in angle_rad.iter().enumerate() {
        if *angle < low.0 {
            low = (*angle, index);
        }
        if *angle > high.0 {
            high = (*angle, index);
        }
        if direction >= 0 && *angle < high.0 - reversal {
            directions[high.1 + 1..index].fill(0);
            path += high.0 - low.0;
            (direction, low) = (-1, (*angle, index));
        } else if direction <= 0 && *angle > low.0 + reversal {
            directions[low.1 + 1..index].fill(0);
            path += high.0 - low.0;
            (direction, high) = (1, (*angle, index));
        }
        directions[index] = direction;
    }
    path += high.0 - low.0;
    (path < FASTEST_RAD_S * duration_s).then_some(directions)
}
