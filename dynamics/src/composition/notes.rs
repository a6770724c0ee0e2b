//! Notes on parts that act on each other in unexpected ways.

use std::f64::consts::TAU;

use crate::simulate::{ForwardSimulation, SimulationError};
use crate::{Direction, Model, Motion, Part, Role, effects};

/// Angles over a turn at which detents are looked at: two thousand to each of the finest shipped detents, those of knob 3.
const SCANNED: u32 = 65_536;

/// What one should know of a composed model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompositionNote {
    /// Karnopp's D is below the friction of sliding.
    #[error(
        "{parameter} of {static_mnm} mNm is below the {sliding_mnm} mNm with which the knob begins to slide, and a knob \
         at rest bears at least those: raise it above, or lower the Coulomb friction, for it to be felt"
    )]
    StickBelowFriction {
        /// D₋ or D₊.
        parameter: &'static str,
        /// Its value, mNm.
        static_mnm: f64,
        /// Friction at the start of sliding, mNm.
        sliding_mnm: f64,
    },
    /// Detents that cannot move the knob.
    #[error(
        "the detents reach {detents_mnm:.3} mNm, less than the {held_mnm:.3} mNm that a knob at rest bears: it can rest \
         anywhere between them"
    )]
    HeldBetweenDetents {
        /// Largest torque of the detents, mNm.
        detents_mnm: f64,
        /// What the knob bears at rest, mNm.
        held_mnm: f64,
    },
    /// Friction that turns into a push.
    #[error("with {parameter} negative, friction pushes instead of braking beyond {speed_rad_s:.2} rad/s")]
    Pushes {
        /// B₋ or B₊.
        parameter: &'static str,
        /// Speed from which it does, rad/s.
        speed_rad_s: f64,
    },
    /// A modulation without what it modulates.
    #[error("{effect} acts on friction, and the model has none: it does nothing")]
    NoFriction {
        /// The effect.
        effect: &'static str,
    },
    /// Stick beside bristles.
    #[error("karnopp-stick does nothing beside presliding-hysteresis, whose bristles hold the knob")]
    StickBesideBristles,
    /// Harmonics that are not the detents'.
    #[error(
        "harmonic_period is {harmonics_rad} rad and detent_period {detents_rad} rad: the harmonics will drift along the \
         detents; set both to the same"
    )]
    PeriodsDiffer {
        /// Period of the harmonics, rad.
        harmonics_rad: f64,
        /// Period of the detents, rad.
        detents_rad: f64,
    },
    /// Lost motion and a soft shaft.
    #[error(
        "backlash and shaft-compliance both lie between cap and knob: a simulation takes {taken} alone, the \
             simulated rig both in series"
    )]
    TwoCouplings {
        /// The one that a simulation takes.
        taken: &'static str,
    },
    /// A model that does not move.
    #[error("it cannot be simulated on its own: {0}")]
    NotSimulated(SimulationError),
}

/// Notes on how a model's parts act on each other.
#[must_use]
pub fn composition_notes(model: &Model) -> Vec<CompositionNote> {
    let mut notes = Vec::new();
    stick(model, &mut notes);
    notes.extend(held(model));
    friction(model, &mut notes);
    if let (Some(harmonics_rad), Some(detents_rad)) =
        (model.parameter("harmonic_period"), model.parameter("detent_period"))
        && (harmonics_rad - detents_rad).abs() > 1e-9 * detents_rad
    {
        notes.push(CompositionNote::PeriodsDiffer { harmonics_rad, detents_rad });
    }
    let mut couplings = model.effects.iter().filter(|effect| matches!(effect.kind().part, Part::Coupling(_)));
    if let (Some(taken), Some(_)) = (couplings.next(), couplings.next()) {
        notes.push(CompositionNote::TwoCouplings { taken: taken.kind().name });
    }
    if let Err(reason) = ForwardSimulation::at_rest(model, 0.0, 0.0) {
        notes.push(CompositionNote::NotSimulated(reason));
    }
    notes
}

fn stick(model: &Model, notes: &mut Vec<CompositionNote>) {
    let Some(stick) = model.effect(effects::karnopp_stick::KIND.name) else { return };
    if model.bristles().is_some() {
        notes.push(CompositionNote::StickBesideBristles);
        return;
    }
    for (index, direction) in [Direction::Negative, Direction::Positive].into_iter().enumerate() {
        let (static_mnm, parameter) = (stick.values()[index], stick.kind().parameters[index].name);
        let sliding_mnm = direction.sign() * model.friction_mnm(&Motion::default(), direction);
        if static_mnm < sliding_mnm {
            notes.push(CompositionNote::StickBelowFriction { parameter, static_mnm, sliding_mnm });
        }
    }
}

fn held(model: &Model) -> Option<CompositionNote> {
    let of_detents = Model {
        effects: model.effects.iter().filter(|effect| effect.kind().role == Role::Detents).copied().collect(),
        ..model.clone()
    };
    let detents_mnm = (0..SCANNED)
        .map(|step| Motion { angle_rad: TAU * f64::from(step) / f64::from(SCANNED), ..Motion::default() })
        .map(|motion| of_detents.free_torque_mnm(&motion).abs())
        .fold(0.0, f64::max);
    let limits = model.stick_limits(&Motion::default());
    let held_mnm = if model.bristles().is_some() { 0.0 } else { limits.negative_mnm.min(limits.positive_mnm) };
    (detents_mnm > 0.0 && detents_mnm < held_mnm)
        .then_some(CompositionNote::HeldBetweenDetents { detents_mnm, held_mnm })
}

fn friction(model: &Model, notes: &mut Vec<CompositionNote>) {
    let is_friction = |part: Part| matches!(part, Part::Friction(_) | Part::FrictionTable(_));
    if !model.effects.iter().any(|effect| is_friction(effect.kind().part)) {
        let idle = model.effects.iter().map(|effect| effect.kind()).filter(|kind| kind.part.changes_friction());
        notes.extend(idle.map(|kind| CompositionNote::NoFriction { effect: kind.name }));
    }
    let Some(friction) = model.effect(effects::friction::KIND.name) else { return };
    let (coulomb, viscous) = friction.values().split_at(2);
    for (index, (coulomb, viscous)) in coulomb.iter().zip(viscous).enumerate() {
        if *viscous < 0.0 {
            let parameter = friction.kind().parameters[2 + index].name;
            notes.push(CompositionNote::Pushes { parameter, speed_rad_s: coulomb / -viscous });
        }
    }
}
