//! Fits, checks, calibrations and diagnoses of captures whose truth is known.
//!
//! One program, so that its tests share what is compiled and both cores.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "figures that are not asserted are printed")]

mod common;

mod averages;
mod calibration;
mod checks;
mod cogging_calibration;
mod cogging_map;
mod diagnosis;
mod encoder_zero;
mod faulty_sensors;
mod few_periods;
mod filters_match_scipy;
mod foreign_loggers;
mod hidden;
mod hum_above_the_band;
mod invariance;
mod made_over;
mod measured_axis;
mod noisy_acceleration;
mod omitted_effects;
mod one_by_one;
mod paper_table_2;
mod row_order;
mod same_in_any_axes;
mod simulated_rig;
mod what_cannot_be_told;
