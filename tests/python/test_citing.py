"""Whatever was used can be cited."""

import re

import numpy as np
import pytest

import rigid
from physics import EVERY_METHOD
from small_maps import small_map

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
HEAVY = rigid.HeavyTop(rigid.Body((1.0, 1.4, 0.7)), mgl=1.0)
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.7)), mgl=1.0)
RATES = [0.1, 0.2, 2.0]


def keys(bibtex: str) -> list[str]:
    """The keys of the entries, each of which is well formed."""
    entries = bibtex.split("\n\n")
    for entry in entries:
        assert re.fullmatch(r"@(software|misc)\{[\w-]+,\n(  \w+ = \{.+\},\n)+\}", entry)
        assert entry.count("{") == entry.count("}")
    return [re.split("[{,]", entry)[1] for entry in entries]


@pytest.mark.parametrize("method", EVERY_METHOD, ids=lambda method: method.name)
def test_every_method_has_a_source(method: rigid.Method) -> None:
    assert keys(rigid.cite(method)) == ["rigid", f"rigid-{method.name}"]
    assert rigid.cite(method) == rigid.cite(method.name)
    assert method.citation in rigid.cite(method)
    assert method.doi in rigid.cite(method)
    # Kutta has none; that of the other could not be verified.
    assert method.doi.startswith("10.") or method.name in ("rk4", "pmlf6")


def test_growth_has_the_papers_of_its_indicators() -> None:
    growth = rigid.lyapunov(HEAVY, RATES, t=[5.0], check=False)
    assert keys(rigid.cite(growth)) == [
        "rigid",
        "rigid-taylor16",
        *(f"rigid-{name}" for name in ("lyapunov", "megno", "fli", "sali", "gali")),
    ]


def test_sections_and_frequencies_have_their_papers() -> None:
    points = rigid.poincare(HEAVY, RATES, t_end=5.0)
    assert keys(rigid.cite(points)) == [
        "rigid",
        "rigid-taylor20",
        *(f"rigid-{name}" for name in ("poincare", "henon", "complete", "descartes")),
    ]
    run = rigid.simulate(HEAVY, RATES, t=np.linspace(0.0, 20.0, 201))
    for used in (rigid.frequencies(run.t, run.omega[:, 0]), rigid.frequency_drift(run)):
        assert keys(rigid.cite(used)) == ["rigid", "rigid-naff", "rigid-frequency-map"]


def test_results_know_what_they_were_made_with() -> None:
    exact = rigid.simulate(FREE, RATES, t=[1.0])
    assert keys(rigid.cite(exact)) == ["rigid", "rigid-exact-jacobi"]
    assert "rigid-exact-klein" in rigid.cite(rigid.simulate(LAGRANGE, RATES, t=[1.0]))
    stepped = rigid.simulate(HEAVY, RATES, t=[1.0], method="dop853")
    assert keys(rigid.cite(stepped)) == ["rigid", "rigid-dop853"]
    assert rigid.cite(stepped) == rigid.cite(stepped.plan)
    assert keys(rigid.cite(small_map(method="rk4"))) == ["rigid", "rigid-rk4"]
    assert len(keys(rigid.cite("exact"))) == 4
    methods = ["rk4", "exact", "dop853"]
    report = rigid.report(FREE, RATES, t_end=0.1, methods=methods, bodies=1, seconds=0.1)
    cited = keys(rigid.cite(report))
    assert cited[:3] == ["rigid", "rigid-rk4", "rigid-dop853"]
    assert set(cited[3:]) == set(keys(rigid.cite("exact"))[1:])


def test_a_method_that_is_none() -> None:
    with pytest.raises(ValueError, match="used = 'rk5': must be a result, a plan, 'exact' or one"):
        rigid.cite("rk5")
