//! What a model must pass before it is rendered, at the start of a run and while it goes on.

use dynamics::{Calibration, Coupling, Model};
use shared_types::MODEL_MAX_BYTES;

use crate::control::rendering::RenderedModel;
use crate::plan::PlanError;
use crate::stability::Bounds;

/// The bounds of a rig under its gains, computed once.
#[derive(Clone, Debug)]
pub struct Admission {
    bounds: Bounds,
    calibration: Calibration,
}

/// A model that may be rendered.
#[derive(Clone, Debug)]
pub struct Admitted {
    /// As the renderer takes it.
    pub rendered: Box<RenderedModel>,
    /// Where the rendering will feel different from the model, in sentences.
    pub remarks: Vec<String>,
}

impl Admission {
    /// What a rig with this calibration renders within these bounds.
    #[must_use]
    pub fn new(bounds: Bounds, calibration: &Calibration) -> Self {
        Self { bounds, calibration: calibration.clone() }
    }

    /// Checks a model and makes it ready for the renderer.
    ///
    /// # Errors
    /// [`PlanError::Unsafe`], [`PlanError::Unrenderable`] or [`PlanError::TooLong`], each with what would do.
    pub fn admit(&self, model: &Model) -> Result<Admitted, PlanError> {
        let bytes = model.to_toml().len();
        if bytes > MODEL_MAX_BYTES {
            return Err(PlanError::TooLong { bytes });
        }
        let rendered = RenderedModel::new(model, &self.calibration)?;
        let mut remarks = self.bounds.check(model)?;
        let is_outweighed = |shaft: Coupling| shaft.inertias(model.inertia())[0] < self.bounds.least_inertia;
        if model.coupling().is_some_and(|shaft| shaft.half_gap_rad == 0.0 && is_outweighed(shaft)) {
            remarks.push(format!(
                "{:.4} mNm·s²/rad of the inertia, gripper and rotor, are in front of the shaft, not behind it",
                self.bounds.least_inertia
            ));
        }
        Ok(Admitted { rendered: Box::new(rendered), remarks })
    }

    /// What detents and springs leave of the largest torque, mNm.
    pub(crate) fn room_for_friction_mnm(&self, model: &Model) -> f64 {
        self.bounds.room_for_friction_mnm(model)
    }

    /// Stiffness, mNm/rad, and damping, mNm·s/rad, nearest to those of the model's contact or shaft; see
    /// [`Bounds::nearest_contact`].
    pub(crate) fn nearest_contact(&self, model: &Model) -> Option<[f64; 2]> {
        self.bounds.nearest_contact(model)
    }
}
