//! Kernels: generic steps compiled for instruction sets. A group of bodies advances side by side, in blocks of equal
//! steps or in adaptive steps.

mod adaptive;
mod alone;
mod assignment;
mod compiled;
mod drive;
mod group;
mod load;
mod registry;
mod state;
mod step;

pub use adaptive::AdaptiveSteps;
pub use assignment::KernelAssignment;
pub use compiled::Compiled;
pub use drive::{Job, drive};
pub use group::{DeviationRows, DriftRows, ForcesRows, Group, MAX_STATE};
pub use load::{Entry, load, reset_time, scale_of};
pub use registry::{Kernel, Needs, System, Traits};
pub use state::{Balance, State, read, unload};
