//! States by steps of a scheme.

use super::{Request, Schedule, States, Status, around, invariants_at_start, system_of};
use crate::group::{Drives, Group, LANES};
use crate::kernel::{Compiled, Kernel, Watch};
use crate::method::Method;
use crate::outside::Outside;
use crate::run::over_blocks;
use crate::simd::Isa;
use crate::start::{Body, Seat, load, start_clock, unload, widen_scales};
use std::ops::Range;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Longest burst between two looks at the stop flag: a tenth of a second of the dearest steps on the slowest path.
const PATIENCE: usize = 1 << 9;

/// One piece of a body's way: steps of equal size to the next wanted state.
#[derive(Clone, Copy)]
struct Leg {
    steps: u64,
    step: f64,
}

/// A leg, when it begins, and the state that it ends at, if one is wanted there.
#[derive(Clone, Copy)]
struct Stop {
    from: f64,
    leg: Leg,
    state: Option<usize>,
}

/// The legs of one body in the order they are made: forward from 0 through the times >= 0, and backward from 0 through
/// the times < 0.
type Plan = [Vec<Stop>; 2];

/// Steps no longer than `largest` that end exactly at `to`.
fn leg(from: f64, to: f64, largest: f64) -> Leg {
    let span = to - from;
    let wanted = span.abs() / largest;
    // A quotient that misses a whole number by rounding alone does not cost a step.
    let nearest = wanted.round();
    let steps = if (wanted - nearest).abs() <= 1e-9 * nearest { nearest } else { wanted.ceil() };
    if span == 0.0 {
        return Leg { steps: 0, step: 0.0 };
    }
    let steps = steps.max(1.0);
    Leg { steps: steps as u64, step: span / steps }
}

/// The plan of a body with that largest step. Legs end where what acts from outside changes: a step across a knot of
/// its table would lose the order of any scheme.
fn legs(schedule: &Schedule, outside: Option<&Outside>, largest: f64) -> Plan {
    match schedule {
        Schedule::Times(times) => {
            let split = times.partition_point(|&t| t < 0.0);
            let pass = |indices: &mut dyn Iterator<Item = usize>, backward: bool| {
                let (mut from, mut stops) = (0.0, Vec::new());
                for k in indices {
                    while let Some(knot) = outside.and_then(|outside| outside.next_knot(from, backward)) {
                        if if backward { knot <= times[k] } else { times[k] <= knot } {
                            break;
                        }
                        stops.push(Stop { from, leg: leg(from, knot, largest), state: None });
                        from = knot;
                    }
                    stops.push(Stop { from, leg: leg(from, times[k], largest), state: Some(k) });
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
    outside: Option<&Outside>,
    method: Method,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Option<States> {
    let groups = groups(request, outside, method);
    let parts = over_blocks(groups.len(), threads, stop, |g| {
        States::timed(|| Passengers::new(request, outside, method, groups[g].clone(), isa).run(stop))
    });
    let mut all = States::with_capacity(request, outside.is_some());
    for part in parts {
        all.append(part??);
    }
    Some(all)
}

/// The seat of a body. Strides repeat the steps of a map, which are made in the frame of the body.
fn seat_of(request: &Request, outside: Option<&Outside>, method: Method, body: &Body) -> Seat {
    match request.schedule {
        _ if outside.is_some() => Seat::of_driven(method, body),
        Schedule::Times(_) => Seat::of_path(method, body, request.is_top),
        Schedule::Strides(_) => Seat::of(method, body, request.is_top),
    }
}

/// Runs of neighbours that one kernel moves. The bits do not depend on who shares a group.
fn groups(request: &Request, outside: Option<&Outside>, method: Method) -> Vec<Range<usize>> {
    let engine = |body: &Body| {
        let seat = seat_of(request, outside, method, body);
        (seat.table, seat.is_spin_free())
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

/// The bodies of one group on their way through the schedule.
struct Passengers<'a> {
    request: &'a Request<'a>,
    outside: Option<&'a Outside>,
    bodies: &'a [Body],
    steps: &'a [f64],
    seats: Vec<Seat>,
    kernel: Kernel,
    compiled: Compiled,
    states: States,
    /// The attitude of each lane when it was last read.
    last: Vec<[f64; 4]>,
}

impl<'a> Passengers<'a> {
    fn new(
        request: &'a Request<'a>,
        outside: Option<&'a Outside>,
        method: Method,
        group: Range<usize>,
        isa: Isa,
    ) -> Self {
        let bodies = &request.bodies[group.clone()];
        let seats: Vec<Seat> = bodies.iter().map(|body| seat_of(request, outside, method, body)).collect();
        let system = system_of(request, outside, seats[0]);
        let kernel = Kernel { system, table: seats[0].table, watch: Watch::Nothing };
        Passengers {
            request,
            outside,
            bodies,
            steps: &request.steps[group],
            seats,
            kernel,
            compiled: Compiled::new(kernel, isa),
            states: States::unknown(request, outside.is_some(), bodies.len()),
            last: bodies.iter().map(|body| body.attitude).collect(),
        }
    }

    fn run(mut self, stop: &AtomicBool) -> Option<States> {
        // Neighbours mostly have the same step, hence the same plan.
        let mut plans: Vec<Rc<Plan>> = Vec::with_capacity(self.bodies.len());
        for (lane, &step) in self.steps.iter().enumerate() {
            let plan = match plans.last() {
                Some(last) if self.steps[lane - 1] == step => last.clone(),
                _ => Rc::new(legs(&self.request.schedule, self.outside, step)),
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
                load(&mut group, lane, (self.kernel, self.compiled), self.seats[lane], body, 0, 0.0);
                if let (Some(outside), Schedule::Times(times)) = (self.outside, &self.request.schedule) {
                    let rate = body.fastest_rate_driven(outside, around(times));
                    widen_scales(&mut group, lane, self.kernel.system, body, rate);
                }
            }
            let mut moved = [false; LANES];
            let mut drives = Drives::NONE;
            for k in 0..plans[0][pass].len() {
                let of_lane: Vec<Leg> = (0..self.bodies.len())
                    .map(|lane| match self.states.status[lane] {
                        Status::StepLimit => Leg { steps: 0, step: 0.0 },
                        _ => plans[lane][pass][k].leg,
                    })
                    .collect();
                // When legs begin and end is the same for all.
                let Stop { from, state, .. } = plans[0][pass][k];
                if let Some(outside) = self.outside {
                    for (lane, body) in self.bodies.iter().enumerate() {
                        drives.set(lane, &outside.drive(from, pass == 1, body.moments));
                        start_clock(&mut group, self.kernel, lane);
                    }
                }
                advance(&mut group, &drives, self.compiled, &of_lane, stop)?;
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
        let mut now = unload(group, lane, (self.kernel, self.compiled), self.seats[lane], time);
        if !moved {
            // Through the momenta and back, the rates would return rounded.
            now.omega = self.bodies[lane].omega;
        }
        let at = lane * self.request.schedule.len() + state;
        self.states.record(lane, at, now, (invariants_at_start(group, lane), &mut self.last[lane]));
    }
}

/// Advances every lane by its own number of its own steps; lanes that are done wait with a step of 0.
fn advance(
    group: &mut Group,
    drives: &Drives,
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
            let burst = (end - done).min(PATIENCE as u64);
            compiled.advance_driven(group, drives, burst as usize);
            done += burst;
        }
        if compiled.is_processed() {
            step_where(group, legs, |leg| leg.steps == end);
            compiled.leave(group);
        }
    }
    Some(())
}

/// Lets some lanes make their step, and the others wait.
fn step_where(group: &mut Group, legs: &[Leg], goes: impl Fn(&Leg) -> bool) {
    for (lane, leg) in legs.iter().enumerate() {
        group.step.0[lane] = if goes(leg) { leg.step } else { 0.0 };
    }
}
