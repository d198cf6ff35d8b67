"""A hundred thousand bodies go forth and back: where they end must be where they began.

    python tests/long/there_and_back.py [--bodies 100000] [--seed 1]

Fails if a body is off by more than the errors that its two runs state, the first one as much
magnified as the way back magnifies a change of its start.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

import rigid
from error_survey import random_scene
from physics import Floats, present, rotation_angle
from rigid.model.scene import Scene

#: Starts of each scene, and the longest time in turns of the nominal one.
STARTS, TURNS = 500, 20.0


def shares(scene: Scene, omega: Floats, attitude: Floats, t: float) -> tuple[Floats, Floats]:
    """How far off the bodies return, and that as a share of what is stated."""
    forth = rigid.simulate(scene, omega, attitude, t=[t], method="exact")
    rates, turned = forth.omega[:, 0], present(forth.attitude)[:, 0]
    back = rigid.simulate(scene, rates, turned, t=[-t], method="exact")
    growth = rigid.condition(scene, rates, turned, t=[-t])[:, 0]
    fastest = np.linalg.norm(omega, axis=-1)
    off = np.linalg.norm(back.omega[:, 0] - omega, axis=-1) / fastest
    off = np.maximum(off, rotation_angle(present(back.attitude)[:, 0], attitude))
    return off, off / (forth.error * growth + back.error)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    offs: list[Floats] = []
    of_stated: list[Floats] = []
    while len(offs) * STARTS < chosen.bodies:
        scene, omega, attitude = random_scene(rng)
        if scene.directions and scene.body.symmetry_axis is None:
            continue  # no closed form
        starts = omega * (1.0 + 0.3 * rng.normal(size=(STARTS, 3)))
        t = rng.uniform(0.0, 2.0 * np.pi * TURNS) / float(np.linalg.norm(omega))
        attitudes = np.broadcast_to(attitude, (STARTS, 4)) / np.linalg.norm(attitude)
        off, share = shares(scene, starts, attitudes.copy(), t)
        offs.append(off)
        of_stated.append(share)
    off, share = np.concatenate(offs), np.concatenate(of_stated)
    beyond = int((share > 1.0).sum())
    print(f"{len(off)} bodies, off by {off.max():.2e} at most, median {np.median(off):.1e}")
    print(f"of what is stated: {share.max():.2f} at most; beyond it {beyond}")
    return int(beyond > 0)


if __name__ == "__main__":
    sys.exit(main())
