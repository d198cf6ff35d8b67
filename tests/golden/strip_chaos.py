"""Copies reference tangents, stripped to what the tests read: `python strip_chaos.py FOLDER`.

Each file of the folder is a scene as README.md describes `chaos.json`; the output is that file,
here. Numbers are rounded to doubles.
"""

import json
import sys
from pathlib import Path
from typing import Any

SCENE = ("name", "family", "moments", "weight", "damping", "omega", "gamma", "rate_scale")
GROWTH = ("log_growth", "megno", "mean_megno", "sali", "gali", "log_qr")


def rounded(value: Any) -> Any:
    """Decimal strings as doubles."""
    if isinstance(value, list):
        return [rounded(part) for part in value]
    return float(value) if isinstance(value, str) else value


def stripped(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with nothing but what the tests read."""
    at = [
        {
            "t": rounded(state["t"]),
            "matrix": rounded(state["attitude"]["matrix"]),
            "attitude": {key: rounded(state["attitude"][key]) for key in GROWTH},
            "rates": {key: rounded(state["reduced"][key]) for key in GROWTH},
        }
        for state in scene["at"]
    ]
    starts = [[*start["domega"], *start["xi"]] for start in scene["tangents"]]
    return {**{key: scene[key] for key in SCENE}, "tangents": rounded(starts), "at": at}


if __name__ == "__main__":
    scenes = [json.loads(name.read_text()) for name in sorted(Path(sys.argv[1]).glob("*.json"))]
    lines = ",\n".join(json.dumps(stripped(scene)) for scene in scenes if "tangents" in scene)
    (Path(__file__).parent / "chaos.json").write_text(f'{{"scenes": [\n{lines}\n]}}\n')
