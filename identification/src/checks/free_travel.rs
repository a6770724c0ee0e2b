//! Lost motion seen without a fit: the knob turns under next to no torque until it meets a contact.

use dynamics::Calibration;

use crate::numerics::statistics::mean;
use crate::preparation::clock::typical_step;
use crate::preparation::compliance::knob_angle_rad;
use crate::samples::{FitError, Samples};

/// Time over which torque and angle are averaged, s.
const BIN_S: f64 = 0.005;
/// Shortest free travel, s: longer than the slip after a breakaway.
const LEAST_S: f64 = 0.1;
/// Share of the capture's largest torque below which there is next to none: a knob's own friction is more.
const NEXT_TO_NONE: f64 = 0.01;
/// Contact is this many times the torque of free travel …
const CONTACT: f64 = 10.0;
/// … within this share of the free travel beyond its end: a detent's torque rises over its whole width instead.
const WITHIN: f64 = 0.5;
/// Factor by which neighbouring bins' steps may differ: a creeping motor turns evenly, a slip does not.
const EVEN: f64 = 4.0;

/// One stretch of free travel.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct FreeTravel {
    /// Time at which it began, s.
    pub t_s: f64,
    /// Angle at which it began, rad.
    pub from_rad: f64,
    /// Angle at which it ended, rad.
    pub to_rad: f64,
}

impl FreeTravel {
    /// How far the knob turned freely, rad.
    #[must_use]
    pub fn travel_rad(&self) -> f64 {
        (self.to_rad - self.from_rad).abs()
    }
}

/// Finds where the knob turns evenly and slowly under next to no torque, with a contact at one end of the travel or at both.
///
/// Friction is the same all along the way, the torque of a detent rises over its whole width, and a slip lasts only a few
/// hundredths of a second. Where none of the three shows, it is not the knob that turns but a part of it with
/// lost motion. A slow creep (`--sweep slow-turn --amplitude 0.1`) shows it; a fast sweep cannot, since inertia takes
/// torque there. Takes zero and stiffness from `known`.
///
/// # Errors
/// [`FitError`] for samples that are no capture of a motion.
pub fn free_travel(samples: &Samples<'_>, known: Option<&Calibration>) -> Result<Vec<FreeTravel>, FitError> {
    samples.check()?;
    let bins = Bins::of(samples, known);
    let mut found = Vec::new();
    let mut start = 0;
    while start < bins.steps_rad.len() {
        let end = bins.free_until(start);
        if (end - start) as f64 * BIN_S >= LEAST_S && bins.touches(start, end) {
            found.push(FreeTravel {
                t_s: bins.t_s[start],
                from_rad: bins.angle_rad[start],
                to_rad: bins.angle_rad[end],
            });
        }
        start = end.max(start + 1);
    }
    Ok(found)
}

/// Means over short times.
struct Bins {
    t_s: Vec<f64>,
    angle_rad: Vec<f64>,
    torque_mnm: Vec<f64>,
    /// From each bin to the next.
    steps_rad: Vec<f64>,
    /// Torque that is next to none, mNm.
    little_mnm: f64,
}

impl Bins {
    fn of(samples: &Samples<'_>, known: Option<&Calibration>) -> Self {
        let zero_mnm = known.map_or(0.0, |known| known.torque_zero_mnm);
        let length = ((BIN_S / typical_step(samples.t_s).0).round() as usize).max(1);
        let means = |values: &[f64]| -> Vec<f64> { values.chunks_exact(length).map(mean).collect() };
        let angle_rad = means(&knob_angle_rad(samples.angle_rad, samples.torque_mnm, known));
        let torque_mnm: Vec<f64> = means(samples.torque_mnm).iter().map(|torque| torque - zero_mnm).collect();
        let largest_mnm = torque_mnm.iter().fold(0.0_f64, |largest, torque| largest.max(torque.abs()));
        let steps_rad = angle_rad.windows(2).map(|pair| pair[1] - pair[0]).collect();
        Self { t_s: means(samples.t_s), angle_rad, torque_mnm, steps_rad, little_mnm: NEXT_TO_NONE * largest_mnm }
    }

    /// The bin up to which the knob turns on from `start` evenly, in one direction and under next to no torque.
    fn free_until(&self, start: usize) -> usize {
        let is_free = |bin: &usize| {
            let [before, step] = [bin.saturating_sub(1).max(start), *bin].map(|bin| self.steps_rad[bin]);
            let even = step * before > 0.0 && step.abs() < EVEN * before.abs() && before.abs() < EVEN * step.abs();
            even && self.torque_mnm[*bin].abs() <= self.little_mnm
        };
        start + (start..self.steps_rad.len()).take_while(is_free).count()
    }

    /// Whether a contact held the knob just before the start or just beyond the end of a free travel.
    fn touches(&self, start: usize, end: usize) -> bool {
        let travel = self.angle_rad[end] - self.angle_rad[start];
        let is_near =
            |bin: usize, edge: usize| (self.angle_rad[bin] - self.angle_rad[edge]).abs() <= WITHIN * travel.abs();
        let holds = |bin: usize, sign: f64| sign * self.torque_mnm[bin] >= CONTACT * self.little_mnm;
        let beyond = (end..self.angle_rad.len()).take_while(|bin| is_near(*bin, end));
        let behind = (0..=start).rev().take_while(|bin| is_near(*bin, start));
        beyond.into_iter().any(|bin| holds(bin, travel.signum()))
            || behind.into_iter().any(|bin| holds(bin, -travel.signum()))
    }
}
