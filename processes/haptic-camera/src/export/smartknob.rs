//! A model as SmartKnob's configuration, the message `SmartKnobConfig` of `proto/smartknob.proto` (github scottbez1/smartknob).

use anyhow::anyhow;
use dynamics::effects::end_stop;
use dynamics::{Model, knobs};
use serde::Serialize;
use simulators::left_out_by_mnm;

use super::ExportOptions;
use super::firmware::stiffest_end_stop_mnm_rad;
use super::simulator::motion;
use super::torque_over_angle::TorqueOverAngle;
use crate::outcome::UsageError;
use crate::outputs::write_json;
use crate::smartknob::{SmartKnob, Turned, V_PER_RAD};

/// Width of the positions of a knob without detents, as the firmware's own ones have it.
const WIDTH_DEG: f64 = 10.0;
/// A knob changes over to its next detent half way.
const SNAP_POINT: f64 = 0.5;
/// Longest text that the firmware takes, bytes.
const LONGEST_TEXT: usize = 50;

/// What is written: the message, in protobuf's own JSON, and what it leaves out.
#[derive(Serialize)]
struct Exported {
    smartknob_config: SmartKnob,
    motor_mnm_per_v: f64,
    /// RMS torque that is left out along the motion.
    left_out_rms_mnm: f64,
    along: String,
    left_out: Vec<String>,
}

/// Writes the configuration; gives what it leaves out, in words.
pub(super) fn write(options: &ExportOptions) -> anyhow::Result<String> {
    let motor_mnm_per_v = options.motor_mnm_per_v.ok_or_else(|| {
        UsageError(anyhow!("SmartKnob's strengths are in volts; give the motor's torque per volt as --motor-mnm-per-v"))
    })?;
    let model = knobs::named(&options.source)?;
    anyhow::ensure!(model.axis.is_rotary(), "{} has a linear axis; a SmartKnob is rotary", model.name);
    let table = TorqueOverAngle::of(&model, options.points, None).ok().filter(|table| table.is_period);
    let rest = table.as_ref().and_then(|table| table.rest);
    let width_deg = rest.zip(table.as_ref()).map_or(WIDTH_DEG, |(_, table)| table.span_rad.to_degrees());
    let strength = |stiffness_mnm_rad: f64| stiffness_mnm_rad / (V_PER_RAD * motor_mnm_per_v);
    let middle_rad = rest.map_or(0.0, |rest| rest.angle_rad);
    let [first, positions] = positions(&model, middle_rad, width_deg.to_radians());
    let knob = SmartKnob {
        num_positions: u32::try_from(positions).unwrap_or(0),
        // The firmware counts against the angle.
        position: (positions - 1 + first).max(0),
        position_width_radians: width_deg.to_radians(),
        detent_strength_unit: rest.map_or(0.0, |rest| strength(rest.stiffness_mnm_rad)),
        endstop_strength_unit: stiffest_end_stop_mnm_rad(&model).map_or(0.0, strength),
        snap_point: SNAP_POINT,
        // As much of it as the firmware takes.
        text: model.name[..model.name.floor_char_boundary(LONGEST_TEXT)].to_owned().into(),
    };
    let (motions, along) = motion(options, model.axis)?;
    let first_rad = middle_rad + f64::from(first) * knob.position_width_radians;
    let mut turned = Turned { knob: &knob, position: -first };
    let said: Vec<f64> =
        motions.iter().map(|motion| motor_mnm_per_v * turned.volts_at(motion.angle_rad - first_rad)).collect();
    let exported = Exported {
        left_out_rms_mnm: left_out_by_mnm(&model, &said, &motions),
        left_out: left_out(&model, table.as_ref()),
        motor_mnm_per_v,
        along,
        smartknob_config: knob,
    };
    write_json(model.axis, &Some(options.out.clone()), &exported)?;
    let mut words = format!("leaves out {:.6} mNm RMS along {}", exported.left_out_rms_mnm, exported.along);
    words.extend(exported.left_out.iter().map(|left_out| format!("\n- {left_out}")));
    Ok(words)
}

/// The first position between the end stops, counted from that at angle zero, and how many there are; none without stops.
fn positions(model: &Model, middle_rad: f64, width_rad: f64) -> [i32; 2] {
    let Some(stop) = model.effect(end_stop::KIND.name) else { return [0, 0] };
    let [low_rad, high_rad, ..] = *stop.values() else { return [0, 0] };
    let first = ((low_rad - middle_rad) / width_rad).ceil() as i32;
    let last = ((high_rad - middle_rad) / width_rad).floor() as i32;
    [first, last.saturating_sub(first).saturating_add(1).max(1)]
}

/// What a spring towards the middle of each position does not say.
fn left_out(model: &Model, table: Option<&TorqueOverAngle>) -> Vec<String> {
    let detents = table.map(|table| table.effects.as_slice()).unwrap_or_default();
    let shape =
        detents.iter().map(|name| format!("the shape of {name}: approximated by linear springs with a dead zone"));
    let others = model.effects.iter().map(|effect| effect.kind().name);
    let others = others.filter(|name| !detents.contains(name) && *name != end_stop::KIND.name);
    shape.chain(others.map(str::to_owned)).collect()
}
