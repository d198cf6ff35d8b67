//! Canonical forms: from a body to its canonical form and back.

use super::*;
use rigid::scene::TOP;

fn form(body: &Body) -> Option<ClosedForm> {
    CanonicalForm::of(body).map(|form| form.closed_form)
}

#[test]
fn symmetric_to_the_bit_only() {
    let one_more = 1.0_f64.next_up();
    for turn in 0..3 {
        let turned = |v: [f64; 3]| [v[turn % 3], v[(turn + 1) % 3], v[(turn + 2) % 3]];
        let body = |moments, omega| free(turned(moments), turned(omega));
        let omega = [0.3, 0.4, 0.5];
        assert_eq!(form(&body([1.0, 1.0, 1.5], omega)), Some(ClosedForm::Symmetric));
        assert_eq!(form(&body([1.0, one_more, 1.5], omega)), Some(ClosedForm::Asymmetric));
        assert_eq!(form(&body([1.0, 1.0, 1.0], omega)), Some(ClosedForm::PermanentRotation));
        assert_eq!(form(&body([1.0, 1.0, one_more], omega)), Some(ClosedForm::Symmetric));
        assert_eq!(form(&body([1.0, 1.3, 1.5], [0.0, 0.0, 0.5])), Some(ClosedForm::PermanentRotation));
        assert_eq!(form(&body([1.0, 1.3, 1.5], [0.0, 1e-140, 0.5])), Some(ClosedForm::Asymmetric));
        // The square of this number underflows, yet the axis of the rotation precesses.
        assert_eq!(form(&body([1.0, 1.3, 1.5], [0.0, 5e-324, 0.5])), Some(ClosedForm::Asymmetric));

        let weight = turned([0.0, 0.0, -2.0]);
        let heavy = |moments, omega| Body { weight, ..body(moments, omega) };
        assert_eq!(form(&heavy([1.0, 1.0, 1.5], omega)), Some(ClosedForm::Lagrange));
        assert_eq!(form(&heavy([1.0, 1.0, 1.0], omega)), Some(ClosedForm::Lagrange));
        // A body that is only nearly a Lagrange top has no closed form.
        assert_eq!(form(&heavy([1.0, one_more, 1.5], omega)), None);
        assert_eq!(
            form(&Body { weight: turned([0.0, 5e-324, -2.0]), ..heavy([1.0, 1.0, 1.5], omega) }),
            None
        );
    }
}

#[test]
fn upright_hanging_and_plane_swings() {
    let body = |omega, attitude| Body { moments: [1.0, 1.4, 0.9], weight: [0.0, 0.0, 0.7], omega, attitude };
    let level = [0.8, 0.6, 0.0, 0.0];
    assert_eq!(form(&body([1.5, 0.0, 0.0], level)), Some(ClosedForm::Pendulum));
    assert_eq!(form(&body([1.5, 0.0, 1e-300], level)), None);
    assert_eq!(form(&body([1.5, 0.0, 0.0], [0.8, 0.6, 1e-300, 0.0])), None);
    // Also off the principal axes, as long as the axis of rotation is a principal axis.
    assert_eq!(
        form(&Body { weight: [0.0, 0.3, -0.7], ..body([1.5, 0.0, 0.0], level) }),
        Some(ClosedForm::Pendulum)
    );
    for axis in [1, 2, 3, -1, -2, -3] {
        for attitude in [[0.6, 0.0, 0.0, 0.8], [0.0, 0.6, 0.8, 0.0]] {
            let spin = |w1, w3| top(axis, 2.0, 0.7, [w1, 0.0, w3], attitude);
            assert_eq!(
                form(&spin(0.0, 3.0)),
                Some(ClosedForm::PermanentRotation),
                "axis {axis} {attitude:?}"
            );
            assert_eq!(form(&spin(1e-140, 3.0)), Some(ClosedForm::Lagrange), "axis {axis} {attitude:?}");
            // From the upright position a top without enough spin falls; other swings of this size never count.
            let falls = attitude[0] != 0.0;
            let small = if falls { ClosedForm::Lagrange } else { ClosedForm::PermanentRotation };
            assert_eq!(form(&spin(1e-200, 3.0)), Some(small), "axis {axis} {attitude:?}");
            assert_eq!(
                form(&spin(1e-200, 5.0)),
                Some(ClosedForm::PermanentRotation),
                "axis {axis} {attitude:?}"
            );
        }
    }
    // A top without symmetry that stands or hangs at rest remains at rest; so does a top with its centre of mass on the
    // vertical.
    for attitude in [[1.0, 0.0, 0.0, 0.0], [0.6, 0.0, 0.0, 0.8], [0.0, 1.0, 0.0, 0.0]] {
        let still = body([0.0; 3], attitude);
        assert_eq!(form(&still), Some(ClosedForm::PermanentRotation), "{attitude:?}");
        assert_eq!(motion(&still, &[7.0]), [([0.0; 3], attitude)]);
    }
    let no_lever =
        Body { weight: [0.0, 0.6, 0.8], ..body([0.0; 3], [0.9_f64.sqrt(), -(0.1_f64.sqrt()), 0.0, 0.0]) };
    for (omega, attitude) in motion(&no_lever, &[1.0, 10.0]) {
        assert!(omega.iter().chain(&attitude).all(|x| x.is_finite()));
    }
}

/// The sign of 2 E I2 - L^2 is computed without rounding: exactly on the separatrix there is no flip; one rounding
/// beside the separatrix the next flip is at the time of a computation with 50 digits.
#[test]
fn separatrix_to_the_last_bit() {
    let third = (1.0_f64 / 3.0).sqrt();
    let flip = |moments, omega: [f64; 3]| free_quantities(Isa::NARROWEST, &free(moments, omega)).flip_time;
    assert_eq!(flip([2.0, 4.0, 4.5], [0.75, 0.5, 1.0]), f64::INFINITY);
    for (rate, expected) in [(0.75 * third, 76.543_175_864), (0.75 * third * (1.0 + 1e-15), 70.894_027_206)] {
        let found = flip([1.0, 2.0, 3.0], [0.75, 0.5, rate]);
        assert!((found - expected).abs() < 1e-8, "{found}");
    }
}

/// A body released at the limit leaves at once if it falls; a turning point at the limit counts as reaching the limit.
#[test]
fn limits_at_the_turning_points() {
    let at = |tilt: f64, omega| {
        let (sin, cos) = sincos(0.5 * tilt);
        top(3, 0.5, 1.0, omega, [cos, sin, 0.0, 0.0])
    };
    let time = |body: &Body, limit| tilt_time(Isa::NARROWEST, body, limit).unwrap();
    let release = at(0.5, [0.0, 0.0, 5.0]);
    let nutation = top_quantities(Isa::NARROWEST, &release).unwrap();
    assert_eq!(time(&release, 0.5), 0.0);
    let touched = time(&release, nutation.tilt[1]);
    assert!((touched - 0.5 * nutation.period).abs() <= 4.0 * EPS * nutation.period, "{touched} {nutation:?}");
    let beyond = nutation.tilt[1] * (1.0 + 1e-12);
    assert_eq!(time(&release, beyond), f64::INFINITY);
    // A motion through the top reaches the limit.
    let over = at(0.5, [3.0, 0.0, 0.0]);
    assert!(time(&over, std::f64::consts::PI) < top_quantities(Isa::NARROWEST, &over).unwrap().period);
}

/// The state at time 0 equals the start to the bit, for every form and every axis.
#[test]
fn the_start_is_the_state_at_time_zero() {
    let pendulum = Body {
        moments: [1.0, 1.4, 0.9],
        weight: [0.0, 0.3, -0.7],
        omega: [1.5, 0.0, 0.0],
        attitude: [0.8, 0.6, 0.0, 0.0],
    };
    let spin = free([1.0, 2.0, 3.0], [0.0, 0.0, -2.0]);
    let starts = free_bodies().into_iter().chain(tops()).chain([pendulum, spin]);
    for body in starts {
        for times in [&[0.0][..], &[-1.0, 0.0, 1.0], &[-0.0]] {
            let at = times.iter().position(|&t| t == 0.0).unwrap();
            assert_eq!(motion(&body, times)[at], (body.omega, body.attitude));
        }
    }
}

/// The motion of a top does not depend on the axis of its centre of mass, nor on the sign of its weight.
///
/// The start has two or three more roundings, which the motion magnifies in 5 s: kappa of 200 for the fast tops, as for
/// the golden ones.
#[test]
fn every_axis_and_both_signs_of_the_weight() {
    let all = tops();
    let times = [-2.0, 0.7, 5.0];
    let (first, others) = all.split_at(7);
    for (k, body) in others.iter().enumerate() {
        let expected = motion(&first[k % 7], &times);
        let frame = Frame::of(weight_axis(body));
        let [w, x, y, z] = frame.quaternion();
        for ((omega, attitude), (omega0, attitude0)) in motion(body, &times).into_iter().zip(expected) {
            let omega = frame.apply(omega);
            let attitude = rigid::kinematics::quaternion_product(&attitude, &[w, -x, -y, -z]);
            let sign = (0..4).map(|i| attitude[i] * attitude0[i]).sum::<f64>().signum();
            let turn = 2.0 * norm(&[0, 1, 2, 3].map(|i| sign * attitude[i] - attitude0[i]));
            let off = norm(&[0, 1, 2].map(|i| omega[i] - omega0[i])) / (1.0 + norm(&omega0));
            let bound = 3.0 * 200.0 * EPS;
            assert!(turn <= bound && off <= bound, "{body:?}: {turn:e} {off:e}");
        }
    }
}

#[test]
fn what_has_no_closed_form_is_refused() {
    let body = Body { weight: [0.1, 0.0, 1.0], ..free([1.0, 2.0, 2.5], [0.1, 0.2, 0.3]) };
    let plain = free([1.0, 2.0, 2.5], [0.1, 0.2, 0.3]);
    let ask = |bodies: &[Body], schedule| {
        let request = Request {
            bodies,
            scene: &TOP,
            forces: Forces::NONE,
            method: AnyMethod::Exact,
            record: Record::Attitude,
            schedule,
            steps: &[f64::NAN; 2],
            tolerance: None,
            refinement: 1.0,
            max_steps: 0,
        };
        simulate(&request, Call::to_the_end(Isa::NARROWEST, 1)).err().map(|error| error.to_string())
    };
    assert!(ask(&[plain, body], Schedule::Times(&[1.0])).unwrap().contains('1'));
    assert!(ask(&[plain, plain], Schedule::Strides(&[1])).unwrap().contains("takes no steps"));
    assert!(ask(&[plain, plain], Schedule::Times(&[1.0])).is_none());
    assert_eq!(CanonicalForm::of(&plain).unwrap().evaluator(), Evaluator::Free);
}
