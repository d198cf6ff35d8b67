//! States of bodies at the times that a user wants, by steps or in closed form.

mod adaptive;
mod closed;
mod damped_free;
mod fixed;
mod request;
mod states;

pub use request::{Record, Request, Schedule, time_range};
pub use states::{Column, States};

use crate::error::Error;
use crate::exact::{CanonicalForm, Question};
use crate::kernel::{Group, KernelAssignment, Needs, System};
use crate::scheme::Scheme;
use crate::simd::Isa;
use crate::solver::Solver;
use std::sync::atomic::AtomicBool;

/// Runs the request; `None` if it was stopped.
///
/// # Errors
/// If a closed form is wanted and a body has none; if the method does not move tops or forced bodies; if a step is
/// beyond the stability of the method, or a wanted time beyond the table of a torque; if a tolerance is given to a
/// method that is no series.
pub fn simulate(
    request: &Request,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<Option<States>, Error> {
    match request.solver {
        Solver::Steps(scheme) => {
            scheme.check(request.scene, false)?;
            if !request.forcing.is_none() {
                check_forced(request, scheme)?;
            }
            match request.tolerance {
                Some(_) => adaptive::simulate(request, scheme, threads, isa, stop),
                None => Ok(fixed::simulate(request, scheme, threads, isa, stop)),
            }
        }
        Solver::Exact => {
            if !request.forcing.is_none() {
                return damped_free::simulate(request, threads, isa, stop);
            }
            let form = |(index, body)| {
                CanonicalForm::of(body).ok_or(Error::NoClosedForm { index, rule: Question::RULE_OF_STATES })
            };
            let forms: Result<Vec<CanonicalForm>, Error> =
                request.bodies.iter().enumerate().map(form).collect();
            let Schedule::Times(times) = request.schedule else {
                let value = Solver::EXACT.to_string();
                return Err(Error::Value { argument: "method", value, rule: "a closed form takes no steps" });
            };
            Ok(closed::simulate(request, times, &forms?, threads, isa, stop))
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
