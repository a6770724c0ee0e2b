//! The encoder's zero, which may lie elsewhere in the held-out capture: an incremental encoder counts from where it was
//! switched on.
//!
//! Detents, cogging and gravity of the training capture are then predicted at the wrong angle. The angle between both zeros is
//! no property of the knob: it is estimated from the held-out capture and taken out of it.

use dynamics::{Coordinate, EffectKind, Model, Motion, effects};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::residuals::residual;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::search::hypotheses;
use crate::diagnosis::search::judged::{Judged, p_value};
use crate::numerics::statistics::{NORMAL_95, plus_minus};
use crate::numerics::vector::square;
use crate::preparation::motion::KnobMotion;

/// Angles between two zeros that are tried per radian of the finest torque's phase.
const PER_PHASE: f64 = 3.0;
const MOST_TRIED: usize = 4_000;
/// Number of rows at which the angles are compared; the comparison takes at most twice as many.
const ROWS: usize = 2_000;
/// The smallest angle is taken among those whose sum of squares exceeds the least one by at most this share.
const AS_GOOD: f64 = 0.02;
/// Another zero is examined closely if it reduces the sum of squares at the rows' middles by this share.
const PROMISING: f64 = 0.05;
/// Halvings of the distance between two tried angles.
const HALVINGS: usize = 12;
/// The zeros are the same unless another one takes off this share of the sum of squares …
const WORTHWHILE: f64 = 0.2;
/// … and, stretch after stretch, more than chance would with this probability.
const CHANCE: f64 = 1e-4;
/// Share of its interval by which the angle may change when it is estimated again.
const SETTLED: f64 = 0.5;
/// An effect of the angle that the model lacks is used to find the zero if it leaves less than this share of the training
/// capture's sum of squares.
const SHOWS: f64 = 0.5;

/// The angle between the zeros of two captures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EncoderZero {
    /// What must be added to the held-out capture's angle, rad.
    by_rad: f64,
    /// Half its 95 % interval, rad.
    half_rad: f64,
    /// RMS that the model leaves of the held-out capture without and with it, mNm.
    left_mnm: [f64; 2],
}

impl EncoderZero {
    /// The angle between the zeros, estimated from the torques of the angle that the model has or obviously lacks; `None` if
    /// no other zero is clearly better.
    pub(crate) fn of(base: &Judged, [train, heldout]: &[Capture; 2]) -> Option<Self> {
        let structure = &base.structure;
        let by_base = Self::by(structure, heldout);
        if structure.is_coupled() || by_base.is_none() && !of_angle(structure).is_empty() {
            return by_base;
        }
        // Detents determine the angle only up to whole periods; another effect of the angle may determine these.
        let fit = Separable::new(structure.clone(), train);
        let more = hypotheses::candidates(structure, train)
            .into_iter()
            .filter(|kind| kind.depends_on.contains(&Coordinate::Angle));
        let with = more.filter_map(|kind| Some((kind, hypotheses::separable::fitted(kind, &fit, heldout, 0.0)?)));
        let best = with.min_by(|(_, a), (_, b)| a.train_rms_mnm.total_cmp(&b.train_rms_mnm));
        let shows = best.filter(|(kind, best)| {
            is_of_angle(kind) && best.train_rms_mnm.powi(2) < SHOWS * base.train_rms_mnm.powi(2)
        });
        shows.and_then(|(_, best)| Self::by(&best.structure, heldout)).or(by_base)
    }

    /// The angle between the zeros, estimated from the torques of the angle in one structure.
    fn by(structure: &Structure, heldout: &Capture) -> Option<Self> {
        if structure.is_coupled() {
            return None;
        }
        let step_rad = phase_rad(structure, heldout)? / PER_PHASE;
        let from_rad = coarse(structure, heldout, step_rad)?;
        Self::near(from_rad, step_rad, structure, heldout)
    }

    /// Estimates the angle again, by a structure that lacks less than the one that gave `before`.
    pub(crate) fn again(before: Option<Self>, structure: &Structure, heldout: &Capture) -> Option<Self> {
        let Some(before) = before else { return Self::by(structure, heldout) };
        let step_rad = phase_rad(structure, heldout).map_or(before.half_rad, |phase_rad| phase_rad / PER_PHASE);
        Self::near(before.by_rad, step_rad, structure, heldout)
    }

    /// Whether two angles differ, as far as they are known.
    pub(crate) fn differ(before: Option<Self>, after: Option<Self>) -> bool {
        match (before, after) {
            (Some(before), Some(after)) => (after.by_rad - before.by_rad).abs() > SETTLED * after.half_rad,
            _ => before != after,
        }
    }

    /// The best angle between the zeros near `from_rad`; `None` if it does not significantly reduce the held-out residual.
    fn near(from_rad: f64, step_rad: f64, structure: &Structure, heldout: &Capture) -> Option<Self> {
        let left = |by_rad: f64| residual(structure, &moved(heldout, by_rad));
        let (by_rad, curvature) = refined(from_rad, step_rad, |by_rad| square(&left(by_rad)))?;
        let [here, there] = [0.0, by_rad].map(left);
        let worthwhile = square(&there) < (1.0 - WORTHWHILE) * square(&here);
        if !worthwhile || p_value(&here, &there) > CHANCE {
            return None;
        }
        let left_mnm = [here, there].map(|left| (square(&left) / heldout.weight).sqrt());
        Some(Self { by_rad, half_rad: NORMAL_95 * left_mnm[1] / curvature.sqrt(), left_mnm })
    }

    /// The held-out capture as it would be with the training capture's zero.
    pub(crate) fn taken_out_of(&self, heldout: &Capture) -> Capture {
        moved(heldout, self.by_rad)
    }

    /// What was found, in a sentence.
    pub(crate) fn note(&self) -> String {
        let Self { by_rad, half_rad, left_mnm: [before, after] } = self;
        format!(
            "the held-out capture's angle counts from another zero than the training capture's: {} rad were added to it (where \
             all torque of the angle repeats, any number of periods more would do), with which the final model leaves \
             {after:.3} mNm RMS, without {before:.3}",
            plus_minus(*by_rad, *half_rad)
        )
    }
}

/// The capture with `by_rad` added to its angle.
fn moved(capture: &Capture, by_rad: f64) -> Capture {
    let motion = &capture.motion;
    let angle_rad = motion.angle_rad.iter().map(|angle| angle + by_rad).collect();
    capture.with_motion(KnobMotion { angle_rad, ..motion.clone() })
}

/// Whether an effect is a torque of the angle. A spring does not count: shifting its zero only adds an offset.
fn is_of_angle(kind: &EffectKind) -> bool {
    kind.steepest_mnm_rad.is_some()
        && kind.depends_on.first() == Some(&Coordinate::Angle)
        && kind.name != effects::return_spring::KIND.name
}

/// Those of a structure's effects that are torques of the angle.
fn of_angle(structure: &Structure) -> Vec<usize> {
    (0..structure.effects.len()).filter(|index| is_of_angle(structure.effects[*index].kind())).collect()
}

/// Angle over which the finest torque of the angle changes by a radian of phase, rad; `None` where there is no such torque.
fn phase_rad(structure: &Structure, capture: &Capture) -> Option<f64> {
    let finest = of_angle(structure).into_iter().filter_map(|index| {
        let effect = &structure.effects[index];
        let torque_mnm = |motion: &Motion| effect.free_torque_mnm(motion).abs();
        let largest_mnm = capture.row_motions().iter().map(|(motion, _)| torque_mnm(motion)).fold(0.0, f64::max);
        let steepest_mnm_rad = effect.kind().steepest_mnm_rad?(effect);
        (steepest_mnm_rad > 0.0 && largest_mnm > 0.0).then(|| largest_mnm / steepest_mnm_rad)
    });
    finest.reduce(f64::min)
}

/// The angle of a grid over a turn with which the structure explains most of the capture at the rows' middles; `None` if it
/// explains hardly more than an angle of zero.
fn coarse(structure: &Structure, capture: &Capture, step_rad: f64) -> Option<f64> {
    let half = ((std::f64::consts::PI / step_rad) as usize).min(MOST_TRIED / 2);
    let places = of_angle(structure);
    let rest = structure.without_all(&places);
    let torques: Vec<_> = places.iter().map(|index| structure.effects[*index]).collect();
    let of_angle = Model { effects: torques, ..Model::default() };
    let target = residual(&rest, capture);
    let rows: Vec<(f64, f64, f64)> = capture
        .row_motions()
        .iter()
        .zip(&target)
        .filter(|((_, mask), _)| *mask > 0.0)
        .step_by((target.len() / ROWS).max(1))
        .map(|((motion, mask), target)| (motion.angle_rad, *mask, *target))
        .collect();
    let squares = |by_rad: f64| -> f64 {
        let left = |(angle, mask, target): &(f64, f64, f64)| {
            let there = Motion { angle_rad: angle + by_rad, ..Motion::default() };
            (target - mask * of_angle.free_torque_mnm(&there)).powi(2)
        };
        rows.iter().map(left).sum()
    };
    let tried: Vec<(f64, f64)> = (0..=2 * half)
        .map(|place| (place as f64 - half as f64) * step_rad)
        .map(|by_rad| (by_rad, squares(by_rad)))
        .collect();
    let valleys = tried.windows(3).filter(|three| three[1].1 <= three[0].1.min(three[2].1));
    let mut bottoms: Vec<(f64, f64)> = valleys
        .filter_map(|three| refined(three[1].0, step_rad, squares))
        .map(|(by_rad, _)| (by_rad, squares(by_rad)))
        .collect();
    let best = bottoms.iter().map(|bottom| bottom.1).fold(f64::INFINITY, f64::min);
    if best > (1.0 - PROMISING) * squares(0.0) {
        return None;
    }
    bottoms.retain(|bottom| bottom.1 <= (1.0 + AS_GOOD) * best);
    bottoms.into_iter().map(|bottom| bottom.0).min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// The minimum within `step` of a start, and the function's curvature there: half its second derivative.
fn refined(start: f64, step: f64, of: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    let (mut at, mut least, mut step) = (start, of(start), step);
    let mut curvature = 0.0;
    for _ in 0..HALVINGS {
        let [below, above] = [of(at - step), of(at + step)];
        let bend = 0.5 * (below + above) - least;
        if bend > 0.0 {
            curvature = bend / step.powi(2);
        }
        let moved = if bend > 0.0 { (0.25 * (below - above) / bend).clamp(-1.0, 1.0) * step } else { 0.0 };
        let there = of(at + moved);
        if there < least {
            (at, least) = (at + moved, there);
        }
        if moved.abs() < 0.05 * step && bend < 0.01 * least {
            break;
        }
        step *= 0.5;
    }
    (curvature > 0.0).then_some((at, curvature))
}
