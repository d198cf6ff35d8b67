"""A box thrown about each of its axes, with and without noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, positive_int
from .._checks.arrays import finite_array
from ..model.body import Body
from ..model.scene import FreeBody
from ..solve.simulate import simulate
from .stability import gammas, local_stability

Floats = NDArray[np.float64]

NOISE = 0.1
"""Noise of the lab report (rad/s): uniform between zero and this value for every component."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ThrowExperiment:
    """Six runs: about the axes 1, 2, 3 without noise, then with noise.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times (s).
    omega : ndarray, shape (6, m, 3)
        Angular velocity in the body (rad/s).
    dots_t : ndarray, shape (k,)
        Times of the indicator: whole seconds (s).
    dots : ndarray, shape (6, k)
        :func:`rigid.free.local_stability` at these times (1/s): a local indicator, not stability.
    noise : ndarray, shape (3, 3)
        Angular velocities added to the starts of the last three runs (rad/s).
    """

    t: Floats
    omega: Floats
    dots_t: Floats
    dots: Floats
    noise: Floats


def throw_experiment(
    body: Body,
    noise: ArrayLike | np.random.Generator,
    *,
    t_end: float = 30.0,
    samples: int = 601,
) -> ThrowExperiment:
    """Closed-form motion of a body thrown at 1 rad/s about each axis, with and without noise.

    Buller and Wernstål 2011, appendix and Fig. 3. The report does not give the seed of its noise
    (S-18), so pass the noise as an argument.

    Parameters
    ----------
    body : Body
        The body; the report uses ``Body.box(0.01, 0.08, 0.25)``.
    noise : array_like, shape (3,) or (3, 3), or numpy.random.Generator
        Angular velocity (rad/s) added to every start, or one for each of the axes 1, 2, 3. A
        generator draws nine numbers uniform between 0 and 0.1.
    t_end : float
        Length of a run (s).
    samples : int
        Number of times, equally spaced from 0 on.

    Returns
    -------
    ThrowExperiment

    Raises
    ------
    TypeError
        If ``body`` is no body.
    ValueError
        If the noise has another shape, or a value is not finite or out of range.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> box = rigid.Body.box(0.01, 0.08, 0.25)
    >>> thrown = rigid.free.throw_experiment(box, [0.05, 0.05, 0.05])
    >>> np.round(thrown.omega[4, -1], 6)
    array([ 0.06814 , -1.04875 ,  0.071071])
    """
    end = finite_float("t_end", t_end, positive=True)
    t = np.linspace(0.0, end, positive_int("samples", samples, minimum=2))
    if isinstance(noise, np.random.Generator):
        added = NOISE * noise.random((3, 3))
    else:
        added = finite_array("noise", noise)
        if added.shape not in ((3,), (3, 3)):
            raise ValueError(f"noise: expected shape (3,) or (3, 3), got {added.shape}")
        added = np.broadcast_to(added, (3, 3)).copy()
    starts = np.concatenate([np.eye(3), np.eye(3) + added])
    scene = FreeBody(body)
    seconds = np.arange(0.0, np.floor(end) + 1.0)
    omega, dotted = (
        simulate(scene, starts, t=times, method="exact", record="rates").omega
        for times in (t, seconds)
    )
    return ThrowExperiment(
        t=t,
        omega=omega,
        dots_t=seconds,
        dots=local_stability(gammas(body), dotted),
        noise=added,
    )
