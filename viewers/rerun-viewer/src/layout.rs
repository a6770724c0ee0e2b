//! Which views there are and how they lie: the first tab is readable at a glance.

use dynamics::Axis;
use rerun::RecordingStream;
use rerun::blueprint::components::{BackgroundKind, LinkAxis, LockRangeDuringZoom, PlayState};
use rerun::blueprint::{
    BarChartView, ContainerLike, Grid, Horizontal, Spatial2DView, Spatial3DView, Tabs, TextDocumentView, TimePanel,
    TimeSeriesView, Vertical,
};
use rerun::components::Visible;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, TimeAxis, VisibleTimeRanges, VisualBounds2D,
};
use rerun::external::re_sdk_types::blueprint::components as blueprint_components;
use rerun::external::re_types_core::datatypes::{TimeRange, TimeRangeBoundary, VisibleTimeRange};

use crate::drawing::TIMELINE;
use crate::entities::{self, PARAMETERS};
use crate::layout_properties::{self, Properties};
use crate::palette::GROUND;
use crate::plot_axes::{BOX_HEIGHT, BOX_WIDTH};
use crate::scatter::Abscissa;

/// What the live plots reach back, s.
const LIVE_WINDOW_S: i64 = 10;
/// From where the knob is looked at: from above and from the front.
const EYE: [f32; 3] = [0.0, -1.9, 2.7];
/// What of the knob is in the middle of the view.
const LOOK_TARGET: [f32; 3] = [0.0, -0.12, 0.0];

/// What is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Whether it is the running capture, of which the last seconds are shown; of a finished one, all is.
    pub is_live: bool,
    /// Whether the rig turns.
    pub axis: Axis,
    /// Whether there is a velocity.
    pub velocity: bool,
    /// Whether there is an acceleration.
    pub acceleration: bool,
    /// Whether a contact is watched.
    pub contact: bool,
}

impl Subject {
    /// The running capture, which has a velocity and an acceleration.
    pub const fn live(axis: Axis, contact: bool) -> Self {
        Self { is_live: true, axis, velocity: true, acceleration: true, contact }
    }

    /// What the signals' plots reach back, s; `None` for everything.
    const fn window_s(self) -> Option<i64> {
        if self.is_live { Some(LIVE_WINDOW_S) } else { None }
    }
}

/// Sends the layout and makes it the active one.
///
/// # Errors
/// When rerun refuses a part of the layout.
pub fn send(recording: &RecordingStream, subject: Subject) -> anyhow::Result<()> {
    let mut properties = Properties::default();
    let knob = knob(&mut properties, subject);
    let signals = signals(&mut properties, subject);
    let tabs = if subject.is_live {
        let parameters = parameters(&mut properties, subject.axis);
        Tabs::new([knob, signals, parameters, timing_and_processes(&mut properties)])
    } else {
        // The text tells the parameters; how the processes fared is not in the archive's columns.
        Tabs::new([signals, knob])
    };
    let following = TimePanel::new().with_play_state(PlayState::Following);
    layout_properties::send(recording, tabs, following, &properties)
}

/// The knob itself, large, with its torque and its angle.
fn knob(properties: &mut Properties, subject: Subject) -> ContainerLike {
    let title = "knob: green slips positive, rose slips negative, violet sticks; orange: detents of the model";
    let space: ContainerLike = Spatial3DView::new(subject.axis.words(title)).with_origin(entities::KNOB).into();
    let from_above = EyeControls3D::new().with_position(EYE).with_look_target(LOOK_TARGET).with_eye_up([0.0, 0.0, 1.0]);
    properties.of_view(&space, "EyeControls3D", from_above);
    let ground = Background::new(BackgroundKind::SolidColor).with_color(GROUND.opaque());
    properties.of_view(&space, "Background", ground);
    properties.of_view(&space, "LineGrid3D", LineGrid3D::new().with_visible(Visible(false.into())));
    let torque = torque_plot(properties, subject);
    let angle = signal_plot(properties, subject, "angle_rad", &["angle_rad"]);
    let mut columns = vec![space, Vertical::new([torque, angle]).into()];
    let mut shares = vec![4.5, 3.3];
    if subject.is_live {
        columns.push(TextDocumentView::new("parameters").with_origin(entities::PARAMETERS_TEXT).into());
        shares.push(4.7);
    }
    Horizontal::new(columns).with_column_shares(shares).with_name(subject.axis.words("Knob")).into()
}

fn torque_plot(properties: &mut Properties, subject: Subject) -> ContainerLike {
    let title = "torque_mnm (blue line), model_torque_mnm (orange dots)";
    signal_plot(properties, subject, title, &["torque_mnm", "model_torque_mnm"])
}

fn signals(properties: &mut Properties, subject: Subject) -> ContainerLike {
    let mut signals = Vec::new();
    let single =
        [("angle_rad", true), ("velocity_rad_s", subject.velocity), ("acceleration_rad_s2", subject.acceleration)];
    for (field, _) in single.into_iter().filter(|(_, is_there)| *is_there) {
        signals.push((3.0, signal_plot(properties, subject, field, &[field])));
    }
    signals.push((4.0, torque_plot(properties, subject)));
    if subject.contact {
        signals.push((2.5, signal_plot(properties, subject, "contact (1: closed)", &["contact"])));
    }
    let (shares, signals): (Vec<f32>, Vec<ContainerLike>) = signals.into_iter().unzip();

    let mut plots = vec![plot(properties, Abscissa::Angle, subject)];
    if subject.velocity {
        plots.push(plot(properties, Abscissa::Velocity, subject));
    }
    let (tab, text) = if subject.is_live { ("Signals and model", "run") } else { ("Capture", "capture") };
    let summary = TextDocumentView::new(text).with_origin(entities::SUMMARY);
    Horizontal::new([
        Vertical::new(signals).with_row_shares(shares).into(),
        Vertical::new(plots).into(),
        summary.into(),
    ])
    .with_column_shares([3.7, 3.3, 3.2])
    .with_name(tab)
    .into()
}

fn signal_plot(properties: &mut Properties, subject: Subject, title: &str, fields: &[&str]) -> ContainerLike {
    let axis = subject.axis;
    let fields = fields.iter().map(|field| axis.words(&entities::signal(field)).into_owned());
    let view = series(properties, &axis.words(title), fields, subject.window_s());
    if subject.window_s().is_none() {
        // Whoever looks into one signal sees the others at the same time.
        properties.of_view(&view, "TimeAxis", TimeAxis::new().with_link(LinkAxis::LinkToGlobal));
    }
    view
}

fn parameters(properties: &mut Properties, axis: Axis) -> ContainerLike {
    let groups: [(&str, &[&str]); 6] = [
        ("inertia", &["inertia"]),
        ("Coulomb friction, negative (rose) and positive (green)", &["coulomb_negative", "coulomb_positive"]),
        ("viscous friction, negative (rose) and positive (green)", &["viscous_negative", "viscous_positive"]),
        ("detent amplitude", &["detent_amplitude"]),
        ("detent period", &["detent_period"]),
        ("detent phase", &["detent_phase"]),
    ];
    let views = groups.map(|(title, names)| {
        let unit = PARAMETERS.iter().find(|(name, _)| *name == names[0]).map_or("", |(_, unit)| unit);
        series(
            properties,
            &axis.words(&format!("{title}, {unit}")),
            names.iter().map(|name| entities::parameter(name)),
            None,
        )
    });
    let text = TextDocumentView::new("parameters").with_origin(entities::PARAMETERS_TEXT);
    Horizontal::new([Grid::new(views).with_grid_columns(3).into(), text.into()])
        .with_column_shares([6.6, 3.9])
        .with_name("Parameters")
        .into()
}

fn timing_and_processes(properties: &mut Properties) -> ContainerLike {
    let lateness = series(
        properties,
        "largest lateness (blue), tick period (orange): log10 of ns",
        [entities::LATENESS, entities::TICK_PERIOD].map(str::to_owned),
        None,
    );
    let histogram: ContainerLike = BarChartView::new("ticks by lateness: log10 of (1 + ticks) over log10 of ns")
        .with_origin(entities::LATENESS_HISTOGRAM)
        .into();
    let histogram = without_legend(properties, histogram);
    let health = entities::HEALTH.map(|quantity| {
        let title = format!("{quantity}: recorder (green), live-fitter (orange), rerun-viewer (blue)");
        let view = TimeSeriesView::new(title).with_origin(format!("health/{quantity}"));
        without_legend(properties, view.into())
    });
    let processes = TextDocumentView::new("processes").with_origin(entities::PROCESSES_TEXT);
    Vertical::new([
        Horizontal::new([lateness, histogram]).with_column_shares([3.0, 2.0]).into(),
        Horizontal::new([Grid::new(health).with_grid_columns(2).into(), processes.into()])
            .with_column_shares([3.0, 2.0])
            .into(),
    ])
    .with_row_shares([2.0, 3.0])
    .with_name("Timing and processes")
    .into()
}

/// A view of a few series, named in its title: a legend would lie over them.
fn series(
    properties: &mut Properties,
    title: &str,
    entities: impl IntoIterator<Item = String>,
    window_s: Option<i64>,
) -> ContainerLike {
    let contents = entities.into_iter().map(|entity| format!("+ /{entity}"));
    let view = windowed(properties, TimeSeriesView::new(title).with_contents(contents).into(), window_s);
    without_legend(properties, view)
}

/// Lets a view follow the newest `window_s` seconds, or show the whole run.
fn windowed(properties: &mut Properties, view: ContainerLike, window_s: Option<i64>) -> ContainerLike {
    if let Some(window_s) = window_s {
        let range = reaching_back(window_s);
        properties.of_view(&view, "VisibleTimeRanges", VisibleTimeRanges::new([visible(range)]));
        let axis = TimeAxis::new()
            .with_link(LinkAxis::Independent)
            .with_view_range(blueprint_components::TimeRange(range))
            .with_zoom_lock(LockRangeDuringZoom(false.into()));
        properties.of_view(&view, "TimeAxis", axis);
    }
    view
}

fn without_legend(properties: &mut Properties, view: ContainerLike) -> ContainerLike {
    properties.of_view(&view, "PlotLegend", PlotLegend::new().with_visible(Visible(false.into())));
    view
}

fn plot(properties: &mut Properties, abscissa: Abscissa, subject: Subject) -> ContainerLike {
    let axis = subject.axis;
    let origin = axis.words(&entities::plot(abscissa)).into_owned();
    let title = format!("torque_mnm over {} (green turning positive, rose negative)", abscissa.name());
    let view: ContainerLike = Spatial2DView::new(axis.words(&title)).with_origin(origin.as_str()).into();
    let bounds = rerun::datatypes::Range2D {
        x_range: [-0.14 * BOX_WIDTH, 1.05 * BOX_WIDTH].into(),
        y_range: [-0.10 * BOX_HEIGHT, 1.17 * BOX_HEIGHT].into(),
    };
    properties.of_view(&view, "VisualBounds2D", VisualBounds2D::new(bounds));
    // Only the points pile up over time; axes and curves are the newest ones.
    let points = format!("{origin}/quantities/measured");
    let range = subject.window_s().map_or(TimeRange::EVERYTHING, reaching_back);
    properties.of_entity(&view, &points, VisibleTimeRanges::new([visible(range)]));
    view
}

fn reaching_back(seconds: i64) -> TimeRange {
    let start = TimeRangeBoundary::CursorRelative((-seconds * 1_000_000_000).into());
    TimeRange { start, end: TimeRangeBoundary::AT_CURSOR }
}

fn visible(range: TimeRange) -> VisibleTimeRange {
    VisibleTimeRange { timeline: TIMELINE.into(), range }
}
