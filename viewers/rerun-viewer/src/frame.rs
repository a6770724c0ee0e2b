//! What goes to the screen at once.

use std::collections::BTreeMap;

use crate::knob_track::KnobUpdate;
use crate::scatter::PlotUpdate;

/// Everything that is new since the frame before; a frame that is dropped is only missed.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    pub run_id: u64,
    /// Time since the start of the run that the frame belongs to, ns.
    pub time_ns: i64,
    pub series: Series,
    /// The x-y plots, when it is their turn.
    pub plots: Vec<PlotUpdate>,
    /// Ticks by lateness so far, when it is their turn; see [`shared_types::LATENESS_BIN_EDGES_NS`].
    pub lateness: Option<[u64; 12]>,
    /// The knob itself, when it has moved or changed.
    pub knob: Option<KnobUpdate>,
    /// Texts as Markdown by the entities that show them, when they have changed.
    pub texts: Vec<(&'static str, String)>,
}

/// Time series by the paths of the entities that show them.
pub type Series = BTreeMap<String, Points>;

/// Points of a time series, never without one in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// Times since the start of the run, ns.
    pub times_ns: Vec<i64>,
    /// One value for each time, or equally many, such as an interval's ends.
    pub values: Vec<f64>,
}

impl Points {
    pub fn push(&mut self, time_ns: i64, values: &[f64]) {
        self.times_ns.push(time_ns);
        self.values.extend_from_slice(values);
    }
}
