//! Turned controls: detents, friction, backlash and end stops.

mod banded;
mod branches;
mod detents;
mod directions;
mod figures;
mod spline;

use std::collections::BTreeMap;
use std::f64::consts::{SQRT_2, TAU};

use archive::testers::Curve;
use identification::Samples;
use identification::checks::{FreeTravel, count_detents, free_travel};
use identification::statistics::mean;

use crate::branch::Branch;
use crate::figure::{Estimate, FigureKind};
use crate::noise::{DRAWS, Signs, mean_and_deviation};
use crate::repeats::CurveError;
use branches::SplineBranch;
use detents::{Detent, Side, rests, steps};
pub(crate) use figures::KINDS;
use figures::{
    BACKLASH, DETENT_COUNT, DETENT_ENERGY, DETENT_PITCH, DETENT_SHIFT, DETENT_STIFFNESS, END_STOP_HIGH, END_STOP_LOW,
    HYSTERESIS_ENERGY, PEAK_TORQUE, RUNNING_FRICTION, TORQUE_RATIO, TROUGH_TORQUE, UNIFORMITY_PEAK, UNIFORMITY_PITCH,
};
use spline::Spline;

/// Knots from one detent to the next, among which cross-validation chooses. A cubic spline with the fewest of them follows a sine to
/// 0.02 %.
const KNOTS_PER_DETENT: [f64; 4] = [12.0, 18.0, 27.0, 40.0];
/// Cells in a detent: rows in a cell count as their mean.
const CELLS_PER_DETENT: f64 = 240.0;
/// Number of knots relative to the number that predicts best. With more knots, the spline's bias where a branch bends is smaller than
/// the noise, and the intervals need to allow for noise only.
const UNDERSMOOTHED: f64 = 1.5;
/// How far a hinge reaches either way, in knots. A knob jerks where its torque bends, which adds an inertial torque: the narrow hinge
/// averages over the jerk, the wide one follows the bend of a knob without inertia best. The difference of a figure between the two
/// is part of its standard error.
const REACHES: [f64; 2] = [2.0, 6.0];
/// Iterations in which the hinges are moved to the rests of the branches with the hinges of the iteration before.
const BEND_ROUNDS: usize = 3;
/// Detents in a turn that stand for those of a control without any.
const DETENTS_OF_NONE: f64 = 6.0;
/// Time over which the ends of free travel are located, s.
const FREE_TRAVEL_BIN_S: f64 = 0.005;
/// Rows of the curve from one knot to the next.
const ROWS_PER_KNOT: f64 = 4.0;
/// Part of the travel, from each end, in which an end stop may lie.
const OUTER: f64 = 0.2;
/// Torque from which on an angle counts as in an end stop, relative to the largest torque in the middle of the travel.
const STOPS: f64 = 2.0;

const NO_STOP: &str = "the turn met no end stop";

/// What one turn tells.
pub(crate) struct Turned {
    pub(crate) figures: BTreeMap<&'static str, Result<Estimate, String>>,
    pub(crate) detents: Vec<TurnedDetent>,
    pub(crate) branches: Vec<(&'static str, Branch)>,
}

/// One detent in one direction.
#[derive(Clone, Debug)]
pub(crate) struct TurnedDetent {
    pub(crate) direction: &'static str,
    pub(crate) angle: Estimate,
    pub(crate) figures: Vec<(&'static FigureKind, Estimate)>,
}

/// Reads the figures off a slow turn both ways, with the errors that the noise about the branches makes.
///
/// # Errors
/// [`CurveError`] where the control was turned too fast, or one way only.
pub(crate) fn read(curve: &Curve) -> Result<Turned, CurveError> {
    let directions = directions::directions(curve)?;
    let pitch = pitch(curve);
    let about = pitch.as_ref().map_or(TAU / DETENTS_OF_NONE, |pitch| *pitch);
    let smooth = branches(curve, &directions, about).ok_or(CurveError::OneWay)?;
    let [back, there] = &smooth;
    let knot = there.knot();
    let range = [back.ends[0].max(there.ends[0]), back.ends[1].min(there.ends[1])];
    if range[1] - range[0] < ROWS_PER_KNOT * knot {
        return Err(CurveError::OneWay);
    }
    let rests = pitch.as_ref().ok().map(|pitch| rests([&back.spline, &there.spline], range, *pitch));
    let frame = Frame { range, knot, pitch: pitch.as_ref().ok().copied(), rests: rests.unwrap_or_default() };
    let [narrow, wide] = REACHES.map(|reach| frame.bent(&smooth, reach * knot));
    let [back, there] = &narrow;
    let found = frame.look([&back.spline, &there.spline]);
    let otherwise = frame.look([&wide[0].spline, &wide[1].spline]);

    let mut signs = Signs::new();
    let noise = [back.noise(), there.noise()];
    let redrawn: Vec<[Spline; 2]> =
        (0..DRAWS).map(|_| noise.each_ref().map(|noise| noise.redrawn(&mut signs))).collect();
    let looked: Vec<Look> = redrawn.iter().map(|[back, there]| frame.look([back, there])).collect();
    // A maximum picks the highest noise, which biases it. Redrawing adds the same noise, and so the same bias, again: it is subtracted.
    let estimate = |value: f64, of: &dyn Fn(&Look) -> Option<f64>| {
        let values: Vec<f64> = looked.iter().filter_map(of).collect();
        let (mean, standard_error) = mean_and_deviation(&values).unwrap_or((value, 0.0));
        let shift = of(&otherwise).map_or(0.0, |other| other - value);
        Estimate { value: 2.0 * value - mean, standard_error: standard_error.hypot(shift) }
    };
    // Where there is no departure, noise alone makes one; redrawing adds as much noise again, which makes it √2 times as large.
    let departure = |value: f64, of: &dyn Fn(&Look) -> Option<f64>| {
        let Estimate { value: corrected, standard_error } = estimate(value, of);
        let made = (value - corrected) / (SQRT_2 - 1.0);
        Estimate { value: (value - made).max(0.0), standard_error: standard_error.hypot(made / SQRT_2) }
    };
    let no_detents = pitch.err().unwrap_or_else(|| "fewer than two detents were passed both ways".to_owned());
    let figures = KINDS.iter().map(|kind| {
        if std::ptr::eq(*kind, &BACKLASH) {
            return (kind.name, backlash(curve));
        }
        let value = found.figures.get(kind.name);
        let reason = || if is_stop(kind) { NO_STOP.to_owned() } else { no_detents.clone() };
        let of = |look: &Look| look.figures.get(kind.name).copied();
        let estimate =
            value.map(|value| if is_departure(kind) { departure(*value, &of) } else { estimate(*value, &of) });
        (kind.name, estimate.ok_or_else(reason))
    });
    let detents = found.detents.iter().enumerate().map(|(index, (sign, detent))| {
        let estimate = |take: fn(&Detent) -> f64| {
            estimate(take(detent), &|look| look.detents.get(index).map(|(_, detent)| take(detent)))
        };
        TurnedDetent {
            direction: if *sign > 0.0 { "positive" } else { "negative" },
            angle: estimate(|detent| detent.angle),
            figures: PER_DETENT.iter().map(|(kind, take)| (*kind, estimate(*take))).collect(),
        }
    });
    let (figures, detents) = (figures.collect(), detents.collect());
    let (backs, theres): (Vec<Spline>, Vec<Spline>) = redrawn.into_iter().map(|[back, there]| (back, there)).unzip();
    let step = knot / ROWS_PER_KNOT;
    let branches = vec![("negative", back.rows(step, &backs)), ("positive", there.rows(step, &theres))];
    Ok(Turned { figures, detents, branches })
}

/// A figure of a detent, and how it is taken.
type PerDetent = (&'static FigureKind, fn(&Detent) -> f64);

/// The figures that each detent has, in the order of the sheet.
static PER_DETENT: [PerDetent; 6] = [
    (&DETENT_PITCH, |detent| detent.pitch),
    (&PEAK_TORQUE, |detent| detent.peak),
    (&TROUGH_TORQUE, |detent| detent.trough),
    (&TORQUE_RATIO, |detent| (detent.peak - detent.trough) / detent.peak),
    (&DETENT_STIFFNESS, |detent| detent.stiffness),
    (&DETENT_ENERGY, |detent| detent.energy),
];

fn is_departure(kind: &FigureKind) -> bool {
    kind == &UNIFORMITY_PITCH || kind == &UNIFORMITY_PEAK
}

fn is_stop(kind: &FigureKind) -> bool {
    kind == &END_STOP_LOW || kind == &END_STOP_HIGH
}

/// The branches with more knots than predict best what they were not fitted to; `None` if one of them has too few rows.
fn branches(curve: &Curve, directions: &[i8], pitch: f64) -> Option<[SplineBranch; 2]> {
    let with = |knots: f64| {
        let branch =
            |direction| SplineBranch::of(curve, directions, direction, [pitch / knots, pitch / CELLS_PER_DETENT]);
        Some([branch(-1)?, branch(1)?])
    };
    let candidates = KNOTS_PER_DETENT.iter().filter_map(|knots| Some((*knots, with(*knots)?)));
    let (knots, best) = candidates.min_by(|a, b| error(&a.1).total_cmp(&error(&b.1)))?;
    with(UNDERSMOOTHED * knots).or(Some(best))
}

/// Mean square error with which both branches predict what they were not fitted to.
fn error(branches: &[SplineBranch; 2]) -> f64 {
    branches[0].cross_validation + branches[1].cross_validation
}

fn samples<'a>(curve: &'a Curve, t_s: &'a [f64]) -> Samples<'a> {
    Samples {
        t_s,
        angle_rad: &curve.position,
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &curve.load,
    }
}

/// The pitch of the detents, rad, or why there are none.
fn pitch(curve: &Curve) -> Result<f64, String> {
    // Without a time every row counts alike; a step short enough for any table to be less than a day long.
    let rows = || (0..curve.len()).map(|row| row as f64 * 1e-3).collect();
    let t_s: Vec<f64> = curve.t_s.clone().unwrap_or_else(rows);
    count_detents(&samples(curve, &t_s)).map(|count| TAU * count.period_rad).map_err(|error| error.to_string())
}

/// The longest way without torque; its ends are known to the way of one bin of time.
fn backlash(curve: &Curve) -> Result<Estimate, String> {
    let t_s = curve.t_s.as_ref().ok_or(
        "backlash needs a slow creep with a time column, which the table does not \
        have",
    )?;
    let ways = free_travel(&samples(curve, t_s), None).map_err(|error| error.to_string())?;
    let longest = ways.iter().map(FreeTravel::travel_rad).max_by(f64::total_cmp);
    let speed_rad_s = (t_s.len() > 1).then(|| {
        let way: f64 = curve.position.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        way / (t_s[t_s.len() - 1] - t_s[0])
    });
    let standard_error = speed_rad_s.unwrap_or(0.0) * FREE_TRAVEL_BIN_S;
    longest.map(|value| Estimate { value, standard_error }).ok_or_else(|| {
        "the control never turned without torque; to measure backlash, capture the sweep `slow-turn` with an \
         amplitude of 0.1 rad"
            .to_owned()
    })
}

/// What stays the same however the noise falls.
struct Frame {
    range: [f64; 2],
    knot: f64,
    pitch: Option<f64>,
    rests: Vec<f64>,
}

/// What a pair of branches shows.
#[derive(Default)]
struct Look {
    figures: BTreeMap<&'static str, f64>,
    detents: Vec<(f64, Detent)>,
}

impl Frame {
    /// Everything that a pair of branches, negative and positive, shows.
    fn look(&self, branches: [&Spline; 2]) -> Look {
        let mut look = Look::default();
        let sides = self.sides(branches);
        let friction = 0.5 * (self.level(branches[1], self.range) - self.level(branches[0], self.range));
        look.figures.insert(RUNNING_FRICTION.name, friction);
        look.figures.insert(HYSTERESIS_ENERGY.name, 2.0 * TAU * friction);
        for (kind, angle) in self.stops(branches) {
            look.figures.insert(kind.name, angle);
        }
        if let Some(pitch) = self.pitch {
            self.look_at_detents(&sides, pitch, &mut look);
        }
        look
    }

    fn level(&self, spline: &Spline, range: [f64; 2]) -> f64 {
        mean(steps(range, 0.25 * self.knot).map(|at| spline.value(at)))
    }

    fn side<'a>(&self, sign: f64, spline: &'a Spline) -> Side<'a> {
        Side { spline, sign, level: self.level(spline, self.whole_pitches()) }
    }

    fn sides<'a>(&self, [back, there]: [&'a Spline; 2]) -> [Side<'a>; 2] {
        [self.side(-1.0, back), self.side(1.0, there)]
    }

    /// Where a branch rests.
    fn rests_of(&self, sign: f64, spline: &Spline) -> Vec<f64> {
        let side = self.side(sign, spline);
        self.pitch.map_or_else(Vec::new, |pitch| self.rests.iter().filter_map(|near| side.rest(*near, pitch)).collect())
    }

    /// The branches with a hinge at each rest, where detents of unequal height meet at a sharp bend.
    fn bent(&self, smooth: &[SplineBranch; 2], reach: f64) -> [SplineBranch; 2] {
        let hinged = |[back, there]: &[SplineBranch; 2]| {
            let of = |sign, branch: &SplineBranch| branch.hinged(&self.rests_of(sign, &branch.spline), reach);
            Some([of(-1.0, back)?, of(1.0, there)?])
        };
        (0..BEND_ROUNDS).fold(smooth.clone(), |bent, _| hinged(&bent).unwrap_or(bent))
    }

    /// The angles over which the torque's mean is that of whole detents.
    fn whole_pitches(&self) -> [f64; 2] {
        match self.rests.as_slice() {
            [first, .., last] => [*first, *last],
            _ => self.range,
        }
    }

    fn look_at_detents(&self, sides: &[Side<'_>; 2], pitch: f64, look: &mut Look) {
        let rests = sides.map(|side| self.rests.iter().map(|near| side.rest(*near, pitch)).collect::<Vec<_>>());
        for (side, rests) in sides.iter().zip(&rests) {
            for pair in rests.windows(2) {
                let [Some(low), Some(high)] = pair else { continue };
                let (rest, next) = if side.sign > 0.0 { (*low, *high) } else { (*high, *low) };
                look.detents.push((side.sign, side.detent(rest, next)));
            }
        }
        if look.detents.is_empty() {
            return;
        }
        let of = |take: fn(&Detent) -> f64| look.detents.iter().map(|(_, detent)| take(detent)).collect::<Vec<f64>>();
        for (kind, take) in &PER_DETENT {
            look.figures.insert(kind.name, mean(of(*take)));
        }
        let pitches = of(|detent| detent.pitch);
        look.figures.insert(DETENT_COUNT.name, TAU / mean(&pitches));
        look.figures.insert(UNIFORMITY_PITCH.name, uniformity(&pitches));
        look.figures.insert(UNIFORMITY_PEAK.name, uniformity(&of(|detent| detent.peak)));
        let [back, there] = &rests;
        let gaps: Vec<f64> = back.iter().zip(there).filter_map(|(back, there)| Some((*there)? - (*back)?)).collect();
        if !gaps.is_empty() {
            look.figures.insert(DETENT_SHIFT.name, mean(gaps));
        }
    }

    /// End stops, if there are any.
    fn stops(&self, [back, there]: [&Spline; 2]) -> Vec<(&'static FigureKind, f64)> {
        let [low, high] = self.range;
        let way = OUTER * (high - low);
        let step = 0.25 * self.knot;
        let against = |at: f64| there.value(at).max(-back.value(at));
        let within = steps([low + way, high - way], step).map(against).fold(0.0, f64::max);
        let stops = |torque: f64| torque > STOPS * within;
        let above: Vec<f64> = steps([high - way, high], step).collect();
        let below: Vec<f64> = steps([low, low + way], step).collect();
        let free_above = above.iter().rposition(|at| !stops(there.value(*at)));
        let free_below = below.iter().position(|at| !stops(-back.value(*at)));
        let mut found = Vec::new();
        if let Some(free) = free_below.filter(|free| *free > 0) {
            found.push((&END_STOP_LOW, below[free]));
        }
        if let Some(free) = free_above.filter(|free| free + 1 < above.len()) {
            found.push((&END_STOP_HIGH, above[free]));
        }
        found
    }
}

/// Largest departure from the mean, over the mean.
fn uniformity(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|value| (value - mean).abs()).fold(0.0, f64::max) / mean.abs()
}
