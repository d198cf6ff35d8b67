"""rigid: the public call, with each of its schemes by steps, or with an accuracy asked for."""

from __future__ import annotations

from typing import Any

from tops import Floats, Scene, State, matrices

import rigid


def _scene(scene: Scene) -> rigid.HeavyTop:
    return rigid.HeavyTop(rigid.Body(scene.moments), mgl=scene.mgl, com=scene.com)


class Rigid:
    """The knob is the number of steps; with an accuracy, that."""

    side = "rigid"

    def __init__(self, scene: Scene, scheme: str, omega: Floats) -> None:
        self.scheme, self.name, self.unit = scheme, "", "steps"
        self.start, self.t = omega, scene.t
        self.top, self.attitude = _scene(scene), scene.attitude()

    def take(self, count: int) -> None:
        self.omega = self.start[:count]

    def prepare(self, steps: float) -> None:
        pass

    def how(self, steps: float) -> dict[str, Any]:
        # Not one step more by rounding.
        return {"method": self.scheme, "step": self.t / steps * (1 + 1e-12), "check": False}

    def run(self, steps: float) -> None:
        self.done = rigid.simulate(
            self.top, self.omega, self.attitude, t=[self.t], threads=1, **self.how(steps)
        )

    @property
    def chosen(self) -> str:
        return self.done.plan.method

    @property
    def nanoseconds(self) -> int:
        """Processor time of the core."""
        return self.done.nanoseconds

    def state(self) -> State:
        assert self.done.attitude is not None
        return self.done.omega[:, -1], matrices(self.done.attitude[:, -1])


class Accuracy(Rigid):
    """Scheme and steps are chosen by rigid, and every body is run again, until it is below."""

    def __init__(self, scene: Scene, omega: Floats) -> None:
        super().__init__(scene, "accuracy=", omega)
        self.unit = "accuracy"

    def how(self, accuracy: float) -> dict[str, Any]:
        return {"accuracy": accuracy}


class Closed(Rigid):
    """The closed form."""

    def __init__(self, scene: Scene, omega: Floats) -> None:
        super().__init__(scene, "exact", omega)
        self.unit = ""

    def how(self, _: float) -> dict[str, Any]:
        return {"method": "exact"}


def sides(scene: Scene, omega: Floats) -> list[Rigid]:
    return [Rigid(scene, method.name, omega) for method in rigid.methods()]
