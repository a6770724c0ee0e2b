//! The hand on the simulated rig, as a request asks for it.

use std::path::Path;

use dynamics::{Axis, Drive, Excitation};
use foreign_files::{Column, OtherColumns, read_columns};
use hal::simulated_rig::{Grip, Hand, Intention};

use crate::plan::PlanError;
use crate::request::HandRequest;

/// Time after which the hand begins to move, s: the run begins some tenths of a second after the amplifier was switched on.
const HAND_BEGINS_S: f64 = 0.5;

/// The hand on the simulated rig of that axis, whose sweep goes to `amplitude_rad`; `None` when nobody holds the gripper.
pub(super) fn hand(asked: &HandRequest, axis: Axis, amplitude_rad: Option<f64>) -> Result<Option<Hand>, PlanError> {
    let unusable = |reason: String| PlanError::Hand(reason);
    let HandRequest { hand, hand_torque, grip } = asked;
    if !(grip.is_finite() && *grip > 0.0) {
        return Err(unusable(format!("a grip of {grip} must be more than zero, and finite")));
    }
    let usual = Grip::on(axis);
    let grip = Grip { damping: grip * usual.damping, stiffness_mnm_rad: grip * usual.stiffness_mnm_rad, ..usual };
    let intention = match (hand_torque, hand.as_str()) {
        (Some(torque_mnm), _) if torque_mnm.is_finite() => Intention::Torque(*torque_mnm),
        (Some(torque_mnm), _) => return Err(unusable(format!("a torque of {torque_mnm} mNm is not a finite number"))),
        (None, "none") => return Ok(None),
        (None, file) if Path::new(file).extension().is_some_and(|extension| extension == "csv") => {
            recorded_motion(Path::new(file)).map_err(unusable)?
        }
        (None, sweep) => {
            let motion = Excitation::named(sweep, Drive::Position)?.on(axis);
            Intention::Motion(match amplitude_rad {
                Some(amplitude_rad) => motion.with_amplitude(amplitude_rad)?,
                None => motion,
            })
        }
    };
    Ok(Some(Hand { grip, intention, begins_s: HAND_BEGINS_S }))
}

/// Reads the columns `t_s` and `angle_rad` of a table of evenly spaced rows.
fn recorded_motion(path: &Path) -> Result<Intention, String> {
    let error = |what: &dyn std::fmt::Display| format!("{}: {what}", path.display());
    let file = foreign_files::open(path).map_err(|source| error(&source))?;
    let wanted = ["t_s", "angle_rad"].map(Column::required);
    let columns = read_columns(file, wanted, OtherColumns::Ignored).map_err(|source| error(&source))?;
    let [t_s, angle_rad] = columns.map(Option::unwrap_or_default);
    let duration_s = t_s.last().zip(t_s.first()).map_or(0.0, |(last, first)| last - first);
    let rate_hz = (t_s.len().max(1) - 1) as f64 / duration_s;
    if !(t_s.len() >= 2 && duration_s > 0.0 && rate_hz.is_finite()) {
        return Err(error(&"it needs at least two rows with rising t_s"));
    }
    if t_s.windows(2).any(|pair| ((pair[1] - pair[0]) * rate_hz - 1.0).abs() > 0.5) {
        return Err(error(&"its t_s is not evenly spaced; resample it"));
    }
    Ok(Intention::Recorded { angle_rad, rate_hz })
}
