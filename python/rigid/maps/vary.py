"""Parameters of bodies that are drawn at random, for each body of a map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import brief, of_known, positive_int
from .._checks.arrays import Floats
from .._checks.moments import can_move
from ..model.body import Body
from ..model.noise import Noise
from ..model.parameters import (
    AT_REST,
    OF_RUN,
    OF_START,
    PARAMETERS,
    Parameter,
    moments_of,
    numbers_of,
    scene_of,
)
from ..model.scene import Scene, check_scene
from ..model.seed import seed_from
from ..model.start import Start
from .axes import Axis, check_meanings, in_order

Numbers = NDArray[np.uint64]

MOST_DRAWS = 1000
"""Most draws of a body. Where one draw in a hundred is possible, one body of 20 000 gets none."""


@dataclass(frozen=True, slots=True)
class Varied:
    """A parameter that each body has at random, about its nominal value or in a range."""

    name: str
    noise: Noise

    @property
    def parameter(self) -> Parameter:
        """The row of the parameter."""
        return PARAMETERS[self.name]

    def __str__(self) -> str:
        return f"{self.name} by {self.noise.describe()}"

    def about(self, nominal: Floats, deviates: Floats) -> Floats:
        """Values from nominal values and deviates of unit size."""
        if self.noise.high is not None:
            low, high = float(self.noise.size), self.noise.high  # type: ignore[arg-type]
            values = 0.5 * (low + high) + 0.5 * (high - low) * deviates
            return np.broadcast_to(np.clip(values, low, high), nominal.shape)
        change = np.asarray(self.noise.size) * deviates
        return nominal * (1.0 + change) if self.noise.relative else nominal + change


def make_varied(vary: object) -> tuple[Varied, ...]:
    """The varied parameters of an argument ``vary``, a dict of names and distributions.

    They are in the order of their names, whatever the order in the dict: a parameter is drawn by
    its place, and a file may keep the entries of a dict in another order.

    Raises
    ------
    TypeError, ValueError
        For what is no such dict, for a name that no body has, and for another distribution than
        normal or uniform deviations of one size.
    """
    if not isinstance(vary, Mapping):
        raise TypeError(f"vary = {brief(vary)}: must be a dict of names and distributions")
    known = [name for name, row in PARAMETERS.items() if _is_of_body(row)]
    for name, noise in vary.items():
        if name not in known:
            row = PARAMETERS.get(name)
            reason = (
                f"is no parameter{of_known(name, known)}"
                if row is None
                else "belongs to the start; give the start a noise"
                if row.place in OF_START
                else "cannot vary from body to body; use com1, com2, com3"
                if row.place == "com angles"
                else "cannot vary from body to body"
            )
            raise ValueError(f"vary: {name!r} {reason}")
        is_noise = isinstance(noise, Noise) and noise.kind in ("normal", "uniform")
        if not is_noise or noise.cov is not None or isinstance(noise.size, tuple):
            given = noise.describe() if isinstance(noise, Noise) else brief(noise)
            raise TypeError(
                f"vary[{name!r}] = {given}: must be rigid.normal(size), rigid.uniform(size), with "
                "one size, or rigid.uniform(low, high)"
            )
    return tuple(Varied(name, noise) for name, noise in sorted(vary.items()))


def _is_of_body(row: Parameter) -> bool:
    """Whether a parameter is a number of a body and of the forces on it, not of its start."""
    has_values = row.number is None or row.value is not None
    return has_values and row.place not in (*OF_START, OF_RUN)


def check_varied(scene: Scene, start: Start, vary: Sequence[Varied], axes: Sequence[Axis]) -> None:
    """Raise ValueError, with the reason, if a varied parameter has no meaning here."""
    check_meanings("vary", vary, scene, start, beside=axes)
    nominal = {axis.name for axis in axes}
    for one in vary:
        if one.noise.relative and one.name not in nominal:
            numbers = numbers_of(scene, start, {one.parameter.place}, 1)
            if not np.any(one.parameter.get(numbers)):
                raise ValueError(
                    f"vary: {one.name!r} is 0, and a share of 0 varies nothing; give an absolute "
                    "size, or rigid.uniform(low, high)"
                )


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Which bodies of a map are drawn, each a pure function of seed, pixel and sample.

    Attributes
    ----------
    vary : tuple of Varied
    seed : int
    pixels, samples : ndarray of uint64, shape (n,)
        Numbers of pixel and sample of each body.
    """

    vary: tuple[Varied, ...]
    seed: int
    pixels: Numbers
    samples: Numbers

    def put(
        self, numbers: Mapping[str, Floats], physical: bool
    ) -> tuple[dict[str, Floats], NDArray[np.int64]]:
        """Write the drawn parameters into the nominal numbers of the bodies.

        A draw that no body can have is repeated. What has no nominal body stays.

        Returns the values of the parameters, of one for all axes the value of axis 1, and the
        number of draws of each body.
        """
        nominal = {one.name: one.parameter.get(numbers) for one in self.vary}
        count = len(self.pixels)
        draws = np.zeros(count, dtype=np.int64)
        waiting = np.flatnonzero(_possible(numbers, np.arange(count), physical))
        waiting = waiting if self.vary else waiting[:0]
        values = {name: array.copy() for name, array in nominal.items()}
        first = 0
        while len(waiting):
            if first == MOST_DRAWS * len(self.vary):
                raise ValueError(
                    f"vary: none of {MOST_DRAWS} draws gave a body that can exist, in pixel "
                    f"{self.pixels[waiting[0]]}, sample {self.samples[waiting[0]]}; take a smaller "
                    "size"
                )
            trial = {name: every[waiting] for name, every in numbers.items()}
            good = np.ones(len(waiting), dtype=np.bool_)
            for place in in_order(self.vary):
                one = self.vary[place]
                deviates = _core.deviates(
                    one.noise.kind,
                    self.seed,
                    first + place,
                    self.pixels[waiting],
                    self.samples[waiting],
                )
                value = one.about(nominal[one.name][..., waiting], deviates)
                one.parameter.put(trial, value)
                values[one.name][..., waiting] = value
                fits = np.isfinite(value) & ~one.parameter.rejects(value)
                good &= fits.reshape(-1, len(waiting)).all(axis=0)
            good &= _possible(trial, np.arange(len(waiting)), physical)
            for name, every in numbers.items():
                every[waiting[good]] = trial[name][good]
            draws[waiting] += 1
            waiting = waiting[~good]
            first += len(self.vary)
        return {name: np.atleast_2d(array)[0] for name, array in values.items()}, draws


def _possible(numbers: Mapping[str, Floats], some: Any, physical: bool) -> NDArray[np.bool_]:
    """Whether bodies can have the moments that follow from their numbers."""
    return can_move(moments_of({place: every[some] for place, every in numbers.items()}), physical)


def sample_bodies(
    scene: Scene | Body,
    vary: Mapping[str, Noise],
    count: int,
    rng: int | np.random.Generator | np.random.SeedSequence | None = None,
) -> Scene:
    """Bodies with random parameters, for :func:`rigid.simulate` and other calls of many bodies.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body, with the nominal values.
    vary : dict of str to Noise
        As in :func:`stability_map`: names of parameters, and their deviations by :func:`normal` or
        :func:`uniform`. A draw that no body can have is repeated.
    count : int
        Number of bodies.
    rng : int, Generator or SeedSequence, optional
        Seed. A map of one pixel with this seed has the same bodies.

    Returns
    -------
    FreeBody or HeavyTop
        A scene of shape ``(count,)``.

    Raises
    ------
    TypeError, ValueError
        As :func:`stability_map` for its argument ``vary``.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> vary = {"I1": rigid.normal(0.05, relative=True)}
    >>> boxes = rigid.sample_bodies(rigid.Body((1.0, 2.0, 2.5)), vary, 1000, rng=1)
    >>> bool(abs(np.std(boxes.body.moments[:, 0]) - 0.05) < 0.005)
    True
    >>> rigid.simulate(boxes, [0.0, 1.0, 0.1], t=[10.0]).omega.shape
    (1000, 1, 3)
    """
    scene, varied = check_scene(scene), make_varied(vary)
    check_varied(scene, AT_REST, varied, ())
    number = positive_int("count", count)
    places = {"moments", *(one.parameter.place for one in varied)}
    numbers = numbers_of(scene, AT_REST, places, number)
    samples = np.arange(number, dtype=np.uint64)
    draws = Draws(varied, seed_from(rng), np.zeros_like(samples), samples)
    draws.put(numbers, scene.body.physical)
    return scene_of(scene, numbers, moments_of(numbers))
