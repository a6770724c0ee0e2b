//! Models: loaded, changed, composed, saved.

use std::path::PathBuf;

use archive::whole_file::{Replace, write_bytes};
use dynamics::{Composition, Motion, Parts, Role, Source, TorqueTable, composition_notes};
use numpy::{IntoPyArray as _, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::convert::{Column, ModelOrName, name_and_unit_on};
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
    ///     Where each part comes from. Detents may be drawn, too: a CSV file with the header ``angle_rad,torque_mnm``, or a pair of
    ///     columns, angle (rad, rising) and torque (mNm). Either is one period, whose last point repeats the first.
    /// extra : dict of str to Model, str, os.PathLike or int, optional
    ///     One more effect each, by its name: ``{"backlash": 5}``.
    /// name : str, optional
    ///     What the model is called.
    ///
    /// Raises
    /// ------
    /// Error
    ///     If a source lacks the part, two parts have one effect, or a drawn torque does not repeat.
    #[staticmethod]
    #[pyo3(signature = (*, inertia=None, friction=None, detents=None, extra=None, name="composed"))]
    fn compose(
        inertia: Option<ModelOrName>,
        friction: Option<ModelOrName>,
        detents: Option<Detents>,
        extra: Option<Bound<'_, PyDict>>,
        name: &str,
    ) -> PyResult<Self> {
        let mut parts = Parts::default();
        for (role, part) in [
            (Role::Inertia, inertia.map(ModelOrName::source)),
            (Role::Friction, friction.map(ModelOrName::source)),
            (Role::Detents, detents.map(Detents::source)),
        ] {
            parts.roles.extend(part.transpose()?.map(|source| (role, source)));
        }
        for (effect, from) in extra.into_iter().flatten() {
            parts.effects.push((effect.extract()?, from.extract::<ModelOrName>()?.source()?));
        }
        if parts == Parts::default() {
            return Err(Error::new_err(
                "nothing was named to compose a model of; give inertia, friction, detents or extra",
            ));
        }
        parts.composition().map_err(raised).map(|composition| composition.model(name, &parts.description()).into())
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
            let name: String = name.extract()?;
            let within = self.model.axis.name_within(&name).unwrap_or(name);
            composition.set(&within, value.extract()?).map_err(raised)?;
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

    /// Where its effects act together otherwise than one may expect, a sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        composition_notes(&self.model)
            .iter()
            .map(|note| self.model.axis.words(&note.to_string()).into_owned())
            .collect()
    }

    /// Values of its parameters by name, in the units of `units`.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        self.parameters_with_units().try_for_each(|(name, _, value)| values.set_item(name, value))?;
        Ok(values)
    }

    /// Units of its parameters by name.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        self.parameters_with_units().try_for_each(|(name, unit, _)| units.set_item(name, unit))?;
        Ok(units)
    }

    /// "rotary" for a knob that is turned, "linear" for what is pressed or slid: mm stand for rad then, and N for mNm.
    #[getter]
    fn axis(&self) -> String {
        self.model.axis.to_string()
    }

    /// What the torque sensor reads while the knob goes through a motion, from rest, all effects together.
    ///
    /// Parameters
    /// ----------
    /// t_s, angle_rad, velocity_rad_s, acceleration_rad_s2 : array_like of float, shape (n,)
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
        t_s: Column,
        angle_rad: Column,
        velocity_rad_s: Column,
        acceleration_rad_s2: Column,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let columns = [t_s, angle_rad, velocity_rad_s, acceleration_rad_s2].map(|Column(column)| column);
        let rows = columns.each_ref().map(Vec::len);
        if rows.iter().any(|other| *other != rows[0]) {
            return Err(Error::new_err(format!(
                "the columns of the motion have {rows:?} values; give columns of one length"
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

impl Model {
    fn parameters_with_units(&self) -> impl Iterator<Item = (String, String, f64)> {
        self.model.parameters().map(|(kind, value)| {
            let (name, unit) = name_and_unit_on(self.model.axis, kind.name, kind.unit);
            (name, unit, value)
        })
    }
}

/// Where detents come from: a knob, or a drawn torque over the angle.
enum Detents {
    Of(ModelOrName),
    Drawn([Column; 2]),
}

impl FromPyObject<'_, '_> for Detents {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match (given.extract(), given.try_iter()) {
            (Ok(knob), _) => Ok(Self::Of(knob)),
            (Err(_), Ok(columns)) => {
                let columns: Vec<Column> = columns.map(|column| column?.extract()).collect::<PyResult<_>>()?;
                let pair = columns.try_into().map_err(|columns: Vec<Column>| {
                    Error::new_err(format!(
                        "drawn detents are a pair of columns, angle_rad and torque_mnm; {} were given",
                        columns.len()
                    ))
                });
                pair.map(Self::Drawn)
            }
            (Err(error), Err(_)) => Err(error),
        }
    }
}

impl Detents {
    fn source(self) -> PyResult<Source> {
        match self {
            Self::Of(knob) => knob.source(),
            Self::Drawn([Column(angle_rad), Column(torque_mnm)]) => {
                let table = TorqueTable::kept(&angle_rad, &torque_mnm, None).map_err(raised)?;
                Ok(Source::drawn("a drawn table", table))
            }
        }
    }
}
