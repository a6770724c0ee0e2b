//! The renderable model nearest to one that the rig cannot render.

use dynamics::{Coordinate, Effect, EffectKind, Model, Part};

use crate::admission::{Admission, Admitted};
use crate::control::rendering::Unrenderable;
use crate::plan::PlanError;
use crate::stability::{BoundExceeded, Bounded, FASTEST_RAD_S};

/// A model that the rig can render, and what it took.
#[derive(Clone, Debug)]
pub struct Nearest {
    /// The model.
    pub model: Model,
    /// Ready for the renderer.
    pub admitted: Admitted,
    /// What was changed, from what to what, in sentences; empty where nothing had to be.
    pub clipped: Vec<String>,
}

/// Most bounds that are met one after the other: each moves others.
const ROUNDS: u32 = 40;
/// How far a value stays inside its bound, as a share: rounding.
const INSIDE: f64 = 1e-9;
/// Further factor on a quantity whose bound moves with it.
const MOVING: f64 = 0.99;

impl Admission {
    /// The model itself, or one with inertia, friction, stiffness and torque clipped to what the rig renders. The bounds are met one
    /// by one, each by a change of the bounded quantity alone.
    ///
    /// If the inertia in front of a gap is too small, it is raised and the inner inertia stays. A contact becomes as stiff as
    /// possible, with no more damping than that takes. Too large a torque is first taken off viscous friction and off what the knob
    /// bears at rest. Effects that have no place in the renderer are left out.
    ///
    /// # Errors
    /// The refusal, if the model does not come inside the bounds by these changes.
    pub fn nearest(&self, model: &Model) -> Result<Nearest, PlanError> {
        let mut tried = model.clone();
        for _ in 0..ROUNDS {
            match self.admit(&tried) {
                Ok(admitted) => return Ok(nearest(model, tried, admitted)),
                Err(error) => {
                    let changed = match &error {
                        PlanError::Unrenderable(error) => make_renderable(&mut tried, error),
                        PlanError::Unsafe(error) => self.meet(&mut tried, error),
                        _ => false,
                    };
                    if !changed {
                        return Err(error);
                    }
                }
            }
        }
        self.admit(&tried).map(|admitted| nearest(model, tried, admitted))
    }

    /// Brings the quantity that exceeds a bound back to it; `false` where no parameter of the model does that.
    fn meet(&self, model: &mut Model, exceeded: &BoundExceeded) -> bool {
        let BoundExceeded { what, value, bound, .. } = *exceeded;
        if !value.is_finite() {
            return false;
        }
        let share = bound / value * (1.0 - INSIDE);
        match what {
            Bounded::Inertia => set_inertia(model, share * model.inertia()),
            Bounded::CapInertia => set_cap(model, share * value),
            Bounded::Damping => {
                let several = model.effects.iter().any(is_drag);
                change(model, |kind, _, unit, value| match kind.part {
                    Part::Friction(_) if unit == "mNm s/rad" && !several => value.min(bound * (1.0 - INSIDE)),
                    _ if unit.starts_with("mNm s") && kind.depends_on.contains(&Coordinate::Velocity) => share * value,
                    _ => value,
                })
            }
            Bounded::Stiffness => scale_torques(model, share * MOVING),
            Bounded::Torque => {
                let room_mnm = (1.0 - INSIDE) * self.room_for_friction_mnm(model);
                lower_torque(model, room_mnm, share)
            }
            Bounded::Contact => {
                let Some([stiffness_mnm_rad, damping]) = self.nearest_contact(model) else { return false };
                let own = model.coupling().map_or(0.0, |coupling| coupling.stiffness_mnm_rad);
                // An unchanged stiffness would be refused again.
                let stiffness_mnm_rad = stiffness_mnm_rad.min(own * (1.0 - INSIDE));
                stiffness_mnm_rad > 0.0
                    && change(model, |kind, _, unit, value| match (kind.part, unit) {
                        (Part::Coupling(_), "mNm/rad") => stiffness_mnm_rad,
                        (Part::Coupling(_), "mNm s/rad") => damping,
                        _ => value,
                    })
            }
        }
    }
}

/// Whether its torque depends on velocity and is no friction.
fn is_drag(effect: &Effect) -> bool {
    matches!(effect.kind().part, Part::Torque(_)) && effect.kind().depends_on.contains(&Coordinate::Velocity)
}

fn make_renderable(model: &mut Model, error: &Unrenderable) -> bool {
    match *error {
        Unrenderable::Effect { effect } | Unrenderable::Joints { effect, .. } => leave_out(model, effect),
        Unrenderable::Inertia { least, .. } => set_inertia(model, least),
        Unrenderable::Cap { inertia, share, .. } => set_inertia(model, inertia) && set_share(model, share),
        Unrenderable::Inner { share } => set_share(model, share),
    }
}

fn leave_out(model: &mut Model, effect: &str) -> bool {
    let last = model.effects.iter().rposition(|known| known.kind().name == effect);
    last.map(|index| model.effects.remove(index)).is_some()
}

/// Gives every parameter the value that `of` makes of its kind, name, unit and value; says whether any changed.
fn change(model: &mut Model, of: impl Fn(&EffectKind, &str, &str, f64) -> f64) -> bool {
    let mut changed = false;
    for effect in &mut model.effects {
        let kind = effect.kind();
        for (parameter, value) in kind.parameters.iter().zip(effect.values_mut()) {
            let new = of(kind, parameter.name, parameter.unit, *value);
            changed |= new != *value;
            *value = new;
        }
    }
    changed
}

/// Scales a model's inertia to this value, or gives it one.
fn set_inertia(model: &mut Model, inertia: f64) -> bool {
    let now = model.inertia();
    if now > 0.0 {
        let times = inertia / now;
        return change(model, |kind, _, _, value| if let Part::Inertia(_) = kind.part { times * value } else { value });
    }
    let without = |effect: &Effect| !matches!(effect.kind().part, Part::Inertia(_));
    model.effects.retain(without);
    model.effects.insert(0, Effect::new(&dynamics::effects::inertia::KIND, &[inertia]));
    true
}

fn set_share(model: &mut Model, share: f64) -> bool {
    change(model, |_, name, _, value| match name {
        "backlash_inner_share" => share,
        "shaft_outer_share" => 1.0 - share,
        _ => value,
    })
}

/// Gives the cap before the inner body another inertia; the inner body keeps its own.
fn set_cap(model: &mut Model, cap: f64) -> bool {
    let inner = model.coupling().map_or(0.0, |coupling| coupling.inertias(model.inertia())[1]);
    set_inertia(model, cap + inner) && set_share(model, inner / (cap + inner))
}

/// Scales all torques of the angle by `share`, so that they keep their shape.
fn scale_torques(model: &mut Model, share: f64) -> bool {
    change(model, |kind, name, unit, value| {
        let of_angle = kind.steepest_mnm_rad.is_some() && (unit.starts_with("mNm") || name == "table_scale");
        if of_angle { share * value } else { value }
    })
}

/// Lowers friction to `room_mnm`, which detents and springs leave: at rest the torque that the knob bears, and at a hand's fastest
/// motion the viscous part. Where that changes nothing, as when Coulomb friction alone is larger, scales all torques by `share`.
fn lower_torque(model: &mut Model, room_mnm: f64, share: f64) -> bool {
    let borne = change(model, |kind, _, unit, value| match (kind.part, unit) {
        (Part::Stick(_), "mNm") if room_mnm > 0.0 => value.min(room_mnm),
        _ => value,
    });
    let mut viscous = false;
    let fastest_rad_s = FASTEST_RAD_S * model.axis.fingertip_travel();
    for effect in &mut model.effects {
        if effect.kind().name == dynamics::effects::friction::KIND.name
            && let [coulomb_negative, coulomb_positive, viscous_negative, viscous_positive] = effect.values_mut()
        {
            for (coulomb_mnm, damping) in [(coulomb_negative, viscous_negative), (coulomb_positive, viscous_positive)] {
                let most = (room_mnm - *coulomb_mnm) / fastest_rad_s;
                if most > 0.0 && *damping > most {
                    *damping = most;
                    viscous = true;
                }
            }
        }
    }
    if borne || viscous {
        return true;
    }
    let torques = scale_torques(model, share);
    change(model, |kind, _, unit, value| match (kind.part, unit) {
        (Part::Stick(_), "mNm") | (Part::Friction(_), "mNm" | "mNm s/rad") => share * value,
        (Part::Torque(_), unit) if kind.depends_only_on(Coordinate::Velocity) && unit.starts_with("mNm") => {
            share * value
        }
        _ => value,
    }) || torques
}

/// What became of `asked`, with a note at every effect that was changed.
fn nearest(asked: &Model, mut model: Model, admitted: Admitted) -> Nearest {
    let mut clipped = Vec::new();
    for effect in &asked.effects {
        let name = effect.kind().name;
        let Some(rendered) = model.effects.iter_mut().find(|known| known.kind().name == name) else {
            clipped.push(format!("{name} is left out: the renderer does not support it"));
            continue;
        };
        let changes: Vec<String> = effect
            .parameters()
            .zip(rendered.values())
            .filter(|((_, from), to)| from != *to)
            .map(|((parameter, from), to)| {
                let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
                format!("{} = {}{unit} instead of {}", parameter.name, rounded(*to), rounded(from))
            })
            .collect();
        if !changes.is_empty() {
            let origin = rendered.origin().map_or_else(String::new, |origin| format!("{origin}; "));
            *rendered = rendered.with_origin(&format!("{origin}clipped to the rig's limits: {}", changes.join(", ")));
            clipped.extend(changes);
        }
    }
    if asked.inertia() == 0.0 {
        clipped.push(format!("inertia = {} mNm s²/rad instead of none", rounded(model.inertia())));
    }
    if !clipped.is_empty() {
        model.name = format!("{}, the nearest within the rig's limits", model.name);
    }
    Nearest { model, admitted, clipped }
}

/// Four significant digits.
fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = (3.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
