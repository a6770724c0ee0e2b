//! The knob itself: how it is turned, whether it sticks, and where its detents are.

use std::f64::consts::{PI, TAU};

use dynamics::Axis;

use crate::frame::Points;
use crate::model_curves::POINTS_PER_DETENT;
use crate::model_torque::KnobModel;
use crate::source::Reading;

/// Time between two drawn angles: an angle for every picture of the screen is not needed.
const TURN_PERIOD_NS: i64 = 40_000_000;
/// Shortest time between two changes of the colour: what changes faster than that nobody reads.
const MOTION_PERIOD_NS: i64 = 500_000_000;
/// Speed below which a captured knob counts as sticking, rad/s: the largest Δv of the paper's knobs (Table 6). A
/// rendered knob says itself whether it sticks, and what is pressed counts at the fingertip.
const STICK_VELOCITY_RAD_S: f64 = 0.04;
/// Change of the detents, as a share of their depth and distance, that is not drawn.
const UNSEEN: f64 = 0.01;
/// Most detents in a turn that are drawn each; more would be finer than the screen.
const MOST_DETENTS: f64 = 180.0;

/// Whether the knob sticks, and if not which way it slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    Sticking,
    SlippingPositive,
    SlippingNegative,
}

impl Motion {
    /// Of a reading; `None` where velocity is unknown.
    pub fn of(reading: &Reading, axis: Axis) -> Option<Self> {
        let slow = STICK_VELOCITY_RAD_S * axis.fingertip_travel();
        match (reading.stuck, reading.velocity_rad_s) {
            (Some(true), _) => Some(Self::Sticking),
            (None, velocity) if velocity.abs() < slow => Some(Self::Sticking),
            (_, velocity) if velocity.is_nan() => None,
            (_, velocity) if velocity > 0.0 => Some(Self::SlippingPositive),
            _ => Some(Self::SlippingNegative),
        }
    }

    pub const fn word(self) -> &'static str {
        match self {
            Self::Sticking => "sticking",
            Self::SlippingPositive => "slipping, positive",
            Self::SlippingNegative => "slipping, negative",
        }
    }
}

/// The detents around one turn of the knob.
#[derive(Clone, Debug, PartialEq)]
pub struct DetentRing {
    /// Angles of the ring, rad, with the depth there as a share of the amplitude: 1 at the bottom of a detent, −1
    /// between two of them.
    pub depths: Vec<[f64; 2]>,
    /// Angles at which the knob rests, rad.
    pub stable_rad: Vec<f64>,
    /// Largest detent torque, mNm.
    pub amplitude_mnm: f64,
    /// From detent to detent, rad.
    pub spacing_rad: f64,
}

impl DetentRing {
    /// The detents of a model in the turn around `angle_rad`; `None` if there are none, or until they are identified.
    pub fn of(model: &KnobModel, angle_rad: f64) -> Option<Self> {
        let [amplitude, period, phase] = model.detent()?;
        let spacing_rad = Some(TAU * period.abs()).filter(|spacing| *spacing > TAU / MOST_DETENTS)?;
        let middle = (angle_rad / TAU).round() * TAU;
        let (low, high) = (middle - PI, middle + PI);
        let points = (POINTS_PER_DETENT * (TAU / spacing_rad).max(4.0)).ceil() as u32;
        // The knob rests where the torque turns positive: there its integral, the energy, is least.
        let sign = (amplitude * period).signum();
        let depths = (0..=points)
            .map(|index| low + TAU * f64::from(index) / f64::from(points))
            .map(|angle| [angle, sign * (angle / period + phase).cos()])
            .collect();
        let offset = if amplitude * period > 0.0 { 0.0 } else { PI };
        let number = |angle: f64| (angle / period + phase - offset) / TAU;
        let (first, last) = (number(low).min(number(high)), number(low).max(number(high)));
        let numbers = first.ceil() as i64..=last.floor() as i64;
        let stable_rad = numbers.map(|number| period * (TAU * number as f64 + offset - phase)).collect();
        Some(Self { depths, stable_rad, amplitude_mnm: amplitude.abs(), spacing_rad })
    }

    /// Whether nobody could see the difference: the fit never rests, but each drawing costs a browser something.
    fn looks_like(&self, other: &Self) -> bool {
        let first = |ring: &Self| ring.stable_rad.first().copied().unwrap_or(f64::NAN);
        let near = |one: f64, other: f64, tolerance: f64| (one - other).abs() <= tolerance;
        near(self.amplitude_mnm, other.amplitude_mnm, UNSEEN * self.amplitude_mnm)
            && self.stable_rad.len() == other.stable_rad.len()
            && near(first(self), first(other), UNSEEN * self.spacing_rad)
            && near(self.spacing_rad, other.spacing_rad, UNSEEN * self.spacing_rad * self.spacing_rad / TAU)
    }
}

/// What is new of the knob.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnobUpdate {
    /// Angles, rad.
    pub turns: Points,
    /// Whether it sticks, if that has changed.
    pub motion: Option<Motion>,
    /// Its detents, if they have changed.
    pub detents: Option<DetentRing>,
}

#[derive(Clone, Debug, Default)]
pub struct KnobTrack {
    turns: Points,
    next_ns: Option<i64>,
    motion_shown: Option<Motion>,
    next_motion_ns: Option<i64>,
    detents_shown: Option<DetentRing>,
    newest_rad: f64,
}

impl KnobTrack {
    pub fn push(&mut self, reading: &Reading) {
        if !reading.angle_rad.is_finite() {
            return;
        }
        self.newest_rad = reading.angle_rad;
        if self.next_ns.is_none_or(|next_ns| reading.time_ns >= next_ns) {
            self.next_ns = Some(reading.time_ns + TURN_PERIOD_NS);
            self.turns.push(reading.time_ns, &[reading.angle_rad]);
        }
    }

    /// Shows the motion once more though it may not have changed: for pages that are opened late.
    pub const fn show_again(&mut self) {
        self.motion_shown = None;
    }

    /// What is new since the last call, with how the knob moves now and the detents of a new `model`; `None` if nothing is.
    pub fn update(&mut self, motion: Option<Motion>, model: Option<&KnobModel>) -> Option<KnobUpdate> {
        let turns = std::mem::take(&mut self.turns);
        let newest_ns = turns.times_ns.last().copied().or(self.next_motion_ns).unwrap_or_default();
        let is_due = self.next_motion_ns.is_none_or(|next_ns| newest_ns >= next_ns);
        let motion = motion.filter(|_| self.motion_shown != motion && is_due);
        if motion.is_some() {
            self.next_motion_ns = Some(newest_ns + MOTION_PERIOD_NS);
            self.motion_shown = motion;
        }
        let ring = model.and_then(|model| DetentRing::of(model, self.newest_rad));
        let detents = ring.filter(|ring| self.detents_shown.as_ref().is_none_or(|shown| !shown.looks_like(ring)));
        if detents.is_some() {
            self.detents_shown.clone_from(&detents);
        }
        let update = KnobUpdate { turns, motion, detents };
        (update != KnobUpdate::default()).then_some(update)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(time_ns: i64, velocity_rad_s: f64, stuck: Option<bool>) -> Reading {
        Reading { time_ns, angle_rad: 0.25, velocity_rad_s, stuck, ..Reading::default() }
    }

    fn detents(amplitude: f64) -> KnobModel {
        let values = [("detent_amplitude", amplitude), ("detent_period", 0.1), ("detent_phase", 0.5)];
        let value = |name: &str| values.iter().find(|(known, _)| *known == name).map(|(_, value)| [*value, 0.0]);
        KnobModel::from_estimates(value).unwrap()
    }

    #[test]
    fn a_knob_slower_than_the_papers_knobs_stick_at_is_sticking() {
        let motion = |velocity, stuck| Motion::of(&reading(0, velocity, stuck), Axis::Rotary);
        assert_eq!(motion(0.039, None), Some(Motion::Sticking));
        assert_eq!(motion(0.041, None), Some(Motion::SlippingPositive));
        assert_eq!(motion(-3.0, None), Some(Motion::SlippingNegative));
        assert_eq!(motion(f64::NAN, None), None);
        // A slider moves by millimetres.
        assert_eq!(Motion::of(&reading(0, 0.5, None), Axis::Linear), Some(Motion::Sticking));
        // A rendered one says so itself.
        assert_eq!(motion(1.0, Some(true)), Some(Motion::Sticking));
        assert_eq!(motion(0.001, Some(false)), Some(Motion::SlippingPositive));
    }

    #[test]
    fn the_knob_rests_where_the_detent_torque_pushes_back_on_either_side() {
        for amplitude in [2.0, -2.0] {
            let model = detents(amplitude);
            let ring = DetentRing::of(&model, 0.0).unwrap();
            assert_eq!(ring.stable_rad.len(), 10);
            let deepest = ring.depths.iter().max_by(|one, other| one[1].total_cmp(&other[1])).unwrap()[0];
            assert!(ring.stable_rad.iter().any(|angle| (angle - deepest).abs() < 0.1 / 16.0 * TAU));
            for angle in ring.stable_rad {
                // What the knob takes from the rig: positive beyond the detent, negative before it.
                let torque_mnm = |angle| model.torque_mnm(angle, 0.0, 0.0);
                assert!(torque_mnm(angle + 0.05) > 0.5 && torque_mnm(angle - 0.05) < -0.5);
            }
        }
    }

    #[test]
    fn the_ring_is_of_the_turn_that_the_knob_is_in() {
        let ring = DetentRing::of(&detents(2.0), 4.0 * TAU + 0.3).unwrap();
        assert!(ring.stable_rad.iter().all(|angle| (angle - 4.0 * TAU).abs() <= PI));
    }

    #[test]
    fn what_has_not_changed_is_not_drawn_again() {
        let mut track = KnobTrack::default();
        (0..1_000).for_each(|millisecond| track.push(&reading(millisecond * 1_000_000, 1.0, None)));
        let slipping = Some(Motion::SlippingPositive);
        let first = track.update(slipping, Some(&detents(2.0))).unwrap();
        assert_eq!(first.turns.times_ns.len(), 25);
        assert!(first.motion.is_some() && first.detents.is_some());
        assert_eq!(track.update(slipping, Some(&detents(2.0))), None);
    }
}
