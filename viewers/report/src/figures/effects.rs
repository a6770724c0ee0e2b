//! Each effect by itself: its own torque plus what the whole model left over, over the quantity that it depends on.

use std::f64::consts::TAU;

use dynamics::{Coordinate, Direction, Effect, Motion, Part, effects};
use identification::statistics::range;
use identification::{Fit, Point};

use super::{ACCELERATION, ANGLE, Figure, Mark, THIRD, TORQUE, VELOCITY, real, thinned};
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Dots in one plot.
const MOST_DOTS: usize = 2500;
/// Points of the model's curve.
const CURVE: usize = 240;

/// One figure for each effect of the fit that was estimated and is a curve over one quantity.
pub(crate) fn effect_figures(fit: &Fit, points: &[Point]) -> Vec<Figure> {
    let is_estimated = |effect: &&Effect| {
        effect.parameters().all(|(kind, _)| fit.parameters.get(kind.name).is_some_and(|found| found.value.is_some()))
    };
    fit.effects()
        .iter()
        .filter(is_estimated)
        .filter_map(|effect| Some(figure(&View::of(effect)?, effect, points)))
        .collect()
}

/// How an effect is looked at.
struct View {
    axis: &'static str,
    caption: &'static str,
    of: Box<dyn Fn(&Motion) -> f64>,
    /// A motion for a value of the quantity.
    motion: fn(f64, &Effect) -> Motion,
    /// Whether the curve jumps at zero.
    jumps: bool,
}

impl View {
    /// `None` for an effect that is no curve over one quantity.
    fn of(effect: &Effect) -> Option<Self> {
        match effect.kind().part {
            Part::Inertia(_) => Some(Self {
                axis: ACCELERATION,
                caption: "A straight line through zero; its slope is the moment of inertia.",
                of: Box::new(|motion| motion.acceleration_rad_s2),
                motion: |value, _| Motion { acceleration_rad_s2: value, ..Motion::default() },
                jumps: false,
            }),
            Part::FrictionTable(of) if of.over == Coordinate::Angle => Some(Self {
                axis: ANGLE,
                caption: "The friction in the positive direction over the angles that were captured.",
                of: Box::new(|motion| motion.angle_rad),
                motion: |value, _| Motion { angle_rad: value, velocity_rad_s: f64::MIN_POSITIVE, ..Motion::default() },
                jumps: false,
            }),
            Part::Friction(_) | Part::FrictionTable(_) => Some(Self {
                axis: VELOCITY,
                caption: "The step at zero is Coulomb friction, the slopes are viscous friction. Dots that leave the lines \
                          near zero speak of friction that changes with speed.",
                of: Box::new(|motion| motion.velocity_rad_s),
                motion: |value, _| Motion { velocity_rad_s: value, ..Motion::default() },
                jumps: true,
            }),
            Part::Torque(_) if effect.kind().name == effects::detent::KIND.name => {
                let [_, period_rad, phase_rad] = *effect.values() else { return None };
                Some(Self {
                    axis: "angle within a detent (rad)",
                    caption: "All detents laid over each other. Dots that leave the sine tell the true shape of the detents.",
                    of: Box::new(move |motion| {
                        (motion.angle_rad / period_rad + phase_rad).rem_euclid(TAU) * period_rad.abs()
                    }),
                    motion: |value, effect| Motion {
                        angle_rad: value - effect.values()[2] * effect.values()[1],
                        ..Motion::default()
                    },
                    jumps: false,
                })
            }
            Part::Torque(_) if effect.kind().depends_only_on(Coordinate::Velocity) => Some(Self {
                axis: VELOCITY,
                caption: "The effect's torque over the velocities that were captured.",
                of: Box::new(|motion| motion.velocity_rad_s),
                motion: |value, _| Motion { velocity_rad_s: value, ..Motion::default() },
                jumps: false,
            }),
            Part::Torque(_) | Part::TorqueTable(_) => Some(Self {
                axis: ANGLE,
                caption: "The effect's torque over the angles that were captured.",
                of: Box::new(|motion| motion.angle_rad),
                motion: |value, _| Motion { angle_rad: value, ..Motion::default() },
                jumps: false,
            }),
            _ => None,
        }
    }
}

fn figure(view: &View, effect: &Effect, points: &[Point]) -> Figure {
    let dots: Vec<(f64, f64)> = thinned(points.iter(), MOST_DOTS)
        .into_iter()
        .map(|point| ((view.of)(&point.motion()), torque_mnm(effect, &point.motion()) + point.residual_mnm))
        .filter(|(at, torque)| at.is_finite() && torque.is_finite())
        .collect();
    let [first, last] = range(dots.iter().map(|(at, _)| at));
    let curve: Vec<(f64, f64)> = (0..=CURVE)
        .map(|step| first + (last - first) * real(step) / real(CURVE))
        .map(|at| (at, torque_mnm(effect, &(view.motion)(at, effect))))
        .filter(|(at, torque)| at.is_finite() && torque.is_finite())
        .collect();
    let mut layers = vec![Layer::Level(Ink::Zero, 0.0), Layer::Clouds(vec![(Ink::Measured, dots.clone())])];
    if view.jumps {
        let (below, above): (Vec<_>, Vec<_>) = curve.iter().partition(|(at, _)| *at < 0.0);
        layers.extend([Layer::Line(Ink::Model, below), Layer::Line(Ink::Model, above)]);
    } else {
        layers.push(Layer::Line(Ink::Model, curve.clone()));
    }
    let name = effect.kind().name;
    let title = format!("{}{} alone", name[..1].to_uppercase(), &name[1..]);
    let plot = Plot {
        size: THIRD,
        x: Axis::around(view.axis, dots.iter().map(|(at, _)| *at)),
        y: Axis::around(TORQUE, dots.iter().chain(&curve).map(|(_, torque)| *torque)),
        layers,
    };
    Figure {
        legend: vec![(Mark::Dots, Ink::Measured, "measured less the rest"), (Mark::Line, Ink::Model, "model")],
        plot: plot.svg(&title),
        title,
        caption: view.caption.to_owned(),
    }
}

/// Torque of one effect, mNm.
fn torque_mnm(effect: &Effect, motion: &Motion) -> f64 {
    let values = effect.values();
    match effect.kind().part {
        Part::Inertia(inertia) => inertia(values) * motion.acceleration_rad_s2,
        Part::Torque(_) | Part::TorqueTable(_) => effect.free_torque_mnm(motion),
        Part::Friction(_) | Part::FrictionTable(_) => effect.friction_mnm(motion, Direction::of(motion.velocity_rad_s)),
        _ => f64::NAN,
    }
}
