//! States by series, each body in steps of its own: wanted times are answered from the polynomial of a step, and a
//! lane whose body is done takes the next.

use super::{Request, Schedule, States, Status, invariants_at_start, system_of};
use crate::error::Error;
use crate::group::{Group, LANES};
use crate::kernel::{Compiled, Kernel, Watch};
use crate::leaps::Leaps;
use crate::method::Method;
use crate::run::over_blocks;
use crate::simd::Isa;
use crate::start::{Body, Seat, State, load, read, unload};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bodies in a block: enough that the last ones hardly leave lanes waiting.
const BLOCK: usize = 1024;

/// Most steps between two looks at the stop flag.
const PATIENCE: u64 = 1 << 14;

/// Runs the request; `None` if it was stopped.
pub fn simulate(
    request: &Request,
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
            let mut states = States::unknown(request, blocks[b].len());
            for spin_free in [false, true] {
                Ride::new(request, times, method, blocks[b].clone(), spin_free, isa, tolerance)
                    .map_or(Some(()), |ride| ride.run(&mut states, stop))?;
            }
            Some(states)
        })
    });
    let mut all = States::with_capacity(request);
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
}

/// The bodies of a block that one kernel moves.
struct Ride<'a> {
    request: &'a Request<'a>,
    times: &'a [f64],
    /// The first time >= 0.
    split: usize,
    bodies: &'a [Body],
    first_steps: &'a [f64],
    queue: Vec<(usize, Seat)>,
    kernel: (Kernel, Compiled),
    group: Group,
    leaps: Leaps,
}

impl<'a> Ride<'a> {
    /// `None` if no body of the block is moved so.
    fn new(
        request: &'a Request<'a>,
        times: &'a [f64],
        method: Method,
        block: Range<usize>,
        spin_free: bool,
        isa: Isa,
        tolerance: f64,
    ) -> Option<Self> {
        let bodies = &request.bodies[block.clone()];
        let seats = bodies.iter().map(|body| Seat::of_path(method, body, request.is_top)).enumerate();
        let mut queue: Vec<(usize, Seat)> =
            seats.filter(|(_, seat)| seat.is_spin_free() == spin_free).collect();
        let seat = queue.first()?.1;
        // The longest way first (the queue is emptied from its end): at the end no lane waits long.
        queue.sort_by(|a, b| bodies[a.0].fastest_rate().total_cmp(&bodies[b.0].fastest_rate()));
        let kernel = Kernel { system: system_of(request, seat), table: seat.table, watch: Watch::Nothing };
        Some(Ride {
            request,
            times,
            split: times.partition_point(|&t| t < 0.0),
            bodies,
            first_steps: &request.steps[block],
            queue,
            kernel: (kernel, Compiled::new(kernel, isa)),
            group: Group::waiting(),
            leaps: Leaps::waiting(tolerance),
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
            let made =
                self.kernel.1.leap(&mut self.group, &mut self.leaps, left.min(PATIENCE) as usize) as u64;
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
        let rate = body.fastest_rate();
        self.leaps.direction.0[lane] = direction;
        self.leaps.inverse_rate.0[lane] = if rate > 0.0 { 1.0 / rate } else { 0.0 };
        for row in self.leaps.begin.iter_mut().chain(&mut self.leaps.now) {
            row.0[lane] = 0.0;
        }
        passenger.last = body.attitude;
        while let Some(0.0) = self.wanted(&passenger) {
            let mut start = unload(&self.group, lane, self.kernel, passenger.seat, 0.0);
            start.omega = body.omega;
            self.record(lane, &mut passenger, start, states);
            passenger.wanted += 1;
        }
        self.go_on(lane, passenger, states)
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
        self.leaps.next.0[lane] = time;
        Some(passenger)
    }

    fn leave(&mut self, lane: usize, passenger: Passenger, states: &mut States) -> Option<Passenger> {
        states.steps[passenger.body] = passenger.steps;
        self.group.wait(lane);
        self.leaps.next.0[lane] = f64::INFINITY;
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
