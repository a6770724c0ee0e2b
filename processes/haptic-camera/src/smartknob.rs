//! SmartKnob's knobs, as its firmware renders them at rest, and the default ones.
//!
//! Facts from github scottbez1/smartknob: the list of configurations in `firmware/src/interface_task.cpp`, and the control law in
//! `firmware/src/motor_task.cpp`: 4 · strength volt per radian off the middle of the position, without the first fifth of its
//! width or the first degree, whichever is less; the next position's middle from `snap_point` widths on; at the ends
//! the strength of the end stop; at most the supply of 5 V. What its motor makes of a volt the firmware does not say.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::Serialize;
use shared_types::Axis;
use sheet::{Branch, Sheet};

/// Volt per radian and unit of strength.
pub const V_PER_RAD: f64 = 4.0;
/// Share of a position's width that is without torque …
const DEAD_SHARE: f64 = 0.2;
/// … but at most this angle, rad.
const DEAD_RAD: f64 = std::f64::consts::PI / 180.0;
/// Largest voltage, V.
const SUPPLY_V: f64 = 5.0;
/// Steps from one position to the next.
const STEPS: u32 = 60;

/// A configuration of the firmware: the message `SmartKnobConfig` of `proto/smartknob.proto`, field by field.
#[derive(Serialize)]
pub struct SmartKnob {
    /// Number of positions; 0 for no bounds.
    pub num_positions: u32,
    /// The position that it begins in.
    pub position: i32,
    pub position_width_radians: f64,
    pub detent_strength_unit: f64,
    pub endstop_strength_unit: f64,
    /// Widths from the middle at which the position changes.
    pub snap_point: f64,
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
    pub fn reach_rad(&self) -> f64 {
        let last = if self.num_positions == 0 { 3 } else { (self.num_positions - 1).min(3) };
        (f64::from(last) + 1.6) * self.position_width_radians
    }

    /// Largest voltage against leaving a position, V.
    pub fn peak_v(&self) -> f64 {
        self.volts(self.snap_point * self.position_width_radians, self.detent_strength_unit)
    }

    fn volts(&self, off_rad: f64, strength: f64) -> f64 {
        let dead = (DEAD_SHARE * self.position_width_radians).min(DEAD_RAD);
        (V_PER_RAD * strength * (off_rad - off_rad.clamp(-dead, dead))).clamp(-SUPPLY_V, SUPPLY_V)
    }

    /// The volts that a slow hand feels against it, there and back from below the first position.
    pub fn sheet(&self) -> Sheet {
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
        let branch = |load: Vec<f64>| Branch {
            axis: Axis::Rotary,
            first,
            step,
            load_ci95_half_width: vec![0.0; load.len()],
            load,
        };
        let curve = BTreeMap::from([("positive", branch(there)), ("negative", branch(back))]);
        Sheet { axis: Axis::Rotary, runs: 1, figures: BTreeMap::new(), detents: Vec::new(), presses: Vec::new(), curve }
    }
}

/// A knob as it is turned: it keeps its position until the next one's is reached.
pub struct Turned<'knob> {
    pub knob: &'knob SmartKnob,
    /// The position that it is in, counted towards positive angle; the middle of position 0 is at angle 0.
    pub position: i32,
}

impl Turned<'_> {
    /// The volts against leaving the position at that angle, rad.
    pub fn volts_at(&mut self, angle_rad: f64) -> f64 {
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
