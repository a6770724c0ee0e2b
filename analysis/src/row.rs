//! A capture as one row of a table: what it is, what its fit tells, or what is wrong with it.

use std::path::Path;

use dynamics::{ParameterKind, effects};
use identification::{Fit, PreparationMethod};
use loaded_capture::LoadedCapture;

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

/// A capture as a row: a cell for each of [`Row::columns`].
#[derive(Clone, Debug, PartialEq)]
pub struct Row(Vec<(String, Cell)>);

impl Row {
    /// Reads and fits a capture; what is wrong with one that cannot be read or fitted is in its column `error`.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let loaded = LoadedCapture::load(path);
        let fitted = loaded.as_ref().ok().map(|loaded| crate::fit(loaded, PreparationMethod::default()));
        let error = match (&loaded, &fitted) {
            (Err(error), _) => Some(error.to_string()),
            (_, Some(Err(error))) => Some(error.to_string()),
            _ => None,
        };
        let fit = fitted.as_ref().and_then(|fitted| fitted.as_ref().ok());
        Self::with(path, loaded.as_ref().ok(), fit, error)
    }

    fn with(path: &Path, loaded: Option<&LoadedCapture>, fit: Option<&Fit>, error: Option<String>) -> Self {
        let facts = loaded.map(crate::facts);
        let run = loaded.and_then(|loaded| loaded.capture.description.as_ref());
        let text = |words: Option<String>| Cell::Text(words.map(|words| foreign_files::one_line(&words)));
        let mut cells = vec![
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
        .map(|(name, cell)| (name.to_owned(), cell))
        .collect::<Vec<_>>();
        for kind in parameters() {
            let told = fit.and_then(|fit| fit.parameters.get(kind.name));
            let end = |side: usize| told.and_then(|told| told.ci95).map(|ci95| ci95[side]);
            cells.push((kind.name.to_owned(), Cell::Real(told.and_then(|told| told.value))));
            cells.push((format!("{}_ci95_low", kind.name), Cell::Real(end(0))));
            cells.push((format!("{}_ci95_high", kind.name), Cell::Real(end(1))));
        }
        Self(cells)
    }

    /// The columns of every row, each with an empty cell of its kind.
    #[must_use]
    pub fn columns() -> Vec<(String, Cell)> {
        let mut columns = Self::with(Path::new(""), None, None, None).0;
        columns[0].1 = Cell::Text(None);
        columns
    }

    /// The unit of a column; `None` for words and for counts of things.
    #[must_use]
    pub fn unit_of(column: &str) -> Option<&'static str> {
        let stem = column.strip_suffix("_ci95_low").or_else(|| column.strip_suffix("_ci95_high")).unwrap_or(column);
        let of_parameter = parameters().find(|kind| kind.name == stem).map(|kind| kind.unit);
        let known = [("_percent", "%"), ("_hz", "Hz")].into_iter().find(|(ending, _)| column.ends_with(ending));
        of_parameter.or(known.map(|(_, unit)| unit)).or_else(|| archive::unit_of(column))
    }

    /// The cells with their columns' names.
    #[must_use]
    pub fn cells(&self) -> &[(String, Cell)] {
        &self.0
    }
}

/// Parameters that a fit looks for in every capture.
fn parameters() -> impl Iterator<Item = &'static ParameterKind> {
    let kinds =
        [&effects::inertia::KIND, &effects::friction::KIND, &effects::karnopp_stick::KIND, &effects::detent::KIND];
    kinds.into_iter().flat_map(|kind| kind.parameters)
}
