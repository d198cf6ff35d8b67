//! States of bodies at output times, by steps or in closed form; growth of deviation vectors; and bodies that
//! are moved step by step.

mod adaptive;
mod adaptive_lanes;
mod closed;
mod damped_free;
mod fixed;
mod frame;
mod growth;
mod legs;
mod motion;
mod request;
mod section;
mod states;

pub use closed::{ROUNDING, rounding_errors};
pub use frame::{Frame, MAX_DEVIATIONS};
pub use growth::{Deviations, Growths, STEPS_TOGETHER, growth, renormalise};
pub use motion::{Motion, NUMBERS, Torques};
pub use request::{Record, Request, Schedule, default_steps, time_range};
pub use section::{
    Crossings, MOST_KINDS, Point, Pointing, Section, Surface, SurfaceKind, look_again, section,
};
pub use states::{Column, States, StatesPart};

use crate::body::Body;
use crate::call::Call;
use crate::error::{Error, refuse};
use crate::forces::{BodyForces, ForceSet};
use crate::kernel::{Group, Kernel, KernelAssignment, Needs, System};
use crate::memory;
use crate::method::{AnyMethod, Method, Step};
use crate::observe::Observed;
use crate::parallel::{caught, over_blocks};
use crate::simd::LANES;
use std::ops::Range;
use std::time::Instant;

/// The states of a request.
///
/// # Errors
/// If the states do not fit into memory, and as `simulate_into`.
pub fn simulate(request: &Request, call: Call) -> Result<States, Error> {
    let mut states = States::reserved(request, request.bodies.len(), &[])?;
    simulate_into(request, states.whole(), call)?;
    Ok(states)
}

/// Writes the states of a request. Returns the processor time of all threads, ns; of a request that takes no longer than to
/// start one, the time that passed.
///
/// # Errors
/// If the request was stopped; if a closed form is wanted and a body has none; if the method does not move tops or
/// forced bodies; if a step is beyond the stability of the method, or an output time beyond the table of a torque; if a
/// tolerance is given to a method that is no series.
pub fn simulate_into(request: &Request, states: StatesPart, call: Call) -> Result<u64, Error> {
    match request.method {
        AnyMethod::Steps(method) => {
            method.check(request.scene)?;
            if request.record.is_tangent() {
                method.check_tangent(request.record.is_sensitivity() || !request.forces.is_none())?;
                request.check_deviations()?;
            }
            if !request.forces.is_none() {
                check_forced(request, method)?;
            }
            match request.tolerance {
                Some(_) => adaptive::simulate(request, method, states, call),
                None => fixed::simulate(request, method, states, call),
            }
        }
        AnyMethod::Auto => {
            refuse("method", format_args!("'{}'", AnyMethod::AUTO), "is chosen for the samples of maps only")
        }
        AnyMethod::Exact => {
            if request.record.is_tangent() {
                let rule = "has no tangent here: deviation vectors are integrated";
                return refuse("method", format_args!("'{}'", AnyMethod::EXACT), rule);
            }
            if !request.forces.is_none() {
                return damped_free::simulate(request, states, call);
            }
            if let Schedule::Strides(_) = request.schedule {
                return refuse("method", AnyMethod::EXACT, "a closed form takes no steps");
            }
            closed::simulate(request, states, call)
        }
    }
}

/// Refuses a method that does not move forced bodies, a step beyond the stability of an explicit method, damping at a rate
/// beyond the doubles, and a time at which the torque is unknown.
fn check_forced(request: &Request, method: &Method) -> Result<(), Error> {
    for index in 0..request.bodies.len() {
        method.check_forces(request.forces_of(index).into())?;
    }
    let mut last = None;
    for (index, (body, &step)) in request.bodies.iter().zip(request.steps).enumerate() {
        let forces = request.forces_of(index);
        let times = request.schedule.times_of(index).unwrap_or_default();
        for &time in [Some(&0.0), times.first(), times.last()].into_iter().flatten() {
            forces.table.check_reaches(time)?;
        }
        // Neighbours mostly are alike.
        let next = Some((body.moments, forces, step));
        if last == next {
            continue;
        }
        last = next;
        let name = (request.bodies.len() > 1).then_some(index);
        // A tolerance finds steps that are short enough.
        let step = if request.tolerance.is_some() { 0.0 } else { step };
        check_step(method, name, body, forces, step, request.range_of(index))?;
    }
    Ok(())
}

/// Refuses damping at a rate beyond the doubles, and a step that is unstable at its rate. The body is named if it is one
/// among many.
///
/// # Errors
/// Naming the damping or the step; or if the method does not move forced bodies.
pub fn check_step(
    method: &Method,
    name: Option<usize>,
    body: &Body,
    forces: BodyForces,
    step: f64,
    range: [f64; 2],
) -> Result<(), Error> {
    forces.damping.check_rates(body.moments)?;
    let [.., rate] = forces.damping.rates(body.moments);
    // A step is cut to the span.
    let step = step.min(range.iter().fold(0.0_f64, |a, t| a.max(t.abs())));
    method.check_damping(name, step, rate)
}

/// Most bodies of a block of neighbours that are not alike.
const MIXED: usize = 16 * LANES;

/// Bodies 0 .. `n` in blocks of neighbours: of those of one kind, at most a group each. Where few neighbours are of one
/// kind the blocks are larger, as far as every thread has two, and `kinds_in` finds the groups.
fn blocks<K: PartialEq>(
    n: usize,
    threads: usize,
    kind: impl Fn(usize) -> K,
) -> Result<Vec<Range<usize>>, Error> {
    let groups = neighbours(n, LANES, kind)?;
    if groups.len() <= 2 * n.div_ceil(LANES) {
        return Ok(groups);
    }
    let most = n.div_ceil(2).div_ceil(threads.max(1)).next_multiple_of(LANES).min(MIXED);
    neighbours(n, most, |_| ())
}

/// Neighbours of one kind, at most `most` together.
fn neighbours<K: PartialEq>(
    n: usize,
    most: usize,
    kind: impl Fn(usize) -> K,
) -> Result<Vec<Range<usize>>, Error> {
    let mut groups: Vec<Range<usize>> = Vec::new();
    let mut last = None;
    for index in 0..n {
        let next = Some(kind(index));
        match groups.last_mut() {
            Some(group) if group.len() < most && last == next => group.end += 1,
            _ => memory::push("groups of the bodies", &mut groups, index..index + 1)?,
        }
        last = next;
    }
    Ok(groups)
}

/// The bodies of a block that are of one kind, by their indices in the block.
fn kinds_in<K: PartialEq>(block: Range<usize>, kind: impl Fn(usize) -> K) -> Result<Vec<Vec<usize>>, Error> {
    let mut kinds: Vec<(K, Vec<usize>)> = Vec::new();
    for index in 0..block.len() {
        let own = kind(block.start + index);
        if let Some((_, members)) = kinds.iter_mut().find(|(known, _)| *known == own) {
            memory::push("a group of bodies", members, index)?;
        } else {
            let mut members = memory::reserved("a group of bodies", block.len())?;
            members.push(index);
            memory::push("groups of the bodies", &mut kinds, (own, members))?;
        }
    }
    Ok(kinds.into_iter().map(|(_, members)| members).collect())
}

/// The steps that a body makes between two output times, as if these were equally spaced.
fn steps_of_legs(request: &Request, index: usize) -> u64 {
    let [first, last] = request.range_of(index);
    if last - first < f64::INFINITY {
        ((last - first) / (request.steps[index] * request.schedule.len() as f64)).ceil() as u64
    } else {
        // The schedule gives the steps.
        0
    }
}

/// Does `work` for all blocks: it writes the states of a block. Returns the time, as [`simulate_into`].
fn over_blocks_of(
    request: &Request,
    blocks: &[Range<usize>],
    mut states: StatesPart,
    call: Call,
    work: impl Fn(Range<usize>, StatesPart) -> Result<(), Error> + Sync,
) -> Result<u64, Error> {
    let times = request.schedule.len();
    let parts = blocks.iter().map(|block| (block.clone(), states.split_off(times, block.len())));
    let done = |(block, part)| work(block, part);
    if request.is_brief() {
        // To read the processor clock of a thread takes as long as a state.
        let begin = Instant::now();
        caught(|| parts.into_iter().try_for_each(done))?;
        Ok(begin.elapsed().as_nanos() as u64)
    } else {
        let threads = if request.is_light() { 1 } else { call.threads };
        over_blocks(parts, threads, call.stop, done)
    }
}

/// How a body is integrated: with which step, and by which equations of motion.
#[derive(Clone, Copy)]
struct Integration {
    assignment: KernelAssignment,
    forces: ForceSet,
}

impl Integration {
    fn of(request: &Request, method: &Method, index: usize) -> Self {
        let forces = ForceSet::from(request.forces_of(index));
        let on_orbit = (forces.orbit_alone && request.can_follow_an_anomaly())
            .then(|| KernelAssignment::on_orbit(method))
            .flatten();
        let assignment = on_orbit.unwrap_or_else(|| {
            KernelAssignment::of_either(forces.act, method, &request.bodies[index], request.scene)
        });
        Integration { assignment, forces }
    }

    /// Those of the bodies of a block.
    fn of_block(request: &Request, method: &Method, block: Range<usize>) -> Result<Vec<Self>, Error> {
        let mut integrations = memory::reserved("bodies of a block", block.len())?;
        let mut last: Option<(&Body, Self)> = None;
        let all_free = request.forces.is_none();
        for index in block {
            let is_free = all_free || request.forces_of(index).is_none();
            let body = &request.bodies[index];
            let integration = match last {
                // Neighbours mostly have the same moments and the same weight.
                Some((other, integration))
                    if is_free
                        && !integration.forces.act
                        && (other.moments, other.weight) == (body.moments, body.weight) =>
                {
                    integration
                }
                _ => Integration::of(request, method, index),
            };
            last = Some((body, integration));
            integrations.push(integration);
        }
        Ok(integrations)
    }

    /// What the bodies of a group share.
    #[inline]
    fn kind(&self) -> (Step, ForceSet) {
        (self.assignment.step, self.forces)
    }

    /// The kernel, whose system carries what is recorded and no more.
    fn kernel(&self, request: &Request, observed: Observed) -> Kernel {
        let needs = Needs {
            forces: self.forces,
            directions: usize::from(request.record == Record::Axis),
            attitude: request.record == Record::Attitude,
            tangent: request.record.is_tangent(),
            is_changed: request.record.is_sensitivity(),
        };
        let step = self.assignment.step;
        Kernel { system: System::carrying(request.scene, step, needs), step, observed }
    }
}

/// Start and inverse scale of energy and conserved momentum of the body in a lane.
fn invariants_at_start(group: &Group, lane: usize) -> [[f64; 2]; 2] {
    let (energy, momentum) = (&group.energy, &group.momentum);
    [
        [energy.start.0[lane], energy.inverse_scale.0[lane]],
        [momentum.start.0[lane], momentum.inverse_scale.0[lane]],
    ]
}
