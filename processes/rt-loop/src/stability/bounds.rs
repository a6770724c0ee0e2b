//! What can be rendered on a rig, as numbers.

use dynamics::{Axis, Calibration, Coordinate, Direction, Effect, Model, Motion};
use hal::Limits;

use super::contact::Contact;
use super::port::{Hands, LinearModel, Port};
use crate::control::rendering::RenderGains;

/// A model that passes what the rig can render.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value:.4} {unit}, but the rig renders at most {bound:.4} {unit}: {remedy}")]
pub struct BoundExceeded {
    /// What passes its bound.
    pub what: Bounded,
    /// Its value in the model.
    pub value: f64,
    /// The nearest that would do.
    pub bound: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// What to change.
    pub remedy: String,
}

/// What has a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounded {
    /// Inertia of the whole.
    Inertia,
    /// Inertia of the cap of a knob of two bodies.
    CapInertia,
    /// Rise of torque over speed.
    Damping,
    /// Rise of torque over angle.
    Stiffness,
    /// Torque.
    Torque,
    /// Stiffness of what joins two bodies, at its damping.
    Contact,
}

impl std::fmt::Display for Bounded {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Inertia => "the inertia",
            Self::CapInertia => "the inertia of the cap",
            Self::Damping => "the steepest rise of torque over speed",
            Self::Stiffness => "the steepest rise of torque over angle",
            Self::Torque => "the largest torque",
            Self::Contact => "the stiffness of contact or shaft",
        })
    }
}

/// What can be rendered without any hand of the class being able to make it swing, and within the motor's torque.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    port: Port,
    hands: Hands,
    /// See [`dynamics::Axis::fingertip_travel`].
    fingertip_travel: f64,
    /// Least inertia: rotor and gripper, mNm·s²/rad.
    pub least_inertia: f64,
    /// Largest torque, mNm.
    pub largest_torque_mnm: f64,
}

/// Share of the motor's torque that may be the model's: the rest holds against noise and the hand.
const MODEL_SHARE: f64 = 0.9;
/// Share that is permitted of the bounds from zero exclusion: the calibration is known to some per cent.
const SAFETY: f64 = 0.8;

impl Bounds {
    /// The bounds of a rig under these gains.
    #[must_use]
    pub fn of(gains: &RenderGains, calibration: &Calibration, limits: &Limits, rate_hz: f64) -> Self {
        Self {
            port: Port::new(*gains, calibration, rate_hz),
            hands: Hands::on(calibration.axis),
            fingertip_travel: calibration.axis.fingertip_travel(),
            least_inertia: calibration.motor_inertia + calibration.gripper_inertia,
            largest_torque_mnm: MODEL_SHARE * limits.motor_torque_mnm,
        }
    }

    /// The bounds of a rig that takes a torque so much later, s.
    #[must_use]
    pub fn delayed(self, by_s: f64) -> Self {
        Self { port: self.port.delayed(by_s), ..self }
    }

    /// Whether no hand of the class can make a sticking body swing, nor a body of the least inertia.
    #[must_use]
    pub fn holds_rest(&self) -> bool {
        let least = LinearModel::Sliding { inertia: self.least_inertia, damping: 0.0, stiffness_mnm_rad: 0.0 };
        self.port.is_safe(&LinearModel::Stuck, &self.hands) && self.port.is_safe(&least, &self.hands)
    }

    /// Largest inertia at this damping, mNm·s²/rad: one that no hand of the class makes swing, and that the motor can give the
    /// accelerations of a hand.
    #[must_use]
    pub fn largest_inertia(&self, damping: f64) -> f64 {
        let of_motor = self.largest_torque_mnm / (FASTEST_RAD_S2 * self.fingertip_travel);
        let safe = self.largest(self.least_inertia, 10.0 / self.fingertip_travel.powi(2), |inertia| {
            LinearModel::Sliding { inertia, damping, stiffness_mnm_rad: 0.0 }
        });
        safe.min(of_motor)
    }

    /// Largest rise of torque with speed at this inertia, mNm·s/rad.
    #[must_use]
    pub fn largest_damping(&self, inertia: f64) -> f64 {
        let square = self.fingertip_travel.powi(2);
        self.largest(1e-3 / square, 1e3 / square, |damping| LinearModel::Sliding {
            inertia,
            damping,
            stiffness_mnm_rad: 0.0,
        })
    }

    /// Steepest rise of torque with angle at this inertia and damping, mNm/rad.
    #[must_use]
    pub fn largest_stiffness_mnm_rad(&self, inertia: f64, damping: f64) -> f64 {
        let square = self.fingertip_travel.powi(2);
        self.largest(1.0 / square, 1e5 / square, |stiffness_mnm_rad| LinearModel::Sliding {
            inertia,
            damping,
            stiffness_mnm_rad,
        })
    }

    /// The largest value such that every value up to it on a ladder of 2 % steps is safe, less the margin.
    fn largest(&self, from: f64, to: f64, of: impl Fn(f64) -> LinearModel) -> f64 {
        let mut safe = 0.0;
        let mut value = from;
        while value <= to && self.port.is_safe(&of(value), &self.hands) {
            safe = value;
            value *= 1.02;
        }
        SAFETY * safe
    }

    /// Checks a model against the bounds; gives sentences on where the rendering will feel different from the model.
    ///
    /// # Errors
    /// [`BoundExceeded`] for the first bound that the model passes.
    pub fn check(&self, model: &Model) -> Result<Vec<String>, BoundExceeded> {
        let demands = Demands::of(model);
        let inertia = model.inertia();
        let at_most = |what, value: f64, bound: f64, unit, remedy: &str| {
            if value.is_finite() && value <= bound {
                Ok(())
            } else {
                Err(BoundExceeded { what, value, bound, unit, remedy: remedy.to_owned() })
            }
        };
        // `largest_inertia` tries inertias from the least one on, so its damping must be one that the least inertia permits.
        let damping = demands.least_damping.min(self.largest_damping(self.least_inertia));
        at_most(Bounded::Inertia, inertia, self.largest_inertia(damping), "mNm·s²/rad", "lower `inertia`")?;
        let of_speed = || format!("lower `{}`", steepest_over_speed(model).unwrap_or("viscous_positive"));
        let bound = self.largest_damping(inertia);
        at_most(Bounded::Damping, demands.largest_damping, bound, "mNm·s/rad", &of_speed())?;
        let bound = self.largest_stiffness_mnm_rad(inertia, demands.least_damping + demands.coulomb_damping(inertia));
        let remedy = "lower the amplitude, widen the period or add friction";
        at_most(Bounded::Stiffness, demands.stiffness_mnm_rad, bound, "mNm/rad", remedy)?;
        let remedy = if demands.speed_mnm > 0.5 * demands.torque_mnm {
            of_speed()
        } else {
            "lower the amplitude, the static or the Coulomb friction".to_owned()
        };
        at_most(Bounded::Torque, demands.torque_mnm, self.largest_torque_mnm, "mNm", &remedy)?;
        self.check_contact(model, &demands)?;
        let drives = demands.drives_from_rad_s.map(|speed_rad_s| {
            format!("friction would drive the knob above {speed_rad_s:.1} rad/s; it is set to zero there")
        });
        Ok(drives.into_iter().collect())
    }
}

impl Bounds {
    /// Checks what joins the bodies of a model of two.
    fn check_contact(&self, model: &Model, demands: &Demands) -> Result<(), BoundExceeded> {
        let Some(contact) = self.contact(model, demands) else { return Ok(()) };
        let bound = self.largest_inertia(0.0);
        let exceeded = |what, value, bound, unit, remedy: &str| {
            Err(BoundExceeded { what, value, bound, unit, remedy: remedy.to_owned() })
        };
        if contact.cap_inertia > bound {
            let remedy = if contact.half_gap_rad == 0.0 {
                "lower `inertia` or `shaft_outer_share`"
            } else {
                "lower `inertia` or raise `backlash_inner_share`"
            };
            return exceeded(Bounded::CapInertia, contact.cap_inertia, bound, "mNm·s²/rad", remedy);
        }
        let value = contact.stiffness_mnm_rad;
        let bound = contact.stiffest_mnm_rad(&self.port, &self.hands, SAFETY, value);
        if bound < value {
            let remedy = "lower it, or change the damping next to it";
            return exceeded(Bounded::Contact, value, bound, "mNm/rad", remedy);
        }
        Ok(())
    }

    /// What detents and springs of a model leave of the largest torque, mNm; below zero where they pass it.
    #[must_use]
    pub fn room_for_friction_mnm(&self, model: &Model) -> f64 {
        self.largest_torque_mnm - Demands::of(model).free_mnm
    }

    fn contact(&self, model: &Model, demands: &Demands) -> Option<Contact> {
        let dampings = [demands.least_damping, demands.least_damping + demands.coulomb_damping(model.inertia())];
        let coupling = model.coupling()?;
        Some(Contact::new(&coupling, model.inertia(), self.least_inertia, dampings, demands.stiffness_mnm_rad))
    }

    /// Stiffness, mNm/rad, and damping, mNm·s/rad, of contact or shaft that are nearest to the model's and can be rendered; the
    /// stiffness is zero where none can. `None` for a model of one body.
    #[must_use]
    pub fn nearest_contact(&self, model: &Model) -> Option<[f64; 2]> {
        let demands = Demands::of(model);
        let contact = self.contact(model, &demands)?;
        let most_damping = self.largest_damping(contact.cap_inertia);
        Some(contact.nearest(&self.port, &self.hands, SAFETY, most_damping))
    }
}

/// Angles at which torques that depend on angle and velocity are looked at, either way.
const ANGLES: i32 = 500;

/// Steepest rise over speed of the torques that depend on angle and velocity, an end stop's, summed over the effects,
/// mNm·s/rad.
fn damping_in_contact(model: &Model) -> f64 {
    let depends_on_both = |effect: &&Effect| {
        [Coordinate::Angle, Coordinate::Velocity].iter().all(|on| effect.kind().depends_on.contains(on))
    };
    let travel = model.axis.fingertip_travel();
    let steepest = |effect: &Effect| {
        let rise = |angle_rad: f64, speed_rad_s: f64| {
            let at =
                |velocity_rad_s| effect.free_torque_mnm(&Motion { angle_rad, velocity_rad_s, ..Motion::default() });
            ((at(speed_rad_s) - at(0.0)) / speed_rad_s).max((at(0.0) - at(-speed_rad_s)) / speed_rad_s)
        };
        let angles = (-ANGLES..=ANGLES).map(|step| f64::from(step) / f64::from(ANGLES) * looked_at(model.axis));
        angles.map(|angle_rad| rise(angle_rad, travel * FASTEST_RAD_S / f64::from(SPEEDS))).fold(0.0, f64::max)
    };
    model.effects.iter().filter(depends_on_both).map(steepest).sum()
}

/// The parameter whose share in the steepest rise of torque over speed is the largest.
fn steepest_over_speed(model: &Model) -> Option<&'static str> {
    let demands = |effect: &Effect| {
        let alone = Model { effects: vec![*effect], axis: model.axis, ..Model::default() };
        Demands::of(&alone).largest_damping
    };
    let steepest = model.effects.iter().map(|effect| (effect, demands(effect)));
    let (effect, _) = steepest.filter(|(_, damping)| *damping > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let of_speed = effect.parameters().filter(|(parameter, _)| parameter.unit.starts_with("mNm s"));
    of_speed.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(parameter, _)| parameter.name)
}

/// Speed from which a model's friction would drive the knob instead of braking it, rad/s; `None` where it never does.
#[must_use]
pub fn driving_speed_rad_s(model: &Model) -> Option<f64> {
    Demands::of(model).drives_from_rad_s
}

/// What a model demands of a rig.
struct Demands {
    stiffness_mnm_rad: f64,
    least_damping: f64,
    largest_damping: f64,
    /// Least Coulomb friction of either direction, mNm.
    coulomb_mnm: f64,
    free_mnm: f64,
    torque_mnm: f64,
    /// What the fastest speeds add to friction, mNm.
    speed_mnm: f64,
    /// Speed from which friction would drive instead of brake, rad/s.
    drives_from_rad_s: Option<f64>,
}

/// How far a model is looked at either way: a turn, rad, or nearly twice the way of a dome, mm.
fn looked_at(axis: Axis) -> f64 {
    match axis {
        Axis::Rotary => std::f64::consts::TAU,
        Axis::Linear => 6.0,
    }
}

/// Step of looking, rad: a thirtieth of the finest detent that a finger counts.
const LOOKED_AT_STEP_RAD: f64 = 2e-4;
/// Fastest that a hand turns a knob, rad/s.
pub(crate) const FASTEST_RAD_S: f64 = 40.0;
/// Largest acceleration that a hand gives a knob, rad/s²: 0.25 rad at 10 Hz, the fastest voluntary motion of fingers.
const FASTEST_RAD_S2: f64 = 1_000.0;
/// Speeds looked at, each way.
const SPEEDS: u32 = 400;

impl Demands {
    fn of(model: &Model) -> Self {
        let step_rad = LOOKED_AT_STEP_RAD * model.axis.fingertip_travel();
        let steps = (looked_at(model.axis) / step_rad) as i32;
        let (mut free_mnm, mut held_mnm) = (0.0_f64, 0.0_f64);
        for step in -steps..=steps {
            let motion = Motion { angle_rad: f64::from(step) * step_rad, ..Motion::default() };
            let torque_mnm = model.place_torque_mnm(&motion);
            free_mnm = free_mnm.max(torque_mnm.abs());
            let limits = model.stick_limits(&motion);
            held_mnm = held_mnm.max(limits.negative_mnm).max(limits.positive_mnm);
        }
        let mut demands = Self {
            stiffness_mnm_rad: model.steepest_stiffness_mnm_rad(),
            least_damping: f64::INFINITY,
            largest_damping: 0.0,
            coulomb_mnm: f64::INFINITY,
            free_mnm,
            torque_mnm: 0.0,
            speed_mnm: 0.0,
            drives_from_rad_s: None,
        };
        let sliding_mnm = [Direction::Negative, Direction::Positive].map(|to| demands.look_at_speeds(model, to));
        demands.least_damping = demands.least_damping.max(0.0);
        demands.largest_damping += damping_in_contact(model);
        demands.torque_mnm = free_mnm + held_mnm.max(sliding_mnm[0]).max(sliding_mnm[1]);
        demands
    }

    /// Takes in friction and drag in one direction; gives the largest of their sum, mNm.
    fn look_at_speeds(&mut self, model: &Model, direction: Direction) -> f64 {
        let motion = |speed_rad_s: f64| Motion { velocity_rad_s: direction.sign() * speed_rad_s, ..Motion::default() };
        let friction_mnm = |speed_rad_s| direction.sign() * model.friction_mnm(&motion(speed_rad_s), direction);
        // Where the model's friction is negative, none is rendered.
        let braking_mnm =
            |speed_rad_s| friction_mnm(speed_rad_s).max(0.0) + direction.sign() * model.drag_mnm(&motion(speed_rad_s));
        let step_rad_s = model.axis.fingertip_travel() * FASTEST_RAD_S / f64::from(SPEEDS);
        let mut before_mnm = braking_mnm(0.0);
        let mut largest_mnm = before_mnm;
        self.coulomb_mnm = self.coulomb_mnm.min(before_mnm);
        for step in 1..=SPEEDS {
            let speed_rad_s = f64::from(step) * step_rad_s;
            let now_mnm = braking_mnm(speed_rad_s);
            if friction_mnm(speed_rad_s) < 0.0 {
                self.drives_from_rad_s =
                    Some(self.drives_from_rad_s.map_or(speed_rad_s, |known| known.min(speed_rad_s)));
            }
            let slope = (now_mnm - before_mnm) / step_rad_s;
            self.least_damping = self.least_damping.min(slope);
            self.largest_damping = self.largest_damping.max(slope);
            largest_mnm = largest_mnm.max(now_mnm);
            before_mnm = now_mnm;
        }
        self.speed_mnm = self.speed_mnm.max(largest_mnm - braking_mnm(0.0));
        largest_mnm
    }

    /// Damping equivalent to Coulomb friction for a swing as wide as a well of the torque, mNm·s/rad: its describing function,
    /// the way in which Coulomb friction enters the bounds of N. Diolaiti, G. Niemeyer, F. Barbagli and J. K. Salisbury,
    /// *Stability of haptic rendering: discretization, quantization, time delay, and Coulomb effects*, IEEE Trans. Robotics 22,
    /// 2006.
    fn coulomb_damping(&self, inertia: f64) -> f64 {
        if self.stiffness_mnm_rad == 0.0 {
            return 0.0;
        }
        let swing_rad = std::f64::consts::PI * self.free_mnm / self.stiffness_mnm_rad;
        let omega = (self.stiffness_mnm_rad / inertia).sqrt();
        4.0 * self.coulomb_mnm / (std::f64::consts::PI * swing_rad * omega)
    }
}
