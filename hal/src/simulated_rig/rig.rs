//! The simulated rig as an apparatus: where the plant meets the caller's time.

use dynamics::{Model, Part};

use super::description::describe;
use super::plant::{Plant, Truth};
use super::sensors::{Readings, Sensors};
use super::watchdog::Watchdog;
use super::{Hand, ParameterError, RigParameters};
use crate::{Apparatus, ApparatusError, Measurement, RigDescription};

/// A rig with a knob on it that exists as numbers; see the [module](crate::simulated_rig).
#[derive(Debug)]
pub struct SimulatedRig {
    description: RigDescription,
    substep_ns: u64,
    catch_up_limit: u64,
    plant: Plant,
    sensors: Sensors,
    watchdog: Watchdog,
    hand_torque_mnm: f64,
    hand: Option<Hand>,
    /// Torque of the hand over the last substep, mNm.
    applied_by_hand_mnm: f64,
    /// Caller's time at which the plant's time is zero, ns; set by the first reading.
    origin_ns: Option<u64>,
    skipped: u64,
}

impl SimulatedRig {
    /// A rig at rest at angle zero with `knob` mounted, its amplifier off.
    ///
    /// # Errors
    /// [`ParameterError`] for parameters that do not describe a rig, and a model whose torque reading comes before the
    /// torque or later than 0.1 s.
    #[allow(clippy::needless_pass_by_value, reason = "a rig is built from its parameters once")]
    pub fn new(parameters: RigParameters, knob: Model, seed: u64) -> Result<Self, ParameterError> {
        Self::held(parameters, knob, None, seed)
    }

    /// The same rig with a hand on its gripper, beside whatever knob is mounted.
    ///
    /// # Errors
    /// [`ParameterError`] as [`SimulatedRig::new`], and for a grip with an impedance below zero.
    #[allow(clippy::needless_pass_by_value, reason = "a rig is built from its parameters once")]
    pub fn held(parameters: RigParameters, knob: Model, hand: Option<Hand>, seed: u64) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let varies = |effect: &&dynamics::Effect| matches!(effect.kind().part, Part::VaryingInertia(_));
        if let Some(effect) = knob.effects.iter().find(varies) {
            return Err(ParameterError {
                parameter: effect.kind().parameters[0].name,
                value: effect.values()[0],
                requirement: "left out: on this rig a knob's inertia is the same at every angle",
            });
        }
        let hand_inertia = hand.as_ref().map_or(Ok(0.0), |hand| hand.grip.validated())?;
        let substep_s = parameters.substep_s();
        let substeps = |duration_s: f64| (duration_s / substep_s).round() as u64;
        Ok(Self {
            description: describe(&parameters, &knob, seed),
            substep_ns: parameters.substep_ns,
            catch_up_limit: substeps(parameters.catch_up_limit_s),
            sensors: Sensors::new(&parameters, &knob, seed)?,
            watchdog: Watchdog::new(substeps(parameters.watchdog_s)),
            plant: Plant::new(&parameters, knob, hand_inertia),
            hand_torque_mnm: 0.0,
            hand,
            applied_by_hand_mnm: 0.0,
            origin_ns: None,
            skipped: 0,
        })
    }

    /// The plant's true state at its last substep.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.plant.truth()
    }

    /// Lets a hand turn the knob with this torque from now on, mNm.
    pub fn set_hand_torque(&mut self, torque_mnm: f64) {
        self.hand_torque_mnm = torque_mnm;
    }

    /// Torque of the hand on the gripper over the last substep, mNm, the inertia of its fingers apart.
    #[must_use]
    pub fn applied_by_hand_mnm(&self) -> f64 {
        self.applied_by_hand_mnm
    }

    /// Times at which the amplifier's watchdog ran out.
    #[must_use]
    pub fn watchdog_trips(&self) -> u64 {
        self.watchdog.trips()
    }

    /// Time that was left out of the plant's because a reading came too late to make up for, ns.
    #[must_use]
    pub fn skipped_time_ns(&self) -> u64 {
        self.skipped * self.substep_ns
    }

    /// Reads all sensors at the given time, ns.
    ///
    /// # Errors
    /// [`ApparatusError`] once the watchdog ran out, and for a plant whose numbers ran away.
    pub fn read(&mut self, monotonic_time_ns: u64) -> Result<Readings, ApparatusError> {
        let beyond_ns = self.advance_to(monotonic_time_ns);
        self.watchdog.noticed();
        if self.watchdog.ran_out() {
            return Err(ApparatusError::Watchdog);
        }
        let readings = self.sensors.read(&self.plant.truth(), beyond_ns as f64 * 1e-9);
        let Readings { angle_rad, acceleration_rad_s2, torque_mnm, contact: _ } = readings;
        if angle_rad.is_finite() && acceleration_rad_s2.is_finite() && torque_mnm.is_finite() {
            Ok(readings)
        } else {
            Err(ApparatusError::Sensor)
        }
    }

    /// Carries the plant to the given time; gives the time that is left of a substep, ns.
    fn advance_to(&mut self, monotonic_time_ns: u64) -> u64 {
        let origin_ns = *self.origin_ns.get_or_insert(monotonic_time_ns);
        let elapsed_ns = monotonic_time_ns.saturating_sub(origin_ns);
        let mut due = (elapsed_ns / self.substep_ns).saturating_sub(self.plant.steps());
        let late = due.saturating_sub(self.catch_up_limit);
        if late > 0 {
            self.origin_ns = Some(origin_ns + late * self.substep_ns);
            self.skipped += late;
            due = self.catch_up_limit;
        }
        for _ in 0..due {
            let truth = self.plant.truth();
            let held_mnm = self
                .hand
                .as_ref()
                .map_or(0.0, |hand| hand.torque_mnm(truth.time_s, truth.knob_angle_rad, truth.knob_velocity_rad_s));
            self.applied_by_hand_mnm = self.hand_torque_mnm + held_mnm;
            self.plant.step(self.watchdog.torque_mnm(), self.applied_by_hand_mnm);
            self.sensors.step(&self.plant.truth());
            self.watchdog.pass(1);
        }
        self.watchdog.pass(late);
        elapsed_ns % self.substep_ns
    }
}

impl Apparatus for SimulatedRig {
    fn description(&self) -> &RigDescription {
        &self.description
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        self.watchdog.switch_on();
        Ok(())
    }

    fn disable(&mut self) {
        self.watchdog.switch_off();
    }

    fn exchange(&mut self, due_ns: u64, _torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        self.read(due_ns).map(Measurement::from)
    }

    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        if self.watchdog.ran_out() {
            return Err(ApparatusError::Watchdog);
        }
        if !torque_mnm.is_finite() {
            self.watchdog.command(0.0);
            return Err(ApparatusError::Amplifier);
        }
        let limit_mnm = self.description.limits.motor_torque_mnm;
        self.watchdog.command(torque_mnm.clamp(-limit_mnm, limit_mnm));
        Ok(())
    }
}
