//! Kinds of effects, each known to the whole program: names, parameters and law.

use crate::{Bristles, Coupling, Curve, Effect, Hypothesis, Motion, Role, Search, TorqueTable};

/// Most parameters that one effect has.
pub const MAX_PARAMETERS: usize = 24;

/// A physical effect as the instrument knows it.
#[derive(Debug)]
pub struct EffectKind {
    /// Standard name, as used in model files and reports.
    pub name: &'static str,
    /// One line that says what the knob does.
    pub description: &'static str,
    /// Where the law comes from.
    pub source: &'static str,
    /// The part to which it belongs when a knob is composed of parts of others.
    pub role: Role,
    /// What its torque, reading or factor depends on, the main one first; the direction of sliding apart.
    pub depends_on: &'static [Coordinate],
    /// The parameters in the order of an effect's values.
    pub parameters: &'static [ParameterKind],
    /// The part it plays in the equation of motion.
    pub part: Part,
    /// Steepest slope |dτ/dθ| over all angles, mNm/rad; `None` for an effect that is no torque of the angle.
    pub steepest_mnm_rad: Option<fn(&Effect) -> f64>,
    /// The part it plays in a fit of torque to motion; `None` if it has none there.
    pub regressors: Option<Regressors>,
    /// How to look for it in a capture whose model lacks it; `None` if that is never done.
    pub hypothesis: Option<Hypothesis>,
}

impl EffectKind {
    /// Whether it depends on nothing but `coordinate`.
    #[must_use]
    pub fn depends_only_on(&self, coordinate: Coordinate) -> bool {
        self.depends_on == [coordinate]
    }

    /// Whether its torque is part of the load on the friction: the torque of inertia, detents and springs.
    #[must_use]
    pub fn is_of_the_load(&self) -> bool {
        match self.part {
            Part::Inertia(_) | Part::VaryingInertia(_) => true,
            Part::Torque(_) | Part::TorqueTable(_) => !self.depends_only_on(Coordinate::Velocity),
            _ => false,
        }
    }

    /// How many times its law may occur in one effect.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.hypothesis.map_or(1, |hypothesis| hypothesis.lines)
    }

    /// Number of parameters with which its law occurs once.
    #[must_use]
    pub fn parameters_of_a_line(&self) -> usize {
        self.parameters.len() / self.lines()
    }

    /// Number of columns with which its law occurs once in a fit.
    #[must_use]
    pub fn columns_of_a_line(&self) -> usize {
        self.regressors.map_or(0, |regressors| regressors.columns / self.lines())
    }

    /// Name of the parameter that a column's coefficient is, or else of the effect.
    #[must_use]
    pub fn column_name(&self, column: usize) -> &'static str {
        let is_parameter = self.regressors.is_some_and(|regressors| regressors.columns == self.parameters.len());
        if is_parameter { self.parameters[column].name } else { self.name }
    }

    /// Whether a column's coefficient cannot be negative, by the law or because it is a parameter that cannot be negative.
    #[must_use]
    pub fn is_nonnegative(&self, column: usize) -> bool {
        self.regressors.is_some_and(|regressors| {
            let is_parameter = regressors.searched.is_empty() && regressors.columns == self.parameters.len();
            regressors.nonnegative.contains(&column) || is_parameter && self.parameters[column].minimum != Minimum::None
        })
    }

    /// Number of leading parameters that the first `columns` columns have.
    #[must_use]
    pub fn parameters_in(&self, columns: usize) -> usize {
        let all = self.parameters.len();
        match self.regressors {
            None => all,
            Some(regressors) if self.lines() == 1 => all - (regressors.columns - columns),
            Some(_) => self.parameters_of_a_line() * (columns / self.columns_of_a_line()),
        }
    }

    /// The searches for its parameters; none without a hypothesis.
    #[must_use]
    pub fn searches(&self) -> &'static [Search] {
        self.hypothesis.map_or(&[], |hypothesis| hypothesis.searched)
    }
}

/// A quantity on which an effect may depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Angle of the knob.
    Angle,
    /// Velocity of the knob.
    Velocity,
    /// Acceleration of the knob.
    Acceleration,
    /// Time since the start of the capture.
    Time,
    /// Torque on the knob, now or before.
    Load,
}

/// A parameter of an effect.
#[derive(Debug)]
pub struct ParameterKind {
    /// Name, unique over all effects: the key in model files and in JSON.
    pub name: &'static str,
    /// Unit, as printed.
    pub unit: &'static str,
    /// Symbol in the equations.
    pub symbol: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Smallest value that means something.
    pub minimum: Minimum,
}

/// A unit as people are told it: nothing where it is 1.
#[must_use]
pub fn printed_unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// A unit as it follows a number in a sentence.
#[must_use]
pub fn spaced_unit(unit: &str) -> String {
    match printed_unit(unit) {
        "" => String::new(),
        unit => format!(" {unit}"),
    }
}

/// A parameter's lower bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Minimum {
    /// Any finite number.
    None,
    /// Zero or more.
    Zero,
    /// Zero or more; zero where a file leaves it out.
    ZeroOrAbsent,
    /// More than zero.
    AboveZero,
    /// More than zero and less than one.
    ShareOfOne,
}

impl Minimum {
    /// Whether `value` is permitted; a value that is not finite never is.
    #[must_use]
    pub fn permits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::None => true,
                Self::Zero | Self::ZeroOrAbsent => value >= 0.0,
                Self::AboveZero => value > 0.0,
                Self::ShareOfOne => value > 0.0 && value < 1.0,
            }
    }

    /// What a value must be, for a sentence.
    #[must_use]
    pub fn requirement(self) -> &'static str {
        match self {
            Self::None => "a finite number",
            Self::Zero | Self::ZeroOrAbsent => "zero or more, and finite",
            Self::AboveZero => "more than zero, and finite",
            Self::ShareOfOne => "more than zero and less than one",
        }
    }
}

/// Direction in which the knob slides, or is about to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Towards smaller angles.
    Negative,
    /// Towards larger angles.
    Positive,
}

impl Direction {
    /// Direction of a velocity or torque; zero counts as positive.
    #[must_use]
    pub fn of(value: f64) -> Self {
        if value < 0.0 { Self::Negative } else { Self::Positive }
    }

    /// −1 or +1.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Negative => -1.0,
            Self::Positive => 1.0,
        }
    }
}

/// The torques up to which a resting knob holds, and the speed below which it can come to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StickLimits {
    /// Magnitude of the torque that a knob at rest bears in the negative direction, mNm.
    pub negative_mnm: f64,
    /// Torque that a knob at rest bears in the positive direction, mNm.
    pub positive_mnm: f64,
    /// Speed below which the knob sticks, rad/s.
    pub velocity_rad_s: f64,
}

/// The part that an effect plays in the equation of motion.
///
/// The functions take the effect's values in the order of its kind's parameters.
#[derive(Clone, Copy, Debug)]
pub enum Part {
    /// Adds to the mass matrix; gives the inertia, mNm·s²/rad.
    Inertia(fn(&[f64]) -> f64),
    /// Adds an inertia that depends on the angle; gives this inertia, mNm·s²/rad, and its slope, mNm·s²/rad².
    VaryingInertia(fn(&[f64], f64) -> [f64; 2]),
    /// A torque that depends on angle, velocity and time but not on the direction of sliding, mNm.
    Torque(fn(&[f64], &Motion) -> f64),
    /// A torque that a table over the angle holds, times the first value.
    TorqueTable(TableUse),
    /// Friction that a table holds, over the angle or over the speed, times the first value.
    FrictionTable(TableUse),
    /// The torque of friction while sliding in the given direction, mNm: positive when sliding positively.
    Friction(fn(&[f64], &Motion, Direction) -> f64),
    /// Ratio of friction to load, the load being the torque of inertia, detents and springs.
    LoadFriction(fn(&[f64]) -> f64),
    /// What holds the knob at rest.
    Stick(fn(&[f64]) -> StickLimits),
    /// Relative change of the Coulomb friction: 0 leaves it as it is.
    CoulombFactor(fn(&[f64], &Motion) -> f64),
    /// Relative change of all friction, Coulomb and viscous.
    FrictionFactor(fn(&[f64], &Motion) -> f64),
    /// Friction's contacts bend before they slip.
    Bristles(fn(&[f64]) -> Bristles),
    /// What lies between the torque sensor and the body that friction and detents act on.
    Coupling(fn(&[f64]) -> Coupling),
    /// What the torque sensor reads besides the torque, mNm.
    Reading(fn(&[f64], &Motion) -> f64),
    /// Time by which the torque sensor's reading is late, s.
    ReadingDelay(fn(&[f64]) -> f64),
}

impl Part {
    /// Whether it is a factor on the friction of other effects, and no torque of its own.
    #[must_use]
    pub fn changes_friction(self) -> bool {
        matches!(self, Self::CoulombFactor(_) | Self::FrictionFactor(_))
    }
}

/// What an effect makes of its table.
#[derive(Clone, Copy, Debug)]
pub struct TableUse {
    /// What lies between the points.
    pub curve: Curve,
    /// What the points lie over: the angle, or the magnitude of the velocity.
    pub over: Coordinate,
    /// Whether a table without a period keeps its ends' torques beyond them; otherwise its last point repeats the first.
    pub holds: bool,
}

impl TableUse {
    /// Name of the points' coordinate in model files.
    #[must_use]
    pub fn coordinate_name(&self) -> &'static str {
        if self.over == Coordinate::Velocity { "speed_rad_s" } else { "angle_rad" }
    }

    /// Torque of a table at a motion, mNm; for friction its magnitude.
    #[must_use]
    pub fn torque_mnm(&self, table: &TorqueTable, motion: &Motion) -> f64 {
        table.torque_mnm(if self.over == Coordinate::Velocity { motion.velocity_rad_s.abs() } else { motion.angle_rad })
    }
}

/// An effect's columns in a fit: torque = Σ coefficient · column.
///
/// The coefficients are linear; parameters on which the columns themselves depend are searched.
#[derive(Clone, Copy, Debug)]
pub struct Regressors {
    /// Number of columns.
    pub columns: usize,
    /// Indices of the parameters that must be searched because columns depend on them.
    pub searched: &'static [usize],
    /// Writes the columns for one motion. A law of several orders or lines writes only as many of the first ones as the slice has
    /// room for. It reads the searched values of the effect; an end stop reads its coefficients too, which determine where the
    /// contact lets go.
    pub fill: fn(&Effect, &Motion, &mut [f64]),
    /// Writes the effect's values from the fitted coefficients; the searched ones are already in place.
    pub values: fn(&[f64], &mut [f64]),
    /// Columns whose coefficient cannot be negative, besides those whose parameter says so: see [`EffectKind::is_nonnegative`].
    pub nonnegative: &'static [usize],
}

impl Regressors {
    /// The regressors of an effect whose only parameter is the scale of its table.
    pub(crate) const OF_TABLE: Self = Self {
        columns: 1,
        searched: &[],
        fill: Effect::table_column,
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    };
}
