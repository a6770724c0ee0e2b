//! A second body inside the knob, behind lost motion or a shaft that twists.

use dynamics::Coupling;

/// How cap and inner body act on each other over a substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Touch {
    /// Nothing passes between them.
    Apart,
    /// A spring and a damper between them.
    Touching {
        /// Angle by which the cap is ahead where the spring is slack, rad.
        slack_rad: f64,
        /// Moment of the substep at which the spring is taken, as a share of it.
        ///
        /// At the middle the spring's energy is exact. At the end, for the substep in which the bodies meet, the
        /// spring takes in at least the energy that it then holds: meeting cannot add any.
        moment: f64,
    },
}

/// What a body, with its own velocity eliminated, adds to the equation of the motor-side body or the cap for a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Reaction {
    /// Added to the diagonal, mNm·s²/rad.
    pub(super) diagonal: f64,
    /// Added to the momentum, mNm·s.
    pub(super) momentum: f64,
}

impl Reaction {
    /// A damper to the housing, mNm·s/rad, taken at the mean of the velocity over the substep.
    pub(super) fn of_drag(drag: f64, velocity_rad_s: f64, substep_s: f64) -> Self {
        let diagonal = 0.5 * substep_s * drag;
        Self { diagonal, momentum: -diagonal * velocity_rad_s }
    }
}

/// Angle and velocity of the cap at the start of a substep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cap {
    pub(super) angle_rad: f64,
    pub(super) velocity_rad_s: f64,
}

/// What the inner body's surroundings do to it over a substep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Load {
    /// Torque of detents and sliding friction, mNm.
    pub(super) applied_mnm: f64,
    /// Damper to the housing, mNm·s/rad.
    pub(super) drag: f64,
    /// Whether friction holds it.
    pub(super) at_rest: bool,
}

/// How a substep ends for the inner body.
#[derive(Clone, Copy, Debug)]
pub(super) struct InnerEnd {
    /// Velocity at the end, rad/s.
    pub(super) velocity_rad_s: f64,
    /// Torque on its friction if it is at rest at the end, mNm.
    pub(super) holding_mnm: f64,
    /// The contact state with which to solve the substep again, where the assumed one proved wrong.
    pub(super) otherwise: Option<Touch>,
}

/// The body that friction, stick and detents act on.
///
/// Its equation of a substep, with a bar for the mean over it and moment m of the spring,
///
/// ```text
/// Ji·(ωi' − ωi) = h·(Tc + Ti − drag·ω̄i),   Tc = K·(δ − slack) + (2·m·K·h/2 + D)·(ω̄c − ω̄i)
/// ```
///
/// is solved together with those of motor and cap: stiff contacts are stable at any substep.
#[derive(Clone, Copy, Debug)]
pub(super) struct InnerBody {
    substep_s: f64,
    inertia: f64,
    half_gap_rad: f64,
    stiffness_mnm_rad: f64,
    damping: f64,
    pub(super) angle_rad: f64,
    pub(super) velocity_rad_s: f64,
}

impl InnerBody {
    /// A body at rest in the middle of its gap at angle zero; `inertia` in mNm·s²/rad, above zero.
    pub(super) fn new(coupling: &Coupling, inertia: f64, substep_s: f64) -> Self {
        let Coupling { half_gap_rad, inner_share: _, stiffness_mnm_rad, damping } = *coupling;
        Self { substep_s, inertia, half_gap_rad, stiffness_mnm_rad, damping, angle_rad: 0.0, velocity_rad_s: 0.0 }
    }

    /// How the bodies stand to each other at the start of a substep.
    pub(super) fn touch(&self, cap_rad: f64) -> Touch {
        let ahead_rad = cap_rad - self.angle_rad;
        if self.half_gap_rad > 0.0 && ahead_rad.abs() <= self.half_gap_rad {
            Touch::Apart
        } else {
            Touch::Touching { slack_rad: self.half_gap_rad.copysign(ahead_rad), moment: 0.5 }
        }
    }

    /// Torque that passes to the inner body now, mNm.
    pub(super) fn passed_on_mnm(&self, cap: &Cap) -> f64 {
        let Touch::Touching { slack_rad, .. } = self.touch(cap.angle_rad) else { return 0.0 };
        let torque_mnm = self.stiffness_mnm_rad * (cap.angle_rad - self.angle_rad - slack_rad)
            + self.damping * (cap.velocity_rad_s - self.velocity_rad_s);
        if self.half_gap_rad > 0.0 && torque_mnm * slack_rad < 0.0 { 0.0 } else { torque_mnm }
    }

    /// Spring torque at the start, mNm, and the coefficient of the mean difference of speeds, mNm·s/rad.
    fn spring_and_damper(&self, touch: Touch, cap: &Cap) -> (f64, f64) {
        let Touch::Touching { slack_rad, moment } = touch else { return (0.0, 0.0) };
        let spring_mnm = self.stiffness_mnm_rad * (cap.angle_rad - self.angle_rad - slack_rad);
        (spring_mnm, moment * self.stiffness_mnm_rad * self.substep_s + self.damping)
    }

    /// Diagonal, off-diagonal with its sign turned, and momentum of the inner body's equation.
    fn equation(&self, touch: Touch, cap: &Cap, load: &Load) -> (f64, f64, f64) {
        let (spring_mnm, damper) = self.spring_and_damper(touch, cap);
        let coupling = 0.5 * self.substep_s * damper;
        let drag = Reaction::of_drag(load.drag, self.velocity_rad_s, self.substep_s);
        let momentum = self.inertia * self.velocity_rad_s
            + self.substep_s * (spring_mnm + load.applied_mnm)
            + coupling * (cap.velocity_rad_s - self.velocity_rad_s)
            + drag.momentum;
        (self.inertia + coupling + drag.diagonal, coupling, momentum)
    }

    /// What the inner body adds to the cap's equation.
    pub(super) fn onto_cap(&self, touch: Touch, cap: &Cap, load: &Load) -> Reaction {
        let (spring_mnm, _) = self.spring_and_damper(touch, cap);
        let (diagonal, coupling, momentum) = self.equation(touch, cap, load);
        let carried = self.substep_s * spring_mnm + coupling * (cap.velocity_rad_s - self.velocity_rad_s);
        if load.at_rest {
            return Reaction { diagonal: coupling, momentum: -carried };
        }
        let passed = coupling / diagonal;
        Reaction { diagonal: coupling - passed * coupling, momentum: passed * momentum - carried }
    }

    /// The end of a substep at which the cap has the velocity `cap_end_rad_s`.
    pub(super) fn end(&self, touch: Touch, cap: &Cap, load: &Load, cap_end_rad_s: f64) -> InnerEnd {
        let (diagonal, coupling, momentum) = self.equation(touch, cap, load);
        let driven = momentum + coupling * cap_end_rad_s;
        let velocity_rad_s = if load.at_rest { 0.0 } else { driven / diagonal };
        let faster_rad_s = 0.5 * (cap.velocity_rad_s + cap_end_rad_s - self.velocity_rad_s - velocity_rad_s);
        let otherwise = if self.half_gap_rad > 0.0 { self.otherwise(touch, cap, faster_rad_s) } else { None };
        InnerEnd { velocity_rad_s, holding_mnm: driven / self.substep_s, otherwise }
    }

    fn otherwise(&self, touch: Touch, cap: &Cap, faster_rad_s: f64) -> Option<Touch> {
        let ahead_rad = cap.angle_rad - self.angle_rad;
        let (spring_mnm, damper) = self.spring_and_damper(touch, cap);
        match touch {
            // A contact pushes and does not pull.
            Touch::Touching { slack_rad, .. } => {
                ((spring_mnm + damper * faster_rad_s) * slack_rad < 0.0).then_some(Touch::Apart)
            }
            Touch::Apart => {
                let end_rad = ahead_rad + self.substep_s * faster_rad_s;
                let slack_rad = self.half_gap_rad.copysign(end_rad);
                // Bodies that part within the substep were deeper in each other at its start.
                let meet = end_rad.abs() > self.half_gap_rad
                    && (ahead_rad.abs() <= self.half_gap_rad || slack_rad * ahead_rad < 0.0);
                meet.then_some(Touch::Touching { slack_rad, moment: 1.0 })
            }
        }
    }

    /// Goes to the end of the substep.
    pub(super) fn advance(&mut self, end_rad_s: f64) {
        self.angle_rad += 0.5 * self.substep_s * (self.velocity_rad_s + end_rad_s);
        self.velocity_rad_s = end_rad_s;
    }
}
