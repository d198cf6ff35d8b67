"""The folder of a running map as this version writes it, which all later versions must read.

    python tests/golden/make_store.py NAME

writes ``tests/golden/stores/NAME`` and, beside it, what must be read: once for each release, and
never again. Three parts have written it, and the end of one log is torn.
"""

from __future__ import annotations

import json
import os
import platform
import socket
import sys
from hashlib import blake2b
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))

from rigid.store.drive import own_build
from rigid.store.resume import Part
from rigid.store.running import Folder
from stores import go_on

STORES = Path(__file__).with_name("stores")


def main(name: str) -> None:
    """Write the folder, and what must be read from it."""
    path = STORES / name
    if path.exists():
        raise SystemExit(f"{path} is kept as it is")
    # Nothing of the machine that makes it, but its instruction set.
    socket.gethostname = lambda: "golden"
    platform.platform = lambda *_arguments, **_options: "Linux"
    os.getpid = lambda: 1
    for number in (1, 2, 3):
        go_on(path, part=Part(number, 3))
    torn = min((path / "logs").iterdir())
    content = torn.read_bytes()
    torn.write_bytes(content[: content.rindex(b"end.json") + 100])
    folder = Folder(path)
    facts = {
        "version": own_build()[0],
        "key": folder.head.key.hex(),
        "units": int(folder.table.known.sum()),
        "rows": blake2b(folder.table.rows.tobytes(), digest_size=16).hexdigest(),
    }
    (STORES / f"{name}.json").write_text(json.dumps(facts, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
