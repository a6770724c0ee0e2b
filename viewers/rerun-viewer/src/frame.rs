//! What goes to the screen at once.

use crate::decimation::Points;
use crate::knob_track::KnobUpdate;
use crate::scatter::PlotUpdate;

/// Everything that is new since the frame before; a frame that is dropped is only missed.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Identity of the run that is shown.
    pub run_id: u64,
    /// Time since the start of the run that the frame belongs to, ns.
    pub time_ns: i64,
    /// New rows of time series.
    pub series: Vec<SeriesRows>,
    /// The x-y plots, when it is their turn.
    pub plots: Vec<PlotUpdate>,
    /// Ticks by lateness so far, when it is their turn; see [`shared_types::LATENESS_BIN_EDGES_NS`].
    pub lateness: Option<[u64; 12]>,
    /// The knob itself, when it has moved or changed.
    pub knob: Option<KnobUpdate>,
    /// Texts as Markdown by the entities that show them, when they have changed.
    pub texts: Vec<(&'static str, String)>,
}

/// Rows of one time series; a row may hold several values, such as an interval's ends.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesRows {
    /// Path of the entity that shows the series.
    pub entity: String,
    /// Times since the start of the run, ns.
    pub times_ns: Vec<i64>,
    /// `values_per_row` values for each time.
    pub values: Vec<f64>,
    /// Values in a row, at least one.
    pub values_per_row: usize,
}

impl SeriesRows {
    /// One value a row; `None` when there are no points.
    pub fn of_points(entity: String, points: Points) -> Option<Self> {
        let Points { times_ns, values } = points;
        (!times_ns.is_empty()).then_some(Self { entity, times_ns, values, values_per_row: 1 })
    }
}
