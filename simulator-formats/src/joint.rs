//! A model as the parameters of a joint, sorted by what simulators have.

use dynamics::effects::{
    backlash, cogging, detent, detent_harmonics, end_stop, friction, inertia, karnopp_stick, mass_imbalance,
    presliding_hysteresis, quadratic_drag, return_spring, shaft_compliance,
};
use dynamics::{Bristles, Coupling, Model};

use crate::said::{LinearAxis, refuse_linear};

/// A torque of the angle, amplitude·sin(per_rad·θ + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sine {
    pub(crate) amplitude_mnm: f64,
    pub(crate) per_rad: f64,
    pub(crate) phase_rad: f64,
}

/// The parameters of a joint, in mNm, rad and s; torques are those that the joint takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joint {
    pub(crate) inertia: f64,
    /// Coulomb friction, negative and positive.
    pub(crate) coulomb_mnm: [f64; 2],
    /// Viscous friction, negative and positive.
    pub(crate) viscous: [f64; 2],
    /// What a joint at rest bears, negative and positive.
    pub(crate) static_mnm: [f64; 2],
    pub(crate) sines: Vec<Sine>,
    /// Stiffness and centre.
    pub(crate) spring: Option<[f64; 2]>,
    /// Torque per squared speed.
    pub(crate) quadratic_drag: f64,
    pub(crate) bristles: Option<Bristles>,
    pub(crate) coupling: Option<Coupling>,
    /// Angles of the end stops.
    pub(crate) range_rad: Option<[f64; 2]>,
}

impl Joint {
    pub(crate) fn of(model: &Model) -> Result<Self, LinearAxis> {
        refuse_linear(model)?;
        let mut joint = Self {
            inertia: model.inertia(),
            coupling: model.coupling(),
            bristles: model.bristles(),
            ..Self::default()
        };
        for effect in &model.effects {
            let values = effect.values();
            match effect.kind().name {
                name if name == friction::KIND.name => {
                    joint.coulomb_mnm = [values[0], values[1]];
                    joint.viscous = [values[2], values[3]];
                }
                name if name == karnopp_stick::KIND.name => joint.static_mnm = [values[0], values[1]],
                name if name == detent::KIND.name => joint.sine(values[0], 1.0 / values[1], values[2]),
                name if name == cogging::KIND.name => {
                    cogging::lines(values).for_each(|[torque, per_turn, phase]| joint.sine(torque, per_turn, phase));
                }
                name if name == mass_imbalance::KIND.name => joint.sine(values[0], 1.0, values[1]),
                name if name == detent_harmonics::KIND.name => joint.harmonics(values),
                name if name == return_spring::KIND.name => joint.spring = Some([values[0], values[1]]),
                name if name == quadratic_drag::KIND.name => joint.quadratic_drag = values[0],
                name if name == end_stop::KIND.name => joint.range_rad = Some([values[0], values[1]]),
                _ => {}
            }
        }
        joint.static_mnm = [0, 1].map(|side| joint.static_mnm[side].max(joint.coulomb_mnm[side]));
        Ok(joint)
    }

    fn sine(&mut self, amplitude_mnm: f64, per_rad: f64, phase_rad: f64) {
        if amplitude_mnm != 0.0 {
            self.sines.push(Sine { amplitude_mnm, per_rad, phase_rad });
        }
    }

    /// Period, then sine and cosine of each order from the second on.
    fn harmonics(&mut self, values: &[f64]) {
        for (order, pair) in (2_u32..).zip(values[1..].chunks_exact(2)) {
            self.sine(pair[0].hypot(pair[1]), f64::from(order) / values[0], pair[1].atan2(pair[0]));
        }
    }

    /// The same friction in both directions, as most simulators have it.
    pub(crate) fn mean(sides: [f64; 2]) -> f64 {
        0.5 * (sides[0] + sides[1])
    }
}

/// Names of the effects that a joint of MJCF says.
pub(crate) fn of_mjcf() -> [&'static str; 11] {
    [
        inertia::KIND.name,
        friction::KIND.name,
        detent::KIND.name,
        detent_harmonics::KIND.name,
        cogging::KIND.name,
        mass_imbalance::KIND.name,
        return_spring::KIND.name,
        quadratic_drag::KIND.name,
        presliding_hysteresis::KIND.name,
        backlash::KIND.name,
        shaft_compliance::KIND.name,
    ]
}

/// Names of the effects that a joint of URDF says.
pub(crate) fn of_urdf() -> [&'static str; 2] {
    [inertia::KIND.name, friction::KIND.name]
}
