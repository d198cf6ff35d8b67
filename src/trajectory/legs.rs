//! Legs: steps of equal size between the stops of a body, which are its output times and the knots of its forces. The
//! bodies of a group are moved leg by leg together.

use super::{Integration, Request, Schedule};
use crate::body::Body;
use crate::error::Error;
use crate::forces::{Further, Orbit, OrbitPlace, Table};
use crate::kernel::{Compiled, ForcesRows, Group, reset_time};
use crate::memory;
use crate::method::AnyMethod;
use crate::parallel::Interrupt;
use crate::simd::LANES;
use std::ops::Range;

/// The forces on free motions.
static NO_FORCES: ForcesRows<'static> = ForcesRows::NONE;

/// Steps of equal size to the next requested state or knot of the forces.
#[derive(Clone, Copy)]
pub(super) struct Leg {
    pub(super) steps: u64,
    pub(super) step: f64,
}

impl Leg {
    const NONE: Leg = Leg { steps: 0, step: 0.0 };
}

/// Steps no longer than `largest` that end exactly at `to`, their number times the refinement.
fn leg(from: f64, to: f64, largest: f64, refinement: f64) -> Leg {
    let span = to - from;
    let wanted = span.abs() / largest;
    // A quotient that differs from a whole number only by rounding does not add a step.
    let nearest = wanted.round();
    let steps = if (wanted - nearest).abs() <= 1e-9 * nearest { nearest } else { wanted.ceil() };
    if span == 0.0 {
        return Leg::NONE;
    }
    let steps = (steps.max(1.0) * refinement.max(1.0)).ceil();
    Leg { steps: steps as u64, step: span / steps }
}

/// The end of a leg: a time, or a number of steps.
#[derive(Clone, Copy, PartialEq)]
enum End {
    At(f64),
    After(u64),
}

/// The begin and the end of a leg, and the requested state at its end if there is one.
#[derive(Clone, Copy, PartialEq)]
struct Stop {
    from: f64,
    end: End,
    state: Option<usize>,
}

impl Stop {
    /// A body that has arrived stays where it is.
    const ARRIVED: Stop = Stop { from: 0.0, end: End::After(0), state: None };

    /// The leg of a body with that largest step and that refinement.
    fn leg(&self, largest: f64, refinement: f64) -> Leg {
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
    /// The layer at the start of a body whose steps do not follow its damping. Backward in time damping ends nothing.
    fn of(request: &Request, body: usize, backward: bool) -> Option<Layer> {
        let AnyMethod::Steps(method) = request.method else { return None };
        if backward || !method.damps_exactly() {
            return None;
        }
        let forces = request.forces_of(body);
        if forces.is_none() {
            return None;
        }
        let [.., rate] = forces.damping.rates(request.bodies[body].moments);
        let first = PART / rate;
        let last = request.steps[body] / PART;
        (request.steps[body] > first).then_some(Layer { since: 0.0, first, next: first, last })
    }

    /// The first end of a leg after a time, if the layer has not ended.
    fn end_after(&mut self, time: f64) -> f64 {
        // From any `next` above zero, 3200 parts lead to infinity; `check_forced` has seen that no rate is infinite.
        while self.since + self.next <= time {
            self.next *= 1.0 + PART;
        }
        if self.next < self.last { self.since + self.next } else { f64::INFINITY }
    }
}

/// The stops of a body in the order they are made: forward from 0 through the times >= 0, or backward from 0 through
/// the times < 0. Legs end at the knots of the forces: a step across a knot would lose the order of any method.
struct Stops<'a> {
    schedule: &'a Schedule<'a>,
    /// The times of the body; none if its steps are counted.
    times: &'a [f64],
    /// The torque whose knots end legs.
    table: Table<'a>,
    layer: Option<Layer>,
    backward: bool,
    from: f64,
    /// The states that are left.
    left: Range<usize>,
}

impl<'a> Stops<'a> {
    fn new(request: &'a Request, body: usize, backward: bool) -> Self {
        let (schedule, table) = (&request.schedule, request.forces_of(body).table);
        let times = schedule.times_of(body).unwrap_or_default();
        let split = times.partition_point(|&t| t < 0.0);
        let left = if backward { 0..split } else { split..schedule.len() };
        let layer = Layer::of(request, body, backward);
        Stops { schedule, times, table, layer, backward, from: 0.0, left }
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
        let knot = self.table.next_knot(from, self.backward).filter(is_before);
        if let Some(layer) = &mut self.layer {
            let end = layer.end_after(from);
            if end < knot.unwrap_or(to) {
                self.from = end;
                return Some(Stop { from, end: End::At(end), state: None });
            }
            if let Some(since) = knot.filter(|&knot| self.table.jumps_at(knot)) {
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

/// Whether all of some values are equal.
fn are_equal<T: PartialEq>(mut values: impl Iterator<Item = T>) -> bool {
    let first = values.next();
    values.all(|value| Some(value) == first)
}

/// The next stops of all lanes. Tables of torques share their knots: with equal times and layers the stops are equal
/// too, and are found once.
struct GroupStops<'a> {
    each: Vec<Stops<'a>>,
}

impl<'a> GroupStops<'a> {
    fn new(
        request: &'a Request,
        bodies: impl ExactSizeIterator<Item = usize> + Clone,
        backward: bool,
    ) -> Result<Self, Error> {
        let has_own_times = matches!(request.schedule, Schedule::TimesOfEach(..));
        let mut each = memory::reserved("stops of a group", bodies.len())?;
        let layers = bodies.clone().map(|body| Layer::of(request, body, backward));
        let count = if !has_own_times && are_equal(layers) { 1 } else { bodies.len() };
        each.extend(bodies.take(count).map(|body| Stops::new(request, body, backward)));
        Ok(GroupStops { each })
    }

    /// Whether no stop is left.
    fn is_over(&self) -> bool {
        self.each.iter().all(|stops| stops.left.is_empty())
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

/// The bodies of one group, and the legs that they make together. Body b has the lanes from `b lanes_each` on.
pub(super) struct LegGroup<'a> {
    pub(super) request: &'a Request<'a>,
    /// How the bodies of the block are integrated.
    integrations: &'a [Integration],
    /// Index of the first body of the block.
    first: usize,
    /// Indices of the bodies of the group in the block.
    pub(super) members: &'a [usize],
    pub(super) compiled: Compiled,
    pub(super) lanes_each: usize,
    pub(super) lanes: &'a mut Group,
    /// The numbers of the bodies that are not loaded.
    pub(super) waiting: Range<usize>,
    pub(super) stop: &'a Interrupt<'a>,
    /// `None` if no forces act, and no parameter is changed.
    forces_rows: Option<Box<ForcesRows<'a>>>,
    /// The steps of each body; `None` if they are too many, and the body is not moved.
    pub(super) steps: [Option<u64>; LANES],
    backward: bool,
    stops: GroupStops<'a>,
    /// Whether the present stops are the last.
    pub(super) is_over: bool,
    now: [Stop; LANES],
    /// The legs to the present stops.
    pub(super) legs: [Leg; LANES],
    /// Whether the bodies are integrated over the eccentric anomaly of their orbits.
    is_on_clock: bool,
    /// The eccentric anomalies of such bodies at their start, and at the present stops.
    first_anomalies: [f64; LANES],
    anomalies: [f64; LANES],
    /// By which a step of the time becomes one of the anomaly, of such bodies; 1 of others.
    paces: [f64; LANES],
}

impl<'a> LegGroup<'a> {
    /// The bodies before their first leg, not loaded yet. Counts the steps of all legs.
    pub(super) fn new(
        request: &'a Request<'a>,
        integrations: &'a [Integration],
        first: usize,
        members: &'a [usize],
        compiled: Compiled,
        (lanes, lanes_each): (&'a mut Group, usize),
        stop: &'a Interrupt<'a>,
    ) -> Result<Self, Error> {
        let is_changing = integrations[members[0]].forces.act || request.record.is_sensitivity();
        let bodies = members.iter().map(|&member| first + member);
        let stops = GroupStops::new(request, bodies, false)?;
        let mut group = LegGroup {
            request,
            integrations,
            first,
            members,
            compiled,
            lanes_each,
            lanes,
            waiting: 0..0,
            stop,
            forces_rows: is_changing
                .then(|| ForcesRows::with_room(request.forces.function_width()).map(Box::new))
                .transpose()?,
            steps: [Some(0); LANES],
            backward: false,
            stops,
            is_over: false,
            now: [Stop::ARRIVED; LANES],
            legs: [Leg::NONE; LANES],
            is_on_clock: compiled.kernel().system.is_on_clock,
            first_anomalies: [0.0; LANES],
            anomalies: [0.0; LANES],
            paces: [1.0; LANES],
        };
        for b in 0..members.len() {
            if let Some(orbit) = group.orbit(b) {
                group.first_anomalies[b] = orbit.anomaly_at(0.0);
                group.paces[b] = orbit.pace(orbit.farthest(request.range_of(group.index(b))));
            }
        }
        let mut totals = [0_u64; LANES];
        for backward in [false, true] {
            group.anomalies = group.first_anomalies;
            for stops in group.stops(backward)? {
                if stop.is_wanted() {
                    return Err(Error::Stopped);
                }
                for (total, leg) in totals.iter_mut().zip(&group.legs_to(&stops)) {
                    *total = total.saturating_add(leg.steps);
                }
            }
        }
        group.steps = totals.map(|total| Some(total).filter(|&total| total <= request.max_steps));
        Ok(group)
    }

    /// The index of a body among all.
    pub(super) fn index(&self, b: usize) -> usize {
        self.first + self.members[b]
    }

    pub(super) fn body(&self, b: usize) -> &'a Body {
        &self.request.bodies[self.index(b)]
    }

    pub(super) fn integration(&self, b: usize) -> Integration {
        self.integrations[self.members[b]]
    }

    /// The orbit of a body that is integrated over its anomaly.
    fn orbit(&self, b: usize) -> Option<Orbit<f64>> {
        self.is_on_clock.then(|| self.request.forces_of(self.index(b)).further.orbit)
    }

    /// The place on its orbit, at the present stop, of a body that is integrated over its anomaly.
    pub(super) fn place(&self, b: usize) -> Option<OrbitPlace> {
        self.orbit(b).map(|orbit| OrbitPlace::of(orbit, self.anomalies[b]))
    }

    /// The first lane of a body.
    pub(super) fn lane(&self, b: usize) -> usize {
        b * self.lanes_each
    }

    /// The lanes of a body.
    pub(super) fn lanes_of(&self, b: usize) -> Range<usize> {
        self.lane(b)..self.lane(b + 1)
    }

    /// The bound of the rates with which a forced body is loaded.
    pub(super) fn forced_rate(&self, b: usize) -> Option<f64> {
        let is_timed = !matches!(self.request.schedule, Schedule::Strides(_));
        let index = self.index(b);
        (self.is_forced() && is_timed)
            .then(|| self.body(b).fastest_rate(self.request.forces_of(index), self.request.range_of(index)))
            .map(|rate| rate / self.paces[b])
    }

    /// Puts the stops of all bodies at the begin of a direction of time. Whether there are any.
    pub(super) fn begin(&mut self, backward: bool) -> Result<bool, Error> {
        self.backward = backward;
        self.anomalies = self.first_anomalies;
        self.stops = self.stops(backward)?;
        if self.stops.is_over() {
            return Ok(false);
        }
        self.lanes.clear();
        self.waiting = 0..self.members.len();
        Ok(true)
    }

    /// Sets the legs to the next stops, and the forces on them. A body with too many steps stays.
    pub(super) fn begin_legs(&mut self) {
        self.now = self.stops.next().expect("the group is not over");
        self.is_over = self.stops.is_over();
        for b in 0..self.members.len() {
            if let (Some(orbit), Some(at)) = (self.orbit(b), self.compiled.kernel().system.own_at) {
                for (k, number) in orbit.clock_at(self.anomalies[b]).into_iter().enumerate() {
                    self.lanes.state[at + k].0[b] = number;
                }
            }
        }
        self.legs = self.legs_to(&self.now.clone());
        for b in 0..self.members.len() {
            if self.steps[b].is_none() {
                self.legs[b] = Leg::NONE;
            }
        }
        let Some(mut rows) = self.forces_rows.take() else { return };
        for b in 0..self.members.len() {
            if let Some(orbit) = self.orbit(b) {
                // Nothing else acts, at no time.
                rows.numbers.further.set(self.lane(b), &Further { orbit, ..Further::NONE });
                continue;
            }
            let (index, from) = (self.index(b), self.now[b].from);
            let interval = self.request.interval_of(index, from, self.backward);
            let function = self.request.forces_of(index).function_from(from);
            for lane in self.lanes_of(b) {
                rows.set(lane, &interval);
                rows.functions.set(lane, function);
                if self.is_forced() {
                    reset_time(self.lanes, self.compiled.kernel().system, lane);
                }
            }
        }
        self.forces_rows = Some(rows);
    }

    /// The requested state that a body has reached.
    pub(super) fn state(&self, b: usize) -> Option<usize> {
        self.now[b].state.filter(|_| self.steps[b].is_some())
    }

    /// Advances all lanes by some steps.
    pub(super) fn advance(&mut self, steps: u64) {
        let rows = self.forces_rows.as_deref().unwrap_or(&NO_FORCES);
        self.compiled.advance(self.lanes, rows, steps as usize);
    }

    /// Sets the steps of the lanes that move on after some steps, and makes the others inactive.
    pub(super) fn set_steps(&mut self, done: u64) {
        for b in 0..self.members.len() {
            let leg = self.legs[b];
            for lane in self.lanes_of(b) {
                self.lanes.step.0[lane] = if leg.steps > done { leg.step } else { 0.0 };
            }
        }
    }

    fn is_forced(&self) -> bool {
        self.integration(0).forces.act
    }

    fn stops(&self, backward: bool) -> Result<GroupStops<'a>, Error> {
        let first = self.first;
        GroupStops::new(self.request, self.members.iter().map(|&member| first + member), backward)
    }

    /// The legs of all bodies to those stops. The steps over an anomaly are those in the time, times a pace of the orbit.
    fn legs_to(&mut self, stops: &[Stop; LANES]) -> [Leg; LANES] {
        let (mut legs, mut before) = ([Leg::NONE; LANES], None);
        for b in 0..self.members.len() {
            let (orbit, largest) = (self.orbit(b), self.request.steps[self.index(b)]);
            // Neighbours mostly have the same step, and the same orbit.
            let now = Some((largest, stops[b], orbit, self.anomalies[b], self.paces[b]));
            if before == now {
                (legs[b], self.anomalies[b]) = (legs[b - 1], self.anomalies[b - 1]);
                continue;
            }
            before = now;
            let refinement = self.request.refinement;
            legs[b] = match (orbit, stops[b].end) {
                (Some(orbit), End::At(time)) => {
                    let span = orbit.anomaly_in(time - stops[b].from, self.anomalies[b]);
                    self.anomalies[b] = orbit.anomaly_at(time);
                    leg(0.0, span, largest * self.paces[b], refinement)
                }
                _ => stops[b].leg(largest, refinement),
            };
        }
        legs
    }
}
