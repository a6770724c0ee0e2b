//! Properties of views that rerun's layout interface for Rust does not offer.
//!
//! A layout is itself a recording of kind "blueprint", in which a view's properties lie at `view/<id>/<archetype>`. The typed
//! interface makes the views; this adds the properties to the same recording before both are sent.

use anyhow::{Context as _, bail};
use rerun::blueprint::components::PanelState;
use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, SelectionPanel, Tabs, TimePanel,
};
use rerun::external::re_log_types::StoreKind;
use rerun::log::LogMsg;
use rerun::{AsComponents, RecordingStream, RecordingStreamBuilder};

use crate::drawing::TIMELINE;

/// Properties by the path at which they belong.
#[derive(Default)]
pub struct Properties(Vec<(String, Box<dyn AsComponents>)>);

impl Properties {
    /// Gives `view` a property; `name` is the archetype's short name.
    pub fn of_view(&mut self, view: &ContainerLike, name: &str, property: impl AsComponents + 'static) {
        if let ContainerLike::View(view) = view {
            self.0.push((format!("{}/{name}", view.blueprint_path()), Box::new(property)));
        }
    }
}

/// Sends views and properties as one layout, with rerun's own panels out of the way, and makes it the active one.
pub fn send(recording: &RecordingStream, tabs: Tabs, time: TimePanel, properties: &Properties) -> anyhow::Result<()> {
    let blueprint = Blueprint::new(tabs)
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
        .with_time_panel(time.with_state(PanelState::Collapsed).with_timeline(TIMELINE));
    let application = recording.store_info().context("the recording has no identity")?.application_id().clone();
    let (stage, staged) = RecordingStreamBuilder::new(application).send_properties(false).memory()?;
    blueprint.send(&stage, BlueprintActivation::default())?;

    let mut messages = staged.take();
    messages.retain(|message| message.store_id().kind() == StoreKind::Blueprint);
    // rerun activates a layout once it has sent all of it.
    let Some(LogMsg::BlueprintActivationCommand(activation)) = messages.pop() else {
        bail!("rerun gave no layout to activate");
    };

    let (additions, added) =
        RecordingStreamBuilder::from_store_id(&activation.blueprint_id).send_properties(false).memory()?;
    additions.set_time_sequence("blueprint", 0);
    for (path, property) in &properties.0 {
        additions.log(path.as_str(), property.as_ref())?;
    }
    messages.extend(added.take().into_iter().filter(|message| !matches!(message, LogMsg::SetStoreInfo(_))));
    recording.send_blueprint(messages, activation);
    Ok(())
}
