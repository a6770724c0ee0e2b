//! URDF (<http://wiki.ros.org/urdf/XML/joint>): one joint with `dynamics` and, where the knob has end stops, `limit`.

use std::fmt::Write as _;

use dynamics::Model;

use crate::joint::{Joint, of_urdf};
use crate::said::{Export, LinearAxis, left_out, said};
use crate::xml::{attribute, comment, si};

/// Largest torque and speed of the joint, which URDF wants beside a range: more than any hand's. N m, rad/s.
const LARGEST: [f64; 2] = [10.0, 1000.0];

/// The model as a whole URDF file: a base, and a knob on a joint along z.
///
/// # Errors
/// [`LinearAxis`].
pub fn urdf(model: &Model) -> Result<Export, LinearAxis> {
    let joint = Joint::of(model)?;
    let (coulomb_mnm, viscous) = (Joint::mean(joint.coulomb_mnm), Joint::mean(joint.viscous));
    let said = said(model, &of_urdf(), [coulomb_mnm; 2], viscous);
    let left_out = left_out(model, &said, &joint);
    let mut text = String::new();
    let _ = writeln!(
        text,
        "<?xml version=\"1.0\"?>\n<!-- {}, made by haptic-camera {}. SI units: N m, rad, s.",
        comment(&model.name),
        env!("CARGO_PKG_VERSION")
    );
    if !left_out.is_empty() {
        let _ = writeln!(text, "     Left out: {}.", comment(&left_out.join("; ")));
    }
    let kind = if joint.range_rad.is_some() { "revolute" } else { "continuous" };
    let _ = write!(
        text,
        "-->\n<robot name=\"{}\">\n  <link name=\"base\"/>\n  <link name=\"knob\">\n    <inertial>\n      <mass value=\"0.001\"/>\n      \
         <inertia ixx=\"{inertia}\" ixy=\"0\" ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/>\n    </inertial>\n  </link>\n  \
         <joint name=\"knob\" type=\"{kind}\">\n    <parent link=\"base\"/>\n    <child link=\"knob\"/>\n    <axis xyz=\"0 0 1\"/>\n    \
         <dynamics damping=\"{}\" friction=\"{}\"/>\n",
        attribute(&model.name),
        si(viscous),
        si(coulomb_mnm),
        inertia = si(joint.inertia),
    );
    if let Some([lower, upper]) = joint.range_rad {
        let [effort, velocity] = LARGEST;
        let _ = writeln!(
            text,
            "    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\" velocity=\"{velocity}\"/>"
        );
    }
    text.push_str("  </joint>\n</robot>\n");
    Ok(Export { content: text, said, left_out })
}
