//! Principal moments that a real body can have, and principal axes.

use crate::error::Error;
use crate::named::named;
use nalgebra::{Matrix3, SymmetricEigen};

/// Relative slack of the triangle inequality: the moments of a flat body, rounded to doubles, may break the inequality
/// by this much.
const FLATNESS: f64 = 4.0 * f64::EPSILON;

/// Relative error of an eigenvalue of a tensor of inertia.
const EIGENVALUE_ROUNDING: f64 = 16.0 * f64::EPSILON;

named! {
    /// Whether three principal moments are possible, or the first rule that they break.
    pub enum MomentStatus {
        /// A rigid body with these moments exists.
        Possible => "possible",
        /// A moment is NaN or infinite.
        NotFinite => "not finite",
        /// A moment is zero or negative.
        NotPositive => "not positive",
        /// A moment exceeds the sum of the other two by more than the rounding of a flat body.
        Triangle => "triangle inequality broken",
    }
}

impl MomentStatus {
    /// The status of three moments; those that are not `physical` may break the triangle inequality.
    pub fn of(moments: [f64; 3], physical: bool) -> MomentStatus {
        let [a, b, c] = moments;
        // A difference, because the sum of two huge moments could overflow and the half of a subnormal moment rounds.
        let exceeds = |big: f64, x: f64, y: f64| big - x > y + FLATNESS * big;
        if moments.iter().any(|m| !m.is_finite()) {
            MomentStatus::NotFinite
        } else if moments.iter().any(|&m| m <= 0.0) {
            MomentStatus::NotPositive
        } else if physical && (exceeds(a, b, c) || exceeds(b, c, a) || exceeds(c, a, b)) {
            MomentStatus::Triangle
        } else {
            MomentStatus::Possible
        }
    }
}

/// The least and the largest moment.
pub fn moment_range(moments: [f64; 3]) -> [f64; 2] {
    moments.iter().fold([f64::INFINITY, 0.0], |[least, largest], &b| [least.min(b), largest.max(b)])
}

/// By how much the largest moment exceeds the sum of the other two, as a share of the moment of largest size; not
/// positive for possible moments.
pub fn excess(moments: [f64; 3]) -> f64 {
    let [small, middle, large] = ascending(moments).map(|k| moments[k]);
    ((large - middle) - small) / large.abs().max(small.abs())
}

/// The possible moments whose distance to impossible ones, as points of space, is least: those of a flat body.
///
/// An excess e leaves the half-space c <= a + b along its normal (1, 1, -1): a + e/3, b + e/3, c - e/3, in which the
/// order is kept. If the least moment is still negative, the nearest point is on the edge of two half-spaces, a rod:
/// 0, m, m with the mean m of the other two.
pub fn nearest_possible(moments: [f64; 3]) -> [f64; 3] {
    let [small, middle, large] = ascending(moments);
    let third = ((moments[large] - moments[middle]) - moments[small]) / 3.0;
    let mut nearest = moments;
    if moments[small] + third >= 0.0 {
        nearest[small] += third;
        nearest[middle] += third;
        nearest[large] = nearest[small] + nearest[middle];
    } else {
        nearest[small] = 0.0;
        nearest[middle] += 0.5 * (moments[large] - moments[middle]);
        nearest[large] = nearest[middle];
    }
    nearest
}

/// The axes in the order of their moments; of equal moments the first is first.
fn ascending(moments: [f64; 3]) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| moments[i].total_cmp(&moments[j]));
    order
}

/// Checks that a distribution of mass with these principal moments exists: finite, positive, none above the sum of the
/// other two.
///
/// # Errors
/// Naming the moments and the rule.
pub fn check_moments(moments: [f64; 3]) -> Result<(), Error> {
    let [a, b, c] = moments;
    match MomentStatus::of(moments, true) {
        MomentStatus::Possible => Ok(()),
        MomentStatus::NotFinite => Err(Error::MomentNotFinite(a, b, c)),
        MomentStatus::NotPositive => Err(Error::MomentNotPositive(a, b, c)),
        MomentStatus::Triangle => {
            let (nearest, excess) = (nearest_possible(moments), excess(moments));
            Err(Error::MomentTriangle { moments, nearest, excess })
        }
    }
}

/// Principal moments (ascending, possible or not) and axes (columns, right-handed) of a symmetric matrix.
///
/// Each axis but the last has its largest component positive, so that equal tensors give equal axes.
pub fn principal_axes(tensor: [[f64; 3]; 3]) -> Result<([f64; 3], [[f64; 3]; 3]), Error> {
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
    // So are those of a rod, whose moment about its axis is zero.
    let rounding = EIGENVALUE_ROUNDING * c;
    let is_rod = c > 0.0 && a.abs() <= rounding && c - b <= rounding;
    let [a, b] = if is_rod { [0.0, c] } else { [a, b] };
    let column = |k: usize| {
        let v = eigen.eigenvectors.column(order[k]).into_owned();
        if v[v.iamax()] < 0.0 { -v } else { v }
    };
    let (first, second) = (column(0), column(1));
    let third = first.cross(&second);
    let axes = [0, 1, 2].map(|row| [first[row], second[row], third[row]]);
    Ok(([a, b, c], axes))
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
            assert_eq!(MomentStatus::of(moments, true), status, "{moments:?}");
            assert_eq!(check_moments(moments).is_ok(), status == MomentStatus::Possible);
        }
    }
}
