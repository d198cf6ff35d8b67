"""Mutants of Python that compute the same, so that no test can kill them, each with its reason."""

import re

from python_mutants import Mutant

#: Beginning of the module in `python/rigid`, a pattern of what is changed, and why nobody can tell.
EQUIVALENT: tuple[tuple[str, str, str], ...] = ()


def why_equivalent(mutant: Mutant) -> str | None:
    """Why a mutant computes the same; None if it does not."""
    inside = mutant.path.removeprefix("python/rigid/")
    found = (
        reason
        for module, pattern, reason in EQUIVALENT
        if inside.startswith(module) and re.fullmatch(pattern, mutant.change)
    )
    return next(found, None)
