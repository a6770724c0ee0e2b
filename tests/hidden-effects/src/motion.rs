//! Commanded motions: swept sines or moves from point to point to train on, other motions to hold out.

use std::f64::consts::{PI, TAU};

use crate::draw::Draw;

/// The commanded angle of one capture, on a fine grid.
#[derive(Clone, Debug)]
pub struct Motion {
    angle_rad: Vec<f64>,
    grid_hz: f64,
}

/// Points per second of the grid that the command is kept on.
const GRID_HZ: f64 = 2000.0;
/// The knob rests this long at first, about.
const REST_S: f64 = 0.25;

impl Motion {
    /// Commanded angle at a time, rad, by cubic interpolation of the grid.
    pub fn angle_rad(&self, time_s: f64) -> f64 {
        let place = (time_s * self.grid_hz).max(0.0);
        let last = self.angle_rad.len() - 1;
        let index = (place as usize).min(last);
        let at = |offset: isize| self.angle_rad[index.saturating_add_signed(offset).min(last)];
        let (before, here, next, after) = (at(-1), at(0), at(1), at(2));
        let u = place - index as f64;
        let (slope, slope_next) = (0.5 * (next - before), 0.5 * (after - here));
        let rise = next - here;
        here + u * (slope + u * (3.0 * rise - 2.0 * slope - slope_next + u * (slope + slope_next - 2.0 * rise)))
    }

    /// Lowest and highest commanded angle, rad.
    pub fn travel_rad(&self) -> [f64; 2] {
        let fold = |pick: fn(f64, f64) -> f64, start| self.angle_rad.iter().copied().fold(start, pick);
        [fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY)]
    }

    /// The same motion, moved and stretched so that it spans `travel_rad`.
    pub fn spanning(mut self, travel_rad: [f64; 2]) -> Self {
        let [low, high] = self.travel_rad();
        let stretch = (travel_rad[1] - travel_rad[0]) / (high - low);
        self.angle_rad.iter_mut().for_each(|angle| *angle = travel_rad[0] + stretch * (*angle - low));
        self
    }

    /// One or more linear swept sines from 0 to about 3 Hz, amplitudes 1 to 3 rad.
    pub fn sweeps(duration_s: f64, draw: &mut Draw) -> Self {
        let centre = draw.uniform(-0.7, 0.7);
        let moving = duration_s - REST_S;
        let holds = Hold::draw(draw, moving);
        let moving = moving - holds.iter().map(|hold| hold.length_s).sum::<f64>();
        let most = (moving / 2.4).floor().max(1.0) as usize;
        let count = 1 + draw.below(most);
        let parts: Vec<f64> = (0..count).map(|_| draw.uniform(0.8, 1.25)).collect();
        let whole: f64 = parts.iter().sum();
        let mut shape = Vec::new();
        for part in parts {
            let length = moving * part / whole;
            let amplitude = draw.uniform(1.0, 2.7);
            let last_hz = draw.uniform(2.2, 3.2);
            let fastest = draw.uniform(14.0, 22.0);
            let taper = (fastest / (TAU * last_hz * amplitude)).min(1.0);
            let turn = if draw.chance(0.5) { 1.0 } else { -1.0 };
            let count = (length * GRID_HZ) as usize;
            for index in 0..count {
                let time = index as f64 / GRID_HZ;
                let envelope = (1.0 + (taper - 1.0) * time / length) * ease((length - time) / 0.25);
                shape.push(turn * amplitude * envelope * (PI * last_hz / length * time * time).sin());
            }
        }
        Self::assemble(&shape, centre, &holds, duration_s)
    }

    /// Moves from point to point at constant accelerations, with a rest after each.
    pub fn moves(duration_s: f64, draw: &mut Draw) -> Self {
        let centre = draw.uniform(-0.7, 0.7);
        let count = ((duration_s - REST_S) * GRID_HZ) as usize;
        let half_travel = draw.uniform(1.0, 2.7);
        let (mut shape, mut from) = (Vec::with_capacity(count), 0.0);
        while shape.len() < count {
            let way = draw.uniform(-half_travel, half_travel) - from;
            let acceleration = draw.log_uniform(20.0, 200.0);
            let fastest = draw.uniform(1.0, 16.0).min((acceleration * way.abs()).sqrt());
            let rising_s = fastest / acceleration;
            let moving_s = rising_s + way.abs() / fastest;
            let rest_s = draw.uniform(0.02, 0.25);
            for index in 0..((moving_s + rest_s) * GRID_HZ) as usize {
                let time = (index as f64 / GRID_HZ).min(moving_s);
                // Distance that a constant acceleration adds if it begins at `begin`.
                let added = |begin: f64| 0.5 * acceleration * (time - begin).max(0.0).powi(2);
                shape.push(from + way.signum() * (added(0.0) - added(rising_s) - added(moving_s - rising_s)));
            }
            from += way;
        }
        shape.truncate(count);
        Self::assemble(&shape, centre, &[], duration_s)
    }

    /// A motion to hold out: several sines at once, a sweep downwards, or a sine whose amplitude comes and goes.
    pub fn held_out(duration_s: f64, draw: &mut Draw) -> Self {
        let centre = draw.uniform(-0.7, 0.7);
        let moving = duration_s - REST_S;
        let holds = Hold::draw(draw, moving);
        let moving = moving - holds.iter().map(|hold| hold.length_s).sum::<f64>();
        let count = (moving * GRID_HZ) as usize;
        let wave: Box<dyn Fn(f64) -> f64> = match draw.below(3) {
            0 => {
                let sines: Vec<[f64; 3]> = (0..draw.below(4) + 3)
                    .map(|_| {
                        let frequency = draw.uniform(0.25, 2.6);
                        [frequency, draw.uniform(0.4, 1.0) / frequency.max(0.7), draw.phase()]
                    })
                    .collect();
                Box::new(move |time| sines.iter().map(|[f, a, p]| a * ((TAU * f * time + p).sin() - p.sin())).sum())
            }
            1 => {
                let (first_hz, last_hz) = (draw.uniform(2.0, 3.0), draw.uniform(0.2, 0.5));
                Box::new(move |time| {
                    (TAU * (first_hz * time + 0.5 * (last_hz - first_hz) / moving * time * time)).sin()
                })
            }
            _ => {
                let (carrier, beat) = (draw.uniform(0.8, 2.2), draw.uniform(0.2, 0.6));
                let (depth, phase) = (draw.uniform(0.4, 0.9), draw.phase());
                Box::new(move |time| (1.0 + depth * (TAU * beat * time + phase).sin()) * (TAU * carrier * time).sin())
            }
        };
        let mut shape: Vec<f64> = (0..count)
            .map(|index| index as f64 / GRID_HZ)
            .map(|time| wave(time) * ease(time / 0.3) * ease((moving - time) / 0.3))
            .collect();
        let high = shape.iter().copied().fold(0.0, |most: f64, angle| most.max(angle.abs()));
        let fastest = shape.windows(2).fold(0.0, |most: f64, pair| most.max((pair[1] - pair[0]).abs() * GRID_HZ));
        let scale = (draw.uniform(1.0, 2.6) / high).min(draw.uniform(8.0, 21.0) / fastest);
        shape.iter_mut().for_each(|angle| *angle *= scale);
        Self::assemble(&shape, centre, &holds, duration_s)
    }

    /// Rest, then the shape, held where it turns.
    fn assemble(shape: &[f64], centre: f64, holds: &[Hold], duration_s: f64) -> Self {
        let total = (duration_s * GRID_HZ) as usize + 2;
        let mut angle_rad = vec![centre; (REST_S * GRID_HZ) as usize];
        let mut wanted = holds.iter().peekable();
        for (index, angle) in shape.iter().enumerate() {
            angle_rad.push(centre + angle);
            let turns = index > 0
                && shape.get(index + 1).is_some_and(|next| (next - angle) * (angle - shape[index - 1]) <= 0.0);
            if let Some(hold) = wanted.peek().filter(|hold| turns && index as f64 / GRID_HZ > hold.after_s) {
                angle_rad.resize(angle_rad.len() + (hold.length_s * GRID_HZ) as usize, centre + angle);
                wanted.next();
            }
        }
        let last = angle_rad.last().copied().unwrap_or(centre);
        angle_rad.resize(total.max(1), last);
        Self { angle_rad, grid_hz: GRID_HZ }
    }
}

/// A short hold at the first turning point after a time.
#[derive(Clone, Copy, Debug)]
struct Hold {
    after_s: f64,
    length_s: f64,
}

impl Hold {
    fn draw(draw: &mut Draw, moving_s: f64) -> Vec<Self> {
        let count = if draw.chance(0.4) { 0 } else { 1 + draw.below(2) };
        let mut holds: Vec<Self> = (0..count)
            .map(|_| Self {
                after_s: draw.uniform(0.2, 0.7) * moving_s,
                length_s: draw.uniform(0.1, 0.35).min(0.08 * moving_s),
            })
            .collect();
        holds.sort_by(|first, second| first.after_s.total_cmp(&second.after_s));
        holds
    }
}

/// From 0 to 1 as its argument does, smoothly.
fn ease(place: f64) -> f64 {
    let place = place.clamp(0.0, 1.0);
    place * place * (3.0 - 2.0 * place)
}
