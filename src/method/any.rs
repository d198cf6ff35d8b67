//! The choice of a method: left to each sample of a map, the closed form, or one that makes steps.

use super::Method;
use crate::body::Body;
use crate::error::Error;
use crate::forces::BodyForces;

/// The method of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnyMethod {
    /// Of a map: the closed form of each sample that has one, else the default method.
    Auto,
    /// The closed form; a body without one is refused.
    Exact,
    /// A method that makes steps.
    Steps(&'static Method),
}

impl AnyMethod {
    /// The name that leaves the choice to each sample.
    pub const AUTO: &str = "auto";

    /// The name of the closed forms among the methods.
    pub const EXACT: &str = "exact";

    /// The method of this name.
    pub fn parse(name: &str) -> Result<AnyMethod, Error> {
        match name {
            AnyMethod::AUTO => Ok(AnyMethod::Auto),
            AnyMethod::EXACT => Ok(AnyMethod::Exact),
            _ => Method::parse(name).map(AnyMethod::Steps),
        }
    }
}

impl Body {
    /// The rate that determines the steps of a method: the fastest rate of the body, and the fastest damping rate if
    /// the method is stable only for short steps.
    pub fn step_rate(&self, method: &Method, forces: BodyForces, span: [f64; 2]) -> f64 {
        let turning = self.fastest_rate(forces, span);
        if forces.is_none() || method.is_stiff() {
            return turning;
        }
        let [.., slowing] = forces.damping.rates(self.moments);
        let own = forces.further_step_rate(self.moments, self.omega, turning);
        (turning * turning + slowing * slowing).sqrt() + own
    }
}

/// The default step of a method at a rate: the motion turns by the `angle_per_step` of the method. Infinite for a body
/// that does not turn.
pub fn default_step(method: &Method, rate: f64) -> f64 {
    method.facts.angle_per_step / rate
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method;

    #[test]
    fn methods_have_names() {
        assert_eq!(AnyMethod::parse("auto"), Ok(AnyMethod::Auto));
        assert_eq!(AnyMethod::parse("exact"), Ok(AnyMethod::Exact));
        assert_eq!(AnyMethod::parse("rk4"), Ok(AnyMethod::Steps(&method::RK4)));
        assert!(AnyMethod::parse("rk5").is_err());
    }

    #[test]
    fn a_default_step_turns_by_the_angle_of_its_method() {
        let angle = method::RK4.facts.angle_per_step;
        assert_eq!(default_step(&method::RK4, 4.0), angle / 4.0);
        assert_eq!(default_step(&method::RK4, 0.0), f64::INFINITY);
    }
}
