"""Scenes, runs and parts of films for the tests of animations."""

from typing import Any

import numpy as np

import rigid
from rigid.animation import film
from rigid.animation.film import Film, Part
from rigid.solve.run import _recording_of

BOX = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.04, mass=0.3))
OBLATE = rigid.FreeBody(rigid.Body((1.0, 1.0, 1.6)))
PROLATE = rigid.FreeBody(rigid.Body((1.0, 1.0, 0.55)))
ASYMMETRIC = rigid.FreeBody(rigid.Body((1.0, 2.0, 2.5)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
TILTED = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
T = np.linspace(0.0, 2.0, 21)


def run_of(scene: Any, omega: Any = (0.9, 0.1, 1.3), attitude: Any = None, **given: Any) -> Any:
    return rigid.simulate(scene, omega, attitude, **({"t": T} | given))


def film_of(run: rigid.Run, body: int | None = None, **options: Any) -> Film:
    return film.film_of(_recording_of(run, body), **options)


def part(film: Film, kind: str, *, label: str = "", carried: bool = False, which: int = 0) -> Part:
    return [
        one for one in film.parts if (one.kind, one.label, one.carried) == (kind, label, carried)
    ][which]
