"""Random valid and invalid scenes, a thousand times as many as in the gate takes minutes.

    python tests/long/any_scene.py

By default 2000 of each kind: 46 000 valid scenes over the methods, 20 000 invalid calls.
"""

import os
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parent.parent / "python" / "contract" / "test_any_scene.py"

if __name__ == "__main__":
    examples = os.environ.get("RIGID_EXAMPLES", "2000")
    environment = os.environ | {"RIGID_EXAMPLES": examples}
    command = [sys.executable, "-m", "pytest", "--dist", "worksteal", str(TESTS)]
    raise SystemExit(subprocess.run(command, env=environment, check=False).returncode)
