"""heyoka: Taylor series of any order, compiled, eight bodies side by side.

As its documentation recommends for small systems: batch of the width of the registers, fast math,
no compact mode, one compiled integrator used again for all batches. The length of a step follows
from the order and the order from the tolerance, so each order is tried once. Batches of 4 and 16,
forced AVX-512 and the SLP vectoriser were tried and are not faster.
"""

from __future__ import annotations

import math

import numpy as np
from timing import installed, required, sized
from tops import Floats, Form, Scene, State, forms

hy = installed("heyoka")

ORDERS = sized(range(6, 22), (10,))
LANES = 8


def _system(form: Form) -> list[tuple[hy.expression, hy.expression]]:
    variables = hy.make_vars(*(f"y{i}" for i in range(form.moving)))
    known = [hy.par[i] for i in range(form.rates.__code__.co_argcount - form.moving)]
    return list(zip(variables, form.rates(*variables, *known), strict=True))


class Heyoka:
    """One form of the equations; the knob is the order."""

    side, scheme, unit = "heyoka", "Taylor, batch of 8", "order"

    def __init__(self, scene: Scene, form: Form, omega: Floats, rotation: Floats) -> None:
        self.name, self.form, self.t = form.name, form, scene.t
        self.start = form.start(omega, rotation)
        self.made: dict[tuple[int, bool], hy.taylor_adaptive_batch_dbl] = {}
        # Of a quaternion it is slower with fast math than without.
        self.fast_math = form.name != "quaternion"

    def knobs(self) -> list[int]:
        return list(ORDERS)

    def take(self, count: int) -> None:
        self.begin, moving = self.start[:, :count], self.form.moving
        batches = self.begin.reshape(-1, count // LANES, LANES).swapaxes(0, 1)
        self.states = [np.ascontiguousarray(b[:moving]) for b in batches]
        self.known = [np.ascontiguousarray(b[moving:]) for b in batches]

    def prepare(self, order: int) -> None:
        if order in self.made:
            return
        self.made[order] = hy.taylor_adaptive_batch(
            _system(self.form),
            self.states[0],
            pars=self.known[0],
            # A little above the tolerance from which on heyoka takes one order more.
            tol=math.exp(-2.0 * (order - 1)) * 1.0001,
            high_accuracy=False,
            fast_math=self.fast_math,
        )
        made = self.made[order].order
        required(made == order, f"order of heyoka = {made}: must be {order}")

    def run(self, order: int) -> None:
        integrator, t, ends = self.made[order], self.t, []
        state, known = integrator.state, integrator.pars
        for begin, numbers in zip(self.states, self.known, strict=True):
            state[:] = begin
            known[:] = numbers
            integrator.set_time(0.0)
            integrator.propagate_until(t)
            ends.append(state.copy())
        self.ends = ends

    def state(self) -> State:
        moved = np.concatenate(self.ends, axis=1)
        return self.form.end(np.concatenate([moved, self.begin[self.form.moving :]]), self.t)


def reference(scene: Scene, omega: Floats, rotation: Floats) -> State:
    """The same bodies one by one in 80-bit numbers with a tolerance of 1e-19, order 23."""
    wide = np.longdouble
    form = forms(scene, lambda x: hy.expression(wide(x)))[0]
    begin = form.start(omega, rotation).astype(wide)
    integrator = hy.taylor_adaptive(
        _system(form), begin[:, 0], tol=wide(1e-19), fp_type=wide, high_accuracy=True
    )
    ends = []
    for start in begin.T:
        integrator.state[:] = start
        integrator.time = wide(0)
        integrator.propagate_until(wide(scene.t))
        ends.append(integrator.state.copy())
    return form.end(np.array(ends).T, scene.t)


def sides(scene: Scene, omega: Floats, rotation: Floats) -> list[Heyoka]:
    if hy is None:
        return []
    return [Heyoka(scene, form, omega, rotation) for form in forms(scene)]
