//! A knob that is given its motion and gives its torque.

use std::path::Path;

use dynamics::{Model, ModelError, Motion, TorqueReader};
use simulator_formats::fmi::{MODEL_FILE, Variable};

/// N m in a mNm.
const N_M: f64 = 1e-3;

/// Why a knob does not do what it is asked.
#[derive(Debug, thiserror::Error)]
pub(crate) enum KnobError {
    /// The model in the FMU.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// There is no such variable.
    #[error("there is no variable with the reference {0}")]
    Unknown(u32),
    /// A variable that is not to be set now.
    #[error("the variable with the reference {0} cannot be set now")]
    NotSettable(u32),
    /// A value out of the parameter's range.
    #[error("{parameter} = {value}, but it must be {requirement}")]
    OutOfRange {
        /// The parameter.
        parameter: &'static str,
        /// The value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// An input that is no number.
    #[error("the inputs {0:?} are not finite")]
    NotFinite(Motion),
    /// A step before initialization.
    #[error("initialize the knob before the first step")]
    NotInitialized,
}

/// A knob with its parameters, its inputs and, once it runs, its memory.
pub(crate) struct Knob {
    /// The model as in the FMU.
    written: Model,
    /// The model with its parameters as set.
    model: Model,
    added_inertia: f64,
    motion: Motion,
    torque_mnm: f64,
    running: Option<Running>,
}

impl Knob {
    /// The knob whose model lies among an FMU's resources.
    pub(crate) fn load(resources: &Path) -> Result<Self, KnobError> {
        Ok(Self::new(Model::load(&resources.join(MODEL_FILE))?))
    }

    fn new(written: Model) -> Self {
        let model = written.clone();
        Self { written, model, added_inertia: 0.0, motion: Motion::default(), torque_mnm: 0.0, running: None }
    }

    /// Restores the knob as it was loaded.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.written.clone());
    }

    /// A variable's value; `None` for one that there is not.
    pub(crate) fn value(&self, reference: u32) -> Option<f64> {
        Some(match Variable::of(reference) {
            Variable::Time => self.motion.time_s,
            Variable::Angle => self.motion.angle_rad,
            Variable::Velocity => self.motion.velocity_rad_s,
            Variable::Acceleration => self.motion.acceleration_rad_s2,
            Variable::Torque => N_M * self.torque_mnm,
            Variable::AddedInertia => self.added_inertia,
            Variable::Parameter(index) => self.model.parameters().nth(index)?.1,
        })
    }

    /// Sets an input, or before the first step a parameter.
    pub(crate) fn set(&mut self, reference: u32, value: f64) -> Result<(), KnobError> {
        match Variable::of(reference) {
            Variable::Angle => self.motion.angle_rad = value,
            Variable::Velocity => self.motion.velocity_rad_s = value,
            Variable::Acceleration => self.motion.acceleration_rad_s2 = value,
            Variable::AddedInertia if self.running.is_none() => {
                if !(value >= 0.0 && value.is_finite()) {
                    let (parameter, requirement) = ("added_inertia", "at least zero, and finite");
                    return Err(KnobError::OutOfRange { parameter, value, requirement });
                }
                self.added_inertia = value;
            }
            Variable::Parameter(index) if self.running.is_none() => {
                let (kind, _) = self.model.parameters().nth(index).ok_or(KnobError::Unknown(reference))?;
                if !kind.minimum.permits(value) {
                    let (parameter, requirement) = (kind.name, kind.minimum.requirement());
                    return Err(KnobError::OutOfRange { parameter, value, requirement });
                }
                let mut values = self.model.effects.iter_mut().flat_map(|effect| effect.values_mut());
                *values.nth(index).ok_or(KnobError::Unknown(reference))? = value;
            }
            _ => return Err(KnobError::NotSettable(reference)),
        }
        Ok(())
    }

    /// Takes the time of the beginning.
    pub(crate) fn start_at(&mut self, time_s: f64) {
        self.motion.time_s = time_s;
    }

    /// Begins, from rest at the angle that was set.
    pub(crate) fn begin(&mut self) -> Result<(), KnobError> {
        self.running = Some(Running::of(self.model.clone()));
        self.read_at(self.motion.time_s)
    }

    /// Takes the inputs as those of `time_s`; `after_s` is the time of the output.
    pub(crate) fn step(&mut self, time_s: f64, after_s: f64) -> Result<(), KnobError> {
        self.read_at(time_s)?;
        self.motion.time_s = after_s;
        Ok(())
    }

    fn read_at(&mut self, time_s: f64) -> Result<(), KnobError> {
        self.motion.time_s = time_s;
        let motion = self.motion;
        if ![motion.angle_rad, motion.velocity_rad_s, motion.acceleration_rad_s2].into_iter().all(f64::is_finite) {
            return Err(KnobError::NotFinite(motion));
        }
        let reader = self.running.as_mut().and_then(|running| running.reader.as_mut());
        self.torque_mnm = reader.ok_or(KnobError::NotInitialized)?.read_mnm(&motion)
            - self.model.unsettled_friction_mnm(&motion)
            + self.added_inertia * motion.acceleration_rad_s2;
        Ok(())
    }
}

/// What reads the torque of a model, and that model.
struct Running {
    /// `None` while this is dropped.
    reader: Option<TorqueReader<'static>>,
    model: *mut Model,
}

impl Running {
    #[allow(unsafe_code, reason = "the reader looks at a model that lies beside it")]
    fn of(model: Model) -> Self {
        let model = Box::into_raw(Box::new(model));
        // SAFETY: the model lies there, neither moved nor changed, until `drop`, which ends the reader first.
        Self { reader: Some(TorqueReader::of(unsafe { &*model })), model }
    }
}

impl Drop for Running {
    #[allow(unsafe_code, reason = "the model is this one's own")]
    fn drop(&mut self) {
        self.reader = None;
        // SAFETY: it came from a box, and nothing looks at it any more.
        drop(unsafe { Box::from_raw(self.model) });
    }
}
