//! `Inertia`: principal moments that a real body can have.

use crate::error::Error;
use nalgebra::{Matrix3, SymmetricEigen};

/// Relative slack of the triangle inequality: moments of a flat body, rounded to doubles, may break it by this much.
const FLATNESS: f64 = 4.0 * f64::EPSILON;

/// Relative error of an eigenvalue of a tensor of inertia.
const EIGENVALUE_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Principal moments about the body axes 1, 2, 3, in the user's order: finite, positive, no one above the
/// sum of the other two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia([f64; 3]);

impl Inertia {
    /// Checks the moments against the physics of a distribution of mass.
    pub fn new(moments: [f64; 3]) -> Result<Self, Error> {
        let [a, b, c] = moments;
        if moments.iter().any(|m| !m.is_finite()) {
            return Err(Error::MomentNotFinite(a, b, c));
        }
        if moments.iter().any(|&m| m <= 0.0) {
            return Err(Error::MomentNotPositive(a, b, c));
        }
        // As a difference: the sum of two huge moments could overflow, the half of a subnormal one rounds.
        let exceeds = |big: f64, x: f64, y: f64| big - x > y + FLATNESS * big;
        if exceeds(a, b, c) || exceeds(b, c, a) || exceeds(c, a, b) {
            return Err(Error::MomentTriangle(a, b, c));
        }
        Ok(Inertia(moments))
    }

    /// The three moments.
    pub fn moments(self) -> [f64; 3] {
        self.0
    }

    /// The axis (0, 1, 2) about which the body is dynamically symmetric: the other two moments are equal to the bit.
    pub fn symmetry_axis(self) -> Option<usize> {
        (0..3).rev().find(|&k| self.0[(k + 1) % 3] == self.0[(k + 2) % 3])
    }
}

/// Principal moments (ascending) and axes (columns, right-handed) of a tensor of inertia.
///
/// Each axis but the last has its largest component positive, so that the same tensor gives the same axes.
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
    // The eigenvalues of a flat body are rounded: an excess of some ulp is taken for equality.
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
