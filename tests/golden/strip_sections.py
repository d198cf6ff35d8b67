"""Copies reference sections, stripped to what the tests read: `python strip_sections.py FOLDER`.

Each file of the folder is a scene as README.md describes `sections.json`; the output is that file,
here. Numbers are rounded to doubles.
"""

import json
import sys
from pathlib import Path
from typing import Any

SCENE = ("name", "moments", "weight", "omega", "gamma", "T", "section", "value", "direction")


def stripped(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with nothing but what the tests read."""
    points = [
        {
            "t": float(point["t"]),
            "omega": [float(x) for x in point["omega"]],
            "gamma": [float(x) for x in point["gamma"]],
            "direction": point["direction"],
            "slope": point["slope"],
        }
        for point in scene["points"]
    ]
    return {**{key: scene[key] for key in SCENE}, "points": points}


if __name__ == "__main__":
    scenes = [json.loads(name.read_text()) for name in sorted(Path(sys.argv[1]).glob("*.json"))]
    lines = ",\n".join(json.dumps(stripped(scene)) for scene in scenes if "points" in scene)
    (Path(__file__).parent / "sections.json").write_text(f'{{"scenes": [\n{lines}\n]}}\n')
