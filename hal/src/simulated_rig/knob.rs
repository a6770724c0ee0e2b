//! The mounted knob: what friction, stick, bristles and detents act on, and what lies between that and the gripper.

use dynamics::{Coupling, Direction, Model, Motion, Part};

use super::RigParameters;
use super::bristles::BentBristles;
use super::contact::{Braked, Contact, Friction, KnobFriction, Sliding};
use super::inner::{Cap, InnerBody, Load, Reaction, Touch};

/// Least inertia of an inner body, mNm·s²/rad: a thousandth of what the lightest knob of the paper has.
const LEAST_INNER_INERTIA: f64 = 2e-6;

/// The knob with its state.
#[derive(Debug)]
pub(super) struct Knob {
    substep_s: f64,
    coast_speed_rad_s: f64,
    stick_velocity_rad_s: f64,
    model: Model,
    cap_inertia: f64,
    inner: Option<InnerBody>,
    bristles: Option<BentBristles>,
    contact: Contact,
    /// Acceleration, over the last substep, of what friction acts on, rad/s².
    acceleration_rad_s2: f64,
}

impl Knob {
    pub(super) fn new(parameters: &RigParameters, model: Model) -> Self {
        let inertia = model.inertia();
        let mut coupling: Option<Coupling> = None;
        let mut bristles = None;
        for effect in &model.effects {
            match effect.kind().part {
                // Lost motion and a shaft that twists both: the gap's contact is the softer of the two in series.
                Part::Coupling(of) => coupling = Some(in_series(coupling, of(effect.values()))),
                Part::Bristles(of) => bristles = Some(BentBristles::new(of(effect.values()))),
                _ => {}
            }
        }
        let inner_inertia = coupling.map_or(0.0, |coupling| inertia * coupling.inner_share.clamp(0.0, 1.0));
        Self {
            substep_s: parameters.substep_s(),
            coast_speed_rad_s: parameters.speed_limit_rad_s,
            stick_velocity_rad_s: model.stick_limits(&Motion::default()).velocity_rad_s,
            model,
            cap_inertia: inertia - inner_inertia,
            inner: coupling.map(|coupling| {
                InnerBody::new(&coupling, inner_inertia.max(LEAST_INNER_INERTIA), parameters.substep_s())
            }),
            bristles,
            contact: Contact::Stuck,
            acceleration_rad_s2: 0.0,
        }
    }

    /// Inertia that is fast to the gripper, mNm·s²/rad.
    pub(super) fn cap_inertia(&self) -> f64 {
        self.cap_inertia
    }

    /// Whether friction holds it at rest; bristles always give a little.
    pub(super) fn is_stuck(&self) -> bool {
        self.bristles.is_none() && self.contact == Contact::Stuck
    }

    /// Angle, rad, and velocity, rad/s, of what friction and detents act on.
    pub(super) fn inner_motion(&self, cap: &Cap) -> (f64, f64) {
        self.inner.map_or((cap.angle_rad, cap.velocity_rad_s), |inner| (inner.angle_rad, inner.velocity_rad_s))
    }

    /// A substep that begins at `time_s`, with the torque sensor's spring at `sensor_mnm` and a hand's torque on the cap.
    pub(super) fn begin(&self, time_s: f64, cap: Cap, sensor_mnm: f64, hand_mnm: f64) -> LoadStep<'_> {
        let motion = self.middle_of_substep(time_s, &cap);
        let free_mnm = -self.model.free_torque_mnm(&motion);
        let friction = KnobFriction {
            knob: &self.model,
            motion,
            coast_speed_rad_s: self.coast_speed_rad_s,
            light: self.inner.is_some(),
        };
        let dry = if let Some(bristles) = &self.bristles {
            Dry::Bent(bristles.bending(&friction, self.substep_s))
        } else {
            let mut braked = Braked::new(self.contact, friction);
            let driving_mnm = free_mnm + self.inner.map_or(sensor_mnm + hand_mnm, |inner| inner.passed_on_mnm(&cap));
            if let Some(braking_mnm) = self.coming_to_rest_mnm(&cap, driving_mnm, &braked.friction) {
                (braked.braking_mnm, braked.drag) = (braking_mnm, 0.0);
            }
            Dry::Sticking(braked)
        };
        let touch = self.inner.map_or(Touch::Apart, |inner| inner.touch(cap.angle_rad));
        LoadStep { knob: self, cap, hand_mnm, free_mnm, dry, touch }
    }

    /// Motion of what friction acts on in the middle of the substep to come, as far as it can be predicted.
    fn middle_of_substep(&self, time_s: f64, cap: &Cap) -> Motion {
        let half_s = self.substep_s / 2.0;
        let (angle_rad, velocity_rad_s) = self.inner_motion(cap);
        Motion {
            time_s: time_s + half_s,
            angle_rad: angle_rad + half_s * velocity_rad_s,
            velocity_rad_s: velocity_rad_s + half_s * self.acceleration_rad_s2,
            acceleration_rad_s2: self.acceleration_rad_s2,
        }
    }

    /// Karnopp's rule: a knob that has become slower than its stick velocity, and that its static
    /// friction can hold, is brought to rest by that friction.
    fn coming_to_rest_mnm(&self, cap: &Cap, driving_mnm: f64, friction: &KnobFriction<'_>) -> Option<f64> {
        let Contact::Sliding(direction) = self.contact else { return None };
        if self.inner_motion(cap).1.abs() >= self.stick_velocity_rad_s {
            return None;
        }
        let limits = friction.limits();
        let holds = (-limits.negative_mnm..=limits.positive_mnm).contains(&driving_mnm);
        holds.then_some(match direction {
            Direction::Negative => -limits.negative_mnm,
            Direction::Positive => limits.positive_mnm,
        })
    }

    /// Goes to the end of a substep.
    pub(super) fn advance(&mut self, ended: &Ended) {
        self.contact = ended.contact.settled(ended.end_rad_s, self.stick_velocity_rad_s);
        self.acceleration_rad_s2 = (ended.end_rad_s - ended.start_rad_s) / self.substep_s;
        if let Some(bristles) = &mut self.bristles {
            bristles.turn(0.5 * self.substep_s * (ended.start_rad_s + ended.end_rad_s));
        }
        if let Some(inner) = &mut self.inner {
            inner.advance(ended.end_rad_s);
        }
    }
}

/// The coupling of two that follow each other.
fn in_series(first: Option<Coupling>, second: Coupling) -> Coupling {
    let Some(first) = first else { return second };
    let stiffness_mnm_rad =
        first.stiffness_mnm_rad * second.stiffness_mnm_rad / (first.stiffness_mnm_rad + second.stiffness_mnm_rad);
    Coupling {
        half_gap_rad: first.half_gap_rad + second.half_gap_rad,
        inner_share: first.inner_share.min(second.inner_share),
        stiffness_mnm_rad,
        damping: first.damping.min(second.damping),
    }
}

/// The friction of a substep.
enum Dry<'a> {
    Sticking(Braked<KnobFriction<'a>>),
    Bent(Sliding),
}

/// What the knob is to the shaft over a substep.
pub(super) struct LoadStep<'a> {
    knob: &'a Knob,
    cap: Cap,
    hand_mnm: f64,
    /// Torque of detents and the like on the body that they act on, mNm.
    free_mnm: f64,
    dry: Dry<'a>,
    touch: Touch,
}

/// What goes into the cap's equation.
pub(super) struct OntoCap {
    /// Torque on the cap, mNm.
    pub(super) applied_mnm: f64,
    /// Whether friction holds the cap.
    pub(super) at_rest: bool,
    pub(super) reaction: Reaction,
}

/// How a substep ended for what friction acts on.
pub(super) struct Ended {
    contact: Contact,
    start_rad_s: f64,
    end_rad_s: f64,
}

impl LoadStep<'_> {
    /// What detents and friction do to the body that they act on.
    fn load(&self) -> Load {
        let (sliding, at_rest) = match &self.dry {
            Dry::Sticking(braked) => (Sliding { braking_mnm: braked.braking_mnm, drag: braked.drag }, braked.at_rest()),
            Dry::Bent(sliding) => (*sliding, false),
        };
        Load { applied_mnm: self.free_mnm - sliding.braking_mnm, drag: sliding.drag, at_rest }
    }

    pub(super) fn onto_cap(&self) -> OntoCap {
        let load = self.load();
        match &self.knob.inner {
            Some(inner) => OntoCap {
                applied_mnm: self.hand_mnm,
                at_rest: false,
                reaction: inner.onto_cap(self.touch, &self.cap, &load),
            },
            None => OntoCap {
                applied_mnm: self.hand_mnm + load.applied_mnm,
                at_rest: load.at_rest,
                reaction: Reaction::of_drag(load.drag, self.cap.velocity_rad_s, self.knob.substep_s),
            },
        }
    }

    /// Corrects contacts that turned out otherwise in a substep after which the cap has the velocity `cap_end_rad_s`,
    /// or at rest bears `cap_holding_mnm`; says whether it did.
    pub(super) fn correct(&mut self, cap_end_rad_s: f64, cap_holding_mnm: f64) -> bool {
        let (end_rad_s, holding_mnm, otherwise) = match &self.knob.inner {
            None => (cap_end_rad_s, cap_holding_mnm, None),
            Some(inner) => {
                let end = inner.end(self.touch, &self.cap, &self.load(), cap_end_rad_s);
                (end.velocity_rad_s, end.holding_mnm, end.otherwise)
            }
        };
        self.touch = otherwise.unwrap_or(self.touch);
        let stuck_otherwise = match &mut self.dry {
            Dry::Sticking(braked) => braked.correct(end_rad_s, holding_mnm),
            Dry::Bent(_) => false,
        };
        otherwise.is_some() | stuck_otherwise
    }

    pub(super) fn ended(&self, cap_end_rad_s: f64) -> Ended {
        let start_rad_s = self.knob.inner_motion(&self.cap).1;
        let end_rad_s = self.knob.inner.map_or(cap_end_rad_s, |inner| {
            inner.end(self.touch, &self.cap, &self.load(), cap_end_rad_s).velocity_rad_s
        });
        let contact = match &self.dry {
            Dry::Sticking(braked) => braked.contact,
            Dry::Bent(_) => Contact::Sliding(Direction::of(end_rad_s)),
        };
        Ended { contact, start_rad_s, end_rad_s }
    }
}
