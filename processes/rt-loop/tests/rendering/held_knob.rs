//! A rendered knob in a simulated hand, tick by tick, with the plant's truth beside it.

use dynamics::{CoggingHarmonic, Model, Motion, knobs::Fixture};
use hal::Apparatus as _;
use hal::Measurement;
use hal::simulated_rig::{Cogging, Hand, RigParameters, SimulatedRig};
use rt_loop::control::CoggingCompensation;
use rt_loop::control::rendering::{RenderGains, Rendered, RenderedModel, Renderer, StepInput};

/// Torque of the simulated motor, mNm: commands are clipped to it, as the loop does.
const MOTOR_MNM: f64 = 360.8;

/// A knob that is only rendered.
pub struct HeldKnob {
    pub rig: SimulatedRig,
    pub renderer: Renderer,
    pub rate_hz: f64,
    cogging: CoggingCompensation,
    tick: u64,
    previous_rad: Option<f64>,
    /// Work of the hand on the gripper so far, mNm·rad, by the plant's truth.
    pub work_of_hand: f64,
    /// The command before, mNm.
    pub torque_mnm: f64,
}

impl HeldKnob {
    /// A rig at rest that renders `model` under `gains`, in `hand`.
    pub fn new(model: &Model, gains: RenderGains, hand: Option<Hand>, rate_hz: f64, seed: u64) -> Self {
        Self::on_motor(&[], model, gains, hand, rate_hz, seed)
    }

    /// The same on a motor that cogs, and whose cogging is known and taken out.
    pub fn on_motor(
        cogging: &[Cogging],
        model: &Model,
        gains: RenderGains,
        hand: Option<Hand>,
        rate_hz: f64,
        seed: u64,
    ) -> Self {
        let parameters = RigParameters { motor_cogging: cogging.to_vec(), ..RigParameters::default() };
        Self::on(parameters, cogging, model, gains, hand, rate_hz, seed)
    }

    /// The same on a rig of other parameters, of whose motor this cogging is known.
    pub fn on(
        parameters: RigParameters,
        cogging: &[Cogging],
        model: &Model,
        gains: RenderGains,
        hand: Option<Hand>,
        rate_hz: f64,
        seed: u64,
    ) -> Self {
        let nothing = Fixture::None.model().unwrap();
        let mut rig = SimulatedRig::held(parameters, nothing, hand, seed).unwrap();
        rig.enable().unwrap();
        let mut calibration = rig.description().calibration.clone();
        let known = |harmonic: &Cogging| CoggingHarmonic {
            per_turn: harmonic.per_turn,
            torque_mnm: harmonic.torque_mnm,
            phase_rad: harmonic.phase_rad,
        };
        calibration.motor_cogging = Some(cogging.iter().map(known).collect());
        let cogging = CoggingCompensation::new(&calibration, rate_hz, 0.0);
        let rendered = RenderedModel::new(model, &calibration).unwrap();
        let renderer = Renderer::new(Box::new(rendered), gains, &calibration, MOTOR_MNM, rate_hz, 0.0).unwrap();
        Self { rig, renderer, rate_hz, cogging, tick: 0, previous_rad: None, work_of_hand: 0.0, torque_mnm: 0.0 }
    }

    /// Time of the next tick, s.
    pub fn time_s(&self) -> f64 {
        self.tick as f64 / self.rate_hz
    }

    /// One tick.
    pub fn step(&mut self) -> Rendered {
        let measurement = Measurement::from(self.rig.read((self.time_s() * 1e9).round() as u64).unwrap());
        let truth = self.rig.truth();
        self.work_of_hand += self.rig.applied_by_hand_mnm() * truth.knob_velocity_rad_s / self.rate_hz;
        let previous_rad = self.previous_rad.replace(measurement.angle_rad).unwrap_or(measurement.angle_rad);
        let velocity_rad_s = (measurement.angle_rad - previous_rad) * self.rate_hz;
        let rendered = self.renderer.step(&StepInput {
            measurement: &measurement,
            velocity_rad_s,
            elapsed_ticks: 1,
            time_s: self.time_s(),
            step_s: self.rate_hz.recip(),
        });
        let against_cogging_mnm = self.cogging.torque_mnm(measurement.angle_rad, velocity_rad_s);
        self.torque_mnm = (rendered.torque_mnm + against_cogging_mnm).clamp(-MOTOR_MNM, MOTOR_MNM);
        self.rig.write_torque(self.torque_mnm).unwrap();
        self.tick += 1;
        rendered
    }
}

/// What the spring of a model's contact or shaft holds, the cap being ahead of the inner body by `ahead_rad`, mNm·rad.
pub fn held_by_contact(model: &Model, ahead_rad: f64) -> f64 {
    model.coupling().map_or(0.0, |coupling| {
        let beyond_rad = ahead_rad.abs() - coupling.half_gap_rad;
        0.5 * coupling.stiffness_mnm_rad * beyond_rad.max(0.0).powi(2)
    })
}

/// What detents and springs of a model hold at an angle beyond what they hold at zero, mNm·rad.
pub fn held_by_springs(model: &Model, angle_rad: f64) -> f64 {
    let steps = (angle_rad.abs() / 1e-4).ceil().max(1.0) as i32;
    let step_rad = angle_rad / f64::from(steps);
    let at = |index: i32| {
        let motion = Motion { angle_rad: (f64::from(index) + 0.5) * step_rad, ..Motion::default() };
        model.free_torque_mnm(&motion)
    };
    (0..steps).map(at).sum::<f64>() * step_rad
}
