//! Elementary and elliptic functions over `Real`, and the inverse of the incomplete beta function, of our own: no libm in
//! any result path.

mod carlson;
mod elementary;
mod incomplete_beta;
mod jacobi;
pub mod theta;

pub use carlson::{agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj};
pub use elementary::{atan2, exp, exp_m1, ln, ln_1p, rodrigues, sincos, sincos_of_sum, sinhcosh};
pub use incomplete_beta::inverse_incomplete_beta;
pub use jacobi::{complete_k, jacobi};
