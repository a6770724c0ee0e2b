//! What a format says of a model, and what it leaves out.

use dynamics::effects::{end_stop, friction, karnopp_stick};
use dynamics::{Model, Motion, Part};

use crate::joint::Joint;

/// A model in the format of a simulator.
#[derive(Clone, Debug)]
pub struct Export<Content = String> {
    /// What the file holds.
    pub content: Content,
    /// What the format says of the model, exactly.
    pub said: Model,
    /// What it leaves out or says less exactly, in words; empty if nothing.
    pub left_out: Vec<String>,
}

/// A model of a pressed or sliding control, in a format for rotary joints.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the model '{0}' has a linear axis, and this format is for a rotary one; export its force over travel as .csv")]
pub struct LinearAxis(String);

/// Refuses a model of what is pressed or slid.
pub(crate) fn refuse_linear(model: &Model) -> Result<(), LinearAxis> {
    if model.axis.is_rotary() { Ok(()) } else { Err(LinearAxis(model.name.clone())) }
}

/// RMS of the torque that the format leaves out along a motion that begins at rest, mNm.
///
/// What a sensor misreads is no part of the knob and does not count; at rest friction is whatever holds the knob, in both.
#[must_use]
pub fn left_out_mnm(model: &Model, said: &Model, motions: &[Motion]) -> f64 {
    left_out_by_mnm(model, &said.readings_mnm(motions), motions)
}

/// [`left_out_mnm`] for a format whose torque along the motion is `said_mnm`.
#[must_use]
pub fn left_out_by_mnm(model: &Model, said_mnm: &[f64], motions: &[Motion]) -> f64 {
    let all = without_misreadings(model).readings_mnm(motions);
    let squares: f64 = all.iter().zip(said_mnm).map(|(all, said)| (all - said).powi(2)).sum();
    let count = motions.len().max(1) as f64;
    (squares / count).sqrt()
}

fn is_misreading(part: Part) -> bool {
    matches!(part, Part::Reading(_) | Part::ReadingDelay(_))
}

/// The knob, without what the sensor misreads of it.
pub(crate) fn without_misreadings(model: &Model) -> Model {
    let knob = model.effects.iter().filter(|effect| !is_misreading(effect.kind().part));
    Model { effects: knob.copied().collect(), ..model.clone() }
}

/// What the sensor misreads, in words.
pub(crate) fn misreadings(model: &Model) -> Vec<String> {
    let misread = model.effects.iter().filter(|effect| is_misreading(effect.kind().part));
    misread.map(|effect| format!("{}, which is the sensor's", effect.kind().name)).collect()
}

/// The part of a model that a format with the effects `known` says, with this friction in place of the model's own.
pub(crate) fn said(model: &Model, known: &[&str], coulomb_mnm: [f64; 2], viscous: f64) -> Model {
    let mut effects: Vec<_> =
        model.effects.iter().filter(|effect| known.contains(&effect.kind().name)).copied().collect();
    for effect in &mut effects {
        if effect.kind().name == friction::KIND.name {
            effect.values_mut().copy_from_slice(&[coulomb_mnm[0], coulomb_mnm[1], viscous, viscous]);
        }
    }
    Model { effects, ..model.clone() }
}

/// What the effects `known` leave out, in words.
pub(crate) fn left_out(model: &Model, said: &Model, joint: &Joint) -> Vec<String> {
    let mut words = Vec::new();
    if joint.viscous[0] != joint.viscous[1] {
        words.push("viscous friction that differs by direction".to_owned());
    }
    let friction =
        |model: &Model| model.effect(friction::KIND.name).map(|friction| [friction.values()[0], friction.values()[1]]);
    if friction(model) != friction(said) {
        words.push("Coulomb friction that differs by direction".to_owned());
    }
    for effect in model.effects.iter().filter(|effect| said.effect(effect.kind().name).is_none()) {
        let name = effect.kind().name;
        words.push(match name {
            name if name == karnopp_stick::KIND.name => {
                "the static friction in excess of the sliding friction".to_owned()
            }
            name if name == end_stop::KIND.name => "the stiffness of the end stops".to_owned(),
            name if is_misreading(effect.kind().part) => format!("{name}, which is the sensor's"),
            name => name.to_owned(),
        });
    }
    words
}
