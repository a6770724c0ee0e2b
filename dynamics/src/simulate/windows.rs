//! How well a model's motion under the measured or the commanded torque follows the measured motion.

use std::ops::Range;

use super::driving::{Driving, RigMotor};
use super::observer::Observer;
use super::{ForwardSimulation, SimulationError};
use crate::{Model, Motion};

/// A step between samples this many times as long as the usual one is a gap in the capture.
const GAP: f64 = 2.5;

/// Errors of the motion predicted over one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowErrors {
    /// Time at which the window starts, s.
    pub start_s: f64,
    /// Number of predicted samples.
    pub samples: usize,
    /// RMS of predicted minus measured angle, rad.
    pub angle_rms_rad: f64,
    /// RMS of predicted minus measured velocity, rad/s.
    pub velocity_rms_rad_s: f64,
}

/// Errors of the motion predicted over a capture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForwardErrors {
    /// Each window, in the order of time.
    pub windows: Vec<WindowErrors>,
    /// RMS of the angle's error over all predicted samples, rad.
    pub angle_rms_rad: f64,
    /// RMS of the velocity's error over all predicted samples, rad/s.
    pub velocity_rms_rad_s: f64,
}

/// Predicts the motion from the torque, anew from the measured motion at the start of every window.
///
/// Over seconds any prediction drifts away (a knob that stays stuck a millisecond longer ends elsewhere), so it is
/// restarted every `window_s`, 0.1 s being a good length: hundreds of samples, and longer than a knob takes to stop.
///
/// `motions` are measured, the first at rest; `readings_mnm` are what the torque sensor read at their times, from which
/// [`Model::knob_torque_mnm`] takes the model's own reading errors.
/// What cannot be measured at a window's start, an inner body or bent bristles, is followed through the whole capture
/// under the measured motion. Samples whose torque would have been read outside the capture are left out, and a gap in
/// the capture starts a new window.
///
/// # Errors
/// [`SimulationError`], for models that cannot be simulated.
pub fn forward_windows(
    model: &Model,
    motions: &[Motion],
    readings_mnm: &[f64],
    window_s: f64,
) -> Result<ForwardErrors, SimulationError> {
    let torque_mnm = model.knob_torque_mnm(motions, readings_mnm);
    follow(model, 0.0, motions, &Driving::Measured(&torque_mnm), model.readings_within(motions), window_s)
}

/// As [`forward_windows`], but from the torque commanded from the rig's motor, which turns itself and the knob; the torque
/// sensor takes no part.
///
/// `commanded_mnm` is what was commanded at the time of each motion, until the next; NaN where that is unknown. The
/// motor's inertia and friction act on the knob, or on its cap. What the amplifier cannot give, and the time that the
/// current takes, are left to the error.
///
/// # Errors
/// [`SimulationError`], for models that cannot be simulated.
pub fn forward_windows_from_command(
    model: &Model,
    motor: &RigMotor,
    motions: &[Motion],
    commanded_mnm: &[f64],
    window_s: f64,
) -> Result<ForwardErrors, SimulationError> {
    let inertia = model.inertia();
    let inertia = motor.inertia + model.coupling().map_or(inertia, |coupling| coupling.inertias(inertia)[0]);
    let driving = Driving::Commanded { torque_mnm: commanded_mnm, motor, inertia };
    follow(model, motor.inertia, motions, &driving, 0..motions.len(), window_s)
}

/// Predicts the motion at the samples of `known`, window by window.
fn follow(
    model: &Model,
    added_inertia: f64,
    motions: &[Motion],
    driving: &Driving<'_>,
    known: Range<usize>,
    window_s: f64,
) -> Result<ForwardErrors, SimulationError> {
    let Some(first) = motions.first() else { return Ok(ForwardErrors::default()) };
    let usual_s = usual_step_s(motions);
    let mut observer = Observer::new(model, first)?;
    let mut window: Option<Window> = None;
    let mut windows = Vec::new();
    let mut before = *first;
    for (index, motion) in motions.iter().enumerate() {
        observer.advance(motion)?;
        let known = known.contains(&index) && driving.is_known(index);
        if !known || motion.time_s - before.time_s > GAP * usual_s {
            windows.extend(window.take());
        } else if let Some(window) = &mut window {
            window.predict(index, motion, driving)?;
        }
        let full = |window: &Window| motion.time_s - window.start_s >= window_s * (1.0 - 1e-9);
        if window.as_ref().is_some_and(full) {
            windows.extend(window.take());
        }
        if window.is_none() && known {
            let torque_mnm = driving.at(index, motion, usual_s);
            let simulation = ForwardSimulation::from_state(model, added_inertia, &observer.state(), torque_mnm)?;
            window = Some(Window::new(simulation, motion, torque_mnm));
        }
        before = *motion;
    }
    windows.extend(window);
    Ok(ForwardErrors::of(&windows))
}

/// One window under way.
struct Window<'model> {
    simulation: ForwardSimulation<'model>,
    start_s: f64,
    /// The motion predicted so far.
    reached: Motion,
    samples: usize,
    squared_angle_errors: f64,
    squared_velocity_errors: f64,
}

impl<'model> Window<'model> {
    fn new(simulation: ForwardSimulation<'model>, motion: &Motion, torque_mnm: f64) -> Self {
        let reached = simulation.motion(torque_mnm);
        let (squared_angle_errors, squared_velocity_errors) = (0.0, 0.0);
        Self { simulation, start_s: motion.time_s, reached, samples: 0, squared_angle_errors, squared_velocity_errors }
    }

    /// Predicts the motion at the next sample and compares.
    fn predict(&mut self, index: usize, measured: &Motion, driving: &Driving<'_>) -> Result<(), SimulationError> {
        let step_s = measured.time_s - self.reached.time_s;
        if step_s > 0.0 {
            let [now_mnm, then_mnm] = driving.over_step(index, &self.reached, step_s);
            self.simulation.advance(step_s, now_mnm, then_mnm)?;
            self.reached = self.simulation.motion(then_mnm);
        }
        self.samples += 1;
        self.squared_angle_errors += (self.reached.angle_rad - measured.angle_rad).powi(2);
        self.squared_velocity_errors += (self.reached.velocity_rad_s - measured.velocity_rad_s).powi(2);
        Ok(())
    }
}

impl ForwardErrors {
    fn of(windows: &[Window]) -> Self {
        let used = || windows.iter().filter(|window| window.samples > 0);
        let each = |window: &Window| WindowErrors {
            start_s: window.start_s,
            samples: window.samples,
            angle_rms_rad: rms(window.squared_angle_errors, window.samples),
            velocity_rms_rad_s: rms(window.squared_velocity_errors, window.samples),
        };
        let samples = used().map(|window| window.samples).sum();
        Self {
            windows: used().map(each).collect(),
            angle_rms_rad: rms(used().map(|window| window.squared_angle_errors).sum(), samples),
            velocity_rms_rad_s: rms(used().map(|window| window.squared_velocity_errors).sum(), samples),
        }
    }
}

fn rms(squares: f64, samples: usize) -> f64 {
    (squares / samples.max(1) as f64).sqrt()
}

/// The median time between samples, s.
fn usual_step_s(motions: &[Motion]) -> f64 {
    let mut steps: Vec<f64> = motions.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { f64::INFINITY } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
