//! A rig whose sensors panic on demand, for drills.

use hal::{Apparatus, ApparatusError, Measurement, RigDescription};
use shared_types::fault_injection::FaultInjection;

/// An apparatus whose next reading, on the real-time thread, panics once the signal of `fault` came.
pub struct PanickingApparatus {
    apparatus: Box<dyn Apparatus>,
    fault: FaultInjection,
}

impl PanickingApparatus {
    /// `apparatus`, listening for `fault`.
    #[must_use]
    pub fn new(apparatus: Box<dyn Apparatus>, fault: FaultInjection) -> Self {
        Self { apparatus, fault }
    }
}

impl Apparatus for PanickingApparatus {
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
        self.fault.panic_if_requested();
        self.apparatus.exchange(due_ns, torque_mnm)
    }

    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.apparatus.write_torque(torque_mnm)
    }

    fn shift_ns(&self) -> i64 {
        self.apparatus.shift_ns()
    }
}
