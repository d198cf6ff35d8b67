//! Elementary and elliptic functions over `Real`, of our own: no libm in any result path.

mod carlson;
mod elementary;
mod jacobi;
#[cfg(test)]
mod same_bits;
pub mod theta;

pub use carlson::{agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj};
pub use elementary::{atan2, exp, ln, rodrigues, sincos, sincos_of_sum};
pub use jacobi::{complete_e, complete_k, complete_pi, jacobi};
