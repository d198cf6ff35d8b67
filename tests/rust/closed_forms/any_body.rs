//! Properties of every closed form, for any body.

use super::*;

/// A number in twelve decades of either sign, or exactly zero.
fn wide() -> impl Strategy<Value = f64> {
    let number = (-12.0..0.0_f64, prop::bool::ANY)
        .prop_map(|(e, minus)| 10.0_f64.powf(e) * [1.0, -1.0][usize::from(minus)]);
    prop_oneof![4 => number, 1 => Just(0.0)]
}

fn wide3() -> impl Strategy<Value = [f64; 3]> {
    [wide(), wide(), wide()]
}

/// Moments of three masses on the axes, including needles, plates and spheres.
fn moments() -> impl Strategy<Value = [f64; 3]> {
    let masses = wide3().prop_map(|m| m.map(f64::abs));
    let moments = masses.prop_map(|[a, b, c]| [b + c, c + a, a + b]);
    moments.prop_filter("a body", |&m| check_moments(m).is_ok())
}

/// Any attitude, including exactly upright and hanging ones, and attitudes close to these.
fn attitudes() -> impl Strategy<Value = [f64; 4]> {
    let some = prop::array::uniform4(-1.0..1.0_f64);
    let upright = (-PI..PI).prop_map(|a: f64| [a.cos(), 0.0, 0.0, a.sin()]);
    let hanging = (-PI..PI).prop_map(|a: f64| [0.0, a.cos(), a.sin(), 0.0]);
    let near = (wide(), wide(), -PI..PI).prop_map(|(x, y, a): (f64, f64, f64)| [a.cos(), x, y, a.sin()]);
    let below = (wide(), wide(), -PI..PI).prop_map(|(x, y, a): (f64, f64, f64)| [x, a.cos(), a.sin(), y]);
    prop_oneof![some, upright, hanging, near, below].prop_filter("a direction", |q| norm(q) > 0.1).prop_map(
        |q| {
            let length = norm(&q);
            q.map(|c| c / length)
        },
    )
}

/// At these times, in radians of a bound of the rate, every number is finite, a unit quaternion has length one, and
/// energy and momentum differ by some eps of their scale.
fn stays_on_its_invariants(body: &Body) -> Result<(), TestCaseError> {
    let rate = body.fastest_rate(BodyForces::NONE, [0.0; 2]);
    prop_assume!(rate > 0.0 && rate.is_finite());
    let times = [-1e6, -3.0, 0.0, 1e-9, 0.7, 20.0, 1e3, 1e12].map(|angle| angle / rate);
    let states = solved(body, &times);
    prop_assert_eq!(states.status[0], Status::Finished, "{:?}", body);
    prop_assert!(states.unit_drift[0] <= 4.0 * EPS, "{:?}", states.unit_drift[0]);
    prop_assert!(states.energy_drift[0] <= INVARIANT, "{:e} {:?}", states.energy_drift[0], states.omega);
    prop_assert!(states.momentum_drift[0] <= INVARIANT, "{:e} {:?}", states.momentum_drift[0], states.omega);
    Ok(())
}

/// Free rates are three numbers with errors of at most 5 ulp: 10 eps of a sum of squares. The rates of a top come from
/// a quotient of two such parameters, and its height from their squares: 10 eps of the kinetic energy and 10 eps of the
/// potential energy, and half as much again where both energies are of the size of the scale. The sum is rounded, here
/// and at the start.
const INVARIANT: f64 = 32.0 * EPS;

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, rng_seed: RngSeed::Fixed(2026), ..ProptestConfig::default() })]

    #[test]
    fn any_free_body(moments in moments(), omega in wide3(), attitude in attitudes(), e in -60..60, f in -60..60) {
        let (inertia, rate) = (2.0_f64.powi(5 * e), 2.0_f64.powi(2 * f));
        let body = Body {
            moments: moments.map(|x| x * inertia),
            weight: [0.0; 3],
            omega: omega.map(|x| x * rate),
            attitude,
        };
        stays_on_its_invariants(&body)?;
    }

    /// Two moments equal or an ulp to a millionth apart.
    #[test]
    fn any_nearly_symmetric_body(third in 1e-9..1.99, split in 0..53, omega in wide3(), attitude in attitudes()) {
        for split in [0.0, 0.5 * EPS * 2.0_f64.powi(split)] {
            for moments in [[1.0, 1.0 - split, third], [third, 1.0, 1.0 - split], [1.0, third, 1.0 - split]] {
                if check_moments(moments).is_ok() {
                    stays_on_its_invariants(&Body { moments, weight: [0.0; 3], omega, attitude })?;
                }
            }
        }
    }

    #[test]
    fn any_top(
        spin_moment in prop_oneof![1e-9..2.0, Just(1.0), Just(2.0)],
        omega in wide3(),
        attitude in attitudes(),
        weight in -6.0..6.0_f64,
        axis in prop_oneof![Just(3), Just(-3), Just(1), Just(-2)],
        scale in -60..60,
    ) {
        let mut body = top(axis, 10.0_f64.powf(weight), spin_moment, omega, [1.0, 0.0, 0.0, 0.0]);
        if axis.abs() == 3 {
            // Exactly upright and hanging.
            body.attitude = attitude;
        } else {
            body = top(axis, 10.0_f64.powf(weight), spin_moment, omega, attitude);
        }
        let unit = 2.0_f64.powi(4 * scale);
        body.moments = body.moments.map(|x| x * unit);
        body.weight = body.weight.map(|x| x * unit);
        stays_on_its_invariants(&body)?;
    }
}
