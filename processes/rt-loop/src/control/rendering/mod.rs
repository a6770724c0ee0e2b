//! Rendering: the motor and its control loop feel like a knob that is only a model.
//!
//! ```text
//!                 torque sensor                    encoder
//!  hand ══ gripper ══════╪══════ rotor ─────────────┤
//!                        │ slow part     spring and damper (coupling)
//!                        ▼                          │
//!                   virtual knob: the model's inertia, friction, stick and detents
//!                   [ cap ══ gap, contact, shaft ══ inner body with friction, stick and detents ]
//! ```
//!
//! A virtual body has all that the model has and moves by the model's own equation. It is held to the rotor by a virtual
//! coupling, the servo's spring and damper (J. E. Colgate, M. C. Stanley and J. M. Brown, *Issues in the haptic display of
//! tool use*, IROS 1995): whatever the model is, the motor sees no more than that coupling, and a body that is integrated
//! passively behind it cannot shake it. A coupling alone would give way by torque over stiffness, 21 mrad under the static
//! friction of a stiff knob. So the slow part of what the torque sensor measures is taken from the hand to the body
//! directly, and the motor carries it: then the coupling only carries what is fast, and a knob that sticks stands still.
//! The coupling's remaining deflection is known; its slow part is added to the angle at which springs and detents act, so that they are felt
//! where the rotor is. At the body's angle their torques would come late, which acts as a negative damping that grows with their stiffness.
//!
//! - [`RenderedModel`]: a model checked to be one that can be rendered.
//! - [`Renderer`]: the step.
//! - `virtual_knob`: one body, or a cap with an inner body behind a `joint`, the gap or the shaft of the model, both in one
//!   implicit step; `virtual_body`: Karnopp's friction that comes to rest exactly; `cross_fade`: from one model to the next;
//!   `passivity`: the guard that sees to it that the coupling gives out no energy.

mod cross_fade;
mod gains;
mod joint;
mod passivity;
mod rendered_model;
mod renderer;
mod slow_part;
mod virtual_body;
mod virtual_knob;

pub use gains::RenderGains;
pub(crate) use rendered_model::cap_inertia;
pub use rendered_model::{RenderedModel, Unrenderable};
pub use renderer::{Rendered, Renderer, StepInput};
pub(crate) use slow_part::{slow_part, taken_in};
