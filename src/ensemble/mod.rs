//! The Monte Carlo map: a block from its samples to its statistics, finished lanes refilled on the way.

mod closed;
mod draw;
mod ride;
mod statistics;

pub use statistics::{Class, Outcome, Statistics};

use crate::clock::thread_nanoseconds;
use crate::error::Error;
use crate::kernel::{Kernel, System, Table, Watch};
use crate::method::Method;
use crate::outside::Outside;
use crate::run::over_blocks;
use crate::sample::Law;
use crate::simd::Isa;
use crate::start::{Body, Seat};
use crate::trajectory::Solver;
use closed::Referee;
use ride::Job;
use std::ops::Range;
use std::sync::atomic::AtomicBool;

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

/// The method that judges a sample again: of high order, so that it is right where the other is not. Half the step of
/// the same method would share its error: of order 2, one wrong verdict in four would pass.
const SECOND: Method = Method::Taylor16;

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
        if self.judge == Judge::Only(Solver::Exact) {
            let rule = "no verdict in closed form is known under torque and damping";
            return refuse("method", format!("'{}'", Solver::EXACT), rule);
        }
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
            Method::Splitting | Method::Etd4 | Method::Midpoint if driven => Method::Etd4,
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
