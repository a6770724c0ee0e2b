//! One sheet of one curve, or of several of the same part.

use std::collections::BTreeMap;
use std::path::PathBuf;

use archive::testers::Curve;
use identification::statistics::student_95;
use serde::Serialize;
use shared_types::Axis;

use crate::branch::Branch;
use crate::figure::{Estimate, Figure, FigureKind, Spread};
use crate::noise::mean_and_deviation;
use crate::rotary::TurnedDetent;
use crate::{dynamic, pressed, rotary};

/// The data sheet of a part.
#[derive(Clone, Debug, Serialize)]
pub struct Sheet {
    /// Turned or pressed.
    pub axis: Axis,
    /// Curves that it was made of, or presses where a curve has several.
    pub runs: usize,
    /// Its figures by name.
    pub figures: BTreeMap<&'static str, Figure>,
    /// Each detent in each direction, in the order of the angle; empty for what has none.
    pub detents: Vec<Detent>,
    /// What each press by itself tells, by the names of the figures; empty for what is turned.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub presses: Vec<BTreeMap<&'static str, DetentFigure>>,
    /// Load over position, one branch a direction.
    pub curve: BTreeMap<&'static str, Branch>,
}

/// A detent in one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Detent {
    /// Where it rests, rad.
    pub angle_rad: f64,
    /// Its 95 % interval, rad.
    pub angle_rad_ci95: [f64; 2],
    /// `positive` or `negative`: the way in which it is left.
    pub direction: &'static str,
    /// What it takes, by the names of the figures.
    #[serde(flatten)]
    pub figures: BTreeMap<&'static str, DetentFigure>,
}

/// A figure of one detent in one direction, or of one press.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DetentFigure {
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

/// Why there is no sheet.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SheetError {
    /// No curves.
    #[error("there is no curve")]
    NoCurve,
    /// Turned and pressed controls together.
    #[error("some captures are of a rotary control and some of a linear one; give captures of one part")]
    TwoAxes,
    /// A curve that no figure can be read off.
    #[error("{}: {error}", path.display())]
    Curve {
        /// The curve's file.
        path: PathBuf,
        /// What is wrong with it.
        error: CurveError,
    },
}

/// Why no figure can be read off a curve.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// A curve has next to no press.
    #[error("it has almost no press: the travel never exceeds that of its first row by 0.2 mm")]
    NoPress,
    /// A travel that no control has.
    #[error(
        "its travel spans {travel_mm:.3e} mm, which no control has; check its unit, or take out rows without a reading"
    )]
    TooFar {
        /// The travel, mm.
        travel_mm: f64,
    },
    /// A control was turned too fast for static figures.
    #[error(
        "the control was turned at {speed_rad_s:.1} rad/s, too fast for static figures; capture the sweep `slow-turn`"
    )]
    TooFast {
        /// Speed that a tenth of the rows pass, rad/s.
        speed_rad_s: f64,
    },
    /// A control was turned one way only.
    #[error("no angle was passed in both directions; turn the control there and back, as the sweep `slow-turn` does")]
    OneWay,
}

/// What one curve tells.
pub(crate) struct Run {
    pub(crate) figures: BTreeMap<&'static str, Result<Estimate, String>>,
    pub(crate) detents: Vec<TurnedDetent>,
    pub(crate) branches: Vec<(&'static str, Branch)>,
}

impl Run {
    /// What a press by itself tells.
    fn by_itself(&self) -> BTreeMap<&'static str, DetentFigure> {
        let estimated = |kind: &&'static FigureKind| {
            let estimate = *self.figures.get(kind.name)?.as_ref().ok()?;
            let Figure { value, ci95, .. } = Figure::estimated(kind, estimate, f64::INFINITY);
            Some((kind.name, DetentFigure { value: value?, unit: kind.unit, ci95: ci95? }))
        };
        pressed::KINDS.iter().filter_map(estimated).collect()
    }
}

impl Sheet {
    /// The sheet of one curve, or of several curves of one part. Figures are read off each curve, and off each press in it,
    /// separately; the sheet has their means, as testers do.
    ///
    /// # Errors
    /// [`SheetError`] for curves that make no sheet.
    pub fn of(curves: &[Curve]) -> Result<Self, SheetError> {
        let axis = curves.first().ok_or(SheetError::NoCurve)?.axis;
        if curves.iter().any(|curve| curve.axis != axis) {
            return Err(SheetError::TwoAxes);
        }
        let runs: Vec<Run> = curves.iter().map(read).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        let detents = common_detents(&runs);
        let mut figures = BTreeMap::new();
        for kind in kinds_of(axis) {
            let estimates = runs.iter().filter_map(|run| run.figures.get(kind.name)).cloned();
            let figure = match estimates.collect::<Result<Vec<Estimate>, String>>() {
                Ok(estimates) => {
                    let (estimate, freedom) = combined(&estimates);
                    Figure { over: spread(&detents, kind.name), ..Figure::estimated(kind, estimate, freedom) }
                }
                Err(reason) => Figure::undetermined(kind, reason),
            };
            figures.insert(kind.name, figure);
        }
        let presses = if axis.is_rotary() { Vec::new() } else { runs.iter().map(Run::by_itself).collect() };
        Ok(Self { axis, runs: runs.len(), figures, detents, presses, curve: mean_branches(&runs) })
    }

    /// Its figures in the order of the sheet, the static ones first.
    pub fn in_order(&self) -> impl Iterator<Item = &Figure> {
        let kinds = kinds_of(self.axis).iter().chain(dynamic::kinds_of(self.axis));
        kinds.filter_map(|kind| self.figure(kind))
    }

    /// The figure of that kind; `None` for one of the other axis.
    #[must_use]
    pub fn figure(&self, kind: &FigureKind) -> Option<&Figure> {
        self.figures.get(kind.name).filter(|figure| std::ptr::eq(figure.kind, kind))
    }
}

/// The figures of an axis, in the order of the sheet.
#[must_use]
pub fn kinds_of(axis: Axis) -> &'static [&'static FigureKind] {
    match axis {
        Axis::Rotary => rotary::KINDS,
        Axis::Linear => pressed::KINDS,
    }
}

fn read(curve: &Curve) -> Result<Vec<Run>, SheetError> {
    let of_press = |pressed: pressed::Pressed| Run {
        figures: pressed.figures.into_iter().map(|(name, figure)| (name, figure.map_err(str::to_owned))).collect(),
        detents: Vec::new(),
        branches: pressed.branches,
    };
    let runs = match curve.axis {
        Axis::Rotary => rotary::read(curve)
            .map(|turned| vec![Run { figures: turned.figures, detents: turned.detents, branches: turned.branches }]),
        Axis::Linear => pressed::read(curve).map(|presses| presses.into_iter().map(of_press).collect()),
    };
    runs.map_err(|error| SheetError::Curve { path: curve.source.clone(), error })
}

/// Detents that every run shows, each the mean of them.
fn common_detents(runs: &[Run]) -> Vec<Detent> {
    let Some((first, others)) = runs.split_first() else { return Vec::new() };
    let near = |detent: &TurnedDetent, run: &Run| {
        let same = run.detents.iter().filter(|other| other.direction == detent.direction);
        let pitch = detent.figures.first().map_or(0.0, |(_, pitch)| pitch.value);
        same.min_by(|a, b| {
            (a.angle.value - detent.angle.value).abs().total_cmp(&(b.angle.value - detent.angle.value).abs())
        })
        .filter(|other| (other.angle.value - detent.angle.value).abs() < 0.5 * pitch)
        .cloned()
    };
    let mut detents: Vec<Detent> = first
        .detents
        .iter()
        .filter_map(|detent| {
            let mut all = vec![detent.clone()];
            for run in others {
                all.push(near(detent, run)?);
            }
            Some(mean_detent(&all))
        })
        .collect();
    detents.sort_by(|a, b| b.direction.cmp(a.direction).then(a.angle_rad.total_cmp(&b.angle_rad)));
    detents
}

fn mean_detent(runs: &[TurnedDetent]) -> Detent {
    let interval = |estimates: Vec<Estimate>| {
        let (Estimate { value, standard_error }, freedom) = combined(&estimates);
        let half = student_95(freedom) * standard_error;
        (value, [value - half, value + half])
    };
    let (angle_rad, angle_rad_ci95) = interval(runs.iter().map(|run| run.angle).collect());
    let figures = runs[0].figures.iter().enumerate().map(|(index, (kind, _))| {
        let (value, ci95) = interval(runs.iter().map(|run| run.figures[index].1).collect());
        (kind.name, DetentFigure { value, unit: kind.unit, ci95 })
    });
    Detent { angle_rad, angle_rad_ci95, direction: runs[0].direction, figures: figures.collect() }
}

/// How a figure differs from detent to detent; `None` for one that detents do not have.
fn spread(detents: &[Detent], name: &str) -> Option<Spread> {
    let values: Vec<f64> =
        detents.iter().filter_map(|detent| detent.figures.get(name)).map(|figure| figure.value).collect();
    let (mean, spread) = mean_and_deviation(&values)?;
    let worst = values.iter().copied().max_by(|a, b| (a - mean).abs().total_cmp(&(b - mean).abs()))?;
    Some(Spread { spread, worst, number: values.len() })
}

/// The mean of several runs with the standard error with which it predicts one more run, and the degrees of freedom. That error is at
/// least the RMS of the runs' own standard errors: runs may agree by chance, or because all are read in equal steps.
pub(crate) fn combined(runs: &[Estimate]) -> (Estimate, f64) {
    let values: Vec<f64> = runs.iter().map(|run| run.value).collect();
    let Some((value, deviation)) = mean_and_deviation(&values) else {
        return (runs[0], f64::INFINITY);
    };
    let count = runs.len() as f64;
    let own = runs.iter().map(|run| run.standard_error.powi(2)).sum::<f64>() / count;
    let standard_error = (deviation * (1.0 + 1.0 / count).sqrt()).max(own.sqrt());
    (Estimate { value, standard_error }, count - 1.0)
}

/// The branches of one run, or the mean of several runs at the positions that all of them cover.
fn mean_branches(runs: &[Run]) -> BTreeMap<&'static str, Branch> {
    let Some(first) = runs.first() else { return BTreeMap::new() };
    let means = first.branches.iter().map(|(name, branch)| {
        let others: Vec<&Branch> = runs
            .iter()
            .filter_map(|run| run.branches.iter().find(|(other, _)| other == name).map(|(_, branch)| branch))
            .collect();
        (*name, if others.len() < 2 { branch.clone() } else { mean_branch(branch, &others) })
    });
    means.collect()
}

fn mean_branch(first: &Branch, branches: &[&Branch]) -> Branch {
    let count = branches.len() as f64;
    let at = |position: f64| branches.iter().map(|branch| branch.load_at(position)).collect::<Option<Vec<f64>>>();
    let common: Vec<(f64, Vec<f64>)> =
        first.positions().filter_map(|position| Some((position, at(position)?))).collect();
    let half = student_95(count - 1.0) * (1.0 + 1.0 / count).sqrt();
    let means: Vec<(f64, f64)> =
        common.iter().filter_map(|(_, loads)| mean_and_deviation(loads)).map(|(mean, sd)| (mean, half * sd)).collect();
    Branch {
        first: common.first().map_or(first.first, |(position, _)| *position),
        load: means.iter().map(|(mean, _)| *mean).collect(),
        load_ci95_half_width: means.iter().map(|(_, half)| *half).collect(),
        ..first.clone()
    }
}
