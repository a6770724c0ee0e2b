//! One sheet of one curve, or of several of the same part.

use std::collections::BTreeMap;

use archive::testers::Curve;
use identification::statistics::student_95;
use serde::Serialize;
use shared_types::Axis;

use crate::branch::Branch;
use crate::figure::{Estimate, Figure, kinds};
use crate::noise::mean_and_deviation;
use crate::pressed;

/// The data sheet of a part.
#[derive(Clone, Debug, Serialize)]
pub struct Sheet {
    /// Turned or pressed.
    pub axis: Axis,
    /// Curves that it was made of.
    pub runs: usize,
    /// Its figures by name.
    pub figures: BTreeMap<&'static str, Figure>,
    /// Load over position, one branch a direction.
    pub curve: BTreeMap<&'static str, Branch>,
}

/// Why there is no sheet.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SheetError {
    /// No curves.
    #[error("there is no curve to make a sheet of")]
    NoCurve,
    /// Turned and pressed controls together.
    #[error("some of the captures are of a turned control and some of a pressed one; give those of one part")]
    TwoAxes,
    /// A curve has next to no press.
    #[error("there is hardly any press in it: the travel is largest within 0.2 mm of its first row")]
    NoPress,
}

/// What one curve tells.
pub(crate) struct Run {
    pub(crate) figures: BTreeMap<&'static str, Result<Estimate, String>>,
    pub(crate) branches: Vec<(&'static str, Branch)>,
}

impl Sheet {
    /// Of one curve, or of several of one part: each is read by itself, and the figures are their means, as testers do.
    ///
    /// # Errors
    /// [`SheetError`] for curves that make no sheet.
    pub fn of(curves: &[Curve]) -> Result<Self, SheetError> {
        let axis = curves.first().ok_or(SheetError::NoCurve)?.axis;
        if curves.iter().any(|curve| curve.axis != axis) {
            return Err(SheetError::TwoAxes);
        }
        let runs: Vec<Run> = curves.iter().map(read).collect::<Result<_, _>>()?;
        let figures = kinds().filter_map(|kind| {
            let told: Vec<&Result<Estimate, String>> =
                runs.iter().filter_map(|run| run.figures.get(kind.name)).collect();
            (!told.is_empty()).then(|| {
                let estimates: Result<Vec<Estimate>, String> = told.into_iter().cloned().collect();
                let figure = match estimates {
                    Ok(estimates) => {
                        let (estimate, freedom) = combined(&estimates);
                        Figure::told(kind, estimate, freedom)
                    }
                    Err(reason) => Figure::untold(kind, reason),
                };
                (kind.name, figure)
            })
        });
        Ok(Self { axis, runs: runs.len(), figures: figures.collect(), curve: mean_branches(&runs) })
    }
}

fn read(curve: &Curve) -> Result<Run, SheetError> {
    let pressed = pressed::read(curve)?;
    let figures = pressed.figures.into_iter().map(|(name, told)| (name, told.map_err(str::to_owned))).collect();
    Ok(Run { figures, branches: pressed.branches })
}

/// The mean of several runs, with the standard error of one more run about it, and from how many differences it is known.
#[allow(clippy::cast_precision_loss, reason = "a number of runs")]
pub(crate) fn combined(runs: &[Estimate]) -> (Estimate, f64) {
    let values: Vec<f64> = runs.iter().map(|run| run.value).collect();
    let Some((value, deviation)) = mean_and_deviation(&values) else {
        return (runs[0], f64::INFINITY);
    };
    let count = runs.len() as f64;
    (Estimate { value, standard_error: deviation * (1.0 + 1.0 / count).sqrt() }, count - 1.0)
}

/// The branches of one run, or the mean of several where all of them have been.
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

#[allow(clippy::cast_precision_loss, reason = "a number of runs")]
fn mean_branch(first: &Branch, branches: &[&Branch]) -> Branch {
    let count = branches.len() as f64;
    let at = |position: f64| branches.iter().map(|branch| branch.load_at(position)).collect::<Option<Vec<f64>>>();
    let common: Vec<(f64, Vec<f64>)> =
        first.positions().filter_map(|position| Some((position, at(position)?))).collect();
    let half = student_95(count - 1.0) * (1.0 + 1.0 / count).sqrt();
    let told: Vec<(f64, f64)> =
        common.iter().filter_map(|(_, loads)| mean_and_deviation(loads)).map(|(mean, sd)| (mean, half * sd)).collect();
    Branch {
        first: common.first().map_or(first.first, |(position, _)| *position),
        load: told.iter().map(|(mean, _)| *mean).collect(),
        load_ci95_half_width: told.iter().map(|(_, half)| *half).collect(),
        ..first.clone()
    }
}
