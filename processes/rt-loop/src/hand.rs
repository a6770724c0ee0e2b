//! The hand on the simulated rig, as the options ask for it.

use std::path::Path;

use dynamics::{Drive, Excitation};
use hal::simulated::{Grip, Hand, Intention};

use crate::plan::{Options, PlanError};

/// Time after which the hand begins to move, s: the run begins some tenths of a second after the amplifier was switched on.
const HAND_BEGINS_S: f64 = 0.5;

/// The hand on the simulated rig; `None` when nobody holds the gripper.
pub(crate) fn hand(options: &Options) -> Result<Option<Hand>, PlanError> {
    let unusable = |reason: String| PlanError::Hand(reason);
    if !(options.grip.is_finite() && options.grip > 0.0) {
        return Err(unusable(format!("a grip of {} must be more than zero, and finite", options.grip)));
    }
    let usual = Grip::default();
    let grip = Grip {
        damping: options.grip * usual.damping,
        stiffness_mnm_rad: options.grip * usual.stiffness_mnm_rad,
        ..usual
    };
    let intention = match (options.hand_torque, options.hand.as_str()) {
        (Some(torque_mnm), _) if torque_mnm.is_finite() => Intention::Torque(torque_mnm),
        (Some(torque_mnm), _) => return Err(unusable(format!("a torque of {torque_mnm} mNm is no torque"))),
        (None, "none") => return Ok(None),
        (None, file) if Path::new(file).extension().is_some_and(|extension| extension == "csv") => {
            recorded_motion(Path::new(file)).map_err(unusable)?
        }
        (None, sweep) => {
            let motion = Excitation::named(sweep, Drive::Position)?;
            Intention::Motion(match options.amplitude {
                Some(amplitude) => motion.with_amplitude(amplitude)?,
                None => motion,
            })
        }
    };
    Ok(Some(Hand { grip, intention, begins_s: HAND_BEGINS_S }))
}

/// Reads the columns `t_s` and `angle_rad` of a CSV file of evenly spaced rows.
#[allow(clippy::cast_precision_loss, reason = "a number of rows")]
fn recorded_motion(path: &Path) -> Result<Intention, String> {
    let told = |what: String| format!("{}: {what}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| told(error.to_string()))?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').map(str::trim).collect();
    let column = |name: &str| {
        header.iter().position(|found| *found == name).ok_or_else(|| told(format!("has no column {name}")))
    };
    let (time, angle) = (column("t_s")?, column("angle_rad")?);
    let mut rows = Vec::new();
    for (number, line) in lines.enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.split(',').collect();
        let value = |index: usize| cells.get(index).and_then(|cell| cell.trim().parse::<f64>().ok());
        match (value(time), value(angle)) {
            (Some(time_s), Some(angle_rad)) if time_s.is_finite() && angle_rad.is_finite() => {
                rows.push((time_s, angle_rad));
            }
            _ => return Err(told(format!("row {} has no t_s and angle_rad", number + 2))),
        }
    }
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Err(told("has no rows".to_owned())) };
    let duration_s = last.0 - first.0;
    if rows.len() < 2 || duration_s <= 0.0 {
        return Err(told("needs at least two rows with rising t_s".to_owned()));
    }
    let rate_hz = (rows.len() - 1) as f64 / duration_s;
    let uneven = rows.windows(2).any(|pair| ((pair[1].0 - pair[0].0) * rate_hz - 1.0).abs() > 0.5);
    if uneven {
        return Err(told("its t_s is not evenly spaced; resample it".to_owned()));
    }
    Ok(Intention::Recorded { angle_rad: rows.into_iter().map(|(_, angle_rad)| angle_rad).collect(), rate_hz })
}
