//! What joins the two bodies of a knob with lost motion or a shaft that twists.

/// A contact with a dead zone, or a shaft, between a cap and an inner body.
///
/// Over a tick with mean and end velocities its torque is, the cap ahead by δ at the start,
///
/// ```text
/// τ = K·(δ − slack + m·T·mean(ωc − ωi)) + D·(ωc' − ωi')
/// ```
///
/// with m = ½, the middle of the tick, where the spring's energy is exact. Taken at the tick's end (m = 1), a spring takes in at
/// least the energy that it then holds. It is taken so in the tick in which the bodies meet, and always if it is too stiff for the
/// tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Joint {
    /// Inertia of the cap on the rig's side of the torque sensor, rotor included, mNm·s²/rad.
    pub(super) cap_inertia: f64,
    /// Inertia of the inner body, mNm·s²/rad.
    pub(super) inner_inertia: f64,
    /// Half of the angle in which the bodies do not touch, rad; zero for a shaft.
    pub(super) half_gap_rad: f64,
    /// Torque per angle of contact or shaft, mNm/rad.
    pub(super) stiffness_mnm_rad: f64,
    /// Torque per velocity, mNm·s/rad.
    pub(super) damping: f64,
}

/// How the two bodies act on each other over a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Touch {
    /// Nothing passes between them.
    Apart,
    /// A spring and a damper between them.
    Touching {
        /// Angle by which the cap is ahead where the spring is slack, rad.
        slack_rad: f64,
        /// Moment of the tick at which the spring is taken, as a share of it.
        moment: f64,
    },
}

/// Torque between the bodies over a tick: its value if neither moves at the end of the tick, mNm, and its increase for each rad/s
/// by which the cap is then faster, mNm·s/rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Passed {
    pub(super) torque_mnm: f64,
    pub(super) firmness: f64,
}

/// Compliance of what counts as rigid while one model gives way to another, rad/mNm.
const RIGID: f64 = 1e-7;

impl Joint {
    /// One body as two that are rigidly joined, with its inertia divided as in `other`.
    fn of_one_body(inertia: f64, other: &Self) -> Self {
        let inner_inertia = inertia * other.inner_inertia / (other.inner_inertia + other.cap_inertia);
        let stiffness_mnm_rad = RIGID.recip();
        Self {
            cap_inertia: inertia - inner_inertia,
            inner_inertia,
            half_gap_rad: 0.0,
            stiffness_mnm_rad,
            damping: other.damping * stiffness_mnm_rad / other.stiffness_mnm_rad,
        }
    }

    /// The joint between two models, each with its inertia where it is one body (`None`); `share` is the second's.
    pub(super) fn between(from: (Option<Self>, f64), to: (Option<Self>, f64), share: f64) -> Option<Self> {
        let (from, to) = match (from, to) {
            ((None, _), (None, _)) => return None,
            ((Some(from), _), (Some(to), _)) => (from, to),
            ((None, inertia), (Some(to), _)) => (Self::of_one_body(inertia, &to), to),
            ((Some(from), _), (None, inertia)) => (from, Self::of_one_body(inertia, &from)),
        };
        let mixed = |of: fn(&Self) -> f64| of(&from) + share * (of(&to) - of(&from));
        // The compliances are mixed, so that a joint becomes rigid gradually.
        let stiffness_mnm_rad = mixed(|joint| joint.stiffness_mnm_rad.recip()).recip();
        Some(Self {
            cap_inertia: mixed(|joint| joint.cap_inertia),
            inner_inertia: mixed(|joint| joint.inner_inertia),
            half_gap_rad: mixed(|joint| joint.half_gap_rad),
            stiffness_mnm_rad,
            damping: stiffness_mnm_rad * mixed(|joint| joint.damping / joint.stiffness_mnm_rad),
        })
    }

    /// How the bodies stand to each other, the cap ahead by `ahead_rad`.
    pub(super) fn touch(&self, ahead_rad: f64, step_s: f64) -> Touch {
        if self.half_gap_rad > 0.0 && ahead_rad.abs() <= self.half_gap_rad {
            return Touch::Apart;
        }
        let resonance = self.stiffness_mnm_rad * (self.cap_inertia.recip() + self.inner_inertia.recip());
        let moment = if resonance * step_s * step_s > RESOLVED { 1.0 } else { 0.5 };
        Touch::Touching { slack_rad: self.half_gap_rad.copysign(ahead_rad), moment }
    }

    /// The contact state with which to solve the tick again, where `touch` proved wrong. `torque_mnm` passed between the bodies;
    /// the cap was ahead by these angles at the start and the end of the tick.
    pub(super) fn otherwise(&self, touch: Touch, torque_mnm: f64, [start_rad, end_rad]: [f64; 2]) -> Option<Touch> {
        if self.half_gap_rad == 0.0 {
            return None;
        }
        match touch {
            // A contact pushes and does not pull.
            Touch::Touching { slack_rad, .. } => (torque_mnm * slack_rad < 0.0).then_some(Touch::Apart),
            Touch::Apart => {
                let slack_rad = self.half_gap_rad.copysign(end_rad);
                // Bodies that part within the tick were deeper in each other at its start.
                let meet = end_rad.abs() > self.half_gap_rad
                    && (start_rad.abs() <= self.half_gap_rad || slack_rad * start_rad < 0.0);
                meet.then_some(Touch::Touching { slack_rad, moment: 1.0 })
            }
        }
    }

    /// What passes to the inner body over a tick that the cap begins ahead by `ahead_rad` and faster by `faster_rad_s`.
    pub(super) fn passed(&self, touch: Touch, ahead_rad: f64, faster_rad_s: f64, step_s: f64) -> Passed {
        let Touch::Touching { slack_rad, moment } = touch else { return Passed::default() };
        let over_tick = 0.5 * moment * self.stiffness_mnm_rad * step_s;
        Passed {
            torque_mnm: self.stiffness_mnm_rad * (ahead_rad - slack_rad) + over_tick * faster_rad_s,
            firmness: over_tick + self.damping,
        }
    }

    /// Energy of the spring, mNm·rad.
    pub(super) fn held(&self, ahead_rad: f64) -> f64 {
        let beyond_rad = ahead_rad - ahead_rad.clamp(-self.half_gap_rad, self.half_gap_rad);
        0.5 * self.stiffness_mnm_rad * beyond_rad * beyond_rad
    }
}

/// Largest square of the phase, rad², that the joint's resonance may turn in a tick to be resolved: a quarter of a turn.
const RESOLVED: f64 = 2.5;
