//! Why points are no torque table.

use foreign_files::TableError;

/// Points that are no periodic function of the angle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TorqueTableError {
    /// Two columns of different length.
    #[error("the table has {angles} angles but {torques} torques; give every point both")]
    Lengths {
        /// Number of angles.
        angles: usize,
        /// Number of torques.
        torques: usize,
    },
    /// Too few or too many points.
    #[error("the table has {points} points, but it must have {fewest} to {most}")]
    Points {
        /// Number of points.
        points: usize,
        /// Fewest that will do.
        fewest: usize,
        /// Most that will do.
        most: usize,
    },
    /// A value that is not a finite number.
    #[error("point {point} of the table has {column} {value}, but it must be a finite number")]
    NotFinite {
        /// Column.
        column: &'static str,
        /// Point, counted from 1.
        point: usize,
        /// The value found.
        value: f64,
    },
    /// An angle that is not beyond the one before.
    #[error(
        "point {point} of the table is at {angle_rad} rad, not beyond the {before_rad} rad of the point before; \
         order the points by rising angle, one for each"
    )]
    NotRising {
        /// Point, counted from 1.
        point: usize,
        /// Angle of the point before, rad.
        before_rad: f64,
        /// Its angle, rad.
        angle_rad: f64,
    },
    /// A period into which the points do not fit.
    #[error(
        "the table's period_rad is {period_rad}, but its points lie over {span_rad} rad; \
         the period must be at least that"
    )]
    Period {
        /// The period given, rad.
        period_rad: f64,
        /// Angle from the first point to the last, rad.
        span_rad: f64,
    },
    /// A jump where the table begins again.
    #[error(
        "the table does not repeat: it ends on {last_mnm} mNm and begins again with {first_mnm} mNm, a jump of \
         {jump_mnm:.6} mNm where {allowed_mnm:.6} mNm is allowed; end it on the first torque, or give period_rad \
         in a model file, larger than the angle from the first point to the last"
    )]
    NotPeriodic {
        /// Torque of the first point, mNm.
        first_mnm: f64,
        /// Torque of the last point, mNm.
        last_mnm: f64,
        /// The difference, mNm.
        jump_mnm: f64,
        /// The largest that will do, mNm.
        allowed_mnm: f64,
    },
    /// A slope too large for a floating-point number.
    #[error("the table's torque changes too steeply to be computed with; move its points apart")]
    TooSteep,
    /// A text that is no table of numbers.
    #[error(transparent)]
    Text(#[from] TableError),
}
