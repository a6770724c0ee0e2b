//! The rig in small time steps: a rotor under a position servo, a cap, and an inner body that slides.
//!
//! The steps are of the position Verlet kind: half a step of position, the forces there, a step of velocity, the
//! other half of position. Coulomb friction is solved within the step (Moreau 1988): either the body slides the
//! step through against the full friction, or it stands and friction is whatever holds it.

use crate::effect::{Effect, State};
use crate::knob::Knob;
use crate::motion::Motion;

/// Length of a time step, s.
pub const STEP_S: f64 = 1e-5;
/// The servo computes a new torque after so many steps: 20 kHz.
const STEPS_PER_SERVO_TICK: usize = 5;
/// Time constant with which the load of what rubs follows, s: the friction changes the acceleration that it depends on, so one of the two
/// must wait for the other. It is far below a sample, since a loaded mechanism rubs at once.
const LOAD_LAG_S: f64 = 5e-5;
/// The servo holds the knob this long before the capture starts, so that it starts at rest.
const SETTLING_STEPS: usize = 20_000;

/// The motor and its servo.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    /// Inertia of rotor and coupling before the torque sensor, mNm s²/rad.
    pub rotor_inertia: f64,
    /// Natural frequency of the position servo with the knob on it, Hz.
    pub servo_hz: f64,
    /// Its damping ratio.
    pub servo_damping: f64,
    /// Time constant of the motor's current, s.
    pub current_lag_s: f64,
}

/// What happened: positions and velocities of the cap at the steps' borders, accelerations and the torque that the
/// sensor passed on within each step. Entry `n` of the latter two belongs to the step that ends at entry `n + 1` of
/// the former.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Angle of the cap, rad.
    pub angle_rad: Vec<f64>,
    /// Velocity of the cap, rad/s.
    pub velocity_rad_s: Vec<f64>,
    /// Mean acceleration of the cap in a step, rad/s².
    pub acceleration_rad_s2: Vec<f64>,
    /// Mean torque through the sensor in a step, mNm.
    pub torque_mnm: Vec<f64>,
}

/// How cap and inner body hang together.
#[derive(Clone, Copy, Debug)]
pub enum Link {
    /// As one body.
    Rigid,
    /// By a contact of `stiffness`, mNm/rad, and `damping`, mNm s/rad, beyond `half_gap`, rad; `inner_share` of the inertia
    /// lies behind it.
    #[allow(missing_docs, reason = "said above")]
    Gap { half_gap: f64, inner_share: f64, stiffness: f64, damping: f64 },
    /// By a shaft of `stiffness`, mNm/rad, and `damping`, mNm s/rad; `outer_share` of the inertia moves with the cap.
    #[allow(missing_docs, reason = "said above")]
    Spring { outer_share: f64, stiffness: f64, damping: f64 },
}

impl Link {
    fn of(effects: &[Effect]) -> Self {
        let mut links = effects.iter().rev().map(|effect| effect.acts().link(effect.size));
        links.find(|link| !matches!(link, Self::Rigid)).unwrap_or(Self::Rigid)
    }

    /// Part of the knob's inertia that moves with the cap.
    fn cap_share(self) -> f64 {
        match self {
            Self::Rigid => 1.0,
            Self::Gap { inner_share, .. } => 1.0 - inner_share,
            Self::Spring { outer_share, .. } => outer_share,
        }
    }

    fn torque(self, twist: f64, speed: f64) -> f64 {
        match self {
            Self::Rigid => 0.0,
            Self::Gap { half_gap, stiffness, damping, .. } => {
                let depth = twist.abs() - half_gap;
                // A contact pushes and never pulls.
                if depth > 0.0 {
                    twist.signum() * (stiffness * depth + damping * speed * twist.signum()).max(0.0)
                } else {
                    0.0
                }
            }
            Self::Spring { stiffness, damping, .. } => stiffness * twist + damping * speed,
        }
    }
}

/// The body that rubs and has detents: what of the knob and its effects acts on it.
struct Slider<'a> {
    knob: &'a Knob,
    effects: &'a [Effect],
    bristle: Option<Bristle>,
    /// Relative depth and phase of an inertia that varies twice in a turn.
    inertia_wave: Option<[f64; 2]>,
    capture: usize,
    /// Torque that the body's inertia and detents carried lately, mNm.
    load_mnm: f64,
}

/// Friction as a bristle that bends before it slips.
#[derive(Clone, Copy, Debug)]
pub struct Bristle {
    /// Angle over which friction builds up, rad.
    pub length_rad: f64,
    /// Damping over the critical one of the body on it.
    pub damping_ratio: f64,
    /// Deflection over that at slip.
    pub deflection: f64,
}

/// One step of the slider: velocity after it, friction and place torque within it.
struct Step {
    velocity: f64,
    friction: f64,
    place: f64,
}

impl Slider<'_> {
    fn state(&self, angle_rad: f64, velocity_rad_s: f64, time_s: f64) -> State {
        State { angle_rad, velocity_rad_s, time_s, capture: self.capture }
    }

    fn sum(&self, of: impl Fn(&Effect) -> f64) -> f64 {
        self.effects.iter().map(of).sum()
    }

    fn place_torque(&self, state: &State) -> f64 {
        let mut torque = self.sum(|effect| effect.acts().body_torque(effect.size, state));
        if let (Some(period), Some(phase)) = (self.knob.detent_period, self.knob.detent_phase) {
            let slipped = self.sum(|effect| effect.acts().slipped_rad(effect.size, state));
            let x = (state.angle_rad - slipped) / period + phase;
            let wave = |effect: &Effect| effect.acts().detent_wave(effect.size, x, state.velocity_rad_s);
            let shaped = self.effects.iter().find_map(wave);
            torque += self.knob.detent_amplitude * shaped.unwrap_or_else(|| x.sin());
        }
        torque
    }

    /// Inertia of the body when `plain` without the effect, and its slope with the angle.
    fn inertia(&self, plain: f64, angle: f64) -> (f64, f64) {
        match self.inertia_wave {
            Some([depth, phase]) => {
                let (sine, cosine) = (2.0 * angle + phase).sin_cos();
                (plain * (1.0 + depth * cosine), -2.0 * plain * depth * sine)
            }
            None => (plain, 0.0),
        }
    }

    /// Moves a body of inertia `total` under the torque `drive` by a step from `velocity`, at the half-step angle.
    fn step(&mut self, total: f64, drive: f64, angle: f64, velocity: f64, time_s: f64) -> Step {
        let state = self.state(angle, velocity, time_s);
        let place = self.place_torque(&state);
        let factor = |effect: &Effect, viscous| effect.acts().friction_factor(effect.size, &state, viscous);
        let product = |viscous| self.effects.iter().map(|effect| factor(effect, viscous)).product::<f64>();
        let (coulomb_factor, viscous_factor) = (product(false), product(true));
        let extra = self.sum(|effect| effect.acts().friction_extra(effect.size, &state));
        let of_load = self.sum(|effect| effect.acts().load_friction(effect.size)) * self.load_mnm.abs();
        let coulomb = |own: f64| coulomb_factor * (own + extra) + of_load;
        let up = (coulomb(self.knob.coulomb_positive), viscous_factor * self.knob.viscous_positive);
        let down = (coulomb(self.knob.coulomb_negative), viscous_factor * self.knob.viscous_negative);
        let impulse = total * velocity + STEP_S * (drive - place);

        if let Some(bristle) = &mut self.bristle {
            let Bristle { length_rad, damping_ratio, deflection } = *bristle;
            // Dahl's equation by Heun's method; the step is far shorter than the bristle.
            let slope = |deflection: f64| (velocity - velocity.abs() * deflection) / length_rad;
            let trial = deflection + STEP_S * slope(deflection);
            bristle.deflection = deflection + 0.5 * STEP_S * (slope(deflection) + slope(trial));
            let middle = 0.5 * (deflection + bristle.deflection);
            let level = if middle > 0.0 { up.0 } else { down.0 };
            let damping = 2.0 * damping_ratio * (level / length_rad * total).sqrt();
            let bend = level * middle + damping * (velocity - velocity.abs() * middle);
            let viscous = if velocity > 0.0 { up.1 } else { down.1 };
            let after = (impulse - STEP_S * (bend + 0.5 * viscous * velocity)) / (total + 0.5 * STEP_S * viscous);
            return Step { velocity: after, friction: bend + 0.5 * viscous * (velocity + after), place };
        }
        let slid = |sign: f64, (coulomb, viscous): (f64, f64)| {
            (impulse - STEP_S * (sign * coulomb + 0.5 * viscous * velocity)) / (total + 0.5 * STEP_S * viscous)
        };
        let rising = slid(1.0, up);
        let falling = slid(-1.0, down);
        if velocity >= 0.0 && rising > 0.0 {
            Step { velocity: rising, friction: up.0 + 0.5 * up.1 * (velocity + rising), place }
        } else if velocity <= 0.0 && falling < 0.0 {
            Step { velocity: falling, friction: -down.0 + 0.5 * down.1 * (velocity + falling), place }
        } else {
            // The body stands: from rest the drive does not overcome the friction, and from motion the velocity would pass zero.
            Step { velocity: 0.0, friction: impulse / STEP_S, place }
        }
    }
}

/// Runs the rig through a motion of `duration_s`. `capture` is 0 for the training motion, 1 for the held-out one.
pub fn run(rig: Rig, knob: &Knob, effects: &[Effect], motion: &Motion, duration_s: f64, capture: usize) -> Course {
    let link = Link::of(effects);
    let cap_inertia = knob.inertia * link.cap_share();
    let inner_inertia = knob.inertia - cap_inertia;
    let mut slider = Slider {
        knob,
        effects,
        bristle: effects.iter().find_map(|effect| effect.acts().bristle(effect.size)),
        inertia_wave: effects.iter().find_map(|effect| effect.acts().inertia_wave(effect.size)),
        capture,
        load_mnm: 0.0,
    };

    // The servo's gains; where the knob can come loose from the rotor, no stiffer than the rotor alone bears.
    let total = rig.rotor_inertia + knob.inertia;
    let bare = rig.rotor_inertia + cap_inertia;
    let bearable = 3000.0 * bare / (2.0 * rig.servo_damping * total);
    let natural = (std::f64::consts::TAU * rig.servo_hz).min(bearable);
    let (gain, damping) = (total * natural * natural, 2.0 * rig.servo_damping * total * natural);

    let steps = SETTLING_STEPS + (duration_s / STEP_S).round() as usize + 2 * STEPS_PER_SERVO_TICK;
    let mut course = Course::default();
    let (mut cap_angle, mut cap_velocity) = (motion.angle_rad(0.0), 0.0);
    let (mut angle, mut velocity) = (cap_angle, 0.0);
    let (mut wanted, mut drive, mut before) = (0.0, 0.0, cap_angle);
    let current = STEP_S / rig.current_lag_s;
    for index in 0..steps {
        let time_s = ((index as f64 + 0.5 - SETTLING_STEPS as f64) * STEP_S).max(0.0);
        if index >= SETTLING_STEPS {
            course.angle_rad.push(cap_angle);
            course.velocity_rad_s.push(cap_velocity);
        }
        if index % STEPS_PER_SERVO_TICK == 0 {
            let commanded = motion.angle_rad((index as f64 - SETTLING_STEPS as f64) * STEP_S);
            let speed = (commanded - before) / (STEPS_PER_SERVO_TICK as f64 * STEP_S);
            before = commanded;
            wanted = gain * (commanded - cap_angle) + damping * (speed - cap_velocity);
        }
        drive += current * (wanted - drive);

        let middle = cap_angle + 0.5 * STEP_S * cap_velocity;
        let (after, torque) = if matches!(link, Link::Rigid) {
            let (inertia, slope) = slider.inertia(knob.inertia, middle);
            let gyration = 0.5 * slope * cap_velocity * cap_velocity;
            let step = slider.step(rig.rotor_inertia + inertia, drive - gyration, middle, cap_velocity, time_s);
            let inertial = inertia * (step.velocity - cap_velocity) / STEP_S + gyration;
            slider.load_mnm += STEP_S / LOAD_LAG_S * (inertial + step.place - slider.load_mnm);
            (step.velocity, inertial + step.friction + step.place)
        } else {
            let inner_middle = angle + 0.5 * STEP_S * velocity;
            let torque = link.torque(middle - inner_middle, cap_velocity - velocity);
            let step = slider.step(inner_inertia, torque, inner_middle, velocity, time_s);
            angle = inner_middle + 0.5 * STEP_S * step.velocity;
            slider.load_mnm += STEP_S / LOAD_LAG_S * (torque - step.friction - slider.load_mnm);
            velocity = step.velocity;
            let after = cap_velocity + STEP_S * (drive - torque) / bare;
            (after, cap_inertia * (after - cap_velocity) / STEP_S + torque)
        };
        if index >= SETTLING_STEPS {
            course.acceleration_rad_s2.push((after - cap_velocity) / STEP_S);
            course.torque_mnm.push(torque);
        }
        cap_angle = middle + 0.5 * STEP_S * after;
        cap_velocity = after;
    }
    course.angle_rad.push(cap_angle);
    course.velocity_rad_s.push(cap_velocity);
    course
}
