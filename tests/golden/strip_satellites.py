"""Copies reference satellites or flybys to what the tests read.

    python strip_satellites.py FOLDER satellites.json

Each file of the folder is a scene as README.md describes `satellites.json`. Numbers are rounded to
doubles.
"""

import json
import sys
from pathlib import Path

from strip_chaos import rounded

SCENE = ("moments", "e", "true_anomaly", "rotor", "omega", "attitude")
STATE = ("t", "omega", "attitude", "position", "tangent")

if __name__ == "__main__":
    lines = []
    for name in sorted(Path(sys.argv[1]).glob("*.json")):
        scene = json.loads(name.read_text())
        own = {key: rounded(scene[key]) for key in SCENE}
        at = [{key: rounded(state[key]) for key in STATE} for state in scene["at"]]
        lines.append(json.dumps({"name": scene["name"], **own, "at": at}))
    Path(sys.argv[2]).write_text("[\n" + ",\n".join(lines) + "\n]\n")
