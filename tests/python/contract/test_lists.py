"""What must be named in several lists is named in all: forces, criteria and methods."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import map_kinds
import rigid
from adversarial import KINDS
from rigid.maps import page
from rigid.model.criterion import CRITERIA, Criterion
from rigid.model.forces import FORCES
from rigid.model.parameters import PARAMETERS, PLACES

DOCS = Path(__file__).parents[3] / "docs"


def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", FORCES)
def test_a_force_is_a_force_everywhere(name: str) -> None:
    """A list that does not know a force would leave it out of a motion, in silence."""
    assert name in inspect.signature(rigid.FreeBody).parameters
    assert f"\n    {name} : " in (rigid.FreeBody.__doc__ or "")
    assert any(name in method.forces for method in rigid.methods())
    assert PLACES[name].first == FORCES[name].first
    assert [row for row in PARAMETERS.values() if row.place == name]
    assert f"{name}=" in text(DOCS / "forces.md")


def test_films_of_maps_move_under_every_force() -> None:
    """A row of numbers is read as it is written: the lists of both languages agree."""
    further = ", ".join(f"{name}: {force.width}" for name, force in FORCES.items())
    assert f", {further}}};" in text(Path(page.__file__).parents[1] / "animation/page/motion.js")


def test_hard_runs_are_made_under_every_force() -> None:
    rng = np.random.default_rng(1)
    met = {name for _, make in KINDS.values() for name in make(rng).scene.forces}
    assert met >= FORCES.keys()


@pytest.mark.parametrize("name", CRITERIA)
def test_a_criterion_is_a_criterion_everywhere(name: str) -> None:
    assert getattr(rigid, name).__doc__.startswith("Stable: ")  # for the table of the guide
    asked = (request.get("stable") for request, _ in map_kinds.KINDS.values())
    leaves = [leaf for one in asked if isinstance(one, Criterion) for leaf in one.leaves]
    assert any(type(leaf) is CRITERIA[name] for leaf in leaves)


def test_every_method_has_a_line_in_the_guide() -> None:
    known = [method.name for method in rigid.methods()]
    described = text(DOCS / "methods.md")
    assert [name for name in known if name not in described] == []
