//! What the live fitter publishes.

#[cfg(feature = "services")]
use iceoryx2::prelude::ZeroCopySend;

use crate::wire_code;

wire_message! {
    /// One parameter as fitted so far.
    pub struct Estimate as "haptic_camera/msg/Estimate" {
        /// Fitted value, in the parameter's own unit; NaN while it is not identifiable.
        pub value: f64,
        /// Lower end of the 95 % interval.
        pub ci95_low: f64,
        /// Upper end of the 95 % interval.
        pub ci95_high: f64,
        /// 1 excited enough to be estimated, 0 not yet, 2 not part of the model.
        pub verdict: u32,
        /// 1 known as well as was asked for, 2 too small for the torque sensor to show, 0 neither.
        pub convergence: u32,
    }
}

wire_message! {
    /// The model of Equation 1 fitted to the stream so far.
    pub struct FitUpdate as "haptic_camera/msg/FitUpdate" {
        /// Identity of the run.
        pub run_id: u64,
        /// CLOCK_MONOTONIC of the newest sample that went into the fit, ns.
        pub monotonic_time_ns: u64,
        /// Tick of the newest sample that went into the fit.
        pub latest_tick: u64,
        /// Samples that went into the fit.
        pub samples: u64,
        /// Samples that never reached the fitter.
        pub lost_samples: u64,
        /// CPU time that this update cost, ns.
        pub update_ns: u64,
        /// RMS of the torque that the model leaves unexplained, mNm.
        pub residual_rms_mnm: f64,
        /// RMS of the velocity while the knob slid, rad/s; NaN before the first estimate.
        pub speed_rms_rad_s: f64,
        /// RMS of the acceleration while the knob slid, rad/s^2; NaN before the first estimate.
        pub acceleration_rms_rad_s2: f64,
        /// Inertia of the knob, mNm s^2/rad.
        pub inertia: Estimate,
        /// Coulomb friction when turning in the negative direction, mNm.
        pub coulomb_negative: Estimate,
        /// Coulomb friction when turning in the positive direction, mNm.
        pub coulomb_positive: Estimate,
        /// Viscous friction when turning in the negative direction, mNm s/rad.
        pub viscous_negative: Estimate,
        /// Viscous friction when turning in the positive direction, mNm s/rad.
        pub viscous_positive: Estimate,
        /// Amplitude of the detent torque, mNm.
        pub detent_amplitude: Estimate,
        /// Detent period P in sin(angle/P + S), rad.
        pub detent_period: Estimate,
        /// Detent phase S in sin(angle/P + S), rad.
        pub detent_phase: Estimate,
    }
}

wire_code! {
    /// Whether a parameter can be estimated from the data so far.
    pub enum Verdict {
        /// The sweep has not yet excited the parameter enough.
        NotYet = 0,
        /// Excited enough: value and interval mean what they say.
        Estimated = 1,
        /// The model that was fitted does not have this parameter.
        Absent = 2,
    }
}

wire_code! {
    /// Whether a parameter is known as well as was asked for.
    pub enum Convergence {
        /// The interval is still wider than was asked for, or there is none.
        Open = 0,
        /// The interval is as narrow as was asked for.
        Converged = 1,
        /// The parameter is too small for the torque sensor to show.
        Negligible = 2,
    }
}

impl Estimate {
    /// Half the width of the 95 % interval; NaN while there is none.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        0.5 * (self.ci95_high - self.ci95_low)
    }

    /// Whether the model that was fitted has this parameter.
    #[must_use]
    pub fn is_in_model(&self) -> bool {
        self.verdict != Verdict::Absent.code()
    }

    /// Whether a longer capture is not needed for this parameter: it has converged or is negligible.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.convergence != Convergence::Open.code()
    }
}

impl FitUpdate {
    /// The parameters with their standard names, in the order of Equation 1.
    #[must_use]
    pub fn estimates(&self) -> [(&'static str, Estimate); 8] {
        [
            ("inertia", self.inertia),
            ("coulomb_negative", self.coulomb_negative),
            ("coulomb_positive", self.coulomb_positive),
            ("viscous_negative", self.viscous_negative),
            ("viscous_positive", self.viscous_positive),
            ("detent_amplitude", self.detent_amplitude),
            ("detent_period", self.detent_period),
            ("detent_phase", self.detent_phase),
        ]
    }
}
