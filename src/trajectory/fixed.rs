//! States by steps of a scheme.

use super::states::StatesPart;
use super::{Request, Schedule, States, groups, invariants_at_start, over_groups, system_of, time_range};
use crate::error::Error;
use crate::forcing::Forcing;
use crate::kernel::{Compiled, ForcingRows, Group, Kernel};
use crate::kernel::{Entry, KernelAssignment, load, reset_time, unload};
use crate::memory;
use crate::observe::Observed;
use crate::scheme::Scheme;
use crate::simd::{Isa, LANES};
use crate::start::Body;
use crate::status::Status;
use std::ops::Range;
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

/// The end of a leg: a time, or a number of steps.
#[derive(Clone, Copy)]
enum End {
    At(f64),
    After(u64),
}

/// The begin and the end of a leg, and the requested state at its end if there is one.
#[derive(Clone, Copy)]
struct Stop {
    from: f64,
    end: End,
    state: Option<usize>,
}

impl Stop {
    /// The leg of a body with that largest step and that refinement.
    fn leg(&self, largest: f64, refinement: f64) -> Leg {
        match self.end {
            End::At(to) => leg(self.from, to, largest, refinement),
            End::After(steps) => Leg { steps, step: largest },
        }
    }
}

/// The stops of all bodies in the order they are made: forward from 0 through the times >= 0, or backward from 0 through
/// the times < 0. Legs end at the knots of the forcing: a step across a knot would lose the order of any scheme.
struct Stops<'a> {
    schedule: &'a Schedule<'a>,
    forcing: &'a Forcing,
    backward: bool,
    from: f64,
    /// The states that are left.
    left: Range<usize>,
}

impl<'a> Stops<'a> {
    fn new(request: &'a Request, backward: bool) -> Self {
        let (schedule, forcing) = (&request.schedule, request.forcing);
        let split = match schedule {
            Schedule::Times(times) => times.partition_point(|&t| t < 0.0),
            Schedule::Strides(_) => 0,
        };
        let left = if backward { 0..split } else { split..schedule.len() };
        Stops { schedule, forcing, backward, from: 0.0, left }
    }
}

impl Iterator for Stops<'_> {
    type Item = Stop;

    fn next(&mut self) -> Option<Stop> {
        let mut left = self.left.clone();
        let state = if self.backward { left.next_back() } else { left.next() }?;
        let to = match self.schedule {
            Schedule::Times(times) => times[state],
            Schedule::Strides(strides) => {
                self.left = left;
                return Some(Stop { from: 0.0, end: End::After(strides[state]), state: Some(state) });
            }
        };
        let from = self.from;
        let is_before = |&knot: &f64| if self.backward { knot > to } else { knot < to };
        match self.forcing.next_knot(from, self.backward).filter(is_before) {
            Some(knot) => {
                self.from = knot;
                Some(Stop { from, end: End::At(knot), state: None })
            }
            None => {
                (self.from, self.left) = (to, left);
                Some(Stop { from, end: End::At(to), state: Some(state) })
            }
        }
    }
}

/// Runs the request.
pub fn simulate(
    request: &Request,
    scheme: &Scheme,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<States, Error> {
    let engine = |body: &Body| {
        let assignment = assignment_of(request, scheme, body);
        (assignment.step, assignment.is_reduced())
    };
    // The bits of a body do not depend on the others of its group.
    let groups = groups(request.bodies, LANES, |a, b| engine(a) == engine(b))?;
    over_groups(request, &groups, threads, stop, |group, states| {
        FixedBatch::new(request, scheme, group, isa, states)?.run(stop)?;
        Ok(0)
    })
}

/// The assignment of a body. Strides repeat the steps of a map, which are made in the frame of the body.
fn assignment_of(request: &Request, scheme: &Scheme, body: &Body) -> KernelAssignment {
    match request.schedule {
        _ if !request.forcing.is_none() => KernelAssignment::of_forced(scheme, body),
        Schedule::Times(_) => KernelAssignment::of_path(scheme, body, request.scene),
        Schedule::Strides(_) => KernelAssignment::of(scheme, body, request.scene),
    }
}

/// The bodies of one group.
struct FixedBatch<'a> {
    request: &'a Request<'a>,
    bodies: &'a [Body],
    steps: &'a [f64],
    assignments: Vec<KernelAssignment>,
    compiled: Compiled,
    states: StatesPart<'a>,
    /// The attitude of each lane at its last recorded state.
    last: [[f64; 4]; LANES],
}

impl<'a> FixedBatch<'a> {
    fn new(
        request: &'a Request<'a>,
        scheme: &Scheme,
        group: Range<usize>,
        isa: Isa,
        states: StatesPart<'a>,
    ) -> Result<Self, Error> {
        let bodies = &request.bodies[group.clone()];
        let assignments = bodies.iter().map(|body| assignment_of(request, scheme, body));
        let assignments = memory::collected("bodies of a group", bodies.len(), assignments)?;
        let system = system_of(request, assignments[0]);
        let kernel = Kernel { system, step: assignments[0].step, observed: Observed::Nothing };
        let (steps, compiled) = (&request.steps[group], Compiled::new(kernel, isa));
        Ok(FixedBatch { request, bodies, steps, assignments, compiled, states, last: [[0.0; 4]; LANES] })
    }

    /// The legs of all lanes to that stop.
    fn legs(&self, stop: &Stop) -> [Leg; LANES] {
        let mut legs = [Leg { steps: 0, step: 0.0 }; LANES];
        for (lane, &step) in self.steps.iter().enumerate() {
            // Neighbours mostly have the same step.
            let same = lane > 0 && self.steps[lane - 1] == step;
            legs[lane] = if same { legs[lane - 1] } else { stop.leg(step, self.request.refinement) };
        }
        legs
    }

    fn run(mut self, stop: &AtomicBool) -> Result<(), Error> {
        let forcing = self.request.forcing;
        let mut totals = [0_u64; LANES];
        for next in [false, true].into_iter().flat_map(|backward| Stops::new(self.request, backward)) {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Stopped);
            }
            for (total, leg) in totals.iter_mut().zip(&self.legs(&next)).take(self.bodies.len()) {
                *total = total.saturating_add(leg.steps);
            }
        }
        for lane in 0..self.bodies.len() {
            if totals[lane] > self.request.max_steps {
                self.states.status[lane] = Status::StepLimit;
            } else {
                self.states.steps[lane] = totals[lane];
                for drift in self.states.drifts() {
                    drift[lane] = 0.0;
                }
            }
        }
        for backward in [false, true] {
            let stops = Stops::new(self.request, backward);
            if stops.left.is_empty() {
                continue;
            }
            let mut group = Group::inactive();
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
            for Stop { from, end, state } in stops {
                let mut legs = self.legs(&Stop { from, end, state });
                for (leg, status) in legs.iter_mut().zip(&*self.states.status) {
                    if *status == Status::StepLimit {
                        *leg = Leg { steps: 0, step: 0.0 };
                    }
                }
                let legs = &legs[..self.bodies.len()];
                if !forcing.is_none() {
                    for (lane, body) in self.bodies.iter().enumerate() {
                        forcing_rows.set(lane, &forcing.interval(from, backward, body.moments));
                        reset_time(&mut group, self.compiled.kernel().system, lane);
                    }
                }
                advance(&mut group, &forcing_rows, self.compiled, legs, stop)?;
                for lane in 0..self.bodies.len() {
                    moved[lane] |= legs[lane].steps > 0;
                    if let Some(state) = state.filter(|_| self.states.status[lane] != Status::StepLimit) {
                        self.record(&group, lane, state, moved[lane]);
                    }
                }
            }
        }
        Ok(())
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
) -> Result<(), Error> {
    let mut ends = [0; LANES];
    let ends = &mut ends[..legs.len()];
    ends.iter_mut().zip(legs).for_each(|(end, leg)| *end = leg.steps);
    ends.sort_unstable();
    if compiled.is_processed() {
        step_where(group, legs, |leg| leg.steps > 0);
        compiled.enter(group);
    }
    let mut done = 0;
    for &mut end in ends {
        // Of equal ends only the first.
        if end == done {
            continue;
        }
        step_where(group, legs, |leg| leg.steps > done);
        while done < end {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Stopped);
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
    Ok(())
}

/// Sets the steps of some lanes, and makes the others inactive.
fn step_where(group: &mut Group, legs: &[Leg], goes: impl Fn(&Leg) -> bool) {
    for (lane, leg) in legs.iter().enumerate() {
        group.step.0[lane] = if goes(leg) { leg.step } else { 0.0 };
    }
}
