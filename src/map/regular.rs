//! Whether a motion is regular or chaotic, from the mean MEGNO of a deviation vector at a few times.
//!
//! The mean MEGNO of deviation vectors that grow like a power `t^p` of the time stays at `2 p`. It grows like `lambda T
//! / 2` where deviation vectors grow exponentially, so it doubles with the time.

use super::{Class, Observation, Outcome, STEP_BLOCK};
use crate::body::Body;
use crate::forces::BodyForces;
use crate::kernel::{Group, System};
use crate::kinematics::cross;
use crate::method::{self, Method};
use crate::observe::{Deviation, Growth};
use crate::simd::Isa;
use crate::status::Status;
use crate::trajectory::{Frame, STEPS_TOGETHER, renormalise};

/// The horizon over the times at which the mean MEGNO is read, the checkpoints.
pub const PARTS: [u64; 4] = [8, 4, 2, 1];

/// Steps of a sample: a whole number of blocks until each checkpoint.
pub(super) const STEPS: u64 = PARTS[0] * BLOCK;

/// Steps between two looks at a sample: fewer than those of other criteria, so that there may be few until the horizon.
pub(super) const BLOCK: u64 = STEP_BLOCK / 2;

/// Least number of steps of a sample: the means need them.
pub(super) const FEWEST: u64 = 64 * PARTS[0];

/// And of the run that checks it: a sample that turns little then has other steps in both.
const FEWEST_AGAIN: u64 = FEWEST + STEPS;

/// The method of the run that checks a sample.
pub const SECOND: &Method = &method::DOP853;

/// Its longest step: the body turns by this angle (rad).
const SECOND_ANGLE: f64 = 1.0;

/// In runs over more than this angle (rad) its steps are shorter: the longer a run, the more often it passes a saddle, and
/// the less it may err there.
const SECOND_TURN: f64 = 1600.0;

/// The longest step of the run that checks a sample with this bound of its rate. It follows no step of the first run, so
/// that it is right where the steps of the user are too long, and wrong in half of them.
pub(super) fn second_step(rate: f64, t_end: f64) -> f64 {
    // Square roots have the same bits everywhere. The error of the whole run falls like 1 / t_end.
    SECOND_ANGLE * (SECOND_TURN / (rate * t_end)).min(1.0).sqrt().sqrt() / rate
}

/// A deviation vector beyond 2^this, or below its inverse, is divided by a power of two.
const LARGEST_EXPONENT: u64 = 256;

/// Blocks between two looks for such deviation vectors: in their steps a deviation vector grows by less than 2^256.
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

/// Generic deviation vectors, with rates in the unit of the body: each has a part along the direction that grows most.
/// Those of the first and of the second run of a verdict follow from the first two; the others are for spectra.
pub const DEVIATIONS: [[f64; 6]; 6] = [
    [0.5, -0.25, 0.375, 0.3125, 0.4375, -0.5],
    [-0.25, 0.5, 0.125, 0.25, -0.375, 0.625],
    [0.125, 0.25, -0.5, -0.5, 0.25, 0.125],
    [0.375, -0.5, -0.25, 0.125, 0.625, 0.375],
    [0.25, 0.125, 0.5, 0.5, -0.125, 0.25],
    [-0.5, 0.375, 0.25, -0.125, 0.5, -0.625],
];

/// The largest component of what is left on the level of `L.gamma` must exceed this: rounding has no part in it then.
const LEAST_LEFT: f64 = 1.0 / (1 << 20) as f64;

/// The deviation vector of a run of a sample.
pub(super) fn deviation(body: &Body, forces: BodyForces, of_attitude: bool, cross_check: bool) -> Deviation {
    let start = deviation_start(body, forces, cross_check);
    Deviation { start, inverse_scale: [1.0 / body.rate_unit(); 3], of_attitude }
}

/// The deviation vector from which a verdict begins: that of the first run, or of the one that checks it.
///
/// Where `L.gamma` is conserved by a weight, it is the part of the generic deviation vector that keeps `L.gamma`. A
/// motion changes with `L.gamma` too: at a resonance quadratically in the time, and a top may be integrable at one
/// value only.
pub fn deviation_start(body: &Body, forces: BodyForces, cross_check: bool) -> [f64; 6] {
    let (generic, unit) = (DEVIATIONS[usize::from(cross_check)], body.rate_unit());
    let keeps_momentum = forces.is_none() && body.weight != [0.0; 3];
    let gradient = if keeps_momentum { momentum_gradient(body, unit) } else { None };
    let level = gradient.map(|gradient| across(&generic, &gradient));
    let mut start = level.filter(|level| largest(level) > LEAST_LEFT).unwrap_or(generic);
    for rate in &mut start[..3] {
        *rate *= unit;
    }
    start
}

/// The gradient of `L.gamma = I omega . gamma` by a deviation vector with rates in this unit, its largest component one
/// in size: `(unit I gamma, I omega x gamma)`, because a rotation vector x changes gamma by `gamma x x`. `None` if it
/// vanishes or is not finite. Moments over the largest one and rates over their unit stay in the range of doubles.
fn momentum_gradient(body: &Body, unit: f64) -> Option<[f64; 6]> {
    let gamma = body.gamma();
    let most = largest(&body.moments);
    let moments = body.moments.map(|moment| moment / most);
    let momentum = [0, 1, 2].map(|k| moments[k] * (body.omega[k] / unit));
    let [a, b, c] = [0, 1, 2].map(|k| moments[k] * gamma[k]);
    let [x, y, z] = cross(&momentum, &gamma);
    let gradient = [a, b, c, x, y, z];
    let most = largest(&gradient);
    let scaled = gradient.map(|g| g / most);
    scaled.iter().all(|g| g.is_finite()).then_some(scaled)
}

/// The part of a deviation vector across a direction.
fn across(deviation: &[f64; 6], direction: &[f64; 6]) -> [f64; 6] {
    let product = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
    let along = product(deviation, direction) / product(direction, direction);
    let mut left = *deviation;
    for (left, direction) in left.iter_mut().zip(direction) {
        *left -= along * direction;
    }
    left
}

/// The largest size of some components.
fn largest(components: &[f64]) -> f64 {
    components.iter().fold(0.0, |largest, component| largest.max(component.abs()))
}

/// The way of a sample through its checkpoints.
#[derive(Clone, Copy)]
pub(super) struct Checkpoints {
    rule: Rule,
    norm: Deviation,
    /// The rotation about the vertical is removed from the deviation vector every so many steps: damping shrinks the
    /// rest.
    turns: bool,
    steps: f64,
    /// Horizon.
    t_end: f64,
    /// Mean MEGNO at the checkpoints that were reached.
    means: [f64; 4],
    reached: usize,
    /// Steps after which the deviation vector was renormalised.
    renormalised: f64,
}

impl Checkpoints {
    pub(super) fn new(rule: Rule, norm: Deviation, is_forced: bool, [steps, t_end]: [f64; 2]) -> Checkpoints {
        let turns = is_forced && !norm.of_attitude;
        Checkpoints { rule, norm, turns, steps, t_end, means: [f64::NAN; 4], reached: 0, renormalised: 0.0 }
    }

    /// Steps until the next time at which the sample is looked at.
    pub(super) fn next(&self) -> f64 {
        let checkpoint = self.steps / PARTS[self.reached] as f64;
        if self.turns { checkpoint.min(self.renormalised + STEPS_TOGETHER[0] as f64) } else { checkpoint }
    }

    /// Looks at the sample in a lane at that time; returns whether its class is known.
    pub(super) fn look(&mut self, group: &mut Group, system: System, lane: usize) -> bool {
        let now = group.count.0[lane];
        if self.turns {
            self.renormalise(group, system, lane);
            self.renormalised = now;
        }
        if now < self.steps / PARTS[self.reached] as f64 {
            return false;
        }
        self.means[self.reached] = mean_megno(group, lane);
        self.reached += 1;
        let seen = self.reached > 1 && self.rule.is_chaotic_at(self.means, self.reached - 1);
        seen || self.reached == PARTS.len()
    }

    /// Brings the deviation vector of a lane near one in size, which changes no digit of its growth.
    pub(super) fn renormalise(&self, group: &mut Group, system: System, lane: usize) {
        // One deviation vector takes so few operations that the instruction set does not matter.
        renormalise(group, system, lane, &self.norm, self.turns, &mut Frame::new(1, Isa::NARROWEST));
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

/// Divides the deviation vectors of a group that are far from one in size. Looks after some blocks only.
pub(super) fn keep_in_range<'a>(
    group: &mut Group,
    system: System,
    blocks: u64,
    checkpoints: impl Iterator<Item = (usize, &'a Checkpoints)>,
) {
    if !blocks.is_multiple_of(BLOCKS_TOGETHER) {
        return;
    }
    let at = system.tangent_at.expect("the system has a deviation vector");
    for (lane, one) in checkpoints {
        let size = (0..6).fold(0.0_f64, |size, k| size.max(group.state[at + k].0[lane].abs()));
        let exponent = (size.to_bits() >> 52).abs_diff(1023);
        if exponent > LARGEST_EXPONENT && size > 0.0 {
            one.renormalise(group, system, lane);
        }
    }
}

impl Observation<'_> {
    /// Steps of a sample are a multiple of the first number, and at least the second.
    pub(super) fn whole_steps(&self, cross_check: bool) -> [u64; 2] {
        match (self.criterion.rule(), cross_check) {
            (Some(_), false) => [STEPS, FEWEST],
            (Some(_), true) => [STEPS, FEWEST_AGAIN],
            (None, _) => [STEP_BLOCK; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forces::Forces;
    use crate::inertia::moment_range;
    use crate::kinematics::{dot, quaternion_product};
    use std::array;

    const RULE: Rule = Rule { sure: 2.1, low: 3.0, high: 5.0, ratio: 1.5 };

    const TOP: Body = Body {
        moments: [1.0, 1.6, 0.7],
        weight: [0.3, 0.2, 1.1],
        omega: [0.5, -2.4, 1.25],
        attitude: [0.5, -0.1, 0.7, 0.5],
    };

    /// `L.gamma` of a body with this change of its rates, turned by this rotation vector in the body.
    fn momentum_about_vertical(body: &Body, [a, b, c, x, y, z]: [f64; 6]) -> f64 {
        let angle = (x * x + y * y + z * z).sqrt();
        let share = if angle > 0.0 { (0.5 * angle).sin() / angle } else { 0.0 };
        let turn = [(0.5 * angle).cos(), share * x, share * y, share * z];
        let turned = Body { attitude: quaternion_product(&body.attitude, &turn), ..*body };
        let [p, q, r] = body.omega;
        let momentum = [body.moments[0] * (p + a), body.moments[1] * (q + b), body.moments[2] * (r + c)];
        dot(&momentum, &turned.gamma())
    }

    /// The derivative of `L.gamma` along a deviation vector by central differences.
    fn slope(body: &Body, deviation: [f64; 6]) -> f64 {
        let [after, before] = [STEP, -STEP].map(|h| momentum_about_vertical(body, deviation.map(|u| h * u)));
        (after - before) / (2.0 * STEP)
    }

    const STEP: f64 = 1e-5;

    #[test]
    fn deviations_of_a_verdict_keep_the_momentum_about_the_vertical() {
        let tops = [
            TOP,
            Body { weight: [1.0, 0.0, 0.0], moments: [4.0, 4.0, 1.0], ..TOP },
            Body { omega: [0.0; 3], ..TOP },
            Body { omega: [30.0, -20.0, 40.0], ..TOP },
            Body { moments: [1.0, 1.0, 1e-6], attitude: [1.0, 0.0, 0.0, 0.0], ..TOP },
        ];
        for body in tops {
            let unit = body.rate_unit();
            for cross_check in [false, true] {
                let found = deviation_start(&body, BodyForces::NONE, cross_check);
                let generic = DEVIATIONS[usize::from(cross_check)];
                let mut scaled = found;
                scaled[..3].iter_mut().for_each(|rate| *rate /= unit);
                // Truncation is the square of the step, rounding 2^-53 over the step, each times some L.
                let momentum = largest(&body.moments) * unit;
                assert!(slope(&body, found).abs() < 1e-10 * momentum, "{body:?}: {}", slope(&body, found));
                // Only what is along the gradient is gone, and of it everything.
                let gone: [f64; 6] = array::from_fn(|k| generic[k] - scaled[k]);
                let gradient: [f64; 6] = array::from_fn(|k| {
                    let mut along = [0.0; 6];
                    along[k] = if k < 3 { unit } else { 1.0 };
                    slope(&body, along) / momentum
                });
                let product = |a: &[f64; 6], b: &[f64; 6]| (0..6).map(|k| a[k] * b[k]).sum::<f64>();
                let sizes = product(&gone, &gone).sqrt() * product(&gradient, &gradient).sqrt();
                assert!((product(&gone, &gradient).abs() - sizes).abs() < 1e-9, "{body:?}");
            }
        }
    }

    #[test]
    fn deviations_do_not_depend_on_units() {
        let known = deviation_start(&TOP, BodyForces::NONE, false);
        for (mass, rate) in [(3, -7), (400, 40), (900, -400), (-900, 400), (-400, -40)] {
            let [mass, rate] = [mass, rate].map(|power| 2.0_f64.powi(power));
            let scaled = Body {
                moments: TOP.moments.map(|x| x * mass),
                weight: TOP.weight.map(|x| x * rate * mass * rate),
                omega: TOP.omega.map(|x| x * rate),
                ..TOP
            };
            let mut found = deviation_start(&scaled, BodyForces::NONE, false);
            found[..3].iter_mut().for_each(|x| *x /= rate);
            assert_eq!(found, known, "{mass:e} {rate:e}");
        }
    }

    #[test]
    fn bodies_whose_momentum_about_the_vertical_is_not_that_of_a_weight_have_generic_deviations() {
        let damping = Forces::new(&[], &[], &[], &[[0.1, 0.1, 0.1, 0.0, 0.0, 0.0]]).unwrap();
        let nothing = Forces::new(&[], &[], &[], &[[0.0; 6]]).unwrap();
        let is_generic = |body: &Body, forces: &Forces| {
            let unit = body.rate_unit();
            let [a, b, c, x, y, z] = DEVIATIONS[1];
            let found = deviation_start(body, forces.of(0), true);
            found == [a * unit, b * unit, c * unit, x, y, z]
        };
        assert!(!is_generic(&TOP, Forces::NONE));
        assert!(!is_generic(&TOP, &nothing));
        assert!(is_generic(&TOP, &damping));
        assert!(is_generic(&Body { weight: [0.0; 3], ..TOP }, Forces::NONE));
        assert!(is_generic(&Body { attitude: [f64::NAN; 4], ..TOP }, Forces::NONE));
    }

    #[test]
    fn a_deviation_along_the_gradient_stays() {
        // The gradient (unit I gamma, L x gamma) is made equal to the deviation vector (d, x): gamma follows from d and
        // moments for which gamma is across x, L from x, and the weight from the unit.
        let [a, b, c, x, y, z] = DEVIATIONS[0];
        let (i1, i2) = (0.1, 0.2);
        let moments = [i1, i2, -c * z / (a * x / i1 + b * y / i2)];
        let along = [a / moments[0], b / moments[1], c / moments[2]];
        let unit = dot(&along, &along).sqrt();
        let gamma = along.map(|x| x / unit);
        let momentum = cross(&gamma, &[x, y, z]);
        let omega = [0, 1, 2].map(|k| momentum[k] / moments[k]);
        let mgl = (unit * unit - dot(&omega, &omega)) * moment_range(moments)[0];
        assert!(mgl > 0.0);
        // The shortest turn that brings the vertical to gamma in the body.
        let scale = (2.0 * (1.0 + gamma[2])).sqrt();
        let attitude = [0.5 * scale, gamma[1] / scale, -gamma[0] / scale, 0.0];
        let body = Body { moments, weight: [mgl, 0.0, 0.0], omega, attitude };
        assert!((0..3).all(|k| (body.gamma()[k] - gamma[k]).abs() < 1e-15));
        assert!((body.rate_unit() - unit).abs() < 1e-14);
        let found = deviation_start(&body, BodyForces::NONE, false);
        assert_eq!(found[3..], DEVIATIONS[0][3..]);
        assert_ne!(deviation_start(&body, BodyForces::NONE, true)[3..], DEVIATIONS[1][3..]);
    }

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
    fn steps_of_the_second_run_are_shorter_in_long_runs() {
        for (rate, t_end, step) in
            [(2.0, 1.0, 0.5), (2.0, 800.0, 0.5), (2.0, 12800.0, 0.25), (4.0, 6400.0, 0.125)]
        {
            assert_eq!(second_step(rate, t_end), step);
        }
        assert_eq!(second_step(0.0, 100.0), f64::INFINITY);
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
