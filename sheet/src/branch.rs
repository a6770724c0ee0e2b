//! Load over position in one direction, at even steps.

use std::collections::BTreeMap;

use serde::ser::{Serialize, Serializer};
use shared_types::Axis;

/// Load over position in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Turned or pressed.
    pub axis: Axis,
    /// The first position, rad or mm.
    pub first: f64,
    /// From one position to the next, rad or mm.
    pub step: f64,
    /// Load at each position, mNm or N.
    pub load: Vec<f64>,
    /// Half width of the load's 95 % interval at each position.
    pub load_ci95_half_width: Vec<f64>,
}

impl Branch {
    /// Means of rows in cells of `step` about its multiples; between cells without rows, straight lines.
    pub(crate) fn of_rows(axis: Axis, step: f64, rows: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let cell = |position: f64| (position / step).round() as i64;
        let ends = rows.clone().map(|(position, _)| cell(position));
        let (low, high) = ends.fold((i64::MAX, i64::MIN), |(low, high), at| (low.min(at), high.max(at)));
        let cells = usize::try_from(high.saturating_sub(low)).map_or(0, |last| last + 1);
        let (mut sums, mut counts) = (vec![0.0; cells], vec![0.0; cells]);
        for (position, load) in rows {
            if let Some(at) = usize::try_from(cell(position) - low).ok().filter(|at| *at < cells) {
                sums[at] += load;
                counts[at] += 1.0;
            }
        }
        let means: Vec<Option<f64>> =
            sums.iter().zip(&counts).map(|(sum, count)| (*count > 0.0).then(|| sum / count)).collect();
        let first = low as f64 * step;
        Self { axis, first, step, load: bridged(&means), load_ci95_half_width: vec![0.0; cells] }
    }

    /// Number of positions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.load.len()
    }

    /// True without any position.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.load.is_empty()
    }

    /// The position of that index, rad or mm.
    #[must_use]
    pub fn position(&self, index: usize) -> f64 {
        self.first + index as f64 * self.step
    }

    /// Every position, rad or mm.
    pub fn positions(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|index| self.position(index))
    }

    /// Load at a position between the first and the last; `None` beyond.
    #[must_use]
    pub fn load_at(&self, position: f64) -> Option<f64> {
        let place = (position - self.first) / self.step;
        // Positions that come from the branch itself may lie a rounding beyond its ends.
        if !(place > -1e-6 && place < (self.len() as f64 - 1.0) + 1e-6) {
            return None;
        }
        let below = (place.max(0.0).floor() as usize).min(self.len().saturating_sub(2));
        let share = place - below as f64;
        Some(self.load[below] + share * (self.load.get(below + 1)? - self.load[below]))
    }
}

/// The values, with straight lines between those that are there.
fn bridged(values: &[Option<f64>]) -> Vec<f64> {
    let mut filled = vec![0.0; values.len()];
    let mut before: Option<(usize, f64)> = None;
    for (index, value) in values.iter().enumerate() {
        let Some(value) = *value else { continue };
        let (from, start) = before.unwrap_or((index, value));
        for (step, filled) in filled[from..=index].iter_mut().enumerate() {
            let share = if index > from { step as f64 / (index - from) as f64 } else { 0.0 };
            *filled = start + share * (value - start);
        }
        before = Some((index, value));
    }
    filled
}

/// As columns whose names carry their units.
impl Serialize for Branch {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [position, load] =
            [self.axis.position(), self.axis.load()].map(|quantity| (quantity.name(), quantity.unit().to_lowercase()));
        let columns: BTreeMap<String, Vec<f64>> = [
            (format!("{}_{}", position.0, position.1), self.positions().collect()),
            (format!("{}_{}", load.0, load.1), self.load.clone()),
            (format!("{}_ci95_half_width_{}", load.0, load.1), self.load_ci95_half_width.clone()),
        ]
        .into();
        columns.serialize(serializer)
    }
}
