//! Explicit Runge-Kutta methods: one engine, any tableau.

use super::tableau::{ALL_STAGES, MAX_STAGES, Slopes, Tableau, coefficient, first, weight};
use super::tangent::{further_tangent_rate, tangent_rate};
use super::{Coefficients, Engine, EngineName, Facts, Method, Numbers, Step, Variables};
use super::{acceleration, acceleration_by};
use crate::forces::ForcesInterval;
use crate::kinematics;
use crate::real::Real;
use crate::scene::{Applied, FurtherRate, Layout, Model, Parameters};
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

/// The motion inside a step of [`DOP853`] is a polynomial of this order.
const INSIDE_DOP853: Numbers = Numbers { order: 7, ..Numbers::NONE };

/// The engine.
///
/// By `rk4` the constants of a body and the unit of time are multiplied once: the slopes of the rates of a free body are
/// their products, whose units contain the moments, and the slopes of the rates of a top contain the unit.
#[derive(Clone, Copy)]
pub struct RungeKutta<T, R, M> {
    model: M,
    /// The model whose slopes contain the unit.
    in_units: M,
    applied: Applied<R>,
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
        if const { in_units::<T, R, M, L>() } {
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
            at[d] = if const { in_units::<T, R, M, L>() } && is_change::<L>(d) {
                add_times(y[d], factor, sum[d])
            } else if L::QUATERNION && d >= L::QUATERNION_AT && d < L::QUATERNION_AT + 4 {
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
    T::MULTIPLIES_ONCE && !(M::HEAVY || L::BALANCE || L::CHANGED)
}

/// Whether the slopes of the rates contain the unit.
#[inline(always)]
const fn in_units<T: Tableau, R: Real, M: Model<R>, L: Layout>() -> bool {
    T::MULTIPLIES_ONCE && M::HEAVY && !(L::BALANCE || L::CHANGED)
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
    ($engine:ident, $y:ident, $k:ident, $sum:ident: $($i:literal)*) => {
        let model = if const { in_units::<T, R, M, L>() } { &$engine.in_units } else { &$engine.model };
        $(
            if const { $i < T::STAGES } {
                let at = if const { $i == 0 } {
                    *$y
                } else {
                    stage_state::<T, M, L, $i, R, D>(&$engine.slopes, $y, &$k)
                };
                $k[$i] = rate::<T, R, M, L, D>(model, &$engine.applied, &at);
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

/// y + u sum_j a_ij k_j.
#[inline(always)]
fn stage_state<T: Tableau, M: Model<R>, L: Layout, const I: usize, R: Real, const D: usize>(
    slopes: &Units<R>,
    y: &[R; D],
    k: &[[R; D]; MAX_STAGES],
) -> [R; D] {
    let mut at = *y;
    for_stages!(J => {
        if const { coefficient::<T>(I, J) != 0.0 } {
            for d in 0..D {
                at[d] = if const { J == first::<T>(I) } {
                    times(const { coefficient::<T>(I, J) }, k[J][d])
                } else {
                    add_times(at[d], const { coefficient::<T>(I, J) }, k[J][d])
                };
            }
        }
    });
    slopes.add::<T, M, L, D>(&at, 1.0, y)
}

/// The equations of motion of the whole state.
#[inline(always)]
fn rate<T: Tableau, R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
) -> [R; D] {
    if L::FURTHER {
        return further_rate::<R, M, L, D>(model, applied, y);
    }
    let omega = [y[0], y[1], y[2]];
    let mut dy = *y;
    let torque = if L::BALANCE { applied.torque::<L, D>(y) } else { [R::splat(0.0); 3] };
    let change = if const { in_products::<T, R, M, L>() } {
        [y[1] * y[2], y[2] * y[0], y[0] * y[1]]
    } else {
        acceleration_by::<R, M, L, D>(model, applied, y, &torque)
    };
    kinematics::put(&mut dy, 0, change);
    for v in 0..L::VECTORS {
        let at = 3 + 3 * v;
        kinematics::put(&mut dy, at, kinematics::direction_rate(&kinematics::direction(y, v), &omega));
    }
    if L::QUATERNION {
        let at = L::QUATERNION_AT;
        let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
        kinematics::put(&mut dy, at, kinematics::doubled_attitude_rate(&q, &omega));
    }
    if L::BALANCE {
        let at = L::BALANCE_AT;
        kinematics::put(&mut dy, at, applied.balance::<L, D>(&torque, y));
        dy[at + 2] = R::splat(1.0);
    }
    if L::TANGENT {
        kinematics::put(&mut dy, L::TANGENT_AT, tangent_rate::<R, M, L, D>(model, applied, y, &change));
    }
    dy
}

/// The equations of motion of the whole state under further forces.
#[inline(always)]
fn further_rate<R: Real, M: Model<R>, L: Layout, const D: usize>(
    model: &M,
    applied: &Applied<R>,
    y: &[R; D],
) -> [R; D] {
    let mut dy = *y;
    let rates = applied.under_further::<M, L, D>(model, y);
    let FurtherRate { omega, turn, balance, .. } = rates;
    kinematics::put(&mut dy, 0, omega);
    let turning = [y[0] + turn[0], y[1] + turn[1], y[2] + turn[2]];
    for v in 0..L::VECTORS {
        let n = kinematics::direction(y, v);
        kinematics::put(&mut dy, 3 + 3 * v, kinematics::direction_rate(&n, &turning));
    }
    kinematics::put(&mut dy, L::BALANCE_AT, balance);
    dy[L::TIME_AT] = R::splat(1.0);
    if L::TANGENT {
        let rate = further_tangent_rate::<R, M, L, D>(model, applied, y, &rates);
        kinematics::put(&mut dy, L::TANGENT_AT, rate);
    }
    if L::OWN > 0 {
        applied.forces.further.change(y, L::OWN_AT, &mut dy);
    }
    dy
}

impl<T: Tableau, R: Real, M: Model<R>> RungeKutta<T, R, M> {
    /// The slopes of the stages of a step, and their weighted sum.
    #[inline(always)]
    fn weighted<L: Layout, const D: usize>(&self, y: &[R; D], slopes: &mut Slopes<R, D>) -> [R; D] {
        let mut k = [*y; MAX_STAGES];
        let mut sum = *y;
        stages!(self, y, k, sum: 0 1 2 3 4 5 6 7 8 9 10 11);
        #[expect(clippy::manual_memcpy, reason = "a copy of slices is a call")]
        for i in 0..MAX_STAGES {
            slopes[i] = k[i];
        }
        sum
    }

    /// The change of a state by a step, and the slopes of its stages.
    #[inline(always)]
    pub fn change<L: Layout, const D: usize>(&self, y: &[R; D], slopes: &mut Slopes<R, D>) -> [R; D] {
        let sum = self.weighted::<L, D>(y, slopes);
        self.sums.add::<T, M, L, D>(&sum, const { 1.0 / T::DIVISOR }, &[R::splat(0.0); D])
    }

    /// Two estimates of the error of a step, from the slopes of its stages.
    #[inline(always)]
    pub fn errors<const D: usize>(&self, slopes: &Slopes<R, D>) -> [[R; D]; 2] {
        let mut errors = [[R::splat(0.0); D]; 2];
        for e in 0..2 {
            for i in 0..MAX_STAGES {
                for d in 0..D {
                    errors[e][d] = R::splat(T::INSIDE.errors[e][i]).fma(slopes[i][d], errors[e][d]);
                }
            }
            for d in 0..D {
                errors[e][d] = errors[e][d] * self.slopes.others;
            }
        }
        errors
    }

    /// The motion inside a step that has led from one state to another, in powers of the fraction of the step: the
    /// polynomial of order 7 of Hairer, Nørsett and Wanner, section II.6, `y + s (F_0 + (1 - s) (F_1 + s (F_2 + …)))`.
    #[inline(always)]
    pub fn expand_step<L: Layout, const D: usize>(
        &self,
        y: &[R; D],
        after: &[R; D],
        slopes: &mut Slopes<R, D>,
        dense: &mut Coefficients<R, D>,
    ) {
        let unit = self.slopes.others;
        slopes[MAX_STAGES] = rate::<T, R, M, L, D>(&self.model, &self.applied, after);
        for (stage, row) in T::INSIDE.stages.iter().enumerate() {
            let mut sum = [R::splat(0.0); D];
            for (i, &number) in row.iter().enumerate() {
                for d in 0..D {
                    sum[d] = R::splat(number).fma(slopes[i][d], sum[d]);
                }
            }
            let mut at = *y;
            for d in 0..D {
                at[d] = unit.fma(sum[d], y[d]);
            }
            slopes[MAX_STAGES + 1 + stage] = rate::<T, R, M, L, D>(&self.model, &self.applied, &at);
        }
        dense.clear();
        for row in powers::<T, R, D>(y, after, slopes, unit) {
            dense.push(row);
        }
    }
}

/// The motion inside a step from its slopes; see [`RungeKutta::expand_step`].
#[inline(always)]
pub(super) fn powers<T: Tableau, R: Real, const D: usize>(
    y: &[R; D],
    after: &[R; D],
    slopes: &Slopes<R, D>,
    unit: R,
) -> [[R; D]; 8] {
    let mut parts = [[R::splat(0.0); D]; 7];
    for d in 0..D {
        let change = after[d] - y[d];
        parts[0][d] = change;
        parts[1][d] = unit.fma(slopes[0][d], -change);
        parts[2][d] = (change + change) - unit * (slopes[0][d] + slopes[MAX_STAGES][d]);
    }
    for k in 0..4 {
        let weights = &T::INSIDE.polynomial[k];
        for i in 0..ALL_STAGES {
            for d in 0..D {
                parts[3 + k][d] = R::splat(weights[i]).fma(slopes[i][d], parts[3 + k][d]);
            }
        }
        for d in 0..D {
            parts[3 + k][d] = parts[3 + k][d] * unit;
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
    const MOVES: bool = !(T::ROWS_ONLY && M::HEAVY && L::QUATERNION);
    const HAS_TANGENT: bool = true;
    const IS_SHORT: bool = T::STAGES <= 4 && D <= 6 && !L::BALANCE;
    /// With twelve stages and the search inside a step, the compiler copies the set-up of a pack by calls. Under the
    /// torque of a function, which is called, nothing is lost by that.
    const SEES_LIMITS: bool = T::STAGES < 12 || L::FUNCTION;
    /// Only there: the further stages of other bodies would take more time than shorter steps.
    const IS_SERIES: bool = L::FUNCTION && T::INSIDE.is_known;

    #[inline(always)]
    fn new(p: &Parameters<R>, forces: &ForcesInterval<'static, R>, _numbers: &'static Numbers) -> Self {
        let (model, applied) = (M::new(p), Applied::new(p, forces));
        let (unit, half) = (p.step * R::splat(T::UNIT), R::splat(0.5));
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
        RungeKutta { model, in_units, applied, slopes, sums, tableau: PhantomData }
    }

    #[inline(always)]
    fn step(
        &self,
        _p: &Parameters<R>,
        y: &mut [R; D],
        _compensation: &mut [R; D],
        _dense: &mut Coefficients<R, D>,
    ) {
        let mut k = [*y; MAX_STAGES];
        let mut sum = *y;
        stages!(self, y, k, sum: 0 1 2 3 4 5 6 7 8 9 10 11);
        *y = self.sums.add::<T, M, L, D>(&sum, const { 1.0 / T::DIVISOR }, y);
    }

    #[inline(always)]
    fn step_inside(
        &self,
        p: &Parameters<R>,
        y: &mut [R; D],
        compensation: &mut [R; D],
        dense: &mut Coefficients<R, D>,
    ) {
        if const { !T::INSIDE.is_known } {
            Engine::<R, M, L, D>::step(self, p, y, compensation, dense);
            return;
        }
        let before = *y;
        let mut slopes = [before; ALL_STAGES];
        let sum = self.weighted::<L, D>(&before, &mut slopes);
        *y = self.sums.add::<T, M, L, D>(&sum, const { 1.0 / T::DIVISOR }, &before);
        self.expand_step::<L, D>(&before, y, &mut slopes, dense);
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
    use crate::scene::{FunctionFrame, Top};

    const D: usize = FunctionFrame::LEN;
    type Dop853 = RungeKutta<Dop853Tableau, f64, Top<f64>>;

    fn engine(step: f64) -> (Parameters<f64>, Dop853) {
        let p = Parameters { moments: [1.0, 1.6, 2.1], weight: [0.3, 0.0, 0.8], step };
        let forces = ForcesInterval::none();
        (p, <Dop853 as Engine<_, _, FunctionFrame, D>>::new(&p, &forces, &Numbers::NONE))
    }

    fn start() -> [f64; D] {
        let mut y = [0.0; D];
        y[..3].copy_from_slice(&[0.4, 1.0, -0.7]);
        (y[5], y[6], y[10]) = (1.0, 1.0, 1.0);
        y
    }

    /// The state after a time, by many steps.
    fn truth(time: f64) -> [f64; D] {
        let (p, engine) = engine(time / 64.0);
        let (mut y, mut unused) = (start(), [0.0; D]);
        for _ in 0..64 {
            let dense = &mut Coefficients::new();
            Engine::<_, _, FunctionFrame, D>::step(&engine, &p, &mut y, &mut unused, dense);
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
            let (mut y, mut unused, mut dense) = (start(), [0.0; D], Coefficients::new());
            Engine::<_, _, FunctionFrame, D>::step_inside(&engine, &p, &mut y, &mut unused, &mut dense);
            // A rounding of each of the eight terms.
            assert!(apart(&inside(&dense, 1.0), &y) < 1e-14 && apart(dense.order(0), &start()) == 0.0);
            let within = [0.3, 0.5, 0.8].map(|at| apart(&inside(&dense, at), &truth(at * step)));
            let mut slopes = [start(); ALL_STAGES];
            engine.change::<FunctionFrame, D>(&start(), &mut slopes);
            let [fifth, third] = engine.errors(&slopes).map(|estimate| apart(&estimate, &[0.0; D]));
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
