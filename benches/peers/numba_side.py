"""numba: what an expert writes. Fixed steps, blocks of bodies that stay in the first cache.

The step is written out as straight code with the table as literals; the bodies of a block are the
innermost loop, which LLVM makes wide; fast math allows fused multiply-adds. Blocks of 8 to 64, and
one loop for each stage with the slopes in memory, were tried: within 3 %, or slower.
"""

from __future__ import annotations

import itertools

import numpy as np
from timing import installed
from tops import Floats, Form, Scene, State, forms

numba = installed("numba")

Table = tuple[list[list[float]], list[float]]

BLOCK = 16

RK4: Table = ([[0.5], [0.0, 0.5], [0.0, 0.0, 1.0]], [1 / 6, 1 / 3, 1 / 3, 1 / 6])

# Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., section II.5.
# fmt: off
DOP853: Table = (
    [
        [0.05260015195876773],
        [0.0197250569845379, 0.0591751709536137],
        [0.02958758547680685, 0.0, 0.08876275643042054],
        [0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
        [0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
        [0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
        [0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328,
         -0.015319437748624402, 0.008273789163814023],
        [0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726,
         27.59209969944671, 20.154067550477894, -43.48988418106996],
        [0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843,
         21.230051448181193, 15.279233632882423, -33.28821096898486,
         -0.020331201708508627],
        [-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295,
         -8.149787010746927, -18.52006565999696, 22.739487099350505, 2.4936055526796523,
         -3.0467644718982196],
        [2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625,
         -17.9589318631188, 27.94888452941996, -2.8589982771350235, -8.87285693353063,
         12.360567175794303, 0.6433927460157636],
    ],
    [
        0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003,
        -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034,
        0.04471061572777259,
    ],
)
# fmt: on


def _sum(weights: list[float], d: int) -> str:
    return " + ".join(f"{w!r} * k{j}_{d}" for j, w in enumerate(weights) if w)


def written(table: Table, form: Form, constants: int) -> str:
    """Source of a function that moves all bodies by some steps."""
    matrix, weights = table
    moving, every = range(form.moving), range(form.moving + constants)
    step = [f"y{d} = y[{d * BLOCK} + i]" for d in every]
    for stage in range(len(weights)):
        at = [f"y{d}" for d in every]
        if stage:
            row = matrix[stage - 1]
            step += [f"x{d} = y{d} + h * ({_sum(row, d)})" for d in moving]
            at[: form.moving] = [f"x{d}" for d in moving]
        slopes = ", ".join(f"k{stage}_{d}" for d in moving)
        step.append(f"{slopes} = rates({', '.join(at)})")
    step += [f"y[{d * BLOCK} + i] = y{d} + h * ({_sum(weights, d)})" for d in moving]
    return "\n".join(
        [
            "def advance(states, h, steps):",
            f"    y = np.empty({len(every) * BLOCK})",
            f"    for first in range(0, states.shape[1], {BLOCK}):",
            f"        for c in range({len(every)}):",
            f"            for i in range({BLOCK}):",
            f"                y[c * {BLOCK} + i] = states[c, first + i]",
            "        for _ in range(steps):",
            f"            for i in range({BLOCK}):",
            *(f"                {line}" for line in step),
            f"        for c in range({form.moving}):",
            f"            for i in range({BLOCK}):",
            f"                states[c, first + i] = y[c * {BLOCK} + i]",
        ]
    )


class Numba:
    """One form, one table; the knob is the number of steps."""

    side, unit = "numba", "steps"

    def __init__(self, scene: Scene, form: Form, table: str, start: Floats) -> None:
        self.scheme, self.name = table, form.name
        self.form, self.t, self.start = form, scene.t, start
        source = written(TABLES[table], form, len(start) - form.moving)
        fast = {"fastmath": True, "error_model": "numpy"}
        names = {"np": np, "rates": numba.njit(inline="always", **fast)(form.rates)}
        exec(source, names)
        self.advance = numba.njit(**fast)(names["advance"])

    def take(self, count: int) -> None:
        self.begin = np.ascontiguousarray(self.start[:, :count])

    def prepare(self, steps: int) -> None:
        # Compiles it.
        self.advance(self.begin.copy(), self.t / steps, 1)

    def run(self, steps: int) -> None:
        self.states = self.begin.copy()
        self.advance(self.states, self.t / steps, steps)

    def state(self) -> State:
        return self.form.end(self.states, self.t)


TABLES = {"DOP853": DOP853, "RK4": RK4}


def sides(scene: Scene, omega: Floats, rotation: Floats) -> list[Numba]:
    if numba is None:
        return []
    return [
        Numba(scene, form, table, form.start(omega, rotation))
        for form, table in itertools.product(forms(scene), TABLES)
        if table == "DOP853" or form.name == "two rows"
    ]
