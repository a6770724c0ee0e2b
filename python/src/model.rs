//! Models: loaded, changed, composed, saved.

use std::path::PathBuf;

use archive::whole_file::{Replace, write_bytes};
use dynamics::{Composition, Motion, Role, Source};
use numpy::{IntoPyArray as _, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::ModelOrName;
use crate::error::{Error, raised};

/// A knob as numbers: a named list of effects with their parameters.
///
/// Models do not change; `change` and `compose` make new ones.
#[pyclass(frozen, eq, module = "haptic_camera")]
#[derive(PartialEq)]
pub(crate) struct Model {
    pub(crate) model: dynamics::Model,
}

impl From<dynamics::Model> for Model {
    fn from(model: dynamics::Model) -> Self {
        Self { model }
    }
}

#[pymethods]
impl Model {
    /// Load a model.
    ///
    /// Parameters
    /// ----------
    /// source : str, os.PathLike or int
    ///     A model file, or 1 to 5 for the knobs of Swindells and MacLean 2007 (Tables 5 and 6).
    ///
    /// Raises
    /// ------
    /// Error
    ///     If there is no such knob, or the file is no model.
    #[staticmethod]
    fn load(source: ModelOrName) -> PyResult<Self> {
        source.model().map(Self::from)
    }

    /// A model from the text of a model file.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        dynamics::Model::from_toml(text, "the text").map(Self::from).map_err(raised)
    }

    /// Compose a model of one knob's inertia, another's friction and a third one's detents.
    ///
    /// Parameters
    /// ----------
    /// inertia, friction, detents : Model, str, os.PathLike or int, optional
    ///     Where each part comes from.
    /// extra : dict of str to Model, str, os.PathLike or int, optional
    ///     One more effect each, by its name: ``{"backlash": 5}``.
    /// name : str, optional
    ///     What the model is called.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If a source lacks the part, or two parts have one effect.
    #[staticmethod]
    #[pyo3(signature = (*, inertia=None, friction=None, detents=None, extra=None, name="composed"))]
    fn compose(
        inertia: Option<ModelOrName>,
        friction: Option<ModelOrName>,
        detents: Option<ModelOrName>,
        extra: Option<Bound<'_, PyDict>>,
        name: &str,
    ) -> PyResult<Self> {
        let mut composition = Composition::default();
        let mut parts = Vec::new();
        for (role, part) in [(Role::Inertia, inertia), (Role::Friction, friction), (Role::Detents, detents)] {
            if let Some(part) = part {
                let source = source(part)?;
                composition.take(role, &source).map_err(raised)?;
                parts.push(format!("{role} of {}", source.label));
            }
        }
        for (effect, from) in extra.into_iter().flatten() {
            let (effect, source): (String, Source) = (effect.extract()?, source(from.extract()?)?);
            composition.take_effect(&effect, &source).map_err(raised)?;
            parts.push(format!("{effect} of {}", source.label));
        }
        if parts.is_empty() {
            return Err(Error::new_err(
                "nothing was named to compose a model of; give inertia, friction, detents or extra",
            ));
        }
        Ok(Self { model: composition.model(name, &parts.join(", ")) })
    }

    /// The model with other values for some of its parameters, by their names: ``model.change(detent_amplitude=1.5)``.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If the model has no such parameter, or the value is out of its range.
    #[pyo3(signature = (**values))]
    fn change(&self, values: Option<Bound<'_, PyDict>>) -> PyResult<Self> {
        let source = Source::new(self.model.name.clone(), self.model.clone());
        let mut composition = Composition::default();
        for effect in &self.model.effects {
            composition.take_effect(effect.kind().name, &source).map_err(raised)?;
        }
        for (name, value) in values.into_iter().flatten() {
            composition.set(&name.extract::<String>()?, value.extract()?).map_err(raised)?;
        }
        Ok(Self { model: composition.model(&self.model.name, &self.model.description) })
    }

    /// What the knob is called.
    #[getter]
    fn name(&self) -> &str {
        &self.model.name
    }

    /// What it is like, or where its numbers come from.
    #[getter]
    fn description(&self) -> &str {
        &self.model.description
    }

    /// Names of its effects.
    #[getter]
    fn effects(&self) -> Vec<&'static str> {
        self.model.effects.iter().map(|effect| effect.kind().name).collect()
    }

    /// Values of its parameters by name, in the units of `units`.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        self.model.parameters().try_for_each(|(kind, value)| values.set_item(kind.name, value))?;
        Ok(values)
    }

    /// Units of its parameters by name.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        self.model.parameters().try_for_each(|(kind, _)| units.set_item(kind.name, kind.unit))?;
        Ok(units)
    }

    /// What the torque sensor reads while the knob goes through a motion, from rest, all effects together.
    ///
    /// Parameters
    /// ----------
    /// t_s, angle_rad, velocity_rad_s, acceleration_rad_s2 : ndarray of float64, shape (n,)
    ///     The motion: time, s, rising; angle, rad; velocity, rad/s; acceleration, rad/s².
    ///
    /// Returns
    /// -------
    /// ndarray of float64, shape (n,)
    ///     Torque, mNm. Where the velocity is exactly zero, friction without bristles is left out: there it is whatever holds
    ///     the knob. A delay of the sensor is not applied.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If the arrays differ in length.
    fn torque_mnm<'py>(
        &self,
        py: Python<'py>,
        t_s: PyReadonlyArray1<'py, f64>,
        angle_rad: PyReadonlyArray1<'py, f64>,
        velocity_rad_s: PyReadonlyArray1<'py, f64>,
        acceleration_rad_s2: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let columns = [&t_s, &angle_rad, &velocity_rad_s, &acceleration_rad_s2].map(|column| column.as_array());
        if columns.iter().any(|column| column.len() != columns[0].len()) {
            return Err(Error::new_err(format!(
                "the columns of the motion have {:?} values; give columns of one length",
                columns.map(|column| column.len())
            )));
        }
        let [time, angle, velocity, acceleration] = columns;
        let motions: Vec<Motion> = (0..time.len())
            .map(|row| Motion {
                time_s: time[row],
                angle_rad: angle[row],
                velocity_rad_s: velocity[row],
                acceleration_rad_s2: acceleration[row],
            })
            .collect();
        Ok(py.detach(|| self.model.readings_mnm(&motions)).into_pyarray(py))
    }

    /// The model as a model file has it, with a comment on every parameter.
    fn to_toml(&self) -> String {
        self.model.to_toml()
    }

    /// Write a model file.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If there is a file already and `overwrite` is false, or the folder cannot be written to.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn save(&self, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let replaced = if overwrite { Replace::Anything } else { Replace::Nothing };
        write_bytes(&path, replaced, self.to_toml().as_bytes()).map_err(raised)
    }

    fn __repr__(&self) -> String {
        format!("<Model {:?}: {}>", self.model.name, self.effects().join(", "))
    }

    /// Pickled as the text of its file.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_toml")?, (slf.get().to_toml(),)))
    }
}

fn source(given: ModelOrName) -> PyResult<Source> {
    given.named().map(|(name, model)| Source::new(name, model))
}
