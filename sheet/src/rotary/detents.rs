//! Where the detents are, and what each of them takes.

use identification::checks::rising_crossings;

use super::spline::Spline;

/// Steps between two detents at which a branch is looked at.
const STEPS: f64 = 96.0;
/// A detent counts once its torque has passed this share of the detents' amplitude on both sides.
const HYSTERESIS: f64 = 0.3;
/// Largest distance of a branch's rest from that of both branches' mean, as a share of a pitch.
const NEAR: f64 = 0.4;

/// Times that the place of a rest is halved: to a millionth of a pitch.
const HALVES: u32 = 14;
/// Share of a pitch that a rest must be away from the ends, where a spline is held on one side only.
const MARGIN: f64 = 0.25;

/// What one detent takes in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Detent {
    /// Where it rests, rad.
    pub(super) angle: f64,
    pub(super) pitch: f64,
    pub(super) peak: f64,
    pub(super) trough: f64,
    pub(super) stiffness: f64,
    pub(super) energy: f64,
}

/// One direction: its branch, +1 or −1, and its mean torque.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<'a> {
    pub(super) spline: &'a Spline,
    pub(super) sign: f64,
    pub(super) level: f64,
}

/// Steps of equal length over a stretch, ends included.
pub(super) fn steps([low, high]: [f64; 2], step: f64) -> impl Iterator<Item = f64> + Clone {
    let count = ((high - low) / step).ceil().max(1.0) as usize;
    (0..=count).map(move |index| low + (high - low) * index as f64 / count as f64)
}

/// Rests of both branches' mean: where it rises through its own mean, far enough on both sides.
pub(super) fn rests(branches: [&Spline; 2], range: [f64; 2], pitch: f64) -> Vec<f64> {
    let at: Vec<f64> = steps(range, pitch / STEPS).collect();
    let torque: Vec<f64> = at.iter().map(|at| 0.5 * (branches[0].value(*at) + branches[1].value(*at))).collect();
    let mean = torque.iter().sum::<f64>() / torque.len() as f64;
    let torque: Vec<f64> = torque.iter().map(|torque| torque - mean).collect();
    let threshold = HYSTERESIS * std::f64::consts::SQRT_2 * identification::statistics::rms(&torque);
    let step = (range[1] - range[0]) / (at.len() - 1) as f64;
    let mut rests: Vec<f64> =
        rising_crossings(&torque, threshold).into_iter().map(|place| range[0] + place * step).collect();
    rests.retain(|rest| (range[0] + MARGIN * pitch..=range[1] - MARGIN * pitch).contains(rest));
    rests
}

/// Where a function rises through zero between two places, by bisection, since it may bend sharply there.
fn crossing(value: impl Fn(f64) -> f64, [mut below, mut above]: [f64; 2]) -> f64 {
    for _ in 0..HALVES {
        let middle = 0.5 * (below + above);
        if value(middle) < 0.0 { below = middle } else { above = middle }
    }
    0.5 * (below + above)
}

impl Side<'_> {
    /// Torque against the turning, less the running friction.
    fn detent_torque(&self, at: f64) -> f64 {
        self.sign * (self.spline.value(at) - self.level)
    }

    /// Where this branch rises through its mean, near a rest.
    pub(super) fn rest(&self, near: f64, pitch: f64) -> Option<f64> {
        let at: Vec<f64> = steps([near - NEAR * pitch, near + NEAR * pitch], pitch / STEPS).collect();
        let value = |at: f64| self.spline.value(at) - self.level;
        let rises = at.windows(2).filter(|pair| value(pair[0]) < 0.0 && value(pair[1]) >= 0.0);
        let crossings = rises.map(|pair| crossing(value, [pair[0], pair[1]]));
        crossings.min_by(|a, b| (a - near).abs().total_cmp(&(b - near).abs()))
    }

    /// What is taken from a rest to the next in the direction of turning.
    pub(super) fn detent(&self, rest: f64, next: f64) -> Detent {
        let pitch = (next - rest).abs();
        let at: Vec<f64> = steps([rest.min(next), rest.max(next)], pitch / STEPS).collect();
        let against: Vec<f64> = at.iter().map(|at| self.sign * self.spline.value(*at)).collect();
        let detent: Vec<f64> = at.iter().map(|at| self.detent_torque(*at)).collect();
        // From the rest on, whichever way that is.
        let mut order: Vec<f64> = detent;
        if self.sign < 0.0 {
            order.reverse();
        }
        let crest =
            (1..order.len()).find(|index| order[*index] < 0.0 && order[index - 1] >= 0.0).unwrap_or(order.len());
        let step = at[1] - at[0];
        let energy = order[..crest].windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) * step).sum();
        Detent {
            angle: rest,
            pitch,
            peak: against.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            trough: against.iter().copied().fold(f64::INFINITY, f64::min),
            stiffness: self.spline.slope(rest),
            energy,
        }
    }
}
