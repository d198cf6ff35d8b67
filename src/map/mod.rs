//! The Monte Carlo map: blocks of samples are drawn, classified and counted.

mod check;
mod classify;
mod criterion;
mod draw;
mod integrate;
mod interval;
mod joined;
mod measure;
mod regular;
mod request;
mod sketch;
mod statistics;

pub use check::Check;
pub use criterion::Criterion;
pub use draw::{Laws, Mixed, OF_START};
pub use interval::{clopper_pearson, clopper_pearson_of_each};
pub use joined::{Condition, Logic, MOST_CONDITIONS};
pub use measure::{Measure, Quantity, Value};
pub use regular::{DEVIATIONS, PARTS, Rule, SECOND as SECOND_OF_GROWTH, deviation_start};
pub use request::{Map, Pixel, PlannedRun};
pub use sketch::{Bin, Sketch};
pub use statistics::{Class, Column, FIXED_POINT, Field, Outcome, Statistics};

use crate::error::Error;
use crate::forces::{BodyForces, ForceSet, OrbitPlace};
use crate::kernel::{Kernel, KernelAssignment, Needs, System};
use crate::memory;
use crate::method::{self, AnyMethod, Method, Step, default_step};
use crate::observe::{Observed, Tilt};
use crate::parallel::{Interrupt, over_blocks, thread_nanoseconds};
use crate::simd::Isa;
use crate::start::Body;
use check::Runs;
use classify::ClosedFormClassifier;
use integrate::{RUNS, Run};
use joined::Joined;
use measure::Own;
use statistics::Sample;
use std::ops::{Deref, Range};
use std::slice;
use std::sync::Mutex;

/// A sample takes whole blocks of this many steps and may stop after each. What is observed at the ends of blocks then
/// depends on the sample alone, whoever shares its group.
pub const STEP_BLOCK: u64 = 16;

/// Steps of the run that checks a sample, over those of its first run, both by the default method: its errors are six times
/// as large, so that both runs err alike by chance only, and it costs less.
const SECOND_SHARE: f64 = 0.8;

/// A sample that is integrated over the anomaly of its orbit.
#[derive(Clone, Copy)]
struct OnOrbit {
    /// Where it begins.
    place: OrbitPlace,
    /// The bound of its rates over the pace of the anomaly.
    rate: f64,
    /// The pace by which a step of the time becomes one of the anomaly; see [`crate::forces::Orbit::pace`].
    pace: f64,
}

/// Cost of a classification in closed form in units of RK4 steps, to share the processor time of a block.
const EXACT_AS_STEPS: u64 = 20;

/// Samples of a block: a millisecond of work or more.
const BLOCK: u64 = 1024;

/// The class of a sample, the outcome of its first run, and that of its second.
pub type Verdict = (Class, Outcome, Option<Outcome>);

/// The verdict of a sample that was not run.
pub const NO_VERDICT: Verdict = (Class::Failed, Outcome::REFUSED, None);

/// The class of a condition of a sample, and the time at which its first run left it.
pub type Part = (Class, f64);

/// A pixel with its statistics.
type PixelStatistics = (u64, Statistics);

impl Map {
    /// Samples of the whole map; `checked` has seen that the product fits.
    pub fn len(&self) -> u64 {
        self.pixels.len() as u64 * self.samples
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Pixel and sample of a range in pixel-major order. Counted, not divided: a division costs as much as a draw.
    fn pixels_and_samples(&self, range: Range<u64>) -> impl Iterator<Item = (u64, u64)> {
        let (mut pixel, mut sample) = (range.start / self.samples, range.start % self.samples);
        let samples = self.samples;
        range.map(move |_| {
            let this = (pixel, sample);
            sample += 1;
            if sample == samples {
                (pixel, sample) = (pixel + 1, 0);
            }
            this
        })
    }

    /// The map as each of its conditions sees it.
    fn each_watched(&self) -> impl Iterator<Item = Watched<'_>> {
        self.conditions.iter().map(|&Condition { criterion, axis }| Watched {
            map: self,
            criterion,
            axis,
            is_stopped: true,
        })
    }

    /// Statistics of the samples `start .. stop` in pixel-major order, for the pixels that they touch, and the sketches of
    /// the measures, pixel by pixel.
    ///
    /// # Errors
    /// If the statistics do not fit into memory, or `interrupt` is set.
    pub fn run(
        &self,
        start: u64,
        stop: u64,
        threads: usize,
        isa: Isa,
        interrupt: &Interrupt,
    ) -> Result<(u64, Vec<Statistics>, Vec<Sketch>), Error> {
        let first = start / self.samples;
        // As many as there are pixels at most, which are in memory.
        let pixels = (stop.div_ceil(self.samples) - first) as usize;
        let measures = self.measures.len();
        let statistics = memory::filled("statistics of the pixels", pixels, Statistics::NONE)?;
        let sketches = memory::filled("measures of the pixels", pixels * measures, Sketch::NONE)?;
        let all = Mutex::new((statistics, sketches));
        let block = BLOCK.min((stop - start).div_ceil(threads as u64)).max(1);
        let count = (stop - start).div_ceil(block);
        over_blocks(0..count, threads, interrupt, |b| {
            // No block begins within a group of samples, whose outcomes hang together.
            let [begin, end] = [b, b + 1].map(|b| self.group_begin(stop.min(start + b * block)));
            let end = if b + 1 == count { stop } else { end };
            let (pixels, sketches) = self.block(begin.max(start), end.max(start), isa, interrupt)?;
            let mut all = all.lock().expect("merging does not panic");
            for (index, (pixel, statistics)) in pixels.into_iter().enumerate() {
                let at = (pixel - first) as usize;
                all.0[at].merge(&statistics);
                for (k, sketch) in sketches[index * measures..(index + 1) * measures].iter().enumerate() {
                    all.1[at * measures + k].merge(sketch)?;
                }
            }
            Ok(())
        })?;
        let (statistics, sketches) = all.into_inner().expect("merging does not panic");
        Ok((first, statistics, sketches))
    }

    /// The statistics of one block, by pixel, and the sketches of its measures.
    fn block(
        &self,
        start: u64,
        stop: u64,
        isa: Isa,
        interrupt: &Interrupt,
    ) -> Result<(Vec<PixelStatistics>, Vec<Sketch>), Error> {
        let begin = thread_nanoseconds();
        let classified = self.classified(start..stop, isa, interrupt)?;
        let measured = self.measured(start..stop, isa, interrupt)?;
        let (mut pixels, mut sketches): (Vec<PixelStatistics>, Vec<Sketch>) = Default::default();
        for (at, (pixel, _)) in self.pixels_and_samples(start..stop).enumerate() {
            if pixels.last().is_none_or(|&(last, _)| last != pixel) {
                memory::push("statistics of a block", &mut pixels, (pixel, Statistics::NONE))?;
                for _ in &self.measures {
                    memory::push("measures of a block", &mut sketches, Sketch::NONE)?;
                }
            }
            let statistics = &mut pixels.last_mut().expect("pushed above").1;
            let first = sketches.len() - self.measures.len();
            let mut added = Ok(());
            self.with_sample(&classified, start + at as u64, |sample, _| {
                statistics.add(sample);
                for (number, sketch) in sketches[first..].iter_mut().enumerate() {
                    let (value, steps) = self.value(number, sample, &measured, at);
                    statistics.steps += steps;
                    if let Err(error) = sketch.add(&value) {
                        added = Err(error);
                    }
                }
            });
            added?;
        }
        let elapsed = (thread_nanoseconds() - begin) as f64;
        // A closed form costs about what some tens of steps do.
        let work = |s: &Statistics| (s.steps + EXACT_AS_STEPS * s.exact) as f64;
        let total: f64 = pixels.iter().map(|(_, s)| work(s)).sum();
        for (_, statistics) in &mut pixels {
            statistics.nanoseconds = elapsed * work(statistics) / total.max(1.0);
        }
        Ok((pixels, sketches))
    }

    /// The value of a measure of a sample, and the steps of its own runs.
    #[inline(always)]
    fn value(
        &self,
        number: usize,
        sample: &Sample,
        measured: &[Vec<Option<Own>>],
        at: usize,
    ) -> (Value, u64) {
        let own = measured[number].get(at).and_then(Option::as_ref);
        let of_growth = self.conditions.iter().any(|one| one.criterion.rule().is_some());
        (self.measures[number].value(sample, own, of_growth), own.map_or(0, |own| own.steps))
    }

    /// Samples of strictly ascending flat numbers: each with its classification and the outcome of its first run, with the
    /// bits of the map; and the class of each of its conditions, with the time at which the first run left it.
    ///
    /// # Errors
    /// If they do not fit into memory, or `interrupt` is set.
    pub fn samples_at(
        &self,
        flat: &[u64],
        threads: usize,
        isa: Isa,
        interrupt: &Interrupt,
    ) -> Result<(Vec<Verdict>, Vec<Part>), Error> {
        const VERDICTS: &str = "outcomes of the samples";
        // Samples of one group are classified together, and neighbours side by side.
        let parts = parts(flat, |sample, later| self.belong_together(sample, later))?;
        let count = self.conditions.len();
        let verdicts = memory::filled(VERDICTS, flat.len(), NO_VERDICT)?;
        let nothing = (Class::Failed, f64::INFINITY);
        let all =
            Mutex::new((verdicts, memory::filled(VERDICTS, flat.len().saturating_mul(count), nothing)?));
        over_blocks(0..parts.len() as u64, threads, interrupt, |part| {
            let part = parts[part as usize].clone();
            let classified = self.classified(flat[part.start]..flat[part.end - 1] + 1, isa, interrupt)?;
            let mut all = all.lock().expect("copying does not panic");
            for at in part.clone() {
                self.with_sample(&classified, flat[at], |sample, parts| {
                    all.0[at] = (sample.class, *sample.first, sample.second.copied());
                    for (known, part) in all.1[at * count..].iter_mut().zip(parts) {
                        *known = (part.class, part.first.left);
                    }
                });
            }
            interrupt.tell(part.len() as f64);
            Ok(())
        })?;
        Ok(all.into_inner().expect("copying does not panic"))
    }

    /// The values of the measures of samples of strictly ascending flat numbers, sample by sample, and the steps of the runs
    /// of the measures. What follows from the classification of the samples is NaN for those beyond `known`.
    ///
    /// # Errors
    /// As [`Map::samples_at`].
    pub fn values_at(
        &self,
        flat: &[u64],
        known: &[Verdict],
        threads: usize,
        isa: Isa,
        interrupt: &Interrupt,
    ) -> Result<(Vec<Value>, Vec<u64>), Error> {
        const VALUES: &str = "values of the samples";
        let measures = self.measures.len();
        let parts = parts(flat, |sample, later| later == sample + 1)?;
        let values = memory::filled(VALUES, flat.len().saturating_mul(measures), Value::NONE)?;
        let all = Mutex::new((values, memory::filled(VALUES, flat.len(), 0)?));
        over_blocks(0..parts.len() as u64, threads, interrupt, |part| {
            let part = parts[part as usize].clone();
            let measured = self.measured(flat[part.start]..flat[part.end - 1] + 1, isa, interrupt)?;
            let mut all = all.lock().expect("copying does not panic");
            for (index, at) in part.enumerate() {
                let (class, first, second) = known.get(at).unwrap_or(&NO_VERDICT);
                let (class, second) = (*class, second.as_ref());
                let sample = Sample { class, first, second, audited: false, t_end: self.t_end };
                for k in 0..measures {
                    let (value, steps) = self.value(k, &sample, &measured, index);
                    all.0[at * measures + k] = value;
                    all.1[at] += steps;
                }
            }
            Ok(())
        })?;
        Ok(all.into_inner().expect("copying does not panic"))
    }

    /// Whether a sample and a later one are classified in one go.
    fn belong_together(&self, sample: u64, later: u64) -> bool {
        let group_ends = |watched: Watched| watched.with_groups(sample..sample + 1).end;
        later == sample + 1 || self.each_watched().any(|watched| later < group_ends(watched))
    }

    /// The samples of a range with their outcomes, by condition.
    fn classified(
        &self,
        range: Range<u64>,
        isa: Isa,
        interrupt: &Interrupt,
    ) -> Result<Vec<Classified>, Error> {
        let mut all = memory::reserved(RUNS, self.conditions.len())?;
        for watched in self.each_watched() {
            all.push(watched.classified(range.clone(), isa, interrupt)?);
        }
        Ok(all)
    }

    /// Calls a function with a sample as the statistics see it and with its conditions, unless its pixel has no body.
    #[inline(always)]
    fn with_sample(&self, all: &[Classified], flat: u64, mut see: impl FnMut(&Sample, &[Sample])) {
        let (t_end, index) = (self.t_end, |one: &Classified| (flat - one.range.start) as usize);
        let Some(alone) = all[0].sample(index(&all[0]), t_end) else { return };
        let (mut each, joined);
        let (sample, parts) = if all.len() == 1 && self.logic.is_single() {
            (alone, slice::from_ref(&alone))
        } else {
            each = [alone; MOST_CONDITIONS];
            for (part, one) in each.iter_mut().zip(all) {
                *part = one.sample(index(one), t_end).expect("a body is possible whatever is asked of it");
            }
            joined = self.logic.joined(&each[..all.len()]);
            let Joined { class, first, second, audited } = &joined;
            let (class, second, audited) = (*class, second.as_ref(), *audited);
            (Sample { class, first, second, audited, t_end }, &each[..all.len()])
        };
        // Called once, so that the compiler keeps the sample in registers.
        see(&sample, parts)
    }
}

/// Ascending samples in parts of consecutive ones that belong together, a block at most.
fn parts(flat: &[u64], belong_together: impl Fn(u64, u64) -> bool) -> Result<Vec<Range<usize>>, Error> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    for (at, &sample) in flat.iter().enumerate() {
        match parts.last_mut() {
            Some(part) if (part.len() as u64) < BLOCK && belong_together(flat[at - 1], sample) => {
                part.end = at + 1;
            }
            _ => memory::push("parts of the samples", &mut parts, at..at + 1)?,
        }
    }
    Ok(parts)
}

/// A map with the one of its conditions that is watched.
#[derive(Clone, Copy)]
struct Watched<'a> {
    map: &'a Map,
    criterion: Criterion,
    axis: i32,
    /// Whether a run ends where it leaves stability.
    is_stopped: bool,
}

impl Deref for Watched<'_> {
    type Target = Map;

    #[inline(always)]
    fn deref(&self) -> &Map {
        self.map
    }
}

impl Watched<'_> {
    /// How a run of a sample is assigned to a kernel: over the anomaly of the orbit, if an orbit alone acts and its method has
    /// such steps.
    fn assignment(&self, body: &Body, forces: BodyForces, cross_check: bool) -> KernelAssignment {
        let method = self.method(cross_check);
        let on_orbit = self.is_on_orbit(forces).then(|| KernelAssignment::on_orbit(method)).flatten();
        on_orbit.unwrap_or_else(|| KernelAssignment::of_either(self.is_forced(), method, body, self.scene))
    }

    /// The kernel of a sample under these forces with that step: its system carries what acts on the sample, what the
    /// criterion watches, and no more. The bits of a sample do not depend on what acts on others.
    fn kernel(&self, step: Step, forces: BodyForces) -> Kernel {
        let needs = Needs {
            forces: ForceSet { act: self.is_forced(), ..ForceSet::from(forces) },
            directions: self.criterion.directions(self.scene),
            attitude: false,
            tangent: self.criterion.rule().is_some(),
            is_changed: false,
        };
        Kernel { system: System::carrying(self.scene, step, needs), step, observed: self.observed(step) }
    }

    /// The observable of the samples with that step. Over an anomaly the pointing is a tilt from the frame of the orbit.
    fn observed(&self, step: Step) -> Observed {
        let tilt = self.criterion.bound().filter(|_| step.is_on_clock()).and_then(Tilt::of);
        tilt.map_or_else(|| self.criterion.observed(), Observed::Tilt)
    }

    /// The method of a run of a sample.
    fn method(&self, cross_check: bool) -> &'static Method {
        let method = self.map.method.by_steps();
        match (cross_check, self.criterion.rule()) {
            (false, _) => method,
            (true, Some(_)) => regular::SECOND,
            // Few methods integrate the torque of a function: the same takes other steps.
            (true, None) if self.calls_functions() => method,
            (true, None) => method.second(self.is_forced()),
        }
    }

    /// Number of steps of a run of a sample over a time, or over the anomaly from a place: whole blocks, no step longer than
    /// the map allows; above `max_steps` if the rates need that many. A cross-check takes steps of its own: those of the
    /// default method are longer than in the first run, or as long where the map takes another method. It makes at most half
    /// the step that was asked for or, unless it is of regularity, that the same method makes in the first run.
    fn steps_of(
        &self,
        body: &Body,
        forces: BodyForces,
        cross_check: bool,
        (on_orbit, span): (Option<OnOrbit>, f64),
    ) -> u64 {
        let method = self.method(cross_check);
        let (is_ruled, is_auto) = (self.criterion.rule().is_some(), self.map.method == AnyMethod::Auto);
        let is_alike = method == self.method(false);
        let pace = on_orbit.map_or(1.0, |on_orbit| on_orbit.pace);
        let rate = match on_orbit {
            Some(on_orbit) => on_orbit.rate,
            None if forces.is_none() => body.neighbours_rate(),
            None => body.step_rate(method, forces, [0.0, self.t_end]),
        };
        let own = match (cross_check, is_ruled) {
            (true, true) => regular::second_step(rate, self.t_end),
            (true, false) if is_auto => self.map.method.default_step(is_ruled, rate) / SECOND_SHARE,
            (true, false) if method == method::SECOND && !is_alike => {
                AnyMethod::Auto.default_step(is_ruled, rate)
            }
            (true, false) => default_step(method, rate),
            _ => self.map.method.default_step(is_ruled, rate),
        };
        let own = own.min(forces.longest_unseen([0.0, self.t_end]));
        let largest = match self.step {
            Some(step) if cross_check => own.min(0.5 * step * pace),
            Some(step) => step * pace,
            None if cross_check && !is_ruled && !is_auto && is_alike => 0.5 * own,
            None => own,
        };
        let [multiple, fewest] = self.whole_steps(cross_check);
        let blocks = (span / largest / multiple as f64).ceil();
        // A NaN or an absurd number becomes one that no limit allows.
        if !(blocks < 1e17) {
            return u64::MAX;
        }
        let steps = (blocks as u64 * multiple).max(fewest);
        let is_same = || steps == self.steps_of(body, forces, false, (on_orbit, span));
        // Equal steps would be the same run.
        if cross_check && is_auto && !is_ruled && is_same() { steps + multiple } else { steps }
    }

    /// The classification from both runs of a sample. A cross-check that would take too many steps has no effect.
    fn classification(first: &Outcome, second: Option<&Outcome>) -> Class {
        match second.filter(|second| second.was_run()) {
            Some(second) => first.class.agreed(second.class),
            None => first.class,
        }
    }

    /// The samples of a range with their outcomes, and those of the groups of samples that the range touches.
    fn classified(&self, range: Range<u64>, isa: Isa, interrupt: &Interrupt) -> Result<Classified, Error> {
        let range = self.with_groups(range);
        let bodies = self.draw(isa, range.clone())?;
        let unknown = || memory::filled("outcomes of a block", bodies.len(), None::<Outcome>);
        let mut outcomes = [unknown()?, Vec::new()];
        let mut classifier = ClosedFormClassifier::new(*self, isa);
        let mut integrated = Vec::new();
        for (index, (pixel, _)) in self.pixels_and_samples(range.clone()).enumerate() {
            if !self.pixels[pixel as usize].possible {
                continue;
            }
            let exact = !self.is_forced()
                && self.method.exact()
                && classifier.take(index, &bodies[index], &mut outcomes[0]);
            if !exact {
                memory::push(RUNS, &mut integrated, index)?;
            }
        }
        classifier.finish(&mut outcomes[0]);
        let mut audited = Vec::new();
        if !integrated.is_empty() {
            let [first, second] = &mut outcomes;
            *second = unknown()?;
            let (starts, run) = ((&bodies[..], range.start), Run { cross_check: false, isa, interrupt });
            self.integrate(starts, &integrated, run, first)?;
            let runs =
                Runs { range: range.clone(), bodies: &bodies, integrated: &integrated, outcomes: first };
            let again = Run { cross_check: true, ..run };
            audited = self.audited(&runs)?;
            self.integrate(starts, &audited, again, second)?;
            let doubtful = self.doubtful(&runs, second)?;
            self.integrate(starts, &doubtful, again, second)?;
        }
        Ok(Classified { range, outcomes, audited })
    }
}

/// Samples with their outcomes.
struct Classified {
    range: Range<u64>,
    /// By the method of the map, and by the second method; none where a pixel has no body or a sample no second run.
    /// The second list is empty if no sample was integrated.
    outcomes: [Vec<Option<Outcome>>; 2],
    /// Samples with a second run whatever their first, ascending.
    audited: Vec<usize>,
}

impl Classified {
    /// A sample as the statistics see it; `None` where the pixel has no body.
    #[inline(always)]
    fn sample(&self, index: usize, t_end: f64) -> Option<Sample<'_>> {
        let first = self.outcomes[0][index].as_ref()?;
        let second = self.outcomes[1].get(index).and_then(Option::as_ref);
        let audited = self.audited.binary_search(&index).is_ok();
        Some(Sample { class: Watched::classification(first, second), first, second, audited, t_end })
    }
}
