//! The knob that the effect hides in: the base model's numbers, within the ranges of the paper's Table 5.

use serde::{Deserialize, Serialize};

use crate::draw::Draw;

/// The base model of one knob. Units: mNm, rad, s.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Knob {
    /// Inertia beyond the torque sensor, mNm s²/rad.
    #[serde(rename = "M")]
    pub inertia: f64,
    /// Amplitude of the detents, mNm; 0 for a knob without.
    #[serde(rename = "A")]
    pub detent_amplitude: f64,
    /// Coulomb friction while the angle falls, mNm.
    #[serde(rename = "C_neg")]
    pub coulomb_negative: f64,
    /// Coulomb friction while the angle rises, mNm.
    #[serde(rename = "C_pos")]
    pub coulomb_positive: f64,
    /// Viscous friction while the angle falls, mNm s/rad.
    #[serde(rename = "B_neg")]
    pub viscous_negative: f64,
    /// Viscous friction while the angle rises, mNm s/rad.
    #[serde(rename = "B_pos")]
    pub viscous_positive: f64,
    /// The detents' spatial period over 2π, rad.
    #[serde(rename = "P", skip_serializing_if = "Option::is_none")]
    pub detent_period: Option<f64>,
    /// The detents' phase, rad.
    #[serde(rename = "S", skip_serializing_if = "Option::is_none")]
    pub detent_phase: Option<f64>,
}

/// What an effect asks of the knob that shall show it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wish {
    /// `Some(true)` for a knob with detents, `Some(false)` for one without.
    pub detents: Option<bool>,
    /// Detents of at least this amplitude, mNm.
    pub least_detent_mnm: f64,
    /// Coulomb friction of at least this, mNm.
    pub least_coulomb_mnm: f64,
    /// Coulomb friction of at most this, mNm, where it is not zero.
    pub most_coulomb_mnm: f64,
}

impl Knob {
    /// A knob somewhere within Table 5; half of them have no detents unless the wish says otherwise.
    pub fn draw(draw: &mut Draw, wish: Wish) -> Self {
        let half = draw.chance(0.5);
        let detents = wish.detents.unwrap_or(half);
        let most = if wish.most_coulomb_mnm > 0.0 { wish.most_coulomb_mnm } else { 46.0 };
        let least = wish.least_coulomb_mnm.clamp(0.61, most);
        let coulomb = draw.log_uniform(least, most);
        let viscous = draw.log_uniform(0.1, 4.7);
        // Two in five knobs rub alike both ways.
        let skew = if draw.chance(0.4) { 1.0 } else { draw.log_uniform(0.75, 1.33) };
        let least_detent = wish.least_detent_mnm.clamp(1.1, 60.0);
        Self {
            inertia: draw.log_uniform(0.02, 0.28),
            detent_amplitude: if detents {
                draw.log_uniform(least_detent, (3.0 * least_detent).max(45.0))
            } else {
                0.0
            },
            coulomb_negative: (coulomb * skew).min(46.0),
            coulomb_positive: coulomb,
            viscous_negative: viscous * draw.log_uniform(0.7, 1.4),
            viscous_positive: viscous,
            detent_period: detents.then(|| draw.log_uniform(0.034, 0.1)),
            detent_phase: detents.then(|| draw.phase()),
        }
    }

    /// A knob at a corner of Table 5: one or two of its numbers at their extremes.
    pub fn draw_extreme(draw: &mut Draw, wish: Wish) -> Self {
        let mut knob = Self::draw(draw, wish);
        match draw.below(5) {
            0 => knob.inertia = 0.0019,
            1 => knob.inertia = 0.28,
            2 if wish.most_coulomb_mnm == 0.0 => (knob.coulomb_negative, knob.coulomb_positive) = (46.0, 46.0),
            3 if wish.least_coulomb_mnm == 0.0 => (knob.coulomb_negative, knob.coulomb_positive) = (0.61, 0.61),
            // Friction that falls with speed, as the table has it; less of it, so that it stays friction up to 25 rad/s.
            _ => {
                let least = knob.coulomb_negative.min(knob.coulomb_positive);
                knob.viscous_negative = -(0.5 * least / 25.0).min(0.24);
                knob.viscous_positive = -(0.5 * least / 25.0).min(0.24);
            }
        }
        if knob.detent_period.is_some() {
            match draw.below(4) {
                0 => knob.detent_amplitude = 130.0,
                1 => knob.detent_period = Some(0.034),
                2 => knob.detent_period = Some(0.1),
                _ => knob.detent_amplitude = wish.least_detent_mnm.max(1.1),
            }
        }
        knob
    }
}
