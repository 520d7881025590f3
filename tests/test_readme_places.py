"""The files and folders that README names when it tells how the parts lie are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
PARTS = (TOP / "README.md").read_text(encoding="utf-8").split("## How the parts lie")[1].split("\n## ")[0]
NAMED = sorted(set(re.findall(r"`([\w/]+(?:\.py|/))`", PARTS)))


@pytest.mark.parametrize("name", NAMED)
def test_what_is_named_is_there(name: str) -> None:
    folders = ("framework", "elements", "models", "tests", "models/linkage")
    assert any((TOP / folder / name).exists() for folder in (".", *folders)), f"README names {name}"


@pytest.mark.parametrize("folder", ["framework", "models/linkage"])
def test_every_folder_is_named(folder: str) -> None:
    """A reader of a new folder finds there what it is for."""
    there = {path.parent.name for path in (TOP / folder).glob("*/__init__.py")}
    assert not there - {name.rstrip("/").rpartition("/")[2] for name in NAMED}


def test_places_are_seen() -> None:
    assert {"framework/protocol.py", "kinematics/", "solvers/method.py"} <= set(NAMED)
