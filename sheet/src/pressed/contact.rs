//! Where a contact closes and opens, and how long it bounces.

use std::ops::Range;

use archive::testers::Curve;

use crate::figure::Estimate;

/// Longest time between two rows that shows bounce, which lasts some milliseconds at most, s.
const FINE_S: f64 = 1e-3;

const NO_CONTACT: &str = "the file has no contact that closes";
const NOT_CLOSED: &str = "the contact does not close on the press, or is open at its end";
const NOT_OPENED: &str = "the contact does not open on the way back, or is closed at its end";
const NO_TIME: &str = "bounce shows over time only, and the file has none";
const COARSE: &str = "between the rows lies more than 1 ms, in which a bounce passes";

/// A contact that closes, or opens, and settles.
#[derive(Clone, Debug)]
pub(crate) struct Change {
    /// Travel at its first change, mm.
    pub(crate) travel_mm: f64,
    /// Time from its first change to its last, ms.
    pub(crate) bounce_ms: Result<Estimate, &'static str>,
}

impl Change {
    /// The change to closed, or to open, within these rows.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn to(closed: bool, curve: &Curve, rows: Range<usize>) -> Result<Self, &'static str> {
        let contact = curve.closed.as_ref().filter(|contact| contact.contains(&true)).ok_or(NO_CONTACT)?;
        let none = if closed { NOT_CLOSED } else { NOT_OPENED };
        let changes = |row: &usize| contact[*row] == closed && contact[*row - 1] != closed;
        let first = (rows.start + 1..rows.end).find(changes).ok_or(none)?;
        let last = (first..rows.end).rev().find(changes).unwrap_or(first);
        if contact[rows.end - 1] != closed || contact[rows.start] == closed {
            return Err(none);
        }
        let travel_mm = f64::midpoint(curve.position[first - 1], curve.position[first]);
        Ok(Self { travel_mm, bounce_ms: bounce_ms(curve.t_s.as_deref(), first, last) })
    }
}

/// Time between two changes; the time of each is uniformly distributed between its row and the row before.
fn bounce_ms(t_s: Option<&[f64]>, first: usize, last: usize) -> Result<Estimate, &'static str> {
    let t_s = t_s.ok_or(NO_TIME)?;
    let steps_s = [first, last].map(|row| t_s[row] - t_s[row - 1]);
    if steps_s.iter().any(|step_s| *step_s > FINE_S) {
        return Err(COARSE);
    }
    let middle_s = [first, last].map(|row| f64::midpoint(t_s[row - 1], t_s[row]));
    let error_s = steps_s[0].hypot(steps_s[1]) / 12_f64.sqrt();
    Ok(Estimate { value: 1e3 * (middle_s[1] - middle_s[0]), standard_error: 1e3 * error_s })
}
