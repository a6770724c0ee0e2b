//! The state of a knob whose motion is known, while that of its inner body and bristles is not.

use super::{ForwardSimulation, SimulationError, State};
use crate::{Bristles, Model, Motion};

/// Follows a measured motion and keeps track of bristles and inner body.
///
/// `InnerBody` does the same at a fixed small cost; but bodies that bounce off each other multiply errors, and
/// a prediction that starts on the wrong flank of a gap is lost.
#[derive(Debug)]
pub(super) struct Observer<'model> {
    motion: Motion,
    inner: Option<ForwardSimulation<'model>>,
    bristles: Option<Bristles>,
    deflection: f64,
}

impl<'model> Observer<'model> {
    /// At rest before `motion`, the first of a capture.
    pub(super) fn new(model: &'model Model, motion: &Motion) -> Result<Self, SimulationError> {
        let rest = State { time_s: motion.time_s, ..State::at_rest(motion.angle_rad) };
        let inner = model.coupling().map(|coupling| ForwardSimulation::led(model, coupling, &rest)).transpose()?;
        Ok(Self { motion: *motion, inner, bristles: model.bristles(), deflection: 0.0 })
    }

    /// Moves on to the next measured motion.
    pub(super) fn advance(&mut self, to: &Motion) -> Result<(), SimulationError> {
        match &mut self.inner {
            Some(inner) if to.time_s > self.motion.time_s => inner.lead(&self.motion, to)?,
            Some(_) => {}
            None => {
                let turned_rad = to.angle_rad - self.motion.angle_rad;
                let bent = |bristles: Bristles| bristles.bent(self.deflection, turned_rad);
                self.deflection = self.bristles.map_or(0.0, bent);
            }
        }
        self.motion = *to;
        Ok(())
    }

    /// The whole state at the last measured motion.
    pub(super) fn state(&self) -> State {
        let Motion { time_s, angle_rad, velocity_rad_s, .. } = self.motion;
        let inside = self.inner.as_ref().map(ForwardSimulation::state);
        let inside = inside.unwrap_or(State {
            deflection: self.deflection,
            inner_angle_rad: angle_rad,
            inner_velocity_rad_s: velocity_rad_s,
            ..State::default()
        });
        State { time_s, angle_rad, velocity_rad_s, ..inside }
    }
}
