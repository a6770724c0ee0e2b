//! Diagnoses, which tell their progress and stop at Ctrl-C.

use std::any::Any;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};

use analysis::{AnalysisError, DiagnosisResult, diagnosed_model, refuse_drawn};
use identification::diagnosis;
use loaded_capture::LoadedCapture;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use report::{DiagnosisPage, FigureNumbers};

use crate::convert::{CaptureOrPath, ModelOrName, framed, json_on, not_pickled, save_page, to_dict};
use crate::error::raised;
use crate::interruptible::BETWEEN_LOOKS;
use crate::model::Model;

/// How far a diagnosis has come.
#[pyclass(frozen, get_all, module = "haptic_camera")]
pub(crate) struct Progress {
    /// The effect that was tried, or that was added.
    effect: &'static str,
    /// Effects tried in this step; 0 where one was added.
    done: usize,
    /// Effects to try in this step; 0 where one was added.
    of: usize,
    /// RMS left on the held-out capture with an effect that was added, in noise floors; None while effects are tried.
    heldout_over_floor: Option<f64>,
}

impl From<diagnosis::Progress> for Progress {
    fn from(progress: diagnosis::Progress) -> Self {
        match progress {
            diagnosis::Progress::Tried { effect, done, of } => Self { effect, done, of, heldout_over_floor: None },
            diagnosis::Progress::Added { effect, heldout_over_floor } => {
                Self { effect, done: 0, of: 0, heldout_over_floor: Some(heldout_over_floor) }
            }
        }
    }
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        match self.heldout_over_floor {
            Some(over) => format!("<Progress: added {}, {over:.2} times the noise is left>", self.effect),
            None => format!("<Progress: tried {}, {} of {}>", self.effect, self.done, self.of),
        }
    }
}

/// What a model lacks.
///
/// Results do not change; `to_dict` gives what ``haptic-camera diagnose --json`` writes.
#[pyclass(frozen, module = "haptic_camera")]
pub(crate) struct Diagnosis {
    found: diagnosis::Diagnosis,
    train: Arc<LoadedCapture>,
    heldout: Option<Arc<LoadedCapture>>,
}

/// Find where a model and a capture disagree, and name the missing effects.
///
/// Parameters
/// ----------
/// train : Capture, str or os.PathLike
///     The capture that models are fitted to.
/// heldout : Capture, str or os.PathLike, optional
///     A capture of the same knob by which they are judged; without it stretches of `train` are held out, which is
///     weaker evidence.
/// model : Model, str, os.PathLike or int, optional
///     The model to start from; without it inertia, friction and detents as they are fitted.
/// progress : callable, optional
///     Called with a `Progress` after every effect that was tried or added. What it raises ends the diagnosis.
///
/// Returns
/// -------
/// Diagnosis
///
/// Raises
/// ------
/// Error
///     If there can be no meaningful verdict.
/// KeyboardInterrupt
///     At Ctrl-C, as soon as the effects that are being tried are done.
#[pyfunction]
#[pyo3(signature = (train, heldout=None, *, model=None, progress=None))]
pub(crate) fn diagnose(
    py: Python<'_>,
    train: CaptureOrPath,
    heldout: Option<CaptureOrPath>,
    model: Option<ModelOrName>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Diagnosis> {
    let train = train.loaded(py)?;
    let heldout = heldout.map(|capture| capture.loaded(py)).transpose()?;
    let model = model.map(ModelOrName::named).transpose()?;
    if let Some((called, model)) = &model {
        refuse_drawn(model, called).map_err(raised)?;
    }
    let model = model.map(|(_, model)| model);
    let found = py.detach(|| watched(&train, heldout.as_deref(), model, progress.as_ref()))?;
    let (train, heldout) = found.in_their_roles(train, heldout);
    Ok(Diagnosis { found, train, heldout })
}

/// What ends a diagnosis from within its progress.
struct Interrupted;

/// Diagnoses on a thread of its own, while this one passes progress on and looks at Ctrl-C, of which Python notifies only its main thread.
fn watched(
    train: &LoadedCapture,
    heldout: Option<&LoadedCapture>,
    model: Option<dynamics::Model>,
    progress: Option<&Py<PyAny>>,
) -> PyResult<diagnosis::Diagnosis> {
    let interrupted = AtomicBool::new(false);
    let (sender, receiver) = channel();
    std::thread::scope(|scope| {
        let interrupted = &interrupted;
        let worker = scope.spawn(move || {
            let tell = move |progress| {
                if interrupted.load(Ordering::Relaxed) {
                    // A diagnosis has no half result: it is left by the way of a panic, without its message.
                    resume_unwind(Box::new(Interrupted));
                }
                // Nobody listens once the diagnosis is to end.
                let _ = sender.send(progress);
            };
            analysis::diagnose(train, heldout, model, Some(&tell))
        });
        let listened = listen(&receiver, progress);
        interrupted.store(listened.is_err(), Ordering::Relaxed);
        let ended: Result<Result<_, AnalysisError>, Box<dyn Any + Send>> = worker.join();
        listened?;
        match ended {
            Ok(found) => found.map_err(raised),
            Err(panic) => resume_unwind(panic),
        }
    })
}

/// Passes progress on until the diagnosis is done.
fn listen(receiver: &Receiver<diagnosis::Progress>, progress: Option<&Py<PyAny>>) -> PyResult<()> {
    loop {
        let received = receiver.recv_timeout(BETWEEN_LOOKS);
        if let Err(RecvTimeoutError::Disconnected) = received {
            return Ok(());
        }
        Python::attach(|py| {
            py.check_signals()?;
            if let (Ok(step), Some(progress)) = (received, progress) {
                progress.call1(py, (Progress::from(step),))?;
            }
            PyResult::Ok(())
        })?;
    }
}

impl Diagnosis {
    fn page(&self) -> DiagnosisPage<'_> {
        let heldout = self.heldout.as_ref().map(|capture| analysis::facts(capture));
        DiagnosisPage { found: &self.found, train: analysis::facts(&self.train), heldout }
    }

    /// A text in the words of the axis that was diagnosed.
    fn said(&self, text: &str) -> String {
        self.train.capture.axis.words(text).into_owned()
    }
}

#[pymethods]
impl Diagnosis {
    /// What is missing: "none", "effects", or "outside-library" for what no known effect explains.
    #[getter]
    fn verdict(&self) -> &'static str {
        match self.found.verdict {
            diagnosis::Verdict::None => "none",
            diagnosis::Verdict::Effects => "effects",
            diagnosis::Verdict::OutsideLibrary => "outside-library",
        }
    }

    /// Whether nothing else is missing.
    #[getter]
    fn complete(&self) -> bool {
        self.found.complete
    }

    /// Whether `heldout` was trained on and `train` held out, since what is missing could be named so only.
    #[getter]
    fn captures_are_exchanged(&self) -> bool {
        self.found.captures_are_exchanged
    }

    /// The effects that were added, strongest first.
    #[getter]
    fn effects(&self) -> Vec<&'static str> {
        self.found.effects.clone()
    }

    /// The verdict in one sentence.
    #[getter]
    fn summary(&self) -> String {
        self.said(&self.found.summary)
    }

    /// RMS that the model without further effects leaves of the held-out capture, mNm; of what is pressed or slid N.
    #[getter]
    fn heldout_rms_before(&self) -> f64 {
        self.found.heldout_rms_before
    }

    /// RMS that the final model leaves of it, in the same unit.
    #[getter]
    fn heldout_rms_after(&self) -> f64 {
        self.found.heldout_rms_after
    }

    /// RMS that the sensors' noise leaves beside a complete model, in the same unit.
    #[getter]
    fn noise_floor_rms(&self) -> f64 {
        self.found.noise_floor_rms
    }

    /// The model with all that was added.
    fn model(&self) -> Model {
        Model::from(diagnosed_model(&self.found, &[&self.train]))
    }

    /// Everything that ``haptic-camera diagnose --json`` writes, under its keys.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_dict(py, self.to_json()?)
    }

    /// The same as text.
    fn to_json(&self) -> PyResult<String> {
        json_on(self.train.capture.axis, &DiagnosisResult::of(&self.page(), FigureNumbers::new()))
    }

    /// The report page, one HTML file that fetches nothing.
    fn to_html(&self) -> String {
        self.said(&report::diagnosis_page(&self.page()))
    }

    /// Write the report page.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn save_report(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        save_page(py, &path, overwrite, || self.to_html())
    }

    /// The report page in a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> String {
        framed(&py.detach(|| self.to_html()))
    }

    fn __repr__(&self) -> String {
        format!("<Diagnosis: {}>", self.summary())
    }

    /// Its captures are not copied about.
    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a diagnosis", "its model() or its to_dict()"))
    }
}
