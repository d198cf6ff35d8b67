//! What a closed form says about a whole motion: periods, turning points, advances, and times of events.

use super::place::{Form, Kind, Place};
use super::{Exit, Free, Lagrange, Motion, Symmetric};
use crate::simd::Isa;
use crate::special::{atan2, sincos};
use crate::start::Body;
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
    /// What it is called.
    pub kind: &'static str,
}

/// Runs scalar code with the FMA instruction where there is one: same bits, ten times faster.
macro_rules! with_fma {
    ($($(#[$doc:meta])* $name:ident = $generic:ident($($argument:ident: $type:ty),*) -> $out:ty;)*) => {$(
        $(#[$doc])*
        pub fn $name(isa: Isa, $($argument: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn fma($($argument: $type),*) -> $out {
                $generic($($argument),*)
            }
            match isa {
                #[cfg(target_arch = "x86_64")]
                Isa::Avx512 | Isa::Avx2 => {
                    assert!(isa.is_available());
                    // Safety: asked the line before.
                    unsafe { fma($($argument),*) }
                }
                _ => $generic($($argument),*),
            }
        }
    )*};
}
with_fma! {
    /// The quantities of a free body.
    free_quantities = free(body: &Body) -> FreeQuantities;
    /// Time of the first sign change of a component (0 to 2) after the start, and the time from one to the next;
    /// `None` if the motion has no closed form for it.
    sign_changes = changes(body: &Body, axis: usize) -> Option<[f64; 2]>;
    /// The quantities of a symmetric top; `None` if it is none.
    top_quantities = top(body: &Body) -> Option<TopQuantities>;
    /// First time at which the angle between the vertical and the centre of mass of a symmetric top is `limit`.
    tilt_time = time_of_tilt(body: &Body, limit: f64) -> Option<f64>;
}

#[inline(always)]
fn motion<M: Motion<f64>>(place: &Place, body: &Body) -> M {
    let body = place.canonical(body);
    M::new(&body.moments, &body.weight, &body.omega, &body.attitude)
}

#[inline(always)]
fn free(body: &Body) -> FreeQuantities {
    let body = &Body { weight: [0.0; 3], ..*body };
    let Some(place) = Place::of(body) else { unreachable!("every free body has a closed form") };
    let never = f64::INFINITY;
    let omega = body.omega;
    match place.form {
        Form::Asymmetric => {
            let m: Free<f64> = motion(&place, body);
            let (axis, sign) = m.encircled();
            let [k, kc] = m.torus.moduli;
            let circulates = kc > 0.0;
            FreeQuantities {
                axis: if circulates { (sign * (axis + 1.0)) as i8 } else { 0 },
                parameter: [k * k, kc * kc],
                flip_time: m.half_period(),
                amplitude: m.amplitude(),
                precession: m.precession(),
            }
        }
        Form::Symmetric => {
            let m: Symmetric<f64> = motion(&place, body);
            let [body_rate, about_l] = m.turning();
            let [w1, w2, w3] = place.canonical(body).omega;
            let transverse = (w1 * w1 + w2 * w2).sqrt();
            let axis = (0..3).find(|&k| place.axis(k) == 2).unwrap_or(2);
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
                precession: omega.iter().map(|w| w * w).sum::<f64>().sqrt(),
            }
        }
    }
}

#[inline(always)]
fn changes(body: &Body, axis: usize) -> Option<[f64; 2]> {
    let place = Place::of(body)?;
    let never = Some([f64::INFINITY; 2]);
    let question = Exit { axis: place.axis(axis) as f64, limit: 0.0, direction: 1.0 };
    match place.form {
        Form::Spin => never,
        Form::Symmetric => {
            let m: Symmetric<f64> = motion(&place, body);
            Some([m.exit(&question), PI / m.turning()[0].abs()])
        }
        Form::Asymmetric => {
            let m: Free<f64> = motion(&place, body);
            Some([m.exit(&question), m.half_period()])
        }
        Form::Lagrange if place.axis(axis) == 2 => never,
        Form::Lagrange | Form::Pendulum => None,
    }
}

/// The angle whose 1 - cos and 1 + cos are these.
#[inline(always)]
fn angle(versine: f64, rest: f64) -> f64 {
    2.0 * atan2(versine.sqrt(), rest.sqrt())
}

#[inline(always)]
fn top(body: &Body) -> Option<TopQuantities> {
    let place = Place::of(body)?;
    if place.kind() != Kind::Lagrange {
        return upright(body, &place);
    }
    let m: Lagrange<f64> = motion(&place, body);
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
        tilt: [angle(wa, rest_a), angle(wb, rest_b)],
        period: m.period(),
        advance: m.advances(),
        mc: kc * kc,
        kind,
    })
}

/// A top that stands upright or hangs, without swing.
#[inline(always)]
fn upright(body: &Body, place: &Place) -> Option<TopQuantities> {
    let axis = (0..3).find(|&k| body.is_weighed_along(k))?;
    if place.form != Form::Spin {
        return None;
    }
    let weight = body.weight[axis].abs();
    let transverse = body.moments[(axis + 1) % 3];
    let spin = body.moments[axis] * body.omega[axis];
    let hanging = body.depth(axis) > 1.0;
    let kind = if hanging {
        "hanging"
    } else if spin * spin >= 4.0 * transverse * weight {
        "sleeping"
    } else {
        "upright"
    };
    let tilt = if hanging { PI } else { 0.0 };
    Some(TopQuantities { tilt: [tilt; 2], period: f64::INFINITY, advance: [f64::NAN; 2], mc: 1.0, kind })
}

#[inline(always)]
fn time_of_tilt(body: &Body, limit: f64) -> Option<f64> {
    let place = Place::of(body)?;
    let (sin, _) = sincos(0.5 * limit);
    let versine = 2.0 * sin * sin;
    if place.kind() != Kind::Lagrange {
        let axis = (0..3).find(|&k| body.is_weighed_along(k))?;
        return Some(if body.depth(axis) == versine { 0.0 } else { f64::INFINITY });
    }
    let m: Lagrange<f64> = motion(&place, body);
    // A turning point is reached without being passed.
    let at = |w: f64| (w - versine).abs() <= 4.0 * f64::EPSILON * w;
    let [wa, wb, _] = m.points.w;
    if at(m.tilt_at_start()) {
        return Some(0.0);
    }
    for (w, time) in [wa, wb].into_iter().zip(m.turning_times()) {
        if at(w) {
            return Some(time);
        }
    }
    let direction = if m.tilt_at_start() <= versine { 1.0 } else { -1.0 };
    Some(m.exit(&Exit { axis: 2.0, limit: versine, direction }))
}
