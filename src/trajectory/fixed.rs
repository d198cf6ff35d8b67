//! States by steps of a scheme.

use super::{Request, Schedule, States, invariants_at_start, system_of, time_range};
use crate::kernel::{Compiled, ForcingRows, Group, Kernel};
use crate::kernel::{Entry, KernelAssignment, load, start_clock, unload};
use crate::observe::Observed;
use crate::parallel::over_blocks;
use crate::scheme::Scheme;
use crate::simd::{Isa, LANES};
use crate::start::Body;
use crate::status::Status;
use std::ops::Range;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest number of steps between two checks of the stop flag: a tenth of a second
/// of the most expensive steps on the slowest path.
const STEPS_BETWEEN_STOPS: usize = 1 << 9;

/// Steps of equal size to the next requested state or knot of the forcing.
#[derive(Clone, Copy)]
struct Leg {
    steps: u64,
    step: f64,
}

/// A leg, the time at its begin, and the requested state at its end if there is one.
#[derive(Clone, Copy)]
struct Stop {
    from: f64,
    leg: Leg,
    state: Option<usize>,
}

/// The legs of one body in the order they are made: forward from 0 through the times >= 0, and backward from 0 through
/// the times < 0.
type Plan = [Vec<Stop>; 2];

/// Steps no longer than `largest` that end exactly at `to`, their number times the refinement.
fn leg(from: f64, to: f64, largest: f64, refinement: f64) -> Leg {
    let span = to - from;
    let wanted = span.abs() / largest;
    // A quotient that differs from a whole number only by rounding does not add a step.
    let nearest = wanted.round();
    let steps = if (wanted - nearest).abs() <= 1e-9 * nearest { nearest } else { wanted.ceil() };
    if span == 0.0 {
        return Leg { steps: 0, step: 0.0 };
    }
    let steps = (steps.max(1.0) * refinement.max(1.0)).ceil();
    Leg { steps: steps as u64, step: span / steps }
}

/// The plan of a body with that largest step. Legs end at the knots of the forcing: a step across a knot would lose
/// the order of any scheme.
fn legs(request: &Request, largest: f64) -> Plan {
    let forcing = request.forcing;
    let leg = |from, to| leg(from, to, largest, request.refinement);
    match &request.schedule {
        Schedule::Times(times) => {
            let split = times.partition_point(|&t| t < 0.0);
            let pass = |indices: &mut dyn Iterator<Item = usize>, backward: bool| {
                let (mut from, mut stops) = (0.0, Vec::new());
                for k in indices {
                    while let Some(knot) = forcing.next_knot(from, backward) {
                        if if backward { knot <= times[k] } else { times[k] <= knot } {
                            break;
                        }
                        stops.push(Stop { from, leg: leg(from, knot), state: None });
                        from = knot;
                    }
                    stops.push(Stop { from, leg: leg(from, times[k]), state: Some(k) });
                    from = times[k];
                }
                stops
            };
            [pass(&mut (split..times.len()), false), pass(&mut (0..split).rev(), true)]
        }
        Schedule::Strides(strides) => {
            let stop = |(k, &steps)| Stop { from: 0.0, leg: Leg { steps, step: largest }, state: Some(k) };
            [strides.iter().enumerate().map(stop).collect(), Vec::new()]
        }
    }
}

/// Runs the request; `None` if it was stopped.
pub fn simulate(
    request: &Request,
    scheme: &Scheme,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Option<States> {
    let groups = groups(request, scheme);
    let parts = over_blocks(groups.len(), threads, stop, |g| {
        States::timed(|| FixedBatch::new(request, scheme, groups[g].clone(), isa).run(stop))
    });
    let mut all = States::with_capacity(request);
    for part in parts {
        all.append(part??);
    }
    Some(all)
}

/// The assignment of a body. Strides repeat the steps of a map, which are made in the frame of the body.
fn assignment_of(request: &Request, scheme: &Scheme, body: &Body) -> KernelAssignment {
    match request.schedule {
        _ if !request.forcing.is_none() => KernelAssignment::of_forced(scheme, body),
        Schedule::Times(_) => KernelAssignment::of_path(scheme, body, request.scene),
        Schedule::Strides(_) => KernelAssignment::of(scheme, body, request.scene),
    }
}

/// Runs of neighbours that one kernel integrates. The bits of a body do not depend on the others of its group.
fn groups(request: &Request, scheme: &Scheme) -> Vec<Range<usize>> {
    let engine = |body: &Body| {
        let assignment = assignment_of(request, scheme, body);
        (assignment.step, assignment.is_reduced())
    };
    let mut groups = Vec::with_capacity(request.bodies.len().div_ceil(LANES));
    let mut first = 0;
    for run in request.bodies.chunk_by(|a, b| engine(a) == engine(b)) {
        let end = first + run.len();
        groups.extend((first..end).step_by(LANES).map(|begin| begin..end.min(begin + LANES)));
        first = end;
    }
    groups
}

/// The bodies of one group.
struct FixedBatch<'a> {
    request: &'a Request<'a>,
    bodies: &'a [Body],
    steps: &'a [f64],
    assignments: Vec<KernelAssignment>,
    compiled: Compiled,
    states: States,
    /// The attitude of each lane at its last recorded state.
    last: Vec<[f64; 4]>,
}

impl<'a> FixedBatch<'a> {
    fn new(request: &'a Request<'a>, scheme: &Scheme, group: Range<usize>, isa: Isa) -> Self {
        let bodies = &request.bodies[group.clone()];
        let assignments: Vec<KernelAssignment> =
            bodies.iter().map(|body| assignment_of(request, scheme, body)).collect();
        let system = system_of(request, assignments[0]);
        let kernel = Kernel { system, step: assignments[0].step, observed: Observed::Nothing };
        FixedBatch {
            request,
            bodies,
            steps: &request.steps[group],
            assignments,
            compiled: Compiled::new(kernel, isa),
            states: States::unknown(request, bodies.len()),
            last: bodies.iter().map(|body| body.attitude).collect(),
        }
    }

    fn run(mut self, stop: &AtomicBool) -> Option<States> {
        let forcing = self.request.forcing;
        // Neighbours mostly have the same step, hence the same plan.
        let mut plans: Vec<Rc<Plan>> = Vec::with_capacity(self.bodies.len());
        for (lane, &step) in self.steps.iter().enumerate() {
            let plan = match plans.last() {
                Some(last) if self.steps[lane - 1] == step => last.clone(),
                _ => Rc::new(legs(self.request, step)),
            };
            plans.push(plan);
        }
        for (lane, plan) in plans.iter().enumerate() {
            let total = plan.iter().flatten().fold(0_u64, |sum, stop| sum.saturating_add(stop.leg.steps));
            if total > self.request.max_steps {
                self.states.status[lane] = Status::StepLimit;
            } else {
                self.states.steps[lane] = total;
                self.states.energy_drift[lane] = 0.0;
                self.states.momentum_drift[lane] = 0.0;
                self.states.unit_drift[lane] = 0.0;
            }
        }
        for pass in (0..2).filter(|&pass| !plans[0][pass].is_empty()) {
            let mut group = Group::waiting();
            for (lane, body) in self.bodies.iter().enumerate() {
                self.last[lane] = body.attitude;
                let rate = match self.request.schedule {
                    Schedule::Times(times) if !forcing.is_none() => {
                        Some(body.fastest_rate(forcing, time_range(times)))
                    }
                    _ => None,
                };
                let entry = Entry::unobserved(body, rate, 0.0);
                load(&mut group, lane, self.compiled, self.assignments[lane], &entry);
            }
            let mut moved = [false; LANES];
            let mut forcing_rows = ForcingRows::NONE;
            for k in 0..plans[0][pass].len() {
                let of_lane: Vec<Leg> = (0..self.bodies.len())
                    .map(|lane| match self.states.status[lane] {
                        Status::StepLimit => Leg { steps: 0, step: 0.0 },
                        _ => plans[lane][pass][k].leg,
                    })
                    .collect();
                // All bodies of the group have equal begins and ends of legs.
                let Stop { from, state, .. } = plans[0][pass][k];
                if !forcing.is_none() {
                    for (lane, body) in self.bodies.iter().enumerate() {
                        forcing_rows.set(lane, &forcing.interval(from, pass == 1, body.moments));
                        start_clock(&mut group, self.compiled.kernel().system, lane);
                    }
                }
                advance(&mut group, &forcing_rows, self.compiled, &of_lane, stop)?;
                for lane in 0..self.bodies.len() {
                    moved[lane] |= of_lane[lane].steps > 0;
                    if let Some(state) = state.filter(|_| self.states.status[lane] != Status::StepLimit) {
                        self.record(&group, lane, state, moved[lane]);
                    }
                }
            }
        }
        Some(self.states)
    }

    /// Writes the state of a lane and updates the drifts.
    fn record(&mut self, group: &Group, lane: usize, state: usize, moved: bool) {
        let time = match self.request.schedule {
            Schedule::Times(times) => times[state],
            Schedule::Strides(_) => f64::NAN,
        };
        let mut now = unload(group, lane, self.compiled, self.assignments[lane], time);
        if !moved {
            // Through the momenta and back, the rates would return rounded.
            now.omega = self.bodies[lane].omega;
        }
        let at = lane * self.request.schedule.len() + state;
        self.states.record(lane, at, now, (invariants_at_start(group, lane), &mut self.last[lane]));
    }
}

/// Advances every lane by its number of steps of its size; finished lanes are inactive, with a step of 0.
fn advance(
    group: &mut Group,
    forcing_rows: &ForcingRows,
    compiled: Compiled,
    legs: &[Leg],
    stop: &AtomicBool,
) -> Option<()> {
    let mut ends: Vec<u64> = legs.iter().map(|leg| leg.steps).filter(|&steps| steps > 0).collect();
    ends.sort_unstable();
    ends.dedup();
    if compiled.is_processed() {
        step_where(group, legs, |leg| leg.steps > 0);
        compiled.enter(group);
    }
    let mut done = 0;
    for end in ends {
        step_where(group, legs, |leg| leg.steps > done);
        while done < end {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let count = (end - done).min(STEPS_BETWEEN_STOPS as u64);
            compiled.advance(group, forcing_rows, count as usize);
            done += count;
        }
        if compiled.is_processed() {
            step_where(group, legs, |leg| leg.steps == end);
            compiled.leave(group);
        }
    }
    Some(())
}

/// Sets the steps of some lanes, and makes the others inactive.
fn step_where(group: &mut Group, legs: &[Leg], goes: impl Fn(&Leg) -> bool) {
    for (lane, leg) in legs.iter().enumerate() {
        group.step.0[lane] = if goes(leg) { leg.step } else { 0.0 };
    }
}
