//! Explicit Runge-Kutta methods: one engine, any tableau.

use super::tableau::{ALL_STAGES, Dop853Tableau, MAX_STAGES, Rk4Tableau, Tableau};
use super::tableau::{check, coefficient, first, time, times_of, weight};
use super::tangent::{further_tangent_rate, tangent_rate};
use super::{Coefficients, Engine, EngineName, Facts, Limits, Method, Numbers, Proposal, Step, Variables};
use super::{acceleration, acceleration_by, cubic_inside, moved, put_turned, turning_of_rates};
use crate::forces::{ForcesInterval, SMALL_STATE};
use crate::kinematics::{plus, put, speed};
use crate::real::{Real, two_sum};
use crate::scene::{
    Applied, FurtherRate, Layout, MOVED, Model, Moved, Parameters, ROWS_LEN, Torques, Varied, in_rows,
};
use std::marker::PhantomData;

/// Classical Runge-Kutta of order 4.
pub const RK4: Method = Method::direct(
    Facts {
        name: "rk4",
        title: "classical Runge-Kutta",
        order: 4,
        stages: 4,
        symplectic: false,
        reversible: false,
        group_preserving: false,
        conserves: &[],
        angle_per_step: 1.0 / 16.0,
        longest_angle: 0.13,
        citation: "W. Kutta, Beitrag zur näherungsweisen Integration totaler Differentialgleichungen, \
                   Z. Math. Phys. 46 (1901) 435-453",
        doi: "",
    },
    Step::plain(EngineName::Rk4),
    2.78,
);
const _: () = check::<Rk4Tableau>(RK4.facts);

/// Dormand-Prince of order 8.
pub const DOP853: Method = Method::direct(
    Facts {
        name: "dop853",
        title: "Dormand-Prince of order 8 with 12 stages",
        order: 8,
        stages: 12,
        symplectic: false,
        reversible: false,
        group_preserving: false,
        conserves: &[],
        angle_per_step: 0.1,
        longest_angle: 1.1,
        citation: "E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., \
                   Springer (1993), section II.5; P. J. Prince, J. R. Dormand, High order embedded Runge-Kutta \
                   formulae, J. Comput. Appl. Math. 7 (1981) 67-75",
        doi: "10.1007/978-3-540-78862-1",
    },
    Step { engine: EngineName::Dop853, numbers: &INSIDE_DOP853 },
    6.39,
);
const _: () = check::<Dop853Tableau>(DOP853.facts);

/// The motion inside a step of [`DOP853`] is a polynomial of this order.
const INSIDE_DOP853: Numbers = Numbers { order: 7, ..Numbers::NONE };

/// The least error of a step that is asked for: below it the estimate consists of rounding.
const LEAST_ERROR: f64 = 16.0 * f64::EPSILON;

/// The engine.
///
/// With twelve stages all slopes contain the unit of time: the constants of the body and of its forces contain it, else
/// each slope is multiplied. By `rk4` only the slopes of the rates contain the unit; those of a free body are their
/// products, whose units contain the moments.
#[derive(Clone, Copy)]
pub struct RungeKutta<T, R, M> {
    model: M,
    /// The model whose slopes contain the unit.
    in_units: M,
    applied: Applied<R>,
    /// Torque and damping, which contain the unit if all constants do.
    torques: Torques<R>,
    slopes: Units<R>,
    sums: Units<R>,
    tableau: PhantomData<T>,
}

/// Units of the slopes of the variables, or of their weighted sums.
#[derive(Clone, Copy)]
struct Units<R> {
    rates: [R; 3],
    /// The slope of a quaternion is twice its rate of change.
    quaternion: R,
    others: R,
}

impl<R: Real> Units<R> {
    /// y plus a sum of slopes in these units, or times a factor that of slopes that contain the unit.
    #[inline(always)]
    fn add<T: Tableau, M: Model<R>, L: Layout, const D: usize>(
        &self,
        sum: &[R; D],
        factor: f64,
        y: &[R; D],
    ) -> [R; D] {
        let mut at = *y;
        if const { T::SLOPES_CONTAIN_UNIT } {
            for d in 0..D {
                at[d] = add_times(y[d], factor, sum[d]);
            }
            return at;
        }
        if const { in_units::<R, M, L>() } {
            for d in 0..3 {
                at[d] = add_times(y[d], factor, sum[d]);
            }
        } else if const { in_products::<T, R, M, L>() } {
            let [a, b, c] = self.rates;
            (at[0], at[1], at[2]) = (a.fma(sum[0], y[0]), b.fma(sum[1], y[1]), c.fma(sum[2], y[2]));
        } else {
            for d in 0..3 {
                at[d] = self.others.fma(sum[d], y[d]);
            }
        }
        for d in 3..D {
            at[d] = if const { in_units::<R, M, L>() } && is_change::<L>(d) {
                add_times(y[d], factor, sum[d])
            } else if is_quaternion::<L>(d) {
                self.quaternion.fma(sum[d], y[d])
            } else {
                self.others.fma(sum[d], y[d])
            };
        }
        at
    }
}

/// Whether the slopes of the rates are their products, whose units contain the moments.
#[inline(always)]
const fn in_products<T: Tableau, R: Real, M: Model<R>, L: Layout>() -> bool {
    !(T::SLOPES_CONTAIN_UNIT || M::HEAVY || L::BALANCE || L::CHANGED)
}

/// Whether the slopes of the rates contain the unit, of a tableau whose other slopes do not.
#[inline(always)]
const fn in_units<R: Real, M: Model<R>, L: Layout>() -> bool {
    M::HEAVY && !(L::BALANCE || L::CHANGED)
}

/// Whether the constants of the equations contain the unit; else each slope is multiplied.
#[inline(always)]
const fn are_constants_in_units<L: Layout>() -> bool {
    !(L::TANGENT || L::FURTHER)
}

/// Whether each slope is added to the state of a stage, not their sum: one operation less a variable, some roundings more,
/// which a function of a body at rest would see as a motion.
#[inline(always)]
const fn adds_each<T: Tableau, L: Layout>() -> bool {
    T::SLOPES_CONTAIN_UNIT && !L::FUNCTION
}

/// Whether the stages are a loop: under a function the code of twelve written out is five times as long, and not a
/// tenth faster.
#[inline(always)]
const fn loops<T: Tableau, L: Layout>() -> bool {
    T::STAGES > 4 && L::FUNCTION
}

/// Whether a variable is part of the quaternion.
#[inline(always)]
const fn is_quaternion<L: Layout>(d: usize) -> bool {
    L::QUATERNION && d >= L::QUATERNION_AT && d < L::QUATERNION_AT + 4
}

/// Whether a variable is the change of a rate by a deviation vector.
#[inline(always)]
const fn is_change<L: Layout>(d: usize) -> bool {
    L::TANGENT && d >= L::TANGENT_AT && d < L::TANGENT_AT + 3
}

/// Writes a statement once for each stage before the last.
macro_rules! for_stages {
    ($j:ident => $body:block) => {
        for_stages!(@each $j $body 0 1 2 3 4 5 6 7 8 9 10);
    };
    (@each $j:ident $body:block $($number:literal)*) => {$({
        const $j: usize = $number;
        $body
    })*};
}

pub(super) use for_stages;

/// A slope times a number of the table. Two additions take less time than a fused product beside others.
#[inline(always)]
pub(super) fn times<R: Real>(number: f64, slope: R) -> R {
    match number {
        1.0 => slope,
        2.0 => slope + slope,
        _ => R::splat(number) * slope,
    }
}

/// sum + number slope.
#[inline(always)]
pub(super) fn add_times<R: Real>(sum: R, number: f64, slope: R) -> R {
    match number {
        1.0 | 2.0 => sum + times(number, slope),
        _ => R::splat(number).fma(slope, sum),
    }
}

/// The slopes and the weighted sum of the slopes of all stages, unrolled, so that each number of the table is a literal,
/// and zeros and ones cost nothing.
macro_rules! stages {
    ($engine:ident, $varied:ident, $y:ident, $k:ident, $sum:ident: $($i:literal)*) => {
        $(
            if const { $i < T::STAGES } {
                let at = if const { $i == 0 } {
                    *$y
                } else {
                    $engine.stage_state::<L, $i, D>($y, &$k)
                };
                $k[$i] = $engine.slope::<L, D>(&$varied, &at);
                if const { weight::<T>($i) != 0.0 } {
                    for d in 0..D {
                        $sum[d] = if const { $i == 0 } {
                            times(const { weight::<T>($i) }, $k[$i][d])
                        } else {
                            add_times($sum[d], const { weight::<T>($i) }, $k[$i][d])
                        };
                    }
                }
            }
        )*
    };
}

/// The rates of change that forces decide: of the rates, and of work and impulse.
#[inline(always)]
fn gains<T: Tableau, R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    (applied, torques): (&Applied<R>, &Torques<R>),
    y: &[R; D],
) -> ([R; 3], [R; 2]) {
    if L::TURNS {
        return gains::<T, R, M, L::Rows, ROWS_LEN>(model, (applied, torques), &in_rows::<L, R, D>(y));
    }
    let zero = R::splat(0.0);
    if const { in_products::<T, R, M, L>() } {
        return ([y[1] * y[2], y[2] * y[0], y[0] * y[1]], [zero; 2]);
    }
    let torque = if L::BALANCE { torques.damped::<L, D>(y) } else { [zero; 3] };
    let balance = if L::BALANCE { applied.balance::<L, D>(&torque, y) } else { [zero; 2] };
    (acceleration_by::<R, M, L, D>(model, applied, y, &torque), balance)
}

/// The equations of motion of the whole state.
#[inline(always)]
fn rate<T: Tableau, R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    (applied, torques): (&Applied<R>, &Torques<R>),
    (varied_model, varied): &Varied<R, M>,
    y: &[R; D],
) -> [R; D] {
    let omega = [y[0], y[1], y[2]];
    let mut dy = *y;
    if L::FURTHER {
        let FurtherRate { omega: change, turn, balance, states } = if L::TANGENT {
            let (torques, moved) = (varied.torques(), applied.moved::<L, D>(y));
            let rates = varied.under_further::<M::Varied, Moved, MOVED>(varied_model, &torques, &moved);
            put(&mut dy, L::TANGENT_AT, further_tangent_rate::<R, L, D>(y, &rates));
            rates.values()
        } else {
            applied.under_further::<M, L, D>(model, torques, y)
        };
        put(&mut dy, 0, change);
        put(&mut dy, L::BALANCE_AT, balance);
        put_turned::<R, L, D>(y, &plus(&omega, &turn), &mut dy);
        if L::OWN > 0 {
            applied.forces.further.change(y, L::OWN_AT, &mut dy);
        }
        if L::STATES {
            put(&mut dy, L::STATES_AT, states);
        }
    } else {
        let (change, balance) = gains::<T, R, M, L, D>(model, (applied, torques), y);
        put(&mut dy, 0, change);
        put_turned::<R, L, D>(y, &omega, &mut dy);
        if L::BALANCE {
            put(&mut dy, L::BALANCE_AT, balance);
        }
        if L::TANGENT {
            put(&mut dy, L::TANGENT_AT, tangent_rate::<R, M, L, D>(model, applied, y, &change));
        }
    }
    if L::BALANCE {
        dy[L::TIME_AT] = R::splat(1.0);
    }
    dy
}

impl<T: Tableau, R: Real, M: Model<R>> RungeKutta<T, R, M> {
    /// The constants over the unit of a step: the model, the torques, and the units of slopes and sums.
    #[inline(always)]
    fn over<L: Layout>(step: R, model: &M, applied: &Applied<R>) -> (M, Torques<R>, [Units<R>; 2]) {
        let (unit, half) = (step * R::splat(T::UNIT), R::splat(0.5));
        let contain_unit = const { T::SLOPES_CONTAIN_UNIT && are_constants_in_units::<L>() };
        let torques = applied.torques_in::<L>(if contain_unit { unit } else { R::splat(1.0) });
        let in_units = model.in_units(unit);
        // Of products as slopes only.
        let rates = in_units.ratios();
        let slopes = Units { rates, quaternion: unit * half, others: unit };
        let share = R::splat(T::DIVISOR);
        let [a, b, c] = rates;
        let sums = Units {
            rates: [a / share, b / share, c / share],
            quaternion: slopes.quaternion / share,
            others: unit / share,
        };
        (in_units, torques, [slopes, sums])
    }

    /// The state of a stage.
    #[inline(always)]
    fn stage_state<L: Layout, const I: usize, const D: usize>(
        &self,
        y: &[R; D],
        k: &[[R; D]; MAX_STAGES],
    ) -> [R; D] {
        let mut at = *y;
        for_stages!(J => {
            if const { coefficient::<T>(I, J) != 0.0 } {
                for d in 0..D {
                    at[d] = if const { adds_each::<T, L>() } {
                        R::splat(const { coefficient::<T>(I, J) }).fma(k[J][d], at[d])
                    } else if const { J == first::<T>(I) } {
                        times(const { coefficient::<T>(I, J) }, k[J][d])
                    } else {
                        add_times(at[d], const { coefficient::<T>(I, J) }, k[J][d])
                    };
                }
            }
        });
        if const { !adds_each::<T, L>() } {
            at = self.slopes.add::<T, M, L, D>(&at, 1.0, y);
        }
        if const { !T::SLOPES_CONTAIN_UNIT } {
            return at;
        }
        if L::BALANCE {
            at[L::TIME_AT] = self.slopes.others.fma(R::splat(const { time::<T>(I) }), y[L::TIME_AT]);
        }
        at
    }

    /// The slopes of a state.
    #[inline(always)]
    fn slope<L: Layout, const D: usize>(&self, varied: &Varied<R, M>, y: &[R; D]) -> [R; D] {
        if const { !T::SLOPES_CONTAIN_UNIT } {
            let model = if const { in_units::<R, M, L>() } { &self.in_units } else { &self.model };
            return rate::<T, R, M, L, D>(model, (&self.applied, &self.torques), varied, y);
        }
        let unit = self.slopes.others;
        if const { !are_constants_in_units::<L>() } {
            let mut slope = rate::<T, R, M, L, D>(&self.model, (&self.applied, &self.torques), varied, y);
            for d in 0..D {
                slope[d] = slope[d] * if is_quaternion::<L>(d) { self.slopes.quaternion } else { unit };
            }
            return slope;
        }
        let mut slope = *y;
        let (change, balance) = if const { L::TURNS } {
            self.gains_in_units::<L::Rows, ROWS_LEN>(&in_rows::<L, R, D>(y))
        } else {
            self.gains_in_units::<L, D>(y)
        };
        put(&mut slope, 0, change);
        // Not the rates, which would be rounded alike in every step of a steady spin.
        put_turned::<R, L, D>(y, &[y[0], y[1], y[2]], &mut slope);
        for d in 3..L::BALANCE_AT {
            slope[d] = slope[d] * if is_quaternion::<L>(d) { self.slopes.quaternion } else { unit };
        }
        if L::BALANCE {
            put(&mut slope, L::BALANCE_AT, balance);
            slope[L::TIME_AT] = unit;
        }
        slope
    }

    /// What forces decide, over a unit of time; see `gains`.
    #[inline(always)]
    fn gains_in_units<L: Layout, const D: usize>(&self, y: &[R; D]) -> ([R; 3], [R; 2]) {
        let mut change = self.in_units.euler(&[y[1] * y[2], y[2] * y[0], y[0] * y[1]], y);
        if !L::BALANCE {
            return (change, [R::splat(0.0); 2]);
        }
        let torque = self.torques.damped::<L, D>(y);
        self.applied.add_over_moments(&torque, &mut change);
        (change, self.applied.balance::<L, D>(&torque, y))
    }

    /// The slopes of the stages, in a loop, and their weighted sum.
    #[inline(always)]
    fn looped<L: Layout, const D: usize>(&self, y: &[R; D], slopes: &mut Coefficients<R, D>) -> [R; D] {
        let (zero, varied) = ([R::splat(0.0); D], self.applied.varied(&self.model));
        let mut sum = zero;
        slopes.clear();
        for i in 0..MAX_STAGES {
            let row = if i == 0 { &[][..] } else { T::A[i - 1] };
            let mut at = zero;
            // Loops over numbers here and below: iterators side by side are calls.
            let known = slopes.all();
            for j in 0..row.len().min(known.len()) {
                if row[j] != 0.0 {
                    for d in 0..D {
                        at[d] = R::splat(row[j]).fma(known[j][d], at[d]);
                    }
                }
            }
            at = self.slopes.add::<T, M, L, D>(&at, 1.0, y);
            if L::BALANCE {
                at[L::TIME_AT] =
                    self.slopes.others.fma(R::splat(const { times_of::<T>() }[i]), y[L::TIME_AT]);
            }
            let slope = self.slope::<L, D>(&varied, &at);
            for d in 0..D {
                sum[d] = R::splat(T::WEIGHTS[i]).fma(slope[d], sum[d]);
            }
            slopes.push(slope);
        }
        sum
    }

    /// The change of a state by a weighted sum of slopes.
    #[inline(always)]
    fn change<L: Layout, const D: usize>(&self, sum: &[R; D]) -> [R; D] {
        self.sums.add::<T, M, L, D>(sum, const { 1.0 / T::DIVISOR }, &[R::splat(0.0); D])
    }

    /// Adds the weighted sum of the slopes to the state at the begin of the step.
    #[inline(always)]
    fn finish<L: Layout, const D: usize>(&self, sum: &[R; D], y: &mut [R; D], compensation: &mut [R; D]) {
        if const { !L::FURTHER } {
            *y = self.sums.add::<T, M, L, D>(sum, const { 1.0 / T::DIVISOR }, y);
            return;
        }
        // A sink changes a steady spin by less than a rounding of each step.
        let change = self.change::<L, D>(sum);
        for d in 0..D {
            (y[d], compensation[d]) = two_sum(y[d], change[d] + compensation[d]);
        }
    }

    /// Two estimates of the error of a step, from the slopes of its stages.
    #[inline(always)]
    fn errors<const D: usize>(slopes: &Coefficients<R, D>) -> [[R; D]; 2] {
        let mut errors = [[R::splat(0.0); D]; 2];
        for e in 0..2 {
            let (numbers, known) = (&T::INSIDE.errors[e], slopes.all());
            for j in 0..numbers.len().min(known.len()) {
                for d in 0..D {
                    errors[e][d] = R::splat(numbers[j]).fma(known[j][d], errors[e][d]);
                }
            }
        }
        errors
    }

    /// The error of a step over the tolerance, from the states at its ends and the slopes of its stages: of the rates relative
    /// to the fastest known or met, of the attitude and of the place on the orbit in rad, of the states of a function relative
    /// to their sizes at the ends. The balance follows from the motion, so the balance is ignored. The estimates of order 5 and 3 become one that falls as the eighth power of the step
    /// (Hairer, Nørsett, Wanner, section II.10).
    #[inline(always)]
    fn error<L: Layout, const D: usize>(
        [before, after]: [&[R; D]; 2],
        slopes: &Coefficients<R, D>,
        limits: &Limits<R>,
    ) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let estimates = Self::errors(slopes);
        // `max` returns its second argument if the first is no number.
        let rate =
            speed(after).max(speed(before).max(one / limits.inverse_rate)).max(R::splat(f64::MIN_POSITIVE));
        let mut least = R::splat(SMALL_STATE[1]);
        for d in L::STATES_AT..D {
            least = (R::splat(SMALL_STATE[0]) * before[d].abs().max(after[d].abs())).max(least);
        }
        let mut largest = [zero; 2];
        for i in 0..2 {
            let mut sum = zero;
            for d in 0..D {
                if d >= L::BALANCE_AT && d < L::OWN_AT {
                    continue;
                }
                let size = if d < 3 {
                    rate
                } else if d >= L::STATES_AT {
                    before[d].abs().max(after[d].abs()).max(least)
                } else {
                    // The place on the orbit, by its angle; a quaternion changes by half of the angle.
                    R::splat(if d >= L::OWN_AT { 1.0 } else { 0.5 })
                };
                let off = estimates[i][d].abs() / size;
                largest[i] = off.max(largest[i]);
                sum = sum + off;
            }
            // A NaN remains.
            largest[i] = R::select(R::splat(-1.0).lt(sum), largest[i], sum);
        }
        let [fifth, third] = largest;
        // Squares of the estimates would underflow where a smooth torque sets in.
        let ratio = third / fifth;
        let error = fifth
            / (one + R::splat(0.01) * ratio * ratio).sqrt()
            / limits.tolerance.max(R::splat(LEAST_ERROR));
        R::select(zero.lt(fifth), error, fifth)
    }

    /// The motion inside a step that has led from one state to another, in powers of the fraction of the step, from the slopes
    /// of its stages: the polynomial of order 7 of Hairer, Nørsett and Wanner, section II.6,
    /// `y + s (F_0 + (1 - s) (F_1 + s (F_2 + …)))`.
    #[inline(always)]
    fn inside<L: Layout, const D: usize>(&self, [y, after]: [&[R; D]; 2], slopes: &mut Coefficients<R, D>) {
        let varied = self.applied.varied(&self.model);
        slopes.push(self.slope::<L, D>(&varied, after));
        for row in T::INSIDE.stages {
            let mut at = *y;
            let known = slopes.all();
            for j in 0..row.len().min(known.len()) {
                for d in 0..D {
                    at[d] = R::splat(row[j]).fma(known[j][d], at[d]);
                }
            }
            slopes.push(self.slope::<L, D>(&varied, &at));
        }
        let powers = powers::<T, R, D>(y, after, slopes.all());
        slopes.clear();
        for row in powers {
            slopes.push(row);
        }
    }
}

/// The motion inside a step from its slopes, which contain the step; see [`RungeKutta::inside`].
#[inline(always)]
pub(super) fn powers<T: Tableau, R: Real, const D: usize>(
    y: &[R; D],
    after: &[R; D],
    slopes: &[[R; D]],
) -> [[R; D]; 8] {
    let slopes = &slopes[..ALL_STAGES];
    let mut parts = [[R::splat(0.0); D]; 7];
    for d in 0..D {
        let change = after[d] - y[d];
        parts[0][d] = change;
        parts[1][d] = slopes[0][d] - change;
        parts[2][d] = (change + change) - (slopes[0][d] + slopes[MAX_STAGES][d]);
    }
    for k in 0..4 {
        let weights = &T::INSIDE.polynomial[k];
        for i in 0..ALL_STAGES {
            for d in 0..D {
                parts[3 + k][d] = R::splat(weights[i]).fma(slopes[i][d], parts[3 + k][d]);
            }
        }
    }
    // The powers, from the last part on: times s or times 1 - s, plus the part before.
    let mut powers = [[R::splat(0.0); D]; 8];
    powers[0] = parts[6];
    for i in (0..7).rev() {
        for k in (1..8 - i).rev() {
            for d in 0..D {
                let before = powers[k - 1][d];
                powers[k][d] = if i % 2 == 0 { before } else { powers[k][d] - before };
            }
        }
        let part = if i == 0 { y } else { &parts[i - 1] };
        for d in 0..D {
            powers[0][d] = if i % 2 == 0 { part[d] } else { powers[0][d] + part[d] };
        }
    }
    powers
}

impl<T: Tableau, R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for RungeKutta<T, R, M> {
    const VARIABLES: Variables = Variables::Rates;
    /// The attitude is a quaternion, but for a deviation vector.
    const MOVES: bool = if L::VECTORS > 1 { L::TANGENT } else { !(L::VECTORS > 0 && L::QUATERNION) };
    const COMPENSATES: bool = L::FURTHER;
    const HAS_TANGENT: bool = true;
    const IS_SHORT: bool = T::STAGES <= 4 && D <= 6 && !L::BALANCE;
    const IS_LONG: bool = T::INSIDE.is_known;
    /// Only there: the further stages of other bodies would take more time than shorter steps.
    const IS_SERIES: bool = L::FUNCTION && T::INSIDE.is_known;
    const IS_TRIED: bool = true;

    #[inline(always)]
    fn new(p: &Parameters<R>, forces: &ForcesInterval<'static, R>, _numbers: &'static Numbers) -> Self {
        let (model, applied) = (M::new(p), Applied::new(p, forces));
        let (in_units, torques, [slopes, sums]) = Self::over::<L>(p.step, &model, &applied);
        RungeKutta { model, in_units, applied, torques, slopes, sums, tableau: PhantomData }
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
        _dense: &mut Coefficients<R, D>,
    ) {
        if const { loops::<T, L>() } {
            let sum = self.looped::<L, D>(y, &mut Coefficients::new());
            self.finish::<L, D>(&sum, y, compensation);
            return;
        }
        let (mut k, varied) = ([*y; MAX_STAGES], self.applied.varied(&self.model));
        let mut sum = *y;
        stages!(self, varied, y, k, sum: 0 1 2 3 4 5 6 7 8 9 10 11);
        self.finish::<L, D>(&sum, y, compensation);
    }

    #[inline(always)]
    fn motion_inside(
        &self,
        p: &Parameters<R>,
        [before, after]: [&[R; D]; 2],
        dense: &mut Coefficients<R, D>,
    ) {
        if const { !T::INSIDE.is_known } {
            let slopes = [
                Engine::<R, M, L, D>::rates_of_change(self, p, before),
                Engine::<R, M, L, D>::rates_of_change(self, p, after),
            ];
            cubic_inside(p.step, [before, after], &slopes, dense);
            return;
        }
        self.looped::<L, D>(before, dense);
        self.inside::<L, D>([before, after], dense);
    }

    #[inline(always)]
    fn propose(
        &mut self,
        unit: R,
        limits: &Limits<R>,
        y: &[R; D],
        inside: &mut Coefficients<R, D>,
    ) -> Proposal<R, D> {
        let Self { model, applied, .. } = &*self;
        let (in_units, torques, [slopes, sums]) = Self::over::<L>(unit, model, applied);
        (self.in_units, self.torques, self.slopes, self.sums) = (in_units, torques, slopes, sums);
        let sum = self.looped::<L, D>(y, inside);
        let change = self.change::<L, D>(&sum);
        let mut after = *y;
        for d in 0..D {
            after[d] = y[d] + change[d];
        }
        let error = Self::error::<L, D>([y, &after], inside, limits);
        Proposal { change, share: R::splat(1.0), error }
    }

    #[inline(always)]
    fn expand(&mut self, wanted: R, ends: [&[R; D]; 2], inside: &mut Coefficients<R, D>) {
        let functions = self.applied.forces.functions;
        if let Some(functions) = &mut self.applied.forces.functions {
            *functions = functions.only(wanted);
        }
        self.inside::<L, D>(ends, inside);
        self.applied.forces.functions = functions;
    }

    #[inline(always)]
    fn rates_of_change(&self, p: &Parameters<R>, y: &[R; D]) -> [R; D] {
        let turning = Engine::<R, M, L, D>::turning(self, p, y);
        let mut change = moved::<R, L, D>(y, Engine::<R, M, L, D>::velocity(self, p, y), &turning);
        if L::OWN > 0 {
            self.applied.forces.further.change(y, L::OWN_AT, &mut change);
        }
        if L::STATES {
            put(&mut change, L::STATES_AT, self.applied.state_rates::<M, L, D>(&self.model, y));
        }
        change
    }

    #[inline(always)]
    fn turning(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        turning_of_rates::<R, M, L, D>(&self.model, &self.applied, y)
    }

    /// Under a sink by a difference over a thousandth of the step.
    #[inline(always)]
    fn turning_rate(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        if !L::FURTHER {
            return Engine::<R, M, L, D>::velocity(self, p, y);
        }
        let change = Engine::<R, M, L, D>::rates_of_change(self, p, y);
        let (mut later, time) = (*y, p.step * R::splat(1e-3));
        for d in 0..D {
            later[d] = time.fma(change[d], y[d]);
        }
        let mut now = Engine::<R, M, L, D>::turning(self, p, y);
        let then = Engine::<R, M, L, D>::turning(self, p, &later);
        for k in 0..3 {
            now[k] = (then[k] - now[k]) / time;
        }
        now
    }

    #[inline(always)]
    fn velocity(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        acceleration::<R, M, L, D>(&self.model, &self.applied, y)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Dop853Tableau;
    use super::*;
    use crate::scene::{FunctionTurns, Top};

    const D: usize = FunctionTurns::LEN;
    type Dop853 = RungeKutta<Dop853Tableau, f64, Top<f64>>;

    fn engine(step: f64) -> (Parameters<f64>, Dop853) {
        let p = Parameters { moments: [1.0, 1.6, 2.1], weight: [0.3, 0.0, 0.8], step };
        let forces = ForcesInterval::none();
        (p, <Dop853 as Engine<_, _, FunctionTurns, D>>::new(&p, &forces, &Numbers::NONE))
    }

    fn start() -> [f64; D] {
        let mut y = [0.0; D];
        y[..3].copy_from_slice(&[0.4, 1.0, -0.7]);
        y[FunctionTurns::QUATERNION_AT] = 1.0;
        y
    }

    /// The state after a time, by many steps.
    fn truth(time: f64) -> [f64; D] {
        let (p, engine) = engine(time / 64.0);
        let mut y = start();
        for _ in 0..64 {
            Engine::<_, _, FunctionTurns, D>::step(&engine, &p, &mut y);
        }
        y
    }

    /// The polynomial of a step at a fraction of it.
    fn inside(dense: &Coefficients<f64, D>, fraction: f64) -> [f64; D] {
        let mut y = [0.0; D];
        for row in dense.all().iter().rev() {
            for d in 0..D {
                y[d] = y[d] * fraction + row[d];
            }
        }
        y
    }

    fn apart(a: &[f64; D], b: &[f64; D]) -> f64 {
        a.iter().zip(b).fold(0.0, |most, (x, y)| most.max((x - y).abs()))
    }

    #[test]
    fn the_motion_inside_a_step_is_of_order_seven_and_the_estimate_is_the_error() {
        let mut errors = Vec::new();
        for step in [0.3, 0.15] {
            let (p, engine) = engine(step);
            let (mut y, mut dense) = (start(), Coefficients::new());
            Engine::<_, _, FunctionTurns, D>::step(&engine, &p, &mut y);
            Engine::<_, _, FunctionTurns, D>::motion_inside(&engine, &p, [&start(), &y], &mut dense);
            // A rounding of each of the eight terms.
            assert!(apart(&inside(&dense, 1.0), &y) < 1e-14 && apart(dense.order(0), &start()) == 0.0);
            let within = [0.3, 0.5, 0.8].map(|at| apart(&inside(&dense, at), &truth(at * step)));
            engine.looped::<FunctionTurns, D>(&start(), &mut dense);
            let [fifth, third] = Dop853::errors(&dense).map(|estimate| apart(&estimate, &[0.0; D]));
            errors.push([within[0].max(within[1]).max(within[2]), apart(&y, &truth(step)), fifth, third]);
        }
        let falls = |k: usize| (errors[0][k] / errors[1][k]).log2();
        // Local errors: of the polynomial by the eighth power, of the step by the ninth, of the estimates of order 5 and 3
        // by the sixth and the fourth; each to a half, as the next order is not small in such steps.
        for (k, order) in [8.0, 9.0, 6.0, 4.0].into_iter().enumerate() {
            assert!((falls(k) - order).abs() < 0.5, "{k}: {} of {errors:?}", falls(k));
        }
    }
}
