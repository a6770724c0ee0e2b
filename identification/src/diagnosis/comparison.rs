//! The part of a held-out capture that can be compared with a model of the training capture.

use dynamics::effects;

use super::capture::Capture;
use super::capture::encoder_zero::EncoderZero;
use super::search::found::Found;

/// What is said where the held-out capture shows detents that the training capture does not.
pub(crate) const BEYOND: &str = "the detents may be unequal: where the held-out capture goes beyond the angles of the training capture it is \
                      left out; capture a whole turn to have every detent";

/// How the held-out capture is compared with the model.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    /// Its encoder's zero, where that is not the training capture's.
    pub(crate) zero: Option<EncoderZero>,
    /// Whether the detents are unequal: then those that the training capture did not pass are unknown.
    pub(crate) are_unequal: bool,
}

impl Comparison {
    /// The held-out capture as it is compared.
    pub(crate) fn of(self, train: &Capture, given: &Capture) -> Capture {
        self.within(train, given).unwrap_or_else(|| self.moved(given))
    }

    fn moved(self, given: &Capture) -> Capture {
        self.zero.map_or_else(|| given.clone(), |zero| zero.taken_out_of(given))
    }

    /// The held-out capture without the angles beyond the training capture's; `None` where they need not be left out.
    pub(crate) fn within(self, train: &Capture, given: &Capture) -> Option<Capture> {
        if self.are_unequal { self.moved(given).within(train) } else { None }
    }

    /// The comparison that the effects found so far ask for: another zero, or unequal detents.
    pub(crate) fn after(self, found: &Found, train: &Capture, given: &Capture, zero_may_move: bool) -> Self {
        let mut after = self;
        if zero_may_move {
            let again = EncoderZero::again(self.zero, &found.named().structure, given);
            if EncoderZero::differ(self.zero, again) {
                after.zero = again;
            }
        }
        let unequal = Self { are_unequal: true, ..after };
        let are_unequal = found.step_of(effects::unequal_detents::KIND.name).is_some();
        if are_unequal && unequal.within(train, given).is_some() { unequal } else { after }
    }
}
