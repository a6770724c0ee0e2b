//! A model made ready to be rendered on a rig.

use dynamics::Model;
use hal::{RigDescription, TorqueSource};

use super::{PlanError, mounted_knob};
use crate::admission::{Admission, Admitted};
use crate::control::rendering::{RenderGains, Renderer};
use crate::nearest::Nearest;
use crate::request::RenderingRequest;
use crate::stability::{Firmness, gains_for};

/// Rates that are tried where one is too slow to render at, Hz.
const RENDERING_RATES_HZ: [f64; 12] =
    [500.0, 750.0, 1_000.0, 1_500.0, 2_000.0, 2_500.0, 3_000.0, 4_000.0, 5_000.0, 7_500.0, 10_000.0, 20_000.0];

/// A model ready to be rendered.
pub struct Rendering {
    /// The model as it is rendered: the one asked for, or the nearest to it that the rig renders.
    pub model: Model,
    /// The renderer with it.
    pub renderer: Renderer,
    /// The gains with which it is rendered.
    pub gains: RenderGains,
    /// What was changed or left out so that it can be rendered, in sentences.
    pub remarks: Vec<String>,
    /// What further models must pass.
    pub admission: Admission,
    /// Whether to suppress the remarks.
    without_remarks: bool,
}

impl Rendering {
    /// The model asked for, made ready to be rendered on the rig.
    pub(super) fn new(asked: &RenderingRequest, rig: &RigDescription, rate_hz: f64) -> Result<Self, PlanError> {
        let axis = rig.calibration.axis;
        let model = mounted_knob(&asked.model, axis, &rig.name)?;
        if rig.torque == TorqueSource::Motor {
            return Err(PlanError::NoTorqueSensor(rig.name.clone()));
        }
        if rig.calibration.motor_coulomb_mnm.is_none() {
            return Err(PlanError::Uncalibrated);
        }
        let firmness = |rate_hz| gains_for(&rig.calibration, &rig.limits, rate_hz, rig.late_ticks(rate_hz) / rate_hz);
        let rates = RENDERING_RATES_HZ.into_iter().filter(|other| *other <= rig.limits.rate_hz);
        let too_slow = || PlanError::TooSlow {
            asked: rate_hz,
            rig: rig.name.clone(),
            remedy: {
                let mut rates = rates.clone().filter(|other| firmness(*other).is_some());
                match (rates.clone().find(|other| *other > rate_hz), rates.next_back()) {
                    (Some(other), _) | (None, Some(other)) => format!("give --rate-hz {other}"),
                    (None, None) => "it cannot render at any rate that it holds; calibrate it again".to_owned(),
                }
            },
        };
        let Firmness { gains, bounds, share } = firmness(rate_hz).ok_or_else(too_slow)?;
        let softer = (share < 1.0).then(|| {
            let damping = |rate_hz| firmness(rate_hz).map_or(0.0, |other| other.gains.damping);
            let firmest = rates.clone().rev().max_by(|one, other| damping(*one).total_cmp(&damping(*other)));
            let remedy = firmest.filter(|other| damping(*other) > gains.damping);
            format!(
                "at {rate_hz} Hz rotor and gripper would oscillate on the torque sensor at the usual coupling stiffness: \
                 the model is coupled by {:.2} of it{}",
                share * share,
                remedy.map_or_else(String::new, |other| format!("; --rate-hz {other} couples it more firmly"))
            )
        });
        let admission = Admission::new(bounds, &rig.calibration);
        let (model, Admitted { rendered, remarks }) = if asked.nearest {
            let Nearest { model, admitted, clipped } = admission.nearest(&model)?;
            let clipped = clipped.into_iter().map(|change| format!("clipped to the rig's limits: {change}"));
            (model, Admitted { remarks: clipped.chain(admitted.remarks).collect(), ..admitted })
        } else {
            let admitted = admission.admit(&model)?;
            (model, admitted)
        };
        let (motor_mnm, late_ticks) = (rig.limits.motor_torque_mnm, rig.late_ticks(rate_hz));
        let renderer =
            Renderer::new(rendered, gains, &rig.calibration, motor_mnm, rate_hz, late_ticks).ok_or_else(too_slow)?;
        let remarks = softer.iter().chain(&remarks).map(|remark| axis.words(remark).into_owned()).collect();
        Ok(Self { model, renderer, gains, remarks, admission, without_remarks: asked.without_remarks })
    }

    /// The remarks to print for the operator.
    pub fn remarks_to_print(&self) -> impl Iterator<Item = &String> {
        self.remarks.iter().filter(|_| !self.without_remarks)
    }
}
