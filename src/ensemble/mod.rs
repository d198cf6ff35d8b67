//! The Monte Carlo map: a block from its samples to its statistics, finished lanes refilled on the way.

mod closed;
mod draw;

use crate::clock::thread_nanoseconds;
use crate::error::Error;
use crate::group::{Drives, Group, LANES};
use crate::kernel::{Compiled, Kernel, System, Table, Watch};
use crate::method::Method;
use crate::observe::{TiltLimit, largest_tilt};
use crate::outside::Outside;
use crate::run::over_blocks;
use crate::sample::Law;
use crate::simd::Isa;
use crate::start::{Body, Seat, load, widen_scales};
use crate::trajectory::{DRIFT_LIMIT, Solver, Status};
use closed::Referee;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// A sample takes whole bursts of this many steps; after each it may stop. What is seen at the ends of bursts
/// then depends on the sample alone, whoever shares its group.
pub const BURST: u64 = 16;

/// A verdict in closed form in units of RK4 steps, to share the processor time of a block.
const EXACT_AS_STEPS: u64 = 20;

/// Samples of a block: a millisecond of work or more.
const BLOCK: u64 = 1024;

/// When a sample counts as stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// The component of the rates along the watched axis never changes sign.
    NoFlip,
    /// The watched axis stays within this angle of where it started.
    TiltFromStart(f64),
    /// The watched axis stays within this angle of the vertical.
    TiltFromVertical(f64),
}

/// The nominal body of a pixel and the size of its cloud.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Body and nominal start.
    pub body: Body,
    /// Size of the perturbation of each rate.
    pub omega_size: [f64; 3],
    /// Size of the perturbation of the attitude (rad).
    pub attitude_size: f64,
    /// Whether such a body exists.
    pub possible: bool,
}

/// How the samples of a map are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judge {
    /// In closed form where there is one, else by the default scheme.
    Auto,
    /// As said; a sample without a closed form is then not possible.
    Only(Solver),
}

impl Judge {
    /// The name that leaves the choice to each sample.
    pub const AUTO: &str = "auto";

    /// The judge of that name.
    pub fn parse(name: &str) -> Result<Judge, Error> {
        if name == Judge::AUTO { Ok(Judge::Auto) } else { Solver::parse(name).map(Judge::Only) }
    }

    /// Whether closed forms are used.
    fn exact(self) -> bool {
        matches!(self, Judge::Auto | Judge::Only(Solver::Exact))
    }

    /// The scheme of what has no closed form.
    pub fn method(self) -> Method {
        match self {
            Judge::Only(Solver::Steps(method)) => method,
            _ => Method::Rk4,
        }
    }
}

/// Everything that the statistics of a map depend on.
#[derive(Clone, Debug)]
pub struct Map {
    /// Whether the bodies have weight.
    pub is_top: bool,
    /// How the samples are judged.
    pub judge: Judge,
    /// The pixels.
    pub pixels: Vec<Pixel>,
    /// Law of the perturbation of the rates.
    pub omega_law: Law,
    /// Law of the perturbation of the attitude.
    pub attitude_law: Law,
    /// When a sample is stable.
    pub criterion: Criterion,
    /// The watched body axis: 1, 2, 3 or -1, -2, -3.
    pub axis: i32,
    /// Horizon.
    pub t_end: f64,
    /// Largest step; `None` leaves it to the bound of each sample's rates.
    pub step: Option<f64>,
    /// Most steps that a sample may take.
    pub max_steps: u64,
    /// Samples of each pixel.
    pub samples: u64,
    /// How many of them, the first, are judged again by the second method.
    pub checked: u64,
    /// Key of the random numbers.
    pub key: [u64; 2],
}

/// The verdict on a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Stayed stable until the horizon.
    Stable,
    /// Left stability before.
    Unstable,
    /// The second method disagrees.
    Undecided,
    /// No verdict: step limit, not finite, or drifted.
    Failed,
}

impl Class {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Class::Stable => "stable",
            Class::Unstable => "unstable",
            Class::Undecided => "undecided",
            Class::Failed => "failed",
        }
    }
}

/// What one run of one sample gave.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Stable, unstable or failed.
    pub class: Class,
    /// How it ended.
    pub status: Status,
    /// Sign changes seen.
    pub flips: u64,
    /// When stability was lost, infinite if it was not.
    pub left: f64,
    /// Largest tilt, NaN if none is watched (rad).
    pub tilt: f64,
    /// Largest relative energy error at the ends of bursts.
    pub energy_drift: f64,
    /// Largest relative error of the conserved momentum at the ends of bursts.
    pub momentum_drift: f64,
    /// Step.
    pub step: f64,
    /// Steps made.
    pub steps: u64,
    /// Judged in closed form: nothing drifts, and there are no steps.
    pub exact: bool,
}

/// The statistics of a pixel. All merge without order: sums of whole numbers, largest, smallest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Samples that stayed stable.
    pub stable: u64,
    /// Samples that did not.
    pub unstable: u64,
    /// Samples on whose verdict the second method disagrees.
    pub undecided: u64,
    /// Samples without a verdict.
    pub failed: u64,
    /// Of these, the samples that would have needed too many steps.
    pub step_limit: u64,
    /// Of these, the samples that overflowed.
    pub not_finite: u64,
    /// Of these, the samples that lost an invariant.
    pub drifted: u64,
    /// Samples judged in closed form.
    pub exact: u64,
    /// Samples judged again by the second method.
    pub checked: u64,
    /// Largest energy drift, NaN if nothing was run.
    pub energy_drift: f64,
    /// Largest momentum drift, NaN if nothing was run.
    pub momentum_drift: f64,
    /// Earliest loss of stability seen; infinite if none.
    pub earliest: f64,
    /// Steps of all runs.
    pub steps: u64,
    /// Processor time: measured, not reproducible.
    pub nanoseconds: f64,
}

impl Statistics {
    fn none() -> Self {
        // `max` passes over a NaN: it stays only where nothing was run.
        let unknown = f64::NAN;
        Statistics {
            energy_drift: unknown,
            momentum_drift: unknown,
            earliest: f64::INFINITY,
            ..Default::default()
        }
    }

    fn merge(&mut self, other: &Statistics) {
        self.stable += other.stable;
        self.unstable += other.unstable;
        self.undecided += other.undecided;
        self.failed += other.failed;
        self.step_limit += other.step_limit;
        self.not_finite += other.not_finite;
        self.drifted += other.drifted;
        self.exact += other.exact;
        self.checked += other.checked;
        self.energy_drift = self.energy_drift.max(other.energy_drift);
        self.momentum_drift = self.momentum_drift.max(other.momentum_drift);
        self.earliest = self.earliest.min(other.earliest);
        self.steps += other.steps;
        self.nanoseconds += other.nanoseconds;
    }

    fn add(&mut self, verdict: Class, outcome: &Outcome, checked: bool) {
        match verdict {
            Class::Stable => self.stable += 1,
            Class::Unstable => self.unstable += 1,
            Class::Undecided => self.undecided += 1,
            Class::Failed => self.failed += 1,
        }
        self.step_limit += u64::from(outcome.status == Status::StepLimit);
        self.not_finite += u64::from(outcome.status == Status::NotFinite);
        self.drifted += u64::from(outcome.status == Status::Drifted);
        self.checked += u64::from(checked);
        self.exact += u64::from(outcome.exact);
        // A sample that was not run has no drift: `max` passes over its NaN. One that overflowed lost all.
        let lost = |drift: f64| if drift.is_nan() && outcome.took_steps() { f64::INFINITY } else { drift };
        self.energy_drift = self.energy_drift.max(lost(outcome.energy_drift));
        self.momentum_drift = self.momentum_drift.max(lost(outcome.momentum_drift));
        if verdict == Class::Unstable {
            self.earliest = self.earliest.min(outcome.left);
        }
    }
}

/// One run: which sample, by the method of the map or by the second one.
#[derive(Clone, Copy)]
struct Job {
    /// Place in the block.
    index: usize,
    again: bool,
}

/// The method that judges a sample again: of high order, so that it is right where the other is not. Half the step of
/// the same method would share its error: of order 2, one wrong verdict in four would pass.
const SECOND: Method = Method::Taylor16;

/// A body in a lane.
#[derive(Clone, Copy)]
struct Passenger {
    job: Job,
    step: f64,
}

impl Map {
    /// Samples of the whole map.
    pub fn len(&self) -> u64 {
        self.pixels.len() as u64 * self.samples
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Pixel and sample of a range in pixel-major order. Counted, not divided: a division costs as much as a draw.
    fn places(&self, range: Range<u64>) -> impl Iterator<Item = (u64, u64)> {
        let (mut pixel, mut sample) = (range.start / self.samples, range.start % self.samples);
        let samples = self.samples;
        range.map(move |_| {
            let place = (pixel, sample);
            sample += 1;
            if sample == samples {
                (pixel, sample) = (pixel + 1, 0);
            }
            place
        })
    }

    /// The first pixel with a possible body whose verdict has no closed form.
    pub fn first_without_closed_form(&self) -> Option<usize> {
        self.pixels.iter().position(|pixel| pixel.possible && !closed::answers(self, &pixel.body))
    }

    /// What the samples of a pixel are moved by.
    fn seat(&self, body: &Body, driven: bool, again: bool) -> Seat {
        let method = self.method(driven, again);
        if driven { Seat::of_driven(method, body) } else { Seat::of(method, body, self.is_top) }
    }

    /// Refuses what acts from outside where the samples cannot be watched or moved so; one for each pixel.
    ///
    /// # Errors
    /// Naming the argument.
    pub fn check_driven(&self, outside: &[Outside]) -> Result<(), Error> {
        let method = self.judge.method();
        let name = method.facts().name;
        let refuse = |argument, value, rule| Err(Error::Value { argument, value, rule });
        let Some(limit) = method.damping_limit() else {
            return refuse("method", format!("'{name}'"), "moves bodies without torque and damping only");
        };
        if let Criterion::TiltFromStart(_) = self.criterion {
            let rule = "under torque and damping only the tilt from the vertical is watched";
            return refuse("reference", "'start'".to_string(), rule);
        }
        if outside.iter().any(|outside| !outside.knots().is_empty()) {
            return refuse("torque", "a table".to_string(), "must be constant in a map");
        }
        if let Some(step) = self.step {
            for (pixel, outside) in self.pixels.iter().zip(outside).filter(|(pixel, _)| pixel.possible) {
                let [.., rate] = outside.damping_rates(pixel.body.moments);
                if step * rate > limit {
                    return Err(Error::Unstable { step, rate, name, longest: limit / rate });
                }
            }
        }
        Ok(())
    }

    fn kernel(&self, table: Table, outside: Option<&[Outside]>) -> Kernel {
        if let Some(outside) = outside {
            let bare = !self.is_top && !outside.iter().any(Outside::acts_in_space);
            let (system, watch) = match self.criterion {
                Criterion::NoFlip if bare => (System::DrivenRates, Watch::Flips),
                Criterion::NoFlip => (System::DrivenFrame, Watch::Flips),
                _ => (System::DrivenFrame, Watch::Tilt),
            };
            return Kernel { system, table, watch };
        }
        let (system, watch) = match (self.is_top, self.criterion) {
            (false, Criterion::NoFlip) => (System::FreeRates, Watch::Flips),
            (false, _) => (System::FreeAxis, Watch::Tilt),
            (true, Criterion::NoFlip) => (System::TopAxis, Watch::Flips),
            (true, Criterion::TiltFromVertical(_)) => (System::TopAxis, Watch::Tilt),
            (true, Criterion::TiltFromStart(_)) => (System::TopTwoAxes, Watch::Tilt),
        };
        Kernel { system, table, watch }
    }

    /// The method of a run of a sample. Where one for strong damping was asked for, an explicit one could need a
    /// thousand times the steps.
    fn method(&self, driven: bool, again: bool) -> Method {
        match self.judge.method() {
            method if !again => method,
            Method::Splitting | Method::Etd4 if driven => Method::Etd4,
            _ => SECOND,
        }
    }

    /// Steps of a run of a sample: whole bursts, none longer than asked; more than `max_steps` if the rates need it.
    /// The second method takes its own, and half of those that were asked for or are the same.
    fn steps_of(&self, body: &Body, outside: Option<&Outside>, again: bool) -> u64 {
        let method = self.method(outside.is_some(), again);
        let rate = body.step_rate(method, outside, [0.0, self.t_end]);
        let own = if rate > 0.0 { method.facts().angle_per_step / rate } else { self.t_end };
        let largest = match self.step {
            Some(step) if again => own.min(0.5 * step),
            Some(step) => step,
            None if again && method == self.judge.method() => 0.5 * own,
            None => own,
        };
        let bursts = (self.t_end / largest / BURST as f64).ceil().max(1.0);
        // A NaN or an absurd number becomes one that no limit allows.
        if bursts < 1e18 { bursts as u64 * BURST } else { u64::MAX }
    }

    /// The verdict from both runs of a sample. A second run that would take too many steps says nothing.
    fn verdict(first: &Outcome, second: Option<&Outcome>) -> Class {
        match second.filter(|second| second.was_run()) {
            Some(second) if first.class != Class::Failed && second.class != first.class => Class::Undecided,
            _ => first.class,
        }
    }

    /// Statistics of the samples `start .. stop` in pixel-major order, for the pixels that they touch; `None` if
    /// interrupted.
    pub fn run(
        &self,
        start: u64,
        stop: u64,
        threads: usize,
        isa: Isa,
        interrupt: &AtomicBool,
    ) -> Option<(u64, Vec<Statistics>)> {
        self.run_driven(None, start, stop, threads, isa, interrupt)
    }

    /// The same under what acts from outside on the bodies of each pixel.
    pub fn run_driven(
        &self,
        outside: Option<&[Outside]>,
        start: u64,
        stop: u64,
        threads: usize,
        isa: Isa,
        interrupt: &AtomicBool,
    ) -> Option<(u64, Vec<Statistics>)> {
        let first = start / self.samples;
        let last = stop.div_ceil(self.samples);
        let mut all = vec![Statistics::none(); (last - first) as usize];
        let block = BLOCK.min((stop - start).div_ceil(threads as u64)).max(1);
        let blocks = (stop - start).div_ceil(block) as usize;
        let parts = over_blocks(blocks, threads, interrupt, |b| {
            let begin = start + b as u64 * block;
            self.block(outside, begin, stop.min(begin + block), isa, interrupt)
        });
        for part in parts {
            for (pixel, statistics) in part?? {
                all[(pixel - first) as usize].merge(&statistics);
            }
        }
        Some((first, all))
    }

    /// The statistics of one block, by pixel; `None` if interrupted.
    fn block(
        &self,
        outside: Option<&[Outside]>,
        start: u64,
        stop: u64,
        isa: Isa,
        interrupt: &AtomicBool,
    ) -> Option<Vec<(u64, Statistics)>> {
        let begin = thread_nanoseconds();
        let bodies = self.draw(isa, start..stop);
        let mut outcomes: [Vec<Option<Outcome>>; 2] = [vec![None; bodies.len()], Vec::new()];
        let mut referee = Referee::new(self, isa);
        let mut jobs = Table::ALL.map(|_| Vec::new());
        for (index, (pixel, sample)) in self.places(start..stop).enumerate() {
            if self.pixels[pixel as usize].possible {
                if outside.is_none()
                    && self.judge.exact()
                    && referee.take(index, &bodies[index], &mut outcomes[0])
                {
                    continue;
                }
                for again in [false, true].into_iter().filter(|again| !again || sample < self.checked) {
                    let table = self.seat(&bodies[index], outside.is_some(), again).table;
                    jobs[table as usize].push(Job { index, again });
                }
            }
        }
        referee.finish(&mut outcomes[0]);
        if jobs.iter().flatten().any(|job| job.again) {
            outcomes[1] = vec![None; bodies.len()];
        }
        for (jobs, table) in jobs.iter().zip(Table::ALL).filter(|(jobs, _)| !jobs.is_empty()) {
            let kernel = self.kernel(table, outside);
            self.ride((&bodies, start), outside, jobs, kernel, isa, interrupt, |job, outcome| {
                outcomes[usize::from(job.again)][job.index] = Some(outcome);
            })?;
        }

        let mut pixels: Vec<(u64, Statistics)> = Vec::new();
        for (index, (pixel, _)) in self.places(start..stop).enumerate() {
            if pixels.last().is_none_or(|&(last, _)| last != pixel) {
                pixels.push((pixel, Statistics::none()));
            }
            let statistics = &mut pixels.last_mut().expect("pushed above").1;
            if let Some(first) = &outcomes[0][index] {
                let second = outcomes[1].get(index).and_then(Option::as_ref);
                let checked = second.is_some_and(Outcome::was_run);
                statistics.add(Map::verdict(first, second), first, checked);
                statistics.steps += first.steps + second.map_or(0, |run| run.steps);
            }
        }
        let elapsed = (thread_nanoseconds() - begin) as f64;
        // A closed form costs about what some tens of steps do.
        let work = |s: &Statistics| (s.steps + EXACT_AS_STEPS * s.exact) as f64;
        let total: f64 = pixels.iter().map(|(_, s)| work(s)).sum();
        for (_, statistics) in &mut pixels {
            statistics.nanoseconds = elapsed * work(statistics) / total.max(1.0);
        }
        Some(pixels)
    }

    /// Runs jobs of one table through a group, refilling each lane as it falls free; `None` if interrupted. The bodies
    /// are those of the samples from `first` on.
    #[allow(clippy::too_many_arguments)] // Who, how, and what then.
    fn ride(
        &self,
        (bodies, first): (&[Body], u64),
        outside: Option<&[Outside]>,
        jobs: &[Job],
        kernel: Kernel,
        isa: Isa,
        interrupt: &AtomicBool,
        mut finish: impl FnMut(Job, Outcome),
    ) -> Option<()> {
        let compiled = Compiled::new(kernel, isa);
        let (mut group, mut drives) = (Group::waiting(), Drives::NONE);
        let mut lanes: [Option<Passenger>; LANES] = [None; LANES];
        // Steps after which each lane is at its horizon; a lane that waits never is.
        let mut target = [f64::INFINITY; LANES];
        let mut jobs = jobs.iter();
        let mut aboard = 0;
        let limit = self.tilt_limit();
        loop {
            for lane in 0..LANES {
                while lanes[lane].is_none() {
                    let Some(&job) = jobs.next() else { break };
                    let body = &bodies[job.index];
                    let outside =
                        outside.map(|all| &all[((first + job.index as u64) / self.samples) as usize]);
                    let steps = self.steps_of(body, outside, job.again);
                    if steps > self.max_steps {
                        finish(job, Outcome::refused());
                        continue;
                    }
                    let step = self.t_end / steps as f64;
                    let seat = self.seat(body, outside.is_some(), job.again);
                    load(&mut group, lane, (kernel, compiled), seat, body, self.axis, step);
                    if let Some(outside) = outside {
                        drives.set(lane, &outside.drive(0.0, false, body.moments));
                        let rate = body.fastest_rate_driven(outside, [0.0, self.t_end]);
                        widen_scales(&mut group, lane, kernel.system, body, rate);
                    }
                    if let Some(limit) = limit {
                        group.limit[0].0[lane] = limit.cosine;
                        group.limit[1].0[lane] = limit.sine2;
                        // Beyond the limit from the start.
                        if group.cosine.0[lane] < limit.cosine || group.sine2.0[lane] > limit.sine2 {
                            group.left.0[lane] = 0.0;
                        }
                    }
                    target[lane] = steps as f64;
                    lanes[lane] = Some(Passenger { job, step });
                    aboard += 1;
                }
            }
            if aboard == 0 {
                return Some(());
            }
            loop {
                if interrupt.load(Ordering::Relaxed) {
                    return None;
                }
                compiled.advance_driven(&mut group, &drives, BURST as usize);
                if any_done(&group, &target) {
                    break;
                }
            }
            for lane in 0..LANES {
                let Some(passenger) = lanes[lane] else { continue };
                if done(&group, lane, target[lane]) {
                    finish(passenger.job, self.outcome(&group, lane, passenger));
                    lanes[lane] = None;
                    target[lane] = f64::INFINITY;
                    aboard -= 1;
                    group.wait(lane);
                }
            }
        }
    }

    fn tilt_limit(&self) -> Option<TiltLimit> {
        match self.criterion {
            Criterion::NoFlip => None,
            Criterion::TiltFromStart(angle) | Criterion::TiltFromVertical(angle) => {
                Some(TiltLimit::new(angle))
            }
        }
    }

    /// The outcome of a lane that is done.
    fn outcome(&self, group: &Group, lane: usize, passenger: Passenger) -> Outcome {
        let energy_drift = group.energy.worst.0[lane];
        let momentum_drift = group.momentum.worst.0[lane];
        let steps = group.count.0[lane];
        let left = group.left.0[lane];
        let finite = energy_drift.is_finite() && momentum_drift.is_finite() && group.unit.0[lane].is_finite();
        let (class, status) = if !finite {
            (Class::Failed, Status::NotFinite)
        } else if energy_drift.max(momentum_drift).max(group.unit.0[lane]) > DRIFT_LIMIT {
            (Class::Failed, Status::Drifted)
        } else if left < f64::INFINITY {
            (Class::Unstable, Status::Stopped)
        } else {
            (Class::Stable, Status::Finished)
        };
        Outcome {
            class,
            status,
            flips: group.flips.0[lane] as u64,
            left,
            tilt: match self.criterion {
                Criterion::NoFlip => f64::NAN,
                _ => largest_tilt(group.cosine.0[lane], group.sine2.0[lane]),
            },
            energy_drift,
            momentum_drift,
            step: passenger.step,
            steps: steps as u64,
            exact: false,
        }
    }

    /// One sample alone: its start, its verdict and the outcome of its first run, with the bits of the map.
    /// `None` if interrupted.
    pub fn sample(
        &self,
        pixel: u64,
        sample: u64,
        isa: Isa,
        interrupt: &AtomicBool,
    ) -> Option<(Body, Class, Outcome)> {
        self.sample_driven(None, pixel, sample, isa, interrupt)
    }

    /// The same under what acts from outside on the bodies of each pixel.
    pub fn sample_driven(
        &self,
        outside: Option<&[Outside]>,
        pixel: u64,
        sample: u64,
        isa: Isa,
        interrupt: &AtomicBool,
    ) -> Option<(Body, Class, Outcome)> {
        let flat = pixel * self.samples + sample;
        let body = self.draw(isa, flat..flat + 1)[0];
        if !self.pixels[pixel as usize].possible {
            return Some((body, Class::Failed, Outcome::refused()));
        }
        if outside.is_none() && self.judge.exact() {
            let mut outcome = [None];
            let mut referee = Referee::new(self, isa);
            referee.take(0, &body, &mut outcome);
            referee.finish(&mut outcome);
            if let [Some(outcome)] = outcome {
                return Some((body, outcome.class, outcome));
            }
        }
        let mut outcomes = [None, None];
        for again in [false, true].into_iter().filter(|again| !again || sample < self.checked) {
            let kernel = self.kernel(self.seat(&body, outside.is_some(), again).table, outside);
            let job = Job { index: 0, again };
            self.ride((&[body], flat), outside, &[job], kernel, isa, interrupt, |_, outcome| {
                outcomes[usize::from(again)] = Some(outcome);
            })?;
        }
        let first = outcomes[0].expect("every job is finished");
        Some((body, Map::verdict(&first, outcomes[1].as_ref()), first))
    }
}

impl Outcome {
    fn was_run(&self) -> bool {
        self.status != Status::StepLimit
    }

    fn took_steps(&self) -> bool {
        self.was_run() && !self.exact
    }

    /// A sample that would need more steps than allowed.
    fn refused() -> Outcome {
        Outcome {
            class: Class::Failed,
            status: Status::StepLimit,
            flips: 0,
            left: f64::INFINITY,
            tilt: f64::NAN,
            energy_drift: f64::NAN,
            momentum_drift: f64::NAN,
            step: f64::NAN,
            steps: 0,
            exact: false,
        }
    }
}

/// Whether a lane is at its horizon, has left stability, or is no longer to be believed.
#[inline(always)]
fn done(group: &Group, lane: usize, target: f64) -> bool {
    // Written without short cuts, so that the test of a whole group is a few vector instructions.
    (group.count.0[lane] >= target)
        | (group.left.0[lane] < f64::INFINITY)
        // A NaN is not below the limit either.
        | !(group.energy.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.momentum.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.unit.0[lane] <= DRIFT_LIMIT)
}

fn any_done(group: &Group, target: &[f64; LANES]) -> bool {
    (0..LANES).fold(false, |any, lane| any | done(group, lane, target[lane]))
}
