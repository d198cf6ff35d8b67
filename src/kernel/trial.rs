//! Adaptive steps of a Runge-Kutta method, one body at a time: a step with too large an error is made again, shorter.

use super::adaptive::{AdaptiveSteps, some_ends};
use super::group::{ForcesRows, Group};
use crate::kinematics::dot;
use crate::method::{Coefficients, Engine, Numbers, RungeKutta, Slopes, Tableau, two_sum};
use crate::real::zero_or_nan;
use crate::scene::{Layout, Model, Parameters};
use crate::simd::Row;

/// The least error of a step that is asked for: below it the estimate consists of rounding.
const LEAST_ERROR: f64 = 16.0 * f64::EPSILON;

/// Limits of the factor between two steps, and the share of the step that the error allows (Hairer, Nørsett, Wanner,
/// Solving ODEs I, section II.4).
const LEAST_FACTOR: f64 = 0.2;
const LARGEST_FACTOR: f64 = 6.0;
const SAFETY: f64 = 0.9;

/// Advances every lane by adaptive steps until one lane reaches its `next` time; returns the number of steps, at most
/// `most`. A block also ends if the state of a lane is not a number: the time of the lane is then NaN.
#[inline(always)]
pub fn trial_block<M: Model<f64>, L: Layout, T: Tableau, const D: usize>(
    g: &mut Group,
    forces: &ForcesRows,
    l: &mut AdaptiveSteps,
    most: usize,
) -> usize {
    for done in 1..=most {
        let mut reached = false;
        for lane in 0..g.used {
            if g.step.0[lane] != 0.0 {
                reached |= step::<M, L, T, D>(g, forces, l, lane, done == most);
            }
        }
        if reached {
            return done;
        }
    }
    most
}

/// A vector of a lane.
#[inline(always)]
fn three(rows: &[Row; 3], lane: usize) -> [f64; 3] {
    [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]]
}

/// |omega| of a state.
#[inline(always)]
fn speed<const D: usize>(y: &[f64; D]) -> f64 {
    let rates = [y[0], y[1], y[2]];
    dot(&rates, &rates).sqrt()
}

/// Advances a lane by one step; whether it has reached its `next` time.
#[inline(always)]
fn step<M: Model<f64>, L: Layout, T: Tableau, const D: usize>(
    g: &mut Group,
    forces: &ForcesRows,
    l: &mut AdaptiveSteps,
    lane: usize,
    is_last: bool,
) -> bool {
    let (mut y, mut compensation) = ([0.0; D], [0.0; D]);
    for d in 0..D {
        (y[d], compensation[d]) = (g.state[d].0[lane], g.compensation[d].0[lane]);
    }
    let before = y;
    let body = Parameters { moments: three(&g.moments, lane), weight: three(&g.weight, lane), step: 0.0 };
    // SAFETY: the engines end with this step, during which `forces` is borrowed.
    let interval = unsafe { forces.load::<f64>(lane) };
    let begin = [l.now[0].0[lane], l.now[1].0[lane]];
    let now = begin[0] + begin[1];
    // No step goes beyond a knot or an output time.
    let room = l.end.0[lane] - now;
    let (known_rate, longest) = (1.0 / l.inverse_rate.0[lane], l.longest.0[lane]);
    let mut wanted = l.trial.0[lane].max(-longest).min(longest);
    let mut slopes: Slopes<f64, D> = [y; _];
    let mut largest_factor = LARGEST_FACTOR;
    // Each round shortens the step by a tenth at least: one is the shortest, or zero, after 14 000 at most.
    let (engine, is_cut) = loop {
        let is_cut = room.abs() <= wanted.abs();
        let step = if is_cut { room } else { wanted };
        let p = Parameters { step, ..body };
        let engine = <RungeKutta<T, f64, M> as Engine<f64, M, L, D>>::new(&p, &interval, &Numbers::NONE);
        let change = engine.change::<L, D>(&before, &mut slopes);
        for d in 0..D {
            y[d] = before[d] + change[d];
        }
        let error = error::<L, D>(&before, &y, &engine.errors(&slopes), [known_rate, l.tolerance]);
        // The error falls as the eighth power of the step. Of an error of zero the quotient is infinite; an error that
        // is no number is too large.
        let factor = SAFETY / error.sqrt().sqrt().sqrt();
        let factor = if error.is_nan() { LEAST_FACTOR } else { factor.min(largest_factor).max(LEAST_FACTOR) };
        let is_shortest = step.abs() <= 4.0 * f64::EPSILON * now.abs() + f64::MIN_POSITIVE;
        if error <= 1.0 || is_shortest || zero_or_nan(&slopes[0]).is_nan() {
            for d in 0..D {
                (y[d], compensation[d]) = two_sum(before[d], change[d] + compensation[d]);
                g.state[d].0[lane] = y[d];
                g.compensation[d].0[lane] = compensation[d];
            }
            let next = step * factor;
            l.trial.0[lane] = if is_cut && next.abs() < wanted.abs() { wanted } else { next };
            let made = step + zero_or_nan(&y[..L::TANGENT_AT]);
            let fastest = speed(&y);
            if fastest > known_rate {
                l.inverse_rate.0[lane] = 1.0 / fastest;
            }
            (l.unit.0[lane], g.step.0[lane]) = (step, made);
            break (engine, is_cut);
        }
        wanted = step * factor;
        largest_factor = 1.0;
    };
    let is_at_end = is_cut && g.step.0[lane].is_finite();
    let (time, residue) =
        if is_at_end { (l.end.0[lane], 0.0) } else { two_sum(begin[0], g.step.0[lane] + begin[1]) };
    (l.begin[0].0[lane], l.begin[1].0[lane]) = (begin[0], begin[1]);
    (l.now[0].0[lane], l.now[1].0[lane]) = (time, residue);
    let reached = some_ends((l.next.0[lane] - time) * l.direction.0[lane]);
    if reached || is_last {
        let mut inside = Coefficients::new();
        engine.expand_step::<L, D>(&before, &y, &mut slopes, &mut inside);
        for k in 0..=inside.highest() {
            for d in 0..D {
                l.powers[k][d].0[lane] = inside.order(k)[d];
            }
        }
    }
    reached
}

/// The error of a step over the tolerance: of the rates relative to the fastest known or met, of the attitude and of the
/// place on the orbit in rad. The balance follows from the motion, so the balance is ignored. The estimates of order 5 and
/// 3 become one that falls as the eighth power of the step (Hairer, Nørsett, Wanner, section II.10).
#[inline(always)]
fn error<L: Layout, const D: usize>(
    before: &[f64; D],
    after: &[f64; D],
    estimates: &[[f64; D]; 2],
    [known_rate, tolerance]: [f64; 2],
) -> f64 {
    let rate = known_rate.max(speed(before)).max(speed(after)).max(f64::MIN_POSITIVE);
    let mut largest = [0.0_f64; 2];
    for i in 0..2 {
        for d in (0..L::BALANCE_AT).chain(L::OWN_AT..D) {
            let size = match d {
                0..3 => rate,
                // The place on the orbit, by its angle.
                _ if d >= L::OWN_AT => 1.0,
                // A quaternion changes by half of the angle.
                _ => 0.5,
            };
            let off = estimates[i][d].abs() / size;
            // A NaN remains.
            largest[i] = if off > largest[i] || off.is_nan() { off } else { largest[i] };
        }
    }
    let [fifth, third] = largest;
    if fifth == 0.0 {
        return 0.0;
    }
    // Squares of the estimates would underflow where a smooth torque sets in.
    let ratio = third / fifth;
    fifth / (1.0 + 0.01 * ratio * ratio).sqrt() / tolerance.max(LEAST_ERROR)
}
