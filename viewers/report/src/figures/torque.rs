//! Measured and fitted torque over the whole capture, against angle and against velocity.

use dynamics::effects;
use identification::{Fit, Point};
use maud::Markup;

use super::bins::{Bin, runs, smoothed};
use super::{ANGLE, Figure, Mark, TORQUE, VELOCITY, WIDE, real, thinned, travel_rad};
use crate::numbers::two;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Dots of each direction in one plot.
const MOST_DOTS: usize = 3500;
/// Bins over the angle, one for about two SVG units.
const ANGLE_BINS: usize = 400;
/// Rows in each of them where detents must be seen, and where there are none.
const ANGLE_ROWS: (usize, usize) = (6, 40);
/// Bins over the velocity and rows in each.
const VELOCITY_BINS: (usize, usize) = (80, 10);
/// Share of the velocities over which the model is averaged, so that detents and inertia average out.
const VELOCITY_SMOOTHING: f64 = 0.15;
/// Bins that a detent needs to be seen in the line.
const BINS_PER_DETENT: f64 = 5.0;

pub(crate) const LEGEND: [(Mark, Ink, &str); 4] = [
    (Mark::Dots, Ink::MeasuredPositive, "measured turning positively"),
    (Mark::Line, Ink::ModelPositive, "model"),
    (Mark::Dots, Ink::MeasuredNegative, "measured turning negatively"),
    (Mark::Line, Ink::ModelNegative, "model"),
];

/// Torque against angle, by direction.
pub(crate) fn angle_figure(fit: &Fit, points: &[Point]) -> Figure {
    let detent_rad = fit.parameters.get(effects::detent::KIND.parameters[1].name).and_then(|period| period.value);
    let detents = detent_rad.map(|period| std::f64::consts::TAU * period.abs());
    let [positive, negative] = angle_runs(points, detents.is_some());
    let bins = positive.iter().chain(&negative).map(Vec::len).max().unwrap_or(1);
    let averaged = detents.is_some_and(|detent| real(bins) < BINS_PER_DETENT * travel_rad(points) / detent);
    let caption = format!(
        "Dots: what was measured, filtered to the fit's band. Lines: the model's torque for the motion that was captured, \
         averaged at each angle; around them the model's 95 % interval ({}). The two directions lie apart by friction; \
         dots spread about the lines because inertia and viscous friction ask for different torques at one angle.{}",
        interval_words(fit),
        if averaged {
            " The detents are finer than the line can follow: see them one by one in the figures of single effects."
        } else if detents.is_some() {
            " The waves are the detents."
        } else {
            ""
        }
    );
    Figure {
        title: "Torque against angle".to_owned(),
        legend: LEGEND.to_vec(),
        plot: plot(points, ANGLE, |point| point.angle_rad, [positive, negative]).svg("Torque against angle"),
        caption,
    }
}

/// The plot of [`angle_figure`] alone.
pub(crate) fn angle_plot(points: &[Point], has_detents: bool) -> Markup {
    plot(points, ANGLE, |point| point.angle_rad, angle_runs(points, has_detents)).svg("Torque against angle")
}

/// Measured and model torque over any quantity, by direction; the model as means in bins, at most so many and of so many
/// rows on average.
pub(crate) fn quantity_plot(
    points: &[Point],
    title: &str,
    of: fn(&Point) -> f64,
    (most, rows): (usize, usize),
) -> Plot {
    plot(points, title, of, directions(points).map(|points| runs(points.iter(), of, most, rows)))
}

/// The model's torque over the angle, by direction.
fn angle_runs(points: &[Point], has_detents: bool) -> [Vec<Vec<Bin>>; 2] {
    let rows = if has_detents { ANGLE_ROWS.0 } else { ANGLE_ROWS.1 };
    directions(points).map(|points| runs(points.iter(), |point| point.angle_rad, ANGLE_BINS, rows))
}

/// Torque against velocity, by direction.
pub(crate) fn velocity_figure(fit: &Fit, points: &[Point]) -> Figure {
    Figure {
        title: "Torque against velocity".to_owned(),
        legend: LEGEND.to_vec(),
        plot: velocity_plot(points),
        caption: format!(
            "Lines: the model's torque, averaged over similar velocities, with its 95 % interval. Their step at zero is \
             Coulomb friction, their slope viscous friction; the dots spread by inertia and detents, and what of these does \
             not average out bends the lines. Nothing is shown below {} rad/s, where the knob may stick and its torque is \
             whatever holds it.",
            two(fit.preparation.stick_threshold_rad_s)
        ),
    }
}

/// The plot of [`velocity_figure`] alone.
pub(crate) fn velocity_plot(points: &[Point]) -> Markup {
    let fastest_rad_s = points.iter().map(|point| point.velocity_rad_s.abs()).fold(0.0, f64::max);
    let lines = directions(points).map(|points| {
        let bins = runs(points.iter(), |point| point.velocity_rad_s, VELOCITY_BINS.0, VELOCITY_BINS.1);
        vec![smoothed(&bins, VELOCITY_SMOOTHING * fastest_rad_s)]
    });
    plot(points, VELOCITY, |point| point.velocity_rad_s, lines).svg("Torque against velocity")
}

fn interval_words(fit: &Fit) -> String {
    format!("± {} mNm on average", two(fit.mean_ci95_mnm))
}

/// The points with positive and those with negative velocity.
fn directions(points: &[Point]) -> [Vec<Point>; 2] {
    let (positive, negative) = points.iter().partition(|point| point.velocity_rad_s > 0.0);
    [positive, negative]
}

fn plot(points: &[Point], title: &str, of: fn(&Point) -> f64, lines: [Vec<Vec<Bin>>; 2]) -> Plot {
    let measured = [Ink::MeasuredPositive, Ink::MeasuredNegative];
    let clouds = measured.into_iter().zip(directions(points)).map(|(ink, points)| {
        let dots = thinned(points.iter(), MOST_DOTS);
        (ink, dots.iter().map(|point| (of(point), point.torque_mnm)).collect())
    });
    let mut layers = vec![Layer::Level(Ink::Zero, 0.0), Layer::Clouds(clouds.collect())];
    for (ink, runs) in [Ink::ModelPositive, Ink::ModelNegative].into_iter().zip(lines) {
        for run in runs {
            let edges = |bin: &Bin| (bin.at, bin.model_mnm - bin.half_width_mnm, bin.model_mnm + bin.half_width_mnm);
            if run.iter().any(|bin| bin.half_width_mnm > 0.0) {
                layers.push(Layer::Band(ink, run.iter().map(edges).collect()));
            }
            layers.push(Layer::Line(ink, run.iter().map(|bin| (bin.at, bin.model_mnm)).collect()));
        }
    }
    Plot {
        size: WIDE,
        x: Axis::around(title, points.iter().map(of)),
        y: Axis::around(TORQUE, points.iter().map(|point| point.torque_mnm)),
        layers,
    }
}
