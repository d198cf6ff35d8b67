//! Which samples are classified again by the second method.

use super::{Class, Criterion, Map, Observation, Outcome, Quantity};
use crate::body::Body;
use crate::error::Error;
use crate::memory;
use std::ops::Range;

/// The samples of a pixel that are classified again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Those with a smaller number, in the whole map.
    Before(u64),
    /// Those that an error of the first run could have classified otherwise. The error is measured on some samples of
    /// each group, the audited ones.
    Doubtful,
}

impl Check {
    /// Whether a sample with this number is run again whatever its first run.
    pub(super) fn takes(self, number: u64) -> bool {
        match self {
            Check::Before(end) => number < end,
            Check::Doubtful => true,
        }
    }
}

/// Consecutive samples of a pixel with common audits. Their runs err alike: they differ by the perturbation alone.
pub(super) const GROUP: u64 = 64;

/// Audited samples of a group: the first ones, besides the one that ran for the longest time.
const AUDITED: usize = 2;

/// The margin that a verdict needs in order to stand is this many times the root of the largest error of the audited
/// samples (both in rad): samples of a group err alike in regular motion, and differ by decades in chaos. An error of
/// 1e-8 asks for 3e-3 rad, one of 1e-4 for 0.3 rad, and one of 0.01 for nearly all.
const CAUTION: f64 = 30.0;

/// Verdicts with a smaller margin are doubtful whatever the error (rad).
const LEAST_MARGIN: f64 = 0.01;

/// What the lists of samples of a block are called if they do not fit into memory.
const CHECKS: &str = "checks of a block";

/// Samples of a block with the outcomes of their first runs.
pub(super) struct Runs<'a> {
    /// The samples, in pixel-major order.
    pub(super) range: Range<u64>,
    pub(super) bodies: &'a [Body],
    /// Indices of those that were integrated, ascending.
    pub(super) integrated: &'a [usize],
    pub(super) outcomes: &'a [Option<Outcome>],
}

impl Map {
    /// The begin of the group that holds a sample, or the end of the map.
    pub(super) fn group_begin(&self, sample: u64) -> u64 {
        if sample < self.len() { self.group(sample).start } else { self.len() }
    }

    /// The group that holds a sample.
    fn group(&self, sample: u64) -> Range<u64> {
        let (pixel, within) = (sample / self.samples, sample % self.samples);
        let begin = within / GROUP * GROUP;
        let end = self.samples.min(begin + GROUP);
        pixel * self.samples + begin..pixel * self.samples + end
    }
}

impl Observation<'_> {
    /// The check with the criterion considered: only a tilt tells how far from its limit it stayed. A time of leaving that
    /// is measured is checked in every body.
    pub(super) fn resolved_check(&self) -> Check {
        let is_measured = self.measures.iter().any(|measure| measure.quantity == Quantity::TimeToLeave);
        match (self.check, self.criterion) {
            (Check::Doubtful, _) if is_measured => Check::Before(u64::MAX),
            (Check::Doubtful, Criterion::TiltFromStart(_) | Criterion::TiltFromVertical(_)) => {
                Check::Doubtful
            }
            (Check::Doubtful, _) => Check::Before(u64::MAX),
            (check, _) => check,
        }
    }

    /// The range with all samples of the groups that it touches, if these share audits.
    pub(super) fn with_groups(&self, range: Range<u64>) -> Range<u64> {
        if self.resolved_check() != Check::Doubtful || range.is_empty() {
            return range;
        }
        let [first, last] = [range.start, range.end - 1].map(|sample| self.group(sample));
        first.start..last.end
    }

    /// The samples that are classified again in any case, ascending.
    pub(super) fn audited(&self, runs: &Runs) -> Result<Vec<usize>, Error> {
        let mut audited = memory::reserved(CHECKS, runs.integrated.len())?;
        let check = self.resolved_check();
        if check != Check::Doubtful {
            let number = |index: usize| {
                let flat = runs.range.start + index as u64;
                self.counter((flat / self.samples, flat % self.samples))[1]
            };
            audited.extend(runs.integrated.iter().filter(|index| check.takes(number(**index))));
            return Ok(audited);
        }
        for group in self.groups(runs) {
            let begin = audited.len();
            let mut longest: Option<usize> = None;
            for &index in group {
                let Some(outcome) = classified(runs.outcomes, index) else { continue };
                if audited.len() < begin + AUDITED {
                    audited.push(index);
                }
                let lasted = |outcome: &Outcome| outcome.left.min(self.t_end);
                let before = longest.and_then(|index| classified(runs.outcomes, index));
                if before.is_none_or(|before| lasted(before) < lasted(outcome)) {
                    longest = Some(index);
                }
            }
            let longest = longest.filter(|longest| !audited[begin..].contains(longest));
            audited.extend(longest);
            audited[begin..].sort_unstable();
        }
        Ok(audited)
    }

    /// The other samples that an error as large as those of the audited samples of their group could have classified
    /// otherwise. `again` are the outcomes of the audited samples by the second method.
    pub(super) fn doubtful(&self, runs: &Runs, again: &[Option<Outcome>]) -> Result<Vec<usize>, Error> {
        let mut doubtful = memory::reserved(CHECKS, runs.integrated.len())?;
        if self.resolved_check() != Check::Doubtful {
            return Ok(doubtful);
        }
        let rate = |index| self.rate(runs, index);
        for group in self.groups(runs) {
            let mut error = 0.0_f64;
            for &index in group {
                if let (Some(first), Some(second)) = (&runs.outcomes[index], &again[index]) {
                    error = error.max(self.difference(first, second, || rate(index)));
                }
            }
            for &index in group.iter().filter(|&&index| again[index].is_none()) {
                let Some(outcome) = classified(runs.outcomes, index) else { continue };
                let margin = self.margin(outcome, || rate(index));
                if !(margin >= (CAUTION * error.sqrt()).max(LEAST_MARGIN)) {
                    doubtful.push(index);
                }
            }
        }
        Ok(doubtful)
    }

    /// The integrated samples, group by group.
    fn groups<'a>(&self, runs: &Runs<'a>) -> impl Iterator<Item = &'a [usize]> {
        let begin = runs.range.start;
        runs.integrated.chunk_by(move |&a, &b| self.group(begin + a as u64).contains(&(begin + b as u64)))
    }

    /// A bound of the rate of a sample.
    fn rate(&self, runs: &Runs, index: usize) -> f64 {
        let forces = self.forces_of((runs.range.start + index as u64) / self.samples);
        runs.bodies[index].fastest_rate(forces, [0.0, self.t_end])
    }

    /// How far two runs of a sample with this bound of its rate differ (rad); infinite if their classes differ or the
    /// second was not made.
    fn difference(&self, first: &Outcome, second: &Outcome, rate: impl Fn() -> f64) -> f64 {
        match (first.class, second.class) {
            (Class::Stable, Class::Stable) => (first.tilt - second.tilt).abs(),
            (Class::Unstable, Class::Unstable) => rate() * (first.left - second.left).abs(),
            _ => f64::INFINITY,
        }
    }

    /// How far a sample is from the other class: its tilt from the limit, and the turn by which it left before the
    /// horizon (rad).
    fn margin(&self, outcome: &Outcome, rate: impl Fn() -> f64) -> f64 {
        let beyond = outcome.tilt - self.criterion.limit();
        match outcome.class {
            Class::Unstable => beyond.min(rate() * (self.t_end - outcome.left)),
            _ => -beyond,
        }
    }
}

/// The outcome of a sample that was classified.
fn classified(outcomes: &[Option<Outcome>], index: usize) -> Option<&Outcome> {
    outcomes[index].as_ref().filter(|outcome| outcome.class != Class::Failed)
}
