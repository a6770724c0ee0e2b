//! Which contacts between the bodies of a knob can be rendered.

use dynamics::Coupling;

use super::port::{Hands, InnerPart, LinearModel, Port};
use crate::control::rendering::cap_inertia;

/// A contact or shaft as the loop sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Inertia of the cap with rotor and gripper, mNm·s²/rad.
    pub(super) cap_inertia: f64,
    /// Half of the gap, rad; zero for a shaft.
    pub(super) half_gap_rad: f64,
    /// Torque per angle, mNm/rad.
    pub(super) stiffness_mnm_rad: f64,
    /// Torque per velocity, mNm·s/rad.
    pub(super) damping: f64,
    /// The inner body while it slides, without its detents.
    pub(super) sliding: InnerPart,
    /// The same in the steepest of its detents.
    pub(super) in_detent: InnerPart,
}

/// Step of the ladder of stiffnesses.
const STEP: f64 = 1.08;
/// Softest share of a contact that is looked at: below it a swing is 200 times the compression, and hardly touches.
const SOFTEST: f64 = 0.005;
/// Dampings that are tried, from the contact's own on: each so many times the one before.
const DAMPING_STEP: f64 = 1.25;

impl Contact {
    /// The contact between the bodies of a knob; `least_inertia` is that of rotor and gripper.
    pub(super) fn new(
        coupling: &Coupling,
        inertia: f64,
        least_inertia: f64,
        [sliding_damping, detent_damping]: [f64; 2],
        detent_stiffness_mnm_rad: f64,
    ) -> Self {
        let cap_inertia = cap_inertia(coupling, inertia, least_inertia);
        let inner_inertia = inertia - cap_inertia;
        let sliding = InnerPart { inertia: inner_inertia, damping: sliding_damping, stiffness_mnm_rad: 0.0 };
        let in_detent = InnerPart { damping: detent_damping, stiffness_mnm_rad: detent_stiffness_mnm_rad, ..sliding };
        let Coupling { half_gap_rad, stiffness_mnm_rad, damping, .. } = *coupling;
        Self { cap_inertia, half_gap_rad, stiffness_mnm_rad, damping, sliding, in_detent }
    }

    /// Whether no hand of the class can make it swing at `share` of its stiffness and damping, whatever the inner body does.
    fn is_safe(&self, port: &Port, hands: &Hands, share: f64) -> bool {
        let inner = [None, Some(self.sliding), Some(self.in_detent)];
        inner.into_iter().all(|inner| {
            port.is_safe(
                &LinearModel::TwoBodies {
                    cap_inertia: self.cap_inertia,
                    stiffness_mnm_rad: share * self.stiffness_mnm_rad,
                    damping: share * self.damping,
                    inner,
                },
                hands,
            )
        })
    }

    /// Stiffest that is safe with this damping, mNm/rad, up to `most_mnm_rad`; zero if none is.
    ///
    /// By its describing function, a contact with a gap acts over a swing as a share of its spring and the same share of its damper:
    /// from zero, where the swing hardly touches, to one, where the gap does not matter (A. Gelb and W. E. Vander Velde,
    /// *Multiple-input describing functions and nonlinear system design*, 1968). So every share must be safe; for a shaft, the
    /// whole alone.
    pub(super) fn stiffest_mnm_rad(&self, port: &Port, hands: &Hands, safety: f64, most_mnm_rad: f64) -> f64 {
        let mut stiffest = most_mnm_rad;
        let mut tried = Self { stiffness_mnm_rad: stiffest / safety, ..*self };
        while stiffest > SOFTEST * most_mnm_rad {
            if tried.every_share_is_safe(port, hands) {
                return stiffest;
            }
            stiffest /= STEP;
            tried.stiffness_mnm_rad = stiffest / safety;
        }
        0.0
    }

    fn every_share_is_safe(&self, port: &Port, hands: &Hands) -> bool {
        // The whole share usually fails first.
        let mut share = 1.0;
        let least = if self.half_gap_rad == 0.0 { 0.9 } else { SOFTEST };
        while share > least {
            if !self.is_safe(port, hands, share) {
                return false;
            }
            share /= STEP;
        }
        true
    }

    /// Stiffness, mNm/rad, and damping, mNm·s/rad, nearest to the contact's own that are safe: as stiff as can be, and no more
    /// damped than that takes.
    pub(super) fn nearest(&self, port: &Port, hands: &Hands, safety: f64, most_damping: f64) -> [f64; 2] {
        let mut best = [0.0, self.damping];
        let mut damping = self.damping.max(1e-6 * self.stiffness_mnm_rad);
        while damping <= most_damping {
            let tried = Self { damping, ..*self };
            let stiffest = tried.stiffest_mnm_rad(port, hands, safety, self.stiffness_mnm_rad);
            if stiffest > best[0] {
                best = [stiffest, damping];
            }
            if stiffest == self.stiffness_mnm_rad {
                break;
            }
            damping *= DAMPING_STEP;
        }
        best
    }
}
