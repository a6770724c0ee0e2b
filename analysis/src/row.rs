//! A capture as one row of a table: what it is, what its fit tells, or what is wrong with it.

use std::borrow::Cow;
use std::path::Path;

use dynamics::{Axis, ParameterKind, effects};
use identification::{Fit, PreparationMethod};
use loaded_capture::LoadedCapture;
use sheet::{Sheet, Specification, kinds_of};

use crate::AnalysisError;

/// Endings of the column names of an interval's two ends.
pub const CI95_ENDS: [&str; 2] = ["_ci95_low", "_ci95_high"];

/// A value of a row; `None` where there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(Option<String>),
    /// A number that is counted.
    Count(Option<u64>),
    /// A number that is measured.
    Real(Option<f64>),
}

/// A capture as a row: a cell for each of [`Row::columns`], under the same specification.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    cells: Vec<(String, Cell)>,
    axis: Option<Axis>,
}

impl Row {
    /// Reads and fits a capture, and judges it where there is a specification.
    ///
    /// If there is neither a fit nor a sheet, the column `error` says why; if there is no sheet, the column `sheet_error` says why.
    #[must_use]
    pub fn of(path: &Path, specification: Option<&Specification>) -> Self {
        let loaded = LoadedCapture::load(path);
        let fitted = loaded.as_ref().ok().map(|loaded| crate::fit(loaded, PreparationMethod::default()));
        let error = match (&loaded, &fitted) {
            (Err(error), _) => Some(error.to_string()),
            (_, Some(Err(error))) => Some(error.to_string()),
            _ => None,
        };
        let fit = fitted.as_ref().and_then(|fitted| fitted.as_ref().ok());
        let sheet = specification.map(|_| {
            let curve = match &loaded {
                Ok(loaded) => loaded.curve(),
                Err(_) => loaded_capture::load_curve(path, None)?,
            };
            Ok::<_, AnalysisError>(Sheet::of(&[curve])?)
        });
        let error = error.filter(|_| !matches!(sheet, Some(Ok(_))));
        let mut row = Self::with(path, loaded.as_ref().ok(), fit, error);
        if let (Some(specification), Some(sheet)) = (specification, sheet) {
            row.axis = row.axis.or(sheet.as_ref().ok().map(|sheet| sheet.axis));
            row.judge(specification, Some(sheet));
        }
        row
    }

    /// Adds the verdict and the figures, or why there are none; without a sheet, empty cells.
    fn judge(&mut self, specification: &Specification, sheet: Option<Result<Sheet, AnalysisError>>) {
        let (sheet, error) = match sheet {
            Some(Ok(sheet)) => (Some(sheet), None),
            Some(Err(error)) => (None, Some(foreign_files::one_line(&error.to_string()))),
            None => (None, None),
        };
        let judgement = sheet.as_ref().map(|sheet| specification.judge(sheet));
        let verdict = judgement.as_ref().map(|judgement| judgement.verdict.word().to_owned());
        let reasons = judgement.map(|judgement| judgement.reasons.join("; "));
        self.cells.push(("verdict".to_owned(), Cell::Text(verdict)));
        self.cells.push(("verdict_reasons".to_owned(), Cell::Text(reasons)));
        self.cells.push(("sheet_error".to_owned(), Cell::Text(error)));
        for kind in kinds_of(specification.axis()) {
            let figure = sheet.as_ref().and_then(|sheet| sheet.figure(kind));
            self.value(kind.name, figure.and_then(|figure| figure.value), figure.and_then(|figure| figure.ci95));
        }
    }

    /// Adds a value with the ends of its interval.
    fn value(&mut self, name: &str, value: Option<f64>, ci95: Option<[f64; 2]>) {
        self.cells.push((name.to_owned(), Cell::Real(value)));
        for (index, end) in CI95_ENDS.into_iter().enumerate() {
            self.cells.push((format!("{name}{end}"), Cell::Real(ci95.map(|ci95| ci95[index]))));
        }
    }

    fn with(path: &Path, loaded: Option<&LoadedCapture>, fit: Option<&Fit>, error: Option<String>) -> Self {
        let facts = loaded.map(crate::facts);
        let run = loaded.and_then(|loaded| loaded.capture.description.as_ref());
        let text = |words: Option<String>| Cell::Text(words.map(|words| foreign_files::one_line(&words)));
        let cells = vec![
            ("file", Cell::Text(Some(path.display().to_string()))),
            ("error", text(error)),
            ("knob", text(run.map(|run| run.knob.clone()))),
            ("rig", text(run.map(|run| run.apparatus.clone()))),
            ("captured_at_ns", Cell::Count(run.map(|run| run.clock.wall_clock_time_ns))),
            ("rate_hz", Cell::Real(facts.as_ref().map(|facts| facts.rate_hz))),
            ("duration_s", Cell::Real(facts.as_ref().map(|facts| facts.duration_s))),
            ("samples", Cell::Count(facts.as_ref().map(|facts| facts.samples))),
            ("lost_samples", Cell::Count(facts.as_ref().and_then(|facts| facts.gaps))),
            ("missed_ticks", Cell::Count(facts.as_ref().and_then(|facts| facts.missed_ticks))),
            ("residual_rms_mnm", Cell::Real(fit.map(|fit| fit.residual_rms_mnm))),
            ("relative_error_percent", Cell::Real(fit.map(|fit| fit.relative_error_percent))),
            ("mean_ci95_mnm", Cell::Real(fit.map(|fit| fit.mean_ci95_mnm))),
        ]
        .into_iter()
        .map(|(name, cell)| (name.to_owned(), cell));
        let mut row = Self { cells: cells.collect(), axis: loaded.map(|loaded| loaded.capture.axis) };
        for kind in parameters() {
            let parameter = fit.and_then(|fit| fit.parameters.get(kind.name));
            row.value(kind.name, parameter.and_then(|found| found.value), parameter.and_then(|found| found.ci95));
        }
        row
    }

    /// The columns of every row under a specification, each with an empty cell of its kind.
    #[must_use]
    pub fn columns(specification: Option<&Specification>) -> Vec<(String, Cell)> {
        let mut row = Self::with(Path::new(""), None, None, None);
        row.cells[0].1 = Cell::Text(None);
        if let Some(specification) = specification {
            row.judge(specification, None);
        }
        row.cells
    }

    /// The unit of a column about captures of this axis; `None` for words, for counts and ratios.
    #[must_use]
    pub fn unit_of(column: &str, specification: Option<&Specification>, axis: Axis) -> Option<Cow<'static, str>> {
        let stem = CI95_ENDS.into_iter().find_map(|end| column.strip_suffix(end)).unwrap_or(column);
        let of_parameter = parameters().find(|kind| kind.name == stem).map(|kind| kind.unit);
        let figures = specification.map(|specification| kinds_of(specification.axis())).unwrap_or_default();
        let of_figure = figures.iter().find(|kind| kind.name == stem).map(|kind| kind.unit);
        let known = [("_percent", "%"), ("_hz", "Hz")].into_iter().find(|(ending, _)| column.ends_with(ending));
        let unit = of_parameter.or(of_figure).or(known.map(|(_, unit)| unit));
        let unit = unit.or_else(|| archive::unit_of(column)).filter(|unit| !unit.is_empty())?;
        // A figure is in the unit of its own axis already, and a phase is an angle on every axis.
        let is_final = of_figure.is_some() || stem.ends_with("_phase");
        Some(if is_final { Cow::Borrowed(unit) } else { axis.words(unit) })
    }

    /// The cells with their columns' names.
    #[must_use]
    pub fn cells(&self) -> &[(String, Cell)] {
        &self.cells
    }

    /// The axis of what was captured; `None` of a file that cannot be read.
    #[must_use]
    pub fn axis(&self) -> Option<Axis> {
        self.axis
    }
}

/// Parameters that a fit looks for in every capture.
fn parameters() -> impl Iterator<Item = &'static ParameterKind> {
    let kinds =
        [&effects::inertia::KIND, &effects::friction::KIND, &effects::karnopp_stick::KIND, &effects::detent::KIND];
    kinds.into_iter().flat_map(|kind| kind.parameters)
}
