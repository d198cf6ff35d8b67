//! States by steps of a scheme.

use super::{DRIFT_LIMIT, Record, Request, Schedule, States, Status, norm, worse};
use crate::group::{DriftRows, Group, LANES};
use crate::kernel::{Compiled, Kernel, System, Watch};
use crate::method::Method;
use crate::run::over_blocks;
use crate::simd::Isa;
use crate::start::{Body, Seat, load, unload};
use std::ops::Range;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Longest burst between two looks at the stop flag.
const PATIENCE: usize = 1 << 16;

/// One piece of a body's way: steps of equal size to the next wanted state.
#[derive(Clone, Copy)]
struct Leg {
    steps: u64,
    step: f64,
}

/// The legs of one body in the order they are made, each with the index of its state: forward from 0 through
/// the times >= 0, and backward from 0 through the times < 0.
type Plan = [Vec<(usize, Leg)>; 2];

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

/// The plan of a body with that largest step.
fn legs(schedule: &Schedule, largest: f64) -> Plan {
    match schedule {
        Schedule::Times(times) => {
            let split = times.partition_point(|&t| t < 0.0);
            let pass = |indices: &mut dyn Iterator<Item = usize>| {
                let mut from = 0.0;
                indices
                    .map(|k| {
                        let leg = leg(from, times[k], largest);
                        from = times[k];
                        (k, leg)
                    })
                    .collect()
            };
            [pass(&mut (split..times.len())), pass(&mut (0..split).rev())]
        }
        Schedule::Strides(strides) => {
            let forward =
                strides.iter().enumerate().map(|(k, &steps)| (k, Leg { steps, step: largest })).collect();
            [forward, Vec::new()]
        }
    }
}

/// Runs the request; `None` if it was stopped.
pub fn simulate(
    request: &Request,
    method: Method,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Option<States> {
    let groups = groups(request, method);
    let parts = over_blocks(groups.len(), threads, stop, |g| {
        Passengers::new(request, method, groups[g].clone(), isa).run(stop)
    });
    let mut all = States::with_capacity(request);
    for part in parts {
        all.append(part??);
    }
    Some(all)
}

/// The seat of a body. Strides repeat the steps of a map, which are made in the frame of the body.
fn seat_of(request: &Request, method: Method, body: &Body) -> Seat {
    match request.schedule {
        Schedule::Times(_) => Seat::of_path(method, body, request.is_top),
        Schedule::Strides(_) => Seat::of(method, body, request.is_top),
    }
}

/// Runs of neighbours that one kernel moves. The bits do not depend on who shares a group.
fn groups(request: &Request, method: Method) -> Vec<Range<usize>> {
    let engine = |body: &Body| {
        let seat = seat_of(request, method, body);
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
    bodies: &'a [Body],
    steps: &'a [f64],
    seats: Vec<Seat>,
    kernel: Kernel,
    compiled: Compiled,
    states: States,
}

impl<'a> Passengers<'a> {
    fn new(request: &'a Request<'a>, method: Method, group: Range<usize>, isa: Isa) -> Self {
        let bodies = &request.bodies[group.clone()];
        let seats: Vec<Seat> = bodies.iter().map(|body| seat_of(request, method, body)).collect();
        let system = match (request.is_top, request.record) {
            (false, Record::Rates) => System::FreeRates,
            (false, Record::Axis) => System::FreeAxis,
            (false, Record::Attitude) => System::FreeAttitude,
            (true, Record::Rates | Record::Axis) if seats[0].is_spin_free() => System::SpinFreeAxis,
            (true, Record::Attitude) if seats[0].is_spin_free() => System::SpinFreeAttitude,
            (true, Record::Rates | Record::Axis) => System::TopAxis,
            (true, Record::Attitude) => System::TopAttitude,
        };
        let kernel = Kernel { system, table: seats[0].table, watch: Watch::Nothing };
        Passengers {
            request,
            bodies,
            steps: &request.steps[group],
            seats,
            kernel,
            compiled: Compiled::new(kernel, isa),
            states: States::unknown(request, bodies.len()),
        }
    }

    fn run(mut self, stop: &AtomicBool) -> Option<States> {
        // Neighbours mostly have the same step, hence the same plan.
        let mut plans: Vec<Rc<Plan>> = Vec::with_capacity(self.bodies.len());
        for (lane, &step) in self.steps.iter().enumerate() {
            let plan = match plans.last() {
                Some(last) if self.steps[lane - 1] == step => last.clone(),
                _ => Rc::new(legs(&self.request.schedule, step)),
            };
            plans.push(plan);
        }
        for (lane, plan) in plans.iter().enumerate() {
            let total = plan.iter().flatten().fold(0_u64, |sum, (_, leg)| sum.saturating_add(leg.steps));
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
                load(&mut group, lane, (self.kernel, self.compiled), self.seats[lane], body, 0, 0.0);
            }
            let mut moved = [false; LANES];
            for k in 0..plans[0][pass].len() {
                let of_lane: Vec<Leg> = (0..self.bodies.len())
                    .map(|lane| match self.states.status[lane] {
                        Status::StepLimit => Leg { steps: 0, step: 0.0 },
                        _ => plans[lane][pass][k].1,
                    })
                    .collect();
                advance(&mut group, self.compiled, &of_lane, stop)?;
                for lane in 0..self.bodies.len() {
                    moved[lane] |= of_lane[lane].steps > 0;
                    if self.states.status[lane] != Status::StepLimit {
                        self.record(&group, lane, plans[0][pass][k].0, moved[lane]);
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
        let now = now.with_plain_nans();
        let states = &mut self.states;
        let at = lane * self.request.schedule.len() + state;
        states.omega[3 * at..][..3].copy_from_slice(&now.omega);
        let mut units = 0.0_f64;
        if let Some(direction) = now.direction {
            units = worse(units, (norm(&direction) - 1.0).abs());
            if let Some(vertical) = &mut states.vertical {
                vertical[3 * at..][..3].copy_from_slice(&direction);
            }
        }
        if let (Some(now), Some(attitude)) = (now.attitude, &mut states.attitude) {
            units = worse(units, (norm(&now) - 1.0).abs());
            attitude[4 * at..][..4].copy_from_slice(&now);
        }
        for invariants in [Some(now.invariants), now.invariants_of_attitude].into_iter().flatten() {
            let drift = |rows: &DriftRows, value: f64| {
                (value - rows.start.0[lane]).abs() * rows.inverse_scale.0[lane]
            };
            states.energy_drift[lane] = worse(states.energy_drift[lane], drift(&group.energy, invariants[0]));
            states.momentum_drift[lane] =
                worse(states.momentum_drift[lane], drift(&group.momentum, invariants[1]));
        }
        states.unit_drift[lane] = worse(states.unit_drift[lane], units);
        let finite = now.omega.iter().chain(&now.invariants).all(|x| x.is_finite()) && units.is_finite();
        if !finite {
            states.status[lane] = Status::NotFinite;
        } else if states.status[lane] == Status::Finished {
            let drifts = [states.energy_drift[lane], states.momentum_drift[lane], states.unit_drift[lane]];
            // A NaN is not below the limit.
            if !drifts.iter().all(|&drift| drift <= DRIFT_LIMIT) {
                states.status[lane] = Status::Drifted;
            }
        }
    }
}

/// Advances every lane by its own number of its own steps; lanes that are done wait with a step of 0.
fn advance(group: &mut Group, compiled: Compiled, legs: &[Leg], stop: &AtomicBool) -> Option<()> {
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
            compiled.advance(group, burst as usize);
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
