//! From one model to the next without a step in torque.

use super::rendered_model::{Forces, RenderedModel};

/// Time that one model takes to give way to the next, s.
const FADE_S: f64 = 0.25;

/// The model that is rendered, the one that it gives way to, and the one after that.
///
/// Whatever is no longer needed waits to be taken away: it is freed by another thread.
#[derive(Clone, Debug)]
pub(super) struct CrossFade {
    current: Box<RenderedModel>,
    next: Option<Box<RenderedModel>>,
    waiting: Option<Box<RenderedModel>>,
    passed_s: f64,
    retired: [Option<Box<RenderedModel>>; 2],
}

impl CrossFade {
    pub(super) fn new(model: Box<RenderedModel>) -> Self {
        Self { current: model, next: None, waiting: None, passed_s: 0.0, retired: [None, None] }
    }

    /// Takes a model that is to be rendered from now on; `Err` gives it back while the one before still waits.
    pub(super) fn take(&mut self, model: Box<RenderedModel>) -> Result<(), Box<RenderedModel>> {
        if self.waiting.is_some() {
            return Err(model);
        }
        self.waiting = Some(model);
        Ok(())
    }

    /// Lets a tick pass; `true` when a new model begins to be felt.
    pub(super) fn advance(&mut self, step_s: f64) -> bool {
        if self.next.is_some() {
            self.passed_s += step_s;
            if self.passed_s >= FADE_S
                && let Some(free) = self.retired.iter_mut().find(|slot| slot.is_none())
                && let Some(next) = self.next.take()
            {
                *free = Some(std::mem::replace(&mut self.current, next));
            }
        }
        if self.next.is_none() && self.waiting.is_some() {
            self.next = self.waiting.take();
            self.passed_s = 0.0;
            return true;
        }
        false
    }

    /// A model that is no longer rendered.
    pub(super) fn retired(&mut self) -> Option<Box<RenderedModel>> {
        self.retired.iter_mut().find_map(Option::take)
    }

    /// What a body feels now.
    pub(super) fn forces(&self) -> Forces<'_> {
        match &self.next {
            None => self.current.forces(),
            Some(next) => {
                let passed = (self.passed_s / FADE_S).min(1.0);
                Forces { from: &self.current, to: next, share: passed * passed * (3.0 - 2.0 * passed) }
            }
        }
    }
}
