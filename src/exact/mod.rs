//! Closed forms: the motion of a body at any time, evaluated and not integrated.

mod canonical;
pub mod derived;
mod evaluate;
mod free;
mod lagrange;
mod symmetric;

pub use canonical::{CanonicalForm, ClosedForm, Evaluator, Question, depths, lagrange_axis, versines};
pub use evaluate::{StartRows, StateRows};
pub use free::Free;
pub use lagrange::Lagrange;
pub use symmetric::Symmetric;

use crate::real::{Real, two_sum};
use crate::special::sincos_of_sum;
use crate::special::theta::Phase;

/// A motion in closed form.
pub trait Motion<R: Real>: Copy {
    /// Whether the rates without the attitude cost less than a state.
    const RATES_ALONE: bool = true;
    /// The motion from its start: moments, `mgl com`, rates in the body, unit quaternion.
    fn new(moments: &[R; 3], weight: &[R; 3], omega: &[R; 3], attitude: &[R; 4]) -> Self;
    /// The rates in the body at the time `t`.
    #[inline(always)]
    fn rates(&self, t: R) -> [R; 3] {
        self.state(t).0
    }
    /// Rates and attitude at the time `t`.
    fn state(&self, t: R) -> ([R; 3], [R; 4]);
    /// First time after the start at which the motion crosses the boundary `question`; infinite if it never does.
    fn exit(&self, question: &Exit<R>) -> R;
}

/// The boundary of the stable motion, of a body or of those of all lanes. A free motion reads the axis, a top the other fields.
#[derive(Clone, Copy)]
pub struct Exit<R> {
    /// 0, 1 or 2: the component of the rates whose sign is observed.
    pub axis: R,
    /// 1 - cos and 1 + cos of the angle between the vertical and the centre of mass that must not be passed.
    pub limit: [R; 2],
    /// The limit is crossed upward (1) or downward (-1).
    pub direction: R,
}

/// Distance in phase to the next of the zeros that lie two quarter periods apart, one of them at an even (or odd)
/// number of quarters; a zero at the start itself is not the next one.
#[inline(always)]
fn to_next_zero<R: Real>(start: &Phase<R>, quarter: R, odd: R::Mask) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let parity = R::select(R::odd(start.quarters), one, zero);
    let wanted = R::select(odd, one, zero);
    let here = (parity - wanted).abs().lt(R::splat(0.5));
    let ahead = start.rest.lt(zero);
    let whole = R::select(here, R::select(ahead, zero, quarter + quarter), quarter);
    whole - start.rest
}

/// `v` times a number.
#[inline(always)]
fn scaled<R: Real, const N: usize>(v: &[R; N], by: R) -> [R; N] {
    let mut out = *v;
    for x in &mut out {
        *x = *x * by;
    }
    out
}

/// The exponent of the power of two below the largest of three sizes.
#[inline(always)]
fn exponent_near<R: Real>(v: &[R; 3]) -> R {
    let (_, e) = v[0].abs().max(v[1].abs().max(v[2].abs())).frexp();
    e.max(R::splat(-1020.0)).min(R::splat(1020.0))
}

/// The power of two below the largest of three sizes, and its inverse: motions do not depend on units, to the bit.
#[inline(always)]
fn power_near<R: Real>(v: &[R; 3]) -> (R, R) {
    let e = exponent_near(v);
    (e.exp2i(), (-e).exp2i())
}

/// sin and cos of the sum of products and a small angle; the products are not rounded before the reduction.
#[inline(always)]
fn turn<R: Real, const N: usize>(products: &[(R, R); N], angle: R) -> (R, R) {
    let (mut high, mut low) = (angle, R::splat(0.0));
    for &(a, b) in products {
        let product = a * b;
        let product_low = a.fms(b, product);
        let (sum, lost) = two_sum(high, product);
        low = low + (lost + product_low);
        high = sum;
    }
    sincos_of_sum(high, low)
}

/// A quaternion of nearly unit length made a unit quaternion, by one step of Newton.
#[inline(always)]
fn normalised<R: Real>(q: &[R; 4]) -> [R; 4] {
    let length2 = q[0].fma(q[0], q[1].fma(q[1], q[2].fma(q[2], q[3] * q[3])));
    let correction = (length2 - R::splat(1.0)) * R::splat(-0.5);
    let mut out = *q;
    for x in &mut out {
        *x = correction.fma(*x, *x);
    }
    out
}
