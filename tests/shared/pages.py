"""What the pages of the explorer hold, and what their functions say under Node."""

import base64
import json
import re
import shutil
import subprocess
import zlib
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid.animation.explorer import Explorer

__all__ = ["NODE", "content", "under_node", "unpacked"]

NODE = shutil.which("node")


def content(page: Path | Explorer) -> dict[str, Any]:
    """The map that a page holds."""
    text = page.read_text() if isinstance(page, Path) else page.page
    found = re.search(r'<script type="application/json" id="map">(.*?)</script>', text)
    assert found is not None
    held: dict[str, Any] = json.loads(found[1])
    return held


def unpacked(packed: dict[str, str]) -> NDArray[Any]:
    """An array of a page."""
    dtype = np.dtype(packed["type"])
    planes = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), dtype=np.uint8)
    mixed = np.ascontiguousarray(planes.reshape(dtype.itemsize, -1).T)
    return mixed.reshape(-1).view(dtype)


def under_node(function: str, *arguments: Any) -> Any:
    """What a function of the page says under Node."""
    folder = resources.files("rigid.animation").joinpath("page")
    names = ("vectors.js", "motion.js", "draw.js", "quantities.js")
    script = "".join(folder.joinpath(name).read_text() for name in names)
    script += "const given = JSON.parse(require('fs').readFileSync(0, 'utf8'));"
    script += f"console.log(JSON.stringify(({function})(...given)));"
    asked = json.dumps(
        [one if isinstance(one, dict) else np.asarray(one).tolist() for one in arguments]
    )
    assert NODE is not None
    done = subprocess.run(
        [NODE, "-e", script], input=asked, capture_output=True, check=True, text=True
    )
    return json.loads(done.stdout)
