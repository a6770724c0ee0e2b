//! What is done again and again, each time after a period.

use std::time::{Duration, Instant};

/// When it is time again; at once at first.
#[derive(Debug, Default)]
pub struct Timer(Option<Instant>);

impl Timer {
    /// Whether it is time; if so, the next time is this period from now.
    pub fn is_due(&mut self, period: Duration) -> bool {
        let now = Instant::now();
        let due = self.0.is_none_or(|next| now >= next);
        if due {
            self.0 = Some(now + period);
        }
        due
    }
}
