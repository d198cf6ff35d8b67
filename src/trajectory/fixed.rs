//! States by steps of a scheme.

use super::{
    Effort, Integration, Request, Schedule, StatesPart, blocks, invariants_at_start, kinds_in,
    over_blocks_of, steps_of_legs,
};
use crate::error::Error;
use crate::forcing::BodyForcing;
use crate::kernel::{Compiled, ForcingRows, Group, Kernel};
use crate::kernel::{Entry, load, reset_time, unload};
use crate::memory;
use crate::observe::{Displacement, Observed};
use crate::parallel::Interrupt;
use crate::scheme::Scheme;
use crate::simd::{Isa, LANES};
use crate::solver::Solver;
use crate::start::Body;
use crate::status::Status;
use std::ops::Range;

/// Largest number of steps between two checks of the stop flag: a tenth of a second
/// of the most expensive steps on the slowest path.
const STEPS_BETWEEN_STOPS: usize = 1 << 9;

/// The forcing of free motions.
static NO_FORCING: ForcingRows = ForcingRows::NONE;

/// Steps of equal size to the next requested state or knot of the forcing.
#[derive(Clone, Copy)]
pub(super) struct Leg {
    pub(super) steps: u64,
    pub(super) step: f64,
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
#[derive(Clone, Copy, PartialEq)]
pub(super) enum End {
    At(f64),
    After(u64),
}

/// The begin and the end of a leg, and the requested state at its end if there is one.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Stop {
    pub(super) from: f64,
    end: End,
    pub(super) state: Option<usize>,
}

impl Stop {
    /// A body that has arrived stays where it is.
    const ARRIVED: Stop = Stop { from: 0.0, end: End::After(0), state: None };

    /// The leg of a body with that largest step and that refinement.
    pub(super) fn leg(&self, largest: f64, refinement: f64) -> Leg {
        match self.end {
            End::At(to) => leg(self.from, to, largest, refinement),
            End::After(steps) => Leg { steps, step: largest },
        }
    }
}

/// What strong damping makes of a start or of a jump of the torque: first the fast rates end, while the slow ones still
/// turn the body. Steps from one end of the layer to the other would all step over it, whatever their number: the first
/// leg is a part of the time of the fastest damping, and each next one ends later by a part.
#[derive(Clone, Copy, PartialEq)]
struct Layer {
    since: f64,
    first: f64,
    /// The next end of a leg, since the begin of the layer.
    next: f64,
    /// The time after which steps are short enough.
    last: f64,
}

/// Legs of a layer, as a part of the time since its begin. With 1/2 the error of the layer is that of the other steps:
/// where both cancel, two runs agree by chance.
const PART: f64 = 0.25;

impl Layer {
    /// The layer at the start of a body whose steps do not follow its damping.
    fn of(request: &Request, body: usize) -> Option<Layer> {
        let Solver::Steps(scheme) = request.solver else { return None };
        let forcing = request.forcing_of(body);
        if !scheme.damps_exactly() || forcing.is_none() {
            return None;
        }
        let [.., rate] = forcing.damping_rates(request.bodies[body].moments);
        let first = PART / rate;
        let last = request.steps[body] / PART;
        (request.steps[body] > first).then_some(Layer { since: 0.0, first, next: first, last })
    }

    /// The first end of a leg after a time, if the layer has not ended.
    fn end_after(&mut self, time: f64) -> f64 {
        while self.since + self.next <= time {
            self.next *= 1.0 + PART;
        }
        if self.next < self.last { self.since + self.next } else { f64::INFINITY }
    }
}

/// The stops of a body in the order they are made: forward from 0 through the times >= 0, or backward from 0 through
/// the times < 0. Legs end at the knots of the forcing: a step across a knot would lose the order of any scheme.
struct Stops<'a> {
    schedule: &'a Schedule<'a>,
    /// The times of the body; none if its steps are counted.
    times: &'a [f64],
    forcing: BodyForcing<'a>,
    /// Backward in time damping ends nothing.
    layer: Option<Layer>,
    backward: bool,
    from: f64,
    /// The states that are left.
    left: Range<usize>,
}

impl<'a> Stops<'a> {
    fn new(request: &'a Request, body: usize, backward: bool) -> Self {
        let (schedule, forcing) = (&request.schedule, request.forcing_of(body));
        let times = schedule.times_of(body).unwrap_or_default();
        let split = times.partition_point(|&t| t < 0.0);
        let left = if backward { 0..split } else { split..schedule.len() };
        let layer = if backward { None } else { Layer::of(request, body) };
        Stops { schedule, times, forcing, layer, backward, from: 0.0, left }
    }
}

impl Iterator for Stops<'_> {
    type Item = Stop;

    fn next(&mut self) -> Option<Stop> {
        let mut left = self.left.clone();
        let state = if self.backward { left.next_back() } else { left.next() }?;
        if let Schedule::Strides(strides) = self.schedule {
            self.left = left;
            return Some(Stop { from: 0.0, end: End::After(strides[state]), state: Some(state) });
        }
        let (from, to) = (self.from, self.times[state]);
        let is_before = |&knot: &f64| if self.backward { knot > to } else { knot < to };
        let knot = self.forcing.next_knot(from, self.backward).filter(is_before);
        if let Some(layer) = &mut self.layer {
            let end = layer.end_after(from);
            if end < knot.unwrap_or(to) {
                self.from = end;
                return Some(Stop { from, end: End::At(end), state: None });
            }
            if let Some(since) = knot.filter(|&knot| self.forcing.jumps_at(knot)) {
                *layer = Layer { since, next: layer.first, ..*layer };
            }
        }
        match knot {
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

/// The next stops of all lanes. Tables of torques share their knots: with equal times and layers the stops are equal
/// too, and are found once.
pub(super) struct GroupStops<'a> {
    each: Vec<Stops<'a>>,
}

impl<'a> GroupStops<'a> {
    pub(super) fn new(
        request: &'a Request,
        bodies: impl ExactSizeIterator<Item = usize>,
        backward: bool,
    ) -> Result<Self, Error> {
        let (count, stops) = (bodies.len(), bodies.map(|body| Stops::new(request, body, backward)));
        let mut each = memory::collected("stops of a group", count, stops)?;
        let has_own_times = matches!(request.schedule, Schedule::TimesOfEach(..));
        if !has_own_times && each.iter().all(|stops| stops.layer == each[0].layer) {
            each.truncate(1);
        }
        Ok(GroupStops { each })
    }
}

impl Iterator for GroupStops<'_> {
    type Item = [Stop; LANES];

    fn next(&mut self) -> Option<[Stop; LANES]> {
        if let [shared] = &mut self.each[..] {
            return Some([shared.next()?; LANES]);
        }
        let mut next = [Stop::ARRIVED; LANES];
        let mut goes_on = false;
        for (stop, own) in next.iter_mut().zip(&mut self.each) {
            if let Some(own) = own.next() {
                (*stop, goes_on) = (own, true);
            }
        }
        goes_on.then_some(next)
    }
}

/// Runs the request.
pub fn simulate(
    request: &Request,
    scheme: &Scheme,
    states: StatesPart,
    threads: usize,
    isa: Isa,
    stop: &Interrupt,
) -> Result<Effort, Error> {
    let count = request.bodies.len();
    let ways = Integration::of_block(request, scheme, 0..count)?;
    let kind = |index: usize| ways[index].kind();
    let blocks = blocks(count, threads, |index| (kind(index), steps_of_legs(request, index)))?;
    // The bits of a body do not depend on the others of its group.
    over_blocks_of(request, &blocks, states, threads, stop, |block, mut states| {
        states.forget();
        for mut members in kinds_in(block.clone(), kind)? {
            // A group makes the steps of the body that needs most.
            members.sort_unstable_by_key(|&member| steps_of_legs(request, block.start + member));
            for group in members.chunks(LANES) {
                let own = &ways[block.clone()];
                FixedBatch::new(request, own, block.start, group, isa, &mut states).run(stop)?;
            }
        }
        Ok(0)
    })
}

/// The bodies of one group.
struct FixedBatch<'a, 'b> {
    request: &'a Request<'a>,
    /// How the bodies of the block are integrated.
    ways: &'a [Integration],
    /// Index of the first body of the block.
    first: usize,
    /// Indices of the bodies of the group in the block.
    members: &'a [usize],
    compiled: Compiled,
    states: &'a mut StatesPart<'b>,
    /// The attitude of each lane at its last recorded state.
    last: [[f64; 4]; LANES],
}

impl<'a, 'b> FixedBatch<'a, 'b> {
    fn new(
        request: &'a Request<'a>,
        ways: &'a [Integration],
        first: usize,
        members: &'a [usize],
        isa: Isa,
        states: &'a mut StatesPart<'b>,
    ) -> Self {
        let way = ways[members[0]];
        let kernel =
            Kernel { system: way.system(request), step: way.assignment.step, observed: Observed::Nothing };
        let compiled = Compiled::new(kernel, isa);
        FixedBatch { request, ways, first, members, compiled, states, last: [[0.0; 4]; LANES] }
    }

    /// The indices of the bodies among all, lane after lane.
    fn bodies(&self) -> impl ExactSizeIterator<Item = usize> + Clone + use<'a, 'b> {
        let first = self.first;
        self.members.iter().map(move |&member| first + member)
    }

    fn body(&self, lane: usize) -> &'a Body {
        &self.request.bodies[self.first + self.members[lane]]
    }

    /// The legs of all lanes to those stops.
    fn legs(&self, stops: &[Stop; LANES]) -> [Leg; LANES] {
        let steps = |lane: usize| self.request.steps[self.first + self.members[lane]];
        let mut legs = [Leg { steps: 0, step: 0.0 }; LANES];
        for lane in 0..self.members.len() {
            // Neighbours mostly have the same step.
            let same = lane > 0 && steps(lane - 1) == steps(lane) && stops[lane - 1] == stops[lane];
            legs[lane] =
                if same { legs[lane - 1] } else { stops[lane].leg(steps(lane), self.request.refinement) };
        }
        legs
    }

    fn run(mut self, stop: &Interrupt) -> Result<(), Error> {
        let is_forced = self.ways[self.members[0]].forces.act;
        let mut totals = [0_u64; LANES];
        for backward in [false, true] {
            for next in GroupStops::new(self.request, self.bodies(), backward)? {
                if stop.is_wanted() {
                    return Err(Error::Stopped);
                }
                for (total, leg) in totals.iter_mut().zip(&self.legs(&next)) {
                    *total = total.saturating_add(leg.steps);
                }
            }
        }
        for (&member, &total) in self.members.iter().zip(&totals) {
            if total > self.request.max_steps {
                self.states.status[member] = Status::StepLimit;
            } else {
                self.states.steps[member] = total;
                for drift in self.states.drifts() {
                    drift[member] = 0.0;
                }
            }
        }
        for backward in [false, true] {
            let stops = GroupStops::new(self.request, self.bodies(), backward)?;
            if stops.each.iter().all(|stops| stops.left.is_empty()) {
                continue;
            }
            let mut group = Group::inactive();
            for (lane, index) in self.bodies().enumerate() {
                let body = self.body(lane);
                self.last[lane] = body.attitude;
                let timed = is_forced && !matches!(self.request.schedule, Schedule::Strides(_));
                let rate = timed
                    .then(|| body.fastest_rate(self.request.forcing_of(index), self.request.range_of(index)));
                let mut entry = Entry::unobserved(body, rate, 0.0);
                entry.displacement = Displacement::new(self.request.record.displacement_of(index));
                load(&mut group, lane, self.compiled, self.ways[self.members[lane]].assignment, &entry);
            }
            let mut moved = [false; LANES];
            let is_changing = is_forced || self.request.record.is_sensitivity();
            let mut forcing_rows = is_changing.then(|| Box::new(ForcingRows::NONE));
            for next in stops {
                let mut legs = self.legs(&next);
                for (lane, &member) in self.members.iter().enumerate() {
                    if self.states.status[member] == Status::StepLimit {
                        legs[lane] = Leg { steps: 0, step: 0.0 };
                    }
                }
                let legs = &legs[..self.members.len()];
                if let Some(forcing_rows) = &mut forcing_rows {
                    for (lane, index) in self.bodies().enumerate() {
                        let interval = self.request.interval_of(index, next[lane].from, backward);
                        forcing_rows.set(lane, &interval);
                        if is_forced {
                            reset_time(&mut group, self.compiled.kernel().system, lane);
                        }
                    }
                }
                let forcing_rows = forcing_rows.as_deref().unwrap_or(&NO_FORCING);
                advance(&mut group, forcing_rows, self.compiled, legs, stop)?;
                for (lane, &member) in self.members.iter().enumerate() {
                    moved[lane] |= legs[lane].steps > 0;
                    let limited = self.states.status[member] == Status::StepLimit;
                    if let Some(state) = next[lane].state.filter(|_| !limited) {
                        self.record(&group, lane, state, moved[lane]);
                    }
                }
            }
        }
        Ok(())
    }

    /// Writes the state of a lane and updates the drifts.
    fn record(&mut self, group: &Group, lane: usize, state: usize, moved: bool) {
        let member = self.members[lane];
        let mut now = unload(group, lane, self.compiled, self.ways[member].assignment);
        if !moved {
            // Through the momenta and back, the rates would return rounded.
            now.omega = self.body(lane).omega;
            now.tangent = now.tangent.map(|_| self.request.record.displacement_of(self.first + member));
        }
        let at = member * self.request.schedule.len() + state;
        self.states.record(member, at, &now, (invariants_at_start(group, lane), &mut self.last[lane]));
    }
}

/// Advances every lane by its number of steps of its size; finished lanes are inactive, with a step of 0.
fn advance(
    group: &mut Group,
    forcing_rows: &ForcingRows,
    compiled: Compiled,
    legs: &[Leg],
    stop: &Interrupt,
) -> Result<(), Error> {
    let mut lanes: [usize; LANES] = std::array::from_fn(|lane| lane);
    let lanes = &mut lanes[..legs.len()];
    lanes.sort_unstable_by_key(|&lane| legs[lane].steps);
    set_steps(group, legs);
    if compiled.is_processed() {
        compiled.enter(group);
    }
    let (mut done, mut at_rest) = (0, 0);
    for (i, &lane) in lanes.iter().enumerate() {
        let end = legs[lane].steps;
        if end == done {
            continue;
        }
        for &finished in &lanes[at_rest..i] {
            group.step.0[finished] = 0.0;
        }
        at_rest = i;
        while done < end {
            if stop.is_wanted() {
                return Err(Error::Stopped);
            }
            let count = (end - done).min(STEPS_BETWEEN_STOPS as u64);
            compiled.advance(group, forcing_rows, count as usize);
            done += count;
        }
    }
    if compiled.is_processed() {
        set_steps(group, legs);
        compiled.leave(group);
    }
    Ok(())
}

/// Sets the steps of the lanes that move, and makes the others inactive.
fn set_steps(group: &mut Group, legs: &[Leg]) {
    for (lane, leg) in legs.iter().enumerate() {
        group.step.0[lane] = if leg.steps > 0 { leg.step } else { 0.0 };
    }
}
