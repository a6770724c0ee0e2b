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
use crate::entities;
use crate::layout_properties::{self, Properties};
use crate::palette::GROUND;
use crate::plot_axes::{BOX_HEIGHT, BOX_WIDTH};
use crate::run::Run;
use crate::scatter::Abscissa;

/// What the live plots reach back, s.
const LIVE_WINDOW_S: i64 = 10;
/// From where the knob is looked at: from above and from the front.
const EYE: [f32; 3] = [0.0, -1.9, 2.7];
const LOOK_TARGET: [f32; 3] = [0.0, -0.12, 0.0];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Whether it is the running capture, of which the last seconds are shown; of a finished one, all is.
    pub is_live: bool,
    pub axis: Axis,
    /// Whether there is a velocity, and so on.
    pub velocity: bool,
    pub acceleration: bool,
    pub contact: bool,
}

impl Subject {
    /// The running capture, which has a velocity and an acceleration.
    pub fn live(run: &Run) -> Self {
        let contact = run.description.as_ref().is_some_and(|run| run.contact);
        Self { is_live: true, axis: run.axis.unwrap_or_default(), velocity: true, acceleration: true, contact }
    }
}

pub fn send(recording: &RecordingStream, subject: Subject) -> anyhow::Result<()> {
    let window = subject.is_live.then(|| TimeRange {
        start: TimeRangeBoundary::CursorRelative((-LIVE_WINDOW_S * 1_000_000_000).into()),
        end: TimeRangeBoundary::AT_CURSOR,
    });
    let mut layout = Layout { properties: Properties::default(), subject, window };
    let (knob, signals) = (layout.knob(), layout.signals());
    let tabs = if subject.is_live {
        Tabs::new([knob, signals, layout.parameters(), layout.timing_and_processes()])
    } else {
        // The text tells the parameters; how the processes fared is not in the archive's columns.
        Tabs::new([signals, knob])
    };
    let following = TimePanel::new().with_play_state(PlayState::Following);
    layout_properties::send(recording, tabs, following, &layout.properties)
}

/// Lays out views and notes their properties.
struct Layout {
    properties: Properties,
    subject: Subject,
    /// What the signals' plots reach back; `None` for everything.
    window: Option<TimeRange>,
}

impl Layout {
    /// The knob itself, large, with its torque and its angle.
    fn knob(&mut self) -> ContainerLike {
        let Subject { axis, is_live, .. } = self.subject;
        let title = "knob: green slips positive, rose slips negative, violet sticks; orange: detents of the model";
        let space: ContainerLike = Spatial3DView::new(axis.words(title)).with_origin(entities::KNOB).into();
        let from_above =
            EyeControls3D::new().with_position(EYE).with_look_target(LOOK_TARGET).with_eye_up([0.0, 0.0, 1.0]);
        self.properties.of_view(&space, "EyeControls3D", from_above);
        let ground = Background::new(BackgroundKind::SolidColor).with_color(GROUND);
        self.properties.of_view(&space, "Background", ground);
        self.properties.of_view(&space, "LineGrid3D", LineGrid3D::new().with_visible(Visible(false.into())));
        let plots = Vertical::new([self.torque(), self.signal("angle_rad", &["angle_rad"])]);
        let mut columns = vec![(4.5, space), (3.3, plots.into())];
        columns.extend(is_live.then(|| (4.7, text("parameters", entities::PARAMETERS_TEXT))));
        let (shares, columns): (Vec<f32>, Vec<ContainerLike>) = columns.into_iter().unzip();
        Horizontal::new(columns).with_column_shares(shares).with_name(axis.words("Knob")).into()
    }

    fn torque(&mut self) -> ContainerLike {
        let title = "torque_mnm (blue line), model_torque_mnm (orange dots)";
        self.signal(title, &["torque_mnm", "model_torque_mnm"])
    }

    fn signals(&mut self) -> ContainerLike {
        let Subject { is_live, velocity, acceleration, contact, .. } = self.subject;
        let single = [("angle_rad", true), ("velocity_rad_s", velocity), ("acceleration_rad_s2", acceleration)];
        let single = single.into_iter().filter(|(_, is_there)| *is_there);
        let mut signals: Vec<_> = single.map(|(field, _)| (3.0, self.signal(field, &[field]))).collect();
        signals.push((4.0, self.torque()));
        signals.extend(contact.then(|| (2.5, self.signal("contact (1: closed)", &["contact"]))));
        let (shares, signals): (Vec<f32>, Vec<ContainerLike>) = signals.into_iter().unzip();

        let mut plots = vec![self.plot(Abscissa::Angle)];
        plots.extend(velocity.then(|| self.plot(Abscissa::Velocity)));
        let (tab, name) = if is_live { ("Signals and model", "run") } else { ("Capture", "capture") };
        Horizontal::new([
            Vertical::new(signals).with_row_shares(shares).into(),
            Vertical::new(plots).into(),
            text(name, entities::SUMMARY),
        ])
        .with_column_shares([3.7, 3.3, 3.2])
        .with_name(tab)
        .into()
    }

    /// A view of signals that follows the newest seconds, or shows all of a finished capture.
    fn signal(&mut self, title: &str, fields: &[&str]) -> ContainerLike {
        let axis = self.subject.axis;
        let fields = fields.iter().map(|field| axis.words(&entities::signal(field)).into_owned());
        let view = self.series(&axis.words(title), fields);
        let time_axis = match self.window {
            Some(range) => {
                self.properties.of_view(&view, "VisibleTimeRanges", VisibleTimeRanges::new([visible(range)]));
                TimeAxis::new()
                    .with_link(LinkAxis::Independent)
                    .with_view_range(blueprint_components::TimeRange(range))
                    .with_zoom_lock(LockRangeDuringZoom(false.into()))
            }
            // Whoever looks into one signal sees the others at the same time.
            None => TimeAxis::new().with_link(LinkAxis::LinkToGlobal),
        };
        self.properties.of_view(&view, "TimeAxis", time_axis);
        view
    }

    fn parameters(&mut self) -> ContainerLike {
        let groups: [(&str, &[&str]); 6] = [
            ("inertia", &["inertia"]),
            ("Coulomb friction, negative (rose) and positive (green)", &["coulomb_negative", "coulomb_positive"]),
            ("viscous friction, negative (rose) and positive (green)", &["viscous_negative", "viscous_positive"]),
            ("detent amplitude", &["detent_amplitude"]),
            ("detent period", &["detent_period"]),
            ("detent phase", &["detent_phase"]),
        ];
        let views = groups.map(|(title, names)| {
            let unit = entities::parameters().find(|one| one.name == names[0]).map_or("", |one| one.unit);
            let title = format!("{title}, {unit}");
            self.series(&self.subject.axis.words(&title), names.iter().map(|name| entities::parameter(name)))
        });
        Horizontal::new([Grid::new(views).with_grid_columns(3).into(), text("parameters", entities::PARAMETERS_TEXT)])
            .with_column_shares([6.6, 3.9])
            .with_name("Parameters")
            .into()
    }

    fn timing_and_processes(&mut self) -> ContainerLike {
        let lateness = self.series(
            "largest lateness (blue), tick period (orange): log10 of ns",
            [entities::LATENESS, entities::TICK_PERIOD].map(str::to_owned),
        );
        let histogram = BarChartView::new("ticks by lateness: log10 of (1 + ticks) over log10 of ns")
            .with_origin(entities::LATENESS_HISTOGRAM);
        let histogram = self.without_legend(histogram);
        let health = entities::HEALTH.map(|quantity| {
            let title = format!("{quantity}: recorder (green), live-fitter (orange), rerun-viewer (blue)");
            self.without_legend(TimeSeriesView::new(title).with_origin(format!("health/{quantity}")))
        });
        let health = Grid::new(health).with_grid_columns(2).into();
        let rows = [[lateness, histogram], [health, text("processes", entities::PROCESSES_TEXT)]];
        Vertical::new(rows.map(|row| Horizontal::new(row).with_column_shares([3.0, 2.0]).into()))
            .with_row_shares([2.0, 3.0])
            .with_name("Timing and processes")
            .into()
    }

    /// A view of a few series, named in its title: a legend would lie over them.
    fn series(&mut self, title: &str, entities: impl IntoIterator<Item = String>) -> ContainerLike {
        let contents = entities.into_iter().map(|entity| format!("+ /{entity}"));
        self.without_legend(TimeSeriesView::new(title).with_contents(contents))
    }

    fn without_legend(&mut self, view: impl Into<ContainerLike>) -> ContainerLike {
        let view = view.into();
        self.properties.of_view(&view, "PlotLegend", PlotLegend::new().with_visible(Visible(false.into())));
        view
    }

    fn plot(&mut self, abscissa: Abscissa) -> ContainerLike {
        let axis = self.subject.axis;
        let origin = axis.words(&entities::plot(abscissa)).into_owned();
        let title = format!("torque_mnm over {} (green turning positive, rose negative)", abscissa.name());
        let view: ContainerLike = Spatial2DView::new(axis.words(&title)).with_origin(origin.as_str()).into();
        let x_range = [-0.14 * BOX_WIDTH, 1.05 * BOX_WIDTH].into();
        let y_range = [-0.10 * BOX_HEIGHT, 1.17 * BOX_HEIGHT].into();
        let bounds = VisualBounds2D::new(rerun::datatypes::Range2D { x_range, y_range });
        self.properties.of_view(&view, "VisualBounds2D", bounds);
        // Only the points pile up over time, in whatever way they are drawn; axes and curves are the newest ones.
        let points = format!("ViewContents/overrides/{origin}/quantities/measured/visualizers");
        let range = self.window.unwrap_or(TimeRange::EVERYTHING);
        self.properties.of_view(&view, &points, VisibleTimeRanges::new([visible(range)]));
        view
    }
}

fn text(name: &str, entity: &str) -> ContainerLike {
    TextDocumentView::new(name).with_origin(entity).into()
}

fn visible(range: TimeRange) -> VisibleTimeRange {
    VisibleTimeRange { timeline: TIMELINE.into(), range }
}
