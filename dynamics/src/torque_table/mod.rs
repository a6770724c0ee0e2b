//! A torque drawn as points over the angle, with a smooth curve through them.

mod error;
mod interpolant;

use std::io::Read;

use foreign_files::{Column, OtherColumns, read_columns};

use crate::{Coordinate, TableUse, interned};

pub use self::error::TorqueTableError;

/// Most points of a table: ten times what a hand can place.
const MOST_POINTS: usize = 10_000;
/// Fewest points.
const FEWEST_POINTS: usize = 3;
/// Largest jump between the torque of the last point and that of the first which it repeats, as a share of the
/// table's range: rounding of a drawing, not a step that could be felt.
const JUMP_SHARE: f64 = 1e-3;
/// Relative difference up to which a table's length is its period.
const SAME_PERIOD: f64 = 1e-9;

/// What lies between two neighbouring points of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// A cubic with continuous slope that is monotone where the points are.
    Cubic,
    /// A cubic with continuous slope, whose torque everywhere is a linear function of the points' torques (Catmull and Rom).
    Spline,
    /// A quarter of a sine, flat at the point of the larger magnitude: points alternate between zeros and extremes.
    Sine,
}

/// A torque drawn over one period of the angle, or over a range beyond which it keeps the torque of the nearer end.
///
/// With [`Curve::Cubic`] it is a cubic between neighbouring points, with continuous slope, across the period's end too. Where the
/// points rise it rises, where they fall it falls, and it has its extremes at points: nobody who draws a detent of
/// 10 mNm expects 11. A periodic cubic spline would be smoother by one derivative, but overshoots at every corner.
/// Slopes after F. N. Fritsch and J. Butland, *A method for constructing local monotone piecewise cubic
/// interpolants*, SIAM J. Sci. Stat. Comput. 5 (1984) 300–304.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueTable {
    curve: Curve,
    /// `None` for a table that keeps its ends' torques beyond them.
    period_rad: Option<f64>,
    points: Vec<f64>,
    torque_mnm: Vec<f64>,
    /// Slope at every point, mNm/rad.
    slope_mnm_rad: Vec<f64>,
}

impl TorqueTable {
    /// The table through points at rising angles, rad, with their torques, mNm.
    ///
    /// It repeats after `period_rad`; without one the last point repeats the first, and the period is what lies
    /// between them. The table is kept for as long as the program runs, equal ones once: see [`crate::Effect`].
    ///
    /// # Errors
    /// [`TorqueTableError`] for what is no periodic function of the angle.
    pub fn kept(
        angle_rad: &[f64],
        torque_mnm: &[f64],
        period_rad: Option<f64>,
    ) -> Result<&'static Self, TorqueTableError> {
        let of = TableUse { curve: Curve::Cubic, over: Coordinate::Angle, holds: false };
        Self::kept_for(of, angle_rad, torque_mnm, period_rad)
    }

    /// [`TorqueTable::kept`] for the table of an effect's kind, with points over the coordinate of `of`.
    ///
    /// # Errors
    /// [`TorqueTableError`] for what is no function of the coordinate.
    pub fn kept_for(
        of: TableUse,
        points: &[f64],
        torque_mnm: &[f64],
        period_rad: Option<f64>,
    ) -> Result<&'static Self, TorqueTableError> {
        Self::through(of, points, torque_mnm, period_rad).map(interned::table)
    }

    /// [`TorqueTable::kept`] from a text with the columns `angle_rad` and `torque_mnm`, where the last point repeats the first.
    ///
    /// # Errors
    /// [`TorqueTableError`], also for text that is no such table.
    pub fn kept_from_csv(text: impl Read) -> Result<&'static Self, TorqueTableError> {
        let wanted = ["angle_rad", "torque_mnm"].map(Column::required);
        let [angle_rad, torque_mnm] = read_columns(text, wanted, OtherColumns::Refused)?.map(Option::unwrap_or_default);
        Self::kept(&angle_rad, &torque_mnm, None)
    }

    /// The table of [`TorqueTable::kept_for`] by value, not kept.
    ///
    /// # Errors
    /// [`TorqueTableError`] for what is no function of the coordinate.
    pub fn through(
        of: TableUse,
        angle_rad: &[f64],
        torque_mnm: &[f64],
        period_rad: Option<f64>,
    ) -> Result<Self, TorqueTableError> {
        check_points(of.coordinate_name(), angle_rad, torque_mnm)?;
        let span_rad = angle_rad[angle_rad.len() - 1] - angle_rad[0];
        let held = of.holds && period_rad.is_none();
        let period_rad = period_rad.unwrap_or(span_rad);
        let within = period_rad.is_finite() && period_rad >= span_rad * (1.0 - SAME_PERIOD);
        if !within {
            return Err(TorqueTableError::Period { period_rad, span_rad });
        }
        let repeats = !held && (period_rad - span_rad).abs() <= SAME_PERIOD * span_rad;
        if repeats {
            check_jump(torque_mnm)?;
        }
        let points = angle_rad.len() - usize::from(repeats);
        let mut table = Self {
            curve: of.curve,
            period_rad: (!held).then_some(period_rad),
            points: angle_rad[..points].to_vec(),
            torque_mnm: torque_mnm[..points].to_vec(),
            slope_mnm_rad: Vec::new(),
        };
        table.slope_mnm_rad = (0..points).map(|point| table.slope_at(point)).collect();
        // Torques or angles near the limits of floating-point numbers give slopes that are not finite.
        if table.steepest_mnm_rad().is_finite() { Ok(table) } else { Err(TorqueTableError::TooSteep) }
    }

    /// Angle after which it repeats, rad; `None` if it keeps its ends' torques beyond them.
    #[must_use]
    pub fn period_rad(&self) -> Option<f64> {
        self.period_rad
    }

    /// Where the points lie, rising, within one period: rad, or rad/s over the speed.
    #[must_use]
    pub fn points(&self) -> &[f64] {
        &self.points
    }

    /// Torques of the points, mNm.
    #[must_use]
    pub fn points_mnm(&self) -> &[f64] {
        &self.torque_mnm
    }
}

fn check_points(name: &'static str, angle_rad: &[f64], torque_mnm: &[f64]) -> Result<(), TorqueTableError> {
    let (angles, torques) = (angle_rad.len(), torque_mnm.len());
    if angles != torques {
        return Err(TorqueTableError::Lengths { angles, torques });
    }
    if !(FEWEST_POINTS..=MOST_POINTS).contains(&angles) {
        return Err(TorqueTableError::Points { points: angles, fewest: FEWEST_POINTS, most: MOST_POINTS });
    }
    for (column, values) in [(name, angle_rad), ("torque_mnm", torque_mnm)] {
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(TorqueTableError::NotFinite { column, point: index + 1, value: values[index] });
        }
    }
    let turned_back = angle_rad.windows(2).position(|pair| pair[1] <= pair[0]);
    turned_back.map_or(Ok(()), |index| {
        Err(TorqueTableError::NotRising {
            point: index + 2,
            before_rad: angle_rad[index],
            angle_rad: angle_rad[index + 1],
        })
    })
}

/// Checks that a last point which repeats the first has its torque.
fn check_jump(torque_mnm: &[f64]) -> Result<(), TorqueTableError> {
    let extreme = |choose: fn(f64, f64) -> f64| torque_mnm.iter().copied().fold(torque_mnm[0], choose);
    let allowed_mnm = JUMP_SHARE * (extreme(f64::max) - extreme(f64::min));
    let (first_mnm, last_mnm) = (torque_mnm[0], torque_mnm[torque_mnm.len() - 1]);
    let jump_mnm = (last_mnm - first_mnm).abs();
    if jump_mnm <= allowed_mnm {
        return Ok(());
    }
    Err(TorqueTableError::NotPeriodic { first_mnm, last_mnm, jump_mnm, allowed_mnm })
}
