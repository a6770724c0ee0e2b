//! A rig whose sensors panic on demand, for drills.

use hal::{Apparatus, ApparatusError, Measurement, RigDescription};
use shared_types::drill::Drill;

/// An apparatus whose next reading panics once the drill's signal came: on the real-time thread, where else none would.
pub struct DrilledApparatus {
    apparatus: Box<dyn Apparatus>,
    drill: Drill,
}

impl DrilledApparatus {
    /// `apparatus`, listening for `drill`.
    #[must_use]
    pub fn new(apparatus: Box<dyn Apparatus>, drill: Drill) -> Self {
        Self { apparatus, drill }
    }
}

impl Apparatus for DrilledApparatus {
    fn description(&self) -> &RigDescription {
        self.apparatus.description()
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        self.apparatus.enable()
    }

    fn disable(&mut self) {
        self.apparatus.disable();
    }

    fn prepare(&mut self, stop: &dyn Fn() -> bool) -> Result<(), ApparatusError> {
        self.apparatus.prepare(stop)
    }

    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        self.drill.panic_if_told();
        self.apparatus.exchange(due_ns, torque_mnm)
    }

    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.apparatus.write_torque(torque_mnm)
    }

    fn shift_ns(&self) -> i64 {
        self.apparatus.shift_ns()
    }
}
