//! `Inertia`: principal moments that a real body can have.

use crate::error::Error;
use nalgebra::{Matrix3, SymmetricEigen};

/// Relative slack of the triangle inequality: the moments of a flat body, rounded to doubles, may break the inequality
/// by this much.
const FLATNESS: f64 = 4.0 * f64::EPSILON;

/// Relative error of an eigenvalue of a tensor of inertia.
const EIGENVALUE_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Whether three principal moments are possible, or the first rule that they break.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum MomentStatus {
    /// A rigid body with these moments exists.
    Possible = 0,
    /// A moment is NaN or infinite.
    NotFinite = 1,
    /// A moment is zero or negative.
    NotPositive = 2,
    /// A moment exceeds the sum of the other two by more than the rounding of a flat body.
    Triangle = 3,
}

impl MomentStatus {
    /// All statuses, in the order of their codes.
    pub const ALL: [MomentStatus; 4] =
        [MomentStatus::Possible, MomentStatus::NotFinite, MomentStatus::NotPositive, MomentStatus::Triangle];

    /// The status of three moments.
    pub fn of(moments: [f64; 3]) -> MomentStatus {
        let [a, b, c] = moments;
        // A difference, because the sum of two huge moments could overflow and the half of a subnormal moment rounds.
        let exceeds = |big: f64, x: f64, y: f64| big - x > y + FLATNESS * big;
        if moments.iter().any(|m| !m.is_finite()) {
            MomentStatus::NotFinite
        } else if moments.iter().any(|&m| m <= 0.0) {
            MomentStatus::NotPositive
        } else if exceeds(a, b, c) || exceeds(b, c, a) || exceeds(c, a, b) {
            MomentStatus::Triangle
        } else {
            MomentStatus::Possible
        }
    }

    /// A description of the status.
    pub fn name(self) -> &'static str {
        match self {
            MomentStatus::Possible => "possible",
            MomentStatus::NotFinite => "not finite",
            MomentStatus::NotPositive => "not positive",
            MomentStatus::Triangle => "triangle inequality broken",
        }
    }
}

/// Principal moments about the body axes 1, 2, 3, in the user's order: finite, positive, none above the sum of the
/// other two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia([f64; 3]);

impl Inertia {
    /// Checks that a distribution of mass with these moments exists.
    pub fn new(moments: [f64; 3]) -> Result<Self, Error> {
        let [a, b, c] = moments;
        match MomentStatus::of(moments) {
            MomentStatus::Possible => Ok(Inertia(moments)),
            MomentStatus::NotFinite => Err(Error::MomentNotFinite(a, b, c)),
            MomentStatus::NotPositive => Err(Error::MomentNotPositive(a, b, c)),
            MomentStatus::Triangle => Err(Error::MomentTriangle(a, b, c)),
        }
    }

    /// The three moments.
    pub fn moments(self) -> [f64; 3] {
        self.0
    }

    /// The axis (0, 1, 2) about which the body is dynamically symmetric: the other two moments are exactly equal.
    pub fn symmetry_axis(self) -> Option<usize> {
        (0..3).rev().find(|&k| self.0[(k + 1) % 3] == self.0[(k + 2) % 3])
    }
}

/// Principal moments (ascending) and axes (columns, right-handed) of a tensor of inertia.
///
/// Each axis but the last has its largest component positive, so that equal tensors give equal axes.
pub fn principal_axes(tensor: [[f64; 3]; 3]) -> Result<(Inertia, [[f64; 3]; 3]), Error> {
    let scale = tensor.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    for row in 0..3 {
        for column in 0..3 {
            let (value, mirror) = (tensor[row][column], tensor[column][row]);
            if !value.is_finite() || (value - mirror).abs() > 1e-12 * scale {
                return Err(Error::Tensor { row, column, value, mirror });
            }
        }
    }
    let matrix = Matrix3::from_fn(|i, j| tensor[i][j] + 0.5 * (tensor[j][i] - tensor[i][j]));
    let eigen = SymmetricEigen::new(matrix);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let [a, b, c] = order.map(|k| eigen.eigenvalues[k]);
    // The eigenvalues of a flat body are rounded, so an excess of a few ulp counts as equality.
    let c = if c - b > a && c - b <= a + EIGENVALUE_ROUNDING * c { a + b } else { c };
    let inertia = Inertia::new([a, b, c])?;
    let column = |k: usize| {
        let v = eigen.eigenvectors.column(order[k]).into_owned();
        if v[v.iamax()] < 0.0 { -v } else { v }
    };
    let (first, second) = (column(0), column(1));
    let third = first.cross(&second);
    let axes = [0, 1, 2].map(|row| [first[row], second[row], third[row]]);
    Ok((inertia, axes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_status_of_moments_names_the_first_rule_that_they_break() {
        let cases = [
            ([1.0, 2.0, 3.0], MomentStatus::Possible),
            // 0.1 + 0.2 is above 0.3 by an ulp: a flat body, rounded.
            ([0.1, 0.2, 0.1 + 0.2], MomentStatus::Possible),
            ([1.0, f64::NAN, -1.0], MomentStatus::NotFinite),
            ([1.0, 0.0, 5.0], MomentStatus::NotPositive),
            ([1.0, 1.0, 2.1], MomentStatus::Triangle),
            ([f64::MAX, f64::MAX, f64::MAX], MomentStatus::Possible),
        ];
        for (moments, status) in cases {
            assert_eq!(MomentStatus::of(moments), status, "{moments:?}");
            assert_eq!(Inertia::new(moments).is_ok(), status == MomentStatus::Possible);
        }
        for (code, status) in MomentStatus::ALL.into_iter().enumerate() {
            assert_eq!(status as usize, code);
        }
    }
}
