//! Random knobs and hands, inside the bounds or not.

use std::f64::consts::TAU;

use dynamics::{Effect, Model, effects};
use hal::simulated_rig::{Grip, Hand, Intention};

use crate::numbers::Numbers;

/// A knob whose inertia, friction, stick and detents are drawn over decades; each but the inertia may be missing.
pub fn random_knob(numbers: &mut Numbers, largest_inertia: f64) -> Model {
    let mut knob =
        Model { name: "random".to_owned(), description: String::new(), effects: Vec::new(), ..Model::default() };
    knob.effects.push(Effect::new(&effects::inertia::KIND, &[numbers.between(0.02, largest_inertia)]));
    if numbers.unit() < 0.8 {
        let [coulomb, viscous] = [numbers.between(0.1, 60.0), numbers.between(1e-3, 5.0)];
        knob.effects.push(Effect::new(&effects::friction::KIND, &[coulomb, coulomb, viscous, viscous]));
        if numbers.unit() < 0.5 {
            let borne = coulomb * (1.0 + 2.0 * numbers.unit());
            knob.effects
                .push(Effect::new(&effects::karnopp_stick::KIND, &[borne, borne, numbers.between(0.003, 0.05)]));
        }
    }
    if numbers.unit() < 0.7 {
        let [amplitude, period] = [numbers.between(0.2, 80.0), numbers.between(0.01, 0.2)];
        knob.effects.push(Effect::new(&effects::detent::KIND, &[amplitude, period, TAU * numbers.unit()]));
    }
    knob
}

/// The same with an inner body behind a gap, or behind a shaft: gap, inertias, stiffness and damping over decades.
pub fn random_two_bodies(numbers: &mut Numbers, least_inertia: f64, largest_inertia: f64) -> Model {
    let mut knob = random_knob(numbers, largest_inertia);
    let cap_inertia = numbers.between(1.000_001 * least_inertia, largest_inertia);
    let inner_inertia = numbers.between(1e-4, 0.1);
    let [stiffness, damping] = [numbers.between(300.0, 1e5), numbers.between(0.05, 20.0)];
    if numbers.unit() < 0.75 {
        knob.effects[0].values_mut()[0] = cap_inertia + inner_inertia;
        let share = inner_inertia / (cap_inertia + inner_inertia);
        let half_gap = numbers.between(1e-3, 0.1);
        knob.effects.push(Effect::new(&effects::backlash::KIND, &[half_gap, share, stiffness, damping]));
    } else {
        let [before, outer] = if numbers.unit() < 0.5 { [least_inertia, 0.0] } else { [cap_inertia; 2] };
        let inertia = before + inner_inertia;
        knob.effects[0].values_mut()[0] = inertia;
        knob.effects.push(Effect::new(&effects::shaft_compliance::KIND, &[stiffness, damping, outer / inertia]));
    }
    knob
}

/// A hand of the class, or none: it moves about for `moves_s` and then wants to be where it is.
pub fn random_hand(numbers: &mut Numbers, moves_s: f64, lasts_s: f64) -> Hand {
    const RATE_HZ: f64 = 1_000.0;
    let grip = if numbers.unit() < 0.1 {
        // It has let go.
        Grip { inertia: 0.0, damping: 0.0, stiffness_mnm_rad: 0.0 }
    } else {
        let stiffness_mnm_rad = numbers.between(20.0, 6_400.0);
        let damping = stiffness_mnm_rad / numbers.between(50.0, 1_000.0);
        Grip { inertia: 0.02 * numbers.unit(), damping, stiffness_mnm_rad }
    };
    let tones: Vec<[f64; 3]> =
        (0..4).map(|_| [numbers.between(0.01, 0.3), numbers.between(0.5, 8.0), TAU * numbers.unit()]).collect();
    let at = |time_s: f64| -> f64 {
        tones.iter().map(|[size, hz, phase]| size * ((TAU * hz * time_s + phase).sin() - phase.sin())).sum()
    };
    let angle_rad = (0..(lasts_s * RATE_HZ) as usize).map(|index| at((index as f64 / RATE_HZ).min(moves_s))).collect();
    Hand { grip, intention: Intention::Recorded { angle_rad, rate_hz: RATE_HZ }, begins_s: 0.05 }
}
