//! A press and its return at even steps of the travel.

use archive::testers::Curve;
use shared_types::Axis;

use crate::branch::Branch;

/// Steps of the travel, mm: those of Dome Lab's rows.
pub(crate) const STEP_MM: f64 = 0.005;
/// Rows over which features are smoothed, as Dome Lab does.
const SMOOTHED: usize = 7;
/// Least part of the press that a return must cover.
const RETURNED: f64 = 0.5;

/// A press and its return.
#[derive(Clone, Debug)]
pub(crate) struct Stroke {
    /// Rows up to the largest travel.
    pub(crate) press: Branch,
    /// Rows from there on; `None` where the control was not let back.
    pub(crate) back: Option<Branch>,
    /// Travel at which the contact closes on the press, mm; `None` where that was not seen.
    pub(crate) closes_mm: Option<f64>,
}

impl Stroke {
    pub(crate) fn of(curve: &Curve) -> Self {
        let deepest = curve.position.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let turn = curve.position.iter().position(|travel| *travel >= deepest).unwrap_or_default();
        let rows =
            |from: usize, to: usize| curve.position[from..to].iter().copied().zip(curve.load[from..to].iter().copied());
        let branch = |from: usize, to: usize| Branch::of_rows(Axis::Linear, STEP_MM, rows(from, to));
        let press = branch(0, turn + 1);
        let back = branch(turn, curve.len());
        let closes_mm = curve.closed.as_ref().and_then(|closed| {
            let first = closed[..=turn].iter().position(|closed| *closed)?;
            (first > 0).then(|| curve.position[first])
        });
        #[allow(clippy::cast_precision_loss, reason = "a number of rows")]
        let returned = back.len() as f64 > RETURNED * press.len() as f64;
        Self { press, back: returned.then_some(back), closes_mm }
    }
}

/// Means over seven rows about each, over fewer at the ends.
#[allow(clippy::cast_precision_loss, reason = "seven rows")]
pub(crate) fn smoothed(load: &[f64]) -> Vec<f64> {
    let half = SMOOTHED / 2;
    let about = |index: usize| {
        let part = &load[index.saturating_sub(half)..(index + half + 1).min(load.len())];
        part.iter().sum::<f64>() / part.len() as f64
    };
    (0..load.len()).map(about).collect()
}
