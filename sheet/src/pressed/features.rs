//! Where the features of a press lie, and what its figures are.

use shared_types::Quantity;

use super::figures::{
    ACTUATION_FORCE, ACTUATION_TRAVEL, BOTTOM_OUT_STIFFNESS, COLLAPSE_FORCE, COLLAPSE_TRAVEL, CONTACT_CLOSING_FORCE,
    CONTACT_CLOSING_TRAVEL, CONTACT_HYSTERESIS, CONTACT_OPENING_FORCE, CONTACT_OPENING_TRAVEL, FORCE_DROP,
    FORCE_DROP_RATIO, HYSTERESIS_ENERGY, RELEASE_FORCE, RETURN_ENERGY, RETURN_FORCE, SNAP, TOTAL_ENERGY, TRAVEL,
    VALLEY_FORCE, VALLEY_TRAVEL,
};
use super::stroke::{STEP_MM, Stroke, smoothed};
use crate::branch::Branch;
use crate::figure::FigureKind;

/// Rows on either side among which a maximum must be the largest value.
const NEIGHBOURS: usize = 5;
/// Part of the press in which the collapse lies.
const COLLAPSE_WITHIN: f64 = 0.75;
/// Drop from which a maximum is a collapse, gf.
const LEAST_DROP_GF: f64 = 2.0;
/// Way after the collapse in which the valley lies, mm.
const VALLEY_WITHIN_MM: f64 = 1.6;
/// Rise from which on the control has bottomed out, gf/mm.
const BOTTOM_OUT_GF_MM: f64 = 300.0;

const NO_COLLAPSE: &str = "the force never falls by more than 2 gf on the press: there is no collapse";
const NO_BOTTOM: &str = "the press ends before the force rises by 300 gf/mm: there is no bottom-out";
const NO_ACTUATION: &str = "there is neither a contact that closes nor a collapse on the press";
const NO_RETURN: &str = "the control was not released";

type Value = Result<f64, &'static str>;

/// Every figure of a stroke but the contact's bounce.
pub(super) fn features(stroke: &Stroke) -> Vec<(&'static FigureKind, Value)> {
    let press = &stroke.press;
    let smooth = smoothed(&press.load);
    let collapse = collapse(&smooth);
    let valley = collapse.map(|at| valley(&smooth, at));
    let bottom = bottom_out(&smooth, valley.unwrap_or(smooth.len() / 2));
    let at = |index: Option<usize>, reason| index.map(|index| press.position(index)).ok_or(reason);
    let force = |index: Option<usize>, reason| index.map(|index| smooth[index]).ok_or(reason);

    let [closes_mm, opens_mm] = [&stroke.closing, &stroke.opening]
        .map(|change| change.as_ref().map(|change| change.travel_mm).map_err(|reason| *reason));
    let closes = closes_mm.ok().and_then(|travel| index_of(press, travel));
    let actuation = closes.or(collapse);
    let release = actuation.and_then(|actuation| lowest(&smooth, collapse.unwrap_or(actuation), bottom?));
    let actuation_force = force(actuation, NO_ACTUATION);
    let release_force = force(release, if actuation.is_none() { NO_ACTUATION } else { NO_BOTTOM });
    let force_drop = actuation_force.and_then(|actuation| Ok(actuation - release_force?));
    let back = stroke.back.as_ref().map(|back| back_figures(back, press, actuation, bottom));
    let [return_force, return_energy] = back.unwrap_or([Err(NO_RETURN), Err(NO_RETURN)]);
    let energy = bottom.map(|bottom| area(&press.load[..=bottom])).ok_or(NO_BOTTOM);
    let opening_force = opens_mm.and_then(|travel| {
        let back = stroke.back.as_ref().ok_or(NO_RETURN)?;
        Ok(smoothed(&back.load)[index_of(back, travel).ok_or(NO_RETURN)?])
    });
    let collapse_force = force(collapse, NO_COLLAPSE);
    let valley_force = force(valley, NO_COLLAPSE);
    vec![
        (&COLLAPSE_FORCE, collapse_force),
        (&COLLAPSE_TRAVEL, at(collapse, NO_COLLAPSE)),
        (&VALLEY_FORCE, valley_force),
        (&VALLEY_TRAVEL, at(valley, NO_COLLAPSE)),
        (&SNAP, collapse_force.and_then(|collapse| Ok(1.0 - valley_force? / collapse))),
        (&TRAVEL, at(bottom, NO_BOTTOM)),
        (&TOTAL_ENERGY, energy),
        (&ACTUATION_FORCE, actuation_force),
        (&ACTUATION_TRAVEL, at(actuation, NO_ACTUATION)),
        (&RELEASE_FORCE, release_force),
        (&FORCE_DROP, force_drop),
        (&FORCE_DROP_RATIO, force_drop.and_then(|drop| Ok(drop / actuation_force?))),
        (&RETURN_FORCE, return_force),
        (&RETURN_ENERGY, return_energy),
        (&HYSTERESIS_ENERGY, energy.and_then(|press| Ok(press - return_energy?))),
        (&BOTTOM_OUT_STIFFNESS, bottom.map_or(Err(NO_BOTTOM), |bottom| end_stiffness(press, &smooth, bottom))),
        (&CONTACT_CLOSING_TRAVEL, closes_mm),
        (&CONTACT_CLOSING_FORCE, closes_mm.and_then(|_| force(closes, NO_ACTUATION))),
        (&CONTACT_OPENING_TRAVEL, opens_mm),
        (&CONTACT_OPENING_FORCE, opening_force),
        (&CONTACT_HYSTERESIS, closes_mm.and_then(|closes| Ok(closes - opens_mm?))),
    ]
}

fn gram_force() -> f64 {
    Quantity::Force.factor("gf").unwrap_or(1.0)
}

/// The index of a travel; `None` beyond the ends.
fn index_of(branch: &Branch, travel_mm: f64) -> Option<usize> {
    let place = ((travel_mm - branch.first) / branch.step).round();
    (place >= 0.0 && (place as usize) < branch.len()).then_some(place as usize)
}

fn rows(way_mm: f64) -> usize {
    (way_mm / STEP_MM).round() as usize
}

/// The most prominent local maximum in the first part of the press.
fn collapse(smooth: &[f64]) -> Option<usize> {
    let end = (COLLAPSE_WITHIN * smooth.len() as f64) as usize;
    let is_maximum = |at: usize| smooth[at - NEIGHBOURS..=at + NEIGHBOURS].iter().all(|other| *other <= smooth[at]);
    let drop = |at: usize| smooth[at] - smooth[valley(smooth, at)];
    let maxima = (NEIGHBOURS..end.saturating_sub(NEIGHBOURS)).filter(|at| is_maximum(*at));
    let deepest = maxima.map(|at| (at, drop(at))).max_by(|a, b| a.1.total_cmp(&b.1));
    deepest.filter(|(_, drop)| *drop > LEAST_DROP_GF * gram_force()).map(|(at, _)| at)
}

fn valley(smooth: &[f64], collapse: usize) -> usize {
    let last = (collapse + rows(VALLEY_WITHIN_MM)).min(smooth.len() - 1);
    lowest(smooth, collapse, last).unwrap_or(collapse)
}

/// The first of the lowest values from one index to another; `None` where they stand the other way round.
fn lowest(smooth: &[f64], from: usize, to: usize) -> Option<usize> {
    (from..=to.min(smooth.len() - 1)).min_by(|a, b| smooth[*a].total_cmp(&smooth[*b]))
}

/// Where the force begins to rise steeply after an index.
fn bottom_out(smooth: &[f64], after: usize) -> Option<usize> {
    let steep = BOTTOM_OUT_GF_MM * gram_force() * 2.0 * STEP_MM;
    (after + 1..smooth.len().saturating_sub(1)).find(|at| smooth[at + 1] - smooth[at - 1] > steep)
}

/// Area by trapezia, N mm.
fn area(force_n: &[f64]) -> f64 {
    force_n.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) * STEP_MM).sum()
}

/// Return force and return energy.
fn back_figures(back: &Branch, press: &Branch, actuation: Option<usize>, bottom: Option<usize>) -> [Value; 2] {
    let Some(bottom) = bottom.and_then(|bottom| index_of(back, press.position(bottom))) else {
        return [Err(NO_BOTTOM); 2];
    };
    let smooth = smoothed(&back.load);
    let actuation = actuation.map_or(Err(NO_ACTUATION), |at| index_of(back, press.position(at)).ok_or(NO_RETURN));
    let lowest = actuation.and_then(|from| lowest(&smooth, from, bottom).ok_or(NO_RETURN));
    let first = index_of(back, press.first).unwrap_or(0);
    [lowest.map(|at| smooth[at]), Ok(area(&back.load[first.min(bottom)..=bottom]))]
}

/// Rise over way from the bottom-out to the end of the press, N/mm.
fn end_stiffness(press: &Branch, smooth: &[f64], bottom: usize) -> Value {
    let way_mm = (press.len() - 1 - bottom) as f64 * STEP_MM;
    if way_mm > 0.0 { Ok((smooth[press.len() - 1] - smooth[bottom]) / way_mm) } else { Err(NO_BOTTOM) }
}
