//! The two branches of a turned control, as splines, and the noise about them.

use archive::testers::Curve;
use identification::statistics::{NORMAL_95, rms};
use shared_types::Axis;

use super::spline::{Spline, SplineFit};
use crate::branch::Branch;
use crate::noise::Signs;

/// Neighbouring cells whose noise may go together.
const CORRELATED: usize = 4;
/// Least value of 1 − leverage in the correction of a residual.
const LEAST_FREE: f64 = 0.1;

/// Rows in one direction, those in a cell of angle as their mean.
#[derive(Clone, Debug)]
struct Cells {
    angles: Vec<f64>,
    loads: Vec<f64>,
    rows: Vec<f64>,
}

/// Torque over angle in one direction.
#[derive(Clone, Debug)]
pub(super) struct SplineBranch {
    cells: Cells,
    fit: SplineFit,
    smooth: Vec<f64>,
    /// First and last angle, rad.
    pub(super) ends: [f64; 2],
    pub(super) spline: Spline,
    /// Mean square error of prediction (generalised cross-validation; P. Craven, G. Wahba, Numer. Math. 31, 1979, 377–403).
    pub(super) cross_validation: f64,
}

impl SplineBranch {
    /// Fits the rows of a curve in one direction, averaged in cells of `cell` rad, with knots every `knot` rad; `None` for too few
    /// rows.
    pub(super) fn of(curve: &Curve, directions: &[i8], direction: i8, [knot, cell]: [f64; 2]) -> Option<Self> {
        let mut cells: std::collections::BTreeMap<i64, [f64; 3]> = std::collections::BTreeMap::new();
        let rows = curve.position.iter().zip(&curve.load).zip(directions);
        for ((angle, load), _) in rows.filter(|(_, of)| **of == direction) {
            let [sum, loads, count] = cells.entry((angle / cell).floor() as i64).or_default();
            (*sum, *loads, *count) = (*sum + angle, *loads + load, *count + 1.0);
        }
        let column = |take: fn(&[f64; 3]) -> f64| cells.values().map(take).collect::<Vec<f64>>();
        let cells = Cells {
            angles: column(|[sum, _, count]| sum / count),
            loads: column(|[_, loads, count]| loads / count),
            rows: column(|[.., count]| *count),
        };
        Self::fitted(cells, knot, &[], 0.0)
    }

    /// The branch fitted again with hinges at these angles, each `reach` rad wide to either side; `None` if its rows do not determine them.
    pub(super) fn hinged(&self, hinges: &[f64], reach: f64) -> Option<Self> {
        Self::fitted(self.cells.clone(), self.knot(), hinges, reach)
    }

    fn fitted(cells: Cells, knot: f64, hinges: &[f64], reach: f64) -> Option<Self> {
        let Cells { angles, loads, rows } = &cells;
        let fit = SplineFit::new(angles, rows, knot, hinges, reach)?;
        let spline = fit.solve(loads);
        let smooth: Vec<f64> = angles.iter().map(|angle| spline.value(*angle)).collect();
        let squares: f64 =
            loads.iter().zip(&smooth).zip(rows).map(|((load, smooth), count)| count * (load - smooth).powi(2)).sum();
        let cross_validation = squares / (1.0 - fit.width() as f64 / loads.len() as f64).powi(2);
        let ends = [*angles.first()?, *angles.last()?];
        Some(Self { cells, fit, smooth, ends, spline, cross_validation })
    }

    /// From one knot to the next, rad.
    pub(super) fn knot(&self) -> f64 {
        self.fit.knot
    }

    /// The noise about it.
    pub(super) fn noise(&self) -> Noise<'_> {
        let mut left: Vec<f64> =
            self.cells.loads.iter().zip(&self.smooth).map(|(load, smooth)| load - smooth).collect();
        let correlated = together(&left);
        // Next to a hinge the spline follows most of the noise; the leverage corrects for that (H. White's residuals in the form HC2:
        // J. G. MacKinnon, H. White, J. Econometrics 29, 1985, 305–325).
        for (left, leverage) in left.iter_mut().zip(self.fit.leverages()) {
            *left *= correlated / (1.0 - leverage).max(LEAST_FREE).sqrt();
        }
        Noise { branch: self, left }
    }

    /// As rows of a table, `step` apart, with the deviations of redrawn branches.
    pub(super) fn rows(&self, step: f64, redrawn: &[Spline]) -> Branch {
        let count = ((self.ends[1] - self.ends[0]) / step).floor() as usize + 1;
        let mut branch = Branch {
            axis: Axis::Rotary,
            first: self.ends[0],
            step,
            load: vec![0.0; count],
            load_ci95_half_width: vec![0.0; count],
        };
        for index in 0..count {
            let angle = branch.position(index);
            branch.load[index] = self.spline.value(angle);
            let deviations: Vec<f64> = redrawn.iter().map(|spline| spline.value(angle) - branch.load[index]).collect();
            branch.load_ci95_half_width[index] = NORMAL_95 * rms(&deviations);
        }
        branch
    }
}

/// A branch with its residuals, enlarged to correct for the spline's leverage and for the correlation of neighbouring cells.
#[derive(Debug)]
pub(super) struct Noise<'a> {
    branch: &'a SplineBranch,
    left: Vec<f64>,
}

impl Noise<'_> {
    /// The branch as it might have come out with other noise.
    pub(super) fn redrawn(&self, signs: &mut Signs) -> Spline {
        self.branch.fit.solve(&signs.redraw(&self.branch.smooth, &self.left))
    }
}

/// Factor by which the noise of a mean exceeds that of independent values, because neighbours are correlated.
fn together(left: &[f64]) -> f64 {
    let product = |lag: usize| left.iter().zip(&left[lag.min(left.len())..]).map(|(a, b)| a * b).sum::<f64>();
    let variance = product(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let correlations: f64 = (1..=CORRELATED).map(|lag| product(lag) / variance).sum();
    (1.0 + 2.0 * correlations).max(1.0).sqrt()
}
