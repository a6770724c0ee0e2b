//! Steps from event to event: breaking away, sticking, turning round.

use super::equation::Sliding;
use super::runge_kutta::{Place, Step, dormand_prince};
use super::{ForwardSimulation, LONGEST_STEP_S, SimulationError, TorqueLine};
use crate::Direction;

/// Shortest step, s: a torque that jumps within it is a torque that jumps.
const SHORTEST_STEP_S: f64 = 1e-10;
/// Bisections of a step to locate an event: 2⁻⁴⁰ of it.
const BISECTIONS: u32 = 40;
/// Events within one longest step beyond which the knob is taken to be at rest.
const MOST_EVENTS: u32 = 16;
/// Steps within one longest step beyond which a model is given up: faster changes than 5 MHz are no knob's.
const MOST_STEPS: u32 = 500;

impl ForwardSimulation<'_> {
    /// Moves on to `end_s`, at most one longest step away, through however many events lie between.
    pub(super) fn advance_through_events(&mut self, end_s: f64, torque: &TorqueLine) -> Result<(), SimulationError> {
        let mut events = 0;
        for _ in 0..MOST_STEPS {
            if self.time_s >= end_s {
                return Ok(());
            }
            // The body chatters between slip and stick within so short a time that it is held at rest until the end.
            let held = events >= MOST_EVENTS;
            if held {
                self.come_to_rest();
            } else if self.sliding.is_none() {
                self.sliding = self.breakaway(torque);
            }
            let (reached_s, place) = self.step_towards(end_s, torque);
            if !place.iter().all(|value| value.is_finite()) {
                return Err(SimulationError::NotFinite { time_s: self.time_s });
            }
            let happened = !held
                && match self.sliding {
                    None => self.wait_for_breakaway(reached_s, &place, torque),
                    Some(direction) => self.slide(reached_s, &place, torque, direction),
                };
            if happened {
                events += 1;
            } else {
                self.go_to(reached_s, place);
            }
        }
        if self.time_s >= end_s { Ok(()) } else { Err(SimulationError::TooStiff { time_s: self.time_s }) }
    }

    /// Whether a body at rest breaks away before `end_s`; it then goes to just there.
    fn wait_for_breakaway(&mut self, end_s: f64, end: &Place, torque: &TorqueLine) -> bool {
        if self.breakaway_at(end_s, end, torque).is_none() {
            return false;
        }
        let breaks_away = |time: f64| self.breakaway_at(time, &self.reached(time, torque), torque).is_some();
        let time_s = bisect(self.time_s, end_s, breaks_away);
        self.go_to(time_s, self.reached(time_s, torque));
        true
    }

    /// Whether a sliding body sticks, slows down through Karnopp's Δv or turns round before `end_s`; it then goes to that moment.
    fn slide(&mut self, end_s: f64, end: &Place, torque: &TorqueLine, direction: Direction) -> bool {
        let threshold = self.stick_velocity_rad_s();
        let speed_of = |place: &Place| direction.sign() * place[1];
        let speed_at = |time: f64| speed_of(&self.reached(time, torque));
        let (speed, end_speed) = (speed_of(&self.place), speed_of(end));

        if speed > threshold && end_speed <= threshold && threshold > 0.0 {
            let time_s = bisect(self.time_s, end_s, |time| speed_at(time) <= threshold);
            self.go_to(time_s, self.reached(time_s, torque));
            if self.breakaway(torque).is_none() {
                self.come_to_rest();
            } else {
                // The load is too large to stick: it goes on through, from just below the threshold.
                self.place[1] = direction.sign() * threshold * (1.0 - 1e-9);
            }
            true
        } else if end_speed < 0.0 {
            let time_s = bisect(self.time_s, end_s, |time| speed_at(time) < 0.0);
            self.go_to(time_s, self.reached(time_s, torque));
            self.come_to_rest();
            true
        } else {
            false
        }
    }

    pub(super) fn come_to_rest(&mut self) {
        self.place[1] = 0.0;
        self.sliding = None;
    }

    fn go_to(&mut self, time_s: f64, place: Place) {
        self.deflection =
            self.sliding_from_here().map_or(self.deflection, |sliding| self.equation.deflection(&sliding, place[0]));
        self.place = place;
        self.time_s = time_s;
    }

    pub(super) fn sliding_from_here(&self) -> Option<Sliding> {
        let from = |direction| Sliding { direction, from_rad: self.place[0], deflection: self.deflection };
        self.sliding.map(from)
    }

    pub(super) fn stick_velocity_rad_s(&self) -> f64 {
        self.equation.limits(self.time_s, self.place[0]).velocity_rad_s
    }

    pub(super) fn breakaway(&self, torque: &TorqueLine) -> Option<Direction> {
        self.breakaway_at(self.time_s, &self.place, torque)
    }

    /// The direction in which the body would break away if it were at rest there and then; `None` if it would stay at rest.
    fn breakaway_at(&self, time_s: f64, place: &Place, torque: &TorqueLine) -> Option<Direction> {
        self.equation.breakaway(time_s, place, torque.at(time_s), self.deflection)
    }

    /// The place of the knob at `time_s`, by a single step without an event.
    fn reached(&self, time_s: f64, torque: &TorqueLine) -> Place {
        self.stepped(time_s - self.time_s, torque).end
    }

    fn stepped(&self, step_s: f64, torque: &TorqueLine) -> Step {
        let sliding = self.sliding_from_here();
        dormand_prince(self.time_s, step_s, &self.place, |time_s, place| {
            self.equation.rates(time_s, place, torque.at(time_s), sliding.as_ref())
        })
    }

    /// Time and state after the longest step up to `end_s` that keeps to the tolerance.
    fn step_towards(&mut self, end_s: f64, torque: &TorqueLine) -> (f64, Place) {
        let remaining_s = end_s - self.time_s;
        let mut step_s = self.step_s.min(remaining_s);
        loop {
            let step = self.stepped(step_s, torque);
            if step.error <= 1.0 || step_s <= SHORTEST_STEP_S {
                let whole = step_s >= remaining_s;
                // A step cut short by `end_s` says nothing about the next one's length.
                if !whole || step_s >= self.step_s {
                    self.step_s = (step_s * step.growth()).clamp(SHORTEST_STEP_S, LONGEST_STEP_S);
                }
                return (if whole { end_s } else { self.time_s + step_s }, step.end);
            }
            step_s = (step_s * step.growth()).max(SHORTEST_STEP_S);
            self.step_s = step_s;
        }
    }
}

/// The earliest time found at which `passed` holds, between a start where it does not hold and an end where it does.
fn bisect(start: f64, end: f64, passed: impl Fn(f64) -> bool) -> f64 {
    let (mut before, mut after) = (start, end);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + after);
        if passed(middle) {
            after = middle;
        } else {
            before = middle;
        }
    }
    after
}
