"""Runs the Python lines of the README with the installed package, in a folder of their own."""

import doctest
import os
import re
import sys
import tempfile
from pathlib import Path

import rigid

readme = Path(sys.argv[1]).read_text(encoding="utf-8")
lines = "\n".join(re.findall(r"^```python\n(.*?)^```", readme, re.MULTILINE | re.DOTALL))
os.environ["MPLBACKEND"] = "Agg"
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    test = doctest.DocTestParser().get_doctest(lines, {}, "README", sys.argv[1], 0)
    done = doctest.DocTestRunner().run(test)
    os.chdir("/")
print(f"README: {done.attempted} lines of Python, {done.failed} failed, by {rigid.__file__}")
sys.exit(done.failed > 0 or done.attempted == 0)
