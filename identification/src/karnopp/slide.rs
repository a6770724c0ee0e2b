//! A knob that starts from rest or comes to rest: the instant, from the motion.
//!
//! Away from its rest the knob obeys M·θ̈ = τ − friction − detents. The torque is measured and everything else is fitted
//! already, so a trajectory from rest has one unknown, the instant at which it leaves, and one that ends in rest has
//! a second, the speed with which it arrives. Both follow from the encoder by least squares: the problem is linear in the
//! speed and the angle at rest, and the instant is searched.

use std::ops::Range;

use dynamics::{Direction, Effect, Motion, Part};

use crate::regression::least_squares::LeastSquares;

/// How far into a rest its end is looked for, in windows.
const DEEPEST: usize = 4;
/// Instants that are tried in a window at least.
const TRIED: usize = 12;
/// Rounds of golden section that narrow the instant from two samples to about a thousandth of one.
const ROUNDS: u32 = 16;
/// 1 − 1/φ.
const GOLDEN: f64 = 0.381_966;
/// A trajectory fits if what remains is at most this many standard deviations of the angle's noise.
const FITS: f64 = 2.0;
/// Share of the distance moved that the fitted model may lack.
const LACKING: f64 = 1e-3;
/// A knob that moved less than this many standard deviations cannot be timed.
const MOVED: f64 = 20.0;

/// The capture and the fitted effects from which trajectories are computed.
pub(super) struct Slide<'a> {
    /// Angle of the knob, not filtered, rad.
    pub(super) angle_rad: &'a [f64],
    /// Standard deviation of its noise, rad.
    pub(super) noise_rad: f64,
    /// Torque on the knob without its delay, mNm.
    pub(super) torque_mnm: &'a [f64],
    /// The effects fitted so far.
    pub(super) effects: &'a [Effect],
    pub(super) rate_hz: f64,
}

/// The border between rest and sliding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    /// When, in samples since the start of the capture.
    pub(super) instant: f64,
    /// Direction of sliding.
    pub(super) direction: Direction,
    /// Speed at the border, zero for a breakaway, rad/s.
    pub(super) speed_rad_s: f64,
    /// Angle at rest, rad.
    pub(super) rest_rad: f64,
    /// Acceleration of the sliding knob at the border, a magnitude, rad/s².
    pub(super) acceleration_rad_s2: f64,
}

/// On which side of the border the knob slides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Before it: the knob comes to rest.
    Before,
    /// After it: the knob breaks away from rest.
    After,
}

impl Slide<'_> {
    /// The border near one end of a rest; `None` where the knob creeps, is stopped by something else, or the capture ends.
    ///
    /// Looks `window` samples beyond that end and up to `DEEPEST` times as far into the rest: on a slow ramp the knob leaves the noise late.
    pub(super) fn border(&self, rest: &Range<usize>, side: Side, window: usize) -> Option<Border> {
        let end = if side == Side::After { rest.end.checked_sub(1)? } else { rest.start };
        let within = rest.len().clamp(window, DEEPEST * window);
        let (before, after) = if side == Side::After { (within, window) } else { (window, within) };
        let (first, last) = (end.checked_sub(before)?, end + after);
        if last + 1 >= self.angle_rad.len() {
            return None;
        }
        let (inside, outside) = if side == Side::After { (first, last) } else { (last, first) };
        let moved_rad = self.angle_rad[outside] - self.angle_rad[inside];
        if moved_rad.abs() < MOVED * self.noise_rad || moved_rad == 0.0 {
            return None;
        }
        let direction = Direction::of(if side == Side::After { moved_rad } else { -moved_rad });
        let trial = |instant: f64| self.trial(instant, first..last + 1, side, direction);
        let tried: Vec<(usize, f64)> = (first + window / 4..=last - window / 4)
            .step_by((window / TRIED).max(1))
            .map(|index| (index, trial(index as f64).0))
            .collect();
        let best = (0..tried.len()).min_by(|a, b| tried[*a].1.total_cmp(&tried[*b].1))?;
        // If the best instant is the first or the last one tried, the border lies beyond those tried.
        let (mut low, mut high) = (tried.get(best.checked_sub(1)?)?.0 as f64, tried.get(best + 1)?.0 as f64);
        for _ in 0..ROUNDS {
            let (left, right) = (low + GOLDEN * (high - low), high - GOLDEN * (high - low));
            if trial(left).0 <= trial(right).0 {
                high = right;
            } else {
                low = left;
            }
        }
        let (squares, border) = trial(0.5 * (low + high));
        let rms_rad = (squares / (last + 1 - first) as f64).sqrt();
        let limit_rad = FITS * self.noise_rad + LACKING * moved_rad.abs();
        let near = (0.5 * (low + high)).round().max(0.0);
        let at = Motion { angle_rad: border.rest_rad, ..Motion::default() };
        let acceleration_rad_s2 = self.acceleration_rad_s2(self.torque_mnm[near as usize], &at, direction).abs();
        (rms_rad <= limit_rad).then_some(Border { acceleration_rad_s2, ..border })
    }

    /// Least squares for angle at rest and speed with the instant given: the sum of squares left, and the border.
    fn trial(&self, instant: f64, window: Range<usize>, side: Side, direction: Direction) -> (f64, Border) {
        let displacement = self.displacement(instant, &window, side, direction);
        let left: Vec<f64> =
            window.clone().zip(&displacement).map(|(index, moved)| self.angle_rad[index] - moved).collect();
        let since = |index: usize| (index as f64 - instant).min(0.0) / self.rate_hz;
        let mut columns = vec![vec![1.0; left.len()]];
        if side == Side::Before {
            columns.push(window.map(since).collect());
        }
        let fitted = LeastSquares::solve(&columns, &left);
        let speed_rad_s = fitted.coefficients.get(1).map_or(0.0, |slope| slope * direction.sign());
        let rest_rad = fitted.coefficients[0];
        (fitted.squares(), Border { instant, direction, speed_rad_s, rest_rad, acceleration_rad_s2: 0.0 })
    }

    /// Distance from rest at every sample of the window for a knob that slides from `instant` on or until then, at rest there.
    fn displacement(&self, instant: f64, window: &Range<usize>, side: Side, direction: Direction) -> Vec<f64> {
        let mut displacement = vec![0.0; window.len()];
        let mut indices: Vec<usize> = window.clone().collect();
        if side == Side::Before {
            indices.reverse();
        }
        let beyond =
            |index: &usize| if side == Side::After { *index as f64 > instant } else { (*index as f64) < instant };
        let whole = indices.iter().copied().find(beyond);
        let Some(first) = whole else { return displacement };
        let neighbour = if side == Side::After { first.saturating_sub(1) } else { first + 1 };
        let share = (instant - first as f64).abs();
        let mut at = Motion { angle_rad: self.angle_rad[neighbour], ..Motion::default() };
        let rest_rad = at.angle_rad;
        let mut time = instant;
        let mut torque = self.torque_mnm[first] + share * (self.torque_mnm[neighbour] - self.torque_mnm[first]);
        for index in indices.into_iter().filter(beyond) {
            let step_s = (index as f64 - time) / self.rate_hz;
            let next = self.torque_mnm[index];
            let before = self.acceleration_rad_s2(torque, &at, direction);
            let ahead = Motion {
                angle_rad: at.angle_rad + step_s * (at.velocity_rad_s + 0.5 * step_s * before),
                velocity_rad_s: at.velocity_rad_s + step_s * before,
                ..at
            };
            let after = self.acceleration_rad_s2(next, &ahead, direction);
            // Exact for an acceleration that changes along a straight line.
            at.angle_rad += step_s * (at.velocity_rad_s + step_s * (2.0 * before + after) / 6.0);
            at.velocity_rad_s += 0.5 * step_s * (before + after);
            displacement[index - window.start] = at.angle_rad - rest_rad;
            (time, torque) = (index as f64, next);
        }
        displacement
    }

    /// Acceleration of the knob sliding in a direction under a torque.
    fn acceleration_rad_s2(&self, torque_mnm: f64, at: &Motion, direction: Direction) -> f64 {
        let (mut inertia, mut taken_mnm) = (0.0, 0.0);
        for effect in self.effects {
            if let Part::Inertia(of) = effect.kind().part {
                inertia += of(effect.values());
            }
            taken_mnm += effect.free_torque_mnm(at) + effect.friction_mnm(at, direction);
        }
        (torque_mnm - taken_mnm) / inertia
    }

    /// Torque of the angle alone (detents), mNm.
    pub(super) fn angle_torque_mnm(&self, angle_rad: f64) -> f64 {
        let at = Motion { angle_rad, ..Motion::default() };
        self.effects.iter().map(|effect| effect.free_torque_mnm(&at)).sum()
    }
}
