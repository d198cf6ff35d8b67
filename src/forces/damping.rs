//! Linear damping: the torque `-D omega`.

use crate::error::{Error, refuse};
use crate::real::Real;

/// Entries 11, 22, 33, 23, 31, 12 of the matrix `D`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping(pub [f64; 6]);

/// The eigenvalues of `I^(-1/2) D I^(-1/2)`, and its eigenvectors as columns.
pub type Modes = ([f64; 3], [[f64; 3]; 3]);

/// Subtracts a damping matrix times `omega` from `sum`.
#[inline(always)]
pub fn damp<R: Real>(matrix: &[R; 6], [w1, w2, w3]: [R; 3], sum: &mut [R; 3]) {
    let [d11, d22, d33, d23, d31, d12] = *matrix;
    *sum = [
        d31.fnma(w3, d12.fnma(w2, d11.fnma(w1, sum[0]))),
        d23.fnma(w3, d22.fnma(w2, d12.fnma(w1, sum[1]))),
        d33.fnma(w3, d23.fnma(w2, d31.fnma(w1, sum[2]))),
    ];
}

impl Damping {
    /// No damping.
    pub const NONE: Damping = Damping([0.0; 6]);

    /// Refuses a matrix that is not finite, or by which damping would add energy.
    ///
    /// # Errors
    /// Naming the matrix and the rule.
    pub fn check(&self) -> Result<(), Error> {
        if !self.0.iter().all(|x| x.is_finite()) {
            return refuse("damping", format_args!("{:?}", self.0), "must be finite");
        }
        let [least, .., largest] = self.rates([1.0; 3]);
        // The error of an eigenvalue is a few roundings of the largest one.
        if least < -8.0 * f64::EPSILON * largest.abs().max(least.abs()) {
            let rule = "must be positive semi-definite, so that damping cannot add energy";
            return refuse("damping", format_args!("{:?}", self.matrix()), rule);
        }
        Ok(())
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.0 == [0.0; 6]
    }

    /// The matrix `D`.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        let [d11, d22, d33, d23, d31, d12] = self.0;
        [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]]
    }

    /// Refuses damping that slows a body with these moments at a rate beyond the doubles.
    ///
    /// # Errors
    /// Naming the rate.
    pub fn check_rates(&self, moments: [f64; 3]) -> Result<(), Error> {
        // No eigenvalue is negative, so none exceeds the trace. A rod has no moment about its axis.
        let trace: f64 = (0..3).filter(|&k| self.0[k] > 0.0).map(|k| self.0[k] / moments[k]).sum();
        if trace.is_finite() {
            return Ok(());
        }
        let rule = "damping over moment must be below 1.8e308 1/s";
        refuse("damping", format_args!("a rate of {trace} 1/s"), rule)
    }

    /// Damping rates of a body with these moments without torque, ascending: the eigenvalues of `I^(-1/2) D I^(-1/2)`.
    pub fn rates(&self, moments: [f64; 3]) -> [f64; 3] {
        let (mut rates, _) = self.modes(moments);
        rates.sort_by(f64::total_cmp);
        rates
    }

    /// The modes of a body with these moments.
    pub fn modes(&self, moments: [f64; 3]) -> Modes {
        if self.is_none() {
            return eigen([[0.0; 3]; 3]);
        }
        let mut scaled = self.matrix();
        for i in 0..3 {
            for k in 0..3 {
                // The root of a square would be rounded.
                scaled[i][k] /= if i == k { moments[i] } else { moments[i].sqrt() * moments[k].sqrt() };
            }
        }
        eigen(scaled)
    }

    /// The rate k, if `D = k I`, equal to within the rounding of the products.
    pub fn slows_evenly(&self, moments: [f64; 3]) -> Option<f64> {
        let [d11, d22, d33, ..] = self.0;
        let diagonal = self.0[3..].iter().all(|&x| x == 0.0);
        let own = [d11, d22, d33];
        let fits = |&k: &f64| (0..3).all(|i| k * moments[i] == own[i]);
        (0..3).map(|i| own[i] / moments[i]).find(fits).filter(|_| diagonal)
    }
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by plane rotations (Jacobi 1846). Only arithmetic
/// and roots are used, so that the bits are equal on all machines.
fn eigen(mut a: [[f64; 3]; 3]) -> Modes {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Convergence is quadratic: the off-diagonal part of any matrix vanishes after five or six sweeps.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            // The smaller root of t^2 + 2 tau t = 1; it is zero if the square of tau overflows.
            let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
            let cos = 1.0 / (1.0 + t * t).sqrt();
            let sin = t * cos;
            let (app, aqq, apq) = (a[p][p], a[q][q], a[p][q]);
            let r = 3 - p - q;
            let (apr, aqr) = (a[p][r], a[q][r]);
            a[p][p] = app - t * apq;
            a[q][q] = aqq + t * apq;
            (a[p][q], a[q][p]) = (0.0, 0.0);
            a[p][r] = cos * apr - sin * aqr;
            a[q][r] = sin * apr + cos * aqr;
            (a[r][p], a[r][q]) = (a[p][r], a[q][r]);
            for row in &mut vectors {
                let (vp, vq) = (row[p], row[q]);
                row[p] = cos * vp - sin * vq;
                row[q] = sin * vp + cos * vq;
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], vectors)
}
