//! The state of a knob whose motion is known, but not what lies inside it.

use super::State;
use crate::{Bristles, InnerBody, Model, Motion};

/// Follows a measured motion and keeps track of bristles and inner body.
#[derive(Debug)]
pub(super) struct Observer<'model> {
    motion: Motion,
    inner: Option<InnerBody<'model>>,
    bristles: Option<Bristles>,
    deflection: f64,
}

impl<'model> Observer<'model> {
    /// At rest before `motion`, the first of a capture.
    pub(super) fn new(model: &'model Model, motion: &Motion) -> Self {
        let inner = model.coupling().map(|coupling| InnerBody::at_rest(model, coupling, motion.angle_rad));
        Self { motion: *motion, inner, bristles: model.bristles(), deflection: 0.0 }
    }

    /// Moves on to the next measured motion.
    pub(super) fn advance(&mut self, to: &Motion) {
        match &mut self.inner {
            Some(inner) if to.time_s > self.motion.time_s => inner.advance(&self.motion, to),
            Some(_) => {}
            None => {
                let turned_rad = to.angle_rad - self.motion.angle_rad;
                let bent = |bristles: Bristles| bristles.bent(self.deflection, turned_rad);
                self.deflection = self.bristles.map_or(0.0, bent);
            }
        }
        self.motion = *to;
    }

    /// The whole state at the last measured motion.
    pub(super) fn state(&self) -> State {
        let Motion { time_s, angle_rad, velocity_rad_s, .. } = self.motion;
        let (inner_angle_rad, inner_velocity_rad_s, deflection) =
            self.inner.as_ref().map_or((angle_rad, velocity_rad_s, self.deflection), |inner| {
                (inner.angle_rad(), inner.velocity_rad_s(), inner.deflection())
            });
        State { time_s, angle_rad, velocity_rad_s, deflection, inner_angle_rad, inner_velocity_rad_s }
    }
}
