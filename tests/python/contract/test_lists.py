"""What must be named in several lists is named in all: forces, criteria and methods."""

import inspect
from pathlib import Path

import numpy as np
import pytest

import map_kinds
import rigid
from adversarial import KINDS
from rigid import _core
from rigid.maps import page
from rigid.model.criteria import CRITERIA
from rigid.model.criterion import Criterion
from rigid.model.forces import FORCES
from rigid.model.parameters import PARAMETERS, PLACES
from rigid.reports.plot import FAMILIES

DOCS = Path(__file__).parents[3] / "docs"


def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", FORCES)
def test_a_force_is_a_force_everywhere(name: str) -> None:
    """A list that does not know a force would leave it out of a motion, in silence."""
    core, _ = _core.change_places()
    assert name in inspect.signature(rigid.FreeBody).parameters
    assert f"\n    {name} : " in (rigid.FreeBody.__doc__ or "")
    assert any(name in method.forces for method in rigid.methods())
    assert PLACES[name].first == core[name]
    assert [row for row in PARAMETERS.values() if row.place == name]
    assert f"{name}=" in text(DOCS / "forces.md")


def test_films_of_maps_move_under_every_force() -> None:
    scene = rigid.FreeBody(
        rigid.Body((1.0, 2.0, 2.5)),
        orbit=rigid.Orbit(1.0),
        rotor=(0.0, 0.0, 0.1),
        drag=0.1,
        dissipation=rigid.EnergySink(0.1),
    )
    numbers = scene.further_numbers()
    assert numbers.keys() == FORCES.keys()
    assert {name: np.size(array) for name, array in numbers.items()} == page._FURTHER


def test_hard_runs_are_made_under_every_force() -> None:
    rng = np.random.default_rng(1)
    met = {name for _, make in KINDS.values() for name in make(rng).scene.forces}
    assert met >= FORCES.keys()


@pytest.mark.parametrize("name", CRITERIA)
def test_a_criterion_is_a_criterion_everywhere(name: str) -> None:
    assert callable(getattr(rigid, name))
    assert f"   {name}\n" in text(DOCS / "api" / "rigid.rst")
    assert name in text(DOCS / "maps.md")
    asked = (request.get("stable") for request, _ in map_kinds.KINDS.values())
    leaves = [leaf for one in asked if isinstance(one, Criterion) for leaf in one.leaves]
    assert any(type(leaf) is CRITERIA[name] for leaf in leaves)


def test_every_method_has_a_family_in_pictures_and_a_line_in_the_guide() -> None:
    known = [method.name for method in rigid.methods()]
    described = text(DOCS / "methods.md")
    assert {name for family in FAMILIES for name in family.members} == {*known, "exact"}
    assert [name for name in known if name not in described] == []
