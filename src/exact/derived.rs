//! Quantities of a whole motion from its closed form: periods, turning points, advances, and times of events.

use super::canonical::{CanonicalForm, ClosedForm, Evaluator, depths, versines};
use super::{Exit, Free, Lagrange, Motion, Symmetric, power_near};
use crate::body::Body;
use crate::simd::Isa;
use crate::special::atan2;
use std::f64::consts::PI;

/// A free motion as a whole.
#[derive(Clone, Copy, Debug)]
pub struct FreeQuantities {
    /// Body axis that the polhode encircles, 1 to 3, with the sign of the rate along it; 0 if there is none.
    pub axis: i8,
    /// Parameter and complementary parameter of the elliptic functions.
    pub parameter: [f64; 2],
    /// Time between sign changes of the components that change it.
    pub flip_time: f64,
    /// Largest size of each component of the rates.
    pub amplitude: [f64; 3],
    /// Mean rate at which the encircled axis precesses about L; the rate about L where the axis is at rest.
    pub precession: f64,
}

impl FreeQuantities {
    /// Period of the rates.
    pub fn period(&self) -> f64 {
        2.0 * self.flip_time
    }

    /// Angle by which the encircled axis precesses in a period; 0 if it does not precess.
    pub fn turn(&self) -> f64 {
        if self.precession == 0.0 { 0.0 } else { 2.0 * self.flip_time * self.precession }
    }
}

/// The nutation of a top as a whole.
#[derive(Clone, Copy, Debug)]
pub struct TopQuantities {
    /// Angles between the vertical and the centre of mass at the turning points.
    pub tilt: [f64; 2],
    /// Period of the nutation.
    pub period: f64,
    /// Advance of precession and spin in a period, about the vertical and about the centre of mass.
    pub advance: [f64; 2],
    /// Complementary parameter.
    pub mc: f64,
    /// Name of the motion.
    pub kind: &'static str,
}

impl TopQuantities {
    /// Mean rate of precession.
    pub fn precession(&self) -> f64 {
        self.advance[0] / self.period
    }

    /// Whether the top precesses against its spin.
    pub fn is_retrograde(&self, body: &Body) -> bool {
        let along: f64 = (0..3).map(|k| body.omega[k] * body.weight[k]).sum();
        self.advance[0] * along < 0.0
    }
}

/// Whether the motion of a free body or a Lagrange top leads away from an unstable rotation, or is one, to the last bit.
pub fn is_on_separatrix(isa: Isa, body: &Body) -> bool {
    if body.weight != [0.0; 3] {
        return top_quantities(isa, body).is_some_and(|top| top.mc == 0.0 || top.kind == UPRIGHT);
    }
    let turning = (0..3).filter(|&k| body.omega[k] != 0.0);
    match turning.clone().count() {
        0 => false,
        1 => turning.into_iter().any(|k| {
            let [i, j, own] = [k + 1, k + 2, k].map(|axis| body.moments[axis % 3]);
            i.min(j) < own && own < i.max(j)
        }),
        // A parameter below the range of doubles is zero, yet the period is finite.
        _ => {
            let free = free_quantities(isa, body);
            free.parameter[1] == 0.0 && free.flip_time == f64::INFINITY
        }
    }
}

/// The name of an upright top that falls if it is touched.
const UPRIGHT: &str = "upright";

/// Time of sign change number `k`, from 0, of a component with these `sign_changes`.
pub fn sign_change_time([first, interval]: [f64; 2], k: usize) -> f64 {
    let never = first == f64::INFINITY;
    if never || k == 0 { first } else { first + k as f64 * interval }
}

/// Runs scalar code with the FMA instruction where there is one: same bits, ten times faster.
macro_rules! with_fma {
    ($(
        $(#[$doc:meta])*
        $vis:vis fn $name:ident $(<$motion:ident>)? =
            $generic:ident($($argument:ident: $type:ty),*) -> $out:ty;
    )*) => {$(
        $(#[$doc])*
        $vis fn $name $(<$motion: Motion<f64>>)? (isa: Isa, $($argument: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn fma $(<$motion: Motion<f64>>)? (isa: Isa, $($argument: $type),*) -> $out {
                $generic(isa, $($argument),*)
            }
            match isa {
                #[cfg(target_arch = "x86_64")]
                Isa::Avx512 | Isa::Avx2 => {
                    assert!(isa.is_available());
                    // SAFETY: the line before checks the feature.
                    unsafe { fma(isa, $($argument),*) }
                }
                #[cfg(plain)]
                Isa::Scalar => $generic(isa, $($argument),*),
            }
        }
    )*};
}
with_fma! {
    /// The quantities of a free body.
    pub fn free_quantities = free(body: &Body) -> FreeQuantities;
    /// Time of the first sign change of a component (0 to 2) after the start, and the time from one to the next;
    /// `None` if the motion has no closed form for it.
    pub fn sign_changes = changes(body: &Body, axis: usize) -> Option<[f64; 2]>;
    /// The quantities of a symmetric top; `None` if the body is not a symmetric top.
    pub fn top_quantities = top(body: &Body) -> Option<TopQuantities>;
    /// Complementary parameter of the nutation of a top or pendulum, and the rate at which it leaves the saddle of its
    /// separatrix; 1 and 0 for any other body.
    pub fn saddle = saddle_of(body: &Body) -> [f64; 2];
    /// First time at which the angle between the vertical and the centre of mass of a symmetric top is `limit`.
    pub fn tilt_time = time_of_tilt(body: &Body, limit: f64) -> Option<f64>;
    /// The motion of a body that has this canonical form. All quantities share the code of its set-up.
    fn motion<M> = set_up(form: CanonicalForm, body: &Body) -> M;
}

#[inline(always)]
fn set_up<M: Motion<f64>>(_: Isa, form: CanonicalForm, body: &Body) -> M {
    let body = form.to_canonical(body);
    M::new(&body.moments, &body.weight, &body.omega, &body.attitude)
}

/// The length of a vector whose squares may leave the range of doubles.
#[inline(always)]
fn length(v: [f64; 3]) -> f64 {
    let (unit, inverse) = power_near(&v);
    unit * v.iter().map(|x| (x * inverse) * (x * inverse)).sum::<f64>().sqrt()
}

#[inline(always)]
fn free(isa: Isa, body: &Body) -> FreeQuantities {
    let body = &Body { weight: [0.0; 3], ..*body };
    let Some(form) = CanonicalForm::of(body) else { unreachable!("every free body has a closed form") };
    let never = f64::INFINITY;
    let omega = body.omega;
    match form.closed_form {
        ClosedForm::Asymmetric => {
            let m: Free<f64> = motion(isa, form, body);
            let (axis, sign) = m.encircled();
            let [k, kc] = m.torus.moduli;
            let circulates = m.half_period() < never;
            FreeQuantities {
                axis: if circulates { (sign * (axis + 1.0)) as i8 } else { 0 },
                parameter: [k * k, kc * kc],
                flip_time: m.half_period(),
                amplitude: m.amplitude(),
                precession: m.precession(),
            }
        }
        ClosedForm::Symmetric => {
            let m: Symmetric<f64> = motion(isa, form, body);
            let [body_rate, about_l] = m.turning();
            let [w1, w2, w3] = form.to_canonical(body).omega;
            let transverse = length([w1, w2, 0.0]);
            let axis = (0..3).find(|&k| form.axis(k) == 2).unwrap_or(2);
            let turns = body_rate != 0.0 && transverse > 0.0;
            let mut amplitude = if turns { [transverse; 3] } else { omega.map(f64::abs) };
            amplitude[axis] = w3.abs();
            FreeQuantities {
                axis: if w3 == 0.0 { 0 } else { (axis + 1) as i8 * if w3 < 0.0 { -1 } else { 1 } },
                parameter: [0.0, 1.0],
                flip_time: if turns { PI / body_rate.abs() } else { never },
                amplitude,
                precession: about_l,
            }
        }
        _ => {
            let spherical = body.moments[0] == body.moments[1] && body.moments[1] == body.moments[2];
            let along = (0..3).find(|&k| omega[k] != 0.0 && !spherical);
            FreeQuantities {
                axis: along.map_or(0, |k| (k + 1) as i8 * if omega[k] < 0.0 { -1 } else { 1 }),
                parameter: [0.0, 1.0],
                flip_time: never,
                amplitude: omega.map(f64::abs),
                precession: length(omega),
            }
        }
    }
}

#[inline(always)]
fn changes(isa: Isa, body: &Body, axis: usize) -> Option<[f64; 2]> {
    let form = CanonicalForm::of(body)?;
    let never = Some([f64::INFINITY; 2]);
    let question = Exit { axis: form.axis(axis) as f64, limit: [0.0; 2], direction: 1.0 };
    match form.closed_form {
        ClosedForm::PermanentRotation => never,
        ClosedForm::Symmetric => {
            let m: Symmetric<f64> = motion(isa, form, body);
            Some([m.exit(&question), PI / m.turning()[0].abs()])
        }
        ClosedForm::Asymmetric => {
            let m: Free<f64> = motion(isa, form, body);
            Some([m.exit(&question), m.half_period()])
        }
        ClosedForm::Lagrange if form.axis(axis) == 2 => never,
        ClosedForm::Lagrange | ClosedForm::Pendulum => None,
    }
}

/// The angle with given sqrt(1 - cos) and 1 + cos.
#[inline(always)]
fn angle(root: f64, rest: f64) -> f64 {
    2.0 * atan2(root, rest.sqrt())
}

#[inline(always)]
fn top(isa: Isa, body: &Body) -> Option<TopQuantities> {
    let form = CanonicalForm::of(body)?;
    if form.evaluator() != Evaluator::Lagrange {
        return upright(body, form);
    }
    let m: Lagrange<f64> = motion(isa, form, body);
    let [wa, wb, _] = m.points.w;
    let [rest_a, rest_b] = m.points.rest;
    let [top, spin] = m.momenta();
    // phi' vanishes where w = -b/a.
    let reversal = -top / spin;
    let near = |w: f64| (reversal - w).abs() <= 1e-12 * wb;
    let kind = if m.torus.moduli[0] == 0.0 || wb - wa <= 1e-14 * wb {
        "steady"
    } else if spin == 0.0 && top == 0.0 {
        "planar"
    } else if spin == 0.0 {
        "spherical pendulum"
    } else if near(wa) || near(wb) {
        "cusp"
    } else if wa < reversal && reversal < wb {
        "loop"
    } else {
        "monotone"
    };
    let kc = m.torus.moduli[1];
    Some(TopQuantities {
        tilt: [angle(m.points.root, rest_a), angle(wb.sqrt(), rest_b)],
        period: m.period(),
        advance: m.advances(),
        mc: kc * kc,
        kind,
    })
}

/// A top that is upright or hangs, without swinging.
#[inline(always)]
fn upright(body: &Body, form: CanonicalForm) -> Option<TopQuantities> {
    let axis = (0..3).find(|&k| body.is_weighed_along(k))?;
    if form.closed_form != ClosedForm::PermanentRotation {
        return None;
    }
    let weight = body.weight[axis].abs();
    let transverse = body.moments[(axis + 1) % 3];
    let spin = body.moments[axis] * body.omega[axis];
    let hanging = depths(body, axis)[0] > 1.0;
    let kind = if hanging {
        "hanging"
    } else if spin * spin >= 4.0 * transverse * weight {
        "sleeping"
    } else {
        UPRIGHT
    };
    let tilt = if hanging { PI } else { 0.0 };
    Some(TopQuantities { tilt: [tilt; 2], period: f64::INFINITY, advance: [f64::NAN; 2], mc: 1.0, kind })
}

#[inline(always)]
fn saddle_of(isa: Isa, body: &Body) -> [f64; 2] {
    let Some(form) = CanonicalForm::of(body).filter(|form| form.evaluator() == Evaluator::Lagrange) else {
        return [1.0, 0.0];
    };
    let m: Lagrange<f64> = motion(isa, form, body);
    let kc = m.torus.moduli[1];
    [kc * kc, m.saddle_exponent()]
}

#[inline(always)]
fn time_of_tilt(isa: Isa, body: &Body, limit: f64) -> Option<f64> {
    let form = CanonicalForm::of(body)?;
    let versine = versines(limit);
    if form.evaluator() != Evaluator::Lagrange {
        let axis = (0..3).find(|&k| body.is_weighed_along(k))?;
        return Some(if depths(body, axis) == versine { 0.0 } else { f64::INFINITY });
    }
    let m: Lagrange<f64> = motion(isa, form, body);
    // A turning point is reached without being passed. A rounded limit is rounded in its distance from the nearer pole.
    let rounding = 4.0 * f64::EPSILON;
    let at = |[w, rest]: [f64; 2]| {
        if versine[0] <= 1.0 {
            (w - versine[0]).abs() <= rounding * w
        } else {
            (rest - versine[1]).abs() <= rounding * (rest + (rest * w).sqrt())
        }
    };
    let ([wa, wb, _], [rest_a, rest_b]) = (m.points.w, m.points.rest);
    if at(m.at_start()) {
        return Some(0.0);
    }
    for (turning_point, time) in [[wa, rest_a], [wb, rest_b]].into_iter().zip(m.turning_times()) {
        if at(turning_point) {
            return Some(time);
        }
    }
    let direction = if m.at_start()[0] <= versine[0] { 1.0 } else { -1.0 };
    Some(m.exit(&Exit { axis: 2.0, limit: versine, direction }))
}
