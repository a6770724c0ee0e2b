//! What the page of a trend is made of; it serialises to what `trend --json` gives.

use std::collections::BTreeMap;

use identification::statistics::{mean_angle, nearest_turn, student_95};
use serde::Serialize;

/// Parameters over time, group by group.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Trend {
    /// The table that they were taken from.
    pub source: String,
    /// What captures are grouped by: `knob` or `rig`.
    pub by: String,
    /// The groups, by name.
    pub groups: Vec<TrendGroup>,
    /// Captures of the table with an error, which are left out.
    pub with_error: usize,
    /// Captures whose files do not say when they were made, of which only the verdicts count.
    pub without_time: usize,
    /// Version of the program that made the page.
    #[serde(skip)]
    pub software_version: String,
}

/// Captures that belong together.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TrendGroup {
    /// The knob or the rig.
    pub name: String,
    /// Its parameters, and figures of the sheet, as the table has them.
    pub parameters: Vec<TrendParameter>,
    /// Captures by their verdicts; empty of a table without a specification.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub verdicts: BTreeMap<String, usize>,
}

impl TrendGroup {
    /// The verdicts as `3 fail, 20 pass`.
    #[must_use]
    pub fn verdicts_in_words(&self) -> String {
        let words: Vec<String> = self.verdicts.iter().map(|(verdict, count)| format!("{count} {verdict}")).collect();
        words.join(", ")
    }
}

/// A parameter over time.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TrendParameter {
    /// Standard name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Captures that tell it.
    pub captures: usize,
    /// Mean of the captures.
    pub mean: f64,
    /// Standard deviation from capture to capture; `None` of one.
    pub sd: Option<f64>,
    /// Mean half width of the captures' own 95 % intervals.
    pub mean_ci95_half_width: Option<f64>,
    /// How it drifts; `None` of fewer than three times.
    pub drift: Option<Drift>,
    /// Each capture, in the order of time.
    #[serde(skip)]
    pub points: Vec<TrendPoint>,
}

/// A straight line through the captures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// Change a day.
    pub per_day: f64,
    /// 95 % interval of the change a day, from the captures' scatter about the line.
    pub per_day_ci95: [f64; 2],
    /// Value at the first capture of the table.
    pub at_start: f64,
}

impl Drift {
    /// Whether chance hardly explains it.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.per_day_ci95[0] > 0.0 || self.per_day_ci95[1] < 0.0
    }
}

/// A capture's value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrendPoint {
    /// Days since the first capture of the table.
    pub days: f64,
    /// Its value.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
}

impl TrendParameter {
    /// Mean, scatter and drift of a parameter's captures.
    #[must_use]
    pub fn of(name: &str, unit: &str, mut points: Vec<TrendPoint>) -> Self {
        points.sort_by(|one, other| one.days.total_cmp(&other.days));
        if name.ends_with("phase") {
            put_on_one_turn(&mut points);
        }
        let count = crate::figures::real(points.len());
        let mean_of = |of: &dyn Fn(&TrendPoint) -> f64| points.iter().map(of).sum::<f64>() / count;
        let mean = mean_of(&|point| point.value);
        let (mean_days, squares) = (mean_of(&|point| point.days), mean_of(&|point| (point.value - mean).powi(2)));
        let half_widths: Vec<f64> =
            points.iter().filter_map(|point| point.ci95.map(|[low, high]| 0.5 * (high - low))).collect();
        let half_width = half_widths.iter().sum::<f64>() / crate::figures::real(half_widths.len());
        let spread = mean_of(&|point| (point.days - mean_days).powi(2));
        let per_day = mean_of(&|point| (point.days - mean_days) * (point.value - mean)) / spread;
        let drift = (points.len() > 2 && spread > 0.0).then(|| {
            let left = mean_of(&|point| (point.value - mean - per_day * (point.days - mean_days)).powi(2));
            let half = student_95(count - 2.0) * (left / ((count - 2.0) * spread)).sqrt();
            Drift { per_day, per_day_ci95: [per_day - half, per_day + half], at_start: mean - per_day * mean_days }
        });
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            captures: points.len(),
            mean,
            sd: (points.len() > 1).then(|| (squares * count / (count - 1.0)).sqrt()),
            mean_ci95_half_width: (!half_widths.is_empty()).then_some(half_width),
            drift,
            points,
        }
    }
}

/// Moves phases by whole turns to within half a turn of their mean on the circle.
fn put_on_one_turn(phases: &mut [TrendPoint]) {
    let centre_rad = mean_angle(phases.iter().map(|phase| (phase.value, 1.0)));
    for phase in phases {
        let by = nearest_turn(phase.value, centre_rad) - phase.value;
        phase.value += by;
        phase.ci95 = phase.ci95.map(|ends| ends.map(|end| end + by));
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn phases_on_both_sides_of_the_circles_cut_lie_side_by_side() {
        let days = [0.0, 1.0, 2.0, 3.0, 4.0];
        let values = [3.13, -3.13, 3.12, -3.12, 3.13];
        let point = |(days, value): (f64, f64)| TrendPoint { days, value, ci95: Some([value - 0.1, value + 0.1]) };
        let points = || days.into_iter().zip(values).map(point).collect();
        let phase = TrendParameter::of("detent_phase", "rad", points());
        assert!((phase.mean.abs() - PI).abs() < 0.03 && phase.sd.is_some_and(|sd| sd < 0.02), "{}", phase.mean);
        assert!(phase.points.iter().all(|one| one.ci95.is_some_and(|[low, high]| low < one.value && one.value < high)));
        assert!(TrendParameter::of("inertia", "mNm s²/rad", points()).sd.is_some_and(|sd| sd > 3.0));
    }
}
