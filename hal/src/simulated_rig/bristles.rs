//! Friction whose contacts bend before they slip.

use dynamics::{Bristles, Direction};

use super::contact::{KnobFriction, Sliding};

/// The knob's bristles: their mean deflection z, in units of that at which they slip.
///
/// dz/dt = (θ̇ − |θ̇|·z)/z₀ by the midpoint rule. They carry the Coulomb friction of the side to which they are bent;
/// what friction changes with speed comes on top of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct BentBristles {
    law: Bristles,
    deflection: f64,
}

impl BentBristles {
    pub(super) fn new(law: Bristles) -> Self {
        Self { law, deflection: 0.0 }
    }

    /// The torque over the substep to come, whose length is `substep_s`.
    pub(super) fn bending(&self, friction: &KnobFriction<'_>, substep_s: f64) -> Sliding {
        let direction = Direction::of(friction.motion.velocity_rad_s);
        let (negative_mnm, positive_mnm) = friction.at_rest_mnm();
        let coulomb_mnm = if self.deflection < 0.0 { -negative_mnm } else { positive_mnm };
        let still_mnm = if direction == Direction::Negative { negative_mnm } else { positive_mnm };
        let of_speed_mnm = friction.sliding_mnm(direction) - still_mnm;
        let share = 1.0 - direction.sign() * self.deflection;
        let stiffness_mnm_rad = coulomb_mnm / self.law.deflection_rad;
        Sliding {
            braking_mnm: coulomb_mnm * self.deflection + of_speed_mnm,
            drag: share * (0.5 * substep_s * stiffness_mnm_rad + self.law.damping),
        }
    }

    /// Bends by a turn of the knob, rad.
    pub(super) fn turn(&mut self, turned_rad: f64) {
        let slip = turned_rad / self.law.deflection_rad;
        let half = 0.5 * slip.abs();
        self.deflection = (self.deflection * (1.0 - half) + slip) / (1.0 + half);
    }
}
