//! Adaptive steps of a group, and states inside the step: of a series with the length that its terms allow; of a Runge-Kutta
//! method by trial. A lane whose step has too large an error keeps its state, and tries a shorter step in the next round.

use super::group::{Group, MAX_STATE};
use super::step::used_packs;
use crate::error::Error;
use crate::kinematics::speed;
use crate::memory;
use crate::method::{Coefficients, Engine, Limits, Proposal, in_halves};
use crate::real::{Pack, Real, two_sum, zero_or_nan};
use crate::scene::{Layout, Model, Parameters};
use crate::simd::{LANES, Row, load_rows, store_rows};

/// Time and last polynomial of each body of a group.
#[derive(Clone)]
pub struct AdaptiveSteps {
    /// Coefficients of the last step of a block, in powers of the time since its begin over `unit`; of lanes that end
    /// the block, or of all if it has made as many steps as it may.
    pub powers: Vec<[Row; MAX_STATE]>,
    /// The time unit of `powers`.
    pub unit: Row,
    /// Begin of the last step, and its rounding error.
    pub begin: [Row; 2],
    /// End of the last step.
    pub now: [Row; 2],
    /// Time at which a block ends for the lane; infinite for inactive lanes.
    pub next: Row,
    /// The next knot of the forces: no step goes beyond it.
    pub end: Row,
    /// 1 forward, -1 backward.
    pub direction: Row,
    /// One over the scale of the rates; a Runge-Kutta method counts the rates that it meets.
    pub inverse_rate: Row,
    /// The longest step of a Runge-Kutta method.
    pub longest: Row,
    /// The length that the next step tries, with its sign: of a series the length of its last step. Zero in inactive lanes.
    pub trial: Row,
    /// 1 where the last step had too large an error and is made again, shorter.
    pub again: Row,
    /// Size of the last terms of a step of a series, or of the error of a Runge-Kutta step.
    pub tolerance: f64,
}

impl AdaptiveSteps {
    /// Inactive lanes, for a series of that order.
    pub fn inactive(tolerance: f64, order: usize) -> Result<AdaptiveSteps, Error> {
        let nothing = Row([0.0; LANES]);
        Ok(AdaptiveSteps {
            powers: memory::filled("series of a group", order + 1, [nothing; MAX_STATE])?,
            unit: nothing,
            begin: [nothing; 2],
            now: [nothing; 2],
            next: Row([f64::INFINITY; LANES]),
            end: Row([f64::INFINITY; LANES]),
            direction: Row([1.0; LANES]),
            inverse_rate: nothing,
            longest: nothing,
            trial: nothing,
            again: nothing,
            tolerance,
        })
    }
}

/// Limits of the factor between two steps, and the share of the step that the error allows (Hairer, Nørsett, Wanner,
/// Solving ODEs I, section II.4).
const LEAST_FACTOR: f64 = 0.2;
const LARGEST_FACTOR: f64 = 6.0;
const SAFETY: f64 = 0.9;

/// Advances every lane by adaptive steps until one lane reaches its `next` time, in at most `most` rounds, in each of which
/// a lane makes a step unless its error is too large. A block also ends if the state of a lane is not a number: the time of
/// the lane is then NaN.
#[inline(always)]
pub fn adaptive_block<P: Pack, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    l: &mut AdaptiveSteps,
    bodies: &mut [(Parameters<P>, S); PACKS],
    most: usize,
) where
    M: Model<P>,
    L: Layout,
    S: Engine<P, M, L, D>,
{
    let packs = used_packs::<P, PACKS>(g);
    for done in 1..=most {
        let mut reached = false;
        for b in 0..packs {
            reached |= step::<P, M, L, S, D>(g, l, &mut bodies[b].1, b * P::LANES, done == most);
        }
        if reached {
            return;
        }
    }
}

/// Advances the pack that begins at a lane by one step; whether a lane has reached its `next` time.
#[inline(always)]
fn step<P: Pack, M: Model<P>, L: Layout, S: Engine<P, M, L, D>, const D: usize>(
    g: &mut Group,
    l: &mut AdaptiveSteps,
    engine: &mut S,
    at: usize,
    is_last: bool,
) -> bool {
    let (zero, one) = (P::splat(0.0), P::splat(1.0));
    let (next, mut wanted) = (P::load(&l.next.0[at..]), P::load(&l.trial.0[at..]));
    if !P::any(zero.lt(wanted.abs())) && !P::any(next.abs().lt(P::splat(f64::INFINITY))) {
        // Nobody is in the pack.
        return false;
    }
    let mut y: [P; D] = load_rows(&g.state, at);
    let mut compensation: [P; D] = load_rows(&g.compensation, at);
    let (before, lost) = (y, compensation);
    let begin: [P; 2] = load_rows(&l.now, at);
    let (now, end) = (begin[0] + begin[1], P::load(&l.end.0[at..]));
    let inverse_rate = P::load(&l.inverse_rate.0[at..]);
    let limits = Limits { tolerance: P::splat(l.tolerance), inverse_rate, room: end - now };
    let mut unit = wanted;
    if const { S::IS_TRIED } {
        // No step goes beyond a knot or an output time.
        let longest = P::load(&l.longest.0[at..]);
        wanted = wanted.max(-longest).min(longest);
        unit = P::select(wanted.abs().lt(limits.room.abs()), wanted, limits.room);
    }
    let mut inside = Coefficients::new();
    let Proposal { change, share, error } = engine.propose(unit, &limits, &y, &mut inside);
    in_halves!(d in D {
        (y[d], compensation[d]) = two_sum(y[d], change[d].fma(share, compensation[d]));
    });
    // The motion goes on if the deviation vector overflows.
    let mut unknown = zero_or_nan(&y[..L::TANGENT_AT]);
    if L::STATES {
        unknown = unknown + zero_or_nan(&y[L::STATES_AT..]);
    }
    let mut made = unit.fma(share, unknown);
    let (mut time, mut residue) = two_sum(begin[0], made + begin[1]);
    let (mut trial, mut steps) = (made, one);
    if const { S::IS_TRIED } {
        // One where the step is made again: not where it is the shortest, nor where the state has no rate of change, so that
        // no step has a smaller error. The number after one, so that an error of one is not too large; a NaN is.
        let mut again = P::select(error.lt(P::splat(1.0 + f64::EPSILON)), zero, one);
        let shortest = P::splat(4.0 * f64::EPSILON) * now.abs() + P::splat(f64::MIN_POSITIVE);
        again = P::select(shortest.lt(unit.abs()), again, zero);
        again = P::select(zero_or_nan(inside.order(0)).lt(one), again, zero);
        let is_made = again.lt(one);
        // After a step with too large an error none is longer. The error falls as the eighth power of the step; of an error
        // of zero the quotient is infinite. `min` and `max` return their second argument if an argument is NaN.
        let was_again = zero.lt(P::load(&l.again.0[at..]));
        let largest = P::select(was_again, one, P::splat(LARGEST_FACTOR));
        let factor = P::splat(SAFETY) / error.sqrt().sqrt().sqrt();
        trial = unit * largest.min(factor).max(P::splat(LEAST_FACTOR));
        // One where a step that is made was cut, and ends at the knot or the output time if its state is a number.
        let mut cut = P::select(wanted.abs().lt(limits.room.abs()), zero, one);
        cut = P::select(is_made, cut, zero);
        trial = P::select(trial.abs().lt(cut * wanted.abs()), wanted, trial);
        let is_at_end = zero.lt(made.fma(zero, cut));
        time = P::select(is_at_end, end, P::select(is_made, time, begin[0]));
        residue = P::select(is_at_end, zero, P::select(is_made, residue, begin[1]));
        made = P::select(is_made, made, unit);
        for d in 0..D {
            y[d] = P::select(is_made, y[d], before[d]);
            compensation[d] = P::select(is_made, compensation[d], lost[d]);
        }
        let fastest = P::select(is_made, speed(&y), zero);
        P::select((one / inverse_rate).lt(fastest), one / fastest, inverse_rate)
            .store(&mut l.inverse_rate.0[at..]);
        again.store(&mut l.again.0[at..]);
        steps = one - again;
    }
    store_rows(&y, &mut g.state, at);
    store_rows(&compensation, &mut g.compensation, at);
    unit.store(&mut l.unit.0[at..]);
    trial.store(&mut l.trial.0[at..]);
    made.store(&mut g.step.0[at..]);
    (P::load(&g.count.0[at..]) + steps).store(&mut g.count.0[at..]);
    store_rows(&begin, &mut l.begin, at);
    store_rows(&[time, residue], &mut l.now, at);
    let ahead = (next - time) * P::load(&l.direction.0[at..]);
    let ends = some_ends(ahead);
    if ends || is_last {
        let wanted = if is_last { steps } else { P::select(zero.lt(ahead), zero, one) };
        engine.expand(wanted, [&before, &y], &mut inside);
        for k in 0..=inside.highest() {
            store_rows(inside.order(k), &mut l.powers[k], at);
        }
    }
    ends
}

/// Whether the time ahead of some lane is over, or NaN.
#[inline(always)]
pub(super) fn some_ends<R: Real>(ahead: R) -> bool {
    !R::all(R::splat(0.0).lt(ahead))
}

/// The state of a lane inside its last step, `units` after the begin of the step.
#[inline(always)]
pub fn dense_output<const D: usize>(
    l: &AdaptiveSteps,
    order: usize,
    lane: usize,
    units: f64,
) -> [f64; MAX_STATE] {
    let mut y = [0.0; MAX_STATE];
    for k in (0..=order).rev() {
        for d in 0..D {
            y[d] = y[d].fma(units, l.powers[k][d].0[lane]);
        }
    }
    y
}
