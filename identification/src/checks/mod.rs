//! What a capture tells without a fit: detents counted, breakaways read off, lost motion seen.
//!
//! Nothing here shares a step with [`fit`](crate::fit()) but the samples themselves, so that agreement
//! means something. The paper does the same by hand: its periods agreed with detents counted over 360°
//! within 4.8, 1.6 and 9.9 % for knobs 3, 4 and 5 (section 4.3).

mod breakaway;
mod detents;
mod free_travel;

pub use breakaway::{Breakaway, breakaways};
pub use detents::{CountError, DetentCount, count_detents, rising_crossings};
pub use free_travel::{FreeTravel, free_travel};
