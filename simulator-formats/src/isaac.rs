//! The fields of Isaac Lab's joint friction model (`ActuatorBaseCfg`, <https://isaac-sim.github.io/IsaacLab>), since Isaac Sim 5.

use dynamics::Model;
use serde_json::json;

use crate::joint::Joint;
use crate::said::LinearAxis;

/// JSON whose `actuator` has the fields under their names, in SI units: `ImplicitActuatorCfg(**actuator, stiffness=0.0, …)`.
///
/// `friction` is the torque that breaks the joint away, `dynamic_friction` that of sliding, each the mean of both directions.
///
/// # Errors
/// [`LinearAxis`].
pub fn isaac_lab(model: &Model) -> Result<String, LinearAxis> {
    let joint = Joint::of(model)?;
    let si = |thousandths: f64| 1e-3 * thousandths;
    let fields = json!({
        "made_by": "haptic-camera",
        "actuator": {
            "armature": si(joint.inertia),
            "friction": si(Joint::mean(joint.static_mnm)),
            "dynamic_friction": si(Joint::mean(joint.coulomb_mnm)),
            "viscous_friction": si(Joint::mean(joint.viscous)),
        },
    });
    Ok(format!("{fields:#}\n"))
}
