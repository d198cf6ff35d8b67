"""Runs the Python lines of the README with the installed package, in a folder of their own.

The package, whose description is the README, names no placeholder such as OWNER.
"""

import doctest
import os
import re
import sys
import tempfile
from importlib.metadata import metadata
from pathlib import Path

import rigid

described = metadata(rigid.build_info()["distribution"]).as_string()
placeholders = re.findall(r".*\b(?:OWNER|TODO|FIXME)\b.*", described)
if placeholders:
    sys.exit(f"the metadata of the package has placeholders: {placeholders}")
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
