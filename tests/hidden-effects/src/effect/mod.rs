//! The effects that a capture may hide, one a file: those with a name in the catalogue, and real ones without.
//!
//! Each acts on the body that slides, on the link between cap and inner body, or on the sensors, and has one number that is
//! scaled to reach a strength: its size.

mod angle_dependent_inertia;
mod backlash;
mod cogging;
mod cubic_spring;
mod detent_harmonics;
mod directional_detents;
mod eddy_current_damping;
mod encoder_eccentricity;
mod end_stop;
mod friction_drift;
mod friction_dropouts;
mod friction_eccentricity;
mod friction_step;
mod grip_slips;

mod load_dependent_friction;
mod mains_hum;
mod mass_imbalance;
mod presliding_hysteresis;
mod quadratic_drag;
mod rate_limited_sensor;
mod return_spring;
mod scratch;
mod sensor_delay;
mod sensor_hysteresis;
mod sensor_saturation;
mod shaft_compliance;
mod strange_hum;
mod stribeck;
mod torque_drift;
mod torque_offset;
mod unequal_detents;

mod velocity_strengthening;

use serde_json::Value;

use crate::draw::Draw;
use crate::knob::{Knob, Wish};
use crate::plant::{Bristle, Link};

/// Every effect: those of the catalogue first.
static ALL: [&Kind; 32] = [
    &stribeck::KIND,
    &velocity_strengthening::KIND,
    &backlash::KIND,
    &detent_harmonics::KIND,
    &unequal_detents::KIND,
    &angle_dependent_inertia::KIND,
    &load_dependent_friction::KIND,
    &mass_imbalance::KIND,
    &friction_eccentricity::KIND,
    &scratch::KIND,
    &presliding_hysteresis::KIND,
    &return_spring::KIND,
    &end_stop::KIND,
    &quadratic_drag::KIND,
    &eddy_current_damping::KIND,
    &shaft_compliance::KIND,
    &friction_drift::KIND,
    &cogging::KIND,
    &torque_offset::KIND,
    &sensor_delay::KIND,
    &mains_hum::KIND,
    &sensor_saturation::KIND,
    &cubic_spring::KIND,
    &friction_step::KIND,
    &torque_drift::KIND,
    &strange_hum::KIND,
    &encoder_eccentricity::KIND,
    &grip_slips::KIND,
    &friction_dropouts::KIND,
    &rate_limited_sensor::KIND,
    &directional_detents::KIND,
    &sensor_hysteresis::KIND,
];

/// The effects that the catalogue knows.
pub fn catalogue() -> Vec<&'static Kind> {
    ALL.iter().copied().filter(|kind| kind.in_catalogue).collect()
}

/// Real effects that the catalogue does not know.
pub fn outside() -> Vec<&'static Kind> {
    ALL.iter().copied().filter(|kind| !kind.in_catalogue).collect()
}

/// The effect called `name`.
pub fn named(name: &str) -> Option<&'static Kind> {
    ALL.iter().copied().find(|kind| kind.name == name)
}

/// Pairs that a capture cannot tell from one another or from one of them alone.
const LOOK_ALIKES: [(&str, &str); 14] = [
    ("torque-offset", "return-spring"),
    ("return-spring", "mass-imbalance"),
    ("shaft-compliance", "presliding-hysteresis"),
    ("shaft-compliance", "backlash"),
    ("shaft-compliance", "sensor-delay"),
    ("quadratic-drag", "stribeck"),
    ("quadratic-drag", "eddy-current-damping"),
    ("presliding-hysteresis", "backlash"),
    ("backlash", "sensor-delay"),
    ("presliding-hysteresis", "stribeck"),
    ("velocity-strengthening", "stribeck"),
    ("velocity-strengthening", "quadratic-drag"),
    ("velocity-strengthening", "eddy-current-damping"),
    ("velocity-strengthening", "presliding-hysteresis"),
];

/// Pairs that the plant cannot have at once: its detents have one shape, and the inertia behind a coupling is constant. Whether a drag is part
/// of the load depends on where the drag acts.
const EXCLUSIVE: [(&str, &str); 5] = [
    ("load-dependent-friction", "quadratic-drag"),
    ("load-dependent-friction", "eddy-current-damping"),
    ("detent-harmonics", "unequal-detents"),
    ("angle-dependent-inertia", "shaft-compliance"),
    ("angle-dependent-inertia", "backlash"),
];

/// Whether the plant can have two effects of the catalogue at once, and they can then be distinguished.
pub fn distinguishable(first: &str, second: &str) -> bool {
    let is_listed = |pair: &(&str, &str)| *pair == (first, second) || *pair == (second, first);
    first != second && !LOOK_ALIKES.iter().chain(&EXCLUSIVE).any(is_listed)
}

/// An effect before its numbers are drawn.
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// Whether the instrument's catalogue has it.
    pub in_catalogue: bool,
    /// The knob that shows it, if it is to reach so many mNm RMS.
    pub wish: fn(f64) -> Wish,
    /// Draws the numbers that stay.
    draw: fn(&Scene<'_>, &mut Draw) -> Box<dyn Acts>,
}

/// What is known before an effect is drawn.
struct Scene<'a> {
    knob: &'a Knob,
    /// Lowest and highest angle of training and held-out motion, rad.
    travel_rad: [f64; 2],
    durations_s: [f64; 2],
    /// An angle near the middle of the travel, rad.
    centre_rad: f64,
    /// −1 or +1.
    sign: f64,
}

impl Scene<'_> {
    fn middle_rad(&self) -> f64 {
        0.5 * (self.travel_rad[0] + self.travel_rad[1])
    }

    /// Moments of a capture, apart from the rest at its start, in order.
    fn times_s(&self, count: usize, capture: usize, draw: &mut Draw) -> Vec<f64> {
        let mut times: Vec<f64> = (0..count).map(|_| draw.uniform(0.6, self.durations_s[capture] - 0.2)).collect();
        times.sort_by(f64::total_cmp);
        times
    }
}

/// What an effect of a size does; an effect leaves alone what it does not name.
#[allow(unused_variables, reason = "most effects act in one place only")]
pub trait Acts {
    /// The sizes between which the strength is sought: where the effect is weakest and where it is strongest.
    fn size_limits(&self) -> [f64; 2];

    /// The parameters as the answers tell them.
    fn parameters(&self, size: f64, knob: &Knob) -> Value;

    /// Multiplies the Coulomb friction, or the viscous one where `viscous`.
    fn friction_factor(&self, size: f64, state: &State, viscous: bool) -> f64 {
        1.0
    }

    /// Adds to the Coulomb friction, mNm.
    fn friction_extra(&self, size: f64, state: &State) -> f64 {
        0.0
    }

    /// Friction over the load that the body carries.
    fn load_friction(&self, size: f64) -> f64 {
        0.0
    }

    /// Torque that the sliding body takes for its place and speed, mNm.
    fn body_torque(&self, size: f64, state: &State) -> f64 {
        0.0
    }

    /// How far the body has slipped in its grip, rad.
    fn slipped_rad(&self, size: f64, state: &State) -> f64 {
        0.0
    }

    /// The detents' wave at phase `x`, in the place of a sine, if the effect shapes it.
    fn detent_wave(&self, size: f64, x: f64, velocity_rad_s: f64) -> Option<f64> {
        None
    }

    /// Relative depth and phase of an inertia that varies twice in a turn.
    fn inertia_wave(&self, size: f64) -> Option<[f64; 2]> {
        None
    }

    /// Bristles in the place of Coulomb friction.
    fn bristle(&self, size: f64) -> Option<Bristle> {
        None
    }

    /// How cap and inner body hang together.
    fn link(&self, size: f64) -> Link {
        Link::Rigid
    }

    /// What the encoder reads beyond the angle, rad, and how that changes with the angle.
    fn encoder(&self, size: f64, angle_rad: f64) -> [f64; 2] {
        [0.0; 2]
    }

    /// What the torque sensor reads for a torque at a time.
    fn reading(&self, size: f64, torque_mnm: f64, time_s: f64) -> f64 {
        torque_mnm
    }

    /// The torque as the sensor passes it on, step by step: what needs the time between samples.
    fn channel(&self, size: f64, torque_mnm: &mut Vec<f64>) {}
}

/// One effect of a certain size.
pub struct Effect {
    /// What effect it is.
    pub kind: &'static Kind,
    /// The number that is scaled to reach a strength.
    pub size: f64,
    acts: Box<dyn Acts>,
}

impl Effect {
    /// Draws the effect for a knob whose training and held-out motion span `travel_rad` (both of `[lowest, highest]`).
    pub fn draw(
        kind: &'static Kind,
        knob: &Knob,
        travel_rad: [f64; 2],
        durations_s: [f64; 2],
        draw: &mut Draw,
    ) -> Self {
        let mut scene = Scene { knob, travel_rad, durations_s, centre_rad: 0.0, sign: 1.0 };
        scene.centre_rad = scene.middle_rad() + draw.uniform(-0.4, 0.4);
        scene.sign = if draw.chance(0.5) { 1.0 } else { -1.0 };
        Self { kind, size: 0.0, acts: (kind.draw)(&scene, draw) }
    }

    /// What it does.
    pub fn acts(&self) -> &dyn Acts {
        &*self.acts
    }
}

/// The place in phase space that friction and position torques depend on.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Angle of the sliding body, rad.
    pub angle_rad: f64,
    /// Its velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Time since the start of the capture, s.
    pub time_s: f64,
    /// 0 in the training capture, 1 in the held-out one.
    pub capture: usize,
}

/// A signal between its steps, held at its ends.
pub(crate) fn between(values: &[f64], place: f64) -> f64 {
    let place = place.clamp(0.0, (values.len() - 1) as f64);
    let index = (place as usize).min(values.len().saturating_sub(2));
    let part = place - index as f64;
    values[index] + part * (values[(index + 1).min(values.len() - 1)] - values[index])
}
