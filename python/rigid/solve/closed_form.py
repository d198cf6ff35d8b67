"""The rule which bodies have a closed form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arrays import Floats
from ..model.bodies import lagrange_axes
from ..model.criterion import Criterion, Joined
from ..model.scene import Scene

Codes: TypeAlias = NDArray[np.uint8]
"""The closed forms of bodies, by their codes."""

Question: TypeAlias = str | Criterion

NO_FORM = 0
"""The code of a body without a closed form."""

_NAMES = _core.closed_form_names()

RECORDS: Mapping[str, str] = {
    "rates": "rates at output times",
    "axis": "rates and vertical at output times",
    "attitude": "rates and attitude at output times",
}
"""The states that a run can record, in words."""

_STATES_RULE = (
    "closed forms are known of a free body, of a top with two exactly equal moments and its "
    "centre of mass on the third axis, and of a top that swings about a principal axis"
)

FORCED_RULE = (
    "under forces a closed form is known only of a free body whose damping is a multiple of its "
    "inertia"
)

_CLASS_RULE = (
    "closed forms are known of no_flip and regular of a free body, and of tilt_below(axis=±k, "
    "reference='vertical'), no_flip(k) and regular of a top with two exactly equal moments and "
    "its centre of mass on the third axis k"
)


def closed_forms(question: Question, moments: Floats, weight: Floats) -> Codes:
    """The code of the closed form that applies to the question from any start; shape (n,).

    Parameters
    ----------
    question : str or Criterion
    moments, weight : ndarray, shape (n, 3) or (1, 3)
    """
    if isinstance(question, Joined):
        each = [closed_forms(leaf, moments, weight) for leaf in question.leaves]
        return np.where(np.all(each, axis=0), each[0], np.uint8(NO_FORM))
    asked = ("states", None) if isinstance(question, str) else question.closed_form_question()
    if asked is None:
        return np.full(len(moments), NO_FORM, dtype=np.uint8)
    name, axis = asked
    rows = np.ascontiguousarray(moments), np.ascontiguousarray(weight)
    return _core.closed_forms_for(name, *rows, axis)


def question_words(question: Question) -> str:
    """The question in words."""
    return RECORDS[question] if isinstance(question, str) else str(question)


def rule(question: Question) -> str:
    """The rule, in words, which bodies have a closed form for the question."""
    asked = "states" if isinstance(question, str) else (question.closed_form_question() or ("",))[0]
    return _STATES_RULE if asked == "states" else _CLASS_RULE


def names(forms: Codes) -> list[str]:
    """The names of the closed forms that occur, sorted."""
    if len(forms) == 1:
        return [_NAMES[forms[0]]] if forms[0] != NO_FORM else []
    codes = set(np.flatnonzero(np.bincount(forms)).tolist())
    return sorted(_NAMES[code] for code in codes - {NO_FORM})


def all_have(forms: Codes) -> bool:
    """Whether all bodies have a closed form; faster than a reduction."""
    return bool(np.count_nonzero(forms) == len(forms))


def why_not(question: Question, moments: Floats, weight: Floats) -> str:
    """The reason why this body has no closed form."""
    axis = int(lagrange_axes(moments[np.newaxis], weight[np.newaxis])[0])
    if axis or not weight.any():
        symmetry = f": the symmetry axis is {axis}" if axis else ""
        return f"no closed form of {question_words(question)}{symmetry}"
    reasons = {
        1: "the centre of mass is on no principal axis",
        2: "the centre of mass is not on the symmetry axis",
        3: "no two moments of the top are exactly equal",
    }
    return f"no closed form: {reasons[len(set(moments.tolist()))]}"


def are_slowed_evenly(scene: Scene, forces: _core.Forces, moments: Floats) -> NDArray[np.bool_]:
    """Whether nothing acts on a body but damping that is a multiple of its inertia.

    The body then moves as without damping, but ever slower. Shape (n,), or (1,) if all are alike.
    """
    if scene.directions:
        return np.zeros(1, dtype=bool)
    return ~np.isnan(forces.slows_evenly(moments))
