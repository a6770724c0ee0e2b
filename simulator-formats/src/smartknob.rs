//! SmartKnob's knobs, as its firmware renders them at rest, the default ones, and models as such knobs.
//!
//! Facts from github scottbez1/smartknob: the list of configurations in `firmware/src/interface_task.cpp`, and the control law in
//! `firmware/src/motor_task.cpp`. The voltage is 4 · strength volt per radian from the middle of the position, beyond a dead zone of a fifth
//! of its width or one degree, whichever is less. `snap_point` widths from the middle, the next position takes over; beyond the ends,
//! the strength is the end stop's. The voltage is at most the supply of 5 V. The firmware does not state the motor's torque per volt.

use std::borrow::Cow;

use dynamics::effects::end_stop;
use dynamics::{Model, Motion};
use serde::Serialize;

use crate::firmware::stiffest_end_stop_mnm_rad;
use crate::said::refuse_linear;
use crate::{LinearAxis, TorqueOverAngle, left_out_by_mnm};

/// Volt per radian and unit of strength.
const V_PER_RAD: f64 = 4.0;
/// Share of a position's width that is without torque …
const DEAD_SHARE: f64 = 0.2;
/// … but at most this angle, rad.
const DEAD_RAD: f64 = std::f64::consts::PI / 180.0;
/// Largest voltage, V.
const SUPPLY_V: f64 = 5.0;
/// Steps from one position to the next.
const STEPS: u32 = 60;
/// Width of the positions of a knob without detents, as the firmware's own ones have it.
const WIDTH_DEG: f64 = 10.0;
/// A knob changes over to its next detent half way.
const SNAP_POINT: f64 = 0.5;
/// Longest text that the firmware takes, bytes.
const LONGEST_TEXT: usize = 50;

/// A configuration of the firmware: the message `SmartKnobConfig` of `proto/smartknob.proto`, field by field.
#[derive(Debug, Serialize)]
pub struct SmartKnob {
    /// Number of positions; 0 for no bounds.
    pub num_positions: u32,
    /// The position that it begins in.
    pub position: i32,
    /// From one position to the next.
    pub position_width_radians: f64,
    /// A quarter of the volts per radian off the middle of a position.
    pub detent_strength_unit: f64,
    /// The same beyond the first and the last position.
    pub endstop_strength_unit: f64,
    /// Widths from the middle at which the position changes.
    pub snap_point: f64,
    /// What the display shows.
    pub text: Cow<'static, str>,
}

const fn knob(
    text: &'static str,
    num_positions: u32,
    width_deg: f64,
    [detent_strength_unit, endstop_strength_unit]: [f64; 2],
    snap_point: f64,
) -> SmartKnob {
    let (position, position_width_radians) = (0, width_deg.to_radians());
    let text = Cow::Borrowed(text);
    SmartKnob {
        num_positions,
        position,
        position_width_radians,
        detent_strength_unit,
        endstop_strength_unit,
        snap_point,
        text,
    }
}

/// The configurations that the firmware ships. The last has detents at 4 of its 32 positions only; one of these is shown.
pub const ALL: [SmartKnob; 10] = [
    knob("Unbounded, no detents", 0, 10.0, [0.0, 1.0], 1.1),
    knob("Bounded 0–10, no detents", 11, 10.0, [0.0, 1.0], 1.1),
    knob("Multi-rev, no detents", 73, 10.0, [0.0, 1.0], 1.1),
    knob("On/off, strong detent", 2, 60.0, [1.0, 1.0], 0.55),
    knob("Return to centre", 1, 60.0, [0.01, 0.6], 1.1),
    knob("Fine values, no detents", 256, 1.0, [0.0, 1.0], 1.1),
    knob("Fine values, with detents", 256, 1.0, [1.0, 1.0], 1.1),
    knob("Coarse values, strong detents", 32, 8.225_806_452, [2.0, 1.0], 1.1),
    knob("Coarse values, weak detents", 32, 8.225_806_452, [0.2, 1.0], 1.1),
    knob("Coarse values, magnetic detents", 32, 7.0, [2.5, 1.0], 0.7),
];

impl SmartKnob {
    /// Angle over which it is shown, rad: four positions at most.
    #[must_use]
    pub fn reach_rad(&self) -> f64 {
        let last = if self.num_positions == 0 { 3 } else { (self.num_positions - 1).min(3) };
        (f64::from(last) + 1.6) * self.position_width_radians
    }

    /// Largest voltage against leaving a position, V.
    #[must_use]
    pub fn peak_v(&self) -> f64 {
        self.volts(self.snap_point * self.position_width_radians, self.detent_strength_unit)
    }

    fn volts(&self, off_rad: f64, strength: f64) -> f64 {
        let dead = (DEAD_SHARE * self.position_width_radians).min(DEAD_RAD);
        (V_PER_RAD * strength * (off_rad - off_rad.clamp(-dead, dead))).clamp(-SUPPLY_V, SUPPLY_V)
    }

    /// The resistance, in volts, to a slow turn from below the first position and back: the first angle and the step of
    /// the angles, rad, then the volts of either way in order of the angle.
    #[must_use]
    pub fn slow_turn(&self) -> ([f64; 2], [Vec<f64>; 2]) {
        let width = self.position_width_radians;
        let step = width / f64::from(STEPS);
        let steps = (0..).take_while(|index| f64::from(*index) * step <= self.reach_rad()).count();
        let first = -0.8 * width;
        let angles: Vec<f64> = (0..steps).map(|index| first + index as f64 * step).collect();
        let mut turned = Turned { knob: self, position: 0 };
        let mut felt = |angle: f64| turned.volts_at(angle);
        let there: Vec<f64> = angles.iter().map(|angle| felt(*angle)).collect();
        let mut back: Vec<f64> = angles.iter().rev().map(|angle| felt(*angle)).collect();
        back.reverse();
        ([first, step], [there, back])
    }
}

/// A knob as it is turned: it keeps its position until the next one's is reached.
struct Turned<'knob> {
    knob: &'knob SmartKnob,
    /// The position that it is in, counted towards positive angle; the middle of position 0 is at angle 0.
    position: i32,
}

impl Turned<'_> {
    /// The volts against leaving the position at that angle, rad.
    fn volts_at(&mut self, angle_rad: f64) -> f64 {
        let knob = self.knob;
        let width = knob.position_width_radians;
        let ends = (knob.num_positions > 0).then(|| [0, i32::try_from(knob.num_positions - 1).unwrap_or(i32::MAX)]);
        let off = |position: i32| angle_rad - f64::from(position) * width;
        if off(self.position) > knob.snap_point * width && ends.is_none_or(|[_, last]| self.position < last) {
            self.position += 1;
        } else if off(self.position) < -knob.snap_point * width && ends.is_none_or(|[first, _]| self.position > first) {
            self.position -= 1;
        }
        let off = off(self.position);
        let beyond =
            ends.is_some_and(|[first, last]| self.position == first && off < 0.0 || self.position == last && off > 0.0);
        knob.volts(off, if beyond { knob.endstop_strength_unit } else { knob.detent_strength_unit })
    }
}

/// A model as a configuration, and what it leaves out.
#[derive(Debug)]
pub struct SmartKnobExport {
    /// The configuration.
    pub knob: SmartKnob,
    /// What a spring towards the middle of each position does not say, in words.
    pub left_out: Vec<String>,
    /// RMS of the torque that is left out along the motion, mNm.
    pub left_out_mnm: f64,
}

/// A model as a configuration for a motor with that torque per volt, and the torque that it leaves out along a motion.
///
/// # Errors
/// [`LinearAxis`].
pub fn smartknob(model: &Model, motor_mnm_per_v: f64, motions: &[Motion]) -> Result<SmartKnobExport, LinearAxis> {
    refuse_linear(model)?;
    let table = TorqueOverAngle::of(model, 1, None).ok().filter(|table| table.is_period);
    let rest = table.as_ref().and_then(|table| table.rest);
    let width_deg = rest.zip(table.as_ref()).map_or(WIDTH_DEG, |(_, table)| table.span_rad.to_degrees());
    let strength = |stiffness_mnm_rad: f64| stiffness_mnm_rad / (V_PER_RAD * motor_mnm_per_v);
    let middle_rad = rest.map_or(0.0, |rest| rest.angle_rad);
    let [first, positions] = positions(model, middle_rad, width_deg.to_radians());
    // Angle zero may lie beyond an end stop.
    let last = (positions - 1).max(0);
    let at_zero = first.saturating_neg().clamp(0, last);
    let knob = SmartKnob {
        num_positions: u32::try_from(positions).unwrap_or(0),
        // The firmware counts against the angle.
        position: last - at_zero,
        position_width_radians: width_deg.to_radians(),
        detent_strength_unit: rest.map_or(0.0, |rest| strength(rest.stiffness_mnm_rad)),
        endstop_strength_unit: stiffest_end_stop_mnm_rad(model).map_or(0.0, strength),
        snap_point: SNAP_POINT,
        // As much of it as the firmware takes.
        text: model.name[..model.name.floor_char_boundary(LONGEST_TEXT)].to_owned().into(),
    };
    let first_rad = middle_rad + f64::from(first) * knob.position_width_radians;
    let mut turned = Turned { knob: &knob, position: at_zero };
    let said: Vec<f64> =
        motions.iter().map(|motion| motor_mnm_per_v * turned.volts_at(motion.angle_rad - first_rad)).collect();
    Ok(SmartKnobExport {
        left_out: left_out(model, table.as_ref()),
        left_out_mnm: left_out_by_mnm(model, &said, motions),
        knob,
    })
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
