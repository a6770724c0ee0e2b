//! A model that can be rendered.

use dynamics::{Calibration, Coupling, Direction, Model, Motion, Part, StickLimits};

use super::joint::Joint;

/// A model as the renderer takes it: on the rig's side of the torque sensor, and never driven by its friction.
#[derive(Clone, Debug)]
pub struct RenderedModel {
    model: Model,
    /// Inertia on the rig's side of the torque sensor, rotor included, mNm·s²/rad.
    inertia: f64,
    /// What joins its two bodies, if it has two.
    joint: Option<Joint>,
    /// The motor's viscous friction, which is felt anyway, mNm·s/rad.
    motor_viscous: f64,
}

/// An inertia with four decimals, or with four digits where it is small.
fn digits(inertia: f64) -> String {
    if inertia < 0.001 { format!("{inertia:.3e}") } else { format!("{inertia:.4}") }
}

/// Why a model cannot be rendered at all, whatever the rig.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unrenderable {
    /// An effect that has no place in the virtual body.
    #[error(
        "the effect '{effect}' cannot be rendered; remove it from the model, or express it as torque, inertia and \
         friction"
    )]
    Effect {
        /// Its name.
        effect: &'static str,
    },
    /// An inertia that the gripper alone already has.
    #[error(
        "an inertia of {inertia} mNm·s²/rad cannot be rendered: gripper and rotor have {least} already; the least \
         possible is inertia = {least}", least = digits(*least)
    )]
    Inertia {
        /// The model's, mNm·s²/rad.
        inertia: f64,
        /// The least that would do, mNm·s²/rad.
        least: f64,
    },
    /// A cap that the gripper alone outweighs.
    #[error(
        "a cap of {cap} mNm·s²/rad before its gap cannot be rendered: gripper and rotor have {least:.4} already; the \
         least possible is inertia = {inertia:.5} with backlash_inner_share = {share:.4}"
    )]
    Cap {
        /// The model's, mNm·s²/rad.
        cap: f64,
        /// The least that would do, mNm·s²/rad.
        least: f64,
        /// The inertia of the whole with such a cap, mNm·s²/rad.
        inertia: f64,
        /// The share of that inertia that is inside.
        share: f64,
    },
    /// An inner body without inertia.
    #[error(
        "an inner body without inertia cannot be rendered; the least possible backlash_inner_share, or 1 − shaft_outer_share, is {share:.2e}"
    )]
    Inner {
        /// The least share that would do.
        share: f64,
    },
    /// More than one gap or shaft.
    #[error("a model with {count} gaps and shafts cannot be rendered, only one; remove '{effect}'")]
    Joints {
        /// How many it has.
        count: usize,
        /// The last one.
        effect: &'static str,
    },
}

/// Least inertia of an inner body, mNm·s²/rad: a thousandth of that of the lightest knob of Swindells and MacLean.
const LEAST_INNER_INERTIA: f64 = 2e-6;

impl RenderedModel {
    /// `model` on a rig with this calibration.
    ///
    /// What a model says of the torque sensor's reading (delay, offset, hum) is not felt and left out.
    ///
    /// # Errors
    /// [`Unrenderable`].
    pub fn new(model: &Model, calibration: &Calibration) -> Result<Self, Unrenderable> {
        let is_not_rendered = |part: Part| matches!(part, Part::Bristles(_) | Part::VaryingInertia(_));
        let unrenderable = model.effects.iter().find(|effect| is_not_rendered(effect.kind().part));
        if let Some(effect) = unrenderable {
            return Err(Unrenderable::Effect { effect: effect.kind().name });
        }
        let joints = || model.effects.iter().filter(|effect| matches!(effect.kind().part, Part::Coupling(_)));
        if let (2.., Some(effect)) = (joints().count(), joints().next_back()) {
            return Err(Unrenderable::Joints { count: joints().count(), effect: effect.kind().name });
        }
        let least = calibration.gripper_inertia + calibration.motor_inertia;
        let joint = joint(model, calibration, least)?;
        if model.inertia() < least {
            return Err(Unrenderable::Inertia { inertia: model.inertia(), least });
        }
        let mut model = model.clone();
        model.effects.retain(|effect| !matches!(effect.kind().part, Part::Reading(_) | Part::ReadingDelay(_)));
        Ok(Self {
            inertia: model.inertia() - calibration.gripper_inertia,
            joint,
            motor_viscous: calibration.motor_viscous.unwrap_or(0.0),
            model,
        })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    pub(super) fn forces(&self) -> Forces<'_> {
        Forces { from: self, to: self, share: 0.0 }
    }
}

/// Relative rounding by which an inertia may be below its least, where a share was computed to give exactly the least.
const ROUNDING: f64 = 1e-9;

/// Inertia of the body in front of a gap or a shaft. In front of a shaft it is at least `least`, the inertia of rotor and gripper,
/// which counts as part of the knob's inertia.
pub(crate) fn cap_inertia(coupling: &Coupling, inertia: f64, least: f64) -> f64 {
    let [own, _] = coupling.inertias(inertia);
    if coupling.half_gap_rad == 0.0 { own.max(least) } else { own }
}

/// The joint between the bodies of a model of two; `None` for a model of one body.
fn joint(model: &Model, calibration: &Calibration, least: f64) -> Result<Option<Joint>, Unrenderable> {
    let Some(coupling) = model.coupling() else { return Ok(None) };
    let inertia = model.inertia();
    let cap = cap_inertia(&coupling, inertia, least);
    let inner = inertia - cap;
    if cap < least * (1.0 - ROUNDING) {
        let [inertia, share] = with_least_cap(inner, least);
        return Err(Unrenderable::Cap { cap, least, inertia, share });
    }
    if inner < LEAST_INNER_INERTIA * (1.0 - ROUNDING) {
        return Err(if cap == least {
            Unrenderable::Inertia { inertia, least: least + LEAST_INNER_INERTIA }
        } else {
            Unrenderable::Inner { share: LEAST_INNER_INERTIA / inertia }
        });
    }
    Ok(Some(Joint {
        cap_inertia: cap.max(least) - calibration.gripper_inertia,
        inner_inertia: inner,
        half_gap_rad: coupling.half_gap_rad,
        stiffness_mnm_rad: coupling.stiffness_mnm_rad,
        damping: coupling.damping,
    }))
}

/// Total inertia, mNm·s²/rad, and its inner share, of a knob with this inner inertia behind the lightest possible cap.
fn with_least_cap(inner: f64, least: f64) -> [f64; 2] {
    let inner = inner.max(LEAST_INNER_INERTIA);
    [least + inner, inner / (least + inner)]
}

/// What a body feels: one model, or two while one gives way to the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces<'a> {
    pub(super) from: &'a RenderedModel,
    pub(super) to: &'a RenderedModel,
    /// Share of the second, from 0 to 1.
    pub(super) share: f64,
}

impl Forces<'_> {
    fn mixed(&self, of: impl Fn(&RenderedModel) -> f64) -> f64 {
        let from = of(self.from);
        if self.share == 0.0 { from } else { from + self.share * (of(self.to) - from) }
    }

    /// Inertia on the rig's side of the torque sensor, mNm·s²/rad.
    pub(super) fn inertia(&self) -> f64 {
        self.mixed(|rendered| rendered.inertia)
    }

    /// What joins the two bodies, unless both models have but one.
    pub(super) fn joint(&self) -> Option<Joint> {
        let of = |rendered: &RenderedModel| (rendered.joint, rendered.inertia);
        if self.share == 0.0 { self.from.joint } else { Joint::between(of(self.from), of(self.to), self.share) }
    }

    /// Torque of detents, springs and the like, mNm.
    pub(super) fn free_mnm(&self, motion: &Motion) -> f64 {
        self.mixed(|rendered| rendered.model.place_torque_mnm(motion))
    }

    /// Friction and drag while sliding in `direction`, mNm, with their sign.
    ///
    /// The motor's viscous friction is subtracted, since it is felt anyway. A fitted law with a negative viscous coefficient drives
    /// beyond some speed; rendered friction never drives. A model without friction still has the motor's, which damps its detents:
    /// their delay gives out energy at every swing (the b of Colgate and Schenkel's b > K·T/2).
    pub(super) fn friction_mnm(&self, motion: &Motion, direction: Direction) -> f64 {
        let sign = direction.sign();
        self.mixed(|rendered| {
            let felt_anyway_mnm = rendered.motor_viscous * motion.velocity_rad_s;
            let taken_mnm = rendered.model.friction_mnm(motion, direction) + rendered.model.drag_mnm(motion);
            sign * (sign * (taken_mnm - felt_anyway_mnm)).max(0.0)
        })
    }

    /// What the body bears at rest.
    pub(super) fn stick_limits(&self, motion: &Motion) -> StickLimits {
        let (from, to) = (self.from.model.stick_limits(motion), self.to.model.stick_limits(motion));
        let between = |from: f64, to: f64| from + self.share * (to - from);
        StickLimits {
            negative_mnm: between(from.negative_mnm, to.negative_mnm),
            positive_mnm: between(from.positive_mnm, to.positive_mnm),
            velocity_rad_s: between(from.velocity_rad_s, to.velocity_rad_s),
        }
    }
}
