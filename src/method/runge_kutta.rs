//! Explicit Runge-Kutta methods: one engine, any tableau.

use super::{Facts, Form, Rk4, Scheme, kinetic_of_rates, momentum_of_rates};
use crate::model::{self, Layout, Model, Parameters};
use crate::real::Real;
use std::marker::PhantomData;

/// The table of an explicit Runge-Kutta method, `k_i = f(y + h sum_j a_ij k_j)`,
/// `y + (h / divisor) sum_i weights_i k_i`.
pub trait Tableau: Copy {
    /// Name, order, properties, citation.
    const FACTS: Facts;
    /// Rows 1, 2, … of the matrix a; row i has i entries.
    const A: &'static [&'static [f64]];
    /// Weights over the common divisor: whole numbers where they can be.
    const WEIGHTS: &'static [f64];
    /// Their common divisor.
    const DIVISOR: f64;
    /// Number of stages.
    const STAGES: usize = Self::WEIGHTS.len();
}

impl Tableau for Rk4 {
    const FACTS: Facts = Facts {
        name: "rk4",
        title: "classical Runge-Kutta",
        order: 4,
        stages: 4,
        symplectic: false,
        reversible: false,
        group_preserving: false,
        angle_per_step: 1.0 / 16.0,
        citation: "W. Kutta, Beitrag zur näherungsweisen Integration totaler Differentialgleichungen, \
                   Z. Math. Phys. 46 (1901) 435-453",
        doi: "",
    };
    const A: &'static [&'static [f64]] = &[&[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]];
    const WEIGHTS: &'static [f64] = &[1.0, 2.0, 2.0, 1.0];
    const DIVISOR: f64 = 6.0;
}

/// Order conditions up to 4 (Hairer, Nørsett, Wanner, Solving ODEs I, table II.2.1), to 4 ulp.
const fn check<T: Tableau>() {
    let s = T::STAGES;
    assert!(T::A.len() + 1 == s && T::FACTS.stages == s && s <= MAX_STAGES);
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
            let a = T::A[i - 1][j];
            c[i] += a;
            ac[i] += a * c[j];
            ac2[i] += a * c[j] * c[j];
            aac[i] += a * ac[j];
            j += 1;
        }
        let b = T::WEIGHTS[i] / T::DIVISOR;
        let terms = [1.0, c[i], c[i] * c[i], ac[i], c[i] * c[i] * c[i], c[i] * ac[i], ac2[i], aac[i]];
        let mut k = 0;
        while k < 8 {
            sums[k] += b * terms[k];
            k += 1;
        }
        i += 1;
    }
    let wanted = [1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 4.0, 1.0 / 8.0, 1.0 / 12.0, 1.0 / 24.0];
    let conditions = [0, 1, 2, 4, 8][if T::FACTS.order < 4 { T::FACTS.order as usize } else { 4 }];
    let mut k = 0;
    while k < conditions {
        let miss = sums[k] - wanted[k];
        assert!(miss < 1e-15 && -miss < 1e-15);
        k += 1;
    }
}
const _: () = check::<Rk4>();

/// The engine.
pub struct RungeKutta<T, R, M> {
    model: M,
    /// a_ij times the step.
    scaled: [[R; MAX_STAGES]; MAX_STAGES],
    /// The step over the divisor of the weights.
    weight_unit: R,
    table: PhantomData<T>,
}

impl<T, R: Copy, M: Copy> Clone for RungeKutta<T, R, M> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T, R: Copy, M: Copy> Copy for RungeKutta<T, R, M> {}

/// Most stages of any table here.
const MAX_STAGES: usize = 4;

/// a_ij of the table, 0 outside its triangle.
const fn coefficient<T: Tableau>(i: usize, j: usize) -> f64 {
    if i < T::STAGES && j < i { T::A[i - 1][j] } else { 0.0 }
}

/// y + h sum_j a_ij k_j.
#[inline(always)]
fn stage_state<T: Tableau, const I: usize, R: Real, const D: usize>(
    scaled: &[R; MAX_STAGES],
    y: &[R; D],
    k: &[[R; D]; MAX_STAGES],
) -> [R; D] {
    let mut at = *y;
    macro_rules! terms {
        ($($j:literal)*) => {$(
            if const { coefficient::<T>(I, $j) != 0.0 } {
                for d in 0..D {
                    at[d] = scaled[$j].fma(k[$j][d], at[d]);
                }
            }
        )*};
    }
    terms!(0 1 2);
    at
}

/// sum += weight_i k; the first stage begins the sum.
#[inline(always)]
fn add_weighted<T: Tableau, const I: usize, R: Real, const D: usize>(sum: &mut [R; D], k: &[R; D]) {
    for d in 0..D {
        sum[d] = match (I, const { T::WEIGHTS[I] }) {
            (0, 1.0) => k[d],
            (0, weight) => k[d] * R::splat(weight),
            (_, 1.0) => sum[d] + k[d],
            // Two additions for one fused product: the same bits, and adders are idle here.
            (_, 2.0) => sum[d] + (k[d] + k[d]),
            (_, weight) => R::splat(weight).fma(k[d], sum[d]),
        };
    }
}

/// The equations of motion of the whole state.
#[inline(always)]
fn rate<R: Real, M: Model<R>, L: Layout, const D: usize>(model: &M, y: &[R; D]) -> [R; D] {
    let omega = [y[0], y[1], y[2]];
    let mut dy = *y;
    dy[..3].copy_from_slice(&model.acceleration(&omega, y));
    for v in 0..L::VECTORS {
        let at = 3 + 3 * v;
        dy[at..at + 3].copy_from_slice(&model::direction_rate(&model::direction(y, v), &omega));
    }
    if L::QUATERNION {
        let at = L::QUATERNION_AT;
        let q = [y[at], y[at + 1], y[at + 2], y[at + 3]];
        dy[at..at + 4].copy_from_slice(&model::attitude_rate(&q, &omega));
    }
    dy
}

impl<T: Tableau, R: Real, M: Model<R>, L: Layout, const D: usize> Scheme<R, M, L, D> for RungeKutta<T, R, M> {
    const FORM: Form = Form::Rates;

    #[inline(always)]
    fn new(p: &Parameters<R>) -> Self {
        let mut scaled = [[p.step; MAX_STAGES]; MAX_STAGES];
        for i in 0..T::STAGES {
            for j in 0..i {
                scaled[i][j] = p.step * R::splat(coefficient::<T>(i, j));
            }
        }
        let weight_unit = p.step / R::splat(T::DIVISOR);
        RungeKutta { model: M::new(p), scaled, weight_unit, table: PhantomData }
    }

    #[inline(always)]
    fn step(&self, _p: &Parameters<R>, y: &mut [R; D]) {
        let mut k = [*y; MAX_STAGES];
        let mut sum = *y;
        // Written out, so that each number of the table is a literal and its zeros and ones cost nothing.
        macro_rules! stages {
            ($($i:literal)*) => {$(
                if const { $i < T::STAGES } {
                    let at = stage_state::<T, $i, R, D>(&self.scaled[$i], y, &k);
                    k[$i] = rate::<R, M, L, D>(&self.model, &at);
                    add_weighted::<T, $i, R, D>(&mut sum, &k[$i]);
                }
            )*};
        }
        stages!(0 1 2 3);
        for d in 0..D {
            y[d] = self.weight_unit.fma(sum[d], y[d]);
        }
    }

    #[inline(always)]
    fn velocity(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        self.model.acceleration(&[y[0], y[1], y[2]], y)
    }

    #[inline(always)]
    fn momentum(p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        momentum_of_rates(p, y)
    }

    #[inline(always)]
    fn kinetic(p: &Parameters<R>, y: &[R; D]) -> R {
        kinetic_of_rates(p, y)
    }
}
