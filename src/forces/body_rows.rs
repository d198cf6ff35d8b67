//! Rows of values of bodies: a row for each body, or one that serves all.

use crate::error::Error;
use crate::memory;

/// Rows of equal length, one after another.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BodyRows<T> {
    pub(super) values: Vec<T>,
    /// The length of a row.
    pub(super) width: usize,
}

impl<T: Copy> BodyRows<T> {
    /// No rows.
    pub(super) const NONE: BodyRows<T> = BodyRows { values: Vec::new(), width: 1 };

    /// Rows of so many values.
    pub(super) fn of_width(values: Vec<T>, width: usize) -> Self {
        BodyRows { values, width }
    }

    /// The number of rows.
    pub(super) fn len(&self) -> usize {
        self.values.len().checked_div(self.width).unwrap_or(0)
    }

    /// Whether all values are in a row.
    pub(super) fn are_whole(&self) -> bool {
        self.values.len() == self.len() * self.width
    }

    /// The row of a body; empty if there are no rows.
    pub(super) fn of(&self, body: usize) -> &[T] {
        if self.values.is_empty() {
            return &[];
        }
        let first = if self.values.len() > self.width { self.width * body } else { 0 };
        &self.values[first..][..self.width]
    }

    /// Copies of the rows of some bodies, in this order, or of all; a row that serves all stays.
    ///
    /// # Errors
    /// If they do not fit into memory.
    pub(super) fn of_some(&self, what: &str, bodies: Option<&[usize]>) -> Result<Self, Error> {
        let values = match bodies {
            Some(bodies) if self.len() > 1 => {
                let rows = bodies.iter().flat_map(|&body| self.of(body).iter().copied());
                memory::collected(what, self.width * bodies.len(), rows)?
            }
            _ => copied(what, &self.values)?,
        };
        Ok(BodyRows { values, width: self.width })
    }
}

/// A copy of values.
///
/// # Errors
/// If they do not fit into memory.
pub(super) fn copied<T: Copy>(what: &str, all: &[T]) -> Result<Vec<T>, Error> {
    memory::collected(what, all.len(), all.iter().copied())
}
