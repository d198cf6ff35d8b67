//! Flip times, periods, amplitudes and mean turns, against other formulas and the motion itself.

use super::*;

/// The vertical in axes whose third axis points to the centre of mass, and this axis in space.
fn poles(body: &Body, attitude: &[f64; 4]) -> ([f64; 3], [f64; 3]) {
    let frame = Frame::of(weight_axis(body));
    let gamma = to_body_frame(attitude, &[0.0, 0.0, 1.0]);
    (frame.apply(gamma), to_space(attitude, frame.back([0.0, 0.0, 1.0])))
}

/// The angle between the vertical and the centre of mass.
fn tilt(body: &Body, attitude: &[f64; 4]) -> f64 {
    let ([x, y, z], _) = poles(body, attitude);
    x.hypot(y).atan2(z)
}

/// The tilt stays between its turning points and reaches both in a period. After a period the tilt is the same again,
/// and precession and spin have advanced.
///
/// The error of the angles of a state is some eps of the angle turned, divided by the sine of the smallest tilt.
#[test]
fn nutation_and_advance() {
    const SAMPLES: i32 = 4000;
    for body in tops() {
        let quantities = top_quantities(Isa::available()[0], &body).unwrap();
        let [low, high] = quantities.tilt;
        let period = quantities.period;
        let times: Vec<f64> = (0..=SAMPLES).map(|k| period * f64::from(k) / f64::from(SAMPLES)).collect();
        let states = motion(&body, &times);
        let tilts: Vec<f64> = states.iter().map(|(_, q)| tilt(&body, q)).collect();
        let smallest = tilts.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = tilts.iter().copied().fold(0.0, f64::max);
        let rate = states.iter().map(|(w, _)| norm(w)).fold(0.0, f64::max);
        let slack = 8.0 * EPS * (1.0 + rate * period) / low.sin().min(high.sin());
        assert!(smallest >= low - slack && largest <= high + slack, "{quantities:?} {smallest} {largest}");
        // The cosine varies as sn^2 <= u^2; the nearest sample differs by half a step of the phase.
        let cosines = [low, smallest, largest, high].map(f64::cos);
        let missed = (cosines[0] - cosines[3]) * (complete_k(quantities.mc) / f64::from(SAMPLES)).powi(2);
        assert!(cosines[0] - cosines[1] <= missed + slack, "{quantities:?} {smallest}");
        assert!(cosines[2] - cosines[3] <= missed + slack, "{quantities:?} {largest}");
        // The slope of the tilt is at most a rate.
        let again = (tilts[SAMPLES as usize] - tilts[0]).abs();
        assert!(again <= slack, "{quantities:?}: {again:e}");

        let phi = unwrapped(states.iter().map(|(_, q)| {
            let (_, [x, y, _]) = poles(&body, q);
            y.atan2(x)
        }));
        let psi = unwrapped(states.iter().map(|(_, q)| {
            let ([x, y, _], _) = poles(&body, q);
            x.atan2(y)
        }));
        for (found, expected) in [phi, psi].into_iter().zip(quantities.advance) {
            assert!(
                (found - expected).abs() <= 2.0 * slack,
                "{quantities:?}: {phi} {psi}, {slack:e} {body:?}"
            );
        }
    }
}

/// The tilt passes its limit at the computed time, and not before.
#[test]
fn tilt_time_is_when_the_limit_is_passed() {
    let isa = Isa::available()[0];
    for body in tops() {
        let [low, high] = top_quantities(isa, &body).unwrap().tilt;
        let start = tilt(&body, &body.attitude);
        for part in [0.05, 0.3, 0.7, 0.98] {
            let limit = low + part * (high - low);
            let t = tilt_time(isa, &body, limit).unwrap();
            if high - low < 1e-7 || (start - limit).abs() < 1e-9 {
                continue;
            }
            // The slope at the limit, from the invariants of a motion between two turning points.
            let period = top_quantities(isa, &body).unwrap().period;
            assert!(0.0 < t && t < period, "{body:?}: {limit} at {t}");
            let rate = body.fastest_rate(BodyForces::NONE, [0.0; 2]);
            let after = 1e-6 * period;
            let near = motion(&body, &[t, t + after]);
            let slope = (tilt(&body, &near[1].1) - tilt(&body, &near[0].1)).abs() / after;
            let slack = 8.0 * EPS * (1.0 + rate * t) / limit.sin() + 4.0 * EPS * slope * t;
            let off = (tilt(&body, &near[0].1) - limit).abs();
            assert!(off <= slack, "{body:?}: {limit} at {t}, off {off:e} of {slack:e}");
            let times: Vec<f64> = (0..2000).map(|k| t * f64::from(k) / 2000.0).collect();
            let side = (start - limit).signum();
            for (_, q) in motion(&body, &times) {
                assert!((tilt(&body, &q) - limit) * side > -slack, "{body:?}: {limit} before {t}");
            }
        }
        // A tilt beyond the turning points is never reached.
        for limit in [0.5 * low, 0.5 * (high + PI)] {
            assert_eq!(tilt_time(isa, &body, limit), Some(f64::INFINITY), "{body:?} {limit}");
        }
    }
}

/// The period of a pendulum released at rest at an angle from hanging: 4 K(sin^2(angle/2)) sqrt(I / mgl). The period is
/// that of two nutations, and does not depend on the other moments of a body that swings about a principal axis.
#[test]
fn period_of_a_pendulum() {
    let isa = Isa::available()[0];
    for angle in [1e-6_f64, 0.1, 1.0, 2.0, 3.0, 3.13] {
        let attitude = [(0.5 * (PI - angle)).cos(), (0.5 * (PI - angle)).sin(), 0.0, 0.0];
        for (moments, form) in
            [([1.2, 1.2, 0.3], ClosedForm::Lagrange), ([1.2, 1.5, 0.9], ClosedForm::Pendulum)]
        {
            let body = Body { moments, weight: [0.0, 0.0, 2.5], omega: [0.0; 3], attitude };
            assert_eq!(CanonicalForm::of(&body).unwrap().closed_form, form);
            let quantities = top_quantities(isa, &body).unwrap();
            // cos^2(angle/2) of the attitude.
            let mc = attitude[1] * attitude[1];
            let expected = 4.0 * complete_k(1.0 - attitude[0] * attitude[0]) * (1.2_f64 / 2.5).sqrt();
            let expected = if mc < 0.5 { 4.0 * complete_k(mc) * (1.2_f64 / 2.5).sqrt() } else { expected };
            // The error of K is at most 5 ulp, and half the relative error of mc.
            let miss = (2.0 * quantities.period / expected - 1.0).abs();
            assert!(miss <= 16.0 * EPS, "{angle}: {} {expected}, {miss:e}", 2.0 * quantities.period);
            assert_eq!(quantities.kind, "planar", "{quantities:?}");
            // In the motion the body is again at rest where it was released.
            let (omega, q) = motion(&body, &[2.0 * quantities.period])[0];
            let off = (tilt(&body, &q) - (PI - angle)).abs();
            assert!(norm(&omega) <= 1e-14 && off <= 1e-14, "{angle}: {omega:?} {off:e}");
        }
    }
}

/// Starts exactly at a pole, slow and fast, with energies below and above that of the other pole: a pendulum turns
/// where its energy is potential, a spinning top somewhere, and every number is finite.
#[test]
fn tops_that_start_at_a_pole() {
    let isa = Isa::available()[0];
    for attitude in [[0.0, 0.6, 0.8, 0.0], [0.0, 1.0, 0.0, 0.0], [0.6, 0.0, 0.0, 0.8]] {
        let hanging = attitude[0] == 0.0;
        for (spin_moment, spin) in [(0.1, 0.0), (0.1, 1e-6), (0.5, -0.3), (1e-9, 1.0), (2.0, 1.0)] {
            for k in 1..400 {
                // The kinetic energy over the energy of a fall from top to bottom.
                let ratio = 0.01 * f64::from(k);
                let body = top(3, 1.0, spin_moment, [2.0 * ratio.sqrt(), 0.0, spin], attitude);
                let quantities = top_quantities(isa, &body).unwrap();
                let [low, high] = quantities.tilt;
                assert_eq!(if hanging { high } else { low }, if hanging { PI } else { 0.0 }, "{body:?}");
                assert!(0.0 <= low && low <= high && high <= PI, "{body:?} {quantities:?}");
                let separatrix = hanging && spin == 0.0 && k == 100;
                assert!(quantities.period.is_finite() != separatrix, "{body:?} {quantities:?}");
                if spin == 0.0 {
                    // 1 + cos at the other turning point, 2 for a circulating body: a few roundings, and as many over
                    // the distance to the next root.
                    let expected = if hanging { 2.0 * ratio.min(1.0) } else { 0.0 };
                    let turning = if hanging { 1.0 + low.cos() } else { 1.0 + high.cos() };
                    let allowed = 4.0 * EPS * (1.0 + 1.0 / (1.0 - ratio).abs());
                    assert!((turning - expected).abs() <= allowed, "{body:?} {quantities:?}");
                }
            }
        }
    }
}
