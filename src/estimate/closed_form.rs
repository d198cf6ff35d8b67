//! The error of a closed form.

use super::saddle::{magnified, separatrix};
use super::{REST, larger, swing};
use crate::body::Body;
use crate::forces::BodyForces;
use crate::simd::Isa;
use crate::special::ln;
use crate::trajectory::ROUNDING;

/// The error of a closed form between two times around 0, and the time from which on it is 1 or more: rounding for each
/// radian turned, or its growth at a saddle.
///
/// A top beside the separatrix of its nutation magnifies rounding by `exp(exponent t)`, at each passage of the saddle at most
/// by one over the relative distance from the separatrix. Rounding of the attitude moves a top that hangs all but still as
/// much as it would move any: of its small rates, `fastest` at most, it is a larger share.
pub fn error_of_closed_form(
    isa: Isa,
    body: &Body,
    forces: BodyForces,
    [first, last]: [f64; 2],
    fastest: f64,
) -> [f64; 2] {
    let rate = body.fastest_rate(forces, [first, last]);
    let (angle, reach) = (rate * (last - first), larger(-first, last));
    let mut error = ROUNDING * (1.0 + angle);
    let mut since = 1.0 / (ROUNDING * rate);
    if forces.is_none() && body.weight != [0.0; 3] {
        let scale = larger(rate, swing(body));
        let [distance, exponent] = separatrix(isa, body);
        let mut factor = magnified(exponent * reach, distance);
        let mut share = 1.0;
        if fastest > REST * scale {
            share = scale / fastest;
            factor *= (exponent / fastest).max(1.0);
        }
        error = ROUNDING * larger(share + angle, factor);
        since = since.min((-ln(ROUNDING)).max(distance / ROUNDING - 1.0) / exponent);
    }
    let lost = if error >= 1.0 { since.min(reach) } else { f64::INFINITY };
    [error, if -first > last && lost < f64::INFINITY { -lost } else { lost }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_errs_by_each_radian_turned_and_a_top_at_its_saddle_by_its_exponent() {
        let isa = Isa::current().unwrap();
        let omega = [0.0, 0.0, 3.0];
        let free = Body { moments: [1.0, 1.0, 0.5], weight: [0.0; 3], omega, attitude: [1.0, 0.0, 0.0, 0.0] };
        let error = |body: &Body, span| error_of_closed_form(isa, body, BodyForces::NONE, span, 3.0);
        assert_eq!(error(&free, [-1.0, 2.0]), [ROUNDING * 10.0, f64::INFINITY]);
        let [lost, from] = error(&free, [-1e16, 1.0]);
        assert!(lost > 1.0 && (from * 3.0 * ROUNDING + 1.0).abs() < 1e-12);
    }
}
