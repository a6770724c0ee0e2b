//! The switch in a control: a contact that bounces.

use serde::{Deserialize, Serialize};

use super::ParameterError;

/// A contact that closes on the way up and opens on the way down, each time with bounce.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Switch {
    /// Angle at which it closes, rad.
    pub closing_angle_rad: f64,
    /// Angle at which it opens again, rad; not above the other.
    pub opening_angle_rad: f64,
    /// Time from its first closing until it stays closed, s.
    #[serde(default)]
    pub closing_bounce_s: f64,
    /// Time from its first opening until it stays open, s.
    #[serde(default)]
    pub opening_bounce_s: f64,
}

/// When a bouncing contact changes after its first change, as shares of the bounce: each flight is shorter than the one before, as
/// a ball's are.
const CHANGES: [f64; 6] = [0.15, 0.45, 0.55, 0.75, 0.85, 1.0];

impl Switch {
    /// Checks that the numbers describe a switch.
    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let Self { closing_angle_rad, opening_angle_rad, closing_bounce_s, opening_bounce_s } = *self;
        let checks = [
            ("switch's closing_angle_rad", closing_angle_rad, closing_angle_rad.is_finite(), "finite"),
            (
                "switch's opening_angle_rad",
                opening_angle_rad,
                opening_angle_rad <= closing_angle_rad && opening_angle_rad.is_finite(),
                "finite, and not above the angle at which the switch closes",
            ),
            ("switch's closing_bounce_s", closing_bounce_s, (0.0..1.0).contains(&closing_bounce_s), "from 0 to 1 s"),
            ("switch's opening_bounce_s", opening_bounce_s, (0.0..1.0).contains(&opening_bounce_s), "from 0 to 1 s"),
        ];
        let refused = checks.into_iter().find(|(_, _, permitted, _)| !permitted);
        refused
            .map_or(Ok(()), |(parameter, value, _, requirement)| Err(ParameterError { parameter, value, requirement }))
    }
}

/// A switch in time.
#[derive(Debug)]
pub(super) struct Switching {
    switch: Switch,
    /// Whether it is closed once it has stopped bouncing.
    settles_closed: bool,
    /// When that changed last, s.
    changed_s: f64,
}

impl Switching {
    /// Open, and long at rest.
    pub(super) fn new(switch: Switch) -> Self {
        Self { switch, settles_closed: false, changed_s: f64::NEG_INFINITY }
    }

    /// Lets a substep pass at whose end the control is at `angle_rad`.
    pub(super) fn step(&mut self, time_s: f64, angle_rad: f64) {
        let Switch { closing_angle_rad, opening_angle_rad, .. } = self.switch;
        let closes = if self.settles_closed { angle_rad > opening_angle_rad } else { angle_rad >= closing_angle_rad };
        if closes != self.settles_closed {
            (self.settles_closed, self.changed_s) = (closes, time_s);
        }
    }

    /// Whether the contact is closed.
    pub(super) fn is_closed(&self, time_s: f64) -> bool {
        let Switch { closing_bounce_s, opening_bounce_s, .. } = self.switch;
        let bounce_s = if self.settles_closed { closing_bounce_s } else { opening_bounce_s };
        let since_s = time_s - self.changed_s;
        let changes = CHANGES.iter().filter(|share| since_s >= *share * bounce_s).count();
        self.settles_closed == changes.is_multiple_of(2)
    }
}

#[cfg(test)]
mod tests {
    use super::{Switch, Switching};

    #[test]
    fn it_closes_and_opens_where_it_is_told_and_bounces_as_long() {
        let switch = Switch {
            closing_angle_rad: 3.1,
            opening_angle_rad: 2.9,
            closing_bounce_s: 1.2e-3,
            opening_bounce_s: 0.6e-3,
        };
        let mut switching = Switching::new(switch);
        // There and back between 0 and 3.4 within 2 s.
        let (mut changes, mut before) = (Vec::new(), false);
        for step in 0..200_000 {
            let time_s = f64::from(step) * 1e-5;
            let angle_rad = 3.4 * (1.0 - (time_s - 1.0).abs());
            switching.step(time_s, angle_rad);
            if switching.is_closed(time_s) != before {
                before = !before;
                changes.push((time_s, angle_rad));
            }
        }
        // Three flights each time, so seven changes.
        assert_eq!((changes.len(), before), (14, false));
        for (first, last, angle_rad, bounce_s) in [(0, 6, 3.1, 1.2e-3), (7, 13, 2.9, 0.6e-3)] {
            assert!((changes[first].1 - angle_rad).abs() < 1e-4);
            assert!((changes[last].0 - changes[first].0 - bounce_s).abs() < 1.5e-5);
        }
    }
}
