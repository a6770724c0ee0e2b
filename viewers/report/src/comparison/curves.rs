//! Torque against angle and against velocity, a small plot for each knob.

use std::f64::consts::{PI, TAU};

use dynamics::{Direction, Motion};
use maud::{Markup, html};

use super::input::{ComparedKnob, Comparison};
use crate::figures::{ANGLE, THIRD, TORQUE, VELOCITY, real};
use crate::numbers::three;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Height of a small plot, SVG units.
const HEIGHT: u32 = 190;
/// Points of a curve for each detent, and fewest and most of a curve.
const POINTS_PER_DETENT: f64 = 24.0;
const FEWEST_POINTS: usize = 240;
const MOST_POINTS: usize = 2400;
/// Detents in a plot on a scale of its own.
const DETENTS: f64 = 3.0;
/// Speed up to which friction is drawn, rad/s, about that of the paper's sweep.
const FASTEST_RAD_S: f64 = 8.0;
/// Share of the largest torque below which a curve looks flat on the common scale.
const FLAT: f64 = 0.05;

type Curve = Vec<(f64, f64)>;

/// The figures, numbered from `first`; gives how many there are.
pub(super) fn figures(compared: &Comparison, first: usize) -> (Markup, usize) {
    let knobs = &compared.knobs;
    let turn: Vec<Curve> = knobs.iter().map(|knob| angle_curve(knob, PI)).collect();
    let with_detents: Vec<&ComparedKnob> = knobs.iter().filter(|knob| detent_rad(knob).is_some()).collect();
    let friction: Vec<[Curve; 2]> = knobs.iter().map(friction_curves).collect();
    let mut number = first;
    let mut next = || {
        number += 1;
        number - 1
    };
    let markup = html! {
        figure.maps {
            h3 { span.number { "Figure " (next()) " " } "Torque against angle, one turn, on one scale" }
            (small_multiples(knobs, &turn.iter().map(|curve| vec![curve.clone()]).collect::<Vec<_>>(), ANGLE))
            figcaption {
                "What depends on the angle alone in each model: the detents, without friction and inertia. The scale is the same in all \
                 plots, so that heights compare; the number of waves is the number of detents in a turn. " (flat_words(knobs, &turn))
            }
        }
        @if !with_detents.is_empty() {
            figure.maps {
                h3 { span.number { "Figure " (next()) " " } "Three detents of each, each on a scale of its own" }
                div.thirds { @for knob in &with_detents { (own_scale(knob)) } }
                figcaption {
                    "The same curves close by. The axes differ from plot to plot: what compares here is the shape. The knob rests where \
                     a curve crosses zero upwards, since a positive torque is what it takes to turn it further."
                }
            }
        }
        figure.maps {
            h3 { span.number { "Figure " (next()) " " } "Friction against velocity, on one scale" }
            (small_multiples(knobs, &friction.iter().map(|two| two.to_vec()).collect::<Vec<_>>(), VELOCITY))
            figcaption {
                "What friction and drag take while the knob slides. Half the step at zero is Coulomb friction, the slope viscous friction; a line that \
                 falls as the knob turns faster is a negative viscous friction. Static friction, which holds the knob at rest, is not drawn."
            }
        }
    };
    (markup, number - first)
}

/// The torque that depends on the angle alone, over ± `reach_rad`.
fn angle_curve(knob: &ComparedKnob, reach_rad: f64) -> Curve {
    let detents = detent_rad(knob).map_or(0.0, |detent_rad| 2.0 * reach_rad / detent_rad);
    let points = ((POINTS_PER_DETENT * detents) as usize).clamp(FEWEST_POINTS, MOST_POINTS);
    (0..=points)
        .map(|step| reach_rad * (2.0 * real(step) / real(points) - 1.0))
        .filter_map(|angle_rad| {
            let motion = Motion { angle_rad, ..Motion::default() };
            Some((angle_rad, knob.model.as_ref()?.place_torque_mnm(&motion)))
        })
        .filter(|(_, torque_mnm)| torque_mnm.is_finite())
        .collect()
}

/// Angle from one detent to the next, if the model has detents.
fn detent_rad(knob: &ComparedKnob) -> Option<f64> {
    knob.detent_spacing_deg.map(f64::to_radians)
}

/// Friction and drag turning negatively and positively, with the direction's end at zero velocity.
fn friction_curves(knob: &ComparedKnob) -> [Curve; 2] {
    [(Direction::Negative, -FASTEST_RAD_S), (Direction::Positive, FASTEST_RAD_S)].map(|(direction, farthest_rad_s)| {
        (0..=FEWEST_POINTS)
            .map(|step| farthest_rad_s * real(step) / real(FEWEST_POINTS))
            .filter_map(|velocity_rad_s| {
                let motion = Motion { velocity_rad_s, ..Motion::default() };
                let model = knob.model.as_ref()?;
                Some((velocity_rad_s, model.friction_mnm(&motion, direction) + model.drag_mnm(&motion)))
            })
            .filter(|(_, torque_mnm)| torque_mnm.is_finite())
            .collect()
    })
}

/// Knobs whose curve is hardly seen beside the largest.
fn flat_words(knobs: &[ComparedKnob], curves: &[Curve]) -> String {
    let height = |curve: &Curve| curve.iter().map(|(_, torque)| torque.abs()).fold(0.0, f64::max);
    let largest = curves.iter().map(height).fold(0.0, f64::max);
    let names = |keep: &dyn Fn(f64) -> bool| -> Vec<&str> {
        let kept = knobs.iter().zip(curves).filter(|(_, curve)| keep(height(curve)));
        kept.map(|(knob, _)| knob.name.as_str()).collect()
    };
    let none = names(&|height| height == 0.0);
    let small = names(&|height| height > 0.0 && height < FLAT * largest);
    let mut words = Vec::new();
    if !none.is_empty() {
        words.push(format!("Nothing in {} depends on the angle.", none.join(", ")));
    }
    if !small.is_empty() {
        words.push(format!(
            "The waves of {} are too small for this scale; the next figure shows them.",
            small.join(", ")
        ));
    }
    words.join(" ")
}

/// A plot for each knob, all on the scale that holds every curve.
fn small_multiples(knobs: &[ComparedKnob], curves: &[Vec<Curve>], title: &str) -> Markup {
    let all = || curves.iter().flatten().flatten();
    let x = Axis::around(title, all().map(|(at, _)| *at));
    let y = Axis::around(TORQUE, all().map(|(_, torque)| *torque).chain([0.0]));
    html! {
        div.thirds {
            @for (knob, curves) in knobs.iter().zip(curves) { (panel(knob, curves, &x, &y, title == ANGLE)) }
        }
    }
}

fn own_scale(knob: &ComparedKnob) -> Markup {
    let curve = angle_curve(knob, 0.5 * DETENTS * detent_rad(knob).unwrap_or(TAU));
    let x = Axis::around(ANGLE, curve.iter().map(|(at, _)| *at));
    let y = Axis::around(TORQUE, curve.iter().map(|(_, torque)| *torque));
    panel(knob, &[curve], &x, &y, true)
}

fn panel(knob: &ComparedKnob, curves: &[Curve], x: &Axis, y: &Axis, with_detents: bool) -> Markup {
    let lines = curves.iter().map(|curve| Layer::Line(Ink::Model, curve.clone()));
    let plot = Plot {
        size: (THIRD.0, HEIGHT),
        x: x.clone(),
        y: y.clone(),
        layers: [Layer::Level(Ink::Zero, 0.0)].into_iter().chain(lines).collect(),
    };
    html! {
        div.map {
            p { strong { (knob.name) } @if with_detents { span.faint { (in_a_turn(knob)) } } }
            (plot.svg(&format!("Torque of {}", knob.name)))
        }
    }
}

/// How many detents a turn has.
fn in_a_turn(knob: &ComparedKnob) -> String {
    match knob.detents_per_turn.zip(knob.detent_spacing_deg) {
        Some((per_turn, spacing_deg)) => {
            format!("{} detents in a turn, {}° apart", three(per_turn), three(spacing_deg))
        }
        None => "no detents".to_owned(),
    }
}
