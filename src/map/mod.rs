//! The Monte Carlo map: blocks of samples are drawn, classified and counted.

mod check;
mod classify;
mod criterion;
mod draw;
mod integrate;
mod interval;
mod joined;
mod measure;
mod observation;
mod regular;
mod request;
mod run;
mod sketch;
mod statistics;
mod steps;

pub use check::Check;
pub use criterion::{Criterion, NAMED};
pub use draw::{Distributions, Mixed, OF_START};
pub use interval::{clopper_pearson, clopper_pearson_of_each};
pub use joined::{Condition, Logic, MOST_CONDITIONS};
pub use measure::{Measure, Quantity, Value};
pub use regular::{DEVIATIONS, PARTS, Rule, SECOND as SECOND_OF_GROWTH, deviation_start};
pub use request::{Map, Pixel};
pub use sketch::{Bin, Sketch};
pub use statistics::{Class, Column, FIXED_POINT, Field, Outcome, Statistics, Verdict};
pub use steps::PlannedRun;

use observation::{Observation, OnOrbit};

/// A sample takes whole blocks of this many steps and may stop after each. What is observed at the ends of blocks then
/// depends on the sample alone, whoever shares its group.
pub const STEP_BLOCK: u64 = 16;

/// The class of a condition of a sample, and the time at which its first run left it.
pub type ConditionVerdict = (Class, f64);
