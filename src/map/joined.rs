//! Conditions joined by logic. Each holds or fails over the whole horizon, alone; the logic joins the verdicts.
//!
//! A condition is kept until a time if it was not left before. `a & b`: both are kept until the horizon; `a | b`: at
//! least one of them is, the same one all the time; `~a`: it was left. What is not known of one condition has no effect
//! where the others decide (S. C. Kleene, Introduction to Metamathematics, 1952, § 64).

use super::statistics::Sample;
use super::{Class, Criterion, Outcome, Verdict};
use crate::error::{Error, refuse};
use crate::status::Status;

/// What is observed of a sample, and of which body axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// When the condition is kept.
    pub criterion: Criterion,
    /// The observed body axis: 1, 2, 3 or -1, -2, -3; 0 if the criterion observes none.
    pub axis: i32,
}

/// Most conditions of a map, and most operations of a logic.
pub const MOST_CONDITIONS: usize = 16;
const MOST_OPERATIONS: usize = 4 * MOST_CONDITIONS;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    Condition(u8),
    And,
    Or,
    Not,
}

/// The logic that joins conditions, in postfix notation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logic(Vec<Operation>);

impl Logic {
    /// Whether it is that of a single condition.
    #[inline(always)]
    pub(super) fn is_single(&self) -> bool {
        matches!(self.0[..], [Operation::Condition(_)])
    }

    /// The logic of a text such as `0 1 & ~`: numbers of conditions, and the operations that follow their operands.
    ///
    /// # Errors
    /// If the text is no logic of that many conditions, each of which occurs.
    pub fn parse(text: &str, conditions: usize) -> Result<Logic, Error> {
        let refuse = |rule| refuse("logic", format_args!("'{text}'"), rule);
        if !(1..=MOST_CONDITIONS).contains(&conditions) {
            return refuse("must join 1 to 16 conditions");
        }
        let (mut operations, mut depth, mut seen) = (Vec::new(), 0_usize, 0_u32);
        for word in text.split(' ') {
            if operations.len() == MOST_OPERATIONS {
                return refuse("must have at most 64 words");
            }
            let (operation, operands) = match (word, word.parse::<u8>()) {
                ("&", _) => (Operation::And, 2),
                ("|", _) => (Operation::Or, 2),
                ("~", _) => (Operation::Not, 1),
                (_, Ok(number)) if usize::from(number) < conditions => {
                    seen |= 1 << number;
                    (Operation::Condition(number), 0)
                }
                _ => return refuse("must consist of numbers of conditions, &, | and ~"),
            };
            if depth < operands {
                return refuse("must have the operands before each operation");
            }
            depth = depth - operands + 1;
            operations.push(operation);
        }
        if depth != 1 || seen.count_ones() as usize != conditions {
            return refuse("must join all conditions to one");
        }
        Ok(Logic(operations))
    }

    /// Whether the joined conditions hold, from whether each does; `None` where that is not known.
    fn holds(&self, each: impl Fn(usize) -> Option<bool>) -> Option<bool> {
        let (mut stack, mut depth) = ([None; MOST_OPERATIONS], 0);
        for operation in &self.0 {
            let (value, operands) = match *operation {
                Operation::Condition(number) => (each(number.into()), 0),
                Operation::Not => (stack[depth - 1].map(|value: bool| !value), 1),
                Operation::And => (both(stack[depth - 2], stack[depth - 1]), 2),
                Operation::Or => {
                    let [one, other] =
                        [stack[depth - 2], stack[depth - 1]].map(|value| value.map(|v: bool| !v));
                    (both(one, other).map(|value| !value), 2)
                }
            };
            depth = depth - operands + 1;
            stack[depth - 1] = value;
        }
        stack[0]
    }

    /// The last time at which the joined conditions turned from kept to left, from the times at which each was left;
    /// infinite if they did not. Conditions that are not known to be left count as kept.
    fn left(&self, times: &[f64]) -> f64 {
        let kept_after = |now: f64| self.holds(|number| Some(!(times[number] <= now))) == Some(true);
        let (mut last, mut now) = (f64::INFINITY, f64::NEG_INFINITY);
        // A condition that was left at once was never kept.
        let mut was_kept = self.holds(|_| Some(true)) == Some(true);
        while let Some(next) = times.iter().copied().filter(|&time| time > now).reduce(f64::min) {
            if next == f64::INFINITY {
                break;
            }
            now = next;
            let is_kept = kept_after(now);
            if was_kept && !is_kept {
                last = now;
            }
            was_kept = is_kept;
        }
        last
    }

    /// The class and the outcome of a sample from those of its conditions, by both methods.
    pub(super) fn joined(&self, samples: &[Sample]) -> Verdict {
        let holds = self.holds(|number| match samples[number].class {
            Class::Stable => Some(true),
            Class::Unstable => Some(false),
            Class::Undecided | Class::Failed => None,
        });
        let failed = samples.iter().find(|sample| sample.class == Class::Failed);
        let class = match (holds, failed) {
            (Some(true), _) => Class::Stable,
            (Some(false), _) => Class::Unstable,
            (None, Some(_)) => Class::Failed,
            (None, None) => Class::Undecided,
        };
        let mut times = [f64::INFINITY; MOST_CONDITIONS];
        for (time, sample) in times.iter_mut().zip(samples) {
            *time = sample.first.left;
        }
        let left = self.left(&times[..samples.len()]);
        let status = match (class, failed) {
            (Class::Failed, Some(sample)) => sample.first.status,
            _ if left < f64::INFINITY => Status::Stopped,
            _ => Status::Finished,
        };
        let mut first = *samples[0].first;
        for other in samples[1..].iter().map(|sample| sample.first) {
            first = first.with(other);
        }
        // Those that would take too many steps have no part in what is known.
        let mut ran = samples.iter().filter(|sample| sample.first.was_run()).peekable();
        first.exact = ran.peek().is_some() && ran.all(|sample| sample.first.exact);
        let second =
            samples.iter().filter_map(|sample| sample.second).copied().reduce(|one, other| one.with(&other));
        for (time, sample) in times.iter_mut().zip(samples) {
            *time = sample.second.filter(|second| second.was_run()).map_or(*time, |second| second.left);
        }
        let left_again = self.left(&times[..samples.len()]);
        let second = second.map(|second| Outcome { left: left_again, ..second });
        let audited = samples.iter().any(|sample| sample.audited);
        Verdict { class, first: Outcome { class, status, left, ..first }, second, audited }
    }
}

impl Outcome {
    /// The numbers of two runs of one sample together: those that only one run has, the larger drift and step, and all
    /// steps.
    fn with(self, other: &Outcome) -> Outcome {
        // `max` ignores a NaN.
        Outcome {
            status: if self.was_run() { self.status } else { other.status },
            flips: self.flips.max(other.flips),
            tilt: self.tilt.max(other.tilt),
            exponent: self.exponent.max(other.exponent),
            mean_megno: self.mean_megno.max(other.mean_megno),
            energy_drift: self.energy_drift.max(other.energy_drift),
            momentum_drift: self.momentum_drift.max(other.momentum_drift),
            unit_drift: self.unit_drift.max(other.unit_drift),
            step: self.step.max(other.step),
            steps: self.steps + other.steps,
            ..self
        }
    }
}

fn both(one: Option<bool>, other: Option<bool>) -> Option<bool> {
    match (one, other) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEVER: f64 = f64::INFINITY;

    #[test]
    fn a_logic_is_read_or_refused() {
        assert_eq!(Logic::parse("0", 1), Ok(Logic(vec![Operation::Condition(0)])));
        for (text, conditions, words) in [
            ("0", 2, "must join all conditions to one"),
            ("0 1", 2, "must join all conditions to one"),
            ("0 &", 1, "must have the operands before each operation"),
            ("0 2 &", 2, "must consist of numbers"),
            ("", 1, "must consist of numbers"),
            ("0", 0, "must join 1 to 16 conditions"),
            (&"0 ".repeat(65), 1, "must have at most 64 words"),
        ] {
            let message = Logic::parse(text, conditions).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }

    #[test]
    fn an_unknown_condition_has_no_effect_where_the_others_decide() {
        let of = |text, values: [Option<bool>; 2]| Logic::parse(text, 2).unwrap().holds(|k| values[k]);
        let values = [None, Some(false), Some(true)];
        for one in values {
            for other in values {
                let (and, or) = (of("0 1 &", [one, other]), of("0 1 |", [one, other]));
                let none = |value: Option<bool>| -> f64 {
                    if value == Some(true) { 1.0 } else { value.map_or(0.5, |_| 0.0) }
                };
                assert_eq!(none(and), none(one).min(none(other)), "{one:?} & {other:?}");
                assert_eq!(none(or), none(one).max(none(other)), "{one:?} | {other:?}");
                assert_eq!(of("0 1 & ~", [one, other]), and.map(|value| !value));
            }
        }
    }

    #[test]
    fn conditions_joined_are_left_when_their_logic_turns_for_the_last_time() {
        for (text, times, expected) in [
            ("0 1 &", [3.0, 2.0], 2.0),
            ("0 1 |", [3.0, 2.0], 3.0),
            ("0 1 |", [NEVER, 2.0], NEVER),
            // Never kept, or kept from the time on at which the other was left.
            ("0 ~ 1 &", [NEVER, 2.0], NEVER),
            ("0 ~ 1 &", [1.0, 2.0], 2.0),
            ("0 ~ 1 &", [2.0, 1.0], NEVER),
            ("0 1 ~ &", [2.0, 1.0], 2.0),
            ("0 ~ 1 |", [1.0, 0.5], 0.5),
            ("0 1 &", [0.0, NEVER], 0.0),
        ] {
            assert_eq!(Logic::parse(text, 2).unwrap().left(&times), expected, "{text} {times:?}");
        }
    }
}
