//! Explicit Runge-Kutta methods: one engine, any tableau.

use super::tangent::{further_tangent_rate, tangent_rate};
use super::{Coefficients, Engine, EngineName, Facts, Method, Numbers, Step, Variables};
use super::{acceleration, acceleration_by};
use crate::forces::{Force, ForcesInterval};
use crate::kinematics;
use crate::real::Real;
use crate::scene::{Applied, FurtherRate, Layout, Model, Parameters};
use std::marker::PhantomData;

/// The table of an explicit Runge-Kutta method with the unit of time `u = h UNIT`, `k_i = f(y + u sum_j a_ij k_j)`,
/// `y + (u / divisor) sum_i weights_i k_i`.
pub trait Tableau: Copy {
    /// Order of the method.
    const ORDER: usize;
    /// Whether the attitude of tops is integrated as rows of its matrix only.
    const ROWS_ONLY: bool;
    /// The unit of time over the step: a power of two with which few coefficients differ from one and two, which cost
    /// no multiplication.
    const UNIT: f64;
    /// Whether the constants of a body are multiplied by the unit once. Each is one more number that is rounded alike in
    /// every step, which a method of high order would show.
    const MULTIPLIES_ONCE: bool;
    /// Rows 1, 2, … of the matrix a; row i has i entries.
    const A: &'static [&'static [f64]];
    /// Weights over the common divisor: whole numbers where they can be.
    const WEIGHTS: &'static [f64];
    /// Common divisor of the weights.
    const DIVISOR: f64;
    /// Number of stages.
    const STAGES: usize = Self::WEIGHTS.len();
    /// The motion inside a step and the error of a step, of a method with [`MAX_STAGES`] stages.
    const INSIDE: &'static Inside = &Inside::UNKNOWN;
}

/// The motion inside a step, by its value and slope at both ends and by further stages, and two estimates of the error of
/// the step.
pub struct Inside {
    is_known: bool,
    /// Rows of the matrix a of the further stages; the stage before the first is the slope at the end.
    stages: [&'static [f64]; FURTHER_STAGES],
    /// The last four coefficients of the polynomial, from all slopes.
    polynomial: [[f64; ALL_STAGES]; 4],
    /// The estimates of order 5 and of order 3, from the slopes of the stages.
    errors: [[f64; MAX_STAGES]; 2],
}

impl Inside {
    /// The motion inside a step is not known.
    const UNKNOWN: Inside = Inside {
        is_known: false,
        stages: [&[]; FURTHER_STAGES],
        polynomial: [[0.0; ALL_STAGES]; 4],
        errors: [[0.0; MAX_STAGES]; 2],
    };
}

/// Stages for the motion inside a step.
const FURTHER_STAGES: usize = 3;

/// Stages of a step, its end, and the further stages.
const ALL_STAGES: usize = MAX_STAGES + 1 + FURTHER_STAGES;

/// The slopes of a step: of its stages, at its end, and of the further stages.
pub type Slopes<R, const D: usize> = [[R; D]; ALL_STAGES];

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

/// The tableau of [`RK4`].
#[derive(Clone, Copy)]
pub struct Rk4Tableau;

/// The tableau of [`DOP853`].
#[derive(Clone, Copy)]
pub struct Dop853Tableau;

impl Tableau for Rk4Tableau {
    const ORDER: usize = 4;
    const ROWS_ONLY: bool = false;
    const UNIT: f64 = 0.5;
    const MULTIPLIES_ONCE: bool = true;
    const A: &'static [&'static [f64]] = &[&[1.0], &[0.0, 1.0], &[0.0, 0.0, 2.0]];
    const WEIGHTS: &'static [f64] = &[1.0, 2.0, 2.0, 1.0];
    const DIVISOR: f64 = 3.0;
}

impl Tableau for Dop853Tableau {
    const ORDER: usize = 8;
    const ROWS_ONLY: bool = true;
    const UNIT: f64 = 1.0;
    const MULTIPLIES_ONCE: bool = false;
    const A: &'static [&'static [f64]] = &[
        &[0.05260015195876773],
        &[0.0197250569845379, 0.0591751709536137],
        &[0.02958758547680685, 0.0, 0.08876275643042054],
        &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
        &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
        &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
        &[
            0.03709200011850479,
            0.0,
            0.0,
            0.17038392571223998,
            0.10726203044637328,
            -0.015319437748624402,
            0.008273789163814023,
        ],
        &[
            0.6241109587160757,
            0.0,
            0.0,
            -3.3608926294469414,
            -0.868219346841726,
            27.59209969944671,
            20.154067550477894,
            -43.48988418106996,
        ],
        &[
            0.47766253643826434,
            0.0,
            0.0,
            -2.4881146199716677,
            -0.590290826836843,
            21.230051448181193,
            15.279233632882423,
            -33.28821096898486,
            -0.020331201708508627,
        ],
        &[
            -0.9371424300859873,
            0.0,
            0.0,
            5.186372428844064,
            1.0914373489967295,
            -8.149787010746927,
            -18.52006565999696,
            22.739487099350505,
            2.4936055526796523,
            -3.0467644718982196,
        ],
        &[
            2.273310147516538,
            0.0,
            0.0,
            -10.53449546673725,
            -2.0008720582248625,
            -17.9589318631188,
            27.94888452941996,
            -2.8589982771350235,
            -8.87285693353063,
            12.360567175794303,
            0.6433927460157636,
        ],
    ];
    const WEIGHTS: &'static [f64] = &[
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ];
    const DIVISOR: f64 = 1.0;
    const INSIDE: &'static Inside = &Inside {
        is_known: true,
        stages: [
            &[
                0.056167502283047954,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.25350021021662483,
                -0.2462390374708025,
                -0.12419142326381637,
                0.15329179827876568,
                0.00820105229563469,
                0.007567897660545699,
                -0.008298,
            ],
            &[
                0.03183464816350214,
                0.0,
                0.0,
                0.0,
                0.0,
                0.028300909672366776,
                0.053541988307438566,
                -0.05492374857139099,
                0.0,
                0.0,
                -0.00010834732869724932,
                0.0003825710908356584,
                -0.00034046500868740456,
                0.1413124436746325,
            ],
            &[
                -0.42889630158379194,
                0.0,
                0.0,
                0.0,
                0.0,
                -4.697621415361164,
                7.683421196062599,
                4.06898981839711,
                0.3567271874552811,
                0.0,
                0.0,
                0.0,
                -0.0013990241651590145,
                2.9475147891527724,
                -9.15095847217987,
            ],
        ],
        polynomial: [
            [
                -8.428938276109013,
                0.0,
                0.0,
                0.0,
                0.0,
                0.5667149535193777,
                -3.0689499459498917,
                2.38466765651207,
                2.117034582445028,
                -0.871391583777973,
                2.2404374302607883,
                0.6315787787694688,
                -0.08899033645133331,
                18.148505520854727,
                -9.194632392478356,
                -4.436036387594894,
            ],
            [
                10.427508642579134,
                0.0,
                0.0,
                0.0,
                0.0,
                242.28349177525817,
                165.20045171727028,
                -374.5467547226902,
                -22.113666853125306,
                7.733432668472264,
                -30.674084731089398,
                -9.332130526430229,
                15.697238121770845,
                -31.139403219565178,
                -9.35292435884448,
                35.81684148639408,
            ],
            [
                19.985053242002433,
                0.0,
                0.0,
                0.0,
                0.0,
                -387.0373087493518,
                -189.17813819516758,
                527.8081592054236,
                -11.57390253995963,
                6.8812326946963,
                -1.0006050966910838,
                0.7777137798053443,
                -2.778205752353508,
                -60.19669523126412,
                84.32040550667716,
                11.99229113618279,
            ],
            [
                -25.69393346270375,
                0.0,
                0.0,
                0.0,
                0.0,
                -154.18974869023643,
                -231.5293791760455,
                357.6391179106141,
                93.40532418362432,
                -37.45832313645163,
                104.0996495089623,
                29.8402934266605,
                -43.53345659001114,
                96.32455395918828,
                -39.17726167561544,
                -149.72683625798564,
            ],
        ],
        errors: [
            [
                0.01312004499419488,
                0.0,
                0.0,
                0.0,
                0.0,
                -1.2251564463762044,
                -0.4957589496572502,
                1.6643771824549864,
                -0.35032884874997366,
                0.3341791187130175,
                0.08192320648511571,
                -0.022355307863886294,
            ],
            [
                -0.18980075407240762,
                0.0,
                0.0,
                0.0,
                0.0,
                4.450312892752409,
                1.8915178993145003,
                -5.801203960010585,
                -0.4226823213237919,
                -0.1521609496625161,
                0.20136540080403034,
                0.02265179219836082,
            ],
        ],
    };
}

/// Checks the quadrature conditions of the stated order, and all order conditions up to 4 (Hairer, Nørsett, Wanner,
/// Solving ODEs I, table II.2.1).
const fn check<T: Tableau>(facts: Facts) {
    let s = T::STAGES;
    assert!(T::A.len() + 1 == s && facts.stages == s && facts.order as usize == T::ORDER && s <= MAX_STAGES);
    let (mut powers, mut size) = ([0.0; MAX_STAGES], 0.0);
    // Sums of b, b c, b c^2, b a c, b c^3, b c a c, b a c^2, b a a c.
    let mut sums = [0.0; 8];
    let mut c = [0.0; MAX_STAGES];
    let mut ac = [0.0; MAX_STAGES];
    let mut ac2 = [0.0; MAX_STAGES];
    let mut aac = [0.0; MAX_STAGES];
    let mut i = 0;
    while i < s {
        let mut j = 0;
        while j < i {
            let a = T::A[i - 1][j] * T::UNIT;
            c[i] += a;
            ac[i] += a * c[j];
            ac2[i] += a * c[j] * c[j];
            aac[i] += a * ac[j];
            j += 1;
        }
        let b = T::WEIGHTS[i] * T::UNIT / T::DIVISOR;
        size += if b < 0.0 { -b } else { b };
        let mut power = b;
        let mut k = 0;
        while k < MAX_STAGES {
            powers[k] += power;
            power *= c[i];
            k += 1;
        }
        let terms = [1.0, c[i], c[i] * c[i], ac[i], c[i] * c[i] * c[i], c[i] * ac[i], ac2[i], aac[i]];
        let mut k = 0;
        while k < 8 {
            sums[k] += b * terms[k];
            k += 1;
        }
        i += 1;
    }
    // Two roundings of each term and sum, and one of each coefficient.
    let allowed = 4.0 * f64::EPSILON * size;
    let wanted = [1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 4.0, 1.0 / 8.0, 1.0 / 12.0, 1.0 / 24.0];
    let conditions = [0, 1, 2, 4, 8][if T::ORDER < 4 { T::ORDER } else { 4 }];
    let mut k = 0;
    while k < conditions {
        let miss = sums[k] - wanted[k];
        assert!(miss < allowed && -miss < allowed);
        k += 1;
    }
    let mut k = 0;
    while k < T::ORDER {
        let miss = powers[k] - 1.0 / (k as f64 + 1.0);
        assert!(miss < allowed && -miss < allowed);
        k += 1;
    }
}
const _: () = check::<Rk4Tableau>(RK4.facts);
const _: () = check::<Dop853Tableau>(DOP853.facts);

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

/// Largest number of stages of any tableau.
const MAX_STAGES: usize = 12;

/// a_ij of the table, 0 outside its triangle.
#[inline(always)]
const fn coefficient<T: Tableau>(i: usize, j: usize) -> f64 {
    if i < T::STAGES && j < i { T::A[i - 1][j] } else { 0.0 }
}

/// Weight of a stage, 0 outside the table.
#[inline(always)]
const fn weight<T: Tableau>(i: usize) -> f64 {
    if i < T::STAGES { T::WEIGHTS[i] } else { 0.0 }
}

/// Whether the slopes of the rates are their products, whose units contain the moments.
#[inline(always)]
const fn in_products<T: Tableau, R: Real, M: Model<R>, L: Layout>() -> bool {
    T::MULTIPLIES_ONCE && !(M::HEAVY || L::BALANCE || L::CHANGED || L::ORBIT)
}

/// Whether the slopes of the rates contain the unit.
#[inline(always)]
const fn in_units<T: Tableau, R: Real, M: Model<R>, L: Layout>() -> bool {
    T::MULTIPLIES_ONCE && M::HEAVY && !(L::BALANCE || L::CHANGED || L::ORBIT)
}

/// Whether a variable is the change of a rate by a deviation vector.
#[inline(always)]
const fn is_change<L: Layout>(d: usize) -> bool {
    L::TANGENT && d >= L::TANGENT_AT && d < L::TANGENT_AT + 3
}

/// Index of the first coefficient of a row.
#[inline(always)]
const fn first<T: Tableau>(i: usize) -> usize {
    let mut j = 0;
    while j < i && coefficient::<T>(i, j) == 0.0 {
        j += 1;
    }
    j
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

/// A slope times a number of the table. Two additions take less time than a fused product beside others.
#[inline(always)]
fn times<R: Real>(number: f64, slope: R) -> R {
    match number {
        1.0 => slope,
        2.0 => slope + slope,
        _ => R::splat(number) * slope,
    }
}

/// sum + number slope.
#[inline(always)]
fn add_times<R: Real>(sum: R, number: f64, slope: R) -> R {
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
    let change = if L::ORBIT {
        applied.on_orbit::<M, L, D>(model, y)
    } else if const { in_products::<T, R, M, L>() } {
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
    if L::ORBIT {
        applied.forces.further.orbit.change(y, L::OWN_AT, &mut dy);
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
        dense.clear();
        for row in powers {
            dense.push(row);
        }
    }
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
    fn new(p: &Parameters<R>, forces: &ForcesInterval<R>, _numbers: &'static Numbers) -> Self {
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
