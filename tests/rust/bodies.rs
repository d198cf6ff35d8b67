//! Possible moments of inertia, and principal axes.

use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use rigid::body::Body;
use rigid::call::Call;
use rigid::error::Error;
use rigid::forces::Forces;
use rigid::inertia::{check_moments, nearest_possible, principal_axes};
use rigid::method;
use rigid::method::AnyMethod;
use rigid::scene::FREE;
use rigid::simd::Isa;
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, simulate};

/// The error message for these moments, in any order.
fn refusal(moments: [f64; 3]) -> String {
    let [a, b, c] = moments;
    let orders = [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]];
    let refuse = |m: [f64; 3]| {
        let message = check_moments(m).expect_err(&format!("{m:?}")).to_string();
        let (values, rule) = message.split_once("): ").unwrap_or_else(|| panic!("{message}"));
        let values = values.strip_prefix("moments = (").unwrap_or_else(|| panic!("{message}"));
        let read: Vec<f64> = values.split(", ").map(|value| value.parse().unwrap()).collect();
        // Six digits are enough to find the body.
        assert!(read.iter().zip(&m).all(|(x, m)| x.is_nan() || x == m || (x - m).abs() <= 1e-5 * m.abs()));
        rule.to_string()
    };
    let rules = orders.map(refuse);
    // After the rule come the nearest moments, in the order of the given ones.
    let rules = rules.map(|rule| rule.split("; the excess").next().unwrap().to_string());
    assert!(rules.iter().all(|rule| *rule == rules[0]), "{rules:?}");
    rules[0].clone()
}

fn accepted(moments: [f64; 3]) {
    let [a, b, c] = moments;
    for m in [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]] {
        check_moments(m).expect("a real body");
    }
}

#[test]
fn moments_that_no_body_has() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(refusal([1.0, bad, 1.0]), "every moment of inertia must be finite");
    }
    for bad in [0.0, -0.0, -1.0, -5e-324] {
        assert!(refusal([1.0, bad, 1.0]).starts_with("every moment of inertia must be positive (a thin rod"));
    }
    for bad in [[1.0, 1.0, 2.1], [1.0, 2.0, 3.0 + 1e-14], [1e-300, 1.0, 1.0 + 1e-14]] {
        assert!(refusal(bad).starts_with("no moment may exceed the sum of the other two"));
    }
}

#[test]
fn a_flat_body_is_a_body() {
    // 0.1 + 0.7 rounds to less than 0.8, 0.1 + 0.2 to more than 0.3.
    for flat in [[1.0, 1.0, 2.0], [1.0, 2.0, 3.0], [0.1, 0.7, 0.8], [0.1, 0.2, 0.3], [1e-20, 1.0, 1.0]] {
        accepted(flat);
    }
}

/// The nearest possible moments are possible, keep the order, and no possible moments are nearer.
#[test]
fn nearest_bodies_of_impossible_moments() {
    let distance = |m: [f64; 3], n: [f64; 3]| (0..3).map(|k| (m[k] - n[k]).powi(2)).sum::<f64>().sqrt();
    for (moments, expected) in [
        ([3.0, 5.0, 9.0], [10.0 / 3.0, 16.0 / 3.0, 26.0 / 3.0]),
        ([8.0, 4.0, 0.4], [6.8, 5.2, 1.6]),
        ([-1.0, 4.0, 3.0], [0.0, 3.5, 3.5]),
    ] {
        let nearest = nearest_possible(moments);
        // Three roundings of numbers below 16.
        assert!(distance(nearest, expected) < 8e-15, "{nearest:?}");
        let least = distance(moments, nearest);
        // A grid of possible moments around: none is nearer.
        for place in 0..30_usize.pow(3) {
            let near = [place % 30, place / 30 % 30, place / 900].map(|i| i as f64 / 3.0);
            let [a, b, c] = near;
            if a <= b + c && b <= a + c && c <= a + b {
                assert!(distance(moments, near) >= least * (1.0 - 1e-14), "{near:?}");
            }
        }
    }
}

#[test]
fn huge_and_tiny_bodies() {
    let (huge, tiny) = (f64::MAX, 5e-324);
    accepted([huge, huge, huge]);
    accepted([0.5 * huge, 0.5 * huge, huge]);
    assert!(refusal([0.25 * huge, 0.5 * huge, huge]).contains("triangle inequality"));
    accepted([tiny, tiny, tiny]);
    accepted([tiny, tiny, 2.0 * tiny]);
    accepted([5.0 * tiny, tiny, 6.0 * tiny]);
    assert!(refusal([tiny, tiny, 3.0 * tiny]).contains("triangle inequality"));
}

#[test]
fn axis_of_symmetry() {
    let axis = |moments| {
        Body { moments, weight: [0.0; 3], omega: [0.0; 3], attitude: [1.0, 0.0, 0.0, 0.0] }.symmetry_axis()
    };
    assert_eq!(axis([2.0, 1.0, 1.0]), Some(0));
    assert_eq!(axis([1.0, 2.0, 1.0]), Some(1));
    assert_eq!(axis([1.0, 1.0, 2.0]), Some(2));
    assert_eq!(axis([1.0, 1.0, 1.0]), Some(2));
    // Equal to the bit: a nearly symmetric body moves differently after a long time.
    assert_eq!(axis([1.0, 1.0_f64.next_up(), 2.0]), None);
}

// --- Principal axes -------------------------------------------------------------------------------------------

type Tensor = [[f64; 3]; 3];

fn tensor_of(matrix: Matrix3<f64>) -> Tensor {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)]))
}

fn matrix_of(tensor: Tensor) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| tensor[i][j])
}

/// Checks principal axes of a tensor: ascending moments, right-handed orthonormal columns, the sign rule, and the
/// tensor itself. The eigensolver is backward stable: a dozen plane rotations with an error of eps of the norm each, 12
/// * 2.2e-16 < 1e-14.
fn check_axes(tensor: Tensor) -> ([f64; 3], Tensor) {
    let (moments, axes) = principal_axes(tensor).unwrap();
    let axes_matrix = matrix_of(axes);
    assert!(moments[0] <= moments[1] && moments[1] <= moments[2], "{moments:?}");
    assert!((axes_matrix.transpose() * axes_matrix - Matrix3::identity()).norm() < 1e-14);
    assert!((axes_matrix.determinant() - 1.0).abs() < 1e-14);
    for k in 0..2 {
        let column = axes_matrix.column(k);
        assert!(column[column.iamax()] > 0.0, "{axes:?}");
    }
    // Divided by the largest entry first, because a product of huge moments would overflow.
    let scale = matrix_of(tensor).amax();
    let diagonal = Matrix3::from_diagonal(&(Vector3::from(moments) / scale));
    let rebuilt = axes_matrix * diagonal * axes_matrix.transpose();
    let error = (rebuilt - matrix_of(tensor) / scale).norm();
    assert!(error < 1e-14, "{error:e}: {tensor:?}");
    // Equal arguments give equal bits.
    assert_eq!(principal_axes(tensor).unwrap(), (moments, axes));
    (moments, axes)
}

/// The tensor of inertia of a few masses: symmetric to the bit, and of a real body.
fn tensor_of_masses(masses: &[(f64, [f64; 3])]) -> Tensor {
    let mut sum = Matrix3::zeros();
    for &(mass, place) in masses {
        let r = Vector3::from(place);
        sum += mass * (Matrix3::identity() * r.norm_squared() - r * r.transpose());
    }
    tensor_of((sum + sum.transpose()) * 0.5)
}

/// The tensor with these moments along the columns of a rotation.
fn turned(moments: [f64; 3], [a, b, c]: [f64; 3]) -> (Tensor, Matrix3<f64>) {
    let turn: Matrix3<f64> = Rotation3::from_euler_angles(a, b, c).into_inner();
    let tensor: Matrix3<f64> = turn * Matrix3::from_diagonal(&Vector3::from(moments)) * turn.transpose();
    (tensor_of((tensor + tensor.transpose()) * 0.5), turn)
}

fn masses() -> impl Strategy<Value = Vec<(f64, [f64; 3])>> {
    prop::collection::vec((0.1..10.0, prop::array::uniform3(-1.0..1.0)), 4..9)
}

proptest! {
    #[test]
    fn axes_of_any_body(masses in masses(), exponent in -300..300) {
        let scale = 2.0_f64.powi(exponent);
        check_axes(tensor_of_masses(&masses).map(|row| row.map(|x| x * scale)));
    }

    /// Two moments are equal, or nearly: the axes are not unique, the tensor is.
    #[test]
    fn axes_of_a_nearly_symmetric_body(
        angles in prop::array::uniform3(-3.0..3.0),
        third in 0.1..1.9,
        exponent in -60..-4,
    ) {
        let split = 2.0_f64.powi(exponent);
        for moments in [[1.0, 1.0 + split, third], [1.0, 1.0, third], [1.0, 1.0, 1.0]] {
            check_axes(turned(moments, angles).0);
        }
    }

    /// The axis of the largest moment is the direction from which the tensor was made. Its error is 1e-14 over the gap
    /// to the next moment, which is at least 0.1.
    #[test]
    fn axes_are_where_they_were_put(angles in prop::array::uniform3(-3.0..3.0)) {
        let (tensor, turn) = turned([1.0, 1.2, 1.3], angles);
        let (moments, axes) = check_axes(tensor);
        for k in 0..3 {
            let along = matrix_of(axes).column(k).dot(&turn.column(k)).abs();
            prop_assert!((along - 1.0).abs() < 1e-13);
            prop_assert!((moments[k] - [1.0, 1.2, 1.3][k]).abs() < 1e-14);
        }
    }
}

#[test]
fn axes_of_plain_tensors() {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(check_axes(identity).1, identity);
    let diagonal = [[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]];
    let (moments, axes) = check_axes(diagonal);
    assert_eq!(moments, [2.0, 3.0, 4.0]);
    // Axes 2, 1 and minus 3 of the tensor.
    assert_eq!(axes, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
    for scale in [f64::MAX / 4.0, 1e-300] {
        check_axes(diagonal.map(|row| row.map(|x| x * scale)));
    }
}

#[test]
fn tensors_that_are_none() {
    let base = [[2.0, 0.1, 0.2], [0.1, 2.5, 0.3], [0.2, 0.3, 3.0]];
    check_axes(base);
    for (row, column) in [(0, 1), (0, 2), (1, 2), (1, 0), (2, 0), (2, 1)] {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.7] {
            let mut tensor = base;
            tensor[row][column] = value;
            let error = principal_axes(tensor).unwrap_err();
            assert!(matches!(error, Error::Tensor { .. }), "{error}");
            let message = error.to_string();
            assert!(message.contains("finite and symmetric"), "{message}");
            assert!(message.contains(&value.to_string()), "{message}");
        }
    }
    for k in 0..3 {
        let mut tensor = base;
        tensor[k][k] = f64::NAN;
        assert!(matches!(principal_axes(tensor), Err(Error::Tensor { .. })));
        tensor[k][k] = -2.0;
        assert!(matches!(check_moments(check_axes(tensor).0), Err(Error::MomentNotPositive(..))));
        tensor[k][k] = 9.0;
        assert!(matches!(check_moments(check_axes(tensor).0), Err(Error::MomentTriangle { .. })));
    }
    // The rounding of a rotated tensor is accepted.
    let mut nearly = base;
    nearly[0][1] *= 1.0 + 1e-13;
    check_axes(nearly);
}

/// Tiny and huge moments give the rates of an ordinary body of the same shape.
#[test]
fn the_unit_of_inertia_does_not_matter() {
    let rates = |unit: f64| -> Vec<Vec<f64>> {
        let moments = [2.0 * unit, 3.0 * unit, 4.0 * unit];
        check_moments(moments).unwrap();
        let body = Body { moments, weight: [0.0; 3], omega: [0.3, 1.0, 0.2], attitude: [1.0, 0.0, 0.0, 0.0] };
        let of_method = |method: &'static method::Method| {
            let request = Request {
                bodies: &[body],
                scene: &FREE,
                forces: Forces::NONE,
                method: AnyMethod::Steps(method),
                record: Record::Rates,
                schedule: Schedule::Times(&[5.0]),
                steps: &[0.01],
                tolerance: None,
                refinement: 1.0,
                max_steps: 1000,
            };
            let states = simulate(&request, Call::to_the_end(Isa::NARROWEST, 1)).unwrap();
            assert_eq!(states.status[0], Status::Finished);
            states.rates().to_vec()
        };
        method::ALL.iter().copied().map(of_method).collect()
    };
    // Powers of two give the same bits. Squares of the momenta must not overflow.
    for exponent in [-500, -30, 30, 500] {
        assert_eq!(rates(2.0_f64.powi(exponent)), rates(1.0), "2^{exponent}");
    }
}

/// A flat body remains possible after any rotation, although the eigenvalues of its tensor are rounded.
#[test]
fn flat_bodies_come_back_from_their_tensors() {
    let axes = Vector3::new(1.0, 2.0, 3.0);
    for k in 0..2000 {
        let angles = [0.37, 1.01, 2.3].map(|step| step * f64::from(k));
        let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let tensor = turn.matrix() * Matrix3::from_diagonal(&axes) * turn.matrix().transpose();
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (tensor[(i, j)] + tensor[(j, i)])));
        assert!(check_moments(principal_axes(rows).unwrap().0).is_ok(), "{rows:?}");
    }
}
