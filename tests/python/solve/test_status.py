"""The status of a body: one list of codes, that of the core."""

from __future__ import annotations

from rigid import Status, _core


def test_codes_are_those_of_the_core() -> None:
    """Python adds the codes of an error estimate, which the core does not make."""
    core = {name.upper().replace(" ", "_"): code for code, name in enumerate(_core.status_names())}
    python = {name: int(status) for name, status in Status.__members__.items()}
    assert core.items() <= python.items()
    assert python.keys() - core.keys() == {"OK", "FLAGGED", "UNCHECKED", "COARSE"}
    assert Status["OK"] is Status["FINISHED"]
