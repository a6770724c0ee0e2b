//! The view of the instrument: what is measured, what is fitted and how the processes fare.
//!
//! The viewer is last in line. It reads the sample stream, the fitter's updates and the health
//! reports from shared memory, reduces them to what a screen can show and hands them to
//! [rerun](https://rerun.io). It publishes its own health and nothing else.
//!
//! ```text
//! rig ──► source ──► picture ──► outbox ──► screen ──► web page | window | file
//!         20 ms      250 ms      drops      a thread of its own,
//!         polls      frames      oldest     may stall as it likes
//! ```
//!
//! [`drawn`] keeps what was drawn for pages, and [`page`] serves it. Its [server](page::server) refuses other users and
//! drops connections that take nothing. `docs/live-view.md` says what is to be seen.
//!
//! - **When it stalls or dies** nobody notices: shared memory drops its oldest blocks, the
//!   control loop never waits. A viewer started again receives the last seconds first, at the port that
//!   it had ([`port`]), and the page goes on with it.
//! - **When rerun stalls** the outbox drops the oldest frames and counts them; polling goes on.
//! - **When the run ends** the page stays up until SIGTERM, so that one can look; a file is closed.
//! - **SIGINT** is the supervisor's business and ignored, unless the operator has the viewer itself
//!   in the foreground; SIGTERM and the parent's death end it.
//!
//! A finished capture is another source for the same picture. It is shown whole: a file waits while
//! the outbox is full, so no frame is dropped, and the model is the one that the whole capture gives.
//!
//! A diagnosis becomes a file at once, without source or screen: [`diagnosis`].

pub mod capture_source;
pub mod capture_summary;
pub mod cli;
pub mod decimation;
pub mod diagnosis;
pub mod drawing;
pub mod drawn;
pub mod entities;
pub mod extent;
pub mod frame;
pub mod glance;
pub mod knob_drawing;
pub mod knob_track;
pub mod layout;
pub mod layout_properties;
pub mod model_curves;
pub mod model_torque;
pub mod numbers;
pub mod outbox;
pub mod page;
pub mod palette;
pub mod peer;
pub mod picture;
pub mod plot_axes;
pub mod plot_drawing;
pub mod port;
pub mod processes;
pub mod recording_file;
pub mod remote;
pub mod rendered;
pub mod rig_source;
pub mod run;
pub mod scatter;
pub mod screen;
pub mod series_styles;
pub mod signals;
pub mod slider_drawing;
pub mod source;
pub mod strokes;
pub mod summary;
#[cfg(test)]
mod wedged_page;
