//! A model's torque as a table over the angle.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use dynamics::{Axis, Effect, Model, Motion, Role};

/// Angle that a table covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum TableSpan {
    /// From one detent to the next.
    Period,
    /// Once around, with springs and end stops.
    Turn,
}

/// Why a model has no such table.
#[derive(Debug, thiserror::Error)]
pub enum TabulationError {
    /// Several periods, or none.
    #[error("{0} has no detents of a single period; tabulate a turn")]
    NoPeriod(String),
    /// Friction and inertia alone.
    #[error("{0} has no torque that depends on the angle, so there is nothing to tabulate")]
    NoTorque(String),
}

/// Relative difference up to which two periods are one.
const SAME_PERIOD: f64 = 1e-9;
/// Points in which a rest and the slope there are looked for.
const FINE_POINTS: u32 = 1 << 14;

/// Travel over which a pressed control is tabulated, mm: that of a key.
const TRAVEL_MM: f64 = 4.0;

/// Torque that the knob takes at rest, over one period of its detents or a turn.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueOverAngle {
    /// Whether the control turns.
    pub(crate) axis: Axis,
    /// Angle that the table goes over, rad; it begins at zero.
    pub(crate) span_rad: f64,
    /// Whether that is one period of the detents.
    pub(crate) is_period: bool,
    /// Torques at even steps of the angle, mNm; the one at the end of the span is not repeated.
    pub(crate) torque_mnm: Vec<f64>,
    /// Names of the effects that are in it.
    pub(crate) effects: Vec<&'static str>,
    /// Where the torque holds the knob best; none where it nowhere does.
    pub(crate) rest: Option<Rest>,
}

/// A place where the torque holds the knob.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rest {
    /// Where it is, rad.
    pub(crate) angle_rad: f64,
    /// Slope of the torque there, mNm/rad.
    pub(crate) stiffness_mnm_rad: f64,
}

impl TorqueOverAngle {
    /// Tabulates a model at so many points; without a span over one period of its detents, or a turn.
    ///
    /// # Errors
    /// For a model without a torque of the angle, or without the period asked for.
    pub fn of(model: &Model, points: u32, over: Option<TableSpan>) -> Result<Self, TabulationError> {
        let period_rad = period_rad(model);
        let span_rad = match over {
            Some(TableSpan::Turn) => TAU,
            Some(TableSpan::Period) => period_rad.ok_or_else(|| TabulationError::NoPeriod(model.name.clone()))?,
            None if !model.axis.is_rotary() => TRAVEL_MM,
            None => period_rad.unwrap_or(TAU),
        };
        let is_period = over != Some(TableSpan::Turn) && period_rad.is_some() && model.axis.is_rotary();
        // A spring or a stop does not repeat with the detents.
        let taken = |effect: &&Effect| {
            effect.kind().steepest_mnm_rad.is_some() && (!is_period || effect.kind().role == Role::Detents)
        };
        let effects: Vec<&Effect> = model.effects.iter().filter(taken).collect();
        if effects.is_empty() {
            return Err(TabulationError::NoTorque(model.name.clone()));
        }
        let torque_mnm = |angle_rad: f64| -> f64 {
            let motion = Motion { angle_rad, ..Motion::default() };
            effects.iter().map(|effect| effect.free_torque_mnm(&motion)).sum()
        };
        let at = |index: u32, points: u32| span_rad * f64::from(index) / f64::from(points);
        let fine: Vec<f64> = (0..=FINE_POINTS).map(|index| torque_mnm(at(index, FINE_POINTS))).collect();
        let step_rad = span_rad / f64::from(FINE_POINTS);
        let rests = (0_u32..).zip(fine.windows(2)).filter(|(_, pair)| pair[0] <= 0.0 && pair[1] > 0.0);
        let rests = rests.map(|(index, pair)| Rest {
            angle_rad: at(index, FINE_POINTS) - step_rad * pair[0] / (pair[1] - pair[0]),
            stiffness_mnm_rad: (pair[1] - pair[0]) / step_rad,
        });
        Ok(Self {
            axis: model.axis,
            span_rad,
            is_period,
            torque_mnm: (0..points).map(|index| torque_mnm(at(index, points))).collect(),
            effects: effects.iter().map(|effect| effect.kind().name).collect(),
            rest: rests.max_by(|a, b| a.stiffness_mnm_rad.total_cmp(&b.stiffness_mnm_rad)),
        })
    }

    /// Two columns; over a period the last point repeats the first, as `compose --detents` reads it.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut text = self.axis.words("angle_rad,torque_mnm\n").into_owned();
        let points = self.torque_mnm.len();
        let repeated = usize::from(self.is_period);
        for index in 0..points + repeated {
            let angle_rad = self.span_rad * index as f64 / points as f64;
            let _ = writeln!(text, "{angle_rad},{}", self.torque_mnm[index % points]);
        }
        text
    }

    /// What it covers, for an operator.
    #[must_use]
    pub fn in_words(&self) -> String {
        let over = match self.axis {
            Axis::Linear => "its travel",
            Axis::Rotary if self.is_period => "one period of the detents",
            Axis::Rotary => "one turn",
        };
        let (points, span_rad) = (self.torque_mnm.len(), self.span_rad);
        let span = self.axis.words(&format!("{span_rad:.6} rad")).into_owned();
        format!("{} at {points} points over {over}, {span}", self.effects.join(" + "))
    }
}

/// The angle after which the detents repeat, rad; `None` without detents and with several periods.
fn period_rad(model: &Model) -> Option<f64> {
    let detents = model.effects.iter().filter(|effect| effect.kind().role == Role::Detents);
    let periods: Option<Vec<f64>> = detents.map(effect_period_rad).collect();
    let periods = periods?;
    let first = *periods.first()?;
    periods.iter().all(|period| (period / first - 1.0).abs() < SAME_PERIOD).then_some(first)
}

fn effect_period_rad(effect: &Effect) -> Option<f64> {
    if let Some(table) = effect.table() {
        return table.period_rad();
    }
    // Detents are written as functions of θ/P.
    effect.parameters().find(|(kind, _)| kind.name.ends_with("_period")).map(|(_, value)| TAU * value)
}
