//! States by series, each body in steps of its own: wanted times are answered from the polynomial of a step, and a
//! lane whose body is done takes the next.

use super::{Request, Schedule, States, Status, around, invariants_at_start, system_of};
use crate::error::Error;
use crate::group::{Drives, Group, LANES};
use crate::kernel::{Compiled, Kernel, Watch};
use crate::leaps::Leaps;
use crate::method::Method;
use crate::outside::Outside;
use crate::run::over_blocks;
use crate::simd::Isa;
use crate::start::{Body, Seat, State, load, read, start_clock, unload, widen_scales};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bodies in a block: enough that the last ones hardly leave lanes waiting.
const BLOCK: usize = 1024;

/// Most steps between two looks at the stop flag.
const PATIENCE: u64 = 1 << 14;

/// Runs the request; `None` if it was stopped.
pub fn simulate(
    request: &Request,
    outside: Option<&Outside>,
    method: Method,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<Option<States>, Error> {
    let refused = |rule| {
        let value = request.tolerance.map_or(String::new(), |tolerance| format!("{tolerance:e}"));
        Error::Value { argument: "tolerance", value, rule }
    };
    let Schedule::Times(times) = request.schedule else {
        return Err(refused("steps of a given size have no tolerance"));
    };
    let tolerance = request.tolerance.filter(|t| (f64::MIN_POSITIVE..1.0).contains(t));
    let tolerance = tolerance.ok_or_else(|| refused("must be positive and below one"))?;
    if !method.is_series() {
        return Err(refused("only the Taylor methods choose their steps"));
    }
    let blocks: Vec<Range<usize>> = (0..request.bodies.len())
        .step_by(BLOCK)
        .map(|first| first..request.bodies.len().min(first + BLOCK))
        .collect();
    let parts = over_blocks(blocks.len(), threads, stop, |b| {
        States::timed(|| {
            let mut states = States::unknown(request, outside.is_some(), blocks[b].len());
            for spin_free in [false, true] {
                Ride::new(request, outside, times, method, blocks[b].clone(), spin_free, isa, tolerance)
                    .map_or(Some(()), |ride| ride.run(&mut states, stop))?;
            }
            Some(states)
        })
    });
    let mut all = States::with_capacity(request, outside.is_some());
    for part in parts {
        let Some(Some(part)) = part else { return Ok(None) };
        all.append(part);
    }
    Ok(Some(all))
}

/// A body on its way: forward through the times >= 0, then from its start backward through the others.
#[derive(Clone, Copy)]
struct Passenger {
    /// In the block.
    body: usize,
    seat: Seat,
    /// The next wanted time.
    wanted: usize,
    backward: bool,
    steps: u64,
    /// Attitude when it was last read.
    last: [f64; 4],
    /// Where what acts from outside changes next; infinite if it does not.
    knot: f64,
}

/// The bodies of a block that one kernel moves.
struct Ride<'a> {
    request: &'a Request<'a>,
    outside: Option<&'a Outside>,
    times: &'a [f64],
    /// The first time >= 0.
    split: usize,
    bodies: &'a [Body],
    first_steps: &'a [f64],
    queue: Vec<(usize, Seat)>,
    kernel: (Kernel, Compiled),
    group: Group,
    leaps: Leaps,
    drives: Drives,
}

impl<'a> Ride<'a> {
    /// `None` if no body of the block is moved so.
    #[allow(clippy::too_many_arguments)] // What is asked, and of which bodies.
    fn new(
        request: &'a Request<'a>,
        outside: Option<&'a Outside>,
        times: &'a [f64],
        method: Method,
        block: Range<usize>,
        spin_free: bool,
        isa: Isa,
        tolerance: f64,
    ) -> Option<Self> {
        let bodies = &request.bodies[block.clone()];
        let seat_of = |body| match outside {
            Some(_) => Seat::of_driven(method, body),
            None => Seat::of_path(method, body, request.is_top),
        };
        let seats = bodies.iter().map(seat_of).enumerate();
        let mut queue: Vec<(usize, Seat)> =
            seats.filter(|(_, seat)| seat.is_spin_free() == spin_free).collect();
        let seat = queue.first()?.1;
        // The longest way first (the queue is emptied from its end): at the end no lane waits long.
        queue.sort_by(|a, b| bodies[a.0].fastest_rate().total_cmp(&bodies[b.0].fastest_rate()));
        let system = system_of(request, outside, seat);
        let kernel = Kernel { system, table: seat.table, watch: Watch::Nothing };
        Some(Ride {
            request,
            outside,
            times,
            split: times.partition_point(|&t| t < 0.0),
            bodies,
            first_steps: &request.steps[block],
            queue,
            kernel: (kernel, Compiled::new(kernel, isa)),
            group: Group::waiting(),
            leaps: Leaps::waiting(tolerance),
            drives: Drives::NONE,
        })
    }

    fn run(mut self, states: &mut States, stop: &AtomicBool) -> Option<()> {
        let mut lanes: [Option<Passenger>; LANES] = [None; LANES];
        loop {
            for lane in 0..LANES {
                while lanes[lane].is_none() {
                    let Some((body, seat)) = self.queue.pop() else { break };
                    let passenger = Passenger {
                        body,
                        seat,
                        wanted: self.split,
                        backward: false,
                        steps: 0,
                        last: [0.0; 4],
                        knot: f64::INFINITY,
                    };
                    for drift in
                        [&mut states.energy_drift, &mut states.momentum_drift, &mut states.unit_drift]
                    {
                        drift[body] = 0.0;
                    }
                    lanes[lane] = self.depart(lane, passenger, states);
                }
            }
            let aboard = lanes.iter().flatten();
            let Some(left) = aboard.map(|passenger| self.request.max_steps - passenger.steps).min() else {
                return Some(());
            };
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let most = left.min(PATIENCE) as usize;
            let made = self.kernel.1.leap(&mut self.group, &self.drives, &mut self.leaps, most) as u64;
            states.lane_steps += made * LANES as u64;
            for lane in 0..LANES {
                if let Some(mut passenger) = lanes[lane] {
                    passenger.steps += made;
                    lanes[lane] = self.arrive(lane, passenger, states);
                }
            }
        }
    }

    /// Puts a body into a lane, at its start; `None` if it has nowhere to go.
    fn depart(&mut self, lane: usize, mut passenger: Passenger, states: &mut States) -> Option<Passenger> {
        let body = &self.bodies[passenger.body];
        let first = self.first_steps[passenger.body];
        let span =
            self.times.last().copied().unwrap_or(0.0).abs() + self.times.first().map_or(0.0, |t| t.abs());
        // What does not turn is there in one step.
        let first = if first.is_finite() { first } else { span };
        let direction = if passenger.backward { -1.0 } else { 1.0 };
        load(&mut self.group, lane, self.kernel, passenger.seat, body, 0, direction * first);
        let mut rate = body.fastest_rate();
        if let Some(outside) = self.outside {
            // What stands still at first is moved by what acts on it.
            rate = body.fastest_rate_driven(outside, around(self.times));
            widen_scales(&mut self.group, lane, self.kernel.0.system, body, rate);
        }
        self.leaps.direction.0[lane] = direction;
        self.leaps.inverse_rate.0[lane] = if rate > 0.0 { 1.0 / rate } else { 0.0 };
        for row in self.leaps.begin.iter_mut().chain(&mut self.leaps.now) {
            row.0[lane] = 0.0;
        }
        passenger.last = body.attitude;
        self.meet(lane, &mut passenger, 0.0);
        while let Some(0.0) = self.wanted(&passenger) {
            let mut start = unload(&self.group, lane, self.kernel, passenger.seat, 0.0);
            start.omega = body.omega;
            self.record(lane, &mut passenger, start, states);
            passenger.wanted += 1;
        }
        self.go_on(lane, passenger, states)
    }

    /// Lets what acts from outside from a knot on, which a body has reached, act until the next.
    fn meet(&mut self, lane: usize, passenger: &mut Passenger, knot: f64) {
        let Some(outside) = self.outside else { return };
        let backward = passenger.backward;
        let moments = self.bodies[passenger.body].moments;
        self.drives.set(lane, &outside.drive(knot, backward, moments));
        start_clock(&mut self.group, self.kernel.0, lane);
        let never = if backward { f64::NEG_INFINITY } else { f64::INFINITY };
        passenger.knot = outside.next_knot(knot, backward).unwrap_or(never);
        self.leaps.end.0[lane] = passenger.knot;
    }

    /// Answers the wanted times that a lane has reached; the next body, or none, if it is done.
    fn arrive(&mut self, lane: usize, mut passenger: Passenger, states: &mut States) -> Option<Passenger> {
        let leaps = &self.leaps;
        let [begin, lost] = [leaps.begin[0].0[lane], leaps.begin[1].0[lane]];
        let (now, unit, direction) = (leaps.now[0].0[lane], leaps.unit.0[lane], leaps.direction.0[lane]);
        while let Some(time) = self.wanted(&passenger).filter(|&time| (time - now) * direction <= 0.0) {
            let units = ((time - begin) - lost) / unit;
            let y = self.kernel.1.inside(&self.leaps, lane, units);
            let state = read(&self.group, lane, self.kernel, passenger.seat, y, time);
            self.record(lane, &mut passenger, state, states);
            if passenger.backward && passenger.wanted == 0 {
                return self.leave(lane, passenger, states);
            }
            passenger.wanted = if passenger.backward { passenger.wanted - 1 } else { passenger.wanted + 1 };
        }
        if !now.is_finite() {
            let body = passenger.body;
            states.status[body] = Status::NotFinite;
            for drift in [&mut states.energy_drift, &mut states.momentum_drift, &mut states.unit_drift] {
                drift[body] = f64::NAN;
            }
            return self.leave(lane, passenger, states);
        }
        // Steps end at a knot but for rounding; one more, too short to have a length, would be made.
        let short = (passenger.knot - now) * direction;
        if passenger.knot.is_finite() && short <= 4.0 * f64::EPSILON * passenger.knot.abs() {
            let knot = passenger.knot;
            self.meet(lane, &mut passenger, knot);
        }
        self.go_on(lane, passenger, states)
    }

    /// The time that a body is on its way to.
    fn wanted(&self, passenger: &Passenger) -> Option<f64> {
        self.times.get(passenger.wanted).copied()
    }

    /// On to the next wanted time, or back to the start and backward, or out.
    fn go_on(&mut self, lane: usize, passenger: Passenger, states: &mut States) -> Option<Passenger> {
        let Some(time) = self.wanted(&passenger) else {
            if self.split == 0 {
                return self.leave(lane, passenger, states);
            }
            let back = Passenger { wanted: self.split - 1, backward: true, ..passenger };
            return self.depart(lane, back, states);
        };
        if passenger.steps >= self.request.max_steps {
            states.status[passenger.body] = Status::StepLimit;
            return self.leave(lane, passenger, states);
        }
        // A knot is looked at as soon as it is as near as rounding allows.
        let (knot, margin) = (passenger.knot, 4.0 * f64::EPSILON * passenger.knot.abs());
        self.leaps.next.0[lane] = match passenger.backward {
            _ if knot.is_infinite() => time,
            false => time.min(knot - margin),
            true => time.max(knot + margin),
        };
        Some(passenger)
    }

    fn leave(&mut self, lane: usize, passenger: Passenger, states: &mut States) -> Option<Passenger> {
        states.steps[passenger.body] = passenger.steps;
        self.group.wait(lane);
        self.leaps.next.0[lane] = f64::INFINITY;
        self.leaps.end.0[lane] = f64::INFINITY;
        self.leaps.direction.0[lane] = 1.0;
        for row in &mut self.leaps.now {
            row.0[lane] = 0.0;
        }
        None
    }

    fn record(&self, lane: usize, passenger: &mut Passenger, state: State, states: &mut States) {
        let at = passenger.body * self.times.len() + passenger.wanted;
        let known = (invariants_at_start(&self.group, lane), &mut passenger.last);
        states.record(passenger.body, at, state, known);
    }
}
