"""Where the crates of the core come from, and under which licences: the rules of ``deny.toml``.

``cargo deny check`` reads the same file and also asks a database of advisories; it takes minutes to
build, so tests check here what needs no database.
"""

from __future__ import annotations

import json
import re
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[3]
RULES = tomllib.loads((ROOT / "deny.toml").read_text())
REGISTRY = "registry+https://github.com/rust-lang/crates.io-index"


@pytest.fixture(scope="module")
def resolved() -> dict[str, Any]:
    """What cargo resolves for a build on this machine, tests included."""
    host = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    triple = re.search(r"^host: (.*)$", host, re.MULTILINE)
    assert triple is not None
    command = ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"]
    command += ["--filter-platform", triple[1]]
    metadata = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return dict(json.loads(metadata))


def is_allowed(expression: str) -> bool:
    """Whether an SPDX expression is met by the allowed licences."""
    inner = re.search(r"\(([^()]*)\)", expression)
    if inner is not None:
        met = RULES["licenses"]["allow"][0] if is_allowed(inner[1]) else "none"
        return is_allowed(expression.replace(inner[0], met))
    return any(
        all(licence in RULES["licenses"]["allow"] for licence in choice.split(" AND "))
        for choice in re.split(" OR |/", expression)
    )


def test_licences_are_read_as_expressions() -> None:
    assert is_allowed("(MIT OR GPL-3.0) AND Unicode-3.0")
    assert is_allowed("GPL-3.0/MIT")
    assert not is_allowed("GPL-3.0-only")
    assert not is_allowed("MIT AND GPL-3.0-only")


def test_every_crate_has_an_allowed_licence(resolved: dict[str, Any]) -> None:
    refused = {
        package["name"]: package["license"]
        for package in resolved["packages"]
        if not is_allowed(package["license"] or "none")
    }
    assert not refused
    assert len(resolved["packages"]) > 20


def test_every_locked_crate_comes_from_the_registry_with_its_checksum() -> None:
    locked = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    strange = [
        package["name"]
        for package in locked
        if package["name"] != "rigid"
        and (package.get("source") != REGISTRY or len(package.get("checksum", "")) != 64)
    ]
    assert not strange


def test_banned_crates_stand_below_their_wrappers_only(resolved: dict[str, Any]) -> None:
    names = {package["id"]: package["name"] for package in resolved["packages"]}
    for rule in RULES["bans"]["deny"]:
        users = {
            names[node["id"]]
            for node in resolved["resolve"]["nodes"]
            for dependency in node["deps"]
            if names[dependency["pkg"]] == rule["crate"]
        }
        assert users <= set(rule.get("wrappers", [])), rule["crate"]
