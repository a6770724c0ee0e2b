//! The curve through a table's points.

use std::f64::consts::FRAC_PI_2;

use super::{Curve, TorqueTable};

/// The curve between two neighbouring points, as a function of the share t of the way from one to the other.
struct Piece {
    curve: Curve,
    width_rad: f64,
    torque_mnm: [f64; 2],
    /// Slopes at both ends times the width, mNm.
    rise_mnm: [f64; 2],
}

impl Piece {
    /// A quarter of a sine, or Hermite's cubic.
    fn torque_mnm(&self, t: f64) -> f64 {
        let Self { torque_mnm: [from, to], rise_mnm: [leaving, arriving], .. } = *self;
        if self.curve == Curve::Sine {
            let flat_end = from.abs() <= to.abs();
            let (sine, cosine) = (FRAC_PI_2 * t).sin_cos();
            return if flat_end { from + (to - from) * sine } else { to + (from - to) * cosine };
        }
        let difference = to - from;
        let square = leaving - difference;
        let cube = difference - arriving;
        // (1 − t)·from + t·to plus what bends it, so that equal ends stay exact.
        (1.0 - t) * from + t * to + t * (1.0 - t) * (square * (1.0 - t) + cube * t)
    }

    /// Largest magnitude of the slope, mNm/rad: at an end or where the second derivative vanishes.
    fn steepest_mnm_rad(&self) -> f64 {
        let Self { width_rad, torque_mnm: [from, to], rise_mnm: [leaving, arriving], .. } = *self;
        if self.curve == Curve::Sine {
            return FRAC_PI_2 * (to - from).abs() / width_rad;
        }
        // slope·width = leaving + 2·b·t + 3·c·t²
        let b = 3.0 * (to - from) - 2.0 * leaving - arriving;
        let c = leaving + arriving - 2.0 * (to - from);
        let turning = -b / (3.0 * c);
        let inside = if turning > 0.0 && turning < 1.0 { leaving + b * turning } else { 0.0 };
        leaving.abs().max(arriving.abs()).max(inside.abs()) / width_rad
    }
}

impl TorqueTable {
    /// Torque at an angle, or at a speed, mNm.
    #[must_use]
    pub fn torque_mnm(&self, at: f64) -> f64 {
        let first = self.points[0];
        let within = self.period_rad.map_or(at, |period_rad| first + (at - first).rem_euclid(period_rad));
        let point = self.points.partition_point(|point| *point <= within).clamp(1, self.pieces()) - 1;
        let piece = self.piece(point);
        // Beyond the ends, or where rounding leaves it a little beyond the period's end.
        piece.torque_mnm(((within - self.points[point]) / piece.width_rad).clamp(0.0, 1.0))
    }

    /// Steepest slope |dτ/dθ| of the curve over all angles, mNm/rad.
    #[must_use]
    pub fn steepest_mnm_rad(&self) -> f64 {
        let each = (0..self.pieces()).map(|point| self.piece(point).steepest_mnm_rad());
        // A slope that is not finite counts as infinitely steep.
        each.fold(0.0, |most, steepest| if steepest.is_finite() { steepest.max(most) } else { f64::INFINITY })
    }

    /// The slope at a point, mNm/rad: zero at an extreme, otherwise the harmonic mean of the secants' on both sides,
    /// the nearer neighbour weighing more.
    pub(super) fn slope_at(&self, point: usize) -> f64 {
        if self.period_rad.is_none() && (point == 0 || point == self.pieces()) {
            return self.secant(point.min(self.pieces() - 1))[1];
        }
        let before = (point + self.points.len() - 1) % self.points.len();
        let ([width_before, secant_before], [width, secant]) = (self.secant(before), self.secant(point));
        if self.curve == Curve::Spline {
            return (width * secant_before + width_before * secant) / (width + width_before);
        }
        if secant_before * secant <= 0.0 {
            return 0.0;
        }
        let (weight_before, weight) = (2.0 * width + width_before, width + 2.0 * width_before);
        (weight_before + weight) / (weight_before / secant_before + weight / secant)
    }

    fn piece(&self, point: usize) -> Piece {
        let next = (point + 1) % self.points.len();
        let width_rad = self.width_rad(point);
        Piece {
            curve: self.curve,
            width_rad,
            torque_mnm: [self.torque_mnm[point], self.torque_mnm[next]],
            rise_mnm: [self.slope_mnm_rad[point] * width_rad, self.slope_mnm_rad[next] * width_rad],
        }
    }

    /// Width and slope of the straight line from a point to the next.
    fn secant(&self, point: usize) -> [f64; 2] {
        let next = (point + 1) % self.points.len();
        let width_rad = self.width_rad(point);
        [width_rad, (self.torque_mnm[next] - self.torque_mnm[point]) / width_rad]
    }

    /// Angle from a point to the next, across the period's end from the last, rad.
    fn width_rad(&self, point: usize) -> f64 {
        match self.points.get(point + 1) {
            Some(next_rad) => next_rad - self.points[point],
            None => self.points[0] + self.period_rad.unwrap_or(f64::INFINITY) - self.points[point],
        }
    }

    /// Number of curves between points: one more across the period's end.
    fn pieces(&self) -> usize {
        self.points.len() - usize::from(self.period_rad.is_none())
    }
}
