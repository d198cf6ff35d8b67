//! The request of a trajectory: bodies, record and times.

use crate::body::Body;
use crate::error::Error;
use crate::forces::ForceSet;
use crate::forces::{BodyForces, Forces, ForcesInterval, ParameterChange};
use crate::memory;
use crate::method::{AnyMethod, Method, default_step};
use crate::scene::Scene;
use std::ops::Range;

/// The variables that are integrated and recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record<'a> {
    /// Rates (for a top also the vertical).
    Rates,
    /// Rates and the vertical in body components.
    Axis,
    /// Rates and attitude.
    Attitude,
    /// The deviation vector of each body that begins with these numbers: a change of the rates and a rotation vector.
    Tangent(&'a [[f64; 6]]),
    /// The deviation vector of each body by this change of its parameters, from the same start.
    Sensitivity(&'a [ParameterChange<f64>]),
}

impl Record<'_> {
    /// Whether deviation vectors are recorded.
    pub fn is_tangent(&self) -> bool {
        matches!(self, Record::Tangent(_) | Record::Sensitivity(_))
    }

    /// Whether parameters change.
    pub fn is_sensitivity(&self) -> bool {
        matches!(self, Record::Sensitivity(_))
    }

    /// The change of the parameters of a body.
    pub fn change_of(&self, body: usize) -> ParameterChange<f64> {
        match self {
            Record::Sensitivity(changes) => changes[body],
            _ => ParameterChange::filled(0.0),
        }
    }

    /// The deviation vector of a body at its start; zero if none is recorded.
    pub fn deviation_of(&self, body: usize) -> [f64; 6] {
        match self {
            Record::Tangent(deviations) => deviations[body],
            _ => [0.0; 6],
        }
    }
}

/// The times of the requested states.
#[derive(Clone, Copy)]
pub enum Schedule<'a> {
    /// At these times, ascending; the start is at time 0.
    Times(&'a [f64]),
    /// At times of each body's own, row after row, this many a body, ascending in each row.
    TimesOfEach(&'a [f64], usize),
    /// After these numbers of further steps of exactly the body's own step, the first perhaps 0.
    Strides(&'a [u64]),
}

impl<'a> Schedule<'a> {
    /// The times of a body; `None` if its steps are counted.
    pub fn times_of(&self, body: usize) -> Option<&'a [f64]> {
        match self {
            Schedule::Times(times) => Some(times),
            Schedule::TimesOfEach(times, count) => Some(&times[body * count..][..*count]),
            Schedule::Strides(_) => None,
        }
    }

    /// The times of neighbouring bodies.
    pub fn of_range(self, bodies: Range<usize>) -> Self {
        match self {
            Schedule::TimesOfEach(times, count) => {
                Schedule::TimesOfEach(&times[bodies.start * count..bodies.end * count], count)
            }
            shared => shared,
        }
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        match self {
            Schedule::Times(times) => times.len(),
            Schedule::TimesOfEach(_, count) => *count,
            Schedule::Strides(strides) => strides.len(),
        }
    }

    /// Whether no state is requested.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The request.
pub struct Request<'a> {
    /// The bodies with their starts.
    pub bodies: &'a [Body],
    /// What moves them.
    pub scene: &'static Scene,
    /// Applied torque and damping.
    pub forces: &'a Forces,
    /// The method of the bodies.
    pub method: AnyMethod,
    /// The recorded variables.
    pub record: Record<'a>,
    /// The times of the states.
    pub schedule: Schedule<'a>,
    /// Largest step of each body; with a tolerance its first.
    pub steps: &'a [f64],
    /// A leg between two output times takes this many times its steps, rounded up: above 1 at least one more. Of steps
    /// that follow a tolerance the longest under a function is so many times shorter.
    pub refinement: f64,
    /// Tolerance of adaptive steps of a Taylor series: the largest last terms of a step, relative to the state.
    pub tolerance: Option<f64>,
    /// Largest number of steps of a body.
    pub max_steps: u64,
}

impl Request<'_> {
    /// The forces on a body.
    pub fn forces_of(&self, body: usize) -> BodyForces<'_> {
        self.forces.of(body)
    }

    /// Whether a body on an orbit may take its anomaly for the time: not where steps in the time are asked for, nor with
    /// deviation vectors.
    pub(super) fn can_follow_an_anomaly(&self) -> bool {
        let has_times = !matches!(self.schedule, Schedule::Strides(_));
        has_times && self.tolerance.is_none() && !self.record.is_tangent()
    }

    /// Refuses deviation vectors under forces for which there are no kernels.
    ///
    /// # Errors
    /// If a further force or the torque of a function acts on a body.
    pub fn check_deviations(&self) -> Result<(), Error> {
        (0..self.forces.bodies()).try_for_each(|body| ForceSet::from(self.forces_of(body)).check_deviations())
    }

    /// The forces on a body from a time to the next knot, and the change of its parameters.
    pub fn interval_of(&self, body: usize, time: f64, backward: bool) -> ForcesInterval<'static, f64> {
        let forces = self.forces_of(body);
        let interval = forces.interval(time, backward, forces.damping.modes(self.bodies[body].moments));
        let mut change = self.record.change_of(body);
        change.further.orbit.begin_at(time);
        ForcesInterval { change, ..interval }
    }

    /// Whether the request takes less than some 100 microseconds, about as long as to start a thread.
    pub(super) fn is_light(&self) -> bool {
        // Steps and states of many bodies cost tens of nanoseconds each.
        const FEW: f64 = 2000.0;
        let (bodies, states) = (self.bodies.len() as f64, self.schedule.len() as f64);
        let steps = |(index, step): (usize, &f64)| {
            let [first, last] = self.range_of(index);
            (last - first) / step
        };
        let made = match (self.method, &self.schedule) {
            _ if bodies * states > FEW => return false,
            (AnyMethod::Auto | AnyMethod::Exact, _) => 0.0,
            (AnyMethod::Steps(_), Schedule::Strides(strides)) => bodies * strides.iter().sum::<u64>() as f64,
            (AnyMethod::Steps(_), _) => {
                self.refinement * self.steps.iter().enumerate().map(steps).sum::<f64>()
            }
        };
        // A step of zero, whose number is not a number, is not light.
        made + bodies * states <= FEW
    }

    /// Whether the request is in closed form and light: of steps one may cost a hundred others.
    pub fn is_brief(&self) -> bool {
        matches!(self.method, AnyMethod::Exact) && self.is_light()
    }

    /// The time range of the motion of a body.
    pub fn range_of(&self, body: usize) -> [f64; 2] {
        self.schedule.times_of(body).map_or([0.0, f64::INFINITY], time_range)
    }
}

/// The longest steps that a method takes by default; infinite at rest.
///
/// # Errors
/// If they do not fit into memory.
pub fn default_steps(
    method: &Method,
    bodies: &[Body],
    forces: &Forces,
    schedule: &Schedule,
) -> Result<Vec<f64>, Error> {
    let step = |(index, body): (usize, &Body)| {
        let span = schedule.times_of(index).map_or([0.0; 2], time_range);
        let forces = forces.of(index);
        default_step(method, body.step_rate(method, forces, span)).min(forces.longest_unseen(span))
    };
    memory::collected("steps", bodies.len(), bodies.iter().enumerate().map(step))
}

/// The time range of a motion that starts at 0: the first and the last of ascending times and 0.
pub fn time_range(times: &[f64]) -> [f64; 2] {
    let end = |time: Option<&f64>| time.copied().unwrap_or(0.0);
    [end(times.first()).min(0.0), end(times.last()).max(0.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_range_includes_the_start() {
        assert_eq!(time_range(&[]), [0.0, 0.0]);
        assert_eq!(time_range(&[1.0, 2.0]), [0.0, 2.0]);
        assert_eq!(time_range(&[-2.0, -1.0]), [-2.0, 0.0]);
        assert_eq!(time_range(&[-1.0, 3.0]), [-1.0, 3.0]);
    }
}
