//! The rendering step: measurement in, torque for the motor out.

use biquad::{Biquad as _, DirectForm2Transposed};
use dynamics::Calibration;
use hal::Measurement;
use shared_types::Sample;

use super::super::servo::{across_ticks, notch};
use super::cross_fade::CrossFade;
use super::gains::RenderGains;
use super::passivity::{PassivityObserver, Tick};
use super::rendered_model::RenderedModel;
use super::slow_part::{slow_part, taken_in};
use super::virtual_knob::VirtualKnob;

/// The input of a rendering step.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a> {
    /// The sensors.
    pub measurement: &'a Measurement,
    /// Way of the encoder since the last tick over the time since then, rad/s.
    pub velocity_rad_s: f64,
    /// Ticks since the last step: one, or more after a stall.
    pub elapsed_ticks: u64,
    /// Time since the start, s.
    pub time_s: f64,
    /// Length of a tick, s.
    pub step_s: f64,
}

/// What a rendering step gives.
#[derive(Clone, Copy, Debug)]
pub struct Rendered {
    /// Torque for the motor, mNm, not yet clipped to its limit.
    pub torque_mnm: f64,
    /// Angle of the virtual body at the reading, rad.
    pub angle_rad: f64,
    /// Angle at the reading of what friction and detents act on, rad: the same, or that of the inner body of two.
    pub inner_angle_rad: f64,
    /// Whether what friction and detents act on is at rest.
    pub stuck: bool,
    /// Whether another model begins to be rendered.
    pub begins_another: bool,
    /// Whether the guard took energy back.
    pub guarded: bool,
}

impl Rendered {
    /// Its bits of [`Sample::flags`].
    #[must_use]
    pub fn flags(&self) -> u32 {
        let bit = |set: bool, bit: u32| if set { bit } else { 0 };
        bit(self.begins_another, Sample::MODEL_TAKEN)
            | bit(self.stuck, Sample::STUCK)
            | bit(self.guarded, Sample::GUARDED)
    }
}

/// The renderer with its state.
#[derive(Clone, Debug)]
pub struct Renderer {
    gains: RenderGains,
    motor_inertia: f64,
    motor_torque_mnm: f64,
    /// The motor's own Coulomb friction, which the knob is not to have, mNm.
    coulomb_mnm: f64,
    torque_zero_mnm: f64,
    notch: Option<DirectForm2Transposed<f64>>,
    slow: DirectForm2Transposed<f64>,
    fade: CrossFade,
    knob: VirtualKnob,
    /// Slow part of the angle by which the rotor is ahead of the body, rad.
    given_way_rad: f64,
    /// What the filters were given last.
    hand_mnm: f64,
    spring_mnm: f64,
    observer: PassivityObserver,
    previous_angle_rad: Option<f64>,
}

impl Renderer {
    /// A renderer at rest, for a motor of at most `motor_torque_mnm` whose torque shows `late_ticks` later than on a rig that reads and
    /// drives at the tick; `None` when the rate is too low for its filters.
    #[must_use]
    pub fn new(
        model: Box<RenderedModel>,
        gains: RenderGains,
        calibration: &Calibration,
        motor_torque_mnm: f64,
        rate_hz: f64,
        late_ticks: f64,
    ) -> Option<Self> {
        Some(Self {
            gains,
            motor_inertia: calibration.motor_inertia,
            motor_torque_mnm,
            coulomb_mnm: calibration.motor_coulomb_mnm.unwrap_or(0.0),
            torque_zero_mnm: calibration.torque_zero_mnm,
            notch: notch(gains.notch_hz, gains.notch_depth, gains.notch_width, rate_hz).map(DirectForm2Transposed::new),
            slow: DirectForm2Transposed::new(slow_part(gains.slow_edge_hz, gains.slow_damping, rate_hz)?),
            fade: CrossFade::new(model),
            knob: VirtualKnob::at_rest(0.0),
            given_way_rad: 0.0,
            hand_mnm: 0.0,
            spring_mnm: 0.0,
            observer: PassivityObserver::new(gains.slack, gains.damping, late_ticks),
            previous_angle_rad: None,
        })
    }

    /// Begins at this angle, at rest.
    pub fn begin(&mut self, angle_rad: f64) {
        self.knob = VirtualKnob::at_rest(angle_rad);
        self.given_way_rad = 0.0;
    }

    /// Takes a model that is to be felt from now on; `Err` gives it back while the one before still waits.
    ///
    /// # Errors
    /// The model, when too many came at once.
    pub fn take(&mut self, model: Box<RenderedModel>) -> Result<(), Box<RenderedModel>> {
        self.fade.take(model)
    }

    /// A model that is no longer needed, to be freed elsewhere.
    pub fn retired(&mut self) -> Option<Box<RenderedModel>> {
        self.fade.retired()
    }

    /// After a stall, during which nothing held the rotor, moves a sliding body on with it: otherwise the coupling would make
    /// up for the whole way at once. A sticking body stays where it is.
    fn catch_up(&mut self, elapsed_ticks: u64, velocity_rad_s: f64, step_s: f64) {
        if elapsed_ticks > 1 {
            self.knob.carry_on(velocity_rad_s * step_s * (elapsed_ticks - 1) as f64);
        }
    }

    /// One tick.
    pub fn step(&mut self, input: &StepInput<'_>) -> Rendered {
        let StepInput { measurement, velocity_rad_s, elapsed_ticks, time_s, step_s } = *input;
        self.catch_up(elapsed_ticks, velocity_rad_s, step_s);
        let inner_start_rad = self.knob.inner_angle_rad();
        let begins_another = self.fade.advance(step_s);
        let (start_rad, start_rad_s) = (self.knob.angle_rad(), self.knob.velocity_rad_s());
        let way_rad = measurement.angle_rad
            - self.previous_angle_rad.replace(measurement.angle_rad).unwrap_or(measurement.angle_rad);
        let correction_mnm = self.observer.correction_mnm(way_rad, step_s);
        // The sensor reads what the rig puts into the gripper; the hand puts in the opposite.
        let hand_mnm = self.torque_zero_mnm - measurement.torque_mnm;
        let slow_mnm = across_ticks(elapsed_ticks, self.hand_mnm, hand_mnm, |input| self.slow.run(input));
        let ahead_rad = measurement.angle_rad + self.gains.lead_s * velocity_rad_s - start_rad;
        self.given_way_rad += taken_in(self.gains.place_edge_hz, step_s) * (ahead_rad - self.given_way_rad);
        let spring_mnm = self.gains.stiffness_mnm_rad * ahead_rad + self.gains.damping * (velocity_rad_s - start_rad_s);
        let coupling_mnm = self.notch.as_mut().map_or(spring_mnm, |notch| {
            across_ticks(elapsed_ticks, self.spring_mnm, spring_mnm, |input| notch.run(input))
        });
        (self.hand_mnm, self.spring_mnm) = (hand_mnm, spring_mnm);
        // The body feels no more than the motor can pass on: otherwise a clipped command would give out energy.
        let drive_mnm = (slow_mnm + coupling_mnm).clamp(-self.motor_torque_mnm, self.motor_torque_mnm);
        let forces = self.fade.forces();
        let work = self.knob.advance(&forces, drive_mnm, self.given_way_rad, time_s, step_s);
        let acceleration_rad_s2 = (self.knob.velocity_rad_s() - start_rad_s) / step_s;
        let rendered_mnm = self.motor_inertia * acceleration_rad_s2 - drive_mnm;
        let kept = self.knob.kept(&forces, self.motor_inertia);
        self.observer.note(&Tick { rendered_mnm: rendered_mnm + correction_mnm, kept, work });
        Rendered {
            torque_mnm: rendered_mnm + correction_mnm + self.coulomb_mnm * self.knob.sliding(),
            angle_rad: start_rad,
            inner_angle_rad: inner_start_rad,
            stuck: self.knob.is_stuck(),
            begins_another,
            guarded: correction_mnm != 0.0,
        }
    }
}
