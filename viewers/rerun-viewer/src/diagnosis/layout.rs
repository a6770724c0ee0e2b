//! How the views of a diagnosis lie.

use identification::diagnosis::Diagnosis;
use rerun::RecordingStream;
use rerun::blueprint::components::LinkAxis;
use rerun::blueprint::{
    BarChartView, ContainerLike, Grid, Horizontal, Tabs, TextDocumentView, TimePanel, TimeSeriesView, Vertical,
};
use rerun::external::re_sdk_types::blueprint::archetypes::TimeAxis;

use super::Input;
use super::charts::{Comparison, comparisons, map_entity};
use crate::entities::SUMMARY;
use crate::layout_properties::{self, Properties};

pub fn send(recording: &RecordingStream, input: &Input) -> anyhow::Result<()> {
    let mut properties = Properties::default();
    let chart = |Comparison { entity, title, .. }| BarChartView::new(title).with_origin(entity).into();
    let effects: Vec<ContainerLike> = comparisons(&input.diagnosis).into_iter().map(chart).collect();
    let effects = Grid::new(effects).with_grid_columns(2).with_name("Effects");
    let tabs = [overview(&mut properties, input), maps(&input.diagnosis), effects.into()];
    layout_properties::send(recording, Tabs::new(tabs), TimePanel::new(), &properties)
}

/// Torque and residual of both captures, and the words.
fn overview(properties: &mut Properties, input: &Input) -> ContainerLike {
    let quantities = [("torque", "torque: measured and predicted, mNm"), ("residual", "measured minus predicted, mNm")];
    let mut plots: Vec<ContainerLike> = Vec::new();
    for role in input.captures.iter().map(|capture| &capture.role) {
        for (quantity, what) in quantities {
            let view =
                TimeSeriesView::new(format!("{role} capture, {what}")).with_origin(format!("{role}/{quantity}")).into();
            // Each capture has its own clock.
            properties.of_view(&view, "TimeAxis", TimeAxis::new().with_link(LinkAxis::Independent));
            plots.push(view);
        }
    }
    let text = TextDocumentView::new("diagnosis").with_origin(SUMMARY);
    Horizontal::new([Vertical::new(plots).into(), text.into()])
        .with_column_shares([5.0, 3.0])
        .with_name("Diagnosis")
        .into()
}

/// The residual over each coordinate, before and after.
fn maps(found: &Diagnosis) -> ContainerLike {
    let views = found.locations.iter().map(|location| {
        let mark = if location.significant { "" } else { ", not significant" };
        let title = format!(
            "{}, {}: {:.0} %{mark}; mean residual before and after, mNm",
            location.coordinate, location.unit, location.explained_percent
        );
        BarChartView::new(title).with_origin(map_entity(location.coordinate)).into()
    });
    Grid::new(views.collect::<Vec<_>>()).with_grid_columns(3).with_name("Maps").into()
}
