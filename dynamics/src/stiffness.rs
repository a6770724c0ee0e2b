//! How steeply a knob's torque changes with the angle.

use crate::effects::{detent, detent_harmonics};
use crate::{Effect, Model};

/// Relative difference up to which two periods are one.
const SAME_PERIOD: f64 = 1e-9;

impl Model {
    /// Steepest slope |dτ/dθ| that the torque can have at any angle, mNm/rad: a renderer must stay stable at this
    /// stiffness at its sample rate.
    ///
    /// The sum of the effects' steepest slopes, so an upper bound where several act; detents and harmonics of the same
    /// period are taken as the one waveform that they are. Friction, and the contact of a coupling
    /// ([`Model::coupling`]), are not in it.
    #[must_use]
    pub fn steepest_stiffness_mnm_rad(&self) -> f64 {
        let alone = |effect: &Effect| effect.kind().steepest_mnm_rad.map_or(0.0, |steepest| steepest(effect));
        let of_waveform = |effect: &Effect| match self.first_harmonic_mnm(effect) {
            Some(first_mnm) => detent_harmonics::steepest_mnm_rad(effect, first_mnm),
            None if self.is_part_of_harmonics(effect) => 0.0,
            None => alone(effect),
        };
        self.effects.iter().map(of_waveform).sum()
    }

    /// Sine and cosine of the detents that `effect` has the harmonics of.
    fn first_harmonic_mnm(&self, effect: &Effect) -> Option<[f64; 2]> {
        if effect.kind().name != detent_harmonics::KIND.name {
            return None;
        }
        let [amplitude, period, phase] = *self.effect(detent::KIND.name)?.values() else { return None };
        let same = (period - effect.values()[0]).abs() <= SAME_PERIOD * period;
        same.then(|| [amplitude * phase.cos(), amplitude * phase.sin()])
    }

    fn is_part_of_harmonics(&self, effect: &Effect) -> bool {
        let harmonics = self.effect(detent_harmonics::KIND.name);
        effect.kind().name == detent::KIND.name
            && harmonics.is_some_and(|harmonics| self.first_harmonic_mnm(harmonics).is_some())
    }
}
