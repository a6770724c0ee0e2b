//! How the views of a diagnosis lie.

use rerun::RecordingStream;
use rerun::blueprint::components::LinkAxis;
use rerun::blueprint::{
    BarChartView, ContainerLike, Grid, Horizontal, Tabs, TextDocumentView, TimePanel, TimeSeriesView, Vertical,
};
use rerun::external::re_sdk_types::blueprint::archetypes::TimeAxis;

use super::charts::{FORWARD, GAP, map_entity, step_entity};
use super::input::DiagnosisInput;
use crate::entities::SUMMARY;
use crate::layout_properties::{self, Properties};

/// Sends the layout and makes it the active one.
pub fn send(recording: &RecordingStream, input: &DiagnosisInput) -> anyhow::Result<()> {
    let mut properties = Properties::default();
    let tabs = [overview(&mut properties, input), maps(input), effects(input)];
    layout_properties::send(recording, Tabs::new(tabs), TimePanel::new(), &properties)
}

/// Torque and residual of both captures, and the words.
fn overview(properties: &mut Properties, input: &DiagnosisInput) -> ContainerLike {
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
fn maps(input: &DiagnosisInput) -> ContainerLike {
    let views = input.diagnosis.locations.iter().map(|location| {
        let mark = if location.significant { "" } else { ", not significant" };
        let title = format!(
            "{}, {}: {:.0} %{mark}; mean residual before and after, mNm",
            location.coordinate, location.unit, location.explained_percent
        );
        chart(title, &map_entity(&location.coordinate))
    });
    Grid::new(views.collect::<Vec<_>>()).with_grid_columns(3).with_name("Maps").into()
}

/// The gap step by step, and each effect beside its rivals.
fn effects(input: &DiagnosisInput) -> ContainerLike {
    let mut views = vec![chart("left of the held-out capture, mNm RMS".to_owned(), GAP)];
    if input.diagnosis.forward_from_command.is_some() {
        views.push(chart("error of the motion from the command, rad RMS".to_owned(), FORWARD));
    }
    for (index, step) in input.diagnosis.steps.iter().enumerate() {
        let entity = step_entity(index, step);
        let title = |what: &str| format!("{} and its rivals: {what}", step.effect);
        views.push(chart(title("left of the held-out capture, mNm RMS"), &format!("{entity}/heldout_rms_mnm")));
        views.push(chart(title("evidence, nats"), &format!("{entity}/evidence_nats")));
    }
    Grid::new(views).with_grid_columns(2).with_name("Effects").into()
}

fn chart(title: String, origin: &str) -> ContainerLike {
    BarChartView::new(title).with_origin(origin).into()
}
