//! Bodies side by side, each in steps of its own: how far the series of a body reaches, and its states in between.

use crate::group::{Group, LANES, MAX_STATE, Row};
use crate::method::{Coefficients, MAX_ORDER, Scheme, two_sum};
use crate::model::{Layout, Model, Parameters};
use crate::real::{Pack, Real};
use crate::special::{exp, ln};

/// Where each body of a group is, and the polynomial that took it there.
#[derive(Clone)]
pub struct Leaps {
    /// Coefficients of the last step, in powers of the time since its begin over `unit`.
    pub powers: Vec<[Row; MAX_STATE]>,
    /// See `powers`.
    pub unit: Row,
    /// Begin of the last step, and what rounding took from it.
    pub begin: [Row; 2],
    /// Its end.
    pub now: [Row; 2],
    /// When something is to be done; infinite for lanes that wait.
    pub next: Row,
    /// Where what acts from outside changes: no step goes beyond.
    pub end: Row,
    /// 1 forward, -1 backward.
    pub direction: Row,
    /// One over the rate that rates are compared with.
    pub inverse_rate: Row,
    /// Size of the last terms of a step.
    pub tolerance: f64,
}

impl Leaps {
    /// Lanes that wait.
    pub fn waiting(tolerance: f64) -> Leaps {
        let nothing = Row([0.0; LANES]);
        Leaps {
            powers: vec![[nothing; MAX_STATE]; MAX_ORDER + 1],
            unit: nothing,
            begin: [nothing; 2],
            now: [nothing; 2],
            next: Row([f64::INFINITY; LANES]),
            end: Row([f64::INFINITY; LANES]),
            direction: Row([1.0; LANES]),
            inverse_rate: nothing,
            tolerance,
        }
    }
}

/// Advances every lane by steps of its own until one of them has to be looked at; returns their number, `most` at
/// most. A lane whose state is no number has to be looked at too: its time is then none either.
#[inline(always)]
pub fn leap<P: Pack, const PACKS: usize, M, L, S, const D: usize>(
    g: &mut Group,
    l: &mut Leaps,
    bodies: &[(Parameters<P>, S); PACKS],
    most: usize,
) -> usize
where
    M: Model<P>,
    L: Layout,
    S: Scheme<P, M, L, D>,
{
    for done in 1..=most {
        let mut look = false;
        for b in 0..PACKS {
            let at = b * P::LANES;
            let unit = P::load(&g.step.0[at..]);
            let (mut y, mut carry) = ([unit; D], [unit; D]);
            for d in 0..D {
                y[d] = P::load(&g.state[d].0[at..]);
                carry[d] = P::load(&g.carry[d].0[at..]);
            }
            let mut c = Coefficients::new();
            bodies[b].1.coefficients(unit, &y, &mut c);
            let inverse_rate = P::load(&l.inverse_rate.0[at..]);
            let mut reach = reach::<P, L, D>(&c, S::ORDER, inverse_rate, P::splat(l.tolerance));
            if M::DRIVEN {
                let now = P::load(&l.now[0].0[at..]) + P::load(&l.now[1].0[at..]);
                // The second argument wins where one is no number.
                reach = ((P::load(&l.end.0[at..]) - now) / unit).min(reach);
            }
            let mut rise = *c.order(S::ORDER);
            for k in (1..S::ORDER).rev() {
                for d in 0..D {
                    rise[d] = rise[d].fma(reach, c.order(k)[d]);
                }
            }
            let mut health = P::splat(0.0);
            for d in 0..D {
                (y[d], carry[d]) = two_sum(y[d], rise[d].fma(reach, carry[d]));
                health = y[d].fma(P::splat(0.0), health);
                y[d].store(&mut g.state[d].0[at..]);
                carry[d].store(&mut g.carry[d].0[at..]);
            }
            for k in 0..=S::ORDER {
                for d in 0..D {
                    c.order(k)[d].store(&mut l.powers[k][d].0[at..]);
                }
            }
            let step = unit.fma(reach, health);
            unit.store(&mut l.unit.0[at..]);
            step.store(&mut g.step.0[at..]);

            let begin = [P::load(&l.now[0].0[at..]), P::load(&l.now[1].0[at..])];
            let (time, lost) = two_sum(begin[0], step + begin[1]);
            begin[0].store(&mut l.begin[0].0[at..]);
            begin[1].store(&mut l.begin[1].0[at..]);
            time.store(&mut l.now[0].0[at..]);
            lost.store(&mut l.now[1].0[at..]);
            let ahead = (P::load(&l.next.0[at..]) - time) * P::load(&l.direction.0[at..]);
            let (zero, one) = (P::splat(0.0), P::splat(1.0));
            // Not ahead, or no number.
            look |= P::any(zero.lt(P::select(zero.lt(ahead), zero, one)));
        }
        if look {
            return done;
        }
    }
    most
}

/// How many units the series may be followed: until one of its last two terms would be the tolerance, with the
/// margin of Jorba & Zou 2005, eq. (3-8) (doi 10.1080/10586458.2005.10128904).
#[inline(always)]
fn reach<R: Real, L: Layout, const D: usize>(
    c: &Coefficients<R, D>,
    order: usize,
    inverse_rate: R,
    tolerance: R,
) -> R {
    let last = room::<R, L, D>(c.order(order), inverse_rate, tolerance) * R::splat(1.0 / order as f64);
    let before =
        room::<R, L, D>(c.order(order - 1), inverse_rate, tolerance) * R::splat(1.0 / (order - 1) as f64);
    // From one step to the next at most a factor of 2^30: what stands still has no scale.
    let bound = R::splat(30.0 * std::f64::consts::LN_2);
    let margin = R::splat(0.7 / (order - 1) as f64);
    exp((last.min(before) - margin).min(bound).max(-bound))
}

/// ln of the tolerance over the largest number of a term. The balance follows the motion: it does not count.
#[inline(always)]
fn room<R: Real, L: Layout, const D: usize>(term: &[R; D], inverse_rate: R, tolerance: R) -> R {
    let mut largest = R::splat(f64::MIN_POSITIVE);
    for d in 0..L::BALANCE_AT {
        let size = if d < 3 { term[d].abs() * inverse_rate } else { term[d].abs() };
        largest = largest.max(size);
    }
    ln(tolerance) - ln(largest)
}

/// The state of a lane inside its last step, that many units after its begin.
#[inline(always)]
pub fn inside<const D: usize>(l: &Leaps, order: usize, lane: usize, units: f64) -> [f64; MAX_STATE] {
    let mut y = [0.0; MAX_STATE];
    for k in (0..=order).rev() {
        for d in 0..D {
            y[d] = y[d].fma(units, l.powers[k][d].0[lane]);
        }
    }
    y
}
