//! Explicit Runge-Kutta steps of a body on an orbit on which nothing else acts. The eccentric anomaly E takes the place
//! of the time: equal steps in E are short near the periapsis, where the body turns fast.
//!
//! The distance is `r = 1 - e cos E`, or `e cosh E - 1` of a hyperbola. The rates over the pace of the anomaly are `Q = omega r / n`, with
//! `Q' = (I2 - I3) / I1 (Q2 Q3 - 3 o2 o3 / r) + (e sin E / r) Q1` and so on, o the direction from the planet in the
//! body. The quaternion q leads from the body to the frame of the orbit, whose third axis k is the normal:
//! `q' = q (0, Q) / 2 - (sqrt |1 - e^2| / 2r) k q`. On a hyperbola -e cosh E and e sinh E take the place of e cos E and
//! e sin E, and -1 that of 1 in the distance. Steps move the numbers of `Orbit::clock_at`, from which both follow.

use super::runge_kutta::{add_times, for_stages, powers, times};
use super::tableau::{ALL_STAGES, MAX_STAGES, Tableau, coefficient, node, time, weight};
use super::{Coefficients, Engine, EngineName, Numbers, Step, Variables, cubic_inside};
use crate::forces::{Along, ForcesInterval, StepAlong, conic_sign};
use crate::kinematics;
use crate::real::Real;
use crate::scene::{Layout, Model, Parameters};
use std::marker::PhantomData;

/// Variables that change by slopes: rates over the pace, and the quaternion.
const TURNING: usize = 7;

/// The engine. Its slopes contain the unit of the table: the step, or a part of it.
#[derive(Clone, Copy)]
pub struct OrbitSteps<T, R> {
    /// `(I2 - I3) / I1` and its cyclic neighbours, times the unit.
    ratios: [R; 3],
    unit: R,
    /// Half of the unit, and that times `sqrt |1 - e^2|`.
    half: R,
    turn: R,
    /// Twice `sqrt |1 - e^2|`, for halves of the normal.
    frame: R,
    /// 1 of an ellipse, -1 of a hyperbola.
    sign: R,
    eccentricity: R,
    /// To the stages, and over the step.
    along: [Along<R>; MAX_STAGES],
    step: StepAlong<R>,
    tableau: PhantomData<T>,
}

/// y + sum_j a_ij k_j.
#[inline(always)]
fn stage_state<T: Tableau, R: Real, const I: usize>(
    y: &[R; TURNING],
    k: &[[R; TURNING]; MAX_STAGES],
) -> [R; TURNING] {
    let mut at = *y;
    for_stages!(J => {
        if const { coefficient::<T>(I, J) != 0.0 } {
            for d in 0..TURNING {
                at[d] = add_times(at[d], const { coefficient::<T>(I, J) }, k[J][d]);
            }
        }
    });
    at
}

/// The slopes and the weighted sum of the slopes of all stages, unrolled.
macro_rules! stages {
    ($engine:ident, $clock:ident, $y:ident, $k:ident, $sum:ident: $($i:literal)*) => {$(
        if const { $i < T::STAGES } {
            $k[$i] = if const { $i == 0 } {
                $engine.rate($engine.place($clock), &$y)
            } else {
                $engine.rate($engine.along[$i].after($clock), &stage_state::<T, R, $i>(&$y, &$k))
            };
            if const { weight::<T>($i) != 0.0 } {
                for d in 0..TURNING {
                    $sum[d] = if const { $i == 0 } {
                        times(const { weight::<T>($i) }, $k[$i][d])
                    } else {
                        add_times($sum[d], const { weight::<T>($i) }, $k[$i][d])
                    };
                }
            }
        }
    )*};
}

/// The variables that change by slopes, and the numbers of `Orbit::clock_at`.
#[expect(clippy::manual_memcpy, reason = "a copy of slices is a call")]
#[inline(always)]
fn parts<R: Real, const D: usize>(y: &[R; D]) -> ([R; TURNING], [R; 2]) {
    let mut turning = [y[0]; TURNING];
    for d in 0..TURNING {
        turning[d] = y[d];
    }
    (turning, [y[TURNING], y[TURNING + 1]])
}

impl<T: Tableau, R: Real> OrbitSteps<T, R> {
    /// `e cos E` and `e sin E` at the numbers of the clock; see [`Along::after`].
    #[inline(always)]
    fn place(&self, clock: [R; 2]) -> [R; 2] {
        self.along[0].after(clock)
    }

    /// The equations of motion, times the unit, where `e cos E` and `e sin E` are known.
    #[inline(always)]
    fn rate(&self, [cos, sin]: [R; 2], y: &[R; TURNING]) -> [R; TURNING] {
        let (one, half) = (R::splat(1.0), R::splat(0.5));
        let near = one / (self.sign - cos);
        let stretch = (self.unit * sin) * near;
        let turn = self.turn * near;
        let [a, b, c, q0, q1, q2, q3] = *y;
        // Halves of o, so that 3 o2 o3 / r is 12 of their products.
        let x = q2.fnma(q2, q3.fnma(q3, half));
        let y = q0.fnma(q3, q1 * q2);
        let z = q0.fma(q2, q1 * q3);
        let pull = R::splat(12.0) * near;
        let (px, py) = (pull * x, pull * y);
        let (u, v, w) = (a * self.half, b * self.half, c * self.half);
        [
            self.ratios[0].fma(py.fnma(z, b * c), stretch * a),
            self.ratios[1].fma(px.fnma(z, c * a), stretch * b),
            self.ratios[2].fma(px.fnma(y, a * b), stretch * c),
            turn.fma(q3, q3.fnma(w, q2.fnma(v, -(q1 * u)))),
            turn.fma(q2, q3.fnma(v, q2.fma(w, q0 * u))),
            turn.fnma(q1, q1.fnma(w, q3.fma(u, q0 * v))),
            turn.fnma(q0, q2.fnma(u, q1.fma(v, q0 * w))),
        ]
    }

    /// The motion inside a step between two states, in powers of the fraction of the step.
    #[inline(always)]
    fn inside(
        &self,
        step: R,
        before: &[R; TURNING],
        clock: [R; 2],
        after: &[R; TURNING],
    ) -> [[R; TURNING]; 8] {
        let (mut k, mut sum, before) = ([*before; MAX_STAGES], *before, *before);
        stages!(self, clock, before, k, sum: 0 1 2 3 4 5 6 7 8 9 10 11);
        let mut slopes = [before; ALL_STAGES];
        #[expect(clippy::manual_memcpy, reason = "a copy of slices is a call")]
        for i in 0..MAX_STAGES {
            slopes[i] = k[i];
        }
        slopes[MAX_STAGES] = self.rate(self.place(self.step.after(clock)), after);
        for (stage, row) in T::INSIDE.stages.iter().enumerate() {
            let mut at = before;
            for (i, &number) in row.iter().enumerate() {
                for d in 0..TURNING {
                    at[d] = R::splat(number).fma(slopes[i][d], at[d]);
                }
            }
            let part = Along::of(self.eccentricity, step * R::splat(node(row)));
            slopes[MAX_STAGES + 1 + stage] = self.rate(part.after(clock), &at);
        }
        powers::<T, R, TURNING>(&before, after, &slopes)
    }
}

impl<T: Tableau, R: Real, M: Model<R>, L: Layout, const D: usize> Engine<R, M, L, D> for OrbitSteps<T, R> {
    const VARIABLES: Variables = Variables::Rates;
    const MOVES: bool = L::CLOCK;
    const ON_CLOCK: bool = true;
    const IS_LONG: bool = true;

    #[inline(always)]
    fn new(p: &Parameters<R>, forces: &ForcesInterval<'static, R>, _numbers: &'static Numbers) -> Self {
        let (one, e) = (R::splat(1.0), forces.further.orbit.eccentricity());
        let unit = p.step * R::splat(T::UNIT);
        let half = unit * R::splat(0.5);
        let [a, b, c] = M::new(p).ratios();
        let root = ((one - e) * (one + e)).abs().sqrt();
        let mut along = [Along::of(e, R::splat(0.0)); MAX_STAGES];
        for_stages!(I => {
            if const { I + 1 < T::STAGES } {
                along[I + 1] = Along::of(e, p.step * R::splat(const { time::<T>(I + 1) * T::UNIT }));
            }
        });
        OrbitSteps {
            ratios: [a * unit, b * unit, c * unit],
            unit,
            half,
            turn: half * root,
            frame: root + root,
            sign: conic_sign(e),
            eccentricity: e,
            along,
            step: StepAlong::of(e, p.step),
            tableau: PhantomData,
        }
    }

    #[inline(always)]
    fn step(&self, _p: &Parameters<R>, y: &mut [R; D]) {
        let (before, clock) = parts(y);
        let mut k = [before; MAX_STAGES];
        let mut sum = before;
        stages!(self, clock, before, k, sum: 0 1 2 3 4 5 6 7 8 9 10 11);
        for d in 0..TURNING {
            y[d] = add_times(y[d], const { 1.0 / T::DIVISOR }, sum[d]);
        }
        [y[TURNING], y[TURNING + 1]] = self.step.after(clock);
    }

    /// The motion inside a step: of `rk4`, whose steps are short, by the cubic.
    #[inline(always)]
    fn motion_inside(
        &self,
        p: &Parameters<R>,
        [before, after]: [&[R; D]; 2],
        dense: &mut Coefficients<R, D>,
    ) {
        let ((before, clock), (after, end)) = (parts(before), parts(after));
        if const { !T::INSIDE.is_known } {
            let slopes = [self.rate(self.place(clock), &before), self.rate(self.place(end), &after)];
            cubic_inside(R::splat(1.0 / T::UNIT), [&before, &after], &slopes, dense);
            return;
        }
        dense.clear();
        for row in self.inside(p.step, &before, clock, &after) {
            let mut all = [R::splat(0.0); D];
            kinematics::put(&mut all, 0, row);
            dense.push(all);
        }
    }

    /// The angular velocity of the body against the frame of the orbit.
    #[inline(always)]
    fn turning(&self, _p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        let (turning, clock) = parts(y);
        let [cos, _] = self.place(clock);
        let [a, b, c, q0, q1, q2, q3] = turning;
        let [_, _, normal] = kinematics::half_rows(&[q0, q1, q2, q3]);
        let rate = self.frame / (self.sign - cos);
        [rate.fnma(normal[0], a), rate.fnma(normal[1], b), rate.fnma(normal[2], c)]
    }

    /// The frame turns about the normal: its rate in the body is the difference w of the rates and of those against it,
    /// `w' = -e sin E / r w + w x turning`.
    #[inline(always)]
    fn turning_rate(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        let turning = Engine::<R, M, L, D>::turning(self, p, y);
        let frame = [y[0] - turning[0], y[1] - turning[1], y[2] - turning[2]];
        let [cos, sin] = self.place([y[TURNING], y[TURNING + 1]]);
        let slower = sin / (self.sign - cos);
        let turned = kinematics::cross(&frame, &turning);
        let mut change = Engine::<R, M, L, D>::velocity(self, p, y);
        for k in 0..3 {
            change[k] = slower.fma(frame[k], change[k]) - turned[k];
        }
        change
    }

    #[inline(always)]
    fn velocity(&self, p: &Parameters<R>, y: &[R; D]) -> [R; 3] {
        let (turning, clock) = parts(y);
        let [a, b, c, ..] = self.rate(self.place(clock), &turning);
        let share = R::splat(1.0) / (p.step * R::splat(T::UNIT));
        [a * share, b * share, c * share]
    }
}

/// The step over the anomaly of an orbit, of a method that has one.
pub(super) const fn on_orbit(step: Step) -> Option<Step> {
    let engine = match step.engine {
        EngineName::Rk4 => EngineName::OrbitRk4,
        EngineName::Dop853 => EngineName::OrbitDop853,
        _ => return None,
    };
    Some(Step { engine, numbers: step.numbers })
}
