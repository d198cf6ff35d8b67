"""Checks a checkout that is released, and makes its README one that PyPI can show.

    python .ci/release.py REPOSITORY_URL GIT_REF

The URL must be that of ``[project.urls]``, and a tag that of the version. PyPI shows the README
without the repository, so its relative links become those of the tagged files.
"""

import re
import sys
import tomllib
from pathlib import Path

url, ref = sys.argv[1:]
urls = tomllib.loads(Path("pyproject.toml").read_text())["project"].get("urls", {})
version = tomllib.loads(Path("Cargo.toml").read_text())["package"]["version"]
if urls.get("Repository") != url:
    sys.exit(f"[project.urls] Repository = {urls.get('Repository')!r}: must be {url!r}")
if ref.startswith("refs/tags/") and ref != f"refs/tags/v{version}":
    sys.exit(f"tag {ref!r}: must be v{version}, the version of Cargo.toml")
readme = Path("README.md")
text = readme.read_text(encoding="utf-8")
text, pictures = re.subn(r"!\[([^]]*)\]\((?!http)", rf"![\1]({url}/raw/v{version}/", text)
text, links = re.subn(r"(?<!!)\[([^]]*)\]\((?!http|#)", rf"[\1]({url}/blob/v{version}/", text)
readme.write_text(text, encoding="utf-8")
print(f"version {version}; README: {pictures} pictures and {links} links are absolute")
