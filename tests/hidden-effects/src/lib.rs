//! A plant that hides an effect in its captures, so that the diagnosis can be tried on what its authors did not write.
//!
//! It shares nothing with the instrument: no crate of it is a dependency. Where the instrument's candidates are
//! columns of a regression or a body driven by the measured angle, this plant is a whole rig in small time steps:
//! a rotor under a position servo, a cap, an inner body behind a contact or a spring ([`plant`]), friction that
//! truly sticks, and sensors with their noise, steps and lag ([`sensors`]). The command's trajectory is
//! [`motion`], the knob that the effect hides in [`knob`], the effects themselves [`effect`].
//!
//! **Strength** is the RMS of what the best base model ([`base_fit`]) leaves unexplained on noise-free training
//! data while the knob slides, over the RMS of the torque noise. [`capture`] scales each effect to the strength
//! asked for by bisection of one of its parameters.
//!
//! Units: rad, s, mNm, mNm s²/rad.

pub mod base_fit;
pub mod capture;
pub mod draw;
pub mod effect;
pub mod family;
pub mod knob;
pub mod motion;
pub mod plant;
pub mod sensors;
