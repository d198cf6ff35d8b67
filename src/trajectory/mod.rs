//! States of bodies at the times that a user wants, by steps or in closed form.

mod adaptive;
mod closed;
mod damped_free;
mod fixed;
mod request;
mod states;

pub use request::{Record, Request, Schedule, time_range};
use states::StatesPart;
pub use states::{Column, States};

use crate::error::Error;
use crate::exact::{CanonicalForm, Question};
use crate::kernel::{Group, KernelAssignment, Needs, System};
use crate::memory;
use crate::parallel::{over_blocks, thread_nanoseconds};
use crate::scheme::Scheme;
use crate::simd::Isa;
use crate::solver::Solver;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Runs the request.
///
/// # Errors
/// If the states do not fit into memory, or the request was stopped; if a closed form is wanted and a body has none; if the method does not move tops or forced bodies; if a step is
/// beyond the stability of the method, or a wanted time beyond the table of a torque; if a tolerance is given to a
/// method that is no series.
pub fn simulate(request: &Request, threads: usize, isa: Isa, stop: &AtomicBool) -> Result<States, Error> {
    match request.solver {
        Solver::Steps(scheme) => {
            scheme.check(request.scene, false)?;
            if !request.forcing.is_none() {
                check_forced(request, scheme)?;
            }
            match request.tolerance {
                Some(_) => adaptive::simulate(request, scheme, threads, isa, stop),
                None => fixed::simulate(request, scheme, threads, isa, stop),
            }
        }
        Solver::Exact => {
            if !request.forcing.is_none() {
                return damped_free::simulate(request, threads, isa, stop);
            }
            let form = |(index, body)| {
                CanonicalForm::of(body).ok_or(Error::NoClosedForm { index, rule: Question::RULE_OF_STATES })
            };
            let mut forms = memory::reserved("closed forms of the bodies", request.bodies.len())?;
            for body in request.bodies.iter().enumerate() {
                forms.push(form(body)?);
            }
            let Schedule::Times(times) = request.schedule else {
                let value = Solver::EXACT.to_string();
                return Err(Error::Value { argument: "method", value, rule: "a closed form takes no steps" });
            };
            closed::simulate(request, times, &forms, threads, isa, stop)
        }
    }
}

/// Refuses a method that does not move forced bodies, a step beyond the stability of an explicit method, and a time at
/// which the torque is unknown.
fn check_forced(request: &Request, scheme: &Scheme) -> Result<(), Error> {
    let forcing = request.forcing;
    let limit = scheme.damping_limit().ok_or_else(|| Error::Value {
        argument: "method",
        value: format!("'{}'", scheme.facts.name),
        rule: "moves bodies without torque and damping only",
    })?;
    if let Schedule::Times(times) = request.schedule {
        for &time in [Some(&0.0), times.first(), times.last()].into_iter().flatten() {
            forcing.check_reaches(time)?;
        }
    }
    if request.tolerance.is_some() || limit == f64::INFINITY {
        return Ok(());
    }
    let mut last = None;
    for (body, &step) in request.bodies.iter().zip(request.steps) {
        // Neighbours mostly are alike.
        if last == Some((body.moments, step)) {
            continue;
        }
        last = Some((body.moments, step));
        let [.., rate] = forcing.damping_rates(body.moments);
        // A step is cut to the span.
        let span = match request.schedule {
            Schedule::Times(times) => time_range(times).iter().fold(0.0_f64, |a, t| a.max(t.abs())),
            Schedule::Strides(_) => f64::INFINITY,
        };
        let step = step.min(span);
        if step * rate > limit {
            let (name, longest) = (scheme.facts.name, limit / rate);
            return Err(Error::Unstable { step, rate, name, longest });
        }
    }
    Ok(())
}

/// Neighbours that are alike, in groups of at most `most`.
fn groups<T>(items: &[T], most: usize, alike: impl Fn(&T, &T) -> bool) -> Result<Vec<Range<usize>>, Error> {
    let mut groups = Vec::new();
    let mut first = 0;
    for run in items.chunk_by(alike) {
        let end = first + run.len();
        for begin in (first..end).step_by(most) {
            memory::push("groups of the bodies", &mut groups, begin..end.min(begin + most))?;
        }
        first = end;
    }
    Ok(groups)
}

/// The states of all groups. `work` writes those of one group and returns the steps of its lanes.
fn over_groups(
    request: &Request,
    groups: &[Range<usize>],
    threads: usize,
    stop: &AtomicBool,
    work: impl Fn(Range<usize>, StatesPart) -> Result<u64, Error> + Sync,
) -> Result<States, Error> {
    let mut states = States::unknown(request)?;
    let [nanoseconds, lane_steps] = [const { AtomicU64::new(0) }; 2];
    let parts = states.parts(request.schedule.len(), groups.iter().map(ExactSizeIterator::len));
    over_blocks(groups.iter().cloned().zip(parts), threads, stop, |(group, part)| {
        let begin = thread_nanoseconds();
        lane_steps.fetch_add(work(group, part)?, Ordering::Relaxed);
        nanoseconds.fetch_add(thread_nanoseconds() - begin, Ordering::Relaxed);
        Ok(())
    })?;
    (states.nanoseconds, states.lane_steps) = (nanoseconds.into_inner(), lane_steps.into_inner());
    Ok(states)
}

/// The system that carries what is recorded and no more.
fn system_of(request: &Request, assignment: KernelAssignment) -> System {
    let directions = if request.record == Record::Axis { 1 } else { 0 };
    let needs = Needs {
        is_forced: !request.forcing.is_none(),
        is_reduced: assignment.is_reduced(),
        directions: if request.forcing.acts_in_space() { 3 } else { directions },
        attitude: request.record == Record::Attitude,
    };
    System::carrying(request.scene, assignment.step, needs)
}

/// Start and inverse scale of energy and conserved momentum of the body in a lane.
fn invariants_at_start(group: &Group, lane: usize) -> [[f64; 2]; 2] {
    [&group.energy, &group.momentum].map(|rows| [rows.start.0[lane], rows.inverse_scale.0[lane]])
}
