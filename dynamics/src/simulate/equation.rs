//! The equations of motion of a knob of one body or two.

use super::SimulationError;
use super::runge_kutta::Place;
use super::twist::Twist;
use crate::model::balanced_load_mnm;
use crate::{Bristles, Coupling, Direction, Model, Motion, StickLimits};

/// Share of a knob's inertia below which a cap counts as having none: rounding of 1 − share.
const WEIGHTLESS: f64 = 1e-9;

/// What moves the knob's bodies.
#[derive(Clone, Debug)]
pub(super) struct Equation<'model> {
    model: &'model Model,
    /// Inertia of what friction acts on.
    inertia: f64,
    bristles: Option<Bristles>,
    cap: Option<Cap>,
}

/// The body that the torque acts on, where friction acts on another.
#[derive(Clone, Debug)]
struct Cap {
    /// Inertia, or `None` where the acceleration is given instead of the torque.
    inertia: Option<f64>,
    coupling: Coupling,
}

/// A body that slides in one direction since it was at an angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sliding {
    pub(super) direction: Direction,
    pub(super) from_rad: f64,
    /// Deflection of the bristles there.
    pub(super) deflection: f64,
}

impl<'model> Equation<'model> {
    /// The equations and, where the cap has no inertia of its own, the shaft that it twists.
    pub(super) fn of(model: &'model Model, added_inertia: f64) -> Result<(Self, Option<Twist>), SimulationError> {
        let total = model.inertia();
        let coupling = model.coupling();
        let [cap, inner] = coupling.map_or([0.0, total], |coupling| coupling.inertias(total));
        let outer = cap + added_inertia;
        let weightless = outer.abs() <= WEIGHTLESS * total;
        let (inertia, cap, twist) = match coupling {
            None => (total + added_inertia, None, None),
            Some(coupling) if weightless && coupling.half_gap_rad == 0.0 => (inner, None, Some(Twist::of(&coupling))),
            Some(coupling) if outer > 0.0 && !weightless => (inner, Some(Cap { inertia: Some(outer), coupling }), None),
            Some(_) => return Err(SimulationError::WeightlessCap { inertia: outer }),
        };
        if inertia > 0.0 && inertia.is_finite() {
            Ok((Self { model, inertia, bristles: model.bristles(), cap }, twist))
        } else {
            Err(SimulationError::NoInertia { inertia })
        }
    }

    /// The equations of an inner body whose cap has a given motion: they take the cap's acceleration in the place of the torque on it.
    pub(super) fn led(model: &'model Model, coupling: Coupling) -> Result<Self, SimulationError> {
        let [_, inertia] = coupling.inertias(model.inertia());
        if inertia > 0.0 && inertia.is_finite() {
            Ok(Self { model, inertia, bristles: model.bristles(), cap: Some(Cap { inertia: None, coupling }) })
        } else {
            Err(SimulationError::NoInertia { inertia })
        }
    }

    pub(super) fn has_cap(&self) -> bool {
        self.cap.is_some()
    }

    /// Torque on the body on which friction acts; `torque_mnm` acts on the knob and is ignored where there is a cap.
    fn driving_mnm(&self, place: &Place, torque_mnm: f64) -> f64 {
        let passed_on = |cap: &Cap| cap.coupling.torque_mnm(place[2] - place[0], place[3] - place[1]);
        self.cap.as_ref().map_or(torque_mnm, passed_on)
    }

    /// Derivatives by time of the state vector `place`; `sliding` is `None` at rest.
    pub(super) fn rates(&self, time_s: f64, place: &Place, torque_mnm: f64, sliding: Option<&Sliding>) -> Place {
        let driving_mnm = self.driving_mnm(place, torque_mnm);
        let (velocity, acceleration) = sliding.map_or((0.0, 0.0), |sliding| {
            let motion = Motion { time_s, angle_rad: place[0], velocity_rad_s: place[1], acceleration_rad_s2: 0.0 };
            let resisting = self.model.free_torque_mnm(&motion) + self.friction_mnm(&motion, sliding);
            let inertia = self.inertia + self.model.inertia_at(place[0]) - self.model.inertia();
            let net_mnm =
                driving_mnm - resisting + self.inertial_load_friction_mnm(&motion, sliding, driving_mnm - resisting);
            (place[1], net_mnm / inertia)
        });
        let cap =
            |cap: &Cap| (place[3], cap.inertia.map_or(torque_mnm, |inertia| (torque_mnm - driving_mnm) / inertia));
        let (cap_velocity, cap_acceleration) = self.cap.as_ref().map_or((0.0, 0.0), cap);
        [velocity, acceleration, cap_velocity, cap_acceleration]
    }

    /// Correction of the net torque, mNm, for inertia as a part of the load. `net_mnm`, the net torque without the correction,
    /// counts the friction of the load as if the acceleration were zero.
    fn inertial_load_friction_mnm(&self, motion: &Motion, sliding: &Sliding, net_mnm: f64) -> f64 {
        let coefficient = self.model.load_friction();
        if coefficient == 0.0 {
            return 0.0;
        }
        let (place_mnm, sign) = (self.model.place_torque_mnm(motion), sliding.direction.sign());
        let both_mnm = net_mnm + place_mnm + sign * coefficient * place_mnm.abs();
        let load_mnm = balanced_load_mnm(both_mnm, sign * coefficient);
        sign * coefficient * (place_mnm.abs() - load_mnm.abs())
    }

    fn friction_mnm(&self, motion: &Motion, sliding: &Sliding) -> f64 {
        let Some(bristles) = self.bristles else { return self.model.friction_mnm(motion, sliding.direction) };
        let bent = self.deflection(sliding, motion.angle_rad);
        self.model.bristled_friction_mnm(bristles, motion, bent, sliding.direction)
    }

    /// Deflection of the bristles after sliding to an angle.
    ///
    /// This is [`Bristles::bent`], continued smoothly to angles before the start, which the stages of a step may evaluate.
    pub(super) fn deflection(&self, sliding: &Sliding, angle_rad: f64) -> f64 {
        let Some(bristles) = self.bristles else { return sliding.deflection };
        let slipping = sliding.direction.sign();
        let turned_rad = slipping * (angle_rad - sliding.from_rad);
        slipping + (sliding.deflection - slipping) * (-turned_rad / bristles.deflection_rad).exp()
    }

    /// What a body at rest bears: nothing where bristles give way.
    pub(super) fn limits(&self, time_s: f64, angle_rad: f64) -> StickLimits {
        if self.bristles.is_some() {
            return StickLimits::default();
        }
        self.model.stick_limits(&Motion { time_s, angle_rad, ..Motion::default() })
    }

    /// The direction in which a body at rest breaks away, if it does.
    pub(super) fn breakaway(&self, time_s: f64, place: &Place, torque_mnm: f64, deflection: f64) -> Option<Direction> {
        let still = Motion { time_s, angle_rad: place[0], ..Motion::default() };
        let bent_mnm = if self.bristles.is_some() { self.model.bent_friction_mnm(&still, deflection) } else { 0.0 };
        let at_rest = [place[0], 0.0, place[2], place[3]];
        let load = self.driving_mnm(&at_rest, torque_mnm) - self.model.free_torque_mnm(&still) - bent_mnm;
        let limits = self.limits(time_s, place[0]);
        if load > limits.positive_mnm {
            Some(Direction::Positive)
        } else if load < -limits.negative_mnm {
            Some(Direction::Negative)
        } else {
            None
        }
    }
}
