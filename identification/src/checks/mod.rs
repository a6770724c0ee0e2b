//! Checks of a capture without a fit: counting detents, reading off breakaways, finding lost motion.
//!
//! These checks share only the samples with [`fit`](crate::fit()), not its steps, so that agreement
//! means something. The paper does the same by hand: its periods agreed with detents counted over 360°
//! within 4.8, 1.6 and 9.9 % for knobs 3, 4 and 5 (section 4.3).

mod breakaway;
mod detents;
mod free_travel;

pub use breakaway::{Breakaway, breakaways};
pub use detents::{CountError, DetentCount, count_detents, rising_crossings};
pub use free_travel::{FreeTravel, free_travel};
