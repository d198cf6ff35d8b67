//! Adaptive steps of a group: the length of each step from the series of the body, and states inside the step.

use super::group::{Group, MAX_STATE};
use super::step::used_packs;
use crate::error::Error;
use crate::memory;
use crate::method::{Coefficients, Engine, in_halves, two_sum};
use crate::real::{Pack, Real, zero_or_nan};
use crate::scene::{Layout, Model, Parameters};
use crate::simd::{LANES, Row};
use crate::special::{exp, ln};

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
    /// The step that a Runge-Kutta method tries next, with its sign.
    pub trial: Row,
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
            tolerance,
        })
    }
}

/// Advances every lane by adaptive steps until one lane reaches its `next` time; returns the number of steps, at most
/// `most`. A block also ends if the state of a lane is not a number: the time of the lane is then NaN.
#[inline(always)]
pub fn adaptive_block<P: Pack, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    l: &mut AdaptiveSteps,
    bodies: &[(Parameters<P>, S); PACKS],
    most: usize,
) -> usize
where
    M: Model<P>,
    L: Layout,
    S: Engine<P, M, L, D>,
{
    let packs = used_packs::<P, PACKS>(g);
    for done in 1..=most {
        let mut reached = false;
        for b in 0..packs {
            let at = b * P::LANES;
            let unit = P::load(&g.step.0[at..]);
            let (mut y, mut compensation) = ([unit; D], [unit; D]);
            for d in 0..D {
                y[d] = P::load(&g.state[d].0[at..]);
                compensation[d] = P::load(&g.compensation[d].0[at..]);
            }
            let mut c = Coefficients::new();
            bodies[b].1.expand(unit, &y, &mut c);
            let order = c.highest();
            let inverse_rate = P::load(&l.inverse_rate.0[at..]);
            let mut bound = step_bound::<P, L, D>(&c, order, inverse_rate, P::splat(l.tolerance));
            if L::BALANCE {
                let now = P::load(&l.now[0].0[at..]) + P::load(&l.now[1].0[at..]);
                // `min` returns its second argument if an argument is NaN.
                bound = ((P::load(&l.end.0[at..]) - now) / unit).min(bound);
            }
            let mut increment = *c.order(order);
            for k in (1..order).rev() {
                in_halves!(d in D { increment[d] = increment[d].fma(bound, c.order(k)[d]); });
            }
            in_halves!(d in D {
                (y[d], compensation[d]) = two_sum(y[d], increment[d].fma(bound, compensation[d]));
                y[d].store(&mut g.state[d].0[at..]);
                compensation[d].store(&mut g.compensation[d].0[at..]);
            });
            // The motion goes on if the deviation vector overflows.
            let step = unit.fma(bound, zero_or_nan(&y[..L::TANGENT_AT]));
            unit.store(&mut l.unit.0[at..]);
            step.store(&mut g.step.0[at..]);

            let begin = [P::load(&l.now[0].0[at..]), P::load(&l.now[1].0[at..])];
            let (time, residue) = two_sum(begin[0], step + begin[1]);
            begin[0].store(&mut l.begin[0].0[at..]);
            begin[1].store(&mut l.begin[1].0[at..]);
            time.store(&mut l.now[0].0[at..]);
            residue.store(&mut l.now[1].0[at..]);
            let ahead = (P::load(&l.next.0[at..]) - time) * P::load(&l.direction.0[at..]);
            let ends = some_ends(ahead);
            reached |= ends;
            if ends || done == most {
                for k in 0..=order {
                    for d in 0..D {
                        c.order(k)[d].store(&mut l.powers[k][d].0[at..]);
                    }
                }
            }
        }
        if reached {
            return done;
        }
    }
    most
}

/// Whether the time ahead of some lane is over, or NaN.
#[inline(always)]
pub(super) fn some_ends<R: Real>(ahead: R) -> bool {
    !R::all(R::splat(0.0).lt(ahead))
}

/// The longest step, in units, for which the last two terms of the series are below the tolerance, with the safety
/// factor of Jorba & Zou 2005, eq. (3-8) (doi 10.1080/10586458.2005.10128904).
#[inline(always)]
fn step_bound<R: Real, L: Layout, const D: usize>(
    c: &Coefficients<R, D>,
    order: usize,
    inverse_rate: R,
    tolerance: R,
) -> R {
    let deviation =
        if L::TANGENT { largest_change::<R, L, D>(c.order(0), inverse_rate) } else { R::splat(1.0) };
    let scales = [inverse_rate, deviation];
    let last = log_margin::<R, L, D>(c.order(order), scales, tolerance);
    let before = log_margin::<R, L, D>(c.order(order - 1), scales, tolerance);
    bound_of_margins(last, before, order)
}

/// The longest step, from ln of the tolerance over the largest number of the last term and of the one before.
#[inline(always)]
pub(super) fn bound_of_margins<R: Real>(last: R, before: R, order: usize) -> R {
    let last = last * R::splat(1.0 / order as f64);
    let before = before * R::splat(1.0 / (order - 1) as f64);
    // The factor between two steps is at most 2^30, because a body at rest has no time scale.
    let growth = R::splat(30.0 * std::f64::consts::LN_2);
    let margin = R::splat(0.7 / (order - 1) as f64);
    exp((last.min(before) - margin).min(growth).max(-growth))
}

/// ln of the tolerance over the largest number of a term, where a deviation vector counts relative to its size. The
/// balance follows from the motion, so the balance is ignored.
#[inline(always)]
fn log_margin<R: Real, L: Layout, const D: usize>(
    term: &[R; D],
    [inverse_rate, deviation]: [R; 2],
    tolerance: R,
) -> R {
    let mut largest = R::splat(f64::MIN_POSITIVE);
    for d in 0..L::BALANCE_AT {
        let size = if d < 3 { term[d].abs() * inverse_rate } else { term[d].abs() };
        largest = largest.max(size);
    }
    if L::TANGENT {
        // `max` returns its second argument if the quotient is a NaN: a deviation vector that has overflowed does not
        // count.
        let change = largest_change::<R, L, D>(term, inverse_rate);
        // Nor does one that is zero and stays so.
        let none = R::splat(f64::MIN_POSITIVE);
        largest = R::select(none.lt(change), change / deviation, none).max(largest);
    }
    ln(tolerance) - ln(largest)
}

/// The largest number of a deviation vector, its change of the rates over the scale of the rates.
#[inline(always)]
fn largest_change<R: Real, L: Layout, const D: usize>(y: &[R; D], inverse_rate: R) -> R {
    let mut largest = R::splat(f64::MIN_POSITIVE);
    for d in 0..6 {
        let size = y[L::TANGENT_AT + d].abs();
        largest = (if d < 3 { size * inverse_rate } else { size }).max(largest);
    }
    largest
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
