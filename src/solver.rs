//! The solver of a body: its closed form or a scheme.

use crate::error::Error;
use crate::scheme::Scheme;

/// The solver of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// The closed form.
    Exact,
    /// A scheme.
    Steps(&'static Scheme),
}

impl Solver {
    /// The name of the closed forms among the methods.
    pub const EXACT: &str = "exact";

    /// The solver of this name.
    pub fn parse(name: &str) -> Result<Solver, Error> {
        if name == Solver::EXACT { Ok(Solver::Exact) } else { Scheme::parse(name).map(Solver::Steps) }
    }
}

/// The default step of a scheme at a rate: the motion turns by the `angle_per_step` of the scheme. Infinite for a body
/// that does not turn.
pub fn default_step(scheme: &Scheme, rate: f64) -> f64 {
    scheme.facts.angle_per_step / rate
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme;

    #[test]
    fn solvers_have_names() {
        assert_eq!(Solver::parse("exact"), Ok(Solver::Exact));
        assert_eq!(Solver::parse("rk4"), Ok(Solver::Steps(&scheme::RK4)));
        assert!(Solver::parse("rk5").is_err());
    }

    #[test]
    fn a_default_step_turns_by_the_angle_of_its_scheme() {
        let angle = scheme::RK4.facts.angle_per_step;
        assert_eq!(default_step(&scheme::RK4, 4.0), angle / 4.0);
        assert_eq!(default_step(&scheme::RK4, 0.0), f64::INFINITY);
    }
}
