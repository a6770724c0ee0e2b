//! A capture as a map of torque over angle: the passes in either direction.

use std::ops::Range;

use dynamics::{Axis, Calibration};

use crate::numerics::statistics::{median, noise_deviation};
use crate::numerics::vector::{extent, smallest_step};
use crate::preparation::compliance::knob_angle_rad;
use crate::preparation::motion::KnobMotion;
use crate::preparation::outliers::cleaned;
use crate::preparation::saturation::Saturation;
use crate::preparation::wrapped::unwrapped;
use crate::samples::{FEWEST_SAMPLES, Samples};

/// Fewest rows of a direction from which its friction is told.
const FEWEST_ROWS: usize = FEWEST_SAMPLES / 4;
/// A reversal counts once the knob has come back by this many times what the encoder resolves.
const REVERSAL: f64 = 10.0;
/// Least travel that is a motion and not noise, in units of a counted reversal.
const LEAST_TRAVEL: f64 = 20.0;
/// Mean speed of the passes above which a knob's inertia and viscous friction are no longer negligible, rad/s.
const FASTEST_RAD_S: f64 = 0.5;
/// A stay of more than so many times the usual length is a rest …
const REST: f64 = 10.0;
/// … if it is at least this share of the capture.
const SHORTEST_REST: f64 = 0.02;
/// The travel is divided into this many cells …
const CELLS: usize = 50;
/// … of which this share must have been visited: a jump from one angle to another is no map.
const VISITED: f64 = 0.8;

/// A Coulomb friction's parameter and its direction.
pub(super) type Friction = (&'static str, i8);

/// The rows of a slow capture: of the velocity only its direction and its mean can be estimated, of the acceleration nothing.
pub(crate) struct Map {
    pub(crate) motion: KnobMotion,
    pub(crate) torque_mnm: Vec<f64>,
    /// Direction of each row, +1 or −1.
    pub(super) directions: Vec<i8>,
    saturation: Saturation,
    /// What was done to angle and torque, a sentence each.
    cleaned: Vec<String>,
    is_curve: bool,
}

impl Map {
    /// The map of checked samples, corrected by the rig's calibration; `None` if the knob did not pass slowly through its travel. A curve has no
    /// duration, so that it is never too fast.
    pub(crate) fn of(samples: &Samples<'_>, axis: Axis, known: Option<&Calibration>, is_curve: bool) -> Option<Self> {
        let (whole, wraps) = unwrapped(samples.angle_rad, axis).unzip();
        let samples = &Samples { angle_rad: whole.as_deref().unwrap_or(samples.angle_rad), ..*samples };
        let ([angle_rad, torque_mnm], outliers) = cleaned(samples);
        let samples = &Samples { angle_rad: &angle_rad, torque_mnm: &torque_mnm, ..*samples };
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
        let zero_mnm = known.map_or(0.0, |known| known.torque_zero_mnm);
        let torque_mnm: Vec<f64> = taken(samples.torque_mnm).iter().map(|torque_mnm| torque_mnm - zero_mnm).collect();
        let time_s = taken(samples.t_s);
        let angle_rad = knob_angle_rad(&taken(samples.angle_rad), &torque_mnm, known);
        let directions: Vec<i8> = index.iter().map(|at| directions[*at]).collect();
        let speed_rad_s = mean_speed_rad_s(&time_s, &angle_rad, &directions);
        let velocity_rad_s = directions.iter().map(|direction| f64::from(*direction) * speed_rad_s).collect();
        let rate_hz = (index.len() - 1) as f64 / (time_s[index.len() - 1] - time_s[0]);
        let columns = [time_s, angle_rad, velocity_rad_s, vec![0.0; index.len()]];
        let motion = KnobMotion::as_given(columns, 0.5 * rate_hz);
        let cleaned = wraps.into_iter().chain(outliers).collect();
        Some(Self { motion, torque_mnm, directions, saturation, cleaned, is_curve })
    }

    /// The frictions of the directions that have enough rows.
    pub(super) fn frictions(&self) -> Vec<Friction> {
        [("coulomb_negative", -1), ("coulomb_positive", 1)]
            .into_iter()
            .filter(|(_, direction)| self.directions.iter().filter(|d| **d == *direction).count() >= FEWEST_ROWS)
            .collect()
    }

    /// The column of a friction: its direction in the rows of that direction, else zero.
    pub(super) fn friction_column(&self, (_, direction): Friction) -> Vec<f64> {
        self.directions.iter().map(|d| if *d == direction { f64::from(*d) } else { 0.0 }).collect()
    }

    /// Why neither inertia nor viscous friction can be estimated.
    pub(super) fn without_speed(&self) -> &'static str {
        if self.is_curve {
            "without time there is neither speed nor acceleration; choose the table's column of time, if it has one"
        } else {
            "the knob turned too slowly: its speed and acceleration do not stand out of the sensors' noise; sweep faster"
        }
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let why = if self.is_curve {
            "the table has no time, or its column was not chosen"
        } else {
            "the knob turned too slowly for its speed to be measured"
        };
        let mut notes = vec![format!(
            "{why}: torque against angle and direction was fitted, from {} passes",
            self.directions.chunk_by(|one, other| one == other).count()
        )];
        notes.extend(self.faults());
        notes
    }

    /// What is wrong with sensors and samples, a sentence each.
    pub(crate) fn faults(&self) -> impl Iterator<Item = String> + '_ {
        self.saturation.note("torque", "mNm").into_iter().chain(self.cleaned.iter().cloned())
    }
}

/// Mean speed within the passes, rad/s.
fn mean_speed_rad_s(time_s: &[f64], angle_rad: &[f64], directions: &[i8]) -> f64 {
    let (mut way_rad, mut duration_s) = (0.0, 0.0);
    for at in (1..time_s.len()).filter(|at| directions[at - 1] == directions[*at]) {
        way_rad += f64::from(directions[at]) * (angle_rad[at] - angle_rad[at - 1]);
        duration_s += time_s[at] - time_s[at - 1];
    }
    if duration_s > 0.0 { way_rad / duration_s } else { 0.0 }
}

/// +1 or −1 for the direction of the pass that a sample belongs to; 0 where that is not known: before the first pass,
/// and between a turning point and where the knob has surely turned, while friction changes over.
///
/// `None` if the knob did not pass slowly through its travel.
fn directions(angle_rad: &[f64], duration_s: f64, resolution_rad: f64) -> Option<Vec<i8>> {
    let (lowest, highest) = extent(angle_rad)?;
    let travel = highest - lowest;
    let reversal = REVERSAL * resolution_rad.max(noise_deviation(angle_rad));
    if !reversal.is_finite() || travel < LEAST_TRAVEL * reversal {
        return None;
    }
    let mut visited = [false; CELLS];
    for angle in angle_rad {
        visited[(((angle - lowest) / travel * CELLS as f64) as usize).min(CELLS - 1)] = true;
    }
    if (visited.iter().filter(|visited| **visited).count() as f64) < VISITED * CELLS as f64 {
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
    for rest in rests(angle_rad, reversal) {
        directions[rest].fill(0);
    }
    (path < FASTEST_RAD_S * duration_s).then_some(directions)
}

/// Where the knob stays within a counted reversal for so much longer than it does otherwise that it rests, with a torque that says nothing of
/// friction: in a pause, or after the last pass.
fn rests(angle_rad: &[f64], reversal_rad: f64) -> Vec<Range<usize>> {
    let mut stays: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for index in 1..=angle_rad.len() {
        if angle_rad.get(index).is_none_or(|angle| (angle - angle_rad[start]).abs() > reversal_rad) {
            stays.push(start..index);
            start = index;
        }
    }
    let mut lengths: Vec<f64> = stays.iter().map(|stay| stay.len() as f64).collect();
    let longest = (REST * median(&mut lengths)).max(SHORTEST_REST * angle_rad.len() as f64);
    stays.into_iter().filter(|stay| stay.len() as f64 > longest).collect()
}
