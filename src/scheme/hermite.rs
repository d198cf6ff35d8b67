//! Hermite steps: a predictor and a corrector from derivatives of the equations of motion at several nodes.
//!
//! At each node the rate of change and its first two derivatives are known. The polynomial through those of the last
//! three nodes predicts the state after the step; the polynomial through those of the predicted state and of the last
//! two nodes corrects it. Both integrate a polynomial of degree 8 exactly (Obreshkov 1940; Nitadori and Makino 2008).
//! The rate of change is then evaluated again at the corrected state, its derivatives are not.

use super::acceleration;
use super::{Coefficients, Engine, Facts, Numbers, Scheme, Step, Stepper, Variables};
use crate::forcing::ForcingInterval;
use crate::kinematics::{
    add_roll_across, add_roll_along, add_turn_across, add_turn_along, direction, direction_rate, put,
};
use crate::real::Real;
use crate::scene::{Applied, Layout, Model, Parameters};

/// Hermite steps of order 9.
pub const HERMITE9: Scheme = Scheme::direct(
    Facts {
        name: "hermite9",
        title: "Hermite predictor and corrector of order 9",
        order: 9,
        stages: 2,
        symplectic: false,
        reversible: false,
        group_preserving: false,
        conserves: &[],
        angle_per_step: 0.1,
        citation: "K. Nitadori, J. Makino, Sixth- and eighth-order Hermite integrator for N-body simulations, \
                   New Astron. 13 (2008) 498-507; N. Obreshkov, Neue Quadraturformeln, \
                   Abh. Preuß. Akad. Wiss., Math.-naturwiss. Kl. 4 (1940)",
        doi: "10.1016/j.newast.2008.01.010",
    },
    Step::plain(Engine::Hermite),
    0.2,
);

/// Nodes whose derivatives are known.
pub const NODES: usize = 3;
/// The rate of change and its derivatives at a node.
pub const DERIVATIVES: usize = 3;

/// `step^(k+1)` times the derivative of order `k` of the rate of change.
pub type Derivatives<R, const D: usize> = [[R; D]; DERIVATIVES];
/// The derivatives at the last nodes; see [`ages`].
pub type Past<R, const D: usize> = [Derivatives<R, D>; NODES];
/// Weights of the derivatives at nodes.
type Weights = [[f64; DERIVATIVES]; NODES];

/// The places in [`Past`] of the last node, the one before and the oldest, after some steps.
#[inline(always)]
pub fn ages(steps: usize) -> [usize; NODES] {
    let shift = NODES - steps % NODES;
    [shift % NODES, (shift + 1) % NODES, (shift + 2) % NODES]
}

/// The integral over the next step, by the nodes 0, -1 and -2.
const PREDICTOR: Weights = [
    [560699.0 / 13440.0, -74993.0 / 4480.0, 104119.0 / 40320.0],
    [-6446.0 / 105.0, -81.0 / 8.0, -2932.0 / 315.0],
    [277829.0 / 13440.0, 32783.0 / 4480.0, 30409.0 / 40320.0],
];
/// The same, by the nodes 1, 0 and -1.
const CORRECTOR: Weights = [
    [5669.0 / 13440.0, -303.0 / 4480.0, 169.0 / 40320.0],
    [64.0 / 105.0, 1.0 / 8.0, 8.0 / 315.0],
    [-421.0 / 13440.0, -47.0 / 4480.0, -41.0 / 40320.0],
];
/// The integral over the last two steps, by the nodes 0, -1 and -2.
const LAST_TWO: Weights = [
    [41.0 / 105.0, -2.0 / 35.0, 1.0 / 315.0],
    [128.0 / 105.0, 0.0, 16.0 / 315.0],
    [41.0 / 105.0, 2.0 / 35.0, 1.0 / 315.0],
];
/// Rounds in which the two nodes before a start converge. In each round their error falls by the order of the step.
const ROUNDS: usize = 9;

/// The terms of degree 4 to 7 of a polynomial of degree 7 that is zero at 0 with its first three derivatives, from its
/// value and these derivatives at 1.
const LAST_TERMS: [[f64; 4]; 4] = [
    [35.0, -15.0, 2.5, -1.0 / 6.0],
    [-84.0, 39.0, -7.0, 0.5],
    [70.0, -34.0, 6.5, -0.5],
    [-20.0, 10.0, -2.0, 1.0 / 6.0],
];

/// Checks that weights at three neighbouring nodes, the first one given, integrate every polynomial of degree 8.
const fn check(weights: &Weights, first: i32, [begin, end]: [i32; 2]) {
    let mut degree = 0;
    while degree < NODES * DERIVATIVES {
        let (mut sum, mut size) = (0.0, 0.0);
        let mut j = 0;
        while j < NODES {
            let node = (first - j as i32) as f64;
            let mut k = 0;
            while k < DERIVATIVES && k <= degree {
                // The derivative of order k of t^degree.
                let (mut term, mut i) = (weights[j][k], 0);
                while i < degree {
                    term *= if i < k { (degree - i) as f64 } else { node };
                    i += 1;
                }
                sum += term;
                size += if term < 0.0 { -term } else { term };
                k += 1;
            }
            j += 1;
        }
        let (mut from, mut to, mut i) = (1.0, 1.0, 0);
        while i <= degree {
            (from, to) = (from * begin as f64, to * end as f64);
            i += 1;
        }
        let miss = sum - (to - from) / (degree as f64 + 1.0);
        // Two roundings of each term, and one of each sum.
        let allowed = 8.0 * f64::EPSILON * size;
        assert!(miss < allowed && -miss < allowed);
        degree += 1;
    }
}
const _: () = {
    check(&PREDICTOR, 0, [0, 1]);
    check(&CORRECTOR, 1, [0, 1]);
    check(&LAST_TWO, 0, [-2, 0]);
};

/// Writes a statement once for each number of a range, so that the compiler keeps the numbers in registers.
macro_rules! unrolled {
    (variable $d:ident in $range:expr => $body:block) => {
        unrolled!(@each $d $range, $body, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14)
    };
    (vector $v:ident in $range:expr => $body:block) => {
        unrolled!(@each $v $range, $body, 0 1 2)
    };
    (@each $d:ident $range:expr, $body:block, $($number:literal)*) => {$(
        if const { $range.start <= $number && $number < $range.end } {
            let $d: usize = $number;
            $body
        }
    )*};
}

/// The engine.
#[derive(Clone, Copy)]
pub struct Hermite<R, M> {
    model: M,
    /// The model over one step: with the weight times the step, and products of a rate and an angle of one step.
    over_step: M,
    applied: Applied<R>,
    step: R,
}

/// The angles of one step, and their derivatives times powers of the step.
type Angles<R> = [[R; 3]; DERIVATIVES];

impl<R: Real, M: Model<R>> Hermite<R, M> {
    /// The first variables without which their own rates of change are not known: rates, and the vertical if there is
    /// weight. Torque in space needs all variables.
    #[inline(always)]
    const fn coupled<L: Layout>() -> usize {
        if L::BALANCE { L::LEN } else { 3 + 3 * M::HEAVY as usize }
    }

    /// The directions among the coupled variables.
    #[inline(always)]
    const fn coupled_vectors<L: Layout>() -> usize {
        if L::BALANCE { L::VECTORS } else { M::HEAVY as usize }
    }

    #[inline(always)]
    fn angles<const D: usize>(&self, rates: &[R; D]) -> [R; 3] {
        [self.step * rates[0], self.step * rates[1], self.step * rates[2]]
    }

    /// Adds `n x angles`, with derivatives of the angles.
    #[inline(always)]
    fn turn(n: &[R; 3], angles: &[R; 3], sum: &mut [R; 3]) {
        add_turn_across(n, [angles[0], angles[1]], sum);
        add_turn_along(n, angles[2], sum);
    }

    /// The state or its derivatives of order `j`, for the products of order `ORDER` (Leibniz), with the derivatives of the
    /// angles that they are multiplied by: of order 2, the middle product counts twice.
    #[inline(always)]
    fn factors<'a, const D: usize, const ORDER: usize>(
        y: &'a [R; D],
        angles: &Angles<R>,
        f: &'a Derivatives<R, D>,
        j: usize,
    ) -> (&'a [R; D], [R; 3]) {
        let state = if j == 0 { y } else { &f[j - 1] };
        let [a, b, c] = angles[ORDER - j];
        (state, if ORDER == 2 && j == 1 { [a + a, b + b, c + c] } else { [a, b, c] })
    }

    /// The derivative of order `ORDER` of the rates of change of the coupled variables, at the state `y` with the lower
    /// derivatives `f`. `angles` contains one order more than `f`.
    #[inline(always)]
    fn couple<L: Layout, const D: usize, const ORDER: usize>(
        &self,
        y: &[R; D],
        angles: &Angles<R>,
        f: &mut Derivatives<R, D>,
    ) {
        let newest = if ORDER == 0 { y } else { &f[ORDER - 1] };
        let [turned1, turned2, turned3] = angles[0];
        let mut products = [turned2 * newest[2], turned3 * newest[0], turned1 * newest[1]];
        let mut directions = [[turned1; 3]; 3];
        unrolled!(vector v in (0..Self::coupled_vectors::<L>()) => {
            directions[v] = direction_rate(&direction(newest, v), &angles[0]);
        });
        for j in 0..ORDER {
            let (state, turned) = Self::factors::<D, ORDER>(y, angles, f, j);
            products[0] = turned[1].fma(state[2], products[0]);
            products[1] = turned[2].fma(state[0], products[1]);
            products[2] = turned[0].fma(state[1], products[2]);
            unrolled!(vector v in (0..Self::coupled_vectors::<L>()) => {
                Self::turn(&direction(state, v), &turned, &mut directions[v]);
            });
        }
        let rates = self.over_step.euler(&products, newest);
        put(&mut f[ORDER], 0, rates);
        unrolled!(vector v in (0..Self::coupled_vectors::<L>()) => {
            put(&mut f[ORDER], 3 + 3 * v, directions[v]);
        });
    }

    /// The derivative of order `ORDER` of the rates of change of the variables that follow the coupled ones.
    #[inline(always)]
    fn carry<L: Layout, const D: usize, const ORDER: usize>(
        y: &[R; D],
        angles: &Angles<R>,
        f: &mut Derivatives<R, D>,
    ) {
        let newest = if ORDER == 0 { y } else { &f[ORDER - 1] };
        let mut directions = [angles[0]; 3];
        unrolled!(vector v in (Self::coupled_vectors::<L>()..L::VECTORS) => {
            directions[v] = direction_rate(&direction(newest, v), &angles[0]);
        });
        let mut quaternion = [R::splat(0.0); 4];
        if L::QUATERNION {
            add_roll_across(&quaternion_of::<R, L, D>(newest), [angles[0][0], angles[0][1]], &mut quaternion);
            add_roll_along(&quaternion_of::<R, L, D>(newest), angles[0][2], &mut quaternion);
        }
        for j in 0..ORDER {
            let (state, turned) = Self::factors::<D, ORDER>(y, angles, f, j);
            unrolled!(vector v in (Self::coupled_vectors::<L>()..L::VECTORS) => {
                Self::turn(&direction(state, v), &turned, &mut directions[v]);
            });
            if L::QUATERNION {
                add_roll_across(&quaternion_of::<R, L, D>(state), [turned[0], turned[1]], &mut quaternion);
                add_roll_along(&quaternion_of::<R, L, D>(state), turned[2], &mut quaternion);
            }
        }
        unrolled!(vector v in (Self::coupled_vectors::<L>()..L::VECTORS) => {
            put(&mut f[ORDER], 3 + 3 * v, directions[v]);
        });
        if L::QUATERNION {
            let half = R::splat(0.5);
            for i in 0..4 {
                f[ORDER][L::QUATERNION_AT + i] = half * quaternion[i];
            }
        }
    }

    /// Adds the applied torques and the balance to the derivatives of order `ORDER`. `torques` contains the derivatives
    /// of the torque of lower orders.
    #[inline(always)]
    fn apply<L: Layout, const D: usize, const ORDER: usize>(
        &self,
        y: &[R; D],
        torques: &mut [[R; 3]; DERIVATIVES],
        f: &mut Derivatives<R, D>,
    ) {
        torques[ORDER] = if ORDER == 0 {
            self.applied.torque::<L, D>(y)
        } else {
            // The coefficient of a series of order k is the derivative over k!, and the torque is linear in both states.
            let mut before = if ORDER == 1 { *y } else { f[0] };
            let factor = if ORDER == 1 { self.step } else { self.step + self.step };
            for d in 3..L::BALANCE_AT {
                before[d] = before[d] * factor;
            }
            self.applied.torque_of_order::<L, D>(y, &f[ORDER - 1], &before)
        };
        let change = self.applied.over_moments(&torques[ORDER]);
        for i in 0..3 {
            f[ORDER][i] = self.step.fma(change[i], f[ORDER][i]);
        }
        let mut balance = [R::splat(0.0); 2];
        for j in 0..ORDER + 1 {
            let state = if j == 0 { y } else { &f[j - 1] };
            let mut part = self.applied.balance::<L, D>(&torques[ORDER - j], state);
            if ORDER == 2 && j == 1 {
                part = [part[0] + part[0], part[1] + part[1]];
            }
            balance = [balance[0] + part[0], balance[1] + part[1]];
        }
        f[ORDER][L::BALANCE_AT] = self.step * balance[0];
        f[ORDER][L::BALANCE_AT + 1] = self.step * balance[1];
        f[ORDER][L::BALANCE_AT + 2] = if ORDER == 0 { self.step } else { R::splat(0.0) };
    }

    /// The coupled variables of all derivatives at a state, and the angles.
    #[inline(always)]
    fn coupled_derivatives<L: Layout, const D: usize>(
        &self,
        y: &[R; D],
        f: &mut Derivatives<R, D>,
    ) -> Angles<R> {
        let zero = R::splat(0.0);
        let (mut angles, mut torques) = ([[zero; 3]; DERIVATIVES], [[zero; 3]; DERIVATIVES]);
        macro_rules! orders {
            ($($k:literal)*) => {$(
                angles[$k] = self.angles(if $k == 0 { y } else { &f[$k as usize - 1] });
                self.couple::<L, D, $k>(y, &angles, f);
                if L::BALANCE {
                    self.apply::<L, D, $k>(y, &mut torques, f);
                }
            )*};
        }
        orders!(0 1 2);
        angles
    }

    /// The other variables of all derivatives at a state.
    #[inline(always)]
    fn carried_derivatives<L: Layout, const D: usize>(
        y: &[R; D],
        angles: &Angles<R>,
        f: &mut Derivatives<R, D>,
    ) {
        if !L::BALANCE {
            Self::carry::<L, D, 0>(y, angles, f);
            Self::carry::<L, D, 1>(y, angles, f);
            Self::carry::<L, D, 2>(y, angles, f);
        }
    }

    /// All derivatives at a state.
    #[inline(always)]
    fn derivatives<L: Layout, const D: usize>(&self, y: &[R; D], f: &mut Derivatives<R, D>) {
        let angles = self.coupled_derivatives::<L, D>(y, f);
        Self::carried_derivatives::<L, D>(y, &angles, f);
    }

    /// The rate of change at a state, times the step.
    #[inline(always)]
    fn rate<L: Layout, const D: usize>(&self, y: &[R; D], f: &mut Derivatives<R, D>) {
        let zero = [R::splat(0.0); 3];
        let angles = [self.angles(y), zero, zero];
        self.couple::<L, D, 0>(y, &angles, f);
        if L::BALANCE {
            self.apply::<L, D, 0>(y, &mut [zero; DERIVATIVES], f);
        } else {
            Self::carry::<L, D, 0>(y, &angles, f);
        }
    }
}

#[inline(always)]
fn quaternion_of<R: Real, L: Layout, const D: usize>(y: &[R; D]) -> [R; 4] {
    let at = L::QUATERNION_AT;
    [y[at], y[at + 1], y[at + 2], y[at + 3]]
}

/// The sum of weighted derivatives of one variable, the smallest terms first.
#[inline(always)]
fn weighted<R: Real, const D: usize>(
    weights: &[[f64; DERIVATIVES]],
    nodes: &[&Derivatives<R, D>],
    d: usize,
) -> R {
    let mut sum = R::splat(0.0);
    for j in (0..nodes.len()).rev() {
        for k in (0..DERIVATIVES).rev() {
            let f = nodes[j][k][d];
            let weight = R::splat(weights[j][k]);
            let is_first = j + 1 == nodes.len() && k + 1 == DERIVATIVES;
            sum = if is_first { f * weight } else { weight.fma(f, sum) };
        }
    }
    sum
}

impl<R: Real, M: Model<R>, L: Layout, const D: usize> Stepper<R, M, L, D> for Hermite<R, M> {
    const VARIABLES: Variables = Variables::Rates;
    // As for the series: rows of the matrix are cheaper than the vertical and a quaternion.
    const MOVES: bool = !L::SATELLITE && !L::CALLED && !(M::HEAVY && L::QUATERNION);
    const REMEMBERS: bool = true;
    const HAS_POLYNOMIAL: bool = true;

    #[inline(always)]
    fn new(p: &Parameters<R>, forcing: &ForcingInterval<R>, _numbers: &'static Numbers) -> Self {
        let mut weight = p.weight;
        for i in 0..3 {
            weight[i] = weight[i] * p.step;
        }
        let over_step = M::new(&Parameters { weight, ..*p });
        Hermite { model: M::new(p), over_step, applied: Applied::new(p, forcing), step: p.step }
    }

    #[inline(always)]
    fn step(&self, _p: &Parameters<R>, _y: &mut [R; D], _: &mut [R; D], _: &mut Coefficients<R, D>) {
        unreachable!("a step needs the past")
    }

    /// The nodes before the start lie on the motion that the equations continue backward: no state of the past enters,
    /// so a jump of the torque does no harm.
    #[inline(always)]
    fn begin(&self, y: &[R; D], past: &mut Past<R, D>) {
        self.derivatives::<L, D>(y, &mut past[0]);
        let mut states = [*y; NODES];
        unrolled!(variable d in (0..D) => {
            // The Taylor series to order 3.
            let (f, half) = (past[0][0][d], past[0][1][d] * R::splat(0.5));
            let sixth = past[0][2][d] * R::splat(1.0 / 6.0);
            states[1][d] = y[d] - (f - (half - sixth));
            let [half, sixth] = [half * R::splat(4.0), sixth * R::splat(8.0)];
            states[2][d] = y[d] - ((f + f) - (half - sixth));
        });
        for _ in 0..ROUNDS {
            for node in 1..NODES {
                self.derivatives::<L, D>(&states[node], &mut past[node]);
            }
            let nodes = [&past[0], &past[1], &past[2]];
            unrolled!(variable d in (0..D) => {
                // The corrector of the last step, and of the last two.
                states[1][d] = y[d] - weighted(&CORRECTOR, &nodes, d);
                states[2][d] = y[d] - weighted(&LAST_TWO, &nodes, d);
            });
        }
    }

    #[inline(always)]
    fn advance(&self, y: &mut [R; D], past: &mut Past<R, D>, [last, before, oldest]: [usize; NODES]) {
        let mut predicted = *y;
        // The state is predicted in two parts, so that the derivatives of each stay in registers.
        unrolled!(variable d in (0..Self::coupled::<L>()) => {
            predicted[d] = y[d] + weighted(&PREDICTOR, &[&past[last], &past[before], &past[oldest]], d);
        });
        let mut f = [*y; DERIVATIVES];
        let angles = self.coupled_derivatives::<L, D>(&predicted, &mut f);
        unrolled!(variable d in (Self::coupled::<L>()..D) => {
            predicted[d] = y[d] + weighted(&PREDICTOR, &[&past[last], &past[before], &past[oldest]], d);
        });
        Self::carried_derivatives::<L, D>(&predicted, &angles, &mut f);
        // Number by number: the compiler would call a function to copy whole arrays. And before the correction: the compiler
        // then reads the past again, instead of moving what it has read for the prediction to the stack and back.
        unrolled!(variable d in (0..D) => {
            past[oldest][1][d] = f[1][d];
            past[oldest][2][d] = f[2][d];
        });
        // A lane that rests keeps its state, also one that is infinite.
        let moves = R::splat(0.0).lt(self.step.abs());
        unrolled!(variable d in (0..D) => {
            let corrected = y[d] + weighted(&CORRECTOR, &[&f, &past[last], &past[before]], d);
            y[d] = R::select(moves, corrected, y[d]);
        });
        self.rate::<L, D>(y, &mut f);
        unrolled!(variable d in (0..D) => {
            past[oldest][0][d] = f[0][d];
        });
    }

    /// The polynomial of degree 7 with the states and their derivatives at both ends of a step.
    #[inline(always)]
    fn polynomial(
        &self,
        [before, after]: [&[R; D]; 2],
        [begin, end]: [&Derivatives<R, D>; 2],
        dense: &mut Coefficients<R, D>,
    ) {
        // Copies, so that the states of every step can stay in registers.
        let (before, after) = (*before, *after);
        let mut rows = [[R::splat(0.0); D]; 8];
        for d in 0..D {
            let half = begin[1][d] * R::splat(0.5);
            let sixth = begin[2][d] * R::splat(1.0 / 6.0);
            let (second, third) = (begin[1][d], begin[2][d]);
            // What the cubic at the begin misses at the end, and its derivatives.
            let a = after[d] - (((sixth + half) + begin[0][d]) + before[d]);
            let b = end[0][d] - ((third * R::splat(0.5) + second) + begin[0][d]);
            let c = end[1][d] - (third + second);
            let e = end[2][d] - third;
            let cubic = [before[d], begin[0][d], half, sixth];
            for k in 0..4 {
                rows[k][d] = cubic[k];
                let [of_a, of_b, of_c, of_e] = LAST_TERMS[k];
                let first = R::splat(of_a) * a;
                rows[4 + k][d] = R::splat(of_e).fma(e, R::splat(of_c).fma(c, R::splat(of_b).fma(b, first)));
            }
        }
        dense.clear();
        for row in rows {
            dense.push(row);
        }
    }

    #[inline(always)]
    fn velocity(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        acceleration::<R, M, L, D>(&self.model, &self.applied, y)
    }
}
