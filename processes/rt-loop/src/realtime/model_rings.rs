//! Models on their way into the loop, and what becomes of them: two rings, so that the loop neither allocates nor frees.

use rtrb::{Consumer, Producer, RingBuffer};

use crate::control::ControlState;
use crate::control::rendering::RenderedModel;

/// Models that may wait for the loop.
const MODELS: usize = 2;
/// What may wait for the publisher: far more than the few that [`MODELS`] can lead to.
const EVENTS: usize = 64;

/// What becomes of a model in the loop.
#[derive(Debug)]
pub enum ModelEvent {
    /// The oldest model not yet rendered begins to be rendered.
    Rendered {
        /// Scheduled tick of the run.
        tick: u64,
        /// CLOCK_MONOTONIC at which it was due, ns.
        monotonic_time_ns: u64,
    },
    /// A model is no longer rendered, and is to be freed.
    Retired(Box<RenderedModel>),
}

/// The publisher's ends.
#[derive(Debug)]
pub struct ModelPort {
    /// Models to the loop.
    pub models: Producer<Box<RenderedModel>>,
    /// What becomes of them.
    pub events: Consumer<ModelEvent>,
}

/// The loop's ends.
#[derive(Debug)]
pub(super) struct ModelEnds {
    models: Consumer<Box<RenderedModel>>,
    events: Producer<ModelEvent>,
    /// The renderer has not taken it so far.
    in_hand: Option<Box<RenderedModel>>,
}

impl ModelEnds {
    pub(super) fn new() -> (Self, ModelPort) {
        let (model_producer, model_consumer) = RingBuffer::new(MODELS);
        let (event_producer, event_consumer) = RingBuffer::new(EVENTS);
        let ends = Self { models: model_consumer, events: event_producer, in_hand: None };
        (ends, ModelPort { models: model_producer, events: event_consumer })
    }

    /// Hands the renderer a model that came; one that it cannot take yet is offered again at the next tick.
    pub(super) fn offer(&mut self, control: &mut ControlState) {
        if self.in_hand.is_none() {
            self.in_hand = self.models.pop().ok();
        }
        if let Some(model) = self.in_hand.take() {
            self.in_hand = control.take_model(model).err();
        }
    }

    /// Announces that a model begins to be rendered.
    pub(super) fn announce_rendered(&mut self, tick: u64, monotonic_time_ns: u64) {
        // The publisher sends no model while another is not felt: there is always room.
        let _ = self.events.push(ModelEvent::Rendered { tick, monotonic_time_ns });
    }

    /// Hands over a model that is no longer rendered, to be freed elsewhere; without room it stays with the renderer.
    pub(super) fn give_back(&mut self, control: &mut ControlState) {
        if self.events.slots() > 0
            && let Some(model) = control.retired_model()
        {
            // There is room: nothing comes back that this thread would have to free.
            let _ = self.events.push(ModelEvent::Retired(model));
        }
    }
}
