//! Two inertias with the torque sensor's spring between them.

use super::RigParameters;
use super::inner::Reaction;

/// A quantity on either side of the torque sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sides<T> {
    pub(super) motor: T,
    pub(super) load: T,
}

/// Motor side and load side, coupled by the torque sensor.
///
/// A substep is the implicit midpoint rule, for which the energy of inertias and spring is exact at
/// any step, with dry friction as a constraint on the velocity at its end. With g = k·h/2 + c and
/// a bar for the mean over the substep the sensor carries Ts = k·φ + g·(ω̄m − ω̄l), and the
/// velocities at the end solve the 2×2 system
///
/// ```text
/// Jm·(ωm' − ωm) = h·(Tm − Ts)
/// Jl·(ωl' − ωl) = h·(Ts + Tl)
/// ```
#[derive(Debug)]
pub(super) struct Shaft {
    substep_s: f64,
    inertia: Sides<f64>,
    stiffness_mnm_rad: f64,
    /// g, mNm·s/rad.
    implicit_damping: f64,
    /// h·g/2, the off-diagonal of the system with its sign turned, mNm·s²/rad.
    coupling: f64,
    diagonal: Sides<f64>,
    pub(super) angle_rad: Sides<f64>,
    pub(super) velocity_rad_s: Sides<f64>,
}

/// How a substep ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    /// Velocity at the end, rad/s.
    pub(super) velocity_rad_s: Sides<f64>,
    /// Torque on each side's contact if that side is at rest at the end, mNm.
    pub(super) holding_mnm: Sides<f64>,
}

impl Shaft {
    /// A shaft at rest with `cap_inertia` of the knob fast to the gripper, mNm·s²/rad.
    pub(super) fn new(parameters: &RigParameters, cap_inertia: f64) -> Self {
        let substep_s = parameters.substep_s();
        let inertia = Sides { motor: parameters.motor_inertia(), load: parameters.gripper_inertia + cap_inertia };
        let stiffness_mnm_rad = parameters.torque_sensor_stiffness_mnm_rad;
        let implicit_damping = stiffness_mnm_rad * substep_s / 2.0 + parameters.torque_sensor_damping;
        let coupling = substep_s * implicit_damping / 2.0;
        let diagonal = Sides { motor: inertia.motor + coupling, load: inertia.load + coupling };
        Self {
            substep_s,
            inertia,
            stiffness_mnm_rad,
            implicit_damping,
            coupling,
            diagonal,
            angle_rad: Sides::default(),
            velocity_rad_s: Sides::default(),
        }
    }

    /// Torque in the sensor's spring now, mNm.
    pub(super) fn spring_mnm(&self) -> f64 {
        self.stiffness_mnm_rad * (self.angle_rad.motor - self.angle_rad.load)
    }

    /// The end of a substep under the torques `applied_mnm` (friction included for a side that slides), with
    /// `onto_load` added to the load's equation.
    pub(super) fn solve(&self, applied_mnm: Sides<f64>, at_rest: Sides<bool>, onto_load: Reaction) -> Outcome {
        let Self { substep_s, inertia, coupling, diagonal, velocity_rad_s, .. } = self;
        let diagonal = Sides { motor: diagonal.motor, load: diagonal.load + onto_load.diagonal };
        let spring_mnm = self.spring_mnm();
        let carried = coupling * (velocity_rad_s.motor - velocity_rad_s.load);
        let momentum = Sides {
            motor: inertia.motor * velocity_rad_s.motor + substep_s * (applied_mnm.motor - spring_mnm) - carried,
            load: inertia.load * velocity_rad_s.load
                + substep_s * (applied_mnm.load + spring_mnm)
                + carried
                + onto_load.momentum,
        };
        let velocity_rad_s = match (at_rest.motor, at_rest.load) {
            (false, false) => {
                let determinant = diagonal.motor * diagonal.load - coupling * coupling;
                Sides {
                    motor: (diagonal.load * momentum.motor + coupling * momentum.load) / determinant,
                    load: (diagonal.motor * momentum.load + coupling * momentum.motor) / determinant,
                }
            }
            (false, true) => Sides { motor: momentum.motor / diagonal.motor, load: 0.0 },
            (true, false) => Sides { motor: 0.0, load: momentum.load / diagonal.load },
            (true, true) => Sides::default(),
        };
        let holding_mnm = Sides {
            motor: (momentum.motor + coupling * velocity_rad_s.load) / substep_s,
            load: (momentum.load + coupling * velocity_rad_s.motor) / substep_s,
        };
        Outcome { velocity_rad_s, holding_mnm }
    }

    /// Goes to the end of the substep; gives the mean torque in the sensor over it, mNm.
    pub(super) fn advance(&mut self, end_rad_s: Sides<f64>) -> f64 {
        let mean_rad_s = Sides {
            motor: (self.velocity_rad_s.motor + end_rad_s.motor) / 2.0,
            load: (self.velocity_rad_s.load + end_rad_s.load) / 2.0,
        };
        let sensor_mnm = self.spring_mnm() + self.implicit_damping * (mean_rad_s.motor - mean_rad_s.load);
        self.angle_rad.motor += self.substep_s * mean_rad_s.motor;
        self.angle_rad.load += self.substep_s * mean_rad_s.load;
        self.velocity_rad_s = end_rad_s;
        sensor_mnm
    }
}
