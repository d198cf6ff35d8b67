"""Copies reference trajectories, stripped to what the tests read: `python strip.py FULL.json ... `.

Each input is a family of scenes as described in README.md; the output has the same name, here.
"""

import json
import sys
from pathlib import Path
from typing import Any

SCENE = ("id", "inertia", "mass", "gravity", "com", "omega0", "q0")
DRIVEN = ("torque_body", "damping")
SAMPLE = ("t", "omega", "q", "energy", "L_space", "kappa_att", "kappa_omega")


def is_driven(scene: dict[str, Any]) -> bool:
    """Under torque or damping."""
    return any(scene["torque_body"]) or bool(scene["damping"])


def stripped(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with nothing but what the tests read."""
    samples = [{key: sample[key] for key in SAMPLE} for sample in scene["samples"]]
    driven = {key: scene[key] for key in DRIVEN} if is_driven(scene) else {}
    return {**{key: scene[key] for key in SCENE}, **driven, "samples": samples}


def dump(scenes: list[dict[str, Any]]) -> str:
    """JSON with one sample a line."""
    parts = []
    for scene in scenes:
        head = json.dumps({key: scene[key] for key in scene if key != "samples"})[:-1]
        samples = ",\n  ".join(json.dumps(sample) for sample in scene["samples"])
        parts.append(f'{head}, "samples": [\n  {samples}]}}')
    return '{"scenes": [\n' + ",\n".join(parts) + "\n]}\n"


if __name__ == "__main__":
    here = Path(__file__).parent
    for name in map(Path, sys.argv[1:]):
        scenes = json.loads(name.read_text())["scenes"]
        (here / name.name).write_text(dump([stripped(scene) for scene in scenes]))
