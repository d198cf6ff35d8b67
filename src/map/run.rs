//! Blocks of samples on threads: drawn, classified, measured and counted.

use super::measure::Own;
use super::observation::{Classified, RUNS};
use super::statistics::Sample;
use super::{
    Class, Condition, ConditionVerdict, MOST_CONDITIONS, Map, Observation, Sketch, Statistics, Value, Verdict,
};
use crate::call::Call;
use crate::error::Error;
use crate::memory;
use crate::parallel::{over_blocks, thread_nanoseconds};
use std::ops::Range;
use std::slice;
use std::sync::Mutex;

/// Cost of a classification in closed form in units of RK4 steps, to share the processor time of a block.
const EXACT_AS_STEPS: u64 = 20;

/// Samples of a block: a millisecond of work or more.
const BLOCK: u64 = 1024;

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
    pub(super) fn pixels_and_samples(&self, range: Range<u64>) -> impl Iterator<Item = (u64, u64)> {
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
    pub(super) fn observations(&self) -> impl Iterator<Item = Observation<'_>> {
        self.conditions.iter().map(|&Condition { criterion, axis }| Observation {
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
    /// If the statistics do not fit into memory, or the call is stopped.
    pub fn run(
        &self,
        start: u64,
        stop: u64,
        call: Call,
    ) -> Result<(u64, Vec<Statistics>, Vec<Sketch>), Error> {
        let first = start / self.samples;
        // As many as there are pixels at most, which are in memory.
        let pixels = (stop.div_ceil(self.samples) - first) as usize;
        let measures = self.measures.len();
        let statistics = memory::filled("statistics of the pixels", pixels, Statistics::NONE)?;
        let sketches = memory::filled("measures of the pixels", pixels * measures, Sketch::NONE)?;
        let all = Mutex::new((statistics, sketches));
        let block = BLOCK.min((stop - start).div_ceil(call.threads as u64)).max(1);
        let count = (stop - start).div_ceil(block);
        over_blocks(0..count, call.threads, call.stop, |b| {
            // No block begins within a group of samples, whose outcomes hang together.
            let [begin, end] = [b, b + 1].map(|b| self.group_begin(stop.min(start + b * block)));
            let end = if b + 1 == count { stop } else { end };
            let (pixels, sketches) = self.block(begin.max(start), end.max(start), call)?;
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
    fn block(&self, start: u64, stop: u64, call: Call) -> Result<(Vec<PixelStatistics>, Vec<Sketch>), Error> {
        let begin = thread_nanoseconds();
        let classified = self.classified(start..stop, call)?;
        let measured = self.measured(start..stop, call)?;
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
    /// If they do not fit into memory, or the call is stopped.
    pub fn samples_at(
        &self,
        flat: &[u64],
        call: Call,
    ) -> Result<(Vec<Verdict>, Vec<ConditionVerdict>), Error> {
        const VERDICTS: &str = "outcomes of the samples";
        // Samples of one group are classified together, and neighbours side by side.
        let parts = parts(flat, |sample, later| self.belong_together(sample, later))?;
        let count = self.conditions.len();
        let verdicts = memory::filled(VERDICTS, flat.len(), Verdict::NONE)?;
        let nothing = (Class::Failed, f64::INFINITY);
        let all =
            Mutex::new((verdicts, memory::filled(VERDICTS, flat.len().saturating_mul(count), nothing)?));
        over_blocks(0..parts.len() as u64, call.threads, call.stop, |part| {
            let part = parts[part as usize].clone();
            let classified = self.classified(flat[part.start]..flat[part.end - 1] + 1, call)?;
            let mut all = all.lock().expect("copying does not panic");
            for at in part.clone() {
                self.with_sample(&classified, flat[at], |sample, parts| {
                    all.0[at] = sample.verdict();
                    for (known, part) in all.1[at * count..].iter_mut().zip(parts) {
                        *known = (part.class, part.first.left);
                    }
                });
            }
            call.stop.tell(part.len() as f64);
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
        call: Call,
    ) -> Result<(Vec<Value>, Vec<u64>), Error> {
        const VALUES: &str = "values of the samples";
        let measures = self.measures.len();
        let parts = parts(flat, |sample, later| later == sample + 1)?;
        let values = memory::filled(VALUES, flat.len().saturating_mul(measures), Value::NONE)?;
        let all = Mutex::new((values, memory::filled(VALUES, flat.len(), 0)?));
        over_blocks(0..parts.len() as u64, call.threads, call.stop, |part| {
            let part = parts[part as usize].clone();
            let measured = self.measured(flat[part.start]..flat[part.end - 1] + 1, call)?;
            let mut all = all.lock().expect("copying does not panic");
            for (index, at) in part.enumerate() {
                let sample = known.get(at).unwrap_or(&Verdict::NONE).sample(self.t_end);
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
        let group_ends = |one: Observation| one.with_groups(sample..sample + 1).end;
        later == sample + 1 || self.observations().any(|observation| later < group_ends(observation))
    }

    /// The samples of a range with their outcomes, by condition.
    fn classified(&self, range: Range<u64>, call: Call) -> Result<Vec<Classified>, Error> {
        let mut all = memory::reserved(RUNS, self.conditions.len())?;
        for observation in self.observations() {
            all.push(observation.classified(range.clone(), call)?);
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
            (joined.sample(t_end), &each[..all.len()])
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
