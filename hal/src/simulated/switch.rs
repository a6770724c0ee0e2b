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
const CHANGES: [f64; 6] = [0.10, 0.50, 0.58, 0.80, 0.85, 1.0];

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
        refused.map_or(Ok(()), |(parameter, value, _, requirement)| {
            Err(ParameterError { parameter, value, requirement })
        })
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
