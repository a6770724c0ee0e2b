//! A knob under a given torque, by small fixed steps and with nothing of the crate under test.
//!
//! Position Verlet with the forces of the middle of the step; Coulomb friction either lets the body slide through the
//! step or holds it (Moreau 1988).

/// A knob of one body or two. Units mNm, rad, s.
#[derive(Clone, Copy)]
pub struct Knob {
    pub inertia: f64,
    pub coulomb_mnm: f64,
    pub viscous: f64,
    /// Torque borne at rest and speed below which the body comes to rest.
    pub stick: Option<(f64, f64)>,
    /// Further torque at (angle, velocity).
    pub place: fn(f64, f64) -> f64,
    /// Coulomb friction over its usual value at (angle, velocity, time).
    pub coulomb_factor: fn(f64, f64, f64) -> f64,
    /// Viscous friction over its usual value at a time.
    pub viscous_factor: fn(f64) -> f64,
    /// Angle and damping of bristles.
    pub bristles: Option<(f64, f64)>,
    pub link: Link,
}

/// What lies between the torque and the body that friction acts on.
#[derive(Clone, Copy)]
pub enum Link {
    Rigid,
    /// A cap with inertia: half gap (or zero for a shaft), inertia of the cap, stiffness, damping.
    Cap(f64, f64, f64, f64),
    /// A shaft turned at an end without inertia: stiffness, damping.
    Shaft(f64, f64),
}

impl Default for Knob {
    fn default() -> Self {
        Self {
            inertia: 0.05,
            coulomb_mnm: 4.0,
            viscous: 0.6,
            stick: None,
            place: |_, _| 0.0,
            coulomb_factor: |_, _, _| 1.0,
            viscous_factor: |_| 1.0,
            bristles: None,
            link: Link::Rigid,
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Body {
    angle: f64,
    velocity: f64,
}

/// Angle and velocity of what the torque acts on at every sample, from rest at zero, the torque going in straight lines
/// from sample to sample, each in `substeps` steps.
pub fn run(knob: &Knob, sample_s: f64, torque_mnm: &[f64], substeps: usize) -> Vec<(f64, f64)> {
    let step_s = sample_s / substeps as f64;
    let (mut body, mut cap, mut deflection, mut twist) = (Body::default(), Body::default(), 0.0, 0.0);
    let mut course = vec![(0.0, 0.0)];
    for (index, pair) in torque_mnm.windows(2).enumerate() {
        for substep in 0..substeps {
            let share = (substep as f64 + 0.5) / substeps as f64;
            let torque = pair[0] + share * (pair[1] - pair[0]);
            let time_s = (index as f64 + share) * sample_s;
            match knob.link {
                Link::Rigid => body = step(knob, knob.inertia, &body, &mut deflection, step_s, time_s, |_, _| torque),
                Link::Shaft(stiffness, damping) => {
                    body = step(knob, knob.inertia, &body, &mut deflection, step_s, time_s, |_, _| torque);
                    // Crank–Nicolson for D·ẋ = τ − K·x.
                    let half = 0.5 * step_s * stiffness;
                    twist = ((damping - half) * twist + step_s * torque) / (damping + half);
                }
                Link::Cap(half_gap, inertia, stiffness, damping) => {
                    let contact = |ahead: f64, faster: f64| {
                        let beyond = if ahead > half_gap {
                            ahead - half_gap
                        } else if ahead < -half_gap {
                            ahead + half_gap
                        } else {
                            return 0.0;
                        };
                        let torque = stiffness * beyond + damping * faster;
                        if torque * beyond > 0.0 || half_gap == 0.0 { torque } else { 0.0 }
                    };
                    let middle = cap.angle + 0.5 * step_s * cap.velocity;
                    let start = (cap.velocity, body);
                    let mut velocity = cap.velocity;
                    let bent = deflection;
                    for _ in 0..3 {
                        deflection = bent;
                        let mean = 0.5 * (velocity + start.0);
                        let drive = |angle: f64, speed: f64| contact(middle - angle, mean - speed);
                        body = step(knob, knob.inertia - inertia, &start.1, &mut deflection, step_s, time_s, drive);
                        let inner = start.1.angle + 0.5 * step_s * start.1.velocity;
                        let passed = contact(middle - inner, mean - 0.5 * (start.1.velocity + body.velocity));
                        velocity = start.0 + step_s * (torque - passed) / inertia;
                    }
                    cap = Body { angle: middle + 0.5 * step_s * velocity, velocity };
                }
            }
        }
        course.push(match knob.link {
            Link::Rigid => (body.angle, body.velocity),
            Link::Cap(..) => (cap.angle, cap.velocity),
            Link::Shaft(stiffness, damping) => {
                (body.angle + twist, body.velocity + (pair[1] - stiffness * twist) / damping)
            }
        });
    }
    course
}

fn step(
    knob: &Knob,
    inertia: f64,
    from: &Body,
    deflection: &mut f64,
    step_s: f64,
    time_s: f64,
    drive: impl Fn(f64, f64) -> f64,
) -> Body {
    let Body { angle, velocity } = *from;
    let middle = angle + 0.5 * step_s * velocity;
    let bent = *deflection;
    let mut after = velocity;
    // The forces at the mean velocity, found by repetition.
    for _ in 0..3 {
        let mean = 0.5 * (velocity + after);
        let load = drive(middle, mean) - (knob.place)(middle, mean);
        let coulomb = knob.coulomb_mnm * (knob.coulomb_factor)(middle, mean, time_s);
        let viscous = knob.viscous * (knob.viscous_factor)(time_s) * mean;
        if let Some((length, damping)) = knob.bristles {
            let slope = |deflection: f64| (mean - mean.abs() * deflection) / length;
            let half = bent + 0.5 * step_s * slope(bent);
            *deflection = bent + step_s * slope(half);
            after = velocity + step_s / inertia * (load - coulomb * half - damping * length * slope(half) - viscous);
            continue;
        }
        let (held, stick_velocity) = knob.stick.map_or((coulomb, 0.0), |(held, speed)| (held.max(coulomb), speed));
        let side = if velocity == 0.0 { load.signum() } else { velocity.signum() };
        after = velocity + step_s / inertia * (load - side * coulomb - viscous);
        let slows_to_rest = velocity.abs() > stick_velocity && after.abs() <= stick_velocity && load.abs() <= held;
        if (velocity == 0.0 && load.abs() <= held) || after * side <= 0.0 || slows_to_rest {
            after = 0.0;
        }
    }
    Body { angle: middle + 0.5 * step_s * after, velocity: after }
}
