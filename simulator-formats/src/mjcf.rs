//! MuJoCo's MJCF (<https://mujoco.readthedocs.io/en/stable/XMLreference.html>), for MuJoCo 4.0.
//!
//! | here | in MJCF |
//! |---|---|
//! | inertia | `armature` of the hinge: the knob's body has as good as no mass |
//! | Coulomb friction | `frictionloss`, half of the sum; half of the difference is a constant torque, at rest too, which is the same |
//! | viscous friction, drag | `damping`, a polynomial b₀ + b₁·|v|; the mean of both directions |
//! | sinusoids of the angle | passive motors `dcmotor input="none"` with `cogging`, each amplitude·sin(n·θ + phase) |
//! | bristles | a passive motor with `lugre` in place of `frictionloss`: σ₀ = C/z₀ |
//! | spring, end stops | `stiffness` and `springref`, `range` |
//! | backlash, soft shaft | a second hinge, and between the two a tendon with `range`, or with `stiffness` and `damping` |

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use dynamics::Model;

use crate::joint::{Joint, Sine, of_mjcf};
use crate::said::{Export, LinearAxis, left_out, said};
use crate::xml::{attribute, comment, si};

/// Step of the simulation, s: a sample of most captures.
const TIMESTEP_S: f64 = 1e-4;
/// Mass and moments of the bodies, which MuJoCo wants above zero: far below any knob's.
const NEXT_TO_NOTHING: f64 = 1e-12;

/// The model as a whole MJCF file: one knob on a hinge along z.
///
/// # Errors
/// [`LinearAxis`].
pub fn mjcf(model: &Model) -> Result<Export, LinearAxis> {
    let joint = Joint::of(model)?;
    let viscous = Joint::mean(joint.viscous);
    // Bristles bend alike in both directions; a constant torque beside them would bend them at rest.
    let mean_mnm = Joint::mean(joint.coulomb_mnm);
    let coulomb_mnm = if joint.bristles.is_some() { [mean_mnm; 2] } else { joint.coulomb_mnm };
    let said = said(model, &of_mjcf(), coulomb_mnm, viscous);
    let mut left_out = left_out(model, &said, &joint);
    if joint.coupling.is_some_and(|coupling| coupling.half_gap_rad > 0.0) {
        left_out.push("the stiffness of the backlash's contacts".to_owned());
    }
    let mut text = String::new();
    let _ = writeln!(
        text,
        "<!-- {}, made by haptic-camera {}. SI units: N m, rad, s.",
        comment(&model.name),
        env!("CARGO_PKG_VERSION")
    );
    if !left_out.is_empty() {
        let _ = writeln!(text, "     Left out: {}.", comment(&left_out.join("; ")));
    }
    let _ = write!(
        text,
        "-->\n<mujoco model=\"{}\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
         <option timestep=\"{TIMESTEP_S}\" gravity=\"0 0 0\" integrator=\"implicitfast\"/>\n  <worldbody>\n",
        attribute(&model.name)
    );
    bodies(&joint, viscous, &mut text);
    text.push_str("  </worldbody>\n");
    tendon(&joint, &mut text);
    actuators(&joint, &mut text);
    text.push_str("</mujoco>\n");
    Ok(Export { content: text, said, left_out })
}

/// The hinge that is turned, and behind backlash or a soft shaft the one that friction and detents act on.
fn bodies(joint: &Joint, viscous: f64, text: &mut String) {
    let mut own = format!(" damping=\"{}", si(viscous));
    if joint.quadratic_drag != 0.0 {
        let _ = write!(own, " {}", si(joint.quadratic_drag));
    }
    own.push('"');
    let friction_mnm = Joint::mean(joint.coulomb_mnm);
    if joint.bristles.is_none() && friction_mnm > 0.0 {
        // The friction of a sliding knob is then its Coulomb friction.
        let _ = write!(own, " frictionloss=\"{}\" {}", si(friction_mnm), stiff("friction"));
    }
    if let Some([stiffness, centre_rad]) = joint.spring {
        let _ = write!(own, " stiffness=\"{}\" springref=\"{centre_rad}\"", si(stiffness));
    }
    let range = joint.range_rad.map(|[lower, upper]| format!(" range=\"{lower} {upper}\"")).unwrap_or_default();
    match joint.coupling {
        None => body("knob", joint.inertia, &format!("{own}{range}"), text),
        Some(coupling) => {
            let [cap, inner] = coupling.inertias(joint.inertia);
            body("knob", cap, "", text);
            body("inner", inner, &format!("{own}{range}"), text);
        }
    }
}

/// A constraint as stiff as the step permits.
fn stiff(constraint: &str) -> String {
    format!("solref{constraint}=\"{} 1\" solimp{constraint}=\"0.9999 0.9999 0.001\"", 2.0 * TIMESTEP_S)
}

fn body(name: &str, inertia: f64, attributes: &str, text: &mut String) {
    let _ = write!(
        text,
        "    <body name=\"{name}\">\n      <joint name=\"{name}\" type=\"hinge\" axis=\"0 0 1\" armature=\"{}\"{attributes}/>\n      \
         <inertial pos=\"0 0 0\" mass=\"{NEXT_TO_NOTHING}\" diaginertia=\"{NEXT_TO_NOTHING} {NEXT_TO_NOTHING} {NEXT_TO_NOTHING}\"/>\n    \
         </body>\n",
        si(inertia)
    );
}

fn tendon(joint: &Joint, text: &mut String) {
    let Some(coupling) = joint.coupling else { return };
    let way = if coupling.half_gap_rad > 0.0 {
        format!("range=\"{} {}\" {}", -coupling.half_gap_rad, coupling.half_gap_rad, stiff("limit"))
    } else {
        format!(
            "stiffness=\"{}\" damping=\"{}\" springlength=\"0\"",
            si(coupling.stiffness_mnm_rad),
            si(coupling.damping)
        )
    };
    let _ = write!(
        text,
        "  <tendon>\n    <fixed name=\"coupling\" {way}>\n      <joint joint=\"knob\" coef=\"1\"/>\n      \
         <joint joint=\"inner\" coef=\"-1\"/>\n    </fixed>\n  </tendon>\n"
    );
}

fn actuators(joint: &Joint, text: &mut String) {
    let mut sines = joint.sines.clone();
    let difference_mnm = 0.5 * (joint.coulomb_mnm[1] - joint.coulomb_mnm[0]);
    // Unequal Coulomb levels are their mean and a constant torque: a sine of wavenumber zero.
    if difference_mnm != 0.0 && joint.bristles.is_none() {
        sines.push(Sine { amplitude_mnm: difference_mnm, per_rad: 0.0, phase_rad: FRAC_PI_2 });
    }
    if sines.is_empty() && joint.bristles.is_none() {
        return;
    }
    let on = if joint.coupling.is_some() { "inner" } else { "knob" };
    // Without a motor constant the windings carry no current: what is left acts on the joint alone.
    let passive = format!("joint=\"{on}\" input=\"none\" motorconst=\"0\" resistance=\"1\"");
    text.push_str("  <actuator>\n");
    for (number, Sine { amplitude_mnm, per_rad, phase_rad }) in (1..).zip(&sines) {
        // A motor's torque acts on the joint; ours is what the joint takes.
        let _ = writeln!(
            text,
            "    <dcmotor name=\"angle-torque-{number}\" {passive} cogging=\"{} {per_rad} {phase_rad}\"/>",
            si(-amplitude_mnm)
        );
    }
    if let Some(bristles) = joint.bristles {
        let coulomb_mnm = Joint::mean(joint.coulomb_mnm);
        let _ = writeln!(
            text,
            "    <dcmotor name=\"bristles\" {passive} lugre=\"{} {} {coulomb} {coulomb} 1\"/>",
            si(coulomb_mnm / bristles.deflection_rad),
            si(bristles.damping),
            coulomb = si(coulomb_mnm)
        );
    }
    text.push_str("  </actuator>\n");
}
