//! A rendering on the simulated rig, tick by tick: no clock, no other thread.

#![allow(dead_code, reason = "each test uses some of it")]

use clap::Parser as _;
use dynamics::{Calibration, Effect, Model, effects, knobs};
use hal::{Apparatus, Measurement};
use rt_loop::admission::Admission;
use rt_loop::control::rendering::RenderedModel;
use rt_loop::control::{ControlState, Reading, Request, StepOutput};
use rt_loop::plan::Plan;
use rt_loop::request::Options;

const RATE_HZ: f64 = 10_000.0;

/// The simulated rig with a hand on it and the control step that renders knob 3.
pub struct Bench {
    pub control: ControlState,
    pub admission: Admission,
    apparatus: Box<dyn Apparatus>,
    time_tick: u64,
}

impl Bench {
    /// Armed, with a hand that follows several sines.
    pub fn new() -> Self {
        Self::on_rig(&["--hand=multisine", "--duration-s=3"], |_| ())
    }

    /// The same with other arguments, on a rig of which `knowing` has its word.
    pub fn on_rig(further: &[&str], knowing: impl Fn(&mut Calibration)) -> Self {
        let arguments = [&["rt-loop", "--render=3", "--seed=5"], further].concat();
        let mut plan = Plan::new(&Options::try_parse_from(arguments).unwrap().into()).unwrap();
        knowing(&mut plan.rig.calibration);
        let rendering = plan.rendering.unwrap();
        let mut control =
            ControlState::new(plan.control, &plan.rig.calibration).unwrap().with_renderer(rendering.renderer);
        let mut apparatus = plan.apparatus;
        apparatus.enable().unwrap();
        control.arm();
        Self { control, admission: rendering.admission, apparatus, time_tick: 0 }
    }

    /// Begins the run after some ticks armed.
    pub fn start(&mut self) {
        for _ in 0..1_000 {
            let measurement = self.read(1);
            let output = self.step(1, measurement);
            self.write(&output);
        }
        assert!(self.control.request(Request::Start));
    }

    pub fn read(&mut self, elapsed_ticks: u64) -> Measurement {
        self.time_tick += elapsed_ticks;
        self.apparatus.exchange((self.time_tick as f64 * 1e9 / RATE_HZ) as u64, 0.0).unwrap()
    }

    pub fn step(&mut self, elapsed_ticks: u64, measurement: Measurement) -> StepOutput {
        self.control.step(&Reading { elapsed_ticks, measurement: Ok(measurement) })
    }

    pub fn write(&mut self, output: &StepOutput) {
        self.apparatus.write_torque(output.torque_mnm).unwrap();
    }

    /// A knob that never sticks, ready for the renderer.
    pub fn sliding(&self, inertia: f64, viscous: f64, detent_amplitude_mnm: f64) -> Box<RenderedModel> {
        let effects = vec![
            Effect::new(&effects::inertia::KIND, &[inertia]),
            Effect::new(&effects::friction::KIND, &[0.0, 0.0, viscous, viscous]),
            Effect::new(&effects::detent::KIND, &[detent_amplitude_mnm, 0.034, 0.0]),
        ];
        let model = Model { name: "sliding".to_owned(), description: String::new(), effects, ..Model::default() };
        self.admission.admit(&model).unwrap().rendered
    }

    /// The nearest to knob 5, which has an inner body behind a gap, ready for the renderer.
    pub fn two_bodies(&self) -> Box<RenderedModel> {
        self.admission.nearest(&knobs::paper_knob(5).unwrap()).unwrap().admitted.rendered
    }

    /// Knob 3 with another parameter, ready for the renderer.
    pub fn tuned(&self, effect: &str, index: usize, value: f64) -> Box<RenderedModel> {
        let mut model: Model = knobs::paper_knob(3).unwrap();
        let effect = model.effects.iter_mut().find(|known| known.kind().name == effect).unwrap();
        effect.values_mut()[index] = value;
        self.admission.admit(&model).unwrap().rendered
    }
}
