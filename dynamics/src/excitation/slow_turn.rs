//! A slow turn there and back.

use serde::{Deserialize, Serialize};

use super::Jet;

/// Time in which the speed comes up and goes down again, s.
const EASE_S: f64 = 0.25;

/// From zero to the full angle at a constant speed, back at the same speed, and so on.
///
/// At a constant speed inertia is out of play: what the torque shows over the angle is friction and
/// detents, and what an accelerometer shows is gravity. Turning both ways tells the two directions
/// of friction apart and cancels what a channel's delay does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlowTurn {
    /// Time of one way, s; more than a quarter.
    pub leg_s: f64,
}

impl SlowTurn {
    /// Turns of the knob in the default slow turn: a little over one, so that no angle is missed.
    pub const TURNS: f64 = 1.2;
}

impl Default for SlowTurn {
    /// 7.5 s each way: close to 1 rad/s for 1.2 turns.
    fn default() -> Self {
        Self { leg_s: 7.5 }
    }
}

impl SlowTurn {
    pub(super) fn at(&self, time_s: f64) -> Jet {
        let within_s = time_s.rem_euclid(2.0 * self.leg_s);
        if within_s <= self.leg_s {
            self.way_there(within_s)
        } else {
            let mirrored = self.way_there(2.0 * self.leg_s - within_s);
            Jet { first: -mirrored.first, ..mirrored }
        }
    }

    fn way_there(&self, time_s: f64) -> Jet {
        let speed = 1.0 / (self.leg_s - EASE_S);
        let left_s = self.leg_s - time_s;
        if time_s < EASE_S {
            eased(time_s).scaled(speed)
        } else if left_s < EASE_S {
            let end = eased(left_s).scaled(speed);
            Jet { value: 1.0 - end.value, first: end.first, second: -end.second }
        } else {
            Jet { value: speed * (time_s - 0.5 * EASE_S), first: speed, second: 0.0 }
        }
    }
}

/// The angle of a speed that rises to 1 along the quintic step.
fn eased(time_s: f64) -> Jet {
    let speed = Jet::smooth_step(time_s, EASE_S);
    let x = (time_s / EASE_S).clamp(0.0, 1.0);
    // The integral of x³·(10 − 15x + 6x²).
    let integral = x * x * x * x * (2.5 + x * (-3.0 + x));
    Jet { value: EASE_S * integral, first: speed.value, second: speed.first }
}
