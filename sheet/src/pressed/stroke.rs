//! A press and its return at even steps of the travel.

use std::ops::Range;

use archive::testers::Curve;
use identification::statistics::range;
use shared_types::Axis;

use super::contact::Change;
use crate::branch::Branch;

/// Steps of the travel, mm: those of Dome Lab's rows.
pub(crate) const STEP_MM: f64 = 0.005;
/// Rows over which features are smoothed, as Dome Lab does.
const SMOOTHED: usize = 7;
/// Least part of the press that a return must cover.
const RETURNED: f64 = 0.5;
/// Least fall of the travel after a press, and least rise into a press, as a part of the whole travel.
const TURNED: f64 = 0.25;
/// Least depth of a press that counts, as a part of the whole travel.
const DEEP: f64 = 0.95;

/// A press and its return.
#[derive(Clone, Debug)]
pub(crate) struct Stroke {
    /// Rows up to the largest travel.
    pub(crate) press: Branch,
    /// Rows from there on; `None` where the control was not let back.
    pub(crate) back: Option<Branch>,
    /// Where the contact closes on the press, and when.
    pub(crate) closing: Result<Change, &'static str>,
    /// Where it opens on the way back, and when.
    pub(crate) opening: Result<Change, &'static str>,
}

impl Stroke {
    /// Every press of a curve with its return. One that is cut off counts only where there is no whole one.
    pub(crate) fn all(curve: &Curve) -> Vec<Self> {
        let strokes: Vec<Self> = presses(&curve.position).into_iter().map(|rows| Self::of(curve, rows)).collect();
        let returned = strokes.iter().any(|stroke| stroke.back.is_some());
        strokes.into_iter().filter(|stroke| stroke.back.is_some() || !returned).collect()
    }

    fn of(curve: &Curve, rows: Range<usize>) -> Self {
        let travel = &curve.position[rows.clone()];
        let [_, deepest] = range(travel);
        let turn = rows.start + travel.iter().position(|travel| *travel >= deepest).unwrap_or_default();
        let branch = |rows: Range<usize>| {
            let loads = curve.load[rows.clone()].iter().copied();
            Branch::of_rows(Axis::Linear, STEP_MM, curve.position[rows].iter().copied().zip(loads))
        };
        let press = branch(rows.start..turn + 1);
        let back = branch(turn..rows.end);
        let returned = back.len() as f64 > RETURNED * press.len() as f64;
        Self {
            press,
            back: returned.then_some(back),
            closing: Change::to(true, curve, rows.start..turn + 1),
            opening: Change::to(false, curve, turn..rows.end),
        }
    }
}

/// The rows of each press with its return, which reach from where the travel is least to where it is least again.
fn presses(travel: &[f64]) -> Vec<Range<usize>> {
    let [low, high] = range(travel);
    let swing = TURNED * (high - low);
    let mut found: Vec<(Range<usize>, f64)> = Vec::new();
    let (mut start, mut least, mut most) = (0, 0, None::<usize>);
    for (row, at) in travel.iter().enumerate() {
        match most {
            // Pressed on, until it has come back a good way.
            Some(deepest) if *at < travel[deepest] - swing => {
                found.push((start..travel.len(), travel[deepest]));
                (least, most) = (row, None);
            }
            Some(deepest) if *at > travel[deepest] => most = Some(row),
            Some(_) => {}
            None if *at > travel[least] + swing => {
                // What comes before the first press belongs to it.
                if let Some((rows, _)) = found.last_mut() {
                    rows.end = least;
                    start = least;
                }
                most = Some(row);
            }
            None if *at <= travel[least] => least = row,
            None => {}
        }
    }
    found.extend(most.map(|deepest| (start..travel.len(), travel[deepest])));
    found.into_iter().filter(|(_, deepest)| *deepest >= low + DEEP * (high - low)).map(|(rows, _)| rows).collect()
}

/// Means over seven rows about each, over fewer at the ends.
pub(crate) fn smoothed(load: &[f64]) -> Vec<f64> {
    let half = SMOOTHED / 2;
    let about = |index: usize| {
        let part = &load[index.saturating_sub(half)..(index + half + 1).min(load.len())];
        part.iter().sum::<f64>() / part.len() as f64
    };
    (0..load.len()).map(about).collect()
}
