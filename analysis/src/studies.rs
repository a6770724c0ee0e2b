//! Figures of many units, and what they tell of a process and of a tester.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use archive::testers::ColumnChoice;
use archive::{Capture, Overview};
use dynamics::Axis;
use foreign_files::{Column, OtherColumns, TableError, read_labelled};
use sheet::{
    Capability, CapabilityError, Design, FigureKind, Gauge, GaugeError, Limits, QdasRow, Sheet, Specification, kinds,
    kinds_of,
};

use crate::{AnalysisError, common_axis, curve_files, curves};

/// Figures with their limits, and the units that they were measured on.
pub struct Study {
    figures: Vec<(&'static FigureKind, Limits)>,
    units: Vec<Unit>,
}

/// One unit as one operator measured it once.
struct Unit {
    /// The part's folder, or its label.
    part: String,
    /// The operator's folder, or the operator's label.
    operator: String,
    /// The file; `None` for a row of a table.
    file: Option<PathBuf>,
    values: Vec<Option<f64>>,
}

/// Why figures of many units tell nothing.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Neither a figure nor limits.
    #[error("there is no figure to study; name one, such as collapse_force, or give a specification that limits some")]
    NoFigure,
    /// A name that is none of a figure.
    #[error("`{}` is not a figure; known are {}", .0, kinds().map(|kind| kind.name).collect::<Vec<_>>().join(", "))]
    UnknownFigure(String),
    /// A table that has no columns of values.
    #[error("{}: {error}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// What is wrong with it.
        error: TableError,
    },
    /// A unit whose curve does not tell a figure.
    #[error("{file} has no {figure}; `haptic-camera sheet` gives the reason")]
    NoValue {
        /// The unit's file.
        file: String,
        /// The figure.
        figure: &'static str,
    },
    /// Values that do not say whose they are.
    #[error(
        "a gauge study needs the part and operator of each value: captures in folders PART/OPERATOR/, or a table with \
         both columns"
    )]
    Unlabelled,
    /// Other parts for each operator in a crossed study.
    #[error(
        "the operators did not measure the same parts, as a crossed study needs; if each measured parts of their own, make it a nested one"
    )]
    OtherParts,
    /// Too few values of a figure for its capability.
    #[error("{0}: {1}")]
    Capability(&'static str, CapabilityError),
    /// Too few values of a figure for a gauge study, or uneven ones.
    #[error("{0}: {1}")]
    Gauge(&'static str, GaugeError),
    /// A unit's curve that cannot be read.
    #[error(transparent)]
    Unit(#[from] AnalysisError),
}

/// The figure that is named, or those that the specification limits. Figures of one name have equal units, and are told
/// apart by the axis of the captures.
fn studied(
    figure: Option<&str>,
    specification: Option<&Specification>,
    axis: Option<Axis>,
) -> Result<Vec<(&'static FigureKind, Limits)>, StudyError> {
    let of_axis = axis.map(kinds_of).unwrap_or_default();
    let own = |kind: &'static FigureKind| of_axis.iter().copied().find(|one| one.name == kind.name).unwrap_or(kind);
    let limited = specification.map(Specification::limits).unwrap_or_default();
    let mut limited = limited.iter().map(|&(kind, limits)| (own(kind), limits));
    let Some(name) = figure else {
        let limited: Vec<_> = limited.collect();
        return if limited.is_empty() { Err(StudyError::NoFigure) } else { Ok(limited) };
    };
    let without_limits = || kinds().find(|kind| kind.name == name).map(|kind| (own(kind), Limits::default()));
    let known = limited.find(|(kind, _)| kind.name == name).or_else(without_limits);
    known.map(|known| vec![known]).ok_or_else(|| StudyError::UnknownFigure(name.to_owned()))
}

impl Study {
    /// A study of captures and testers' files: the figure that is named, or those that the specification limits.
    ///
    /// # Errors
    /// [`StudyError`], also for a file that has no sheet.
    pub fn of_captures(
        captures: &[PathBuf],
        choice: Option<&ColumnChoice>,
        figure: Option<&str>,
        specification: Option<&Specification>,
    ) -> Result<Self, StudyError> {
        // A wrong name is refused before anything is read.
        studied(figure, specification, None)?;
        let files = curve_files(captures)?;
        let sheet = |file: &PathBuf| Ok(Sheet::of(&curves(std::slice::from_ref(file), choice)?)?);
        let sheets = files.iter().map(sheet).collect::<Result<Vec<Sheet>, AnalysisError>>()?;
        let axis = common_axis(sheets.iter().map(|sheet| sheet.axis))?;
        let figures = studied(figure, specification, Some(axis))?;
        let unit = |(file, sheet): (PathBuf, Sheet)| {
            let values = figures.iter().map(|(kind, _)| sheet.figure(kind).and_then(|figure| figure.value)).collect();
            // A capture lies in its operator's folder, and that in its part's.
            let [operator, part] = [1, 2].map(|above| {
                let name = file.ancestors().nth(above).and_then(Path::file_name);
                name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
            });
            Unit { part, operator, file: Some(file), values }
        };
        let units = files.into_iter().zip(sheets).map(unit).collect();
        Ok(Self { figures, units })
    }

    /// A study of the values of one figure in a table, with columns of labels for part and operator.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn of_table(
        table: &Path,
        figure: Option<&str>,
        specification: Option<&Specification>,
    ) -> Result<Self, StudyError> {
        let figures = studied(figure, specification, None)?;
        let file =
            foreign_files::open(table).map_err(|error| AnalysisError::Unreadable { path: table.to_owned(), error })?;
        let wanted = [Column::required("value")];
        let ([values], [parts, operators]) = read_labelled(file, wanted, ["part", "operator"], OtherColumns::Ignored)
            .map_err(|error| StudyError::Table { path: table.to_owned(), error })?;
        let label = |column: &[String], row: usize| column.get(row).cloned().unwrap_or_default();
        let unit = |(row, value): (usize, f64)| Unit {
            part: label(&parts, row),
            operator: label(&operators, row),
            file: None,
            values: vec![Some(value)],
        };
        Ok(Self { figures, units: values.unwrap_or_default().into_iter().enumerate().map(unit).collect() })
    }

    /// Whether the process keeps its units within their limits, with so many consecutive ones in a subgroup.
    ///
    /// # Errors
    /// [`StudyError::NoValue`] and [`StudyError::Capability`].
    pub fn capability(&self, subgroup: usize) -> Result<BTreeMap<&'static str, Capability>, StudyError> {
        self.each(|kind, limits, values| {
            Capability::of(values, subgroup, limits).map_err(|error| StudyError::Capability(kind.name, error))
        })
    }

    /// Whether the tester is good enough to tell the units apart.
    ///
    /// # Errors
    /// [`StudyError`] for values that are missing, or do not make up such a study.
    pub fn gauge(&self, design: Design) -> Result<BTreeMap<&'static str, Gauge>, StudyError> {
        self.each(|kind, limits, values| {
            let tolerance = limits.min.zip(limits.max).map(|(min, max)| max - min);
            Gauge::of(&self.by_operator(values, design)?, design, tolerance)
                .map_err(|error| StudyError::Gauge(kind.name, error))
        })
    }

    /// The figures as a Q-DAS file.
    #[must_use]
    pub fn qdas(&self, name: &str) -> String {
        let row = |unit: &Unit| QdasRow { measured_at: measured_at(unit.file.as_deref()), values: unit.values.clone() };
        sheet::qdas(name, &self.figures, &self.units.iter().map(row).collect::<Vec<_>>())
    }

    /// What the values of each figure tell; an error names a unit whose curve does not tell one.
    fn each<T>(
        &self,
        of: impl Fn(&FigureKind, Limits, &[f64]) -> Result<T, StudyError>,
    ) -> Result<BTreeMap<&'static str, T>, StudyError> {
        let value = |unit: &Unit, index: usize| {
            unit.values[index].ok_or_else(|| StudyError::NoValue {
                file: unit.file.as_ref().map(|file| file.display().to_string()).unwrap_or_default(),
                figure: self.figures[index].0.name,
            })
        };
        let column = |index| self.units.iter().map(|unit| value(unit, index)).collect::<Result<Vec<f64>, _>>();
        let columns = (0..self.figures.len()).map(column).collect::<Result<Vec<_>, _>>()?;
        let figures = self.figures.iter().zip(&columns);
        figures.map(|((kind, limits), values)| Ok((kind.name, of(kind, *limits, values)?))).collect()
    }

    fn by_operator(&self, values: &[f64], design: Design) -> Result<Vec<Vec<Vec<f64>>>, StudyError> {
        if self.units.iter().any(|unit| unit.part.is_empty() || unit.operator.is_empty()) {
            return Err(StudyError::Unlabelled);
        }
        let mut sorted: BTreeMap<&str, BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
        for (unit, value) in self.units.iter().zip(values) {
            sorted.entry(&unit.operator).or_default().entry(&unit.part).or_default().push(*value);
        }
        let mut parts = sorted.values().map(|parts| parts.keys().collect::<Vec<_>>());
        let first = parts.next();
        if design == Design::Crossed && parts.any(|parts| Some(parts) != first) {
            return Err(StudyError::OtherParts);
        }
        Ok(sorted.into_values().map(|parts| parts.into_values().collect()).collect())
    }
}

/// When an archive was recorded, or another file was written, else now.
fn measured_at(file: Option<&Path>) -> String {
    let recorded = |file| {
        let run = Capture::is_archive(file).ok()?.then(|| Overview::read(file).ok())??.description?;
        let second = i64::try_from(run.clock.wall_clock_time_ns / 1_000_000_000).ok().filter(|second| *second > 0)?;
        jiff::Timestamp::from_second(second).ok()
    };
    let written = |file: &Path| jiff::Timestamp::try_from(file.metadata().ok()?.modified().ok()?).ok();
    let at = file.and_then(|file| recorded(file).or_else(|| written(file))).unwrap_or_else(jiff::Timestamp::now);
    at.to_zoned(jiff::tz::TimeZone::system()).strftime("%d.%m.%Y/%H:%M:%S").to_string()
}
