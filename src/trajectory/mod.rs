//! States of bodies at the times that a user wants, stepped or in closed form.

mod adaptive;
mod closed;
mod stepped;

use crate::clock::thread_nanoseconds;
use crate::error::Error;
use crate::exact::Place;
use crate::group::Group;
use crate::kernel::System;
use crate::method::{Method, phi};
use crate::outside::Outside;
use crate::simd::Isa;
use crate::special::exp;
use crate::start::{Body, Seat, State};
use std::sync::atomic::AtomicBool;

/// How a body is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// By its closed form.
    Exact,
    /// By a scheme.
    Steps(Method),
}

impl Solver {
    /// The name of the closed forms among the methods.
    pub const EXACT: &str = "exact";

    /// The solver of that name.
    pub fn parse(name: &str) -> Result<Solver, Error> {
        if name == Solver::EXACT { Ok(Solver::Exact) } else { Method::parse(name).map(Solver::Steps) }
    }
}

/// What is carried, and so recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// Rates (a top needs its vertical with them).
    Rates,
    /// Rates and the vertical seen from the body.
    Axis,
    /// Rates and attitude.
    Attitude,
}

/// When states are wanted.
pub enum Schedule<'a> {
    /// At these times, ascending; the start is at time 0.
    Times(&'a [f64]),
    /// After these numbers of further steps of exactly the body's own step, the first perhaps 0.
    Strides(&'a [u64]),
}

impl Schedule<'_> {
    /// Number of states.
    pub fn len(&self) -> usize {
        match self {
            Schedule::Times(times) => times.len(),
            Schedule::Strides(strides) => strides.len(),
        }
    }

    /// Whether no state is wanted.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The request.
pub struct Request<'a> {
    /// The bodies with their starts.
    pub bodies: &'a [Body],
    /// Whether they have weight.
    pub is_top: bool,
    /// How they are moved.
    pub solver: Solver,
    /// What is recorded.
    pub record: Record,
    /// When.
    pub schedule: Schedule<'a>,
    /// Largest step of each body; with a tolerance its first.
    pub steps: &'a [f64],
    /// Of a Taylor series: the last terms of each step relative to the state; each body then takes its own steps.
    pub tolerance: Option<f64>,
    /// Most steps that a body may take.
    pub max_steps: u64,
}

/// How a body ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// At the last wanted time.
    Finished = 0,
    /// Stopped when the question was answered.
    Stopped = 1,
    /// Would have needed more steps than allowed: not run, or stopped there if it chooses its steps itself.
    StepLimit = 2,
    /// A number overflowed or became NaN.
    NotFinite = 3,
    /// The energy, the conserved momentum or the length of a direction or quaternion was lost: the step is too
    /// long for the motion to mean anything.
    Drifted = 4,
}

/// Relative error of an invariant from which on a motion is not to be believed.
pub const DRIFT_LIMIT: f64 = 0.1;

impl Status {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Status::Finished => "finished",
            Status::Stopped => "stopped",
            Status::StepLimit => "step limit",
            Status::NotFinite => "not finite",
            Status::Drifted => "drifted",
        }
    }
}

/// States and what is known of their error, body first.
pub struct States {
    /// (n, times, 3)
    pub omega: Vec<f64>,
    /// (n, times, 3), if recorded.
    pub vertical: Option<Vec<f64>>,
    /// (n, times, 4), if recorded.
    pub attitude: Option<Vec<f64>>,
    /// (n, times), if something acts from outside: its work since the start.
    pub work: Option<Vec<f64>>,
    /// Largest energy error at a wanted time, relative. Of a body that something acts on from outside: of the energy
    /// less the work, relative to the energy at the start and then.
    pub energy_drift: Vec<f64>,
    /// Largest error of the conserved momentum at a wanted time, relative.
    pub momentum_drift: Vec<f64>,
    /// Largest deviation of |gamma| and |q| from one.
    pub unit_drift: Vec<f64>,
    /// How each body ended.
    pub status: Vec<Status>,
    /// Steps that each body took.
    pub steps: Vec<u64>,
    /// Processor time of all threads, ns.
    pub nanoseconds: u64,
    /// Steps of all lanes under way, those that waited too; of bodies that choose their steps.
    pub lane_steps: u64,
}

/// Runs the request; `None` if it was stopped.
///
/// # Errors
/// If closed forms are wanted and a body has none, the method does not move tops, or a tolerance is given to what is no
/// series.
pub fn simulate(
    request: &Request,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<Option<States>, Error> {
    simulate_driven(request, None, threads, isa, stop)
}

/// The same under what acts from outside.
///
/// # Errors
/// As above, and if the method does not move driven bodies, a step is beyond its stability, or the table of a torque
/// does not reach a wanted time.
pub fn simulate_driven(
    request: &Request,
    outside: Option<&Outside>,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<Option<States>, Error> {
    match request.solver {
        Solver::Steps(method) => {
            method.check(request.is_top, false)?;
            if let Some(outside) = outside {
                check_driven(request, method, outside)?;
            }
            match request.tolerance {
                Some(_) => adaptive::simulate(request, outside, method, threads, isa, stop),
                None => Ok(stepped::simulate(request, outside, method, threads, isa, stop)),
            }
        }
        Solver::Exact => {
            if let Some(outside) = outside {
                return slowed_evenly(request, outside, threads, isa, stop);
            }
            let place = |(index, body)| Place::of(body).ok_or(Error::NoClosedForm { index });
            let places: Result<Vec<Place>, Error> = request.bodies.iter().enumerate().map(place).collect();
            let Schedule::Times(times) = request.schedule else {
                let value = Solver::EXACT.to_string();
                return Err(Error::Value { argument: "method", value, rule: "a closed form takes no steps" });
            };
            Ok(closed::simulate(request, times, &places?, threads, isa, stop))
        }
    }
}

/// Free bodies under a damping `D = k I`: `L' = L x omega - k L` is the free motion in the time
/// `s = (1 - exp(-k t)) / k`, times `exp(-k t)`.
fn slowed_evenly(
    request: &Request,
    outside: &Outside,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<Option<States>, Error> {
    let refuse = |rule| Err(Error::Value { argument: "method", value: Solver::EXACT.to_string(), rule });
    let Schedule::Times(times) = request.schedule else {
        return refuse("a closed form takes no steps");
    };
    let known = request.bodies.iter().map(|body| outside.slows_evenly(body.moments));
    let rates: Option<Vec<f64>> = known.collect();
    let even = rates.filter(|rates| !request.is_top && rates.windows(2).all(|two| two[0] == two[1]));
    let Some(rates) = even else {
        return refuse(
            "under torque or damping a closed form is known of free bodies whose damping is a multiple of their inertia",
        );
    };
    let rate = rates.first().copied().unwrap_or(0.0);
    let factors: Vec<f64> = times.iter().map(|&t| exp(-rate * t)).collect();
    let slow: Vec<f64> = times.iter().map(|&t| t * phi(-rate * t)[1]).collect();
    let request = Request { schedule: Schedule::Times(&slow), ..*request };
    let Some(mut states) = simulate(&request, threads, isa, stop)? else { return Ok(None) };
    let mut work = Vec::with_capacity(states.omega.len() / 3);
    for (body, rows) in request.bodies.iter().zip(states.omega.chunks_mut(3 * times.len().max(1))) {
        let kinetic = |w: &[f64]| (0..3).map(|k| 0.5 * body.moments[k] * w[k] * w[k]).sum::<f64>();
        for (row, &factor) in rows.chunks_mut(3).zip(&factors) {
            row.iter_mut().for_each(|w| *w *= factor);
            work.push(kinetic(row) - kinetic(&body.omega));
        }
    }
    states.work = Some(work);
    Ok(Some(states))
}

/// Refuses what would give a wrong motion: a method that does not know of torque and damping, steps with which an
/// explicit one blows up, times at which the torque is not known.
fn check_driven(request: &Request, method: Method, outside: &Outside) -> Result<(), Error> {
    let limit = method.damping_limit().ok_or_else(|| Error::Value {
        argument: "method",
        value: format!("'{}'", method.facts().name),
        rule: "moves bodies without torque and damping only",
    })?;
    if let Schedule::Times(times) = request.schedule {
        for &time in [Some(&0.0), times.first(), times.last()].into_iter().flatten() {
            outside.check_reaches(time)?;
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
        let [.., rate] = outside.damping_rates(body.moments);
        // A step is cut to the span.
        let span = match request.schedule {
            Schedule::Times(times) => around(times).iter().fold(0.0_f64, |a, t| a.max(t.abs())),
            Schedule::Strides(_) => f64::INFINITY,
        };
        let step = step.min(span);
        if step * rate > limit {
            let (name, longest) = (method.facts().name, limit / rate);
            return Err(Error::Unstable { step, rate, name, longest });
        }
    }
    Ok(())
}

/// First and last of ascending times and 0.
fn around(times: &[f64]) -> [f64; 2] {
    let end = |time: Option<&f64>| time.copied().unwrap_or(0.0);
    [end(times.first()).min(0.0), end(times.last()).max(0.0)]
}

impl States {
    /// Whether the vertical and the attitude are recorded.
    fn columns(request: &Request) -> (bool, bool) {
        match request.record {
            Record::Rates => (false, false),
            Record::Axis => (true, false),
            Record::Attitude => (request.is_top, true),
        }
    }

    /// Nothing yet, with room for all bodies.
    fn with_capacity(request: &Request, driven: bool) -> States {
        let n = request.bodies.len();
        let (vertical, attitude) = States::columns(request);
        let column = |width: usize| Vec::with_capacity(width * n * request.schedule.len());
        States {
            omega: column(3),
            vertical: vertical.then(|| column(3)),
            attitude: attitude.then(|| column(4)),
            work: driven.then(|| column(1)),
            energy_drift: Vec::with_capacity(n),
            momentum_drift: Vec::with_capacity(n),
            unit_drift: Vec::with_capacity(n),
            status: Vec::with_capacity(n),
            steps: Vec::with_capacity(n),
            nanoseconds: 0,
            lane_steps: 0,
        }
    }

    /// `n` bodies that have not moved.
    fn unknown(request: &Request, driven: bool, n: usize) -> States {
        let (vertical, attitude) = States::columns(request);
        let column = |width: usize| vec![f64::NAN; width * n * request.schedule.len()];
        States {
            omega: column(3),
            vertical: vertical.then(|| column(3)),
            attitude: attitude.then(|| column(4)),
            work: driven.then(|| column(1)),
            energy_drift: vec![f64::NAN; n],
            momentum_drift: vec![f64::NAN; n],
            unit_drift: vec![f64::NAN; n],
            status: vec![Status::Finished; n],
            steps: vec![0; n],
            nanoseconds: 0,
            lane_steps: 0,
        }
    }

    /// The bodies of `other` after those here.
    fn append(&mut self, other: States) {
        self.omega.extend(other.omega);
        if let (Some(here), Some(there)) = (&mut self.vertical, other.vertical) {
            here.extend(there);
        }
        if let (Some(here), Some(there)) = (&mut self.attitude, other.attitude) {
            here.extend(there);
        }
        if let (Some(here), Some(there)) = (&mut self.work, other.work) {
            here.extend(there);
        }
        self.energy_drift.extend(other.energy_drift);
        self.momentum_drift.extend(other.momentum_drift);
        self.unit_drift.extend(other.unit_drift);
        self.status.extend(other.status);
        self.steps.extend(other.steps);
        self.nanoseconds += other.nanoseconds;
        self.lane_steps += other.lane_steps;
    }

    /// The states that `work` returns, with the processor time that it took.
    fn timed(work: impl FnOnce() -> Option<States>) -> Option<States> {
        let begin = thread_nanoseconds();
        let mut states = work()?;
        states.nanoseconds = thread_nanoseconds() - begin;
        Some(states)
    }

    /// Writes the state of a body, number `at` of all, and updates its drifts, given start and inverse scale of energy
    /// and conserved momentum. A sign that is not known is that nearer to the last attitude.
    fn record(
        &mut self,
        body: usize,
        at: usize,
        mut now: State,
        (invariants, last): ([[f64; 2]; 2], &mut [f64; 4]),
    ) {
        self.omega[3 * at..][..3].copy_from_slice(&now.omega);
        let mut units = 0.0_f64;
        if let Some(direction) = &now.direction {
            units = worse(units, (norm(direction) - 1.0).abs());
            if let Some(vertical) = &mut self.vertical {
                vertical[3 * at..][..3].copy_from_slice(direction);
            }
        }
        let sign_is_free = now.sign_is_free;
        if let (Some(now), Some(attitude)) = (&mut now.attitude, &mut self.attitude) {
            if sign_is_free && (0..4).map(|k| now[k] * last[k]).sum::<f64>() < 0.0 {
                *now = now.map(|x| -x);
            }
            *last = *now;
            units = worse(units, (norm(now) - 1.0).abs());
            attitude[4 * at..][..4].copy_from_slice(now);
        }
        if let (Some(balance), Some(work)) = (&now.balance, &mut self.work) {
            work[at] = balance.work;
        }
        let scales = now.balance.map(|balance| balance.scales);
        for now in [Some(now.invariants), now.invariants_of_attitude].into_iter().flatten() {
            let [energy, momentum] = [0, 1].map(|i| {
                let off = (now[i] - invariants[i][0]).abs();
                match scales {
                    // Of a body at rest that nothing has moved yet both are zero.
                    Some(scales) if off == 0.0 && scales[i].is_finite() => 0.0,
                    Some(scales) => off / (scales[i] + inverse_or_zero(invariants[i][1])),
                    None => off * invariants[i][1],
                }
            });
            self.energy_drift[body] = worse(self.energy_drift[body], energy);
            self.momentum_drift[body] = worse(self.momentum_drift[body], momentum);
        }
        self.unit_drift[body] = worse(self.unit_drift[body], units);
        let finite = now.omega.iter().chain(&now.invariants).all(|x| x.is_finite()) && units.is_finite();
        if !finite {
            self.status[body] = Status::NotFinite;
            // The sign of a NaN is that of the instruction that made it.
            let one_nan = |x: &mut f64| *x = if x.is_nan() { f64::NAN } else { *x };
            self.omega[3 * at..][..3].iter_mut().for_each(one_nan);
            self.vertical.iter_mut().flat_map(|v| &mut v[3 * at..][..3]).for_each(one_nan);
            self.attitude.iter_mut().flat_map(|q| &mut q[4 * at..][..4]).for_each(one_nan);
            self.work.iter_mut().flat_map(|w| &mut w[at..][..1]).for_each(one_nan);
            for drift in [&mut self.energy_drift, &mut self.momentum_drift, &mut self.unit_drift] {
                one_nan(&mut drift[body]);
            }
        } else if self.status[body] == Status::Finished {
            let drifts = [self.energy_drift[body], self.momentum_drift[body], self.unit_drift[body]];
            // A NaN is not below the limit.
            if !drifts.iter().all(|&drift| drift <= DRIFT_LIMIT) {
                self.status[body] = Status::Drifted;
            }
        }
    }
}

/// What moves: no more than what is recorded needs.
fn system_of(request: &Request, outside: Option<&Outside>, seat: Seat) -> System {
    if let Some(outside) = outside {
        let bare = !request.is_top && request.record == Record::Rates && !outside.acts_in_space();
        return if bare { System::DrivenRates } else { System::DrivenFrame };
    }
    match (request.is_top, request.record) {
        (false, Record::Rates) => System::FreeRates,
        (false, Record::Axis) => System::FreeAxis,
        (false, Record::Attitude) => System::FreeAttitude,
        (true, Record::Rates | Record::Axis) if seat.is_spin_free() => System::SpinFreeAxis,
        (true, Record::Rates | Record::Axis) => System::TopAxis,
        (true, Record::Attitude) => match (seat.is_spin_free(), seat.table.carries_rows()) {
            (false, false) => System::TopAttitude,
            (false, true) => System::TopTwoAxes,
            (true, false) => System::SpinFreeAttitude,
            (true, true) => System::SpinFreeTwoAxes,
        },
    }
}

/// Start and inverse scale of energy and conserved momentum of the body in a lane.
fn invariants_at_start(group: &Group, lane: usize) -> [[f64; 2]; 2] {
    [&group.energy, &group.momentum].map(|rows| [rows.start.0[lane], rows.inverse_scale.0[lane]])
}

/// The scale that this is the inverse of; zero if there is none.
fn inverse_or_zero(inverse: f64) -> f64 {
    if inverse > 0.0 && inverse.is_finite() { 1.0 / inverse } else { 0.0 }
}

/// The larger of two errors; a NaN is worse than any number.
fn worse(old: f64, new: f64) -> f64 {
    if new <= old || old.is_nan() { old } else { new }
}

fn norm<const N: usize>(v: &[f64; N]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
