//! Whether a motion is regular or chaotic, from the mean MEGNO of a displacement at a few times.
//!
//! The mean MEGNO of displacements that grow like a power `t^p` of the time stays at `2 p`. It grows like `lambda T / 2`
//! where displacements grow exponentially, so it doubles with the time.

use super::{Class, Outcome, STEP_BLOCK, Watched};
use crate::kernel::{Group, System};
use crate::observe::{Displacement, Growth};
use crate::simd::Isa;
use crate::start::Body;
use crate::status::Status;
use crate::trajectory::{Frame, STEPS_TOGETHER, settle};

/// The horizon over the times at which the mean MEGNO is read, the checkpoints.
pub const PARTS: [u64; 4] = [8, 4, 2, 1];

/// Steps of a sample: a whole number of blocks until each checkpoint.
pub(super) const STEPS: u64 = PARTS[0] * BLOCK;

/// Steps between two looks at a sample: fewer than those of other criteria, so that there may be few until the horizon.
pub(super) const BLOCK: u64 = STEP_BLOCK / 2;

/// Least number of steps of a sample: the means need them.
pub(super) const FEWEST: u64 = 64 * PARTS[0];

/// A displacement beyond 2^this, or below its inverse, is divided by a power of two.
const LARGEST_EXPONENT: u64 = 256;

/// Blocks between two looks for such displacements: in their steps a displacement grows by less than 2^256.
const BLOCKS_TOGETHER: u64 = 4;

/// When a run is called regular, and when chaotic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Regular: a mean MEGNO below this. The limit of regular motions is 2.
    pub sure: f64,
    /// Regular too: a mean MEGNO below this and less than 1/2 above that at half of the horizon.
    pub low: f64,
    /// Chaotic: a mean MEGNO above this; at an earlier checkpoint than the horizon above twice this. Quadratic growth
    /// gives 4.
    pub high: f64,
    /// And above this times that at half of the time: quadratic growth gives 1, exponential growth 2.
    pub ratio: f64,
}

impl Rule {
    /// The class of a run, from its mean MEGNO at the checkpoints: stable if it is regular, unstable if it is chaotic.
    pub fn class(self, means: [f64; 4]) -> Class {
        let [.., half, end] = means;
        if !means.iter().all(|mean| mean.is_finite()) {
            Class::Failed
        } else if (1..4).any(|checkpoint| self.is_chaotic_at(means, checkpoint)) {
            Class::Unstable
        } else if end < self.sure || (end < self.low && end - half < 0.5) {
            Class::Stable
        } else {
            Class::Undecided
        }
    }

    /// Whether a run is seen to be chaotic at a checkpoint after the first. Later ones cannot change that.
    fn is_chaotic_at(self, means: [f64; 4], checkpoint: usize) -> bool {
        let high = if checkpoint == 3 { self.high } else { 2.0 * self.high };
        means[checkpoint] > high && means[checkpoint] > self.ratio * means[checkpoint - 1]
    }
}

/// The generic displacements of the first and of the second run, with rates in the unit of the body: each has a part
/// along the direction that grows most. The others are for spectra.
pub const DISPLACEMENTS: [[f64; 6]; 6] = [
    [0.5, -0.25, 0.375, 0.3125, 0.4375, -0.5],
    [-0.25, 0.5, 0.125, 0.25, -0.375, 0.625],
    [0.125, 0.25, -0.5, -0.5, 0.25, 0.125],
    [0.375, -0.5, -0.25, 0.125, 0.625, 0.375],
    [0.25, 0.125, 0.5, 0.5, -0.125, 0.25],
    [-0.5, 0.375, 0.25, -0.125, 0.5, -0.625],
];

/// The displacement of a run of a sample.
pub(super) fn displacement(body: &Body, of_attitude: bool, cross_check: bool) -> Displacement {
    let unit = body.rate_unit();
    let mut start = DISPLACEMENTS[usize::from(cross_check)];
    for rate in &mut start[..3] {
        *rate *= unit;
    }
    Displacement { start, inverse_scale: [1.0 / unit; 3], of_attitude }
}

/// The way of a sample through its checkpoints.
#[derive(Clone, Copy)]
pub(super) struct Course {
    rule: Rule,
    norm: Displacement,
    /// The rotation about the vertical is removed from the displacement every so many steps: damping shrinks the rest.
    turns: bool,
    steps: f64,
    /// Horizon.
    t_end: f64,
    /// Mean MEGNO at the checkpoints that were reached.
    means: [f64; 4],
    reached: usize,
    /// Steps after which the displacement was settled.
    settled: f64,
}

impl Course {
    pub(super) fn new(rule: Rule, norm: Displacement, is_forced: bool, [steps, t_end]: [f64; 2]) -> Course {
        let turns = is_forced && !norm.of_attitude;
        Course { rule, norm, turns, steps, t_end, means: [f64::NAN; 4], reached: 0, settled: 0.0 }
    }

    /// Steps until the next time at which the sample is looked at.
    pub(super) fn next(&self) -> f64 {
        let checkpoint = self.steps / PARTS[self.reached] as f64;
        if self.turns { checkpoint.min(self.settled + STEPS_TOGETHER[0] as f64) } else { checkpoint }
    }

    /// Looks at the sample in a lane at that time; returns whether its class is known.
    pub(super) fn look(&mut self, group: &mut Group, system: System, lane: usize) -> bool {
        let now = group.count.0[lane];
        if self.turns {
            self.settle(group, system, lane);
            self.settled = now;
        }
        if now < self.steps / PARTS[self.reached] as f64 {
            return false;
        }
        self.means[self.reached] = mean_megno(group, lane);
        self.reached += 1;
        let seen = self.reached > 1 && self.rule.is_chaotic_at(self.means, self.reached - 1);
        seen || self.reached == PARTS.len()
    }

    /// Brings the displacement of a lane near one in size, which changes no digit of its growth.
    pub(super) fn settle(&self, group: &mut Group, system: System, lane: usize) {
        // One displacement takes so few operations that the instruction set does not matter.
        settle(group, system, lane, &self.norm, self.turns, &mut Frame::new(1, Isa::Scalar));
    }

    /// The outcome, from that of the motion alone.
    pub(super) fn outcome(&self, group: &Group, lane: usize, motion: Outcome) -> Outcome {
        if motion.class == Class::Failed {
            return motion;
        }
        let rows = group.observed_in(lane);
        let seen = self.reached < PARTS.len();
        let class = if seen { Class::Unstable } else { self.rule.class(self.means) };
        let time = self.t_end / PARTS[self.reached - 1] as f64;
        let status = match class {
            Class::Failed => Status::NotFinite,
            _ if seen => Status::Stopped,
            _ => Status::Finished,
        };
        let left = if class == Class::Unstable { time } else { f64::INFINITY };
        let [log, ..] = Growth::logs(&rows);
        Outcome { class, status, left, exponent: log / time, mean_megno: mean_megno(group, lane), ..motion }
    }
}

fn mean_megno(group: &Group, lane: usize) -> f64 {
    let [.., mean] = Growth::logs(&group.observed_in(lane));
    2.0 * mean
}

/// Divides the displacements of a group that are far from one in size. Looks after some blocks only.
pub(super) fn keep_in_range<'a>(
    group: &mut Group,
    system: System,
    blocks: u64,
    courses: impl Iterator<Item = (usize, &'a Course)>,
) {
    if !blocks.is_multiple_of(BLOCKS_TOGETHER) {
        return;
    }
    let at = system.tangent_at().expect("the system has a displacement");
    for (lane, course) in courses {
        let size = (0..6).fold(0.0_f64, |size, k| size.max(group.state[at + k].0[lane].abs()));
        let exponent = (size.to_bits() >> 52).abs_diff(1023);
        if exponent > LARGEST_EXPONENT && size > 0.0 {
            course.settle(group, system, lane);
        }
    }
}

impl Watched<'_> {
    /// Steps of a sample are a multiple of the first number, and at least the second.
    pub(super) fn whole_steps(&self) -> [u64; 2] {
        if self.criterion.rule().is_some() { [STEPS, FEWEST] } else { [STEP_BLOCK; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: Rule = Rule { sure: 2.1, low: 3.0, high: 5.0, ratio: 1.5 };

    #[test]
    fn powers_of_the_time_are_regular_or_undecided_and_exponentials_chaotic() {
        let classes = [
            ([1.9, 1.95, 2.0, 2.0], Class::Stable),
            ([0.0; 4], Class::Stable),
            ([2.2, 2.3, 2.4, 2.5], Class::Stable),
            ([2.0, 2.0, 2.0, 2.9], Class::Undecided),
            ([4.0; 4], Class::Undecided),
            ([18.0; 4], Class::Undecided),
            ([1.0, 2.0, 4.0, 8.0], Class::Unstable),
            // Early: above twice the bound, whatever follows.
            ([2.0, 11.0, 11.5, 12.0], Class::Unstable),
            ([2.0, 9.0, 11.0, 12.0], Class::Undecided),
            ([2.0, 2.0, 2.0, f64::NAN], Class::Failed),
        ];
        for (means, class) in classes {
            assert_eq!(RULE.class(means), class, "{means:?}");
        }
    }

    #[test]
    fn two_runs_agree_or_one_is_sure() {
        use Class::*;
        for (first, second, together) in [
            (Stable, Stable, Stable),
            (Unstable, Unstable, Unstable),
            (Stable, Unstable, Undecided),
            (Unstable, Stable, Undecided),
            (Unstable, Undecided, Unstable),
            (Undecided, Unstable, Unstable),
            (Undecided, Stable, Undecided),
            (Stable, Undecided, Undecided),
            (Stable, Failed, Undecided),
            (Unstable, Failed, Undecided),
            (Failed, Stable, Failed),
        ] {
            assert_eq!(first.agreed(second), together, "{first:?} {second:?}");
        }
    }
}
