//! Taylor series in time of a motion: one engine, any order.
//!
//! The equations of motion are quadratic, so each order follows from the Cauchy products of the lower ones
//! (Jorba & Zou 2005, §2). Coefficients are those of powers of t / step: their sum is the state after a step.

use super::tangent::turn;
use super::{Engine, EngineName, Facts, Limits, Method, Numbers, Proposal, Step, Variables};
use super::{acceleration, turning_of_rates};
use crate::dual::Dual;
use crate::forces::{ForcesInterval, Further, FurtherSeries, Order, TrajectorySeries};
use crate::kinematics::{
    add_cross, add_roll_across, add_roll_along, add_turn_across, add_turn_along, cross, direction, plus, put,
};
use crate::real::{Outlined, Real, is_finite, two_sum};
use crate::scene::{
    Applied, Layout, MOVED, Model, Moved, Parameters, Varied, add_turned_axes, moved_by, quaternion,
};
use crate::series::{Coefficients, INVERSE, MAX_ORDER, VectorSeries};
use crate::special::{exp, ln};
use std::marker::PhantomData;

/// A loop over the indices 0 .. D of a state, in two halves: the compiler unrolls only loops that are short enough, and
/// an index that is no constant would keep the state in memory.
macro_rules! in_halves {
    ($index:ident in $length:ident $body:block) => {
        for $index in 0..$length / 2 $body
        for $index in $length / 2..$length $body
    };
}
pub(crate) use in_halves;

/// The order from which on the rounding error of the state is compensated. Compensation costs 4 % of a step of order
/// 16, and 13 % of a step of order 8; steps of order 8 are seldom so short that rounding matters.
const COMPENSATED_FROM: usize = 16;

/// A series of an even order, with the largest angles of a step, by default and borne, and the damping limit.
macro_rules! series {
    ($order:literal, $angle:expr, $longest:literal, $damping_limit:literal) => {
        Method::direct(
            Facts {
                name: concat!("taylor", $order),
                title: concat!("Taylor series of order ", $order),
                order: $order,
                stages: $order,
                symplectic: false,
                reversible: false,
                group_preserving: false,
                conserves: &[],
                angle_per_step: $angle,
                longest_angle: $longest,
                citation: "A. Jorba, M. Zou, A software package for the numerical integration of ODEs by means of \
                           high-order Taylor methods, Exp. Math. 14 (2005) 99-117; F. Biscani, D. Izzo, \
                           Revisiting high-order Taylor methods for astrodynamics and celestial mechanics, \
                           Mon. Not. R. Astron. Soc. 504 (2021) 2614-2628, doi 10.1093/mnras/stab1032",
                doi: "10.1080/10586458.2005.10128904",
            },
            Step {
                engine: EngineName::Taylor,
                numbers: &Numbers {
                    order: $order,
                    is_compensated: $order >= COMPENSATED_FROM,
                    ..Numbers::NONE
                },
            },
            $damping_limit,
        )
    };
}

// With these angles per step, the attitudes of 600 random bodies and tops were off by at most 4e-14 rad per radian
// turned.
/// Taylor series of order 12.
pub const TAYLOR12: Method = series!(12, 2.0 / 5.0, 0.95, 2.91);
/// Taylor series of order 16.
pub const TAYLOR16: Method = series!(16, 3.0 / 4.0, 1.0, 3.66);
/// Taylor series of order 20.
pub const TAYLOR20: Method = series!(20, 9.0 / 10.0, 1.2, 4.41);
/// Taylor series of order 26.
pub const TAYLOR26: Method = series!(26, 9.0 / 8.0, 1.3, 5.53);

/// Cauchy products of one order: of the rates with each other, with the directions and with the quaternion.
#[derive(Clone, Copy)]
struct Products<R> {
    rates: [R; 3],
    directions: [[R; 3]; 3],
    quaternion: [R; 4],
}

impl<R: Real> Products<R> {
    #[inline(always)]
    fn none() -> Self {
        let zero = R::splat(0.0);
        Products { rates: [zero; 3], directions: [[zero; 3]; 3], quaternion: [zero; 4] }
    }

    /// Adds the products of the rates of one order with the rates, directions and quaternion of another order.
    #[inline(always)]
    fn add<L: Layout, const D: usize>(&mut self, a: &[R; D], b: &[R; D]) {
        let [w1, w2, w3] = [a[0], a[1], a[2]];
        add_rates(a, b, &mut self.rates);
        for v in 0..L::VECTORS {
            add_turn_along(&direction(b, v), w3, &mut self.directions[v]);
        }
        if L::QUATERNION {
            add_roll_along(&quaternion::<L, R, D>(b), w3, &mut self.quaternion);
        }
        for v in 0..L::VECTORS {
            add_turn_across(&direction(b, v), [w1, w2], &mut self.directions[v]);
        }
        if L::QUATERNION {
            add_roll_across(&quaternion::<L, R, D>(b), [w1, w2], &mut self.quaternion);
        }
    }
}

/// Adds the products of the rates of one order with those of another.
#[inline(always)]
pub(super) fn add_rates<R: Real, const D: usize>(a: &[R; D], b: &[R; D], sums: &mut [R; 3]) {
    *sums = [a[1].fma(b[2], sums[0]), a[2].fma(b[0], sums[1]), a[0].fma(b[1], sums[2])];
}

/// The engine.
#[derive(Clone, Copy)]
pub struct Taylor<R, M> {
    pub(super) model: M,
    pub(super) applied: Applied<R>,
    step: R,
    pub(super) order: usize,
    /// Whether the rounding of a step is added to the next.
    is_compensated: bool,
    /// Whether orders above 1 of the applied torque have more than damping.
    pub(super) has_high_orders: bool,
}

impl<R: Real, M: Model<R>> Taylor<R, M> {
    /// All coefficients of the motion that starts at `y`. Two orders are summed side by side, because both need the
    /// same rows. The newest rows are summed last, so that the first sums need not wait.
    #[inline(always)]
    pub fn coefficients<L: Layout, const D: usize>(&self, unit: R, y: &[R; D], c: &mut Coefficients<R, D>) {
        let side_by_side = const { L::VECTORS < 3 };
        for all_orders in [self.has_high_orders, true] {
            // Made here: a value that is assigned again is copied.
            let (mut series, mut moved) = (Beside::new(all_orders), MovedSeries::new(self));
            c.clear();
            c.push(*y);
            for half in 0..self.order / 2 {
                let k = 2 * half;
                let (mut sums, mut after) = (Products::none(), Products::none());
                for j in 1..k {
                    sums.add::<L, D>(c.order(j), c.order(k - j));
                    if side_by_side {
                        after.add::<L, D>(c.order(j + 1), c.order(k - j));
                    }
                }
                if k > 0 {
                    sums.add::<L, D>(c.order(0), c.order(k));
                    if side_by_side {
                        after.add::<L, D>(c.order(1), c.order(k));
                    }
                }
                sums.add::<L, D>(c.order(k), c.order(0));
                self.push_next::<L, D>(unit, sums, (&mut series, &mut moved), c, k);
                if !side_by_side {
                    for j in 1..k {
                        after.add::<L, D>(c.order(j + 1), c.order(k - j));
                    }
                    if k > 0 {
                        after.add::<L, D>(c.order(1), c.order(k));
                    }
                }
                after.add::<L, D>(c.order(0), c.order(k + 1));
                after.add::<L, D>(c.order(k + 1), c.order(0));
                self.push_next::<L, D>(unit, after, (&mut series, &mut moved), c, k + 1);
            }
            // All coefficients are finite if those of the highest order are: where one overflows, so do those after it. A
            // torque that is zero times one that has overflowed is not a number, and may not be skipped.
            if !(L::BALANCE && L::VECTORS > 0) || series.all_orders || is_finite(&directions::<R, L, D>(c)) {
                break;
            }
        }
        if L::TANGENT && !L::FURTHER {
            self.deviation::<L, D>(unit, c);
        }
    }

    /// Adds the sum of a series to the numbers at its begin; `first` is the index of the first of them.
    #[inline(always)]
    fn add_series<const N: usize, const D: usize>(
        &self,
        c: &Coefficients<R, D>,
        first: usize,
        y: &mut [R; N],
        compensation: &mut [R; N],
    ) {
        // Small terms first, the state last.
        let mut increment = *y;
        let (last, before) = (c.order(self.order), c.order(self.order - 1));
        in_halves!(d in N { increment[d] = last[first + d] + before[first + d]; });
        for k in (1..self.order - 1).rev() {
            in_halves!(d in N { increment[d] = increment[d] + c.order(k)[first + d]; });
        }
        if self.is_compensated {
            in_halves!(d in N {
                (y[d], compensation[d]) = two_sum(y[d], increment[d] + compensation[d]);
            });
        } else {
            in_halves!(d in N { y[d] = y[d] + increment[d]; });
        }
    }

    /// Adds the coefficients of order k + 1, from the products of order k.
    #[inline(always)]
    fn push_next<L: Layout, const D: usize>(
        &self,
        unit: R,
        sums: Products<R>,
        (series, moved): (&mut Beside<R>, &mut MovedSeries<R, M>),
        c: &mut Coefficients<R, D>,
        k: usize,
    ) {
        let mut next = self.next::<L, D>(unit, sums, (c.order(k), k));
        if L::FURTHER {
            self.add_further::<L, D>(unit, &sums.rates, (series, moved), c, &mut next, k);
        } else if L::BALANCE {
            self.add_applied::<L, D>(unit, series, c, &mut next, k);
        }
        c.push(next);
    }

    /// The coefficients of order k + 1 from the products and the coefficients of order k.
    #[inline(always)]
    fn next<L: Layout, const D: usize>(
        &self,
        unit: R,
        sums: Products<R>,
        (of_k, k): (&[R; D], usize),
    ) -> [R; D] {
        let factor = unit * R::splat(INVERSE[k + 1]);
        let acceleration = self.model.euler(&sums.rates, of_k);
        // Every number is written: those of the balance by `add_applied`, those of the deviation vector by `deviation`.
        let mut next = [unit; D];
        for i in 0..3 {
            next[i] = factor * acceleration[i];
            for v in 0..L::VECTORS {
                next[3 + 3 * v + i] = factor * sums.directions[v][i];
            }
        }
        if L::QUATERNION {
            let half = factor * R::splat(0.5);
            for i in 0..4 {
                next[L::QUATERNION_AT + i] = half * sums.quaternion[i];
            }
        }
        next
    }

    /// Adds the applied torque to the coefficients of order k + 1, and computes those of the balance. The coefficient
    /// of the torque of order k is linear in the states of orders k and k - 1; the power is one more Cauchy product.
    #[inline(always)]
    fn add_applied<L: Layout, const D: usize>(
        &self,
        unit: R,
        Beside { torques, all_orders, .. }: &mut Beside<R>,
        c: &Coefficients<R, D>,
        next: &mut [R; D],
        k: usize,
    ) {
        let factor = unit * R::splat(INVERSE[k + 1]);
        let newest = torque_of_order::<R, L, D>(&self.applied, unit, c, k, *all_orders);
        torques.push(k, newest);
        let change = self.applied.over_moments(&newest);
        for i in 0..3 {
            next[i] = factor.fma(change[i], next[i]);
        }
        let mut balance = [R::splat(0.0); 2];
        for j in 0..k + 1 {
            // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
            let torque = unsafe { torques.order(j) };
            let [power, impulse] = self.applied.balance::<L, D>(torque, c.order(k - j));
            balance = [balance[0] + power, balance[1] + impulse];
        }
        next[L::BALANCE_AT] = factor * balance[0];
        next[L::BALANCE_AT + 1] = factor * balance[1];
        next[L::BALANCE_AT + 2] = if k == 0 { unit } else { R::splat(0.0) };
    }

    /// Adds the further forces to the coefficients of order k + 1, with torque and damping, and computes those of the balance
    /// and of the variables of the forces: `Applied::under_further` by Cauchy products.
    #[inline(always)]
    fn add_further<L: Layout, const D: usize>(
        &self,
        unit: R,
        products: &[R; 3],
        (beside, moved): (&mut Beside<R>, &mut MovedSeries<R, M>),
        c: &Coefficients<R, D>,
        next: &mut [R; D],
        k: usize,
    ) {
        let gains = if L::TANGENT {
            self.gains_with_change::<L, D>(unit, (beside, moved), c, next, k)
        } else {
            let (equations, at) = ((&self.model, &self.applied), (unit, k, beside.all_orders));
            gains_of_order::<R, M, L, D>(equations, at, products, &mut beside.further, c, next)
        };
        let Beside { torques, impulse, further: TurnSeries { turn, .. }, .. } = beside;
        torques.push(k, gains.torque);
        impulse.push(k, gains.impulse);
        let (applied, factor) = (&self.applied, unit * R::splat(INVERSE[k + 1]));
        let mut turned = [[R::splat(0.0); 3]; 3];
        // The check of an index would keep a loop that does nothing.
        for j in 0..if L::VECTORS > 0 { k + 1 } else { 0 } {
            // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
            let sink = unsafe { turn.order(k - j) };
            for v in 0..L::VECTORS {
                add_cross(&direction(c.order(j), v), sink, &mut turned[v]);
            }
        }
        for i in 0..3 {
            next[i] = factor * gains.rate[i];
            for v in 0..L::VECTORS {
                next[3 + 3 * v + i] = factor.fma(turned[v][i], next[3 + 3 * v + i]);
            }
        }
        let mut balance = [R::splat(0.0); 2];
        for j in 0..k + 1 {
            // SAFETY: as above.
            let (torque, impulse) = unsafe { (torques.order(j), impulse.order(j)) };
            let [power, _] = applied.balance::<L, D>(torque, c.order(k - j));
            let [_, gained] = applied.balance::<L, D>(impulse, c.order(k - j));
            balance = [balance[0] + power, balance[1] + gained];
        }
        put(next, L::BALANCE_AT, [factor * balance[0], factor * balance[1]]);
        next[L::TIME_AT] = if k == 0 { unit } else { R::splat(0.0) };
    }

    /// The same gains with their changes by the deviation vector, whose coefficients of order k + 1 are written too.
    #[inline(always)]
    fn gains_with_change<L: Layout, const D: usize>(
        &self,
        unit: R,
        (beside, moved): (&mut Beside<R>, &mut MovedSeries<R, M>),
        c: &Coefficients<R, D>,
        next: &mut [R; D],
        k: usize,
    ) -> Gains<R> {
        let (applied, MovedSeries { equations, rows, next: next_moved, further, frames }) =
            (&self.applied, moved);
        if k == 0 {
            rows.push(applied.moved::<L, D>(c.order(0)));
        } else {
            let mut axes = [[R::splat(0.0); 3]; 3];
            for j in 0..k + 1 {
                add_turned_axes::<R, L, D>(c.order(j), c.order(k - j), &mut axes);
            }
            rows.push(moved_by::<R, L, D>(c.order(k), &axes, *next_moved));
        }
        let mut products = [Dual::splat(0.0); 3];
        for j in 0..k + 1 {
            add_rates(rows.order(j), rows.order(k - j), &mut products);
        }
        let gains = gains_of_order::<Dual<R>, M::Varied, Moved, MOVED>(
            (&equations.0, &equations.1),
            (Dual::constant(unit), k, beside.all_orders),
            &products,
            further,
            rows,
            next_moved,
        );
        let frame = plus(&rates(rows.order(k)), &gains.turn);
        frames.push(k, Dual::values(&frame));
        let mut turning = Dual::slopes(&frame);
        for j in 0..k + 1 {
            // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
            let frame = unsafe { frames.order(k - j) };
            add_cross(&turn::<R, L, D>(c.order(j)), frame, &mut turning);
        }
        let (factor, spin) = (unit * R::splat(INVERSE[k + 1]), Dual::slopes(&gains.rate));
        for i in 0..3 {
            next[L::TANGENT_AT + i] = factor * spin[i];
            next[L::TANGENT_AT + 3 + i] = factor * turning[i];
        }
        for d in 0..L::OWN {
            next[L::OWN_AT + d] = next_moved[Moved::OWN_AT + d].value;
        }
        beside.further.turn.push(k, Dual::values(&gains.turn));
        Gains {
            rate: Dual::values(&gains.rate),
            turn: Dual::values(&gains.turn),
            torque: Dual::values(&gains.torque),
            impulse: Dual::values(&gains.impulse),
        }
    }
}

/// What acts under further forces, of one order.
struct Gains<R> {
    /// The rate of change of the rates.
    rate: [R; 3],
    /// The turn of the frame by the dissipation.
    turn: [R; 3],
    /// The torque that does work.
    torque: [R; 3],
    /// The torque of the impulse.
    impulse: [R; 3],
}

/// The gains of order k, from the products of the rates; those of order k + 1 of the variables of the forces are written.
#[inline(always)]
fn gains_of_order<R: Real, M: Model<R>, L: Layout, const D: usize>(
    (model, applied): (&M, &Applied<R>),
    (unit, k, all_orders): (R, usize, bool),
    products: &[R; 3],
    TurnSeries { turn, rotor, rotor_changes, torques, on_trajectory }: &mut TurnSeries<R>,
    c: &Coefficients<R, D>,
    next: &mut [R; D],
) -> Gains<R> {
    let of_k = c.order(k);
    let at = Order { k, own: L::OWN_AT, factor: unit * R::splat(INVERSE[k + 1]) };
    let mut torque = torque_of_order::<R, L, D>(applied, unit, c, k, all_orders);
    applied.add_further_orders::<L, D>(c, at, (torques, on_trajectory), next, &mut torque);
    if k == 0 {
        let (momentum, change) = applied.rotor_from(c.order(0)[L::TIME_AT], unit);
        rotor.push(0, momentum);
        *rotor_changes = change.is_some();
        if let Some(change) = change {
            rotor.push(1, change);
        }
    }
    // SAFETY: the call for the order 0 has pushed the first row, and the second if there is a change.
    let (momentum, change_of_rotor) =
        unsafe { (rotor.order(0), if k > 0 && *rotor_changes { Some(rotor.order(1)) } else { None }) };
    let by_rotor = across_rotor((momentum, change_of_rotor), &rates(of_k), || rates(c.order(k - 1)));
    let impulse = plus(&by_rotor, &torque);
    let change = applied.over_moments(&impulse);
    let rate = plus(&model.euler(products, of_k), &change);
    let sink = applied.turn(&rate);
    turn.push(k, sink);
    // SAFETY: the calls for the orders 0 to k - 1, one each and ascending, have pushed the row k - 1.
    let by_rotor = across_rotor((momentum, change_of_rotor), &sink, || unsafe { *turn.order(k - 1) });
    let mut by_turn = by_rotor;
    for j in 0..k + 1 {
        // SAFETY: the calls for the orders 0 to k, one each and ascending, have pushed the rows 0 to k.
        let sink = unsafe { turn.order(k - j) };
        add_cross(&applied.momentum(&rates(c.order(j))), sink, &mut by_turn);
    }
    Gains {
        rate: plus(&rate, &applied.over_moments(&by_turn)),
        turn: sink,
        torque: plus(&torque, &by_turn),
        impulse: plus(&impulse, &by_rotor),
    }
}

/// The coefficient of an order of `h x v`, from that of v; if h changes, also from that of the order before.
#[inline(always)]
fn across_rotor<R: Real>(
    (momentum, change): (&[R; 3], Option<&[R; 3]>),
    v: &[R; 3],
    before: impl FnOnce() -> [R; 3],
) -> [R; 3] {
    let mut sum = cross(momentum, v);
    if let Some(change) = change {
        add_cross(change, &before(), &mut sum);
    }
    sum
}

/// The coefficient of order k of the applied torque with damping.
#[inline(always)]
fn torque_of_order<R: Real, L: Layout, const D: usize>(
    applied: &Applied<R>,
    unit: R,
    c: &Coefficients<R, D>,
    k: usize,
    all_orders: bool,
) -> [R; 3] {
    let of_k = c.order(k);
    if k == 0 {
        applied.torque::<L, D>(of_k)
    } else if k == 1 || all_orders {
        let before = times_unit::<R, L, D>(c.order(k - 1), unit);
        applied.torque_of_order::<L, D>(c.order(0), of_k, &before)
    } else {
        applied.damped([R::splat(0.0); 3], rates(of_k))
    }
}

/// The rates of a state, or of one order of it.
#[inline(always)]
fn rates<R: Real, const D: usize>(y: &[R; D]) -> [R; 3] {
    [y[0], y[1], y[2]]
}

/// The directions among the coefficients of a state, times the unit of time; the other numbers have no meaning.
#[inline(always)]
pub(super) fn times_unit<R: Real, L: Layout, const D: usize>(of_state: &[R; D], unit: R) -> [R; D] {
    let mut scaled = [unit; D];
    for d in 3..L::BALANCE_AT {
        scaled[d] = of_state[d] * unit;
    }
    scaled
}

/// The directions among the coefficients of the highest order; in place of those that a layout has not, a rate.
#[inline(always)]
#[allow(clippy::manual_memcpy)] // The compiler does not always inline `copy_from_slice`.
fn directions<R: Real, L: Layout, const D: usize>(c: &Coefficients<R, D>) -> [R; 9] {
    let last = c.order(c.highest());
    let mut directions = [last[0]; 9];
    for d in 0..3 * L::VECTORS {
        directions[d] = last[3 + d];
    }
    directions
}

/// Coefficients beside those of the state.
struct Beside<R: Real> {
    torques: VectorSeries<R>,
    /// The torque of the impulse, under further forces.
    impulse: VectorSeries<R>,
    further: TurnSeries<R>,
    /// Whether no order of the torque is skipped.
    all_orders: bool,
}

impl<R: Real> Beside<R> {
    #[inline(always)]
    fn new(all_orders: bool) -> Self {
        Beside {
            torques: VectorSeries::new(),
            impulse: VectorSeries::new(),
            further: TurnSeries::new(),
            all_orders,
        }
    }
}

/// Coefficients under further forces.
struct TurnSeries<R: Real> {
    /// The turn of the frame by the dissipation.
    turn: VectorSeries<R>,
    /// The momentum of the rotor at the begin of the step, then, if it changes in some lane, the change over the unit of time.
    rotor: VectorSeries<R>,
    rotor_changes: bool,
    /// Those of the forces.
    torques: FurtherSeries<R>,
    on_trajectory: TrajectorySeries<R>,
}

impl<R: Real> TurnSeries<R> {
    #[inline(always)]
    fn new() -> Self {
        TurnSeries {
            turn: VectorSeries::new(),
            rotor: VectorSeries::new(),
            rotor_changes: false,
            torques: Further::series(),
            on_trajectory: TrajectorySeries::new(),
        }
    }
}

/// Coefficients under further forces, with their changes by a deviation vector. They are no part of `Beside`, so that
/// motions without one have no memory for them.
struct MovedSeries<R: Real, M: Model<R>> {
    equations: Varied<R, M>,
    rows: Coefficients<Dual<R>, MOVED>,
    /// The variables of the forces of the next order.
    next: [Dual<R>; MOVED],
    further: TurnSeries<Dual<R>>,
    /// The angular velocity of the frame.
    frames: VectorSeries<R>,
}

impl<R: Real, M: Model<R>> MovedSeries<R, M> {
    #[inline(always)]
    fn new(engine: &Taylor<R, M>) -> Self {
        MovedSeries {
            equations: engine.applied.varied(&engine.model),
            rows: Coefficients::new(),
            next: [Dual::splat(0.0); MOVED],
            further: TurnSeries::new(),
            frames: VectorSeries::new(),
        }
    }
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
pub fn bound_of_margins<R: Real>(last: R, before: R, order: usize) -> R {
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

/// The coefficients of a step under forces or with a deviation vector, in a function that fixed and adaptive steps
/// share: shorter series are up to 13 % faster in the loop over steps.
struct Expansion<'a, R, M, L, const D: usize> {
    engine: &'a Taylor<R, M>,
    unit: R,
    y: &'a [R; D],
    c: &'a mut Coefficients<R, D>,
    layout: PhantomData<L>,
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Outlined for Expansion<'_, R, M, L, D> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        self.engine.coefficients::<L, D>(self.unit, self.y, self.c);
    }
}

impl<R: Real, M: Model<R>> Taylor<R, M> {
    #[inline(always)]
    fn expanded<L: Layout, const D: usize>(&self, unit: R, y: &[R; D], c: &mut Coefficients<R, D>) {
        if const { L::BALANCE || L::TANGENT } {
            R::outlined(Expansion { engine: self, unit, y, c, layout: PhantomData::<L> });
        } else {
            self.coefficients::<L, D>(unit, y, c);
        }
    }
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for Taylor<R, M> {
    const VARIABLES: Variables = Variables::Rates;
    // The attitude of a top is integrated as rows of its matrix: the vertical, which the torque needs anyway, and
    // another direction cost less than the vertical and a quaternion.
    const MOVES: bool = !L::FUNCTION && !L::TURNS && !(M::HEAVY && L::QUATERNION);
    const HAS_TANGENT: bool = true;
    const COMPENSATES: bool = true;
    const IS_SERIES: bool = true;
    // Under further forces a deviation vector needs coefficients beside those of the motion.
    const SHARES_MOTION: bool = L::TANGENT && !L::FURTHER;

    #[inline(always)]
    fn new(p: &Parameters<R>, forces: &ForcesInterval<'static, R>, numbers: &'static Numbers) -> Self {
        // The bound shows the compiler that no index lies outside the table.
        let (model, applied) = (M::new(p), Applied::new(p, forces));
        let has_high_orders = L::BALANCE && applied.has_high_orders();
        let (order, is_compensated) = (numbers.order.min(MAX_ORDER), numbers.is_compensated);
        Taylor { model, applied, step: p.step, order, is_compensated, has_high_orders }
    }

    #[inline(always)]
    fn step(&self, p: &Parameters<R>, y: &mut [R; D]) {
        Engine::<R, M, L, D>::step_on(self, p, y, &mut [R::splat(0.0); D], &mut Coefficients::new());
    }

    #[inline(always)]
    fn step_on(
        &self,
        _p: &Parameters<R>,
        y: &mut [R; D],
        compensation: &mut [R; D],
        c: &mut Coefficients<R, D>,
    ) {
        self.expanded::<L, D>(self.step, y, c);
        self.add_series(c, 0, y, compensation);
    }

    #[inline(always)]
    fn move_deviation(&self, deviation: &mut [R; 6], compensation: &mut [R; 6], c: &mut Coefficients<R, D>) {
        c.set(0, L::TANGENT_AT, *deviation);
        self.deviation::<L, D>(self.step, c);
        self.add_series(c, L::TANGENT_AT, deviation, compensation);
    }

    #[inline(always)]
    fn propose(
        &mut self,
        unit: R,
        limits: &Limits<R>,
        y: &[R; D],
        c: &mut Coefficients<R, D>,
    ) -> Proposal<R, D> {
        self.expanded::<L, D>(unit, y, c);
        let order = c.highest();
        let mut share = step_bound::<R, L, D>(c, order, limits.inverse_rate, limits.tolerance);
        if L::BALANCE {
            // `min` returns its second argument if an argument is NaN.
            share = (limits.room / unit).min(share);
        }
        let mut change = *c.order(order);
        for k in (1..order).rev() {
            in_halves!(d in D { change[d] = change[d].fma(share, c.order(k)[d]); });
        }
        Proposal { change, share, error: R::splat(0.0) }
    }

    #[inline(always)]
    fn turning(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        turning_of_rates::<R, M, L, D>(&self.model, &self.applied, y)
    }

    #[inline(always)]
    fn velocity(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        acceleration::<R, M, L, D>(&self.model, &self.applied, y)
    }
}
