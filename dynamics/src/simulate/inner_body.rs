//! The motion of a knob's inner body while its cap moves as it was measured.

use crate::model::balanced_load_mnm;
use crate::sorted_effects::{Friction, SortedEffects};
use crate::{Bristles, Coupling, Direction, Model, Motion, StickLimits};

/// Substeps per sample, at least.
const SUBSTEPS: f64 = 2.0;
/// Largest phase that the coupling's resonance may turn in one substep, rad …
const PHASE: f64 = 0.25;
/// … and where only motion far below it counts.
const SLOW_PHASE: f64 = 1.0;

/// The inner body of a knob whose cap moves as it was measured.
///
/// Implicit midpoint rule for coupling and inertia, dry friction as a constraint on the velocity at the end of a substep
/// (J. J. Moreau, *Unilateral contact and dry friction in finite freedom dynamics*, CISM 302, 1988): the body comes
/// to rest exactly and stays there until the load passes what it bears at rest. Friction with bristles gives way
/// instead, its stiffness and damping being taken at the middle of the substep too.
#[derive(Debug)]
pub(crate) struct InnerBody<'model> {
    effects: SortedEffects<'model>,
    karnopp_limits: StickLimits,
    coupling: Coupling,
    bristles: Option<Bristles>,
    inertia: f64,
    /// Of the cap, mNm·s²/rad.
    cap_inertia: f64,
    /// Angular frequency of the body on the coupling, rad/s.
    resonance_rad_s: f64,
    /// Largest phase that it may turn in one substep, rad.
    largest_phase_rad: f64,
    angle_rad: f64,
    velocity_rad_s: f64,
    deflection: f64,
}

/// How finely an inner body is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// From motion to motion, its resonance resolved.
    Full,
    /// For motion far below the resonance, which is hardly resolved (the implicit rule stays stable): one step covers this many motions, and
    /// the torque on the cap is interpolated linearly over them.
    Slow(usize),
}

/// What acts on the body over a sample.
struct Held {
    /// Its inertia, mNm·s²/rad.
    inertia: f64,
    /// Torque of detents, springs and whatever else depends on the angle, mNm.
    free_mnm: f64,
    /// The part of `free_mnm` that counts as load for friction, mNm; zero if no friction depends on the load.
    place_mnm: f64,
    limits: StickLimits,
    /// Friction at the lowest speed in either direction, mNm.
    level_mnm: [f64; 2],
    /// The direction in which the body turns, or is about to.
    direction: Direction,
    /// Rise of friction over speed in that direction, mNm·s/rad.
    slope: f64,
}

impl Held {
    fn friction_mnm(&self, velocity_rad_s: f64, direction: Direction) -> f64 {
        let slope = if direction == self.direction { self.slope } else { 0.0 };
        self.level_mnm[direction as usize] + slope * velocity_rad_s
    }
}

/// The velocity at the end of a substep without dry friction: momentum over mass.
struct Free {
    /// Momentum, mNm·s.
    momentum: f64,
    /// Inertia with what coupling and damping add to it over the substep, mNm·s²/rad.
    mass: f64,
    /// Torque on the body if it were at rest at the end, mNm.
    load_mnm: f64,
}

impl<'model> InnerBody<'model> {
    /// An inner body at rest in the middle of its gap under a cap at `angle_rad`.
    ///
    /// `knob` gives inertia, friction and detents; its own coupling is not looked at.
    pub(crate) fn at_rest(knob: &'model Model, coupling: Coupling, angle_rad: f64) -> Self {
        let [cap_inertia, inertia] = coupling.inertias(knob.inertia());
        let inertia = inertia.max(f64::MIN_POSITIVE);
        Self {
            effects: SortedEffects::of(knob),
            karnopp_limits: knob.karnopp_limits(),
            coupling,
            bristles: knob.bristles(),
            inertia,
            cap_inertia,
            resonance_rad_s: (coupling.stiffness_mnm_rad / inertia).sqrt(),
            largest_phase_rad: PHASE,
            angle_rad,
            velocity_rad_s: 0.0,
            deflection: 0.0,
        }
    }

    /// An inner body under a cap that bears a torque. On a shaft it turns with the cap, behind it by the twist; in a gap the torque does not show
    /// where it is, so it rests in the middle.
    pub(crate) fn under(knob: &'model Model, coupling: Coupling, cap: &Motion, torque_mnm: f64) -> Self {
        let body = Self::at_rest(knob, coupling, cap.angle_rad);
        if coupling.half_gap_rad > 0.0 {
            return body;
        }
        let angle_rad = cap.angle_rad - (torque_mnm - body.cap_mnm(cap)) / coupling.stiffness_mnm_rad;
        Self { angle_rad, velocity_rad_s: cap.velocity_rad_s, ..body }
    }

    pub(crate) fn at_resolution(self, resolution: Resolution) -> Self {
        let largest_phase_rad = if resolution == Resolution::Full { PHASE } else { SLOW_PHASE };
        Self { largest_phase_rad, ..self }
    }

    /// Torque on the cap now, mNm.
    pub(crate) fn torque_mnm(&self, cap: &Motion) -> f64 {
        self.coupling.torque_mnm(cap.angle_rad - self.angle_rad, cap.velocity_rad_s - self.velocity_rad_s)
    }

    /// Torque that the cap's own inertia takes, mNm.
    pub(crate) fn cap_mnm(&self, cap: &Motion) -> f64 {
        self.cap_inertia * cap.acceleration_rad_s2
    }

    /// Number of substeps that a sample takes.
    fn substeps(&self, sample_s: f64) -> u32 {
        (self.resonance_rad_s * sample_s / self.largest_phase_rad).ceil().clamp(SUBSTEPS, 16.0) as u32
    }

    /// Moves on to the next sample, the cap going there evenly accelerated.
    ///
    /// Detents, springs and levels of friction are taken at the angle expected half a sample later and held over the sample: unlike
    /// contact and sticking, they change slowly compared with a sample.
    pub(crate) fn advance(&mut self, from: &Motion, to: &Motion) {
        Self::advance_together(std::array::from_mut(self), from, to);
    }

    /// Moves several bodies on under one motion of their caps.
    ///
    /// A substep depends on the one before it but not on those of other bodies, so that the processor overlaps the bodies' substeps.
    pub(crate) fn advance_together<const BODIES: usize>(bodies: &mut [Self; BODIES], from: &Motion, to: &Motion) {
        let sample_s = to.time_s - from.time_s;
        let held = bodies.each_ref().map(|body| body.held(sample_s, from, to));
        let substeps = bodies.each_ref().map(|body| body.substeps(sample_s));
        let shares = substeps.map(|substeps| 1.0 / f64::from(substeps));
        let turning = |share: f64| from.velocity_rad_s + share * (to.velocity_rad_s - from.velocity_rad_s);
        for index in 0..substeps.into_iter().max().unwrap_or(0) {
            for (((body, held), substeps), share) in bodies.iter_mut().zip(&held).zip(substeps).zip(shares) {
                if index < substeps {
                    let passed = f64::from(index) * share;
                    let cap_rad = from.angle_rad + passed * (to.angle_rad - from.angle_rad);
                    body.substep(share * sample_s, cap_rad, turning(passed + 0.5 * share), held);
                }
            }
        }
    }

    fn held(&self, sample_s: f64, from: &Motion, to: &Motion) -> Held {
        let cap_rad_s = 0.5 * (from.velocity_rad_s + to.velocity_rad_s);
        let at = |velocity_rad_s| Motion {
            time_s: from.time_s + 0.5 * sample_s,
            angle_rad: self.angle_rad + 0.5 * sample_s * self.velocity_rad_s,
            velocity_rad_s,
            acceleration_rad_s2: 0.0,
        };
        // If a body at rest starts to turn, it turns in the cap's direction.
        let turning_rad_s = if self.velocity_rad_s == 0.0 { cap_rad_s } else { self.velocity_rad_s };
        let direction = Direction::of(turning_rad_s);
        let Friction { level_mnm, sliding_mnm } = self.effects.friction(&at(turning_rad_s), direction);
        let slope = (sliding_mnm - level_mnm[direction as usize]) / turning_rad_s;
        let now = at(self.velocity_rad_s);
        Held {
            inertia: self.inertia + self.effects.further_inertia(now.angle_rad),
            free_mnm: self.effects.free_torque_mnm(&now),
            place_mnm: self.effects.rubbing_place_torque_mnm(&now),
            limits: self.karnopp_limits.at_least(level_mnm),
            level_mnm,
            direction,
            slope: if slope.is_finite() { slope } else { 0.0 },
        }
    }

    #[inline]
    fn substep(&mut self, step_s: f64, cap_rad: f64, cap_rad_s: f64, held: &Held) {
        let free = self.without_dry_friction(step_s, cap_rad, cap_rad_s, held);
        let end_rad_s = match self.bristles {
            Some(bristles) => self.bent_end_rad_s(bristles, step_s, &free, held),
            None => self.dry_end_rad_s(step_s, &free, held),
        };
        let turned_rad = 0.5 * step_s * (self.velocity_rad_s + end_rad_s);
        self.deflection = self.bristles.map_or(0.0, |bristles| bristles.bent(self.deflection, turned_rad));
        self.angle_rad += turned_rad;
        self.velocity_rad_s = end_rad_s;
    }

    #[inline]
    fn without_dry_friction(&self, step_s: f64, cap_rad: f64, cap_rad_s: f64, held: &Held) -> Free {
        let Coupling { half_gap_rad, stiffness_mnm_rad, damping, .. } = self.coupling;
        let velocity = self.velocity_rad_s;
        let ahead_rad = cap_rad - self.angle_rad;
        let beyond_rad = ahead_rad - ahead_rad.clamp(-half_gap_rad, half_gap_rad);
        let touching = half_gap_rad == 0.0 || beyond_rad != 0.0;
        let pulls = half_gap_rad > 0.0
            && (stiffness_mnm_rad * beyond_rad + damping * (cap_rad_s - velocity)) * beyond_rad < 0.0;
        let implicit = if touching && !pulls { stiffness_mnm_rad * step_s / 2.0 + damping } else { 0.0 };
        let spring_mnm = if implicit > 0.0 { stiffness_mnm_rad * beyond_rad } else { 0.0 };
        let load_mnm = spring_mnm + implicit * (cap_rad_s - 0.5 * velocity) - held.free_mnm;
        let momentum = held.inertia * velocity + step_s * load_mnm;
        Free { momentum, mass: held.inertia + 0.5 * step_s * implicit, load_mnm }
    }

    #[inline]
    fn dry_end_rad_s(&self, step_s: f64, free: &Free, held: &Held) -> f64 {
        let velocity = self.velocity_rad_s;
        let frictionless = free.momentum / free.mass;
        let limits = &held.limits;
        let bears = (-limits.negative_mnm..=limits.positive_mnm).contains(&free.load_mnm);
        if velocity == 0.0 && bears {
            return 0.0;
        }
        // The velocity at which friction acts must have the direction that it opposes.
        let sliding_rad_s = if velocity * frictionless > 0.0 { velocity } else { 0.0 };
        let direction = Direction::of(frictionless);
        let braked = frictionless - step_s * held.friction_mnm(sliding_rad_s, direction) / free.mass;
        let braked = braked + self.less_load_friction_rad_s(step_s, braked, direction, free, held);
        let sticks = bears && velocity.abs() > limits.velocity_rad_s && braked.abs() <= limits.velocity_rad_s;
        if braked * frictionless > 0.0 && !sticks { braked } else { 0.0 }
    }

    /// Correction of a sliding body's velocity at the end of a substep, rad/s: the friction in `held` counts the load of detents and
    /// springs only, but the torque of the body's inertia is part of the load too.
    #[inline]
    fn less_load_friction_rad_s(
        &self,
        step_s: f64,
        end_rad_s: f64,
        direction: Direction,
        free: &Free,
        held: &Held,
    ) -> f64 {
        let friction = direction.sign() * self.effects.load_friction;
        if friction == 0.0 {
            return 0.0;
        }
        // The coupling takes up a part of the braking torque: only the share inertia / mass of it acts on the inertia.
        let of_inertia = friction * held.inertia / free.mass;
        let inertial_mnm = held.inertia * (end_rad_s - self.velocity_rad_s) / step_s;
        let both_mnm = inertial_mnm + held.place_mnm + of_inertia * held.place_mnm.abs();
        let load_mnm = balanced_load_mnm(both_mnm, of_inertia);
        step_s * friction * (held.place_mnm.abs() - load_mnm.abs()) / free.mass
    }

    fn bent_end_rad_s(&self, bristles: Bristles, step_s: f64, free: &Free, held: &Held) -> f64 {
        let velocity = self.velocity_rad_s;
        let level_mnm = held.friction_mnm(0.0, Direction::of(self.deflection)).abs();
        let bent_mnm = self.deflection * level_mnm;
        let direction = if velocity == 0.0 { Direction::of(free.load_mnm - bent_mnm) } else { Direction::of(velocity) };
        let yielding = 1.0 - direction.sign() * self.deflection;
        let stiffness_mnm_rad = level_mnm * yielding / bristles.deflection_rad;
        let implicit = 0.5 * step_s * stiffness_mnm_rad + bristles.damping * yielding;
        let rest_mnm = held.friction_mnm(velocity, direction) - held.friction_mnm(0.0, direction);
        let momentum = free.momentum - step_s * (bent_mnm + rest_mnm + 0.5 * implicit * velocity);
        momentum / (free.mass + 0.5 * step_s * implicit)
    }
}
