//! What the torque sensor reads while the knob goes through a known motion.

use std::ops::Range;

use crate::simulate::inner_body::InnerBody;
use crate::{Bristles, Coupling, Direction, Effect, Model, Motion, Part, Resolution, shifted};

/// Speed below which a model without stick of its own counts as resting, rad/s.
const RESTING_RAD_S: f64 = 0.02;

/// What the torque sensor reads of a model, one motion after the other.
#[derive(Debug)]
pub struct TorqueReader<'model> {
    model: &'model Model,
    memory: Memory<'model>,
    before: Option<Motion>,
}

/// The state on which a torque depends besides the present motion.
#[derive(Debug)]
enum Memory<'model> {
    None,
    /// How far the bristles are bent.
    Bent(Bristles, f64),
    Coupled(Coupling),
    Body(InnerBody<'model>),
}

impl<'model> TorqueReader<'model> {
    /// Of a model before its first motion.
    #[must_use]
    pub fn of(model: &'model Model) -> Self {
        let memory = match (model.coupling(), model.bristles()) {
            (Some(coupling), _) => Memory::Coupled(coupling),
            (None, Some(bristles)) => Memory::Bent(bristles, 0.0),
            (None, None) => Memory::None,
        };
        Self { model, memory, before: None }
    }

    /// The reading at a motion that follows the one before, mNm; as [`Model::readings_mnm`] has it.
    pub fn read_mnm(&mut self, motion: &Motion) -> f64 {
        let before = self.before.replace(*motion).unwrap_or(*motion);
        if let Memory::Coupled(coupling) = self.memory {
            self.memory = Memory::Body(InnerBody::at_rest(self.model, coupling, motion.angle_rad));
        }
        let torque_mnm = match &mut self.memory {
            Memory::None | Memory::Coupled(_) => self.model.torque_mnm(motion),
            Memory::Bent(bristles, bent) => {
                *bent = bristles.bent(*bent, motion.angle_rad - before.angle_rad);
                self.model.inertia_at(motion.angle_rad) * motion.acceleration_rad_s2
                    + self.model.free_torque_mnm(motion)
                    + self.model.bristled_friction_mnm(*bristles, motion, *bent, Direction::of(motion.velocity_rad_s))
            }
            Memory::Body(body) => {
                if motion.time_s > before.time_s {
                    body.advance(&before, motion);
                }
                body.torque_mnm(motion) + body.cap_mnm(motion)
            }
        };
        torque_mnm + self.model.misreading_mnm(motion)
    }
}

impl Model {
    /// What the torque sensor reads at every motion, mNm: all effects together, those with a memory too.
    ///
    /// The motions follow each other in time, the first at rest. The reading's delay is not applied: these are the
    /// readings of [`Model::reading_delay_s`] later. While friction without bristles holds the knob at rest, its torque
    /// is left out, as in [`Model::torque_mnm`].
    #[must_use]
    pub fn readings_mnm(&self, motions: &[Motion]) -> Vec<f64> {
        if let Some(coupling) = self.coupling() {
            let at_rest = |first: &Motion| [InnerBody::at_rest(self, coupling, first.angle_rad)];
            let [readings_mnm] = Self::coupled_mnm([self], motions, Resolution::Full, at_rest);
            return readings_mnm;
        }
        let mut reader = TorqueReader::of(self);
        motions.iter().map(|motion| reader.read_mnm(motion)).collect()
    }

    /// [`Model::readings_mnm`] of several models for one measured motion; faster than one model after the other if they have an inner body.
    ///
    /// The first measured reading, `first_mnm`, shows how far a shaft was twisted then.
    #[must_use]
    pub fn readings_of_mnm<const MODELS: usize>(
        models: [&Self; MODELS],
        motions: &[Motion],
        first_mnm: f64,
        resolution: Resolution,
    ) -> [Vec<f64>; MODELS] {
        match all(models.map(Self::coupling)) {
            Some(couplings) => Self::coupled_mnm(models, motions, resolution, |first| {
                std::array::from_fn(|index| {
                    let torque_mnm = first_mnm - models[index].misreading_mnm(first);
                    InnerBody::under(models[index], couplings[index], first, torque_mnm)
                })
            }),
            None => models.map(|model| model.readings_mnm(motions)),
        }
    }

    /// What the sensor reads besides the torque, mNm.
    fn misreading_mnm(&self, motion: &Motion) -> f64 {
        let each = self.effects.iter().map(|effect| match effect.kind().part {
            Part::Reading(reading) => reading(effect.values(), motion),
            _ => 0.0,
        });
        each.sum()
    }

    /// The torque at the times of `motions`, mNm, from what the sensor read at these times: the inverse of offset, hum
    /// and delay.
    ///
    /// Outside of [`Model::readings_within`] the first or the last reading stands in.
    #[must_use]
    pub fn knob_torque_mnm(&self, motions: &[Motion], readings_mnm: &[f64]) -> Vec<f64> {
        let time_s: Vec<f64> = motions.iter().map(|motion| motion.time_s).collect();
        let mut torque_mnm = shifted(&time_s, readings_mnm, self.reading_delay_s());
        torque_mnm.iter_mut().zip(motions).for_each(|(sum, motion)| *sum -= self.misreading_mnm(motion));
        torque_mnm
    }

    /// Indices of the motions whose delayed torque reading falls within the times of `motions`.
    #[must_use]
    pub fn readings_within(&self, motions: &[Motion]) -> Range<usize> {
        let (Some(first), Some(last)) = (motions.first(), motions.last()) else { return 0..0 };
        let delay_s = self.reading_delay_s();
        let start = motions.partition_point(|motion| motion.time_s + delay_s < first.time_s);
        let end = motions.partition_point(|motion| motion.time_s + delay_s <= last.time_s);
        start..end.max(start)
    }

    /// Time by which the torque reading is late, s.
    #[must_use]
    pub fn reading_delay_s(&self) -> f64 {
        let late = |effect: &Effect| match effect.kind().part {
            Part::ReadingDelay(delay) => delay(effect.values()),
            _ => 0.0,
        };
        self.effects.iter().map(late).sum()
    }

    /// The coupling of cap and inner body; `None` for a knob of one body.
    #[must_use]
    pub fn coupling(&self) -> Option<Coupling> {
        self.effects.iter().find_map(|effect| match effect.kind().part {
            Part::Coupling(coupling) => Some(coupling(effect.values())),
            _ => None,
        })
    }

    /// The bristles over whose deflection friction builds up; `None` if it acts at once.
    #[must_use]
    pub fn bristles(&self) -> Option<Bristles> {
        self.effects.iter().find_map(|effect| match effect.kind().part {
            Part::Bristles(bristles) => Some(bristles(effect.values())),
            _ => None,
        })
    }

    fn coupled_mnm<'model, const MODELS: usize>(
        models: [&'model Self; MODELS],
        motions: &[Motion],
        resolution: Resolution,
        bodies: impl Fn(&Motion) -> [InnerBody<'model>; MODELS],
    ) -> [Vec<f64>; MODELS] {
        let mut readings_mnm = [(); MODELS].map(|()| Vec::with_capacity(motions.len()));
        let Some(first) = motions.first() else { return readings_mnm };
        let mut bodies = bodies(first).map(|body| body.at_resolution(resolution));
        let step = if let Resolution::Slow(step) = resolution { step.max(1) } else { 1 };
        let mut before = first;
        let mut torques_mnm = bodies.each_ref().map(|body| body.torque_mnm(first));
        for passed in motions.chunks(step) {
            let now = &passed[passed.len() - 1];
            if now.time_s > before.time_s {
                InnerBody::advance_together(&mut bodies, before, now);
            }
            before = now;
            for (((readings_mnm, body), model), torque_mnm) in
                readings_mnm.iter_mut().zip(&bodies).zip(models).zip(&mut torques_mnm)
            {
                let begins_mnm = std::mem::replace(torque_mnm, body.torque_mnm(now));
                let falls_mnm = (begins_mnm - *torque_mnm) / passed.len() as f64;
                readings_mnm.extend(passed.iter().zip((0..passed.len()).rev()).map(|(cap, ahead)| {
                    *torque_mnm + ahead as f64 * falls_mnm + body.cap_mnm(cap) + model.misreading_mnm(cap)
                }));
            }
        }
        readings_mnm
    }

    /// The part of sliding friction to leave out of a reading close to rest, mNm.
    ///
    /// At rest friction is whatever holds the knob and no function of its motion. Without this part, friction rises in a straight line
    /// through zero across the band of Karnopp's Δv, so that the encoder's noise does not make it jump between both signs. Zero for
    /// friction that builds up by itself, with bristles or behind a coupling.
    #[must_use]
    pub fn unsettled_friction_mnm(&self, motion: &Motion) -> f64 {
        if motion.velocity_rad_s == 0.0 || self.coupling().is_some() || self.bristles().is_some() {
            return 0.0;
        }
        let band = self.stick_limits(motion).velocity_rad_s.max(RESTING_RAD_S);
        let share = (motion.velocity_rad_s.abs() / band).min(1.0);
        (1.0 - share) * self.friction_mnm(motion, Direction::of(motion.velocity_rad_s))
    }

    /// Friction whose Coulomb part is scaled by the deflection of the bristles, `bent`, mNm.
    #[must_use]
    pub fn bent_friction_mnm(&self, motion: &Motion, bent: f64) -> f64 {
        self.partly_bent_mnm(motion, bent, Direction::of(motion.velocity_rad_s))
    }

    /// The same with the damping of the bristles, while turning in `direction`.
    pub(crate) fn bristled_friction_mnm(
        &self,
        bristles: Bristles,
        motion: &Motion,
        bent: f64,
        direction: Direction,
    ) -> f64 {
        let bending_rad_s = motion.velocity_rad_s * (1.0 - direction.sign() * bent);
        self.partly_bent_mnm(motion, bent, direction) + bristles.damping * bending_rad_s
    }

    fn partly_bent_mnm(&self, motion: &Motion, bent: f64, direction: Direction) -> f64 {
        let still = Motion { velocity_rad_s: 0.0, ..*motion };
        bent.abs() * self.friction_mnm(&still, Direction::of(bent)) + self.friction_mnm(motion, direction)
            - self.friction_mnm(&still, direction)
    }
}

/// All of them, if none is missing.
fn all<T: Copy, const COUNT: usize>(options: [Option<T>; COUNT]) -> Option<[T; COUNT]> {
    let mut all = [options.first().copied().flatten()?; COUNT];
    for (slot, option) in all.iter_mut().zip(options) {
        *slot = option?;
    }
    Some(all)
}
