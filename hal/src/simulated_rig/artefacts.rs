//! Artefacts of the torque channel, where the model lists any: a delay, and effects that add to the reading.

use dynamics::{Effect, Model, Motion, Part};

use super::{ParameterError, RigParameters};

/// Longest delay of a reading, s.
const LONGEST_DELAY_S: f64 = 0.1;

/// Delay and additions of the torque channel.
#[derive(Debug)]
pub(super) struct Artefacts {
    /// Effects that add to the reading.
    readings: Vec<Effect>,
    substep_s: f64,
    /// Delay in substeps.
    delay: f64,
    /// Ring buffer of the channel's values at the last substeps.
    past_mnm: Box<[f64]>,
    next: usize,
}

impl Artefacts {
    /// The artefacts that `model` lists.
    ///
    /// # Errors
    /// [`ParameterError`] for a reading that comes before the torque, or later than 0.1 s.
    pub(super) fn new(parameters: &RigParameters, model: &Model) -> Result<Self, ParameterError> {
        let delays = model.effects.iter().map(|effect| match effect.kind().part {
            Part::ReadingDelay(delay_s) => delay_s(effect.values()),
            _ => 0.0,
        });
        let delay_s: f64 = delays.sum();
        if !(0.0..=LONGEST_DELAY_S).contains(&delay_s) {
            let requirement = "from 0 to 0.1 s: nothing is read before it happens";
            return Err(ParameterError { parameter: "sensor_delay", value: delay_s, requirement });
        }
        let delay = delay_s / parameters.substep_s();
        let kept = delay.ceil() as usize + 1;
        let adds = |effect: &&Effect| matches!(effect.kind().part, Part::Reading(_));
        Ok(Self {
            readings: model.effects.iter().filter(adds).copied().collect(),
            substep_s: parameters.substep_s(),
            delay,
            past_mnm: vec![0.0; kept].into_boxed_slice(),
            next: 0,
        })
    }

    /// Lets a substep pass at whose end the channel stands at `torque_mnm`.
    pub(super) fn step(&mut self, torque_mnm: f64) {
        self.past_mnm[self.next] = torque_mnm;
        self.next = (self.next + 1) % self.past_mnm.len();
    }

    /// The reading `beyond_s` after the last substep, at which the channel changes by `rate_mnm_s`.
    pub(super) fn read(&self, beyond_s: f64, rate_mnm_s: f64, motion: &Motion) -> f64 {
        let added: f64 = self
            .readings
            .iter()
            .map(|effect| match effect.kind().part {
                Part::Reading(reading) => reading(effect.values(), motion),
                _ => 0.0,
            })
            .sum();
        self.delayed_mnm(self.delay - beyond_s / self.substep_s, rate_mnm_s) + added
    }

    /// The channel's value a number of substeps ago, between substeps on a straight line.
    fn delayed_mnm(&self, ago: f64, rate_mnm_s: f64) -> f64 {
        if ago <= 0.0 {
            return self.past(0) - ago * self.substep_s * rate_mnm_s;
        }
        let whole = ago.floor() as usize;
        let (later, earlier) = (self.past(whole), self.past(whole + 1));
        later + (ago - ago.floor()) * (earlier - later)
    }

    fn past(&self, substeps_ago: usize) -> f64 {
        let kept = self.past_mnm.len();
        self.past_mnm[(self.next + kept - 1 - substeps_ago.min(kept - 1)) % kept]
    }
}
