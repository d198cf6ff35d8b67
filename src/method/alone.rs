//! The Taylor series of one body alone: the lanes of a register hold its directions, not other bodies.
//!
//! All directions have the same products with the rates. So one operation makes the products of all of them. The sums
//! have the order of `Taylor`, so a coefficient has the same bits.

use super::taylor::times_unit;
use super::{Coefficients, Taylor};
use crate::kinematics::{add_turn_across, add_turn_along, dot};
use crate::real::{Quad, is_finite};
use crate::scene::{Layout, Model};
use crate::series::INVERSE;

/// Length of a state in registers: three columns and the balance.
pub const COLUMNS: usize = 4;

/// A state in registers. Column i has component i of the directions 0, 1 and 2 and of the rates. The last register has
/// impulse, time, zero and work.
pub type Columns<R> = [R; COLUMNS];

/// The coefficients of one order: the first three columns; the rates 1, 2 and 3, each in all lanes; the rates in the order
/// 2, 3, 1 and in the order 3, 1, 2, side by side.
type Terms<R> = [R; 8];

/// The coefficients of a step, by order.
pub struct SeriesAlone<R> {
    terms: Coefficients<R, 8>,
    torques: Coefficients<R, 3>,
    balance: Coefficients<R, 1>,
}

impl<R: Quad> SeriesAlone<R> {
    /// No coefficients yet.
    #[inline(always)]
    #[allow(clippy::new_without_default)] // A default would be taken for zero.
    pub fn new() -> Self {
        SeriesAlone { terms: Coefficients::new(), torques: Coefficients::new(), balance: Coefficients::new() }
    }

    /// The columns of one order. The last one is zero without a balance.
    #[inline(always)]
    pub fn columns<L: Layout>(&self, k: usize) -> Columns<R> {
        let [n1, n2, n3, ..] = *self.terms.order(k);
        [n1, n2, n3, if L::BALANCE { self.balance.order(k)[0] } else { R::splat(0.0) }]
    }

    /// The directions and the rates of one order.
    #[inline(always)]
    pub fn directions(&self, k: usize) -> [R; 3] {
        first_three(self.terms.order(k))
    }

    /// The highest order known.
    #[inline(always)]
    pub fn highest(&self) -> usize {
        self.terms.highest()
    }
}

/// Index in the state of the number in a lane of a column; `None` if nothing stands there. The second of two directions
/// stands in two lanes.
#[inline(always)]
pub fn in_columns<L: Layout>(column: usize, lane: usize) -> Option<usize> {
    match (column, lane) {
        (3, _) if !L::BALANCE => None,
        (3, 0) => Some(L::IMPULSE_AT),
        (3, 1) => Some(L::TIME_AT),
        (3, 2) => None,
        (3, _) => Some(L::BALANCE_AT),
        (_, 3) => Some(column),
        _ => Some(3 + 3 * (if lane < L::VECTORS { lane } else { L::VECTORS - 1 }) + column),
    }
}

/// Cauchy products of one order: of the rates with each other, side by side, and of the rates with the directions.
#[derive(Clone, Copy)]
struct Products<R> {
    rates: R,
    directions: [R; 3],
}

impl<R: Quad> Products<R> {
    #[inline(always)]
    fn none() -> Self {
        Products { rates: R::splat(0.0), directions: [R::splat(0.0); 3] }
    }

    /// Adds the products of the rates of one order with the rates and directions of another order.
    #[inline(always)]
    fn add(&mut self, [_, _, _, w1, w2, w3, w231, _]: &Terms<R>, other: &Terms<R>) {
        let [n1, n2, n3, .., v312] = other;
        let n = [*n1, *n2, *n3];
        self.rates = w231.fma(*v312, self.rates);
        add_turn_along(&n, *w3, &mut self.directions);
        add_turn_across(&n, [*w1, *w2], &mut self.directions);
    }
}

/// The directions and the rates among terms.
#[inline(always)]
fn first_three<R: Copy>([n1, n2, n3, ..]: &Terms<R>) -> [R; 3] {
    [*n1, *n2, *n3]
}

/// The terms of directions and rates.
#[inline(always)]
fn terms<R: Quad>([n1, n2, n3]: [R; 3], [w1, w2, w3]: [R; 3]) -> Terms<R> {
    let (w231, w312) = (w2.with_middle(w3, w1), w3.with_middle(w1, w2));
    [n1.with_last(w1), n2.with_last(w2), n3.with_last(w3), w1, w2, w3, w231, w312]
}

/// A state with the time and each number in all lanes, as the torque takes it.
#[inline(always)]
fn spread<R: Quad, L: Layout, const D: usize>(terms: &Terms<R>, time: R) -> [R; D] {
    let mut y = [time; D];
    for i in 0..3 {
        y[i] = terms[3 + i];
        for v in 0..L::VECTORS {
            y[3 + 3 * v + i] = terms[i].lane(v);
        }
    }
    y
}

impl<R: Quad, M: Model<R>> Taylor<R, M> {
    /// All coefficients of the motion that starts at `y`, but for those of the balance: those of `coefficients`, in columns.
    #[inline(always)]
    pub fn expand_alone<L: Layout, const D: usize>(
        &self,
        unit: R,
        y: &Columns<R>,
        series: &mut SeriesAlone<R>,
    ) {
        let SeriesAlone { terms: c, torques, .. } = series;
        let time = y[3].lane(1);
        let mut all_orders = self.has_high_orders;
        // Twice at most.
        loop {
            c.clear();
            torques.clear();
            c.push(terms([y[0], y[1], y[2]], [y[0].lane(3), y[1].lane(3), y[2].lane(3)]));
            for half in 0..self.order / 2 {
                let (rows, k) = (c.all(), 2 * half);
                assert!(rows.len() == k + 1);
                let (mut sums, mut after) = (Products::none(), Products::none());
                for j in 1..k {
                    sums.add(&rows[j], &rows[k - j]);
                    after.add(&rows[j + 1], &rows[k - j]);
                }
                if k > 0 {
                    sums.add(&rows[0], &rows[k]);
                    after.add(&rows[1], &rows[k]);
                }
                sums.add(&rows[k], &rows[0]);
                let next = self.next_alone::<L, D>([unit, time], sums, (torques, all_orders), rows);
                c.push(next);
                let rows = c.all();
                after.add(&rows[0], &next);
                after.add(&next, &rows[0]);
                let next = self.next_alone::<L, D>([unit, time], after, (torques, all_orders), rows);
                c.push(next);
            }
            // As in `coefficients`.
            if !L::BALANCE || all_orders || is_finite(&first_three(c.order(c.highest()))) {
                break;
            }
            all_orders = true;
        }
    }

    /// The coefficients of order k + 1, from the products of order k, the highest one known.
    #[inline(always)]
    fn next_alone<L: Layout, const D: usize>(
        &self,
        [unit, time]: [R; 2],
        sums: Products<R>,
        (torques, all_orders): (&mut Coefficients<R, 3>, bool),
        rows: &[Terms<R>],
    ) -> Terms<R> {
        let k = rows.len() - 1;
        let (factor, zero) = (unit * R::splat(INVERSE[k + 1]), R::splat(0.0));
        let [n1, n2, n3, w1, w2, w3, ..] = rows[k];
        let gamma = [w1, w2, w3, n1.lane(0), n2.lane(0), n3.lane(0)];
        let products = [sums.rates.lane(0), sums.rates.lane(1), sums.rates.lane(2)];
        let acceleration = self.model.euler(&products, &gamma);
        let mut rates = [factor * acceleration[0], factor * acceleration[1], factor * acceleration[2]];
        if L::BALANCE {
            let torque = if k == 0 {
                self.applied.torque::<L, D>(&spread::<R, L, D>(&rows[0], time))
            } else if k == 1 || all_orders {
                // The time is of order 1.
                let (start, of_time) = (spread::<R, L, D>(&rows[0], time), if k == 1 { unit } else { zero });
                let now = spread::<R, L, D>(&rows[k], of_time);
                let before = times_unit::<R, L, D>(&spread::<R, L, D>(&rows[k - 1], zero), unit);
                self.applied.torque_of_order::<L, D>(&start, &now, &before)
            } else {
                self.applied.damped([zero; 3], [w1, w2, w3])
            };
            torques.push(torque);
            let change = self.applied.over_moments(&torque);
            for i in 0..3 {
                rates[i] = factor.fma(change[i], rates[i]);
            }
        }
        let [d1, d2, d3] = sums.directions;
        terms([factor * d1, factor * d2, factor * d3], rates)
    }

    /// The coefficients of the balance: the torque times the vertical is the impulse, and times the rates the power. No
    /// other coefficient needs them, so they come last, two orders side by side.
    #[inline(always)]
    pub fn add_balance_alone(&self, unit: R, start: R, series: &mut SeriesAlone<R>) {
        let SeriesAlone { terms, torques, balance } = series;
        let (rows, torques, zero) = (terms.all(), torques.all(), R::splat(0.0));
        assert!(rows.len() == torques.len() + 1);
        balance.clear();
        balance.push([start]);
        for half in 0..self.order / 2 {
            let k = 2 * half;
            let (mut sum, mut after) = (zero, zero);
            // Without indices the compiler checks none.
            for (torque, pair) in torques[..k + 1].iter().zip(rows[..k + 2].windows(2).rev()) {
                sum = sum + along(torque, &pair[0]);
                after = after + along(torque, &pair[1]);
            }
            after = after + along(&torques[k + 1], &rows[0]);
            let of_time = if k == 0 { unit } else { zero };
            balance.push([(unit * R::splat(INVERSE[k + 1]) * sum).with_middle(of_time, zero)]);
            balance.push([(unit * R::splat(INVERSE[k + 2]) * after).with_middle(zero, zero)]);
        }
    }
}

/// A torque times directions and rates.
#[inline(always)]
fn along<R: Quad>(torque: &[R; 3], terms: &Terms<R>) -> R {
    dot(torque, &first_three(terms))
}
