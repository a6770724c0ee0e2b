//! The torque that an inner body bears at rest, fitted where a coupling alone does not explain a capture.
//!
//! The sum of squares is a step function of the stick limit, since a body either breaks away or does not. It has no useful
//! derivative, so levels are tried, together with dampings of the contact: the simulation moves the cap as it was measured
//! and smoothed, so that the cap yields to a blow neither as fast nor as far as the real one. A simulated body then rebounds
//! too far, comes to rest in the middle of its gap and sticks where the real one went on. More damping compensates for this.

use dynamics::effects::{backlash, karnopp_stick};
use dynamics::{Effect, Part};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::statistics::quantile;

/// Shares of the largest torque that are tried as limits, together with everything else …
const LEVELS: [f64; 2] = [0.3, 1.0];
/// … and alone where one of them helped.
const FINE_LEVELS: [f64; 8] = [0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 1.0, 2.0];
/// Ratios by which the contact's damping is raised.
const DAMPINGS: [f64; 3] = [1.0, 4.0, 16.0];
/// Quantile of the torque's magnitude that counts as the largest: single blows are larger.
const LARGEST: f64 = 0.99;
/// Shares of the inertia that may be left.
const LIGHTER: [f64; 2] = [1.0, 0.25];
/// If the best trial leaves more than this share of the sum of squares, stick limits are given up.
const HOPELESS: f64 = 0.9;

/// The fit with the best of the levels, refined from there; `None` where bodies cannot lose touch, and where the best level leaves
/// more than [`HOPELESS`] of the sum of squares.
pub(crate) fn fitted<'a>(fit: &Nonlinear<'a>, train: &'a Capture) -> Option<Nonlinear<'a>> {
    let mut torques: Vec<f64> = train.torque_mnm(0.0).iter().map(|torque| torque.abs()).collect();
    let largest_mnm = quantile(&mut torques, LARGEST);
    let mut coarse = best_of(&trials(&fit.structure, largest_mnm, train), train)?;
    if coarse.squares() > HOPELESS * fit.squares() {
        return None;
    }
    coarse.refine_slow(fit.leaves_much());
    let coarse = coarse.refined();
    let fine = best_of(&FINE_LEVELS.map(|share| coarse.structure.sticking(share * largest_mnm)), train)?.refined();
    Some(if fine.squares() < coarse.squares() { fine } else { coarse })
}

/// The structure that leaves least as it stands.
fn best_of<'a>(trials: &[Structure], train: &'a Capture) -> Option<Nonlinear<'a>> {
    Nonlinear::all(trials, train).into_iter().min_by(|a, b| a.squares().total_cmp(&b.squares()))
}

/// Structures with other limits, more damping and a lighter cap: a structure without stick may have taken blows for
/// inertia.
fn trials(structure: &Structure, largest_mnm: f64, train: &Capture) -> Vec<Structure> {
    let coupling = |effect: &Effect| matches!(effect.kind().part, Part::Coupling(_));
    let (Some(index), Some(inertia)) = (
        structure.effects.iter().position(coupling),
        structure.effects.iter().position(|effect| matches!(effect.kind().part, Part::Inertia(_))),
    ) else {
        return Vec::new();
    };
    if structure.model().coupling().is_none_or(|coupling| coupling.half_gap_rad == 0.0) {
        return Vec::new();
    }
    let mut trials = Vec::new();
    for (damping, lighter) in DAMPINGS.into_iter().flat_map(|damping| LIGHTER.map(|lighter| (damping, lighter))) {
        let mut moved = structure.clone();
        moved.effects[inertia].values_mut()[0] *= lighter;
        let values = moved.effects[index].values_mut();
        values[backlash::INNER_SHARE] /= lighter;
        values[backlash::DAMPING] *= damping;
        let moved = within_range(moved, index, train);
        trials.extend(LEVELS.map(|share| moved.sticking(share * largest_mnm)));
        trials.push(moved);
    }
    trials
}

/// The structure with the values of the effect at an index clamped to the ranges of their searches.
fn within_range(mut structure: Structure, index: usize, train: &Capture) -> Structure {
    let scene = train.scene_of(&structure);
    let effect = &mut structure.effects[index];
    for search in effect.kind().searches() {
        if let Some((least, largest)) = search.range_in(&scene) {
            let value = &mut effect.values_mut()[search.parameter];
            *value = value.max(least).min(largest);
        }
    }
    structure
}

impl Structure {
    /// Whether the structure has stick: at rest the knob may bear more than friction.
    pub(crate) fn sticks(&self) -> bool {
        self.effects.iter().any(|effect| matches!(effect.kind().part, Part::Stick(_)))
    }

    /// The structure with a stick limit for both directions, put before the effect that was added last.
    fn sticking(&self, limit_mnm: f64) -> Self {
        let mut more = self.clone();
        if let Some(effect) = more.effects.iter_mut().find(|effect| matches!(effect.kind().part, Part::Stick(_))) {
            effect.values_mut()[..2].copy_from_slice(&[limit_mnm, limit_mnm]);
            return more;
        }
        let stick = Effect::new(&karnopp_stick::KIND, &[limit_mnm, limit_mnm, 0.0]);
        self.with_at(self.effects.len().saturating_sub(1), stick, 0)
    }
}
