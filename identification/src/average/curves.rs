//! Torques that several captures measured point by point, made into one curve.

use dynamics::{Effect, Model, Motion, TorqueTable, effects};

use super::scalar::{Estimated, combined};
use crate::estimate::Fit;
use crate::numerics::statistics::interval;
use crate::regression::characteristic::{CharacteristicPoint, MeasuredCurve, Spline};

/// The mean of each measured curve with the effect through its points; a capture takes part where its own points show the torque.
pub(super) fn mean(fits: &[Fit]) -> Vec<(MeasuredCurve, Effect)> {
    let kinds = [&effects::angle_characteristic::KIND, &effects::friction_characteristic::KIND];
    let of_kind = |kind: &&'static dynamics::EffectKind| {
        let measured: Vec<Branch<'_>> = fits.iter().filter_map(|fit| Branch::of(fit, kind.name)).collect();
        // Where a capture passed both ways and its fit has no friction over the angle, it showed none.
        let even = if measured.is_empty() { 0 } else { fits.iter().filter(|fit| is_even(fit, kind.name)).count() };
        let points: Vec<CharacteristicPoint> =
            places(&measured)?.into_iter().map(|at| point(&measured, even, at)).collect();
        let (at, torque_mnm): (Vec<f64>, Vec<f64>) = points.iter().map(|point| (point.at, point.torque_mnm)).unzip();
        let effect = Spline::through(kind, at, None)?.effect(&torque_mnm)?;
        Some((MeasuredCurve { effect: kind.name, points }, effect))
    };
    kinds.iter().filter_map(of_kind).collect()
}

/// The mean of what quasi-static maps hold over the angle beyond their detent; `None` where none holds any. Of a map with a detent
/// alone it is zero.
pub(super) fn beyond_detents(fits: &[Fit]) -> Option<Effect> {
    let kind = &effects::angle_characteristic::KIND;
    let is_map = |fit: &&Fit| {
        fit.preparation.method == "quasi-static" && fit.characteristics.is_empty() && !fit.detent_harmonics.is_empty()
    };
    let maps: Vec<&Fit> = fits.iter().filter(is_map).collect();
    let table = |fit: &&Fit| fit.effects.iter().find(|effect| effect.kind().name == kind.name)?.table();
    let tables: Vec<&TorqueTable> = maps.iter().filter_map(table).collect();
    // One that repeats after a turn has a torque at every angle.
    let finest = tables.iter().max_by_key(|table| (table.period_rad().is_some(), table.points().len()))?;
    let zeros = (maps.len() - tables.len()) as f64;
    let mean_mnm = |at: &f64| {
        let shows = |table: &&&TorqueTable| {
            let points = table.points();
            table.period_rad().is_some() || points.first() <= Some(at) && Some(at) <= points.last()
        };
        let shown = tables.iter().filter(shows).map(|table| table.torque_mnm(*at));
        let (sum, count) = shown.fold((0.0, zeros), |(sum, count), torque_mnm| (sum + torque_mnm, count + 1.0));
        sum / count
    };
    let mut places = finest.points().to_vec();
    if finest.period_rad().is_none() {
        let (first, last) = (*places.first()?, *places.last()?);
        // Where a map begins or ends the mean jumps: points close together there would make the spline swing.
        let least_rad = 0.5 * (last - first) / (places.len() - 1).max(1) as f64;
        let is_beyond = |at: &&f64| **at < first - least_rad || **at > last + least_rad;
        places.extend(tables.iter().flat_map(|table| table.points()).filter(is_beyond));
        places.sort_by(f64::total_cmp);
        places.dedup_by(|next, before| *next - *before < least_rad);
    }
    let torque_mnm: Vec<f64> = places.iter().map(mean_mnm).collect();
    Spline::through(kind, places, finest.period_rad())?.effect(&torque_mnm)
}

/// A capture's curve and the model that interpolates it.
struct Branch<'a> {
    curve: &'a MeasuredCurve,
    spline: Model,
}

impl<'a> Branch<'a> {
    fn of(fit: &'a Fit, name: &str) -> Option<Self> {
        let curve = fit.characteristics.iter().find(|curve| curve.effect == name)?;
        let effect = fit.effects.iter().find(|effect| effect.kind().name == name)?;
        Some(Self { curve, spline: Model { effects: vec![*effect], ..Model::default() } })
    }

    /// The torque at an angle, of a friction that of the positive direction; `None` where the capture hardly shows it.
    fn estimate(&self, at: f64) -> Option<(f64, f64)> {
        let half_width = self.curve.half_width(at)?;
        let motion = Motion { angle_rad: at, velocity_rad_s: 1.0, ..Motion::default() };
        Some((self.spline.torque_mnm(&motion), half_width))
    }
}

/// Whether a fit that measured its curves found friction in both directions and no variation of it over the angle.
fn is_even(fit: &Fit, name: &str) -> bool {
    let known = |name: &str| fit.parameters.get(name).is_some_and(|known| known.value.is_some());
    name == effects::friction_characteristic::KIND.name
        && !fit.characteristics.is_empty()
        && fit.characteristics.iter().all(|curve| curve.effect != name)
        && known("coulomb_negative")
        && known("coulomb_positive")
}

/// The places of the capture with the most points, and those of others beyond them, in rising order; `None` without a capture.
fn places(measured: &[Branch<'_>]) -> Option<Vec<f64>> {
    let places = |branch: &Branch<'_>| branch.curve.points.iter().map(|point| point.at).collect::<Vec<f64>>();
    let mut all = places(measured.iter().max_by_key(|branch| branch.curve.points.len())?);
    let (first, last) = (*all.first()?, *all.last()?);
    all.extend(measured.iter().flat_map(places).filter(|at| *at < first || *at > last));
    all.sort_by(f64::total_cmp);
    all.dedup();
    Some(all)
}

/// The mean at one place, with `even` captures that show no torque there; zero without an interval where no capture shows it.
fn point(measured: &[Branch<'_>], even: usize, at: f64) -> CharacteristicPoint {
    let mut estimates: Vec<(f64, f64)> = measured.iter().filter_map(|branch| branch.estimate(at)).collect();
    if estimates.is_empty() {
        return CharacteristicPoint { at, torque_mnm: 0.0, ci95: None };
    }
    estimates.extend(std::iter::repeat_n((0.0, 0.0), even));
    let Estimated { value, half_width } = combined(&estimates);
    CharacteristicPoint { at, torque_mnm: value, ci95: Some(interval(value, half_width)) }
}
